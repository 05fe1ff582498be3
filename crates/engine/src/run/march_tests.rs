//! Steps grow when the motion allows it, and the time is that of the caller's clock.

use crate::beam::profile::Profile as Along;
use crate::beam::section::{Material, Solid};
use crate::machine::{Air, Body, Joint, LiftingSurface, Machine, Motor, Solver};
use crate::run::Plant;
use nalgebra::Matrix3;
use std::sync::Arc;

fn started(machine: Machine) -> Plant {
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    plant
}

/// An oscillation of 20 rad/s that decays with e^(-4t): its steps are short at first, and 5 s later, with an amplitude of e^(-20), as long
/// as allowed. The next 5 s take 20 steps; two more are allowed for the ends.
#[test]
fn steps_grow_where_a_motion_dies_down() {
    const LONGEST_S: f64 = 0.25;
    let drive = Motor { stiffness_n_m_rad: 400.0, damping_n_m_s_rad: 8.0, ..Motor::default() };
    let machine = Machine::builder("Dying")
        .body(
            Body::rigid("arm").inertia(1.0, [0.0; 3], Matrix3::identity()),
            Joint::revolute("hinge", [0.0, 1.0, 0.0]).motor(drive).start_angle_rad(0.3),
        )
        .solver(Solver { max_step_s: LONGEST_S, ..Solver::default() })
        .build()
        .unwrap_or_else(|refused| panic!("{refused}"));
    let mut plant = started(machine);
    let steps = |plant: &mut Plant, end_s: f64| {
        plant.step(end_s).unwrap_or_else(|error| panic!("{error}"));
        plant.statistics().steps
    };
    let [first, middle, last] = [0.5, 5.0, 10.0].map(|end_s| steps(&mut plant, end_s));
    assert!(first > 10, "{first} steps for 1.6 periods");
    assert!(last - middle <= 22, "{} steps for 5 s at rest, {middle} before", last - middle);
}

/// A wing in still air is independent of absolute time: a clock that is shifted by a quarter of a second within an aerodynamic step shifts
/// everything, and the motion is otherwise unchanged, within round-off of times, 1e-16 s at 1 rad/s, amplified by the tolerances of
/// coupling and steps.
#[test]
fn a_clock_that_is_set_inside_an_aerodynamic_step_changes_nothing() {
    let wing = || {
        let drive = Motor { stiffness_n_m_rad: 5.0, damping_n_m_s_rad: 0.01, ..Motor::default() };
        let material = Material { youngs_modulus_pa: 7e10, shear_modulus_pa: 3e10, density_kg_m3: 500.0 };
        let machine = Machine::builder("Pitching")
            .body(
                Body::beam("wing", 1.0, Solid::rectangle(0.3, 0.02, material)).elements(1),
                Joint::revolute("pitch", [1.0, 0.0, 0.0]).start_rate_rad_s(2.0).motor(drive),
            )
            .air(Air::strips().density_kg_m3(1.2).wind_m_s([0.0, -15.0, 0.5]).step_s(0.0078125))
            .surface(LiftingSurface::on("wing", 2).chord_m(Along::constant(0.3)))
            .build()
            .unwrap_or_else(|refused| panic!("{refused}"));
        started(machine)
    };
    let run = |set_on_s: f64| {
        let mut plant = wing();
        let step = |plant: &mut Plant, end_s: f64| plant.step(end_s).unwrap_or_else(|error| panic!("{error}"));
        step(&mut plant, 0.0625 + 0.00390625);
        let time_s = plant.time_s() + set_on_s;
        plant.adopt_time(time_s);
        (1..=20)
            .map(|k| {
                step(&mut plant, time_s + 0.00390625 * f64::from(k));
                [plant.outputs().joints()[0].angle_rad, plant.outputs().joints()[0].rate_rad_s]
            })
            .collect::<Vec<_>>()
    };
    let (alone, set) = (run(0.0), run(0.25));
    assert!(alone.iter().any(|[angle_rad, _]| angle_rad.abs() > 0.05));
    for (step, (a, b)) in alone.iter().zip(&set).enumerate() {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-10), "step {}: {a:?} {b:?}", step + 1);
    }
}
