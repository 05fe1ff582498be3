//! Final motion of a model with a spinning rotor: a state that rotates with the rotor if there is one, otherwise a periodic motion.

use crate::run::Plant;
use crate::run::periodic::shooting::{NearbyMotion, PeriodicMotion, Seen, Shooting};
use crate::run::periodic::turn::Turn;
use crate::system::PlantError;

/// Allowed residual of a steady state at other azimuths, in rad or divided by the machine's length: rounded angles of a model file cause
/// 1e-7.
const STEADY: f64 = 1e-6;

/// Final motion of a model whose shaft rotates at a constant speed.
#[derive(Debug, Clone)]
pub enum Settled {
    /// The plant is in a steady state, which rotates with the rotor.
    Steady,
    /// The plant is at the start of a periodic revolution.
    Periodic(PeriodicMotion),
}

impl Plant {
    /// Finds the final motion of the model prepared by [`Turn::of`], NOTATION eqs. (L32), (L33) and (L40): an initialised plant is set to
    /// the state that rotates with the rotor, if tilt, gravity and shear allow one, otherwise to the start of a periodic revolution, found
    /// from that state to `accuracy` as by [`Plant::periodic`].
    ///
    /// The steady state is verified: at two further azimuths it must not change by more than 1e-6 of the model's length.
    ///
    /// # Errors
    /// As for [`Plant::periodic`].
    pub fn settle(&mut self, turn: &Turn, accuracy: f64) -> Result<Settled, PlantError> {
        self.settle_beside(turn, accuracy, &mut None, &mut |_, _| Ok(()))
    }

    /// Finds the final motion like [`Plant::settle`], near a motion that was found before at another wind or pitch of the model: if the
    /// model had no steady state then, none is sought, and the search starts from that motion, which is replaced by the motion found.
    /// `seen` is called for the revolutions tried, sample by sample as in [`Plant::trace`]; the last one from sample 0 is the final motion.
    /// A steady state is not marched. Work and dissipated energy of a revolution are computed only if the plant watches
    /// [`crate::system::OutputSet::ACCOUNTS`].
    ///
    /// # Errors
    /// As for [`Plant::settle`], and errors of `seen`.
    pub fn settle_beside(
        &mut self,
        turn: &Turn,
        accuracy: f64,
        nearby: &mut Option<NearbyMotion>,
        seen: &mut Seen<'_>,
    ) -> Result<Settled, PlantError> {
        if nearby.is_some() {
            let begin = self.snapshot();
            if let Ok(motion) = self.close(turn, accuracy, nearby, seen) {
                return Ok(Settled::Periodic(motion));
            }
            self.restore(&begin)?;
        }
        let begin = self.snapshot();
        match self.study().turn_in_balance(turn.shaft, turn.speed_rad_s) {
            Ok(swing) if swing <= STEADY => return Ok(Settled::Steady),
            Ok(_) => {}
            // no equilibrium at one azimuth; a periodic revolution may still exist
            Err(_) => self.restore(&begin)?,
        }
        self.close(turn, accuracy, nearby, seen).map(Settled::Periodic)
    }

    fn close(
        &mut self,
        turn: &Turn,
        accuracy: f64,
        nearby: &mut Option<NearbyMotion>,
        seen: &mut Seen<'_>,
    ) -> Result<PeriodicMotion, PlantError> {
        let mut shooting = Shooting::new(self, *turn);
        shooting.seen = Some(seen);
        shooting.close_beside(accuracy, nearby)
    }
}
