//! Builds the joints of the model file with a [`JointBuilder`]: parent, motion, latch, end stops.

use crate::body_file::FrameFile;
use crate::checker::Checker;
use crate::file::ModelFile;
use crate::freedom_file::{EndStopsFile, LatchFile, LatchType, MotionType, MotorFile, SpringFile, TableEnds};
use crate::joint_file::{AttitudeFile, JointFile, JointType, PAIRS};
use foldwing_engine::machine::builder::{JointBuilder, LatchBuilder};
use foldwing_engine::machine::units::quoted;
use foldwing_engine::machine::{
    EndStops, Joint, JointMotion, Latch, LinearMotor, LinearSpring, Motion, Motor, Spring, Travel,
};
use nalgebra::{Rotation3, Vector3};

/// Name of the parent that is not a body.
const ROOT: &str = "root";

/// Axes, and keys without a field of the same name in the machine, with the joint types that have them.
const KEYS: &[(&str, &[JointType])] = {
    use JointType::{Cylindrical, Prismatic, Revolute, Sliding, Universal};
    &[
        ("axis", &[Revolute, Prismatic, Universal, Cylindrical]),
        ("rotation", &[Cylindrical]),
        ("translation", &[Cylindrical]),
        ("body_axis", &[Universal]),
        ("attitude", &[Sliding]),
        ("polynomial_deg", &[Revolute]),
        ("table_s_deg", &[Revolute]),
        ("polynomial_m", &[Prismatic, Sliding]),
        ("table_s_m", &[Prismatic, Sliding]),
    ]
};

/// Keys of a motor that only revolute joints have, with the corresponding fields of the machine.
const REVOLUTE_DRIVE_KEYS: &[(&str, &str)] = &[
    ("constant_torque_N_m", "constant_torque_n_m"),
    ("torque_limit_N_m", "torque_limit_n_m"),
    ("rate_limit_deg_s", "rate_limit_rad_s"),
    ("inertia_kg_m2", "inertia_kg_m2"),
    ("gear_ratio", "gear_ratio"),
    ("command_deg", "command_rad"),
];

/// Builds the joints of all bodies, in the order of the bodies. Invalid ones are replaced.
pub(super) fn build_all(file: &ModelFile, checker: &mut Checker) -> Vec<JointBuilder> {
    let joint_of = joint_of_bodies(file, checker);
    let held = |joint: usize| joint_of.contains(&Some(joint));
    let joints: Vec<JointBuilder> = file.joint.iter().map(|(name, joint)| build(name, joint, file, checker)).collect();
    for (index, (name, _)) in file.joint.iter().enumerate() {
        if !held(index) {
            checker.stands_in(&["joint", name]);
        }
    }
    let bodies = bodies(file).zip(joint_of);
    bodies
        .map(|(name, joint)| match joint {
            Some(joint) => joints[joint].clone(),
            None => {
                let name = format!("unheld_{name}");
                checker.stands_in(&["joint", &name]);
                Joint::clamped(name)
            }
        })
        .collect()
}

/// Names of all bodies: beams, then rigid bodies, then modal bodies.
fn bodies(file: &ModelFile) -> impl Iterator<Item = &String> {
    file.body.keys().chain(file.rigid_body.keys()).chain(file.modal_body.keys())
}

/// Joint of each body. Checks that children exist and differ from their parents, and that no body is the child of two
/// joints.
fn joint_of_bodies(file: &ModelFile, checker: &mut Checker) -> Vec<Option<usize>> {
    let mut joint_of = vec![None; bodies(file).count()];
    let mut hold = true;
    for (index, (name, joint)) in file.joint.iter().enumerate() {
        let path = ["joint", name, "child"];
        let earlier = file.joint.values().take(index).position(|other| other.child == joint.child);
        let Some(body) = bodies(file).position(|body| *body == joint.child) else {
            checker.unknown_name(&path, &joint.child, "a body", bodies(file).map(String::as_str));
            hold = false;
            continue;
        };
        if joint.child == joint.parent {
            checker.refuse(&path, "a body other than the parent");
            hold = false;
        } else if let Some((other, _)) = earlier.and_then(|earlier| file.joint.get_index(earlier)) {
            checker.refuse(
                &path,
                format!(
                    "a body that is not yet the child of another joint; this one is the child of \
                                           {other:?}"
                ),
            );
            hold = false;
        } else {
            joint_of[body] = Some(index);
        }
    }
    hold &= file.joint.values().all(|joint| joint.parent == ROOT || bodies(file).any(|body| *body == joint.parent));
    if hold {
        for (name, _) in bodies(file).zip(&joint_of).filter(|(_, joint)| joint.is_none()) {
            let allowed = format!("exactly one joint with child = {name:?}");
            checker.refuse_as(&["body", name], "a body without a joint", allowed);
        }
    }
    joint_of
}

/// Builds a joint.
fn build(name: &str, joint: &JointFile, file: &ModelFile, checker: &mut Checker) -> JointBuilder {
    for (key, types) in KEYS.iter().filter(|(_, types)| !types.contains(&joint.kind)) {
        if checker.states(&["joint", name, key]) {
            if *key == "axis" && joint.kind == JointType::Sliding {
                if joint.attitude != Some(AttitudeFile::Hinge) {
                    checker.refuse(&["joint", name, key], "this key of a sliding joint only with attitude = \"hinge\"");
                }
                continue;
            }
            let freedoms = joint.kind.freedoms().iter();
            let freedoms = freedoms.filter(|own| types.iter().any(|kind| kind.travel() == Some(own.travel)));
            let freedoms: Vec<&str> = freedoms.map(|own| own.name).collect();
            let names: Vec<&str> = types.iter().copied().map(JointType::name).collect();
            let allowed = match freedoms.is_empty() {
                true => format!("this key only with type = {}", quoted(&names)),
                false => format!("this key of a {} joint only in its {}", joint.kind.name(), quoted(&freedoms)),
            };
            checker.refuse(&["joint", name, key], allowed);
        }
    }
    for (key, field) in
        REVOLUTE_DRIVE_KEYS.iter().filter(|_| [JointType::Universal, JointType::Ball].contains(&joint.kind))
    {
        // set only values that are stated, so that the machine keeps its defaults for the others
        if checker.states(&["joint", name, "motor", key]) {
            checker.refuse(&["joint", name, "motor", key], "this key only with type = \"revolute\"");
            checker.stands_in(&["joint", name, "motor", field]);
        }
    }
    let place = parent_frame(name, joint, file, checker);
    // rotates vectors to the parent frame of the joint
    let turned = |vector: Vector3<f64>| match place {
        Some(place) => Rotation3::new(radians(place.rotation_deg)) * vector,
        None => vector,
    };
    let axis = turned(Vector3::from(joint.axis.unwrap_or_default()));
    let mut built = match joint.kind {
        JointType::Clamped => Joint::clamped(name),
        JointType::Revolute => Joint::revolute(name, axis),
        JointType::Prismatic => Joint::prismatic(name, axis),
        JointType::Sliding => Joint::sliding(name).attitude(joint.attitude()),
        JointType::Universal => Joint::universal(name, axis, joint.body_axis.unwrap_or_default()),
        JointType::Ball => Joint::ball(name),
        JointType::Free => Joint::free(name),
        JointType::Cylindrical => {
            joint.kind.freedoms().iter().fold(Joint::cylindrical(name, axis), |chain, freedom| {
                let table = joint.freedom(freedom.travel);
                let change = |own| act(own, &freedom.joint(name), &table, checker);
                match freedom.travel {
                    Travel::Rotation => chain.rotation(change),
                    Travel::Translation => chain.translation(change),
                }
            })
        }
    };
    built = on_parent(built, name, joint, checker);
    let mount = Rotation3::new(radians(joint.mount_rotation_deg));
    built = match place {
        Some(place) => built.mount((Rotation3::new(radians(place.rotation_deg)) * mount).into_inner()),
        None => built.mount(mount.into_inner()),
    };
    let from_m = place.map_or(Vector3::zeros(), |place| Vector3::from(place.position_m));
    built = built.offset_m(from_m + turned(Vector3::from(joint.parent_offset_m.unwrap_or_default())));
    if let Some(velocity_deg_s) = joint.start_angular_velocity_deg_s {
        built = built.start_angular_velocity_rad_s(turned(radians(velocity_deg_s)));
    }
    if let Some(velocity_m_s) = joint.start_velocity_m_s {
        built = built.start_velocity_m_s(velocity_m_s);
    }
    act(built, name, joint, checker)
}

/// Adds start, motion, motor, springs, latch and end stops to a joint, or to a degree of freedom of a chain.
fn act(mut built: JointBuilder, name: &str, joint: &JointFile, checker: &mut Checker) -> JointBuilder {
    refuse_other_travel(name, joint, checker);
    if joint.kind.travel() == Some(Travel::Translation) && checker.states(&["joint", name, "motor", "gear_ratio"]) {
        checker.refuse(&["joint", name, "motor", "gear_ratio"], "this key only with type = \"revolute\"");
    }
    if let Some(angle_deg) = joint.start_angle_deg {
        built = built.start_angle_rad(angle_deg.to_radians());
    }
    if let Some(rate_deg_s) = joint.start_rate_deg_s {
        built = built.start_rate_rad_s(rate_deg_s.to_radians());
    }
    if let Some(position_m) = joint.start_position_m {
        built = built.start_position_m(position_m);
    }
    if let Some(rate_m_s) = joint.start_rate_m_s {
        built = built.start_rate_m_s(rate_m_s);
    }
    if let Some(release) = joint.release {
        built = built.release(release);
    }
    if let Some(kind) = joint.motion {
        match motion(name, joint, kind, checker) {
            Some(motion) => built = built.motion(motion),
            None => checker.stands_in(&["joint", name]),
        }
    }
    if joint.motion != Some(MotionType::Prescribed) && joint.kind.travel().is_some() {
        let keys = match joint.travel() {
            Travel::Rotation => ["polynomial_deg", "table_s_deg", "table_ends"],
            Travel::Translation => ["polynomial_m", "table_s_m", "table_ends"],
        };
        for key in keys {
            if checker.states(&["joint", name, key]) {
                checker.refuse(&["joint", name, key], "this key only with motion = \"prescribed\"");
            }
        }
    }
    if let Some(motor) = &joint.motor {
        built = built.motor(build_motor(motor, joint.travel()));
    }
    if let Some(spring) = &joint.spring {
        built = built.spring(build_spring(spring, joint.travel()));
    }
    if let Some(generator) = crate::generator::build(name, joint, checker) {
        built = built.generator(generator);
    }
    if let Some(dc_motor) = crate::dc_motor::build(name, joint, checker) {
        built = built.dc_motor(dc_motor);
    }
    if let Some(latch) = joint.latch.as_ref().and_then(|latch| build_latch(name, latch, joint.travel(), checker)) {
        built = built.latch(latch);
    }
    if let Some(end_stops) =
        joint.end_stops.as_ref().and_then(|stops| build_stops(name, stops, joint.travel(), checker))
    {
        built = built.end_stops(end_stops);
    }
    built
}

/// Reports keys of a revolute joint in a prismatic one, and vice versa.
fn refuse_other_travel(name: &str, joint: &JointFile, checker: &mut Checker) {
    for (table, turns, slides) in PAIRS {
        let (strange, allowed) = match joint.kind {
            JointType::Prismatic | JointType::Sliding => {
                let kind = joint.kind.name();
                (turns, format!("{slides} instead: the keys of a {kind} joint are in m and N"))
            }
            JointType::Revolute => {
                (slides, format!("{turns} instead: the keys of a revolute joint are in deg and N·m"))
            }
            // an error at the table itself; each degree of freedom is checked with its own tables
            JointType::Cylindrical => continue,
            JointType::Clamped | JointType::Universal | JointType::Ball | JointType::Free => {
                (slides, "this key only with type = \"prismatic\" or \"sliding\"".to_owned())
            }
        };
        if checker.states(&["joint", name, table, strange]) {
            checker.refuse(&["joint", name, table, strange], allowed);
            if *strange == "stiffness_N_m_rad" || *strange == "stiffness_N_m" {
                checker.stands_in(&["joint", name, "latch"]); // the ratio of the latch may refer to this stiffness
            }
        }
    }
}

fn radians(degrees: [f64; 3]) -> Vector3<f64> {
    Vector3::from(degrees).map(f64::to_radians)
}

/// Parent frame of a joint, if it names one.
fn parent_frame<'f>(
    name: &str,
    joint: &JointFile,
    file: &'f ModelFile,
    checker: &mut Checker,
) -> Option<&'f FrameFile> {
    let frame = joint.parent_frame.as_ref()?;
    let path = ["joint", name, "parent_frame"];
    let Some(parent) = file.rigid_body.get(&joint.parent) else {
        checker.refuse(&path, "this key only with a rigid body as parent");
        return None;
    };
    let found = parent.frame.get(frame);
    if found.is_none() {
        let known = parent.frame.keys().map(String::as_str);
        checker.unknown_name(&path, frame, &format!("a frame of {:?}", joint.parent), known);
    }
    found
}

fn on_parent(built: JointBuilder, name: &str, joint: &JointFile, checker: &mut Checker) -> JointBuilder {
    if joint.parent == ROOT {
        if joint.parent_position_m.is_some() {
            checker.refuse(
                &["joint", name, "parent_position_m"],
                "this key only with a body as parent; on the root write root_position_m = [x, y, z] (m)",
            );
        }
        return built.at_root(joint.root_position_m.unwrap_or_default());
    }
    if joint.root_position_m.is_some() {
        checker.refuse(
            &["joint", name, "root_position_m"],
            "this key only with parent = \"root\"; on a body write parent_position_m (m), the distance along it",
        );
    }
    match joint.parent_position_m {
        Some(position_m) => built.on_at(&joint.parent, position_m),
        None => built.on(&joint.parent),
    }
}

/// Motion of a revolute or prismatic joint; `None` after an error for which there is no replacement.
fn motion(name: &str, joint: &JointFile, kind: MotionType, checker: &mut Checker) -> Option<JointMotion> {
    match kind {
        MotionType::Free => return Some(JointMotion::Free),
        MotionType::Locked => return Some(JointMotion::Locked),
        MotionType::Prescribed if joint.kind.travel().is_none() => return Some(JointMotion::Locked), // already reported
        MotionType::Prescribed => {}
    }
    let travel = joint.travel();
    let (polynomial, table, [polynomial_key, table_key], pair, si): (_, _, _, _, fn(f64) -> f64) = match travel {
        Travel::Rotation => (
            &joint.polynomial_deg,
            &joint.table_s_deg,
            ["polynomial_deg", "table_s_deg"],
            "pairs [time in s, angle in deg] with ascending times",
            f64::to_radians,
        ),
        Travel::Translation => (
            &joint.polynomial_m,
            &joint.table_s_m,
            ["polynomial_m", "table_s_m"],
            "pairs [time in s, position in m] with ascending times",
            |position_m| position_m,
        ),
    };
    if joint.table_ends.is_some() && table.is_none() {
        checker.refuse(&["joint", name, "table_ends"], format!("this key only with {table_key}"));
    }
    match (polynomial, table) {
        (Some(coefficients), None) => {
            let coefficients = coefficients.iter().copied().map(si).collect();
            Some(JointMotion::Prescribed(Motion::Polynomial(coefficients)))
        }
        (None, Some(table)) => {
            if !table.windows(2).all(|pair| pair[0][0] < pair[1][0]) {
                checker.refuse(&["joint", name, table_key], pair);
                return None;
            }
            let points = table.iter().map(|[time_s, value]| (*time_s, si(*value))).collect();
            let onward = joint.table_ends == Some(TableEnds::Extrapolate);
            Some(JointMotion::Prescribed(if onward { Motion::Onward(points) } else { Motion::Table(points) }))
        }
        (Some(_), Some(_)) => {
            checker.refuse(&["joint", name, table_key], format!("either {polynomial_key} or {table_key}, not both"));
            None
        }
        (None, None) => {
            let allowed = format!("this motion with {polynomial_key} or {table_key}");
            checker.refuse(&["joint", name, "motion"], allowed);
            None
        }
    }
}

fn build_motor(motor: &MotorFile, travel: Travel) -> Motor {
    let none = Motor::default();
    if travel == Travel::Translation {
        let none = LinearMotor::default();
        return Motor::from(LinearMotor {
            stiffness_n_m: motor.stiffness_n_m,
            damping_n_s_m: motor.damping_n_s_m,
            constant_force_n: motor.constant_force_n,
            force_limit_n: motor.force_limit_n.unwrap_or(none.force_limit_n),
            rate_limit_m_s: motor.rate_limit_m_s.unwrap_or(none.rate_limit_m_s),
            mass_kg: motor.mass_kg,
            command_m: motor.command_m,
        });
    }
    Motor {
        stiffness_n_m_rad: motor.stiffness_n_m_rad,
        damping_n_m_s_rad: motor.damping_n_m_s_rad,
        constant_torque_n_m: motor.constant_torque_n_m,
        torque_limit_n_m: motor.torque_limit_n_m.unwrap_or(none.torque_limit_n_m),
        rate_limit_rad_s: motor.rate_limit_deg_s.map_or(none.rate_limit_rad_s, f64::to_radians),
        inertia_kg_m2: motor.inertia_kg_m2,
        gear_ratio: motor.gear_ratio,
        command_rad: motor.command_deg.to_radians(),
    }
}

fn build_spring(spring: &SpringFile, travel: Travel) -> Spring {
    match travel {
        Travel::Rotation => Spring {
            stiffness_n_m_rad: spring.stiffness_n_m_rad,
            damping_n_m_s_rad: spring.damping_n_m_s_rad,
            rest_angle_rad: spring.rest_angle_deg.to_radians(),
        },
        Travel::Translation => Spring::from(LinearSpring {
            stiffness_n_m: spring.stiffness_n_m,
            damping_n_s_m: spring.damping_n_s_m,
            rest_position_m: spring.rest_position_m,
        }),
    }
}

/// Builds a latch; `None` after an error.
fn build_latch(name: &str, latch: &LatchFile, travel: Travel, checker: &mut Checker) -> Option<LatchBuilder> {
    let path = ["joint", name, "latch", "stiffness_ratio"];
    let (key, stiffness, stand, capture) = match travel {
        Travel::Rotation => (
            "stiffness_N_m_rad",
            latch.stiffness_n_m_rad,
            latch.angle_deg.to_radians(),
            latch.capture_deg.map(f64::to_radians),
        ),
        Travel::Translation => ("stiffness_N_m", latch.stiffness_n_m, latch.position_m, latch.capture_m),
    };
    let mut built = match (latch.kind, latch.stiffness_ratio, stiffness) {
        (LatchType::Rigid, ..) => {
            for key in ["stiffness_ratio", key] {
                if checker.states(&["joint", name, "latch", key]) {
                    let allowed = "this key only with kind = \"elastic\": a rigid latch has no spring";
                    checker.refuse(&["joint", name, "latch", key], allowed);
                }
            }
            Latch::rigid()
        }
        (LatchType::Elastic, Some(ratio), None) => Latch::with_ratio(ratio),
        (LatchType::Elastic, None, Some(stiffness_n_m_rad)) => Latch::with_stiffness_n_m_rad(stiffness_n_m_rad),
        (LatchType::Elastic, Some(_), Some(_)) => {
            checker.refuse(&path, format!("either stiffness_ratio or {key}, not both"));
            return None;
        }
        (LatchType::Elastic, None, None) => {
            checker.refuse(&path, format!("a finite number > 1, or {key} instead, or kind = \"rigid\""));
            return None;
        }
    };
    built = built.angle_rad(stand);
    if let Some(capture) = capture {
        built = built.capture_rad(capture);
    }
    Some(built.initially_closed(latch.initially_closed).enable(latch.enable))
}

/// Builds end stops; `None` after an error.
fn build_stops(name: &str, end_stops: &EndStopsFile, travel: Travel, checker: &mut Checker) -> Option<EndStops> {
    let (key, stiffness, damping_n_m_s_rad, [lower_rad, upper_rad]) = match travel {
        Travel::Rotation => (
            "stiffness_N_m_rad",
            end_stops.stiffness_n_m_rad,
            end_stops.damping_n_m_s_rad,
            [end_stops.lower_deg, end_stops.upper_deg].map(|end| end.map(f64::to_radians)),
        ),
        Travel::Translation => {
            ("stiffness_N_m", end_stops.stiffness_n_m, end_stops.damping_n_s_m, [end_stops.lower_m, end_stops.upper_m])
        }
    };
    let Some(stiffness_n_m_rad) = stiffness else {
        checker.refuse(&["joint", name, "end_stops", key], "a finite number > 0");
        return None;
    };
    Some(EndStops { lower_rad, upper_rad, stiffness_n_m_rad, damping_n_m_s_rad })
}
