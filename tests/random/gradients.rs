//! gradients of random machines' runs, forward and adjoint.
//!
//! Parts whose derivatives are not covered are removed, as named by the errors; the remaining machine has any combination of the joints,
//! bodies, loads and events that gradients cover.

use crate::machines::{Model, Value, View};
use crate::{STEPS, Verdict, machine, start, step_s};
use foldwing::plant::{Gradient, GradientError, Parameter, Plant, RunResult, Tape};

/// Maximum number of parts that are removed.
const TRIES: usize = 40;
/// Number of parameters per machine.
const PARAMETERS: usize = 4;
/// Number of outputs that are results.
const RESULTS: usize = 6;
/// One in this many machines has a mean among its results: an adjoint pass for a mean takes finite differences of the output with respect
/// to all coordinates at every stage.
const PER_MEAN: usize = 4;
/// Allowed difference between forward and adjoint derivatives, relative to the largest entry of a row: derivatives of outputs are
/// differences over millimetres, with errors of 1e-8 for stiff sections; the largest of the first 60 seeds is 1.5e-6 (seed 20), the next is
/// below 1e-7.
const SAME: f64 = 2e-6;
/// Derivatives below this fraction of the result are round-off: those of outputs that a parameter does not affect.
const ROUND_OFF: f64 = 1e-11;

/// Tables that exist only in machines with aerodynamics.
const OF_AIR: [&str; 4] = ["aerodynamics", "wind", "gust", "polar"];

/// Checks that forward and adjoint derivatives agree.
pub fn both_ways(model: &Model) -> Verdict {
    let Some((model, mut plant, tape)) = covered(model) else { return Verdict::Silent };
    let mut random = fastrand::Rng::with_seed(model.seed);
    let mut numbers = numbers(&model);
    random.shuffle(&mut numbers);
    let mut parameters = Vec::new();
    for &(table, key, value) in &numbers {
        if parameters.len() == PARAMETERS {
            break;
        }
        // some parameters change the mesh, or have no valid values nearby
        let Ok(one) = parameter(&model, (table, key), value) else { continue };
        if Gradient::new(&mut plant, &tape, vec![one]).is_ok() {
            parameters.extend(parameter(&model, (table, key), value).map(|parameter| (parameter, value)));
        }
    }
    if parameters.is_empty() {
        return Verdict::Silent;
    }
    let (parameters, values): (Vec<Parameter>, Vec<f64>) = parameters.into_iter().unzip();
    let outputs = plant.outputs().values().len();
    let mut gradient = match Gradient::new(&mut plant, &tape, parameters) {
        Ok(gradient) => gradient,
        Err(error) => return Verdict::Broken(format!("parameters without a gradient together: {error}")),
    };
    let mut tried = 0;
    for number in 0..RESULTS {
        let (index, time) = (random.usize(0..outputs), random.usize(0..2));
        let result = match number == 0 && random.usize(0..PER_MEAN) == 0 {
            true => RunResult::Mean { index, time, square: random.bool() },
            false => RunResult::Output { index, time },
        };
        let row = match gradient.forward(&[result]) {
            Ok(mut table) => table.remove(0),
            Err(GradientError::NotCovered { .. } | GradientError::OtherChoice { .. }) => continue,
            // blades without twist in still air are at the row of 0°
            Err(GradientError::Corner { .. }) => return Verdict::Silent,
            Err(error) => return Verdict::Broken(format!("{result:?} forward: {error}")),
        };
        let (other, value) = match (gradient.adjoint(result), gradient.values(&[result])) {
            (Ok(other), Ok(value)) => (other, value[0]),
            (Err(error), _) | (_, Err(error)) => return Verdict::Broken(format!("{result:?} adjoint: {error}")),
        };
        tried += 1;
        // scaled by the value of each parameter
        let by_size = |row: &[f64]| row.iter().zip(&values).map(|(slope, value)| slope * value).collect::<Vec<f64>>();
        let (row, other) = (by_size(&row), by_size(&other));
        let largest = row.iter().chain(&other).fold(0.0f64, |largest, slope| largest.max(slope.abs()));
        let allowed = SAME * largest + ROUND_OFF * value.abs().max(1.0);
        if row.iter().zip(&other).any(|(a, b)| (a - b).abs() > allowed || !a.is_finite()) {
            return Verdict::Broken(format!("{result:?}: forward {row:?}, adjoint {other:?} of {value}"));
        }
    }
    if tried == 0 { Verdict::Silent } else { Verdict::Holds }
}

/// The machine without parts that are not covered, and a third of its run; `None` if it does not run.
fn covered(model: &Model) -> Option<(Model, Plant, Tape)> {
    let mut model = model.clone();
    model.actions.clear();
    for _ in 0..TRIES {
        let mut plant = start(machine(&model, &View::plain()).ok()?).ok()?;
        let (start_s, step_s) = (plant.machine().experiment.start_time_s, step_s(&plant));
        let times_s = [1, 2].map(|part| start_s + step_s * (part * STEPS / 6) as f64);
        match plant.run_on_tape(&times_s) {
            Ok(tape) => return Some((model, plant, tape)),
            Err(GradientError::NotCovered { part, place }) => model = without(&model, part, &place)?,
            // an event without a derivative, or a run that ends with an error
            Err(_) => return None,
        }
    }
    None
}

/// The machine without the part that an error names.
pub fn without(model: &Model, part: &str, place: &str) -> Option<Model> {
    let remove = |name: &str| {
        let index =
            model.tables.iter().position(|table| table.name == name || table.name.starts_with(&format!("{name}.")));
        index.map(|index| model.without(index))
    };
    let of_joint = |table: &str| remove(&format!("joint.{place}.{table}"));
    match part {
        "the vortex lattice" => Some(still(model)),
        "rotors whose tower disturbs the wind" => remove("tower"),
        part if part.starts_with("gusts") => remove("gust"),
        "mass-proportional damping of bodies with shear on free joints" => Some(unsheared(model, place)),
        part if part.starts_with("failures") => remove(&format!("failure.{place}")),
        part if part.starts_with("runs in which a generator passes") => of_joint("generator"),
        "the methods generalized_alpha and rk4" => remove("solver"),
        part if part.starts_with("real-time mode") => remove("solver"),
        _ => None,
    }
}

/// The machine without the shear of a body; copies of a body have its name and a number.
fn unsheared(model: &Model, body: &str) -> Model {
    let mut model = model.clone();
    let own = |name: &str| name.strip_prefix("body.").is_some_and(|name| body.starts_with(name));
    for table in model.tables.iter_mut().filter(|table| own(&table.name)) {
        table.keys.retain(|(key, _)| !matches!(*key, "shear" | "shear_damping_factors"));
    }
    model
}

/// The machine without aerodynamics.
fn still(model: &Model) -> Model {
    let mut model = model.clone();
    let of_air = |name: &str| OF_AIR.iter().any(|table| name == *table || name.starts_with(&format!("{table}.")));
    while let Some(index) = model.tables.iter().position(|table| of_air(&table.name)) {
        model = model.without(index);
    }
    model
}

/// Numbers in the model that are not zero: table, key, value.
pub fn numbers(model: &Model) -> Vec<(usize, usize, f64)> {
    let mut found = Vec::new();
    for (t, table) in model.tables.iter().enumerate() {
        let of_machine =
            ["body.", "joint.", "mass.", "section.", "rigid_body.", "closure.", "failure.", "surface.", "aerodynamics"];
        if !of_machine.iter().any(|kind| table.name.starts_with(kind)) {
            continue;
        }
        for (k, (_, value)) in table.keys.iter().enumerate() {
            if let Value::Plain(text) = value
                && text.contains('.')
                && let Ok(value) = text.parse::<f64>()
                && value != 0.0
            {
                found.push((t, k, value));
            }
        }
    }
    found
}

pub fn parameter(model: &Model, (table, key): (usize, usize), value: f64) -> Result<Parameter, String> {
    let name = format!("{}.{}", model.tables[table].name, model.tables[table].keys[key].0);
    Parameter::new(name, value, 1e-3 * value.abs(), |value| {
        let mut other = model.clone();
        other.tables[table].keys[key].1 = Value::from(value);
        machine(&other, &View::plain()).map(|machine| Plant::new(std::sync::Arc::new(machine)))
    })
}
