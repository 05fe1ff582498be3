//! Influence matrix of the lattice, its factors, and the resulting circulation.

use crate::aero::biot_savart::{LANES, blocks};
use crate::aero::flow::Flow;
use crate::aero::lattice::{Factors, VortexLattice};
use crate::aero::lattice_state::LatticeState;
use crate::aero::near_sheets::NoCirculation;
use crate::load::SectionMotion;

impl VortexLattice {
    /// Builds the influence matrix for the current geometry, and its factors if they are due. Does nothing for unchanged geometry.
    pub(super) fn influence(&mut self, state: &LatticeState, established: bool) -> Result<(), NoCirculation> {
        let is_factored =
            !established && self.factored && self.factored_corner_m == state.corner_m && self.factors_have_angles();
        if !is_factored {
            let is_built = self.built && self.matrix_corner_m == state.corner_m && self.matrix_has_angles();
            if established || !is_built {
                self.build(state, established)?;
            }
            if self.factors != Factors::Kept {
                self.factorize()?;
            }
        }
        if self.factors == Factors::Due {
            self.factors = Factors::Kept;
        }
        Ok(())
    }

    /// Factorises the influence matrix.
    fn factorize(&mut self) -> Result<(), NoCirculation> {
        self.factored = false;
        self.profiles.has_gains = false;
        self.system.factorize(self.arch)?;
        self.factored_corner_m.copy_from_slice(&self.matrix_corner_m);
        self.factored_stretch = self.matrix_stretch;
        self.factored_angle_rad.copy_from_slice(&self.matrix_angle_rad);
        self.factored = true;
        Ok(())
    }

    /// Builds the influence matrix.
    fn build(&mut self, state: &LatticeState, established: bool) -> Result<(), NoCirculation> {
        self.built = false;
        if let Some(closed) = self.closed_sheets() {
            return Err(NoCirculation::Closed(closed));
        }
        if let Some(crossed) = self.crossed_edges {
            return Err(NoCirculation::Overlapping(crossed));
        }
        let (panels, rows) = (self.right.len(), blocks(self.right.len()) * LANES);
        let (kernel, bound, inducing) = (self.kernel, &self.bound, &self.inducing);
        let (points, normals, firsts, arms) = (&self.points, &self.normals, &self.first_panel, &mut self.arms[0]);
        let matrix = self.system.cleared();
        for (block, (points, normals)) in points.iter().zip(normals).enumerate().take(rows / LANES) {
            let place = (rows, block * LANES);
            for ((sheet, whole), first) in bound.iter().zip(inducing).zip(firsts) {
                let (corners, strips) = (&state.corner_m, sheet.strips);
                let of = |row: usize| first + row.min(sheet.rows - 1) * strips;
                kernel.influence(whole, corners, points, normals, arms, matrix, place, of);
            }
        }
        debug_assert!(panels <= rows);
        self.see_influence(state, established);
        if established {
            self.add_established_wake(state);
        }
        self.built = !established;
        self.matrix_corner_m.copy_from_slice(&state.corner_m);
        self.keep_matrix_angles();
        Ok(())
    }

    /// Adds the influence of the rings of an established wake to that of the rings in front of them, whose circulation they have.
    fn add_established_wake(&mut self, state: &LatticeState) {
        let rows = blocks(self.right.len()) * LANES;
        let kernel = self.kernel;
        let (points, normals, arms) = (&self.points, &self.normals, &mut self.arms[0]);
        let sheets = self.bound.iter().zip(&self.wake).zip(&self.first_panel);
        let matrix = self.system.entries_mut();
        for ((sheet, wake), first) in sheets {
            let of = |_: usize| first + (sheet.rows - 1) * sheet.strips;
            for (block, (points, normals)) in points.iter().zip(normals).enumerate().take(rows / LANES) {
                let place = (rows, block * LANES);
                kernel.influence(wake, &state.wake_node_m, points, normals, arms, matrix, place, of);
            }
        }
    }

    /// Computes the circulation for which the normal velocity at the collocation points vanishes, eq. (U4), apart from the velocities of
    /// the profiles.
    pub(super) fn circulate(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        state: &mut LatticeState,
    ) -> Result<(), NoCirculation> {
        let mut panel = 0;
        for sheet in &self.bound {
            for row in 0..sheet.rows {
                for strip in 0..sheet.strips {
                    let normal = self.normals[panel / LANES].get(panel % LANES);
                    self.right[panel] = -self.relative_m_s[sheet.ring(row, strip)].dot(&normal);
                    panel += 1;
                }
            }
        }
        match self.profiles.count() {
            0 => self.solve_right(state)?,
            _ => self.circulate_profiles(motions, flow, state)?,
        }
        for ((sheet, inducing), first) in self.bound.iter().zip(&self.inducing).zip(&self.first_panel) {
            let panels = sheet.rows * sheet.strips;
            let rings_m2_s = &mut state.circulation_m2_s[sheet.first_ring..][..panels + sheet.strips];
            rings_m2_s[..panels].copy_from_slice(&self.solution[*first..][..panels]);
            rings_m2_s.copy_within(panels - sheet.strips..panels, panels);
            self.bound_filaments.gather(inducing, &state.circulation_m2_s);
        }
        Ok(())
    }

    /// Solves for the current right-hand side.
    pub(super) fn solve_right(&mut self, state: &LatticeState) -> Result<(), NoCirculation> {
        let own = self.factored_corner_m == state.corner_m && self.factors_have_angles();
        if own || !self.system.solve_with_factors_near_by(self.arch, &self.right, &mut self.solution) {
            if !own {
                self.factors = Factors::OfEach;
                self.factorize()?;
            }
            self.solution.copy_from_slice(&self.right);
            self.system.solve(self.arch, &mut self.solution);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aero::AirLoads;
    use crate::aero::flap::{Deflection, Flap};
    use crate::aero::lattice::LatticeOptions;
    use crate::aero::surface::{Profile, Surface};
    use crate::aero::test_lattices::{chord, flow, options, section};
    use nalgebra::Vector3;

    const STEP_S: f64 = 0.01;

    /// A wing of 3 m span and 1 m chord with a control surface over the outer half, in air with a speed of sound of 100 m/s.
    fn lattice() -> VortexLattice {
        let surface = Surface { sections: 0..5, chords: vec![chord(); 5], chord_panels: 4, profile: Profile::THIN };
        let options = LatticeOptions { speed_of_sound_m_s: Some(100.0), ..options() };
        let mut lattice = VortexLattice::new(vec![surface], options);
        lattice.add_flaps(&[Flap {
            name: "flap".to_owned(),
            surface: 0,
            strips: 2..4,
            hinge_fraction: 0.5,
            lower_rad: -1.0,
            upper_rad: 1.0,
            command_rad: 0.0,
            downward: 1.0,
        }]);
        lattice
    }

    /// The circulation of a step does not depend on matrices kept from earlier steps, for any change since: nothing, only the angle
    /// of a control surface, the speed and hence the stretching, or the attitude of the wing. A new lattice gives the same from the same
    /// state.
    #[test]
    fn kept_matrices_are_those_of_the_present() {
        let attitude = |pitch_rad: f64| [0.0, 0.8, 1.5, 2.3, 3.0].map(|x| section(Vector3::x() * x, pitch_rad));
        let flow = |speed_m_s: f64| flow(Vector3::new(0.0, -speed_m_s, 0.05 * speed_m_s));
        let deflection = |angle_rad: f64| [Deflection { angle_rad, rate_rad_s: 0.0 }];
        // sequence of speed in m/s, control surface angle and pitch in rad
        let course = [
            (40.0, 0.0, 0.0),
            (40.0, 0.0, 0.0),
            (40.0, 0.5, 0.0),
            (40.0, -0.4, 0.0),
            (70.0, -0.4, 0.0),
            (30.0, -0.4, 0.0),
            (30.0, -0.4, 0.3),
            (30.0, 0.5, 0.3),
            (30.0, 0.5, 0.3),
        ];
        let mut kept = lattice();
        let (mut state, mut next) = (kept.blank_state(), kept.blank_state());
        let mut loads = AirLoads::still(5);
        kept.start(&attitude(0.0), &flow(40.0), None, &mut state, &mut loads).unwrap();
        for (step, (speed_m_s, flap_rad, pitch_rad)) in course.into_iter().enumerate() {
            let (flow, motions) = (flow(speed_m_s), attitude(pitch_rad));
            let solved = |lattice: &mut VortexLattice, next: &mut LatticeState, loads: &mut AirLoads| {
                lattice.deflect(&deflection(flap_rad));
                lattice.convect(&state, &flow, STEP_S, next);
                lattice.solve(&state, &motions, &flow, STEP_S, next, loads).unwrap();
            };
            let mut fresh = lattice();
            let (mut expected, mut expected_loads) = (fresh.blank_state(), AirLoads::still(5));
            solved(&mut fresh, &mut expected, &mut expected_loads);
            solved(&mut kept, &mut next, &mut loads);
            let size = expected.circulation_m2_s.iter().fold(0.0_f64, |size, own| size.max(own.abs()));
            let pairs = next.circulation_m2_s.iter().zip(&expected.circulation_m2_s);
            let off = pairs.map(|(own, expected)| (own - expected).abs()).fold(0.0, f64::max);
            // factors of a nearby matrix give the solution to round-off times the condition number
            assert!(off < 1e-11 * size, "step {step}: {off:e} of {size}");
            let force_n = |loads: &AirLoads| loads.circulatory.iter().map(|load| load.force_n).sum::<Vector3<f64>>();
            let off_n = (force_n(&loads) - force_n(&expected_loads)).norm();
            assert!(off_n < 1e-11 * force_n(&expected_loads).norm(), "step {step}: {off_n:e} N");
            std::mem::swap(&mut state, &mut next);
        }
    }
}
