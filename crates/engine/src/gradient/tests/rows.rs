//! Gradients by rows of inputs over time whose present rows matter at the start, and whose rates matter.

use super::limits::{clear_limit, commanded};
use super::refusals::fold;
use super::*;
use crate::load::{RootMotion, Wrench};
use crate::signal::JointInputs;
use std::mem::offset_of;

/// Difference of runs in the unit of the input: an equilibrium at the start is found to 1e-9, which a smaller one would show.
const SHIFT: f64 = 1e-2;
/// The same for commands of a motor: over [`SHIFT`] the truncation of stiff motions is up to 3e-6.
const SHIFT_OF_COMMAND_RAD: f64 = 1e-4;

/// Derivatives by all rows of the only input over time, both ways and by differences of runs with the same steps: the largest differences,
/// relative to the result's largest.
fn by_rows(
    machine: &Machine,
    (inputs, shift): (&InputRows, f64),
    results: impl Fn(&Plant) -> Vec<RunResult>,
) -> [f64; 2] {
    let mut plant = commanded(machine.clone(), inputs);
    let tape = plant.run_on_tape_with(inputs, &TIMES_S).unwrap_or_else(|error| panic!("{error}"));
    let results = results(&plant);
    let rows = inputs.times_s().len();
    let fresh = || Ok::<_, String>(Plant::new(Arc::new(machine.clone())));
    let parameter = Parameter::of_rows("rows", (0, (0..rows).collect()), shift, fresh).unwrap();
    let mut gradient = Gradient::new(&mut plant, &tape, vec![parameter]).unwrap_or_else(|error| panic!("{error}"));
    // values first, as the command does: they leave the inputs of the end of the run
    gradient.values(&results).unwrap_or_else(|error| panic!("{error}"));
    let forward = gradient.forward(&results).unwrap_or_else(|error| panic!("{error}"));
    let adjoint: Vec<Vec<f64>> =
        results.iter().map(|result| gradient.adjoint(*result).unwrap_or_else(|error| panic!("{error}"))).collect();
    let mut known = vec![vec![0.0; rows]; results.len()];
    for row in 0..rows {
        for (steps, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
            let mut columns = inputs.columns().to_vec();
            columns[0].values[row] += steps * shift;
            let changed = InputRows::new(inputs.times_s().to_vec(), columns).unwrap();
            for (known, value) in known.iter_mut().zip(retraced_with(&tape, machine.clone(), &changed, &results)) {
                known[row] += weight / (12.0 * shift) * value;
            }
        }
    }
    let mut worst = [0.0f64; 2];
    for ((forward, adjoint), known) in forward.iter().zip(&adjoint).zip(&known) {
        let scale = known.iter().fold(0.0f64, |scale, slope| scale.max(slope.abs()));
        for ((forward, adjoint), known) in forward.iter().zip(adjoint).zip(known) {
            let apart = [(forward - adjoint).abs() / scale, (forward - known).abs() / scale];
            worst = [0, 1].map(|which| larger(worst[which], apart[which]));
        }
    }
    worst
}

/// GR-84: GR-02's wing from its static equilibrium under a load that changes over time, by the rows of the load: the first of them moves the
/// start.
#[test]
fn rows_of_a_load_move_the_equilibrium_at_the_start() {
    let mut machine = Numbers::USUAL.machine(false).unwrap();
    machine.experiment.start = StartState::Equilibrium;
    // the rest of Newton's iteration in each run is noise of the differences: 4.1e-6 at the tolerance of 1e-10 of the other tests
    machine.solver.tolerance = 1e-12;
    let layout = *Plant::new(Arc::new(machine.clone())).inputs().layout();
    let index = layout.stations.place(0, offset_of!(Wrench, force_n)) + 2;
    let column = InputColumn { index, held: false, values: vec![0.3, 0.4, 0.1, 0.5, 0.2] };
    let inputs = InputRows::new(vec![-0.1, 0.05, 0.15, 0.15, 0.6], vec![column]).unwrap();
    let worst = by_rows(&machine, (&inputs, SHIFT), |plant| {
        let layout = *plant.outputs().layout();
        let indices = [layout.gauges.place(0, 0), layout.joints.place(1, 0), layout.energy.place(0, 0)];
        (0..2).flat_map(|time| indices.map(|index| RunResult::Output { index, time })).collect()
    });
    println!("GR-84 {:.1e} {:.1e}", worst[0], worst[1]);
    assert!(worst[0] < 1e-10, "{:.1e}", worst[0]);
    assert!(worst[1] < 1e-7, "{:.1e}", worst[1]);
}

/// GR-85: accounts of GR-01's wing by the rows of an acceleration of the root and of gravity with a ramp and a jump: the work of a field
/// depends on its rate.
#[test]
fn accounts_by_rows_of_a_field() {
    let machine = Numbers::USUAL.machine(true).unwrap();
    let layout = *Plant::new(Arc::new(machine.clone())).inputs().layout();
    for (offset, first) in
        [(offset_of!(RootMotion, acceleration_m_s2), 1.0), (offset_of!(RootMotion, gravity_m_s2), -9.81)]
    {
        let values = [0.0, 2.0, 3.0, -1.0, 0.5].map(|change| first + change).to_vec();
        let column = InputColumn { index: layout.root.place(0, offset) + 2, held: false, values };
        let inputs = InputRows::new(vec![-0.1, 0.05, 0.18, 0.18, 0.6], vec![column]).unwrap();
        let worst = by_rows(&machine, (&inputs, SHIFT), |plant| {
            let indices = plant.outputs().layout().accounts();
            (0..2).flat_map(|time| indices.map(|index| RunResult::Output { index, time })).collect()
        });
        println!("GR-85 {:.1e} {:.1e}", worst[0], worst[1]);
        assert!(worst[0] < 1e-9, "{:.1e}", worst[0]);
        assert!(worst[1] < 1e-6, "{:.1e}", worst[1]);
    }
}

/// Rows of the command of the fold of a machine.
fn of_command(machine: &Machine, times_s: &[f64], values: &[f64]) -> InputRows {
    let layout = *Plant::new(Arc::new(machine.clone())).inputs().layout();
    let index = layout.joints.place(1, offset_of!(JointInputs, command_rad));
    let column = InputColumn { index, held: false, values: values.to_vec() };
    InputRows::new(times_s.to_vec(), vec![column]).unwrap()
}

/// Both accounts, strain and angle at both times.
fn accounts_and_motion(plant: &Plant) -> Vec<RunResult> {
    let layout = *plant.outputs().layout();
    let [work, dissipated] = layout.accounts();
    let indices = [work, dissipated, layout.gauges.place(0, 0), layout.joints.place(1, 0)];
    (0..2).flat_map(|time| indices.map(|index| RunResult::Output { index, time })).collect()
}

/// GR-115: accounts of GR-02's wing by the rows of the motor's command with ramps and a jump: a neutral angle that moves does work, also where
/// the torque is at its limit.
#[test]
fn accounts_by_rows_of_a_command() {
    let numbers = Numbers::USUAL;
    let machine = |limit_n_m: f64| {
        let mut machine = numbers.machine(false).unwrap();
        machine.solver.tolerance = 1e-12;
        let joint = fold(&mut machine);
        (joint.end_stops, joint.motor.torque_limit_n_m) = (None, limit_n_m);
        machine
    };
    let unlimited = machine(f64::MAX);
    let inputs = of_command(&unlimited, &[-0.1, 0.05, 0.18, 0.18, 0.6], &[0.1, 0.4, 0.6, 0.2, 0.5]);
    let limited = |share: f64| machine(share * numbers.limit);
    // of the smallest limit
    let distance = 4.0 * SHIFT_OF_COMMAND_RAD * numbers.stiffness / (0.3 * numbers.limit);
    let share = clear_limit(|share| commanded(limited(share), &inputs), &inputs, distance);
    for (machine, words) in [(unlimited, "without a limit"), (limited(share), "with a limit")] {
        let worst = by_rows(&machine, (&inputs, SHIFT_OF_COMMAND_RAD), accounts_and_motion);
        println!("GR-115 {words}: {:.1e} {:.1e}", worst[0], worst[1]);
        assert!(worst[0] < 1e-9, "{words}: {:.1e}", worst[0]);
        assert!(worst[1] < 1e-6, "{words}: {:.1e}", worst[1]);
    }
}

/// GR-116: the same by the rows of a constant command: the runs beside it jump, or change their rates, where it does not.
#[test]
fn rows_of_a_constant_command() {
    for method in [Method::Esdirk4, Method::TrBdf2] {
        let mut machine = Numbers::USUAL.machine(false).unwrap();
        machine.solver.tolerance = 1e-12;
        machine.solver.method = method;
        fold(&mut machine).end_stops = None;
        let inputs = of_command(&machine, &[-0.1, 0.05, 0.18, 0.18, 0.6], &[0.3; 5]);
        let worst = by_rows(&machine, (&inputs, SHIFT_OF_COMMAND_RAD), accounts_and_motion);
        println!("GR-116 {method:?}: {:.1e} {:.1e}", worst[0], worst[1]);
        assert!(worst[0] < 1e-9, "{method:?}: {:.1e}", worst[0]);
        assert!(worst[1] < 1e-6, "{method:?}: {:.1e}", worst[1]);
    }
}

/// GR-117: by the rows of the command of a motor that runs away: those before it move the neutral angle from which it runs, those behind it
/// nothing.
#[test]
fn rows_of_a_command_before_a_runaway() {
    let mut machine = Numbers::USUAL.machine(false).unwrap();
    machine.solver.tolerance = 1e-12;
    fold(&mut machine).end_stops = None;
    let effect = Effect::MotorRunaway { body: 1, to_rad: 0.9, rate_rad_s: 1.5 };
    let (name, at_time_s) = ("runaway".to_owned(), Some(0.11));
    machine.failures.push(Failure { name, effect, at_time_s, after: None, when: None, delay_s: 0.0 });
    let inputs = of_command(&machine, &[-0.1, 0.05, 0.18, 0.18, 0.6], &[0.1, 0.2, 0.3, 0.2, 0.5]);
    let worst = by_rows(&machine, (&inputs, SHIFT_OF_COMMAND_RAD), accounts_and_motion);
    println!("GR-117 {:.1e} {:.1e}", worst[0], worst[1]);
    assert!(worst[0] < 1e-9, "{:.1e}", worst[0]);
    assert!(worst[1] < 1e-6, "{:.1e}", worst[1]);
}
