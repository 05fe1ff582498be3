//! Which call is legal when: the table of FMI 2.0.4, section 4.2.4 (co-simulation), as printed in the standard, independently of the
//! library, with the additions of the documentation.

#![allow(dead_code, reason = "each test uses a part of it")]

/// Phase of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    Instantiated,
    Initialization,
    StepComplete,
    /// A failed step is an error here, never `fmi2Discard`: the column `error` of the standard, not `stepFailed`.
    StepFailed,
    Terminated,
}

/// Phases in the order of the columns of [`TABLE`].
pub const PHASES: [Phase; 5] =
    [Phase::Instantiated, Phase::Initialization, Phase::StepComplete, Phase::StepFailed, Phase::Terminated];

impl Phase {
    /// The name of the phase in messages.
    pub fn phrase(self) -> &'static str {
        match self {
            Self::Instantiated => "before fmi2EnterInitializationMode",
            Self::Initialization => "in Initialization Mode",
            Self::StepComplete => "after fmi2ExitInitializationMode",
            Self::StepFailed => "after a failed step",
            Self::Terminated => "after fmi2Terminate",
        }
    }
}

/// One function: the phases in which it is legal, and its effect on the instance.
pub struct Row {
    /// Name in the standard.
    pub name: &'static str,
    /// Columns in the order of [`PHASES`]: `x` is legal.
    legal: &'static str,
    /// Effect of a successful call.
    pub effect: Effect,
}

/// Effect of a successful call on an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effect {
    /// Leaves the state unchanged.
    Reads,
    /// Changes inputs, parameters, time or the experiment.
    Changes,
    /// Leads to a phase.
    To(Phase),
}

impl Row {
    /// Returns whether the call is legal in a phase.
    pub fn is_legal(&self, phase: Phase) -> bool {
        let column = PHASES.iter().position(|known| *known == phase).expect("in the table");
        self.legal.split(' ').nth(column) == Some("x")
    }
}

const fn row(name: &'static str, legal: &'static str, effect: Effect) -> Row {
    Row { name, legal, effect }
}

/// The table. In addition to the standard, the status functions are legal after a failed step, because only they give the last valid time.
/// `fmi2CancelStep` is legal while a step is in progress, which it never is between two calls.
pub const TABLE: [Row; 30] = {
    use Effect::{Changes, Reads, To};
    [
        row("fmi2SetDebugLogging", "x x x x x", Reads),
        row("fmi2SetupExperiment", "x - - - -", Changes),
        row("fmi2EnterInitializationMode", "x - - - -", To(Phase::Initialization)),
        row("fmi2ExitInitializationMode", "- x - - -", To(Phase::StepComplete)),
        row("fmi2Terminate", "- - x - -", To(Phase::Terminated)),
        row("fmi2Reset", "x x x x x", To(Phase::Instantiated)),
        row("fmi2GetReal", "- x x x x", Reads),
        row("fmi2GetInteger", "- x x x x", Reads),
        row("fmi2GetBoolean", "- x x x x", Reads),
        row("fmi2GetString", "- x x x x", Reads),
        row("fmi2SetReal", "x x x - -", Changes),
        row("fmi2SetInteger", "x x x - -", Changes),
        row("fmi2SetBoolean", "x x x - -", Changes),
        row("fmi2SetString", "x x x - -", Changes),
        row("fmi2GetFMUstate", "x x x x x", Reads),
        row("fmi2SetFMUstate", "x x x x x", Changes),
        row("fmi2FreeFMUstate", "x x x x x", Reads),
        row("fmi2SerializedFMUstateSize", "x x x x x", Reads),
        row("fmi2SerializeFMUstate", "x x x x x", Reads),
        row("fmi2DeSerializeFMUstate", "x x x x x", Reads),
        row("fmi2GetDirectionalDerivative", "- x x x x", Reads),
        row("fmi2SetRealInputDerivatives", "x x x - -", Changes),
        row("fmi2GetRealOutputDerivatives", "- - x x x", Reads),
        row("fmi2DoStep", "- - x - -", Changes),
        row("fmi2CancelStep", "- - - - -", Reads),
        row("fmi2GetStatus", "- - x x x", Reads),
        row("fmi2GetRealStatus", "- - x x x", Reads),
        row("fmi2GetIntegerStatus", "- - x x x", Reads),
        row("fmi2GetBooleanStatus", "- - x x x", Reads),
        row("fmi2GetStringStatus", "- - x x x", Reads),
    ]
};

/// The row of a function.
pub fn row_of(name: &str) -> &'static Row {
    TABLE.iter().find(|row| row.name == name).unwrap_or_else(|| panic!("{name} is not in the table"))
}
