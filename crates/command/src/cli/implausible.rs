//! Warnings about implausible models or runs, based on computed values: static deflection, latches out of reach, run times far from the
//! natural periods.

use crate::cli::assessment::{Assessment, Effort, Reach, efforts, frequencies_hz, short};
use foldwing_engine::machine::{Body, Machine};
use foldwing_engine::plant::Plant;
use foldwing_study::warnings;

/// Minimum number of output rows per period at which an oscillation is visible.
const ROWS_PER_PERIOD: f64 = 4.0;
/// Ratio of static deflection to wing size above which a warning is given.
const MAXIMUM_DEFLECTION: f64 = 0.5;
/// Fraction of a period below which a run shows no motion.
const MINIMUM_SWING: f64 = 0.01;
/// Maximum number of elastic coordinates for which modes are computed after a run; the cost grows with their third power. `check`
/// computes them at any size.
const MAXIMUM_ELASTIC_FREEDOMS: usize = 320;

/// Times of a run, and the names of their settings.
pub(super) struct Times {
    pub start_s: f64,
    pub stop_s: f64,
    pub step_s: f64,
    /// Name of the step in messages.
    pub step_name: &'static str,
    /// Name of the end in messages.
    pub stop_name: &'static str,
}

/// Returns the warnings about a model with its `[simulation]`.
pub(super) fn model(answer: &Assessment, machine: &Machine) -> Vec<String> {
    let mut warnings = Vec::new();
    if let Some(deflection) = answer
        .static_deflection
        .as_ref()
        .filter(|deflection| deflection.deflection_m > MAXIMUM_DEFLECTION * deflection.length_m)
    {
        warnings.push(format!(
            "the tip of {} deflects by {:.4} m of {:.4} m under gravity: check moduli (Pa), lengths (m) and masses (kg)",
            deflection.body, deflection.deflection_m, deflection.length_m
        ));
    }
    let judged = |joint: &&Effort| machine.air.is_none() || joint.reaches == Reach::NotJudged;
    warnings.extend(answer.joints.iter().filter(judged).filter_map(latch));
    warnings.extend(warnings::undeformed(machine).iter().map(ToString::to_string));
    let run = &machine.experiment;
    let (start_s, stop_s, step_s) = (run.start_time_s, run.stop_time_s, run.step_s);
    let written = Times { start_s, stop_s, step_s, step_name: "[simulation] step_s =", stop_name: "[simulation]" };
    warnings.extend(times(&answer.frequencies_hz, &written));
    warnings
}

/// Warnings about a finished run: latches that stayed open and could not close, times far from the natural periods. `as_written` means
/// that no input or setting changed the drive of the joints from the model file.
pub(super) fn run(plant: &Plant, as_written: bool, run: &Times) -> Vec<String> {
    let machine = plant.machine();
    let latches = plant.outputs().latches();
    let open = |row: usize| {
        as_written && machine.air.is_none() && latches[row].count.get() == 0 && !latches[row].closed.is_on()
    };
    let has_latch = |row: usize| machine.one_freedoms().nth(row).is_some_and(|(_, joint)| joint.latch.is_some());
    let mut warnings: Vec<String> =
        efforts(machine, |row| open(row) && has_latch(row)).iter().filter_map(latch).collect();
    if machine.bodies.iter().map(Body::elastic_freedoms).sum::<usize>() <= MAXIMUM_ELASTIC_FREEDOMS {
        warnings.extend(times(&frequencies_hz(machine), run));
    }
    warnings
}

/// Warning if a joint does not reach its latch. With aerodynamics, whose loads may drive the joint further, only if its motor drives it
/// away from the latch.
fn latch(joint: &Effort) -> Option<String> {
    let (end, unit, name) = (short(joint.end), joint.travel.shown_unit(), &joint.name);
    match joint.reaches {
        _ if !joint.has_latch => None,
        Reach::TurnsAway => Some(format!(
            "joint {name}: the latch at {end} {unit} is never reached without a command: motor, spring and gravity \
             drive the joint away from it; move the latch to the other side of the start, or command the joint to it"
        )),
        Reach::StallsAt(place) => Some(format!(
            "joint {name}: in slow motion the joint stops at {} {unit}, before the latch at {end} {unit}: it reaches \
             the latch only by its momentum",
            short(place)
        )),
        Reach::NotJudged if joint.drive[1] < 0.0 => Some(format!(
            "joint {name}: motor and spring pull the joint away from the latch at {end} {unit} over the whole range; \
             only wind or momentum can close the latch; a positive constant_torque_N_m or constant_force_N acts \
             towards negative positions: is its sign as intended?"
        )),
        Reach::Arrives | Reach::Stands | Reach::NotJudged => None,
    }
}

/// Warnings if the rows of a run do not resolve the wing's slowest mode, or if the run is much shorter than its period.
fn times(frequencies_hz: &[f64], run: &Times) -> Vec<String> {
    let mut warnings = Vec::new();
    let Some(hz) = frequencies_hz.iter().copied().find(|hz| *hz > 0.0) else { return warnings };
    let lasts_s = run.stop_s - run.start_s;
    if run.step_s * hz * ROWS_PER_PERIOD > 1.0 {
        warnings.push(format!(
            "{} {} s is long for a wing that oscillates at {} Hz: a period has {:.1} rows; use {:.1e} or less to resolve it",
            run.step_name,
            run.step_s,
            short(hz),
            1.0 / (run.step_s * hz),
            0.05 / hz
        ));
    }
    if lasts_s * hz < MINIMUM_SWING {
        warnings.push(format!(
            "{} lasts {lasts_s} s, a hundredth of the longest period ({} Hz) or less, so the motion is hardly \
             simulated; times are in seconds",
            run.stop_name,
            short(hz)
        ));
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The step proposed in the warning gives twenty rows per period and no warning; the other numbers in the text are those of the run.
    #[test]
    fn the_step_that_is_proposed_passes() {
        let run = |step_s: f64| Times { start_s: 0.0, stop_s: 1e3, step_s, step_name: "step", stop_name: "stop" };
        for (hz, step_s) in [(2.0, 1.0), (5.0, 0.15), (0.3, 9.0)] {
            let of = |step_s: f64| times(&[0.0, hz, 3.0 * hz], &run(step_s));
            let warnings = of(step_s);
            assert_eq!(warnings.len(), 1, "{warnings:?}");
            let proposed: f64 = warnings[0]
                .split("; use ")
                .nth(1)
                .and_then(|rest| rest.split(' ').next()?.parse().ok())
                .expect("a step");
            assert_eq!(of(proposed), [""; 0], "{warnings:?}");
            // the proposed step is rounded to two digits
            let rows = 1.0 / (proposed * hz);
            assert!(rows > 18.0 && rows < 22.0, "{rows} rows of a swing: {warnings:?}");
            let due = format!(
                "step {step_s} s is long for a wing that oscillates at {hz} Hz: a period has {:.1} rows",
                1.0 / (step_s * hz)
            );
            assert!(warnings[0].starts_with(&due), "{warnings:?}");
        }
    }
}
