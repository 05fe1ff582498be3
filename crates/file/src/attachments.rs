//! Attachments of bodies: point masses, rigid bodies, loads, gauges and internal-load sections.

use crate::file::{ModelFile, SectionSideFile};
use foldwing_engine::load::Wrench;
use foldwing_engine::machine::builder::MachineBuilder;
use foldwing_engine::machine::{AttachedMass, Gauge, InternalLoad};
use nalgebra::Matrix3;

/// Adds the attachments to a machine. Gauges on bodies with an invalid section are omitted.
pub(super) fn add(file: &ModelFile, lawless: &[&str], mut machine: MachineBuilder) -> MachineBuilder {
    for (name, mass) in &file.mass {
        let [xx, yy, zz, xy, xz, yz] = mass.inertia_kg_m2;
        let attached = AttachedMass {
            name: name.clone(),
            position_m: mass.position_m,
            mass_kg: mass.mass_kg,
            offset_m: mass.offset_m.into(),
            inertia_kg_m2: Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            allow_nonphysical_inertia: false,
        };
        machine = machine.mass(&mass.body, attached);
    }
    for (name, load) in &file.load {
        let wrench = Wrench { force_n: load.force_n.into(), moment_n_m: load.moment_n_m.into() };
        machine = machine.load(name, &load.body, load.station, wrench);
    }
    for (name, gauge) in file.gauge.iter().filter(|(_, gauge)| !lawless.contains(&gauge.body.as_str())) {
        let mut built = Gauge::on(name, &gauge.body, gauge.position_m).y_m(gauge.y_m);
        if let Some(z_m) = gauge.z_m {
            built = built.z_m(z_m);
        }
        if let Some(direction) = gauge.direction {
            built = built.direction(direction);
        }
        machine = machine.gauge(built);
    }
    for (name, place) in &file.internal_load {
        let built = InternalLoad::on(name, &place.body, place.position_m);
        machine = machine.internal_load(match place.side {
            SectionSideFile::Inboard => built,
            SectionSideFile::Outboard => built.outboard(),
        });
    }
    machine
}
