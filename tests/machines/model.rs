//! Tables of a model file whose values depend on a view.

use crate::machines::course::Action;
use crate::machines::view::{Frame, View};
use nalgebra::{UnitQuaternion, Vector3};
use std::fmt::Write;

/// A value of the file, and its dependence on the view.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Equal in every view: numbers, functions along a body.
    Plain(String),
    /// A name: of another table, which must then exist, or a word of the format.
    Text(String),
    /// A number that changes its sign in the mirror image.
    Odd(f64),
    Polar(Vector3<f64>, Frame),
    Axial(Vector3<f64>, Frame),
    /// Rotation vector in degrees.
    TurnDeg(Vector3<f64>, Frame),
    /// `[Ixx, Iyy, Izz, Ixy, Ixz, Iyz]` in a frame of the machine.
    Inertia([f64; 6]),
    /// Whether the leading edge is on the side of `+y`.
    Leading(bool),
    /// Direction of rotation of a rotor: whether clockwise.
    Clockwise(bool),
    List(Vec<Value>),
    /// Function along a body: its form, its coefficients or rows, and whether it changes its sign in the mirror image.
    Function(Form, Vec<Vec<f64>>, bool),
}

/// Form of a function along a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Form {
    Number,
    Polynomial,
    Table,
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        Self::Plain(format!("{number:?}"))
    }
}

impl From<usize> for Value {
    fn from(number: usize) -> Self {
        Self::Plain(number.to_string())
    }
}

impl From<bool> for Value {
    fn from(flag: bool) -> Self {
        Self::Plain(flag.to_string())
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl<T: Into<Value>> From<Vec<T>> for Value {
    fn from(list: Vec<T>) -> Self {
        Self::List(list.into_iter().map(Into::into).collect())
    }
}

fn vector(v: Vector3<f64>) -> String {
    format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z)
}

impl Value {
    fn write(&self, view: &View) -> String {
        match self {
            Self::Plain(text) => text.clone(),
            Self::Text(text) => format!("{text:?}"),
            Self::Odd(number) => format!("{:?}", view.odd(*number)),
            Self::Polar(v, frame) => vector(view.polar(*v, *frame)),
            Self::Axial(v, frame) => vector(view.axial(*v, *frame)),
            Self::TurnDeg(v, frame) if view.turn == UnitQuaternion::identity() => vector(view.axial(*v, *frame)),
            Self::TurnDeg(v, frame) => {
                let rotation = UnitQuaternion::from_scaled_axis(v.map(f64::to_radians));
                vector(view.attitude(rotation, *frame).scaled_axis().map(f64::to_degrees))
            }
            Self::Inertia([xx, yy, zz, xy, xz, yz]) => {
                format!("[{xx:?}, {yy:?}, {zz:?}, {:?}, {xz:?}, {:?}]", view.odd(*xy), view.odd(*yz))
            }
            Self::Leading(plus) => format!("\"{}y\"", if *plus != view.mirror { '+' } else { '-' }),
            Self::Clockwise(clockwise) => {
                format!("\"{}\"", if *clockwise != view.mirror { "clockwise" } else { "counter_clockwise" })
            }
            Self::Function(form, rows, odd) => {
                let value = |value: f64| if *odd { view.odd(value) } else { value };
                match form {
                    Form::Number => format!("{:?}", value(rows[0][0])),
                    Form::Polynomial => {
                        let coefficients: Vec<f64> = rows[0].iter().map(|c| value(*c)).collect();
                        format!("{{ polynomial = {coefficients:?} }}")
                    }
                    Form::Table => {
                        let rows: Vec<[f64; 2]> = rows.iter().map(|row| [row[0], value(row[1])]).collect();
                        format!("{{ table = {rows:?} }}")
                    }
                }
            }
            Self::List(list) => {
                format!("[{}]", list.iter().map(|value| value.write(view)).collect::<Vec<_>>().join(", "))
            }
        }
    }

    /// Returns whether this value refers to the table of this name.
    fn names(&self, name: &str) -> bool {
        match self {
            Self::Text(text) => text == name,
            Self::List(list) => list.iter().any(|value| value.names(name)),
            Self::Plain(_)
            | Self::Odd(_)
            | Self::Polar(..)
            | Self::Axial(..)
            | Self::TurnDeg(..)
            | Self::Inertia(_)
            | Self::Leading(_)
            | Self::Function(..)
            | Self::Clockwise(_) => false,
        }
    }
}

/// A table of the file; the top level has an empty name.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    pub name: String,
    pub keys: Vec<(&'static str, Value)>,
}

impl Table {
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), keys: Vec::new() }
    }

    pub fn with(mut self, key: &'static str, value: impl Into<Value>) -> Self {
        self.keys.push((key, value.into()));
        self
    }

    pub fn set(&mut self, key: &'static str, value: impl Into<Value>) {
        self.keys.push((key, value.into()));
    }

    pub fn has(&self, key: &str) -> bool {
        self.keys.iter().any(|(own, _)| *own == key)
    }

    /// Returns whether a key has this word as its value.
    pub fn is(&self, key: &str, word: &str) -> bool {
        self.keys.iter().any(|(own, value)| *own == key && *value == Value::from(word))
    }

    /// The number of a key, or zero without the key.
    pub fn number(&self, key: &str) -> f64 {
        match self.keys.iter().find(|(own, _)| *own == key) {
            Some((_, Value::Plain(text))) => text.parse().expect("a number"),
            _ => 0.0,
        }
    }

    fn short_name(&self) -> Option<&str> {
        self.name.rsplit_once('.').map(|(_, short)| short)
    }
}

/// A machine and the actions on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    pub seed: u64,
    pub tables: Vec<Table>,
    pub actions: Vec<Action>,
}

impl Model {
    /// The text of the model file.
    pub fn text(&self, view: &View) -> String {
        let mut text = String::new();
        for table in &self.tables {
            if !table.name.is_empty() {
                writeln!(text, "\n[{}]", table.name).expect("to a string");
            }
            for (key, value) in &table.keys {
                writeln!(text, "{key} = {}", value.write(view)).expect("to a string");
            }
        }
        text
    }

    pub fn table(&self, name: &str) -> Option<&Table> {
        self.tables.iter().find(|table| table.name == name)
    }

    /// Returns whether some table has this key.
    pub fn says(&self, key: &str) -> bool {
        self.tables.iter().any(|table| table.has(key))
    }

    /// Number of copies of a body, if any.
    pub fn copies(&self) -> Option<u64> {
        let count = self.tables.iter().flat_map(|table| &table.keys).find(|(key, _)| *key == "count");
        count.and_then(|(_, value)| if let Value::Plain(text) = value { text.parse().ok() } else { None })
    }

    /// Returns whether some table contains this word or name.
    pub fn names(&self, word: &str) -> bool {
        self.tables.iter().any(|table| table.keys.iter().any(|(_, value)| value.names(word)))
    }

    /// Returns whether there is a table whose name begins with this.
    pub fn has(&self, prefix: &str) -> bool {
        self.tables.iter().any(|table| table.name.starts_with(prefix))
    }

    /// The model without a table, those inside it, and all that refer to one of them.
    pub fn without(&self, index: usize) -> Self {
        let mut gone = vec![false; self.tables.len()];
        let mut next = vec![index];
        while let Some(index) = next.pop() {
            gone[index] = true;
            let lost = &self.tables[index];
            let inside = format!("{}.", lost.name);
            for (other, table) in self.tables.iter().enumerate() {
                let named = |short| table.keys.iter().any(|(_, value)| value.names(short));
                // no table refers to `joint.j0.motor`
                let is_named = lost.name.matches('.').count() == 1 && lost.short_name().is_some_and(named);
                if !gone[other] && (is_named || table.name.starts_with(&inside)) {
                    next.push(other);
                }
            }
        }
        let kept = self.tables.iter().zip(&gone).filter(|(_, gone)| !**gone).map(|(table, _)| table.clone());
        Self { seed: self.seed, tables: kept.collect(), actions: self.actions.clone() }
    }
}
