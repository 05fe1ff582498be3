//! `foldwing flutter`: aeroelastic modes over wind speed; flutter and divergence speeds, also as a function of another parameter.

use crate::cli::Failure;
use crate::cli::branches::{BranchArguments, BranchTable, Varied, csv_text, write_figures};
use crate::cli::outlets::{Force, Mark, Outlets, Quiet};
use crate::cli::progress::Progress;
use crate::cli::shapes;
use crate::cli::shapes::shares;
use crate::cli::sweep::axis;
use crate::report::figure::{Curve, Figure};
use clap::builder::NonEmptyStringValueParser;
use foldwing_engine::plant::Crossing;
use foldwing_study::flutter::{
    Change, Ended, Event, Flutter, FlutterError, MAXIMUM_COUNT, MAXIMUM_SPEEDS, Options, sweep_watched,
};
use foldwing_study::watch;
use serde::Serialize;
use serde_json::json;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::FLUTTER)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Wind speeds in m/s, along the wind of the model: FROM:TO:COUNT or A,B,…
    #[arg(long, value_name = "VALUES", allow_hyphen_values = true)]
    wind_m_s: String,
    /// Repeat for several values of a start value, a parameter or a key of the model file (`file:…`):
    /// KEY=FROM:TO:COUNT or KEY=A,B,…
    #[arg(long = "vary", value_name = "KEY=VALUES", value_parser = NonEmptyStringValueParser::new())]
    over: Option<String>,
    /// Number of modes to track, beginning with the lowest frequency
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u16).range(1..=60))]
    count: u16,
    /// Start value of an input or parameter, e.g. `fold.release=0`; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    #[command(flatten)]
    branches: BranchArguments,
    /// HTML page with the mode shapes animated at each wind speed: one file, no network needed
    #[arg(long, value_name = "OUT.html", conflicts_with = "over")]
    view: Option<PathBuf>,
    /// Print JSON for programs
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    force: Force,
    #[command(flatten)]
    quiet: Quiet,
}

/// An entry of `results` in the JSON.
#[derive(Serialize)]
struct Entry<'a> {
    /// Value of `--vary`.
    value: Option<&'a str>,
    #[serde(flatten)]
    found: &'a Flutter,
}

/// Events between the preceding speed and `speed_m_s`, for a row of a table.
fn changes_up_to(found: &Flutter, speed_m_s: f64) -> String {
    let places = &found.branches.places;
    let before = places.iter().rev().map(|place| place.at).find(|at| *at < speed_m_s).unwrap_or(0.0);
    let own = found.changes.iter().filter(|change| (before..speed_m_s).contains(&change.between_m_s[0]));
    own.map(|change| change.event.name()).collect::<Vec<_>>().join(" ")
}

/// Computes flutter and divergence of a model.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let speeds_m_s = speeds(&arguments.wind_m_s)?;
    let mut outlets = Outlets::new(arguments.force.force, [arguments.model.as_path()]);
    arguments.branches.check(&outlets)?;
    let view = outlets.place_if(arguments.view.as_deref(), Mark::PAGE)?;
    let varied = Varied::new(&arguments.model, &arguments.settings, arguments.over.as_ref())?;
    let values = varied.values();
    let options = Options { wind_m_s: speeds_m_s, count: usize::from(arguments.count) };
    let (mut list, mut page) = (Vec::new(), None);
    {
        let mut progress = Progress::phase("wind speeds");
        let count = options.wind_m_s.len();
        let all = (values.len() * count) as u64;
        for (index, value) in values.iter().enumerate() {
            // count all values of `--vary` as one part, so that the estimated time is for the whole
            let mut watch = |watch::Progress { part, done, total }: watch::Progress| {
                if total.is_some() || values.len() > 1 {
                    progress.part("wind speeds", Some(all));
                    progress.at((index * count + if total.is_some() { done } else { count }) as u64);
                } else {
                    progress.part(part, None);
                    progress.at(done as u64);
                }
                ControlFlow::Continue(())
            };
            let plant = varied.plant(value)?;
            if arguments.view.is_none() {
                list.push(sweep_watched(plant, &options, &mut watch).map_err(failure)?);
                continue;
            }
            let seen = shapes::sweep_seen(plant, &options, &mut watch).map_err(failure)?;
            let drawn = shapes::of_flutter(varied.plant(value)?, &seen);
            page = Some(shapes::page(&drawn.map_err(|error| Failure::Statics(error.to_string()))?)?);
            list.push(seen.found);
        }
    }
    if let Some(page) = page {
        view.fill(page.as_bytes())?;
    }
    if let Some(warning) = list.iter().flat_map(|found| &found.warnings).next() {
        arguments.quiet.warning(&warning.to_string());
    }
    let key = (!varied.key().is_empty()).then_some(varied.key());
    let tables: Vec<BranchTable> =
        list.iter().map(|found| BranchTable { quantity: "speed", unit: "m/s", branches: &found.branches }).collect();
    if let (Some(path), Some(first)) = (&arguments.branches.csv, tables.first()) {
        let mut header = first.header(key);
        header.push("change".to_owned());
        let quantity = usize::from(key.is_some());
        let mut rows = Vec::new();
        for ((table, value), found) in tables.iter().zip(&values).zip(&list) {
            for mut row in table.rows(key.map(|_| value.as_str())) {
                let change = row[quantity].parse().map_or(String::new(), |speed_m_s| changes_up_to(found, speed_m_s));
                row.push(change);
                rows.push(row);
            }
        }
        let text = csv_text(&header, &rows);
        outlets.place(path, Mark::first_line(&text))?.fill(&text)?;
    }
    let name = &varied.machine().name;
    let figures = match (key, tables.first(), list.first()) {
        (Some(key), ..) => map(name, key, &values, &list).map(|map| ("flutter_map", map)).into_iter().collect(),
        (None, Some(table), Some(found)) => table.figures(name, &marks(found)),
        _ => Vec::new(),
    };
    write_figures(&arguments.branches, figures, &mut outlets)?;
    if arguments.json {
        let pairs = list.iter().zip(&values);
        let entries: Vec<Entry> =
            pairs.map(|(found, value)| Entry { value: key.map(|_| value.as_str()), found }).collect();
        let value = json!({ "name": name, "over": key, "results": entries });
        return arguments.quiet.print(&format!("{value:#}"), &outlets);
    }
    let mut text = String::new();
    for (found, value) in list.iter().zip(&values) {
        if let Some(key) = key {
            let _ = writeln!(text, "{key} = {value}");
        }
        text.push_str(&summary(found, &options.wind_m_s));
    }
    if let (None, Some(table)) = (key, tables.first()) {
        text = format!("{name} in a wind of {} m/s\n{}\n{}", arguments.wind_m_s, table.text(), text);
    }
    arguments.quiet.print(&text, &outlets)
}

/// Parses positive, ascending speeds in m/s.
fn speeds(text: &str) -> Result<Vec<f64>, Failure> {
    let refused = |cause: String| Failure::Usage(format!("--wind-m-s {text}: {cause}"));
    let values = axis(text).map_err(refused)?;
    let speeds: Option<Vec<f64>> = values.iter().map(|value| value.parse().ok()).collect();
    let speeds = speeds.ok_or_else(|| refused("must be numbers in m/s: A,B,… or FROM:TO:COUNT".to_owned()))?;
    let rise = speeds[0] > 0.0 && speeds.windows(2).all(|pair| pair[1] > pair[0]);
    if speeds.len() < 2 || !rise || speeds.iter().any(|speed| !speed.is_finite()) {
        return Err(refused("needs two or more positive speeds in ascending order".to_owned()));
    }
    if speeds.len() > MAXIMUM_SPEEDS {
        return Err(refused(format!("{} speeds exceed the maximum of {MAXIMUM_SPEEDS}", speeds.len())));
    }
    Ok(speeds)
}

/// Converts the error of a sweep to a message of the command.
pub(super) fn failure(error: FlutterError) -> Failure {
    let text = error.to_string();
    match error {
        FlutterError::FirstSpeed { .. } | FlutterError::Stopped => Failure::Statics(text),
        FlutterError::NoWind { machine } => Failure::Usage(format!(
            "{machine}: the model has no wind, so its direction is undefined; set aerodynamics.wind_m_s, or --set \
             wind.velocity.y=-1"
        )),
        FlutterError::Speeds => {
            Failure::Usage("--wind-m-s: needs two or more positive speeds in ascending order".to_owned())
        }
        FlutterError::TooManySpeeds { count } => {
            Failure::Usage(format!("--wind-m-s: {count} speeds exceed the maximum of {MAXIMUM_SPEEDS}"))
        }
        FlutterError::Count { count } => Failure::Usage(format!("--count {count}: must be from 1 to {MAXIMUM_COUNT}")),
        FlutterError::NoAir { .. } | FlutterError::Rotor { .. } | FlutterError::UnsteadyStart { .. } => {
            Failure::Usage(text)
        }
    }
}

/// Describes flutter and divergence as text.
fn summary(found: &Flutter, speeds_m_s: &[f64]) -> String {
    let mut text = String::new();
    for Crossing { branch, at, mode, begins } in &found.crossings {
        let what = match (mode.is_real(), begins) {
            (true, _) => continue,
            (false, true) => "flutter at",
            (false, false) => "no flutter beyond",
        };
        let _ = writeln!(
            text,
            "{what} {at:.6} m/s: {:.6} Hz ({:.6} rad/s), mode {}, {}",
            mode.frequency_hz,
            mode.eigenvalue_1_s.norm(),
            branch + 1,
            shares(mode)
        );
    }
    for speed_m_s in &found.divergence_m_s {
        let _ = writeln!(text, "divergence at {speed_m_s:.6} m/s");
    }
    if found.is_unstable_from_first() {
        let _ = writeln!(text, "unstable from the first speed on, {} m/s: start at a lower speed", speeds_m_s[0]);
    }
    let last = found.branches.places.last().map_or(0.0, |place| place.at);
    if text.is_empty() && found.changes.iter().all(|change| matches!(change.event, Event::Latch { .. })) {
        let _ = writeln!(text, "neither flutter nor divergence up to {last} m/s");
    }
    for Change { between_m_s: [low, high], event } in &found.changes {
        let _ = writeln!(text, "between {low:.6} and {high:.6} m/s: {event}");
    }
    let _ = write!(text, "{} modes tracked from {} to {last} m/s", found.modes_tracked(), speeds_m_s[0]);
    if let Some(Ended { wind_m_s, error }) = &found.ended {
        let _ = write!(text, "; the sweep ends before {wind_m_s} m/s: {error}");
    }
    text.push('\n');
    text
}

/// Speeds marked in the figures.
fn marks(found: &Flutter) -> Vec<(f64, String)> {
    let flutter = found.flutter().map(|crossing| (crossing.at, format!("flutter {:.4} m/s", crossing.at)));
    let divergence = found.divergence_m_s.iter().map(|speed| (*speed, format!("divergence {speed:.4} m/s")));
    flutter.chain(divergence).collect()
}

/// Figure of the lowest speeds of flutter and divergence over a parameter; `None` if its values are not numbers.
fn map(name: &str, key: &str, values: &[String], list: &[Flutter]) -> Option<Figure> {
    let at: Option<Vec<f64>> = values.iter().map(|value| value.parse().ok()).collect();
    let at = at?;
    let curve = |n: usize, what: &str, speed: &dyn Fn(&Flutter) -> Option<f64>| {
        let points = at.iter().zip(list).filter_map(|(at, found)| Some([*at, speed(found)?]));
        Curve::nth(n, what, points.collect())
    };
    let curves = vec![
        curve(0, "flutter", &|found| found.flutter().next().map(|crossing| crossing.at)),
        curve(1, "divergence", &|found| found.divergence_m_s.first().copied()),
    ];
    Some(Figure {
        title: format!("{name}: speeds of flutter and divergence"),
        x_label: key.to_owned(),
        y_label: "speed (m/s)".to_owned(),
        curves: curves.into_iter().filter(|curve| !curve.points.is_empty()).collect(),
        ..Figure::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The range of speeds includes both ends; invalid texts are errors.
    #[test]
    fn speeds_are_ranges_with_a_count() {
        assert_eq!(speeds("50:56:4").unwrap_or_default(), [50.0, 52.0, 54.0, 56.0]);
        assert_eq!(speeds("1,2.5,2.75").unwrap_or_default(), [1.0, 2.5, 2.75]);
        for text in ["50", "50:40:2", "0:10:2", "1:2:0", "1:x:2", "1:1e9:1e3", "2,1", "1,1", "1,inf", "nan,2", "50:200"]
        {
            assert!(speeds(text).is_err(), "{text}");
        }
    }
}
