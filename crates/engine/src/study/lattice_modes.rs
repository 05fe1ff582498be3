//! Modes of a machine in the air of a lattice, NOTATION eq. (L30): the rows of the wake are delays, so the eigenvalues of the
//! discrete-time system are those of a small matrix that depends on the eigenvalue.

use crate::solve::complex_factors::ComplexFactors;
use crate::solve::contour;
use crate::solve::lagged::{Lagged, LaggedMode};
use crate::study::Study;
use crate::study::flight::tell_lateral_apart;
use crate::study::lattice_space::SampledLattice;
use crate::study::linear::determinant_is_positive;
use crate::system::PlantError;
use crate::system::air::VELOCITY_WEIGHTS;
use crate::system::shape::ModeShape;
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::PI;

type ComplexMatrix = DMatrix<Complex<f64>>;
type ComplexVector = DVector<Complex<f64>>;

/// Maximum number of corrections of an eigenvalue.
const CORRECTIONS: usize = 30;
/// Correction of an eigenvalue, relative to its distance from 1, below which it has converged.
const FOUND: f64 = 1e-11;
/// Relative difference below which two eigenvalues are one.
const SAME: f64 = 1e-6;
/// Part of a shape that must be orthogonal to those of the same eigenvalue, so that it is another motion.
const OTHER: f64 = 1e-2;
/// Step of the derivative by the eigenvalue, relative to its distance from 1.
const STEP: f64 = 1e-6;
/// Correction of a guess, relative to the radius in which it was found, beyond which it was none: guesses are accurate to 1e-6.
const STRAY: f64 = 0.1;

/// Ratio of the radii of two circles: moments over a circle tell motions apart that are not much slower than its radius.
const SHRINK: f64 = 4.0;
/// Ratio by which the first circle grows while it holds too few motions.
const GROW: f64 = 2.0;
/// Maximum number of circles that shrink: slower motions would be round-off, see [`crate::solve::lagged::free_rate_1_s`].
const CIRCLES: usize = 12;
/// Magnitude over that of the fastest eigenvalue that steps can tell from a slower one, up to which motions are looked for.
const NYQUIST: f64 = 0.98;
/// Participation of the wake beyond which a motion that does not grow is the wake's own, as of lag states in (L22).
const WAKE: f64 = 0.5;
/// Share of the kinetic energy in rates that are not those of the eigenvalue, beyond which the motion is faster than steps can show.
const HIDDEN: f64 = 0.5;
/// Real part over the magnitude of an eigenvalue above which it grows.
const GROWTH: f64 = 1e-6;

/// `z` and a shape, coordinates and rates.
type Guess = (Complex<f64>, ComplexVector);

/// The nonlinear eigenvalue problem.
struct Delays<'a> {
    system: &'a SampledLattice,
    /// Derivative of coordinates and rates at the end of the step by the loads of the step.
    pushed: DMatrix<f64>,
}

impl Delays<'_> {
    /// Loads of the step that ends, per coordinate, for motions that grow by the factor `z` per step; the wake arrives as if the factor
    /// were `late`.
    fn loads(&self, z: Complex<f64>, late: Complex<f64>) -> Option<ComplexMatrix> {
        let SampledLattice { slopes, step_s, by_place, by_velocity, .. } = self.system;
        let one = Complex::from(1.0);
        let [own, earlier, last] = VELOCITY_WEIGHTS;
        let back = z.inv();
        // eq. (Q4)
        let mean = (one - back) / *step_s;
        let seen = mean * (z * own + earlier) / (z - last);
        let mut motion =
            DMatrix::from_fn(slopes.rows(), by_place.ncols(), |i, j| seen * by_velocity[(i, j)] + by_place[(i, j)]);
        // nodes of the wake stand where the edge was
        let edges = 3 * slopes.edges;
        let mut node = ComplexMatrix::zeros(slopes.rows(), if slopes.node_rows() > 0 { edges } else { 0 });
        let mut gone = one;
        for row in 0..slopes.node_rows() {
            gone *= late.inv();
            node.zip_apply(&slopes.node.columns(row * edges, edges), |sum, entry| *sum += gone * entry);
        }
        if node.ncols() > 0 {
            let left = motion.rows(slopes.edge_row(), edges).into_owned();
            motion += node * left;
        }
        let strips = slopes.trailing.len();
        let mut wake = ComplexMatrix::zeros(slopes.rows(), strips);
        let mut delay = one;
        for row in 0..slopes.wake_rows {
            delay *= late.inv();
            let own = slopes.wake.columns(row * strips, strips);
            wake.zip_apply(&own, |sum, entry| *sum += delay * entry);
        }
        let trailing = |matrix: &ComplexMatrix| matrix.select_rows(&slopes.trailing);
        let shed = (ComplexMatrix::identity(strips, strips) - trailing(&wake)).lu().solve(&trailing(&motion))?;
        let answer = motion + wake * shed;
        let loads = 6 * slopes.sections;
        let rate = (one - back) / *step_s;
        let impulse = slopes.impulse.rows(0, loads).map(|entry| rate * entry) * answer.rows(0, slopes.panels);
        Some(answer.rows(slopes.panels, loads) * ((one + back) * 0.5) + impulse)
    }

    /// `z − E + z H Φ(z)`, with the delays of the wake by `late`.
    fn matrix(&self, z: Complex<f64>, late: Complex<f64>) -> Option<ComplexMatrix> {
        let n = self.pushed.nrows() / 2;
        let mut matrix = self.system.held.free.map(|entry| Complex::from(-entry));
        (0..2 * n).for_each(|i| matrix[(i, i)] += z);
        let loads = self.loads(z, late)?;
        let air = self.pushed.map(Complex::from) * loads;
        let mut own = matrix.columns_mut(0, n);
        own += air * z;
        Some(matrix)
    }

    /// Guesses of all motions with eigenvalues up to `radius_1_s`, and whether there may be more.
    fn within(&self, radius_1_s: f64) -> Option<(Vec<Guess>, bool)> {
        let n = self.pushed.nrows() / 2;
        let mass = &self.system.second.mass;
        let scale = DVector::from_fn(2 * n, |i, _| {
            let size = mass[(i % n, i % n)].sqrt().recip();
            if i < n { size } else { size * radius_1_s }
        });
        let mut factors_at = |value: Complex<f64>| {
            let z = (value * self.system.step_s).exp();
            let matrix = self.matrix(z, z)?;
            Some(ComplexFactors::new(2 * n, |i, j| matrix[(i, j)]))
        };
        let inside = contour::inside(radius_1_s, &scale, &mut factors_at)?;
        let guesses = inside.found.into_iter().map(|(value, shape)| ((value * self.system.step_s).exp(), shape));
        Some((guesses.collect(), inside.full))
    }

    /// The eigenvalue next to a guess, its shape, and the participation of the wake, by inverse iteration and the two-sided Rayleigh
    /// functional; `None` where the iteration does not end.
    fn corrected(&self, (mut z, mut right): Guess) -> Option<(Guess, f64)> {
        let size = right.norm();
        right.unscale_mut(size);
        let mut left = right.clone();
        let real = z.im == 0.0;
        let mut before = f64::INFINITY;
        for _ in 0..CORRECTIONS {
            let away = z - 1.0;
            let step = if away.norm() > 0.0 { away * STEP } else { Complex::from(STEP * STEP) };
            let matrix = self.matrix(z, z)?;
            let slope = (self.matrix(z + step, z + step)? - &matrix).map(|entry| entry / step);
            let factors = ComplexFactors::new(matrix.nrows(), |i, j| matrix[(i, j)]);
            let (x, y) = (factors.solve(&right), factors.solve_adjoint(&left));
            let (x_size, y_size) = (x.norm(), y.norm());
            // exactly singular: the eigenvalue to the last digit
            let singular = !(x_size.is_finite() && y_size.is_finite() && x_size > 0.0 && y_size > 0.0);
            if !singular {
                (right, left) = (x.unscale(x_size), y.unscale(y_size));
            }
            let slope_of = |slope: &ComplexMatrix| left.dotc(&(slope * &right));
            let mut change = left.dotc(&(&matrix * &right)) / slope_of(&slope);
            if real {
                change.im = 0.0;
            }
            z -= change;
            let (size, away) = (change.norm(), (z - 1.0).norm());
            // next to 1 round-off of the factor itself is more than that share of its distance: corrections then cease to fall
            let at_round_off = size <= SAME * away && size >= 0.5 * before;
            before = size;
            if singular || size <= FOUND * away.max(STEP) || at_round_off {
                let late = (self.matrix(z, z + step)? - self.matrix(z, z)?).map(|entry| entry / step);
                let wake = (slope_of(&late) / slope_of(&slope)).norm();
                return z.is_finite().then_some(((z, right), wake));
            }
        }
        None
    }

    /// A motion that passes so fast that steps show it as a slower one, which may move others: most of its kinetic energy is in rates
    /// that are not those of the eigenvalue.
    fn is_faster_than_steps(&self, z: Complex<f64>, right: &ComplexVector) -> bool {
        let n = self.pushed.nrows() / 2;
        let mass = self.system.second.mass.map(Complex::from);
        let energy = |rate: &ComplexVector| rate.dotc(&(&mass * rate)).re;
        let rate = right.rows(n, n).into_owned();
        let left = &rate - right.rows(0, n) * (z.ln() / self.system.step_s);
        energy(&left) > HIDDEN * energy(&rate)
    }

    /// The mode of an eigenvalue, of a pair that with positive imaginary part.
    fn named(&self, (z, right): Guess, lag_share: f64) -> Option<LaggedMode> {
        let n = self.pushed.nrows() / 2;
        let eigenvalue_1_s = z.ln() / self.system.step_s;
        let shape = right.rows(0, n).into_owned();
        let largest = shape.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
        if eigenvalue_1_s.im < 0.0 {
            let shape = (shape / largest).map(|entry| entry.conj());
            return Some(LaggedMode { eigenvalue_1_s: eigenvalue_1_s.conj(), shape, lag_share });
        }
        Some(LaggedMode { eigenvalue_1_s, shape: shape / largest, lag_share })
    }

    /// Motions of the machine with eigenvalues up to `radius_1_s` beyond those that nothing resists, and whether there may be some
    /// below a fraction of the radius, which a smaller circle tells apart. `None` where the moments fail.
    fn motions(&self, radius_1_s: f64, free_1_s: f64) -> Option<(Vec<LaggedMode>, bool)> {
        let (guesses, full) = self.within(radius_1_s)?;
        let value = |z: Complex<f64>| z.ln() / self.system.step_s;
        let slower = full || guesses.iter().any(|(z, _)| value(*z).norm() < radius_1_s / SHRINK);
        let mut list: Vec<LaggedMode> = Vec::new();
        for guess in guesses {
            let guessed = value(guess.0);
            let Some(((z, right), wake)) = self.corrected(guess) else { continue };
            let found = value(z);
            let size = found.norm();
            let counts = size > free_1_s && size <= radius_1_s && (found - guessed).norm() < STRAY * radius_1_s;
            if !counts || wake > WAKE && found.re <= GROWTH * size || self.is_faster_than_steps(z, &right) {
                continue;
            }
            let Some(mode) = self.named((z, right), wake) else { continue };
            let same = list.iter().filter(|other| is_same(other, &mode));
            let mut left = mode.shape.clone();
            let mut known: Vec<ComplexVector> = Vec::new();
            for other in same.map(|other| &other.shape).chain([&mode.shape]) {
                left = other.clone();
                let size = left.norm();
                for direction in &known {
                    let part = direction.dotc(&left);
                    left.axpy(-part, direction, Complex::from(1.0));
                }
                left.unscale_mut(size);
                known.push(left.normalize());
            }
            if left.norm() > OTHER {
                list.push(mode);
            }
        }
        Some((list, slower))
    }

    /// The slowest motions, ascending, at least `count` where steps can show so many, from a first circle of `radius_1_s`.
    /// `None` where the moments fail.
    fn slowest(&self, count: usize, radius_1_s: f64, free_1_s: f64) -> Option<Vec<LaggedMode>> {
        let fastest_1_s = NYQUIST * PI / self.system.step_s;
        let mut radius_1_s = radius_1_s.min(fastest_1_s);
        let (mut list, mut slower) = self.motions(radius_1_s, free_1_s)?;
        let mut smaller_1_s = radius_1_s;
        for _ in 0..CIRCLES {
            smaller_1_s /= SHRINK;
            if !slower || smaller_1_s <= free_1_s {
                break;
            }
            let found = self.motions(smaller_1_s, free_1_s)?;
            // a smaller circle is more accurate inside
            list.retain(|mode| {
                mode.eigenvalue_1_s.norm() > smaller_1_s && !found.0.iter().any(|other| is_same(other, mode))
            });
            list.extend(found.0);
            slower = found.1;
        }
        while list.len() < count && radius_1_s < fastest_1_s {
            let before_1_s = radius_1_s;
            radius_1_s = (GROW * radius_1_s).min(fastest_1_s);
            let mut found = self.motions(radius_1_s, free_1_s)?.0;
            found.retain(|mode| {
                mode.eigenvalue_1_s.norm() > before_1_s && !list.iter().any(|other| is_same(other, mode))
            });
            list.extend(found);
        }
        list.sort_by(|a, b| a.eigenvalue_1_s.norm().total_cmp(&b.eigenvalue_1_s.norm()));
        Some(list)
    }
}

/// Whether the eigenvalues of two modes differ by round-off only.
fn is_same(a: &LaggedMode, b: &LaggedMode) -> bool {
    (a.eigenvalue_1_s - b.eigenvalue_1_s).norm() < SAME * b.eigenvalue_1_s.norm()
}

impl Study<'_> {
    /// The `count` modes of lowest frequency in the air of a lattice about the present state of rest, ascending, those that only decay
    /// or only grow included; and the sign of the determinant of the static stiffness in the established flow, `None` if it is singular.
    /// Motions of the wake alone are left out unless they grow, and so are motions that are too fast for the aerodynamic step: there may
    /// be fewer modes than `count`.
    ///
    /// # Errors
    /// As [`Study::lattice_space`].
    pub fn lattice_modes_and_rest(&mut self, count: usize) -> Result<(Vec<ModeShape>, Option<bool>), PlantError> {
        let system = self.sampled_lattice(false)?;
        let time_s = self.system.state.now.time_s;
        let cause = |cause: &str| PlantError::Linearization { time_s, cause: cause.into() };
        let pushed = &system.held.by_force * &system.force;
        let delays = Delays { system: &system, pushed };
        let second = system.second.clone();
        let one = Complex::from(1.0);
        let at_rest =
            delays.loads(one, one).map(|loads| &second.stiffness + &system.force * loads.map(|entry| entry.re));
        let sign = at_rest.as_ref().and_then(determinant_is_positive);
        let structure = Lagged::without(second);
        let bare = structure.modes(count).map_err(|error| cause(&error.to_string()))?;
        let mut list = Vec::new();
        if let (false, Some(stiffness)) = (bare.is_empty(), at_rest) {
            let (still, free_1_s) =
                structure.still_with(&stiffness, count).map_err(|error| cause(&error.to_string()))?;
            let fastest_1_s = bare.iter().map(|mode| mode.eigenvalue_1_s.norm()).fold(0.0, f64::max);
            let radius_1_s = if fastest_1_s > free_1_s { fastest_1_s } else { PI / system.step_s / SHRINK };
            let failed = || cause("the eigenvalues of the model in discrete time are not found");
            list = still;
            list.extend(delays.slowest(count.saturating_sub(list.len()), radius_1_s, free_1_s).ok_or_else(failed)?);
            list.truncate(count);
        }
        let freedoms = self.system.freedoms();
        let mut shapes: Vec<ModeShape> = list.into_iter().map(|mode| self.mode_shape(mode, &freedoms)).collect();
        tell_lateral_apart(&mut shapes);
        Ok((shapes, sign))
    }
}
