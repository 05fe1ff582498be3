//! Tubes, rectangles and ellipses of one material, by exact solutions.

use super::materials::Material;
use super::properties::{Moments, Raw};
use foldwing_engine::beam::section::{ellipse_torsion_constant_m4, rectangle_torsion_constant_m4};
use std::f64::consts::PI;

/// Section of one material with two axes of symmetry: area, `∫y² dA`, `∫z² dA`, torsion constant, shear areas.
struct Symmetric {
    area_m2: f64,
    second_m4: [f64; 2],
    torsion_m4: f64,
    shear_areas_m2: [f64; 2],
    half_m: [f64; 2],
}

impl Symmetric {
    fn raw(&self, material: &Material) -> Raw {
        let weighted = |weight: f64| Moments {
            whole: weight * self.area_m2,
            first: [0.0; 2],
            second: [weight * self.second_m4[0], 0.0, weight * self.second_m4[1]],
        };
        Raw {
            stiffness: weighted(material.youngs_modulus_pa),
            mass: weighted(material.density_kg_m3),
            torsional_rigidity_n_m2: material.shear_modulus_pa * self.torsion_m4,
            shear_stiffnesses_n: self.shear_areas_m2.map(|area| material.shear_modulus_pa * area),
            shear_centre_m: [0.0; 2],
            warping_stiffness_n_m4: 0.0,
            reach_m: self.half_m.map(|half| [-half, half]),
        }
    }
}

/// Round tube with outer diameter and wall thickness in m. Torsion and bending are exact; shear follows from the energy of
/// Saint-Venant's flexure of a ring, NOTATION eq. (S14). With a wall of half the diameter it is a solid rod.
pub(in crate::shapes) fn tube(diameter_m: f64, wall_m: f64, material: &Material) -> Raw {
    let (a, b) = (0.5 * diameter_m, 0.5 * diameter_m - wall_m);
    let area_m2 = PI * wall_m * (a + b);
    let second = 0.25 * area_m2 * (a * a + b * b);
    let ratio = material.poisson_ratio();
    // shear stresses (P cos θ, Q sin θ) with P = K (r² − s + p/r²), Q = K (s + p/r²) − (1 − 2ν) r²/4; ∫(P² + Q²) r dr by powers of r
    let (k, c) = (0.75 + 0.5 * ratio, 0.25 * (1.0 - 2.0 * ratio));
    let (s, p) = (a * a + b * b, a * a * b * b);
    let power = |n: i32| (a.powi(n) - b.powi(n)) / f64::from(n);
    let inverse = if b > 0.0 { p * p * 0.5 * (b.powi(-2) - a.powi(-2)) } else { 0.0 };
    let logarithm = if b > 0.0 { p * (a / b).ln() } else { 0.0 };
    let radial = power(6) - 2.0 * s * power(4) + (s * s + 2.0 * p) * power(2) - 2.0 * s * logarithm + inverse;
    let across = s * s * power(2) + 2.0 * s * logarithm + inverse;
    let mixed = s * power(4) + p * power(2);
    let energy = k * k * (radial + across) - 2.0 * k * c * mixed + c * c * power(6);
    let shear_area = 4.0 * ((1.0 + ratio) * second).powi(2) / (PI * energy);
    Symmetric {
        area_m2,
        second_m4: [second; 2],
        torsion_m4: 2.0 * second,
        shear_areas_m2: [shear_area; 2],
        half_m: [a; 2],
    }
    .raw(material)
}

/// Solid rectangle with sides along `y` and `z` in m; torsion by NOTATION eq. (S2), shear by eq. (S15).
pub(in crate::shapes) fn rectangle(width_m: f64, height_m: f64, material: &Material) -> Raw {
    let area_m2 = width_m * height_m;
    let shear = |across: f64, along: f64| rectangle_shear_area_m2(across, along, material.poisson_ratio());
    Symmetric {
        area_m2,
        second_m4: [area_m2 * width_m * width_m / 12.0, area_m2 * height_m * height_m / 12.0],
        torsion_m4: rectangle_torsion_constant_m4(width_m, height_m),
        shear_areas_m2: [shear(height_m, width_m), shear(width_m, height_m)],
        half_m: [0.5 * width_m, 0.5 * height_m],
    }
    .raw(material)
}

/// Shear area of a rectangle for a force along the side `along_m`, NOTATION eq. (S15).
///
/// The terms decrease with `n⁻⁴`; after 200 terms the error is below 1e-7 of the sum.
fn rectangle_shear_area_m2(across_m: f64, along_m: f64, poisson_ratio: f64) -> f64 {
    let (b, h) = (across_m, along_m);
    let sum: f64 = (1..=200)
        .map(|n| {
            let n = f64::from(n);
            let wave = 2.0 * n * PI / b;
            b.powi(5) / (8.0 * (n * PI).powi(4)) * (h - 2.0 / wave * (0.5 * wave * h).tanh())
        })
        .sum();
    let second = b * h.powi(3) / 12.0;
    let anticlastic = poisson_ratio / (1.0 + poisson_ratio);
    1.0 / (1.2 / (b * h) + (anticlastic / second).powi(2) * sum)
}

/// Solid ellipse with full axes along `y` and `z` in m; torsion by NOTATION eq. (S3), shear by eq. (S16).
pub(in crate::shapes) fn ellipse(width_m: f64, height_m: f64, material: &Material) -> Raw {
    let (a, b) = (0.5 * width_m, 0.5 * height_m);
    let area_m2 = PI * a * b;
    let shear = |across: f64, along: f64| ellipse_shear_area_m2(across, along, material.poisson_ratio());
    Symmetric {
        area_m2,
        second_m4: [0.25 * area_m2 * a * a, 0.25 * area_m2 * b * b],
        torsion_m4: ellipse_torsion_constant_m4(width_m, height_m),
        shear_areas_m2: [shear(b, a), shear(a, b)],
        half_m: [a, b],
    }
    .raw(material)
}

/// Shear area of an ellipse with half axes in m for a force along the second axis, NOTATION eq. (S16).
fn ellipse_shear_area_m2(across_m: f64, along_m: f64, poisson_ratio: f64) -> f64 {
    let (a, b, ratio) = (across_m, along_m, poisson_ratio);
    let (a2, b2) = (a * a, b * b);
    let (area, second) = (PI * a * b, 0.25 * PI * a * b * b2);
    let denominator = (1.0 + ratio) * (3.0 * b2 + a2);
    // stresses along the force: c (b² − z² − e y²), and perpendicular to it: −d y z, for a force divided by the second moment of area
    let c = (2.0 * (1.0 + ratio) * b2 + a2) / (2.0 * denominator);
    let e = (1.0 - 2.0 * ratio) * b2 / (2.0 * (1.0 + ratio) * b2 + a2);
    let d = ((1.0 + ratio) * b2 + ratio * a2) / denominator;
    // mean values over the ellipse: z² → b²/4, z⁴ → b⁴/8, y² z² → a² b²/24
    let square =
        b2 * b2 - 0.5 * b2 * b2 + b2 * b2 / 8.0 - 0.5 * e * a2 * b2 + e * a2 * b2 / 12.0 + e * e * a2 * a2 / 8.0;
    let mean = c * c * square + d * d * a2 * b2 / 24.0;
    second * second / (area * mean)
}
