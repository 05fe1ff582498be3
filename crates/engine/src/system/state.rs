//! The plant's state: small, clonable, and containing all that an FMU state needs.

use crate::force::memory::JointMemory;
use crate::machine::Machine;
use crate::signal::{Inputs, Parameters};
use crate::solve::point::Point;
use crate::system::air::AirHistory;
use crate::system::failure_memory::FailureMemory;
use crate::system::not_finite::not_finite;
use crate::system::outside::Outside;
use crate::system::{PlantError, Statistics};
use nalgebra::UnitQuaternion;
use serde::{Deserialize, Serialize};

/// Names of the fields that may hold non-finite values: [`AirHistory::motion_tolerance`] and [`State::stages`].
const TOLERANCE: &str = "motion_tolerance";
const STAGES: &str = "stages";

/// All quantities that change in time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct State {
    /// Whether `Plant::initialize` has succeeded.
    pub initialized: bool,
    /// Inputs as last set by the caller.
    pub inputs: Inputs,
    /// Parameters as last set by the caller.
    pub parameters: Parameters,
    /// Rates per second of the real inputs in the next step, as the caller set them.
    pub rates: Inputs,
    /// Inputs of the current step at `applied_from_s`.
    pub applied_inputs: Inputs,
    /// Rates per second of the real inputs in the current step.
    pub applied_rates: Inputs,
    /// Time of `applied_inputs` in s.
    pub applied_from_s: f64,
    /// Parameters of the current step.
    pub applied_parameters: Parameters,
    /// Start of the integrator's previous step; the same as `start` after an event and after a failed step.
    pub before: Point,
    /// Start of the integrator's current step; the same as `ahead` if the current time is the end of a step.
    pub start: Point,
    /// End of the integrator's current step, at or ahead of the current time.
    pub ahead: Point,
    /// Intermediate stages of [`State::present_step`]; meaningless without such a step.
    pub stages: Vec<Point>,
    /// Current point.
    pub now: Point,
    /// Step size to try next in s.
    pub step_s: f64,
    /// State of each revolute or prismatic joint.
    pub joints: Vec<JointMemory>,
    /// State of each failure.
    pub failures: Vec<FailureMemory>,
    /// Previous quaternions of universal, ball and free joints, for continuous signs.
    pub spatial_rotations: Vec<UnitQuaternion<f64>>,
    /// Previous quaternions of the tips, for continuous signs.
    pub tip_rotations: Vec<UnitQuaternion<f64>>,
    /// Previous quaternions of the stations, for continuous signs.
    pub station_rotations: Vec<UnitQuaternion<f64>>,
    /// Aerodynamic state; `None` without aerodynamics and before initialisation.
    pub air: Option<AirHistory>,
    /// Values set by an external integrator, if there is one.
    pub outside: Option<Outside>,
    /// Counters of the time integration.
    pub statistics: Statistics,
}

impl State {
    /// State with the inputs and parameters of the model; the rest is set by initialisation.
    pub fn of_model(machine: &Machine) -> Self {
        let (inputs, parameters) = (Inputs::of(machine), Parameters::of(machine));
        Self {
            initialized: false,
            rates: inputs.no_rates(),
            applied_rates: inputs.no_rates(),
            applied_inputs: inputs.clone(),
            applied_from_s: 0.0,
            applied_parameters: parameters.clone(),
            inputs,
            parameters,
            before: Point::default(),
            start: Point::default(),
            ahead: Point::default(),
            stages: Vec::new(),
            now: Point::default(),
            step_s: 0.0,
            joints: Vec::new(),
            failures: Vec::new(),
            spatial_rotations: Vec::new(),
            tip_rotations: Vec::new(),
            station_rotations: Vec::new(),
            air: None,
            outside: None,
            statistics: Statistics::default(),
        }
    }

    /// Start and end of the integrator's step that contains the current time or ends there. `None` without such a step: at the start, after
    /// an event and after a failed step.
    pub fn present_step(&self) -> Option<[&Point; 2]> {
        let Self { before, start, ahead, .. } = self;
        [[start, ahead], [before, start]].into_iter().find(|[begin, end]| begin.time_s < end.time_s)
    }

    /// Copies a state of the same plant; allocates nothing if the sizes are equal.
    pub fn copy_from(&mut self, other: &Self) {
        self.initialized = other.initialized;
        let inputs = [&mut self.inputs, &mut self.rates, &mut self.applied_inputs, &mut self.applied_rates];
        for (own, other) in
            inputs.into_iter().zip([&other.inputs, &other.rates, &other.applied_inputs, &other.applied_rates])
        {
            own.clone_from(other);
        }
        self.parameters.clone_from(&other.parameters);
        self.applied_parameters.clone_from(&other.applied_parameters);
        self.applied_from_s = other.applied_from_s;
        let points = [&mut self.before, &mut self.start, &mut self.ahead, &mut self.now];
        for (own, other) in points.into_iter().zip([&other.before, &other.start, &other.ahead, &other.now]) {
            own.clone_from(other);
        }
        self.stages.clone_from(&other.stages);
        self.step_s = other.step_s;
        self.joints.clone_from(&other.joints);
        self.failures.clone_from(&other.failures);
        self.spatial_rotations.clone_from(&other.spatial_rotations);
        self.tip_rotations.clone_from(&other.tip_rotations);
        self.station_rotations.clone_from(&other.station_rotations);
        match (&mut self.air, &other.air) {
            (Some(own), Some(other)) => own.copy_from(other),
            (own, other) => own.clone_from(other),
        }
        self.outside.clone_from(&other.outside);
        self.statistics = other.statistics;
    }
}

/// All quantities that must survive rollback: inputs, parameters, integrator history, events, energies.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot(Box<State>);

impl Snapshot {
    pub(crate) fn of(state: &State) -> Self {
        Self(Box::new(state.clone()))
    }

    /// Whether the model is under an external integrator.
    pub fn is_outside(&self) -> bool {
        self.0.outside.is_some()
    }

    pub(crate) fn state(&self) -> &State {
        &self.0
    }

    /// Returns an error for a snapshot whose vectors do not have the lengths of this model: `coordinates`, numbers of continuous `states`,
    /// of `tips` and of `stages` within a step. `air` is an aerodynamic history with the sizes of this model.
    pub(crate) fn check(
        &self,
        own: &State,
        (coordinates, states): (usize, usize),
        tips: usize,
        stages: usize,
        air: Option<&AirHistory>,
    ) -> Result<(), PlantError> {
        let theirs = &*self.0;
        let inputs = [&theirs.inputs, &theirs.rates, &theirs.applied_inputs, &theirs.applied_rates];
        let parameters = [&theirs.parameters, &theirs.applied_parameters];
        if !(inputs.into_iter().all(|inputs| inputs.fit(own.inputs.layout()))
            && parameters.into_iter().all(|parameters| parameters.fit(own.parameters.layout())))
        {
            return Err(PlantError::Snapshot("numbers of joints, bodies or stations differ".into()));
        }
        let fits = |point: &Point| {
            [&point.q, &point.v, &point.a, &point.auxiliary].iter().all(|vector| vector.len() == coordinates)
        };
        let points_fit = [&theirs.before, &theirs.start, &theirs.ahead, &theirs.now].into_iter().all(fits);
        let stage_fits = |point: &Point| {
            point.auxiliary.is_empty()
                && [&point.q, &point.v, &point.a].iter().all(|vector| vector.len() == coordinates)
        };
        let stages_fit = theirs.stages.len() == stages && theirs.stages.iter().all(stage_fits);
        if theirs.initialized && !(points_fit && stages_fit) {
            return Err(PlantError::Snapshot("numbers of coordinates differ".into()));
        }
        let rotations = [&theirs.spatial_rotations, &theirs.tip_rotations, &theirs.station_rotations].map(Vec::len);
        let rotations_fit = rotations == [own.parameters.spatial().len(), tips, own.inputs.stations().len()];
        let failures_fit = theirs.failures.len() == own.inputs.failures().len();
        if theirs.initialized && !(rotations_fit && failures_fit && theirs.joints.len() == own.inputs.joints().len()) {
            return Err(PlantError::Snapshot("numbers of free ends or joint states differ".into()));
        }
        let air_fits = match (air, &theirs.air) {
            (Some(own), Some(theirs)) => own.fits(theirs),
            (None, theirs) => theirs.is_none(),
            (Some(_), None) => !theirs.initialized,
        };
        if !air_fits {
            return Err(PlantError::Snapshot("numbers of panels, strips or rows of the wake differ".into()));
        }
        if let Some(outside) = &theirs.outside
            && !outside.fits(theirs.initialized, states)
        {
            return Err(PlantError::Snapshot("states of an external integrator that cannot occur in a run".into()));
        }
        theirs.check_values()
    }
}

impl State {
    /// Returns an error for values that cannot occur in a run: the bytes of a saved state may be arbitrary.
    fn check_values(&self) -> Result<(), PlantError> {
        let refuse = |what: &str| Err(PlantError::Snapshot(format!("{what} that cannot occur in a run")));
        // without a step to the current time there are no stages; an infinite tolerance means that the aerodynamics has not been solved yet
        let left_out = if self.present_step().is_some() { &[TOLERANCE][..] } else { &[TOLERANCE, STAGES][..] };
        if let Some(found) = not_finite(self, left_out) {
            return Err(PlantError::Snapshot(format!("{found}, which cannot occur in a run")));
        }
        if self.air.as_ref().is_some_and(|air| air.motion_tolerance.is_nan()) {
            return refuse("a tolerance of the air");
        }
        let in_order =
            self.outside.is_some() || self.start.time_s <= self.now.time_s && self.now.time_s <= self.ahead.time_s;
        if self.initialized && !(in_order && self.step_s > 0.0) {
            return refuse("an order of times or an internal step");
        }
        if let Err(what) = self.parameters.check().and_then(|()| self.applied_parameters.check()) {
            return refuse(what);
        }
        let inputs = [&self.inputs, &self.rates, &self.applied_inputs, &self.applied_rates];
        let rates = [&self.rates, &self.applied_rates];
        if !(inputs.into_iter().all(Inputs::can_be) && rates.into_iter().all(Inputs::can_be_rates)) {
            return refuse("inputs");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::profile::Profile as Along;
    use crate::beam::section::{Material, Solid};
    use crate::machine::builder::{AirBuilder, FlapBuilder};
    use crate::machine::{Air, Body, Failure, Joint, LiftingSurface, Motor, WakeModel};
    use crate::run::Plant;
    use serde_json::{Value, json};
    use std::collections::BTreeMap;
    use std::sync::Arc;

    /// The state of a wing with a tip on a ball joint after some steps, in which no part is empty.
    fn state(air: AirBuilder, exchanges: bool) -> State {
        let material = Material { youngs_modulus_pa: 7e9, shear_modulus_pa: 3e9, density_kg_m3: 1400.0 };
        let half = |name: &str| {
            let section = Solid::rectangle(0.2, 0.01, material);
            Body::beam(name, 0.5, section).elements(1).load_stations(1)
        };
        let surface = |name: &str| LiftingSurface::on(name, 2).chord_panels(2).chord_m(Along::constant(0.2));
        let drive = Motor { stiffness_n_m_rad: 200.0, damping_n_m_s_rad: 2.0, ..Motor::default() };
        let machine = Machine::builder("Copied")
            .body(half("inner"), Joint::revolute("fold", [0.0, 1.0, 0.0]).motor(drive.clone()))
            .body(half("outer"), Joint::ball("ball").on("inner").motor(drive))
            .failure(Failure::motor_loss("dies", "fold").at_time_s(0.015))
            .air(air.density_kg_m3(1.2).wind_m_s([0.0, -20.0, 1.0]).step_s(0.005))
            .surface(surface("inner"))
            .surface(surface("outer"))
            .flap(FlapBuilder::new("flap", "outer", [0.0, 0.5], 0.5).command_rad(0.1))
            .step_s(0.005)
            .build()
            .unwrap_or_else(|refused| panic!("{refused}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        for step in 1..=5 {
            plant.step(0.005 * f64::from(step)).unwrap_or_else(|error| panic!("{error}"));
        }
        if exchanges {
            plant.system_mut().begin_exchange().expect("strips have states");
        }
        let mut state = plant.snapshot().state().clone();
        // the text format cannot represent infinity
        state.air.as_mut().expect("has air").motion_tolerance = 1.0;
        state
    }

    /// Collects the paths of numbers and booleans: names of fields, with all entries of a list under one path, and whether any value exists
    /// there.
    fn places(value: &Value, at: &mut Vec<String>, found: &mut BTreeMap<Vec<String>, bool>) {
        match value {
            Value::Object(fields) => {
                for (name, value) in fields {
                    at.push(name.clone());
                    places(value, at, found);
                    at.pop();
                }
            }
            Value::Array(entries) => entries.iter().for_each(|value| places(value, at, found)),
            Value::Bool(_) | Value::Number(_) | Value::Null => {
                *found.entry(at.clone()).or_default() |= !value.is_null();
            }
            Value::String(_) => {}
        }
    }

    /// Changes all values at a path.
    fn change(value: &mut Value, at: &[String]) {
        match value {
            Value::Object(fields) => {
                if let Some(value) = at.first().and_then(|name| fields.get_mut(name)) {
                    change(value, &at[1..]);
                }
            }
            Value::Array(entries) => entries.iter_mut().for_each(|value| change(value, at)),
            Value::Bool(on) => *on = !*on,
            Value::Number(number) => {
                *value = match number.as_u64() {
                    Some(count) => json!(count + 1),
                    None => json!(number.as_f64().map_or(1.0, |number| 1.5 * number + 0.7)),
                };
            }
            Value::Null => *value = json!(1.0),
            Value::String(_) => {}
        }
    }

    /// A copy equals the other state after a change of any field, including the aerodynamic and other memories: failed steps and events are
    /// rolled back by copying.
    #[test]
    fn copies_are_equal_in_every_field() {
        let lattice = || Air::lattice().wake(WakeModel::Free).wake_rows(3);
        for (air, exchanges) in [(lattice(), false), (Air::strips(), false), (Air::strips(), true)] {
            let own = state(air, exchanges);
            let text = serde_json::to_value(&own).expect("serialises");
            let mut found = BTreeMap::new();
            places(&text, &mut Vec::new(), &mut found);
            let mut changed = 0;
            for (place, is_there) in found {
                let mut text = text.clone();
                change(&mut text, &place);
                let name = place.join(".");
                let other: State = match serde_json::from_value(text) {
                    Ok(other) => other,
                    // the field is not a number in any of the variants
                    Err(_) if !is_there => continue,
                    Err(error) => panic!("{name}: {error}"),
                };
                assert!(own != other, "{name} is no part of the comparison");
                let mut copy = own.clone();
                copy.copy_from(&other);
                assert!(copy == other, "{name} is not copied");
                changed += 1;
            }
            assert!(changed > 60, "only {changed} fields");
        }
    }
}
