//! Universal, ball and free joints of the file to [`Spatial`]: axes, spring and damper, start velocities.

use crate::config::joint_file::{DriveFile, JointFile, JointType};
use crate::config::joints::unit_axis;
use crate::config::tree::ROOT;
use crate::config::validate::Checker;
use crate::machine::{Spatial, SpatialFreedom};
use nalgebra::{Matrix3, Vector3};

/// Cosine between a universal joint's axes beyond which they count as parallel.
const PARALLEL: f64 = 0.999;

/// Share of a start angular velocity across both axes of a universal joint that is taken for rounded numbers.
const ACROSS: f64 = 1e-4;

/// Keys of a drive that only revolute joints have.
const REVOLUTE_DRIVE_KEYS: &[&str] =
    &["constant_torque_N_m", "torque_limit_N_m", "rate_limit_deg_s", "inertia_kg_m2", "command_deg"];

/// Builds a universal, ball or free joint whose attitude at the start is `mount` (parent ← body); `None` if a
/// problem was found that leaves nothing to build.
pub(super) fn build(name: &str, joint: &JointFile, mount: &Matrix3<f64>, checker: &mut Checker) -> Option<Spatial> {
    for key in REVOLUTE_DRIVE_KEYS.iter().filter(|_| joint.kind != JointType::Free) {
        if checker.states(&["joint", name, "drive", key]) {
            checker.refuse(&["joint", name, "drive", key], "this key with type = \"revolute\" only");
        }
    }
    if joint.kind == JointType::Free && joint.parent != ROOT {
        let allowed = "\"root\" where type = \"free\": a body that another one carries is held by that body's joint";
        checker.refuse(&["joint", name, "parent"], allowed);
    }
    let mut spin = Vector3::from(joint.start_angular_velocity_deg_s.unwrap_or_default()).map(f64::to_radians);
    let freedom = match joint.kind {
        JointType::Universal => {
            let (parent_axis, body_axis) = universal(name, joint, mount, checker)?;
            let normal = parent_axis.cross(&(mount * body_axis)).normalize();
            spin = within_axes(name, &spin, &normal, checker)?;
            SpatialFreedom::Universal { parent_axis, body_axis }
        }
        JointType::Free => SpatialFreedom::Free,
        JointType::Ball | JointType::Clamped | JointType::Revolute => SpatialFreedom::Ball,
    };
    let DriveFile { stiffness_n_m_rad, damping_n_m_s_rad, .. } = joint.drive.clone().unwrap_or_default();
    Some(Spatial {
        freedom,
        stiffness_n_m_rad,
        damping_n_m_s_rad,
        start_angular_velocity_rad_s: spin,
        start_velocity_m_s: joint.start_velocity_m_s.unwrap_or_default().into(),
    })
}

/// Axes of a universal joint: of the parent in its frame, of the body in its own.
fn universal(
    name: &str,
    joint: &JointFile,
    mount: &Matrix3<f64>,
    checker: &mut Checker,
) -> Option<(Vector3<f64>, Vector3<f64>)> {
    let parent_axis = unit_axis(name, "axis", joint.axis, checker);
    let body_axis = unit_axis(name, "body_axis", joint.body_axis, checker);
    let (parent_axis, body_axis) = (parent_axis?, body_axis?);
    if parent_axis.dot(&(mount * body_axis)).abs() > PARALLEL {
        let allowed = "an array of 3 finite numbers, in the attitude of mount_rotation_deg not parallel to axis";
        checker.refuse(&["joint", name, "body_axis"], allowed);
        return None;
    }
    Some((parent_axis, body_axis))
}

/// An angular velocity without its part across both axes of a universal joint; refused where that is no round-off.
fn within_axes(name: &str, spin: &Vector3<f64>, normal: &Vector3<f64>, checker: &mut Checker) -> Option<Vector3<f64>> {
    // against overflow of squares
    let scale = spin.amax();
    if scale == 0.0 {
        return Some(*spin);
    }
    let direction = (spin / scale).normalize();
    let across = normal.dot(&direction);
    if across.abs() > ACROSS {
        let [x, y, z] = normal.map(|part| (part * 1e4).round() / 1e4 + 0.0).into();
        let allowed = format!("rates in deg/s about axis and body_axis only: nothing along [{x}, {y}, {z}]");
        checker.refuse(&["joint", name, "start_angular_velocity_deg_s"], allowed);
        return None;
    }
    Some(spin - normal * normal.dot(spin))
}
