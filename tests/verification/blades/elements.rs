//! B-01 to B-09: elements whose section and natural strain vary along their length.

use crate::blades::blade::{description, errors, reference, solve};
use crate::static_newton::assert_order;
use foldwing::beam::element::ElementKind::{Constant, Linear};
use foldwing::beam::law::{NaturalStrain, SectionLaw};
use foldwing::beam::profile::Profile;
use foldwing::beam::section::{Material, Outline, Section, Solid};
use foldwing::load::RootMotion;
use foldwing::multibody::dynamics::{Damping, Environment, residual};
use foldwing::multibody::energy::elastic;
use foldwing::multibody::factor::{FreedomTangent, Weights, factorize};
use foldwing::multibody::kinematics::Motion;
use foldwing::multibody::model::BodyDescription;
use foldwing::multibody::{Model, Workspace};
use nalgebra::{DMatrix, Matrix4, Vector3};

const LENGTH_M: f64 = 1.2;

/// Section with a full stiffness matrix.
fn coupled(stiffness: Matrix4<f64>) -> Section {
    Section {
        shear: None,
        stiffness,
        mass_kg_m: 1.0,
        first_moment_kg: [0.0; 2],
        second_moment_kg_m: [1e-3, 0.0, 1e-3],
        half_width_m: 0.1,
        half_height_m: 0.05,
    }
}

#[rustfmt::skip]
fn inner_stiffness() -> Matrix4<f64> {
    Matrix4::new(
        90.0, 2.0, -1.5, 3.0,
        2.0, 1.6, 0.4, -0.2,
        -1.5, 0.4, 1.3, 0.3,
        3.0, -0.2, 0.3, 2.8,
    )
}

#[rustfmt::skip]
fn outer_stiffness() -> Matrix4<f64> {
    Matrix4::new(
        40.0, -1.0, 0.5, 1.0,
        -1.0, 0.7, -0.1, 0.1,
        0.5, -0.1, 0.5, 0.05,
        1.0, 0.1, 0.05, 0.9,
    )
}

const TWIST: [f64; 4] = [0.7, -1.1, 0.9, 0.8];
const CURVATURE_Y: [f64; 3] = [-0.4, 0.9, -1.2];
const CURVATURE_Z: [f64; 3] = [0.5, -0.6, 1.1];

/// Fully coupled stiffness that falls linearly to less than half; twist and curvatures are polynomials.
fn blade() -> BodyDescription {
    let section = SectionLaw::between(coupled(inner_stiffness()), coupled(outer_stiffness()), LENGTH_M);
    let natural = NaturalStrain([
        Profile::constant(0.0),
        Profile::Polynomial(TWIST.to_vec()),
        Profile::Polynomial(CURVATURE_Y.to_vec()),
        Profile::Polynomial(CURVATURE_Z.to_vec()),
    ]);
    description(LENGTH_M, section, natural)
}

fn stiffness(s: f64) -> Matrix4<f64> {
    inner_stiffness() + (outer_stiffness() - inner_stiffness()) * (s / LENGTH_M)
}

fn curvature(s: f64) -> [f64; 3] {
    let power = |c: &[f64]| c.iter().enumerate().map(|(i, c)| c * s.powi(i as i32)).sum();
    [power(&TWIST), power(&CURVATURE_Y), power(&CURVATURE_Z)]
}

/// B-01. Varying section and natural curvature: tip position, rotation, root moment and, at the boundaries of pairs, the recovered strain
/// converge with order 4 for pairs and order 2 for constant elements. All couplings, strains of order one.
#[test]
fn b01_order_of_convergence() {
    let force = Vector3::new(0.4, -0.5, 0.9);
    let exact = reference(LENGTH_M, &stiffness, &curvature, &force, 4);
    for (kind, meshes, least, most) in [(Linear, [4, 8, 16], 3.7, 4.4), (Constant, [16, 32, 64], 1.8, 2.2)] {
        let found = meshes.map(|n| errors(LENGTH_M, &solve(&blade(), (kind, n), &force, 4), &exact));
        for (i, what) in ["tip", "rotation", "root moment", "strain"].iter().enumerate() {
            assert_order(&format!("B-01 {kind:?} {what}"), &found.map(|errors| errors[i]), least, most);
        }
    }
}

/// B-02. Without loads the blade takes its natural shape, with order 4 for pairs and 2 for constant elements, and has no strain.
#[test]
fn b02_natural_shape() {
    let exact = reference(LENGTH_M, &stiffness, &curvature, &Vector3::zeros(), 4);
    for (kind, meshes, least, most) in [(Linear, [4, 8, 16], 3.7, 4.4), (Constant, [16, 32, 64], 1.8, 2.2)] {
        let found = meshes.map(|n| solve(&blade(), (kind, n), &Vector3::zeros(), 4));
        let at = |i: usize| found.each_ref().map(|solution| errors(LENGTH_M, solution, &exact)[i]);
        assert_order(&format!("B-02 {kind:?} tip"), &at(0), least, most);
        assert_order(&format!("B-02 {kind:?} rotation"), &at(1), least, most);
        let strain = found[0].measures.iter().map(|measures| measures.amax()).fold(0.0, f64::max);
        assert!(strain < 1e-12, "{kind:?}: strain {strain:.1e} without loads");
    }
}

fn motion_residual(model: &Model, work: &mut Workspace, q: &[f64], a: &[f64]) -> Vec<f64> {
    let zero = vec![0.0; q.len()];
    let mut value = zero.clone();
    let environment = Environment { root: &RootMotion::default(), damping: &[Damping::default()], stations: &[] };
    residual(model, work, Motion { q, v: &zero, a }, environment, &mut value);
    value
}

fn wave(count: usize, scale: f64, pitch: f64) -> Vec<f64> {
    (0..count).map(|i| scale * (pitch * i as f64 + 0.3).sin()).collect()
}

/// B-03. The static residual is the gradient of the elastic energy, and this energy equals the numerical integral of `½ (ε_h − P ε₀)ᵀ
/// K_s(s) (ε_h − P ε₀)`: this checks the unequal blocks of the two halves and their coupling.
#[test]
fn b03_residual_is_the_gradient_of_the_energy() {
    let model = Model::new(&[BodyDescription { kind: Linear, elements: 3, ..blade() }]);
    let mut work = Workspace::new(&model);
    let n = model.coordinates;
    let (q, zero) = (wave(n, 0.7, 1.3), vec![0.0; n]);
    let force = motion_residual(&model, &mut work, &q, &zero);
    for i in 0..n {
        let at = |shift: f64| {
            let mut q = q.clone();
            q[i] += shift;
            elastic(&model, &q)
        };
        let slope = (at(0.5) - at(-0.5)) / 1.0; // the energy is quadratic: a central difference of any step is exact
        assert!((slope - force[i]).abs() < 1e-12 * (1.0 + slope.abs()), "coordinate {i}: {slope} and {}", force[i]);
    }

    let mut energy = 0.0;
    for pair in model.elements.chunks(2) {
        let length_m = 2.0 * pair[0].length_m;
        let excess = |k: usize| {
            let c = pair[k].coordinate;
            nalgebra::Vector4::from_column_slice(&q[c..c + 4]) - pair[k].elastic.natural_strain
        };
        let (a, b) = (excess(0), excess(1));
        const STEPS: u32 = 2000;
        for i in 0..STEPS {
            let sigma = (f64::from(i) + 0.5) / f64::from(STEPS);
            let strain = (a + b) * 0.5 + (b - a) * (1.5 * (sigma - 0.5));
            let section = stiffness(pair[0].start_m + sigma * length_m);
            energy += 0.5 * strain.dot(&(section * strain)) * length_m / f64::from(STEPS);
        }
    }
    let error = (elastic(&model, &q) / energy - 1.0).abs();
    assert!(error < 1e-6, "energy off by {error:.1e}; the midpoint rule holds 1e-7");
}

/// B-04. The articulated-body solution with unequal blocks: inserting the `x` of `(M + c K) x = r` into the residual, which is linear in
/// the accelerations, leaves only the round-off of its terms.
#[test]
fn b04_solve_inverts_what_the_residual_multiplies() {
    for kind in [Linear, Constant] {
        let model = Model::new(&[BodyDescription { kind, elements: 4, ..blade() }]);
        let mut work = Workspace::new(&model);
        let n = model.coordinates;
        let (q, right) = (wave(n, 0.7, 1.3), wave(n, 1.0, 2.1));
        let rest = motion_residual(&model, &mut work, &q, &vec![0.0; n]);
        let weight = 1e-2;
        let weights = Weights { mass: 1.0, damping: 0.0, stiffness: weight };
        let hinge = FreedomTangent { free: false, stiffness: 0.0, damping: 0.0 };
        factorize(&model, &mut work, weights, &[Damping::default()], &[hinge]).unwrap();
        let mut x = right.clone();
        foldwing::multibody::factor::solve(&model, &mut work, &mut x);
        let moved: Vec<f64> = q.iter().zip(&x).map(|(q, x)| q + weight * x).collect();
        // K (q + c x) − K q = c K x: the elastic force does not depend on the pose
        let stretched = motion_residual(&model, &mut work, &moved, &vec![0.0; n]);
        let driven = motion_residual(&model, &mut work, &q, &x);
        let scale = right.iter().fold(0.0f64, |largest, value| largest.max(value.abs()));
        for i in 0..n {
            let gap = (driven[i] - rest[i]) + (stretched[i] - rest[i]) - right[i];
            assert!(gap.abs() < 1e-9 * scale, "{kind:?}, coordinate {i}: off by {gap:.1e}");
        }
    }
}

/// Determinant of moment and shear at the free end, divided by `ω²`, of a clamped, harmonically vibrating Euler–Bernoulli beam with rotary
/// inertia (state: deflection, slope, moment, shear); its roots are the frequencies. Width and height fall linearly to 0.55.
fn free_end_determinant(omega_squared: f64, section: impl Fn(f64) -> [f64; 3]) -> f64 {
    let march = |moment: f64, shear: f64| {
        let mut state = nalgebra::Vector4::new(0.0, 0.0, moment, shear);
        let slope = |s: f64, x: &nalgebra::Vector4<f64>| {
            let [stiffness, mass, rotary] = section(s);
            // M' = V − ρI ω² w',  V' = ω² m w  with M = EI w''
            nalgebra::Vector4::new(
                x[1],
                x[2] / stiffness,
                x[3] - rotary * omega_squared * x[1],
                omega_squared * mass * x[0],
            )
        };
        let h = LENGTH_M / 1000.0;
        for i in 0..1000 {
            let s = h * f64::from(i);
            let k1 = slope(s, &state);
            let k2 = slope(s + 0.5 * h, &(state + k1 * (0.5 * h)));
            let k3 = slope(s + 0.5 * h, &(state + k2 * (0.5 * h)));
            let k4 = slope(s + h, &(state + k3 * h));
            state += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
        }
        [state[2], state[3]]
    };
    let (a, b) = (march(1.0, 0.0), march(0.0, 1.0));
    a[0] * b[1] - a[1] * b[0]
}

/// B-05. Flap frequencies of a straight blade whose width and height fall to 55 % at the tip, against shooting on the beam equation with
/// rotary inertia: mass and stiffness vary along the elements in dynamics too. Pairs have order 4.
#[test]
fn b05_frequencies_of_a_tapered_blade() {
    let material = Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.1e9, density_kg_m3: 1400.0 };
    let (width, height) = (0.06, 0.004);
    let solid = Solid {
        shear_factor: None,
        outline: Outline::Rectangle,
        width_m: width,
        height_m: height,
        material,
        torsional_rigidity_n_m2: None,
    };
    let taper = Profile::linear(1.0, 0.55, LENGTH_M);
    let law = SectionLaw::Tapered { solid, width: taper.clone(), height: taper };
    let body = description(LENGTH_M, law, [0.0; 4].into());
    let section = |s: f64| {
        let f: f64 = 1.0 - 0.45 * s / LENGTH_M;
        let (b, h) = (width * f, height * f);
        [3e9 * b * h.powi(3) / 12.0, 1400.0 * b * h, 1400.0 * b * h.powi(3) / 12.0]
    };
    let root = |mut low: f64, mut high: f64| {
        let sign = free_end_determinant(low, section).signum();
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if free_end_determinant(middle, section).signum() == sign { low = middle } else { high = middle }
        }
        low
    };
    // brackets of the roots from a scan
    let scan: Vec<f64> = (0..4000).map(|i| (f64::from(i) * 0.25).powi(2)).collect();
    let exact: Vec<f64> = scan
        .windows(2)
        .filter(|pair| free_end_determinant(pair[0], section) * free_end_determinant(pair[1], section) < 0.0)
        .take(2)
        .map(|pair| root(pair[0], pair[1]).sqrt())
        .collect();
    let errors = [4, 8, 16].map(|elements| {
        let found = flap_frequencies(&BodyDescription { elements, ..body.clone() });
        [0, 1].map(|i| (found[i] / exact[i] - 1.0).abs())
    });
    for mode in 0..2 {
        assert_order(
            &format!("B-05 mode {} at {:.3} rad/s", mode + 1, exact[mode]),
            &errors.map(|e| e[mode]),
            3.3,
            4.6,
        );
    }
    assert!(errors[2][0] < 5e-7 && errors[2][1] < 1e-5, "16 pairs: {errors:?}");
}

/// Angular frequencies of the flap modes, ascending, from the mass matrix of the residual and the stiffness of the elements' blocks.
fn flap_frequencies(body: &BodyDescription) -> Vec<f64> {
    let model = Model::new(std::slice::from_ref(body));
    let mut work = Workspace::new(&model);
    let n = model.coordinates;
    let q = vec![0.0; n];
    // κy is the third strain of every element
    let flap: Vec<usize> = (0..n).filter(|i| i % 4 == 2).collect();
    let column = |i: usize, of: &mut dyn FnMut(&[f64]) -> Vec<f64>| {
        let mut unit = vec![0.0; n];
        unit[flap[i]] = 1.0;
        of(&unit)
    };
    let m = flap.len();
    let (mut mass, mut stiffness) = (DMatrix::zeros(m, m), DMatrix::zeros(m, m));
    for j in 0..m {
        let by_acceleration = column(j, &mut |unit| motion_residual(&model, &mut work, &q, unit));
        let by_strain = column(j, &mut |unit| motion_residual(&model, &mut work, unit, &q));
        for i in 0..m {
            mass[(i, j)] = by_acceleration[flap[i]];
            stiffness[(i, j)] = by_strain[flap[i]];
        }
    }
    let inverse = mass.cholesky().expect("positive definite").inverse();
    let mut squares: Vec<f64> = (inverse * stiffness).complex_eigenvalues().iter().map(|value| value.re).collect();
    squares.sort_by(f64::total_cmp);
    squares.into_iter().map(f64::sqrt).collect()
}
