//! Importers' loggers that are absent, slow, or call the FMU.

use crate::fmu::{Attempt, Fmu, Messages, Resources, WING, callbacks, table};
use foldwing_fmu::functions::*;
use foldwing_fmu::states::*;
use foldwing_fmu::status::*;
use foldwing_fmu::types::*;
use std::cell::{Cell, RefCell};
use std::ffi::c_void;
use std::ptr;
use std::time::{Duration, Instant};

type Fixed = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String);
type Variadic = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);

/// An instance whose messages go to `logger`; `environment` outlives it.
fn with_logger(logger: Option<Fixed>, environment: *mut c_void) -> Fmu {
    let messages = Box::new(Messages::default());
    // Variadic functions cannot be written in Rust; without further arguments both calling conventions are the same.
    let logger = logger.map(|logger| unsafe { std::mem::transmute::<Fixed, Variadic>(logger) });
    let functions = fmi2CallbackFunctions { logger, componentEnvironment: environment, ..callbacks(&messages) };
    let component = Attempt { logging_on: true, ..Attempt::of(WING, &Resources::with(WING)) }.call(&functions);
    assert!(!component.is_null());
    Fmu { component, messages, table: table(WING) }
}

/// Unfolds the wing through its latching, with a rejected call before every step; returns every Real at the end.
fn unfold(fmu: &Fmu) -> Vec<u64> {
    fmu.setup(0.0, None);
    unsafe {
        fmu.ok(fmi2EnterInitializationMode(fmu.component));
        fmu.ok(fmi2ExitInitializationMode(fmu.component));
    }
    for i in 0..15 {
        assert_eq!(fmu.try_set("fold.external_torque", f64::NAN), fmi2Discard);
        fmu.step(0.01 * f64::from(i), 0.01);
    }
    fmu.bits()
}

unsafe extern "C" fn slow(
    environment: fmi2ComponentEnvironment,
    _: fmi2String,
    _: fmi2Status,
    _: fmi2String,
    _: fmi2String,
) {
    let calls = unsafe { &*environment.cast::<Cell<u32>>() };
    calls.set(calls.get() + 1);
    std::thread::sleep(Duration::from_millis(10));
}

/// G-01. Without a logger, and with one that takes 10 ms, results are bit-identical; time is lost only for messages.
#[test]
fn g01_absent_and_slow_loggers() {
    let silent = unfold(&with_logger(None, ptr::null_mut()));
    let calls = Cell::new(0);
    let fmu = with_logger(Some(slow), ptr::from_ref(&calls).cast_mut().cast());
    let begin = Instant::now();
    assert_eq!(unfold(&fmu), silent);
    assert!(begin.elapsed() >= Duration::from_millis(160), "15 refusals and the latch");
    assert_eq!(calls.get(), 16);
    for i in 15..20 {
        fmu.step(0.01 * f64::from(i), 0.01);
    }
    assert_eq!(calls.get(), 16, "no message, no call");
}

/// Data of a logger that calls the FMU.
struct Caller {
    own: Cell<fmi2Component>,
    other: fmi2Component,
    /// Statuses of the calls on the logging instance, and of that on another one.
    own_statuses: RefCell<Vec<fmi2Status>>,
    other_statuses: RefCell<Vec<fmi2Status>>,
}

unsafe extern "C" fn call_back(
    environment: fmi2ComponentEnvironment,
    _: fmi2String,
    _: fmi2Status,
    _: fmi2String,
    _: fmi2String,
) {
    let caller = unsafe { &*environment.cast::<Caller>() };
    let c = caller.own.get();
    if c.is_null() {
        return;
    }
    let (mut value, mut state, mut status) = (0.0, ptr::null_mut(), 0);
    unsafe {
        caller.own_statuses.borrow_mut().extend([
            fmi2GetReal(c, &1, 1, &mut value),
            fmi2SetReal(c, &1, 1, &0.0),
            fmi2DoStep(c, 0.0, 1e-3, fmi2True),
            fmi2GetFMUstate(c, &mut state),
            fmi2GetStatus(c, fmi2DoStepStatus, &mut status),
            fmi2SetDebugLogging(c, fmi2False, 0, ptr::null()),
            fmi2Terminate(c),
            fmi2Reset(c),
        ]);
        fmi2FreeInstance(c);
        caller.other_statuses.borrow_mut().push(fmi2GetReal(caller.other, &1, 1, &mut value));
    }
}

/// G-02. A logger that calls the logging instance, from rejected calls and from the middle of a step: each call is rejected, freeing has no
/// effect, and the run continues as if nothing had been called. Another instance can be called.
#[test]
fn g02_loggers_that_call_back() {
    let other = Fmu::stepping();
    let caller = Caller {
        own: Cell::new(ptr::null_mut()),
        other: other.component,
        own_statuses: RefCell::default(),
        other_statuses: RefCell::default(),
    };
    let fmu = with_logger(Some(call_back), ptr::from_ref(&caller).cast_mut().cast());
    caller.own.set(fmu.component);
    let expected = unfold(&with_logger(None, ptr::null_mut()));
    assert_eq!(unfold(&fmu), expected);
    assert_eq!(*caller.own_statuses.borrow(), vec![fmi2Error; 8 * 16], "15 refusals, one latch");
    assert_eq!(*caller.other_statuses.borrow(), vec![fmi2OK; 16]);
    caller.own.set(ptr::null_mut());
}
