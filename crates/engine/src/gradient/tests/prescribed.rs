//! Gradients of machines with prescribed motions: by the numbers of their laws, and through events beside them.

use super::*;
use crate::system::JointOutputs;
use std::mem::offset_of;

/// Strains, motions, reactions and the torque that holds the prescribed joint, at both times.
fn results(plant: &Plant, (joint, latch): (usize, Option<usize>)) -> Vec<RunResult> {
    let layout = *plant.outputs().layout();
    let indices = [
        layout.gauges.place(0, 0),
        layout.tips.place(0, 0) + 2,
        layout.energy.place(0, 0),
        layout.tips.place(0, 0),
        layout.joints.place(joint, offset_of!(JointOutputs, rate_rad_s)),
        layout.joints.place(joint, offset_of!(JointOutputs, holding_torque_n_m)),
        layout.root.place(0, 0) + 2,
    ];
    let outputs = (0..2).flat_map(|time| indices.map(|index| RunResult::Output { index, time }));
    outputs.chain(latch.map(|joint| RunResult::LatchTime { joint })).collect()
}

fn prescribed(mut machine: Machine, body: usize, motion: Motion) -> Machine {
    if let JointKind::Revolute(hinge) = &mut machine.bodies[body].joint.kind {
        hinge.motion = JointMotion::Prescribed(motion);
    }
    machine.solver.tolerance = 1e-12;
    machine
}

fn agree(compared: &Compared, words: &str) {
    let Compared { forward_and_adjoint, differences, .. } = compared;
    assert!(*forward_and_adjoint < 1e-10, "{words}: {forward_and_adjoint:.1e}");
    assert!(*differences < 1e-6, "{words}: {differences:.1e}");
}

/// GR-38: the wing of GR-01 whose root joint follows a table, as a clamped spline, an onward one, and linear without rates, with an elastic
/// or a rigid latch between two of its knots: by two of its angles and the numbers of the wing.
#[test]
fn gradients_by_the_knots_of_a_prescribed_motion() {
    // knots at which the latch closes well within a step
    type Case = (fn(Vec<(f64, f64)>) -> Motion, bool, f64);
    let kinds: [Case; 3] =
        [(Motion::Table, true, 0.07), (Motion::Onward, false, 0.07), (Motion::QuasiStatic, true, 0.0715)];
    for (motion, rigid, second_s) in kinds {
        let machine = |numbers: Numbers| {
            let knots =
                vec![(0.0, 0.0), (second_s, numbers.stop), (0.15, -0.1), (0.29, 0.5 * numbers.load), (0.36, 0.1)];
            let machine = numbers.machine(true)?;
            let machine = if rigid { rigid::hardened(machine) } else { machine };
            Ok(prescribed(machine, 0, motion(knots)))
        };
        let own = machine(Numbers::USUAL).unwrap_or_else(|error| panic!("{error}"));
        let tape = started(own).run_on_tape(&TIMES_S).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(tape.knots_s, [0.0, second_s, 0.15, 0.29, 0.36]);
        let places: Vec<Place> = PLACES.into_iter().filter(|place| !rigid || place.0 != "latch_stiffness").collect();
        let compared = compare_results(machine, &InputRows::default(), &places, |plant| results(plant, (0, Some(1))));
        assert_eq!(compared.events, 1);
        agree(&compared, "table");
    }
}

/// GR-39: a fold that follows a polynomial, whose four coefficients are numbers; it also turns the beams' inertia forces.
#[test]
fn gradients_by_the_coefficients_of_a_prescribed_motion() {
    let machine = |numbers: Numbers| {
        let Numbers { start_angle, start_rate, torque, command, .. } = numbers;
        Ok(prescribed(
            numbers.machine(true)?,
            1,
            Motion::Polynomial(vec![start_angle, start_rate, 40.0 * torque, -60.0 * command]),
        ))
    };
    let unused = ["stiffness", "damping", "latch_stiffness", "latch_angle", "stop"];
    let places: Vec<Place> = PLACES.into_iter().filter(|place| !unused.contains(&place.0)).collect();
    let compared = compare_results(machine, &InputRows::default(), &places, |plant| results(plant, (1, None)));
    agree(&compared, "polynomial");
}

/// GR-40: a mass on a spring upon a support that moves by `c0 + c1 t + c2 t² + c3 t³`: its displacement relative to the support is
/// `y = −(2 c2 (1 − cos ωt) + 6 c3 (t − sin(ωt)/ω))/ω²`, until a rigid latch joins both. Time of the latch, displacement before, position and rate
/// after it, by coefficients, stiffness, mass and place of the latch.
#[test]
fn a_mass_on_a_moving_support_has_its_closed_form() {
    const USUAL: [f64; 6] = [0.1, 0.2, 1.5, -0.7, 30.0, 0.8];
    const EDGE_M: f64 = -0.08;
    const TIMES_S: [f64; 2] = [0.2, 0.9];
    let plant = |numbers: [f64; 6], edge_m: f64| {
        let [c0, c1, c2, c3, stiffness_n_m, mass_kg] = numbers;
        let support = Joint::prismatic("track", [0.0, 0.0, 1.0]).prescribed(Motion::Polynomial(vec![c0, c1, c2, c3]));
        let spring = Spring { stiffness_n_m_rad: stiffness_n_m, ..Spring::default() };
        let slide = Joint::prismatic("slide", [0.0, 0.0, 1.0])
            .on("support")
            .spring(spring)
            .latch(Latch::rigid().position_m(edge_m - 0.01).capture_m(0.01));
        let body = |name: &str, mass_kg: f64| {
            Body::rigid(name).inertia(mass_kg, [0.0; 3], nalgebra::Matrix3::identity() * 1e-3)
        };
        let machine = Machine::builder("Shaker")
            .gravity_m_s2([0.0; 3])
            .body(body("support", 1.0), support)
            .body(body("mass", mass_kg), slide)
            .solver(Solver { tolerance: 1e-11, ..Solver::default() })
            .build()
            .map_err(|refused| refused.to_string())?;
        Ok::<_, String>(Plant::new(Arc::new(machine)))
    };
    let known = |numbers: [f64; 6], edge_m: f64| -> [f64; 4] {
        let [c0, c1, c2, c3, stiffness_n_m, mass_kg] = numbers;
        let square = stiffness_n_m / mass_kg;
        let omega = square.sqrt();
        let displacement =
            |t: f64| -(2.0 * c2 * (1.0 - (omega * t).cos()) + 6.0 * c3 * (t - (omega * t).sin() / omega)) / square;
        let (mut low, mut high) = (0.0, 0.5);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if displacement(middle) > edge_m { low = middle } else { high = middle }
        }
        let t = TIMES_S[1];
        [low, displacement(TIMES_S[0]), c0 + t * (c1 + t * (c2 + t * c3)) + edge_m, c1 + t * (2.0 * c2 + t * 3.0 * c3)]
    };
    let mut own = plant(USUAL, EDGE_M).unwrap_or_else(|error| panic!("{error}"));
    own.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    let tape = own.run_on_tape(&TIMES_S).unwrap_or_else(|error| panic!("{error}"));
    let layout = *own.outputs().layout();
    let results = [
        RunResult::LatchTime { joint: 1 },
        RunResult::Output { index: layout.joints.place(1, offset_of!(JointOutputs, angle_rad)), time: 0 },
        RunResult::Output { index: layout.tips.place(0, 0) + 2, time: 1 },
        RunResult::Output { index: layout.joints.place(0, offset_of!(JointOutputs, rate_rad_s)), time: 1 },
    ];
    let beside = |place: usize, shift: f64| {
        let (mut numbers, mut edge_m) = (USUAL, EDGE_M);
        *numbers.get_mut(place).unwrap_or(&mut edge_m) += shift;
        (numbers, edge_m)
    };
    let size = |place: usize| USUAL.get(place).map_or(EDGE_M, |number| *number).abs();
    let parameter = |place: usize| {
        let plant = |shift: f64| {
            let (numbers, edge_m) = beside(place, shift);
            plant(numbers, edge_m)
        };
        Parameter::new("number", 0.0, 1e-3 * size(place), plant).unwrap_or_else(|error| panic!("{error}"))
    };
    let parameters = (0..=USUAL.len()).map(parameter).collect();
    let mut gradient = Gradient::new(&mut own, &tape, parameters).unwrap_or_else(|error| panic!("{error}"));
    let values = gradient.values(&results).unwrap_or_else(|error| panic!("{error}"));
    let forward = gradient.forward(&results).unwrap_or_else(|error| panic!("{error}"));
    let exact = known(USUAL, EDGE_M);
    for (row, result) in results.iter().enumerate() {
        assert!((values[row] - exact[row]).abs() < 1e-8 * exact[row].abs(), "{row}: {} {}", values[row], exact[row]);
        let adjoint = gradient.adjoint(*result).unwrap_or_else(|error| panic!("{error}"));
        let slope = |place: usize| {
            let step = 1e-3 * size(place);
            let value = |shift: f64| {
                let (numbers, edge_m) = beside(place, shift);
                known(numbers, edge_m)[row] * size(place)
            };
            let [far, near] = [2.0, 1.0].map(|steps| value(steps * step) - value(-steps * step));
            (8.0 * near - far) / (12.0 * step)
        };
        let slopes: Vec<f64> = (0..=USUAL.len()).map(slope).collect();
        let scale = slopes.iter().fold(0.0f64, |most, slope| most.max(slope.abs()));
        for (place, slope) in slopes.iter().enumerate() {
            let [forward, adjoint] = [forward[row][place], adjoint[place]].map(|slope| slope * size(place));
            assert!((forward - adjoint).abs() < 1e-10 * scale, "{row} {place}: {forward} and {adjoint}");
            // the run's own error
            assert!((forward - slope).abs() < 1e-7 * scale, "{row} {place}: {forward} and {slope}");
        }
    }
}

/// Times of knots are not numbers to differentiate by, and a latch that closes at a knot has no derivative: errors by name.
#[test]
fn knots_that_move_are_refused() {
    let machine = |time_s: f64| {
        let motion = Motion::Table(vec![(0.0, 0.0), (time_s, 0.2), (0.3, 0.0)]);
        prescribed(Numbers::USUAL.machine(true).unwrap_or_else(|error| panic!("{error}")), 0, motion)
    };
    let mut plant = started(machine(0.07));
    let tape = plant.run_on_tape(&[0.02]).unwrap_or_else(|error| panic!("{error}"));
    let parameter = Parameter::new("time", 0.07, 1e-4, |time_s| plant_of(Ok(machine(time_s))));
    let outcome =
        Gradient::new(&mut plant, &tape, vec![parameter.unwrap_or_else(|error| panic!("{error}"))]).map(|_| ());
    assert!(matches!(outcome, Err(GradientError::Structure { what: "the times of a prescribed motion", .. })));
}
