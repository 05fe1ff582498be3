//! Modes as a function of a parameter, for `flutter` and `modes --vary`: the model at each value, tables, CSV and figures.

use crate::cli::grid::GridArguments;
use crate::cli::outlets::{Mark, Outlets};
use crate::cli::pictures::{SheetArguments, write_figure};
use crate::cli::sweep::{Experiment, Plan};
use crate::cli::{Failure, read_model};
use crate::report::figure::{Curve, Figure};
use foldwing_engine::plant::{Branches, ModeShape, Plant};
use foldwing_fmi::interface::Interface;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// File names of the figures.
const FIGURES: [&str; 6] = ["damping", "frequency", "root_locus", "flutter_map", "campbell", "damping_and_frequency"];
/// Columns of the CSV after the parameters.
const COLUMNS: [&str; 5] = ["mode", "frequency_Hz", "damping_ratio", "eigenvalue_re_1_s", "eigenvalue_im_1_s"];

/// Output files of modes over a parameter.
#[derive(clap::Args)]
pub(super) struct BranchArguments {
    /// CSV file to write: a row for each value and mode
    #[arg(long, value_name = "OUT.csv")]
    pub csv: Option<PathBuf>,
    /// Folder for figures: damping and frequency over the varied quantity, and the paths of the eigenvalues
    #[arg(long, value_name = "DIR")]
    pub plot: Option<PathBuf>,
    #[command(flatten)]
    pub sheets: SheetArguments,
}

impl BranchArguments {
    /// Fails before any computation if an output file exists that Foldwing did not write.
    pub fn check(&self, outlets: &Outlets) -> Result<(), Failure> {
        let Some(folder) = &self.plot else { return Ok(()) };
        let shown = folder.display().to_string();
        std::fs::create_dir_all(folder).map_err(|error| Failure::writing(&shown, &error))?;
        for name in FIGURES {
            outlets.check(&folder.join(format!("{name}.svg")), &Mark::SVG)?;
            outlets.check(&folder.join(format!("{name}.png")), &Mark::PNG)?;
        }
        Ok(())
    }
}

/// Model with one varied start value, parameter or key of the file.
pub(super) struct Varied {
    file: String,
    text: String,
    machine: Arc<foldwing_engine::machine::Machine>,
    interface: Arc<Interface>,
    settings: Vec<String>,
    plan: Option<Plan>,
    grid: GridArguments,
}

impl Varied {
    /// Reads a model; `over` is `KEY=FROM:TO:COUNT` or `KEY=A,B,…`, as in `sweep --vary`.
    pub fn new(model: &Path, settings: &[String], over: Option<&String>) -> Result<Self, Failure> {
        let (machine, text) = read_model(model)?;
        let interface = Interface::new(&machine);
        let plan = over.map(|over| Plan::grid("--vary", std::slice::from_ref(over), &interface)).transpose()?;
        let varied = Self {
            file: model.display().to_string(),
            text,
            machine: Arc::new(machine),
            interface: Arc::new(interface),
            settings: settings.to_vec(),
            plan,
            grid: GridArguments::of(None, None, None),
        };
        if let Some(plan) = &varied.plan {
            varied.experiment(plan).check_values()?;
        }
        Ok(varied)
    }

    /// Returns the model at the values of the file.
    pub fn machine(&self) -> &foldwing_engine::machine::Machine {
        &self.machine
    }

    /// Returns the name of the varied parameter; empty without variation.
    pub fn key(&self) -> &str {
        self.plan.as_ref().map_or("", |plan| plan.keys()[0].as_str())
    }

    /// Returns the parameter values as texts; one empty text without variation.
    pub fn values(&self) -> Vec<String> {
        match &self.plan {
            None => vec![String::new()],
            Some(plan) => (0..plan.count()).map(|index| plan.variant(index)[0].to_owned()).collect(),
        }
    }

    /// Returns the parameter values as numbers, ascending or descending.
    pub fn numbers(&self) -> Result<Vec<f64>, Failure> {
        numbers(self.key(), &self.values())
    }

    /// Returns the plant at a value.
    pub fn plant(&self, value: &str) -> Result<Plant, Failure> {
        match &self.plan {
            Some(plan) => Ok(self.experiment(plan).prepare(0, &[value])?.0),
            None => crate::cli::settings::plant_with(Arc::clone(&self.machine), &self.interface, &self.settings),
        }
    }

    fn experiment<'a>(&'a self, plan: &'a Plan) -> Experiment<'a> {
        Experiment {
            file: self.file.clone(),
            machine: Arc::clone(&self.machine),
            interface: Arc::clone(&self.interface),
            text: &self.text,
            plan,
            settings: &self.settings,
            inputs: None,
            grid: &self.grid,
            outputs: &[],
        }
    }
}

/// Parses the values of `--vary KEY` as ascending or descending numbers.
pub(super) fn numbers(key: &str, values: &[String]) -> Result<Vec<f64>, Failure> {
    let refused = |cause: String| Failure::Usage(format!("--vary {key}: {cause}"));
    let numbers: Option<Vec<f64>> = values.iter().map(|value| value.parse().ok()).collect();
    let numbers = numbers.ok_or_else(|| refused("mode tracking needs numerical values".to_owned()))?;
    let steps: Vec<f64> = numbers.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if numbers.len() < 2 || !(steps.iter().all(|step| *step > 0.0) || steps.iter().all(|step| *step < 0.0)) {
        return Err(refused("needs two or more values in ascending or descending order".to_owned()));
    }
    Ok(numbers)
}

/// Tracked modes over a parameter, with its name and unit for output.
pub(super) struct BranchTable<'a> {
    /// Name of the parameter.
    pub quantity: &'a str,
    /// Unit of the parameter; empty if it has none or it is unknown.
    pub unit: &'a str,
    /// The tracked modes.
    pub branches: &'a Branches<ModeShape>,
}

impl BranchTable<'_> {
    fn label(&self) -> String {
        if self.unit.is_empty() { self.quantity.to_owned() } else { format!("{} ({})", self.quantity, self.unit) }
    }

    /// Returns whether the modes belong to a spinning rotor, whose motions are named.
    fn is_rotor(&self) -> bool {
        self.branches.places.iter().flat_map(|place| place.modes.iter().flatten()).any(|mode| !mode.whirl.is_empty())
    }

    fn count(&self) -> usize {
        self.branches.places.first().map_or(0, |place| place.modes.len())
    }

    /// Frequency and damping ratio of every branch, one line per value; for a real pole, its rate.
    pub fn text(&self) -> String {
        let mut text = format!("{:>16}", self.label());
        for mode in 1..=self.count() {
            let _ = write!(text, "  {:>22}", format!("mode {mode}: Hz, damping"));
        }
        text.push('\n');
        for place in &self.branches.places {
            let _ = write!(text, "{:16.6}", place.at);
            for mode in &place.modes {
                let cell = match mode {
                    None => "-".to_owned(),
                    Some(mode) if mode.is_real() => format!("real {:+.5} 1/s", mode.eigenvalue_1_s.re),
                    Some(mode) => format!("{:.6} {:+.6}", mode.frequency_hz, mode.damping_ratio),
                };
                let _ = write!(text, "  {cell:>22}");
            }
            text.push('\n');
        }
        text
    }

    /// Names of the CSV columns; the columns of `first` come first.
    pub fn header(&self, first: Option<&str>) -> Vec<String> {
        let quantity = if self.unit.is_empty() {
            self.quantity.to_owned()
        } else {
            format!("{}_{}", self.quantity, self.unit.replace('/', "_"))
        };
        let motion = self.is_rotor().then(|| "motion".to_owned());
        first.map(str::to_owned).into_iter().chain([quantity]).chain(COLUMNS.map(str::to_owned)).chain(motion).collect()
    }

    /// Rows of the CSV; `first` is the value of a second parameter, common to all rows.
    pub fn rows(&self, first: Option<&str>) -> Vec<Vec<String>> {
        let mut rows = Vec::new();
        for place in &self.branches.places {
            for (branch, mode) in place.modes.iter().enumerate() {
                let Some(mode) = mode else { continue };
                let real = |value: f64| format!("{value:?}");
                let own = [
                    real(place.at),
                    (branch + 1).to_string(),
                    real(mode.frequency_hz),
                    real(mode.damping_ratio),
                    real(mode.eigenvalue_1_s.re),
                    real(mode.eigenvalue_1_s.im),
                ];
                rows.push(first.map(str::to_owned).into_iter().chain(own).chain(motion(mode)).collect());
            }
        }
        rows
    }

    /// Modes over the parameter as JSON: for each value, the eigenvalues, frequencies and damping ratios of the modes, null where a mode
    /// is missing or does not oscillate; for a rotor also the names of the motions. `ended` is the value at which the tracking ended, and
    /// the reason.
    pub fn json(&self, name: &str, ended: Option<(f64, String)>) -> Value {
        let oscillates = |mode: &&ModeShape| !mode.is_real() || mode.is_free();
        let places: Vec<Value> = self
            .branches
            .places
            .iter()
            .map(|place| {
                let of = |value: &dyn Fn(&ModeShape) -> Value| -> Vec<Value> {
                    place.modes.iter().map(|mode| mode.as_ref().map_or(Value::Null, value)).collect()
                };
                let number = |value: &dyn Fn(&ModeShape) -> f64| {
                    of(&|mode| Some(mode).filter(oscillates).map_or(Value::Null, |mode| json!(value(mode))))
                };
                let mut entry = json!({
                    "value": place.at,
                    "eigenvalues_1_s": of(&|mode| json!([mode.eigenvalue_1_s.re, mode.eigenvalue_1_s.im])),
                    "frequency_Hz": number(&|mode| mode.frequency_hz),
                    "damping_ratio": number(&|mode| mode.damping_ratio),
                });
                if self.is_rotor() {
                    entry["motion"] = json!(of(&|mode| json!(motion(mode))));
                }
                entry
            })
            .collect();
        let ended = ended.map(|(value, message)| json!({ "value": value, "message": message }));
        json!({ "name": name, "over": self.quantity, "modes": places, "ended": ended })
    }

    /// Types of motion in a branch of a rotor, in the order of the sweep, each with the first value at which it occurs.
    pub fn motions(&self, branch: usize) -> Vec<(f64, String)> {
        let mut list: Vec<(f64, String)> = Vec::new();
        for place in &self.branches.places {
            let Some(name) = place.modes[branch].as_ref().and_then(motion) else { continue };
            if list.last().is_none_or(|(_, last)| *last != name) {
                list.push((place.at, name));
            }
        }
        list
    }

    /// Most frequent type of motion in a branch.
    fn usual_motion(&self, branch: usize) -> Option<String> {
        let names: Vec<String> =
            self.branches.places.iter().filter_map(|place| place.modes[branch].as_ref().and_then(motion)).collect();
        let count = |name: &String| names.iter().filter(|other| *other == name).count();
        names.iter().max_by_key(|name| count(name)).cloned()
    }

    /// Figures of damping and frequency over the parameter, and of the root locus.
    pub fn figures(&self, name: &str, marks: &[(f64, String)]) -> Vec<(&'static str, Figure)> {
        let curves = |point: &dyn Fn(f64, &ModeShape) -> [f64; 2]| -> Vec<Curve> {
            let of = |branch: usize| {
                let found = self
                    .branches
                    .places
                    .iter()
                    .filter_map(|place| place.modes[branch].as_ref().map(|mode| point(place.at, mode)));
                let name = self.usual_motion(branch).unwrap_or_else(|| format!("mode {}", branch + 1));
                Curve::nth(branch, name, found.collect())
            };
            (0..self.count()).map(of).collect()
        };
        let over = |y_label: &str, what: &str, point: &dyn Fn(f64, &ModeShape) -> [f64; 2]| Figure {
            title: format!("{name}: {what}"),
            x_label: self.label(),
            y_label: y_label.to_owned(),
            curves: curves(point),
            marks: marks.to_vec(),
            ..Figure::default()
        };
        let hz = |mode: &ModeShape| mode.eigenvalue_1_s.im / std::f64::consts::TAU;
        let locus = Figure {
            title: format!("{name}: paths of the eigenvalues"),
            x_label: "real part (1/s)".to_owned(),
            y_label: "imaginary part (rad/s)".to_owned(),
            curves: curves(&|_, mode| [mode.eigenvalue_1_s.re, mode.eigenvalue_1_s.im]),
            marks: vec![(0.0, String::new())],
            ..Figure::default()
        };
        let damping = over("damping ratio", "damping", &|at, mode| [at, mode.damping_ratio]);
        let frequency = over("frequency (Hz)", "frequency", &move |at, mode| [at, hz(mode)]);
        // one above the other over the same speeds, as papers have them
        let panels = [("damping", &damping), ("frequency", &frequency)]
            .map(|(title, figure)| Figure { title: title.to_owned(), ..figure.clone() });
        let both = Figure {
            title: format!("{name}: damping and frequency"),
            panels: panels.into(),
            columns: 1,
            ..Figure::default()
        };
        vec![(FIGURES[0], damping), (FIGURES[1], frequency), (FIGURES[2], locus), (FIGURES[5], both)]
    }
}

/// Dominant motion in a mode of a spinning rotor; `None` for other machines.
fn motion(mode: &ModeShape) -> Option<String> {
    mode.whirl.first().map(|share| if mode.is_free() { format!("{share}, free") } else { share.to_string() })
}

/// Writes the figures into the given folder.
pub(super) fn write_figures(
    arguments: &BranchArguments,
    figures: Vec<(&'static str, Figure)>,
    outlets: &mut Outlets,
) -> Result<(), Failure> {
    let Some(folder) = &arguments.plot else { return Ok(()) };
    figures.into_iter().try_for_each(|(stem, figure)| write_figure(folder, stem, &figure, &arguments.sheets, outlets))
}

/// Returns a table as CSV text.
pub(super) fn csv_text(header: &[String], rows: &[Vec<String>]) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let written = writer.write_record(header).and_then(|()| rows.iter().try_for_each(|row| writer.write_record(row)));
    written.expect("writing to memory does not fail");
    writer.into_inner().expect("writing to memory does not fail")
}
