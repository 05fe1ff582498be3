//! Modal bodies in the tangent: a block in their coordinates and the twist of their first node, NOTATION eq. (M12).
//!
//! Forces are projected on the coordinates with the partial velocities of positions and attitudes, and the partial velocities change with
//! the coordinates, because of the shortening and of the rotating attitude.

use crate::beam::modal::{ModalElement, ShapesAt};
use crate::load::{LoadFrame, Wrench};
use crate::math::so3::hat;
use crate::multibody::modal::{Modal, ModalWork};
use crate::multibody::tangent::block::{Block, UNKNOWNS, Unknowns, turned};
use crate::multibody::workspace::Node;
use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3, Vector6};

type Columns = SMatrix<f64, 6, UNKNOWNS>;

/// The tangent of a modal body at its pose.
#[derive(Debug, Clone)]
pub(super) struct ModalTangent {
    /// Index of its first coordinate.
    pub coordinate: usize,
    /// Number of its coordinates.
    pub modes: usize,
    /// Partial velocities of the outer end: its twist per coordinate.
    pub partial: Columns,
    /// Vector from the first node to the outer end, m.
    arm: Vector3<f64>,
    /// Part of the block that does not depend on the tangent of the outer end.
    own: Block,
    /// Magnitudes of the pivots for scaling: the stiffnesses.
    pub sizes: [f64; UNKNOWNS],
}

/// A point of the body with a load or mass.
struct Place<'a> {
    partial: &'a Columns,
    arm: Vector3<f64>,
}

/// A wrench at a point, root frame, with the sign of the residual.
struct Acting<'a> {
    force: Vector3<f64>,
    moment: Vector3<f64>,
    element: &'a ModalElement,
    shapes: &'a ShapesAt,
    /// Coordinates of the body.
    q: &'a [f64],
    /// Frame of the first node.
    axes: &'a Matrix3<f64>,
}

impl ModalTangent {
    /// Linearises at the pose in `work`, with the wrench on the outer end. `frame` maps positions to accelerations.
    pub fn new(modal: &Modal, work: &ModalWork, [inner, outer]: [&Node; 2], frame: &Matrix3<f64>) -> Self {
        let (element, modes) = (&modal.element, modal.element.modes);
        let q = &work.q[..modes];
        let axes = &inner.rotation;
        let mut partial = Columns::zeros();
        for i in 0..modes {
            partial.fixed_view_mut::<3, 1>(0, i).copy_from(&work.velocity[i]);
            partial.fixed_view_mut::<3, 1>(3, i).copy_from(&work.spin[i]);
        }
        let mut own = Block::zeros();
        let mut sizes = [1.0; UNKNOWNS];
        for (i, size) in sizes.iter_mut().enumerate().take(modes) {
            *size = element.stiffness[(i, i)];
            for j in 0..modes {
                own.xx[(i, j)] = element.stiffness[(i, j)];
            }
        }
        let tip = Acting { force: outer.force, moment: outer.moment, element, shapes: &element.tip, q, axes };
        Place { partial: &partial, arm: work.arm }.add_geometry(&tip, &mut own);
        for point in &element.masses {
            let shapes = &point.shapes;
            let shortened = shapes.shortened(q);
            let arm = axes * shapes.position_m(q, &shortened);
            let mut columns = Columns::zeros();
            for i in 0..modes {
                columns.fixed_view_mut::<3, 1>(0, i).copy_from(&(axes * shapes.velocity(i, &shortened)));
            }
            let local = axes.transpose() * arm;
            let rates = &inner.load_rate;
            let force = (rates[0] + rates[1] * local.x + rates[2] * local.y + rates[3] * local.z) * point.mass_kg;
            let place = Place { partial: &columns, arm };
            place.add_geometry(&Acting { force, moment: Vector3::zeros(), element, shapes, q, axes }, &mut own);
            if *frame != Matrix3::zeros() {
                let mut outer = Matrix6::zeros();
                outer.fixed_view_mut::<3, 3>(0, 0).copy_from(&(frame * point.mass_kg));
                place.add_outer(&outer, &mut own);
            }
        }
        Self { coordinate: modal.coordinate, modes, partial, arm: work.arm, own, sizes }
    }

    /// Adds a load at a position on the body.
    pub fn add_load(
        &mut self,
        modal: &Modal,
        work: &ModalWork,
        node: &Node,
        place_m: f64,
        (load, frame): (&Wrench, LoadFrame),
    ) {
        let q = &work.q[..self.modes];
        let mut own_shapes = None;
        let place = modal.place(node, q, modal.element.shapes(place_m, &mut own_shapes));
        let mut partial = Columns::zeros();
        for i in 0..self.modes {
            let (velocity, spin) = place.partial(node, i);
            partial.fixed_view_mut::<3, 1>(0, i).copy_from(&velocity);
            partial.fixed_view_mut::<3, 1>(3, i).copy_from(&spin);
        }
        let (force, moment) = turned(load, frame, &place.rotation(node));
        let here = Place { partial: &partial, arm: place.arm };
        // loads have a negative sign in the residual
        let acting = Acting {
            force: -force,
            moment: -moment,
            element: &modal.element,
            shapes: place.shapes,
            q,
            axes: &node.rotation,
        };
        here.add_geometry(&acting, &mut self.own);
        if frame == LoadFrame::Section {
            here.add_outer(&super::follower(&force, &moment), &mut self.own);
        }
    }

    /// `Φ`: twist of the outer end per twist of the first node.
    fn shift(&self) -> Matrix6<f64> {
        shift(&self.arm)
    }

    /// Reads the body's coordinates from a vector.
    pub fn read(&self, x: &[f64]) -> Unknowns {
        let mut part = Unknowns::<UNKNOWNS>::zeros();
        part.as_mut_slice()[..self.modes].copy_from_slice(&x[self.coordinate..self.coordinate + self.modes]);
        part
    }

    /// Twist of the outer end due to changes of the coordinates and the twist of the first node.
    pub fn displaced(&self, x: &[f64], inner: &Vector6<f64>) -> Vector6<f64> {
        self.shift() * inner + self.partial * self.read(x)
    }

    /// Adds the changes of the forces on the coordinates to `y`; returns the change of the wrench on the first node, for changes of the
    /// coordinates, of the first node's twist and of the wrench at the outer end.
    pub fn push(&self, x: &[f64], inner: &Vector6<f64>, outer: &Vector6<f64>, y: &mut [f64]) -> Vector6<f64> {
        let own = self.read(x);
        let forces = self.own.xx * own + self.own.xa * inner + self.partial.transpose() * outer;
        for k in 0..self.modes {
            y[self.coordinate + k] += forces[k];
        }
        self.own.ax * own + self.own.aa * inner + self.carried(outer)
    }

    /// `Φᵀ` applied to a wrench.
    pub fn carried(&self, wrench: &Vector6<f64>) -> Vector6<f64> {
        self.shift().transpose() * wrench
    }

    /// The block with the tangent of the outer end.
    pub fn block(&self, outer: &Matrix6<f64>) -> Block {
        let mut block = self.own.clone();
        Place { partial: &self.partial, arm: self.arm }.add_outer(outer, &mut block);
        block
    }
}

impl Place<'_> {
    /// Adds the contribution of a wrench that is constant in the root frame.
    fn add_geometry(&self, acting: &Acting, block: &mut Block) {
        let Acting { force, moment, element, shapes, q, axes } = acting;
        let along = axes.column(0).dot(force);
        let (moment_inside, turn) = (axes.tr_mul(moment), element.turn(shapes.angles_rad(q)));
        for j in 0..q.len() {
            for i in 0..q.len() {
                let bent = turn.spin_along(&shapes.angles_1_m(i), &shapes.angles_1_m(j));
                block.xx[(i, j)] += bent.dot(&moment_inside) - along * shapes.shortening_1_m[i][j];
            }
        }
        for i in 0..q.len() {
            let (velocity, spin) = halves(self.partial, i);
            // the partial velocities rotate with the first node
            let turning = velocity.cross(force) + spin.cross(moment);
            let arm = velocity.cross(force);
            for k in 0..3 {
                block.xa[(i, 3 + k)] += turning[k];
                block.ax[(3 + k, i)] += arm[k];
            }
        }
        let mut spin = block.aa.fixed_view_mut::<3, 3>(3, 3);
        spin += hat(force) * hat(&self.arm);
    }

    /// Adds the contribution of a wrench that changes by `outer` with the twist of its position.
    fn add_outer(&self, outer: &Matrix6<f64>, block: &mut Block) {
        let shift = shift(&self.arm);
        let (rows, columns) = (outer * self.partial, outer * shift);
        block.xx += self.partial.transpose() * rows;
        block.xa += self.partial.transpose() * columns;
        block.ax += shift.transpose() * rows;
        block.aa += shift.transpose() * columns;
    }
}

fn shift(arm: &Vector3<f64>) -> Matrix6<f64> {
    let mut shift = Matrix6::identity();
    shift.fixed_view_mut::<3, 3>(0, 3).copy_from(&-hat(arm));
    shift
}

fn halves(columns: &Columns, i: usize) -> (Vector3<f64>, Vector3<f64>) {
    (columns.fixed_view::<3, 1>(0, i).into_owned(), columns.fixed_view::<3, 1>(3, i).into_owned())
}
