//! The equations of motion of the whole model: the tree, its motors and latches, its loads.

use crate::beam::element::rigid_body_mass;
use crate::force::Stored;
use crate::force::set::Forces;
use crate::load::{RootMotion, Wrench};
use crate::machine::Machine;
use crate::machine::{InternalLoad, LoopEnd, Parent, SectionSide};
use crate::math::strain::{SHEAR_Y, SHEAR_Z, SHEARED, Strain};
use crate::multibody::closure::{ClosureDescription, Penalty};
use crate::multibody::dynamics::{self, Damping, Environment};
use crate::multibody::factor::{self, FreedomTangent, Weights};
use crate::multibody::gauge::Side;
use crate::multibody::internal_load::SectionPlace;
use crate::multibody::kinematics::{self, Motion};
use crate::multibody::model::{Attachment, BodyDescription, Element};
use crate::multibody::no_slip::NoSlipDescription;
use crate::multibody::rigid_loop::{self, Miss};
use crate::multibody::{Model, Workspace, energy, norm, station_load};
use crate::signal::{Inputs, Parameters};
use crate::solve::newton::NewtonError;
use crate::solve::point::Point;
use crate::solve::{EquationsOfMotion, Open, Powers, Singular};
use crate::system::air::StepLoads;
use crate::system::air::sections::add_sections;
use crate::system::course::Course;
use crate::system::failure_memory;
use crate::system::joint_forces;
use crate::system::spatial::SpatialJoint;

/// Weight of the stiffness in s² in the corrections that close loops between steps: joints rotate, while strains of beams change little in
/// modes faster than 100 rad/s.
const CLOSING_S2: f64 = 1e-4;

/// Equations of motion with their workspace.
pub(crate) struct Equations {
    pub model: Model,
    pub work: Workspace,
    /// Inputs of the communication step; if they vary in time, the residual updates `root`, `stations` and the external torques to its
    /// time.
    pub course: Course,
    pub root: RootMotion,
    pub damping: Vec<Damping>,
    /// Loads at the stations of the model: first the caller's loads, then the aerodynamic loads on the sections.
    pub stations: Vec<Wrench>,
    /// Number of stations with loads of the caller.
    pub load_stations: usize,
    /// Aerodynamic loads; `None` for models without aerodynamics.
    pub air: Option<StepLoads>,
    /// Whether some station carries a load.
    pub loaded: bool,
    /// Forces on the joints.
    pub forces: Forces,
    /// Joints with several degrees of freedom.
    pub spatial: Vec<SpatialJoint>,
    /// Time in s that selects the branch of slews and prescribed motions: the middle of a step, or the current time.
    pub branch_s: f64,
    /// Whether energies are booked; not during trial marches, which are undone.
    pub booked: bool,
    pub tangents: Vec<FreedomTangent>,
    /// Weights of the last factorisation.
    weights: Weights,
    /// Per circuit: damping of its joint without it, during a factorisation.
    own_damping: Vec<f64>,
    /// Time of the next failure known in advance, in s; infinite if there is none.
    pub failure_s: f64,
    /// Elements before any failure, for models with bodies that may be weakened.
    pub sound: Vec<Element>,
    /// Positions of the internal loads that are outputs.
    pub sections: Vec<SectionPlace>,
    scratch: Vec<f64>,
}

impl Equations {
    /// Creates the equations of a model with the fixed factors of `parameters`; inputs and tunable parameters are set later.
    pub fn new(machine: &Machine, parameters: &Parameters) -> Self {
        let descriptions: Vec<BodyDescription> = machine
            .bodies
            .iter()
            .zip(parameters.bodies())
            .map(|(body, factors)| BodyDescription {
                length_m: body.length_m,
                section: body.section.scaled(factors.mass_factor, factors.stiffness_factor),
                kind: body.element,
                elements: body.elements,
                natural_strain: body.natural_strain.clone(),
                parent: match body.joint.parent {
                    Parent::Root { position_m } => Attachment::Root(position_m),
                    Parent::Body { index, .. } if body.joint.kind.rides() => Attachment::Axis { index },
                    Parent::Body { index, position_m } => Attachment::Body { index, position_m },
                },
                offset_m: body.joint.offset_m,
                mount: body.joint.mount,
                joint: body.joint.kind.in_tree(),
                masses: body
                    .masses
                    .iter()
                    .map(|mass| (mass.position_m, rigid_body_mass(mass.mass_kg, &mass.offset_m, &mass.inertia_kg_m2)))
                    .collect(),
                stations_m: body.station_positions_m.clone(),
                load_frame: body.load_frame,
            })
            .collect();
        let closures: Vec<ClosureDescription> = machine
            .closures
            .iter()
            .map(|closure| ClosureDescription {
                places: closure.ends.map(LoopEnd::on_body),
                offsets_m: closure.offsets_m,
                rigid: closure.rigid,
                penalty: Penalty {
                    inertia_kg: closure.inertia_kg,
                    damping_n_s_m: closure.damping_n_s_m,
                    stiffness_n_m: closure.stiffness_n_m,
                },
            })
            .collect();
        let no_slips: Vec<NoSlipDescription> = machine
            .no_slips
            .iter()
            .map(|no_slip| NoSlipDescription {
                place: (no_slip.body, no_slip.position_m),
                offset_m: no_slip.offset_m,
                runner: no_slip.runner,
                normal: no_slip.plane_normal,
                distance_m: no_slip.plane_normal.dot(&no_slip.plane_point_m),
                holds_normal: no_slip.hold_normal,
            })
            .collect();
        let mut model = Model::with_constraints(&descriptions, &closures, &no_slips);
        for (index, body) in machine.bodies.iter().enumerate() {
            model.bodies[index].damps_attached = body.damp_attached_masses;
            let [y, z] = body.shear_damping_factors;
            let shares = Strain::<SHEARED>::from_fn(|i, _| match i {
                SHEAR_Y => y,
                SHEAR_Z => z,
                strain => body.stiffness_damping_factors[strain],
            });
            model.bodies[index].damping_roots =
                (shares != Strain::<SHEARED>::repeat(1.0)).then(|| shares.map(f64::sqrt));
        }
        for (index, revolute) in machine.one_freedoms() {
            let joint = &mut model.bodies[index].joint;
            joint.drive_inertia = revolute.motor.inertia_kg_m2;
            joint.drive_carried = revolute.motor.gear_ratio.map_or(0.0, |ratio| 1.0 / ratio);
        }
        for (index, body) in machine.bodies.iter().enumerate() {
            model.damp_modes(index, &body.modal_damping_ratios);
        }
        for (joint, own) in machine.dc_motors() {
            let constant_n_m_a = own.torque_constant_n_m_a * own.gear_ratio;
            let (body, _) = machine.one_freedoms().nth(joint).expect("a joint with a motor");
            model.add_circuit(body, [own.inductance_h, own.resistance_ohm, constant_n_m_a]);
        }
        let load_stations = model.stations.len();
        add_sections(machine, &mut model);
        let mut tangents = vec![FreedomTangent::HELD; model.bodies.len()];
        for (body, _) in machine.spatials() {
            tangents[body].free = true;
        }
        let section = |place: &InternalLoad| {
            let side = match place.side {
                SectionSide::Inboard => Side::Inboard,
                SectionSide::Outboard => Side::Outboard,
            };
            SectionPlace::new(&model, &descriptions[place.body].section, place.body, place.position_m, side)
        };
        Self {
            sections: machine.internal_loads.iter().map(section).collect(),
            work: Workspace::new(&model),
            course: Course::held(&Inputs::of(machine)),
            root: RootMotion::default(),
            damping: vec![Damping::default(); model.bodies.len()],
            stations: vec![Wrench::default(); model.stations.len()],
            load_stations,
            air: machine.air.as_ref().map(|_| StepLoads::none(model.stations.len() - load_stations)),
            loaded: false,
            forces: joint_forces::of_machine(machine, &model),
            spatial: SpatialJoint::of_machine(machine, &model),
            tangents,
            weights: Weights { mass: 1.0, damping: 0.0, stiffness: 0.0 },
            own_damping: vec![0.0; model.circuits.len()],
            branch_s: 0.0,
            booked: true,
            failure_s: f64::INFINITY,
            sound: if failure_memory::weaken_bodies(machine) { model.elements.clone() } else { Vec::new() },
            scratch: vec![0.0; model.coordinates],
            model,
        }
    }

    /// Updates the aerodynamic loads, and the inputs that vary in time, to a time.
    pub(crate) fn bring_loads_to(&mut self, time_s: f64) {
        if let Some(air) = &self.air {
            air.write(&mut self.stations[self.load_stations..]);
        }
        if self.course.moves {
            self.root = self.course.root(time_s);
            self.course.write_stations(time_s, &mut self.stations[..self.load_stations]);
            for (i, joint) in self.forces.joints_mut().iter_mut().enumerate() {
                if let Some(external) = joint.external_mut() {
                    external.torque_n_m = self.course.torque_n_m(i, time_s);
                }
            }
            for (i, armature) in self.forces.armatures_mut().enumerate() {
                armature.voltage_v = self.course.voltage_v(i, time_s);
            }
        }
    }

    /// Sets all rates to zero except the currents, which become those at rest.
    pub(crate) fn stand(&self, v: &mut [f64]) {
        v.fill(0.0);
        self.rest_currents(v);
    }

    /// Sets the currents to those at rest, eq. (A13).
    pub(crate) fn rest_currents(&self, v: &mut [f64]) {
        for armature in self.forces.armatures() {
            v[armature.circuit.coordinate] = armature.rest_current_a();
        }
    }

    /// Computes motion and wrenches of all nodes like a residual evaluation.
    pub fn wrenches(&mut self, time_s: f64, motion: Motion, scratch: &mut [f64]) {
        self.bring_loads_to(time_s);
        let environment = Environment {
            root: &self.root,
            damping: &self.damping,
            stations: if self.loaded { &self.stations } else { &[] },
        };
        dynamics::wrenches(&self.model, &mut self.work, motion, environment, scratch);
    }

    /// Gravity, motor and elastic potentials in J at the configuration of the last residual.
    pub fn potentials(&self, time_s: f64, q: &[f64]) -> Potentials {
        let mut stored = Stored { elastic: energy::elastic(&self.model, q), drive: 0.0 };
        self.forces.add_stored(time_s, q, &self.work, &mut stored);
        for closure in &self.model.closures {
            stored.elastic += closure.energy_j(&self.work).1;
        }
        let gravity = -self.root.apparent_gravity_m_s2().dot(&energy::first_moment_kg_m(&self.model, &self.work));
        Potentials { elastic: stored.elastic, gravity, drive: stored.drive }
    }

    /// Closes the rigid loops, skates and wheels of a start or of an interpolated state, with a factorisation for this state: interpolation meets the
    /// constraints only to its own error.
    pub(crate) fn close_point(&mut self, point: &mut Point) -> Result<(), NewtonError> {
        if self.model.constraints() == 0 {
            return Ok(());
        }
        let mut residual = std::mem::take(&mut self.scratch);
        self.residual(point.time_s, &point.q, &point.v, &point.a, &mut residual);
        self.scratch = residual;
        self.factorize(1.0, 0.0, CLOSING_S2)?;
        self.close(&mut point.q, &mut point.v, &mut point.a)?;
        if !self.spatial.is_empty() {
            // large corrections leave the constraints of the joint parameters
            self.project(&mut point.q, &mut point.v, &mut point.a);
            self.close(&mut point.q, &mut point.v, &mut point.a)?;
        }
        Ok(())
    }

    /// Whether a known kink is exactly at `time_s`, so that prescribed rates or accelerations may jump there.
    pub fn kink_at(&self, time_s: f64) -> bool {
        self.forces.kink_at(time_s) || self.failure_s <= time_s
    }

    /// Time of the next known kink after `time_s`: end of a slew, knot of a prescribed motion, end of an aerodynamic step.
    pub fn next_kink_s(&self, time_s: f64) -> f64 {
        let mut next = self.forces.next_kink_s(time_s);
        if self.failure_s > time_s {
            next = next.min(self.failure_s);
        }
        if let Some(air) = self.air.as_ref().filter(|air| air.end_s > time_s) {
            next = next.min(air.end_s);
        }
        next
    }
}

/// Potential energies in J.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Potentials {
    /// Strain energy of beams, springs of fold joints, closed latches and closed loops.
    pub elastic: f64,
    /// Potential of the apparent gravity, zero at the origin.
    pub gravity: f64,
    /// Potential of springs and constant torques of the motors.
    pub drive: f64,
}

impl Potentials {
    /// Sum of the potentials in J.
    pub fn total(&self) -> f64 {
        self.elastic + self.gravity + self.drive
    }
}

impl EquationsOfMotion for Equations {
    fn coordinates(&self) -> usize {
        self.model.coordinates
    }

    fn prescribe(&self, time_s: f64, q: &mut [f64], v: &mut [f64], a: &mut [f64]) {
        self.forces.prescribe([time_s, self.branch_s], q, v, a);
    }

    fn project(&self, q: &mut [f64], v: &mut [f64], a: &mut [f64]) {
        for joint in &self.spatial {
            joint.project(q, v, a);
        }
    }

    fn close(&mut self, q: &mut [f64], v: &mut [f64], a: &mut [f64]) -> Result<bool, Open> {
        if self.model.constraints() == 0 {
            let is_projected = self.booked && !self.spatial.is_empty();
            if is_projected {
                // the powers of the projected end need its motion
                kinematics::sweep_motion(&self.model, &mut self.work, Motion { q, v, a });
            }
            return Ok(is_projected);
        }
        let closed = rigid_loop::close(&self.model, &mut self.work, [q, v, a]);
        closed.map(|()| true).map_err(|miss| match miss {
            Miss::Open(gap) => Open::Gap { gap },
            Miss::Slips(slip) => Open::Slip { slip },
        })
    }

    fn residual(&mut self, time_s: f64, q: &[f64], v: &[f64], a: &[f64], residual: &mut [f64]) {
        self.bring_loads_to(time_s);
        let environment = Environment {
            root: &self.root,
            damping: &self.damping,
            stations: if self.loaded { &self.stations } else { &[] },
        };
        dynamics::residual(&self.model, &mut self.work, Motion { q, v, a }, environment, residual);
        self.forces.apply(time_s, [q, v], &self.work, residual, &mut self.tangents);
        if !self.model.circuits.is_empty() {
            for armature in self.forces.armatures() {
                residual[armature.circuit.coordinate] = armature.circuit.residual_v(v, a, armature.voltage_v);
            }
        }
        for joint in self.spatial.iter().filter(|joint| joint.held) {
            residual[joint.range()].fill(0.0);
        }
    }

    fn take_pieces(&mut self, time_s: f64, q: &[f64], v: &[f64]) {
        self.drop_pieces();
        self.forces.move_pieces(time_s, q, v, false);
    }

    fn move_pieces(&mut self, time_s: f64, q: &[f64], v: &[f64], only_first: bool) -> bool {
        self.forces.move_pieces(time_s, q, v, only_first)
    }

    fn drop_pieces(&mut self) {
        self.forces.drop_pieces();
    }

    fn factorize(&mut self, mass: f64, damping: f64, stiffness: f64) -> Result<(), Singular> {
        let weights = Weights { mass, damping, stiffness };
        self.weights = weights;
        for (circuit, kept) in self.model.circuits.iter().zip(&mut self.own_damping) {
            let damping = &mut self.tangents[circuit.body].damping;
            *kept = *damping;
            *damping += circuit.added_damping(weights);
        }
        let factors = factor::factorize(&self.model, &mut self.work, weights, &self.damping, &self.tangents);
        for (circuit, kept) in self.model.circuits.iter().zip(&self.own_damping) {
            self.tangents[circuit.body].damping = *kept;
        }
        factors.map_err(|pivot| Singular { coordinate: pivot.coordinate })
    }

    fn solve(&mut self, x: &mut [f64]) -> f64 {
        for circuit in &self.model.circuits {
            circuit.reduce(self.weights, x);
        }
        let mut norm = factor::solve(&self.model, &mut self.work, x);
        for circuit in &self.model.circuits {
            circuit.expand(self.weights, x);
            norm = circuit.include(norm, x);
        }
        norm
    }

    fn norm(&mut self, change: &[f64]) -> f64 {
        let norm = norm::kinematic_norm(&self.model, &mut self.work, change);
        self.model.circuits.iter().fold(norm, |norm, circuit| circuit.include(norm, change))
    }

    fn powers(&mut self, time_s: f64, q: &[f64], v: &[f64], a: &[f64]) -> Powers {
        let mut powers = Powers::default();
        if !self.booked {
            return powers;
        }
        if self.forces.joints().iter().any(|joint| joint.law().is_some()) {
            // the torque that holds a prescribed joint must correspond to these accelerations, not to those of the last iterate
            let mut residual = std::mem::take(&mut self.scratch);
            self.residual(time_s, q, v, a, &mut residual);
            self.scratch = residual;
        }
        let damping = &self.damping;
        if damping.iter().any(|damping| damping.stiffness_s != 0.0) {
            powers.dissipated += energy::stiffness_damping_power(&self.model, v, damping);
        }
        powers.dissipated += energy::modal_damping_power(&self.model, v);
        if damping.iter().any(|damping| damping.mass_1_s != 0.0) {
            energy::mass_damping_power(&self.model, &self.work, damping, |beam| powers.dissipated += beam);
        }
        self.forces.add_powers([time_s, self.branch_s], [q, v], &self.work, &mut powers);
        for closure in &self.model.closures {
            powers.dissipated += closure.dissipation_w(&self.work);
        }
        if self.course.moves {
            // a gravity field that varies in time does work on the potential, eq. (A4)
            let field = self.course.rates.root().apparent_gravity_m_s2();
            powers.work -= field.dot(&energy::first_moment_kg_m(&self.model, &self.work));
        }
        if self.root.rotates() {
            powers.work += energy::frame_power(&self.model, &self.work, &self.root)
                + energy::frame_power_of_drives(&self.model, &self.work, &self.root, v);
        }
        if self.loaded {
            powers.work += station_load::power_w(&self.model, &self.work, Motion { q, v, a: &[] }, &self.stations);
        }
        powers
    }
}
