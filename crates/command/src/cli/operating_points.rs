//! `foldwing operating-points`: power, thrust and loads of a rotor over wind speed, rotor speed and pitch, optionally solving for pitch
//! or rotor speed.

use crate::cli::branches::csv_text;
use crate::cli::operating_table::{as_json, cells, header, rows_text, shown};
use crate::cli::outlets::{Force, Mark, Outlets, Quiet};
use crate::cli::progress::Progress;
use crate::cli::settings::settings_of_turning;
use crate::cli::sweep::axis;
use crate::cli::{Failure, read_model};
use crate::report::inputs::name_message;
use clap::builder::NonEmptyStringValueParser;
use foldwing_fmi::interface::Variable;
use foldwing_study::operating_points::{
    List, Options, PointError, PointsError, Search, Target, Unknown, tabulate_watched,
};
use foldwing_study::values::SettingError;
use std::path::PathBuf;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::OPERATING_POINTS)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Wind speeds in m/s, along the wind of the model: A,B,… or FROM:TO:COUNT
    #[arg(long, value_name = "VALUES", required = true)]
    wind_m_s: String,
    /// Rotor speeds in rpm; with --tip-speed-ratio the maximum speed [default: the speed in the model]
    #[arg(long, value_name = "VALUES", allow_negative_numbers = true)]
    speed_rpm: Option<String>,
    /// Tip speed ratio, from which the rotor speed follows
    #[arg(long, value_name = "RATIO")]
    tip_speed_ratio: Option<f64>,
    /// Pitch angles of all blades in degrees, positive about the axes of the pitch joints [default: the angle in the model]
    #[arg(long, value_name = "VALUES", allow_negative_numbers = true)]
    pitch_deg: Option<String>,
    /// Combine the lists value by value (a list with one value applies to all) [default: all combinations]
    #[arg(long)]
    paired: bool,
    /// Quantity to solve for, with its range: `pitch_deg=0:90` or `speed_rpm=6:14`
    #[arg(long = "solve-for", value_name = "KEY=FROM:TO", requires = "hold", value_parser = NonEmptyStringValueParser::new())]
    find: Option<String>,
    /// Target value of the mean of an output, e.g. `rotor.power=5.3e6`; if the output is below the target at FROM, FROM is used
    #[arg(long = "target", value_name = "OUTPUT=VALUE", requires = "find", value_parser = NonEmptyStringValueParser::new())]
    hold: Option<String>,
    /// Joint that is the shaft [default: the only joint that can rotate without limit and carries a hub]
    #[arg(long, value_name = "JOINT", value_parser = NonEmptyStringValueParser::new())]
    shaft: Option<String>,
    /// Joints that pitch the blades, separated by commas [default: the joints between hub and blades]
    #[arg(long, value_name = "JOINTS", value_parser = NonEmptyStringValueParser::new())]
    pitch_joints: Option<String>,
    /// Start value of an input or parameter; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Outputs in the table: names or patterns, separated by commas [default: rotor outputs, deflection and root loads of the first blade
    /// and of other bodies, holding torque of the shaft]
    #[arg(long = "variables", value_name = "NAME")]
    outputs: Vec<String>,
    /// Steps per revolution of a periodic steady state, rounded up to a multiple of 144
    #[arg(long, default_value_t = 720)]
    steps: usize,
    /// Periodicity tolerance: allowed difference between start and end of a revolution, as rotation in rad or displacement divided by the
    /// length of the model
    #[arg(long = "tolerance", default_value = "1e-6")]
    accuracy: f64,
    /// CSV file with means and peak-to-peak values of all outputs
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,
    /// Print JSON for programs
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    force: Force,
    #[command(flatten)]
    quiet: Quiet,
}

/// Computes the points and prints them.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (machine, _) = read_model(&arguments.model)?;
    let list = |option: &str, text: &Option<String>| text.as_ref().map(|text| values(option, text)).transpose();
    let options = Options {
        wind_m_s: values("--wind-m-s", &arguments.wind_m_s)?,
        speed_rpm: list("--speed-rpm", &arguments.speed_rpm)?,
        tip_speed_ratio: arguments.tip_speed_ratio,
        pitch_deg: list("--pitch-deg", &arguments.pitch_deg)?,
        paired: arguments.paired,
        search: match (&arguments.find, &arguments.hold) {
            (Some(find), Some(hold)) => Some(Search { unknown: unknown(find)?, target: target(hold)? }),
            _ => None,
        },
        shaft: arguments.shaft.clone(),
        pitch_joints: arguments
            .pitch_joints
            .as_ref()
            .map(|names| names.split(',').map(|name| name.trim().to_owned()).collect()),
        settings: settings_of_turning(
            &machine,
            (arguments.shaft.as_deref(), Some(1.0), arguments.steps),
            &arguments.settings,
        )?,
        outputs: arguments.outputs.clone(),
        steps: arguments.steps,
        tolerance: arguments.accuracy,
    };
    let mut outlets = Outlets::new(arguments.force.force, [arguments.model.as_path()]);
    let mut progress = Progress::phase("operating points");
    let table = tabulate_watched(machine, &options, &mut progress.watch()).map_err(|error| arguments.failure(error))?;
    drop(progress);
    let words = |error: &PointError| arguments.words(error);
    if let Some(path) = &arguments.csv {
        let rows: Vec<Vec<String>> = table.points.iter().map(|point| cells(point, &words)).collect();
        let text = csv_text(&header(&table.outputs), &rows);
        outlets.place(path, Mark::first_line(&text))?.fill(&text)?;
    }
    for (point, error) in table.points.iter().filter_map(|point| Some((point, point.state.as_ref().err()?))) {
        arguments.quiet.note(&format!("no state at {} m/s: {}", point.wind_m_s, words(error)));
    }
    if arguments.json {
        return arguments.quiet.print(&format!("{:#}", as_json(&table, &words)), &outlets);
    }
    let named = !arguments.outputs.is_empty();
    arguments.quiet.print(&rows_text(&table, &shown(&table, named)), &outlets)
}

impl Arguments {
    /// Converts the error of a table to a message of the command.
    fn failure(&self, error: PointsError) -> Failure {
        let option = |list: List| format!("--{}", list.name().replace('_', "-"));
        let text = error.to_string();
        Failure::Usage(match error {
            PointsError::Point(error) => return Failure::Statics(self.words(&error)),
            PointsError::Stopped => return Failure::Statics(text),
            PointsError::Name(error) | PointsError::Setting(SettingError::Name(error)) => {
                name_message::<Variable>(&error)
            }
            PointsError::Empty { list } => format!("{}: has no value", option(list)),
            PointsError::NotFinite { list, value } => format!("{} {value}: must be finite numbers", option(list)),
            PointsError::NegativeWind { .. } => text.replacen("wind_m_s", "--wind-m-s", 1),
            PointsError::TipSpeedRatio { .. } => text.replacen("tip_speed_ratio", "--tip-speed-ratio", 1),
            PointsError::Tolerance { .. } => text.replacen("tolerance", "--tolerance", 1),
            PointsError::SeveralSpeeds => {
                "--speed-rpm: with --tip-speed-ratio only one value is allowed, the maximum speed".to_owned()
            }
            PointsError::NoRadius => {
                "--tip-speed-ratio: needs rotor aerodynamics (aerodynamics.model = \"bem\"); give --speed-rpm"
                    .to_owned()
            }
            PointsError::Unpaired { list, count, longest } => format!(
                "--paired: {} has {count} values and another list {longest}; paired lists need the same length, or one value",
                option(list)
            ),
            PointsError::Range { .. } => refused_range(self.find.as_deref().unwrap_or_default()),
            PointsError::TargetNotFinite { .. } => refused_target(self.hold.as_deref().unwrap_or_default()),
            PointsError::NotAnOutput { .. } => {
                format!("--target {}: is not a real output", self.hold.as_deref().unwrap_or_default())
            }
            PointsError::SoughtAndGiven { unknown } => format!(
                "--solve-for {}: it is the unknown, so omit {}",
                self.find.as_deref().unwrap_or_default(),
                if unknown.is_pitch() { "--pitch-deg" } else { "--speed-rpm" }
            ),
            PointsError::NoWind { machine } => format!(
                "{machine}: the model has no wind, so its direction is undefined; set aerodynamics.wind_m_s, or --set \
                 wind.velocity.x=1"
            ),
            PointsError::NoPitchJoints { machine } => format!(
                "{machine}: no revolute joints connect the blades to the hub, so the pitch cannot be set; name the \
                 pitch joints with --pitch-joints"
            ),
            PointsError::PitchJoint { joint } => format!(
                "--pitch-joints {}: the model has no revolute joint {joint:?}",
                self.pitch_joints.as_deref().unwrap_or_default()
            ),
            PointsError::TooMany { .. }
            | PointsError::NoAir { .. }
            | PointsError::LoosePitch { .. }
            | PointsError::Setting(SettingError::Value(_)) => text,
        })
    }

    /// Reason why a point has no solution, as a message of the command.
    fn words(&self, error: &PointError) -> String {
        let target = self.hold.as_deref().unwrap_or_default();
        match error {
            PointError::NoTurn { .. } | PointError::Plant(_) => error.to_string(),
            PointError::AboveTarget { output, from, to, excess, .. } => format!(
                "--target {target}: {output} is above the target everywhere from {from} to {to}, by {excess:.6e} at \
                 the end; extend the range of --solve-for"
            ),
            PointError::NotHeld { .. } => format!("--target {target}: no value was found that reaches the target"),
        }
    }
}

/// Parses `pitch_deg=FROM:TO` or `speed_rpm=FROM:TO`.
fn unknown(text: &str) -> Result<Unknown, Failure> {
    let refused = || Failure::Usage(refused_range(text));
    let (key, range) = text.split_once('=').ok_or_else(refused)?;
    let (from, to) = range.split_once(':').ok_or_else(refused)?;
    let number = |text: &str| text.trim().parse::<f64>().map_err(|_| refused());
    let (from, to) = (number(from)?, number(to)?);
    match key {
        "pitch_deg" => Ok(Unknown::PitchDeg { from, to }),
        "speed_rpm" => Ok(Unknown::SpeedRpm { from, to }),
        _ => Err(refused()),
    }
}

fn refused_range(text: &str) -> String {
    format!("--solve-for {text}: must be pitch_deg=FROM:TO or speed_rpm=FROM:TO with two different finite numbers")
}

/// Parses `OUTPUT=VALUE`.
fn target(text: &str) -> Result<Target, Failure> {
    let refused = || Failure::Usage(refused_target(text));
    let (output, value) = text.split_once('=').ok_or_else(refused)?;
    let value = value.trim().parse().map_err(|_| refused())?;
    Ok(Target { output: output.to_owned(), value })
}

fn refused_target(text: &str) -> String {
    format!("--target {text}: must be OUTPUT=VALUE with a finite number in SI units")
}

/// Parses the numbers of a list or range.
fn values(option: &str, text: &str) -> Result<Vec<f64>, Failure> {
    let refused = |cause: String| Failure::Usage(format!("{option} {text}: {cause}"));
    let number = |value: &String| match value.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(refused(format!("`{value}` is not a finite number"))),
    };
    axis(text).map_err(refused)?.iter().map(number).collect()
}
