//! F-210, F-211: `roll_fold.toml`, two folds that open one after the other.

use super::{machine, percent, run};
use foldwing::machine::Machine;

const MODEL: &str = include_str!("../../../examples/models/roll_fold.toml");

/// Latch times of both folds in s, and the angle of the outer fold in degrees at the latching of the inner one.
fn latching(machine: Machine) -> ([f64; 2], f64) {
    let mut outer_deg = f64::NAN;
    let plant = run(machine, |plant| {
        let outputs = plant.outputs();
        if outputs.latches()[0].count.get() == 0 {
            outer_deg = outputs.joints()[1].angle_rad.to_degrees();
        }
    });
    let latches = plant.outputs().latches();
    assert!(latches.iter().all(|latch| latch.closed.is_on() && latch.count.get() == 1), "{latches:?}");
    ([latches[0].time_s, latches[1].time_s], outer_deg)
}

/// F-210. The folds latch one after the other: when the inner one latches, the outer one still has four fifths of its rotation to go. The
/// latch times are compared with those of a mesh three times as fine at a tolerance of 1e-7: 0.5 %, the effect of the model's tolerance of
/// 1e-4 and of the vibration after the inner latch.
#[test]
fn f210_folds_open_one_after_the_other() {
    let (times_s, outer_deg) = latching(machine(MODEL, &[]));
    let fine = [("elements = 2", "elements = 6"), ("[simulation]", "[solver]\ntolerance = 1e-7\n[simulation]")];
    let (fine_s, _) = latching(machine(MODEL, &fine));
    let off: Vec<f64> = times_s.iter().zip(fine_s).map(|(time, fine)| time / fine - 1.0).collect();
    println!(
        "F-210 latched at {times_s:.5?} s, refined {fine_s:.5?} s, off {:.4?} %; outer fold then at {outer_deg:.1} deg",
        percent(&off)
    );
    assert!(outer_deg > 0.8 * 178.0 && times_s[1] > 5.0 * times_s[0], "{outer_deg} deg, {times_s:?} s");
    assert!(off.iter().all(|off| off.abs() < 5e-3), "{off:?}");
}

/// Rigid panels of the model: two links attached to the end of the inner panel, which does not move.
struct Links {
    /// Whether the latches are closed.
    closed: [bool; 2],
}

impl Links {
    const GRAVITY: f64 = 9.81;
    const LENGTH_M: [f64; 2] = [0.2, 0.13];
    const MASS_KG: [f64; 2] = [0.512 * 0.2, 0.512 * 0.13];
    const ACTUATOR_KG: f64 = 0.02;
    /// Spring, damper, constant torque and latch of each joint.
    const JOINTS: [[f64; 4]; 2] = [[0.3, 0.03, 0.6, 999.0 * 0.3], [0.02, 0.1, 0.15, 150.0]];

    /// Second derivatives of the panels' angles below the horizon, from Lagrange's equations of the two links. State: angles in rad, rates
    /// in rad/s.
    fn rates(&self, [a, b, da, db]: [f64; 4]) -> [f64; 4] {
        let ([la, lb], [ma, mb]) = (Self::LENGTH_M, Self::MASS_KG);
        // the inertia of a plate includes its thickness
        let rod = |mass: f64, length: f64| mass * (length * length / 3.0 + 0.004 * 0.004 / 12.0);
        let (inertia_a, inertia_b) = (rod(ma, la) + (Self::ACTUATOR_KG + mb) * la * la, rod(mb, lb));
        let coupling = 0.5 * mb * la * lb;
        let torque = |joint: usize, angle: f64, rate: f64| {
            let [k, c, t, latch] = Self::JOINTS[joint];
            -(k * angle + c * rate + t) - if self.closed[joint] { latch * angle } else { 0.0 }
        };
        let (inner, outer) = (torque(0, a, da), torque(1, b - a, db - da));
        let (sin, cos) = (a - b).sin_cos();
        let weight_a = Self::GRAVITY * a.cos() * la * (0.5 * ma + Self::ACTUATOR_KG + mb);
        let weight_b = Self::GRAVITY * b.cos() * 0.5 * mb * lb;
        let right_a = inner - outer + weight_a - coupling * sin * db * db;
        let right_b = outer + weight_b + coupling * sin * da * da;
        let mixed = coupling * cos;
        let determinant = inertia_a * inertia_b - mixed * mixed;
        [
            da,
            db,
            (inertia_b * right_a - mixed * right_b) / determinant,
            (inertia_a * right_b - mixed * right_a) / determinant,
        ]
    }

    /// Latch times in s by the classical Runge–Kutta method, with steps of a thousandth of the latch's period.
    fn latch_times_s() -> [f64; 2] {
        const STEP_S: f64 = 1e-5;
        let mut links = Self { closed: [false; 2] };
        let mut times_s = [f64::NAN; 2];
        let mut state = [160f64.to_radians(), 338f64.to_radians(), 0.0, 0.0];
        let plus = |state: [f64; 4], rate: [f64; 4], step: f64| std::array::from_fn(|i| state[i] + step * rate[i]);
        for i in 0..200_000 {
            let k1 = links.rates(state);
            let k2 = links.rates(plus(state, k1, 0.5 * STEP_S));
            let k3 = links.rates(plus(state, k2, 0.5 * STEP_S));
            let k4 = links.rates(plus(state, k3, STEP_S));
            let next: [f64; 4] =
                std::array::from_fn(|j| state[j] + STEP_S / 6.0 * (k1[j] + 2.0 * (k2[j] + k3[j]) + k4[j]));
            let folds = |state: [f64; 4]| [state[0], state[1] - state[0]];
            for (joint, (before, after)) in folds(state).into_iter().zip(folds(next)).enumerate() {
                if !links.closed[joint] && after <= 0.0 {
                    links.closed[joint] = true;
                    times_s[joint] = STEP_S * (f64::from(i) + before / (before - after));
                }
            }
            state = next;
        }
        times_s
    }
}

/// F-211. The machine with panels a thousand times as stiff against two rigid links by Lagrange's equations: latch times within 0.05 %, the
/// effect of the remaining bending under the latch torque and of the solver's tolerance of 1e-6. The latch times of the elastic wing differ
/// by less than a tenth: bending contributes, but does not dominate.
#[test]
fn f211_stiff_panels_are_two_links() {
    let rigid_s = Links::latch_times_s();
    let stiff = [
        ("youngs_modulus_Pa = 6.0e10", "youngs_modulus_Pa = 6.0e13"),
        ("stiffness_damping_s = 1e-4", "stiffness_damping_s = 1e-7"),
        ("[simulation]", "[solver]\ntolerance = 1e-6\n[simulation]"),
    ];
    let off = |times_s: [f64; 2]| [0, 1].map(|i| times_s[i] / rigid_s[i] - 1.0);
    let (stiff, shipped) = (off(latching(machine(MODEL, &stiff)).0), off(latching(machine(MODEL, &[])).0));
    println!(
        "F-211 rigid links latch at {rigid_s:.5?} s; stiff panels off {:.4?} %, the shipped wing {:.4?} %",
        percent(&stiff),
        percent(&shipped)
    );
    assert!(stiff.iter().all(|off| off.abs() < 5e-4), "{stiff:?}");
    assert!(shipped.iter().all(|off| off.abs() < 0.1), "{shipped:?}");
}
