//! Builds the torque law of a generator in the model file.

use crate::checker::Checker;
use crate::freedom_file::AboveTableFile;
use crate::joint_file::{JointFile, JointType};
use foldwing_engine::machine::{Beyond, GeneratorLaw};
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// Range of the magnitude of a motor's gear ratio.
const MAGNITUDES: RangeInclusive<f64> = 1e-6..=1e6;

/// Builds the generator of a joint; `None` if it has none, or after an error.
pub(super) fn build(name: &str, joint: &JointFile, checker: &mut Checker) -> Option<GeneratorLaw> {
    let generator = joint.generator.as_ref()?;
    let stated = joint.motor.as_ref().and_then(|motor| motor.gear_ratio);
    // a generator on another type of joint is reported by the builder of the machine
    let assumed = (joint.kind != JointType::Revolute).then_some(1.0);
    let Some(gear_ratio) = stated.or(assumed) else {
        let allowed = "a finite ratio other than 0, because the joint has a generator; 1.0 without a gearbox";
        checker.refuse(&["joint", name, "motor", "gear_ratio"], allowed);
        return None;
    };
    if !generator.table_rpm_n_m.windows(2).all(|pair| pair[0][0] < pair[1][0]) {
        let allowed = "rows [speed in rpm, torque in N·m] with ascending speeds";
        checker.refuse(&["joint", name, "generator", "table_rpm_N_m"], allowed);
        return None;
    }
    let last = generator.table_rpm_n_m.last().map_or(0.0, |row| row[0]);
    if generator.above_table == AboveTableFile::ConstantPower && last <= 0.0 {
        let allowed =
            "a last row at a speed > 0, above which its power is held constant; or above_table = \"constant_torque\"";
        checker.refuse(&["joint", name, "generator", "table_rpm_N_m"], allowed);
        return None;
    }
    if !MAGNITUDES.contains(&gear_ratio.abs()) {
        return None; // already reported for the motor
    }
    let radians = PI / 30.0;
    Some(GeneratorLaw {
        gear_ratio,
        rows: generator.table_rpm_n_m.iter().map(|[rpm, torque_n_m]| [rpm * radians, *torque_n_m]).collect(),
        square_gain_n_m_s2: generator.quadratic_gain_n_m_rpm2.map(|gain| gain / (radians * radians)),
        beyond: match generator.above_table {
            AboveTableFile::ConstantTorque => Beyond::Torque,
            AboveTableFile::ConstantPower => Beyond::Power,
        },
        efficiency: generator.efficiency,
        connected: generator.on,
    })
}
