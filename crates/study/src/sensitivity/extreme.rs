//! Instants of largest values, at which the output's rate along the discrete run is zero.

use crate::sensitivity::error::QuantityError;
use crate::sensitivity::quantity::Extreme;
use foldwing_engine::plant::{Gradient, GradientError, Plant, Tape};

/// Minimum number of intervals at whose ends outputs are sampled to find their largest values.
const SAMPLES: usize = 2_000;
/// Minimum number of these intervals per step of the run: a motion that the steps resolve is then sampled some hundred times per cycle at
/// the default tolerance.
const PER_STEP: usize = 4;
/// Maximum number of runs that refine an instant.
const CORRECTIONS: usize = 40;
/// Maximum number of samples between the largest one and an end of the bracket of its instant.
const WIDEST: usize = 5;
/// Rate at which an instant counts as found, as a fraction of the output's range divided by the sampling interval.
const FLAT: f64 = 1e-9;
/// Width of a bracket, as a fraction of the run, below which no further runs are needed.
const NARROW: f64 = 1e-12;

/// Samples of the outputs of a run.
pub(super) struct Samples {
    times_s: Vec<f64>,
    values: Vec<Vec<f64>>,
}

impl Samples {
    /// Samples the outputs with these `indices` of a recorded run.
    pub fn of(
        plant: &mut Plant,
        tape: &Tape,
        indices: &[usize],
        (start_s, stop_s): (f64, f64),
    ) -> Result<Self, GradientError> {
        let intervals = SAMPLES.max(tape.steps().saturating_mul(PER_STEP));
        let mut samples = Self { times_s: Vec::new(), values: vec![Vec::new(); indices.len()] };
        if indices.is_empty() {
            return Ok(samples);
        }
        for point in 0..=intervals {
            let share = point as f64 / intervals as f64;
            let time_s = if point == intervals { stop_s } else { start_s + share * (stop_s - start_s) };
            let outputs = plant.outputs_on_tape(tape, time_s)?;
            samples.times_s.push(time_s);
            for (values, index) in samples.values.iter_mut().zip(indices) {
                values.push(outputs[*index]);
            }
        }
        Ok(samples)
    }

    /// The instant of the largest value of an output: start, stop, or found from rates of runs that end a step there.
    pub fn instant(
        &self,
        (plant, tape): (&mut Plant, &mut Tape),
        (place, index): (usize, usize),
        kind: Extreme,
    ) -> Result<Result<f64, QuantityError>, GradientError> {
        match self.flat_instant((plant, tape), (place, index), kind) {
            // the requested instant is that of an event
            Err(GradientError::Simultaneous { time_s, .. }) => Ok(Err(QuantityError::Corner { time_s })),
            outcome => outcome,
        }
    }

    fn flat_instant(
        &self,
        (plant, tape): (&mut Plant, &mut Tape),
        (place, index): (usize, usize),
        kind: Extreme,
    ) -> Result<Result<f64, QuantityError>, GradientError> {
        let values = &self.values[place];
        let sizes = || values.iter().map(|value| kind.size(*value));
        let best = highest(values, kind);
        let last = values.len() - 1;
        let range = sizes().fold(f64::NEG_INFINITY, f64::max) - sizes().fold(f64::INFINITY, f64::min);
        if best == 0 || best == last || range == 0.0 {
            return Ok(Ok(self.times_s[best]));
        }
        // the output keeps this value to the end, like the angle of a joint held by its rigid latch
        if values[best] == values[last] {
            return Ok(Ok(self.times_s[last]));
        }
        let (start_s, spacing_s) = (self.times_s[0], self.times_s[1] - self.times_s[0]);
        // sign of the rate of the size, which is positive before the largest value and negative after it
        let sign = if kind.size(1.0) * values[best] < 0.0 && kind == Extreme::Peak { -1.0 } else { kind.size(1.0) };
        let jumps_s: Vec<f64> = tape.jumps_s().collect();
        let mut rate = |time_s: f64| -> Result<f64, GradientError> {
            let time = plant.request(tape, time_s)?;
            Ok(sign * Gradient::new(plant, tape, Vec::new())?.rate(index, time)?)
        };
        // at a requested time the state is that of a separate step, not of the interpolation that was sampled: the bracket may be a few
        // samples wider
        let (mut from, mut to) = (self.times_s[best], self.times_s[best]);
        let (mut rate_from, mut rate_to) = (f64::NAN, f64::NAN);
        for width in 1..=WIDEST {
            if rate_from.is_nan() || rate_from <= 0.0 {
                from = self.times_s[best.saturating_sub(width).max(1)];
                rate_from = rate(from)?;
            }
            if rate_to.is_nan() || rate_to >= 0.0 {
                to = self.times_s[(best + width).min(last)];
                rate_to = rate(to)?;
            }
            if rate_from > 0.0 && rate_to < 0.0 {
                break;
            }
        }
        let (scale, span_s) = (range / spacing_s, self.times_s[last] - start_s);
        let mut found = (self.times_s[best], f64::INFINITY);
        for trial in 0..CORRECTIONS {
            // secant steps between the ends of a bracket, and every third time its middle: the rate may jump between two steps of the run
            let time_s = match trial % 3 {
                2 => 0.5 * (from + to),
                _ => (from * rate_to - to * rate_from) / (rate_to - rate_from),
            };
            if !(rate_from > 0.0 && rate_to < 0.0) || to - from <= NARROW * span_s {
                break;
            }
            let there = rate(time_s)?;
            if there.abs() < found.1 {
                found = (time_s, there.abs());
            }
            if there.abs() <= FLAT * scale {
                break;
            }
            match there > 0.0 {
                true => (from, rate_from) = (time_s, there),
                false => (to, rate_to) = (time_s, there),
            }
        }
        let (time_s, left) = found;
        let event = || jumps_s.iter().any(|jump_s| (from..=to).contains(jump_s));
        Ok(if left > FLAT * scale && event() { Err(QuantityError::Corner { time_s }) } else { Ok(time_s) })
    }
}

/// The sample next to the highest crest, which may not be the highest sample: a smaller cycle may be sampled closer to its crest.
fn highest(values: &[f64], kind: Extreme) -> usize {
    let crests = (0..values.len()).map(|point| (point, crest(values, point, kind)));
    crests.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(point, _)| point)
}

/// Size of an output at a sample; if it is larger than at the neighbours, that at the vertex of the parabola through the three.
fn crest(values: &[f64], point: usize, kind: Extreme) -> f64 {
    let size = |point: usize| kind.size(values[point]);
    let own = size(point);
    if point == 0 || point + 1 == values.len() || size(point - 1) >= own || size(point + 1) > own {
        return own;
    }
    let (before, behind) = (size(point - 1), size(point + 1));
    own + (behind - before).powi(2) / (8.0 * (2.0 * own - before - behind))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two cycles of 20 samples: the crest of the first, 1, lies in the middle between two samples, that of the second, 0.995, on one, which
    /// is the largest sample.
    #[test]
    fn a_cycle_is_judged_by_its_crest() {
        let sample = |point: usize| {
            let (amplitude, phase) = if point < 20 { (1.0, 9.5) } else { (0.995, 30.0) };
            amplitude * (std::f64::consts::PI / 10.0 * (point as f64 - phase)).cos()
        };
        let values: Vec<f64> = (0..40).map(sample).collect();
        let least: Vec<f64> = values.iter().map(|value| -value).collect();
        assert!(values[30] > values[9] && values[9] < 0.99, "the largest sample is one of the second cycle");
        let found =
            [highest(&values, Extreme::Maximum), highest(&least, Extreme::Minimum), highest(&least, Extreme::Peak)];
        assert!(found.iter().all(|point| [9, 10].contains(point)), "{found:?}");
    }
}
