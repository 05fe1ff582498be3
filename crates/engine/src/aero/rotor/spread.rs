//! Distribution of the loads of blade sections to the structure, and their sum over the rotor.

use crate::aero::AirLoads;
use crate::aero::rotor::bem::{Cut, Disc, Rotor};
use crate::aero::rotor::options::Spread;
use crate::load::Wrench;
use nalgebra::Vector3;

impl Rotor {
    /// Distributes the line loads to the sections and sums thrust and torque, including those of represented blades.
    pub(super) fn spread(&self, loads: &mut AirLoads, disc: &mut Disc) {
        for (blade, range) in self.blades.iter().enumerate() {
            let (cuts, loads) = (&self.cuts[range.clone()], &mut loads.circulatory[range.clone()]);
            let places_m = &self.options.positions_m[blade];
            match self.options.features.spread {
                Spread::Linear => {
                    let weights = if self.options.sections_turn[blade] { WITH_LEVERS } else { FORCES_ALONE };
                    spread_in_lines(cuts, places_m, weights, loads, disc);
                }
                Spread::Cells => spread_over_cells(cuts, places_m, self.options.lengths_m[blade], loads, disc),
            }
        }
        disc.loads.thrust_n *= self.like;
        disc.loads.torque_n_m *= self.like;
        disc.loads.power_w = disc.loads.torque_n_m * disc.loads.speed_rad_s;
    }
}

/// Weights of a section's own line load and of its neighbour's, eq. (B8): times the length between them for the force, times its square for
/// the moment.
type Weights = [[f64; 2]; 2];
const WITH_LEVERS: Weights = [[7.0 / 20.0, 3.0 / 20.0], [3.0 / 60.0, 2.0 / 60.0]];
/// Weights for sections at which moments do no work as the blade bends.
const FORCES_ALONE: Weights = [[1.0 / 3.0, 1.0 / 6.0], [0.0, 0.0]];

/// Distributes line loads that are linear between the sections, eq. (B8).
fn spread_in_lines(cuts: &[Cut], places_m: &[f64], [forces, levers]: Weights, loads: &mut [Wrench], disc: &mut Disc) {
    for (inner, places_m) in places_m.windows(2).enumerate() {
        let ends = [inner, inner + 1];
        let length_m = places_m[1] - places_m[0];
        let segment_m = cuts[ends[1]].from_apex_m - cuts[ends[0]].from_apex_m;
        let along = segment_m.try_normalize(1e-9).unwrap_or_else(Vector3::zeros);
        for (own, other, sign) in [(ends[0], ends[1], 1.0), (ends[1], ends[0], -1.0)] {
            let (near, far) = (&cuts[own], &cuts[other]);
            let force_n = (near.line_n_m * forces[0] + far.line_n_m * forces[1]) * length_m;
            let lever_n_m = (near.line_n_m * levers[0] + far.line_n_m * levers[1]) * (sign * length_m * length_m);
            let moment_n_m = (near.moment_n * 2.0 + far.moment_n) * (length_m / 6.0) + along.cross(&lever_n_m);
            disc.put(near, &force_n, &moment_n_m, &mut loads[own]);
        }
    }
}

/// Distributes constant line loads in cells about the sections, eq. (B26).
fn spread_over_cells(cuts: &[Cut], places_m: &[f64], length_m: f64, loads: &mut [Wrench], disc: &mut Disc) {
    let half_way_m = |inner: usize| 0.5 * (places_m[inner] + places_m[inner + 1]);
    let last = places_m.len() - 1;
    for (index, (cut, load)) in cuts.iter().zip(loads).enumerate() {
        let begin_m = if index == 0 { 0.0 } else { half_way_m(index - 1) };
        let end_m = if index == last { length_m } else { half_way_m(index) };
        let width_m = end_m - begin_m;
        disc.put(cut, &(cut.line_n_m * width_m), &(cut.moment_n * width_m), load);
    }
}

impl Disc {
    /// Adds a force in N at the quarter chord and a moment in N·m to the load of a section and to the loads of the rotor.
    fn put(&mut self, cut: &Cut, force_n: &Vector3<f64>, moment_n_m: &Vector3<f64>, load: &mut Wrench) {
        load.add_force_at(&cut.arm_m, force_n);
        load.moment_n_m += moment_n_m;
        self.loads.thrust_n += force_n.dot(&self.normal);
        let about_apex_n_m = cut.from_apex_m.cross(force_n) + moment_n_m;
        self.loads.torque_n_m += self.turn * about_apex_n_m.dot(&self.normal);
    }
}

#[cfg(test)]
mod tests {
    use super::{FORCES_ALONE, WITH_LEVERS};

    /// WT-58. For a line load that falls from 1 to 0 over a length of 1: force, first moment about its heavy end, and, with moments, the
    /// work on the displacements `s²` and `s³`.
    #[test]
    fn wt58_lumped_loads_are_exact() {
        for (forces, levers, degrees) in
            [(FORCES_ALONE[0], FORCES_ALONE[1], 0..2), (WITH_LEVERS[0], WITH_LEVERS[1], 0..4)]
        {
            for degree in degrees {
                let slope = |s: f64| if degree == 0 { 0.0 } else { f64::from(degree) * s.powi(degree - 1) };
                let heavy = forces[0] * 0f64.powi(degree) + levers[0] * slope(0.0);
                let light = forces[1] - levers[1] * slope(1.0);
                let exact = 1.0 / f64::from((degree + 1) * (degree + 2));
                assert!((heavy + light - exact).abs() < 1e-14, "degree {degree}: {} for {exact}", heavy + light);
            }
        }
    }
}
