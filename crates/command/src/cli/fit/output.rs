//! Table, JSON and figures of a fit.

use crate::cli::fit::data::Data;
use crate::cli::fit::trials::Trials;
use crate::cli::number::six;
use crate::report::figure::{Curve, Figure, Look, PALETTE};
use foldwing_study::fit::{Found, Uncertainty};
use nalgebra::DVector;
use serde::Serialize;
use std::fmt::Write;

/// Component of a unit direction below which a parameter is omitted from the text.
const SMALL: f64 = 0.05;
const BEFORE: [u8; 3] = [150, 160, 170];

/// Result as JSON; numbers that are not finite are `null`.
#[derive(Serialize)]
pub struct Identified {
    name: String,
    /// Whether the search ended by one of its tolerances.
    pub converged: bool,
    /// Reason why the search ended.
    pub ended: String,
    runs: usize,
    /// Standard deviation of the residuals, in units of `--sigma` or of the largest magnitude in each column.
    noise: f64,
    degrees_of_freedom: i64,
    numbers: Vec<Number>,
    covariance: Vec<Vec<f64>>,
    /// Directions that the measurements do not determine, with a component for each parameter relative to its
    /// magnitude.
    unidentified: Vec<Vec<f64>>,
    measurements: Vec<Measurements>,
}

#[derive(Serialize)]
struct Number {
    name: String,
    unit: &'static str,
    start: f64,
    value: f64,
    standard_error: f64,
}

#[derive(Serialize)]
struct Measurements {
    name: String,
    unit: &'static str,
    times_s: Vec<f64>,
    measured: Vec<f64>,
    before: Vec<f64>,
    after: Vec<f64>,
    /// Root mean square difference.
    rms_before: f64,
    rms_after: f64,
}

impl Identified {
    pub fn new(
        trials: &Trials,
        data: &Data,
        (first, found, own): (&DVector<f64>, &Found, &Uncertainty),
        (before, after): (&[f64], &[f64]),
    ) -> Self {
        let errors = own.standard_errors();
        let number = |(i, (name, _, unit)): (usize, &(String, f64, &'static str))| Number {
            name: name.clone(),
            unit,
            start: first[i],
            value: found.x[i],
            standard_error: errors[i],
        };
        let measurements = data.columns.iter().filter(|column| !data.places(column).is_empty()).map(|column| {
            let places = data.places(column);
            let rms = |computed: &[f64]| {
                let squares = places.clone().map(|i| (computed[i] - data.values[i]).powi(2));
                (squares.sum::<f64>() / places.len() as f64).sqrt()
            };
            Measurements {
                name: column.name.clone(),
                unit: trials.units[column.first],
                times_s: column.times_s.clone(),
                measured: data.values[places.clone()].to_vec(),
                before: before[places.clone()].to_vec(),
                after: after[places.clone()].to_vec(),
                rms_before: rms(before),
                rms_after: rms(after),
            }
        });
        Self {
            name: trials.name.clone(),
            converged: found.ended.converged(),
            ended: found.ended.to_string(),
            runs: found.runs,
            noise: own.noise,
            degrees_of_freedom: data.values.len() as i64 - first.len() as i64,
            numbers: trials.numbers.iter().enumerate().map(number).collect(),
            covariance: own.covariance.row_iter().map(|row| row.iter().copied().collect()).collect(),
            unidentified: own.undetermined.iter().map(|row| row.as_slice().to_vec()).collect(),
            measurements: measurements.collect(),
        }
    }
}

/// Returns the result as a text table; `settings` are `NAME=VALUE` of inputs and parameters.
pub fn text_of(found: &Identified, settings: &[String]) -> String {
    let count: usize = found.measurements.iter().map(|own| own.measured.len()).sum();
    let mut text = format!(
        "{}: {} numbers from {count} measurements, {} runs, {}\n",
        found.name,
        found.numbers.len(),
        found.runs,
        found.ended
    );
    let width = found.numbers.iter().map(|own| own.name.len()).chain([6]).max().unwrap_or(0);
    let _ = writeln!(text, "{:<width$}  {:>12}  {:>12}  {:>14}", "number", "start", "value", "standard error");
    for Number { name, unit, start, value, standard_error } in &found.numbers {
        let error = if standard_error.is_nan() { "-".to_owned() } else { format!("± {standard_error:.1e}") };
        let unit = if unit.is_empty() || *unit == "1" { "" } else { unit };
        let line = format!("{name:<width$}  {:>12}  {:>12}  {error:>14}  {unit}", six(*start), six(*value));
        let _ = writeln!(text, "{}", line.trim_end());
    }
    let width = found.measurements.iter().map(|own| own.name.len()).chain([11]).max().unwrap_or(0);
    let _ = writeln!(text, "{:<width$}  {:>12}  {:>12}  {:>14}", "measurement", "count", "rms before", "rms after");
    for own in &found.measurements {
        let unit = if own.unit.is_empty() || own.unit == "1" { "" } else { own.unit };
        let (count, before, after) = (own.measured.len(), six(own.rms_before), six(own.rms_after));
        let line = format!("{:<width$}  {count:>12}  {before:>12}  {after:>14}  {unit}", own.name);
        let _ = writeln!(text, "{}", line.trim_end());
    }
    if !found.noise.is_nan() {
        let _ = writeln!(text, "standard deviation of the scaled residuals: {}", six(found.noise));
    }
    for direction in &found.unidentified {
        let parts = direction.iter().zip(&found.numbers).filter(|(part, _)| part.abs() > SMALL);
        let parts: Vec<String> = parts.map(|(part, number)| format!("{part:+.2} {}", number.name)).collect();
        let _ = writeln!(text, "not determined, relative changes together: {}", parts.join(", "));
    }
    if !settings.is_empty() {
        let settings: Vec<String> = settings.iter().map(|text| format!("--set {text}")).collect();
        let _ = writeln!(text, "for other commands: {}", settings.join(" "));
    }
    text
}

/// Figures of each column over time: measured values as dots, and values computed before and after the fit.
pub fn figures(found: &Identified) -> Vec<Figure> {
    let columns = found.measurements.iter().filter(|own| !own.times_s.is_empty());
    let figure = |own: &Measurements| {
        let points = |values: &[f64]| own.times_s.iter().zip(values).map(|(time_s, value)| [*time_s, *value]).collect();
        let curve = |name: &str, colour, look, values: &[f64]| Curve {
            name: name.to_owned(),
            colour,
            look,
            points: points(values),
        };
        Figure {
            title: format!("{}: {}", found.name, own.name),
            x_label: "time (s)".to_owned(),
            y_label: format!("{} ({})", own.name, own.unit),
            curves: vec![
                curve("before", BEFORE, Look::Dashed, &own.before),
                curve("after", PALETTE[0], Look::Line, &own.after),
                curve("measured", PALETTE[1], Look::Dots, &own.measured),
            ],
            ..Figure::default()
        }
    };
    columns.map(figure).collect()
}

/// Figure of measured against computed values, each divided by the largest measured magnitude of its name.
pub fn scatter(found: &Identified) -> Figure {
    let points = |computed: fn(&Measurements) -> &[f64]| -> Vec<[f64; 2]> {
        let each = |own: &Measurements| {
            let largest = own.measured.iter().fold(0.0f64, |largest, value| largest.max(value.abs()));
            let scale = if largest == 0.0 { 1.0 } else { largest };
            own.measured.iter().zip(computed(own)).map(|(a, b)| [a / scale, b / scale]).collect::<Vec<_>>()
        };
        found.measurements.iter().flat_map(each).collect()
    };
    let (before, after) = (points(|own| &own.before), points(|own| &own.after));
    let ends = before.iter().chain(&after).map(|point| point[0]);
    let ends = [ends.clone().fold(f64::INFINITY, f64::min), ends.fold(f64::NEG_INFINITY, f64::max)];
    let curve = |name: &str, colour, look, points| Curve { name: name.to_owned(), colour, look, points };
    Figure {
        title: format!("{}: computed against measured", found.name),
        x_label: "measured, over the largest".to_owned(),
        y_label: "computed, over the largest measured".to_owned(),
        curves: vec![
            curve("equal", [110, 122, 134], Look::Line, ends.map(|end| [end, end]).to_vec()),
            curve("before", PALETTE[4], Look::Dots, before),
            curve("after", PALETTE[0], Look::Dots, after),
        ],
        equal: true,
        ..Figure::default()
    }
}
