//! Compares links with shear with differences, the exponential and the links of the residual.

use crate::math::local_jacobian::LocalJacobian;
use crate::math::local_link::{LANES, Lanes, Strains, poses, poses_and_motions, vector};
use crate::math::se3::{LinkGeometry, link_curvature};
use crate::math::so3::{hat, rotation_about};
use crate::math::strain::{CURVATURES, SHEAR_Y, SHEAR_Z, SHEARED, STRETCH, Strain, TWIST};
use nalgebra::{Matrix3, Matrix4, Vector3};
use std::array::from_fn;

/// Angles by which the curvatures rotate a link of 1 m: they cover all branches of the coefficients.
const ANGLES: [f64; 6] = [1e-9, 1e-4, 0.15, 1.0, 2.5, 6.0];

fn strain(angle: f64) -> [f64; SHEARED] {
    [0.05, 0.48 * angle, -0.6 * angle, 0.64 * angle, -0.3, 0.2]
}

/// Compares the pose of one link with the product of 2²⁰ small ones by repeated squaring of a matrix exponential, which shares no
/// coefficient with the code under test. Tolerance: round-off of the squarings.
#[test]
fn pose_is_the_exponential() {
    let inner = rotation_about(&Vector3::new(0.6, 0.0, 0.8), 0.9);
    for angle in ANGLES {
        let (length, strain) = (0.8, strain(angle));
        let mut generator = Matrix4::<f64>::zeros();
        let turn = Vector3::from_column_slice(&strain[CURVATURES]) * length;
        generator.fixed_view_mut::<3, 3>(0, 0).copy_from(&hat(&turn));
        generator[(0, 3)] = length * (1.0 + strain[STRETCH]);
        (generator[(1, 3)], generator[(2, 3)]) = (length * strain[SHEAR_Y], length * strain[SHEAR_Z]);
        let small = generator / f64::from(1u32 << 20);
        let mut excess = small + small * small / 2.0 + small * small * small / 6.0;
        for _ in 0..20 {
            excess = excess * 2.0 + excess * excess;
        }
        let exponential = Matrix4::identity() + excess;
        let (_, link) = LinkGeometry::new(&inner, length, &strain);
        let rotation = inner * exponential.fixed_view::<3, 3>(0, 0);
        let arm = inner * exponential.fixed_view::<3, 1>(0, 3);
        assert!((link.rotation - rotation).norm() < 2e-13, "{angle}: {:.1e}", (link.rotation - rotation).norm());
        assert!((link.arm_m - arm).norm() < 2e-13, "{angle}: {:.1e}", (link.arm_m - arm).norm());
    }
}

/// Sixth-order difference quotient of a function at 0; with a step of 0.01 and derivatives of order one its error is 1e-14.
fn slope(of: impl Fn(f64) -> Vector3<f64>) -> Vector3<f64> {
    let h = 0.01;
    let pair = |k: f64| of(k * h) - of(-k * h);
    (pair(1.0) * 45.0 - pair(2.0) * 9.0 + pair(3.0)) / (60.0 * h)
}

/// Compares rates and biases, eqs. (K5) and (K12), with sixth-order differences along a curve of strains, and the Jacobian of eqs. (K4) and
/// (K11) with the rates. Tolerance: 1e-10 for a step of 0.01 and angles up to 6 rad.
#[test]
fn rates_and_biases_match_differences() {
    let inner = rotation_about(&Vector3::new(0.0, 0.6, 0.8), 0.7);
    let rate: [f64; SHEARED] = [0.3, -0.4, 0.5, 0.7, 0.6, -0.8];
    for angle in ANGLES {
        let (length, start) = (0.6, strain(angle));
        let motion = |t: f64| {
            let at: [f64; SHEARED] = from_fn(|i| start[i] + t * rate[i]);
            let (geometry, link) = LinkGeometry::new(&inner, length, &at);
            (link, geometry.rates(&inner, &rate))
        };
        let (link, rates) = motion(0.0);
        let velocity = slope(|t| motion(t).0.arm_m);
        assert!((velocity - rates.velocity).norm() < 1e-10, "{angle}: {:.1e}", (velocity - rates.velocity).norm());
        let bias = slope(|t| motion(t).1.velocity);
        assert!((bias - rates.velocity_bias).norm() < 1e-10, "{angle}: {:.1e}", (bias - rates.velocity_bias).norm());
        let spin_bias = slope(|t| motion(t).1.spin);
        assert!((spin_bias - rates.spin_bias).norm() < 1e-10, "{angle}");
        let by_columns: Vector3<f64> = (0..SHEARED).map(|i| link.velocity[i] * rate[i]).sum();
        assert!((by_columns - rates.velocity).norm() < 1e-14, "{angle}");
        let spin: Vector3<f64> = link.spin_columns().iter().zip(rate).map(|(column, rate)| column * rate).sum();
        assert!((spin - rates.spin).norm() < 1e-14, "{angle}");
    }
}

/// Compares the derivatives of the generalised forces of a wrench, eq. (L42), with sixth-order differences of the Jacobian.
#[test]
fn curvature_matches_differences() {
    let (force, moment) = (Vector3::new(1.0, -2.0, 0.7), Vector3::new(0.4, 0.9, -1.3));
    for angle in ANGLES {
        let (length, start) = (0.6, strain(angle));
        let exact = link_curvature(length, &start, &force, &moment);
        for j in 0..SHEARED {
            let part = |from: usize| {
                slope(|t| {
                    let mut at = start;
                    at[j] += t;
                    let (_, link) = LinkGeometry::new(&Matrix3::identity(), length, &at);
                    let forces = Strain::<SHEARED>::from(link.project(&force, &moment));
                    forces.fixed_rows::<3>(from).into_owned()
                })
            };
            for from in [0, 3] {
                let error = (part(from) - exact.fixed_view::<3, 1>(from, j)).amax();
                assert!(error < 1e-10, "{angle}, column {j}: {error:.1e}");
            }
        }
    }
}

/// Compares the links of the residual with those in the world frame: pose, Jacobian, motion and both products. Tolerance: round-off of some
/// hundred operations on numbers up to 50.
#[test]
fn local_links_are_those_of_the_world() {
    let inner = rotation_about(&Vector3::new(0.48, 0.6, 0.64), 1.1);
    let length = 0.4;
    for angle in ANGLES {
        let own = |lane: usize| strain(angle * (1.0 + 0.1 * lane as f64));
        let (rate, pull) = ([0.3, -1.0, 0.8, 2.0, 0.7, -0.4], [4.0, 3.0, -5.0, 1.0, -2.0, 6.0]);
        let coordinates: Vec<f64> = (0..LANES).flat_map(own).collect();
        let q = Strains::<SHEARED>::read(&coordinates, &from_fn(|lane| SHEARED * lane));
        let (v, a) = (Strains::read(&rate, &[0; LANES]), Strains::read(&pull, &[0; LANES]));
        let length_m = Lanes([length; LANES]);
        let (links, motions) = poses_and_motions(length_m, &q, &v, &a);
        assert_eq!(poses(length_m, &q), links);
        for lane in 0..LANES {
            let (geometry, link) = LinkGeometry::new(&inner, length, &own(lane));
            let rates = geometry.rates(&inner, &rate);
            let local = LocalJacobian::of(&links, lane);
            let found = local.turned::<SHEARED>(&inner, length);
            let mut worst = (found.rotation - link.rotation).norm().max((found.arm_m - link.arm_m).norm());
            let columns = found.velocity.iter().zip(&link.velocity).chain(found.spin.iter().zip(&link.spin));
            columns.for_each(|(found, known)| worst = worst.max((found - known).norm()));
            let acceleration = (0..SHEARED).fold(rates.velocity_bias, |sum, j| sum + link.velocity[j] * pull[j]);
            let spin_rate = (0..3).fold(rates.spin_bias, |sum, j| sum + link.spin[j] * pull[TWIST + j]);
            for (found, known) in [
                (&motions.velocity, rates.velocity),
                (&motions.spin, rates.spin),
                (&motions.acceleration, acceleration),
                (&motions.spin_rate, spin_rate),
            ] {
                worst = worst.max((inner * vector(found, lane) - known).norm());
            }
            assert!(worst < 5e-14, "{angle}: {worst:.1e}");
            let (linear, angular) = local.push(length, &pull);
            let by_strain = (0..SHEARED).fold(Vector3::zeros(), |sum, j| sum + link.velocity[j] * pull[j]);
            assert!((inner * linear - by_strain).norm() < 2e-14, "{angle}");
            let by_strain = (0..3).fold(Vector3::zeros(), |sum, j| sum + link.spin[j] * pull[TWIST + j]);
            assert!((inner * angular - by_strain).norm() < 2e-14, "{angle}");
            let (force, moment) = (Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.3, 0.7, -1.1));
            let found: [f64; SHEARED] = local.project(length, &inner.tr_mul(&force), &inner.tr_mul(&moment));
            for (found, known) in found.iter().zip(link.project(&force, &moment)) {
                assert!((found - known).abs() < 2e-14, "{angle}");
            }
        }
    }
}
