//! Aerodynamics in the summary of `foldwing check`.

use foldwing_engine::machine::Machine;
use foldwing_engine::machine::{Air, AirOptions, Coupling, LoadRule, Parent, PitchRate, WakeModel};
use foldwing_engine::plant::{CLOSED_PANELS, SurfaceGap};
use serde::Serialize;
use std::fmt::Write;

/// Aerodynamic data of a model.
#[derive(Serialize)]
pub struct AirSummary {
    model: String,
    density_kg_m3: f64,
    wind_m_s: [f64; 3],
    step_s: f64,
    coupling: &'static str,
    surfaces: Vec<SurfaceSummary>,
    gaps: Vec<GapSummary>,
    gusts: Vec<String>,
}

/// Pair of lattices that overlap at the start.
#[derive(Serialize)]
struct GapSummary {
    bodies: [String; 2],
    angle_deg: Option<f64>,
    least_panels: f64,
    widest_panels: f64,
    closed: bool,
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
    /// Returns the summary of a model with aerodynamics, with the pairs of surfaces that are close to each other.
    pub fn new(machine: &Machine, gaps: &[SurfaceGap]) -> Option<Self> {
        let air = machine.air.as_ref()?;
        let surface = |surface: &foldwing_engine::machine::LiftingSurface| {
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
            model: describe_all(air),
            density_kg_m3: air.density_kg_m3,
            wind_m_s: air.wind_m_s.into(),
            step_s: air.step_s,
            coupling: match air.coupling {
                Coupling::Staggered => "staggered",
                Coupling::Iterated { .. } => "iterated",
            },
            surfaces: air.surfaces.iter().map(surface).collect(),
            gaps: gaps.iter().map(|gap| GapSummary::new(machine, gap)).collect(),
            gusts: air.gusts.iter().map(|gust| gust.name.clone()).collect(),
        })
    }

    /// Returns the summary as text.
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
        for gap in &self.gaps {
            let _ = writeln!(text, "  {}", gap.text());
        }
        if !self.gusts.is_empty() {
            let _ = writeln!(text, "  gusts: {}", self.gusts.join(", "));
        }
        text
    }
}

impl GapSummary {
    fn new(machine: &Machine, gap: &SurfaceGap) -> Self {
        let joins = |child: usize, parent: usize| {
            let joint = &machine.bodies[child].joint;
            let hangs = matches!(joint.parent, Parent::Body { index, .. } if index == parent);
            let (_, own) = joint.kind.one_freedom().filter(|_| hangs && !joint.kind.slides())?;
            Some(own.start_angle_rad.to_degrees())
        };
        let [one, two] = gap.bodies;
        Self {
            bodies: gap.bodies.map(|body| machine.bodies[body].name.clone()),
            angle_deg: joins(two, one).or_else(|| joins(one, two)),
            least_panels: gap.least_panels,
            widest_panels: gap.widest_panels,
            closed: gap.closed,
        }
    }

    fn text(&self) -> String {
        let [one, two] = &self.bodies;
        let angle = self.angle_deg.map_or(String::new(), |angle| format!(" at {angle:.6} deg"));
        let verdict = if self.closed {
            format!(
                "a simulation is not possible; open the joint until the largest gap is {CLOSED_PANELS} panels, or use more strips"
            )
        } else {
            "each induces velocities at the control points of the other".to_owned()
        };
        format!(
            "{one} and {two} overlap{angle}, {:.3} to {:.3} panels apart: {verdict}",
            self.least_panels, self.widest_panels
        )
    }
}

/// Describes the aerodynamic models.
fn describe_all(air: &Air) -> String {
    let each = air.parts.iter().map(|part| match part.name.as_str() {
        "" => describe(&part.options),
        name => format!("{name}: {}", describe(&part.options)),
    });
    each.collect::<Vec<_>>().join("; ")
}

/// Describes an aerodynamic model.
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
        AirOptions::Rotor(rotor) => {
            let skew = if rotor.features.skewed_wake { ", skewed wake" } else { "" };
            let inflow = if rotor.features.dynamic_inflow { ", dynamic inflow" } else { "" };
            let stall = if rotor.features.dynamic_stall { ", dynamic stall" } else { "" };
            let induced = match rotor.features.inflow_lag_s {
                Some(lag_s) => format!("blade elements with an induced velocity that lags by {lag_s} s"),
                None => "blade element momentum".to_owned(),
            };
            let rate = match rotor.features.pitch_rate {
                PitchRate::None => "",
                PitchRate::Hub => ", pitch rate relative to the hub",
                PitchRate::Air => ", pitch rate relative to the air",
            };
            let like = rotor.features.blades.map_or(String::new(), |blades| format!(", {blades} identical blades"));
            format!("{induced}{like}{skew}{inflow}{rate}{stall}")
        }
        AirOptions::SlenderBody(body) => {
            let mass = if body.apparent_mass { "" } else { ", no apparent mass" };
            format!("slender body of {:.4} m3{mass}", body.volume_m3())
        }
        AirOptions::Strips(strips) => {
            let lag = if strips.unsteady { "unsteady" } else { "quasi-steady" };
            let mass = if strips.apparent_mass { "" } else { ", no apparent mass" };
            let line = match &strips.tip_loss {
                None => "",
                Some(line) if line.mirror_normal.is_some() => ", tip loss by a lifting line, mirror plane",
                Some(_) => ", tip loss by a lifting line",
            };
            format!("{lag} strips{mass}{line}")
        }
    }
}
