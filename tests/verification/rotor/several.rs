//! Several aerodynamic models in one machine: RT-21 and following.

use crate::counting_allocator::allocations;
use foldwing::machine::Machine;
use foldwing::plant::{Holding, Outputs, Plant};
use nalgebra::Vector3;
use std::fmt::Write;
use std::sync::Arc;

pub const PROPELLERS: &str = include_str!("../../../examples/airs/wing_with_propellers.toml");
pub const TWIN: &str = include_str!("../../../examples/airs/twin_rotor.toml");

/// The machine of a model file.
pub fn machine(text: &str) -> Machine {
    foldwing::config::parse(text, "airs.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// The machine of a model file at its start.
pub fn started(text: &str) -> Plant {
    let mut plant = Plant::new(Arc::new(machine(text)));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    plant
}

/// Outputs at the start and at the ends of steps.
pub fn run(text: &str, step_s: f64, steps: usize) -> Vec<Outputs> {
    let mut plant = started(text);
    let mut list = vec![plant.outputs().clone()];
    for step in 1..=steps {
        plant.step(step_s * step as f64).unwrap_or_else(|error| panic!("{error}"));
        list.push(plant.outputs().clone());
    }
    list
}

/// Turbines on the root, at places along y in m: flexible blades, a shaft with a generator. The aerodynamics is that of `air`.
pub fn turbines(places: &[(&str, f64)], air: &str) -> String {
    let mut text = "name = \"Turbines\"\n[section.blade]\nshape = \"rectangle\"\nwidth_m = 0.25\nheight_m = 0.05\n\
        youngs_modulus_Pa = 3e10\nshear_modulus_Pa = 4e9\ndensity_kg_m3 = 900.0\n\
        [solver]\nmethod = \"esdirk4\"\nfixed_step_s = 0.0025\ntolerance = 1e-12\n"
        .to_owned();
    let polar = TWIN.split_once("[polar.symmetric]").and_then(|(_, rest)| rest.split_once("[wind]")).unwrap().0;
    for (name, y_m) in places {
        write!(
            text,
            "[rigid_body.{name}_hub]\nmass_kg = 120.0\ninertia_kg_m2 = [12.0, 12.0, 12.0, 0.0, 0.0, 0.0]\n\
             [joint.{name}_shaft]\ntype = \"revolute\"\nparent = \"root\"\nroot_position_m = [0.0, {y_m:?}, 0.0]\n\
             child = \"{name}_hub\"\naxis = [1.0, 0.0, 0.0]\nstart_rate_deg_s = 440.0\n\
             [joint.{name}_shaft.motor]\ndamping_N_m_s_rad = 190.0\n\
             [body.{name}_blade]\nsection = \"blade\"\nlength_m = 5.4\nelements = 1\ncount = 3\n\
             [joint.{name}_root]\ntype = \"clamped\"\nparent = \"{name}_hub\"\nchild = \"{name}_blade\"\n\
             parent_offset_m = [0.0, 0.0, 0.6]\nmount_rotation_deg = [127.27922061357856, 0.0, 127.27922061357856]\n\
             [surface.{name}_blade]\nbody = \"{name}_blade\"\nelastic_axis_fraction = 0.25\n\
             stations_m = [0.0, 1.6, 3.2, 4.6, 5.4]\npolars = [\"symmetric\", \"symmetric\", \"symmetric\", \"symmetric\", \"symmetric\"]\n\
             chord_m = {{ table = [[0.0, 0.55], [5.4, 0.15]] }}\nincidence_deg = {{ table = [[0.0, -44.0], [1.6, -12.0], [5.4, -2.5]] }}\n"
        )
        .unwrap();
    }
    text + "[polar.symmetric]" + polar + air
}

pub const COMMON: &str =
    "wind_m_s = [8.0, 1.0, 0.5]\nstep_s = 0.01\ncoupling_tolerance = 1e-11\ncoupling_iterations = 200\n";

/// A part for a rotor.
pub fn rotor_part(name: &str, more: &str) -> String {
    format!("[aerodynamics.{name}]\nmodel = \"bem\"\nhub = \"{name}_hub\"\nhub_radius_m = 0.6\n{more}")
}

const LAGS: &str = "skewed_wake = true\ndynamic_inflow = true\ndynamic_stall = true\n";

/// RT-21. Two rotors far apart on a rigid tower are one rotor each: loads, coefficients, shaft and blades over 1 s, with flexible blades,
/// skewed wake, dynamic inflow and dynamic stall. The bound is the tolerance of the iterations.
#[test]
fn rt21_two_distant_rotors_are_one_rotor_each() {
    let single = format!("[aerodynamics]\nmodel = \"bem\"\nhub = \"one_hub\"\nhub_radius_m = 0.6\n{LAGS}{COMMON}");
    let both = format!("[aerodynamics]\n{COMMON}{}{}", rotor_part("one", LAGS), rotor_part("two", LAGS));
    let (single, both) = (turbines(&[("one", 0.0)], &single), turbines(&[("one", -200.0), ("two", 200.0)], &both));
    let bodies = |text: &str| machine(text).bodies.iter().map(|body| body.name.clone()).collect::<Vec<_>>();
    let (of_alone, of_both) = (bodies(&single), bodies(&both));
    // hub and blades of a rotor in both machines
    let pairs_of_bodies = |rotor: usize| {
        let place = |name: &String| {
            let name = name.replacen("one", ["one", "two"][rotor], 1);
            of_both.iter().position(|other| *other == name).unwrap()
        };
        of_alone.iter().map(place).enumerate().collect::<Vec<_>>()
    };
    let (alone, twins) = (run(&single, 0.02, 50), run(&both, 0.02, 50));
    let (mut largest, mut reaction) = (0.0f64, 0.0f64);
    for (alone, twins) in alone.iter().zip(&twins) {
        assert_eq!((alone.rotor().len(), twins.rotor().len()), (1, 2));
        for rotor in 0..2 {
            let (one, own) = (alone.rotor()[0], twins.rotor()[rotor]);
            let joint = [alone.joints()[0], twins.joints()[rotor]];
            let pairs = [
                [one.thrust_n, own.thrust_n],
                [one.torque_n_m, own.torque_n_m],
                [one.power_w, own.power_w],
                [one.wind_m_s, own.wind_m_s],
                [one.thrust_coefficient, own.thrust_coefficient],
                joint.map(|joint| joint.angle_rad),
                joint.map(|joint| joint.rate_rad_s),
            ];
            for [a, b] in pairs {
                largest = largest.max((a - b).abs() / a.abs().max(1e-3));
            }
            for (alone_at, twin_at) in pairs_of_bodies(rotor) {
                let [a, b] = [alone.joint_reactions()[alone_at], twins.joint_reactions()[twin_at]];
                let size = a.force_n.norm().max(1.0);
                reaction = reaction.max((a.force_n - b.force_n).norm() / size);
            }
        }
    }
    let last = alone[alone.len() - 1].rotor()[0];
    println!(
        "RT-21: {largest:.1e}, reactions {reaction:.1e}; thrust {:.1} N, torque {:.1} N·m",
        last.thrust_n, last.torque_n_m
    );
    assert!(last.thrust_n > 500.0 && last.torque_n_m > 100.0, "{last:?}");
    // reactions contain the accelerations of stiff blades, which the iterations leave with a larger error
    assert!(largest < 1e-10 && reaction < 1e-9, "{largest:e} {reaction:e}");
}

/// RT-22. A single model in a table `[aerodynamics.<name>]` is the same to the bit as in `[aerodynamics]`, for a rotor and for strips.
#[test]
fn rt22_one_named_part_is_the_old_form() {
    let old = turbines(
        &[("one", 0.0)],
        &format!("[aerodynamics]\nmodel = \"bem\"\nhub = \"one_hub\"\nhub_radius_m = 0.6\n{LAGS}{COMMON}"),
    );
    let new = turbines(&[("one", 0.0)], &format!("[aerodynamics]\n{COMMON}{}", rotor_part("one", LAGS)));
    assert_eq!(run(&old, 0.02, 10), run(&new, 0.02, 10));
    let goland = include_str!("../../../examples/models/goland_wing.toml");
    let named = goland.replace("model = \"strip\"\n", "") + "\n[aerodynamics.wing]\nmodel = \"strip\"\n";
    assert_ne!(goland, named);
    let bits = |text: &str| run(text, 0.01, 10);
    assert_eq!(bits(goland), bits(&named));
    // such a machine keeps its linear model
    let modes =
        |text: &str| started(text).study().modes(3).unwrap().iter().map(|mode| mode.eigenvalue_1_s).collect::<Vec<_>>();
    assert_eq!(modes(goland), modes(&named));
}

/// The wing without its propellers, in the old form.
fn bare_wing(text: &str) -> String {
    let table: toml::Table = text.parse().unwrap();
    let mut kept = table.clone();
    for (group, entry) in table {
        let toml::Value::Table(entries) = entry else { continue };
        for name in entries
            .keys()
            .filter(|name| ["hub", "blade", "shaft", "root1", "root2"].iter().any(|part| name.contains(part)))
        {
            kept[&group].as_table_mut().unwrap().remove(name);
        }
    }
    let air = kept["aerodynamics"].as_table_mut().unwrap();
    for name in ["wing", "left", "right"] {
        air.remove(name);
    }
    air.insert("model".to_owned(), "strip".into());
    kept.remove("polar");
    kept.retain(|_, entry| !entry.as_table().is_some_and(toml::Table::is_empty));
    toml::to_string(&kept).unwrap()
}

/// RT-23. The wing with two propellers is symmetric about its plane: strains, tips, loads, hinge moments, thrusts and speeds of the two
/// sides agree over 0.2 s; thrust is forward, and the motors drive.
#[test]
fn rt23_wing_with_two_propellers_is_symmetric() {
    let flaps = |side: &str| {
        format!(
            "[control_surface.{side}]\nbody = \"{side}_wing\"\nfrom_m = 2.5\nto_m = 4.0\nhinge_fraction = 0.75\ncommand_deg = 4.0\n"
        )
    };
    let text = PROPELLERS.replace("step_s = 0.001\n", "step_s = 0.001\ncoupling_tolerance = 1e-10\n")
        + &flaps("right")
        + &flaps("left")
        + "[solver]\nmethod = \"esdirk4\"\nfixed_step_s = 0.0005\ntolerance = 1e-12\n";
    let machine = machine(&text);
    let body = |name: &str| machine.bodies.iter().position(|body| body.name == name).unwrap();
    let outputs = run(&text, 0.005, 40);
    let mut largest = 0.0f64;
    let mut compare = |a: f64, b: f64, size: f64| largest = largest.max((a - b).abs() / size);
    let mirrored = |v: &Vector3<f64>| Vector3::new(v.x, -v.y, v.z);
    for outputs in &outputs {
        let [right, left] = [outputs.rotor()[0], outputs.rotor()[1]];
        compare(right.thrust_n, left.thrust_n, right.thrust_n.abs());
        compare(right.torque_n_m, left.torque_n_m, right.torque_n_m.abs());
        // the shafts turn in opposite directions, each speed is positive in the direction of its rotor
        compare(right.speed_rad_s, left.speed_rad_s, right.speed_rad_s.abs());
        compare(outputs.joints()[0].rate_rad_s, -outputs.joints()[1].rate_rad_s, right.speed_rad_s.abs());
        let [right, left] = ["right_wing", "left_wing"].map(|name| outputs.joint_reactions()[body(name)]);
        let size = right.force_n.norm();
        mirrored(&right.force_n).iter().zip(&left.force_n).for_each(|(a, b)| compare(*a, *b, size));
        let [right, left] = [outputs.flaps()[0], outputs.flaps()[1]];
        assert!(right.hinge_moment_n_m.abs() > 0.01, "{right:?}");
        compare(right.hinge_moment_n_m, left.hinge_moment_n_m, right.hinge_moment_n_m.abs());
    }
    let last = &outputs[outputs.len() - 1];
    let rotor = last.rotor()[0];
    println!(
        "RT-23: {largest:.1e}; thrust {:.1} N, torque {:.1} N·m, {:.1} rad/s",
        rotor.thrust_n, rotor.torque_n_m, rotor.speed_rad_s
    );
    // thrust is positive downwind, torque positive where it drives the rotor
    assert!(rotor.thrust_n < -50.0 && rotor.torque_n_m < -5.0, "{rotor:?}");
    assert!(largest < 1e-9, "{largest:e}");
}

/// RT-24. No model reaches another: at the start, the strips of the wing carry the same loads to the bit as without the propellers, and its
/// control surfaces have the same hinge moments; a propeller has the thrust that it has without the other. Total force and moment are the
/// sums of all.
#[test]
fn rt24_no_model_reaches_another() {
    let flap = "[control_surface.aileron]\nbody = \"left_wing\"\nfrom_m = 2.5\nto_m = 4.0\nhinge_fraction = 0.75\ncommand_deg = 4.0\n";
    let text = PROPELLERS.replace("[aerodynamics]\n", "[aerodynamics]\nreport_circulation = true\n") + flap;
    let (whole, bare) = (started(&text), started(&bare_wing(&text)));
    let of = |plant: &Plant, name: &str| {
        let air = plant.machine().air.as_ref().unwrap();
        let surface = air.surfaces.iter().position(|own| plant.machine().bodies[own.body].name == name).unwrap();
        plant.surface_forces_n()[surface].clone()
    };
    for name in ["right_wing", "left_wing"] {
        assert!(of(&bare, name).iter().all(|force_n| force_n.z > 1.0), "{name}");
        assert_eq!(of(&whole, name), of(&bare, name), "{name}");
    }
    let circulations = |plant: &Plant| {
        let air = plant.machine().air.as_ref().unwrap();
        let mut values = plant.outputs().circulation_m2_s().iter();
        let mut of_wings = Vec::new();
        for surface in &air.surfaces {
            let own: Vec<f64> = values.by_ref().take(surface.positions_m.len() - 1).copied().collect();
            if plant.machine().bodies[surface.body].name.ends_with("wing") {
                of_wings.extend(own);
            }
        }
        of_wings
    };
    assert_eq!(circulations(&whole), circulations(&bare));
    assert!(circulations(&bare).len() == 16 && circulations(&bare).iter().all(|value| value.abs() > 0.1));
    assert_eq!(whole.outputs().flaps()[0], bare.outputs().flaps()[0]);
    assert!(whole.outputs().flaps()[0].hinge_moment_n_m.abs() > 0.01);
    let one = text.replace("[aerodynamics.left]\nmodel = \"bem\"\nhub = \"left_hub\"\nhub_radius_m = 0.12\nrotation_direction = \"counter_clockwise\"\n", "");
    assert_ne!(one, text);
    let lonely = foldwing::config::parse(&one, "airs.toml").expect_err("blades without a rotor").to_string();
    assert!(lonely.contains("stations_m and polars only on bodies that the hub of a rotor carries"), "{lonely}");
    // the total is the sum of sections and hubs
    let sum: Vector3<f64> = whole.surface_forces_n().iter().flatten().sum();
    let total = whole.outputs().air_total().force_n;
    let thrusts: f64 = whole.outputs().rotor().iter().map(|rotor| rotor.thrust_n).sum();
    let drag: f64 =
        ["right_wing", "left_wing"].map(|name| of(&whole, name)).iter().flatten().map(|force_n| force_n.x).sum();
    println!("RT-24: total {total:.3?} N, thrusts {thrusts:.3} N, drag of the wing {drag:.3} N");
    approx::assert_relative_eq!(sum, total, max_relative = 1e-12);
    approx::assert_relative_eq!(thrusts + drag, total.x, max_relative = 1e-9);
}

/// RT-25. Steps with two rotors and strips allocate nothing.
#[test]
fn rt25_steps_do_not_allocate() {
    let mut plant = started(PROPELLERS);
    plant.step(0.02).unwrap();
    let before = allocations();
    assert!(before > 0, "the counter counts");
    plant.step(0.05).unwrap();
    assert_eq!(allocations(), before);
}

/// RT-26. A static equilibrium of the wing with stopped propellers: the accelerations at the start from it vanish; it is stable, with the
/// loads of all three models.
#[test]
fn rt26_equilibrium_with_stopped_propellers() {
    let mut text = String::new();
    for line in PROPELLERS.lines() {
        match line {
            line if line.starts_with("start_rate_deg_s") => text += "motion = \"locked\"\n",
            line if line.starts_with("[joint.") && line.ends_with(".motor]") => text += "",
            line if line.starts_with("constant_torque") || line.starts_with("damping_N_m_s") => {}
            line => writeln!(text, "{line}").unwrap(),
        }
    }
    let mut plant = Plant::new(Arc::new(machine(&text)));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    let fastest = plant.outputs().tips().iter().map(|tip| tip.acceleration_m_s2.norm()).fold(0.0, f64::max);
    let up_m = plant.outputs().tips()[0].position_m.z;
    let stability = plant.study().stability().unwrap();
    println!("RT-26: tip up by {up_m:.4} m, acceleration {fastest:.1e} m/s2; {stability:?}");
    assert!(up_m.abs() > 1e-3 && fastest < 1e-6, "{up_m} {fastest:e}");
    assert!(stability.is_stable() && !stability.potential, "{stability:?}");
}

/// RT-27. What has no form for several models is refused with the names of the models: periodic motions, flutter with rotors.
#[test]
fn rt27_studies_of_several_models_are_refused_by_name() {
    let plant = started(TWIN);
    let turn =
        foldwing::plant::Turn::of(plant.machine(), Some("port_shaft"), Some(8.0), 64).expect_err("no turn").to_string();
    assert!(turn.contains("port, starboard"), "{turn}");
    // an error of a model names the body, not the surface of the same number in another model
    let (before, rest) = PROPELLERS.split_once("[surface.right_wing]").unwrap();
    let rest = rest.split_once("\n# Hub").unwrap().1;
    let fast =
        format!("{before}# Hub{rest}").replace("model = \"strip\"", "model = \"strip\"\nspeed_of_sound_m_s = 20.0");
    let sonic = Plant::new(Arc::new(machine(&fast))).initialize(0.0).expect_err("Mach 1.25").to_string();
    assert!(sonic.contains("of body left_wing has a relative flow of Mach"), "{sonic}");
}

/// RT-28. Faulty parts are rejected with key and line.
#[test]
fn rt28_faulty_parts_are_refused_by_key() {
    let part = "[aerodynamics.other]\nmodel = \"strip\"\n";
    let still = TWIN.replace("[wind]\nreference_height_m = 20.0\nshear_exponent = 0.14\n", "");
    let cases: Vec<(String, &[&str])> = vec![
        (
            TWIN.replace("[aerodynamics]\n", "[aerodynamics]\nmodel = \"strip\"\n"),
            &["aerodynamics.model", "switch them off"],
        ),
        (
            TWIN.replace("[aerodynamics]\n", "[aerodynamics]\nhub = \"port_hub\"\n"),
            &["aerodynamics.hub", "[aerodynamics.<name>]"],
        ),
        (TWIN.replace("[aerodynamics]\n", "[aerodynamics]\nthreads = 2\n"), &["aerodynamics.threads"]),
        (TWIN.replace("[aerodynamics]\n", "[aerodynamics]\ndensty_kg_m3 = 1.0\n"), &["densty_kg_m3", "density_kg_m3"]),
        (TWIN.replace("hub = \"port_hub\"", "hub = \"port_hup\""), &["aerodynamics.port.hub", "port_hub"]),
        (TWIN.replace("hub = \"port_hub\"\n", ""), &["aerodynamics.port.hub"]),
        (TWIN.replace("hub = \"starboard_hub\"", "hub = \"port_hub\""), &["aerodynamics.", "different shafts"]),
        (
            TWIN.replace("dynamic_inflow = true\n\n[aerodynamics.st", "quasi_steady = true\n\n[aerodynamics.st"),
            &["aerodynamics.port.quasi_steady"],
        ),
        (
            TWIN.replacen("dynamic_inflow = true", "inflow_lag_s = 0.001", 1),
            &["aerodynamics.port.inflow_lag_s", "0.01"],
        ),
        (TWIN.replacen("dynamic_inflow = true", "blades = 4", 1), &["aerodynamics.port.blades", "multiple of 3"]),
        (TWIN.replacen("dynamic_inflow = true", "shaft_axis = [0, 0, 0]", 1), &["aerodynamics.port.shaft_axis"]),
        (TWIN.replacen("dynamic_inflow = true", "step_s = 0.01", 1), &["aerodynamics.port.step_s"]),
        (TWIN.replacen("model = \"bem\"", "model = \"uvlm\"", 1), &["aerodynamics.port.model", "\"strip\"", "\"bem\""]),
        (still + part, &["aerodynamics.other", "a part without a surface"]),
        (PROPELLERS.to_owned() + part, &["aerodynamics.other.model", "one part with strips"]),
        (PROPELLERS.to_owned() + "[wind]\nreference_height_m = 10.0\nshear_exponent = 0.1\n", &["wind", "strips"]),
        (
            PROPELLERS.replace("[aerodynamics.wing]\nmodel = \"strip\"\n", ""),
            &["surface.", "a surface that belongs to no part"],
        ),
        (
            PROPELLERS.to_owned()
                + "[control_surface.c]\nbody = \"right_blade1\"\nfrom_m = 0.1\nto_m = 0.2\nhinge_fraction = 0.7\n",
            &["control_surface.c"],
        ),
        (PROPELLERS.replacen("strips = 8", "strips = 8\nchord_panels = 2", 1), &["surface.right_wing.chord_panels"]),
        (PROPELLERS.replacen("length_m = 0.48", "length_m = 0.48\nstrips = 3", 1), &["surface.right_blade1.strips"]),
    ];
    for (text, words) in cases {
        assert!(text != TWIN && text != PROPELLERS, "{words:?}");
        let told = foldwing::config::parse(&text, "airs.toml").expect_err(words[0]).to_string();
        for word in words {
            assert!(told.contains(word), "{word:?} is missing in {told}");
        }
        assert!(told.contains("airs.toml:"), "{told}");
    }
    // a machine whose parts were changed directly
    for surfaces in [vec![], vec![1, 0], vec![0, 1, 3]] {
        let mut changed = machine(TWIN);
        changed.air.as_mut().unwrap().parts[0].surfaces = surfaces;
        let faults = changed.validate();
        assert!(faults.iter().any(|fault| fault.allowed.contains("every surface in one part")), "{faults:?}");
    }
    // switched off: no aerodynamics, nothing else
    let off = machine(&PROPELLERS.replace("[aerodynamics]\n", "[aerodynamics]\nmodel = \"none\"\n"));
    assert!(off.air.is_none());
}

/// RT-29. Both examples run as they are: the turbine's rotors turn in opposite directions at the same speed on a tower that bends downwind.
#[test]
fn rt29_examples_run() {
    let outputs = run(TWIN, 0.02, 100);
    let last = &outputs[outputs.len() - 1];
    let [port, starboard] = [last.rotor()[0], last.rotor()[1]];
    println!("RT-29: {port:?} {starboard:?}");
    assert!(port.power_w > 5e3 && port.power_coefficient < 16.0 / 27.0, "{port:?}");
    approx::assert_relative_eq!(port.thrust_n, starboard.thrust_n, max_relative = 1e-4);
    approx::assert_relative_eq!(port.speed_rad_s, starboard.speed_rad_s, max_relative = 1e-4);
}

/// RT-33. An error of one model names the body of its own surface: strips of a wing, whose surface follows those of three blades, reach the
/// speed of sound.
#[test]
fn rt33_errors_name_the_body_of_the_models_own_surface() {
    let air = format!("[aerodynamics]\n{COMMON}{}[aerodynamics.wing]\nmodel = \"strip\"\n", rotor_part("one", ""));
    let clamp = |parent: &str, child: &str| {
        format!("[joint.{child}]\ntype = \"clamped\"\nparent = \"{parent}\"\nchild = \"{child}\"\n")
    };
    let block = "mass_kg = 1.0\ninertia_kg_m2 = [0.1, 0.1, 0.1, 0.0, 0.0, 0.0]\n";
    // at the end of a chain, so that the blades come first
    let wing = format!(
        "speed_of_sound_m_s = 7.0\n[rigid_body.tower]\n{block}{}[rigid_body.pylon]\n{block}{}\
         [body.wing]\nsection = \"blade\"\nlength_m = 2.0\nelements = 1\n{}mount_rotation_deg = [0.0, 0.0, 90.0]\n\
         [surface.wing]\nbody = \"wing\"\nleading_edge = \"+y\"\nchord_m = 0.4\nstrips = 3\n",
        clamp("root", "tower"),
        clamp("tower", "pylon"),
        clamp("pylon", "wing")
    );
    let built = machine(&(turbines(&[("one", 0.0)], &air) + &wing));
    let surfaces = &built.air.as_ref().expect("aerodynamics").surfaces;
    assert_eq!(built.bodies[surfaces[3].body].name, "wing");
    let error = Plant::new(Arc::new(built)).initialize(0.0).map(|_| ()).expect_err("a wing at Mach 1").to_string();
    println!("RT-33: {error}");
    assert!(error.contains("strip 1 of body wing has a relative flow of Mach 1.1"), "{error}");
}
