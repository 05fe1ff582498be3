//! Skates and wheels of the model file.

use crate::file::ModelFile;
use foldwing_engine::machine::NoSlip;
use foldwing_engine::machine::builder::{MachineBuilder, NoSlipBuilder};

/// Adds skates and wheels to a machine.
pub(super) fn add(file: &ModelFile, mut machine: MachineBuilder) -> MachineBuilder {
    let placed = |built: NoSlipBuilder, position_m: Option<f64>| match position_m {
        Some(position_m) => built.position_m(position_m),
        None => built,
    };
    for (name, skate) in &file.skate {
        let built = NoSlip::skate(name, &skate.body, skate.direction)
            .offset_m(skate.offset_m)
            .plane(skate.plane_normal, skate.plane_point_m)
            .hold_normal(skate.hold_normal);
        machine = machine.no_slip(placed(built, skate.position_m));
    }
    for (name, wheel) in &file.wheel {
        let built = NoSlip::wheel(name, &wheel.body, wheel.axis, wheel.radius_m)
            .offset_m(wheel.offset_m)
            .rolling(wheel.rolling)
            .plane(wheel.plane_normal, wheel.plane_point_m)
            .hold_normal(wheel.hold_normal);
        machine = machine.no_slip(placed(built, wheel.position_m));
    }
    machine
}
