//! Constant-strain links in their inner frames, several computed together, for the residual.
//!
//! Pose, Jacobian and rates are those of [`crate::math::se3::LinkGeometry`], NOTATION eqs. (K3)–(K5), before the rotation into the world
//! frame. Without shear the axis of a link has the direction `e = e_x`, for which most products vanish; the axis of links with shear is that
//! of `sheared_link.rs`. The result does not depend on the previous link, so that several links can be computed together.

use crate::math::lanes::{Coefficients, ZERO};
use crate::math::sheared_link::{self, Turning};
use crate::math::strain::{SHEAR_Y, SHEARED, STRETCH, TWIST, strains_at};
use nalgebra::{Matrix3, Vector3};
use std::array::from_fn;

pub use crate::math::lanes::{LANES, Lanes};
pub(crate) use crate::math::lanes::{Three, cross, dot, turned, turned_back};

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
        (arm_m, slope_m) = sheared_link::arm_and_slopes(&k, turn, [stretched_m, sheared_m[0], sheared_m[1]]);
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
        let first_rates = [b1, c1];
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
        if N == SHEARED {
            let axis =
                |of: &Strains<N>, along_m: Lanes| [along_m, length_m * of.0[SHEAR_Y], length_m * of.0[SHEAR_Y + 1]];
            let n = [self.stretched_m, self.sheared_m[0], self.sheared_m[1]];
            let of = Turning { turn, rate, second: pull, squares: [s1, s2], first_rates, second_rates: [b2, c2] };
            let axes = [n, axis(v, stretch_rate), axis(a, stretch_pull)];
            [motions.velocity, motions.acceleration] =
                sheared_link::motion(k, &links.tangent, &links.slope_m, &of, axes);
        }
        motions
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
