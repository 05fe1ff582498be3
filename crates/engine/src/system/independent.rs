//! Degrees of freedom of a machine with rigid loops: the loops make some of them depend on the others, NOTATION eq. (L49).

use crate::multibody::kinematics::{Motion, sweep_motion};
use crate::multibody::tangent::Tangent;
use crate::system::System;
use crate::system::freedoms::Freedom;
use nalgebra::DMatrix;

/// Rate of a gap by the last joints, relative to the largest rate of a gap, below which strains depend on the rest instead of joints.
const BY_JOINTS: f64 = 1e-3;
/// Rate of a gap, relative to the largest one, below which a row is redundant.
const REDUNDANT: f64 = 1e-10;
/// Share of the largest pivot that another one needs to be preferred because it is further out: a dependent degree of freedom then moves by
/// at most twice the change that the best choice would have, and round-off decides between no two equal ones.
const PREFERRED: f64 = 0.5;

/// A degree of freedom that depends on the others, and the row of the gaps that determines it.
struct Dependent {
    column: usize,
    row: usize,
}

impl System {
    /// Degrees of freedom that the rigid loops leave independent, with those that follow them.
    pub(super) fn independent(&self, freedoms: Vec<Freedom>) -> Vec<Freedom> {
        if self.equations.model.rigid_loops.is_empty() || freedoms.is_empty() {
            return freedoms;
        }
        let (list, reduced) = self.eliminated(&freedoms);
        let follow = |column: usize| {
            let shares = list.iter().map(|own| (freedoms[own.column].index, -reduced[(own.row, column)]));
            shares.filter(|(_, share)| *share != 0.0).collect()
        };
        let depends = |column: usize| list.iter().any(|own| own.column == column);
        let kept = freedoms.iter().enumerate().filter(|(column, _)| !depends(*column));
        kept.map(|(column, freedom)| Freedom { follow: follow(column), ..freedom.clone() }).collect()
    }

    /// Indices in the vectors of the equations of the degrees of freedom that depend on the others.
    pub(crate) fn dependent(&self) -> Vec<usize> {
        if self.equations.model.rigid_loops.is_empty() {
            return Vec::new();
        }
        let freedoms = self.freedoms_of_tree();
        let (list, _) = self.eliminated(&freedoms);
        list.iter().map(|own| freedoms[own.column].index).collect()
    }

    /// Rates of the gaps of the rigid loops with the degrees of freedom at the current state, reduced by Gauss–Jordan elimination: in the row
    /// of a dependent degree of freedom it alone of the dependent ones has a rate, which is 1.
    fn eliminated(&self, freedoms: &[Freedom]) -> (Vec<Dependent>, DMatrix<f64>) {
        let mut gaps = self.gap_rates(freedoms);
        let model = &self.equations.model;
        let of_joint: Vec<bool> = (freedoms.iter())
            .map(|freedom| model.bodies.iter().any(|body| body.joint.range().contains(&freedom.index)))
            .collect();
        let largest = gaps.amax();
        let mut list: Vec<Dependent> = Vec::new();
        let mut open = vec![true; gaps.nrows()];
        for _ in 0..gaps.nrows() {
            let pivot = |column: usize| {
                let rows = (0..open.len()).filter(|row| open[*row]);
                rows.map(|row| (gaps[(row, column)].abs(), row))
                    .fold((0.0, 0), |a: (f64, usize), b| if b.0 > a.0 { b } else { a })
            };
            let last = |among: &dyn Fn(usize) -> bool, least: f64| {
                let columns: Vec<usize> = (0..freedoms.len()).filter(|column| among(*column)).collect();
                let best = columns.iter().map(|column| pivot(*column).0).fold(0.0, f64::max);
                let found = columns.into_iter().rev().find(|column| pivot(*column).0 >= PREFERRED * best);
                found.filter(|_| best > least * largest)
            };
            let Some(column) = last(&|column| of_joint[column], BY_JOINTS).or_else(|| last(&|_| true, REDUNDANT))
            else {
                break;
            };
            let (_, row) = pivot(column);
            open[row] = false;
            let own = gaps.row(row) / gaps[(row, column)];
            gaps.set_row(row, &own);
            for other in (0..gaps.nrows()).filter(|other| *other != row) {
                let share = gaps[(other, column)];
                let rest = gaps.row(other) - &own * share;
                gaps.set_row(other, &rest);
            }
            list.push(Dependent { column, row });
        }
        (list, gaps)
    }

    /// Rates of the gaps of the rigid loops, three rows each, per unit of the rates of the degrees of freedom.
    fn gap_rates(&self, freedoms: &[Freedom]) -> DMatrix<f64> {
        let (model, now) = (&self.equations.model, &self.state.now);
        let mut work = self.equations.work.clone();
        let still = vec![0.0; model.coordinates];
        sweep_motion(model, &mut work, Motion { q: &now.q, v: &still, a: &still });
        let mut gaps = DMatrix::zeros(3 * model.rigid_loops.len(), freedoms.len());
        for (column, freedom) in freedoms.iter().enumerate() {
            let mut unit = still.clone();
            unit[freedom.index] = 1.0;
            Tangent::to_coordinates(model, &work, &mut unit);
            // velocities are linear in the rates
            sweep_motion(model, &mut work, Motion { q: &now.q, v: &unit, a: &still });
            for (closure, own) in model.rigid_loops.iter().enumerate() {
                gaps.fixed_view_mut::<3, 1>(3 * closure, column).copy_from(&own.gap(&work).velocity_m_s);
            }
        }
        gaps
    }
}
