//! V-40 to V-44: frequencies against closed forms and an exact dynamic stiffness.

use crate::reference::{case, numbers};
use crate::static_newton::{cantilever, order, plain_section};
use crate::trees::{Case, State};
use foldwing::beam::element::ElementKind::{self, Constant, Linear};
use foldwing::beam::section::Section;
use foldwing::load::{LoadFrame, RootMotion};
use foldwing::multibody::Workspace;
use foldwing::multibody::dynamics::{Damping, Environment, residual};
use foldwing::multibody::joint::JointKind;
use foldwing::multibody::kinematics::Motion;
use foldwing::multibody::model::Attachment;
use nalgebra::{DMatrix, DVector, Vector3};
use std::f64::consts::PI;

/// Angular frequencies in rad/s, ascending, and shapes of the unloaded wing with its hinges held at `angles_rad`.
///
/// Both matrices are columns of the engine's residual: with respect to accelerations at zero rates, and to strains (exact, because the
/// residual is linear in both there). Solved as `K⁻¹M`, so that massless motions have eigenvalue zero.
pub fn modes(case: &Case, angles_rad: &[f64]) -> Vec<(f64, DVector<f64>)> {
    let model = &case.model;
    let n = model.coordinates;
    let mut rest = model.natural_coordinates();
    let hinges: Vec<usize> = model
        .bodies
        .iter()
        .map(|body| &body.joint)
        .filter(|joint| joint.kind.freedoms() == 1)
        .map(|joint| joint.coordinate)
        .collect();
    for (&hinge, &angle) in hinges.iter().zip(angles_rad) {
        rest[hinge] = angle;
    }
    let zero = vec![0.0; n];
    let damping = vec![Damping::default(); model.bodies.len()];
    let mut work = Workspace::new(model);
    let mut at = |q: &[f64], a: &[f64]| {
        let environment = Environment { root: &RootMotion::default(), damping: &damping, stations: &[] };
        let mut value = vec![0.0; n];
        residual(model, &mut work, Motion { q, v: &zero, a }, environment, &mut value);
        DVector::from_vec(value)
    };
    let (mut mass, mut stiffness) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    for j in 0..n {
        let mut unit = zero.clone();
        unit[j] = 1.0;
        mass.set_column(j, &at(&rest, &unit));
        let moved: Vec<f64> = rest.iter().zip(&unit).map(|(q, u)| q + u).collect();
        stiffness.set_column(j, &at(&moved, &zero));
    }
    let mass = mass.remove_columns_at(&hinges).remove_rows_at(&hinges);
    let stiffness = stiffness.remove_columns_at(&hinges).remove_rows_at(&hinges);
    let root = stiffness.cholesky().expect("stiffness is positive definite").l();
    let half = root.solve_lower_triangular(&mass).expect("regular");
    let flexibility = root.solve_lower_triangular(&half.transpose()).expect("regular");
    let symmetric = (&flexibility + flexibility.transpose()) * 0.5;
    let eigen = symmetric.symmetric_eigen();
    let mut list: Vec<(f64, DVector<f64>)> = (0..eigen.eigenvalues.len())
        .map(|i| {
            let shape = root.tr_solve_lower_triangular(&eigen.eigenvectors.column(i).into_owned()).expect("regular");
            (1.0 / eigen.eigenvalues[i].max(1e-300).sqrt(), shape)
        })
        .collect();
    list.sort_by(|a, b| a.0.total_cmp(&b.0));
    list
}

fn beta_l(mode: usize) -> f64 {
    numbers(&case("modal.betaL")["expected"]["clamped_free_betaL"])[mode]
}

/// `w''(x) L² / w(L)` of a clamped-free mode at `x/L`.
pub fn mode_shape(mode: usize, place: f64) -> f64 {
    let b = beta_l(mode);
    let sigma = (b.cosh() + b.cos()) / (b.sinh() + b.sin());
    let x = b * place;
    let curvature = b * b * (x.cosh() + x.cos() - sigma * (x.sinh() + x.sin()));
    let tip = b.cosh() - b.cos() - sigma * (b.sinh() - b.sin());
    curvature / tip
}

/// Clamped beam of unit length, mass and `EI_y`, stiff in all other deformations, without rotary inertia.
pub fn flap_beam(kind: ElementKind, elements: usize) -> Case {
    let mut section = plain_section([1e7, 1e5, 1.0, 1e5]);
    section.second_moment_kg_m = [0.0; 3];
    let mut body = cantilever(1.0, section, kind, elements, LoadFrame::Root);
    body.stations_m.clear();
    Case::new(vec![body], Vec::new())
}

fn flap_errors(kind: ElementKind, elements: usize, count: usize) -> Vec<f64> {
    let list = modes(&flap_beam(kind, elements), &[]);
    (0..count).map(|mode| list[mode].0 / beta_l(mode).powi(2) - 1.0).collect()
}

/// V-40. Clamped-free flap frequencies, constant elements: relative error of mode `i` at most `(β_i L/n)²/15`
/// (a piecewise constant curvature of a wave of that length), order 2.
#[test]
fn v40_constant_elements() {
    let meshes = [10, 20, 40].map(|n| (n, flap_errors(Constant, n, 4)));
    for (elements, errors) in &meshes {
        for (mode, error) in errors.iter().enumerate() {
            let bound = (beta_l(mode) / *elements as f64).powi(2) / 15.0;
            println!("V-40 {elements} elements, mode {}: {error:.2e}, bound {bound:.2e}", mode + 1);
            assert!(error.abs() <= bound, "{elements} elements, mode {}: {error:.2e} over {bound:.2e}", mode + 1);
        }
    }
    for mode in 0..4 {
        let observed = order(meshes[1].1[mode].abs(), meshes[2].1[mode].abs(), 2.0);
        assert!((1.9..2.1).contains(&observed), "mode {}: order {observed:.2}", mode + 1);
    }
}

/// V-41. As V-40 with pairs: with 10 pairs, modes 1 to 3 are within 1e-6, 5e-5 and 5e-4 (half a wavelength per three pairs), order 3.5 to
/// 4.5.
#[test]
fn v41_pairs() {
    let meshes = [5, 10, 20].map(|n| flap_errors(Linear, n, 3));
    for (mode, bound) in [1e-6, 5e-5, 5e-4].into_iter().enumerate() {
        let list: Vec<String> = meshes.iter().map(|errors| format!("{:.2e}", errors[mode])).collect();
        let observed = order(meshes[0][mode].abs(), meshes[1][mode].abs(), 2.0);
        println!("V-41 mode {}: errors {list:?}, order {observed:.2}", mode + 1);
        assert!(meshes[1][mode].abs() <= bound, "mode {}: {list:?} over {bound:.0e}", mode + 1);
        assert!((3.3..4.6).contains(&observed), "mode {}: order {observed:.2}", mode + 1);
    }
}

/// V-42. Clamped-free torsion, `ω = (2i − 1) π/2 √(GJ/ρJ)/L`: order 4 with pairs, 2 with constant elements.
#[test]
fn v42_torsion() {
    let error = |kind, elements, mode: usize| {
        let mut section = plain_section([1e7, 1.0, 1e7, 1e7]);
        section.second_moment_kg_m = [0.5, 0.0, 0.5];
        let mut body = cantilever(1.0, section, kind, elements, LoadFrame::Root);
        body.stations_m.clear();
        let frequency = modes(&Case::new(vec![body], Vec::new()), &[])[mode].0;
        (frequency / ((mode as f64 + 0.5) * PI) - 1.0).abs()
    };
    for mode in 0..2 {
        for (kind, meshes, orders) in [(Constant, [8, 16, 32], 1.9..2.1), (Linear, [4, 8, 16], 3.7..4.3)] {
            let errors = meshes.map(|n| error(kind, n, mode));
            let observed = order(errors[1], errors[2], 2.0);
            println!(
                "V-42 {kind:?} mode {}: {:.2e} {:.2e} {:.2e}, order {observed:.2}",
                mode + 1,
                errors[0],
                errors[1],
                errors[2]
            );
            assert!(orders.contains(&observed), "{kind:?} mode {}: order {observed:.2}", mode + 1);
        }
    }
}

/// V-43. Two plates of \[O\] Table 5 as a rigid L-frame, fold held at 0° and 90°, in-plane modes against the exact dynamic stiffness (1e-9
/// Hz). 8 pairs per body: four frequencies, each within 1e-4. Other motions are suppressed by high stiffness.
#[test]
fn v43_folded_frame() {
    let reference = case("modal.wing_table5_frames");
    let inputs = &reference["inputs"];
    let value = |key: &str| inputs[key].as_f64().expect("a number");
    let section = Section {
        second_moment_kg_m: [0.0; 3],
        mass_kg_m: value("m"),
        ..plain_section([value("EA"), 1e4, value("EI"), 1e4])
    };
    for (fold_deg, key) in [(0.0f64, "fold0"), (90.0, "fold90")] {
        let expected = numbers(&reference["expected"]["Lframe_inplane_Hz"][key]);
        let errors = [4, 8].map(|pairs| {
            let mut a = cantilever(0.15, section.clone(), Linear, pairs, LoadFrame::Root);
            a.stations_m.clear();
            let mut b = a.clone();
            b.parent = Attachment::Body { index: 0, position_m: 0.15 };
            b.joint = JointKind::Revolute { axis: Vector3::y() };
            let list = modes(&Case::new(vec![a, b], Vec::new()), &[fold_deg.to_radians()]);
            let relative = |mode: usize| list[mode].0 / (2.0 * PI) / expected[mode] - 1.0;
            [0, 1, 2, 3].map(relative)
        });
        println!("V-43 fold {fold_deg}°: {errors:?}");
        for (mode, error) in errors[1].iter().enumerate() {
            assert!(error.abs() < 1e-4, "fold {fold_deg}°, mode {}: frequency off by {error:.1e}", mode + 1);
            let observed = order(errors[0][mode].abs(), error.abs(), 2.0);
            assert!(observed > 3.3, "fold {fold_deg}°, mode {}: order {observed:.2}", mode + 1);
        }
    }
}

/// V-44. The mass matrix from the residual equals that of the dense form at a random pose: `BᵀMB`, round-off.
#[test]
fn v44_mass_matrix_from_the_residual() {
    let case = crate::trees::branching_tree(51, [Linear, Constant, Constant, Linear]);
    let state = State::random(&case, 52, 0.5);
    let model = &case.model;
    let exact = crate::oracle::Oracle::new(&case).mass_matrix(&state.q);
    let zero = vec![0.0; model.coordinates];
    let mut work = Workspace::new(model);
    let mut at = |a: &[f64]| {
        let damping = vec![Damping::default(); model.bodies.len()];
        let environment = Environment { root: &RootMotion::default(), damping: &damping, stations: &[] };
        let mut value = vec![0.0; model.coordinates];
        residual(model, &mut work, Motion { q: &state.q, v: &zero, a }, environment, &mut value);
        DVector::from_vec(value)
    };
    let base = at(&zero);
    for j in 0..model.coordinates {
        let mut unit = zero.clone();
        unit[j] = 1.0;
        let gap = (at(&unit) - &base - exact.column(j)).amax() / (exact.column(j).amax() + base.amax());
        assert!(gap < 1e-14, "column {j} off by {gap:.1e}");
    }
}
