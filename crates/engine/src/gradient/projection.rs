//! The projection of the end of a step onto the constraints of universal, ball and free joints, (J6), with its slopes, eq. (X27).

use crate::gradient::tape::Step;
use crate::gradient::variation::Variation;
use crate::gradient::{Gradient, GradientError, add};
use crate::math::difference::SIXTH_ORDER;
use crate::multibody::joint::Joint;
use crate::run::Plant;
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use nalgebra::{DMatrix, DVector};

/// Maximum number of corrections of a last stage.
const CORRECTIONS: usize = 20;
/// Correction of a last stage, as displacement relative to the machine's length, from which it is round-off.
const ROUND_OFF: f64 = 1e-14;
/// Step of the differences of a projection, relative to parameters of unit size, and to the sizes of their rates and accelerations.
const STEP: f64 = 2e-3;

/// Slopes of the projections of all joints with redundant parameters.
pub(super) struct Projection(Vec<(Joint, DMatrix<f64>)>);

impl Projection {
    /// Projects a variation of the last stage to that of the end.
    pub fn apply(&self, variation: &mut Variation) {
        self.multiply(variation, |slopes, part| slopes * part);
    }

    /// The multipliers of the last stage from those of the end.
    pub fn pull(&self, on: &mut Variation) {
        self.multiply(on, |slopes, part| slopes.tr_mul(&part));
    }

    fn multiply(&self, of: &mut Variation, product: impl Fn(&DMatrix<f64>, DVector<f64>) -> DVector<f64>) {
        for (joint, slopes) in &self.0 {
            let (range, count) = (joint.range(), joint.kind.coordinates());
            let parts = [&of.q, &of.v, &of.a].map(|part| &part[range.clone()]).concat();
            let new = product(slopes, DVector::from_vec(parts));
            for (part, new) in [&mut of.q, &mut of.v, &mut of.a].into_iter().zip(new.as_slice().chunks_exact(count)) {
                part[range.clone()].copy_from_slice(new);
            }
        }
    }
}

/// Slopes of the projection of a joint's parameters with their derivatives.
fn slopes(joint: &Joint, at: &Point) -> DMatrix<f64> {
    let (range, count) = (joint.range(), joint.kind.coordinates());
    let here = Joint { coordinate: 0, ..*joint };
    let own = [&at.q, &at.v, &at.a].map(|part| &part[range.clone()]).concat();
    let sizes = [0, 1, 2].map(|part| {
        own[part * count..(part + 1) * count].iter().fold(f64::MIN_POSITIVE, |size: f64, entry| size.max(entry.abs()))
    });
    let mut slopes = DMatrix::zeros(3 * count, 3 * count);
    for column in 0..3 * count {
        let step = STEP * if column < count { 1.0 } else { sizes[column / count] };
        let mut sum = vec![0.0; 3 * count];
        for (steps, weight) in (1..).zip(SIXTH_ORDER) {
            for sign in [1.0, -1.0] {
                let mut there = own.clone();
                there[column] += sign * f64::from(steps) * step;
                let (q, rest) = there.split_at_mut(count);
                let (v, a) = rest.split_at_mut(count);
                here.restore(q, v, a);
                add(&mut sum, sign * weight / (60.0 * step), &there);
            }
        }
        slopes.column_mut(column).copy_from_slice(&sum);
    }
    slopes
}

impl Gradient<'_> {
    /// The projection at the end of a step.
    pub(super) fn projection(&self, step: &Step) -> Projection {
        let Some(last) = step.last.as_deref() else { return Projection(Vec::new()) };
        let joints = self.system.equations.model.bodies.iter().map(|body| body.joint);
        let of = |joint: Joint| (joint, slopes(&joint, last));
        Projection(joints.filter(|joint| joint.kind.is_redundant()).map(of).collect())
    }
}

impl Plant {
    /// Keeps the last stage of a step just taken, if its end was projected: solved again, as the run does not store it.
    pub(super) fn keep_last_stage(&mut self, step: &mut Step) -> Result<(), GradientError> {
        let Some(tableau) = self.tableau().filter(|_| !self.system.equations.spatial.is_empty()) else { return Ok(()) };
        let h = step.length_s();
        let gain = h * tableau.gamma;
        let mut last = step.end.clone();
        let Point { time_s, q, v, a, .. } = &mut last;
        q.copy_from_slice(&step.start.q);
        v.copy_from_slice(&step.start.v);
        let before = std::iter::once(&step.start).chain(&step.stages);
        for (weight, stage) in tableau.rows[tableau.stages() - 2].iter().zip(before) {
            add(q, h * weight, &stage.v);
            add(v, h * weight, &stage.a);
        }
        add(v, gain, a);
        add(q, gain, v);
        let equations = &mut self.system.equations;
        equations.branch_s = step.middle_s();
        equations.prescribe(*time_s, q, v, a);
        let mut left = vec![0.0; a.len()];
        let mut size = f64::INFINITY;
        for correction in 0..CORRECTIONS {
            equations.residual(*time_s, q, v, a, &mut left);
            if correction == 0 {
                let not_solved = GradientError::NotSolved { time_s: *time_s, left: f64::INFINITY };
                equations.factorize(1.0, gain, gain * gain).map_err(|_| not_solved)?;
            }
            let before = std::mem::replace(&mut size, equations.solve(&mut left) * gain * gain);
            add(a, -1.0, &left);
            add(v, -gain, &left);
            add(q, -gain * gain, &left);
            if size <= ROUND_OFF || size >= before {
                break;
            }
        }
        step.last = Some(Box::new(last));
        Ok(())
    }
}
