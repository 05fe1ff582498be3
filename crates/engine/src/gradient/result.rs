//! Names of the results of a run.

/// A result of a run, a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RunResult {
    /// An output at a requested time; the energy accounts are integrals up to there.
    Output {
        /// Index in [`Outputs::values`](crate::system::Outputs::values).
        index: usize,
        /// Index of the time among those requested.
        time: usize,
    },
    /// The instant of the first closing of the latch of a joint, s.
    LatchTime {
        /// Index of the joint among those with one freedom.
        joint: usize,
    },
    /// The impulse on the outer body with which a rigid latch closes for the first time, N·m·s; at prismatic joints N·s.
    Impulse {
        /// Index of the joint among those with one freedom.
        joint: usize,
    },
    /// The mean of an output from the start of the run to a requested time, by the stages of its steps.
    Mean {
        /// Index in [`Outputs::values`](crate::system::Outputs::values).
        index: usize,
        /// Index of the time among those requested.
        time: usize,
        /// Whether it is the mean of the output's square.
        square: bool,
    },
}

impl RunResult {
    /// Whether it is an instant, known at the end of the step that ends there.
    pub(super) fn is_latch_time(&self) -> bool {
        match self {
            Self::LatchTime { .. } => true,
            Self::Output { .. } | Self::Impulse { .. } | Self::Mean { .. } => false,
        }
    }
}
