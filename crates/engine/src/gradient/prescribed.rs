//! Joints with prescribed motions, whose coordinates vary with the time and with the numbers of their laws, eq. (X19).

use crate::gradient::variation::{Causes, Variation};
use crate::gradient::{Gradient, add};

/// Slopes of the coordinate of a joint with a prescribed motion at an instant: of its angle, rate and acceleration.
pub(super) struct LawSlopes {
    pub coordinate: usize,
    /// By the time.
    by_time: [f64; 3],
    /// With respect to the numbers of the perturbed models.
    by_neighbours: Vec<[f64; 3]>,
}

impl LawSlopes {
    /// Sets the variation of the coordinate in a direction with a share of its number, for a change of the time: `variation` holds `δq*`,
    /// `δv*` and `δa` of eq. (X6).
    pub fn set(&self, number: Option<(usize, f64)>, shift_s: f64, gain: f64, variation: &mut Variation) {
        let [q, v, a] = [0, 1, 2].map(|part| {
            let by_number = number.map_or(0.0, |(beside, share)| share * self.by_neighbours[beside][part]);
            shift_s * self.by_time[part] + by_number
        });
        let c = self.coordinate;
        variation.a[c] = a;
        variation.v[c] = v - gain * a;
        variation.q[c] = q - gain * v;
    }
}

impl Gradient<'_> {
    /// Slopes of the prescribed coordinates at a time on the branch of another one.
    pub(super) fn laws(&mut self, time_s: f64, branch_s: f64) -> Vec<LawSlopes> {
        let joints = self.system.equations.forces.joints();
        let prescribed = joints.iter().enumerate().filter_map(|(joint, forces)| Some((joint, forces, forces.law()?)));
        let own: Vec<(usize, usize, [f64; 3])> =
            prescribed.map(|(joint, forces, law)| (joint, forces.coordinate, law.by_time(time_s, branch_s))).collect();
        let with_neighbours = own.into_iter().map(|(joint, coordinate, by_time)| {
            let each = self.neighbours.iter_mut().map(|beside| {
                let mut slopes = [0.0; 3];
                beside.add_slopes(&mut slopes, |system, values| {
                    let law = system.equations.forces.joints()[joint].law();
                    values.copy_from_slice(&law.map_or([0.0; 3], |law| law.at_on(time_s, branch_s)));
                });
                slopes
            });
            LawSlopes { coordinate, by_time, by_neighbours: each.collect() }
        });
        with_neighbours.collect()
    }

    /// Index of the perturbed model and its weight, of a direction.
    pub(super) fn number_of(&self, direction: usize, shares: &[f64], causes: Causes) -> Option<(usize, f64)> {
        let entry = self.entries.get(direction).filter(|_| causes.parameters)?;
        Some((entry.beside, shares[direction]))
    }

    /// Adds the slopes with respect to the parameters through the prescribed coordinates at an instant to `gradient`, and returns
    /// those with respect to time: `on` are the multipliers of their angles, rates and accelerations.
    pub(super) fn through_laws(
        &self,
        (laws, time_s): (&[LawSlopes], f64),
        on: [&[f64]; 3],
        gradient: Option<&mut Vec<f64>>,
    ) -> f64 {
        let along = |law: &LawSlopes, slopes: &[f64; 3]| {
            on.iter().zip(slopes).map(|(on, slope)| on[law.coordinate] * slope).sum::<f64>()
        };
        if let Some(gradient) = gradient {
            let by_neighbour = |beside: usize| laws.iter().map(|law| along(law, &law.by_neighbours[beside])).sum();
            let by_neighbours: Vec<f64> = (0..self.neighbours.len()).map(by_neighbour).collect();
            add(gradient, 1.0, &self.by_parameters(time_s, &by_neighbours));
        }
        laws.iter().map(|law| along(law, &law.by_time)).sum()
    }
}
