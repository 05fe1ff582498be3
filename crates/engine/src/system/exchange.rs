//! The machine under an external integrator, for example in FMI Model Exchange: time, states and inputs are set one by one, and dependent
//! quantities are evaluated on request.

use crate::machine::Travel;
use crate::math::strain::{CURVATURES, NAMES};
use crate::multibody::circuit::Circuit;
use crate::system::hybrid::NotHybrid;
use crate::system::nominal::{self, OF_JOINTS};
use crate::system::outside::Outside;
use crate::system::{PlantError, System};

/// Constraint violation of the redundant parameters (of order 1) above which a step requests an event that projects the states. Derivatives
/// do not depend on the violation: the projection only keeps the states meaningful.
const DRIFT: f64 = 1e-4;
/// Number of energy accounts that are states: work of the inputs, dissipated energy.
const ACCOUNTS: usize = 2;

/// Name of a coordinate that is a state of an external integrator.
#[derive(Debug, Clone, PartialEq)]
pub struct CoordinateName {
    /// Name, for example `fold.angle` or `inner.element[2].kappa_y`.
    pub name: String,
    /// Index of its body, or of the body attached by its joint.
    pub body: usize,
    /// Quantity of the coordinate.
    pub quantity: CoordinateQuantity,
    /// Typical magnitudes of the coordinate and of its rate, in their units.
    pub nominal: [f64; 2],
}

/// Quantity of a coordinate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CoordinateQuantity {
    /// Angle in rad.
    Angle,
    /// Displacement in m.
    Position,
    /// Redundant parameter without unit, of a quaternion or a rotation matrix.
    Parameter,
    /// Strain, dimensionless.
    Strain,
    /// Curvature in 1/m.
    Curvature,
}

impl System {
    /// Passes control of the initialised model to an external integrator, which starts in event mode. Returns an error with a lattice.
    pub fn begin_exchange(&mut self) -> Result<(), NotHybrid> {
        let accounts = self.account_count();
        let hybrid = self.hybrid()?;
        let moved = hybrid.states();
        let mut states = vec![0.0; moved + accounts];
        hybrid.read(&mut states[..moved]);
        states[moved..].copy_from_slice(&hybrid.accounts_j()[..accounts]);
        let now_s = self.state.now.time_s;
        self.state.outside = Some(Outside { time_s: now_s, event_s: now_s, states, entered: true });
        self.limit_frequencies();
        self.configure();
        self.told.forget();
        self.told.make_room(moved + accounts, self.exchange_indicator_count());
        // for rolling back a failed event
        self.begin.clone_from(&self.state);
        Ok(())
    }

    /// Sets whether the energy accounts, work of the inputs and energy dissipated, are states of an external integrator: otherwise the
    /// accounts are not known while it integrates. To be called before [`System::begin_exchange`]; they are states by default.
    pub fn keep_exchange_accounts(&mut self, kept: bool) {
        self.exchange.without_accounts = !kept;
    }

    /// Whether the energy accounts are states of an external integrator.
    pub fn keeps_exchange_accounts(&self) -> bool {
        !self.exchange.without_accounts
    }

    fn account_count(&self) -> usize {
        if self.exchange.without_accounts { 0 } else { ACCOUNTS }
    }

    /// Takes the limit of frequencies from the parameters while an external integrator integrates.
    pub(super) fn limit_frequencies(&mut self) {
        let limit_rad_s = self.state.parameters.solver().frequency_limit_rad_s;
        let limited = self.state.outside.is_some() && limit_rad_s > 0.0;
        self.exchange.strain_inertia_s2 = if limited { limit_rad_s.powi(-2) } else { 0.0 };
    }

    /// Number of continuous states: coordinates that move, their rates, lag states of strips and rotors, currents of DC motors
    /// and, if they are kept, work and dissipation.
    pub fn exchange_state_count(&self) -> usize {
        2 * self.moving.len() + self.lag_count() + self.circuits().len() + self.account_count()
    }

    /// Names of the lag states, in the order of the states.
    pub fn exchange_lags(&self) -> Vec<String> {
        let continuous = self.air.as_ref().and_then(|air| air.continuous.as_ref());
        continuous.map_or(Vec::new(), |air| self.lag_names(air.gusts))
    }

    /// Units of the lag states, in the order of the states.
    pub fn exchange_lag_units(&self) -> Vec<&'static str> {
        let continuous = self.air.as_ref().and_then(|air| air.continuous.as_ref());
        continuous.map_or(Vec::new(), |air| self.lag_units(air.gusts))
    }

    /// Names of the currents, in the order of the states, after the lag states.
    pub fn exchange_currents(&self) -> Vec<String> {
        let name = |circuit: &Circuit| format!("{}.current", self.machine.bodies[circuit.body].joint.name);
        self.circuits().iter().map(name).collect()
    }

    /// Circuits of the model.
    pub(super) fn circuits(&self) -> &[Circuit] {
        &self.equations.model.circuits
    }

    /// Number of annuli of rotors whose loads can jump with their momentum balance; known before the initialisation.
    pub fn switch_count(&self) -> usize {
        self.air.as_ref().map_or(0, |air| air.model.switches(true).count())
    }

    /// Whether air flows downwind through the annuli whose balance can jump, after [`System::update_exchange`].
    pub fn exchange_flows(&self) -> Vec<bool> {
        let Some(air) = &self.air else { return Vec::new() };
        let mut distances = vec![1.0; air.model.switches(false).count()];
        air.model.read_switches(false, &mut distances);
        distances.iter().map(|distance| *distance > 0.0).collect()
    }

    /// Error for a derivative across the jump of one of these annuli.
    pub fn no_exchange_slope(&self, annulus: usize) -> PlantError {
        let place = self.air.as_ref().and_then(|air| air.model.switches(false).nth(annulus));
        let [part, section] = place.unwrap_or_default();
        self.no_slope(part, section)
    }

    /// Number of event indicators: those of the forces, then two for each motor, then one for each annulus whose loads can jump.
    pub fn exchange_indicator_count(&self) -> usize {
        let motors = self.equations.forces.joints().iter().filter(|joint| joint.motor().is_some()).count();
        self.equations.forces.indicators().count() + 2 * motors + self.switch_count()
    }

    /// Coordinates that are states, in the order of the states; their rates follow in the same order.
    pub fn exchange_coordinates(&self) -> Vec<CoordinateName> {
        let model = &self.equations.model;
        let mut names: Vec<Option<CoordinateName>> = vec![None; model.coordinates];
        for (index, (body, described)) in model.bodies.iter().zip(&self.machine.bodies).enumerate() {
            let mut name = |c: usize, name: String, quantity, nominal: [f64; 2]| {
                names[c] = Some(CoordinateName { name, body: index, quantity, nominal });
            };
            let (kind, joint) = (body.joint.kind, &described.joint.name);
            let first = body.joint.coordinate;
            let shifts = if kind.is_redundant() { kind.translations() } else { 0 };
            for (k, axis) in ["x", "y", "z"].iter().enumerate().take(shifts) {
                name(first + k, format!("{joint}.position.{axis}"), CoordinateQuantity::Position, OF_JOINTS);
            }
            for k in shifts..if kind.is_redundant() { kind.coordinates() } else { 0 } {
                let parameter = format!("{joint}.parameter[{}]", k - shifts + 1);
                name(first + k, parameter, CoordinateQuantity::Parameter, OF_JOINTS);
            }
            if let Some((travel, _)) = described.joint.kind.one_freedom() {
                let quantity = match travel {
                    Travel::Rotation => CoordinateQuantity::Angle,
                    Travel::Translation => CoordinateQuantity::Position,
                };
                name(first, format!("{joint}.{}", travel.coordinate()), quantity, OF_JOINTS);
            }
            for (i, c) in body.modal.iter().flat_map(|modal| modal.range()).enumerate() {
                name(c, format!("{}.mode[{}]", described.name, i + 1), CoordinateQuantity::Position, OF_JOINTS);
            }
            for (i, element) in model.elements[body.first_element..][..body.elements].iter().enumerate() {
                for ((k, strain), c) in NAMES.iter().enumerate().zip(element.range()) {
                    let quantity = match CURVATURES.contains(&k) {
                        true => CoordinateQuantity::Curvature,
                        false => CoordinateQuantity::Strain,
                    };
                    let nominal = nominal::of_strain(described, element, k);
                    name(c, format!("{}.element[{}].{}", described.name, i + 1, strain.name), quantity, nominal);
                }
            }
        }
        let unnamed = |c: usize| CoordinateName {
            name: format!("coordinate[{}]", c + 1),
            body: 0,
            quantity: CoordinateQuantity::Parameter,
            nominal: OF_JOINTS,
        };
        self.moving.iter().map(|&c| names[c].take().unwrap_or_else(|| unnamed(c))).collect()
    }

    /// Returns a continuous state: the value set by the external integrator, or the value of the internal integrator.
    pub fn exchange_state(&self, state: usize) -> f64 {
        let (now, n) = (&self.state.now, self.moving.len());
        let lags = 2 * n + self.lag_count();
        let currents = lags + self.circuits().len();
        match &self.state.outside {
            Some(outside) => outside.states[state],
            None if !self.state.initialized => 0.0,
            None if state < n => now.q[self.moving[state]],
            None if state < 2 * n => now.v[self.moving[state - n]],
            None if state < lags => self.own_lag(state - 2 * n)[0],
            None if state < currents => now.v[self.circuits()[state - lags].coordinate],
            None => [now.work, now.dissipated][state - currents],
        }
    }

    /// Returns the time derivative of a continuous state from the last [`System::update_exchange`], or from the internal integrator.
    pub fn exchange_derivative(&self, state: usize) -> f64 {
        let (now, n) = (&self.state.now, self.moving.len());
        let lags = 2 * n + self.lag_count();
        let currents = lags + self.circuits().len();
        match &self.state.outside {
            Some(_) => self.told.derivatives.get(state).copied().unwrap_or(0.0),
            None if !self.state.initialized => 0.0,
            None if state < n => now.v[self.moving[state]],
            None if state < 2 * n => now.a[self.moving[state - n]],
            None if state < lags => self.own_lag(state - 2 * n)[1],
            None if state < currents => now.a[self.circuits()[state - lags].coordinate],
            None => [now.powers.work, now.powers.dissipated][state - currents],
        }
    }

    /// Continuous states as set by the external integrator; empty before [`System::begin_exchange`].
    pub fn exchange_states(&self) -> &[f64] {
        self.state.outside.as_ref().map_or(&[], |outside| &outside.states)
    }

    /// Sets the [`System::exchange_state_count`] continuous states.
    pub fn set_exchange_states(&mut self, states: &[f64]) {
        if let Some(outside) = &mut self.state.outside {
            outside.states.copy_from_slice(states);
            self.told.forget();
        }
    }

    /// Sets one continuous state; the others are unchanged.
    pub fn set_exchange_state(&mut self, state: usize, value: f64) {
        if let Some(outside) = &mut self.state.outside {
            outside.states[state] = value;
            self.told.forget();
        }
    }

    /// Time as set by the external integrator, in s.
    pub fn exchange_time_s(&self) -> f64 {
        self.state.outside.as_ref().map_or(self.state.now.time_s, |outside| outside.time_s)
    }

    /// Time of the last event, or of the start, in s: latches, failures and limits have the state that this event has given them, so that
    /// times before it have no meaning.
    pub fn exchange_event_s(&self) -> f64 {
        self.state.outside.as_ref().map_or(self.state.now.time_s, |outside| outside.event_s)
    }

    /// Sets the time in s.
    pub fn set_exchange_time(&mut self, time_s: f64) {
        if let Some(outside) = &mut self.state.outside {
            outside.time_s = time_s;
            self.told.forget();
        }
    }

    /// Notes that inputs or parameters have been set.
    pub fn exchange_inputs_set(&mut self) {
        self.inputs_may_differ = true;
        self.told.forget();
    }

    /// Evaluates derivatives and indicators for the set time, states and inputs.
    pub fn update_exchange(&mut self) -> Result<(), PlantError> {
        if self.told.found {
            return Ok(());
        }
        let Some(outside) = self.state.outside.take() else { return Ok(()) };
        let indicators = self.exchange_indicator_count();
        let mut told = std::mem::take(&mut self.told);
        told.make_room(outside.states.len(), indicators);
        let mut hybrid = self.as_hybrid();
        let (moved, accounts) = outside.states.split_at(hybrid.states());
        told.drift = hybrid.set(outside.time_s, moved);
        if let &[work_j, dissipated_j] = accounts {
            hybrid.set_accounts_j([work_j, dissipated_j]);
        }
        // during an event, they are applied by its transition
        if !outside.entered {
            hybrid.follow_inputs();
        }
        let (of_moved, of_accounts) = told.derivatives.split_at_mut(moved.len());
        let rates = match hybrid.crushed() {
            Some(error) => Err(error),
            None => hybrid.derivatives(of_moved),
        };
        if let Ok(rates) = &rates {
            of_accounts.copy_from_slice(&[rates.work_w, rates.dissipated_w][..of_accounts.len()]);
        }
        let (of_forces, rest) = told.indicators.split_at_mut(hybrid.indicators());
        let (of_motors, of_annuli) = rest.split_at_mut(hybrid.limits());
        hybrid.read_indicators(of_forces);
        hybrid.read_limits(of_motors);
        hybrid.read_switches(of_annuli);
        told.found = rates.is_ok();
        self.told = told;
        self.state.outside = Some(outside);
        self.forget_outputs();
        rates.map(|_| ())
    }

    /// Derivatives of the states from the last [`System::update_exchange`].
    pub fn exchange_derivatives(&self) -> &[f64] {
        &self.told.derivatives
    }

    /// Event indicators of the last [`System::update_exchange`]: an event occurs where an indicator of a force falls through zero, or an
    /// indicator of a motor or an annulus changes its sign.
    pub fn exchange_indicators(&self) -> &[f64] {
        &self.told.indicators
    }

    /// Ends a step of the external integrator. Returns true if an event is due: an indicator was crossed, redundant parameters have
    /// drifted, or a changed command is subject to a rate limit.
    pub fn complete_exchange_step(&mut self) -> Result<bool, PlantError> {
        self.update_exchange()?;
        let due = self.as_hybrid().arrived(|_| {});
        if !due {
            // crossings are relative to the start of the step
            let mut told = std::mem::take(&mut self.told);
            let mut hybrid = self.as_hybrid();
            hybrid.complete();
            hybrid.read_indicators(&mut told.indicators);
            self.told = told;
        }
        Ok(due || self.told.drift > DRIFT || self.inputs_may_differ)
    }

    /// Enters event mode.
    pub fn enter_exchange_event(&mut self) -> Result<(), PlantError> {
        self.update_exchange()?;
        if let Some(outside) = &mut self.state.outside {
            outside.entered = true;
            outside.event_s = outside.time_s;
        }
        Ok(())
    }

    /// Performs the transitions of the event: for crossed indicators, a kink, and changed inputs and parameters; redundant parameters are
    /// projected onto their constraints. Returns true if the states have changed. After an error the states are those before the event.
    pub fn make_exchange_event(&mut self) -> Result<bool, PlantError> {
        self.update_exchange()?;
        let mut crossed = std::mem::take(&mut self.told.crossed);
        crossed.clear();
        let mut hybrid = self.as_hybrid();
        hybrid.arrived(|number| crossed.push(number));
        let made = hybrid.transition(&crossed);
        self.told.crossed = crossed;
        self.told.forget();
        made?;
        let Some(mut outside) = self.state.outside.take() else { return Ok(false) };
        // in the memory of the derivatives, which will be evaluated again
        let mut before = std::mem::take(&mut self.told.derivatives);
        before.copy_from_slice(&outside.states);
        let hybrid = self.as_hybrid();
        let (moved, accounts) = outside.states.split_at_mut(hybrid.states());
        hybrid.read(moved);
        accounts.copy_from_slice(&hybrid.accounts_j()[..accounts.len()]);
        let sound = outside.states.iter().all(|state| state.is_finite());
        if !sound {
            outside.states.copy_from_slice(&before);
        }
        let changed = before != outside.states;
        self.told.derivatives = before;
        self.state.outside = Some(outside);
        if sound {
            Ok(changed)
        } else {
            Err(PlantError::NotFinite { time_s: self.exchange_time_s(), cause: self.largest_input() })
        }
    }

    /// Time of the next event known in advance, in s; infinite if there is none.
    pub fn next_exchange_event_s(&mut self) -> f64 {
        self.as_hybrid().next_kink_s()
    }

    /// Leaves event mode.
    pub fn leave_exchange_event(&mut self) {
        if let Some(outside) = &mut self.state.outside {
            outside.entered = false;
        }
        self.told.forget();
    }
}

#[cfg(test)]
mod tests {
    use crate::machine::{Body, Joint, Machine, Motor};
    use crate::run::Plant;
    use nalgebra::Matrix3;
    use std::sync::Arc;

    /// An arm on a hinge with a motor of 2 N·m/rad, limited to 0.5 N·m, under an external integrator.
    fn arm(torque_limit_n_m: f64) -> Plant {
        let drive = Motor { stiffness_n_m_rad: 2.0, torque_limit_n_m, ..Motor::default() };
        let machine = Machine::builder("Arm")
            .body(
                Body::rigid("arm").inertia(1.0, [0.0, 0.0, 0.0], Matrix3::identity()),
                Joint::revolute("hinge", [0.0, 1.0, 0.0]).motor(drive),
            )
            .build()
            .unwrap_or_else(|refused| panic!("{refused}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let system = plant.system_mut();
        system.begin_exchange().unwrap_or_else(|refused| panic!("{refused}"));
        system.make_exchange_event().unwrap_or_else(|error| panic!("{error}"));
        system.leave_exchange_event();
        plant
    }

    /// The two indicators of a motor are positive within its limits, and one of them changes its sign when the motor reaches a limit: at
    /// ±0.25 rad.
    #[test]
    fn indicators_of_motors_change_their_sign_at_the_limits() {
        let mut plant = arm(0.5);
        let system = plant.system_mut();
        for (angle_rad, expected) in [
            (0.0, [1.0, 1.0]),
            (0.249, [1.0, 1.0]),
            (0.251, [1.0, -1.0]),
            (0.4, [1.0, -1.0]),
            (-0.249, [1.0, 1.0]),
            (-0.251, [-1.0, 1.0]),
        ] {
            system.set_exchange_states(&[angle_rad, 0.0, 0.0, 0.0]);
            system.update_exchange().unwrap_or_else(|error| panic!("{error}"));
            let signs: Vec<f64> = system.exchange_indicators().iter().map(|indicator| indicator.signum()).collect();
            assert_eq!(signs, expected, "at {angle_rad} rad");
        }
    }

    /// A command that jumps by 0.3 rad in an event stretches the motor's spring: the energy ½ · 2 N·m/rad · (0.3 rad)² is work of the
    /// input, and is added to the state of the work account.
    #[test]
    fn accounts_are_those_of_after_an_event() {
        let mut plant = arm(100.0);
        let states = [0.0, 0.5, 7.0, 3.0];
        plant.system_mut().set_exchange_states(&states);
        plant.system_mut().enter_exchange_event().unwrap_or_else(|error| panic!("{error}"));
        plant.inputs_mut().joints_mut()[0].command_rad = 0.3;
        let system = plant.system_mut();
        system.exchange_inputs_set();
        assert!(system.make_exchange_event().unwrap_or_else(|error| panic!("{error}")), "the states are others");
        system.leave_exchange_event();
        for (found, expected) in system.exchange_states().iter().zip([0.0, 0.5, 7.0 + 0.09, 3.0]) {
            assert!((found - expected).abs() < 1e-14, "{:?}", system.exchange_states()); // round-off
        }
    }
}
