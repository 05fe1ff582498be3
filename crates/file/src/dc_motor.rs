//! Builds the DC motor of a joint in the model file.

use crate::checker::Checker;
use crate::joint_file::JointFile;
use foldwing_engine::machine::{DcMotor, Travel};

/// Builds the DC motor of a joint; `None` if it has none, or after an error.
pub(super) fn build(name: &str, joint: &JointFile, checker: &mut Checker) -> Option<DcMotor> {
    let own = joint.dc_motor.as_ref()?;
    let (key, constant, unit) = match joint.travel() {
        Travel::Rotation => ("torque_constant_N_m_A", own.torque_constant_n_m_a, "a finite torque constant > 0 N·m/A"),
        Travel::Translation => ("force_constant_N_A", own.force_constant_n_a, "a finite force constant > 0 N/A"),
    };
    // another type of joint is reported by the builder of the machine
    let assumed = joint.kind.travel().is_none().then_some(1.0);
    let Some(torque_constant_n_m_a) = constant.or(assumed) else {
        checker.refuse(&["joint", name, "dc_motor", key], unit);
        return None;
    };
    let ratio = joint.motor.as_ref().and_then(|motor| motor.gear_ratio).filter(|_| joint.travel() == Travel::Rotation);
    // an invalid ratio is reported for the motor
    let ratio = ratio.filter(|ratio| (1e-6..=1e6).contains(&ratio.abs()));
    Some(DcMotor {
        resistance_ohm: own.resistance_ohm,
        inductance_h: own.inductance_h,
        torque_constant_n_m_a,
        gear_ratio: ratio.unwrap_or(1.0),
        voltage_v: own.voltage_v,
        start_current_a: own.start_current_a,
    })
}
