//! DC-01 to DC-12 and DC-16 to DC-18: DC motors, whose currents are states, against the linear solution and by invariants.

use crate::agreement::agree;
use crate::linear_rows::compare::{Rows, linear_rows_agree};
use crate::plant::machines::{balance_j, hinge_of, start};
use foldwing::machine::{Machine, Method};
use foldwing::plant::{Branch, Holding, Hybrid, Plant, Search, Snapshot};
use nalgebra::{Matrix5, Vector5};

fn machine(text: &str) -> Machine {
    foldwing::config::parse(text, "model.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Inertia in kg·m², damping in N·m·s/rad, resistance in Ω, inductance in H, torque constant in N·m/A and gear ratio of a rotor on a hinge.
const ROTOR: [f64; 6] = [0.02, 0.003, 1.5, 4e-3, 0.05, 20.0];

/// A rigid rotor without gravity on a hinge with a motor and a damper; more keys of its tables.
fn rotor(hinge: &str, dc_motor: &str, tail: &str) -> String {
    let [inertia, damping, resistance, inductance, constant, ratio] = ROTOR;
    format!(
        "name = 'rotor'\ngravity_m_s2 = [0.0, 0.0, 0.0]\n[rigid_body.rotor]\nmass_kg = 1.0\n\
         inertia_kg_m2 = [{inertia}, {inertia}, {inertia}, 0.0, 0.0, 0.0]\n[joint.hinge]\ntype = 'revolute'\nparent = 'root'\nchild = 'rotor'\n\
         axis = [0.0, 0.0, 1.0]\n{hinge}\n[joint.hinge.spring]\ndamping_N_m_s_rad = {damping}\n[joint.hinge.motor]\n\
         gear_ratio = {ratio:?}\n[joint.hinge.dc_motor]\nresistance_ohm = {resistance}\ninductance_H = {inductance}\n\
         torque_constant_N_m_A = {constant}\n{dc_motor}\n{tail}"
    )
}

/// A second body on the rotor, on a tilted hinge with a motor.
const SECOND: &str = "[rigid_body.other]\nmass_kg = 1.0\ncentre_of_mass_m = [0.1, 0.0, 0.05]\ninertia_kg_m2 = [0.1, 0.12, 0.1, 0.0, 0.0, 0.0]\n\
     [joint.second]\ntype = 'revolute'\nparent = 'rotor'\nchild = 'other'\naxis = [0.0, 1.0, 0.5]\n[joint.second.dc_motor]\n\
     resistance_ohm = 1.0\ninductance_H = 0.01\ntorque_constant_N_m_A = 0.3\nvoltage_V = 2.0\n";

/// Angle, rate, current, voltage and rate of the voltage of [`rotor`] after a time: the exponential of the matrix of the linear equations.
fn solution(time_s: f64, start: [f64; 5]) -> Vector5<f64> {
    let [inertia, damping, resistance, inductance, constant, ratio] = ROTOR;
    let torque = constant * ratio;
    #[rustfmt::skip]
    let matrix = Matrix5::new(
        0.0, 1.0, 0.0, 0.0, 0.0,
        0.0, -damping / inertia, torque / inertia, 0.0, 0.0,
        0.0, -torque / inductance, -resistance / inductance, 1.0 / inductance, 0.0,
        0.0, 0.0, 0.0, 0.0, 1.0,
        0.0, 0.0, 0.0, 0.0, 0.0,
    );
    (matrix * time_s).exp() * Vector5::from(start)
}

/// Angle, rate and current of the first joint.
fn state(plant: &Plant) -> [f64; 3] {
    let (joint, motor) = (plant.outputs().joints()[0], plant.outputs().dc_motors()[0]);
    [joint.angle_rad, joint.rate_rad_s, motor.current_a]
}

/// Largest difference of angle, rate and current from the solution, relative to their largest values in the run: 4 rad, 12 rad/s, 8 A.
fn off(plant: &Plant, expected: &Vector5<f64>) -> f64 {
    let scales = [4.0, 12.0, 8.0];
    let found = state(plant);
    (0..3).map(|i| (found[i] - expected[i]).abs() / scales[i]).fold(0.0, f64::max)
}

/// DC-01. A rotor with a geared motor under a step of the voltage, 12 V, then under a ramp of −40 V/s as an input with a known rate: angle,
/// rate and current are those of the linear equations. The internal step follows from the tolerance in the kinematic norm.
#[test]
fn dc01_step_and_ramp_are_those_of_the_linear_equations() {
    let mut plant = start(machine(&rotor("", "voltage_V = 12.0", "[solver]\ntolerance = 1e-9\n")));
    let mut worst = 0.0f64;
    let mut expected = Vector5::from([0.0, 0.0, 0.0, 12.0, 0.0]);
    for k in 1..=20 {
        plant.step(0.005 * f64::from(k)).expect("a step");
        expected = solution(0.005 * f64::from(k), [0.0, 0.0, 0.0, 12.0, 0.0]);
        worst = worst.max(off(&plant, &expected));
    }
    let [torque, power] = [plant.outputs().dc_motors()[0].torque_n_m, plant.outputs().dc_motors()[0].power_w];
    let current_a = state(&plant)[2];
    assert!((torque - current_a).abs() < 1e-12 && (power - 12.0 * current_a).abs() < 1e-12, "K N is 1 N·m/A");
    for k in 1..=20 {
        plant.input_rates_mut().dc_motors_mut()[0].voltage_v = -40.0;
        plant.step(0.1 + 0.005 * f64::from(k)).expect("a step");
        let begin = [expected[0], expected[1], expected[2], 12.0, -40.0];
        worst = worst.max(off(&plant, &solution(0.005 * f64::from(k), begin)));
    }
    assert!((plant.inputs().dc_motors()[0].voltage_v - 8.0).abs() < 1e-12, "the ramp ends at 8 V");
    println!("DC-01 {worst:.1e} of the largest angle, rate and current in {} steps", plant.statistics().steps);
    agree("DC-01", worst, 2e-6);
}

/// DC-02. Convergence with the fixed step: each method has its order in the current too, which has no code of its own in any of them.
#[test]
fn dc02_methods_have_their_orders_in_the_current() {
    let expected = solution(0.05, [0.0, 0.0, 0.0, 12.0, 0.0]);
    for (method, name, order) in [
        (Method::GeneralizedAlpha, "generalised-alpha", 2.0),
        (Method::TrBdf2, "TR-BDF2", 2.0),
        (Method::Esdirk3, "ESDIRK3", 3.0),
        (Method::Esdirk4, "ESDIRK4", 4.0),
        (Method::Rk4, "Runge-Kutta", 4.0),
    ] {
        let error = |step_s: f64| {
            let mut own = machine(&rotor("", "voltage_V = 12.0", ""));
            own.solver.method = method;
            own.solver.fixed_step_s = Some(step_s);
            own.solver.tolerance = 1e-13;
            let mut plant = start(own);
            plant.step(0.05).expect("a step");
            (state(&plant)[2] - expected[2]).abs()
        };
        let [coarse, fine] = [2.5e-4, 1.25e-4].map(error);
        let found = (coarse / fine).log2();
        println!("DC-02 {name}: {coarse:.2e} A, {fine:.2e} A, order {found:.2}");
        assert!((found - order).abs() < 0.25, "{name}: order {found}");
    }
}

/// DC-03. The prismatic form: a slider of 2 kg with 30 N/A, at constant voltage, has the terminal velocity u/K and the thrust zero; at its
/// start, the current grows with u/L.
#[test]
fn dc03_a_linear_motor_reaches_its_no_load_velocity() {
    let text = "name = 'slider'\ngravity_m_s2 = [0.0, 0.0, 0.0]\n[rigid_body.slider]\nmass_kg = 2.0\n[joint.rail]\ntype = 'prismatic'\n\
                parent = 'root'\nchild = 'slider'\naxis = [1.0, 0.0, 0.0]\n[joint.rail.dc_motor]\nresistance_ohm = 4.0\n\
                inductance_H = 0.002\nforce_constant_N_A = 30.0\nvoltage_V = 24.0\n[solver]\ntolerance = 1e-9\n";
    let mut plant = start(machine(text));
    plant.step(1e-6).expect("a step");
    let first = plant.outputs().dc_motors()[0].current_a;
    // within 2e-3, R t/L, of which half is the decrease of the slope
    assert!((first - 24.0 / 0.002 * 1e-6).abs() < 2e-3 * first, "{first} A after 1 us");
    // the mechanical time constant is m R/K² = 8.9 ms
    plant.step(0.4).expect("a step");
    let joint = plant.outputs().joints()[0];
    assert!((joint.rate_rad_s - 0.8).abs() < 1e-6, "{} m/s", joint.rate_rad_s);
    assert!(plant.outputs().dc_motors()[0].torque_n_m.abs() < 1e-3, "{:?}", plant.outputs().dc_motors()[0]);
    assert_eq!(joint.torque_applied_n_m, plant.outputs().dc_motors()[0].torque_n_m);
}

/// A flexible arm under gravity with a geared motor, a damped position motor, an elastic latch and an end stop.
fn arm(dc_motor: &str) -> String {
    format!(
        "name = 'arm'\ngravity_m_s2 = [0.0, 0.0, -9.81]\n[section.s]\nshape = 'rectangle'\nwidth_m = 0.03\nheight_m = 0.004\n\
         density_kg_m3 = 2700.0\nyoungs_modulus_Pa = 7e10\npoisson_ratio = 0.33\n[body.arm]\nlength_m = 0.5\nsection = 's'\nelements = 4\n\
         stiffness_damping_s = 1e-4\n[joint.fold]\ntype = 'revolute'\nparent = 'root'\nchild = 'arm'\naxis = [0.0, -1.0, 0.0]\n\
         start_angle_deg = -60.0\n[joint.fold.motor]\nstiffness_N_m_rad = 0.1\ndamping_N_m_s_rad = 0.01\ninertia_kg_m2 = 0.002\n\
         gear_ratio = -50.0\n[joint.fold.dc_motor]\nresistance_ohm = 2.0\ninductance_H = 1e-3\ntorque_constant_N_m_A = 0.02\n{dc_motor}\n\
         [joint.fold.latch]\nangle_deg = 10.0\nstiffness_N_m_rad = 60.0\n[joint.fold.end_stops]\nlower_deg = -70.0\n\
         stiffness_N_m_rad = 80.0\ndamping_N_m_s_rad = 0.1\n[solver]\ntolerance = 1e-7\n"
    )
}

/// DC-04. Energy: electrical work less heat of the resistance, damping and latch is the change of kinetic, elastic, magnetic and potential
/// energy, under steps and ramps of the voltage, through the closing of a latch, with a negative gear ratio.
#[test]
fn dc04_energy_is_balanced_through_a_latch() {
    let mut plant = start(machine(&arm("voltage_V = -6.0")));
    let before_j = balance_j(plant.outputs());
    let mut largest_j = 0.0f64;
    for k in 1..=60 {
        if k == 20 {
            plant.inputs_mut().dc_motors_mut()[0].voltage_v = -14.0;
        }
        if (30..40).contains(&k) {
            plant.input_rates_mut().dc_motors_mut()[0].voltage_v = 100.0;
        }
        plant.step(0.01 * f64::from(k)).expect("a step");
        largest_j = largest_j.max(plant.outputs().energy().work.abs());
    }
    let drift_j = balance_j(plant.outputs()) - before_j;
    let energy = *plant.outputs().energy();
    println!("DC-04 {drift_j:.1e} J of {largest_j} J, {energy:?}");
    assert!(plant.outputs().latches()[0].time_s > 0.0, "the latch closes");
    assert!(largest_j > 1.0 && energy.dissipated > 0.5, "work and heat matter: {energy:?}");
    agree("DC-04", drift_j.abs() / largest_j, 2e-5);
}

/// DC-05. Rollback and saved states to the bit, in the middle of an internal step; the communication step does not change the run.
#[test]
fn dc05_saved_states_and_communication_steps_leave_the_run() {
    let text = arm("voltage_V = -9.0\nstart_current_A = 0.5");
    let mut plant = start(machine(&text));
    assert_eq!(plant.outputs().dc_motors()[0].current_a, 0.5);
    plant.step(0.0507).expect("a step");
    let snapshot = plant.snapshot();
    let bytes = postcard::to_stdvec(&snapshot).expect("serialises");
    let run_on = |plant: &mut Plant| {
        plant.step(0.09).expect("a step");
        plant.inputs_mut().dc_motors_mut()[0].voltage_v = 3.0;
        plant.step(0.2).expect("a step");
        plant.outputs().values().iter().map(|value| value.to_bits()).collect::<Vec<_>>()
    };
    let first = run_on(&mut plant);
    plant.restore(&snapshot).expect("the same machine");
    assert_eq!(run_on(&mut plant), first, "after a rollback");
    let mut other = start(machine(&text));
    let saved: Snapshot = postcard::from_bytes(&bytes).expect("deserialises");
    other.restore(&saved).expect("the same machine");
    assert_eq!(run_on(&mut other), first, "in another instance");

    let end = |step_s: f64| {
        let mut plant = start(machine(&text));
        let steps = (0.2 / step_s).round() as usize;
        (1..=steps).for_each(|k| plant.step(0.2 * k as f64 / steps as f64).expect("a step"));
        state(&plant)
    };
    let [whole, short] = [0.2, 1e-3].map(end);
    let worst = (0..3).map(|i| (whole[i] - short[i]).abs()).fold(0.0, f64::max);
    // times are rounded differently
    assert!(worst < 1e-10, "{worst:e}");
}

/// DC-06. A locked joint: its current follows u/R (1 − exp(−R t/L)), and the lock bears the torque in addition to the weight.
#[test]
fn dc06_the_current_of_a_locked_joint_goes_on() {
    let mut plant = start(machine(&rotor("release = false", "voltage_V = 12.0", "[solver]\ntolerance = 1e-9\n")));
    plant.step(0.004).expect("a step");
    let expected_a = 12.0 / 1.5 * (1.0 - (-1.5f64 * 0.004 / 4e-3).exp());
    let [angle_rad, rate_rad_s, current_a] = state(&plant);
    assert_eq!([angle_rad, rate_rad_s], [0.0, 0.0]);
    assert!((current_a - expected_a).abs() < 2e-6 * expected_a, "{current_a} A for {expected_a} A");
    // K N = 1 N·m/A
    let holding_n_m = plant.outputs().joints()[0].holding_torque_n_m;
    assert!((holding_n_m + current_a).abs() < 1e-12, "{holding_n_m} N·m");
    plant.inputs_mut().joints_mut()[0].release = true.into();
    plant.step(0.1).expect("a step");
    assert!(state(&plant)[1] > 5.0, "{:?}", state(&plant));
}

/// DC-07. Static equilibrium: the current is u/R, and its torque balances the spring and the weight; it is a state of rest, which a run
/// keeps, stable, and without a zero frequency of the charge. The load path scales the voltage.
#[test]
fn dc07_equilibrium_has_the_stall_current() {
    let text = rotor("", "voltage_V = 6.0", "")
        .replace("damping_N_m_s_rad = 0.003", "damping_N_m_s_rad = 0.003\nstiffness_N_m_rad = 8.0");
    let mut plant = Plant::new(std::sync::Arc::new(machine(&text)));
    plant.study().equilibrium(0.0, Holding::AsReleased).expect("an equilibrium");
    let [angle_rad, rate_rad_s, current_a] = state(&plant);
    assert!((angle_rad - 4.0 / 8.0).abs() < 1e-12 && rate_rad_s == 0.0 && current_a == 4.0, "{:?}", state(&plant));
    assert!(plant.is_at_rest());
    let stability = plant.study().stability().expect("a verdict");
    assert!(stability.is_stable() && !stability.neutral, "{stability:?}");
    let modes = plant.study().modes(3).expect("modes");
    println!("DC-07 modes {:?}", modes.iter().map(|mode| mode.eigenvalue_1_s).collect::<Vec<_>>());
    assert!(
        !modes.is_empty() && modes.iter().all(|mode| mode.eigenvalue_1_s.norm() > 1.0),
        "no motion without stiffness"
    );
    plant.step(0.5).expect("a step");
    assert!((state(&plant)[0] - 0.5).abs() < 1e-9 && (state(&plant)[2] - 4.0).abs() < 1e-8, "{:?}", state(&plant));
}

/// DC-16. A run that starts in equilibrium has the current u/R from its first instant on, on a free, a held and a latched joint; one that
/// starts unstrained has the current of the file.
#[test]
fn dc16_runs_from_equilibrium_start_with_the_stall_current() {
    let joints = ["", "release = false", "latch = { stiffness_N_m_rad = 500.0, initially_closed = true }"];
    for (start, current_a) in [("equilibrium", 4.0), ("unstrained", 0.5)] {
        for joint in joints {
            let tail = format!("[simulation]\nstart = '{start}'\n");
            let text = rotor(joint, "voltage_V = 6.0\nstart_current_A = 0.5", &tail)
                .replace("damping_N_m_s_rad = 0.003", "damping_N_m_s_rad = 0.003\nstiffness_N_m_rad = 8.0");
            let mut plant = Plant::new(std::sync::Arc::new(machine(&text)));
            plant.initialize(0.0).expect("a start");
            assert_eq!(state(&plant)[2], current_a, "{start} {joint}");
            plant.step(0.05).expect("a step");
            // R/L = 375 1/s, unless the joint moves: a free joint starts at its start angle, which is not that of its equilibrium
            let rests = state(&plant)[1].abs() < 1e-9;
            assert!(rests || joint.is_empty() || start == "unstrained", "{start} {joint}: {:?}", state(&plant));
            if rests {
                let expected = 4.0 + (current_a - 4.0) * (-375.0_f64 * 0.05).exp();
                assert!((state(&plant)[2] - expected).abs() < 1e-7, "{start} {joint}: {:?}", state(&plant));
            }
        }
    }
}

/// Equilibrium of a model with one joint as released: its coordinate, and whether its latch is closed.
fn rest_of(text: &str) -> Result<(f64, bool), String> {
    let mut plant = Plant::new(std::sync::Arc::new(machine(text)));
    plant.study().equilibrium(0.0, Holding::AsReleased).map_err(|error| error.to_string())?;
    let latched = plant.outputs().latches().iter().any(|latch| latch.closed.is_on());
    Ok((plant.outputs().joints()[0].angle_rad, latched))
}

/// DC-17. Static equilibrium of joints without stiffness that a motor pushes against an elastic latch, a rigid latch and an end stop, from
/// starts far from them and at the stop: closed form. A latch behind a position of balance is not reached.
#[test]
fn dc17_motors_push_joints_against_latches_and_stops() {
    let arm = |start_deg: f64, volts: f64, latch: &str| {
        format!(
            "name = 'arm'\ngravity_m_s2 = [0.0, 0.0, -9.80665]\n[rigid_body.arm]\nmass_kg = 0.5\ncentre_of_mass_m = [0.1, 0.0, 0.0]\n\
             inertia_kg_m2 = [0.001, 0.002, 0.002, 0.0, 0.0, 0.0]\n[joint.f]\ntype = 'revolute'\nparent = 'root'\nchild = 'arm'\n\
             axis = [0.0, 1.0, 0.0]\nstart_angle_deg = {start_deg:?}\nlatch = {{ {latch} }}\n[joint.f.dc_motor]\n\
             resistance_ohm = 2.0\ninductance_H = 1e-3\ntorque_constant_N_m_A = 0.5\nvoltage_V = {volts:?}\n"
        )
    };
    // 3 N·m of the motor and the weight against the latch at 0: −400 θ − 3 + m g x cos θ = 0
    let torque = 0.5 * 9.80665 * 0.1;
    let mut expected = -0.006;
    for _ in 0..50 {
        expected = (torque * f64::cos(expected) - 3.0) / 400.0;
    }
    for start_deg in [1.0, 60.0, 140.0] {
        let (angle_rad, latched) =
            rest_of(&arm(start_deg, -12.0, "stiffness_N_m_rad = 400.0")).expect("an equilibrium");
        assert!(latched && (angle_rad - expected).abs() < 1e-10, "{start_deg}: {angle_rad} {expected}");
    }
    let rigid = rest_of(&arm(60.0, -12.0, "kind = 'rigid', capture_deg = 2.0")).expect("an equilibrium");
    assert!(rigid.1 && (rigid.0 - 2.0_f64.to_radians()).abs() < 1e-12, "{rigid:?}");
    // the weight turns the arm from 60° towards 90°, where it balances, before the latch at 150°
    let beyond = rest_of(&arm(60.0, 0.0, "stiffness_N_m_rad = 400.0, angle_deg = 150.0"));
    assert!(
        beyond
            .as_ref()
            .map_or(true, |(angle_rad, latched)| !latched && (angle_rad - 0.5 * std::f64::consts::PI).abs() < 1e-9),
        "{beyond:?}"
    );
    let car = |start_m: f64, volts: f64| {
        format!(
            "name = 'car'\n[rigid_body.car]\nmass_kg = 2.0\n[joint.s]\ntype = 'prismatic'\nparent = 'root'\nchild = 'car'\n\
             axis = [1.0, 0.0, 0.0]\nstart_position_m = {start_m:?}\n[joint.s.dc_motor]\nresistance_ohm = 2.0\ninductance_H = 0.01\n\
             force_constant_N_A = 5.0\nvoltage_V = {volts:?}\n[joint.s.end_stops]\nlower_m = -1.0\nupper_m = 1.0\nstiffness_N_m = 1e4\n"
        )
    };
    for (start_m, volts, expected_m) in
        [(0.0, 12.0, 1.003), (1.0, 12.0, 1.003), (0.5, -12.0, -1.003), (-1.0, -8.0, -1.002)]
    {
        let (position_m, _) = rest_of(&car(start_m, volts)).expect("an equilibrium");
        assert!((position_m - expected_m).abs() < 1e-12, "{start_m} {volts}: {position_m}");
    }
    assert!(rest_of(&car(0.0, 0.0)).expect_err("no force").contains("no stiffness resists a motion"));
    // the arm at 60° beside a car that is stopped at its end: the latch at 300°, behind the balance of the weight at 90°, stays open
    let balanced = arm(60.0, 0.0, "stiffness_N_m_rad = 400.0, angle_deg = 300.0");
    let mut beside =
        Plant::new(std::sync::Arc::new(machine(&(balanced + &car(0.0, 12.0).replacen("name = 'car'\n", "", 1)))));
    beside.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    let [arm, car] = [0, 1].map(|joint| beside.outputs().joints()[joint].angle_rad);
    assert!((arm - 0.5 * std::f64::consts::PI).abs() < 1e-9 && (car - 1.003).abs() < 1e-9, "{arm} {car}");
}

/// DC-18. A motor in the air of a lattice: the equilibrium is found, its stability is not assessed, with the reason.
#[test]
fn dc18_equilibrium_in_a_lattice_has_no_verdict() {
    let text = "name = 'lattice'\n[section.p]\nshape = 'rectangle'\nwidth_m = 0.1\nheight_m = 0.004\nmaterial = 'aluminium 7075-T6'\n\
        [body.b]\nlength_m = 0.3\nsection = 'p'\nelements = 1\n[joint.f]\ntype = 'revolute'\nparent = 'root'\nchild = 'b'\n\
        axis = [0.0, -1.0, 0.0]\nspring = { stiffness_N_m_rad = 20.0 }\n[joint.f.dc_motor]\nresistance_ohm = 5.0\ninductance_H = 5e-3\n\
        torque_constant_N_m_A = 0.5\nvoltage_V = 2.0\n[surface.b]\nbody = 'b'\nstrips = 3\nincidence_deg = 2.0\n\
        [aerodynamics]\nmodel = 'uvlm'\nwind_m_s = [0.0, -15.0, 0.0]\n";
    let mut plant = Plant::new(std::sync::Arc::new(machine(text)));
    let search = Search { branch: Branch::Stable, ..Search::default() };
    let rest = plant.study().rest(0.0, Holding::AsReleased, search).expect("an equilibrium");
    let cause = rest.stability.and_then(|stability| stability.not_judged).expect("no verdict");
    assert!(cause.contains("dc_motor of joint \"f\"") && cause.contains("discrete time"), "{cause}");
    assert!((state(&plant)[2] - 0.4).abs() < 1e-12 && plant.is_at_rest());
}

/// DC-08. Linear models: the poles are those of the two-pole form and an integrator of the angle, the current is one state; every row of the
/// four matrices agrees with differences, for the rotor, a flexible arm and a wing in strips.
#[test]
fn dc08_linear_models_have_the_current_as_a_state() {
    let mut plant = start(machine(&rotor("", "voltage_V = 12.0", "")));
    plant.step(0.01).expect("a step");
    let a = plant.study().state_space(&[], &|_| nalgebra::DVector::zeros(0)).expect("a linear model").a;
    assert_eq!(a.nrows(), 3, "angle, rate, current");
    let [inertia, damping, resistance, inductance, constant, ratio] = ROTOR;
    let [sum, product] = [
        -(damping / inertia + resistance / inductance),
        (damping * resistance + (constant * ratio).powi(2)) / (inertia * inductance),
    ];
    assert!((a.trace() / sum - 1.0).abs() < 1e-12, "{a}");
    let minor = a[(1, 1)] * a[(2, 2)] - a[(1, 2)] * a[(2, 1)];
    assert!((minor / product - 1.0).abs() < 1e-12 && a.determinant().abs() < 1e-10 * product, "{a}");

    let wing = "[aerodynamics]\nmodel = 'strip'\ndensity_kg_m3 = 1.2\nwind_m_s = [0.0, -9.0, 0.5]\nstep_s = 2e-3\n[surface.arm]\n\
                body = 'arm'\nstrips = 4\n";
    for (name, text) in [
        ("rotor", rotor("start_rate_deg_s = 50.0", "voltage_V = 12.0\nstart_current_A = 2.0", "")),
        ("locked rotor beside a free one", {
            let own = rotor("release = false", "voltage_V = 12.0", "");
            own + SECOND
        }),
        ("arm", arm("voltage_V = -6.0\nstart_current_A = -1.0")),
        ("arm in air", arm("voltage_V = -6.0\nstart_current_A = -1.0") + wing),
    ] {
        match linear_rows_agree(&machine(&text)) {
            Rows::Agree(worst) => println!("DC-08 {name}: {worst:.1e}"),
            other => panic!("{name}: {other:?}"),
        }
    }
}

/// DC-09. Under an external integrator the current is a continuous state with its derivative, the charge is none: Runge–Kutta with
/// 20 µs, with a step of the voltage between two of its steps, agrees with the internal integrator; two motors on two coupled joints.
#[test]
fn dc09_an_external_integrator_finds_the_same_run() {
    let text = rotor("start_rate_deg_s = 60.0", "voltage_V = 6.0", "[solver]\ntolerance = 1e-9\n") + SECOND;
    let mut own = start(machine(&text));
    own.step(0.02).expect("a step");
    own.inputs_mut().dc_motors_mut()[0].voltage_v = -9.0;
    own.step(0.04).expect("a step");

    let mut plant = start(machine(&text));
    assert_eq!(plant.exchange_currents(), ["hinge.current", "second.current"]);
    assert_eq!(plant.coordinates(), 4, "two angles and two charges");
    let mut hybrid = plant.hybrid().expect("a hybrid system");
    assert_eq!(hybrid.states(), 6, "two pairs and two currents");
    let mut states = vec![0.0; hybrid.states()];
    hybrid.read(&mut states);
    let step_s = 2e-5;
    for k in 0..2000 {
        if k == 1000 {
            hybrid.system_mut().inputs_mut().dc_motors_mut()[0].voltage_v = -9.0;
            hybrid.follow_inputs();
        }
        states = runge_kutta(&mut hybrid, f64::from(k) * step_s, step_s, &states);
        hybrid.complete();
    }
    hybrid.set(0.04, &states);
    let found = hybrid.outputs();
    let mut worst = 0.0f64;
    for k in 0..2 {
        let (joint, due) = (found.joints()[k], own.outputs().joints()[k]);
        let (motor, due_motor) = (found.dc_motors()[k], own.outputs().dc_motors()[k]);
        worst =
            worst.max((joint.angle_rad - due.angle_rad).abs()).max((joint.rate_rad_s - due.rate_rad_s).abs() / 10.0);
        worst = worst.max((motor.current_a - due_motor.current_a).abs() / 3.0);
    }
    println!("DC-09 {worst:.1e}, {:?}", found.dc_motors());
    agree("DC-09", worst, 2e-6);
}

fn runge_kutta(hybrid: &mut Hybrid, time_s: f64, step_s: f64, begin: &[f64]) -> Vec<f64> {
    let (mut end, mut slope) = (begin.to_vec(), vec![0.0; begin.len()]);
    for (place, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
        let at: Vec<f64> = begin.iter().zip(&slope).map(|(x, slope)| x + place * step_s * slope).collect();
        hybrid.set(time_s + place * step_s, &at);
        hybrid.derivatives(&mut slope).expect("derivatives");
        end.iter_mut().zip(&slope).for_each(|(x, slope)| *x += weight / 6.0 * step_s * slope);
    }
    end
}

/// DC-10. Motors with closed loops: the four-bar linkage with its motor replaced by an electrical one, closed by penalties and rigidly,
/// balances its energy, and both forms agree to the compliance of the penalties.
#[test]
fn dc10_motors_drive_closed_loops() {
    let text = include_str!("../../../examples/models/four_bar.toml");
    let electric = text.replacen(
        "[joint.motor.motor]\nconstant_torque_N_m = -1.0\ndamping_N_m_s_rad = 0.1\n",
        "[joint.motor.dc_motor]\nresistance_ohm = 0.5\ninductance_H = 2e-3\ntorque_constant_N_m_A = 0.2\nvoltage_V = 2.5\n",
        1,
    );
    assert_ne!(electric, text, "the model has this motor");
    let run = |rigid: bool| {
        let mut own = machine(&electric);
        own.solver.tolerance = 1e-7;
        own.closures.iter_mut().for_each(|closure| closure.rigid = rigid);
        let mut plant = start(own);
        let before_j = balance_j(plant.outputs());
        (1..=40).for_each(|k| plant.step(0.01 * f64::from(k)).expect("a step"));
        let drift_j = balance_j(plant.outputs()) - before_j;
        let work_j = plant.outputs().energy().work;
        println!("DC-10 rigid {rigid}: {drift_j:.1e} J of {work_j} J, {:?}", state(&plant));
        let allowed = if rigid { 3e-6 } else { 3e-5 };
        agree(if rigid { "DC-10 rigid" } else { "DC-10 penalty" }, drift_j.abs() / work_j, allowed);
        state(&plant)
    };
    let [penalty, rigid] = [false, true].map(run);
    for (found, due) in penalty.iter().zip(rigid) {
        assert!((found - due).abs() < 2e-3 * due.abs().max(1.0), "{penalty:?} {rigid:?}");
    }
}

/// DC-11. Messages: every analysis and combination without the current names the joint, and what to do instead.
#[test]
fn dc11_what_is_not_covered_is_refused_by_name() {
    let mut own = machine(&rotor("", "voltage_V = 12.0", ""));
    let mut plant = start(own.clone());
    hinge_of(&mut own, 0).dc_motor.as_mut().expect("a motor").inductance_h = 0.0;
    let faults = own.validate().iter().map(ToString::to_string).collect::<String>();
    assert!(faults.contains("without inductance the motor is a damper"), "{faults}");
    let refused = plant.study().rotor(0.0, None).expect_err("no rotor analysis").to_string();
    assert!(
        refused.contains("joint \"hinge\"") && refused.contains("omit the table [joint.hinge.dc_motor]"),
        "{refused}"
    );
    for (from, to, part) in [
        ("inductance_H = 0.004", "inductance_H = 0.0", "a finite inductance > 0 H"),
        ("inductance_H = 0.004", "inductance_H = -1.0", "a finite inductance > 0 H"),
        ("resistance_ohm = 1.5", "resistance_ohm = 0.0", "resistance"),
        ("torque_constant_N_m_A = 0.05", "", "a finite torque constant > 0 N·m/A"),
        ("torque_constant_N_m_A = 0.05", "force_constant_N_A = 0.05", "torque_constant_N_m_A instead"),
        ("axis = ", "motion = 'locked'\naxis = ", "a dc_motor only with motion = \"free\""),
        (
            "[solver]",
            "[failure.lost]\nkind = 'motor_loss'\njoint = 'hinge'\nat_time_s = 1.0\n[solver]",
            "a joint without dc_motor",
        ),
    ] {
        let text = rotor("", "voltage_V = 12.0", "[solver]\ntolerance = 1e-6\n");
        assert!(text.contains(from), "{from}");
        let error = foldwing::config::parse(&text.replacen(from, to, 1), "model.toml").expect_err(to).to_string();
        assert!(error.contains(part), "{to}: {error}");
    }
}

/// DC-12. Rates of the outputs in time along a step and at the start, and directional derivatives by the voltage.
#[test]
fn dc12_outputs_have_their_rates() {
    let mut plant = start(machine(&rotor("", "voltage_V = 12.0", "[solver]\ntolerance = 1e-9\n")));
    // at the start di/dt = u/L, and the torque grows with K N u/L
    let rates = plant.study().output_rates();
    assert!((rates.dc_motors()[0].current_a - 3000.0).abs() < 1e-6, "{:?}", rates.dc_motors()[0]);
    assert!((rates.dc_motors()[0].torque_n_m - 3000.0).abs() < 1e-6);
    assert!((rates.joints()[0].torque_applied_n_m - 3000.0).abs() < 1e-6, "{:?}", rates.joints()[0]);
    plant.step(0.01).expect("a step");
    let rates = plant.study().output_rates();
    let [_, rate_rad_s, current_a] = state(&plant);
    let slope_a_s = (12.0 - 1.5 * current_a - rate_rad_s) / 4e-3;
    // quartics through five times of an internal step
    assert!(
        (rates.dc_motors()[0].current_a - slope_a_s).abs() < 1e-3 * slope_a_s.abs(),
        "{slope_a_s} {:?}",
        rates.dc_motors()[0]
    );
    let response = plant
        .study()
        .output_response(&|inputs, amount| inputs.dc_motors_mut()[0].voltage_v += amount)
        .expect("derivatives");
    assert!((response.dc_motors()[0].power_w - current_a).abs() < 1e-12, "{:?}", response.dc_motors()[0]);
    assert_eq!([response.dc_motors()[0].current_a, response.joints()[0].rate_rad_s], [0.0, 0.0]);
}
