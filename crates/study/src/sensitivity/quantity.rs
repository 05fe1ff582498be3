//! Results of a run by their names.

use crate::names::{self, NameError};
use crate::sensitivity::error::QuantityError;
use foldwing_engine::machine::{Latch, LatchKind, Machine};
use foldwing_fmi::interface::{Causality, Interface, Value, Variable};

/// Suffix of the name of a latch time, the instant at which a latch closes.
const LATCH_TIME: &str = ".latch_time";
/// Suffix of the name of the impulse with which a rigid latch closes.
const LATCH_IMPULSE: &str = ".latch_impulse";

/// A kind of extreme value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extreme {
    /// The largest value, `max(…)`.
    Maximum,
    /// The smallest value, `min(…)`.
    Minimum,
    /// The value of largest magnitude, `peak(…)`, with its sign.
    Peak,
}

impl Extreme {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Maximum, Self::Minimum, Self::Peak];

    /// The word before the brackets.
    pub fn word(self) -> &'static str {
        match self {
            Self::Maximum => "max",
            Self::Minimum => "min",
            Self::Peak => "peak",
        }
    }

    /// The quantity that is largest at the extreme value.
    pub(super) fn size(self, value: f64) -> f64 {
        match self {
            Self::Maximum => value,
            Self::Minimum => -value,
            Self::Peak => value.abs(),
        }
    }
}

/// A kind of mean over the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Average {
    /// The mean, `mean(…)`.
    Mean,
    /// The root of the mean of the squares, `rms(…)`.
    RootMeanSquare,
}

impl Average {
    /// All kinds.
    pub const ALL: [Self; 2] = [Self::Mean, Self::RootMeanSquare];

    /// The word before the brackets.
    pub fn word(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::RootMeanSquare => "rms",
        }
    }
}

/// A function of an output over the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Over {
    Extreme(Extreme),
    Average(Average),
}

impl Over {
    fn all() -> impl Iterator<Item = Self> {
        Extreme::ALL.into_iter().map(Self::Extreme).chain(Average::ALL.into_iter().map(Self::Average))
    }

    fn word(self) -> &'static str {
        match self {
            Self::Extreme(kind) => kind.word(),
            Self::Average(kind) => kind.word(),
        }
    }
}

/// A scalar result of a run.
#[derive(Debug, Clone, PartialEq)]
pub enum Quantity {
    /// An output at a time, or at the end of the run.
    Output {
        /// Its index in the engine's outputs.
        index: usize,
        /// Time in s; `None`: the end of the run.
        time_s: Option<f64>,
    },
    /// An extreme value of an output over the run.
    Extreme {
        /// Its index in the engine's outputs.
        index: usize,
        /// Type of the extreme value.
        kind: Extreme,
    },
    /// A mean of an output over the run.
    Average {
        /// Its index in the engine's outputs.
        index: usize,
        /// Type of the mean.
        kind: Average,
    },
    /// The impulse on the outer body with which the rigid latch of a joint closes for the first time.
    LatchImpulse {
        /// Index of the joint among those with one degree of freedom.
        joint: usize,
    },
    /// The instant at which the latch of a joint closes for the first time.
    LatchTime {
        /// Index of the joint among those with one degree of freedom.
        joint: usize,
    },
}

/// A quantity with its name in results.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Named {
    pub name: String,
    pub unit: &'static str,
    pub quantity: Quantity,
}

impl Named {
    /// Whether it is an integral over the run: a mean, or an energy account, whose indices in the engine's outputs are given.
    pub fn is_integral(&self, accounts: [usize; 2]) -> bool {
        match self.quantity {
            Quantity::Average { .. } => true,
            Quantity::Output { index, .. } | Quantity::Extreme { index, .. } => accounts.contains(&index),
            Quantity::LatchImpulse { .. } | Quantity::LatchTime { .. } => false,
        }
    }

    /// The quantities named by a text: `NAME`, `NAME@TIME`, `max(NAME)`, `min(NAME)`, `peak(NAME)`, `mean(NAME)`, `rms(NAME)` with a name,
    /// vector or pattern of real outputs, `JOINT.latch_time` or `JOINT.latch_impulse`.
    pub fn of(text: &str, machine: &Machine, interface: &Interface) -> Result<Vec<Self>, QuantityError> {
        let text = text.trim();
        if let Some(latch) = of_latch(text, machine, interface) {
            return Ok(vec![latch]);
        }
        let over = Over::all().find_map(|kind| {
            let inner = text.strip_prefix(kind.word())?.strip_prefix('(')?.strip_suffix(')')?;
            Some((kind, inner))
        });
        let (pattern, time_s) = match (over, text.split_once('@')) {
            (Some((_, inner)), _) => (inner, None),
            (None, Some((pattern, time))) => {
                let time_s: f64 = time.trim().parse().map_err(|_| QuantityError::Time(time.trim().to_owned()))?;
                if !time_s.is_finite() {
                    return Err(QuantityError::Time(time.trim().to_owned()));
                }
                (pattern, Some(time_s))
            }
            (None, None) => (text, None),
        };
        let rows: Vec<&Variable> = interface.variables().iter().filter(is_real_output).collect();
        let chosen = names::choose(&[pattern.to_owned()], &rows, names::of_variable, "real output")?;
        if chosen.is_empty() {
            return Err(NameError::unknown(text, "real output", rows.iter().map(|row| row.name.as_str())).into());
        }
        let named = |row: &&Variable| {
            let index = interface.output_index(row.value_reference).unwrap_or(usize::MAX);
            let (name, quantity) = match (over, time_s) {
                (Some((over, _)), _) => {
                    let quantity = match over {
                        Over::Extreme(kind) => Quantity::Extreme { index, kind },
                        Over::Average(kind) => Quantity::Average { index, kind },
                    };
                    (format!("{}({})", over.word(), row.name), quantity)
                }
                (None, Some(time_s)) => {
                    (format!("{}@{time_s:?}", row.name), Quantity::Output { index, time_s: Some(time_s) })
                }
                (None, None) => (row.name.clone(), Quantity::Output { index, time_s: None }),
            };
            Self { name, unit: row.unit(), quantity }
        };
        Ok(chosen.iter().map(named).collect())
    }
}

fn is_real_output(row: &&Variable) -> bool {
    row.causality == Causality::Output && matches!(row.value, Value::Real(_))
}

/// The latch time or impulse named by a text, if a joint of this name has a latch, for impulses a rigid one.
fn of_latch(text: &str, machine: &Machine, interface: &Interface) -> Option<Named> {
    let joint_with = |name: &str, has: fn(&Latch) -> bool| {
        machine
            .one_freedoms()
            .position(|(body, own)| machine.bodies[body].joint.name == name && own.latch.as_ref().is_some_and(has))
    };
    if let Some(name) = text.strip_suffix(LATCH_TIME) {
        let joint = joint_with(name, |_| true)?;
        return Some(Named { name: text.to_owned(), unit: "s", quantity: Quantity::LatchTime { joint } });
    }
    let joint = joint_with(text.strip_suffix(LATCH_IMPULSE)?, |latch| latch.kind == LatchKind::Rigid)?;
    let unit = interface.find(text).map_or("", Variable::unit);
    Some(Named { name: text.to_owned(), unit, quantity: Quantity::LatchImpulse { joint } })
}
