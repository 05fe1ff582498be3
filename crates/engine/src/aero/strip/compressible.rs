//! Prandtl-Glauert rule for strips, NOTATION eq. (U22).

use crate::aero::near_sheets::Sonic;
use crate::aero::strip::section::Strip;
use crate::aero::strip::{Inflow, Strips};

/// Prandtl-Glauert factor on pressures at a Mach number, eq. (U22); kept finite from Mach 1 on, which [`Strips::sonic`] reports.
pub(super) fn compression(mach: f64) -> f64 {
    1.0 / (1.0 - mach * mach).max(1e-6).sqrt()
}

impl Strips {
    /// First strip of the surfaces at Mach 1 or beyond in the last evaluation, with its Mach number.
    pub fn sonic(&self) -> Option<Sonic> {
        let mach = |strip: &Strip, now: &Inflow| now.speed_m_s / strip.speed_of_sound_m_s;
        let index = self.strips.iter().zip(&self.inflows).position(|(strip, now)| mach(strip, now) >= 1.0)?;
        let strip = &self.strips[index];
        let mach = mach(strip, &self.inflows[index]);
        Some(Sonic { surface: strip.surface, strip: index - self.first[strip.surface], mach })
    }
}
