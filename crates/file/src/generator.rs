//! Generator in the model file: its keys, and the torque law of the machine.

use crate::joint_file::{JointFile, JointType};
use crate::validate::Checker;
use foldwing_engine::machine::{Beyond, GeneratorLaw};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// Generator on the high-speed shaft of a revolute joint's motor: torque as a function of speed. Speeds refer to the
/// high-speed shaft: the joint rate times `gear_ratio` of `[joint.<name>.motor]`; torque against the motion is
/// positive.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct GeneratorFile {
    /// Rows `[speed in rpm, torque in N·m]`, speeds ascending, linear between rows.
    #[serde(rename = "table_rpm_N_m")]
    #[schemars(length(min = 1, max = 1000), extend("x-allowed" = "1 to 1000 rows [speed in rpm, torque in N·m] of finite numbers, speeds ascending"))]
    pub table_rpm_n_m: Vec<[f64; 2]>,
    /// Torque over the square of the speed below the first row, in N·m/rpm²; default: the torque of the first row.
    #[serde(rename = "quadratic_gain_N_m_rpm2")]
    #[schemars(range(min = 0.0))]
    pub quadratic_gain_n_m_rpm2: Option<f64>,
    /// Quantity that is constant above the last row, default `constant_torque`.
    #[serde(default)]
    pub above_table: AboveTableFile,
    /// Ratio of electrical to mechanical power, default 1.
    #[serde(default = "whole")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub efficiency: f64,
    /// Start value of the input `<joint>.generator_on`: false disconnects it. Default true.
    #[serde(default = "yes")]
    pub on: bool,
}

/// Quantity that is constant above the table of a generator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum AboveTableFile {
    /// The torque of the last row.
    #[default]
    ConstantTorque,
    /// The power of the last row.
    ConstantPower,
}

/// Range of the magnitude of a motor's gear ratio.
const MAGNITUDES: RangeInclusive<f64> = 1e-6..=1e6;

fn whole() -> f64 {
    1.0
}

fn yes() -> bool {
    true
}

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
