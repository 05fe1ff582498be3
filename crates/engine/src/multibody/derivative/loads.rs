//! Variations of loads at stations, NOTATION eq. (X3): dead loads in the root frame and follower loads in the section frame.

use crate::beam::modal::MAXIMUM_MODES;
use crate::load::{LoadFrame, Wrench};
use crate::math::jet::{Jet, Partial, Vector, cross, plus, three, turned};
use crate::math::jet_link::pose;
use crate::math::strain::{SHEARED, STRAINS};
use crate::multibody::Model;
use crate::multibody::derivative::chain::Shift;
use crate::multibody::derivative::link;
use crate::multibody::modal::Modal;
use crate::multibody::model::Station;
use crate::multibody::station::{first_coordinate, inner_node, node_under, sibling, steps};
use crate::multibody::workspace::Node;
use nalgebra::Vector3;

/// Number of strains, or of shapes, on which a station may depend: those of a pair, or of a modal body.
const BOTH: usize = 2 * SHEARED;
const _: () = assert!(MAXIMUM_MODES <= BOTH);

/// A load on a section inside an element at the point of linearisation, root frame; without strains, a load on a node.
#[derive(Debug, Clone, Copy)]
pub(super) struct LoadedSection {
    node: usize,
    first: usize,
    strains: usize,
    frame: LoadFrame,
    /// The load with the negative sign that it has in the residual.
    force: Vector3<f64>,
    moment: Vector3<f64>,
    /// Vector from the node to the section in m.
    arm: Vector3<f64>,
    /// Displacement and rotation of the section per unit of each strain.
    columns: [[Vector3<f64>; 2]; BOTH],
    /// Derivatives of the forces on the strains with respect to a rotation of the node.
    turned: [Vector3<f64>; BOTH],
    /// Derivatives of the forces on the strains (rows) with respect to the strains, for a constant load.
    slopes: [[f64; BOTH]; BOTH],
}

impl LoadedSection {
    /// A load at the poses of the last sweep.
    pub fn new(model: &Model, nodes: &[Node], q: &[f64], station: &Station, load: &Wrench) -> Self {
        if let Some(node) = node_under(model, station) {
            return Self::on_node(node, nodes, station.frame, load);
        }
        if let Some(modal) = &model.bodies[station.body].modal {
            return Self::on_shapes(modal, (inner_node(model, station), nodes), q, station, load);
        }
        match model.bodies[station.body].sheared {
            false => Self::in_element::<STRAINS, { 2 * STRAINS }>(model, nodes, q, station, load),
            true => Self::in_element::<SHEARED, { 2 * SHEARED }>(model, nodes, q, station, load),
        }
    }

    /// A load inside an element with `N` strains, or inside a pair of these with `P`.
    fn in_element<const N: usize, const P: usize>(
        model: &Model,
        nodes: &[Node],
        q: &[f64],
        station: &Station,
        load: &Wrench,
    ) -> Self {
        let (node, first) = (inner_node(model, station), first_coordinate(model, station));
        let (steps, count) = steps(model, station);
        let strains = if steps[0].weights[1] == 0.0 { N } else { P };
        let coordinate = |i: usize| match i < strains {
            true => Partial::<P>::along(q[first + i], i),
            false => Partial::ZERO,
        };
        let mixed = |step: usize| -> [Partial<P>; N] {
            let [own, other] = steps[step].weights;
            std::array::from_fn(|i| coordinate(i).times(own) + coordinate(sibling::<N>(i)).times(other))
        };
        let rotation = nodes[node].rotation;
        // poses along the path in the frame of the node
        let unit: [Vector<Partial<P>>; 3] = three(|j| three(|i| Partial::constant(if i == j { 1.0 } else { 0.0 })));
        let mut path = [([Partial::ZERO; 3], unit); 3];
        for step in 0..count {
            let link = pose(steps[step].length_m, &mixed(step));
            let (position, axes) = &path[step];
            let next = plus(*position, turned(axes, &link.arm_m));
            path[step + 1] = (next, three(|j| turned(axes, &link.rotation[j])));
        }
        let (position, axes) = &path[count];
        let mut columns = [[Vector3::zeros(); 2]; BOTH];
        for (k, column) in columns.iter_mut().enumerate().take(P) {
            let by = |vector: &Vector<Partial<P>>| Vector3::from(vector.map(|entry| entry.by[k]));
            let turn = axes.iter().fold(Vector3::zeros(), |sum, axis| sum + value(axis).cross(&by(axis)));
            *column = [rotation * by(position), rotation * turn * 0.5];
        }
        let section = rotation * nalgebra::Matrix3::from_columns(&[value(&axes[0]), value(&axes[1]), value(&axes[2])]);
        let [force, moment] = match station.frame {
            LoadFrame::Root => [-load.force_n, -load.moment_n_m],
            LoadFrame::Section => [section * -load.force_n, section * -load.moment_n_m],
        };
        let [local_force, local_moment] = [force, moment].map(|vector| rotation.tr_mul(&vector));
        let constant = |vector: &Vector3<f64>| -> Vector<Partial<P>> { three(|i| Partial::constant(vector[i])) };
        let (force_jet, mut moment_jet) = (constant(&local_force), constant(&local_moment));
        let mut slopes = [[0.0; BOTH]; BOTH];
        for step in (0..count).rev() {
            let (inner, axes) = &path[step];
            let local =
                |on: &Vector<Partial<P>>| -> Vector<Partial<P>> { three(|i| crate::math::jet::dot(&axes[i], on)) };
            let rows = link::forces(steps[step].length_m, &mixed(step), &local(&force_jet), &local(&moment_jet));
            let [own, other] = steps[step].weights;
            for (i, row) in rows.iter().enumerate() {
                let mut add = |strain: usize, weight: f64| {
                    slopes[strain].iter_mut().zip(&row.by).for_each(|(slope, by)| *slope += weight * by);
                };
                add(i, own);
                if strains == P {
                    add(sibling::<N>(i), other);
                }
            }
            let outer = path[step + 1].0;
            let arm = three(|i| outer[i] - inner[i]);
            moment_jet = plus(moment_jet, cross(arm, force_jet));
        }
        let turned = columns.map(|[linear, angular]| linear.cross(&force) + angular.cross(&moment));
        let arm = rotation * value(position);
        Self { node, first, strains, frame: station.frame, force, moment, arm, columns, turned, slopes }
    }

    /// A load between the ends of a modal body.
    fn on_shapes(modal: &Modal, (node, nodes): (usize, &[Node]), q: &[f64], station: &Station, load: &Wrench) -> Self {
        let (inner, modes) = (&nodes[node], modal.element.modes);
        let mut own = None;
        let place = modal.place(inner, &q[modal.range()], modal.element.shapes(station.offset_m, &mut own));
        let mut columns = [[Vector3::zeros(); 2]; BOTH];
        for (i, column) in columns.iter_mut().enumerate().take(modes) {
            *column = place.partial(inner, i).into();
        }
        let section = place.rotation(inner);
        let [force, moment] = match station.frame {
            LoadFrame::Root => [-load.force_n, -load.moment_n_m],
            LoadFrame::Section => [section * -load.force_n, section * -load.moment_n_m],
        };
        let [local_force, local_moment] = [force, moment].map(|vector| inner.rotation.tr_mul(&vector));
        let slope = |i: usize, j: usize| match i.max(j) < modes {
            true => place.force_slope((i, j), (&local_force, &local_moment)),
            false => 0.0,
        };
        Self {
            node,
            first: modal.coordinate,
            strains: modes,
            frame: station.frame,
            force,
            moment,
            arm: place.arm,
            columns,
            turned: columns.map(|[linear, angular]| linear.cross(&force) + angular.cross(&moment)),
            slopes: std::array::from_fn(|i| std::array::from_fn(|j| slope(i, j))),
        }
    }

    fn on_node(node: usize, nodes: &[Node], frame: LoadFrame, load: &Wrench) -> Self {
        let [force, moment] = [-load.force_n, -load.moment_n_m].map(|vector| match frame {
            LoadFrame::Root => vector,
            LoadFrame::Section => nodes[node].rotation * vector,
        });
        let zero = Vector3::zeros();
        Self {
            node,
            first: 0,
            strains: 0,
            frame,
            force,
            moment,
            arm: zero,
            columns: [[zero; 2]; BOTH],
            turned: [zero; BOTH],
            slopes: [[0.0; BOTH]; BOTH],
        }
    }

    /// Adds the variations of the load's wrench on the node and of its forces on the strains.
    pub fn forward(&self, shift: &Shift, along: &[f64], wrench: &mut [Vector3<f64>; 2], rows: &mut [f64]) {
        let turn = &shift.angular[0];
        let changes = &along[self.first..self.first + self.strains];
        let (mut moved, mut section_turn) = (turn.cross(&self.arm), *turn);
        for (change, [linear, angular]) in changes.iter().zip(&self.columns) {
            moved += linear * *change;
            section_turn += angular * *change;
        }
        let [force, moment] = match self.frame {
            LoadFrame::Root => [Vector3::zeros(); 2],
            LoadFrame::Section => [section_turn.cross(&self.force), section_turn.cross(&self.moment)],
        };
        wrench[0] += force;
        wrench[1] += moment + moved.cross(&self.force) + self.arm.cross(&force);
        for i in 0..self.strains {
            let [linear, angular] = &self.columns[i];
            let own: f64 = self.slopes[i].iter().zip(changes).map(|(slope, change)| slope * change).sum();
            rows[self.first + i] += linear.dot(&force) + angular.dot(&moment) + self.turned[i].dot(turn) + own;
        }
    }

    /// The transpose of [`Self::forward`]: adds the multipliers of the node's motion and of the strains, from those of the wrench and of
    /// the forces on the strains.
    pub fn reverse(&self, on: &[Vector3<f64>; 2], w: &[f64], sum: &mut Shift, by_q: &mut [f64]) {
        let w = match self.strains {
            0 => &[],
            strains => &w[self.first..self.first + strains],
        };
        let (mut moved, mut turn) = (on[0] + on[1].cross(&self.arm), on[1]);
        let mut by_turn = Vector3::zeros();
        for (i, w) in w.iter().enumerate() {
            let [linear, angular] = &self.columns[i];
            moved += linear * *w;
            turn += angular * *w;
            by_turn += self.turned[i] * *w;
        }
        let by_move = self.force.cross(&on[1]);
        let by_section = match self.frame {
            LoadFrame::Root => Vector3::zeros(),
            LoadFrame::Section => self.force.cross(&moved) + self.moment.cross(&turn),
        };
        sum.angular[0] += by_turn + self.arm.cross(&by_move) + by_section;
        for k in 0..self.strains {
            let [linear, angular] = &self.columns[k];
            let own: f64 = w.iter().enumerate().map(|(i, w)| w * self.slopes[i][k]).sum();
            by_q[self.first + k] += own + linear.dot(&by_move) + angular.dot(&by_section);
        }
    }

    /// Node on which the load acts.
    pub fn node(&self) -> usize {
        self.node
    }
}

fn value<const P: usize>(vector: &Vector<Partial<P>>) -> Vector3<f64> {
    Vector3::from(vector.map(|entry| entry.value))
}
