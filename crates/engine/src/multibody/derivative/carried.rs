//! Mass-proportional damping of bodies on a free joint, relative to the rigid motion of their carrier, on which its resultant reacts,
//! NOTATION eqs. (D15) and (X28).

use crate::multibody::derivative::chain::{STILL, Shift};
use crate::multibody::derivative::spot::{Four, NONE, Spot, beam_forces};
use crate::multibody::model::{Body, Model};
use crate::multibody::nodal::multiply;
use crate::multibody::workspace::Node;
use nalgebra::Vector3;

/// Damping of a body at the point of linearisation.
#[derive(Debug, Clone)]
pub(super) struct CarriedDamping {
    /// Node whose rigid motion is the reference.
    carrier: usize,
    /// Its angular velocity in rad/s.
    spin: Vector3<f64>,
    /// Vectors from it to the nodes of the body in m.
    arms: Vec<Vector3<f64>>,
    /// Forces on the nodal vectors per damping.
    forces: Vec<Four>,
    /// Workspace: rates of the nodal vectors relative to the reference and the forces due to them, or their multipliers.
    rates: Vec<Four>,
    changes: Vec<Four>,
}

impl CarriedDamping {
    /// For a body; `None` if its damping is relative to the root.
    pub fn of_body(body: &Body) -> Option<Self> {
        let nodes = body.last_node() + 1 - body.first_node;
        let four = vec![NONE; nodes];
        body.carrier.map(|carrier| Self {
            carrier,
            spin: Vector3::zeros(),
            arms: vec![Vector3::zeros(); nodes],
            forces: four.clone(),
            rates: four.clone(),
            changes: four,
        })
    }

    /// Stores the forces at the motion of the nodes.
    pub fn prepare(&mut self, model: &Model, body: &Body, nodes: &[Node]) {
        let carrier = &nodes[self.carrier];
        self.spin = carrier.spin;
        for (place, node) in nodes[body.first_node..=body.last_node()].iter().enumerate() {
            self.arms[place] = node.position - carrier.position;
            let (velocity, spin) = node.relative_to(carrier);
            let axis = |k: usize| spin.cross(&node.rotation.column(k).into_owned());
            self.rates[place] = [velocity, axis(0), axis(1), axis(2)];
        }
        damped_forces(model, body, &self.rates, &mut self.forces);
    }

    /// Variation of the rates of a node's vectors in the rigid motion of the reference.
    fn carried(&self, place: usize, spot: &Spot, [own, carrier]: [&Shift; 2]) -> Four {
        let turn_rate = carrier.angular[1] - self.spin.cross(&carrier.angular[0]);
        let apart = own.linear[0] - carrier.linear[0];
        let origin = carrier.linear[1] + turn_rate.cross(&self.arms[place]) + self.spin.cross(&apart);
        let axis = |k: usize| {
            let axis = &spot.axes[k][0];
            turn_rate.cross(axis) + self.spin.cross(&own.angular[0].cross(axis))
        };
        [origin, axis(0), axis(1), axis(2)]
    }

    /// The transpose of [`Self::carried`].
    fn pull(&self, place: usize, spot: &Spot, on: &Four, [first, own]: [usize; 2], sums: &mut [Shift]) {
        let mut on_turn_rate = self.arms[place].cross(&on[0]);
        let apart = on[0].cross(&self.spin);
        let mut on_turn = Vector3::zeros();
        for (axis, on) in spot.axes.iter().zip(&on[1..]) {
            on_turn_rate += axis[0].cross(on);
            on_turn += axis[0].cross(&on.cross(&self.spin));
        }
        let node = &mut sums[first + own];
        node.linear[0] += apart;
        node.angular[0] += on_turn;
        let carrier = &mut sums[self.carrier];
        carrier.linear[0] -= apart;
        carrier.linear[1] += on[0];
        carrier.angular[1] += on_turn_rate;
        carrier.angular[0] += self.spin.cross(&on_turn_rate);
    }

    /// Subtracts the part of the rigid motion from the variations of the damped loads of the nodes.
    pub fn subtract(&self, body: &Body, (spots, alpha): (&[Spot], f64), shifts: &[Shift], loads: &mut [Four]) {
        for (place, loads) in loads[body.first_node..=body.last_node()].iter_mut().enumerate() {
            let n = body.first_node + place;
            let carried = self.carried(place, &spots[n], [&shifts[n], &shifts[self.carrier]]);
            loads.iter_mut().zip(&carried).for_each(|(load, carried)| *load -= carried * alpha);
        }
    }

    /// The transpose of [`Self::subtract`], from the multipliers of the loads.
    pub fn pull_subtracted(&self, body: &Body, (spots, alpha): (&[Spot], f64), on: &[Four], sums: &mut [Shift]) {
        for (place, on) in on[body.first_node..=body.last_node()].iter().enumerate() {
            let spot = &spots[body.first_node + place];
            self.pull(place, spot, &on.map(|on| on * -alpha), [body.first_node, place], sums);
        }
    }

    /// Subtracts the variation of the resultant from the wrench on the reference.
    pub fn react(
        &mut self,
        (model, body): (&Model, &Body),
        (spots, alpha): (&[Spot], f64),
        shifts: &[Shift],
        wrenches: &mut [[Vector3<f64>; 2]],
    ) {
        for place in 0..self.arms.len() {
            let n = body.first_node + place;
            let carried = self.carried(place, &spots[n], [&shifts[n], &shifts[self.carrier]]);
            let turning = Shift { linear: STILL, angular: shifts[n].angular };
            let axis = |k: usize| turning.carried(&spots[n].axes[k]).linear[1];
            let own = [shifts[n].linear[1], axis(0), axis(1), axis(2)];
            self.rates[place] = std::array::from_fn(|k| own[k] - carried[k]);
        }
        damped_forces(model, body, &self.rates, &mut self.changes);
        let [mut force, mut moment] = [Vector3::zeros(); 2];
        for place in 0..self.arms.len() {
            let n = body.first_node + place;
            let (own, changes) = (&self.forces[place], &self.changes[place]);
            let apart = shifts[n].linear[0] - shifts[self.carrier].linear[0];
            force += changes[0];
            moment += self.arms[place].cross(&changes[0]) + apart.cross(&own[0]);
            for k in 0..3 {
                let axis = &spots[n].axes[k][0];
                moment += axis.cross(&changes[k + 1]) + shifts[n].angular[0].cross(axis).cross(&own[k + 1]);
            }
        }
        wrenches[self.carrier][0] -= force * alpha;
        wrenches[self.carrier][1] -= moment * alpha;
    }

    /// The transpose of [`Self::react`].
    pub fn pull_reaction(
        &mut self,
        (model, body): (&Model, &Body),
        (spots, alpha): (&[Spot], f64),
        on: &[[Vector3<f64>; 2]],
        sums: &mut [Shift],
    ) {
        let [on_force, on_moment] = on[self.carrier].map(|on| on * -alpha);
        for place in 0..self.arms.len() {
            let n = body.first_node + place;
            let own = &self.forces[place];
            let on_axis = |k: usize| on_moment.cross(&spots[n].axes[k][0]);
            self.changes[place] = [on_force + on_moment.cross(&self.arms[place]), on_axis(0), on_axis(1), on_axis(2)];
            let apart = own[0].cross(&on_moment);
            sums[n].linear[0] += apart;
            sums[self.carrier].linear[0] -= apart;
            for k in 0..3 {
                let (axis, force) = (&spots[n].axes[k][0], &own[k + 1]);
                sums[n].angular[0] += force * on_moment.dot(axis) - on_moment * axis.dot(force);
            }
        }
        damped_forces(model, body, &self.changes, &mut self.rates);
        for place in 0..self.arms.len() {
            let n = body.first_node + place;
            let on = self.rates[place];
            sums[n].linear[1] += on[0];
            let mut turning = Shift::ZERO;
            for (axis, on) in spots[n].axes.iter().zip(&on[1..]) {
                turning.add_carried(&Shift { linear: [Vector3::zeros(), *on, Vector3::zeros()], angular: STILL }, axis);
            }
            sums[n].angular.iter_mut().zip(&turning.angular).for_each(|(sum, on)| *sum += on);
            self.pull(place, &spots[n], &on.map(|on| -on), [body.first_node, place], sums);
        }
    }
}

/// Forces of the damped masses of a body on its nodal vectors: symmetric.
fn damped_forces(model: &Model, body: &Body, rates: &[Four], forces: &mut [Four]) {
    beam_forces(model, body, rates, forces);
    if !body.damps_attached {
        return;
    }
    for (place, forces) in forces.iter_mut().enumerate() {
        if let Some(attached) = &model.nodes[body.first_node + place].attached {
            let own = multiply(attached, &rates[place]);
            forces.iter_mut().zip(&own).for_each(|(sum, own)| *sum += own);
        }
    }
}
