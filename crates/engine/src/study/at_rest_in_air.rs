//! Equilibria in air: convergence of structure and established flow.

use crate::load::SectionMotion;
use crate::solve::equilibrium::Effort;
use crate::study::{Departure, Holding, Study};
use crate::system::PlantError;
use crate::system::air::AirCoupling;
use nalgebra::Rotation3;

/// Maximum number of iterations between air and structure at rest.
const MAXIMUM_STATIC_ITERATIONS: usize = 100;
/// Change of the loads at equilibrium, relative to the largest, below which they have converged: far above the error of the statics.
const STATIC_TOLERANCE: f64 = 1e-9;
/// Rotation of a section in rad beyond which a converged equilibrium may be on another branch than the one from still air: with loads that
/// turn with the sections there are others, up to rolled-up wings.
const FAR_RAD: f64 = 1.0;

impl Study<'_> {
    /// Finds the equilibrium under the loads of an established flow, eq. (Q5), with hinges without stiffness except that of the air by eq.
    /// (Q6); without air as [`crate::system::System::settle_at_rest`].
    pub(crate) fn settle_in_air(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        if self.system.air.is_none() {
            return self.settle_at_rest(time_s, holding);
        }
        let (start, joints) = (self.system.state.now.q.clone(), self.system.state.joints.clone());
        let settled = self.settle_with_air(time_s, holding);
        if settled.is_ok() || holding == Holding::Stopped {
            return settled;
        }
        self.system.state.now.q.copy_from_slice(&start);
        self.system.state.joints.copy_from_slice(&joints);
        // the flow after a diverged iteration is no starting point
        self.system.state.air = None;
        self.system.configure();
        let hinges = self.free_hinges();
        if hinges.is_empty() { settled } else { self.coast(time_s, &hinges) }
    }

    /// Solves alternately for the structure under constant loads and for the air around it, until both agree: eq. (Q5). If that diverges,
    /// or ends far away, strips follow the path from still air instead, eq. (Q12).
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

    /// Motions of the sections in the last solution of the air.
    fn section_motions(&self) -> Vec<SectionMotion> {
        self.system.air.as_ref().map_or_else(Vec::new, |air| air.motions.clone())
    }

    fn iterate_with_air(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        let start = self.system.state.now.q.clone();
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
            "the loads of the air at rest still change by {change:.1e} of the largest after {MAXIMUM_STATIC_ITERATIONS} iterations with the \
             structure; the machine may be past divergence in this wind: try a lower speed, or more stiffness"
        );
        Err(PlantError::Equilibrium { time_s, reached: 0.0, tried: 1.0, cause })
    }
}
