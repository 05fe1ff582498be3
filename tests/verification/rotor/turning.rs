//! A rotor in a machine: stiff blades on a shaft at constant speed, with `model = "bem"`.

use super::{nrel_5mw, number, reference, table};
use crate::counting_allocator::allocations;
use foldwing::aero::RotorLoads;
use foldwing::aero::rotor::induction::EndRule;
use foldwing::machine::Machine;
use foldwing::plant::Plant;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::sync::Arc;

/// A model file of the NREL 5 MW rotor with beams `stiffness` times as stiff as a steel tube of 2 m for blades. The shaft runs at a given
/// speed; the blades are clamped to the hub, and the pitch is part of their incidence.
fn model(wind: &str, speed_rad_s: f64, pitch_deg: f64, air: &str, tables: &str) -> String {
    let blade = table(&reference("nrel5mw_blade.csv"));
    let stations: Vec<f64> = blade.iter().map(|row| number(row, "span_m")).collect();
    let along = |column: &str, sign: f64, shift: f64| {
        let rows = blade.iter().map(|row| format!("[{}, {}]", row["span_m"], sign * (number(row, column) + shift)));
        rows.collect::<Vec<_>>().join(", ")
    };
    let polars: Vec<&str> = blade.iter().map(|row| row["section"].as_str()).collect();
    let mut text = format!(
        "name = \"Rotor\"\n\
         [section.tube]\nshape = \"rectangle\"\nwidth_m = 2.0\nheight_m = 2.0\nyoungs_modulus_Pa = 2e15\nshear_modulus_Pa = 1e15\ndensity_kg_m3 = 1.0\n\
         [rigid_body.hub]\nmass_kg = 1000.0\ninertia_kg_m2 = [1e6, 1e6, 1e6, 0, 0, 0]\n\
         [joint.shaft]\ntype = \"revolute\"\nparent = \"root\"\nchild = \"hub\"\naxis = [1, 0, 0]\n\
         motion = \"prescribed\"\npolynomial_deg = [0.0, {:?}]\n\
         [aerodynamics]\nmodel = \"bem\"\nhub = \"hub\"\nhub_radius_m = 1.5\nwind_m_s = {wind}\n{air}\n",
        speed_rad_s.to_degrees()
    );
    for k in 0..3 {
        let angle = TAU * f64::from(k) / 3.0;
        // the body's x along the blade, its y towards the leading edge (direction of rotation), its z downwind
        let (sine, cosine) = angle.sin_cos();
        let along_blade = Vector3::new(0.0, -sine, cosine);
        let axes = Matrix3::from_columns(&[along_blade, Vector3::x().cross(&along_blade), Vector3::x()]);
        // by a quaternion: blade 0 is rotated by 180 degrees, where a matrix does not determine the sign of its axis
        let turned = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
        let mount = turned.scaled_axis() * (180.0 / PI);
        let apex = along_blade * 1.5;
        write!(
            text,
            "[body.blade{k}]\nlength_m = 61.4999\nelements = 1\nsection = \"tube\"\n\
             [joint.root{k}]\ntype = \"clamped\"\nparent = \"hub\"\nchild = \"blade{k}\"\n\
             parent_offset_m = {:?}\nmount_rotation_deg = {:?}\n\
             [surface.blade{k}]\nbody = \"blade{k}\"\nelastic_axis_fraction = 0.25\nstations_m = {stations:?}\n\
             polars = {polars:?}\nchord_m = {{ table = [{chord}] }}\nincidence_deg = {{ table = [{twist}] }}\n",
            apex.as_slice(),
            mount.as_slice(),
            chord = along("chord_m", 1.0, 0.0),
            twist = along("twist_deg", -1.0, pitch_deg),
        )
        .unwrap();
    }
    let mut used = polars.clone();
    used.sort_unstable();
    used.dedup();
    for name in used {
        writeln!(text, "[polar.{name}]\nfile = \"polars/{name}.csv\"").unwrap();
    }
    text + tables
}

fn machine(text: String) -> Machine {
    let folder = format!("{}/tests/reference/turbine", env!("CARGO_MANIFEST_DIR"));
    let text = foldwing::config::with_files(text, folder.as_ref(), "rotor.toml").unwrap();
    foldwing::config::parse(&text, "rotor.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Aerodynamic loads after rotating for a time.
fn turned(text: String, time_s: f64) -> RotorLoads {
    let mut plant = Plant::new(Arc::new(machine(text)));
    plant.initialize(0.0).unwrap();
    plant.step(time_s).unwrap();
    plant.outputs().rotor()[0]
}

/// RT-02: the operating points of RT-01 in a machine with rotating blades: coefficients of OpenFAST to 1e-5, with its end-loss formula.
/// Blades are 1e5 times as stiff as steel, the shaft rotates at constant speed, steps are 20 ms.
#[test]
fn turning_rotor_has_the_steady_coefficients() {
    let rows = table(&reference("openfast_aeromap_stiff.csv"));
    for row in rows.iter().filter(|row| ["7", "11", "19"].contains(&row["WindSpeed_m_per_s"].as_str())) {
        let wind = format!("[{}, 0, 0]", row["WindSpeed_m_per_s"]);
        let speed_rad_s = number(row, "RotorSpeed_RPM") * PI / 30.0;
        let pitch_deg = number(row, "Pitch_deg");
        let air = "end_loads = \"full_induction\"\nstep_s = 0.02\n";
        let got = turned(model(&wind, speed_rad_s, pitch_deg, air, ""), 0.5);
        let power = got.power_coefficient / number(row, "RtFldCp_nd") - 1.0;
        let thrust = got.thrust_coefficient / number(row, "RtFldCt_nd") - 1.0;
        println!("{wind}: Cp {power:+.2e}, Ct {thrust:+.2e}");
        assert!(power.abs() < 1e-5 && thrust.abs() < 1e-5, "{wind}: {power:e} {thrust:e}");
        assert!((got.tip_speed_ratio / number(row, "TSR_nd") - 1.0).abs() < 1e-5);
    }
}

/// Without that end-loss formula the blade ends carry no load, in the machine as in the steady rotor.
#[test]
fn ends_without_load_are_those_of_the_steady_rotor() {
    let (wind_m_s, speed_rad_s) = (8.0, 9.1311 * PI / 30.0);
    let expected = nrel_5mw(EndRule::ZeroLoad).at(wind_m_s, speed_rad_s, 0.0);
    let got = turned(model("[8, 0, 0]", speed_rad_s, 0.0, "step_s = 0.02\n", ""), 0.1);
    approx::assert_relative_eq!(got.thrust_n, expected.thrust_n, max_relative = 1e-5);
    approx::assert_relative_eq!(got.torque_n_m, expected.torque_n_m, max_relative = 1e-5);
    approx::assert_relative_eq!(got.power_w, expected.power_w, max_relative = 1e-5);
}

/// RT-16: the same rotor with dynamic stall, which in steady flow reduces to the static polar: thrust, torque and the bending moments at
/// the blades' roots from light load to stall, and at the pitch that holds rated power at 12 m/s. 1e-9: a steady-flow start begins in the
/// steady state, which the induction of the simulation keeps.
#[test]
fn dynamic_stall_leaves_the_steady_rotor() {
    for (wind, speed_rad_s, pitch_deg) in [
        ("[6, 0, 0]", 0.8, 0.0),
        ("[11, 0, 0]", 1.25, 0.0),
        ("[12, 0, 0]", 12.1 * PI / 30.0, 3.59),
        ("[16, 0, 0]", 1.0, -2.0),
    ] {
        let of = |air: &str| {
            let root = "[internal_load.root]\nbody = \"blade1\"\nposition_m = 0.0\n";
            let text = model(wind, speed_rad_s, pitch_deg, &format!("step_s = 0.02\n{air}"), root);
            let mut plant = Plant::new(Arc::new(machine(text)));
            plant.initialize(0.0).unwrap();
            plant.step(0.5).unwrap();
            (plant.outputs().rotor()[0], plant.outputs().internal_loads()[0].moment_n_m)
        };
        let ((plain, root), (dynamic, dynamic_root)) = (of(""), of("dynamic_stall = true\n"));
        let miss = [
            (dynamic.thrust_n / plain.thrust_n - 1.0).abs(),
            (dynamic.torque_n_m / plain.torque_n_m - 1.0).abs(),
            (dynamic_root - root).norm() / root.norm(),
        ];
        println!(
            "{wind}: thrust {:.1e}, torque {:.1e}, root moment {:.1e} of {:.3e} N·m",
            miss[0],
            miss[1],
            miss[2],
            root.norm()
        );
        assert!(miss.iter().all(|miss| *miss < 1e-9), "{wind}: {miss:?}");
        // the downwind bending moment of a blade is a third to a half of the thrust times two thirds of its length or more
        assert!(root.norm() > 0.2 * plain.thrust_n * 61.5, "{wind}: {root}");
    }
}

/// RT-20. The mean induction of a rotor: radius-weighted sum of the axial induced velocities of the annuli divided by that of their wind
/// speeds, from the independent steady rotor; nodes with complete end loss are excluded.
#[test]
fn mean_induction_is_that_of_the_annuli() {
    let (wind_m_s, speed_rad_s) = (8.0, 9.1311 * PI / 30.0);
    let rotor = nrel_5mw(EndRule::ZeroLoad);
    let nodes = rotor.at(wind_m_s, speed_rad_s, 0.0).nodes;
    let inner = 1..nodes.len() - 1;
    let weighted: f64 = inner.clone().map(|i| rotor.nodes[i].radius_m * nodes[i].axial_induction).sum();
    let weights: f64 = inner.clone().map(|i| rotor.nodes[i].radius_m).sum();
    let found = turned(model("[8, 0, 0]", speed_rad_s, 0.0, "step_s = 0.02\n", ""), 0.1);
    println!("mean induction {:.9}, of the annuli {:.9}", found.induction, weighted / weights);
    // 1e-7: deflections of stiff blades
    approx::assert_relative_eq!(found.induction, weighted / weights, max_relative = 1e-7);
    assert!((0.2..0.4).contains(&found.induction), "{found:?}");
    // a radius-weighted mean, not a mean of the induction factors: these fall towards the root
    let factors = inner.clone().map(|i| nodes[i].axial_induction).sum::<f64>() / inner.len() as f64;
    assert!((found.induction / factors - 1.0).abs() > 0.01, "{factors}");
    // settled dynamic inflow gives the same, apart from the blades' deflections, which it follows with a lag
    let lagged = turned(model("[8, 0, 0]", speed_rad_s, 0.0, "step_s = 0.02\ndynamic_inflow = true\n", ""), 0.1);
    println!("with dynamic inflow {:.9}", lagged.induction);
    approx::assert_relative_eq!(lagged.induction, found.induction, max_relative = 1e-7);
}

/// RT-05: the rotor continues from a snapshot bit-identically, with all its lag states.
#[test]
fn snapshots_hold_wake_and_stall() {
    let air =
        "step_s = 0.05\ndynamic_inflow = true\ndynamic_stall = true\nskewed_wake = true\nsteady_initial_flow = false\n";
    let text = model("[8, 3, 0]", 0.95, 0.0, air, "");
    let mut plant = Plant::new(Arc::new(machine(text.clone())));
    plant.initialize(0.0).unwrap();
    let start_n = plant.outputs().rotor()[0].thrust_n;
    plant.step(0.4).unwrap();
    let snapshot = plant.snapshot();
    plant.step(0.9).unwrap();
    let expected = plant.outputs().values().to_vec();
    let mut other = Plant::new(Arc::new(machine(text)));
    other.initialize(0.0).unwrap();
    other.restore(&snapshot).unwrap();
    other.step(0.9).unwrap();
    assert_eq!(other.outputs().values(), expected);
    // after an impulsive start the wake slows the wind more and more
    let end_n = plant.outputs().rotor()[0].thrust_n;
    assert!(end_n < start_n, "{start_n} {end_n}");
}

/// RT-06: states of a turbine away from its operating points: finite loads of the right sign.
#[test]
fn rotor_meets_any_wind() {
    let loads = |wind: &str, speed_rad_s: f64, pitch_deg: f64| {
        let air = "step_s = 0.05\nskewed_wake = true\ndynamic_stall = true\n";
        let got = turned(model(wind, speed_rad_s, pitch_deg, air, ""), 0.1);
        let numbers = [got.thrust_n, got.torque_n_m, got.power_w, got.power_coefficient, got.thrust_coefficient];
        assert!(numbers.iter().all(|number| number.is_finite()), "{wind} {speed_rad_s} {pitch_deg}: {got:?}");
        got
    };
    // no wind, no rotation
    let still = loads("[0, 0, 0]", 0.0, 0.0);
    assert_eq!((still.thrust_n, still.torque_n_m, still.power_coefficient), (0.0, 0.0, 0.0));
    // in still air it is a propeller that the air decelerates
    let fan = loads("[0, 0, 0]", 1.0, 0.0);
    assert!(fan.torque_n_m < 0.0 && fan.thrust_coefficient == 0.0, "{fan:?}");
    // parked across a storm: pushed downwind; feathered: hardly
    let (parked, feathered) = (loads("[50, 0, 0]", 0.0, 0.0), loads("[50, 0, 0]", 0.0, 90.0));
    assert!(parked.thrust_n > 5e5 && feathered.thrust_n.abs() < 0.1 * parked.thrust_n, "{parked:?} {feathered:?}");
    // wind from behind, from the side, and reversed rotation
    assert!(loads("[-8, 0, 0]", 0.95, 0.0).thrust_n < 0.0);
    assert!(loads("[0, 12, 0]", 0.95, 0.0).torque_n_m < 0.0);
    assert!(loads("[8, 0, 0]", -0.95, 0.0).power_w < 0.0);
    // ten times the wind
    assert!(loads("[80, 0, 0]", 0.95, 0.0).thrust_n > 1e6);
}

/// RT-17: coefficients refer to the wind along the shaft, and are 0 where this is negligible: wind from the side.
#[test]
fn coefficients_are_zero_in_a_wind_from_the_side() {
    let at = |yaw_deg: f64| {
        let (sine, cosine) = yaw_deg.to_radians().sin_cos();
        turned(model(&format!("[{:?}, {:?}, 0]", 12.0 * cosine, 12.0 * sine), 1.0, 0.0, "step_s = 0.05\n", ""), 0.1)
    };
    let of = |loads: &RotorLoads| {
        [loads.power_coefficient, loads.thrust_coefficient, loads.tip_speed_ratio, loads.induction]
    };
    let side = at(90.0);
    assert_eq!(of(&side), [0.0; 4], "{side:?}");
    assert!(side.thrust_n != 0.0 && side.torque_n_m != 0.0);
    // the wind along the shaft just below and just above a hundredth of the tip speed, hypot(63, 12) m/s
    let (below, above) = (at(86.95), at(86.9));
    assert!(of(&below) == [0.0; 4] && of(&above).iter().all(|value| *value != 0.0), "{below:?} {above:?}");
    let pressure_n = 0.5 * 1.225 * PI * 62.9999f64.powi(2) * above.wind_m_s.powi(2);
    approx::assert_relative_eq!(above.thrust_coefficient, above.thrust_n / pressure_n, max_relative = 1e-6);
}

/// RT-18: pitching moment at the root of a blade: moments of the polars at the angles and speeds that include the induction, linear between
/// the stations, from the independent steady rotor. The quarter chord is the blade's axis, so forces have no moment about it.
#[test]
fn pitching_moment_is_that_of_the_sections_behind_the_induction() {
    let (wind_m_s, speed_rad_s) = (8.0, 9.1311 * PI / 30.0);
    let rotor = nrel_5mw(EndRule::ZeroLoad);
    let nodes = rotor.at(wind_m_s, speed_rad_s, 0.0).nodes;
    let line_n: Vec<f64> = nodes
        .iter()
        .zip(&rotor.nodes)
        .enumerate()
        .map(|(i, (load, node))| {
            let loaded = i > 0 && i + 1 < nodes.len();
            let pressure_n = 0.5 * 1.225 * (node.chord_m * load.section.speed_m_s).powi(2);
            if loaded { pressure_n * load.section.row.moment } else { 0.0 }
        })
        .collect();
    let expected: f64 = (1..nodes.len())
        .map(|i| 0.5 * (line_n[i] + line_n[i - 1]) * (rotor.nodes[i].radius_m - rotor.nodes[i - 1].radius_m))
        .sum();
    let load = "[internal_load.root]\nbody = \"blade0\"\nposition_m = 0.0\n";
    let mut plant = Plant::new(Arc::new(machine(model("[8, 0, 0]", speed_rad_s, 0.0, "step_s = 0.02\n", load))));
    plant.initialize(0.0).unwrap();
    plant.step(0.1).unwrap();
    let found = plant.outputs().internal_loads()[0].moment_n_m.x;
    println!("pitching moment at the root: {found:.3} N·m, of the sections {expected:.3}");
    // the blade's x is its axis, y points to the leading edge: nose-up is a rotation about x. 1e-6: deflections of stiff blades, whose
    // forces then have lever arms
    assert!(expected < -1e4 && (found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
}

/// RT-07: a rotor with reversed rotation is the mirror image.
#[test]
fn counter_clockwise_rotor_is_the_mirror_image() {
    let clockwise = model("[9, 2, 1]", 1.0, 3.0, "step_s = 0.05\nskewed_wake = true\n", "");
    // mirrored at y = 0: blades at opposite azimuths, leading edges and speed reversed
    let mirrored = clockwise
        .replace("wind_m_s = [9, 2, 1]", "wind_m_s = [9, -2, 1]\nrotation_direction = \"counter_clockwise\"")
        .replace("elastic_axis_fraction", "leading_edge = \"-y\"\nelastic_axis_fraction")
        .replace("polynomial_deg = [0.0, ", "polynomial_deg = [0.0, -");
    let swapped = mirrored.replace("blade1", "blade9").replace("blade2", "blade1").replace("blade9", "blade2");
    let (one, other) = (turned(clockwise, 0.2), turned(swapped, 0.2));
    for (a, b) in
        [(one.thrust_n, other.thrust_n), (one.torque_n_m, other.torque_n_m), (one.speed_rad_s, other.speed_rad_s)]
    {
        approx::assert_relative_eq!(a, b, max_relative = 1e-9);
    }
}

/// RT-08: wind fields: shear alone does not change the mean, a table is added, turbulence affects the loads and is repeatable for a seed.
#[test]
fn fields_reach_the_blades() {
    let wind = "[wind]\nreference_height_m = 90.0\nground_m = [0, 0, -90]\n";
    let run = |wind_m_s: &str, more: &str| {
        turned(model(wind_m_s, 1.0, 0.0, "step_s = 0.05\n", &format!("{wind}{more}")), 0.3)
    };
    let plain = run("[10, 0, 0]", "");
    let none = turned(model("[10, 0, 0]", 1.0, 0.0, "step_s = 0.05\n", ""), 0.3);
    assert_eq!(plain, none);
    let sheared = run("[10, 0, 0]", "shear_exponent = 0.2\n");
    assert!((sheared.wind_m_s / 10.0 - 1.0).abs() < 0.02 && sheared.thrust_n != plain.thrust_n, "{sheared:?}");
    let table =
        run("[0, 0, 0]", "downwind = [1, 0, 0]\nreference_length_m = 126.0\ntable = [[0, 10, 0, 0, 0, 0, 0, 0]]\n");
    approx::assert_relative_eq!(table.thrust_n, plain.thrust_n, max_relative = 1e-12);
    let turbulence = |seed: u32| {
        let more = format!(
            "downwind = [1, 0, 0]\n[wind.turbulence]\nseed = {seed}\nmean_m_s = 10.0\nstandard_deviation_m_s = 1.5\npoints = [5, 5]\n\
             spacing_m = [35.0, 35.0]\nplanes = 64\nplane_interval_s = 0.25\n"
        );
        run("[0, 0, 0]", &more)
    };
    let (one, again, other) = (turbulence(1), turbulence(1), turbulence(2));
    assert_eq!(one, again);
    assert!(one.thrust_n != other.thrust_n && (one.wind_m_s - 10.0).abs() < 4.0, "{one:?}");
    let towered = turned(
        model(
            "[10, 0, 0]",
            1.0,
            0.0,
            "step_s = 0.05\n",
            "[tower]\nbase_m = [5, 0, -90]\nrows = [[0, 6, 1], [87, 4, 1]]\nshadow = \"powles\"\n",
        ),
        2.0 * PI / 3.0 * 0.5, // a blade is in front of the tower
    );
    let free = turned(model("[10, 0, 0]", 1.0, 0.0, "step_s = 0.05\n", ""), 2.0 * PI / 3.0 * 0.5);
    assert!(towered.thrust_n < free.thrust_n, "{} {}", towered.thrust_n, free.thrust_n);
}

/// RT-09: errors in a model file are rejected with key and line.
#[test]
fn faulty_rotors_are_refused_by_name() {
    let sound = model("[8, 0, 0]", 1.0, 0.0, "", "");
    let folder = format!("{}/tests/reference/turbine", env!("CARGO_MANIFEST_DIR"));
    let with = |from: &str, to: &str| {
        let changed = sound.replacen(from, to, 1);
        assert_ne!(changed, sound, "{from}");
        let read = foldwing::config::with_files(changed, folder.as_ref(), "rotor.toml");
        match read.and_then(|text| foldwing::config::parse(&text, "rotor.toml")) {
            Ok(_) => "nothing refused".to_owned(),
            Err(error) => error.to_string(),
        }
    };
    for (from, to, expected) in [
        ("hub = \"hub\"", "hub = \"hubb\"", "key 'aerodynamics.hub'"),
        ("hub = \"hub\"\n", "", "key 'aerodynamics.hub' is missing"),
        ("hub_radius_m = 1.5\n", "", "key 'aerodynamics.hub_radius_m' is missing"),
        ("hub_radius_m = 1.5", "hub_radius_m = 1.5\nshaft_axis = [0, 0, 0]", "key 'aerodynamics.shaft_axis'"),
        ("hub_radius_m = 1.5", "hub_radius_m = 1.5\nfree_wake = true", "key 'aerodynamics.free_wake'"),
        ("hub_radius_m = 1.5", "hub_radius_m = 1.5\nindicial = \"fine\"", "key 'aerodynamics.indicial'"),
        ("hub_radius_m = 1.5", "hub_radius_m = 1.5\nmirror_normal = [0, 0, 1]", "key 'aerodynamics.mirror_normal'"),
        ("stations_m = [0.0, 1.3667", "stations_m = [0.0, 0.0", "key 'surface.blade0.stations_m'"),
        ("61.4999]\npolars", "62.0]\npolars", "key 'surface.blade0.stations_m'"),
        ("polars = [\"cylinder1\"", "polars = [\"cylinder9\"", "key 'surface.blade0.polars'"),
        ("polars = [\"cylinder1\", ", "polars = [", "key 'surface.blade0.polars'"),
        ("elastic_axis_fraction = 0.25", "elastic_axis_fraction = 0.25\nstrips = 3", "key 'surface.blade0.strips'"),
        (
            "elastic_axis_fraction = 0.25",
            "elastic_axis_fraction = 0.25\ndrag_coefficient = 0.1",
            "key 'surface.blade0.drag_coefficient'",
        ),
        ("polars/du21_a17.csv", "polars/missing.csv", "key 'polar.du21_a17.file'"),
        ("polars/du21_a17.csv", "nrel5mw_blade.csv", "no column alpha_deg"),
        (
            "file = \"polars/du21_a17.csv\"",
            "rows = [[-10, 0, 0.1, 0], [10, 1, 0.1, 0]]",
            "aspect_ratio, which extends them",
        ),
        ("model = \"bem\"", "model = \"strip\"", "key 'aerodynamics.hub'"),
    ] {
        let refusal = with(from, to);
        assert!(refusal.contains(expected), "{to}: {refusal}");
        assert!(refusal.starts_with("rotor.toml:") && !refusal.starts_with("rotor.toml:0"), "{to}: {refusal}");
    }
    let extended =
        with("file = \"polars/du21_a17.csv\"", "rows = [[-10, -0.5, 0.02, 0], [10, 1.4, 0.03, 0]]\naspect_ratio = 17");
    assert_eq!(extended, "nothing refused");
}

/// RT-10: steps of a rotor with all kinds of lag states allocate no memory.
#[test]
fn steps_do_not_allocate() {
    let air = "step_s = 0.05\ndynamic_inflow = true\ndynamic_stall = true\nskewed_wake = true\n";
    let tables = "[wind]\nreference_height_m = 90.0\nground_m = [0, 0, -90]\nshear_exponent = 0.2\n\
                  [tower]\nbase_m = [5, 0, -90]\nrows = [[0, 6, 1], [87, 4, 1]]\nshadow = \"powles\"\n";
    let mut plant = Plant::new(Arc::new(machine(model("[8, 1, 0]", 0.95, 0.0, air, tables))));
    plant.initialize(0.0).unwrap();
    plant.step(0.2).unwrap();
    let before = allocations();
    assert!(before > 0, "the counter counts");
    plant.step(0.6).unwrap();
    assert_eq!(allocations(), before);
}

/// A rotor of three blades with one blade missing is rejected with an error that gives the cause; so is one with a blade at a wrong
/// azimuth.
#[test]
fn rotor_with_a_blade_missing_is_refused() {
    let whole = model("[8, 0, 0]", 1.0, 0.0, "step_s = 0.02\n", "");
    let (kept, rest) = whole.split_once("[body.blade2]").unwrap();
    let (_, polars) = rest.split_once("[polar.").unwrap();
    let missing = format!("{kept}[polar.{polars}");
    let folder = format!("{}/tests/reference/turbine", env!("CARGO_MANIFEST_DIR"));
    let text = foldwing::config::with_files(missing, folder.as_ref(), "rotor.toml").unwrap();
    let told = foldwing::config::parse(&text, "rotor.toml").expect_err("two blades of three").to_string();
    for word in ["blade1 120.0 deg from blade0 about the shaft", "180.0 deg apart for 2 blades", "is one missing"] {
        assert!(told.contains(word), "{word:?} is missing in {told}");
    }
    // a second rotor, or a wing in addition to a rotor
    let other = "[joint.other]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"wing\"\n[body.wing]\nlength_m = 5.0\nelements = 1\n\
        section = \"tube\"\n[surface.wing]\nbody = \"wing\"\nelastic_axis_fraction = 0.25\nstations_m = [0.0, 5.0]\n\
        polars = [\"cylinder1\", \"cylinder1\"]\nchord_m = 1.0\n";
    let text = model("[8, 0, 0]", 1.0, 0.0, "step_s = 0.02\n", other);
    let text = foldwing::config::with_files(text, folder.as_ref(), "rotor.toml").unwrap();
    let told = foldwing::config::parse(&text, "rotor.toml").expect_err("a wing that does not turn").to_string();
    assert!(
        told.contains("wing, which is not attached to the hub hub") && told.contains("[aerodynamics.<name>]"),
        "{told}"
    );
}
