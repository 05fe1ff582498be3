//! Gradients of runs with the staggered coupling, whose loads follow from a trial march under predicted loads, eq. (X39).

use super::air::{AIR_PLACES, AirPlace, InAir, Kind, compare_in_air, simulated};
use super::*;
use crate::signal::JointInputs;
use std::mem::offset_of;

/// GR-105: strips without lags, with lags, and with apparent mass, from a sudden and an established flow: both ways, and by fourth-order
/// differences of simulations.
#[test]
fn gradients_in_the_staggered_coupling_are_those_of_simulations() {
    for (unsteady, established, full) in [(false, true, false), (true, true, true), (true, false, false)] {
        let kind = Kind { unsteady, established, full, staggered: true, ..Kind::PLAIN };
        let times_s = [0.032, 0.064];
        let places = if full { &AIR_PLACES[..] } else { &AIR_PLACES[..4] };
        let (both, differences, events) =
            compare_in_air(kind, (&times_s, places), |_, machine, results| simulated(&times_s, machine, results));
        println!("GR-105 {unsteady} {established} {full}: {both:.1e} {differences:.1e}");
        assert_eq!(events, 0);
        assert!(both < 1e-10, "{unsteady} {established}: {both:.1e}");
        assert!(differences < 1e-6, "{unsteady} {established}: {differences:.1e}");
    }
}

/// GR-105: through a latch, elastic or rigid with a prescribed root joint, and onto a stop; with a boom and a propeller; at times within steps,
/// by differences of runs with the same steps. The trial march of the step meets the same events.
#[test]
fn gradients_in_the_staggered_coupling_pass_through_events() {
    let all = [
        Kind { latched: true, ..Kind::FULL },
        Kind { rigid: true, driven: true, ..Kind::FULL },
        Kind { latched: false, ..Kind::FULL },
        Kind { several: true, unsteady: true, ..Kind::PLAIN },
    ];
    for (number, kind) in all.into_iter().enumerate() {
        let kind = Kind { staggered: true, ..kind };
        let times_s = [0.1213, 0.159];
        let knot: AirPlace = ("knot", |n| &mut n.wing.stop);
        let mut places = [0, 2, 5, 7, 9, 11].map(|place| AIR_PLACES[place]).to_vec();
        places.extend(kind.rigid.then_some(knot));
        let (both, differences, events) = compare_in_air(kind, (&times_s, &places), |tape, machine, results| {
            retraced_at(tape, machine, &InputRows::default(), (&times_s, results))
        });
        println!("GR-105 {number}: {both:.1e} {differences:.1e}");
        assert!(events > 0, "{number}: no event");
        assert!(both < 1e-10, "{number}: {both:.1e}");
        assert!(differences < 1e-6, "{number}: {differences:.1e}");
    }
}

/// A failure within an aerodynamic step is an error by name; at the end of one it has derivatives.
#[test]
fn failures_within_steps_of_the_staggered_coupling_are_refused() {
    let kind = Kind { latched: false, fails: true, staggered: true, ..Kind::FULL };
    let machine = |fail_s: f64| {
        let mut numbers = InAir::USUAL;
        numbers.wing.fail_s = fail_s;
        numbers.machine(kind).unwrap_or_else(|error| panic!("{error}"))
    };
    let outcome = started(machine(0.0613)).run_on_tape(&[0.1]).map(|_| ()).expect_err("within a step").to_string();
    assert!(outcome.contains("a slew or failure that begins or ends within an aerodynamic step"), "{outcome}");
    assert!(outcome.contains("or move the event at 0.0613 s to an end of an aerodynamic step"), "{outcome}");
    started(machine(0.064)).run_on_tape(&[0.1]).unwrap_or_else(|error| panic!("{error}"));
}

/// GR-105: a lock closes at the end of an aerodynamic step, by a row of its input: the rates jump before the trial march.
#[test]
fn locks_close_before_a_trial_march() {
    let times_s = [0.0613, 0.1213];
    for staggered in [false, true] {
        let kind = Kind { latched: false, staggered, ..Kind::FULL };
        let machine = |numbers: InAir| numbers.machine(kind).unwrap_or_else(|error| panic!("{error}"));
        let mut plant = Plant::new(Arc::new(machine(InAir::USUAL)));
        let index = plant.inputs().layout().joints.place(1, offset_of!(JointInputs, release));
        let column = InputColumn { index, held: true, values: vec![1.0, 0.0, 0.0] };
        let inputs = InputRows::new(vec![-0.1, 0.048, 1.0], vec![column]).unwrap_or_else(|error| panic!("{error}"));
        inputs.set(&mut plant, 0.0);
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let tape = plant.run_on_tape_with(&inputs, &times_s).unwrap_or_else(|error| panic!("{error}"));
        let layout = *plant.outputs().layout();
        let outputs = [layout.gauges.place(0, 0), layout.tips.place(0, 0) + 2, layout.joints.place(1, 0)];
        let results: Vec<RunResult> =
            (0..2).flat_map(|time| outputs.map(|index| RunResult::Output { index, time })).collect();
        let places = [0, 2, 5, 7, 9, 11].map(|place| AIR_PLACES[place]);
        let beside = |place: AirPlace, shift: f64| {
            let mut numbers = InAir::USUAL;
            *(place.1)(&mut numbers) += shift;
            numbers
        };
        let size = |place: AirPlace| *(place.1)(&mut { InAir::USUAL });
        let parameter = |place: &AirPlace| {
            let plant = |shift: f64| plant_of(beside(*place, shift).machine(kind));
            Parameter::new(place.0, 0.0, 1e-3 * size(*place), plant).unwrap_or_else(|error| panic!("{error}"))
        };
        let parameters = places.iter().map(parameter).collect();
        let mut gradient = Gradient::new(&mut plant, &tape, parameters).unwrap_or_else(|error| panic!("{error}"));
        let forward = gradient.forward(&results).unwrap_or_else(|error| panic!("{error}"));
        let adjoint: Vec<Vec<f64>> =
            results.iter().map(|result| gradient.adjoint(*result).unwrap_or_else(|error| panic!("{error}"))).collect();
        let own = gradient.values(&results).unwrap_or_else(|error| panic!("{error}"));
        let run = |numbers: InAir| retraced_at(&tape, machine(numbers), &inputs, (&times_s, &results));
        same_values(&own, &run(InAir::USUAL));
        let mut known = vec![vec![0.0; places.len()]; results.len()];
        for (column, place) in places.iter().enumerate() {
            let step = 1e-3 * size(*place);
            for (steps, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
                for (row, value) in known.iter_mut().zip(run(beside(*place, steps * step))) {
                    row[column] += weight / (12.0 * step) * value;
                }
            }
        }
        let places: Vec<(&str, f64)> = places.iter().map(|place| (place.0, size(*place))).collect();
        let [both, differences] = disagreements((&results, &own), &places, [&forward, &adjoint, &known]);
        println!("GR-105 lock {staggered}: {both:.1e} {differences:.1e}");
        assert!(both < 1e-10 && differences < 1e-6, "{staggered}: {both:.1e} {differences:.1e}");
    }
}
