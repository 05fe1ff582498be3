//! Points along a modal body with loads or motion outputs, NOTATION eqs. (M2)–(M4) and (M7).

use super::{Modal, square};
use crate::beam::modal::{MAXIMUM_MODES, ShapesAt};
use crate::beam::small_turn::SmallTurn;
use crate::load::SectionMotion;
use crate::multibody::motion::Motion;
use crate::multibody::node::Node;
use crate::multibody::station::Accelerated;
use nalgebra::{Matrix3, Vector3};

/// A position on a modal body at given coordinates.
pub(crate) struct Place<'s> {
    pub shapes: &'s ShapesAt,
    shortened: [f64; MAXIMUM_MODES],
    turn: SmallTurn,
    /// Vector from the first node in m, root frame.
    pub arm: Vector3<f64>,
}

impl Modal {
    /// The position with some shapes ([`crate::beam::modal::ModalElement::shapes`]); `q` are the coordinates of the body.
    #[inline]
    pub(crate) fn place<'s>(&self, node: &Node, q: &[f64], shapes: &'s ShapesAt) -> Place<'s> {
        let shortened = shapes.shortened(q);
        Place {
            arm: node.rotation * shapes.position_m(q, &shortened),
            turn: self.element.turn(shapes.angles_rad(q)),
            shapes,
            shortened,
        }
    }

    /// Pose, velocity and angular velocity at a position.
    pub(crate) fn motion_at(&self, node: &Node, motion: Motion, place_m: f64) -> SectionMotion {
        let mut own = None;
        let place = self.place(node, &motion.q[self.range()], self.element.shapes(place_m, &mut own));
        let moved = place.moved(node, &motion.v[self.range()]);
        place.motion(node, moved)
    }

    /// Pose, velocities and accelerations at a position.
    pub(crate) fn accelerated_at(&self, node: &Node, motion: Motion, place_m: f64) -> Accelerated {
        let mut own = None;
        let place = self.place(node, &motion.q[self.range()], self.element.shapes(place_m, &mut own));
        let (v, a) = (&motion.v[self.range()], &motion.a[self.range()]);
        let ((velocity, spin), (second, spin_rate)) = (place.moved(node, v), place.moved(node, a));
        let drawn = -node.rotation.column(0) * square(&place.shapes.shortened(v), v);
        let angle_rates = place.shapes.angles_rad(v);
        let bent = node.rotation * place.turn.spin_along(&angle_rates, &angle_rates);
        let swing = node.spin.cross(&place.arm);
        Accelerated {
            motion: place.motion(node, (velocity, spin)),
            acceleration_m_s2: node.acceleration
                + node.spin_rate.cross(&place.arm)
                + node.spin.cross(&(swing + velocity * 2.0))
                + second
                + drawn,
            spin_rate_rad_s2: node.spin_rate + node.spin.cross(&spin) + spin_rate + bent,
        }
    }

    /// Displacement and rotation at a position due to those of the first node and a change of the body's coordinates.
    pub fn displaced_at(
        &self,
        node: &Node,
        (q, place_m): (&[f64], f64),
        (linear, angular): &(Vector3<f64>, Vector3<f64>),
        change: &[f64],
    ) -> (Vector3<f64>, Vector3<f64>) {
        let mut own = None;
        let place = self.place(node, q, self.element.shapes(place_m, &mut own));
        let (velocity, spin) = place.moved(node, change);
        (linear + angular.cross(&place.arm) + velocity, angular + spin)
    }
}

impl Place<'_> {
    /// Attitude, root ← section.
    #[inline]
    pub(crate) fn rotation(&self, node: &Node) -> Matrix3<f64> {
        node.rotation * self.turn.rotation()
    }

    /// Velocity and angular velocity per rate of a coordinate, root frame.
    pub(crate) fn partial(&self, node: &Node, i: usize) -> (Vector3<f64>, Vector3<f64>) {
        (
            node.rotation * self.shapes.velocity(i, &self.shortened),
            node.rotation * self.turn.spin(&self.shapes.angles_1_m(i)),
        )
    }

    /// Motion of the section, with its velocity and angular velocity relative to the first node.
    fn motion(&self, node: &Node, (velocity, spin): (Vector3<f64>, Vector3<f64>)) -> SectionMotion {
        SectionMotion {
            rotation: self.rotation(node),
            position_m: node.position + self.arm,
            velocity_m_s: node.velocity + node.spin.cross(&self.arm) + velocity,
            spin_rad_s: node.spin + spin,
        }
    }

    /// Derivative of the generalised force on coordinate `i` by coordinate `j`, for a constant force and moment in the frame of the first node.
    pub(crate) fn force_slope(&self, places: (usize, usize), load: (&Vector3<f64>, &Vector3<f64>)) -> f64 {
        self.shapes.force_slope(places, &self.turn, load)
    }

    fn moved(&self, node: &Node, rates: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
        let velocity = self.shapes.moved(rates, &self.shortened);
        (node.rotation * velocity, node.rotation * self.turn.spin(&self.shapes.angles_rad(rates)))
    }
}
