//! LR-01 to LR-10, LR-12, LR-13, LR-17 to LR-19: every row of `A`, `B`, `C` and `D` against differences of the nonlinear machine, see [`compare`].

pub mod compare;
mod several;
mod stiff_end;
mod still_shaft;
mod thin_blade;

use crate::whole::is_whole;
use compare::{Rows, linear_rows_agree, linear_rows_agree_at};
use foldwing::config;
use foldwing::interface::{Interface, LinearModel};
use foldwing::machine::{AirOptions, Machine};
use foldwing::plant::{Holding, Plant};
use nalgebra::DMatrix;
use std::fmt::Write;
use std::sync::Arc;

/// A shipped model.
fn shipped(path: &str) -> Machine {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(path);
    config::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).0
}

/// Shipped models that LR-01 cannot compare or that exceed its tolerance, with a part of the message. The aircraft need a trimmed state.
const LEFT_OUT: &[(&str, &str)] = &[
    ("airs/wing_with_fuselage.toml", "no steady flight"),
    ("flight/folding_aircraft.toml", "no steady flight"),
    ("flying_aircraft.toml", "no steady flight"),
    ("gear/castor.toml", "constrains velocities"),
    ("gear/oleo.toml", "constrains velocities"),
    ("models/flying_wing.toml", "no steady flight"),
    ("models/double_pendulum.toml", "no stiffness resists a motion of joint"),
];

/// Paths of all model files below `examples`, sorted.
fn examples() -> Vec<String> {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let (mut folders, mut found) = (vec![root.clone()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
            let path = entry.expect("readable").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "toml") {
                let within = path.strip_prefix(&root).expect("below the folder");
                found.push(within.to_str().expect("a name in UTF-8").replace('\\', "/"));
            }
        }
    }
    found.sort();
    found
}

/// LR-01. Shipped models about their start, or about their equilibrium if a joint has several degrees of freedom. Short studies: one of
/// each kind of aerodynamics and joint.
#[test]
#[ignore = "minutes; `make validate` runs it"]
fn lr01_rows_of_shipped_models() {
    const SHORT: [&str; 8] = [
        "airs/twin_rotor.toml",
        "airs/wing_with_propellers.toml",
        "models/goland_wing.toml",
        "models/flared_wing_tip.toml",
        "models/four_bar.toml",
        "models/roll_fold.toml",
        "failures/pitch_link.toml",
        "turbine/nrel_5mw_wind.toml",
    ];
    let all = examples();
    let named = SHORT.iter().chain(LEFT_OUT.iter().map(|(path, _)| path));
    named.for_each(|path| assert!(all.iter().any(|known| known == path), "{path} is not shipped"));
    let mut missed = Vec::new();
    for path in all.iter().filter(|path| is_whole() || SHORT.contains(&path.as_str())) {
        println!("LR-01 {path}");
        let cause = LEFT_OUT.iter().find(|(left, _)| left == path).map(|(_, cause)| *cause);
        match (linear_rows_agree(&shipped(path)), cause) {
            (Rows::Agree(off), None) => println!("LR-01 {path}: off by at most {off:.1e} of a row's scale"),
            (Rows::Miss(why) | Rows::Refused(why), Some(cause)) if why.contains(cause) => {}
            (Rows::Agree(_), Some(_)) => missed.push(format!("{path} agrees, and is left out")),
            (Rows::Miss(why) | Rows::Refused(why), _) => missed.push(format!("{path}: {why}")),
        }
    }
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

/// Pseudo-random numbers between 0 and 1, the same in every run.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }
}

/// A chain of one to four beams and rigid bodies on revolute joints: motors within and beyond their limits, springs, dampers, loaded end
/// stops, generators with a table, slipping brakes, closed elastic latches; loads, gauges, internal loads, and strip theory for some.
fn random_machine(random: &mut Random) -> String {
    let mut text = String::from(
        "name = 'random'\ngravity_m_s2 = [0.5, -0.3, -9.0]\n[section.s]\nshape = 'explicit'\naxial_stiffness_N = 4e4\n\
         torsional_rigidity_N_m2 = 8.0\nflap_stiffness_N_m2 = 12.0\nedge_stiffness_N_m2 = 30.0\ncoupling_twist_flap_N_m2 = 1.5\n\
         mass_kg_m = 0.5\ncentre_of_mass_m = [0.01, 0.0]\nsecond_moments_kg_m = [0.01, 0.0, 0.004]\nhalf_width_m = 0.1\n\
         half_height_m = 0.05\n",
    );
    let count = 1 + (4.0 * random.unit()) as usize;
    let in_air = random.chance(0.25);
    let mut beams = Vec::new();
    for k in 0..count {
        let parent = if k == 0 { "root".to_owned() } else { format!("b{}", k - 1) };
        let beam = random.chance(0.5) || in_air && k == 0;
        if beam {
            beams.push(k);
            let _ = write!(
                text,
                "[body.b{k}]\nlength_m = {:.3}\nsection = 's'\nelements = {}\nelement = '{}'\nmass_damping_1_s = {:.3}\n\
                 stiffness_damping_s = {:.5}\nload_stations = 1\n[gauge.g{k}]\nbody = 'b{k}'\nposition_m = 0.1\n\
                 [internal_load.c{k}]\nbody = 'b{k}'\nposition_m = 0.15\n",
                random.between(0.3, 0.7),
                if random.chance(0.5) { 1 } else { 2 },
                if random.chance(0.5) { "linear" } else { "constant" },
                random.between(0.0, 0.5),
                random.between(0.0, 1e-3),
            );
        } else {
            let _ = write!(
                text,
                "[rigid_body.b{k}]\nmass_kg = {:.3}\ncentre_of_mass_m = [{:.3}, 0.05, -0.03]\n\
                 inertia_kg_m2 = [0.02, 0.03, 0.04, 0.001, 0.0, 0.002]\n",
                random.between(0.3, 2.0),
                random.between(-0.2, 0.3),
            );
        }
        let slide = random.chance(0.25);
        let (kind, per, rate, limit, upper) = if slide {
            ("prismatic", "N_m", "start_rate_m_s", "force_limit_N", ("upper_m", "stiffness_N_m", "damping_N_s_m"))
        } else {
            (
                "revolute",
                "N_m_rad",
                "start_rate_deg_s",
                "torque_limit_N_m",
                ("upper_deg", "stiffness_N_m_rad", "damping_N_m_s_rad"),
            )
        };
        let turn = if slide { 1.0 } else { 57.3 };
        let _ = write!(
            text,
            "[joint.j{k}]\ntype = '{kind}'\nparent = '{parent}'\nchild = 'b{k}'\naxis = [{:.3}, 1.0, {:.3}]\n\
             {rate} = {:.3}\n{} = {:.4}\nmotor.stiffness_{per} = {:.3}\nmotor.{} = {:.3}\n",
            random.between(-0.5, 0.5),
            random.between(-0.5, 0.5),
            turn * random.between(-2.0, 2.0),
            if slide { "start_position_m" } else { "start_angle_deg" },
            turn * random.between(-0.2, 0.4),
            random.between(0.5, 8.0),
            upper.2,
            random.between(0.0, 0.4),
        );
        if random.chance(0.5) {
            let _ = writeln!(text, "motor.{limit} = {:.3}", random.between(0.05, 3.0));
        }
        if random.chance(0.4) {
            let _ = writeln!(text, "spring.stiffness_{per} = {:.3}", random.between(0.5, 5.0));
        }
        if !slide && random.chance(0.5) {
            let _ = write!(
                text,
                "motor.gear_ratio = {:.2}\n[joint.j{k}.generator]\ntable_rpm_N_m = [[-10.0, {:.3}], [5.0, 0.1], [12.0, {:.3}]]\nabove_table = 'constant_power'\nefficiency = 0.9\n",
                random.between(1.0, 3.0),
                random.between(-0.5, 0.5),
                random.between(0.3, 2.0),
            );
        }
        if random.chance(0.4) {
            let _ = write!(
                text,
                "[joint.j{k}.end_stops]\n{} = {:.4}\n{} = {:.1}\n{} = {:.3}\n",
                upper.0,
                turn * random.between(-0.3, 0.3),
                upper.1,
                random.between(100.0, 1000.0),
                upper.2,
                random.between(0.0, 5.0),
            );
        } else if random.chance(0.3) {
            let (at, window, ratio) = if slide {
                ("position_m", "capture_m", "stiffness_N_m")
            } else {
                ("angle_deg", "capture_deg", "stiffness_N_m_rad")
            };
            let _ = write!(
                text,
                "[joint.j{k}.latch]\n{at} = {:.4}\n{window} = {:.4}\n{ratio} = 400.0\n",
                turn * 0.1,
                turn * 0.8
            );
        }
        if random.chance(0.4) {
            let (torque, slip) = if slide { ("force_N", "slip_m_s") } else { ("torque_N_m", "slip_deg_s") };
            let _ = write!(
                text,
                "[failure.f{k}]\nkind = 'brake_applied'\njoint = 'j{k}'\nat_time_s = 0.001\n{torque} = {:.3}\nramp_s = 0.002\n{slip} = {:.4}\n",
                random.between(0.1, 2.0),
                turn * random.between(0.3, 2.0),
            );
        }
    }
    if in_air {
        text += "[aerodynamics]\nmodel = 'strip'\nwind_m_s = [0.5, -9.0, 0.7]\nstep_s = 1e-3\n";
        for k in beams {
            let _ = write!(text, "[surface.b{k}]\nbody = 'b{k}'\nchord_m = 0.2\nstrips = 2\n");
        }
    }
    text + "[solver]\ntolerance = 1e-10\n[simulation]\nstop_time_s = 1.0\nstep_s = 1e-3\n"
}

/// LR-02. Random machines about a moving state. Short studies: eight of the hundred.
#[test]
fn lr02_rows_of_random_machines() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut worst, mut missed, mut unreached) = (0.0f64, Vec::new(), 0);
    for number in 0..if is_whole() { 100 } else { 8 } {
        let text = random_machine(&mut random);
        let machine = config::parse(&text, "random.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}\n{text}"));
        if let Err(error) = plant.step(0.005) {
            // with aerodynamics, a whole aerodynamic step is integrated with the shortest step that it needs, 4e-8 s at this tolerance
            println!("LR-02 machine {number}: {error}");
            unreached += 1;
            continue;
        }
        match linear_rows_agree_at(&mut plant) {
            Rows::Agree(off) => worst = worst.max(off),
            Rows::Miss(why) | Rows::Refused(why) => {
                println!("LR-02 machine {number}: {why}\n{text}");
                missed.push(number);
            }
        }
    }
    assert!(missed.is_empty(), "rows of the machines {missed:?} are off, see above");
    assert!(unreached <= 5, "{unreached} machines give up");
    println!("LR-02: off by at most {worst:.1e} of a row's scale");
}

/// LR-03. At a kink the four matrices take the same side: a motor exactly at its limit is not limited, a generator at a row of its table
/// continues towards higher speeds, a motionless joint exactly at its end stop is not in contact. On either side of the kink, the matrices
/// are those of that side.
#[test]
fn lr03_one_side_of_a_kink() {
    let model = |wanted: f64, rpm: f64, at_m: f64| {
        let text = format!(
            "name = 'K'\n[rigid_body.block]\nmass_kg = 2.0\ninertia_kg_m2 = [0.5, 0.5, 0.5, 0.0, 0.0, 0.0]\n\
             [rigid_body.rotor]\nmass_kg = 1.0\ninertia_kg_m2 = [0.5, 0.5, 0.5, 0.0, 0.0, 0.0]\n\
             [rigid_body.rest]\nmass_kg = 1.0\n\
             [joint.slide]\ntype = 'prismatic'\nparent = 'root'\nchild = 'block'\naxis = [1.0, 0.0, 0.0]\n\
             start_position_m = {wanted:?}\nmotor.stiffness_N_m = 4.0\nmotor.force_limit_N = 2.0\n\
             [joint.shaft]\ntype = 'revolute'\nparent = 'root'\nchild = 'rotor'\naxis = [1.0, 0.0, 0.0]\n\
             start_rate_deg_s = {:?}\nmotor.gear_ratio = 1.0\n\
             [joint.shaft.generator]\ntable_rpm_N_m = [[0.0, 0.0], [30.0, 1.0], [60.0, 4.0]]\n\
             [joint.stop]\ntype = 'prismatic'\nparent = 'root'\nchild = 'rest'\naxis = [0.0, 1.0, 0.0]\nstart_position_m = {at_m:?}\n\
             [joint.stop.end_stops]\nupper_m = 0.25\nstiffness_N_m = 50.0\ndamping_N_s_m = 3.0\n[simulation]\nstop_time_s = 1.0\n",
            rpm * 6.0
        );
        let machine = config::parse(&text, "kinks.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let interface = Interface::new(plant.machine());
        let outputs: Vec<_> = interface.real_outputs().collect();
        let inputs: Vec<_> = interface.real_inputs().collect();
        interface.linearize(&mut plant, &inputs, &outputs).unwrap_or_else(|error| panic!("{error}"))
    };
    let entry = |model: &LinearModel, matrix: char, row: &str, column: &str| {
        let place = |list: &[foldwing::interface::LinearSignal], name: &str| {
            list.iter().position(|signal| signal.name == name).unwrap_or_else(|| panic!("{name}"))
        };
        let m = &model.matrices;
        match matrix {
            'A' => m.a[(place(&model.states, row), place(&model.states, column))],
            'B' => m.b[(place(&model.states, row), place(&model.inputs, column))],
            'C' => m.c[(place(&model.outputs, row), place(&model.states, column))],
            _ => m.d[(place(&model.outputs, row), place(&model.inputs, column))],
        }
    };
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
    let beyond = 1e-9;
    // derivatives: of the motor, of the generator with respect to its speed in N.m.s/rad, of the stop
    let per_rpm = 30.0 / std::f64::consts::PI;
    for (wanted, rpm, at_m, motor, generator, stop) in [
        (0.5, 30.0, 0.25, 4.0, 0.1 * per_rpm, [0.0, 0.0]),
        (0.5 + beyond, 30.0 - beyond, 0.25 + beyond, 0.0, per_rpm / 30.0, [50.0, 3.0]),
        (0.5 - beyond, 30.0 + beyond, 0.25 - beyond, 4.0, 0.1 * per_rpm, [0.0, 0.0]),
    ] {
        let model = model(wanted, rpm, at_m);
        near(entry(&model, 'A', "der(slide.position)", "slide.position"), -motor / 2.0);
        near(entry(&model, 'B', "der(slide.position)", "slide.position_command"), motor / 2.0);
        near(entry(&model, 'C', "slide.motor_force", "slide.position"), -motor);
        near(entry(&model, 'D', "slide.motor_force", "slide.position_command"), motor);
        near(entry(&model, 'A', "der(shaft.angle)", "der(shaft.angle)"), -generator / 0.5);
        near(entry(&model, 'C', "shaft.generator_torque", "der(shaft.angle)"), generator);
        near(entry(&model, 'A', "der(stop.position)", "stop.position"), -stop[0]);
        near(entry(&model, 'A', "der(stop.position)", "der(stop.position)"), -stop[1]);
    }
}

/// LR-04. In compressible flow the loads grow with the Mach number: the static gain of the linear lattice for the wind speed is the
/// derivative of the steady loads, which at Mach 0.5 grow by a sixth more than with the square of the speed.
#[test]
fn lr04_lattice_in_compressible_air() {
    let machine = |speed_m_s: f64| {
        let text = format!(
            "name = 'M'\n[section.s]\nshape = 'explicit'\naxial_stiffness_N = 1e12\ntorsional_rigidity_N_m2 = 1e11\n\
             flap_stiffness_N_m2 = 1e11\nedge_stiffness_N_m2 = 1e11\nmass_kg_m = 5.0\nsecond_moments_kg_m = [0.1, 0.0, 0.1]\n\
             half_width_m = 0.5\nhalf_height_m = 0.1\n[body.wing]\nlength_m = 4.0\nsection = 's'\nelements = 1\n\
             [joint.mount]\ntype = 'clamped'\nparent = 'root'\nchild = 'wing'\n\
             [aerodynamics]\nmodel = 'uvlm'\ndensity_kg_m3 = 0.5\nwind_m_s = [0.0, {:?}, {:?}]\nspeed_of_sound_m_s = 300.0\n\
             step_s = 2e-3\nwake_rows = 20\n[surface.wing]\nbody = 'wing'\nchord_m = 1.0\nstrips = 4\nchord_panels = 2\n\
             [simulation]\nstop_time_s = 1.0\nstart = 'equilibrium'\n",
            -speed_m_s,
            0.05 * speed_m_s
        );
        config::parse(&text, "mach.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
    };
    let started = |speed_m_s: f64| {
        let mut plant = Plant::new(Arc::new(machine(speed_m_s)));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        plant
    };
    let mut plant = Plant::new(Arc::new(machine(150.0)));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    let interface = Interface::new(plant.machine());
    let named = |name: &str| interface.find(name).unwrap_or_else(|| panic!("{name}"));
    let inputs = ["wind.velocity.y", "wind.velocity.z"].map(named);
    let model = interface.linearize_lattice(&mut plant, &inputs, &[], &[named("aero.force.z")]);
    let model = model.unwrap_or_else(|error| panic!("{error}"));
    let m = &model.matrices;
    let n = m.a.nrows();
    let at_rest = (DMatrix::identity(n, n) - &m.a).lu().solve(&m.b).expect("decays");
    let gain = &m.c * at_rest + &m.d;
    // along the wind: both components of the wind grow with the speed
    let found = -gain[(0, 0)] + 0.05 * gain[(0, 1)];
    let lift_n = |speed_m_s: f64| started(speed_m_s).outputs().air_total().force_n.z;
    let slope = |step: f64| (lift_n(150.0 + step) - lift_n(150.0 - step)) / (2.0 * step);
    let expected = (4.0 * slope(1.0) - slope(2.0)) / 3.0;
    let power = expected * 150.0 / lift_n(150.0);
    println!("LR-04: {found} N.s/m for {expected}, the load grows with the power {power} of the speed");
    // without compressibility the exponent would be 2
    assert!(power > 2.1, "{power}");
    assert!((found / expected - 1.0).abs() < 2e-3, "{found} for {expected}");
}

/// LR-05. Commands do not move a joint whose drive has a runaway, a jam or a loss of power: rows before and after the failure.
#[test]
fn lr05_commands_of_failed_drives() {
    for (failure, follows) in [
        ("kind = 'motor_runaway'\nto_deg = 30.0\nrate_deg_s = 400.0", false),
        ("kind = 'motor_jam'", false),
        ("kind = 'motor_loss'", false),
        ("kind = 'spring_break'", true),
    ] {
        let text = format!(
            "name = 'K'\n[rigid_body.block]\nmass_kg = 2.0\ninertia_kg_m2 = [0.5, 0.5, 0.5, 0.0, 0.0, 0.0]\n\
             [joint.hinge]\ntype = 'revolute'\nparent = 'root'\nchild = 'block'\naxis = [1.0, 0.0, 0.0]\nstart_rate_deg_s = 20.0\n\
             motor.stiffness_N_m_rad = 4.0\nmotor.damping_N_m_s_rad = 0.1\nspring.stiffness_N_m_rad = 1.0\n\
             [rigid_body.tip]\nmass_kg = 1.0\ninertia_kg_m2 = [0.2, 0.2, 0.2, 0.0, 0.0, 0.0]\n\
             [joint.other]\ntype = 'revolute'\nparent = 'block'\nchild = 'tip'\nparent_offset_m = [0.0, 0.5, 0.0]\n\
             axis = [1.0, 0.0, 0.0]\nmotor.stiffness_N_m_rad = 3.0\n\
             [failure.f]\njoint = 'hinge'\n{failure}\nat_time_s = 0.01\n"
        );
        let machine = config::parse(&text, "failed.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).expect("a start");
        for (end_s, follows) in [(0.005, true), (0.02, follows)] {
            plant.step(end_s).expect("a run");
            let interface = Interface::new(plant.machine());
            let inputs: Vec<_> = interface.real_inputs().filter(|row| row.name.ends_with(".angle_command")).collect();
            let outputs: Vec<_> = interface.real_outputs().collect();
            let model = interface.linearize(&mut plant, &inputs, &outputs).expect("a linear model");
            let moves = |name: &str| {
                let column = model.inputs.iter().position(|input| input.name == name).expect("an input");
                model.matrices.b.column(column).amax() > 0.0
            };
            println!("LR-05 {failure:?} at {end_s} s: {}", moves("hinge.angle_command"));
            assert_eq!(
                [moves("hinge.angle_command"), moves("other.angle_command")],
                [follows, true],
                "{failure} at {end_s} s"
            );
            let rows = linear_rows_agree_at(&mut plant);
            assert!(matches!(rows, Rows::Agree(_)), "{failure} at {end_s} s: {rows:?}");
        }
    }
}

/// Hinged beams with strip theory and an impulsive start, with gravity and a start rate in °/s.
fn hinged_wing(start_rate_deg_s: f64) -> Machine {
    let text = format!(
        "name = 'W'\n[section.s]\nshape = 'rectangle'\nwidth_m = 0.06\nheight_m = 0.005\ndensity_kg_m3 = 1600.0\n\
         youngs_modulus_Pa = 13e9\nshear_modulus_Pa = 5e9\n[body.inner]\nlength_m = 0.3\nsection = 's'\nelements = 2\n\
         [body.outer]\nlength_m = 0.2\nsection = 's'\nelements = 2\n\
         [joint.hinge]\ntype = 'revolute'\nparent = 'root'\nchild = 'inner'\naxis = [0.1, 1.0, 0.0]\n\
         start_angle_deg = 20.0\nstart_rate_deg_s = {start_rate_deg_s:?}\nmotor.stiffness_N_m_rad = 20.0\n\
         [joint.fold]\ntype = 'revolute'\nparent = 'inner'\nchild = 'outer'\naxis = [1.0, 0.2, 0.3]\n\
         motor.stiffness_N_m_rad = 5.0\nmotor.damping_N_m_s_rad = 0.02\n\
         [surface.inner]\nbody = 'inner'\nchord_m = 0.1\nstrips = 2\nincidence_deg = 3.0\n\
         [surface.outer]\nbody = 'outer'\nchord_m = 0.1\nstrips = 2\nincidence_deg = 3.0\n\
         [aerodynamics]\nmodel = 'strip'\nwind_m_s = [0.5, -9.0, 0.7]\nstep_s = 2e-3\nsteady_initial_flow = false\n\
         [solver]\ntolerance = 1e-9\n[simulation]\nstop_time_s = 1.0\nstep_s = 1e-3\n"
    );
    config::parse(&text, "hinged.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// LR-06. At zero rates with inputs changed since the last step, the model uses the current accelerations: they multiply the change of the
/// mass matrix with the pose.
#[test]
fn lr06_rest_whose_inputs_have_changed() {
    let machine = Arc::new(hinged_wing(0.0));
    let mut plant = Plant::new(Arc::clone(&machine));
    plant.study().equilibrium(0.0, Holding::AsReleased).expect("an equilibrium");
    plant.inputs_mut().joints_mut()[1].torque_n_m = 3.0;
    let rows = linear_rows_agree_at(&mut plant);
    assert!(matches!(rows, Rows::Agree(_)), "{rows:?}");
    println!("LR-06: {rows:?}");
}

/// LR-07. Reading the machine as a hybrid system twice within an aerodynamic step gives bit-identical lag states: the current ones.
#[test]
fn lr07_lag_states_are_those_of_the_present() {
    let mut plant = Plant::new(Arc::new(hinged_wing(50.0)));
    plant.initialize(0.0).expect("a start");
    // half an aerodynamic step
    plant.step(0.005).expect("a run");
    let read = |plant: &mut Plant| {
        let hybrid = plant.hybrid().expect("a hybrid system");
        let mut states = vec![0.0; hybrid.states()];
        hybrid.read(&mut states);
        states
    };
    let first = read(&mut plant);
    assert!(first[first.len() - plant.exchange_lags().len()..].iter().any(|lag| *lag != 0.0));
    assert_eq!(first, read(&mut plant));
}

/// LR-08. Start rates do not affect an equilibrium: if the flow starts impulsively, its loads are those without motion.
#[test]
fn lr08_equilibria_have_no_start_rates() {
    let rest = |start_rate_deg_s: f64| {
        let mut plant = Plant::new(Arc::new(hinged_wing(start_rate_deg_s)));
        plant.study().equilibrium(0.0, Holding::AsReleased).expect("an equilibrium");
        plant.outputs().joints().iter().map(|joint| joint.angle_rad).collect::<Vec<_>>()
    };
    // identical searches: results agree to the last bit
    assert_eq!(rest(0.0), rest(50.0));
}

/// LR-09. In air a hundred times as heavy as at sea level, linear models of a wing about a moving state are correct without apparent mass;
/// with an apparent mass many times the wing's they are rejected with an error that gives the remedy.
#[test]
fn lr09_moving_in_heavy_air() {
    for apparent_mass in [false, true] {
        let mut machine = shipped("models/goland_wing.toml");
        let air = machine.air.as_mut().expect("air");
        air.density_kg_m3 *= 100.0;
        let AirOptions::Strips(strips) = &mut air.parts[0].options else { panic!("strips") };
        strips.apparent_mass = apparent_mass;
        let mut plant = Plant::new(Arc::new(machine));
        plant.inputs_mut().wind_m_s_mut().z = 3.0;
        plant.initialize(0.0).expect("a start");
        plant.step(0.005).expect("a run");
        let rows = linear_rows_agree_at(&mut plant);
        println!("LR-09, apparent mass {apparent_mass}: {rows:?}");
        match rows {
            Rows::Agree(_) => {}
            Rows::Refused(why) => assert!(apparent_mass && why.contains("write apparent_mass = false"), "{why}"),
            Rows::Miss(why) => panic!("{why}"),
        }
    }
}

/// LR-10. In a gust of the model file the lag states of its downwash are states of every linear model, with and without a gust input: rows
/// during the gust and after it, when only the lag states remain.
#[test]
fn lr10_lags_of_the_own_gust() {
    let mut plant = Plant::new(Arc::new(shipped("models/goland_wing.toml")));
    plant.initialize(0.0).expect("a start");
    for end_s in [0.041, 0.1] {
        plant.step(end_s).expect("a run");
        let rows = linear_rows_agree_at(&mut plant);
        println!("LR-10 at {end_s} s: {rows:?}");
        assert!(matches!(rows, Rows::Agree(_)), "at {end_s} s: {rows:?}");
        let interface = Interface::new(plant.machine());
        let states = [&[][..], &[2][..]].map(|gusts| {
            let model =
                interface.linearize_in_gusts(&mut plant, &[], gusts, &[]).unwrap_or_else(|error| panic!("{error}"));
            model.states.into_iter().map(|state| (state.name, state.value)).collect::<Vec<_>>()
        });
        assert_eq!(states[0], states[1]);
        let of_gust = |(name, value): &&(String, f64)| name.contains(".gust_lag[") && *value != 0.0;
        // three lag terms on each of twelve strips
        assert_eq!(states[0].iter().filter(of_gust).count(), 36);
    }
}
