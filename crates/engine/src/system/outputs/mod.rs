//! Outputs: one flat vector, with one source file per group, and their values at the current time.

mod attitudes;
mod dc_motors;
mod energies;
mod failures;
mod feedthrough;
mod flaps;
mod framed_bodies;
mod gauges;
mod generators;
mod joints;
mod latches;
mod loads;
mod output_set;
mod points;
mod present;
mod spatial;
mod values;

pub use dc_motors::DcMotorOutputs;
pub use energies::EnergyOutputs;
pub use failures::FailureOutputs;
pub use flaps::FlapOutputs;
pub use framed_bodies::ModalOutputs;
pub(crate) use gauges::gauge_points;
pub use generators::GeneratorOutputs;
pub use joints::JointOutputs;
pub use latches::LatchOutputs;
pub use loads::{LoopOutputs, NoSlipOutputs};
pub use output_set::OutputSet;
pub use points::PointOutputs;
pub use spatial::SpatialOutputs;
pub use values::{OutputLayout, Outputs};

use crate::multibody::kinematics::{sweep_motion, sweep_poses};

use crate::multibody::motion::Motion;
use crate::solve::EquationsOfMotion;
use crate::system::System;
use output_set::Sweep;
use present::Present;

impl System {
    /// Selects the outputs that `Plant::step` evaluates; initially all. Selected outputs that are not up to date are evaluated immediately.
    ///
    /// Other outputs keep their previous value in [`System::outputs`] until [`System::provide`] is called for them. Descriptions of the
    /// whole wing ([`System::sections`], [`System::shape`], [`System::section_strains`], linear models, modes) need [`OutputSet::ALL`].
    /// Later steps do not depend on the selection.
    pub fn watch(&mut self, wanted: OutputSet) {
        self.watched = wanted;
        if self.state.initialized {
            self.provide(wanted);
        }
    }

    /// Evaluates those of `wanted` that are not up to date at the current time, with the set inputs: forces and accelerations have direct
    /// feedthrough. Allocates nothing.
    pub fn provide(&mut self, wanted: OutputSet) {
        if self.state.initialized && !self.found.contains(wanted) {
            let missing = wanted.without(self.found);
            if !(self.inputs_may_differ && self.evaluate_with_set_inputs(missing)) {
                self.evaluate_some(missing);
            }
        }
    }

    /// Evaluates all outputs again if inputs have been set since the last step, with these inputs instead of the applied ones.
    pub(crate) fn show_set_inputs(&mut self) {
        if self.inputs_may_differ && self.state.initialized {
            self.forget_outputs();
            self.provide(OutputSet::ALL);
        }
    }

    /// Whether these outputs are up to date at the current time.
    pub fn provides(&self, wanted: OutputSet) -> bool {
        !self.state.initialized || self.found.contains(wanted)
    }

    /// Evaluates all outputs from the current state and the inputs of the last step. Allocates nothing.
    pub(crate) fn evaluate(&mut self) {
        self.evaluate_only(OutputSet::ALL);
    }

    /// Like [`Self::evaluate`], for the outputs in `wanted`.
    pub(crate) fn evaluate_only(&mut self, wanted: OutputSet) {
        self.found = OutputSet::NONE;
        self.evaluate_some(wanted);
    }

    /// Marks all outputs as out of date, because the current state has changed.
    pub(crate) fn forget_outputs(&mut self) {
        self.found = OutputSet::NONE;
        self.outputs.time_s = self.state.now.time_s;
        self.equations.branch_s = self.state.now.time_s;
    }

    fn evaluate_some(&mut self, wanted: OutputSet) {
        // aerodynamic loads are read at the load stations and along the surfaces
        let wanted = if self.air.is_some() { OutputSet::ALL } else { wanted };
        self.found = self.found | wanted;
        self.sweep_for(wanted);
        let (state, outputs) = (&self.state, &mut self.outputs);
        let now = &state.now;
        outputs.time_s = now.time_s;
        let present = Present { state, equations: &self.equations, motion: Motion { q: &now.q, v: &now.v, a: &now.a } };
        if wanted.meets(OutputSet::JOINTS) {
            joints::fill(outputs.joints_mut(), &present);
            latches::fill(outputs.latches_mut(), &present);
            failures::fill(outputs.failures_mut(), &present);
            generators::fill(outputs.generators_mut(), &present);
            dc_motors::fill(outputs.dc_motors_mut(), &present);
        }
        if wanted.meets(OutputSet::HOLDING) {
            joints::fill_holding(outputs.joints_mut(), &present);
        }
        if wanted.meets(OutputSet::SPATIAL) {
            spatial::fill(outputs.spatial_mut(), &present);
        }
        if wanted.meets(OutputSet::REACTIONS) {
            loads::fill_reactions(outputs.joint_reactions_mut(), &present);
            for (index, place) in self.machine.framed_bodies().enumerate() {
                let reaction = outputs.joint_reactions()[place];
                framed_bodies::fill_root(&mut outputs.modal_mut()[index], (place, &self.machine), &reaction, &present);
            }
        }
        if wanted.meets(OutputSet::GAUGES) {
            loads::fill_gauges(outputs.gauges_mut(), &present, &self.gauges);
        }
        if wanted.meets(OutputSet::SECTION_LOADS) {
            loads::fill_sections(outputs.section_loads_mut(), &present);
        }
        if wanted.meets(OutputSet::LOOPS) {
            loads::fill_loops(outputs.loops_mut(), &present, &self.machine);
            loads::fill_no_slips(outputs.no_slips_mut(), &present);
        }
        if wanted.meets(OutputSet::ROOT) {
            loads::fill_root(outputs.root_mut(), &present);
        }
        if wanted.meets(OutputSet::TIP_PLACES) {
            framed_bodies::fill_deflections(outputs.modal_mut(), &self.machine, &present);
        }
        points::fill_tips(outputs.tips_mut(), &present, &self.tip_bodies, wanted);
        points::fill_stations(outputs.stations_mut(), &present, wanted);
        if wanted.meets(OutputSet::ENERGIES) {
            energies::fill(outputs.energy_mut(), &present);
        }
        if wanted.meets(OutputSet::ACCOUNTS) {
            energies::fill_accounts(outputs.energy_mut(), &present);
        }
        if let (Some(air), Some(history)) = (&mut self.air, &state.air) {
            air.report(&self.equations, history, now, outputs);
        }
    }

    /// Updates the equations to the current time to the extent that some outputs require.
    fn sweep_for(&mut self, wanted: OutputSet) {
        let (now, equations) = (&self.state.now, &mut self.equations);
        let time_s = now.time_s;
        equations.branch_s = time_s;
        let motion = Motion { q: &now.q, v: &now.v, a: &now.a };
        let sweep = wanted.sweep(self.gauges_need_forces);
        match sweep {
            // linear models continue from a complete residual, and only it contains the constraint torques
            _ if wanted == OutputSet::ALL || wanted.meets(OutputSet::HOLDING) => {
                equations.residual(time_s, &now.q, &now.v, &now.a, &mut self.scratch[0]);
            }
            // with inputs that vary in time, the residual updates them
            _ if equations.course.moves || sweep == Sweep::Residual => {
                equations.wrenches(time_s, motion, &mut self.scratch[0]);
            }
            Sweep::Nothing | Sweep::Residual => {}
            Sweep::Poses => sweep_poses(&equations.model, &mut equations.work, motion.q),
            Sweep::Motion => sweep_motion(&equations.model, &mut equations.work, motion),
        }
    }
}
