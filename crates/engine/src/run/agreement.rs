//! Coupling of aerodynamics and structure: loads consistent with the motion at the end of every aerodynamic step.
//!
//! Aerodynamic steps have a fixed length from the start, independent of the caller's steps. Within a step the loads are constant and rotate
//! with the sections, NOTATION eq. (Q1): the mean of the circulatory loads at its ends, and the mean rate of the fluid's impulse. The loads
//! at the end follow from trial marches of the structure to it, eq. (Q2), after which the structure is rolled back and marched once more.
//! Vibrations that the steps cannot resolve must not gain energy from the loads: the aerodynamic model therefore uses velocities consistent
//! with the displacements over the steps, eq. (Q4), not instantaneous ones.

use crate::aero::flow::{AirPath, Flow};
use crate::force::Outcome;
use crate::force::memory::JointMemory;
use crate::machine::Coupling;
use crate::run::Plant;
use crate::run::march::even_step;
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use crate::system::air::start::{flow, refusal};
use crate::system::air::{AirCoupling, AirHistory, Gain, Sample, StepLoads, gaps};
use crate::system::failure_memory::FailureMemory;
use crate::system::state::State;
use crate::system::{PlantError, Statistics, System};
use nalgebra::Vector3;

/// Fraction of an aerodynamic step below which the rest of it is round-off.
const SLIVER: f64 = 1e-9;
/// Round-off of the caller's clock, relative to its time: that of a sum of 10⁵ steps.
const CLOCK_ROUND_OFF: f64 = 1e-11;
/// Fraction of the coupling's tolerance by which the residual error of Newton's iteration in a trial march may change the loads.
const MOTION_SHARE: f64 = 0.1;
/// Smallest displacement error in the kinematic norm that is required of Newton's iteration: a thousand times the round-off of angles,
/// since its last corrections are a hundred times the remaining error.
const MINIMUM_MOTION_TOLERANCE: f64 = 1e-12;

/// Number of consecutive aerodynamic steps in which the load prediction of the staggered coupling may be off by more than the largest load
/// of the run: if this continues, loads without prediction would be more accurate, and the error grows with each step. A start with small
/// loads has two or three such steps.
const MAXIMUM_STRAYED: u32 = 4;
/// Bounds on the contraction of the load changes per trial: it is assumed to continue only up to the first, and never to be faster than the
/// second, because other directions follow.
const MAXIMUM_RATE: f64 = 0.1;
const MINIMUM_RATE: f64 = 0.02;
/// Fraction of the tolerance below which the next change is predicted instead of computed.
const LEFT_SHARE: f64 = 0.2;
/// Smallest tolerance for which changes are predicted: smaller tolerances are set to compare solutions, which requires true convergence.
const MINIMUM_FORESIGHT: f64 = 1e-5;
/// Growth of the structural steps relative to the time since a jump of the accelerations: steps by the error estimate, which resolve the
/// fast modes excited by an impact until they are damped, may grow by a factor of 3 per step and soon need no bound.
const GROWTH_AFTER_JUMP: f64 = 0.2;
/// Error text for a diverging staggered coupling.
const STAGGERED_DIVERGES: &str = "coupling = \"staggered\" diverges: in 4 consecutive aerodynamic steps the prediction \
                                  error of the loads exceeded the largest load of the run: one correction per step is \
                                  unstable for this ratio of apparent to structural mass; write coupling = \"iterated\"";

/// Error text for loads of a rotor that do not converge.
const JUMPS: &str = "; an annulus of the rotor may alternate between the windmill and the propeller brake state: write coupling = \"staggered\"";

/// Error text for loads of a slender body that do not converge.
const APPARENT: &str = "; the apparent mass of a slender body may exceed the mass of the structure that it moves: write apparent_mass = false \
                        for the slender body, or give the structure its mass";

/// Time in s by which the caller's clock may deviate from the end of an aerodynamic step.
fn round_off_s(time_s: f64, step_s: f64) -> f64 {
    SLIVER * step_s + CLOCK_ROUND_OFF * time_s.abs()
}

impl Plant {
    /// Whether `start` is at the end of an aerodynamic step and `time_s` is that end except for round-off of the caller's clock; `start` is
    /// then set to `time_s`. Outputs there belong to the step that ends, independently of the last bits of the clock.
    pub(crate) fn adopt_end_of_air_step(&mut self, time_s: f64) -> bool {
        let (Some(history), Some(air)) = (&self.system.state.air, &self.system.air) else { return false };
        let (end_s, round_off_s) = (history.loads.end_s, round_off_s(time_s, air.settings.step_s));
        let is_end =
            history.steps > 0 && self.system.state.start.time_s >= end_s - round_off_s && time_s <= end_s + round_off_s;
        if is_end {
            (self.system.state.start.time_s, self.system.state.ahead.time_s) = (time_s, time_s);
        }
        is_end
    }

    /// Starts the next aerodynamic step if the current one has ended.
    pub(crate) fn begin_air_step(&mut self) -> Result<(), PlantError> {
        if self.enter_air_step() { self.agree_on_loads() } else { Ok(()) }
    }

    /// Whether a trial march of the staggered coupling comes next: its next aerodynamic step starts.
    pub(crate) fn is_before_trial(&self) -> bool {
        let staggered = self.system.air.as_ref().is_some_and(|air| air.settings.coupling == Coupling::Staggered);
        staggered && self.air_step_is_over()
    }

    /// Whether the current aerodynamic step has ended.
    fn air_step_is_over(&self) -> bool {
        let (Some(history), Some(air)) = (&self.system.state.air, &self.system.air) else { return false };
        let time_s = self.system.state.start.time_s;
        time_s >= history.loads.end_s - round_off_s(time_s, air.settings.step_s)
    }

    /// Starts the next aerodynamic step if the current one has ended, up to its first trial march: returns the end of the step in s, with the
    /// structure at `start` and accelerations under the predicted loads.
    pub(crate) fn enter_trial(&mut self) -> Result<Option<f64>, PlantError> {
        if !self.enter_air_step() {
            return Ok(None);
        }
        let Some(rest) = self.begin_agreement() else { return Ok(None) };
        self.limit_newton();
        self.system.discontinuity(|_, _| Outcome::default())?;
        Ok(Some(rest.end_s))
    }

    /// Puts the aerodynamics at the start of the next step, with predicted loads, if the current one has ended; returns whether it has.
    fn enter_air_step(&mut self) -> bool {
        if !self.air_step_is_over() {
            return false;
        }
        let (Some(history), Some(air)) = (&mut self.system.state.air, &self.system.air) else { return false };
        let step_s = air.settings.step_s;
        history.before.copy_from(&history.after);
        history.begin.copy_from_slice(&history.end);
        let AirHistory { loads, at_begin, .. } = history;
        for (earlier, (from, to)) in at_begin.iter_mut().zip(loads.from.iter_mut().zip(&mut loads.to)) {
            *from = *to;
            if history.steps > 0 {
                to.force_n += to.force_n - earlier.force_n;
                to.moment_n_m += to.moment_n_m - earlier.moment_n_m;
            }
            *earlier = *from;
        }
        history.steps += 1;
        (history.carried_m, history.gain) = (Vector3::zeros(), Gain::default());
        loads.begin_s = self.system.state.start.time_s;
        loads.end_s = history.start_s + history.steps as f64 * step_s;
        true
    }

    /// Computes the loads for the rest of the current step again, after the inputs have changed within it.
    pub(crate) fn renew_air(&mut self) -> Result<(), PlantError> {
        if self.system.state.air.is_none() || self.air_step_is_over() { Ok(()) } else { self.agree_on_loads() }
    }

    /// Finds the loads at the end of the current aerodynamic step that are consistent with the motion there, NOTATION eq. (Q2). Leaves the
    /// structure at `start`, with accelerations under these loads.
    fn agree_on_loads(&mut self) -> Result<(), PlantError> {
        let Some(rest) = self.begin_agreement() else { return Ok(()) };
        let (mut change_n, mut before_n) = (Some(0.0), None);
        for trial in 0..rest.most_trials {
            change_n = self.try_loads(&rest, trial == 0, before_n)?;
            if change_n.is_none() {
                break;
            }
            before_n = change_n;
        }
        let System { air: Some(air), state, machine, .. } = &mut self.system else { return Ok(()) };
        if let Some(history) = &state.air {
            let row_panels = air.model.row_panels(&history.before, &history.after, &rest.path);
            let longest = &mut state.statistics.longest_row_panels;
            *longest = longest.max(row_panels);
            state.statistics.stalled_steps += u64::from(air.model.lags_beyond_stall(&history.after));
        }
        let RestOfStep { begin_s, end_s, most_trials, .. } = rest;
        if let Some(change_n) = change_n {
            let change = change_n / state.air.as_ref().map_or(1.0, |history| history.scale_n);
            let mut cause =
                format!("the loads still change by {change:.1e} of the largest load after {most_trials} iterations");
            if air.settings.rotors().next().is_some() {
                cause += JUMPS;
            }
            if air.settings.slender_bodies().any(|(_, body)| body.apparent_mass) {
                cause += APPARENT;
            }
            if let Some(surface) =
                gaps::blown_from_behind(&air.settings, &air.motions, &flow(&air.settings, state, end_s))
            {
                let body = &machine.bodies[air.settings.surfaces[surface].body].name;
                cause += &format!(
                    "; the relative flow reaches {body} at its trailing edge, where the wake must leave: turn \
                              the wind or the wing"
                );
            }
            return Err(refusal(begin_s, cause));
        }
        if let Some(error) = gaps::crossing(machine, &air.settings, &air.model, end_s) {
            return Err(error);
        }
        self.system.discontinuity(|_, _| Outcome::default()).map(|_| ())
    }

    /// Convects the wake to the end of the current aerodynamic step and stores the start of its trial marches; `None` without aerodynamics.
    fn begin_agreement(&mut self) -> Option<RestOfStep> {
        let System { air: Some(air), state, equations, machine, .. } = &mut self.system else { return None };
        let air = &mut **air;
        let history = state.air.as_ref()?;
        self.trial.save(state, equations.air.as_ref());
        let step_s = air.settings.step_s;
        let (begin_s, end_s) = (history.loads.begin_s, history.loads.end_s);
        // displacement of the wind over the whole step, and rotation of the root frame at the middle of the rest of the step: exact for
        // inputs that vary linearly from the step's start
        let middle_s = 0.5 * (begin_s + end_s);
        let displacement_m = history.carried_m + state.wind_at_m_s(middle_s) * (end_s - begin_s);
        let spin_rad_s = state.spin_at_rad_s(middle_s);
        let gain = history.gain.after(end_s - begin_s, state.applied_rates.wind_m_s());
        let carrying = Flow { wind_m_s: displacement_m / step_s, spin_rad_s, ..flow(&air.settings, state, end_s) };
        let path = AirPath::new(&carrying, step_s);
        let history = state.air.as_mut()?;
        air.model.convect(&history.before, &carrying, step_s, &mut history.after);
        air.read(&history.loads);
        air.acceleration.restart();
        let (tolerance, most_trials) = match air.settings.coupling {
            Coupling::Staggered => (f64::INFINITY, 1),
            Coupling::Iterated { tolerance, most_iterations } => (tolerance, most_iterations),
        };
        if let Some(fixed_s) = machine.solver.fixed_step_s {
            history.structure_step_s = even_step(end_s - begin_s, fixed_s);
        }
        Some(RestOfStep { begin_s, end_s, gain, path, tolerance, most_trials })
    }

    /// Marches the structure to the end of the step with the current guess of the loads, rolls it back, and solves for the loads due to
    /// that motion. Returns `None` if they agree with the guess, or if those of one more march would; otherwise returns their change in N
    /// and sets the next guess. `first`: the trial march determines the structural steps; `before_n`: change in the previous march.
    fn try_loads(&mut self, rest: &RestOfStep, first: bool, before_n: Option<f64>) -> Result<Option<f64>, PlantError> {
        let &RestOfStep { begin_s, end_s, ref gain, tolerance, .. } = rest;
        self.limit_newton();
        let booked = std::mem::replace(&mut self.system.equations.booked, false);
        let marched = self.march_on_trial(end_s, first);
        self.system.equations.booked = booked;
        let next_s = self.system.state.step_s;
        // if the error estimate required no step, the next one is the best guess
        let wanted_s = if self.smallest_step_s.is_finite() { self.smallest_step_s } else { next_s };
        let halved = self.system.state.statistics.failures > self.trial.statistics.failures;
        if marched.is_ok() {
            let System { air, state, equations, scratch, .. } = &mut self.system;
            let ahead = &state.ahead;
            equations.residual(end_s, &ahead.q, &ahead.v, &ahead.a, &mut scratch[0]);
            if let Some(air) = air {
                air.observe(equations, ahead);
            }
        }
        self.go_back();
        let System { air: Some(air), state, machine, .. } = &mut self.system else { return Ok(None) };
        let air = &mut **air;
        let Some(history) = &mut state.air else { return Ok(None) };
        let step_s = air.settings.step_s;
        let ends = history.begin.iter().zip(&mut history.end).zip(air.model.instants());
        for (motion, ((begin, end), &instant)) in air.motions.iter_mut().zip(ends) {
            *end = if instant { Sample::steady(motion) } else { begin.next(motion, step_s, gain) };
            *motion = end.motion;
        }
        if first && machine.solver.fixed_step_s.is_none() {
            history.structure_step_s = even_step(end_s - begin_s, wanted_s);
        } else if halved {
            // Newton's iteration has failed with these steps: all later marches use shorter ones, otherwise the loads at the end jump from
            // one trial to the next
            history.structure_step_s *= 0.5;
            air.acceleration.restart();
        }
        if first {
            self.trial.step_s = next_s;
        }
        state.step_s = self.trial.step_s;
        marched?;
        state.statistics.air_solutions += 1;
        let density_kg_m3 = state.applied_parameters.air_density_kg_m3();
        air.deflect(state, end_s)?;
        let AirCoupling { model, settings, motions, loads, .. } = &mut *air;
        let flow = flow(settings, state, end_s);
        let Some(history) = &mut state.air else { return Ok(None) };
        model
            .solve(&history.before, motions, &flow, step_s, &mut history.after, loads)
            .map_err(|error| gaps::failure(machine, settings, begin_s, error))?;
        let (change_n, size_n) = air.compare();
        if !change_n.is_finite() {
            return Err(refusal(begin_s, "the loads are not finite"));
        }
        history.scale_n = history.scale_n.max(size_n);
        if air.settings.coupling == Coupling::Staggered {
            history.strayed = if change_n > history.scale_n { history.strayed + 1 } else { 0 };
            if history.strayed >= MAXIMUM_STRAYED {
                return Err(refusal(begin_s, STAGGERED_DIVERGES));
            }
        }
        let bound_n = (tolerance * history.scale_n).max(air.round_off_n(density_kg_m3));
        // predicts the next change from the current contraction
        let rate = before_n.map_or(1.0, |before_n| (change_n / before_n).max(MINIMUM_RATE));
        let foreseen =
            tolerance >= MINIMUM_FORESIGHT && rate <= MAXIMUM_RATE && rate * change_n <= LEFT_SHARE * bound_n;
        let agreed = foreseen || change_n <= bound_n;
        if change_n <= bound_n {
            air.accept();
        } else {
            let AirCoupling { acceleration, guess, residual, .. } = &mut *air;
            acceleration.next(guess, residual);
        }
        air.write(&mut history.loads);
        Ok(if agreed { None } else { Some(change_n) })
    }

    /// Sets the tolerance of Newton's iteration in the trial marches such that its effect on the loads is negligible, eq. (Q2).
    fn limit_newton(&mut self) {
        let System { air: Some(air), state, equations, .. } = &mut self.system else { return };
        let density_kg_m3 = state.applied_parameters.air_density_kg_m3();
        let Some(history) = &mut state.air else { return };
        history.motion_tolerance = match air.settings.coupling {
            Coupling::Iterated { tolerance, .. } if history.scale_n > 0.0 => {
                let displacement_m = air.unnoticed_m(MOTION_SHARE * tolerance * history.scale_n, density_kg_m3);
                (displacement_m / equations.model.reference_length_m).max(MINIMUM_MOTION_TOLERANCE)
            }
            Coupling::Staggered | Coupling::Iterated { .. } => f64::INFINITY,
        };
    }

    /// Marches the structure to the end of the aerodynamic step under the current guess of the loads; `first`: with steps chosen by the
    /// error estimate.
    fn march_on_trial(&mut self, end_s: f64, first: bool) -> Result<(), PlantError> {
        self.system.discontinuity(|_, _| Outcome::default())?;
        self.smallest_step_s = f64::INFINITY;
        while self.system.state.ahead.time_s < end_s {
            let State { start, ahead, .. } = &mut self.system.state;
            start.copy_from(ahead);
            self.system.apply_events()?;
            match self.structure_step_s().filter(|_| !first || self.system.machine.solver.fixed_step_s.is_some()) {
                Some(step_s) => self.advance_fixed(step_s, end_s)?,
                None => self.advance(end_s)?,
            }
            self.loosen_bound_after_jump();
        }
        Ok(())
    }

    /// Structural step within the current aerodynamic step in s; `None` without aerodynamics.
    pub(crate) fn structure_step_s(&self) -> Option<f64> {
        let history = self.system.state.air.as_ref()?;
        Some(self.after_jump_s().map_or(history.structure_step_s, |bound_s| bound_s.min(history.structure_step_s)))
    }

    /// Bound in s on the structural steps after the last jump of the accelerations; `None` without a bound and for fixed steps.
    pub(crate) fn after_jump_s(&self) -> Option<f64> {
        let history = self.system.state.air.as_ref()?;
        (history.after_jump_s > 0.0 && self.system.machine.solver.fixed_step_s.is_none())
            .then_some(history.after_jump_s)
    }

    /// Increases the bound with the time since the jump, until it no longer has an effect.
    pub(crate) fn loosen_bound_after_jump(&mut self) {
        let max_step_s = self.system.state.applied_parameters.solver().max_step_s;
        let State { start, ahead, air: Some(history), .. } = &mut self.system.state else { return };
        if history.after_jump_s > 0.0 {
            history.after_jump_s += GROWTH_AFTER_JUMP * (ahead.time_s - start.time_s);
            if history.after_jump_s >= max_step_s {
                history.after_jump_s = 0.0;
            }
        }
    }

    /// Rolls back a trial march, but keeps its aerodynamic results.
    fn go_back(&mut self) {
        let (trial, system) = (&self.trial, &mut self.system);
        let Statistics { air_solutions, iterations, trial_iterations, .. } = system.state.statistics;
        let State { start, ahead, joints, failures, statistics, air, .. } = &mut system.state;
        start.copy_from(&trial.start);
        ahead.copy_from(&trial.start);
        joints.copy_from_slice(&trial.joints);
        if let Some(history) = air {
            history.after_jump_s = trial.after_jump_s;
        }
        failures.copy_from_slice(&trial.failures);
        *statistics = Statistics {
            air_solutions,
            trial_iterations: trial_iterations + iterations - trial.statistics.iterations,
            ..trial.statistics
        };
        system.configure();
        if let Some(loads) = &mut system.equations.air {
            loads.copy_from(&trial.loads);
        }
    }
}

/// Rest of an aerodynamic step.
struct RestOfStep {
    begin_s: f64,
    end_s: f64,
    /// Change of the wind since the start of the step.
    gain: Gain,
    /// Displacement of the air over the whole step.
    path: AirPath,
    /// Change of the loads, relative to the largest load, at which the iteration has converged.
    tolerance: f64,
    most_trials: usize,
}

/// State at the start of the trial marches of an aerodynamic step, for rollback; the memory of sliding joints contains the elements of their
/// carriages, NOTATION eq. (J19).
pub(super) struct Trial {
    start: Point,
    step_s: f64,
    after_jump_s: f64,
    joints: Vec<JointMemory>,
    failures: Vec<FailureMemory>,
    statistics: Statistics,
    loads: StepLoads,
}

impl Trial {
    /// Allocates memory for the trial marches of a system.
    pub fn new(system: &System) -> Self {
        let sections = system.equations.stations.len() - system.equations.load_stations;
        Self {
            start: Point::zeros(system.coordinates()),
            step_s: 0.0,
            after_jump_s: 0.0,
            joints: Vec::with_capacity(system.machine.bodies.len()),
            failures: Vec::with_capacity(system.machine.failures.len()),
            statistics: Statistics::default(),
            loads: StepLoads::none(sections),
        }
    }

    /// Stores the start of a trial march. `loads`: the loads that correspond to its accelerations.
    fn save(&mut self, state: &State, loads: Option<&StepLoads>) {
        self.start.copy_from(&state.start);
        self.joints.clone_from(&state.joints);
        self.failures.clone_from(&state.failures);
        (self.step_s, self.statistics) = (state.step_s, state.statistics);
        self.after_jump_s = state.air.as_ref().map_or(0.0, |history| history.after_jump_s);
        if let Some(loads) = loads {
            self.loads.copy_from(loads);
        }
    }
}
