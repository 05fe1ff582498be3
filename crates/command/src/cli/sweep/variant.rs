//! One variant of a sweep: its model, run and row of results.

use crate::cli::Failure;
use crate::cli::grid::{Grid, GridArguments, grid_of};
use crate::cli::settings::{apply_setting, plant_with};
use crate::cli::simulate::feed;
use crate::cli::sweep::pictures::Pictures;
use crate::cli::sweep::plan::{Plan, file_path};
use crate::report::{InputTable, cell};
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{OutputSet, Plant};
use foldwing_file as config;
use foldwing_fmi::interface::{Interface, Value};
use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// Settings common to the variants.
pub(in crate::cli) struct Experiment<'a> {
    /// Name of the model file, for messages.
    pub file: String,
    /// Machine of the unchanged model file.
    pub machine: Arc<Machine>,
    /// Variables of this model.
    pub interface: Arc<Interface>,
    /// Text of the model file.
    pub text: &'a str,
    /// The variants.
    pub plan: &'a Plan,
    /// Values of `--set`, for all variants.
    pub settings: &'a [String],
    /// Inputs over time, for all variants.
    pub inputs: Option<&'a InputTable>,
    /// Communication points, if given on the command line.
    pub grid: &'a GridArguments,
    /// Variables whose final values are recorded.
    pub outputs: &'a [String],
}

/// Names of the columns: number and values of the variant, status, final values, measurements, message.
///
/// # Errors
/// Two columns with the same name.
pub(in crate::cli) fn columns(plan: &Plan, outputs: &[String], machine: &Machine) -> Result<Vec<String>, Failure> {
    let mut columns = vec!["variant".to_owned()];
    columns.extend(plan.keys().iter().cloned());
    columns.extend(["status", "end_time"].map(str::to_owned));
    columns.extend(outputs.iter().cloned());
    columns.extend(latches(machine).map(|(_, name)| format!("{name}.first_latch_time")));
    columns.extend(machine.gauges.iter().map(|gauge| format!("gauge.{}.strain.peak", gauge.name)));
    columns.extend(["steps", "rejections", "iterations", "message"].map(str::to_owned));
    let mut seen = HashSet::new();
    match columns.iter().find(|column| !seen.insert(column.as_str())) {
        Some(twice) => Err(Failure::Usage(format!("--variables {twice}: this column exists already"))),
        None => Ok(columns),
    }
}

/// Joints with a latch: index among the revolute and prismatic joints, and name.
fn latches(machine: &Machine) -> impl Iterator<Item = (usize, &str)> {
    let revolutes = machine.bodies.iter().filter_map(|body| {
        let (_, own) = body.joint.kind.one_freedom()?;
        Some((own.latch.is_some(), body.joint.name.as_str()))
    });
    revolutes.enumerate().filter(|(_, (latched, _))| *latched).map(|(place, (_, name))| (place, name))
}

/// Measurements during the run of a variant.
struct Measures {
    first_latch_time_s: Vec<Option<f64>>,
    peaks: Vec<f64>,
}

impl Measures {
    fn include(&mut self, plant: &Plant) {
        for (peak, strain) in self.peaks.iter_mut().zip(plant.outputs().gauges()) {
            *peak = peak.max(strain.abs());
        }
        for (first, joint) in self.first_latch_time_s.iter_mut().zip(plant.joint_statuses()) {
            if first.is_none() && joint.latch_count > 0 {
                *first = Some(joint.latch_time_s);
            }
        }
    }
}

/// Returns the text of a model file with other values of some keys; messages start with `place`. Parts of a path may be array indices,
/// which start at 0.
pub(in crate::cli) fn changed_text(text: &str, place: &str, changes: &[(Vec<&str>, &str)]) -> Result<String, Failure> {
    let mut tree: toml::Table = toml::from_str(text).map_err(|error| Failure::Refused(error.to_string()))?;
    for (path, value) in changes {
        let refused = |cause: &str| Failure::Usage(format!("{place} file:{}={value}: {cause}", path.join(".")));
        // a value that is not valid TOML is taken as a string: file:solver.method=esdirk3
        let parsed = toml::from_str::<toml::Table>(&format!("value = {value}")).ok();
        let parsed = parsed.filter(|table| table.len() == 1).and_then(|mut table| table.remove("value"));
        let parsed = parsed.unwrap_or_else(|| toml::Value::String((*value).to_owned()));
        let (first, further) = path.split_first().expect("paths have at least one part");
        let mut entry = tree.entry(*first).or_insert_with(|| toml::Table::new().into());
        for name in further {
            entry = match entry {
                toml::Value::Table(table) => table.entry(*name).or_insert_with(|| toml::Table::new().into()),
                toml::Value::Array(array) => {
                    let count = array.len();
                    let index = name.parse().ok().filter(|index: &usize| *index < count);
                    let index = index.ok_or_else(|| {
                        refused(&format!(
                            "{name} is not an index of the array, which has {count} entries; indices start at 0"
                        ))
                    })?;
                    &mut array[index]
                }
                toml::Value::String(_)
                | toml::Value::Integer(_)
                | toml::Value::Float(_)
                | toml::Value::Boolean(_)
                | toml::Value::Datetime(_) => {
                    let at = path.iter().position(|part| part == name).unwrap_or(1);
                    return Err(refused(&format!("{} is not a table", path[at - 1])));
                }
            };
        }
        *entry = parsed;
    }
    toml::to_string(&tree).map_err(|error| Failure::Refused(error.to_string()))
}

/// Returns the number at a key of a model file, or the reason why there is none.
pub(in crate::cli) fn number_in_file(text: &str, path: &[&str]) -> Result<f64, String> {
    let tree: toml::Value = toml::from_str(text).map_err(|error| error.to_string())?;
    let mut entry = &tree;
    for name in path {
        let next = match entry {
            toml::Value::Table(table) => table.get(*name),
            toml::Value::Array(array) => name.parse().ok().and_then(|index: usize| array.get(index)),
            toml::Value::String(_)
            | toml::Value::Integer(_)
            | toml::Value::Float(_)
            | toml::Value::Boolean(_)
            | toml::Value::Datetime(_) => None,
        };
        entry = next
            .ok_or_else(|| format!("the model file has no key `{name}` there; set it to a number in the file first"))?;
    }
    match entry {
        toml::Value::Float(value) => Ok(*value),
        toml::Value::Integer(value) => Ok(*value as f64),
        toml::Value::String(_) | toml::Value::Boolean(_) | toml::Value::Datetime(_) => {
            Err("is not a number".to_owned())
        }
        toml::Value::Array(array) => {
            Err(format!("is an array; name one of its {} entries, such as file:{}.0", array.len(), path.join(".")))
        }
        toml::Value::Table(_) => Err("is a table; name one of its keys".to_owned()),
    }
}

/// Returns the machine of a model file, given by its name and text, with other values of some keys; messages start with `place`.
pub(in crate::cli) fn changed_machine(
    (file, text): (&str, &str),
    place: &str,
    changes: &[(Vec<&str>, &str)],
) -> Result<Machine, Failure> {
    let text = changed_text(text, place, changes)?;
    config::parse(&text, file).map_err(|error| {
        let what: Vec<String> =
            changes.iter().map(|(path, value)| format!("file:{}={value}", path.join("."))).collect();
        // omit line numbers: they refer to the changed text, which the user does not have
        let cause = |problem: &config::Problem| {
            let text = problem.to_string();
            text.split_once(": ").map_or(text.clone(), |(_line, rest)| rest.to_owned())
        };
        let causes: Vec<String> = error.problems().iter().map(cause).collect();
        Failure::Usage(format!("{place} {}: {}: {}", what.join(" "), file, causes.join("; ")))
    })
}

impl Experiment<'_> {
    /// Sets every value of every key once, so that invalid values are reported before the first run.
    ///
    /// A value of a key of the model file is checked in the first variant that has it; if it is invalid only in combination with other
    /// values, those variants fail.
    pub fn check_values(&self) -> Result<(), Failure> {
        let mut plant = plant_with(Arc::clone(&self.machine), &self.interface, self.settings)?;
        let mut seen = vec![HashSet::new(); self.plan.keys().len()];
        for index in 0..self.plan.count() {
            let values = self.plan.variant(index);
            let place = self.plan.place(index);
            let mut file_changes = false;
            for ((key, &value), seen) in self.plan.keys().iter().zip(&values).zip(&mut seen) {
                if !seen.insert(value) {
                    continue;
                }
                if file_path(key).is_some() {
                    file_changes = true;
                } else {
                    apply_setting(&place, &format!("{key}={value}"), &self.interface, &mut plant)?;
                }
            }
            if file_changes {
                self.prepare(index, &values)?;
            }
        }
        Ok(())
    }

    /// Returns the plant of a variant and its variables.
    pub fn prepare(&self, index: usize, values: &[&str]) -> Result<(Plant, Arc<Interface>), Failure> {
        let place = self.plan.place(index);
        let keyed = || self.plan.keys().iter().zip(values);
        let changes: Vec<_> = keyed().filter_map(|(key, value)| Some((file_path(key)?, *value))).collect();
        let (machine, interface) = if changes.is_empty() {
            (Arc::clone(&self.machine), Arc::clone(&self.interface))
        } else {
            let machine = self.changed(&place, &changes)?;
            let interface = Interface::new(&machine);
            (Arc::new(machine), Arc::new(interface))
        };
        let mut plant = plant_with(machine, &interface, self.settings)?;
        for (key, value) in keyed().filter(|(key, _)| file_path(key).is_none()) {
            apply_setting(&place, &format!("{key}={value}"), &interface, &mut plant)?;
        }
        Ok((plant, interface))
    }

    /// Returns the machine with other values of some keys of the model file.
    fn changed(&self, place: &str, changes: &[(Vec<&str>, &str)]) -> Result<Machine, Failure> {
        changed_machine((&self.file, self.text), place, changes)
    }

    /// Runs a variant and returns its cells without the variant number. Errors are in the message column of the row.
    pub fn run(&self, index: usize, pictures: Option<&mut Pictures>) -> Vec<String> {
        let values = self.plan.variant(index);
        let cells = catch_unwind(AssertUnwindSafe(|| match self.prepare(index, &values) {
            Ok((plant, interface)) => self.simulate(plant, &interface, pictures),
            Err(failure) => self.without_result(&failure.to_string()),
        }));
        let cells = cells.unwrap_or_else(|_| self.without_result("internal error: the variant panicked"));
        values.into_iter().map(str::to_owned).chain(cells).collect()
    }

    /// Cells of a variant that was not run.
    fn without_result(&self, message: &str) -> Vec<String> {
        let empty = 1 + self.outputs.len() + latches(&self.machine).count() + self.machine.gauges.len() + 3;
        let mut cells = vec!["failed".to_owned()];
        cells.extend(std::iter::repeat_n(String::new(), empty));
        cells.push(one_line(message));
        cells
    }

    fn simulate(&self, mut plant: Plant, interface: &Interface, mut pictures: Option<&mut Pictures>) -> Vec<String> {
        let mut measures = Measures {
            first_latch_time_s: vec![None; plant.revolute_joints().len()],
            peaks: vec![0.0; plant.machine().gauges.len()],
        };
        if pictures.is_none() {
            plant.watch(OutputSet::GAUGES);
        }
        let outcome = self.march(&mut plant, interface, &mut measures, pictures.as_deref_mut());
        if let Some(pictures) = pictures {
            pictures.finish(outcome.is_ok());
        }
        plant.provide(OutputSet::ALL);
        let (status, message) = match outcome {
            Ok(()) => ("done", String::new()),
            Err(failure) => ("failed", one_line(&failure.to_string())),
        };
        let real = |value: f64| cell(&Value::Real(value));
        let mut cells = vec![status.to_owned(), real(plant.time_s())];
        cells.extend(self.outputs.iter().map(|name| {
            let value =
                interface.find(name).and_then(|row| interface.get(&plant, plant.outputs(), row.value_reference));
            value.as_ref().map(cell).unwrap_or_default()
        }));
        // a changed model file may have different joints and gauges: columns are matched by name
        let machine = plant.machine();
        cells.extend(latches(&self.machine).map(|(_, name)| {
            let place = latches(machine).find(|(_, other)| *other == name).map(|(place, _)| place);
            place.map(|place| real(measures.first_latch_time_s[place].unwrap_or(-1.0))).unwrap_or_default()
        }));
        cells.extend(self.machine.gauges.iter().map(|gauge| {
            let place = machine.gauges.iter().position(|other| other.name == gauge.name);
            place.map(|place| real(measures.peaks[place])).unwrap_or_default()
        }));
        let statistics = plant.statistics();
        cells.extend([statistics.steps, statistics.rejections, statistics.iterations].map(|count| count.to_string()));
        cells.push(message);
        cells
    }

    fn march(
        &self,
        plant: &mut Plant,
        interface: &Interface,
        measures: &mut Measures,
        mut pictures: Option<&mut Pictures>,
    ) -> Result<(), Failure> {
        let mut include = |plant: &Plant, grid: &Grid| {
            measures.include(plant);
            if let Some(pictures) = &mut pictures {
                pictures.include(plant, interface, grid.steps);
            }
        };
        let experiment = &plant.machine().experiment;
        let (start_s, stop_s) = (experiment.start_time_s, experiment.stop_time_s);
        let grid = grid_of(self.grid, start_s, stop_s, experiment.step_s)?;
        let failed = |error: foldwing_engine::plant::PlantError| Failure::Simulation(error.to_string());
        feed(self.inputs, interface, plant, grid.start_s)?;
        plant.initialize(grid.start_s).map_err(failed)?;
        include(plant, &grid);
        for point in 1..=grid.steps {
            feed(self.inputs, interface, plant, grid.time_s(point - 1))?;
            let outcome = plant.step(grid.time_s(point));
            include(plant, &grid);
            outcome.map_err(failed)?;
        }
        Ok(())
    }
}

/// Replaces line breaks, because a message occupies a single line of the table.
fn one_line(message: &str) -> String {
    message
        .split(|c: char| c.is_control())
        .map(str::trim)
        .filter(|part| !part.is_empty())
        .collect::<Vec<_>>()
        .join("; ")
}
