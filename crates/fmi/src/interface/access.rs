//! Reading and writing rows: checks and errors.

use crate::interface::table::{Bound, NON_NEGATIVE, Place};
use crate::interface::{Causality, Value, Variability, Variable};
use foldwing_engine::plant::{OutputSet, Outputs, Plant};

/// Error of reading or writing a row.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AccessError {
    /// No such row.
    #[error("unknown value reference {value_reference}: this model has 0 to {last}")]
    UnknownReference {
        /// The requested value reference.
        value_reference: u32,
        /// Last value reference of the table.
        last: u32,
    },
    /// The row has another type.
    #[error("variable {name} (value reference {value_reference}) has type {actual}, not {requested}")]
    WrongType {
        /// Name of the row.
        name: String,
        /// Its value reference.
        value_reference: u32,
        /// Its type.
        actual: &'static str,
        /// The requested type.
        requested: &'static str,
    },
    /// The row is an output, a local variable or time, which cannot be set.
    #[error("variable {name} cannot be set: it is {causality}; only inputs and parameters can")]
    NotSettable {
        /// Name of the row.
        name: String,
        /// Its causality.
        causality: &'static str,
    },
    /// The row is a continuous state, and the FMU integrates.
    #[error(
        "continuous state {name} cannot be set in co-simulation after the start: the FMU integrates it; only Model \
         Exchange allows this"
    )]
    State {
        /// Name of the row.
        name: String,
    },
    /// The row is a fixed parameter and the initialisation has ended.
    #[error("parameter {name} is fixed: it can be set before the end of the initialisation only")]
    Fixed {
        /// Name of the row.
        name: String,
    },
    /// Only continuous inputs have a time derivative that can be set.
    #[error("variable {name} has no time derivative to set: only Real inputs have one")]
    NotAnInput {
        /// Name of the row.
        name: String,
    },
    /// Only outputs have derivatives.
    #[error("no derivative of variable {name} is available: unknowns must be Real outputs")]
    NotAnUnknown {
        /// Name of the row.
        name: String,
    },
    /// The row is not a known at this stage.
    #[error(
        "no derivative with respect to variable {name}: knowns must be Real inputs and, in Initialization Mode, parameters"
    )]
    NotAKnown {
        /// Name of the row.
        name: String,
    },
    /// Only derivatives of states and outputs have derivatives in Model Exchange.
    #[error("no derivative of variable {name} is available: unknowns must be derivatives of states and Real outputs")]
    NotAnExchangeUnknown {
        /// Name of the row.
        name: String,
    },
    /// The row is not a known of Model Exchange.
    #[error(
        "no derivative with respect to variable {name}: knowns must be continuous states, Real inputs, tunable \
             parameters and time"
    )]
    NotAnExchangeKnown {
        /// Name of the row.
        name: String,
    },
    /// No such derivative.
    #[error("variable {name} has no time derivative of order {order}: inputs have order 1, outputs 1 and higher")]
    Order {
        /// Name of the row.
        name: String,
        /// The rejected order.
        order: i32,
    },
    /// The number of values differs from that of the variables.
    #[error(
        "{given} values were passed for {variables} variables that have {own}: pass a value for each element of an \
         array, row by row"
    )]
    Count {
        /// Number of values passed.
        given: usize,
        /// Number of variables.
        variables: usize,
        /// Number of values that they need.
        own: usize,
    },
    /// NaN or infinite.
    #[error("variable {name} cannot be {value}: the value must be finite")]
    NotFinite {
        /// Name of the row.
        name: String,
        /// The rejected value.
        value: f64,
    },
    /// Outside the range of the row.
    #[error("variable {name} cannot be {value}: it must be {}", bounds(*min, *max, unit))]
    OutOfRange {
        /// Name of the row.
        name: String,
        /// The rejected value.
        value: f64,
        /// Smallest value allowed.
        min: f64,
        /// Largest value allowed.
        max: f64,
        /// Unit of the value and of both bounds.
        unit: &'static str,
    },
}

/// Describes a range, without the bounds that only keep numbers finite: `≥ 0 N.m`, `from 1e-12 to 0.1`.
fn bounds(min: f64, max: f64, unit: &str) -> String {
    let unlimited = NON_NEGATIVE.map_or(f64::INFINITY, |(_, largest)| largest);
    let shown = |value: f64| match value.abs() {
        0.0 | 1e-4..1e6 => value.to_string(),
        _ => format!("{value:e}"),
    };
    let unit = if matches!(unit, "" | "1") { String::new() } else { format!(" {unit}") };
    match (min > -unlimited, max < unlimited) {
        (true, false) if 0.0 < min && min <= 1.0 / unlimited => format!("> 0{unit}"),
        (true, false) => format!("≥ {}{unit}", shown(min)),
        (false, true) => format!("≤ {}{unit}", shown(max)),
        _ => format!("from {} to {}{unit}", shown(min), shown(max)),
    }
}

impl AccessError {
    /// Returns whether the value, not the call, is invalid.
    pub fn is_bad_value(&self) -> bool {
        matches!(self, Self::NotFinite { .. } | Self::OutOfRange { .. })
    }
}

/// Stage of the simulation with respect to setting values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Before the end of the initialisation: fixed parameters can be set.
    Starting,
    /// Between steps: inputs and tunable parameters only.
    Running,
    /// During integration by an importer (Model Exchange): inputs, tunable parameters and continuous states.
    Exchanging,
}

/// Types of variables common to both versions of the standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Real.
    Real,
    /// Integer.
    Integer,
    /// Boolean.
    Boolean,
    /// String: no row has this type.
    String,
}

impl Kind {
    /// Name in FMI 2.0.
    pub fn name(self) -> &'static str {
        match self {
            Self::Real => "Real",
            Self::Integer => "Integer",
            Self::Boolean => "Boolean",
            Self::String => "String",
        }
    }

    /// Name in FMI 3.0.
    pub fn name_of_fmi3(self) -> &'static str {
        match self {
            Self::Real => "Float64",
            Self::Integer => "Int32",
            Self::Boolean => "Boolean",
            Self::String => "String",
        }
    }
}

/// Rust type of a variable type.
pub trait Scalar: Copy {
    /// The type.
    const KIND: Kind;
    /// Converts to a tagged value.
    fn into_value(self) -> Value;
    /// Converts from a tagged value of the same type.
    fn from_value(value: Value) -> Option<Self>;
}

macro_rules! scalar {
    ($type:ty, $variant:ident) => {
        impl Scalar for $type {
            const KIND: Kind = Kind::$variant;
            #[inline]
            fn into_value(self) -> Value {
                Value::$variant(self)
            }
            #[inline]
            fn from_value(value: Value) -> Option<Self> {
                match value {
                    Value::$variant(value) => Some(value),
                    _ => None,
                }
            }
        }
    };
}

scalar!(f64, Real);
scalar!(i32, Integer);
scalar!(bool, Boolean);

impl Value {
    /// The type.
    #[inline]
    pub fn kind(self) -> Kind {
        match self {
            Self::Real(_) => Kind::Real,
            Self::Integer(_) => Kind::Integer,
            Self::Boolean(_) => Kind::Boolean,
        }
    }
}

/// Stages at which a row can be set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Settable {
    Never,
    /// A continuous state: before the start the value is a guess, which the initialisation does not use.
    Guess,
    Starting,
    Always,
}

/// Data for reading and writing a row, packed for speed.
pub(super) struct Slot {
    /// Position of its value.
    pub(super) place: Place,
    /// Outputs that the plant must have computed before it is read.
    pub(super) needs: OutputSet,
    pub(super) kind: Kind,
    pub(super) settable: Settable,
    pub(super) min: f64,
    pub(super) max: f64,
}

impl Slot {
    pub(super) fn new(variable: &Variable, bound: &Bound) -> Self {
        let (min, max) = variable.range.unwrap_or((f64::MIN, f64::MAX));
        let settable = match (variable.causality, variable.variability) {
            (Causality::Input, _) | (Causality::Parameter, Variability::Tunable) => Settable::Always,
            (Causality::Parameter, _) => Settable::Starting,
            (Causality::Local, _) if matches!(bound.place, Place::State(_)) => Settable::Guess,
            (Causality::Output | Causality::Local | Causality::Independent, _) => Settable::Never,
        };
        Self { place: bound.place, needs: bound.needs, kind: variable.value.kind(), settable, min, max }
    }

    /// Returns the current value; inputs and parameters are read from the plant.
    #[inline]
    pub(super) fn read(&self, plant: &Plant, outputs: &Outputs) -> Value {
        let number = match self.place {
            Place::Time => outputs.time_s,
            Place::Input(place) => plant.inputs().values()[place],
            Place::Parameter(place) => plant.parameters().values()[place],
            Place::Output(place) => outputs.values()[place],
            Place::Local(counter) => return Value::Integer(counter.read(&plant.statistics())),
            Place::Duration(duration) => duration.read_s(plant.latency()),
            Place::State(state) => plant.exchange_state(state),
            Place::Derivative(state) => plant.exchange_derivative(state),
            Place::Indicator(indicator) => plant.exchange_indicators().get(indicator).copied().unwrap_or(1.0),
        };
        match self.kind {
            Kind::Real | Kind::String => Value::Real(number),
            Kind::Integer => Value::Integer(number as i32),
            Kind::Boolean => Value::Boolean(number != 0.0),
        }
    }

    /// Sets an input, a parameter or, under an importer's integrator, a continuous state; the caller has checked that the row is one of
    /// these and that the types agree. A guess of a continuous state is ignored: initial values follow from inputs and parameters alone.
    #[inline]
    pub(super) fn write(&self, plant: &mut Plant, value: Value, stage: Stage) {
        let number = match value {
            Value::Real(value) => value,
            Value::Integer(value) => f64::from(value),
            Value::Boolean(value) => f64::from(u8::from(value)),
        };
        match self.place {
            Place::Input(place) => plant.inputs_mut().values_mut()[place] = number,
            Place::Parameter(place) => plant.parameters_mut().values_mut()[place] = number,
            Place::State(state) if stage == Stage::Exchanging => plant.system_mut().set_exchange_state(state, number),
            Place::State(_) => {}
            Place::Time
            | Place::Output(_)
            | Place::Local(_)
            | Place::Duration(_)
            | Place::Derivative(_)
            | Place::Indicator(_) => debug_assert!(false, "{:?} cannot be set to {value:?}", self.place),
        }
    }

    /// Returns whether the value comes from the last evaluation rather than from the importer.
    pub(super) fn is_computed(&self) -> bool {
        let Self { place, .. } = self;
        !matches!(place, Place::Time | Place::Input(_) | Place::Parameter(_))
    }

    /// Returns whether it can be set at events only: a switch or a tunable parameter.
    pub(super) fn is_set_at_events(&self) -> bool {
        self.settable == Settable::Always && !self.is_continuous_input()
    }

    /// Returns whether it is a continuous input.
    pub(super) fn is_continuous_input(&self) -> bool {
        matches!(self.place, Place::Input(_)) && self.kind == Kind::Real
    }
}

impl Variable {
    /// Unit of a Real row; empty for others.
    pub fn unit(&self) -> &'static str {
        let declared = crate::interface::TYPES.iter().find(|declared| Some(declared.name) == self.declared_type);
        declared.map_or("", |declared| declared.unit)
    }
}
