//! A model prepared for revolutions of its shaft at a constant speed: the shaft is prescribed, and steps divide the revolution.

use crate::aero::AirOptions;
use crate::aero::rotor::wind::Source;
use crate::machine::{Coupling, JointKind, JointMotion, Machine, Method, Motion, OneFreedom};
use crate::study::shaft_of;
use std::f64::consts::TAU;

/// Number of azimuths per revolution at which motions are sampled, evenly spaced.
pub const SAMPLES: usize = 144;
/// Maximum number of steps per revolution.
const MAXIMUM_STEPS: usize = 1_000_000;
/// Tolerance of the steps, a hundred times the accuracy of Newton's iteration: differences of two revolutions need more digits than a run.
const TOLERANCE: f64 = 1e-10;
/// Change of the loads at which the aeroelastic iteration ends: differences of two revolutions contain the remaining error.
const COUPLING_TOLERANCE: f64 = 1e-9;
/// Maximum number of these iterations if the model has none.
const COUPLING_ITERATIONS: usize = 50;
/// Smallest factor by which a step is cut if its equations cannot be solved: a revolution that needs shorter steps is not resolved.
const SMALLEST_STEP: f64 = 0.1;

/// One revolution of a shaft at constant speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// Body attached by the joint that is the shaft.
    pub(super) shaft: usize,
    /// Speed of the shaft in rad/s.
    pub speed_rad_s: f64,
    /// Number of integrator steps per revolution, a multiple of [`SAMPLES`].
    pub steps: usize,
}

impl Turn {
    /// Duration of a revolution in s.
    pub fn period_s(&self) -> f64 {
        TAU / self.speed_rad_s.abs()
    }

    /// Prepares the machine with its shaft prescribed at `speed_rad_s`, from its initial angle, and with steps of ESDIRK4 that divide the
    /// revolution into at least `steps`, a multiple of [`SAMPLES`]; aerodynamic steps divide it too and are no longer than those of the
    /// model. Without a speed, the shaft's motion must be prescribed at a constant rate, or its initial rate is used. `shaft` is the name
    /// of its joint; by default the only joint that rotates without limit and carries a hub.
    ///
    /// # Errors
    /// If there is no such joint or no speed, and if the machine is not periodic: other joints with prescribed motion, failures, gusts,
    /// wind from tables or turbulence; joints with redundant parameters, whose coordinates are not states; vortex lattices, whose wake
    /// grows.
    pub fn of(
        machine: &Machine,
        shaft: Option<&str>,
        speed_rad_s: Option<f64>,
        steps: usize,
    ) -> Result<(Machine, Self), String> {
        let body = shaft_of(machine, shaft)?;
        let mut machine = machine.clone();
        let start_s = machine.experiment.start_time_s;
        let name = machine.bodies[body].joint.name.clone();
        let JointKind::Revolute(hinge) = &mut machine.bodies[body].joint.kind else {
            return Err(format!("the joint {name} is not revolute; a shaft must be revolute"));
        };
        let speed_rad_s = speed_rad_s.map_or_else(|| own_speed_rad_s(hinge, &name), Ok)?;
        if speed_rad_s == 0.0 || !speed_rad_s.is_finite() || !(TAU / speed_rad_s).is_finite() {
            return Err(format!(
                "the speed of the shaft {name} is {speed_rad_s} rad/s; allowed are finite speeds other than 0; at \
                 standstill compute the static equilibrium instead"
            ));
        }
        if !(1..=MAXIMUM_STEPS).contains(&steps) {
            return Err(format!("{steps} steps per revolution; allowed are 1 to {MAXIMUM_STEPS}"));
        }
        let start_rad = match &hinge.motion {
            JointMotion::Prescribed(Motion::Polynomial(coefficients)) => {
                coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * start_s + coefficient)
            }
            JointMotion::Free | JointMotion::Locked | JointMotion::Prescribed(_) => hinge.start_angle_rad,
        };
        hinge.motion =
            JointMotion::Prescribed(Motion::Polynomial(vec![start_rad - speed_rad_s * start_s, speed_rad_s]));
        (hinge.start_angle_rad, hinge.start_rate_rad_s) = (start_rad, 0.0);
        (hinge.generator, hinge.latch, hinge.end_stops) = (None, None, None);
        let turn = Self { shaft: body, speed_rad_s, steps: steps.div_ceil(SAMPLES) * SAMPLES };
        machine.solver.method = Method::Esdirk4;
        machine.solver.most_iterations = None;
        let step_s = turn.period_s() / turn.steps as f64;
        machine.solver.fixed_step_s = Some(step_s);
        (machine.solver.min_step_s, machine.solver.max_step_s) = (SMALLEST_STEP * step_s, step_s);
        machine.solver.tolerance = TOLERANCE;
        check_sameness(&machine, body)?;
        if let Some(air) = &mut machine.air {
            let sample_s = turn.period_s() / SAMPLES as f64;
            air.step_s = sample_s / (sample_s / air.step_s * (1.0 - 1e-9)).ceil().max(1.0);
            let rotors = air.is_rotor();
            match &mut air.coupling {
                Coupling::Iterated { tolerance, .. } => *tolerance = tolerance.min(COUPLING_TOLERANCE),
                // strips store earlier positions of their sections, which would differ with a single correction
                coupling if !rotors => {
                    *coupling =
                        Coupling::Iterated { tolerance: COUPLING_TOLERANCE, most_iterations: COUPLING_ITERATIONS };
                }
                Coupling::Staggered => {}
            }
        }
        Ok((machine, turn))
    }
}

/// Speed of a shaft according to its description.
fn own_speed_rad_s(hinge: &OneFreedom, name: &str) -> Result<f64, String> {
    match &hinge.motion {
        JointMotion::Prescribed(Motion::Polynomial(coefficients))
            if coefficients.iter().skip(2).all(|coefficient| *coefficient == 0.0) =>
        {
            Ok(coefficients.get(1).copied().unwrap_or(0.0))
        }
        JointMotion::Prescribed(_) => {
            Err(format!("the shaft {name} is prescribed, but not at a constant speed; give its speed"))
        }
        _ if hinge.start_rate_rad_s != 0.0 => Ok(hinge.start_rate_rad_s),
        JointMotion::Free | JointMotion::Locked => {
            Err(format!("the shaft {name} has no speed in the model; give its speed"))
        }
    }
}

/// Returns an error for parts that are not periodic.
fn check_sameness(machine: &Machine, shaft: usize) -> Result<(), String> {
    for (index, body) in machine.bodies.iter().enumerate() {
        let joint = &body.joint;
        if joint.kind.spatial().is_some() {
            return Err(format!(
                "the joint {} is universal, ball or free: its coordinates cannot serve as states of the periodic \
                 motion; replace it by revolute and prismatic joints",
                joint.name
            ));
        }
        let Some((_, own)) = joint.kind.one_freedom() else { continue };
        if let JointMotion::Prescribed(motion) = &own.motion {
            let still =
                matches!(motion, Motion::Polynomial(coefficients) if coefficients[1..].iter().all(|c| *c == 0.0));
            if index != shaft && !still {
                return Err(format!(
                    "the joint {} has a prescribed motion, which only the shaft may have; lock the joint or release it",
                    joint.name
                ));
            }
        }
    }
    if let Some(failure) = machine.failures.first() {
        return Err(format!("the failure {} ends the periodic motion; remove it from the model", failure.name));
    }
    let Some(air) = &machine.air else { return Ok(()) };
    if let Some(gust) = air.gusts.first() {
        return Err(format!("the gust {} is not periodic over a revolution; remove it from the model", gust.name));
    }
    match air.only() {
        None => Err(format!(
            "periodic motions have one aerodynamic model, and the model has {}: {}; keep one of them, or simulate the model",
            air.parts.len(),
            air.parts.iter().map(|part| part.name.as_str()).collect::<Vec<_>>().join(", ")
        )),
        Some(AirOptions::Lattice(_)) => {
            Err("the wake of a vortex lattice is not periodic; use model = \"bem\" or \"strip\"".to_owned())
        }
        Some(AirOptions::SlenderBody(_)) => {
            Err("periodic motions do not include slender bodies; remove them, or simulate the model".to_owned())
        }
        Some(AirOptions::Strips(_)) => Ok(()),
        Some(AirOptions::Rotor(options)) => match options.features.field.as_ref().map(|field| &field.source) {
            Some(Source::Table(table)) if table.rows.len() > 1 => {
                Err("a wind table over time is not periodic over a revolution; give one row, or a wind profile"
                    .to_owned())
            }
            Some(Source::Box(_)) => {
                Err("turbulence is not periodic over a revolution; remove [aerodynamics.turbulence] from the model"
                    .to_owned())
            }
            Some(Source::Steady(_) | Source::Table(_)) | None => Ok(()),
        },
    }
}
