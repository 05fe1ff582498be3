//! `foldwing modes --vary rotor_speed_rpm=…`: the Campbell diagram of a rotor, with named whirl modes.

use crate::cli::branches::{BranchArguments, BranchTable, csv_text, numbers, write_figures};
use crate::cli::outlets::{Mark, Outlets, Quiet};
use crate::cli::progress::Progress;
use crate::cli::settings::typed_settings;
use crate::cli::sweep::axis;
use crate::cli::{Failure, read_model};
use crate::report::figure::{Curve, Figure, Look};
use crate::report::inputs::name_message;
use foldwing_fmi::interface::Variable;
use foldwing_study::campbell::{Campbell, CampbellError, Options, over_speed_watched};
use foldwing_study::values::SettingError;
use std::fmt::Write;
use std::path::Path;

/// Key of the rotor speed in `--vary`.
pub(super) const KEY: &str = "rotor_speed_rpm";
/// Multiples of the rotor frequency in the diagram in addition to 1P, in units of the number of blades.
const PER_BLADES: [usize; 2] = [1, 2];
/// Colour of the lines at these multiples.
const FAINT: [u8; 3] = [110, 122, 134];

/// Arguments of the diagram.
pub(super) struct Asked<'a> {
    /// Model file.
    pub model: &'a Path,
    /// Values of `--set`.
    pub settings: &'a [String],
    /// Values of the key.
    pub values: &'a str,
    /// Joint that is the shaft, if given.
    pub shaft: Option<&'a str>,
    /// Without loads, gravity, root motion and aerodynamics; otherwise modes are computed about the periodic state if
    /// any of these acts.
    pub bare: bool,
    /// Number of modes.
    pub count: usize,
    /// Output files.
    pub branches: &'a BranchArguments,
    /// JSON instead of the table.
    pub json: bool,
    /// Print only the result.
    pub quiet: Quiet,
}

/// Tracks the modes of the model over a range of rotor speeds, and prints them.
pub(super) fn run(asked: &Asked, outlets: &mut Outlets) -> Result<(), Failure> {
    asked.branches.check(outlets)?;
    let values =
        axis(asked.values).map_err(|cause| Failure::Usage(format!("--vary {KEY}={}: {cause}", asked.values)))?;
    let (machine, _) = read_model(asked.model)?;
    let options = Options {
        speed_rpm: numbers(KEY, &values)?,
        shaft: asked.shaft.map(str::to_owned),
        undeformed: asked.bare,
        count: asked.count,
        settings: typed_settings(&machine, asked.settings)?,
    };
    let has_air = machine.air.is_some();
    let mut progress = Progress::of("rotor speeds", options.speed_rpm.len() as u64);
    let found = over_speed_watched(machine, &options, &mut progress.watch());
    drop(progress);
    let Campbell { machine: name, blades, branches, disturbance, ended } = found.map_err(failure)?;
    if let Some(disturbance) = &disturbance {
        asked.quiet.note(&format!(
            "{disturbance}: the steady state is periodic, and the modes are Floquet modes about it, with the shaft at constant speed"
        ));
    }
    let table = BranchTable { quantity: KEY, unit: "", branches: &branches };
    if let Some(path) = &asked.branches.csv {
        let text = csv_text(&table.header(None), &table.rows(None));
        outlets.place(path, Mark::first_line(&text))?.fill(&text)?;
    }
    let mut figures = table.figures(&name, &[]);
    if let Some((_, mut diagram)) = figures.iter().position(|(stem, _)| *stem == "frequency").map(|i| figures.remove(i))
    {
        add_multiples(&mut diagram, blades, &options.speed_rpm);
        diagram.title = format!("{name}: Campbell diagram");
        diagram.x_label = "rotor speed (rpm)".to_owned();
        figures.push(("campbell", diagram));
    }
    write_figures(asked.branches, figures, outlets)?;
    let ended = ended.map(|(value, error)| (value, error.to_string()));
    if asked.json {
        return asked.quiet.print(&format!("{:#}", table.json(&name, ended)), outlets);
    }
    if let Some((value, error)) = ended {
        asked.quiet.note(&format!("mode tracking ends before {KEY} = {value}: {error}"));
    }
    let how = match (disturbance.is_some(), has_air) {
        (false, _) => "without aerodynamics",
        (true, false) => "about the periodic steady state",
        (true, true) => "about the periodic steady state, with aerodynamics",
    };
    let mut text = format!("{name}: modes versus rotor speed, in the fixed frame, {how}\n{}", table.text());
    for branch in 0..branches.places.first().map_or(0, |place| place.modes.len()) {
        let list = table.motions(branch);
        let words: Vec<String> = match &list[..] {
            [(_, only)] => vec![only.clone()],
            _ => list.iter().map(|(at, name)| format!("from {at} rpm {name}")).collect(),
        };
        let _ = writeln!(text, "mode {}: {}", branch + 1, words.join(", "));
    }
    asked.quiet.print(&text, outlets)
}

/// Adds the lines of the rotor frequency and its multiples to a Campbell diagram.
fn add_multiples(diagram: &mut Figure, blades: usize, speeds_rpm: &[f64]) {
    let highest = diagram.curves.iter().flat_map(|curve| &curve.points).map(|point| point[1]).fold(0.0, f64::max);
    let last = speeds_rpm.iter().fold(0.0f64, |last, speed| last.max(speed.abs()));
    for multiple in std::iter::once(1).chain(PER_BLADES.map(|times| times * blades)) {
        let per_rpm = multiple as f64 / 60.0;
        // the lines end at the highest frequency of the modes
        let end = if per_rpm * last > highest { highest / per_rpm } else { last };
        let first = speeds_rpm.iter().fold(f64::INFINITY, |first, speed| first.min(speed.abs()));
        if end > first {
            let points = vec![[first, per_rpm * first], [end, per_rpm * end]];
            diagram.curves.insert(0, Curve { name: format!("{multiple}P"), colour: FAINT, look: Look::Dashed, points });
        }
    }
}

/// Converts the error of a diagram to a message of the command.
fn failure(error: CampbellError) -> Failure {
    match error {
        CampbellError::Speeds => {
            Failure::Usage(format!("--vary {KEY}: needs two or more values in ascending or descending order"))
        }
        CampbellError::Setting(SettingError::Name(error)) => Failure::Usage(name_message::<Variable>(&error)),
        CampbellError::Setting(SettingError::Value(error)) => Failure::Usage(error.to_string()),
        CampbellError::Plant(_) | CampbellError::NoTurn { .. } | CampbellError::Stopped => {
            Failure::Statics(error.to_string())
        }
        CampbellError::FirstSpeed { speed_rpm, error } => {
            Failure::Statics(format!("--vary {KEY}, at {speed_rpm}: {}", failure(*error)))
        }
    }
}
