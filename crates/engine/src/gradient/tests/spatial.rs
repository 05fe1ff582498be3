//! Gradients of machines with universal, ball and free joints.

use super::folding::{agree, flap, fold, hold, without};
use super::rigid::hardened;
use super::*;
use crate::load::RootMotion;
use crate::machine::SpatialFreedom;
use crate::machine::builder::BodyBuilder;
use crate::system::{JointOutputs, SpatialOutputs};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::mem::offset_of;

fn beam(numbers: Numbers, name: &str, length_m: f64) -> BodyBuilder {
    let material = Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.2e9, density_kg_m3: numbers.density };
    Body::beam(name, length_m, Solid::rectangle(0.05, numbers.thickness, material))
        .elements(2)
        .mass_damping_1_s(500.0 * numbers.beta)
        .stiffness_damping_s(numbers.beta)
        .load_stations(1)
}

/// An attitude that varies with the start angle.
fn mount(numbers: Numbers) -> Matrix3<f64> {
    Rotation3::new(Vector3::new(0.3, -0.5, 0.2) * numbers.start_angle).into_inner()
}

fn builder(numbers: Numbers) -> MachineBuilder {
    let wrench = crate::load::Wrench { force_n: [0.0, 0.0, numbers.load].into(), ..Default::default() };
    Machine::builder("Spatial")
        .gravity_m_s2([0.0, 0.5, -9.81])
        .load("pull", "inner", 1, wrench)
        .gauge(Gauge::on("root", "inner", 0.05))
        // reactions contain the remainder of the iteration
        .solver(Solver { tolerance: 1e-12, ..solver() })
}

/// A hull in free flight with a folding wing, whose bodies have mass-proportional damping relative to the hull.
fn flying(numbers: Numbers) -> Result<Machine, String> {
    let hull = Body::rigid("hull").inertia(0.4, [0.02, 0.01, -0.03], Matrix3::identity() * 2e-3);
    let rate = numbers.start_rate;
    let free = Joint::free("flight")
        .at_root([0.1, 0.2, 0.3])
        .mount(mount(numbers))
        .start_velocity_m_s([4.0, -rate, 0.2])
        .start_angular_velocity_rad_s([3.0 * rate, 2.0, -1.5]);
    builder(numbers)
        .body(hull, free)
        .body(beam(numbers, "inner", numbers.length), Joint::clamped("shoulder").on("hull").offset_m([0.05, 0.0, 0.02]))
        .body(beam(numbers, "outer", 0.3).damp_attached_masses(true), fold(numbers, "inner"))
        .mass("outer", AttachedMass::point("tip", 0.3, numbers.mass))
        .build()
        .map_err(|refused| refused.to_string())
}

/// A folding wing on a ball joint.
fn swinging(numbers: Numbers) -> Result<Machine, String> {
    let ball = Joint::ball("hook").mount(mount(numbers)).motor(hold(numbers)).start_angular_velocity_rad_s([
        numbers.start_rate,
        1.0,
        -0.7,
    ]);
    builder(numbers)
        .body(beam(numbers, "inner", numbers.length), ball)
        .body(beam(numbers, "outer", 0.3), fold(numbers, "inner"))
        .mass("outer", AttachedMass::point("tip", 0.3, numbers.mass))
        .build()
        .map_err(|refused| refused.to_string())
}

/// A beam on a hinge, another one on a universal joint at its end, with axes that are not at right angles, and a folding arm.
fn jointed(numbers: Numbers) -> Result<Machine, String> {
    // the attitude turns about the first axis: the angle between the axes stays
    let axis = Vector3::new(0.0, 1.0, 0.2);
    let mount = Rotation3::new(axis * 0.2 * numbers.start_angle) * Rotation3::new(Vector3::new(0.2, -0.1, 0.1));
    let cardan = Joint::universal("cardan", axis, [0.3, 0.1, 1.0])
        .on("inner")
        .offset_m([0.01, 0.02, 0.0])
        .mount(mount.into_inner())
        .motor(hold(numbers));
    builder(numbers)
        .body(beam(numbers, "inner", numbers.length), flap())
        .body(beam(numbers, "middle", 0.3), cardan)
        .body(
            Body::rigid("outer").inertia(numbers.mass, [0.1, 0.0, 0.01], Matrix3::identity() * 1e-3),
            fold(numbers, "middle"),
        )
        .build()
        .map_err(|refused| refused.to_string())
}

/// Motions, strains, reactions (in free flight there is none on the root) and energies at both times, and the latch time of a joint.
fn results(plant: &Plant, latch: Option<usize>) -> Vec<RunResult> {
    let layout = *plant.outputs().layout();
    let spatial = |offset: usize, entry: usize| layout.spatial.place(0, offset) + entry;
    let indices = [
        layout.gauges.place(0, 0),
        layout.tips.place(0, 0) + 2,
        layout.energy.place(0, 0),
        layout.joints.place(0, offset_of!(JointOutputs, rate_rad_s)),
        spatial(offset_of!(SpatialOutputs, rotation), 0),
        spatial(offset_of!(SpatialOutputs, rotation), 2),
        spatial(offset_of!(SpatialOutputs, angular_velocity_rad_s), 1),
        layout.root.place(0, 0) + 2,
    ];
    let flies = plant.machine().spatials().any(|(_, joint)| joint.freedom == SpatialFreedom::Free);
    let indices = &indices[..indices.len() - usize::from(flies)];
    let outputs = (0..2).flat_map(|time| indices.iter().map(move |index| RunResult::Output { index: *index, time }));
    outputs.chain(latch.map(|joint| RunResult::LatchTime { joint })).collect()
}

/// GR-58: a wing in free flight, with start velocities and attitude as parameters, through an elastic and through a rigid latch.
#[test]
fn gradients_of_free_flight() {
    let places = without(&["stop", "command"]);
    let compared = compare_results(flying, &InputRows::default(), &places, |plant| results(plant, Some(0)));
    assert!(compared.events > 0, "no event");
    agree(&compared, 1e-9, "free flight, elastic latch");
    let rigid = |numbers: Numbers| flying(numbers).map(|machine| stiffened(machine, 2));
    let places = without(&["stop", "command", "latch_stiffness"]);
    let compared = compare_results(rigid, &InputRows::default(), &places, |plant| results(plant, Some(0)));
    assert!(compared.events > 0, "no event");
    agree(&compared, 1e-9, "free flight, rigid latch");
}

/// The latch of the joint of a body made rigid.
fn stiffened(mut machine: Machine, body: usize) -> Machine {
    machine.bodies.swap(1, body);
    let mut machine = hardened(machine);
    machine.bodies.swap(1, body);
    machine
}

/// GR-59: a folding wing on a ball joint with spring and damper, through an elastic and through a rigid latch.
#[test]
fn gradients_of_a_ball_joint() {
    let places = without(&["stop", "command"]);
    let compared = compare_results(swinging, &InputRows::default(), &places, |plant| results(plant, Some(0)));
    assert!(compared.events > 0, "no event");
    agree(&compared, 1e-9, "ball joint, elastic latch");
    let rigid = |numbers: Numbers| swinging(numbers).map(hardened);
    let places = without(&["stop", "command", "latch_stiffness"]);
    let compared = compare_results(rigid, &InputRows::default(), &places, |plant| results(plant, Some(0)));
    assert!(compared.events > 0, "no event");
    agree(&compared, 1e-9, "ball joint, rigid latch");
}

/// GR-60: a universal joint between two beams, through an elastic and through a rigid latch.
#[test]
fn gradients_of_a_universal_joint() {
    let places = without(&["stop", "command"]);
    let compared = compare_results(jointed, &InputRows::default(), &places, |plant| results(plant, Some(1)));
    assert!(compared.events > 0, "no event");
    agree(&compared, 1e-9, "universal joint, elastic latch");
    let rigid = |numbers: Numbers| jointed(numbers).map(|machine| stiffened(machine, 2));
    let places = without(&["stop", "command", "latch_stiffness"]);
    let compared = compare_results(rigid, &InputRows::default(), &places, |plant| results(plant, Some(1)));
    assert!(compared.events > 0, "no event");
    agree(&compared, 1e-9, "universal joint, rigid latch");
}

/// GR-61: from static equilibrium, a ball joint's and a universal joint's, against the load.
#[test]
fn spatial_joints_start_in_equilibrium() {
    let places = without(&["stop", "command", "latch_stiffness", "latch_angle", "start_rate"]);
    let settled = |machine: Result<Machine, String>| {
        let mut machine = machine?;
        for body in &mut machine.bodies {
            match &mut body.joint.kind {
                JointKind::Spatial(joint) => joint.start_angular_velocity_rad_s = Vector3::zeros(),
                JointKind::Revolute(fold) if fold.latch.is_some() => {
                    (fold.latch, fold.start_rate_rad_s) = (None, 0.0);
                    fold.spring = Some(Spring { stiffness_n_m_rad: 2.0, ..Spring::default() });
                }
                JointKind::Revolute(_) | JointKind::Clamped | JointKind::Prismatic(_) | JointKind::Sliding(_) => {}
            }
        }
        machine.experiment.start = StartState::Equilibrium;
        Ok(machine)
    };
    let results = |plant: &Plant| {
        let mut results = results(plant, None);
        // rates and energies stay zero in equilibrium
        let layout = *plant.outputs().layout();
        let spin = layout.spatial.place(0, offset_of!(SpatialOutputs, angular_velocity_rad_s)) + 1;
        let still = [layout.energy.place(0, 0), layout.joints.place(0, offset_of!(JointOutputs, rate_rad_s)), spin];
        results.retain(|result| !matches!(result, RunResult::Output { index, .. } if still.contains(index)));
        results
    };
    let ball = |numbers: Numbers| settled(swinging(Numbers { stiffness: 3.0 * numbers.stiffness, ..numbers }));
    agree(&compare_results(ball, &InputRows::default(), &places, results), 1e-9, "ball, equilibrium");
    let universal = |numbers: Numbers| settled(jointed(Numbers { stiffness: 3.0 * numbers.stiffness, ..numbers }));
    agree(&compare_results(universal, &InputRows::default(), &places, results), 1e-9, "universal, equilibrium");
}

/// GR-62: energy accounts and means of all three machines, through the latch.
#[test]
#[ignore = "long; `make long` runs it"]
fn accounts_and_means_of_spatial_joints() {
    let places = [PLACES[1], PLACES[4], PLACES[7], PLACES[8], PLACES[9], PLACES[12], PLACES[13]];
    let wanted = |plant: &Plant| {
        let layout = *plant.outputs().layout();
        let accounts = layout.accounts().map(|index| RunResult::Output { index, time: 1 });
        let (gauge, turn) =
            (layout.gauges.place(0, 0), layout.spatial.place(0, offset_of!(SpatialOutputs, rotation)) + 1);
        let mean = |index: usize, square: bool| RunResult::Mean { index, time: 1, square };
        accounts.into_iter().chain([mean(gauge, true), mean(turn, false)]).collect::<Vec<RunResult>>()
    };
    type Make = fn(Numbers) -> Result<Machine, String>;
    let machines: [(&str, Make); 3] = [("free", flying), ("ball", swinging), ("universal", jointed)];
    for (words, machine) in machines {
        agree(
            &compare_results(machine, &InputRows::default(), &places, wanted),
            1e-9,
            &format!("{words}, accounts and means"),
        );
    }
}

/// GR-63: an attitude at a third of a turn, at which the Euler parameters of neighbouring machines have opposite signs, has the slopes of the
/// same machine turned a little further, to first order in the turn.
#[test]
fn a_third_of_a_turn_has_a_slope() {
    let slope = |further_rad: f64| {
        let machine = |shift: f64| {
            let turn = Rotation3::new(Vector3::new(0.0, 0.0, -2.0 * PI / 3.0 + further_rad + shift)).into_inner();
            let ball = Joint::ball("hook").mount(turn).start_angular_velocity_rad_s([0.5, 1.0, -0.7]);
            builder(Numbers::USUAL)
                .body(beam(Numbers::USUAL, "inner", 0.4), ball)
                .build()
                .map_err(|refused| refused.to_string())
        };
        let mut plant = started(machine(0.0).unwrap_or_else(|error| panic!("{error}")));
        let tape = plant.run_on_tape(&[0.1]).unwrap_or_else(|error| panic!("{error}"));
        let parameter = Parameter::new("turn", 0.0, 1e-3, |shift| plant_of(machine(shift)));
        let parameter = parameter.unwrap_or_else(|error| panic!("{error}"));
        let index = plant.outputs().layout().tips.place(0, 0) + 1;
        let mut gradient = Gradient::new(&mut plant, &tape, vec![parameter]).unwrap_or_else(|error| panic!("{error}"));
        gradient.adjoint(RunResult::Output { index, time: 0 }).unwrap_or_else(|error| panic!("{error}"))[0]
    };
    let [at, beyond] = [0.0, 1e-2].map(slope);
    assert!((at - beyond).abs() < 0.05 * at.abs() && at.abs() > 0.1, "{at} and {beyond}");
}

/// GR-67: a parameter that changes the angle between the axes of a universal joint is rejected by name: the constraints depend on it.
#[test]
fn axes_of_universal_joints_are_no_parameters() {
    let machine = |shift: f64| {
        let cardan = Joint::universal("cardan", [0.0, 1.0, 0.2 + shift], [0.3, 0.1, 1.0]).motor(hold(Numbers::USUAL));
        builder(Numbers::USUAL)
            .body(beam(Numbers::USUAL, "inner", 0.4), cardan)
            .build()
            .map_err(|refused| refused.to_string())
    };
    let mut plant = started(machine(0.0).unwrap_or_else(|error| panic!("{error}")));
    let tape = plant.run_on_tape(&[0.02]).unwrap_or_else(|error| panic!("{error}"));
    let parameter = Parameter::new("axis", 0.0, 1e-3, |shift| plant_of(machine(shift)));
    let parameter = parameter.unwrap_or_else(|error| panic!("{error}"));
    let outcome = Gradient::new(&mut plant, &tape, vec![parameter]).map(|_| ()).expect_err("other axes");
    assert!(
        outcome.to_string().contains("parameter axis changes the angle between the axes of a universal joint"),
        "{outcome}"
    );
}

/// GR-108: on a root whose rotation and acceleration vary, through an elastic and a rigid latch: a ball joint, a free one, a universal one.
#[test]
fn gradients_on_a_root_that_turns_and_accelerates() {
    type Built = fn(Numbers) -> Result<Machine, String>;
    let all: [(Built, usize, &str); 4] = [
        (swinging, 0, "ball"),
        (|numbers| swinging(numbers).map(hardened), 0, "ball, rigid latch"),
        (flying, 0, "free"),
        (jointed, 1, "universal"),
    ];
    for (machine, joint, words) in all {
        let layout =
            *Plant::new(Arc::new(machine(Numbers::USUAL).unwrap_or_else(|error| panic!("{error}")))).inputs().layout();
        let column = |offset: usize, values: [f64; 4]| InputColumn {
            index: layout.root.place(0, offset) + 1,
            held: false,
            values: values.to_vec(),
        };
        let columns = vec![
            column(offset_of!(RootMotion, angular_velocity_rad_s), [0.0, 0.4, -0.3, 0.6]),
            column(offset_of!(RootMotion, acceleration_m_s2), [0.0, 2.0, -1.0, 1.0]),
        ];
        let inputs = InputRows::new(vec![-0.1, 0.05, 0.12, 0.6], columns).unwrap_or_else(|error| panic!("{error}"));
        let places = without(&["stop", "command"]);
        let compared = compare_over(1e-4, machine, &inputs, &places, |plant| results(plant, Some(joint)));
        assert!(compared.events > 0, "{words}: no event");
        agree(&compared, 1e-9, words);
    }
}
