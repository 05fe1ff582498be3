//! Modes of a model with a lattice, NOTATION eq. (L30): the rows of the wake act as delays, so that the eigenvalues of the discrete-time
//! system are those of a small matrix that depends on the eigenvalue.

use crate::solve::complex_factors::ComplexFactors;
use crate::solve::contour;
use crate::solve::lagged::{Lagged, LaggedMode};
use crate::solve::modes::grows;
use crate::study::Study;
use crate::study::flight::tell_lateral_apart;
use crate::study::lattice_delays::Delays;
use crate::study::linear::determinant_is_positive;
use crate::system::PlantError;
use crate::system::shape::ModeShape;
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::PI;

type ComplexMatrix = DMatrix<Complex<f64>>;
type ComplexVector = DVector<Complex<f64>>;

/// Maximum number of corrections of an eigenvalue.
const CORRECTIONS: usize = 30;
/// Correction of an eigenvalue, relative to its distance from 1, below which it has converged.
const FOUND: f64 = 1e-11;
/// Relative difference below which two eigenvalues are equal.
const SAME: f64 = 1e-6;
/// Fraction of a shape that must be orthogonal to those with the same eigenvalue, so that it counts as another mode.
const OTHER: f64 = 1e-2;
/// Step of the derivative with respect to the eigenvalue, relative to its distance from 1.
const STEP: f64 = 1e-6;
/// Correction of an estimate, relative to the radius in which it was found, above which it is discarded: estimates are accurate to 1e-6.
const STRAY: f64 = 0.1;

/// Ratio of the radii of two circles: moments over a circle resolve modes that are not much slower than its radius.
const SHRINK: f64 = 4.0;
/// Ratio by which the first circle grows while it contains too few modes.
const GROW: f64 = 2.0;
/// Maximum number of nested circles: slower modes would be round-off, see [`crate::solve::lagged::Lagged::still_with`].
const CIRCLES: usize = 12;
/// Magnitude up to which modes are sought, relative to the largest eigenvalue without aliasing by the steps.
const NYQUIST: f64 = 0.98;
/// Participation of the wake above which a mode that does not grow is a wake mode, like the lag modes in (L22).
const WAKE: f64 = 0.5;
/// Fraction of the kinetic energy in rates that are inconsistent with the eigenvalue, above which the mode is too fast for the step.
const HIDDEN: f64 = 0.5;
/// Decay of an estimate, relative to the radius of its circle, above which it cannot belong to a mode that grows: a thousand times the
/// error of estimates.
const DECAYS: f64 = 1e-3;

/// Factor by which motions may decay while the air passes along the wake. The inverse of this factor multiplies the wake's last row for a
/// decaying motion: with 1e6 ten digits of the aerodynamic loads remain, with 1e16 none, and the moments over a circle that extends so far
/// are noise.
const FADED: f64 = 1e6;
/// Number of eigenvalues that a disc can hold in addition to those of the model.
const CAPACITY: usize = 60;
/// Distance from the centre, relative to the radius, up to which eigenvalues contribute to the moments beyond round-off.
const REACH: f64 = 1.5;
/// Distance of the centres of neighbouring discs, relative to their radius: two discs intersect at 0.66 of the radius.
const APART: f64 = 1.5;
/// Half-width of a row of discs that is fully covered between its ends, relative to the radius: at the intersections of neighbours.
const ACROSS: f64 = 0.66;
/// Ratio of the radii of a row of discs and of the row to its left. They overlap: `RISE (1 - ACROSS) < 1 + ACROSS`.
const RISE: f64 = 4.0;
/// Magnitude, relative to the radius of the disc about 0, up to which other discs are not used.
const INNER: f64 = 0.9;

/// A disc in the plane of eigenvalues. Circles around all eigenvalues up to a frequency are not usable: they extend to regions where the
/// wake is round-off, and to the copies of each eigenvalue at a spacing of `2π` divided by the step.
#[derive(Debug, Clone, Copy)]
struct Disc {
    center_1_s: Complex<f64>,
    radius_1_s: f64,
}

/// Kind of modes sought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sought {
    /// All modes of the model, and growing modes of the wake.
    All,
    /// Growing modes: estimates that decay are not corrected.
    Growing,
}

/// `z` and a shape of coordinates and rates.
type Guess = (Complex<f64>, ComplexVector);

impl Delays<'_> {
    /// Estimates of all modes with eigenvalues in a disc, and whether there may be more.
    fn within(&self, disc: Disc) -> Option<(Vec<Guess>, bool)> {
        let n = self.by_place.ncols();
        let mass = &self.system.second.mass;
        let scale = DVector::from_fn(2 * n, |i, _| {
            let size = mass[(i % n, i % n)].sqrt().recip();
            if i < n { size } else { size * (disc.center_1_s.norm() + disc.radius_1_s) }
        });
        let mut factors_at = |value: Complex<f64>| {
            let z = (value * self.system.step_s).exp();
            let matrix = self.matrix(z, z)?;
            Some(ComplexFactors::new(2 * n, |i, j| matrix[(i, j)]))
        };
        let inside = contour::inside(disc.center_1_s, disc.radius_1_s, self.capacity(disc), &scale, &mut factors_at)?;
        let guesses = inside.found.into_iter().map(|(value, shape)| self.mirrored_if_better(disc, value, shape));
        Some((guesses.collect(), inside.full))
    }

    /// The estimate, or its mirror image at the height of the disc's centre if that fits better.
    fn mirrored_if_better(&self, disc: Disc, value_1_s: Complex<f64>, shape: ComplexVector) -> Guess {
        let at = |value_1_s: Complex<f64>| (value_1_s * self.system.step_s).exp();
        if disc.center_1_s.im == 0.0 {
            return (at(value_1_s), shape);
        }
        let left = |z: Complex<f64>, shape: &ComplexVector| {
            self.matrix(z, z).map_or(f64::INFINITY, |matrix| (&matrix * shape).norm() / matrix.norm())
        };
        let mirrored_1_s = Complex::new(value_1_s.re, 2.0 * disc.center_1_s.im - value_1_s.im);
        let conjugate = shape.map(|entry| entry.conj());
        if left(at(mirrored_1_s), &conjugate) < left(at(value_1_s), &shape) {
            return (at(mirrored_1_s), conjugate);
        }
        (at(value_1_s), shape)
    }

    /// Number of eigenvalues that the moments must resolve: each mode of the model appears as one within the range of the steps, in pairs
    /// distributed over it, in addition to modes of the wake.
    fn capacity(&self, disc: Disc) -> usize {
        let machine = 2.0 * self.by_place.ncols() as f64 * (REACH * disc.radius_1_s * self.system.step_s / PI).min(1.0);
        CAPACITY + machine.ceil() as usize
    }

    /// Decay rate in 1/s above which modes are not sought, because the oldest row of the wake would be amplified relative to the youngest
    /// by more than the accuracy allows.
    fn fastest_decay_1_s(&self) -> f64 {
        let rows = self.nodes.len().max(self.wake.len()).max(1);
        FADED.ln() / (rows as f64 * self.system.step_s)
    }

    /// The eigenvalue closest to an estimate, its shape, and the participation of the wake, by inverse iteration and the two-sided Rayleigh
    /// functional; `None` if the iteration does not converge.
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
            // exactly singular: the eigenvalue is accurate to the last digit
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
            // close to 1, the round-off of the factor itself exceeds that fraction of its distance: corrections then cease to decrease
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

    /// Whether the steps alias a mode to a slower one, which may be coupled to others: most of its kinetic energy is in rates that are
    /// inconsistent with the eigenvalue.
    fn is_faster_than_steps(&self, z: Complex<f64>, right: &ComplexVector) -> bool {
        let n = self.by_place.ncols();
        let mass = self.system.second.mass.map(Complex::from);
        let energy = |rate: &ComplexVector| rate.dotc(&(&mass * rate)).re;
        let rate = right.rows(n, n).into_owned();
        let left = &rate - right.rows(0, n) * (z.ln() / self.system.step_s);
        energy(&left) > HIDDEN * energy(&rate)
    }

    /// The mode of an eigenvalue; for a pair, the one with positive imaginary part.
    fn named(&self, (z, right): Guess, lag_share: f64) -> Option<LaggedMode> {
        let n = self.by_place.ncols();
        let eigenvalue_1_s = z.ln() / self.system.step_s;
        let shape = right.rows(0, n).into_owned();
        let largest = shape.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
        if eigenvalue_1_s.im < 0.0 {
            let shape = (shape / largest).map(|entry| entry.conj());
            return Some(LaggedMode { eigenvalue_1_s: eigenvalue_1_s.conj(), shape, lag_share });
        }
        Some(LaggedMode { eigenvalue_1_s, shape: shape / largest, lag_share })
    }

    /// Modes of the model with eigenvalues in a disc and up to `fastest_1_s`, except rigid-body modes, and whether there may be some
    /// below a fraction of the radius, which a smaller disc about 0 resolves. `None` if the moments fail.
    fn motions(&self, disc: Disc, fastest_1_s: f64, free_1_s: f64, sought: Sought) -> Option<(Vec<LaggedMode>, bool)> {
        let (guesses, full) = self.within(disc)?;
        let radius_1_s = disc.radius_1_s;
        let value = |z: Complex<f64>| z.ln() / self.system.step_s;
        let slower = full || guesses.iter().any(|(z, _)| value(*z).norm() < radius_1_s / SHRINK);
        let mut list: Vec<LaggedMode> = Vec::new();
        for guess in guesses {
            let guessed = value(guess.0);
            if sought == Sought::Growing && guessed.re < -DECAYS * radius_1_s {
                continue;
            }
            let Some(((z, right), wake)) = self.corrected(guess) else { continue };
            let found = value(z);
            let size = found.norm();
            let counts = size > free_1_s && size <= fastest_1_s && (found - guessed).norm() < STRAY * radius_1_s;
            let decays = !grows(found);
            let left_out = decays && (wake > WAKE || sought == Sought::Growing);
            if !counts || left_out || self.is_faster_than_steps(z, &right) {
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

    /// The slowest modes in ascending order, at least `count` if the steps resolve this number, starting from a limit of `radius_1_s`.
    /// `None` if the moments fail.
    fn slowest(&self, count: usize, radius_1_s: f64, free_1_s: f64) -> Option<Vec<LaggedMode>> {
        let fastest_1_s = self.fastest_1_s();
        let mut radius_1_s = radius_1_s.min(fastest_1_s);
        let mut list = self.inside(0.0, radius_1_s, free_1_s, Sought::All)?;
        while list.len() < count && radius_1_s < fastest_1_s {
            let before_1_s = radius_1_s;
            radius_1_s = (GROW * radius_1_s).min(fastest_1_s);
            let found = self.inside(before_1_s, radius_1_s, free_1_s, Sought::All)?;
            merge(&mut list, found);
        }
        list.sort_by(|a, b| a.eigenvalue_1_s.norm().total_cmp(&b.eigenvalue_1_s.norm()));
        Some(list)
    }

    /// The growing modes up to `radius_1_s`, or further if the sign of the static stiffness (`is_stiff`) and the number of real growing
    /// modes disagree; and whether they finally agree. `None` if the moments fail.
    fn growing(&self, radius_1_s: f64, free_1_s: f64, is_stiff: Option<bool>) -> Option<(Vec<LaggedMode>, bool)> {
        let fastest_1_s = self.fastest_1_s();
        let mut radius_1_s = radius_1_s.min(fastest_1_s);
        let (mut list, mut before_1_s) = (Vec::new(), 0.0);
        loop {
            merge(&mut list, self.inside(before_1_s, radius_1_s, free_1_s, Sought::Growing)?);
            let leaving = list.iter().filter(|mode| mode.eigenvalue_1_s.im == 0.0).count();
            let agrees = is_stiff.is_none_or(|is_stiff| is_stiff == leaving.is_multiple_of(2));
            if agrees || radius_1_s >= fastest_1_s {
                return Some((list, agrees));
            }
            before_1_s = radius_1_s;
            radius_1_s = (GROW * radius_1_s).min(fastest_1_s);
        }
    }

    /// Magnitude in 1/s of the largest eigenvalue sought.
    fn fastest_1_s(&self) -> f64 {
        NYQUIST * PI / self.system.step_s
    }

    /// The modes between two limits in 1/s: by a disc about 0, with smaller nested ones if there are much slower modes, and by [`discs`]
    /// that cover the rest. `None` if the moments fail.
    fn inside(&self, from_1_s: f64, to_1_s: f64, free_1_s: f64, sought: Sought) -> Option<Vec<LaggedMode>> {
        let decay_1_s = self.fastest_decay_1_s();
        let mut list = Vec::new();
        if from_1_s < decay_1_s {
            list = self.slower(decay_1_s.min(to_1_s), free_1_s, sought)?;
        }
        for disc in discs(decay_1_s, from_1_s, to_1_s) {
            let (mut found, _) = self.motions(disc, to_1_s, free_1_s, sought)?;
            // the smaller discs about 0 are more accurate
            found.retain(|mode| mode.eigenvalue_1_s.norm() > INNER * decay_1_s);
            merge(&mut list, found);
        }
        Some(list)
    }

    /// The modes in a disc about 0.
    fn slower(&self, radius_1_s: f64, free_1_s: f64, sought: Sought) -> Option<Vec<LaggedMode>> {
        let about = |radius_1_s: f64| Disc { center_1_s: Complex::from(0.0), radius_1_s };
        let (mut list, mut slower) = self.motions(about(radius_1_s), radius_1_s, free_1_s, sought)?;
        let mut smaller_1_s = radius_1_s;
        for _ in 0..CIRCLES {
            smaller_1_s /= SHRINK;
            if !slower || smaller_1_s <= free_1_s {
                break;
            }
            let found = self.motions(about(smaller_1_s), smaller_1_s, free_1_s, sought)?;
            // a smaller circle is more accurate inside it
            list.retain(|mode| mode.eigenvalue_1_s.norm() > smaller_1_s);
            merge(&mut list, found.0);
            slower = found.1;
        }
        Some(list)
    }
}

/// Discs that, together with one about 0, cover the eigenvalues between two magnitudes in 1/s that do not decay: rows of discs with
/// leftmost points at `-decay_1_s`, beyond which the wake is round-off. Each row is further to the right than the previous one, with larger
/// discs. Empty up to `decay_1_s`, which the disc about 0 covers.
fn discs(decay_1_s: f64, from_1_s: f64, to_1_s: f64) -> Vec<Disc> {
    let largest_1_s = (to_1_s + decay_1_s) / (1.0 + ACROSS);
    // left edge of the strip that the next row must cover
    let mut left_1_s = if decay_1_s < to_1_s { 0.0 } else { to_1_s };
    let (mut list, mut radius_1_s) = (Vec::new(), decay_1_s);
    while left_1_s < to_1_s {
        // the last row need not extend beyond the largest eigenvalue
        let last_row = radius_1_s >= largest_1_s;
        radius_1_s = radius_1_s.min(largest_1_s);
        let apart_1_s = APART * radius_1_s;
        let first = usize::from(left_1_s == 0.0);
        let last = (to_1_s / apart_1_s).round() as usize;
        for at in first..=last {
            let center_1_s = Complex::new(radius_1_s - decay_1_s, at as f64 * apart_1_s);
            let nearest_1_s = left_1_s.hypot((center_1_s.im - 0.5 * apart_1_s).max(0.0));
            if nearest_1_s < to_1_s && center_1_s.norm() + radius_1_s > from_1_s {
                list.push(Disc { center_1_s, radius_1_s });
            }
        }
        left_1_s = if last_row { to_1_s } else { (1.0 + ACROSS) * radius_1_s - decay_1_s };
        radius_1_s *= RISE;
    }
    list
}

/// Whether the eigenvalues of two modes differ by round-off only.
fn is_same(a: &LaggedMode, b: &LaggedMode) -> bool {
    (a.eigenvalue_1_s - b.eigenvalue_1_s).norm() < SAME * b.eigenvalue_1_s.norm()
}

/// Adds modes that are not in the list yet. Several with one eigenvalue come from the same disc.
fn merge(list: &mut Vec<LaggedMode>, found: Vec<LaggedMode>) {
    let known = list.len();
    for mode in found {
        if !list[..known].iter().any(|other| is_same(other, &mode)) {
            list.push(mode);
        }
    }
}

impl Study<'_> {
    /// The `count` modes of lowest frequency with a lattice about the current equilibrium, in ascending order, including those that decay
    /// or grow without oscillation; and the sign of the determinant of the static stiffness in the established flow, `None` if it is
    /// singular. Modes of the wake alone are omitted unless they grow, and so are modes that are too fast for the aerodynamic step: there
    /// may be fewer modes than `count`.
    ///
    /// # Errors
    /// As for [`Study::lattice_space`].
    pub fn lattice_modes_and_rest(&mut self, count: usize) -> Result<(Vec<ModeShape>, Option<bool>), PlantError> {
        let system = self.sampled_lattice(false)?;
        let delays = Delays::new(&system);
        let Start { sign, still, free_1_s, radius_1_s } = self.start_of(&delays, count)?;
        let mut list = still;
        if let Some(radius_1_s) = radius_1_s {
            let wanted = count.saturating_sub(list.len());
            list.extend(delays.slowest(wanted, radius_1_s, free_1_s).ok_or_else(|| self.no_eigenvalues())?);
            list.truncate(count);
        }
        let freedoms = self.system.freedoms();
        let mut shapes: Vec<ModeShape> = list.into_iter().map(|mode| self.mode_shape(mode, &freedoms)).collect();
        tell_lateral_apart(&mut shapes);
        Ok((shapes, sign))
    }

    /// The growing modes with a lattice about the current equilibrium, among those no faster than the `count`-th mode of the structure
    /// alone, one of each pair. The cost is a fraction of that of [`Study::lattice_modes_and_rest`].
    ///
    /// # Errors
    /// As for [`Study::lattice_space`], and if the static aeroelastic stiffness has an unstable direction without a corresponding mode.
    pub(super) fn growing_in_air_of_lattice(&mut self, count: usize) -> Result<Vec<ModeShape>, PlantError> {
        let system = self.sampled_lattice(false)?;
        let delays = Delays::new(&system);
        let Start { sign, still, free_1_s, radius_1_s } = self.start_of(&delays, count)?;
        let Some(radius_1_s) = radius_1_s else { return Ok(Vec::new()) };
        // the stiffness of rigid-body modes is round-off
        let is_stiff = sign.filter(|_| still.is_empty());
        let found = delays.growing(radius_1_s, free_1_s, is_stiff);
        let (list, agrees) = found.ok_or_else(|| self.no_eigenvalues())?;
        if !agrees {
            let cause = "the sign of the static aeroelastic stiffness and the number of unstable real modes disagree: \
                         the model is close to divergence, or the mesh or the aerodynamic step is too coarse";
            return Err(PlantError::Linearization { time_s: self.system.state.now.time_s, cause: cause.into() });
        }
        let freedoms = self.system.freedoms();
        Ok(list.into_iter().map(|mode| self.mode_shape(mode, &freedoms)).collect())
    }

    /// Starting data of the search for modes.
    fn start_of(&self, delays: &Delays, count: usize) -> Result<Start, PlantError> {
        let cause = |error: &dyn std::fmt::Display| PlantError::Linearization {
            time_s: self.system.state.now.time_s,
            cause: error.to_string(),
        };
        let one = Complex::from(1.0);
        let second = delays.system.second.clone();
        let at_rest = delays.forces(one, one).map(|forces| &second.stiffness + forces.map(|entry| entry.re));
        let sign = at_rest.as_ref().and_then(determinant_is_positive);
        let structure = Lagged::without(second);
        let bare = structure.modes(count).map_err(|error| cause(&error))?;
        let mut start = Start { sign, still: Vec::new(), free_1_s: 0.0, radius_1_s: None };
        if let (false, Some(stiffness)) = (bare.is_empty(), at_rest) {
            (start.still, start.free_1_s) = structure.still_with(&stiffness, count).map_err(|error| cause(&error))?;
            let fastest_1_s = bare.iter().take(count).map(|mode| mode.eigenvalue_1_s.norm()).fold(0.0, f64::max);
            start.radius_1_s =
                Some(if fastest_1_s > start.free_1_s { fastest_1_s } else { PI / delays.system.step_s / SHRINK });
        }
        Ok(start)
    }

    fn no_eigenvalues(&self) -> PlantError {
        let cause = "the eigenvalues of the discrete-time model could not be computed".into();
        PlantError::Linearization { time_s: self.system.state.now.time_s, cause }
    }
}

/// Starting data of the search for modes.
struct Start {
    /// Sign of the determinant of the static aeroelastic stiffness; `None` if it is singular.
    sign: Option<bool>,
    /// Rigid-body modes (no stiffness).
    still: Vec<LaggedMode>,
    /// Magnitude of the eigenvalue in 1/s below which modes are rigid-body modes.
    free_1_s: f64,
    /// Radius of the first circle in 1/s; `None` without modes.
    radius_1_s: Option<f64>,
}

#[cfg(test)]
mod tests;
