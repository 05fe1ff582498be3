//! No-slip constraints: skates and wheels on a plane of the root frame, NOTATION eqs. (L45)–(L48).
//!
//! Their rows are linear in the velocity of the point of contact and, except for the row along the normal, not derivatives of functions of
//! the coordinates: they restrict velocities without restricting positions. At the level of accelerations they join the rows of the rigid
//! loops in `rigid_loop.rs`.

use crate::multibody::closure::Gap;
use crate::multibody::node::Node;
pub use crate::multibody::runner::{LEAST_SINE, NoSlip, NoSlipDescription, ROWS, Runner};
use crate::multibody::workspace::{Pair, Workspace};
use nalgebra::Vector3;

/// Point of contact with its frame, root frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// From the node to the point in m.
    pub arm_m: Vector3<f64>,
    /// Rate of that vector in m/s: for a wheel not that of the material point.
    pub arm_rate_m_s: Vector3<f64>,
    /// Directions of the rows: across the heading, along `normal × heading`; the heading; the normal.
    pub directions: [Vector3<f64>; ROWS],
    /// Rates of the directions in 1/s.
    pub direction_rates_1_s: [Vector3<f64>; ROWS],
}

/// Unit vector along `vector`, and its rate for the rate of `vector`.
fn unit(vector: &Vector3<f64>, rate: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let length = vector.norm();
    let unit = vector / length;
    (unit, (rate - unit * unit.dot(rate)) / length)
}

impl NoSlip {
    /// Rows that are constrained.
    pub fn active(&self) -> [bool; ROWS] {
        let rolls = match self.described.runner {
            Runner::Skate { .. } => false,
            Runner::Wheel { rolling, .. } => rolling,
        };
        [true, rolls, self.described.holds_normal]
    }

    /// Angle between the blade, or the axis of a wheel, and the normal of the plane in rad, from 0 to π/2, and its rate in rad/s.
    pub(crate) fn angle(&self, node: &Node) -> [f64; 2] {
        let (Runner::Skate { direction } | Runner::Wheel { axis: direction, .. }) = &self.described.runner;
        let (normal, direction) = (&self.described.normal, node.rotation * direction);
        let (across, along) = (direction.cross(normal), direction.dot(normal));
        let sine = across.norm();
        let rate = if sine > 0.0 { node.spin.dot(&across) / sine * along.signum() } else { 0.0 };
        [sine.atan2(along.abs()), -rate]
    }

    /// Point of contact and directions of the rows at the motion of a node, eqs. (L45), (L46).
    pub fn contact(&self, node: &Node) -> Contact {
        let normal = self.described.normal;
        let turned = |direction: &Vector3<f64>| {
            let direction = node.rotation * direction;
            (direction, node.spin.cross(&direction))
        };
        let (centre, centre_rate) = turned(&self.described.offset_m);
        let (side, side_rate, arm_m, arm_rate_m_s) = match &self.described.runner {
            Runner::Skate { direction } => {
                let (blade, blade_rate) = turned(direction);
                let (side, side_rate) = unit(&normal.cross(&blade), &normal.cross(&blade_rate));
                (side, side_rate, centre, centre_rate)
            }
            Runner::Wheel { axis, radius_m, .. } => {
                let (axis, axis_rate) = turned(axis);
                let (heading, heading_rate) = unit(&axis.cross(&normal), &axis_rate.cross(&normal));
                // from the point of contact to the centre
                let spoke = heading.cross(&axis);
                let spoke_rate = heading_rate.cross(&axis) + heading.cross(&axis_rate);
                let (arm_m, arm_rate_m_s) = (centre - spoke * *radius_m, centre_rate - spoke_rate * *radius_m);
                (normal.cross(&heading), normal.cross(&heading_rate), arm_m, arm_rate_m_s)
            }
        };
        Contact {
            arm_m,
            arm_rate_m_s,
            directions: [side, side.cross(&normal), normal],
            direction_rates_1_s: [side_rate, side_rate.cross(&normal), Vector3::zeros()],
        }
    }

    /// Gap of the rows at the motion of the last sweep, of the ground relative to the body: the position along the normal and the velocities
    /// along the directions, with their rates, eq. (L47). Rows that are not constrained are zero.
    pub fn gap(&self, work: &Workspace) -> Gap {
        let node = &work.nodes[self.node];
        let contact = self.contact(node);
        let velocity = node.velocity + node.spin.cross(&contact.arm_m);
        let acceleration =
            node.acceleration + node.spin_rate.cross(&contact.arm_m) + node.spin.cross(&contact.arm_rate_m_s);
        let mut gap =
            Gap { position_m: Vector3::zeros(), velocity_m_s: Vector3::zeros(), acceleration_m_s2: Vector3::zeros() };
        if self.described.holds_normal {
            gap.position_m[2] = -self.height_m(work);
        }
        for (row, _) in self.active().iter().enumerate().filter(|(_, active)| **active) {
            let (direction, rate) = (&contact.directions[row], &contact.direction_rates_1_s[row]);
            gap.velocity_m_s[row] = -direction.dot(&velocity);
            gap.acceleration_m_s2[row] = -direction.dot(&acceleration) - rate.dot(&velocity);
        }
        gap
    }

    /// Distance of the point of contact from the plane along its normal in m, at the poses of the last sweep.
    pub fn height_m(&self, work: &Workspace) -> f64 {
        let node = &work.nodes[self.node];
        (node.position + self.contact(node).arm_m).dot(&self.described.normal) - self.described.distance_m
    }

    /// Force on the body for multipliers of the rows in N, root frame.
    pub fn force_n(&self, contact: &Contact, multipliers: &Vector3<f64>) -> Vector3<f64> {
        let rows = self.active().into_iter().zip(&contact.directions).zip(multipliers.iter());
        rows.filter(|((active, _), _)| *active).map(|((_, direction), force_n)| direction * *force_n).sum()
    }

    /// Adds the forces on the body to its node; returns their wrench about the origin on the root, with the sign of the nodes' wrenches.
    pub(crate) fn apply(&self, work: &mut Workspace, multipliers: &Vector3<f64>) -> Pair {
        let node = &mut work.nodes[self.node];
        let contact = self.contact(node);
        let force = self.force_n(&contact, multipliers);
        node.add_fixed(&-force, &-contact.arm_m.cross(&force));
        Pair { linear: force, angular: (node.position + contact.arm_m).cross(&force) }
    }

    /// Adds a unit multiplier of a row to the wrenches in `work.bias`.
    pub(crate) fn load_unit(&self, work: &mut Workspace, row: usize) {
        let contact = self.contact(&work.nodes[self.node]);
        let force = contact.directions[row];
        work.bias[self.node].linear -= force;
        work.bias[self.node].angular -= contact.arm_m.cross(&force);
    }

    /// Changes of the rows due to the node displacements in `work.bias`.
    pub(crate) fn gap_change(&self, work: &Workspace) -> Vector3<f64> {
        let contact = self.contact(&work.nodes[self.node]);
        let change = work.bias[self.node].linear + work.bias[self.node].angular.cross(&contact.arm_m);
        let mut rows = Vector3::zeros();
        for (row, _) in self.active().iter().enumerate().filter(|(_, active)| **active) {
            rows[row] = -contact.directions[row].dot(&change);
        }
        rows
    }
}
