//! Smooth pieces of the functions of a section, NOTATION eq. (X37): intervals of polars, sides of limits and branches, and the root of the
//! momentum balance of a rotor.

use crate::aero::polar::{Polar, PolarRow};
use std::f64::consts::TAU;

/// Distance in rad from a row of a polar that is round-off of an angle of attack.
const ROUND_OFF_RAD: f64 = 1e-11;

/// Distance from a limit, relative to it, that is round-off: such a value is taken as the limit, as the outermost sections of rigid blades are
/// at the radius of the rotor.
const ROUND_OFF: f64 = 1e-12;

/// Pieces in the order of evaluation.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PieceList {
    /// Intervals and sides.
    pub choices: Vec<usize>,
    /// Angles in rad near which the function continues: angles of attack, whose range ends at ±π, and roots of the balance.
    values: Vec<f64>,
    /// Whether an angle of attack is that of a row of its polar, at which both sides have other slopes.
    pub at_kink: bool,
    /// Whether a place is that of a point of a grid, at which both sides have other slopes.
    pub at_node: bool,
}

/// Evaluation of functions with several smooth pieces.
#[derive(Debug)]
pub enum Pieces<'a> {
    /// On the pieces of the arguments.
    Free,
    /// The same, and the pieces are recorded.
    Record(&'a mut PieceList),
    /// On known pieces, continued beyond their ends.
    Keep {
        /// The pieces.
        list: &'a PieceList,
        /// Numbers of choices and values already used.
        used: [usize; 2],
    },
}

impl<'a> Pieces<'a> {
    /// Evaluation on the pieces of a list, from its start.
    pub fn keep(list: &'a PieceList) -> Self {
        Self::Keep { list, used: [0; 2] }
    }

    /// The same pieces for each round of an iteration; an evaluation behind it records them.
    pub fn of_round(&self) -> Pieces<'_> {
        match self {
            Self::Free | Self::Record(_) => Pieces::Free,
            Self::Keep { list, used } => Pieces::Keep { list, used: *used },
        }
    }

    /// The piece with a number: that of the arguments, or the known one.
    pub fn choice(&mut self, own: usize) -> usize {
        match self {
            Self::Free => own,
            Self::Record(list) => {
                list.choices.push(own);
                own
            }
            Self::Keep { list, used } => {
                used[0] += 1;
                list.choices.get(used[0] - 1).copied().unwrap_or(own)
            }
        }
    }

    /// Whether a condition holds: for the arguments, or on the known piece.
    pub fn holds(&mut self, own: bool) -> bool {
        self.choice(usize::from(own)) == 1
    }

    /// The smaller of two numbers.
    pub fn least(&mut self, value: f64, limit: f64) -> f64 {
        match self {
            Self::Free => value.min(limit),
            Self::Record(_) | Self::Keep { .. } => {
                if self.holds(value < limit - ROUND_OFF * limit.abs()) {
                    value
                } else {
                    limit
                }
            }
        }
    }

    /// The larger of two numbers.
    pub fn most(&mut self, value: f64, limit: f64) -> f64 {
        match self {
            Self::Free => value.max(limit),
            Self::Record(_) | Self::Keep { .. } => {
                if self.holds(value > limit + ROUND_OFF * limit.abs()) {
                    value
                } else {
                    limit
                }
            }
        }
    }

    /// Whether a number reaches a limit.
    pub fn reaches(&mut self, value: f64, limit: f64) -> bool {
        match self {
            Self::Free => value >= limit,
            Self::Record(_) | Self::Keep { .. } => self.holds(value >= limit - ROUND_OFF * limit.abs()),
        }
    }

    /// A number between limits.
    pub fn within(&mut self, value: f64, [least, most]: [f64; 2]) -> f64 {
        match self {
            Self::Free => value.clamp(least, most),
            Self::Record(_) | Self::Keep { .. } => {
                let above = self.most(value, least);
                self.least(above, most)
            }
        }
    }

    /// Records whether a place on a grid with unit spacing is that of a point.
    pub fn note_node(&mut self, place: f64) {
        if let Self::Record(list) = self {
            list.at_node |= (place - place.round()).abs() <= ROUND_OFF * place.abs().max(1.0);
        }
    }

    /// A known value; `None` if values are recorded or not needed.
    pub fn known(&mut self) -> Option<f64> {
        match self {
            Self::Free | Self::Record(_) => None,
            Self::Keep { list, used } => {
                used[1] += 1;
                list.values.get(used[1] - 1).copied()
            }
        }
    }

    /// Records a value for [`Self::known`].
    pub fn note(&mut self, value: f64) {
        if let Self::Record(list) = self {
            list.values.push(value);
        }
    }

    /// An angle in rad that jumps by a turn at the ends of its range: on a known piece without the jump.
    pub fn near(&mut self, angle_rad: f64) -> f64 {
        match self.known() {
            Some(known_rad) => angle_rad + TAU * ((known_rad - angle_rad) / TAU).round(),
            None => {
                self.note(angle_rad);
                angle_rad
            }
        }
    }

    /// Coefficients at an angle of attack in rad.
    pub fn row(&mut self, polar: &Polar, angle_rad: f64) -> PolarRow {
        match self {
            Self::Free => polar.at(angle_rad),
            Self::Record(list) => {
                list.choices.push(polar.interval(angle_rad));
                list.at_kink |= polar.is_at_kink(angle_rad, ROUND_OFF_RAD);
                polar.at(angle_rad)
            }
            Self::Keep { .. } => polar.in_interval(self.choice(0), angle_rad),
        }
    }
}

/// Use of the pieces of its functions by an aerodynamic model.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Holding<P> {
    /// Nothing.
    #[default]
    Free,
    /// The next evaluation records them.
    Record(P),
    /// Evaluations keep them.
    Keep(P),
}

impl<P: Default> Holding<P> {
    /// Takes the pieces that the last evaluation has recorded.
    pub fn recorded(&mut self) -> Option<P> {
        match std::mem::take(self) {
            Self::Record(pieces) => Some(pieces),
            Self::Free | Self::Keep(_) => None,
        }
    }

    /// Pieces in one of the lists.
    pub fn pieces(&mut self, list: impl Fn(&mut P) -> &mut PieceList) -> Pieces<'_> {
        match self {
            Self::Free => Pieces::Free,
            Self::Record(pieces) => Pieces::Record(list(pieces)),
            Self::Keep(pieces) => Pieces::keep(list(pieces)),
        }
    }
}
