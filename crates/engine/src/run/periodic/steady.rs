//! Where a turning machine settles: a state that turns with the rotor where there is one, a motion that every turn repeats elsewhere.

use crate::run::Plant;
use crate::run::periodic::shooting::{NearbyMotion, PeriodicMotion, Seen, Shooting};
use crate::run::periodic::turn::Turn;
use crate::system::PlantError;

/// What other azimuths may ask of a steady state, in rad or over the machine's length: rounded angles of a model file make 1e-7.
const STEADY: f64 = 1e-6;

/// Where a machine settles whose shaft turns at a constant speed.
#[derive(Debug, Clone)]
pub enum Settled {
    /// The plant is in the state, which turns with the rotor.
    Steady,
    /// The plant is at the begin of a turn that brings its state back.
    Periodic(PeriodicMotion),
}

impl Plant {
    /// Where the machine that [`Turn::of`] has made ready settles, NOTATION eqs. (L32), (L33) and (L40): an initialised plant goes to the
    /// state that turns with the rotor, if tilt, gravity and shear allow one, otherwise to the begin of a turn that repeats, found from
    /// that state to `accuracy` as [`Plant::periodic`] finds it.
    ///
    /// Whether the state is steady is measured: at two further azimuths it must not change by more than 1e-6 of the machine's length.
    ///
    /// # Errors
    /// As [`Plant::periodic`].
    pub fn settle(&mut self, turn: &Turn, accuracy: f64) -> Result<Settled, PlantError> {
        self.settle_beside(turn, accuracy, &mut None, &mut |_, _| Ok(()))
    }

    /// The same beside a motion that was found before, at another wind or pitch of the machine: where the machine did not balance then, no
    /// balance is sought, and the search begins at that motion. The motion found takes its place. `seen` looks at the turns tried, sample by
    /// sample as in [`Plant::trace`]; the last one from sample 0 on is that of the motion. A steady state is not marched.
    ///
    /// # Errors
    /// As [`Plant::settle`], and those of `seen`.
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
            // nothing balances at one azimuth; a turn may still repeat
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
