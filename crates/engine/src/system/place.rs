//! Names of coordinates, for error messages.

use crate::beam::element::ElementKind;
use crate::machine::Travel;
use crate::multibody::model::Element;
use crate::multibody::norm;
use crate::solve::newton::NewtonError;
use crate::system::PlantError;
use crate::system::System;
use crate::system::magnitude::inputs_are_moderate;

/// Inputs through which a coupled model may close an algebraic loop via the root.
const ROOT_ACCELERATION: &str = "root.acceleration";
const ROOT_ANGULAR_ACCELERATION: &str = "root.angular_acceleration";
/// Advice if the iteration diverges in real-time mode.
const REAL_TIME_ADVICE: &str =
    "shorten solver.fixed_step_s, allow more solver.max_iterations, or use mode = \"accurate\"";

/// Reason why an internal step failed.
pub(crate) enum Failure {
    /// The error estimate is too large.
    Estimate {
        /// Kinematic norm of the estimate.
        error: f64,
        /// Allowed value.
        tolerance: f64,
    },
    /// The equations of a stage were not solved.
    Newton(NewtonError),
    /// After the limited number of iterations, a stage is too far from its solution to continue.
    Unsolved {
        /// Kinematic norm of the last correction: rotation in rad, or displacement divided by the model's length.
        rest: f64,
    },
    /// A joint rotates by more than half a revolution within a step of given length, so that the direction of rotation is ambiguous.
    Turned {
        /// Coordinate of its angle.
        coordinate: usize,
        /// Rotation in rad.
        turn_rad: f64,
    },
}

impl System {
    /// Error of a failed internal step from `start` of length `step_s`; `remainder` is the remaining correction or error estimate.
    pub(crate) fn no_convergence(&self, step_s: f64, failure: Failure, remainder: &[f64]) -> PlantError {
        if let (Failure::Newton(_) | Failure::Estimate { .. } | Failure::Unsolved { .. }, Some(error)) =
            (&failure, self.no_heading(&self.state.start, step_s))
        {
            return error;
        }
        let time_s = self.state.start.time_s;
        let place = match &failure {
            Failure::Newton(NewtonError::Singular(singular)) => self.place_of(singular.coordinate),
            Failure::Turned { coordinate, .. } => self.place_of(*coordinate),
            // the remainder is not finite: the accelerations at the start of the step are more informative
            Failure::Newton(NewtonError::NotFinite { .. }) => self.place_of_largest(&self.state.start.a),
            Failure::Estimate { .. } | Failure::Newton(_) | Failure::Unsolved { .. } => {
                self.place_of_largest(remainder)
            }
        };
        let (cause, advice) = match failure {
            Failure::Estimate { error, tolerance } => (
                format!("the error estimate {error:.1e} exceeds the tolerance {tolerance:.1e}"),
                "allow a larger solver.tolerance or a smaller solver.min_step",
            ),
            // whether the iteration overflows or merely diverges depends on round-off
            Failure::Newton(error) if !inputs_are_moderate(&self.state.applied_inputs) => (
                format!("{error}; {}", self.largest_input()),
                "check inputs and parameters far beyond the structure's strength",
            ),
            Failure::Newton(error) if self.machine.solver.most_iterations.is_some() => (
                format!("in real-time mode a stage has no solution: {error}; {}", self.largest_input()),
                REAL_TIME_ADVICE,
            ),
            Failure::Unsolved { rest } => (
                format!("in real-time mode the allowed iterations leave a correction of {rest:.1e} rad"),
                REAL_TIME_ADVICE,
            ),
            Failure::Turned { turn_rad, .. } => (
                format!("in real-time mode it rotates by {turn_rad:.1e} rad in one step, more than half a revolution"),
                REAL_TIME_ADVICE,
            ),
            Failure::Newton(error) => (
                format!("{error}; {}", self.largest_input()),
                "check loads, motor and latch there, or allow a smaller solver.min_step",
            ),
        };
        PlantError::NoConvergence { time_s, step_s, place, cause, advice }
    }

    /// Name of the element or joint with the largest contribution to a change of the coordinates.
    fn place_of_largest(&self, change: &[f64]) -> String {
        self.place_of(norm::largest_share(&self.equations.model, &self.equations.work, change))
    }

    /// Whether a coordinate belongs to a joint.
    pub(crate) fn is_joint(&self, coordinate: usize) -> bool {
        self.equations.model.bodies.iter().any(|body| body.joint.range().contains(&coordinate))
    }

    /// Name of the element or joint of a coordinate.
    pub(crate) fn place_of(&self, coordinate: usize) -> String {
        let model = &self.equations.model;
        for (body, machine) in model.bodies.iter().zip(&self.machine.bodies) {
            if body.joint.range().contains(&coordinate) {
                return format!("joint {}", machine.joint.name);
            }
            if let Some(modal) = body.modal.as_ref().filter(|modal| modal.range().contains(&coordinate)) {
                let mode = coordinate - modal.coordinate + 1;
                return format!("mode {mode} of {} of body {}", modal.element.modes, machine.name);
            }
            let elements = &model.elements[body.first_element..body.first_element + body.elements];
            let holds = |element: &Element| element.range().contains(&coordinate);
            if let Some(place) = elements.iter().position(holds) {
                let per_element = if body.kind == ElementKind::Linear { 2 } else { 1 };
                let (element, count) = (place / per_element + 1, body.elements / per_element);
                return format!("element {element} of {count} of body {}", machine.name);
            }
        }
        if let Some(circuit) = model.circuits.iter().find(|circuit| circuit.coordinate == coordinate) {
            return format!("the current of joint {}", self.machine.bodies[circuit.body].joint.name);
        }
        "no joint and no element".to_owned()
    }

    /// Name of the largest input among the current loads, torques, commands and motions, with the probable cause if it is an acceleration
    /// of the root.
    pub(crate) fn largest_input(&self) -> String {
        let inputs = &self.state.applied_inputs;
        let mut largest = (0.0, "all inputs are 0".to_owned());
        let mut offer = |value: f64, unit: &str, name: &dyn Fn() -> String| {
            if value.is_nan() || value.abs() > largest.0 {
                largest = (value.abs(), format!("the largest input is {} = {value:e} {unit}", name()));
            }
        };
        let root = &inputs.root();
        let vectors = [
            (&root.gravity_m_s2, "m/s2", "gravity"),
            (&root.acceleration_m_s2, "m/s2", ROOT_ACCELERATION),
            (&root.angular_velocity_rad_s, "rad/s", "root.angular_velocity"),
            (&root.angular_acceleration_rad_s2, "rad/s2", ROOT_ANGULAR_ACCELERATION),
            (inputs.wind_m_s(), "m/s", "wind.velocity"),
        ];
        for (vector, unit, name) in vectors {
            for (value, axis) in vector.iter().zip(["x", "y", "z"]) {
                offer(*value, unit, &|| format!("{name}.{axis}"));
            }
        }
        for (flap, described) in inputs.flaps().iter().zip(self.machine.air.iter().flat_map(|air| &air.flaps)) {
            offer(flap.command_rad, "rad", &|| format!("aero.control_surface.{}.angle_command", described.name));
            offer(flap.command_rate_rad_s, "rad/s", &|| {
                format!("aero.control_surface.{}.angle_command_rate", described.name)
            });
        }
        for (joint, &body) in inputs.joints().iter().zip(&self.revolute_joints) {
            let described = &self.machine.bodies[body].joint;
            let (name, travel) = (&described.name, described.kind.one_freedom().map(|(travel, _)| travel));
            let travel = travel.unwrap_or(Travel::Rotation);
            offer(joint.torque_n_m, travel.effort_unit(), &|| format!("{name}.{}", travel.words("external_torque")));
            offer(joint.command_rad, travel.units()[0], &|| format!("{name}.{}", travel.words("angle_command")));
        }
        for (own, (joint, _)) in inputs.dc_motors().iter().zip(self.machine.dc_motors()) {
            offer(own.voltage_v, "V", &|| format!("{}.voltage", self.joint_name(joint)));
        }
        let stations =
            self.machine.bodies.iter().flat_map(|body| (0..body.station_positions_m.len()).map(move |i| (body, i)));
        for (load, (body, station)) in inputs.stations().iter().zip(stations) {
            for (vector, unit, what) in [(&load.force_n, "N", "force"), (&load.moment_n_m, "N.m", "moment")] {
                for (value, axis) in vector.iter().zip(["x", "y", "z"]) {
                    offer(*value, unit, &|| format!("load.{}[{}].{what}.{axis}", body.name, station + 1));
                }
            }
        }
        let largest = largest.1;
        if [ROOT_ACCELERATION, ROOT_ANGULAR_ACCELERATION].iter().any(|name| largest.contains(&format!("{name}."))) {
            let mass_kg = self.mass_kg();
            format!(
                "{largest}; if this input is computed from root.force, the carrier must be heavier than the wing \
                 ({mass_kg:.3} kg)"
            )
        } else {
            largest
        }
    }
}
