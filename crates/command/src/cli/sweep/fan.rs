//! `sweep --view`: one page with all variants.

use crate::cli::Failure;
use crate::cli::outlets::Place;
use crate::cli::sweep::variant::Experiment;
use crate::report::recording::FRAMES;
use crate::report::signals::Signals;
use crate::report::viewer::{PackedRun, page_of_fan};
use crate::report::{Recording, number};
use foldwing_engine::plant::Plant;
use foldwing_fmi::interface::{Causality, Interface};
use foldwing_recording::columns;
use foldwing_recording::fan::{Fan, FanRun, INTERVALS, MAXIMUM_SIGNALS, MAXIMUM_VALUES};

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

/// The page of a sweep under construction.
pub(super) struct FanPage<'a> {
    experiment: &'a Experiment<'a>,
    names: Vec<String>,
    runs: Vec<Option<FanRun>>,
    whole: Option<(Recording, Signals)>,
}

impl<'a> FanPage<'a> {
    /// An empty page of all variants.
    ///
    /// # Errors
    /// More values than fit into memory.
    pub fn new(experiment: &'a Experiment<'a>) -> Result<Self, Failure> {
        let interface = &experiment.interface;
        let is_output = |name: &String| interface.find(name).is_some_and(|one| one.causality == Causality::Output);
        let all = || interface.variables().iter().map(|variable| variable.name.clone());
        let given = experiment.outputs.iter().cloned();
        let given: Vec<String> = if experiment.outputs.is_empty() { all().collect() } else { given.collect() };
        let names: Vec<String> = given.into_iter().filter(is_output).collect();
        if names.len() > MAXIMUM_SIGNALS {
            return Err(Failure::Usage(format!(
                "--view: bands of {} variables do not fit into a page, at most {MAXIMUM_SIGNALS}; select fewer by --variables",
                names.len()
            )));
        }
        let count = experiment.plan.count();
        let values = count * names.len() * (INTERVALS as usize + 1);
        if values > MAXIMUM_VALUES {
            return Err(Failure::Usage(format!(
                "--view: {count} variants with {} variables have {values} values, at most {MAXIMUM_VALUES}; select fewer by --variables",
                names.len()
            )));
        }
        Ok(Self { experiment, names, runs: vec![None; count], whole: None })
    }

    /// The variant whose page it is: the one in the middle.
    pub fn shown(&self) -> usize {
        self.runs.len() / 2
    }

    /// Variables of the page.
    pub fn names(&self) -> Vec<String> {
        self.names.clone()
    }

    /// Keeps the pictures of a variant.
    pub fn keep(&mut self, index: usize, run: Option<FanRun>, whole: Option<(Recording, Signals)>) {
        self.runs[index] = run;
        self.whole = whole.or(self.whole.take());
    }

    /// Writes the page.
    pub fn write(self, place: Place) -> Result<(), Failure> {
        let shown = self.shown();
        let plan = self.experiment.plan;
        let texts = |index: usize| plan.variant(index).into_iter().map(str::to_owned).collect();
        let fan = Fan {
            signals: self.names,
            keys: plan.keys().to_vec(),
            labels: (0..self.runs.len()).map(texts).collect(),
            runs: self.runs,
            shown,
        };
        let refused = |cause: String| Failure::Simulation(format!("--view: {cause}"));
        let packed = fan.packed().map_err(refused)?;
        let (recording, signals) = self.whole.ok_or_else(|| refused("no run to show".to_owned()))?;
        let run = PackedRun::new(&recording, &signals, 2);
        place.fill(page_of_fan(&recording.scene.name, &run, &packed).as_bytes())
    }
}

impl Pictures<'_> {
    /// The recordings, of a failed run none.
    pub fn parts(self) -> (Option<FanRun>, Option<(Recording, Signals)>) {
        (self.run.filter(|_| self.is_done), self.whole.flatten().filter(|_| self.is_done))
    }
}
