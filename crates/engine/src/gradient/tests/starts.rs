//! Derivatives with respect to the start of a run: equilibria, numbers at the ends of their ranges, start values of inputs and parameters.

use super::*;

/// GR-07: from a static equilibrium, whose own derivative by eleven numbers is that of the neighbouring equilibria. Rates are zero at
/// the start for all of them.
#[test]
fn gradients_start_in_an_equilibrium() {
    let places: Vec<Place> =
        PLACES.into_iter().filter(|place| !place.0.starts_with("latch") && !place.0.starts_with("start")).collect();
    let machine = |numbers: Numbers| {
        let mut machine = numbers.machine(false)?;
        machine.experiment.start = StartState::Equilibrium;
        Ok(machine)
    };
    let Compared { forward_and_adjoint, differences, .. } = compare_machines(false, machine, &places);
    assert!(forward_and_adjoint < 1e-10, "{forward_and_adjoint:.1e}");
    // as for GR-01, of differences over a thousandth of each number
    assert!(differences < 1e-6, "{differences:.1e}");
}

/// GR-08: a number at the end of its range has one-sided differences (a damping of zero, which must not be negative): equal to the slope
/// of the same number from the inside, extrapolated to the end.
#[test]
fn a_number_at_the_end_of_its_range_has_a_slope() {
    let place = PLACES[1];
    let slope = |damping: f64| {
        let machine = |shift: f64| {
            let machine = Numbers { damping: damping + shift, ..Numbers::USUAL }.machine(true)?;
            if damping + shift < 0.0 {
                return Err("a damping below zero".to_owned());
            }
            Ok(machine)
        };
        let mut plant = started(machine(0.0).unwrap_or_else(|error| panic!("{error}")));
        let tape = plant.run_on_tape(&TIMES_S).unwrap_or_else(|error| panic!("{error}"));
        let parameter = Parameter::new(place.0, 0.0, 2e-7, |shift| plant_of(machine(shift)));
        let parameter = parameter.unwrap_or_else(|error| panic!("{error}"));
        let sided = parameter.machines();
        let mut gradient = Gradient::new(&mut plant, &tape, vec![parameter]).unwrap_or_else(|error| panic!("{error}"));
        let slope = gradient.adjoint(RunResult::LatchTime { joint: 1 }).unwrap_or_else(|error| panic!("{error}"))[0];
        (slope, sided)
    };
    let ((at_end, one_sided), (inside, central), (further, _)) = (slope(0.0), slope(1e-6), slope(2e-6));
    assert_eq!((one_sided, central), (5, 4));
    let extrapolated = 2.0 * inside - further;
    // the slope's own curvature: 3.4e-4 of it over steps of 1e-4 squared
    assert!((at_end - extrapolated).abs() < 1e-6 * at_end.abs(), "{at_end} and {extrapolated}");
    let refused = Parameter::new(place.0, 0.0, 1.0, |_| Err::<Plant, _>("refused"));
    assert!(matches!(refused, Err("refused")));
}

/// GR-09: start values of inputs and parameters are parameters too, at any value: a load at a station, gravity and the motor's torque set
/// before the start give the slopes of the machine that has these numbers. The requested times may include the start.
#[test]
fn start_values_are_parameters() {
    let machine = |numbers: Numbers| Numbers { load: 0.0, ..numbers }.machine(true);
    let with = |load: f64| {
        let mut plant = plant_of(machine(Numbers::USUAL))?;
        plant.inputs_mut().stations_mut()[0].force_n.z += load;
        Ok::<_, String>(plant)
    };
    let parameter = |name, plant: &dyn Fn(f64) -> Result<Plant, String>| {
        Parameter::new(name, Numbers::USUAL.load, 1e-3, plant).unwrap_or_else(|error| panic!("{error}"))
    };
    let slopes = |set: bool| {
        let plant = |load: f64| match set {
            true => with(load),
            false => plant_of(Numbers { load, ..Numbers::USUAL }.machine(true)),
        };
        let mut own = plant(Numbers::USUAL.load).unwrap_or_else(|error| panic!("{error}"));
        own.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let tape = own.run_on_tape(&[0.0, 0.1, 0.4]).unwrap_or_else(|error| panic!("{error}"));
        let layout = *own.outputs().layout();
        let results: Vec<RunResult> = (0..3)
            .flat_map(|time| {
                let energy = layout.energy.place(0, 0);
                let root = layout.root.place(0, 0)..layout.root.place(0, 0) + 6;
                [energy, layout.gauges.place(0, 0)]
                    .into_iter()
                    .chain(root)
                    .map(move |index| RunResult::Output { index, time })
            })
            .collect();
        let mut gradient =
            Gradient::new(&mut own, &tape, vec![parameter("load", &plant)]).unwrap_or_else(|error| panic!("{error}"));
        let forward = gradient.forward(&results).unwrap_or_else(|error| panic!("{error}"));
        // the gauge is recovered from forces, whose differences have more round-off, 3e-10; so do reactions, of 1 N per N, 1e-12
        for (row, result) in forward.iter().zip(&results) {
            let adjoint = gradient.adjoint(*result).unwrap_or_else(|error| panic!("{error}"))[0];
            let apart = (row[0] - adjoint).abs();
            assert!(apart <= 1e-8 * adjoint.abs() + 1e-11, "{result:?}: {} and {adjoint}", row[0]);
        }
        forward
    };
    for (own, other) in slopes(true).iter().zip(&slopes(false)) {
        assert!((own[0] - other[0]).abs() <= 1e-9 * other[0].abs() + 1e-11, "{own:?} and {other:?}");
    }
    // at the start the load changes accelerations, and with them the reaction at the root, but no kinetic energy
    let start = slopes(true);
    let reaction = start[2..8].iter().fold(0.0f64, |most, row| most.max(row[0].abs()));
    assert!(start[0][0].abs() < 1e-15 && reaction > 1e-3, "{start:?}");
}
