//! A small Newton solver for tests: static equilibrium with a dense tangent from differences of the residual.

use foldwing::beam::element::ElementKind;
use foldwing::beam::section::Section;
use foldwing::load::{LoadFrame, RootMotion, Wrench};
use foldwing::multibody::dynamics::{Damping, Environment, residual};
use foldwing::multibody::joint::JointKind;
use foldwing::multibody::kinematics::Motion;
use foldwing::multibody::model::{Attachment, BodyDescription};
use foldwing::multibody::{Model, Workspace};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix4, Vector3, Vector4};

/// Loads of a static case.
pub struct Loading {
    /// Gravity in m/s².
    pub gravity_m_s2: Vector3<f64>,
    /// Wrench per station.
    pub stations: Vec<Wrench>,
}

impl Loading {
    /// Station loads without gravity.
    pub fn stations(stations: Vec<Wrench>) -> Self {
        Self { gravity_m_s2: Vector3::zeros(), stations }
    }

    /// Residual at zero rates; leaves the results of the recursion in `work`.
    pub fn residual(&self, model: &Model, work: &mut Workspace, q: &[f64]) -> DVector<f64> {
        self.fraction(model, work, q, 1.0)
    }

    fn fraction(&self, model: &Model, work: &mut Workspace, q: &[f64], share: f64) -> DVector<f64> {
        let root = RootMotion { gravity_m_s2: self.gravity_m_s2 * share, ..RootMotion::default() };
        let stations: Vec<Wrench> = self
            .stations
            .iter()
            .map(|load| Wrench { force_n: load.force_n * share, moment_n_m: load.moment_n_m * share })
            .collect();
        let zero = vec![0.0; q.len()];
        let mut value = vec![0.0; q.len()];
        let damping = vec![Damping::default(); model.bodies.len()];
        let environment = Environment { root: &root, damping: &damping, stations: &stations };
        residual(model, work, Motion { q, v: &zero, a: &zero }, environment, &mut value);
        value.into()
    }
}

/// Equilibrium by load steps; `held` coordinates keep their initial value. Leaves the last residual in `work`.
///
/// Each load step ends when the Newton correction, below 1e-9 of the coordinates, no longer decreases: round-off.
pub fn equilibrium(model: &Model, work: &mut Workspace, start: &[f64], loading: &Loading, steps: usize) -> Vec<f64> {
    let n = model.coordinates;
    let held: Vec<usize> = model
        .bodies
        .iter()
        .map(|body| &body.joint)
        .filter(|joint| joint.kind.freedoms() == 1)
        .map(|joint| joint.coordinate)
        .collect();
    let mut q = start.to_vec();
    for step in 1..=steps {
        let share = step as f64 / steps as f64;
        let mut last = f64::INFINITY;
        for iteration in 0.. {
            assert!(iteration < 60, "Newton does not converge at load share {share}, last correction {last:.1e}");
            let mut tangent = DMatrix::zeros(n, n);
            for j in 0..n {
                let h = 1e-6 * q[j].abs().max(1.0);
                let mut at = |shift: f64| {
                    let mut q = q.clone();
                    q[j] += shift;
                    loading.fraction(model, work, &q, share)
                };
                let slope: DVector<f64> = (at(h) - at(-h)) / (2.0 * h);
                tangent.set_column(j, &slope);
            }
            let mut right = -loading.fraction(model, work, &q, share);
            for &c in &held {
                tangent.row_mut(c).fill(0.0);
                tangent.column_mut(c).fill(0.0);
                tangent[(c, c)] = 1.0;
                right[c] = 0.0;
            }
            let change = tangent.lu().solve(&right).expect("regular tangent");
            let size = change.amax() / (1.0 + DVector::from_column_slice(&q).amax());
            q.iter_mut().zip(change.iter()).for_each(|(q, change)| *q += change);
            if (size < 1e-9 && size >= 0.5 * last) || size < 1e-14 {
                break;
            }
            last = size;
        }
    }
    loading.residual(model, work, &q);
    q
}

/// Section with diagonal stiffness `(EA, GJ, EI_y, EI_z)` and small inertia.
pub fn plain_section(stiffness: [f64; 4]) -> Section {
    Section {
        stiffness: Matrix4::from_diagonal(&Vector4::from(stiffness)),
        mass_kg_m: 1.0,
        first_moment_kg: [0.0; 2],
        second_moment_kg_m: [1e-3, 0.0, 1e-3],
        half_width_m: 0.1,
        half_height_m: 0.05,
        shear: None,
    }
}

/// Straight body along the root's axes, clamped, with one station at its tip.
pub fn cantilever(
    length_m: f64,
    section: Section,
    kind: ElementKind,
    elements: usize,
    frame: LoadFrame,
) -> BodyDescription {
    BodyDescription {
        length_m,
        section: section.into(),
        kind,
        elements,
        natural_strain: [0.0; 4].into(),
        offset_m: Vector3::zeros(),
        parent: Attachment::Root(Vector3::zeros()),
        mount: Matrix3::identity(),
        joint: JointKind::Clamped,
        masses: Vec::new(),
        stations_m: vec![length_m],
        load_frame: frame,
    }
}

/// Observed order from the errors of two meshes.
pub fn order(coarse: f64, fine: f64, ratio: f64) -> f64 {
    (coarse / fine).ln() / ratio.ln()
}

/// Asserts that the order between the last two of the errors on meshes refined by a factor of 2 is at least `least` and less than `most`.
pub fn assert_order(what: &str, errors: &[f64], least: f64, most: f64) {
    let orders: Vec<f64> = errors.windows(2).map(|pair| order(pair[0], pair[1], 2.0)).collect();
    let list: Vec<String> = errors.iter().map(|error| format!("{error:.2e}")).collect();
    println!("{what}: errors {list:?}, orders {orders:.2?}");
    let last = orders[orders.len() - 1];
    assert!((least..=most).contains(&last), "{what}: order {last:.2} outside {least}..{most}, errors {list:?}");
}
