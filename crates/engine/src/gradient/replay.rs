//! Slews and failures of a neighbouring machine in the steps of a tape, eq. (X34): their times and angles follow from the parameters, not
//! from the motion.

use crate::force::drive::Slew;
use crate::force::memory::Told;
use crate::gradient::inputs::Offset;
use crate::gradient::tape::{Step, Tape};
use crate::machine::Machine;
use crate::system::System;
use crate::system::failure_memory::{self, FailureMemory};
use crate::system::state::State;

/// Property that changes where a failure has no time of its own in a neighbouring machine.
const TWO_TRIGGERS: &str = "which of two triggers of a failure comes first";

/// States of slews and failures between their changes.
#[derive(Debug, Clone)]
pub(super) struct Replay {
    episodes: Vec<Episode>,
}

#[derive(Debug, Clone)]
struct Episode {
    slews: Vec<Slew>,
    failures: Vec<FailureMemory>,
}

impl Replay {
    /// The states of an initialised machine beside that of the tape, `own`.
    ///
    /// # Errors
    /// The property that a change of the parameter would change, in words.
    pub fn of(system: &mut System, own: &Machine, tape: &Tape, offset: Option<Offset>) -> Result<Self, &'static str> {
        let mut episodes: Vec<Episode> = Vec::new();
        let mut before: Option<&Step> = None;
        for step in &tape.steps {
            if step.episode >= episodes.len() {
                let (slews, failures) = match episodes.last() {
                    Some(last) => (last.slews.clone(), last.failures.clone()),
                    None => {
                        let slews = system.state.joints.iter().map(|joint| joint.slew).collect();
                        (slews, vec![FailureMemory::default(); step.failures.len()])
                    }
                };
                let mut episode = Episode { slews, failures };
                episode.fail((&system.machine, own), (before, step))?;
                if !tape.inputs.columns().is_empty() {
                    tape.inputs.write_present(step.piece, offset, &mut system.state);
                }
                episode.slew(system, (before, step));
                episodes.push(episode);
            }
            before = Some(step);
        }
        Ok(Self { episodes })
    }

    /// Puts slews and failures into their states in a step.
    pub fn impose(&self, step: &Step, state: &mut State) {
        let Some(Episode { slews, failures }) = self.episodes.get(step.episode) else { return };
        state.joints.iter_mut().zip(slews).for_each(|(joint, slew)| joint.slew = *slew);
        state.failures.clone_from(failures);
    }
}

impl Episode {
    /// Times of the failures that are triggered or occur at the start of a step.
    fn fail(
        &mut self,
        (machine, own): (&Machine, &Machine),
        (before, step): (Option<&Step>, &Step),
    ) -> Result<(), &'static str> {
        // a failure may trigger one that is described before it
        for _ in 0..step.failures.len() {
            for (index, is) in step.failures.iter().enumerate() {
                let was = before.map_or(FailureMemory::default(), |before| before.failures[index]);
                if let (Some(at_s), None, None) = (is.brought_s, was.brought_s, self.failures[index].brought_s) {
                    self.failures[index].brought_s = self.trigger_s((machine, own), (index, at_s), (before, step))?;
                }
                if is.failed_s.is_some() && was.failed_s.is_none() {
                    let brought_s = self.failures[index].brought_s;
                    self.failures[index].failed_s =
                        brought_s.map(|brought_s| brought_s + machine.failures[index].delay_s);
                }
            }
        }
        Ok(())
    }

    /// Time of the trigger of a failure that the own machine triggers at `at_s`; `None` if that of another failure is not known yet.
    fn trigger_s(
        &self,
        (machine, own): (&Machine, &Machine),
        (index, at_s): (usize, f64),
        (before, step): (Option<&Step>, &Step),
    ) -> Result<Option<f64>, &'static str> {
        let described = &own.failures[index];
        let by_time = described.at_time_s == Some(at_s);
        let other = described.after.filter(|other| step.failures[*other].failed_s == Some(at_s));
        match (before, by_time, other) {
            // triggers at the start are those of all machines, as are inputs and motions at the end of a step
            (None, _, _) | (Some(_), false, None) => Ok(Some(at_s)),
            (Some(_), true, None) => Ok(machine.failures[index].at_time_s),
            (Some(_), false, Some(other)) => Ok(self.failures[other].failed_s),
            (Some(_), true, Some(_)) => Err(TWO_TRIGGERS),
        }
    }

    /// Slews whose motors are given another command at the start of a step; the inputs of the step are those of the state.
    fn slew(&mut self, system: &System, (before, step): (Option<&Step>, &Step)) {
        let State { applied_inputs, applied_rates, applied_parameters, applied_from_s, .. } = &system.state;
        let failures = &system.machine.failures;
        for (index, (forces, memory)) in system.equations.forces.joints().iter().zip(&step.joints).enumerate() {
            let was = before.map(|before| (before.joints[index].slew, before.middle_s()));
            let is = memory.slew;
            if was.is_some_and(|(slew, _)| slew == is) {
                continue;
            }
            // a failure on the joint, or a row of the inputs
            let fails = |failure: &usize| {
                step.failures[*failure].failed_s == Some(is.start_s)
                    && failures[*failure].effect.joint_of() == Some(forces.body)
            };
            let failed_s = (0..failures.len()).find(fails).and_then(|failure| self.failures[failure].failed_s);
            let time_s = failed_s.unwrap_or(is.start_s);
            let (command, rate) = (&applied_inputs.joints()[index], &applied_rates.joints()[index]);
            let mut told = Told {
                time_s,
                at_end: false,
                release: false,
                latch_enable: false,
                command_rad: command.command_rad + rate.command_rad * (time_s - applied_from_s),
                command_rate_rad_s: rate.command_rad,
                rate_limit_rad_s: applied_parameters.joints()[index].rate_limit_rad_s,
            };
            failure_memory::tell(failures, &self.failures, forces.body, memory, &mut told);
            let slew = &mut self.slews[index];
            let from_rad = match was {
                Some((was, middle_s)) => slew.on(time_s, was.piece(middle_s)).0,
                None => slew.from_rad,
            };
            *slew = Slew {
                from_rad,
                target_rad: told.command_rad,
                target_rate_rad_s: told.command_rate_rad_s,
                start_s: time_s,
                rate_limit_rad_s: told.rate_limit_rad_s,
            };
        }
    }
}
