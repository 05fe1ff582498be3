//! Closed loops of the model file.

use crate::file::ModelFile;
use foldwing_engine::machine::Closure;
use foldwing_engine::machine::builder::MachineBuilder;

/// Adds the loops to a machine.
pub(super) fn add(file: &ModelFile, mut machine: MachineBuilder) -> MachineBuilder {
    for (name, closure) in &file.closures {
        let bodies = [closure.bodies[0].as_str(), closure.bodies[1].as_str()];
        let stiffness_n_m = closure.stiffness_n_m.unwrap_or_default();
        let start = match closure.rigid {
            true => Closure::rigid(name, bodies).stiffness_n_m(stiffness_n_m),
            false => Closure::between(name, bodies, stiffness_n_m),
        };
        let mut built =
            start.offsets_m(closure.offsets_m).damping_n_s_m(closure.damping_n_s_m).inertia_kg(closure.inertia_kg);
        if let Some(positions_m) = closure.positions_m {
            built = built.positions_m(positions_m);
        }
        machine = machine.closure(built);
    }
    machine
}
