//! A minimal importer: calls the exported functions and records the log messages.

#![allow(dead_code, reason = "each test uses a part of it")]

use foldwing::config;
use foldwing::interface::{Interface, guid};
use foldwing::packaging::Kinds;
use foldwing_fmu::functions::*;
use foldwing_fmu::states::*;
use foldwing_fmu::types::*;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_void};
use std::path::PathBuf;
use std::ptr;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The shipped model.
pub const WING: &str = include_str!("../../examples/models/folding_wing.toml");
/// Another model.
pub const OTHER: &str = include_str!("../../examples/models/folding_wing_as_printed.toml");

/// One recorded message: status, category, and text as printed by a C formatter.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    pub instance: String,
    pub status: fmi2Status,
    pub category: String,
    pub raw: String,
    pub text: String,
}

/// Target of the logger: the component environment.
pub type Messages = RefCell<Vec<Message>>;

unsafe extern "C" fn record(
    environment: fmi2ComponentEnvironment,
    name: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    format: fmi2String,
) {
    let text = |pointer| unsafe { CStr::from_ptr(pointer) }.to_str().expect("UTF-8").to_owned();
    let raw = text(format);
    let messages = unsafe { &*environment.cast::<Messages>() };
    messages.borrow_mut().push(Message {
        instance: text(name),
        status,
        category: text(category),
        text: raw.replace("%%", "%"),
        raw,
    });
}

type Fixed = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String);
type Variadic = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);

/// Callback functions that record into `messages`.
pub fn callbacks(messages: &Messages) -> fmi2CallbackFunctions {
    // Variadic functions cannot be written in Rust; without further arguments both calling conventions are the same.
    let logger = unsafe { std::mem::transmute::<Fixed, Variadic>(record) };
    fmi2CallbackFunctions {
        logger: Some(logger),
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: ptr::from_ref(messages).cast_mut().cast::<c_void>(),
    }
}

/// A separate resource folder, removed at the end.
pub struct Resources {
    pub folder: PathBuf,
}

impl Resources {
    /// A folder with a model file of this text.
    pub fn with(text: &str) -> Self {
        let resources = Self::empty("plain");
        std::fs::write(resources.folder.join("model.toml"), text).expect("writable");
        resources
    }

    /// A folder without a model file.
    pub fn empty(name: &str) -> Self {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("writable");
        Self { folder }
    }

    /// The folder as a URI.
    pub fn uri(&self) -> String {
        format!("file://{}", self.folder.display()).replace(' ', "%20")
    }
}

impl Drop for Resources {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// GUID of a model file's text.
pub fn guid_of(text: &str) -> String {
    guid(text, table(text).variables())
}

/// Variable table of a model file's text.
pub fn table(text: &str) -> Interface {
    Interface::new(&config::parse(text, "model.toml").expect("a valid model"))
}

/// Variable table of a model file's text with continuous states.
pub fn table_with_states(text: &str) -> Interface {
    let kinds = Kinds { model_exchange: true, ..Kinds::default() };
    kinds.interface(&config::parse(text, "model.toml").expect("a valid model"))
}

/// Arguments of an instantiation; the defaults are valid.
pub struct Attempt {
    pub name: Option<String>,
    pub fmu_type: fmi2Type,
    pub guid: Option<String>,
    pub location: Option<String>,
    pub logging_on: bool,
}

impl Attempt {
    /// Arguments for a model in a folder.
    pub fn of(text: &str, resources: &Resources) -> Self {
        Self {
            name: Some("wing".into()),
            fmu_type: fmi2CoSimulation,
            guid: Some(guid_of(text)),
            location: Some(resources.uri()),
            logging_on: false,
        }
    }

    /// The component, null if rejected, and the log messages.
    pub fn run(&self) -> (fmi2Component, Box<Messages>) {
        let messages = Box::new(Messages::default());
        let component = self.call(&callbacks(&messages));
        (component, messages)
    }

    /// The component, null if rejected.
    pub fn call(&self, callbacks: *const fmi2CallbackFunctions) -> fmi2Component {
        let c = |text: &Option<String>| text.as_ref().map(|text| CString::new(text.as_str()).expect("no zero"));
        let pointer = |text: &Option<CString>| text.as_ref().map_or(ptr::null(), |text| text.as_ptr());
        let (name, guid, location) = (c(&self.name), c(&self.guid), c(&self.location));
        unsafe {
            fmi2Instantiate(
                pointer(&name),
                self.fmu_type,
                pointer(&guid),
                pointer(&location),
                callbacks,
                fmi2False,
                fmi2Boolean::from(self.logging_on),
            )
        }
    }

    /// The message of a rejected instantiation.
    pub fn refusal(&self) -> String {
        let (component, messages) = self.run();
        assert!(component.is_null(), "must be refused");
        let messages = messages.borrow();
        assert_eq!(messages.len(), 1, "one message: {messages:?}");
        assert_eq!(messages[0].status, fmi2Error);
        messages[0].text.clone()
    }
}

/// An instance with its log and its variable table.
pub struct Fmu {
    pub component: fmi2Component,
    pub messages: Box<Messages>,
    pub table: Interface,
}

impl Fmu {
    /// Freshly instantiated.
    pub fn new(text: &str) -> Self {
        let resources = Resources::with(text);
        let (component, messages) = Attempt::of(text, &resources).run();
        assert!(!component.is_null(), "refused: {messages:?}");
        Self { component, messages, table: table(text) }
    }

    /// Freshly instantiated for Model Exchange.
    pub fn exchanged(text: &str) -> Self {
        Self::of_kind(text, fmi2ModelExchange)
    }

    /// Freshly instantiated from an FMU of both interface types.
    pub fn of_kind(text: &str, fmu_type: fmi2Type) -> Self {
        let resources = Resources::with(text);
        let table = table_with_states(text);
        let guid = Some(guid(text, table.variables()));
        let (component, messages) = Attempt { fmu_type, guid, ..Attempt::of(text, &resources) }.run();
        assert!(!component.is_null(), "refused: {messages:?}");
        Self { component, messages, table }
    }

    /// The shipped model, in Initialization Mode at `start_s`.
    pub fn initializing(start_s: f64) -> Self {
        let fmu = Self::new(WING);
        fmu.setup(start_s, None);
        unsafe { fmu.ok(fmi2EnterInitializationMode(fmu.component)) };
        fmu
    }

    /// The shipped model, ready to step from t = 0.
    pub fn stepping() -> Self {
        let fmu = Self::initializing(0.0);
        unsafe { fmu.ok(fmi2ExitInitializationMode(fmu.component)) };
        fmu
    }

    /// Sets up an experiment without a tolerance.
    pub fn setup(&self, start_s: f64, stop_s: Option<f64>) {
        let stop = (fmi2Boolean::from(stop_s.is_some()), stop_s.unwrap_or(0.0));
        unsafe { self.ok(fmi2SetupExperiment(self.component, 0, 0.0, start_s, stop.0, stop.1)) };
    }

    /// Panics and prints the log unless a call succeeded.
    pub fn ok(&self, status: fmi2Status) {
        assert_eq!(status, fmi2OK, "{:?}", self.messages.borrow().last());
    }

    /// Panics unless a call was rejected with `expected` and one message that contains every part.
    pub fn refused(&self, status: fmi2Status, expected: fmi2Status, parts: &[&str]) {
        let text = self.last_message();
        assert_eq!(status, expected, "{text}");
        for part in parts {
            assert!(text.contains(part), "{part:?} is not in {text:?}");
        }
        let category = if expected == fmi2Discard { "logStatusDiscard" } else { "logStatusError" };
        let messages = self.messages.borrow();
        let last = messages.last().expect("a message");
        assert_eq!((last.status, last.category.as_str(), last.instance.as_str()), (expected, category, "wing"));
        drop(messages);
        self.messages.borrow_mut().clear();
    }

    fn last_message(&self) -> String {
        self.messages.borrow().last().map_or_else(|| "(no message)".to_owned(), |last| last.text.clone())
    }

    /// Value reference of a name.
    pub fn reference(&self, name: &str) -> u32 {
        self.table.find(name).unwrap_or_else(|| panic!("no variable {name}")).value_reference
    }

    /// Sets one Real and returns the status.
    pub fn try_set(&self, name: &str, value: f64) -> fmi2Status {
        unsafe { fmi2SetReal(self.component, &self.reference(name), 1, &value) }
    }

    /// Sets one Real.
    pub fn set(&self, name: &str, value: f64) {
        self.ok(self.try_set(name, value));
    }

    /// Reads one Real.
    pub fn get(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        self.ok(unsafe { fmi2GetReal(self.component, &self.reference(name), 1, &mut value) });
        value
    }

    /// Sets one Boolean.
    pub fn set_boolean(&self, name: &str, value: bool) {
        self.ok(unsafe { fmi2SetBoolean(self.component, &self.reference(name), 1, &fmi2Boolean::from(value)) });
    }

    /// Reads one Boolean.
    pub fn get_boolean(&self, name: &str) -> bool {
        let mut value = -1;
        self.ok(unsafe { fmi2GetBoolean(self.component, &self.reference(name), 1, &mut value) });
        value == fmi2True
    }

    /// Takes a step and returns the status.
    pub fn try_step(&self, time_s: f64, step_s: f64) -> fmi2Status {
        unsafe { fmi2DoStep(self.component, time_s, step_s, fmi2True) }
    }

    /// Takes a step.
    pub fn step(&self, time_s: f64, step_s: f64) {
        self.ok(self.try_step(time_s, step_s));
    }

    /// Bits of every Real of the table, in order.
    pub fn bits(&self) -> Vec<u64> {
        use foldwing::interface::Value;
        let reals = self.table.variables().iter().filter(|row| matches!(row.value, Value::Real(_)));
        let references: Vec<u32> = reals.map(|row| row.value_reference).collect();
        let mut values = vec![0.0; references.len()];
        self.ok(unsafe { fmi2GetReal(self.component, references.as_ptr(), references.len(), values.as_mut_ptr()) });
        values.into_iter().map(f64::to_bits).collect()
    }

    /// Saves the state.
    pub fn save(&self) -> fmi2FMUstate {
        let mut state = ptr::null_mut();
        self.ok(unsafe { fmi2GetFMUstate(self.component, &mut state) });
        assert!(!state.is_null());
        state
    }

    /// Bytes of a saved state.
    pub fn serialize(&self, state: fmi2FMUstate) -> Vec<u8> {
        let mut size = 0;
        self.ok(unsafe { fmi2SerializedFMUstateSize(self.component, state, &mut size) });
        let mut bytes = vec![0_u8; size];
        self.ok(unsafe { fmi2SerializeFMUstate(self.component, state, bytes.as_mut_ptr().cast(), size) });
        bytes
    }

    /// Status and handle of a state from bytes.
    pub fn deserialize(&self, bytes: &[u8]) -> (fmi2Status, fmi2FMUstate) {
        let mut state = ptr::null_mut();
        let status = unsafe { fmi2DeSerializeFMUstate(self.component, bytes.as_ptr().cast(), bytes.len(), &mut state) };
        (status, state)
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        unsafe { fmi2FreeInstance(self.component) };
    }
}
