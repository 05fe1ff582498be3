//! The simulation of the page: its plant, clock and history, and the messages to the page.

use crate::live::controls::{Control, controls};
use crate::live::history::{History, Moment};
use crate::live::order::{Given, MOST_WATCHED, Order};
use crate::live::pace::Pace;
use crate::live::pull::{Held, Pull};
use crate::live::summary::Summary;
use crate::report::acting::Watch;
use crate::report::number;
use crate::report::recording::{Frame, Scene};
use crate::report::viewer::{numbers_of_frame, page_of_live};
use foldwing_engine::machine::{Machine, Parent};
use foldwing_engine::plant::{OutputSet, Plant, Snapshot};
use foldwing_fmi::interface::{AccessError, Causality, Interface, Stage, Value};
use foldwing_study::names::NameError;
use nalgebra::Vector3;
use serde_json::json;
use std::time::{Duration, Instant};

/// Frames per second of wall time.
pub(super) const FRAMES_1_S: f64 = 30.0;

/// Minimum and maximum communication step in s of wall time. Between steps the spring is updated and events are reported.
const STEPS_S: [f64; 2] = [5e-4, 1.0 / 60.0];

/// Maximum wall time in s of uninterrupted steps, so that a slow simulation still responds to commands.
const TURN_S: f64 = 0.02;

/// Samples of the plotted outputs per second of wall time.
const SAMPLES_1_S: f64 = 250.0;

/// Simulation paced by the wall clock.
pub struct Session {
    pub(super) plant: Plant,
    interface: Interface,
    pub(super) controls: Vec<Control>,
    scene: Scene,
    watch: Watch,
    /// Communication step in s; start time and number of steps since the last jump in time.
    step_s: f64,
    origin_s: f64,
    taken: u64,
    pace: Pace,
    /// Instant from which wall times are measured.
    started: Instant,
    first: Snapshot,
    history: History,
    pub(super) pull: Option<Pull>,
    /// Value references of the plotted outputs, and the samples since the last frame, row by row after their times.
    pub(super) watched: Vec<u32>,
    samples: Vec<f32>,
    next_sample_s: f64,
    /// Number of events sent so far.
    sent_events: usize,
    /// Error of the last step, if any.
    failure: Option<String>,
    /// Whether anything has changed since the last frame was sent to the pages.
    changed: bool,
    summary: Summary,
}

impl Session {
    /// Creates a simulation, with its clock stopped, from the current state of an initialised plant.
    pub fn new(mut plant: Plant, interface: Interface, speed: f64) -> Self {
        plant.watch(OutputSet::NONE);
        plant.provide(OutputSet::ALL);
        let [shortest_s, longest_s] = STEPS_S;
        let step_s = plant.machine().experiment.step_s.clamp(shortest_s, longest_s).min(plant.longest_step_s());
        let first = plant.snapshot();
        let now_s = plant.time_s();
        let watch = Watch::new(plant.machine());
        let mut session = Self {
            controls: controls(&interface, &plant),
            scene: Scene::of(&plant),
            sent_events: 0,
            watch,
            step_s,
            origin_s: now_s,
            taken: 0,
            pace: Pace::new(speed),
            started: Instant::now(),
            history: History::new(Moment { time_s: now_s, snapshot: first.clone(), held: None }),
            first,
            pull: None,
            watched: Vec::new(),
            samples: Vec::new(),
            next_sample_s: now_s,
            failure: None,
            changed: true,
            summary: Summary::default(),
            plant,
            interface,
        };
        session.watch.include(&session.plant, &session.scene.joints);
        session
    }

    /// Page that shows the simulation, as HTML.
    pub fn page(&mut self) -> String {
        self.plant.provide(OutputSet::ALL);
        let frame = Frame::of(&self.scene, &self.plant);
        let outputs = self.interface.variables().iter().filter(|row| row.causality == Causality::Output);
        let outputs = outputs.filter(|row| matches!(row.value, Value::Real(_)));
        let signals: Vec<_> = outputs.map(|row| (row.name.clone(), row.unit().to_owned())).collect();
        let reach_m = reach_m(self.plant.machine());
        let live = json!({
            "controls": self.controls,
            "step_s": self.step_s,
            "speed": self.pace.speed(),
            "reach_m": reach_m,
            "weight_n": 9.81 * self.plant.mass_kg(),
        });
        page_of_live(&self.scene, &frame, &signals, &live)
    }

    /// Name of the model.
    pub fn name(&self) -> &str {
        &self.scene.name
    }

    /// Communication step in s.
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Current time in s.
    pub fn time_s(&self) -> f64 {
        self.plant.time_s()
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
                let first = Moment { time_s: f64::NEG_INFINITY, snapshot: self.first.clone(), held: None };
                self.go_back(&first)?;
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
            Order::Set { name, value } => self.set(name, *value).map(|()| Some(self.values())),
            Order::Watch { names } => self.add_watched(names).map(|()| None),
            Order::Pull { station, target_m, stiffness_n_m } => {
                self.set_pull(*station, Vector3::from(*target_m), *stiffness_n_m).map(|()| None)
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

    /// Performs one communication step; after an error the simulation stops at the last valid time.
    fn advance_one(&mut self) {
        let (before_s, next_s, begun) = (self.time_s(), self.next_s(), Instant::now());
        if let Some(pull) = &mut self.pull {
            pull.apply(&mut self.plant, self.step_s);
        }
        let outcome = self.plant.step(next_s);
        self.taken += 1;
        self.changed = true;
        self.watch.include(&self.plant, &self.scene.joints);
        self.sample();
        self.summary.steps += 1;
        self.summary.simulated_s += self.time_s() - before_s;
        self.summary.slowest_s = self.summary.slowest_s.max(begun.elapsed().as_secs_f64());
        if let Err(error) = outcome {
            self.pace.stop();
            self.failure = Some(error.to_string());
        }
    }

    /// Adds a sample of the plotted signals.
    fn sample(&mut self) {
        let now_s = self.time_s();
        if self.watched.is_empty() || now_s < self.next_sample_s - 1e-9 * self.step_s {
            return;
        }
        self.next_sample_s = now_s + self.pace.speed() / SAMPLES_1_S;
        self.plant.provide(self.interface.needs(self.watched.as_slice()));
        self.samples.push(now_s as f32);
        for reference in &self.watched {
            let value = self.interface.get(&self.plant, self.plant.outputs(), *reference);
            self.samples.push(value.map_or(f32::NAN, |value| number(&value) as f32));
        }
    }

    fn moment(&self) -> Moment {
        Moment {
            time_s: self.time_s(),
            snapshot: self.plant.snapshot(),
            held: self.pull.as_ref().map(|pull| pull.held),
        }
    }

    fn go_back(&mut self, moment: &Moment) -> Result<(), String> {
        self.plant.restore(&moment.snapshot).map_err(|error| error.to_string())?;
        if let Some(held) = moment.held {
            held.release(&mut self.plant);
        }
        self.pace.stop();
        self.pull = None;
        self.failure = None;
        (self.origin_s, self.taken) = (self.time_s(), 0);
        self.next_sample_s = self.origin_s;
        self.samples.clear();
        let (now_s, mut watch) = (self.origin_s, Watch::new(self.plant.machine()));
        watch.events = std::mem::take(&mut self.watch.events);
        watch.events.retain(|event| event.time_s <= now_s || event.kind == "gust");
        watch.include(&self.plant, &self.scene.joints);
        self.sent_events = watch.events.len();
        self.watch = watch;
        Ok(())
    }

    /// Message after a rollback: the time and the values of the controls.
    fn rolled_back_message(&mut self) -> String {
        json!({ "kind": "rolled_back", "time": self.time_s(), "values": self.value_list() }).to_string()
    }

    /// Message with the values of all controls.
    pub fn values(&mut self) -> String {
        json!({ "kind": "values", "values": self.value_list() }).to_string()
    }

    /// First message to a page: values of the controls, and the events so far.
    pub fn connected_message(&mut self) -> String {
        self.changed = true;
        let events: Vec<_> = self.watch.events.iter().map(event).collect();
        json!({ "kind": "connected", "values": self.value_list(), "events": events }).to_string()
    }

    /// Values of the controls in their order, without the load of a pull.
    fn value_list(&mut self) -> Vec<f64> {
        let values = |session: &mut Self| {
            let Self { controls, interface, plant, .. } = session;
            let value = |one: &Control| interface.get(plant, plant.outputs(), one.reference);
            controls.iter().map(|one| value(one).map_or(f64::NAN, |value| number(&value))).collect()
        };
        self.without_pull(values)
    }

    /// Calls a function while the inputs have the values without the pull.
    fn without_pull<T>(&mut self, act: impl FnOnce(&mut Self) -> T) -> T {
        let held = self.pull.as_ref().map(|pull| pull.held);
        let with_pull = held.and_then(|held| Some(self.plant.inputs().stations().get(held.station)?.force_n));
        if let Some(held) = held {
            held.release(&mut self.plant);
        }
        let result = act(self);
        if let (Some(pull), Some(with_n)) = (&mut self.pull, with_pull)
            && let Some(load) = self.plant.inputs_mut().stations_mut().get_mut(pull.held.station)
        {
            // the function may have changed the force
            let set_n = load.force_n;
            load.force_n = with_n + set_n - pull.held.base_n;
            pull.held.base_n = set_n;
        }
        result
    }

    fn set(&mut self, name: &str, given: Given) -> Result<(), String> {
        let known = || self.controls.iter().map(|one| one.name.as_str());
        let Some(one) = self.controls.iter().find(|one| one.name == name) else {
            return Err(match self.interface.find(name) {
                Some(_) => format!("{name} cannot be set during a run: only inputs and tunable parameters can"),
                None => NameError::unknown(name, "input or tunable parameter", known()).to_string(),
            });
        };
        let (reference, kind) = (one.reference, one.kind);
        self.without_pull(|session| {
            let (plant, row) = (&mut session.plant, &[reference][..]);
            let outcome: Result<(), AccessError> = match (kind, given) {
                ("switch", Given::Switch(value)) => session.interface.set_all(plant, row, &[value], Stage::Running),
                ("real", Given::Number(value)) => session.interface.set_all(plant, row, &[value], Stage::Running),
                ("integer", Given::Number(value)) if value.fract() == 0.0 && value.abs() < f64::from(i32::MAX) => {
                    session.interface.set_all(plant, row, &[value as i32], Stage::Running)
                }
                (_, Given::Switch(_)) => return Err(format!("{name} cannot be true or false: it must be a number")),
                ("switch", Given::Number(value)) => {
                    return Err(format!("{name} cannot be {value}: it must be true or false"));
                }
                (_, Given::Number(value)) => {
                    return Err(format!("{name} cannot be {value}: it must be a whole number"));
                }
            };
            outcome.map_err(|error| error.to_string())
        })
    }

    fn add_watched(&mut self, names: &[String]) -> Result<(), String> {
        let mut added = Vec::new();
        for name in names {
            let row = self.interface.find(name).filter(|row| row.causality == Causality::Output);
            let outputs = self.interface.variables().iter().filter(|row| row.causality == Causality::Output);
            let unknown = || NameError::unknown(name, "output", outputs.map(|row| row.name.as_str())).to_string();
            added.push(row.ok_or_else(unknown)?.value_reference);
        }
        let before = self.watched.clone();
        self.watched.retain(|reference| !added.contains(reference));
        self.watched.extend(added);
        let too_many = self.watched.len().saturating_sub(MOST_WATCHED);
        self.watched.drain(..too_many);
        if self.watched != before {
            // all rows of a frame have the same width
            self.samples.clear();
        }
        Ok(())
    }

    fn set_pull(&mut self, station: usize, target_m: Vector3<f64>, stiffness_n_m: f64) -> Result<(), String> {
        if self.pull.as_ref().is_some_and(|pull| pull.held.station != station) {
            self.release_pull();
        }
        match &mut self.pull {
            Some(pull) => {
                pull.target_m = target_m;
                pull.stiffness_n_m = stiffness_n_m;
            }
            None => {
                let stations = self.plant.inputs().stations().len();
                let pull = Pull::new(&self.plant, station, target_m, stiffness_n_m);
                self.pull = Some(pull.ok_or_else(|| match stations {
                    0 => "there is no load station to pull on: the model has none".to_owned(),
                    _ => format!("there is no load station {station}: they are numbered from 0 to {}", stations - 1),
                })?);
            }
        }
        Ok(())
    }

    /// Removes the spring.
    pub fn release_pull(&mut self) {
        if let Some(Pull { held, .. }) = self.pull.take() {
            Held::release(held, &mut self.plant);
        }
    }

    /// The current frame, if anything has changed: a header in JSON, then numbers in single precision, little-endian.
    ///
    /// The first four bytes are the length of the header, which is padded with spaces to a multiple of four. The numbers are the
    /// samples (time and the values of `names`, row by row), followed by the state in the format of `run.js`.
    pub fn next_frame(&mut self) -> Option<Vec<u8>> {
        if !std::mem::take(&mut self.changed) {
            return None;
        }
        self.summary.frames += 1;
        self.plant.provide(OutputSet::ALL);
        if self.failure.is_none() {
            // do not replace a valid state by that of a failed step
            self.history.push(self.moment());
        }
        let frame = Frame::of(&self.scene, &self.plant);
        let (rows, numbers) = numbers_of_frame(&self.scene, &frame);
        let names = self.watched.iter().map(|row| self.interface.variables()[*row as usize].name.as_str());
        let names: Vec<&str> = names.collect();
        let events: Vec<_> =
            self.watch.events[self.sent_events.min(self.watch.events.len())..].iter().map(event).collect();
        let samples = self.samples.len() / (self.watched.len() + 1);
        let mut header = json!({
            "time": frame.time_s,
            "oldest": self.history.oldest_s(),
            "running": self.pace.runs(),
            "speed": self.pace.speed(),
            "factor": self.pace.factor(),
            "lost": self.pace.lost_s(),
            "failure": self.failure,
            "pull": self.pull.as_ref().map(Pull::shown),
            "events": events,
            "names": names,
            "samples": samples,
            "rows": rows,
        })
        .to_string()
        .into_bytes();
        self.sent_events = self.watch.events.len();
        while !header.len().is_multiple_of(4) {
            header.push(b' ');
        }
        let mut bytes = u32::try_from(header.len()).unwrap_or(0).to_le_bytes().to_vec();
        bytes.extend(header);
        bytes.extend(self.samples.drain(..).chain(numbers).flat_map(f32::to_le_bytes));
        Some(bytes)
    }
}

/// Length in m of the longest chain of bodies from the root.
fn reach_m(machine: &Machine) -> f64 {
    // parent bodies precede their children
    let mut begins_m: Vec<f64> = Vec::new();
    for body in &machine.bodies {
        begins_m.push(match body.joint.parent {
            Parent::Root { .. } => 0.0,
            Parent::Body { index, position_m } => begins_m.get(index).copied().unwrap_or(0.0) + position_m,
        });
    }
    begins_m.iter().zip(&machine.bodies).map(|(begin_m, body)| begin_m + body.length_m).fold(0.0, f64::max)
}

fn event(event: &crate::report::acting::Event) -> serde_json::Value {
    json!({ "t": event.time_s, "text": event.text, "kind": event.kind })
}
