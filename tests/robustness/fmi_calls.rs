//! Invalid calls: each kind is rejected with the right status and a message that gives the cause, and does not affect the instance.

use crate::fmu::{Attempt, Fmu, OTHER, Resources, WING, callbacks, guid_of};
use foldwing::fmi2::FUNCTIONS;
use foldwing_fmu::functions::*;
use foldwing_fmu::states::*;
use foldwing_fmu::status::*;
use foldwing_fmu::types::*;
use std::ptr;

#[test]
fn the_shared_library_exports_every_function() {
    let tests = std::env::current_exe().expect("a path");
    let name = format!("{}foldwing_fmu{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let path = tests.with_file_name(name); // Cargo builds the library next to its tests
    // SAFETY: our own library, without initialisers.
    let library = unsafe { libloading::Library::new(&path) }.unwrap_or_else(|error| panic!("{path:?}: {error}"));
    for export in FUNCTIONS {
        let symbol = unsafe { library.get::<unsafe extern "C" fn()>(export.as_bytes()) };
        assert!(symbol.is_ok(), "{export} is not exported");
    }
    type Text = extern "C" fn() -> *const std::ffi::c_char;
    for (export, expected) in [("fmi2GetVersion", c"2.0"), ("fmi2GetTypesPlatform", c"default")] {
        let text = unsafe { library.get::<Text>(export.as_bytes()) }.expect("exported");
        assert_eq!(unsafe { std::ffi::CStr::from_ptr(text()) }, expected);
    }
}

#[test]
fn unknown_value_reference_is_an_error_that_names_it() {
    let fmu = Fmu::stepping();
    let (bad, mut value) = (4_000_000_000_u32, 1.0);
    let last = (fmu.table.variables().len() - 1).to_string();
    let status = unsafe { fmi2GetReal(fmu.component, &bad, 1, &mut value) };
    fmu.refused(status, fmi2Error, &["fmi2GetReal", "unknown value reference 4000000000", &last]);
    let status = unsafe { fmi2SetReal(fmu.component, &bad, 1, &value) };
    fmu.refused(status, fmi2Error, &["fmi2SetReal", "unknown value reference 4000000000"]);
    let status = unsafe { fmi2GetInteger(fmu.component, &bad, 1, &mut 0) };
    fmu.refused(status, fmi2Error, &["fmi2GetInteger", "unknown value reference"]);
    assert_eq!(value, 1.0, "nothing is written on a refusal");
    fmu.step(0.0, 1e-3);
}

#[test]
fn wrong_type_is_an_error_that_names_variable_and_types() {
    let fmu = Fmu::stepping();
    let angle = fmu.reference("fold.angle");
    let status = unsafe { fmi2GetBoolean(fmu.component, &angle, 1, &mut 0) };
    fmu.refused(status, fmi2Error, &["fmi2GetBoolean", "fold.angle", "has type Real, not Boolean"]);
    let release = fmu.reference("fold.release");
    let status = unsafe { fmi2SetReal(fmu.component, &release, 1, &1.0) };
    fmu.refused(status, fmi2Error, &["fmi2SetReal", "fold.release", "has type Boolean, not Real"]);
    let status = unsafe { fmi2GetString(fmu.component, &angle, 1, &mut ptr::null()) };
    fmu.refused(status, fmi2Error, &["fmi2GetString", "fold.angle", "not String"]);
    let status = unsafe { fmi2SetString(fmu.component, &angle, 1, &ptr::null()) };
    fmu.refused(status, fmi2Error, &["fmi2SetString", "fold.angle", "not String"]);
    fmu.ok(unsafe { fmi2GetString(fmu.component, ptr::null(), 0, ptr::null_mut()) });
    let status = unsafe { fmi2SetInteger(fmu.component, &fmu.reference("solver.steps"), 1, &3) };
    fmu.refused(status, fmi2Error, &["solver.steps", "local"]);
}

#[test]
fn a_bad_value_is_discarded_with_the_whole_batch() {
    let fmu = Fmu::stepping();
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        fmu.refused(
            fmu.try_set("fold.external_torque", value),
            fmi2Discard,
            &["fold.external_torque", "must be finite", &value.to_string()],
        );
    }
    fmu.refused(
        fmu.try_set("fold.motor_stiffness", -1.0),
        fmi2Discard,
        &["fold.motor_stiffness", "-1", "≥ 0", "N.m/rad"],
    );

    let references =
        ["fold.angle_command", "fold.external_torque", "fold.motor_damping"].map(|name| fmu.reference(name));
    let status = unsafe { fmi2SetReal(fmu.component, references.as_ptr(), 3, [0.1, 0.2, -1.0].as_ptr()) };
    fmu.refused(status, fmi2Discard, &["fold.motor_damping"]);
    assert_eq!(
        (fmu.get("fold.angle_command"), fmu.get("fold.external_torque")),
        (0.0, 0.0),
        "none of the batch may be set"
    );
    fmu.step(0.0, 1e-3);
}

#[test]
fn outputs_time_and_late_fixed_parameters_cannot_be_set() {
    let fmu = Fmu::initializing(0.0);
    fmu.set("fold.start_angle", 1.0);
    fmu.ok(unsafe { fmi2ExitInitializationMode(fmu.component) });
    fmu.refused(fmu.try_set("fold.angle", 1.0), fmi2Error, &["fold.angle", "it is an output"]);
    fmu.refused(fmu.try_set("time", 1.0), fmi2Error, &["time", "independent variable"]);
    fmu.refused(fmu.try_set("fold.start_angle", 1.0), fmi2Error, &["fold.start_angle", "fixed"]);
    fmu.set("fold.motor_stiffness", 0.03);
    assert_eq!(fmu.get("fold.motor_stiffness"), 0.03, "tunable ones can");
}

#[test]
fn calls_out_of_order_are_errors_that_leave_the_instance_unharmed() {
    let fmu = Fmu::new(WING);
    let c = fmu.component;
    let mut value = 0.0;
    unsafe {
        fmu.refused(fmu.try_step(0.0, 1e-3), fmi2Error, &["fmi2DoStep", "before fmi2EnterInitializationMode"]);
        let early = fmi2GetReal(c, &fmu.reference("fold.angle"), 1, &mut value);
        fmu.refused(early, fmi2Error, &["fmi2GetReal", "before fmi2EnterInitializationMode"]);
        fmu.refused(fmi2ExitInitializationMode(c), fmi2Error, &["fmi2ExitInitializationMode", "not legal before"]);
        fmu.refused(fmi2Terminate(c), fmi2Error, &["fmi2Terminate", "not legal before"]);

        fmu.setup(0.0, None);
        fmu.ok(fmi2EnterInitializationMode(c));
        fmu.refused(fmi2EnterInitializationMode(c), fmi2Error, &["in Initialization Mode"]);
        fmu.refused(fmu.try_step(0.0, 1e-3), fmi2Error, &["fmi2DoStep", "in Initialization Mode"]);
        fmu.refused(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), fmi2Error, &["in Initialization Mode"]);

        fmu.ok(fmi2ExitInitializationMode(c));
        fmu.refused(fmi2ExitInitializationMode(c), fmi2Error, &["after fmi2ExitInitializationMode"]);
        fmu.refused(fmi2CancelStep(c), fmi2Error, &["fmi2CancelStep", "not legal"]);
        fmu.step(0.0, 1e-3);

        fmu.ok(fmi2Terminate(c));
        fmu.refused(fmu.try_step(1e-3, 1e-3), fmi2Error, &["fmi2DoStep", "after fmi2Terminate"]);
        fmu.refused(fmu.try_set("fold.external_torque", 1.0), fmi2Error, &["fmi2SetReal", "after fmi2Terminate"]);
        assert!(fmu.get("fold.angle") > 2.9, "values can be read after the end");
        fmu.ok(fmi2Reset(c));
        fmu.refused(fmu.try_step(0.0, 1e-3), fmi2Error, &["before fmi2EnterInitializationMode"]);
    }
}

#[test]
fn null_pointers_are_errors_unless_nothing_is_asked() {
    let fmu = Fmu::stepping();
    let c = fmu.component;
    let (angle, mut value, mut size) = (fmu.reference("fold.angle"), 0.0, 0);
    unsafe {
        assert_eq!(fmi2DoStep(ptr::null_mut(), 0.0, 1e-3, 0), fmi2Error);
        assert_eq!(fmi2GetReal(ptr::null_mut(), &angle, 1, &mut value), fmi2Error);
        fmi2FreeInstance(ptr::null_mut());

        fmu.refused(fmi2GetReal(c, ptr::null(), 1, &mut value), fmi2Error, &["fmi2GetReal", "argument vr is null"]);
        fmu.refused(fmi2GetReal(c, &angle, 1, ptr::null_mut()), fmi2Error, &["argument value is null"]);
        fmu.refused(fmi2SetReal(c, &angle, 1, ptr::null()), fmi2Error, &["fmi2SetReal", "argument value is null"]);
        fmu.refused(fmi2GetBoolean(c, &angle, 1, ptr::null_mut()), fmi2Error, &["argument value is null"]);
        fmu.refused(fmi2SetInteger(c, ptr::null(), 1, &1), fmi2Error, &["argument vr is null"]);
        fmu.refused(fmi2SetDebugLogging(c, 1, 1, ptr::null()), fmi2Error, &["argument categories is null"]);
        fmu.refused(fmi2SetDebugLogging(c, 1, 1, &ptr::null()), fmi2Error, &["argument categories is null"]);
        fmu.refused(fmi2GetRealStatus(c, fmi2LastSuccessfulTime, ptr::null_mut()), fmi2Error, &["value is null"]);

        fmu.refused(fmi2GetFMUstate(c, ptr::null_mut()), fmi2Error, &["argument FMUstate is null"]);
        fmu.refused(fmi2SetFMUstate(c, ptr::null_mut()), fmi2Error, &["argument FMUstate is null"]);
        fmu.refused(fmi2SerializedFMUstateSize(c, ptr::null_mut(), &mut size), fmi2Error, &["FMUstate is null"]);
        let state = fmu.save();
        fmu.refused(fmi2SerializedFMUstateSize(c, state, ptr::null_mut()), fmi2Error, &["argument size is null"]);
        let status = fmi2SerializeFMUstate(c, state, ptr::null_mut(), 1000);
        fmu.refused(status, fmi2Error, &["argument serializedState is null"]);
        let status = fmi2DeSerializeFMUstate(c, ptr::null(), 1000, &mut ptr::null_mut());
        fmu.refused(status, fmi2Error, &["argument serializedState is null"]);

        fmu.ok(fmi2GetReal(c, ptr::null(), 0, ptr::null_mut()));
        fmu.ok(fmi2SetBoolean(c, ptr::null(), 0, ptr::null()));
        fmu.ok(fmi2FreeFMUstate(c, ptr::null_mut()));
        fmu.ok(fmi2FreeFMUstate(c, &mut ptr::null_mut()));
    }
    fmu.step(0.0, 1e-3);
}

#[test]
fn a_guid_mismatch_is_refused_and_both_are_named() {
    let resources = Resources::with(WING);
    let attempt = Attempt { guid: Some(guid_of(OTHER)), ..Attempt::of(WING, &resources) };
    let message = attempt.refusal();
    assert!(message.contains(&guid_of(OTHER)) && message.contains(&guid_of(WING)), "{message}");
    let message = Attempt { guid: None, ..attempt }.refusal();
    assert!(message.contains("(null)"), "{message}");
}

#[test]
fn missing_and_damaged_resources_are_refused_by_path() {
    let empty = Resources::empty("empty");
    let message = Attempt { guid: None, ..Attempt::of(WING, &empty) }.refusal();
    assert!(message.contains("model.toml") && message.contains("cannot be read"), "{message}");

    let damaged = Resources::with(&WING.replace("length_m", "lenght_m"));
    let message = Attempt::of(WING, &damaged).refusal();
    assert!(message.contains("model.toml:") && message.contains("lenght_m"), "{message}");

    let message = Attempt { location: None, ..Attempt::of(WING, &empty) }.refusal();
    assert!(message.contains("no resource location"), "{message}");
    let message = Attempt { location: Some("http://wing/resources".into()), ..Attempt::of(WING, &empty) }.refusal();
    assert!(message.contains("\"http://wing/resources\" is not a file URI"), "{message}");
}

#[test]
fn wrong_type_of_fmu_and_missing_name_are_refused() {
    let resources = Resources::with(WING);
    let message = Attempt { fmu_type: fmi2ModelExchange, ..Attempt::of(WING, &resources) }.refusal();
    assert!(message.contains("co-simulation only"), "{message}");
    for name in [None, Some(String::new())] {
        let message = Attempt { name, ..Attempt::of(WING, &resources) }.refusal();
        assert!(message.contains("instance name is missing"), "{message}");
    }
}

#[test]
fn a_folder_with_a_space_and_a_plain_path_are_found() {
    let resources = Resources::empty("with space");
    std::fs::write(resources.folder.join("model.toml"), WING).expect("writable");
    let plain = resources.folder.display().to_string();
    for location in [resources.uri(), plain.clone(), format!("file://localhost{plain}").replace(' ', "%20")] {
        let (component, messages) = Attempt { location: Some(location), ..Attempt::of(WING, &resources) }.run();
        assert!(!component.is_null(), "{messages:?}");
        unsafe { fmi2FreeInstance(component) };
    }
}

#[test]
fn a_silent_importer_is_legal() {
    let resources = Resources::with(WING);
    let messages = crate::fmu::Messages::default();
    let without_logger = fmi2CallbackFunctions { logger: None, ..callbacks(&messages) };
    for functions in [ptr::null(), &raw const without_logger] {
        let component = Attempt::of(WING, &resources).call(functions);
        assert!(!component.is_null());
        unsafe {
            assert_eq!(fmi2DoStep(component, 0.0, 1e-3, 0), fmi2Error);
            fmi2FreeInstance(component);
        }
        assert!(Attempt { guid: None, ..Attempt::of(WING, &resources) }.call(functions).is_null());
    }
}

#[test]
fn the_message_is_its_own_format_so_percent_signs_are_doubled() {
    let resources = Resources::with(WING);
    let (component, messages) =
        Attempt { location: Some("file:///100%zz".into()), ..Attempt::of(WING, &resources) }.run();
    assert!(component.is_null());
    let messages = messages.borrow();
    assert!(messages[0].raw.contains("100%%zz") && messages[0].text.contains("100%zz"), "{messages:?}");
}

#[test]
fn damaged_and_foreign_serialised_states_are_refused() {
    let fmu = Fmu::stepping();
    let bytes = fmu.serialize(fmu.save());
    let refused = |bytes: &[u8], parts: &[&str]| fmu.refused(fmu.deserialize(bytes).0, fmi2Error, parts);

    refused(&[], &["fmi2DeSerializeFMUstate", "damaged", "0 bytes instead of"]);
    for length in [1, 9, 30, 50, 59, bytes.len() / 2, bytes.len() - 1] {
        refused(&bytes[..length], &["damaged", &format!("{length} bytes instead of")]);
    }
    refused(&[&bytes[..], b"x"].concat(), &["damaged", "bytes instead of"]);
    for at in [60, bytes.len() / 2, bytes.len() - 1] {
        let mut flipped = bytes.clone();
        flipped[at] ^= 0x10;
        refused(&flipped, &["damaged", "checksum"]);
    }
    let changed = |at: usize, byte: u8| [&bytes[..at], &[byte], &bytes[at + 1..]].concat();
    refused(&changed(0, b'X'), &["not written by this program"]);
    refused(&changed(9, 0x7f), &["version 32522", "reads version 10"]);

    let other = Fmu::new(OTHER);
    let foreign = other.serialize(other.save());
    refused(&foreign, &["belongs to the model", &guid_of(OTHER), &guid_of(WING)]);

    let (status, state) = fmu.deserialize(&bytes);
    fmu.ok(status);
    fmu.ok(unsafe { fmi2SetFMUstate(fmu.component, state) });
    let mut short = vec![0_i8; bytes.len() - 1];
    let status = unsafe { fmi2SerializeFMUstate(fmu.component, state, short.as_mut_ptr().cast(), short.len()) };
    fmu.refused(status, fmi2Error, &["buffer", &short.len().to_string(), &bytes.len().to_string()]);
}

#[test]
fn freed_and_foreign_state_handles_are_refused() {
    let (fmu, other) = (Fmu::stepping(), Fmu::stepping());
    let foreign = other.save();
    let freed = fmu.save();
    let mut handle = freed;
    unsafe {
        fmu.ok(fmi2FreeFMUstate(fmu.component, &mut handle));
        assert!(handle.is_null(), "the handle is cleared");
        let wild = ptr::without_provenance_mut(0x1234);
        for mut bad in [freed, foreign, wild] {
            let parts = &["freed or belongs to another instance"];
            fmu.refused(fmi2SetFMUstate(fmu.component, bad), fmi2Error, parts);
            fmu.refused(fmi2GetFMUstate(fmu.component, &mut bad), fmi2Error, parts);
            fmu.refused(fmi2FreeFMUstate(fmu.component, &mut bad), fmi2Error, parts);
            fmu.refused(fmi2SerializedFMUstateSize(fmu.component, bad, &mut 0), fmi2Error, parts);
        }
        other.ok(fmi2SetFMUstate(other.component, foreign));
    }
    fmu.step(0.0, 1e-3);
}

#[test]
fn steps_of_no_size_and_steps_at_another_time_are_refused() {
    let fmu = Fmu::stepping();
    for step_s in [0.0, -1e-3, f64::NAN, f64::INFINITY, 1e-320] {
        let time_s = if step_s == 1e-320 { 1.0 } else { 0.0 };
        fmu.refused(fmu.try_step(time_s, step_s), fmi2Error, &["fmi2DoStep", "must be positive", "size"]);
    }
    fmu.refused(fmu.try_step(f64::NAN, 1e-3), fmi2Error, &["fmi2DoStep"]);
    fmu.refused(fmu.try_step(0.25, 1e-3), fmi2Error, &["starts at t = 0.25 s", "is at t = 0 s"]);
    fmu.refused(fmu.try_step(2e-9, 1e-3), fmi2Error, &["is at t = 0 s"]);

    fmu.step(5e-10, 1e-3); // round-off of the importer's clock
    assert_eq!(fmu.get("time"), 5e-10 + 1e-3, "the caller's time is adopted");
}

#[test]
fn steps_beyond_the_stop_time_are_refused_but_for_round_off() {
    let fmu = Fmu::new(WING);
    fmu.setup(0.0, Some(0.01));
    unsafe {
        fmu.ok(fmi2EnterInitializationMode(fmu.component));
        fmu.ok(fmi2ExitInitializationMode(fmu.component));
    }
    fmu.refused(fmu.try_step(0.0, 0.011), fmi2Error, &["ends at t = 0.011 s", "stop time 0.01 s"]);
    fmu.step(0.0, 0.01 + 5e-10);
}

#[test]
fn bad_experiments_are_discarded() {
    let fmu = Fmu::new(WING);
    let setup = |tolerance, start, stop| unsafe { fmi2SetupExperiment(fmu.component, 1, tolerance, start, 1, stop) };
    fmu.refused(setup(1e-4, f64::NAN, 1.0), fmi2Discard, &["startTime", "NaN"]);
    fmu.refused(setup(1e-4, 1.0, 0.5), fmi2Discard, &["stopTime", "0.5"]);
    fmu.refused(setup(0.0, 0.0, 1.0), fmi2Discard, &["solver.tolerance", "0"]);
    fmu.ok(setup(1e-5, 0.0, 1.0));
}

#[test]
fn a_failed_step_keeps_the_last_good_time_and_can_be_taken_back() {
    let fmu = Fmu::stepping();
    fmu.step(0.0, 1e-3);
    let good = fmu.save();
    let before = fmu.bits();
    fmu.set("load.outer[4].force.z", 1e200);
    fmu.refused(fmu.try_step(1e-3, 1e-3), fmi2Error, &["fmi2DoStep", "t = "]);

    let (mut time_s, mut status) = (f64::NAN, fmi2OK);
    unsafe {
        fmu.ok(fmi2GetRealStatus(fmu.component, fmi2LastSuccessfulTime, &mut time_s));
        fmu.ok(fmi2GetStatus(fmu.component, fmi2DoStepStatus, &mut status));
        assert!((1e-3..2e-3).contains(&time_s), "last successful time {time_s}");
        assert_eq!(status, fmi2Error);
        assert_eq!(fmu.get("time"), time_s);

        fmu.refused(fmu.try_step(time_s, 1e-3), fmi2Error, &["fmi2DoStep", "after a failed step"]);
        fmu.refused(fmu.try_set("fold.external_torque", 0.0), fmi2Error, &["fmi2SetReal", "after a failed step"]);
        fmu.refused(fmi2Terminate(fmu.component), fmi2Error, &["after a failed step"]);
        fmu.ok(fmi2SetFMUstate(fmu.component, good));
    }
    assert_eq!(fmu.bits(), before);
    fmu.step(1e-3, 1e-3);
}

#[test]
fn status_functions_answer_their_own_kind_only() {
    let fmu = Fmu::stepping();
    let c = fmu.component;
    let (mut status, mut time_s, mut end, mut text) = (fmi2Fatal, f64::NAN, -1, ptr::null());
    unsafe {
        fmu.ok(fmi2GetStatus(c, fmi2DoStepStatus, &mut status));
        fmu.ok(fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &mut time_s));
        fmu.ok(fmi2GetBooleanStatus(c, fmi2Terminated, &mut end));
        fmu.ok(fmi2GetStringStatus(c, fmi2PendingStatus, &mut text));
        assert_eq!((status, time_s, end), (fmi2OK, 0.0, fmi2False));
        assert!(std::ffi::CStr::from_ptr(text).to_str().expect("text").contains("no step"));
        let wrong = fmi2GetRealStatus(c, fmi2DoStepStatus, &mut time_s);
        fmu.refused(wrong, fmi2Error, &["status kind 0", "fmi2LastSuccessfulTime"]);
        fmu.refused(fmi2GetIntegerStatus(c, 77, &mut 0), fmi2Error, &["status kind 77", "nothing"]);
    }
}

#[test]
fn log_categories_are_checked_and_events_logged_on_request() {
    let fmu = Fmu::stepping();
    let (nonsense, events) = (c"logNonsense", c"logEvents");
    let status = unsafe { fmi2SetDebugLogging(fmu.component, 1, 1, &nonsense.as_ptr()) };
    fmu.refused(status, fmi2Error, &["\"logNonsense\"", "logEvents", "logStatusError"]);

    fmu.step(0.0, 0.05);
    fmu.set_boolean("fold.release", true);
    assert!(fmu.messages.borrow().is_empty(), "silent by default");
    fmu.ok(unsafe { fmi2SetDebugLogging(fmu.component, 1, 1, &events.as_ptr()) });
    fmu.step(0.05, 0.1);
    assert!(fmu.get_boolean("fold.latched"));
    fmu.set_boolean("fold.latch_enable", false);
    fmu.step(0.15, 0.001);
    let messages = fmu.messages.borrow();
    assert!(messages.iter().all(|message| message.category == "logEvents"), "{messages:?}");
    let texts: Vec<&str> = messages.iter().map(|message| message.text.as_str()).collect();
    let latch_s = fmu.get("fold.latch_time");
    assert_eq!(
        texts,
        [
            format!("fmi2DoStep: joint fold: latch closed at t = {latch_s:.9} s"),
            "fmi2DoStep: joint fold: latch opened at t = 0.150000000 s".to_owned(),
        ]
    );
}

/// The lock releases at the communication point of the input; later releases have no effect.
#[test]
fn releases_are_logged_with_their_time() {
    let fmu = Fmu::initializing(0.0);
    fmu.set_boolean("fold.release", false);
    fmu.ok(unsafe { fmi2ExitInitializationMode(fmu.component) });
    fmu.ok(unsafe { fmi2SetDebugLogging(fmu.component, 1, 0, ptr::null()) });
    fmu.step(0.0, 0.05);
    fmu.set_boolean("fold.release", true);
    fmu.step(0.05, 0.01);
    fmu.step(0.06, 0.01);
    let messages = fmu.messages.borrow();
    let texts: Vec<&str> = messages.iter().map(|message| message.text.as_str()).collect();
    assert_eq!(texts, ["fmi2DoStep: joint fold: released at t = 0.050000000 s"]);
}
