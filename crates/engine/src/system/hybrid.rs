//! The machine as a hybrid system: continuous states with derivatives, event indicators, transitions. Interface for external integrators
//! (FMI Model Exchange, the solver of another program, a study).

use crate::force::latch::CROSSING_S;
use crate::math::strain::{STRAINS, STRETCH};
use crate::multibody::model::Element;
use crate::signal::JointParameters;
use crate::solve::EquationsOfMotion;
use crate::system::PlantError;
use crate::system::air::instant_workspace::ContinuousAir;
use crate::system::equations::Equations;
use crate::system::events::settle;
use crate::system::outputs::Outputs;
use crate::system::state::State;
use crate::system::{OutputSet, System};

/// An initialised model, without aerodynamics or without a lattice, under an external integrator.
///
/// The states are the coordinates that forces can move, then their rates, then the lag states of strips and rotors, then the currents of
/// electrical motors; their number is constant, even while joints are held. Coordinates of universal, ball and free joints are redundant
/// parameters: [`Hybrid::complete`] projects them onto their constraints. Between events, derivatives are smooth in states and time, except
/// at the torque limits of motors and where the balance of an annulus jumps, which have no transition: [`Hybrid::read_limits`],
/// [`Hybrid::read_switches`].
pub struct Hybrid<'a> {
    system: &'a mut System,
}

/// Energies booked by a transition in J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Jump {
    /// Dissipated energy.
    pub dissipated_j: f64,
    /// Work of the inputs.
    pub work_j: f64,
}

/// Rates of the energy accounts in W.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AccountRates {
    /// Power dissipated by damping.
    pub dissipated_w: f64,
    /// Power of the inputs.
    pub work_w: f64,
}

/// Reason why a model cannot be integrated externally.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NotHybrid {
    /// `Plant::initialize` has not succeeded.
    #[error("the model is not initialised; initialise it first")]
    Uninitialized,
    /// The element along which a body slides is known to the internal integrator only.
    #[error(
        "an external integrator is not possible with a sliding joint: the body crosses borders of elements, where the rates of \
         all coordinates jump; use co-simulation"
    )]
    Sliding,
    /// Rigid loops are closed at the ends of the internal integrator's steps.
    #[error(
        "an external integrator is not possible with a rigid loop: its states would leave the constraints; use co-simulation, or give the \
         loop stiffness_N_m in place of rigid = true"
    )]
    RigidLoop,
    /// Skates and wheels are projected onto their constraints at the ends of the internal integrator's steps.
    #[error(
        "an external integrator is not possible with a skate or a wheel: its states would leave the constraints, so that they slip; use \
         co-simulation"
    )]
    NoSlip,
    /// Panels and wake advance in fixed aerodynamic steps.
    #[error(
        "an external integrator is not possible with a vortex lattice, which uses fixed aerodynamic steps; write \
         model = \"strip\" in [aerodynamics], omit the table, or use co-simulation"
    )]
    Air,
}

impl System {
    /// The model as a hybrid system at the current time. Returns an error before `Plant::initialize`, and with a lattice, whose
    /// states are advanced only by the internal integrator.
    pub fn hybrid(&mut self) -> Result<Hybrid<'_>, NotHybrid> {
        if !self.state.initialized {
            return Err(NotHybrid::Uninitialized);
        }
        if !self.air_is_continuous() {
            return Err(NotHybrid::Air);
        }
        if self.machine.sliding_joint().is_some() {
            return Err(NotHybrid::Sliding);
        }
        if self.machine.closures.iter().any(|closure| closure.rigid) {
            return Err(NotHybrid::RigidLoop);
        }
        if !self.machine.no_slips.is_empty() {
            return Err(NotHybrid::NoSlip);
        }
        // crossings located ahead by the internal integrator do not apply to the external one
        self.state.joints.iter_mut().for_each(|joint| joint.crossed = 0);
        self.hand_air_over();
        let mut hybrid = self.as_hybrid();
        hybrid.complete();
        Ok(hybrid)
    }

    /// The model as a hybrid system, without the checks of [`System::hybrid`], within a step of the external integrator.
    pub(super) fn as_hybrid(&mut self) -> Hybrid<'_> {
        Hybrid { system: self }
    }

    /// Coordinates that are states of [`System::hybrid`]: all except those that are prescribed or permanently locked, and the charges of
    /// circuits, on which nothing depends.
    pub(super) fn moving_coordinates(equations: &Equations) -> Vec<usize> {
        let given = |c: usize| equations.forces.joints().iter().any(|joint| joint.coordinate == c && !joint.driven);
        let circuits = &equations.model.circuits;
        let charge = |c: usize| circuits.iter().any(|circuit| circuit.coordinate == c);
        (0..equations.model.coordinates).filter(|&c| !given(c) && !charge(c)).collect()
    }
}

impl Hybrid<'_> {
    /// Number of continuous states.
    pub fn states(&self) -> usize {
        2 * self.system.moving.len() + self.system.lag_count() + self.system.circuits().len()
    }

    /// Indices in the vectors of the equations of the coordinates that are states, in the order of the states; their rates follow in the
    /// same order.
    pub fn coordinates(&self) -> &[usize] {
        &self.system.moving
    }

    /// Current time in s.
    pub fn time_s(&self) -> f64 {
        self.system.state.now.time_s
    }

    /// Copies the current states. `states` has [`Hybrid::states`] entries.
    pub fn read(&self, states: &mut [f64]) {
        let now = &self.system.state.now;
        self.copy_to(states, &now.q, &now.v);
        self.copy_others(states, self.air().map_or(&[], |air| &air.lags), &now.v);
    }

    /// Copies coordinates that move and their rates, or rates and accelerations.
    fn copy_to(&self, states: &mut [f64], of_coordinates: &[f64], of_rates: &[f64]) {
        let moving = &self.system.moving;
        for (i, &c) in moving.iter().enumerate() {
            (states[i], states[moving.len() + i]) = (of_coordinates[c], of_rates[c]);
        }
    }

    /// Copies lag states and currents, or their rates, behind those of the coordinates.
    fn copy_others(&self, states: &mut [f64], of_lags: &[f64], of_charges: &[f64]) {
        let (lags, currents) = states[2 * self.system.moving.len()..].split_at_mut(self.system.lag_count());
        lags.copy_from_slice(of_lags);
        for (current, circuit) in currents.iter_mut().zip(self.system.circuits()) {
            *current = of_charges[circuit.coordinate];
        }
    }

    fn air(&self) -> Option<&ContinuousAir> {
        self.system.air.as_ref()?.continuous.as_ref()
    }

    /// Sets time and states, and returns the constraint violation of the redundant parameters. Allocates nothing, like the other functions
    /// of this type.
    pub fn set(&mut self, time_s: f64, states: &[f64]) -> f64 {
        let (lags, currents) = states[2 * self.system.moving.len()..].split_at(self.system.lag_count());
        self.system.set_lags(lags);
        let System { state, equations, moving, .. } = &mut *self.system;
        let now = &mut state.now;
        let (first, second) = states[..2 * moving.len()].split_at(moving.len());
        for (i, &c) in moving.iter().enumerate() {
            (now.q[c], now.v[c]) = (first[i], second[i]);
        }
        for (circuit, current) in equations.model.circuits.iter().zip(currents) {
            now.v[circuit.coordinate] = *current;
        }
        now.time_s = time_s;
        now.a.fill(0.0);
        now.auxiliary.fill(0.0);
        // at a kink, a step that ends there uses the values before it
        equations.branch_s = if time_s > state.start.time_s { 0.5 * (state.start.time_s + time_s) } else { time_s };
        equations.prescribe(time_s, &mut now.q, &mut now.v, &mut now.a);
        equations.project(&mut now.q, &mut now.v, &mut now.a);
        let off = moving.iter().zip(first).map(|(&c, given)| (now.q[c] - given).abs()).fold(0.0, f64::max);
        self.system.forget_outputs();
        off
    }

    /// Error for an element that the states compress through zero length, which is physically impossible. It is the first symptom of
    /// integration steps that are too long for the axial modes, the fastest ones of a model.
    pub(super) fn crushed(&self) -> Option<PlantError> {
        let System { state, equations, .. } = &*self.system;
        let strain = |element: &Element| element.strains::<STRAINS>(&state.now.q)[STRETCH];
        let element = equations.model.elements.iter().find(|element| strain(element) <= -1.0)?;
        let (time_s, place) = (state.now.time_s, self.system.place_of(element.coordinate));
        Some(PlantError::Crushed { time_s, place, strain: strain(element) })
    }

    /// Work of the inputs and dissipated energy up to the current time in J.
    pub fn accounts_j(&self) -> [f64; 2] {
        let now = &self.system.state.now;
        [now.work, now.dissipated]
    }

    /// Sets the energy accounts to the values integrated from their rates.
    pub fn set_accounts_j(&mut self, [work, dissipated]: [f64; 2]) {
        let now = &mut self.system.state.now;
        (now.work, now.dissipated) = (work, dissipated);
    }

    /// Computes the derivatives of the states at the current time, in O(n) by the mass matrix, and the rates of the energy accounts.
    pub fn derivatives(&mut self, derivatives: &mut [f64]) -> Result<AccountRates, PlantError> {
        let in_air = self.system.air.is_some();
        let System { equations, state, scratch, .. } = &mut *self.system;
        let now = &mut state.now;
        // starts from zero, so that repeated calls give identical bits
        now.a.fill(0.0);
        now.auxiliary.fill(0.0);
        equations.prescribe(now.time_s, &mut now.q, &mut now.v, &mut now.a);
        equations.project(&mut now.q, &mut now.v, &mut now.a);
        if in_air {
            self.system.settle_in_air()?;
        } else {
            equations.residual(now.time_s, &now.q, &now.v, &now.a, &mut scratch[0]);
            let jump = settle(equations, &mut scratch[0], now);
            self.system.accelerations(self.time_s(), jump)?;
        }
        let now = &self.system.state.now;
        self.copy_to(derivatives, &now.v, &now.a);
        self.copy_others(derivatives, self.air().map_or(&[], |air| air.lag_rates()), &now.a);
        Ok(AccountRates { dissipated_w: now.powers.dissipated, work_w: now.powers.work })
    }

    /// Number of event indicators.
    pub fn indicators(&self) -> usize {
        self.system.equations.forces.indicators().count()
    }

    /// Reads the event indicators at the current time, in rad or m: an event occurs when one falls through zero. Indicators that cannot be
    /// crossed are 1.
    pub fn read_indicators(&self, indicators: &mut [f64]) {
        let State { start, now, joints, .. } = &self.system.state;
        let forces = &self.system.equations.forces;
        for (value, indicator) in indicators.iter_mut().zip(forces.indicators()) {
            let armed = forces.is_armed(indicator, start, joints);
            let distance = if armed { forces.distance(indicator, start, now, joints).0 } else { 1.0 };
            *value = if distance.is_finite() { distance } else { 1.0 };
        }
    }

    /// Whether some indicator has fallen to zero at the current time, to the accuracy of the location of crossings; `crossed` is called
    /// with the index of each.
    pub fn arrived(&self, mut crossed: impl FnMut(usize)) -> bool {
        let State { start, now, joints, .. } = &self.system.state;
        let forces = &self.system.equations.forces;
        let mut any = false;
        for (number, indicator) in forces.indicators().enumerate() {
            let (distance, closing) = forces.distance(indicator, start, now, joints);
            if forces.is_armed(indicator, start, joints) && distance <= CROSSING_S * closing {
                crossed(number);
                any = true;
            }
        }
        any
    }

    /// Number of limits: two for each motor. A motor within its limits has a positive distance from both, in N·m; at a limit its torque has
    /// a kink, but neither a jump nor a discrete state.
    pub fn limits(&self) -> usize {
        2 * self.system.equations.forces.joints().iter().filter(|joint| joint.motor().is_some()).count()
    }

    /// Reads the distances of the motor torques from their limits at the current time, in N·m; 1 without a limit.
    pub fn read_limits(&self, distances: &mut [f64]) {
        let System { state, equations, .. } = &*self.system;
        let now = &state.now;
        let motors = equations.forces.joints().iter().filter_map(|joint| Some((joint.coordinate, joint.motor()?)));
        for (pair, (c, motor)) in distances.chunks_exact_mut(2).zip(motors) {
            pair.copy_from_slice(&motor.limit_distances_n_m(now.time_s, now.q[c], now.v[c]));
        }
    }

    /// Number of annuli of rotors whose loads can jump with their momentum balance: none with dynamic inflow.
    pub fn switches(&self) -> usize {
        self.system.switch_count()
    }

    /// Reads the distances of these annuli from their jumps in the last [`Hybrid::derivatives`], eq. (W24). Induced
    /// velocities and loads jump with a change of the sign; the states do not.
    pub fn read_switches(&self, distances: &mut [f64]) {
        if let Some(air) = &self.system.air {
            air.model.read_switches(true, distances);
        }
    }

    /// Applies the continuous inputs and tunable parameters from the current time on. Switches, rate limits, and commands subject to a rate
    /// limit are applied by [`Hybrid::transition`], because they change discrete states. The work of moving commands and gravity on
    /// potentials, and of changed stiffness, is not booked.
    pub fn follow_inputs(&mut self) {
        let system = &mut *self.system;
        if !system.inputs_may_differ {
            return;
        }
        let State { parameters, applied_parameters, .. } = &mut system.state;
        for (own, set) in applied_parameters.joints_mut().iter_mut().zip(parameters.joints()) {
            *own = JointParameters { rate_limit_rad_s: own.rate_limit_rad_s, ..*set };
        }
        applied_parameters.spatial_mut().copy_from_slice(parameters.spatial());
        applied_parameters.bodies_mut().copy_from_slice(parameters.bodies());
        *applied_parameters.air_density_kg_m3_mut() = parameters.air_density_kg_m3();
        let State { inputs, applied_inputs: applied, applied_from_s, joints, now, .. } = &mut system.state;
        for ((own, set), memory) in applied.joints_mut().iter_mut().zip(inputs.joints()).zip(joints) {
            own.torque_n_m = set.torque_n_m;
            if memory.slew.follows_at_once() {
                own.command_rad = set.command_rad;
                memory.slew.redirect(now.time_s, set.command_rad, 0.0, memory.slew.rate_limit_rad_s);
                memory.slew.from_rad = set.command_rad;
            }
        }
        applied.stations_mut().copy_from_slice(inputs.stations());
        applied.flaps_mut().copy_from_slice(inputs.flaps());
        applied.dc_motors_mut().copy_from_slice(inputs.dc_motors());
        *applied.root_mut() = *inputs.root();
        *applied.wind_m_s_mut() = *inputs.wind_m_s();
        *applied_from_s = now.time_s;
        system.inputs_may_differ = system.inputs_changed();
        system.configure();
        system.forget_outputs();
    }

    /// Time in s of the next time event after the current time: end of a slew, knot of a prescribed motion.
    pub fn next_kink_s(&self) -> f64 {
        self.system.equations.next_kink_s(self.time_s())
    }

    /// Ends a step of the external integrator at the current time: redundant parameters are projected onto their constraints, and the
    /// motion of indicators is measured from here.
    pub fn complete(&mut self) {
        let State { before, start, ahead, now, .. } = &mut self.system.state;
        [before, start, ahead].into_iter().for_each(|point| point.copy_from(now));
        self.system.remember_attitudes();
    }

    /// Performs the transitions of the indicators that the caller has found crossed at the current time, passes a kink at this time, and
    /// applies changed inputs and parameters. The states may jump, so the caller must read them again.
    pub fn transition(&mut self, crossed: &[usize]) -> Result<Jump, PlantError> {
        let system = &mut *self.system;
        for joint in &mut system.state.joints {
            joint.crossed = 0;
        }
        for &number in crossed {
            if let Some(indicator) = system.equations.forces.indicators().nth(number) {
                system.state.joints[indicator.joint].crossed |= 1 << indicator.number;
            }
        }
        let before = (system.state.now.dissipated, system.state.now.work);
        self.complete();
        let system = &mut *self.system;
        system.begin.copy_from(&system.state);
        let changed = system.inputs_changed();
        let outcome = if changed { system.apply_inputs() } else { Ok(()) }.and_then(|()| system.apply_events());
        if let Err(error) = outcome {
            system.go_back_to_begin();
            return Err(error);
        }
        system.inputs_may_differ = false;
        let State { start, now, .. } = &mut system.state;
        now.copy_from(start);
        let jump = Jump { dissipated_j: now.dissipated - before.0, work_j: now.work - before.1 };
        system.forget_outputs();
        Ok(jump)
    }

    /// Outputs at the current time; derivatives must have been evaluated.
    pub fn outputs(&mut self) -> &Outputs {
        self.system.provide(OutputSet::ALL);
        &self.system.outputs
    }

    /// The underlying system, for access to its inputs and parameters.
    pub fn system_mut(&mut self) -> &mut System {
        self.system
    }
}

#[cfg(test)]
mod tests {
    use crate::machine::{AttachedMass, Body, Joint, Machine};
    use crate::run::Plant;
    use nalgebra::Matrix3;
    use std::sync::Arc;

    /// Attitudes are stored at the end of each step of an external integrator: over two revolutions of a hinge no quaternion changes its
    /// sign from one step to the next, and the last one is at the current time.
    #[test]
    fn attitudes_are_remembered_at_the_end_of_each_step() {
        let mass = AttachedMass { inertia_kg_m2: Matrix3::identity(), ..AttachedMass::point("mass", 0.0, 1.0) };
        let machine = Machine::builder("Turning")
            .body(Body::rigid("arm"), Joint::revolute("hinge", [0.0, 0.6, 0.8]))
            .mass("arm", mass)
            .step_s(0.01)
            .build()
            .unwrap_or_else(|refused| panic!("{refused}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let mut hybrid = plant.hybrid().unwrap_or_else(|refused| panic!("{refused}"));
        let mut derivatives = vec![0.0; hybrid.states()];
        let mut last = hybrid.system_mut().state.tip_rotations[0];
        for step in 1..=26 {
            let angle_rad = 0.5 * f64::from(step);
            hybrid.set(0.01 * f64::from(step), &[angle_rad, 0.0]);
            hybrid.derivatives(&mut derivatives).unwrap_or_else(|error| panic!("{error}"));
            hybrid.complete();
            let now = hybrid.system_mut().state.tip_rotations[0];
            // the angle between the two quaternions is half the rotation of the step
            let cosine = now.coords.dot(&last.coords);
            assert!((cosine - 0.25_f64.cos()).abs() < 1e-12, "at {angle_rad} rad: {cosine}");
            last = now;
        }
    }
}
