//! The result of a sweep over wind speeds.

use crate::warnings::Warning;
use foldwing_engine::machine::Travel;
use foldwing_engine::plant::{Branches, Crossing, ModeShape, PlantError};
use nalgebra::Complex;
use serde::Serialize;
use serde::ser::{SerializeStruct, Serializer};
use std::fmt;

/// Aeroelastic modes as functions of the wind speed, with flutter and divergence.
///
/// Serialised, it is an entry of `results` in the JSON of `foldwing flutter`: without mode shapes.
#[derive(Debug, Clone, PartialEq)]
pub struct Flutter {
    /// Modes over the speed in m/s: those of lowest frequency at the first speed, and all that are unstable at any speed.
    pub branches: Branches<ModeShape>,
    /// Speeds in m/s at which modes become unstable or stable, ascending.
    pub crossings: Vec<Crossing<ModeShape>>,
    /// Speeds of divergence in m/s, ascending.
    pub divergence_m_s: Vec<f64>,
    /// Events between two speeds that are not represented by a speed of flutter or divergence, ascending.
    pub changes: Vec<Change>,
    /// Speed at which the sweep ended early, and the reason.
    pub ended: Option<Ended>,
    /// Warnings: assumptions of the aerodynamic models that the machine does not meet at one of the speeds.
    pub warnings: Vec<Warning>,
}

/// A speed at which a sweep ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Ended {
    /// The first speed in m/s without a result.
    pub wind_m_s: f64,
    /// Reason why it has none.
    pub error: PlantError,
}

/// An event between two speeds. Its `Display` text is a phrase for messages.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// Speeds in m/s that bracket the change.
    pub between_m_s: [f64; 2],
    /// The event.
    pub event: Event,
}

/// An event of a sweep other than flutter and divergence.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// Latches open or close: the modes below and above belong to different configurations.
    Latch {
        /// Joints that move or latch.
        joints: Vec<JointChange>,
        /// No equilibrium was found in between.
        lost: bool,
    },
    /// The equilibrium jumps, or there is none in between.
    Jump {
        /// Joints that move.
        joints: Vec<JointChange>,
        /// No equilibrium was found in between.
        lost: bool,
    },
    /// A mode becomes unstable, and the speed at which it does is not found.
    Unstable {
        /// Index of the branch.
        branch: usize,
        /// Eigenvalue in 1/s at the higher speed.
        eigenvalue_1_s: Complex<f64>,
        /// Frequency in Hz there; `None` for a real mode.
        frequency_hz: Option<f64>,
    },
    /// The static aeroelastic stiffness changes sign, and the speed at which it does is not found.
    Divergence,
}

/// A joint whose equilibrium differs between two speeds.
#[derive(Debug, Clone, PartialEq)]
pub struct JointChange {
    /// Name of the joint.
    pub joint: String,
    /// Whether its latch closes (`true`) or opens; `None` if it does neither.
    pub closes: Option<bool>,
    /// Whether it rotates or slides.
    pub travel: Travel,
    /// Angles in rad, or positions in m, at the lower and the higher speed; `None` if they are equal within 1e-3.
    pub from_to: Option<[f64; 2]>,
}

impl Flutter {
    /// Speeds at which an oscillation starts to grow, ascending.
    pub fn flutter(&self) -> impl Iterator<Item = &Crossing<ModeShape>> {
        self.oscillating().filter(|crossing| crossing.begins)
    }

    fn oscillating(&self) -> impl Iterator<Item = &Crossing<ModeShape>> {
        self.crossings.iter().filter(|crossing| !crossing.mode.is_real())
    }

    /// Returns whether a mode is unstable at the first speed.
    pub fn is_unstable_from_first(&self) -> bool {
        self.branches.places.first().is_some_and(|place| place.modes.iter().flatten().any(ModeShape::grows))
    }

    /// Number of modes tracked.
    pub fn modes_tracked(&self) -> usize {
        self.branches.places.first().map_or(0, |place| place.modes.len())
    }

    /// First and last speed in m/s with modes.
    pub fn covered_m_s(&self) -> Option<[f64; 2]> {
        let places = &self.branches.places;
        places.first().zip(places.last()).map(|(first, last)| [first.at, last.at])
    }
}

impl Event {
    /// Name of the kind: `latch`, `jump`, `unstable` or `divergence`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Latch { .. } => "latch",
            Self::Jump { .. } => "jump",
            Self::Unstable { .. } => "unstable",
            Self::Divergence => "divergence",
        }
    }
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Latch { joints, lost } => {
                write!(f, "the configuration of the joints changes, so the modes change as well{}", details(joints, *lost))
            }
            Self::Jump { joints, lost } => {
                write!(f, "the equilibrium jumps, as it does beyond the divergence speed of a loaded wing{}", details(joints, *lost))
            }
            Self::Unstable { branch, eigenvalue_1_s, frequency_hz } => {
                let how = frequency_hz.map_or("not oscillating".to_owned(), |hz| format!("at {hz:.4} Hz"));
                write!(f, "mode {} becomes unstable: growth rate {:.4} 1/s, {how}", branch + 1, eigenvalue_1_s.re)
            }
            Self::Divergence => f.write_str(
                "the static stiffness changes its sign, but the speed was not found: divergence, or another branch of equilibria",
            ),
        }
    }
}

fn details(joints: &[JointChange], lost: bool) -> String {
    let mut parts = Vec::new();
    for JointChange { joint, closes, travel, from_to } in joints {
        if let Some(closes) = closes {
            parts.push(format!("the latch of {joint} {}", if *closes { "closes" } else { "opens" }));
        }
        if let Some(ends) = from_to {
            let [from, to] = ends.map(|value| travel.shown(value));
            parts.push(format!("{joint} goes from {from:.3} to {to:.3} {}", travel.shown_unit()));
        }
    }
    if lost {
        parts.push("no equilibrium in between".to_owned());
    }
    if parts.is_empty() { String::new() } else { format!(": {}", parts.join(", ")) }
}

impl Serialize for Flutter {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Speed {
            speed_m_s: f64,
            #[serde(rename = "frequency_Hz")]
            frequency_hz: f64,
            mode: usize,
            begins: bool,
        }
        #[derive(Serialize)]
        struct Place {
            speed_m_s: f64,
            eigenvalues_1_s: Vec<Option<[f64; 2]>>,
        }
        let speed = |crossing: &Crossing<ModeShape>| Speed {
            speed_m_s: crossing.at,
            frequency_hz: crossing.mode.frequency_hz,
            mode: crossing.branch + 1,
            begins: crossing.begins,
        };
        let pair = |mode: &Option<ModeShape>| {
            let value = mode.as_ref()?.eigenvalue_1_s;
            Some([value.re, value.im])
        };
        let places = self.branches.places.iter();
        let places =
            places.map(|place| Place { speed_m_s: place.at, eigenvalues_1_s: place.modes.iter().map(pair).collect() });
        let mut fields = serializer.serialize_struct("Flutter", 9)?;
        fields.serialize_field("flutter", &self.oscillating().map(speed).collect::<Vec<_>>())?;
        fields.serialize_field("divergence_m_s", &self.divergence_m_s)?;
        fields.serialize_field("changes", &self.changes)?;
        fields.serialize_field("unstable_from_first", &self.is_unstable_from_first())?;
        fields.serialize_field("modes_tracked", &self.modes_tracked())?;
        fields.serialize_field("covered_m_s", &self.covered_m_s())?;
        fields.serialize_field("ended", &self.ended)?;
        fields.serialize_field("warnings", &self.warnings)?;
        fields.serialize_field("modes", &places.collect::<Vec<_>>())?;
        fields.end()
    }
}

impl Serialize for Change {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Change", 3)?;
        fields.serialize_field("kind", self.event.name())?;
        fields.serialize_field("between_m_s", &self.between_m_s)?;
        fields.serialize_field("text", &self.event.to_string())?;
        fields.end()
    }
}

impl Serialize for Ended {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Ended", 2)?;
        fields.serialize_field("speed_m_s", &self.wind_m_s)?;
        fields.serialize_field("message", &self.error.to_string())?;
        fields.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The text of an event lists the joints with the unit of their travel, and whether there is an equilibrium in between.
    #[test]
    fn events_name_joints_with_their_units() {
        let turns = JointChange {
            joint: "fold".to_owned(),
            closes: Some(true),
            travel: Travel::Rotation,
            from_to: Some([0.5 * std::f64::consts::PI, 0.0]),
        };
        let slides = JointChange {
            joint: "rail".to_owned(),
            closes: Some(false),
            travel: Travel::Translation,
            from_to: Some([0.25, 1.0]),
        };
        let latch = Event::Latch { joints: vec![turns, slides], lost: true };
        let expected = "the configuration of the joints changes, so the modes change as well: the latch of fold \
                        closes, fold goes from 90.000 to 0.000 deg, \
                        the latch of rail opens, rail goes from 0.250 to 1.000 m, no equilibrium in between";
        assert_eq!(latch.to_string(), expected);
        let jump = Event::Jump { joints: Vec::new(), lost: false };
        assert_eq!(jump.to_string(), "the equilibrium jumps, as it does beyond the divergence speed of a loaded wing");
        let eigenvalue_1_s = Complex::new(0.125, 2.0);
        let grows = |frequency_hz| Event::Unstable { branch: 1, eigenvalue_1_s, frequency_hz }.to_string();
        assert_eq!(grows(Some(1.5)), "mode 2 becomes unstable: growth rate 0.1250 1/s, at 1.5000 Hz");
        assert_eq!(grows(None), "mode 2 becomes unstable: growth rate 0.1250 1/s, not oscillating");
        assert_eq!(json(&Change { between_m_s: [1.0, 2.0], event: Event::Divergence })["kind"], "divergence");
    }

    fn json(value: &impl Serialize) -> serde_json::Value {
        serde_json::to_value(value).unwrap_or_else(|error| panic!("{error}"))
    }
}
