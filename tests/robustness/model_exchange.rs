//! FMI 2.0 Model Exchange: life cycle, integration by the importer through events, rollback, drift, rejected calls.

use crate::calls::{self, Arguments, no_info};
use crate::counting_allocator::allocations;
use crate::fmu::{Attempt, Fmu, Resources, WING};
use foldwing_fmu::exchange::*;
use foldwing_fmu::functions::*;
use foldwing_fmu::states::*;
use foldwing_fmu::types::*;
use std::ptr;

const FLYING: &str = include_str!("../../examples/models/flying_wing.toml");
const PENDULUM: &str = include_str!("../../examples/models/double_pendulum.toml");

/// Phase of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    Instantiated,
    Initialization,
    Event,
    Continuous,
    Terminated,
}

const PHASES: [Phase; 5] =
    [Phase::Instantiated, Phase::Initialization, Phase::Event, Phase::Continuous, Phase::Terminated];

impl Phase {
    /// The name of the phase in messages.
    fn phrase(self) -> &'static str {
        match self {
            Self::Instantiated => "before fmi2EnterInitializationMode",
            Self::Initialization => "in Initialization Mode",
            Self::Event => "in Event Mode",
            Self::Continuous => "in Continuous-Time Mode",
            Self::Terminated => "after fmi2Terminate",
        }
    }
}

/// The table of FMI 2.0.4, section 3.2.3, with the phases in the order of [`PHASES`]; functions of co-simulation are never legal.
pub const TABLE: [(&str, &str); 40] = [
    ("fmi2SetDebugLogging", "x x x x x"),
    ("fmi2SetupExperiment", "x - - - -"),
    ("fmi2EnterInitializationMode", "x - - - -"),
    ("fmi2ExitInitializationMode", "- x - - -"),
    ("fmi2Terminate", "- - x x -"),
    ("fmi2Reset", "x x x x x"),
    ("fmi2GetReal", "- x x x x"),
    ("fmi2GetInteger", "- x x x x"),
    ("fmi2GetBoolean", "- x x x x"),
    ("fmi2GetString", "- x x x x"),
    ("fmi2SetReal", "x x x x -"),
    ("fmi2SetInteger", "x x x x -"),
    ("fmi2SetBoolean", "x x x x -"),
    ("fmi2SetString", "x x x x -"),
    ("fmi2GetFMUstate", "x x x x x"),
    ("fmi2SetFMUstate", "x x x x x"),
    ("fmi2FreeFMUstate", "x x x x x"),
    ("fmi2SerializedFMUstateSize", "x x x x x"),
    ("fmi2SerializeFMUstate", "x x x x x"),
    ("fmi2DeSerializeFMUstate", "x x x x x"),
    ("fmi2EnterEventMode", "- - x x -"),
    ("fmi2NewDiscreteStates", "- - x - -"),
    ("fmi2EnterContinuousTimeMode", "- - x - -"),
    ("fmi2CompletedIntegratorStep", "- - - x -"),
    ("fmi2SetTime", "- - x x -"),
    ("fmi2SetContinuousStates", "- - - x -"),
    ("fmi2GetDerivatives", "- x x x x"),
    ("fmi2GetEventIndicators", "- x x x x"),
    ("fmi2GetContinuousStates", "- x x x x"),
    ("fmi2GetNominalsOfContinuousStates", "x - x x x"),
    ("fmi2GetDirectionalDerivative", "- x x x x"),
    ("fmi2SetRealInputDerivatives", "- - - - -"),
    ("fmi2GetRealOutputDerivatives", "- - - - -"),
    ("fmi2DoStep", "- - - - -"),
    ("fmi2CancelStep", "- - - - -"),
    ("fmi2GetStatus", "- - - - -"),
    ("fmi2GetRealStatus", "- - - - -"),
    ("fmi2GetIntegerStatus", "- - - - -"),
    ("fmi2GetBooleanStatus", "- - - - -"),
    ("fmi2GetStringStatus", "- - - - -"),
];

/// An instance that the test integrates.
pub struct Outside {
    pub fmu: Fmu,
    pub time_s: f64,
    pub states: Vec<f64>,
    pub indicators: Vec<f64>,
    /// Scratch vector of [`Outside::tried`].
    pub at: Vec<f64>,
    pub slope: Vec<f64>,
    pub sum: Vec<f64>,
}

impl Outside {
    pub fn new(fmu: Fmu) -> Self {
        let states = fmu.table.nominals().len();
        let indicators = indicators_of(&fmu);
        let room = || vec![0.0; states];
        let (states, at, slope, sum) = (room(), room(), room(), room());
        Self { fmu, time_s: 0.0, states, indicators: vec![1.0; indicators], at, slope, sum }
    }

    /// An instance in Continuous-Time Mode at t = 0.
    pub fn started(text: &str) -> Self {
        let outside = Self::new(Fmu::exchanged(text));
        outside.in_phase(Phase::Continuous)
    }

    /// The new instance after the calls that lead to a phase.
    pub fn in_phase(mut self, phase: Phase) -> Self {
        let c = self.fmu.component;
        unsafe {
            if phase != Phase::Instantiated {
                self.fmu.setup(0.0, None);
                self.fmu.ok(fmi2EnterInitializationMode(c));
            }
            if !matches!(phase, Phase::Instantiated | Phase::Initialization) {
                self.fmu.ok(fmi2ExitInitializationMode(c));
                if phase != Phase::Event {
                    self.update();
                    self.fmu.ok(fmi2EnterContinuousTimeMode(c));
                }
                self.read();
            }
            if phase == Phase::Terminated {
                self.fmu.ok(fmi2Terminate(c));
            }
        }
        self
    }

    pub fn read(&mut self) {
        let n = self.states.len();
        self.fmu.ok(unsafe { fmi2GetContinuousStates(self.fmu.component, self.states.as_mut_ptr(), n) });
    }

    pub fn update(&mut self) -> fmi2EventInfo {
        let mut info = no_info();
        self.fmu.ok(unsafe { fmi2NewDiscreteStates(self.fmu.component, &mut info) });
        assert_eq!((info.newDiscreteStatesNeeded, info.terminateSimulation), (fmi2False, fmi2False));
        info
    }

    /// Handles an event at the current time.
    fn event(&mut self, set: impl FnOnce(&Fmu)) -> fmi2EventInfo {
        unsafe {
            self.fmu.ok(fmi2EnterEventMode(self.fmu.component));
            set(&self.fmu);
            let info = self.update();
            self.fmu.ok(fmi2EnterContinuousTimeMode(self.fmu.component));
            self.read();
            info
        }
    }

    pub fn set(&self, time_s: f64, states: &[f64]) {
        unsafe {
            self.fmu.ok(fmi2SetTime(self.fmu.component, time_s));
            self.fmu.ok(fmi2SetContinuousStates(self.fmu.component, states.as_ptr(), states.len()));
        }
    }

    /// States after a step, in [`Outside::sum`], by the classical Runge–Kutta method.
    fn tried(&mut self, step_s: f64) {
        self.sum.copy_from_slice(&self.states);
        self.slope.fill(0.0);
        for (place, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
            for i in 0..self.at.len() {
                self.at[i] = self.states[i] + place * step_s * self.slope[i];
            }
            self.set(self.time_s + place * step_s, &self.at);
            let n = self.slope.len();
            self.fmu.ok(unsafe { fmi2GetDerivatives(self.fmu.component, self.slope.as_mut_ptr(), n) });
            for i in 0..n {
                self.sum[i] += weight / 6.0 * step_s * self.slope[i];
            }
        }
    }

    /// Returns whether some indicator would reach zero within a further step.
    fn crosses(&mut self, step_s: f64) -> bool {
        self.tried(step_s);
        self.set(self.time_s + step_s, &self.sum);
        let n = self.indicators.len();
        self.fmu.ok(unsafe { fmi2GetEventIndicators(self.fmu.component, self.indicators.as_mut_ptr(), n) });
        self.indicators.iter().any(|&indicator| indicator <= 0.0)
    }

    /// Takes one step, or a part of it up to the first event; returns whether there was one.
    pub fn step(&mut self, step_s: f64) -> bool {
        let mut arrived_s = step_s;
        let crossed = self.crosses(step_s);
        if crossed {
            let mut low_s = 0.0;
            while arrived_s - low_s > 1e-12 {
                let middle_s = 0.5 * (low_s + arrived_s);
                if self.crosses(middle_s) { arrived_s = middle_s } else { low_s = middle_s }
            }
            self.crosses(arrived_s);
        }
        self.states.copy_from_slice(&self.sum);
        self.time_s += arrived_s;
        self.set(self.time_s, &self.states);
        let (mut event, mut end) = (fmi2False, fmi2False);
        self.fmu.ok(unsafe { fmi2CompletedIntegratorStep(self.fmu.component, fmi2True, &mut event, &mut end) });
        assert_eq!(end, fmi2False);
        assert_eq!(event != fmi2False, crossed, "the instance sees what the importer sees");
        if crossed {
            self.event(|_| {});
        }
        crossed
    }

    /// Integrates to a time with steps of at most `step_s`; returns the times of events in s.
    pub fn run(&mut self, end_s: f64, step_s: f64) -> Vec<f64> {
        let mut events = Vec::new();
        while self.time_s < end_s - 1e-12 {
            if self.step(step_s.min(end_s - self.time_s)) {
                events.push(self.time_s);
            }
        }
        events
    }

    /// Bytes of the current state; leaves no saved state behind.
    fn present(&self) -> Vec<u8> {
        let mut state = self.fmu.save();
        let bytes = self.fmu.serialize(state);
        self.fmu.ok(unsafe { fmi2FreeFMUstate(self.fmu.component, &mut state) });
        bytes
    }

    /// Calls a function with arguments that are valid wherever the call is legal.
    fn call(&mut self, name: &str) -> fmi2Status {
        let state = self.fmu.save();
        let bytes = self.fmu.serialize(state);
        let (states, indicators) = (self.states.as_slice(), self.indicators.len());
        calls::call(&self.fmu, name, &Arguments { state, bytes: &bytes, time_s: self.time_s, states, indicators })
    }
}

/// Number of event indicators, from the error for a wrong number.
pub fn indicators_of(fmu: &Fmu) -> usize {
    let c = fmu.component;
    fmu.setup(0.0, None);
    let told = unsafe {
        fmu.ok(fmi2EnterInitializationMode(c));
        assert_eq!(fmi2GetEventIndicators(c, vec![0.0; 9999].as_mut_ptr(), 9999), fmi2Error);
        fmi2Reset(c);
        fmu.messages.borrow_mut().pop().expect("a message").text
    };
    let number = told.rsplit("this model has ").next().expect("a number");
    number.parse().unwrap_or_else(|_| panic!("{told}"))
}

/// ME-01. Each of the 40 functions in each of the 5 phases of Model Exchange. Illegal: `fmi2Error`, one message that names function and
/// phase, and a bit-identical state. Legal: `fmi2OK` without a message.
#[test]
fn me01_every_call_in_every_phase_of_model_exchange() {
    let mut cells = [0, 0];
    for (column, phase) in PHASES.into_iter().enumerate() {
        for (name, legal) in TABLE {
            let mut subject = Outside::new(Fmu::exchanged(WING)).in_phase(phase);
            let cell = format!("{name} {}", phase.phrase());
            let before = subject.present();
            let status = subject.call(name);
            let legal = legal.split(' ').nth(column) == Some("x");
            cells[usize::from(legal)] += 1;
            let messages: Vec<_> = subject.fmu.messages.borrow_mut().drain(..).collect();
            if legal {
                assert_eq!(status, fmi2OK, "{cell}: {messages:?}");
                assert!(messages.is_empty(), "{cell}: {messages:?}");
            } else {
                assert_eq!(status, fmi2Error, "{cell}");
                let [message] = messages.as_slice() else { panic!("{cell}: one message, not {messages:?}") };
                let head = format!("{name}: not legal {}", phase.phrase());
                assert!(message.text.starts_with(&head), "{}", message.text);
                assert_eq!(subject.present(), before, "{cell} changed the state");
            }
        }
    }
    println!("Model Exchange: {} cells, {} legal, {} refused", cells[0] + cells[1], cells[1], cells[0]);
}

/// ME-02. The shipped wing, integrated through the C functions by the Runge–Kutta method at 4 µs, latches once, at the time of
/// co-simulation at a tolerance of 1e-9, to 1e-7 s; angle and energy balances agree to 1e-7, the strain to 1e-6, because its rate is about
/// 10 1/s and the two latch times differ by 1e-8 s. No step allocates memory, and a run from a saved state, also from its bytes in another
/// instance, is bit-identical.
#[test]
fn me02_the_wing_latches_as_in_co_simulation() {
    let reference = Fmu::of_kind(WING, fmi2CoSimulation);
    unsafe {
        reference.ok(fmi2SetupExperiment(reference.component, fmi2True, 1e-9, 0.0, fmi2False, 0.0));
        reference.ok(fmi2EnterInitializationMode(reference.component));
        reference.ok(fmi2ExitInitializationMode(reference.component));
    }
    let end_s = 0.13;
    reference.step(0.0, end_s);

    let mut outside = Outside::started(WING);
    outside.run(0.1, 4e-6);
    let before = allocations();
    outside.run(0.12, 4e-6);
    assert_eq!(allocations() - before, 0, "allocations in 5000 steps of the importer's");
    let (saved, time_s, states) = (outside.fmu.save(), outside.time_s, outside.states.clone());
    let bytes = outside.fmu.serialize(saved);
    let events = outside.run(end_s, 4e-6);
    let [latched_s] = events[..] else { panic!("one event: {events:?}") };
    let end = outside.fmu.bits();
    println!("ME-02 latch {latched_s} s against {} s", reference.get("fold.latch_time"));
    assert!((latched_s - reference.get("fold.latch_time")).abs() < 1e-7);
    assert_eq!(outside.fmu.get("fold.latch_time"), latched_s);
    assert!(outside.fmu.get_boolean("fold.latched"));
    for name in
        ["fold.angle", "energy.work", "energy.dissipated", "energy.total", "tip.position.z", "gauge.root.strain"]
    {
        let (found, expected) = (outside.fmu.get(name), reference.get(name));
        let allowed = if name.starts_with("gauge.") { 1e-6 } else { 1e-7 };
        assert!((found - expected).abs() < allowed, "{name}: {found} against {expected}");
    }

    let mut elsewhere = Outside::started(WING);
    let (status, handle) = elsewhere.fmu.deserialize(&bytes);
    elsewhere.fmu.ok(status);
    elsewhere.fmu.ok(unsafe { fmi2SetFMUstate(elsewhere.fmu.component, handle) });
    outside.fmu.ok(unsafe { fmi2SetFMUstate(outside.fmu.component, saved) });
    for again in [&mut outside, &mut elsewhere] {
        again.read();
        assert_eq!(again.states, states);
        again.time_s = time_s;
        assert_eq!(again.run(end_s, 4e-6), [latched_s]);
        assert_eq!(again.fmu.bits(), end);
    }
}

/// ME-03. Redundant parameters of a free and of two ball joints, scaled away from their constraints by 1 %: the derivatives of all states
/// equal those on the constraints, to 1e-9 of the largest; the end of the step requests an event, which restores the states. Without drift
/// no event is requested.
#[test]
fn me03_derivatives_do_not_feel_drift_and_an_event_takes_it_back() {
    for text in [FLYING, PENDULUM] {
        let mut outside = Outside::started(text);
        let rows = outside.fmu.table.variables().iter().filter(|row| row.nominal.is_some());
        let names: Vec<String> = rows.map(|row| row.name.clone()).collect();
        let redundant: Vec<usize> =
            (0..names.len()).filter(|&i| names[i].contains(".parameter[") && names[i].starts_with("state.")).collect();
        assert!(!redundant.is_empty());
        outside.run(2e-5, 1e-6);
        let derivatives = |outside: &Outside, states: &[f64]| {
            let mut slope = vec![0.0; states.len()];
            outside.set(outside.time_s, states);
            let status = unsafe { fmi2GetDerivatives(outside.fmu.component, slope.as_mut_ptr(), slope.len()) };
            outside.fmu.ok(status);
            slope
        };
        let complete = |outside: &Outside| {
            let (mut event, mut end) = (-1, -1);
            let c = outside.fmu.component;
            outside.fmu.ok(unsafe { fmi2CompletedIntegratorStep(c, fmi2True, &mut event, &mut end) });
            event
        };
        let states = outside.states.clone();
        let expected = derivatives(&outside, &states);
        assert_eq!(complete(&outside), fmi2False);
        let mut drifted = states.clone();
        redundant.iter().for_each(|&i| drifted[i] *= 1.01);
        let found = derivatives(&outside, &drifted);
        let scale = expected.iter().fold(1.0_f64, |scale, value| scale.max(value.abs()));
        for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert!((found - expected).abs() <= 1e-9 * scale, "{}: {found} against {expected}", names[i]);
        }
        assert_eq!(complete(&outside), fmi2True);
        let info = outside.event(|_| {});
        assert_eq!(info.valuesOfContinuousStatesChanged, fmi2True);
        for (found, expected) in outside.states.iter().zip(&states) {
            assert!((found - expected).abs() < 1e-9, "{found} against {expected}");
        }
        assert_eq!(complete(&outside), fmi2False);
    }
}

/// ME-04. Rejected with a message and without effect: switches set while the importer integrates, states and times that are not finite,
/// wrong numbers of states, saved states of the other interface type, an FMU without Model Exchange.
#[test]
fn me04_refusals_name_what_is_wrong() {
    let outside = Outside::started(WING);
    let (fmu, c) = (&outside.fmu, outside.fmu.component);
    let before = outside.present();
    unsafe {
        let release = fmu.reference("fold.release");
        fmu.refused(fmi2SetBoolean(c, &release, 1, &fmi2False), fmi2Error, &["fold.release", "Continuous-Time Mode"]);
        let start = fmu.reference("fold.start_angle");
        fmu.refused(fmi2SetReal(c, &start, 1, &1.0), fmi2Error, &["fold.start_angle is fixed"]);
        fmu.refused(fmi2SetTime(c, f64::NAN), fmi2Discard, &["time", "finite"]);
        fmu.refused(
            fmi2SetTime(c, -1e-3),
            fmi2Discard,
            &["time -0.001 s", "before the last event or the start, at 0 s"],
        );
        let mut states = outside.states.clone();
        states[0] = f64::INFINITY;
        let n = states.len();
        fmu.refused(
            fmi2SetContinuousStates(c, states.as_ptr(), n),
            fmi2Discard,
            &["state.inner.element[1].epsilon_x", "inf"],
        );
        fmu.refused(fmi2SetContinuousStates(c, states.as_ptr(), n - 1), fmi2Error, &["nx", &n.to_string()]);
        fmu.refused(fmi2GetDerivatives(c, ptr::null_mut(), n), fmi2Error, &["derivatives", "null"]);
        fmu.refused(fmi2NewDiscreteStates(c, ptr::null_mut()), fmi2Error, &["in Event Mode"]);
    }
    assert_eq!(outside.present(), before);
    let mut outside = outside;
    outside.set(1e-3, &outside.states);
    outside.event(|_| {});
    let (fmu, c) = (&outside.fmu, outside.fmu.component);
    unsafe {
        fmu.refused(fmi2SetTime(c, 5e-4), fmi2Discard, &["time 0.0005 s", "at 0.001 s", "fmi2SetFMUstate"]);
        fmu.ok(fmi2SetTime(c, 2e-3));
        fmu.ok(fmi2SetTime(c, 1e-3));
        let (status, mut state) = fmu.deserialize(&before);
        fmu.ok(status);
        fmu.ok(fmi2SetFMUstate(c, state));
        fmu.ok(fmi2SetTime(c, 5e-4));
        fmu.ok(fmi2FreeFMUstate(c, &mut state));
    }
    // co-simulation of the same FMU
    let other = Fmu::of_kind(WING, fmi2CoSimulation);
    let (status, state) = other.deserialize(&before);
    other.ok(status);
    other.refused(unsafe { fmi2SetFMUstate(other.component, state) }, fmi2Error, &["Model Exchange", "co-simulation"]);
    let resources = Resources::with(WING);
    let refusal = Attempt { fmu_type: fmi2ModelExchange, ..Attempt::of(WING, &resources) }.refusal();
    assert!(refusal.contains("--interface cs,me"), "{refusal}");
}

/// ME-05. Inputs: a torque acts instantaneously during the integration, a locked joint stops in an event, which reports that the states
/// have jumped, and a rate-limited slew ends at the time event given by the instance.
#[test]
fn me05_inputs_act_at_once_and_switches_in_events() {
    let mut outside = Outside::started(WING);
    let place = |outside: &Outside, name: &str| {
        let rows = outside.fmu.table.variables().iter().filter(|row| row.nominal.is_some());
        rows.map(|row| row.name.as_str()).position(|found| found == name).expect("a state")
    };
    let rate = place(&outside, "state_rate.fold.angle");
    let derivative = |outside: &Outside| outside.fmu.get("der(state_rate.fold.angle)");
    outside.run(0.01, 1e-5);
    let free = derivative(&outside);
    outside.fmu.set("fold.external_torque", 1e-3);
    let pushed = derivative(&outside);
    assert!(pushed != free && pushed == outside.fmu.get("der(state_rate.fold.angle)"), "{free} {pushed}");
    outside.fmu.set("fold.external_torque", 0.0);
    assert_eq!(derivative(&outside), free, "the derivatives depend on time, states and inputs alone");
    assert!(outside.states[rate] != 0.0);
    let info = outside.event(|fmu| fmu.set_boolean("fold.release", false));
    assert_eq!(info.valuesOfContinuousStatesChanged, fmi2True);
    assert_eq!(outside.states[rate], 0.0);
    assert_eq!(derivative(&outside), 0.0);
    let info = outside.event(|fmu| fmu.set_boolean("fold.release", true));
    assert_eq!((info.valuesOfContinuousStatesChanged, info.nextEventTimeDefined), (fmi2False, fmi2False));

    // the same machine with a motor that slews
    let text = WING.replacen("[joint.fold.motor]", "[joint.fold.motor]\nrate_limit_deg_s = 90.0", 1);
    let mut outside = Outside::started(&text);
    let start = outside.fmu.get("fold.neutral_angle");
    outside.fmu.set("fold.angle_command", start + 0.1);
    let (mut event, mut end) = (-1, -1);
    let c = outside.fmu.component;
    outside.fmu.ok(unsafe { fmi2CompletedIntegratorStep(c, fmi2True, &mut event, &mut end) });
    assert_eq!(event, fmi2True, "a command behind a rate limit waits for an event");
    let info = outside.event(|_| {});
    assert_eq!(info.nextEventTimeDefined, fmi2True);
    assert!((info.nextEventTime - 0.1 / 90_f64.to_radians()).abs() < 1e-12, "{}", info.nextEventTime);
}

/// A beam under gravity on a hinge with a prescribed motion.
const SPUN: &str = r#"
name = "Spun"
gravity_m_s2 = [0.0, 0.0, -9.81]
[section.spar]
shape = "rectangle"
width_m = 0.05
height_m = 0.01
density_kg_m3 = 1400
youngs_modulus_Pa = 3e9
poisson_ratio = 0.3
[body.arm]
length_m = 0.5
section = "spar"
elements = 1
[joint.hub]
type = "revolute"
parent = "root"
child = "arm"
axis = [0.0, 1.0, 0.0]
motion = "prescribed"
polynomial_deg = [10.0, 40.0, 300.0]
"#;

/// ME-06. Under a prescribed motion, time alone changes derivatives; setting it back gives bit-identical derivatives.
#[test]
fn me06_time_alone_changes_derivatives() {
    let outside = Outside::started(SPUN);
    let found = |time_s: f64| -> Vec<f64> {
        let mut derivatives = vec![0.0; outside.states.len()];
        unsafe {
            outside.fmu.ok(fmi2SetTime(outside.fmu.component, time_s));
            let n = derivatives.len();
            outside.fmu.ok(fmi2GetDerivatives(outside.fmu.component, derivatives.as_mut_ptr(), n));
        }
        derivatives
    };
    let (first, later, again) = (found(0.0), found(0.2), found(0.0));
    assert_eq!(first, again);
    let change = first.iter().zip(&later).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let size = first.iter().map(|a| a.abs()).fold(0.0, f64::max);
    // the hinge rotates by 20 degrees, at ten times the rate: weight and centrifugal force of the beam change by far more than this
    // fraction
    assert!(change > 0.1 * size, "{change} of {size}");
}

/// ME-07. Forward Euler diverges with steps that are typical of explicit methods of higher order. It is stopped, with an error that names
/// the element and the remedy, before the fold seems to reach its latch; a stable method can then continue from valid states.
#[test]
fn me07_a_diverging_integrator_is_stopped_by_name() {
    // the shorter the step, the later: the axial modes grow at the rate ω² h / 2
    for (step_s, end_s) in [(1e-5, 1e-3), (5e-6, 1e-3), (2e-6, 2e-3), (1e-6, 4e-3)] {
        let mut outside = Outside::started(WING);
        let (first, c, n) = (outside.states.clone(), outside.fmu.component, outside.states.len());
        let steps = (end_s / step_s) as usize;
        let stopped = (0..steps).any(|_| {
            let status = unsafe { fmi2GetDerivatives(c, outside.slope.as_mut_ptr(), n) };
            if status != fmi2OK {
                outside.fmu.refused(
                    status,
                    fmi2Discard,
                    &["of body", "is compressed to less than zero length", "shorter step", "an implicit method"],
                );
                return true;
            }
            assert!(!outside.fmu.get_boolean("fold.latched"), "{step_s}: latched at {} s", outside.time_s);
            outside.states.iter_mut().zip(&outside.slope).for_each(|(state, slope)| *state += step_s * slope);
            outside.time_s += step_s;
            outside.set(outside.time_s, &outside.states);
            let (mut event, mut end) = (fmi2False, fmi2False);
            let status = unsafe { fmi2CompletedIntegratorStep(c, fmi2True, &mut event, &mut end) };
            if status == fmi2OK && event == fmi2True {
                outside.event(|_| {});
            }
            false
        });
        assert!(stopped, "{step_s} s: went on to {} s", outside.time_s);
        outside.time_s = 0.0;
        outside.states.copy_from_slice(&first);
        outside.set(0.0, &first);
        assert!(outside.run(1e-3, 1e-5).is_empty(), "{step_s}: Runge and Kutta's method with 1e-5 s is stable");
    }
}

/// ME-08, ME-23. Magnitude and damping rate of the fastest motion, from which the page in the FMU gives the steps of explicit methods,
/// against the eigenvalues of a matrix of differences: three shipped machines, and a wing with damping ratios of the fastest motion of
/// about 0.1 and 0.5, and far above 1. Power iteration converges from below; the documented error is 5 %.
#[test]
fn me08_fastest_motion_is_the_largest_eigenvalue() {
    use foldwing::plant::Plant;
    use nalgebra::DMatrix;
    let damped = |beta_s: f64| {
        let lines = WING.replace("length_m = 0.15\n", &format!("length_m = 0.15\nstiffness_damping_s = {beta_s:?}\n"));
        assert_ne!(lines, WING, "{beta_s}");
        lines
    };
    let ratios = [damped(1e-6), damped(5e-6), damped(1e-3)];
    let shipped = [(WING, "the wing"), (PENDULUM, "the pendulum"), (FLYING, "the flying wing")];
    for (text, name) in shipped.into_iter().chain(ratios.iter().map(|text| (text.as_str(), "a damped wing"))) {
        let machine = foldwing::config::parse(text, name).expect("a model");
        let mut plant = Plant::new(std::sync::Arc::new(machine));
        plant.initialize(0.0).expect("starts");
        let system = plant.system_mut();
        system.begin_exchange().expect("has states");
        let fastest = system.fastest_motion().expect("accelerations");
        let (states, n) = (system.exchange_states().to_vec(), system.exchange_states().len());
        let mut jacobian = DMatrix::zeros(n, n);
        // rates are larger than coordinates by about the frequency: in these units differences and eigenvalues are well conditioned
        let scale = |i: usize| if i < n / 2 - 1 { 1.0 } else { 1e5 };
        for column in 0..n {
            let step = 1e-8 * scale(column);
            let mut side = |sign: f64| {
                let mut shifted = states.clone();
                shifted[column] += sign * step;
                system.set_exchange_states(&shifted);
                system.update_exchange().expect("derivatives");
                system.exchange_derivatives().to_vec()
            };
            let (above, below) = (side(1.0), side(-1.0));
            for row in 0..n {
                jacobian[(row, column)] = (above[row] - below[row]) / (2.0 * step) * scale(column) / scale(row);
            }
        }
        let eigenvalues = jacobian.complex_eigenvalues();
        let largest = eigenvalues.iter().max_by(|a, b| a.norm().total_cmp(&b.norm())).expect("a state");
        let share = fastest.magnitude_rad_s / largest.norm();
        println!("ME-23 {name}: {fastest:?} of {largest}");
        assert!((0.95..=1.01).contains(&share), "{name}: {fastest:?} of {largest}");
        // where motions are hardly damped, what the shapes of several have in common is an error of the ratio
        let off = (fastest.damping_rate_1_s + largest.re).abs() / largest.norm();
        assert!(off < 0.05, "{name}: {fastest:?} of {largest}");
    }
}

/// ME-09. States have start values in the model description, equal to those of an instance with default start values: an importer that
/// starts from the description has a legal state, with unit quaternions and closed loops. Setting them before the start changes nothing.
#[test]
fn me09_states_start_from_the_description() {
    let four_bar = include_str!("../../examples/models/four_bar.toml");
    for text in [WING, PENDULUM, FLYING, four_bar] {
        let machine = foldwing::config::parse(text, "model.toml").expect("a model");
        for version in [foldwing::instance::Version::Fmi2, foldwing::instance::Version::Fmi3] {
            let kinds = foldwing::packaging::Kinds { model_exchange: true, version, ..Default::default() };
            let description = kinds.model_description(&machine, &kinds.interface(&machine), text);
            let states = description.matches("initial=\"approx\"").count();
            assert!(
                states > 0 && description.matches("reinit=\"true\"").count() == states,
                "{}: {states}",
                machine.name
            );
        }
        let kinds = foldwing::packaging::Kinds { model_exchange: true, ..Default::default() };
        let outside = Outside::started(text);
        let interface = kinds.interface(&machine);
        let rows = interface.variables().iter().filter(|row| row.nominal.is_some());
        let starts: Vec<(u32, f64)> = rows
            .map(|row| match row.value {
                foldwing::interface::Value::Real(start) => (row.value_reference, start),
                other => panic!("{}: {other:?}", row.name),
            })
            .collect();
        assert_eq!(starts.iter().map(|(_, start)| *start).collect::<Vec<_>>(), outside.states, "{}", machine.name);

        // set before the start, with a guess far from the solution
        let fresh = Fmu::exchanged(text);
        let (row, start) = starts[0];
        for value in [start, start + 1.0] {
            fresh.ok(unsafe { fmi2SetReal(fresh.component, &row, 1, &value) });
        }
        let mut started = Outside::new(fresh).in_phase(Phase::Continuous);
        started.read();
        assert_eq!(started.states, outside.states);
        let fixed = outside.fmu.table.variables().iter().find(|row| row.name == "fold.start_angle");
        if let Some(fixed) = fixed {
            let status = unsafe { fmi2SetReal(outside.fmu.component, &fixed.value_reference, 1, &1.0) };
            outside.fmu.refused(status, fmi2Error, &["fold.start_angle is fixed"]);
        }
    }
}
