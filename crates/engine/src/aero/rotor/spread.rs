//! Loads of the blades' sections on the structure, and those of the rotor.

use crate::aero::AirLoads;
use crate::aero::rotor::bem::{Cut, Disc, Rotor};
use crate::aero::rotor::options::Spread;
use crate::load::Wrench;
use nalgebra::Vector3;

impl Rotor {
    /// Puts the line loads on the sections and sums thrust and torque, those of like blades included.
    pub(super) fn spread(&self, loads: &mut AirLoads, disc: &mut Disc) {
        for (blade, range) in self.blades.iter().enumerate() {
            let (cuts, loads) = (&self.cuts[range.clone()], &mut loads.circulatory[range.clone()]);
            let places_m = &self.options.positions_m[blade];
            match self.options.features.spread {
                Spread::Linear => spread_in_lines(cuts, places_m, loads, disc),
                Spread::Cells => spread_over_cells(cuts, places_m, self.options.lengths_m[blade], loads, disc),
            }
        }
        disc.loads.thrust_n *= self.like;
        disc.loads.torque_n_m *= self.like;
        disc.loads.power_w = disc.loads.torque_n_m * disc.loads.speed_rad_s;
    }
}

/// Straight lines between the sections, eq. (B8).
fn spread_in_lines(cuts: &[Cut], places_m: &[f64], loads: &mut [Wrench], disc: &mut Disc) {
    for (inner, places_m) in places_m.windows(2).enumerate() {
        let ends = [inner, inner + 1];
        let length_m = places_m[1] - places_m[0];
        let way = cuts[ends[1]].from_apex_m - cuts[ends[0]].from_apex_m;
        let along = way.try_normalize(1e-9).unwrap_or_else(Vector3::zeros);
        for (own, other, sign) in [(ends[0], ends[1], 1.0), (ends[1], ends[0], -1.0)] {
            let (near, far) = (&cuts[own], &cuts[other]);
            let force_n = (near.line_n_m * 7.0 + far.line_n_m * 3.0) * (length_m / 20.0);
            let lever_n_m = (near.line_n_m * 3.0 + far.line_n_m * 2.0) * (sign * length_m * length_m / 60.0);
            let moment_n_m = (near.moment_n * 2.0 + far.moment_n) * (length_m / 6.0) + along.cross(&lever_n_m);
            disc.put(near, &force_n, &moment_n_m, &mut loads[own]);
        }
    }
}

/// Cells about the sections, eq. (B26).
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
    /// Adds a force in N at the quarter chord and a moment in N·m to the load of a section and to those of the rotor.
    fn put(&mut self, cut: &Cut, force_n: &Vector3<f64>, moment_n_m: &Vector3<f64>, load: &mut Wrench) {
        load.add_force_at(&cut.arm_m, force_n);
        load.moment_n_m += moment_n_m;
        self.loads.thrust_n += force_n.dot(&self.normal);
        let about_apex_n_m = cut.from_apex_m.cross(force_n) + moment_n_m;
        self.loads.torque_n_m += self.turn * about_apex_n_m.dot(&self.normal);
    }
}
