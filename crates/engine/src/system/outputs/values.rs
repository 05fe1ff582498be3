//! All outputs in one flat vector: its layout, and views of its groups.

use crate::aero::RotorLoads;
use crate::load::Wrench;
use crate::machine::Machine;
use crate::signal::{Segment, are_finite, views};
use crate::system::outputs::dc_motors::DcMotorOutputs;
use crate::system::outputs::energies::EnergyOutputs;
use crate::system::outputs::failures::FailureOutputs;
use crate::system::outputs::flaps::FlapOutputs;
use crate::system::outputs::framed_bodies::ModalOutputs;
use crate::system::outputs::generators::GeneratorOutputs;
use crate::system::outputs::joints::JointOutputs;
use crate::system::outputs::latches::LatchOutputs;
use crate::system::outputs::loads::{LoopOutputs, NoSlipOutputs};
use crate::system::outputs::output_set::OutputSet;
use crate::system::outputs::points::{PointOutputs, UPRIGHT};
use crate::system::outputs::spatial::SpatialOutputs;
use nalgebra::Vector3;
use std::mem::offset_of;

/// Layout of [`Outputs::values`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputLayout {
    /// See [`Outputs::joints`].
    pub joints: Segment<JointOutputs>,
    /// See [`Outputs::spatial`].
    pub spatial: Segment<SpatialOutputs>,
    /// See [`Outputs::joint_reactions`].
    pub joint_reactions: Segment<Wrench>,
    /// See [`Outputs::gauges`].
    pub gauges: Segment<f64>,
    /// See [`Outputs::internal_loads`].
    pub internal_loads: Segment<Wrench>,
    /// See [`Outputs::loops`].
    pub loops: Segment<LoopOutputs>,
    /// See [`Outputs::no_slips`].
    pub no_slips: Segment<NoSlipOutputs>,
    /// See [`Outputs::root`].
    pub root: Segment<Wrench>,
    /// See [`Outputs::tips`].
    pub tips: Segment<PointOutputs>,
    /// See [`Outputs::stations`].
    pub stations: Segment<PointOutputs>,
    /// See [`Outputs::energy`].
    pub energy: Segment<EnergyOutputs>,
    /// See [`Outputs::air_total`].
    pub air_total: Segment<Wrench>,
    /// See [`Outputs::air_stations`].
    pub air_stations: Segment<Wrench>,
    /// See [`Outputs::circulation_m2_s`].
    pub circulation_m2_s: Segment<f64>,
    /// See [`Outputs::rotor`].
    pub rotor: Segment<RotorLoads>,
    /// See [`Outputs::flaps`].
    pub flaps: Segment<FlapOutputs>,
    /// See [`Outputs::generators`].
    pub generators: Segment<GeneratorOutputs>,
    /// See [`Outputs::dc_motors`].
    pub dc_motors: Segment<DcMotorOutputs>,
    /// See [`Outputs::modal`].
    pub modal: Segment<ModalOutputs>,
    /// See [`Outputs::latches`].
    pub latches: Segment<LatchOutputs>,
    /// See [`Outputs::failures`].
    pub failures: Segment<FailureOutputs>,
    /// Number of values that vary continuously; those after them change at events only.
    continuous: usize,
    /// Length of the vector.
    end: usize,
}

impl OutputLayout {
    /// Whether a value changes at events only.
    pub(crate) fn changes_at_events(&self, index: usize) -> bool {
        index >= self.continuous
    }

    /// Indices of the energy accounts, work of the inputs and energy dissipated, which are integrals over the run.
    pub fn accounts(&self) -> [usize; 2] {
        [offset_of!(EnergyOutputs, work), offset_of!(EnergyOutputs, dissipated)]
            .map(|offset| self.energy.place(0, offset))
    }

    /// Group of outputs that a value belongs to; all outputs for values of the aerodynamics and of events.
    pub(crate) fn group(&self, index: usize) -> OutputSet {
        let groups = [
            (self.joints.range(), OutputSet::JOINTS | OutputSet::HOLDING),
            (self.spatial.range(), OutputSet::SPATIAL),
            (self.joint_reactions.range(), OutputSet::REACTIONS),
            (self.gauges.range(), OutputSet::GAUGES),
            (self.internal_loads.range(), OutputSet::SECTION_LOADS),
            (self.loops.range(), OutputSet::LOOPS),
            (self.no_slips.range(), OutputSet::LOOPS),
            (self.root.range(), OutputSet::ROOT),
            (self.tips.range(), OutputSet::TIP_PLACES | OutputSet::TIP_MOTIONS),
            (
                self.stations.range(),
                OutputSet::STATION_PLACES | OutputSet::STATION_MOTIONS | OutputSet::STATION_ACCELERATIONS,
            ),
            (self.energy.range(), OutputSet::ENERGIES),
        ];
        groups.into_iter().find(|(range, _)| range.contains(&index)).map_or(OutputSet::ALL, |(_, group)| group)
    }

    /// Layout for a model.
    pub fn new(machine: &Machine) -> Self {
        let mut end = 0;
        let (one_freedoms, bodies) = (machine.one_freedoms().count(), machine.bodies.len());
        let stations = machine.bodies.iter().map(|body| body.station_positions_m.len()).sum();
        let surfaces = machine.air.iter().flat_map(|air| &air.surfaces);
        Self {
            joints: Segment::append(&mut end, one_freedoms),
            spatial: Segment::append(&mut end, machine.spatials().count()),
            joint_reactions: Segment::append(&mut end, bodies),
            gauges: Segment::append(&mut end, machine.gauges.len()),
            internal_loads: Segment::append(&mut end, machine.internal_loads.len()),
            loops: Segment::append(&mut end, machine.closures.len()),
            no_slips: Segment::append(&mut end, machine.no_slips.len()),
            root: Segment::append(&mut end, 1),
            tips: Segment::append(&mut end, machine.tip_bodies().count()),
            stations: Segment::append(&mut end, stations),
            energy: Segment::append(&mut end, 1),
            air_total: Segment::append(&mut end, 1),
            air_stations: Segment::append(&mut end, if machine.air.is_some() { stations } else { 0 }),
            circulation_m2_s: Segment::append(&mut end, surfaces.map(|surface| surface.positions_m.len() - 1).sum()),
            rotor: Segment::append(&mut end, machine.air.as_ref().map_or(0, |air| air.rotors().count())),
            flaps: Segment::append(&mut end, machine.air.as_ref().map_or(0, |air| air.flaps.len())),
            generators: Segment::append(&mut end, machine.generators().count()),
            dc_motors: Segment::append(&mut end, machine.dc_motors().count()),
            modal: Segment::append(&mut end, machine.framed_bodies().count()),
            continuous: end,
            latches: Segment::append(&mut end, one_freedoms),
            failures: Segment::append(&mut end, machine.failures.len()),
            end,
        }
    }
}

/// All outputs of the interface at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    /// Time in s.
    pub time_s: f64,
    layout: OutputLayout,
    values: Vec<f64>,
}

impl Outputs {
    views! { (pub(crate))
        /// Per revolute or prismatic joint, in the order of [`crate::system::System::revolute_joints`].
        joints, joints_mut: [JointOutputs];
        /// Per revolute or prismatic joint: its latch.
        latches, latches_mut: [LatchOutputs];
        /// Per failure, in the order of [`Machine::failures`].
        failures, failures_mut: [FailureOutputs];
        /// Per universal, ball or free joint, in the order of [`crate::system::System::spatial_joints`].
        spatial, spatial_mut: [SpatialOutputs];
        /// Per body: force and moment of the joint on the body's inner end, root frame, at that end.
        joint_reactions, joint_reactions_mut: [Wrench];
        /// Axial strain at each gauge.
        gauges, gauges_mut: [f64];
        /// Per position of [`Machine::internal_loads`]: force and moment of the part outboard of the section on the part inboard of it,
        /// section frame.
        internal_loads, section_loads_mut: [Wrench];
        /// Per closed loop, in the order of [`Machine::closures`].
        loops, loops_mut: [LoopOutputs];
        /// Per skate or wheel, in the order of [`Machine::no_slips`].
        no_slips, no_slips_mut: [NoSlipOutputs];
        /// Per free end, in the order of [`crate::system::System::tip_bodies`].
        tips, tips_mut: [PointOutputs];
        /// Per station, in the order of [`crate::signal::Inputs::stations`].
        stations, stations_mut: [PointOutputs];
        /// Per load station of models with aerodynamics: aerodynamic force and moment on the part of the body that is nearest to it, at
        /// the station, root frame.
        air_stations, air_stations_mut: [Wrench];
        /// Per strip, surfaces in the order of their bodies: circulation in m²/s.
        circulation_m2_s, circulation_m2_s_mut: [f64];
        /// Per rotor, in the order of [`crate::machine::Air::parts`]: its loads.
        rotor, rotor_mut: [RotorLoads];
        /// Per control surface, in the order of [`crate::machine::Air::flaps`].
        flaps, flaps_mut: [FlapOutputs];
        /// Per generator, in the order of their joints.
        generators, generators_mut: [GeneratorOutputs];
        /// Per electrical DC motor, in the order of their joints.
        dc_motors, dc_motors_mut: [DcMotorOutputs];
        /// Per modal body, in the order of the bodies.
        modal, modal_mut: [ModalOutputs];
        ;
        /// Force and moment of the wing on the aircraft at the origin, root frame.
        root, root_mut: Wrench;
        /// Energies.
        energy, energy_mut: EnergyOutputs;
        /// Aerodynamic force and moment at the origin, root frame; zero without aerodynamics.
        air_total, air_total_mut: Wrench;
    }

    /// Zero outputs with the sizes of a model, before initialisation.
    pub(crate) fn blank(machine: &Machine) -> Self {
        let layout = OutputLayout::new(machine);
        let mut outputs = Self { time_s: 0.0, layout, values: vec![0.0; layout.end] };
        outputs.latches_mut().fill(LatchOutputs::OPEN);
        outputs.failures_mut().fill(FailureOutputs::NONE);
        let upright = SpatialOutputs { rotation: UPRIGHT, angular_velocity_rad_s: Vector3::zeros() };
        outputs.spatial_mut().fill(upright);
        outputs.tips_mut().fill(PointOutputs::BLANK);
        outputs.stations_mut().fill(PointOutputs::BLANK);
        outputs
    }

    /// Layout of [`Self::values`].
    pub fn layout(&self) -> &OutputLayout {
        &self.layout
    }

    /// All values in SI units: first those that vary continuously, then those of [`Self::latches`] and [`Self::failures`]. Switches are 1
    /// or 0, quaternions are `x, y, z, w`.
    #[inline]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Whether all outputs are finite.
    pub(crate) fn are_finite(&self) -> bool {
        are_finite(&self.values)
    }

    /// Zero derivatives with the same layout. Attitudes then hold the derivatives of their four components.
    pub(crate) fn no_change(&self) -> Self {
        Self { time_s: 0.0, layout: self.layout, values: vec![0.0; self.values.len()] }
    }

    /// Adds a multiple of other outputs; latches, failures and the time are unchanged.
    pub(crate) fn add(&mut self, other: &Self, weight: f64) {
        let continuous = ..self.layout.continuous;
        let terms = self.values[continuous].iter_mut().zip(&other.values[continuous]);
        terms.for_each(|(sum, term)| *sum += term * weight);
    }
}
