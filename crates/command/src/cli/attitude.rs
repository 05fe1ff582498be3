//! Attitude of a free machine: gravity and wind as the machine sees them, NOTATION eq. (Q9).

use crate::cli::Failure;
use foldwing_engine::plant::Plant;
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

/// Inputs that a turn of the machine changes: components of gravity, then of the wind.
const INPUTS: [&str; 6] =
    ["gravity.x", "gravity.y", "gravity.z", "wind.velocity.x", "wind.velocity.y", "wind.velocity.z"];

/// A turn of the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Turn {
    /// About the way ahead, the right side down.
    Roll,
    /// About the way to the right, the nose up.
    Pitch,
    /// About the way down, the nose to the right.
    Yaw,
}

impl Turn {
    const ALL: [Self; 3] = [Self::Roll, Self::Pitch, Self::Yaw];

    /// Name of the unknown.
    pub fn name(self) -> &'static str {
        ["attitude.roll", "attitude.pitch", "attitude.yaw"][self as usize]
    }

    /// The turn of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|turn| turn.name() == name)
    }
}

/// Gravity in m/s² and wind in m/s before the turn, root frame, and the axes ahead, right and down.
#[derive(Debug, Clone)]
pub(super) struct Attitude {
    given: [f64; 6],
    /// Columns: ahead, to the right, down; `None` without gravity, or without wind across it.
    axes: Option<Matrix3<f64>>,
}

impl Attitude {
    /// With the start values of a plant.
    pub fn of(plant: &Plant) -> Self {
        let (gravity, wind) = (plant.inputs().root().gravity_m_s2, plant.inputs().wind_m_s());
        let mut given = [0.0; 6];
        given[..3].copy_from_slice(gravity.as_slice());
        given[3..].copy_from_slice(wind.as_slice());
        let axes = Unit::try_new(gravity, 0.0).and_then(|down| {
            let ahead = Unit::try_new(down.dot(wind) * down.into_inner() - wind, LEVEL * wind.norm())?;
            Some(Matrix3::from_columns(&[ahead.into_inner(), down.cross(&ahead), down.into_inner()]))
        });
        Self { given, axes }
    }

    /// Whether the machine has an attitude.
    pub fn check(&self, turn: Turn) -> Result<(), Failure> {
        if self.axes.is_some() {
            return Ok(());
        }
        Err(Failure::Usage(format!(
            "--free {}: an attitude needs gravity and a wind that is not parallel to it; set gravity and wind.velocity",
            turn.name()
        )))
    }

    /// Takes the value of one of its inputs; returns whether `name` is one.
    pub fn take(&mut self, name: &str, value: f64) -> bool {
        let place = INPUTS.iter().position(|input| *input == name);
        if let Some(place) = place {
            self.given[place] = value;
        }
        place.is_some()
    }

    /// Gravity and wind as the machine sees them after turns of roll, pitch and yaw in rad, which count from the attitude given,
    /// yaw first.
    pub fn turned(&self, turns_rad: [f64; 3]) -> Vec<(String, f64)> {
        let [gravity, wind] = [0, 3].map(|first| Vector3::from_column_slice(&self.given[first..first + 3]));
        let [gravity, wind] = match self.axes {
            Some(axes) if turns_rad != [0.0; 3] => {
                let [roll, pitch, yaw] = turns_rad;
                // columns of the axes are those of Rotation3's angles: x ahead, y to the right, z down
                let turn = axes * Rotation3::from_euler_angles(roll, pitch, yaw).into_inner() * axes.transpose();
                [turn.transpose() * gravity, turn.transpose() * wind]
            }
            _ => [gravity, wind],
        };
        INPUTS.iter().map(|name| (*name).to_owned()).zip(gravity.iter().chain(wind.iter()).copied()).collect()
    }
}

/// Share of the wind across gravity below which its horizontal direction is undefined.
const LEVEL: f64 = 1e-6;
