//! Arm of links with shear: its axis has any direction `n = ℓ (1 + εx, γy, γz)`, NOTATION eqs. (K11) and (K12).
//!
//! With `Θ × (Θ × y) = Θ (Θ·y) − y θ²` the rates of `V y = y + b Θ × y + c Θ × (Θ × y)` have one vector product for each vector `y`.

use crate::math::lanes::{Coefficients, Lanes, Three, cross, dot, turned};
use std::array::from_fn;

/// Arm `V n` and the columns of `∂(V n)/∂Θ`, in m.
#[inline(always)]
pub(super) fn arm_and_slopes(k: &Coefficients, turn: Three, n: Three) -> (Three, [Three; 3]) {
    let once = cross(turn, n);
    let twice = cross(turn, once);
    let arm = from_fn(|i| n[i] + k.b * once[i] + k.c * twice[i]);
    let (b1, c1, c) = (k.b1 * 2.0, k.c1 * 2.0, k.c * 2.0);
    // through b, c and θ², all along Θ_j
    let by_angle: Three = from_fn(|i| b1 * once[i] + c1 * twice[i] - c * n[i]);
    let (turned, aside) = (turn.map(|x| k.c * x), n.map(|x| k.b * x));
    let along = k.c * dot(turn, n);
    let mut slopes: [Three; 3] = from_fn(|j| from_fn(|i| by_angle[i] * turn[j] + turned[i] * n[j]));
    for (j, column) in slopes.iter_mut().enumerate() {
        // b e_j × n
        let (next, last) = ((j + 1) % 3, (j + 2) % 3);
        column[j] = column[j] + along;
        column[next] = column[next] - aside[last];
        column[last] = column[last] + aside[next];
    }
    (arm, slopes)
}

/// Rotation vector of a link with its rates, and the rates of `b` and `c` without the part of `Θ̈`.
pub(super) struct Turning {
    pub turn: Three,
    pub rate: Three,
    pub second: Three,
    /// `2 Θ·Θ̇` and `2 Θ̇·Θ̇`.
    pub squares: [Lanes; 2],
    /// `ḃ` and `ċ`.
    pub first_rates: [Lanes; 2],
    /// `b̈` and `c̈`.
    pub second_rates: [Lanes; 2],
}

/// Velocity and acceleration of the outer end for the axis `n` and its rates `n1`, `n2`, in the inner frame.
#[inline(always)]
pub(super) fn motion(
    k: &Coefficients,
    tangent: &[Three; 3],
    slope_m: &[Three; 3],
    of: &Turning,
    [n, n1, n2]: [Three; 3],
) -> [Three; 2] {
    let (turn, rate) = (of.turn, of.rate);
    let ([s1, s2], [b1, c1], [b2, c2]) = (of.squares, of.first_rates, of.second_rates);
    let angle_squared = dot(turn, turn);
    // V̇ y = (ḃ Θ + b Θ̇) × y + Θ (ċ Θ·y + c Θ̇·y) + Θ̇ (c Θ·y) − y (ċ θ² + c s₁)
    let spun: Three = from_fn(|i| b1 * turn[i] + k.b * rate[i]);
    let shrunk = c1 * angle_squared + k.c * s1;
    let first = |y: Three, along: Lanes, swept: Lanes| -> Three {
        let aside = cross(spun, y);
        let (on_turn, on_rate) = (c1 * along + k.c * swept, k.c * along);
        from_fn(|i| aside[i] + turn[i] * on_turn + rate[i] * on_rate - y[i] * shrunk)
    };
    let (along, swept) = (dot(turn, n), dot(rate, n));
    let of_axis = first(n, along, swept);
    let of_rate = first(n1, dot(turn, n1), dot(rate, n1));
    // V̈ n without the part of Θ̈, which `slope_m` has
    let (b1, c1) = (b1 * 2.0, c1 * 2.0);
    let twice_spun: Three = from_fn(|i| b2 * turn[i] + b1 * rate[i]);
    let aside = cross(twice_spun, n);
    let (on_turn, on_rate) = (c2 * along + c1 * swept, c1 * along + k.c * swept * 2.0);
    let shrunk = c2 * angle_squared + c1 * s1 + k.c * s2;
    let (by_rate, by_second) = (turned(tangent, &n1), turned(tangent, &n2));
    let by_turning = turned(slope_m, &of.second);
    [
        from_fn(|i| by_rate[i] + of_axis[i]),
        from_fn(|i| {
            of_rate[i] * 2.0 + aside[i] + turn[i] * on_turn + rate[i] * on_rate - n[i] * shrunk
                + by_second[i]
                + by_turning[i]
        }),
    ]
}
