//! Distribution of the loads of blade sections to the structure, and their sum over the rotor.

use crate::aero::AirLoads;
use crate::aero::rotor::bem::Rotor;
use crate::aero::rotor::disc::{Cut, Disc};
use crate::aero::rotor::options::Spread;
use crate::load::Wrench;
use crate::math::so3::hat;
use nalgebra::{Matrix3, SMatrix, Vector3};

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

/// Number of entries of a section on which the loads depend: line load, line moment, arm of the quarter chord, place from the apex.
pub(super) const SPREAD: usize = 12;

/// Derivatives of the load of a section, force and moment, with respect to the [`SPREAD`] entries of itself and of another section.
pub(super) struct Share {
    pub sections: [usize; 2],
    pub slopes: [SMatrix<f64, 6, SPREAD>; 2],
}

impl Rotor {
    /// Derivatives of the distributed loads for the line loads and moments of the last evaluation.
    pub(super) fn spread_slopes(&self) -> Vec<Share> {
        let mut shares = Vec::new();
        for (blade, range) in self.blades.iter().enumerate() {
            let places_m = &self.options.positions_m[blade];
            match self.options.features.spread {
                Spread::Linear => {
                    let weights = if self.options.sections_turn[blade] { WITH_LEVERS } else { FORCES_ALONE };
                    shares.extend(places_m.windows(2).enumerate().flat_map(|(inner, places_m)| {
                        let ends = [range.start + inner, range.start + inner + 1];
                        let length_m = places_m[1] - places_m[0];
                        [([ends[0], ends[1]], 1.0), ([ends[1], ends[0]], -1.0)]
                            .map(|(sections, sign)| self.share_of_line(sections, (sign, length_m), weights))
                    }));
                }
                Spread::Cells => shares.extend(range.clone().map(|section| {
                    let width_m = cell_m(section - range.start, places_m, self.options.lengths_m[blade]);
                    self.share_of_cell(section, width_m)
                })),
            }
        }
        shares
    }

    /// Share of a pair of neighbours in [`spread_in_lines`]; `sign`: 1 for the inner of the two.
    fn share_of_line(&self, sections: [usize; 2], (sign, length_m): (f64, f64), [forces, levers]: Weights) -> Share {
        let [near, far] = sections.map(|section| &self.cuts[section]);
        let segment_m = (far.from_apex_m - near.from_apex_m) * sign;
        let along = segment_m.try_normalize(1e-9).unwrap_or_else(Vector3::zeros);
        let force_n = (near.line_n_m * forces[0] + far.line_n_m * forces[1]) * length_m;
        let lever_n_m = (near.line_n_m * levers[0] + far.line_n_m * levers[1]) * (length_m * length_m * sign);
        // of the direction by the place of the far section, times the lever
        let turning =
            hat(&lever_n_m) * (Matrix3::identity() - along * along.transpose()) * (-sign / segment_m.norm().max(1e-9));
        let mut slopes = [SMatrix::<f64, 6, SPREAD>::zeros(); 2];
        for (of, side) in slopes.iter_mut().zip([-1.0, 1.0]) {
            of.fixed_view_mut::<3, 3>(3, 9).copy_from(&(turning * side));
        }
        for (of, (force, (lever, moment))) in
            slopes.iter_mut().zip(forces.into_iter().zip(levers.into_iter().zip([2.0, 1.0])))
        {
            let by_line = Matrix3::identity() * (force * length_m);
            of.fixed_view_mut::<3, 3>(0, 0).copy_from(&by_line);
            let by_lever = hat(&along) * (lever * sign * length_m * length_m);
            of.fixed_view_mut::<3, 3>(3, 0).copy_from(&(hat(&near.arm_m) * by_line + by_lever));
            of.fixed_view_mut::<3, 3>(3, 3).copy_from(&(Matrix3::identity() * (moment * length_m / 6.0)));
        }
        slopes[0].fixed_view_mut::<3, 3>(3, 6).copy_from(&-hat(&force_n));
        Share { sections, slopes }
    }

    /// Share of a section in [`spread_over_cells`].
    fn share_of_cell(&self, section: usize, width_m: f64) -> Share {
        let cut = &self.cuts[section];
        let mut own = SMatrix::<f64, 6, SPREAD>::zeros();
        own.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * width_m));
        own.fixed_view_mut::<3, 3>(3, 0).copy_from(&(hat(&cut.arm_m) * width_m));
        own.fixed_view_mut::<3, 3>(3, 3).copy_from(&(Matrix3::identity() * width_m));
        own.fixed_view_mut::<3, 3>(3, 6).copy_from(&-hat(&(cut.line_n_m * width_m)));
        Share { sections: [section; 2], slopes: [own, SMatrix::zeros()] }
    }
}

/// Distributes constant line loads in cells about the sections, eq. (B26).
fn spread_over_cells(cuts: &[Cut], places_m: &[f64], length_m: f64, loads: &mut [Wrench], disc: &mut Disc) {
    for (index, (cut, load)) in cuts.iter().zip(loads).enumerate() {
        let width_m = cell_m(index, places_m, length_m);
        disc.put(cut, &(cut.line_n_m * width_m), &(cut.moment_n * width_m), load);
    }
}

/// Width in m of the cell of a section.
fn cell_m(index: usize, places_m: &[f64], length_m: f64) -> f64 {
    let half_way_m = |inner: usize| 0.5 * (places_m[inner] + places_m[inner + 1]);
    let begin_m = if index == 0 { 0.0 } else { half_way_m(index - 1) };
    let end_m = if index == places_m.len() - 1 { length_m } else { half_way_m(index) };
    end_m - begin_m
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
