//! No-slip constraints: skates and wheels on a plane of the root frame, NOTATION eqs. (L45)–(L48).
//!
//! Their rows are linear in the velocity of the point of contact and, except for the row along the normal, not derivatives of functions of
//! the coordinates: they restrict velocities without restricting positions. At the level of accelerations they join the rows of the rigid
//! loops in `rigid_loop.rs`.

use crate::math::jet::{self, Jet, Vector, cross, dot, plus, three};
use crate::multibody::closure::Gap;
use crate::multibody::node::Node;
pub use crate::multibody::runner::{LEAST_SINE, NoSlip, NoSlipDescription, ROWS, Runner};
use crate::multibody::workspace::{Pair, Workspace};
use nalgebra::Vector3;

/// Motion of a node in jets, root frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NodeMotion<J> {
    /// Position in m.
    pub position: Vector<J>,
    /// Velocity in m/s.
    pub velocity: Vector<J>,
    /// Acceleration in m/s².
    pub acceleration: Vector<J>,
    /// Angular velocity in rad/s.
    pub spin: Vector<J>,
    /// Angular acceleration in rad/s².
    pub spin_rate: Vector<J>,
    /// Columns of the rotation matrix, root ← node.
    pub axes: [Vector<J>; 3],
}

impl NodeMotion<f64> {
    fn of(node: &Node) -> Self {
        Self {
            position: node.position.into(),
            velocity: node.velocity.into(),
            acceleration: node.acceleration.into(),
            spin: node.spin.into(),
            spin_rate: node.spin_rate.into(),
            axes: node.rotation.into(),
        }
    }
}

impl<J: Jet> NodeMotion<J> {
    /// A vector fixed to the node, and its rate.
    fn turned(&self, fixed: &Vector3<f64>) -> [Vector<J>; 2] {
        let vector = jet::turned(&self.axes, &constants(fixed));
        [vector, cross(self.spin, vector)]
    }
}

/// Point of contact with its frame in jets, root frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Contact<J> {
    /// From the node to the point in m.
    arm_m: Vector<J>,
    /// Rate of that vector in m/s: for a wheel not that of the material point.
    arm_rate_m_s: Vector<J>,
    /// Directions of the rows: across the heading, along `normal × heading`; the heading; the normal.
    directions: [Vector<J>; ROWS],
    /// Rates of the directions in 1/s.
    direction_rates_1_s: [Vector<J>; ROWS],
}

fn constants<J: Jet>(vector: &Vector3<f64>) -> Vector<J> {
    three(|axis| J::constant(vector[axis]))
}

fn minus<J: Jet>(a: Vector<J>, b: Vector<J>) -> Vector<J> {
    three(|axis| a[axis] - b[axis])
}

fn scaled<J: Jet>(vector: Vector<J>, factor: J) -> Vector<J> {
    vector.map(|entry| entry * factor)
}

/// Unit vector along `vector`, and its rate for the rate of `vector`.
fn unit<J: Jet>(vector: Vector<J>, rate: Vector<J>) -> [Vector<J>; 2] {
    let square = dot(&vector, &vector);
    let root = square.value().sqrt();
    let inverse = square.composed([1.0 / root, -0.5 / root.powi(3), 0.75 / root.powi(5)]);
    let unit = scaled(vector, inverse);
    [unit, scaled(minus(rate, scaled(unit, dot(&unit, &rate))), inverse)]
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
    fn contact<J: Jet>(&self, node: &NodeMotion<J>) -> Contact<J> {
        let normal = constants(&self.described.normal);
        let [centre, centre_rate] = node.turned(&self.described.offset_m);
        let ([side, side_rate], arm_m, arm_rate_m_s) = match &self.described.runner {
            Runner::Skate { direction } => {
                let [blade, blade_rate] = node.turned(direction);
                (unit(cross(normal, blade), cross(normal, blade_rate)), centre, centre_rate)
            }
            Runner::Wheel { axis, radius_m, .. } => {
                let [axis, axis_rate] = node.turned(axis);
                let [heading, heading_rate] = unit(cross(axis, normal), cross(axis_rate, normal));
                // from the point of contact to the centre
                let spoke = cross(heading, axis);
                let spoke_rate = plus(cross(heading_rate, axis), cross(heading, axis_rate));
                let radius = |spoke: Vector<J>| spoke.map(|entry| entry.times(*radius_m));
                let side = [cross(normal, heading), cross(normal, heading_rate)];
                (side, minus(centre, radius(spoke)), minus(centre_rate, radius(spoke_rate)))
            }
        };
        Contact {
            arm_m,
            arm_rate_m_s,
            directions: [side, cross(side, normal), normal],
            direction_rates_1_s: [side_rate, cross(side_rate, normal), [J::ZERO; 3]],
        }
    }

    /// Rows of the gap, its rates and its accelerations at the motion of a node, of the ground relative to the body: the position along the
    /// normal and the velocities along the directions, with their rates, eq. (L47). Rows that are not constrained are zero.
    pub(crate) fn rows<J: Jet>(&self, node: &NodeMotion<J>) -> [Vector<J>; 3] {
        let contact = self.contact(node);
        let velocity = plus(node.velocity, cross(node.spin, contact.arm_m));
        let turning = plus(cross(node.spin_rate, contact.arm_m), cross(node.spin, contact.arm_rate_m_s));
        let acceleration = plus(node.acceleration, turning);
        let mut rows = [[J::ZERO; 3]; 3];
        if self.described.holds_normal {
            rows[0][2] = self.height(node, &contact).times(-1.0);
        }
        for (row, _) in self.active().iter().enumerate().filter(|(_, active)| **active) {
            let (direction, rate) = (&contact.directions[row], &contact.direction_rates_1_s[row]);
            rows[1][row] = dot(direction, &velocity).times(-1.0);
            rows[2][row] = (dot(direction, &acceleration) + dot(rate, &velocity)).times(-1.0);
        }
        rows
    }

    /// Gap of the rows at the motion of the last sweep.
    pub fn gap(&self, work: &Workspace) -> Gap {
        let [position_m, velocity_m_s, acceleration_m_s2] = self.rows(&self.motion(work)).map(Vector3::from);
        Gap { position_m, velocity_m_s, acceleration_m_s2 }
    }

    fn motion(&self, work: &Workspace) -> NodeMotion<f64> {
        NodeMotion::of(&work.nodes[self.node])
    }

    /// Distance of the point of contact from the plane along its normal in m.
    fn height<J: Jet>(&self, node: &NodeMotion<J>, contact: &Contact<J>) -> J {
        let point = plus(node.position, contact.arm_m);
        dot(&point, &constants(&self.described.normal)) - J::constant(self.described.distance_m)
    }

    /// Force and moment on the node per multiplier, with the sign of the nodes' wrenches; zero for rows that are not constrained.
    pub(crate) fn wrenches<J: Jet>(&self, node: &NodeMotion<J>) -> [[Vector<J>; 2]; ROWS] {
        let contact = self.contact(node);
        let active = self.active();
        std::array::from_fn(|row| {
            if !active[row] {
                return [[J::ZERO; 3]; 2];
            }
            let force = contact.directions[row].map(|entry| entry.times(-1.0));
            [force, cross(contact.arm_m, force)]
        })
    }

    /// Distance of the point of contact from the plane along its normal in m, at the poses of the last sweep.
    pub fn height_m(&self, work: &Workspace) -> f64 {
        let node = self.motion(work);
        self.height(&node, &self.contact(&node))
    }

    /// Distance of the point of contact from the node in m.
    pub(crate) fn arm_m(&self, work: &Workspace) -> f64 {
        Vector3::from(self.contact(&self.motion(work)).arm_m).norm()
    }

    /// Adds the forces on the body to its node; returns their wrench about the origin on the root, with the sign of the nodes' wrenches.
    pub(crate) fn apply(&self, work: &mut Workspace, multipliers: &Vector3<f64>) -> Pair {
        let [mut force, mut moment] = [Vector3::zeros(); 2];
        for ([own_force, own_moment], multiplier) in self.wrenches(&self.motion(work)).iter().zip(multipliers) {
            force += Vector3::from(*own_force) * *multiplier;
            moment += Vector3::from(*own_moment) * *multiplier;
        }
        let node = &mut work.nodes[self.node];
        node.add_fixed(&force, &moment);
        Pair { linear: -force, angular: -moment - node.position.cross(&force) }
    }

    /// Adds a unit multiplier of a row to the wrenches in `work.bias`.
    pub(crate) fn load_unit(&self, work: &mut Workspace, row: usize) {
        let [force, moment] = self.wrenches(&self.motion(work))[row].map(Vector3::from);
        work.bias[self.node].linear += force;
        work.bias[self.node].angular += moment;
    }

    /// Changes of the rows due to the node displacements in `work.bias`.
    pub(crate) fn gap_change(&self, work: &Workspace) -> Vector3<f64> {
        let Pair { linear, angular } = work.bias[self.node];
        let change =
            |[force, moment]: [Vector<f64>; 2]| Vector3::from(force).dot(&linear) + Vector3::from(moment).dot(&angular);
        Vector3::from(self.wrenches(&self.motion(work)).map(change))
    }
}
