//! Compares links in their own frames with links in the world frame.

use super::*;
use crate::math::local_jacobian::LocalJacobian;
use crate::math::se3::LinkGeometry;
use crate::math::strain::STRAINS;

/// Compares pose, Jacobian and motion with the links in the world frame, in all three branches of the coefficients and with links of
/// different angles computed together. Tolerance: round-off of some hundred operations on numbers up to 50.
#[test]
fn local_links_are_those_of_the_world() {
    let inner = crate::math::so3::rotation_about(&Vector3::new(0.48, 0.6, 0.64), 1.1);
    let length = 0.4;
    for scale in [0.0, 1e-6, 0.1, 1.0, 3.0, 8.0] {
        let strain = |link: usize| {
            let bend = scale * (1.0 + 0.1 * link as f64);
            [0.02, 0.7 * bend, -0.4 * bend, 0.5 * bend]
        };
        let (rate, pull) = ([0.3, -1.0, 0.8, 2.0], [4.0, 3.0, -5.0, 1.0]);
        let coordinates: Vec<f64> = (0..LANES).flat_map(strain).collect();
        let q = Strains::<STRAINS>::read(&coordinates, &from_fn(|link| STRAINS * link));
        let (v, a) = (Strains::read(&rate, &[0; LANES]), Strains::read(&pull, &[0; LANES]));
        let (links, motions) = poses_and_motions(Lanes::all(length), &q, &v, &a);
        assert_eq!(poses(Lanes::all(length), &q), links);
        for lane in 0..LANES {
            let (geometry, link) = LinkGeometry::new(&inner, length, &strain(lane));
            let rates = geometry.rates(&inner, &rate);
            let local = LocalJacobian::of(&links, lane);
            let found = local.turned::<STRAINS>(&inner, length);
            let columns = found.velocity.iter().zip(&link.velocity).chain(found.spin.iter().zip(&link.spin));
            let worst = columns
                .fold((found.rotation - link.rotation).norm(), |worst, (found, link)| worst.max((found - link).norm()));
            let worst = worst.max((found.arm_m - link.arm_m).norm());
            let acceleration = (0..STRAINS).fold(rates.velocity_bias, |sum, j| sum + link.velocity[j] * pull[j]);
            let spin_rate = (0..3).fold(rates.spin_bias, |sum, j| sum + link.spin[j] * pull[TWIST + j]);
            let worst = [
                (&motions.velocity, rates.velocity),
                (&motions.spin, rates.spin),
                (&motions.acceleration, acceleration),
                (&motions.spin_rate, spin_rate),
            ]
            .into_iter()
            .fold(worst, |worst, (found, world)| worst.max((inner * vector(found, lane) - world).norm()));
            assert!(worst < 3e-14, "{scale}: {worst:.1e}");

            let (linear, angular) = local.push(length, &pull);
            let by_strain = (0..STRAINS).fold(Vector3::zeros(), |sum, j| sum + link.velocity[j] * pull[j]);
            assert!((inner * linear - by_strain).norm() < 1e-14, "{scale}");
            let by_strain = (0..3).fold(Vector3::zeros(), |sum, j| sum + link.spin[j] * pull[TWIST + j]);
            assert!((inner * angular - by_strain).norm() < 1e-14, "{scale}");
            let (force, moment) = (Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.3, 0.7, -1.1));
            let projected: [f64; STRAINS] =
                local.project(length, &(inner.transpose() * force), &(inner.transpose() * moment));
            let world = link.project(&force, &moment);
            for j in 0..STRAINS {
                assert!((projected[j] - world[j]).abs() < 1e-14, "{scale}: {j}");
            }
        }
    }
}

/// The derivatives by recurrence lose no digits: compared with the independent long series of the coefficients in the world frame, to 1e-14
/// relative: three operations with a cancellation by a factor of ten.
#[test]
fn coefficients_by_recurrence_keep_their_digits() {
    for x in [0.0, 1e-9, 0.01, 0.0899, 0.0901, 0.7, 2.2] {
        let found = Coefficients::at(Lanes::all(x));
        let known = crate::math::se3::Coefficients::at(x);
        for (found, known) in [
            (found.b, known.b),
            (found.b1, known.b1),
            (found.b2, known.b2),
            (found.c, known.c),
            (found.c1, known.c1),
            (found.c2, known.c2),
        ] {
            assert!((found.0[0] / known - 1.0).abs() < 1e-14, "{x}: {} instead of {known}", found.0[0]);
        }
    }
}
