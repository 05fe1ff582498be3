//! Optional capabilities through the C functions: their effects, their errors, and a test for every flag of the model description.

use crate::fmu::{Fmu, WING};
use foldwing::config;
use foldwing::interface::guid;
use foldwing::packaging::{Kinds, model_description};
use foldwing_fmu::derivatives::*;
use foldwing_fmu::functions::*;
use foldwing_fmu::states::*;
use foldwing_fmu::types::*;
use std::ptr;

fn set_rate(fmu: &Fmu, name: &str, order: i32, value: f64) -> fmi2Status {
    unsafe { fmi2SetRealInputDerivatives(fmu.component, &fmu.reference(name), 1, &order, &value) }
}

fn rate(fmu: &Fmu, name: &str, order: i32) -> (fmi2Status, f64) {
    let mut value = f64::NAN;
    let status = unsafe { fmi2GetRealOutputDerivatives(fmu.component, &fmu.reference(name), 1, &order, &mut value) };
    (status, value)
}

fn derivative(fmu: &Fmu, unknown: &str, known: &str, seed: f64) -> (fmi2Status, f64) {
    let mut value = f64::NAN;
    let (unknown, known) = (fmu.reference(unknown), fmu.reference(known));
    let status = unsafe { fmi2GetDirectionalDerivative(fmu.component, &unknown, 1, &known, 1, &seed, &mut value) };
    (status, value)
}

/// Input derivatives may also be set before initialisation; they apply to the first step only.
#[test]
fn input_derivatives_hold_for_the_next_step() {
    let fmu = Fmu::new(WING);
    fmu.ok(set_rate(&fmu, "fold.external_torque", 1, 2.0));
    fmu.setup(0.0, None);
    unsafe {
        fmu.ok(fmi2EnterInitializationMode(fmu.component));
        fmu.ok(fmi2ExitInitializationMode(fmu.component));
    }
    fmu.step(0.0, 1e-3);
    let [stiffness, damping, constant] =
        ["motor_stiffness", "motor_damping", "motor_constant_torque"].map(|name| fmu.get(&format!("fold.{name}")));
    let drive = stiffness * fmu.get("fold.angle") + damping * fmu.get("fold.angular_velocity") + constant;
    let external = fmu.get("fold.total_torque") + drive;
    assert!((external - 2e-3).abs() < 1e-15, "{external} N.m, but for round-off of 0.1 N.m");
    assert_eq!(fmu.get("fold.external_torque"), 2e-3);
    fmu.step(1e-3, 1e-3);
    assert_eq!(fmu.get("fold.external_torque"), 2e-3);
}

#[test]
fn input_derivatives_are_part_of_the_state() {
    let fmu = Fmu::stepping();
    fmu.step(0.0, 1e-3);
    fmu.ok(set_rate(&fmu, "load.outer[4].force.z", 1, 5.0));
    let state = fmu.save();
    let bytes = fmu.serialize(state);
    fmu.step(1e-3, 1e-3);
    let first = fmu.bits();
    fmu.ok(unsafe { fmi2SetFMUstate(fmu.component, state) });
    fmu.step(1e-3, 1e-3);
    assert_eq!(fmu.bits(), first);
    let other = Fmu::stepping();
    let (status, state) = other.deserialize(&bytes);
    other.ok(status);
    other.ok(unsafe { fmi2SetFMUstate(other.component, state) });
    other.step(1e-3, 1e-3);
    assert_eq!(other.bits(), first);
}

#[test]
fn bad_input_derivatives_are_refused_and_change_nothing() {
    let fmu = Fmu::stepping();
    let c = fmu.component;
    let plain = Fmu::stepping();
    fmu.refused(set_rate(&fmu, "fold.angle", 1, 1.0), fmi2Error, &["fold.angle", "only Real inputs"]);
    fmu.refused(
        set_rate(&fmu, "fold.motor_stiffness", 1, 1.0),
        fmi2Error,
        &["fold.motor_stiffness", "only Real inputs"],
    );
    fmu.refused(set_rate(&fmu, "fold.release", 1, 1.0), fmi2Error, &["fold.release", "Boolean, not Real"]);
    fmu.refused(set_rate(&fmu, "fold.external_torque", 2, 1.0), fmi2Error, &["fold.external_torque", "order 2"]);
    fmu.refused(set_rate(&fmu, "fold.external_torque", 0, 1.0), fmi2Error, &["order 0"]);
    fmu.refused(
        set_rate(&fmu, "fold.external_torque", 1, f64::NAN),
        fmi2Discard,
        &["der(fold.external_torque)", "NaN"],
    );
    let torque = fmu.reference("fold.external_torque");
    unsafe {
        let batch = [torque, 99_999];
        let status = fmi2SetRealInputDerivatives(c, batch.as_ptr(), 2, [1, 1].as_ptr(), [1.0, 1.0].as_ptr());
        fmu.refused(status, fmi2Error, &["unknown value reference 99999"]);
        fmu.refused(fmi2SetRealInputDerivatives(c, ptr::null(), 1, &1, &1.0), fmi2Error, &["vr is null"]);
        fmu.refused(fmi2SetRealInputDerivatives(c, &torque, 1, ptr::null(), &1.0), fmi2Error, &["order is null"]);
        fmu.refused(fmi2SetRealInputDerivatives(c, &torque, 1, &1, ptr::null()), fmi2Error, &["value is null"]);
        fmu.ok(fmi2SetRealInputDerivatives(c, ptr::null(), 0, ptr::null(), ptr::null()));
    }
    fmu.step(0.0, 1e-3);
    plain.step(0.0, 1e-3);
    assert_eq!(fmu.bits(), plain.bits());
}

#[test]
fn output_derivatives_are_those_of_the_motion() {
    let fmu = Fmu::stepping();
    fmu.step(0.0, 0.05);
    let before = fmu.bits();
    for (value, of) in [("fold.angular_velocity", "fold.angle"), ("tip.velocity.x", "tip.position.x")] {
        let (status, slope) = rate(&fmu, of, 1);
        fmu.ok(status);
        // between the ends of a step angles and rates are interpolated separately, NOTATION (T6): they differ by its error, 5e-4 here
        assert!((slope / fmu.get(value) - 1.0).abs() < 1e-3, "{of}: {slope} against {}", fmu.get(value));
        assert_eq!(rate(&fmu, of, 2), (fmi2OK, 0.0), "higher orders are zero");
    }
    assert_eq!(fmu.bits(), before, "asking changes nothing");
    assert!(rate(&fmu, "root.force.z", 1).1 != 0.0);
}

#[test]
fn bad_output_derivatives_are_refused() {
    let starting = Fmu::initializing(0.0);
    starting.refused(rate(&starting, "fold.angle", 1).0, fmi2Error, &["in Initialization Mode"]);
    let fmu = Fmu::stepping();
    let c = fmu.component;
    fmu.refused(rate(&fmu, "fold.external_torque", 1).0, fmi2Error, &["fold.external_torque", "Real outputs"]);
    fmu.refused(rate(&fmu, "fold.latched", 1).0, fmi2Error, &["Boolean, not Real"]);
    fmu.refused(rate(&fmu, "fold.angle", 0).0, fmi2Error, &["order 0"]);
    let angle = fmu.reference("fold.angle");
    unsafe {
        let mut value = 0.0;
        let status = fmi2GetRealOutputDerivatives(c, &77_777, 1, &1, &mut value);
        fmu.refused(status, fmi2Error, &["unknown value reference 77777"]);
        fmu.refused(fmi2GetRealOutputDerivatives(c, ptr::null(), 1, &1, &mut value), fmi2Error, &["vr is null"]);
        fmu.refused(fmi2GetRealOutputDerivatives(c, &angle, 1, ptr::null(), &mut value), fmi2Error, &["order is null"]);
        fmu.refused(fmi2GetRealOutputDerivatives(c, &angle, 1, &1, ptr::null_mut()), fmi2Error, &["value is null"]);
        fmu.ok(fmi2GetRealOutputDerivatives(c, ptr::null(), 0, ptr::null(), ptr::null_mut()));
    }
}

#[test]
fn directional_derivatives_by_inputs_and_in_initialization_mode_by_parameters() {
    let fmu = Fmu::initializing(0.0);
    let (status, by_angle) = derivative(&fmu, "fold.angle", "fold.start_angle", 3.0);
    fmu.ok(status);
    assert!((by_angle - 3.0).abs() < 1e-11, "{by_angle}: differences of 1e-3 rad leave 1e-12");
    let (_, by_stiffness) = derivative(&fmu, "fold.total_torque", "fold.motor_stiffness", 1.0);
    assert!((by_stiffness + fmu.get("fold.angle")).abs() < 1e-10, "the torque is -k theta: {by_stiffness}");
    fmu.ok(unsafe { fmi2ExitInitializationMode(fmu.component) });
    fmu.step(0.0, 0.02);
    let before = fmu.bits();
    let (status, by_torque) = derivative(&fmu, "fold.total_torque", "fold.external_torque", 2.0);
    fmu.ok(status);
    assert!((by_torque - 2.0).abs() < 1e-14, "{by_torque}");
    assert_eq!(derivative(&fmu, "fold.angle", "fold.external_torque", 1.0), (fmi2OK, 0.0), "the state is frozen");
    let [by_acceleration, by_gravity] =
        ["root.acceleration.z", "gravity.z"].map(|known| derivative(&fmu, "root.force.z", known, 1.0).1);
    assert!(by_gravity != 0.0 && (by_acceleration + by_gravity).abs() < 1e-12, "{by_acceleration} and {by_gravity} kg");
    assert_eq!(fmu.bits(), before, "asking changes nothing");
}

#[test]
fn bad_directional_derivatives_are_refused() {
    let fmu = Fmu::stepping();
    let c = fmu.component;
    let refused = |unknown, known, seed, status, parts: &[&str]| {
        fmu.refused(derivative(&fmu, unknown, known, seed).0, status, parts);
    };
    refused(
        "fold.angle",
        "fold.motor_stiffness",
        1.0,
        fmi2Error,
        &["fold.motor_stiffness", "in Initialization Mode, parameters"],
    );
    refused("fold.angle", "time", 1.0, fmi2Error, &["no derivative with respect to variable time"]);
    refused("fold.external_torque", "fold.external_torque", 1.0, fmi2Error, &["unknowns must be Real outputs"]);
    refused("fold.latched", "fold.external_torque", 1.0, fmi2Error, &["Boolean, not Real"]);
    refused("fold.angle", "fold.release", 1.0, fmi2Error, &["Boolean, not Real"]);
    refused("fold.angle", "fold.external_torque", f64::INFINITY, fmi2Discard, &["d(fold.external_torque)", "inf"]);
    let (angle, torque, mut value) = (fmu.reference("fold.angle"), fmu.reference("fold.external_torque"), 0.0);
    let get = |u: *const u32, k: *const u32, dk: *const f64, du: *mut f64| unsafe {
        fmi2GetDirectionalDerivative(c, u, 1, k, 1, dk, du)
    };
    fmu.refused(get(ptr::null(), &torque, &1.0, &mut value), fmi2Error, &["vUnknown_ref is null"]);
    fmu.refused(get(&angle, ptr::null(), &1.0, &mut value), fmi2Error, &["vKnown_ref is null"]);
    fmu.refused(get(&angle, &torque, ptr::null(), &mut value), fmi2Error, &["dvKnown is null"]);
    fmu.refused(get(&angle, &torque, &1.0, ptr::null_mut()), fmi2Error, &["dvUnknown is null"]);
    fmu.refused(get(&44_444, &torque, &1.0, &mut value), fmi2Error, &["unknown value reference 44444"]);
    fmu.refused(get(&angle, &44_444, &1.0, &mut value), fmi2Error, &["unknown value reference 44444"]);
    unsafe {
        let none = fmi2GetDirectionalDerivative(c, &angle, 1, ptr::null(), 0, ptr::null(), &mut value);
        fmu.ok(none);
        assert_eq!(value, 0.0, "no known, no change");
        fmu.ok(fmi2GetDirectionalDerivative(c, ptr::null(), 0, &torque, 1, &1.0, ptr::null_mut()));
    }
    let fresh = Fmu::new(WING);
    fresh.refused(derivative(&fresh, "fold.angle", "fold.external_torque", 1.0).0, fmi2Error, &["before fmi2Enter"]);
}

/// A tunable parameter takes effect at the next step; a fixed one cannot be changed any more.
#[test]
fn tunable_parameters_change_during_a_run() {
    let fmu = Fmu::stepping();
    let plain = Fmu::stepping();
    for fmu in [&fmu, &plain] {
        fmu.step(0.0, 0.01);
    }
    fmu.set("fold.motor_stiffness", 0.05);
    fmu.step(0.01, 0.01);
    plain.step(0.01, 0.01);
    assert!(fmu.get("fold.angle") < plain.get("fold.angle") - 1e-3, "the stiffer spring unfolds faster");
}

/// Flag, value, and the test that uses the capability (or that checks the rejection of the call), as file and function.
const FLAGS: &[(&str, &str, &str, &str)] = &[
    ("needsExecutionTool", "false", "fmi/test_deployment.py", "test_f10_default_arguments_unfold_and_latch"),
    (
        "canHandleVariableCommunicationStepSize",
        "true",
        "fmi/test_deployment.py",
        "test_f16_latch_time_does_not_depend_on_the_communication_step",
    ),
    ("canInterpolateInputs", "true", "robustness/fmi_capabilities.rs", "input_derivatives_hold_for_the_next_step"),
    ("maxOutputDerivativeOrder", "1", "robustness/fmi_capabilities.rs", "output_derivatives_are_those_of_the_motion"),
    (
        "canRunAsynchronuously",
        "false",
        "robustness/fmi_calls.rs",
        "calls_out_of_order_are_errors_that_leave_the_instance_unharmed",
    ),
    (
        "canBeInstantiatedOnlyOncePerProcess",
        "false",
        "robustness/fmi_semantics.rs",
        "interleaved_instances_equal_each_alone",
    ),
    ("canNotUseMemoryManagementFunctions", "true", "robustness/fmi_calls.rs", "a_silent_importer_is_legal"),
    ("canGetAndSetFMUstate", "true", "robustness/fmi_semantics.rs", "a_restored_state_repeats_the_step_bit_for_bit"),
    (
        "canSerializeFMUstate",
        "true",
        "robustness/fmi_semantics.rs",
        "a_serialised_state_goes_on_in_another_instance_bit_for_bit",
    ),
    (
        "providesDirectionalDerivative",
        "true",
        "robustness/fmi_capabilities.rs",
        "directional_derivatives_by_inputs_and_in_initialization_mode_by_parameters",
    ),
];

#[test]
fn every_flag_of_the_description_has_a_test() {
    let machine = config::parse(WING, "model.toml").expect("valid");
    let table = foldwing::interface::Interface::new(&machine);
    let (variables, guid) = (table.variables(), guid(WING, table.variables()));
    let text = model_description(&machine, variables, &table.dependencies(&machine), &guid, Kinds::default());
    let element = text.split("<CoSimulation").nth(1).and_then(|rest| rest.split('>').next()).expect("the element");
    let flags: Vec<(&str, &str)> = element
        .split_whitespace()
        .filter_map(|attribute| attribute.split_once("=\""))
        .map(|(name, value)| (name, value.trim_end_matches(['/', '"'])))
        .filter(|(name, _)| *name != "modelIdentifier")
        .collect();
    let listed: Vec<(&str, &str)> = FLAGS.iter().map(|&(name, value, _, _)| (name, value)).collect();
    assert_eq!(flags, listed);
    for (name, _, file, function) in FLAGS {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(file);
        let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{file}: {error}"));
        let found = [format!("fn {function}("), format!("def {function}(")].iter().any(|head| text.contains(head));
        assert!(found, "{name}: {file} has no test {function}");
    }
}
