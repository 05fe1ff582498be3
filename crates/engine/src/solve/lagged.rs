//! Modes of second-order equations with first-order lag states, for example of aeroelastic systems, NOTATION eq. (L22).
//!
//! `M q̈ + C q̇ + K q + G x = 0`, `ẋ = P q + R q̇ + L x`.

use crate::solve::complex_factors::ComplexFactors;
use crate::solve::eigen::eigen;
use crate::solve::linearize::SecondOrder;
use crate::solve::modes::{FREE_MOTION, NoModes, SPARE_MODES, grows, modes, shifted_root};
use crate::solve::reduction::balanced_rows;
use crate::solve::resolvent::Resolvent;
use nalgebra::{Complex, DMatrix, DVector};

/// Equations linearised about a state.
#[derive(Debug, Clone, PartialEq)]
pub struct Lagged {
    /// Mass, damping and stiffness, `M`, `C` and `K`.
    pub second: SecondOrder,
    /// `G`: derivative of the residual with respect to the lag states.
    pub force: DMatrix<f64>,
    /// `P`: derivative of the lag states' rates with respect to the coordinates.
    pub position: DMatrix<f64>,
    /// `R`: derivative of the lag states' rates with respect to the rates of the coordinates.
    pub rate: DMatrix<f64>,
    /// `L`: derivative of the lag states' rates with respect to the lag states.
    pub lag: DMatrix<f64>,
}

/// A mode `q(t) = shape · exp(λt)`; for a complex pair, the one with positive imaginary part.
#[derive(Debug, Clone, PartialEq)]
pub struct LaggedMode {
    /// Eigenvalue `λ` in 1/s.
    pub eigenvalue_1_s: Complex<f64>,
    /// Shape over the coordinates; its largest entry is real.
    pub shape: DVector<Complex<f64>>,
    /// Participation of the lag states: 0 if they do not participate, 1 if nothing else does.
    pub lag_share: f64,
}

/// Relative correction of an eigenvalue below which the error is round-off.
const CLOSE: f64 = 1e-10;
/// Relative distance from an eigenvalue of the lag states alone below which an eigenvalue is counted as one of theirs.
const OWN: f64 = 1e-7;
/// Participation of the lag states above which a mode that does not grow is counted as a lag mode, not as a motion of the model.
const LAG: f64 = 0.5;

/// Relative distance from an eigenvalue of the lag states alone within which an eigenvalue that has not converged is attributed to them.
const CROWD: f64 = 1e-2;
/// Maximum number of rounds, between which the basis of shapes is extended.
const MAXIMUM_ROUNDS: usize = 4;
/// Dimension of the Krylov space of slow motions.
const KRYLOV: usize = 16;
/// Eigenvalue, relative to the square root of the shift required by the stiffness, below which it is round-off: the finite differences in
/// the matrices are accurate to 1e-9, which changes a double zero by the square root of that.
const SLOWEST: f64 = 1e-4;
/// Fraction of a unit direction that must be orthogonal to the basis of shapes, so that round-off does not extend the basis.
const NEW: f64 = 1e-6;

/// Eigenvalue in 1/s below which a motion is a rigid-body mode, from the shift of the stiffness.
fn free_1_s(shift_1_s2: f64) -> f64 {
    SLOWEST * shift_1_s2.sqrt()
}

/// Eigenvalues and their vectors.
type Eigenpairs = (Vec<Complex<f64>>, Vec<DVector<Complex<f64>>>);

/// An eigenvalue in 1/s with its shape over a basis, and the eigenvalue that the refinement reached without convergence.
type Guess = (Complex<f64>, DVector<Complex<f64>>, Complex<f64>);

impl Lagged {
    /// Equations without lag states.
    pub fn without(second: SecondOrder) -> Self {
        let n = second.mass.nrows();
        let (wide, high) = (DMatrix::zeros(n, 0), DMatrix::zeros(0, n));
        Self { second, force: wide, position: high.clone(), rate: high, lag: DMatrix::zeros(0, 0) }
    }

    /// Static stiffness with the lag states in equilibrium, `K − G L⁻¹ P`; `None` if the lag states have no equilibrium.
    pub fn rest_stiffness(&self) -> Option<DMatrix<f64>> {
        if self.lag.nrows() == 0 {
            return Some(self.second.stiffness.clone());
        }
        let follow = self.lag.clone().lu().solve(&self.position)?;
        Some(&self.second.stiffness - &self.force * follow)
    }

    /// The `count` modes of lowest frequency, without lag modes, and every mode that grows, in ascending order. There are fewer if modes
    /// have not converged after four rounds: these are omitted unless they grow. Growing modes are sought in the space of `4 count + 24`
    /// undamped modes.
    ///
    /// # Errors
    /// If the mass matrix is not positive definite or the iteration fails.
    pub fn modes(&self, count: usize) -> Result<Vec<LaggedMode>, NoModes> {
        let SecondOrder { mass, damping, stiffness } = &self.second;
        if self.lag.nrows() == 0 || mass.nrows() == 0 {
            let list = modes(mass, damping, stiffness, count)?;
            let plain = |mode: crate::solve::modes::Mode| LaggedMode {
                eigenvalue_1_s: mode.eigenvalue_1_s,
                shape: mode.shape,
                lag_share: 0.0,
            };
            return Ok(list.into_iter().map(plain).collect());
        }
        let (shift, mut basis) = self.basis(4 * count + SPARE_MODES)?;
        let limits = [free_1_s(shift), FREE_MOTION.powi(2) * shift];
        let own = eigen(&balanced_rows(&self.lag).0).ok_or(NoModes::Iteration)?.values;
        let resolvent = Resolvent::of(&self.lag);
        let mut round = 1;
        loop {
            let (mut list, lacking) = self.modes_over(&basis, (&own, &resolvent), limits, count)?;
            let fastest_1_s = lacking.iter().fold(0.0f64, |fastest, (value, _, _)| fastest.max(value.norm()));
            if lacking.is_empty()
                || round == MAXIMUM_ROUNDS
                || !extend(&mut basis, &self.slow_shapes(fastest_1_s, &lacking), &self.second.mass)
            {
                // growing modes are reported even if their eigenvalue is not exact
                let exact = |mode: &LaggedMode| {
                    grows(mode.eigenvalue_1_s)
                        || lacking.iter().all(|(_, _, polished)| *polished != mode.eigenvalue_1_s)
                };
                list.retain(exact);
                return Ok(list);
            }
            round += 1;
        }
    }

    /// Shapes of the Krylov space of the inverse about a real `at_1_s`, starting from the sum of some shapes. It contains slower motions,
    /// whose aerodynamic deformation may differ from that of any undamped mode.
    fn slow_shapes(&self, at_1_s: f64, start: &[Guess]) -> Vec<DVector<f64>> {
        let (n, lags) = (self.position.ncols(), self.lag.nrows());
        let SecondOrder { mass, damping, stiffness } = &self.second;
        let own = (DMatrix::identity(lags, lags) * at_1_s - &self.lag).lu();
        let drive = &self.position + &self.rate * at_1_s;
        let Some(follow) = own.solve(&drive) else { return Vec::new() };
        let factors = (mass * at_1_s.powi(2) + damping * at_1_s + stiffness + &self.force * follow).lu();
        // (A - at) z = b with z = (q, dq/dt, x)
        let solved = |b: &DVector<f64>| -> Option<DVector<f64>> {
            let (b_q, b_v, b_x) = (b.rows(0, n), b.rows(n, n), b.rows(2 * n, lags));
            let by_lag = own.solve(&(&self.rate * b_q - b_x))?;
            let right = -(mass * (b_v + b_q * at_1_s) + damping * b_q + &self.force * by_lag);
            let q = factors.solve(&right)?;
            let v = &q * at_1_s + b_q;
            let x = own.solve(&(&self.position * &q + &self.rate * &v - b_x))?;
            let mut z = DVector::zeros(2 * n + lags);
            z.rows_mut(0, n).copy_from(&q);
            z.rows_mut(n, n).copy_from(&v);
            z.rows_mut(2 * n, lags).copy_from(&x);
            Some(z)
        };
        let mut z = DVector::zeros(2 * n + lags);
        for (value, shape, _) in start {
            z.rows_mut(0, n).zip_apply(shape, |sum, x| *sum += x.re + x.im);
            z.rows_mut(n, n).zip_apply(shape, |sum, x| *sum += (x * value).re + (x * value).im);
        }
        let (mut space, mut shapes): (Vec<DVector<f64>>, _) = (Vec::new(), Vec::new());
        for _ in 0..KRYLOV {
            let size = z.norm();
            let Some(mut next) = solved(&z.unscale(size)) else { break };
            for _ in 0..2 {
                for known in &space {
                    next -= known * known.dot(&next);
                }
            }
            if !(next.norm() > 0.0 && next.norm().is_finite()) {
                break;
            }
            space.push(next.normalize());
            shapes.extend([next.rows(0, n).into_owned(), next.rows(n, n).into_owned()]);
            z = next;
        }
        shapes
    }

    /// Modes over a basis of shapes, each refined over all coordinates, and the eigenvalues and shapes over the basis of those that did not
    /// converge.
    fn modes_over(
        &self,
        basis: &DMatrix<f64>,
        (own, resolvent): (&[Complex<f64>], &Resolvent),
        [free, still_1_s2]: [f64; 2],
        count: usize,
    ) -> Result<(Vec<LaggedMode>, Vec<Guess>), NoModes> {
        let (values, shapes) = self.eigenvalues(basis)?;
        let mut order: Vec<usize> = (0..values.len()).filter(|&i| values[i].im >= 0.0).collect();
        order.sort_by(|&i, &j| values[i].norm().total_cmp(&values[j].norm()));
        let mut list = self.still(basis, still_1_s2);
        let mut lacking = Vec::new();
        for i in order {
            let value = values[i];
            let growing = grows(value);
            let beyond = list.len() >= count;
            if beyond && !growing {
                continue;
            }
            let nearest = own.iter().map(|own| (own - value).norm()).fold(f64::INFINITY, f64::min);
            if !growing && nearest <= OWN * value.norm() {
                continue;
            }
            if value.norm() <= free {
                // rigid-body modes are already in the list
                continue;
            }
            let shape = &Basis(basis) * &shapes[i];
            let (mode, converged) = self.polish(resolvent, value, shape.clone());
            // the highest eigenvalues over a truncated basis may grow although no mode of the model does
            if beyond && !(converged && grows(mode.eigenvalue_1_s)) {
                continue;
            }
            // lag modes of equal strips cluster about their poles and are not motions of the model
            if !converged && mode.lag_share <= LAG && nearest > CROWD * value.norm() {
                lacking.push((value, shape, mode.eigenvalue_1_s));
            }
            if mode.lag_share <= LAG || grows(mode.eigenvalue_1_s) {
                list.push(mode);
            }
        }
        list.sort_by(|a, b| a.eigenvalue_1_s.norm().total_cmp(&b.eigenvalue_1_s.norm()));
        Ok((list, lacking))
    }

    /// Rigid-body modes: the null space of the static stiffness.
    fn still(&self, basis: &DMatrix<f64>, limit_1_s2: f64) -> Vec<LaggedMode> {
        let stiffness = self.rest_stiffness().unwrap_or_else(|| self.second.stiffness.clone());
        still_over(basis, &stiffness, limit_1_s2)
    }

    /// Rigid-body modes if the aerodynamics changes the static stiffness to `rest`, and the magnitude in 1/s below which other eigenvalues
    /// count as such. Computed over more than `count` of the slowest undamped modes.
    ///
    /// # Errors
    /// If the mass matrix is not positive definite.
    pub fn still_with(&self, rest: &DMatrix<f64>, count: usize) -> Result<(Vec<LaggedMode>, f64), NoModes> {
        let (shift, basis) = self.basis(4 * count + SPARE_MODES)?;
        Ok((still_over(&basis, rest, FREE_MOTION.powi(2) * shift), free_1_s(shift)))
    }

    /// Undamped modes of lowest frequency of the structure with aerodynamic mass and stiffness, mass-normalised, as columns, and the shift
    /// that made the stiffness positive.
    fn basis(&self, most: usize) -> Result<(f64, DMatrix<f64>), NoModes> {
        let SecondOrder { mass, stiffness, .. } = &self.second;
        let (shift, root) = shifted_root(mass, stiffness, 0.0)?;
        let half = root.solve_lower_triangular(mass).ok_or(NoModes::Iteration)?;
        let whole = root.solve_lower_triangular(&half.transpose()).ok_or(NoModes::Iteration)?;
        let eigen = ((&whole + whole.transpose()) * 0.5).symmetric_eigen();
        let mut order: Vec<usize> = (0..mass.nrows()).filter(|&i| eigen.eigenvalues[i] > 0.0).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        order.truncate(most);
        let vectors = eigen.eigenvectors.select_columns(&order);
        let mut basis = root.tr_solve_lower_triangular(&vectors).ok_or(NoModes::Iteration)?;
        for (mut column, &i) in basis.column_iter_mut().zip(&order) {
            column.unscale_mut(eigen.eigenvalues[i].sqrt());
        }
        Ok((shift, basis))
    }

    /// Eigenvalues over a basis of shapes, with their vectors in that basis.
    fn eigenvalues(&self, basis: &DMatrix<f64>) -> Result<Eigenpairs, NoModes> {
        let (n, m) = (basis.ncols(), self.lag.nrows());
        let within = |matrix: &DMatrix<f64>| basis.transpose() * matrix * basis;
        let inverse = within(&self.second.mass).try_inverse().ok_or(NoModes::Mass)?;
        let mut a = DMatrix::zeros(2 * n + m, 2 * n + m);
        a.view_mut((0, n), (n, n)).fill_with_identity();
        a.view_mut((n, 0), (n, n)).copy_from(&-(&inverse * within(&self.second.stiffness)));
        a.view_mut((n, n), (n, n)).copy_from(&-(&inverse * within(&self.second.damping)));
        a.view_mut((n, 2 * n), (n, m)).copy_from(&-(&inverse * basis.transpose() * &self.force));
        a.view_mut((2 * n, 0), (m, n)).copy_from(&(&self.position * basis));
        a.view_mut((2 * n, n), (m, n)).copy_from(&(&self.rate * basis));
        a.view_mut((2 * n, 2 * n), (m, m)).copy_from(&self.lag);
        let (balanced, scale) = balanced_rows(&a);
        let found = eigen(&balanced).ok_or(NoModes::Iteration)?;
        let shape = |i: usize| {
            let pair = found.values[i].im > 0.0;
            let part = |k: usize, column: usize| found.vectors[(k, column)] * scale[k];
            DVector::from_fn(n, |k, _| Complex::new(part(k, i), if pair { part(k, i + 1) } else { 0.0 }))
        };
        let shapes = (0..found.values.len())
            .map(|i| if found.values[i].im < 0.0 { DVector::zeros(n) } else { shape(i) })
            .collect();
        Ok((found.values, shapes))
    }

    /// Refines a mode over all coordinates: its shape by inverse iteration, its eigenvalue by the two-sided Rayleigh functional of `T(λ) =
    /// λ²M + λC + K + G(λ − L)⁻¹(P + λR)`, and the participation of the lag states from `T′`.
    ///
    /// Also returns whether the iteration converged.
    fn polish(&self, resolvent: &Resolvent, value: Complex<f64>, shape: DVector<Complex<f64>>) -> (LaggedMode, bool) {
        let (mut eigenvalue, mut right) = (value, shape);
        let mut left = right.clone();
        let (mut lag_share, mut converged) = (1.0, false);
        for pass in 0..8 {
            let near = eigenvalue * (1.0 + 1e-9);
            let follow = self.follow(resolvent, near);
            let SecondOrder { mass, damping, stiffness } = &self.second;
            let through = &self.force.map(|x| Complex::new(x, 0.0)) * &follow;
            let entry = |i: usize, j: usize| {
                near * near * mass[(i, j)] + near * damping[(i, j)] + stiffness[(i, j)] + through[(i, j)]
            };
            let factors = ComplexFactors::new(mass.nrows(), entry);
            for _ in 0..2 {
                let (x, y) = (factors.solve(&right), factors.solve_adjoint(&left));
                let (x_size, y_size) = (x.norm(), y.norm());
                if !(x_size.is_finite() && y_size.is_finite() && x_size > 0.0 && y_size > 0.0) {
                    break;
                }
                (right, left) = (x / Complex::new(x_size, 0.0), y / Complex::new(y_size, 0.0));
            }
            let (residual, slope, lag_part) = self.forms(resolvent, eigenvalue, &left, &right);
            lag_share = (lag_part / slope).norm();
            let step = residual / slope;
            if !step.norm().is_finite() || step.norm() >= 0.1 * eigenvalue.norm() {
                break;
            }
            eigenvalue -= step;
            if pass > 0 && step.norm() < CLOSE * eigenvalue.norm() {
                converged = true;
                break;
            }
        }
        // a real eigenvalue remains real
        if value.im == 0.0 {
            eigenvalue.im = 0.0;
        }
        (LaggedMode { eigenvalue_1_s: eigenvalue, shape: scaled(right), lag_share }, converged)
    }

    /// Response of the lag states, `(λ − L)⁻¹(P + λR)`.
    fn follow(&self, resolvent: &Resolvent, at: Complex<f64>) -> DMatrix<Complex<f64>> {
        let drive = DMatrix::from_fn(self.position.nrows(), self.position.ncols(), |i, j| {
            at * self.rate[(i, j)] + self.position[(i, j)]
        });
        resolvent.behind(at, drive)
    }

    /// The forms `yᴴTx` and `yᴴT′x`, and the contribution of the lag states to the latter.
    fn forms(
        &self,
        resolvent: &Resolvent,
        at: Complex<f64>,
        left: &DVector<Complex<f64>>,
        right: &DVector<Complex<f64>>,
    ) -> (Complex<f64>, Complex<f64>, Complex<f64>) {
        let complex = |matrix: &DMatrix<f64>| matrix.map(|x| Complex::new(x, 0.0));
        let form = |matrix: &DMatrix<f64>| left.dotc(&(complex(matrix) * right));
        let SecondOrder { mass, damping, stiffness } = &self.second;
        let (m, c, k) = (form(mass), form(damping), form(stiffness));
        let column = |vector: DVector<Complex<f64>>| DMatrix::from_column_slice(vector.len(), 1, vector.as_slice());
        let rates = complex(&self.rate) * right;
        let drive = complex(&self.position) * right + &rates * at;
        let followers = resolvent.behind(at, column(drive));
        let force = complex(&self.force);
        let of = |columns: &DMatrix<Complex<f64>>| left.dotc(&(&force * columns).column(0).into_owned());
        let lag_part = -of(&resolvent.behind(at, followers.clone()));
        let residual = at * at * m + at * c + k + of(&followers);
        let slope = at * m * 2.0 + c + of(&resolvent.behind(at, column(rates))) + lag_part;
        (residual, slope, lag_part)
    }
}

/// The null space of a stiffness over a basis of shapes.
fn still_over(basis: &DMatrix<f64>, stiffness: &DMatrix<f64>, limit_1_s2: f64) -> Vec<LaggedMode> {
    let parts = (basis.transpose() * stiffness * basis).svd(false, true);
    let Some(rows) = parts.v_t else { return Vec::new() };
    let null = (0..rows.nrows()).filter(|&i| parts.singular_values[i] <= limit_1_s2);
    let mode = |i: usize| {
        let shape = (basis * rows.row(i).transpose()).map(|x| Complex::new(x, 0.0));
        LaggedMode { eigenvalue_1_s: Complex::new(0.0, 0.0), shape: scaled(shape), lag_share: 0.0 }
    };
    null.map(mode).collect()
}

/// Adds directions to a mass-orthonormal basis; returns whether any was linearly independent.
fn extend(basis: &mut DMatrix<f64>, directions: &[DVector<f64>], mass: &DMatrix<f64>) -> bool {
    let before = basis.ncols();
    for direction in directions {
        let size = direction.dot(&(mass * direction)).sqrt();
        if !(size.is_finite() && size > 0.0) {
            continue;
        }
        let mut part = direction / size;
        for _ in 0..2 {
            let along = basis.transpose() * (mass * &part);
            part -= &*basis * along;
        }
        let left = part.dot(&(mass * &part)).sqrt();
        if left > NEW && basis.ncols() < basis.nrows() {
            let last = basis.ncols();
            *basis = std::mem::replace(basis, DMatrix::zeros(0, 0)).insert_column(last, 0.0);
            basis.set_column(last, &(part / left));
        }
    }
    basis.ncols() > before
}

/// The shape scaled so that its largest entry is 1.
fn scaled(shape: DVector<Complex<f64>>) -> DVector<Complex<f64>> {
    let largest = shape.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap_or_default();
    if largest.norm() > 0.0 { shape / largest } else { shape }
}

impl std::ops::Mul<&DVector<Complex<f64>>> for &Basis<'_> {
    type Output = DVector<Complex<f64>>;

    fn mul(self, shape: &DVector<Complex<f64>>) -> Self::Output {
        let [re, im] = [shape.map(|x| x.re), shape.map(|x| x.im)].map(|part| self.0 * part);
        DVector::from_fn(re.len(), |i, _| Complex::new(re[i], im[i]))
    }
}

/// A real basis for complex shapes.
struct Basis<'a>(&'a DMatrix<f64>);
