//! Wheels that lie flat on their planes, and skates with blades along the normal: the error in place of that of the integrator.

use crate::machine::Runner;
use crate::multibody::kinematics::{Motion, sweep_motion};
use crate::multibody::no_slip::LEAST_SINE;
use crate::solve::newton::NewtonError;
use crate::solve::point::Point;
use crate::system::{PlantError, System};

impl System {
    /// The first wheel or skate that has no heading at a state, or loses it within a step from there, as an error; `None` if all have one.
    pub(crate) fn no_heading(&self, point: &Point, step_s: f64) -> Option<PlantError> {
        let model = &self.equations.model;
        if model.no_slips.is_empty() {
            return None;
        }
        let mut work = self.equations.work.clone();
        sweep_motion(model, &mut work, Motion { q: &point.q, v: &point.v, a: &point.a });
        let angles = model.no_slips.iter().map(|no_slip| no_slip.angle(&work.nodes[no_slip.node]));
        let lost = |[angle_rad, rate_rad_s]: [f64; 2]| angle_rad + (step_s * rate_rad_s).min(0.0) < LEAST_SINE.asin();
        let (described, [angle_rad, _]) = self.machine.no_slips.iter().zip(angles).find(|(_, angle)| lost(*angle))?;
        let (lies, part) = match described.runner {
            Runner::Skate { .. } => ("stands on its tip", "blade"),
            Runner::Wheel { .. } => ("lies flat", "axis"),
        };
        Some(PlantError::NoHeading {
            time_s: point.time_s,
            kind: described.table(),
            name: described.name.clone(),
            lies,
            part,
            angle_deg: angle_rad.to_degrees(),
        })
    }

    /// Error of constraints that cannot be closed at a state.
    pub(crate) fn not_closed(&self, point: &Point, error: &NewtonError) -> PlantError {
        let initialization = || PlantError::Initialization { time_s: point.time_s, cause: error.to_string() };
        self.no_heading(point, 0.0).unwrap_or_else(initialization)
    }
}
