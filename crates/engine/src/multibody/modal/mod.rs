//! Modal bodies in the recursions: a link with one degree of freedom per shape between the body's first node and the node at its outer end,
//! with mass in between, NOTATION eqs. (M1)–(M13).
//!
//! Deflections, shortening and attitudes are those of \[E\]; velocities and accelerations are their exact time derivatives, for the
//! attitude to all orders of the slopes, and forces are projected on the coordinates with the same partial velocities: the power of the
//! forces equals the rate of the energies.

mod along;
mod factor;
mod forces;
pub(crate) mod place;

pub(crate) use factor::ModalFactor;

use crate::beam::modal::{MAXIMUM_MODES, ModalElement};
use crate::multibody::motion::Motion;
use crate::multibody::node::{Node, Pair};
use nalgebra::{Matrix3, Vector3};

/// A modal body's element with its position in `q`.
#[derive(Debug, Clone, PartialEq)]
pub struct Modal {
    /// Element with the shapes.
    pub element: ModalElement,
    /// Index of its first coordinate.
    pub coordinate: usize,
}

/// Workspace of the sweeps for a modal body.
#[derive(Debug, Clone)]
pub struct ModalWork {
    /// Vector from the first node to the node at the outer end, root frame, m.
    pub(crate) arm: Vector3<f64>,
    /// Velocity of the outer end per rate of a coordinate, root frame.
    pub(crate) velocity: [Vector3<f64>; MAXIMUM_MODES],
    /// Angular velocity of the outer end per rate of a coordinate, root frame, 1/m.
    pub(crate) spin: [Vector3<f64>; MAXIMUM_MODES],
    /// Coordinates of the sweep.
    pub(crate) q: [f64; MAXIMUM_MODES],
    /// Rates of the sweep; zero after a sweep of poses only.
    pub(crate) v: [f64; MAXIMUM_MODES],
    /// Second rates of the sweep.
    pub(crate) a: [f64; MAXIMUM_MODES],
    pub(crate) factor: ModalFactor,
}

impl ModalWork {
    pub(crate) fn new() -> Self {
        let zero = [Vector3::zeros(); MAXIMUM_MODES];
        Self {
            arm: Vector3::zeros(),
            velocity: zero,
            spin: zero,
            q: [0.0; MAXIMUM_MODES],
            v: [0.0; MAXIMUM_MODES],
            a: [0.0; MAXIMUM_MODES],
            factor: ModalFactor::ZERO,
        }
    }
}

impl Modal {
    /// Range of its coordinates in `q`.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.coordinate..self.coordinate + self.element.modes
    }

    /// Moves the node at the outer end according to the shapes, eqs. (M2)–(M4) and (M7).
    pub(crate) fn carry<const RATES: bool>(
        &self,
        work: &mut ModalWork,
        inner: &Node,
        outer: &mut Node,
        motion: Motion,
    ) {
        let (range, modes, tip) = (self.range(), self.element.modes, &self.element.tip);
        work.q[..modes].copy_from_slice(&motion.q[range.clone()]);
        let shortened = tip.shortened(&work.q[..modes]);
        work.arm = inner.rotation * tip.position_m(&work.q[..modes], &shortened);
        let turn = self.element.turn(tip.angles_rad(&work.q[..modes]));
        for i in 0..modes {
            work.velocity[i] = inner.rotation * tip.velocity(i, &shortened);
            work.spin[i] = inner.rotation * turn.spin(&tip.angles_1_m(i));
        }
        outer.rotation = inner.rotation * turn.rotation();
        outer.position = inner.position + work.arm;
        if !RATES {
            work.v = [0.0; MAXIMUM_MODES];
            work.a = [0.0; MAXIMUM_MODES];
            return;
        }
        work.v[..modes].copy_from_slice(&motion.v[range.clone()]);
        work.a[..modes].copy_from_slice(&motion.a[range]);
        let (velocity, spin) = work.moved(modes, &work.v);
        let (second, spin_rate) = work.moved(modes, &work.a);
        let swing = inner.spin.cross(&work.arm);
        let drawn = -inner.rotation.column(0) * square(&tip.shortened(&work.v[..modes]), &work.v[..modes]);
        let rates = tip.angles_rad(&work.v[..modes]);
        let bent = inner.rotation * turn.spin_along(&rates, &rates);
        outer.velocity = inner.velocity + swing + velocity;
        outer.spin = inner.spin + spin;
        outer.acceleration = inner.acceleration
            + inner.spin_rate.cross(&work.arm)
            + inner.spin.cross(&(swing + velocity * 2.0))
            + second
            + drawn;
        outer.spin_rate = inner.spin_rate + inner.spin.cross(&spin) + spin_rate + bent;
    }

    /// Projections of a wrench at the outer end on the coordinates, added to `out`, eq. (M8).
    #[inline]
    pub(crate) fn project(&self, work: &ModalWork, wrench: &Pair, out: &mut [f64]) {
        for (i, out) in out[self.range()].iter_mut().enumerate() {
            *out += work.velocity[i].dot(&wrench.linear) + work.spin[i].dot(&wrench.angular);
        }
    }

    /// Twist of the outer end due to that of the first node and a change of the coordinates.
    #[inline]
    pub(crate) fn displaced(&self, work: &ModalWork, inner: &Pair, change: &[f64]) -> Pair {
        let (linear, angular) = work.moved(self.element.modes, &change[self.range()]);
        Pair { linear: inner.linear + inner.angular.cross(&work.arm) + linear, angular: inner.angular + angular }
    }

    /// Largest rotation of the outer end in rad between two sets of coordinates.
    pub(crate) fn turn_between(&self, from: &[f64], to: &[f64]) -> f64 {
        let turn: Vector3<f64> =
            self.range().enumerate().map(|(i, c)| self.element.tip.angles_1_m(i) * (to[c] - from[c])).sum();
        turn.norm()
    }
}

impl ModalWork {
    /// Velocity and angular velocity of the outer end relative to the first node for given rates.
    #[inline]
    fn moved(&self, modes: usize, rates: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
        let (mut linear, mut angular) = (Vector3::zeros(), Vector3::zeros());
        for (i, rate) in rates.iter().enumerate().take(modes) {
            linear += self.velocity[i] * *rate;
            angular += self.spin[i] * *rate;
        }
        (linear, angular)
    }
}

/// Scalar product `Σ a_i b_i`.
#[inline]
fn square(a: &[f64; MAXIMUM_MODES], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Components of a vector in the frame of `axes`.
#[inline]
fn inside(axes: &Matrix3<f64>, vector: &Vector3<f64>) -> Vector3<f64> {
    axes.tr_mul(vector)
}
