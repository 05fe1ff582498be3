//! `foldwing simulate`: outputs over time as CSV.

use crate::cli::choice::chosen;
use crate::cli::grid::{Grid, GridArguments, grid_of};
use crate::cli::implausible::{self, Times};
use crate::cli::lattice::LatticeRecord;
use crate::cli::notes::notes;
use crate::cli::outlets::{Force, Mark, Outlet, Outlets, Place};
use crate::cli::pictures::{PictureArguments, Pictures, SheetArguments};
use crate::cli::progress::Progress;
use crate::cli::settings::plant_with;
use crate::cli::strains::StrainPeaks;
use crate::cli::timing::Timing;
use crate::cli::{Failure, print, read_bytes, read_model, shown, tell};
use crate::report::recording::FRAMES;
use crate::report::{Channel, InputTable, InputsError, Recorder};
use clap::builder::NonEmptyStringValueParser;
use foldwing_engine::plant::{OutputSet, Plant};
use foldwing_fmi::interface::{Causality, Interface, Variable};
use serde_json::json;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::SIMULATE)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// CSV file to write; `-` is standard output
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,
    /// Inputs over time: CSV with a column `time` and columns named after inputs, `-` for standard input; values are taken at the start of
    /// each step, with real inputs interpolated linearly between rows and Booleans held
    #[arg(long, value_name = "IN.csv")]
    inputs: Option<PathBuf>,
    /// Start value of an input or parameter; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    #[command(flatten)]
    grid: GridArguments,
    /// CSV file for the largest longitudinal strain of every section (ends of the elements) over the run
    #[arg(long, value_name = "OUT.csv")]
    strains: Option<PathBuf>,
    /// JSON file for the vortex lattice and its wake at the times of `--lattice-at`
    #[arg(long, value_name = "OUT.json", requires = "lattice_at")]
    lattice: Option<PathBuf>,
    /// Time in s at which to write the lattice; may be repeated. The file has its state at the end of the aerodynamic step that contains the
    /// next communication point
    #[arg(long, value_name = "S", requires = "lattice", allow_negative_numbers = true)]
    lattice_at: Vec<f64>,
    /// Variables to write: names or patterns (`fold.*`), separated by commas; may be repeated [default: all outputs]
    #[arg(long = "variables", value_name = "NAME")]
    outputs: Vec<String>,
    /// JSON file for the cost of the run: processor time, wall times of initialisation, steps and output, counts of steps,
    /// rejections, iterations and factorisations
    #[arg(long = "profile", value_name = "OUT.json")]
    timing: Option<PathBuf>,
    #[command(flatten)]
    pictures: PictureArguments,
    #[command(flatten)]
    force: Force,
    /// Print the summary as JSON on standard output, for programs: joints, solver statistics, notes, warnings, written files
    #[arg(long)]
    json: bool,
    /// Print no summary
    #[arg(short, long)]
    quiet: bool,
}

impl Arguments {
    /// Arguments of a simulation whose only output is the HTML page.
    pub(super) fn for_page(
        model: PathBuf,
        page: PathBuf,
        inputs: Option<PathBuf>,
        settings: Vec<String>,
        grid: GridArguments,
        beside: Vec<PathBuf>,
        (force, quiet, json): (Force, bool, bool),
    ) -> Self {
        let sheets = SheetArguments::DEFAULT;
        let pictures = PictureArguments { plot: None, sheets, view: Some(page), beside, vtk: None, frames: FRAMES };
        Self {
            model,
            csv: None,
            inputs,
            settings,
            grid,
            strains: None,
            lattice: None,
            lattice_at: Vec::new(),
            outputs: Vec::new(),
            timing: None,
            pictures,
            force,
            json,
            quiet,
        }
    }
}

/// Simulates and writes the CSV; the rows before an error are kept.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    one_standard_input([Some(arguments.model.as_path()), arguments.inputs.as_deref()])?;
    one_standard_output(arguments.json, arguments.csv.as_deref())?;
    let (machine, _) = read_model(&arguments.model)?;
    let experiment = &machine.experiment;
    let grid = grid_of(&arguments.grid, experiment.start_time_s, experiment.stop_time_s, experiment.step_s)?;
    let interface = Interface::new(&machine);
    let recorded = recorded(&arguments.outputs, &interface)?;
    let inputs = arguments.inputs.as_ref().map(|path| read_inputs(path, interface.variables())).transpose()?;
    let mut plant = plant_with(machine, &interface, &arguments.settings)?;
    if arguments.strains.is_none() && arguments.lattice.is_none() && !arguments.pictures.any() {
        let rows: Vec<u32> = recorded.iter().map(|variable| variable.value_reference).collect();
        plant.watch(interface.needs(rows.as_slice()) | OutputSet::JOINTS); // the summary includes the joints
    }

    let read = [Some(arguments.model.as_path()), arguments.inputs.as_deref()].into_iter().flatten();
    let read = read.chain(arguments.pictures.beside.iter().map(PathBuf::as_path));
    let mut outlets = Outlets::new(arguments.force.force, read);
    let names = || recorded.iter().map(|variable| variable.name.as_str());
    let csv = outlets.place_if(arguments.csv.as_deref(), table(&recorded))?;
    let reports = Reports::new(arguments, &mut outlets)?;
    let named = if arguments.outputs.is_empty() { &[] } else { recorded.as_slice() };
    let pictures = Pictures::new(&arguments.pictures, &grid, &recorded, named, &mut outlets)?;
    let csv = csv.open()?;
    let target = csv.name().to_owned();
    let writing = |error: io::Error| Failure::writing(&target, &error);
    let mut run = Run {
        plant,
        interface: &interface,
        inputs,
        recorded: &recorded,
        value_references: recorded.iter().map(|variable| variable.value_reference).collect(),
        recorder: Recorder::new(csv, names()).map_err(writing)?,
        strains: arguments.strains.as_ref().map(|_| StrainPeaks::default()),
        lattices: arguments.lattice.as_ref().map(|_| LatticeRecord::new(arguments.lattice_at.clone())),
        timing: None,
        pictures,
    };
    let clock = Instant::now();
    run.timing = arguments.timing.as_ref().map(|_| Timing::start());
    let outcome = run.through(&grid, &writing);
    if let Some(timing) = &mut run.timing {
        timing.finish();
    }
    if let Err(Failure::Usage(_) | Failure::Files(_) | Failure::Closed) = outcome {
        return outcome; // nothing was computed, or nothing can be written: an existing file is kept
    }
    let Run { plant, recorder, strains, lattices, timing, pictures, .. } = run;
    recorder.finish().map_err(writing)?.finish()?;
    reports.write(timing, strains, lattices, &plant, grid.start_s)?;
    let elapsed = clock.elapsed();
    pictures.write(&mut outlets)?;
    outcome?;
    if arguments.quiet && !arguments.json {
        return Ok(());
    }
    let notes = notes(plant.machine(), grid.stop_s);
    let as_written = arguments.inputs.is_none() && arguments.settings.is_empty();
    let implausible = implausible::run(&plant, as_written, &times(&arguments.grid, &grid));
    let warnings: Vec<String> = advice(&plant).into_iter().chain(implausible).collect();
    if !arguments.quiet {
        notes.iter().for_each(|note| tell::note(note));
        warnings.iter().for_each(|warning| tell::warning(warning));
        if !arguments.json {
            eprint!("{}", summary(&plant, &grid, elapsed));
        }
        outlets.report();
    }
    if arguments.json {
        let mut value = summary_json(&plant, &grid, elapsed);
        value["notes"] = json!(notes);
        value["warnings"] = json!(warnings);
        value["files"] = json!(outlets.files());
        return print(&format!("{value:#}"));
    }
    Ok(())
}

/// Checks that a table and the summary of `--json` do not both go to standard output.
pub fn one_standard_output(json: bool, csv: Option<&Path>) -> Result<(), Failure> {
    if json && csv == Some(Path::new("-")) {
        return Err(Failure::Usage(
            "--csv -: --json writes to standard output too; name a file for the table".to_owned(),
        ));
    }
    Ok(())
}

/// Mark of a CSV of these variables. A table with only inputs has none, since the user may have written it for a run.
fn table(recorded: &[&Variable]) -> Mark {
    if recorded.iter().all(|variable| variable.causality == Causality::Input) {
        return Mark::Never;
    }
    Mark::table(std::iter::once("time").chain(recorded.iter().map(|variable| variable.name.as_str())))
}

/// Files written at the end of a run in addition to the CSV and the pictures.
struct Reports {
    timing: Place,
    strains: Place,
    lattices: Place,
}

impl Reports {
    fn new(arguments: &Arguments, outlets: &mut Outlets) -> Result<Self, Failure> {
        Ok(Self {
            timing: outlets.place_if(arguments.timing.as_deref(), Mark::TIMING)?,
            strains: outlets.place_if(arguments.strains.as_deref(), Mark::table(StrainPeaks::COLUMNS))?,
            lattices: outlets.place_if(arguments.lattice.as_deref(), Mark::LATTICE)?,
        })
    }

    fn write(
        self,
        timing: Option<Timing>,
        strains: Option<StrainPeaks>,
        lattices: Option<LatticeRecord>,
        plant: &Plant,
        start_s: f64,
    ) -> Result<(), Failure> {
        if let Some(timing) = timing {
            let simulated_s = plant.time_s() - start_s;
            written(self.timing, |sink| timing.write(&plant.statistics(), simulated_s, sink))?;
        }
        if let Some(strains) = strains {
            written(self.strains, |sink| strains.write(plant, sink))?;
        }
        if let Some(lattices) = lattices {
            written(self.lattices, |sink| lattices.write(sink))?;
        }
        Ok(())
    }
}

/// Opens a file, calls `write` on it, and finishes it.
fn written(place: Place, write: impl FnOnce(&mut Outlet) -> io::Result<()>) -> Result<(), Failure> {
    let mut outlet = place.open()?;
    write(&mut outlet).map_err(|error| outlet.failure(&error))?;
    outlet.finish()
}

/// Checks that at most one input file is read from standard input.
pub(super) fn one_standard_input<'a>(read: impl IntoIterator<Item = Option<&'a Path>>) -> Result<(), Failure> {
    let count = read.into_iter().flatten().filter(|path| *path == Path::new("-")).count();
    if count > 1 {
        return Err(Failure::Usage("-: standard input can be read only once; name the other file".to_owned()));
    }
    Ok(())
}

/// Variables of the table: the named ones, or all outputs without names.
fn recorded<'a>(names: &[String], interface: &'a Interface) -> Result<Vec<&'a Variable>, Failure> {
    let variables = interface.variables();
    if names.is_empty() {
        return Ok(variables.iter().filter(|variable| variable.causality == Causality::Output).collect());
    }
    chosen(names, &variables.iter().collect::<Vec<_>>(), "variable")
}

/// Reads inputs over time from a file.
pub fn read_inputs(path: &Path, variables: &[impl Channel]) -> Result<InputTable, Failure> {
    let name = shown(path);
    let unreadable = |error: io::Error| Failure::Files(format!("{name}: cannot be read: {error}"));
    let source: Box<dyn Read> = match path == Path::new("-") {
        true => Box::new(io::Cursor::new(read_bytes(path)?)),
        false => Box::new(File::open(path).map_err(unreadable)?),
    };
    InputTable::read(source, &name, variables).map_err(|error| {
        let unreadable = matches!(error, InputsError::Unreadable { .. });
        if unreadable { Failure::Files(error.to_string()) } else { Failure::Refused(error.to_string()) }
    })
}

/// Sets the inputs of the step that starts at `time_s`, if a table has them.
pub(super) fn feed(
    inputs: Option<&InputTable>,
    interface: &Interface,
    plant: &mut Plant,
    time_s: f64,
) -> Result<(), Failure> {
    let Some(table) = inputs else { return Ok(()) };
    for (row, value) in table.at(time_s) {
        interface
            .set(plant, interface.variables()[row].value_reference, value)
            .map_err(|error| Failure::Refused(format!("input at {time_s} s: {error}")))?;
    }
    Ok(())
}

/// Simulation in progress.
struct Run<'a, W: Write> {
    plant: Plant,
    interface: &'a Interface,
    inputs: Option<InputTable>,
    recorded: &'a [&'a Variable],
    /// Their value references.
    value_references: Vec<u32>,
    recorder: Recorder<W>,
    /// Largest strains, if requested.
    strains: Option<StrainPeaks>,
    /// Lattices, if requested.
    lattices: Option<LatticeRecord>,
    /// Timing, if requested.
    timing: Option<Timing>,
    pictures: Pictures<'a>,
}

impl<W: Write> Run<'_, W> {
    fn through(&mut self, grid: &Grid, writing: &impl Fn(io::Error) -> Failure) -> Result<(), Failure> {
        let failed = |error: foldwing_engine::plant::PlantError| Failure::Simulation(error.to_string());
        feed(self.inputs.as_ref(), self.interface, &mut self.plant, grid.start_s)?;
        self.plant.initialize(grid.start_s).map_err(failed)?;
        if self.lattices.is_some() && self.plant.lattice().is_none() {
            return Err(Failure::Usage("--lattice: the model has no vortex lattice".to_owned()));
        }
        self.record(grid.start_s).map_err(writing)?;
        if let Some(timing) = &mut self.timing {
            timing.initialized();
        }
        let mut progress = Progress::of("time", grid.steps);
        for point in 1..=grid.steps {
            feed(self.inputs.as_ref(), self.interface, &mut self.plant, grid.time_s(point - 1))?;
            let time_s = grid.time_s(point);
            let begin = self.timing.is_some().then(Instant::now);
            if let Err(error) = self.plant.step(time_s) {
                if self.plant.time_s() > grid.time_s(point - 1) {
                    self.record(self.plant.time_s()).map_err(writing)?; // the last time reached without an error
                }
                return Err(failed(error));
            }
            let end = begin.map(|begin| (begin, Instant::now()));
            self.record(time_s).map_err(writing)?;
            if let (Some(timing), Some((begin, end))) = (&mut self.timing, end) {
                timing.stepped(begin, end);
            }
            progress.at(point);
        }
        Ok(())
    }

    fn record(&mut self, time_s: f64) -> io::Result<()> {
        let (plant, interface) = (&self.plant, self.interface);
        if let Some(strains) = &mut self.strains {
            strains.include(plant);
        }
        if let Some(lattices) = &mut self.lattices {
            lattices.include(plant);
        }
        let value = |variable: &&Variable| {
            interface.get(plant, plant.outputs(), variable.value_reference).expect("rows come from the same table")
        };
        self.pictures.include(plant, self.recorded.iter().map(value));
        self.recorder.record_variables(time_s, interface, plant, &self.value_references)
    }
}

/// Advice on the run.
fn advice(plant: &Plant) -> Vec<String> {
    let statistics = plant.statistics();
    let on_rows = plant.machine().air.as_ref().and_then(|air| statistics.advice_on_rows(air.step_s));
    [on_rows, statistics.advice_on_stall(), statistics.advice_on_failures()].into_iter().flatten().collect()
}

/// Times of the run, with the names of the options or keys that set them.
fn times(given: &GridArguments, grid: &Grid) -> Times {
    let [_, stop, step] = given.given();
    Times {
        start_s: grid.start_s,
        stop_s: grid.stop_s,
        step_s: grid.step_s,
        step_name: if step.is_some() { "--step" } else { "[simulation] step_s =" },
        stop_name: if stop.is_some() { "the run" } else { "[simulation]" },
    }
}

/// Summary as JSON: final values of the joints with one degree of freedom, and the statistics of the solver.
fn summary_json(plant: &Plant, grid: &Grid, elapsed: Duration) -> serde_json::Value {
    let machine = plant.machine();
    let outputs = plant.outputs().joints().iter().zip(plant.outputs().latches());
    let joints = outputs.zip(plant.revolute_joints()).filter_map(|((joint, latch), body)| {
        let holder = &machine.bodies[*body].joint;
        let (travel, own) = holder.kind.one_freedom()?;
        let count = latch.count.get();
        Some(json!({
            "name": holder.name,
            (travel.words("angle_rad")): joint.angle_rad,
            "has_latch": own.latch.is_some(),
            "latched": latch.closed.is_on(),
            "latch_count": count,
            "latch_time_s": (count > 0).then_some(latch.time_s),
        }))
    });
    let joints: Vec<serde_json::Value> = joints.collect();
    let statistics = plant.statistics();
    json!({
        "name": machine.name,
        "start_s": grid.start_s,
        "stop_s": grid.stop_s,
        "rows": grid.steps + 1,
        "elapsed_s": elapsed.as_secs_f64(),
        "joints": joints,
        "solver": {
            "steps": statistics.steps,
            "rejections": statistics.rejections,
            "failures": statistics.failures,
            "iterations": statistics.iterations,
            "factorizations": statistics.factorizations,
            "events": statistics.events,
        },
    })
}

/// Summary as text of a few lines.
fn summary(plant: &Plant, grid: &Grid, elapsed: Duration) -> String {
    let machine = plant.machine();
    let mut text = String::new();
    let outputs = plant.outputs().joints().iter().zip(plant.outputs().latches());
    for ((joint, latched), body) in outputs.zip(plant.revolute_joints()) {
        let holder = &machine.bodies[*body].joint;
        let name = &holder.name;
        let Some((travel, own)) = holder.kind.one_freedom() else { continue };
        let latch = own.latch.as_ref();
        let latch = match (latch, latched.count.get()) {
            (None, _) => "has no latch".to_owned(),
            (Some(_), 0) if latched.closed.is_on() => "latched from the start".to_owned(),
            (Some(latch), 0) if latch.initially_closed => "latch open at the end".to_owned(),
            (Some(_), 0) => "did not latch".to_owned(),
            (Some(_), count) => format!("latched at {:.6} s ({count} in all)", latched.time_s),
        };
        let end = travel.told(joint.angle_rad);
        text += &format!("{name}: {latch}, {end} at the end\n");
    }
    let statistics = plant.statistics();
    text + &format!(
        "{:.6} s simulated in {:.4} s: {} steps, {} rejected, {} failed, {} iterations, {} events\n",
        grid.stop_s - grid.start_s,
        elapsed.as_secs_f64(),
        statistics.steps,
        statistics.rejections,
        statistics.failures,
        statistics.iterations,
        statistics.events
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packaging::drawing::tests::two_body_machine;

    /// A table with other columns than inputs is recognised by its header; a table with only inputs is never recognised.
    #[test]
    fn only_tables_of_inputs_alone_are_never_replaced() {
        let interface = Interface::new(&two_body_machine());
        let of =
            |causality: Causality| interface.variables().iter().filter(move |row| row.causality == causality).take(2);
        let rows: Vec<&Variable> =
            [Causality::Input, Causality::Output, Causality::Parameter].into_iter().flat_map(of).collect();
        assert_eq!(rows.len(), 6);
        for chosen in 1..1_u32 << rows.len() {
            let chosen: Vec<&Variable> =
                rows.iter().enumerate().filter(|(i, _)| (chosen >> i) & 1 == 1).map(|(_, row)| *row).collect();
            let names: Vec<&str> = chosen.iter().map(|row| row.name.as_str()).collect();
            let inputs = chosen.iter().filter(|row| row.causality == Causality::Input).count();
            match table(&chosen) {
                Mark::Never => assert_eq!(inputs, chosen.len(), "{names:?}"),
                Mark::Table(line) => {
                    assert!(inputs < chosen.len(), "{names:?}");
                    assert_eq!(String::from_utf8_lossy(&line), format!("time,{}\n", names.join(",")));
                }
                Mark::Head { name, .. } | Mark::Archive { name, .. } => panic!("{names:?}: {name}"),
            }
        }
    }
}
