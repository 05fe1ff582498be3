//! State of failures: their triggers, and the inputs, parameters and forces that they replace or add on joints.

use crate::force::Force;
use crate::force::friction::SlippingBrake;
use crate::force::memory::{JointMemory, Told};
use crate::force::watch::Watch;
use crate::machine::Machine;
use crate::machine::failure::{Effect, Failure};
use crate::signal::Inputs;
use serde::{Deserialize, Serialize};

/// State of a failure.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct FailureMemory {
    /// Time of its trigger in s.
    pub brought_s: Option<f64>,
    /// Time in s at which the failure occurred.
    pub failed_s: Option<f64>,
}

impl FailureMemory {
    /// Whether the failure has occurred.
    pub fn has_failed(&self) -> bool {
        self.failed_s.is_some()
    }
}

/// Whether some failure reduces the stiffness of a body.
pub(crate) fn weaken_bodies(machine: &Machine) -> bool {
    machine.failures.iter().any(|failure| matches!(failure.effect, Effect::StiffnessLoss { .. }))
}

/// Forces added to a joint for its failures: brakes, which are initially off, and monitored bounds.
pub(crate) fn forces_on(machine: &Machine, body: usize) -> impl Iterator<Item = Force> {
    let brakes = machine.failures.iter().enumerate().filter_map(move |(index, failure)| match failure.effect {
        Effect::BrakeApplied { body: on, brake } if on == body => {
            Some(Force::Slipping(SlippingBrake::off(brake, index)))
        }
        Effect::MotorLoss { .. }
        | Effect::MotorJam { .. }
        | Effect::MotorRunaway { .. }
        | Effect::LatchBreak { .. }
        | Effect::LatchNoCapture { .. }
        | Effect::LockRelease { .. }
        | Effect::SpringBreak { .. }
        | Effect::LoopBreak { .. }
        | Effect::StiffnessLoss { .. }
        | Effect::BrakeApplied { .. } => None,
    });
    let bounds = machine.failures.iter().enumerate().filter_map(move |(failure, described)| {
        described.when.filter(|bound| bound.body == body).map(|bound| (failure, bound))
    });
    let watches = bounds.zip(0..).map(|((failure, bound), number)| Force::Watch(Watch { bound, number, failure }));
    brakes.chain(watches)
}

/// Triggers the failures that are due at the start, by their inputs or by a time that has passed. Triggers by the motion follow when the
/// start state is known.
pub(crate) fn begin(failures: &[Failure], inputs: &Inputs, time_s: f64, memories: &mut [FailureMemory]) {
    let on = |index: usize| inputs.failures()[index].is_on();
    bring_about(failures, memories, time_s, on, |_| false);
}

/// Triggers the failures that are due at a time; returns whether one occurs.
pub(super) fn bring_about(
    failures: &[Failure],
    memories: &mut [FailureMemory],
    time_s: f64,
    is_on: impl Fn(usize) -> bool,
    has_tripped: impl Fn(usize) -> bool,
) -> bool {
    let mut any = false;
    // a failure may trigger another at the same time
    for _ in 0..failures.len() {
        let mut more = false;
        for (index, failure) in failures.iter().enumerate() {
            if memories[index].has_failed() {
                continue;
            }
            if memories[index].brought_s.is_none() {
                let at_s = failure.at_time_s.filter(|&at_s| at_s <= time_s).map(|_| time_s);
                let after_s = failure.after.and_then(|other| memories[other].failed_s);
                let now_s = (is_on(index) || has_tripped(index)).then_some(time_s);
                memories[index].brought_s = [at_s, after_s, now_s].into_iter().flatten().reduce(f64::min);
            }
            if memories[index].brought_s.is_some_and(|brought_s| brought_s + failure.delay_s <= time_s) {
                memories[index].failed_s = Some(time_s);
                more = true;
            }
        }
        any |= more;
        if !more {
            break;
        }
    }
    any
}

/// Time in s of the next failure known in advance.
pub(super) fn next_s(failures: &[Failure], memories: &[FailureMemory]) -> f64 {
    let waiting = failures.iter().zip(memories).filter(|(_, memory)| !memory.has_failed());
    let due = waiting.filter_map(|(failure, memory)| match (memory.brought_s, failure.at_time_s) {
        (Some(brought_s), _) => Some(brought_s + failure.delay_s),
        // the trigger is at this time, and the failure time is known from then on
        (None, at_s) => at_s,
    });
    due.fold(f64::INFINITY, f64::min)
}

/// Replaces inputs and parameters of the forces on the joint of `body` according to the failures that have occurred.
pub(crate) fn tell(
    failures: &[Failure],
    memories: &[FailureMemory],
    body: usize,
    memory: &JointMemory,
    told: &mut Told,
) {
    let failed = failures.iter().zip(memories).filter(|(_, memory)| memory.has_failed());
    for (failure, _) in failed.filter(|(failure, _)| failure.effect.joint_of() == Some(body)) {
        match failure.effect {
            Effect::MotorRunaway { to_rad, rate_rad_s, .. } => {
                (told.command_rad, told.command_rate_rad_s) = (to_rad, 0.0);
                told.rate_limit_rad_s = rate_rad_s;
            }
            Effect::LatchBreak { .. } => told.latch_enable = false,
            Effect::LatchNoCapture { .. } => told.latch_enable &= memory.latch.closed,
            Effect::LockRelease { .. } => told.release = true,
            Effect::MotorLoss { .. }
            | Effect::MotorJam { .. }
            | Effect::SpringBreak { .. }
            | Effect::LoopBreak { .. }
            | Effect::StiffnessLoss { .. }
            | Effect::BrakeApplied { .. } => {}
        }
    }
    // a jammed motor holds the joint, whether or not it is released
    let jams = |failure: &Failure| matches!(failure.effect, Effect::MotorJam { body: on } if on == body);
    if failures.iter().zip(memories).any(|(failure, memory)| memory.has_failed() && jams(failure)) {
        told.release = false;
    }
}

/// Initial state of a joint, with the failures that exist from the start.
pub(crate) fn begin_joint(
    failures: &[Failure],
    memories: &[FailureMemory],
    (body, latched): (usize, bool),
    told: &mut Told,
    memory: &mut JointMemory,
) {
    // a latch that fails to catch is open unless the model describes it as initially closed
    let catches = |failure: &Failure| !matches!(failure.effect, Effect::LatchNoCapture { body: on } if on == body);
    let fails = |(failure, memory): (&Failure, &FailureMemory)| memory.has_failed() && !catches(failure);
    if !latched && failures.iter().zip(memories).any(fails) {
        memory.latch.closed = false;
    }
    tell(failures, memories, body, memory, told);
    memory.released = told.release;
    memory.latch.enabled = told.latch_enable;
    memory.latch.closed &= told.latch_enable;
    (memory.slew.target_rad, memory.slew.rate_limit_rad_s) = (told.command_rad, told.rate_limit_rad_s);
}
