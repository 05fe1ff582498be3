//! Derivatives of outputs with respect to inputs and parameters.

use super::{Bench, Dice};
use crate::coupling::wings;
use foldwing::config;
use foldwing::interface::{AccessError, Causality, DerivativeError, Stage, Value};
use std::collections::BTreeMap;

/// Required relative agreement.
const AGREEMENT: f64 = 1e-6;
/// Length in s of the steps after which outputs reflect a change of the inputs; one and two of them give the outputs at their start.
const INSTANT_S: f64 = 1e-13;

/// Magnitude in m/s² whose round-off an output contains: specific forces are differences between accelerations and gravity.
fn weight(name: &str) -> f64 {
    if name.contains("specific_force") { 2.0 * 9.81 } else { 0.0 }
}

/// Derivatives of all unknowns with respect to one known.
fn column(bench: &mut Bench, stage: Stage, unknowns: &[u32], known: u32) -> Vec<f64> {
    let mut values = vec![f64::NAN; unknowns.len()];
    let outcome =
        bench.table.directional_derivative(&mut bench.plant, (stage, 0.0), (unknowns, &mut values), (&[known], &[1.0]));
    outcome.unwrap_or_else(|error| panic!("{error}"));
    values
}

/// Compares the derivatives with respect to all real inputs at the current state with central differences between steps of nearly zero
/// length from that state with changed inputs. Returns the number of pairs and the largest relative difference.
fn compare_at_state(what: &str, bench: &mut Bench) -> (usize, f64) {
    let unknowns: Vec<u32> = bench.reals(Causality::Output).iter().map(|row| row.value_reference).collect();
    let knowns: Vec<(u32, String)> =
        bench.reals(Causality::Input).iter().map(|row| (row.value_reference, row.name.clone())).collect();
    let dependencies = bench.table.dependencies(bench.plant.machine());
    let start = bench.plant.snapshot();
    let bits = bench.values(&unknowns);
    let (mut pairs, mut worst) = (0, 0.0_f64);
    // largest derivative of each unknown with respect to each kind of input, e.g. to all forces
    let kind = |name: &str| name.rsplit('.').nth(1).unwrap_or(name).to_owned();
    let mut largest: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for (known, name) in &knowns {
        let given = column(bench, Stage::Running, &unknowns, *known);
        let sizes = largest.entry(kind(name)).or_insert_with(|| vec![0.0; unknowns.len()]);
        sizes.iter_mut().zip(given).for_each(|(size, entry)| *size = size.max(entry.abs()));
    }
    for (known, name) in knowns {
        let given = column(bench, Stage::Running, &unknowns, known);
        assert_eq!(bench.plant.snapshot(), start, "{what}: asking for {name} changes the state");
        assert_eq!(bench.values(&unknowns), bits, "{what}: asking for {name} changes the outputs");
        // away from the limits of drives; everything else is a polynomial of second degree
        let step = if name.ends_with(".angle_command") || name.ends_with(".external_torque") { 1e-4 } else { 1.0 };
        let value = bench.values(&[known])[0];
        let mut side = |sign: f64| {
            let mut after = |steps: f64| {
                bench.plant.restore(&start).expect("own snapshot");
                bench.table.set(&mut bench.plant, known, Value::Real(value + sign * step)).expect("an input");
                if bench.table.find("aero.density").is_some() {
                    // changes of the aerodynamic loads with the inputs do not count: these loads are held
                    bench.set("aero.density", 1e-20);
                }
                let start_s = bench.plant.time_s();
                bench.step(start_s + steps * INSTANT_S);
                (bench.plant.time_s() - start_s, bench.values(&unknowns))
            };
            let ((near_s, near), (far_s, far)) = (after(1.0), after(2.0));
            let begin = |(near, far): (&f64, &f64)| (far_s * near - near_s * far) / (far_s - near_s);
            near.iter().zip(&far).map(begin).collect::<Vec<f64>>()
        };
        let (above, below) = (side(1.0), side(-1.0));
        bench.plant.restore(&start).expect("own snapshot");
        // round-off of a component scales with the magnitude of its vector: for a planar linkage, components normal to the plane are zero
        let vector = |unknown: u32| {
            let name = &bench.table.variables()[unknown as usize].name;
            name.rsplit_once('.').map_or(name.clone(), |(stem, _)| stem.to_owned())
        };
        let name_of = |unknown: u32| bench.table.variables()[unknown as usize].name.as_str();
        let mut sizes: BTreeMap<String, f64> = BTreeMap::new();
        for (i, &unknown) in unknowns.iter().enumerate() {
            let size = sizes.entry(vector(unknown)).or_default();
            *size = size.max(above[i].abs() + below[i].abs() + given[i].abs() * step + weight(name_of(unknown)));
        }
        for (i, &unknown) in unknowns.iter().enumerate() {
            let row = &bench.table.variables()[unknown as usize];
            let slope = (above[i] - below[i]) / (2.0 * step);
            let declared = dependencies[unknown as usize].running.iter().any(|&(reference, _)| reference == known);
            assert!(declared || given[i] == 0.0, "{what}: {} by {name} is not declared", row.name);
            // round-off of the difference: the solution for the accelerations has the condition number of the mass matrix
            let floor = if row.name.starts_with("gauge.") { 1e-15 } else { 1e-13 };
            // each component of a specific force is a sum over the three components of the acceleration
            let terms = if row.name.contains("specific_force") { 3.0 } else { 1.0 };
            let noise = (1e-11 * terms * sizes[&vector(unknown)] + floor) / step;
            let error = (given[i] - slope).abs();
            assert!(
                error <= AGREEMENT * given[i].abs() + 1e-10 * largest[&kind(&name)][i] + noise,
                "{what}: {} by {name}: {} against {slope} by differences",
                row.name,
                given[i]
            );
            if given[i].abs() > 1e-3 * largest[&kind(&name)][i] + 1e6 * noise {
                worst = worst.max(error / given[i].abs());
            }
            pairs += usize::from(declared);
        }
    }
    (pairs, worst)
}

/// Sets all real inputs to random values that do not drive any motor to its limit.
fn scatter(bench: &mut Bench, dice: &mut Dice) {
    let names: Vec<String> = bench.reals(Causality::Input).iter().map(|row| row.name.clone()).collect();
    for name in names {
        let (size, about) = match name.as_str() {
            name if name.starts_with("load.") => (0.01, 0.0),
            name if name.starts_with("wind.") => (1.0, bench.get(name)),
            name if name.ends_with(".external_torque") || name.ends_with(".angle_command") => (0.01, 0.0),
            _ => (0.5, bench.get(&name)),
        };
        let value = about + size * dice.roll();
        bench.set(&name, value);
    }
}

/// E-08. Derivatives with respect to all inputs equal central differences at random states of every kind of machine: before, at and after
/// the latch, at a rate limit, at a torque limit, with aerodynamics. To 1e-6, plus 1e-10 of the largest derivative with respect to inputs
/// of the same kind: accelerations are the solution of a linear system, whose round-off scales with its largest entries.
#[test]
fn e08_derivatives_by_inputs_equal_differences() {
    let lattice = "model = \"uvlm\"\nstep_s = 1e-3\nwake_rows = 10\ndensity_kg_m3 = 1.2\nwind_m_s = [0.0, -10.0, 1.0]";
    let strips = "model = \"strip\"\nstep_s = 1e-3\ndensity_kg_m3 = 1.2\nwind_m_s = [0.0, -10.0, 1.0]";
    let shipped = ["folding_wing", "folding_wing_constant", "branched", "flying_wing", "four_bar", "three_bodies"];
    let benches = shipped.map(|name| (name, Bench::shipped(name))).into_iter().chain([
        ("in air, lattice", Bench::of(wings::folding_wing(lattice, 3, 2))),
        ("in air, strips", Bench::of(wings::folding_wing(strips, 3, 1))),
    ]);
    for (name, mut bench) in benches {
        let mut dice = Dice(3);
        let mut sum = (0, 0.0_f64);
        for end_s in [0.003, 0.0307, 0.06] {
            scatter(&mut bench, &mut dice);
            bench.march(end_s, 3);
            let (pairs, worst) = compare_at_state(&format!("{name} at {end_s} s"), &mut bench);
            sum = (sum.0 + pairs, sum.1.max(worst));
        }
        println!("E-08: {name}: {} pairs, worst {:.1e}", sum.0, sum.1);
    }
}

/// E-08. The same comparison before, at and after the latch of the shipped wing.
#[test]
fn e08_derivatives_around_the_latch() {
    let rigid =
        include_str!("../../../examples/models/folding_wing.toml").replace("stiffness_ratio = 1e4", "kind = \"rigid\"");
    let rigid = config::parse(&rigid, "rigid").expect("valid");
    for (kind, machine) in [("elastic", None), ("rigid", Some(rigid))] {
        let bench = || machine.clone().map_or_else(|| Bench::shipped("folding_wing"), Bench::of);
        let mut ahead = bench();
        ahead.march(0.15, 30);
        let latch_s = ahead.get("fold.latch_time");
        assert!(latch_s > 0.1 && latch_s < 0.15, "{latch_s} s");
        let mut bench = bench();
        for (when, end_s) in
            [("just before", latch_s - 1e-6), ("at", latch_s), ("just after", latch_s + 1e-6), ("after", 0.15)]
        {
            bench.march(end_s, 2);
            let (pairs, worst) = compare_at_state(&format!("{when} the {kind} latch"), &mut bench);
            println!("E-08: {when} the {kind} latch, t = {end_s} s: {pairs} pairs, worst {worst:.1e}");
        }
        assert!(bench.plant.outputs().latches()[0].closed.is_on());
    }
}

/// E-08. The torque of a motor at its torque limit does not depend on the command; with a rate limit it does not depend on it
/// instantaneously; without limits the derivative is the stiffness.
#[test]
fn e08_limits_of_the_drive() {
    let by_command = |prepare: &dyn Fn(&mut Bench)| {
        let mut bench = Bench::shipped("folding_wing");
        prepare(&mut bench);
        bench.plant.initialize(0.0).expect("a start");
        bench.step(0.01);
        compare_at_state("limits", &mut bench);
        let (torque, command) = (bench.reference("fold.total_torque"), bench.reference("fold.angle_command"));
        column(&mut bench, Stage::Running, &[torque], command)[0]
    };
    let free = by_command(&|_| ());
    assert!((free - 0.026).abs() < 1e-12, "{free} N.m/rad is not the drive's stiffness");
    assert_eq!(by_command(&|bench| bench.set("fold.motor_rate_limit", 3.0)), 0.0);
    assert_eq!(by_command(&|bench| bench.set("fold.motor_torque_limit", 0.01)), 0.0);
}

/// E-09. In Initialization Mode, derivatives of initial values with respect to inputs and parameters equal fourth-order central differences
/// of the initialisation with relative steps of 1e-4, whose truncation error is 1e-16 of the fifth derivative; from the unstrained state
/// and, with aerodynamics, with loads at the first instant. Undeclared pairs give zero.
#[test]
fn e09_derivatives_of_initial_values_equal_differences() {
    let lattice = "model = \"uvlm\"\nstep_s = 1e-3\nwake_rows = 10\ndensity_kg_m3 = 1.2\nwind_m_s = [0.0, -10.0, 1.0]";
    let shipped = ["folding_wing", "branched", "flying_wing", "four_bar"];
    let benches = shipped.map(|name| (name, Bench::shipped(name))).into_iter();
    for (name, mut bench) in benches.chain([("in air", Bench::of(wings::folding_wing(lattice, 3, 2)))]) {
        let unknowns: Vec<u32> = bench.reals(Causality::Output).iter().map(|row| row.value_reference).collect();
        let rows = bench.reals(Causality::Input).into_iter().chain(bench.reals(Causality::Parameter));
        let knowns: Vec<(u32, String)> = rows.map(|row| (row.value_reference, row.name.clone())).collect();
        let dependencies = bench.table.dependencies(bench.plant.machine());
        let bits = bench.values(&unknowns);
        let (mut pairs, mut worst) = (0, 0.0_f64);
        for (known, known_name) in knowns.into_iter().filter(|(_, name)| !name.starts_with("solver.")) {
            let given = column(&mut bench, Stage::Starting, &unknowns, known);
            assert_eq!(bench.values(&unknowns), bits, "{name}: asking for {known_name} changes the outputs");
            let value = bench.values(&[known])[0];
            // for polynomials of second degree, differences have no truncation error, and large steps have the least round-off
            let exact = ["load.", "gravity.", "root."].iter().any(|group| known_name.starts_with(group));
            let size = if value == 0.0 { 1.0 } else { value.abs() };
            let step = if exact && name != "in air" { 0.5 } else { 1e-4 * size };
            let mut side = |sign: f64| {
                let shifted = Value::Real(value + sign * step);
                // non-negative values permit only a one-sided difference
                let reached = bench.table.set(&mut bench.plant, known, shifted).is_ok();
                bench.plant.initialize(0.0).expect("a start");
                let values = bench.values(&unknowns);
                bench.table.set(&mut bench.plant, known, Value::Real(value)).expect("the value before");
                (values, f64::from(u8::from(reached)))
            };
            let ((above, up), (below, down)) = (side(1.0), side(-1.0));
            let ((above_2, _), (below_2, _)) = (side(2.0), side(-2.0));
            bench.plant.initialize(0.0).expect("a start");
            for (i, &unknown) in unknowns.iter().enumerate() {
                let row = &bench.table.variables()[unknown as usize];
                let declared = dependencies[unknown as usize].initial.iter().any(|&(reference, _)| reference == known);
                let slope = if up + down == 2.0 {
                    (8.0 * (above[i] - below[i]) - (above_2[i] - below_2[i])) / (12.0 * step)
                } else {
                    (above[i] - below[i]) / step
                };
                assert!(declared || given[i] == 0.0, "{name}: {} by {known_name} is not declared", row.name);
                // round-off of the values, of strains as differences of poses of size 1, and of angular accelerations as sums of the
                // effects of moments of 1 N·m on a plate of 1e-5 kg·m²
                let floor = match row.name.as_str() {
                    name if name.starts_with("gauge.") => 1e-15,
                    name if name.contains("angular_acceleration") => 1e-11,
                    _ => 1e-13,
                };
                // each component of a specific force is a sum over the three components of the acceleration
                let stem = |name: &str| name.rsplit_once('.').map(|(stem, _)| stem.to_owned());
                let beside = |&(_, other): &(usize, &u32)| {
                    let other = &bench.table.variables()[*other as usize].name;
                    row.name.contains("specific_force") && *other != row.name && stem(other) == stem(&row.name)
                };
                let others = || unknowns.iter().enumerate().filter(beside).map(|(j, _)| j);
                let size = above[i].abs()
                    + below[i].abs()
                    + weight(&row.name)
                    + others().map(|j| above[j].abs() + below[j].abs()).sum::<f64>();
                let noise = (1e-11 * size + floor) / step;
                let error = (given[i] - slope).abs();
                // one-sided differences; axes of sections rotate with the angles, which doubles the second derivative
                let one_sided = if row.name.contains("specific_force") { 2e-3 } else { 1e-3 };
                let allowed = if up + down == 2.0 { AGREEMENT } else { one_sided };
                assert!(
                    error <= allowed * others().map(|j| given[j].abs()).fold(given[i].abs(), f64::max) + noise,
                    "{name}: {} by {known_name}: {} against {slope} by differences",
                    row.name,
                    given[i]
                );
                if up + down == 2.0 && given[i].abs() > 1e6 * noise {
                    worst = worst.max(error / given[i].abs());
                }
                pairs += usize::from(declared);
            }
        }
        println!("E-09: {name}: {pairs} pairs, worst {worst:.1e}");
    }
}

/// E-10. Seeds superpose, and variables that are not unknowns or knowns are rejected.
#[test]
fn e10_seeds_add_up_and_other_rows_are_refused() {
    let mut bench = Bench::shipped("folding_wing");
    bench.step(0.01);
    let force = bench.reference("root.force.x");
    let [torque, field] = ["fold.external_torque", "gravity.z"].map(|name| bench.reference(name));
    let single = [torque, field].map(|known| column(&mut bench, Stage::Running, &[force], known)[0]);
    let mut both = [0.0];
    let seeds = (&[torque, field][..], &[2.0, -3.0][..]);
    bench
        .table
        .directional_derivative(&mut bench.plant, (Stage::Running, 0.0), (&[force], &mut both), seeds)
        .expect("legal");
    let sum = 2.0 * single[0] - 3.0 * single[1];
    assert!((both[0] - sum).abs() < 1e-12 * sum.abs(), "{} and {sum}", both[0]);

    let mut refuse = |stage, unknown: &str, known: &str, seed: f64| {
        let (unknown, known) = (bench.reference(unknown), bench.reference(known));
        let knowns = (&[known][..], &[seed][..]);
        let outcome =
            bench.table.directional_derivative(&mut bench.plant, (stage, 0.0), (&[unknown], &mut [0.0]), knowns);
        let DerivativeError::Access(error) = outcome.expect_err("refused") else { panic!("not an access error") };
        error
    };
    use AccessError as E;
    assert!(matches!(refuse(Stage::Running, "fold.angle", "fold.motor_stiffness", 1.0), E::NotAKnown { .. }));
    assert!(matches!(refuse(Stage::Starting, "fold.angle", "time", 1.0), E::NotAKnown { .. }));
    assert!(matches!(refuse(Stage::Running, "fold.angle", "fold.angular_velocity", 1.0), E::NotAKnown { .. }));
    assert!(matches!(
        refuse(Stage::Running, "fold.external_torque", "fold.external_torque", 1.0),
        E::NotAnUnknown { .. }
    ));
    assert!(matches!(refuse(Stage::Running, "fold.latched", "fold.external_torque", 1.0), E::WrongType { .. }));
    assert!(matches!(refuse(Stage::Running, "fold.angle", "fold.release", 1.0), E::WrongType { .. }));
    assert!(matches!(refuse(Stage::Running, "fold.angle", "fold.external_torque", f64::NAN), E::NotFinite { .. }));
}
