//! Invariants, each a function of a machine.

use crate::machines::{Doing, Model, View};
use crate::outputs::worst;
use crate::rows::{Rows, linear_rows_agree_at};
use crate::{STEPS, Verdict, advance, machine, run, run_on, start, step_s};
use foldwing::aero::AirOptions;
use foldwing::config;
use foldwing::interface::Interface;
use foldwing::machine::{
    Air, Body, Coupling, JointKind, JointMotion, Machine, Method, Motion, Parent, Solver, SpatialFreedom,
};
use foldwing::plant::{Holding, Hybrid, Outputs, Plant, Snapshot};
use nalgebra::{DMatrix, DVector, Vector3};
use std::sync::Arc;

/// A run of the machine in its original view; `None` if it is rejected.
fn plain(model: &Model) -> Option<Vec<Outputs>> {
    machine(model, &View::plain()).and_then(start).and_then(|plant| run(plant, model, &View::plain(), 1)).ok()
}

/// A machine in another view against the original machine. Both take the same steps except for round-off, which Newton's iteration and the
/// motion amplify.
pub fn seen_otherwise(model: &Model, view: &View) -> Verdict {
    // seeded turbulence is not symmetric
    if view.mirror && model.has("wind.turbulence") {
        return Verdict::Silent;
    }
    // copies in the mirror image are numbered in the opposite order: the second of three becomes the third
    if view.mirror && model.copies().is_some_and(|count| count > 2) {
        return Verdict::Silent;
    }
    // at the file's tolerance most agree to 1e-10; Newton's iteration may leave errors of 1e-8, which appear in the accelerations of stiff
    // parts
    match seen_otherwise_with(model, view, None, 1e-7) {
        Verdict::Holds => {}
        verdict => return verdict,
    }
    // forces of loops are gaps of 1e-16 m times a stiffness of 1e5 N/m, to which light sections respond
    let bound = if model.has("loop") { 1e-8 } else { 1e-9 };
    match seen_otherwise_with(model, view, Some(1e-11), bound) {
        // if iterations cannot reach round-off
        Verdict::Silent | Verdict::Holds => Verdict::Holds,
        // the error of the iterations falls with their tolerance
        Verdict::Broken(why) => match seen_otherwise_with(model, view, Some(1e-13), bound) {
            Verdict::Holds => Verdict::Holds,
            Verdict::Silent | Verdict::Broken(_) => Verdict::Broken(why),
        },
    }
}

/// The comparison with the file's solver, or with fixed steps and iterations to round-off.
fn seen_otherwise_with(model: &Model, view: &View, tolerance: Option<f64>, bound: f64) -> Verdict {
    let of = |view: &View| {
        let mut machine = machine(model, view)?;
        if let Some(tolerance) = tolerance {
            exactly(&mut machine, tolerance);
        }
        Ok(machine)
    };
    let run_of = |machine: Machine, view: &View| {
        let mut plant = start(machine)?;
        let outputs = run_on(&mut plant, model, view, 1)?;
        Ok((outputs, plant.statistics()))
    };
    let Ok(parsed) = of(&View::plain()) else { return Verdict::Silent };
    // a row of masses without moments of inertia can rotate about itself due to round-off
    let spins = |body: &Body| body.is_modal() && matches!(body.joint.kind, JointKind::Spatial(_));
    if parsed.bodies.iter().any(spins) {
        return Verdict::Silent;
    }
    let Ok::<_, String>((here, own)) = run_of(parsed.clone(), &View::plain()) else { return Verdict::Silent };
    // iterations to round-off may fail for either view: those of the file were compared before
    let exact = tolerance.is_some();
    let other: Machine = match of(view) {
        Ok(other) => other,
        Err::<_, String>(error) => return Verdict::Broken(format!("is refused in another view: {error}")),
    };
    let (there, others) = match run_of(other, view) {
        Ok(there) => there,
        Err::<_, String>(_) if exact => return Verdict::Silent,
        Err::<_, String>(error) => return Verdict::Broken(format!("stops in another view: {error}")),
    };
    let (off, what) = worst(&parsed, &here, &there, view);
    let (steps, other_steps) = ((own.steps, own.failures), (others.steps, others.failures));
    let bound = if steps == other_steps {
        bound
    } else if own.failures == 0 {
        return Verdict::Broken(format!("{steps:?} steps and failures, {other_steps:?} in another view"));
    } else {
        // if Newton's iteration fails, round-off may decide this, and other steps follow: compare within the tolerance
        let mut looser = parsed.clone();
        looser.solver.tolerance *= 1.1;
        match run_of(looser, &View::plain()) {
            Ok((beside, _)) => bound.max(SAME_TOLERANCE * worst(&parsed, &here, &beside, &View::plain()).0),
            Err::<_, String>(_) => return Verdict::Silent,
        }
    };
    if off < bound { Verdict::Holds } else { Verdict::Broken(format!("{off:.1e}, {what}")) }
}

/// Allowed difference of runs with different steps, relative to that of two runs whose tolerances differ by a factor of ten.
const SAME_TOLERANCE: f64 = 10.0;

/// Fixed steps, and iterations to a given tolerance, whatever the solver settings of the file.
fn exactly(machine: &mut Machine, tolerance: f64) {
    let span_s = machine.air.as_ref().map_or(machine.experiment.step_s, |air| air.step_s);
    machine.solver =
        Solver { tolerance, method: Method::Esdirk4, fixed_step_s: Some(0.25 * span_s), ..Solver::default() };
    if let Some(Air { coupling: Coupling::Iterated { tolerance: own, most_iterations }, .. }) = &mut machine.air {
        (*own, *most_iterations) = (1e-12, 1000);
    }
}

/// Drift of the energy balance relative to the largest energy that is exchanged, or stored in bodies and springs: the error of strains at a
/// tolerance is a fraction of it.
fn drift(outputs: &[Outputs]) -> f64 {
    let account = |outputs: &Outputs| {
        let energy = outputs.energy();
        energy.total - energy.work + energy.dissipated
    };
    let cover = |of: fn(&Outputs) -> f64| {
        let values = outputs.iter().map(of);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    let stored = |of: fn(&Outputs) -> f64| outputs.iter().map(|outputs| of(outputs).abs()).fold(0.0, f64::max);
    let exchanged = cover(|outputs| outputs.energy().kinetic)
        .max(cover(|outputs| outputs.energy().work))
        .max(cover(|outputs| outputs.energy().dissipated))
        .max(stored(|outputs| outputs.energy().elastic))
        .max(stored(|outputs| outputs.energy().motor));
    let begin = account(&outputs[0]);
    outputs.iter().map(|outputs| (account(outputs) - begin).abs()).fold(0.0, f64::max) / exchanged.max(1e-9)
}

/// Integrates a machine by the fourth-order method with a tolerance, whatever the method and steps of its file.
fn by_tolerance(machine: &mut Machine, tolerance: f64) {
    let max_step_s = machine.solver.max_step_s;
    machine.solver = Solver { tolerance, method: Method::Esdirk4, max_step_s, ..Solver::default() };
}

/// The energy balance closes to ten tolerances, or to the discretisation error: then a tighter tolerance reduces it. An error in a power
/// would remain. Uses the fourth-order method, for which tight tolerances are cheap: the balance does not depend on the method.
pub fn energy(model: &Model) -> Verdict {
    let at = |tolerance: f64| {
        let mut machine = machine(model, &View::plain())?;
        by_tolerance(&mut machine, tolerance);
        if let Some(Air { coupling: Coupling::Iterated { tolerance: own, .. }, .. }) = &mut machine.air {
            *own = tolerance;
        }
        run(start(machine)?, model, &View::plain(), 1).map(|outputs| drift(&outputs))
    };
    let tolerance = 1e-6;
    let Ok(coarse) = at(tolerance) else { return Verdict::Silent };
    if coarse < 10.0 * tolerance {
        return Verdict::Holds;
    }
    // a method of fourth order gains a factor of 1000 from tolerances that much tighter, less if the maximum step bounded the error before,
    // if steps pass corners of a table, or if stiff strains start to move; 1e-7 is the effect of round-off on these
    let gain = if model.tables.iter().any(|table| table.has("table_rpm_N_m")) { 0.3 } else { 0.1 };
    let mut found = String::new();
    for share in [1e-4, 1e-6] {
        let Ok(fine) = at(share * tolerance) else { return Verdict::Silent };
        if fine < gain * coarse || fine < 1e-7 {
            return Verdict::Holds;
        }
        found += &format!(", by {fine:.1e} at {:.0e}", share * tolerance);
    }
    Verdict::Broken(format!("the account drifts by {coarse:.1e} at a tolerance of {tolerance:.0e}{found}"))
}

/// Rollback, continuation in another instance, and reinitialisation.
pub fn states(model: &Model) -> Verdict {
    let view = View::plain();
    let Some(outputs) = plain(model) else { return Verdict::Silent };
    let parsed = Arc::new(machine(model, &view).expect("it ran"));
    let fresh = || {
        let mut plant = Plant::new(parsed.clone());
        plant.initialize(parsed.experiment.start_time_s).expect("it ran");
        plant
    };
    let same = |plant: &Plant, at: usize, what: &str| {
        // bit-identical, switches included
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
    // everywhere between the events of a machine, also with the integrator ahead in the middle of a step
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
    // every step is taken, undone and repeated: for any event inside, it has occurred and been undone
    let mut undone = fresh();
    for step in 0..STEPS {
        let before = undone.snapshot();
        let inputs = undone.inputs().clone();
        for take in ["a step", "a step that was taken back"] {
            if let Err(error) = advance(&mut undone, model, &view, step, 1) {
                return Verdict::Broken(format!("{take} stops: {error}"));
            }
            if take == "a step" {
                if let Err(error) = undone.restore(&before) {
                    return Verdict::Broken(format!("the snapshot before a step is refused: {error}"));
                }
                if undone.inputs() != &inputs {
                    return Verdict::Broken("the snapshot before a step has other inputs".to_owned());
                }
            }
        }
        if let Some(broken) = same(&undone, step + 1, "a step that was taken back differs") {
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
    if let Err(error) = plant.initialize(parsed.experiment.start_time_s) {
        return Verdict::Broken(format!("does not begin again: {error}"));
    }
    match same(&plant, 0, "the second start differs")
        .or_else(|| goes_on(&mut plant, 0, STEPS, "a run from the second start differs"))
    {
        Some(broken) => Verdict::Broken(broken),
        None => Verdict::Holds,
    }
}

/// The integrator runs ahead of the communication points. With changed inputs it does not, so inputs are constant here.
pub fn communication(model: &Model) -> Verdict {
    let model = &Model { actions: Vec::new(), ..model.clone() };
    let Some(here) = plain(model) else { return Verdict::Silent };
    let parsed = machine(model, &View::plain()).expect("it ran");
    // fixed steps divide the communication step: shorter communication steps give a different run
    if parsed.solver.fixed_step_s.is_some() {
        return Verdict::Silent;
    }
    let there = start(parsed.clone()).and_then(|plant| run(plant, model, &View::plain(), 3));
    match there {
        Ok(there) => {
            let (off, what) = worst(&parsed, &here, &there, &View::plain());
            if off < 1e-12 { Verdict::Holds } else { Verdict::Broken(format!("{off:.1e}, {what}")) }
        }
        Err(error) => Verdict::Broken(format!("stops with a third of the communication step: {error}")),
    }
}

/// A file read twice, and read from the same tables as JSON, as passed by the Python package.
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

/// Asks for what rigid loops do not permit; returns what is not refused with the name of the loop and the cure.
pub fn refuse_rigid_loops(plant: &mut Plant) -> Result<(), String> {
    let Some(name) = plant.machine().closures.iter().find(|closure| closure.rigid).map(|closure| closure.name.clone())
    else {
        return Ok(());
    };
    let time_s = plant.machine().experiment.start_time_s;
    let Err(error) = plant.study().rotor(time_s, None).map(|_| ()) else {
        return Err("rotor analysis: not refused".to_owned());
    };
    let text = error.to_string();
    if !text.contains(&format!("{name:?}")) || !text.contains("stiffness_N_m") {
        return Err(format!("rotor analysis: {text}"));
    }
    match plant.hybrid().err() {
        Some(_) => Ok(()),
        None => Err("Model Exchange: not refused".to_owned()),
    }
}

/// Velocity of the other frame in m/s: along the ground of a lattice, so that the ground is unchanged.
const FRAME_M_S: Vector3<f64> = Vector3::new(4.0, -2.5, 0.0);

/// A flying machine, with or without aerodynamics, against the same one in a uniformly moving frame.
pub fn galilei(model: &Model) -> Verdict {
    let Ok(parsed) = machine(model, &View::plain()) else { return Verdict::Silent };
    // parts fixed in the root frame would move
    let on_root = parsed.bodies.iter().filter(|body| matches!(body.joint.parent, Parent::Root { .. })).count();
    let turns = model.actions.iter().any(|action| matches!(action.doing, Doing::RootSpin(..)));
    let flies = parsed.spatials().any(|(_, spatial)| spatial.freedom == SpatialFreedom::Free);
    // planes of skates and wheels too
    let on_planes = !parsed.no_slips.is_empty();
    if !flies || on_root > 1 || on_planes || turns || model.has("gust") || model.says("mirror_normal") {
        return Verdict::Silent;
    }
    let Some(here) = plain(model) else { return Verdict::Silent };
    let mut moving = parsed.clone();
    for body in &mut moving.bodies {
        if let JointKind::Spatial(spatial) = &mut body.joint.kind
            && spatial.freedom == SpatialFreedom::Free
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
    // the tolerances are fractions of the wing's length; the error of Newton's iteration is a hundredth of them
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
        let way = FRAME_M_S * (a.time_s - here[0].time_s);
        let points = a.tips().iter().chain(a.stations()).zip(b.tips().iter().chain(b.stations()));
        for (i, (a, b)) in points.enumerate() {
            see((a.position_m - way - b.position_m).norm(), 1.0, format!("position {i}"));
            see((a.velocity_m_s - FRAME_M_S - b.velocity_m_s).norm(), 10.0, format!("velocity {i}"));
        }
        see((a.air_total().force_n - b.air_total().force_n).norm(), force_n, "air".to_owned());
    }
    if worst.0 < bound { Verdict::Holds } else { Verdict::Broken(format!("{:.1e}, {}", worst.0, worst.1)) }
}

fn slopes(hybrid: &mut Hybrid<'_>, time_s: f64, x: &[f64]) -> Option<DVector<f64>> {
    hybrid.set(time_s, x);
    let mut f = DVector::zeros(x.len());
    hybrid.derivatives(f.as_mut_slice()).ok()?;
    Some(f)
}

/// Implicit midpoint rule for the hybrid system over a span, with a Jacobian by differences at its start.
fn integrated(hybrid: &mut Hybrid<'_>, begin: &[f64], begin_s: f64, span_s: f64, parts: usize) -> Option<Vec<f64>> {
    let n = begin.len();
    let step_s = span_s / parts as f64;
    let base = slopes(hybrid, begin_s, begin)?;
    let mut jacobian = DMatrix::zeros(n, n);
    for k in 0..n {
        let mut x = begin.to_vec();
        let bump = 1e-7 * (1.0 + x[k].abs());
        x[k] += bump;
        jacobian.set_column(k, &((slopes(hybrid, begin_s, &x)? - &base) / bump));
    }
    let factors = (DMatrix::identity(n, n) - jacobian * (0.5 * step_s)).lu();
    let mut x = DVector::from_column_slice(begin);
    let mut f = base;
    for part in 0..parts {
        let middle_s = begin_s + step_s * (part as f64 + 0.5);
        // the simplified Newton iteration gains a factor of a hundred per iteration over spans this short
        for iteration in 0..12 {
            let middle = &x + &f * (0.5 * step_s);
            let off = slopes(hybrid, middle_s, middle.as_slice())? - &f;
            let by = factors.solve(&off)?;
            f += &by;
            if by.amax() <= 1e-12 * f.amax() {
                break;
            }
            if iteration == 11 && by.amax() > 1e-8 * f.amax() {
                return None;
            }
        }
        x += &f * step_s;
        hybrid.set(begin_s + step_s * (part as f64 + 1.0), x.as_slice());
        hybrid.complete();
        hybrid.read(x.as_mut_slice());
    }
    Some(x.as_slice().to_vec())
}

/// Tolerance of the co-simulation with which Model Exchange is compared.
const EXCHANGE_TOLERANCE: f64 = 1e-9;
/// Aerodynamic steps in co-simulation in s, from long to short.
const AIR_STEPS_S: [f64; 3] = [2.5e-4, 6.25e-5, 1.5625e-5];
/// Allowed difference between Model Exchange and co-simulation at the end, relative to the motion.
const APART: f64 = 1e-4;

/// Model Exchange, integrated by a separate rule with three step sizes, against co-simulation over communication steps without events.
///
/// Co-simulation uses aerodynamic steps: their error falls with the square of the step, or with the step if a gust has a kink. The effect
/// of wrong derivatives would remain: a difference beyond the bound must fall to half or less for a sixteenth of the step.
pub fn exchange(model: &Model) -> Verdict {
    let mut found = Vec::<Apart>::new();
    for air_step_s in AIR_STEPS_S {
        let Some(apart) = exchanged(model, air_step_s) else { return Verdict::Silent };
        if apart.share <= APART {
            return Verdict::Holds;
        }
        let has_air_steps = apart.in_air;
        found.push(apart);
        if !has_air_steps {
            break;
        }
    }
    let shares: Vec<f64> = found.iter().map(|apart| apart.share).collect();
    let (last, earlier) = shares.split_last().expect("at least one");
    if earlier.iter().any(|share| *last <= 0.5 * share) {
        return Verdict::Holds;
    }
    let places: Vec<&str> = found.iter().map(|apart| apart.place.as_str()).collect();
    Verdict::Broken(format!("by the steps of the air: {}", places.join("; ")))
}

/// The largest difference between Model Exchange and co-simulation.
struct Apart {
    /// Part of the difference not explained by the errors of both sides, relative to the motion.
    share: f64,
    place: String,
    in_air: bool,
}

/// Compares Model Exchange and co-simulation for an aerodynamic step in s; `None` if no step can be compared.
fn exchanged(model: &Model, air_step_s: f64) -> Option<Apart> {
    let view = View::plain();
    let mut parsed = machine(model, &view).ok()?;
    by_tolerance(&mut parsed, EXCHANGE_TOLERANCE);
    let in_air = parsed.air.is_some();
    if let Some(air) = &mut parsed.air {
        air.step_s = air_step_s;
    }
    let mut plant = start(parsed.clone()).ok()?;
    let step_s = step_s(&plant);
    let mut worst: Option<Apart> = None;
    for step in 0..STEPS {
        let changes = model.actions.iter().any(|action| action.step == step);
        let (snapshot, events) = (plant.snapshot(), plant.statistics().events);
        advance(&mut plant, model, &view, step, 1).ok()?;
        // an indicator that is disarmed by an event, or that returns, has the same sign at both ends
        if changes || step % 6 != 4 || plant.statistics().events != events {
            continue;
        }
        let mut other = Plant::new(Arc::new(parsed.clone()));
        other.restore(&snapshot).expect("its own");
        let mut hybrid = other.hybrid().ok()?;
        let (mut begin, mut expected) = (vec![0.0; hybrid.states()], vec![0.0; hybrid.states()]);
        hybrid.read(&mut begin);
        let indicators = |hybrid: &Hybrid| {
            let mut values = vec![0.0; hybrid.indicators()];
            hybrid.read_indicators(&mut values);
            values.iter().map(|value| *value > 0.0).collect::<Vec<_>>()
        };
        let before = indicators(&hybrid);
        let begin_s = hybrid.time_s();
        if begin.is_empty() || hybrid.next_kink_s() <= begin_s + step_s {
            continue;
        }
        // not multiples of each other: the error of a step with a kink depends on the position of the kink in the step
        let ends = [23, 31, 40].map(|parts| integrated(&mut hybrid, &begin, begin_s, step_s, parts));
        let [Some(coarse), Some(medium), Some(fine)] = ends else { continue };
        if indicators(&hybrid) != before {
            continue;
        }
        let mut end = Plant::new(Arc::new(parsed.clone()));
        end.restore(&plant.snapshot()).expect("its own");
        end.hybrid().expect("as before").read(&mut expected);
        // coordinates, not rates: rates of stiff strains oscillate within the tolerances
        let lags = other.system_mut().exchange_lags().len();
        let coordinates = 0..(begin.len() - lags) / 2;
        let [coarse, medium, off] = [&coarse, &medium, &expected]
            .map(|other| coordinates.clone().map(|k| (fine[k] - other[k]).abs()).fold(0.0, f64::max));
        let own = coarse.max(medium);
        let moved = coordinates.clone().map(|k| (fine[k] - begin[k]).abs()).fold(1e-6, f64::max);
        // the rule's error falls with the square of its steps, at kinks with the step; each of a few hundred steps of co-simulation
        // contributes its tolerance
        let share = ((off - 2.0 * own - 100.0 * EXCHANGE_TOLERANCE) / moved).max(0.0);
        if worst.as_ref().is_none_or(|worst| share > worst.share) {
            let place = format!("step {step}: off by {off:.1e} of {moved:.1e}, own error {own:.1e}");
            worst = Some(Apart { share, place, in_air });
        }
    }
    worst
}

/// Numbers of lag states and of annuli with an indicator of a machine under an external integrator, after a third of the run: derivatives
/// beside its state are finite, and have the same bits from the saved state in another plant.
pub fn saved_in_exchange(model: &Model) -> Result<[usize; 2], Verdict> {
    let view = View::plain();
    let silent = |_| Verdict::Silent;
    let parsed = machine(model, &view).map_err(silent)?;
    let mut plant = start(parsed.clone()).map_err(silent)?;
    for step in 0..STEPS / 3 {
        advance(&mut plant, model, &view, step, 1).map_err(silent)?;
    }
    let snapshot = plant.snapshot();
    let lags = plant.exchange_lags().len();
    let mut found = Vec::<(Vec<f64>, Vec<f64>)>::new();
    let mut annuli = 0;
    let mut other = Plant::new(Arc::new(parsed));
    other.restore(&snapshot).map_err(|error| Verdict::Broken(error.to_string()))?;
    for plant in [&mut plant, &mut other] {
        let mut hybrid = plant.hybrid().map_err(|_| Verdict::Silent)?;
        let mut states = vec![0.0; hybrid.states()];
        hybrid.read(&mut states);
        let time_s = hybrid.time_s();
        // another state first: what it leaves behind must not matter
        if found.is_empty() {
            let beside: Vec<f64> = states.iter().map(|state| state + 1e-3 * (1.0 + state.abs())).collect();
            hybrid.set(time_s, &beside);
            let _ = hybrid.derivatives(&mut vec![0.0; states.len()]);
        }
        let near: Vec<f64> = states.iter().map(|state| state + 1e-6 * (1.0 + state.abs())).collect();
        hybrid.set(time_s, &near);
        let mut slope = states;
        hybrid.derivatives(&mut slope).map_err(|error| Verdict::Broken(error.to_string()))?;
        annuli = hybrid.switches();
        let mut distances = vec![0.0; annuli];
        hybrid.read_switches(&mut distances);
        if slope.iter().chain(&distances).any(|value| !value.is_finite()) {
            return Err(Verdict::Broken("not finite".to_owned()));
        }
        found.push((slope, distances));
    }
    match found[0] == found[1] {
        true => Ok([lags, annuli]),
        false => Err(Verdict::Broken("a saved state gives other derivatives".to_owned())),
    }
}

/// The machine with prescribed motions held at their initial positions: its equilibrium is that of the machine with the motions, NOTATION
/// (L1), and its simulation starts there without accelerations due to them.
fn with_laws_standing(mut machine: Machine) -> Option<Machine> {
    let start_s = machine.experiment.start_time_s;
    let mut plant = Plant::new(Arc::new(machine.clone()));
    plant.initialize(start_s).ok()?;
    let places: Vec<f64> = plant.outputs().joints().iter().map(|joint| joint.angle_rad).collect();
    let joints = machine.bodies.iter_mut().filter_map(|body| match &mut body.joint.kind {
        JointKind::Revolute(joint) | JointKind::Prismatic(joint) | JointKind::Sliding(joint) => Some(joint),
        JointKind::Clamped | JointKind::Spatial(_) => None,
    });
    for (joint, place) in joints.zip(places) {
        if let JointMotion::Prescribed(law) = &mut joint.motion {
            *law = Motion::Polynomial(vec![place]);
        }
    }
    Some(machine)
}

/// Rows of the linear model against differences of the machine, after a third of the run, at an instant without an event just before.
pub fn linear(model: &Model) -> Verdict {
    let view = View::plain();
    let Ok(mut parsed) = machine(model, &view) else { return Verdict::Silent };
    by_tolerance(&mut parsed, 1e-9);
    if parsed.sliding_joint().is_some() || parsed.closures.iter().any(|closure| closure.rigid) {
        // without an external integrator, the reference has no jump of the rates with the wind
        for part in parsed.air.iter_mut().flat_map(|air| &mut air.parts) {
            if let AirOptions::Strips(options) = &mut part.options {
                options.apparent_mass = false;
            }
        }
    }
    let rests = parsed.spatials().count() > 0 || parsed.closures.iter().any(|closure| closure.rigid);
    let start_s = parsed.experiment.start_time_s;
    let mut plant = Plant::new(Arc::new(parsed));
    if rests {
        // linear models only about an equilibrium: the prescribed motions are held there
        if plant.study().equilibrium(start_s, Holding::AsReleased).is_err() {
            return Verdict::Silent;
        }
        let Some(standing) = with_laws_standing(plant.machine().clone()) else { return Verdict::Silent };
        let mut standing = Plant::new(Arc::new(standing));
        if standing.study().equilibrium(start_s, Holding::AsReleased).is_err() {
            return Verdict::Broken("has an equilibrium only while its laws move".to_owned());
        }
        if let Some(apart) = linear_models_differ(&mut plant, &mut standing) {
            return Verdict::Broken(format!("at rest the rates of a law matter: {apart}"));
        }
        plant = standing;
    } else {
        if plant.initialize(start_s).is_err() {
            return Verdict::Silent;
        }
        for step in 0..STEPS / 3 {
            if advance(&mut plant, model, &view, step, 1).is_err() {
                return Verdict::Silent;
            }
        }
    }
    match linear_rows_agree_at(&mut plant) {
        Rows::Agree(_) => Verdict::Holds,
        Rows::Refused(why) => {
            println!("X-11 seed {}: {why}", model.seed);
            Verdict::Silent
        }
        Rows::Miss(why) => Verdict::Broken(why),
    }
}

/// First entry in which the linear models of two machines with the same variables differ.
fn linear_models_differ(one: &mut Plant, other: &mut Plant) -> Option<String> {
    let [a, b] = [one, other].map(|plant| {
        let interface = Interface::new(plant.machine());
        let (inputs, outputs) =
            (interface.real_inputs().collect::<Vec<_>>(), interface.real_outputs().collect::<Vec<_>>());
        interface.linearize(plant, &inputs, &outputs).map_err(|error| error.to_string())
    });
    // a prescribed motion with a rate permits no equilibrium, and the machine is rejected
    let (Ok(a), Ok(b)) = (a, b) else { return None };
    let [a_parts, b_parts] = [&a, &b].map(|model| {
        let matrices = &model.matrices;
        [("A", &matrices.a), ("B", &matrices.b), ("C", &matrices.c), ("D", &matrices.d)]
    });
    for ((what, a), (_, b)) in a_parts.into_iter().zip(b_parts) {
        let at = a.iter().zip(b).position(|(a, b)| a != b);
        if let Some(at) = at {
            return Some(format!(
                "{what}, row {}, column {}: {:e} and {:e}",
                at % a.nrows() + 1,
                at / a.nrows() + 1,
                a[at],
                b[at]
            ));
        }
    }
    None
}
