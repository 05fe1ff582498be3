//! Outputs at the present time.

use crate::beam::recovery::axial_row;
use crate::config::Machine;
use crate::config::machine::Gauge;
use crate::load::Wrench;
use crate::math::so3::quaternion_near;
use crate::multibody::gauge::GaugePoint;
use crate::multibody::kinematics::Motion;
use crate::multibody::{energy, station};
use crate::plant::Plant;
use crate::plant::face::{AirOutputs, EnergyOutputs, JointOutputs, LoopOutputs, Outputs, PointOutputs, SpatialOutputs};
use crate::solve::EquationsOfMotion;
use nalgebra::{UnitQuaternion, Vector3};

/// Outputs of the right sizes, before initialisation.
pub(super) fn blank(machine: &Machine, joints: usize, spatial: usize, tips: usize) -> Outputs {
    let point = PointOutputs {
        position_m: Vector3::zeros(),
        velocity_m_s: Vector3::zeros(),
        angular_velocity_rad_s: Vector3::zeros(),
        acceleration_m_s2: Vector3::zeros(),
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
    /// Fills the outputs from the present state and the inputs of the step that led to it. Allocates nothing.
    pub(super) fn evaluate(&mut self) {
        let (state, equations, outputs) = (&mut self.state, &mut self.equations, &mut self.outputs);
        let now = &state.now;
        let time_s = now.time_s;
        equations.branch_s = time_s;
        equations.residual(time_s, &now.q, &now.v, &now.a, &mut self.scratch[0]);
        let motion = Motion { q: &now.q, v: &now.v, a: &now.a };
        let (model, work) = (&equations.model, &equations.work);
        outputs.time_s = time_s;

        for (i, (joint, state)) in equations.joints.iter().zip(&state.joints).enumerate() {
            let (angle, rate) = (now.q[joint.coordinate], now.v[joint.coordinate]);
            outputs.joints[i] = JointOutputs {
                angle_rad: angle,
                rate_rad_s: rate,
                torque_applied_n_m: joint.drive_torque(time_s, angle, rate).applied_n_m,
                latch_torque_n_m: joint.closed_latch().map_or(0.0, |latch| latch.torque_n_m(angle)),
                latched: joint.latched,
                latch_time_s: state.latch.time_s,
                latch_count: state.latch.count,
            };
        }
        for (i, joint) in equations.spatial.iter().enumerate() {
            let (rotation, angular_velocity_rad_s) = joint.motion(work, &now.v);
            let rotation = quaternion_near(&rotation, &state.spatial_rotations[i]);
            state.spatial_rotations[i] = rotation;
            outputs.spatial[i] = SpatialOutputs { rotation, angular_velocity_rad_s };
        }
        for (reaction, body) in outputs.joint_reactions.iter_mut().zip(&model.bodies) {
            let node = &work.nodes[body.first_node];
            *reaction = Wrench { force_n: node.force, moment_n_m: node.moment };
        }
        for joint in &equations.spatial {
            if let Some(moment_n_m) = joint.ball_moment_n_m(work, &now.v) {
                outputs.joint_reactions[joint.body].moment_n_m = moment_n_m;
            }
        }
        for (strain, gauge) in outputs.gauges.iter_mut().zip(&self.gauges) {
            *strain = gauge.strain(model, work, motion, &equations.damping);
        }
        for (output, closure) in outputs.loops.iter_mut().zip(&model.closures) {
            let gap = closure.gap(work);
            *output = LoopOutputs { gap_m: gap.position_m, force_n: closure.force_n(&gap) };
        }
        outputs.root = Wrench { force_n: -work.root_force, moment_n_m: -work.root_moment };

        let root = &equations.root;
        let omega = &root.angular_velocity_rad_s;
        for (i, &body) in self.tip_bodies.iter().enumerate() {
            let node = &work.nodes[model.bodies[body].last_node()];
            let rotation = quaternion_near(&node.rotation, &state.tip_rotations[i]);
            state.tip_rotations[i] = rotation;
            let inertial = node.acceleration
                + root.acceleration_m_s2
                + omega.cross(&(node.velocity * 2.0 + omega.cross(&node.position)))
                + root.angular_acceleration_rad_s2.cross(&node.position);
            outputs.tips[i] = PointOutputs {
                position_m: node.position,
                velocity_m_s: node.velocity,
                angular_velocity_rad_s: node.spin,
                acceleration_m_s2: inertial,
                rotation,
            };
        }
        for (i, place) in model.stations[..equations.load_stations].iter().enumerate() {
            let point = station::motion(model, work, motion, place);
            let rotation = quaternion_near(&point.rotation, &state.station_rotations[i]);
            state.station_rotations[i] = rotation;
            outputs.stations[i] = PointOutputs {
                position_m: point.position_m,
                velocity_m_s: point.velocity_m_s,
                angular_velocity_rad_s: point.spin_rad_s,
                acceleration_m_s2: Vector3::zeros(),
                rotation,
            };
        }
        if let (Some(air), Some(history)) = (&mut self.air, &state.air) {
            air.report(equations, history, now, outputs);
        }
        let (model, work) = (&equations.model, &equations.work);
        let penalty: f64 = model.closures.iter().map(|closure| closure.energy_j(work).0).sum();
        let kinetic = energy::kinetic(model, work, |_, _| {}) + penalty;
        let potentials = equations.potentials(time_s, &now.q);
        outputs.energy = EnergyOutputs {
            kinetic,
            elastic: potentials.elastic,
            gravity: potentials.gravity,
            drive: potentials.drive,
            work: now.work,
            dissipated: now.dissipated,
            total: kinetic + potentials.total(),
        };
    }
}
