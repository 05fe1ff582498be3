//! Slope of the axis at the ends of elements with shear, in place of `r_x`.

use crate::multibody::node::Node;
use nalgebra::{Matrix3, Vector3};

/// Slope of the axis at one end of an element with shear, root frame.
#[derive(Debug, Clone, Copy)]
pub struct Slope {
    /// `e_x + ε` in the section's axes.
    pub(super) local: Vector3<f64>,
    /// Slope vector `d`.
    pub(crate) vector: Vector3<f64>,
    /// Rate of the slope in the section's axes, `R ε̇`, in 1/s.
    pub(super) strained: Vector3<f64>,
    /// Second rate of the slope in the section's axes, `R ε̈`, in 1/s².
    pub(super) pulled: Vector3<f64>,
    /// `d̈ + α ḋ`, inertial: multiplied by the mass, like [`Node::load_rate`].
    pub(super) load_rate: Vector3<f64>,
}

impl Slope {
    /// Zero slope and rates.
    pub(crate) const ZERO: Self = {
        let zero = Vector3::new(0.0, 0.0, 0.0);
        Self { local: zero, vector: zero, strained: zero, pulled: zero, load_rate: zero }
    };

    /// Axes `[d r_y r_z]` of the section, with the slope in place of `r_x`.
    #[inline]
    pub(crate) fn axes(&self, node: &Node) -> Matrix3<f64> {
        let mut axes = node.rotation;
        axes.set_column(0, &self.vector);
        axes
    }

    /// Nodal vectors `(r, d, r_y, r_z)`.
    #[inline]
    pub(crate) fn vectors(&self, node: &Node) -> [Vector3<f64>; 4] {
        [node.position, self.vector, axis(node, 1), axis(node, 2)]
    }

    /// Rates of the nodal vectors relative to the root frame.
    #[inline]
    pub(crate) fn velocities(&self, node: &Node) -> [Vector3<f64>; 4] {
        self.moved(node, &node.velocity, &node.spin)
    }

    /// Rates of the nodal vectors relative to the rigid-body motion of a carrier, or to the root frame.
    #[inline]
    pub(crate) fn relative_velocities(&self, node: &Node, carrier: Option<&Node>) -> [Vector3<f64>; 4] {
        let (velocity, spin) = carrier.map_or((node.velocity, node.spin), |carrier| node.relative_to(carrier));
        self.moved(node, &velocity, &spin)
    }

    #[inline]
    fn moved(&self, node: &Node, velocity: &Vector3<f64>, spin: &Vector3<f64>) -> [Vector3<f64>; 4] {
        let slope = spin.cross(&self.vector) + self.strained;
        [*velocity, slope, spin.cross(&axis(node, 1)), spin.cross(&axis(node, 2))]
    }

    /// Rates that are multiplied by the mass.
    #[inline]
    pub(crate) fn load_rates(&self, node: &Node) -> [Vector3<f64>; 4] {
        let [origin, _, y, z] = node.load_rate;
        [origin, self.load_rate, y, z]
    }
}

fn axis(node: &Node, k: usize) -> Vector3<f64> {
    node.rotation.fixed_view::<3, 1>(0, k).into_owned()
}
