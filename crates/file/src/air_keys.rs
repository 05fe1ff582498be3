//! Keys of aerodynamic models, and their settings.

use crate::air_file::{AirFile, CouplingFile};
use crate::air_part_file::{IndicialFile, TipLossFile};
use foldwing_engine::aero::lattice::WakeModel;
use foldwing_engine::aero::strip::indicial::Fit;
use foldwing_engine::machine::Coupling;
use foldwing_engine::machine::builder::AirBuilder;

/// Keys of `[aerodynamics]` and of `[surface.<name>]` that only the lattice uses, and those that only strip theory uses.
pub(super) const LATTICE_KEYS: &[&str] = &["free_wake", "wake_rows", "threads", "ground_normal", "ground_distance_m"];
/// Keys of `[aerodynamics]` used by the lattice and by a lifting line.
pub(super) const SPAN_KEYS: &[&str] = &["mirror_normal", "core_radius_m"];
pub(super) const LATTICE_SURFACE_KEYS: &[&str] = &["chord_panels"];
pub(super) const STRIP_KEYS: &[&str] = &["quasi_steady", "apparent_mass", "indicial", "tip_loss"];
/// Keys of `[surface.<name>]` that describe the profile, used by strip theory and the lattice.
pub(super) const PROFILE_KEYS: &[&str] =
    &["lift_slope_1_rad", "zero_lift_angle_deg", "moment_coefficient", "drag_coefficient", "polar"];

pub(super) fn build(base: AirBuilder, air: &AirFile) -> AirBuilder {
    let mut built = base
        .density_kg_m3(air.density_kg_m3)
        .wind_m_s(air.wind_m_s)
        .established(air.steady_initial_flow)
        .reports_circulation(air.report_circulation)
        .unsteady(!air.quasi_steady)
        .apparent_mass(air.apparent_mass)
        .fit(match air.indicial {
            IndicialFile::Jones => Fit::Jones,
            IndicialFile::Fine => Fit::Fine,
        })
        .tip_loss(air.tip_loss == TipLossFile::LiftingLine)
        .wake(if air.free_wake { WakeModel::Free } else { WakeModel::Prescribed })
        .wake_rows(air.wake_rows)
        .threads(air.threads)
        .coupling(match air.coupling {
            CouplingFile::Staggered => Coupling::Staggered,
            CouplingFile::Iterated => {
                Coupling::Iterated { tolerance: air.coupling_tolerance, most_iterations: air.coupling_iterations }
            }
        });
    if let Some(step_s) = air.step_s {
        built = built.step_s(step_s);
    }
    if let Some(suction) = air.leading_edge_suction {
        built = built.leading_edge_suction(suction);
    }
    if let Some(normal) = air.mirror_normal {
        built = built.mirror_normal(normal);
    }
    if let (Some(normal), Some(distance_m)) = (air.ground_normal, air.ground_distance_m) {
        built = built.ground(normal, distance_m);
    }
    if let Some(speed_m_s) = air.speed_of_sound_m_s {
        built = built.speed_of_sound_m_s(speed_m_s);
    }
    if let Some(radius_m) = air.core_radius_m {
        built = built.core_radius_m(radius_m);
    }
    built
}
