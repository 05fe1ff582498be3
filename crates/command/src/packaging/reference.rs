//! Reference results: the default experiment, and the same experiment with varying inputs, simulated during packaging, so that they agree
//! with the library. Stored in the format of FMI-LS-REF 1.0.0-alpha.1.

use crate::packaging::xml::{self, real};
use crate::report::{InputTable, Recorder};
use foldwing_engine::machine::Body;
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{Plant, PlantError};
use foldwing_fmi::interface::{Causality, Interface, Value, Variable};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Folder of the layered standard inside the archive.
pub const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";

/// Maximum number of communication steps of a reference: enough to show the motion, and few enough to keep the archive small.
const MAXIMUM_STEPS: u64 = 400;

/// Maximum number of variables according to the rules of the FMI Cross-Check.
const MAXIMUM_VARIABLES: usize = 10;

/// Tolerance for a repeated run, relative to each variable's range over the run. The same library on the same platform gives bit-identical
/// results for the same inputs; importers that interpolate the stimuli differently, and mathematical functions of other compilers, differ
/// in the last bit.
pub const TOLERANCE: f64 = 1e-6;

/// Absolute tolerance for variables that are zero except for round-off, in the variable's unit.
pub const LEAST: f64 = 1e-9;

/// Maximum downward acceleration of the root in the experiment with varying inputs, in m/s².
const ROOT_ACCELERATION_M_S2: f64 = 2.0;

/// Force on the outermost station in this experiment, as a fraction of its body's weight.
const LOAD_SHARE: f64 = 0.2;

const GRAVITY_M_S2: f64 = 9.81;

/// An experiment with its result.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// Name, used as prefix of its file names.
    pub name: &'static str,
    /// Description.
    pub description: &'static str,
    /// Inputs over time as CSV; `None` if all inputs keep their start values.
    pub stimuli: Option<String>,
    /// Outputs over time as CSV.
    pub result: String,
}

/// The experiments of a model and their communication step.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Communication step in s.
    pub step_s: f64,
    /// The experiments.
    pub experiments: [Experiment; 2],
}

impl Reference {
    /// Simulates the experiments of a model.
    ///
    /// Inputs are sampled at the start of each communication step, with reals interpolated linearly between the rows of the stimuli, as in
    /// `foldwing simulate --inputs` and FMPy.
    pub fn simulate(machine: &Machine) -> Result<Self, PlantError> {
        let interface = Interface::new(machine);
        let grid = Grid::new(machine);
        let stimuli = stimuli(machine, &interface);
        Ok(Self {
            step_s: grid.step_s,
            experiments: [
                Experiment {
                    name: "default",
                    description: "The default experiment: every input and parameter at its start value",
                    stimuli: None,
                    result: run(machine, &interface, &grid, None)?,
                },
                Experiment {
                    name: "inputs",
                    description: "The default experiment while the root is accelerated and the outermost station loaded",
                    result: run(machine, &interface, &grid, Some(&stimuli))?,
                    stimuli: Some(stimuli),
                },
            ],
        })
    }

    /// Files of the layered standard by their paths in the archive.
    pub fn files(&self, machine: &Machine) -> BTreeMap<String, String> {
        let mut files = BTreeMap::from([
            (format!("{FOLDER}/fmi-ls-manifest.xml"), self.manifest()),
            (format!("{FOLDER}/experiments.exp"), self.experiments_file(machine)),
            ("documentation/fmi-ls-ref.txt".to_owned(), self.notes()),
        ]);
        for experiment in &self.experiments {
            files.insert(format!("{FOLDER}/{}", experiment.result_file()), experiment.result.clone());
            if let (Some(path), Some(text)) = (experiment.stimuli_file(), &experiment.stimuli) {
                files.insert(format!("{FOLDER}/{path}"), text.clone());
            }
        }
        files
    }

    fn manifest(&self) -> String {
        let related = |kind: &str, source: String, role: &str, description: String| {
            let owned = |text: &str| text.to_owned();
            vec![("type", owned(kind)), ("source", source), ("role", owned(role)), ("description", description)]
        };
        let mut rows = vec![related(
            "application/x-ma-ls-experiments",
            "experiments.exp".to_owned(),
            "experiment/smoke-test",
            "Experiments with reference results, for a first check of the FMU in a simulation environment".to_owned(),
        )];
        for experiment in &self.experiments {
            let what = format!("Reference result of the experiment {}", experiment.name);
            rows.push(related("text/csv", experiment.result_file(), "result", what));
        }
        let model = "The model file that the FMU was made from";
        rows.push(related("application/toml", "../../resources/model.toml".to_owned(), "model", model.to_owned()));
        xml::document(|xml| {
            let attributes = [
                ("xmlns:fmi-ls", "http://fmi-standard.org/fmi-ls-manifest"),
                ("fmi-ls:fmi-ls-name", "org.fmi-standard.fmi-ls-ref"),
                ("fmi-ls:fmi-ls-version", "1.0.0-alpha.1"),
                (
                    "fmi-ls:fmi-ls-description",
                    "Layered Standard providing information on related files included in an FMU.",
                ),
            ]
            .map(|(name, value)| (name, value.to_owned()));
            xml::nest(xml, "fmiReferences", &attributes.into(), |xml| {
                rows.iter().try_for_each(|row| xml::leaf(xml, "Related", row))
            })
        })
    }

    fn experiments_file(&self, machine: &Machine) -> String {
        let attributes = vec![
            ("name", format!("{}: smoke tests", machine.name)),
            ("description", "Experiments that `foldwing package` ran with the library of this FMU".to_owned()),
        ];
        xml::document(|xml| {
            xml::nest(xml, "Experiments", &attributes, |xml| {
                self.experiments.iter().try_for_each(|experiment| {
                    let settings = vec![
                        ("name", experiment.name.to_owned()),
                        ("description", experiment.description.to_owned()),
                        ("startTime", real(machine.experiment.start_time_s)),
                        ("stopTime", real(machine.experiment.stop_time_s)),
                        ("tolerance", real(machine.solver.tolerance)),
                        ("stepSize", real(self.step_s)),
                    ];
                    xml::nest(xml, "Experiment", &settings, |xml| {
                        if let Some(source) = experiment.stimuli_file() {
                            xml::leaf(xml, "Stimuli", &vec![("source", source)])?;
                        }
                        xml::leaf(xml, "References", &vec![("source", experiment.result_file())])
                    })
                })
            })
        })
    }

    /// Notes required by the layered standard.
    fn notes(&self) -> String {
        let mut text = format!(
            "Reference results (FMI-LS-REF 1.0.0-alpha.1)\n\n\
             {FOLDER} holds the experiments below with their results. They were simulated by\n\
             `foldwing package` with the code of the library in this FMU.\n\n\
             Communication step: {} s, inputs taken at its beginning and held (reals linearly interpolated between the rows\n\
             of the stimuli), no input derivatives.\n\
             Expected deviation: at most {TOLERANCE:e} of a variable's range over the run, or {LEAST:e} in its unit where that is\n\
             more; round-off where the same library runs without stimuli. An importer with other communication steps gets other\n\
             values in the experiment with moving inputs, as they are held for longer or shorter.\n\n",
            real(self.step_s)
        );
        for experiment in &self.experiments {
            let stimuli = experiment.stimuli_file().map_or(String::new(), |file| format!(", inputs {file}"));
            text += &format!(
                "{}: {}.\n  result {}{stimuli}\n",
                experiment.name,
                experiment.description,
                experiment.result_file()
            );
        }
        text
    }
}

impl Experiment {
    fn result_file(&self) -> String {
        format!("{}_ref.csv", self.name)
    }

    fn stimuli_file(&self) -> Option<String> {
        self.stimuli.as_ref().map(|_| format!("{}_in.csv", self.name))
    }
}

/// Communication points of a reference.
struct Grid {
    start_s: f64,
    stop_s: f64,
    step_s: f64,
    steps: u64,
}

impl Grid {
    /// Communication steps of the model or every second, third, … of them: a multiple that ends exactly at the stop time, if there is one
    /// no longer than twice the smallest possible step.
    fn new(machine: &Machine) -> Self {
        let experiment = &machine.experiment;
        let (start_s, stop_s) = (experiment.start_time_s, experiment.stop_time_s);
        let own = (((stop_s - start_s) / experiment.step_s).round() as u64).max(1);
        let least = own.div_ceil(MAXIMUM_STEPS);
        let multiple = (least..=2 * least).find(|multiple| own.is_multiple_of(*multiple));
        let steps = multiple.map_or(own.min(MAXIMUM_STEPS), |multiple| own / multiple);
        let step_s = (stop_s - start_s) / steps as f64;
        Self { start_s, stop_s, step_s, steps }
    }

    fn time_s(&self, point: u64) -> f64 {
        if point == self.steps { self.stop_s } else { self.start_s + point as f64 * self.step_s }
    }
}

/// Outputs that describe a wing with few columns: fold angles and latches, strains, the first tip, root loads.
pub(super) fn recorded(variables: &[Variable]) -> Vec<&Variable> {
    let is = |row: &&Variable, prefix: &str, suffix: &str| row.name.starts_with(prefix) && row.name.ends_with(suffix);
    let kinds: [(&str, &str, usize); 10] = [
        ("", ".angle", 2),
        ("", ".position", 2),
        ("", ".latch_time", 1),
        ("gauge.", ".strain", 2),
        ("tip", ".position.x", 1),
        ("tip", ".position.y", 1),
        ("tip", ".position.z", 1),
        ("root.", "moment.y", 1),
        ("root.", "force.z", 1),
        ("aero.", "force.z", 1),
    ];
    let outputs = || variables.iter().filter(|row| row.causality == Causality::Output);
    let mut rows: Vec<&Variable> = Vec::new();
    for (prefix, suffix, most) in kinds {
        rows.extend(outputs().filter(|row| is(row, prefix, suffix)).take(most));
    }
    rows.extend(outputs().filter(|row| row.name == "energy.total"));
    rows.truncate(MAXIMUM_VARIABLES);
    rows
}

/// Triangular pulses over the run: the root accelerates downwards, and the outermost station, if any, is loaded upwards. Every other input
/// has a column with its start value, because importers require it.
fn stimuli(machine: &Machine, interface: &Interface) -> String {
    let mut peaks = BTreeMap::from([("root.acceleration.z".to_owned(), -ROOT_ACCELERATION_M_S2)]);
    if let Some(body) = machine.bodies.iter().rev().find(|body| !body.station_positions_m.is_empty()) {
        let station = format!("load.{}[{}].force.z", body.name, body.station_positions_m.len());
        peaks.insert(station, LOAD_SHARE * weight_n(body));
    }
    let inputs: Vec<&Variable> = interface.variables().iter().filter(|row| row.causality == Causality::Input).collect();
    let (start_s, stop_s) = (machine.experiment.start_time_s, machine.experiment.stop_time_s);
    let mut recorder = Recorder::quoted(Vec::new(), inputs.iter().map(|variable| variable.name.as_str()))
        .expect("writing to memory does not fail");
    for (time_s, share) in [(start_s, 0.0), (0.5 * (start_s + stop_s), 1.0), (stop_s, 0.0)] {
        let values = inputs.iter().map(|row| match (row.value, peaks.get(&row.name)) {
            (Value::Real(start), Some(peak)) => Value::Real(start + share * peak),
            (value, _) => value,
        });
        recorder.record(time_s, values).expect("writing to memory does not fail");
    }
    text(recorder)
}

/// Returns the text written by a recorder.
fn text(recorder: Recorder<Vec<u8>>) -> String {
    let bytes = recorder.finish().expect("writing to memory does not fail");
    String::from_utf8(bytes).expect("the recorder writes text")
}

/// Weight of a body in N, computed from the mass per length at its middle, rounded to two digits.
fn weight_n(body: &Body) -> f64 {
    let weight_n = GRAVITY_M_S2 * body.length_m * body.section.at(0.5 * body.length_m).mass_kg_m;
    format!("{weight_n:.1e}").parse().expect("a number just written")
}

/// Records the outputs at every communication point.
fn run(machine: &Machine, interface: &Interface, grid: &Grid, stimuli: Option<&str>) -> Result<String, PlantError> {
    let inputs = stimuli.map(|text| {
        InputTable::read(text.as_bytes(), "stimuli", interface.variables()).expect("the stimuli name inputs")
    });
    let mut plant = Plant::new(Arc::new(machine.clone()));
    let feed = |plant: &mut Plant, time_s: f64| {
        let Some(table) = &inputs else { return };
        for (row, value) in table.at(time_s) {
            let reference = interface.variables()[row].value_reference;
            interface.set(plant, reference, value).expect("stimuli lie within the inputs' ranges");
        }
    };
    let rows = recorded(interface.variables());
    let values = |plant: &Plant| -> Vec<Value> {
        let value = |row: &&Variable| {
            interface.get(plant, plant.outputs(), row.value_reference).expect("rows come from the same table")
        };
        rows.iter().map(value).collect()
    };
    feed(&mut plant, grid.start_s);
    plant.initialize(grid.start_s)?;
    let mut history = vec![(grid.start_s, values(&plant))];
    for point in 1..=grid.steps {
        feed(&mut plant, grid.time_s(point - 1));
        plant.step(grid.time_s(point))?;
        history.push((grid.time_s(point), values(&plant)));
    }
    let columns = moving(&history);
    let kept: Vec<&Variable> = columns.iter().map(|&column| rows[column]).collect();
    let mut recorder = Recorder::quoted(Vec::new(), kept.iter().map(|variable| variable.name.as_str()))
        .expect("writing to memory does not fail");
    for (time_s, values) in &history {
        recorder
            .record(*time_s, columns.iter().map(|&column| values[column]))
            .expect("writing to memory does not fail");
    }
    Ok(text(recorder))
}

/// Indices of columns that change by more than round-off; a comparison of the others relative to their range would compare noise. The first
/// column if none changes.
fn moving(history: &[(f64, Vec<Value>)]) -> Vec<usize> {
    let number = |value: &Value| match value {
        Value::Real(value) => *value,
        Value::Integer(value) => f64::from(*value),
        Value::Boolean(value) => f64::from(u8::from(*value)),
    };
    let range = |column: usize| {
        let values = || history.iter().map(|(_, values)| number(&values[column]));
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    let columns: Vec<usize> = (0..history[0].1.len()).filter(|&column| range(column) > LEAST).collect();
    if columns.is_empty() { vec![0] } else { columns }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packaging::drawing::tests::two_body_machine;

    /// Communication steps are multiples of the model's step, at most 400 if possible, and end at the stop time.
    #[test]
    fn steps_are_few_and_reach_the_end() {
        let cases =
            [(0.4, 5e-4, 400, 1e-3), (2.0, 2e-3, 250, 8e-3), (0.2, 1e-3, 200, 1e-3), (0.823, 1e-3, 400, 0.823 / 400.0)];
        for (stop_s, step_s, steps, expected_s) in cases {
            let mut machine = two_body_machine();
            (machine.experiment.stop_time_s, machine.experiment.step_s) = (stop_s, step_s);
            let grid = Grid::new(&machine);
            assert_eq!(grid.steps, steps, "{stop_s} s by {step_s} s");
            assert!((grid.step_s - expected_s).abs() < 1e-15, "{} s, expected {expected_s}", grid.step_s);
            assert_eq!(grid.time_s(grid.steps), stop_s);
        }
    }

    /// Both experiments reach the end, are in the CSV format of the cross-check (quoted names, at most ten) and differ by the effect of the
    /// inputs; every file listed in the manifest or the experiments exists.
    #[test]
    fn reference_holds_two_experiments_and_names_its_files() {
        let machine = two_body_machine();
        let reference = Reference::simulate(&machine).unwrap();
        let [default, inputs] = &reference.experiments;
        for experiment in [default, inputs] {
            let lines: Vec<&str> = experiment.result.lines().collect();
            assert_eq!(lines.len(), 402, "header, start and 400 steps");
            assert!(lines[0].starts_with("\"time\",\"fold.angle\","), "{}", lines[0]);
            // the wing moves in its plane of symmetry, so constant columns are omitted
            assert!(!lines[0].contains("tip.position.y"), "{}", lines[0]);
            assert!(lines[0].split(',').count() <= 1 + MAXIMUM_VARIABLES);
            assert!(lines[401].starts_with("0.4,"), "{}", lines[401]);
            assert!(experiment.result.len() < 100_000, "{} bytes", experiment.result.len());
        }
        assert_ne!(default.result, inputs.result);
        let stimuli: Vec<&str> = inputs.stimuli.as_ref().unwrap().lines().collect();
        assert_eq!(stimuli.len(), 4, "header, start, peak, end");
        assert_eq!(stimuli[1].split_once(',').unwrap().1, stimuli[3].split_once(',').unwrap().1);
        assert_ne!(stimuli[1].split_once(',').unwrap().1, stimuli[2].split_once(',').unwrap().1);

        let files = reference.files(&machine);
        let texts = [&files[&format!("{FOLDER}/fmi-ls-manifest.xml")], &files[&format!("{FOLDER}/experiments.exp")]];
        let sources: Vec<&str> = texts
            .iter()
            .flat_map(|text| text.split("source=\"").skip(1).map(|rest| rest.split('"').next().unwrap()))
            .collect();
        assert_eq!(sources.len(), 7, "{sources:?}");
        for source in sources.into_iter().filter(|source| !source.starts_with("..")) {
            assert!(files.contains_key(&format!("{FOLDER}/{source}")), "{source} is named and missing");
        }
        let notes = &files["documentation/fmi-ls-ref.txt"];
        assert!(notes.contains("at most 1e-6 of a variable's range over the run, or 1e-9 in its unit"), "{notes}");
    }
}
