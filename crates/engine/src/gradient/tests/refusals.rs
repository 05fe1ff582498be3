//! Parts, events and results without a derivative are errors by name.

use super::*;
use crate::aero::flow::GustShape;
use crate::aero::surface::Profile;
use crate::machine::builder::{AirBuilder, GustBuilder};

/// The usual wing with a change; the text of the error.
fn refused(change: impl FnOnce(&mut Machine)) -> String {
    let mut machine = Numbers::USUAL.machine(true).unwrap_or_else(|error| panic!("{error}"));
    change(&mut machine);
    let mut plant = started(machine);
    match plant.run_on_tape(&[0.2]) {
        Ok(tape) => panic!("{} steps", tape.steps()),
        Err(error) => error.to_string(),
    }
}

pub(super) fn fold(machine: &mut Machine) -> &mut OneFreedom {
    match &mut machine.bodies[1].joint.kind {
        JointKind::Revolute(fold) => fold,
        JointKind::Clamped | JointKind::Prismatic(_) | JointKind::Sliding(_) | JointKind::Spatial(_) => {
            panic!("no fold joint")
        }
    }
}

/// Parts and settings without exact derivatives are errors by name.
#[test]
fn what_is_not_covered_is_refused_by_name() {
    type Case = (&'static str, fn(&mut Machine));
    let cases: [Case; 3] = [
        ("runs in which a generator passes the first row of its table, where its torque jumps (fold)", |machine| {
            fold(machine).generator = Some(GeneratorLaw {
                // the wing folds with a negative rate, from 0.3 rad/s on
                gear_ratio: -1.0,
                rows: vec![[1.0, 0.1], [2.0, 0.2]],
                square_gain_n_m_s2: Some(0.05),
                beyond: Beyond::Torque,
                efficiency: 1.0,
                connected: true,
            });
        }),
        ("real-time mode", |machine| machine.solver.most_iterations = Some(2)),
        ("the methods generalized_alpha and rk4", |machine| machine.solver.method = Method::GeneralizedAlpha),
    ];
    for (words, change) in cases {
        let message = refused(change);
        assert!(message.contains(words), "{message} instead of {words}");
    }
}

/// A lattice, and inputs that differ from the machine's are errors by name.
#[test]
fn machines_that_are_not_covered_are_refused_by_name() {
    let plate =
        Solid::rectangle(0.05, 0.004, Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.2e9, density_kg_m3: 1e3 });
    let wing = || Body::beam("wing", 0.4, plate).elements(1);
    let clamped = || Machine::builder("Wing").body(wing(), Joint::clamped("mount"));
    let air = clamped()
        .air(Air::lattice().density_kg_m3(1.2).wind_m_s([0.0, -5.0, 0.0]))
        .surface(LiftingSurface::on("wing", 2).chord_m(Along::constant(0.1)));
    let machine = air.build().unwrap_or_else(|error| panic!("{error}"));
    let outcome = started(machine).run_on_tape(&[0.01]).map(|_| ()).expect_err("a lattice");
    assert!(outcome.to_string().contains("the vortex lattice (aerodynamics)"), "{outcome}");
    let mut plant = started(clamped().build().unwrap_or_else(|error| panic!("{error}")));
    plant.inputs_mut().root_mut().gravity_m_s2.z = -1.0;
    let outcome = plant.run_on_tape(&[0.01]).map(|_| ()).expect_err("another gravity");
    let expected =
        "gradients do not cover inputs or parameters that changed after the initialisation; initialise the model again";
    assert_eq!(outcome.to_string(), expected);
}

/// Air whose steps have no derivatives, rows of inputs within aerodynamic steps, and results that are not covered there, are errors by name.
#[test]
fn air_that_is_not_covered_is_refused_by_name() {
    let plate =
        Solid::rectangle(0.05, 0.004, Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.2e9, density_kg_m3: 1e3 });
    let wing = |air: AirBuilder, profile: Profile| {
        Machine::builder("Wing")
            .body(Body::beam("wing", 0.4, plate).elements(1), Joint::clamped("mount"))
            .air(air.density_kg_m3(1.2).wind_m_s([0.0, -5.0, 0.0]).step_s(4e-3))
            .surface(LiftingSurface::on("wing", 2).chord_m(Along::constant(0.1)).profile(profile))
    };
    let build = |builder: MachineBuilder| builder.build().unwrap_or_else(|error| panic!("{error}"));
    let gust = GustBuilder::new("front", GustShape::SharpEdge, [0.0, 0.0, 1.0]);
    let words = "gusts with jumps or kinks, all but one_minus_cosine (front)";
    let outcome = started(build(wing(Air::strips(), Profile::THIN).gust(gust))).run_on_tape(&[0.01]);
    let error = outcome.map(|_| ()).expect_err(words).to_string();
    assert!(error.contains(words), "{error} instead of {words}");
    let machine = build(wing(Air::strips().reports_circulation(true), Profile::THIN));
    let mut plant = started(machine.clone());
    let index = plant.inputs().layout().stations.range().start;
    let column = InputColumn { index, held: false, values: vec![0.0; 2] };
    let rows =
        |row_s: f64| InputRows::new(vec![0.0, row_s], vec![column.clone()]).unwrap_or_else(|error| panic!("{error}"));
    let outcome = plant.run_on_tape_with(&rows(0.009), &[0.01]).map(|_| ()).expect_err("a row within a step");
    let expected = "gradients do not cover rows of the inputs within aerodynamic steps; move the row at 0.009 s to a multiple of \
                    aerodynamics.step_s = 0.004 s after the start";
    assert_eq!(outcome.to_string(), expected);
    for (row_s, covered) in [(0.008, true), (0.01, false), (0.012, true), (0.013, true)] {
        let outcome = started(machine.clone()).run_on_tape_with(&rows(row_s), &[0.01]).map(|_| ());
        assert_eq!(outcome.is_ok(), covered, "a row at {row_s} s: {outcome:?}");
    }
    let mut plant = started(machine.clone());
    let tape = plant.run_on_tape(&[0.0, 0.01]).unwrap_or_else(|error| panic!("{error}"));
    let layout = *plant.outputs().layout();
    let gradient = Gradient::new(&mut plant, &tape, Vec::new()).unwrap_or_else(|error| panic!("{error}"));
    let of = |index: usize, time: usize| gradient.check_output(index, time).expect_err("no number").to_string();
    assert!(of(layout.tips.place(0, 0), 0).contains("results at the start of a run with aerodynamics"));
    assert!(of(layout.circulation_m2_s.place(0, 0), 1).contains("circulations and control surfaces as results"));
    let stepped = |shift: f64| {
        let mut machine = machine.clone();
        machine.air.as_mut().expect("air").step_s += shift;
        plant_of(Ok(machine))
    };
    let parameter = Parameter::new("step", 0.0, 1e-6, stepped).unwrap_or_else(|error| panic!("{error}"));
    let outcome = Gradient::new(&mut plant, &tape, vec![parameter]).map(|_| ());
    assert!(matches!(outcome, Err(GradientError::Structure { what: "the aerodynamic step", .. })));
}

/// A wing at rest in air at rest: the direction of its lift by a small velocity is that of the velocity, without a derivative.
#[test]
fn strips_that_meet_no_air_are_refused() {
    let still = |density_kg_m3: f64| {
        let material = Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.2e9, density_kg_m3: 1e3 };
        let body = Body::beam("plate", 0.4, Solid::rectangle(0.05, 0.004, material)).elements(1);
        let air = Air::strips().density_kg_m3(density_kg_m3).wind_m_s([0.0; 3]).step_s(4e-3);
        let builder = Machine::builder("Still").gravity_m_s2([0.0; 3]).body(body, Joint::clamped("mount")).air(air);
        let surface = LiftingSurface::on("plate", 2).chord_m(Along::constant(0.1));
        let machine = builder.surface(surface).build().map_err(|error| error.to_string())?;
        Ok::<_, String>(Plant::new(Arc::new(machine)))
    };
    let mut plant = still(1.2).unwrap_or_else(|error| panic!("{error}"));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    let tape = plant.run_on_tape(&[0.01]).unwrap_or_else(|error| panic!("{error}"));
    let index = plant.outputs().layout().tips.place(0, 0);
    let parameter = Parameter::new("density", 1.2, 1e-3, still).unwrap_or_else(|error| panic!("{error}"));
    let mut gradient = Gradient::new(&mut plant, &tape, vec![parameter]).unwrap_or_else(|error| panic!("{error}"));
    let result = RunResult::Output { index, time: 0 };
    let words = "strips without relative flow (plate)";
    for outcome in [gradient.forward(&[result]).map(|_| ()), gradient.adjoint(result).map(|_| ())] {
        let error = outcome.expect_err("no slope").to_string();
        assert!(error.contains(words), "{error}");
    }
}

/// A joint that only touches its capture range has no derivative of the instant: an error, never a number. The start rate is bisected until
/// the joint turns around at the range's edge, at the end of a step, where the search for crossings finds it.
#[test]
fn grazing_is_refused() {
    let run = |rate: f64| {
        let arm =
            AttachedMass { inertia_kg_m2: nalgebra::Matrix3::identity(), ..AttachedMass::point("mass", 0.0, 1.0) };
        let latch = Latch::with_stiffness_n_m_rad(10.0).angle_rad(0.5).capture_rad(0.01);
        let drive = Motor { stiffness_n_m_rad: 4.0, ..Motor::default() };
        let machine = Machine::builder("Swing")
            .body(
                Body::rigid("arm"),
                Joint::revolute("hinge", [0.0, 0.0, 1.0]).motor(drive).latch(latch).start_rate_rad_s(rate),
            )
            .mass("arm", arm)
            .solver(Solver { tolerance: 1e-8, fixed_step_s: Some(PI / 200.0), ..Solver::default() })
            .build()
            .unwrap_or_else(|error| panic!("{error}"));
        started(machine).run_on_tape(&[FRAC_PI_2])
    };
    let (mut low, mut high) = (0.9, 1.1);
    let mut grazed = false;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match run(middle) {
            Err(GradientError::Grazing { .. }) => {
                grazed = true;
                break;
            }
            Err(error) => panic!("{error}"),
            Ok(tape) if tape.steps.iter().any(|step| matches!(step.ending, Ending::Crossing(_))) => high = middle,
            Ok(_) => low = middle,
        }
    }
    assert!(grazed, "between {low} and {high}");
}

/// Two wings that latch at the same instant are an error.
#[test]
fn simultaneous_crossings_are_refused() {
    let mut builder = Machine::builder("Pair");
    for name in ["left", "right"] {
        let arm = AttachedMass { inertia_kg_m2: nalgebra::Matrix3::identity(), ..AttachedMass::point(name, 0.0, 1.0) };
        let latch = Latch::with_stiffness_n_m_rad(10.0).angle_rad(0.5).capture_rad(0.01);
        let hinge = Joint::revolute(format!("{name}_hinge"), [0.0, 0.0, 1.0]).latch(latch).start_rate_rad_s(1.0);
        builder = builder.body(Body::rigid(name), hinge).mass(name, arm);
    }
    let machine = builder.build().unwrap_or_else(|error| panic!("{error}"));
    let outcome = started(machine).run_on_tape(&[1.0]);
    assert!(
        matches!(&outcome, Err(GradientError::Simultaneous { first, second, .. }) if first == "left_hinge" && second == "right_hinge")
    );
}

/// Times out of order, results that do not exist, and parameters that change the mesh or the start are errors.
#[test]
fn questions_without_an_answer_are_refused() {
    let machine = |numbers: Numbers| numbers.machine(true);
    let mut plant = started(machine(Numbers::USUAL).unwrap_or_else(|error| panic!("{error}")));
    assert!(matches!(plant.run_on_tape(&[0.02, 0.01]), Err(GradientError::Times { .. })));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    let tape = plant.run_on_tape(&[0.02]).unwrap_or_else(|error| panic!("{error}"));
    let continued = plant.run_on_tape(&[0.04]).map(|_| ()).expect_err("a run that continues another");
    assert_eq!(
        continued.to_string(),
        "gradients do not cover runs that continue an earlier run; initialise the model first"
    );
    let layout = *plant.outputs().layout();
    let parameter = Parameter::new("start", 0.0, 1e-3, |shift| plant_of(machine(beside(PLACES[7], shift))));
    let parameter = parameter.unwrap_or_else(|error| panic!("{error}"));
    let latch = layout.latches.place(0, 0);
    {
        let mut gradient = Gradient::new(&mut plant, &tape, vec![parameter]).unwrap_or_else(|error| panic!("{error}"));
        let refusal = |result| gradient.seed(result).map(|_| ()).expect_err("no number");
        let refusals = [
            RunResult::LatchTime { joint: 1 },
            RunResult::Output { index: 0, time: 1 },
            RunResult::Output { index: latch, time: 0 },
        ]
        .map(refusal);
        assert!(
            matches!(refusals[0], GradientError::Absent { .. }) && matches!(refusals[1], GradientError::Absent { .. })
        );
        assert_eq!(
            refusals[2].to_string(),
            "gradients do not cover outputs that change at events only, such as latch times; choose the latch time of the joint as the result"
        );
    }
    // a thousandth of it decides whether the wing starts latched
    let latched = Parameter::new("start", 0.0, 0.6, |shift| plant_of(machine(beside(PLACES[7], shift))));
    let latched = latched.unwrap_or_else(|error| panic!("{error}"));
    let outcome = Gradient::new(&mut plant, &tape, vec![latched]).map(|_| ());
    assert!(matches!(outcome, Err(GradientError::Structure { .. })));
}
