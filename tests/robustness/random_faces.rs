//! Random calls for Model Exchange of either version and for co-simulation of FMI 3.0, as `random_calls.rs` for co-simulation of FMI 2.0.

use crate::faces::{Ask, Face, Handle, NEVER, NO_TYPES, Times, Vector};
use crate::fmi3::Phase;
use crate::fmu::Fmu;
use crate::fmu3::{Agreed, Fmu3};
use crate::random_arguments::{self as arguments, Verdict, pick};
use crate::random_session::models;
use crate::watchdog::Guard;
use fastrand::Rng;
use foldwing::interface::{Causality, Kind, Value, Variable};
use std::collections::BTreeMap;
use std::ffi::CStr;
use std::fmt;
use std::ptr;

/// Maximum number of saved states that an instance keeps.
const MAXIMUM_STATES: usize = 5;
/// Statuses.
const OK: u32 = 0;
const DISCARD: u32 = 2;
const ERROR: u32 = 3;

/// Interface of the instances in a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cast {
    Exchange2,
    Exchange3,
    Steps3,
}

/// Number of each status per function.
#[derive(Default)]
pub struct Tally(BTreeMap<(&'static str, u32), u64>);

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} calls: function, OK, Discard, Error", self.0.values().sum::<u64>())?;
        let names: std::collections::BTreeSet<_> = self.0.keys().map(|(name, _)| *name).collect();
        for name in names {
            let [ok, discard, error] =
                [OK, DISCARD, ERROR].map(|status| self.0.get(&(name, status)).copied().unwrap_or(0));
            writeln!(f, "  {name:36} {ok:8} {discard:8} {error:8}")?;
        }
        Ok(())
    }
}

/// A saved state, with the time and phase of its instance.
#[derive(Clone)]
struct Saved {
    handle: Handle,
    phase: Phase,
    bytes: Vec<u8>,
    /// Made of modified bytes: its content is unknown.
    forged: bool,
}

/// An instance, and its expected state.
struct Actor {
    name: String,
    face: Face,
    agreed: Agreed,
    phase: Phase,
    bytes: Vec<u8>,
    saved: Vec<Saved>,
    freed: Vec<Handle>,
    /// Saved state used to inspect the current state without leaving another one behind.
    probe: Handle,
    forged: bool,
    indicators: usize,
    /// Approximate values of the continuous states.
    states: Vec<f64>,
    /// Outputs of a new instance after a few steps.
    reference: Vec<u64>,
}

/// A call, its allowed statuses, and the saved state that it refers to.
struct Plan {
    ask: Ask,
    hole: u8,
    right: Vec<u32>,
    own: Option<usize>,
    forged: bool,
}

impl Plan {
    fn of(ask: Ask, right: &[u32]) -> Self {
        Self { ask, hole: 0, right: right.to_vec(), own: None, forged: false }
    }
}

pub struct Session {
    actors: Vec<Actor>,
}

impl Session {
    /// New instances of every model that the interface supports: two of each, because states are also exchanged between twins.
    pub fn new(cast: Cast) -> Self {
        let fits = |text: &str| {
            cast == Cast::Steps3 || !["uvlm", "bem"].iter().any(|air| text.contains(&format!("model = \"{air}\"")))
        };
        let actors = models()
            .iter()
            .filter(|(_, text)| fits(text))
            .flat_map(|model| [model, model])
            .enumerate()
            .map(|(number, (name, text))| {
                let pair = number / 2;
                let event_mode = pair % 3 != 0;
                let agreed = Agreed { event_mode, early_return: pair % 3 != 1, intermediate_update: pair % 2 == 1 };
                Actor::new(name, text, cast, agreed)
            })
            .collect();
        Self { actors }
    }

    /// One sequence of calls, reproducible by its seed alone.
    pub fn run(&mut self, seed: u64, calls: usize, guard: &Guard, tally: &mut Tally) {
        let mut rng = Rng::with_seed(seed);
        let first = rng.usize(..self.actors.len());
        let cast = [first, first ^ 1, (first + 2) % self.actors.len()];
        for call in 0..calls {
            let who = pick(&mut rng, &cast);
            let place = format!("FOLDWING_SEED={seed}, call {call}, model {}", self.actors[who].name);
            guard.note(|| place.clone());
            let others: Vec<Saved> = cast
                .iter()
                .filter(|&&other| other != who)
                .flat_map(|&other| self.actors[other].saved.clone())
                .collect();
            match self.actors[who].turn(&mut rng, &others) {
                Ok(made) => *tally.0.entry(made).or_default() += 1,
                Err(complaint) => panic!("{place}: {complaint}"),
            }
        }
        for who in cast {
            guard.note(|| format!("FOLDWING_SEED={seed}, end, model {}", self.actors[who].name));
            self.actors[who].start_afresh(seed);
        }
    }
}

impl Actor {
    fn new(name: &str, text: &str, cast: Cast, agreed: Agreed) -> Self {
        let face = match cast {
            Cast::Exchange2 => Face::Exchange2(Fmu::exchanged(text)),
            Cast::Exchange3 => Face::Exchange3(Fmu3::exchanged(text)),
            Cast::Steps3 => Face::Steps3(Fmu3::new(text, agreed)),
        };
        let mut probe = Ask::Save(ptr::null_mut());
        assert_eq!(face.make(&mut probe, 0), OK);
        let Ask::Save(probe) = probe else { unreachable!() };
        let indicators = match &face {
            Face::Exchange2(fmu) => crate::model_exchange::indicators_of(fmu),
            _ => {
                let mut count = Ask::Count(Vector::Indicators, 0);
                let status = face.make(&mut count, 0);
                let Ask::Count(_, count) = count else { unreachable!() };
                assert_eq!(status, if face.exchanges() { OK } else { ERROR });
                count
            }
        };
        face.told();
        let states = vec![0.0; face.table().nominals().len()];
        let mut actor = Self {
            name: name.to_owned(),
            face,
            agreed,
            phase: Phase::Instantiated,
            bytes: Vec::new(),
            saved: Vec::new(),
            freed: Vec::new(),
            probe,
            forged: false,
            indicators,
            states,
            reference: Vec::new(),
        };
        actor.bytes = actor.present();
        actor.reference = actor.walk();
        actor.good(Ask::Reset);
        assert_eq!(actor.present(), actor.bytes, "a reset instance is a fresh one");
        actor
    }

    /// Makes a call that must succeed.
    fn good(&self, mut ask: Ask) -> Ask {
        let status = self.face.make(&mut ask, 0);
        assert_eq!(status, OK, "{}: {ask:?}: {:?}", self.name, self.face.told());
        ask
    }

    /// Bytes of the current state.
    fn present(&self) -> Vec<u8> {
        self.good(Ask::Save(self.probe));
        self.face.serialize(self.probe)
    }

    fn vector(&self, which: Vector, n: usize) -> Vec<f64> {
        match self.good(Ask::Read(which, vec![0.0; n])) {
            Ask::Read(_, values) => values,
            _ => unreachable!(),
        }
    }

    /// Steps from the instantiated state through three steps; returns every Real of the model.
    fn walk(&mut self) -> Vec<u64> {
        let times = Times { tolerance: None, start_s: 0.0, stop_s: None };
        if self.face.version() == 0 {
            // the model may start later
            self.good(Ask::Experiment(times));
        }
        self.good(Ask::EnterInitialization(times));
        self.good(Ask::ExitInitialization);
        if self.face.exchanges() {
            self.good(Ask::Update);
            self.good(Ask::EnterContinuous);
            let n = self.states.len();
            self.states = self.vector(Vector::States, n);
            let mut states = self.states.clone();
            for i in 0..3 {
                self.good(Ask::SetTime(1e-6 * f64::from(i)));
                self.good(Ask::SetStates(states.clone()));
                let slope = self.vector(Vector::Derivatives, n);
                states.iter_mut().zip(slope).for_each(|(state, slope)| *state += 1e-6 * slope);
            }
        } else {
            if self.agreed.event_mode {
                self.good(Ask::Update);
                self.good(Ask::EnterStep);
            }
            let mut begin_s = 0.0;
            for _ in 0..3 {
                let step =
                    self.good(Ask::Step { time_s: begin_s, step_s: 1e-3, event: false, early: false, last_s: 0.0 });
                let Ask::Step { last_s, .. } = step else { unreachable!() };
                begin_s = last_s;
            }
        }
        self.face.bits()
    }

    /// Resets the instance and compares it with a new one; discards all saved states.
    fn start_afresh(&mut self, seed: u64) {
        for state in std::mem::take(&mut self.saved) {
            self.good(Ask::Free(state.handle));
        }
        self.agree_to_return(None);
        self.good(Ask::Reset);
        let bits = self.walk();
        assert!(bits == self.reference, "FOLDWING_SEED={seed}, model {}: reset is not fresh", self.name);
        self.good(Ask::Reset);
        (self.phase, self.forged) = (Phase::Instantiated, false);
        self.freed.clear();
        self.bytes = self.present();
        self.face.told();
    }

    /// Time from which on the importer ends steps early, and the end time, in s.
    fn agree_to_return(&self, when: Option<(f64, f64)>) {
        if let Face::Steps3(fmu) = &self.face {
            fmu.environment.returns.set(when);
            fmu.environment.asked.borrow_mut().clear();
        }
    }

    /// Makes one call and checks all properties that must hold after it; returns function and status.
    fn turn(&mut self, rng: &mut Rng, others: &[Saved]) -> Result<(&'static str, u32), String> {
        let mut plan = self.draw(rng, others);
        let name = plan.ask.names()[self.face.version()];
        let (was, legal) = (self.phase, self.face.is_legal(name, self.phase));
        let mut own_s = f64::NAN;
        if let (Ask::Step { time_s, step_s, .. }, true) = (&mut plan.ask, legal) {
            own_s = self.time_s();
            *time_s += own_s;
            let sound = *step_s > 0.0 && *step_s < 1e6 && *time_s + *step_s > *time_s;
            if !sound || (*time_s - own_s).abs() > 1e-9 || !time_s.is_finite() {
                plan.right = vec![ERROR];
            }
        }
        let status = self.face.make(&mut plan.ask, plan.hole);
        // a step may give a warning in addition to its result, and so does a start value that is not used
        let advises = matches!(plan.ask, Ask::Step { .. } | Ask::Set(..));
        let beside = |told: &(u32, String, String)| told.1 == "logEvents" || advises && told.1 == "logStatusWarning";
        let told: Vec<_> = self.face.told().into_iter().filter(|told| !beside(told)).collect();
        let complaint =
            |what: &str| format!("{name} {}: {what}; status {status}, {told:?}, {:?}", was.phrase(), plan.ask);
        let right = if legal { plan.right.as_slice() } else { &[ERROR] };
        if !right.contains(&status) {
            return Err(complaint(&format!("expected {right:?}")));
        }
        match (told.as_slice(), status) {
            ([], OK) => {}
            ([(said, category, text)], status) if status != OK => {
                let expected = if status == DISCARD { "logStatusDiscard" } else { "logStatusError" };
                let head = format!("{name}: not legal {}", self.face.phrase(was));
                if *said != status
                    || category != expected
                    || !text.starts_with(&format!("{name}: "))
                    || text.len() > 2000
                {
                    return Err(complaint("the message does not fit"));
                }
                if text.starts_with(&head) == legal {
                    return Err(complaint("the life cycle says otherwise"));
                }
            }
            _ => return Err(complaint("one message for a refusal, none otherwise")),
        }
        let found = self.face.phase();
        let expected = self.led_to(&plan, was, status, found);
        if found != expected {
            return Err(complaint(&format!("leads to {found:?} instead of {expected:?}")));
        }
        self.phase = found;
        let present = self.present();
        // values are computed when they are read, from the values set by the importer, and are part of the state
        let finds = matches!(
            plan.ask,
            Ask::Get(..) | Ask::Read(..) | Ask::Completed | Ask::Update | Ask::EnterEvent | Ask::ExitInitialization
        ) && self.face.exchanges();
        // FMI 3.0 sets no rates of inputs; rates from corrupted bytes end with an event, failed or not
        let finds = finds || self.forged && matches!(plan.ask, Ask::Update);
        let evaluates = was == Phase::Initialization && status != ERROR;
        let reads = name[4..].starts_with("Get") && !matches!(plan.ask, Ask::Rates(..));
        let kept = !legal || !finds && !evaluates && (reads || status != OK && found != Phase::Failed);
        if kept && present != self.bytes {
            // after the checksum
            let differ = |at: &usize| present.get(*at) != self.bytes.get(*at);
            let at: Vec<usize> = (60..present.len().max(self.bytes.len())).filter(differ).take(8).collect();
            let around = |bytes: &[u8]| bytes.get(at.first().map_or(0..0, |at| at - 9..at + 9)).map(<[u8]>::to_vec);
            let (now, before) = (around(&present), around(&self.bytes));
            return Err(complaint(&format!("the state has changed, at bytes {at:?}: {before:?} to {now:?}")));
        }
        self.bytes = present;
        self.follow(&plan, status, own_s).map_err(|what| complaint(&what))?;
        Ok((name, status))
    }

    /// The phase after a call according to the standard.
    fn led_to(&self, plan: &Plan, was: Phase, status: u32, found: Phase) -> Phase {
        if status != OK {
            let failed = matches!(plan.ask, Ask::Step { .. }) && found == Phase::Failed;
            return if failed { found } else { was };
        }
        match plan.ask {
            Ask::EnterInitialization(_) => Phase::Initialization,
            Ask::ExitInitialization if self.face.exchanges() || self.agreed.event_mode => Phase::Event,
            Ask::ExitInitialization | Ask::EnterStep => Phase::Step,
            Ask::Terminate => Phase::Terminated,
            Ask::Reset => Phase::Instantiated,
            Ask::EnterEvent => Phase::Event,
            Ask::EnterContinuous => Phase::Continuous,
            Ask::Restore(_) => match plan.own {
                Some(own) if !self.saved[own].forged => self.saved[own].phase,
                _ => found,
            },
            _ => was,
        }
    }

    /// Records the results of a call and checks them.
    fn follow(&mut self, plan: &Plan, status: u32, own_s: f64) -> Result<(), String> {
        if let Ask::Step { time_s, step_s, event, early, last_s } = plan.ask {
            if !self.forged && (status == OK || self.phase == Phase::Failed) {
                let bits = self.face.bits();
                if let Some(real) = bits.iter().position(|bits| !f64::from_bits(*bits).is_finite()) {
                    return Err(format!("{} is not finite", self.face.real(real)));
                }
            }
            let end_s = time_s + step_s;
            let told = self.agreed.early_return || !event && !early;
            let sound = status != OK || early == (last_s < end_s) && last_s >= own_s - 1e-9 && last_s <= end_s && told;
            return if sound { Ok(()) } else { Err(format!("a step from {own_s} s gives {:?}", plan.ask)) };
        }
        if status != OK {
            return Ok(());
        }
        match &plan.ask {
            Ask::Reset => self.forged = false,
            Ask::Read(which, values) => {
                // an indicator may be infinite: only its sign matters to an importer
                let sound = |value: &f64| value.is_finite() || *which == Vector::Indicators && value.is_infinite();
                if !self.forged && !values.iter().all(sound) {
                    return Err("a value is not finite".to_owned());
                }
                if *which == Vector::States && !self.forged {
                    self.states.clone_from(values);
                }
            }
            Ask::Save(handle) => {
                let saved =
                    Saved { handle: *handle, phase: self.phase, bytes: self.bytes.clone(), forged: self.forged };
                match plan.own {
                    Some(own) => self.saved[own] = saved,
                    None => self.saved.push(saved),
                }
            }
            Ask::Free(handle) => {
                if let (Some(own), 0) = (plan.own, plan.hole) {
                    assert!(handle.is_null(), "the handle is cleared");
                    self.freed.push(self.saved.remove(own).handle);
                }
            }
            Ask::Restore(_) => {
                let saved = &self.saved[plan.own.expect("its own")];
                self.forged = saved.forged;
                if !saved.forged && self.bytes != saved.bytes {
                    return Err("the restored state is another one".to_owned());
                }
            }
            Ask::Size(_, size) if *size != self.saved[plan.own.expect("its own")].bytes.len() => {
                return Err(format!("size {size}"));
            }
            Ask::Write(_, room) => {
                let bytes = &self.saved[plan.own.expect("its own")].bytes;
                if room[..bytes.len()] != *bytes || room[bytes.len()..].iter().any(|byte| *byte != 0xaa) {
                    return Err("other bytes than before, or more of them".to_owned());
                }
            }
            Ask::Parse(_, handle) => {
                let bytes = self.face.serialize(*handle);
                let phase = plan.own.map_or(self.phase, |own| self.saved[own].phase);
                // time and phase are known only for a state of this instance
                let forged = plan.forged || plan.own.is_none();
                self.saved.push(Saved { handle: *handle, phase, bytes, forged });
            }
            _ => {}
        }
        if self.saved.len() > MAXIMUM_STATES {
            let oldest = self.saved.remove(0).handle;
            self.freed.push(oldest);
            self.good(Ask::Free(oldest));
        }
        Ok(())
    }

    /// The instance's time in s.
    fn time_s(&self) -> f64 {
        match self.good(Ask::Get(Kind::Real, vec![0], vec![0.0])) {
            Ask::Get(_, _, values) => values[0],
            _ => unreachable!(),
        }
    }
}

#[path = "random_asks.rs"]
mod asks;
