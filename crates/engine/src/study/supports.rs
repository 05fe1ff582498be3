//! Forces of rigid loops beside the state of a linear model, NOTATION eq. (L50): the accelerations of the degrees of freedom balance the
//! forces on the independent ones, the multipliers of the loops those on the dependent ones.

use crate::solve::EquationsOfMotion;
use crate::study::differences::Bare;
use crate::system::System;
use nalgebra::{DMatrix, DVector};

/// Singular value relative to the largest one below which a combination of multipliers exerts no force.
const IDLE: f64 = 1e-10;

/// Multipliers by the forces on the dependent degrees of freedom.
#[derive(Debug)]
pub(super) struct Supports {
    /// Indices of the dependent degrees of freedom in the vectors of the equations.
    dependent: Vec<usize>,
    /// Multipliers of least norm per force on each of them.
    by_force: DMatrix<f64>,
}

impl Supports {
    /// The supports at the current state of a system; `None` without rigid loops, or if they restrain nothing.
    pub fn of(system: &System) -> Option<Self> {
        let dependent = system.dependent();
        if dependent.is_empty() {
            return None;
        }
        let (tree, count) = (system.equations.model.tree_coordinates(), system.coordinates());
        let mut bare = Bare::without_stiffness(system);
        let columns = (tree..count).map(|multiplier| {
            let mut unit = vec![0.0; count];
            unit[multiplier] = 1.0;
            let forces = bare.of_accelerations(&system.state.now.q, &unit);
            DVector::from_iterator(dependent.len(), dependent.iter().map(|index| forces[*index]))
        });
        let forces = DMatrix::from_columns(&columns.collect::<Vec<_>>());
        let least = IDLE * forces.singular_values().max();
        let by_force = forces.pseudo_inverse(least).ok()?;
        Some(Self { dependent, by_force })
    }

    /// Sets the multipliers of the rigid loops to those that balance the forces on the dependent degrees of freedom at the state and the
    /// loads of the equations.
    pub fn set(&self, system: &mut System) {
        let tree = system.equations.model.tree_coordinates();
        let mut residual = vec![0.0; system.coordinates()];
        let now = &mut system.state.now;
        system.equations.residual(now.time_s, &now.q, &now.v, &now.a, &mut residual);
        let left = self.dependent.iter().map(|index| residual[*index]);
        let change = &self.by_force * DVector::from_iterator(self.dependent.len(), left);
        now.a[tree..].iter_mut().zip(change.iter()).for_each(|(multiplier, change)| *multiplier -= change);
    }
}
