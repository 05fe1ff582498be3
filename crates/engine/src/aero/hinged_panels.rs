//! Panels of the lattice that belong to control surfaces, and the hinges of its strips.

use crate::aero::flap::{Deflection, Flap};
use nalgebra::Vector3;

/// Control surfaces of a lattice with their current deflections.
#[derive(Debug, Clone, Default)]
pub(super) struct LatticeFlaps {
    pub flaps: Vec<Flap>,
    pub deflections: Vec<Deflection>,
    /// Control surface of each panel, in the order of the equations; empty without control surfaces.
    pub of_panel: Vec<Option<usize>>,
    /// Hinge lines: a point in m and a unit vector from the inner to the outer section. One for each strip of the lattice; empty without
    /// control surfaces.
    pub lines: Vec<HingeLine>,
    /// Index of the first strip of each surface among all strips.
    pub first_strip: Vec<usize>,
}

/// Hinge of a strip, root frame.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct HingeLine {
    /// Midpoint of the hinge in m.
    pub middle_m: Vector3<f64>,
    /// Unit vector of the axis about which positive angles rotate.
    pub axis: Vector3<f64>,
}

impl LatticeFlaps {
    /// Deflections, on which the influence matrix depends.
    pub fn deflections(&self) -> &[Deflection] {
        &self.deflections
    }

    /// Index of the control surface of a panel, numbered as in the equations.
    pub fn of_panel(&self, panel: usize) -> Option<usize> {
        self.of_panel.get(panel).copied().flatten()
    }

    /// Index of the control surface of a strip of a surface at a row of panels.
    pub fn of_strip(&self, surface: usize, row: usize, strip: usize, chord_panels: usize) -> Option<usize> {
        let has = |flap: &Flap| {
            flap.surface == surface && flap.strips.contains(&strip) && row >= hinge_row(flap, chord_panels)
        };
        self.flaps.iter().position(has)
    }

    /// Moment in N·m of a force about the hinge of a strip, positive in the direction of positive angles.
    pub fn moment_n_m(&self, surface: usize, strip: usize, point_m: &Vector3<f64>, force_n: &Vector3<f64>) -> f64 {
        let line = &self.lines[self.first_strip[surface] + strip];
        line.axis.dot(&(point_m - line.middle_m).cross(force_n))
    }
}

/// First row of panels of a control surface.
pub(super) fn hinge_row(flap: &Flap, chord_panels: usize) -> usize {
    (flap.hinge_fraction * chord_panels as f64).round() as usize
}
