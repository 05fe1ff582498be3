//! Operating points with their outputs.

use crate::operating_points::error::PointError;
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

/// Operating points of a rotor.
///
/// Serialised, it is the JSON of `foldwing operating-points`.
#[derive(Debug, Clone, PartialEq)]
pub struct OperatingPoints {
    /// Name of the model.
    pub machine: String,
    /// Outermost body of the first blade.
    pub blade: Option<String>,
    /// Name and unit of each output.
    pub outputs: Vec<(String, &'static str)>,
    /// Points in the order of the lists: pitch varies fastest, then speed.
    pub points: Vec<Point>,
}

/// An operating point.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Wind speed in m/s.
    pub wind_m_s: f64,
    /// Rotor speed in rpm; NaN if there is no state and no speed was given.
    pub speed_rpm: f64,
    /// Pitch in degrees; NaN if no joint pitches the blades.
    pub pitch_deg: f64,
    /// The state, or why there is none.
    pub state: Result<State, PointError>,
}

/// The state of a rotor at an operating point.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// The state is a motion that repeats every revolution; otherwise it is steady in the rotating frame.
    pub is_periodic: bool,
    /// Whether the search met the target of its output; `false` if the output is below the target at the start of the range. `None`
    /// without a search.
    pub held: Option<bool>,
    /// Statistics of each output over a revolution, in its unit.
    pub outputs: Vec<Statistics>,
}

/// Statistics of an output over a revolution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statistics {
    /// Mean.
    pub mean: f64,
    /// Largest minus smallest value.
    pub peak_to_peak: f64,
}

impl Point {
    /// Kind of the state: `steady`, `periodic` or `none`.
    pub fn state_name(&self) -> &'static str {
        match &self.state {
            Err(_) => "none",
            Ok(state) if state.is_periodic => "periodic",
            Ok(_) => "steady",
        }
    }

    /// Result of the search for the target: `held` or `below`; `None` without a search or a state.
    pub fn hold_name(&self) -> Option<&'static str> {
        let held = self.state.as_ref().ok()?.held?;
        Some(if held { "held" } else { "below" })
    }

    /// Statistics of the outputs; none without a state.
    pub fn outputs(&self) -> &[Statistics] {
        self.state.as_ref().map_or(&[], |state| &state.outputs)
    }
}

impl Serialize for OperatingPoints {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Output<'a> {
            name: &'a str,
            unit: &'a str,
        }
        let outputs: Vec<Output> = self.outputs.iter().map(|(name, unit)| Output { name, unit }).collect();
        let mut fields = serializer.serialize_struct("OperatingPoints", 3)?;
        fields.serialize_field("name", &self.machine)?;
        fields.serialize_field("outputs", &outputs)?;
        fields.serialize_field("points", &self.points)?;
        fields.end()
    }
}

impl Serialize for Point {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let column = |part: fn(&Statistics) -> f64| self.outputs().iter().map(part).collect::<Vec<f64>>();
        let mut fields = serializer.serialize_struct("Point", 8)?;
        fields.serialize_field("wind_m_s", &self.wind_m_s)?;
        fields.serialize_field("rotor_speed_rpm", &self.speed_rpm)?;
        fields.serialize_field("pitch_deg", &self.pitch_deg)?;
        fields.serialize_field("state", self.state_name())?;
        fields.serialize_field("hold", &self.hold_name())?;
        fields.serialize_field("message", &self.state.as_ref().err().map(ToString::to_string))?;
        fields.serialize_field("mean", &column(|output| output.mean))?;
        fields.serialize_field("peak_to_peak", &column(|output| output.peak_to_peak))?;
        fields.end()
    }
}
