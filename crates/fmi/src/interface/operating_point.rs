//! Operating point of a linear model: time, joints, latches, and acting inputs.

use crate::interface::{Causality, Interface, Value};
use foldwing_engine::machine::{JointMotion, LatchKind, Travel};
use foldwing_engine::plant::Plant;
use nalgebra::Complex;
use std::fmt;

/// Ratio of the imaginary to the real part of an eigenvalue below which the imaginary part is round-off.
const ROUND_OFF: f64 = 1e-9;

/// The state about which a model is linearised, in readable form.
#[derive(Debug, Clone, PartialEq)]
pub struct OperatingPoint {
    /// Time in s.
    pub time_s: f64,
    /// The model is in static equilibrium; false at a start that is not an equilibrium, and during a run.
    pub equilibrium: bool,
    /// Revolute and prismatic joints, in the order of the model.
    pub joints: Vec<JointPoint>,
    /// Acting inputs: all Booleans, and Reals that are not 0.
    pub acting: Vec<Acting>,
    /// Unstable eigenvalues in 1/s of the linear model, fastest-growing first, among its modes of lowest frequency; one of each conjugate
    /// pair. With a vortex lattice they are `ln z` of the discrete-time eigenvalues divided by the step. `None` for machines that are too
    /// large for the computation.
    pub growing_1_s: Option<Vec<Complex<f64>>>,
}

/// A revolute or prismatic joint at the operating point.
#[derive(Debug, Clone, PartialEq)]
pub struct JointPoint {
    /// Its name.
    pub name: String,
    /// Rotation or translation.
    pub travel: Travel,
    /// Fold angle in rad, or position in m.
    pub angle_rad: f64,
    /// `free`, `held` by its lock or a closed rigid latch, `locked` or `prescribed`: the coordinate is a state of the linear model if it is
    /// free.
    pub motion: &'static str,
    /// `closed` (an elastic latch is a stiff spring of the linear model, a rigid one holds the joint), `open`, or `none`.
    pub latch: &'static str,
}

/// An acting input.
#[derive(Debug, Clone, PartialEq)]
pub struct Acting {
    /// Name in the table.
    pub name: String,
    /// Unit; empty for Booleans.
    pub unit: String,
    /// Value.
    pub value: Value,
}

impl Interface {
    /// The plant's current state as an operating point, with the unstable eigenvalues about it.
    pub(super) fn operating_point(&self, plant: &Plant, growing_1_s: Option<Vec<Complex<f64>>>) -> OperatingPoint {
        let machine = plant.machine();
        let statuses = plant.joint_statuses().zip(plant.outputs().joints()).zip(plant.revolute_joints());
        let joints = statuses.map(|((status, outputs), body)| {
            let joint = &machine.bodies[*body].joint;
            let own = joint.kind.one_freedom();
            let (motion, latch) = (own.map(|(_, own)| &own.motion), own.and_then(|(_, own)| own.latch.as_ref()));
            let latched_rigidly = status.latched && latch.is_some_and(|latch| latch.kind == LatchKind::Rigid);
            let motion = match motion {
                Some(JointMotion::Locked) => "locked",
                Some(JointMotion::Prescribed(_)) => "prescribed",
                Some(JointMotion::Free) | None if status.released && !latched_rigidly => "free",
                Some(JointMotion::Free) | None => "held",
            };
            let latch = match (latch.is_some(), status.latched) {
                (false, _) => "none",
                (true, true) => "closed",
                (true, false) => "open",
            };
            let travel = own.map_or(Travel::Rotation, |(travel, _)| travel);
            JointPoint { name: joint.name.clone(), travel, angle_rad: outputs.angle_rad, motion, latch }
        });
        let inputs = self.variables().iter().filter(|row| row.causality == Causality::Input);
        let acting = inputs.filter_map(|row| {
            let value = self.get(plant, plant.outputs(), row.value_reference)?;
            let acts = !matches!(value, Value::Real(0.0));
            acts.then(|| Acting { name: row.name.clone(), unit: row.unit().to_owned(), value })
        });
        OperatingPoint {
            time_s: plant.time_s(),
            equilibrium: plant.is_at_rest(),
            joints: joints.collect(),
            acting: acting.collect(),
            growing_1_s,
        }
    }
}

impl fmt::Display for OperatingPoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let state = if self.equilibrium { "an equilibrium" } else { "a state that is not an equilibrium" };
        write!(f, "about {state} at t = {} s", self.time_s)?;
        for JointPoint { name, travel, angle_rad, motion, latch } in &self.joints {
            write!(f, "; {name} at {:.4} {}, {motion}", travel.shown(*angle_rad), travel.shown_unit())?;
            if *latch != "none" {
                write!(f, ", latch {latch}")?;
            }
        }
        for (i, Acting { name, unit, value }) in self.acting.iter().enumerate() {
            let begin = if i == 0 { "; with " } else { ", " };
            match value {
                Value::Real(value) => write!(f, "{begin}{name} = {value} {unit}")?,
                Value::Integer(value) => write!(f, "{begin}{name} = {value}")?,
                Value::Boolean(value) => write!(f, "{begin}{name} = {value}")?,
            }
        }
        match self.growing_1_s.as_deref() {
            Some([]) | None => Ok(()),
            Some([fastest, ..]) if fastest.im.abs() <= ROUND_OFF * fastest.re => {
                write!(f, "; UNSTABLE: grows with {:.4} 1/s", fastest.re)
            }
            Some([fastest, ..]) => {
                let frequency_hz = fastest.im.abs() / std::f64::consts::TAU;
                write!(f, "; UNSTABLE: grows with {:.4} 1/s, oscillating at {frequency_hz:.4} Hz", fastest.re)
            }
        }
    }
}
