//! Uniform access to an instance of any of three interfaces: Model Exchange of FMI 2.0 and of 3.0, co-simulation of 3.0.

use crate::fmi3::{self, OF_EXCHANGE, OF_STEPS, Phase};
use crate::fmu::Fmu;
use crate::fmu3::Fmu3;
use crate::{calls, model_exchange};
use foldwing::interface::{Interface, Kind, Value};
use foldwing_fmu::exchange::*;
use foldwing_fmu::fmi3::clocks::*;
use foldwing_fmu::fmi3::derivatives::*;
use foldwing_fmu::fmi3::exchange::*;
use foldwing_fmu::fmi3::functions::*;
use foldwing_fmu::fmi3::states::*;
use foldwing_fmu::fmi3::steps::*;
use foldwing_fmu::fmi3::types::fmi3Instance;
use foldwing_fmu::fmi3::values::*;
use foldwing_fmu::functions::*;
use foldwing_fmu::states::*;
use std::ffi::{CStr, c_void};
use std::ptr;

/// Handle of a saved state in either version.
pub type Handle = *mut c_void;

/// An instance.
pub enum Face {
    Exchange2(Fmu),
    Exchange3(Fmu3),
    Steps3(Fmu3),
}

/// Vectors of Model Exchange that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Vector {
    States,
    Derivatives,
    Indicators,
    Nominals,
}

/// A call with its arguments; results are written into them.
#[derive(Debug)]
pub enum Ask {
    Logging(Vec<Option<&'static CStr>>),
    /// FMI 2.0 only.
    Experiment(Times),
    /// In FMI 3.0 with the times.
    EnterInitialization(Times),
    ExitInitialization,
    Terminate,
    Reset,
    EnterEvent,
    Update,
    EnterContinuous,
    EnterStep,
    Completed,
    SetTime(f64),
    SetStates(Vec<f64>),
    Read(Vector, Vec<f64>),
    /// Number of continuous states, or of indicators; FMI 3.0 only.
    Count(Vector, usize),
    Get(Kind, Vec<u32>, Vec<f64>),
    Set(Kind, Vec<u32>, Vec<f64>),
    /// A type of FMI 3.0 that no variable has.
    NoType(usize, Vec<u32>),
    /// Functions that are not legal in any phase.
    Never(usize),
    Save(Handle),
    Restore(Handle),
    Free(Handle),
    Size(Handle, usize),
    Write(Handle, Vec<u8>),
    Parse(Vec<u8>, Handle),
    Step {
        time_s: f64,
        step_s: f64,
        event: bool,
        early: bool,
        last_s: f64,
    },
    Rates(Vec<u32>, Vec<i32>, Vec<f64>),
    Directional {
        unknowns: Vec<u32>,
        knowns: Vec<u32>,
        seed: Vec<f64>,
        result: Vec<f64>,
    },
    Adjoint {
        unknowns: Vec<u32>,
        knowns: Vec<u32>,
        seed: Vec<f64>,
        result: Vec<f64>,
    },
}

/// Times of an experiment in s, and its tolerance.
#[derive(Debug, Clone, Copy)]
pub struct Times {
    pub tolerance: Option<f64>,
    pub start_s: f64,
    pub stop_s: Option<f64>,
}

type OfNoType = unsafe fn(fmi3Instance, *const u32, usize) -> u32;

macro_rules! no_types {
    ($($get:ident $set:ident),*) => {
        &[$(
            (stringify!($get), |i, r, n| unsafe { $get(i, r, n, ptr::null_mut(), 0) }),
            (stringify!($set), |i, r, n| unsafe { $set(i, r, n, ptr::null(), 0) }),
        )*
        ("fmi3GetBinary", |i, r, n| unsafe { fmi3GetBinary(i, r, n, ptr::null_mut(), ptr::null_mut(), 0) }),
        ("fmi3SetBinary", |i, r, n| unsafe { fmi3SetBinary(i, r, n, ptr::null(), ptr::null(), 0) }),
        ("fmi3GetClock", |i, r, n| unsafe { fmi3GetClock(i, r, n, ptr::null_mut()) }),
        ("fmi3SetClock", |i, r, n| unsafe { fmi3SetClock(i, r, n, ptr::null()) })]
    };
}

/// Getters and setters of types that no variable has.
pub const NO_TYPES: &[(&str, OfNoType)] = no_types!(
    fmi3GetFloat32 fmi3SetFloat32, fmi3GetInt8 fmi3SetInt8, fmi3GetUInt8 fmi3SetUInt8, fmi3GetInt16 fmi3SetInt16,
    fmi3GetUInt16 fmi3SetUInt16, fmi3GetUInt32 fmi3SetUInt32, fmi3GetInt64 fmi3SetInt64, fmi3GetUInt64 fmi3SetUInt64,
    fmi3GetString fmi3SetString
);

type OfNothing = unsafe fn(fmi3Instance) -> u32;

/// Functions of FMI 3.0 that this FMU does not support.
pub const NEVER: &[(&str, OfNothing)] = &[
    ("fmi3EnterConfigurationMode", |i| unsafe { fmi3EnterConfigurationMode(i) }),
    ("fmi3ExitConfigurationMode", |i| unsafe { fmi3ExitConfigurationMode(i) }),
    ("fmi3EvaluateDiscreteStates", |i| unsafe { fmi3EvaluateDiscreteStates(i) }),
    ("fmi3ActivateModelPartition", |i| unsafe { fmi3ActivateModelPartition(i, 7, f64::NAN) }),
    ("fmi3GetNumberOfVariableDependencies", |i| unsafe { fmi3GetNumberOfVariableDependencies(i, 0, ptr::null_mut()) }),
    ("fmi3GetVariableDependencies", |i| unsafe {
        fmi3GetVariableDependencies(i, 0, ptr::null_mut(), ptr::null_mut(), ptr::null_mut(), ptr::null_mut(), 3)
    }),
    ("fmi3GetIntervalDecimal", |i| unsafe {
        fmi3GetIntervalDecimal(i, ptr::null(), 1, ptr::null_mut(), ptr::null_mut())
    }),
    ("fmi3GetIntervalFraction", |i| unsafe {
        fmi3GetIntervalFraction(i, ptr::null(), 1, ptr::null_mut(), ptr::null_mut(), ptr::null_mut())
    }),
    ("fmi3GetShiftDecimal", |i| unsafe { fmi3GetShiftDecimal(i, ptr::null(), 1, ptr::null_mut()) }),
    ("fmi3GetShiftFraction", |i| unsafe { fmi3GetShiftFraction(i, ptr::null(), 1, ptr::null_mut(), ptr::null_mut()) }),
    ("fmi3SetIntervalDecimal", |i| unsafe { fmi3SetIntervalDecimal(i, ptr::null(), 1, ptr::null()) }),
    ("fmi3SetIntervalFraction", |i| unsafe { fmi3SetIntervalFraction(i, ptr::null(), 1, ptr::null(), ptr::null()) }),
    ("fmi3SetShiftDecimal", |i| unsafe { fmi3SetShiftDecimal(i, ptr::null(), 1, ptr::null()) }),
    ("fmi3SetShiftFraction", |i| unsafe { fmi3SetShiftFraction(i, ptr::null(), 1, ptr::null(), ptr::null()) }),
];

impl Ask {
    /// Names of the function in FMI 2.0 and 3.0; empty where the version has no such function.
    pub fn names(&self) -> [&'static str; 2] {
        match self {
            Self::Logging(_) => ["fmi2SetDebugLogging", "fmi3SetDebugLogging"],
            Self::Experiment(_) => ["fmi2SetupExperiment", ""],
            Self::EnterInitialization(_) => ["fmi2EnterInitializationMode", "fmi3EnterInitializationMode"],
            Self::ExitInitialization => ["fmi2ExitInitializationMode", "fmi3ExitInitializationMode"],
            Self::Terminate => ["fmi2Terminate", "fmi3Terminate"],
            Self::Reset => ["fmi2Reset", "fmi3Reset"],
            Self::EnterEvent => ["fmi2EnterEventMode", "fmi3EnterEventMode"],
            Self::Update => ["fmi2NewDiscreteStates", "fmi3UpdateDiscreteStates"],
            Self::EnterContinuous => ["fmi2EnterContinuousTimeMode", "fmi3EnterContinuousTimeMode"],
            Self::EnterStep => ["", "fmi3EnterStepMode"],
            Self::Completed => ["fmi2CompletedIntegratorStep", "fmi3CompletedIntegratorStep"],
            Self::SetTime(_) => ["fmi2SetTime", "fmi3SetTime"],
            Self::SetStates(_) => ["fmi2SetContinuousStates", "fmi3SetContinuousStates"],
            Self::Read(Vector::States, _) => ["fmi2GetContinuousStates", "fmi3GetContinuousStates"],
            Self::Read(Vector::Derivatives, _) => ["fmi2GetDerivatives", "fmi3GetContinuousStateDerivatives"],
            Self::Read(Vector::Indicators, _) => ["fmi2GetEventIndicators", "fmi3GetEventIndicators"],
            Self::Read(Vector::Nominals, _) => {
                ["fmi2GetNominalsOfContinuousStates", "fmi3GetNominalsOfContinuousStates"]
            }
            Self::Count(Vector::Indicators, _) => ["", "fmi3GetNumberOfEventIndicators"],
            Self::Count(..) => ["", "fmi3GetNumberOfContinuousStates"],
            Self::Get(Kind::Real, ..) => ["fmi2GetReal", "fmi3GetFloat64"],
            Self::Get(Kind::Integer, ..) => ["fmi2GetInteger", "fmi3GetInt32"],
            Self::Get(Kind::Boolean, ..) => ["fmi2GetBoolean", "fmi3GetBoolean"],
            Self::Get(Kind::String, ..) => ["fmi2GetString", ""],
            Self::Set(Kind::Real, ..) => ["fmi2SetReal", "fmi3SetFloat64"],
            Self::Set(Kind::Integer, ..) => ["fmi2SetInteger", "fmi3SetInt32"],
            Self::Set(Kind::Boolean, ..) => ["fmi2SetBoolean", "fmi3SetBoolean"],
            Self::Set(Kind::String, ..) => ["fmi2SetString", ""],
            Self::NoType(which, _) => ["", NO_TYPES[*which].0],
            Self::Never(which) => ["", NEVER[*which].0],
            Self::Save(_) => ["fmi2GetFMUstate", "fmi3GetFMUState"],
            Self::Restore(_) => ["fmi2SetFMUstate", "fmi3SetFMUState"],
            Self::Free(_) => ["fmi2FreeFMUstate", "fmi3FreeFMUState"],
            Self::Size(..) => ["fmi2SerializedFMUstateSize", "fmi3SerializedFMUStateSize"],
            Self::Write(..) => ["fmi2SerializeFMUstate", "fmi3SerializeFMUState"],
            Self::Parse(..) => ["fmi2DeSerializeFMUstate", "fmi3DeserializeFMUState"],
            Self::Step { .. } => ["fmi2DoStep", "fmi3DoStep"],
            Self::Rates(..) => ["", "fmi3GetOutputDerivatives"],
            Self::Directional { .. } => ["", "fmi3GetDirectionalDerivative"],
            Self::Adjoint { .. } => ["", "fmi3GetAdjointDerivative"],
        }
    }
}

/// The pointer of argument `number`, or null if this is the argument `hole`.
fn holed<T>(pointer: *const T, number: u8, hole: u8) -> *const T {
    if number == hole { ptr::null() } else { pointer }
}

/// The same for an argument to be written.
fn holed_mut<T>(pointer: *mut T, number: u8, hole: u8) -> *mut T {
    if number == hole { ptr::null_mut() } else { pointer }
}

impl Face {
    /// The variable table of the model.
    pub fn table(&self) -> &Interface {
        match self {
            Self::Exchange2(fmu) => &fmu.table,
            Self::Exchange3(fmu) | Self::Steps3(fmu) => &fmu.table,
        }
    }

    /// 0 in FMI 2.0, 1 in FMI 3.0: index into [`Ask::names`].
    pub fn version(&self) -> usize {
        usize::from(!matches!(self, Self::Exchange2(_)))
    }

    /// Returns whether the importer integrates (Model Exchange).
    pub fn exchanges(&self) -> bool {
        !matches!(self, Self::Steps3(_))
    }

    /// Rows of a variable; empty if there is no such variable.
    pub fn rows(&self, reference: u32) -> Vec<u32> {
        match self {
            Self::Exchange2(fmu) => {
                fmu.table.variables().get(reference as usize).map(|_| reference).into_iter().collect()
            }
            Self::Exchange3(fmu) | Self::Steps3(fmu) => {
                fmu.table.arrays().get(reference as usize).map(|array| array.rows.clone()).unwrap_or_default()
            }
        }
    }

    /// Number of value references.
    pub fn references(&self) -> u32 {
        let count = if self.version() == 0 { self.table().variables().len() } else { self.table().arrays().len() };
        u32::try_from(count).expect("few")
    }

    /// Messages since the last call: status, category, text.
    pub fn told(&self) -> Vec<(u32, String, String)> {
        match self {
            Self::Exchange2(fmu) => fmu
                .messages
                .borrow_mut()
                .drain(..)
                .map(|message| (message.status, message.category, message.text))
                .collect(),
            Self::Exchange3(fmu) | Self::Steps3(fmu) => fmu.environment.messages.borrow_mut().drain(..).collect(),
        }
    }

    /// Bytes of a saved state.
    pub fn serialize(&self, state: Handle) -> Vec<u8> {
        match self {
            Self::Exchange2(fmu) => fmu.serialize(state),
            Self::Exchange3(fmu) | Self::Steps3(fmu) => fmu.serialize(state),
        }
    }

    /// Bits of every Real.
    pub fn bits(&self) -> Vec<u64> {
        match self {
            Self::Exchange2(fmu) => fmu.bits(),
            Self::Exchange3(fmu) | Self::Steps3(fmu) => fmu.bits(),
        }
    }

    /// Name of a Real, given its index in [`Face::bits`].
    pub fn real(&self, place: usize) -> String {
        let table = match self {
            Self::Exchange2(fmu) => &fmu.table,
            Self::Exchange3(fmu) | Self::Steps3(fmu) => &fmu.table,
        };
        let mut reals = table.variables().iter().filter(|row| matches!(row.value, Value::Real(_)));
        reals.nth(place).map_or_else(String::new, |row| row.name.clone())
    }

    /// The phase of the instance, from the error message of a call that is never legal.
    pub fn phase(&self) -> Phase {
        let (name, phases) = match self {
            Self::Exchange2(fmu) => {
                assert_eq!(unsafe { fmi2DoStep(fmu.component, 0.0, 1.0, 1) }, 3);
                ("fmi2DoStep", OF_EXCHANGE.as_slice())
            }
            Self::Exchange3(fmu) | Self::Steps3(fmu) => {
                assert_eq!(unsafe { fmi3EnterConfigurationMode(fmu.instance) }, 3);
                let phases: &[Phase] = if self.exchanges() { &OF_EXCHANGE } else { &OF_STEPS };
                ("fmi3EnterConfigurationMode", phases)
            }
        };
        let text = self.told().pop().expect("a refusal is told").2;
        let rest = text.strip_prefix(&format!("{name}: not legal ")).unwrap_or_else(|| panic!("{text}"));
        let found = phases.iter().find(|phase| rest.starts_with(&self.phrase(**phase)));
        *found.unwrap_or_else(|| panic!("{text}"))
    }

    /// Name of a phase in the terms of the version.
    pub fn phrase(&self, phase: Phase) -> String {
        if self.version() == 0 { phase.phrase().replace("fmi3", "fmi2") } else { phase.phrase().to_owned() }
    }

    /// Returns whether a function is legal in a phase by the table of the standard.
    pub fn is_legal(&self, name: &str, phase: Phase) -> bool {
        let phases: &[Phase] = if self.exchanges() { &OF_EXCHANGE } else { &OF_STEPS };
        let column = phases.iter().position(|known| *known == phase).expect("a phase of the kind");
        let cells = if self.version() == 0 {
            model_exchange::TABLE.iter().find(|row| row.0 == name).map(|row| row.1)
        } else {
            let same = match &name[..7] {
                _ if fmi3::TABLE.iter().any(|row| row.0 == name) => name,
                "fmi3Get"
                    if NO_TYPES.iter().any(|of| of.0 == name)
                        || name.ends_with("Int32")
                        || name.ends_with("Boolean") =>
                {
                    "fmi3GetFloat64"
                }
                "fmi3Set"
                    if NO_TYPES.iter().any(|of| of.0 == name)
                        || name.ends_with("Int32")
                        || name.ends_with("Boolean") =>
                {
                    "fmi3SetFloat64"
                }
                _ => return false,
            };
            let row = fmi3::TABLE.iter().find(|row| row.0 == same);
            row.map(|row| if self.exchanges() { row.2 } else { row.1 })
        };
        cells.unwrap_or_else(|| panic!("{name} is in no table")).split(' ').nth(column) == Some("x")
    }

    /// Makes a call, with null for argument number `hole`, counted from 1.
    pub fn make(&self, ask: &mut Ask, hole: u8) -> u32 {
        match self {
            Self::Exchange2(fmu) => unsafe { of_fmi2(fmu.component, ask, hole) },
            Self::Exchange3(fmu) | Self::Steps3(fmu) => unsafe { of_fmi3(fmu.instance, ask, hole) },
        }
    }
}

unsafe fn of_fmi2(c: Handle, ask: &mut Ask, hole: u8) -> u32 {
    let mut info = calls::no_info();
    let (mut event, mut end) = (0, 0);
    unsafe {
        match ask {
            Ask::Logging(names) => {
                let names: Vec<_> = names.iter().map(|name| name.map_or(ptr::null(), CStr::as_ptr)).collect();
                fmi2SetDebugLogging(c, 1, names.len(), names.as_ptr())
            }
            Ask::Experiment(Times { tolerance, start_s, stop_s }) => fmi2SetupExperiment(
                c,
                i32::from(tolerance.is_some()),
                tolerance.unwrap_or(0.0),
                *start_s,
                i32::from(stop_s.is_some()),
                stop_s.unwrap_or(0.0),
            ),
            Ask::EnterInitialization(_) => fmi2EnterInitializationMode(c),
            Ask::ExitInitialization => fmi2ExitInitializationMode(c),
            Ask::Terminate => fmi2Terminate(c),
            Ask::Reset => fmi2Reset(c),
            Ask::EnterEvent => fmi2EnterEventMode(c),
            Ask::Update => fmi2NewDiscreteStates(c, holed_mut(&mut info, 1, hole)),
            Ask::EnterContinuous => fmi2EnterContinuousTimeMode(c),
            Ask::Completed => fmi2CompletedIntegratorStep(c, 1, holed_mut(&mut event, 1, hole), &mut end),
            Ask::SetTime(time_s) => fmi2SetTime(c, *time_s),
            Ask::SetStates(states) => fmi2SetContinuousStates(c, holed(states.as_ptr(), 1, hole), states.len()),
            Ask::Read(which, values) => {
                let (values, n) = (holed_mut(values.as_mut_ptr(), 1, hole), values.len());
                match which {
                    Vector::States => fmi2GetContinuousStates(c, values, n),
                    Vector::Derivatives => fmi2GetDerivatives(c, values, n),
                    Vector::Indicators => fmi2GetEventIndicators(c, values, n),
                    Vector::Nominals => fmi2GetNominalsOfContinuousStates(c, values, n),
                }
            }
            Ask::Get(kind, references, values) => {
                let (vr, n) = (holed(references.as_ptr(), 1, hole), references.len());
                let mut whole = vec![0; values.len()];
                match kind {
                    Kind::Real => fmi2GetReal(c, vr, n, holed_mut(values.as_mut_ptr(), 2, hole)),
                    Kind::Integer => fmi2GetInteger(c, vr, n, holed_mut(whole.as_mut_ptr(), 2, hole)),
                    Kind::Boolean => fmi2GetBoolean(c, vr, n, holed_mut(whole.as_mut_ptr(), 2, hole)),
                    Kind::String => fmi2GetString(c, vr, n, ptr::null_mut()),
                }
            }
            Ask::Set(kind, references, values) => {
                let (vr, n) = (holed(references.as_ptr(), 1, hole), references.len());
                let whole: Vec<i32> = values.iter().map(|value| *value as i32).collect();
                match kind {
                    Kind::Real => fmi2SetReal(c, vr, n, holed(values.as_ptr(), 2, hole)),
                    Kind::Integer => fmi2SetInteger(c, vr, n, holed(whole.as_ptr(), 2, hole)),
                    Kind::Boolean => fmi2SetBoolean(c, vr, n, holed(whole.as_ptr(), 2, hole)),
                    Kind::String => fmi2SetString(c, vr, n, ptr::null()),
                }
            }
            Ask::Save(handle) => fmi2GetFMUstate(c, holed_mut(handle, 1, hole)),
            Ask::Restore(handle) => fmi2SetFMUstate(c, *handle),
            Ask::Free(handle) => fmi2FreeFMUstate(c, holed_mut(handle, 1, hole)),
            Ask::Size(handle, size) => fmi2SerializedFMUstateSize(c, *handle, holed_mut(size, 1, hole)),
            Ask::Write(handle, room) => {
                fmi2SerializeFMUstate(c, *handle, holed_mut(room.as_mut_ptr().cast(), 1, hole), room.len())
            }
            Ask::Parse(bytes, handle) => fmi2DeSerializeFMUstate(
                c,
                holed(bytes.as_ptr().cast(), 2, hole),
                bytes.len(),
                holed_mut(handle, 1, hole),
            ),
            Ask::Step { time_s, step_s, .. } => fmi2DoStep(c, *time_s, *step_s, 1),
            other => panic!("FMI 2.0 has no {other:?}"),
        }
    }
}

unsafe fn of_fmi3(i: fmi3Instance, ask: &mut Ask, hole: u8) -> u32 {
    let (mut flags, mut next_s) = ([false; 5], 0.0);
    unsafe {
        match ask {
            Ask::Logging(names) => {
                let names: Vec<_> = names.iter().map(|name| name.map_or(ptr::null(), CStr::as_ptr)).collect();
                fmi3SetDebugLogging(i, true, names.len(), names.as_ptr())
            }
            Ask::EnterInitialization(Times { tolerance, start_s, stop_s }) => fmi3EnterInitializationMode(
                i,
                tolerance.is_some(),
                tolerance.unwrap_or(0.0),
                *start_s,
                stop_s.is_some(),
                stop_s.unwrap_or(0.0),
            ),
            Ask::ExitInitialization => fmi3ExitInitializationMode(i),
            Ask::Terminate => fmi3Terminate(i),
            Ask::Reset => fmi3Reset(i),
            Ask::EnterEvent => fmi3EnterEventMode(i),
            Ask::Update => {
                let [a, b, c, d, e] = &mut flags;
                fmi3UpdateDiscreteStates(i, holed_mut(a, 1, hole), b, c, d, e, holed_mut(&mut next_s, 2, hole))
            }
            Ask::EnterContinuous => fmi3EnterContinuousTimeMode(i),
            Ask::EnterStep => fmi3EnterStepMode(i),
            Ask::Completed => {
                let [event, end, ..] = &mut flags;
                fmi3CompletedIntegratorStep(i, true, holed_mut(event, 1, hole), holed_mut(end, 2, hole))
            }
            Ask::SetTime(time_s) => fmi3SetTime(i, *time_s),
            Ask::SetStates(states) => fmi3SetContinuousStates(i, holed(states.as_ptr(), 1, hole), states.len()),
            Ask::Read(which, values) => {
                let (values, n) = (holed_mut(values.as_mut_ptr(), 1, hole), values.len());
                match which {
                    Vector::States => fmi3GetContinuousStates(i, values, n),
                    Vector::Derivatives => fmi3GetContinuousStateDerivatives(i, values, n),
                    Vector::Indicators => fmi3GetEventIndicators(i, values, n),
                    Vector::Nominals => fmi3GetNominalsOfContinuousStates(i, values, n),
                }
            }
            Ask::Count(Vector::Indicators, n) => fmi3GetNumberOfEventIndicators(i, holed_mut(n, 1, hole)),
            Ask::Count(_, n) => fmi3GetNumberOfContinuousStates(i, holed_mut(n, 1, hole)),
            Ask::Get(kind, references, values) => {
                let (vr, n, m) = (holed(references.as_ptr(), 1, hole), references.len(), values.len());
                let (mut whole, mut flags) = (vec![0; m], vec![false; m]);
                match kind {
                    Kind::Real => fmi3GetFloat64(i, vr, n, holed_mut(values.as_mut_ptr(), 2, hole), m),
                    Kind::Integer => fmi3GetInt32(i, vr, n, holed_mut(whole.as_mut_ptr(), 2, hole), m),
                    _ => fmi3GetBoolean(i, vr, n, holed_mut(flags.as_mut_ptr(), 2, hole), m),
                }
            }
            Ask::Set(kind, references, values) => {
                let (vr, n, m) = (holed(references.as_ptr(), 1, hole), references.len(), values.len());
                let whole: Vec<i32> = values.iter().map(|value| *value as i32).collect();
                let flags: Vec<bool> = values.iter().map(|value| *value != 0.0).collect();
                match kind {
                    Kind::Real => fmi3SetFloat64(i, vr, n, holed(values.as_ptr(), 2, hole), m),
                    Kind::Integer => fmi3SetInt32(i, vr, n, holed(whole.as_ptr(), 2, hole), m),
                    _ => fmi3SetBoolean(i, vr, n, holed(flags.as_ptr(), 2, hole), m),
                }
            }
            Ask::NoType(which, references) => {
                NO_TYPES[*which].1(i, holed(references.as_ptr(), 1, hole), references.len())
            }
            Ask::Never(which) => NEVER[*which].1(i),
            Ask::Save(handle) => fmi3GetFMUState(i, holed_mut(handle, 1, hole)),
            Ask::Restore(handle) => fmi3SetFMUState(i, *handle),
            Ask::Free(handle) => fmi3FreeFMUState(i, holed_mut(handle, 1, hole)),
            Ask::Size(handle, size) => fmi3SerializedFMUStateSize(i, *handle, holed_mut(size, 1, hole)),
            Ask::Write(handle, room) => {
                fmi3SerializeFMUState(i, *handle, holed_mut(room.as_mut_ptr(), 1, hole), room.len())
            }
            Ask::Parse(bytes, handle) => {
                fmi3DeserializeFMUState(i, holed(bytes.as_ptr(), 2, hole), bytes.len(), holed_mut(handle, 1, hole))
            }
            Ask::Step { time_s, step_s, event, early, last_s } => {
                let mut end = true;
                let status = fmi3DoStep(
                    i,
                    *time_s,
                    *step_s,
                    true,
                    holed_mut(event, 1, hole),
                    &mut end,
                    early,
                    holed_mut(last_s, 2, hole),
                );
                assert!(status != 0 || !end, "nothing ends a simulation");
                status
            }
            Ask::Rates(references, orders, values) => fmi3GetOutputDerivatives(
                i,
                holed(references.as_ptr(), 1, hole),
                references.len(),
                holed(orders.as_ptr(), 2, hole),
                values.as_mut_ptr(),
                values.len(),
            ),
            Ask::Directional { unknowns, knowns, seed, result } => fmi3GetDirectionalDerivative(
                i,
                holed(unknowns.as_ptr(), 1, hole),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                holed(seed.as_ptr(), 2, hole),
                seed.len(),
                result.as_mut_ptr(),
                result.len(),
            ),
            Ask::Adjoint { unknowns, knowns, seed, result } => fmi3GetAdjointDerivative(
                i,
                holed(unknowns.as_ptr(), 1, hole),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                holed(seed.as_ptr(), 2, hole),
                seed.len(),
                result.as_mut_ptr(),
                result.len(),
            ),
            Ask::Experiment(_) => panic!("FMI 3.0 has no fmi3SetupExperiment"),
        }
    }
}
