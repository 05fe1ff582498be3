//! Lifting surfaces close to each other: warnings of `foldwing check`, and errors that stop a run.

pub use crate::aero::near_sheets::CLOSED_PANELS;

use crate::aero::flow::Flow;
use crate::aero::near_sheets::NoCirculation;
use crate::aero::{AirModel, AirModels};
use crate::load::SectionMotion;
use crate::machine::{self, Machine};
use crate::solve::EquationsOfMotion;
use crate::system::PlantError;
use crate::system::System;

/// Two lattices that lie close above each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceGap {
    /// Indices into the model's bodies.
    pub bodies: [usize; 2],
    /// Smallest distance of a control point of one lattice from the sheet of the other, divided by the local panel size.
    pub least_panels: f64,
    /// Largest such distance among those of up to about one panel.
    pub widest_panels: f64,
    /// Whether the gap between the sheets is too small for the lattice to resolve, which is an error at the start of a run.
    pub closed: bool,
}

/// Converts an error of the aerodynamic model to an error that names the bodies.
pub(crate) fn failure(machine: &Machine, air: &machine::Air, time_s: f64, failure: NoCirculation) -> PlantError {
    match failure {
        NoCirculation::Singular(_) => PlantError::Air { time_s, cause: failure.to_string() },
        NoCirculation::Sonic(sonic) => {
            let body = &machine.bodies[air.surfaces[sonic.surface].body].name;
            let cause = format!(
                "strip {} of body {body} has a relative flow of Mach {:.3}; the Prandtl-Glauert correction \
                 (speed_of_sound_m_s) is valid only below Mach 1, before shocks form; reduce the speed",
                sonic.strip + 1,
                sonic.mach
            );
            PlantError::Surroundings { time_s, cause }
        }
        NoCirculation::BelowGround(surface) => {
            let body = &machine.bodies[air.surfaces[surface].body].name;
            let cause = format!(
                "the surface of body {body} reaches below the ground; raise the wing or increase ground_distance_m"
            );
            PlantError::Surroundings { time_s, cause }
        }
        NoCirculation::Profile(surface) => {
            let body = &machine.bodies[air.surfaces[surface].body].name;
            let cause = format!(
                "no circulation satisfies the polars of all strips of body {body}; beyond stall there may be several \
                 solutions or none: use fewer strips, a polar that falls less steeply, or model = \"strip\""
            );
            PlantError::Surroundings { time_s, cause }
        }
        NoCirculation::Closed(closed) => PlantError::ClosedSheets {
            time_s,
            bodies: closed.surfaces.map(|surface| machine.bodies[air.surfaces[surface].body].name.clone()),
            gap_m: closed.gap_m,
            gap_panels: closed.gap_panels,
        },
        NoCirculation::Overlapping(crossed) => {
            let mut bodies = crossed.surfaces.map(|surface| machine.bodies[air.surfaces[surface].body].name.clone());
            if crossed.surfaces[0] == crossed.surfaces[1] {
                bodies[1] = "its image in the mirror plane".to_owned();
            }
            PlantError::OverlappingSheets { time_s, bodies, depth_m: crossed.depth_m }
        }
    }
}

/// Error if the sheet of one lattice passes through another.
pub(crate) fn crossing(machine: &Machine, air: &machine::Air, model: &AirModels, time_s: f64) -> Option<PlantError> {
    let Some(AirModel::Lattice(lattice)) = model.only() else { return None };
    lattice.crossed_sheets().map(|crossed| PlantError::CrossedSheets {
        time_s,
        bodies: crossed.surfaces.map(|surface| machine.bodies[air.surfaces[surface].body].name.clone()),
        depth_m: crossed.depth_m,
    })
}

/// Index of the first surface whose flow comes mainly from its trailing edge.
pub(crate) fn blown_from_behind(air: &machine::Air, motions: &[SectionMotion], flow: &Flow) -> Option<usize> {
    let mut first = 0;
    air.surfaces.iter().position(|surface| {
        let sections = &motions[first..first + surface.chords.len()];
        first += surface.chords.len();
        let from_behind = sections.iter().zip(&surface.chords).filter(|(motion, chord)| {
            let backwards = motion.rotation * (chord.trailing_m - chord.leading_m);
            (flow.velocity_m_s(&motion.position_m) - motion.velocity_m_s).dot(&backwards) < 0.0
        });
        2 * from_behind.count() > surface.chords.len()
    })
}

impl System {
    /// Pairs of lattices that lie above each other within about one panel in the unstrained start pose; empty without a lattice. Leaves the
    /// plant in this pose, so that it must be initialised afterwards.
    pub fn surface_gaps(&mut self) -> Vec<SurfaceGap> {
        if self.air.is_none() {
            return Vec::new();
        }
        self.start(0.0);
        let now = &mut self.state.now;
        self.equations.prescribe(0.0, &mut now.q, &mut now.v, &mut now.a);
        self.equations.residual(0.0, &now.q, &now.v, &now.a, &mut self.scratch[0]);
        let Some(air) = &mut self.air else { return Vec::new() };
        air.observe(&self.equations, &self.state.now);
        let Some(AirModel::Lattice(lattice)) = air.model.only_mut() else { return Vec::new() };
        let (mut state, mut pairs) = (lattice.blank_state(), Vec::new());
        lattice.measure_gaps(&air.motions, &mut state);
        for other in 0..air.settings.surfaces.len() {
            for own in 0..other {
                let (one, two) = (lattice.gap(own, other), lattice.gap(other, own));
                let least_panels = one.panels[0].min(two.panels[0]);
                if least_panels < 1.0 {
                    pairs.push(SurfaceGap {
                        bodies: [own, other].map(|surface| air.settings.surfaces[surface].body),
                        least_panels,
                        widest_panels: one.panels[1].max(two.panels[1]),
                        closed: one.is_closed() || two.is_closed(),
                    });
                }
            }
        }
        pairs
    }
}
