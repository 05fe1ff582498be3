//! Planar finite segments: rigid links with springs at their hinges, the method of comparison in §4.4.
//!
//! Two bodies of equal segments in the plane `X`–`Z`, the first clamped, a free hinge between them. Coordinates are the relative angles
//! `φ_i`; link `i` points to `(cos θ_i, sin θ_i)`, `θ_i = Σ φ`. The equations implement the library's [`EquationsOfMotion`] twice, by
//! recursion in O(n) and with a dense matrix, so that the same integrators solve them as the beams.

use foldwing::solve::stepper::{Method, Stepper};
use foldwing::solve::{
    EquationsOfMotion, Powers, Singular,
    newton::{Accuracy, Effort},
    point::Point,
};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix3, Vector2, Vector3};

/// Bodies of Table 4.
pub mod table_4 {
    /// Length of each body in m.
    pub const LENGTH_M: f64 = 10.0;
    /// Bending stiffness in N·m².
    pub const BENDING_N_M2: f64 = 1e4;
    /// Mass per length in kg/m.
    pub const MASS_KG_M: f64 = 1.0;
    /// Rotary inertia per length in kg·m.
    pub const ROTARY_KG_M: f64 = 0.1;
    /// Gravity along `−Z` in m/s².
    pub const GRAVITY_M_S2: f64 = 9.8;
}

/// Spring at the clamped end: bending of half a segment, or of a whole one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RootSpring {
    /// `EI/l` as between segments: the clamp is too soft by half a segment.
    WholeSegment,
    /// `2EI/l`.
    HalfSegment,
}

/// Solver of the linear systems.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Algebra {
    /// Articulated recursion, O(n).
    Recursive,
    /// Dense matrix and Cholesky factor, O(n³).
    Dense,
}

/// Kinematics of one link.
#[derive(Debug, Clone, Copy)]
struct Link {
    axis: Vector2<f64>,
    normal: Vector2<f64>,
    angle_rad: f64,
    rate_rad_s: f64,
    hinge_m: Vector2<f64>,
    hinge_velocity_m_s: Vector2<f64>,
}

/// The chain.
pub struct Segments {
    /// Stiffness at each hinge in N·m/rad.
    pub springs: Vec<f64>,
    algebra: Algebra,
    length_m: f64,
    mass_kg: f64,
    /// Moment of inertia about the segment's centre, kg·m².
    inertia_kg_m2: f64,
    links: Vec<Link>,
    wrenches: Vec<Vector3<f64>>,
    /// Column `P e` and pivot of each hinge, and shift to the next hinge.
    columns: Vec<Vector3<f64>>,
    pivots: Vec<f64>,
    carried: Vec<f64>,
    dense: Option<Cholesky<f64, Dyn>>,
}

impl Segments {
    /// Table 4 with `segments` segments per body.
    pub fn table_4(segments: usize, root: RootSpring, algebra: Algebra) -> Self {
        let length_m = table_4::LENGTH_M / segments as f64;
        let spring = table_4::BENDING_N_M2 / length_m;
        let mut springs = vec![spring; 2 * segments];
        springs[0] *= if root == RootSpring::HalfSegment { 2.0 } else { 1.0 };
        springs[segments] = 0.0;
        let mass_kg = table_4::MASS_KG_M * length_m;
        let still = Link {
            axis: Vector2::x(),
            normal: Vector2::y(),
            angle_rad: 0.0,
            rate_rad_s: 0.0,
            hinge_m: Vector2::zeros(),
            hinge_velocity_m_s: Vector2::zeros(),
        };
        Self {
            algebra,
            length_m,
            mass_kg,
            inertia_kg_m2: mass_kg * length_m * length_m / 12.0 + table_4::ROTARY_KG_M * length_m,
            links: vec![still; 2 * segments],
            wrenches: vec![Vector3::zeros(); 2 * segments + 1],
            columns: vec![Vector3::zeros(); 2 * segments],
            pivots: vec![0.0; 2 * segments],
            carried: vec![0.0; 2 * segments],
            dense: None,
            springs,
        }
    }

    /// Outward sweep.
    fn place(&mut self, q: &[f64], v: &[f64]) {
        let (mut angle, mut rate) = (0.0, 0.0);
        let (mut hinge, mut velocity) = (Vector2::zeros(), Vector2::zeros());
        for (link, (q, v)) in self.links.iter_mut().zip(q.iter().zip(v)) {
            angle += q;
            rate += v;
            let (sine, cosine) = f64::sin_cos(angle);
            let (axis, normal) = (Vector2::new(cosine, sine), Vector2::new(-sine, cosine));
            *link =
                Link { axis, normal, angle_rad: angle, rate_rad_s: rate, hinge_m: hinge, hinge_velocity_m_s: velocity };
            hinge += axis * self.length_m;
            velocity += normal * (rate * self.length_m);
        }
    }

    /// Kinetic, elastic and gravity energy in J.
    pub fn energy_j(&mut self, q: &[f64], v: &[f64]) -> [f64; 3] {
        self.place(q, v);
        let half = 0.5 * self.length_m;
        let kinetic = self.links.iter().map(|link| {
            let velocity = link.hinge_velocity_m_s + link.normal * (half * link.rate_rad_s);
            0.5 * (self.mass_kg * velocity.norm_squared() + self.inertia_kg_m2 * link.rate_rad_s.powi(2))
        });
        let gravity =
            self.links.iter().map(|link| self.mass_kg * table_4::GRAVITY_M_S2 * (link.hinge_m + link.axis * half).y);
        let elastic = self.springs.iter().zip(q).map(|(k, q)| 0.5 * k * q * q);
        [kinetic.sum(), elastic.sum(), gravity.sum()]
    }

    /// Inertia of a link about its inner hinge, for `(v_x, v_z, ω)`.
    fn spatial(&self, link: &Link, weight: f64) -> Matrix3<f64> {
        let half = 0.5 * self.length_m;
        let m = self.mass_kg;
        let s = link.normal * (m * half);
        Matrix3::new(m, 0.0, s.x, 0.0, m, s.y, s.x, s.y, self.inertia_kg_m2 + m * half * half) * weight
    }

    /// Mass matrix by the textbook formula in absolute angles, summed to relative ones.
    pub fn dense_mass(&self) -> DMatrix<f64> {
        let n = self.links.len();
        let l2 = self.mass_kg * self.length_m * self.length_m;
        let mut mass = DMatrix::from_fn(n, n, |i, j| {
            let outer = (n - 1 - i.max(j)) as f64;
            let share = if i == j { 0.25 + outer } else { 0.5 + outer };
            let own = if i == j { self.inertia_kg_m2 } else { 0.0 };
            l2 * share * (self.links[i].angle_rad - self.links[j].angle_rad).cos() + own
        });
        for i in (0..n - 1).rev() {
            for j in 0..n {
                mass[(i, j)] += mass[(i + 1, j)];
            }
        }
        for j in (0..n - 1).rev() {
            for i in 0..n {
                mass[(i, j)] += mass[(i, j + 1)];
            }
        }
        mass
    }
}

impl EquationsOfMotion for Segments {
    fn coordinates(&self) -> usize {
        self.links.len()
    }

    fn prescribe(&self, _: f64, _: &mut [f64], _: &mut [f64], _: &mut [f64]) {}

    fn residual(&mut self, _: f64, q: &[f64], v: &[f64], a: &[f64], residual: &mut [f64]) {
        self.place(q, v);
        let (l, half) = (self.length_m, 0.5 * self.length_m);
        let mut alpha = 0.0;
        let mut hinge = Vector2::new(0.0, table_4::GRAVITY_M_S2); // acceleration minus gravity
        for ((link, a), wrench) in self.links.iter().zip(a).zip(&mut self.wrenches) {
            alpha += a;
            let turning = link.normal * alpha - link.axis * link.rate_rad_s.powi(2);
            let force = (hinge + turning * half) * self.mass_kg;
            let moment = self.inertia_kg_m2 * alpha + half * link.normal.dot(&force);
            *wrench = Vector3::new(force.x, force.y, moment);
            hinge += turning * l;
        }
        let mut outer = Vector3::zeros();
        for (i, link) in self.links.iter().enumerate().rev() {
            let lever = l * link.normal.dot(&outer.xy());
            outer += self.wrenches[i];
            outer.z += lever;
            residual[i] = outer.z + self.springs[i] * q[i];
        }
    }

    fn factorize(&mut self, mass: f64, _: f64, stiffness: f64) -> Result<(), Singular> {
        if self.algebra == Algebra::Dense {
            let mut matrix = self.dense_mass() * mass;
            self.springs.iter().enumerate().for_each(|(i, k)| matrix[(i, i)] += stiffness * k);
            self.dense = Some(matrix.cholesky().ok_or(Singular { coordinate: 0 })?);
            return Ok(());
        }
        let mut outer = Matrix3::zeros(); // articulated inertia at the outer hinge, with its angle eliminated
        for i in (0..self.links.len()).rev() {
            let link = &self.links[i];
            let mut shift = Matrix3::identity();
            shift.fixed_view_mut::<2, 1>(0, 2).copy_from(&(link.normal * self.length_m));
            let inertia = self.spatial(link, mass) + shift.transpose() * outer * shift;
            let column: Vector3<f64> = inertia.column(2).into_owned();
            let pivot = column.z + stiffness * self.springs[i];
            if pivot.is_nan() || pivot <= 0.0 {
                return Err(Singular { coordinate: i });
            }
            self.columns[i] = column;
            self.pivots[i] = pivot;
            outer = inertia - column * column.transpose() / pivot;
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
        let mut outer = Vector3::zeros();
        for i in (0..self.links.len()).rev() {
            let lever = self.length_m * self.links[i].normal.dot(&outer.xy());
            outer.z += lever;
            self.carried[i] = x[i] + outer.z;
            outer -= self.columns[i] * (self.carried[i] / self.pivots[i]);
        }
        let mut motion = Vector3::zeros();
        for (i, x) in x.iter_mut().enumerate() {
            *x = (self.carried[i] - self.columns[i].dot(&motion)) / self.pivots[i];
            motion.z += *x;
            let shift = self.links[i].normal * (self.length_m * motion.z);
            motion += Vector3::new(shift.x, shift.y, 0.0);
        }
        self.norm(x)
    }

    fn norm(&mut self, change: &[f64]) -> f64 {
        let (mut angle, mut shift, mut norm) = (0.0, Vector2::zeros(), 0.0_f64);
        for (link, change) in self.links.iter().zip(change) {
            angle += change;
            shift += link.normal * (self.length_m * angle);
            norm = norm.max(f64::abs(angle)).max(shift.norm() / (2.0 * table_4::LENGTH_M));
            if angle.is_nan() {
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

/// Equations of a planar system with a free end.
pub trait PlanarChain: EquationsOfMotion {
    /// Position of the free end in m for a configuration.
    fn tip_m(&mut self, q: &[f64]) -> Vector2<f64>;
}

impl PlanarChain for Segments {
    fn tip_m(&mut self, q: &[f64]) -> Vector2<f64> {
        self.place(q, &vec![0.0; q.len()]);
        let last = self.links.last().expect("links");
        last.hinge_m + last.axis * self.length_m
    }
}

/// Position of the free end every 10 ms from 10 ms to 5 s, with fixed steps.
pub fn fall(segments: &mut impl PlanarChain, method: Method, step_s: f64) -> Vec<Vector2<f64>> {
    let n = segments.coordinates();
    let mut stepper = Stepper::new(method, n);
    let (mut start, mut end) = (Point::zeros(n), Point::zeros(n));
    let mut stages = vec![Point::zeros(n); method.continuation().inner_stages()];
    let zeros = vec![0.0; n];
    segments.residual(0.0, &zeros, &zeros, &zeros, &mut start.a);
    segments.factorize(1.0, 0.0, 0.0).expect("a positive mass matrix");
    segments.solve(&mut start.a);
    start.a.iter_mut().for_each(|a| *a = -*a);
    start.auxiliary.clone_from(&start.a);
    let per_sample = (0.01 / step_s).round() as usize;
    let mut tips = Vec::with_capacity(500);
    for step in 1..=500 * per_sample {
        let mut effort = Effort::default();
        stepper.step(segments, &start, step_s, (&mut end, &mut stages), NEWTON, &mut effort).expect("convergence");
        end.time_s = step as f64 * step_s;
        std::mem::swap(&mut start, &mut end);
        if step % per_sample == 0 {
            tips.push(segments.tip_m(&start.q));
        }
    }
    tips
}

/// Tolerance of Newton's iteration in a step, as displacement divided by the chain's length: far below the discretisation error.
pub const NEWTON: Accuracy = Accuracy::within(1e-8);
