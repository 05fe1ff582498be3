//! Sliding joints in comparison with finite differences of poses, and the elimination in comparison with the residual.

use super::*;
use crate::beam::element::rigid_body_mass;
use crate::beam::section::{Material, Solid};
use crate::load::LoadFrame;
use crate::load::RootMotion;
use crate::multibody::dynamics::residual;
use crate::multibody::dynamics::{Damping, Environment};
use crate::multibody::factor::{FreedomTangent, Weights, factorize, solve};
use crate::multibody::joint::JointKind;
use crate::multibody::kinematics::sweep_motion;
use crate::multibody::model::{Attachment, BodyDescription};
use nalgebra::{Matrix3, Rotation3};

/// A hinged beam along which a body slides that carries another beam on a hinge, and a second body on the same element or pair.
fn model(kind: ElementKind, sheared: bool) -> Model {
    let section = Solid::rectangle(0.05, 0.02, Material::isotropic(1e8, 0.3, 1000.0));
    let part = |joint, parent, length_m: f64, elements, sheared| BodyDescription {
        length_m,
        section: if sheared { section.with_shear().section().into() } else { section.section().into() },
        kind,
        elements,
        natural_strain: [0.0, 0.4, -0.6, 0.3].into(),
        offset_m: if matches!(parent, Attachment::Root(_)) {
            Vector3::zeros()
        } else {
            Vector3::new(0.02, -0.05, 0.04)
        },
        parent,
        mount: Rotation3::new(Vector3::new(0.4, -0.2, 0.9)).into_inner(),
        joint,
        masses: vec![(
            0.0,
            rigid_body_mass(0.3, &Vector3::new(0.05, 0.02, -0.1), &Matrix3::from_diagonal_element(1e-3)),
        )],
        stations_m: Vec::new(),
        load_frame: LoadFrame::Root,
    };
    let hinge = JointKind::Revolute { axis: Vector3::y() };
    Model::new(&[
        part(hinge, Attachment::Root(Vector3::zeros()), 1.0, 3, sheared),
        part(JointKind::Sliding, Attachment::Axis { index: 0 }, 0.0, 0, false),
        part(hinge, Attachment::Body { index: 1, position_m: 0.0 }, 0.4, 1, false),
        part(JointKind::Sliding, Attachment::Axis { index: 0 }, 0.0, 0, false),
    ])
}

/// Random coordinates, rates and accelerations, with both bodies in the second element or pair.
fn motion(model: &Model, seed: u64) -> [Vec<f64>; 3] {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut all = [0.5, 1.5, 4.0]
        .map(|size| -> Vec<f64> { (0..model.coordinates).map(|_| size * (2.0 * random.f64() - 1.0)).collect() });
    for (slide, share) in model.slides.iter().zip([0.3, 0.85]) {
        all[0][model.bodies[slide.rider].joint.coordinate] = (1.0 + share) / 3.0;
    }
    all
}

fn seated(model: &Model) -> Workspace {
    let mut work = Workspace::new(model);
    for (own, slide) in work.slides.iter_mut().zip(&model.slides) {
        own.element = slide.element(model, 1);
    }
    work
}

fn cases() -> impl Iterator<Item = (Model, u64)> {
    let kinds = [ElementKind::Constant, ElementKind::Linear];
    kinds.into_iter().flat_map(|kind| [false, true].map(|sheared| (model(kind, sheared), 7 + u64::from(sheared))))
}

/// Velocities and accelerations of the bodies are the derivatives of their poses along a motion: central differences with steps of 1e-4 s
/// are accurate to 1e-7 in velocities and 1e-6 in accelerations.
#[test]
fn rates_are_derivatives_of_poses() {
    for (model, seed) in cases() {
        let [q, v, a] = motion(&model, seed);
        let mut work = seated(&model);
        let mut at = |time: f64| {
            let along = |i: usize| q[i] + time * (v[i] + 0.5 * time * a[i]);
            let q: Vec<f64> = (0..q.len()).map(along).collect();
            let rates: Vec<f64> = v.iter().zip(&a).map(|(v, a)| v + time * a).collect();
            sweep_motion(&model, &mut work, Motion { q: &q, v: &rates, a: &a });
            work.nodes.clone()
        };
        let step = 1e-4;
        let [before, here, after] = [at(-step), at(0.0), at(step)];
        for rider in model.slides.iter().map(|slide| model.bodies[slide.rider].first_node) {
            let [b, h, f] = [&before, &here, &after].map(|nodes| &nodes[rider]);
            let velocity = (f.position - b.position) / (2.0 * step) - h.velocity;
            let turn = (f.rotation - b.rotation) / (2.0 * step) - hat(&h.spin) * h.rotation;
            let acceleration = (f.velocity - b.velocity) / (2.0 * step) - h.acceleration;
            let spin_rate = (f.spin - b.spin) / (2.0 * step) - h.spin_rate;
            let sizes = [velocity.amax(), turn.amax(), acceleration.amax(), spin_rate.amax()];
            assert!(sizes[0] < 1e-6 && sizes[1] < 1e-6 && sizes[2] < 1e-5 && sizes[3] < 1e-5, "{sizes:?}");
        }
    }
}

/// The elimination inverts the mass matrix of the residual: the solution of `M x = r` gives `r` again, to round-off of its largest entry.
#[test]
fn elimination_inverts_the_mass_matrix() {
    for (model, seed) in cases() {
        let [q, v, a] = motion(&model, seed);
        let mut work = seated(&model);
        let damping = vec![Damping::default(); model.bodies.len()];
        let root = RootMotion::default();
        let environment = Environment { root: &root, damping: &damping, stations: &[] };
        let zero = vec![0.0; q.len()];
        let mut rows = [zero.clone(), zero.clone()];
        for (a, rows) in [&a, &zero].into_iter().zip(&mut rows) {
            residual(&model, &mut work, Motion { q: &q, v: &v, a }, environment, rows);
        }
        let mut x: Vec<f64> = rows[0].iter().zip(&rows[1]).map(|(with, without)| with - without).collect();
        let tangents = vec![FreedomTangent { free: true, stiffness: 0.0, damping: 0.0 }; model.bodies.len()];
        let weights = Weights { mass: 1.0, damping: 0.0, stiffness: 0.0 };
        factorize(&model, &mut work, weights, &damping, &tangents).expect("positive pivots");
        assert!(solve(&model, &mut work, &mut x).is_finite());
        let mut again = zero.clone();
        residual(&model, &mut work, Motion { q: &q, v: &v, a: &x }, environment, &mut again);
        let size = rows[0].iter().zip(&rows[1]).map(|(with, without)| (with - without).abs()).fold(0.0, f64::max);
        let error = again.iter().zip(&rows[0]).map(|(again, row)| (again - row).abs()).fold(0.0, f64::max);
        assert!(error < 1e-11 * size, "{error:.1e} of {size:.1e}");
    }
}

/// The power of a wrench on a body is that of its projections on the coordinates: both maps are transposes of each other.
#[test]
fn projection_is_the_transpose_of_the_velocities() {
    for (model, seed) in cases() {
        let [q, v, _] = motion(&model, seed);
        let zero = vec![0.0; q.len()];
        let mut work = seated(&model);
        sweep_motion(&model, &mut work, Motion { q: &q, v: &v, a: &zero });
        let (index, slide) = (0, model.slides[0]);
        let wrench = Pair { linear: Vector3::new(1.0, -2.0, 0.7), angular: Vector3::new(0.3, 0.5, -1.1) };
        let carriage = work.slides[index].carry::<true>(&model, &slide, &work.nodes, Motion { q: &q, v: &v, a: &zero });
        let mut rows = zero.clone();
        work.slides[index].project(&model, &slide, &wrench, &mut rows);
        let own = &work.slides[index];
        rows[model.bodies[slide.rider].joint.coordinate] += dot(&own.column, &wrench);
        let inner = work.nodes[own.inner_node(&model, &slide)];
        let carried = inner.velocity + inner.spin.cross(&own.arm);
        let of_rows: f64 = rows.iter().zip(&v).map(|(row, rate)| row * rate).sum();
        let power = dot(&Pair { linear: carriage.velocity - carried, angular: carriage.spin - inner.spin }, &wrench);
        assert!((power - of_rows).abs() < 1e-13 * (1.0 + power.abs()), "{power} {of_rows}");
    }
}
