//! Inertia of elements with shear in the tangent: the slope of their axis at both ends rotates with the nodes and changes with the strains.

use crate::math::so3::hat;
use crate::math::strain::LINEAR;
use crate::multibody::model::Element;
use crate::multibody::slope;
use crate::multibody::slope_vector::Slope;
use crate::multibody::tangent::block::{Cross, SlopeTangent};
use crate::multibody::tangent::twist::{add_turning, shares, spread};
use crate::multibody::workspace::Node;
use nalgebra::{Matrix3, Matrix6, SMatrix};
use std::array::from_fn;

impl<const N: usize> SlopeTangent<N> {
    /// Tangent of an element between two nodes: also adds its lumped inertias to the tangents of the nodes, and returns the coupling of the
    /// nodes. `frame` maps nodal vectors to their accelerations.
    pub fn new(
        element: &Element,
        frame: &Matrix3<f64>,
        (nodes, slopes): (&[Node], &[Slope; 2]),
        [at_inner, at_outer]: [&mut Matrix6<f64>; 2],
    ) -> (Self, Cross) {
        let axes: [Matrix3<f64>; 2] = from_fn(|end| slopes[end].axes(&nodes[end]));
        let forces = slope::forces::<false>(element, &from_fn(|end| slopes[end].load_rates(&nodes[end])));
        add_turning(at_inner, &axes[0], &forces[0]);
        add_turning(at_outer, &axes[1], &forces[1]);
        let mut tangent = Self::ZERO;
        for end in 0..2 {
            // M = d × f and R^T f with the force f on the slope
            let turning = hat(&forces[end][1]) * nodes[end].rotation;
            for (k, &strain) in LINEAR.iter().enumerate() {
                let column = turning.column(k).into_owned();
                tangent.columns[end].fixed_view_mut::<3, 1>(3, strain).copy_from(&-column);
                tangent.rows[end].fixed_view_mut::<1, 3>(strain, 3).copy_from(&-column.transpose());
            }
        }
        let mut cross = Cross { outer_inner: Matrix6::zeros(), inner_outer: Matrix6::zeros() };
        if *frame == Matrix3::zeros() {
            return (tangent, cross);
        }
        let twists: [SMatrix<f64, 12, 6>; 2] = from_fn(|end| spread(&axes[end]));
        let strains: [SMatrix<f64, 12, N>; 2] = from_fn(|end| {
            let mut map = SMatrix::<f64, 12, N>::zeros();
            for (k, &strain) in LINEAR.iter().enumerate() {
                map.fixed_view_mut::<3, 1>(3, strain).copy_from(&nodes[end].rotation.column(k));
            }
            map
        });
        let transposed = element.cross_mass.transpose();
        let Some(inner_mass) = &element.inner_mass else { return (tangent, cross) };
        let masses = [[&**inner_mass, &transposed], [&element.cross_mass, &element.outer_mass]];
        *at_inner += shares(masses[0][0], frame, &twists[0], &twists[0]);
        *at_outer += shares(masses[1][1], frame, &twists[1], &twists[1]);
        cross.inner_outer = shares(masses[0][1], frame, &twists[0], &twists[1]);
        cross.outer_inner = shares(masses[1][0], frame, &twists[1], &twists[0]);
        for (row, masses) in masses.into_iter().enumerate() {
            for (column, mass) in masses.into_iter().enumerate() {
                tangent.rows[column] += shares(mass, frame, &strains[row], &twists[column]);
                tangent.columns[row] += shares(mass, frame, &twists[row], &strains[column]);
                tangent.own += shares(mass, frame, &strains[row], &strains[column]);
            }
        }
        (tangent, cross)
    }
}
