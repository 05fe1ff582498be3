//! Tables of a periodic steady state: outputs over the revolution with their harmonics, and Floquet modes.

use foldwing_engine::plant::{Floquet, FloquetMode, SAMPLES};
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::fmt::Write;

/// Change over a revolution, relative to the range of an output, above which it is not periodic.
const DRIFT: f64 = 1e-2;
/// The same relative to its largest magnitude, and in its unit, below which it is round-off.
const ROUND_OFF: [f64; 2] = [1e-6, 1e-9];
/// An output over the revolution.
pub(super) struct Series {
    /// Name of the output.
    pub name: String,
    unit: &'static str,
    /// Values at the samples, and at the end of the revolution.
    pub values: Vec<f64>,
}

impl Series {
    /// Returns a series without values.
    pub fn of(name: &str, unit: &'static str) -> Self {
        Self { name: name.to_owned(), unit, values: Vec::with_capacity(SAMPLES + 1) }
    }

    /// Name with unit.
    pub fn label(&self) -> String {
        if self.unit.is_empty() || self.unit == "1" {
            self.name.clone()
        } else {
            format!("{} [{}]", self.name, self.unit)
        }
    }

    /// Returns whether all values are zero.
    pub fn is_zero(&self) -> bool {
        self.values.iter().all(|value| *value == 0.0)
    }

    /// Returns whether the value at the end of the revolution is that at its start.
    pub fn is_periodic(&self) -> bool {
        let largest = self.values.iter().fold(0.0f64, |largest, value| largest.max(value.abs()));
        self.drift() <= (2.0 * DRIFT * self.half_range()).max(ROUND_OFF[0] * largest).max(ROUND_OFF[1])
    }

    /// Difference of the values at the end and at the start of the revolution.
    pub fn drift(&self) -> f64 {
        let (Some(first), Some(last)) = (self.values.first(), self.values.last()) else { return 0.0 };
        (last - first).abs()
    }

    /// Half the difference of the largest and the smallest value.
    pub fn half_range(&self) -> f64 {
        let high = self.values.iter().fold(f64::MIN, |high, value| high.max(*value));
        let low = self.values.iter().fold(f64::MAX, |low, value| low.min(*value));
        0.5 * (high - low)
    }

    /// Amplitude of a harmonic and the azimuth from the start in rad of its first maximum; for 0 the mean.
    pub fn harmonic(&self, n: usize) -> [f64; 2] {
        let values = &self.values[..SAMPLES.min(self.values.len())];
        let count = values.len() as f64;
        if n == 0 {
            return [values.iter().sum::<f64>() / count, 0.0];
        }
        let (mut cosine, mut sine) = (0.0, 0.0);
        for (k, value) in values.iter().enumerate() {
            let (s, c) = (TAU * (n * k % SAMPLES) as f64 / SAMPLES as f64).sin_cos();
            cosine += value * c * 2.0 / count;
            sine += value * s * 2.0 / count;
        }
        [cosine.hypot(sine), sine.atan2(cosine).rem_euclid(TAU) / n as f64]
    }

    /// Name, unit, mean, half the range, amplitudes and phases as JSON; phases are shaft angles with the sign of its rotation, as in the
    /// table over the revolution.
    pub fn json(&self, harmonics: usize, sense: f64) -> Value {
        let parts: Vec<[f64; 2]> = (1..=harmonics).map(|n| self.harmonic(n)).collect();
        json!({
            "name": self.name,
            "unit": self.unit,
            "periodic": self.is_periodic(),
            "mean": self.harmonic(0)[0],
            "half_range": self.half_range(),
            "amplitudes": parts.iter().map(|part| part[0]).collect::<Vec<_>>(),
            "largest_at_deg": parts.iter().map(|part| sense * part[1].to_degrees()).collect::<Vec<_>>(),
        })
    }
}

/// The outputs over the shaft angle from the start, in degrees, one row per sample.
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
        Some(_) => "; averaged: equations in the ground frame, averaged over the turn",
        None => "",
    };
    let _ = writeln!(
        text,
        "\nmodes about this motion, {} turns{averaged}\n{:>4} {:>12} {:>12} {:>10} {:>7} {:>12} {:>10}  motion",
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
            "relative change of the stiffness in the ground frame over the turn: up to {:.1e}",
            averaged.spread
        );
    }
}

/// Appends notes on modes that the list does not contain.
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
            "modes not shown, as the turn has fewer than 24 steps (--steps) or 2 of its {SAMPLES} samples in a period of theirs: {}",
            floquet.coarse
        );
    }
    if let Some(cause) = &floquet.unseen {
        let _ =
            writeln!(text, "frequencies are those in the coordinates of the machine, not in the ground frame: {cause}");
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

/// The Floquet modes as JSON.
pub(super) fn modes_json(floquet: &Floquet, count: usize) -> Value {
    let mode = |mode: &FloquetMode| {
        json!({
            "multiplier": [mode.multiplier.re, mode.multiplier.im],
            "exponent_1_s": [mode.exponent_1_s.re, mode.exponent_1_s.im],
            "frequency_Hz": mode.frequency_hz,
            "damping_ratio": mode.damping_ratio,
            "ambiguous": mode.ambiguous,
            "harmonics": mode.harmonics.iter().take(5).map(|harmonic| json!({
                "number": harmonic.number,
                "share": harmonic.share,
                "frequency_Hz": harmonic.frequency_rad_s / TAU,
            })).collect::<Vec<_>>(),
            "motion": mode.parts.iter().take(5).map(|part| json!({ "part": part.to_string(), "share": part.share })).collect::<Vec<_>>(),
            "error": mode.error,
            "grows": mode.is_growing(),
            "averaged_1_s": mode.averaged_1_s.map(|value| [value.re, value.im]),
        })
    };
    json!({
        "turns": floquet.turns,
        "not_found": floquet.unfound,
        "largest_multiplier_not_found": floquet.largest_unfound,
        "not_resolved": floquet.coarse,
        "not_seen_from_ground": floquet.unseen,
        "modes": floquet.modes.iter().take(count).map(mode).collect::<Vec<_>>(),
        "averaged_stiffness_change": floquet.averaged.as_ref().map(|averaged| averaged.spread),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use foldwing_engine::plant::Harmonic;

    /// `2 + 3 cos(2(ψ − 0.4))`: mean, second harmonic with its phase, no other; a ramp is not periodic, a constant is.
    #[test]
    fn harmonics_of_a_series() {
        let of = |f: &dyn Fn(f64) -> f64| {
            let mut series = Series::of("x", "m");
            series.values = (0..=SAMPLES).map(|k| f(TAU * k as f64 / SAMPLES as f64)).collect();
            series
        };
        let wave = of(&|turn| 2.0 + 3.0 * (2.0 * (turn - 0.4)).cos());
        assert!(
            (wave.harmonic(0)[0] - 2.0).abs() < 1e-13 && wave.harmonic(1)[0] < 1e-13 && wave.harmonic(3)[0] < 1e-13
        );
        let [amplitude, place] = wave.harmonic(2);
        assert!((amplitude - 3.0).abs() < 1e-12 && (place - 0.4).abs() < 1e-12, "{amplitude} {place}");
        assert!(wave.is_periodic() && (wave.half_range() - 3.0).abs() < 1e-2);
        assert!(!of(&|turn| turn).is_periodic() && of(&|_| 7.0).is_periodic());
        assert!((of(&|turn| turn).drift() - TAU).abs() < 1e-12);
        // for a shaft that turns backwards, the angles are those of its own rotation, as in the table over the revolution
        let places = [1.0, -1.0].map(|sense| wave.json(2, sense)["largest_at_deg"][1].as_f64().unwrap());
        assert!((places[0] - 0.4f64.to_degrees()).abs() < 1e-9 && places[1] == -places[0], "{places:?}");
    }

    /// Modes in text and JSON have the same numbers in the units of their keys and headings: frequencies in Hz, also those of harmonics and
    /// the candidate frequencies of an ambiguous mode.
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
            averaged_1_s: Some(complex(-0.6, 4.0)),
        };
        let floquet = Floquet { modes: vec![mode.clone()], turns: 12, ..Floquet::default() };
        let json = &modes_json(&floquet, 5)["modes"][0];
        let number = |value: &Value| value.as_f64().expect("a number");
        for (found, due) in json["harmonics"].as_array().unwrap().iter().zip(&mode.harmonics) {
            assert_eq!(found["number"], due.number);
            assert_eq!(
                [number(&found["share"]), number(&found["frequency_Hz"])],
                [due.share, due.frequency_rad_s / TAU]
            );
        }
        let [re, im] = [0, 1].map(|part| number(&json["exponent_1_s"][part]));
        // two roundings
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
