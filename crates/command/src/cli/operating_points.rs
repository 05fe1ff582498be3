//! `foldwing operating-points`: power, thrust and loads of a rotor over wind, speed and pitch, with an optional solution for pitch or
//! speed.

use crate::cli::branches::csv_text;
use crate::cli::operating_search::{Asked, Find, Found, Target};
use crate::cli::operating_table::{Row, as_json, header, rows_text, shown};
use crate::cli::outlets::{Force, Mark, Outlets};
use crate::cli::sweep::axis;
use crate::cli::{Failure, print, read_model, tell};
use clap::builder::NonEmptyStringValueParser;
use foldwing_engine::machine::Machine;
use std::path::PathBuf;
use std::sync::Arc;

/// Maximum number of points: a larger grid is probably a mistake.
const MAXIMUM_POINTS: usize = 100_000;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::OPERATING_POINTS)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Wind speeds in m/s, along the wind of the model: A,B,… or FROM:TO:COUNT
    #[arg(long, value_name = "VALUES", required = true)]
    wind_m_s: String,
    /// Rotor speeds in rpm; with --tip-speed-ratio the maximum speed; default: that of the model
    #[arg(long, value_name = "VALUES", allow_negative_numbers = true)]
    speed_rpm: Option<String>,
    /// Tip speed ratio, from which the rotor speed follows
    #[arg(long, value_name = "RATIO")]
    tip_speed_ratio: Option<f64>,
    /// Pitch angles of all blades in degrees, positive as the pitch joints turn; default: that of the model
    #[arg(long, value_name = "VALUES", allow_negative_numbers = true)]
    pitch_deg: Option<String>,
    /// Combine the lists value by value (a list of one value holds for all); default: all combinations
    #[arg(long)]
    paired: bool,
    /// Quantity to solve for, with its range: `pitch_deg=0:90` or `speed_rpm=6:14`
    #[arg(long = "solve-for", value_name = "KEY=FROM:TO", requires = "hold", value_parser = NonEmptyStringValueParser::new())]
    find: Option<String>,
    /// Target value of the mean of an output, e.g. `rotor.power=5.3e6`; where it is below the target at FROM, FROM is kept
    #[arg(long = "target", value_name = "OUTPUT=VALUE", requires = "find", value_parser = NonEmptyStringValueParser::new())]
    hold: Option<String>,
    /// Joint that is the shaft; default: the only one that turns without limit and carries a hub
    #[arg(long, value_name = "JOINT", value_parser = NonEmptyStringValueParser::new())]
    shaft: Option<String>,
    /// Joints that pitch the blades, separated by commas [default: those that bear the blades on the hub]
    #[arg(long, value_name = "JOINTS", value_parser = NonEmptyStringValueParser::new())]
    pitch_joints: Option<String>,
    /// Start value of an input or parameter; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Outputs in the table: names or patterns, separated by commas [default: the rotor's, deflection and root loads of the first
    /// blade and of other bodies, the torque that holds the shaft]
    #[arg(long = "variables", value_name = "NAME")]
    outputs: Vec<String>,
    /// Steps per revolution of a periodic steady state, rounded up to a multiple of 144
    #[arg(long, default_value_t = 720)]
    steps: usize,
    /// Periodicity tolerance: distance of the ends of a revolution, rotation in rad or displacement over the length of the model
    #[arg(long = "tolerance", default_value_t = 1e-6)]
    accuracy: f64,
    /// CSV file with means and peak-to-peak values of all outputs
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,
    /// Print JSON for programs
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    force: Force,
}

/// Computes the points and prints them.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (machine, _) = read_model(&arguments.model)?;
    let wanted = Wanted {
        wind_m_s: values("--wind-m-s", &arguments.wind_m_s)?,
        speed_rpm: arguments.speed_rpm.as_ref().map(|text| values("--speed-rpm", text)).transpose()?,
        tip_speed_ratio: arguments.tip_speed_ratio,
        pitch_deg: arguments.pitch_deg.as_ref().map(|text| values("--pitch-deg", text)).transpose()?,
        paired: arguments.paired,
        find: arguments.find.clone(),
        hold: arguments.hold.clone(),
        shaft: arguments.shaft.clone(),
        pitch_joints: arguments.pitch_joints.clone(),
        settings: arguments.settings.clone(),
        outputs: arguments.outputs.clone(),
        steps: arguments.steps,
        accuracy: arguments.accuracy,
    };
    let mut outlets = Outlets::new(arguments.force.force, [arguments.model.as_path()]);
    let table = points(machine, &wanted)?;
    if let Some(path) = &arguments.csv {
        let rows: Vec<Vec<String>> = table.rows.iter().map(Row::cells).collect();
        let text = csv_text(&header(&table.outputs), &rows);
        outlets.place(path, Mark::first_line(&text))?.fill(&text)?;
    }
    for (row, cause) in table.rows.iter().filter_map(|row| row.cause.as_ref().map(|cause| (row, cause))) {
        tell::note(&format!("no state at {} m/s: {cause}", row.wind_m_s));
    }
    if arguments.json {
        return print(&format!("{:#}", as_json(&table)));
    }
    let named = !arguments.outputs.is_empty();
    print(&rows_text(&table, &shown(&table, named)))
}

/// Arguments of the analysis, from the command or from a program.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    /// Wind speeds in m/s.
    pub wind_m_s: Vec<f64>,
    /// Rotor speeds in rpm; `None`: that of the model.
    pub speed_rpm: Option<Vec<f64>>,
    /// Tip speed ratio, with the rotor speed up to the one speed given.
    pub tip_speed_ratio: Option<f64>,
    /// Pitch angles in degrees; `None`: that of the model.
    pub pitch_deg: Option<Vec<f64>>,
    /// The lists are combined value by value.
    pub paired: bool,
    /// `pitch_deg=FROM:TO` or `speed_rpm=FROM:TO`.
    pub find: Option<String>,
    /// `OUTPUT=VALUE`.
    pub hold: Option<String>,
    /// Joint that is the shaft.
    pub shaft: Option<String>,
    /// Joints that pitch the blades, separated by commas.
    pub pitch_joints: Option<String>,
    /// `NAME=VALUE` of inputs and parameters.
    pub settings: Vec<String>,
    /// Outputs in the table.
    pub outputs: Vec<String>,
    /// Steps per revolution.
    pub steps: usize,
    /// Periodicity tolerance.
    pub accuracy: f64,
}

/// Operating points with their outputs.
pub(super) struct Table {
    /// Name of the machine.
    pub name: String,
    /// Body of the first flexible blade.
    pub blade: Option<String>,
    /// Name and unit of each output.
    pub outputs: Vec<(String, &'static str)>,
    /// Rows in the order of the lists.
    pub rows: Vec<Row>,
}

/// Computes all points. A point without a state has a row with the cause; the others are still computed.
pub(super) fn points(machine: Machine, wanted: &Wanted) -> Result<Table, Failure> {
    let combinations = combinations(wanted)?;
    if !(wanted.accuracy > 0.0 && wanted.accuracy < 1.0) {
        return Err(Failure::Usage(format!("--tolerance {}: must lie between 0 and 1", wanted.accuracy)));
    }
    let find = match (&wanted.find, &wanted.hold) {
        (Some(find), Some(hold)) => {
            let find = Find::parse(find)?;
            let given = match find.is_pitch {
                true => ("--pitch-deg", wanted.pitch_deg.is_some()),
                false => ("--speed-rpm", wanted.speed_rpm.is_some() || wanted.tip_speed_ratio.is_some()),
            };
            if given.1 {
                return Err(Failure::Usage(format!(
                    "--solve-for {}: it is the unknown, so omit {}",
                    find.text, given.0
                )));
            }
            Some((find, Target::parse(hold)?))
        }
        (None, None) => None,
        _ => return Err(Failure::Usage("--solve-for and --target are needed together".to_owned())),
    };
    let mut asked = Asked::new(Arc::new(machine), wanted, find.as_ref().map(|(_, target)| target))?;
    let mut rows = Vec::with_capacity(combinations.len());
    for [wind_m_s, speed_rpm, pitch_deg] in combinations {
        let speed_rpm = match wanted.tip_speed_ratio {
            Some(ratio) => Some(asked.speed_rpm(ratio, wind_m_s.unwrap_or(0.0), speed_rpm)?),
            None => speed_rpm,
        };
        let at = [wind_m_s.unwrap_or(0.0), speed_rpm.unwrap_or(f64::NAN), pitch_deg.unwrap_or(f64::NAN)];
        let found = match &find {
            Some((find, target)) => asked.search(at, find, target),
            None => asked.point(at),
        };
        rows.push(match found {
            Ok(found) => Row::of(wind_m_s.unwrap_or(0.0), found),
            Err(Failure::Statics(cause)) => Row::without(at, cause),
            Err(other) => return Err(other),
        });
    }
    if rows.iter().all(|row| row.cause.is_some())
        && let Some(cause) = rows.first().and_then(|row| row.cause.clone())
    {
        return Err(Failure::Statics(cause));
    }
    Ok(Table { name: asked.name().to_owned(), blade: asked.blade(), outputs: asked.outputs(), rows })
}

/// Wind, speed and pitch of every point; `None` stands for the value of the model.
fn combinations(wanted: &Wanted) -> Result<Vec<[Option<f64>; 3]>, Failure> {
    let own = |list: &Option<Vec<f64>>| -> Vec<Option<f64>> {
        list.as_ref().map_or(vec![None], |list| list.iter().map(|value| Some(*value)).collect())
    };
    let lists = [own(&Some(wanted.wind_m_s.clone())), own(&wanted.speed_rpm), own(&wanted.pitch_deg)];
    let names = ["--wind-m-s", "--speed-rpm", "--pitch-deg"];
    for (name, list) in names.iter().zip(&lists) {
        if list.is_empty() {
            return Err(Failure::Usage(format!("{name}: has no value")));
        }
        if let Some(value) = list.iter().flatten().find(|value| !value.is_finite()) {
            return Err(Failure::Usage(format!("{name} {value}: must be finite numbers")));
        }
    }
    if let Some(value) = wanted.wind_m_s.iter().find(|value| **value < 0.0) {
        return Err(Failure::Usage(format!(
            "--wind-m-s {value}: must not be negative; its direction is that of the model's wind"
        )));
    }
    if let Some(ratio) = wanted.tip_speed_ratio {
        if !(ratio.is_finite() && ratio > 0.0) {
            return Err(Failure::Usage(format!("--tip-speed-ratio {ratio}: must be a finite number > 0")));
        }
        if lists[1].len() > 1 {
            return Err(Failure::Usage(
                "--speed-rpm: with --tip-speed-ratio one value is allowed, which the speed does not exceed".to_owned(),
            ));
        }
    }
    let longest = lists.iter().map(Vec::len).max().unwrap_or(1);
    let count = if wanted.paired { longest } else { lists.iter().map(Vec::len).fold(1, usize::saturating_mul) };
    if count > MAXIMUM_POINTS {
        return Err(Failure::Usage(format!("{count} points are more than {MAXIMUM_POINTS}")));
    }
    if !wanted.paired {
        let [wind, speed, pitch] = &lists;
        let of = |w: &Option<f64>| -> Vec<[Option<f64>; 3]> {
            speed.iter().flat_map(|s| pitch.iter().map(|p| [*w, *s, *p])).collect()
        };
        return Ok(wind.iter().flat_map(of).collect());
    }
    if let Some((name, list)) = names.iter().zip(&lists).find(|(_, list)| ![1, longest].contains(&list.len())) {
        return Err(Failure::Usage(format!(
            "--paired: {name} has {} values and another list {longest}; paired lists need the same length, or one value",
            list.len()
        )));
    }
    Ok((0..longest).map(|i| std::array::from_fn(|k| lists[k][i.min(lists[k].len() - 1)])).collect())
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

impl Row {
    /// Row of a state that was found.
    fn of(wind_m_s: f64, found: Found) -> Self {
        let Found { speed_rpm, pitch_deg, is_periodic, held, values, .. } = found;
        Self { wind_m_s, speed_rpm, pitch_deg, is_periodic, held, values, cause: None }
    }

    /// Row with the cause of a missing state.
    fn without([wind_m_s, speed_rpm, pitch_deg]: [f64; 3], cause: String) -> Self {
        Self { wind_m_s, speed_rpm, pitch_deg, is_periodic: false, held: None, values: Vec::new(), cause: Some(cause) }
    }
}
