//! Constraints, all of them quadratic, and the fictitious springs of the first two conventional methods.

use crate::conventional::assembly::{BodyMotion, NodeMotion, row};
use nalgebra::{DMatrix, DVector, Vector3};

/// A node of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct End {
    /// Body.
    pub body: usize,
    /// Node, counted from its inner end.
    pub node: usize,
}

impl End {
    fn of(self, motion: &[BodyMotion]) -> (&[usize], &NodeMotion) {
        (&motion[self.body].active, &motion[self.body].nodes[self.node])
    }

    fn vector(self, motion: &[BodyMotion], k: usize) -> Vector3<f64> {
        row(&self.of(motion).1.h, k)
    }
}

/// Equations between coordinates or nodes that multipliers enforce.
#[derive(Debug, Clone, PartialEq)]
pub enum Constraint {
    /// `ζᵀζ = 1`, eq. (22), of the four coordinates from the given one.
    EulerParameters(usize),
    /// Eq. (18) of the nine coordinates from the given one.
    DirectionCosines(usize),
    /// A node at the root frame's origin.
    Pinned(End),
    /// Two coincident nodes: `r_b = r_a`.
    Coincident(End, End),
    /// Scalar product of two gradients.
    Product {
        /// First gradient: node and row.
        a: (End, usize),
        /// Second gradient.
        b: (End, usize),
        /// Its value.
        value: f64,
    },
}

/// Products of eq. (18): pairs of `μ` in its order; the seventh equation is `μ₃₂ = 0`.
const COSINE_PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
/// Index of `μ₃₂` among the nine.
const MU_32: usize = 7;

impl Constraint {
    /// True for constraints between the variables of one joint or root node: `Ψ` of eq. (9), and the rigid nodes of the DAE.
    pub fn is_local(&self) -> bool {
        match self {
            Self::EulerParameters(_) | Self::DirectionCosines(_) => true,
            Self::Product { a, b, .. } => a.0 == b.0,
            Self::Pinned(_) | Self::Coincident(..) => false,
        }
    }

    /// Number of scalar equations.
    pub fn rows(&self) -> usize {
        match self {
            Self::EulerParameters(_) | Self::Product { .. } => 1,
            Self::DirectionCosines(_) => 7,
            Self::Pinned(_) | Self::Coincident(..) => 3,
        }
    }

    /// `Ψ`.
    pub fn value(&self, motion: &[BodyMotion], q: &DVector<f64>) -> Vec<f64> {
        match *self {
            Self::EulerParameters(at) => vec![q.rows(at, 4).norm_squared() - 1.0],
            Self::DirectionCosines(at) => {
                let mu = |i: usize| q.fixed_rows::<3>(at + 3 * i);
                let product = |&(i, j): &(usize, usize)| mu(i).dot(&mu(j)) - f64::from(u8::from(i == j));
                COSINE_PAIRS.iter().map(product).chain([q[at + MU_32]]).collect()
            }
            Self::Pinned(end) => end.vector(motion, 0).as_slice().to_vec(),
            Self::Coincident(a, b) => (b.vector(motion, 0) - a.vector(motion, 0)).as_slice().to_vec(),
            Self::Product { a, b, value } => vec![a.0.vector(motion, a.1).dot(&b.0.vector(motion, b.1)) - value],
        }
    }

    /// Adds its rows of `Ψ_q`, starting at `first`, and of `γ = −d/dt(Ψ_q) q̇`.
    pub fn linearise(
        &self,
        motion: &[BodyMotion],
        q: &DVector<f64>,
        v: &DVector<f64>,
        jacobian: &mut DMatrix<f64>,
        gamma: &mut DVector<f64>,
        first: usize,
    ) {
        match *self {
            Self::EulerParameters(at) => {
                (0..4).for_each(|i| jacobian[(first, at + i)] = 2.0 * q[at + i]);
                gamma[first] = -2.0 * v.rows(at, 4).norm_squared();
            }
            Self::DirectionCosines(at) => {
                for (line, &(i, j)) in COSINE_PAIRS.iter().enumerate() {
                    for k in 0..3 {
                        jacobian[(first + line, at + 3 * i + k)] += q[at + 3 * j + k];
                        jacobian[(first + line, at + 3 * j + k)] += q[at + 3 * i + k];
                        gamma[first + line] -= 2.0 * v[at + 3 * i + k] * v[at + 3 * j + k];
                    }
                }
                jacobian[(first + 6, at + MU_32)] = 1.0;
            }
            Self::Pinned(end) => position_rows(end, motion, 1.0, jacobian, gamma, first),
            Self::Coincident(a, b) => {
                position_rows(a, motion, -1.0, jacobian, gamma, first);
                position_rows(b, motion, 1.0, jacobian, gamma, first);
            }
            Self::Product { a, b, .. } => {
                for (own, other) in [(a, b), (b, a)] {
                    let (active, node) = own.0.of(motion);
                    let with = other.0.vector(motion, other.1);
                    for (&j, column) in active.iter().zip(&node.columns) {
                        jacobian[(first, j)] += row(column, own.1).dot(&with);
                    }
                    gamma[first] -= row(&node.bias, own.1).dot(&with);
                }
                let rate = |(end, k): (End, usize)| row(&end.of(motion).1.rate, k);
                gamma[first] -= 2.0 * rate(a).dot(&rate(b));
            }
        }
    }

    /// Projects the joint variables of a constraint, and their rates, orthogonally onto it; constraints between nodes are left unchanged.
    pub fn project(&self, q: &mut DVector<f64>, v: &mut DVector<f64>) {
        match *self {
            Self::EulerParameters(at) => {
                let zeta = q.rows(at, 4).normalize();
                let along = zeta.dot(&v.rows(at, 4));
                q.rows_mut(at, 4).copy_from(&zeta);
                v.rows_mut(at, 4).axpy(-along, &zeta, 1.0);
            }
            Self::DirectionCosines(at) => {
                let count = q.len();
                let rows = |q: &DVector<f64>| {
                    let mut jacobian = DMatrix::zeros(7, count);
                    let (zero, mut unused) = (DVector::zeros(count), DVector::zeros(7));
                    self.linearise(&[], q, &zero, &mut jacobian, &mut unused, 0);
                    jacobian.columns(at, 9).into_owned()
                };
                let shift = |jacobian: &DMatrix<f64>, residual: DVector<f64>| {
                    let normal = jacobian * jacobian.transpose();
                    let lambda = normal.lu().solve(&residual).expect("the seven rows are independent");
                    jacobian.transpose() * lambda
                };
                for _ in 0..2 {
                    let step = shift(&rows(q), DVector::from_vec(self.value(&[], q)));
                    let mut part = q.rows_mut(at, 9);
                    part -= step;
                }
                let jacobian = rows(q);
                let residual = &jacobian * v.rows(at, 9);
                let mut part = v.rows_mut(at, 9);
                part -= shift(&jacobian, residual);
            }
            _ => {}
        }
    }
}

fn position_rows(
    end: End,
    motion: &[BodyMotion],
    sign: f64,
    jacobian: &mut DMatrix<f64>,
    gamma: &mut DVector<f64>,
    first: usize,
) {
    let (active, node) = end.of(motion);
    for i in 0..3 {
        for (&j, column) in active.iter().zip(&node.columns) {
            jacobian[(first + i, j)] += sign * column[(0, i)];
        }
        gamma[first + i] -= sign * node.bias[(0, i)];
    }
}

/// A fictitious spring.
#[derive(Debug, Clone, PartialEq)]
pub enum Spring {
    /// `½ k (q_i − rest)²`: restrains a redundant rotation angle.
    Coordinate {
        /// Coordinate.
        index: usize,
        /// Its unstressed value.
        rest: f64,
        /// `k` in N·m/rad.
        stiffness: f64,
    },
    /// `½ k |a + sign·b|²` between nodal vectors of two joined nodes.
    Vectors {
        /// First vector: node and row.
        a: (End, usize),
        /// Second vector.
        b: (End, usize),
        /// Sign of the second.
        sign: f64,
        /// `k` in N/m for positions, N·m for gradients.
        stiffness: f64,
    },
}

impl Spring {
    /// Adds the generalised force.
    pub fn add_force(&self, motion: &[BodyMotion], q: &DVector<f64>, force: &mut DVector<f64>) {
        match *self {
            Self::Coordinate { index, rest, stiffness } => force[index] -= stiffness * (q[index] - rest),
            Self::Vectors { a, b, sign, stiffness } => {
                let gap = a.0.vector(motion, a.1) + b.0.vector(motion, b.1) * sign;
                for ((end, k), weight) in [(a, 1.0), (b, sign)] {
                    let (active, node) = end.of(motion);
                    for (&j, column) in active.iter().zip(&node.columns) {
                        force[j] -= stiffness * weight * gap.dot(&row(column, k));
                    }
                }
            }
        }
    }

    /// Energy in J.
    pub fn energy(&self, motion: &[BodyMotion], q: &DVector<f64>) -> f64 {
        match *self {
            Self::Coordinate { index, rest, stiffness } => 0.5 * stiffness * (q[index] - rest).powi(2),
            Self::Vectors { a, b, sign, stiffness } => {
                0.5 * stiffness * (a.0.vector(motion, a.1) + b.0.vector(motion, b.1) * sign).norm_squared()
            }
        }
    }
}
