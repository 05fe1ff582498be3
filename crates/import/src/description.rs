//! Model description of an FMU: library, default experiment, variables with types, units and ranges.

use crate::description_file::{Attributes, Root, ScalarVariable};
use crate::description3::{self, Root3};
use foldwing_command::report::{Channel, cell, number};
use foldwing_fmi::interface::Value;
use std::collections::HashMap;
use std::fmt;

/// Model description with interpreted contents.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// `modelName`.
    pub model_name: String,
    /// `guid` or `instantiationToken`, which the library verifies.
    pub guid: String,
    /// Name of the library without its extension.
    pub identifier: String,
    /// Whether the step size may vary.
    pub varies_step: bool,
    /// Default experiment.
    pub experiment: Experiment,
    /// Variables in the order of the file.
    pub variables: Vec<Variable>,
}

/// Default experiment of an FMU, times in s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Experiment {
    /// Start time; 0 if not given.
    pub start_s: f64,
    /// Stop time; one second after the start if not given.
    pub stop_s: f64,
    /// Communication step; a 500th of the duration if not given.
    pub step_s: f64,
}

/// Type of a variable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kind {
    /// Floating-point number.
    Real,
    /// Integer.
    Integer,
    /// Boolean.
    Boolean,
    /// Text.
    String,
    /// Binary or clock of FMI 3.0, which can be neither read nor set.
    Opaque,
    /// Enumeration; its items, each with its value.
    Enumeration(Vec<(String, i32)>),
}

/// Data type of FMI 3.0, named as in its functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "names of the standard")]
pub enum NativeType {
    Float32,
    Float64,
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    Int64,
    UInt64,
    Boolean,
    String,
    Binary,
    Clock,
}

impl NativeType {
    /// Minimum and maximum of an integer type.
    pub fn bounds(self) -> (Option<f64>, Option<f64>) {
        let (least, most) = match self {
            Self::Int8 => (f64::from(i8::MIN), f64::from(i8::MAX)),
            Self::UInt8 => (0.0, f64::from(u8::MAX)),
            Self::Int16 => (f64::from(i16::MIN), f64::from(i16::MAX)),
            Self::UInt16 => (0.0, f64::from(u16::MAX)),
            Self::Int32 => (f64::from(i32::MIN), f64::from(i32::MAX)),
            Self::UInt32 => (0.0, f64::from(u32::MAX)),
            Self::Int64 => (-(2_f64.powi(63)), 2_f64.powi(63)),
            Self::UInt64 => (0.0, 2_f64.powi(64)),
            Self::Float32 | Self::Float64 | Self::Boolean | Self::String | Self::Binary | Self::Clock => {
                return (None, None);
            }
        };
        (Some(least), Some(most))
    }
}

/// Element of a variable of FMI 3.0; a scalar has one element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Element {
    /// Type.
    pub native: NativeType,
    /// Position in row-major order.
    pub place: usize,
    /// Number of elements of the variable.
    pub length: usize,
}

/// Unit of a variable and its display units.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Name in the file.
    pub name: String,
    /// Display units: `displayed = factor · value + offset`.
    pub display: Vec<DisplayUnit>,
}

/// A display unit.
#[derive(Debug, Clone, PartialEq)]
pub struct DisplayUnit {
    /// Name in the file.
    pub name: String,
    /// Ratio of displayed to stored value.
    pub factor: f64,
    /// Displayed value when the stored value is zero.
    pub offset: f64,
}

/// A variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// Value reference, unique among variables of its type except aliases.
    pub value_reference: u32,
    /// `causality` in the file, `local` if not given.
    pub causality: String,
    /// Whether it may be set before the initialisation: inputs, parameters, and start values of other variables.
    pub settable: bool,
    /// Type.
    pub kind: Kind,
    /// Unit.
    pub unit: Option<Unit>,
    /// Minimum and maximum.
    pub range: Option<(f64, f64)>,
    /// Start value in the file.
    pub start: Option<String>,
    /// Element of an array; FMI 3.0 only.
    pub element: Option<Element>,
}

/// A value of any type.
#[derive(Debug, Clone, PartialEq)]
pub enum Datum {
    /// Real, Integer, Enumeration or Boolean.
    Number(Value),
    /// Integer or Enumeration beyond 32 bits.
    Whole(i128),
    /// String.
    Text(String),
}

impl Datum {
    /// An integer of any size.
    pub fn whole(value: i128) -> Self {
        i32::try_from(value).map_or(Self::Whole(value), |value| Self::Number(Value::Integer(value)))
    }

    /// Value as a real number; NaN for text.
    pub fn real(&self) -> f64 {
        match self {
            Self::Number(value) => number(value),
            Self::Whole(value) => *value as f64,
            Self::Text(_) => f64::NAN,
        }
    }

    /// Value as an integer; 0 if it is not a number.
    pub fn integer(&self) -> i128 {
        match self {
            Self::Number(Value::Integer(value)) => i128::from(*value),
            Self::Number(Value::Boolean(value)) => i128::from(*value),
            Self::Whole(value) => *value,
            Self::Number(Value::Real(_)) | Self::Text(_) => 0,
        }
    }
}

/// Checks the identifier, which is used as a file name below `binaries`: it must not lead outside this folder.
fn check_identifier(identifier: &str) -> Result<(), String> {
    let outside = |c: char| c.is_control() || matches!(c, '/' | '\\' | ':');
    if identifier.is_empty() || identifier.starts_with('.') || identifier.contains(outside) {
        let shown: String = identifier.chars().take(60).collect();
        return Err(format!("modelIdentifier {shown:?} is not a library name; allowed: a C identifier"));
    }
    Ok(())
}

impl fmt::Display for Datum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(value) => f.write_str(&cell(value)),
            Self::Whole(value) => value.fmt(f),
            Self::Text(text) => f.write_str(text),
        }
    }
}

impl Description {
    /// Interprets the contents of the file.
    ///
    /// # Errors
    /// A missing or contradictory item; the message names it.
    pub(super) fn new(root: Root, third: Option<Root3>) -> Result<Self, String> {
        let co_simulation = root.co_simulation.ok_or("no element CoSimulation")?;
        check_identifier(&co_simulation.identifier)?;
        let units = root.units.list.into_iter().map(|unit| {
            let display = unit.display.into_iter().map(|display| DisplayUnit {
                name: display.name,
                factor: display.factor.unwrap_or(1.0),
                offset: display.offset.unwrap_or(0.0),
            });
            (unit.name.clone(), Unit { name: unit.name, display: display.collect() })
        });
        let units: HashMap<String, Unit> = units.collect();
        let types = root.types.list.into_iter().map(|declared| (declared.name, declared.attributes));
        let types: HashMap<String, Attributes> = types.collect();
        let (token, absent) = match third {
            Some(_) => (root.token, "no attribute instantiationToken"),
            None => (root.guid, "no attribute guid"),
        };
        let variables = match third {
            Some(third) => description3::variables(third, &units)?,
            None => {
                let list = root.variables.list.into_iter();
                list.map(|variable| Variable::new(variable, &types, &units)).collect::<Result<_, _>>()?
            }
        };
        let experiment = root.experiment;
        let start_s = experiment.start.unwrap_or(0.0);
        let stop_s = experiment.stop.unwrap_or(start_s + 1.0);
        Ok(Self {
            model_name: root.model_name.ok_or("no attribute modelName")?,
            guid: token.ok_or(absent)?,
            identifier: co_simulation.identifier,
            varies_step: co_simulation.varies_step,
            experiment: Experiment { start_s, stop_s, step_s: experiment.step.unwrap_or((stop_s - start_s) / 500.0) },
            variables,
        })
    }

    /// Returns a variable by name.
    pub fn find(&self, name: &str) -> Option<&Variable> {
        self.variables.iter().find(|variable| variable.name == name)
    }
}

impl Variable {
    fn new(
        file: ScalarVariable,
        types: &HashMap<String, Attributes>,
        units: &HashMap<String, Unit>,
    ) -> Result<Self, String> {
        let (own, mut kind) = [
            (file.real, Kind::Real),
            (file.integer, Kind::Integer),
            (file.boolean, Kind::Boolean),
            (file.string, Kind::String),
            (file.enumeration, Kind::Enumeration(vec![])),
        ]
        .into_iter()
        .find_map(|(attributes, kind)| attributes.map(|attributes| (attributes, kind)))
        .ok_or_else(|| format!("variable {}: no type", file.name))?;
        let silent = Attributes::default();
        let declared = own.declared_type.as_ref().and_then(|name| types.get(name)).unwrap_or(&silent);
        if let Kind::Enumeration(words) = &mut kind {
            *words = declared.items.iter().map(|item| (item.name.clone(), item.value)).collect();
        }
        let unit = own.unit.as_ref().or(declared.unit.as_ref());
        let mut unit =
            unit.map(|name| units.get(name).cloned().unwrap_or_else(|| Unit { name: name.clone(), display: vec![] }));
        if own.relative.or(declared.relative) == Some(true) {
            let displays = unit.iter_mut().flat_map(|unit| &mut unit.display);
            displays.for_each(|display| display.offset = 0.0); // a temperature difference has no offset: 5 K are 5 °C
        }
        let (min, max) = (own.min.or(declared.min), own.max.or(declared.max));
        let range =
            (min.is_some() || max.is_some()).then(|| (min.unwrap_or(f64::NEG_INFINITY), max.unwrap_or(f64::INFINITY)));
        let causality = file.causality.unwrap_or_else(|| "local".to_owned());
        let given = matches!(file.initial.as_deref(), Some("exact" | "approx"));
        let settable = (matches!(causality.as_str(), "input" | "parameter") || given)
            && file.variability.as_deref() != Some("constant");
        Ok(Self {
            name: file.name,
            value_reference: file.reference,
            causality,
            settable,
            kind,
            unit,
            range,
            start: own.start,
            element: None,
        })
    }

    /// Parses a value from the command line: a number, optionally followed by a space and a unit; a Boolean, an item of an enumeration, or
    /// text.
    ///
    /// # Errors
    /// The cause and the allowed values.
    pub fn parse(&self, text: &str) -> Result<Datum, String> {
        let value = match &self.kind {
            Kind::Real => Value::Real(self.real(text)?),
            Kind::Integer if self.element.is_some() => return self.whole(text),
            Kind::Integer => Value::Integer(whole(text)?),
            Kind::Enumeration(words) => match words.iter().find(|(word, _)| word == text) {
                Some((_, number)) => Value::Integer(*number),
                None => Value::Integer(whole(text).map_err(|_| format!("`{text}` is not one{}", among(words)))?),
            },
            Kind::Boolean => match text {
                "1" | "true" => Value::Boolean(true),
                "0" | "false" => Value::Boolean(false),
                _ => return Err(format!("`{text}` is not a Boolean; allowed are 0, 1, false and true")),
            },
            Kind::String => return Ok(Datum::Text(text.to_owned())),
            Kind::Opaque => return Err(format!("`{text}`: no value of this type can be given")),
        };
        let number = match value {
            Value::Real(value) => Some(value),
            Value::Integer(value) => Some(f64::from(value)),
            Value::Boolean(_) => None,
        };
        match number {
            Some(number) => self.within(text, number, Datum::Number(value)),
            None => Ok(Datum::Number(value)),
        }
    }

    /// Parses an integer of FMI 3.0, of up to 64 bits.
    fn whole(&self, text: &str) -> Result<Datum, String> {
        let value: i128 = text.parse().map_err(|_| format!("`{text}` is not a whole number"))?;
        self.within(text, value as f64, Datum::whole(value))
    }

    fn within(&self, text: &str, number: f64, value: Datum) -> Result<Datum, String> {
        match self.range {
            Some((min, max)) if !(min..=max).contains(&number) => {
                Err(format!("`{text}` is out of range; allowed is {min:?} to {max:?}{}", self.unit_after_number()))
            }
            _ => Ok(value),
        }
    }

    /// Name of the array if this is an element of one, otherwise of the variable.
    pub fn array_name(&self) -> &str {
        match self.element {
            Some(element) if element.length > 1 => self.name.rfind('[').map_or(&self.name, |at| &self.name[..at]),
            _ => &self.name,
        }
    }

    /// Start value in the description; zero, false or empty if not given.
    pub fn start_value(&self) -> Datum {
        let given = self.start.as_deref().and_then(|start| match self.kind {
            // the start value may be outside the range, which is not checked here
            Kind::Real => start.parse().ok().map(|value| Datum::Number(Value::Real(value))),
            Kind::Integer | Kind::Enumeration(_) => start.parse().ok().map(Datum::whole),
            Kind::Boolean | Kind::String | Kind::Opaque => self.parse(start).ok(),
        });
        given.unwrap_or(match self.kind {
            Kind::Real => Datum::Number(Value::Real(0.0)),
            Kind::Integer | Kind::Enumeration(_) => Datum::Number(Value::Integer(0)),
            Kind::Boolean => Datum::Number(Value::Boolean(false)),
            Kind::String | Kind::Opaque => Datum::Text(String::new()),
        })
    }

    /// Parses a real number and converts it to the variable's unit.
    fn real(&self, text: &str) -> Result<f64, String> {
        let (number, unit) = text.split_once(' ').map_or((text, None), |(number, unit)| (number, Some(unit.trim())));
        let number = number.parse::<f64>().map_err(|_| format!("`{number}` is not a number"))?;
        let Some(name) = unit else { return Ok(number) };
        let Some(own) = &self.unit else { return Err(format!("`{name}`: the variable has no unit")) };
        if own.name == name {
            return Ok(number);
        }
        match own.display.iter().find(|display| display.name == name) {
            Some(display) => Ok((number - display.offset) / display.factor),
            None => {
                let others = own.display.iter().map(|display| format!(", {}", display.name)).collect::<String>();
                Err(format!("`{name}` is not one of its units; allowed: {}{others}", own.name))
            }
        }
    }

    /// The unit preceded by a space; empty if there is none.
    pub fn unit_after_number(&self) -> String {
        self.unit.as_ref().map(|unit| format!(" {}", unit.name)).unwrap_or_default()
    }
}

impl Channel for Variable {
    const LISTED_BY: &'static str = "`foldwing run X.fmu --list-variables`";

    fn name(&self) -> &str {
        &self.name
    }

    fn is_input(&self) -> bool {
        self.causality == "input"
    }

    fn kind(&self) -> Option<Value> {
        match self.kind {
            Kind::Real => Some(Value::Real(0.0)),
            Kind::Integer | Kind::Enumeration(_) => Some(Value::Integer(0)),
            Kind::Boolean => Some(Value::Boolean(false)),
            Kind::String | Kind::Opaque => None,
        }
    }

    fn range(&self) -> Option<(f64, f64)> {
        self.range
    }
}

fn whole(text: &str) -> Result<i32, String> {
    text.parse().map_err(|_| format!("`{text}` is not a whole number"))
}

fn among(words: &[(String, i32)]) -> String {
    let list: Vec<String> = words.iter().map(|(word, number)| format!("{word} ({number})")).collect();
    if list.is_empty() { " of its words and not a whole number".to_owned() } else { format!(" of {}", list.join(", ")) }
}

#[cfg(test)]
#[path = "description_tests.rs"]
mod tests;
