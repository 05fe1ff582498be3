//! Rigid rotor at constant speed in uniform axial wind: loads of the rotor and of its blades.

use crate::aero::pieces::Pieces;
use crate::aero::polar::Polar;
use crate::aero::rotor::induction::{Annular, Annulus, Approach, EndRule, SectionState, balance};
use std::f64::consts::PI;

/// Tip-speed ratios between which the induction is blended in, eq. (B7): momentum theory does not hold for the wake of a stopped rotor.
const FADE: [f64; 2] = [1.0, 2.0];

/// Node of a blade at which aerodynamic loads are computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BladeNode {
    /// Distance from the shaft axis in m.
    pub radius_m: f64,
    /// Chord in m.
    pub chord_m: f64,
    /// Angle from the plane of rotation to the chord at zero pitch in rad, positive towards feather.
    pub twist_rad: f64,
    /// Index of the polar.
    pub polar: usize,
}

/// A rotor with straight blades in one plane; the loads are linear between nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyRotor {
    /// Number of blades.
    pub blades: usize,
    /// Inner radius of the blades in m, for Prandtl's hub loss.
    pub hub_radius_m: f64,
    /// Radius in m of the blade tips, for Prandtl's tip loss and the reference area of all coefficients.
    pub tip_radius_m: f64,
    /// Density of the air in kg/m³.
    pub density_kg_m3: f64,
    /// Nodes from the hub to the tip, at least two, radii ascending.
    pub nodes: Vec<BladeNode>,
    /// Polars from −180° to 180°.
    pub polars: Vec<Polar>,
    /// Rule for the loads at nodes with complete loss.
    pub end_loads: EndRule,
}

/// Induction and loads of a node of a blade.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeLoad {
    /// Axial induction factor; 1 at a stopped end.
    pub axial_induction: f64,
    /// Tangential induction factor.
    pub tangential_induction: f64,
    /// Flow angle, angle of attack and static coefficients.
    pub section: SectionState,
    /// Force per length along the wind in N/m.
    pub normal_n_m: f64,
    /// Force per length that drives the rotor in N/m.
    pub driving_n_m: f64,
}

/// Loads of the rotor.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyLoads {
    /// Thrust along the wind in N.
    pub thrust_n: f64,
    /// Torque about the shaft in N·m.
    pub torque_n_m: f64,
    /// Power in W.
    pub power_w: f64,
    /// Power divided by `½ρπR²U³`.
    pub power_coefficient: f64,
    /// Thrust divided by `½ρπR²U²`.
    pub thrust_coefficient: f64,
    /// Loads node by node.
    pub nodes: Vec<NodeLoad>,
}

/// Fraction of the induction that applies at a tip-speed ratio, eq. (B7): none below 1, all from 2 on, as in AeroDyn.
pub fn induction_share(tip_speed_ratio: f64) -> f64 {
    induction_share_on(tip_speed_ratio, &mut Pieces::Free)
}

/// The same on pieces of its limits.
pub fn induction_share_on(tip_speed_ratio: f64, pieces: &mut Pieces) -> f64 {
    let [none, all] = FADE;
    let x = pieces.within((tip_speed_ratio.abs() - none) / (all - none), [0.0, 1.0]);
    0.5 * (1.0 - (PI * x).cos())
}

/// State of a section in its annulus with a fraction of the induction, eq. (B7). `None` at an end of the blade without load.
pub fn section(
    annulus: &Annulus,
    polar: &Polar,
    approach: &Approach,
    end_loads: EndRule,
    share: f64,
) -> Option<(Annular, SectionState)> {
    let state = match (annulus.is_end(), end_loads) {
        (true, EndRule::ZeroLoad) => return None,
        (true, EndRule::Stopped) => Annular { axial_loss_m_s: approach.axial_m_s, ..Annular::FREE },
        (false, _) => balance(annulus, polar, approach),
    };
    let state = Annular { axial_loss_m_s: share * state.axial_loss_m_s, swirl_m_s: share * state.swirl_m_s, ..state };
    let axial_m_s = approach.axial_m_s - state.axial_loss_m_s;
    let tangential_m_s = approach.tangential_m_s + state.swirl_m_s;
    Some((state, SectionState::of(axial_m_s, tangential_m_s, approach.chord_angle_rad, polar)))
}

/// Replaces a line load that varies linearly between the given positions by point loads at these positions, eq. (B8); force and first
/// moment are exact. Calls `add(node, other, metres)`: the node receives `metres` times the line load of `other`.
pub fn lump(places_m: impl ExactSizeIterator<Item = f64> + Clone, mut add: impl FnMut(usize, usize, f64)) {
    for (node, (inner_m, outer_m)) in places_m.clone().zip(places_m.skip(1)).enumerate() {
        let sixth_m = (outer_m - inner_m) / 6.0;
        add(node, node, 2.0 * sixth_m);
        add(node, node + 1, sixth_m);
        add(node + 1, node, sixth_m);
        add(node + 1, node + 1, 2.0 * sixth_m);
    }
}

impl SteadyRotor {
    /// Loads for a wind in m/s, a rotor speed in rad/s and a pitch angle in rad, positive towards feather.
    pub fn at(&self, wind_m_s: f64, speed_rad_s: f64, pitch_rad: f64) -> SteadyLoads {
        let tip_m_s = speed_rad_s * self.tip_radius_m;
        let share = if wind_m_s == 0.0 { 1.0 } else { induction_share(tip_m_s / wind_m_s) };
        let nodes: Vec<NodeLoad> =
            self.nodes.iter().map(|node| self.node(node, wind_m_s, speed_rad_s, pitch_rad, share)).collect();
        let (mut thrust_n, mut torque_n_m) = (0.0, 0.0);
        lump(self.nodes.iter().map(|node| node.radius_m), |at, of, length_m| {
            thrust_n += self.blades as f64 * length_m * nodes[of].normal_n_m;
            torque_n_m += self.blades as f64 * length_m * nodes[of].driving_n_m * self.nodes[at].radius_m;
        });
        let power_w = torque_n_m * speed_rad_s;
        let pressure_n = 0.5 * self.density_kg_m3 * PI * self.tip_radius_m.powi(2) * wind_m_s.powi(2);
        SteadyLoads {
            thrust_n,
            torque_n_m,
            power_w,
            power_coefficient: power_w / (pressure_n * wind_m_s),
            thrust_coefficient: thrust_n / pressure_n,
            nodes,
        }
    }

    fn node(&self, node: &BladeNode, wind_m_s: f64, speed_rad_s: f64, pitch_rad: f64, share: f64) -> NodeLoad {
        let polar = &self.polars[node.polar];
        let annulus = Annulus::new(self.blades, node.chord_m, node.radius_m, self.hub_radius_m, self.tip_radius_m);
        let approach = Approach {
            axial_m_s: wind_m_s,
            tangential_m_s: speed_rad_s * node.radius_m,
            chord_angle_rad: node.twist_rad + pitch_rad,
        };
        match section(&annulus, polar, &approach, self.end_loads, share) {
            Some((state, section)) => {
                let [normal, driving] = section.force_m3_s2(node.chord_m);
                NodeLoad {
                    axial_induction: state.axial_loss_m_s / wind_m_s,
                    tangential_induction: state.swirl_m_s / approach.tangential_m_s,
                    section,
                    normal_n_m: self.density_kg_m3 * normal,
                    driving_n_m: self.density_kg_m3 * driving,
                }
            }
            None => NodeLoad {
                axial_induction: 1.0,
                tangential_induction: 0.0,
                section: SectionState::of(0.0, approach.tangential_m_s, approach.chord_angle_rad, polar),
                normal_n_m: 0.0,
                driving_n_m: 0.0,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lumped_loads_keep_force_and_moment_of_straight_lines() {
        let places_m = [1.0f64, 2.5, 3.0, 7.0];
        let load = [10.0f64, -4.0, 6.0, 1.0];
        let (mut force, mut moment) = (0.0, 0.0);
        lump(places_m.iter().copied(), |at, of, length_m| {
            force += length_m * load[of];
            moment += length_m * load[of] * places_m[at];
        });
        // reference: fine sums by the midpoint rule
        let (mut expected_force, mut expected_moment) = (0.0, 0.0);
        for i in 0..3 {
            let (count, length) = (20_000, places_m[i + 1] - places_m[i]);
            for k in 0..count {
                let share = (f64::from(k) + 0.5) / f64::from(count);
                let (place, line) = (places_m[i] + share * length, load[i] + share * (load[i + 1] - load[i]));
                expected_force += line * length / f64::from(count);
                expected_moment += line * place * length / f64::from(count);
            }
        }
        approx::assert_relative_eq!(force, expected_force, max_relative = 1e-8);
        approx::assert_relative_eq!(moment, expected_moment, max_relative = 1e-8);
    }

    #[test]
    fn induction_fades_in_between_tip_speed_ratios_one_and_two() {
        assert_eq!([0.0, 0.99, 1.0, 2.0, 9.0].map(induction_share), [0.0, 0.0, 0.0, 1.0, 1.0]);
        approx::assert_relative_eq!(induction_share(-1.5), 0.5, max_relative = 1e-12);
    }
}
