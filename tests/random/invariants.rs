//! Invariants, each a function of a machine.

use crate::machines::{Doing, Model, View};
use crate::outputs::worst;
use crate::{STEPS, Verdict, advance, machine, run, start, step_s};
use foldwing::config;
use foldwing::machine::Parent;
use foldwing::plant::{Outputs, Plant, Snapshot};
use nalgebra::Vector3;
use std::sync::Arc;

/// A run of the machine as drawn, or none if it is refused.
fn plain(model: &Model) -> Option<Vec<Outputs>> {
    machine(model, &View::plain()).and_then(start).and_then(|plant| run(plant, model, &View::plain(), 1)).ok()
}

/// A machine in another view against the machine as drawn. Both take the same steps but for round-off, which Newton's iteration and
/// the motion carry on; where they do not, an event or the choice of a step has come between, and tighter tolerances must bring the two
/// together.
pub fn seen_otherwise(model: &Model, view: &View) -> Verdict {
    // copies in a mirror are numbered the other way round: the second of three is the third
    if view.mirror && model.copies().is_some_and(|count| count > 2) {
        return Verdict::Silent;
    }
    let Some(here) = plain(model) else { return Verdict::Silent };
    let other = match machine(model, view) {
        Ok(other) => other,
        Err(error) => return Verdict::Broken(format!("is refused in another view: {error}")),
    };
    let parsed = machine(model, &View::plain()).expect("it ran");
    match start(other).and_then(|plant| run(plant, model, view, 1)) {
        Ok(there) => {
            let (off, what) = worst(&parsed, &here, &there, view);
            if off < 1e-9 { Verdict::Holds } else { Verdict::Broken(format!("{off:.1e}, {what}")) }
        }
        Err(error) => Verdict::Broken(format!("stops in another view: {error}")),
    }
}

/// Drift of the account over the largest energy that is exchanged.
fn drift(outputs: &[Outputs]) -> f64 {
    let account = |outputs: &Outputs| {
        let energy = outputs.energy();
        energy.total - energy.work + energy.dissipated
    };
    let cover = |of: fn(&Outputs) -> f64| {
        let values = outputs.iter().map(of);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    let exchanged = cover(|outputs| outputs.energy().kinetic)
        .max(cover(|outputs| outputs.energy().work))
        .max(cover(|outputs| outputs.energy().dissipated))
        .max(cover(|outputs| outputs.energy().elastic));
    let begin = account(&outputs[0]);
    outputs.iter().map(|outputs| (account(outputs) - begin).abs()).fold(0.0, f64::max) / exchanged.max(1e-9)
}

/// The account is closed to ten tolerances, or to what the tolerance leaves: then a tighter one closes it further. A power that is booked
/// wrongly stays.
pub fn energy(model: &Model) -> Verdict {
    let at = |tolerance: f64| {
        let mut machine = machine(model, &View::plain())?;
        machine.solver.tolerance = tolerance;
        run(start(machine)?, model, &View::plain(), 1).map(|outputs| drift(&outputs))
    };
    let Ok(machine) = machine(model, &View::plain()) else { return Verdict::Silent };
    let tolerance = machine.solver.tolerance;
    let Ok(coarse) = at(tolerance) else { return Verdict::Silent };
    if coarse < 10.0 * tolerance {
        return Verdict::Holds;
    }
    let Ok(fine) = at(1e-3 * tolerance.max(1e-9)) else { return Verdict::Silent };
    // second-order methods gain a factor of ten from a thousandth of the tolerance, and half of that is taken for booked wrongly
    if fine < 0.2 * coarse || fine < 1e-7 {
        Verdict::Holds
    } else {
        Verdict::Broken(format!("the account drifts by {coarse:.1e} at a tolerance of {tolerance:.0e}, by {fine:.1e} at a thousandth"))
    }
}

/// Going back from later, going on elsewhere, and beginning again.
pub fn states(model: &Model) -> Verdict {
    let view = View::plain();
    let Some(outputs) = plain(model) else { return Verdict::Silent };
    let parsed = Arc::new(machine(model, &view).expect("it ran"));
    let fresh = || {
        let mut plant = Plant::new(parsed.clone());
        plant.initialize(0.0).expect("it ran");
        plant
    };
    let same = |plant: &Plant, at: usize, what: &str| {
        // switches and all: the very bits
        let (found, expected) = (plant.outputs(), &outputs[at]);
        let bits = |outputs: &Outputs| outputs.values().iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        (bits(found) != bits(expected)).then(|| format!("{what}, at {} s", expected.time_s))
    };
    let goes_on = |plant: &mut Plant, from: usize, to: usize, what: &str| -> Option<String> {
        for step in from..to {
            if let Err(error) = advance(plant, model, &view, step, 1) {
                return Some(format!("{what}: {error}"));
            }
            if let Some(broken) = same(plant, step + 1, what) {
                return Some(broken);
            }
        }
        None
    };
    let mut plant = fresh();
    // everywhere between the events that a machine has, and with the integrator ahead in the midst of its step
    let [first, second] = [STEPS / 3, 2 * STEPS / 3];
    let mut saved = Vec::new();
    for step in 0..STEPS {
        if step == first || step == second {
            saved.push((step, plant.snapshot()));
        }
        if let Err(error) = advance(&mut plant, model, &view, step, 1) {
            return Verdict::Broken(format!("a second run stops: {error}"));
        }
        if let Some(broken) = same(&plant, step + 1, "a second run differs") {
            return Verdict::Broken(broken);
        }
    }
    for (step, snapshot) in &saved {
        if let Err(error) = plant.restore(snapshot) {
            return Verdict::Broken(format!("its own snapshot is refused: {error}"));
        }
        if let Some(broken) = same(&plant, *step, "restored outputs differ") {
            return Verdict::Broken(broken);
        }
        if let Some(broken) = goes_on(&mut plant, *step, STEPS, "steps from a restored state differ") {
            return Verdict::Broken(broken);
        }
        let bytes = postcard::to_stdvec(snapshot).expect("serialises");
        let copy: Snapshot = postcard::from_bytes(&bytes).expect("deserialises");
        let mut elsewhere = Plant::new(parsed.clone());
        if let Err(error) = elsewhere.restore(&copy) {
            return Verdict::Broken(format!("another instance refuses the snapshot: {error}"));
        }
        if let Some(broken) = goes_on(&mut elsewhere, *step, STEPS, "another instance goes another way") {
            return Verdict::Broken(broken);
        }
    }
    let inputs = fresh().inputs().clone();
    plant.inputs_mut().clone_from(&inputs);
    if let Err(error) = plant.initialize(0.0) {
        return Verdict::Broken(format!("does not begin again: {error}"));
    }
    match same(&plant, 0, "the second start differs")
        .or_else(|| goes_on(&mut plant, 0, STEPS, "a run from the second start differs"))
    {
        Some(broken) => Verdict::Broken(broken),
        None => Verdict::Holds,
    }
}

/// The integrator runs ahead of whoever steps it. Inputs end its step, so both runs have them at the same times.
pub fn communication(model: &Model) -> Verdict {
    let Some(here) = plain(model) else { return Verdict::Silent };
    let parsed = machine(model, &View::plain()).expect("it ran");
    let there = start(parsed.clone()).and_then(|plant| run(plant, model, &View::plain(), 3));
    match there {
        Ok(there) => {
            let (off, what) = worst(&parsed, &here, &there, &View::plain());
            if off < 1e-12 { Verdict::Holds } else { Verdict::Broken(format!("{off:.1e}, {what}")) }
        }
        Err(error) => Verdict::Broken(format!("stops with a third of the communication step: {error}")),
    }
}

/// Read twice, and read from the same tables as JSON, as the package for Python hands them over.
pub fn files(model: &Model) -> Verdict {
    let text = model.text(&View::plain());
    let Ok(machine) = config::parse(&text, "machine.toml") else { return Verdict::Silent };
    let tables: toml::Table = text.parse().expect("it was parsed");
    let json = serde_json::to_string(&tables).expect("tables of numbers and texts");
    let again = config::text_of_json(&json)
        .and_then(|text| config::parse(&text, "machine.toml").map_err(|error| error.to_string()));
    match again {
        Ok(again) if again == machine => Verdict::Holds,
        Ok(_) => Verdict::Broken("another machine from the same tables as JSON".to_owned()),
        Err(error) => Verdict::Broken(format!("refused as JSON: {error}")),
    }
}

/// Velocity of the other frame in m/s: along the ground of a lattice, so that the ground stays.
const FRAME_M_S: Vector3<f64> = Vector3::new(4.0, -2.5, 0.0);

/// A machine that flies, in air or without, against the same one seen from a frame that moves uniformly.
pub fn galilei(model: &Model) -> Verdict {
    let Ok(parsed) = machine(model, &View::plain()) else { return Verdict::Silent };
    // what stands still in the root frame would move
    let on_root = parsed.bodies.iter().filter(|body| matches!(body.joint.parent, Parent::Root { .. })).count();
    let turns = model.actions.iter().any(|action| matches!(action.doing, Doing::RootSpin(..)));
    if !model.names("free") || on_root > 1 || turns || model.has("gust") || model.says("mirror_normal") {
        return Verdict::Silent;
    }
    let Some(here) = plain(model) else { return Verdict::Silent };
    let mut moving = parsed.clone();
    for body in &mut moving.bodies {
        if let foldwing::machine::JointKind::Spatial(spatial) = &mut body.joint.kind
            && spatial.freedom == foldwing::machine::SpatialFreedom::Free
        {
            spatial.start_velocity_m_s -= FRAME_M_S;
        }
    }
    if let Some(air) = &mut moving.air {
        air.wind_m_s -= FRAME_M_S;
    }
    let there = match start(moving).and_then(|plant| run(plant, model, &View::plain(), 1)) {
        Ok(there) => there,
        Err(error) => return Verdict::Broken(format!("stops in a frame that moves along: {error}")),
    };
    // the tolerances are shares of the wing's length; Newton's iteration leaves a hundredth of them
    let bound = if model.says("free_wake") { 1e-4 } else { 1e-6 };
    let mut worst = (0.0, String::new());
    let mut see = |off: f64, size: f64, what: String| {
        let share = off / size.max(1e-9);
        if share > worst.0 {
            worst = (share, what);
        }
    };
    let most = |of: &dyn Fn(&Outputs) -> f64| here.iter().map(of).fold(0.0, f64::max);
    let force_n = most(&|outputs| outputs.air_total().force_n.norm());
    for (a, b) in here.iter().zip(&there) {
        let way = FRAME_M_S * a.time_s;
        let points = a.tips().iter().chain(a.stations()).zip(b.tips().iter().chain(b.stations()));
        for (i, (a, b)) in points.enumerate() {
            see((a.position_m - way - b.position_m).norm(), 1.0, format!("position {i}"));
            see((a.velocity_m_s - FRAME_M_S - b.velocity_m_s).norm(), 10.0, format!("velocity {i}"));
        }
        see((a.air_total().force_n - b.air_total().force_n).norm(), force_n, "air".to_owned());
    }
    if worst.0 < bound { Verdict::Holds } else { Verdict::Broken(format!("{:.1e}, {}", worst.0, worst.1)) }
}

/// Along the motion of co-simulation: what the states of Model Exchange change by is the integral of their derivatives. Simpson's
/// rule over spans that are halved: the error of a right derivative falls to a sixteenth or less, that of a wrong one stays.
pub fn exchange(model: &Model) -> Verdict {
    let view = View::plain();
    let miss = |parts: usize| -> Result<Option<f64>, String> {
        let mut machine = machine(model, &view)?;
        machine.solver.tolerance = 1e-10;
        let mut plant = start(machine)?;
        let Ok(hybrid) = plant.hybrid() else { return Ok(None) };
        let states = hybrid.states();
        if states == 0 {
            return Ok(None);
        }
        let span_s = step_s(&plant) / parts as f64;
        let sample = |plant: &Plant| -> Result<[Vec<f64>; 2], String> {
            let snapshot = plant.snapshot();
            let mut other = Plant::new(Arc::new(plant.machine().clone()));
            other.restore(&snapshot).map_err(|error| error.to_string())?;
            let mut hybrid = other.hybrid().map_err(|error| error.to_string())?;
            let (mut x, mut f) = (vec![0.0; states], vec![0.0; states]);
            hybrid.read(&mut x);
            hybrid.derivatives(&mut f).map_err(|error| error.to_string())?;
            Ok([x, f])
        };
        let mut worst = 0.0f64;
        // two places of the run
        for begin in [3, 15] {
            while plant.time_s() < step_s(&plant) * (begin as f64 - 0.5) {
                let step = (plant.time_s() / step_s(&plant)).round() as usize;
                advance(&mut plant, model, &view, step, 1)?;
            }
            let begin_s = plant.time_s();
            let mut samples = Vec::new();
            for i in 0..3 {
                if i > 0 {
                    plant.step(begin_s + 0.5 * f64::from(i) * span_s).map_err(|error| error.to_string())?;
                }
                samples.push(sample(&plant)?);
            }
            for k in 0..states {
                let [a, b, c] = [&samples[0], &samples[1], &samples[2]];
                let by = (a[1][k] + 4.0 * b[1][k] + c[1][k]) * span_s / 6.0;
                let size = samples.iter().map(|of| of[1][k].abs()).fold(1e-3, f64::max) * span_s;
                worst = worst.max((c[0][k] - a[0][k] - by).abs() / size);
            }
            plant.step(begin_s + step_s(&plant)).map_err(|error| error.to_string())?;
        }
        Ok(Some(worst))
    };
    let Ok(Some(coarse)) = miss(16) else { return Verdict::Silent };
    if coarse < 1e-3 {
        return Verdict::Holds;
    }
    let Ok(Some(fine)) = miss(256) else { return Verdict::Silent };
    if fine < 1e-3 || fine < 0.1 * coarse {
        Verdict::Holds
    } else {
        Verdict::Broken(format!("off by {coarse:.1e} of the change over a 16th of a step, by {fine:.1e} over a 256th"))
    }
}
