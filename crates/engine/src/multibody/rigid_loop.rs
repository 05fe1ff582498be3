//! Constraints by multipliers: rigid loops, points that coincide by constraint forces, NOTATION eqs. (C5)–(C7), with skates and wheels,
//! eqs. (L47), (L48).
//!
//! The multipliers of the constraints are unknowns beside the accelerations, stored as the last coordinates; in their rows the residual has
//! the second rates of the gaps. The small matrix of the constraints follows from the factors of the tree; its pseudo-inverse omits
//! redundant rows.

use crate::multibody::closure::{self, Gap, project_bias};
use crate::multibody::constraint::Constraint;
use crate::multibody::kinematics::{Motion, sweep_motion};
use crate::multibody::model::Model;
use crate::multibody::norm::kinematic_norm;
pub(crate) use crate::multibody::rigid_factor::RigidFactor;
use crate::multibody::runner::ROWS;
use crate::multibody::workspace::{Pair, Workspace};
use nalgebra::Vector3;
use std::sync::Arc;

/// The gap or one of its rates.
type Rate = fn(&Gap) -> Vector3<f64>;

/// Largest gap, relative to the machine's length, and largest rate of a gap, relative to the speeds at the loop, that count as round-off.
const ROUND_OFF: f64 = 2.0 * f64::EPSILON;
/// Gap relative to the machine's length above which a loop is open, if no correction reduces it further.
const OPEN: f64 = 1e-12;
/// Number of initial corrections in which the gaps or their rates may grow: the rates are corrected at coordinates that still change.
const SETTLED: usize = 3;
/// Maximum number of corrections: each reduces the gap in the ratio of the change of directions since the factorisation, as a rule to 1 %.
const CORRECTIONS: usize = 30;
/// Rate of a row, relative to the speeds at the constraint, above which a skate or a wheel slips; the same share of the machine's length
/// off its plane.
const SLIPS: f64 = 1e-9;

/// Writes the second rates of the gaps to the rows of the multipliers, eq. (C5).
pub(crate) fn violations(model: &Model, work: &Workspace, residual: &mut [f64]) {
    for index in 0..model.constraints() {
        let gap = model.constraint(index).gap(work);
        residual[model.multipliers(index)].copy_from_slice(gap.acceleration_m_s2.as_slice());
    }
}

/// Adds the constraints to a factorisation of the tree, its closures and its damped modes.
pub(crate) fn factorize(model: &Model, work: &mut Workspace) {
    let mut factor = std::mem::replace(&mut work.rigid_factor, RigidFactor::new(0, 0));
    let rows = factor.gaps.len();
    factor.mobility = 0.0;
    for row in 0..rows {
        let column = &mut factor.columns[row];
        let own = model.constraint(row / ROWS);
        if !own.is_active(row % ROWS) {
            // without a force the pseudo-inverse omits the row
            column.fill(0.0);
            (0..rows).for_each(|other| factor.small[other * rows + row] = 0.0);
            continue;
        }
        work.bias.fill(Pair::ZERO);
        own.load_unit(work, row % ROWS);
        project_bias(model, work, column);
        closure::solve(model, work, column);
        for other in 0..model.constraints() {
            let (change, largest) = model.constraint(other).changes(work);
            factor.mobility = factor.mobility.max(largest);
            for axis in 0..ROWS {
                factor.small[(ROWS * other + axis) * rows + row] = change[axis];
            }
        }
    }
    factor.invert();
    work.rigid_factor = factor;
}

/// Adds the constraints to a solution without them, whose node displacements must be in `work.bias`. In the rows of the multipliers `x`
/// holds the second rates of the gaps on entry and the changes of the multipliers on return, eq. (C6). Returns the kinematic norm of the
/// solution.
pub(crate) fn correct(model: &Model, work: &mut Workspace, x: &mut [f64]) -> f64 {
    let mut factor = std::mem::replace(&mut work.rigid_factor, RigidFactor::new(0, 0));
    let (of_tree, rows) = x.split_at_mut(model.tree_coordinates());
    for index in 0..model.constraints() {
        let (change, _) = model.constraint(index).changes(work);
        for axis in 0..ROWS {
            factor.gaps[ROWS * index + axis] = change[axis] - rows[ROWS * index + axis];
        }
    }
    factor.remove_gaps(of_tree);
    rows.iter_mut().enumerate().for_each(|(row, x)| *x = factor.weight(row));
    work.rigid_factor = factor;
    kinematic_norm(model, work, x)
}

/// The factors that the last projection used.
pub(crate) fn last_closing(work: &Workspace) -> Arc<RigidFactor> {
    work.closing.clone().unwrap_or_else(|| Arc::new(work.rigid_factor.clone()))
}

/// Projects a state onto the constraints with the last factors, or those in `work.closing`, eqs. (C7), (L48): coordinates, then rates and
/// accelerations at these.
pub(crate) fn close(model: &Model, work: &mut Workspace, [q, v, a]: [&mut [f64]; 3]) -> Result<(), Miss> {
    let tree = model.tree_coordinates();
    // integrals of the multipliers have no meaning
    q[tree..].fill(0.0);
    v[tree..].fill(0.0);
    let kept = work.closing.clone();
    let mut factor = match &kept {
        Some(kept) => RigidFactor::clone(kept),
        None => std::mem::replace(&mut work.rigid_factor, RigidFactor::new(0, 0)),
    };
    let mut before = f64::INFINITY;
    let mut openness = Openness::default();
    for round in 0..CORRECTIONS {
        sweep_motion(model, work, Motion { q, v, a });
        openness = Openness::of(model, work);
        let worst = openness.gap.max(openness.rate);
        if worst <= ROUND_OFF
            || (round >= SETTLED && worst > 0.5 * before && openness.gap <= OPEN)
            || !worst.is_finite()
        {
            break;
        }
        before = worst;
        let parts: [(&mut [f64], Rate); 3] = [
            (&mut q[..tree], |gap| gap.position_m),
            (&mut v[..tree], |gap| gap.velocity_m_s),
            (&mut a[..tree], |gap| gap.acceleration_m_s2),
        ];
        for (x, part) in parts {
            for index in 0..model.constraints() {
                let gap = model.constraint(index).gap(work);
                factor.gaps[ROWS * index..][..ROWS].copy_from_slice(part(&gap).as_slice());
            }
            factor.remove_gaps(x);
        }
    }
    if kept.is_none() {
        work.rigid_factor = factor;
    }
    let Openness { of_loops, slip, .. } = openness;
    match (of_loops <= OPEN, slip <= SLIPS) {
        (true, true) => Ok(()),
        (true, false) => Err(Miss::Slips(slip)),
        (false, true | false) => Err(Miss::Open(of_loops)),
    }
}

/// Reason why corrections leave a state off the constraints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Miss {
    /// Largest gap relative to the machine's length.
    Open(f64),
    /// Largest rate of a row of a skate or a wheel relative to its speed, or distance from the plane relative to the machine's length.
    Slips(f64),
}

/// Distance of a state from the constraints.
#[derive(Debug, Clone, Copy, Default)]
struct Openness {
    /// Largest gap relative to the machine's length.
    gap: f64,
    /// Largest rate of a row relative to the speed of the constraint's points, which counts as at least one length per second.
    rate: f64,
    /// Largest gap of rigid loops only.
    of_loops: f64,
    /// Largest gap or rate of skates and wheels only.
    slip: f64,
}

impl Openness {
    /// The distance at the motion of the last sweep.
    fn of(model: &Model, work: &Workspace) -> Self {
        let length_m = model.reference_length_m;
        // a gap that is not a number is not closed
        let larger = |largest: f64, share: f64| if share.is_nan() { f64::INFINITY } else { largest.max(share) };
        let mut own = Self::default();
        for index in 0..model.constraints() {
            let constraint = model.constraint(index);
            let gap = constraint.gap(work);
            let speed_m_s = length_m.max(constraint.speed_m_s(work));
            let rate = gap.velocity_m_s.norm() / speed_m_s;
            let open = gap.position_m.norm() / length_m;
            own.gap = larger(own.gap, open);
            own.rate = larger(own.rate, rate);
            match constraint {
                Constraint::Loop(_) => own.of_loops = larger(own.of_loops, open),
                Constraint::NoSlip(_) => own.slip = larger(larger(own.slip, open), rate),
            }
        }
        own
    }
}
