//! The projection of the end of a step onto the constraints of universal, ball and free joints, (J6), with its slopes, eq. (X27), then onto
//! those of rigid loops, skates and wheels, (C7) and (L48), with its slopes, eq. (X42).

use crate::gradient::tape::Step;
use crate::gradient::variation::{Variation, product};
use crate::gradient::{Gradient, GradientError, add, dot};
use crate::math::difference::SIXTH_ORDER;
use crate::multibody::joint::Joint;
use crate::multibody::kinematics::{self, Motion};
use crate::multibody::no_slip::ROWS;
use crate::multibody::rigid_loop::{self, RigidFactor};
use crate::run::Plant;
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use crate::system::equations::Equations;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Maximum number of corrections of a last stage.
const CORRECTIONS: usize = 20;
/// Correction of a last stage, as displacement relative to the machine's length, from which it is round-off.
const ROUND_OFF: f64 = 1e-14;
/// Corrections of a projection onto constraints: each reduces the gaps in the ratio of the change of directions since the factorisation, as
/// a rule to 1 %.
const CLOSINGS: usize = 6;
/// Step of the differences of a projection, relative to parameters of unit size, and to the sizes of their rates and accelerations.
const STEP: f64 = 2e-3;

/// Slopes of the projections of all joints with redundant parameters, and of that onto constraints.
pub(super) struct Projection {
    joints: Vec<(Joint, DMatrix<f64>)>,
    closing: Option<Closing>,
}

/// Slopes of the projection onto the gaps of constraints: coordinates, then rates, then accelerations, each along the columns of the factors
/// of the run, eq. (X42).
struct Closing {
    /// Changes of the tree's coordinates that remove the gaps: a matrix of one row per row of the gaps.
    removal: Vec<Vec<f64>>,
    /// Per order, the rows of the gap, its rate and its acceleration.
    rows: [Vec<GapRow>; 3],
}

/// A row of a gap or of its rates.
struct GapRow {
    /// Slopes with respect to the coordinates, their rates and their accelerations.
    by_motion: Variation,
    by_parameters: Vec<f64>,
}

impl Projection {
    /// Projects a variation of the last stage to that of the end; `direction`: its parameter, if its machine varies too.
    pub fn apply(&self, variation: &mut Variation, direction: Option<usize>) {
        self.multiply(variation, |slopes, part| slopes * part);
        let Some(Closing { removal, rows }) = &self.closing else { return };
        let tree = removal.first().map_or(0, Vec::len);
        // integrals of the multipliers have no meaning
        [&mut variation.q, &mut variation.v].into_iter().for_each(|part| part[tree..].fill(0.0));
        for (order, rows) in rows.iter().enumerate() {
            for _ in 0..CLOSINGS {
                let gap = |row: &GapRow| {
                    product(&row.by_motion, variation) + direction.map_or(0.0, |direction| row.by_parameters[direction])
                };
                let gaps: Vec<f64> = rows.iter().map(gap).collect();
                let part = variation.part_mut(order);
                for (gap, change) in gaps.iter().zip(removal) {
                    add(&mut part[..tree], -gap, change);
                }
            }
        }
    }

    /// The multipliers of the last stage from those of the end; `gradient` receives the slopes with respect to the parameters.
    pub fn pull(&self, on: &mut Variation, mut gradient: Option<&mut Vec<f64>>) {
        if let Some(Closing { removal, rows }) = &self.closing {
            let tree = removal.first().map_or(0, Vec::len);
            for (order, rows) in rows.iter().enumerate().rev() {
                for _ in 0..CLOSINGS {
                    let on_part = &on.part_mut(order)[..tree];
                    let weights: Vec<f64> = removal.iter().map(|change| dot(change, on_part)).collect();
                    for (weight, row) in weights.iter().zip(rows) {
                        on.add(-weight, &row.by_motion);
                        if let Some(gradient) = &mut gradient {
                            add(gradient, -weight, &row.by_parameters);
                        }
                    }
                }
            }
            [&mut on.q, &mut on.v].into_iter().for_each(|part| part[tree..].fill(0.0));
        }
        self.multiply(on, |slopes, part| slopes.tr_mul(&part));
    }

    fn multiply(&self, of: &mut Variation, product: impl Fn(&DMatrix<f64>, DVector<f64>) -> DVector<f64>) {
        for (joint, slopes) in &self.joints {
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
    /// The projection at the end of a step, whose joints are adopted.
    pub(super) fn projection(&mut self, step: &Step) -> Projection {
        let Some(last) = step.last.as_deref() else { return Projection { joints: Vec::new(), closing: None } };
        let joints = self.system.equations.model.bodies.iter().map(|body| body.joint);
        let of = |joint: Joint| (joint, slopes(&joint, last));
        let joints = joints.filter(|joint| joint.kind.is_redundant()).map(of).collect();
        Projection { joints, closing: self.closing(step) }
    }

    /// Slopes of the projection onto constraints by the factors of the run.
    fn closing(&mut self, step: &Step) -> Option<Closing> {
        let factor = step.closing.as_deref()?;
        let (at, n) = (&step.end, self.system.coordinates());
        self.linearize(at);
        let gaps = ROWS * self.system.equations.model.constraints();
        let by_neighbours: Vec<Vec<f64>> = self
            .neighbours
            .iter_mut()
            .map(|beside| {
                let mut slopes = vec![0.0; 3 * gaps];
                beside.add_slopes(&mut slopes, |system, gaps| system.equations.gaps(at, gaps));
                slopes
            })
            .collect();
        let rows = [0, 1, 2].map(|order| {
            let row = |row: usize| {
                let mut by_motion = Variation::zeros(n);
                let Variation { q, v, a } = &mut by_motion;
                self.derivative.gap_slopes((row / ROWS, order, row % ROWS), [q, v, a]);
                let own: Vec<f64> = by_neighbours.iter().map(|slopes| slopes[order * gaps + row]).collect();
                GapRow { by_motion, by_parameters: self.by_parameters(at.time_s, &own) }
            };
            (0..gaps).map(row).collect()
        });
        Some(Closing { removal: (0..gaps).map(|row| factor.removal(row)).collect(), rows })
    }
}

impl Equations {
    /// Gaps of all rows of the constraints at a point, then their rates and accelerations.
    fn gaps(&mut self, at: &Point, gaps: &mut [f64]) {
        kinematics::sweep_motion(&self.model, &mut self.work, Motion { q: &at.q, v: &at.v, a: &at.a });
        let (positions, rates) = gaps.split_at_mut(ROWS * self.model.constraints());
        let (velocities, accelerations) = rates.split_at_mut(positions.len());
        for index in 0..self.model.constraints() {
            let gap = self.model.constraint(index).gap(&self.work);
            let own = ROWS * index..ROWS * (index + 1);
            positions[own.clone()].copy_from_slice(gap.position_m.as_slice());
            velocities[own.clone()].copy_from_slice(gap.velocity_m_s.as_slice());
            accelerations[own].copy_from_slice(gap.acceleration_m_s2.as_slice());
        }
    }
}

impl Plant {
    /// The factors of the last projection onto constraints.
    pub(super) fn last_closing(&self) -> Option<Arc<RigidFactor>> {
        let equations = &self.system.equations;
        (equations.model.constraints() > 0).then(|| rigid_loop::last_closing(&equations.work))
    }

    /// Takes a step whose end is projected onto constraints by the factors of another one.
    pub(super) fn closed_by<T>(&mut self, step: &Step, take: impl FnOnce(&mut Self) -> T) -> T {
        self.system.equations.work.closing.clone_from(&step.closing);
        let taken = take(self);
        self.system.equations.work.closing = None;
        taken
    }

    /// Keeps the last stage of a step just taken, if its end was projected: solved again, as the run does not store it.
    pub(super) fn keep_last_stage(&mut self, step: &mut Step) -> Result<(), GradientError> {
        let equations = &self.system.equations;
        let is_projected = !equations.spatial.is_empty() || equations.model.constraints() > 0;
        let Some(tableau) = self.tableau().filter(|_| is_projected) else { return Ok(()) };
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
