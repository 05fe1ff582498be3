//! Scales of inputs and outputs for reductions, and the error of a reduced model by frequency, NOTATION eqs. (L19) and (L37).

use nalgebra::{Complex, DMatrix};

/// Number of iterations of the scales: each at least halves the remaining error.
const ROUNDS: usize = 200;
/// Number of iterations in which the largest gains are scaled to 1.
const LEVELS: usize = 10;
/// Gain on balanced scales below which an output does not respond to an input: round-off.
const NO_RESPONSE: f64 = 1e-8;

/// A mode of the whole model that the reduced model lacks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dropped {
    /// Eigenvalue of the mode in 1/s.
    pub eigenvalue_1_s: Complex<f64>,
    /// Largest gain of the mode divided by the largest gain of the whole model in the range, for the input and output with the largest
    /// ratio.
    pub share: f64,
}

/// Error of a reduced model in a range of frequencies.
#[derive(Debug, Clone, PartialEq)]
pub struct Accuracy {
    /// End of the range in Hz, which starts at 0.
    pub up_to_hz: f64,
    /// Largest error in the range divided by the largest gain in it, for each output (rows) and each input (columns); 0 if an output does
    /// not respond.
    pub error: DMatrix<f64>,
    /// Frequency in Hz of the largest relative error.
    pub worst_hz: f64,
    /// Omitted modes in the range with a relative gain above [`Accuracy::SEEN`], slowest first. Not computed in discrete time.
    pub dropped: Vec<Dropped>,
}

impl Accuracy {
    /// Fraction of the largest gain above which an omitted mode is listed.
    pub const SEEN: f64 = 0.01;

    /// The largest error, with its output and input; 0 if there are no inputs or outputs.
    pub fn worst(&self) -> (f64, [usize; 2]) {
        let mut worst = (0.0, [0, 0]);
        for i in 0..self.error.nrows() {
            for j in 0..self.error.ncols() {
                if self.error[(i, j)] > worst.0 {
                    worst = (self.error[(i, j)], [i, j]);
                }
            }
        }
        worst
    }
}

/// Largest gains and errors over frequencies, added one by one.
pub(super) struct Measure {
    gain: DMatrix<f64>,
    error: DMatrix<f64>,
    at_hz: DMatrix<f64>,
}

impl Measure {
    pub fn new(outputs: usize, inputs: usize) -> Self {
        let none = DMatrix::zeros(outputs, inputs);
        Self { gain: none.clone(), error: none.clone(), at_hz: none }
    }

    /// Adds the gains of the whole model at a frequency, and the error of the reduced model.
    pub fn add(&mut self, frequency_hz: f64, gain: &DMatrix<Complex<f64>>, error: &DMatrix<Complex<f64>>) {
        for i in 0..gain.nrows() {
            for j in 0..gain.ncols() {
                self.gain[(i, j)] = self.gain[(i, j)].max(gain[(i, j)].norm());
                let off = error[(i, j)].norm();
                if off > self.error[(i, j)] {
                    (self.error[(i, j)], self.at_hz[(i, j)]) = (off, frequency_hz);
                }
            }
        }
    }

    /// Largest gain for each pair of output and input.
    pub fn gains(&self) -> &DMatrix<f64> {
        &self.gain
    }

    /// Relative errors up to a frequency. `beside` is an additional error of each pair.
    pub fn accuracy(&self, up_to_hz: f64, beside: f64, dropped: Vec<Dropped>) -> Accuracy {
        let responds = responding(&self.gain);
        let error = DMatrix::from_fn(self.gain.nrows(), self.gain.ncols(), |i, j| {
            if responds[(i, j)] { (self.error[(i, j)] + beside) / self.gain[(i, j)] } else { 0.0 }
        });
        let mut accuracy = Accuracy { up_to_hz, error, worst_hz: 0.0, dropped };
        if let (1.., [i, j]) = (self.gain.len(), accuracy.worst().1) {
            accuracy.worst_hz = self.at_hz[(i, j)];
        }
        accuracy
    }
}

/// Pairs of outputs and inputs with a response, independent of their units.
pub(super) fn responding(gains: &DMatrix<f64>) -> DMatrix<bool> {
    let [inputs, outputs] = even_scales(gains);
    DMatrix::from_fn(gains.nrows(), gains.ncols(), |i, j| {
        gains[(i, j)] > 0.0 && gains[(i, j)] * outputs[i] * inputs[j] > NO_RESPONSE
    })
}

/// Factors of inputs and outputs that scale the geometric means of the gains of each to 1: the least-squares solution in the logarithms,
/// where units only add constants. Pairs without a response, relative to the others of the same output and input, are ignored.
pub(super) fn even_scales(gains: &DMatrix<f64>) -> [Vec<f64>; 2] {
    let logarithm = gains.map(f64::ln);
    let any = gains.map(|gain| gain > 0.0 && gain.is_finite());
    let mean = |terms: &[f64]| if terms.is_empty() { 0.0 } else { terms.iter().sum::<f64>() / terms.len() as f64 };
    let largest = |terms: &[f64]| terms.iter().copied().reduce(f64::max).unwrap_or(0.0);
    let settled =
        |[mut inputs, mut outputs]: [Vec<f64>; 2], counts: &DMatrix<bool>, rounds, level: &dyn Fn(&[f64]) -> f64| {
            for _ in 0..rounds {
                for (i, own) in outputs.iter_mut().enumerate() {
                    let counted = (0..gains.ncols()).filter(|&j| counts[(i, j)]);
                    *own = -level(&counted.map(|j| logarithm[(i, j)] + inputs[j]).collect::<Vec<_>>());
                }
                for (j, own) in inputs.iter_mut().enumerate() {
                    let counted = (0..gains.nrows()).filter(|&i| counts[(i, j)]);
                    *own = -level(&counted.map(|i| logarithm[(i, j)] + outputs[i]).collect::<Vec<_>>());
                }
            }
            [inputs, outputs]
        };
    // from mean gains, which scale with the units, to scales on which the largest gain of each is 1, where round-off is recognisable
    let begin = settled([vec![0.0; gains.ncols()], vec![0.0; gains.nrows()]], &any, ROUNDS, &mean);
    let [inputs, outputs] = settled(begin.clone(), &any, LEVELS, &largest);
    let counts = DMatrix::from_fn(gains.nrows(), gains.ncols(), |i, j| {
        any[(i, j)] && logarithm[(i, j)] + outputs[i] + inputs[j] > NO_RESPONSE.ln()
    });
    settled(begin, &counts, ROUNDS, &mean).map(|list| list.into_iter().map(f64::exp).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Scales follow the units exactly, and round-off between signals that do not respond has no effect on them.
    #[test]
    fn scales_follow_units() {
        let gains = DMatrix::from_row_slice(3, 2, &[3.0, 0.2, 50.0, 0.0, 7e-3, 1.1]);
        let [inputs, outputs] = even_scales(&gains);
        let units = ([1e6, 1.0], [1.0, 1e-9, 300.0]);
        let other = DMatrix::from_fn(3, 2, |i, j| gains[(i, j)] * units.0[j] * units.1[i]);
        let [own_inputs, own_outputs] = even_scales(&other);
        for i in 0..3 {
            for j in 0..2 {
                let expected = inputs[j] * outputs[i] / (units.0[j] * units.1[i]);
                approx::assert_relative_eq!(own_inputs[j] * own_outputs[i], expected, max_relative = 1e-12);
            }
        }
        let mut noisy = gains.clone();
        noisy[(1, 1)] = 1e-14;
        let [noisy_inputs, noisy_outputs] = even_scales(&noisy);
        approx::assert_relative_eq!(noisy_inputs[1] * noisy_outputs[2], inputs[1] * outputs[2], max_relative = 1e-12);
        assert!(!responding(&noisy)[(1, 1)] && responding(&noisy)[(2, 0)]);
    }
}
