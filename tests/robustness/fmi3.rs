//! FMI 3.0 through the C functions: bit-identical results with FMI 2.0, arrays, events within steps, early return, derivatives, saved
//! states, life cycle.

use crate::counting_allocator::allocations;
use crate::fmu::{Fmu, WING};
use crate::fmu3::{Agreed, Fmu3};
use foldwing_fmu::derivatives::*;
use foldwing_fmu::exchange::*;
use foldwing_fmu::fmi3::clocks::*;
use foldwing_fmu::fmi3::derivatives::*;
use foldwing_fmu::fmi3::exchange::*;
use foldwing_fmu::fmi3::functions::*;
use foldwing_fmu::fmi3::states::*;
pub use foldwing_fmu::fmi3::steps::fmi3EnterStepMode as enter_step;
use foldwing_fmu::fmi3::steps::*;
use foldwing_fmu::fmi3::values::*;
use foldwing_fmu::functions::*;
use std::ptr;

pub const TWO_FOLDS: &str = include_str!("../../examples/models/three_bodies.toml");
pub const FLYING: &str = include_str!("../../examples/models/flying_wing.toml");
const TUNNEL: &str = include_str!("../../examples/models/folding_wing_in_tunnel.toml");

/// An importer that handles events itself.
pub const EVENTS: Agreed = Agreed { event_mode: true, early_return: true, intermediate_update: false };
/// Communication step in s.
pub const STEP_S: f64 = 1e-3;

/// F3-01. The same model with the same steps gives bit-identical results in both versions: every Real, also between steps, through the
/// latch, with changing inputs; also with aerodynamics and in free flight.
#[test]
fn f301_co_simulation_of_both_versions_has_the_same_bits() {
    for (text, steps) in [(WING, 150), (FLYING, 20), (TUNNEL, 3)] {
        let (second, third) = (Fmu::new(text), Fmu3::new(text, Agreed::default()));
        second.setup(0.0, None);
        unsafe {
            second.ok(fmi2EnterInitializationMode(second.component));
            second.ok(fmi2ExitInitializationMode(second.component));
        }
        third.start();
        for i in 0..steps {
            let gravity = [-9.81 + 1e-3 * f64::from(i), 0.1, 0.0];
            for (axis, value) in ["x", "y", "z"].iter().zip(gravity) {
                second.set(&format!("gravity.{axis}"), value);
            }
            third.set("gravity", &gravity);
            second.step(STEP_S * f64::from(i), STEP_S);
            let answer = third.step(STEP_S * f64::from(i), STEP_S);
            assert!(!answer.event && !answer.early);
            assert_eq!(second.bits(), third.bits(), "step {i}");
        }
    }
}

/// F3-02. Arrays correspond row by row to the scalars of FMI 2.0; they are accepted as a whole or rejected because of count, type or an
/// element.
#[test]
fn f302_arrays_are_set_and_read_whole() {
    let fmu = Fmu3::started(Agreed::default());
    let loads: Vec<f64> = (0..12).map(f64::from).collect();
    fmu.set("load.outer.force", &loads);
    assert_eq!(fmu.get("load.outer.force"), loads);
    let array = &fmu.table.arrays()[fmu.reference("load.outer.force") as usize];
    assert_eq!(array.dimensions, [4, 3]);
    assert_eq!(fmu.table.variables()[array.rows[5] as usize].name, "load.outer[2].force.z");
    assert_eq!(fmu.try_set("load.outer.force", &loads[..11]), 3);
    let expected =
        "11 values were passed for 1 variables that have 12: pass a value for each element of an array, row by row";
    assert!(fmu.told().contains(expected));
    let before = fmu.present();
    let mut bad = loads.clone();
    bad[7] = f64::NAN;
    assert_eq!(fmu.try_set("load.outer.force", &bad), 2);
    assert!(fmu.told().contains("load.outer[3].force.y"), "the element is named");
    assert_eq!(fmu.try_set_boolean("load.outer.force", true), 3);
    assert!(fmu.told().contains("has type Float64, not Boolean"));
    assert_eq!(fmu.try_set("tip.position", &[0.0; 3]), 3);
    assert!(fmu.told().contains("it is an output"));
    assert_eq!(unsafe { fmi3SetFloat64(fmu.instance, &9999, 1, &0.0, 1) }, 3);
    assert!(fmu.told().contains("unknown value reference 9999"));
    assert_eq!(unsafe { fmi3GetFloat32(fmu.instance, &0, 1, ptr::null_mut(), 1) }, 3);
    assert!(fmu.told().contains("variable time (value reference 0) has type Float64, not Float32"));
    assert_eq!(unsafe { fmi3GetString(fmu.instance, ptr::null(), 0, ptr::null_mut(), 0) }, 0);
    assert!(fmu.present() == before, "a refused call changes nothing");
}

/// Tolerance of the runs with two folds.
const FINE: f64 = 1e-8;

/// Simulates two folds: the outer one is locked until the inner one latches. Returns the times at which they latch in s, and the outer
/// angle in rad at the end.
fn release_at_the_latch(step_s: f64, end_s: f64) -> [f64; 3] {
    let fmu = Fmu3::new(TWO_FOLDS, EVENTS);
    fmu.ok(fmu.try_set_boolean("fold_outer.release", false));
    unsafe {
        fmu.ok(fmi3EnterInitializationMode(fmu.instance, true, FINE, 0.0, false, 0.0));
        fmu.ok(fmi3ExitInitializationMode(fmu.instance));
    }
    fmu.update();
    fmu.ok(unsafe { fmi3EnterStepMode(fmu.instance) });
    let (mut time_s, mut latched_s) = (0.0, f64::NAN);
    while time_s < end_s - 1e-12 {
        let answer = fmu.step(time_s, step_s.min(end_s - time_s));
        time_s = answer.last_s;
        if answer.event {
            fmu.ok(unsafe { fmi3EnterEventMode(fmu.instance) });
            let before = fmu.get_boolean("fold_inner.latched");
            fmu.update();
            if !before && fmu.get_boolean("fold_inner.latched") && latched_s.is_nan() {
                latched_s = time_s;
                assert_eq!(fmu.get("fold_inner.latch_time"), [latched_s]);
                fmu.ok(fmu.try_set_boolean("fold_outer.release", true));
                fmu.update();
            }
            fmu.ok(unsafe { fmi3EnterStepMode(fmu.instance) });
        }
    }
    [latched_s, fmu.get("fold_outer.latch_time")[0], fmu.get("fold_outer.angle")[0]]
}

/// F3-03. An importer that uses Event Mode gets control at the latch, whatever its steps, and releases the second fold at exactly this
/// instant: as in FMI 2.0 with a communication point there, known in advance. The results are bit-identical for all communication steps.
#[test]
fn f303_the_second_fold_is_released_when_the_first_latches() {
    let end_s = 0.4;
    let found @ [latched_s, outer_s, angle] = release_at_the_latch(0.02, end_s);
    let second = Fmu::new(TWO_FOLDS);
    second.set_boolean("fold_outer.release", false);
    unsafe {
        second.ok(fmi2SetupExperiment(second.component, 1, FINE, 0.0, 0, 0.0));
        second.ok(fmi2EnterInitializationMode(second.component));
        second.ok(fmi2ExitInitializationMode(second.component));
    }
    second.step(0.0, latched_s);
    assert_eq!(second.get("fold_inner.latch_time"), latched_s);
    second.set_boolean("fold_outer.release", true);
    second.step(latched_s, end_s - latched_s);
    let (known_s, known) = (second.get("fold_outer.latch_time"), second.get("fold_outer.angle"));
    println!("latches at {latched_s:.9} s and {outer_s:.9} s, {:+.1e} s beside the known release", outer_s - known_s);
    // at a tolerance of 1e-8 either run is accurate to about 1e-9 s and 1e-7 rad; their internal steps differ
    assert!(outer_s > latched_s && (outer_s - known_s).abs() < 1e-8, "{outer_s} {known_s}");
    assert!((angle - known).abs() < 1e-6, "{angle} {known}");
    for step_s in [5e-3, 0.05] {
        assert_eq!(release_at_the_latch(step_s, end_s), found, "step {step_s} s");
    }
}

/// F3-04. Events end a step only if the importer uses Event Mode and allows early return; otherwise the step handles them, bit-identical to
/// FMI 2.0. The event is at the closing of the latch, and the discrete outputs change in the event.
#[test]
fn f304_a_step_ends_at_the_latch_only_where_it_may() {
    let whole = Agreed { event_mode: true, ..Agreed::default() };
    let handled = Fmu3::started(whole);
    handled.update();
    handled.ok(unsafe { fmi3EnterStepMode(handled.instance) });
    let plain = Fmu3::started(Agreed::default());
    let answer = handled.step(0.0, 0.2);
    assert_eq!((answer, answer.early), (plain.step(0.0, 0.2), false));
    assert_eq!(handled.bits(), plain.bits());
    let latch_s = plain.get("fold.latch_time")[0];

    let fmu = Fmu3::started(EVENTS);
    fmu.update();
    fmu.ok(unsafe { fmi3EnterStepMode(fmu.instance) });
    let answer = fmu.step(0.0, 0.2);
    assert!(answer.event && answer.early);
    assert_eq!(answer.last_s, latch_s);
    assert!(!fmu.get_boolean("fold.latched"), "it closes in the event");
    assert_eq!(fmu.try_set_boolean("fold.latch_enable", false), 3, "switches change in Event Mode");
    assert!(
        fmu.told().contains("in Step Mode: only continuous inputs can; set it in Event Mode, after fmi3EnterEventMode")
    );
    let waiting = fmu.save();
    unsafe {
        fmu.ok(fmi3EnterEventMode(fmu.instance));
        fmu.update();
        assert!(fmu.get_boolean("fold.latched"));
        let after = fmu.bits();
        fmu.update();
        assert_eq!(fmu.bits(), after, "nothing is left to do");
        fmu.ok(fmi3EnterStepMode(fmu.instance));
        let rest_s = 0.2 - answer.last_s;
        let ended = fmu.step(answer.last_s, rest_s);
        assert!(!ended.event && !ended.early);
        assert_eq!(fmu.bits(), plain.bits(), "the same steps, the same bits");
        // an importer that continues without Event Mode
        fmu.ok(fmi3SetFMUState(fmu.instance, waiting));
        fmu.step(answer.last_s, rest_s);
    }
    assert_eq!(fmu.bits(), plain.bits());
}

/// F3-05. Within a step the importer receives an update at every internal step, can only read there, and may end the step; results with and
/// without updates are bit-identical.
#[test]
fn f305_intermediate_updates() {
    let agreed = Agreed { intermediate_update: true, early_return: true, ..Agreed::default() };
    let (asked, plain) = (Fmu3::started(agreed), Fmu3::started(Agreed::default()));
    asked.environment.reads.set(asked.reference("fold.angle"));
    asked.step(0.0, 0.05);
    plain.step(0.0, 0.05);
    assert_eq!(asked.bits(), plain.bits(), "hearing changes nothing");
    let heard = asked.environment.asked.borrow().clone();
    assert!(heard.len() > 5, "{heard:?}");
    assert!(heard.iter().all(|&(time_s, angle, status)| time_s < 0.05 && angle.is_finite() && status == 0));
    assert!(heard.is_sorted_by(|a, b| a.0 < b.0));
    let last = *heard.last().expect("some");

    // the same instants as communication points of another run
    let other = Fmu3::started(Agreed::default());
    other.step(0.0, last.0);
    assert_eq!(other.get("fold.angle")[0].to_bits(), last.1.to_bits());

    for (from_s, named_s, expected_s) in [(0.06, 0.0, None), (0.06, 0.07, Some(0.07))] {
        let fmu = Fmu3::started(agreed);
        fmu.environment.reads.set(fmu.reference("fold.angle"));
        fmu.environment.returns.set(Some((from_s, named_s)));
        let answer = fmu.step(0.0, 0.1);
        assert!(answer.early && !answer.event);
        match expected_s {
            Some(expected_s) => assert_eq!(answer.last_s, expected_s),
            None => assert!(answer.last_s >= from_s && answer.last_s < 0.1),
        }
        fmu.environment.returns.set(None);
        fmu.step(answer.last_s, 0.1 - answer.last_s);
    }

    let intrusions: [fn(_) -> _; 5] = [
        |instance| unsafe { fmi3Reset(instance) },
        |instance| unsafe { fmi3Terminate(instance) },
        |instance| unsafe { fmi3SetFloat64(instance, &1, 1, &0.0, 1) },
        |instance| unsafe { fmi3GetFMUState(instance, &mut ptr::null_mut()) },
        |instance| unsafe {
            fmi3FreeInstance(instance);
            fmi3DoStep(instance, 0.0, 0.1, true, &mut false, &mut false, &mut false, &mut 0.0)
        },
    ];
    for intrusion in intrusions {
        let fmu = Fmu3::started(agreed);
        fmu.environment.intrudes.set(Some(intrusion));
        fmu.step(0.0, 0.05);
        fmu.environment.intrudes.set(None);
        assert_eq!(fmu.bits(), plain.bits());
    }
}

/// F3-06. Directional derivatives are bit-identical to those of FMI 2.0; the adjoint is their transpose to round-off, while stepping and in
/// Initialization Mode.
#[test]
fn f306_adjoint_derivatives_are_the_transpose() {
    let fmu = Fmu3::started(Agreed::default());
    fmu.step(0.0, 0.02);
    let unknowns = ["tip.acceleration", "gauge.strain", "root.force"].map(|name| fmu.reference(name));
    let knowns = ["load.outer.force", "gravity", "fold.external_torque"].map(|name| fmu.reference(name));
    let count = |references: &[u32]| -> usize {
        references.iter().map(|&reference| fmu.table.arrays()[reference as usize].rows.len()).sum()
    };
    let (rows, columns) = (count(&unknowns), count(&knowns));
    let mut forward = vec![0.0; rows * columns];
    for column in 0..columns {
        let mut seed = vec![0.0; columns];
        seed[column] = 1.0;
        let mut found = vec![0.0; rows];
        fmu.ok(unsafe {
            fmi3GetDirectionalDerivative(
                fmu.instance,
                unknowns.as_ptr(),
                3,
                knowns.as_ptr(),
                3,
                seed.as_ptr(),
                columns,
                found.as_mut_ptr(),
                rows,
            )
        });
        for (row, value) in found.into_iter().enumerate() {
            forward[row * columns + column] = value;
        }
    }
    assert!(forward.iter().filter(|entry| **entry != 0.0).count() > rows * columns / 4);
    for row in 0..rows {
        let mut seed = vec![0.0; rows];
        seed[row] = 1.0;
        let mut found = vec![0.0; columns];
        fmu.ok(unsafe {
            fmi3GetAdjointDerivative(
                fmu.instance,
                unknowns.as_ptr(),
                3,
                knowns.as_ptr(),
                3,
                seed.as_ptr(),
                rows,
                found.as_mut_ptr(),
                columns,
            )
        });
        assert_eq!(found, forward[row * columns..][..columns], "row {row}: one column is found in one way");
    }
    // time derivatives of outputs are those of FMI 2.0
    let second = Fmu::stepping();
    second.step(0.0, 0.02);
    let (mut rates, mut expected) = ([0.0; 3], [0.0; 3]);
    let reference = fmu.reference("tip.position");
    fmu.ok(unsafe { fmi3GetOutputDerivatives(fmu.instance, &reference, 1, &1, rates.as_mut_ptr(), 3) });
    let rows = ["x", "y", "z"].map(|axis| second.reference(&format!("tip.position.{axis}")));
    let (c, order) = (second.component, [1; 3]);
    second.ok(unsafe { fmi2GetRealOutputDerivatives(c, rows.as_ptr(), 3, order.as_ptr(), expected.as_mut_ptr()) });
    assert_eq!(rates, expected);
    assert!(rates.iter().any(|rate| rate.abs() > 0.1), "{rates:?}");
}

/// F3-07. Rollback and serialised states restore the instance bit-identically, also from within an event; a state of FMI 2.0 is rejected.
#[test]
fn f307_saved_states() {
    let fmu = Fmu3::started(EVENTS);
    fmu.update();
    fmu.ok(unsafe { fmi3EnterStepMode(fmu.instance) });
    let answer = fmu.step(0.0, 0.2);
    fmu.ok(unsafe { fmi3EnterEventMode(fmu.instance) });
    let bytes = fmu.present();
    let go_on = |fmu: &Fmu3| {
        fmu.update();
        fmu.ok(unsafe { fmi3EnterStepMode(fmu.instance) });
        fmu.step(answer.last_s, 0.02);
        fmu.bits()
    };
    let here = fmu.save();
    let expected = go_on(&fmu);
    fmu.ok(unsafe { fmi3SetFMUState(fmu.instance, here) });
    assert_eq!(go_on(&fmu), expected);
    let other = Fmu3::started(EVENTS);
    let mut state = ptr::null_mut();
    other.ok(unsafe { fmi3DeserializeFMUState(other.instance, bytes.as_ptr(), bytes.len(), &mut state) });
    other.ok(unsafe { fmi3SetFMUState(other.instance, state) });
    assert_eq!(go_on(&other), expected);
    // without Event Mode there is no such phase
    let plain = Fmu3::started(Agreed::default());
    plain.ok(unsafe { fmi3DeserializeFMUState(plain.instance, bytes.as_ptr(), bytes.len(), &mut state) });
    assert_eq!(unsafe { fmi3SetFMUState(plain.instance, state) }, 3);
    assert!(plain.told().contains("it was saved in Event Mode, a state that this instance never enters"));
    let second = Fmu::stepping();
    let bytes = second.serialize(second.save());
    assert_eq!(unsafe { fmi3DeserializeFMUState(fmu.instance, bytes.as_ptr(), bytes.len(), &mut state) }, 3);
    assert!(fmu.told().contains("belongs to the model"));
}

/// F3-08. Model Exchange of both versions is bit-identical: derivatives, indicators, nominal values, an event.
#[test]
fn f308_model_exchange_of_both_versions_has_the_same_bits() {
    for text in [WING, FLYING] {
        let (second, third) = (Fmu::exchanged(text), Fmu3::exchanged(text));
        second.setup(0.0, None);
        let (c, i) = (second.component, third.instance);
        let (mut states, mut indicators) = (0, 0);
        unsafe {
            second.ok(fmi2EnterInitializationMode(c));
            second.ok(fmi2ExitInitializationMode(c));
            third.start();
            third.ok(fmi3GetNumberOfContinuousStates(i, &mut states));
            third.ok(fmi3GetNumberOfEventIndicators(i, &mut indicators));
            assert_eq!(states, second.table.nominals().len());
            let mut info = std::mem::zeroed();
            second.ok(fmi2NewDiscreteStates(c, &mut info));
            third.update();
            second.ok(fmi2EnterContinuousTimeMode(c));
            third.ok(fmi3EnterContinuousTimeMode(i));
            let mut x = vec![0.0; states];
            third.ok(fmi3GetContinuousStates(i, x.as_mut_ptr(), states));
            // Euler's method, with steps short enough that the divergence in the axial modes stays small
            for step in 0..20 {
                let time_s = 1e-6 * f64::from(step);
                second.ok(fmi2SetTime(c, time_s));
                second.ok(fmi2SetContinuousStates(c, x.as_ptr(), states));
                third.ok(fmi3SetTime(i, time_s));
                third.ok(fmi3SetContinuousStates(i, x.as_ptr(), states));
                let (mut a, mut b) = (vec![0.0; states], vec![0.0; states]);
                second.ok(fmi2GetDerivatives(c, a.as_mut_ptr(), states));
                third.ok(fmi3GetContinuousStateDerivatives(i, b.as_mut_ptr(), states));
                assert_eq!(a, b);
                let (mut za, mut zb) = (vec![0.0; indicators], vec![0.0; indicators]);
                second.ok(fmi2GetEventIndicators(c, za.as_mut_ptr(), indicators));
                third.ok(fmi3GetEventIndicators(i, zb.as_mut_ptr(), indicators));
                assert_eq!(za, zb);
                if indicators > 0 {
                    assert_eq!(third.get("event_indicator"), zb);
                }
                x.iter_mut().zip(&a).for_each(|(x, slope)| *x += 1e-6 * slope);
                let (mut event, mut end) = (false, true);
                third.ok(fmi3CompletedIntegratorStep(i, true, &mut event, &mut end));
                second.ok(fmi2CompletedIntegratorStep(c, 1, &mut 0, &mut 0));
                assert!(!end);
            }
            third.ok(fmi3EnterEventMode(i));
            third.update();
        }
    }
}

/// Integrates an instance for Model Exchange by Euler's method up to a time.
fn integrated(fmu: &Fmu3, states: &mut [f64], slope: &mut [f64], indicators: &mut [f64], steps: std::ops::Range<u32>) {
    let (i, n) = (fmu.instance, states.len());
    let (mut event, mut end) = (false, true);
    for step in steps {
        unsafe {
            fmu.ok(fmi3GetContinuousStateDerivatives(i, slope.as_mut_ptr(), n));
            states.iter_mut().zip(&*slope).for_each(|(state, slope)| *state += 1e-6 * slope);
            fmu.ok(fmi3SetTime(i, 1e-6 * f64::from(step + 1)));
            fmu.ok(fmi3SetContinuousStates(i, states.as_ptr(), n));
            fmu.ok(fmi3GetEventIndicators(i, indicators.as_mut_ptr(), indicators.len()));
            fmu.ok(fmi3CompletedIntegratorStep(i, true, &mut event, &mut end));
        }
        assert!(!event && !end);
    }
}

/// An instance for Model Exchange at its start, with the vectors that an integrator needs.
fn integrable(text: &str) -> (Fmu3, Vec<f64>, Vec<f64>, Vec<f64>) {
    let fmu = Fmu3::exchanged(text);
    fmu.start();
    fmu.update();
    let n = fmu.table.nominals().len();
    let (mut states, mut indicators) = (vec![0.0; n], 0);
    unsafe {
        fmu.ok(fmi3EnterContinuousTimeMode(fmu.instance));
        fmu.ok(fmi3GetContinuousStates(fmu.instance, states.as_mut_ptr(), n));
        fmu.ok(fmi3GetNumberOfEventIndicators(fmu.instance, &mut indicators));
    }
    (fmu, states, vec![0.0; n], vec![0.0; indicators])
}

/// F3-16. Model Exchange of FMI 3.0: steps of the importer's integrator allocate no memory; a run from a saved state, also from its bytes
/// in another instance, is bit-identical; so are eight instances in threads. The folding wing, and Goland's wing in a wind from below, with
/// the lag states of its strips.
#[test]
fn f316_model_exchange_allocates_nothing_rolls_back_and_runs_in_threads() {
    let goland = include_str!("../../examples/models/goland_wing.toml");
    for text in [WING, &goland.replacen("[0.0, -130.0, 0.0]", "[0.0, -130.0, 5.0]", 1)] {
        check_exchange(text);
    }
}

fn check_exchange(text: &str) {
    let (fmu, mut states, mut slope, mut indicators) = integrable(text);
    integrated(&fmu, &mut states, &mut slope, &mut indicators, 0..50);
    let before = allocations();
    integrated(&fmu, &mut states, &mut slope, &mut indicators, 50..550);
    assert_eq!(allocations() - before, 0, "allocations in 500 steps of the importer's");
    // values returned by one call for all variables are those returned one by one
    let rows = fmu.table.variables().iter().filter(|row| row.nominal.is_some());
    let names: Vec<String> = rows.map(|row| row.name.clone()).collect();
    fmu.ok(unsafe { fmi3GetContinuousStateDerivatives(fmu.instance, slope.as_mut_ptr(), slope.len()) });
    for (i, name) in names.iter().enumerate() {
        assert_eq!(fmu.get(name), [states[i]], "{name}");
        assert_eq!(fmu.get(&format!("der({name})")), [slope[i]], "{name}");
    }
    let (here, at) = (fmu.save(), states.clone());
    let bytes = fmu.serialize(here);
    integrated(&fmu, &mut states, &mut slope, &mut indicators, 550..1000);
    let (expected, end) = (fmu.bits(), states.clone());

    let (other, ..) = integrable(text);
    let mut handle = ptr::null_mut();
    fmu.ok(unsafe { fmi3SetFMUState(fmu.instance, here) });
    other.ok(unsafe { fmi3DeserializeFMUState(other.instance, bytes.as_ptr(), bytes.len(), &mut handle) });
    other.ok(unsafe { fmi3SetFMUState(other.instance, handle) });
    for again in [&fmu, &other] {
        let n = states.len();
        again.ok(unsafe { fmi3GetContinuousStates(again.instance, states.as_mut_ptr(), n) });
        assert_eq!(states, at);
        integrated(again, &mut states, &mut slope, &mut indicators, 550..1000);
        assert_eq!(states, end);
        assert_eq!(again.bits(), expected);
    }

    let whole = || {
        let (fmu, mut states, mut slope, mut indicators) = integrable(text);
        integrated(&fmu, &mut states, &mut slope, &mut indicators, 0..1000);
        fmu.bits()
    };
    std::thread::scope(|scope| {
        let running: Vec<_> = (0..8).map(|_| scope.spawn(whole)).collect();
        running.into_iter().for_each(|thread| assert_eq!(thread.join().expect("no panic"), expected));
    });
}

/// F3-09. After the first step no memory is allocated: in steps with events and updates, in getting and setting.
#[test]
fn f309_a_step_allocates_nothing() {
    let agreed = Agreed { event_mode: true, early_return: true, intermediate_update: false };
    let fmu = Fmu3::started(agreed);
    fmu.update();
    fmu.ok(unsafe { fmi3EnterStepMode(fmu.instance) });
    let [loads, tip, torque] =
        ["load.outer.force", "tip.acceleration", "fold.external_torque"].map(|name| fmu.reference(name));
    let (forces, mut values, mut time_s, mut events) = ([1e-3; 12], [0.0; 3], 0.0, 0);
    let mut step = |i: i32| unsafe {
        fmu.ok(fmi3SetFloat64(fmu.instance, &loads, 1, forces.as_ptr(), 12));
        fmu.ok(fmi3SetFloat64(fmu.instance, &torque, 1, &(1e-4 * f64::from(i)), 1));
        let answer = fmu.step(time_s, STEP_S);
        time_s = answer.last_s;
        if answer.event {
            events += 1;
            fmu.ok(fmi3EnterEventMode(fmu.instance));
            fmu.update();
            fmu.ok(fmi3EnterStepMode(fmu.instance));
        }
        fmu.ok(fmi3GetFloat64(fmu.instance, &tip, 1, values.as_mut_ptr(), 3));
    };
    step(0);
    let before = allocations();
    (1..200).for_each(&mut step);
    assert_eq!(allocations() - before, 0, "allocations in 199 steps through the latch");
    assert!(events > 0, "the latch must have closed on the way");
}

/// Phase of an instance, and its interface type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    Instantiated,
    Initialization,
    Event,
    Step,
    Continuous,
    Failed,
    Terminated,
}

impl Phase {
    /// The name of the phase in messages.
    pub fn phrase(self) -> &'static str {
        match self {
            Self::Instantiated => "before fmi3EnterInitializationMode",
            Self::Initialization => "in Initialization Mode",
            Self::Event => "in Event Mode",
            Self::Step => "in Step Mode",
            Self::Continuous => "in Continuous-Time Mode",
            Self::Failed => "after a failed step",
            Self::Terminated => "after fmi3Terminate",
        }
    }
}

/// Phases of co-simulation with Event Mode, and of Model Exchange.
pub const OF_STEPS: [Phase; 6] =
    [Phase::Instantiated, Phase::Initialization, Phase::Event, Phase::Step, Phase::Failed, Phase::Terminated];
pub const OF_EXCHANGE: [Phase; 5] =
    [Phase::Instantiated, Phase::Initialization, Phase::Event, Phase::Continuous, Phase::Terminated];

/// FMI 3.0.2, sections 2.3, 3.2.1 and 4.2.1: which functions are legal, in the order of [`OF_STEPS`] and of [`OF_EXCHANGE`]. For every
/// getter and setter the row of `fmi3GetFloat64` or `fmi3SetFloat64` applies. After a failed step the calls of FMI 2.0 are legal.
pub const TABLE: [(&str, &str, &str); 35] = [
    ("fmi3SetDebugLogging", "x x x x x x", "x x x x x"),
    ("fmi3EnterInitializationMode", "x - - - - -", "x - - - -"),
    ("fmi3ExitInitializationMode", "- x - - - -", "- x - - -"),
    ("fmi3EnterEventMode", "- - - x - -", "- - - x -"),
    ("fmi3Terminate", "- - x x - -", "- - x x -"),
    ("fmi3Reset", "x x x x x x", "x x x x x"),
    ("fmi3GetFloat64", "- x x x x x", "- x x x x"),
    ("fmi3SetFloat64", "x x x x - -", "x x x x -"),
    ("fmi3GetNumberOfVariableDependencies", "- - - - - -", "- - - - -"),
    ("fmi3GetFMUState", "x x x x x x", "x x x x x"),
    ("fmi3SetFMUState", "x x x x x x", "x x x x x"),
    ("fmi3FreeFMUState", "x x x x x x", "x x x x x"),
    ("fmi3SerializedFMUStateSize", "x x x x x x", "x x x x x"),
    ("fmi3SerializeFMUState", "x x x x x x", "x x x x x"),
    ("fmi3DeserializeFMUState", "x x x x x x", "x x x x x"),
    ("fmi3GetDirectionalDerivative", "- x x x x x", "- x x x x"),
    ("fmi3GetAdjointDerivative", "- x x x x x", "- x x x x"),
    ("fmi3EnterConfigurationMode", "- - - - - -", "- - - - -"),
    ("fmi3EvaluateDiscreteStates", "- - - - - -", "- - - - -"),
    ("fmi3UpdateDiscreteStates", "- - x - - -", "- - x - -"),
    ("fmi3EnterContinuousTimeMode", "- - - - - -", "- - x - -"),
    ("fmi3CompletedIntegratorStep", "- - - - - -", "- - - x -"),
    ("fmi3SetTime", "- - - - - -", "- - x x -"),
    ("fmi3SetContinuousStates", "- - - - - -", "- - - x -"),
    ("fmi3GetContinuousStateDerivatives", "- - - - - -", "- x x x x"),
    ("fmi3GetEventIndicators", "- - - - - -", "- x x x x"),
    ("fmi3GetContinuousStates", "- - - - - -", "- x x x x"),
    ("fmi3GetNominalsOfContinuousStates", "- - - - - -", "- x x x x"),
    ("fmi3GetNumberOfEventIndicators", "- - - - - -", "x x x x x"),
    ("fmi3GetNumberOfContinuousStates", "- - - - - -", "x x x x x"),
    ("fmi3EnterStepMode", "- - x - - -", "- - - - -"),
    ("fmi3GetOutputDerivatives", "- - x x x x", "- - - - -"),
    ("fmi3DoStep", "- - - x - -", "- - - - -"),
    ("fmi3ActivateModelPartition", "- - - - - -", "- - - - -"),
    ("fmi3GetIntervalDecimal", "- - - - - -", "- - - - -"),
];

/// An instance in a phase, and its time.
fn in_phase(exchange: bool, phase: Phase) -> (Fmu3, f64) {
    let fmu = if exchange { Fmu3::exchanged(WING) } else { Fmu3::new(WING, EVENTS) };
    let i = fmu.instance;
    unsafe {
        if phase != Phase::Instantiated {
            fmu.ok(fmi3EnterInitializationMode(i, false, 0.0, 0.0, false, 0.0));
        }
        if matches!(phase, Phase::Instantiated | Phase::Initialization) {
            return (fmu, 0.0);
        }
        fmu.ok(fmi3ExitInitializationMode(i));
        if phase == Phase::Event {
            return (fmu, 0.0);
        }
        fmu.update();
        if exchange {
            fmu.ok(fmi3EnterContinuousTimeMode(i));
        } else {
            fmu.ok(fmi3EnterStepMode(i));
            fmu.step(0.0, STEP_S);
        }
        if phase == Phase::Failed {
            let mut force = [0.0; 12];
            force[11] = 1e200;
            fmu.set("load.outer.force", &force);
            assert_eq!(fmu.try_step(STEP_S, STEP_S).status, 3);
            fmu.told();
        }
        if phase == Phase::Terminated {
            fmu.ok(fmi3Terminate(i));
        }
    }
    (fmu, if exchange { 0.0 } else { STEP_S })
}

/// Calls a function with arguments that are valid wherever the call is legal.
fn call(fmu: &Fmu3, name: &str, time_s: f64) -> u32 {
    let i = fmu.instance;
    let mut state = fmu.save();
    let bytes = fmu.serialize(state);
    let nominals = fmu.table.nominals().len();
    let (mut values, mut number, mut flag) = (vec![1e-3; nominals], 0, false);
    let [angle, torque, tip] =
        ["fold.angle", "fold.external_torque", "tip.acceleration"].map(|name| fmu.reference(name));
    let mut three = [0.0; 3];
    unsafe {
        match name {
            "fmi3SetDebugLogging" => fmi3SetDebugLogging(i, false, 1, &c"logEvents".as_ptr()),
            "fmi3EnterInitializationMode" => fmi3EnterInitializationMode(i, true, 1e-5, 0.0, true, 1.0),
            "fmi3ExitInitializationMode" => fmi3ExitInitializationMode(i),
            "fmi3EnterEventMode" => fmi3EnterEventMode(i),
            "fmi3Terminate" => fmi3Terminate(i),
            "fmi3Reset" => fmi3Reset(i),
            "fmi3GetFloat64" => fmi3GetFloat64(i, &tip, 1, three.as_mut_ptr(), 3),
            "fmi3SetFloat64" => fmi3SetFloat64(i, &torque, 1, &0.01, 1),
            "fmi3GetNumberOfVariableDependencies" => fmi3GetNumberOfVariableDependencies(i, 0, &mut number),
            "fmi3GetFMUState" => fmi3GetFMUState(i, &mut state),
            "fmi3SetFMUState" => fmi3SetFMUState(i, state),
            "fmi3FreeFMUState" => fmi3FreeFMUState(i, &mut state),
            "fmi3SerializedFMUStateSize" => fmi3SerializedFMUStateSize(i, state, &mut number),
            "fmi3SerializeFMUState" => {
                let mut room = bytes.clone();
                fmi3SerializeFMUState(i, state, room.as_mut_ptr(), room.len())
            }
            "fmi3DeserializeFMUState" => fmi3DeserializeFMUState(i, bytes.as_ptr(), bytes.len(), &mut ptr::null_mut()),
            "fmi3GetDirectionalDerivative" => {
                fmi3GetDirectionalDerivative(i, &tip, 1, &torque, 1, &1.0, 1, three.as_mut_ptr(), 3)
            }
            "fmi3GetAdjointDerivative" => {
                fmi3GetAdjointDerivative(i, &tip, 1, &torque, 1, three.as_ptr(), 3, &mut 0.0, 1)
            }
            "fmi3EnterConfigurationMode" => fmi3EnterConfigurationMode(i),
            "fmi3EvaluateDiscreteStates" => fmi3EvaluateDiscreteStates(i),
            "fmi3UpdateDiscreteStates" => {
                fmi3UpdateDiscreteStates(i, &mut flag, &mut false, &mut false, &mut false, &mut false, &mut 0.0)
            }
            "fmi3EnterContinuousTimeMode" => fmi3EnterContinuousTimeMode(i),
            "fmi3CompletedIntegratorStep" => fmi3CompletedIntegratorStep(i, true, &mut flag, &mut false),
            "fmi3SetTime" => fmi3SetTime(i, time_s),
            "fmi3SetContinuousStates" => fmi3SetContinuousStates(i, values.as_ptr(), nominals),
            "fmi3GetContinuousStateDerivatives" => fmi3GetContinuousStateDerivatives(i, values.as_mut_ptr(), nominals),
            "fmi3GetEventIndicators" => {
                let indicators = fmu.table.arrays().last().expect("some").rows.len();
                fmi3GetEventIndicators(i, vec![0.0; indicators].as_mut_ptr(), indicators)
            }
            "fmi3GetContinuousStates" => fmi3GetContinuousStates(i, values.as_mut_ptr(), nominals),
            "fmi3GetNominalsOfContinuousStates" => fmi3GetNominalsOfContinuousStates(i, values.as_mut_ptr(), nominals),
            "fmi3GetNumberOfEventIndicators" => fmi3GetNumberOfEventIndicators(i, &mut number),
            "fmi3GetNumberOfContinuousStates" => fmi3GetNumberOfContinuousStates(i, &mut number),
            "fmi3EnterStepMode" => fmi3EnterStepMode(i),
            "fmi3GetOutputDerivatives" => fmi3GetOutputDerivatives(i, &angle, 1, &1, &mut 0.0, 1),
            "fmi3DoStep" => fmi3DoStep(i, time_s, STEP_S, true, &mut flag, &mut false, &mut false, &mut 0.0),
            "fmi3ActivateModelPartition" => fmi3ActivateModelPartition(i, 0, 0.0),
            "fmi3GetIntervalDecimal" => fmi3GetIntervalDecimal(i, ptr::null(), 0, ptr::null_mut(), ptr::null_mut()),
            other => panic!("no call for {other}"),
        }
    }
}

/// F3-10. Each of 35 functions in each phase of co-simulation with Event Mode and of Model Exchange, against the table of the standard.
/// Illegal: an error, one message that names function and phase, and a bit-identical state. Legal: no message.
#[test]
fn f310_every_call_in_every_phase() {
    let mut cells = [0, 0];
    for exchange in [false, true] {
        let phases: &[Phase] = if exchange { &OF_EXCHANGE } else { &OF_STEPS };
        for (column, &phase) in phases.iter().enumerate() {
            for (name, steps, exchanged) in TABLE {
                let (fmu, time_s) = in_phase(exchange, phase);
                let before = fmu.present();
                let status = call(&fmu, name, time_s);
                let legal = if exchange { exchanged } else { steps }.split(' ').nth(column) == Some("x");
                cells[usize::from(legal)] += 1;
                let messages: Vec<_> = fmu.environment.messages.borrow_mut().drain(..).collect();
                let cell = format!("{name} {}, Model Exchange {exchange}: {messages:?}", phase.phrase());
                assert_eq!(status, if legal { 0 } else { 3 }, "{cell}");
                assert_eq!(messages.len(), usize::from(!legal), "{cell}");
                if !legal {
                    let head = format!("{name}: not legal {}", phase.phrase());
                    assert!(messages[0].2.starts_with(&head), "{cell}");
                    assert!(fmu.present() == before, "{cell} changed the state");
                }
            }
        }
    }
    println!("FMI 3.0: {} cells, {} legal, {} refused", cells[0] + cells[1], cells[1], cells[0]);
}

/// F3-11. Null arguments are rejected by every function, without any effect.
#[test]
fn f311_no_instance_and_null_arguments() {
    let fmu = Fmu3::started(Agreed::default());
    let i = fmu.instance;
    let before = fmu.present();
    unsafe {
        assert_eq!(fmi3Reset(ptr::null_mut()), 3);
        assert_eq!(fmi3GetFloat64(i, ptr::null(), 2, ptr::null_mut(), 2), 3);
        assert!(fmu.told().contains("argument valueReferences is null"));
        assert_eq!(fmi3GetFloat64(i, &0, 1, ptr::null_mut(), 1), 3);
        assert!(fmu.told().contains("argument values is null"));
        let null = ptr::null_mut::<bool>();
        assert_eq!(fmi3DoStep(i, 0.0, STEP_S, true, null, null, null, ptr::null_mut()), 3);
        assert!(fmu.told().contains("argument eventHandlingNeeded is null"));
        assert_eq!(fmi3GetFMUState(i, ptr::null_mut()), 3);
        assert!(fmu.told().contains("argument FMUState is null"));
        fmi3FreeInstance(ptr::null_mut());
        let none = fmi3InstantiateScheduledExecution(
            c"wing".as_ptr(),
            ptr::null(),
            ptr::null(),
            false,
            false,
            ptr::null_mut(),
            None,
            None,
            None,
            None,
        );
        assert!(none.is_null());
    }
    assert!(fmu.present() == before);
}

/// F3-13. Instances of both versions in eight threads are bit-identical to single instances.
#[test]
fn f313_instances_of_both_versions_in_threads() {
    let second = || {
        let fmu = Fmu::stepping();
        (0..40).for_each(|i| fmu.step(STEP_S * f64::from(i), STEP_S));
        fmu.bits()
    };
    let third = || {
        let fmu = Fmu3::started(Agreed { intermediate_update: true, ..Agreed::default() });
        (0..40).for_each(|i| {
            fmu.step(STEP_S * f64::from(i), STEP_S);
        });
        fmu.bits()
    };
    let alone = second();
    assert_eq!(third(), alone);
    std::thread::scope(|scope| {
        let running: Vec<_> =
            (0..8).map(|i| if i % 2 == 0 { scope.spawn(second) } else { scope.spawn(third) }).collect();
        running.into_iter().for_each(|thread| assert_eq!(thread.join().expect("no panic"), alone));
    });
}
