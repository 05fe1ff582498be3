//! Construction of the table: signals with their positions in the flat vectors, and scalar variables.

use crate::interface::cause::Depends;
use crate::interface::counter::{Counter, Duration};
use crate::interface::known::{Input, Known, Parameter};
use crate::interface::{Causality, Initial, Value, Variability, Variable};
use foldwing_engine::load::Wrench;
use foldwing_engine::machine::{Machine, UNLIMITED};
use foldwing_engine::plant::{FACTOR_RANGE, Inputs, OutputLayout, OutputSet, Parameters};
use std::mem::offset_of;

/// Components of a vector.
const AXES: [&str; 3] = ["x", "y", "z"];
/// Components of a quaternion.
const QUATERNION: [&str; 4] = ["w", "x", "y", "z"];

pub(super) type Range = Option<(f64, f64)>;
pub(super) const NON_NEGATIVE: Range = Some((0.0, UNLIMITED));
pub(super) const FACTOR: Range = Some(FACTOR_RANGE);
/// A fold joint starts within one revolution in either direction.
pub(super) const TURN: Range = Some((-360_f64.to_radians(), 360_f64.to_radians()));
pub(super) const TOLERANCE: Range = Some((1e-12, 1e-1));
/// Positive numbers; the bounds only exclude zero and meaningless values.
pub(super) const POSITIVE: Range = Some((1e-30, UNLIMITED));

/// Shape of a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// One number.
    Scalar,
    /// `x`, `y`, `z`.
    Vector,
    /// `w`, `x`, `y`, `z`.
    Quaternion,
}

impl Shape {
    /// Names of the components; for a scalar one empty name.
    pub fn components(self) -> &'static [&'static str] {
        match self {
            Self::Scalar => &[""],
            Self::Vector => &AXES,
            Self::Quaternion => &QUATERNION,
        }
    }

    /// Position of a component after the signal's first number in the flat vector: nalgebra stores quaternions as `x, y, z, w`.
    fn place(self, component: usize) -> usize {
        match self {
            Self::Scalar | Self::Vector => component,
            Self::Quaternion => (component + 3) % 4,
        }
    }
}

/// Quantity of the model with its name, shape and position, flattened into [`Variable`]s for FMI 2.0.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Name without component.
    pub name: String,
    /// Shape.
    pub shape: Shape,
    /// Causality.
    pub causality: Causality,
    /// Row of its first component; the others follow.
    pub first_reference: u32,
    /// Position of its first number in the flat vector of inputs, parameters or outputs; `None` for time and locals.
    pub place: Option<usize>,
    /// Description; `{}` is the component.
    pub(super) meaning: String,
    /// The array of which it is an element, with others of its kind; otherwise it is a separate variable in FMI 3.0.
    pub(super) array: Option<ArrayText>,
}

/// Name and meaning of an array of signals; `{}` is the component.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ArrayText {
    pub name: String,
    pub meaning: String,
}

/// Source of a row's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// The independent variable.
    Time,
    /// In [`Inputs::values`].
    Input(usize),
    /// In [`Parameters::values`].
    Parameter(usize),
    /// In [`foldwing_engine::plant::Outputs::values`].
    Output(usize),
    /// A counter of the time integration.
    Local(Counter),
    /// A duration of communication steps.
    Duration(Duration),
    /// A continuous state.
    State(usize),
    /// Its derivative in time.
    Derivative(usize),
    /// An event indicator.
    Indicator(usize),
}

impl Place {
    /// Index of an input's value in [`Inputs::values`].
    pub(super) fn input(self) -> Option<usize> {
        match self {
            Self::Input(index) => Some(index),
            Self::Time
            | Self::Parameter(_)
            | Self::Output(_)
            | Self::Local(_)
            | Self::Duration(_)
            | Self::State(_)
            | Self::Derivative(_)
            | Self::Indicator(_) => None,
        }
    }

    /// Index of an output's value in [`foldwing_engine::plant::Outputs::values`].
    pub(super) fn output(self) -> Option<usize> {
        match self {
            Self::Output(index) => Some(index),
            Self::Time
            | Self::Input(_)
            | Self::Parameter(_)
            | Self::Local(_)
            | Self::Duration(_)
            | Self::State(_)
            | Self::Derivative(_)
            | Self::Indicator(_) => None,
        }
    }
}

/// Data of a row in addition to its [`Variable`].
#[derive(Debug, Clone)]
pub(super) struct Bound {
    /// Source of the row's value.
    pub place: Place,
    /// The known that the row represents, if others may depend on it.
    pub known: Option<Known>,
    /// Dependencies of its value, an index into [`Table::depends`].
    pub depends: Option<usize>,
    /// Outputs that must have been computed before it is read.
    pub needs: OutputSet,
}

/// Type of a row's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    /// Real with a declared type.
    Real(&'static str),
    /// Integer.
    Integer,
    /// Boolean.
    Boolean,
}

impl Type {
    fn value(self, number: f64) -> Value {
        match self {
            Self::Real(_) => Value::Real(number),
            Self::Integer => Value::Integer(number as i32),
            Self::Boolean => Value::Boolean(number != 0.0),
        }
    }

    fn declared(self) -> Option<&'static str> {
        match self {
            Self::Real(declared) => Some(declared),
            Self::Integer | Self::Boolean => None,
        }
    }
}

/// Name and meaning of a signal; `{}` is the component.
pub(super) struct Text {
    /// Name without component.
    pub name: String,
    /// Description.
    pub meaning: String,
    /// The array of which the signal is an element.
    array: Option<ArrayText>,
}

impl Text {
    pub fn new(name: impl Into<String>, meaning: impl Into<String>) -> Self {
        Self { name: name.into(), meaning: meaning.into(), array: None }
    }

    /// The text as the next element of an array: the signals of an array are added in its order and differ in position only.
    pub fn in_array(self, name: impl Into<String>, meaning: impl Into<String>) -> Self {
        Self { array: Some(ArrayText { name: name.into(), meaning: meaning.into() }), ..self }
    }
}

/// Table under construction.
pub(super) struct Table {
    /// Start values and positions of the inputs.
    pub inputs: Inputs,
    /// Start values and positions of the parameters.
    pub parameters: Parameters,
    /// Positions of the outputs.
    pub outputs: OutputLayout,
    pub variables: Vec<Variable>,
    pub bounds: Vec<Bound>,
    pub signals: Vec<Signal>,
    /// Dependencies of outputs, each entry shared by the components of a signal.
    pub depends: Vec<Depends>,
}

/// Position, in a flat vector, of a field of element `$index` of a segment.
macro_rules! place {
    ($segment:expr, $index:expr, $type:ty, $field:ident) => {
        $segment.place($index, std::mem::offset_of!($type, $field))
    };
}
pub(super) use place;

impl Table {
    /// A table with `time` only.
    pub fn new(machine: &Machine) -> Self {
        let mut table = Self {
            inputs: Inputs::of(machine),
            parameters: Parameters::of(machine),
            outputs: OutputLayout::new(machine),
            variables: Vec::new(),
            bounds: Vec::new(),
            signals: Vec::new(),
            depends: Vec::new(),
        };
        let bound = Bound { place: Place::Time, known: Some(Known::Time), depends: None, needs: OutputSet::NONE };
        let text = Text::new("time", "simulation time");
        let row = (Causality::Independent, Variability::Continuous, Type::Real("Time"), None);
        table.push(text, row, Shape::Scalar, |_| (bound.clone(), 0.0));
        table
    }

    /// Adds an input from `place` on.
    pub fn input(&mut self, known: Input, place: usize, shape: Shape, of: Type, text: Text) {
        let variability = match of {
            Type::Real(_) => Variability::Continuous,
            Type::Integer | Type::Boolean => Variability::Discrete,
        };
        let starts: Vec<f64> = self.inputs.values()[place..place + shape.components().len()].to_vec();
        self.push(text, (Causality::Input, variability, of, None), shape, |component| {
            let (place, known) = (Place::Input(place + component), Some(Known::Input(known)));
            (Bound { place, known, depends: None, needs: OutputSet::NONE }, starts[component])
        });
    }

    /// Adds a parameter at `place`.
    pub fn parameter(
        &mut self,
        known: Parameter,
        place: usize,
        variability: Variability,
        declared: &'static str,
        range: Range,
        text: Text,
    ) {
        let start = self.parameters.values()[place];
        let row = (Causality::Parameter, variability, Type::Real(declared), range);
        self.push(text, row, Shape::Scalar, |_| {
            let (place, known) = (Place::Parameter(place), Some(Known::Parameter(known)));
            (Bound { place, known, depends: None, needs: OutputSet::NONE }, start)
        });
    }

    /// Adds a continuous output from `place` on.
    pub fn output(
        &mut self,
        (place, needs): (usize, OutputSet),
        shape: Shape,
        declared: &'static str,
        depends: Depends,
        text: Text,
    ) {
        self.any_output((place, needs), shape, (Variability::Continuous, Type::Real(declared)), depends, text);
    }

    /// Adds an output that changes at events only, at `place`.
    pub fn event_output(&mut self, place: usize, of: Type, depends: Depends, text: Text) {
        self.any_output((place, OutputSet::JOINTS), Shape::Scalar, (Variability::Discrete, of), depends, text);
    }

    fn any_output(
        &mut self,
        (place, needs): (usize, OutputSet),
        shape: Shape,
        (variability, of): (Variability, Type),
        depends: Depends,
        text: Text,
    ) {
        self.depends.push(depends);
        let depends = Some(self.depends.len() - 1);
        self.push(text, (Causality::Output, variability, of, None), shape, |component| {
            (Bound { place: Place::Output(place + shape.place(component)), known: None, depends, needs }, 0.0)
        });
    }

    /// Adds a local variable.
    pub fn local(&mut self, place: Place, of: Type, text: Text) {
        let bound = Bound { place, known: None, depends: None, needs: OutputSet::NONE };
        let row = (Causality::Local, Variability::Discrete, of, None);
        self.push(text, row, Shape::Scalar, |_| (bound.clone(), 0.0));
    }

    /// Adds a continuous state or its derivative.
    pub fn state(&mut self, place: Place, declared: &'static str, nominal: Option<f64>, of: Option<u32>, text: Text) {
        let bound = Bound { place, known: None, depends: None, needs: OutputSet::NONE };
        let row = (Causality::Local, Variability::Continuous, Type::Real(declared), None);
        self.push(text, row, Shape::Scalar, |_| (bound.clone(), 0.0));
        if let Some(row) = self.variables.last_mut() {
            (row.nominal, row.derivative_of) = (nominal, of);
        }
    }

    /// Adds a signal: one row per component, with the [`Bound`] and the start value given by `component`.
    fn push(
        &mut self,
        text: Text,
        (causality, variability, of, range): (Causality, Variability, Type, Range),
        shape: Shape,
        component: impl Fn(usize) -> (Bound, f64),
    ) {
        let reference = |rows: usize| u32::try_from(rows).expect("fewer than 2^32 variables");
        let first_reference = reference(self.variables.len());
        let mut first = None;
        for (i, key) in shape.components().iter().enumerate() {
            let (bound, start) = component(i);
            if let Place::Input(place) | Place::Parameter(place) | Place::Output(place) = bound.place {
                first = Some(first.map_or(place, |first: usize| first.min(place)));
            }
            self.bounds.push(bound);
            self.variables.push(Variable {
                name: if shape == Shape::Scalar { text.name.clone() } else { format!("{}.{key}", text.name) },
                value_reference: reference(self.variables.len()),
                causality,
                variability,
                initial: match causality {
                    Causality::Input | Causality::Independent => None,
                    Causality::Parameter => Some(Initial::Exact),
                    Causality::Output | Causality::Local => Some(Initial::Calculated),
                },
                value: of.value(start),
                declared_type: of.declared(),
                range,
                description: text.meaning.replace("{}", key),
                nominal: None,
                derivative_of: None,
            });
        }
        let Text { name, meaning, array } = text;
        self.signals.push(Signal { name, shape, causality, first_reference, place: first, meaning, array });
    }
}

/// Rows of a force and a moment in succession.
pub(super) fn wrench(
    table: &mut Table,
    (first, needs): (usize, OutputSet),
    depends: &Depends,
    [force, moment]: [Text; 2],
) {
    let at = |offset: usize| (first + offset / size_of::<f64>(), needs);
    table.output(at(offset_of!(Wrench, force_n)), Shape::Vector, "Force", depends.clone(), force);
    table.output(at(offset_of!(Wrench, moment_n_m)), Shape::Vector, "Moment", depends.clone(), moment);
}

/// Names of the force and the moment of a wrench, with their meanings.
pub(super) fn wrench_texts(name: &str, [force, moment]: [&str; 2]) -> [Text; 2] {
    [Text::new(format!("{name}.force"), force), Text::new(format!("{name}.moment"), moment)]
}

/// Key, field, position, variability, declared type, range, meaning.
pub(super) type ParameterRow<Field> = (&'static str, Field, usize, Variability, &'static str, Range, &'static str);
