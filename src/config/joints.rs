//! Joints of the file to [`Joint`]: where they hold, hinge axis, motion, drive, latch.

use crate::actuation::prescribed::Law;
use crate::config::file::ModelFile;
use crate::config::joint_file::{DriveFile, JointFile, JointType, LatchFile, MotionType, SpringFile, TableEnds};
use crate::config::schema::quoted;
use crate::config::spatial;
use crate::config::tree::{ROOT, Tree};
use crate::config::validate::Checker;
use crate::machine::{
    DEFAULT_CAPTURE_RAD, Drive, Joint, JointKind, JointMotion, Latch, Motion, Parent, Revolute, Spring, UNLIMITED,
};
use nalgebra::{Rotation3, Vector3};

/// Groups of the FMU's variables, which a joint's name would clash with.
pub(super) const RESERVED: &[&str] = &[
    "load", "gravity", "root", "wind", "gauge", "loop", "tip", "station", "aero", "energy", "solver", "body", "time",
    "der",
];

/// Beginning of the groups of several free ends, `tip_<body>`.
const RESERVED_BEGINNING: &str = "tip_";

/// Keys that not every joint has, with the types that have them.
const KEYS: &[(&str, &[JointType])] = {
    use JointType::{Ball, Free, Revolute, Universal};
    &[
        ("axis", &[Revolute, Universal]),
        ("body_axis", &[Universal]),
        ("start_angular_velocity_deg_s", &[Universal, Ball, Free]),
        ("start_velocity_m_s", &[Free]),
        ("start_angle_deg", &[Revolute]),
        ("start_rate_deg_s", &[Revolute]),
        ("release", &[Revolute]),
        ("motion", &[Revolute]),
        ("polynomial_deg", &[Revolute]),
        ("table_s_deg", &[Revolute]),
        ("drive", &[Revolute, Universal, Ball]),
        ("spring", &[Revolute]),
        ("latch", &[Revolute]),
    ]
};

/// Builds a joint; `None` if a problem was found that leaves nothing to build.
pub(super) fn build(
    name: &str,
    joint: &JointFile,
    file: &ModelFile,
    tree: Option<&Tree>,
    checker: &mut Checker,
) -> Option<Joint> {
    if RESERVED.contains(&name) || name.starts_with(RESERVED_BEGINNING) {
        let allowed =
            format!("a name that does not begin with {RESERVED_BEGINNING} and is none of {}", RESERVED.join(", "));
        checker.refuse_as(&["joint", name], format!("the name {name:?}"), allowed);
    }
    let parent = build_parent(name, joint, file, tree, checker);
    for (key, types) in KEYS.iter().filter(|(_, types)| !types.contains(&joint.kind)) {
        if checker.states(&["joint", name, key]) {
            let names: Vec<&str> = types.iter().copied().map(JointType::name).collect();
            checker.refuse(&["joint", name, key], format!("this key with type = {} only", quoted(&names)));
        }
    }
    let rotation = Vector3::from(joint.mount_rotation_deg).map(f64::to_radians);
    let mount = Rotation3::new(rotation).into_inner();
    let kind = match joint.kind {
        JointType::Clamped => JointKind::Clamped,
        JointType::Revolute => JointKind::Revolute(Box::new(build_revolute(name, joint, file, checker)?)),
        JointType::Universal | JointType::Ball | JointType::Free => {
            JointKind::Spatial(Box::new(spatial::build(name, joint, &mount, checker)?))
        }
    };
    Some(Joint { name: name.to_owned(), parent: parent?, mount, kind })
}

fn build_parent(
    name: &str,
    joint: &JointFile,
    file: &ModelFile,
    tree: Option<&Tree>,
    checker: &mut Checker,
) -> Option<Parent> {
    if joint.parent == ROOT {
        if joint.parent_position_m.is_some() {
            checker.refuse(
                &["joint", name, "parent_position_m"],
                "this key with a body as parent; write root_position_m = [x, y, z] (m)",
            );
        }
        return Some(Parent::Root { position_m: joint.root_position_m.unwrap_or_default().into() });
    }
    if joint.root_position_m.is_some() {
        checker.refuse(
            &["joint", name, "root_position_m"],
            "this key with parent = \"root\"; write parent_position_m (m), the distance along the parent",
        );
    }
    let (index, _, parent) = file.body.get_full(&joint.parent)?;
    let position_m = joint.parent_position_m.unwrap_or(parent.length_m);
    checker.on_body(&["joint", name, "parent_position_m"], position_m, parent);
    Some(Parent::Body { index: tree?.rank[index], position_m })
}

fn build_revolute(name: &str, joint: &JointFile, file: &ModelFile, checker: &mut Checker) -> Option<Revolute> {
    let motion = build_motion(name, joint, checker);
    let drive = build_drive(joint.drive.as_ref());
    let spring = joint.spring.as_ref().map(build_spring);
    let stiffness_n_m_rad = drive.stiffness_n_m_rad + spring.map_or(0.0, |spring| spring.stiffness_n_m_rad);
    let latch = build_latch(name, joint, stiffness_n_m_rad, checker);
    let release = joint.release.unwrap_or(true);
    let start_rate_rad_s = joint.start_rate_deg_s.unwrap_or(0.0).to_radians();
    if start_rate_rad_s != 0.0 && (kind_of(joint) != MotionType::Free || !release) {
        let allowed = "a rate of 0 deg/s where the joint is locked, prescribed or not released at the start";
        checker.refuse(&["joint", name, "start_rate_deg_s"], allowed);
    }
    let axis = unit_axis(name, "axis", joint.axis, checker);
    let motion = motion?;
    Some(Revolute {
        axis: axis?,
        start_angle_rad: match &motion {
            JointMotion::Prescribed(law) => law_start_rad(law, file.experiment.start_time_s),
            _ => joint.start_angle_deg.unwrap_or(0.0).to_radians(),
        },
        start_rate_rad_s,
        motion,
        release,
        drive,
        spring,
        latch: latch?,
    })
}

/// Unit vector of the direction at a key, which must be given and not be zero.
pub(super) fn unit_axis(
    name: &str,
    key: &str,
    direction: Option<[f64; 3]>,
    checker: &mut Checker,
) -> Option<Vector3<f64>> {
    let direction = Vector3::from(direction.unwrap_or_default());
    let largest = direction.amax();
    if largest == 0.0 {
        checker.refuse(&["joint", name, key], "an array of 3 finite numbers, not all 0");
        return None;
    }
    Some((direction / largest).normalize())
}

fn kind_of(joint: &JointFile) -> MotionType {
    joint.motion.unwrap_or(MotionType::Free)
}

fn build_motion(name: &str, joint: &JointFile, checker: &mut Checker) -> Option<JointMotion> {
    if kind_of(joint) != MotionType::Prescribed {
        for key in ["polynomial_deg", "table_s_deg", "table_ends"] {
            if checker.states(&["joint", name, key]) {
                checker.refuse(&["joint", name, key], "this key with motion = \"prescribed\" only");
            }
        }
        let locked = kind_of(joint) == MotionType::Locked;
        return Some(if locked { JointMotion::Locked } else { JointMotion::Free });
    }
    if joint.start_angle_deg.is_some() {
        checker.refuse(
            &["joint", name, "start_angle_deg"],
            "no start angle beside motion = \"prescribed\", which gives it",
        );
    }
    if joint.table_ends.is_some() && joint.table_s_deg.is_none() {
        checker.refuse(&["joint", name, "table_ends"], "this key with table_s_deg only");
    }
    match (&joint.polynomial_deg, &joint.table_s_deg) {
        (Some(coefficients), None) => {
            let coefficients = coefficients.iter().copied().map(f64::to_radians).collect();
            Some(JointMotion::Prescribed(Motion::Polynomial(coefficients)))
        }
        (None, Some(table)) => {
            if !table.windows(2).all(|pair| pair[0][0] < pair[1][0]) {
                checker.refuse(&["joint", name, "table_s_deg"], "pairs [time in s, angle in deg] with ascending times");
                return None;
            }
            let points = table.iter().map(|[time_s, angle_deg]| (*time_s, angle_deg.to_radians())).collect();
            let onward = joint.table_ends == Some(TableEnds::Onward);
            Some(JointMotion::Prescribed(if onward { Motion::Onward(points) } else { Motion::Table(points) }))
        }
        (Some(_), Some(_)) => {
            checker.refuse(&["joint", name, "table_s_deg"], "either polynomial_deg or table_s_deg, not both");
            None
        }
        (None, None) => {
            checker.refuse(&["joint", name, "motion"], "this motion with polynomial_deg or table_s_deg");
            None
        }
    }
}

/// Angle of a law at a time in rad; between the points of a table only nearly (straight lines).
fn law_start_rad(law: &Motion, time_s: f64) -> f64 {
    match law {
        Motion::Polynomial(coefficients) => coefficients.iter().rev().fold(0.0, |sum, c| sum * time_s + c),
        Motion::Onward(_) => Law::new(law).at(time_s)[0],
        Motion::Table(points) => {
            let after = points.partition_point(|(time, _)| *time <= time_s);
            match (points.get(after.wrapping_sub(1)), points.get(after)) {
                (Some((t0, a0)), Some((t1, a1))) => a0 + (a1 - a0) * (time_s - t0) / (t1 - t0),
                (Some((_, angle)), None) | (None, Some((_, angle))) => *angle,
                (None, None) => 0.0,
            }
        }
    }
}

fn build_drive(drive: Option<&DriveFile>) -> Drive {
    let drive = drive.cloned().unwrap_or_default();
    Drive {
        stiffness_n_m_rad: drive.stiffness_n_m_rad,
        damping_n_m_s_rad: drive.damping_n_m_s_rad,
        constant_torque_n_m: drive.constant_torque_n_m,
        torque_limit_n_m: drive.torque_limit_n_m.unwrap_or(UNLIMITED),
        rate_limit_rad_s: drive.rate_limit_deg_s.map_or(UNLIMITED, f64::to_radians),
        inertia_kg_m2: drive.inertia_kg_m2,
        command_rad: drive.command_deg.to_radians(),
    }
}

fn build_spring(spring: &SpringFile) -> Spring {
    Spring {
        stiffness_n_m_rad: spring.stiffness_n_m_rad,
        damping_n_m_s_rad: spring.damping_n_m_s_rad,
        rest_angle_rad: spring.rest_angle_deg.to_radians(),
    }
}

/// `Some(None)` without a latch, `None` if a problem was found. `stiffness_n_m_rad` is that of motor and spring, which
/// the ratio refers to.
fn build_latch(name: &str, joint: &JointFile, stiffness_n_m_rad: f64, checker: &mut Checker) -> Option<Option<Latch>> {
    let Some(latch) = &joint.latch else { return Some(None) };
    let path = ["joint", name, "latch"];
    if kind_of(joint) != MotionType::Free {
        checker.refuse_as(&path, "a latch on a joint that does not move freely", "a latch with motion = \"free\" only");
    }
    if latch.initially_closed && !latch.enable {
        let allowed = "true with enable = true only: a latch that is not enabled is open";
        checker.refuse(&["joint", name, "latch", "initially_closed"], allowed);
    }
    Some(Some(Latch {
        angle_rad: latch.angle_deg.to_radians(),
        stiffness_n_m_rad: latch_stiffness_n_m_rad(name, latch, stiffness_n_m_rad, checker)?,
        capture_rad: latch.capture_deg.map_or(DEFAULT_CAPTURE_RAD, f64::to_radians),
        initially_closed: latch.initially_closed,
        enable: latch.enable,
    }))
}

fn latch_stiffness_n_m_rad(name: &str, latch: &LatchFile, own_n_m_rad: f64, checker: &mut Checker) -> Option<f64> {
    let path = ["joint", name, "latch", "stiffness_ratio"];
    match (latch.stiffness_ratio, latch.stiffness_n_m_rad) {
        (None, Some(stiffness)) => Some(stiffness),
        (Some(_), Some(_)) => {
            checker.refuse(&path, "either stiffness_ratio or stiffness_N_m_rad, not both");
            None
        }
        (None, None) => {
            checker.refuse(&path, "a finite number > 1, or stiffness_N_m_rad instead");
            None
        }
        (Some(ratio), None) => {
            let stiffness = (ratio - 1.0) * own_n_m_rad;
            if own_n_m_rad == 0.0 {
                let allowed =
                    "a ratio where the stiffness of drive and spring is > 0; write stiffness_N_m_rad (N·m/rad) instead";
                checker.refuse(&path, allowed);
            } else if !(stiffness > 0.0 && stiffness <= UNLIMITED) {
                checker.refuse(&path, "a ratio that gives a finite stiffness > 0 N·m/rad");
            }
            Some(stiffness)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn start_of_a_law() {
        let table = Motion::Table(vec![(1.0, 0.0), (3.0, 1.0)]);
        assert_eq!([0.0, 1.0, 2.0, 3.0, 9.0].map(|t| law_start_rad(&table, t)), [0.0, 0.0, 0.5, 1.0, 1.0]);
        assert_eq!(law_start_rad(&Motion::Polynomial(vec![1.0, 2.0, 3.0]), 2.0), 17.0);
    }
}
