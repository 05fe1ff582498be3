//! Recording of a variant for the page of a sweep.

use crate::report::recording::FRAMES;
use crate::report::signals::Signals;
use crate::report::{Recording, number};
use foldwing_engine::plant::Plant;
use foldwing_fmi::interface::Interface;
use foldwing_recording::columns;
use foldwing_recording::fan::FanRun;

/// Recording of a variant.
pub(in crate::cli) struct Pictures<'a> {
    /// Names of the signals.
    names: &'a [String],
    run: Option<FanRun>,
    /// The whole run, of the variant whose page it is.
    whole: Option<Option<(Recording, Signals)>>,
    is_done: bool,
}

impl<'a> Pictures<'a> {
    /// Pictures of a variant; `is_shown` for the one whose page it is.
    pub fn new(names: &'a [String], is_shown: bool) -> Self {
        Self { names, run: None, whole: is_shown.then_some(None), is_done: false }
    }

    /// Records the plant at one of the `steps + 1` points of the run.
    pub fn include(&mut self, plant: &Plant, interface: &Interface, steps: u64) {
        let rows: Vec<_> = self.names.iter().map(|name| interface.find(name)).collect();
        let value = |row: &Option<_>| {
            let row: &foldwing_fmi::interface::Variable = (*row)?;
            interface.get(plant, plant.outputs(), row.value_reference)
        };
        let values: Vec<f64> = rows.iter().map(|row| value(row).map_or(f64::NAN, |value| number(&value))).collect();
        self.run.get_or_insert_with(|| FanRun::new(plant, steps)).include(plant, values.iter().copied());
        if let Some(whole) = &mut self.whole {
            let (recording, signals) = whole.get_or_insert_with(|| {
                let named = rows.iter().flatten().copied();
                (Recording::new(plant, steps, FRAMES), Signals::new(columns(named), steps))
            });
            recording.include(plant);
            let present = rows.iter().zip(&values).filter(|(row, _)| row.is_some());
            signals.include(plant.time_s(), present.map(|(_, value)| *value));
        }
    }

    /// Ends the run.
    pub fn finish(&mut self, is_done: bool) {
        self.is_done = is_done;
    }
}

impl Pictures<'_> {
    /// The recordings, of a failed run none.
    pub fn parts(self) -> (Option<FanRun>, Option<(Recording, Signals)>) {
        (self.run.filter(|_| self.is_done), self.whole.flatten().filter(|_| self.is_done))
    }
}
