//! Wrenches of the forces of inertia on nodes with the variations of nodes, NOTATION eq. (X31).

#![expect(
    clippy::needless_range_loop,
    reason = "several arrays have the index, and iterators are not inlined into code for vectors"
)]

use crate::math::wide::Fours;
use crate::multibody::derivative::chain::Timed;
use crate::multibody::derivative::gains::{Gains, Quad, TURNS, UNDAMPED, Undamped, add_turned, add_undamped, set};
use crate::multibody::derivative::spot::Spot;
use nalgebra::Matrix4;

/// Axes of a node, and the factors of its rotation and both derivatives in the variations of the loads of its axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turning {
    axes: [Quad; 3],
    /// Per order of the derivative and axis.
    factors: [[Quad; 3]; 3],
}

impl Turning {
    pub const ZERO: Self = Self { axes: [[0.0; 4]; 3], factors: [[[0.0; 4]; 3]; 3] };

    /// `damps`: with the damping of the mass.
    #[inline(always)]
    pub fn write(&mut self, spot: &Spot, damps: bool) {
        for k in 0..3 {
            let [r, r1, r2] = &spot.axes[k];
            let [by_rate, by_turn] = if damps { spot.damped[k] } else { [r1 * 2.0, *r2] };
            set(&mut self.axes[k], 0, r);
            set(&mut self.factors[0][k], 0, &by_turn);
            set(&mut self.factors[1][k], 0, &by_rate);
            set(&mut self.factors[2][k], 0, r);
        }
    }
}

/// Sum of the vectors of the three axes with the entries of a row of a mass block; `SLIM`: the block couples only `r` and `r_x`.
#[inline(always)]
fn weighted<const SLIM: bool, V: Fours>(
    fours: V,
    vectors: &[Quad; 3],
    row: usize,
    mass: impl Fn(usize, usize) -> f64,
) -> Quad {
    let mut own = [0.0; 4];
    for k in 0..3 {
        if !SLIM || row == k + 1 || (row < 2 && k == 0) {
            fours.add(&mut own, mass(row, k + 1), &vectors[k]);
        }
    }
    own
}

/// Adds to the wrench on a node, with the axes of `rows`, per unit of the variation of another, with the axes of `columns`, the part due to a
/// mass block that does not depend on the first derivative of the displacement; mass-proportional damping makes the part that does its rate times
/// that of the second derivative. `SLIM`: see [`weighted`].
#[inline(always)]
pub(super) fn add_inertia<const SLIM: bool, V: Fours>(
    fours: V,
    sum: &mut Undamped,
    mass: impl Fn(usize, usize) -> f64,
    [rows, columns]: [&Turning; 2],
) {
    // entries of the columns of a cross product: [j, k] is [v]× in its rows j and k
    let crossed = |[x, y, z, _]: Quad| [([1, 2], [z, -y]), ([2, 0], [x, -z]), ([0, 1], [y, -x])];
    let first = crossed(weighted::<SLIM, V>(fours, &rows.axes, 0, |i, j| mass(j, i)));
    for (i, ([j, k], [on_j, on_k])) in first.into_iter().enumerate() {
        sum[i][i] += mass(0, 0);
        sum[i][4 + j] += on_j;
        sum[i][4 + k] += on_k;
    }
    for order in 0..3 {
        let place = 3 * (order + 1);
        let on = |row: usize| weighted::<SLIM, V>(fours, &columns.factors[order], row, &mass);
        let (force, on) = (crossed(on(0)), [on(1), on(2), on(3)]);
        let mut moments = [[0.0; 4]; 3];
        for j in 0..3 {
            for k in 0..3 {
                fours.add(&mut moments[j], -rows.axes[k][j], &on[k]);
            }
        }
        let whole = moments[0][0] + moments[1][1] + moments[2][2];
        for (i, ([j, k], [on_j, on_k])) in force.into_iter().enumerate() {
            let column = &mut sum[place + i];
            column[j] -= on_j;
            column[k] -= on_k;
            if let Some(moment) = column.last_chunk_mut::<4>() {
                fours.add(moment, 1.0, &moments[i]);
                moment[i] -= whole;
            }
        }
    }
}

/// Coupling of the ends of an element by its mass: wrench on one per unit of the variation of the other.
#[derive(Debug, Clone)]
pub(super) struct Coupling {
    pub outer_inner: Undamped,
    pub inner_outer: Undamped,
    /// Ratio of the columns of the first derivative of the displacement to those of the second.
    pub alpha_1_s: f64,
}

impl Coupling {
    pub const ZERO: Self =
        Self { outer_inner: [[0.0; 8]; UNDAMPED], inner_outer: [[0.0; 8]; UNDAMPED], alpha_1_s: 0.0 };

    #[inline(always)]
    pub fn write<const SLIM: bool, V: Fours>(
        &mut self,
        fours: V,
        mass: &Matrix4<f64>,
        [outer, inner]: [&Turning; 2],
        alpha_1_s: f64,
    ) {
        *self = Self { alpha_1_s, ..Self::ZERO };
        add_inertia::<SLIM, V>(fours, &mut self.outer_inner, |i, j| mass[(i, j)], [outer, inner]);
        add_inertia::<SLIM, V>(fours, &mut self.inner_outer, |i, j| mass[(j, i)], [inner, outer]);
    }

    /// Adds the wrench on the inner node with its own variation, which moves the outer node at the end of an arm.
    #[inline(always)]
    pub fn add_carried_on_inner<V: Fours>(&self, fours: V, sum: &mut Gains<8>, [r, r1, r2]: &Timed) {
        let (own, alpha_1_s) = (&self.inner_outer, self.alpha_1_s);
        add_undamped(fours, sum, own, alpha_1_s);
        let [turn, turn1, turn2] = TURNS;
        add_turned(fours, sum, turn, own, 0, &(r2 + r1 * alpha_1_s));
        add_turned(fours, sum, turn1, own, 0, &(r1 * 2.0 + r * alpha_1_s));
        add_turned(fours, sum, turn2, own, 0, r);
    }
}
