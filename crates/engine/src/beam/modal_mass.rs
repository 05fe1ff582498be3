//! Inertia of a modal body with few shapes, from precomputed sums over its masses, NOTATION eq. (M9).
//!
//! Each component of the position, velocity and acceleration of a mass is a linear combination of functions of the distance along the body:
//! 1, `x`, the deflections of the shapes, and the shortenings per product of two coordinates. Forces and moments are then products of the
//! coefficients with the sums `Σ m f_a f_b` over all masses.

use crate::beam::modal::{FEW_MODES, MassPoint};
use nalgebra::{Matrix3, Vector3};

/// First indices of the deflections along `y` and `z` and of the shortenings, and the number of functions.
const BEND: [usize; 2] = [2, 2 + FEW_MODES];
const SHORTENING: usize = 2 + 2 * FEW_MODES;
const FUNCTIONS: usize = SHORTENING + FEW_MODES * (FEW_MODES + 1) / 2;

/// Coefficients of the functions.
type Factors = [f64; FUNCTIONS];

/// Motion of a modal body in the frame of its inner end.
pub(crate) struct MassMotion<'m> {
    /// Coordinates in m; zeros after those of the body, as in the rates.
    pub q: &'m [f64; FEW_MODES],
    /// Rates of the coordinates in m/s.
    pub v: &'m [f64; FEW_MODES],
    /// Second derivatives of the coordinates in m/s².
    pub a: &'m [f64; FEW_MODES],
    /// Acceleration of the inner end minus gravity, in m/s².
    pub origin: Vector3<f64>,
    /// Gradient of that acceleration with respect to position, in 1/s².
    pub spread: Matrix3<f64>,
    /// Twice the angular velocity in rad/s, for the Coriolis acceleration.
    pub twice_spin: Vector3<f64>,
}

/// Inertia forces of all masses in the frame of the inner end.
pub(crate) struct MassForces {
    /// Total force in N.
    pub force: Vector3<f64>,
    /// Moment about the inner end in N·m.
    pub moment: Vector3<f64>,
    /// Generalised forces on the coordinates in N.
    pub on_coordinates: [f64; FEW_MODES],
}

/// Sums `Σ m f_a f_b` over the masses of a body with at most [`FEW_MODES`] shapes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MassMoments([Factors; FUNCTIONS]);

/// Pairs of coordinates in the order of the functions.
fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..FEW_MODES).flat_map(|i| (i..FEW_MODES).map(move |j| (i, j)))
}

/// Index of the shortening for a product of two coordinates.
const fn shortening(i: usize, j: usize) -> usize {
    let (low, high) = if i < j { (i, j) } else { (j, i) };
    // the rows of the triangle before row `low` have FEW_MODES, FEW_MODES − 1, … entries
    SHORTENING + low * FEW_MODES - low * (low + 1) / 2 + high
}

impl MassMoments {
    /// Computes the sums over the masses of a body.
    pub fn new(masses: &[MassPoint]) -> Self {
        let mut sums = [[0.0; FUNCTIONS]; FUNCTIONS];
        for MassPoint { mass_kg, shapes } in masses {
            let mut functions = [0.0; FUNCTIONS];
            (functions[0], functions[1]) = (1.0, shapes.place_m);
            for i in 0..FEW_MODES {
                functions[BEND[0] + i] = shapes.bend[i][0];
                functions[BEND[1] + i] = shapes.bend[i][1];
            }
            for (i, j) in pairs() {
                functions[shortening(i, j)] = shapes.shortening_1_m[i][j];
            }
            for (row, own) in sums.iter_mut().zip(functions) {
                row.iter_mut().zip(functions).for_each(|(sum, other)| *sum += mass_kg * own * other);
            }
        }
        Self(sums)
    }

    /// Forces as mass times acceleration, eq. (M9).
    pub fn forces(&self, motion: &MassMotion) -> MassForces {
        let MassMotion { q, v, a, origin, spread, twice_spin: spin } = motion;
        // displacement along x by the shortening, its rate and its second derivative, without motion of the frame
        let [mut place, mut rate, mut second] = [[0.0; FUNCTIONS]; 3];
        for (i, j) in pairs() {
            // S is symmetric: each off-diagonal pair counts twice
            let (k, both) = (shortening(i, j), if i == j { 0.5 } else { 1.0 });
            place[k] = -both * q[i] * q[j];
            rate[k] = -both * (q[i] * v[j] + q[j] * v[i]);
            second[k] = -both * (2.0 * v[i] * v[j] + q[i] * a[j] + q[j] * a[i]);
        }
        let [mut x, mut y, mut z] = [[0.0; FUNCTIONS]; 3];
        (x[0], y[0], z[0]) = (origin.x, origin.y, origin.z);
        (x[1], y[1], z[1]) = (spread[(0, 0)], spread[(1, 0)], spread[(2, 0)]);
        for i in 0..FEW_MODES {
            let [along_y, along_z] = BEND.map(|first| first + i);
            x[along_y] = spread[(0, 1)] * q[i] - spin.z * v[i];
            y[along_y] = spread[(1, 1)] * q[i] + a[i];
            z[along_y] = spread[(2, 1)] * q[i] + spin.x * v[i];
            x[along_z] = spread[(0, 2)] * q[i] + spin.y * v[i];
            y[along_z] = spread[(1, 2)] * q[i] - spin.x * v[i];
            z[along_z] = spread[(2, 2)] * q[i] + a[i];
        }
        for k in SHORTENING..FUNCTIONS {
            x[k] = spread[(0, 0)] * place[k] + second[k];
            y[k] = spread[(1, 0)] * place[k] + spin.z * rate[k];
            z[k] = spread[(2, 0)] * place[k] - spin.y * rate[k];
        }
        let [x, y, z] = [x, y, z].map(|factors| self.times(&factors));
        let bent = |first: usize, sums: &Factors| q.iter().zip(&sums[first..]).map(|(q, sum)| q * sum).sum::<f64>();
        let along = |sums: &Factors| sums[1] + (SHORTENING..FUNCTIONS).map(|k| place[k] * sums[k]).sum::<f64>();
        let drawn = |i: usize| (0..FEW_MODES).map(|j| q[j] * x[shortening(i, j)]).sum::<f64>();
        MassForces {
            force: Vector3::new(x[0], y[0], z[0]),
            moment: Vector3::new(
                bent(BEND[0], &z) - bent(BEND[1], &y),
                bent(BEND[1], &x) - along(&z),
                along(&y) - bent(BEND[0], &x),
            ),
            on_coordinates: std::array::from_fn(|i| y[BEND[0] + i] + z[BEND[1] + i] - drawn(i)),
        }
    }

    fn times(&self, factors: &Factors) -> Factors {
        let mut sums = [0.0; FUNCTIONS];
        for (row, factor) in self.0.iter().zip(factors) {
            sums.iter_mut().zip(row).for_each(|(sum, entry)| *sum += entry * factor);
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::modal::{ModalElement, ModalLaw, Shape};
    use crate::beam::profile::Profile;

    /// The precomputed sums give the same forces as a loop over the masses. Tolerance: round-off of some hundred operations, relative to
    /// the largest term.
    #[test]
    fn moments_give_the_forces_of_mass_after_mass() {
        let shape =
            |coefficients: &[f64]| Shape { coefficients: coefficients.to_vec(), damping_ratio: 0.0, start_m: 0.0 };
        let element = ModalElement::new(&ModalLaw {
            length_m: 3.0,
            cells: 9,
            mass_kg_m: Profile::Polynomial(vec![2.0, -0.3]),
            flap_stiffness_n_m2: Profile::Polynomial(vec![1e3]),
            edge_stiffness_n_m2: Profile::Polynomial(vec![3e3]),
            twist_rad: Some(Profile::Polynomial(vec![0.4])),
            flap: vec![shape(&[1.0]), shape(&[-0.6, 1.6])],
            edge: vec![shape(&[0.8, 0.2])],
            axial_shortening: true,
            section_rotation: true,
            rates_of_angles: false,
            mass_factor: 1.0,
            stiffness_factor: 1.0,
        });
        let mut generator = fastrand::Rng::with_seed(3);
        let mut random = |size: f64| size * (2.0 * generator.f64() - 1.0);
        let mut coordinates = |size: f64| [random(size), random(size), random(size), 0.0];
        let (q, v, a) = (coordinates(0.8), coordinates(5.0), coordinates(40.0));
        let mut vector = |size: f64| Vector3::new(random(size), random(size), random(size));
        let (origin, twice_spin) = (vector(20.0), vector(8.0));
        let spread = Matrix3::from_columns(&[vector(9.0), vector(9.0), vector(9.0)]);
        let (mut force, mut moment, mut on) = (Vector3::zeros(), Vector3::zeros(), [0.0; FEW_MODES]);
        for MassPoint { mass_kg, shapes } in &element.masses {
            let (shortened, drawn) = (shapes.shortened(&q), shapes.shortened(&v));
            let place = shapes.position_m(&q, &shortened);
            let square: f64 = drawn.iter().zip(&v).map(|(drawn, v)| drawn * v).sum();
            let second = shapes.moved(&a, &shortened) - Vector3::x() * square;
            let own = (origin + spread * place + twice_spin.cross(&shapes.moved(&v, &shortened)) + second) * *mass_kg;
            force += own;
            moment += place.cross(&own);
            for (i, on) in on.iter_mut().enumerate() {
                *on += shapes.velocity(i, &shortened).dot(&own);
            }
        }
        let moments = element.moments.as_ref().expect("few shapes");
        let found = moments.forces(&MassMotion { q: &q, v: &v, a: &a, origin, spread, twice_spin });
        assert!((found.force - force).norm() < 1e-13 * force.norm(), "{} instead of {force}", found.force);
        assert!((found.moment - moment).norm() < 1e-13 * moment.norm(), "{} instead of {moment}", found.moment);
        let largest = on.iter().fold(0.0f64, |largest, on| largest.max(on.abs()));
        for (found, on) in found.on_coordinates.iter().zip(&on) {
            assert!((found - on).abs() < 1e-13 * largest, "{found} instead of {on}");
        }
    }
}
