//! Energy accounts: work of the inputs and energy dissipated.

use super::rigid::hardened;
use super::*;
use crate::load::Wrench;
use crate::machine::failure::FrictionBrake;
use crate::signal::JointInputs;
use std::mem::offset_of;

/// Both accounts at both times, and the latch time.
fn accounts(plant: &Plant, latch: Option<usize>) -> Vec<RunResult> {
    let indices = plant.outputs().layout().accounts();
    let outputs = (0..2).flat_map(|time| indices.map(|index| RunResult::Output { index, time }));
    outputs.chain(latch.map(|joint| RunResult::LatchTime { joint })).collect()
}

fn agree(compared: &Compared, allowed: f64, words: &str) {
    let Compared { forward_and_adjoint, differences, events } = compared;
    assert!(*events > 0, "{words}: no event");
    assert!(*forward_and_adjoint < 1e-9, "{words}: {forward_and_adjoint:.1e}");
    assert!(*differences < allowed, "{words}: {differences:.1e}");
}

/// GR-52: accounts of GR-01's and GR-02's wing, through the latch and onto the stop, by six numbers.
#[test]
#[ignore = "long; `make long` runs it"]
fn accounts_pass_through_a_latch_and_a_stop() {
    let places = [PLACES[1], PLACES[4], PLACES[5], PLACES[7], PLACES[9], PLACES[14]];
    let machine = |numbers: Numbers| numbers.machine(true);
    let compared = compare_results(machine, &InputRows::default(), &places, |plant| accounts(plant, Some(1)));
    agree(&compared, 1e-6, "latch");
    let places = [PLACES[1], PLACES[2], PLACES[6], PLACES[8], PLACES[11], PLACES[13]];
    let machine = |numbers: Numbers| numbers.machine(false);
    let compared = compare_results(machine, &InputRows::default(), &places, |plant| accounts(plant, None));
    // found 1.1e-6: the damper of the stop starts with a jump of the power, and crossings are located to 1e-10 s, as in GR-16
    agree(&compared, 3e-6, "stop");
}

/// GR-53: accounts of the wing with a rigid latch, whose impulse dissipates energy, by five numbers.
#[test]
fn accounts_pass_through_a_rigid_latch() {
    let places = [PLACES[0], PLACES[5], PLACES[7], PLACES[9], PLACES[12]];
    let machine = |numbers: Numbers| numbers.machine(true).map(hardened);
    let compared = compare_results(machine, &InputRows::default(), &places, |plant| accounts(plant, Some(1)));
    agree(&compared, 1e-6, "rigid latch");
    let mut plant = started(machine(Numbers::USUAL).unwrap_or_else(|error| panic!("{error}")));
    let tape = plant.run_on_tape(&[0.4]).unwrap_or_else(|error| panic!("{error}"));
    let jump = |pair: &[Step]| pair[1].start.dissipated - pair[0].end.dissipated;
    let taken_j: f64 = tape.steps.windows(2).map(jump).sum();
    assert!(taken_j > 1e-3, "{taken_j}: the latch takes energy");
}

/// GR-54: accounts with inputs over time (a command with ramps, a torque and a load that jump), by numbers of the machine.
#[test]
fn accounts_with_inputs_over_time() {
    let plant = Plant::new(Arc::new(Numbers::USUAL.machine(true).unwrap_or_else(|error| panic!("{error}"))));
    let layout = *plant.inputs().layout();
    let column = |index: usize, values: [f64; 5]| InputColumn { index, held: false, values: values.to_vec() };
    let columns = vec![
        column(layout.joints.place(1, offset_of!(JointInputs, command_rad)), [0.2, 0.3, 0.1, 0.1, 0.0]),
        column(layout.joints.place(1, offset_of!(JointInputs, torque_n_m)), [0.0, 0.02, 0.05, -0.03, 0.03]),
        column(layout.stations.place(0, offset_of!(Wrench, force_n)) + 2, [0.3, 0.1, 0.5, 0.2, 0.3]),
    ];
    let inputs = InputRows::new(vec![-0.1, 0.04, 0.1, 0.1, 0.6], columns).unwrap_or_else(|error| panic!("{error}"));
    let places = [PLACES[0], PLACES[1], PLACES[7], PLACES[9], PLACES[12]];
    let machine = |numbers: Numbers| numbers.machine(true);
    let compared = compare_results(machine, &inputs, &places, |plant| accounts(plant, Some(1)));
    agree(&compared, 1e-6, "inputs");
}

/// GR-55: an arm of 1 kg·m² with a damper `d` and an external torque `τ`, from the rate `ω₀`: with `x = e^{−dt}`, `ω = ω₀ x + τ(1 − x)/d`,
/// the work is `τ θ` and the dissipated energy `τ θ + (ω₀² − ω²)/2`; by `τ`, `d` and `ω₀`, both ways, to 1e-7 of a run with an error of
/// 1e-9.
#[test]
fn accounts_of_a_damped_arm() {
    let (time_s, torque, damping, rate) = (1.3, 0.7, 0.4, 0.9);
    let known = |[torque, damping, rate]: [f64; 3]| {
        let left = f64::exp(-damping * time_s);
        let final_rate = rate * left + torque * (1.0 - left) / damping;
        let angle = rate * (1.0 - left) / damping + torque / damping * (time_s - (1.0 - left) / damping);
        [torque * angle, torque * angle + 0.5 * (rate * rate - final_rate * final_rate)]
    };
    let plant = |[torque, damping, rate]: [f64; 3]| {
        let body = Body::rigid("arm").inertia(1.0, [0.0; 3], nalgebra::Matrix3::identity());
        let motor = Motor { damping_n_m_s_rad: damping, ..Motor::default() };
        let machine = Machine::builder("Arm")
            .gravity_m_s2([0.0; 3])
            .body(body, Joint::revolute("hinge", [0.0, 0.0, 1.0]).motor(motor).start_rate_rad_s(rate))
            .solver(Solver { tolerance: 1e-10, ..Solver::default() })
            .build();
        plant_of(machine.map_err(|refused| refused.to_string())).map(|mut plant| {
            plant.inputs_mut().joints_mut()[0].torque_n_m = torque;
            plant
        })
    };
    let numbers = [torque, damping, rate];
    let beside = |place: usize, shift: f64| {
        let mut numbers = numbers;
        numbers[place] += shift;
        numbers
    };
    let mut own = plant(numbers).unwrap_or_else(|error| panic!("{error}"));
    own.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    let tape = own.run_on_tape(&[time_s]).unwrap_or_else(|error| panic!("{error}"));
    let accounts = own.outputs().layout().accounts();
    let results = accounts.map(|index| RunResult::Output { index, time: 0 });
    let parameters = (0..3).map(|place| {
        Parameter::new("number", 0.0, 1e-3 * numbers[place], |shift| plant(beside(place, shift)))
            .unwrap_or_else(|error| panic!("{error}"))
    });
    let mut gradient = Gradient::new(&mut own, &tape, parameters.collect()).unwrap_or_else(|error| panic!("{error}"));
    let values = gradient.values(&results).unwrap_or_else(|error| panic!("{error}"));
    let forward = gradient.forward(&results).unwrap_or_else(|error| panic!("{error}"));
    for (row, result) in results.into_iter().enumerate() {
        let adjoint = gradient.adjoint(result).unwrap_or_else(|error| panic!("{error}"));
        let value = known(numbers)[row];
        assert!((values[row] - value).abs() < 1e-7 * value, "{row}: {} and {value}", values[row]);
        for place in 0..3 {
            let slope = (known(beside(place, 1e-4))[row] - known(beside(place, -1e-4))[row]) / 2e-4;
            for found in [forward[row][place], adjoint[place]] {
                assert!((found - slope).abs() < 1e-7, "{row} by {place}: {found} and {slope}");
            }
        }
        // along the length of the last step: the power there
        let index = accounts[row];
        let rate = gradient.rate(index, 0).unwrap_or_else(|error| panic!("{error}"));
        let left = f64::exp(-damping * time_s);
        let final_rate = numbers[2] * left + torque * (1.0 - left) / damping;
        let power = [torque * final_rate, damping * final_rate * final_rate][row];
        assert!((rate - power).abs() < 1e-6 * power, "{row}: {rate} and {power}");
    }
}

/// GR-94: an arm of `J` = 1.7 kg·m² whose angle `a + b t + c t²` is prescribed takes the work `J ((b + 2 c t)² − b²)/2`, and an arm on a brake
/// that slips from 0.1 s on, `J ω' = −T tanh(ω/s)`, dissipates `J (ω₀² − ω²)/2` with `sinh(ω/s) = sinh(ω₀/s) e^{−T (t − 0.1 s)/(J s)}`: by
/// `b` and `c`, and by `ω₀` and `T`, both ways, to 1e-7 of a run with an error of 1e-9.
#[test]
fn accounts_of_a_driven_and_of_a_braked_arm() {
    let (inertia, time_s) = (1.7, 0.7);
    let work = |[rate, half]: [f64; 2]| 0.5 * inertia * ((rate + 2.0 * half * time_s).powi(2) - rate * rate);
    let dissipated = |[rate, torque]: [f64; 2]| {
        let slip = 0.5;
        let left = f64::sinh(rate / slip) * f64::exp(-torque * (time_s - 0.1) / (inertia * slip));
        0.5 * inertia * (rate * rate - (slip * left.asinh()).powi(2))
    };
    let plant = |[rate, second]: [f64; 2], braked: bool| {
        let body = Body::rigid("arm").inertia(1.0, [0.0; 3], nalgebra::Matrix3::from_diagonal_element(inertia));
        let hinge = Joint::revolute("hinge", [0.0, 1.0, 0.0]).start_rate_rad_s(rate);
        let solver = Solver { tolerance: 1e-10, ..Solver::default() };
        let builder = Machine::builder("Arm").gravity_m_s2([0.0; 3]).body(body, hinge).solver(solver);
        let machine = builder.build().map(|mut machine| {
            if braked {
                let brake = FrictionBrake { torque_n_m: second, ramp_s: 0.0, slip_rad_s: 0.5 };
                let (effect, at_time_s) = (Effect::BrakeApplied { body: 0, brake }, Some(0.1));
                let name = "stops".to_owned();
                machine.failures.push(Failure { name, effect, at_time_s, after: None, when: None, delay_s: 0.0 });
            } else if let JointKind::Revolute(hinge) = &mut machine.bodies[0].joint.kind {
                hinge.motion = JointMotion::Prescribed(Motion::Polynomial(vec![0.2, rate, second]));
            }
            machine
        });
        plant_of(machine.map_err(|refused| refused.to_string()))
    };
    let known_of: [&dyn Fn([f64; 2]) -> f64; 2] = [&work, &dissipated];
    for ((braked, usual), known) in [(false, [0.9, 0.7]), (true, [0.9, 0.8])].into_iter().zip(known_of) {
        let mut own = plant(usual, braked).unwrap();
        own.initialize(0.0).unwrap();
        let tape = own.run_on_tape(&[time_s]).unwrap_or_else(|error| panic!("{error}"));
        let index = own.outputs().layout().accounts()[usize::from(braked)];
        let result = RunResult::Output { index, time: 0 };
        let beside = |place: usize, shift: f64| {
            let mut numbers = usual;
            numbers[place] += shift;
            numbers
        };
        let parameter = |place: usize| {
            Parameter::new("number", 0.0, 1e-3 * usual[place], |shift| plant(beside(place, shift), braked)).unwrap()
        };
        let mut gradient = Gradient::new(&mut own, &tape, (0..2).map(parameter).collect()).unwrap();
        approx::assert_relative_eq!(gradient.values(&[result]).unwrap()[0], known(usual), max_relative = 1e-7);
        let forward = gradient.forward(&[result]).unwrap();
        let adjoint = gradient.adjoint(result).unwrap();
        for place in 0..2 {
            let slope = (known(beside(place, 1e-4)) - known(beside(place, -1e-4))) / 2e-4;
            approx::assert_relative_eq!(forward[0][place], slope, max_relative = 1e-7);
            approx::assert_relative_eq!(adjoint[place], slope, max_relative = 1e-7);
        }
    }
}

/// Accounts of a run with a prescribed joint: the work of its holding torque, by the coefficients of the prescribed motion.
#[test]
#[ignore = "long; `make long` runs it"]
fn work_of_a_prescribed_motion() {
    let machine = |numbers: Numbers| {
        let Numbers { start_angle, start_rate, torque, .. } = numbers;
        let mut machine = numbers.machine(true)?;
        if let JointKind::Revolute(hinge) = &mut machine.bodies[1].joint.kind {
            hinge.motion = JointMotion::Prescribed(Motion::Polynomial(vec![start_angle, start_rate, 4.0 * torque]));
        }
        machine.solver.tolerance = 1e-12;
        Ok(machine)
    };
    let places = [PLACES[2], PLACES[8], PLACES[9], PLACES[12]];
    let compared = compare_results(machine, &InputRows::default(), &places, |plant| accounts(plant, None));
    assert!(compared.forward_and_adjoint < 1e-9, "{:.1e}", compared.forward_and_adjoint);
    assert!(compared.differences < 1e-6, "{:.1e}", compared.differences);
}

/// GR-56: means of accounts are errors that name them.
#[test]
fn means_of_accounts_are_refused_by_name() {
    let refused = |machine: Machine, square: bool| {
        let mut plant = started(machine);
        let tape = plant.run_on_tape(&[0.02]).unwrap_or_else(|error| panic!("{error}"));
        let index = plant.outputs().layout().accounts()[0];
        let mut gradient = Gradient::new(&mut plant, &tape, Vec::new()).unwrap_or_else(|error| panic!("{error}"));
        gradient
            .values(&[RunResult::Mean { index, time: 0, square }])
            .err()
            .map_or_else(String::new, |error| error.to_string())
    };
    for square in [false, true] {
        let message = refused(Numbers::USUAL.machine(true).unwrap_or_else(|error| panic!("{error}")), square);
        assert!(message.contains("means of energy accounts"), "{message}");
    }
}
