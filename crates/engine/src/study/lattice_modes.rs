//! Modes of a machine in the air of a lattice, NOTATION eq. (L30): the rows of the wake are delays, so the eigenvalues of the
//! discrete-time system are those of a small matrix that depends on the eigenvalue.

use crate::solve::lagged::{Lagged, LaggedMode};
use crate::solve::linearize::SecondOrder;
use crate::solve::modes::NoModes;
use crate::study::Study;
use crate::study::flight::tell_lateral_apart;
use crate::study::lattice_space::SampledLattice;
use crate::study::linear::determinant_is_positive;
use crate::system::PlantError;
use crate::system::air::VELOCITY_WEIGHTS;
use crate::system::shape::ModeShape;
use nalgebra::{Complex, DMatrix, DVector};

type ComplexMatrix = DMatrix<Complex<f64>>;
type ComplexVector = DVector<Complex<f64>>;

/// Maximum number of corrections of an eigenvalue.
const CORRECTIONS: usize = 30;
/// Correction of an eigenvalue, relative to its distance from 1, below which it has converged.
const FOUND: f64 = 1e-11;
/// Relative difference below which two eigenvalues are one.
const SAME: f64 = 1e-6;
/// Step of the derivative by the eigenvalue.
const STEP: f64 = 1e-6;

/// Ratio of the frequencies at which the air is looked at to find where modes are.
const OCTAVE: f64 = 2.0;
/// Ratio of the magnitude of an eigenvalue to such a frequency within which it is a guess: more than half an octave, so that none is
/// between them.
const WINDOW: f64 = 1.6;
/// Such frequencies, from that of the fastest mode of the structure that is looked for.
const OCTAVES: i32 = 12;
/// Frequency over the magnitude of the eigenvalue below which a motion that decays counts as one of the lags of the air: 95 % of critical damping.
const LIGHTEST: f64 = 0.31;

/// `z` and a shape, coordinates and rates.
type Guess = (Complex<f64>, ComplexVector);

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
        let mut node = ComplexMatrix::zeros(slopes.rows(), if slopes.node_rows() > 0 { edges } else { 0 });
        let mut gone = one;
        for row in 0..slopes.node_rows() {
            gone *= back;
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

    /// `z − E + z H Φ(z)`.
    fn matrix(&self, z: Complex<f64>) -> Option<ComplexMatrix> {
        let n = self.pushed.nrows() / 2;
        let mut matrix = self.system.held.free.map(|entry| Complex::from(-entry));
        (0..2 * n).for_each(|i| matrix[(i, i)] += z);
        let loads = self.loads(z)?;
        let air = self.pushed.map(Complex::from) * loads;
        let mut own = matrix.columns_mut(0, n);
        own += air * z;
        Some(matrix)
    }

    /// The mode next to one of a machine in air that answers at a frequency near by as at it; `None` if there is none.
    fn near(&self, mode: &LaggedMode) -> Option<LaggedMode> {
        let found = self.named(self.corrected(self.guess(mode))?)?;
        let ratio = found.eigenvalue_1_s.norm() / mode.eigenvalue_1_s.norm();
        let is_motion =
            found.eigenvalue_1_s.re > 0.0 || found.eigenvalue_1_s.im > LIGHTEST * found.eigenvalue_1_s.norm();
        (is_motion && ratio < OCTAVE && ratio > OCTAVE.recip()).then_some(found)
    }

    /// Modes of the structure with stiffness and damping that the air has at a frequency, which have about that frequency: the
    /// p-k method (Hassig, Journal of Aircraft 8, 1971).
    fn at_frequency(&self, rad_s: f64, count: usize) -> Result<Vec<LaggedMode>, NoModes> {
        let SampledLattice { second, force, step_s, .. } = self.system;
        let Some(loads) = self.loads(Complex::new(0.0, rad_s * step_s).exp()) else { return Ok(Vec::new()) };
        let in_air = SecondOrder {
            stiffness: &second.stiffness + force * loads.map(|entry| entry.re),
            damping: &second.damping + force * loads.map(|entry| entry.im / rad_s),
            ..second.clone()
        };
        let mut list = Lagged::without(in_air).modes(count)?;
        list.retain(|mode| {
            let size = mode.eigenvalue_1_s.norm();
            mode.eigenvalue_1_s.im > LIGHTEST * size && size < WINDOW * rad_s && size > rad_s / WINDOW
        });
        Ok(list)
    }

    /// `z` and shape, coordinates and rates, of a mode.
    fn guess(&self, mode: &LaggedMode) -> Guess {
        let n = self.pushed.nrows() / 2;
        let entry = |i: usize| if i < n { mode.shape[i] } else { mode.shape[i - n] * mode.eigenvalue_1_s };
        ((mode.eigenvalue_1_s * self.system.step_s).exp(), ComplexVector::from_fn(2 * n, |i, _| entry(i)))
    }

    /// The eigenvalue next to a guess, and its shape, by inverse iteration and the two-sided Rayleigh functional; `None` where the
    /// iteration does not end.
    fn corrected(&self, (mut z, mut right): Guess) -> Option<Guess> {
        let mut left: Option<ComplexVector> = None;
        for _ in 0..CORRECTIONS {
            let matrix = self.matrix(z)?;
            let slope = (self.matrix(z * (1.0 + STEP))? - &matrix).map(|entry| entry / (z * STEP));
            let factors = matrix.clone().lu();
            let adjoint = matrix.adjoint().lu();
            let own = left.clone().unwrap_or_else(|| right.clone());
            // exactly singular: the eigenvalue to the last digit
            let (Some(x), Some(y)) = (factors.solve(&(&slope * &right)), adjoint.solve(&own)) else {
                return z.is_finite().then_some((z, right));
            };
            let (x_size, y_size) = (x.norm(), y.norm());
            if !(x_size.is_finite() && y_size.is_finite() && x_size > 0.0 && y_size > 0.0) {
                return z.is_finite().then_some((z, right));
            }
            right = x / Complex::from(x_size);
            let y = y / Complex::from(y_size);
            let change = y.dotc(&(&matrix * &right)) / y.dotc(&(&slope * &right));
            left = Some(y);
            z -= change;
            if change.norm() <= FOUND * (z - 1.0).norm().max(STEP) {
                return z.is_finite().then_some((z, right));
            }
        }
        None
    }

    /// The mode of an eigenvalue, of a pair that with positive imaginary part.
    fn named(&self, (z, right): Guess) -> Option<LaggedMode> {
        let n = self.pushed.nrows() / 2;
        let eigenvalue_1_s = z.ln() / self.system.step_s;
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
    /// Modes of lowest frequency in the air of a lattice about the present state of rest that swing, and the sign of the determinant
    /// of the static stiffness in the established flow; `None` if it is singular. Where modes are is guessed from the air at frequencies
    /// an octave apart, so that those are found too which have no frequency without air, as that of a hinge that swings freely.
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
        let bare = Lagged::without(second.clone()).modes(count).map_err(|error| cause(&error.to_string()))?;
        let mut list: Vec<LaggedMode> = Vec::new();
        let nyquist_rad_s = std::f64::consts::PI / system.step_s;
        let fastest_rad_s = bare.iter().map(|mode| mode.eigenvalue_1_s.norm()).fold(0.0, f64::max).min(nyquist_rad_s);
        for octave in 0..if fastest_rad_s > 0.0 { OCTAVES } else { 0 } {
            let guesses = delays.at_frequency(fastest_rad_s / OCTAVE.powi(octave), count);
            let guesses = guesses.map_err(|error| cause(&error.to_string()))?;
            for found in guesses.iter().filter_map(|mode| delays.near(mode)) {
                let same = |other: &LaggedMode| {
                    (other.eigenvalue_1_s - found.eigenvalue_1_s).norm() < SAME * found.eigenvalue_1_s.norm()
                };
                if found.eigenvalue_1_s.norm() < nyquist_rad_s && !list.iter().any(same) {
                    list.push(found);
                }
            }
        }
        list.sort_by(|a, b| a.eigenvalue_1_s.norm().total_cmp(&b.eigenvalue_1_s.norm()));
        let at_rest = delays.loads(Complex::from(1.0)).map(|loads| loads.map(|entry| entry.re));
        let sign = at_rest.and_then(|loads| {
            let SecondOrder { stiffness, .. } = &second;
            determinant_is_positive(&(stiffness + &system.force * loads))
        });
        let freedoms = self.system.freedoms();
        let mut shapes: Vec<ModeShape> = list.into_iter().map(|mode| self.mode_shape(mode, &freedoms)).collect();
        tell_lateral_apart(&mut shapes);
        Ok((shapes, sign))
    }
}
