//! A machine in another view: rotated as a whole about the root's origin, or mirrored in the plane y = 0.

use nalgebra::{UnitQuaternion, Vector3};

/// Frame in which the components of a vector are given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Frame {
    /// The root frame: the view rotates such components.
    Root,
    /// A frame of the machine itself.
    Body,
}

/// First the mirror image, in every frame, then the rotation of the root frame.
#[derive(Debug, Clone, Copy)]
pub struct View {
    pub turn: UnitQuaternion<f64>,
    pub mirror: bool,
}

impl View {
    /// The unchanged machine.
    pub fn plain() -> Self {
        Self { turn: UnitQuaternion::identity(), mirror: false }
    }

    /// The machine rotated by a rotation vector in rad.
    pub fn turned(rotation_rad: Vector3<f64>) -> Self {
        Self { turn: UnitQuaternion::from_scaled_axis(rotation_rad), mirror: false }
    }

    /// The mirror image.
    pub fn mirrored() -> Self {
        Self { turn: UnitQuaternion::identity(), mirror: true }
    }

    /// A quantity that changes its sign in the mirror image.
    pub fn odd(&self, value: f64) -> f64 {
        if self.mirror { -value } else { value }
    }

    /// Positions, forces, velocities.
    pub fn polar(&self, mut v: Vector3<f64>, frame: Frame) -> Vector3<f64> {
        v.y = self.odd(v.y);
        self.in_frame(v, frame)
    }

    /// Rotation axes, angular velocities, moments.
    pub fn axial(&self, v: Vector3<f64>, frame: Frame) -> Vector3<f64> {
        self.in_frame(Vector3::new(self.odd(v.x), v.y, self.odd(v.z)), frame)
    }

    /// Attitude of a frame of the machine in the root frame or in another frame of the machine.
    pub fn attitude(&self, rotation: UnitQuaternion<f64>, frame: Frame) -> UnitQuaternion<f64> {
        let inner = UnitQuaternion::from_scaled_axis(self.axial(rotation.scaled_axis(), Frame::Body));
        if frame == Frame::Root { self.turn * inner } else { inner }
    }

    fn in_frame(&self, v: Vector3<f64>, frame: Frame) -> Vector3<f64> {
        // unchanged machines keep their numbers to the last bit
        if frame == Frame::Root && self.turn != UnitQuaternion::identity() { self.turn * v } else { v }
    }
}
