//! Rigid loops in the tangent, NOTATION eq. (L44): Newton's method for coordinates and multipliers together.
//!
//! A support, a spring across each gap, is added to the tangent, so that its factors exist if only the loops restrain a degree of freedom.
//! It changes no solution, because its force is zero when the constraints are met.

use crate::multibody::model::Model;
use crate::multibody::tangent::Tangent;
use crate::multibody::tangent::loops::RigidTangent;
use nalgebra::{DMatrix, DVector};

/// Singular value of the small matrix, relative to its largest, below which a row is redundant.
const REDUNDANT: f64 = 1e-10;
/// Singular value of the small matrix, relative to the displacement of a point by a unit force on it alone, below which it is round-off: of
/// forces that cancel, times that of displacements that cancel, 1e-32 multiplied by the condition of the tree. Those of a loop that restrains a
/// motion are at least the stiffness of the machine over that of the support, 1e-13 for a soft hinge between stiff beams.
const IDLE: f64 = 1e-20;
/// Stiffness of the support of a machine without beams, relative to its weight divided by its length.
const OF_WEIGHT: f64 = 100.0;

/// Stiffness of the support in N/m: the largest axial stiffness of an element.
pub(super) fn support_n_m(model: &Model) -> f64 {
    let axial = |element: &crate::multibody::model::Element| match &element.sheared {
        Some(own) => own.section_stiffness[0][(0, 0)] / element.length_m,
        None => element.elastic.section_stiffness[0][(0, 0)] / element.length_m,
    };
    let of_beams = model.elements.iter().map(axial).fold(0.0, f64::max);
    let mass_kg: f64 =
        model.nodes.iter().map(|node| node.beam[(0, 0)] + node.attached.map_or(0.0, |attached| attached[(0, 0)])).sum();
    of_beams.max(OF_WEIGHT * 10.0 * mass_kg / model.reference_length_m)
}

impl Tangent {
    /// Factorises the constraints; the factors of the tree with its closures and the support must be current.
    pub(super) fn factorize_rigid(&mut self, model: &Model) {
        let rows = 3 * model.rigid_loops.len();
        self.rigid = None;
        if rows == 0 {
            return;
        }
        let n = model.coordinates;
        let closures = self.closures[model.closures.len()..].to_vec();
        let mut columns = DMatrix::zeros(n, rows);
        let mut small = DMatrix::zeros(rows, rows);
        let mut x = vec![0.0; n];
        let mut mobility = 0.0f64;
        for row in 0..rows {
            let closure = &closures[row / 3];
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                let Some(node) = closure.nodes[side] else { continue };
                let wrench = closure.points[side].transpose().column(row % 3).into_owned();
                x.fill(0.0);
                self.solve_tree(model, &mut x, Some((node, &wrench)));
                self.correct_closures(&mut x);
                self.displace(model, &x);
                mobility = mobility.max(closure.displacement(side, &self.displaced).amax());
                columns.column_mut(row).iter_mut().zip(&x).for_each(|(sum, x)| *sum += sign * x);
            }
            let gaps = self.rigid_gaps(model, columns.column(row).as_slice());
            small.column_mut(row).copy_from(&gaps);
        }
        let symmetric = (&small + small.transpose()) * 0.5;
        let values = symmetric.symmetric_eigenvalues();
        // if no loop has a freedom, the largest value is round-off too
        let least = |largest: f64| (REDUNDANT * largest).max(IDLE * mobility);
        let negative = values.iter().filter(|value| **value < -least(values.amax())).count();
        let largest = small.singular_values().max();
        if let Ok(inverse) = small.pseudo_inverse(least(largest)) {
            self.rigid = Some(RigidTangent { columns, inverse, negative, support_n_m: support_n_m(model) });
        }
    }

    /// Changes of the gaps of the rigid loops with the coordinates `x`.
    fn rigid_gaps(&mut self, model: &Model, x: &[f64]) -> DVector<f64> {
        self.displace(model, x);
        let closures = &self.closures[model.closures.len()..];
        let gaps = closures.iter().flat_map(|closure| {
            let change = closure.displacement(1, &self.displaced) - closure.displacement(0, &self.displaced);
            [change.x, change.y, change.z]
        });
        DVector::from_iterator(3 * closures.len(), gaps)
    }

    /// Adds the constraints to a solution: in the rows of the multipliers `x` holds the gaps on entry and the changes of the multipliers on
    /// return.
    pub(super) fn correct_rigid(&mut self, model: &Model, x: &mut [f64]) {
        let Some(rigid) = self.rigid.take() else { return };
        let moved = self.rigid_gaps(model, x);
        let (of_tree, rows) = x.split_at_mut(model.tree_coordinates());
        let open = DVector::from_column_slice(rows);
        let weights = &rigid.inverse * (moved - &open);
        let correction = &rigid.columns * &weights;
        of_tree.iter_mut().zip(correction.iter()).for_each(|(x, correction)| *x -= correction);
        let changes = weights + open * rigid.support_n_m;
        rows.copy_from_slice(changes.as_slice());
        self.rigid = Some(rigid);
    }
}
