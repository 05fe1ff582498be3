//! Control surfaces of the model: their angles from the inputs, and their hinge moments for the outputs.

use crate::aero::AirStates;
use crate::aero::flap::{Deflection, Flap};
use crate::machine::Air;
use crate::signal::{FlapInputs, Inputs};
use crate::system::PlantError;
use crate::system::air::AirCoupling;
use crate::system::equations::Equations;
use crate::system::outputs::{FlapOutputs, Outputs};
use crate::system::state::State;

/// Excess over an angle limit in rad that is accepted as round-off of a conversion from degrees by the caller.
const ROUND_OFF_RAD: f64 = 1e-12;

/// Angles and rates of the control surfaces from the inputs.
pub(crate) fn deflections<'a>(air: &'a Air, inputs: &'a Inputs) -> impl Iterator<Item = Deflection> + 'a {
    debug_assert_eq!(air.flaps.len(), inputs.flaps().len());
    inputs.flaps().iter().map(deflection)
}

fn deflection(inputs: &FlapInputs) -> Deflection {
    Deflection { angle_rad: inputs.command_rad, rate_rad_s: inputs.command_rate_rad_s }
}

/// Angle and rate of a control surface `elapsed_s` after the time of `inputs`, with the rates per second in `rates`.
fn later(inputs: &FlapInputs, rates: &FlapInputs, elapsed_s: f64) -> Deflection {
    Deflection {
        angle_rad: inputs.command_rad + rates.command_rad * elapsed_s,
        rate_rad_s: inputs.command_rate_rad_s + rates.command_rate_rad_s * elapsed_s,
    }
}

/// Checks the angle of a control surface against its limits.
fn check(flap: &Flap, angle_rad: f64, time_s: f64) -> Result<(), PlantError> {
    if (flap.lower_rad - ROUND_OFF_RAD..=flap.upper_rad + ROUND_OFF_RAD).contains(&angle_rad) {
        return Ok(());
    }
    let Flap { name, lower_rad, upper_rad, .. } = flap;
    // in degrees, as in the model file, without the round-off of the conversion
    let degrees = [*lower_rad, *upper_rad].map(|rad| (rad.to_degrees() * 1e6).round() / 1e6);
    let cause = format!(
        "aero.control_surface.{name}.angle_command rotates control surface {name} to {angle_rad} rad; allowed: from {lower_rad:.6} \
         to {upper_rad:.6} rad (lower_deg = {}, upper_deg = {})",
        degrees[0], degrees[1]
    );
    Err(PlantError::Surroundings { time_s, cause })
}

impl AirCoupling {
    /// Passes the control surface angles at a time of the current communication step to the aerodynamic models.
    ///
    /// # Errors
    /// If an angle exceeds its limits.
    pub fn deflect(&mut self, state: &State, time_s: f64) -> Result<(), PlantError> {
        if self.settings.flaps.is_empty() {
            return Ok(());
        }
        let elapsed_s = time_s - state.applied_from_s;
        let inputs = state.applied_inputs.flaps().iter().zip(state.applied_rates.flaps());
        for ((own, flap), (inputs, rates)) in self.deflections.iter_mut().zip(&self.settings.flaps).zip(inputs) {
            *own = later(inputs, rates, elapsed_s);
            check(flap, own.angle_rad, time_s)?;
        }
        self.model.deflect(&self.deflections);
        Ok(())
    }

    /// Writes the outputs of the control surfaces at a time, after the fraction `share` of the aerodynamic step.
    pub(super) fn report_flaps(
        &self,
        equations: &Equations,
        states: [&AirStates; 2],
        (time_s, share): (f64, f64),
        outputs: &mut Outputs,
    ) {
        let course = &equations.course;
        let inputs = course.base.flaps().iter().zip(course.rates.flaps());
        for (flap, (output, (inputs, rates))) in outputs.flaps_mut().iter_mut().zip(inputs).enumerate() {
            let now = later(inputs, rates, time_s - course.from_s);
            let [before, after] = states.map(|states| self.model.hinge_moment(states, flap));
            *output = FlapOutputs {
                angle_rad: now.angle_rad,
                rate_rad_s: now.rate_rad_s,
                hinge_moment_n_m: before.between(&after, share),
            };
        }
    }
}
