//! Means over the run and impulses of rigid latches.

use super::rigid::hardened;
use super::*;
use crate::system::JointOutputs;
use std::mem::offset_of;

/// Means and mean squares of a strain, a height, an energy, a rate and an angle up to both times, and the latch time.
fn means(plant: &Plant, latch: Option<usize>) -> Vec<RunResult> {
    let layout = *plant.outputs().layout();
    let indices = [
        layout.gauges.place(0, 0),
        layout.tips.place(0, 0) + 2,
        layout.energy.place(0, 0),
        layout.joints.place(1, offset_of!(JointOutputs, rate_rad_s)),
        layout.joints.place(1, offset_of!(JointOutputs, angle_rad)),
    ];
    let mean = |time: usize, square: bool| indices.map(|index| RunResult::Mean { index, time, square });
    let means = [(0, false), (1, false), (1, true)].into_iter().flat_map(|(time, square)| mean(time, square));
    means.chain(latch.map(|joint| RunResult::LatchTime { joint })).collect()
}

fn agree(compared: &Compared, allowed: f64) {
    let Compared { forward_and_adjoint, differences, events } = compared;
    assert!(*events > 0, "no event");
    assert!(*forward_and_adjoint < 1e-9, "{forward_and_adjoint:.1e}");
    assert!(*differences < allowed, "{differences:.1e}");
}

/// GR-46: means and mean squares of GR-01's and GR-02's wing, through the latch and onto the stop, by five numbers.
#[test]
fn means_pass_through_a_latch_and_a_stop() {
    let places = [PLACES[0], PLACES[5], PLACES[7], PLACES[9], PLACES[13]];
    let machine = |numbers: Numbers| numbers.machine(true);
    agree(&compare_results(machine, &InputRows::default(), &places, |plant| means(plant, Some(1))), 1e-6);
    let places = [PLACES[1], PLACES[6], PLACES[8], PLACES[11], PLACES[13]];
    let machine = |numbers: Numbers| numbers.machine(false);
    agree(&compare_results(machine, &InputRows::default(), &places, |plant| means(plant, None)), 1e-6);
}

/// GR-47: means of the wing with a rigid latch, and the impulse of its latch, by six numbers.
#[test]
fn means_and_impulses_pass_through_a_rigid_latch() {
    let places = [PLACES[0], PLACES[5], PLACES[7], PLACES[9], PLACES[11], PLACES[12]];
    let machine = |numbers: Numbers| numbers.machine(true).map(hardened);
    let compared = compare_results(machine, &InputRows::default(), &places, |plant| {
        let mut results = means(plant, Some(1));
        results.push(RunResult::Impulse { joint: 1 });
        results
    });
    agree(&compared, 1e-6);
}

/// GR-48: mean angle and mean square of the angle of an arm of 1 kg·m² under a constant torque `T` towards `−θ` from rest, `−T t²/6` and `T² t⁴/20`, by the
/// torque: both ways, to 1e-7 of a run whose own error is 1e-10.
#[test]
fn means_of_an_arm_under_a_constant_torque() {
    let machine = |torque_n_m: f64| {
        let body = Body::rigid("arm").inertia(1.0, [0.0; 3], nalgebra::Matrix3::identity());
        let motor = Motor { constant_torque_n_m: torque_n_m, ..Motor::default() };
        Machine::builder("Arm")
            .gravity_m_s2([0.0; 3])
            .body(body, Joint::revolute("hinge", [0.0, 0.0, 1.0]).motor(motor))
            .solver(Solver { tolerance: 1e-10, ..Solver::default() })
            .build()
            .map_err(|refused| refused.to_string())
    };
    let (torque, time_s) = (0.7, 1.3);
    let mut plant = started(machine(torque).unwrap_or_else(|error| panic!("{error}")));
    let tape = plant.run_on_tape(&[time_s]).unwrap_or_else(|error| panic!("{error}"));
    let index = plant.outputs().layout().joints.place(0, offset_of!(JointOutputs, angle_rad));
    let results = [false, true].map(|square| RunResult::Mean { index, time: 0, square });
    let parameter = Parameter::new("torque", torque, 1e-3, |torque| plant_of(machine(torque)));
    let parameter = parameter.unwrap_or_else(|error| panic!("{error}"));
    let mut gradient = Gradient::new(&mut plant, &tape, vec![parameter]).unwrap_or_else(|error| panic!("{error}"));
    let values = gradient.values(&results).unwrap_or_else(|error| panic!("{error}"));
    let forward = gradient.forward(&results).unwrap_or_else(|error| panic!("{error}"));
    let known = [
        (-torque * time_s.powi(2) / 6.0, -time_s.powi(2) / 6.0),
        (torque.powi(2) * time_s.powi(4) / 20.0, torque * time_s.powi(4) / 10.0),
    ];
    for (row, (value, slope)) in known.into_iter().enumerate() {
        let adjoint = gradient.adjoint(results[row]).unwrap_or_else(|error| panic!("{error}"))[0];
        for (found, known) in [(values[row], value), (forward[row][0], slope), (adjoint, slope)] {
            assert!((found - known).abs() < 1e-7 * known.abs(), "{row}: {found} and {known}");
        }
    }
}

/// Impulses of elastic latches and of joints without a closing, and means up to the start, are not there.
#[test]
fn results_that_a_run_does_not_have() {
    let mut plant = started(Numbers::USUAL.machine(true).unwrap_or_else(|error| panic!("{error}")));
    let tape = plant.run_on_tape(&[0.0, 0.4]).unwrap_or_else(|error| panic!("{error}"));
    let mut gradient = Gradient::new(&mut plant, &tape, Vec::new()).unwrap_or_else(|error| panic!("{error}"));
    for result in [
        RunResult::Impulse { joint: 0 },
        RunResult::Impulse { joint: 1 },
        RunResult::Mean { index: 0, time: 0, square: false },
    ] {
        let error = gradient.values(&[result]).err();
        assert!(matches!(error, Some(GradientError::Absent { .. })), "{result:?}: {error:?}");
    }
}
