//! Rates of outputs at communication points where an internal step ends: with aerodynamics at the ends of aerodynamic steps, and wherever
//! inputs change at every communication point.

use super::Bench;
use foldwing::config;
use foldwing::interface::Causality;
use foldwing::machine::{Machine, Method};
use std::path::{Path, PathBuf};

/// Allowed difference between a rate and the time derivative of the output, relative to the largest rate of the variable. An output
/// extrapolated over a communication step has an error of this fraction of its largest change in the step; rates and differences agree to
/// 1e-4 or better within an internal step, so 1e-2 leaves room for modes above 100 kHz, which differences smooth.
const ALLOWED: f64 = 1e-2;
/// One-sided difference over five points for the derivative at the last of them: weights, to be divided by 12 spacings.
const LEFT: [f64; 5] = [3.0, -16.0, 36.0, -48.0, 25.0];

/// Real outputs of a machine, with the instants at which difference quotient and rate were compared.
struct Compared {
    rows: Vec<(String, u32)>,
    /// Difference quotient, rate and the round-off allowed between them, per instant and variable.
    places: Vec<Vec<[f64; 3]>>,
}

impl Compared {
    fn new(bench: &Bench) -> Self {
        let rows = bench.reals(Causality::Output);
        Self { rows: rows.iter().map(|row| (row.name.clone(), row.value_reference)).collect(), places: Vec::new() }
    }

    fn references(&self) -> Vec<u32> {
        self.rows.iter().map(|row| row.1).collect()
    }

    /// Compares at `time_s`; the last four steps of the bench up to it have length `side_s`. False if an internal step ends in between,
    /// where outputs have kinks.
    fn compare(&mut self, bench: &mut Bench, time_s: f64, side_s: f64) -> bool {
        let references = self.references();
        bench.step(time_s - 4.0 * side_s);
        let steps = bench.plant.statistics().steps;
        let mut values = vec![bench.values(&references)];
        for left in [3.0, 2.0, 1.0, 0.0] {
            bench.step(time_s - left * side_s);
            values.push(bench.values(&references));
        }
        if bench.plant.statistics().steps != steps {
            return false;
        }
        let given = self.rates(bench);
        let slope = |row: usize| {
            let sum: f64 = values.iter().zip(LEFT).map(|(values, weight)| weight * values[row]).sum();
            sum / (12.0 * side_s)
        };
        // of sums as large as the largest variable of the kind: loads that cancel, moment arms
        let size = |row: usize| {
            let alike =
                self.rows.iter().zip(&values[4]).filter(|((other, _), _)| kind(other) == kind(&self.rows[row].0));
            alike.map(|(_, value)| value.abs()).fold(0.0, f64::max)
        };
        let places = (0..references.len()).map(|row| [slope(row), given[row], 1e-13 * size(row) / side_s]).collect();
        self.places.push(places);
        true
    }

    fn rates(&self, bench: &mut Bench) -> Vec<f64> {
        let references = self.references();
        let mut given = vec![f64::NAN; references.len()];
        let orders = vec![1; references.len()];
        bench.table.output_rates(&mut bench.plant, &references, &orders, &mut given).expect("outputs");
        given
    }

    /// The variables beyond the tolerance: name, error relative to the largest rate, difference quotient and rate there. Variables that
    /// cancel to round-off, such as weight and inertia in free flight, are scaled by those of their kind.
    fn misses(&self) -> Vec<(String, f64, f64, f64)> {
        let peaks: Vec<f64> = (0..self.rows.len())
            .map(|row| self.places.iter().map(|place| place[row][0].abs()).fold(0.0, f64::max))
            .collect();
        let mut misses = Vec::new();
        for (row, (name, _)) in self.rows.iter().enumerate() {
            let alike = self.rows.iter().zip(&peaks).filter(|((other, _), _)| kind(other) == kind(name));
            let floor = 1e-9 * alike.map(|(_, peak)| *peak).fold(0.0, f64::max);
            let error = |place: &Vec<[f64; 3]>| {
                let [slope, rate, noise] = place[row];
                ((rate - slope).abs() - noise - floor).max(0.0) / peaks[row].max(f64::MIN_POSITIVE)
            };
            let Some(worst) = self.places.iter().max_by(|a, b| error(a).total_cmp(&error(b))) else { continue };
            if error(worst) > ALLOWED || error(worst).is_nan() {
                misses.push((name.clone(), error(worst), worst[row][0], worst[row][1]));
            }
        }
        misses
    }

    fn conclude(&self, case: &str, name: &str) {
        let misses = self.misses();
        println!("{case}: {name}: {} rows at {} places, {} miss", self.rows.len(), self.places.len(), misses.len());
        assert!(misses.is_empty(), "{name}: {} rows of {} miss: {misses:?}", misses.len(), self.rows.len());
    }
}

/// Kind of a variable, for a common scale: components of a vector; forces and moments, since arms are about a metre; positions and
/// distances.
fn kind(name: &str) -> &str {
    match name.rsplit('.').nth(1) {
        Some("force" | "moment") => "load",
        Some("position" | "deflection") => "place",
        Some("reaction_force" | "reaction_moment") => "reaction",
        Some(vector) => vector,
        None => name,
    }
}

/// Every model file below a folder.
fn model_files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut files: Vec<PathBuf> = entries
        .flat_map(|path| match path.extension() {
            _ if path.is_dir() => model_files(&path),
            Some(extension) if extension == "toml" => vec![path],
            _ => Vec::new(),
        })
        .collect();
    files.sort();
    files
}

/// E-14. For every shipped model with aerodynamics: rates of all outputs equal the difference quotients of the values read up to the
/// present, at the ends of aerodynamic steps, where every usual communication point lies, and inside these steps. Aerodynamic loads are
/// constant within a step (Q1); their jump at its start is not part of the rate.
#[test]
#[ignore = "long; `make long` runs it"]
fn e14_rates_in_air_are_slopes_of_what_is_read() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut models = 0;
    for path in model_files(&examples) {
        let (machine, _) = config::read(&path).unwrap_or_else(|error| panic!("{error}"));
        let Some(step_s) = machine.air.as_ref().map(|air| air.step_s) else { continue };
        models += 1;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut bench = Bench::of(machine);
        let mut compared = Compared::new(&bench);
        let side_s = 2e-4 * step_s;
        let [mut ends, mut inside] = [0, 0];
        for step in 1..=8 {
            let begin_s = step_s * f64::from(step - 1);
            inside += u32::from(compared.compare(&mut bench, begin_s + 0.613 * step_s, side_s));
            ends += u32::from(compared.compare(&mut bench, step_s * f64::from(step), side_s));
        }
        compared.conclude("E-14", &name);
        assert!(ends >= 6 && inside >= 6, "{name}: {ends} ends and {inside} places inside without a kink");
    }
    assert!(models >= 15, "{models} models in air");
}

/// E-15. If an input changes at every communication point, each communication step ends with an internal step: rates at such points equal
/// the difference quotients of a run that continues in small steps from there. For every method that takes its steps from stages, without
/// aerodynamics and with strips.
#[test]
fn e15_rates_hold_where_inputs_change_at_every_point() {
    // SDIRK2 takes steps of about 0.1 µs here
    let methods = [
        (Method::TrBdf2, 1e-7, 1e-9),
        (Method::Sdirk2, 1e-8, 1e-9),
        (Method::Esdirk3, 1e-7, 1e-9),
        (Method::Esdirk4, 1e-7, 1e-11),
    ]
    .map(|(method, side_s, tolerance)| ("folding_wing", method, side_s, tolerance));
    // only the error estimate resolves the vibrations excited by a jump of an input: 21, 15, 2 and 0 variables are beyond the tolerance at
    // 1e-10 to 1e-13
    let air = ("goland_wing", Method::Esdirk4, 1e-7, 1e-13);
    for (name, method, side_s, tolerance) in methods.into_iter().chain([air]) {
        let machine = || -> Machine {
            let path = format!("{}/examples/models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
            let (mut machine, _) = config::read(path).unwrap_or_else(|error| panic!("{error}"));
            machine.solver.method = method;
            // both runs then give the same motion, also in axial modes near 2e5 rad/s between the ends of steps
            machine.solver.tolerance = tolerance;
            machine
        };
        let [mut once, mut slowly] = [Bench::of(machine()), Bench::of(machine())];
        let mut compared = Compared::new(&once);
        let step_s = 1e-3;
        for step in 1..=6 {
            let time_s = step_s * f64::from(step);
            for bench in [&mut once, &mut slowly] {
                bench.set("gravity.z", -9.8 - f64::from(step));
            }
            once.step(time_s);
            slowly.step(time_s - 1000.0 * side_s);
            if !compared.compare(&mut slowly, time_s, side_s) {
                continue;
            }
            let given = compared.rates(&mut once);
            let place = compared.places.last_mut().expect("the place just compared");
            place.iter_mut().zip(given).for_each(|(place, given)| place[1] = given);
        }
        compared.conclude("E-15", &format!("{name}, {method:?}"));
        assert!(compared.places.len() >= 4, "{name}: {} places without a kink", compared.places.len());
    }
}
