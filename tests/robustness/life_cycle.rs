//! The complete life cycle: every function in every phase of an instance, against the table of the standard (`standard.rs`). The state
//! after a panic, which no exported function reaches, is covered by a unit test in `crates/fmu/src/tests.rs`.

use crate::calls::{self, Arguments, STEP_S};
use crate::fmu::{Fmu, WING};
use crate::standard::{Effect, PHASES, Phase, Row, TABLE};
use foldwing_fmu::functions::*;
use foldwing_fmu::states::*;
use foldwing_fmu::types::*;
use std::ptr;

/// An instance in a phase, with the arguments for the calls of the table.
struct Subject {
    fmu: Fmu,
    /// State saved in this phase.
    here: fmi2FMUstate,
    /// State saved before the step that failed.
    before_failure: fmi2FMUstate,
    bytes: Vec<u8>,
    time_s: f64,
}

impl Subject {
    fn in_phase(phase: Phase) -> Self {
        let fmu = Fmu::new(WING);
        let c = fmu.component;
        let mut before_failure = ptr::null_mut();
        let mut time_s = 0.0;
        unsafe {
            if phase != Phase::Instantiated {
                fmu.setup(0.0, None);
                fmu.ok(fmi2EnterInitializationMode(c));
            }
            if !matches!(phase, Phase::Instantiated | Phase::Initialization) {
                fmu.ok(fmi2ExitInitializationMode(c));
                fmu.step(0.0, STEP_S);
                time_s = STEP_S;
            }
            match phase {
                Phase::StepFailed => {
                    before_failure = fmu.save();
                    fmu.set("load.outer[4].force.z", 1e200);
                    assert_eq!(fmu.try_step(time_s, STEP_S), fmi2Error);
                }
                Phase::Terminated => fmu.ok(fmi2Terminate(c)),
                _ => {}
            }
        }
        let here = fmu.save();
        let bytes = fmu.serialize(here);
        fmu.messages.borrow_mut().clear();
        Self { fmu, here, before_failure, bytes, time_s }
    }

    /// Calls a function with arguments that are valid wherever the call is legal.
    fn call(&mut self, name: &str) -> fmi2Status {
        let Self { fmu, here: state, bytes, time_s, .. } = self;
        calls::call(fmu, name, &Arguments { state: *state, bytes, time_s: *time_s, states: &[], indicators: 0 })
    }

    /// Bytes of the current state; leaves no saved state behind.
    fn present(&self) -> Vec<u8> {
        let mut state = self.fmu.save();
        let bytes = self.fmu.serialize(state);
        self.fmu.ok(unsafe { fmi2FreeFMUstate(self.fmu.component, &mut state) });
        bytes
    }

    /// The phase of the instance, from the error message of a call that is never legal.
    fn phase_named(&self) -> String {
        assert_eq!(unsafe { fmi2CancelStep(self.fmu.component) }, fmi2Error);
        let text = self.fmu.messages.borrow_mut().pop().expect("a refusal is told").text;
        let rest = text.strip_prefix("fmi2CancelStep: not legal ").unwrap_or_else(|| panic!("{text}"));
        PHASES.iter().find(|phase| rest.starts_with(phase.phrase())).expect("a phase").phrase().to_owned()
    }

    /// Continues from a phase by legal calls to two further steps; returns the bits of every output.
    fn go_on(&self, phase: Phase) -> Vec<u64> {
        let (fmu, c) = (&self.fmu, self.fmu.component);
        let mut time_s = self.time_s;
        unsafe {
            match phase {
                Phase::StepFailed => fmu.ok(fmi2SetFMUstate(c, self.before_failure)),
                Phase::Terminated => fmu.ok(fmi2Reset(c)),
                _ => {}
            }
            if matches!(phase, Phase::Terminated | Phase::Instantiated) {
                time_s = 0.0;
                fmu.setup(0.0, None);
                fmu.ok(fmi2EnterInitializationMode(c));
            }
            if matches!(phase, Phase::Terminated | Phase::Instantiated | Phase::Initialization) {
                fmu.ok(fmi2ExitInitializationMode(c));
            }
        }
        fmu.step(time_s, STEP_S);
        fmu.step(time_s + STEP_S, STEP_S);
        fmu.bits()
    }
}

/// L-01. Each of the 30 functions in each of the 5 phases. Illegal: `fmi2Error`, one message with function and phase, state and outputs
/// unchanged, and the legal continuation bit-identical to that without the call. Legal: `fmi2OK`, the phase given by the standard; reading
/// changes nothing. A second instance is unaffected by either.
#[test]
fn l01_every_call_in_every_phase() {
    let neighbour = Subject::in_phase(Phase::StepComplete);
    let mut cells = [0, 0];
    for phase in PHASES {
        let undisturbed = Subject::in_phase(phase).go_on(phase);
        for row in &TABLE {
            let mut subject = Subject::in_phase(phase);
            let legal = row.is_legal(phase);
            cells[usize::from(legal)] += 1;
            if legal {
                accepted(&mut subject, row, phase)
            } else {
                refused(&mut subject, row, phase, &undisturbed)
            }
            assert_eq!(
                neighbour.present(),
                neighbour.bytes,
                "{} {} reached another instance",
                row.name,
                phase.phrase()
            );
            assert!(neighbour.fmu.messages.borrow().is_empty(), "{} told another instance's log", row.name);
        }
    }
    assert_eq!(cells[0] + cells[1], 150, "30 functions in 5 phases");
    println!("life cycle: {} cells, {} legal, {} refused", cells[0] + cells[1], cells[1], cells[0]);
}

fn refused(subject: &mut Subject, row: &Row, phase: Phase, undisturbed: &[u64]) {
    let cell = format!("{} {}", row.name, phase.phrase());
    let readable = crate::standard::row_of("fmi2GetReal").is_legal(phase) && phase != Phase::Initialization;
    let outputs = readable.then(|| subject.fmu.bits());
    assert_eq!(subject.call(row.name), fmi2Error, "{cell}");
    {
        let messages = subject.fmu.messages.borrow();
        let [message] = messages.as_slice() else { panic!("{cell}: one message, not {messages:?}") };
        assert!(message.text.starts_with(&format!("{}: not legal {}", row.name, phase.phrase())), "{}", message.text);
        assert_eq!((message.status, message.category.as_str()), (fmi2Error, "logStatusError"), "{cell}");
    }
    subject.fmu.messages.borrow_mut().clear();
    assert_eq!(subject.present(), subject.bytes, "{cell} changed the state");
    if let Some(outputs) = outputs {
        assert_eq!(subject.fmu.bits(), outputs, "{cell} changed an output");
    }
    assert_eq!(subject.phase_named(), phase.phrase(), "{cell} changed the phase");
    assert_eq!(subject.go_on(phase), undisturbed, "{cell} changed what follows");
}

fn accepted(subject: &mut Subject, row: &Row, phase: Phase) {
    let cell = format!("{} {}", row.name, phase.phrase());
    let status = subject.call(row.name);
    // the standard defines no Integer status: rejected, whatever the kind
    let expected = if row.name == "fmi2GetIntegerStatus" { fmi2Error } else { fmi2OK };
    assert_eq!(status, expected, "{cell}: {:?}", subject.fmu.messages.borrow().last());
    let told = subject.fmu.messages.borrow_mut().drain(..).count();
    assert_eq!(told, usize::from(status != fmi2OK), "{cell}: messages");
    let after = if let Effect::To(after) = row.effect { after } else { phase };
    assert_eq!(subject.phase_named(), after.phrase(), "{cell} leads there");
    match row.effect {
        // in Initialization Mode reading evaluates the values set
        Effect::Reads if phase != Phase::Initialization => {
            assert_eq!(subject.present(), subject.bytes, "{cell} changed the state");
        }
        Effect::To(after) if after != phase => assert_ne!(subject.present(), subject.bytes, "{cell} changed nothing"),
        _ => {}
    }
    if row.name == "fmi2DoStep" {
        subject.time_s += STEP_S;
    }
    if row.name == "fmi2Reset" {
        subject.time_s = 0.0;
    }
    subject.go_on(after);
}

/// L-02. Without an instance, every function returns `fmi2Error`, and freeing null has no effect.
#[test]
fn l02_every_call_without_an_instance() {
    let mut subject = Subject::in_phase(Phase::StepComplete);
    let component = std::mem::replace(&mut subject.fmu.component, ptr::null_mut());
    let here = subject.here;
    for row in TABLE.iter().filter(|row| row.name != "fmi2FreeFMUstate") {
        assert_eq!(subject.call(row.name), fmi2Error, "{} without an instance", row.name);
    }
    assert_eq!(unsafe { fmi2FreeFMUstate(ptr::null_mut(), &mut { here }) }, fmi2Error);
    unsafe { fmi2FreeInstance(ptr::null_mut()) };
    assert!(subject.fmu.messages.borrow().is_empty(), "there is no log to tell");
    subject.fmu.component = component;
    assert_eq!(subject.present(), subject.bytes);
}
