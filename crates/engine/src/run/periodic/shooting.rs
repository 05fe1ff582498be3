//! Periodic states by shooting: Newton's method with products of the monodromy matrix, NOTATION eqs. (L32) and (L33).

use crate::aero::memory::Measure;
use crate::force::memory::JointMemory;
use crate::machine::Machine;
use crate::run::Plant;
use crate::run::periodic::turn::{SAMPLES, Turn};
use crate::solve::EquationsOfMotion;
use crate::solve::krylov::Directions;
use crate::system::air::{AirCoupling, AirHistory};
use crate::system::events::settle;
use crate::system::outputs::OutputSet;
use crate::system::state::State;
use crate::system::{PlantError, Snapshot, System};
use nalgebra::DVector;
use std::sync::Arc;

/// Difference step for a product, in scaled states.
const PRODUCT_STEP: f64 = 1e-5;
/// Fraction of the distance that may remain after solving the linear equations of a Newton step.
const LINEAR_SHARE: f64 = 1e-3;
/// Remaining linear error as a fraction of the accuracy, if that is larger; the rest is left for nonlinear terms.
const ENOUGH: f64 = 0.2;
/// Maximum number of products with the monodromy matrix.
const MAXIMUM_PRODUCTS: usize = 300;
/// Maximum number of Newton steps, and of revolutions marched in place of a Newton step that does not converge.
const MAXIMUM_STEPS: usize = 40;
const MAXIMUM_TURNS: usize = 12;
/// Largest Newton step, in rad or divided by the model's length.
const LONGEST: f64 = 0.5;
/// Maximum number of halvings of a step that does not reduce the distance.
const HALVINGS: usize = 5;
/// Ratio of the distances after and before a Newton step above which the products are too inaccurate, because they belong to another
/// revolution.
const SLOW: f64 = 0.3;

/// A state that is periodic over a revolution of the shaft.
#[derive(Debug, Clone)]
pub struct PeriodicMotion {
    /// State at the start of the revolution.
    pub start: Snapshot,
    /// Number of states of the search: degrees of freedom, their rates, and the aerodynamic memories.
    pub states: usize,
    /// Difference between the ends of the revolution: rotation in rad or displacement divided by the model's length, rates also divided
    /// by the shaft speed.
    pub distance: f64,
    /// Number of Newton steps.
    pub newton_steps: usize,
    /// Number of revolutions marched.
    pub turns: usize,
}

/// A periodic motion of a similar model, with the products of its search: the start of the next search.
#[derive(Debug, Clone)]
pub struct NearbyMotion {
    states: DVector<f64>,
    weights: DVector<f64>,
    known: Directions,
    /// Aerodynamic quantities that are not among the states.
    air: Option<AirHistory>,
    /// Difference from the previous motion to this one.
    difference: Option<DVector<f64>>,
    /// Fraction of that difference by which the start of the next search is extrapolated.
    share: f64,
}

impl NearbyMotion {
    /// Extrapolates the start of the next search by a fraction of the difference between the previous motion and this one, for motions that
    /// vary linearly, for example over equidistant pitch angles.
    pub fn go_on(&mut self, share: f64) {
        self.share = share;
    }

    /// States at the start of the next search.
    fn begin(&self) -> DVector<f64> {
        match &self.difference {
            Some(difference) if self.share != 0.0 => &self.states + difference * self.share,
            _ => self.states.clone(),
        }
    }
}

/// Function that is called with the plant at every sample of a revolution.
pub type Seen<'s> = dyn FnMut(usize, &mut Plant) -> Result<(), PlantError> + 's;

/// The revolution as a function of the state at its start.
pub(super) struct Shooting<'p> {
    pub plant: &'p mut Plant,
    pub turn: Turn,
    /// Coordinates of the degrees of freedom, in the order of [`crate::system::System::freedoms`].
    pub free: Vec<usize>,
    /// A state at the start of the revolution, including the parts that are not among the states of the search.
    base: State,
    /// Scales of the states: rotation in rad, displacement divided by the model's length; rates also divided by the shaft speed.
    weights: DVector<f64>,
    begin_s: f64,
    pub turns: usize,
    /// Called in every revolution that may be the final one.
    pub seen: Option<&'p mut Seen<'p>>,
    /// Steps of the marches for products, if they are longer than those of the revolution.
    long: Option<Steps>,
}

/// Step sizes of marches.
struct Steps {
    machine: Arc<Machine>,
    /// Unused without aerodynamics.
    air_step_s: f64,
}

impl Steps {
    /// One step of structure and rotor aerodynamics in each sample of a revolution. Newton steps with this coarser revolution converge to
    /// the same motion, slightly more slowly; `None` if the model's steps are no shorter. The memories of strips are means over their
    /// steps, so that longer steps would give products of other states.
    fn long(machine: &Machine, turn: &Turn) -> Option<Self> {
        let step_s = turn.period_s() / SAMPLES as f64;
        let shorter = |own_s: f64| own_s < step_s * (1.0 - 1e-9);
        let mut machine = machine.clone();
        let air = match &mut machine.air {
            None => false,
            Some(air) if air.is_rotor() => shorter(std::mem::replace(&mut air.step_s, step_s)),
            Some(_) => return None,
        };
        let structure = machine.solver.fixed_step_s.replace(step_s).is_some_and(shorter);
        (air || structure).then(|| Self { machine: Arc::new(machine), air_step_s: step_s })
    }
}

impl<'p> Shooting<'p> {
    /// Starts from the current state of an initialised plant, at the start of the revolution.
    pub fn new(plant: &'p mut Plant, turn: Turn) -> Self {
        let free: Vec<usize> = plant.system.freedoms().iter().map(|freedom| freedom.index).collect();
        let mut base = plant.system.state.clone();
        let begin_s = base.now.time_s;
        let equations = &mut plant.system.equations;
        let mut unused = vec![0.0; base.now.q.len()];
        equations.residual(begin_s, &base.now.q, &base.now.v, &base.now.a, &mut unused);
        let mut unit = vec![0.0; base.now.q.len()];
        let mut sizes = Vec::new();
        for &c in &free {
            unit[c] = 1.0;
            sizes.push(equations.norm(&unit).max(f64::MIN_POSITIVE));
            unit[c] = 0.0;
        }
        let speed_rad_s = turn.speed_rad_s.abs();
        let rates: Vec<f64> = sizes.iter().map(|size| size / speed_rad_s).collect();
        sizes.extend(rates);
        let tip_m_s = equations.model.reference_length_m * speed_rad_s;
        let measure = |(measure, _): (Measure, &mut f64)| match measure {
            Measure::Velocity => 1.0 / tip_m_s,
            Measure::Rate => 1.0 / speed_rad_s,
            Measure::Number => 1.0,
        };
        sizes.extend(memories(plant.system.air.as_deref(), &mut base.air).into_iter().map(measure));
        let long = Steps::long(&plant.system.machine, &turn);
        Self { plant, turn, free, base, weights: DVector::from_vec(sizes), begin_s, turns: 0, seen: None, long }
    }

    /// Number of states.
    pub fn states(&self) -> usize {
        self.weights.len()
    }

    /// Scales the coordinates of a stiff body by the rate that follows a release from a deflection, if that is larger than the deflection:
    /// `frequencies_rad_s` are those of each coordinate alone.
    pub fn stiffen(&mut self, frequencies_rad_s: &[f64]) {
        for (weight, frequency_rad_s) in self.weights.iter_mut().zip(frequencies_rad_s) {
            *weight *= (frequency_rad_s / self.turn.speed_rad_s.abs()).max(1.0);
        }
    }

    /// The scaled states of the search, from a state of the system.
    fn measured(&self, state: &mut State) -> DVector<f64> {
        let now = &state.now;
        let mut list: Vec<f64> = self.free.iter().map(|&c| now.q[c]).collect();
        list.extend(self.free.iter().map(|&c| now.v[c]));
        list.extend(memories(self.plant.system.air.as_deref(), &mut state.air).into_iter().map(|(_, memory)| *memory));
        DVector::from_vec(list).component_mul(&self.weights)
    }

    /// The states at the start of the revolution.
    pub fn at_begin(&self) -> DVector<f64> {
        self.measured(&mut self.base.clone())
    }

    /// Sets the plant to the start of the revolution with given states.
    fn begin(&mut self, states: &DVector<f64>) -> Result<(), PlantError> {
        let states = states.component_div(&self.weights);
        let (n, system) = (self.free.len(), &mut self.plant.system);
        system.state.copy_from(&self.base);
        if let (Some(history), Some(air)) = (&mut system.state.air, &system.air) {
            // the end of the current step is the start of the revolution, for any step length
            history.start_s = self.begin_s - history.steps as f64 * air.settings.step_s;
        }
        for (i, &c) in self.free.iter().enumerate() {
            (system.state.now.q[c], system.state.now.v[c]) = (states[i], states[n + i]);
        }
        let memories = memories(system.air.as_deref(), &mut system.state.air);
        memories.into_iter().zip(states.iter().skip(2 * n)).for_each(|((_, memory), value)| *memory = *value);
        system.configure();
        let begin_s = self.begin_s;
        let now = &mut system.state.now;
        now.a.fill(0.0);
        now.auxiliary.fill(0.0);
        system.equations.branch_s = begin_s;
        system.equations.prescribe(begin_s, &mut now.q, &mut now.v, &mut now.a);
        system.equations.residual(begin_s, &now.q, &now.v, &now.a, &mut system.scratch[0]);
        system.refresh_air(begin_s)?;
        let now = &mut system.state.now;
        system.equations.residual(begin_s, &now.q, &now.v, &now.a, &mut system.scratch[0]);
        let jump = settle(&mut system.equations, &mut system.scratch[0], now);
        system.accelerations(begin_s, jump)?;
        let State { before, start, ahead, now, .. } = &mut system.state;
        [before, start, ahead].into_iter().for_each(|point| point.copy_from(now));
        system.forget_outputs();
        Ok(())
    }

    /// Marches a revolution from given states and returns those at its end; `seen` is called with the plant at the start of every sample,
    /// from 0, and at the end of the revolution.
    pub fn march(&mut self, states: &DVector<f64>, seen: &mut Seen<'_>) -> Result<DVector<f64>, PlantError> {
        self.begin(states)?;
        self.turns += 1;
        let period_s = self.turn.period_s();
        for sample in 0..=SAMPLES {
            if sample > 0 {
                self.plant.step(self.begin_s + period_s * sample as f64 / SAMPLES as f64)?;
                self.check_memory()?;
            }
            seen(sample, self.plant)?;
        }
        let mut state = std::mem::replace(&mut self.plant.system.state, self.base.clone());
        let end = self.measured(&mut state);
        self.plant.system.state = state;
        Ok(end)
    }

    /// Marches a revolution with the steps for products, and without energy accounts.
    fn march_long(&mut self, states: &DVector<f64>) -> Result<DVector<f64>, PlantError> {
        let booked = std::mem::replace(&mut self.plant.system.equations.booked, false);
        self.exchange_steps();
        let end = self.march(states, &mut |_, _| Ok(()));
        self.exchange_steps();
        self.plant.system.equations.booked = booked;
        end
    }

    /// Exchanges the steps of the revolution and those for products.
    fn exchange_steps(&mut self) {
        let (Some(long), System { machine, air, .. }) = (&mut self.long, &mut self.plant.system) else { return };
        std::mem::swap(machine, &mut long.machine);
        if let Some(air) = air {
            std::mem::swap(&mut air.settings.step_s, &mut long.air_step_s);
        }
    }

    /// Discards products that did not reduce the distance: first those of another motion, then those of long steps.
    fn forget(&mut self, known: &mut Directions, of_another: &mut bool) {
        known.clear();
        if !std::mem::take(of_another) {
            self.long = None;
        }
    }

    /// Returns an error for events of joint forces within the revolution.
    fn check_memory(&self) -> Result<(), PlantError> {
        let quiet = |memory: &JointMemory| JointMemory { crossed: 0, ..*memory };
        let System { machine, state, .. } = &self.plant.system;
        for ((body, _), (now, before)) in machine.one_freedoms().zip(state.joints.iter().zip(&self.base.joints)) {
            if quiet(now) != quiet(before) {
                let name = &machine.bodies[body].joint.name;
                return Err(self.refused(format!(
                    "the joint {name} reaches its latch, its end stops or a brake at t = {} s, within the revolution; \
                     only motions without such \
                     events are supported: open the latch or widen the end stops",
                    state.now.time_s
                )));
            }
        }
        Ok(())
    }

    fn refused(&self, cause: String) -> PlantError {
        PlantError::Periodic { time_s: self.begin_s, cause }
    }

    /// Takes over the (aerodynamic) quantities that are not among the states from the end of a revolution to the start of the next.
    fn carry(&mut self, left: Option<AirHistory>) {
        let period_s = self.turn.period_s();
        if let Some(mut air) = left {
            air.shift(-period_s);
            self.base.air = Some(air);
        }
    }

    /// Distance of two states: the largest of the distances of coordinates, rates, and aerodynamic lag states.
    fn distance(&mut self, difference: &DVector<f64>) -> f64 {
        let plain = difference.component_div(&self.weights);
        let n = self.free.len();
        let speed_rad_s = self.turn.speed_rad_s.abs();
        let equations = &mut self.plant.system.equations;
        let mut largest = difference.iter().skip(2 * n).fold(0.0f64, |largest, x| largest.max(x.abs()));
        for (first, scale) in [(0, 1.0), (n, 1.0 / speed_rad_s)] {
            let mut change = vec![0.0; equations.model.coordinates];
            self.free.iter().enumerate().for_each(|(i, &c)| change[c] = plain[first + i]);
            let size = scale * equations.norm(&change);
            largest = if size.is_nan() { f64::INFINITY } else { largest.max(size) };
        }
        largest
    }

    /// Marches a revolution from given states; returns it with the final aerodynamic state and its distance. Energies are booked only if
    /// the plant watches their accounts.
    fn attempt(&mut self, states: DVector<f64>) -> Result<Attempt, PlantError> {
        let mut seen = self.seen.take();
        let watches_accounts = self.plant.system.watched.contains(OutputSet::ACCOUNTS);
        let booked = std::mem::replace(&mut self.plant.system.equations.booked, watches_accounts);
        let end = match &mut seen {
            Some(seen) => self.march(&states, &mut **seen),
            None => self.march(&states, &mut |_, _| Ok(())),
        };
        self.plant.system.equations.booked = booked;
        self.seen = seen;
        let end = end?;
        let left = self.plant.system.state.air.clone();
        let distance = self.distance(&(&end - &states));
        Ok(Attempt { states, end, left, distance: if distance.is_nan() { f64::INFINITY } else { distance } })
    }

    /// Finds a revolution that is periodic to `accuracy`, eq. (L33).
    pub fn close(&mut self, accuracy: f64) -> Result<PeriodicMotion, PlantError> {
        self.close_beside(accuracy, &mut None)
    }

    /// Finds a periodic revolution starting from the motion `nearby` with its products, if that has the same number of states and its
    /// revolution starts within the length of a Newton step from its end; `nearby` is replaced by the motion found.
    pub fn close_beside(
        &mut self,
        accuracy: f64,
        nearby: &mut Option<NearbyMotion>,
    ) -> Result<PeriodicMotion, PlantError> {
        let (mut known, mut of_another) = (Directions::default(), false);
        let (mut newton_steps, mut marched) = (0, 0);
        let own = (self.weights.clone(), self.base.air.clone());
        let mut before = None;
        let begun = match nearby.take().filter(|near| near.weights.len() == own.0.len()) {
            Some(near) => {
                let states = near.begin();
                (self.weights, self.base.air) = (near.weights, near.air);
                match self.attempt(states) {
                    Ok(attempt) if attempt.distance < LONGEST => {
                        (known, of_another, before) = (near.known, true, Some(near.states));
                        Some(attempt)
                    }
                    _ => None,
                }
            }
            None => None,
        };
        let mut present = match begun {
            Some(attempt) => attempt,
            None => {
                (self.weights, self.base.air) = own;
                self.attempt(self.at_begin())?
            }
        };
        let mut nearest = present.distance;
        while present.distance > accuracy {
            if newton_steps + marched == MAXIMUM_STEPS {
                return Err(self.no_contraction(nearest, accuracy));
            }
            let fresh = known.products() == 0;
            match self.nearer(&present, accuracy, &mut known)? {
                Some(mut next) => {
                    if next.distance > SLOW * present.distance {
                        self.forget(&mut known, &mut of_another);
                    }
                    newton_steps += 1;
                    // the aerodynamic quantities that are not among the states have changed too
                    let left = next.left.take();
                    let carries = left.is_some();
                    self.carry(left);
                    present = next;
                    if carries && present.distance <= accuracy {
                        let right = &present.end - &present.states;
                        let none = |_: &DVector<f64>| -> Result<DVector<f64>, PlantError> { Ok(right.clone()) };
                        let (change, _) = known.solve(&right, LINEAR_SHARE, 0, none)?;
                        present = self.attempt(&present.states + change)?;
                    }
                }
                None if !fresh || self.long.is_some() => self.forget(&mut known, &mut of_another),
                None if marched < MAXIMUM_TURNS => {
                    // a further revolution is marched: decaying motions converge by themselves
                    known.clear();
                    self.carry(present.left.take());
                    present = self.attempt(present.end)?;
                    marched += 1;
                }
                None => return Err(self.no_contraction(nearest, accuracy)),
            }
            nearest = nearest.min(present.distance);
        }
        let Attempt { states, distance, .. } = present;
        self.begin(&states)?;
        let difference = before.map(|before| &states - before);
        let (weights, air) = (self.weights.clone(), self.base.air.clone());
        *nearby = Some(NearbyMotion { states, weights, known, air, difference, share: 0.0 });
        let (states, turns) = (self.states(), self.turns);
        Ok(PeriodicMotion { start: self.plant.snapshot(), states, distance, newton_steps, turns })
    }

    /// A Newton step, shortened until the distance decreases; `None` if it does not decrease. Its linear equations are solved only as
    /// accurately as `accuracy` requires.
    fn nearer(
        &mut self,
        present: &Attempt,
        accuracy: f64,
        known: &mut Directions,
    ) -> Result<Option<Attempt>, PlantError> {
        let Attempt { states, end, distance, .. } = present;
        let mut own_end = self.long.is_none().then(|| end.clone());
        let mut product = |direction: &DVector<f64>| -> Result<DVector<f64>, PlantError> {
            let own_end = match &own_end {
                Some(end) => end,
                None => own_end.insert(self.march_long(states)?),
            };
            Ok((self.march_long(&(states + direction * PRODUCT_STEP))? - own_end) / PRODUCT_STEP)
        };
        let left = LINEAR_SHARE.max(ENOUGH * accuracy / distance);
        let change = match known.solve(&(end - states), left, MAXIMUM_PRODUCTS, &mut product) {
            Ok((change, _)) => change,
            // the final revolution does not use the longer steps
            Err(_) if self.long.is_some() => return Ok(None),
            Err(error) => return Err(error),
        };
        let size = self.distance(&change);
        if !size.is_finite() {
            return Ok(None);
        }
        let mut share = (LONGEST / size).min(1.0);
        for _ in 0..=HALVINGS {
            // a march that fails starts too far from the solution
            if let Ok(next) = self.attempt(states + &change * share)
                && next.distance < *distance
            {
                return Ok(Some(next));
            }
            share *= 0.5;
        }
        Ok(None)
    }

    fn no_contraction(&self, nearest: f64, accuracy: f64) -> PlantError {
        self.refused(format!(
            "no periodic revolution of the shaft was found: in {} revolutions the smallest difference between start \
             and end is {nearest:.1e} (rotation in rad, or displacement divided by the model's length), \
             {accuracy:.1e} is required; check for undamped motions, start closer to the solution, use more steps per \
             revolution, or a larger tolerance",
            self.turns
        ))
    }
}

/// Aerodynamic memories.
fn memories<'h>(air: Option<&AirCoupling>, history: &'h mut Option<AirHistory>) -> Vec<(Measure, &'h mut f64)> {
    match (air, history) {
        (Some(air), Some(history)) => air.memories(history),
        _ => Vec::new(),
    }
}

/// A revolution that was marched.
struct Attempt {
    /// Scaled states at its start and at its end.
    states: DVector<f64>,
    end: DVector<f64>,
    /// Aerodynamic state at its end.
    left: Option<AirHistory>,
    distance: f64,
}
