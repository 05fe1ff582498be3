//! Flutter roots after the pitch link has opened.

use super::air::{Induced, STRIPS, loads, trim};
use super::{blade, joint_of, lamina};
use crate::plant::machines::{reference_rows, start};
use foldwing::machine::{JointMotion, Motion};
use foldwing::plant::Plant;
use nalgebra::{DMatrix, Vector3};

const STATES: usize = 4 + STRIPS;

/// Time derivatives of flap, pitch, their rates and the induced velocities, with the shaft rotating at 4 rad/s; accelerations by the
/// engine.
fn slopes(plant: &mut Plant, z: &[f64; STATES]) -> [f64; STATES] {
    let (q, rates) = (Vector3::new(0.0, z[0], z[1]), Vector3::new(4.0, z[2], z[3]));
    let (moments, lag) = loads(&q, &rates, &Induced::from_column_slice(&z[4..]));
    let mut hybrid = plant.hybrid().expect("no air of its own");
    for (joint, inputs) in hybrid.system_mut().inputs_mut().joints_mut().iter_mut().enumerate() {
        inputs.torque_n_m = moments[joint];
    }
    hybrid.follow_inputs();
    hybrid.set(0.0, &z[..4]);
    let mut found = [0.0; STATES];
    hybrid.derivatives(&mut found[..4]).expect("accelerations");
    found[4..].copy_from_slice(lag.as_slice());
    found
}

/// Oscillatory roots of the blade about its steady rotation, least damped first, 1/s and rad/s.
fn roots(pitch_kg_m2: f64) -> Vec<(f64, f64)> {
    let mut machine = blade(pitch_kg_m2);
    machine.failures.clear();
    joint_of(&mut machine, "pitch").release = true;
    let shaft = joint_of(&mut machine, "shaft");
    (shaft.motion, shaft.start_rate_rad_s) = (JointMotion::Prescribed(Motion::Polynomial(vec![0.0, 4.0])), 0.0);
    let stiffness_n_m_rad = joint_of(&mut machine, "flap").spring.expect("a spring").stiffness_n_m_rad;
    let (q, _, induced) = trim(&lamina(pitch_kg_m2), stiffness_n_m_rad);
    assert!((q[1].to_degrees() - 0.630_188).abs() < 1e-6, "trimmed at {} degrees", q[1].to_degrees());
    let mut plant = start(machine);
    let mut about = [0.0; STATES];
    (about[0], about[1]) = (q[1], q[2]);
    about[4..].copy_from_slice(induced.as_slice());
    let step = 1e-6;
    let mut matrix = DMatrix::zeros(STATES, STATES);
    for column in 0..STATES {
        let mut at = |sign: f64| {
            let mut z = about;
            z[column] += sign * step;
            slopes(&mut plant, &z)
        };
        let (ahead, behind) = (at(1.0), at(-1.0));
        for row in 0..STATES {
            matrix[(row, column)] = (ahead[row] - behind[row]) / (2.0 * step);
        }
    }
    let mut roots: Vec<(f64, f64)> =
        matrix.complex_eigenvalues().iter().filter(|z| z.im > 0.5).map(|z| (z.re, z.im)).collect();
    roots.sort_by(|a, b| b.0.total_cmp(&a.0));
    roots
}

/// PL-05. Growth rates and frequencies as functions of the inertia that remains in the pitch circuit: the paper's strong remedy.
#[test]
fn pl05_flutter_roots_over_the_gear_inertia() {
    let mut worst = [0.0f64; 2];
    for row in reference_rows("pitch_link_growth.csv") {
        let roots = roots(row[0]);
        for (found, expected) in roots.iter().zip(row[1..].chunks(2)) {
            worst[0] = worst[0].max((found.0 - expected[0]).abs());
            worst[1] = worst[1].max((found.1 - expected[1]).abs());
        }
    }
    println!("largest misses {:.1e} 1/s, {:.1e} rad/s", worst[0], worst[1]);
    assert!(worst[0] < 1e-4 && worst[1] < 1e-5, "{worst:?}");
    // neutral inertia, by bisection of the flutter root
    let (mut low, mut high) = (100.0, 150.0);
    while high - low > 0.01 {
        let middle = 0.5 * (low + high);
        if roots(middle)[0].0 > 0.0 { low = middle } else { high = middle }
    }
    println!("neutral at {low:.2} kg·m²");
    assert!((low - 105.7).abs() < 5.0, "neutral at {low} kg·m²");
}
