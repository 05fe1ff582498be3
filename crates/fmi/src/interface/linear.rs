//! The linear model with the names and units of the variable table.

use crate::interface::known::{Input, JointInput, Known};
use crate::interface::operating_point::OperatingPoint;
use crate::interface::table::Place;
use crate::interface::{Causality, Interface, Value, Variable};
use foldwing_engine::plant::{
    Accuracy, InputSlope, Inputs, Keep, NoReduction, Outputs, Plant, PlantError, Reduced, StateSpace, reduce,
    reduce_in_band, reduce_sampled,
};
use nalgebra::{DVector, Vector3};

/// A signal of a linear model.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearSignal {
    /// Name: for an input or output the name in the table, for a state the free coordinate or `der(…)` of it.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value at the operating point.
    pub value: f64,
}

/// `δẋ = A δx + B δu`, `δy = C δx + D δu` about a state.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearModel {
    /// The state about which the model is linearised.
    pub point: OperatingPoint,
    /// The loads of a vortex lattice are held constant in the model: it includes no wind, aerodynamic damping or flutter. False with strip
    /// theory, whose loads and lag states are included.
    pub without_air: bool,
    /// States: free coordinates, then their rates, then the aerodynamic states, for strips the lag states, for a lattice the changes of the
    /// rates at the aerodynamic steps, of the circulations and of the loads, then the currents of DC motors.
    pub states: Vec<LinearSignal>,
    /// Inputs.
    pub inputs: Vec<LinearSignal>,
    /// Outputs.
    pub outputs: Vec<LinearSignal>,
    /// The four matrices.
    pub matrices: StateSpace,
    /// Reduction of the states, if any.
    pub reduction: Option<Reduction>,
    /// Step in s of a discrete-time model, `δx⁺ = A δx + B δu`, as for a vortex lattice, [`Interface::linearize_lattice`].
    pub step_s: Option<f64>,
}

/// Reduction of a linear model.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    /// Kept states.
    pub keep: Keep,
    /// Number of states before the reduction.
    pub whole: usize,
    /// Bound on the largest gain of the omitted part over all frequencies, in units of the outputs divided by those of the inputs. `None`
    /// if a motion that does not decay was omitted, and for reductions for a band.
    pub error_bound: Option<f64>,
    /// Upper end in Hz of the frequency band of the model; `None` for all frequencies.
    pub up_to_hz: Option<f64>,
    /// Error as a function of frequency; `None` in discrete time without a band.
    pub accuracy: Option<Accuracy>,
}

impl Reduction {
    /// `modal` or `balanced`.
    pub fn method(&self) -> &'static str {
        match self.keep {
            Keep::Modes => "modal",
            Keep::Balanced => "balanced",
        }
    }
}

impl LinearModel {
    /// Returns the model with `order` states, NOTATION eqs. (L18) and (L19). The states are named `modal_1` or `balanced_1` and so on and
    /// have no unit. With a band the model has at most that many states and matches the full one up to `up_to_hz`, eq. (L37).
    ///
    /// # Errors
    /// Invalid orders and frequencies, models whose modes do not span the states, and in discrete time, motions that do not decay.
    pub fn reduced(&self, order: usize, keep: Keep, up_to_hz: Option<f64>) -> Result<Self, NoReduction> {
        let Reduced { model, error_bound, accuracy, .. } =
            reduce_any(&self.matrices, order, keep, up_to_hz, self.step_s)?;
        let reduction = Reduction { keep, whole: self.states.len(), error_bound, up_to_hz, accuracy };
        Ok(self.with_fewer(model, reduction))
    }

    fn with_fewer(&self, model: StateSpace, reduction: Reduction) -> Self {
        let state =
            |i: usize| LinearSignal { name: format!("{}_{i}", reduction.method()), unit: "1".to_owned(), value: 0.0 };
        let states = (1..=model.a.nrows()).map(state).collect();
        Self { states, matrices: model, reduction: Some(reduction), ..self.clone() }
    }
}

/// Reduces the states of a model in continuous time or, with a step, in discrete time.
///
/// # Errors
/// Those of [`LinearModel::reduced`].
pub fn reduce_any(
    model: &StateSpace,
    order: usize,
    keep: Keep,
    up_to_hz: Option<f64>,
    step_s: Option<f64>,
) -> Result<Reduced, NoReduction> {
    match (step_s, up_to_hz) {
        (None, _) => reduce(model, order, keep, up_to_hz),
        (Some(_), Some(_)) if keep == Keep::Modes => Err(NoReduction::SampledModes),
        (Some(step_s), Some(up_to_hz)) => reduce_in_band(model, order, up_to_hz, step_s),
        (Some(_), None) => reduce_sampled(model, order, keep),
    }
}

/// Inputs of [`Interface::linearize_in_gusts`] in addition to those of the table.
pub const GUSTS: [&str; 3] = ["gust.x", "gust.y", "gust.z"];

/// Step of differences in the inputs of motors (rad, N·m): small compared with torque limits.
const DRIVE_STEP: f64 = 1e-4;

impl Interface {
    /// Real inputs of the table available to a linear model: all except, with a lattice, wind and control surfaces, which act through loads
    /// that the model holds constant.
    pub fn real_inputs(&self) -> impl Iterator<Item = &Variable> {
        let of_air = |row: &&Variable| {
            let known = self.known(row.value_reference);
            matches!(known, Some(Known::Input(Input::Wind | Input::Flap(_) | Input::FlapRate(_))))
        };
        self.reals(Causality::Input).filter(move |row| self.linear_air || !of_air(row))
    }

    /// All real inputs of the table; with a lattice those of [`Interface::linearize_lattice`].
    pub fn real_inputs_in_air(&self) -> impl Iterator<Item = &Variable> {
        self.reals(Causality::Input)
    }

    /// Real outputs of the table, all available to a linear model.
    pub fn real_outputs(&self) -> impl Iterator<Item = &Variable> {
        self.reals(Causality::Output)
    }

    fn reals(&self, causality: Causality) -> impl Iterator<Item = &Variable> {
        let wanted = move |row: &&Variable| row.causality == causality && matches!(row.value, Value::Real(_));
        self.variables().iter().filter(wanted)
    }

    /// Linear model about the plant's current state, from real inputs to real outputs. The plant must be initialised; its state is
    /// unchanged.
    pub fn linearize(
        &self,
        plant: &mut Plant,
        inputs: &[&Variable],
        outputs: &[&Variable],
    ) -> Result<LinearModel, PlantError> {
        self.linearize_in_gusts(plant, inputs, &[], outputs)
    }

    /// Linear model as in [`Interface::linearize`], with components of the velocity of a uniform gust as further inputs: indices into
    /// [`GUSTS`], m/s, root frame. Strips respond to a gust with Küssner's lag, to wind with Wagner's; nothing else responds to a gust.
    ///
    /// # Errors
    /// Those of [`Interface::linearize`].
    pub fn linearize_in_gusts(
        &self,
        plant: &mut Plant,
        inputs: &[&Variable],
        gusts: &[usize],
        outputs: &[&Variable],
    ) -> Result<LinearModel, PlantError> {
        self.linear_model(plant, inputs, gusts, outputs, false)
    }

    /// Linear model in discrete time of a machine with a vortex lattice, about an equilibrium, with the aerodynamic step, NOTATION eqs.
    /// (L27) to (L29): wind, gusts that travel with it, control surfaces and all other real inputs, constant over a step.
    ///
    /// # Errors
    /// Machines without a lattice, states that are not an equilibrium, and flows without a steady straight wake.
    pub fn linearize_lattice(
        &self,
        plant: &mut Plant,
        inputs: &[&Variable],
        gusts: &[usize],
        outputs: &[&Variable],
    ) -> Result<LinearModel, PlantError> {
        self.linear_model(plant, inputs, gusts, outputs, true)
    }

    fn linear_model(
        &self,
        plant: &mut Plant,
        inputs: &[&Variable],
        gusts: &[usize],
        outputs: &[&Variable],
        sampled: bool,
    ) -> Result<LinearModel, PlantError> {
        let place = |row: &&&Variable| self.slots[row.value_reference as usize].place;
        let real_inputs: Vec<(usize, bool)> = inputs
            .iter()
            .filter_map(|row| match place(&row) {
                Place::Input(place) => {
                    let drive = matches!(
                        self.known(row.value_reference),
                        Some(Known::Input(Input::Joint(_, JointInput::Command | JointInput::Torque)))
                    );
                    Some((place, drive))
                }
                Place::Time
                | Place::Parameter(_)
                | Place::Output(_)
                | Place::Local(_)
                | Place::Duration(_)
                | Place::State(_)
                | Place::Derivative(_)
                | Place::Indicator(_) => None,
            })
            .collect();
        let adders: Vec<_> = real_inputs
            .iter()
            .map(|&(place, _)| move |inputs: &mut Inputs, amount: f64| inputs.values_mut()[place] += amount)
            .collect();
        let own = adders.iter().zip(&real_inputs).map(|(add, &(_, drive))| InputSlope {
            add,
            step: if drive { DRIVE_STEP } else { 1.0 },
            gust_m_s: Vector3::zeros(),
        });
        let none = |_: &mut Inputs, _: f64| {};
        let of_gust = |component: &usize| {
            let mut gust_m_s = Vector3::zeros();
            gust_m_s[*component] = 1.0;
            InputSlope { add: &none, step: 1.0, gust_m_s }
        };
        let slopes: Vec<InputSlope> = own.chain(gusts.iter().map(of_gust)).collect();
        let rows: Vec<usize> = outputs.iter().filter_map(|row| place(&row).output()).collect();
        let read =
            |values: &Outputs| DVector::from_iterator(rows.len(), rows.iter().map(|&place| values.values()[place]));
        let sampled = if sampled { Some(plant.study().lattice_space(&slopes, &read)?) } else { None };
        let matrices = match &sampled {
            Some(sampled) => sampled.matrices.clone(),
            None => plant.study().state_space(&slopes, &read)?,
        };
        let growing_1_s =
            if sampled.is_some() { plant.study().growing_in_lattice_1_s()? } else { plant.study().growing_1_s()? };
        let point = self.operating_point(plant, growing_1_s);

        let values = read(plant.outputs());
        let signal =
            |row: &Variable, value: f64| LinearSignal { name: row.name.clone(), unit: row.unit().to_owned(), value };
        let present = |row: &&&Variable| match self.get(plant, plant.outputs(), row.value_reference) {
            Some(Value::Real(value)) => value,
            _ => 0.0,
        };
        let freedoms = plant.freedoms();
        let (positions, rates) = plant.free_state();
        let states: Vec<LinearSignal> = freedoms
            .iter()
            .zip(&positions)
            .map(|(freedom, &value)| LinearSignal { name: freedom.name.clone(), unit: freedom.unit.to_owned(), value })
            .chain(freedoms.iter().zip(&rates).map(|(freedom, &value)| LinearSignal {
                name: format!("der({})", freedom.name),
                unit: freedom.rate_unit.to_owned(),
                value,
            }))
            .chain(plant.air_lags(!gusts.is_empty()).into_iter().map(|(name, unit, value)| LinearSignal {
                name,
                unit: unit.to_owned(),
                value,
            }))
            .chain(plant.current_states().into_iter().map(|(name, unit, value)| LinearSignal {
                name,
                unit: unit.to_owned(),
                value,
            }))
            .collect();
        let states = match &sampled {
            None => states,
            Some(sampled) => {
                let rest = sampled.states[2 * sampled.freedoms..].iter();
                let rest =
                    rest.map(|(name, unit)| LinearSignal { name: name.clone(), unit: (*unit).to_owned(), value: 0.0 });
                states.into_iter().take(2 * sampled.freedoms).chain(rest).collect()
            }
        };
        let gusts = gusts.iter().map(|component| LinearSignal {
            name: GUSTS[*component].to_owned(),
            unit: "m/s".to_owned(),
            value: 0.0,
        });
        Ok(LinearModel {
            point,
            without_air: plant.machine().air.is_some() && !plant.air_is_linearised() && sampled.is_none(),
            step_s: sampled.map(|sampled| sampled.step_s),
            states,
            inputs: inputs.iter().map(|row| signal(row, present(&row))).chain(gusts).collect(),
            outputs: outputs.iter().zip(values.iter()).map(|(row, &value)| signal(row, value)).collect(),
            matrices,
            reduction: None,
        })
    }
}
