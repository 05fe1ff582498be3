//! The gate itself, with bodies that no exported function has.

use super::functions::fmi2FreeInstance;
use super::*;
use crate::fmi2::instance::Request;
use crate::fmi2::log::Log;
use crate::interface::{Interface, guid};
use std::cell::RefCell;
use std::rc::Rc;

const WING: &str = include_str!("../../../examples/models/folding_wing.toml");

/// An instance of the shipped model, as C holds it, and its log.
fn component() -> (fmi2Component, Rc<RefCell<Vec<String>>>) {
    let folder = tempfile_folder();
    std::fs::write(folder.join("model.toml"), WING).expect("writable");
    let machine = crate::config::parse(WING, "model.toml").expect("valid");
    let guid = guid(WING, Interface::new(&machine).variables());
    let request = Request { name: Some("wing"), fmu_type: 1, guid: Some(&guid), resource_location: folder.to_str() };
    let mut instance = Instance::new(&request).expect("an instance");
    std::fs::remove_dir_all(folder).expect("removable");
    let messages = Rc::new(RefCell::new(Vec::new()));
    let sink = Rc::clone(&messages);
    let sink: Sink = Box::new(move |_, category, text| sink.borrow_mut().push(format!("{}: {text}", category.name())));
    *instance.log_mut() = Log::new(Some(sink), false);
    (Box::into_raw(Box::new(instance)).cast(), messages)
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
            assert_eq!(enter(component, call, |_| Ok(())), fmi2Fatal, "{} after a panic", call.name());
        }
        let last = messages.borrow().last().cloned().expect("a message");
        assert!(last.contains("only fmi2FreeInstance is legal"), "{last}");
        fmi2FreeInstance(component);
    }
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
    // SAFETY: null with whatever length is what these functions check.
    unsafe {
        assert_eq!(enter(std::ptr::null_mut(), Call::GetReal, |_| Ok(())), fmi2Error);
        assert!(slice::<f64>(std::ptr::null(), 3, "value").is_err());
        assert_eq!(slice::<f64>(std::ptr::null(), 0, "value").expect("legal"), &[0.0; 0]);
        assert!(slice_mut::<f64>(std::ptr::null_mut(), 1, "value").is_err());
        assert_eq!(text(std::ptr::null(), "fmuGUID").expect("legal"), None);
        assert!(text(c"\xff".as_ptr(), "fmuGUID").expect_err("no UTF-8").to_string().contains("fmuGUID"));
    }
}
