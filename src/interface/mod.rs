//! The variable table: every name, causality, unit, start value and meaning, bound to the plant.
//!
//! The one source of truth: the model description, the FMI calls, `foldwing check`, CSV columns and the
//! documentation page all read this table.

use crate::config::Machine;
use crate::plant::{Outputs, Plant};

/// FMI 2.0 causality.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Set by the importer.
    Input,
    /// Computed, reported.
    Output,
    /// Constant during a step; see [`Variability`].
    Parameter,
    /// Computed, for inspection only.
    Local,
    /// The independent variable, time.
    Independent,
}

/// FMI 2.0 variability.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variability {
    /// Set before initialisation.
    Fixed,
    /// May change between steps.
    Tunable,
    /// Changes at events only.
    Discrete,
    /// May change at any time.
    Continuous,
}

/// FMI 2.0 `initial`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Initial {
    /// Start value given.
    Exact,
    /// Computed from others.
    Calculated,
}

/// Type and start value of a variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value {
    /// Real.
    Real(f64),
    /// Integer.
    Integer(i32),
    /// Boolean.
    Boolean(bool),
}

/// How an output depends on a known, FMI 2.0 `dependenciesKind`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DependencyKind {
    /// Any nonlinear dependence.
    Dependent,
    /// Constant factor.
    Constant,
    /// Factor that changes only before initialisation.
    Fixed,
    /// Factor that changes at events or with tunable parameters.
    Tunable,
    /// Factor that changes at events.
    Discrete,
}

/// One row of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Structured name, as scripts use it.
    pub name: String,
    /// FMI value reference: the row's position in the table.
    pub value_reference: u32,
    /// Causality.
    pub causality: Causality,
    /// Variability.
    pub variability: Variability,
    /// `initial`; `None` where the standard forbids or defaults it.
    pub initial: Option<Initial>,
    /// Type with start value; outputs carry a zero that is not written.
    pub value: Value,
    /// Declared type (unit, display unit, quantity), by name in [`TYPES`]; `None` for Boolean and Integer.
    pub declared_type: Option<&'static str>,
    /// Smallest and largest value allowed.
    pub range: Option<(f64, f64)>,
    /// One sentence: meaning, frame, sign.
    pub description: String,
    /// Rows that the value depends on at a communication point (outputs; state frozen).
    pub dependencies: Vec<(u32, DependencyKind)>,
    /// Rows that the initial value depends on (outputs, in Initialization Mode).
    pub initial_dependencies: Vec<(u32, DependencyKind)>,
}

/// Base-unit exponents of a unit, FMI 2.0 `BaseUnit`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Name, e.g. `N.m`.
    pub name: &'static str,
    /// Exponents of kg, m, s, rad.
    pub exponents: [i32; 4],
    /// Display unit: name and factor from base to display.
    pub display: Option<(&'static str, f64)>,
}

/// A declared real type.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RealType {
    /// Name, e.g. `Angle`.
    pub name: &'static str,
    /// Quantity, e.g. `Angle`.
    pub quantity: &'static str,
    /// Unit by name in [`UNITS`].
    pub unit: &'static str,
}

/// Units that the table uses.
pub const UNITS: &[Unit] = &[];

/// Real types that the table uses.
pub const TYPES: &[RealType] = &[];

/// The table of one model.
pub struct Interface {
    variables: Vec<Variable>,
}

impl Interface {
    /// The table of a machine. Row 0 is `time`.
    pub fn new(_machine: &Machine) -> Self {
        todo!()
    }

    /// All rows; a row's position is its value reference.
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// Row of a name.
    pub fn find(&self, _name: &str) -> Option<&Variable> {
        todo!()
    }

    /// Present value: inputs and parameters as the plant holds them, outputs from `outputs`.
    pub fn get(&self, _plant: &Plant, _outputs: &Outputs, _value_reference: u32) -> Option<Value> {
        todo!()
    }

    /// Sets an input or parameter; the row's type must match and the value lie within its range.
    pub fn set(&self, _plant: &mut Plant, _value_reference: u32, _value: Value) -> Result<(), String> {
        todo!()
    }
}
