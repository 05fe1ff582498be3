//! Vortex lattice and wake at chosen times of a run, as JSON.

use foldwing_engine::plant::{Plant, SurfaceLattice};
use nalgebra::Vector3;
use serde_json::{Value, json};
use std::io::{self, Write};

/// Round-off of communication points against the times asked for, in s.
const ROUND_OFF_S: f64 = 1e-9;

/// Lattices taken so far, and the times to come.
pub struct LatticeRecord {
    /// Times still to come in s, descending.
    times_s: Vec<f64>,
    taken: Vec<Value>,
}

impl LatticeRecord {
    /// Takes the lattice at the first communication point at or after each time.
    pub fn new(mut times_s: Vec<f64>) -> Self {
        times_s.sort_by(|a, b| b.total_cmp(a));
        Self { times_s, taken: Vec::new() }
    }

    /// Takes the plant's present lattice where a time asked for has come.
    pub fn include(&mut self, plant: &Plant) {
        let due = |time_s: &f64| *time_s <= plant.time_s() + ROUND_OFF_S;
        if !self.times_s.last().is_some_and(due) {
            return;
        }
        while self.times_s.last().is_some_and(due) {
            self.times_s.pop();
        }
        if let Some((time_s, surfaces)) = plant.lattice() {
            let surfaces: Vec<Value> = surfaces.iter().map(|surface| describe(plant, surface)).collect();
            self.taken.push(json!({ "time_s": time_s, "surfaces": surfaces }));
        }
    }

    /// Writes what was taken.
    pub fn write(&self, mut sink: impl Write) -> io::Result<()> {
        serde_json::to_writer(&mut sink, &self.taken)?;
        writeln!(sink)?;
        sink.flush()
    }
}

/// One surface with the name of its body.
fn describe(plant: &Plant, surface: &SurfaceLattice) -> Value {
    let rows = |rows: &[Vec<Vector3<f64>>]| -> Vec<Vec<[f64; 3]>> {
        rows.iter().map(|row| row.iter().map(|point| (*point).into()).collect()).collect()
    };
    json!({
        "body": plant.machine().bodies[surface.body].name,
        "corner_m": rows(&surface.corner_m),
        "circulation_m2_s": surface.circulation_m2_s,
        "wake_node_m": rows(&surface.wake_node_m),
        "wake_circulation_m2_s": surface.wake_circulation_m2_s,
    })
}
