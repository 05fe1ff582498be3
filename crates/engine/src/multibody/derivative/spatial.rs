//! Universal, ball and free joints at the point of linearisation, NOTATION eqs. (X24)–(X26).
//!
//! Their coordinates are redundant parameters `η`, their rows the forces on the degrees of freedom and the constraints (J4): rows and columns differ.

use crate::math::so3::hat;
use crate::multibody::derivative::chain::{Shift, second};
use crate::multibody::joint::parameters::{JointPose, MAX_PARAMETERS, UNIVERSAL_PAIRS, euler_map};
use crate::multibody::joint::{Joint, JointKind, RedundantWork};
use crate::multibody::kinematics::Motion;
use crate::multibody::model::{Base, Body};
use crate::multibody::workspace::{Node, Workspace};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use std::ops::Range;

/// Three components per parameter.
pub(super) type Columns = SMatrix<f64, 3, MAX_PARAMETERS>;
/// Rows per parameter.
type Square = SMatrix<f64, MAX_PARAMETERS, MAX_PARAMETERS>;
type Parameters = SVector<f64, MAX_PARAMETERS>;

/// Slopes of a joint's rotation, angular velocity and angular acceleration in the parent's frame, eq. (X24).
#[derive(Debug, Clone, Copy)]
struct Turning {
    /// Of the rotation, by the parameters.
    turn: Columns,
    /// Of the angular velocity, by the parameters and their rates.
    spin: [Columns; 2],
    /// Of the angular acceleration, by the parameters, their rates and their second derivatives.
    spin_rate: [Columns; 3],
}

/// A joint with redundant parameters at the point of linearisation.
#[derive(Debug, Clone)]
pub(super) struct SpatialBlock {
    /// Body that it carries.
    pub body: usize,
    /// Parameters of the joint.
    pub joint: Joint,
    /// First node of the body.
    pub node: usize,
    /// Node that carries the joint; `None` on the root.
    pub carrier: Option<usize>,
    /// Slopes of the rotation and of the angular velocity in the parent's frame.
    turn: Columns,
    spin: [Columns; 2],
    /// Variation of the rotation with its two time derivatives (first index) by the parameters with theirs (second index), root frame.
    by: [[Columns; 3]; 3],
    /// Axes of the rotations among the degrees of freedom, root frame.
    axes: Matrix3<f64>,
    /// Slopes of their torques by a rotation of the parent, as columns.
    turned: Matrix3<f64>,
    /// Slopes of the rows with respect to the parameters with their derivatives, in addition to those through the wrench and the parent's rotation.
    own: [Square; 3],
    /// Parameters by rows: `η = D x` of eq. (X26), and its inverse.
    pub(super) maps: [Square; 2],
}

impl SpatialBlock {
    /// For a body whose joint has redundant parameters; `None` for others.
    pub fn of_body(index: usize, body: &Body) -> Option<Self> {
        let carrier = match body.base {
            Base::Root(_) => None,
            Base::Node(node) => Some(node),
            Base::Axis(_) => return None,
        };
        body.joint.kind.is_redundant().then(|| Self {
            body: index,
            joint: body.joint,
            node: body.first_node,
            carrier,
            turn: Columns::zeros(),
            spin: [Columns::zeros(); 2],
            by: [[Columns::zeros(); 3]; 3],
            axes: Matrix3::zeros(),
            turned: Matrix3::zeros(),
            own: [Square::zeros(); 3],
            maps: [Square::identity(); 2],
        })
    }

    /// Linearises the joint at the motions and wrenches in `work`.
    pub fn prepare(&mut self, work: &Workspace, motion: Motion) {
        let Some(at) = work.joints[self.body].redundant() else { return };
        let kind = &self.joint.kind;
        let [rates, seconds] = [motion.v, motion.a].map(|all| &all[self.joint.range()]);
        let slopes = match kind {
            JointKind::Universal { .. } => universal(at, rates, seconds),
            JointKind::Clamped
            | JointKind::Revolute { .. }
            | JointKind::Prismatic { .. }
            | JointKind::Sliding
            | JointKind::Ball
            | JointKind::Free => spherical(kind, at, rates, seconds),
        };
        (self.turn, self.spin) = (slopes.turn, slopes.spin);
        let (spin, spin_rate) = at.pose.spin(kind, rates, seconds);
        self.by = in_root(self.carrier.map(|node| &work.nodes[node]), local(&slopes, &spin, &spin_rate));
        let node = &work.nodes[self.node];
        self.axes = at.axes;
        self.turned = Matrix3::zeros();
        self.own = constraint_slopes(kind, at, rates, seconds);
        if kind.transmits() {
            for k in 0..kind.freedoms() {
                self.turned.set_column(k, &at.axes.column(k).cross(&node.moment));
            }
        }
        if let JointKind::Universal { .. } = kind {
            // the second axis rotates with the body
            let row = self.turned.column(1).transpose() * self.by[0][0];
            for k in 0..kind.coordinates() {
                self.own[0][(1, k)] += row[k];
            }
        }
        self.maps = maps(kind, at);
    }

    /// Adds torques on the degrees of freedom, whose slopes by the joint's rotation and angular velocity in the parent's frame are given.
    pub fn add_torques(&mut self, by_turn: &Matrix3<f64>, by_spin: &Matrix3<f64>) {
        let of_parameters = by_turn * self.turn + by_spin * self.spin[0];
        let of_rates = by_spin * self.spin[1];
        for row in 0..self.joint.kind.freedoms().min(3) {
            for k in 0..self.joint.kind.coordinates() {
                self.own[0][(row, k)] += of_parameters[(row, k)];
                self.own[1][(row, k)] += of_rates[(row, k)];
            }
        }
    }

    /// Rows of the torques.
    fn torques(&self) -> Range<usize> {
        let first = self.joint.coordinate + if self.joint.kind.floats() { 3 } else { 0 };
        first..self.joint.coordinate + self.joint.kind.freedoms()
    }

    fn of(&self, all: &[f64]) -> Parameters {
        let mut own = Parameters::zeros();
        own.as_mut_slice()[..self.joint.kind.coordinates()].copy_from_slice(&all[self.joint.range()]);
        own
    }

    fn add_to(&self, own: &Parameters, all: &mut [f64]) {
        all[self.joint.range()].iter_mut().zip(own.iter()).for_each(|(all, own)| *all += own);
    }

    /// Adds the effect of variations of the parameters on the body's first node.
    pub fn move_node(&self, along: Motion, shift: &mut Shift) {
        let parts = [along.q, along.v, along.a].map(|all| self.of(all));
        for (sum, by) in shift.angular.iter_mut().zip(&self.by) {
            for (by, part) in by.iter().zip(&parts) {
                *sum += by * part;
            }
        }
        if self.joint.kind.floats() {
            for (sum, part) in shift.linear.iter_mut().zip(&parts) {
                *sum += part.fixed_rows::<3>(0);
            }
        }
    }

    /// Adds the multipliers of the parameters with their derivatives: the transpose of [`Self::move_node`].
    pub fn pull(&self, on: &Shift, sums: [&mut [f64]; 3]) {
        for (k, sum) in sums.into_iter().enumerate() {
            let mut own = Parameters::zeros();
            for (by, on) in self.by.iter().zip(&on.angular) {
                own += by[k].tr_mul(on);
            }
            if self.joint.kind.floats() {
                let mut linear = own.fixed_rows_mut::<3>(0);
                linear += on.linear[k];
            }
            self.add_to(&own, sum);
        }
    }

    /// Adds the variations of the rows due to that of the wrench, of the parent's rotation and of the parameters.
    pub fn add_rows(&self, [force, moment]: &[Vector3<f64>; 2], turn: &Vector3<f64>, along: Motion, rows: &mut [f64]) {
        let mut own = Parameters::zeros();
        for (slopes, part) in self.own.iter().zip([along.q, along.v, along.a]) {
            own += slopes * self.of(part);
        }
        self.add_to(&own, rows);
        if self.joint.kind.floats() {
            let c = self.joint.coordinate;
            rows[c..c + 3].iter_mut().zip(force.iter()).for_each(|(row, force)| *row += force);
            rows[c + 3..c + 6].iter_mut().zip(moment.iter()).for_each(|(row, moment)| *row += moment);
            return;
        }
        for (k, row) in self.torques().enumerate() {
            rows[row] += self.axes.column(k).dot(moment) + self.turned.column(k).dot(turn);
        }
    }

    /// Adds the projection of a wrench on the body's first node on the rows.
    pub fn project(&self, [force, moment]: &[Vector3<f64>; 2], rows: &mut [f64]) {
        if self.joint.kind.floats() {
            let own = &mut rows[self.joint.coordinate..][..6];
            own.iter_mut().zip(force.iter().chain(moment.iter())).for_each(|(row, entry)| *row += entry);
            return;
        }
        for (k, row) in self.torques().enumerate() {
            rows[row] += self.axes.column(k).dot(moment);
        }
    }

    /// Displacement and rotation of the body's first node of multipliers of the rows, and the multiplier of the parent's rotation; adds
    /// those of the parameters. The transpose of [`Self::add_rows`].
    pub fn pull_rows(&self, w: &[f64], sums: [&mut [f64]; 3]) -> [Vector3<f64>; 3] {
        let own = self.of(w);
        for (slopes, sum) in self.own.iter().zip(sums) {
            self.add_to(&slopes.tr_mul(&own), sum);
        }
        let [mut moved, mut turn, mut by_turn] = [Vector3::zeros(); 3];
        if self.joint.kind.floats() {
            moved += own.fixed_rows::<3>(0);
            turn += own.fixed_rows::<3>(3);
            return [moved, turn, by_turn];
        }
        for (k, row) in self.torques().enumerate() {
            turn += self.axes.column(k) * w[row];
            by_turn += self.turned.column(k) * w[row];
        }
        [moved, turn, by_turn]
    }

    /// Multiplies the joint's entries by one of the maps of eq. (X26), or by its transpose.
    pub fn apply(&self, map: &Square, transposed: bool, all: &mut [f64]) {
        let own = self.of(all);
        let new = if transposed { map.tr_mul(&own) } else { map * own };
        all[self.joint.range()].iter_mut().zip(new.iter()).for_each(|(all, new)| *all = *new);
    }
}

/// Columns of a joint with Euler parameters: its rotation is one for any length of them.
fn spherical(kind: &JointKind, at: &RedundantWork, rates: &[f64], seconds: &[f64]) -> Turning {
    let start = if kind.floats() { 3 } else { 0 };
    let part = |all: &[f64]| nalgebra::Vector4::from_column_slice(&all[start..start + 4]);
    let (zeta, rate, second) = (part(&at.pose.eta), part(rates), part(seconds));
    let square = zeta.norm_squared();
    let map = |of: &nalgebra::Vector4<f64>| euler_map(of.as_slice()) * (2.0 / square);
    // share of the rate of the square, and the slopes of shares
    let stretch = 2.0 * zeta.dot(&rate) / square;
    let (by_zeta, by_rate) = (zeta * (2.0 / square), rate * (2.0 / square));
    let own = map(&zeta);
    let spin = own * rate;
    let of_second = own * second;
    let spin_by = -map(&rate) - spin * by_zeta.transpose();
    let rate_by_rate = own * -stretch - spin * by_zeta.transpose();
    let rate_by = -map(&second)
        - of_second * by_zeta.transpose()
        - spin_by * stretch
        - spin * (by_rate - by_zeta * stretch).transpose();
    let wide = |of: &SMatrix<f64, 3, 4>| {
        let mut columns = Columns::zeros();
        columns.fixed_view_mut::<3, 4>(0, start).copy_from(of);
        columns
    };
    Turning {
        turn: wide(&own),
        spin: [wide(&spin_by), wide(&own)],
        spin_rate: [wide(&rate_by), wide(&rate_by_rate), wide(&own)],
    }
}

/// Columns of a universal joint, whose parameters are the direction cosines.
fn universal(at: &RedundantWork, rates: &[f64], seconds: &[f64]) -> Turning {
    let cosines = Matrix3::from_column_slice(&at.pose.eta);
    let column = |all: &[f64], a: usize| Vector3::from_column_slice(&all[3 * a..3 * a + 3]);
    let rotation = &at.pose.rotation;
    let gram = Matrix3::identity() * 3.0 - cosines.tr_mul(&cosines);
    let mut turn = Columns::zeros();
    let [mut by_rates, mut by_seconds] = [Columns::zeros(); 2];
    for k in 0..MAX_PARAMETERS {
        let a = k / 3;
        let mut change = Matrix3::zeros();
        change[(k % 3, a)] = 1.0;
        let symmetric = change.tr_mul(&cosines) + cosines.tr_mul(&change);
        let turned = (change * gram - cosines * symmetric) * 0.5;
        let axial = (0..3).fold(Vector3::zeros(), |sum, b| sum + rotation.column(b).cross(&turned.column(b)));
        turn.set_column(k, &(axial * 0.5));
        let unit: Vector3<f64> = Vector3::ith(k % 3, 0.5);
        by_rates.set_column(k, &unit.cross(&column(rates, a)));
        by_seconds.set_column(k, &unit.cross(&column(seconds, a)));
    }
    let map = at.pose.spin_map;
    Turning { turn, spin: [by_rates, map], spin_rate: [by_seconds, Columns::zeros(), map] }
}

/// Variation of the rotation with its two time derivatives, by the parameters with theirs, in the parent's frame, eq. (X24).
fn local(slopes: &Turning, spin: &Vector3<f64>, spin_rate: &Vector3<f64>) -> [[Columns; 3]; 3] {
    let Turning { turn, spin: [spin_by, spin_by_rates], spin_rate: [rate_by, rate_by_rates, rate_by_seconds] } = slopes;
    let (across, across_rate) = (hat(spin), hat(spin_rate));
    let first = spin_by + across * turn;
    let zero = Columns::zeros();
    [
        [*turn, zero, zero],
        [first, *spin_by_rates, zero],
        [rate_by + across_rate * turn + across * first, rate_by_rates + across * spin_by_rates, *rate_by_seconds],
    ]
}

/// The same in the root frame.
fn in_root(parent: Option<&Node>, local: [[Columns; 3]; 3]) -> [[Columns; 3]; 3] {
    let Some(parent) = parent else { return local };
    let turned = local.map(|row| row.map(|columns| parent.rotation * columns));
    let (spin, second) = (hat(&parent.spin), second(parent));
    let [own, first, twice] = &turned;
    let each = |of: &dyn Fn(usize) -> Columns| [of(0), of(1), of(2)];
    [*own, each(&|k| first[k] + spin * own[k]), each(&|k| twice[k] + spin * first[k] * 2.0 + second * own[k])]
}

/// Slopes of the constraints with respect to the parameters with their derivatives.
fn constraint_slopes(kind: &JointKind, at: &RedundantWork, rates: &[f64], seconds: &[f64]) -> [Square; 3] {
    let mut own = [Square::zeros(); 3];
    let first = kind.freedoms();
    let eta = &at.pose.eta;
    let JointKind::Universal { parent_axis, body_axis, .. } = kind else {
        let start = if kind.floats() { 3 } else { 0 };
        for k in start..start + 4 {
            own[0][(first, k)] = seconds[k];
            own[1][(first, k)] = 2.0 * rates[k];
            own[2][(first, k)] = eta[k];
        }
        return own;
    };
    for (row, (a, b)) in UNIVERSAL_PAIRS.into_iter().enumerate() {
        let weight = if a == b { 0.5 } else { 1.0 };
        for k in 0..3 {
            for (own_column, other) in [(3 * a + k, 3 * b + k), (3 * b + k, 3 * a + k)] {
                own[0][(first + row, own_column)] += weight * seconds[other];
                own[1][(first + row, own_column)] += weight * 2.0 * rates[other];
                own[2][(first + row, own_column)] += weight * eta[other];
            }
        }
    }
    for a in 0..3 {
        for k in 0..3 {
            own[2][(first + 6, 3 * a + k)] = body_axis[a] * parent_axis[k];
        }
    }
    own
}

/// Converts forces on the degrees of freedom of a joint with redundant parameters, which come first among its entries of `on`, to
/// multipliers of its parameters, `D⁻ᵀ` of eq. (X26), in place: the transpose of [`to_freedoms`]. `at` is the joint at its pose.
pub fn to_multipliers(joint: &Joint, at: &RedundantWork, on: &mut [f64]) {
    let [_, back] = maps(&joint.kind, at);
    let own = &mut on[joint.range()];
    own[joint.kind.freedoms()..].fill(0.0);
    let mut forces = Parameters::zeros();
    forces.as_mut_slice()[..own.len()].copy_from_slice(own);
    own.iter_mut().zip(&back.tr_mul(&forces)).for_each(|(own, new)| *own = *new);
}

/// Converts changes of the parameters of a joint to changes of its degrees of freedom, `D⁻¹` of eq. (X26), in place; the constraints have zeros.
pub fn to_freedoms(joint: &Joint, at: &RedundantWork, change: &mut [f64]) {
    let [_, back] = maps(&joint.kind, at);
    let own = &mut change[joint.range()];
    let mut parameters = Parameters::zeros();
    parameters.as_mut_slice()[..own.len()].copy_from_slice(own);
    own.iter_mut().zip(&(back * parameters)).for_each(|(own, new)| *own = *new);
    own[joint.kind.freedoms()..].fill(0.0);
}

/// Converts changes of the degrees of freedom of a joint to changes of its parameters that turn its body by them, in place, for parameters that
/// do not fulfil the constraints either.
pub fn to_turning(joint: &Joint, at: &RedundantWork, change: &mut [f64]) {
    let shift = joint.kind.translations();
    let own = &mut change[joint.range()];
    let mut turn = Vector3::zeros();
    for k in 0..joint.kind.freedoms() - shift {
        let axis = if shift == 3 { Vector3::ith(k, 1.0) } else { at.axes.column(k).into_owned() };
        turn += axis * own[shift + k];
    }
    let map = &at.pose.spin_map;
    // three rotations are independent
    let within = (map * map.transpose()).try_inverse().unwrap_or_else(Matrix3::identity) * at.parent.tr_mul(&turn);
    own[shift..].iter_mut().zip(map.tr_mul(&within).iter().skip(shift)).for_each(|(own, new)| *own = *new);
}

/// `D` of eq. (X26) and its inverse.
fn maps(kind: &JointKind, at: &RedundantWork) -> [Square; 2] {
    let (freedoms, count) = (kind.freedoms(), kind.coordinates());
    let pose: &JointPose = &at.pose;
    let mut to_parameters = Square::identity();
    let none = [0.0; MAX_PARAMETERS];
    for row in 0..count {
        let mut constraint = none;
        let shift = if kind.floats() { 3 } else { 0 };
        let turn = match row {
            row if row < shift => continue,
            // axes in the parent's frame; on the root they are those of the root frame
            row if row < freedoms => pose.axes.column(row - shift).into_owned(),
            row => {
                constraint[row - freedoms] = 1.0;
                pose.constraint_axis * pose.constraint_turn(kind, &constraint)
            }
        };
        let mut column = pose.parameter_change(kind, &turn, &constraint);
        column[..shift].fill(0.0);
        to_parameters.set_column(row, &Parameters::from_column_slice(&column));
    }
    let back = to_parameters.try_inverse().unwrap_or_else(Square::identity);
    [to_parameters, back]
}
