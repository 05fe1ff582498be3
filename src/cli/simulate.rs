//! `foldwing simulate`: outputs over time as CSV.

use crate::cli::lattice::LatticeRecord;
use crate::cli::settings::plant_with;
use crate::cli::strains::StrainPeaks;
use crate::cli::timing::Timing;
use crate::cli::{Failure, read_model};
use clap::builder::NonEmptyStringValueParser;
use foldwing::config::Machine;
use foldwing::config::machine::JointKind;
use foldwing::interface::{Causality, Interface, Variable};
use foldwing::plant::Plant;
use foldwing::report::inputs::unknown_name;
use foldwing::report::{InputTable, Recorder};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Shorter runs show no progress bar.
const PROGRESS_AFTER: Duration = Duration::from_millis(500);

#[derive(clap::Args)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// CSV file to write; `-` is standard output
    #[arg(long, value_name = "OUT.csv")]
    csv: PathBuf,
    /// Inputs over time: CSV with a column `time` and columns named after inputs; taken at the start of each step,
    /// reals on straight lines between rows, Booleans held
    #[arg(long, value_name = "IN.csv")]
    inputs: Option<PathBuf>,
    /// Start value of an input or parameter; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Communication step in s [default: the model's]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    step: Option<f64>,
    /// Start time in s [default: the model's]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    start: Option<f64>,
    /// Stop time in s [default: the model's]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    stop: Option<f64>,
    /// CSV file for the largest longitudinal strain of every section (ends of the elements) over the run
    #[arg(long, value_name = "OUT.csv")]
    strains: Option<PathBuf>,
    /// JSON file for the vortex lattice and its wake at the times of `--lattice-at`
    #[arg(long, value_name = "OUT.json", requires = "lattice_at")]
    lattice: Option<PathBuf>,
    /// Time in s at which the lattice is written; may be repeated. Taken at the next communication point, at the end of
    /// the aerodynamic step there
    #[arg(long, value_name = "S", requires = "lattice", allow_negative_numbers = true)]
    lattice_at: Vec<f64>,
    /// Variable to write; may be repeated [default: all outputs]
    #[arg(long = "output", value_name = "NAME")]
    outputs: Vec<String>,
    /// JSON file for what the run costs: processor time, wall time of start, steps and rows, counts of steps,
    /// rejections, iterations and factorisations
    #[arg(long, value_name = "OUT.json")]
    timing: Option<PathBuf>,
    /// Print no summary
    #[arg(short, long)]
    quiet: bool,
}

/// Simulates and writes the CSV; the rows up to a failure are kept.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (machine, _) = read_model(&arguments.model)?;
    let grid = Grid::new(arguments, &machine)?;
    let interface = Interface::new(&machine);
    let recorded = recorded(&arguments.outputs, &interface)?;
    let inputs = arguments.inputs.as_ref().map(|path| read_inputs(path, &interface)).transpose()?;
    let plant = plant_with(machine, &interface, &arguments.settings)?;

    let target = arguments.csv.display().to_string();
    let writing = |error: io::Error| Failure::writing(&target, &error);
    let sink: Box<dyn Write> = match target.as_str() {
        "-" => Box::new(io::stdout().lock()),
        path => Box::new(File::create(path).map_err(writing)?),
    };
    let recorder = Recorder::new(BufWriter::new(sink), &recorded).map_err(writing)?;
    let strains = arguments.strains.as_ref().map(|_| StrainPeaks::default());
    let lattices = arguments.lattice.as_ref().map(|_| LatticeRecord::new(arguments.lattice_at.clone()));
    let mut run =
        Run { plant, interface: &interface, inputs, recorded: &recorded, recorder, strains, lattices, timing: None };
    let clock = Instant::now();
    run.timing = arguments.timing.as_ref().map(|_| Timing::start());
    let outcome = run.through(&grid, &writing);
    if let Some(timing) = &mut run.timing {
        timing.finish();
    }
    let Run { plant, recorder, strains, lattices, timing, .. } = run;
    if let (Some(timing), Some(path)) = (timing, &arguments.timing) {
        let failed = |error: io::Error| Failure::writing(&path.display().to_string(), &error);
        let sink = BufWriter::new(File::create(path).map_err(failed)?);
        timing.write(&plant.statistics(), plant.time_s() - grid.start_s, sink).map_err(failed)?;
    }
    recorder.finish().and_then(|mut sink| sink.flush()).map_err(writing)?;
    if let (Some(strains), Some(path)) = (strains, &arguments.strains) {
        let failed = |error: io::Error| Failure::writing(&path.display().to_string(), &error);
        let sink = BufWriter::new(File::create(path).map_err(failed)?);
        strains.write(&plant, sink).map_err(failed)?;
    }
    if let (Some(lattices), Some(path)) = (lattices, &arguments.lattice) {
        let failed = |error: io::Error| Failure::writing(&path.display().to_string(), &error);
        lattices.write(BufWriter::new(File::create(path).map_err(failed)?)).map_err(failed)?;
    }
    outcome?;
    if !arguments.quiet {
        eprint!("{}", summary(&plant, &grid, clock.elapsed()));
    }
    Ok(())
}

/// Communication points.
struct Grid {
    start_s: f64,
    stop_s: f64,
    step_s: f64,
    steps: u64,
}

impl Grid {
    /// Most rows that a run may have: beyond it the step is surely a slip.
    const MOST_STEPS: f64 = 1e9;

    fn new(arguments: &Arguments, machine: &Machine) -> Result<Self, Failure> {
        let experiment = &machine.experiment;
        let start_s = finite("--start", arguments.start, experiment.start_time_s)?;
        // A start given alone moves the experiment; it does not shorten it.
        let duration_s = experiment.stop_time_s - experiment.start_time_s;
        let stop_s = finite("--stop", arguments.stop, start_s + duration_s)?;
        let step_s = finite("--step", arguments.step, experiment.step_s)?;
        if step_s <= 0.0 {
            return Err(Failure::Usage(format!("--step {step_s}: the step must be positive")));
        }
        if stop_s <= start_s {
            return Err(Failure::Usage(format!("--stop {stop_s}: must lie after the start time, {start_s} s")));
        }
        let steps = ((stop_s - start_s) / step_s - 1e-9).ceil().max(1.0);
        if steps > Self::MOST_STEPS {
            return Err(Failure::Usage(format!(
                "--step {step_s}: {steps:.0} rows are more than {:.0}",
                Self::MOST_STEPS
            )));
        }
        Ok(Self { start_s, stop_s, step_s, steps: steps as u64 })
    }

    /// Time of a communication point; the last is the stop time exactly.
    fn time_s(&self, point: u64) -> f64 {
        if point == self.steps { self.stop_s } else { self.start_s + point as f64 * self.step_s }
    }
}

fn finite(option: &str, given: Option<f64>, default: f64) -> Result<f64, Failure> {
    match given {
        Some(value) if !value.is_finite() => Err(Failure::Usage(format!("{option} {value}: must be a finite number"))),
        Some(value) => Ok(value),
        None => Ok(default),
    }
}

/// Rows of the table to write: those named, else all outputs.
fn recorded<'a>(names: &[String], interface: &'a Interface) -> Result<Vec<&'a Variable>, Failure> {
    let variables = interface.variables();
    if names.is_empty() {
        return Ok(variables.iter().filter(|variable| variable.causality == Causality::Output).collect());
    }
    let find = |name: &String| interface.find(name).ok_or_else(|| unknown(name, "variable", variables));
    names.iter().map(find).collect()
}

/// A name that no row has.
pub(super) fn unknown<'a>(name: &str, what: &str, rows: impl IntoIterator<Item = &'a Variable>) -> Failure {
    Failure::Usage(unknown_name(name, what, rows.into_iter().map(|row| row.name.as_str())))
}

fn read_inputs(path: &PathBuf, interface: &Interface) -> Result<InputTable, Failure> {
    let name = path.display().to_string();
    let file = File::open(path).map_err(|error| Failure::Files(format!("{name}: cannot be read: {error}")))?;
    InputTable::read(file, &name, interface.variables()).map_err(|error| Failure::Refused(error.to_string()))
}

/// One simulation.
struct Run<'a, W: Write> {
    plant: Plant,
    interface: &'a Interface,
    inputs: Option<InputTable>,
    recorded: &'a [&'a Variable],
    recorder: Recorder<W>,
    /// Largest strains, where they are wanted.
    strains: Option<StrainPeaks>,
    /// Lattices, where they are wanted.
    lattices: Option<LatticeRecord>,
    /// Clocks, where they are wanted.
    timing: Option<Timing>,
}

impl<W: Write> Run<'_, W> {
    fn through(&mut self, grid: &Grid, writing: &impl Fn(io::Error) -> Failure) -> Result<(), Failure> {
        let failed = |error: foldwing::plant::PlantError| Failure::Simulation(error.to_string());
        self.feed(grid.start_s)?;
        self.plant.initialize(grid.start_s).map_err(failed)?;
        if self.lattices.is_some() && self.plant.lattice().is_none() {
            return Err(Failure::Usage("--lattice: the model's air is no vortex lattice".to_owned()));
        }
        self.record(grid.start_s).map_err(writing)?;
        if let Some(timing) = &mut self.timing {
            timing.initialized();
        }
        let mut progress = Progress::new(grid.steps);
        for point in 1..=grid.steps {
            self.feed(grid.time_s(point - 1))?;
            let time_s = grid.time_s(point);
            let begin = self.timing.is_some().then(Instant::now);
            if let Err(error) = self.plant.step(time_s) {
                if self.plant.time_s() > grid.time_s(point - 1) {
                    self.record(self.plant.time_s()).map_err(writing)?; // the last good time
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

    /// Inputs of the step that begins at `time_s`.
    fn feed(&mut self, time_s: f64) -> Result<(), Failure> {
        let Some(table) = &self.inputs else { return Ok(()) };
        for (value_reference, value) in table.at(time_s) {
            self.interface
                .set(&mut self.plant, value_reference, value)
                .map_err(|error| Failure::Refused(format!("input at {time_s} s: {error}")))?;
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
        self.recorder.record(time_s, self.recorded.iter().map(value))
    }
}

/// A bar on standard error for runs that last, none where nobody watches.
struct Progress {
    bar: Option<ProgressBar>,
    steps: u64,
    started: Instant,
}

impl Progress {
    fn new(steps: u64) -> Self {
        Self { bar: None, steps, started: Instant::now() }
    }

    fn at(&mut self, step: u64) {
        if self.bar.is_none() && self.started.elapsed() > PROGRESS_AFTER && io::stderr().is_terminal() {
            let style = ProgressStyle::with_template("{wide_bar} {percent} % of the time, {eta} left")
                .expect("the template is valid");
            let bar = ProgressBar::with_draw_target(Some(self.steps), ProgressDrawTarget::stderr());
            self.bar = Some(bar.with_style(style));
        }
        if let Some(bar) = &self.bar {
            bar.set_position(step);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// What happened, in a few lines.
fn summary(plant: &Plant, grid: &Grid, elapsed: Duration) -> String {
    let machine = plant.machine();
    let mut text = String::new();
    for (joint, body) in plant.outputs().joints.iter().zip(plant.revolute_joints()) {
        let holder = &machine.bodies[*body].joint;
        let name = &holder.name;
        let latch = match &holder.kind {
            JointKind::Revolute(revolute) => revolute.latch.as_ref(),
            JointKind::Clamped | JointKind::Spatial(_) => None,
        };
        let latch = match (latch, joint.latch_count) {
            (None, _) => "has no latch".to_owned(),
            (Some(_), 0) if joint.latched => "latched from the start".to_owned(),
            (Some(latch), 0) if latch.initially_closed => "latch open at the end".to_owned(),
            (Some(_), 0) => "did not latch".to_owned(),
            (Some(_), count) => format!("latched at {:.6} s ({count} in all)", joint.latch_time_s),
        };
        text += &format!("{name}: {latch}, angle {:.3} deg at the end\n", joint.angle_rad.to_degrees());
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
