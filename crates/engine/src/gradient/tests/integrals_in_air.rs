//! Integrals over runs in air: means of outputs, eq. (X20), and energy accounts, eq. (X22), whose integrands depend on the loads of the
//! aerodynamic step.

use super::air::{AIR_PLACES, AirPlace, InAir, Kind, compare_results_in_air};
use super::*;

/// Means of a coordinate of the tip and of a reaction of the root, the mean square of the lift, and both energy accounts.
fn integrals(plant: &Plant) -> Vec<RunResult> {
    let layout = *plant.outputs().layout();
    let outputs = [
        (layout.tips.place(0, 0) + 2, 0, false),
        (layout.air_total.place(0, 0) + 2, 1, true),
        (layout.root.place(0, 0) + 3, 0, false),
    ];
    let means = outputs.map(|(index, time, square)| RunResult::Mean { index, time, square });
    let accounts = layout.accounts().map(|index| RunResult::Output { index, time: 0 });
    means.into_iter().chain(accounts).collect()
}

/// GR-110: through a rigid latch with a prescribed root joint, whose work in the impulse is no energy of the machine, onto a stop in the
/// staggered coupling, and with a boom and a propeller, up to times within steps: both ways, and by differences of runs with the same steps.
#[test]
fn integrals_in_air_pass_through_events() {
    let kinds = [
        Kind { rigid: true, driven: true, ..Kind::FULL },
        Kind { latched: false, staggered: true, ..Kind::FULL },
        Kind { several: true, unsteady: true, ..Kind::PLAIN },
    ];
    for (number, kind) in kinds.into_iter().enumerate() {
        let times_s = [0.1213, 0.159];
        let places = [0, 9].map(|place| AIR_PLACES[place]);
        let results = |plant: &Plant| {
            let accounts = plant.outputs().layout().accounts();
            let is_account =
                |result: &RunResult| matches!(result, RunResult::Output { index, .. } if accounts.contains(index));
            integrals(plant).into_iter().filter(|result| !kind.driven || !is_account(result)).collect()
        };
        let (both, differences, events) =
            compare_results_in_air(kind, (&times_s, &places), results, |tape, machine, results| {
                retraced_at(tape, machine, &InputRows::default(), (&times_s, results))
            });
        println!("GR-110 {number}: {both:.1e} {differences:.1e}, {events} events");
        assert!(events > 0, "{number}: no event");
        assert!(both < 1e-10, "{number}: {both:.1e}");
        assert!(differences < 1e-6, "{number}: {differences:.1e}");
    }
}

/// GR-110: a failure within an aerodynamic step, by its time.
#[test]
fn integrals_in_air_pass_through_a_failure() {
    let kind = Kind { latched: false, fails: true, ..Kind::FULL };
    let times_s = [0.1213, 0.159];
    let time: AirPlace = ("fail_s", |n| &mut n.wing.fail_s);
    let places = [AIR_PLACES[0], AIR_PLACES[9], time];
    let (both, differences, _) =
        compare_results_in_air(kind, (&times_s, &places), integrals, |tape, machine, results| {
            retraced_at(tape, machine, &InputRows::default(), (&times_s, results))
        });
    println!("GR-110 failure: {both:.1e} {differences:.1e}");
    assert!(both < 1e-10, "{both:.1e}");
    assert!(differences < 1e-6, "{differences:.1e}");
}

/// GR-110: values of the integrals are those of the outputs of the run: the mean is the integral of samples by Simpson's rule to its error, and
/// the accounts close the balance of the energies.
#[test]
fn integrals_in_air_are_those_of_the_outputs() {
    let kind = Kind { latched: false, ..Kind::FULL };
    let machine = || InAir::USUAL.machine(kind).unwrap_or_else(|error| panic!("{error}"));
    let times_s = [0.02, 0.04];
    let mut plant = started(machine());
    let tape = plant.run_on_tape(&times_s).unwrap_or_else(|error| panic!("{error}"));
    let results = integrals(&plant);
    let mut gradient = Gradient::new(&mut plant, &tape, Vec::new()).unwrap_or_else(|error| panic!("{error}"));
    let values = gradient.values(&results).unwrap_or_else(|error| panic!("{error}"));
    let mut beside = started(machine());
    let layout = *beside.outputs().layout();
    let [work, dissipated] = layout.accounts();
    let index = layout.tips.place(0, 0) + 2;
    let count = 20;
    let mut samples = vec![beside.outputs().values()[index]];
    for sample in 1..=count {
        beside.step(times_s[0] * f64::from(sample) / f64::from(count)).unwrap_or_else(|error| panic!("{error}"));
        samples.push(beside.outputs().values()[index]);
    }
    let weight = |at: usize| match at {
        0 => 1.0,
        at if at == samples.len() - 1 => 1.0,
        at if at % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let sum: f64 = samples.iter().enumerate().map(|(at, value)| weight(at) * value).sum();
    let known = sum / (3.0 * f64::from(count));
    assert!((values[0] - known).abs() < 1e-5 * known.abs(), "{} and {known}", values[0]);
    let now = beside.outputs().values();
    for (value, account) in values[3..].iter().zip([work, dissipated]) {
        assert!((value - now[account]).abs() < 1e-9 * now[account].abs(), "{value} and {}", now[account]);
    }
}
