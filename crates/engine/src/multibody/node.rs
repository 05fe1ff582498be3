//! Quantities of a node in the recursions: motion and wrench, articulated inertia, factors of the element at it, small displacements.

use crate::math::strain::{Strain, StrainMatrix};
use nalgebra::{Matrix3, Vector3};

/// Motion of a node relative to the root frame, and the sum of the wrenches on it so far.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    /// Attitude, root ← node.
    pub rotation: Matrix3<f64>,
    /// Position in m.
    pub position: Vector3<f64>,
    /// Velocity in m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity in rad/s.
    pub spin: Vector3<f64>,
    /// Acceleration relative to the root frame in m/s².
    pub acceleration: Vector3<f64>,
    /// Angular acceleration relative to the root frame in rad/s².
    pub spin_rate: Vector3<f64>,
    /// `ë + α ė` of the nodal vectors `(r, r_x, r_y, r_z)`, inertial, minus gravity: multiplied by the mass.
    pub load_rate: [Vector3<f64>; 4],
    /// Force at the node: inertia forces minus loads of the outboard part, N.
    pub force: Vector3<f64>,
    /// Moment at the node in N·m.
    pub moment: Vector3<f64>,
    /// Contribution to `force` and `moment` of parts at the node itself: attached masses, loads on it, child bodies.
    pub fixed: Pair,
}

impl Node {
    pub(super) const ZERO: Self = Self {
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        position: Vector3::new(0.0, 0.0, 0.0),
        velocity: Vector3::new(0.0, 0.0, 0.0),
        spin: Vector3::new(0.0, 0.0, 0.0),
        acceleration: Vector3::new(0.0, 0.0, 0.0),
        spin_rate: Vector3::new(0.0, 0.0, 0.0),
        load_rate: [Vector3::new(0.0, 0.0, 0.0); 4],
        force: Vector3::new(0.0, 0.0, 0.0),
        moment: Vector3::new(0.0, 0.0, 0.0),
        fixed: Pair::ZERO,
    };

    /// Velocity and angular velocity relative to a rigid body that moves with `carrier`, root frame.
    #[inline]
    pub(crate) fn relative_to(&self, carrier: &Self) -> (Vector3<f64>, Vector3<f64>) {
        let carried = carrier.velocity + carrier.spin.cross(&(self.position - carrier.position));
        (self.velocity - carried, self.spin - carrier.spin)
    }

    /// Adds a wrench of parts attached to the node.
    #[inline]
    pub(crate) fn add_fixed(&mut self, force: &Vector3<f64>, moment: &Vector3<f64>) {
        self.force += force;
        self.moment += moment;
        self.fixed.linear += force;
        self.fixed.angular += moment;
    }
}

/// Symmetric 6×6 articulated inertia in blocks over (velocity, spin).
#[derive(Debug, Clone, Copy)]
pub struct ArticulatedInertia {
    /// Velocity–velocity block.
    pub vv: Matrix3<f64>,
    /// Velocity–spin block.
    pub vw: Matrix3<f64>,
    /// Spin–spin block.
    pub ww: Matrix3<f64>,
}

impl ArticulatedInertia {
    /// Adds another articulated inertia.
    #[inline]
    pub(crate) fn add(&mut self, other: &Self) {
        self.vv += other.vv;
        self.vw += other.vw;
        self.ww += other.ww;
    }

    /// Sum with another articulated inertia.
    #[inline]
    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self { vv: self.vv + other.vv, vw: self.vw + other.vw, ww: self.ww + other.ww }
    }

    /// Zero inertia.
    pub const ZERO: Self = Self {
        vv: Matrix3::from_array_storage(ZERO_3),
        vw: Matrix3::from_array_storage(ZERO_3),
        ww: Matrix3::from_array_storage(ZERO_3),
    };
}

const ZERO_3: nalgebra::ArrayStorage<f64, 3, 3> = nalgebra::ArrayStorage([[0.0; 3]; 3]);

/// Factors of one element's elimination.
#[derive(Debug, Clone, Copy)]
pub struct ElementFactor<const N: usize> {
    /// Lower Cholesky factor of `X`, with inverted diagonal.
    pub cholesky: StrainMatrix<N>,
    /// `U`: coupling of the strains to the inner node, velocity rows.
    pub velocity: [Vector3<f64>; N],
    /// `U`, spin rows.
    pub spin: [Vector3<f64>; N],
    /// Coupling to the strains of the inner half, for outer halves.
    pub coupling: StrainMatrix<N>,
}

/// Factors of all elements, and their right-hand sides in a solution; used for the elements with `N` strains.
#[derive(Debug, Clone)]
pub(crate) struct Eliminated<const N: usize> {
    pub factors: Vec<ElementFactor<N>>,
    pub right_hand: Vec<Strain<N>>,
}

impl<const N: usize> Eliminated<N> {
    pub(super) fn new(elements: usize) -> Self {
        let zero = [Vector3::zeros(); N];
        let factor = ElementFactor {
            cholesky: StrainMatrix::zeros(),
            velocity: zero,
            spin: zero,
            coupling: StrainMatrix::zeros(),
        };
        Self { factors: vec![factor; elements], right_hand: vec![Strain::zeros(); elements] }
    }
}

/// Small displacement or wrench as a pair of vectors.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    /// Velocity or force.
    pub linear: Vector3<f64>,
    /// Spin or moment.
    pub angular: Vector3<f64>,
}

impl Pair {
    /// Zero vectors.
    pub const ZERO: Self = Self { linear: Vector3::new(0.0, 0.0, 0.0), angular: Vector3::new(0.0, 0.0, 0.0) };
}

/// Largest squares of displacement and rotation so far.
#[derive(Default)]
pub(crate) struct NormSquared {
    linear: f64,
    pub(crate) angular: f64,
    /// Sum of all entries times zero: preserves NaN and infinity, which `max` would drop.
    taint: f64,
}

impl NormSquared {
    #[inline]
    pub(crate) fn include(&mut self, moved: &Pair) {
        let (linear, angular) = (moved.linear.norm_squared(), moved.angular.norm_squared());
        self.taint += (linear + angular) * 0.0;
        self.linear = self.linear.max(linear);
        self.angular = self.angular.max(angular);
    }

    pub(crate) fn value(&self, reference_length_m: f64) -> f64 {
        (self.linear.sqrt() / reference_length_m).max(self.angular.sqrt()) + self.taint
    }
}
