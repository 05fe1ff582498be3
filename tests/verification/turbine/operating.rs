//! Operating points of rotors: states steady in the rotor frame against simulations and OpenFAST, periodic motions with strips, the
//! Campbell diagram by Floquet theory compared with the Coleman transformation.

use crate::turbine::machine::*;
use crate::turbine::swing::Swing;
use crate::whole::is_whole;
use foldwing::aero::EndRule;
use foldwing::config;
use foldwing::machine::*;
use foldwing::plant::{Plant, Settled, Turn};
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::sync::Arc;

const RPM: f64 = PI / 30.0;

/// The text of the example with strain-based blades.
const STRAIN_TEXT: &str = include_str!("../../../examples/turbine/nrel_5mw_strain.toml");

/// A machine at a wind speed and a pitch angle, with its blades locked at this pitch.
fn pitched(mut machine: Machine, wind_m_s: f64, pitch_deg: f64) -> Machine {
    machine.air.as_mut().expect("air").wind_m_s = Vector3::new(wind_m_s, 0.0, 0.0);
    for blade in 1..=3 {
        let pitch = hinge_mut(&mut machine, &format!("pitch{blade}"));
        (pitch.motion, pitch.motor, pitch.start_angle_rad) =
            (JointMotion::Locked, Motor::default(), pitch_deg.to_radians());
    }
    machine
}

/// Steady state of a machine at a rotor speed.
fn settled(machine: &Machine, speed_rpm: f64) -> (Plant, Turn, Settled) {
    settled_in(machine, speed_rpm, 720)
}

fn settled_in(machine: &Machine, speed_rpm: f64, steps: usize) -> (Plant, Turn, Settled) {
    let (machine, turn) = Turn::of(machine, None, Some(speed_rpm * RPM), steps).expect("a turn");
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).expect("a start");
    let settled = plant.settle(&turn, 1e-7).unwrap_or_else(|error| panic!("{error}"));
    (plant, turn, settled)
}

fn is_steady(settled: &Settled) -> bool {
    matches!(settled, Settled::Steady)
}

/// WT-60. The steady flexible rotor as a function of wind speed, all rows of OpenFAST's map, bounds and their reasons as in WT-21; without
/// a simulation.
#[test]
fn wt60_steady_states_are_those_of_the_map() {
    let (names, rows) = table(include_str!("../../reference/turbine/openfast_aeromap_flexible.csv"));
    let of = |row: &[f64], name: &str| row[names.iter().position(|known| *known == name).expect("a column")];
    let mut machine = windy(&on_a_stand(WIND_TEXT));
    let AirOptions::Rotor(options) = &mut machine.air.as_mut().expect("air").parts[0].options else {
        panic!("a rotor")
    };
    (options.features.end_loads, options.features.aerodyn_compatible) = (EndRule::Stopped, true);
    let mut worst = [0.0f64; 4];
    for row in &rows {
        let (wind, speed, pitch) = (row[0], row[1], row[2]);
        let (plant, _, settled) = settled(&pitched(machine.clone(), wind, pitch), speed);
        assert!(is_steady(&settled), "{wind} m/s");
        let outputs = plant.outputs();
        let (air, tip) = (outputs.rotor()[0], outputs.modal()[0].deflection_m);
        // the torque that holds the shaft balances only the aerodynamic torque: the generator's table is not used
        let mut hinges =
            plant.machine().one_freedoms().map(|(body, _)| plant.machine().bodies[body].joint.name.as_str());
        let shaft = hinges.position(|name| name == "shaft").expect("a shaft");
        let holding_n_m = outputs.joints()[shaft].holding_torque_n_m;
        assert!((holding_n_m / air.torque_n_m + 1.0).abs() < 1e-6, "{wind} m/s: {holding_n_m} N m");
        let (sine, cosine) = pitch.to_radians().sin_cos();
        let (out, within) = (tip.z * cosine - tip.y * sine, -(tip.y * cosine + tip.z * sine));
        let own = [
            air.thrust_n / of(row, "RtFldFxh_N") - 1.0,
            air.torque_n_m / of(row, "RtFldMxh_Nm") - 1.0,
            (out - of(row, "OoPDefl1_m")) / 6.481,
            (within - of(row, "IPDefl1_m")) / 0.839,
        ];
        worst.iter_mut().zip(own).for_each(|(worst, own)| *worst = worst.max(own.abs()));
    }
    println!(
        "WT-60: {} rows, thrust {:.1e}, torque {:.1e}, tip {:.1e}, {:.1e}",
        rows.len(),
        worst[0],
        worst[1],
        worst[2],
        worst[3]
    );
    assert!(worst[0] < 2e-3 && worst[1] < 2e-3 && worst[2] < 3e-3 && worst[3] < 6e-3, "{worst:?}");
}

/// WT-61. A steady state persists: simulated for three seconds, tip and loads keep their values; with modal and beam blades, dynamic inflow
/// and stall, a pitch of 10°, counter-clockwise rotation, and gravity along the shaft. The drift is due to the steps of the simulation and
/// to the residual of the state, 1e-9 of the machine's length for deflections of a thousandth of it: 1e-8 of the values is allowed.
#[test]
fn wt61_steady_states_stay() {
    let modal = windy(&on_a_stand(WIND_TEXT));
    let beams = windy(&on_a_stand(STRAIN_TEXT));
    let mut lagging = windy(&on_a_stand(WIND_TEXT));
    let AirOptions::Rotor(options) = &mut lagging.air.as_mut().expect("air").parts[0].options else {
        panic!("a rotor")
    };
    options.features.dynamic_inflow = true;
    let mut falling = modal.clone();
    falling.gravity_m_s2 = Vector3::new(9.81, 0.0, 0.0);
    let cases = [
        ("modal", modal, 11.0, 12.1, 0.0),
        ("modal, pitched", windy(&on_a_stand(WIND_TEXT)), 16.0, 12.1, 10.0),
        ("beams", beams, 8.0, 9.16, 0.0),
        ("dynamic inflow", lagging, 8.0, 9.16, 0.0),
        ("gravity along the shaft", falling, 8.0, 9.16, 0.0),
    ];
    for (what, machine, wind, speed, pitch) in cases {
        let (mut plant, _, settled) = settled(&pitched(machine, wind, pitch), speed);
        assert!(is_steady(&settled), "{what}");
        let read = |plant: &Plant| {
            let outputs = plant.outputs();
            let (air, body) = (outputs.rotor()[0], outputs.modal()[0]);
            [air.thrust_n, air.torque_n_m, body.deflection_m.z, body.deflection_m.y, body.root.moment_n_m.y]
        };
        let begin = read(&plant);
        let mut worst = 0.0f64;
        for k in 1..=30 {
            plant.step(0.1 * f64::from(k)).expect("a step");
            let now = read(&plant);
            worst = begin.iter().zip(now).fold(worst, |worst, (a, b)| worst.max((a - b).abs() / a.abs().max(0.1)));
        }
        println!("WT-61 {what}: moves by {worst:.1e}");
        assert!(worst < 1e-8, "{what}: {worst:.1e}");
    }
}

/// WT-62. Causes of a periodic variation are detected: tilt under gravity, shear, wind from the side; a tower of equal stiffness in both
/// directions is none, nor is a stand. The means of the periodic motion differ from the steady state of the same rotor by less than the
/// amplitude.
#[test]
fn wt62_what_swings_is_noticed() {
    let stand = || windy(&on_a_stand(WIND_TEXT));
    let mut fallen = stand();
    fallen.gravity_m_s2 = Vector3::new(0.0, 0.0, -1e-3);
    let sheared = "[wind]\nreference_height_m = 90.0\nground_m = [0, 0, -90]\nshear_exponent = 1e-3\n\n[surface.blade]";
    let sheared = windy(&on_a_stand(WIND_TEXT).replace("[surface.blade]", sheared));
    let mut aside = pitched(stand(), 8.0, 0.0);
    aside.air.as_mut().expect("air").wind_m_s.y = 0.1;
    let (steady, ..) = settled(&pitched(stand(), 8.0, 0.0), 9.16);
    let reference = steady.outputs().rotor()[0].thrust_n;
    for (what, machine) in [
        ("gravity of 1e-4 g", pitched(fallen, 8.0, 0.0)),
        ("shear", pitched(sheared, 8.0, 0.0)),
        ("wind from the side", aside),
    ] {
        let (mut plant, turn, settled) = settled(&machine, 9.16);
        let Settled::Periodic(motion) = settled else { panic!("{what} is steady") };
        let mut thrust = Vec::new();
        let mut seen = |_: usize, plant: &mut Plant| {
            thrust.push(plant.outputs().rotor()[0].thrust_n);
            Ok(())
        };
        plant.trace(&turn, &motion, &mut seen).expect("a turn");
        let mean = thrust.iter().sum::<f64>() / thrust.len() as f64;
        println!("WT-62 {what}: {} turns, thrust {:+.1e}", motion.turns, mean / reference - 1.0);
        // shear and side wind of a thousandth change the thrust by as much
        assert!((mean / reference - 1.0).abs() < 2e-3, "{what}: {mean} N for {reference} N");
    }
}

/// A blade on a flap hinge that rotates about the vertical in a horizontal wind, with strips.
fn fan(wind_m_s: f64, rate_rad_s: f64) -> Machine {
    let text = format!(
        "name = \"fan\"\ngravity_m_s2 = [0, 0, -9.81]\n\
         [section.spar]\nshape = \"rectangle\"\nwidth_m = 0.2\nheight_m = 0.03\ndensity_kg_m3 = 1600\nyoungs_modulus_Pa = 60e9\npoisson_ratio = 0.3\n\
         [rigid_body.hub]\nmass_kg = 5.0\ninertia_kg_m2 = [1.0, 1.0, 1.0, 0, 0, 0]\n\
         [joint.shaft]\ntype = \"revolute\"\nparent = \"root\"\nchild = \"hub\"\naxis = [0, 0, 1]\nstart_rate_deg_s = {:?}\n\
         [body.blade]\nlength_m = 2.0\nsection = \"spar\"\nelements = 2\n\
         [joint.flap]\ntype = \"revolute\"\nparent = \"hub\"\nchild = \"blade\"\naxis = [0, 1, 0]\nparent_position_m = 0.0\n\
         spring = {{ stiffness_N_m_rad = 300.0 }}\n\
         [aerodynamics]\nmodel = \"strip\"\nwind_m_s = [0.0, {wind_m_s:?}, 0.0]\nstep_s = 4e-3\n\
         [surface.blade]\nbody = \"blade\"\nchord_m = 0.2\nelastic_axis_fraction = 0.25\nstrips = 6\nincidence_deg = 3.0\n",
        rate_rad_s.to_degrees()
    );
    config::parse(&text, "fan.toml").unwrap_or_else(|refused| panic!("{refused}"))
}

/// WT-63. A blade with strips, excited once per revolution by an edgewise wind: the motion found by shooting against a simulation from rest
/// with the same steps. Inboard the air speed is low and the lag states decay slowly, so the simulation approaches by only a fifth per
/// revolution: 3e-6 rad after 36, 1e-8 after 60. The motion found by shooting repeats to 1e-8 over six revolutions.
#[test]
#[ignore = "long; `make long` runs it"]
fn wt63_a_blade_in_strips() {
    let rate_rad_s = 12.0;
    let (machine, turn) = Turn::of(&fan(-6.0, rate_rad_s), Some("shaft"), None, 144).expect("a turn");
    let mut plant = Plant::new(Arc::new(machine.clone()));
    plant.initialize(0.0).expect("a start");
    let motion = plant.periodic(&turn, 1e-8).unwrap_or_else(|error| panic!("{error}"));
    let mut angles = Vec::new();
    let flap = place(&plant, "flap.angle");
    let mut seen = |_: usize, plant: &mut Plant| {
        angles.push(plant.free_state().0[flap]);
        Ok(())
    };
    plant.trace(&turn, &motion, &mut seen).expect("a turn");
    let mut plant = Plant::new(Arc::new(machine.clone()));
    plant.initialize(0.0).expect("a start");
    let turns = if is_whole() { 60.0 } else { 36.0 };
    plant.step(turn.period_s() * turns).expect("a march");
    let mut miss = 0.0f64;
    for (k, angle) in angles.iter().enumerate() {
        plant.step(turn.period_s() * (turns + k as f64 / 144.0)).expect("a step");
        miss = miss.max((plant.free_state().0[flap] - angle).abs());
    }
    let mean = angles[..144].iter().sum::<f64>() / 144.0;
    let swing = angles.iter().fold(f64::MIN, |a, b| a.max(*b)) - angles.iter().fold(f64::MAX, |a, b| a.min(*b));
    println!(
        "WT-63: mean {mean:.5} rad, swing {swing:.5} rad, off the march by {miss:.1e} rad; {} states, {} turns",
        motion.states, motion.turns
    );
    assert!(swing > 0.02, "the wind drives the blade: {swing}");
    assert!(miss < if is_whole() { 1e-7 } else { 1e-5 }, "{miss:.1e}");
    let mut again = Plant::new(Arc::new(machine));
    again.initialize(0.0).expect("a start");
    again.restore(&motion.start).expect("the begin");
    again.step(turn.period_s() * 6.0).expect("six turns");
    let leaves = (again.free_state().0[flap] - angles[0]).abs();
    assert!(leaves < 1e-8, "leaves by {leaves:.1e}");
}

/// WT-67. A run that does not begin at 0 s, from another azimuth: the motion over the revolution is the same as a function of azimuth. The
/// steps are the same, times have one digit less.
#[test]
fn wt67_a_turn_begins_at_any_time() {
    let swing = Swing {
        mass_kg: 50.0,
        inertia_kg_m2: 550.0,
        arm_m: 3.0,
        hinge_m: 0.3,
        spring_n_m_rad: 6000.0,
        damping_n_m_s_rad: 60.0,
        gravity_m_s2: 9.81,
        speed_rad_s: 1.2,
    };
    let over_the_turn = |start_s: f64| {
        let mut machine = swing.machine();
        machine.experiment.start_time_s = start_s;
        let (machine, turn) = Turn::of(&machine, Some("shaft"), Some(swing.speed_rad_s), 288).expect("a turn");
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(start_s).expect("a start");
        let motion = plant.periodic(&turn, 1e-9).expect("a motion");
        let lag = place(&plant, "lag.angle");
        let mut list = Vec::new();
        let mut seen = |_: usize, plant: &mut Plant| {
            list.push(plant.free_state().0[lag]);
            Ok(())
        };
        plant.trace(&turn, &motion, &mut seen).expect("a turn");
        list
    };
    let (one, other) = (over_the_turn(0.0), over_the_turn(5.0));
    let miss = one.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("WT-67: {miss:.1e} rad");
    assert!(miss < 1e-8, "{miss:.1e}");
}

/// WT-64. Without gravity, the Floquet modes of the rotor equal those by the Coleman transformation, at three speeds: exponents to the
/// error of 720 steps, 4e-6 for a motion at 6 Hz, with 1e-5 allowed; corresponding modes have the same name. The tower participates; the
/// shaft speed is prescribed in both. Floquet modes have at least 24 steps in a period: 720 per revolution resolve 12.57 rad/s at 4 rpm, and
/// the thirteenth mode has 12.65.
#[test]
#[ignore = "long; `make long` runs it"]
fn wt64_floquet_beside_coleman() {
    let mut machine = turbine();
    machine.gravity_m_s2 = Vector3::zeros();
    let speeds: &[f64] = if is_whole() { &[4.0, 8.0, 12.1, 18.0] } else { &[7.0, 12.1] };
    let mut worst = 0.0f64;
    for speed_rpm in speeds {
        let steps = if *speed_rpm < 5.0 { 1440 } else { 720 };
        let (mut plant, turn, settled) = settled_in(&machine, *speed_rpm, steps);
        assert!(is_steady(&settled), "{speed_rpm} rpm");
        let motion = plant.periodic(&turn, 1e-9).expect("a motion");
        assert_eq!(motion.newton_steps, 0, "the steady state is the motion");
        let floquet = plant.floquet(&turn, &motion, 120).expect("modes");
        let mut held = machine.clone();
        hinge_mut(&mut held, "shaft").motion = JointMotion::Locked;
        let mut coleman = Plant::new(Arc::new(held));
        let rotor = coleman.study().rotor(0.0, None).expect("a rotor");
        let modes = coleman.study().whirl_modes(0.0, &rotor, speed_rpm * RPM, 13).expect("modes");
        for mode in modes {
            let value = mode.eigenvalue_1_s;
            let near = |other: &&foldwing::plant::FloquetMode| (other.exponent_1_s - value).norm();
            let found = floquet.modes.iter().min_by(|a, b| near(a).total_cmp(&near(b))).expect("a mode");
            worst = worst.max(near(&found) / value.norm());
            let (own, other) = (mode.whirl[0].to_string(), found.parts[0].to_string());
            assert_eq!(own, other, "{speed_rpm} rpm, {value}");
        }
    }
    println!("WT-64: exponents off by {worst:.1e}");
    assert!(worst < 1e-5, "{worst:.1e}");
}

/// WT-65. The search for the rotor used to discard loads, wind and state. It leaves them unchanged, bit-identical.
#[test]
fn wt65_looking_for_the_rotor_changes_nothing() {
    let mut plant = Plant::new(Arc::new(windy(WIND_TEXT)));
    *plant.inputs_mut().wind_m_s_mut() = Vector3::new(9.0, 1.0, 0.0);
    plant.initialize(0.0).expect("a start");
    plant.step(0.5).expect("half a second");
    plant.inputs_mut().root_mut().gravity_m_s2.x = 0.3;
    let (before, thrust) = (plant.snapshot(), plant.outputs().rotor()[0].thrust_n);
    let shape = plant.shape();
    let rotor = plant.study().rotor(0.0, None).expect("a rotor");
    assert_eq!(rotor.blades(), 3);
    assert_eq!(plant.snapshot(), before);
    assert_eq!(plant.outputs().rotor()[0].thrust_n, thrust);
    assert_eq!(format!("{:?}", plant.shape()), format!("{shape:?}"), "where the bodies are");
    let refused = plant.study().rotor(0.0, Some("pitch1"));
    assert!(refused.is_err());
    assert_eq!(plant.snapshot(), before, "after an error too");
    plant.step(0.6).expect("it goes on");
}
