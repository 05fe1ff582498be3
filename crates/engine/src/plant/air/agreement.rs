//! Air and structure: loads that agree with the motion at the end of every aerodynamic step.
//!
//! Aerodynamic steps have a fixed length from the start on, whatever the caller's steps are. Within one the loads are
//! constant and turn with the sections, NOTATION eq. (Q1): the mean of the circulatory ones at its ends, and the mean rate
//! of the fluid's impulse. Those at the end follow from trial marches of the structure to it, eq. (Q2), after which the
//! structure goes back and marches for good. What vibrates faster than the steps can follow must not gain energy from
//! them: the air sees velocities that belong to the displacements over the steps, eq. (Q4), not those of the instants.

use crate::aero::flow::{AirPath, Flow};
use crate::force::Outcome;
use crate::machine::{self, Coupling};
use crate::plant::Plant;
use crate::plant::air::{AirCoupling, AirHistory, Gain, Sample, StepLoads, Trial, gaps};
use crate::plant::face::PlantError;
use crate::plant::march::even_step;
use crate::plant::state::State;
use crate::plant::statics::Holding;
use crate::solve::EquationsOfMotion;
use crate::solve::equilibrium::Effort;
use nalgebra::Vector3;

/// Share of an aerodynamic step below which the rest of it is round-off.
const SLIVER: f64 = 1e-9;
/// Round-off of the caller's clock, relative to its time: that of 10⁵ steps summed up.
const CLOCK_ROUND_OFF: f64 = 1e-11;
/// Most iterations between air and structure at rest.
const MOST_STATIC_ITERATIONS: usize = 100;
/// Change of the loads at rest, relative to the largest, at which they agree: far above the statics' own error.
const STATIC_TOLERANCE: f64 = 1e-9;

/// Share of the coupling's tolerance that the loads may move by what Newton's iteration leaves in a trial march.
const MOTION_SHARE: f64 = 0.1;
/// Smallest displacement error in the kinematic norm that Newton's iteration is asked for: a thousand times the round-off
/// of angles, since its last corrections are a hundred times what they leave.
const LEAST_MOTION_TOLERANCE: f64 = 1e-12;

/// Aerodynamic steps in a row in which the prediction of the staggered coupling may miss the loads by more than the largest
/// of the run: where it does so on and on, no prediction at all would be nearer, and each step makes it worse. A start
/// against small loads takes two or three such steps.
const MOST_STRAYED: u32 = 4;
/// What is said then.
const STAGGERED_DIVERGES: &str = "coupling = \"staggered\" diverges: in 4 aerodynamic steps in a row the loads missed their \
     prediction by more than the largest of the run: the air is too heavy for one correction, write coupling = \"iterated\"";

/// The flow at a time, with the wind and the turning of the root frame at that time.
fn flow<'a>(settings: &'a machine::Air, state: &State, time_s: f64) -> Flow<'a> {
    Flow {
        time_s,
        density_kg_m3: state.applied_parameters.air_density_kg_m3(),
        wind_m_s: state.wind_at_m_s(time_s),
        spin_rad_s: state.spin_at_rad_s(time_s),
        gusts: &settings.gusts,
    }
}

/// Time in s by which the caller's clock may be off an aerodynamic step's end that it means.
fn round_off_s(time_s: f64, step_s: f64) -> f64 {
    SLIVER * step_s + CLOCK_ROUND_OFF * time_s.abs()
}

/// The air has no solution.
fn refusal(time_s: f64, cause: impl std::fmt::Display) -> PlantError {
    PlantError::Air { time_s, cause: cause.to_string() }
}

impl Plant {
    /// Air at the start of the run, with its loads on the present motion.
    pub(in crate::plant) fn start_air(&mut self, time_s: f64) -> Result<(), PlantError> {
        let Some(air) = &mut self.air else { return Ok(()) };
        let now = &self.state.now;
        self.equations.residual(time_s, &now.q, &now.v, &now.a, &mut self.scratch[0]);
        air.observe(&self.equations, now);
        let mut history = air.blank.clone();
        let AirCoupling { model, settings, motions, loads, .. } = &mut **air;
        let flow = flow(settings, &self.state, time_s);
        model
            .start(motions, &flow, settings.established, &mut history.after, loads)
            .map_err(|error| gaps::failure(&self.machine, settings, time_s, error))?;
        if let Some(error) = gaps::crossing(&self.machine, settings, model, time_s) {
            return Err(error);
        }
        air.read(&history.loads);
        let (change_n, size_n) = air.compare();
        if !change_n.is_finite() {
            return Err(refusal(time_s, "its loads are not finite"));
        }
        air.accept();
        history.start_s = time_s;
        history.scale_n = size_n;
        (history.loads.begin_s, history.loads.end_s) = (time_s, time_s);
        air.write(&mut history.loads);
        history.loads.from.clone_from(&history.loads.to);
        history.at_begin.clone_from(&history.loads.to);
        history.before.copy_from(&history.after);
        for (end, motion) in history.end.iter_mut().zip(&air.motions) {
            *end = Sample::steady(motion);
        }
        history.begin.copy_from_slice(&history.end);
        self.state.air = Some(history);
        self.configure();
        Ok(())
    }

    /// Brings the machine to rest under the loads of an established flow, eq. (Q5), and hinges that only the air restores
    /// by eq. (Q6); without air as [`Plant::settle_at_rest`] does.
    pub(in crate::plant) fn settle_in_air(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        if self.air.is_none() {
            return self.settle_at_rest(time_s, holding);
        }
        let (start, joints) = (self.state.now.q.clone(), self.state.joints.clone());
        let settled = self.settle_with_air(time_s, holding);
        if settled.is_ok() || holding == Holding::Stopped {
            return settled;
        }
        self.state.now.q.copy_from_slice(&start);
        self.state.joints.copy_from_slice(&joints);
        self.configure();
        let hinges = self.free_hinges();
        if hinges.is_empty() { settled } else { self.coast(time_s, &hinges) }
    }

    /// Structure under held loads and air about it in turn, until they agree: eq. (Q5).
    pub(super) fn settle_with_air(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        let start = self.state.now.q.clone();
        let joints = self.state.joints.clone();
        self.start_air(time_s)?;
        let mut change = f64::NAN;
        if let Some(air) = &mut self.air {
            air.acceleration.restart();
        }
        for _ in 0..MOST_STATIC_ITERATIONS {
            self.state.now.q.copy_from_slice(&start);
            self.state.joints.copy_from_slice(&joints);
            self.configure();
            let guess = self.state.air.as_ref().map(|history| history.loads.clone());
            let effort = self.settle_at_rest(time_s, holding)?;
            self.start_air(time_s)?;
            let (Some(air), Some(history), Some(guess)) = (&mut self.air, &mut self.state.air, guess) else {
                return Ok(effort);
            };
            air.read(&guess);
            let (change_n, size_n) = air.compare();
            change = change_n / size_n;
            let agreed_n = STATIC_TOLERANCE * size_n;
            let round_off_n = air.round_off_n(self.state.applied_parameters.air_density_kg_m3());
            if !change_n.is_finite() || change_n <= agreed_n.max(round_off_n) {
                return Ok(effort);
            }
            let AirCoupling { acceleration, guess, residual, .. } = &mut **air;
            acceleration.next(guess, residual);
            air.write(&mut history.loads);
            history.loads.from.clone_from(&history.loads.to);
        }
        let cause = format!("the loads at rest still change by {change:.1e} after {MOST_STATIC_ITERATIONS} iterations");
        Err(refusal(time_s, cause))
    }

    /// Whether `start` stands at the end of an aerodynamic step and `time_s` is that end but for the caller's clock; it
    /// then is `time_s`. What is read there belongs to the step that ends, whatever the last bits of the clock say.
    pub(in crate::plant) fn adopt_end_of_air_step(&mut self, time_s: f64) -> bool {
        let (Some(history), Some(air)) = (&self.state.air, &self.air) else { return false };
        let (end_s, round_off_s) = (history.loads.end_s, round_off_s(time_s, air.settings.step_s));
        let is_end =
            history.steps > 0 && self.state.start.time_s >= end_s - round_off_s && time_s <= end_s + round_off_s;
        if is_end {
            (self.state.start.time_s, self.state.ahead.time_s) = (time_s, time_s);
        }
        is_end
    }

    /// Begins the next aerodynamic step where the present one is over.
    pub(in crate::plant) fn begin_air_step(&mut self) -> Result<(), PlantError> {
        let (Some(history), Some(air)) = (&mut self.state.air, &self.air) else { return Ok(()) };
        let (step_s, time_s) = (air.settings.step_s, self.state.start.time_s);
        if time_s < history.loads.end_s - round_off_s(time_s, step_s) {
            return Ok(());
        }
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
        loads.begin_s = self.state.start.time_s;
        loads.end_s = history.start_s + history.steps as f64 * step_s;
        self.agree_on_loads()
    }

    /// Ends at the present time what the inputs so far have to say in the present step: they change now.
    pub(in crate::plant) fn cut_step(&mut self) {
        let time_s = self.state.now.time_s;
        let Some(begin_s) = self.state.air.as_ref().map(|history| history.loads.begin_s) else { return };
        // exact for a wind that runs linearly
        let wind_m_s = self.state.wind_at_m_s(0.5 * (begin_s + time_s));
        let rate_m_s2 = self.state.applied_rates.wind_m_s();
        let Some(AirHistory { loads, carried_m, gain, .. }) = &mut self.state.air else { return };
        if time_s > loads.begin_s && time_s < loads.end_s {
            *carried_m += wind_m_s * (time_s - loads.begin_s);
            *gain = gain.after(time_s - loads.begin_s, rate_m_s2);
            loads.begin_s = time_s;
        }
    }

    /// Finds the loads for the rest of the present step anew, after the inputs have changed inside it.
    pub(in crate::plant) fn renew_air(&mut self) -> Result<(), PlantError> {
        match (&self.state.air, &self.air) {
            (Some(history), Some(air)) => {
                let time_s = self.state.start.time_s;
                let is_over = time_s >= history.loads.end_s - round_off_s(time_s, air.settings.step_s);
                if is_over { Ok(()) } else { self.agree_on_loads() }
            }
            _ => Ok(()),
        }
    }

    /// Loads at the end of the present aerodynamic step that agree with the motion there, NOTATION eq. (Q2).
    /// Leaves the structure at `start`, with accelerations under these loads.
    fn agree_on_loads(&mut self) -> Result<(), PlantError> {
        let Some(mut air) = self.air.take() else { return Ok(()) };
        let outcome = self.iterate(&mut air);
        self.air = Some(air);
        outcome
    }

    fn iterate(&mut self, air: &mut AirCoupling) -> Result<(), PlantError> {
        let step_s = air.settings.step_s;
        air.trial.save(&self.state, self.equations.air.as_ref());
        let Some(mut history) = self.state.air.take() else { return Ok(()) };
        let (begin_s, end_s) = (history.loads.begin_s, history.loads.end_s);
        // way of the wind over the whole step, and the turning of the root frame in the middle of what is left of it:
        // exact for inputs that run linearly from the step's start
        let middle_s = 0.5 * (begin_s + end_s);
        let way_m = history.carried_m + self.state.wind_at_m_s(middle_s) * (end_s - begin_s);
        let spin_rad_s = self.state.spin_at_rad_s(middle_s);
        let carrying = Flow { wind_m_s: way_m / step_s, spin_rad_s, ..flow(&air.settings, &self.state, end_s) };
        let gain = history.gain.after(end_s - begin_s, self.state.applied_rates.wind_m_s());
        let path = AirPath::new(&carrying, step_s);
        air.model.convect(&history.before, &carrying, step_s, &mut history.after);
        air.read(&history.loads);
        air.acceleration.restart();
        let (tolerance, most) = match air.settings.coupling {
            Coupling::Staggered => (f64::INFINITY, 1),
            Coupling::Iterated { tolerance, most_iterations } => (tolerance, most_iterations),
        };
        if let Some(fixed_s) = self.machine.solver.fixed_step_s {
            history.structure_step_s = even_step(end_s - begin_s, fixed_s);
        }
        let mut outcome = Err(0.0);
        for trial in 0..most {
            history.motion_tolerance = match air.settings.coupling {
                Coupling::Iterated { tolerance, .. } if history.scale_n > 0.0 => {
                    let density_kg_m3 = self.state.applied_parameters.air_density_kg_m3();
                    let way_m = air.unnoticed_m(MOTION_SHARE * tolerance * history.scale_n, density_kg_m3);
                    (way_m / self.equations.model.reference_length_m).max(LEAST_MOTION_TOLERANCE)
                }
                _ => f64::INFINITY,
            };
            self.state.air = Some(history);
            self.equations.booked = false;
            let marched = self.march_on_trial(end_s, trial == 0);
            self.equations.booked = true;
            let (wanted_s, next_s) = (self.smallest_step_s, self.state.step_s);
            let halved = self.state.statistics.failures > air.trial.statistics.failures;
            let ahead = &self.state.ahead;
            if marched.is_ok() {
                self.equations.residual(end_s, &ahead.q, &ahead.v, &ahead.a, &mut self.scratch[0]);
                air.observe(&self.equations, ahead);
            }
            history = self.go_back(&air.trial);
            for (motion, (begin, end)) in air.motions.iter_mut().zip(history.begin.iter().zip(&mut history.end)) {
                *end = begin.next(motion, step_s, &gain);
                *motion = end.motion;
            }
            let chosen = trial == 0 && self.machine.solver.fixed_step_s.is_none();
            if chosen {
                history.structure_step_s = even_step(end_s - begin_s, wanted_s);
            } else if halved {
                // Newton's iteration has failed on the agreed steps: from now on all march with shorter ones, else the loads
                // at the end jump from one trial to the next
                history.structure_step_s *= 0.5;
                air.acceleration.restart();
            }
            if trial == 0 {
                air.trial.step_s = next_s;
            }
            self.state.step_s = air.trial.step_s;
            if let Err(error) = marched {
                self.state.air = Some(history);
                return Err(error);
            }
            let AirCoupling { model, settings, motions, loads, .. } = &mut *air;
            let flow = flow(settings, &self.state, end_s);
            self.state.statistics.air_solutions += 1;
            if let Err(error) = model.solve(&history.before, motions, &flow, step_s, &mut history.after, loads) {
                self.state.air = Some(history);
                return Err(gaps::failure(&self.machine, settings, begin_s, error));
            }
            let (change_n, size_n) = air.compare();
            if !change_n.is_finite() {
                self.state.air = Some(history);
                return Err(refusal(begin_s, "its loads are not finite"));
            }
            history.scale_n = history.scale_n.max(size_n);
            if air.settings.coupling == Coupling::Staggered {
                history.strayed = if change_n > history.scale_n { history.strayed + 1 } else { 0 };
                if history.strayed >= MOST_STRAYED {
                    self.state.air = Some(history);
                    return Err(refusal(begin_s, STAGGERED_DIVERGES));
                }
            }
            let round_off_n = air.round_off_n(self.state.applied_parameters.air_density_kg_m3());
            if change_n <= (tolerance * history.scale_n).max(round_off_n) {
                air.accept();
                outcome = Ok(());
            } else {
                outcome = Err(change_n / history.scale_n);
                let AirCoupling { acceleration, guess, residual, .. } = &mut *air;
                acceleration.next(guess, residual);
            }
            air.write(&mut history.loads);
            if outcome.is_ok() {
                break;
            }
        }
        let row_panels = air.model.row_panels(&history.before, &history.after, &path);
        let longest = &mut self.state.statistics.longest_row_panels;
        *longest = longest.max(row_panels);
        self.state.air = Some(history);
        if let Err(change) = outcome {
            let mut cause = format!("the loads still change by {change:.1e} of the largest after {most} iterations");
            if let Some(surface) =
                gaps::blown_from_behind(&air.settings, &air.motions, &flow(&air.settings, &self.state, end_s))
            {
                let body = &self.machine.bodies[air.settings.surfaces[surface].body].name;
                cause +=
                    &format!("; the air meets the trailing edge of {body} first, and the wake must leave behind it");
            }
            return Err(refusal(begin_s, cause));
        }
        if let Some(error) = gaps::crossing(&self.machine, &air.settings, &air.model, end_s) {
            return Err(error);
        }
        self.discontinuity(|_, _| Outcome::default()).map(|_| ())
    }

    /// Marches the structure to the end of the aerodynamic step under the present guess of the loads; `first`: with steps
    /// by the error estimate.
    fn march_on_trial(&mut self, end_s: f64, first: bool) -> Result<(), PlantError> {
        self.discontinuity(|_, _| Outcome::default())?;
        self.smallest_step_s = f64::INFINITY;
        while self.state.ahead.time_s < end_s {
            let State { start, ahead, .. } = &mut self.state;
            start.copy_from(ahead);
            self.apply_events()?;
            match self.structure_step_s().filter(|_| !first || self.machine.solver.fixed_step_s.is_some()) {
                Some(step_s) => self.advance_fixed(step_s, end_s)?,
                None => self.advance(end_s)?,
            }
        }
        Ok(())
    }

    /// Step of the structure that the present aerodynamic step is marched with, in s; `None` without air.
    pub(in crate::plant) fn structure_step_s(&self) -> Option<f64> {
        self.state.air.as_ref().map(|history| history.structure_step_s)
    }

    /// Undoes a trial march; takes the history out, so that its air can be changed.
    fn go_back(&mut self, trial: &Trial) -> AirHistory {
        let solutions = self.state.statistics.air_solutions;
        let trial_iterations = self.state.statistics.iterations - trial.statistics.iterations;
        let so_far = self.state.statistics.trial_iterations;
        let State { start, ahead, joints, .. } = &mut self.state;
        start.copy_from(&trial.start);
        ahead.copy_from(&trial.start);
        joints.copy_from_slice(&trial.joints);
        self.state.statistics = trial.statistics;
        self.state.statistics.air_solutions = solutions;
        self.state.statistics.trial_iterations = so_far + trial_iterations;
        self.configure();
        if let Some(loads) = &mut self.equations.air {
            loads.copy_from(&trial.loads);
        }
        self.state.air.take().expect("a machine in air has a history")
    }
}

impl Trial {
    /// Remembers where a trial march starts. `loads`: those that its accelerations belong to.
    fn save(&mut self, state: &State, loads: Option<&StepLoads>) {
        self.start.copy_from(&state.start);
        self.joints.clone_from(&state.joints);
        (self.step_s, self.statistics) = (state.step_s, state.statistics);
        if let Some(loads) = loads {
            self.loads.copy_from(loads);
        }
    }
}
