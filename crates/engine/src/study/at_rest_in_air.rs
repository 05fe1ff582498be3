//! Static aeroelastic equilibria: iteration between the structure and an established flow.

use crate::force::memory::JointMemory;
use crate::load::SectionMotion;
use crate::solve::EquationsOfMotion;
use crate::solve::equilibrium::Effort;
use crate::study::{Departure, Holding, Study};
use crate::system::PlantError;
use crate::system::air::AirCoupling;
use nalgebra::Rotation3;

/// Maximum number of static iterations between aerodynamics and structure.
const MAXIMUM_STATIC_ITERATIONS: usize = 100;
/// Change of the loads, relative to the largest, below which a static equilibrium has converged: far above the error of the structural
/// solution.
const STATIC_TOLERANCE: f64 = 1e-9;
/// Rotation of a section in rad above which a converged equilibrium may be on another branch than the one from still air: loads that rotate
/// with the sections allow others, up to rolled-up wings.
const FAR_RAD: f64 = 1.0;
/// Angle in rad, or displacement in m, beyond a latch up to which an equilibrium counts as at the latch: the accuracy of hinge equilibria.
const AT_LATCH_RAD: f64 = 1e-6;

impl Study<'_> {
    /// Finds the equilibrium under the loads of an established flow, eq. (Q5), and for hinges with only aerodynamic stiffness by eq. (Q6);
    /// without aerodynamics like [`crate::system::System::settle_at_rest`].
    ///
    /// A latch closes on a joint whose equilibrium is at or beyond the latch angle. Under the loads of intermediate states, a search may
    /// pass a latch that the equilibrium does not reach: a latch that would have to pull the joint towards itself is left open.
    ///
    /// # Errors
    /// If there is no equilibrium, or if the only one lies beyond such a latch.
    pub(crate) fn settle_in_air(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        let (start, joints) = (self.system.state.now.q.clone(), self.system.state.joints.clone());
        let effort = self.settle_with_latches(time_s, holding)?;
        let pulling = self.pulling_latches(time_s, &start, &joints);
        if pulling.is_empty() {
            return Ok(effort);
        }
        let latched = self.system.state.clone();
        self.restart_search(&start, &joints);
        for &joint in &pulling {
            self.system.state.joints[joint].latch.enabled = false;
        }
        let opened = self.settle_with_latches(time_s, holding);
        let mut beyond_rad: f64 = f64::NEG_INFINITY;
        for &joint in &pulling {
            self.system.state.joints[joint].latch.enabled = true;
            let forces = &self.system.equations.forces.joints()[joint];
            if let Some(catching) = forces.latch() {
                let (from_rad, to_rad) = (start[forces.coordinate], self.system.state.now.q[forces.coordinate]);
                beyond_rad = beyond_rad.max(-catching.latch.gap_rad(from_rad, to_rad));
            }
        }
        let opened = opened?;
        if beyond_rad < 0.0 {
            return Ok(opened);
        }
        if beyond_rad < AT_LATCH_RAD {
            self.system.state = latched;
            self.system.configure();
            return Ok(effort);
        }
        let names: Vec<&str> = pulling.iter().map(|joint| self.system.joint_name(*joint)).collect();
        let cause = format!(
            "no state of the latch of {} is consistent: if it is closed, the loads pull its joint back towards the start \
             angle; if it is open, the equilibrium lies beyond the latch angle; choose a start angle near the equilibrium, or \
             disable the latch (latch_enable = false)",
            names.join(", ")
        );
        Err(PlantError::Equilibrium { time_s, reached: 1.0, tried: 1.0, cause, diverges_m_s: None })
    }

    /// Joints whose latches, not closed in `joints`, have closed and pull them towards the latch, in the direction of their motion from
    /// `start`: without the latch, the loads move them back.
    fn pulling_latches(&mut self, time_s: f64, start: &[f64], joints: &[JointMemory]) -> Vec<usize> {
        let closed = |i: &usize| self.system.state.joints[*i].latch.closed && !joints[*i].latch.closed;
        let closed: Vec<usize> = (0..joints.len()).filter(closed).collect();
        if closed.is_empty() {
            return closed;
        }
        let zero = vec![0.0; start.len()];
        let now = &self.system.state.now;
        let tree = self.system.equations.model.tree_coordinates();
        let multipliers: Vec<f64> = zero[..tree].iter().chain(&now.q[tree..]).copied().collect();
        let mut still = zero;
        self.system.equations.stand(&mut still);
        self.system.equations.residual(time_s, &now.q, &still, &multipliers, &mut self.system.scratch[0]);
        let pulls = |i: &usize| {
            let forces = &self.system.equations.forces.joints()[*i];
            let Some(latch) = forces.latch().map(|catching| catching.latch) else { return false };
            let side = if start[forces.coordinate] < latch.angle_rad { 1.0 } else { -1.0 };
            let on_joint_n_m = match latch.is_rigid() {
                true => forces.holding_n_m,
                false => latch.torque_n_m(self.system.state.now.q[forces.coordinate]),
            };
            side * on_joint_n_m > 0.0
        };
        closed.into_iter().filter(pulls).collect()
    }

    /// Restores the state before a search; the flow from another search is not used as a starting point.
    fn restart_search(&mut self, start: &[f64], joints: &[JointMemory]) {
        self.system.state.now.q.copy_from_slice(start);
        self.system.state.joints.copy_from_slice(joints);
        self.system.state.air = None;
        self.system.configure();
    }

    /// Finds the equilibrium, with latches that close on joints that pass them in the search.
    fn settle_with_latches(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        if self.system.air.is_none() {
            return self.settle_at_rest(time_s, holding);
        }
        let (start, joints) = (self.system.state.now.q.clone(), self.system.state.joints.clone());
        let settled = self.settle_with_air(time_s, holding);
        if settled.is_ok() || holding == Holding::Stopped {
            return settled;
        }
        self.restart_search(&start, &joints);
        let hinges = self.free_hinges();
        // joints of a rigid loop do not move one by one
        if hinges.is_empty() || self.system.is_constrained() { settled } else { self.coast(time_s, &hinges) }
    }

    /// Solves alternately for the structure under constant loads and for the flow around it until both agree: eq. (Q5). If that diverges,
    /// or ends far from the start, strips follow the path from still air instead, eq. (Q12).
    pub(crate) fn settle_with_air(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        if !self.has_path_in_air(holding) {
            return self.iterate_with_air(time_s, holding);
        }
        let (start, joints) = (self.system.state.now.q.clone(), self.system.state.joints.clone());
        self.system.start_air(time_s)?;
        let unstrained = self.section_motions();
        let found = self.iterate_with_air(time_s, holding);
        let turned = |(from, to): (&SectionMotion, &SectionMotion)| {
            Rotation3::from_matrix_unchecked(to.rotation * from.rotation.transpose()).angle() > FAR_RAD
        };
        if found.is_ok() && !unstrained.iter().zip(&self.section_motions()).any(turned) {
            return found;
        }
        let kept = self.system.state.clone();
        self.system.state.now.q.copy_from_slice(&start);
        self.system.state.joints.copy_from_slice(&joints);
        match (self.follow_in_air(time_s, holding), found) {
            (Ok(effort), _) => Ok(effort),
            (Err(error), Ok(effort)) => {
                self.system.state = kept;
                self.system.configure();
                if let PlantError::Equilibrium { reached, .. } = error {
                    self.quest.departure = Some(Departure::PathInAirEnds(reached));
                }
                Ok(effort)
            }
            (Err(error @ PlantError::Equilibrium { .. }), Err(_)) => Err(error),
            (Err(_), Err(error)) => Err(error),
        }
    }

    /// Motions of the sections in the last aerodynamic solution.
    fn section_motions(&self) -> Vec<SectionMotion> {
        self.system.air.as_ref().map_or_else(Vec::new, |air| air.motions.clone())
    }

    fn iterate_with_air(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        let start = self.system.state.now.q.clone();
        self.system.follow_carriages();
        let joints = self.system.state.joints.clone();
        self.system.start_air(time_s)?;
        let mut change = f64::NAN;
        if let Some(air) = &mut self.system.air {
            air.acceleration.restart();
        }
        for _ in 0..MAXIMUM_STATIC_ITERATIONS {
            self.system.state.now.q.copy_from_slice(&start);
            self.system.state.joints.copy_from_slice(&joints);
            self.system.configure();
            let guess = self.system.state.air.as_ref().map(|history| history.loads.clone());
            let effort = self.settle_at_rest(time_s, holding)?;
            self.system.follow_carriages();
            self.system.start_air(time_s)?;
            let (Some(air), Some(history), Some(guess)) = (&mut self.system.air, &mut self.system.state.air, guess)
            else {
                return Ok(effort);
            };
            air.read(&guess);
            let (change_n, size_n) = air.compare();
            change = change_n / size_n;
            let agreed_n = STATIC_TOLERANCE * size_n;
            let round_off_n = air.round_off_n(self.system.state.applied_parameters.air_density_kg_m3());
            if !change_n.is_finite() || change_n <= agreed_n.max(round_off_n) {
                return Ok(effort);
            }
            let AirCoupling { acceleration, guess, residual, .. } = &mut **air;
            acceleration.next(guess, residual);
            air.write(&mut history.loads);
            history.loads.from.clone_from(&history.loads.to);
        }
        let cause = format!(
            "the static aerodynamic loads still change by {change:.1e} of the largest load after \
             {MAXIMUM_STATIC_ITERATIONS} iterations with the structure; the wind may be above the divergence speed: \
             try a lower speed, or more stiffness"
        );
        Err(PlantError::Equilibrium { time_s, reached: 0.0, tried: 1.0, cause, diverges_m_s: None })
    }
}
