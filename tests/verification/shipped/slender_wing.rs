//! F-230, F-231: `slender_wing.toml`, curved, tapered and with large upward bending, against an independent planar beam.

use super::{machine, percent};
use foldwing::machine::Machine;
use foldwing::plant::{Holding, ModeShape, Plant};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

const MODEL: &str = include_str!("../../../examples/models/slender_wing.toml");

const LENGTH_M: f64 = 16.0;
const GRAVITY: f64 = 9.81;
/// Natural curvature in 1/m, upward.
const CURVATURE_1_M: f64 = PI / 18.0 / LENGTH_M;

/// Linear interpolation from root to tip.
fn between(root: f64, tip: f64, place_m: f64) -> f64 {
    root + (tip - root) * place_m / LENGTH_M
}

fn stiffness_n_m2(place_m: f64) -> f64 {
    between(5.0e4, 8.0e3, place_m)
}

fn mass_kg_m(place_m: f64) -> f64 {
    between(1.0, 0.5, place_m)
}

/// Mass moment of inertia per length for a rotation about the chord.
fn rotary_kg_m(place_m: f64) -> f64 {
    between(2.0e-3, 3.0e-4, place_m)
}

/// Lift per length, normal to axis and wind, of a thin plate at 4 degrees, in N/m: the normal pressure force `½ρ c 2π V² sin α cos α`
/// rotated into the wind's frame, plus leading-edge suction.
fn lift_n_m(place_m: f64) -> f64 {
    let (sin, cos) = 4f64.to_radians().sin_cos();
    0.5 * 1.1 * 14.0 * 14.0 * between(1.2, 0.5, place_m) * TAU * sin * cos * (cos + sin * sin)
}

/// Tip `[x, z]` in m and moment at the root in N·m of an inextensible planar beam of `segments` straight pieces, bent by its lift, which
/// stays normal to it, and its weight, by fixed-point iteration of the angles.
fn planar_equilibrium(segments: usize) -> ([f64; 2], f64) {
    let h = LENGTH_M / segments as f64;
    let middle = |i: usize| h * (i as f64 + 0.5);
    let mut angles = vec![0.0_f64; segments];
    loop {
        // from the tip inwards: force beyond each joint, and its moment at the joint
        let (mut force, mut moment) = ([0.0, 0.0], 0.0);
        let mut moments = vec![0.0; segments];
        for i in (0..segments).rev() {
            let (sin, cos) = angles[i].sin_cos();
            let lift = h * lift_n_m(middle(i));
            let own = [-lift * sin, lift * cos - h * mass_kg_m(middle(i)) * GRAVITY];
            let arm = |at: f64, force: [f64; 2]| at * (cos * force[1] - sin * force[0]);
            moment += arm(h, force) + arm(0.5 * h, own);
            force = [force[0] + own[0], force[1] + own[1]];
            moments[i] = moment;
        }
        // joints are at the middles of the segments; the first half segment bends at the root
        let (mut angle, mut change) = (0.0, 0.0_f64);
        for (i, moment) in moments.iter().enumerate() {
            let length = if i == 0 { 0.5 * h } else { h };
            let place = if i == 0 { 0.25 * h } else { h * i as f64 };
            angle += length * (CURVATURE_1_M + moment / stiffness_n_m2(place));
            let step = 0.5 * (angle - angles[i]);
            angles[i] += step;
            change = change.max(step.abs());
        }
        if change < 1e-13 {
            let tip = angles.iter().fold([0.0, 0.0], |[x, z], angle| [x + h * angle.cos(), z + h * angle.sin()]);
            return (tip, moments[0]);
        }
    }
}

fn plant(changes: &[(&str, &str)]) -> Plant {
    let machine: Machine = machine(MODEL, changes);
    Plant::new(Arc::new(machine))
}

/// F-230. In flight the tip rises by a third of the span above its position without loads. Tip and root moment against a planar
/// finite-difference beam with the lift of a thin plate (Richardson extrapolation from two meshes; its error is below 1e-6): 0.2 % of the
/// length and of the moment, because the beam excludes the wing's twist of a hundredth of a degree. With a torsionally rigid wing, four
/// times as many elements and eight times as many strips: 2e-5. The part of this due to constant lift per strip, distributed to both its
/// ends, falls with the square of the number of strips (3e-5 with 96, 4e-6 with 192).
#[test]
fn f230_static_deflection() {
    let (coarse, fine) = (planar_equilibrium(1000), planar_equilibrium(2000));
    let limit = |coarse: f64, fine: f64| fine + (fine - coarse) / 3.0;
    let tip = [limit(coarse.0[0], fine.0[0]), limit(coarse.0[1], fine.0[1])];
    let moment = limit(coarse.1, fine.1);
    let unloaded_m = (1.0 - (CURVATURE_1_M * LENGTH_M).cos()) / CURVATURE_1_M;
    let errors = |changes: &[(&str, &str)]| {
        let mut plant = plant(changes);
        plant.study().equilibrium(0.0, Holding::Stopped).unwrap_or_else(|error| panic!("{error}"));
        let outputs = plant.outputs();
        let place = outputs.tips()[0].position_m;
        let off = (place.x - tip[0]).hypot(place.z - tip[1]) / LENGTH_M;
        println!(
            "F-230 tip ({:.4}, {:.4}) m, {:.1} % of the length above the unloaded one, off {off:.1e} of the length; root moment {:.2} N.m, off {:.1e}",
            place.x,
            place.z,
            100.0 * (place.z - unloaded_m) / LENGTH_M,
            -outputs.root().moment_n_m.y,
            -outputs.root().moment_n_m.y / moment - 1.0
        );
        assert!(place.z - unloaded_m > 0.3 * LENGTH_M, "{}", place.z);
        [off, (-outputs.root().moment_n_m.y / moment - 1.0).abs()]
    };
    println!("F-230 planar beam: tip ({:.5}, {:.5}) m, {moment:.3} N.m", tip[0], tip[1]);
    let shipped = errors(&[]);
    let stiff = errors(&[
        ("torsional_rigidity_N_m2 = 2.0e4", "torsional_rigidity_N_m2 = 2.0e8"),
        ("torsional_rigidity_N_m2 = 4.0e3", "torsional_rigidity_N_m2 = 4.0e7"),
        ("elements = 6", "elements = 24"),
        ("strips = 24", "strips = 192"),
    ]);
    assert!(shipped.iter().all(|off| *off < 2e-3), "{shipped:?}");
    assert!(stiff.iter().all(|off| *off < 2e-5), "{stiff:?}");
}

/// Lowest natural frequencies in Hz of a planar chain of rigid links in the unloaded curve, with springs at their joints, and the wing's
/// mass at three points of each link and its rotary inertia: classical finite segments.
fn chain_frequencies_hz(joints: usize, count: usize) -> Vec<f64> {
    let h = LENGTH_M / joints as f64;
    let place = |along: f64| {
        let turned = CURVATURE_1_M * along;
        [turned.sin() / CURVATURE_1_M, (1.0 - turned.cos()) / CURVATURE_1_M]
    };
    let spring_m = |i: usize| h * (i as f64 + 0.5);
    let mut mass = DMatrix::<f64>::zeros(joints, joints);
    // Simpson's rule on each link between springs; the last link is half as long
    for link in 0..joints {
        let (from, to) = (spring_m(link), (spring_m(link) + h).min(LENGTH_M));
        for (share, weight) in [(0.0, 1.0 / 6.0), (0.5, 4.0 / 6.0), (1.0, 1.0 / 6.0)] {
            let along = from + share * (to - from);
            let (kilograms, turn) =
                (weight * (to - from) * mass_kg_m(along), weight * (to - from) * rotary_kg_m(along));
            let at = place(along);
            let arms = DMatrix::from_fn(2, link + 1, |axis, joint| {
                let [x, z] = place(spring_m(joint));
                if axis == 0 { z - at[1] } else { at[0] - x }
            });
            let mut block = mass.view_mut((0, 0), (link + 1, link + 1));
            block.gemm_tr(kilograms, &arms, &arms, 1.0);
            block.add_scalar_mut(turn);
        }
    }
    // K is diagonal: eigenvalues of K^(-1/2) M K^(-1/2) are 1/ω²
    let flexibility = DVector::from_fn(joints, |i, _| (h / stiffness_n_m2(spring_m(i))).sqrt());
    let scaled = DMatrix::from_fn(joints, joints, |i, j| flexibility[i] * mass[(i, j)] * flexibility[j]);
    let mut values: Vec<f64> = scaled.symmetric_eigenvalues().iter().copied().collect();
    values.sort_by(|a, b| b.total_cmp(a));
    values[..count].iter().map(|value| 1.0 / (TAU * value.sqrt())).collect()
}

/// F-231. Natural frequencies of bending in the plane of the curve, about the unloaded wing without aerodynamics, against a chain of rigid
/// links with springs (Richardson extrapolation from 80 and 160 of them, accurate to 1e-5): the first four within 0.1, 0.1, 0.2 and 1 %,
/// the error of six pairs; with 24 pairs all within 1e-4.
#[test]
fn f231_natural_frequencies() {
    let (coarse, fine) = (chain_frequencies_hz(80, 4), chain_frequencies_hz(160, 4));
    let reference: Vec<f64> = coarse.iter().zip(&fine).map(|(coarse, fine)| fine + (fine - coarse) / 3.0).collect();
    let errors = |elements: &str| {
        let mut plant = plant(&[("elements = 6", elements)]);
        plant.study().undeformed(0.0).unwrap_or_else(|error| panic!("{error}"));
        let modes = plant.study().bare_modes(10).unwrap_or_else(|error| panic!("{error}"));
        // the other modes bend out of the plane and twist
        let flap = |mode: &&ModeShape| mode.shares[2] > 0.9;
        let found: Vec<f64> = modes.iter().filter(flap).take(4).map(|mode| mode.frequency_hz).collect();
        let off: Vec<f64> = found.iter().zip(&reference).map(|(found, exact)| found / exact - 1.0).collect();
        println!("F-231 {elements}: {found:.5?} Hz, off {:.4?} %", percent(&off));
        assert_eq!(off.len(), 4, "{found:?}");
        off
    };
    println!("F-231 links: {reference:.5?} Hz, the finer chain off {:.1e}", fine[3] / reference[3] - 1.0);
    for (off, limit) in errors("elements = 6").iter().zip([1e-3, 1e-3, 2e-3, 1e-2]) {
        assert!(off.abs() < limit, "{off:.1e} over {limit:.0e}");
    }
    assert!(errors("elements = 24").iter().all(|off| off.abs() < 1e-4));
}
