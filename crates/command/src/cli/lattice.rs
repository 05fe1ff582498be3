//! Vortex lattice and wake at chosen times of a run, as JSON.

use foldwing_engine::plant::{Plant, SurfaceLattice};
use nalgebra::Vector3;
use serde_json::{Value, json};
use std::io::{self, Write};

/// Tolerance in s of the comparison of communication points with the requested times.
const ROUND_OFF_S: f64 = 1e-9;

/// Recorded lattices, and the times not yet reached.
pub struct LatticeRecord {
    /// Times in s not yet reached, descending.
    times_s: Vec<f64>,
    taken: Vec<Value>,
}

impl LatticeRecord {
    /// Records the lattice at the first communication point at or after each time.
    pub fn new(mut times_s: Vec<f64>) -> Self {
        times_s.sort_by(|a, b| b.total_cmp(a));
        Self { times_s, taken: Vec::new() }
    }

    /// Records the plant's current lattice if a requested time has been reached.
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

    /// Writes the recorded lattices.
    pub fn write(&self, mut sink: impl Write) -> io::Result<()> {
        serde_json::to_writer(&mut sink, &self.taken)?;
        writeln!(sink)?;
        sink.flush()
    }
}

/// Describes the lattice of one surface, with the name of its body.
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
