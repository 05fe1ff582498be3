//! Meaning of accepted files: units, defaults, order.

use crate::model_file::{MODEL, repository, with};
use approx::assert_relative_eq;
use foldwing::config;
use foldwing::load::LoadFrame;
use foldwing::machine::Machine;
use foldwing::machine::{ElementKind, JointKind, JointMotion, Method, Motion, Parent, Revolute, StartState, UNLIMITED};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

fn accepted(text: &str) -> Machine {
    config::parse(text, "wing.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn shipped(name: &str) -> Machine {
    config::read(repository().join("examples/models").join(name)).unwrap_or_else(|error| panic!("{error}")).0
}

fn names(machine: &Machine) -> Vec<&str> {
    machine.bodies.iter().map(|body| body.name.as_str()).collect()
}

fn revolute<'m>(machine: &'m Machine, joint: &str) -> &'m Revolute {
    let body = machine.bodies.iter().find(|body| body.joint.name == joint).unwrap();
    match &body.joint.kind {
        JointKind::Revolute(revolute) => revolute,
        _ => panic!("{joint} is not revolute"),
    }
}

/// \[O\] Table 5: two equal plates, the actuator at the joint, defaults elsewhere.
#[test]
fn the_shipped_wing_has_the_plates_of_the_paper() {
    let machine = shipped("folding_wing.toml");
    assert_eq!((machine.name.as_str(), names(&machine)), ("FoldingWing", vec!["inner", "outer"]));
    assert_eq!(machine.gravity_m_s2, Vector3::new(-9.8, 0.0, 0.0));
    let bending_n_m2 = 2.83e9 * 0.05 * 0.002_f64.powi(3) / 12.0;
    for body in &machine.bodies {
        assert_eq!((body.length_m, body.element, body.elements), (0.15, ElementKind::Linear, 4));
        assert_eq!(
            (body.mass_damping_1_s, body.stiffness_damping_s, body.natural_strain.clone()),
            (2.5, 0.0, [0.0; 4].into())
        );
        assert_relative_eq!(body.section.at(0.0).mass_kg_m, 1425.0 * 0.05 * 0.002, max_relative = 1e-15);
        assert_relative_eq!(body.section.at(0.0).stiffness[(2, 2)], bending_n_m2, max_relative = 1e-14);
        assert_eq!(body.section.at(0.0).stiffness[(1, 1)], 0.18);
        let strip_centres_m = [0.01875, 0.05625, 0.09375, 0.13125];
        assert_relative_eq!(body.station_positions_m.as_slice(), strip_centres_m.as_slice(), max_relative = 1e-15);
        assert_eq!(body.load_frame, LoadFrame::Root);
    }
    let [actuator] = machine.bodies[0].masses.as_slice() else { panic!("one mass at the joint") };
    assert_eq!((actuator.position_m, actuator.mass_kg, actuator.inertia_kg_m2), (0.15, 0.0203, Matrix3::zeros()));
    assert_eq!(machine.bodies[0].joint.parent, Parent::Root { position_m: Vector3::zeros() });
    assert_eq!(machine.bodies[1].joint.parent, Parent::Body { index: 0, position_m: 0.15 });

    let [gauge] = machine.gauges.as_slice() else { panic!("one gauge") };
    assert_eq!((gauge.name.as_str(), gauge.body, gauge.position_m), ("root", 0, 0.02));
    assert_eq!((gauge.y_m, gauge.z_m), (0.0, 0.001));
    let solver = &machine.solver;
    assert_eq!((solver.method, solver.tolerance, solver.max_step_s), (Method::Esdirk4, 1e-4, 5e-3));
    assert_eq!((solver.min_step_s, solver.fixed_step_s, solver.rho_infinity), (1e-9, None, 0.8));
    let experiment = &machine.experiment;
    assert_eq!((experiment.start_time_s, experiment.stop_time_s, experiment.step_s), (0.0, 0.4, 5e-4));
}

/// \[O\] Table 5, with the spring stiffness that fits its Fig. 10.
#[test]
fn the_shipped_wing_has_the_fold_joint_of_the_experiment() {
    let machine = shipped("folding_wing.toml");
    let fold = revolute(&machine, "fold");
    assert_eq!((fold.axis, fold.motion.clone(), fold.release), (Vector3::y(), JointMotion::Free, true));
    assert_eq!((fold.start_angle_rad, fold.start_rate_rad_s), (170_f64.to_radians(), 0.0));
    let motor = &fold.motor;
    assert_eq!((motor.stiffness_n_m_rad, motor.damping_n_m_s_rad), (0.026, 0.0008));
    assert_eq!((motor.constant_torque_n_m, motor.command_rad), (0.043, 0.0));
    assert_eq!((motor.torque_limit_n_m, motor.rate_limit_rad_s), (UNLIMITED, UNLIMITED));
    let latch = fold.latch.as_ref().unwrap();
    assert_relative_eq!(latch.stiffness_n_m_rad, 9999.0 * 0.026, max_relative = 1e-15);
    assert_eq!((latch.angle_rad, latch.capture_rad, latch.initially_closed, latch.enable), (0.0, 1e-6, false, true));
}

/// Each variant differs from the shipped wing only as its name indicates.
#[test]
fn variants_differ_in_one_thing() {
    let wing = shipped("folding_wing.toml");
    let rest = |machine: Machine| (machine.bodies, machine.gauges, machine.gravity_m_s2, machine.solver);

    let mut printed = shipped("folding_wing_as_printed.toml");
    assert_eq!(revolute(&printed, "fold").motor.stiffness_n_m_rad, 0.26);
    printed.bodies[1].joint = wing.bodies[1].joint.clone();
    // two pairs satisfy the energy balance at the default tolerance with its stiff latch
    printed.bodies.iter_mut().for_each(|body| body.elements = 4);
    assert_eq!(rest(printed), rest(wing.clone()));

    let mut constant = shipped("folding_wing_constant.toml");
    for body in &mut constant.bodies {
        assert_eq!((body.element, body.elements), (ElementKind::Constant, 15));
        (body.element, body.elements) = (ElementKind::Linear, 4);
    }
    assert_eq!(rest(constant), rest(wing));
}

#[test]
fn the_wing_of_three_bodies_folds_to_both_sides() {
    let machine = shipped("three_bodies.toml");
    assert_eq!(names(&machine), ["inner", "middle", "outer"]);
    let (inner, outer) = (revolute(&machine, "fold_inner"), revolute(&machine, "fold_outer"));
    assert!(inner.start_angle_rad < 0.0 && outer.start_angle_rad > 0.0);
    assert!(inner.latch.is_some() && outer.latch.is_some());
}

#[test]
fn the_branched_wing_has_two_free_ends_and_a_coupled_section() {
    let machine = shipped("branched.toml");
    assert_eq!(names(&machine), ["wing", "upper", "lower"]);
    assert_eq!(machine.bodies[1].joint.parent, Parent::Body { index: 0, position_m: 0.5 });
    assert_eq!(machine.bodies[2].joint.parent, Parent::Body { index: 0, position_m: 0.48 });
    assert_eq!((machine.bodies[1].load_frame, machine.bodies[2].station_positions_m.len()), (LoadFrame::Section, 0));

    let section = &machine.bodies[0].section.at(0.0);
    assert_eq!((section.stiffness[(1, 2)], section.stiffness[(2, 1)]), (0.35, 0.35));
    assert_relative_eq!(section.first_moment_kg[0], 0.35 * -0.008, max_relative = 1e-15);
    // Given about the centre of mass, stored about the beam axis: Steiner's term is added.
    assert_relative_eq!(section.second_moment_kg_m[0], 1.5e-4 + 0.35 * 0.008_f64.powi(2), max_relative = 1e-15);

    let JointMotion::Prescribed(Motion::Table(points)) = &revolute(&machine, "fold_lower").motion else {
        panic!("the lower winglet is prescribed")
    };
    assert_eq!(points[1], (0.1, -20_f64.to_radians()));
    assert_relative_eq!(revolute(&machine, "fold_upper").axis.norm(), 1.0, max_relative = 1e-15);
}

/// Bodies may be in any order; parents come first, otherwise the order of the file is kept.
#[test]
fn parents_come_first() {
    let (inner, rest) = MODEL.split_once("[body.outer]").unwrap();
    let (head, inner) = inner.split_once("[body.inner]").unwrap();
    let (outer, rest) = rest.split_once("[joint.mount]").unwrap();
    let swapped = format!("{head}[body.outer]{outer}[body.inner]{inner}[joint.mount]{rest}");
    assert_eq!(accepted(&swapped), accepted(MODEL));

    // Two bodies on the root keep the order of the file, whichever it is.
    let free = |text: &str| text.replace("parent = \"inner\"", "parent = \"root\"");
    assert_eq!(names(&accepted(&free(MODEL))), ["inner", "outer"]);
    let machine = accepted(&free(&swapped));
    assert_eq!(names(&machine), ["outer", "inner"]);
    assert_eq!((machine.gauges[0].body, machine.bodies[1].masses.len()), (1, 1));
}

/// Mount, axis and motion: degrees become radians, any axis becomes a unit vector.
#[test]
fn angles_are_radians_and_axes_unit_vectors() {
    let stated = "mount_rotation_deg = [0, 0, 90]\nstart_angle_deg = 90\nstart_rate_deg_s = -180";
    let machine = accepted(&with("start_angle_deg = 170", stated));
    let fold = revolute(&machine, "fold");
    assert_eq!((fold.axis, fold.start_angle_rad, fold.start_rate_rad_s), (Vector3::y(), FRAC_PI_2, -PI));
    // Rotation from body to parent frame: the body's x axis points along the parent's y axis.
    assert_relative_eq!(machine.bodies[1].joint.mount * Vector3::x(), Vector3::y(), epsilon = 1e-15);
}

#[test]
fn a_prescribed_joint_starts_where_its_law_starts() {
    let text = with("start_angle_deg = 170", "motion = \"prescribed\"\npolynomial_deg = [90, -10]");
    let machine = accepted(&text.replace("[joint.fold.latch]\nstiffness_ratio = 1e4\n", ""));
    let fold = revolute(&machine, "fold");
    assert_eq!(fold.start_angle_rad, FRAC_PI_2);
    assert_eq!(fold.motion, JointMotion::Prescribed(Motion::Polynomial(vec![FRAC_PI_2, -10_f64.to_radians()])));
}

#[test]
fn a_latch_on_a_hinge_without_spring_states_its_stiffness() {
    let text = with("[joint.fold.motor]\nstiffness_N_m_rad = 0.026\n", "");
    let machine = accepted(&text.replace("stiffness_ratio = 1e4", "stiffness_N_m_rad = 200"));
    let fold = revolute(&machine, "fold");
    assert_eq!((fold.motor.stiffness_n_m_rad, fold.latch.as_ref().unwrap().stiffness_n_m_rad), (0.0, 200.0));
}

#[test]
fn stations_may_be_listed() {
    let machine = accepted(&with("load_stations = 4", "load_station_positions_m = [0, 0.05, 0.15]"));
    assert_eq!(machine.bodies[0].station_positions_m, [0.0, 0.05, 0.15]);
    assert_eq!(machine.bodies[1].station_positions_m.len(), 4, "the default");
}

/// Loads act at the stations that they name, add up, and become start values of the inputs.
#[test]
fn loads_add_up_at_their_stations() {
    let loads = "[load.lift]\nbody = \"inner\"\nstation = 4\nforce_N = [0, 0, 2]\n\
                 [load.store]\nbody = \"inner\"\nstation = 4\nforce_N = [0, 0, -0.5]\nmoment_N_m = [0, 0.1, 0]\n";
    let text = with("[mass.actuator]", &format!("{loads}[mass.actuator]"));
    let machine = accepted(&text.replace("[simulation]", "[simulation]\nstart = \"equilibrium\""));
    let inner = &machine.bodies[0];
    assert_eq!(inner.station_loads.len(), 4);
    assert_eq!(inner.station_loads[3].force_n, Vector3::new(0.0, 0.0, 1.5));
    assert_eq!(inner.station_loads[3].moment_n_m, Vector3::new(0.0, 0.1, 0.0));
    assert!(inner.station_loads[..3].iter().all(foldwing::load::Wrench::is_zero));
    assert_eq!(machine.experiment.start, StartState::Equilibrium);
    let interface = foldwing::interface::Interface::new(&machine);
    let start = |name: &str| interface.find(name).unwrap().value;
    assert_eq!(start("load.inner[4].force.z"), foldwing::interface::Value::Real(1.5));
    assert_eq!(start("load.inner[3].force.z"), foldwing::interface::Value::Real(0.0));
    assert_eq!(shipped("folding_wing.toml").experiment.start, StartState::Unstrained);
}
