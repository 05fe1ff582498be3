//! Sections and flow at one instant, NOTATION eq. (W13).

use crate::aero::flap::Deflection;
use crate::aero::flow::{Flow, Gust, GustShape};
use crate::load::SectionMotion;
use nalgebra::Vector3;
use std::borrow::Cow;

/// Acceleration and angular acceleration of a section relative to the root frame, resolved in it, m/s² and rad/s².
pub type SectionAcceleration = [Vector3<f64>; 2];

/// Distance in m of the front of a gust that fills all space.
const FAR_M: f64 = 1e12;

/// Motion of the sections and flow at one instant.
#[derive(Debug, Clone)]
pub struct Instant<'a> {
    /// Motion of all sections.
    pub motions: Cow<'a, [SectionMotion]>,
    /// Their accelerations.
    pub accelerations: Cow<'a, [SectionAcceleration]>,
    /// Flow.
    pub flow: Flow<'a>,
    /// A uniform gust in addition to those of the flow, root frame, m/s.
    pub gust_m_s: Vector3<f64>,
    /// Lag states: of strips in m/s, [`Strips::lags`](crate::aero::strip::Strips::lags); of rotors in their own units, [`Rotor::lags`](crate::aero::rotor::bem::Rotor::lags).
    pub lags: Cow<'a, [f64]>,
    /// Angles and rates of the control surfaces.
    pub flaps: Cow<'a, [Deflection]>,
    /// Rates of these rates in rad/s².
    pub flap_rad_s2: Cow<'a, [f64]>,
}

impl<'a> Instant<'a> {
    /// Gusts of the flow and the uniform one; without a uniform one they are borrowed.
    pub(in crate::aero) fn gusts(&self) -> Cow<'a, [Gust]> {
        if self.gust_m_s == Vector3::zeros() {
            return Cow::Borrowed(self.flow.gusts);
        }
        let uniform = Gust {
            name: String::new(),
            shape: GustShape::SharpEdge,
            velocity_m_s: self.gust_m_s,
            direction: Vector3::x(),
            speed_m_s: 0.0,
            origin_m: Vector3::x() * FAR_M,
            start_s: 0.0,
        };
        Cow::Owned(self.flow.gusts.iter().chain([&uniform]).cloned().collect())
    }

    /// Sections at the same positions without motion, accelerations, wind and lags, where only the apparent mass responds to an
    /// acceleration.
    pub(in crate::aero) fn still(&self) -> Self {
        let still = |motion: &SectionMotion| SectionMotion {
            velocity_m_s: Vector3::zeros(),
            spin_rad_s: Vector3::zeros(),
            ..*motion
        };
        let flow = Flow { wind_m_s: Vector3::zeros(), spin_rad_s: Vector3::zeros(), gusts: &[], ..self.flow };
        Self {
            motions: self.motions.iter().map(still).collect(),
            accelerations: vec![[Vector3::zeros(); 2]; self.accelerations.len()].into(),
            flow,
            gust_m_s: Vector3::zeros(),
            lags: vec![0.0; self.lags.len()].into(),
            flaps: self.flaps.clone(),
            flap_rad_s2: vec![0.0; self.flap_rad_s2.len()].into(),
        }
    }
}
