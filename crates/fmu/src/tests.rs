//! Tests of the gate, with bodies that no exported function has.

use super::functions::fmi2FreeInstance;
use super::types::fmi2Component;
use super::*;
use foldwing_fmi::fmi2::Call;
use foldwing_fmi::instance::{Log, Manner, Request, Version};
use foldwing_fmi::interface::{Interface, guid};
use std::cell::RefCell;
use std::rc::Rc;

const WING: &str = include_str!("../../../examples/models/folding_wing.toml");

/// A handle of an instance of the shipped model, and its log.
fn component() -> (fmi2Component, Rc<RefCell<Vec<String>>>) {
    let folder = tempfile_folder();
    std::fs::write(folder.join("model.toml"), WING).expect("writable");
    let machine = foldwing_file::parse(WING, "model.toml").expect("valid");
    let guid = guid(WING, Interface::new(&machine).variables());
    let request = Request {
        version: Version::Fmi2,
        name: Some("wing"),
        fmu_type: 1,
        guid: Some(&guid),
        resource_location: folder.to_str(),
        manner: Manner::default(),
    };
    let mut instance = Instance::new(&request).expect("an instance");
    std::fs::remove_dir_all(folder).expect("removable");
    let messages = Rc::new(RefCell::new(Vec::new()));
    let sink = Rc::clone(&messages);
    let sink: Sink = Box::new(move |_, category, text| sink.borrow_mut().push(format!("{}: {text}", category.name())));
    *instance.log_mut() = Log::new(Some(sink), false);
    (Held::handle(instance, None), messages)
}

fn tempfile_folder() -> std::path::PathBuf {
    let thread = format!("{:?}", std::thread::current().id()).replace(|c: char| !c.is_ascii_digit(), "");
    let folder = std::env::temp_dir().join(format!("foldwing-gate-{}-{thread}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("writable");
    folder
}

#[test]
fn a_panic_is_fatal_logged_and_poisons_the_instance() {
    let (component, messages) = component();
    // SAFETY: the component is alive until it is freed below.
    unsafe {
        let status = enter(component, Call::SetReal, |_| panic!("index {} out of bounds", 7));
        assert_eq!(status, fmi2Fatal);
        assert_eq!(messages.borrow()[0], "logStatusFatal: fmi2SetReal: internal error: index 7 out of bounds");
        for call in [Call::Reset, Call::GetReal, Call::SetFmuState] {
            assert_eq!(enter(component, call, |_| Ok(())), fmi2Fatal, "{} after a panic", call.rule().name);
        }
        let last = messages.borrow().last().cloned().expect("a message");
        assert!(last.contains("only fmi2FreeInstance is legal"), "{last}");
        fmi2FreeInstance(component);
    }
}

/// L-03. After an internal error, which no exported function causes, every function returns `fmi2Fatal` for any arguments; freeing works.
#[test]
fn l03_every_call_after_a_breakdown() {
    use super::{derivatives::*, functions::*, states::*, status::*};
    let (component, messages) = component();
    let (vr, n) = (std::ptr::null(), 3);
    // SAFETY: the component is alive until it is freed below; null pointers are checked by each function.
    let calls = unsafe {
        assert_eq!(enter(component, Call::DoStep, |_| panic!("never")), fmi2Error, "not yet legal, so it does not run");
        assert_eq!(enter(component, Call::Reset, |_| panic!("spoilt")), fmi2Fatal);
        messages.borrow_mut().clear();
        [
            ("fmi2SetDebugLogging", fmi2SetDebugLogging(component, 1, 0, std::ptr::null())),
            ("fmi2SetupExperiment", fmi2SetupExperiment(component, 0, 0.0, 0.0, 0, 0.0)),
            ("fmi2EnterInitializationMode", fmi2EnterInitializationMode(component)),
            ("fmi2ExitInitializationMode", fmi2ExitInitializationMode(component)),
            ("fmi2Terminate", fmi2Terminate(component)),
            ("fmi2Reset", fmi2Reset(component)),
            ("fmi2GetReal", fmi2GetReal(component, vr, n, std::ptr::null_mut())),
            ("fmi2GetInteger", fmi2GetInteger(component, vr, n, std::ptr::null_mut())),
            ("fmi2GetBoolean", fmi2GetBoolean(component, vr, n, std::ptr::null_mut())),
            ("fmi2GetString", fmi2GetString(component, vr, n, std::ptr::null_mut())),
            ("fmi2SetReal", fmi2SetReal(component, vr, n, std::ptr::null())),
            ("fmi2SetInteger", fmi2SetInteger(component, vr, n, std::ptr::null())),
            ("fmi2SetBoolean", fmi2SetBoolean(component, vr, n, std::ptr::null())),
            ("fmi2SetString", fmi2SetString(component, vr, n, std::ptr::null())),
            ("fmi2GetFMUstate", fmi2GetFMUstate(component, std::ptr::null_mut())),
            ("fmi2SetFMUstate", fmi2SetFMUstate(component, std::ptr::null_mut())),
            ("fmi2FreeFMUstate", fmi2FreeFMUstate(component, std::ptr::null_mut())),
            (
                "fmi2SerializedFMUstateSize",
                fmi2SerializedFMUstateSize(component, std::ptr::null_mut(), std::ptr::null_mut()),
            ),
            ("fmi2SerializeFMUstate", fmi2SerializeFMUstate(component, std::ptr::null_mut(), std::ptr::null_mut(), n)),
            ("fmi2DeSerializeFMUstate", fmi2DeSerializeFMUstate(component, std::ptr::null(), n, std::ptr::null_mut())),
            (
                "fmi2GetDirectionalDerivative",
                fmi2GetDirectionalDerivative(component, vr, n, vr, n, std::ptr::null(), std::ptr::null_mut()),
            ),
            (
                "fmi2SetRealInputDerivatives",
                fmi2SetRealInputDerivatives(component, vr, n, std::ptr::null(), std::ptr::null()),
            ),
            (
                "fmi2GetRealOutputDerivatives",
                fmi2GetRealOutputDerivatives(component, vr, n, std::ptr::null(), std::ptr::null_mut()),
            ),
            ("fmi2DoStep", fmi2DoStep(component, 0.0, 1e-3, 1)),
            ("fmi2CancelStep", fmi2CancelStep(component)),
            ("fmi2GetStatus", fmi2GetStatus(component, 0, std::ptr::null_mut())),
            ("fmi2GetRealStatus", fmi2GetRealStatus(component, 2, std::ptr::null_mut())),
            ("fmi2GetIntegerStatus", fmi2GetIntegerStatus(component, 0, std::ptr::null_mut())),
            ("fmi2GetBooleanStatus", fmi2GetBooleanStatus(component, 3, std::ptr::null_mut())),
            ("fmi2GetStringStatus", fmi2GetStringStatus(component, 1, std::ptr::null_mut())),
        ]
    };
    let told = messages.borrow();
    assert_eq!(told.len(), calls.len(), "one message each");
    for ((name, status), told) in calls.iter().zip(told.iter()) {
        assert_eq!(*status, fmi2Fatal, "{name}");
        let expected = format!(
            "logStatusFatal: {name}: an internal error occurred in this instance earlier; only \
                     fmi2FreeInstance is legal"
        );
        assert_eq!(*told, expected);
    }
    println!("life cycle after a breakdown: {} cells", calls.len());
    // SAFETY: alive, freed once.
    unsafe { fmi2FreeInstance(component) };
}

#[test]
fn the_life_cycle_is_asked_before_the_body_runs() {
    let (component, messages) = component();
    // SAFETY: the component is alive until it is freed below.
    unsafe {
        assert_eq!(enter(component, Call::DoStep, |_| panic!("must not run")), fmi2Error);
        assert_eq!(enter(component, Call::SetReal, |_| Ok(())), fmi2OK);
        fmi2FreeInstance(component);
    }
    assert_eq!(messages.borrow().len(), 1, "an error is told, a success is not");
}

#[test]
fn null_is_refused_and_zero_values_make_it_legal() {
    // SAFETY: these functions check null with any length.
    unsafe {
        assert_eq!(enter(std::ptr::null_mut(), Call::GetReal, |_| Ok(())), fmi2Error);
        assert!(slice::<f64>(std::ptr::null(), 3, "value").is_err());
        assert_eq!(slice::<f64>(std::ptr::null(), 0, "value").expect("legal"), &[0.0; 0]);
        assert!(slice_mut::<f64>(std::ptr::null_mut(), 1, "value").is_err());
        assert_eq!(text(std::ptr::null(), "fmuGUID").expect("legal"), None);
        assert!(text(c"\xff".as_ptr(), "fmuGUID").expect_err("no UTF-8").to_string().contains("fmuGUID"));
    }
}
