//! Effects of calls according to design and standard: values and their times, initialisation, rollback, reset.

use crate::fmu::{Attempt, Fmu, Resources, WING, table};
use foldwing::config;
use foldwing_fmu::derivatives::*;
use foldwing_fmu::functions::*;
use foldwing_fmu::states::*;
use foldwing_fmu::types::*;

const STEP_S: f64 = 1e-3;

/// Steps of 1 ms from `from` to `to` ms.
fn advance(fmu: &Fmu, from: usize, to: usize) {
    for i in from..to {
        fmu.step(i as f64 * STEP_S, STEP_S);
    }
}

#[test]
fn in_initialization_mode_a_get_evaluates_again() {
    let fmu = Fmu::initializing(0.0);
    let folded = fmu.get("tip.position.x");
    fmu.set("fold.start_angle", 0.0);
    let unfolded = fmu.get("tip.position.x");
    assert!((unfolded - 0.3).abs() < 1e-9 && folded < 0.1, "{folded} m, then {unfolded} m");
    fmu.set("fold.external_torque", 1e-3);
    let torque = fmu.get("fold.total_torque");
    fmu.set("fold.external_torque", 2e-3);
    assert!((fmu.get("fold.total_torque") - torque - 1e-3).abs() < 1e-12, "inputs act at once");
}

/// FMI 2.0 does not provide for reading between a set and the next step; importers that solve algebraic loops do it.
#[test]
fn between_steps_a_get_after_a_set_shows_the_inputs() {
    let fmu = Fmu::stepping();
    advance(&fmu, 0, 5);
    let felt = ["fold.total_torque", "root.force.z", "tip.acceleration.z", "gauge.root.strain", "energy.gravity"];
    let state = ["fold.angle", "tip.position.z", "tip.velocity.z", "energy.kinetic", "fold.latch_torque"];
    let (before, rest) = (felt.map(|name| fmu.get(name)), state.map(|name| fmu.get(name)));
    let inputs = [("fold.external_torque", 0.01), ("gravity.z", 3.0), ("load.outer[4].force.z", 0.1)];
    let own = inputs.map(|(name, _)| fmu.get(name));
    inputs.iter().for_each(|(name, value)| fmu.set(name, *value));
    let now = felt.map(|name| fmu.get(name));
    assert!((now[0] - before[0] - 0.01).abs() < 1e-15, "{now:?}");
    assert!(now.iter().zip(before).all(|(now, before)| *now != before), "{now:?}, {before:?}");
    assert_eq!(state.map(|name| fmu.get(name)), rest, "the state waits for the next step");
    inputs.iter().zip(own).for_each(|((name, _), value)| fmu.set(name, value));
    assert_eq!(felt.map(|name| fmu.get(name)), before);
    let other = Fmu::stepping();
    advance(&other, 0, 5);
    advance(&fmu, 5, 6);
    advance(&other, 5, 6);
    assert_eq!(felt.map(|name| fmu.get(name)), felt.map(|name| other.get(name)), "looking changes nothing");
}

#[test]
fn start_values_hold_before_initialisation_too() {
    let fmu = Fmu::new(WING);
    fmu.set("fold.start_angle", 0.5);
    fmu.set("body.outer.mass_factor", 2.0);
    fmu.setup(0.0, None);
    fmu.ok(unsafe { fmi2EnterInitializationMode(fmu.component) });
    assert_eq!(fmu.get("fold.angle"), 0.5);
    assert_eq!(fmu.get("body.outer.mass_factor"), 2.0);
}

#[test]
fn the_tolerance_of_the_experiment_wins_over_the_model_s() {
    let fmu = Fmu::new(WING);
    fmu.ok(unsafe { fmi2SetupExperiment(fmu.component, 1, 3e-6, 0.0, 0, 0.0) });
    fmu.ok(unsafe { fmi2EnterInitializationMode(fmu.component) });
    assert_eq!(fmu.get("solver.tolerance"), 3e-6);
    let model = Fmu::initializing(0.0);
    assert_ne!(model.get("solver.tolerance"), 3e-6, "without one the model's holds");
    // a tolerance set as a parameter has priority, before and after
    let before = Fmu::new(WING);
    before.set("solver.tolerance", 2e-5);
    before.ok(unsafe { fmi2SetupExperiment(before.component, 1, 3e-6, 0.0, 0, 0.0) });
    let after = Fmu::new(WING);
    after.ok(unsafe { fmi2SetupExperiment(after.component, 1, 3e-6, 0.0, 0, 0.0) });
    after.set("solver.tolerance", 2e-5);
    for fmu in [before, after] {
        fmu.ok(unsafe { fmi2EnterInitializationMode(fmu.component) });
        assert_eq!(fmu.get("solver.tolerance"), 2e-5);
    }
}

#[test]
fn a_later_start_only_shifts_the_time() {
    let early = Fmu::stepping();
    let late = Fmu::initializing(100.0);
    late.ok(unsafe { fmi2ExitInitializationMode(late.component) });
    for i in 0..150 {
        early.step(i as f64 * STEP_S, STEP_S);
        late.step(100.0 + i as f64 * STEP_S, STEP_S);
    }
    let (first, second) = (early.get("fold.latch_time"), late.get("fold.latch_time") - 100.0);
    assert!((first - second).abs() < 1e-6, "latched at {first} s and {second} s");
}

#[test]
fn reset_equals_fresh_and_frees_nothing() {
    let fmu = Fmu::stepping();
    let state = fmu.save();
    fmu.set("fold.motor_stiffness", 0.05);
    advance(&fmu, 0, 20);
    unsafe {
        fmu.ok(fmi2Reset(fmu.component));
        fmu.setup(0.0, None);
        fmu.ok(fmi2EnterInitializationMode(fmu.component));
        fmu.ok(fmi2ExitInitializationMode(fmu.component));
    }
    let fresh = Fmu::stepping();
    assert_eq!(fmu.bits(), fresh.bits());
    advance(&fmu, 0, 130);
    advance(&fresh, 0, 130);
    assert_eq!(fmu.bits(), fresh.bits());
    fmu.ok(unsafe { fmi2SetFMUstate(fmu.component, state) });
}

/// The step includes the closing of the latch (t = 0.122 s), where an incomplete state would show.
#[test]
fn a_restored_state_repeats_the_step_bit_for_bit() {
    let fmu = Fmu::stepping();
    advance(&fmu, 0, 121);
    fmu.set("fold.external_torque", 1e-3);
    let state = fmu.save();
    let before = fmu.bits();
    fmu.step(0.121, 5e-3);
    let first = fmu.bits();
    assert!(fmu.get_boolean("fold.latched"));
    for _ in 0..2 {
        fmu.ok(unsafe { fmi2SetFMUstate(fmu.component, state) });
        assert_eq!(fmu.bits(), before);
        fmu.step(0.121, 5e-3);
        assert_eq!(fmu.bits(), first);
    }
}

/// The shipped wing with a rigid latch: it closes at the time of the elastic one, holds the angle, and outputs its reaction in place of the
/// spring's torque; a state from before the closing leads through it again, also in another instance; the derivative of the reaction with
/// respect to the external torque is −1, and is among the declared dependencies.
#[test]
fn a_rigid_latch_through_the_c_functions() {
    let text = WING.replace("stiffness_ratio = 1e4", "kind = \"rigid\"");
    assert_ne!(text, WING);
    let (elastic, rigid) = (Fmu::stepping(), Fmu::new(&text));
    rigid.setup(0.0, None);
    rigid.ok(unsafe { fmi2EnterInitializationMode(rigid.component) });
    rigid.ok(unsafe { fmi2ExitInitializationMode(rigid.component) });
    let table = table(&text);
    assert!(table.find("fold.latch_stiffness").is_none());
    for fmu in [&elastic, &rigid] {
        advance(fmu, 0, 121);
    }
    let state = rigid.save();
    let bytes = rigid.serialize(state);
    for fmu in [&elastic, &rigid] {
        advance(fmu, 121, 150);
    }
    let (angle_rad, torque_n_m) = (rigid.get("fold.angle"), rigid.get("fold.latch_torque"));
    assert!((rigid.get("fold.latch_time") - elastic.get("fold.latch_time")).abs() < 2e-10);
    assert!(angle_rad.abs() <= 1e-6 && rigid.get("fold.angular_velocity") == 0.0 && rigid.get_boolean("fold.latched"));
    assert!(torque_n_m != 0.0 && rigid.get("fold.holding_torque") == 0.0 && rigid.get("fold.latch_impulse") > 0.0);
    let (unknown, known) = (rigid.reference("fold.latch_torque"), rigid.reference("fold.external_torque"));
    let dependencies = table.dependencies(&config::parse(&text, "model.toml").expect("valid"));
    let mut slope = f64::NAN;
    rigid.ok(unsafe { fmi2GetDirectionalDerivative(rigid.component, &unknown, 1, &known, 1, &1.0, &mut slope) });
    assert!((slope + 1.0).abs() < 1e-9, "{slope}");
    assert!(dependencies[unknown as usize].running.iter().any(|&(reference, _)| reference == known));
    let first = rigid.bits();
    rigid.ok(unsafe { fmi2SetFMUstate(rigid.component, state) });
    assert!(!rigid.get_boolean("fold.latched"));
    advance(&rigid, 121, 150);
    assert_eq!(rigid.bits(), first);
    let heir = Fmu::new(&text);
    let (status, state) = heir.deserialize(&bytes);
    heir.ok(status);
    heir.ok(unsafe { fmi2SetFMUstate(heir.component, state) });
    advance(&heir, 121, 150);
    assert_eq!(heir.bits(), first);
    heir.set_boolean("fold.latch_enable", false);
    advance(&heir, 150, 151);
    assert!(
        !heir.get_boolean("fold.latched")
            && heir.get("fold.latch_torque") == 0.0
            && heir.get("fold.angular_velocity") != 0.0
    );
}

#[test]
fn a_serialised_state_goes_on_in_another_instance_bit_for_bit() {
    let fmu = Fmu::stepping();
    advance(&fmu, 0, 121);
    let bytes = fmu.serialize(fmu.save());
    let heir = Fmu::new(WING);
    let (status, state) = heir.deserialize(&bytes);
    heir.ok(status);
    heir.ok(unsafe { fmi2SetFMUstate(heir.component, state) });
    assert_eq!(heir.bits(), fmu.bits());
    advance(&fmu, 121, 140);
    advance(&heir, 121, 140);
    assert_eq!(heir.bits(), fmu.bits());
    assert_eq!(heir.serialize(heir.save()), fmu.serialize(fmu.save()));
}

#[test]
fn a_state_saved_before_and_in_the_initialisation_can_be_restored() {
    let fmu = Fmu::new(WING);
    fmu.set("fold.start_angle", 1.0);
    let fresh = fmu.save();
    fmu.setup(0.0, None);
    fmu.ok(unsafe { fmi2EnterInitializationMode(fmu.component) });
    fmu.set("body.outer.stiffness_factor", 3.0);
    let initializing = fmu.save();
    fmu.ok(unsafe { fmi2ExitInitializationMode(fmu.component) });
    advance(&fmu, 0, 10);
    let first = fmu.bits();

    fmu.ok(unsafe { fmi2SetFMUstate(fmu.component, initializing) });
    fmu.ok(unsafe { fmi2ExitInitializationMode(fmu.component) });
    advance(&fmu, 0, 10);
    assert_eq!(fmu.bits(), first);

    fmu.ok(unsafe { fmi2SetFMUstate(fmu.component, fresh) });
    fmu.setup(0.0, None);
    fmu.ok(unsafe { fmi2EnterInitializationMode(fmu.component) });
    assert_eq!((fmu.get("fold.angle"), fmu.get("body.outer.stiffness_factor")), (1.0, 1.0));
}

/// The stop time is part of the state: a restored state has its stop time, whatever stop time the instance has been given since.
#[test]
fn a_restored_state_brings_its_stop_time() {
    let instance = |stop_s| {
        let fmu = Fmu::new(WING);
        fmu.setup(0.0, stop_s);
        unsafe {
            fmu.ok(fmi2EnterInitializationMode(fmu.component));
            fmu.ok(fmi2ExitInitializationMode(fmu.component));
        }
        fmu.step(0.0, STEP_S);
        fmu
    };
    let (short, endless) = (instance(Some(2e-3)), instance(None));
    let set = |to: &Fmu, from: &Fmu| {
        let (status, state) = to.deserialize(&from.serialize(from.save()));
        to.ok(status);
        to.ok(unsafe { fmi2SetFMUstate(to.component, state) });
    };
    let own = short.save();
    set(&short, &endless);
    short.step(STEP_S, 5e-3);
    short.ok(unsafe { fmi2SetFMUstate(short.component, own) });
    short.refused(short.try_step(STEP_S, 5e-3), fmi2Error, &["beyond the stop time 0.002 s"]);
    set(&endless, &short);
    endless.refused(endless.try_step(STEP_S, 5e-3), fmi2Error, &["beyond the stop time 0.002 s"]);
}

/// Components of a quaternion by their names, through the C functions: a body mounted with a rotation of 60° about `x` has `w = cos 30°`,
/// `x = sin 30°`, which identifies the order.
#[test]
fn quaternions_run_over_w_x_y_z() {
    let turned = WING.replace("[joint.mount]", "[joint.mount]\nmount_rotation_deg = [60, 0, 0]");
    assert_ne!(turned, WING);
    let fmu = Fmu::new(&turned);
    fmu.setup(0.0, None);
    unsafe {
        fmu.ok(fmi2EnterInitializationMode(fmu.component));
        fmu.ok(fmi2ExitInitializationMode(fmu.component));
    }
    let half = 30_f64.to_radians();
    for (component, expected) in [("w", half.cos()), ("x", half.sin()), ("y", 0.0), ("z", 0.0)] {
        let found = fmu.get(&format!("station.inner[1].rotation.{component}"));
        assert!((found - expected).abs() < 1e-14, "{component}: {found}, not {expected}");
    }
}

#[test]
fn a_state_handle_can_be_used_again() {
    let fmu = Fmu::stepping();
    let mut state = fmu.save();
    let handle = state;
    advance(&fmu, 0, 3);
    fmu.ok(unsafe { fmi2GetFMUstate(fmu.component, &mut state) });
    assert_eq!(state, handle, "overwritten in place");
    advance(&fmu, 3, 5);
    fmu.ok(unsafe { fmi2SetFMUstate(fmu.component, state) });
    assert_eq!(fmu.get("time"), 3e-3);
}

#[test]
fn interleaved_instances_equal_each_alone() {
    let alone = Fmu::stepping();
    advance(&alone, 0, 130);
    let (one, two) = (Fmu::stepping(), Fmu::stepping());
    two.set("fold.external_torque", 5e-3);
    for i in 0..130 {
        advance(&one, i, i + 1);
        advance(&two, i, i + 1);
    }
    assert_eq!(one.bits(), alone.bits());
    assert_ne!(two.bits(), alone.bits());
}

#[test]
fn many_instances_come_and_go() {
    let resources = Resources::with(WING);
    for _ in 0..200 {
        let (component, messages) = Attempt::of(WING, &resources).run();
        assert!(!component.is_null(), "{messages:?}");
        let mut state: fmi2FMUstate = std::ptr::null_mut();
        unsafe {
            assert_eq!(fmi2GetFMUstate(component, &mut state), fmi2OK);
            fmi2FreeInstance(component);
        }
    }
}
