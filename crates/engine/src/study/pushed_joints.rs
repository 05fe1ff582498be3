//! Static equilibria of joints without stiffness that loads push against a latch or an end stop.

use crate::solve::EquationsOfMotion as _;
use crate::study::Study;
use crate::study::statics::Holding;

/// Positions between the start of a joint and the stop at which the force on it is evaluated.
const POSITIONS: u32 = 32;
/// Distance beyond a stop or the edge of a latch at which the joint is caught, relative to 1 rad or 1 m and to the coordinate: above
/// round-off, and a thousandth of the default half-width of a latch's capture window.
const BEYOND: f64 = 1e-9;

impl Study<'_> {
    /// Stops each released joint at the first latch or end stop towards which the loads push it on the whole way from `start`, the other
    /// coordinates unchanged: without stiffness, the search along the load path does not get there. Returns whether a joint was stopped.
    pub(super) fn stop_pushed_joints(&mut self, start: &mut [f64], time_s: f64, holding: Holding) -> bool {
        let model = &self.system.equations.model;
        // the force on a joint in a loop depends on the others, and that of aerodynamics on the flow at each position
        let depends = self.system.air.is_some() || !(model.closures.is_empty() && model.rigid_loops.is_empty());
        if holding == Holding::Stopped || depends {
            return false;
        }
        let mut pushed = false;
        for index in 0..self.system.state.joints.len() {
            let joint = &self.system.equations.forces.joints()[index];
            if joint.held {
                continue;
            }
            let c = joint.coordinate;
            let force = self.force_at(start, c, start[c], time_s);
            if force == 0.0 || !force.is_finite() {
                continue;
            }
            let (direction, memory) = (force.signum(), &self.system.state.joints[index]);
            let joint = &self.system.equations.forces.joints()[index];
            let Some(end) = joint.ahead_rad(start[c], direction, memory) else { continue };
            let mut way = (1..=POSITIONS).map(|k| start[c] + (end - start[c]) * f64::from(k) / f64::from(POSITIONS));
            if way.all(|position| self.force_at(start, c, position, time_s) * direction > 0.0) {
                let joint = &self.system.equations.forces.joints()[index];
                let beyond = end + direction * BEYOND * (1.0 + end.abs());
                pushed |= joint.stops_at_rest(&mut start[c], beyond, &mut self.system.state.joints[index]);
            }
        }
        pushed
    }

    /// Sum of all forces or torques along coordinate `c` in N or N·m if it has the value `position` at rest and the others those of `start`.
    fn force_at(&mut self, start: &[f64], c: usize, position: f64, time_s: f64) -> f64 {
        let mut q = start.to_vec();
        q[c] = position;
        let (mut v, a) = (vec![0.0; q.len()], vec![0.0; q.len()]);
        self.system.equations.seat_at(&q);
        self.system.equations.stand(&mut v);
        let mut residual = vec![0.0; q.len()];
        self.system.equations.residual(time_s, &q, &v, &a, &mut residual);
        -residual[c]
    }
}
