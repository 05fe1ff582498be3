//! Results that are forces of redundant constraints: of these only sums are determined, so that they have no derivative.

use crate::gradient::{Gradient, GradientError};
use crate::multibody::kinematics::{Motion, sweep_motion};
use crate::multibody::no_slip::ROWS;
use crate::multibody::workspace::{Pair, Workspace};
use crate::solve::point::Point;
use crate::system::{LoopOutputs, NoSlipOutputs};
use nalgebra::Vector3;
use std::mem::{offset_of, size_of};

/// Entry of a unit null vector of the constraints, and wrench on a node, relative to the multipliers, that is round-off.
const ROUND_OFF: f64 = 1e-7;

impl Gradient<'_> {
    /// Returns an error for an output at a requested time that contains a force of redundant constraints.
    pub(super) fn check_determined(&self, index: usize, time: usize) -> Result<(), GradientError> {
        let step = &self.tape.steps[self.tape.marks[time].step];
        let Some(factor) = &step.closing else { return Ok(()) };
        let layout = self.system.outputs.layout();
        let reacts = layout.joint_reactions.range().contains(&index) || layout.internal_loads.range().contains(&index);
        let model = &self.system.equations.model;
        let row = self.multiplier_of(index).filter(|row| model.constraint(row / ROWS).is_active(row % ROWS));
        if row.is_none() && !reacts {
            return Ok(());
        }
        let undetermined = |null: Vec<f64>| match row {
            Some(row) => null[row].abs() > ROUND_OFF,
            None => self.largest_wrench(&null, &step.end) > ROUND_OFF * model.reference_length_m.max(1.0),
        };
        match factor.null_vectors().any(undetermined) {
            true => Err(GradientError::OtherChoice {
                part: "forces of redundant constraints, of which only sums are determined",
                remedy: "choose motions, strains or the reaction of the root, or remove a redundant rigid loop, skate or wheel"
                    .into(),
            }),
            false => Ok(()),
        }
    }

    /// The row of the constraints whose multiplier an output is.
    fn multiplier_of(&self, index: usize) -> Option<usize> {
        let layout = self.system.outputs.layout();
        let machine = &self.system.machine;
        let place = |first: usize, size: usize| {
            let entries = size / size_of::<f64>();
            ((index - first) / entries, (index - first) % entries)
        };
        let component =
            |entry: usize, offset: usize| entry.checked_sub(offset / size_of::<f64>()).filter(|axis| *axis < ROWS);
        if layout.loops.range().contains(&index) {
            let (own, entry) = place(layout.loops.range().start, size_of::<LoopOutputs>());
            let before = machine.closures[..own].iter().filter(|closure| closure.rigid).count();
            let axis = component(entry, offset_of!(LoopOutputs, force_n))?;
            return machine.closures[own].rigid.then_some(ROWS * before + axis);
        }
        if layout.no_slips.range().contains(&index) {
            let (own, entry) = place(layout.no_slips.range().start, size_of::<NoSlipOutputs>());
            let loops = machine.closures.iter().filter(|closure| closure.rigid).count();
            let axis = component(entry, offset_of!(NoSlipOutputs, side_force_n))?;
            return Some(ROWS * (loops + own) + axis);
        }
        None
    }

    /// Largest force in N or moment in N·m on a node by multipliers of the constraints at a point.
    fn largest_wrench(&self, multipliers: &[f64], at: &Point) -> f64 {
        let model = &self.system.equations.model;
        let mut work = Workspace::new(model);
        sweep_motion(model, &mut work, Motion { q: &at.q, v: &at.v, a: &at.a });
        let mut sums = vec![[Vector3::zeros(); 2]; model.nodes.len()];
        for (row, multiplier) in multipliers.iter().enumerate() {
            work.bias.fill(Pair::ZERO);
            model.constraint(row / ROWS).load_unit(&mut work, row % ROWS);
            for ([force, moment], unit) in sums.iter_mut().zip(&work.bias) {
                *force += unit.linear * *multiplier;
                *moment += unit.angular * *multiplier;
            }
        }
        sums.iter().flatten().fold(0.0, |largest, part| largest.max(part.amax()))
    }
}
