//! Motion of free ends and load stations.

use crate::load::SectionMotion;
use crate::math::so3::quaternion_near;
use crate::multibody::station;
use crate::system::outputs::{OutputSet, Present};
use bytemuck::{Pod, Zeroable};
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

/// Position, velocities and attitude of a point of the wing, in the root frame and relative to it, unless a field states another frame.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PointOutputs {
    /// Position in m.
    pub position_m: Vector3<f64>,
    /// Velocity in m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Angular velocity in rad/s.
    pub angular_velocity_rad_s: Vector3<f64>,
    /// Inertial acceleration (without gravity) in m/s².
    pub acceleration_m_s2: Vector3<f64>,
    /// Inertial angular acceleration in rad/s².
    pub angular_acceleration_rad_s2: Vector3<f64>,
    /// Specific force in m/s², section frame: inertial acceleration minus gravity, which is the reading of an accelerometer, NOTATION
    /// eq. (G8).
    pub specific_force_m_s2: Vector3<f64>,
    /// Attitude, root ← section; sign continuous in time.
    pub rotation: UnitQuaternion<f64>,
}

impl PointOutputs {
    /// Outputs of a point that has not been evaluated yet.
    pub(crate) const BLANK: Self = Self {
        position_m: Vector3::new(0.0, 0.0, 0.0),
        velocity_m_s: Vector3::new(0.0, 0.0, 0.0),
        angular_velocity_rad_s: Vector3::new(0.0, 0.0, 0.0),
        acceleration_m_s2: Vector3::new(0.0, 0.0, 0.0),
        angular_acceleration_rad_s2: Vector3::new(0.0, 0.0, 0.0),
        specific_force_m_s2: Vector3::new(0.0, 0.0, 0.0),
        rotation: UPRIGHT,
    };
}

/// Identity rotation.
pub(crate) const UPRIGHT: UnitQuaternion<f64> = Unit::new_unchecked(Quaternion::new(1.0, 0.0, 0.0, 0.0));

/// Writes the outputs of free ends.
pub(crate) fn fill_tips(outputs: &mut [PointOutputs], present: &Present, bodies: &[usize], wanted: OutputSet) {
    let (equations, root) = (present.equations, &present.equations.root);
    for ((tip, &body), last) in outputs.iter_mut().zip(bodies).zip(&present.state.tip_rotations) {
        let node = &equations.work.nodes[equations.model.bodies[body].last_node()];
        if wanted.meets(OutputSet::TIP_PLACES) {
            tip.position_m = node.position;
            tip.rotation = quaternion_near(&node.rotation, last);
        }
        if wanted.meets(OutputSet::TIP_MOTIONS) {
            tip.velocity_m_s = node.velocity;
            tip.angular_velocity_rad_s = node.spin;
            tip.acceleration_m_s2 = root.inertial_acceleration_m_s2(&node.position, &node.velocity, &node.acceleration);
            tip.angular_acceleration_rad_s2 = root.inertial_angular_acceleration_rad_s2(&node.spin, &node.spin_rate);
            tip.specific_force_m_s2 = node.rotation.tr_mul(&(tip.acceleration_m_s2 - root.gravity_m_s2));
        }
    }
}

/// Writes the outputs of load stations.
pub(crate) fn fill_stations(outputs: &mut [PointOutputs], present: &Present, wanted: OutputSet) {
    let (equations, motion) = (present.equations, present.motion);
    let (model, work) = (&equations.model, &equations.work);
    let places = wanted.meets(OutputSet::STATION_PLACES);
    let accelerations = wanted.meets(OutputSet::STATION_ACCELERATIONS);
    if !(places || accelerations || wanted.meets(OutputSet::STATION_MOTIONS)) {
        return;
    }
    let root = &equations.root;
    let places_of = model.stations[..equations.load_stations].iter().zip(&present.state.station_rotations);
    for (station, (place, last)) in outputs.iter_mut().zip(places_of) {
        let point = if accelerations {
            let found = station::accelerated(model, work, motion, place);
            let SectionMotion { position_m, velocity_m_s, spin_rad_s, .. } = &found.motion;
            station.acceleration_m_s2 =
                root.inertial_acceleration_m_s2(position_m, velocity_m_s, &found.acceleration_m_s2);
            station.angular_acceleration_rad_s2 =
                root.inertial_angular_acceleration_rad_s2(spin_rad_s, &found.spin_rate_rad_s2);
            station.specific_force_m_s2 =
                found.motion.rotation.tr_mul(&(station.acceleration_m_s2 - root.gravity_m_s2));
            found.motion
        } else {
            station::motion(model, work, motion, place)
        };
        if places {
            station.position_m = point.position_m;
            station.rotation = quaternion_near(&point.rotation, last);
        }
        if wanted.meets(OutputSet::STATION_MOTIONS) {
            station.velocity_m_s = point.velocity_m_s;
            station.angular_velocity_rad_s = point.spin_rad_s;
        }
    }
}
