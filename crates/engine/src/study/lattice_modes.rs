//! Modes of a machine in the air of a lattice, NOTATION eq. (L30): the rows of the wake are delays, so the eigenvalues of the
//! discrete-time system are those of a small matrix that depends on the eigenvalue.

use crate::solve::lagged::{Lagged, LaggedMode};
use crate::solve::linearize::SecondOrder;
use crate::study::Study;
use crate::study::lattice_space::SampledLattice;
use crate::study::linear::determinant_is_positive;
use crate::system::PlantError;
use crate::system::air::VELOCITY_WEIGHTS;
use crate::system::shape::ModeShape;
use nalgebra::{Complex, DMatrix, DVector};

type ComplexMatrix = DMatrix<Complex<f64>>;
type ComplexVector = DVector<Complex<f64>>;

/// Steps in which the share of the air grows from 0 to 1 while a mode is followed.
const SHARES: usize = 16;
/// Maximum number of corrections of an eigenvalue at each share.
const CORRECTIONS: usize = 30;
/// Correction of an eigenvalue, relative to its distance from 1, below which it has converged.
const FOUND: f64 = 1e-11;
/// Relative difference below which two eigenvalues are one.
const SAME: f64 = 1e-6;
/// Step of the derivative by the eigenvalue.
const STEP: f64 = 1e-6;

/// The nonlinear eigenvalue problem.
struct Delays<'a> {
    system: &'a SampledLattice,
    /// Derivative of coordinates and rates at the end of the step by the loads of the step.
    pushed: DMatrix<f64>,
}

impl Delays<'_> {
    /// Loads of the step that ends, per coordinate, for motions that grow by the factor `z` per step.
    fn loads(&self, z: Complex<f64>) -> Option<ComplexMatrix> {
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
        let left = motion.rows(slopes.edge_row(), edges).into_owned();
        let mut gone = one;
        for row in 0..slopes.node_rows() {
            gone *= back;
            motion += slopes.node.columns(row * edges, edges).map(|entry| gone * entry) * &left;
        }
        let strips = slopes.trailing.len();
        let mut wake = ComplexMatrix::zeros(slopes.rows(), strips);
        let mut delay = one;
        for row in 0..slopes.wake_rows {
            delay *= back;
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

    /// `z − E + z H Φ(z)` with a share of the air.
    fn matrix(&self, z: Complex<f64>, share: f64) -> Option<ComplexMatrix> {
        let n = self.pushed.nrows() / 2;
        let mut matrix = self.system.held.free.map(|entry| Complex::from(-entry));
        (0..2 * n).for_each(|i| matrix[(i, i)] += z);
        let loads = self.loads(z)?;
        let air = self.pushed.map(Complex::from) * loads;
        let mut own = matrix.columns_mut(0, n);
        own += air * (z * share);
        Some(matrix)
    }

    /// Follows a mode from the structure alone; `None` where it is lost.
    fn follow(&self, mode: &LaggedMode) -> Option<LaggedMode> {
        let step_s = self.system.step_s;
        let n = self.pushed.nrows() / 2;
        let mut z = (mode.eigenvalue_1_s * step_s).exp();
        let mut right =
            ComplexVector::from_fn(
                2 * n,
                |i, _| {
                    if i < n { mode.shape[i] } else { mode.shape[i - n] * mode.eigenvalue_1_s }
                },
            );
        for part in 0..=SHARES {
            let share = part as f64 / SHARES as f64;
            let mut left: Option<ComplexVector> = None;
            let mut found = false;
            for _ in 0..CORRECTIONS {
                let matrix = self.matrix(z, share)?;
                let near = self.matrix(z * (1.0 + STEP * 0.5), share)? - self.matrix(z * (1.0 - STEP * 0.5), share)?;
                let slope = near.map(|entry| entry / (z * STEP));
                let factors = matrix.clone().lu();
                let adjoint = matrix.adjoint().lu();
                let own = left.clone().unwrap_or_else(|| right.clone());
                let (Some(x), Some(y)) = (factors.solve(&(&slope * &right)), adjoint.solve(&own)) else {
                    // exactly singular: the eigenvalue to the last digit
                    found = true;
                    break;
                };
                let (x_size, y_size) = (x.norm(), y.norm());
                if !(x_size.is_finite() && y_size.is_finite() && x_size > 0.0 && y_size > 0.0) {
                    found = true;
                    break;
                }
                right = x / Complex::from(x_size);
                let y = y / Complex::from(y_size);
                let change = y.dotc(&(&matrix * &right)) / y.dotc(&(&slope * &right));
                left = Some(y);
                z -= change;
                if change.norm() <= FOUND * (z - 1.0).norm().max(STEP) {
                    found = true;
                    break;
                }
            }
            if !found || !z.is_finite() {
                return None;
            }
        }
        let eigenvalue_1_s = z.ln() / step_s;
        let shape = right.rows(0, n).into_owned();
        let largest = shape.iter().copied().max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
        if eigenvalue_1_s.im < 0.0 {
            let shape = (shape / largest).map(|entry| entry.conj());
            return Some(LaggedMode { eigenvalue_1_s: eigenvalue_1_s.conj(), shape, lag_share: 0.0 });
        }
        Some(LaggedMode { eigenvalue_1_s, shape: shape / largest, lag_share: 0.0 })
    }
}

impl Study<'_> {
    /// Modes of lowest frequency in the air of a lattice about the present state of rest, and the sign of the determinant of the static
    /// stiffness in the established flow; `None` if it is singular. Each mode is followed from the structure under constant loads to
    /// the full air; modes that are lost on the way are left out.
    ///
    /// # Errors
    /// As [`Study::lattice_space`].
    pub fn lattice_modes_and_rest(&mut self, count: usize) -> Result<(Vec<ModeShape>, Option<bool>), PlantError> {
        let system = self.sampled_lattice(false)?;
        let cause = |cause: &str| PlantError::Linearization { time_s: 0.0, cause: cause.into() };
        let pushed = &system.held.by_force * &system.force;
        let delays = Delays { system: &system, pushed };
        let second = system.second.clone();
        let bare = Lagged::without(second.clone()).modes(count).map_err(|error| cause(&error.to_string()))?;
        let mut list: Vec<LaggedMode> = Vec::new();
        let nyquist_rad_s = std::f64::consts::PI / system.step_s;
        for mode in bare.iter().filter(|mode| mode.eigenvalue_1_s.norm() < nyquist_rad_s) {
            let Some(found) = delays.follow(mode) else { continue };
            let same = |other: &LaggedMode| {
                (other.eigenvalue_1_s - found.eigenvalue_1_s).norm() < SAME * found.eigenvalue_1_s.norm()
            };
            if !list.iter().any(same) {
                list.push(found);
            }
        }
        list.sort_by(|a, b| a.eigenvalue_1_s.norm().total_cmp(&b.eigenvalue_1_s.norm()));
        let at_rest = delays.loads(Complex::from(1.0)).map(|loads| loads.map(|entry| entry.re));
        let sign = at_rest.and_then(|loads| {
            let SecondOrder { stiffness, .. } = &second;
            determinant_is_positive(&(stiffness + &system.force * loads))
        });
        let freedoms = self.system.freedoms();
        Ok((list.into_iter().map(|mode| self.mode_shape(mode, &freedoms)).collect(), sign))
    }
}
