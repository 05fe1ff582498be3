//! The double pendulums of Otsuka et al. §4.1–4.3, by every method of Table 1.
//!
//! Body A lies along `X` and is attached to the origin by a ball joint; body B, along `+Z`, is attached to its end, so that `r_x^P + r_z^Q
//! = 0` as in §4.3; gravity acts along `−Y`. Point P is the end of A, Q the start of B.

use crate::conventional::assembly::{Assembly, Body};
use crate::conventional::constraint::{Constraint, End, Spring};
use crate::conventional::link::{Axis, Joint, turn};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use std::f64::consts::FRAC_PI_2;

/// Table 3: length in m; the section is a square of 20 mm.
pub const LENGTH_M: f64 = 1.8;
/// Table 3: Young's modulus in Pa.
pub const YOUNG_PA: f64 = 200e9;
/// Table 3: shear modulus in Pa.
pub const SHEAR_PA: f64 = 80e9;
/// Table 3: density in kg/m³.
pub const DENSITY_KG_M3: f64 = 7800.0;
/// Side of the square section in m.
pub const SIDE_M: f64 = 0.02;
/// Table 3: `I_yy = I_zz = 1.333 cm⁴`; `I_xx` is their sum.
pub const SECOND_M4: f64 = SIDE_M * SIDE_M * SIDE_M * SIDE_M / 12.0;
/// Gravity in m/s².
pub const GRAVITY_M_S2: f64 = 9.8;
/// Time step of the paper in s.
pub const STEP_S: f64 = 1e-4;

/// Joint between A and B.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Between {
    /// §4.1.
    Ball,
    /// §4.2: axes `r_y^P` and `r_z^Q`.
    Universal,
    /// §4.3: axis `r_x^P = −r_z^Q`.
    Revolute,
}

impl Between {
    /// All three.
    pub const ALL: [Self; 3] = [Self::Ball, Self::Universal, Self::Revolute];

    /// Name of the joint for file names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ball => "ball",
            Self::Universal => "universal",
            Self::Revolute => "revolute",
        }
    }
}

/// Attitude of body B at the start: its `r_x` along `+Z`.
pub fn start_of_b() -> Matrix3<f64> {
    turn(Axis::Y, -FRAC_PI_2)[0]
}

/// One body of Table 3.
pub fn body(parent: Option<usize>, joint: Joint, mount: Matrix3<f64>, elements: usize) -> Body {
    let (area, second) = (SIDE_M * SIDE_M, SECOND_M4);
    Body {
        parent,
        joint,
        mount,
        length_m: LENGTH_M,
        elements,
        mass_kg_m: DENSITY_KG_M3 * area,
        second_moment_kg_m: [DENSITY_KG_M3 * second; 2],
        stiffness: [YOUNG_PA * area, SHEAR_PA * 2.0 * second, YOUNG_PA * second, YOUNG_PA * second],
    }
}

/// Gravity along `−Y`.
pub fn gravity() -> Vector3<f64> {
    Vector3::new(0.0, -GRAVITY_M_S2, 0.0)
}

/// Ends P and Q.
pub fn joined_nodes(elements: usize) -> [End; 2] {
    [End { body: 0, node: elements }, End { body: 1, node: 0 }]
}

/// The paper's method and its initial state.
pub fn joint_parameters(between: Between, elements: usize) -> (Assembly, DVector<f64>) {
    let identity = Matrix3::identity();
    let (joint, mount) = match between {
        Between::Ball => (Joint::Ball, identity),
        Between::Universal => (Joint::Universal, identity),
        Between::Revolute => (Joint::Revolute(Axis::X), start_of_b()),
    };
    let bodies = vec![body(None, Joint::Ball, identity, elements), body(Some(0), joint, mount, elements)];
    let system = Assembly::new(bodies, vec![], vec![], gravity());
    let mut q = DVector::zeros(system.coordinates());
    q[0] = 1.0;
    let at = system.first[1];
    match between {
        Between::Ball => {
            let half = -0.5 * FRAC_PI_2; // −90° about r_y
            q[at] = half.cos();
            q[at + 2] = half.sin();
        }
        Between::Universal => q.rows_mut(at, 9).copy_from_slice(start_of_b().as_slice()),
        Between::Revolute => {}
    }
    (system, q)
}

/// The third conventional method: twelve variables at the root node of each body, multipliers, index 1.
pub fn index_1_dae(between: Between, elements: usize) -> (Assembly, DVector<f64>) {
    let identity = Matrix3::identity();
    let bodies = vec![body(None, Joint::Nodal, identity, elements), body(None, Joint::Nodal, identity, elements)];
    let [p, q_end] = joined_nodes(elements);
    let product = |k, l| Constraint::Product { a: (p, k), b: (q_end, l), value: 0.0 };
    let mut given = vec![Constraint::Pinned(End { body: 0, node: 0 }), Constraint::Coincident(p, q_end)];
    match between {
        Between::Ball => {}
        Between::Universal => given.push(product(2, 3)),
        Between::Revolute => given.extend([product(1, 1), product(1, 2)]),
    }
    let system = Assembly::new(bodies, given, vec![], gravity());
    let mut q = DVector::zeros(system.coordinates());
    set_node(&system, &mut q, 0, Vector3::zeros(), &identity);
    set_node(&system, &mut q, 1, Vector3::new(LENGTH_M, 0.0, 0.0), &start_of_b());
    (system, q)
}

/// The second conventional method: body B is free, with springs of `position_n_m` (N/m) between the joined nodes and,
/// at the revolute joint, of `gradient_n_m` (N·m) on `r_x^P + r_z^Q`.
pub fn penalty_joint(
    between: Between,
    elements: usize,
    position_n_m: f64,
    gradient_n_m: f64,
) -> (Assembly, DVector<f64>) {
    let identity = Matrix3::identity();
    let bodies = vec![body(None, Joint::Ball, identity, elements), body(None, Joint::Free, identity, elements)];
    let [p, q_end] = joined_nodes(elements);
    let mut springs = vec![Spring::Vectors { a: (p, 0), b: (q_end, 0), sign: -1.0, stiffness: position_n_m }];
    if between == Between::Revolute {
        springs.push(Spring::Vectors { a: (p, 1), b: (q_end, 3), sign: 1.0, stiffness: gradient_n_m });
    }
    let system = Assembly::new(bodies, vec![], springs, gravity());
    let mut q = DVector::zeros(system.coordinates());
    q[0] = 1.0;
    let at = system.first[1];
    let half = -0.5 * FRAC_PI_2;
    q[at] = LENGTH_M;
    q[at + 3] = half.cos();
    q[at + 5] = half.sin();
    (system, q)
}

/// The first conventional method: three angles about `z, y, x` at both joints. Body A's attitude is `chart · R(angles)`, so the chart
/// determines which attitude is singular; B's angles start at zero. For the revolute joint, fictitious springs of `redundant_n_m_rad`
/// restrain two angles.
pub fn rotation_angles(
    between: Between,
    elements: usize,
    chart: &Matrix3<f64>,
    redundant_n_m_rad: f64,
) -> (Assembly, DVector<f64>) {
    let identity = Matrix3::identity();
    let angles = Joint::Angles([Axis::Z, Axis::Y, Axis::X]);
    let carrier = |parent, attitude| Body { elements: 0, ..body(parent, Joint::Clamped, attitude, 1) };
    let revolute = between == Between::Revolute;
    let (chart_of_b, mount) = if revolute { (identity, start_of_b()) } else { (start_of_b(), identity) };
    let bodies = vec![
        carrier(None, *chart),
        body(Some(0), angles.clone(), identity, elements),
        carrier(Some(1), chart_of_b),
        body(Some(2), angles, mount, elements),
    ];
    let at = 3 + 4 * elements;
    let held = |index| Spring::Coordinate { index, rest: 0.0, stiffness: redundant_n_m_rad };
    let springs = if revolute { vec![held(at), held(at + 1)] } else { vec![] };
    let system = Assembly::new(bodies, vec![], springs, gravity());
    let mut q = DVector::zeros(system.coordinates());
    q.rows_mut(0, 3).copy_from_slice(&angles_of(&chart.transpose()));
    (system, q)
}

/// Angles about z, y, x of a rotation `R_z(α) R_y(β) R_x(γ)`; singular at `β = ±90°`.
fn angles_of(r: &Matrix3<f64>) -> [f64; 3] {
    [r[(1, 0)].atan2(r[(0, 0)]), -r[(2, 0)].asin(), r[(2, 1)].atan2(r[(2, 2)])]
}

fn set_node(system: &Assembly, q: &mut DVector<f64>, body: usize, r: Vector3<f64>, attitude: &Matrix3<f64>) {
    let at = system.first[body];
    q.rows_mut(at, 3).copy_from(&r);
    q.rows_mut(at + 3, 9).copy_from_slice(attitude.as_slice());
}

/// One step of the classical Runge–Kutta method, followed by a projection onto the constraints if `project` is set.
pub fn runge_kutta(system: &Assembly, q: &mut DVector<f64>, v: &mut DVector<f64>, h: f64, project: bool) {
    let a1 = system.accelerations(q, v).0;
    let (q2, v2) = (&*q + &*v * (h / 2.0), &*v + &a1 * (h / 2.0));
    let a2 = system.accelerations(&q2, &v2).0;
    let (q3, v3) = (&*q + &v2 * (h / 2.0), &*v + &a2 * (h / 2.0));
    let a3 = system.accelerations(&q3, &v3).0;
    let (q4, v4) = (&*q + &v3 * h, &*v + &a3 * h);
    let a4 = system.accelerations(&q4, &v4).0;
    *q += (&*v + (v2 + v3) * 2.0 + v4) * (h / 6.0);
    *v += (a1 + (a2 + a3) * 2.0 + a4) * (h / 6.0);
    if project {
        system.project(q, v);
    }
}

/// Highest angular frequency in rad/s of small motions about a state without velocity, in the null space of the constraints.
pub fn highest_frequency(system: &Assembly, q: &DVector<f64>) -> f64 {
    let still = DVector::zeros(q.len());
    let (equations, _) = system.equations(q, &still);
    let h = 1e-6;
    let force = |j: usize, sign: f64| {
        let mut shifted = q.clone();
        shifted[j] += sign * h;
        system.equations(&shifted, &still).0.force
    };
    let n = q.len();
    let columns: Vec<DVector<f64>> = (0..n).map(|j| (force(j, -1.0) - force(j, 1.0)) / (2.0 * h)).collect();
    let stiffness = DMatrix::from_columns(&columns);
    let gram = equations.jacobian.transpose() * &equations.jacobian;
    let eigen = gram.symmetric_eigen();
    let free: Vec<DVector<f64>> = (0..n)
        .filter(|&j| eigen.eigenvalues[j] < 1e-8 * eigen.eigenvalues.amax().max(1e-300))
        .map(|j| eigen.eigenvectors.column(j).into_owned())
        .collect();
    let basis = DMatrix::from_columns(&free);
    let mass = basis.transpose() * equations.mass * &basis;
    let inverse = mass.cholesky().expect("positive definite mass").l().try_inverse().expect("regular");
    let scaled = &inverse * (basis.transpose() * stiffness * &basis) * inverse.transpose();
    let symmetric = (&scaled + scaled.transpose()) * 0.5;
    symmetric.symmetric_eigenvalues().max().sqrt()
}
