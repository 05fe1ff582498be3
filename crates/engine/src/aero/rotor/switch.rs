//! Jumps of the momentum balance of annuli, for external integrators: NOTATION eq. (W24).

use crate::aero::polar::Polar;
use crate::aero::rotor::bem::Rotor;
use crate::aero::rotor::induction::{Annulus, Approach, normal_at_rest};

/// Relative speed in m/s below which an annulus has no jump: rotor and air rest.
const LEAST_SPEED_M_S: f64 = 1e-3;
/// Wind and largest wind of the propeller-brake state, relative to the speed of the section, below which its jump is of that size and not
/// an event: round-off would change the sign of the indicator of an unloaded annulus in still air.
const LEAST: f64 = 1e-3;

/// Velocity of the air through an annulus at which its balance jumps, relative to the speed of the section: the indicator has the sign of
/// the flow through the annulus, and falls through zero where the flow reverses at once, between windmill and propeller-brake state, eq.
/// (B6). It is continuous in hover, where the flow does not reverse. 1 where a jump would have no effect.
fn distance(annulus: &Annulus, polar: &Polar, approach: &Approach) -> f64 {
    let Approach { axial_m_s, tangential_m_s, .. } = *approach;
    let speed_m_s = axial_m_s.hypot(tangential_m_s);
    let normal = normal_at_rest(polar, approach);
    let brake_m_s = (0.5 * annulus.solidity * normal.abs()).sqrt() * tangential_m_s.abs();
    if speed_m_s < LEAST_SPEED_M_S || axial_m_s.abs().max(brake_m_s) < LEAST * speed_m_s {
        return 1.0;
    }
    (axial_m_s - brake_m_s.copysign(normal)) / speed_m_s
}

impl Rotor {
    /// Whether the balance of an annulus can jump: neither at an end of the blade, nor with an induced velocity that follows the load, nor
    /// with AeroDyn's rule, which stays in the windmill state.
    fn jumps(&self, section: usize) -> bool {
        let features = &self.options.features;
        let [tip_exponent, hub_exponent] = self.sections[section].exponents;
        let annulus = Annulus { solidity: 0.0, tip_exponent, hub_exponent };
        features.inflow_lag_s.is_none() && !features.aerodyn_compatible && !annulus.is_end()
    }

    /// Sections of the annuli whose balance can jump.
    pub fn switches(&self) -> impl Iterator<Item = usize> {
        (0..self.sections.len()).filter(|&section| self.jumps(section))
    }

    /// Whether loads jump with the balance; with dynamic inflow only rates of lag states do.
    pub fn loads_jump(&self) -> bool {
        !self.options.features.dynamic_inflow
    }

    /// Reads the distances of these annuli from their jumps, in the last evaluation; 1 for a rotor without induction. A jump is where the
    /// sign changes.
    pub fn read_switches(&self, distances: &mut [f64]) {
        for (value, section) in distances.iter_mut().zip(self.switches()) {
            let polar = &self.options.polars[self.sections[section].polar];
            *value = match &self.balances[section] {
                Some((annulus, approach, _)) if self.share > 0.0 => distance(annulus, polar, approach),
                Some(_) | None => 1.0,
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aero::polar::PolarRow;
    use crate::aero::rotor::induction::balance;

    /// Along winds from both sides, for a section with positive, no and negative lift at a flow angle of zero: the indicator has the sign of
    /// the flow through the annulus, and the flow is continuous except where the indicator changes its sign.
    #[test]
    fn the_indicator_has_the_sign_of_the_flow() {
        let rows = (-180..=180).map(|degree| {
            let angle_rad = f64::from(degree).to_radians();
            let lift = std::f64::consts::TAU * angle_rad.sin() * angle_rad.cos();
            PolarRow { angle_rad, lift, drag: 0.01 + 1.5 * angle_rad.sin().powi(2), moment: 0.0 }
        });
        let polar = Polar { rows: rows.collect() };
        let annulus = Annulus { solidity: 0.08, tip_exponent: 0.7, hub_exponent: 3.0 };
        let mut jumps = 0;
        for (chord_angle_rad, turning) in [(-0.15, 1.0), (0.0, 1.0), (0.12, 1.0), (-0.15, -1.0), (0.12, -1.0)] {
            let at = |step: i32| Approach {
                axial_m_s: 0.01 * f64::from(step) + 1e-3,
                tangential_m_s: turning * 20.0,
                chord_angle_rad,
            };
            let through_m_s = |approach: &Approach| {
                let found = balance(&annulus, &polar, approach);
                assert!(found.balanced, "{approach:?}");
                approach.axial_m_s - found.axial_loss_m_s
            };
            let (mut before_m_s, mut before) = (through_m_s(&at(-600)), distance(&annulus, &polar, &at(-600)));
            for step in -599..=600 {
                let approach = at(step);
                let (flow_m_s, indicator) = (through_m_s(&approach), distance(&annulus, &polar, &approach));
                let is_small = indicator == 1.0 || before == 1.0;
                assert!(is_small || flow_m_s * indicator > 0.0, "{approach:?}: {flow_m_s} {indicator}");
                let jumped = (flow_m_s - before_m_s).abs() > 0.5;
                assert_eq!(jumped, !is_small && indicator * before < 0.0, "{approach:?}: {before_m_s} {flow_m_s}");
                jumps += u32::from(jumped);
                (before_m_s, before) = (flow_m_s, indicator);
            }
        }
        assert_eq!(jumps, 4, "one for each loaded section");
    }
}
