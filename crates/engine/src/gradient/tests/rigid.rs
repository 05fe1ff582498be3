//! Gradients through rigid latches and locks, which stop a joint by an impulse.

use super::*;
use crate::force::memory::Contact;
use crate::machine::{Closure, InternalLoad};
use crate::signal::JointInputs;
use crate::system::JointOutputs;
use std::mem::offset_of;

/// The fold joint's latch made rigid, and the iteration closer: stiff motions that the impulse starts enter reactions with its remainder.
pub(super) fn hardened(mut machine: Machine) -> Machine {
    if let JointKind::Revolute(fold) = &mut machine.bodies[1].joint.kind
        && let Some(latch) = &mut fold.latch
    {
        (latch.kind, latch.stiffness_n_m_rad) = (LatchKind::Rigid, 0.0);
    }
    machine.solver.tolerance = 1e-12;
    machine
}

fn build(builder: MachineBuilder) -> Result<Machine, String> {
    builder.internal_load(InternalLoad::on("cut", "inner", 0.1)).build().map_err(|refused| refused.to_string())
}

/// Numbers that a rigid latch has: all but its stiffness and an end stop.
fn places() -> Vec<Place> {
    PLACES.into_iter().filter(|place| !["stop", "latch_stiffness"].contains(&place.0)).collect()
}

/// Motions, strains, reactions and torques at both times, and the latch times of some joints.
fn results(plant: &Plant, latches: &[usize]) -> Vec<RunResult> {
    let layout = *plant.outputs().layout();
    let of_joint = |joint: usize, offset: usize| layout.joints.place(joint, offset);
    let indices = [
        layout.gauges.place(0, 0),
        layout.tips.place(0, 0) + 2,
        layout.energy.place(0, 0),
        of_joint(0, offset_of!(JointOutputs, rate_rad_s)),
        layout.tips.place(0, 0),
        of_joint(1, offset_of!(JointOutputs, latch_torque_n_m)),
        layout.internal_loads.place(0, 0) + 4,
        layout.root.place(0, 0) + 3,
    ];
    let outputs = (0..2).flat_map(|time| indices.map(|index| RunResult::Output { index, time }));
    outputs.chain(latches.iter().map(|joint| RunResult::LatchTime { joint: *joint })).collect()
}

fn agree(compared: &Compared, allowed: f64) {
    let Compared { forward_and_adjoint, differences, .. } = compared;
    assert!(*forward_and_adjoint < 1e-10, "{forward_and_adjoint:.1e}");
    assert!(*differences < allowed, "{differences:.1e}");
}

/// GR-33: the wing of GR-01 with a rigid latch: strains, motions, loads of a section, the latch's reaction and the root's behind the latch,
/// and its time, by thirteen numbers.
#[test]
fn gradients_pass_through_a_rigid_latch() {
    let machine = |numbers: Numbers| build(numbers.builder(true)).map(hardened);
    let compared = compare_results(machine, &InputRows::default(), &places(), |plant| results(plant, &[1]));
    assert_eq!(compared.events, 1);
    agree(&compared, 1e-6);
}

/// A beam, a rigid arm and another one in a row, with a rigid latch between each two; the outermost joint starts on an end stop, to which a
/// motor presses it.
fn chain(numbers: Numbers) -> Result<Machine, String> {
    let material = Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.2e9, density_kg_m3: numbers.density };
    let inner = Body::beam("inner", numbers.length, Solid::rectangle(0.05, numbers.thickness, material))
        .elements(2)
        .mass_damping_1_s(0.5)
        .stiffness_damping_s(numbers.beta)
        .load_stations(1);
    let arm = |name: &str, mass_kg: f64| {
        Body::rigid(name).inertia(mass_kg, [0.15, 0.0, 0.01], nalgebra::Matrix3::identity() * 1e-3)
    };
    let drive = Motor {
        stiffness_n_m_rad: numbers.stiffness,
        damping_n_m_s_rad: numbers.damping,
        constant_torque_n_m: 3.0 * numbers.torque,
        command_rad: numbers.command,
        inertia_kg_m2: 1e-4,
        ..Motor::default()
    };
    let fold = Joint::revolute("fold", [0.0, 1.0, 0.1])
        .on("inner")
        .offset_m([0.01, 0.0, 0.005])
        .motor(drive)
        .start_angle_rad(numbers.start_angle)
        .start_rate_rad_s(numbers.start_rate)
        .latch(Latch::rigid().angle_rad(numbers.latch_angle).capture_rad(0.01));
    let presses = Motor { constant_torque_n_m: -2.0 * numbers.torque, ..Motor::default() };
    let stops = EndStops {
        lower_rad: None,
        upper_rad: Some(numbers.stop + 0.1),
        stiffness_n_m_rad: 20.0,
        damping_n_m_s_rad: 0.3,
    };
    let wrist = Joint::revolute("wrist", [0.0, 1.0, -0.1])
        .on("outer")
        .offset_m([0.3, 0.0, 0.0])
        .motor(presses)
        .end_stops(stops)
        .latch(Latch::rigid().angle_rad(0.38).capture_rad(0.005))
        .start_angle_rad(0.451);
    let root = Joint::revolute("flap", [0.0, 1.0, 0.0]).spring(Spring { stiffness_n_m_rad: 40.0, ..Spring::default() });
    let wrench = crate::load::Wrench { force_n: [0.0, 0.0, numbers.load].into(), ..Default::default() };
    let builder = Machine::builder("Chain")
        .gravity_m_s2([0.0, 0.0, -9.81])
        .body(inner, root)
        .body(arm("outer", 0.1), fold)
        .body(arm("tip", numbers.mass), wrist)
        .load("pull", "inner", 1, wrench)
        .gauge(Gauge::on("root", "inner", 0.05))
        .solver(solver());
    build(builder).map(hardened)
}

/// GR-34: two rigid latches, one after the other, in a row of three bodies: the impulse of the first ends the contact of the outer
/// joint with its end stop.
#[test]
fn gradients_pass_through_two_rigid_latches_and_stops() {
    let own = chain(Numbers::USUAL).unwrap_or_else(|error| panic!("{error}"));
    let tape = started(own).run_on_tape(&TIMES_S).unwrap_or_else(|error| panic!("{error}"));
    let contact = |step: &Step| step.joints[2].contact;
    let leaves = |pair: &[Step]| {
        matches!(pair[0].ending, Ending::Crossing(indicator) if indicator.joint == 1)
            && (contact(&pair[0]), contact(&pair[1])) != (Contact::Apart, Contact::Apart)
            && contact(&pair[0]) != contact(&pair[1])
    };
    assert!(tape.steps.windows(2).any(leaves), "no latch changes a contact");
    let places: Vec<Place> = PLACES.into_iter().filter(|place| place.0 != "latch_stiffness").collect();
    let compared = compare_results(chain, &InputRows::default(), &places, |plant| results(plant, &[1, 2]));
    // 1.3e-6 found; neither truncation nor the location of crossings alone, see GR-34
    agree(&compared, 3e-6);
}

/// GR-35: a parallelogram of beams, without and with shear, that a loop closes and a rigid latch at its crank stops: ideal joints in the
/// impulse.
#[test]
fn gradients_pass_through_a_rigid_latch_of_a_closed_loop() {
    let machine = |numbers: Numbers, has_shear: bool| {
        let material = Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.2e9, density_kg_m3: numbers.density };
        let bar = |name: &str, length_m: f64| {
            let solid = Solid::rectangle(0.02, numbers.thickness, material);
            Body::beam(name, length_m, if has_shear { solid.with_shear() } else { solid })
                .elements(1)
                .stiffness_damping_s(numbers.beta)
        };
        let hinge = |name: &str| Joint::revolute(name, [0.0, 1.0, 0.0]);
        let angle = numbers.start_angle;
        let drive =
            Motor { constant_torque_n_m: -numbers.torque, damping_n_m_s_rad: numbers.damping, ..Motor::default() };
        let latch = Latch::rigid().angle_rad(numbers.latch_angle + 1.45).capture_rad(0.01);
        let builder = Machine::builder("Parallelogram")
            .gravity_m_s2([0.0, 0.0, -9.81])
            .body(bar("inner", numbers.length), hinge("crank").motor(drive).start_angle_rad(angle))
            .body(bar("coupler", 0.5), hinge("elbow").on("inner").start_angle_rad(-angle))
            .body(
                bar("rocker", numbers.length),
                hinge("pivot").at_root([0.5, 0.0, 0.0]).latch(latch).start_angle_rad(angle),
            )
            .closure(Closure::between("pin", ["coupler", "rocker"], 1e5).damping_n_s_m(20.0))
            .mass("coupler", AttachedMass::point("load", 0.2, numbers.mass))
            .gauge(Gauge::on("root", "inner", 0.05))
            .solver(Solver { tolerance: 1e-12, ..solver() });
        build(builder)
    };
    let known = ["damping", "torque", "latch_angle", "start_angle", "length", "thickness", "density", "mass", "beta"];
    let places: Vec<Place> = PLACES.into_iter().filter(|place| known.contains(&place.0)).collect();
    // loads of sections, strains recovered from them and reactions in a loop are differences of large forces: without a latch, too, they
    // keep 4e-8
    let motions = |plant: &Plant| {
        let layout = *plant.outputs().layout();
        let loads = [layout.gauges.range(), layout.internal_loads.range(), layout.root.range()];
        let is_load = |index: usize| loads.iter().any(|range| range.contains(&index));
        let mut results = results(plant, &[2]);
        results.retain(|result| !matches!(result, RunResult::Output { index, .. } if is_load(*index)));
        results
    };
    for has_shear in [false, true] {
        let machine = |numbers: Numbers| machine(numbers, has_shear);
        let compared = compare_results(machine, &InputRows::default(), &places, motions);
        let Compared { forward_and_adjoint, differences, events } = compared;
        println!("GR-35 {has_shear}: {forward_and_adjoint:.1e} {differences:.1e}");
        assert_eq!(events, 1);
        // the masses of the loop in the impulse, a million times those of the machine, leave round-off of 1e-16 times a million, over a
        // thousandth of a length
        assert!(forward_and_adjoint < 1e-9, "{has_shear}: {forward_and_adjoint:.1e}");
        assert!(differences < 2e-6, "{has_shear}: {differences:.1e}");
    }
}

/// LP-06: the wing of GR-33 tied to the root by a loop with spring, damper and inertia: motions, reactions, latch time and the force of the
/// loop by thirteen numbers. Bounds of GR-35, whose impulses have the masses of a loop, too.
#[test]
fn gradients_with_a_loop_on_the_root() {
    let machine = |numbers: Numbers| {
        let tie = Closure::between("tie", ["inner", "root"], 60.0)
            .positions_m([0.15, 0.0])
            .offsets_m([[0.0; 3], [0.15, 0.0, 0.0]])
            .damping_n_s_m(0.5)
            .inertia_kg(0.02);
        build(numbers.builder(true).closure(tie)).map(hardened)
    };
    let with_force = |plant: &Plant| {
        let layout = *plant.outputs().layout();
        let loads = [layout.gauges.range(), layout.internal_loads.range(), layout.root.range()];
        let is_load = |index: usize| loads.iter().any(|range| range.contains(&index));
        let mut results = results(plant, &[1]);
        results.retain(|result| !matches!(result, RunResult::Output { index, .. } if is_load(*index)));
        results.push(RunResult::Output { index: layout.loops.place(0, 0) + 2, time: 1 });
        results
    };
    let compared = compare_results(machine, &InputRows::default(), &places(), with_force);
    let Compared { forward_and_adjoint, differences, .. } = compared;
    assert!(forward_and_adjoint < 1e-9, "{forward_and_adjoint:.1e}");
    assert!(differences < 2e-6, "{differences:.1e}");
}

/// GR-36: a lock that closes at a time on a joint that moves, a latch that closes beside it, a lock that opens, and a latch that opens and is
/// closed again on a joint within its range: each by an input.
#[test]
fn gradients_pass_through_locks_that_close() {
    let machine = |numbers: Numbers| build(numbers.builder(true)).map(hardened);
    let own = machine(Numbers::USUAL).unwrap_or_else(|error| panic!("{error}"));
    let plant = Plant::new(Arc::new(own));
    let layout = *plant.inputs().layout();
    let place = |joint: usize, offset: usize| layout.joints.place(joint, offset);
    let column = |index: usize, held: bool, values: [f64; 6]| InputColumn { index, held, values: values.to_vec() };
    let columns = vec![
        column(place(0, offset_of!(JointInputs, release)), true, [1.0, 0.0, 1.0, 1.0, 1.0, 1.0]),
        column(place(1, offset_of!(JointInputs, latch_enable)), true, [1.0, 1.0, 1.0, 0.0, 1.0, 1.0]),
        column(place(1, offset_of!(JointInputs, torque_n_m)), false, [0.0, 0.01, 0.02, -0.01, 0.0, 0.01]),
    ];
    let inputs = InputRows::new(vec![0.0, 0.053, 0.23, 0.27, 0.277, 0.5], columns);
    let inputs = inputs.unwrap_or_else(|error| panic!("{error}"));
    let places = places();
    let compared = compare_results(machine, &inputs, &places, |plant| results(plant, &[1]));
    assert_eq!(compared.events, 1);
    agree(&compared, 1e-6);
}

/// GR-37: an arm that turns freely and one that unfolds from its end, without any torque: angular momentum and energy are constant until a
/// rigid latch joins the two, the momentum behind it as well. Latch time, angle, rate, energy and impulse by eight numbers, in closed form
/// with one quadrature.
#[test]
fn a_rigid_latch_keeps_the_angular_momentum() {
    #[derive(Clone, Copy)]
    struct Arms {
        /// Inertias about the root and of the outer arm, mass, distance to the hinge and of the mass from it, rates, edge of the range.
        numbers: [f64; 8],
    }
    const USUAL: [f64; 8] = [0.05, 0.004, 0.6, 0.3, 0.25, 0.7, 2.0, 0.9];
    const START: f64 = -0.8;
    const END_S: f64 = 1.2;
    let plant = |Arms { numbers: [inner, outer, mass, arm, reach, spin, rate, edge] }: Arms| {
        let about_z = |inertia: f64| nalgebra::Matrix3::identity() * inertia;
        let hinge = |name: &str| Joint::revolute(name, [0.0, 0.0, 1.0]);
        let fold = hinge("fold")
            .on("inner")
            .offset_m([arm, 0.0, 0.0])
            .start_angle_rad(START)
            .start_rate_rad_s(rate)
            .latch(Latch::rigid().angle_rad(edge + 0.01).capture_rad(0.01));
        let machine = Machine::builder("Arms")
            .gravity_m_s2([0.0; 3])
            .body(Body::rigid("inner").inertia(1.0, [0.0; 3], about_z(inner)), hinge("shoulder").start_rate_rad_s(spin))
            .body(Body::rigid("outer").inertia(mass, [reach, 0.0, 0.0], about_z(outer)), fold)
            .solver(Solver { tolerance: 1e-11, ..Solver::default() })
            .build()
            .map_err(|refused| refused.to_string())?;
        Ok::<_, String>(Plant::new(Arc::new(machine)))
    };
    let known = |Arms { numbers: [inner, outer, mass, arm, reach, spin, rate, edge] }: Arms| -> [f64; 5] {
        let inertias = |angle: f64| {
            let across = mass * arm * reach * angle.cos();
            let outer = outer + mass * reach * reach;
            [inner + outer + mass * arm * arm + 2.0 * across, outer + across, outer]
        };
        let [whole, mixed, own] = inertias(START);
        let momentum = whole * spin + mixed * rate;
        let twice_energy = whole * spin * spin + 2.0 * mixed * spin * rate + own * rate * rate;
        // rates of the fold and of the root at an angle
        let rates = |angle: f64| {
            let [whole, mixed, own] = inertias(angle);
            let fold = ((twice_energy - momentum * momentum / whole) / (own - mixed * mixed / whole)).sqrt();
            [fold, (momentum - mixed * fold) / whole]
        };
        let intervals = 2000;
        let step = (edge - START) / f64::from(intervals);
        let (mut latch_s, mut turn) = (0.0, 0.0);
        for i in 0..=intervals {
            let simpson = if i == 0 || i == intervals { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
            let [fold, root] = rates(START + step * f64::from(i));
            latch_s += simpson * step / 3.0 / fold;
            turn += simpson * step / 3.0 * root / fold;
        }
        let ([whole, mixed, own], [fold, root]) = (inertias(edge), rates(edge));
        let behind = momentum / whole;
        let impulse = mixed * (behind - root) - own * fold;
        [latch_s, turn + behind * (END_S - latch_s), behind, 0.5 * momentum * behind, impulse]
    };
    let beside = |place: usize, shift: f64| {
        let mut numbers = USUAL;
        numbers[place] += shift;
        Arms { numbers }
    };
    let mut own = plant(Arms { numbers: USUAL }).unwrap_or_else(|error| panic!("{error}"));
    own.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    let tape = own.run_on_tape(&[END_S]).unwrap_or_else(|error| panic!("{error}"));
    let layout = *own.outputs().layout();
    let output = |index: usize| RunResult::Output { index, time: 0 };
    let results = [
        RunResult::LatchTime { joint: 1 },
        output(layout.joints.place(0, offset_of!(JointOutputs, angle_rad))),
        output(layout.joints.place(0, offset_of!(JointOutputs, rate_rad_s))),
        output(layout.energy.place(0, 0)),
        RunResult::Impulse { joint: 1 },
    ];
    let parameter = |place: usize| {
        Parameter::new("number", 0.0, 1e-3 * USUAL[place], |shift| plant(beside(place, shift)))
            .unwrap_or_else(|error| panic!("{error}"))
    };
    let parameters = (0..USUAL.len()).map(parameter).collect();
    let mut gradient = Gradient::new(&mut own, &tape, parameters).unwrap_or_else(|error| panic!("{error}"));
    let values = gradient.values(&results).unwrap_or_else(|error| panic!("{error}"));
    let forward = gradient.forward(&results).unwrap_or_else(|error| panic!("{error}"));
    let exact = known(Arms { numbers: USUAL });
    for (row, result) in results.iter().enumerate() {
        assert!(
            (values[row] - exact[row]).abs() < 1e-8 * exact[row].abs(),
            "{result:?}: {} {}",
            values[row],
            exact[row]
        );
        let adjoint = gradient.adjoint(*result).unwrap_or_else(|error| panic!("{error}"));
        let slope = |place: usize| {
            let step = 1e-3 * USUAL[place];
            let rule = [(-2.0, 1.0 / 12.0), (-1.0, -8.0 / 12.0), (1.0, 8.0 / 12.0), (2.0, -1.0 / 12.0)];
            rule.iter().map(|(steps, weight)| weight / step * known(beside(place, steps * step))[row]).sum::<f64>()
        };
        let slopes: Vec<f64> = (0..USUAL.len()).map(|place| slope(place) * USUAL[place]).collect();
        let scale = slopes.iter().fold(0.0f64, |most, slope| most.max(slope.abs()));
        for (place, slope) in slopes.iter().enumerate() {
            let [forward, adjoint] = [forward[row][place], adjoint[place]].map(|slope| slope * USUAL[place]);
            assert!((forward - adjoint).abs() < 1e-10 * scale, "{result:?} {place}: {forward} and {adjoint}");
            // the run's own error
            assert!((forward - slope).abs() < 1e-7 * scale, "{result:?} {place}: {forward} and {slope}");
        }
    }
}
