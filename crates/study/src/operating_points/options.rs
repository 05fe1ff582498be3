//! Options of a table of operating points.

use crate::values::{Setting, Target};

/// Options of [`tabulate`](fn@crate::operating_points::tabulate).
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Wind speeds in m/s, in the direction of the model's wind; not negative.
    pub wind_m_s: Vec<f64>,
    /// Rotor speeds in rpm; `None`: that of the model. With a tip speed ratio one value, the maximum speed.
    pub speed_rpm: Option<Vec<f64>>,
    /// Ratio of the speed of the blade tips to the wind speed, from which the rotor speed follows.
    pub tip_speed_ratio: Option<f64>,
    /// Pitch angles of all blades in degrees, positive as the angles of the pitch joints; `None`: that of the model.
    pub pitch_deg: Option<Vec<f64>>,
    /// The lists are combined value by value, where a list of one value applies to all points; otherwise in all combinations.
    pub paired: bool,
    /// The pitch or the speed to search for.
    pub search: Option<Search>,
    /// Joint of the shaft; `None`: the only joint that rotates without limit and carries a hub.
    pub shaft: Option<String>,
    /// Joints that pitch the blades; `None`: those that connect the blades to the hub.
    pub pitch_joints: Option<Vec<String>>,
    /// Start values.
    pub settings: Vec<Setting>,
    /// Outputs in the table: names, patterns, prefixes, lists with commas ([`choose`](crate::names::choose)). If empty: outputs of the
    /// rotor, deflection and root loads of the first blade and of other bodies, and torques that hold joints.
    pub outputs: Vec<String>,
    /// Steps per revolution of a periodic state, rounded up to a multiple of 144.
    pub steps: usize,
    /// Difference between the ends of a revolution below which a state counts as periodic: rotation in rad, or displacement relative
    /// to the model's length; between 0 and 1.
    pub tolerance: f64,
}

impl Default for Options {
    /// 720 steps, tolerance 1e-6, and no wind.
    fn default() -> Self {
        Self {
            wind_m_s: Vec::new(),
            speed_rpm: None,
            tip_speed_ratio: None,
            pitch_deg: None,
            paired: false,
            search: None,
            shaft: None,
            pitch_joints: None,
            settings: Vec::new(),
            outputs: Vec::new(),
            steps: 720,
            tolerance: 1e-6,
        }
    }
}

/// A search for the value of an unknown at which the mean of an output has its target. If the output is below the target at the
/// start of the range, the start is kept.
#[derive(Debug, Clone, PartialEq)]
pub struct Search {
    /// The unknown with its range.
    pub unknown: Unknown,
    /// The output with its target.
    pub target: Target,
}

/// An unknown with its range, two different finite numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unknown {
    /// The pitch of all blades, in degrees.
    PitchDeg {
        /// Start of the search.
        from: f64,
        /// Its end.
        to: f64,
    },
    /// The speed of the rotor, in rpm.
    SpeedRpm {
        /// Start of the search.
        from: f64,
        /// Its end.
        to: f64,
    },
}

impl Unknown {
    /// Start and end of the range, in deg or rpm.
    pub fn range(&self) -> [f64; 2] {
        match *self {
            Self::PitchDeg { from, to } | Self::SpeedRpm { from, to } => [from, to],
        }
    }

    /// Whether it is the pitch.
    pub fn is_pitch(&self) -> bool {
        matches!(self, Self::PitchDeg { .. })
    }

    /// Its name: `pitch_deg` or `speed_rpm`.
    pub fn name(&self) -> &'static str {
        if self.is_pitch() { "pitch_deg" } else { "speed_rpm" }
    }
}
