//! Gradients of machines with rigid loops, skates and wheels.

use super::folding::{agree, fold, without};
use super::*;
use crate::machine::builder::LatchBuilder;
use crate::machine::{Closure, NoSlip};
use crate::system::{JointOutputs, LoopOutputs, NoSlipOutputs};
use nalgebra::Matrix3;
use std::mem::offset_of;

/// A parallelogram of beams with a rigid loop, and a latch at its rocker.
fn parallelogram(numbers: Numbers, latch: LatchBuilder) -> Result<Machine, String> {
    let material = Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.2e9, density_kg_m3: numbers.density };
    let bar = |name: &str, length_m: f64| {
        Body::beam(name, length_m, Solid::rectangle(0.02, numbers.thickness, material))
            .elements(1)
            .stiffness_damping_s(numbers.beta)
    };
    let hinge = |name: &str| Joint::revolute(name, [0.0, 1.0, 0.0]);
    let angle = numbers.start_angle;
    let drive = Motor { constant_torque_n_m: -numbers.torque, damping_n_m_s_rad: numbers.damping, ..Motor::default() };
    // a fifth: the differences of runs over a shift of the latch have the truncation of stiff motions
    let latch = latch.angle_rad(0.2 * numbers.latch_angle + 1.44).capture_rad(0.01);
    let crank = hinge("crank").motor(drive).start_angle_rad(angle).start_rate_rad_s(0.3 * numbers.start_rate);
    Machine::builder("Parallelogram")
        .gravity_m_s2([0.0, 0.3, -9.81])
        .body(bar("inner", numbers.length), crank)
        .body(bar("coupler", 0.5), hinge("elbow").on("inner").start_angle_rad(-angle))
        .body(
            bar("rocker", numbers.length),
            hinge("pivot").at_root([0.5, 0.0, 0.0]).latch(latch).start_angle_rad(angle),
        )
        .closure(Closure::rigid("pin", ["coupler", "rocker"]))
        .mass("coupler", AttachedMass::point("load", 0.2, numbers.mass))
        .gauge(Gauge::on("root", "inner", 0.05))
        .solver(Solver { tolerance: 1e-12, ..solver() })
        .build()
        .map_err(|refused| refused.to_string())
}

/// Strain, tip, energy, a rate, the root's reaction and the force of the loop at two times, the mean of a strain and the dissipated energy,
/// and the time of the latch.
fn of_loop(plant: &Plant) -> Vec<RunResult> {
    let layout = *plant.outputs().layout();
    let indices = [
        layout.gauges.place(0, 0),
        layout.tips.place(1, 0) + 2,
        layout.energy.place(0, 0),
        layout.joints.place(0, offset_of!(JointOutputs, rate_rad_s)),
        layout.root.place(0, 0) + 3,
        layout.loops.place(0, offset_of!(LoopOutputs, force_n)),
        layout.loops.place(0, offset_of!(LoopOutputs, force_n)) + 2,
    ];
    let outputs = (0..2).flat_map(|time| indices.map(|index| RunResult::Output { index, time }));
    let [_, dissipated] = layout.accounts();
    let others = [
        RunResult::Mean { index: layout.gauges.place(0, 0), time: 1, square: false },
        RunResult::Mean { index: indices[6], time: 0, square: true },
        RunResult::Output { index: dissipated, time: 1 },
        RunResult::LatchTime { joint: 2 },
    ];
    outputs.chain(others).collect()
}

/// Step of the differences of runs of a linkage as a share of a number: over [`DIFFERENCE`] their truncation is 2e-6.
const OVER: f64 = 1e-4;

/// GR-112: a parallelogram of beams with a rigid loop, with an elastic and a rigid latch, in whose impulse the constraint acts: strains,
/// motions, reactions, the force of the loop, means, the dissipated energy and the latch time by eleven numbers. Forward and adjoint mode as in
/// GR-35: reactions are differences of large forces.
#[test]
fn gradients_with_a_rigid_loop() {
    let names = ["command", "stiffness", "stop", "load", "latch_stiffness"];
    let elastic =
        |numbers: Numbers| parallelogram(numbers, Latch::with_stiffness_n_m_rad(0.3 * numbers.latch_stiffness));
    let compared = compare_over(OVER, elastic, &InputRows::default(), &without(&names[..4]), of_loop);
    assert!(compared.events > 0);
    agree(&compared, 1e-9, "GR-112 elastic latch");
    let rigid = |numbers: Numbers| parallelogram(numbers, Latch::rigid());
    let compared = compare_over(OVER, rigid, &InputRows::default(), &without(&names), of_loop);
    assert_eq!(compared.events, 1);
    agree(&compared, 1e-9, "GR-112 rigid latch");
}

/// GR-114: of the side forces of two wheels on one axis only the sum is determined: each is an error as a result, as are the reactions of their
/// axles, while those of the nose wheel, normal forces and motions are results (GR-113).
#[test]
fn forces_of_redundant_constraints_are_refused() {
    let machine = sledge(Numbers::USUAL, true).unwrap_or_else(|error| panic!("{error}"));
    let mut plant = started(machine);
    let tape = plant.run_on_tape(&TIMES_S).unwrap_or_else(|error| panic!("{error}"));
    let layout = *plant.outputs().layout();
    let mut gradient = Gradient::new(&mut plant, &tape, Vec::new()).unwrap_or_else(|error| panic!("{error}"));
    let side = offset_of!(NoSlipOutputs, side_force_n);
    let rolling = offset_of!(NoSlipOutputs, rolling_force_n);
    let mut outcome = |index: usize| {
        let values = gradient.values(&[RunResult::Output { index, time: 0 }]);
        values.map(|_| ()).map_err(|refused| refused.to_string())
    };
    // the bodies: hull, arm, nose, port, starboard
    let reaction = |body: usize| layout.joint_reactions.place(body, 0);
    for index in [layout.no_slips.place(1, side), layout.no_slips.place(2, side), reaction(3), reaction(4)] {
        let refused = outcome(index).expect_err("not determined");
        assert!(refused.contains("only sums are determined; choose motions"), "{index}: {refused}");
    }
    for index in [
        layout.no_slips.place(0, side),
        layout.no_slips.place(1, rolling),
        layout.no_slips.place(2, offset_of!(NoSlipOutputs, normal_force_n)),
        layout.tips.place(0, 0),
        layout.root.place(0, 0),
    ] {
        assert_eq!(outcome(index), Ok(()), "{index}");
    }
}

/// A hull on a plane with an arm that folds: on a skate, or on three wheels.
fn sledge(numbers: Numbers, wheels: bool) -> Result<Machine, String> {
    let inertia = Matrix3::from_diagonal(&nalgebra::Vector3::new(2e-3, 3e-3, 4e-3));
    let hull = Body::rigid("hull").inertia(0.4, [0.02, 0.01, -0.03], inertia);
    let free = Joint::free("travel")
        .at_root([0.0, 0.0, 0.1])
        .start_velocity_m_s([0.0, 2.0 + numbers.start_rate, 0.0])
        .start_angular_velocity_rad_s([0.0, 0.0, if wheels { 0.0 } else { 1.5 + numbers.start_rate }]);
    let material = Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.2e9, density_kg_m3: numbers.density };
    let arm = Body::beam("outer", numbers.length, Solid::rectangle(0.05, numbers.thickness, material))
        .elements(2)
        .stiffness_damping_s(numbers.beta)
        .load_stations(1);
    let wrench = crate::load::Wrench { force_n: [0.0, 0.0, 0.3 * numbers.load].into(), ..Default::default() };
    let mut machine = Machine::builder("Sledge")
        .gravity_m_s2([0.0, 0.0, -9.81])
        .body(hull, free)
        .body(arm, fold(numbers, "hull"))
        .mass("outer", AttachedMass::point("tip", numbers.length, numbers.mass))
        .load("pull", "outer", 1, wrench)
        .gauge(Gauge::on("root", "outer", 0.05))
        .solver(Solver { tolerance: 1e-12, ..solver() });
    let places = [("nose", [0.0, 0.3, 0.0]), ("port", [-0.2, -0.1, 0.0]), ("starboard", [0.2, -0.1, 0.0])];
    for (name, at_m) in places.into_iter().filter(|_| wheels) {
        let inertia = Matrix3::from_diagonal(&nalgebra::Vector3::new(6e-4, 3e-4, 3e-4));
        let disc = Body::rigid(name).inertia(0.5 * numbers.mass, [0.0; 3], inertia);
        let axle = Joint::revolute(format!("{name}_axle"), [1.0, 0.0, 0.0]).on("hull").offset_m(at_m);
        let rim = NoSlip::wheel(format!("{name}_rim"), name, [1.0, 0.0, 0.0], 0.1).plane([0.0, 0.0, 1.0], [0.0; 3]);
        machine = machine
            .body(disc, axle.start_rate_rad_s(-10.0 * (2.0 + numbers.start_rate)))
            .no_slip(rim.rolling(name != "port"));
    }
    if !wheels {
        let blade = NoSlip::skate("blade", "hull", [0.0, 1.0, 0.0]).offset_m([0.0, -0.1 * numbers.start_angle, -0.1]);
        machine = machine.no_slip(blade.plane([0.0, 0.0, 1.0], [0.0; 3]));
    }
    machine.build().map_err(|refused| refused.to_string())
}

/// GR-113: a hull on a skate, and one on three wheels of which two roll, with a beam that folds onto a latch: strain, motions, energy, the
/// forces of the plane and the latch time by thirteen numbers.
#[test]
fn gradients_on_skates_and_wheels() {
    let results = |plant: &Plant| {
        let layout = *plant.outputs().layout();
        let indices = [
            layout.gauges.place(0, 0),
            layout.tips.place(0, 0) + 1,
            layout.tips.place(0, 0),
            layout.energy.place(0, 0),
            layout.joints.place(0, offset_of!(JointOutputs, rate_rad_s)),
            layout.no_slips.place(0, offset_of!(NoSlipOutputs, side_force_n)),
            layout.no_slips.place(0, offset_of!(NoSlipOutputs, normal_force_n)),
        ];
        let outputs = (0..2).flat_map(|time| indices.map(|index| RunResult::Output { index, time }));
        outputs.chain([RunResult::LatchTime { joint: 0 }]).collect()
    };
    let places = without(&["stop", "command"]);
    for wheels in [false, true] {
        let compared = compare_results(|numbers| sledge(numbers, wheels), &InputRows::default(), &places, results);
        assert!(compared.events > 0);
        agree(&compared, 1e-10, if wheels { "GR-113 wheels" } else { "GR-113 skate" });
    }
}
