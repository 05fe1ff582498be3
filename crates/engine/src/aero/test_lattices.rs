//! Lattices, sections and flows for unit tests of the lattice.

use crate::aero::flow::Flow;
use crate::aero::lattice::{LatticeOptions, LoadRule, WakeModel};
use crate::aero::surface::ChordLine;
use crate::load::SectionMotion;
use nalgebra::Vector3;

/// Options with a prescribed wake of ten rows, a vortex core of 0.02 m, loads by Bernoulli's equation, no images and no compressibility.
pub(super) fn options() -> LatticeOptions {
    LatticeOptions {
        wake: WakeModel::Prescribed,
        wake_rows: 10,
        core_radius_m: 0.02,
        load_rule: LoadRule::Bernoulli,
        mirror_normal: None,
        ground: None,
        speed_of_sound_m_s: None,
        threads: 1,
    }
}

/// A chord of 1 m along `y`; its leading edge is 0.25 m in front of the axis.
pub(super) fn chord() -> ChordLine {
    ChordLine { leading_m: Vector3::y() * 0.25, trailing_m: Vector3::y() * -0.75 }
}

/// A section at a position, without velocity, rotated about `x` by the pitch angle.
pub(super) fn section(position_m: Vector3<f64>, pitch_rad: f64) -> SectionMotion {
    SectionMotion {
        rotation: nalgebra::Rotation3::from_axis_angle(&Vector3::x_axis(), pitch_rad).into_inner(),
        position_m,
        velocity_m_s: Vector3::zeros(),
        spin_rad_s: Vector3::zeros(),
    }
}

/// Uniform flow with a density of 1.2 kg/m³.
pub(super) fn flow(wind_m_s: Vector3<f64>) -> Flow<'static> {
    Flow { time_s: 0.0, density_kg_m3: 1.2, wind_m_s, spin_rad_s: Vector3::zeros(), gusts: &[] }
}
