//! Advice where the rows of a wake grow too long for what they carry, and where strips of a lattice stall.

use crate::system::Statistics;

/// Rows of the wake longer than this many panels are too coarse for what they carry: `aerodynamics.step_s` is too long.
pub const MAXIMUM_ROW_PANELS: f64 = 2.0;

impl Statistics {
    /// What to know where strips of a lattice have stalled.
    pub fn advice_on_stall(&self) -> Option<String> {
        (self.stalled_steps > 0).then(|| {
            format!(
                "in {} aerodynamic steps strips of the lattice were beyond stall, where neighbours may have several circulations: their lift \
                 followed the polar with a lag of 3 semi-chords and depends on the number of strips",
                self.stalled_steps
            )
        })
    }

    /// What to do where rows of the wake have outgrown `MAXIMUM_ROW_PANELS` with aerodynamic steps of `step_s` in s.
    pub fn advice_on_rows(&self, step_s: f64) -> Option<String> {
        // the way of a round number of panels is reached to round-off
        (self.longest_row_panels > MAXIMUM_ROW_PANELS * (1.0 + 1e-9)).then(|| {
            let longest = self.longest_row_panels;
            // as many decimals as tell it from the bound
            let exceeds = |&decimals: &usize| {
                let half_unit = 0.5 * 10f64.powi(-(decimals as i32));
                longest >= MAXIMUM_ROW_PANELS + half_unit
            };
            let decimals = (1..9).find(exceeds).unwrap_or(9);
            // down to two digits: what is written must cure it
            let exact_s = step_s * MAXIMUM_ROW_PANELS / longest;
            let unit_s = 10f64.powf(exact_s.log10().floor() - 1.0);
            let shorter_s = (exact_s / unit_s * (1.0 + 1e-9)).floor() * unit_s;
            format!(
                "the wake has rows of up to {longest:.decimals$} panels, and more than {MAXIMUM_ROW_PANELS} are too \
                 coarse: aerodynamics.step_s of at most {shorter_s:.1e} s instead of {step_s:.3e} s cures this"
            )
        })
    }
}
