//! Gusts in code: equivalent of a table `[gust.<name>]` of the model file.

use crate::aero::flow::{Gust, GustShape};
use crate::machine::fault::{Checker, array_text};
use crate::machine::units::shortest;
use nalgebra::Vector3;

/// A gust under construction, see [`GustBuilder::new`].
#[derive(Debug, Clone, PartialEq)]
pub struct GustBuilder {
    pub(super) name: String,
    shape: GustShape,
    velocity_m_s: Vector3<f64>,
    direction: Option<Vector3<f64>>,
    speed_m_s: Option<f64>,
    origin_m: Vector3<f64>,
    start_s: f64,
}

impl GustBuilder {
    /// A gust with its shape and its largest added velocity in m/s, root frame; for turbulence, its standard deviation. By default it
    /// travels with the wind and passes the root's origin at 0 s.
    pub fn new(name: impl Into<String>, shape: GustShape, velocity_m_s: impl Into<Vector3<f64>>) -> Self {
        Self {
            name: name.into(),
            shape,
            velocity_m_s: velocity_m_s.into(),
            direction: None,
            speed_m_s: None,
            origin_m: Vector3::zeros(),
            start_s: 0.0,
        }
    }

    /// Direction in which the gust travels, root frame, of any nonzero length.
    pub fn direction(self, direction: impl Into<Vector3<f64>>) -> Self {
        Self { direction: Some(direction.into()), ..self }
    }

    /// Speed at which the gust travels in m/s.
    pub fn speed_m_s(self, speed_m_s: f64) -> Self {
        Self { speed_m_s: Some(speed_m_s), ..self }
    }

    /// Position in m that its front passes at [`GustBuilder::start_s`].
    pub fn origin_m(self, origin_m: impl Into<Vector3<f64>>) -> Self {
        Self { origin_m: origin_m.into(), ..self }
    }

    /// Time in s at which the gust's front passes [`GustBuilder::origin_m`].
    pub fn start_s(self, start_s: f64) -> Self {
        Self { start_s, ..self }
    }

    pub(super) fn build(&self, wind_m_s: &Vector3<f64>, checker: &mut Checker) -> Option<Gust> {
        let place = |key| ["gust", self.name.as_str(), key];
        let direction = self.direction.unwrap_or(*wind_m_s);
        let Some(unit) = direction.try_normalize(0.0).filter(|unit| unit.norm() > 0.5) else {
            let allowed = "an array of 3 finite numbers, not all 0; its default is the direction of wind_m_s";
            checker.refuse(&place("direction"), array_text(direction.as_slice()), allowed);
            return None;
        };
        let speed_m_s = self.speed_m_s.unwrap_or(wind_m_s.norm());
        if speed_m_s <= 0.0 {
            let allowed = "a finite speed > 0 m/s; its default is the magnitude of wind_m_s";
            checker.refuse(&place("speed_m_s"), shortest(speed_m_s), allowed);
            return None;
        }
        Some(Gust {
            name: self.name.clone(),
            shape: self.shape.clone(),
            velocity_m_s: self.velocity_m_s,
            direction: unit,
            speed_m_s,
            origin_m: self.origin_m,
            start_s: self.start_s,
        })
    }
}
