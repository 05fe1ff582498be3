//! Current lattice and wake, for reports; not used in the time step.

use crate::aero::{AirModel, AirState};
use crate::system::System;
use nalgebra::Vector3;

/// Lattice and wake of one surface, root frame.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceLattice {
    /// Index into the model's bodies.
    pub body: usize,
    /// Corners of the bound rings in m: rows from the leading edge, columns from the inner section; the last row but one is the trailing
    /// edge, the last one the start of the wake.
    pub corner_m: Vec<Vec<Vector3<f64>>>,
    /// Circulation of the strips at the trailing edge in m²/s, about the span from the inner to the outer end.
    pub circulation_m2_s: Vec<f64>,
    /// Normal force of the panels in N, positive along chord times span: steady part and rate of the impulse, without the corrections of
    /// profiles; rows from the leading edge. Empty if the last step solved is another, as after a state is restored.
    pub panel_force_n: Vec<Vec<f64>>,
    /// Nodes of the wake in m: rows from the trailing edge, columns from the inner section; a single row before the first shedding.
    pub wake_node_m: Vec<Vec<Vector3<f64>>>,
    /// Circulation of the wake's rings in m²/s: rows from the trailing edge.
    pub wake_circulation_m2_s: Vec<Vec<f64>>,
}

impl System {
    /// Force in N of the air at the edges of the strips, surface by surface, root frame, at the current time, as it acts on the structure.
    /// Their sum is the total force of the air on the surfaces. Empty without aerodynamics.
    pub fn surface_forces_n(&self) -> Vec<Vec<Vector3<f64>>> {
        let Some(air) = &self.air else { return Vec::new() };
        let mut loads = air.section_forces_n(&self.equations).into_iter();
        air.settings.surfaces.iter().map(|surface| loads.by_ref().take(surface.positions_m.len()).collect()).collect()
    }

    /// End time in s of the aerodynamic step that contains the current time, with the vortex lattice at that time, surface by surface;
    /// `None` without a lattice or before initialisation.
    pub fn lattice(&self) -> Option<(f64, Vec<SurfaceLattice>)> {
        let (air, history) = (self.air.as_ref()?, self.state.air.as_ref()?);
        let (Some(AirModel::Lattice(lattice)), Some(AirState::Lattice(state))) =
            (air.model.only(), history.after.only())
        else {
            return None;
        };
        let view = |(index, surface): (usize, &crate::machine::LiftingSurface)| {
            let columns = surface.positions_m.len();
            SurfaceLattice {
                body: surface.body,
                corner_m: (0..=surface.chord_panels + 1)
                    .map(|row| (0..columns).map(|column| lattice.corner_m(state, index, row, column)).collect())
                    .collect(),
                circulation_m2_s: (0..columns - 1)
                    .map(|strip| lattice.strip_circulation(state, index, strip))
                    .collect(),
                panel_force_n: (0..surface.chord_panels)
                    .map_while(|row| {
                        (0..columns - 1).map(|strip| lattice.panel_force_n(state, index, row, strip)).collect()
                    })
                    .collect(),
                wake_node_m: (0..=state.wake_rows)
                    .map(|row| (0..columns).map(|column| lattice.wake_node_m(state, index, row, column)).collect())
                    .collect(),
                wake_circulation_m2_s: (0..state.wake_rows)
                    .map(|row| {
                        let ring = |strip| lattice.wake_circulation_m2_s(state, index, row, strip);
                        (0..columns - 1).map(ring).collect()
                    })
                    .collect(),
            }
        };
        let surfaces = air.settings.surfaces.iter().enumerate().map(view).collect();
        Some((history.loads.end_s, surfaces))
    }

    /// Bodies with lattice strips beyond stall, where the lift is below the maximum reached at a lower angle of attack, and the number of
    /// these strips; neighbouring strips may then have several steady circulations, NOTATION eq. (U32). From the last aerodynamic solution.
    pub fn strips_beyond_stall(&self) -> Vec<(usize, usize)> {
        let (Some(air), Some(history)) = (&self.air, &self.state.air) else { return Vec::new() };
        let (Some(AirModel::Lattice(lattice)), Some(AirState::Lattice(state))) =
            (air.model.only(), history.after.only())
        else {
            return Vec::new();
        };
        let mut list: Vec<(usize, usize)> = Vec::new();
        for surface in lattice.surfaces_beyond_stall(state) {
            let body = air.settings.surfaces[surface].body;
            match list.last_mut().filter(|(last, _)| *last == body) {
                Some((_, count)) => *count += 1,
                None => list.push((body, 1)),
            }
        }
        list
    }
}
