//! Nodes at the point of linearisation: their axes, the variations of `L` of the nodal vectors, and the forces of beams, NOTATION eq. (X3).

use crate::load::RootMotion;
use crate::math::so3::hat;
use crate::multibody::derivative::chain::{STILL, Shift, Timed, fixed, second};
use crate::multibody::dynamics::beam_force;
use crate::multibody::model::{Body, Model};
use crate::multibody::workspace::Node;
use nalgebra::{Matrix3, Vector3};

/// The four nodal vectors, their rates, or the forces on them.
pub(super) type Four = [Vector3<f64>; 4];

pub(super) const NONE: Four = [Vector3::new(0.0, 0.0, 0.0); 4];

/// The root's motion in the form required for the nodal vectors.
#[derive(Debug, Clone, Copy)]
pub(super) struct Field {
    pub rotates: bool,
    /// Matrix of the Coriolis acceleration, `2 [Ω]×`.
    coriolis: Matrix3<f64>,
    /// Matrix of the Euler and centrifugal accelerations, `[Ω̇]× + [Ω]×²`.
    frame: Matrix3<f64>,
}

impl Field {
    pub fn of(root: &RootMotion) -> Self {
        let turn = hat(&root.angular_velocity_rad_s);
        Self {
            rotates: root.rotates(),
            coriolis: turn * 2.0,
            frame: hat(&root.angular_acceleration_rad_s2) + turn * turn,
        }
    }

    /// `L` of a vector with two time derivatives.
    #[inline(always)]
    pub fn load(&self, [e, e1, e2]: &Timed, alpha: f64) -> Vector3<f64> {
        let own = e2 + e1 * alpha;
        if self.rotates { own + self.coriolis * e1 + self.frame * e } else { own }
    }

    /// Multipliers of the vector and its derivatives, from those of `L`.
    #[inline(always)]
    pub fn pulled(&self, on: &Vector3<f64>, alpha: f64) -> Timed {
        if self.rotates {
            [self.frame.tr_mul(on), on * alpha + self.coriolis.tr_mul(on), *on]
        } else {
            [Vector3::zeros(), on * alpha, *on]
        }
    }
}

/// A node at the point of linearisation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    /// `[ω̇]× + [ω]×²`, see [`second`].
    pub second: Matrix3<f64>,
    /// Axes of the node in the root frame.
    pub axes: [Timed; 3],
    /// `2 ṙ + α r` and `r̈ + α ṙ` of each axis `r`, if the root does not rotate: in the variation of its `L`, the factors of the rate of
    /// the rotation and of the rotation.
    pub damped: [[Vector3<f64>; 2]; 3],
    /// `Σ r_k f_kᵀ − Σ r_k·f_k I` of the forces on the axes: derivative of the moment with respect to a rotation of these.
    pub by_turn: Matrix3<f64>,
}

impl Spot {
    pub const ZERO: Self = {
        let zero = Matrix3::from_array_storage(nalgebra::ArrayStorage([[0.0; 3]; 3]));
        Self { second: zero, axes: [STILL; 3], damped: [[Vector3::new(0.0, 0.0, 0.0); 2]; 3], by_turn: zero }
    };

    /// At a node, with the mass-proportional damping of its body.
    #[inline(always)]
    pub fn of(node: &Node, alpha: f64) -> Self {
        let second = second(node);
        let axis = |k: usize| fixed(node, &second, node.rotation.column(k).into_owned());
        let axes = [axis(0), axis(1), axis(2)];
        let damped = axes.map(|[r, r1, r2]| [r1 * 2.0 + r * alpha, r2 + r1 * alpha]);
        Self { second, axes, damped, by_turn: Matrix3::zeros() }
    }

    /// Stores the derivative, with respect to a rotation of the axes, of the moment of the forces on them.
    pub fn set_forces(&mut self, forces: &Four) {
        let mut by_turn = Matrix3::zeros();
        for (axis, force) in self.axes.iter().zip(&forces[1..]) {
            by_turn += axis[0] * force.transpose();
        }
        self.by_turn = by_turn - Matrix3::from_diagonal_element(by_turn.trace());
    }

    /// Variation of `L` for the nodal vectors.
    #[inline(always)]
    pub fn loads(&self, shift: &Shift, field: &Field, alpha: f64) -> Four {
        let turning = Shift { linear: STILL, angular: shift.angular };
        let mut loads = [field.load(&shift.linear, alpha); 4];
        for (load, axis) in loads[1..].iter_mut().zip(&self.axes) {
            *load = field.load(&turning.carried(axis).linear, alpha);
        }
        loads
    }

    /// Adds the multipliers of a shift from those of `L`: the transpose of [`Spot::loads`].
    #[inline(always)]
    pub fn add_loads(&self, on: &Four, field: &Field, alpha: f64, sum: &mut Shift) {
        let origin = field.pulled(&on[0], alpha);
        sum.linear.iter_mut().zip(&origin).for_each(|(sum, on)| *sum += on);
        let mut turning = Shift::ZERO;
        for (axis, on) in self.axes.iter().zip(&on[1..]) {
            turning.add_carried(&Shift { linear: field.pulled(on, alpha), angular: STILL }, axis);
        }
        sum.angular.iter_mut().zip(&turning.angular).for_each(|(sum, on)| *sum += on);
    }

    /// [`Spot::loads`] with the damping of the body, in a root that does not rotate.
    #[inline(always)]
    pub fn own_loads(&self, shift: &Shift, alpha: f64) -> Four {
        let [_, e1, e2] = &shift.linear;
        let [turn, turn1, turn2] = &shift.angular;
        let mut loads = [e2 + e1 * alpha; 4];
        for ((load, axis), [by_rate, by_turn]) in loads[1..].iter_mut().zip(&self.axes).zip(&self.damped) {
            *load = turn2.cross(&axis[0]) + turn1.cross(by_rate) + turn.cross(by_turn);
        }
        loads
    }

    /// The transpose of [`Spot::own_loads`].
    #[inline(always)]
    pub fn add_own_loads(&self, on: &Four, alpha: f64, sum: &mut Shift) {
        sum.linear[1] += on[0] * alpha;
        sum.linear[2] += on[0];
        let [turn, turn1, turn2] = &mut sum.angular;
        for ((on, axis), [by_rate, by_turn]) in on[1..].iter().zip(&self.axes).zip(&self.damped) {
            *turn2 += axis[0].cross(on);
            *turn1 += by_rate.cross(on);
            *turn += by_turn.cross(on);
        }
    }

    /// Variation of the wrench of the forces on the nodal vectors, whose variations are `change`.
    #[inline(always)]
    pub fn wrench(&self, turn: &Vector3<f64>, change: &Four) -> [Vector3<f64>; 2] {
        let moment = |k: usize| self.axes[k][0].cross(&change[k + 1]);
        [change[0], moment(0) + moment(1) + moment(2) + self.by_turn * turn]
    }

    /// Multipliers of the forces on the nodal vectors, from those of their wrench.
    #[inline(always)]
    pub fn pulled(&self, [force, moment]: &[Vector3<f64>; 2]) -> Four {
        let on = |k: usize| moment.cross(&self.axes[k][0]);
        [*force, on(0), on(1), on(2)]
    }
}

/// Forces on the nodal vectors of a body due to the loads `L` of its beam, eq. (D5): symmetric, so that it is its own transpose.
pub(super) fn beam_forces(model: &Model, body: &Body, loads: &[Four], forces: &mut [Four]) {
    if body.sheared || body.modal.is_some() {
        // the masses of its beam belong to elements, or lie between its ends
        forces.fill(NONE);
        return;
    }
    let load = |i: usize| &loads[i];
    for (i, forces) in forces.iter_mut().enumerate() {
        *forces = match body.slim_mass {
            true => beam_force::<true>(model, body, i, load),
            false => beam_force::<false>(model, body, i, load),
        };
    }
}
