//! The constant-strain link: a beam segment whose frame satisfies `r' = R (1+εx, γy, γz)`, `R' = R [κ]×`.
//!
//! Its end pose is the SE(3) exponential `exp(ℓ ξ)`, `ξ = (1+εx, γy, γz; κx, κy, κz)`. Without shear everything is resolved in the world
//! frame: the inner frame first rotates the local strain, NOTATION eqs. (K2)–(K5); the shears add their own terms, eqs. (K11) and (K12).

use crate::math::so3::hat;
use crate::math::strain::{CURVATURES, EDGE, FLAP, SHEAR_Y, SHEARED, STRETCH, StrainMatrix, TWIST};
use nalgebra::{Matrix3, Vector3};
use std::array::from_fn;

/// `b = (1 − cos θ)/θ²` and `c = (θ − sin θ)/θ³` as functions of `x = θ²`, with first and second derivatives with respect to `x`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// `b(x)`.
    pub b: f64,
    /// `db/dx`.
    pub b1: f64,
    /// `d²b/dx²`.
    pub b2: f64,
    /// `c(x)`.
    pub c: f64,
    /// `dc/dx`.
    pub c1: f64,
    /// `d²c/dx²`.
    pub c2: f64,
}

/// Series coefficients `1/(2k+2)!` and `1/(2k+3)!` with alternating sign.
const SERIES: [(f64, f64); 14] = series();

const fn series() -> [(f64, f64); 14] {
    let mut table = [(0.0, 0.0); 14];
    let (mut factorial, mut k, mut sign) = (2.0, 0, 1.0);
    while k < 14 {
        let next = factorial * (2 * k + 3) as f64;
        table[k] = (sign / factorial, sign / next);
        factorial = next * (2 * k + 4) as f64;
        sign = -sign;
        k += 1;
    }
    table
}

/// Square of the angle above which the closed forms are used: at 1.5 rad their second derivatives are accurate to 1e-13, at 0.1 rad the
/// error would be 6e-7.
const CLOSED_FORM_ABOVE: f64 = 2.25;
/// Below this square of the angle (0.22 rad) eight terms are accurate to round-off; fourteen terms are up to [`CLOSED_FORM_ABOVE`].
const SHORT_SERIES_BELOW: f64 = 0.05;

impl Coefficients {
    /// Coefficients at `x = θ²` (rad²).
    #[inline]
    pub fn at(x: f64) -> Self {
        if x < SHORT_SERIES_BELOW {
            Self::by_series::<8>(x)
        } else if x < CLOSED_FORM_ABOVE {
            Self::by_series::<14>(x)
        } else {
            Self::by_closed_form(x)
        }
    }

    #[inline]
    fn by_series<const TERMS: usize>(x: f64) -> Self {
        // Horner's scheme for a polynomial and its first two derivatives.
        let (mut b, mut b1, mut b2) = (0.0, 0.0, 0.0);
        let (mut c, mut c1, mut c2) = (0.0, 0.0, 0.0);
        let mut k = TERMS;
        while k > 0 {
            k -= 1;
            b2 = b2 * x + b1;
            b1 = b1 * x + b;
            b = b * x + SERIES[k].0;
            c2 = c2 * x + c1;
            c1 = c1 * x + c;
            c = c * x + SERIES[k].1;
        }
        Self { b, b1, b2: 2.0 * b2, c, c1, c2: 2.0 * c2 }
    }

    fn by_closed_form(x: f64) -> Self {
        let angle = x.sqrt();
        let (sine, cosine) = angle.sin_cos();
        let sinc = sine / angle;
        let sinc1 = (cosine - sinc) / (2.0 * x);
        let sinc2 = (-0.5 * sinc - 3.0 * sinc1) / (2.0 * x);
        let half = (0.5 * angle).sin();
        let b = 2.0 * half * half / x;
        let b1 = (0.5 * sinc - b) / x;
        let b2 = (0.5 * sinc1 - 2.0 * b1) / x;
        let c = (1.0 - sinc) / x;
        let c1 = (-sinc1 - c) / x;
        let c2 = (-sinc2 - 2.0 * c1) / x;
        Self { b, b1, b2, c, c1, c2 }
    }
}

impl Coefficients {
    /// Coefficients at `x = θ²` (rad²), with the third derivatives of `b` and `c`: from series for `f_8` and `f_9` of `f_k = Σ (−x)^j/(2j+k)!`
    /// by `f_k = 1/k! − x f_{k+2}` and `f_k' = (k f_{k+2} − f_{k+1})/2`, with `f_2 = b` and `f_3 = c`; or from the lower derivatives where
    /// `x b = 1 − cos θ` and `x c = 1 − sin θ/θ` lose no digits.
    #[inline(always)]
    pub(crate) fn with_third(x: f64) -> (Self, [f64; 2]) {
        if x >= CLOSED_FORM_ABOVE {
            let own = Self::by_closed_form(x);
            let b3 = (-own.c1 - 0.5 * x * own.c2 - 3.0 * own.b2) / x;
            return (own, [b3, (own.b2 - 7.0 * own.c2) / (2.0 * x)]);
        }
        let [f8, f9] = if x < SHORT_SERIES_BELOW { last::<5>(x) } else { last::<11>(x) };
        let (f6, f7) = (1.0 / 720.0 - x * f8, 1.0 / 5040.0 - x * f9);
        let (f4, f5) = (1.0 / 24.0 - x * f6, 1.0 / 120.0 - x * f7);
        let (b, c) = (0.5 - x * f4, 1.0 / 6.0 - x * f5);
        let own = Self {
            b,
            b1: f4 - 0.5 * c,
            b2: 0.25 * (f4 - 5.0 * f5 + 8.0 * f6),
            c,
            c1: 1.5 * f5 - 0.5 * f4,
            c2: 0.25 * (f5 - 7.0 * f6 + 15.0 * f7),
        };
        let b3 = 0.125 * (48.0 * f8 - 33.0 * f7 + 9.0 * f6 - f5);
        let c3 = 0.125 * (105.0 * f9 - 57.0 * f8 + 12.0 * f7 - f6);
        (own, [b3, c3])
    }
}

/// `f_8` and `f_9` by their series; those of `b` and `c` have the same terms with the other sign, three terms later.
#[inline(always)]
fn last<const TERMS: usize>(x: f64) -> [f64; 2] {
    let mut sums = [0.0; 2];
    let mut k = TERMS + 3;
    while k > 3 {
        k -= 1;
        sums = [sums[0] * x - SERIES[k].0, sums[1] * x - SERIES[k].1];
    }
    sums
}

/// Pose of a link and the effect of its strains on its outer end, all in the world frame.
///
/// | symbol | field      | shape | unit  | meaning |
/// |--------|------------|-------|-------|---------|
/// | `d`    | `arm_m`    | 3     | m     | inner to outer end |
/// | `R_b`  | `rotation` | 3×3   | –     | world ← outer end |
/// | `J_v`  | `velocity` | 3 × `N` | m, m² | velocity of the outer end per strain rate |
/// | `J_ω`  | `spin`     | 3 × 3 | m     | angular velocity of the outer end per curvature rate |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link<const N: usize> {
    /// Vector `d = R_a p`.
    pub arm_m: Vector3<f64>,
    /// Rotation matrix `R_b = R_a Q`.
    pub rotation: Matrix3<f64>,
    /// Columns of `J_v` for `εx, κx, κy, κz`, with shear also `γy, γz`.
    pub velocity: [Vector3<f64>; N],
    /// Columns of `J_ω` for `κx, κy, κz`; stretch and shears do not rotate the outer end.
    pub spin: [Vector3<f64>; 3],
}

impl<const N: usize> Link<N> {
    /// A link of zero length with the axes of the world frame.
    pub const ZERO: Self = Self {
        arm_m: Vector3::new(0.0, 0.0, 0.0),
        rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        velocity: [Vector3::new(0.0, 0.0, 0.0); N],
        spin: [Vector3::new(0.0, 0.0, 0.0); 3],
    };

    /// Generalised forces `Jᵀ (F, M)` for a wrench at the outer end, world frame: N·m and N·m².
    #[inline]
    pub fn project(&self, force_n: &Vector3<f64>, moment_n_m: &Vector3<f64>) -> [f64; N] {
        from_fn(|strain| match CURVATURES.contains(&strain) {
            true => self.velocity[strain].dot(force_n) + self.spin[strain - TWIST].dot(moment_n_m),
            false => self.velocity[strain].dot(force_n),
        })
    }

    /// Columns of `J_ω` for all strains: those of stretch and shears are zero.
    #[inline]
    pub fn spin_columns(&self) -> [Vector3<f64>; N] {
        from_fn(|strain| match CURVATURES.contains(&strain) {
            true => self.spin[strain - TWIST],
            false => Vector3::zeros(),
        })
    }
}

/// Motion of a link's outer end relative to its inner frame due to strain rates, resolved in the world frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkRates {
    /// Velocity `R_a ṗ` in m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity `R_a w` in rad/s.
    pub spin: Vector3<f64>,
    /// Acceleration `R_a p̈` at zero strain acceleration in m/s².
    pub velocity_bias: Vector3<f64>,
    /// Angular acceleration `R_a ẇ` at zero strain acceleration in rad/s².
    pub spin_bias: Vector3<f64>,
}

/// Terms shared by pose and rates of one link; made by [`LinkGeometry::new`].
#[derive(Debug, Clone, Copy)]
pub struct LinkGeometry {
    coefficients: Coefficients,
    angle_squared: f64,
    length_m: f64,
    /// Stretched length `a = ℓ (1 + εx)`.
    stretched_m: f64,
    /// Transverse displacement `ℓ R_a (0, γy, γz)`; zero without shear.
    sheared_m: Vector3<f64>,
    /// Columns `ℓ V e_y`, `ℓ V e_z` of the Jacobian for shear.
    sheared_columns_m: [Vector3<f64>; 2],
    /// Rotation vector `Θ = ℓ R_a κ`.
    turn: Vector3<f64>,
    /// Axis `e = r_x` of the inner frame.
    axis: Vector3<f64>,
    /// `Θ × e` and `Θ × (Θ × e)`.
    axis_once: Vector3<f64>,
    axis_twice: Vector3<f64>,
    /// Direction of the arm `u = e + b Θ×e + c Θ×(Θ×e)`.
    direction: Vector3<f64>,
}

impl LinkGeometry {
    /// Pose and Jacobian of a link of `length_m` with `strain = (εx, κx, κy, κz)`, followed by `γy, γz` with shear, attached to the frame
    /// `inner` (world ← a), eqs. (K3), (K4).
    #[inline]
    pub fn new<const N: usize>(inner: &Matrix3<f64>, length_m: f64, strain: &[f64; N]) -> (Self, Link<N>) {
        let (e_x, e_y, e_z) = (column(inner, 0), column(inner, 1), column(inner, 2));
        let local = [length_m * strain[TWIST], length_m * strain[FLAP], length_m * strain[EDGE]];
        let turn = e_x * local[0] + e_y * local[1] + e_z * local[2];
        let x = local[0] * local[0] + local[1] * local[1] + local[2] * local[2];
        let k = Coefficients::at(x);
        let stretched = length_m * (1.0 + strain[STRETCH]);

        let once = [turn.cross(&e_x), turn.cross(&e_y), turn.cross(&e_z)];
        // Θ×(Θ×e) = Θ (Θ·e) − x e
        let twice = [turn * local[0] - e_x * x, turn * local[1] - e_y * x, turn * local[2] - e_z * x];

        let sinc = 1.0 - x * k.c;
        let rotation = Matrix3::from_columns(&[
            e_x + once[0] * sinc + twice[0] * k.b,
            e_y + once[1] * sinc + twice[1] * k.b,
            e_z + once[2] * sinc + twice[2] * k.b,
        ]);
        let tangent = [
            e_x + once[0] * k.b + twice[0] * k.c,
            e_y + once[1] * k.b + twice[1] * k.c,
            e_z + once[2] * k.b + twice[2] * k.c,
        ];
        let direction = tangent[0];

        // ∂u/∂Θ_j, eq. (K4), with e_y × e_x = −e_z, e_z × e_x = e_y.
        let slope = (once[0] * k.b1 + twice[0] * k.c1) * 2.0;
        let by_turn = [
            (turn - e_x * local[0]) * k.c + slope * local[0],
            -e_z * k.b - (e_x * local[1] + once[2]) * k.c + slope * local[1],
            e_y * k.b + (once[1] - e_x * local[2]) * k.c + slope * local[2],
        ];
        let scale = length_m * stretched;
        let spin = [tangent[0] * length_m, tangent[1] * length_m, tangent[2] * length_m];
        let mut link = Link {
            arm_m: direction * stretched,
            rotation,
            velocity: from_fn(|strain| match strain {
                STRETCH => direction * length_m,
                SHEAR_Y.. => spin[strain - SHEAR_Y + 1],
                TWIST.. => by_turn[strain - TWIST] * scale,
            }),
            spin,
        };
        let mut sheared_m = Vector3::zeros();
        if N == SHEARED {
            let local = [strain[SHEAR_Y], strain[SHEAR_Y + 1]];
            sheared_m = (e_y * local[0] + e_z * local[1]) * length_m;
            link.arm_m += spin[1] * local[0] + spin[2] * local[1];
            for (j, axis) in [e_x, e_y, e_z].iter().enumerate() {
                link.velocity[TWIST + j] += tangent_slope(&k, &turn, axis, &sheared_m) * length_m;
            }
        }
        let geometry = Self {
            coefficients: k,
            angle_squared: x,
            length_m,
            stretched_m: stretched,
            sheared_m,
            sheared_columns_m: [spin[1], spin[2]],
            turn,
            axis: e_x,
            axis_once: once[0],
            axis_twice: twice[0],
            direction,
        };
        (geometry, link)
    }

    /// Motion of the outer end for `strain_rate = (ε̇x, κ̇x, κ̇y, κ̇z)`, eq. (K5), followed by `γ̇y, γ̇z` with shear, eq. (K12).
    #[inline]
    pub fn rates<const N: usize>(&self, inner: &Matrix3<f64>, strain_rate: &[f64; N]) -> LinkRates {
        let k = &self.coefficients;
        let turn = &self.turn;
        let turn_rate = (column(inner, 0) * strain_rate[TWIST]
            + column(inner, 1) * strain_rate[FLAP]
            + column(inner, 2) * strain_rate[EDGE])
            * self.length_m;
        let stretch_rate = self.length_m * strain_rate[STRETCH];

        let x1 = 2.0 * turn.dot(&turn_rate);
        let x2 = 2.0 * turn_rate.dot(&turn_rate);
        let (b1, c1) = (k.b1 * x1, k.c1 * x1);
        let (b2, c2) = (k.b2 * x1 * x1 + k.b1 * x2, k.c2 * x1 * x1 + k.c1 * x2);

        let rate_axis = turn_rate.cross(&self.axis);
        let mixed = turn_rate.cross(&self.axis_once) + turn.cross(&rate_axis);
        let direction_rate = self.axis_once * b1 + rate_axis * k.b + self.axis_twice * c1 + mixed * k.c;
        let direction_bias = self.axis_once * b2
            + rate_axis * (2.0 * b1)
            + self.axis_twice * c2
            + mixed * (2.0 * c1)
            + turn_rate.cross(&rate_axis) * (2.0 * k.c);

        let swing = turn.cross(&turn_rate);
        // Θ×(Θ×Θ̇) = Θ (Θ·Θ̇) − x Θ̇
        let swing_twice = turn * (0.5 * x1) - turn_rate * self.angle_squared;
        let mut rates = LinkRates {
            velocity: self.direction * stretch_rate + direction_rate * self.stretched_m,
            spin: turn_rate + swing * k.b + swing_twice * k.c,
            velocity_bias: direction_rate * (2.0 * stretch_rate) + direction_bias * self.stretched_m,
            spin_bias: swing * b1 + swing_twice * c1 + turn_rate.cross(&swing) * k.c,
        };
        if N == SHEARED {
            let local = [strain_rate[SHEAR_Y], strain_rate[SHEAR_Y + 1]];
            let shear_rate = (column(inner, 1) * local[0] + column(inner, 2) * local[1]) * self.length_m;
            // V̇ y, and V̈ y without the second derivative of Θ
            let parts = |y: &Vector3<f64>| {
                let (once, rate_once) = (turn.cross(y), turn_rate.cross(y));
                (once, rate_once, turn.cross(&once), turn_rate.cross(&once) + turn.cross(&rate_once))
            };
            let first = |y: &Vector3<f64>| {
                let (once, rate_once, twice, mixed) = parts(y);
                once * b1 + rate_once * k.b + twice * c1 + mixed * k.c
            };
            let (once, rate_once, twice, mixed) = parts(&self.sheared_m);
            rates.velocity += self.sheared_columns_m[0] * local[0] + self.sheared_columns_m[1] * local[1];
            rates.velocity += first(&self.sheared_m);
            rates.velocity_bias += first(&shear_rate) * 2.0
                + once * b2
                + rate_once * (2.0 * b1)
                + twice * c2
                + mixed * (2.0 * c1)
                + turn_rate.cross(&rate_once) * (2.0 * k.c);
        }
        rates
    }
}

/// Derivative `∂(V n)/∂Θ` along `axis` for a constant vector `n`: NOTATION eq. (K11).
#[inline]
fn tangent_slope(k: &Coefficients, turn: &Vector3<f64>, axis: &Vector3<f64>, n: &Vector3<f64>) -> Vector3<f64> {
    let (once, by_axis) = (turn.cross(n), axis.cross(n));
    let along = turn.dot(axis);
    once * (2.0 * k.b1 * along)
        + by_axis * k.b
        + turn.cross(&once) * (2.0 * k.c1 * along)
        + (axis.cross(&once) + turn.cross(&by_axis)) * k.c
}

/// Derivative, with respect to the strains, of the generalised forces of a wrench on a link's strains: `H[k, j] = F·∂j_v,k/∂q_j +
/// M·∂j_ω,k/∂q_j`, NOTATION eqs. (L2) and (L42).
///
/// `force_n` (N) and `moment_n_m` (N·m) act at the outer end, are resolved in the inner frame like the Jacobian's columns `j` here, and are
/// held constant. Rows and columns are in the order of the strains: N·m, N·m² and N·m³. The matrix is not symmetric, because the columns of
/// angular velocity are not gradients.
pub fn link_curvature<const N: usize>(
    length_m: f64,
    strain: &[f64; N],
    force_n: &Vector3<f64>,
    moment_n_m: &Vector3<f64>,
) -> StrainMatrix<N> {
    let turn = Vector3::from_column_slice(&strain[CURVATURES]) * length_m;
    let x = turn.norm_squared();
    let k = Coefficients::at(x);
    let stretched = length_m * (1.0 + strain[STRETCH]);
    let identity = Matrix3::identity();
    let axis = Vector3::x();
    // F·u = F·e + b h + c s, h = F·(Θ×e), s = F·(Θ×(Θ×e)), with gradients and second derivatives with respect to Θ
    let (b1, c1) = (turn * (2.0 * k.b1), turn * (2.0 * k.c1));
    let spread = turn * turn.transpose();
    let (b2, c2) = (identity * (2.0 * k.b1) + spread * (4.0 * k.b2), identity * (2.0 * k.c1) + spread * (4.0 * k.c2));
    let pulled = |e: &Vector3<f64>| {
        let (once, twice) = (turn.cross(e), turn.cross(&turn.cross(e)));
        let (h, s) = (force_n.dot(&once), force_n.dot(&twice));
        let along = force_n.dot(e);
        let h1 = e.cross(force_n);
        let s1 = force_n * turn.dot(e) + e * force_n.dot(&turn) - turn * (2.0 * along);
        let s2 = force_n * e.transpose() + e * force_n.transpose() - identity * (2.0 * along);
        let gradient = b1 * h + h1 * k.b + c1 * s + s1 * k.c;
        let second = b1 * h1.transpose()
            + h1 * b1.transpose()
            + b2 * h
            + c1 * s1.transpose()
            + s1 * c1.transpose()
            + c2 * s
            + s2 * k.c;
        (gradient, second)
    };
    let (gradient, second) = pulled(&axis);
    // Vᵀ M = M + b M×Θ + c (Θ (Θ·M) − x M) and its derivative with respect to Θ
    let along = turn.dot(moment_n_m);
    let swing = moment_n_m.cross(&turn);
    let swing_twice = turn * along - moment_n_m * x;
    let spin = swing * b1.transpose()
        + hat(moment_n_m) * k.b
        + swing_twice * c1.transpose()
        + (identity * along + turn * moment_n_m.transpose() - moment_n_m * turn.transpose() * 2.0) * k.c;

    let mut curvature = StrainMatrix::<N>::zeros();
    let square = length_m * length_m;
    let mut bending = second * (stretched * square) + spin * square;
    let mut couple = |strain: usize, gradient: &Vector3<f64>| {
        for j in 0..3 {
            curvature[(strain, TWIST + j)] = square * gradient[j];
            curvature[(TWIST + j, strain)] = square * gradient[j];
        }
    };
    couple(STRETCH, &gradient);
    if N == SHEARED {
        for (shear, axis) in [(SHEAR_Y, Vector3::y()), (SHEAR_Y + 1, Vector3::z())] {
            let (gradient, second) = pulled(&axis);
            bending += second * (length_m * strain[shear] * square);
            couple(shear, &gradient);
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            curvature[(TWIST + i, TWIST + j)] = bending[(i, j)];
        }
    }
    curvature
}

#[inline]
fn column(matrix: &Matrix3<f64>, index: usize) -> Vector3<f64> {
    Vector3::new(matrix[(0, index)], matrix[(1, index)], matrix[(2, index)])
}

#[cfg(test)]
#[path = "se3_tests.rs"]
mod tests;
