//! Outlines in the data of a page: aerofoils, and nacelle and hub of a turbine.

use serde::Deserialize;

/// Heights of an aerofoil over its chord line, relative to the chord, at positions along it and at every edge of the strips.
#[derive(Debug, Deserialize)]
pub(super) struct Aerofoil {
    pub stations: Vec<f64>,
    pub upper: Vec<Vec<f64>>,
    pub lower: Vec<Vec<f64>>,
    #[serde(rename = "hidesSpar")]
    pub hides_spar: bool,
}

/// Nacelle or hub: rings of points in the frame of its body.
#[derive(Debug, Deserialize)]
pub(super) struct Solid {
    pub body: usize,
    pub rings: Vec<Vec<[f64; 3]>>,
    pub round: bool,
}

impl Aerofoil {
    /// Returns whether there are heights at all positions for a number of edges.
    pub fn fits(&self, columns: usize) -> bool {
        let side = |heights: &Vec<Vec<f64>>| {
            heights.len() == columns && heights.iter().all(|edge| edge.len() == self.stations.len())
        };
        self.stations.len() > 1 && side(&self.upper) && side(&self.lower)
    }
}

impl Solid {
    /// Returns whether the rings form a surface on one of a number of bodies.
    pub fn is_on_one_of(&self, bodies: usize) -> bool {
        let around = self.rings.first().map_or(0, Vec::len);
        self.body < bodies && around > 2 && self.rings.iter().all(|ring| ring.len() == around)
    }
}
