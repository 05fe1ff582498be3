//! Factorisation and solution of `(a BᵀM B + b C + c K) x = r`: the tree by its recursion, then closed loops and damped modes, then
//! constraints, each as a correction of low rank.

use crate::multibody::dynamics::Damping;
use crate::multibody::model::Model;
use crate::multibody::tree_factor::factorize_tree;
use crate::multibody::workspace::Workspace;
use crate::multibody::{closure, rigid_loop};

pub use crate::multibody::elimination::{BadPivot, FreedomTangent, Weights};

/// Factorises at the poses in `work`. `tangents` has one entry per body; those of clamped bodies are ignored.
/// Allocates nothing.
pub fn factorize(
    model: &Model,
    work: &mut Workspace,
    weights: Weights,
    damping: &[Damping],
    tangents: &[FreedomTangent],
) -> Result<(), BadPivot> {
    factorize_tree(model, work, weights, damping, tangents)?;
    if model.is_bordered() {
        closure::factorize(model, work, weights).ok_or(BadPivot { coordinate: 0 })?;
    }
    if model.constraints() > 0 {
        rigid_loop::factorize(model, work);
    }
    Ok(())
}

/// Solves with the last factorisation: `x` holds the right-hand side and then the solution.
///
/// Returns the kinematic norm of the solution: the largest rotation in rad, or node displacement divided by the reference length, caused by
/// `x`. Not finite if an entry is not finite. Allocates nothing.
pub fn solve(model: &Model, work: &mut Workspace, x: &mut [f64]) -> f64 {
    let norm = closure::solve(model, work, x);
    if model.constraints() == 0 { norm } else { rigid_loop::correct(model, work, x) }
}
