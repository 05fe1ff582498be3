//! Gradients through failures, at given times and at bounds of joint motions.

use super::limits::{results, usual};
use super::refusals::fold;
use super::*;
use crate::machine::Closure;
use crate::machine::failure::{Bound, BoundSide, FrictionBrake, Quantity};

const FAIL_S: Place = ("fail_s", |n| &mut n.fail_s);
const DELAY_S: Place = ("delay_s", |n| &mut n.delay_s);
const REMAINING: Place = ("remaining", |n| &mut n.remaining);

/// A failure after a delay.
fn failure(numbers: Numbers, effect: Effect) -> Failure {
    let (at_time_s, delay_s) = (Some(numbers.fail_s), numbers.delay_s);
    Failure { name: "snap".to_owned(), effect, at_time_s, after: None, when: None, delay_s }
}

/// The wing of GR-01 with a failure.
fn wing(numbers: Numbers, effect: Effect) -> Result<Machine, String> {
    let mut machine = numbers.machine(true)?;
    machine.failures.push(failure(numbers, effect));
    machine.solver.tolerance = 1e-12;
    Ok(machine)
}

fn agree(compared: &Compared, allowed: f64, words: &str) {
    let Compared { forward_and_adjoint, differences, .. } = compared;
    println!("{words}: {forward_and_adjoint:.1e} {differences:.1e}");
    assert!(*forward_and_adjoint < 1e-9, "{words}: {forward_and_adjoint:.1e}");
    assert!(*differences < allowed, "{words}: {differences:.1e}");
}

/// Compares by the time and delay of the failure, by `own` numbers and by some of the wing.
fn check(words: &str, machine: impl Fn(Numbers) -> Result<Machine, String>, own: &[Place], latch: bool) {
    let mut plant = started(machine(Numbers::USUAL).unwrap_or_else(|error| panic!("{error}")));
    let tape = plant.run_on_tape(&TIMES_S).unwrap_or_else(|error| panic!("{error}"));
    assert!(tape.steps.iter().any(|step| step.failures.iter().any(|failure| failure.has_failed())), "{words}");
    let names = ["stiffness", "torque", "start_angle", "length"];
    let places: Vec<Place> = usual(&names).into_iter().chain([FAIL_S, DELAY_S]).chain(own.iter().copied()).collect();
    let compared = compare_results(machine, &InputRows::default(), &places, |plant| results(plant, latch.then_some(1)));
    // a released lock starts stiff motions: 1.1e-6 found with Newton's iteration to 1e-12
    agree(&compared, 2e-6, words);
}

/// GR-76: a motor that loses its torque.
#[test]
fn gradients_pass_through_failures() {
    check("motor_loss", |n| wing(n, Effect::MotorLoss { body: 1 }), &[], false);
}

/// GR-76: motors that jam, springs that break, beams that lose stiffness, latches that do not catch.
#[test]
#[ignore = "long; `make long` runs it"]
fn gradients_pass_through_more_failures() {
    check("spring_break", broken_spring, &[REMAINING], true);
    check("stiffness_loss", |n| wing(n, Effect::StiffnessLoss { body: 0, remaining: n.remaining }), &[REMAINING], true);
    check("latch_no_capture", |n| wing(n, Effect::LatchNoCapture { body: 1 }), &[], false);
    check("motor_jam", |n| wing(n, Effect::MotorJam { body: 1 }), &[], false);
}

/// GR-77: a brake with a ramp and a motor that runs away, by their torque, ramp, slip rate, end and rate.
#[test]
fn gradients_pass_through_brakes_and_runaways() {
    let brake = |n: Numbers| FrictionBrake { torque_n_m: n.brake, ramp_s: n.ramp_s, slip_rad_s: n.slip };
    let own: [Place; 3] = [("brake", |n| &mut n.brake), ("ramp_s", |n| &mut n.ramp_s), ("slip", |n| &mut n.slip)];
    check("brake_applied", |n| wing(n, Effect::BrakeApplied { body: 1, brake: brake(n) }), &own, false);
    let runaway = |n: Numbers| wing(n, Effect::MotorRunaway { body: 1, to_rad: n.runaway, rate_rad_s: n.rate_limit });
    let own: [Place; 3] =
        [("runaway", |n| &mut n.runaway), ("rate_limit", |n| &mut n.rate_limit), ("command", |n| &mut n.command)];
    check("motor_runaway", runaway, &own, false);
}

/// The wing with a spring that breaks.
fn broken_spring(numbers: Numbers) -> Result<Machine, String> {
    wing(numbers, Effect::SpringBreak { body: 0, remaining: numbers.remaining })
}

/// GR-78: a lock that opens, a latch that breaks behind its closing, and a loop that opens, each by another failure and its delay.
#[test]
fn gradients_pass_through_chains_of_failures() {
    let locked = |numbers: Numbers| {
        let mut machine = broken_spring(numbers)?;
        fold(&mut machine).release = false;
        fold(&mut machine).start_rate_rad_s = 0.0;
        let effect = Effect::LockRelease { body: 1 };
        let delay_s = numbers.delay_s + 0.01;
        let name = "link".to_owned();
        machine.failures.push(Failure { name, effect, at_time_s: None, after: Some(0), when: None, delay_s });
        Ok::<_, String>(machine)
    };
    check("lock_release", locked, &[REMAINING], false);
    let mut intact = started(broken_spring(Numbers::USUAL).unwrap());
    let tape = intact.run_on_tape(&TIMES_S).unwrap_or_else(|error| panic!("{error}"));
    let later_s = tape.latch_time_s(1).expect("a latch time") + 0.03 - Numbers::USUAL.fail_s;
    let unlatched = |numbers: Numbers| {
        let mut machine = broken_spring(numbers)?;
        let effect = Effect::LatchBreak { body: 1 };
        let name = "hook".to_owned();
        let delay_s = later_s + numbers.delay_s;
        machine.failures.push(Failure { name, effect, at_time_s: None, after: Some(0), when: None, delay_s });
        Ok::<_, String>(machine)
    };
    check("latch_break", unlatched, &[REMAINING], true);
    let looped = |numbers: Numbers| {
        let tie = Closure::between("tie", ["inner", "root"], 60.0)
            .positions_m([0.15, 0.0])
            .offsets_m([[0.0; 3], [0.15, 0.0, 0.0]])
            .damping_n_s_m(0.5)
            .inertia_kg(0.02);
        let mut machine = numbers.builder(true).closure(tie).build().map_err(|refused| refused.to_string())?;
        let effect = Effect::LoopBreak { closure: 0, remaining: numbers.remaining };
        machine.failures.push(failure(numbers, effect));
        Ok::<_, String>(machine)
    };
    check("loop_break", looped, &[REMAINING], true);
}

/// GR-79: a failure where a joint passes an angle, and another where it passes a rate, by these bounds and eight numbers; the same with a
/// delay is an error.
#[test]
fn gradients_pass_through_bounds() {
    let bounded = |numbers: Numbers, quantity: Quantity, value: f64, side: BoundSide, delay_s: f64| {
        let mut machine = wing(numbers, Effect::MotorLoss { body: 1 })?;
        let when = Some(Bound { body: 1, quantity, value, side });
        let failure = &mut machine.failures[0];
        (failure.at_time_s, failure.when, failure.delay_s) = (None, when, delay_s);
        Ok::<_, String>(machine)
    };
    let own: Place = ("runaway", |n| &mut n.runaway);
    let names = ["stiffness", "damping", "torque", "start_angle", "start_rate", "length", "thickness", "mass"];
    let places: Vec<Place> = usual(&names).into_iter().chain([own]).collect();
    let angle = |n: Numbers| bounded(n, Quantity::Angle, n.runaway, BoundSide::Below, 0.0);
    let rate = |n: Numbers| bounded(n, Quantity::Rate, -3.0 * n.runaway, BoundSide::Below, 0.0);
    let compared = compare_results(angle, &InputRows::default(), &places, |plant| results(plant, None));
    assert!(compared.events > 0, "no bound");
    agree(&compared, 1e-6, "angle");
    let compared = compare_results(rate, &InputRows::default(), &places, |plant| results(plant, None));
    assert!(compared.events > 0, "no bound");
    agree(&compared, 3e-6, "rate");
    let late = bounded(Numbers::USUAL, Quantity::Angle, 0.9, BoundSide::Below, 0.01).unwrap();
    let error = started(late).run_on_tape(&TIMES_S).map(|_| ()).expect_err("a delay").to_string();
    assert!(
        error.contains("failures with a delay, a ramp or a runaway after a bound of a joint's motion (snap)"),
        "{error}"
    );
}

/// Two failures at one time, of which a number moves one, have no derivative by this number; by others they have.
#[test]
fn failures_that_coincide_are_refused_where_they_part() {
    let machine = |numbers: Numbers| {
        let mut machine = wing(numbers, Effect::SpringBreak { body: 0, remaining: 0.5 })?;
        machine.failures[0].delay_s = 0.0;
        let effect = Effect::MotorLoss { body: 1 };
        let (name, at_time_s) = ("dies".to_owned(), Some(Numbers::USUAL.fail_s));
        machine.failures.push(Failure { name, effect, at_time_s, after: None, when: None, delay_s: 0.0 });
        Ok::<_, String>(machine)
    };
    let mut plant = started(machine(Numbers::USUAL).unwrap());
    let tape = plant.run_on_tape(&[0.2]).unwrap_or_else(|error| panic!("{error}"));
    let result = RunResult::Output { index: plant.outputs().layout().joints.place(1, 0), time: 0 };
    for (place, covered) in [(FAIL_S, false), (PLACES[0], true)] {
        let parameter = Parameter::new(place.0, 0.0, 1e-4, |shift| plant_of(machine(beside(place, shift)))).unwrap();
        let mut gradient = Gradient::new(&mut plant, &tape, vec![parameter]).unwrap();
        let outcomes = [gradient.forward(&[result]).map(|_| ()), gradient.adjoint(result).map(|_| ())];
        for outcome in outcomes {
            match outcome {
                Ok(()) => assert!(covered),
                Err(GradientError::Simultaneous { first, second, .. }) => {
                    assert!(!covered && first == "failure dies" && second == "failure snap", "{first} {second}")
                }
                Err(error) => panic!("{error}"),
            }
        }
    }
}
