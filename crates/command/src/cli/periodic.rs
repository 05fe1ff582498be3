//! `foldwing periodic`: the periodic steady state of a rotor, its harmonics, and its Floquet modes.

use crate::cli::choice::chosen;
use crate::cli::outlets::{Force, Mark, Outlets};
use crate::cli::periodic_tables::{Series, csv_text, modes_json, modes_text};
use crate::cli::settings::plant_with;
use crate::cli::{Failure, print, read_model};
use clap::builder::NonEmptyStringValueParser;
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{Floquet, OutputSet, PeriodicMotion, Plant, PlantError, SAMPLES, Turn};
use foldwing_fmi::interface::{Interface, Value, Variable};
use serde_json::json;
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::PERIODIC)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Speed of the shaft in rpm; default: that at which it is prescribed or starts
    #[arg(long, value_name = "RPM", allow_negative_numbers = true)]
    speed_rpm: Option<f64>,
    /// Joint that is the shaft; default: the only one that turns without limit and carries a hub
    #[arg(long, value_name = "JOINT", value_parser = NonEmptyStringValueParser::new())]
    shaft: Option<String>,
    /// Start value of an input or parameter, e.g. `wind.velocity.x=8`; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Steps per revolution, rounded up to a multiple of 144
    #[arg(long, default_value_t = 720)]
    steps: usize,
    /// Periodicity tolerance: distance of the ends of the revolution, rotation in rad or displacement over the length of the model
    #[arg(long = "tolerance", default_value_t = 1e-8)]
    accuracy: f64,
    /// Outputs in the tables: names or patterns, separated by commas [default: deflections, angles, the rotor's; in files all]
    #[arg(long = "variables", value_name = "NAME")]
    outputs: Vec<String>,
    /// Number of harmonics of the rotor speed in the table
    #[arg(long, default_value_t = 3)]
    harmonics: usize,
    /// Number of Floquet modes; 0 leaves them out
    #[arg(long, default_value_t = 10)]
    count: usize,
    /// Maximum number of perturbations integrated for the Floquet modes, two revolutions each
    #[arg(long = "perturbations", default_value_t = 120)]
    directions: usize,
    /// CSV file for the outputs over the revolution
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,
    /// Print JSON for programs
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    force: Force,
}

/// Default outputs in the text, if the machine has them.
const SHOWN: [&str; 5] = ["*.deflection.*", "*.angle", "rotor.*", "tip.position.*", "*.holding_torque"];
/// Maximum number of harmonics that the samples of a revolution resolve.
const MAXIMUM_HARMONICS: usize = SAMPLES / 2 - 1;

/// Arguments of the analysis, from the command or from a program.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    /// Shaft speed in rpm; `None`: the prescribed or initial speed.
    pub speed_rpm: Option<f64>,
    /// Joint that is the shaft.
    pub shaft: Option<String>,
    /// `NAME=VALUE` of inputs and parameters.
    pub settings: Vec<String>,
    /// Steps per revolution.
    pub steps: usize,
    /// Periodicity tolerance.
    pub accuracy: f64,
    /// Outputs; empty: all.
    pub outputs: Vec<String>,
    /// Number of harmonics of the shaft speed.
    pub harmonics: usize,
    /// Number of Floquet modes; 0 omits them.
    pub count: usize,
    /// Maximum number of perturbations integrated for the Floquet modes.
    pub directions: usize,
}

/// Periodic steady state with its outputs over the revolution.
pub(super) struct Answer {
    name: String,
    turn: Turn,
    motion: PeriodicMotion,
    series: Vec<Series>,
    floquet: Option<Floquet>,
}

impl Wanted {
    /// Computes the periodic steady state.
    pub(super) fn answer(&self, machine: &Machine) -> Result<Answer, Failure> {
        if self.harmonics > MAXIMUM_HARMONICS {
            return Err(Failure::Usage(format!(
                "--harmonics {}: must be at most {MAXIMUM_HARMONICS}, as many as the {SAMPLES} samples of a turn resolve",
                self.harmonics
            )));
        }
        if !(self.accuracy > 0.0 && self.accuracy < 1.0) {
            return Err(Failure::Usage(format!("--tolerance {}: must lie between 0 and 1", self.accuracy)));
        }
        if self.directions == 0 && self.count > 0 {
            let told = "--perturbations 0: modes need at least 1; --count 0 leaves them out";
            return Err(Failure::Usage(told.to_owned()));
        }
        let speed_rad_s = self.speed_rpm.map(|speed_rpm| speed_rpm * PI / 30.0);
        let (machine, turn) = Turn::of(machine, self.shaft.as_deref(), speed_rad_s, self.steps)
            .map_err(|cause| Failure::Statics(format!("no periodic motion: {cause}")))?;
        let interface = Interface::new(&machine);
        let all: Vec<&Variable> = interface.real_outputs().collect();
        let recorded = if self.outputs.is_empty() { all } else { chosen(&self.outputs, &all, "real output")? };
        let mut plant = plant_with(machine, &interface, &self.settings)?;
        let failed = |error: PlantError| Failure::Statics(error.to_string());
        plant.watch(OutputSet::NONE);
        let time_s = plant.machine().experiment.start_time_s;
        plant.initialize(time_s).map_err(failed)?;
        let motion = plant.periodic(&turn, self.accuracy).map_err(failed)?;
        let series = traced(&mut plant, &turn, &motion, &interface, &recorded).map_err(failed)?;
        let floquet = match self.count {
            0 => None,
            _ => Some(plant.floquet(&turn, &motion, self.directions).map_err(failed)?),
        };
        Ok(Answer { name: plant.machine().name.clone(), turn, motion, series, floquet })
    }
}

/// Computes the periodic steady state and prints it.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (machine, _) = read_model(&arguments.model)?;
    let wanted = Wanted {
        speed_rpm: arguments.speed_rpm,
        shaft: arguments.shaft.clone(),
        settings: arguments.settings.clone(),
        steps: arguments.steps,
        accuracy: arguments.accuracy,
        outputs: arguments.outputs.clone(),
        harmonics: arguments.harmonics,
        count: arguments.count,
        directions: arguments.directions,
    };
    let named = !arguments.outputs.is_empty();
    let mut outlets = Outlets::new(arguments.force.force, [arguments.model.as_path()]);
    let Answer { name, turn, motion, series, floquet } = &wanted.answer(&machine)?;
    if let Some(path) = &arguments.csv {
        let text = csv_text(series, turn.speed_rad_s.signum());
        outlets.place(path, Mark::first_line(&text))?.fill(&text)?;
    }
    if arguments.json {
        return print(&format!("{:#}", wanted.answer_json(turn, name, motion, series, floquet.as_ref())));
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
        "{name}: periodic at {:.6} rpm, a turn of {:.6} s in {} steps\n{} states; periodic to {:.1e} after {} Newton \
         steps and {} turns\n\n",
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
    print(&text)
}

/// Outputs at the samples of the revolution, including its end.
fn traced(
    plant: &mut Plant,
    turn: &Turn,
    motion: &PeriodicMotion,
    interface: &Interface,
    recorded: &[&Variable],
) -> Result<Vec<Series>, PlantError> {
    let mut list: Vec<Series> = recorded.iter().map(|variable| Series::of(&variable.name, variable.unit())).collect();
    let rows: Vec<u32> = recorded.iter().map(|variable| variable.value_reference).collect();
    let needs = interface.needs(rows.as_slice());
    let mut seen = |_: usize, plant: &mut Plant| {
        plant.provide(needs);
        for (series, row) in list.iter_mut().zip(&rows) {
            if let Some(Value::Real(value)) = interface.get(plant, plant.outputs(), *row) {
                series.values.push(value);
            }
        }
        Ok(())
    };
    plant.trace(turn, motion, &mut seen)?;
    Ok(list)
}

/// Appends mean, amplitude and harmonics of outputs, one line each.
fn harmonics_text(shown: &[&Series], count: usize, text: &mut String) {
    let width = shown.iter().map(|series| series.label().chars().count()).max().unwrap_or(0).max(6);
    let _ = write!(text, "{:width$} {:>13} {:>12}", "output", "mean", "half range");
    (1..=count).for_each(|n| {
        let _ = write!(text, " {:>12}", format!("{n}P"));
    });
    text.push('\n');
    let mut left_out = Vec::new();
    for series in shown {
        if !series.is_periodic() {
            left_out.push(format!("{} ({:.1e})", series.label(), series.drift()));
            continue;
        }
        let _ = write!(text, "{:width$} {:13.6e} {:12.4e}", series.label(), series.harmonic(0)[0], series.half_range());
        (1..=count).for_each(|n| {
            let _ = write!(text, " {:12.4e}", series.harmonic(n)[0]);
        });
        text.push('\n');
    }
    if !left_out.is_empty() {
        let _ = writeln!(
            text,
            "not periodic within --tolerance, harmonics omitted (change over the turn): {}",
            left_out.join(", ")
        );
    }
}

impl Wanted {
    fn answer_json(
        &self,
        turn: &Turn,
        name: &str,
        motion: &PeriodicMotion,
        series: &[Series],
        floquet: Option<&Floquet>,
    ) -> serde_json::Value {
        let outputs: Vec<serde_json::Value> =
            series.iter().map(|series| series.json(self.harmonics, turn.speed_rad_s.signum())).collect();
        let mut value = json!({
            "name": name,
            "rotor_speed_rpm": turn.speed_rad_s * 30.0 / PI,
            "period_s": turn.period_s(),
            "steps": turn.steps,
            "states": motion.states,
            "distance": motion.distance,
            "newton_steps": motion.newton_steps,
            "turns": motion.turns,
            "outputs": outputs,
        });
        if let Some(floquet) = floquet {
            value["floquet"] = modes_json(floquet, self.count);
        }
        value
    }
}

impl Answer {
    /// Returns the output of `foldwing periodic --json`, with the values of the outputs at the samples of the revolution, including its
    /// end.
    pub fn json_with_values(&self, wanted: &Wanted) -> serde_json::Value {
        let Self { name, turn, motion, series, floquet } = self;
        let mut value = wanted.answer_json(turn, name, motion, series, floquet.as_ref());
        let sense = turn.speed_rad_s.signum();
        value["turn_deg"] = (0..=SAMPLES).map(|k| sense * 360.0 * k as f64 / SAMPLES as f64).collect();
        value["values"] = series.iter().map(|series| json!(series.values)).collect();
        value
    }
}
