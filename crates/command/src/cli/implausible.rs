//! What a model or a run of it probably does not mean, by what it computes: sag, latches out of reach, times far from the motion.

use crate::cli::assessment::{Assessment, Effort, Reach, efforts, frequencies_hz, short};
use foldwing_engine::machine::{Body, Machine};
use foldwing_engine::plant::Plant;
use foldwing_study::doubts::flow;

/// Rows that a swing should have to be recognised in them.
const ROWS_PER_PERIOD: f64 = 4.0;
/// Share of the wing's extent beyond which a sag is worth a warning.
const MAXIMUM_SAG: f64 = 0.5;
/// Share of a swing below which nothing moves in a run.
const MINIMUM_SWING: f64 = 0.01;
/// Elastic coordinates of the machine up to which a run looks for its modes, for the sake of time: their cost grows with
/// the third power, and `check` finds them at any size.
const MAXIMUM_ELASTIC_FREEDOMS: usize = 320;

/// Times of a run, and where they are written.
pub(super) struct Times {
    pub start_s: f64,
    pub stop_s: f64,
    pub step_s: f64,
    /// By what words a user knows the step.
    pub step_name: &'static str,
    /// By what words a user knows the end.
    pub stop_name: &'static str,
}

/// Warnings about a model with its default experiment.
pub(super) fn model(answer: &Assessment, machine: &Machine) -> Vec<String> {
    let mut warnings = Vec::new();
    if let Some(sag) = answer.sag.as_ref().filter(|sag| sag.way_m > MAXIMUM_SAG * sag.extent_m) {
        warnings.push(format!(
            "the tip of {} sags by {:.4} m of {:.4} m under gravity: are moduli (Pa), lengths (m) and masses (kg) meant so?",
            sag.body, sag.way_m, sag.extent_m
        ));
    }
    if machine.air.is_none() {
        warnings.extend(answer.joints.iter().filter_map(latch));
    }
    warnings.extend(flow(machine).map(|doubt| doubt.to_string()));
    let run = &machine.experiment;
    let (start_s, stop_s, step_s) = (run.start_time_s, run.stop_time_s, run.step_s);
    let written = Times { start_s, stop_s, step_s, step_name: "[simulation] step_s =", stop_name: "[simulation]" };
    warnings.extend(times(&answer.frequencies_hz, &written));
    warnings
}

/// Warnings about a run that has ended: latches that stayed open and could not close, times far from the motion. `as_written`: no
/// input or setting drove the joints otherwise than the model file says.
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

/// Whether a joint reaches its latch. Air may carry it on where nothing else does: not for machines with air.
fn latch(joint: &Effort) -> Option<String> {
    let (end, unit, name) = (short(joint.end), joint.travel.shown_unit(), &joint.name);
    match joint.reaches {
        _ if !joint.has_latch => None,
        Reach::TurnsAway => Some(format!(
            "joint {name}: the latch at {end} {unit} never closes by itself: motor, spring and gravity drive the joint the other \
             way from its start; move the latch to the other side of the start, or command it there"
        )),
        Reach::StallsAt(place) => Some(format!(
            "joint {name}: moving slowly it stalls at {} {unit}, before the latch at {end} {unit}: only momentum carries it on",
            short(place)
        )),
        Reach::Arrives | Reach::Stands | Reach::NotJudged => None,
    }
}

/// Whether the rows of a run show the wing's slowest swing, and whether it has time for one.
fn times(frequencies_hz: &[f64], run: &Times) -> Vec<String> {
    let mut warnings = Vec::new();
    let Some(hz) = frequencies_hz.iter().copied().find(|hz| *hz > 0.0) else { return warnings };
    let lasts_s = run.stop_s - run.start_s;
    if run.step_s * hz * ROWS_PER_PERIOD > 1.0 {
        warnings.push(format!(
            "{} {} s is long for a wing that swings with {} Hz: a swing has {:.1} rows; write {:.1e} or less to see it",
            run.step_name,
            run.step_s,
            short(hz),
            1.0 / (run.step_s * hz),
            0.05 / hz
        ));
    }
    if lasts_s * hz < MINIMUM_SWING {
        warnings.push(format!(
            "{} lasts {lasts_s} s, a hundredth of the slowest swing ({} Hz) or less: nothing moves in it; seconds are meant",
            run.stop_name,
            short(hz)
        ));
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The step that the warning proposes gives a swing twenty rows, for which there is no warning; its other numbers are those of the run.
    #[test]
    fn the_step_that_is_proposed_passes() {
        let run = |step_s: f64| Times { start_s: 0.0, stop_s: 1e3, step_s, step_name: "step", stop_name: "stop" };
        for (hz, step_s) in [(2.0, 1.0), (5.0, 0.15), (0.3, 9.0)] {
            let of = |step_s: f64| times(&[0.0, hz, 3.0 * hz], &run(step_s));
            let warnings = of(step_s);
            assert_eq!(warnings.len(), 1, "{warnings:?}");
            let proposed: f64 = warnings[0]
                .split("write ")
                .nth(1)
                .and_then(|rest| rest.split(' ').next()?.parse().ok())
                .expect("a step");
            assert_eq!(of(proposed), [""; 0], "{warnings:?}");
            // rounded to two digits
            let rows = 1.0 / (proposed * hz);
            assert!(rows > 18.0 && rows < 22.0, "{rows} rows of a swing: {warnings:?}");
            let due = format!(
                "step {step_s} s is long for a wing that swings with {hz} Hz: a swing has {:.1} rows",
                1.0 / (step_s * hz)
            );
            assert!(warnings[0].starts_with(&due), "{warnings:?}");
        }
    }
}
