//! One step of the recursion of Otsuka et al. (7)–(8): `h_outer = A(x) h_inner`, with exact derivatives.
//!
//! A node is a 4×3 matrix `h` whose rows are `r, r_x, r_y, r_z` in the root frame. Elements and all joints but one act on the rows, `A = L
//! ⊗ I₃`; the ball joint as printed in eq. (20) acts on the columns.

use nalgebra::{Matrix3, Matrix4, SMatrix, Vector3};

/// Nodal vectors `r, r_x, r_y, r_z` as rows.
pub type Node = SMatrix<f64, 4, 3>;

/// Axis of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// `r_x`.
    X,
    /// `r_y`.
    Y,
    /// `r_z`.
    Z,
}

/// Connection of the first node of a body to its parent, and the variables that describe it.
#[derive(Debug, Clone, PartialEq)]
pub enum Joint {
    /// No variables.
    Clamped,
    /// One angle about an axis of the parent, eqs. (14)–(15).
    Revolute(Axis),
    /// Nine direction cosines, eqs. (16)–(18); the body's `r_z` stays normal to the parent's `r_y`.
    Universal,
    /// Four Euler parameters; the rotation `c` of eq. (21) is taken in the parent's frame, `R_B = R_A c`.
    Ball,
    /// Four Euler parameters; `c` acts on components in the root frame as printed in eq. (20), `R_B = c R_A`.
    BallInRoot,
    /// Three rotations about successive axes: the first conventional method of Table 1.
    Angles([Axis; 3]),
    /// Position and four Euler parameters in the root frame: a body held only by springs.
    Free,
    /// The twelve nodal vectors themselves: the third conventional method of Table 1.
    Nodal,
}

impl Joint {
    /// Number of variables, `N_J` of Table 2.
    pub fn variables(&self) -> usize {
        match self {
            Self::Clamped => 0,
            Self::Revolute(_) => 1,
            Self::Universal => 9,
            Self::Ball | Self::BallInRoot => 4,
            Self::Angles(_) => 3,
            Self::Free => 7,
            Self::Nodal => 12,
        }
    }
}

/// A linear map of nodes.
#[derive(Debug, Clone, Copy)]
pub enum Map {
    /// Acts on the four rows.
    Rows(Matrix4<f64>),
    /// Multiplies the three gradients by the transpose from the right; the factor multiplies the position.
    Gradients(f64, Matrix3<f64>),
}

impl Map {
    /// The image of a node or of its derivative.
    pub fn apply(&self, node: &Node) -> Node {
        match self {
            Self::Rows(rows) => rows * node,
            Self::Gradients(position, turn) => {
                let mut image = node * turn.transpose();
                image.set_row(0, &(node.row(0) * *position));
                image
            }
        }
    }
}

/// A map with its derivatives at `(x, ẋ)`.
#[derive(Debug, Clone)]
pub struct Jet {
    /// `A(x)`.
    pub value: Map,
    /// `∂A/∂x_j`.
    pub partial: Vec<Map>,
    /// `Ȧ`.
    pub rate: Map,
    /// `Ä` at `ẍ = 0`.
    pub bias: Map,
}

/// Terms of the exponential's series; `‖κΔs‖` stays below 4 in the tests, where the remainder is below 1e-18.
const TERMS: u32 = 40;

/// Element: `exp(κ Δs)` of eqs. (5)–(7) and its derivatives, by power series.
pub fn element(length_m: f64, strain: &[f64], rate: &[f64]) -> Jet {
    let x = generator(1.0, strain) * length_m;
    let unit = |j: usize| {
        let mut e = [0.0; 4];
        e[j] = 1.0;
        generator(0.0, &e) * length_m
    };
    let directions: [Matrix4<f64>; 4] = std::array::from_fn(unit);
    let w = generator(0.0, rate) * length_m;

    // term k of exp(X), its derivatives with respect to the four strains, and the first and second along the rate
    let (mut term, mut sum) = (Matrix4::identity(), Matrix4::identity());
    let (mut along, mut along_sum) = ([Matrix4::zeros(); 4], [Matrix4::zeros(); 4]);
    let (mut first, mut first_sum) = (Matrix4::zeros(), Matrix4::zeros());
    let (mut second, mut second_sum) = (Matrix4::zeros(), Matrix4::zeros());
    for k in 1..TERMS {
        let share = 1.0 / f64::from(k);
        second = (x * second + w * first * 2.0) * share;
        first = (x * first + w * term) * share;
        for j in 0..4 {
            along[j] = (x * along[j] + directions[j] * term) * share;
            along_sum[j] += along[j];
        }
        term = x * term * share;
        sum += term;
        first_sum += first;
        second_sum += second;
        let last = term.amax() + first.amax() + second.amax() + along.iter().map(Matrix4::amax).sum::<f64>();
        if last < 1e-19 {
            break;
        }
    }
    Jet {
        value: Map::Rows(sum),
        partial: along_sum.map(Map::Rows).to_vec(),
        rate: Map::Rows(first_sum),
        bias: Map::Rows(second_sum),
    }
}

/// Matrix `κ` of eq. (6), whose 3×3 blocks are multiples of the identity; `stretch` is 1 for the matrix itself and 0 for its derivatives.
fn generator(stretch: f64, strain: &[f64]) -> Matrix4<f64> {
    let [ex, kx, ky, kz] = [strain[0], strain[1], strain[2], strain[3]];
    #[rustfmt::skip]
    let kappa = Matrix4::new(
        0.0, stretch + ex, 0.0, 0.0,
        0.0, 0.0, kz, -ky,
        0.0, -kz, 0.0, kx,
        0.0, ky, -kx, 0.0,
    );
    kappa
}

/// Joint: `C(η)` of eq. (8), then the constant rotation `mount` from body to parent frame at zero joint rotation.
pub fn joint(kind: &Joint, mount: &Matrix3<f64>, x: &[f64], rate: &[f64]) -> Jet {
    let count = kind.variables();
    let still = Jet { value: rows(1.0, &Matrix3::identity()), partial: vec![], rate: none(), bias: none() };
    let jet = match kind {
        Joint::Clamped => still,
        Joint::Revolute(axis) => {
            let [value, first, second] = turn(*axis, x[0]);
            Jet {
                value: rows(1.0, &value),
                partial: vec![rows(0.0, &first)],
                rate: rows(0.0, &(first * rate[0])),
                bias: rows(0.0, &(second * (rate[0] * rate[0]))),
            }
        }
        Joint::Universal => linear(count, x, rate, |x, one| rows(one, &Matrix3::from_column_slice(&x[..9]))),
        Joint::Ball => quadratic(x, rate, rows),
        Joint::BallInRoot => quadratic(x, rate, |position, c| Map::Gradients(position, *c)),
        Joint::Angles(axes) => angles(axes, x, rate),
        Joint::Free => {
            let turning = quadratic(&x[3..], &rate[3..], rows);
            let shift = |map: &Map, by: &[f64]| match map {
                Map::Rows(matrix) => {
                    let mut shifted = *matrix;
                    (0..3).for_each(|i| shifted[(0, i + 1)] = by[i]);
                    Map::Rows(shifted)
                }
                Map::Gradients(..) => *map,
            };
            let unit = |j| shift(&none(), &std::array::from_fn::<f64, 3, _>(|i| f64::from(u8::from(i == j))));
            Jet {
                value: shift(&turning.value, &x[..3]),
                partial: (0..3).map(unit).chain(turning.partial).collect(),
                rate: shift(&turning.rate, &rate[..3]),
                bias: turning.bias,
            }
        }
        Joint::Nodal => linear(count, x, rate, |x, one| {
            let mut matrix = Matrix4::zeros();
            matrix[(0, 0)] = one;
            (0..12).for_each(|i| matrix[(i / 3, 1 + i % 3)] = x[i]);
            Map::Rows(matrix)
        }),
    };
    let mounted = |map: Map| match (map, rows(1.0, mount)) {
        (Map::Rows(matrix), Map::Rows(mount)) => Map::Rows(mount * matrix),
        (map, _) => map, // the ball joint in the root frame is only used with the identity
    };
    Jet {
        value: mounted(jet.value),
        partial: jet.partial.into_iter().map(mounted).collect(),
        rate: mounted(jet.rate),
        bias: mounted(jet.bias),
    }
}

/// Maps `h = (r, R)` to `(one·r, R c)`: row `j` of the gradients becomes `Σ_k c_kj r_k`.
fn rows(one: f64, c: &Matrix3<f64>) -> Map {
    let mut matrix = Matrix4::zeros();
    matrix[(0, 0)] = one;
    matrix.fixed_view_mut::<3, 3>(1, 1).copy_from(&c.transpose());
    Map::Rows(matrix)
}

fn none() -> Map {
    Map::Rows(Matrix4::zeros())
}

/// Jet of a map that is linear in its variables; `one` is the constant factor of the position.
fn linear(count: usize, x: &[f64], rate: &[f64], map: impl Fn(&[f64], f64) -> Map) -> Jet {
    let unit = |j: usize| {
        let mut e = vec![0.0; count];
        e[j] = 1.0;
        map(&e, 0.0)
    };
    Jet { value: map(x, 1.0), partial: (0..count).map(unit).collect(), rate: map(rate, 0.0), bias: none() }
}

/// Jet of the rotation by Euler parameters, a quadratic form.
fn quadratic(x: &[f64], rate: &[f64], map: impl Fn(f64, &Matrix3<f64>) -> Map) -> Jet {
    let unit = |j: usize| {
        let mut e = [0.0; 4];
        e[j] = 1.0;
        map(0.0, &(euler_form(&e, x) * 2.0))
    };
    Jet {
        value: map(1.0, &euler_form(x, x)),
        partial: (0..4).map(unit).collect(),
        rate: map(0.0, &(euler_form(rate, x) * 2.0)),
        bias: map(0.0, &(euler_form(rate, rate) * 2.0)),
    }
}

/// Symmetric bilinear form whose diagonal is `c` of eq. (21).
fn euler_form(a: &[f64], b: &[f64]) -> Matrix3<f64> {
    let s = |i: usize, j: usize| a[i] * b[j] + a[j] * b[i]; // 2 ζi ζj on the diagonal a = b
    let d = |signs: [f64; 4]| (0..4).map(|i| signs[i] * a[i] * b[i]).sum::<f64>();
    Matrix3::new(
        d([1.0, 1.0, -1.0, -1.0]),
        s(1, 2) - s(0, 3),
        s(1, 3) + s(0, 2),
        s(1, 2) + s(0, 3),
        d([1.0, -1.0, 1.0, -1.0]),
        s(2, 3) - s(0, 1),
        s(1, 3) - s(0, 2),
        s(2, 3) + s(0, 1),
        d([1.0, -1.0, -1.0, 1.0]),
    )
}

/// Rotation about an axis and its first two derivatives; about `r_y` it is eq. (15).
pub fn turn(axis: Axis, angle_rad: f64) -> [Matrix3<f64>; 3] {
    let (sine, cosine) = angle_rad.sin_cos();
    let n = match axis {
        Axis::X => Vector3::x(),
        Axis::Y => Vector3::y(),
        Axis::Z => Vector3::z(),
    };
    let cross = n.cross_matrix();
    let plane = Matrix3::identity() - n * n.transpose();
    [n * n.transpose() + plane * cosine + cross * sine, cross * cosine - plane * sine, -(cross * sine) - plane * cosine]
}

/// Jet of three successive rotations, by the product rule.
fn angles(axes: &[Axis; 3], x: &[f64], rate: &[f64]) -> Jet {
    let turns: [[Matrix3<f64>; 3]; 3] = std::array::from_fn(|i| turn(axes[i], x[i]));
    let product = |orders: [usize; 3]| turns[0][orders[0]] * turns[1][orders[1]] * turns[2][orders[2]];
    let order = |i: usize, j: usize| {
        let mut orders = [0; 3];
        orders[i] += 1;
        orders[j] += 1;
        product(orders)
    };
    let first = |i: usize| product(std::array::from_fn(|k| usize::from(k == i)));
    let mut bias = Matrix3::zeros();
    for i in 0..3 {
        for j in 0..3 {
            bias += order(i, j) * (rate[i] * rate[j]);
        }
    }
    Jet {
        value: rows(1.0, &product([0, 0, 0])),
        partial: (0..3).map(|i| rows(0.0, &first(i))).collect(),
        rate: rows(0.0, &(0..3).map(|i| first(i) * rate[i]).sum::<Matrix3<f64>>()),
        bias: rows(0.0, &bias),
    }
}
