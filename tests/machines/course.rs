//! Actions on a machine during a run: inputs that change at communication points.

use crate::machines::view::{Frame, View};
use foldwing::load::{LoadFrame, Wrench};
use foldwing::machine::JointKind;
use foldwing::plant::Plant;
use nalgebra::Vector3;

/// Actions. Indices are taken modulo the number of parts, so that the same actions also apply to a machine with parts removed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Doing {
    RootAcceleration(Vector3<f64>),
    RootSpin(Vector3<f64>, Vector3<f64>),
    Wind(Vector3<f64>),
    Load(usize, Vector3<f64>, Vector3<f64>),
    Command(usize, f64),
    Torque(usize, f64),
    Release(usize, bool),
    LatchEnable(usize, bool),
    GeneratorOn(usize, bool),
    Trigger(usize),
    Flap(usize, f64),
}

/// An action at the start of a communication step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Action {
    pub step: usize,
    pub doing: Doing,
}

impl Action {
    pub fn apply(&self, plant: &mut Plant, view: &View) {
        let frames: Vec<LoadFrame> = (plant.machine().bodies.iter())
            .flat_map(|body| body.station_positions_m.iter().map(|_| body.load_frame))
            .collect();
        let slides = |kind: &JointKind| match kind {
            JointKind::Prismatic(_) | JointKind::Sliding(_) => Some(true),
            JointKind::Revolute(_) => Some(false),
            JointKind::Clamped | JointKind::Spatial(_) => None,
        };
        let prismatic: Vec<bool> = plant.machine().bodies.iter().filter_map(|body| slides(&body.joint.kind)).collect();
        // rad and N·m for revolute joints; a prismatic joint moves by centimetres
        let scaled = |joint: usize, value: f64| if prismatic[joint] { 0.05 * value } else { value };
        let inputs = plant.inputs_mut();
        let place = |index: usize, count: usize| (count > 0).then(|| index % count.max(1));
        let (joints, stations) = (inputs.joints().len(), inputs.stations().len());
        match self.doing {
            Doing::RootAcceleration(v) => inputs.root_mut().acceleration_m_s2 = view.polar(v, Frame::Root),
            Doing::RootSpin(rate, pull) => {
                inputs.root_mut().angular_velocity_rad_s = view.axial(rate, Frame::Root);
                inputs.root_mut().angular_acceleration_rad_s2 = view.axial(pull, Frame::Root);
            }
            Doing::Wind(v) => *inputs.wind_m_s_mut() += view.polar(v, Frame::Root),
            Doing::Load(index, force, moment) => {
                if let Some(index) = place(index, stations) {
                    let frame = if frames[index] == LoadFrame::Root { Frame::Root } else { Frame::Body };
                    let wrench = Wrench { force_n: view.polar(force, frame), moment_n_m: view.axial(moment, frame) };
                    inputs.stations_mut()[index] = wrench;
                }
            }
            Doing::Command(index, value) => {
                if let Some(index) = place(index, joints) {
                    inputs.joints_mut()[index].command_rad += scaled(index, value);
                }
            }
            Doing::Torque(index, value) => {
                if let Some(index) = place(index, joints) {
                    inputs.joints_mut()[index].torque_n_m = value;
                }
            }
            Doing::Release(index, on) => {
                if let Some(index) = place(index, joints) {
                    inputs.joints_mut()[index].release = on.into();
                }
            }
            Doing::LatchEnable(index, on) => {
                if let Some(index) = place(index, joints) {
                    inputs.joints_mut()[index].latch_enable = on.into();
                }
            }
            Doing::GeneratorOn(index, on) => {
                if let Some(index) = place(index, joints) {
                    inputs.joints_mut()[index].generator_on = on.into();
                }
            }
            Doing::Trigger(index) => {
                if let Some(index) = place(index, inputs.failures().len()) {
                    inputs.failures_mut()[index] = true.into();
                }
            }
            Doing::Flap(index, value) => {
                if let Some(index) = place(index, inputs.flaps().len()) {
                    inputs.flaps_mut()[index].command_rad = value;
                }
            }
        }
    }
}
