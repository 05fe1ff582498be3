//! A minimal importer of FMI 3.0: calls the exported functions and records the log messages.

#![allow(dead_code, reason = "each test uses a part of it")]

use crate::fmu::{Resources, WING};
use foldwing::config;
use foldwing::instance::Version;
use foldwing::interface::{Interface, Value};
use foldwing::packaging::Kinds;
use foldwing_fmu::fmi3::exchange::*;
use foldwing_fmu::fmi3::functions::*;
use foldwing_fmu::fmi3::states::*;
use foldwing_fmu::fmi3::steps::*;
use foldwing_fmu::fmi3::types::*;
use foldwing_fmu::fmi3::values::*;
use std::cell::{Cell, RefCell};
use std::ffi::{CStr, CString};
use std::ptr;

/// A call of the interface.
pub type Call = fn(fmi3Instance) -> fmi3Status;

/// Data of the importer's callback functions.
#[derive(Default)]
pub struct Environment {
    /// Status, category and text of each message.
    pub messages: RefCell<Vec<(fmi3Status, String, String)>>,
    /// The instance, for calls from within a step.
    pub instance: Cell<fmi3Instance>,
    /// Times of the intermediate updates in s, with the value of a variable and the status of reading it.
    pub asked: RefCell<Vec<(f64, f64, fmi3Status)>>,
    /// Variable to read in these updates.
    pub reads: Cell<u32>,
    /// Time in s from which on it requests early return, and the time returned.
    pub returns: Cell<Option<(f64, f64)>>,
    /// A call to make within a step, which must be rejected.
    pub intrudes: Cell<Option<Call>>,
}

unsafe extern "C" fn record(
    environment: fmi3InstanceEnvironment,
    status: fmi3Status,
    category: fmi3String,
    message: fmi3String,
) {
    let text = |pointer| unsafe { CStr::from_ptr(pointer) }.to_str().expect("UTF-8").to_owned();
    let environment = unsafe { &*environment.cast::<Environment>() };
    environment.messages.borrow_mut().push((status, text(category), text(message)));
}

unsafe extern "C" fn ask(
    environment: fmi3InstanceEnvironment,
    time_s: f64,
    set: bool,
    get: bool,
    finished: bool,
    may_return: bool,
    returns: *mut bool,
    at_s: *mut f64,
) {
    let environment = unsafe { &*environment.cast::<Environment>() };
    assert!(!set && get && finished);
    let mut value = f64::NAN;
    let status = unsafe { fmi3GetFloat64(environment.instance.get(), &environment.reads.get(), 1, &mut value, 1) };
    environment.asked.borrow_mut().push((time_s, value, status));
    if let Some(intrude) = environment.intrudes.get() {
        assert_ne!(intrude(environment.instance.get()), 0, "refused within a step");
    }
    if let Some((_, named_s)) = environment.returns.get().filter(|&(from_s, _)| time_s >= from_s && may_return) {
        unsafe { (*returns, *at_s) = (true, named_s) };
    }
}

/// Capabilities of the importer.
#[derive(Debug, Clone, Copy, Default)]
pub struct Agreed {
    pub event_mode: bool,
    pub early_return: bool,
    pub intermediate_update: bool,
}

/// Results of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    pub status: fmi3Status,
    pub event: bool,
    pub early: bool,
    pub last_s: f64,
}

/// An instance with its log and its variable table.
pub struct Fmu3 {
    pub instance: fmi3Instance,
    pub environment: Box<Environment>,
    pub table: Interface,
}

impl Fmu3 {
    /// Freshly instantiated for co-simulation.
    pub fn new(text: &str, agreed: Agreed) -> Self {
        Self::of(text, Some(agreed), Kinds { version: Version::Fmi3, ..Kinds::default() })
    }

    /// Freshly instantiated for Model Exchange.
    pub fn exchanged(text: &str) -> Self {
        Self::of(
            text,
            None,
            Kinds { version: Version::Fmi3, co_simulation: true, model_exchange: true, ..Kinds::default() },
        )
    }

    fn of(text: &str, agreed: Option<Agreed>, kinds: Kinds) -> Self {
        let resources = Resources::with(text);
        let table = kinds.interface(&config::parse(text, "model.toml").expect("a valid model"));
        let token = CString::new(kinds.token(&table, text)).expect("no zero");
        let folder = CString::new(format!("{}/", resources.folder.display())).expect("no zero");
        let environment = Box::new(Environment::default());
        let pointer = ptr::from_ref(&*environment).cast_mut().cast();
        let (name, log) = (c"wing".as_ptr(), Some(record as _));
        let instance = unsafe {
            match agreed {
                Some(agreed) => fmi3InstantiateCoSimulation(
                    name,
                    token.as_ptr(),
                    folder.as_ptr(),
                    false,
                    false,
                    agreed.event_mode,
                    agreed.early_return,
                    ptr::null(),
                    0,
                    pointer,
                    log,
                    agreed.intermediate_update.then_some(ask as _),
                ),
                None => fmi3InstantiateModelExchange(name, token.as_ptr(), folder.as_ptr(), false, false, pointer, log),
            }
        };
        assert!(!instance.is_null(), "refused: {:?}", environment.messages);
        environment.instance.set(instance);
        Self { instance, environment, table }
    }

    /// The shipped model, ready to step from t = 0, or in its first event.
    pub fn started(agreed: Agreed) -> Self {
        let fmu = Self::new(WING, agreed);
        fmu.start();
        fmu
    }

    /// Initialises at t = 0.
    pub fn start(&self) {
        unsafe {
            self.ok(fmi3EnterInitializationMode(self.instance, false, 0.0, 0.0, false, 0.0));
            self.ok(fmi3ExitInitializationMode(self.instance));
        }
    }

    /// Panics and prints the log unless a call succeeded.
    pub fn ok(&self, status: fmi3Status) {
        assert_eq!(status, 0, "{:?}", self.environment.messages.borrow().last());
    }

    /// The last message; clears the log.
    pub fn told(&self) -> String {
        self.environment.messages.borrow_mut().drain(..).next_back().expect("a message").2
    }

    /// Value reference of a name.
    pub fn reference(&self, name: &str) -> u32 {
        let place = self.table.arrays().iter().position(|array| array.name == name);
        u32::try_from(place.unwrap_or_else(|| panic!("no variable {name}"))).expect("few")
    }

    /// Values of a Float64 variable.
    pub fn get(&self, name: &str) -> Vec<f64> {
        let reference = self.reference(name);
        let mut values = vec![f64::NAN; self.table.arrays()[reference as usize].rows.len()];
        self.ok(unsafe { fmi3GetFloat64(self.instance, &reference, 1, values.as_mut_ptr(), values.len()) });
        values
    }

    /// Value of a Boolean variable.
    pub fn get_boolean(&self, name: &str) -> bool {
        let mut value = false;
        self.ok(unsafe { fmi3GetBoolean(self.instance, &self.reference(name), 1, &mut value, 1) });
        value
    }

    /// Sets a Float64 variable and returns the status.
    pub fn try_set(&self, name: &str, values: &[f64]) -> fmi3Status {
        unsafe { fmi3SetFloat64(self.instance, &self.reference(name), 1, values.as_ptr(), values.len()) }
    }

    /// Sets a Float64 variable.
    pub fn set(&self, name: &str, values: &[f64]) {
        self.ok(self.try_set(name, values));
    }

    /// Sets a Boolean variable and returns the status.
    pub fn try_set_boolean(&self, name: &str, value: bool) -> fmi3Status {
        unsafe { fmi3SetBoolean(self.instance, &self.reference(name), 1, &value, 1) }
    }

    /// Takes a step.
    pub fn try_step(&self, time_s: f64, step_s: f64) -> Answer {
        let (mut event, mut end, mut early, mut last_s) = (true, true, true, f64::NAN);
        let status =
            unsafe { fmi3DoStep(self.instance, time_s, step_s, true, &mut event, &mut end, &mut early, &mut last_s) };
        assert!(!end || status != 0);
        Answer { status, event, early, last_s }
    }

    /// Takes a step that must succeed; returns its end time in s and whether an event is pending there.
    pub fn step(&self, time_s: f64, step_s: f64) -> Answer {
        let answer = self.try_step(time_s, step_s);
        self.ok(answer.status);
        answer
    }

    /// Executes the transitions of an event; returns whether continuous states have changed.
    pub fn update(&self) -> bool {
        let (mut again, mut end, mut nominals, mut states, mut defined, mut next_s) =
            (true, true, true, true, true, f64::NAN);
        self.ok(unsafe {
            fmi3UpdateDiscreteStates(
                self.instance,
                &mut again,
                &mut end,
                &mut nominals,
                &mut states,
                &mut defined,
                &mut next_s,
            )
        });
        assert_eq!((again, end, nominals), (false, false, false));
        states
    }

    /// Bits of every Float64 of the table in the order of its rows.
    pub fn bits(&self) -> Vec<u64> {
        let mut bits = vec![0; self.table.variables().len()];
        let real = |row: &u32| matches!(self.table.variables()[*row as usize].value, Value::Real(_));
        for array in self.table.arrays().iter().filter(|array| real(&array.rows[0])) {
            for (&row, value) in array.rows.iter().zip(self.get(&array.name)) {
                bits[row as usize] = value.to_bits();
            }
        }
        let rows = (0..).zip(bits).filter(|(row, _)| real(row));
        rows.map(|(_, bits)| bits).collect()
    }

    /// Saves the state.
    pub fn save(&self) -> fmi3FMUState {
        let mut state = ptr::null_mut();
        self.ok(unsafe { fmi3GetFMUState(self.instance, &mut state) });
        state
    }

    /// Bytes of a saved state.
    pub fn serialize(&self, state: fmi3FMUState) -> Vec<u8> {
        let mut size = 0;
        self.ok(unsafe { fmi3SerializedFMUStateSize(self.instance, state, &mut size) });
        let mut bytes = vec![0_u8; size];
        self.ok(unsafe { fmi3SerializeFMUState(self.instance, state, bytes.as_mut_ptr(), size) });
        bytes
    }

    /// Bytes of the current state; leaves no saved state behind.
    pub fn present(&self) -> Vec<u8> {
        let mut state = self.save();
        let bytes = self.serialize(state);
        self.ok(unsafe { fmi3FreeFMUState(self.instance, &mut state) });
        bytes
    }
}

impl Drop for Fmu3 {
    fn drop(&mut self) {
        unsafe { fmi3FreeInstance(self.instance) };
    }
}
