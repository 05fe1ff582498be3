//! Goland's wing for the tests: the shipped model with every kind of aerodynamics, simulated in time.
//!
//! In wind along its chord the wing encounters a small short gust. Growth rate and frequency of the response come from the tip's heave by
//! the matrix pencil ([`crate::coupling::identification`]); at the flutter speed the growth rate vanishes.

use crate::coupling::identification::{Oscillation, least_damped};
use crate::coupling::wings::start;
use foldwing::config;
use foldwing::machine::Machine;
use serde_json::Value;

/// Samples before this time are not used: the gust has passed after 40 ms, higher modes have decayed.
const FROM_S: f64 = 0.1;
/// Sampling interval in s: 22 samples per period of the flutter.
const INTERVAL_S: f64 = 4e-3;
/// Frequency range in rad/s in which flutter is sought; bending and torsion in a vacuum are at 49 and 87.
const BAND_RAD_S: [f64; 2] = [40.0, 110.0];

/// Strip theory.
pub const STRIPS: &str = "model = \"strip\"";

/// The vortex lattice of a half wing.
pub const LATTICE: &str = "model = \"uvlm\"\nmirror_normal = [1.0, 0.0, 0.0]";

/// The same lattice with loads by the Kutta–Joukowski theorem.
pub const LATTICE_WITH_SUCTION: &str = "model = \"uvlm\"\nmirror_normal = [1.0, 0.0, 0.0]\nleading_edge_suction = true";

/// Discretisation of a run, and its aerodynamics.
#[derive(Clone, Copy, Debug)]
pub struct Goland {
    /// Lines of `[aerodynamics]` that select the model.
    pub air: &'static str,
    /// Density of the air in kg/m³.
    pub density_kg_m3: f64,
    /// Pairs of elements.
    pub pairs: usize,
    /// Strips along the span.
    pub strips: usize,
    /// Panels of the lattice along the chord.
    pub chord_panels: usize,
    /// Rows of panels in the wake.
    pub wake_rows: usize,
    /// Distance the wind travels in an aerodynamic step, in chords; the motion is so small that the error estimate needs no shorter
    /// structural steps.
    pub step_chords: f64,
    /// Distance of the elastic axis behind the leading edge, as a fraction of the chord.
    pub elastic_axis_fraction: f64,
    /// Incidence of the surface in degrees.
    pub incidence_deg: f64,
    /// Peak velocity of the gust in m/s: so small that terms quadratic in the motion are negligible.
    pub gust_m_s: f64,
    /// End of the record in s.
    pub end_s: f64,
}

impl Goland {
    /// Chord in m.
    pub const CHORD_M: f64 = 1.8288;

    /// Strips with Wagner's lag at the density of the published strip-theory values.
    pub fn strips() -> Self {
        Self {
            air: STRIPS,
            density_kg_m3: 1.225,
            pairs: 4,
            strips: 16,
            chord_panels: 1,
            wake_rows: 1,
            step_chords: 0.075,
            elastic_axis_fraction: 0.33,
            incidence_deg: 0.0,
            gust_m_s: 0.02,
            end_s: 0.5,
        }
    }

    /// Lattice whose panels have the length that the wind travels in a step, with a wake of ten chords, at the density of the published
    /// values; the wing ends at a mirror plane.
    pub fn lattice(chord_panels: usize, strips: usize) -> Self {
        Self {
            air: LATTICE,
            density_kg_m3: 1.02,
            strips,
            chord_panels,
            wake_rows: 10 * chord_panels,
            step_chords: 1.0 / chord_panels as f64,
            end_s: 0.4,
            ..Self::strips()
        }
    }

    /// The wing in a wind along its chord, with the structure of the shipped model modified by `change`.
    pub fn machine(&self, speed_m_s: f64, change: impl Fn(String) -> String) -> Machine {
        let shipped = include_str!("../../../examples/models/goland_wing.toml");
        let (structure, _) = shipped.split_once("\n[aerodynamics]").expect("air after the structure");
        let structure = change(structure.replace("\nelements = 4\n", &format!("\nelements = {}\n", self.pairs)));
        let step_s = self.step_chords * Self::CHORD_M / speed_m_s;
        let [wake_rows, chord_panels] = match self.air {
            STRIPS => [String::new(), String::new()],
            _ => [format!("wake_rows = {}\n", self.wake_rows), format!("chord_panels = {}\n", self.chord_panels)],
        };
        let mut text = format!(
            "{structure}\n[aerodynamics]\n{}\ndensity_kg_m3 = {:?}\nwind_m_s = [0.0, {:?}, 0.0]\nstep_s = {step_s:?}\n\
             {wake_rows}coupling_tolerance = 1e-7\n\
             [surface.wing]\nbody = \"wing\"\nchord_m = 1.8288\nelastic_axis_fraction = {:?}\nincidence_deg = {:?}\n\
             strips = {}\n{chord_panels}[solver]\nmax_step_s = {step_s:?}\n",
            self.air, self.density_kg_m3, -speed_m_s, self.elastic_axis_fraction, self.incidence_deg, self.strips
        );
        if self.gust_m_s > 0.0 {
            let gust =
                format!("velocity_m_s = [0.0, 0.0, {:?}]\nlength_m = 2.0\norigin_m = [0.0, 0.7, 0.0]", self.gust_m_s);
            text += &format!("[gust.bump]\nshape = \"one_minus_cosine\"\n{gust}\n");
        }
        config::parse(&text, "goland.toml").unwrap_or_else(|error| panic!("{error}"))
    }

    /// Growth rate and frequency at a speed.
    pub fn oscillation(&self, speed_m_s: f64) -> Oscillation {
        let mut plant = start(self.machine(speed_m_s, |structure| structure));
        let samples = ((self.end_s - FROM_S) / INTERVAL_S).round() as u32;
        let heave_m: Vec<f64> = (0..samples)
            .map(|i| {
                plant.step(FROM_S + f64::from(i) * INTERVAL_S).unwrap_or_else(|error| panic!("{error}"));
                plant.outputs().tips()[0].position_m.z
            })
            .collect();
        least_damped(&heave_m, INTERVAL_S, BAND_RAD_S)
    }

    /// Flutter speed in m/s and frequency in rad/s: the zero of the parabola through the growth rates at three speeds, spaced by the
    /// fraction `spread` of the middle one.
    pub fn flutter(&self, near_m_s: f64, spread: f64) -> [f64; 2] {
        let speeds_m_s = [1.0 - spread, 1.0, 1.0 + spread].map(|factor| factor * near_m_s);
        let runs = speeds_m_s.map(|speed_m_s| self.oscillation(speed_m_s));
        let growth = |speed_m_s| parabola(speeds_m_s, runs.map(|run| run.growth_1_s), speed_m_s);
        let [mut below, mut above] = [speeds_m_s[0], speeds_m_s[2]];
        assert!(growth(below) < 0.0 && growth(above) > 0.0, "no flutter between {speeds_m_s:?}: {runs:?}");
        for _ in 0..60 {
            let middle = 0.5 * (below + above);
            if growth(middle) < 0.0 { below = middle } else { above = middle }
        }
        [below, parabola(speeds_m_s, runs.map(|run| run.frequency_rad_s), below)]
    }
}

/// Value at `at` of the parabola through three points.
pub fn parabola(x: [f64; 3], y: [f64; 3], at: f64) -> f64 {
    (0..3)
        .map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            y[i] * (at - x[j]) * (at - x[k]) / ((x[i] - x[j]) * (x[i] - x[k]))
        })
        .sum()
}

/// The reference file with the wing's data and the published results.
pub fn reference() -> Value {
    serde_json::from_str(include_str!("../../reference/goland.json")).expect("valid JSON")
}

/// The shipped model has the data of the reference.
#[test]
fn q20_model_has_the_data_of_the_reference() {
    let wing = &reference()["wing"];
    let of = |key: &str| wing[key].as_f64().unwrap_or_else(|| panic!("no number {key}"));
    let text = include_str!("../../../examples/models/goland_wing.toml");
    let file: toml::Table = toml::from_str(text).expect("TOML");
    let number = |value: &toml::Value| value.as_float().expect("a number");
    let section = &file["section"]["wing"];
    let surface = &file["surface"]["wing"];
    let arm_m = -number(&section["centre_of_mass_m"][0]);
    let inertia_kg_m = number(&section["second_moments_kg_m"][0]) + number(&section["second_moments_kg_m"][2]);
    let mass_kg_m = number(&section["mass_kg_m"]);
    for (ours, key) in [
        (number(&file["body"]["wing"]["length_m"]), "span_m"),
        (number(&surface["chord_m"]), "chord_m"),
        (number(&surface["elastic_axis_fraction"]), "elastic_axis_of_chord"),
        (mass_kg_m, "mass_kg_m"),
        (arm_m, "static_moment_arm_m"),
        (number(&section["flap_stiffness_N_m2"]), "flap_stiffness_N_m2"),
        (number(&section["torsional_rigidity_N_m2"]), "torsional_stiffness_N_m2"),
        (inertia_kg_m + mass_kg_m * arm_m * arm_m, "inertia_about_elastic_axis_kg_m"),
    ] {
        // number of digits in the file
        approx::assert_relative_eq!(ours, of(key), max_relative = 1e-7);
    }
}
