//! Derivatives of named results with respect to named numbers.

use crate::names;
use crate::sensitivity::error::{GradientsError, QuantityError};
use crate::sensitivity::extreme::Samples;
use crate::sensitivity::quantity::{Average, Named, Quantity};
use foldwing_engine::plant::{Gradient, InputRows, Parameter, Plant, RunPieces, RunResult, Tape};
use foldwing_fmi::interface::Interface;
use serde::Serialize;

/// Number of parameters per result from which on the adjoint costs less than one direction for each parameter.
const ADJOINT_FROM: f64 = 1.6;

/// Differentiation mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// The mode that costs less.
    #[default]
    Auto,
    /// One direction per parameter, propagated forward through the run.
    Forward,
    /// Multipliers of each result, propagated backward through the run.
    Adjoint,
}

/// Options of [`differentiate`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Options {
    /// Results: `NAME` of a real output at the end of the run, `NAME@TIME` at a time in s, `max(NAME)`, `min(NAME)`, `peak(NAME)`, `mean(NAME)`,
    /// `rms(NAME)` over the run, `JOINT.latch_time`, `JOINT.latch_impulse`. Names of vectors and patterns represent all of their components.
    pub of: Vec<String>,
    /// Stop time in s; `None`: that of the model.
    pub stop_s: Option<f64>,
    /// Forward or adjoint.
    pub mode: Mode,
    /// Inputs over time; by default all are constant.
    pub inputs: InputRows,
}

/// Numbers of a model, and the parameter that varies the model with them.
pub struct Numbers {
    /// A number of the model, or values of an input over time.
    pub by: Vec<By>,
    /// Plants with perturbed values of these numbers.
    pub parameter: Parameter,
}

/// Results of a run with their derivatives.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gradients {
    /// Name of the model.
    pub name: String,
    /// Start of the run in s.
    pub start_s: f64,
    /// Stop of the run in s.
    pub stop_s: f64,
    /// Steps of the run.
    pub steps: usize,
    /// Forward or adjoint.
    pub mode: Mode,
    /// The numbers.
    pub by: Vec<By>,
    /// The results.
    pub of: Vec<Derivatives>,
}

/// A number of the model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct By {
    /// Name: of an input or parameter, of an input at the time of a row (`fold.command@0.1`), or a key of the model file.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Unit; empty if it is part of the name.
    pub unit: &'static str,
}

/// A result with its derivatives.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Derivatives {
    /// Name, as in [`Options::of`].
    pub name: String,
    /// Time of the result in s.
    pub time_s: f64,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
    /// Derivatives with respect to the numbers, in their order.
    pub derivatives: Vec<f64>,
}

/// Runs a model and differentiates results of the run with respect to numbers of the model.
///
/// `plant` has its start values and is not yet initialised; the plants of `numbers` differ from it only in the perturbed number. Without
/// numbers only the values are computed.
///
/// # Errors
/// Results that do not exist, parts of the model that gradients do not cover, and a run that fails.
pub fn differentiate(plant: Plant, numbers: Vec<Numbers>, options: &Options) -> Result<Gradients, GradientsError> {
    let stop_s = checked_stop_s(&plant, options)?;
    // names before the run
    let named = named(&plant, &options.of)?;
    let mut recorded = Recorded::run(plant, &options.inputs, stop_s)?;
    let results = recorded.results(named)?;
    recorded.derivatives(&results, numbers, options.mode)
}

/// Stop time of the run in s.
fn checked_stop_s(plant: &Plant, options: &Options) -> Result<f64, GradientsError> {
    let start_s = plant.machine().experiment.start_time_s;
    let stop_s = options.stop_s.unwrap_or(plant.machine().experiment.stop_time_s);
    match stop_s.partial_cmp(&start_s) == Some(std::cmp::Ordering::Greater) && stop_s.is_finite() {
        true => Ok(stop_s),
        false => Err(GradientsError::Stop { start_s, stop_s }),
    }
}

/// A run whose steps are kept, for derivatives of its results and for runs of other models with the same steps.
pub struct Recorded {
    plant: Plant,
    tape: Tape,
    start_s: f64,
    stop_s: f64,
    pieces: Option<RunPieces>,
}

/// Results of a recorded run.
#[derive(Debug, Clone)]
pub struct Results {
    named: Vec<Named>,
    list: Vec<RunResult>,
    /// Times in s; a latch time is itself the result and has no time.
    times_s: Vec<Option<f64>>,
}

impl Recorded {
    /// Runs a model and keeps its steps; `plant` has its start values and is not yet initialised.
    ///
    /// # Errors
    /// A stop time before the start, parts of the model that gradients do not cover, and a run that fails.
    pub fn new(plant: Plant, options: &Options) -> Result<Self, GradientsError> {
        let stop_s = checked_stop_s(&plant, options)?;
        Self::run(plant, &options.inputs, stop_s)
    }

    /// To the stop, so that latch times up to there are found.
    fn run(mut plant: Plant, inputs: &InputRows, stop_s: f64) -> Result<Self, GradientsError> {
        let start_s = plant.machine().experiment.start_time_s;
        inputs.set(&mut plant, start_s);
        plant.initialize(start_s)?;
        let tape = plant.run_on_tape_with(inputs, &[stop_s])?;
        Ok(Self { plant, tape, start_s, stop_s, pieces: None })
    }

    /// The steps.
    pub fn tape(&self) -> &Tape {
        &self.tape
    }

    /// The results with these names, as in [`Options::of`].
    ///
    /// # Errors
    /// Results that do not exist or have no derivative.
    pub fn find(&mut self, of: &[String]) -> Result<Results, GradientsError> {
        let named = named(&self.plant, of)?;
        self.results(named)
    }

    fn results(&mut self, named: Vec<Named>) -> Result<Results, GradientsError> {
        let Self { plant, tape, start_s, stop_s, .. } = self;
        let (list, times_s) = results((plant, tape), &named, (*start_s, *stop_s))?.into_iter().unzip();
        Ok(Results { named, list, times_s })
    }

    /// Derivatives of results; the plants of `numbers` differ from that of the run only in the perturbed number. Without numbers only the values
    /// are computed.
    ///
    /// # Errors
    /// Numbers and results without derivatives.
    pub fn derivatives(
        &mut self,
        results: &Results,
        numbers: Vec<Numbers>,
        mode: Mode,
    ) -> Result<Gradients, GradientsError> {
        let Self { plant, tape, start_s, stop_s, .. } = self;
        let Results { named, list, times_s } = results;
        let (mut by, mut parameters) = (Vec::new(), Vec::new());
        for numbers in numbers {
            by.extend(numbers.by);
            parameters.push(numbers.parameter);
        }
        let adjoint = match mode {
            // an adjoint pass of an integral differences the integrand by all coordinates at every stage
            Mode::Auto if named.iter().any(|own| own.is_integral(plant.outputs().layout().accounts())) => false,
            Mode::Auto => list.len() as f64 * ADJOINT_FROM < by.len() as f64,
            Mode::Forward => false,
            Mode::Adjoint => true,
        };
        let name = plant.machine().name.clone();
        let mut gradient = Gradient::new(plant, tape, parameters)?;
        let mut values = gradient.values(list)?;
        let mut table = match (by.is_empty(), adjoint) {
            (true, _) => vec![Vec::new(); list.len()],
            (false, true) => list.iter().map(|result| gradient.adjoint(*result)).collect::<Result<_, _>>()?,
            (false, false) => gradient.forward(list)?,
        };
        for ((own, value), row) in named.iter().zip(&mut values).zip(&mut table) {
            if let Quantity::Average { kind: Average::RootMeanSquare, .. } = own.quantity {
                if *value == 0.0 {
                    return Err(GradientsError::Quantity { of: own.name.clone(), error: QuantityError::Zero });
                }
                *value = value.sqrt();
                row.iter_mut().for_each(|slope| *slope /= 2.0 * *value);
            }
        }
        let of = named.iter().zip(times_s).zip(values).zip(table);
        let of = of.map(|(((own, time_s), value), derivatives)| {
            let (name, unit) = (own.name.clone(), own.unit);
            Derivatives { name, unit, time_s: time_s.unwrap_or(value), value, derivatives }
        });
        let mode = if adjoint { Mode::Adjoint } else { Mode::Forward };
        let (start_s, stop_s, steps) = (*start_s, *stop_s, tape.steps());
        Ok(Gradients { name, start_s, stop_s, steps, mode, by, of: of.collect() })
    }

    /// Values of the results of another model in a run with the same steps: derivatives are those of this run, whose differences tend to
    /// them. `None` if a force lies on another smooth piece at some stage, so that a difference would pass its kink.
    ///
    /// `plant` has its start values and is not yet initialised; the rows of `inputs` have the times of those of the run.
    ///
    /// # Errors
    /// A run with other events, and results that it does not have.
    pub fn along(
        &mut self,
        mut plant: Plant,
        inputs: &InputRows,
        results: &Results,
    ) -> Result<Option<Vec<f64>>, GradientsError> {
        inputs.set(&mut plant, self.start_s);
        plant.initialize(self.start_s)?;
        let tape = plant.run_along(&self.tape, inputs)?;
        let own = self.pieces.get_or_insert_with(|| self.plant.pieces_on_tape(&self.tape));
        if plant.pieces_on_tape(&tape) != *own {
            return Ok(None);
        }
        let (start_s, stop_s) = (self.start_s, self.stop_s);
        let mut other = Self { plant, tape, start_s, stop_s, pieces: None };
        let found = other.results(results.named.clone())?;
        let found = other.derivatives(&found, Vec::new(), Mode::Forward)?;
        Ok(Some(found.of.iter().map(|row| row.value).collect()))
    }
}

/// The results with these names.
fn named(plant: &Plant, of: &[String]) -> Result<Vec<Named>, GradientsError> {
    let interface = Interface::new(plant.machine());
    let mut list: Vec<Named> = Vec::new();
    for of in of.iter().flat_map(|list| names::split(list)) {
        let found = Named::of(of, plant.machine(), &interface)
            .map_err(|error| GradientsError::Quantity { of: of.to_owned(), error })?;
        list.extend(found);
    }
    if list.is_empty() { Err(GradientsError::NoResult) } else { Ok(list) }
}

/// The results, each with its time in s; a latch time is itself the result and has no time.
fn results(
    (plant, tape): (&mut Plant, &mut Tape),
    named: &[Named],
    (start_s, stop_s): (f64, f64),
) -> Result<Vec<(RunResult, Option<f64>)>, GradientsError> {
    let extreme = |own: &Named| match own.quantity {
        Quantity::Extreme { index, .. } => Some(index),
        Quantity::Output { .. }
        | Quantity::Average { .. }
        | Quantity::LatchImpulse { .. }
        | Quantity::LatchTime { .. } => None,
    };
    let sampled: Vec<usize> = named.iter().filter_map(extreme).collect();
    let samples = Samples::of(plant, tape, &sampled, (start_s, stop_s))?;
    let (mut list, mut places) = (Vec::new(), 0..);
    // every time is requested once
    let mut requested: Vec<(f64, usize)> = Vec::new();
    for own in named {
        let refused = |error| GradientsError::Quantity { of: own.name.clone(), error };
        let (index, time_s) = match own.quantity {
            Quantity::LatchTime { joint } => {
                list.push((RunResult::LatchTime { joint }, None));
                continue;
            }
            Quantity::LatchImpulse { joint } => {
                list.push((RunResult::Impulse { joint }, Some(tape.latch_time_s(joint).unwrap_or(stop_s))));
                continue;
            }
            Quantity::Average { index, .. } => (index, stop_s),
            Quantity::Output { index, time_s } => {
                let time_s = time_s.unwrap_or(stop_s);
                if !(start_s..=stop_s).contains(&time_s) {
                    return Err(refused(QuantityError::Outside { time_s, start_s, stop_s }));
                }
                (index, time_s)
            }
            Quantity::Extreme { index, kind } => {
                let place = places.next().unwrap_or(0);
                (index, samples.instant((plant, tape), (place, index), kind)?.map_err(refused)?)
            }
        };
        let time = match requested.iter().find(|(other_s, _)| *other_s == time_s) {
            Some((_, time)) => *time,
            None => plant.request(tape, time_s)?,
        };
        requested.push((time_s, time));
        let result = match own.quantity {
            Quantity::Average { kind, .. } => RunResult::Mean { index, time, square: kind == Average::RootMeanSquare },
            Quantity::Output { .. }
            | Quantity::Extreme { .. }
            | Quantity::LatchImpulse { .. }
            | Quantity::LatchTime { .. } => RunResult::Output { index, time },
        };
        list.push((result, Some(time_s)));
    }
    Ok(list)
}
