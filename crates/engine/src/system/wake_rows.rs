//! Advice for wake rows that are too long for their vorticity, and for stalled strips of a lattice.

use crate::system::Statistics;

/// Length of wake rows in panels above which they are too coarse: `aerodynamics.step_s` is too long.
pub const MAXIMUM_ROW_PANELS: f64 = 2.0;

impl Statistics {
    /// Advice if strips of a lattice have stalled.
    pub fn advice_on_stall(&self) -> Option<String> {
        (self.stalled_steps > 0).then(|| {
            format!(
                "in {} aerodynamic steps strips of the lattice were beyond stall, where the circulation is not unique: \
                 their lift \
                 followed the polar with a lag of 3 semi-chords and depends on the number of strips",
                self.stalled_steps
            )
        })
    }

    /// Advice if rows of the wake are longer than `MAXIMUM_ROW_PANELS`, with aerodynamic steps of `step_s` in s.
    pub fn advice_on_rows(&self, step_s: f64) -> Option<String> {
        // a distance of a whole number of panels is reached only to round-off
        (self.longest_row_panels > MAXIMUM_ROW_PANELS * (1.0 + 1e-9)).then(|| {
            let longest = self.longest_row_panels;
            // with enough decimals to differ from the bound
            let exceeds = |&decimals: &usize| {
                let half_unit = 0.5 * 10f64.powi(-(decimals as i32));
                longest >= MAXIMUM_ROW_PANELS + half_unit
            };
            let decimals = (1..9).find(exceeds).unwrap_or(9);
            // rounded down to two digits, so that the suggested value is small enough
            let exact_s = step_s * MAXIMUM_ROW_PANELS / longest;
            let unit_s = 10f64.powf(exact_s.log10().floor() - 1.0);
            let shorter_s = (exact_s / unit_s * (1.0 + 1e-9)).floor() * unit_s;
            format!(
                "rows of the wake are up to {longest:.decimals$} panel chords long, and more than {MAXIMUM_ROW_PANELS} \
                 are too coarse: set aerodynamics.step_s to at most {shorter_s:.1e} s (it is {step_s:.3e} s)"
            )
        })
    }
}
