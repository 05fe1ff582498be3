//! Gradients of motors with torque limits and rate limits.

use super::refusals::fold;
use super::*;
use crate::signal::JointInputs;
use crate::system::{EnergyOutputs, JointOutputs};
use std::mem::offset_of;

const LIMIT: Place = ("limit", |n| &mut n.limit);
const RATE_LIMIT: Place = ("rate_limit", |n| &mut n.rate_limit);

/// Strain, height, angle, energy and torque of the motor and accounts at both times, and the latch time.
pub(super) fn results(plant: &Plant, latch: Option<usize>) -> Vec<RunResult> {
    let layout = *plant.outputs().layout();
    let indices = [
        layout.gauges.place(0, 0),
        layout.tips.place(0, 0) + 2,
        layout.joints.place(1, 0),
        layout.joints.place(1, offset_of!(JointOutputs, motor_torque_n_m)),
        layout.joints.place(1, offset_of!(JointOutputs, neutral_angle_rad)),
        layout.energy.place(0, offset_of!(EnergyOutputs, motor)),
        layout.energy.place(0, offset_of!(EnergyOutputs, total)),
    ];
    let indices: Vec<usize> = indices.into_iter().chain(layout.accounts()).collect();
    let outputs = (0..2).flat_map(|time| indices.iter().map(move |index| RunResult::Output { index: *index, time }));
    outputs.chain(latch.map(|joint| RunResult::LatchTime { joint })).collect()
}

/// Numbers of the usual wing without an end stop.
pub(super) fn usual(names: &[&str]) -> Vec<Place> {
    PLACES.into_iter().filter(|place| names.contains(&place.0)).collect()
}

/// A share of the torque limit, below 1, at which no stage is at the limit to within `distance` of it, and many lie on either side: the pieces
/// of stages do not change along the differences.
pub(super) fn clear_limit(started: impl Fn(f64) -> Plant, inputs: &InputRows, distance: f64) -> f64 {
    let clear = |share: &f64| {
        let mut plant = started(*share);
        let tape = plant.run_on_tape_with(inputs, &TIMES_S).unwrap_or_else(|error| panic!("{error}"));
        let (mut stages, mut near) = ([0; 2], false);
        for step in &tape.steps {
            parameter::adopt(plant.system_mut(), step, &tape.inputs);
            let joint = plant.system_mut().equations.forces.joints()[1].clone();
            let (c, motor) = (joint.coordinate, joint.motor().unwrap());
            for at in step.later() {
                let (time_s, angle_rad, rate_rad_s) = (at.time_s, at.q[c], at.v[c]);
                let limited = motor.limit_distances_n_m(time_s, angle_rad, rate_rad_s).iter().any(|left| *left < 0.0);
                stages[usize::from(limited)] += 1;
                // of the torque at zero rate too, which energies and accounts have
                near |= motor.is_at_limit(time_s, angle_rad, rate_rad_s, distance);
            }
        }
        stages[0] > 20 && stages[1] > 20 && !near
    };
    (0..120).map(|number| 0.3 + 0.005 * f64::from(number)).find(clear).expect("a limit")
}

/// GR-73: the wing of GR-01 whose motor starts at its torque limit, leaves it and reaches it again, with energies and accounts, by the limit
/// and eight numbers.
#[test]
fn gradients_pass_through_a_torque_limit() {
    let machine_of = |numbers: Numbers, share: f64| {
        let mut machine = numbers.machine(true)?;
        fold(&mut machine).motor.torque_limit_n_m = share * numbers.limit;
        Ok::<_, String>(machine)
    };
    let limit = |share: f64| started(machine_of(Numbers::USUAL, share).unwrap());
    let share = clear_limit(limit, &InputRows::default(), 4.0 * DIFFERENCE);
    let machine = |numbers: Numbers| machine_of(numbers, share);
    let names = ["stiffness", "damping", "torque", "command", "latch_angle", "start_angle", "length", "mass"];
    let places: Vec<Place> = usual(&names).into_iter().chain([LIMIT]).collect();
    let compared = compare_results(machine, &InputRows::default(), &places, |plant| results(plant, Some(1)));
    let Compared { forward_and_adjoint, differences, events } = compared;
    println!("GR-73 {forward_and_adjoint:.1e} {differences:.1e}");
    assert!(events > 0, "no event");
    assert!(forward_and_adjoint < 1e-9, "{forward_and_adjoint:.1e}");
    assert!(differences < 1e-6, "{differences:.1e}");
}

/// An arm of 1 kg·m² on a motor.
fn arm(motor: Motor, start_angle_rad: f64, fixed_step_s: Option<f64>) -> Result<Plant, String> {
    let body = Body::rigid("arm").inertia(1.0, [0.0; 3], nalgebra::Matrix3::identity());
    let hinge = Joint::revolute("hinge", [0.0, 0.0, 1.0]).motor(motor).start_angle_rad(start_angle_rad);
    let builder = Machine::builder("Arm").gravity_m_s2([0.0; 3]).body(body, hinge);
    let solver = Solver { tolerance: 1e-10, fixed_step_s, ..Solver::default() };
    plant_of(builder.solver(solver).build().map_err(|refused| refused.to_string()))
}

/// GR-74: an arm that a motor of stiffness `k` turns at its limit `L` until `k θ = L`: `θ̈ = −L` and then a vibration, by `L`, `k` and the
/// start angle. The limit is no event, so that the slopes of the run differ from those of the motion by a share of the step in which it is
/// left.
#[test]
fn an_arm_leaves_the_torque_limit() {
    let usual = [1.0, 4.0, 1.1];
    let end_s = 1.6;
    let known = |[limit, stiffness, start]: [f64; 3]| {
        let edge = limit / stiffness;
        let left_s = (2.0 * (start - edge) / limit).sqrt();
        let (rate, frequency) = (-limit * left_s, stiffness.sqrt());
        let (sin, cos) = (frequency * (end_s - left_s)).sin_cos();
        edge * cos + rate / frequency * sin
    };
    let plant = |[limit, stiffness, start]: [f64; 3]| {
        let motor = Motor { stiffness_n_m_rad: stiffness, torque_limit_n_m: limit, ..Motor::default() };
        arm(motor, start, None)
    };
    let beside = |place: usize, shift: f64| {
        let mut numbers = usual;
        numbers[place] += shift;
        numbers
    };
    let mut own = plant(usual).unwrap();
    own.initialize(0.0).unwrap();
    let tape = own.run_on_tape(&[end_s]).unwrap_or_else(|error| panic!("{error}"));
    let result = RunResult::Output { index: own.outputs().layout().joints.place(0, 0), time: 0 };
    let parameters = (0..3)
        .map(|place| Parameter::new("number", 0.0, 1e-3 * usual[place], |shift| plant(beside(place, shift))).unwrap());
    let mut gradient = Gradient::new(&mut own, &tape, parameters.collect()).unwrap();
    let forward = gradient.forward(&[result]).unwrap().remove(0);
    let adjoint = gradient.adjoint(result).unwrap();
    for place in 0..3 {
        let slope = (known(beside(place, 1e-5)) - known(beside(place, -1e-5))) / 2e-5 * usual[place];
        let [forward, adjoint] = [forward[place], adjoint[place]].map(|slope| slope * usual[place]);
        println!("GR-74 {place}: {forward} {adjoint} {slope}");
        assert!((forward - adjoint).abs() < 1e-10, "{place}: {forward} and {adjoint}");
        // the largest of these slopes is 1.07
        assert!((forward - slope).abs() < 2e-3, "{place}: {forward} and {slope}");
    }
}

/// A start, or a constant torque, exactly at the torque limit has two one-sided slopes: an error.
#[test]
fn a_motor_exactly_at_its_limit_is_refused() {
    let motors = [
        Motor { stiffness_n_m_rad: 2.0, torque_limit_n_m: 1.0, ..Motor::default() },
        Motor { constant_torque_n_m: 1.0, torque_limit_n_m: 1.0, ..Motor::default() },
    ];
    for motor in motors {
        let mut plant = arm(motor, 0.5, Some(0.01)).unwrap();
        plant.initialize(0.0).unwrap();
        let error = plant.run_on_tape(&[0.1]).map(|_| ()).expect_err("at the limit").to_string();
        assert!(
            error.contains("joint hinge, at 0 s: the torque of its motor is exactly at the torque limit"),
            "{error}"
        );
    }
}

/// Rows of the fold's command: a jump, which is reached after a while, a jump back to a ramp, which is met, and a ramp that is faster than
/// the limit.
fn commands(machine: &Machine) -> InputRows {
    let plant = Plant::new(Arc::new(machine.clone()));
    let index = plant.inputs().layout().joints.place(1, offset_of!(JointInputs, command_rad));
    let values = vec![0.2, 0.21, 0.6, 0.55, 0.35, 0.25, -1.1, -1.0];
    let column = InputColumn { index, held: false, values };
    let times_s = vec![-0.1, 0.021, 0.021, 0.173, 0.173, 0.301, 0.361, 0.6];
    InputRows::new(times_s, vec![column]).unwrap_or_else(|error| panic!("{error}"))
}

/// Gradients of a wing under the commands, both ways and against runs with the same steps, each slope times its number, of the result's
/// largest, and the derivatives by the rows from runs. `difference`: between the runs, as a share of a number, or in rad.
fn compare_commanded(
    machine: impl Fn(Numbers) -> Result<Machine, String>,
    numbers: &[Place],
    difference: f64,
) -> ([f64; 2], Vec<Vec<f64>>) {
    let own = machine(Numbers::USUAL).unwrap();
    let inputs = commands(&own);
    let mut plant = commanded(own.clone(), &inputs);
    let tape = plant.run_on_tape_with(&inputs, &TIMES_S).unwrap_or_else(|error| panic!("{error}"));
    let timed = tape.steps.iter().filter(|step| step.ending == Ending::Timed).count();
    assert!(timed >= 2, "{timed} ends of slews");
    let pieces = plant.pieces_on_tape(&tape);
    let results = results(&plant, tape.latch_time_s(1).map(|_| 1));
    let rows = inputs.times_s().len();
    let fresh = || Ok::<_, String>(Plant::new(Arc::new(own.clone())));
    let mut parameters = vec![Parameter::of_rows("rows", (0, (0..rows).collect()), 1e-3, fresh).unwrap()];
    for place in numbers {
        let machine = |shift| plant_of(machine(beside(*place, shift)));
        parameters.push(Parameter::new(place.0, 0.0, 1e-3 * size(*place), machine).unwrap());
    }
    let mut gradient = Gradient::new(&mut plant, &tape, parameters).unwrap_or_else(|error| panic!("{error}"));
    let forward = gradient.forward(&results).unwrap_or_else(|error| panic!("{error}"));
    let adjoint: Vec<Vec<f64>> =
        results.iter().map(|result| gradient.adjoint(*result).unwrap_or_else(|error| panic!("{error}"))).collect();
    let run = |machine: Machine, inputs: &InputRows| {
        let mut plant = commanded(machine, inputs);
        let mut copy = plant.run_along(&tape, inputs).unwrap_or_else(|error| panic!("{error}"));
        // a stage that passes a kink between two runs would spoil their difference
        assert!(plant.pieces_on_tape(&copy) == pieces, "a stage is on another piece");
        for time_s in TIMES_S {
            plant.request(&mut copy, time_s).unwrap_or_else(|error| panic!("{error}"));
        }
        Gradient::new(&mut plant, &copy, Vec::new()).unwrap().values(&results).unwrap_or_else(|error| panic!("{error}"))
    };
    let mut known = Vec::new();
    let mut differentiate = |size: f64, run: &dyn Fn(f64) -> Vec<f64>| {
        let mut slopes = vec![0.0; results.len()];
        for (steps, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
            add(&mut slopes, weight / (12.0 * difference), &run(steps * difference * size));
        }
        known.push(slopes);
    };
    for row in 0..rows {
        differentiate(1.0, &|shift| {
            let mut columns = inputs.columns().to_vec();
            columns[0].values[row] += shift;
            run(own.clone(), &InputRows::new(inputs.times_s().to_vec(), columns).unwrap())
        });
    }
    for place in numbers {
        differentiate(size(*place), &|shift| run(machine(beside(*place, shift)).unwrap(), &inputs));
    }
    let sizes: Vec<f64> = std::iter::repeat_n(1.0, rows).chain(numbers.iter().map(|place| size(*place))).collect();
    let mut worst = [0.0f64; 2];
    for (result, (forward, adjoint)) in forward.iter().zip(&adjoint).enumerate() {
        let scale = known.iter().fold(0.0f64, |scale, slopes| scale.max(slopes[result].abs()));
        for (column, size) in sizes.iter().enumerate() {
            let [forward, adjoint] = [forward[column], adjoint[column]].map(|slope| slope * size / scale);
            let apart = [(forward - adjoint).abs(), (forward - known[column][result] / scale).abs()];
            worst = [0, 1].map(|which| larger(worst[which], apart[which]));
            if apart[0] > 1e-9 || apart[1] > 1e-6 {
                println!("{:?} by {column}: {forward} {adjoint} {}", results[result], known[column][result] / scale);
            }
        }
    }
    known.truncate(rows);
    (worst, known)
}

pub(super) fn commanded(machine: Machine, inputs: &InputRows) -> Plant {
    let mut plant = Plant::new(Arc::new(machine));
    inputs.set(&mut plant, 0.0);
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    plant
}

/// GR-75: the wing of GR-01 whose motor follows its command at a rate limit, by each row of the command, the limit and four numbers: strains,
/// motions, torques, energies and accounts, the latch time.
#[test]
fn gradients_with_a_rate_limit() {
    let machine = |numbers: Numbers| {
        let mut machine = numbers.machine(true)?;
        fold(&mut machine).motor.rate_limit_rad_s = numbers.rate_limit;
        Ok::<_, String>(machine)
    };
    let numbers: Vec<Place> =
        usual(&["stiffness", "torque", "start_angle", "length"]).into_iter().chain([RATE_LIMIT]).collect();
    let (worst, known) = compare_commanded(machine, &numbers, DIFFERENCE);
    println!("GR-75 {:.1e} {:.1e}", worst[0], worst[1]);
    assert!(worst[0] < 1e-9, "{:.1e}", worst[0]);
    // by the row of 0.25 rad; 4.3e-6 found
    assert!(worst[1] < 1e-5, "{:.1e}", worst[1]);
    // the ramp to the sixth row is faster than the limit
    let rows = known.len();
    for (row, slopes) in known.iter().enumerate().take(rows - 2).skip(1) {
        assert!(slopes.iter().any(|slope| slope.abs() > 1e-6), "row {row} has no effect");
    }
}

/// GR-83: the same with a torque limit as well, which is reached while the command is approached, followed and missed.
#[test]
fn gradients_with_both_limits() {
    let machine_of = |numbers: Numbers, share: f64| {
        let mut machine = numbers.machine(true)?;
        // without the latch, whose range is reached just where the command is, so that the order of both changes between the runs
        fold(&mut machine).latch = None;
        let motor = &mut fold(&mut machine).motor;
        (motor.rate_limit_rad_s, motor.torque_limit_n_m) = (numbers.rate_limit, share * numbers.limit);
        Ok::<_, String>(machine)
    };
    // no stage passes a kink between the runs, which would change the piece of its torque and spoil their difference
    let share = 0.2 / Numbers::USUAL.limit;
    let numbers: Vec<Place> =
        usual(&["stiffness", "torque", "start_angle", "length"]).into_iter().chain([LIMIT, RATE_LIMIT]).collect();
    let (worst, _) = compare_commanded(|numbers| machine_of(numbers, share), &numbers, 5e-5);
    println!("GR-83 {:.1e} {:.1e}", worst[0], worst[1]);
    assert!(worst[0] < 1e-9, "{:.1e}", worst[0]);
    assert!(worst[1] < 1e-6, "{:.1e}", worst[1]);
}
