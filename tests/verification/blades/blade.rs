//! The blades of these tests in two forms: as functions that the reference evaluates, and as the engine's description.

use crate::blades::boundary_value::{Rod, Section};
use crate::static_newton::{Loading, equilibrium};
use foldwing::beam::element::ElementKind;
use foldwing::beam::law::{NaturalStrain, SectionLaw};
use foldwing::load::{LoadFrame, Wrench};
use foldwing::multibody::dynamics::Damping;
use foldwing::multibody::gauge::strain_measures;
use foldwing::multibody::joint::JointKind;
use foldwing::multibody::kinematics::Motion;
use foldwing::multibody::model::{Attachment, BodyDescription};
use foldwing::multibody::{Model, Workspace};
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};
use std::f64::consts::PI;

/// Young's modulus of the paper in Pa.
pub const YOUNG_PA: f64 = 70e9;
/// Poisson's ratio of the paper.
pub const POISSON: f64 = 0.25;
/// Shear modulus of the isotropic material, Pa.
pub const SHEAR_PA: f64 = YOUNG_PA / (2.0 * (1.0 + POISSON));

/// Classical stiffness of an ellipse with half axes in m: `diag(EA, GJ, EI₂, EI₃)`.
pub fn ellipse(a: f64, b: f64) -> Matrix4<f64> {
    Matrix4::from_diagonal(&Vector4::new(
        YOUNG_PA * PI * a * b,
        SHEAR_PA * PI * a.powi(3) * b.powi(3) / (a * a + b * b),
        YOUNG_PA * PI * a * b.powi(3) / 4.0,
        YOUNG_PA * PI * b * a.powi(3) / 4.0,
    ))
}

/// A clamped blade whose root frame coincides with the world frame.
pub fn description(length_m: f64, section: SectionLaw, natural_strain: NaturalStrain) -> BodyDescription {
    BodyDescription {
        length_m,
        section,
        kind: ElementKind::Linear,
        elements: 1,
        natural_strain,
        offset_m: Vector3::zeros(),
        parent: Attachment::Root(Vector3::zeros()),
        mount: Matrix3::identity(),
        joint: JointKind::Clamped,
        masses: Vec::new(),
        stations_m: vec![length_m],
        load_frame: LoadFrame::Root,
    }
}

/// Solution of the engine under a dead tip force.
pub struct Solution {
    /// Tip position in m.
    pub tip: Vector3<f64>,
    /// Rotation from the tip section to the root frame.
    pub frame: Matrix3<f64>,
    /// Moment at the blade's root section, with the sign convention of the reference, N·m.
    pub root_moment: Vector3<f64>,
    /// Strain measures at the arc lengths `i L / count`.
    pub measures: Vec<Vector4<f64>>,
}

/// Static equilibrium with `elements` elements of one kind.
pub fn solve(
    body: &BodyDescription,
    (kind, elements): (ElementKind, usize),
    force: &Vector3<f64>,
    count: usize,
) -> Solution {
    let model = Model::new(&[BodyDescription { kind, elements, ..body.clone() }]);
    let mut work = Workspace::new(&model);
    let load = Wrench { force_n: *force, moment_n_m: Vector3::zeros() };
    let steps = if force.norm() > 0.0 { 5 } else { 1 };
    let q = equilibrium(&model, &mut work, &model.natural_coordinates(), &Loading::stations(vec![load]), steps);
    let zero = vec![0.0; q.len()];
    let motion = Motion { q: &q, v: &zero, a: &zero };
    let damping = [Damping::default()];
    let at = |i: usize| body.length_m * i as f64 / count as f64;
    let tip = &work.nodes[model.nodes.len() - 1];
    Solution {
        tip: tip.position,
        frame: tip.rotation,
        root_moment: -work.root_moment,
        measures: (0..=count).map(|i| strain_measures(&model, &work, motion, &damping, 0, at(i))).collect(),
    }
}

/// Errors against the reference: tip position divided by the length, rotation in rad, root moment relative to its magnitude, and the
/// largest error of a strain measure at `i L / count`, relative to the largest value of that measure.
pub fn errors(length_m: f64, found: &Solution, exact: &[Section]) -> [f64; 4] {
    let tip = exact.last().expect("sections");
    let turn = (tip.frame.transpose() * found.frame - Matrix3::identity()).norm() / 2f64.sqrt();
    let root = &exact[0].moment;
    let mut strain = 0.0f64;
    for i in 0..4 {
        let largest = exact.iter().map(|section| section.measures[i].abs()).fold(0.0, f64::max);
        let worst = exact.iter().zip(&found.measures).map(|(e, f)| (e.measures[i] - f[i]).abs()).fold(0.0, f64::max);
        strain = strain.max(if largest > 0.0 { worst / largest } else { 0.0 });
    }
    let moment = (found.root_moment - root).norm() / root.norm().max(f64::MIN_POSITIVE);
    [(found.tip - tip.position).norm() / length_m, turn, moment, strain]
}

/// Sections of the reference at the arc lengths `i L / count`.
pub fn reference(
    length_m: f64,
    stiffness: &dyn Fn(f64) -> Matrix4<f64>,
    curvature: &dyn Fn(f64) -> [f64; 3],
    force: &Vector3<f64>,
    count: usize,
) -> Vec<Section> {
    Rod { length_m, stiffness, curvature, steps: 1200 }.solve(force, count)
}
