//! Many runs of one model in one page: axes of bodies of some of them over time, and for each signal how the values of all are distributed.

use crate::packed::{PackedRun, encoded, in_script};
use crate::recording::Thinning;
use foldwing_engine::plant::Plant;
use serde_json::json;

/// Maximum number of intervals of time.
pub const INTERVALS: u64 = 120;
/// Maximum number of intervals along a body.
const ALONG: usize = 8;
/// Maximum number of drawn runs.
const MAXIMUM_DRAWN: usize = 200;
/// Maximum number of values of drawn axes and bands: the page stays below 10 MB.
const MAXIMUM_NUMBERS: usize = 600_000;
/// Maximum number of signals with bands, which leave room for axes.
pub const MAXIMUM_SIGNALS: usize = 800;
/// Maximum number of values of all signals of all runs, in memory.
pub const MAXIMUM_VALUES: usize = 60_000_000;
/// Fractions of the runs below the curves of a band; the first and the last are the extremes.
const FRACTIONS: [f64; 5] = [0.0, 0.05, 0.5, 0.95, 1.0];

/// Distances from the inner end in m at which the axis of a body is drawn, from those of its sections.
fn along_m(places_m: &[f64]) -> Vec<f64> {
    let stride = places_m.len().saturating_sub(1).div_ceil(ALONG).max(1);
    let last = places_m.len() - 1;
    (0..=last).filter(|i| i % stride == 0 || *i == last).map(|i| places_m[i]).collect()
}

/// Recording of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct FanRun {
    /// Times in s.
    times_s: Vec<f32>,
    /// Positions in m of all points of the axes, time by time, root frame.
    axes_m: Vec<f32>,
    /// Values of the signals, time by time.
    values: Vec<f32>,
    /// Distances along each body in m.
    places_m: Vec<Vec<f64>>,
    thinning: Thinning,
}

impl FanRun {
    /// An empty recording of a run of `steps` steps of a model like the plant's.
    pub fn new(plant: &Plant, steps: u64) -> Self {
        let places_m = crate::recording::Scene::of(plant).bodies.iter().map(|body| along_m(&body.places_m)).collect();
        let thinning = Thinning::new(steps, INTERVALS);
        Self { times_s: Vec::new(), axes_m: Vec::new(), values: Vec::new(), places_m, thinning }
    }

    /// Records the current state with the values of the signals.
    pub fn include(&mut self, plant: &Plant, values: impl Iterator<Item = f64>) {
        if !self.thinning.keeps() {
            return;
        }
        self.times_s.push(plant.time_s() as f32);
        for (body, places_m) in self.places_m.iter().enumerate() {
            let points = plant.sections(body, places_m);
            self.axes_m
                .extend(points.iter().flat_map(|point| point.position_m.iter().map(|c| *c as f32).collect::<Vec<_>>()));
        }
        self.values.extend(values.map(|value| value as f32));
    }

    /// The run is over the same times and bodies as another.
    fn is_like(&self, other: &Self) -> bool {
        self.times_s == other.times_s
            && self.places_m.iter().map(Vec::len).eq(other.places_m.iter().map(Vec::len))
            && self.values.len() == other.values.len()
    }
}

/// The runs of a sweep; `shown` is the one whose page they are in.
#[derive(Debug, Clone, PartialEq)]
pub struct Fan {
    /// Names of the signals.
    pub signals: Vec<String>,
    /// Names of the quantities that vary, and of each run their values as text.
    pub keys: Vec<String>,
    /// Values of the keys per run.
    pub labels: Vec<Vec<String>>,
    /// Recordings per run; `None` for failed ones.
    pub runs: Vec<Option<FanRun>>,
    /// Index of the run whose page it is.
    pub shown: usize,
}

impl Fan {
    /// Description and numbers for the page. Runs that failed, or are over other times or bodies than the shown one, are left out and
    /// counted. If there are more runs than the page has space for, a selection of them at equal intervals is drawn; the bands are those of
    /// all.
    ///
    /// # Errors
    /// The shown run failed.
    pub fn packed(&self) -> Result<PackedRun, String> {
        let shown = self.runs[self.shown].as_ref().ok_or("the run in the middle of the sweep failed")?;
        let alike = |run: &Option<FanRun>| run.as_ref().is_some_and(|run| run.is_like(shown));
        let like: Vec<usize> = (0..self.runs.len()).filter(|i| alike(&self.runs[*i])).collect();
        let run = |i: usize| self.runs[i].as_ref().unwrap_or(shown);
        let bands = self.signals.len() * shown.times_s.len() * FRACTIONS.len();
        let room = MAXIMUM_NUMBERS.saturating_sub(bands) / shown.axes_m.len().max(1);
        let room = room.clamp(1, MAXIMUM_DRAWN);
        let count = like.len().min(room);
        let drawn: Vec<usize> = (0..count).map(|i| like[(like.len() - 1) * i / (count - 1).max(1)]).collect();
        let mut numbers = shown.times_s.clone();
        drawn.iter().for_each(|i| numbers.extend(&run(*i).axes_m));
        let width = self.signals.len();
        for signal in 0..width {
            for time in 0..shown.times_s.len() {
                let mut values: Vec<f32> = like.iter().map(|i| run(*i).values[time * width + signal]).collect();
                values.sort_by(f32::total_cmp);
                numbers.extend(FRACTIONS.map(|fraction| quantile(&values, fraction)));
            }
        }
        let description = json!({
            "keys": self.keys,
            "labels": drawn.iter().map(|i| &self.labels[*i]).collect::<Vec<_>>(),
            "shown": self.labels[self.shown],
            "count": self.runs.len(),
            "like": like.len(),
            "points": shown.places_m.iter().map(Vec::len).collect::<Vec<_>>(),
            "times": shown.times_s.len(),
            "fractions": FRACTIONS,
            "signals": self.signals,
        });
        Ok(PackedRun { description: in_script(&description), numbers: encoded(&numbers) })
    }
}

/// Value below which a fraction of ascending values lies, linear between them.
fn quantile(values: &[f32], fraction: f64) -> f32 {
    let place = fraction * (values.len() - 1) as f64;
    let (before, part) = (place.floor() as usize, place.fract() as f32);
    let next = values[(before + 1).min(values.len() - 1)];
    values[before] + part * (next - values[before])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::tests::shipped;
    use std::sync::Arc;

    /// F-379. Few runs are all drawn, many are thinned with both ends; a failed run is left out of the bands, which are those of all others.
    #[test]
    fn fans_are_bounded() {
        let plant = {
            let mut plant = Plant::new(Arc::new(shipped("folding_wing")));
            plant.initialize(0.0).unwrap();
            plant
        };
        let fan = |count: usize| {
            let run = |i: usize| {
                let mut run = FanRun::new(&plant, INTERVALS);
                (0..=INTERVALS).for_each(|_| run.include(&plant, [i as f64, -1.0].into_iter()));
                (i != 1).then_some(run)
            };
            Fan {
                signals: vec!["a".to_owned(), "b".to_owned()],
                keys: vec!["k".to_owned()],
                labels: (0..count).map(|i| vec![i.to_string()]).collect(),
                runs: (0..count).map(run).collect(),
                shown: count / 2,
            }
        };
        for (count, all) in [(5, true), (400, false)] {
            let packed = fan(count).packed().unwrap();
            let about: serde_json::Value = serde_json::from_str(&packed.description).unwrap();
            let labels = about["labels"].as_array().unwrap();
            assert_eq!((about["count"].as_u64(), about["like"].as_u64()), (Some(count as u64), Some(count as u64 - 1)));
            assert_eq!(labels.len() == count - 1, all, "{} of {count} runs", labels.len());
            assert_eq!((&labels[0][0], &labels[labels.len() - 1][0]), (&json!("0"), &json!((count - 1).to_string())));
            assert!(packed.numbers.len() < 16 * MAXIMUM_NUMBERS / 3 + 100_000, "{} letters", packed.numbers.len());
        }
        assert_eq!([0.0, 0.05, 0.5, 1.0].map(|f| quantile(&[0.0, 2.0, 3.0, 4.0], f)), [0.0, 0.3, 2.5, 4.0]);
        let mut torn = fan(5);
        torn.shown = 1;
        assert!(torn.packed().is_err());
    }
}
