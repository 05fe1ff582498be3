//! Every cause of `fmi2Error` and `fmi2Discard`: the complete message, and the state of the instance afterwards.

use crate::fmu::{Attempt, Fmu, OTHER, Resources, WING, guid_of};
use foldwing_fmu::derivatives::*;
use foldwing_fmu::exchange::*;
use foldwing_fmu::functions::*;
use foldwing_fmu::states::*;
use foldwing_fmu::status::*;
use foldwing_fmu::types::*;
use std::ptr;

/// The model in the tunnel, with few panels.
fn tunnel() -> String {
    include_str!("../../examples/models/folding_wing_in_tunnel.toml")
        .replace("strips = 10", "strips = 2")
        .replace("chord_panels = 4", "chord_panels = 2")
        .replace("wake_rows = 30", "wake_rows = 3")
}

impl Fmu {
    /// Panics unless the last call returned `expected` with exactly the message `text`.
    fn told(&self, status: fmi2Status, expected: fmi2Status, text: &str) {
        let told: Vec<_> = self.messages.borrow_mut().drain(..).map(|message| (message.status, message.text)).collect();
        assert_eq!((status, told), (expected, vec![(expected, text.to_owned())]));
    }

    /// Panics unless a step has failed to converge. The element with the largest change, and its size, depend on the method.
    fn gave_up(&self, status: fmi2Status, place: &str, advice: &str) {
        let text = self.messages.borrow_mut().pop().expect("a message").text;
        let begins = text.starts_with(&format!("fmi2DoStep: no convergence {place}"));
        assert!(status == fmi2Error && begins && text.ends_with(advice), "{text}");
    }

    /// An instance of a model, initialised.
    fn running(text: &str) -> Self {
        let fmu = Self::new(text);
        fmu.setup(0.0, None);
        unsafe {
            fmu.ok(fmi2EnterInitializationMode(fmu.component));
            fmu.ok(fmi2ExitInitializationMode(fmu.component));
        }
        fmu
    }

    fn last_good_s(&self) -> f64 {
        let mut time_s = f64::NAN;
        self.ok(unsafe { fmi2GetRealStatus(self.component, fmi2LastSuccessfulTime, &mut time_s) });
        time_s
    }
}

/// EM-01. Calls in the wrong order, and calls that are legal afterwards.
#[test]
fn em01_out_of_order() {
    let fmu = Fmu::new(WING);
    let c = fmu.component;
    unsafe {
        fmu.told(
            fmi2DoStep(c, 0.0, 1e-3, 0),
            fmi2Error,
            "fmi2DoStep: not legal before fmi2EnterInitializationMode; it is legal after fmi2ExitInitializationMode",
        );
        fmu.ok(fmi2EnterInitializationMode(c));
        fmu.told(
            fmi2Terminate(c),
            fmi2Error,
            "fmi2Terminate: not legal in Initialization Mode; it is legal after fmi2ExitInitializationMode",
        );
        fmu.ok(fmi2ExitInitializationMode(c));
        fmu.told(
            fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0),
            fmi2Error,
            "fmi2SetupExperiment: not legal after fmi2ExitInitializationMode; it is legal before \
             fmi2EnterInitializationMode; fmi2Reset leads back",
        );
        fmu.told(
            fmi2CancelStep(c),
            fmi2Error,
            "fmi2CancelStep: not legal after fmi2ExitInitializationMode: asynchronous steps are not supported, so no \
             step can be cancelled",
        );
        fmu.told(
            fmi2SetTime(c, 0.0),
            fmi2Error,
            "fmi2SetTime: not legal after fmi2ExitInitializationMode; it belongs to Model Exchange, and this instance \
             is for co-simulation",
        );
        fmu.ok(fmi2Terminate(c));
        fmu.told(
            fmi2SetReal(c, &0, 1, &0.0),
            fmi2Error,
            "fmi2SetReal: not legal after fmi2Terminate; it is legal before fmi2EnterInitializationMode, in \
             Initialization Mode, after fmi2ExitInitializationMode; fmi2SetFMUstate with an earlier state or fmi2Reset \
             leads back",
        );
    }
}

/// EM-02. Invalid arguments: each message gives the argument, its value and the allowed values.
#[test]
fn em02_arguments() {
    let fmu = Fmu::stepping();
    let c = fmu.component;
    let last = fmu.table.variables().len() - 1;
    let (torque, angle) = (fmu.reference("fold.external_torque"), fmu.reference("fold.angle"));
    let mut value = 0.0;
    unsafe {
        let null = "fmi2GetReal: argument vr is null; this is allowed only for a length of 0";
        fmu.told(fmi2GetReal(c, ptr::null(), 1, &mut value), fmi2Error, null);
        let unknown = format!("fmi2GetReal: unknown value reference 4000000000: this model has 0 to {last}");
        fmu.told(fmi2GetReal(c, &4_000_000_000, 1, &mut value), fmi2Error, &unknown);
        let text = format!("fmi2GetInteger: variable fold.angle (value reference {angle}) has type Real, not Integer");
        fmu.told(fmi2GetInteger(c, &angle, 1, &mut 0), fmi2Error, &text);
        fmu.told(
            fmi2SetReal(c, &angle, 1, &1.0),
            fmi2Error,
            "fmi2SetReal: variable fold.angle cannot be set: it is an output; only inputs and parameters can",
        );
        fmu.told(
            fmu.try_set("fold.start_angle", 1.0),
            fmi2Error,
            "fmi2SetReal: parameter fold.start_angle is fixed: it can be set before the end of the initialisation only",
        );
        for (value, shown) in [(f64::NAN, "NaN"), (f64::INFINITY, "inf"), (f64::NEG_INFINITY, "-inf")] {
            let text =
                format!("fmi2SetReal: variable fold.external_torque cannot be {shown}: the value must be finite");
            fmu.told(fmi2SetReal(c, &torque, 1, &value), fmi2Discard, &text);
        }
        fmu.told(
            fmu.try_set("fold.motor_damping", -1.0),
            fmi2Discard,
            "fmi2SetReal: variable fold.motor_damping cannot be -1: it must be ≥ 0 N.m.s/rad",
        );
        fmu.told(
            fmi2SetRealInputDerivatives(c, &angle, 1, &1, &1.0),
            fmi2Error,
            "fmi2SetRealInputDerivatives: variable fold.angle has no time derivative to set: only Real inputs have one",
        );
        fmu.told(
            fmi2SetRealInputDerivatives(c, &torque, 1, &2, &1.0),
            fmi2Error,
            "fmi2SetRealInputDerivatives: variable fold.external_torque has no time derivative of order 2: inputs have order 1, \
             outputs 1 and higher",
        );
        fmu.told(
            fmi2GetDirectionalDerivative(c, &torque, 1, &torque, 1, &1.0, &mut value),
            fmi2Error,
            "fmi2GetDirectionalDerivative: no derivative of variable fold.external_torque is available: unknowns must \
             be Real outputs",
        );
        fmu.told(
            fmi2GetDirectionalDerivative(c, &angle, 1, &angle, 1, &1.0, &mut value),
            fmi2Error,
            "fmi2GetDirectionalDerivative: no derivative with respect to variable fold.angle: knowns must be Real inputs and, in \
             Initialization Mode, parameters",
        );
        fmu.told(
            fmi2GetStatus(c, 3, &mut 0),
            fmi2Error,
            "fmi2GetStatus: status kind 3 is not reported by this function; it reports fmi2DoStepStatus",
        );
        fmu.told(
            fmi2SetDebugLogging(c, 1, 1, &c"\xff".as_ptr()),
            fmi2Error,
            "fmi2SetDebugLogging: argument categories is not UTF-8 text",
        );
        fmu.told(
            fmi2SetDebugLogging(c, 1, 1, &c"logNonsense".as_ptr()),
            fmi2Error,
            "fmi2SetDebugLogging: unknown log category \"logNonsense\"; allowed are logAll, logEvents, logStatusWarning, \
             logStatusDiscard, logStatusError, logStatusFatal",
        );
        fmu.ok(fmi2Reset(c));
        fmu.told(
            fmi2SetupExperiment(c, 0, 0.0, f64::NAN, 0, 0.0),
            fmi2Discard,
            "fmi2SetupExperiment: argument startTime is NaN: it must be finite",
        );
        fmu.told(
            fmi2SetupExperiment(c, 0, 0.0, 1.0, 1, 0.5),
            fmi2Discard,
            "fmi2SetupExperiment: argument stopTime is 0.5: it must be finite and not before startTime",
        );
        fmu.told(
            fmi2SetupExperiment(c, 1, 0.0, 0.0, 0, 0.0),
            fmi2Discard,
            "fmi2SetupExperiment: variable solver.tolerance cannot be 0: it must be from 1e-12 to 0.1",
        );
    }
}

/// EM-03. Invalid steps are rejected before the state changes.
#[test]
fn em03_steps() {
    let fmu = Fmu::new(WING);
    fmu.setup(0.0, Some(0.01));
    unsafe {
        fmu.ok(fmi2EnterInitializationMode(fmu.component));
        fmu.ok(fmi2ExitInitializationMode(fmu.component));
    }
    let before = fmu.serialize(fmu.save());
    let refused = |time_s, step_s, text: &str| fmu.told(fmu.try_step(time_s, step_s), fmi2Error, text);
    refused(
        0.0,
        -1e-3,
        "fmi2DoStep: the step from t = 0 s has the size -0.001 s: it must be positive, finite and advance the time",
    );
    refused(
        0.25,
        1e-3,
        "fmi2DoStep: the step starts at t = 0.25 s but the instance is at t = 0 s; step from there, or set an earlier \
         state",
    );
    refused(
        0.0,
        0.02,
        "fmi2DoStep: the step ends at t = 0.02 s, beyond the stop time 0.01 s given to fmi2SetupExperiment; shorten it, or \
         reset and give a later stop time",
    );
    assert_eq!(fmu.serialize(fmu.save()), before);
    fmu.ok(unsafe { fmi2Reset(fmu.component) });
    let fmu = Fmu::stepping();
    // used to run for ever
    fmu.told(
        fmu.try_step(0.0, 1e300),
        fmi2Error,
        "fmi2DoStep: the step from t = 0 s has the size 1e300 s: the maximum is 5e3 s; take shorter steps",
    );
    fmu.step(0.0, 1e-3);
}

/// EM-04. At 1e17 s the internal steps are below the round-off of the clock: an error, where it used to run for ever.
#[test]
fn em04_a_clock_without_resolution() {
    let fmu = Fmu::initializing(1e17);
    fmu.ok(unsafe { fmi2ExitInitializationMode(fmu.component) });
    let before = fmu.bits();
    fmu.told(
        fmu.try_step(1e17, 100.0),
        fmi2Error,
        "fmi2DoStep: a step of 9.7e-6 s does not advance the time t = 100000000000000000 s; start nearer to 0 s",
    );
    assert_eq!(fmu.bits(), before);
}

/// EM-05. Steps that fail at their start: each message gives the cause with time, location and value, all outputs are unchanged
/// (bit-identical), and the run can continue from an earlier state.
#[test]
fn em05_failures_at_the_begin_of_a_step() {
    type Spoil = fn(&Fmu);
    let causes: [(&str, Spoil, &str); 4] = [
        ("load", |fmu| fmu.set("load.outer[4].force.z", 1e200), "load.outer[4].force.z = 1e200 N"),
        ("moment", |fmu| fmu.set("load.inner[1].moment.x", 1e200), "load.inner[1].moment.x = 1e200 N.m"),
        ("spin", |fmu| fmu.set("root.angular_velocity.y", 1e200), "root.angular_velocity.y = 1e200 rad/s"),
        (
            "acceleration",
            |fmu| fmu.set("root.acceleration.z", 1e200),
            "root.acceleration.z = 1e200 m/s2; if this input is computed from root.force, the carrier must be heavier \
             than the wing \
             (0.063 kg)",
        ),
    ];
    let mut found = Vec::new();
    for (name, spoil, _) in causes {
        let fmu = Fmu::stepping();
        fmu.step(0.0, 1e-3);
        let good = fmu.save();
        let table = fmu.table.variables();
        let outputs = |fmu: &Fmu| -> Vec<u64> {
            let reals = table.iter().filter(|row| matches!(row.value, foldwing::interface::Value::Real(_)));
            let outputs = |row: &foldwing::interface::Variable| row.causality != foldwing::interface::Causality::Input;
            reals.zip(fmu.bits()).filter(|(row, _)| outputs(row)).map(|(_, bits)| bits).collect()
        };
        let before = outputs(&fmu);
        spoil(&fmu);
        let status = fmu.try_step(1e-3, 1e-3);
        assert_eq!(status, fmi2Error, "{name}");
        found.extend(fmu.messages.borrow_mut().drain(..).map(|message| message.text));
        assert_eq!(fmu.last_good_s(), 1e-3, "{name}");
        assert!(outputs(&fmu) == before, "{name}: outputs of the last good time");
        fmu.ok(unsafe { fmi2SetFMUstate(fmu.component, good) });
        fmu.step(1e-3, 1e-3);
    }
    let told = |(_, _, largest): (_, _, &str)| {
        format!(
            "fmi2DoStep: no accelerations at t = 0.001 s: the accelerations are not finite; the largest input is \
             {largest}; check the inputs and parameters from this time on"
        )
    };
    assert_eq!(found, causes.map(told));
}

/// EM-11. A torque too large for any step: the message gives the joint and the smallest step tried; the state is unchanged.
#[test]
fn em11_a_torque_beyond_measure() {
    let fmu = Fmu::stepping();
    fmu.step(0.0, 1e-3);
    let before = fmu.get("fold.angular_velocity");
    fmu.set("fold.external_torque", 1e25);
    let status = fmu.try_step(1e-3, 1e-3);
    fmu.gave_up(
        status,
        "at t = 0.001 s with internal steps down to 2.5e-10 s, worst at element ",
        "; the largest input is fold.external_torque = 1e25 N.m; check inputs and parameters far beyond the structure's strength",
    );
    assert_eq!((fmu.get("fold.angular_velocity"), fmu.last_good_s()), (before, 1e-3));
}

/// EM-12. For an extremely large command, the message names the command and not the weight.
#[test]
fn em12_a_command_beyond_measure() {
    let fmu = Fmu::stepping();
    fmu.step(0.0, 1e-3);
    fmu.set("fold.angle_command", 1e300);
    let status = fmu.try_step(1e-3, 1e-3);
    fmu.refused(status, fmi2Error, &["the largest input is fold.angle_command = 1e300 rad"]);
}

/// EM-13. A load that exceeds the aerodynamic model is an error at once that names the load, at the start and during a run; smaller ones
/// are simulated.
#[test]
fn em13_a_load_that_throws_the_wing_through_the_air() {
    let fmu = Fmu::running(&tunnel());
    fmu.step(0.0, 2e-3);
    fmu.set("load.outer[2].force.x", 1e6);
    let status = fmu.try_step(2e-3, 1e-12);
    let parts = [
        "the accelerations at t = 0.002 s move the wing by",
        "load.outer[2].force.x = 1e6 N; reduce the accelerations",
    ];
    fmu.refused(status, fmi2Error, &parts);
    let fmu = Fmu::new(&tunnel());
    fmu.setup(0.0, None);
    fmu.set("load.outer[2].force.x", 1e6);
    unsafe {
        fmu.ok(fmi2EnterInitializationMode(fmu.component));
        let status = fmi2ExitInitializationMode(fmu.component);
        fmu.refused(status, fmi2Error, &["the accelerations at t = 0 s move the wing by", "load.outer[2].force.x"]);
    }
}

/// EM-14. A communication step has a bounded number of iterations for any arguments; the error names the input that causes it, and the
/// instance is at the last valid time.
#[test]
fn em14_work_is_bounded() {
    let fmu = Fmu::initializing(0.0);
    fmu.set("solver.tolerance", 1e-8);
    fmu.set("solver.min_step", 1e-13);
    fmu.ok(unsafe { fmi2ExitInitializationMode(fmu.component) });
    fmu.step(0.0, 1e-3);
    fmu.set("load.outer[4].force.z", 1e6);
    let status = fmu.try_step(1e-3, 3e-3);
    let parts = ["reached only t = ", "load.outer[4].force.z = 1e6 N; use shorter communication steps"];
    fmu.refused(status, fmi2Error, &parts);
    let good_s = fmu.last_good_s();
    assert!(1e-3 < good_s && good_s < 4e-3, "{good_s} s");
}

/// EM-15. A wing that carries a fuselage lighter than itself, coupled step by step through `root.force` and `root.acceleration`: the loop
/// diverges, and the message gives the input and the rule; with eight times the wing's weight it converges.
#[test]
fn em15_a_carrier_lighter_than_the_wing() {
    let fly = |mass_kg: f64| {
        let fmu = Fmu::stepping();
        let mut largest_m_s2 = 0.0_f64;
        for i in 0..400 {
            let acceleration_m_s2 = fmu.get("root.force.z") / mass_kg;
            fmu.set("root.acceleration.z", acceleration_m_s2);
            largest_m_s2 = largest_m_s2.max(acceleration_m_s2.abs());
            if fmu.try_step(5e-4 * f64::from(i), 5e-4) != fmi2OK {
                return (largest_m_s2, fmu.messages.borrow_mut().pop().map(|message| message.text));
            }
        }
        (largest_m_s2, None)
    };
    let (heavy, light) = (fly(0.5), fly(0.01));
    println!("EM-15: {heavy:?}, {light:?}");
    assert!(heavy.0 < 100.0 && heavy.1.is_none(), "{heavy:?}");
    let told = light.1.expect("diverges");
    assert!(told.contains("the largest input is root.acceleration.z = "), "{told}");
    assert!(
        told.contains(
            "if this input is computed from root.force, the carrier must be heavier than the wing (0.063 kg)"
        ),
        "{told}"
    );
}

/// EM-16. With aerodynamics there are no directional derivatives: calls are rejected with the reason, in every phase.
#[test]
fn em16_no_directional_derivatives_in_air() {
    let fmu = Fmu::running(&tunnel());
    let (unknown, known) = (fmu.reference("root.force.z"), fmu.reference("wind.velocity.z"));
    let mut value = 0.0;
    let status = unsafe { fmi2GetDirectionalDerivative(fmu.component, &unknown, 1, &known, 1, &1.0, &mut value) };
    fmu.told(
        status,
        fmi2Error,
        "fmi2GetDirectionalDerivative: no directional derivatives with aerodynamics: the aerodynamic loads would be held \
         constant, and the derivatives wrong; use differences of steps from one saved state",
    );
}

/// EM-06. A step that fails halfway, at a latch of 1e30 N·m/rad: the instance is at the end of the last valid internal step, bit-identical
/// to a second instance stepped to that time.
#[test]
fn em06_a_failure_on_the_way() {
    let [fmu, twin] = [(); 2].map(|()| {
        let fmu = Fmu::initializing(0.0);
        fmu.set("fold.latch_stiffness", 1e30);
        fmu.set("solver.min_step", 1e-6);
        fmu.ok(unsafe { fmi2ExitInitializationMode(fmu.component) });
        fmu
    });
    let status = fmu.try_step(0.0, 0.4);
    let good_s = fmu.last_good_s();
    assert_eq!(good_s, fmu.get("fold.latch_time"), "the latch closes, nothing follows");
    fmu.gave_up(
        status,
        &format!("at t = {good_s} s with internal steps down to 2.5e-7 s, worst at element "),
        "; check loads, motor and latch there, or allow a smaller solver.min_step",
    );
    twin.step(0.0, good_s);
    let state = [
        "fold.angle",
        "fold.angular_velocity",
        "tip.position.x",
        "tip.position.z",
        "tip.velocity.x",
        "gauge.root.strain",
    ];
    for name in state {
        assert_eq!(fmu.get(name).to_bits(), twin.get(name).to_bits(), "{name}");
    }
}

/// EM-07. Start values without a consistent state; they can be corrected in Initialization Mode.
#[test]
fn em07_failures_of_the_initialisation() {
    let fmu = Fmu::initializing(0.0);
    let c = fmu.component;
    fmu.set("solver.min_step", 0.1);
    let text = "fmi2ExitInitializationMode: solver.min_step, 1e-1 s, is longer than solver.max_step, 5e-3 s; change one of them";
    let before = fmu.serialize(fmu.save());
    fmu.told(unsafe { fmi2ExitInitializationMode(c) }, fmi2Error, text);
    fmu.set("solver.min_step", 1e-9);
    fmu.set("gravity.z", -1e300);
    fmu.told(
        unsafe { fmi2ExitInitializationMode(c) },
        fmi2Error,
        "fmi2ExitInitializationMode: no accelerations at t = 0 s: the accelerations are not finite; the largest input is \
         gravity.z = -1e300 m/s2; check the inputs and parameters from this time on",
    );
    fmu.set("gravity.z", 0.0);
    assert_eq!(fmu.serialize(fmu.save()).len(), before.len());
    fmu.ok(unsafe { fmi2ExitInitializationMode(c) });

    // a free body is held while it settles, a ball joint is not
    let flying = include_str!("../../examples/models/flying_wing.toml");
    let flying = flying.replace("[simulation]", "[simulation]\nstart = \"equilibrium\"");
    let fmu = Fmu::new(&flying);
    fmu.ok(unsafe { fmi2EnterInitializationMode(fmu.component) });
    fmu.ok(unsafe { fmi2ExitInitializationMode(fmu.component) });
    let flight = "type = \"free\"\nparent = \"root\"\nchild = \"keel\"\nstart_velocity_m_s = [-12.0, 0.0, 0.0] # nose first: the keel's x points aft";
    assert!(flying.contains(flight));
    let fmu = Fmu::new(&flying.replace(flight, "type = \"ball\"\nparent = \"root\"\nchild = \"keel\""));
    fmu.ok(unsafe { fmi2EnterInitializationMode(fmu.component) });
    let status = unsafe { fmi2ExitInitializationMode(fmu.component) };
    fmu.told(
        status,
        fmi2Error,
        "fmi2ExitInitializationMode: no equilibrium at t = 0 s beyond the load factor 0.0000, last tried 0.0001: no \
         stiffness resists \
         a motion of joint \"flight\": add a spring; reduce the load, or start from the unstrained shape",
    );

    let fmu = Fmu::new(&tunnel());
    fmu.setup(0.0, None);
    fmu.ok(unsafe { fmi2EnterInitializationMode(fmu.component) });
    fmu.set("wind.velocity.z", 1e200);
    let status = unsafe { fmi2ExitInitializationMode(fmu.component) };
    fmu.told(status, fmi2Error,
        "fmi2ExitInitializationMode: no aerodynamic loads at t = 0 s: the loads are not finite; check wind and density, or try \
         another aerodynamics.step_s",
    );
    fmu.set("wind.velocity.z", 0.0);
    fmu.ok(unsafe { fmi2ExitInitializationMode(fmu.component) });
}

/// EM-08. A gust for which no aerodynamic step converges: the outputs are unchanged (bit-identical), with aerodynamics too.
#[test]
fn em08_a_failure_of_the_air() {
    let fmu = Fmu::running(&tunnel());
    fmu.step(0.0, 2e-3);
    let good = fmu.save();
    let (tip, force) = (fmu.get("tip.position.z"), fmu.get("aero.force.z"));
    fmu.set("wind.velocity.y", 1e200);
    let status = fmu.try_step(2e-3, 2e-3);
    fmu.told(status, fmi2Error,
        "fmi2DoStep: no aerodynamic loads at t = 0.002 s: the loads are not finite; check wind and density, or try another \
         aerodynamics.step_s",
    );
    assert_eq!((fmu.get("tip.position.z"), fmu.get("aero.force.z"), fmu.last_good_s()), (tip, force, 2e-3));
    fmu.ok(unsafe { fmi2SetFMUstate(fmu.component, good) });
    fmu.step(2e-3, 2e-3);
}

/// EM-09. States that cannot be set.
#[test]
fn em09_states() {
    let (fmu, other) = (Fmu::stepping(), Fmu::new(OTHER));
    let bytes = fmu.serialize(fmu.save());
    let n = bytes.len();
    let refused = |bytes: &[u8], text: &str| fmu.told(fmu.deserialize(bytes).0, fmi2Error, text);
    let changed = |at: usize, byte: u8| [&bytes[..at], &[byte], &bytes[at + 1..]].concat();
    refused(
        &bytes[..n - 1],
        &format!(
            "fmi2DeSerializeFMUstate: the serialised FMU state is damaged: {} bytes instead of {n}; pass all the \
             bytes that were written when it was serialised",
            n - 1
        ),
    );
    refused(
        &changed(n - 1, bytes[n - 1] ^ 1),
        "fmi2DeSerializeFMUstate: the serialised FMU state is damaged: its checksum does not match; pass the bytes as \
         they were written when it was serialised",
    );
    refused(
        &changed(0, b'X'),
        "fmi2DeSerializeFMUstate: the serialised FMU state was not written by this program: it does not begin with \
         FOLDWING",
    );
    refused(
        &changed(8, 1),
        "fmi2DeSerializeFMUstate: the serialised FMU state has version 1; this library reads version 10: serialise it again \
         with this one",
    );
    refused(
        &other.serialize(other.save()),
        &format!(
            "fmi2DeSerializeFMUstate: the serialised FMU state belongs to the model {}, not to {}; set one of this model",
            guid_of(OTHER),
            guid_of(WING)
        ),
    );
    let stranger = other.save();
    fmu.told(
        unsafe { fmi2SetFMUstate(fmu.component, stranger) },
        fmi2Error,
        "fmi2SetFMUstate: the FMU state was freed or belongs to another instance; set one that this instance has saved",
    );
    let mut short = vec![0_i8; 10];
    fmu.told(
        unsafe { fmi2SerializeFMUstate(fmu.component, fmu.save(), short.as_mut_ptr().cast(), 10) },
        fmi2Error,
        &format!(
            "fmi2SerializeFMUstate: the buffer for the serialised FMU state has 10 bytes; {n} are needed, as returned \
             by the function for the serialised size"
        ),
    );
}

/// EM-19. Model Exchange: variables that the importer cannot set, states of the other interface type, an unknown interface type.
#[test]
fn em19_model_exchange() {
    let fmu = Fmu::exchanged(WING);
    let (c, n) = (fmu.component, fmu.table.nominals().len());
    fmu.setup(0.0, None);
    let mut states = vec![0.0; n];
    unsafe {
        fmu.ok(fmi2EnterInitializationMode(c));
        fmu.ok(fmi2ExitInitializationMode(c));
        fmu.ok(fmi2EnterContinuousTimeMode(c));
        fmu.told(
            fmi2SetBoolean(c, &fmu.reference("fold.release"), 1, &0),
            fmi2Error,
            "fmi2SetBoolean: variable fold.release cannot be set in Continuous-Time Mode: only continuous inputs can; set it in Event \
             Mode, after fmi2EnterEventMode",
        );
        fmu.told(
            fmi2SetTime(c, -0.5),
            fmi2Discard,
            "fmi2SetTime: time -0.5 s lies before the last event or the start, at 0 s: latches and other states of events would be those of \
             the future; restore a state of the FMU saved before the event with fmi2SetFMUstate",
        );
        fmu.ok(fmi2GetContinuousStates(c, states.as_mut_ptr(), n));
        states[0] = f64::NAN;
        fmu.told(
            fmi2SetContinuousStates(c, states.as_ptr(), n),
            fmi2Discard,
            "fmi2SetContinuousStates: continuous state state.inner.element[1].epsilon_x cannot be NaN: the value must be finite",
        );
        fmu.told(
            fmi2SetContinuousStates(c, states.as_ptr(), 1),
            fmi2Error,
            &format!("fmi2SetContinuousStates: argument nx is 1: this model has {n}"),
        );
        fmu.told(
            fmi2SetReal(
                c,
                &fmu.table.variables().iter().find(|row| row.nominal.is_some()).unwrap().value_reference,
                1,
                &f64::NAN,
            ),
            fmi2Discard,
            "fmi2SetReal: variable state.inner.element[1].epsilon_x cannot be NaN: the value must be finite",
        );
        states[0] = -2.0;
        fmu.ok(fmi2SetContinuousStates(c, states.as_ptr(), n));
        fmu.told(
            fmi2GetDerivatives(c, states.as_mut_ptr(), n),
            fmi2Discard,
            "fmi2GetDerivatives: no derivatives at these states, of which state.inner.element[1].epsilon_x = -2e0 is farthest from its \
             nominal magnitude: at t = 0 s element 1 of 4 of body inner is compressed to less than zero length: the \
             longitudinal strain is -2.000e0, but must be greater than -1; let the integrator take a shorter step from \
             the last states, or integrate with an \
             implicit method",
        );
    }
    let other = Fmu::of_kind(WING, fmi2CoSimulation);
    let (status, state) = other.deserialize(&fmu.serialize(fmu.save()));
    other.ok(status);
    other.told(
        unsafe { fmi2SetFMUstate(other.component, state) },
        fmi2Error,
        "fmi2SetFMUstate: the FMU state was saved by an instance for Model Exchange and does not fit one for \
         co-simulation; set a state of the same interface type",
    );
    let resources = Resources::with(WING);
    assert_eq!(
        Attempt { fmu_type: 7, ..Attempt::of(WING, &resources) }.refusal(),
        "fmi2Instantiate: FMU type 7 is unknown; allowed are 0 (Model Exchange) and 1 (co-simulation)"
    );
}

/// EM-10. Rejected instantiations.
#[test]
fn em10_instances() {
    let resources = Resources::with(WING);
    let folder = resources.folder.display().to_string();
    let attempt = || Attempt::of(WING, &resources);
    let says = |attempt: Attempt, text: &str| assert_eq!(attempt.refusal(), format!("fmi2Instantiate: {text}"));
    says(Attempt { name: None, ..attempt() }, "the instance name is missing: it is null or empty");
    says(
        Attempt { fmu_type: fmi2ModelExchange, ..attempt() },
        "this FMU is for co-simulation only: Model Exchange was requested; package it with --interface cs,me",
    );
    says(
        Attempt { guid: Some("{0}".into()), ..attempt() },
        &format!(
            "the GUID {{0}} of the model description differs from {}, which this library computes for \
             resources/model.toml; package the model again",
            guid_of(WING)
        ),
    );
    says(Attempt { location: None, ..attempt() }, "no resource location was given: the model file cannot be found");
    says(
        Attempt { location: Some("http://a/r".into()), ..attempt() },
        "the resource location \"http://a/r\" is not a file URI or a path",
    );
    says(
        Attempt { location: Some("file:///a%zz".into()), ..attempt() },
        "the resource location \"file:///a%zz\" is not properly percent-encoded UTF-8",
    );
    std::fs::write(resources.folder.join("model.toml"), "name = 1").expect("writable");
    let text = attempt().refusal();
    let place =
        format!("fmi2Instantiate: the model cannot be read: {folder}/model.toml:1: key 'name': 1 is not allowed");
    assert!(text.starts_with(&place), "{text}");
    std::fs::remove_file(resources.folder.join("model.toml")).expect("removable");
    let text = attempt().refusal();
    let place = format!("fmi2Instantiate: the model file \"{folder}/model.toml\" cannot be read: ");
    assert!(text.starts_with(&place), "{text}");
}

/// Event Mode of co-simulation is for importers that requested it: for others no saved state can be in it.
#[test]
fn event_mode_that_was_declined_is_refused() {
    let fmu = crate::fmu3::Fmu3::started(crate::fmu3::Agreed::default());
    let before = fmu.present();
    assert_eq!(unsafe { foldwing_fmu::fmi3::exchange::fmi3EnterEventMode(fmu.instance) }, 3);
    let told = "fmi3EnterEventMode: this instance was created without Event Mode: pass eventModeUsed = true to \
                fmi3InstantiateCoSimulation";
    assert_eq!(fmu.told(), told);
    assert_eq!(fmu.present(), before);
    fmu.step(0.0, 1e-3);
}
