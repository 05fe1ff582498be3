//! Strain and stress at any point of a solid section from its strain measures (\[M\] 16–19, 30).
//!
//! The measures `(γ₁, k₁, k₂, k₃)` are the strains `(εx, κx, κy, κz)` minus the natural ones. Components are in the section frame: index 1
//! along the axis, 2 along `y`, 3 along `z`. As in \[M\], terms of the order of strain times curvature times thickness are neglected, and
//! with them the shear due to transverse forces.

use crate::beam::section::{Material, Outline, Section, Solid};
use crate::math::strain::{EDGE, FLAP, STRETCH, Strain, TWIST};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// Green–Lagrange strain `E` (3×3, symmetric, –) at the point `(y, z)` in m of a solid section with the strain
/// `measures` `(γ₁, k₁, k₂, k₃)` in –, 1/m; NOTATION eqs. (R1)–(R4).
///
/// Poisson's ratio of the material determines `E₂₂` and `E₃₃`; they are zero if it is not known. The point must be within the section:
/// outside a rectangle the series of its warping function diverges.
pub fn strain_tensor(solid: &Solid, measures: &Strain, y_m: f64, z_m: f64) -> Matrix3<f64> {
    let axial = measures[STRETCH] + z_m * measures[FLAP] - y_m * measures[EDGE];
    let lateral = -solid.material.poisson_ratio().unwrap_or(0.0) * axial;
    let [along_y, along_z] = torsion_shear(solid, y_m, z_m).map(|shear| 0.5 * shear * measures[TWIST]);
    Matrix3::new(axial, along_y, along_z, along_y, lateral, 0.0, along_z, 0.0, lateral)
}

/// Second Piola–Kirchhoff stress in Pa of an isotropic material, `S = 2μ E + λ tr(E) I` (\[M\] 19), NOTATION eq. (R5).
///
/// `None` if Poisson's ratio is not known, or is ½, for which `λ` is unbounded.
pub fn stress_tensor(material: &Material, strain: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let ratio = material.poisson_ratio()?;
    let lambda = material.youngs_modulus_pa * ratio / ((1.0 + ratio) * (1.0 - 2.0 * ratio));
    let stress = strain * (2.0 * material.shear_modulus_pa) + Matrix3::from_diagonal_element(lambda * strain.trace());
    (1.0 - 2.0 * ratio > 1e-12).then_some(stress)
}

/// Warping displacement `(w₁, w₂, w₃)` in m at a point, NOTATION eqs. (R2)–(R4).
///
/// `w₁` is the Saint-Venant warping of the outline. In \[M\] (30) the term of `w₂` with `k₃` has the opposite sign; with it neither `S₂₂`
/// nor `S₂₃` would vanish.
pub fn warping(solid: &Solid, measures: &Strain, y_m: f64, z_m: f64) -> Vector3<f64> {
    let ratio = solid.material.poisson_ratio().unwrap_or(0.0);
    let [stretch, twist, bend_y, bend_z] = [STRETCH, TWIST, FLAP, EDGE].map(|strain| measures[strain]);
    let half_difference = 0.5 * (z_m * z_m - y_m * y_m);
    Vector3::new(
        twist * torsion_warping(solid, y_m, z_m),
        ratio * (-stretch * y_m - bend_y * y_m * z_m - bend_z * half_difference),
        ratio * (-stretch * z_m + bend_z * y_m * z_m - bend_y * half_difference),
    )
}

/// Weights of the strain measures in the reading of a strain gauge on a fibre through `(y, z)` along the unit vector `direction`: the
/// reading `row · (γ₁, k₁, k₂, k₃)` is the component `n·E n`; NOTATION eq. (R6).
pub fn gauge_row(solid: &Solid, y_m: f64, z_m: f64, direction: &Vector3<f64>) -> Strain {
    Strain::from_fn(|i, _| {
        let mut unit = Strain::zeros();
        unit[i] = 1.0;
        direction.dot(&(strain_tensor(solid, &unit, y_m, z_m) * direction))
    })
}

/// Weights for a gauge along the beam axis, for any section: `(1, 0, z, −y)`, NOTATION eq. (R1).
pub fn axial_row(y_m: f64, z_m: f64) -> Strain {
    let mut row = Strain::zeros();
    (row[STRETCH], row[FLAP], row[EDGE]) = (1.0, z_m, -y_m);
    row
}

/// Strain `E₁₁` of the largest magnitude on a section, and its point `[y, z]` in m; NOTATION eq. (R7).
///
/// The point is on the boundary: on an ellipse where the normal has the direction of the strain gradient, otherwise in a corner of the box
/// `±half_width_m`, `±half_height_m`.
pub fn maximum_axial_strain(outline: Option<Outline>, section: &Section, measures: &Strain) -> (f64, [f64; 2]) {
    let [stretch, bend_y, bend_z] = [STRETCH, FLAP, EDGE].map(|strain| measures[strain]);
    let (a, b) = (section.half_width_m, section.half_height_m);
    let side = if stretch < 0.0 { -1.0 } else { 1.0 };
    // point of the outline with the largest |−y k₃ + z k₂|, on the side where bending adds to the stretch
    let point = match outline {
        Some(Outline::Ellipse) => {
            let reach = (a * bend_z).hypot(b * bend_y);
            if reach > 0.0 { [-a * a * bend_z / reach * side, b * b * bend_y / reach * side] } else { [0.0, b] }
        }
        _ => [-a * bend_z.signum() * side, b * bend_y.signum() * side],
    };
    (stretch + point[1] * bend_y - point[0] * bend_z, point)
}

/// Shear strains `(2E₁₂, 2E₁₃)` per twist at a point, in m: Saint-Venant torsion of the outline, NOTATION eqs. (R3), (R4).
fn torsion_shear(solid: &Solid, y: f64, z: f64) -> [f64; 2] {
    let (a, b) = (0.5 * solid.width_m, 0.5 * solid.height_m);
    match solid.outline {
        Outline::Ellipse => {
            let sum = a * a + b * b;
            [-2.0 * a * a * z / sum, 2.0 * b * b * y / sum]
        }
        // shear follows the contours of Prandtl's stress function, which is symmetric with respect to exchanging the sides
        Outline::Rectangle => [prandtl_slope(y, z, a, b), -prandtl_slope(z, y, b, a)],
    }
}

/// Derivative `∂Φ/∂z` in m of Prandtl's stress function of the rectangle `|y| ≤ a`, `|z| ≤ b`: `∇²Φ = −2`, `Φ = 0` on the boundary; eq.
/// (R4).
///
/// Of the two series the one that converges faster at the point is used; at the corners, where both are slow, the one that vanishes there.
fn prandtl_slope(y: f64, z: f64, a: f64, b: f64) -> f64 {
    let (off_y, off_z) = ((a - y.abs()).max(0.0) / b, (b - z.abs()).max(0.0) / a);
    if off_y > off_z {
        // −2z + (16b/π²) Σ s_n/n² cosh(nπy/2b)/cosh(nπa/2b) sin(nπz/2b)
        let sum = odd_series(2, |n| {
            ratio_of_cosh(n * PI * y / (2.0 * b), n * PI * a / (2.0 * b)) * (n * PI * z / (2.0 * b)).sin()
        });
        -2.0 * z + 16.0 * b / (PI * PI) * sum
    } else {
        // −(16a/π²) Σ s_n/n² sinh(nπz/2a)/cosh(nπb/2a) cos(nπy/2a)
        let sum = odd_series(2, |n| {
            ratio_of_sinh(n * PI * z / (2.0 * a), n * PI * b / (2.0 * a)) * (n * PI * y / (2.0 * a)).cos()
        });
        -16.0 * a / (PI * PI) * sum
    }
}

/// Saint-Venant warping function in m² (displacement per twist).
fn torsion_warping(solid: &Solid, y: f64, z: f64) -> f64 {
    let (a, b) = (0.5 * solid.width_m, 0.5 * solid.height_m);
    match solid.outline {
        Outline::Ellipse => (b * b - a * a) / (a * a + b * b) * y * z,
        Outline::Rectangle if a >= b => rectangle_warping(y, z, a, b),
        Outline::Rectangle => -rectangle_warping(z, y, b, a),
    }
}

/// Warping function of the rectangle: `−yz + (32b²/π³) Σ s_n/n³ sinh(nπy/2b)/cosh(nπa/2b) sin(nπz/2b)`, eq. (R4).
fn rectangle_warping(y: f64, z: f64, a: f64, b: f64) -> f64 {
    let sum = odd_series(3, |n| {
        ratio_of_sinh(n * PI * y / (2.0 * b), n * PI * a / (2.0 * b)) * (n * PI * z / (2.0 * b)).sin()
    });
    -y * z + 32.0 * b * b / PI.powi(3) * sum
}

/// Sum `Σ (−1)^((n−1)/2) n^(−power) term(n)` over 400 odd `n`: the remainder is below 4e-7 even if the terms do not decay.
fn odd_series(power: i32, term: impl Fn(f64) -> f64) -> f64 {
    (0..400)
        .map(|i| {
            let n = f64::from(2 * i + 1);
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            sign * term(n) / n.powi(power)
        })
        .sum()
}

/// `cosh x / cosh c` for `|x| ≤ c` without overflow.
fn ratio_of_cosh(x: f64, c: f64) -> f64 {
    let x = x.abs();
    (x - c).exp() * (1.0 + (-2.0 * x).exp()) / (1.0 + (-2.0 * c).exp())
}

/// `sinh x / cosh c` for `|x| ≤ c` without overflow.
fn ratio_of_sinh(x: f64, c: f64) -> f64 {
    let (size, sign) = (x.abs(), x.signum());
    sign * (size - c).exp() * (1.0 - (-2.0 * size).exp()) / (1.0 + (-2.0 * c).exp())
}

#[cfg(test)]
#[path = "recovery_tests.rs"]
mod tests;
