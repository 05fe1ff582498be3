//! The drawn undeformed wing: joints rotate as in design section 1, and a body curved to a full circle closes.

use super::*;
use foldwing_engine::beam::section::{Material, Section};
use foldwing_engine::load::LoadFrame;
use foldwing_engine::machine::{
    ElementKind, Experiment, Joint, JointKind, JointMotion, Latch, LatchKind, Method, Motor, Parent, Revolute, Solver,
    Spatial, SpatialFreedom, StartState, UNLIMITED,
};
use foldwing_engine::math::strain::{STRAINS, Strain};
use nalgebra::{Matrix3, Rotation3};
use std::f64::consts::{FRAC_PI_2, PI};

fn body(name: &str, joint: Joint) -> Body {
    let material = Material { youngs_modulus_pa: 2.83e9, shear_modulus_pa: 1e9, density_kg_m3: 1425.0 };
    Body {
        name: name.to_owned(),
        length_m: 0.15,
        section: Section::rectangle(0.05, 0.002, &material, Some(0.18)).into(),
        aerofoil: Vec::new(),
        element: ElementKind::Linear,
        elements: 3,
        natural_strain: [0.0; STRAINS].into(),
        mass_damping_1_s: 2.5,
        damp_attached_masses: false,
        stiffness_damping_s: 0.0,
        axis: None,
        stiffness_damping_factors: Strain::repeat(1.0),
        shear_damping_factors: [1.0; 2],
        modal_damping_ratios: vec![],
        station_positions_m: vec![0.05, 0.1],
        station_loads: vec![],
        load_frame: LoadFrame::Root,
        masses: vec![],
        joint,
    }
}

/// Two bodies in line, connected by a fold joint, as used in all tests of this module.
pub(crate) fn two_body_machine() -> Machine {
    let clamp = Joint {
        name: "clamp".to_owned(),
        parent: Parent::Root { position_m: Vector3::zeros() },
        offset_m: Vector3::zeros(),
        mount: Matrix3::identity(),
        kind: JointKind::Clamped,
    };
    let revolute = Revolute {
        axis: Vector3::y(),
        start_angle_rad: FRAC_PI_2,
        start_rate_rad_s: 0.0,
        motion: JointMotion::Free,
        release: true,
        motor: Motor {
            stiffness_n_m_rad: 0.026,
            damping_n_m_s_rad: 0.0008,
            constant_torque_n_m: 0.043,
            torque_limit_n_m: UNLIMITED,
            rate_limit_rad_s: UNLIMITED,
            inertia_kg_m2: 0.0,
            gear_ratio: None,
            command_rad: 0.0,
        },
        spring: None,
        generator: None,
        dc_motor: None,
        end_stops: None,
        latch: Some(Latch {
            kind: LatchKind::Elastic,
            angle_rad: 0.0,
            stiffness_n_m_rad: 260.0,
            capture_rad: 0.0,
            initially_closed: false,
            enable: true,
        }),
    };
    let fold = Joint {
        name: "fold".to_owned(),
        parent: Parent::Body { index: 0, position_m: 0.15 },
        offset_m: Vector3::zeros(),
        mount: Matrix3::identity(),
        kind: JointKind::Revolute(Box::new(revolute)),
    };
    Machine {
        name: "TwoBodies".to_owned(),
        description: "Two bodies < one wing & a joint".to_owned(),
        bodies: vec![body("inner", clamp), body("outer", fold)],
        closures: Vec::new(),
        no_slips: Vec::new(),
        air: None,
        gauges: vec![],
        internal_loads: vec![],
        failures: vec![],
        gravity_m_s2: Vector3::new(-9.8, 0.0, 0.0),
        solver: Solver {
            method: Method::Esdirk3,
            tolerance: 1e-5,
            max_step_s: 1e-2,
            min_step_s: 1e-9,
            fixed_step_s: None,
            rho_infinity: 0.8,
            most_iterations: None,
        },
        experiment: Experiment { start_time_s: 0.0, stop_time_s: 0.4, step_s: 5e-4, start: StartState::Unstrained },
    }
}

/// Positive fold angles about `r_y` rotate the outer body towards `−z` (design section 1).
#[test]
fn positive_angle_folds_downwards() {
    let wing = undeformed(&two_body_machine(), 1.0);
    let tip = wing[1].last().unwrap().position_m;
    assert!((tip - Vector3::new(0.15, 0.0, -0.15)).norm() < 1e-12, "tip at {tip}");
    let deployed = undeformed(&two_body_machine(), 0.0);
    let tip = deployed[1].last().unwrap().position_m;
    assert!((tip - Vector3::new(0.3, 0.0, 0.0)).norm() < 1e-12, "tip at {tip}");
}

/// A body whose initial curvature forms a full circle ends where it starts, within the accuracy of the drawing.
#[test]
fn natural_curvature_is_followed() {
    let mut machine = two_body_machine();
    machine.bodies.truncate(1);
    machine.bodies[0].natural_strain = [0.0, 0.0, 2.0 * PI / 0.15, 0.0].into();
    let gap = undeformed(&machine, 0.0)[0].last().unwrap().position_m.norm();
    assert!(gap < 1e-6, "tip misses root by {gap:.1e} m");
}

/// Universal, ball and free joints are drawn at the start: a free body at its initial position, and its outboard bodies rotated as in the
/// model file. There are no intermediate positions if no joint folds.
#[test]
fn joints_of_several_degrees_of_freedom_stand_at_their_start() {
    let mut machine = two_body_machine();
    let freedoms = [SpatialFreedom::Free, SpatialFreedom::Ball];
    for (body, freedom) in machine.bodies.iter_mut().zip(freedoms) {
        body.joint.kind = JointKind::Spatial(Box::new(Spatial {
            freedom,
            stiffness_n_m_rad: 0.0,
            damping_n_m_s_rad: 0.0,
            start_angular_velocity_rad_s: Vector3::zeros(),
            start_velocity_m_s: Vector3::zeros(),
        }));
    }
    machine.bodies[0].joint.parent = Parent::Root { position_m: Vector3::new(0.0, 0.0, 2.0) };
    machine.bodies[1].joint.mount = *Rotation3::new(Vector3::new(0.0, FRAC_PI_2, 0.0)).matrix();
    let wing = undeformed(&machine, 0.0);
    let tip = wing[1].last().unwrap().position_m;
    assert!((tip - Vector3::new(0.15, 0.0, 1.85)).norm() < 1e-12, "tip at {tip}");
    let svg = svg(&drawing(&machine));
    assert!(!svg.contains("ghost") && !svg.contains("\"start\""), "{svg}");
    assert!(svg.contains("<title>joint fold</title>"));
}

/// Coordinates are finite even for a wing whose projection is a line.
#[test]
fn drawing_is_finite() {
    let mut machine = two_body_machine();
    machine.bodies.truncate(1);
    machine.bodies[0].section = Section { half_width_m: 0.0, ..machine.bodies[0].section.at(0.0) }.into();
    let svg = svg(&drawing(&machine));
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
}

/// The fold axis is drawn through its joint with the direction in the model file, for any mount of its body and any fold angle.
#[test]
fn fold_axes_lie_where_the_file_says() {
    let mut machine = two_body_machine();
    let axis = Vector3::new(0.6, 0.8, 0.0);
    machine.bodies[1].joint.mount = *Rotation3::new(Vector3::new(0.3, -0.2, 0.5)).matrix();
    let JointKind::Revolute(joint) = &mut machine.bodies[1].joint.kind else { panic!("the second joint folds") };
    joint.axis = axis;
    for fraction in [0.0, 1.0] {
        let lines = hinges(&machine, &undeformed(&machine, fraction));
        let [[from, to]] = lines.as_slice() else { panic!("one fold joint, {} lines", lines.len()) };
        assert!((0.5 * (from + to) - Vector3::new(0.15, 0.0, 0.0)).norm() < 1e-12);
        assert!(((to - from).normalize() - axis).norm() < 1e-12, "{:?}", to - from);
        assert!((to - from).norm() > 0.05, "longer than the section is wide");
    }
}

/// The file of `--draw` is self-contained: it has fixed colours, a legend with only the drawn roles, and escaped names.
#[test]
fn the_drawing_is_a_file_of_its_own() {
    let machine = Machine { name: "A<B".to_owned(), ..two_body_machine() };
    let svg = file(&machine);
    assert!(svg.starts_with("<?xml") && svg.contains("<title>A&lt;B</title>") && !svg.contains("var("), "{svg}");
    for (role, name) in KEYS {
        let shown = svg.contains(&format!(">{name}</text>"));
        assert_eq!(shown, matches!(role, Role::Joint | Role::Hinge | Role::Station), "{name}");
    }
    let height: f64 = svg.split("height=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
    assert!(height > drawing(&machine).size[1], "room for the legend");
}
