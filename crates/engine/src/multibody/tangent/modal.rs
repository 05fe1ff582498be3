//! Modal bodies in the tangent: a block over their coordinates and the twist of their first node, NOTATION eq. (M12).
//!
//! Forces are projected on the coordinates with the partial velocities of \[E\]; attitudes change with the coordinates
//! by the derivative of the small rotation itself. The two differ in second order of the slopes, so this part of the
//! tangent is not symmetric.

use crate::beam::modal::{MAXIMUM_MODES, small_turn_slope};
use crate::load::{LoadFrame, Wrench};
use crate::math::so3::hat;
use crate::multibody::modal::{Modal, ModalWork};
use crate::multibody::tangent::block::{Block, turned};
use crate::multibody::workspace::Node;
use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3, Vector6};

type Columns = SMatrix<f64, 6, MAXIMUM_MODES>;

/// The tangent of a modal body at its pose.
#[derive(Debug, Clone)]
pub(super) struct ModalTangent {
    /// Index of its first coordinate.
    pub coordinate: usize,
    /// Number of its coordinates.
    pub modes: usize,
    /// Partial velocities of the outer end.
    pub partial: Columns,
    /// Twist of the outer end per coordinate.
    pub moved: Columns,
    /// From the first node to the outer end, m.
    arm: Vector3<f64>,
    /// The part that does not depend on the tangent of the outer end.
    own: Block,
    /// Scales of the pivots: the stiffnesses.
    pub sizes: [f64; 8],
}

/// A wrench at a place of the body, and what it needs: share of the residual.
struct Acting<'a> {
    partial: &'a Columns,
    moved: &'a Columns,
    arm: Vector3<f64>,
    /// Force in the root frame.
    force: Vector3<f64>,
    /// Moment in the root frame.
    moment: Vector3<f64>,
    /// `S_ij` of the place: change of the partial velocities along the axis.
    shortening_1_m: &'a [[f64; MAXIMUM_MODES]; MAXIMUM_MODES],
    /// Direction of the axis of the first node.
    axis: Vector3<f64>,
}

impl ModalTangent {
    /// At the pose in `work`, with the wrench that acts on the outer end. `frame` gives accelerations from places.
    pub fn new(modal: &Modal, work: &ModalWork, [inner, outer]: [&Node; 2], frame: &Matrix3<f64>) -> Self {
        let (element, modes) = (&modal.element, modal.element.modes);
        let q = &work.q[..modes];
        let axes = &inner.rotation;
        let axis = axes.column(0).into_owned();
        let (mut partial, mut moved) = (Columns::zeros(), Columns::zeros());
        let slope = axes * small_turn_slope(&element.tip.angles_rad(q));
        for i in 0..modes {
            partial.fixed_view_mut::<3, 1>(0, i).copy_from(&work.velocity[i]);
            partial.fixed_view_mut::<3, 1>(3, i).copy_from(&work.spin[i]);
            moved.fixed_view_mut::<3, 1>(0, i).copy_from(&work.velocity[i]);
            moved.fixed_view_mut::<3, 1>(3, i).copy_from(&(slope * element.tip.spin_1_m(i)));
        }
        let mut own = Block::zeros();
        let mut sizes = [1.0; 8];
        for (i, size) in sizes.iter_mut().enumerate().take(modes) {
            *size = element.stiffness[(i, i)];
            for j in 0..modes {
                own.xx[(i, j)] = element.stiffness[(i, j)];
            }
        }
        let tip = Acting {
            partial: &partial,
            moved: &moved,
            arm: work.arm,
            force: outer.force,
            moment: outer.moment,
            shortening_1_m: &element.tip.shortening_1_m,
            axis,
        };
        tip.add_geometry(&mut own);
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
            let acting = Acting {
                partial: &columns,
                moved: &columns,
                arm,
                force,
                moment: Vector3::zeros(),
                shortening_1_m: &shapes.shortening_1_m,
                axis,
            };
            acting.add_geometry(&mut own);
            if *frame != Matrix3::zeros() {
                let mut outer = Matrix6::zeros();
                outer.fixed_view_mut::<3, 3>(0, 0).copy_from(&(frame * point.mass_kg));
                acting.add_outer(&outer, &mut own);
            }
        }
        Self { coordinate: modal.coordinate, modes, partial, moved, arm: work.arm, own, sizes }
    }

    /// Adds a load at a place of the body.
    pub fn add_load(
        &mut self,
        modal: &Modal,
        work: &ModalWork,
        node: &Node,
        place_m: f64,
        (load, frame): (&Wrench, LoadFrame),
    ) {
        let place = modal.place(node, &work.q[..self.modes], place_m);
        let (mut partial, mut moved) = (Columns::zeros(), Columns::zeros());
        let slope = node.rotation * small_turn_slope(&place.shapes.angles_rad(&work.q[..self.modes]));
        for i in 0..self.modes {
            let (velocity, spin) = place.partial(node, i);
            partial.fixed_view_mut::<3, 1>(0, i).copy_from(&velocity);
            partial.fixed_view_mut::<3, 1>(3, i).copy_from(&spin);
            moved.fixed_view_mut::<3, 1>(0, i).copy_from(&velocity);
            moved.fixed_view_mut::<3, 1>(3, i).copy_from(&(slope * place.shapes.spin_1_m(i)));
        }
        let (force, moment) = turned(load, frame, &place.rotation);
        let acting = Acting {
            partial: &partial,
            moved: &moved,
            arm: place.arm,
            // loads enter with a negative sign
            force: -force,
            moment: -moment,
            shortening_1_m: &place.shapes.shortening_1_m,
            axis: node.rotation.column(0).into_owned(),
        };
        acting.add_geometry(&mut self.own);
        if frame == LoadFrame::Section {
            acting.add_outer(&super::follower(&force, &moment), &mut self.own);
        }
    }

    /// `Φ`: twist of the outer end per twist of the first node.
    fn shift(&self) -> Matrix6<f64> {
        shift(&self.arm)
    }

    /// The body's coordinates in a vector.
    pub fn read(&self, x: &[f64]) -> SMatrix<f64, 8, 1> {
        let mut part = SMatrix::<f64, 8, 1>::zeros();
        part.as_mut_slice()[..self.modes].copy_from_slice(&x[self.coordinate..self.coordinate + self.modes]);
        part
    }

    /// Twist of the outer end.
    pub fn displaced(&self, x: &[f64], inner: &Vector6<f64>) -> Vector6<f64> {
        self.shift() * inner + self.moved * self.read(x)
    }

    /// Adds the changes of the forces on the coordinates to `y`; returns the change of the wrench of the first node,
    /// for changes of the coordinates, of the first node's twist and of the wrench at the outer end.
    pub fn push(&self, x: &[f64], inner: &Vector6<f64>, outer: &Vector6<f64>, y: &mut [f64]) -> Vector6<f64> {
        let own = self.read(x);
        let forces = self.own.xx * own + self.own.xa * inner + self.partial.transpose() * outer;
        for k in 0..self.modes {
            y[self.coordinate + k] += forces[k];
        }
        self.own.ax * own + self.own.aa * inner + self.carried(outer)
    }

    /// `Φᵀ` on a wrench.
    pub fn carried(&self, wrench: &Vector6<f64>) -> Vector6<f64> {
        self.shift().transpose() * wrench
    }

    /// The block with the tangent of the outer end.
    pub fn block(&self, outer: &Matrix6<f64>) -> Block {
        let mut block = self.own.clone();
        let acting = Acting {
            partial: &self.partial,
            moved: &self.moved,
            arm: self.arm,
            force: Vector3::zeros(),
            moment: Vector3::zeros(),
            shortening_1_m: &[[0.0; MAXIMUM_MODES]; MAXIMUM_MODES],
            axis: Vector3::zeros(),
        };
        acting.add_outer(outer, &mut block);
        block
    }
}

impl Acting<'_> {
    /// A wrench that does not change with the pose.
    fn add_geometry(&self, block: &mut Block) {
        let along = self.axis.dot(&self.force);
        for i in 0..MAXIMUM_MODES {
            for j in 0..MAXIMUM_MODES {
                block.xx[(i, j)] -= along * self.shortening_1_m[i][j];
            }
            let (velocity, spin) = halves(self.partial, i);
            // the partial velocities turn with the first node
            let turning = velocity.cross(&self.force) + spin.cross(&self.moment);
            for k in 0..3 {
                block.xa[(i, 3 + k)] += turning[k];
            }
            let arm = halves(self.moved, i).0.cross(&self.force);
            for k in 0..3 {
                block.ax[(3 + k, i)] += arm[k];
            }
        }
        let mut spin = block.aa.fixed_view_mut::<3, 3>(3, 3);
        spin += hat(&self.force) * hat(&self.arm);
    }

    /// A wrench that changes by `outer` with the twist of its place.
    fn add_outer(&self, outer: &Matrix6<f64>, block: &mut Block) {
        let shift = shift(&self.arm);
        let (rows, columns) = (outer * self.moved, outer * shift);
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
