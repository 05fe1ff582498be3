//! Effects on the lattice that apply everywhere: the ground plane and compressibility.

use crate::aero::flow::Flow;
use crate::aero::images::Stretch;
use crate::aero::lattice::VortexLattice;
use crate::aero::lattice_state::LatticeState;
use crate::aero::near_sheets::{NoCirculation, Sonic};
use crate::load::SectionMotion;
use nalgebra::Vector3;

/// Mean over the sections of the velocity of the undisturbed air, without gusts, relative to them, root frame, m/s.
pub(super) fn mean_relative_m_s(motions: &[SectionMotion], flow: &Flow) -> Vector3<f64> {
    let relative_m_s = |motion: &SectionMotion| flow.convection_m_s(&motion.position_m) - motion.velocity_m_s;
    motions.iter().map(relative_m_s).sum::<Vector3<f64>>() / motions.len().max(1) as f64
}

impl VortexLattice {
    /// Applies the Prandtl-Glauert stretching along the mean relative flow, eq. (U22).
    ///
    /// # Errors
    /// If a section reaches Mach 1.
    pub(super) fn compress(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        state: &LatticeState,
    ) -> Result<(), NoCirculation> {
        let Some(sound_m_s) = self.options.speed_of_sound_m_s else { return Ok(()) };
        for (at, surface) in self.surfaces.iter().enumerate() {
            for (column, motion) in motions[surface.sections.clone()].iter().enumerate() {
                let relative_m_s = flow.velocity_m_s(&motion.position_m) - motion.velocity_m_s;
                let mach = relative_m_s.norm() / sound_m_s;
                if mach >= 1.0 {
                    let strip = column.min(surface.strips() - 1);
                    return Err(NoCirculation::Sonic(Sonic { surface: at, strip, mach }));
                }
            }
        }
        self.stretch_along(&state.relative_m_s);
        Ok(())
    }

    /// Applies the stretching along a given relative velocity below Mach 1.
    pub(super) fn stretch_along(&mut self, relative_m_s: &Vector3<f64>) {
        let Some(sound_m_s) = self.options.speed_of_sound_m_s else { return };
        let speed_m_s = relative_m_s.norm();
        self.kernel.stretch = (speed_m_s > 0.0).then(|| Stretch {
            axis: relative_m_s / speed_m_s,
            excess: 1.0 / (1.0 - (speed_m_s / sound_m_s).powi(2)).sqrt() - 1.0,
        });
    }

    /// # Errors
    /// If a collocation point is below the ground.
    pub(super) fn above_ground(&self, state: &LatticeState) -> Result<(), NoCirculation> {
        let Some(ground) = &self.kernel.ground else { return Ok(()) };
        for (at, sheet) in self.bound.iter().enumerate() {
            let points_m = &state.collocation_m[sheet.first_ring..sheet.ring(sheet.rows, 0)];
            if points_m.iter().any(|point_m| ground.normal.dot(point_m) + ground.distance_m <= 0.0) {
                return Err(NoCirculation::BelowGround(at));
            }
        }
        Ok(())
    }
}
