//! Natural modes of `M ẍ + C ẋ + K x = 0`, NOTATION eqs. (L10)–(L11).
//!
//! Stiff modes (stretch) have frequencies up to 1e5 times those of interest, so the inverse problem is solved: its largest eigenvalues,
//! which are the low frequencies, are accurate to the last digits.

use crate::solve::complex_factors::ComplexFactors;
use nalgebra::{Complex, DMatrix, DVector, Schur};

/// One mode `x(t) = shape · exp(λt)`; for a complex pair, the one with positive imaginary part.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// Eigenvalue `λ` in 1/s.
    pub eigenvalue_1_s: Complex<f64>,
    /// Shape, over the coordinates of the matrices; its largest entry is real.
    pub shape: DVector<Complex<f64>>,
}

impl Mode {
    /// Frequency `|λ|/2π` in Hz.
    pub fn frequency_hz(&self) -> f64 {
        self.eigenvalue_1_s.norm() / std::f64::consts::TAU
    }

    /// Damping ratio `−Re λ/|λ|`: 0 for undamped motion, 1 or more without oscillation, negative if the motion grows.
    pub fn damping_ratio(&self) -> f64 {
        let size = self.eigenvalue_1_s.norm();
        if size == 0.0 { 0.0 } else { -self.eigenvalue_1_s.re / size }
    }

    /// Whether the motion grows by more than round-off.
    pub fn grows(&self) -> bool {
        grows(self.eigenvalue_1_s)
    }
}

/// Ratio of the real part to the magnitude of an eigenvalue above which a motion counts as growing: above the round-off of an undamped
/// motion.
const GROWTH: f64 = 1e-6;
/// Rate in 1/s up to which a motion counts as neutral, a factor of e in 30 years: eigenvalues of zero, for example of lag states without
/// flow, are computed only to round-off.
const NEUTRAL_1_S: f64 = 1e-9;

/// Returns whether a motion with this eigenvalue in 1/s grows, by more than round-off.
pub fn grows(eigenvalue_1_s: Complex<f64>) -> bool {
    eigenvalue_1_s.re > GROWTH * eigenvalue_1_s.norm() && eigenvalue_1_s.re > NEUTRAL_1_S
}

/// Modes cannot be computed: the matrices do not describe a mechanical system.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoModes {
    /// The mass matrix is not positive definite.
    #[error("the mass matrix is not positive definite")]
    Mass,
    /// The eigenvalue iteration failed.
    #[error("the eigenvalue iteration did not converge")]
    Iteration,
}

/// Asymmetry of the stiffness, relative to its scaled entries, that is treated as round-off.
const ASYMMETRY: f64 = 1e-10;

/// Eigenvalue below which a mode is a rigid-body mode, relative to the square root of the shift required by the stiffness.
pub(super) const FREE_MOTION: f64 = 1e-3;

/// The `count` modes of lowest frequency and every mode that grows, in ascending order. `mass` is symmetric and positive definite;
/// `damping` may contain gyroscopic terms; `stiffness` need not be symmetric (follower loads) or positive (buckled or free models).
pub fn modes(
    mass: &DMatrix<f64>,
    damping: &DMatrix<f64>,
    stiffness: &DMatrix<f64>,
    count: usize,
) -> Result<Vec<Mode>, NoModes> {
    modes_beyond([mass, damping, stiffness], count, 0.0)
}

/// Like [`modes`], for a stiffness `K` that may be negative by up to `shift_1_s2` times the mass, such as that of a rotor in the fixed
/// frame: `K + shift M` is then far from singular, which is not guaranteed for a shift found by trial.
pub fn modes_beyond(
    [mass, damping, stiffness]: [&DMatrix<f64>; 3],
    count: usize,
    shift_1_s2: f64,
) -> Result<Vec<Mode>, NoModes> {
    if mass.nrows() == 0 {
        return Ok(Vec::new());
    }
    let (shift, root) = shifted_root(mass, stiffness, shift_1_s2)?;
    let scaled = |matrix: &DMatrix<f64>| -> DMatrix<f64> {
        let half = root.solve_lower_triangular(matrix).unwrap_or_else(|| matrix.clone());
        let whole = root.solve_lower_triangular(&half.transpose());
        whole.unwrap_or(half).transpose()
    };
    let (mass_s, damping_s, stiffness_s) = (scaled(mass), scaled(damping), scaled(stiffness));
    let asymmetry = (&stiffness_s - stiffness_s.transpose()).amax();
    let mut list = if damping.amax() == 0.0 && asymmetry < ASYMMETRY {
        conservative(&mass_s, shift)
    } else {
        Pencil { mass: mass_s, damping: damping_s, stiffness: stiffness_s }.modes(shift.sqrt(), count)?
    };
    // eigenvalues of rigid-body modes result as round-off of the shift, with either sign
    for mode in list.iter_mut().filter(|mode| mode.eigenvalue_1_s.norm() < FREE_MOTION * shift.sqrt()) {
        mode.eigenvalue_1_s = Complex::new(0.0, 0.0);
    }
    list.sort_by(|a, b| a.eigenvalue_1_s.norm().total_cmp(&b.eigenvalue_1_s.norm()));
    let mut place = 0..;
    list.retain(|mode| place.next().is_some_and(|place| place < count) || mode.grows());
    for mode in &mut list {
        let parts = [mode.shape.map(|x| x.re), mode.shape.map(|x| x.im)]
            .map(|part| root.tr_solve_lower_triangular(&part).unwrap_or(part));
        let shape = DVector::from_fn(parts[0].len(), |i, _| Complex::new(parts[0][i], parts[1][i]));
        let largest = shape.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default();
        mode.shape = if largest.norm() > 0.0 { shape / largest } else { shape };
    }
    Ok(list)
}

/// Cholesky factor of the symmetric part of `K + σM`, with the smallest `σ` tried, from `first` upwards, that makes it positive definite.
pub(super) fn shifted_root(
    mass: &DMatrix<f64>,
    stiffness: &DMatrix<f64>,
    first: f64,
) -> Result<(f64, DMatrix<f64>), NoModes> {
    if mass.clone().cholesky().is_none() {
        return Err(NoModes::Mass);
    }
    let symmetric = (stiffness + stiffness.transpose()) * 0.5;
    let fastest = (0..mass.nrows()).fold(0.0f64, |fastest, i| fastest.max(symmetric[(i, i)].abs() / mass[(i, i)]));
    let mut shift = first;
    for _ in 0..40 {
        let matrix = &symmetric + mass * shift;
        // pivots at the level of round-off do not count as stiffness
        if let Some(factor) = matrix.clone().cholesky() {
            let root = factor.unpack();
            let sound = (0..root.nrows()).all(|i| root[(i, i)].powi(2) > 1e-13 * matrix[(i, i)]);
            if sound {
                return Ok((shift, root));
            }
        }
        shift = if shift == 0.0 { 1e-12 * fastest.max(1e-12) } else { 10.0 * shift };
    }
    Err(NoModes::Iteration)
}

/// Modes of a symmetric problem without damping: `M z = z/(ω² + σ)` in scaled coordinates.
fn conservative(mass: &DMatrix<f64>, shift: f64) -> Vec<Mode> {
    let eigen = ((mass + mass.transpose()) * 0.5).symmetric_eigen();
    (0..mass.nrows())
        .filter(|&i| eigen.eigenvalues[i] > 0.0)
        .map(|i| {
            let square = 1.0 / eigen.eigenvalues[i] - shift;
            let eigenvalue_1_s =
                if square >= 0.0 { Complex::new(0.0, square.sqrt()) } else { Complex::new((-square).sqrt(), 0.0) };
            Mode { eigenvalue_1_s, shape: eigen.eigenvectors.column(i).map(|x| Complex::new(x, 0.0)) }
        })
        .collect()
}

/// Quadratic eigenvalue problem `Q(λ) = λ²M + λC + K` in scaled coordinates.
struct Pencil {
    mass: DMatrix<f64>,
    damping: DMatrix<f64>,
    stiffness: DMatrix<f64>,
}

impl Pencil {
    /// Eigenvalues in the space of the undamped modes of lowest frequency, refined one by one over all coordinates.
    ///
    /// Over all coordinates the range of eigenvalues, about 1e10, would be too large for the deflation of the QR iteration.
    fn modes(&self, shift: f64, count: usize) -> Result<Vec<Mode>, NoModes> {
        let eigen = ((&self.mass + self.mass.transpose()) * 0.5).symmetric_eigen();
        let mut order: Vec<usize> = (0..self.mass.nrows()).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        order.truncate(4 * count + SPARE_MODES);
        let basis = eigen.eigenvectors.select_columns(&order);
        let within = |matrix: &DMatrix<f64>| basis.transpose() * matrix * &basis;
        let reduced =
            Self { mass: within(&self.mass), damping: within(&self.damping), stiffness: within(&self.stiffness) };
        let mut eigenvalues = reduced.eigenvalues(shift)?;
        eigenvalues.retain(|lambda| lambda.im >= -1e-9 * lambda.norm());
        eigenvalues.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
        // an undamped rigid-body mode has a double eigenvalue of zero, but is one mode
        let resisted = |mu: &f64| (1.0 / mu - shift * shift).abs() > (FREE_MOTION * shift).powi(2);
        let free = eigen.eigenvalues.iter().filter(|mu| **mu > 0.0 && !resisted(mu)).count();
        let zeros = eigenvalues.iter().take_while(|lambda| lambda.norm() < FREE_MOTION * shift).count();
        eigenvalues.drain(..zeros.saturating_sub(free));
        let mut list = Vec::new();
        for (i, eigenvalue) in eigenvalues.into_iter().enumerate() {
            let lowest = i < count;
            if !lowest && !grows(eigenvalue) {
                continue;
            }
            let (mode, converged) = self.polish(eigenvalue, i);
            // the highest eigenvalues over a truncated basis may grow although no mode of the model does
            if lowest || converged && mode.grows() {
                list.push(mode);
            }
        }
        Ok(list)
    }

    /// All eigenvalues, from the inverse companion form about `shift`: `ν = 1/(λ − shift)`.
    fn eigenvalues(&self, shift: f64) -> Result<Vec<Complex<f64>>, NoModes> {
        let n = self.mass.nrows();
        let still = &self.stiffness + &self.damping * shift + &self.mass * (shift * shift);
        let moving = &self.damping + &self.mass * (2.0 * shift);
        let lu = still.lu();
        let time_s = self.mass.amax().sqrt();
        let mut companion = DMatrix::zeros(2 * n, 2 * n);
        let solved = |matrix: &DMatrix<f64>| lu.solve(matrix).ok_or(NoModes::Iteration);
        companion.view_mut((0, 0), (n, n)).copy_from(&-solved(&moving)?);
        companion.view_mut((0, n), (n, n)).copy_from(&(-solved(&self.mass)? / time_s));
        companion.view_mut((n, 0), (n, n)).fill_diagonal(time_s);
        // small eigenvalues, the fast modes, may be lost in the round-off of large ones: try larger deflation thresholds
        let schur = [1e-16, 1e-14, 1e-12, 1e-10, 1e-8]
            .into_iter()
            .find_map(|tolerance| Schur::try_new(companion.clone(), tolerance, 60 * n))
            .ok_or(NoModes::Iteration)?;
        let values = schur.complex_eigenvalues();
        Ok(values.iter().filter(|nu| nu.norm() > 0.0).map(|nu| nu.inv() + shift).collect())
    }

    fn factors_at(&self, eigenvalue: Complex<f64>) -> ComplexFactors {
        let square = eigenvalue * eigenvalue;
        ComplexFactors::new(self.mass.nrows(), |i, j| {
            square * self.mass[(i, j)] + eigenvalue * self.damping[(i, j)] + self.stiffness[(i, j)]
        })
    }

    /// Refines a mode: its shape by inverse iteration, its eigenvalue by the two-sided Rayleigh quotient. Each `index` has a different
    /// start vector, so that equal eigenvalues get different shapes.
    ///
    /// Also returns whether the iteration converged.
    fn polish(&self, mut eigenvalue: Complex<f64>, index: usize) -> (Mode, bool) {
        let entry = |i: usize| (1.0 + ((i * (2 * index + 3)) % 11) as f64, 0.3 * ((i + index) % 3) as f64);
        let start = DVector::from_fn(self.mass.nrows(), |i, _| {
            let (re, im) = entry(i);
            Complex::new(re, im)
        });
        let (mut right, mut left) = (start.clone(), start);
        let mut converged = false;
        for _ in 0..8 {
            // slightly off the eigenvalue, so that the matrix has an inverse
            let near = eigenvalue * (1.0 + 1e-9) + Complex::new(1e-12, 0.0);
            let factors = self.factors_at(near);
            for _ in 0..2 {
                let (x, y) = (factors.solve(&right), factors.solve_adjoint(&left));
                let (x_size, y_size) = (x.norm(), y.norm());
                if !(x_size.is_finite() && y_size.is_finite()) {
                    break;
                }
                (right, left) = (x / Complex::new(x_size, 0.0), y / Complex::new(y_size, 0.0));
            }
            let form = |matrix: &DMatrix<f64>| {
                let product = matrix.map(|x| Complex::new(x, 0.0)) * &right;
                left.dotc(&product)
            };
            let (m, c, k) = (form(&self.mass), form(&self.damping), form(&self.stiffness));
            let slope = eigenvalue * m * 2.0 + c;
            let step = (eigenvalue * eigenvalue * m + eigenvalue * c + k) / slope;
            // a longer step would lead to another mode
            if !step.norm().is_finite() || step.norm() >= 0.1 * eigenvalue.norm() {
                break;
            }
            eigenvalue -= step;
            // the error of the quotient is reduced at least quadratically
            if step.norm() < CLOSE * eigenvalue.norm() {
                converged = true;
                break;
            }
        }
        (Mode { eigenvalue_1_s: eigenvalue, shape: right }, converged)
    }
}

/// Relative correction of an eigenvalue after which the remaining error is round-off.
const CLOSE: f64 = 1e-8;

/// Number of undamped modes in the basis of the damped ones, in addition to four times the requested number.
pub(super) const SPARE_MODES: usize = 24;

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of unit masses and springs: `ω_i = 2 sin((2i − 1)π/(4n + 2))`; an additional spring that is 1e14 times stiffer does not
    /// reduce the accuracy, and proportional damping shifts the eigenvalues by the analytical amount.
    #[test]
    fn chain_of_masses() {
        let n = 6;
        let chain = DMatrix::from_fn(n + 1, n + 1, |i, j| match (i, j) {
            (i, j) if i == n && j == n => 1e14,
            (i, j) if i == n || j == n => 0.0,
            (i, j) if i == j => {
                if i + 1 == n {
                    1.0
                } else {
                    2.0
                }
            }
            (i, j) if i.abs_diff(j) == 1 => -1.0,
            _ => 0.0,
        });
        let mass = DMatrix::identity(n + 1, n + 1);
        let beta = 0.01;
        for damping in [DMatrix::zeros(n + 1, n + 1), &chain * beta] {
            let damped = damping.amax() > 0.0;
            let list = modes(&mass, &damping, &chain, n).unwrap();
            for (i, mode) in list.iter().enumerate() {
                let exact = 2.0 * ((2 * i + 1) as f64 * std::f64::consts::PI / (4 * n + 2) as f64).sin();
                let ratio = if damped { 0.5 * beta * exact } else { 0.0 };
                assert!((mode.eigenvalue_1_s.norm() / exact - 1.0).abs() < 1e-12, "{i}: {}", mode.eigenvalue_1_s);
                assert!((mode.damping_ratio() - ratio).abs() < 1e-12, "{i}: {}", mode.damping_ratio());
            }
        }
    }

    /// Uncoupled oscillators, and among the faster ones two equal oscillators with an asymmetric stiffness, like that of a follower load:
    /// the pair flutters, `λ² = −k ± i a`, at a frequency above the lowest modes, and is found even if only one or three modes are
    /// requested.
    #[test]
    fn growing_mode_above_the_lowest() {
        let (n, k, a) = (40, 420.25, 5.0);
        let mut stiffness = DMatrix::from_fn(n, n, |i, j| if i == j { ((i + 1) * (i + 1)) as f64 } else { 0.0 });
        (stiffness[(n - 1, n - 1)], stiffness[(n - 2, n - 2)]) = (k, k);
        let mut damping = DMatrix::zeros(n, n);
        for i in 0..n - 2 {
            damping[(i, i)] = 0.01;
        }
        (stiffness[(n - 2, n - 1)], stiffness[(n - 1, n - 2)]) = (a, -a);
        let exact = Complex::new(-k, -a).sqrt();
        let exact = if exact.re < 0.0 { -exact } else { exact }.conj();
        for count in [1, 4] {
            let list = modes(&DMatrix::identity(n, n), &damping, &stiffness, count).unwrap();
            assert_eq!(list.len(), count + 1);
            let last = list[count].eigenvalue_1_s;
            assert!(
                (Complex::new(last.re, last.im.abs()) - Complex::new(exact.re, exact.im.abs())).norm() < 1e-9 * k,
                "{last}, {exact}"
            );
        }
    }

    /// A rotor: `ẍ − 2Ωẏ + (k − Ω²)x` whirls at `√k ± Ω`. A free mass has frequency zero; an inverted pendulum grows.
    #[test]
    fn rotor_free_mass_and_inverted_pendulum() {
        let (k, omega) = (4.0, 0.5);
        let gyroscopic = DMatrix::from_row_slice(2, 2, &[0.0, -2.0 * omega, 2.0 * omega, 0.0]);
        let list = modes(&DMatrix::identity(2, 2), &gyroscopic, &(DMatrix::identity(2, 2) * (k - omega * omega)), 4);
        let found: Vec<f64> = list.unwrap().iter().map(|mode| mode.eigenvalue_1_s.im).collect();
        assert!((found[0] - 1.5).abs() < 1e-12 && (found[1] - 2.5).abs() < 1e-12, "{found:?}");

        let stiffness = DMatrix::from_diagonal(&DVector::from_vec(vec![0.0, -9.0, 100.0]));
        let list = modes(&DMatrix::identity(3, 3), &DMatrix::zeros(3, 3), &stiffness, 3).unwrap();
        assert_eq!(list[0].eigenvalue_1_s.norm(), 0.0);
        assert!((list[1].eigenvalue_1_s - Complex::new(3.0, 0.0)).norm() < 1e-9, "{}", list[1].eigenvalue_1_s);
        assert_eq!(list[1].damping_ratio(), -1.0);
    }
}
