//! One step of one strip: state and loads from its state before the step.

use crate::aero::AirLoads;
use crate::aero::flap::HingeMoment;
use crate::aero::flow::{AirPath, Flow};
use crate::aero::pieces::Pieces;
use crate::aero::strip::flap::MassRates;
use crate::aero::strip::section::Strip;
use crate::aero::strip::{Inflow, StripHistory, Strips};
use std::f64::consts::PI;

impl Strips {
    /// Computes state and loads of a strip at the end of a step.
    pub(super) fn advance(
        &self,
        (index, now): (usize, &Inflow),
        before: &StripHistory,
        (flow, step_s): (&Flow, f64),
        hinges: &mut [HingeMoment],
        loads: &mut AirLoads,
        pieces: &mut Pieces,
    ) -> StripHistory {
        let (motion, gust) = self.options.lags(before, now, now.gust_downwash_m_s, step_s);
        let mut after = now.history(motion, gust);
        self.add_circulatory((index, now), flow, &mut after, hinges, loads, pieces);
        if self.options.apparent_mass && step_s > 0.0 {
            add_impulsive(&self.strips[index], now, flow, [before, &after], step_s, hinges, loads);
        }
        after
    }
}

/// Adds the loads of the apparent mass: mean rate of its impulse over the step, eq. (W8).
fn add_impulsive(
    strip: &Strip,
    now: &Inflow,
    flow: &Flow,
    [before, after]: [&StripHistory; 2],
    step_s: f64,
    hinges: &mut [HingeMoment],
    loads: &mut AirLoads,
) {
    let semi_chord_m = 0.5 * now.cut.chord_m;
    let mass_kg_m = PI * flow.density_kg_m3 * semi_chord_m.powi(2);
    let middle_m_s2 = (after.middle_m_s - before.middle_m_s) / step_s;
    let force_n = mass_kg_m * middle_m_s2 * now.cut.span_m;
    let pitching_m_s2 = (after.difference_m_s - before.difference_m_s) / step_s;
    let moment_n_m = -mass_kg_m * semi_chord_m / 16.0 * pitching_m_s2 * now.cut.span_m;
    let mean_up = 0.5 * (AirPath::new(flow, step_s).turned(&before.up) + after.up);
    strip.add_force(&mut loads.impulsive, &now.cut, 0.5, &(mean_up * force_n));
    strip.add_moment(&mut loads.impulsive, &now.cut, moment_n_m);
    if let Some(flap) = &now.flap {
        let flap_rad_s2 = (after.flap_rate_rad_s - before.flap_rate_rad_s) / step_s;
        let rates = MassRates { middle_m_s2, difference_m_s2: pitching_m_s2, flap_rad_s2 };
        hinges[flap.flap].impulsive_n_m +=
            now.add_flap_mass(strip, flow.density_kg_m3, &mean_up, &rates, &mut loads.impulsive);
    }
}
