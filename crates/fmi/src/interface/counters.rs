//! Locals: counters of the time integration and, in real-time mode, durations of its steps.

use crate::interface::binding::{Binding, Counter, Duration};
use crate::interface::table::Table;
use crate::interface::{Causality, Value, Variability};
use foldwing_engine::machine::Machine;

/// Name, counter and meaning.
const COUNTERS: &[(&str, Counter, &str)] = &[
    ("steps", Counter::Steps, "accepted internal steps"),
    ("rejections", Counter::Rejections, "internal steps rejected by the error estimate"),
    ("failures", Counter::Failures, "internal steps abandoned by the Newton iteration"),
    ("iterations", Counter::Iterations, "Newton iterations"),
    ("factorizations", Counter::Factorizations, "factorisations of the equations of motion"),
    ("events", Counter::Events, "events: releases, latch closings and openings"),
];

/// Those that only real-time mode has.
const REAL_TIME_COUNTERS: &[(&str, Counter, &str)] = &[
    ("unconverged", Counter::Unconverged, "stages accepted without convergence"),
    ("iterations_max", Counter::LargestIterations, "maximum number of Newton iterations in one stage"),
];

/// Name, duration and meaning of what only real-time mode has.
const DURATIONS: &[(&str, Duration, &str)] = &[
    ("step_time", Duration::Last, "wall time of the last communication step, without the reading of outputs"),
    (
        "step_time_median",
        Duration::Median,
        "median wall time of the communication steps since initialisation, within 4.5 %",
    ),
    ("step_time_max", Duration::Slowest, "wall time of the slowest communication step since initialisation"),
];

/// Adds the rows.
pub(super) fn locals(table: &mut Table, machine: &Machine) {
    let in_real_time = machine.solver.most_iterations.is_some();
    let counters = if in_real_time { REAL_TIME_COUNTERS } else { &[] };
    for &(name, counter, meaning) in COUNTERS.iter().chain(counters) {
        let text = (format!("solver.{name}"), None, None, format!("{meaning} since initialisation"));
        table.push(Binding::Local(counter), Causality::Local, Variability::Discrete, Value::Integer(0), text);
    }
    for &(name, duration, meaning) in if in_real_time { DURATIONS } else { &[] } {
        let text = (format!("solver.{name}"), Some("Time"), None, meaning.to_owned());
        table.push(Binding::Duration(duration), Causality::Local, Variability::Discrete, Value::Real(0.0), text);
    }
}
