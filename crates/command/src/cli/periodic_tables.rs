//! Tables of a periodic steady state: outputs over one revolution with their harmonics, and Floquet modes.

use foldwing_engine::plant::{Floquet, FloquetMode, SAMPLES};
use foldwing_study::periodic::Series;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Name of an output with its unit.
pub(super) fn label(series: &Series) -> String {
    if ["", "1"].contains(&series.unit) { series.name.clone() } else { format!("{} [{}]", series.name, series.unit) }
}

/// Outputs over the shaft angle from the start, in degrees, one row per sample.
pub(super) fn csv_text(series: &[Series], sense: f64) -> Vec<u8> {
    let mut text = "turn_deg".to_owned();
    series.iter().for_each(|series| {
        text.push(',');
        text.push_str(&series.name);
    });
    text.push('\n');
    for k in 0..=SAMPLES {
        let _ = write!(text, "{}", sense * 360.0 * k as f64 / SAMPLES as f64);
        series.iter().filter_map(|series| series.values.get(k)).for_each(|value| {
            let _ = write!(text, ",{value:?}");
        });
        text.push('\n');
    }
    text.into_bytes()
}

/// Appends the Floquet modes, one line each.
pub(super) fn modes_text(floquet: &Floquet, count: usize, text: &mut String) {
    let averaged = match floquet.averaged {
        Some(_) => "; averaged: equations in the fixed frame, averaged over the revolution",
        None => "",
    };
    let _ = writeln!(
        text,
        "\nmodes about this motion, {} revolutions{averaged}\n{:>4} {:>12} {:>12} {:>10} {:>7} {:>12} {:>10}  motion",
        floquet.turns, "mode", "multiplier", "frequency Hz", "damping", "share", "averaged Hz", "damping"
    );
    for (i, mode) in floquet.modes.iter().take(count).enumerate() {
        let averaged = mode.averaged_1_s.map_or(format!("{:>12} {:>10}", "-", "-"), |value| {
            let size = value.norm();
            format!("{:12.6} {:10.6}", size / TAU, if size > 0.0 { -value.re / size } else { 0.0 })
        });
        let _ = writeln!(
            text,
            "{:4} {:12.6} {:12.6} {:>10} {:7.3} {averaged}  {}{}",
            i + 1,
            mode.multiplier.norm(),
            mode.frequency_hz,
            if mode.is_neutral() { "-".to_owned() } else { format!("{:.6}", mode.damping_ratio) },
            mode.harmonics.first().map_or(0.0, |harmonic| harmonic.share),
            mode.parts.first().map_or(String::new(), ToString::to_string),
            others(mode)
        );
    }
    match floquet.modes.iter().filter(|mode| mode.is_growing()).count() {
        0 => {}
        1 => text.push_str("1 mode grows: the motion is unstable\n"),
        growing => {
            let _ = writeln!(text, "{growing} modes grow: the motion is unstable");
        }
    }
    notes(floquet, text);
    if let Some(averaged) = &floquet.averaged {
        let _ = writeln!(
            text,
            "relative change of the stiffness in the fixed frame over the revolution: up to {:.1e}",
            averaged.spread
        );
    }
}

/// Appends notes on modes that are missing in the list.
fn notes(floquet: &Floquet, text: &mut String) {
    if floquet.unfound > 0 {
        let _ = write!(
            text,
            "modes not shown, not converged to four digits: {}, with multipliers of up to {:.3}",
            floquet.unfound, floquet.largest_unfound
        );
        let hint = if floquet.largest_unfound > 1.0 { "; one of them may grow: raise --perturbations" } else { "" };
        let _ = writeln!(text, "{hint}");
    }
    if floquet.coarse > 0 {
        let _ = writeln!(
            text,
            "modes not shown, because the revolution has fewer than 24 steps (--steps) or 2 of its {SAMPLES} samples \
             in one of their periods: {}",
            floquet.coarse
        );
    }
    if let Some(cause) = &floquet.unseen {
        let _ = writeln!(text, "frequencies are in the coordinates of the model, not in the fixed frame: {cause}");
    }
}

/// Other candidate frequencies of an ambiguous mode.
fn others(mode: &FloquetMode) -> String {
    if !mode.ambiguous {
        return String::new();
    }
    let list: Vec<String> = mode
        .harmonics
        .iter()
        .skip(1)
        .take(2)
        .map(|harmonic| format!("{:.6} Hz ({:.2})", harmonic.frequency_rad_s / TAU, harmonic.share))
        .collect();
    format!("; ambiguous, also {}", list.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use foldwing_engine::plant::Harmonic;
    use foldwing_study::periodic::table_of_modes;
    use serde_json::{Value, json};

    /// Text and JSON have the same numbers for modes, in the units of their keys and headings: frequencies in Hz, also those of harmonics
    /// and the candidate frequencies of an ambiguous mode.
    #[test]
    fn modes_have_the_units_of_their_keys() {
        let harmonic = |number: i32, hz: f64, share: f64| Harmonic { number, frequency_rad_s: TAU * hz, share };
        let complex = |re: f64, im: f64| nalgebra::Complex::new(re, im);
        let mode = FloquetMode {
            multiplier: complex(0.6, 0.25),
            exponent_1_s: complex(-0.7, 4.5),
            frequency_hz: complex(-0.7, 4.5).norm() / TAU,
            damping_ratio: 0.7 / complex(-0.7, 4.5).norm(),
            harmonics: vec![harmonic(1, 0.75, 0.5), harmonic(0, 1.25, 0.3), harmonic(-1, 2.5, 0.2)],
            ambiguous: true,
            parts: Vec::new(),
            error: 1e-6,
            principal_1_s: complex(-0.7, 0.2),
            motion: Vec::new(),
            averaged_1_s: Some(complex(-0.6, 4.0)),
        };
        let floquet = Floquet { modes: vec![mode.clone()], turns: 12, ..Floquet::default() };
        let json = &json!(table_of_modes(&floquet, 5))["modes"][0];
        let number = |value: &Value| value.as_f64().expect("a number");
        for (found, due) in json["harmonics"].as_array().unwrap().iter().zip(&mode.harmonics) {
            assert_eq!(found["number"], due.number);
            assert_eq!(
                [number(&found["share"]), number(&found["frequency_Hz"])],
                [due.share, due.frequency_rad_s / TAU]
            );
        }
        let [re, im] = [0, 1].map(|part| number(&json["exponent_1_s"][part]));
        // both numbers are rounded
        assert!((number(&json["frequency_Hz"]) - re.hypot(im) / TAU).abs() < 1e-15, "{json}");
        assert!((number(&json["damping_ratio"]) + re / re.hypot(im)).abs() < 1e-15, "{json}");
        assert_eq!([number(&json["multiplier"][0]), number(&json["averaged_1_s"][1])], [0.6, 4.0]);
        let mut text = String::new();
        modes_text(&floquet, 5, &mut text);
        let line = text.lines().find(|line| line.contains("ambiguous")).expect("the mode");
        assert!(line.ends_with("; ambiguous, also 1.250000 Hz (0.30), 2.500000 Hz (0.20)"), "{line}");
        let words: Vec<&str> = line.split_whitespace().collect();
        let averaged = complex(-0.6, 4.0).norm();
        for (word, due) in words[1..].iter().zip([
            mode.multiplier.norm(),
            mode.frequency_hz,
            mode.damping_ratio,
            0.5,
            averaged / TAU,
            0.6 / averaged,
        ]) {
            assert!((word.parse::<f64>().expect("a number") - due).abs() < 1e-6, "{line}: {due}");
        }
    }
}
