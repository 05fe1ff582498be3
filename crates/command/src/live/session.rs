//! The simulation of the page: its machines, clock and history, and the messages to the page.

use crate::live::history::{History, Moment};
use crate::live::order::{Given, Order};
use crate::live::pace::Pace;
use crate::live::running::{Part, Running};
use crate::live::summary::Summary;
use crate::report::viewer::{LiveMachine, page_of_live};
use foldwing_engine::plant::Plant;
use foldwing_fmi::interface::Interface;
use nalgebra::Vector3;
use serde_json::json;
use std::time::{Duration, Instant};

/// Largest number of machines of a simulation.
pub const MOST_MACHINES: usize = 4;

/// Frames per second of wall time.
pub(super) const FRAMES_1_S: f64 = 30.0;

/// Minimum and maximum communication step in s of wall time. Between steps the spring is updated and events are reported.
const STEPS_S: [f64; 2] = [5e-4, 1.0 / 60.0];

/// Maximum wall time in s of uninterrupted steps, so that a slow simulation still responds to commands.
const TURN_S: f64 = 0.02;

/// Samples of the plotted outputs per second of wall time.
const SAMPLES_1_S: f64 = 250.0;

/// Simulation paced by the wall clock: one machine, or several in step.
pub struct Session {
    /// The machines; fields and values of the page are those of the first.
    pub(super) machines: Vec<Running>,
    /// Communication step in s; start time and number of steps since the last jump in time.
    step_s: f64,
    origin_s: f64,
    taken: u64,
    pace: Pace,
    /// Instant from which wall times are measured.
    started: Instant,
    history: History,
    next_sample_s: f64,
    /// Error of the last step, if any.
    failure: Option<String>,
    /// Whether anything has changed since the last frame was sent to the pages.
    changed: bool,
    summary: Summary,
}

impl Session {
    /// Creates a simulation of one machine, with its clock stopped, from the current state of an initialised plant.
    #[cfg(test)]
    pub fn new(plant: Plant, interface: Interface, speed: f64) -> Self {
        Self::of_machines([(plant.machine().name.clone(), plant, interface)], speed)
    }

    /// Creates a simulation of machines that step together, from the current states of initialised plants with the same time, each with a
    /// name for the legend. The communication step is the shortest of the machines.
    pub fn of_machines(machines: impl IntoIterator<Item = (String, Plant, Interface)>, speed: f64) -> Self {
        let [shortest_s, longest_s] = STEPS_S;
        let machines: Vec<Running> =
            machines.into_iter().map(|(label, plant, interface)| Running::new(label, plant, interface)).collect();
        let step_s = machines.iter().map(|one| &one.plant).fold(longest_s, |least_s, plant| {
            let own_s = plant.machine().experiment.step_s.clamp(shortest_s, longest_s);
            least_s.min(own_s).min(plant.longest_step_s())
        });
        let now_s = machines.first().map_or(0.0, |one| one.plant.time_s());
        let first = Moment { time_s: now_s, states: machines.iter().map(Running::first).collect() };
        Self {
            machines,
            step_s,
            origin_s: now_s,
            taken: 0,
            pace: Pace::new(speed),
            started: Instant::now(),
            history: History::new(first),
            next_sample_s: now_s,
            failure: None,
            changed: true,
            summary: Summary::default(),
        }
    }

    /// Page that shows the simulation, as HTML.
    pub fn page(&mut self) -> String {
        let reach_m = self.machines.iter().map(Running::reach_m).fold(0.0, f64::max);
        let names: Vec<String> = self.machines.iter().map(|one| one.label.clone()).collect();
        let controls: Vec<_> = self.machines.iter().map(|one| json!(one.controls)).collect();
        let (first, others) =
            controls.split_first().map_or((json!([]), Vec::new()), |(one, rest)| (one.clone(), rest.to_vec()));
        let live = json!({
            "controls": first,
            "others": others,
            "machines": names,
            "step_s": self.step_s,
            "speed": self.pace.speed(),
            "reach_m": reach_m,
            "weight_n": 9.81 * self.machines.first().map_or(0.0, |one| one.plant.mass_kg()),
        });
        let shown = self.machines.iter_mut().map(|one| {
            let label = one.label.clone();
            let (scene, first, signals) = one.shown();
            LiveMachine { label, scene, first, signals }
        });
        page_of_live(&shown.collect::<Vec<_>>(), &live)
    }

    /// Names of the machines.
    pub fn name(&self) -> String {
        self.machines.iter().map(|one| one.label.as_str()).collect::<Vec<_>>().join(" and ")
    }

    /// Communication step in s.
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Current time in s.
    pub fn time_s(&self) -> f64 {
        self.machines.first().map_or(0.0, |one| one.plant.time_s())
    }

    /// Returns whether the clock runs.
    pub fn runs(&self) -> bool {
        self.pace.runs()
    }

    /// Statistics of the simulation so far.
    pub fn summary(&self) -> Summary {
        let (ran_s, lost_s, latest_s) = (self.pace.ran_s(), self.pace.lost_s(), self.pace.latest_s());
        Summary { ran_s, lost_s, latest_s, ..self.summary }
    }

    /// Wall time since the session began.
    fn wall(&self) -> Duration {
        self.started.elapsed()
    }

    /// Remaining wall time until the next step is due; `None` while the clock is stopped.
    pub fn until_step(&self) -> Option<Duration> {
        self.pace.until(self.next_s(), self.wall())
    }

    /// End of the next communication step in s.
    fn next_s(&self) -> f64 {
        self.origin_s + (self.taken + 1) as f64 * self.step_s
    }

    /// Executes a command of a page and returns a message for all pages, if any.
    ///
    /// # Errors
    /// Invalid commands, with the allowed values.
    pub fn execute(&mut self, order: &Order) -> Result<Option<String>, String> {
        self.changed = true;
        match order {
            Order::Run {} => self.run(),
            Order::Pause {} => {
                self.pace.stop();
                Ok(None)
            }
            Order::Step {} => {
                self.pace.stop();
                self.check_failure()?;
                self.advance_one();
                Ok(None)
            }
            Order::Restart {} => {
                let states = self.machines.iter().map(Running::first).collect();
                self.go_back(&Moment { time_s: f64::NEG_INFINITY, states })?;
                self.history = History::new(self.moment());
                Ok(Some(self.rolled_back_message()))
            }
            Order::Rollback { time_s } => {
                let moment = self.history.back_to(*time_s).cloned();
                moment.map_or(Ok(()), |moment| self.go_back(&moment))?;
                Ok(Some(self.rolled_back_message()))
            }
            Order::Speed { value } => {
                let (wall, now_s) = (self.wall(), self.time_s());
                self.pace.set_speed(*value, wall, now_s);
                Ok(None)
            }
            Order::Set { name, value, machine } => self.set(name, *value, *machine).map(|()| Some(self.values())),
            Order::Watch { names } => self.add_watched(names).map(|()| None),
            Order::Pull { station, target_m, stiffness_n_m, machine } => {
                let (count, target_m) = (self.machines.len(), Vector3::from(*target_m));
                let one = self.machines.get_mut(*machine).ok_or_else(|| no_machine(*machine, count))?;
                one.set_pull(*station, target_m, *stiffness_n_m).map(|()| None)
            }
            Order::Release {} => {
                self.release_pull();
                Ok(None)
            }
        }
    }

    /// Stops the clock.
    pub fn pause(&mut self) {
        self.pace.stop();
    }

    fn check_failure(&self) -> Result<(), String> {
        match &self.failure {
            Some(failure) => Err(format!("the simulation cannot continue: {failure}; roll back on the time bar")),
            None => Ok(()),
        }
    }

    fn run(&mut self) -> Result<Option<String>, String> {
        self.check_failure()?;
        if !self.pace.runs() {
            let (wall, now_s) = (self.wall(), self.time_s());
            self.pace.start(wall, now_s);
        }
        Ok(None)
    }

    /// Performs the steps that are due, for at most `TURN_S`.
    pub fn advance(&mut self) {
        let begun = self.wall();
        while self.pace.runs() && self.next_s() <= self.pace.due_s(self.wall()) {
            self.advance_one();
            if (self.wall() - begun).as_secs_f64() > TURN_S {
                break;
            }
        }
        let (wall, reached_s, step_s) = (self.wall(), self.time_s(), self.step_s);
        self.pace.catch_up(wall, reached_s, step_s);
    }

    /// Performs one communication step of all machines; after an error the simulation stops at the last valid time.
    fn advance_one(&mut self) {
        let (before_s, next_s, begun) = (self.time_s(), self.next_s(), Instant::now());
        let (step_s, several) = (self.step_s, self.machines.len() > 1);
        self.taken += 1;
        self.changed = true;
        for one in &mut self.machines {
            if let Err(error) = one.step_to(next_s, step_s) {
                self.pace.stop();
                self.failure = Some(if several { format!("{}: {error}", one.label) } else { error });
                break;
            }
        }
        self.sample();
        self.summary.steps += 1;
        self.summary.simulated_s += self.time_s() - before_s;
        self.summary.slowest_s = self.summary.slowest_s.max(begun.elapsed().as_secs_f64());
    }

    /// Adds a sample of the plotted signals, of all machines at the same times.
    fn sample(&mut self) {
        let now_s = self.time_s();
        if self.failure.is_some() || now_s < self.next_sample_s - 1e-9 * self.step_s {
            return;
        }
        if self.machines.iter().all(|one| one.watched.is_empty()) {
            return;
        }
        self.next_sample_s = now_s + self.pace.speed() / SAMPLES_1_S;
        self.machines.iter_mut().for_each(Running::sample);
    }

    fn moment(&self) -> Moment {
        Moment { time_s: self.time_s(), states: self.machines.iter().map(Running::state).collect() }
    }

    fn go_back(&mut self, moment: &Moment) -> Result<(), String> {
        for (one, state) in self.machines.iter_mut().zip(&moment.states) {
            one.go_back(state)?;
        }
        self.pace.stop();
        self.failure = None;
        (self.origin_s, self.taken) = (self.time_s(), 0);
        self.next_sample_s = self.origin_s;
        Ok(())
    }

    /// Name of a machine in texts, if there are several.
    fn label(&self, machine: usize) -> Option<String> {
        (self.machines.len() > 1).then(|| self.machines[machine].label.clone())
    }

    /// Values of the controls of the first machine, and those of the others.
    fn value_lists(&mut self) -> (Vec<f64>, Vec<Vec<f64>>) {
        let mut all: Vec<_> = self.machines.iter_mut().map(Running::values).collect();
        let others = all.split_off(all.len().min(1));
        (all.pop().unwrap_or_default(), others)
    }

    /// Message after a rollback: the time and the values of the controls.
    fn rolled_back_message(&mut self) -> String {
        let (values, others) = self.value_lists();
        json!({ "kind": "rolled_back", "time": self.time_s(), "values": values, "others": others }).to_string()
    }

    /// Message with the values of all controls.
    pub fn values(&mut self) -> String {
        let (values, others) = self.value_lists();
        json!({ "kind": "values", "values": values, "others": others }).to_string()
    }

    /// First message to a page: values of the controls, and the events so far.
    pub fn connected_message(&mut self) -> String {
        self.changed = true;
        let labels: Vec<_> = (0..self.machines.len()).map(|machine| self.label(machine)).collect();
        let events: Vec<_> =
            self.machines.iter().zip(&labels).flat_map(|(one, label)| one.events(label.as_deref())).collect();
        let (values, others) = self.value_lists();
        json!({ "kind": "connected", "values": values, "others": others, "events": events }).to_string()
    }

    /// Sets an input or parameter of one machine, or of all that have it; if it is invalid for one of them, none is changed.
    fn set(&mut self, name: &str, given: Given, machine: Option<usize>) -> Result<(), String> {
        let count = self.machines.len();
        let chosen: Vec<usize> = match machine {
            Some(machine) if machine >= count => return Err(no_machine(machine, count)),
            Some(machine) => vec![machine],
            None => {
                let having: Vec<_> = (0..count).filter(|i| self.machines[*i].has_control(name)).collect();
                // if no machine has the name, the message of the first
                if having.is_empty() { vec![0] } else { having }
            }
        };
        let mut before: Vec<(usize, Given)> = Vec::new();
        for machine in chosen {
            let one = &mut self.machines[machine];
            let old = one.value(name);
            if let Err(reason) = one.set(name, given) {
                let reason = self.label(machine).map_or(reason.clone(), |label| format!("{label}: {reason}"));
                for (machine, old) in before {
                    self.machines[machine].set(name, old)?;
                }
                return Err(reason);
            }
            before.extend(old.map(|old| (machine, old)));
        }
        Ok(())
    }

    /// Adds outputs to those plotted, for every machine that has them.
    fn add_watched(&mut self, names: &[String]) -> Result<(), String> {
        let nowhere = |name: &&String| !self.machines.iter().any(|one| one.has_output(name));
        let unknown: Vec<&String> = names.iter().filter(nowhere).collect();
        if let (Some(first), false) = (self.machines.first_mut(), unknown.is_empty()) {
            // its message names similar outputs
            return first.add_watched(&unknown).map(drop);
        }
        let mut any = false;
        for one in &mut self.machines {
            let own: Vec<&String> = names.iter().filter(|name| one.has_output(name)).collect();
            any |= one.add_watched(&own)?;
        }
        if any {
            // all rows of a frame have the same width, and all machines the same times
            self.machines.iter_mut().for_each(Running::forget_samples);
        }
        Ok(())
    }

    /// Removes the springs.
    pub fn release_pull(&mut self) {
        self.machines.iter_mut().for_each(Running::release_pull);
    }

    /// The current frame, if anything has changed: a header in JSON, then numbers in single precision, little-endian.
    ///
    /// The first four bytes are the length of the header, which is padded with spaces to a multiple of four. The numbers are the
    /// samples and the state of each machine in turn; the header describes the first machine, and in `others` the others.
    pub fn next_frame(&mut self) -> Option<Vec<u8>> {
        if !std::mem::take(&mut self.changed) {
            return None;
        }
        self.summary.frames += 1;
        if self.failure.is_none() {
            // do not replace a valid state by that of a failed step
            self.history.push(self.moment());
        }
        let labels: Vec<_> = (0..self.machines.len()).map(|machine| self.label(machine)).collect();
        let parts: Vec<Part> =
            self.machines.iter_mut().zip(&labels).map(|(one, label)| one.next_part(label.as_deref())).collect();
        let events: Vec<_> = parts.iter().flat_map(|part| part.events.iter()).collect();
        let others: Vec<_> = parts.iter().skip(1).map(|part| &part.description).collect();
        let mut header = json!({
            "time": self.time_s(),
            "oldest": self.history.oldest_s(),
            "running": self.pace.runs(),
            "speed": self.pace.speed(),
            "factor": self.pace.factor(),
            "lost": self.pace.lost_s(),
            "failure": self.failure,
            "events": events,
            "others": others,
        });
        if let (Some(all), Some(own)) =
            (header.as_object_mut(), parts.first().and_then(|part| part.description.as_object()))
        {
            all.extend(own.clone());
        }
        let mut header = header.to_string().into_bytes();
        while !header.len().is_multiple_of(4) {
            header.push(b' ');
        }
        let mut bytes = u32::try_from(header.len()).unwrap_or(0).to_le_bytes().to_vec();
        bytes.extend(header);
        bytes.extend(parts.iter().flat_map(|part| &part.numbers).copied().flat_map(f32::to_le_bytes));
        Some(bytes)
    }
}

fn no_machine(machine: usize, count: usize) -> String {
    format!("there is no model {machine}: models are numbered from 0 to {}", count.saturating_sub(1))
}
