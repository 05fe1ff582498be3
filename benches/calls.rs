//! Cost of the work around the solver, through the exported C functions: setting and getting values, overhead of a step, instantiation. For
//! the duration of single steps in real-time mode see `foldwing latency`.
//!
//! `cargo bench -p foldwing-benches --bench calls` (or `make bench`) prints the tables of `docs/BENCHMARKS.md`. The times are processor
//! times of one thread, the smallest and the median of repeated runs.

#[path = "../tests/robustness/fmu.rs"]
mod fmu;
#[path = "../tests/robustness/fmu3.rs"]
mod fmu3;
#[path = "../crates/study/src/latency/processor_time.rs"]
mod processor_time;

use fmu::{Attempt, Fmu, Resources};
use fmu3::{Agreed, Fmu3};
use foldwing::interface::{Causality, Value};
use foldwing::plant::Plant;
use foldwing_fmu::fmi3::values::fmi3SetFloat64;
use foldwing_fmu::functions::*;
use foldwing_fmu::types::fmi2OK;
use processor_time::processor_time;
use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Number of values set and read per step.
const VALUES: usize = 200;
const STEPS: u32 = 800;
const STEP_S: f64 = 5e-4;
const RUNS: usize = 40;

/// Processor time of this thread if the system provides it, otherwise wall-clock time.
struct Stopwatch {
    clock: Instant,
    processor: Option<Duration>,
}

impl Stopwatch {
    fn start() -> Self {
        Self { clock: Instant::now(), processor: processor_time() }
    }

    /// Time in µs.
    fn us(&self) -> f64 {
        let processor = self.processor.zip(processor_time()).map(|(begin, end)| end - begin);
        1e6 * processor.unwrap_or_else(|| self.clock.elapsed()).as_secs_f64()
    }
}

/// The smallest and the median time.
fn least_and_median(mut times: Vec<f64>) -> (f64, f64) {
    times.sort_by(f64::total_cmp);
    (times[0], times[times.len() / 2])
}

/// The shipped model with enough load stations for 200 real inputs of the FMU.
fn many_stations() -> String {
    let text = fmu::WING.replace("elements = 4", "elements = 4\nload_stations = 16");
    assert_eq!(text.matches("load_stations = 16").count(), 2, "the model file has changed");
    text
}

/// References and start values of the first 200 real variables of a causality.
fn reals(fmu: &Fmu, causality: Causality) -> (Vec<u32>, Vec<f64>) {
    let rows = fmu.table.variables().iter().filter(|row| row.causality == causality);
    let (references, values): (Vec<u32>, Vec<f64>) = rows
        .filter_map(|row| match row.value {
            Value::Real(value) => Some((row.value_reference, value)),
            _ => None,
        })
        .take(VALUES)
        .unzip();
    assert_eq!(references.len(), VALUES, "{causality:?}: too few reals");
    (references, values)
}

/// An instance of a model, ready to step.
fn ready(text: &str) -> Fmu {
    let fmu = Fmu::new(text);
    fmu.setup(0.0, None);
    unsafe {
        fmu.ok(fmi2EnterInitializationMode(fmu.component));
        fmu.ok(fmi2ExitInitializationMode(fmu.component));
    }
    fmu
}

/// Times in µs of the deployment through the C functions, with values set before each step and read after it; fold angle at the end.
fn through_c(text: &str, exchange: bool) -> (f64, f64) {
    let fmu = ready(text);
    let (inputs, commands) = reals(&fmu, Causality::Input);
    let (outputs, mut values) = reals(&fmu, Causality::Output);
    let watch = Stopwatch::start();
    let mut time_s = 0.0;
    for _ in 0..STEPS {
        unsafe {
            if exchange {
                assert_eq!(fmi2SetReal(fmu.component, inputs.as_ptr(), VALUES, commands.as_ptr()), fmi2OK);
            }
            assert_eq!(fmi2DoStep(fmu.component, time_s, STEP_S, 1), fmi2OK);
            if exchange {
                assert_eq!(fmi2GetReal(fmu.component, outputs.as_ptr(), VALUES, values.as_mut_ptr()), fmi2OK);
            }
        }
        time_s += STEP_S;
    }
    let us = watch.us();
    (us, fmu.get("fold.angle"))
}

/// Times in µs of the same steps without the C functions.
fn plant_alone(text: &str) -> (f64, f64) {
    let mut plant = Plant::new(Arc::new(foldwing::config::parse(text, "model.toml").expect("a valid model")));
    plant.initialize(0.0).expect("it starts");
    let watch = Stopwatch::start();
    let mut time_s = 0.0;
    for _ in 0..STEPS {
        time_s += STEP_S;
        plant.step(time_s).expect("it steps");
    }
    let us = watch.us();
    (us, plant.outputs().joints()[0].angle_rad)
}

/// Overhead of a step in addition to the solver, measured alternately with the solver alone.
fn steps() {
    let text = many_stations();
    let (mut with, mut without, mut alone) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..RUNS {
        let (full, bare, own) = (through_c(&text, true), through_c(&text, false), plant_alone(&text));
        assert_eq!([full.1, bare.1], [own.1; 2], "the same digits");
        with.push(full.0 / f64::from(STEPS));
        without.push(bare.0 / f64::from(STEPS));
        alone.push(own.0 / f64::from(STEPS));
    }
    let [with, without, alone] = [with, without, alone].map(least_and_median);
    println!("| one step of {} ms of the deployment, 16 stations per body | least, µs | median, µs |", 1e3 * STEP_S);
    println!("|---|---|---|");
    println!("| `Plant::step`, no C function | {:.2} | {:.2} |", alone.0, alone.1);
    println!("| `fmi2DoStep` | {:.2} | {:.2} |", without.0, without.1);
    println!("| with {VALUES} reals set and {VALUES} got | {:.2} | {:.2} |", with.0, with.1);
    println!("| **beyond the solver's own time** | **{:.2}** | {:.2} |", with.0 - alone.0, with.1 - alone.1);

    let fmu = ready(&text);
    let (inputs, commands) = reals(&fmu, Causality::Input);
    let (outputs, mut values) = reals(&fmu, Causality::Output);
    let calls = 2000;
    let (mut setting, mut getting) = (Vec::new(), Vec::new());
    for _ in 0..RUNS {
        let watch = Stopwatch::start();
        for _ in 0..calls {
            black_box(unsafe { fmi2SetReal(fmu.component, inputs.as_ptr(), VALUES, commands.as_ptr()) });
        }
        setting.push(watch.us() / f64::from(calls));
    }
    fmu.step(0.0, STEP_S); // without it a get would evaluate the outputs again
    for _ in 0..RUNS {
        let watch = Stopwatch::start();
        for _ in 0..calls {
            black_box(unsafe { fmi2GetReal(fmu.component, outputs.as_ptr(), VALUES, values.as_mut_ptr()) });
        }
        getting.push(watch.us() / f64::from(calls));
    }
    for (name, times) in [("`fmi2SetReal`", setting), ("`fmi2GetReal`", getting)] {
        let (least, median) = least_and_median(times);
        println!("| {name} alone, {VALUES} reals | {least:.2} | {median:.2} |");
    }
}

/// Time from the call of `fmi2Instantiate` to the end of initialisation.
fn instantiations() {
    println!(
        "\n| `fmi2Instantiate` to `fmi2ExitInitializationMode` | instantiate, ms | initialise, ms | both, median, ms |"
    );
    println!("|---|---|---|---|");
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    let mut models: Vec<_> = std::fs::read_dir(folder).expect("a folder").flatten().map(|entry| entry.path()).collect();
    models.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    models.sort();
    for path in models {
        let text = std::fs::read_to_string(&path).expect("readable");
        let resources = Resources::with(&text);
        let attempt = Attempt::of(&text, &resources);
        let (mut instantiating, mut initializing, mut both) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..RUNS / 2 {
            let watch = Stopwatch::start();
            let (component, messages) = attempt.run();
            let begun = watch.us();
            assert!(!component.is_null(), "refused: {messages:?}");
            // frees the instance at the end of the round
            let fmu = Fmu { component, messages, table: fmu::table(&text) };
            let watch = Stopwatch::start();
            fmu.setup(0.0, None);
            unsafe {
                fmu.ok(fmi2EnterInitializationMode(component));
                fmu.ok(fmi2ExitInitializationMode(component));
            }
            let done = watch.us();
            instantiating.push(1e-3 * begun);
            initializing.push(1e-3 * done);
            both.push(1e-3 * (begun + done));
        }
        let name = path.file_name().expect("a file").to_string_lossy();
        let [(first, _), (second, _), (_, median)] = [instantiating, initializing, both].map(least_and_median);
        println!("| `{name}` | {first:.2} | {second:.2} | {median:.2} |");
    }
}

/// Loads of all stations: 192 numbers in one call, as scalars in FMI 2.0 or as four arrays in FMI 3.0.
struct Loads {
    second: Fmu,
    third: Fmu3,
    rows: Vec<u32>,
    arrays: Vec<u32>,
    values: Vec<f64>,
}

impl Loads {
    fn new() -> Self {
        let text = many_stations();
        let (second, third) = (ready(&text), Fmu3::new(&text, Agreed::default()));
        third.start();
        let is_load = |array: &&foldwing::interface::Array| array.name.starts_with("load.");
        let rows: Vec<u32> =
            third.table.arrays().iter().filter(is_load).flat_map(|array| array.rows.iter().copied()).collect();
        let arrays = third.table.arrays().iter().filter(is_load).map(|array| third.reference(&array.name)).collect();
        let values = (0..rows.len()).map(|i| 1e-3 * i as f64).collect();
        Self { second, third, rows, arrays, values }
    }

    fn set(&self, version: u32) {
        let Self { second, third, rows, arrays, values } = self;
        black_box(unsafe {
            match version {
                2 => fmi2SetReal(second.component, rows.as_ptr(), rows.len(), values.as_ptr()),
                _ => fmi3SetFloat64(third.instance, arrays.as_ptr(), arrays.len(), values.as_ptr(), values.len()),
            }
        });
    }
}

/// The cost of setting all loads in either version.
fn loads() {
    let loads = Loads::new();
    let calls = 2000;
    println!("\n| {} loads set in one call | least, µs | median, µs |\n|---|---|---|", loads.values.len());
    for (version, name) in [(2, "`fmi2SetReal`"), (3, "`fmi3SetFloat64`, four arrays")] {
        let times = (0..RUNS).map(|_| {
            let watch = Stopwatch::start();
            (0..calls).for_each(|_| loads.set(version));
            watch.us() / f64::from(calls)
        });
        let (least, median) = least_and_median(times.collect());
        println!("| {name} | {least:.3} | {median:.3} |");
    }
}

/// Runs only the calls of one version if the command line asks for it, to count instructions, for example with `perf stat -e instructions:u
/// target/release/deps/calls-… loads3 100000`.
fn counted() -> bool {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let version = match words.first().map(String::as_str) {
        Some("loads2") => 2,
        Some("loads3") => 3,
        _ => return false,
    };
    let calls: u32 = words.get(1).and_then(|word| word.parse().ok()).expect("a number of calls");
    let loads = Loads::new();
    (0..calls).for_each(|_| loads.set(version));
    true
}

fn main() {
    if counted() {
        return;
    }
    steps();
    loads();
    instantiations();
}
