//! `sweep --view`: one page with all variants.

use crate::cli::Failure;
use crate::cli::outlets::Place;
use crate::cli::sweep::variant::Experiment;
use crate::report::Recording;
use crate::report::signals::Signals;
use crate::report::viewer::{PackedRun, page_of_fan};
use foldwing_fmi::interface::Causality;
use foldwing_recording::fan::{Fan, FanRun, INTERVALS, MAXIMUM_SIGNALS, MAXIMUM_VALUES};

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
