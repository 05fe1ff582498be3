//! Gradients of generators.

use super::limits::{results, usual};
use super::refusals::fold;
use super::*;
use crate::system::GeneratorOutputs;
use std::mem::offset_of;

/// The wing of GR-01 that drives a generator.
fn wing(numbers: Numbers, beyond: Beyond, share: f64) -> Result<Machine, String> {
    let mut machine = numbers.machine(true)?;
    let Numbers { gear, row, row_torque, gain, .. } = numbers;
    let (row, first) = (share * row, 0.5 * share * Numbers::USUAL.row);
    fold(&mut machine).generator = Some(GeneratorLaw {
        // the wing folds with a negative rate
        gear_ratio: -gear,
        rows: vec![[first, gain * first * first], [row, row_torque], [1.6 * row, 1.2 * row_torque]],
        square_gain_n_m_s2: Some(gain),
        beyond,
        efficiency: 0.9,
        connected: true,
    });
    Ok(machine)
}

/// GR-80: the wing with a generator whose speed passes all pieces of its law, by its gear ratio, rows and gain and five other numbers: strains,
/// motions, torque and power of the generator, energies and accounts, latch time; with constant torque and with constant power beyond the
/// table.
#[test]
fn gradients_with_a_generator() {
    for beyond in [Beyond::Torque, Beyond::Power] {
        // a table at whose rows no stage lies along the differences
        let clear = |share: &f64| {
            let mut plant = started(wing(Numbers::USUAL, beyond, *share).unwrap());
            let tape = plant.run_on_tape(&TIMES_S).unwrap_or_else(|error| panic!("{error}"));
            let forces = plant.system_mut().equations.forces.joints()[1].clone();
            let law = &forces.generator().unwrap().law;
            let points = tape.steps.iter().flat_map(|step| step.later());
            let speeds: Vec<f64> = points.map(|at| law.gear_ratio * at.v[forces.coordinate]).collect();
            let mut seen: Vec<_> = speeds.iter().filter_map(|speed| law.segment(*speed)).collect();
            seen.sort_by_key(|segment| format!("{segment:?}"));
            seen.dedup();
            let distance = |(speed, row): (&f64, &[f64; 2])| (speed - row[0]).abs() / row[0];
            let pairs = speeds.iter().flat_map(|speed| law.rows.iter().map(move |row| (speed, row)));
            seen.len() >= 4 && pairs.map(distance).fold(f64::INFINITY, f64::min) > 5.0 * DIFFERENCE
        };
        let share = (0..60).map(|number| 0.8 + 0.01 * f64::from(number)).find(clear).expect("a table");
        let own: [Place; 4] = [
            ("gear", |n| &mut n.gear),
            ("row", |n| &mut n.row),
            ("row_torque", |n| &mut n.row_torque),
            ("gain", |n| &mut n.gain),
        ];
        let names = ["stiffness", "torque", "start_angle", "length", "mass"];
        let places: Vec<Place> = usual(&names).into_iter().chain(own).collect();
        let all = |plant: &Plant| {
            let generators = plant.outputs().layout().generators;
            let offsets = [offset_of!(GeneratorOutputs, torque_n_m), offset_of!(GeneratorOutputs, power_w)];
            let own = offsets.into_iter().flat_map(|offset| {
                (0..2).map(move |time| RunResult::Output { index: generators.place(0, offset), time })
            });
            results(plant, Some(1)).into_iter().chain(own).collect()
        };
        let compared = compare_results(|numbers| wing(numbers, beyond, share), &InputRows::default(), &places, all);
        let Compared { forward_and_adjoint, differences, .. } = compared;
        println!("GR-80 {beyond:?} {forward_and_adjoint:.1e} {differences:.1e}");
        assert!(forward_and_adjoint < 1e-9, "{forward_and_adjoint:.1e}");
        // 3.0e-6 found: at the reversal of the rotation the slope of the square law has a kink, which stages pass along the differences
        assert!(differences < 1e-5, "{differences:.1e}");
    }
}

/// A rotor of 1 kg·m² under a constant torque and a generator whose torque is proportional to the square of the speed: `ω = √(T/g) tanh(√(T g) t)`,
/// by `T` and `g`. Its torque jumps at a speed that it does not reach.
#[test]
fn a_rotor_with_a_square_law_has_its_slopes() {
    let (usual, time_s) = ([0.8, 0.3], 1.4);
    let known = |[torque, gain]: [f64; 2]| (torque / gain).sqrt() * ((torque * gain).sqrt() * time_s).tanh();
    let plant = |[torque, gain]: [f64; 2]| {
        let body = Body::rigid("rotor").inertia(1.0, [0.0; 3], nalgebra::Matrix3::identity());
        let law = GeneratorLaw {
            gear_ratio: 1.0,
            rows: vec![[10.0, gain * 150.0], [11.0, gain * 180.0]],
            square_gain_n_m_s2: Some(gain),
            beyond: Beyond::Torque,
            efficiency: 1.0,
            connected: true,
        };
        let motor = Motor { constant_torque_n_m: -torque, ..Motor::default() };
        let hinge = Joint::revolute("hinge", [0.0, 0.0, 1.0]).motor(motor).generator(law);
        let solver = Solver { tolerance: 1e-10, ..Solver::default() };
        let builder = Machine::builder("Rotor").gravity_m_s2([0.0; 3]).body(body, hinge).solver(solver);
        plant_of(builder.build().map_err(|refused| refused.to_string()))
    };
    let beside = |place: usize, shift: f64| {
        let mut numbers = usual;
        numbers[place] += shift;
        numbers
    };
    let mut own = plant(usual).unwrap();
    own.initialize(0.0).unwrap();
    let tape = own.run_on_tape(&[time_s]).unwrap_or_else(|error| panic!("{error}"));
    // energy that the generator takes, work of the inputs with the opposite sign: work of the torque less the kinetic energy
    let taken = |[torque, gain]: [f64; 2]| {
        let angle = ((torque * gain).sqrt() * time_s).cosh().ln() / gain;
        torque * angle - 0.5 * known([torque, gain]).powi(2)
    };
    let rate = offset_of!(crate::system::JointOutputs, rate_rad_s);
    let layout = *own.outputs().layout();
    let energy = layout.energy.place(0, offset_of!(crate::system::EnergyOutputs, work));
    let results = [layout.joints.place(0, rate), energy].map(|index| RunResult::Output { index, time: 0 });
    let parameters = (0..2)
        .map(|place| Parameter::new("number", 0.0, 1e-3 * usual[place], |shift| plant(beside(place, shift))).unwrap());
    let mut gradient = Gradient::new(&mut own, &tape, parameters.collect()).unwrap();
    let forward = gradient.forward(&results).unwrap();
    let value = |result: usize, numbers| if result == 0 { known(numbers) } else { -taken(numbers) };
    for (number, result) in results.into_iter().enumerate() {
        let adjoint = gradient.adjoint(result).unwrap();
        for place in 0..2 {
            let slope = (value(number, beside(place, 1e-4)) - value(number, beside(place, -1e-4))) / 2e-4;
            for found in [forward[number][place], adjoint[place]] {
                println!("GR-80 {number} {place}: {found} and {slope}");
                assert!((found - slope).abs() < 1e-7 * slope.abs(), "{number} {place}: {found} and {slope}");
            }
        }
    }
}
