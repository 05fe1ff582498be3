//! A session of random calls: instances, the expected results of each call, and the properties that must hold after it.
//!
//! Longer than other files: there is one method per call on the same instance, and they share the checks afterwards.

use crate::fmu::{Fmu, WING};
use crate::machines::{View, draw};
use crate::random_arguments::{self as arguments, Verdict, batch, pick};
use crate::random_calls::number;
use crate::standard::{PHASES, Phase, TABLE, row_of};
use crate::watchdog::Guard;
use fastrand::Rng;
use foldwing::interface::{Causality, Kind, Value};
use foldwing_fmu::derivatives::*;
use foldwing_fmu::functions::*;
use foldwing_fmu::states::*;
use foldwing_fmu::status::*;
use foldwing_fmu::types::*;
use std::collections::BTreeMap;
use std::ffi::CString;
use std::fmt;
use std::ptr;

/// Instances of each model in a session, and of one sequence.
const OF_EACH_MODEL: usize = 2;
const IN_A_SEQUENCE: usize = 3;
/// Maximum number of saved states that an instance keeps.
const MAXIMUM_STATES: usize = 6;
/// Any status that a call may have; only a panic gives `fmi2Fatal`.
const ANY: &[fmi2Status] = &[fmi2OK, fmi2Discard, fmi2Error];

/// Random machines of a session, in addition to the shipped models: rotors, modal and rigid bodies, failures, end stops, generators,
/// springs, control surfaces, polars, loops. Each is created again from time to time, so their number determines the duration.
const DRAWN: usize = 12;

/// Models by name: all shipped models except the twin with strips, with a coarser lattice, and the generator's first valid machines. With
/// `FOLDWING_FEW`, that many of them, spread over the list: under valgrind creating an instance of each takes most of the time.
pub fn models() -> Vec<(String, String)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models");
    let mut models: Vec<(String, String)> = std::fs::read_dir(folder)
        .expect("the models")
        .map(|entry| entry.expect("readable").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .map(|path| {
            let text = std::fs::read_to_string(&path).expect("readable");
            let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
            let thin = [
                ("strips = 10", "strips = 3"),
                ("chord_panels = 4", "chord_panels = 2"),
                ("wake_rows = 30", "wake_rows = 4"),
            ];
            (name, thin.iter().fold(text, |text, (from, to)| text.replace(from, to)))
        })
        .collect();
    models.sort();
    let drawn = (0..).map(|seed| (format!("drawn from {seed}"), draw(seed).text(&View::plain())));
    // machines in real-time mode have outputs that measure the clock
    models.extend(drawn.filter(|(_, text)| !text.contains("real_time") && runs(text)).take(DRAWN));
    assert!(models.len() >= 11 && models.iter().any(|(_, text)| text == WING), "the shipped models");
    if let Some(few) = number("FOLDWING_FEW") {
        let all = models.len();
        return (0..few).map(|taken| models[taken * all / few].clone()).collect();
    }
    models
}

/// Returns whether a machine starts and executes the steps used for comparing instances.
fn runs(text: &str) -> bool {
    let Ok(machine) = foldwing::config::parse(text, "machine.toml") else { return false };
    let mut plant = foldwing::plant::Plant::new(std::sync::Arc::new(machine));
    plant.initialize(0.0).and_then(|()| plant.step(3e-3)).is_ok()
}

/// Number of each status per function.
#[derive(Default)]
pub struct Tally(BTreeMap<(&'static str, fmi2Status), u64>);

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = |name, status| self.0.get(&(name, status)).copied().unwrap_or(0);
        writeln!(f, "{} calls: function, OK, Discard, Error", self.0.values().sum::<u64>())?;
        for name in TABLE.iter().map(|row| row.name).chain(["fmi2Instantiate", "fmi2FreeInstance"]) {
            let [ok, discard, error] = [fmi2OK, fmi2Discard, fmi2Error].map(|status| of(name, status));
            writeln!(f, "  {name:30} {ok:8} {discard:8} {error:8}")?;
        }
        Ok(())
    }
}

/// A saved state, with the time and phase of its instance.
#[derive(Clone)]
struct Saved {
    handle: fmi2FMUstate,
    phase: Phase,
    bytes: Vec<u8>,
    /// Made of modified bytes: its content is unknown.
    forged: bool,
}

/// An instance, and its expected state.
struct Actor {
    name: String,
    fmu: Fmu,
    phase: Phase,
    bytes: Vec<u8>,
    states: Vec<Saved>,
    freed: Vec<fmi2FMUstate>,
    /// Saved state used to inspect the current state without leaving another one behind.
    probe: fmi2FMUstate,
    /// Whether the current state has unknown content.
    forged: bool,
    /// Outputs of a new instance after a few steps.
    reference: Vec<u64>,
}

/// Result of a call: function, status, expected statuses, and a part of the message.
struct Outcome {
    name: &'static str,
    status: fmi2Status,
    right: Vec<fmi2Status>,
    part: &'static str,
}

pub struct Session {
    models: Vec<(String, String)>,
    actors: Vec<Actor>,
}

impl Session {
    /// A session with new instances.
    pub fn new() -> Self {
        let models = models();
        let actors = models
            .iter()
            .flat_map(|model| std::iter::repeat_n(model, OF_EACH_MODEL))
            .map(|(name, text)| Actor::new(name, text))
            .collect();
        Self { models, actors }
    }

    /// One sequence of calls, reproducible by its seed alone.
    pub fn run(&mut self, seed: u64, calls: usize, guard: &Guard, tally: &mut Tally) {
        let mut rng = Rng::with_seed(seed);
        let mut cast: Vec<usize> = (0..IN_A_SEQUENCE).map(|_| rng.usize(..self.actors.len())).collect();
        // two of one model, so that states can be exchanged between twins
        cast[1] = cast[0] ^ 1;
        if cast[2] == cast[0] || cast[2] == cast[1] {
            cast[2] = (cast[0] + 2) % self.actors.len();
        }
        for call in 0..calls {
            let who = pick(&mut rng, &cast);
            let label = || format!("FOLDWING_SEED={seed}, call {call}, model {}", self.actors[who].name);
            guard.note(label);
            let others: Vec<Saved> = cast
                .iter()
                .filter(|other| **other != who)
                .flat_map(|other| self.actors[*other].states.clone())
                .collect();
            let actor = &mut self.actors[who];
            let outcome = actor.call(&mut rng, &others);
            *tally.0.entry((outcome.name, outcome.status)).or_default() += 1;
            if let Err(complaint) = actor.check(&outcome) {
                panic!("FOLDWING_SEED={seed}, call {call}, model {}, {}: {complaint}", actor.name, outcome.name);
            }
        }
        for who in cast {
            guard.note(|| format!("FOLDWING_SEED={seed}, end, model {}", self.actors[who].name));
            self.actors[who].start_afresh(seed);
            if rng.u8(..8) == 0 {
                let (name, text) = &self.models[who / OF_EACH_MODEL];
                self.actors[who] = Actor::new(name, text);
                for name in ["fmi2Instantiate", "fmi2FreeInstance"] {
                    *tally.0.entry((name, fmi2OK)).or_default() += 1;
                }
            }
        }
    }
}

impl Actor {
    fn new(name: &str, text: &str) -> Self {
        let fmu = Fmu::new(text);
        let probe = fmu.save();
        let mut actor = Self {
            name: name.to_owned(),
            fmu,
            phase: Phase::Instantiated,
            bytes: Vec::new(),
            states: Vec::new(),
            freed: Vec::new(),
            probe,
            forged: false,
            reference: Vec::new(),
        };
        actor.bytes = actor.present();
        actor.reference = actor.walk();
        unsafe { actor.fmu.ok(fmi2Reset(actor.fmu.component)) };
        assert_eq!(actor.present(), actor.bytes, "a reset instance is a fresh one");
        actor
    }

    /// Bytes of the current state.
    fn present(&self) -> Vec<u8> {
        let mut probe = self.probe;
        self.fmu.ok(unsafe { fmi2GetFMUstate(self.fmu.component, &mut probe) });
        self.fmu.serialize(probe)
    }

    /// Steps from the instantiated state through three steps; returns every Real of the model.
    fn walk(&self) -> Vec<u64> {
        let (fmu, c) = (&self.fmu, self.fmu.component);
        fmu.setup(0.0, None);
        unsafe {
            fmu.ok(fmi2EnterInitializationMode(c));
            fmu.ok(fmi2ExitInitializationMode(c));
        }
        for i in 0..3 {
            fmu.step(1e-3 * f64::from(i), 1e-3);
        }
        fmu.bits()
    }

    /// Resets the instance and compares it with a new one; discards all saved states.
    fn start_afresh(&mut self, seed: u64) {
        let c = self.fmu.component;
        for state in self.states.drain(..) {
            self.fmu.ok(unsafe { fmi2FreeFMUstate(c, &mut { state.handle }) });
        }
        unsafe {
            self.fmu.ok(fmi2SetDebugLogging(c, fmi2False, 0, ptr::null()));
            self.fmu.ok(fmi2Reset(c));
        }
        let bits = self.walk();
        assert!(bits == self.reference, "FOLDWING_SEED={seed}, model {}: reset is not fresh", self.name);
        unsafe { self.fmu.ok(fmi2Reset(c)) };
        (self.phase, self.forged) = (Phase::Instantiated, false);
        self.freed.clear();
        self.bytes = self.present();
    }

    /// Returns whether the initialisation is finished.
    fn started(&self) -> bool {
        !matches!(self.phase, Phase::Instantiated | Phase::Initialization)
    }

    /// The instance's time in s.
    fn time_s(&self) -> f64 {
        let mut time_s = 0.0;
        self.fmu.ok(unsafe { fmi2GetRealStatus(self.fmu.component, fmi2LastSuccessfulTime, &mut time_s) });
        time_s
    }

    /// The phase given by the instance.
    fn phase_named(&self) -> Phase {
        assert_eq!(unsafe { fmi2CancelStep(self.fmu.component) }, fmi2Error);
        let text = self.fmu.messages.borrow_mut().pop().expect("a refusal is told").text;
        let rest = text.strip_prefix("fmi2CancelStep: not legal ").unwrap_or_else(|| panic!("{text}"));
        *PHASES.iter().find(|phase| rest.starts_with(phase.phrase())).unwrap_or_else(|| panic!("{text}"))
    }

    /// Properties after every call.
    fn check(&mut self, outcome: &Outcome) -> Result<(), String> {
        let Outcome { name, status, right, part } = outcome;
        // a step may in addition warn of high cost
        let warns = |category: &str| *name == "fmi2DoStep" && category == "logStatusWarning";
        let told: Vec<_> = (self.fmu.messages.borrow_mut().drain(..))
            .filter(|told| told.category != "logEvents" && !warns(&told.category))
            .collect();
        if !right.contains(status) {
            return Err(format!("status {status}, expected {right:?}; {told:?}"));
        }
        match (told.as_slice(), *status) {
            ([], status) if status == fmi2OK => {}
            ([message], status) if status != fmi2OK => {
                let category = if status == fmi2Discard { "logStatusDiscard" } else { "logStatusError" };
                let sound = message.status == status && message.category == category;
                let text = &message.text;
                if !sound || !text.starts_with(&format!("{name}: ")) || !text.contains(part) || text.len() > 2000 {
                    return Err(format!("message {message:?}, expected {part:?}"));
                }
            }
            _ => return Err(format!("status {status} with the messages {told:?}")),
        }
        let present = self.present();
        let failed_step = *name == "fmi2DoStep" && *status != fmi2OK && self.phase == Phase::StepFailed;
        let reads = row_of(name).effect == crate::standard::Effect::Reads && self.phase != Phase::Initialization;
        if (*status != fmi2OK && !failed_step || reads) && present != self.bytes {
            return Err(format!("status {status}, and the state has changed"));
        }
        self.bytes = present;
        if *name == "fmi2DoStep" && !self.forged && (*status == fmi2OK || failed_step) {
            let table = self.fmu.table.variables();
            let bits = self.fmu.bits();
            let reals = table.iter().filter(|row| row.value.kind() == Kind::Real);
            if let Some((row, _)) = reals.zip(bits).find(|(_, bits)| !f64::from_bits(*bits).is_finite()) {
                return Err(format!("{} is not finite after a step", row.name));
            }
        }
        Ok(())
    }

    /// One random call.
    fn call(&mut self, rng: &mut Rng, others: &[Saved]) -> Outcome {
        let name = self.choose(rng);
        let legal = row_of(name).is_legal(self.phase);
        let (status, mut right, mut part) = match name {
            "fmi2GetReal" | "fmi2GetInteger" | "fmi2GetBoolean" | "fmi2GetString" => self.get(rng, name),
            "fmi2SetReal" | "fmi2SetInteger" | "fmi2SetBoolean" | "fmi2SetString" => self.set(rng, name),
            "fmi2GetFMUstate" | "fmi2SetFMUstate" | "fmi2FreeFMUstate" => self.state(rng, name, others),
            "fmi2SerializedFMUstateSize" | "fmi2SerializeFMUstate" => self.serialize(rng, name, others),
            "fmi2DeSerializeFMUstate" => self.deserialize(rng, others),
            "fmi2SetRealInputDerivatives" | "fmi2GetRealOutputDerivatives" => self.rates(rng, name),
            "fmi2GetDirectionalDerivative" => self.directional(rng),
            "fmi2DoStep" => self.step(rng),
            _ => self.lead(rng, name),
        };
        if !legal {
            (right, part) = (vec![fmi2Error], "not legal");
        }
        self.follow(name, status);
        Outcome { name, status, right, part }
    }

    /// Records the phase after a call.
    fn follow(&mut self, name: &str, status: fmi2Status) {
        use crate::standard::Effect;
        if status != fmi2OK {
            return;
        }
        if let Effect::To(phase) = row_of(name).effect {
            self.phase = phase;
            self.forged &= phase != Phase::Instantiated;
        }
    }

    /// A function, mostly a legal one that lets the run continue.
    fn choose(&self, rng: &mut Rng) -> &'static str {
        let on = match self.phase {
            Phase::Instantiated => "fmi2EnterInitializationMode",
            Phase::Initialization => "fmi2ExitInitializationMode",
            Phase::StepComplete => "fmi2DoStep",
            Phase::StepFailed => "fmi2SetFMUstate",
            Phase::Terminated => "fmi2Reset",
        };
        match rng.u8(..20) {
            0..=3 => on,
            4..=6 => "fmi2SetReal",
            7..=8 => "fmi2GetReal",
            _ => loop {
                let row = &TABLE[rng.usize(..TABLE.len())];
                let ends = matches!(row.name, "fmi2Reset" | "fmi2Terminate");
                let rare = if ends {
                    12
                } else if row.is_legal(self.phase) {
                    1
                } else {
                    4
                };
                if rng.u8(..rare) == 0 {
                    break row.name;
                }
            },
        }
    }

    fn get(&mut self, rng: &mut Rng, name: &str) -> (fmi2Status, Vec<fmi2Status>, &'static str) {
        let table = &self.fmu.table;
        let kind = kind_of(name);
        let references = arguments::references(rng, table, |row| row.value.kind() == kind);
        let n = references.len();
        let mut verdict = batch(references.iter().map(|&reference| arguments::reading(table, reference, kind)));
        let (vr, null) = if rng.u8(..40) == 0 { (ptr::null(), n > 0) } else { (references.as_ptr(), false) };
        let no_room = kind != Kind::String && rng.u8(..40) == 0;
        if null || no_room && n > 0 {
            verdict = Verdict::BadCall;
        }
        const UNTOUCHED: f64 = -77.0;
        let (mut reals, mut integers) = (vec![UNTOUCHED; n], vec![UNTOUCHED as i32; n]);
        let (to_reals, to_integers) =
            if no_room { (ptr::null_mut(), ptr::null_mut()) } else { (reals.as_mut_ptr(), integers.as_mut_ptr()) };
        let c = self.fmu.component;
        let status = unsafe {
            match kind {
                Kind::Real => fmi2GetReal(c, vr, n, to_reals),
                Kind::Integer => fmi2GetInteger(c, vr, n, to_integers),
                Kind::Boolean => fmi2GetBoolean(c, vr, n, to_integers),
                Kind::String => fmi2GetString(c, vr, n, ptr::null_mut()),
            }
        };
        let mut right = statuses(verdict);
        if status != fmi2OK {
            let touched =
                reals.iter().any(|real| *real != UNTOUCHED) || integers.iter().any(|i| *i != UNTOUCHED as i32);
            assert!(!touched, "{name} refused and wrote");
        }
        if self.phase == Phase::Initialization && verdict == Verdict::Taken {
            // there may be no consistent state for the start values
            right.push(fmi2Error);
        }
        (status, right, "")
    }

    fn set(&mut self, rng: &mut Rng, name: &str) -> (fmi2Status, Vec<fmi2Status>, &'static str) {
        let table = &self.fmu.table;
        let kind = kind_of(name);
        let wanted = |row: &foldwing::interface::Variable| {
            row.value.kind() == kind && (arguments::is_settable(row) || kind == Kind::Integer)
        };
        let references = arguments::references(rng, table, wanted);
        let n = references.len();
        let row = |reference: u32| table.variables().get(reference as usize);
        let reals: Vec<f64> = references.iter().map(|&reference| arguments::real(rng, row(reference))).collect();
        let integers: Vec<i32> = references.iter().map(|_| pick(rng, &[0, 1, 1, -1, i32::MAX, i32::MIN])).collect();
        let value = |i: usize| match kind {
            Kind::Real => Value::Real(reals[i]),
            Kind::Integer => Value::Integer(integers[i]),
            _ => Value::Boolean(integers[i] != 0),
        };
        let started = self.started();
        let mut verdict = if kind == Kind::String {
            if n == 0 { Verdict::Taken } else { Verdict::BadCall }
        } else {
            batch(
                references
                    .iter()
                    .enumerate()
                    .map(|(i, &reference)| arguments::setting(table, reference, value(i), started, false)),
            )
        };
        let (vr, null) = if rng.u8(..40) == 0 { (ptr::null(), n > 0) } else { (references.as_ptr(), false) };
        let no_values = kind != Kind::String && rng.u8(..40) == 0;
        if null || no_values && n > 0 {
            verdict = Verdict::BadCall;
        }
        let (of_reals, of_integers) =
            if no_values { (ptr::null(), ptr::null()) } else { (reals.as_ptr(), integers.as_ptr()) };
        let c = self.fmu.component;
        let status = unsafe {
            match kind {
                Kind::Real => fmi2SetReal(c, vr, n, of_reals),
                Kind::Integer => fmi2SetInteger(c, vr, n, of_integers),
                Kind::Boolean => fmi2SetBoolean(c, vr, n, of_integers),
                Kind::String => fmi2SetString(c, vr, n, ptr::null()),
            }
        };
        (status, statuses(verdict), "")
    }

    /// A handle: of this instance, of another one, freed, invented, or null.
    fn handle(&self, rng: &mut Rng, others: &[Saved]) -> (fmi2FMUstate, Option<usize>) {
        let own = (!self.states.is_empty()).then(|| rng.usize(..self.states.len()));
        let wild = match rng.u8(..12) {
            0 => ptr::null_mut(),
            1 => ptr::without_provenance_mut(rng.usize(1..4096)),
            2 if !self.freed.is_empty() => pick(rng, &self.freed),
            3 if !others.is_empty() => others[rng.usize(..others.len())].handle,
            _ => match own {
                Some(own) => return (self.states[own].handle, Some(own)),
                None => ptr::null_mut(),
            },
        };
        (wild, None)
    }

    fn state(&mut self, rng: &mut Rng, name: &str, others: &[Saved]) -> (fmi2Status, Vec<fmi2Status>, &'static str) {
        let (handle, own) = self.handle(rng, others);
        let c = self.fmu.component;
        let known = if own.is_some() { vec![fmi2OK] } else { vec![fmi2Error] };
        let unknown = if handle.is_null() { "is null" } else { "freed or belongs to another instance" };
        match name {
            "fmi2GetFMUstate" => {
                let mut place = handle;
                let nowhere = rng.u8(..30) == 0;
                let status = unsafe { fmi2GetFMUstate(c, if nowhere { ptr::null_mut() } else { &mut place }) };
                let fresh = handle.is_null();
                if status == fmi2OK {
                    let saved =
                        Saved { handle: place, phase: self.phase, bytes: self.bytes.clone(), forged: self.forged };
                    match own {
                        Some(own) => self.states[own] = saved,
                        None => self.states.push(saved),
                    }
                    self.forget_the_oldest();
                }
                let right = if nowhere {
                    vec![fmi2Error]
                } else if fresh {
                    vec![fmi2OK]
                } else {
                    known
                };
                (status, right, "")
            }
            "fmi2FreeFMUstate" => {
                let mut place = handle;
                let nowhere = rng.u8(..30) == 0;
                let status = unsafe { fmi2FreeFMUstate(c, if nowhere { ptr::null_mut() } else { &mut place }) };
                if let (Some(own), false) = (own, nowhere) {
                    assert!(place.is_null(), "the handle is cleared");
                    self.freed.push(self.states.remove(own).handle);
                }
                let nothing = nowhere || handle.is_null();
                (status, if nothing { vec![fmi2OK] } else { known }, if nothing { "" } else { unknown })
            }
            _ => {
                let status = unsafe { fmi2SetFMUstate(c, handle) };
                let Some(own) = own else { return (status, known, unknown) };
                let saved = self.states[own].clone();
                let right = if saved.forged { vec![fmi2OK, fmi2Error] } else { known };
                if status == fmi2OK {
                    (self.phase, self.forged) = (saved.phase, saved.forged);
                    if saved.forged {
                        self.phase = self.phase_named();
                    } else {
                        assert!(self.present() == saved.bytes, "{}: the restored state is another one", self.name);
                    }
                }
                (status, right, "")
            }
        }
    }

    /// Keeps the number of saved states small.
    fn forget_the_oldest(&mut self) {
        if self.states.len() > MAXIMUM_STATES {
            let mut oldest = self.states.remove(0).handle;
            self.freed.push(oldest);
            self.fmu.ok(unsafe { fmi2FreeFMUstate(self.fmu.component, &mut oldest) });
        }
    }

    fn serialize(
        &mut self,
        rng: &mut Rng,
        name: &str,
        others: &[Saved],
    ) -> (fmi2Status, Vec<fmi2Status>, &'static str) {
        let (handle, own) = self.handle(rng, others);
        let c = self.fmu.component;
        let needed = own.map_or(1000, |own| self.states[own].bytes.len());
        if name == "fmi2SerializedFMUstateSize" {
            let mut size = 0;
            let nowhere = rng.u8(..30) == 0;
            let status =
                unsafe { fmi2SerializedFMUstateSize(c, handle, if nowhere { ptr::null_mut() } else { &mut size }) };
            assert!(status != fmi2OK || size == needed, "size {size} of a state of {needed} bytes");
            return (status, if own.is_some() && !nowhere { vec![fmi2OK] } else { vec![fmi2Error] }, "");
        }
        let room = match rng.u8(..6) {
            0 => rng.usize(..needed),
            1 => needed + rng.usize(..50),
            _ => needed,
        };
        let mut bytes = vec![0xaa_u8; room];
        let nowhere = rng.u8(..30) == 0;
        let place = if nowhere { ptr::null_mut() } else { bytes.as_mut_ptr().cast() };
        let status = unsafe { fmi2SerializeFMUstate(c, handle, place, room) };
        let sound = own.is_some() && room >= needed && !nowhere;
        if let (Some(own), true) = (own, status == fmi2OK) {
            assert!(bytes[..needed] == self.states[own].bytes, "{}: other bytes than before", self.name);
            assert!(bytes[needed..].iter().all(|byte| *byte == 0xaa), "written beyond the state");
        }
        (status, if sound { vec![fmi2OK] } else { vec![fmi2Error] }, "")
    }

    fn deserialize(&mut self, rng: &mut Rng, others: &[Saved]) -> (fmi2Status, Vec<fmi2Status>, &'static str) {
        // a state of this instance, of its twin, or of another model
        let pool: Vec<&Saved> = self.states.iter().chain(others).collect();
        let (mut bytes, phase, mut forged) = match pool.len() {
            0 => (self.bytes.clone(), self.phase, self.forged),
            n => {
                let saved = pool[rng.usize(..n)];
                (saved.bytes.clone(), saved.phase, saved.forged)
            }
        };
        let ours = bytes.get(10..48) == self.bytes.get(10..48);
        let mut right = if ours { vec![fmi2OK] } else { vec![fmi2Error] };
        if rng.bool() {
            if !arguments::damage(rng, &mut bytes) {
                right = vec![fmi2Error];
            } else if ours {
                right = vec![fmi2OK, fmi2Error];
                forged = true;
            }
        }
        let nowhere = rng.u8(..30) == 0;
        let mut handle = ptr::null_mut();
        let place = if nowhere { ptr::null_mut() } else { &raw mut handle };
        let status = unsafe { fmi2DeSerializeFMUstate(self.fmu.component, bytes.as_ptr().cast(), bytes.len(), place) };
        if status == fmi2OK {
            // numbers can be encoded with more bytes than necessary
            let bytes = if forged { self.fmu.serialize(handle) } else { bytes };
            self.states.push(Saved { handle, phase, bytes, forged });
            self.forget_the_oldest();
        } else {
            assert!(handle.is_null(), "a refused state has no handle");
        }
        (status, if nowhere { vec![fmi2Error] } else { right }, "")
    }

    fn rates(&mut self, rng: &mut Rng, name: &str) -> (fmi2Status, Vec<fmi2Status>, &'static str) {
        let table = &self.fmu.table;
        let setting = name == "fmi2SetRealInputDerivatives";
        let causality = if setting { Causality::Input } else { Causality::Output };
        let references =
            arguments::references(rng, table, |row| row.causality == causality && row.value.kind() == Kind::Real);
        let orders: Vec<i32> = references
            .iter()
            .map(|_| if rng.u8(..20) == 0 { pick(rng, &[0, 2, -1, i32::MAX, i32::MIN]) } else { 1 })
            .collect();
        let mut values: Vec<f64> = references.iter().map(|_| arguments::real(rng, None)).collect();
        let n = references.len();
        let verdicts = references.iter().enumerate().map(|(i, &reference)| match setting {
            true => arguments::setting_rate(table, reference, orders[i], values[i]),
            false => arguments::reading_rate(table, reference, orders[i]),
        });
        let mut verdict = batch(verdicts);
        let no_orders = rng.u8(..40) == 0;
        if no_orders && n > 0 {
            verdict = Verdict::BadCall;
        }
        let of_orders = if no_orders { ptr::null() } else { orders.as_ptr() };
        let c = self.fmu.component;
        let status = unsafe {
            if setting {
                fmi2SetRealInputDerivatives(c, references.as_ptr(), n, of_orders, values.as_ptr())
            } else {
                fmi2GetRealOutputDerivatives(c, references.as_ptr(), n, of_orders, values.as_mut_ptr())
            }
        };
        (status, statuses(verdict), "")
    }

    fn directional(&mut self, rng: &mut Rng) -> (fmi2Status, Vec<fmi2Status>, &'static str) {
        let table = &self.fmu.table;
        let real = |row: &foldwing::interface::Variable| row.value.kind() == Kind::Real;
        let unknowns = arguments::references(rng, table, |row| real(row) && row.causality == Causality::Output);
        let knowns = arguments::references(rng, table, |row| real(row) && row.causality == Causality::Input);
        let changes: Vec<f64> = knowns.iter().map(|_| arguments::real(rng, None)).collect();
        let mut results = vec![0.0; unknowns.len()];
        let no_changes = rng.u8(..40) == 0 && !knowns.is_empty();
        let of_changes = if no_changes { ptr::null() } else { changes.as_ptr() };
        let status = unsafe {
            fmi2GetDirectionalDerivative(
                self.fmu.component,
                unknowns.as_ptr(),
                unknowns.len(),
                knowns.as_ptr(),
                knowns.len(),
                of_changes,
                results.as_mut_ptr(),
            )
        };
        (status, if no_changes { vec![fmi2Error] } else { ANY.to_vec() }, "")
    }

    fn step(&mut self, rng: &mut Rng) -> (fmi2Status, Vec<fmi2Status>, &'static str) {
        let own_s = if self.phase == Phase::StepComplete { self.time_s() } else { 0.0 };
        let step_s = arguments::step_s(rng);
        let (time_s, shifted) = match rng.u8(..12) {
            0 => (pick(rng, &[f64::NAN, f64::INFINITY, -1e9, own_s + 1.0, own_s - 1e-3]), true),
            1 => (own_s + 1e-10 * (rng.f64() - 0.5), false),
            _ => (own_s, false),
        };
        let status = unsafe { fmi2DoStep(self.fmu.component, time_s, step_s, fmi2Boolean::from(rng.bool())) };
        if self.phase != Phase::StepComplete || self.forged {
            if self.phase == Phase::StepComplete {
                self.phase = self.phase_named();
                return (status, vec![fmi2OK, fmi2Error], "");
            }
            return (status, vec![fmi2OK, fmi2Error], "");
        }
        let impossible = shifted || !(step_s > 0.0 && step_s < 1e6 && time_s + step_s > time_s);
        let end_s = self.time_s();
        if impossible {
            assert_eq!(self.phase_named(), Phase::StepComplete, "a refused step leaves the phase");
            return (status, vec![fmi2Error], "");
        }
        self.phase = self.phase_named();
        match self.phase {
            Phase::StepComplete if status == fmi2OK => assert_eq!(end_s, time_s + step_s, "the step's end"),
            // beyond the stop time: rejected
            Phase::StepComplete => assert_eq!(end_s, own_s, "a refused step takes no time"),
            Phase::StepFailed => assert!((own_s - 1e-9..time_s + step_s).contains(&end_s), "the last good time"),
            other => panic!("a step leads to {other:?}"),
        }
        let right = if self.phase == Phase::StepFailed { vec![fmi2Error] } else { vec![fmi2OK, fmi2Error] };
        (status, right, "")
    }

    /// The calls of the life cycle, and the status functions.
    fn lead(&mut self, rng: &mut Rng, name: &str) -> (fmi2Status, Vec<fmi2Status>, &'static str) {
        let c = self.fmu.component;
        let kind = if rng.u8(..8) == 0 { rng.u32(..) } else { rng.u32(..4) };
        let nowhere = rng.u8(..30) == 0;
        let answer = |own: fmi2StatusKind| if kind == own && !nowhere { vec![fmi2OK] } else { vec![fmi2Error] };
        fn place<T>(value: &mut T, nowhere: bool) -> *mut T {
            if nowhere { ptr::null_mut() } else { value }
        }
        let (mut status, mut real, mut integer, mut text) = (0, 0.0, 0, ptr::null());
        unsafe {
            match name {
                "fmi2SetDebugLogging" => {
                    let names = [c"logAll", c"logEvents", c"logStatusWarning", c"logNonsense", c"", c"\xff%s%n"];
                    let chosen: Vec<CString> = (0..rng.usize(..4))
                        .map(|_| names[rng.usize(..names.len() * 2).min(rng.usize(..names.len()))].to_owned())
                        .collect();
                    let mut pointers: Vec<fmi2String> = chosen.iter().map(|name| name.as_ptr()).collect();
                    let sound = chosen.iter().all(|name| names[..3].contains(&name.as_c_str()));
                    let hole = rng.u8(..20) == 0 && !pointers.is_empty();
                    if hole {
                        pointers[0] = ptr::null();
                    }
                    let status = fmi2SetDebugLogging(c, rng.i32(..2), pointers.len(), pointers.as_ptr());
                    (status, if sound && !hole { vec![fmi2OK] } else { vec![fmi2Error] }, "")
                }
                "fmi2SetupExperiment" => {
                    let mut time = |sound: f64| if rng.u8(..6) == 0 { arguments::real(rng, None) } else { sound };
                    let (tolerance, start_s, stop_s) = (time(1e-4), time(0.0), time(10.0));
                    let defined = (rng.i32(..2), rng.i32(..2));
                    let status = fmi2SetupExperiment(c, defined.0, tolerance, start_s, defined.1, stop_s);
                    let sound = start_s.is_finite()
                        && (defined.0 == 0 || (1e-12..=1e-1).contains(&tolerance))
                        && (defined.1 == 0 || stop_s.is_finite() && stop_s >= start_s);
                    (status, if sound { vec![fmi2OK] } else { vec![fmi2Discard] }, "")
                }
                "fmi2EnterInitializationMode" => (fmi2EnterInitializationMode(c), vec![fmi2OK], ""),
                // there may be no consistent state for the start values
                "fmi2ExitInitializationMode" => (fmi2ExitInitializationMode(c), vec![fmi2OK, fmi2Error], ""),
                "fmi2Terminate" => (fmi2Terminate(c), vec![fmi2OK], ""),
                "fmi2Reset" => (fmi2Reset(c), vec![fmi2OK], ""),
                "fmi2CancelStep" => (fmi2CancelStep(c), vec![fmi2Error], "not legal"),
                "fmi2GetStatus" => (fmi2GetStatus(c, kind, place(&mut status, nowhere)), answer(fmi2DoStepStatus), ""),
                "fmi2GetRealStatus" => {
                    (fmi2GetRealStatus(c, kind, place(&mut real, nowhere)), answer(fmi2LastSuccessfulTime), "")
                }
                "fmi2GetBooleanStatus" => {
                    (fmi2GetBooleanStatus(c, kind, place(&mut integer, nowhere)), answer(fmi2Terminated), "")
                }
                "fmi2GetStringStatus" => {
                    (fmi2GetStringStatus(c, kind, place(&mut text, nowhere)), answer(fmi2PendingStatus), "")
                }
                "fmi2GetIntegerStatus" => {
                    (fmi2GetIntegerStatus(c, kind, place(&mut integer, nowhere)), vec![fmi2Error], "")
                }
                other => panic!("no call for {other}"),
            }
        }
    }
}

/// Type of the values of a getting or setting function.
fn kind_of(name: &str) -> Kind {
    [Kind::Real, Kind::Integer, Kind::Boolean]
        .into_iter()
        .find(|kind| name.ends_with(kind.name()))
        .unwrap_or(Kind::String)
}

/// The statuses allowed for a verdict.
fn statuses(verdict: Verdict) -> Vec<fmi2Status> {
    vec![match verdict {
        Verdict::Taken => fmi2OK,
        Verdict::BadValue => fmi2Discard,
        Verdict::BadCall => fmi2Error,
    }]
}
