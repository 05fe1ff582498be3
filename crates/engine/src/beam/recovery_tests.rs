//! Strain recovery: strains follow from the warping and leave the lateral surface stress-free, and torsion integrates to the torsion
//! constant.

use super::*;
use crate::math::strain::STRAINS;

const MATERIAL: Material = Material { youngs_modulus_pa: 70e9, shear_modulus_pa: 28e9, density_kg_m3: 2700.0 };

fn solid(outline: Outline, width_m: f64, height_m: f64) -> Solid {
    Solid { outline, width_m, height_m, material: MATERIAL, torsional_rigidity_n_m2: None, shear_factor: None }
}

const MEASURES: [f64; STRAINS] = [1e-3, 4e-3, -2e-3, 3e-3];

/// \[M\] (17): the strain components are derivatives of the warping, here by central differences, plus the rotation and stretch of the
/// section.
#[test]
fn strains_are_the_derivatives_of_the_warping() {
    let k = Strain::from(MEASURES);
    for outline in [Outline::Ellipse, Outline::Rectangle] {
        for (width, height) in [(2.0, 0.5), (0.3, 0.7)] {
            let solid = solid(outline, width, height);
            for (fy, fz) in [(0.1, 0.2), (-0.3, 0.35), (0.33, -0.3), (0.0, 0.48), (0.47, 0.05)] {
                let (y, z) = (fy * width, fz * height);
                let h = 1e-5;
                let by_y = (warping(&solid, &k, y + h, z) - warping(&solid, &k, y - h, z)) / (2.0 * h);
                let by_z = (warping(&solid, &k, y, z + h) - warping(&solid, &k, y, z - h)) / (2.0 * h);
                let found = strain_tensor(&solid, &k, y, z);
                let expected = [
                    (1, 1, by_y[1]),
                    (2, 2, by_z[2]),
                    (0, 1, 0.5 * (by_y[0] - k[1] * z)),
                    (0, 2, 0.5 * (by_z[0] + k[1] * y)),
                    (1, 2, 0.5 * (by_z[1] + by_y[2])),
                ];
                for (i, j, expected) in expected {
                    let error = (found[(i, j)] - expected).abs();
                    // error of truncated series and difference quotients, for strains of 1e-3
                    assert!(error < 2e-8, "{outline:?} {width}×{height} at ({y}, {z}): E{i}{j} off by {error:.1e}");
                }
            }
        }
    }
}

/// The lateral stresses vanish and `S₁₁ = E_Young E₁₁`: exact for Saint-Venant extension and bending.
#[test]
fn sides_are_free_of_stress() {
    let solid = solid(Outline::Ellipse, 2.0, 0.5);
    let strain = strain_tensor(&solid, &Strain::from(MEASURES), 0.3, -0.1);
    let stress = stress_tensor(&MATERIAL, &strain).unwrap();
    let scale = stress[(0, 0)].abs();
    assert!((stress[(0, 0)] - 70e9 * strain[(0, 0)]).abs() < 1e-12 * scale);
    for (i, j) in [(1, 1), (2, 2), (1, 2)] {
        assert!(stress[(i, j)].abs() < 1e-12 * scale, "S{i}{j} = {:.1e} Pa", stress[(i, j)]);
    }
}

/// Torsion: no shear across the boundary, and `G ∫(y γ_xz − z γ_xy) dA = GJ k₁` with the series of eq. (S2).
#[test]
fn torsion_shear_runs_along_the_rim_and_makes_the_torque() {
    for (width, height) in [(8.0, 2.0), (1.0, 1.0), (0.002, 0.05)] {
        let solid = solid(Outline::Rectangle, width, height);
        let (a, b) = (0.5 * width, 0.5 * height);
        let largest = width.min(height);
        for i in -10..=10 {
            let part = f64::from(i) / 10.0;
            let [through, _] = torsion_shear(&solid, a, part * b);
            let [_, out] = torsion_shear(&solid, part * a, -b);
            assert!(
                through.abs().max(out.abs()) < 1e-5 * largest,
                "{width}×{height}, {part}: {through:.1e}, {out:.1e}"
            );
        }
        let points =
            crate::math::quadrature::gauss_pieces(-1.0, 1.0, &[-0.99, -0.96, -0.9, -0.7, 0.0, 0.7, 0.9, 0.96, 0.99]);
        let mut torque = 0.0;
        for &(p, wp) in &points {
            for &(q, wq) in &points {
                let (y, z) = (a * p, b * q);
                let [xy, xz] = torsion_shear(&solid, y, z);
                torque += wp * wq * a * b * (y * xz - z * xy);
            }
        }
        let error = (torque / solid.torsion_constant_m4() - 1.0).abs();
        assert!(error < 1e-4, "{width}×{height}: torque off by {error:.1e}");
    }
    // Timoshenko & Goodier, table: the largest shear strain of a square is 0.675 times twist times side
    let [shear, _] = torsion_shear(&solid(Outline::Rectangle, 1.0, 1.0), 0.0, 0.5);
    assert!((shear + 0.675).abs() < 5e-4, "{shear}");
}

/// \[M\] (31), (32): the energy per length of a bi-tapered ellipse with the paper's constants equals that of the scaled outline, `½ (EA γ²
/// + GJ k₁² + EI_y k₂² + EI_z k₃²)`, to round-off.
#[test]
fn bi_tapered_energy_is_that_of_the_stretched_ellipse() {
    let (d2, d3, width_factor, height_factor) = (2.0f64, 0.5f64, 0.8f64, 0.65f64);
    let (lambda, rho) = (width_factor, height_factor / width_factor);
    let area = PI * d2 * d3;
    let j1 = area * d2 * d2 * d3 * d3 / (rho * d3 * d3 + d2 * d2 / rho);
    let (j2, j3) = (0.25 * area * d3 * d3, 0.25 * area * d2 * d2);
    let (young, shear) = (MATERIAL.youngs_modulus_pa, MATERIAL.shear_modulus_pa);
    let paper = Strain::<STRAINS>::new(
        young * area * rho * lambda.powi(2),
        shear * j1 * rho.powi(2) * lambda.powi(4),
        young * j2 * rho.powi(3) * lambda.powi(4),
        young * j3 * rho * lambda.powi(4),
    );
    let ours = solid(Outline::Ellipse, 2.0 * d2, 2.0 * d3).stretched(width_factor, height_factor).section();
    for i in 0..STRAINS {
        assert!((ours.stiffness[(i, i)] / paper[i] - 1.0).abs() < 1e-14, "entry {i}");
    }
    // also [M] (30) for w₁, with z = x/λ
    let solid = solid(Outline::Ellipse, 2.0 * d2, 2.0 * d3).stretched(width_factor, height_factor);
    let (z2, z3) = (0.7, 0.2);
    let first = warping(&solid, &Strain::<STRAINS>::new(0.0, 1.0, 0.0, 0.0), z2 * lambda, z3 * rho * lambda).x;
    let term = (rho * rho * d3 * d3 - d2 * d2) / (rho * rho * d3 * d3 + d2 * d2) * rho * lambda * lambda * z2 * z3;
    assert!((first - term).abs() < 1e-15);
}

/// Compares the maximum over the section with a search along the boundary.
#[test]
fn maximum_of_the_axial_strain() {
    for outline in [Outline::Ellipse, Outline::Rectangle] {
        for measures in [MEASURES, [-2e-3, 0.0, 1e-3, 4e-3], [0.0, 0.0, 0.0, -1e-3], [1e-3, 0.0, 0.0, 0.0]] {
            let k = Strain::from(measures);
            let solid = solid(outline, 2.0, 0.5);
            let (value, [y, z]) = maximum_axial_strain(Some(outline), &solid.section(), &k);
            assert!((strain_tensor(&solid, &k, y, z)[(0, 0)] - value).abs() < 1e-18);
            let mut largest = 0.0f64;
            for i in 0..20_000 {
                let (sine, cosine) = (f64::from(i) * PI / 10_000.0).sin_cos();
                let point = match outline {
                    Outline::Ellipse => [cosine, 0.25 * sine],
                    Outline::Rectangle => [cosine.signum(), 0.25 * sine.signum()],
                };
                largest = largest.max(axial_row(point[0], point[1]).dot(&k).abs());
            }
            assert!((value.abs() / largest - 1.0).abs() < 1e-7, "{outline:?}: {value} against {largest}");
        }
    }
}

/// A rosette at ±45° on the face measures the shear strain of torsion; a gauge along the axis reads eq. (R1).
#[test]
fn gauges_read_their_direction() {
    let solid = solid(Outline::Rectangle, 0.05, 0.002);
    let k = Strain::from(MEASURES);
    let reading = |x: f64, y: f64| gauge_row(&solid, 0.0, 0.001, &Vector3::new(x, y, 0.0).normalize()).dot(&k);
    let shear = 2.0 * strain_tensor(&solid, &k, 0.0, 0.001)[(0, 1)];
    assert!((reading(1.0, 1.0) - reading(1.0, -1.0) - shear).abs() < 1e-18);
    assert!((shear + 0.002 * MEASURES[1]).abs() < 1e-6 * shear.abs(), "thin plate: −h k₁ on the upper face");
    assert!((reading(1.0, 0.0) - axial_row(0.0, 0.001).dot(&k)).abs() < 1e-18);
}
