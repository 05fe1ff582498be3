//! Modes about a periodic motion as a table of numbers.

use foldwing_engine::plant::{Floquet, FloquetMode};
use serde::Serialize;
use std::f64::consts::TAU;

/// Maximum number of harmonics, and of parts of the motion, listed for a mode.
const SHOWN: usize = 5;

/// Modes about a periodic motion. Its JSON is that of `foldwing periodic`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ModeTable {
    turns: usize,
    not_found: usize,
    largest_multiplier_not_found: f64,
    not_resolved: usize,
    not_seen_from_ground: Option<String>,
    modes: Vec<Mode>,
    averaged_stiffness_change: Option<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct Mode {
    multiplier: [f64; 2],
    exponent_1_s: [f64; 2],
    #[serde(rename = "frequency_Hz")]
    frequency_hz: f64,
    damping_ratio: f64,
    ambiguous: bool,
    harmonics: Vec<Harmonic>,
    motion: Vec<Part>,
    error: f64,
    grows: bool,
    averaged_1_s: Option<[f64; 2]>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct Harmonic {
    number: i32,
    share: f64,
    #[serde(rename = "frequency_Hz")]
    frequency_hz: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
struct Part {
    part: String,
    share: f64,
}

/// The first `count` modes.
pub fn table_of_modes(floquet: &Floquet, count: usize) -> ModeTable {
    ModeTable {
        turns: floquet.turns,
        not_found: floquet.unfound,
        largest_multiplier_not_found: floquet.largest_unfound,
        not_resolved: floquet.coarse,
        not_seen_from_ground: floquet.unseen.clone(),
        modes: floquet.modes.iter().take(count).map(mode).collect(),
        averaged_stiffness_change: floquet.averaged.as_ref().map(|averaged| averaged.spread),
    }
}

fn mode(mode: &FloquetMode) -> Mode {
    let harmonics = mode.harmonics.iter().take(SHOWN).map(|harmonic| Harmonic {
        number: harmonic.number,
        share: harmonic.share,
        frequency_hz: harmonic.frequency_rad_s / TAU,
    });
    let parts = mode.parts.iter().take(SHOWN).map(|part| Part { part: part.to_string(), share: part.share });
    Mode {
        multiplier: [mode.multiplier.re, mode.multiplier.im],
        exponent_1_s: [mode.exponent_1_s.re, mode.exponent_1_s.im],
        frequency_hz: mode.frequency_hz,
        damping_ratio: mode.damping_ratio,
        ambiguous: mode.ambiguous,
        harmonics: harmonics.collect(),
        motion: parts.collect(),
        error: mode.error,
        grows: mode.is_growing(),
        averaged_1_s: mode.averaged_1_s.map(|value| [value.re, value.im]),
    }
}
