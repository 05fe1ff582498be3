//! Inputs of a model.

use crate::load::{RootMotion, Wrench};
use crate::machine::Machine;
use crate::signal::{Segment, Switch, are_finite, views};
use bytemuck::{Pod, Zeroable};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Inputs of one revolute or prismatic joint.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct JointInputs {
    /// Commanded neutral angle `θ_cmd` in rad.
    pub command_rad: f64,
    /// External torque `τ_ext` on the outer body about `+θ` in N·m.
    pub torque_n_m: f64,
    /// Release of the lock; off locks the joint at its position.
    pub release: Switch,
    /// Whether the latch may close; ignored by joints without a latch.
    pub latch_enable: Switch,
    /// Whether the generator is connected; ignored by joints without one.
    pub generator_on: Switch,
}

/// Inputs of one electrical DC motor.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct DcMotorInputs {
    /// Voltage at the armature in V.
    pub voltage_v: f64,
}

/// Inputs of one control surface.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub struct FlapInputs {
    /// Deflection angle in rad; positive moves the trailing edge towards the section's `−z`.
    pub command_rad: f64,
    /// Rate of the angle in rad/s, which the caller keeps consistent with the angle.
    pub command_rate_rad_s: f64,
}

/// Layout of [`Inputs::values`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct InputLayout {
    /// See [`Inputs::joints`].
    pub joints: Segment<JointInputs>,
    /// See [`Inputs::stations`].
    pub stations: Segment<Wrench>,
    /// See [`Inputs::root`].
    pub root: Segment<RootMotion>,
    /// See [`Inputs::wind_m_s`].
    pub wind_m_s: Segment<Vector3<f64>>,
    /// See [`Inputs::failures`].
    pub failures: Segment<Switch>,
    /// See [`Inputs::flaps`].
    pub flaps: Segment<FlapInputs>,
    /// See [`Inputs::dc_motors`].
    pub dc_motors: Segment<DcMotorInputs>,
    /// Length of the vector.
    end: usize,
}

impl InputLayout {
    /// Layout for a model.
    pub fn new(machine: &Machine) -> Self {
        let mut end = 0;
        let stations = machine.bodies.iter().map(|body| body.station_positions_m.len()).sum();
        Self {
            joints: Segment::append(&mut end, machine.one_freedoms().count()),
            stations: Segment::append(&mut end, stations),
            root: Segment::append(&mut end, 1),
            wind_m_s: Segment::append(&mut end, 1),
            failures: Segment::append(&mut end, machine.failures.len()),
            flaps: Segment::append(&mut end, machine.air.as_ref().map_or(0, |air| air.flaps.len())),
            dc_motors: Segment::append(&mut end, machine.dc_motors().count()),
            end,
        }
    }
}

/// All inputs, held constant during a step, or their rates per second (switches are then off).
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Inputs {
    layout: InputLayout,
    values: Vec<f64>,
}

/// Written by hand, because a derived `clone_from` allocates and inputs are copied whenever they change.
impl Clone for Inputs {
    fn clone(&self) -> Self {
        Self { layout: self.layout, values: self.values.clone() }
    }

    fn clone_from(&mut self, source: &Self) {
        self.layout = source.layout;
        self.values.clone_from(&source.values);
    }
}

impl Inputs {
    /// Start values of a model's inputs.
    pub fn of(machine: &Machine) -> Self {
        let layout = InputLayout::new(machine);
        let mut inputs = Self { layout, values: vec![0.0; layout.end] };
        for (own, (_, joint)) in inputs.joints_mut().iter_mut().zip(machine.one_freedoms()) {
            *own = JointInputs {
                command_rad: joint.motor.command_rad,
                torque_n_m: 0.0,
                release: joint.release.into(),
                latch_enable: joint.latch.as_ref().is_some_and(|latch| latch.enable).into(),
                generator_on: joint.generator.as_ref().is_some_and(|generator| generator.connected).into(),
            };
        }
        let loads = machine.bodies.iter().flat_map(|body| {
            let load = |i: usize| body.station_loads.get(i).copied().unwrap_or_default();
            (0..body.station_positions_m.len()).map(load)
        });
        inputs.stations_mut().iter_mut().zip(loads).for_each(|(own, load)| *own = load);
        inputs.root_mut().gravity_m_s2 = machine.gravity_m_s2;
        let flaps = machine.air.iter().flat_map(|air| &air.flaps);
        for (own, flap) in inputs.flaps_mut().iter_mut().zip(flaps) {
            own.command_rad = flap.command_rad;
        }
        for (own, (_, dc_motor)) in inputs.dc_motors_mut().iter_mut().zip(machine.dc_motors()) {
            own.voltage_v = dc_motor.voltage_v;
        }
        *inputs.wind_m_s_mut() = machine.air.as_ref().map_or(Vector3::zeros(), |air| air.wind_m_s);
        inputs
    }

    /// Layout of [`Self::values`].
    pub fn layout(&self) -> &InputLayout {
        &self.layout
    }

    /// All values in SI units; switches are 1 or 0.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// All values, mutable.
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values
    }

    views! { (pub)
        /// Inputs of each revolute or prismatic joint, in the order of `Plant::revolute_joints`.
        joints, joints_mut: [JointInputs];
        /// Total force and moment at each station, bodies in model order, stations from the inner end outward, each in its body's
        /// `load_frame`.
        stations, stations_mut: [Wrench];
        /// One switch per failure: on triggers it, off has no effect.
        failures, failures_mut: [Switch];
        /// Inputs of each control surface, in the order of [`crate::machine::Air::flaps`].
        flaps, flaps_mut: [FlapInputs];
        /// Inputs of each electrical DC motor, in the order of [`Machine::dc_motors`].
        dc_motors, dc_motors_mut: [DcMotorInputs];
        ;
        /// Gravity and motion of the root.
        root, root_mut: RootMotion;
        /// Velocity of the air relative to the root's origin, root frame, m/s; ignored by models without aerodynamics.
        wind_m_s, wind_m_s_mut: Vector3<f64>;
    }

    /// Zero rates: inputs of the same sizes, all zero.
    pub fn no_rates(&self) -> Self {
        Self { layout: self.layout, values: vec![0.0; self.values.len()] }
    }

    /// Whether all values are zero, interpreted as rates.
    pub fn is_still(&self) -> bool {
        self.values.iter().all(|&value| value == 0.0)
    }

    /// Sets all values to zero, as rates. Does not allocate.
    pub(crate) fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Adds `elapsed_s` times `rates` (per second), NOTATION eq. (A4). Does not allocate.
    pub(crate) fn run_on(&mut self, rates: &Self, elapsed_s: f64) {
        self.values.iter_mut().zip(&rates.values).for_each(|(value, rate)| *value += rate * elapsed_s);
    }

    /// Whether these inputs have the layout of a model.
    pub(crate) fn fit(&self, layout: &InputLayout) -> bool {
        self.layout == *layout && self.values.len() == layout.end
    }

    /// Whether the values are valid in a run: finite, switches on or off.
    pub(crate) fn can_be(&self) -> bool {
        let valid = |joint: &JointInputs| {
            [joint.release, joint.latch_enable, joint.generator_on].iter().all(|switch| switch.is_valid())
        };
        are_finite(&self.values)
            && self.joints().iter().all(valid)
            && self.failures().iter().all(|failure| failure.is_valid())
    }

    /// Whether the values are valid as rates in a run: those of switches must be off.
    pub(crate) fn can_be_rates(&self) -> bool {
        let still = |joint: &JointInputs| [joint.release, joint.latch_enable, joint.generator_on] == [Switch::OFF; 3];
        self.joints().iter().all(still) && self.failures().iter().all(|&failure| failure == Switch::OFF)
    }
}
