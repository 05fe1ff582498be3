//! Constant-strain links in their inner frames, several computed together, for the residual.
//!
//! Pose, Jacobian and rates are those of [`crate::math::se3::LinkGeometry`], NOTATION eqs. (K3)–(K5), before the rotation into the world
//! frame. Without shear the axis of a link has the direction `e = e_x`, for which most products vanish; the shears add their own terms, eq.
//! (K11). The result does not depend on the previous link, so that several links can be computed together.

use crate::math::strain::{SHEAR_Y, SHEARED, STRETCH, TWIST, strains_at};
use nalgebra::{Matrix3, Vector3};
use std::array::from_fn;
use std::ops::{Add, Mul, Sub};

/// Number of links computed together: the vector width of the smallest supported machine, so that registers suffice.
pub const LANES: usize = 2;

/// One number for each of the links computed together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    /// The same number for all links.
    #[inline(always)]
    fn all(value: f64) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    fn largest(self) -> f64 {
        self.0.into_iter().fold(0.0, f64::max)
    }
}

macro_rules! lane_by_lane {
    ($trait:ident, $method:ident, $operator:tt) => {
        impl $trait for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(from_fn(|i| self.0[i] $operator other.0[i]))
            }
        }
        impl $trait<f64> for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                Self(self.0.map(|value| value $operator other))
            }
        }
    };
}

lane_by_lane!(Add, add, +);
lane_by_lane!(Sub, sub, -);
lane_by_lane!(Mul, mul, *);

/// Three components.
pub(crate) type Three = [Lanes; 3];

/// Scalar product `a·b` for each link.
#[inline(always)]
fn dot([a0, a1, a2]: Three, [b0, b1, b2]: Three) -> Lanes {
    a0 * b0 + a1 * b1 + a2 * b2
}

#[inline(always)]
pub(crate) fn cross([a0, a1, a2]: Three, [b0, b1, b2]: Three) -> Three {
    [a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0]
}

/// `b`, `c` and their first two derivatives with respect to `x = θ²`; and `1 − x c`.
struct Coefficients {
    sinc: Lanes,
    b: Lanes,
    b1: Lanes,
    b2: Lanes,
    c: Lanes,
    c1: Lanes,
    c2: Lanes,
}

/// Series coefficients `1/(2k+6)!` and `1/(2k+7)!` with alternating sign.
const SERIES: [(f64, f64); 10] = series();

const fn series() -> [(f64, f64); 10] {
    let mut table = [(0.0, 0.0); 10];
    let (mut factorial, mut k, mut sign) = (720.0, 0, 1.0);
    while k < 10 {
        let next = factorial * (2 * k + 7) as f64;
        table[k] = (sign / factorial, sign / next);
        factorial = next * (2 * k + 8) as f64;
        sign = -sign;
        k += 1;
    }
    table
}

/// Square of the angle up to which six terms are accurate to round-off (0.3 rad); ten terms are up to [`SERIES_BELOW`].
const SHORT_SERIES_BELOW: f64 = 0.09;
/// Square of the angle up to which the series are used (1.5 rad); closed forms above.
const SERIES_BELOW: f64 = 2.25;

impl Coefficients {
    #[inline(always)]
    fn at(x: Lanes) -> Self {
        let largest = x.largest();
        if largest < SHORT_SERIES_BELOW {
            Self::by_series::<6>(x)
        } else if largest < SERIES_BELOW {
            Self::by_series::<10>(x)
        } else {
            Self::one_by_one(x)
        }
    }

    /// Uses `f_k = Σ (−x)^j/(2j+k)!`, with `f_2 = b` and `f_3 = c`: series for `f_6` and `f_7`, the others by `f_k = 1/k! − x f_{k+2}`,
    /// derivatives by `f_k' = (k f_{k+2} − f_{k+1})/2`.
    #[inline(always)]
    fn by_series<const TERMS: usize>(x: Lanes) -> Self {
        let (last_6, last_7) = SERIES[TERMS - 1];
        let (mut f6, mut f7) = (Lanes::all(last_6), Lanes::all(last_7));
        for (term_6, term_7) in SERIES[..TERMS - 1].iter().rev() {
            f6 = f6 * x + *term_6;
            f7 = f7 * x + *term_7;
        }
        let one = Lanes::all(1.0);
        let f4 = one * (1.0 / 24.0) - x * f6;
        let f5 = one * (1.0 / 120.0) - x * f7;
        let b = one * 0.5 - x * f4;
        let c = one * (1.0 / 6.0) - x * f5;
        Self {
            sinc: one - x * c,
            b,
            b1: f4 - c * 0.5,
            b2: (f4 - f5 * 5.0 + f6 * 8.0) * 0.25,
            c,
            c1: f5 * 1.5 - f4 * 0.5,
            c2: (f5 - f6 * 7.0 + f7 * 15.0) * 0.25,
        }
    }

    #[cold]
    fn one_by_one(x: Lanes) -> Self {
        let each = x.0.map(crate::math::se3::Coefficients::at);
        let pick = |part: fn(&crate::math::se3::Coefficients) -> f64| Lanes(from_fn(|i| part(&each[i])));
        let c = pick(|k| k.c);
        Self {
            sinc: Lanes::all(1.0) - x * c,
            b: pick(|k| k.b),
            b1: pick(|k| k.b1),
            b2: pick(|k| k.b2),
            c,
            c1: pick(|k| k.c1),
            c2: pick(|k| k.c2),
        }
    }
}

/// Strains, strain rates or strain accelerations of the links: `(εx, κx, κy, κz)`, followed by `γy, γz` with shear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strains<const N: usize>(pub [Lanes; N]);

impl<const N: usize> Strains<N> {
    /// Reads links whose strains start at `first` in `coordinates`; unused lanes repeat the last link.
    #[inline(always)]
    pub fn read(coordinates: &[f64], first: &[usize; LANES]) -> Self {
        let each: [[f64; N]; LANES] = first.map(|first| strains_at(coordinates, first));
        Self(from_fn(|strain| Lanes(from_fn(|link| each[link][strain]))))
    }
}

impl Strains<SHEARED> {
    /// Reads links of which some have shear: `counts` are the numbers of their strains; shears of the other links are zero.
    #[inline(always)]
    pub fn read_mixed(coordinates: &[f64], first: &[usize; LANES], counts: [usize; LANES]) -> Self {
        Self(from_fn(|strain| {
            let of = |link: usize| if strain < counts[link] { coordinates[first[link] + strain] } else { 0.0 };
            Lanes(from_fn(of))
        }))
    }
}

/// Pose and Jacobian of the links in their inner frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalLinks {
    /// `Q`: its columns are the axes of the outer frame.
    pub rotation: [Three; 3],
    /// `V n`, without shear `a u`: vector from the inner to the outer end, m.
    pub arm_m: Three,
    /// Columns of `V`; the first is `u`.
    pub tangent: [Three; 3],
    /// Columns of `∂(V n)/∂Θ_j`, without shear `a ∂u/∂Θ_j`, m.
    pub slope_m: [Three; 3],
}

/// Motion of the outer ends relative to the links' inner frames, resolved in the inner frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalMotions {
    /// Velocity `ṗ` in m/s.
    pub velocity: Three,
    /// Angular velocity `w` in rad/s.
    pub spin: Three,
    /// Acceleration `p̈` in m/s².
    pub acceleration: Three,
    /// Angular acceleration `ẇ` in rad/s².
    pub spin_rate: Three,
}

const ZERO: Lanes = Lanes([0.0; LANES]);

impl LocalLinks {
    /// All zero, to be overwritten.
    pub const ZERO: Self =
        Self { rotation: [[ZERO; 3]; 3], arm_m: [ZERO; 3], tangent: [[ZERO; 3]; 3], slope_m: [[ZERO; 3]; 3] };
}

impl LocalMotions {
    /// No motion.
    pub const ZERO: Self = Self { velocity: [ZERO; 3], spin: [ZERO; 3], acceleration: [ZERO; 3], spin_rate: [ZERO; 3] };
}

/// Terms shared by poses and motions.
struct Shared {
    k: Coefficients,
    turn: Three,
    stretched_m: Lanes,
    /// Transverse displacement `ℓ (γy, γz)`; zero without shear.
    sheared_m: [Lanes; 2],
    /// Products `Θ_x Θ_y`, `Θ_x Θ_z`, `Θ_y² + Θ_z²`.
    products: Three,
}

/// Poses of links of `length_m` with strains `q`.
#[inline(always)]
pub fn poses<const N: usize>(length_m: Lanes, q: &Strains<N>) -> LocalLinks {
    place(length_m, q).1
}

/// Poses of links, and their motions with strain rates `v` and strain accelerations `a`.
#[inline(always)]
pub fn poses_and_motions<const N: usize>(
    length_m: Lanes,
    q: &Strains<N>,
    v: &Strains<N>,
    a: &Strains<N>,
) -> (LocalLinks, LocalMotions) {
    let (shared, links) = place(length_m, q);
    let motions = shared.motions(&links, length_m, v, a);
    (links, motions)
}

/// Columns of `I + f [Θ] + g [Θ]²`, from the products of different components of `Θ` and the sums of two squares.
#[inline(always)]
fn spread(f: Lanes, g: Lanes, [x, y, z]: Three, [xy, xz, yz]: Three, across: Three) -> [Three; 3] {
    let one = Lanes::all(1.0);
    let (fx, fy, fz) = (f * x, f * y, f * z);
    let (gxy, gxz, gyz) = (g * xy, g * xz, g * yz);
    [
        [one - g * across[0], gxy + fz, gxz - fy],
        [gxy - fz, one - g * across[1], gyz + fx],
        [gxz + fy, gyz - fx, one - g * across[2]],
    ]
}

/// Poses and Jacobians of links in their inner frames, eqs. (K3), (K4), with the terms that their rates share.
#[inline(always)]
fn place<const N: usize>(length_m: Lanes, q: &Strains<N>) -> (Shared, LocalLinks) {
    let turn: Three = from_fn(|i| length_m * q.0[TWIST + i]);
    let [x, y, z] = turn;
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let (xy, xz, yz) = (x * y, x * z, y * z);
    let k = Coefficients::at(xx + yy + zz);
    let stretched_m = length_m + length_m * q.0[STRETCH];

    let across = [yy + zz, xx + zz, xx + yy];
    let products = [xy, xz, yz];
    let rotation = spread(k.sinc, k.b, turn, products, across);
    let tangent = spread(k.b, k.c, turn, products, across);

    // a ∂u/∂Θ_j, eq. (K4)
    let (ab, ac) = (stretched_m * k.b, stretched_m * k.c);
    let (ab1, ac1) = (stretched_m * k.b1 * 2.0, stretched_m * k.c1 * 2.0);
    let both = [ZERO - ac1 * across[0], ab1 * z + ac1 * xy, ac1 * xz - ab1 * y];
    let (acx, acy, acz) = (ac * x, ac * y, ac * z);
    let mut slope_m = [
        [both[0] * x, both[1] * x + acy, both[2] * x + acz],
        [both[0] * y - acy * 2.0, both[1] * y + acx, both[2] * y - ab],
        [both[0] * z - acz * 2.0, both[1] * z + ab, both[2] * z + acx],
    ];
    let mut arm_m = tangent[0].map(|u| u * stretched_m);
    let mut sheared_m = [ZERO; 2];
    if N == SHEARED {
        sheared_m = from_fn(|i| length_m * q.0[SHEAR_Y + i]);
        let [ny, nz] = sheared_m;
        arm_m = from_fn(|i| arm_m[i] + tangent[1][i] * ny + tangent[2][i] * nz);
        // derivatives for the transverse part (0, n_y, n_z) of n in place of e
        let across_m = [ZERO, ny, nz];
        let once = cross(turn, across_m);
        let twice = cross(turn, once);
        let both: Three = from_fn(|i| (k.b1 * once[i] + k.c1 * twice[i]) * 2.0);
        let along = dot(turn, across_m);
        // e_j × n and e_j × (Θ × n) + Θ × (e_j × n) = Θ n_j + e_j (Θ·n) − 2 n Θ_j
        let aside = [[ZERO, ZERO - nz, ny], [nz, ZERO, ZERO], [ZERO - ny, ZERO, ZERO]];
        for (j, column) in slope_m.iter_mut().enumerate() {
            for (i, entry) in column.iter_mut().enumerate() {
                let mut spread = turn[i] * across_m[j] - across_m[i] * turn[j] * 2.0;
                if i == j {
                    spread = spread + along;
                }
                *entry = *entry + both[i] * turn[j] + k.b * aside[j][i] + k.c * spread;
            }
        }
    }
    let shared = Shared { k, turn, stretched_m, sheared_m, products: [xy, xz, across[0]] };
    (shared, LocalLinks { rotation, arm_m, tangent, slope_m })
}

impl Shared {
    /// Computes the motions by eq. (K5), plus the Jacobian times the strain accelerations.
    #[inline(always)]
    fn motions<const N: usize>(
        &self,
        links: &LocalLinks,
        length_m: Lanes,
        v: &Strains<N>,
        a: &Strains<N>,
    ) -> LocalMotions {
        let (k, turn) = (&self.k, self.turn);
        let rate: Three = from_fn(|i| length_m * v.0[TWIST + i]);
        let pull: Three = from_fn(|i| length_m * a.0[TWIST + i]);
        let (stretch_rate, stretch_pull) = (length_m * v.0[STRETCH], length_m * a.0[STRETCH]);
        let ([x, y, z], [x1, y1, z1]) = (turn, rate);

        let s1 = dot(turn, rate) * 2.0;
        let s2 = dot(rate, rate) * 2.0;
        let (b1, c1) = (k.b1 * s1, k.c1 * s1);
        let (b2, c2) = (k.b2 * s1 * s1 + k.b1 * s2, k.c2 * s1 * s1 + k.c1 * s2);

        // u = (1 − c n, c Θ_xΘ_y + b Θ_z, c Θ_xΘ_z − b Θ_y), n = Θ_y² + Θ_z², and its first and second derivative
        let [xy, xz, n] = self.products;
        let n1 = (y * y1 + z * z1) * 2.0;
        let n2 = (y1 * y1 + z1 * z1) * 2.0;
        let (xy1, xz1) = (x1 * y + x * y1, x1 * z + x * z1);
        let (xy2, xz2) = (x1 * y1 * 2.0, x1 * z1 * 2.0);
        let direction_rate = [
            ZERO - (c1 * n + k.c * n1),
            c1 * xy + k.c * xy1 + b1 * z + k.b * z1,
            c1 * xz + k.c * xz1 - b1 * y - k.b * y1,
        ];
        let sheared = (N == SHEARED).then(|| {
            let rates = from_fn(|i| length_m * v.0[SHEAR_Y + i]);
            let pulls = from_fn(|i| length_m * a.0[SHEAR_Y + i]);
            self.sheared_motion(links, rate, [rates, pulls], [b1, c1, b2, c2])
        });
        let (b1, c1) = (b1 * 2.0, c1 * 2.0);
        let direction_bias = [
            ZERO - (c2 * n + c1 * n1 + k.c * n2),
            c2 * xy + c1 * xy1 + k.c * xy2 + b2 * z + b1 * z1,
            c2 * xz + c1 * xz1 + k.c * xz2 - b2 * y - b1 * y1,
        ];

        let [t0, t1, t2] = links.tangent;
        let [g0, g1, g2] = links.slope_m;
        let swing = cross(turn, rate);
        let (once, twice) = (cross(turn, swing), cross(rate, swing));
        let double_rate = stretch_rate * 2.0;
        let mut motions = LocalMotions {
            velocity: from_fn(|i| t0[i] * stretch_rate + direction_rate[i] * self.stretched_m),
            spin: from_fn(|i| t0[i] * x1 + t1[i] * y1 + t2[i] * z1),
            acceleration: from_fn(|i| {
                direction_rate[i] * double_rate
                    + direction_bias[i] * self.stretched_m
                    + t0[i] * stretch_pull
                    + g0[i] * pull[0]
                    + g1[i] * pull[1]
                    + g2[i] * pull[2]
            }),
            spin_rate: from_fn(|i| {
                swing[i] * b1 * 0.5
                    + once[i] * c1 * 0.5
                    + twice[i] * k.c
                    + t0[i] * pull[0]
                    + t1[i] * pull[1]
                    + t2[i] * pull[2]
            }),
        };
        if let Some([velocity, acceleration]) = sheared {
            motions.velocity = from_fn(|i| motions.velocity[i] + velocity[i]);
            motions.acceleration = from_fn(|i| motions.acceleration[i] + acceleration[i]);
        }
        motions
    }

    /// Contribution of the shears to `ṗ` and `p̈`, eq. (K12), through the part `n = ℓ (0, γy, γz)`.
    #[inline(always)]
    fn sheared_motion(
        &self,
        links: &LocalLinks,
        rate: Three,
        [rates_m, pulls_m]: [[Lanes; 2]; 2],
        [b1, c1, b2, c2]: [Lanes; 4],
    ) -> [Three; 2] {
        let (k, turn) = (&self.k, self.turn);
        let across = |[y, z]: [Lanes; 2]| [ZERO, y, z];
        let (n, n1, n2) = (across(self.sheared_m), across(rates_m), across(pulls_m));
        // V̇ y, and V̈ y without the terms with the second derivative of Θ
        let once = |y: Three| [cross(turn, y), cross(rate, y)];
        let mixed = |[still, moving]: [Three; 2]| -> Three {
            let (a, b) = (cross(rate, still), cross(turn, moving));
            from_fn(|i| a[i] + b[i])
        };
        let first = |y: Three| -> Three {
            let parts = once(y);
            let (twice, mixed) = (cross(turn, parts[0]), mixed(parts));
            from_fn(|i| b1 * parts[0][i] + k.b * parts[1][i] + c1 * twice[i] + k.c * mixed[i])
        };
        let parts = once(n);
        let (twice, mixed, swift) = (cross(turn, parts[0]), mixed(parts), cross(rate, parts[1]));
        let (first_of_n, first_of_rate) = (first(n), first(n1));
        let through = |y: Three| turned(&links.tangent, &y);
        let (by_rate, by_pull) = (through(n1), through(n2));
        // the terms with the second derivative of Θ are included in `slope_m`
        [
            from_fn(|i| by_rate[i] + first_of_n[i]),
            from_fn(|i| {
                first_of_rate[i] * 2.0
                    + b2 * parts[0][i]
                    + b1 * parts[1][i] * 2.0
                    + c2 * twice[i]
                    + c1 * mixed[i] * 2.0
                    + k.c * swift[i] * 2.0
                    + by_pull[i]
            }),
        ]
    }
}

/// Vector of one link.
#[inline(always)]
pub fn vector(three: &Three, lane: usize) -> Vector3<f64> {
    Vector3::new(three[0].0[lane], three[1].0[lane], three[2].0[lane])
}

/// Matrix of one link, from its columns.
#[inline(always)]
pub fn matrix(columns: &[Three; 3], lane: usize) -> Matrix3<f64> {
    Matrix3::from_columns(&[vector(&columns[0], lane), vector(&columns[1], lane), vector(&columns[2], lane)])
}

/// Products of matrices, given by columns, with vectors.
#[inline(always)]
pub(crate) fn turned(columns: &[Three; 3], vector: &Three) -> Three {
    from_fn(|i| columns[0][i] * vector[0] + columns[1][i] * vector[1] + columns[2][i] * vector[2])
}

/// Products of the transposed matrices with vectors.
#[inline(always)]
pub(crate) fn turned_back(columns: &[Three; 3], vector: &Three) -> Three {
    columns.map(|column| dot(column, *vector))
}

impl LocalLinks {
    /// Generalised forces `Jᵀ (F, M)` of each link for wrenches at the outer ends, in the inner frames: N·m and N·m².
    #[inline(always)]
    pub(crate) fn project<const N: usize>(&self, length_m: Lanes, force_n: &Three, moment_n_m: &Three) -> [Lanes; N] {
        let bend = |j: usize| length_m * (dot(self.slope_m[j], *force_n) + dot(self.tangent[j], *moment_n_m));
        let shift = |j: usize| length_m * dot(self.tangent[j], *force_n);
        from_fn(|strain| match strain {
            STRETCH => shift(0),
            SHEAR_Y.. => shift(strain - SHEAR_Y + 1),
            TWIST.. => bend(strain - TWIST),
        })
    }
}

#[cfg(test)]
#[path = "local_link_tests.rs"]
mod tests;
