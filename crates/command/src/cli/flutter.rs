//! `foldwing flutter`: aeroelastic modes over wind speed, the speeds of flutter and divergence, and these over another parameter.

use crate::cli::branches::{BranchArguments, BranchTable, Varied, csv_text, pool, write_figures};
use crate::cli::modes::shares;
use crate::cli::outlets::{Force, Mark, Outlets};
use crate::cli::sweep::axis;
use crate::cli::{Failure, implausible, print, tell};
use crate::report::figure::{Curve, Figure};
use clap::builder::NonEmptyStringValueParser;
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{Branches, Crossing, Holding, ModeShape, Plant, PlantError, change_of_sign};
use nalgebra::Vector3;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;

/// Distance of two equilibria, in rad or relative to the size of the machine, below which no jump between them is searched for.
const NEAR: f64 = 1e-3;
/// Number of bisections between two distant equilibria. Along a path that turns back at its end their distance shrinks by a factor of at
/// least √½ each time, to 1/16 after eight.
const HALVINGS: usize = 8;
/// Ratio of the distances after and before these bisections above which the equilibrium jumps.
const JUMPS: f64 = 0.25;
/// Maximum number of speeds of a sweep.
pub(super) const MAXIMUM_SPEEDS: f64 = 10_000.0;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::FLUTTER)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Wind speeds in m/s, along the wind of the model: FROM:TO:COUNT or A,B,…
    #[arg(long, value_name = "VALUES", allow_hyphen_values = true)]
    wind_m_s: String,
    /// Speeds of flutter and divergence over a start value, a parameter or a key of the model file (`file:…`):
    /// KEY=FROM:TO:COUNT or KEY=A,B,…
    #[arg(long = "vary", value_name = "KEY=VALUES", value_parser = NonEmptyStringValueParser::new())]
    over: Option<String>,
    /// Number of modes to follow, of lowest frequency
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u16).range(1..=60))]
    count: u16,
    /// Start value of an input or parameter, e.g. `fold.release=0`; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    #[command(flatten)]
    branches: BranchArguments,
    /// Print JSON for programs
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    force: Force,
}

/// Results of a sweep over the speed.
pub(super) struct Found {
    /// Modes over the speed.
    pub branches: Branches<ModeShape>,
    /// Speeds at which modes become unstable or stable.
    pub crossings: Vec<Crossing<ModeShape>>,
    /// Speeds of divergence in m/s.
    pub divergence_m_s: Vec<f64>,
    /// Other changes between two speeds, in ascending order: [`Change`].
    pub changes: Vec<Change>,
    /// Reason for an early end of the sweep: speed in m/s and message.
    pub ended: Option<(f64, String)>,
}

/// Change between two speeds that is not a speed of flutter or divergence.
pub(super) struct Change {
    /// Speeds in m/s that bracket the change.
    pub between_m_s: [f64; 2],
    pub kind: Kind,
    pub text: String,
}

/// Types of [`Change`].
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// Latches or end stops open or close: the modes on both sides are those of different configurations.
    Latch,
    /// The equilibrium jumps, or there is none in between.
    Jump,
    /// A mode becomes unstable at a speed that was not found.
    Unstable,
    /// The static stiffness changes its sign at a speed that was not found.
    Divergence,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Latch => "latch",
            Self::Jump => "jump",
            Self::Unstable => "unstable",
            Self::Divergence => "divergence",
        }
    }
}

/// Equilibrium for the comparison with that at another speed: latches, joint positions, and positions of the bodies' ends over the largest.
#[derive(Clone)]
struct Posture {
    latched: Vec<bool>,
    travels: Vec<f64>,
    ends: Vec<Vector3<f64>>,
}

impl Posture {
    fn of(plant: &Plant) -> Self {
        let ends: Vec<Vector3<f64>> =
            plant.shape().iter().filter_map(|body| body.last().map(|section| section.position_m)).collect();
        let size_m = ends.iter().map(Vector3::norm).fold(f64::MIN_POSITIVE, f64::max);
        Self {
            latched: plant.outputs().latches().iter().map(|latch| latch.closed.is_on()).collect(),
            travels: plant.outputs().joints().iter().map(|joint| joint.angle_rad).collect(),
            ends: ends.iter().map(|end| end / size_m).collect(),
        }
    }

    fn distance(&self, other: &Self) -> f64 {
        let turns = self.travels.iter().zip(&other.travels).map(|(a, b)| (a - b).abs());
        let ways = self.ends.iter().zip(&other.ends).map(|(a, b)| (a - b).norm());
        turns.chain(ways).fold(0.0, f64::max)
    }
}

impl Found {
    /// Returns whether a mode is unstable at the first speed.
    fn unstable_from_first(&self) -> bool {
        self.branches.places.first().is_some_and(|place| place.modes.iter().flatten().any(ModeShape::grows))
    }

    /// Describes the changes between the speed before `speed_m_s` and `speed_m_s`, for a row of a table.
    fn changes_up_to(&self, speed_m_s: f64) -> String {
        let places = &self.branches.places;
        let before = places.iter().rev().map(|place| place.at).find(|at| *at < speed_m_s).unwrap_or(0.0);
        let own = self.changes.iter().filter(|change| (before..speed_m_s).contains(&change.between_m_s[0]));
        own.map(|change| change.kind.name()).collect::<Vec<_>>().join(" ")
    }

    /// Number of modes tracked.
    fn tracked(&self) -> usize {
        self.branches.places.first().map_or(0, |place| place.modes.len())
    }

    /// Returns the flutter speeds in m/s, with branch and mode.
    pub fn flutter(&self) -> impl Iterator<Item = &Crossing<ModeShape>> {
        self.crossings.iter().filter(|crossing| crossing.begins && !crossing.mode.is_real())
    }
}

/// Computes flutter and divergence of a model.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let speeds_m_s = speeds(&arguments.wind_m_s)?;
    let mut outlets = Outlets::new(arguments.force.force, [arguments.model.as_path()]);
    arguments.branches.check(&outlets)?;
    let varied = Varied::new(&arguments.model, &arguments.settings, arguments.over.as_ref())?;
    if let Some(doubt) = implausible::flow(varied.machine()) {
        tell::warning(&doubt);
    }
    let values = varied.values();
    let count = usize::from(arguments.count);
    let mut list = Vec::new();
    for value in &values {
        list.push(sweep(varied.plant(value)?, &speeds_m_s, count)?);
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
                let change = row[quantity].parse().map_or(String::new(), |speed_m_s| found.changes_up_to(speed_m_s));
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
        let entries = list.iter().zip(&values).map(|(found, value)| as_json(found, key.map(|_| value.as_str())));
        let value = json!({ "name": name, "over": key, "results": entries.collect::<Vec<_>>() });
        return print(&format!("{value:#}"));
    }
    let mut text = String::new();
    for (found, value) in list.iter().zip(&values) {
        if let Some(key) = key {
            let _ = writeln!(text, "{key} = {value}");
        }
        text.push_str(&summary(found, &speeds_m_s));
    }
    if let (None, Some(table)) = (key, tables.first()) {
        text = format!("{name} in a wind of {} m/s\n{}\n{}", arguments.wind_m_s, table.text(), text);
    }
    print(&text)
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
    if speeds.len() as f64 > MAXIMUM_SPEEDS {
        return Err(refused(format!("{} speeds are more than {MAXIMUM_SPEEDS}", speeds.len())));
    }
    Ok(speeds)
}

/// Computes modes over the speed, crossings and divergence of a plant that is not yet initialised.
pub(super) fn sweep(mut plant: Plant, speeds_m_s: &[f64], count: usize) -> Result<Found, Failure> {
    let direction = wind(plant.machine(), &plant)?;
    let mut signs: Vec<(f64, Option<bool>)> = Vec::new();
    let mut postures: Vec<(f64, Posture)> = Vec::new();
    let rest = |plant: &mut Plant, speed_m_s: f64| -> Result<Posture, PlantError> {
        *plant.inputs_mut().wind_m_s_mut() = direction * speed_m_s;
        let time_s = plant.machine().experiment.start_time_s;
        plant.study().equilibrium(time_s, Holding::AsReleased)?;
        Ok(Posture::of(plant))
    };
    let mut at = |speed_m_s: f64| -> Result<(Vec<ModeShape>, Option<bool>), PlantError> {
        let posture = rest(&mut plant, speed_m_s)?;
        postures.push((speed_m_s, posture));
        if plant.has_linear_lattice() {
            return plant.study().lattice_modes_and_rest(pool(count));
        }
        plant.study().modes_and_rest(pool(count))
    };
    let (mut branches, ended) = Branches::follow(speeds_m_s, &mut |speed_m_s| {
        let (modes, sign) = at(speed_m_s)?;
        signs.push((speed_m_s, sign));
        Ok(modes)
    });
    let ended = ended.map(|(speed_m_s, error): (f64, PlantError)| (speed_m_s, error.to_string()));
    if let (true, Some((speed_m_s, message))) = (branches.places.is_empty(), &ended) {
        return Err(Failure::Statics(format!("at {speed_m_s} m/s: {message}")));
    }
    let mut crossings = branches.crossings(&mut |speed_m_s| at(speed_m_s).map(|(modes, _)| modes));
    branches.keep(count, &mut crossings);
    signs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut divergence_m_s, mut changes) = (Vec::new(), Vec::new());
    for pair in signs.windows(2) {
        if let [(low, Some(low_sign)), (high, Some(high_sign))] = *pair
            && low_sign != high_sign
        {
            let mut sign = |speed_m_s| at(speed_m_s).map(|(_, sign)| sign);
            match change_of_sign([low, high], low_sign, &mut sign) {
                Some(speed_m_s) => divergence_m_s.push(speed_m_s),
                None => changes.push(Change {
                    between_m_s: [low, high],
                    kind: Kind::Divergence,
                    text: "the static stiffness changes its sign, at a speed not found: divergence, or another branch of equilibria"
                        .to_owned(),
                }),
            }
        }
    }
    postures.retain(|(speed_m_s, _)| signs.iter().any(|(known, _)| known == speed_m_s));
    postures.sort_by(|a, b| a.0.total_cmp(&b.0));
    postures.dedup_by(|a, b| a.0 == b.0);
    for pair in postures.windows(2) {
        changes.extend(jump(&mut plant, [&pair[0], &pair[1]], &mut |plant, speed_m_s| rest(plant, speed_m_s).ok()));
    }
    let jumps: Vec<[f64; 2]> =
        changes.iter().filter(|change| change.kind != Kind::Divergence).map(|change| change.between_m_s).collect();
    // at a jump, sign and growth rate change without a zero: it is not a speed of flutter or divergence
    let inside = |speed_m_s: f64| jumps.iter().any(|[low, high]| (*low..=*high).contains(&speed_m_s));
    divergence_m_s.retain(|speed_m_s| !inside(*speed_m_s));
    crossings.retain(|crossing| !inside(crossing.at));
    for (branch, [low, high], mode) in branches.beginnings() {
        let within = |speed_m_s: f64| (low..=high).contains(&speed_m_s);
        let named = match mode.is_real() {
            true => divergence_m_s.iter().any(|speed_m_s| within(*speed_m_s)),
            false => {
                crossings.iter().any(|crossing| crossing.branch == branch && crossing.begins && within(crossing.at))
            }
        };
        if !named {
            let how = match mode.is_real() {
                true => "not oscillating".to_owned(),
                false => format!("at {:.4} Hz", mode.frequency_hz),
            };
            changes.push(Change {
                between_m_s: [low, high],
                kind: Kind::Unstable,
                text: format!(
                    "mode {} becomes unstable: growth rate {:.4} 1/s, {how}",
                    branch + 1,
                    mode.eigenvalue_1_s.re
                ),
            });
        }
    }
    changes.sort_by(|a, b| a.between_m_s[0].total_cmp(&b.between_m_s[0]));
    Ok(Found { branches, crossings, divergence_m_s, changes, ended })
}

/// Returns a jump of the equilibrium between two speeds, by bisection; `None` if the equilibrium is continuous. Latches that open or close
/// count as a jump even if nothing else changes.
fn jump(
    plant: &mut Plant,
    [low, high]: [&(f64, Posture); 2],
    rest: &mut dyn FnMut(&mut Plant, f64) -> Option<Posture>,
) -> Option<Change> {
    let (mut low, mut high) = (low.clone(), high.clone());
    let latches = low.1.latched != high.1.latched;
    let whole = low.1.distance(&high.1);
    if !latches && whole < NEAR {
        return None;
    }
    let mut lost = false;
    for _ in 0..HALVINGS {
        let middle_m_s = 0.5 * (low.0 + high.0);
        let Some(middle) = rest(plant, middle_m_s) else {
            lost = true;
            break;
        };
        let to_low = match latches {
            true => middle.latched != low.1.latched,
            false => low.1.distance(&middle) > middle.distance(&high.1),
        };
        *(if to_low { &mut high } else { &mut low }) = (middle_m_s, middle);
        if !latches && low.1.distance(&high.1) < JUMPS * whole {
            return None;
        }
    }
    let machine = plant.machine();
    let joints: Vec<_> = machine
        .bodies
        .iter()
        .filter_map(|body| body.joint.kind.one_freedom().map(|(travel, _)| (travel, body.joint.name.as_str())))
        .collect();
    let mut parts = Vec::new();
    for (i, (travel, name)) in joints.iter().enumerate() {
        let [before, after] = [&low.1, &high.1].map(|posture| (posture.latched[i], posture.travels[i]));
        if before.0 != after.0 {
            parts.push(format!("the latch of {name} {}", if after.0 { "closes" } else { "opens" }));
        }
        if (before.1 - after.1).abs() >= NEAR {
            let [from, to] = [before.1, after.1].map(|value| travel.shown(value));
            parts.push(format!("{name} goes from {from:.3} to {to:.3} {}", travel.shown_unit()));
        }
    }
    if lost {
        parts.push("no equilibrium in between".to_owned());
    }
    let kind = if latches { Kind::Latch } else { Kind::Jump };
    let begin = match kind {
        Kind::Latch => "the configuration changes, and the modes with it",
        Kind::Jump | Kind::Unstable | Kind::Divergence => {
            "the equilibrium jumps, as beyond divergence of a wing under load"
        }
    };
    let separator = if parts.is_empty() { "" } else { ": " };
    Some(Change { between_m_s: [low.0, high.0], kind, text: format!("{begin}{separator}{}", parts.join(", ")) })
}

/// Returns the wind direction; fails for machines without wind.
fn wind(machine: &Machine, plant: &Plant) -> Result<Vector3<f64>, Failure> {
    let refused = |cause: &str| Failure::Usage(format!("{}: {cause}", machine.name));
    let Some(air) = &machine.air else {
        return Err(refused("has no air; flutter needs [aerodynamics] with model = \"strip\" and surfaces"));
    };
    if air.options.is_rotor() {
        return Err(refused(
            "has rotor aerodynamics, which flutter does not support; use strips or a lattice (aerodynamics.model = \"strip\" or \"uvlm\"), \
             or simulate the response to a gust",
        ));
    }
    if !air.established {
        return Err(refused(
            "aerodynamics.steady_initial_flow = false: flutter needs the developed flow; omit the key",
        ));
    }
    let direction = plant.inputs().wind_m_s().try_normalize(0.0);
    direction.ok_or_else(|| {
        refused("has no wind to give the direction; set aerodynamics.wind_m_s, or --set wind.velocity.y=-1")
    })
}

/// Describes flutter and divergence as text.
fn summary(found: &Found, speeds_m_s: &[f64]) -> String {
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
    if found.unstable_from_first() {
        let _ = writeln!(text, "unstable from the first speed on, {} m/s: start at a lower one", speeds_m_s[0]);
    }
    let last = found.branches.places.last().map_or(0.0, |place| place.at);
    if text.is_empty() && found.changes.iter().all(|change| change.kind == Kind::Latch) {
        let _ = writeln!(text, "neither flutter nor divergence up to {last} m/s");
    }
    for Change { between_m_s: [low, high], text: what, .. } in &found.changes {
        let _ = writeln!(text, "between {low:.6} and {high:.6} m/s: {what}");
    }
    let _ = write!(text, "{} modes tracked from {} to {last} m/s", found.tracked(), speeds_m_s[0]);
    if let Some((speed_m_s, message)) = &found.ended {
        let _ = write!(text, "; the sweep ends before {speed_m_s} m/s: {message}");
    }
    text.push('\n');
    text
}

/// Speeds marked in the figures.
fn marks(found: &Found) -> Vec<(f64, String)> {
    let flutter = found.flutter().map(|crossing| (crossing.at, format!("flutter {:.4} m/s", crossing.at)));
    let divergence = found.divergence_m_s.iter().map(|speed| (*speed, format!("divergence {speed:.4} m/s")));
    flutter.chain(divergence).collect()
}

/// Figure of the lowest speeds of flutter and divergence over a parameter; `None` if its values are not numbers.
fn map(name: &str, key: &str, values: &[String], list: &[Found]) -> Option<Figure> {
    let at: Option<Vec<f64>> = values.iter().map(|value| value.parse().ok()).collect();
    let at = at?;
    let curve = |n: usize, what: &str, speed: &dyn Fn(&Found) -> Option<f64>| {
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
        marks: Vec::new(),
        equal: false,
    })
}

/// Returns the results as JSON.
pub(super) fn as_json(found: &Found, value: Option<&str>) -> Value {
    let crossing = |crossing: &Crossing<ModeShape>| {
        json!({
            "speed_m_s": crossing.at,
            "frequency_Hz": crossing.mode.frequency_hz,
            "mode": crossing.branch + 1,
            "begins": crossing.begins,
        })
    };
    let oscillating = found.crossings.iter().filter(|crossing| !crossing.mode.is_real());
    let places: Vec<Value> = found
        .branches
        .places
        .iter()
        .map(|place| {
            let mode =
                |mode: &Option<ModeShape>| mode.as_ref().map(|mode| [mode.eigenvalue_1_s.re, mode.eigenvalue_1_s.im]);
            json!({ "speed_m_s": place.at, "eigenvalues_1_s": place.modes.iter().map(mode).collect::<Vec<_>>() })
        })
        .collect();
    json!({
        "value": value,
        "flutter": oscillating.map(crossing).collect::<Vec<_>>(),
        "divergence_m_s": found.divergence_m_s,
        "changes": found.changes.iter().map(|change| json!({
            "kind": change.kind.name(), "between_m_s": change.between_m_s, "text": change.text,
        })).collect::<Vec<_>>(),
        "unstable_from_first": found.unstable_from_first(),
        "modes_tracked": found.tracked(),
        "covered_m_s": found.branches.places.first().zip(found.branches.places.last()).map(|(first, last)| [first.at, last.at]),
        "ended": found.ended.as_ref().map(|(speed, message)| json!({ "speed_m_s": speed, "message": message })),
        "modes": places,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both ends belong to the range; invalid texts are errors.
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
