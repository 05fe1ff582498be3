//! Attitude and steady turn of a free model: gravity, wind and motion of the root in the model's frame, NOTATION eqs. (Q9),
//! (Q11).

use foldwing_engine::machine::{AirOptions, WakeModel};
use foldwing_engine::plant::Plant;
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

/// Inputs that depend on the attitude: components of gravity, then of the wind.
const INPUTS: [&str; 6] =
    ["gravity.x", "gravity.y", "gravity.z", "wind.velocity.x", "wind.velocity.y", "wind.velocity.z"];
/// Inputs that depend on a steady turn: acceleration of the root, and its angular velocity.
const TURNING: [&str; 6] = [
    "root.acceleration.x",
    "root.acceleration.y",
    "root.acceleration.z",
    "root.angular_velocity.x",
    "root.angular_velocity.y",
    "root.angular_velocity.z",
];

/// Ratio of the wind component normal to gravity below which its horizontal direction is undefined.
const LEVEL: f64 = 1e-6;

/// Attitude angles in rad, and turn rate in rad/s, in the order of [`Turn`].
pub type Turns = [f64; 4];

/// An angle of the attitude of a model relative to gravity and wind, or the rate of its steady turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turn {
    /// About the forward axis, right side down.
    Roll,
    /// About the axis to the right, nose up.
    Pitch,
    /// About the downward axis, nose to the right.
    Yaw,
    /// Rate of a steady turn about the downward axis, to the right.
    Rate,
}

impl Turn {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Roll, Self::Pitch, Self::Yaw, Self::Rate];

    /// Returns the name of the unknown.
    pub fn name(self) -> &'static str {
        ["attitude.roll", "attitude.pitch", "attitude.yaw", "turn.rate"][self as usize]
    }

    /// Returns its unit.
    pub fn unit(self) -> &'static str {
        if self == Self::Rate { "rad/s" } else { "rad" }
    }

    /// Returns the attitude angle or rate of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|turn| turn.name() == name)
    }
}

/// Reason why a model has no attitude, or no steady turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum TurnError {
    /// No gravity, or no wind component normal to it.
    #[error("an attitude needs gravity and a wind that is not parallel to it; set gravity and wind.velocity")]
    NoAttitude,
    /// No part of the model is on a free joint.
    #[error("only a model on a free joint can fly a steady turn; attach it by a joint of type = \"free\"")]
    NoFreeJoint,
    /// The wake of the lattice is free.
    #[error("a free wake has no steady shape in a turn; write free_wake = false")]
    FreeWake,
    /// The model has the aerodynamics of a rotor.
    #[error("rotors in the wind have no steady turn; use strips (aerodynamics.model = \"strip\")")]
    Rotor,
    /// Start values already prescribe a motion of the root.
    #[error(
        "a turn sets root.acceleration and root.angular_velocity; leave these and root.angular_acceleration at zero"
    )]
    RootMoves,
}

/// Gravity in m/s² and wind in m/s before the rotation, root frame, and the axes forward, right and down.
#[derive(Debug, Clone)]
pub struct Attitude {
    given: [f64; 6],
    /// Start values already prescribe a motion of the root.
    moving: bool,
    /// Reason why the aerodynamic model does not support steady turns.
    no_turn: Option<TurnError>,
    /// The model is on a free joint.
    flies: bool,
    /// Columns: forward, right, down; `None` without gravity, or without a wind component normal to it.
    axes: Option<Matrix3<f64>>,
}

impl Attitude {
    /// Returns the attitude that belongs to the start values of a plant.
    pub fn of(plant: &Plant) -> Self {
        let (gravity, wind) = (plant.inputs().root().gravity_m_s2, plant.inputs().wind_m_s());
        let mut given = [0.0; 6];
        given[..3].copy_from_slice(gravity.as_slice());
        given[3..].copy_from_slice(wind.as_slice());
        let axes = Unit::try_new(gravity, 0.0).and_then(|down| {
            let ahead = Unit::try_new(down.dot(wind) * down.into_inner() - wind, LEVEL * wind.norm())?;
            Some(Matrix3::from_columns(&[ahead.into_inner(), down.cross(&ahead), down.into_inner()]))
        });
        let root = plant.inputs().root();
        let moving = [root.acceleration_m_s2, root.angular_velocity_rad_s, root.angular_acceleration_rad_s2];
        Self {
            given,
            moving: moving.iter().any(|vector| *vector != Vector3::zeros()),
            no_turn: plant.machine().air.iter().flat_map(|air| &air.parts).find_map(|part| match &part.options {
                AirOptions::Strips(_) | AirOptions::SlenderBody(_) => None,
                AirOptions::Lattice(lattice) => (lattice.wake == WakeModel::Free).then_some(TurnError::FreeWake),
                AirOptions::Rotor(_) => Some(TurnError::Rotor),
            }),
            flies: !plant.flying_joints().is_empty(),
            axes,
        }
    }

    /// Checks that the model has an attitude and, for the rate, can turn.
    pub fn check(&self, turn: Turn) -> Result<(), TurnError> {
        if self.axes.is_none() {
            return Err(TurnError::NoAttitude);
        }
        if turn != Turn::Rate {
            return Ok(());
        }
        if !self.flies {
            return Err(TurnError::NoFreeJoint);
        }
        match self.no_turn {
            Some(error) => Err(error),
            None if self.moving => Err(TurnError::RootMoves),
            None => Ok(()),
        }
    }

    /// Sets an input that the attitude uses; returns whether `name` is one.
    pub fn take(&mut self, name: &str, value: f64) -> bool {
        let place = INPUTS.iter().position(|input| *input == name);
        if let Some(place) = place {
            self.given[place] = value;
        }
        place.is_some()
    }

    /// Gravity and wind in the model's frame after rotations by roll, pitch and yaw in rad relative to the given attitude,
    /// yaw first; if it `turns`, also the motion of the root in a steady turn about the vertical.
    pub fn turned(&self, turned: Turns, turns: bool) -> Vec<(String, f64)> {
        let [gravity, wind] = [0, 3].map(|first| Vector3::from_column_slice(&self.given[first..first + 3]));
        let [roll, pitch, yaw, rate_rad_s] = turned;
        let [gravity, wind] = match self.axes {
            Some(axes) if [roll, pitch, yaw] != [0.0; 3] => {
                // the columns of the axes are those of Rotation3's angles: x forward, y to the right, z down
                let turn = axes * Rotation3::from_euler_angles(roll, pitch, yaw).into_inner() * axes.transpose();
                [turn.transpose() * gravity, turn.transpose() * wind]
            }
            _ => [gravity, wind],
        };
        let named = |names: &[&str; 6], first: Vector3<f64>, second: Vector3<f64>| -> Vec<(String, f64)> {
            names.iter().map(|name| (*name).to_owned()).zip(first.iter().chain(second.iter()).copied()).collect()
        };
        let mut list = named(&INPUTS, gravity, wind);
        if turns {
            // the root moves against the wind, and its velocity rotates with it, eq. (Q11)
            let spin = gravity.try_normalize(0.0).map_or_else(Vector3::zeros, |down| down * rate_rad_s);
            list.extend(named(&TURNING, spin.cross(&-wind), spin));
        }
        list
    }
}
