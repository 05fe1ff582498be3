//! Closed loops of the description: two points that coincide.

use nalgebra::Vector3;

/// Carrier of a point of a closed loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LoopEnd {
    /// The root: the point is fixed in the root frame and moves with it.
    Root,
    /// A section of a body.
    Body {
        /// Index into [`Machine::bodies`](crate::machine::Machine::bodies).
        index: usize,
        /// Distance from the body's inner end in m.
        position_m: f64,
    },
}

impl LoopEnd {
    /// Index of the body and distance from its inner end in m; `None` on the root.
    pub fn on_body(self) -> Option<(usize, f64)> {
        match self {
            Self::Root => None,
            Self::Body { index, position_m } => Some((index, position_m)),
        }
    }
}

/// Two points that coincide, of two sections or of a section and the root: a ball joint that closes a loop. Two of them on one axis form a
/// hinge.
#[derive(Debug, Clone, PartialEq)]
pub struct Closure {
    /// Identifier.
    pub name: String,
    /// Carriers of the points; one at least is a body.
    pub ends: [LoopEnd; 2],
    /// Positions of the points relative to the sections' axes, section frames, m; on the root its position in the root frame.
    pub offsets_m: [Vector3<f64>; 2],
    /// Whether the points coincide to round-off, by constraint forces in place of a penalty, whose values are then 0.
    pub rigid: bool,
    /// Inertia of the penalty on the gap in kg.
    pub inertia_kg: f64,
    /// Damping of the penalty on the gap in N·s/m.
    pub damping_n_s_m: f64,
    /// Stiffness of the penalty on the gap in N/m.
    pub stiffness_n_m: f64,
}

impl Closure {
    /// Whether the force of the loop depends on the accelerations of its bodies: with an inertia, and in a rigid loop.
    pub fn resists_acceleration(&self) -> bool {
        self.rigid || self.inertia_kg > 0.0
    }
}
