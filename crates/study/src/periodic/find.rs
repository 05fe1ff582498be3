//! The search for a periodic motion, with its outputs and modes.

use crate::names::{NameError, choose, of_variable};
use crate::periodic::modes::table_of_modes;
use crate::periodic::series::{Series, Summary};
use crate::values::{Setting, SettingError, plant_with};
use crate::watch::{Progress, Watch, unwatched};
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{Floquet, OutputSet, PeriodicMotion, Plant, PlantError, SAMPLES, Turn};
use foldwing_fmi::interface::{Interface, Value, Variable};
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};
use std::f64::consts::PI;
use std::ops::ControlFlow;

/// Maximum number of harmonics that the samples of a revolution resolve.
pub const MAXIMUM_HARMONICS: usize = SAMPLES / 2 - 1;

/// Options of [`find`].
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Shaft speed in rpm; `None`: the prescribed or initial speed.
    pub speed_rpm: Option<f64>,
    /// Joint of the shaft; `None`: the only joint that rotates without limit and carries a hub.
    pub shaft: Option<String>,
    /// Start values.
    pub settings: Vec<Setting>,
    /// Steps per revolution, rounded up to a multiple of 144.
    pub steps: usize,
    /// Difference between the ends of a revolution below which the motion counts as periodic: rotation in rad, or displacement
    /// relative to the model's length; between 0 and 1.
    pub tolerance: f64,
    /// Outputs: names, patterns, prefixes, lists with commas ([`choose`]); all if empty.
    pub outputs: Vec<String>,
    /// Number of harmonics of the shaft speed in the summary of outputs: up to [`MAXIMUM_HARMONICS`].
    pub harmonics: usize,
    /// Number of Floquet modes; 0 omits them.
    pub count: usize,
    /// Maximum number of perturbations integrated for the modes, over two revolutions each.
    pub perturbations: usize,
}

impl Default for Options {
    /// 720 steps, tolerance 1e-8, three harmonics, ten modes.
    fn default() -> Self {
        Self {
            speed_rpm: None,
            shaft: None,
            settings: Vec::new(),
            steps: 720,
            tolerance: 1e-8,
            outputs: Vec::new(),
            harmonics: 3,
            count: 10,
            perturbations: 120,
        }
    }
}

/// A periodic motion.
///
/// Serialised, it is the JSON of `foldwing periodic`: without the values over the revolution.
#[derive(Debug, Clone)]
pub struct Periodic {
    /// Name of the model.
    pub machine: String,
    /// The revolution of the shaft, at constant speed.
    pub turn: Turn,
    /// The motion.
    pub motion: PeriodicMotion,
    /// Outputs over the revolution.
    pub outputs: Vec<Series>,
    /// Floquet modes about the motion; `None` if they were omitted.
    pub floquet: Option<Floquet>,
    harmonics: usize,
    count: usize,
}

/// Error of a search for a periodic motion.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PeriodicError {
    /// More harmonics than [`MAXIMUM_HARMONICS`].
    #[error(
        "harmonics {harmonics}: must be at most {MAXIMUM_HARMONICS}, the highest that the {SAMPLES} samples per \
         revolution resolve"
    )]
    Harmonics {
        /// The rejected number.
        harmonics: usize,
    },
    /// A tolerance that is not between 0 and 1.
    #[error("tolerance {tolerance}: must lie between 0 and 1")]
    Tolerance {
        /// The tolerance.
        tolerance: f64,
    },
    /// Modes are requested without perturbations.
    #[error("perturbations 0: modes need at least 1; count 0 omits the modes")]
    NoPerturbations,
    /// The model has no shaft, or changes from revolution to revolution.
    #[error("no periodic motion: {cause}")]
    NoTurn {
        /// The reason.
        cause: String,
    },
    /// A name or pattern that no output has.
    #[error(transparent)]
    Name(#[from] NameError),
    /// A start value that is rejected.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The motion or the modes are not found.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// The watch of [`find_watched`] stopped the search.
    #[error("the search was stopped")]
    Stopped,
}

/// Finds the motion of a rotor that repeats every revolution, NOTATION eqs. (L32) and (L33), with its outputs and the modes about it.
///
/// # Errors
/// Options that are not allowed, no shaft or speed, a model that changes from revolution to revolution, unknown names, no periodic
/// motion.
pub fn find(machine: &Machine, options: &Options) -> Result<Periodic, PeriodicError> {
    find_watched(machine, options, &mut unwatched)
}

/// [`find`] with `watch` called before the search, before the revolution with the outputs, and before the modes.
///
/// # Errors
/// Those of [`find`], and [`PeriodicError::Stopped`].
pub fn find_watched(machine: &Machine, options: &Options, watch: &mut Watch<'_>) -> Result<Periodic, PeriodicError> {
    let Options { harmonics, tolerance, count, perturbations, .. } = *options;
    if harmonics > MAXIMUM_HARMONICS {
        return Err(PeriodicError::Harmonics { harmonics });
    }
    if !(tolerance > 0.0 && tolerance < 1.0) {
        return Err(PeriodicError::Tolerance { tolerance });
    }
    if perturbations == 0 && count > 0 {
        return Err(PeriodicError::NoPerturbations);
    }
    let speed_rad_s = options.speed_rpm.map(|speed_rpm| speed_rpm * PI / 30.0);
    let (machine, turn) = Turn::of(machine, options.shaft.as_deref(), speed_rad_s, options.steps)
        .map_err(|cause| PeriodicError::NoTurn { cause })?;
    let interface = Interface::new(&machine);
    let all: Vec<&Variable> = interface.real_outputs().collect();
    let recorded = match options.outputs.is_empty() {
        true => all,
        false => choose(&options.outputs, &all, of_variable, "real output")?,
    };
    let mut plant = plant_with(machine, &interface, &options.settings)?;
    plant.watch(OutputSet::NONE);
    plant.initialize(plant.machine().experiment.start_time_s)?;
    let mut begin = |part: &'static str| match watch(Progress { part, done: 0, total: None }) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(PeriodicError::Stopped),
    };
    begin("search for the periodic state")?;
    let motion = plant.periodic(&turn, tolerance)?;
    begin("outputs over a revolution")?;
    let outputs = traced(&mut plant, &turn, &motion, &interface, &recorded)?;
    let floquet = match count {
        0 => None,
        _ => {
            begin("Floquet modes")?;
            Some(plant.floquet(&turn, &motion, perturbations)?)
        }
    };
    Ok(Periodic { machine: plant.machine().name.clone(), turn, motion, outputs, floquet, harmonics, count })
}

/// Outputs at the samples of the revolution, including its end.
fn traced(
    plant: &mut Plant,
    turn: &Turn,
    motion: &PeriodicMotion,
    interface: &Interface,
    recorded: &[&Variable],
) -> Result<Vec<Series>, PlantError> {
    let mut list: Vec<Series> = recorded.iter().map(|variable| Series::of(&variable.name, variable.unit())).collect();
    let rows: Vec<u32> = recorded.iter().map(|variable| variable.value_reference).collect();
    let needs = interface.needs(rows.as_slice());
    let mut seen = |_: usize, plant: &mut Plant| {
        plant.provide(needs);
        for (series, row) in list.iter_mut().zip(&rows) {
            if let Some(Value::Real(value)) = interface.get(plant, plant.outputs(), *row) {
                series.values.push(value);
            }
        }
        Ok(())
    };
    plant.trace(turn, motion, &mut seen)?;
    Ok(list)
}

impl Periodic {
    /// Speed of the shaft in rpm.
    pub fn speed_rpm(&self) -> f64 {
        self.turn.speed_rad_s * 30.0 / PI
    }

    /// Rotation of the shaft from the start at each value of the outputs, in degrees, with the sign of its rotation.
    pub fn turn_deg(&self) -> Vec<f64> {
        let sense = self.turn.speed_rad_s.signum();
        (0..=SAMPLES).map(|k| sense * 360.0 * k as f64 / SAMPLES as f64).collect()
    }

    /// The outputs as mean, range and harmonics.
    pub fn summaries(&self) -> Vec<Summary<'_>> {
        let sense = self.turn.speed_rad_s.signum();
        self.outputs.iter().map(|series| series.summary(self.harmonics, sense)).collect()
    }
}

impl Serialize for Periodic {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { turn, motion, .. } = self;
        let mut fields = serializer.serialize_struct("Periodic", 9 + usize::from(self.floquet.is_some()))?;
        fields.serialize_field("name", &self.machine)?;
        fields.serialize_field("rotor_speed_rpm", &self.speed_rpm())?;
        fields.serialize_field("period_s", &turn.period_s())?;
        fields.serialize_field("steps", &turn.steps)?;
        fields.serialize_field("states", &motion.states)?;
        fields.serialize_field("distance", &motion.distance)?;
        fields.serialize_field("newton_steps", &motion.newton_steps)?;
        fields.serialize_field("turns", &motion.turns)?;
        fields.serialize_field("outputs", &self.summaries())?;
        if let Some(floquet) = &self.floquet {
            fields.serialize_field("floquet", &table_of_modes(floquet, self.count))?;
        }
        fields.end()
    }
}
