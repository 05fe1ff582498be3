//! Redundant parameters of universal, ball and free joints.
//!
//! A universal joint has nine direction cosines and seven constraints, a ball joint four Euler parameters and one constraint, a free joint
//! a position as well (\[O\] 16–21). The constraints are internal to the joint: in the recursions only the two, three or six true degrees
//! of freedom appear, and the parameters follow from them; NOTATION eqs. (J1)–(J6).

use crate::math::so3::hat;
use crate::multibody::joint::JointKind;
use nalgebra::{Matrix3, SMatrix, UnitQuaternion, Vector3};

/// Maximum number of parameters of any joint.
pub const MAX_PARAMETERS: usize = 9;

impl JointKind {
    /// Index of the first Euler parameter among the joint's parameters.
    fn quaternion_start(&self) -> usize {
        if self.floats() { 3 } else { 0 }
    }

    /// Parameters of an attitude (parent ← body), with no offset.
    pub fn parameters_of(&self, rotation: &Matrix3<f64>) -> [f64; MAX_PARAMETERS] {
        let mut eta = [0.0; MAX_PARAMETERS];
        if let Self::Universal { .. } = self {
            eta.copy_from_slice(rotation.as_slice());
        } else {
            let rotation = nalgebra::Rotation3::from_matrix_unchecked(*rotation);
            let quaternion = UnitQuaternion::from_rotation_matrix(&rotation);
            let start = self.quaternion_start();
            eta[start..start + 4].copy_from_slice(&[quaternion.w, quaternion.i, quaternion.j, quaternion.k]);
        }
        eta
    }

    /// Rates of the parameters at an attitude that rotates with `spin` (rad/s, parent's frame).
    pub fn parameter_rates(&self, eta: &[f64], spin: &Vector3<f64>) -> [f64; MAX_PARAMETERS] {
        let mut rates = [0.0; MAX_PARAMETERS];
        let pose = JointPose::new(self, eta);
        for (rate, row) in rates.iter_mut().zip(pose.parameter_map.row_iter()) {
            *rate = (row * spin)[0];
        }
        rates
    }
}

/// `E(ζ)`: maps rates of Euler parameters to the angular velocity in the parent's frame, `ω = 2Eζ̇/ζ·ζ`, eq. (J2).
pub(crate) fn euler_map(zeta: &[f64]) -> SMatrix<f64, 3, 4> {
    let [w, x, y, z] = [zeta[0], zeta[1], zeta[2], zeta[3]];
    SMatrix::<f64, 3, 4>::new(-x, w, -z, y, -y, z, w, -x, -z, -y, x, w)
}

/// Attitude of a joint and the maps between its parameters and its degrees of freedom, parent's frame.
#[derive(Debug, Clone, Copy)]
pub struct JointPose {
    /// Attitude, parent ← body.
    pub rotation: Matrix3<f64>,
    /// Offset of the body's inner end in m; zero except for free joints.
    pub offset_m: Vector3<f64>,
    /// Rotation axes of the degrees of freedom, as columns: two for a universal joint (the third is zero), otherwise unit vectors.
    pub axes: Matrix3<f64>,
    /// Axis of the rotation that only the axis constraint of a universal joint prevents; zero for the others.
    pub constraint_axis: Vector3<f64>,
    /// Angular velocity per rate of the parameters.
    pub spin_map: SMatrix<f64, 3, MAX_PARAMETERS>,
    /// Rates of the parameters per angular velocity, with satisfied constraints.
    pub parameter_map: SMatrix<f64, MAX_PARAMETERS, 3>,
    /// Parameters of the joint.
    pub eta: [f64; MAX_PARAMETERS],
}

impl JointPose {
    /// Pose from the parameters, which may violate their constraints by the error of a step: the rotation is orthonormal up to the square
    /// of that error.
    pub fn new(kind: &JointKind, parameters: &[f64]) -> Self {
        let mut eta = [0.0; MAX_PARAMETERS];
        eta[..parameters.len()].copy_from_slice(parameters);
        match kind {
            JointKind::Universal { parent_axis, body_axis, .. } => Self::universal(parent_axis, body_axis, eta),
            JointKind::Clamped
            | JointKind::Revolute { .. }
            | JointKind::Prismatic { .. }
            | JointKind::Sliding
            | JointKind::Ball
            | JointKind::Free => Self::spherical(kind, eta),
        }
    }

    fn universal(parent_axis: &Vector3<f64>, body_axis: &Vector3<f64>, eta: [f64; MAX_PARAMETERS]) -> Self {
        let cosines = Matrix3::from_column_slice(&eta);
        // one step of Newton's iteration for the polar decomposition
        let rotation = cosines * (Matrix3::identity() * 3.0 - cosines.transpose() * cosines) * 0.5;
        let turned = rotation * body_axis;
        let mut spin_map = SMatrix::<f64, 3, MAX_PARAMETERS>::zeros();
        let mut parameter_map = SMatrix::<f64, MAX_PARAMETERS, 3>::zeros();
        for a in 0..3 {
            let cross = hat(&cosines.column(a).into_owned());
            spin_map.fixed_view_mut::<3, 3>(0, 3 * a).copy_from(&(cross * 0.5));
            parameter_map.fixed_view_mut::<3, 3>(3 * a, 0).copy_from(&-cross);
        }
        Self {
            rotation,
            offset_m: Vector3::zeros(),
            axes: Matrix3::from_columns(&[*parent_axis, turned, Vector3::zeros()]),
            constraint_axis: turned.cross(parent_axis).normalize(),
            spin_map,
            parameter_map,
            eta,
        }
    }

    fn spherical(kind: &JointKind, eta: [f64; MAX_PARAMETERS]) -> Self {
        let start = kind.quaternion_start();
        let zeta = &eta[start..start + 4];
        let square: f64 = zeta.iter().map(|z| z * z).sum();
        let [w, x, y, z] = [zeta[0], zeta[1], zeta[2], zeta[3]];
        let vector = Vector3::new(x, y, z);
        let rotation = (Matrix3::identity() * (w * w - vector.norm_squared())
            + vector * vector.transpose() * 2.0
            + hat(&vector) * (2.0 * w))
            / square;
        let map = euler_map(zeta);
        let mut spin_map = SMatrix::<f64, 3, MAX_PARAMETERS>::zeros();
        let mut parameter_map = SMatrix::<f64, MAX_PARAMETERS, 3>::zeros();
        spin_map.fixed_view_mut::<3, 4>(0, start).copy_from(&(map * (2.0 / square)));
        parameter_map.fixed_view_mut::<4, 3>(start, 0).copy_from(&(map.transpose() * 0.5));
        let offset_m = if start == 3 { Vector3::new(eta[0], eta[1], eta[2]) } else { Vector3::zeros() };
        Self {
            rotation,
            offset_m,
            axes: Matrix3::identity(),
            constraint_axis: Vector3::zeros(),
            spin_map,
            parameter_map,
            eta,
        }
    }

    /// Angular velocity and, at the given second time derivatives of the parameters, angular acceleration of the body, parent's frame, eq. (J3).
    pub fn spin(&self, kind: &JointKind, rates: &[f64], second: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
        let spin = apply(&self.spin_map, rates);
        let mut spin_rate = apply(&self.spin_map, second);
        if !matches!(kind, JointKind::Universal { .. }) {
            let start = kind.quaternion_start();
            let (zeta, zeta_rate) = (&self.eta[start..start + 4], &rates[start..start + 4]);
            spin_rate -= spin * (2.0 * dot(zeta, zeta_rate) / dot(zeta, zeta));
        }
        (spin, spin_rate)
    }

    /// Residual of the constraints at the level of accelerations, eq. (J4): zero if the second time derivatives of the parameters satisfy
    /// them.
    pub fn constraint_residual(&self, kind: &JointKind, rates: &[f64], second: &[f64], residual: &mut [f64]) {
        let JointKind::Universal { parent_axis, body_axis, .. } = kind else {
            let start = kind.quaternion_start();
            let (zeta, rate, second) =
                (&self.eta[start..start + 4], &rates[start..start + 4], &second[start..start + 4]);
            residual[0] = dot(zeta, second) + dot(rate, rate);
            return;
        };
        let (m, m1, m2) = (&self.eta, rates, second);
        let column = |matrix: &[f64], a: usize| Vector3::from_column_slice(&matrix[3 * a..3 * a + 3]);
        for (row, (a, b)) in UNIVERSAL_PAIRS.into_iter().enumerate() {
            let weight = if a == b { 0.5 } else { 1.0 };
            residual[row] = weight
                * (column(m, a).dot(&column(m2, b))
                    + column(m, b).dot(&column(m2, a))
                    + 2.0 * column(m1, a).dot(&column(m1, b)));
        }
        residual[6] = (0..3).map(|a| body_axis[a] * parent_axis.dot(&column(m2, a))).sum();
    }

    /// Change of the parameters from the change of attitude `turn` (parent's frame) and from the right-hand side of the constraints; eq.
    /// (J5).
    pub fn parameter_change(&self, kind: &JointKind, turn: &Vector3<f64>, constraint: &[f64]) -> [f64; MAX_PARAMETERS] {
        let mut change = [0.0; MAX_PARAMETERS];
        for (change, row) in change.iter_mut().zip(self.parameter_map.row_iter()) {
            *change = (row * turn)[0];
        }
        if let JointKind::Universal { .. } = kind {
            let cosines = Matrix3::from_column_slice(&self.eta);
            let stretched = cosines * symmetric(constraint);
            for (change, stretch) in change.iter_mut().zip(stretched.iter()) {
                *change += stretch;
            }
        } else {
            let start = kind.quaternion_start();
            let zeta = &self.eta[start..start + 4];
            let scale = constraint[0] / dot(zeta, zeta);
            for (change, zeta) in change[start..start + 4].iter_mut().zip(zeta) {
                *change += zeta * scale;
            }
        }
        change
    }

    /// Rotation about [`Self::constraint_axis`] required by the right-hand side of a universal joint's constraint; otherwise 0.
    pub fn constraint_turn(&self, kind: &JointKind, constraint: &[f64]) -> f64 {
        let JointKind::Universal { parent_axis, body_axis, .. } = kind else { return 0.0 };
        let cosines = Matrix3::from_column_slice(&self.eta);
        let stretched = cosines * symmetric(constraint) * body_axis;
        let lever = self.axes.column(1).cross(parent_axis).norm();
        (constraint[6] - parent_axis.dot(&stretched)) / lever
    }
}

/// Columns coupled by each orthonormality constraint of a universal joint, \[O\] (18).
pub(crate) const UNIVERSAL_PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

/// Symmetric matrix of the orthonormality right-hand sides, with halved off-diagonal entries.
fn symmetric(constraint: &[f64]) -> Matrix3<f64> {
    let mut matrix = Matrix3::zeros();
    for (row, (a, b)) in UNIVERSAL_PAIRS.into_iter().enumerate() {
        let share = if a == b { 1.0 } else { 0.5 };
        matrix[(a, b)] = share * constraint[row];
        matrix[(b, a)] = share * constraint[row];
    }
    matrix
}

/// Projects parameters with their first and second time derivatives onto the constraints, eq. (J6): the attitude to the nearest attitude that the
/// joint allows, angular velocity and acceleration to their allowed components.
pub fn project(kind: &JointKind, eta: &mut [f64], rates: &mut [f64], second: &mut [f64]) {
    if let JointKind::Universal { .. } = kind {
        project_universal(kind, eta, rates, second);
        return;
    }
    let start = kind.quaternion_start();
    let (zeta, rate, second) =
        (&mut eta[start..start + 4], &mut rates[start..start + 4], &mut second[start..start + 4]);
    let norm = dot(zeta, zeta).sqrt();
    zeta.iter_mut().for_each(|z| *z /= norm);
    remove(rate, zeta, dot(zeta, rate));
    let excess = dot(zeta, second) + dot(rate, rate);
    remove(second, zeta, excess);
}

fn project_universal(kind: &JointKind, eta: &mut [f64], rates: &mut [f64], second: &mut [f64]) {
    let JointKind::Universal { parent_axis, body_axis, cosine } = kind else { return };
    let before = JointPose::new(kind, eta);
    let (spin, spin_rate) = before.spin(kind, rates, second);
    let mut rotation = before.rotation;
    for _ in 0..3 {
        rotation = rotation * (Matrix3::identity() * 3.0 - rotation.transpose() * rotation) * 0.5;
        let turned = rotation * body_axis;
        let lever = turned.cross(parent_axis);
        // rotate about the constraint axis until the angle between the axes has its initial value
        let error = parent_axis.dot(&turned) - cosine;
        rotation = crate::math::so3::rotation_about(&lever.normalize(), -error / lever.norm()) * rotation;
    }
    let turned = rotation * body_axis;
    let across = turned.cross(parent_axis);
    let normal = across.normalize();
    let spin = spin - normal * normal.dot(&spin);
    let bent = -parent_axis.dot(&spin.cross(&spin.cross(&turned))) / across.norm();
    let spin_rate = spin_rate + normal * (bent - normal.dot(&spin_rate));
    let turn = hat(&spin);
    eta.copy_from_slice(rotation.as_slice());
    rates.copy_from_slice((turn * rotation).as_slice());
    second.copy_from_slice(((hat(&spin_rate) + turn * turn) * rotation).as_slice());
}

fn remove(vector: &mut [f64], direction: &[f64], amount: f64) {
    vector.iter_mut().zip(direction).for_each(|(v, d)| *v -= amount * d);
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn apply(map: &SMatrix<f64, 3, MAX_PARAMETERS>, rates: &[f64]) -> Vector3<f64> {
    let mut sum = Vector3::zeros();
    for (i, rate) in rates.iter().enumerate() {
        sum += map.column(i) * *rate;
    }
    sum
}
