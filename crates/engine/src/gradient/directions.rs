//! Linear systems whose factors are nearly exact, by minimal residuals over all directions so far (GCR).
//!
//! Newton's factors `N` leave out gyroscopic and geometric terms of `A`: `N⁻¹A` is near the identity, and the rest has few large
//! directions, so that each direction removes more than a correction by `N⁻¹` alone would. Directions of one solution serve all others with
//! the same matrix.

use crate::gradient::{add, dot, largest_products, scale};
use crate::multibody::{Model, energy};

/// Remainder, as a share of the solution, at which a linear system is solved.
const SOLVED: f64 = 3e-13;
/// Maximum number of directions in which a solution is sought.
const MAX_DIRECTIONS: usize = 40;
/// Safety factor on the largest distance of `N⁻¹A` from the identity so far, for a last correction after which no remainder is computed.
const SAFETY: f64 = 3.0;
/// Cost of a factorisation as a number of directions, each with a product and a solution.
const FACTORS: usize = 1;

/// Directions of the solutions with one matrix, and their images.
#[derive(Debug, Clone, Default)]
pub(super) struct Directions {
    /// Per direction: itself, then its image in m, which is of unit length and orthogonal to the others.
    rows: Vec<Vec<f64>>,
    /// Number in use.
    count: usize,
    /// Number of directions of all solutions with the current matrix.
    added: usize,
    /// This number for the first matrix after a factorisation; `None` until it is known.
    fresh: Option<usize>,
    /// Number of directions that later matrices needed in addition to that.
    excess: usize,
    /// The largest distance of `N⁻¹A` from the identity, found with the factors of the present step, if each of its stages has factors of its
    /// own.
    distance: Option<f64>,
    solution: Vec<f64>,
    /// Displacement of the machine in m per unit of each coordinate.
    scales_m: Vec<f64>,
    ones: Vec<f64>,
}

impl Directions {
    /// For the coordinates of a model: remainders are compared and minimised as displacements.
    pub fn new(model: &Model) -> Self {
        let reach_m = model.reference_length_m;
        let mut scales_m = vec![reach_m; model.coordinates];
        for body in &model.bodies {
            let first = body.joint.coordinate;
            scales_m[first..first + body.joint.kind.translations()].fill(1.0);
            if let Some(modal) = &body.modal {
                scales_m[modal.range()].fill(1.0);
            }
        }
        for element in &model.elements {
            scales_m[element.range()].fill(element.length_m);
            scales_m[element.curvatures()].fill(element.length_m * reach_m);
        }
        for circuit in &model.circuits {
            scales_m[circuit.coordinate] = circuit.displacement_m(reach_m);
        }
        // forces of constraints accelerate the machine's mass
        scales_m[model.tree_coordinates()..].fill(energy::mass_kg(model).recip());
        // a machine without extent: its rotations count as they are
        scales_m.iter_mut().filter(|scale| **scale <= 0.0).for_each(|scale| *scale = 1.0);
        let ones = vec![1.0; scales_m.len()];
        Self { scales_m, ones, ..Self::default() }
    }

    /// The largest displacement of each of several changes of the coordinates.
    pub fn sizes<const N: usize>(&self, changes: [&[f64]; N]) -> [f64; N] {
        largest_products(changes, &self.scales_m)
    }

    /// Discards all directions, for another matrix with the same factors.
    pub fn restart(&mut self) {
        let added = std::mem::take(&mut self.added);
        match self.fresh {
            None if added > 0 => self.fresh = Some(added),
            None => {}
            Some(fresh) => self.excess += added.saturating_sub(fresh),
        }
        self.count = 0;
    }

    /// Discards all directions, for new factors.
    pub fn restart_with_factors(&mut self) {
        (self.count, self.added, self.fresh, self.excess, self.distance) = (0, 0, None, 0, None);
    }

    /// Discards all directions, for new factors of the same kind as those of the other stages of a step: their distance from the matrix is
    /// found once, by a product at its `first` stage.
    pub fn restart_with_factors_of_stage(&mut self, first: bool) {
        let distance = self.distance.filter(|_| !first);
        self.restart_with_factors();
        self.distance = distance.or(Some(f64::INFINITY));
    }

    /// Whether the factors are so old that the directions in excess of those with new factors have cost more than new factors.
    pub fn are_old(&self) -> bool {
        self.excess > FACTORS
    }

    /// Solves `N⁻¹A x = left` for the change of `guess` to the solution. `image` is given a direction and writes `N⁻¹A` times it. The
    /// iteration ends when the remainder is below [`SOLVED`] times the solution or `others`: entries of the solution may be the round-off
    /// of terms that cancel, such as the accelerations of an arm without stiffness. The last correction is the remainder itself, as soon as
    /// the distance of `N⁻¹A` from the identity along the directions so far shows that the remainder is then below this limit.
    ///
    /// # Errors
    /// The remaining share, if it does not fall.
    pub fn solve(
        &mut self,
        mut left: Vec<f64>,
        guess: &[f64],
        others: f64,
        mut image: impl FnMut(&[f64], &mut [f64]),
    ) -> Result<&[f64], f64> {
        let n = left.len();
        scale(&mut left, &self.scales_m);
        self.solution.clear();
        self.solution.extend_from_slice(guess);
        // the component along directions of other solutions
        for row in &self.rows[..self.count] {
            remove(&mut left, &mut self.solution, row);
        }
        let (mut whole, mut own) = (others, 0);
        let mut distance = self.distance.unwrap_or(f64::INFINITY);
        loop {
            let [size] = self.sizes([&self.solution]);
            whole = whole.max(size);
            let [rest] = largest_products([&left], &self.ones);
            let allowed = SOLVED * whole;
            if rest <= allowed {
                return Ok(&self.solution);
            }
            // the corrected solution is at least as large as the remainder exceeds the present one
            if SAFETY * distance * rest <= allowed.max(SOLVED * (rest - size)) {
                for ((solution, left), scale) in self.solution.iter_mut().zip(&left).zip(&self.scales_m) {
                    *solution += left / scale;
                }
                return Ok(&self.solution);
            }
            if own == MAX_DIRECTIONS || !rest.is_finite() {
                return Err(rest / whole);
            }
            if self.count == MAX_DIRECTIONS {
                self.count = 0;
            }
            if self.rows.len() == self.count {
                self.rows.push(vec![0.0; 2 * n]);
            }
            let (before, behind) = self.rows.split_at_mut(self.count);
            let row = &mut behind[0];
            let (direction, image_of) = row.split_at_mut(n);
            direction.iter_mut().zip(&left).zip(&self.scales_m).for_each(|((own, left), scale)| *own = left / scale);
            image(direction, image_of);
            scale(image_of, &self.scales_m);
            let apart = left.iter().zip(&*image_of).fold(0.0f64, |apart, (a, b)| apart.max((a - b).abs()));
            distance = if distance < f64::INFINITY { distance.max(apart / rest) } else { apart / rest };
            if let Some(known) = &mut self.distance {
                *known = distance;
            }
            for other in before {
                let share = dot(&row[n..], &other[n..]);
                add(row, -share, other);
            }
            let length = dot(&row[n..], &row[n..]).sqrt();
            if length.is_nan() || length <= 0.0 {
                return Err(rest / whole);
            }
            row.iter_mut().for_each(|entry| *entry /= length);
            remove(&mut left, &mut self.solution, row);
            self.count += 1;
            self.added += 1;
            own += 1;
        }
    }
}

/// Removes a direction's image from the remainder, and adds its share to the solution.
fn remove(left: &mut [f64], solution: &mut [f64], row: &[f64]) {
    let (own, image) = row.split_at(solution.len());
    let share = dot(left, image);
    add(solution, share, own);
    add(left, -share, image);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The remainder of a solution is below the limit also where it ended by a last correction, after which none is computed; the number of
    /// products with the matrix tells that it did.
    #[test]
    fn the_last_correction_solves() {
        let n = 12;
        let mut random = fastrand::Rng::with_seed(5);
        let matrix: Vec<f64> =
            (0..n * n).map(|entry| f64::from(u8::from(entry % (n + 1) == 0)) + 3e-5 * (random.f64() - 0.5)).collect();
        let product = |x: &[f64], image: &mut [f64]| {
            image.iter_mut().zip(matrix.chunks(n)).for_each(|(image, row)| *image = dot(row, x));
        };
        let left: Vec<f64> = (0..n).map(|_| random.f64() - 0.5).collect();
        // factors for the steps to come, then those of the first stage of a step, whose distance from the identity is not known either
        for of_stage in [false, true] {
            let mut directions = Directions { scales_m: vec![2.0; n], ones: vec![1.0; n], ..Directions::default() };
            if of_stage {
                directions.restart_with_factors_of_stage(true);
            }
            let mut products = 0;
            let counted = |x: &[f64], image: &mut [f64]| {
                products += 1;
                product(x, image);
            };
            let solution = directions.solve(left.clone(), &vec![0.0; n], 0.0, counted).expect("near the identity");
            let solution = solution.to_vec();
            let mut image = vec![0.0; n];
            product(&solution, &mut image);
            let rest = left.iter().zip(&image).fold(0.0f64, |rest, (a, b)| rest.max((a - b).abs()));
            let [whole] = largest_products([&solution], &directions.ones);
            // the second product is the one by which the distance from the identity is confirmed
            assert!(products <= 2 && rest < SOLVED * whole, "{products} products, remainder {rest:e} of {whole}");
        }
    }
}
