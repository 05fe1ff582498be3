//! Compares links in the world frame with the exponential and with differences.

use super::*;
use crate::math::strain::STRAINS;

/// Series and closed form agree at the limit; between the limits the tolerance is the cancellation error of the closed form.
#[test]
fn coefficients_join_at_the_limits() {
    let mut worst = 0.0f64;
    for x in [SHORT_SERIES_BELOW, CLOSED_FORM_ABOVE] {
        let (below, above) = (Coefficients::at(x * (1.0 - 1e-15)), Coefficients::at(x));
        for (p, q) in [
            (below.b, above.b),
            (below.b1, above.b1),
            (below.b2, above.b2),
            (below.c, above.c),
            (below.c1, above.c1),
            (below.c2, above.c2),
        ] {
            worst = worst.max(((p - q) / q).abs());
        }
    }
    assert!(worst < 2e-13, "jump of {worst:.1e}");
}

/// Compares the pose of one link with the product of 2²⁰ infinitesimal ones (by repeated squaring), which shares no coefficient with the
/// code under test.
#[test]
fn pose_is_the_exponential() {
    for (angle, strain) in
        [(0.0, [0.1, 1e-7, -2e-7, 1e-7]), (1.0, [-0.05, 1.1, 0.3, -0.7]), (3.0, [0.2, 2.0, -3.0, 1.5])]
    {
        let length = 0.8;
        let inner = crate::math::so3::rotation_about(&Vector3::new(0.6, 0.0, 0.8), angle);
        let mut generator = nalgebra::Matrix4::<f64>::zeros();
        let twist = Vector3::from_column_slice(&strain[CURVATURES]) * length;
        generator.fixed_view_mut::<3, 3>(0, 0).copy_from(&hat(&twist));
        generator[(0, 3)] = length * (1.0 + strain[STRETCH]);
        let small = generator / f64::from(1u32 << 20);
        // Taylor series for the exponential of a tiny matrix, then twenty squarings of (exp − 1) to avoid cancellation
        let mut excess = small + small * small / 2.0 + small * small * small / 6.0;
        for _ in 0..20 {
            excess = excess * 2.0 + excess * excess;
        }
        let exponential = nalgebra::Matrix4::identity() + excess;
        let (_, link) = LinkGeometry::new(&inner, length, &strain);
        let rotation = inner * exponential.fixed_view::<3, 3>(0, 0);
        let arm = inner * exponential.fixed_view::<3, 1>(0, 3);
        assert!((link.rotation - rotation).norm() < 1e-13, "{:.1e}", (link.rotation - rotation).norm());
        assert!((link.arm_m - arm).norm() < 1e-13);
    }
}

/// Compares Jacobian and bias accelerations with central differences along a curve of strains.
#[test]
fn rates_and_biases_match_differences() {
    let inner = crate::math::so3::rotation_about(&Vector3::new(0.0, 0.6, 0.8), 0.7);
    let length = 0.6;
    let (q0, q1) = ([0.05, 0.9, -1.4, 0.6], [0.3, -1.0, 0.8, 2.0]);
    let at = |t: f64| -> [f64; STRAINS] { from_fn(|i| q0[i] + t * q1[i]) };
    let step = 1e-4;
    let motion = |t: f64| {
        let (geometry, link) = LinkGeometry::new(&inner, length, &at(t));
        (link, geometry.rates(&inner, &q1))
    };
    let ((below, rates_below), (here, rates), (above, rates_above)) = (motion(-step), motion(0.0), motion(step));
    let velocity = (above.arm_m - below.arm_m) / (2.0 * step);
    let spin_matrix = (above.rotation - below.rotation) / (2.0 * step) * here.rotation.transpose();
    let spin = Vector3::new(spin_matrix[(2, 1)], spin_matrix[(0, 2)], spin_matrix[(1, 0)]);
    // difference error: h²/6 times a third derivative of order 1
    assert!((velocity - rates.velocity).norm() < 1e-8);
    assert!((spin - rates.spin).norm() < 1e-8);
    let by_columns: Vector3<f64> = (0..STRAINS).map(|i| here.velocity[i] * q1[i]).sum();
    let spin_by_columns: Vector3<f64> = (0..3).map(|i| here.spin[i] * q1[TWIST + i]).sum();
    assert!((by_columns - rates.velocity).norm() < 1e-15);
    assert!((spin_by_columns - rates.spin).norm() < 1e-15);
    let velocity_bias = (rates_above.velocity - rates_below.velocity) / (2.0 * step);
    let spin_bias = (rates_above.spin - rates_below.spin) / (2.0 * step);
    assert!((velocity_bias - rates.velocity_bias).norm() < 1e-8);
    assert!((spin_bias - rates.spin_bias).norm() < 1e-8);
}

/// Compares the curvature of a link with central differences of its Jacobian, on both sides of the limits of the series.
#[test]
fn curvature_matches_differences() {
    let (force, moment) = (Vector3::new(1.0, -2.0, 0.7), Vector3::new(0.4, 0.9, -1.3));
    let inner = Matrix3::identity();
    for (length, strain) in [
        (0.6, [0.05, 1e-5, -2e-5, 3e-6]),
        (0.6, [0.05, 0.9, -1.4, 0.6]),
        (1.1, [-0.1, 1.0, 1.2, -0.8]),
        (0.9, [0.0, -1.5, 1.2, 1.9]),
    ] {
        let forces = |strain: &[f64; STRAINS]| {
            let (_, link) = LinkGeometry::new(&inner, length, strain);
            crate::math::strain::Strain::from(link.project(&force, &moment))
        };
        let exact = link_curvature(length, &strain, &force, &moment);
        let step = 1e-4;
        for j in 0..STRAINS {
            let at = |shift: f64| {
                let mut moved = strain;
                moved[j] += shift;
                forces(&moved)
            };
            // fourth order: truncation error 1e-16 times the fifth derivative, round-off 1e-12
            let slope = ((at(step) - at(-step)) * 8.0 - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step);
            let error = (slope - exact.column(j)).amax();
            assert!(error < 2e-11, "strain {strain:?}, column {j}: {error:.1e}");
        }
    }
}

/// Third derivatives of the link's coefficients against central differences of the second ones, on both sides of the limits of the series, to
/// 1e-7 of 1/5040; the coefficients with them against those without.
#[test]
fn third_derivatives_of_the_coefficients() {
    for x in [0.0, 0.01, 0.049, 0.051, 0.5, 2.2, 2.3, 9.0] {
        let h = 1e-4;
        let (up, down) = (Coefficients::at(x + h), Coefficients::at(x - h));
        let (own, [b3, c3]) = Coefficients::with_third(x);
        let values = |k: &Coefficients| [k.b, k.b1, k.b2, k.c, k.c1, k.c2];
        for (found, known) in values(&own).into_iter().zip(values(&Coefficients::at(x))) {
            assert!((found - known).abs() < 1e-15 * 4.0, "{x}: {found:e} {known:e}");
        }
        assert!((b3 - (up.b2 - down.b2) / (2.0 * h)).abs() < 1e-10, "{x}");
        assert!((c3 - (up.c2 - down.c2) / (2.0 * h)).abs() < 1e-10, "{x}");
    }
}
