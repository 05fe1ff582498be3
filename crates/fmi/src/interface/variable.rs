//! A row of the table, with its properties in FMI 2.0.

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
    /// Computed from other variables; the start value is an approximation.
    Approximate,
    /// Computed from other variables.
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

/// Kind of dependence of an output on a known, FMI 2.0 `dependenciesKind`.
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
    /// Structured name.
    pub name: String,
    /// FMI value reference: the row's position in the table.
    pub value_reference: u32,
    /// Causality.
    pub causality: Causality,
    /// Variability.
    pub variability: Variability,
    /// `initial`; `None` if the standard forbids it or has a default.
    pub initial: Option<Initial>,
    /// Type with start value; for outputs a zero that is not written.
    pub value: Value,
    /// Declared type (unit, display unit, quantity), by name in [`TYPES`](crate::interface::TYPES); `None` for Boolean and Integer.
    pub declared_type: Option<&'static str>,
    /// Smallest and largest value allowed.
    pub range: Option<(f64, f64)>,
    /// One sentence: meaning, frame and sign.
    pub description: String,
    /// Typical magnitude, of a continuous state.
    pub nominal: Option<f64>,
    /// The continuous state of which this row is the time derivative.
    pub derivative_of: Option<u32>,
}

/// Dependencies of a row; empty for rows that are not outputs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Dependencies {
    /// Rows on which the value depends at a communication point, with the state held constant.
    pub running: Vec<(u32, DependencyKind)>,
    /// Rows on which the initial value depends, in Initialization Mode.
    pub initial: Vec<(u32, DependencyKind)>,
    /// The lists of the output would be longer than [`MAXIMUM_LISTED`]: both are empty, and it counts as dependent on all knowns.
    pub on_all: bool,
}

/// Maximum number of dependencies listed for a row. With thousands of inputs, the lists of accelerations and internal loads at thousands of
/// positions would fill hundreds of megabytes; in FMI a row without a list depends on everything.
pub const MAXIMUM_LISTED: usize = 1_000;
