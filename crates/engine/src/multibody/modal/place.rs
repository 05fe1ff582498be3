//! Places along a modal body: where loads act and motion is reported, NOTATION eqs. (M2)–(M4) and (M7).

use super::{Modal, square};
use crate::beam::modal::{MAXIMUM_MODES, ShapesAt, small_turn};
use crate::load::SectionMotion;
use crate::multibody::kinematics::Motion;
use crate::multibody::station::Accelerated;
use crate::multibody::workspace::{Node, Pair};
use nalgebra::{Matrix3, Vector3};

/// A place of a modal body at some coordinates.
pub(crate) struct Place {
    pub shapes: ShapesAt,
    shortened: [f64; MAXIMUM_MODES],
    /// Small angles of the section in rad, eq. (M3).
    angles: Vector3<f64>,
    /// Angular velocity relative to the inner end per rate of the small angles, frame of the inner end.
    turning: Matrix3<f64>,
    /// From the first node in m, root frame.
    pub arm: Vector3<f64>,
    /// Root ← section.
    pub rotation: Matrix3<f64>,
}

impl Modal {
    /// The place at a distance from the inner end in m; `q` are the body's own coordinates.
    pub(crate) fn place(&self, node: &Node, q: &[f64], place_m: f64) -> Place {
        let shapes = self.element.at(place_m);
        let (shortened, angles) = (shapes.shortened(q), shapes.angles_rad(q));
        Place {
            arm: node.rotation * shapes.position_m(q, &shortened),
            rotation: node.rotation * small_turn(&angles),
            turning: self.element.turning(&angles),
            shapes,
            shortened,
            angles,
        }
    }

    /// Pose, velocity and angular velocity of a place.
    pub(crate) fn motion_at(&self, node: &Node, motion: Motion, place_m: f64) -> SectionMotion {
        let place = self.place(node, &motion.q[self.range()], place_m);
        let moved = place.moved(node, &motion.v[self.range()]);
        place.motion(node, moved)
    }

    /// The same with its accelerations.
    pub(crate) fn accelerated_at(&self, node: &Node, motion: Motion, place_m: f64) -> Accelerated {
        let place = self.place(node, &motion.q[self.range()], place_m);
        let (v, a) = (&motion.v[self.range()], &motion.a[self.range()]);
        let ((velocity, spin), (second, spin_rate)) = (place.moved(node, v), place.moved(node, a));
        let mut rates = [0.0; MAXIMUM_MODES];
        rates[..v.len()].copy_from_slice(v);
        let drawn = -node.rotation.column(0) * square(&place.shapes.shortened(v), &rates);
        let angle_rates = place.shapes.angles_rad(v);
        let bent = node.rotation * (self.element.turning_along(&place.angles, &angle_rates) * angle_rates);
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

    /// Displacement and rotation of a place for those of the first node and a change of the body's own coordinates.
    pub fn displaced_at(
        &self,
        node: &Node,
        (q, place_m): (&[f64], f64),
        (linear, angular): &(Vector3<f64>, Vector3<f64>),
        change: &[f64],
    ) -> (Vector3<f64>, Vector3<f64>) {
        let place = self.place(node, q, place_m);
        let (velocity, spin) = place.moved(node, change);
        (linear + angular.cross(&place.arm) + velocity, angular + spin)
    }

    /// Adds a wrench at a place, root frame, to the projections on the coordinates; returns the equivalent wrench on
    /// the first node.
    pub(crate) fn project_at(&self, node: &Node, place: &Place, wrench: &Pair, out: &mut [f64]) -> Pair {
        let force = node.rotation.tr_mul(&wrench.linear);
        let moment = place.turning.tr_mul(&node.rotation.tr_mul(&wrench.angular));
        for (i, out) in out[self.range()].iter_mut().enumerate() {
            *out += place.shapes.velocity(i, &place.shortened).dot(&force) + place.shapes.angles_1_m(i).dot(&moment);
        }
        Pair { linear: wrench.linear, angular: wrench.angular + place.arm.cross(&wrench.linear) }
    }
}

impl Place {
    /// Velocity and angular velocity per rate of a coordinate, root frame.
    pub(crate) fn partial(&self, node: &Node, i: usize) -> (Vector3<f64>, Vector3<f64>) {
        (
            node.rotation * self.shapes.velocity(i, &self.shortened),
            node.rotation * (self.turning * self.shapes.angles_1_m(i)),
        )
    }

    /// Its motion, with its velocity and angular velocity relative to the first node.
    fn motion(&self, node: &Node, (velocity, spin): (Vector3<f64>, Vector3<f64>)) -> SectionMotion {
        SectionMotion {
            rotation: self.rotation,
            position_m: node.position + self.arm,
            velocity_m_s: node.velocity + node.spin.cross(&self.arm) + velocity,
            spin_rad_s: node.spin + spin,
        }
    }

    fn moved(&self, node: &Node, rates: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
        let velocity: Vector3<f64> =
            rates.iter().enumerate().map(|(i, rate)| self.shapes.velocity(i, &self.shortened) * *rate).sum();
        (node.rotation * velocity, node.rotation * (self.turning * self.shapes.angles_rad(rates)))
    }
}
