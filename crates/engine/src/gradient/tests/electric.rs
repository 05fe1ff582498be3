//! Gradients with electrical DC motors, with rotors that turn with their carrier, and with damping by ratios of modes.

use super::limits::{results, usual};
use super::refusals::fold;
use super::*;
use crate::load::RootMotion;
use crate::machine::DcMotor;
use crate::system::DcMotorOutputs;
use std::mem::offset_of;

/// The wing of GR-01, or of GR-02 with a stop, folded by a geared DC motor; with a rotor that turns with its carrier.
fn electric(numbers: Numbers, latched: bool, carried: bool) -> Result<Machine, String> {
    let mut machine = numbers.machine(latched)?;
    let Numbers { resistance, inductance, torque_constant, gear, voltage, current, .. } = numbers;
    let own = fold(&mut machine);
    own.dc_motor = Some(DcMotor {
        resistance_ohm: resistance,
        inductance_h: inductance,
        torque_constant_n_m_a: torque_constant,
        // the wing folds with a negative rate
        gear_ratio: -gear,
        voltage_v: voltage,
        start_current_a: current,
    });
    own.motor.gear_ratio = carried.then_some(-gear);
    own.motor.inertia_kg_m2 = numbers.rotor;
    // at 1e-10 the differences of runs are 6.2e-6 off, at this one 9.5e-8 (GR-100)
    machine.solver.tolerance = 1e-12;
    Ok(machine)
}

/// Step of the differences of runs as a share of a number: with [`DIFFERENCE`] they are 2.1e-6 off (GR-102), with this one 6.2e-7.
const SHORT: f64 = 2e-4;

const ELECTRIC: [Place; 6] = [
    ("resistance", |n| &mut n.resistance),
    ("inductance", |n| &mut n.inductance),
    ("torque_constant", |n| &mut n.torque_constant),
    ("gear", |n| &mut n.gear),
    ("voltage", |n| &mut n.voltage),
    ("current", |n| &mut n.current),
];
const ROTOR: Place = ("rotor", |n| &mut n.rotor);

/// Strains, motions, torques, energies and accounts, and current, torque and power of the motor.
fn all(plant: &Plant, latched: bool) -> Vec<RunResult> {
    let motors = plant.outputs().layout().dc_motors;
    let offsets = [
        offset_of!(DcMotorOutputs, current_a),
        offset_of!(DcMotorOutputs, torque_n_m),
        offset_of!(DcMotorOutputs, power_w),
    ];
    let own = offsets
        .into_iter()
        .flat_map(|offset| (0..2).map(move |time| RunResult::Output { index: motors.place(0, offset), time }));
    results(plant, latched.then_some(1)).into_iter().chain(own).collect()
}

/// GR-100: the wing on a DC motor through a latch and onto a stop, with a rotor that does or does not turn with its carrier, by the six numbers of
/// the circuit, the rotor's inertia and other numbers.
#[test]
fn gradients_with_currents() {
    for (latched, carried) in [(true, false), (true, true), (false, true)] {
        let names: &[&str] =
            if carried { &["mass"] } else { &["stiffness", "damping", "start_angle", "length", "mass"] };
        let places: Vec<Place> = usual(names).into_iter().chain(ELECTRIC).chain([ROTOR]).collect();
        let machine = |numbers: Numbers| electric(numbers, latched, carried);
        let compared = compare_over(SHORT, machine, &InputRows::default(), &places, |plant| all(plant, latched));
        let Compared { forward_and_adjoint, differences, events } = compared;
        println!("GR-100 {latched} {carried} {forward_and_adjoint:.1e} {differences:.1e}");
        assert!(events > 0, "no event");
        assert!(forward_and_adjoint < 1e-9, "{forward_and_adjoint:.1e}");
        assert!(differences < 1e-6, "{differences:.1e}");
    }
}

/// GR-101: the same under a voltage that ramps and jumps and with a root that turns about the axis of the rotor and across it, by numbers of the
/// circuit, and by the rows of the voltage and of a component of the rotation.
#[test]
fn gradients_with_currents_under_voltages_over_time() {
    let own = electric(Numbers::USUAL, true, true).unwrap();
    let layout = *Plant::new(Arc::new(own.clone())).inputs().layout();
    let column = |index: usize, values: [f64; 5]| InputColumn { index, held: false, values: values.to_vec() };
    let turning = layout.root.place(0, offset_of!(RootMotion, angular_velocity_rad_s));
    let rate = layout.root.place(0, offset_of!(RootMotion, angular_acceleration_rad_s2));
    let columns = vec![
        column(layout.dc_motors.place(0, 0), [2.0, 3.0, 1.0, 4.0, 2.5]),
        column(turning, [0.1, 0.3, 0.3, 0.8, 0.8]),
        column(turning + 2, [0.2, -0.4, -0.4, 0.5, 0.5]),
        column(rate + 1, [0.3, 0.2, 0.2, -0.5, -0.5]),
    ];
    let inputs = InputRows::new(vec![-0.1, 0.07, 0.07, 0.2, 0.6], columns).unwrap();
    let places: Vec<Place> =
        ELECTRIC[..4].iter().copied().chain(usual(&["start_angle", "mass"])).chain([ROTOR]).collect();
    let machine = |numbers: Numbers| electric(numbers, true, true);
    let compared = compare_over(SHORT, machine, &inputs, &places, |plant| all(plant, true));
    let Compared { forward_and_adjoint, differences, events } = compared;
    println!("GR-101 {forward_and_adjoint:.1e} {differences:.1e}");
    assert!(events > 0, "no event");
    assert!(forward_and_adjoint < 1e-9, "{forward_and_adjoint:.1e}");
    assert!(differences < 1e-6, "{differences:.1e}");

    let mut plant = Plant::new(Arc::new(own.clone()));
    inputs.set(&mut plant, 0.0);
    plant.initialize(0.0).unwrap();
    let tape = plant.run_on_tape_with(&inputs, &TIMES_S).unwrap();
    let results = all(&plant, true);
    let rows = |column: usize| {
        let plant = || Ok::<_, String>(Plant::new(Arc::new(own.clone())));
        Parameter::of_rows("rows", (column, (0..5).collect()), 1e-3, plant).unwrap()
    };
    let mut gradient = Gradient::new(&mut plant, &tape, vec![rows(0), rows(2)]).unwrap();
    let forward = gradient.forward(&results).unwrap();
    let adjoint: Vec<Vec<f64>> = results.iter().map(|result| gradient.adjoint(*result).unwrap()).collect();
    let values = gradient.values(&results).unwrap();
    let mut known = vec![vec![0.0; 10]; results.len()];
    let columns = [0, 2].into_iter().flat_map(|column| (0..5).map(move |row| (column, row)));
    for (place, of_row) in columns.enumerate() {
        for (steps, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
            let rows = super::inputs::changed(&inputs, of_row, steps * 1e-3);
            let there = retraced_with(&tape, own.clone(), &rows, &results);
            known.iter_mut().zip(there).for_each(|(known, value)| known[place] += weight / 12e-3 * value);
        }
    }
    let names = [("row", 1.0); 10];
    let [both, differences] = disagreements((&results, &values), &names, [&forward, &adjoint, &known]);
    println!("GR-101 rows {both:.1e} {differences:.1e}");
    assert!(both < 1e-9, "{both:.1e}");
    assert!(differences < 1e-6, "{differences:.1e}");
}

/// GR-102: the wing of GR-01 with damping by ratios of two modes, by a ratio and six numbers that change the modes.
#[test]
fn gradients_with_damping_by_ratios() {
    let machine = |numbers: Numbers| {
        let mut machine = numbers.machine(true)?;
        machine.bodies[0].stiffness_damping_s = 0.0;
        machine.bodies[0].modal_damping_ratios = vec![numbers.ratio, 0.03];
        Ok(machine)
    };
    let ratio: Place = ("ratio", |n| &mut n.ratio);
    let names = ["stiffness", "start_angle", "length", "thickness", "density", "mass"];
    let places: Vec<Place> = usual(&names).into_iter().chain([ratio]).collect();
    let compared = compare_over(SHORT, machine, &InputRows::default(), &places, |plant| results(plant, Some(1)));
    let Compared { forward_and_adjoint, differences, events } = compared;
    println!("GR-102 {forward_and_adjoint:.1e} {differences:.1e}");
    assert!(events > 0, "no event");
    assert!(forward_and_adjoint < 1e-9, "{forward_and_adjoint:.1e}");
    assert!(differences < 1e-6, "{differences:.1e}");
}

/// GR-104: the wing with a geared motor, whose rotor turns with the inner wing, without a circuit, by its ratio and inertia and seven numbers of
/// wing and drive.
#[test]
fn gradients_with_a_rotor_on_its_carrier() {
    let machine = |numbers: Numbers| {
        let mut machine = numbers.machine(true)?;
        let own = &mut fold(&mut machine).motor;
        (own.gear_ratio, own.inertia_kg_m2) = (Some(-numbers.gear), numbers.rotor);
        Ok(machine)
    };
    let gear: Place = ("gear", |n| &mut n.gear);
    let names = ["stiffness", "torque", "start_rate", "length", "thickness", "density", "mass"];
    let places: Vec<Place> = usual(&names).into_iter().chain([gear, ROTOR]).collect();
    let compared = compare_over(SHORT, machine, &InputRows::default(), &places, |plant| results(plant, Some(1)));
    let Compared { forward_and_adjoint, differences, events } = compared;
    println!("GR-104 {forward_and_adjoint:.1e} {differences:.1e}");
    assert!(events > 0, "no event");
    assert!(forward_and_adjoint < 1e-9, "{forward_and_adjoint:.1e}");
    assert!(differences < 1e-6, "{differences:.1e}");
}
