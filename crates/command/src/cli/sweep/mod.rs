//! `foldwing sweep`: runs many variants of a model on several threads and writes a row for each; an interrupted sweep can be resumed.

mod fan;
mod journal;
mod pictures;
mod plan;
mod variant;

pub(super) use plan::{Plan, axis, file_path};
pub(super) use variant::{Experiment, changed_machine, changed_text, columns, number_in_file};

use crate::cli::choice::chosen;
use crate::cli::grid::{GridArguments, grid_of};
use crate::cli::outlets::{Mark, Outlets};
use crate::cli::progress::Progress;
use crate::cli::simulate::read_inputs;
use crate::cli::{Failure, print, read_model, version};
use clap::builder::NonEmptyStringValueParser;
use fan::FanPage;
use foldwing_fmi::interface::Interface;
use journal::Journal;
use pictures::Pictures;
use serde_json::json;
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::SWEEP, group = clap::ArgGroup::new("variants").required(true))]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Start values of an input or parameter, or values of a key of the model file (`file:solver.tolerance`): FROM:TO:COUNT or A,B,…;
    /// several options form a grid, in which the last one varies fastest
    #[arg(long, value_name = "KEY=VALUES", group = "variants", value_parser = NonEmptyStringValueParser::new())]
    vary: Vec<String>,
    /// CSV file with a column for each key and a row for each variant
    #[arg(long, value_name = "FILE.csv", group = "variants", conflicts_with = "vary")]
    samples: Option<PathBuf>,
    /// CSV file for the results, one row for each variant; `OUT.csv.sweep` next to it keeps finished rows
    #[arg(short = 'o', long = "output", value_name = "OUT.csv")]
    out: PathBuf,
    /// HTML page with all variants: the middle one as with `simulate --view`, the others as lines, and bands of their values in the
    /// plots; rows taken over from an earlier run are simulated again
    #[arg(long, value_name = "OUT.html")]
    view: Option<PathBuf>,
    /// Variables whose final values are written: names or patterns (`fold.*`), separated by commas; may be repeated
    #[arg(long = "variables", value_name = "NAME")]
    outputs: Vec<String>,
    /// Start value of an input or parameter in all variants; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Inputs over time in all variants, as in `simulate`
    #[arg(long, value_name = "IN.csv")]
    inputs: Option<PathBuf>,
    #[command(flatten)]
    grid: GridArguments,
    /// Number of threads [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print the summary as JSON for programs
    #[arg(long)]
    json: bool,
    /// Print no summary
    #[arg(short, long)]
    quiet: bool,
}

/// Runs the variants that have no row yet, then writes all rows in the order of the variants.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let clock = Instant::now();
    for (option, path) in [("--samples", &arguments.samples), ("--inputs", &arguments.inputs)] {
        if path.as_deref() == Some(Path::new("-")) {
            return Err(Failure::Usage(format!(
                "{option} -: standard input cannot be read again when the sweep is \
                                               resumed; name a file"
            )));
        }
    }
    let (machine, text) = read_model(&arguments.model)?;
    let interface = Interface::new(&machine);
    let plan = match &arguments.samples {
        Some(path) => Plan::samples(path, &interface)?,
        None => Plan::grid("--vary", &arguments.vary, &interface)?,
    };
    let outputs: Vec<String> =
        chosen(&arguments.outputs, &interface.variables().iter().collect::<Vec<_>>(), "variable")?
            .iter()
            .map(|variable| variable.name.clone())
            .collect();
    let columns = columns(&plan, &outputs, &machine)?;
    // report an invalid grid on the command line before the first run
    let (start_s, stop_s) = (machine.experiment.start_time_s, machine.experiment.stop_time_s);
    grid_of(&arguments.grid, start_s, stop_s, machine.experiment.step_s)?;
    let inputs = arguments.inputs.as_ref().map(|path| read_inputs(path, interface.variables())).transpose()?;
    let experiment = Experiment {
        file: arguments.model.display().to_string(),
        machine: Arc::new(machine),
        interface: Arc::new(interface),
        text: &text,
        plan: &plan,
        settings: &arguments.settings,
        inputs: inputs.as_ref(),
        grid: &arguments.grid,
        outputs: &outputs,
    };
    experiment.check_values()?;

    let identity = json!({
        "foldwing": version(),
        "model file": digest(text.as_bytes()),
        "keys": plan.keys(),
        "values of the keys": digest(plan.values_text().as_bytes()),
        "number of variants": plan.count(),
        "--variables": outputs,
        "--set": arguments.settings,
        "--inputs": arguments.inputs.as_deref().map(file_digest).transpose()?,
        "--start, --stop, --step": arguments.grid.given(),
    });
    if let Some(folder) = arguments.out.parent() {
        fs::create_dir_all(folder).map_err(|error| Failure::writing(&arguments.out.display().to_string(), &error))?;
    }
    let mut journal = Journal::open(&arguments.out, &identity, plan.count())?;
    let read = [Some(&arguments.model), arguments.samples.as_ref(), arguments.inputs.as_ref()];
    let mut outlets = Outlets::new(false, read.into_iter().flatten().map(PathBuf::as_path));
    let place = outlets.place(&arguments.out, Mark::table(columns.iter().map(String::as_str)))?;
    let view = outlets.place_if(arguments.view.as_deref(), Mark::PAGE)?;
    let mut page = arguments.view.as_ref().map(|_| FanPage::new(&experiment)).transpose()?;
    let taken_over = journal.done();
    march(&experiment, &mut journal, page.as_mut(), arguments.threads.unwrap_or(0).into())?;

    let (bytes, failed) = journal.results(&columns)?;
    place.fill_durably(&bytes)?;
    page.map(|page| page.write(view)).transpose()?;
    let (count, elapsed_s) = (plan.count(), clock.elapsed().as_secs_f64());
    if !arguments.quiet {
        if !arguments.json {
            eprintln!("{count} variants in {elapsed_s:.3} s ({failed} failed, {taken_over} resumed)");
        }
        outlets.report();
    }
    if arguments.json {
        let name = &experiment.machine.name;
        return print(&format!(
            "{:#}",
            json!({
                "name": name,
                "variants": count,
                "failed": failed,
                "resumed": taken_over,
                "elapsed_s": elapsed_s,
                "columns": columns,
                "files": outlets.files(),
            })
        ));
    }
    Ok(())
}

/// Runs the variants that have no row yet. Each free thread takes the next one; rows are recorded as variants finish.
fn march(
    experiment: &Experiment,
    journal: &mut Journal,
    page: Option<&mut FanPage>,
    threads: usize,
) -> Result<(), Failure> {
    let missing = journal.missing();
    // a page needs the runs of all
    let left: Vec<usize> = if page.is_some() { (0..experiment.plan.count()).collect() } else { missing.clone() };
    let drawing = page.as_ref().map(|page| (page.names(), page.shown()));
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| Failure::Files(format!("--threads {threads}: the threads cannot be started: {error}")))?;
    let progress = Progress::of("variants that are left", left.len() as u64);
    let shared = Mutex::new((journal, progress, None, page, 0));
    let next = AtomicUsize::new(0);
    // not a parallel iterator: a thread that waits for the threads of a vortex lattice would start another variant on top of its stack,
    // recursively
    pool.broadcast(|_| {
        while let Some(&index) = left.get(next.fetch_add(1, Ordering::Relaxed)) {
            let mut pictures = drawing.as_ref().map(|(names, shown)| Pictures::new(names, index == *shown));
            let row = experiment.run(index, pictures.as_mut());
            let mut shared = shared.lock().unwrap_or_else(PoisonError::into_inner);
            let (journal, progress, failure, page, done) = &mut *shared;
            if failure.is_none() && missing.contains(&index) {
                *failure = journal.append(index, &row).err();
            }
            if let (Some(page), Some(pictures)) = (page.as_deref_mut(), pictures) {
                let (run, whole) = pictures.parts();
                page.keep(index, run, whole);
            }
            if failure.is_some() {
                return;
            }
            *done += 1;
            progress.at(*done);
        }
    });
    let (_, _, failure, _, _) = shared.into_inner().unwrap_or_else(PoisonError::into_inner);
    failure.map_or(Ok(()), Err)
}

/// SHA-256 of bytes as hexadecimal text.
fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of a file as hexadecimal text.
fn file_digest(path: &Path) -> Result<String, Failure> {
    let bytes =
        fs::read(path).map_err(|error| Failure::Files(format!("{}: cannot be read: {error}", path.display())))?;
    Ok(digest(&bytes))
}
