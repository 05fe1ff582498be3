//! Gradients by rows of inputs over time, of machines with aerodynamics.

use super::air::{AIR_PLACES, InAir, Kind, Root};
use super::inputs::changed;
use super::*;
use crate::load::{RootMotion, Wrench};
use crate::signal::{FlapInputs, JointInputs};
use std::mem::offset_of;

/// Rows at ends of aerodynamic steps of 8 ms.
const TIMES: [f64; 7] = [-0.1, 0.024, 0.048, 0.048, 0.08, 0.12, 0.6];
const RESULTS_S: [f64; 2] = [0.1213, 0.159];

/// Rows of a torque on the fold with a jump, of a load's height, of the wind across and along, of the root's angular velocity, and, if there is
/// one, of the command of a control surface.
fn rows(machine: &Machine, fold: usize) -> InputRows {
    let plant = Plant::new(Arc::new(machine.clone()));
    let layout = *plant.inputs().layout();
    let column = |index: usize, values: [f64; 7]| InputColumn { index, held: false, values: values.to_vec() };
    let mut columns = vec![
        column(
            layout.joints.place(fold, offset_of!(JointInputs, torque_n_m)),
            [0.0, 0.02, 0.05, -0.03, 0.01, 0.0, 0.03],
        ),
        column(layout.stations.place(0, offset_of!(Wrench, force_n)) + 2, [0.3, 0.1, 0.5, 0.4, 0.2, 0.3, 0.3]),
        column(layout.wind_m_s.place(0, 0) + 1, [-14.0, -13.0, -15.0, -14.0, -12.5, -14.0, -14.2]),
        column(layout.wind_m_s.place(0, 0) + 2, [0.3, 0.5, 1.5, -0.4, 0.6, 0.2, 0.1]),
        column(
            layout.root.place(0, offset_of!(RootMotion, angular_velocity_rad_s)) + 1,
            [0.0, 0.1, 0.3, 0.3, 0.6, 0.2, 0.4],
        ),
    ];
    if fold == 0 {
        // a root whose rotation varies is an error
        columns[4].values = vec![0.3; 7];
    }
    if machine.air.as_ref().is_some_and(|air| !air.flaps.is_empty()) {
        columns.push(column(
            layout.flaps.place(0, offset_of!(FlapInputs, command_rad)),
            [0.1, 0.12, 0.3, -0.1, -0.2, 0.0, 0.1],
        ));
    }
    InputRows::new(TIMES.to_vec(), columns).unwrap_or_else(|error| panic!("{error}"))
}

/// GR-99: by each value of five or six inputs over time, wind, a control surface and a jump among them, and by numbers of air and structure,
/// through a latch, of outputs within aerodynamic steps and of the latch time: both ways, and differences of runs with the same steps and changed
/// rows.
#[test]
fn rows_of_inputs_in_air_have_slopes() {
    let plain = Kind { unsteady: true, ..Kind::PLAIN };
    for (number, kind) in [
        Kind { latched: true, ..Kind::FULL },
        Kind { latched: false, gusty: true, ..Kind::FULL },
        Kind { stalls: true, ..plain },
        Kind { several: true, ..plain },
        Kind { root: Root::Ball, ..plain },
        Kind { staggered: true, ..Kind::FULL },
    ]
    .into_iter()
    .enumerate()
    {
        let fold = usize::from(kind.root == Root::Hinge);
        // all rows of the first, those of the jump and of the ramp behind it of the others
        let chosen: Vec<usize> = if number == 0 { (0..TIMES.len()).collect() } else { vec![2, 4] };
        let numbers = [0, 2, 5, 9].map(|place| AIR_PLACES[place]);
        let machine = |numbers: InAir| numbers.machine(kind).unwrap_or_else(|error| panic!("{error}"));
        let own = machine(InAir::USUAL);
        let inputs = rows(&own, fold);
        let mut plant = Plant::new(Arc::new(own.clone()));
        inputs.set(&mut plant, 0.0);
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let tape = plant.run_on_tape_with(&inputs, &RESULTS_S).unwrap_or_else(|error| panic!("{error}"));
        let layout = *plant.outputs().layout();
        let output = |index: usize, time: usize| RunResult::Output { index, time };
        let mut results = vec![
            output(layout.gauges.place(0, 0), 0),
            output(layout.tips.place(0, 0) + 2, 0),
            output(layout.air_total.place(0, 0) + 2, 0),
            output(layout.energy.place(0, 0), 1),
            output(layout.tips.place(0, 0), 1),
        ];
        results.extend(layout.accounts().map(|index| output(index, 1)));
        let latches = tape.latch_time_s(fold).is_some();
        assert_eq!(latches, kind.latched);
        results.extend(latches.then_some(RunResult::LatchTime { joint: fold }));
        let step = 1e-4;
        let mut parameters: Vec<Parameter> = (0..inputs.columns().len())
            .map(|column| {
                let plant = || Ok::<_, String>(Plant::new(Arc::new(own.clone())));
                Parameter::of_rows("rows", (column, chosen.clone()), step, plant)
                    .unwrap_or_else(|error| panic!("{error}"))
            })
            .collect();
        for place in numbers {
            let size = *(place.1)(&mut { InAir::USUAL });
            let beside = |shift: f64| {
                let mut numbers = InAir::USUAL;
                *(place.1)(&mut numbers) += shift;
                plant_of(numbers.machine(kind))
            };
            parameters
                .push(Parameter::new(place.0, 0.0, 1e-3 * size, beside).unwrap_or_else(|error| panic!("{error}")));
        }
        let mut gradient = Gradient::new(&mut plant, &tape, parameters).unwrap_or_else(|error| panic!("{error}"));
        let forward = gradient.forward(&results).unwrap_or_else(|error| panic!("{error}"));
        let adjoint: Vec<Vec<f64>> =
            results.iter().map(|result| gradient.adjoint(*result).unwrap_or_else(|error| panic!("{error}"))).collect();
        let values = gradient.values(&results).unwrap_or_else(|error| panic!("{error}"));
        same_values(&values, &along(&tape, own.clone(), &inputs, &results));
        let mut places: Vec<(String, f64)> = Vec::new();
        let mut known = vec![Vec::new(); results.len()];
        let mut difference = |name: String, size: f64, step: f64, run: &dyn Fn(f64) -> Vec<f64>| {
            places.push((name, size));
            let mut slopes = vec![0.0; results.len()];
            for (steps, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
                add(&mut slopes, weight / (12.0 * step), &run(steps * step));
            }
            known.iter_mut().zip(slopes).for_each(|(row, slope)| row.push(slope));
        };
        for column in 0..inputs.columns().len() {
            for &row in &chosen {
                difference(format!("row {row} of {column}"), 1.0, step, &|shift| {
                    along(&tape, own.clone(), &changed(&inputs, (column, row), shift), &results)
                });
            }
        }
        for place in numbers {
            let size = *(place.1)(&mut { InAir::USUAL });
            let share = if kind.stalls || kind.several { 1e-5 } else { 1e-3 };
            difference(place.0.to_owned(), size, share * size, &|shift| {
                let mut numbers = InAir::USUAL;
                *(place.1)(&mut numbers) += shift;
                along(&tape, machine(numbers), &inputs, &results)
            });
        }
        let places: Vec<(&str, f64)> = places.iter().map(|(name, size)| (name.as_str(), *size)).collect();
        let [both, differences] = disagreements((&results, &values), &places, [&forward, &adjoint, &known]);
        println!("GR-99 {number}: {both:.1e} {differences:.1e}");
        // 2.8e-10 found
        assert!(both < 1e-9, "{both:.1e}");
        assert!(differences < 1e-6, "{differences:.1e}");
    }
}

/// A wing on a ball joint, on a root whose rotation varies, is an error by name.
#[test]
fn a_root_whose_rotation_varies_is_refused_with_a_ball_joint() {
    let kind = Kind { root: Root::Ball, ..Kind::PLAIN };
    let machine = InAir::USUAL.machine(kind).unwrap_or_else(|error| panic!("{error}"));
    let mut inputs = rows(&machine, 0);
    let run = |inputs: &InputRows| {
        let mut plant = Plant::new(Arc::new(machine.clone()));
        inputs.set(&mut plant, 0.0);
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        plant.run_on_tape_with(inputs, &[0.016]).map(|_| ())
    };
    assert!(run(&inputs).is_ok(), "a constant rotation");
    inputs = changed(&inputs, (4, 1), 0.1);
    let refused = run(&inputs).expect_err("a rotation that varies").to_string();
    assert!(refused.contains("a root whose rotation varies"), "{refused}");
}

/// Results of the run of another machine, or with other rows, along the steps of a tape.
fn along(tape: &Tape, machine: Machine, inputs: &InputRows, results: &[RunResult]) -> Vec<f64> {
    retraced_at(tape, machine, inputs, (&RESULTS_S, results))
}
