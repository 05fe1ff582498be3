//! Operating points of a rotor: power, thrust and loads as functions of wind, speed and pitch, and the pitch or the speed at which an
//! output has a given value.

mod error;
mod found;
mod options;
mod pitch;
mod point;
mod search;
mod tabulate;

pub use crate::values::{Setting, Target};
pub use error::{List, PointError, PointsError};
pub use found::{OperatingPoints, Point, State, Statistics};
pub use options::{Options, Search, Unknown};
pub use tabulate::{MAXIMUM_POINTS, tabulate, tabulate_watched};
