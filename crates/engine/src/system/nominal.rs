//! Typical magnitudes of the states of an external integrator, for its error weights.

use crate::beam::section::Section;
use crate::machine::Body;
use crate::math::strain::{CURVATURES, EDGE, FLAP, STRETCH, TWIST};
use crate::multibody::model::Element;

/// Typical magnitude of a curvature in 1/m.
const NOMINAL_CURVATURE: f64 = 1.0;
/// The same of another strain.
const NOMINAL_STRAIN: f64 = 1e-2;
/// Smallest rate of a strain over its magnitude in 1/s.
const NOMINAL_RATE_1_S: f64 = 10.0;
/// Typical magnitudes of a coordinate of a joint and of its rate.
pub(super) const OF_JOINTS: [f64; 2] = [1.0, NOMINAL_RATE_1_S];

/// Typical magnitudes of a strain of an element and of its rate: that of the shortest wave on the mesh, which hardly any result shows. An
/// integrator that resolves such waves to small rates takes steps as short as their period.
pub(super) fn of_strain(body: &Body, element: &Element, strain: usize) -> [f64; 2] {
    let own = if CURVATURES.contains(&strain) { NOMINAL_CURVATURE } else { NOMINAL_STRAIN };
    let section = body.section.at(element.start_m + 0.5 * element.length_m);
    let fastest_rad_s = shortest_wave_rad_s(&section, element.length_m, strain);
    let rate_1_s = if fastest_rad_s.is_finite() { fastest_rad_s.max(NOMINAL_RATE_1_S) } else { NOMINAL_RATE_1_S };
    [own, own * rate_1_s]
}

/// Frequency in rad/s of the shortest wave of a strain that elements of `length_m` represent: `2c/l` of waves of stretch, twist and shear,
/// NOTATION eq. (D22); bending waves have the rotary inertia of their sections.
fn shortest_wave_rad_s(section: &Section, length_m: f64, strain: usize) -> f64 {
    let [yy, _, zz] = section.second_moment_kg_m;
    let wave_1_m = 2.0 / length_m;
    let stiffness = match &section.shear {
        Some(whole) => whole[(strain, strain)],
        None => section.stiffness[(strain, strain)],
    };
    let bending = |rotary_kg_m: f64| {
        wave_1_m * wave_1_m * (stiffness / (section.mass_kg_m + rotary_kg_m * wave_1_m * wave_1_m)).sqrt()
    };
    match strain {
        STRETCH => wave_1_m * (stiffness / section.mass_kg_m).sqrt(),
        TWIST => wave_1_m * (stiffness / (yy + zz)).sqrt(),
        FLAP => bending(zz),
        EDGE => bending(yy),
        _ => wave_1_m * (stiffness / section.mass_kg_m).sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::section::{Material, Outline, Solid};

    /// A strip of 50 × 2 mm in elements of 18.75 mm: waves of stretch at `2/l·√(E/ρ)`, of flapwise bending at `(2/l)²·√(EI/(m + ρI (2/l)²))`.
    #[test]
    fn shortest_waves_are_those_of_the_closed_forms() {
        let (young_pa, density_kg_m3, width_m, height_m, length_m) = (2.83e9, 1425.0, 0.05, 0.002, 0.01875);
        let material = Material { youngs_modulus_pa: young_pa, shear_modulus_pa: 1.0e9, density_kg_m3 };
        let solid = Solid {
            outline: Outline::Rectangle,
            width_m,
            height_m,
            material,
            torsional_rigidity_n_m2: Some(0.18),
            shear_factor: None,
        };
        let section = solid.section();
        let speed_m_s = f64::sqrt(young_pa / density_kg_m3);
        let wave_1_m = 2.0 / length_m;
        let found = shortest_wave_rad_s(&section, length_m, STRETCH);
        assert!((found / (wave_1_m * speed_m_s) - 1.0).abs() < 1e-12, "{found}");
        for (strain, depth_m) in [(FLAP, height_m), (EDGE, width_m)] {
            let gyration_m2 = depth_m * depth_m / 12.0;
            let expected =
                wave_1_m * wave_1_m * speed_m_s * f64::sqrt(gyration_m2 / (1.0 + gyration_m2 * wave_1_m * wave_1_m));
            let found = shortest_wave_rad_s(&section, length_m, strain);
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        }
        let polar_m3 = density_kg_m3 * width_m * height_m * (width_m * width_m + height_m * height_m) / 12.0;
        let found = shortest_wave_rad_s(&section, length_m, TWIST);
        assert!((found / (wave_1_m * f64::sqrt(0.18 / polar_m3)) - 1.0).abs() < 1e-12, "{found}");
    }
}
