//! Sliding joints: bodies that ride on a beam that deforms, against Exudyn, closed forms and the balance of momenta and energy.

use crate::plant::machines::*;
use foldwing::beam::section::Section;
use foldwing::machine::builder::{BodyBuilder, JointBuilder};
use foldwing::machine::*;
use foldwing::plant::Plant;
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// Section of 0.5 kg/m with the given `EA` and `EI`, and a rotary inertia that is negligible but not zero, so that twist has inertia.
fn slender(ea_n: f64, ei_n_m2: f64, rotary_kg_m: f64) -> Section {
    Section {
        shear: None,
        stiffness: Matrix4::from_diagonal(&Vector4::new(ea_n, ei_n_m2, ei_n_m2, ei_n_m2)),
        mass_kg_m: 0.5,
        first_moment_kg: [0.0, 0.0],
        second_moment_kg_m: [0.5 * rotary_kg_m, 0.0, 0.5 * rotary_kg_m],
        half_width_m: 0.01,
        half_height_m: 0.01,
    }
}

/// A machine of a beam and a body that slides along it.
fn rail(
    beam: (BodyBuilder, JointBuilder),
    rider: (BodyBuilder, JointBuilder),
    masses: &[(&str, AttachedMass)],
) -> Machine {
    let mut built = Machine::builder("rail").body(beam.0, beam.1).body(rider.0, rider.1);
    for (body, mass) in masses {
        built = built.mass(*body, mass.clone());
    }
    let built = built.solver(solver(Method::Esdirk4, 1e-7)).stop_time_s(1.0).step_s(1e-2).build();
    built.unwrap_or_else(|refused| panic!("{refused}"))
}

/// The free slider of SJ-01 with `pairs` linear elements.
fn bead(pairs: usize, tolerance: f64) -> Machine {
    let beam = body("beam", 1.0, &slender(1e4, 1.0, 1e-7), ElementKind::Linear, pairs);
    let joint = Joint::sliding("slide").on("beam").start_position_m(0.25);
    let mass = AttachedMass::point("mass", 0.0, 0.1);
    let mut machine = rail((beam, clamped()), (Body::rigid("bead"), joint), &[("bead", mass)]);
    machine.gravity_m_s2 = Vector3::new(4.905, 0.0, -8.4957);
    machine.solver.tolerance = tolerance;
    machine
}

/// SJ-01. A point mass slides without friction along a cantilever that deflects by 0.65 of its length, against Exudyn (32 cables, sliding
/// joint): largest differences of tip and mass over 0.42 s.
#[test]
fn sj01_a_bead_slides_down_a_flexible_beam() {
    let rows = reference_rows("sliding/slider_exudyn.csv");
    let mut slider_of = Vec::new();
    for pairs in [2, 3, 4, 6, 8] {
        let mut plant = start(bead(pairs, 1e-7));
        let (mut tip_m, mut slider_m) = (0.0f64, 0.0f64);
        let begin_j = balance_j(plant.outputs());
        for row in rows.iter().skip(1).filter(|row| row[0] < 0.4201) {
            coast(&mut plant, row[0]);
            let tips = plant.outputs().tips();
            let differs = |at: usize, x: f64, y: f64| (tips[at].position_m - Vector3::new(x, 0.0, y)).norm();
            tip_m = tip_m.max(differs(0, row[1], row[2]));
            slider_m = slider_m.max(differs(1, row[3], row[4]));
        }
        let drift_j = (balance_j(plant.outputs()) - begin_j).abs();
        println!(
            "SJ-01 {pairs} pairs: tip {tip_m:.2e} m, slider {slider_m:.2e} m, drift {drift_j:.1e} J, lost {:.2e} J, s {:.6} m, {} events",
            plant.outputs().energy().dissipated,
            plant.outputs().joints()[0].angle_rad,
            plant.statistics().events,
        );
        slider_of.push(slider_m);
    }
}
