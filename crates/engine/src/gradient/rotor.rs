//! Loads and coefficients of rotors as results, eq. (X41): between the ends of an aerodynamic step they are linear in time, with values that
//! the memories at both ends contain.

use crate::gradient::air::AirStep;
use crate::gradient::integrand::Mean;
use crate::gradient::mean::points;
use crate::gradient::outputs::values;
use crate::gradient::tape::Mark;
use crate::gradient::{Gradient, RunResult, add};
use crate::system::RotorLoads;
use std::ops::Range;

/// Slopes of a result with respect to a number of the memories of an aerodynamic step.
#[derive(Debug, Clone, Copy)]
pub(super) struct MemoryShares {
    /// Place of the number in a memory.
    pub place: usize,
    /// By the memory at the start of the step and by that at its end.
    pub shares: [f64; 2],
}

impl MemoryShares {
    /// Adds the variations of the result to a row, for those of the memories at both ends.
    pub fn add_to(&self, row: &mut [f64], memories: [&[Vec<f64>]; 2]) {
        for (memories, share) in memories.into_iter().zip(self.shares) {
            let of: Vec<f64> = memories.iter().map(|memory| memory[self.place]).collect();
            add(row, share, &of);
        }
    }
}

impl Gradient<'_> {
    /// The rotor of an output, and the index of the output among its loads and coefficients; `None` for other outputs.
    pub(super) fn rotor_of(&self, index: usize) -> Option<[usize; 2]> {
        let range = self.system.outputs.layout().rotor.range();
        let of_one = size_of::<RotorLoads>() / size_of::<f64>();
        let place = index.checked_sub(range.start).filter(|_| range.contains(&index))?;
        Some([place / of_one, place % of_one])
    }

    /// Whether a result is a load or a coefficient of a rotor, or a mean of one.
    pub(super) fn is_of_rotor(&self, result: &RunResult) -> bool {
        match *result {
            RunResult::Output { index, .. } | RunResult::Mean { index, .. } => self.rotor_of(index).is_some(),
            RunResult::LatchTime { .. } | RunResult::Impulse { .. } => false,
        }
    }

    /// Slopes of a result with respect to the memories of an aerodynamic step of some steps of the tape; `None` if it does not depend on
    /// them but through the motion and the loads.
    pub(super) fn memory_shares(
        &mut self,
        result: &RunResult,
        (span, air): (&Range<usize>, &AirStep),
    ) -> Option<MemoryShares> {
        let (RunResult::Output { index, time } | RunResult::Mean { index, time, .. }) = *result else { return None };
        let place = air.place_of(self.rotor_of(index)?)?;
        let tape = self.tape;
        let Mark { step: last, branch } = &tape.marks[time];
        let branch = branch.iter().filter(|_| span.contains(last));
        let mut shares = [0.0; 2];
        match Mean::of(*result, tape, self.system) {
            Some(mean) => {
                let whole = &tape.steps[span.start..span.end.min(*last).max(span.start)];
                for step in whole.iter().chain(branch) {
                    self.adopt(step);
                    for (stage, at) in points(step).enumerate() {
                        let [_, slope] = mean.integrand(values(self.system, &at)[index]);
                        let weight = mean.share(self.tableau, stage) * step.length_s() * slope;
                        let along = air.share_at(at.time_s);
                        shares[0] += weight * (1.0 - along);
                        shares[1] += weight * along;
                    }
                }
            }
            None => branch.for_each(|step| {
                let along = air.share_at(step.end.time_s);
                shares = [1.0 - along, along];
            }),
        }
        Some(MemoryShares { place, shares })
    }
}
