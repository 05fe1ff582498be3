//! Errors of a machine description: path, value, allowed values.

use crate::machine::units::{finite, quoted, shortest};
use std::fmt;

/// Path of an error, e.g. `joint "fold", latch, stiffness_n_m_rad`.
///
/// Its components are a type of part (`joint`), then a name if there can be several of the type (`fold`), then fields of the machine or of
/// its builder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place(pub Vec<String>);

/// Types of parts of which a machine has several, each with a name.
const NAMED: &[&str] = &[
    "body",
    "joint",
    "loop",
    "mass",
    "load",
    "gauge",
    "internal_load",
    "surface",
    "gust",
    "failure",
    "control_surface",
];

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, part) in self.0.iter().enumerate() {
            match index {
                0 => write!(f, "{part}")?,
                1 if NAMED.contains(&self.0[0].as_str()) => write!(f, " {part:?}")?,
                _ => write!(f, ", {part}")?,
            }
        }
        Ok(())
    }
}

/// One error. Displays as `place: value is not allowed; allowed: …`, with the remedy.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Path of the value.
    pub place: Place,
    /// The invalid value in SI units and radians, or a description of the current state.
    pub value: String,
    /// Allowed values, with the unit.
    pub allowed: String,
    /// Meaning of `value`.
    pub subject: Subject,
}

/// Meaning of the `value` of a [`Fault`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Subject {
    /// The value of the quantity at the location.
    Value,
    /// A description of the current state.
    State,
    /// An unknown name.
    Name {
        /// Allowed names.
        known: Vec<String>,
    },
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} is not allowed; allowed: {}", self.place, self.value, self.allowed)
    }
}

/// Errors of an invalid machine. Displays one fault per line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refused {
    /// All errors; never empty.
    pub faults: Vec<Fault>,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lines: Vec<String> = self.faults.iter().map(Fault::to_string).collect();
        write!(f, "{}", lines.join("\n"))
    }
}

impl std::error::Error for Refused {}

/// Range of a number. No range contains NaN or numbers larger than [`UNLIMITED`](crate::machine::UNLIMITED).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Range {
    /// Any finite number.
    Finite,
    /// At least a number.
    AtLeast(f64),
    /// Greater than a number.
    Above(f64),
    /// Between two numbers.
    Within(f64, f64),
}

impl Range {
    fn contains(self, value: f64) -> bool {
        let inside = match self {
            Self::Finite => true,
            Self::AtLeast(least) => value >= least,
            Self::Above(bound) => value > bound,
            Self::Within(least, most) => (least..=most).contains(&value),
        };
        inside && is_finite(value)
    }

    /// The range as text with a leading space; empty without bounds.
    fn words(self) -> String {
        match self {
            Self::Finite => String::new(),
            Self::AtLeast(least) => format!(" >= {}", shortest(least)),
            Self::Above(bound) => format!(" > {}", shortest(bound)),
            Self::Within(least, most) => format!(" from {} to {}", shortest(least), shortest(most)),
        }
    }
}

/// Whether the magnitude of a number is at most the largest that a model may contain.
pub(super) fn is_finite(value: f64) -> bool {
    value.abs() <= crate::machine::UNLIMITED
}

/// Collects the faults of a machine.
#[derive(Debug, Default)]
pub(crate) struct Checker {
    /// Faults found so far.
    pub faults: Vec<Fault>,
}

impl Checker {
    fn push(&mut self, place: &[&str], value: String, allowed: String, subject: Subject) {
        let place = Place(place.iter().map(|part| (*part).to_owned()).collect());
        self.faults.push(Fault { place, value, allowed, subject });
    }

    /// Reports the value at the location `place`.
    pub fn refuse(&mut self, place: &[&str], value: impl ToString, allowed: impl Into<String>) {
        self.push(place, value.to_string(), allowed.into(), Subject::Value);
    }

    /// Reports the current state, described by `state`, at the location `place`.
    pub fn refuse_state(&mut self, place: &[&str], state: impl Into<String>, allowed: impl Into<String>) {
        self.push(place, state.into(), allowed.into(), Subject::State);
    }

    /// Reports an unknown name; `known` are the allowed names.
    pub fn unknown_name<'k>(
        &mut self,
        place: &[&str],
        name: &str,
        what: &str,
        known: impl IntoIterator<Item = &'k str>,
    ) {
        let known: Vec<&str> = known.into_iter().collect();
        let allowed = format!("{what}: {}", quoted(&known));
        let known = known.into_iter().map(str::to_owned).collect();
        self.push(place, format!("{name:?}"), allowed, Subject::Name { known });
    }

    /// Reports a number outside its range; the last component of the location gives quantity and unit.
    pub fn number(&mut self, place: &[&str], value: f64, range: Range) -> bool {
        let fits = range.contains(value);
        if !fits {
            let key = place.last().copied().unwrap_or_default();
            self.refuse(place, shortest(value), finite(key, &range.words(), ""));
        }
        fits
    }

    /// Reports arrays that contain a number that is not finite.
    pub fn array(&mut self, place: &[&str], values: &[f64]) -> bool {
        let fits = values.iter().all(|value| is_finite(*value));
        if !fits {
            let key = place.last().copied().unwrap_or_default();
            let allowed = format!("an array of {} {}", values.len(), finite(key, "", "s"));
            self.refuse(place, array_text(values), allowed);
        }
        fits
    }

    /// Reports a count outside its range.
    pub fn count(&mut self, place: &[&str], value: usize, least: usize, most: usize) -> bool {
        let fits = (least..=most).contains(&value);
        if !fits {
            self.refuse(place, value, format!("a whole number from {least} to {most}"));
        }
        fits
    }

    /// Reports a distance that is not on a body.
    pub fn on_body(&mut self, place: &[&str], position_m: f64, length_m: f64) {
        if !(0.0..=length_m).contains(&position_m) {
            let allowed = format!("a length from 0 to {} m, the length of the body", shortest(length_m));
            self.refuse(place, shortest(position_m), allowed);
        }
    }
}

/// An array as text, for example `[1, 2.5, 3]`.
pub(super) fn array_text(values: &[f64]) -> String {
    format!("[{}]", values.iter().map(|value| shortest(*value)).collect::<Vec<_>>().join(", "))
}
