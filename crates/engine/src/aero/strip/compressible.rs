//! Validity of strips: subsonic flow, eq. (U22), and surfaces that do not overlap.

use crate::aero::near_sheets::{NoCirculation, Sonic};
use crate::aero::strip::Strips;
use crate::aero::strip::inflow::Inflow;
use crate::aero::strip::section::Strip;

impl Strips {
    /// Whether the model holds for the last evaluation.
    ///
    /// # Errors
    /// If a strip is at Mach 1 or beyond, or if two surfaces overlap where they are joined and the lifting line passes through both.
    pub fn validity(&self) -> Result<(), NoCirculation> {
        if let Some(sonic) = self.sonic() {
            return Err(NoCirculation::Sonic(sonic));
        }
        match self.line.as_ref().and_then(|line| line.overlap) {
            Some(crossed) => Err(NoCirculation::Overlapping(crossed)),
            None => Ok(()),
        }
    }

    /// First strip of the surfaces at Mach 1 or beyond in the last evaluation, with its Mach number.
    fn sonic(&self) -> Option<Sonic> {
        let mach = |strip: &Strip, now: &Inflow| now.speed_m_s / strip.speed_of_sound_m_s;
        let index = self.strips.iter().zip(&self.inflows).position(|(strip, now)| mach(strip, now) >= 1.0)?;
        let strip = &self.strips[index];
        let mach = mach(strip, &self.inflows[index]);
        Some(Sonic { surface: strip.surface, strip: index - self.first[strip.surface], mach })
    }
}
