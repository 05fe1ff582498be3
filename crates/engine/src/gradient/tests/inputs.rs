//! Gradients by values of inputs over time.

use super::*;
use crate::load::{RootMotion, Wrench};
use crate::signal::JointInputs;
use std::mem::offset_of;

/// Rows of the fold's command, which follows ramps, of a torque on the fold with a jump at 0.1 s, of a load's height and of the root's
/// angular velocity about y, all over the time of the run.
fn rows(machine: &Machine) -> InputRows {
    let plant = Plant::new(Arc::new(machine.clone()));
    let layout = *plant.inputs().layout();
    let column = |index: usize, values: [f64; 7]| InputColumn { index, held: false, values: values.to_vec() };
    let columns = vec![
        column(layout.joints.place(1, offset_of!(JointInputs, command_rad)), [0.2, 0.3, 0.25, 0.25, 0.1, 0.0, -0.1]),
        column(layout.joints.place(1, offset_of!(JointInputs, torque_n_m)), [0.0, 0.02, 0.05, -0.03, 0.01, 0.0, 0.03]),
        column(layout.stations.place(0, offset_of!(Wrench, force_n)) + 2, [0.3, 0.1, 0.5, 0.4, 0.2, 0.3, 0.3]),
        column(
            layout.root.place(0, offset_of!(RootMotion, angular_velocity_rad_s)) + 1,
            [0.0, 0.1, 0.3, 0.3, 0.6, 0.2, 0.4],
        ),
    ];
    InputRows::new(vec![-0.1, 0.04, 0.1, 0.1, 0.17, 0.26, 0.6], columns).unwrap_or_else(|error| panic!("{error}"))
}

/// One value of a column changed.
pub(super) fn changed(rows: &InputRows, (column, row): (usize, usize), shift: f64) -> InputRows {
    let mut columns = rows.columns().to_vec();
    columns[column].values[row] += shift;
    InputRows::new(rows.times_s().to_vec(), columns).unwrap_or_else(|error| panic!("{error}"))
}

/// GR-16: by each value of four inputs over time, a jump among them, and by numbers of the machine, through a latch and onto a stop, of
/// outputs between rows and at a row and of the latch time: both ways, and differences of runs with the same steps and changed rows.
#[test]
fn values_of_inputs_over_time_have_slopes() {
    for latched in [true, false] {
        let numbers = [PLACES[0], PLACES[2], PLACES[7], PLACES[14]];
        let machine = |numbers: Numbers| numbers.machine(latched);
        let own = machine(Numbers::USUAL).unwrap_or_else(|error| panic!("{error}"));
        let inputs = rows(&own);
        let mut plant = Plant::new(Arc::new(own.clone()));
        inputs.set(&mut plant, 0.0);
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let tape = plant.run_on_tape_with(&inputs, &TIMES_S).unwrap_or_else(|error| panic!("{error}"));
        // once more from the start: nothing of the inputs is left over
        inputs.set(&mut plant, 0.0);
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let again = plant.run_on_tape_with(&inputs, &TIMES_S).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(again.steps.last().map(|step| &step.end.q), tape.steps.last().map(|step| &step.end.q));
        let crossings = tape.steps.iter().filter(|step| matches!(step.ending, Ending::Crossing(_))).count();
        let given = tape.steps.iter().filter(|step| step.ending == Ending::Given).count();
        assert!(crossings > 0, "no event");
        assert_eq!(given, 4, "rows at 0.04, 0.1, 0.17 and 0.26 s");
        let layout = *plant.outputs().layout();
        let output = |index: usize, time: usize| RunResult::Output { index, time };
        let mut results = vec![
            output(layout.gauges.place(0, 0), 0),
            output(layout.tips.place(0, 0) + 2, 0),
            output(layout.root.place(0, 0) + 2, 0),
            output(layout.energy.place(0, 0), 1),
            output(layout.joints.place(1, 0), 1),
        ];
        if latched {
            results.push(RunResult::LatchTime { joint: 1 });
        }
        let (step, all) = (1e-3, 0..7);
        let mut parameters: Vec<Parameter> = (0..4)
            .map(|column| {
                let plant = || Ok::<_, String>(Plant::new(Arc::new(own.clone())));
                Parameter::of_rows("rows", (column, all.clone().collect()), step, plant)
                    .unwrap_or_else(|error| panic!("{error}"))
            })
            .collect();
        for place in numbers {
            let parameter =
                Parameter::new(place.0, 0.0, 1e-3 * size(place), |shift| plant_of(machine(beside(place, shift))));
            parameters.push(parameter.unwrap_or_else(|error| panic!("{error}")));
        }
        let mut gradient = Gradient::new(&mut plant, &tape, parameters).unwrap_or_else(|error| panic!("{error}"));
        let forward = gradient.forward(&results).unwrap_or_else(|error| panic!("{error}"));
        let adjoint: Vec<Vec<f64>> =
            results.iter().map(|result| gradient.adjoint(*result).unwrap_or_else(|error| panic!("{error}"))).collect();

        let weights = [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)];
        let difference = |step: f64, run: &dyn Fn(f64) -> Vec<f64>| {
            let mut slopes = vec![0.0; results.len()];
            for (steps, weight) in weights {
                add(&mut slopes, weight / (12.0 * step), &run(steps * step));
            }
            slopes
        };
        let mut known = Vec::new();
        for place in (0..4).flat_map(|column| all.clone().map(move |row| (column, row))) {
            known.push(difference(step, &|shift| {
                retraced_with(&tape, own.clone(), &changed(&inputs, place, shift), &results)
            }));
        }
        for place in numbers {
            known.push(difference(1e-3 * size(place), &|shift| {
                let there = machine(beside(place, shift)).unwrap_or_else(|error| panic!("{error}"));
                retraced(&tape, there, &results).iter().map(|value| value * size(place)).collect()
            }));
        }
        let largest: Vec<f64> = (0..results.len())
            .map(|result| known.iter().fold(0.0f64, |scale, slopes| scale.max(slopes[result].abs())))
            .collect();
        for (column, slopes) in known.iter().take(28).enumerate() {
            let share = slopes.iter().zip(&largest).fold(0.0f64, |most, (slope, scale)| most.max(slope.abs() / scale));
            assert!(share > 1e-4, "row {column} has no effect: {share:.1e}");
        }
        let sizes = || std::iter::repeat_n(1.0, 28).chain(numbers.into_iter().map(size));
        for (result, (forward, adjoint)) in forward.iter().zip(&adjoint).enumerate() {
            let scale = largest[result];
            for (column, size) in sizes().enumerate() {
                let [forward, adjoint] = [forward[column], adjoint[column]].map(|slope| slope * size / scale);
                let known = known[column][result] / scale;
                // as for GR-01; differences have noise of both signs, 1.5e-6, from crossings that are located to 1e-10 s
                assert!((forward - adjoint).abs() < 1e-10, "{latched} {result} {column}: {forward} and {adjoint}");
                assert!((forward - known).abs() < 3e-6, "{latched} {result} {column}: {forward} and {known}");
            }
        }
    }
}
