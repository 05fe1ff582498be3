//! Elements with shear at the point of linearisation: six strains, and inertia of the slope of the axis at both ends, NOTATION eqs. (D18)
//! and (X29).

use crate::math::jet::{Jet, Moving, Partial, Vector};
use crate::math::jet_link::{self, JetSlopes};
use crate::math::strain::{LINEAR, SHEARED, STRETCH, Strain, StrainMatrix, TWIST, strains_at};
use crate::multibody::derivative::chain::{Column, STILL, Shift, Timed, add_part, pulled_part};
use crate::multibody::derivative::link::{orders, turned};
use crate::multibody::derivative::spot::{Field, Four, NONE, Spot};
use crate::multibody::kinematics::Motion;
use crate::multibody::model::{Element, Model};
use crate::multibody::slope;
use crate::multibody::workspace::{Node, Workspace};
use nalgebra::{Matrix3, Vector3};

/// An element with shear.
#[derive(Debug, Clone)]
pub(super) struct ShearedElement {
    element: usize,
    /// Index of its first strain.
    first: usize,
    /// Node at its inner end; the next one is at the outer end.
    node: usize,
    /// Body.
    body: usize,
    /// Slope of the axis at both ends, root frame.
    slopes: [Timed; 2],
    /// Forces on the nodal vectors `(r, d, r_y, r_z)` of both ends.
    forces: [Four; 2],
    /// Derivatives of the forces on the strains (rows) by the strains, for a constant wrench at the outer end.
    by_strains: StrainMatrix<SHEARED>,
}

/// Columns of an element with shear, resolved on its inner node.
pub(super) fn columns(element: &Element, motion: Motion, node: &Node, second: &Matrix3<f64>) -> [Column; SHEARED] {
    let strains: [Moving; SHEARED] = std::array::from_fn(|i| {
        let c = element.coordinate + i;
        Moving([motion.q[c], motion.v[c], motion.a[c]])
    });
    let JetSlopes { tangent, slope_m } = jet_link::sheared_slopes(element.length_m, &strains);
    let mut columns = [Column::ZERO; SHEARED];
    for (k, strain) in LINEAR.into_iter().enumerate() {
        columns[strain].linear = turned(node, second, orders(&tangent[k], element.length_m));
    }
    for (j, column) in columns[TWIST..TWIST + 3].iter_mut().enumerate() {
        column.linear = turned(node, second, orders(&slope_m[j], element.length_m));
        column.angular = turned(node, second, orders(&tangent[j], element.length_m));
    }
    columns
}

/// Derivatives of the forces on the strains by the strains, for a constant wrench in the frame of the inner node.
fn by_strains(element: &Element, q: &[f64], force: &Vector3<f64>, moment: &Vector3<f64>) -> StrainMatrix<SHEARED> {
    let strains: [Partial<SHEARED>; SHEARED] = std::array::from_fn(|i| Partial::along(q[element.coordinate + i], i));
    let JetSlopes { tangent, slope_m } = jet_link::sheared_slopes(element.length_m, &strains);
    let along = |column: &Vector<Partial<SHEARED>>, vector: &Vector3<f64>| {
        column[0].times(vector.x) + column[1].times(vector.y) + column[2].times(vector.z)
    };
    let mut rows = [Partial::<SHEARED>::ZERO; SHEARED];
    for (k, strain) in LINEAR.into_iter().enumerate() {
        rows[strain] = along(&tangent[k], force);
    }
    for j in 0..3 {
        rows[TWIST + j] = along(&slope_m[j], force) + along(&tangent[j], moment);
    }
    StrainMatrix::from_fn(|i, j| element.length_m * rows[i].by[j])
}

impl ShearedElement {
    /// The elements with shear of a model.
    pub fn of_model(model: &Model) -> Vec<Self> {
        let of = |(index, body): (usize, &crate::multibody::model::Body)| {
            let count = if body.sheared { body.elements } else { 0 };
            let (node, element) = (body.first_node, body.first_element);
            (0..count).map(move |i| (index, node + i, element + i)).collect::<Vec<_>>()
        };
        let places = model.bodies.iter().enumerate().flat_map(of);
        let element = |(body, node, element)| Self {
            element,
            first: model.elements[element].coordinate,
            node,
            body,
            slopes: [STILL; 2],
            forces: [NONE; 2],
            by_strains: StrainMatrix::zeros(),
        };
        places.map(element).collect()
    }

    /// Linearises the element at the motions and wrenches in `work`.
    pub fn prepare(&mut self, model: &Model, work: &Workspace, motion: Motion, spots: &[Spot]) {
        let element = &model.elements[self.element];
        let slopes = &work.slopes[self.element];
        let nodes = [&work.nodes[self.node], &work.nodes[self.node + 1]];
        self.forces = slope::forces::<false>(element, &std::array::from_fn(|end| slopes[end].load_rates(nodes[end])));
        for end in 0..2 {
            self.slopes[end] = STILL;
            let axes = &spots[self.node + end].axes;
            for (k, strain) in LINEAR.into_iter().enumerate() {
                let c = element.coordinate + strain;
                let natural = if strain == STRETCH { 1.0 } else { 0.0 };
                add_part(&mut self.slopes[end], &axes[k], [natural + motion.q[c], motion.v[c], motion.a[c]]);
            }
        }
        let outer = nodes[1];
        let local = |vector: &Vector3<f64>| nodes[0].rotation.tr_mul(vector);
        self.by_strains = by_strains(element, motion.q, &local(&outer.force), &local(&outer.moment));
    }

    /// Adds the variations of the wrenches on both nodes and of the forces on the strains.
    pub fn forward(
        &self,
        model: &Model,
        (spots, alphas, field): (&[Spot], &[f64], &Field),
        along: Motion,
        shifts: &[Shift],
        wrenches: &mut [[Vector3<f64>; 2]],
        sum: &mut [f64],
    ) {
        let element = &model.elements[self.element];
        let alpha = alphas[self.body];
        let mut loads = [NONE; 2];
        let mut moved = [STILL; 2];
        for end in 0..2 {
            let n = self.node + end;
            loads[end] = spots[n].loads(&shifts[n], field, alpha);
            let turning = Shift { linear: STILL, angular: shifts[n].angular };
            moved[end] = turning.carried(&self.slopes[end]).linear;
            for (k, strain) in LINEAR.into_iter().enumerate() {
                let c = self.first + strain;
                add_part(&mut moved[end], &spots[n].axes[k], [along.q[c], along.v[c], along.a[c]]);
            }
            loads[end][1] = field.load(&moved[end], alpha);
        }
        let changes = slope::forces::<false>(element, &loads);
        for end in 0..2 {
            let n = self.node + end;
            let (turn, axes) = (&shifts[n].angular[0], &spots[n].axes);
            let (own, change) = (&self.forces[end], &changes[end]);
            let [force, moment] = &mut wrenches[n];
            *force += change[0];
            *moment += moved[end][0].cross(&own[1]) + self.slopes[end][0].cross(&change[1]);
            for k in 1..3 {
                *moment += turn.cross(&axes[k][0]).cross(&own[k + 1]) + axes[k][0].cross(&change[k + 1]);
            }
            for (k, strain) in LINEAR.into_iter().enumerate() {
                sum[self.first + strain] += turn.cross(&axes[k][0]).dot(&own[1]) + axes[k][0].dot(&change[1]);
            }
        }
        let own = self.by_strains * Strain::<SHEARED>::from(strains_at(along.q, self.first));
        sum[self.first..self.first + SHEARED].iter_mut().zip(&own).for_each(|(sum, own)| *sum += own);
    }

    /// The transpose of [`Self::forward`].
    pub fn reverse(
        &self,
        model: &Model,
        (spots, alphas, field): (&[Spot], &[f64], &Field),
        (on, w): (&[[Vector3<f64>; 2]], &[f64]),
        sums: &mut [Shift],
        [by_q, by_v, by_a]: [&mut [f64]; 3],
    ) {
        let element = &model.elements[self.element];
        let alpha = alphas[self.body];
        let own = self.by_strains.tr_mul(&Strain::<SHEARED>::from(strains_at(w, self.first)));
        by_q[self.first..self.first + SHEARED].iter_mut().zip(&own).for_each(|(sum, own)| *sum += own);
        let on_forces: [Four; 2] = std::array::from_fn(|end| {
            let n = self.node + end;
            let ([force, moment], axes) = (&on[n], &spots[n].axes);
            let mut on_slope = moment.cross(&self.slopes[end][0]);
            for (k, strain) in LINEAR.into_iter().enumerate() {
                on_slope += axes[k][0] * w[self.first + strain];
            }
            [*force, on_slope, moment.cross(&axes[1][0]), moment.cross(&axes[2][0])]
        });
        let on_loads = slope::forces::<false>(element, &on_forces);
        for (end, mut rest) in on_loads.into_iter().enumerate() {
            let n = self.node + end;
            let (axes, forces, moment) = (&spots[n].axes, &self.forces[end], &on[n][1]);
            let mut on_slope = field.pulled(&rest[1], alpha);
            on_slope[0] += forces[1].cross(moment);
            rest[1] = Vector3::zeros();
            spots[n].add_loads(&rest, field, alpha, &mut sums[n]);
            let mut turning = Shift::ZERO;
            turning.add_carried(&Shift { linear: on_slope, angular: STILL }, &self.slopes[end]);
            sums[n].angular.iter_mut().zip(&turning.angular).for_each(|(sum, on)| *sum += on);
            let mut on_turn = Vector3::zeros();
            for k in 1..3 {
                let (axis, force) = (&axes[k][0], &forces[k + 1]);
                on_turn += force * moment.dot(axis) - moment * axis.dot(force);
            }
            for (k, strain) in LINEAR.into_iter().enumerate() {
                let c = self.first + strain;
                on_turn += axes[k][0].cross(&forces[1]) * w[c];
                let [x, x1, x2] = pulled_part(&axes[k], &on_slope);
                by_q[c] += x;
                by_v[c] += x1;
                by_a[c] += x2;
            }
            sums[n].angular[0] += on_turn;
        }
    }
}
