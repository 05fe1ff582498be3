//! Comparison of the outputs of two runs of one machine in two views.

use crate::machines::{Frame, View};
use foldwing::machine::{JointKind, Machine, Parent, SpatialFreedom};
use foldwing::plant::Outputs;
use nalgebra::{UnitQuaternion, Vector3};

/// An output by name, as three numbers, or nine of a rotation matrix.
struct Row {
    name: String,
    values: Vec<f64>,
    /// Angles of joints and times are compared relative to their own magnitude, vectors relative to the magnitude of the vector.
    size_of_switch: bool,
}

/// All outputs of the original machine, transformed to a view.
fn rows(machine: &Machine, outputs: &Outputs, view: &View) -> Vec<Row> {
    let mut rows = Vec::new();
    let mut add = |name: String, values: Vec<f64>, size_of_switch| rows.push(Row { name, values, size_of_switch });
    let of = |v: Vector3<f64>| v.as_slice().to_vec();
    let polar = |v: Vector3<f64>| of(view.polar(v, Frame::Root));
    let axial = |v: Vector3<f64>| of(view.axial(v, Frame::Root));
    let polar_inside = |v: Vector3<f64>| of(view.polar(v, Frame::Body));
    let axial_inside = |v: Vector3<f64>| of(view.axial(v, Frame::Body));
    let attitude = |rotation: UnitQuaternion<f64>, frame| {
        let q = view.attitude(rotation, frame);
        // the rotation matrix has no ambiguous sign
        q.to_rotation_matrix().matrix().as_slice().to_vec()
    };
    for (i, joint) in outputs.joints().iter().enumerate() {
        add(format!("joint {i} angle"), vec![joint.angle_rad], false);
        add(format!("joint {i} rate"), vec![joint.rate_rad_s], false);
        add(format!("joint {i} neutral"), vec![joint.neutral_angle_rad], false);
        add(format!("joint {i} torque"), vec![joint.torque_applied_n_m], false);
        add(format!("joint {i} motor"), vec![joint.motor_torque_n_m], false);
        add(format!("joint {i} spring"), vec![joint.spring_torque_n_m], false);
        add(format!("joint {i} holding"), vec![joint.holding_torque_n_m], false);
        add(format!("joint {i} latch torque"), vec![joint.latch_torque_n_m], false);
    }
    let spatial: Vec<bool> = (machine.bodies.iter())
        .filter(|body| matches!(body.joint.kind, JointKind::Spatial(_)))
        .map(|body| matches!(body.joint.parent, Parent::Root { .. }))
        .collect();
    for (i, (joint, on_root)) in outputs.spatial().iter().zip(spatial).enumerate() {
        let frame = if on_root { Frame::Root } else { Frame::Body };
        add(format!("spatial {i} rotation"), attitude(joint.rotation, frame), false);
        add(format!("spatial {i} rate"), of(view.axial(joint.angular_velocity_rad_s, frame)), false);
    }
    // a free joint transmits nothing: its reaction is round-off, and is not an output of an FMU
    let is_free = |body: usize| match &machine.bodies[body].joint.kind {
        JointKind::Spatial(joint) => joint.freedom == SpatialFreedom::Free,
        JointKind::Clamped | JointKind::Revolute(_) | JointKind::Prismatic(_) | JointKind::Sliding(_) => false,
    };
    for (i, wrench) in outputs.joint_reactions().iter().enumerate().filter(|(body, _)| !is_free(*body)) {
        add(format!("reaction {i} force"), polar(wrench.force_n), false);
        add(format!("reaction {i} moment"), axial(wrench.moment_n_m), false);
    }
    for (i, gauge) in outputs.gauges().iter().enumerate() {
        add(format!("gauge {i}"), vec![*gauge], false);
    }
    for (i, wrench) in outputs.internal_loads().iter().enumerate() {
        add(format!("internal load {i} force"), polar_inside(wrench.force_n), false);
        add(format!("internal load {i} moment"), axial_inside(wrench.moment_n_m), false);
    }
    for (i, closure) in outputs.loops().iter().enumerate() {
        add(format!("loop {i} gap"), polar(closure.gap_m), false);
        add(format!("loop {i} force"), polar(closure.force_n), false);
    }
    add("root force".into(), polar(outputs.root().force_n), false);
    add("root moment".into(), axial(outputs.root().moment_n_m), false);
    for (what, points) in [("tip", outputs.tips()), ("station", outputs.stations())] {
        for (i, point) in points.iter().enumerate() {
            add(format!("{what} {i} position"), polar(point.position_m), false);
            add(format!("{what} {i} velocity"), polar(point.velocity_m_s), false);
            add(format!("{what} {i} spin"), axial(point.angular_velocity_rad_s), false);
            add(format!("{what} {i} acceleration"), polar(point.acceleration_m_s2), false);
            add(format!("{what} {i} angular acceleration"), axial(point.angular_acceleration_rad_s2), false);
            add(format!("{what} {i} rotation"), attitude(point.rotation, Frame::Root), false);
            add(format!("{what} {i} specific force"), polar_inside(point.specific_force_m_s2), false);
        }
    }
    let energy = outputs.energy();
    for (name, value) in [
        ("kinetic", energy.kinetic),
        ("elastic", energy.elastic),
        ("motor", energy.motor),
        ("work", energy.work),
        ("dissipated", energy.dissipated),
    ] {
        add(format!("energy {name}"), vec![value], false);
    }
    add("air force".into(), polar(outputs.air_total().force_n), false);
    add("air moment".into(), axial(outputs.air_total().moment_n_m), false);
    for (i, wrench) in outputs.air_stations().iter().enumerate() {
        add(format!("air at station {i} force"), polar(wrench.force_n), false);
        add(format!("air at station {i} moment"), axial(wrench.moment_n_m), false);
    }
    for (i, rotor) in outputs.rotor().iter().enumerate() {
        for (name, value) in [
            ("thrust", rotor.thrust_n),
            ("torque", rotor.torque_n_m),
            ("wind", rotor.wind_m_s),
            ("induction", rotor.induction),
            ("tip speed ratio", rotor.tip_speed_ratio),
        ] {
            add(format!("rotor {i} {name}"), vec![value], false);
        }
        // the direction of the shaft remains downwind; the rotor rotates the other way in the mirror image
        add(format!("rotor {i} speed"), vec![rotor.speed_rad_s.abs()], false);
    }
    for (i, flap) in outputs.flaps().iter().enumerate() {
        add(format!("flap {i} moment"), vec![flap.hinge_moment_n_m], false);
    }
    for (i, generator) in outputs.generators().iter().enumerate() {
        add(format!("generator {i} torque"), vec![generator.torque_n_m], false);
        add(format!("generator {i} power"), vec![generator.power_w], false);
    }
    for (i, body) in outputs.modal().iter().enumerate() {
        add(format!("modal body {i} deflection"), polar_inside(body.deflection_m), false);
        add(format!("modal body {i} force"), polar_inside(body.root.force_n), false);
        add(format!("modal body {i} moment"), axial_inside(body.root.moment_n_m), false);
    }
    for (i, latch) in outputs.latches().iter().enumerate() {
        add(format!("latch {i} closed"), vec![f64::from(u8::from(latch.closed.is_on()))], true);
    }
    for (i, failure) in outputs.failures().iter().enumerate() {
        add(format!("failure {i}"), vec![f64::from(u8::from(failure.failed.is_on()))], true);
    }
    rows
}

/// Unit of an output: small loads and energies are compared relative to others of the same unit only.
#[derive(Clone, Copy, PartialEq)]
enum Unit {
    Newton,
    NewtonMetre,
    Joule,
    /// Accelerations, m/s² or rad/s².
    Acceleration,
    /// Velocities, m/s or rad/s.
    Rate,
    /// Deflections and gaps.
    Metre,
    Other,
}

impl Unit {
    /// Unit of a kind of output; prismatic joints have forces where revolute joints have torques.
    fn of(kind: &str, slides: bool) -> Self {
        let has = |words: &[&str]| words.iter().any(|word| kind.contains(word));
        let of_joint = kind.starts_with("joint ") && has(&["torque", "motor", "spring", "holding"]);
        match () {
            () if of_joint && slides => Self::Newton,
            () if of_joint || has(&["moment", "torque"]) => Self::NewtonMetre,
            () if has(&["force", "thrust"]) => Self::Newton,
            () if kind.starts_with("energy ") => Self::Joule,
            () if has(&["acceleration"]) => Self::Acceleration,
            () if has(&["rate", "velocity", "spin"]) => Self::Rate,
            () if has(&["deflection", "gap", "position"]) => Self::Metre,
            () => Self::Other,
        }
    }

    /// Smallest scale for differences, from the largest value of this unit in a run. Values that vanish by symmetry are round-off of it:
    /// all reactions of a flying body, the work of balanced forces.
    fn floor(self, largest: f64) -> f64 {
        match self {
            // these machines weigh at least 1 N
            Self::Newton => 1e-2 * largest.max(1.0),
            // and are at least 0.1 m long
            Self::NewtonMetre => 1e-2 * largest.max(0.1),
            Self::Joule => 1e-4 * largest.max(1e-5),
            // accelerations follow from differences of axial forces of stiff bodies: their round-off is 4e-11 at standstill and 1e-9 in
            // flight
            Self::Acceleration => 10.0,
            // 3e-14 at standstill
            Self::Rate => 1e-4,
            // round-off of positions of at least 0.1 m
            Self::Metre => 1e-6,
            Self::Other => 1e-9,
        }
    }
}

/// Kind of an output: its name without the numbers of bodies and joints.
fn kind(name: &str) -> String {
    name.chars().filter(|c| !c.is_ascii_digit()).collect()
}

/// Units of the outputs of a machine.
fn units(machine: &Machine, rows: &[Row]) -> Vec<Unit> {
    let slides: Vec<bool> = machine
        .one_freedoms()
        .map(|(body, _)| match machine.bodies[body].joint.kind {
            JointKind::Prismatic(_) | JointKind::Sliding(_) => true,
            JointKind::Clamped | JointKind::Revolute(_) | JointKind::Spatial(_) => false,
        })
        .collect();
    let joint =
        |name: &str| name.split(' ').nth(1).and_then(|index| index.parse().ok()).and_then(|i: usize| slides.get(i));
    rows.iter().map(|row| Unit::of(&kind(&row.name), joint(&row.name) == Some(&true))).collect()
}

/// Scales for comparing the outputs of two runs: the largest value of their kind and unit, and at least the floor of the unit.
fn sizes(rows: &[Row], units: &[Unit], cover: &[f64]) -> Vec<f64> {
    let kinds: Vec<String> = rows.iter().map(|row| kind(&row.name)).collect();
    let most =
        |chosen: &dyn Fn(usize) -> bool| (0..rows.len()).filter(|&j| chosen(j)).map(|j| cover[j]).fold(0.0, f64::max);
    // the largest of all outputs of a kind: a moment that vanishes by symmetry is round-off of the others
    let size = |i: usize| {
        let floor = units[i].floor(most(&|j| units[j] == units[i]));
        floor.max(most(&|j| kinds[j] == kinds[i] && units[j] == units[i]))
    };
    (0..rows.len()).map(size).collect()
}

/// Outputs of the original run, transformed to a view, against those of a run of the machine in this view: the largest difference relative
/// to the range of the output, by name. Outputs that are round-off of others of their kind have the scale of those.
pub fn worst(machine: &Machine, plain: &[Outputs], other: &[Outputs], view: &View) -> (f64, String) {
    let here: Vec<Vec<Row>> = plain.iter().map(|outputs| rows(machine, outputs, view)).collect();
    let there: Vec<Vec<Row>> = other.iter().map(|outputs| rows(machine, outputs, &View::plain())).collect();
    let norm = |values: &[f64]| values.iter().fold(0.0f64, |most, value| most.max(value.abs()));
    let cover: Vec<f64> =
        (0..here[0].len()).map(|i| here.iter().map(|rows| norm(&rows[i].values)).fold(0.0, f64::max)).collect();
    let units = units(machine, &here[0]);
    let mut sizes = sizes(&here[0], &units, &cover);
    if !machine.closures.is_empty() {
        // forces of loops are gaps of 1e-16 m times a stiffness of 1e5 N/m and more; on sections of 1e-6 kg m2 that is 1e-5 rad/s2
        let of_accelerations = sizes.iter_mut().zip(&units).filter(|(_, unit)| **unit == Unit::Acceleration);
        of_accelerations.for_each(|(size, _)| *size *= 30.0);
    }
    let mut worst = (0.0, String::from("none"));
    for (i, size) in sizes.iter().enumerate() {
        for (a, b) in here.iter().zip(&there) {
            let off = a[i].values.iter().zip(&b[i].values).fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
            let share = if a[i].size_of_switch { off } else { off / size };
            if share > worst.0 {
                worst = (
                    share,
                    format!("{} at {} s: {:?} for {:?}", a[i].name, time_s(plain, &here, a), b[i].values, a[i].values),
                );
            }
        }
    }
    worst
}

fn time_s(plain: &[Outputs], here: &[Vec<Row>], rows: &[Row]) -> f64 {
    let at = here.iter().position(|other| std::ptr::eq(other.as_slice(), rows)).expect("one of them");
    plain[at].time_s
}

/// Small loads and energies are compared relative to their own range, down to a floor of their unit: a force of 3 N is not lost next to a
/// moment of 10⁶ N·m, nor 4 kJ dissipated next to 10 MJ of kinetic energy.
#[test]
fn floors_are_those_of_the_unit() {
    let row = |name: &str| Row { name: name.into(), values: vec![0.0], size_of_switch: false };
    let names = ["reaction 0 force", "reaction 0 moment", "flap 0 moment", "energy kinetic", "energy dissipated"];
    let rows = names.map(row);
    let units = names.map(|name| Unit::of(&kind(name), false));
    let found = sizes(&rows, &units, &[3.0, 1e6, 2.0, 1e7, 4e3]);
    for ((name, found), known) in names.iter().zip(found).zip([3.0, 1e6, 1e4, 1e7, 4e3]) {
        assert!((found / known - 1.0_f64).abs() < 1e-12, "{name}: {found} instead of {known}");
    }
    let slides = Unit::of(&kind("joint 3 holding"), true);
    assert!(slides == Unit::Newton && Unit::of(&kind("joint 3 holding"), false) == Unit::NewtonMetre);
}
