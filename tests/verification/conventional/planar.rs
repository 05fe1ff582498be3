//! The paper's method in the plane, inextensible: constant curvature per element, one angle at the hinge.
//!
//! §4.4 compares run times with planar codes; only this one makes that comparison fair: the same unknowns per section as the finite
//! segments, the same algebra in two variants, by recursion in O(n) and with the dense `BᵀMB`, and the same integrator.

use super::segments::{Algebra, PlanarChain, table_4};
use foldwing::solve::{EquationsOfMotion, Powers, Singular};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix3, SMatrix, Vector2, Vector3};

/// Pose, velocities and accelerations of a node.
#[derive(Debug, Clone, Copy, Default)]
struct Node {
    position: Vector2<f64>,
    axis: Vector2<f64>,
    normal: Vector2<f64>,
    angle: f64,
    rate: f64,
    acceleration: Vector2<f64>,
    angular_acceleration: f64,
}

/// Connection of one node to the next: an element or the hinge. `shift` is the distance, `column` the Jacobian `(v_x, v_z, ω)` of the
/// coordinate.
#[derive(Debug, Clone, Copy, Default)]
struct Step {
    shift: Vector2<f64>,
    column: Vector3<f64>,
}

/// The two bodies of Table 4.
pub struct PlanarBeams {
    algebra: Algebra,
    per_body: usize,
    length_m: f64,
    nodes: Vec<Node>,
    steps: Vec<Step>,
    wrenches: Vec<Vector3<f64>>,
    couplings: Vec<Vector3<f64>>,
    pivots: Vec<f64>,
    carried: Vec<f64>,
    outer: Vec<Vector3<f64>>,
    dense: Option<Cholesky<f64, Dyn>>,
}

impl PlanarBeams {
    /// Table 4 with `elements` elements per body. Coordinates: curvatures of the first body, hinge angle, curvatures of the second.
    pub fn table_4(elements: usize, algebra: Algebra) -> Self {
        let steps = 2 * elements + 1;
        Self {
            algebra,
            per_body: elements,
            length_m: table_4::LENGTH_M / elements as f64,
            nodes: vec![Node { axis: Vector2::x(), normal: Vector2::y(), ..Node::default() }; steps + 1],
            steps: vec![Step::default(); steps],
            wrenches: vec![Vector3::zeros(); steps + 1],
            couplings: vec![Vector3::zeros(); steps],
            pivots: vec![0.0; steps],
            carried: vec![0.0; steps],
            outer: vec![Vector3::zeros(); steps + 1],
            dense: None,
        }
    }

    fn is_hinge(&self, step: usize) -> bool {
        step == self.per_body
    }

    fn stiffness(&self, step: usize) -> f64 {
        if self.is_hinge(step) { 0.0 } else { table_4::BENDING_N_M2 * self.length_m }
    }

    /// Outward sweep.
    fn sweep(&mut self, q: &[f64], v: &[f64], a: &[f64]) {
        for i in 0..self.steps.len() {
            let inner = self.nodes[i];
            let (shift, column, curl) = if self.is_hinge(i) {
                (Vector2::zeros(), Vector3::z(), Vector2::zeros())
            } else {
                let [value, first, second] = arc(self.length_m, q[i]);
                let turned = |w: Vector2<f64>| inner.axis * w.x + inner.normal * w.y;
                let slope = turned(first);
                (turned(value), Vector3::new(slope.x, slope.y, self.length_m), turned(second))
            };
            let slope = column.xy();
            let angle = inner.angle + column.z * q[i];
            let (sine, cosine) = angle.sin_cos();
            self.nodes[i + 1] = Node {
                position: inner.position + shift,
                axis: Vector2::new(cosine, sine),
                normal: Vector2::new(-sine, cosine),
                angle,
                rate: inner.rate + column.z * v[i],
                acceleration: inner.acceleration + across(shift) * inner.angular_acceleration
                    - shift * inner.rate.powi(2)
                    + across(slope) * (2.0 * inner.rate * v[i])
                    + curl * v[i].powi(2)
                    + slope * a[i],
                angular_acceleration: inner.angular_acceleration + column.z * a[i],
            };
            self.steps[i] = Step { shift, column };
        }
    }

    /// Element mass matrix for the twists `(v, ω)` of two nodes, from the nodal form of the fully parameterised element.
    fn twist_mass(&self, a: &Node, b: &Node) -> SMatrix<f64, 6, 6> {
        let l = self.length_m;
        let m = table_4::MASS_KG_M * l / 420.0;
        let j = table_4::ROTARY_KG_M * l / 6.0;
        let block = |p: &Node, q: &Node, m00: f64, m01: f64, m10: f64, m11: f64, m22: f64| {
            let (s, t) = (q.normal * m01, p.normal * m10);
            let ww = m11 * p.normal.dot(&q.normal) + m22 * p.axis.dot(&q.axis);
            Matrix3::new(m00, 0.0, s.x, 0.0, m00, s.y, t.x, t.y, ww)
        };
        let mut mass = SMatrix::<f64, 6, 6>::zeros();
        let (e, f, g, h) = (22.0 * l * m, 13.0 * l * m, 4.0 * l * l * m, 3.0 * l * l * m);
        mass.fixed_view_mut::<3, 3>(0, 0).copy_from(&block(a, a, 156.0 * m, e, e, g, 2.0 * j));
        mass.fixed_view_mut::<3, 3>(3, 3).copy_from(&block(b, b, 156.0 * m, -e, -e, g, 2.0 * j));
        let cross = block(b, a, 54.0 * m, f, -f, -h, j);
        mass.fixed_view_mut::<3, 3>(3, 0).copy_from(&cross);
        mass.fixed_view_mut::<3, 3>(0, 3).copy_from(&cross.transpose());
        mass
    }

    /// `BᵀMB` from the columns of `B`.
    pub fn dense_mass(&self) -> DMatrix<f64> {
        let n = self.steps.len();
        let mut columns: Vec<Vec<Vector3<f64>>> = vec![Vec::new()];
        for (i, step) in self.steps.iter().enumerate() {
            let mut next: Vec<Vector3<f64>> = columns[i].iter().map(|twist| carry(step, twist)).collect();
            next.push(step.column);
            columns.push(next);
        }
        let mut mass = DMatrix::zeros(n, n);
        for i in (0..n).filter(|&i| !self.is_hinge(i)) {
            let element = self.twist_mass(&self.nodes[i], &self.nodes[i + 1]);
            let stacked = DMatrix::from_fn(6, i + 1, |row, j| {
                if row < 3 { columns[i].get(j).map_or(0.0, |twist| twist[row]) } else { columns[i + 1][j][row - 3] }
            });
            let mut part = mass.view_mut((0, 0), (i + 1, i + 1));
            part += stacked.transpose() * (element * &stacked);
        }
        mass
    }
}

/// `(X, Z)` of a circular arc of length `l` and curvature `κ` from its inner frame, and its first two derivatives with respect to `κ`.
/// Power series in `β = κl`: ten terms are accurate to 1e-17 up to one radian, which no element exceeds.
fn arc(l: f64, curvature: f64) -> [Vector2<f64>; 3] {
    let beta = curvature * l;
    let mut sums = [Vector2::zeros(); 3];
    let mut power = [1.0, 0.0, 0.0]; // βᵏ and its derivatives
    let (mut factorial, mut sign) = (1.0, 1.0);
    for k in 0..20 {
        factorial *= f64::from(k + 1);
        // ∫₀¹ (cos βs, sin βs) ds: even powers to X, odd ones to Z, with coefficients 1/(k+1)!
        let share = sign / factorial;
        for (sum, power) in sums.iter_mut().zip(power) {
            if k % 2 == 0 { sum.x += share * power } else { sum.y += share * power }
        }
        if k % 2 == 1 {
            sign = -sign;
        }
        power = [power[0] * beta, power[1] * beta + power[0], power[2] * beta + 2.0 * power[1]];
    }
    [sums[0] * l, sums[1] * (l * l), sums[2] * (l * l * l)]
}

/// A vector rotated by 90°.
fn across(v: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-v.y, v.x)
}

/// Twist of the inner node transferred to the outer one.
fn carry(step: &Step, twist: &Vector3<f64>) -> Vector3<f64> {
    let turned = across(step.shift) * twist.z;
    Vector3::new(twist.x + turned.x, twist.y + turned.y, twist.z)
}

/// Wrench at the outer node transferred to the inner one: the transpose of [`carry`].
fn pull(step: &Step, wrench: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(wrench.x, wrench.y, wrench.z + across(step.shift).dot(&wrench.xy()))
}

impl EquationsOfMotion for PlanarBeams {
    fn coordinates(&self) -> usize {
        self.steps.len()
    }

    fn prescribe(&self, _: f64, _: &mut [f64], _: &mut [f64], _: &mut [f64]) {}

    fn residual(&mut self, _: f64, q: &[f64], v: &[f64], a: &[f64], residual: &mut [f64]) {
        self.sweep(q, v, a);
        let l = self.length_m;
        let m = table_4::MASS_KG_M * l / 420.0;
        let j = table_4::ROTARY_KG_M * l / 6.0;
        let gravity = Vector2::new(0.0, -table_4::GRAVITY_M_S2);
        self.wrenches.fill(Vector3::zeros());
        for i in 0..self.steps.len() {
            if self.is_hinge(i) {
                continue;
            }
            let second = |node: &Node| {
                let (alpha, square) = (node.angular_acceleration, node.rate.powi(2));
                let axis = node.normal * alpha - node.axis * square;
                let normal = -node.axis * alpha - node.normal * square;
                [node.acceleration - gravity, axis * l, normal]
            };
            let [a, b] = [&self.nodes[i], &self.nodes[i + 1]];
            let ([ra, da, na], [rb, db, nb]) = (second(a), second(b));
            let wrench = |node: &Node, force: Vector2<f64>, axis: Vector2<f64>, normal: Vector2<f64>| {
                Vector3::new(force.x, force.y, node.normal.dot(&axis) * l - node.axis.dot(&normal))
            };
            let inner = wrench(
                a,
                (ra * 156.0 + da * 22.0 + rb * 54.0 - db * 13.0) * m,
                (ra * 22.0 + da * 4.0 + rb * 13.0 - db * 3.0) * m,
                (na * 2.0 + nb) * j,
            );
            let outer = wrench(
                b,
                (ra * 54.0 + da * 13.0 + rb * 156.0 - db * 22.0) * m,
                (-ra * 13.0 - da * 3.0 - rb * 22.0 + db * 4.0) * m,
                (na + nb * 2.0) * j,
            );
            self.wrenches[i] += inner;
            self.wrenches[i + 1] += outer;
        }
        for i in (0..self.steps.len()).rev() {
            let outer = self.wrenches[i + 1];
            residual[i] = self.steps[i].column.dot(&outer) + self.stiffness(i) * q[i];
            self.wrenches[i] += pull(&self.steps[i], &outer);
        }
    }

    fn factorize(&mut self, mass: f64, _: f64, stiffness: f64) -> Result<(), Singular> {
        if self.algebra == Algebra::Dense {
            let mut matrix = self.dense_mass() * mass;
            (0..self.steps.len()).for_each(|i| matrix[(i, i)] += stiffness * self.stiffness(i));
            self.dense = Some(matrix.cholesky().ok_or(Singular { coordinate: 0 })?);
            return Ok(());
        }
        let mut outer = Matrix3::zeros(); // articulated inertia of the node without its inner element
        for i in (0..self.steps.len()).rev() {
            let (step, hinge) = (self.steps[i], self.is_hinge(i));
            let element =
                if hinge { SMatrix::zeros() } else { self.twist_mass(&self.nodes[i], &self.nodes[i + 1]) * mass };
            let cross: Matrix3<f64> = element.fixed_view::<3, 3>(3, 0).into_owned();
            outer += element.fixed_view::<3, 3>(3, 3);
            let lever = across(step.shift);
            let shift = Matrix3::new(1.0, 0.0, lever.x, 0.0, 1.0, lever.y, 0.0, 0.0, 1.0);
            let pulled = outer * step.column;
            let coupling = pull(&step, &pulled) + cross.transpose() * step.column;
            let pivot = step.column.dot(&pulled) + stiffness * self.stiffness(i);
            if pivot.is_nan() || pivot <= 0.0 {
                return Err(Singular { coordinate: i });
            }
            outer = shift.transpose() * (outer * shift + cross)
                + cross.transpose() * shift
                + element.fixed_view::<3, 3>(0, 0)
                - coupling * coupling.transpose() / pivot;
            self.couplings[i] = coupling;
            self.pivots[i] = pivot;
        }
        Ok(())
    }

    fn solve(&mut self, x: &mut [f64]) -> f64 {
        if self.algebra == Algebra::Dense {
            let mut right = DVector::from_column_slice(x);
            self.dense.as_ref().expect("a factor").solve_mut(&mut right);
            x.copy_from_slice(right.as_slice());
            return self.norm(x);
        }
        self.outer.fill(Vector3::zeros());
        for i in (0..self.steps.len()).rev() {
            let carried = x[i] + self.steps[i].column.dot(&self.outer[i + 1]);
            self.outer[i] = pull(&self.steps[i], &self.outer[i + 1]) - self.couplings[i] * (carried / self.pivots[i]);
            self.carried[i] = carried;
        }
        let mut moved = Vector3::zeros();
        for (i, x) in x.iter_mut().enumerate() {
            *x = (self.carried[i] - self.couplings[i].dot(&moved)) / self.pivots[i];
            moved = carry(&self.steps[i], &moved) + self.steps[i].column * *x;
        }
        self.norm(x)
    }

    fn norm(&mut self, change: &[f64]) -> f64 {
        let (mut moved, mut norm) = (Vector3::zeros(), 0.0_f64);
        for (step, change) in self.steps.iter().zip(change) {
            moved = carry(step, &moved) + step.column * *change;
            norm = norm.max(moved.z.abs()).max(moved.xy().norm() / (2.0 * table_4::LENGTH_M));
            if moved.z.is_nan() {
                return f64::NAN;
            }
        }
        norm
    }

    fn project(&self, _: &mut [f64], _: &mut [f64], _: &mut [f64]) {}

    fn powers(&mut self, _: f64, _: &[f64], _: &[f64], _: &[f64]) -> Powers {
        Powers::default()
    }
}

impl PlanarChain for PlanarBeams {
    fn tip_m(&mut self, q: &[f64]) -> Vector2<f64> {
        let zero = vec![0.0; q.len()];
        self.sweep(q, &zero, &zero);
        self.nodes.last().expect("nodes").position
    }
}
