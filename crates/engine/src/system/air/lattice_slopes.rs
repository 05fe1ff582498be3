//! The linear vortex lattice of a model: its derivatives at the current pose, and the names of its states.

use crate::aero::flow::Flow;
use crate::aero::lattice_linear::{LatticeSlopes, NoLinearLattice};
use crate::aero::{AirModel, AirOptions, AirState};
use crate::load::SectionMotion;
use crate::machine;
use crate::system::air::gaps;
use crate::system::air::start::flow;
use crate::system::{PlantError, System};
use nalgebra::Vector3;

/// Name of a gust that acts on some surface.
fn over<'a>(air: &'a machine::Air, motions: &[SectionMotion], flow: &Flow) -> Option<&'a str> {
    let chords = air.surfaces.iter().flat_map(|surface| &surface.chords);
    let edges = motions.iter().zip(chords).flat_map(|(motion, chord)| {
        [chord.leading_m, chord.trailing_m].map(|place_m| motion.position_m + motion.rotation * place_m)
    });
    let edges: Vec<Vector3<f64>> = edges.collect();
    air.gusts.iter().find(|gust| gust.is_between(flow.time_s, &edges)).map(|gust| gust.name.as_str())
}

impl System {
    /// Whether the aerodynamic model is a lattice, which has a linear model in discrete time.
    pub fn has_linear_lattice(&self) -> bool {
        self.air.as_ref().is_some_and(|air| matches!(air.settings.only(), Some(AirOptions::Lattice(_))))
    }

    /// Derivatives of the lattice about the steady flow around sections without motion; `None` without a lattice.
    ///
    /// # Errors
    /// If the lattice has no steady flow with a straight wake.
    pub(crate) fn lattice_slopes(
        &mut self,
        motions: &[SectionMotion],
        gusts: bool,
    ) -> Result<Option<LatticeSlopes>, PlantError> {
        let time_s = self.state.now.time_s;
        let Some(air) = self.air.as_mut() else { return Ok(None) };
        air.deflect(&self.state, time_s)?;
        let Some(AirModel::Lattice(lattice)) = air.model.only_mut() else { return Ok(None) };
        let settings = &air.settings;
        let flow = flow(settings, &self.state, time_s);
        if let Some(gust) = over(settings, motions, &flow) {
            let cause = format!(
                "gust {gust:?} acts on the surfaces at this time and would be part of the steady flow; delay it \
                 (origin_m, start_s), or remove [gust.{gust}]"
            );
            return Err(PlantError::Linearization { time_s, cause });
        }
        let blank = lattice.blank_state();
        let from = match self.state.air.as_ref().and_then(|history| history.after.only()) {
            Some(AirState::Lattice(state)) => state,
            Some(AirState::Strips(_) | AirState::Rotor(_) | AirState::SlenderBody(_)) | None => &blank,
        };
        let slopes = lattice.linear(motions, &flow, settings.step_s, gusts, from).map_err(|error| match error {
            NoLinearLattice::Flow(error) => gaps::failure(&self.machine, settings, time_s, error),
            error @ (NoLinearLattice::FreeWake
            | NoLinearLattice::NoWake
            | NoLinearLattice::Turning(_)
            | NoLinearLattice::Stalled
            | NoLinearLattice::Slow { .. }) => {
                let cause = format!("the lattice has no linear model: {error}");
                PlantError::Linearization { time_s, cause }
            }
        });
        // the current angles of the control surfaces
        air.model.deflect(&air.deflections);
        slopes.map(Some)
    }

    /// Number of circulations of the lattice and its wake; 0 without a lattice.
    pub(crate) fn lattice_circulations(&self) -> usize {
        let Some(air) = &self.air else { return 0 };
        let Some(AirOptions::Lattice(options)) = air.settings.only() else { return 0 };
        let strips = |surface: &machine::LiftingSurface| surface.positions_m.len() - 1;
        air.settings.surfaces.iter().map(|surface| strips(surface) * (surface.chord_panels + options.wake_rows)).sum()
    }

    /// Aerodynamic step in s; `None` without aerodynamics.
    pub fn air_step_s(&self) -> Option<f64> {
        self.air.as_ref().map(|air| air.settings.step_s)
    }

    /// Names of all panels of the lattice, `wing.panel[row][strip]`, surface by surface and row by row from the leading edge, and names of
    /// its strips, `wing.strip[3]`.
    pub(crate) fn lattice_names(&self) -> [Vec<String>; 2] {
        let (mut panels, mut strips) = (Vec::new(), Vec::new());
        for surface in self.machine.air.iter().flat_map(|air| &air.surfaces) {
            let (name, own) = (&self.machine.bodies[surface.body].name, surface.positions_m.len() - 1);
            for row in 1..=surface.chord_panels {
                panels.extend((1..=own).map(|strip| format!("{name}.panel[{row}][{strip}]")));
            }
            strips.extend((1..=own).map(|strip| format!("{name}.strip[{strip}]")));
        }
        [panels, strips]
    }

    /// Names of the sections of the surfaces, `wing.section[3]`.
    pub(crate) fn section_names(&self) -> Vec<String> {
        let surfaces = self.machine.air.iter().flat_map(|air| &air.surfaces);
        let of = |surface: &crate::machine::LiftingSurface| {
            let name = self.machine.bodies[surface.body].name.clone();
            (1..=surface.positions_m.len()).map(move |section| format!("{name}.section[{section}]"))
        };
        surfaces.flat_map(of).collect()
    }
}
