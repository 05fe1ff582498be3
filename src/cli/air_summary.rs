//! Air in the summary of `foldwing check`.

use foldwing::config::Machine;
use foldwing::config::machine::{AirOptions, Coupling, LoadRule, WakeModel};
use serde::Serialize;
use std::fmt::Write;

/// Air of a model in numbers.
#[derive(Serialize)]
pub struct AirSummary {
    model: String,
    density_kg_m3: f64,
    wind_m_s: [f64; 3],
    step_s: f64,
    coupling: &'static str,
    surfaces: Vec<SurfaceSummary>,
    gusts: Vec<String>,
}

#[derive(Serialize)]
struct SurfaceSummary {
    body: String,
    strips: usize,
    chord_panels: usize,
    area_m2: f64,
    from_m: f64,
    to_m: f64,
}

impl AirSummary {
    /// Of a machine in air.
    pub fn new(machine: &Machine) -> Option<Self> {
        let air = machine.air.as_ref()?;
        let surface = |surface: &foldwing::config::machine::LiftingSurface| {
            let strips = surface.positions_m.windows(2).zip(surface.chords.windows(2));
            SurfaceSummary {
                body: machine.bodies[surface.body].name.clone(),
                strips: surface.positions_m.len() - 1,
                chord_panels: surface.chord_panels,
                area_m2: strips
                    .map(|(edge, chord)| 0.5 * (edge[1] - edge[0]) * (chord[0].length_m() + chord[1].length_m()))
                    .sum(),
                from_m: surface.positions_m[0],
                to_m: surface.positions_m[surface.positions_m.len() - 1],
            }
        };
        Some(Self {
            model: describe(&air.options),
            density_kg_m3: air.density_kg_m3,
            wind_m_s: air.wind_m_s.into(),
            step_s: air.step_s,
            coupling: match air.coupling {
                Coupling::Staggered => "staggered",
                Coupling::Iterated { .. } => "iterated",
            },
            surfaces: air.surfaces.iter().map(surface).collect(),
            gusts: air.gusts.iter().map(|gust| gust.name.clone()).collect(),
        })
    }

    /// For people.
    pub fn text(&self) -> String {
        let [x, y, z] = self.wind_m_s;
        let mut text = format!(
            "\nair\n  {}, {} kg/m3, wind ({x}, {y}, {z}) m/s, {} at steps of {:.6} s\n",
            self.model, self.density_kg_m3, self.coupling, self.step_s
        );
        for surface in &self.surfaces {
            let _ = writeln!(
                text,
                "  on {}: {} strips from {:.4} to {:.4} m, {} panels along the chord, {:.6} m2",
                surface.body, surface.strips, surface.from_m, surface.to_m, surface.chord_panels, surface.area_m2
            );
        }
        if !self.gusts.is_empty() {
            let _ = writeln!(text, "  gusts: {}", self.gusts.join(", "));
        }
        text
    }
}

/// The model of the air in words.
fn describe(options: &AirOptions) -> String {
    match options {
        AirOptions::Lattice(lattice) => {
            let wake = match lattice.wake {
                WakeModel::Prescribed => "prescribed",
                WakeModel::Free => "free",
            };
            let loads = match lattice.load_rule {
                LoadRule::Bernoulli => "Bernoulli",
                LoadRule::KuttaJoukowski => "Kutta-Joukowski",
            };
            let mirror = if lattice.mirror_normal.is_some() { ", mirror plane" } else { "" };
            format!("vortex lattice, {wake} wake of {} rows, {loads} loads{mirror}", lattice.wake_rows)
        }
        AirOptions::Strips(strips) => {
            let lag = if strips.unsteady { "unsteady" } else { "quasi-steady" };
            let mass = if strips.apparent_mass { "" } else { ", no apparent mass" };
            format!("{lag} strips{mass}")
        }
    }
}
