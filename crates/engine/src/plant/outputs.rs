//! Outputs at the present time.

use crate::beam::recovery::axial_row;
use crate::force::joint::JointForces;
use crate::load::{SectionMotion, Wrench};
use crate::machine::Gauge;
use crate::machine::Machine;
use crate::math::so3::quaternion_near;
use crate::multibody::gauge::GaugePoint;
use crate::multibody::kinematics::{Motion, sweep_motion, sweep_poses};
use crate::multibody::model::Element;
use crate::multibody::{energy, station};
use crate::plant::Plant;
use crate::plant::equations::Equations;
use crate::plant::face::{AirOutputs, EnergyOutputs, JointOutputs, LoopOutputs, Outputs, PointOutputs, SpatialOutputs};
use crate::plant::output_set::{OutputSet, Sweep};
use crate::plant::spatial::SpatialJoint;
use crate::plant::state::State;
use crate::solve::EquationsOfMotion;
use nalgebra::{UnitQuaternion, Vector3};

/// Outputs of the right sizes, before initialisation.
pub(super) fn blank(machine: &Machine, joints: usize, spatial: usize, tips: usize) -> Outputs {
    let point = PointOutputs {
        position_m: Vector3::zeros(),
        velocity_m_s: Vector3::zeros(),
        angular_velocity_rad_s: Vector3::zeros(),
        acceleration_m_s2: Vector3::zeros(),
        angular_acceleration_rad_s2: Vector3::zeros(),
        rotation: UnitQuaternion::identity(),
    };
    let stations = machine.bodies.iter().map(|body| body.station_positions_m.len()).sum();
    Outputs {
        time_s: 0.0,
        joints: vec![JointOutputs { latch_time_s: -1.0, ..JointOutputs::default() }; joints],
        spatial: vec![
            SpatialOutputs { rotation: UnitQuaternion::identity(), angular_velocity_rad_s: Vector3::zeros() };
            spatial
        ],
        joint_reactions: vec![Wrench::default(); machine.bodies.len()],
        gauges: vec![0.0; machine.gauges.len()],
        section_loads: vec![Wrench::default(); machine.section_loads.len()],
        loops: vec![LoopOutputs::default(); machine.closures.len()],
        root: Wrench::default(),
        tips: vec![point; tips],
        stations: vec![point; stations],
        energy: EnergyOutputs::default(),
        air: AirOutputs::default(),
    }
}

/// Where the gauges sit and what they read per strain measure; a fibre that the file would refuse is read as axial.
pub(super) fn gauge_points(machine: &Machine) -> Vec<GaugePoint> {
    let point = |gauge: &Gauge| {
        let row = gauge.row(&machine.bodies[gauge.body].section);
        let row = row.unwrap_or_else(|| axial_row(gauge.y_m, gauge.z_m));
        GaugePoint { body: gauge.body, position_m: gauge.position_m, row }
    };
    machine.gauges.iter().map(point).collect()
}

impl Plant {
    /// Says which outputs [`Plant::step`] is to find; at first all. Those that are missing at present are found at once.
    ///
    /// What is left out keeps an old value in [`Plant::outputs`] until [`Plant::provide`] is called for it. What
    /// describes the whole wing ([`Plant::sections`], [`Plant::shape`], [`Plant::section_strains`], linear models, modes)
    /// needs [`OutputSet::ALL`]. Later steps do not depend on it.
    pub fn watch(&mut self, wanted: OutputSet) {
        self.watched = wanted;
        if self.state.initialized {
            self.provide(wanted);
        }
    }

    /// Finds those of `wanted` that have not been found at the present time. Allocates nothing.
    pub fn provide(&mut self, wanted: OutputSet) {
        if self.state.initialized && !self.found.contains(wanted) {
            self.evaluate_some(wanted.without(self.found));
        }
    }

    /// Whether these outputs belong to the present time.
    pub fn provides(&self, wanted: OutputSet) -> bool {
        !self.state.initialized || self.found.contains(wanted)
    }

    /// Fills all outputs from the present state and the inputs of the step that led to it. Allocates nothing.
    pub(super) fn evaluate(&mut self) {
        self.found = OutputSet::NONE;
        self.evaluate_some(OutputSet::ALL);
    }

    /// The present has changed: nothing has been found of it.
    pub(super) fn forget_outputs(&mut self) {
        self.found = OutputSet::NONE;
        self.outputs.time_s = self.state.now.time_s;
        self.equations.branch_s = self.state.now.time_s;
    }

    fn evaluate_some(&mut self, wanted: OutputSet) {
        // loads of the air are read at the load stations and along the surfaces
        let wanted = if self.air.is_some() { OutputSet::ALL } else { wanted };
        self.found = self.found | wanted;
        let (state, equations, outputs) = (&self.state, &mut self.equations, &mut self.outputs);
        let now = &state.now;
        let time_s = now.time_s;
        equations.branch_s = time_s;
        outputs.time_s = time_s;
        let motion = Motion { q: &now.q, v: &now.v, a: &now.a };
        let sweep = wanted.sweep(self.gauges_need_forces);
        match sweep {
            // linear models go on from a whole residual, and it alone has the torques of what holds joints
            _ if wanted == OutputSet::ALL || wanted.meets(OutputSet::HOLDING) => {
                equations.residual(time_s, &now.q, &now.v, &now.a, &mut self.scratch[0]);
            }
            // where inputs run, it brings them to its time
            _ if equations.course.moves || sweep == Sweep::Residual => {
                equations.wrenches(time_s, motion, &mut self.scratch[0]);
            }
            Sweep::Nothing | Sweep::Residual => {}
            Sweep::Poses => sweep_poses(&equations.model, &mut equations.work, motion.q),
            Sweep::Motion => sweep_motion(&equations.model, &mut equations.work, motion),
        }
        let (model, work) = (&equations.model, &equations.work);

        if wanted.meets(OutputSet::JOINTS) {
            for (i, (joint, state)) in equations.forces.joints().iter().zip(&state.joints).enumerate() {
                let (angle, rate) = (now.q[joint.coordinate], now.v[joint.coordinate]);
                let motor = joint.motor_torque(time_s, angle, rate).applied_n_m;
                let (spring, external) = (joint.spring_torque_n_m(angle, rate), joint.external_torque_n_m());
                outputs.joints[i] = JointOutputs {
                    angle_rad: angle,
                    rate_rad_s: rate,
                    torque_applied_n_m: motor + spring + external,
                    motor_torque_n_m: motor,
                    spring_torque_n_m: spring,
                    external_torque_n_m: external,
                    holding_torque_n_m: outputs.joints[i].holding_torque_n_m,
                    latch_torque_n_m: match joint.has_rigid_latch() {
                        true => outputs.joints[i].latch_torque_n_m,
                        false => joint.latch_torque_n_m(angle),
                    },
                    latch_impulse_n_m_s: state.latch.impulse_n_m_s,
                    latched: joint.is_latched(),
                    latch_time_s: state.latch.time_s,
                    latch_count: state.latch.count,
                };
            }
        }
        if wanted.meets(OutputSet::HOLDING) {
            for (output, joint) in outputs.joints.iter_mut().zip(equations.forces.joints()) {
                output.holding_torque_n_m = joint.holding_n_m;
                if joint.has_rigid_latch() {
                    // closed, it bears all, whatever else holds the joint, eq. (A7)
                    let borne_n_m = if joint.is_latched() { joint.holding_n_m } else { 0.0 };
                    output.latch_torque_n_m = borne_n_m;
                    output.holding_torque_n_m -= borne_n_m;
                }
            }
        }
        if wanted.meets(OutputSet::SPATIAL) {
            for (i, joint) in equations.spatial.iter().enumerate() {
                let (rotation, angular_velocity_rad_s) = joint.motion(work, &now.v);
                let rotation = quaternion_near(&rotation, &state.spatial_rotations[i]);
                outputs.spatial[i] = SpatialOutputs { rotation, angular_velocity_rad_s };
            }
        }
        if wanted.meets(OutputSet::REACTIONS) {
            for (reaction, body) in outputs.joint_reactions.iter_mut().zip(&model.bodies) {
                let node = &work.nodes[body.first_node];
                *reaction = Wrench { force_n: node.force, moment_n_m: node.moment };
            }
            for joint in equations.forces.joints() {
                joint.complete_reaction(model, work, motion, time_s, &mut outputs.joint_reactions[joint.body]);
            }
            for joint in equations.forces.spatial() {
                if let Some(moment_n_m) = joint.attitude().and_then(|spring| spring.ball_moment_n_m(work, &now.v)) {
                    outputs.joint_reactions[joint.body].moment_n_m = moment_n_m;
                }
            }
        }
        if wanted.meets(OutputSet::GAUGES) {
            for (strain, gauge) in outputs.gauges.iter_mut().zip(&self.gauges) {
                *strain = gauge.strain(model, work, motion, &equations.damping);
            }
        }
        if wanted.meets(OutputSet::SECTION_LOADS) {
            let loads: &[Wrench] = if equations.loaded { &equations.stations } else { &[] };
            for (load, section) in outputs.section_loads.iter_mut().zip(&equations.sections) {
                *load = section.load(model, work, motion, loads);
            }
        }
        if wanted.meets(OutputSet::LOOPS) {
            for (output, closure) in outputs.loops.iter_mut().zip(&model.closures) {
                let gap = closure.gap(work);
                *output = LoopOutputs { gap_m: gap.position_m, force_n: closure.force_n(&gap) };
            }
        }
        if wanted.meets(OutputSet::ROOT) {
            outputs.root = Wrench { force_n: -work.root_force, moment_n_m: -work.root_moment };
        }
        fill_tips(wanted, &self.tip_bodies, state, equations, outputs);
        fill_stations(wanted, motion, state, equations, outputs);
        if let (Some(air), Some(history)) = (&mut self.air, &state.air) {
            air.report(equations, history, now, outputs);
        }
        if wanted.meets(OutputSet::ENERGIES) {
            let (model, work) = (&equations.model, &equations.work);
            let penalty: f64 = model.closures.iter().map(|closure| closure.energy_j(work).0).sum();
            let kinetic = energy::kinetic(model, work, |_, _| {}) + penalty + energy::kinetic_of_drives(model, &now.v);
            let potentials = equations.potentials(time_s, &now.q);
            outputs.energy = EnergyOutputs {
                kinetic,
                elastic: potentials.elastic,
                gravity: potentials.gravity,
                drive: potentials.drive,
                total: kinetic + potentials.total(),
                ..outputs.energy
            };
        }
        if wanted.meets(OutputSet::ACCOUNTS) {
            (outputs.energy.work, outputs.energy.dissipated) = (now.work, now.dissipated);
        }
    }

    /// Remembers the attitudes at the end of the internal step just taken, for continuous signs of quaternions. Signs so
    /// do not depend on what is read.
    pub(super) fn remember_attitudes(&mut self) {
        let State { ahead, spatial_rotations, tip_rotations, station_rotations, .. } = &mut self.state;
        let last = [spatial_rotations, tip_rotations, station_rotations];
        self.equations.remember_attitudes(&ahead.q, &self.tip_bodies, last);
    }

    /// Remembers the attitudes at the present too where the internal step turns so far that its end says little.
    pub(super) fn remember_far_turns(&mut self) {
        let State { start, ahead, now, spatial_rotations, tip_rotations, station_rotations, .. } = &mut self.state;
        if turn_between(&self.equations, &start.q, &ahead.q) > FAR_TURN_RAD {
            sweep_poses(&self.equations.model, &mut self.equations.work, &now.q);
            let last = [spatial_rotations, tip_rotations, station_rotations];
            self.equations.remember_attitudes(&now.q, &self.tip_bodies, last);
        }
    }
}

impl Equations {
    /// Brings the last attitudes of joints, tips and stations to the poses that the last sweep has left.
    fn remember_attitudes(
        &self,
        q: &[f64],
        tip_bodies: &[usize],
        [joints, tips, stations]: [&mut Vec<UnitQuaternion<f64>>; 3],
    ) {
        let (model, work) = (&self.model, &self.work);
        for (last, joint) in joints.iter_mut().zip(&self.spatial) {
            *last = quaternion_near(&joint.rotation(work), last);
        }
        for (last, &body) in tips.iter_mut().zip(tip_bodies) {
            *last = quaternion_near(&work.nodes[model.bodies[body].last_node()].rotation, last);
        }
        for (last, place) in stations.iter_mut().zip(&model.stations) {
            *last = quaternion_near(&station::rotation(model, work, q, place), last);
        }
    }
}

/// Turn within one internal step above which attitudes are remembered at every communication point, rad.
const FAR_TURN_RAD: f64 = 1.0;

/// Largest angle in rad by which any part of the machine may turn between two sets of coordinates: sum of the turns of
/// all joints and elements.
fn turn_between(equations: &Equations, from: &[f64], to: &[f64]) -> f64 {
    let change = |c: usize| to[c] - from[c];
    let turns = |joint: &&JointForces| equations.model.bodies[joint.body].joint.kind.translations() == 0;
    let hinges: f64 = equations.forces.joints().iter().filter(turns).map(|joint| change(joint.coordinate).abs()).sum();
    let spatial: f64 = equations.spatial.iter().flat_map(SpatialJoint::range).map(|c| 2.0 * change(c).abs()).sum();
    let bend = |element: &Element| {
        let c = element.coordinate;
        element.length_m * Vector3::new(change(c + 1), change(c + 2), change(c + 3)).norm()
    };
    hinges + spatial + equations.model.elements.iter().map(bend).sum::<f64>()
}

/// Free ends.
fn fill_tips(wanted: OutputSet, bodies: &[usize], state: &State, equations: &Equations, outputs: &mut Outputs) {
    let root = &equations.root;
    for (i, &body) in bodies.iter().enumerate() {
        let node = &equations.work.nodes[equations.model.bodies[body].last_node()];
        let tip = &mut outputs.tips[i];
        if wanted.meets(OutputSet::TIP_PLACES) {
            tip.position_m = node.position;
            tip.rotation = quaternion_near(&node.rotation, &state.tip_rotations[i]);
        }
        if wanted.meets(OutputSet::TIP_MOTIONS) {
            tip.velocity_m_s = node.velocity;
            tip.angular_velocity_rad_s = node.spin;
            tip.acceleration_m_s2 = root.inertial_acceleration_m_s2(&node.position, &node.velocity, &node.acceleration);
            tip.angular_acceleration_rad_s2 = root.inertial_angular_acceleration_rad_s2(&node.spin, &node.spin_rate);
        }
    }
}

/// Load stations.
fn fill_stations(wanted: OutputSet, motion: Motion, state: &State, equations: &Equations, outputs: &mut Outputs) {
    let (model, work) = (&equations.model, &equations.work);
    let places = wanted.meets(OutputSet::STATION_PLACES);
    let accelerations = wanted.meets(OutputSet::STATION_ACCELERATIONS);
    if !(places || accelerations || wanted.meets(OutputSet::STATION_MOTIONS)) {
        return;
    }
    let root = &equations.root;
    for (i, place) in model.stations[..equations.load_stations].iter().enumerate() {
        let station = &mut outputs.stations[i];
        let point = if accelerations {
            let found = station::accelerated(model, work, motion, place);
            let SectionMotion { position_m, velocity_m_s, spin_rad_s, .. } = &found.motion;
            station.acceleration_m_s2 =
                root.inertial_acceleration_m_s2(position_m, velocity_m_s, &found.acceleration_m_s2);
            station.angular_acceleration_rad_s2 =
                root.inertial_angular_acceleration_rad_s2(spin_rad_s, &found.spin_rate_rad_s2);
            found.motion
        } else {
            station::motion(model, work, motion, place)
        };
        if places {
            station.position_m = point.position_m;
            station.rotation = quaternion_near(&point.rotation, &state.station_rotations[i]);
        }
        if wanted.meets(OutputSet::STATION_MOTIONS) {
            station.velocity_m_s = point.velocity_m_s;
            station.angular_velocity_rad_s = point.spin_rad_s;
        }
    }
}
