//! `foldwing periodic`: the periodic steady state of a rotor, its harmonics, and its Floquet modes.

use crate::cli::outlets::{Force, Mark, Outlets, Quiet};
use crate::cli::periodic_tables::{csv_text, label, modes_text};
use crate::cli::progress::Progress;
use crate::cli::settings::settings_of_turning;
use crate::cli::{Failure, read_model, shapes};
use crate::report::inputs::name_message;
use clap::builder::NonEmptyStringValueParser;
use foldwing_fmi::interface::Variable;
use foldwing_study::periodic::{Options, Periodic, PeriodicError, Series, find_watched};
use foldwing_study::values::SettingError;
use serde_json::json;
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::PERIODIC)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Speed of the shaft in rpm [default: its prescribed or initial speed]
    #[arg(long, value_name = "RPM", allow_negative_numbers = true)]
    speed_rpm: Option<f64>,
    /// Joint that is the shaft [default: the only joint that can rotate without limit and carries a hub]
    #[arg(long, value_name = "JOINT", value_parser = NonEmptyStringValueParser::new())]
    shaft: Option<String>,
    /// Start value of an input or parameter, e.g. `wind.velocity.x=8`; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Steps per revolution, rounded up to a multiple of 144
    #[arg(long, default_value_t = 720)]
    steps: usize,
    /// Periodicity tolerance: allowed difference between start and end of the revolution, as rotation in rad or displacement divided by the
    /// length of the model
    #[arg(long = "tolerance", default_value = "1e-8")]
    accuracy: f64,
    /// Outputs in the tables: names or patterns, separated by commas [default: deflections, angles and rotor outputs; files contain all
    /// outputs]
    #[arg(long = "variables", value_name = "NAME")]
    outputs: Vec<String>,
    /// Number of harmonics of the rotor speed in the table
    #[arg(long, default_value_t = 3)]
    harmonics: usize,
    /// Number of Floquet modes; 0 omits them
    #[arg(long, default_value_t = 10)]
    count: usize,
    /// Maximum number of perturbations integrated for the Floquet modes, two revolutions each
    #[arg(long = "perturbations", default_value_t = 120)]
    directions: usize,
    /// CSV file for the outputs over the revolution
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,
    /// HTML page with the animated Floquet modes about the periodic motion: one file, no network needed
    #[arg(long, value_name = "OUT.html")]
    view: Option<PathBuf>,
    /// Print JSON for programs
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    force: Force,
    #[command(flatten)]
    quiet: Quiet,
}

/// Default outputs in the text, if the model has them.
const SHOWN: [&str; 5] = ["*.deflection.*", "*.angle", "rotor.*", "tip.position.*", "*.holding_torque"];

/// Computes the periodic steady state and prints it.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (machine, _) = read_model(&arguments.model)?;
    let speed_rad_s = arguments.speed_rpm.map(|speed_rpm| speed_rpm * PI / 30.0);
    let turning = (arguments.shaft.as_deref(), speed_rad_s, arguments.steps);
    let options = Options {
        speed_rpm: arguments.speed_rpm,
        shaft: arguments.shaft.clone(),
        settings: settings_of_turning(&machine, turning, &arguments.settings)?,
        steps: arguments.steps,
        tolerance: arguments.accuracy,
        outputs: arguments.outputs.clone(),
        harmonics: arguments.harmonics,
        count: arguments.count,
        perturbations: arguments.directions,
    };
    let named = !arguments.outputs.is_empty();
    let mut outlets = Outlets::new(arguments.force.force, [arguments.model.as_path()]);
    if arguments.view.is_some() && arguments.count == 0 {
        return Err(Failure::Usage(
            "--view shows the Floquet modes, which --count 0 omits; use a larger --count".to_owned(),
        ));
    }
    let view = outlets.place_if(arguments.view.as_deref(), Mark::PAGE)?;
    let found = find_watched(&machine, &options, &mut Progress::phase("periodic state").watch()).map_err(failure)?;
    if arguments.view.is_some() {
        view.fill(shapes::page(&shapes::of_periodic(&machine, &options, &found)?)?.as_bytes())?;
    }
    let Periodic { machine: name, turn, motion, outputs: series, floquet, .. } = &found;
    if let Some(path) = &arguments.csv {
        let text = csv_text(series, turn.speed_rad_s.signum());
        outlets.place(path, Mark::first_line(&text))?.fill(&text)?;
    }
    if arguments.json {
        return arguments.quiet.print(&format!("{:#}", json!(found)), &outlets);
    }
    let shown: Vec<&Series> = match named {
        true => series.iter().collect(),
        false => {
            let patterns: Vec<wildmatch::WildMatch> =
                SHOWN.iter().map(|word| wildmatch::WildMatch::new(word)).collect();
            let wanted =
                |series: &&Series| !series.is_zero() && patterns.iter().any(|pattern| pattern.matches(&series.name));
            series.iter().filter(wanted).collect()
        }
    };
    let mut text = format!(
        "{name}: periodic at {:.6} rpm, a revolution of {:.6} s in {} steps\n{} states; periodic to {:.1e} after {} Newton steps and {} revolutions\n\n",
        turn.speed_rad_s * 30.0 / PI,
        turn.period_s(),
        turn.steps,
        motion.states,
        motion.distance,
        motion.newton_steps,
        motion.turns
    );
    harmonics_text(&shown, arguments.harmonics, &mut text);
    if let Some(floquet) = floquet {
        modes_text(floquet, arguments.count, &mut text);
    }
    arguments.quiet.print(&text, &outlets)
}

/// Converts the error of the search to a message of the command.
pub(super) fn failure(error: PeriodicError) -> Failure {
    let text = error.to_string();
    match error {
        PeriodicError::Harmonics { .. } | PeriodicError::Tolerance { .. } => Failure::Usage(format!("--{text}")),
        PeriodicError::NoPerturbations => {
            Failure::Usage("--perturbations 0: modes need at least 1; --count 0 omits the modes".to_owned())
        }
        PeriodicError::Name(error) | PeriodicError::Setting(SettingError::Name(error)) => {
            Failure::Usage(name_message::<Variable>(&error))
        }
        PeriodicError::Setting(SettingError::Value(_)) => Failure::Usage(text),
        PeriodicError::NoTurn { .. } | PeriodicError::Plant(_) | PeriodicError::Stopped => Failure::Statics(text),
    }
}

/// Appends mean, amplitude and harmonics of the outputs, one line each.
fn harmonics_text(shown: &[&Series], count: usize, text: &mut String) {
    let width = shown.iter().map(|series| label(series).chars().count()).max().unwrap_or(0).max(6);
    let _ = write!(text, "{:width$} {:>13} {:>12}", "output", "mean", "half range");
    (1..=count).for_each(|n| {
        let _ = write!(text, " {:>12}", format!("{n}P"));
    });
    text.push('\n');
    let mut left_out = Vec::new();
    for series in shown {
        if !series.is_periodic() {
            left_out.push(format!("{} ({:.1e})", label(series), series.drift()));
            continue;
        }
        let _ = write!(text, "{:width$} {:13.6e} {:12.4e}", label(series), series.harmonic(0)[0], series.half_range());
        (1..=count).for_each(|n| {
            let _ = write!(text, " {:12.4e}", series.harmonic(n)[0]);
        });
        text.push('\n');
    }
    if !left_out.is_empty() {
        let _ = writeln!(
            text,
            "not periodic within --tolerance, harmonics omitted (change over the revolution): {}",
            left_out.join(", ")
        );
    }
}
