//! C-20 to C-23: the first two conventional methods of Table 1 and their drawbacks: singularity and tuning.

use crate::conventional::link::{Axis, turn};
use crate::conventional::pendulum::{
    Between, STEP_S, highest_frequency, joint_parameters, penalty_joint, rotation_angles, runge_kutta,
};
use crate::conventional::sample::{Sample, largest, run, run_as_printed};
use crate::whole::is_whole;
use nalgebra::{DVector, Matrix3};
use std::f64::consts::FRAC_PI_2;

/// Largest distance of two tips in m; NaN if one motion has diverged.
fn tip_difference(a: &[Sample], b: &[Sample]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a.tip_m - b.tip_m).norm()).fold(0.0, |m: f64, x| if m >= x { m } else { x })
}

/// True if an energy in J or a length in m has diverged.
fn blown_up(value: f64) -> bool {
    value.is_nan() || value.abs() > 10.0
}

/// C-20. Rotation angles break down where the motion passes their singular attitude; joint parameters do not.
///
/// Which attitude is singular depends on the chart. Body A of the ball–ball pendulum reaches some attitude at 0.3 s; a chart whose middle
/// angle is 90° exactly there has a singular mass matrix in that step. A chart that stays 0.3 rad away from its singularity reproduces the
/// motion of the joint parameters to round-off, so only the singularity causes the failure.
#[test]
#[ignore = "long; `make long` runs it"]
fn c20_rotation_angles_fail_at_their_singular_attitude() {
    let (system, start) = joint_parameters(Between::Ball, 2);
    let (mut q, mut v) = (start.clone(), DVector::zeros(start.len()));
    for _ in 0..3000 {
        runge_kutta(&system, &mut q, &mut v, STEP_S, true);
    }
    let attitude: Matrix3<f64> = system.motion(&q, &v)[0].nodes[0].h.fixed_rows::<3>(1).transpose();
    let ours = run_as_printed(&system, &start, 0.4, true);
    let energy_j = largest(&ours, Sample::total_j);
    assert!(energy_j < 1e-9, "joint parameters: energy off by {energy_j:.1e} J");

    let with_singularity_at = |distance_rad: f64| {
        let chart = attitude * turn(Axis::Y, FRAC_PI_2 - distance_rad)[0].transpose();
        let (angles, start) = rotation_angles(Between::Ball, 2, &chart, 0.0);
        run_as_printed(&angles, &start, 0.4, false)
    };
    let away = with_singularity_at(0.3);
    let error_m = tip_difference(&ours, &away);
    assert!(error_m < 1e-10, "0.3 rad from the singularity: tips differ by {error_m:.1e} m");

    let near = with_singularity_at(1e-3);
    let energy_j = largest(&near, Sample::total_j);
    println!(
        "1e-3 rad past the singularity: energy off by {energy_j:.1e} J, tip by {:.1e} m",
        tip_difference(&ours, &near)
    );
    assert!(energy_j > 1e-6, "1e-3 rad past the singularity: energy off by {energy_j:.1e} J only");

    let through = with_singularity_at(0.0);
    let before_m = tip_difference(&ours[..30], &through[..30]);
    assert!(before_m < 1e-9, "before the singularity: tips differ by {before_m:.1e} m");
    let after = through.last().expect("samples");
    println!("through the singularity: energy {} J, tip x {} m", after.total_j(), after.tip_m.x);
    assert!(
        blown_up(after.total_j()),
        "the method went through its singular attitude with an energy of {:.1e} J",
        after.total_j()
    );
}

/// C-21. Fictitious springs on two redundant angles of the revolute joint: the error falls as `1/k`, the highest frequency rises as `√k`,
/// and the integration with the paper's step becomes unstable before the error is small. Joint parameters need no such springs.
#[test]
#[ignore = "long; `make long` runs it"]
fn c21_redundant_angles_need_tuning() {
    let (system, start) = joint_parameters(Between::Revolute, 2);
    let ours = run_as_printed(&system, &start, 0.3, true);
    let own_rad_s = highest_frequency(&system, &start);
    let outcome = |stiffness: f64, step_s: f64| {
        let (angles, start) = rotation_angles(Between::Revolute, 2, &Matrix3::identity(), stiffness);
        let every = (0.01 / step_s).round() as usize;
        let error_m = tip_difference(&ours, &run(&angles, &start, [0.3, step_s], every, false));
        let frequency_rad_s = highest_frequency(&angles, &start);
        println!("k {stiffness:.0e} N·m/rad, step {step_s:.0e} s: tip {error_m:.1e} m, {frequency_rad_s:.2e} rad/s");
        (error_m, frequency_rad_s)
    };
    let [soft, middle] = [1e3, 1e4].map(|k| outcome(k, STEP_S));
    assert!(soft.0 / middle.0 > 3.0, "tip errors {:.1e} m and {:.1e} m at ten times the stiffness", soft.0, middle.0);
    assert!(middle.0 > 1e-3, "tip error {:.1e} m", middle.0);
    let stiff = outcome(1e5, STEP_S);
    assert!(blown_up(stiff.0), "k = 1e5: the paper's step stays stable, tip error {:.1e} m", stiff.0);
    assert!(stiff.1 > 2.5 * own_rad_s, "highest frequencies {:.2e} and {own_rad_s:.2e} rad/s", stiff.1);
    let fine = outcome(1e5, 0.25 * STEP_S);
    assert!(fine.0 < 0.3 * middle.0, "k = 1e5 with a quarter of the step: tip error {:.1e} m", fine.0);
}

/// C-22. Penalty joint: gap and error fall as `1/k`; at a sufficient stiffness the integration with the paper's step is unstable. The short
/// studies omit the revolute joint.
#[test]
#[ignore = "long; `make long` runs it"]
fn c22_penalty_joint_needs_tuning() {
    let cases = [(Between::Ball, [1e6, 1e7, 1e8], 1e9), (Between::Revolute, [1e4, 1e5, 1e6], 1e7)];
    for (between, stiffness, unstable) in cases.into_iter().take(if is_whole() { 2 } else { 1 }) {
        let name = between.name();
        let (system, start) = joint_parameters(between, 2);
        let ours = run_as_printed(&system, &start, 0.3, true);
        let outcome = |position_n_m: f64| {
            // gradients are dimensionless, positions in metres: a factor of 0.01 m² gives both springs similar frequencies here
            let (penalty, start) = penalty_joint(between, 2, position_n_m, 0.01 * position_n_m);
            let samples = run_as_printed(&penalty, &start, 0.3, true);
            let (error_m, gap_m) = (tip_difference(&ours, &samples), largest(&samples, |s| s.gap_m));
            let hinge = largest(&samples, |s| s.hinge);
            let frequency_rad_s = highest_frequency(&penalty, &start);
            println!(
                "{name}, k {position_n_m:.0e} N/m: tip {error_m:.1e} m, gap {gap_m:.1e} m, \
                 |r_x^P + r_z^Q| {hinge:.1e}, {frequency_rad_s:.2e} rad/s"
            );
            (error_m, gap_m)
        };
        let results = stiffness.map(outcome);
        for pair in results.windows(2) {
            let (gap, error) = (pair[0].1 / pair[1].1, pair[0].0 / pair[1].0);
            assert!((4.0..25.0).contains(&gap), "{name}: gap falls by {gap:.1} for ten times the stiffness");
            assert!(error > 1.5, "{name}: error falls by {error:.1} for ten times the stiffness");
        }
        let (error_m, _) = outcome(unstable);
        assert!(blown_up(error_m), "{name}: stable at k = {unstable:.0e} N/m, tip error {error_m:.1e} m");
    }
}
