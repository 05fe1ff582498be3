//! A machine of a live simulation: its plant, controls, plotted outputs and spring. The clock and the history are those of the session.

use crate::live::controls::{Control, controls};
use crate::live::history::State;
use crate::live::order::{Given, MOST_WATCHED};
use crate::live::pull::{Held, Pull};
use crate::report::acting::{Event, Watch};
use crate::report::number;
use crate::report::recording::{Frame, Scene};
use crate::report::viewer::numbers_of_frame;
use foldwing_engine::machine::{Machine, Parent};
use foldwing_engine::plant::{OutputSet, Plant, Snapshot};
use foldwing_fmi::interface::{AccessError, Causality, Interface, Stage, Value};
use foldwing_study::names::NameError;
use nalgebra::Vector3;
use serde_json::json;

/// Machine of a live simulation.
pub(super) struct Running {
    /// Name in the legend, different for all machines of a session.
    pub label: String,
    pub plant: Plant,
    interface: Interface,
    pub controls: Vec<Control>,
    pub scene: Scene,
    watch: Watch,
    first: Snapshot,
    pub pull: Option<Pull>,
    /// Value references of the plotted outputs, and the samples since the last frame, row by row after their times.
    pub watched: Vec<u32>,
    samples: Vec<f32>,
    /// Number of events sent so far.
    sent_events: usize,
}

/// Part of a frame for one machine: the description in the header, and the numbers after it.
pub(super) struct Part {
    pub description: serde_json::Value,
    pub numbers: Vec<f32>,
    pub events: Vec<serde_json::Value>,
}

impl Running {
    /// Creates a machine from an initialised plant.
    pub fn new(label: String, mut plant: Plant, interface: Interface) -> Self {
        plant.watch(OutputSet::NONE);
        plant.provide(OutputSet::ALL);
        let (first, watch) = (plant.snapshot(), Watch::new(plant.machine()));
        let (controls, scene) = (controls(&interface, &plant), Scene::of(&plant));
        let (pull, watched, samples, sent_events) = (None, Vec::new(), Vec::new(), 0);
        let mut made =
            Self { label, plant, interface, controls, scene, watch, first, pull, watched, samples, sent_events };
        made.watch.include(&made.plant, &made.scene.joints);
        made
    }

    /// The scene, its current frame and the outputs that can be plotted, with their units.
    pub fn shown(&mut self) -> (&Scene, Frame, Vec<(String, String)>) {
        self.plant.provide(OutputSet::ALL);
        let outputs = self.interface.variables().iter().filter(|row| row.causality == Causality::Output);
        let outputs = outputs.filter(|row| matches!(row.value, Value::Real(_)));
        let signals = outputs.map(|row| (row.name.clone(), row.unit().to_owned())).collect();
        (&self.scene, Frame::of(&self.scene, &self.plant), signals)
    }

    /// Steps to a time; after an error the plant has its last valid state.
    pub fn step_to(&mut self, next_s: f64, step_s: f64) -> Result<(), String> {
        if let Some(pull) = &mut self.pull {
            pull.apply(&mut self.plant, step_s);
        }
        let outcome = self.plant.step(next_s);
        self.watch.include(&self.plant, &self.scene.joints);
        outcome.map_err(|error| error.to_string())
    }

    /// Adds a sample of the plotted outputs.
    pub fn sample(&mut self) {
        if self.watched.is_empty() {
            return;
        }
        self.plant.provide(self.interface.needs(self.watched.as_slice()));
        self.samples.push(self.plant.time_s() as f32);
        for reference in &self.watched {
            let value = self.interface.get(&self.plant, self.plant.outputs(), *reference);
            self.samples.push(value.map_or(f32::NAN, |value| number(&value) as f32));
        }
    }

    /// Removes the samples that have not been sent.
    pub fn forget_samples(&mut self) {
        self.samples.clear();
    }

    /// State to which the machine can be rolled back.
    pub fn state(&self) -> State {
        State { snapshot: self.plant.snapshot(), held: self.pull.as_ref().map(|pull| pull.held) }
    }

    /// State at the start.
    pub fn first(&self) -> State {
        State { snapshot: self.first.clone(), held: None }
    }

    pub fn go_back(&mut self, state: &State) -> Result<(), String> {
        self.plant.restore(&state.snapshot).map_err(|error| error.to_string())?;
        if let Some(held) = state.held {
            held.release(&mut self.plant);
        }
        self.pull = None;
        self.samples.clear();
        let (now_s, mut watch) = (self.plant.time_s(), Watch::new(self.plant.machine()));
        watch.events = std::mem::take(&mut self.watch.events);
        watch.events.retain(|event| event.time_s <= now_s || event.kind == "gust");
        watch.include(&self.plant, &self.scene.joints);
        self.sent_events = watch.events.len();
        self.watch = watch;
        Ok(())
    }

    /// All events so far, for a page; `label` is the name of the machine if there are several.
    pub fn events(&self, label: Option<&str>) -> Vec<serde_json::Value> {
        self.watch.events.iter().map(|one| event(one, label)).collect()
    }

    /// Values of the controls in their order, without the force of a pull.
    pub fn values(&mut self) -> Vec<f64> {
        self.without_pull(|machine| {
            let Self { controls, interface, plant, .. } = machine;
            let value = |one: &Control| interface.get(plant, plant.outputs(), one.reference);
            controls.iter().map(|one| value(one).map_or(f64::NAN, |value| number(&value))).collect()
        })
    }

    /// Calls a function while the force of the pull is removed from the inputs.
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

    /// Whether an input or parameter of this name can be set during a run.
    pub fn has_control(&self, name: &str) -> bool {
        self.controls.iter().any(|one| one.name == name)
    }

    /// Current value of a control.
    pub fn value(&mut self, name: &str) -> Option<Given> {
        let at = self.controls.iter().position(|one| one.name == name)?;
        let value = *self.values().get(at)?;
        Some(if self.controls[at].kind == "switch" { Given::Switch(value > 0.5) } else { Given::Number(value) })
    }

    pub fn set(&mut self, name: &str, given: Given) -> Result<(), String> {
        let known = || self.controls.iter().map(|one| one.name.as_str());
        let Some(one) = self.controls.iter().find(|one| one.name == name) else {
            return Err(match self.interface.find(name) {
                Some(_) => format!("{name} cannot be set during a run: only inputs and tunable parameters can"),
                None => NameError::unknown(name, "input or tunable parameter", known()).to_string(),
            });
        };
        let (reference, kind) = (one.reference, one.kind);
        self.without_pull(|machine| {
            let (plant, row) = (&mut machine.plant, &[reference][..]);
            let outcome: Result<(), AccessError> = match (kind, given) {
                ("switch", Given::Switch(value)) => machine.interface.set_all(plant, row, &[value], Stage::Running),
                ("real", Given::Number(value)) => machine.interface.set_all(plant, row, &[value], Stage::Running),
                ("integer", Given::Number(value)) if value.fract() == 0.0 && value.abs() < f64::from(i32::MAX) => {
                    machine.interface.set_all(plant, row, &[value as i32], Stage::Running)
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

    /// Whether there is an output of this name.
    pub fn has_output(&self, name: &str) -> bool {
        self.interface.find(name).is_some_and(|row| row.causality == Causality::Output)
    }

    /// Adds outputs to those plotted, and returns whether any is new.
    pub fn add_watched(&mut self, names: &[&String]) -> Result<bool, String> {
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
        Ok(self.watched != before)
    }

    pub fn set_pull(&mut self, station: usize, target_m: Vector3<f64>, stiffness_n_m: f64) -> Result<(), String> {
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

    /// The machine's part of the next frame: samples (time and the values of `names`, row by row), then the state in the format of
    /// `run.js`.
    pub fn next_part(&mut self, label: Option<&str>) -> Part {
        self.plant.provide(OutputSet::ALL);
        let (rows, state) = numbers_of_frame(&self.scene, &Frame::of(&self.scene, &self.plant));
        let names = self.watched.iter().map(|row| self.interface.variables()[*row as usize].name.as_str());
        let description = json!({
            "pull": self.pull.as_ref().map(Pull::shown),
            "names": names.collect::<Vec<_>>(),
            "samples": self.samples.len() / (self.watched.len() + 1),
            "rows": rows,
            "numbers": state.len(),
        });
        let sent = self.sent_events.min(self.watch.events.len());
        self.sent_events = self.watch.events.len();
        let events = self.watch.events[sent..].iter().map(|one| event(one, label)).collect();
        Part { description, numbers: self.samples.drain(..).chain(state).collect(), events }
    }

    /// Length in m of the longest chain of bodies from the root.
    pub fn reach_m(&self) -> f64 {
        reach_m(self.plant.machine())
    }
}

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

fn event(event: &Event, label: Option<&str>) -> serde_json::Value {
    let text = label.map_or_else(|| event.text.clone(), |label| format!("{label}: {}", event.text));
    json!({ "t": event.time_s, "text": text, "kind": event.kind })
}
