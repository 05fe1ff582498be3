//! Typical magnitudes of the states of an external integrator, for its error weights.

use crate::beam::section::Section;
use crate::machine::Body;
use crate::math::strain::{CURVATURES, LINEAR, STRETCH};
use crate::multibody::model::Element;

/// Typical magnitude of a curvature in 1/m.
const NOMINAL_CURVATURE: f64 = 1.0;
/// Typical magnitude of any other strain.
const NOMINAL_STRAIN: f64 = 1e-2;
/// Rate of a coordinate over its magnitude in 1/s, unless it is that of a fast wave.
const NOMINAL_RATE_1_S: f64 = 10.0;
/// Typical magnitudes of a coordinate of a joint and of its rate.
pub(super) const OF_JOINTS: [f64; 2] = [1.0, NOMINAL_RATE_1_S];

/// Typical magnitudes of a strain of an element and of its rate. Stretch and shear rates are those of the shortest wave on the mesh: no
/// result shows it, and an integrator that resolves it to small rates takes steps as short as its period. Curvature rates are those of slow
/// motions, into which their errors grow.
pub(super) fn of_strain(body: &Body, element: &Element, strain: usize) -> [f64; 2] {
    let own = if CURVATURES.contains(&strain) { NOMINAL_CURVATURE } else { NOMINAL_STRAIN };
    let mut rate_1_s = NOMINAL_RATE_1_S;
    if LINEAR.contains(&strain) {
        let section = body.section.at(element.start_m + 0.5 * element.length_m);
        let fastest_rad_s = shortest_wave_rad_s(&section, element.length_m, strain);
        if fastest_rad_s.is_finite() {
            rate_1_s = fastest_rad_s.max(NOMINAL_RATE_1_S);
        }
    }
    [own, own * rate_1_s]
}

/// Frequency in rad/s of the shortest wave of stretch or shear that elements of `length_m` represent, `2c/l`, NOTATION eq. (D22).
fn shortest_wave_rad_s(section: &Section, length_m: f64, strain: usize) -> f64 {
    let stiffness_n = match &section.shear {
        Some(whole) => whole[(strain, strain)],
        None => section.stiffness[(STRETCH, STRETCH)],
    };
    2.0 / length_m * (stiffness_n / section.mass_kg_m).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::section::{Material, Outline, Solid};
    use crate::math::strain::SHEAR_Z;

    /// A strip of 50 × 2 mm in elements of 18.75 mm: waves of stretch at `2/l·√(E/ρ)`, of shear at `2/l·√(kG/ρ)`.
    #[test]
    fn shortest_waves_are_those_of_the_closed_forms() {
        let (young_pa, shear_pa, density_kg_m3, length_m) = (2.83e9, 1.0e9, 1425.0, 0.01875);
        let solid = Solid {
            outline: Outline::Rectangle,
            width_m: 0.05,
            height_m: 0.002,
            material: Material { youngs_modulus_pa: young_pa, shear_modulus_pa: shear_pa, density_kg_m3 },
            torsional_rigidity_n_m2: None,
            shear_factor: None,
        };
        let expected = 2.0 / length_m * f64::sqrt(young_pa / density_kg_m3);
        let sheared = Solid { shear_factor: Some(0.8), ..solid };
        for section in [solid.section(), sheared.section()] {
            let found = shortest_wave_rad_s(&section, length_m, STRETCH);
            assert!((found / expected - 1.0).abs() < 1e-12, "{found}");
        }
        let found = shortest_wave_rad_s(&sheared.section(), length_m, SHEAR_Z);
        let expected = 2.0 / length_m * f64::sqrt(0.8 * shear_pa / density_kg_m3);
        assert!((found / expected - 1.0).abs() < 1e-12, "{found}");
    }
}
