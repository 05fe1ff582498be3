//! The rigid limit: stiffness × 1e4 against rigid pendulums.

use crate::plant::machines::*;
use foldwing::beam::section::{Material, Section};
use foldwing::machine::*;
use foldwing::plant::Plant;
use nalgebra::Vector3;
use std::sync::Arc;

const LENGTH_M: f64 = 1.8;

/// Steel rods of 3.12 kg/m on free hinges, falling from the given start angles in the `x`–`z` plane.
///
/// The references are called "no_rot" but include the rotary inertia of a 20 mm square section: their period of 2.595204 s is
/// that of `L²/3 + h²/12`, not 2.595164 s of `L²/3`.
fn rods(angles_rad: &[f64], kind: ElementKind, count: usize, stiffness_factor: f64) -> Plant {
    let material = Material { youngs_modulus_pa: 2e11, shear_modulus_pa: 8e10, density_kg_m3: 7800.0 };
    let section = Section::rectangle(0.02, 0.02, &material, None);
    let rods = angles_rad.iter().enumerate().map(|(index, angle_rad)| {
        let hinge = Joint::hinge(format!("hinge{index}"), free_hinge(*angle_rad));
        let parent = index.checked_sub(1).map_or("root".to_owned(), |parent| format!("rod{parent}"));
        (body(&format!("rod{index}"), LENGTH_M, &section, kind, count), hinge.on(parent))
    });
    let mut machine = machine(rods);
    machine.gravity_m_s2 = Vector3::new(0.0, 0.0, -9.8);
    machine.solver = solver(Method::Esdirk4, 1e-8);
    let mut plant = Plant::new(Arc::new(machine));
    plant.parameters_mut().bodies_mut().iter_mut().for_each(|body| body.stiffness_factor = stiffness_factor);
    plant.initialize(0.0).expect("initial accelerations");
    plant
}

/// Largest error of the free end's position in m over the times of a reference `{time: [angles…, x, y]}` up to `end_s`.
pub fn worst_miss_m(mut plant: Plant, reference: &serde_json::Value, end_s: f64) -> f64 {
    let rows = reference.as_object().expect("times");
    let mut times: Vec<(f64, Vec<f64>)> = rows
        .iter()
        .map(|(time, row)| {
            let row = row.as_array().expect("a row").iter().map(|value| value.as_f64().expect("a number")).collect();
            (time.parse().expect("a time"), row)
        })
        .collect();
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut worst_m = 0f64;
    for (time_s, row) in times.iter().filter(|row| row.0 <= end_s) {
        coast(&mut plant, *time_s);
        let tip = plant.outputs().tips()[0].position_m;
        let miss_m = (tip - Vector3::new(row[row.len() - 2], 0.0, row[row.len() - 1])).norm();
        println!("t = {time_s} s: free end misses by {miss_m:.1e} m");
        worst_m = worst_m.max(miss_m);
    }
    worst_m
}

/// P-65. A single rod against the rigid pendulum, 0–2 s (`dyn.rigid_limits`, itself accurate to 1e-12).
///
/// Remaining errors: elasticity, `ρA g L³/(6 EI)` = 1.1e-6 rad at EI = 2.7e7 N·m², and the tolerance of 1e-8 per step over about 1e3 steps.
/// Limit 1e-5 m.
#[test]
fn p65_stiff_rod_is_the_rigid_pendulum() {
    let limits = expected("dyn.rigid_limits");
    for (kind, count) in [(ElementKind::Linear, 1), (ElementKind::Constant, 2)] {
        let plant = rods(&[0.0], kind, count, 1e4);
        let worst_m = worst_miss_m(plant, &limits["rigid_rod_pendulum_L1.8_rhoA3.12_no_rot (theta,x,y)"], 2.0);
        assert!(worst_m < 1e-5, "{kind:?}: free end misses by {worst_m:.1e} m");
    }
}

/// P-64. The rod released from the horizontal is vertically below its hinge after a quarter and three quarters of the period of the
/// reference. It passes there at 7.3 m/s, so the limit of P-65, 1e-5 m, checks the period to 1e-6.
#[test]
fn p64_stiff_rod_swings_in_the_period_of_the_rigid_one() {
    let period_s = expected("dyn.rigid_limits")["period_L1.8"].as_f64().expect("a number");
    let mut plant = rods(&[0.0], ElementKind::Linear, 1, 1e4);
    for share in [0.25, 0.75] {
        coast(&mut plant, share * period_s);
        let tip = plant.outputs().tips()[0];
        println!("P-64 after {share} periods: x = {:.1e} m at {:.2} m/s", tip.position_m.x, tip.velocity_m_s.x);
        assert!(tip.position_m.x.abs() < 1e-5, "{:.1e} m off the vertical", tip.position_m.x);
        assert!(tip.velocity_m_s.norm() > 7.0 && tip.position_m.z < 0.0);
    }
}

/// P-67. The rigid limit is approached with first order in the compliance: ten times the stiffness, a tenth of the error. The rod vibrates
/// after its release, so the ratio of two maximum errors is accurate to a third.
#[test]
fn p67_miss_falls_with_the_compliance() {
    let limits = expected("dyn.rigid_limits");
    let reference = &limits["rigid_rod_pendulum_L1.8_rhoA3.12_no_rot (theta,x,y)"];
    let misses =
        [1.0, 10.0, 100.0].map(|factor| worst_miss_m(rods(&[0.0], ElementKind::Linear, 2, factor), reference, 2.0));
    println!("P-67 misses at 1, 10, 100 times the stiffness: {misses:?} m");
    for pair in misses.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((7.5..13.3).contains(&ratio), "ten times the stiffness divides the miss by {ratio:.1}");
    }
}

/// P-66. Two rods from the horizontal, and the outer one hanging, against rigid double pendulums to 1.5 s.
///
/// Up to this time the motion amplifies the elastic deviation of P-65 about tenfold; later the motion is chaotic, also in the reference.
/// Limit 1e-4 m.
#[test]
fn p66_stiff_rods_are_the_rigid_double_pendulum() {
    let limits = expected("dyn.rigid_limits");
    for (name, angles_rad) in [
        ("rigid_double_rod_L1.8_from_horizontal (thA,thB,x,y)", [0.0, 0.0]),
        ("rigid_double_rod_L1.8_A_horizontal_B_down (thA,thB,x,y)", [0.0, std::f64::consts::FRAC_PI_2]),
    ] {
        let plant = rods(&angles_rad, ElementKind::Linear, 1, 1e4);
        let worst_m = worst_miss_m(plant, &limits[name], 1.5);
        assert!(worst_m < 1e-4, "{name}: free end misses by {worst_m:.1e} m");
    }
}
