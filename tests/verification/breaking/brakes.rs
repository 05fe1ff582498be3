//! A brake whose torque rises in a ramp.

use crate::breaking::*;
use foldwing::machine::Failure;
use foldwing::machine::failure::FrictionBrake;

const RATE_RAD_S: f64 = 3.0;
const TORQUE_N_M: f64 = 0.1;

/// FL-15. A rotor under a brake slows as its torque grows, `ω = ω₀ − T/J (t − ½ t_r)`, and creeps to a stop; its kinetic energy is
/// dissipated.
#[test]
fn fl15_a_brake_stops_a_rotor() {
    let brake = FrictionBrake { torque_n_m: TORQUE_N_M, ramp_s: 0.1, slip_rad_s: 1e-3 };
    let failures = [
        Failure::motor_loss("motor", "hinge").at_time_s(0.05),
        Failure::brake_applied("brake", "hinge", brake).after("motor").delay_s(0.1),
    ];
    let mut plant = start(rotor(|joint| joint.start_rate_rad_s(RATE_RAD_S), &failures));
    assert!(drift_j(&mut plant, 0.5, 7) < 1e-8);
    assert_eq!(failed_s(&plant, 1), Some(0.05 + 0.1));
    let expected = |time_s: f64| RATE_RAD_S - TORQUE_N_M / INERTIA_KG_M2 * (time_s - 0.15 - 0.05);
    let found = plant.outputs().joints()[0].rate_rad_s;
    assert!((found - expected(0.5)).abs() < 1e-8, "{found} rad/s for {}", expected(0.5));
    let stops_s = 0.15 + 0.05 + RATE_RAD_S * INERTIA_KG_M2 / TORQUE_N_M;
    assert!(drift_j(&mut plant, stops_s + 0.1, 20) < 1e-7);
    let found = plant.outputs().joints()[0].rate_rad_s;
    assert!(found.abs() < 1e-4, "{found} rad/s");
    let kinetic_j = 0.5 * INERTIA_KG_M2 * RATE_RAD_S * RATE_RAD_S;
    assert!((plant.outputs().energy().dissipated - kinetic_j).abs() < 1e-7);
}
