//! The elimination of elements with shear against the residual, for all kinds of mass and stiffness.

use super::*;
use crate::beam::section::{Material, Section, Solid};
use crate::load::{LoadFrame, RootMotion};
use crate::multibody::dynamics::{Damping, Environment, residual};
use crate::multibody::factor::{FreedomTangent, Weights, factorize as factorize_model, solve};
use crate::multibody::joint::JointKind;
use crate::multibody::kinematics::Motion;
use crate::multibody::model::{Attachment, BodyDescription};

/// Sections with diagonal and with full stiffness, with the centre of mass on the axis and beside it.
fn sections() -> Vec<(bool, Section)> {
    let material = Material { youngs_modulus_pa: 2.83e6, shear_modulus_pa: 1.0e6, density_kg_m3: 1425.0 };
    let plain = Solid::rectangle(0.05, 0.02, material).with_shear().section();
    let mut coupled = plain.clone();
    if let Some(shear) = &mut coupled.shear {
        let own = *shear;
        for i in 0..SHEARED {
            for j in 0..i {
                let coupling = 0.1 * (own[(i, i)] * own[(j, j)]).sqrt();
                (shear[(i, j)], shear[(j, i)]) = (coupling, coupling);
            }
        }
    }
    let beside = |section: &Section| {
        let mut section = section.clone();
        section.first_moment_kg = [0.01 * section.mass_kg_m, -0.004 * section.mass_kg_m];
        section.second_moment_kg_m[1] = 0.2 * section.second_moment_kg_m[2];
        section.second_moment_kg_m[0] += 1e-4 * section.mass_kg_m;
        section.second_moment_kg_m[2] += 1e-4 * section.mass_kg_m;
        section
    };
    vec![(true, plain.clone()), (false, coupled.clone()), (true, beside(&plain)), (false, beside(&coupled))]
}

/// A clamped body, a hinged one, and a third one on the middle of the first.
fn model(kind: ElementKind, section: &Section) -> Model {
    let body = |parent, joint| BodyDescription {
        length_m: 0.6,
        section: section.clone().into(),
        kind,
        elements: 4,
        natural_strain: [0.0, 0.1, -0.2, 0.3].into(),
        offset_m: Vector3::zeros(),
        parent,
        mount: Matrix3::identity(),
        joint,
        masses: Vec::new(),
        stations_m: Vec::new(),
        load_frame: LoadFrame::Root,
    };
    Model::new(&[
        body(Attachment::Root(Vector3::zeros()), JointKind::Clamped),
        body(Attachment::Body { index: 0, position_m: 0.6 }, JointKind::Revolute { axis: Vector3::y() }),
        body(Attachment::Body { index: 0, position_m: 0.3 }, JointKind::Revolute { axis: Vector3::z() }),
    ])
}

fn wave(model: &Model, scale: f64, shift: f64) -> Vec<f64> {
    (0..model.coordinates).map(|i| scale * (1.7 * i as f64 + shift).sin()).collect()
}

/// The elimination inverts the matrix that multiplies the accelerations in the residual: inertia, and stiffness as that of a frequency limit. 1e-11 of
/// the largest entry: round-off multiplied by the condition of an element.
#[test]
fn elimination_inverts_the_mass_matrix() {
    for kind in [ElementKind::Constant, ElementKind::Linear] {
        for (diagonal, section) in sections() {
            let model = model(kind, &section);
            assert!(model.elements.iter().all(|element| Strained::<SHEARED>::elastic(element).diagonal == diagonal));
            let mut work = Workspace::new(&model);
            let damping =
                vec![Damping { mass_1_s: 0.0, stiffness_s: 0.0, strain_inertia_s2: 1e-5 }; model.bodies.len()];
            let root = RootMotion::default();
            let environment = Environment { root: &root, damping: &damping, stations: &[] };
            let (q, v, a) = (wave(&model, 0.3, 0.4), wave(&model, 2.0, 1.1), wave(&model, 50.0, 0.2));
            let zero = vec![0.0; model.coordinates];
            let mut rows = [zero.clone(), zero.clone()];
            for (a, rows) in [&a, &zero].into_iter().zip(&mut rows) {
                residual(&model, &mut work, Motion { q: &q, v: &v, a }, environment, rows);
            }
            let mut x: Vec<f64> = rows[0].iter().zip(&rows[1]).map(|(with, without)| with - without).collect();
            let tangents = vec![FreedomTangent { free: true, stiffness: 0.0, damping: 0.0 }; model.bodies.len()];
            let weights = Weights { mass: 1.0, damping: 0.0, stiffness: 0.0 };
            factorize_model(&model, &mut work, weights, &damping, &tangents).expect("positive pivots");
            assert!(solve(&model, &mut work, &mut x).is_finite());
            let mut again = zero.clone();
            residual(&model, &mut work, Motion { q: &q, v: &v, a: &x }, environment, &mut again);
            let size = rows[0].iter().zip(&rows[1]).map(|(with, without)| (with - without).abs()).fold(0.0, f64::max);
            let error = again.iter().zip(&rows[0]).map(|(again, row)| (again - row).abs()).fold(0.0, f64::max);
            assert!(error < 1e-11 * size, "{kind:?} {diagonal}: {error:.1e} of {size:.1e}");
        }
    }
}

/// Diagonal stiffness and masses in principal axes have shorter formulas: those for full matrices give the same residual and the same solution to
/// round-off.
#[test]
fn short_formulas_agree_with_full_ones() {
    for kind in [ElementKind::Constant, ElementKind::Linear] {
        let short = model(kind, &sections()[0].1);
        let mut full = short.clone();
        full.bodies.iter_mut().for_each(|body| body.slim_mass = false);
        for element in &mut full.elements {
            if let Some(own) = &mut element.sheared {
                own.diagonal = false;
            }
        }
        let damping = vec![Damping { mass_1_s: 2.0, stiffness_s: 1e-3, strain_inertia_s2: 0.0 }; 3];
        let [one, other] = [&short, &full].map(|model| {
            let mut work = Workspace::new(model);
            let environment = Environment { root: &RootMotion::default(), damping: &damping, stations: &[] };
            let (q, v, a) = (wave(model, 0.3, 0.4), wave(model, 2.0, 1.1), wave(model, 50.0, 0.2));
            let mut rows = vec![0.0; model.coordinates];
            residual(model, &mut work, Motion { q: &q, v: &v, a: &a }, environment, &mut rows);
            let tangents = [FreedomTangent { free: true, stiffness: 0.1, damping: 0.0 }; 3];
            let weights = Weights { mass: 1.0, damping: 1e-3, stiffness: 1e-6 };
            factorize_model(model, &mut work, weights, &damping, &tangents).expect("positive pivots");
            let mut x = rows.clone();
            solve(model, &mut work, &mut x);
            [rows, x]
        });
        for (one, other) in one.iter().zip(&other) {
            let size = one.iter().fold(0.0f64, |size, value| size.max(value.abs()));
            let apart = one.iter().zip(other).fold(0.0f64, |apart, (a, b)| apart.max((a - b).abs()));
            assert!(size > 0.0 && apart < 1e-12 * size, "{kind:?}: {apart:.1e} of {size:.1e}");
        }
    }
}
