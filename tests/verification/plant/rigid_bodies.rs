//! Bodies without elements, offsets, frames: rigid pendulums, a gyroscope, joints at an offset from their body.

use crate::plant::machines::*;
use crate::plant::rigid::worst_miss_m;
use foldwing::beam::section::{Material, Section, Solid};
use foldwing::config;
use foldwing::machine::builder::{BodyBuilder, JointBuilder};
use foldwing::machine::*;
use foldwing::plant::{Holding, Outputs, Plant};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::sync::Arc;

const LENGTH_M: f64 = 1.8;
const GRAVITY_M_S2: f64 = 9.8;

/// A rigid rod along `x` with the inertia of the steel rods of P-65: 3.12 kg/m, a square section of 20 mm.
fn rod(name: &str) -> BodyBuilder {
    let mass_kg = 3.12 * LENGTH_M;
    let (along, across) = (0.02f64.powi(2) / 6.0, (LENGTH_M.powi(2) + 0.02f64.powi(2)) / 12.0);
    let inertia = Matrix3::from_diagonal(&(Vector3::new(along, across, across) * mass_kg));
    Body::rigid(name).inertia(mass_kg, [0.5 * LENGTH_M, 0.0, 0.0], inertia)
}

/// Rigid rods in a row on free hinges at their ends, and a frame at the end of the last one.
fn rods(angles_rad: &[f64]) -> Plant {
    let mut parts = Vec::new();
    for (index, angle_rad) in angles_rad.iter().enumerate() {
        let hinge = Joint::hinge(format!("hinge{index}"), free_hinge(*angle_rad));
        let hinge = match index {
            0 => hinge,
            _ => hinge.on(format!("rod{}", index - 1)).offset_m([LENGTH_M, 0.0, 0.0]),
        };
        parts.push((rod(&format!("rod{index}")), hinge));
    }
    let last = format!("rod{}", angles_rad.len() - 1);
    parts.push((Body::rigid("end"), Joint::clamped("weld").on(last).offset_m([LENGTH_M, 0.0, 0.0])));
    let mut machine = machine(parts);
    machine.gravity_m_s2 = Vector3::new(0.0, 0.0, -GRAVITY_M_S2);
    machine.solver = solver(Method::Esdirk4, 1e-9);
    start(machine)
}

/// RB-01. Rigid rods against the rigid pendulum and double pendulums, to which P-65 and P-66 compare elastic rods. Tolerance of 1e-9 over
/// about 1e3 steps of a motion that amplifies errors tenfold.
#[test]
fn rb01_rigid_links_are_the_rigid_pendulums() {
    let limits = expected("dyn.rigid_limits");
    for (name, angles_rad, end_s) in [
        ("rigid_rod_pendulum_L1.8_rhoA3.12_no_rot (theta,x,y)", &[0.0][..], 2.0),
        ("rigid_double_rod_L1.8_from_horizontal (thA,thB,x,y)", &[0.0, 0.0], 1.5),
        ("rigid_double_rod_L1.8_A_horizontal_B_down (thA,thB,x,y)", &[0.0, std::f64::consts::FRAC_PI_2], 1.5),
    ] {
        let worst_m = worst_miss_m(rods(angles_rad), &limits[name], end_s);
        println!("RB-01 {name}: {worst_m:.1e} m");
        assert!(worst_m < 1e-6, "{name}: free end misses by {worst_m:.1e} m");
    }
}

/// RB-02. A gyroscope: a disc with a horizontal axis on a ball joint precesses steadily at `Ω = m g l/(I ω)` if it starts at this rate, and
/// its axis stays horizontal; the joint carries its weight. The tolerance of 1e-8 per step over 16 revolutions.
#[test]
fn rb02_a_gyroscope_precesses() {
    let (mass_kg, arm_m, axial, spin_rad_s) = (2.0, 0.15, 0.01, 200.0);
    let rate_rad_s = mass_kg * GRAVITY_M_S2 * arm_m / (axial * spin_rad_s);
    let inertia = Matrix3::from_diagonal(&Vector3::new(axial, 0.006, 0.006));
    let disc = Body::rigid("disc").inertia(mass_kg, [arm_m, 0.0, 0.0], inertia);
    let joint = Joint::ball("pivot").start_angular_velocity_rad_s([spin_rad_s, 0.0, rate_rad_s]);
    let mut machine = machine([(disc, joint)]);
    machine.gravity_m_s2 = Vector3::new(0.0, 0.0, -GRAVITY_M_S2);
    machine.solver.tolerance = 1e-8;
    let mut plant = start(machine);
    let before_j = balance_j(plant.outputs());
    coast(&mut plant, 0.5);
    let axis = plant.outputs().spatial()[0].rotation * Vector3::x();
    let turned = Vector3::new((rate_rad_s * 0.5).cos(), (rate_rad_s * 0.5).sin(), 0.0);
    let miss = (axis - turned).norm();
    let force_n = plant.outputs().joint_reactions()[0].force_n;
    // the centre of mass moves on a circle at the rate Ω
    let expected_n = mass_kg * (Vector3::z() * GRAVITY_M_S2 - turned * (arm_m * rate_rad_s.powi(2)));
    let drift = (balance_j(plant.outputs()) - before_j).abs() / plant.outputs().energy().kinetic;
    println!("RB-02 axis off by {miss:.1e}, force by {:.1e}, drift {drift:.1e}", (force_n - expected_n).norm());
    assert!(miss < 1e-5 && (force_n - expected_n).norm() < 1e-3 * expected_n.norm() && drift < 1e-5);
}

/// A wing on a fuselage fixed to the root, with loads on the wing.
fn wing_on(fuselage: Option<BodyBuilder>, roots: [JointBuilder; 2]) -> Machine {
    let material = Material { youngs_modulus_pa: 2.83e9, shear_modulus_pa: 1e9, density_kg_m3: 1425.0 };
    let section = Section::rectangle(0.05, 0.002, &material, Some(0.18));
    let half = |name: &str| body(name, 0.15, &section, ElementKind::Linear, 2).mass_damping_1_s(2.5);
    let [right, left] = roots;
    let mut parts = Vec::new();
    if let Some(fuselage) = fuselage {
        parts.push((fuselage, Joint::clamped("hold").at_root([0.1, -0.2, 0.3])));
    }
    parts.push((half("right"), right));
    parts.push((half("left"), left));
    parts.push((half("tip"), Joint::hinge("fold", wing_hinge(0.026)).on("right")));
    let mut machine = machine(parts);
    machine.gravity_m_s2 = Vector3::new(-9.8, 0.0, 1.0);
    machine.solver.tolerance = 1e-9;
    machine
}

/// RB-03. Wings with offset and rotated roots on a fixed rigid fuselage move as if attached to the root at those positions: the lever arm
/// adds only round-off, and the root force includes the weight of the fuselage. The two runs choose different steps at a tolerance of 1e-9,
/// which leaves errors of 1e-9 m at the tips and, through the axial stiffness, of 1e-3 N in the force.
#[test]
fn rb03_offset_roots_are_places_on_the_root() {
    let arms = [Vector3::new(0.02, 0.03, -0.01), Vector3::new(-0.04, 0.01, 0.02)];
    let turns = [Vector3::new(0.1, 0.2, -0.3), Vector3::new(0.0, 0.1, 3.0)];
    let fuselage = || Body::rigid("fuselage").inertia(0.3, [0.0, 0.02, -0.03], Matrix3::from_diagonal_element(1e-3));
    let hung = [0, 1]
        .map(|i| Joint::clamped(format!("root{i}")).on("fuselage").offset_m(arms[i]).mount_rotation_rad(turns[i]));
    let placed = [0, 1].map(|i| {
        Joint::clamped(format!("root{i}")).at_root(Vector3::new(0.1, -0.2, 0.3) + arms[i]).mount_rotation_rad(turns[i])
    });
    let runs = [wing_on(Some(fuselage()), hung), wing_on(None, placed)].map(|machine| {
        let mut plant = start(machine);
        coast(&mut plant, 0.15);
        plant.outputs().clone()
    });
    let tips = |outputs: &Outputs| outputs.tips().iter().map(|tip| tip.position_m).collect::<Vec<_>>();
    let [hung, placed] = [0, 1].map(|run| tips(&runs[run]));
    // the wings are the last free ends in both
    let pairs = hung.iter().rev().zip(placed.iter().rev());
    let apart_m = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let weight_n: Vector3<f64> = runs[0].root().force_n - runs[1].root().force_n - 0.3 * Vector3::new(-9.8, 0.0, 1.0);
    println!("RB-03 tips {apart_m:.1e} m apart, root force off by {:.1e} N", weight_n.norm());
    assert!(runs[0].latches()[0].closed.is_on() && apart_m < 1e-8 && weight_n.norm() < 2e-3);
}

/// RB-04. A rigid pendulum hangs down in equilibrium and oscillates at `√(m g l/(I + m l²))`, also in its linear model.
#[test]
fn rb04_statics_and_modes_know_rigid_bodies() {
    let mut plant = rods(&[1.2]);
    plant.study().equilibrium(0.0, Holding::AsReleased).expect("it hangs");
    let end = plant.outputs().tips()[0].position_m;
    assert!((end - Vector3::new(0.0, 0.0, -LENGTH_M)).norm() < 1e-9, "{end}");
    let modes = plant.study().modes(1).expect("a mode");
    let per_mass = (LENGTH_M.powi(2) + 0.02f64.powi(2)) / 12.0 + 0.25 * LENGTH_M.powi(2);
    let expected_hz = (GRAVITY_M_S2 * 0.5 * LENGTH_M / per_mass).sqrt() / std::f64::consts::TAU;
    let error = modes[0].frequency_hz / expected_hz - 1.0;
    println!("RB-04 {expected_hz} Hz, off by {error:.1e}");
    assert!(error.abs() < 1e-9, "{} Hz, expected {expected_hz} Hz", modes[0].frequency_hz);
    assert_eq!(plant.study().second_order().expect("a linear model").mass.nrows(), 1);
}

/// RB-05. A machine of rigid bodies and beams from a file and the same machine built in code are identical: frames, offsets, inertia; a
/// machine tumbling in free flight conserves its energy, and the rate of its momentum is the weight.
#[test]
fn rb05_file_and_code_say_the_same() {
    let text = include_str!("rigid_bodies.toml");
    let read = config::parse(text, "rigid_bodies.toml").expect("a sound model");
    let material = Material { youngs_modulus_pa: 2.83e9, shear_modulus_pa: 0.0, density_kg_m3: 1425.0 };
    let plate = Solid::rectangle(0.05, 0.002, material).with_torsional_rigidity_n_m2(0.18);
    let wing = |name| Body::beam(name, 0.15, plate).elements(2);
    let inertia = Matrix3::new(2.4e-3, 0.0, 0.0, 0.0, 3e-4, 9e-5, 0.0, 9e-5, 2.55e-3);
    let turn = Rotation3::new(Vector3::new(0.0, 0.0, 180f64.to_radians()));
    let left_m = Vector3::new(0.0, -0.02, 0.01) + turn * Vector3::new(0.005, 0.0, 0.0);
    let drive = Motor { stiffness_n_m_rad: 0.05, ..Motor::default() };
    let rotor = AttachedMass { offset_m: Vector3::new(0.0, 0.02, 0.0), ..AttachedMass::point("rotor", 0.0, 0.02) };
    let flight = Joint::free("flight")
        .start_velocity_m_s([0.0, 12.0, 0.0])
        .start_angular_velocity_rad_s(Vector3::new(100.0, 400.0, -200.0).map(f64::to_radians));
    let written = Machine::builder("RigidBodies")
        .gravity_m_s2([0.0, 0.0, -9.81])
        .body(wing("right"), Joint::clamped("right_root").on("fuselage").offset_m([0.0, 0.02, 0.01]))
        .body(wing("left"), Joint::clamped("left_root").on("fuselage").offset_m(left_m).mount(turn.into_inner()))
        .body(Body::rigid("fuselage").inertia(0.3, [0.0, 0.02, -0.03], inertia), flight)
        .body(
            Body::rigid("engine").inertia(0.05, [0.0; 3], Matrix3::zeros()),
            Joint::revolute("pylon", [0.0, 0.0, 1.0]).on_at("left", 0.07).offset_m([0.0, 0.03, -0.02]).motor(drive),
        )
        .mass("engine", rotor)
        .solver(Solver { tolerance: 1e-8, ..Solver::default() })
        .stop_time_s(0.3)
        .build();
    assert_eq!(written.unwrap_or_else(|refused| panic!("{refused}")), read);
    let mut plant = Plant::new(Arc::new(read));
    plant.initialize(0.0).expect("accelerations");
    let before_j = balance_j(plant.outputs());
    coast(&mut plant, 0.3);
    let drift = (balance_j(plant.outputs()) - before_j).abs() / plant.outputs().energy().kinetic;
    println!("RB-05 drift {drift:.1e}");
    assert!(drift < 1e-6 && plant.outputs().root().force_n.norm() < 1e-9, "drift {drift:.1e}");
}

/// RB-06. Unsupported keys of a rigid body are rejected with location, value and remedy.
#[test]
fn rb06_refusals() {
    let text = include_str!("rigid_bodies.toml");
    for (from, to, expected) in [
        ("parent_frame = \"left_root\"", "parent_frame = \"left\"", "a frame of \"fuselage\": \"left_root\""),
        (
            "parent_frame = \"left_root\"\n",
            "parent_position_m = 0.1\n",
            "a length from 0 to 0 m, the length of the body",
        ),
        ("root_position_m = [0.0, 0.0, 0.0]", "parent_offset_m = [1.0, 0.0, 0.0]", "no offset from the root"),
        ("mass_kg = 0.3", "mass_kg = -0.3", "a finite mass >= 0 kg"),
        ("[2.4e-3, 3e-4, 2.55e-3,", "[2.4e-3, 3e-4, 5.55e-3,", "m.toml:25: key 'rigid_body.fuselage.inertia_kg_m2'"),
        (
            "mass_kg = 0.05\n\n[joint.flight]",
            "\n[rigid_body.ghost]\n[joint.haunt]\ntype = \"ball\"\nparent = \"left\"\nchild = \"ghost\"\n[joint.flight]",
            "key 'rigid_body.ghost': a rigid body without mass is not allowed; allowed: a mass on it or on a body that it carries",
        ),
    ] {
        assert!(text.contains(from), "{from}");
        let error = config::parse(&text.replacen(from, to, 1), "m.toml").expect_err("refused").to_string();
        assert!(error.contains(expected), "{from} -> {to}: {error}");
    }
    let gauge = Machine::builder("m")
        .body(Body::rigid("stone").inertia(1.0, [0.0; 3], Matrix3::zeros()), Joint::free("flight"))
        .gauge(Gauge::on("g", "stone", 0.0))
        .build();
    assert!(gauge.expect_err("refused").to_string().contains("a flexible body"));
}

/// RB-07. The aircraft of the examples, whose fuselage is a rigid body, moves through a gust like the one whose fuselage was a point mass
/// on a wing root; with the wings' roots offset from its origin and rotated, its energy balance closes.
#[test]
fn rb07_an_aircraft_with_a_rigid_fuselage() {
    let old = include_str!("aircraft_without_fuselage.toml");
    let new = include_str!("../../../examples/flying_aircraft.toml");
    let fly = |text: &str| {
        let mut plant = Plant::new(Arc::new(config::parse(text, "aircraft.toml").expect("a sound model")));
        plant.initialize(0.0).expect("accelerations");
        let before_j = balance_j(plant.outputs());
        plant.inputs_mut().stations_mut()[0].force_n = Vector3::new(0.1, -0.3, 2.0);
        coast(&mut plant, 0.06);
        let outputs = plant.outputs();
        let drift = (balance_j(outputs) - before_j).abs() / outputs.energy().kinetic;
        let ends = outputs.tips().iter().map(|tip| tip.position_m).collect::<Vec<_>>();
        (ends, outputs.joints()[0].angle_rad, drift)
    };
    let (before, now) = (fly(old), fly(new));
    let apart_m = before.0.iter().zip(&now.0).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    println!("RB-07 tips {apart_m:.1e} m, fold {:.1e} rad apart", (before.1 - now.1).abs());
    assert!(before.0.len() == 2 && now.0.len() == 2 && apart_m < 1e-9 && (before.1 - now.1).abs() < 1e-8);
    let aside = new
        .replace(
            "child = \"right_inner\"",
            "parent_offset_m = [0.03, 0.01, 0.02]\nmount_rotation_deg = [5.0, 3.0, -7.0]\nchild = \"right_inner\"",
        )
        .replace("child = \"left_inner\"", "parent_offset_m = [-0.03, 0.01, 0.02]\nchild = \"left_inner\"");
    let aside = fly(&aside);
    println!("RB-07 aside: drift {:.1e}", aside.2);
    assert!(aside.2 < 1e-7 && (aside.0[0] - now.0[0]).norm() > 1e-3, "drift {:.1e}", aside.2);
}

/// RB-08. If the accelerations of a machine with rigid bodies are not defined, the message names the joint: a point mass on the axis of its
/// hinge has no inertia about that axis.
#[test]
fn rb08_failures_are_placed_among_rigid_bodies() {
    let stone = |name: &str, at_m: f64| Body::rigid(name).inertia(1.0, [at_m, 0.0, 0.0], Matrix3::zeros());
    let inner = (stone("arm", 1.0), Joint::revolute("shoulder", [0.0, 1.0, 0.0]));
    let outer = (stone("hand", 0.0), Joint::revolute("wrist", [0.0, 1.0, 0.0]).on("arm"));
    let mut plant = Plant::new(Arc::new(machine([inner, outer])));
    let error = plant.initialize(0.0).expect_err("no inertia about the wrist").to_string();
    assert!(error.contains("joint wrist"), "{error}");
}

/// RB-11. A modal body, whose mass lies on its axis, has no inertia about that axis except round-off, of either sign: the error names the
/// joint that permits this rotation, not a body further inboard whose factors the round-off affects. The remedy is a mass off the axis.
#[test]
fn rb11_a_body_without_inertia_about_its_axis_is_named() {
    let text = |joint: &str, mount: &str, more: &str| {
        format!(
            "name = 'm'\ngravity_m_s2 = [-2.8, 8.3, 3.1]\n[section.s]\nshape = 'ellipse'\nwidth_m = 0.045\nheight_m = 0.0059\n\
             density_kg_m3 = 2300.0\nyoungs_modulus_Pa = 5.2e9\npoisson_ratio = 0.3\n\
             [body.arm]\nlength_m = 0.57\nsection = 's'\nelements = 1\nelement = 'linear'\n\
             [joint.mount]\ntype = 'clamped'\nparent = 'root'\nchild = 'arm'\n\
             [modal_body.blade]\nlength_m = 0.54\nnodes = 5\nstations = [0.0, 1.0]\nmass_kg_m = [0.27, 0.17]\n\
             flap_stiffness_N_m2 = [5.5, 2.75]\nedge_stiffness_N_m2 = [80.0, 80.0]\nflap_shapes = [[1.5, -0.5]]\n\
             flap_damping_ratios = [0.03]\nflap_start_m = [0.0018]\nedge_shapes = [[1.5, -0.5]]\nedge_damping_ratios = [0.03]\n\
             edge_start_m = [-0.0035]\n[joint.bearing]\n{joint}\nparent = 'arm'\nchild = 'blade'\n\
             mount_rotation_deg = {mount}\n{more}[simulation]\nstop_time_s = 0.01\n"
        )
    };
    let started = |text: &str| {
        let machine = config::parse(text, "modal.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).map_err(|error| error.to_string())
    };
    let along = "type = 'revolute'\naxis = [1.0, 0.0, 0.0]";
    // about the blade's axis and one normal to it: the second axis in the first line, the first axis in the second
    let universals = [
        "type = 'universal'\naxis = [0.0, 1.0, 0.0]\nbody_axis = [1.0, 0.0, 0.0]",
        "type = 'universal'\naxis = [1.0, 0.0, 0.0]\nbody_axis = [0.0, 1.0, 0.0]",
    ];
    for (joint, mount) in [
        ("type = 'ball'", "[0.0, 0.0, 0.0]"),
        // attitudes at which the round-off acted as an inertia, so that the error named the arm
        ("type = 'ball'", "[18.0, 35.0, -49.0]"),
        ("type = 'ball'", "[31.0, -60.0, -7.0]"),
        (along, "[0.0, 0.0, 0.0]"),
        (universals[0], "[0.0, 0.0, 0.0]"),
        (universals[0], "[18.0, 35.0, -49.0]"),
        (universals[1], "[0.0, 0.0, 0.0]"),
        ("type = 'free'", "[0.0, 0.0, 0.0]"),
        ("type = 'free'", "[31.0, -60.0, -7.0]"),
    ] {
        let bare = text(joint, mount, "");
        // a free-flying body has no body further inboard
        let (bare, carrier) = match joint {
            "type = 'free'" => (bare.replace("parent = 'arm'", "parent = 'root'"), "root"),
            _ => (bare, "arm"),
        };
        let error = started(&bare).expect_err("no inertia about the blade's axis");
        assert!(
            error.contains(
                "at joint bearing: the carried bodies have no inertia along or about one of this joint's axes"
            ),
            "{joint} {mount}: {error}"
        );
        let mass = "[mass.nut]\nbody = 'blade'\nposition_m = 0.54\nmass_kg = 0.02\noffset_m = [0.0, 0.02, 0.03]\n";
        let remedied = text(joint, mount, mass).replace("parent = 'arm'", &format!("parent = '{carrier}'"));
        started(&remedied).unwrap_or_else(|error| panic!("{joint} {mount}: {error}"));
    }
    // a prismatic joint permits no rotation: the blade's mass is its inertia along any axis
    let slide = "type = 'prismatic'\naxis = [1.0, 0.0, 0.0]";
    started(&text(slide, "[0.0, 0.0, 0.0]", "")).unwrap_or_else(|error| panic!("{error}"));
}
