//! Elimination of the unknowns of one link or joint, NOTATION eq. (X32).

#![expect(
    clippy::needless_range_loop,
    reason = "several arrays have the index, and iterators are not inlined into code for vectors"
)]

use crate::math::strain::{STRAINS, StrainMatrix};
use crate::math::wide::Fours;
use crate::multibody::derivative::chain::Column;
use crate::multibody::derivative::coupling::Coupling;
use crate::multibody::derivative::gains::{
    ACCELERATION, Gains, PLACES, Padded, Quad, RATE, STATE, TURNS, UNDAMPED, add_undamped, carried, combined, set,
};
use crate::multibody::derivative::link::Link;
use nalgebra::Vector3;

/// Factors of one link or joint with `N` unknowns.
#[derive(Debug, Clone)]
pub(super) struct LinkFactor<const N: usize> {
    /// Displacement and rotation of the outer end per unit of each unknown.
    pub reach: [[f64; 6]; N],
    /// Variation of the outer node per unit of each unknown.
    pub moved: [[f64; STATE]; N],
    /// Inverse of the pivot block, by columns.
    pub inverse: [[f64; N]; N],
    /// Wrench passed to the carrier per unit of each unknown.
    pub passed: [[f64; 6]; N],
    /// Inverse times the change of the unknowns' forces with the carrier's variation.
    pub by_carrier: Gains<N>,
    /// Coupling of a pair by columns: of the inner half's forces with the outer half's unknowns, of the outer half times its inverse.
    pub sibling: [[f64; N]; N],
}

/// Contributions of the outer half of a pair to the inner one.
pub(super) struct Carried<const N: usize> {
    pub wrench: [[f64; N]; 6],
    pub by_middle: Gains<N>,
    pub block: [[f64; N]; N],
}

impl<const N: usize> Carried<N> {
    pub const ZERO: Self = Self { wrench: [[0.0; N]; 6], by_middle: [[0.0; N]; STATE], block: [[0.0; N]; N] };
}

/// A link as the elimination needs it.
pub(super) struct Given<'a, const N: usize> {
    pub link: &'a Link,
    pub columns: &'a [Column],
    pub gain_s: f64,
    /// Forces on the unknowns themselves, by columns.
    pub own: [[f64; N]; N],
    /// Wrench on the outer node per unit of its variation, and coupling by the mass of the element.
    pub outer: &'a Gains<8>,
    pub cross: Option<&'a Coupling>,
}

impl<const N: usize> LinkFactor<N> {
    pub const ZERO: Self = Self {
        reach: [[0.0; 6]; N],
        moved: [[0.0; STATE]; N],
        inverse: [[0.0; N]; N],
        passed: [[0.0; 6]; N],
        by_carrier: [[0.0; N]; STATE],
        sibling: [[0.0; N]; N],
    };
}

/// Forces on the unknowns due to a wrench at the outer end.
#[inline(always)]
fn reached<V: Fours, const N: usize>(fours: V, rows: &[[f64; N]; 6], wrench: &Padded) -> [f64; N] {
    let mut sum = [0.0; N];
    for k in 0..6 {
        fours.add(&mut sum, wrench[PLACES[k]], &rows[k]);
    }
    sum
}

/// `sum += columns · rows`, a matrix with its unknowns side by side.
#[inline(always)]
fn add_rows<V: Fours, const N: usize, const C: usize>(
    fours: V,
    sum: &mut [[f64; N]; 6],
    columns: &[Padded; C],
    rows: &[[f64; N]; C],
) {
    for k in 0..C {
        for i in 0..6 {
            fours.add(&mut sum[i], columns[k][PLACES[i]], &rows[k]);
        }
    }
}

/// `[arm]×` by columns, in zeros that stay.
#[inline(always)]
fn write_crossing(columns: &mut [Quad; 3], arm: &Vector3<f64>) {
    for (column, [next, last]) in [[1, 2], [2, 0], [0, 1]].into_iter().enumerate() {
        columns[column][next] = arm[last];
        columns[column][last] = -arm[next];
    }
}

/// Adds the wrench at the carrier of a wrench at the end of an arm, which is given by [`write_crossing`].
#[inline(always)]
fn add_moved_in<V: Fours>(fours: V, sum: &mut Padded, wrench: &Padded, arm: &[Quad; 3]) {
    fours.add(sum, 1.0, wrench);
    let Some(moment) = sum.last_chunk_mut::<4>() else { return };
    for k in 0..3 {
        fours.add(moment, wrench[k], &arm[k]);
    }
}

/// Inverse without pivoting, by columns; `None` at a pivot that is not positive or not finite: the block is positive but for the terms of
/// the motion.
#[inline(always)]
fn inverse<V: Fours, const N: usize>(fours: V, mut block: [[f64; N]; N]) -> Option<[[f64; N]; N]> {
    for k in 0..N {
        let pivot = block[k][k];
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        let own = 1.0 / pivot;
        let mut column = block[k];
        column[k] = 0.0;
        for (_, other) in block.iter_mut().enumerate().filter(|(j, _)| *j != k) {
            let share = other[k] * own;
            other[k] = 0.0;
            fours.add(other, -share, &column);
            other[k] = share;
        }
        for entry in 0..N {
            block[k][entry] = -column[entry] * own;
        }
        block[k][k] = own;
    }
    Some(block)
}

/// Eliminates the unknowns of a link into its factor; returns the change of the wrench at the carrier with its variation. `from_sibling`: the
/// terms that the outer half of a pair passes to the inner one.
#[inline(always)]
pub(super) fn eliminate<V: Fours, const N: usize>(
    fours: V,
    given: &Given<N>,
    from_sibling: Option<&Carried<N>>,
    factor: &mut LinkFactor<N>,
    (on_inner, crossing): (&mut Gains<8>, &mut [Quad; 3]),
) -> Option<()> {
    let Given { link, columns, gain_s, own, outer, cross } = given;
    let (g, g2) = (*gain_s, gain_s * gain_s);
    let arm = &link.arm;
    // by rows, the unknowns side by side: reach and variation of the outer node
    let (mut rows, mut moved_rows) = ([[0.0; N]; 6], [[0.0; N]; STATE]);
    for (j, column) in columns.iter().enumerate().take(N) {
        let ([l, l1, l2], [w, w1, w2]) = (&column.linear, &column.angular);
        let (reach, moved) = (&mut factor.reach[j], &mut factor.moved[j]);
        set(reach, 0, l);
        set(reach, 3, w);
        set(moved, RATE, &(l * g + l1 * g2));
        set(moved, ACCELERATION, &(l + l1 * (2.0 * g) + l2 * g2));
        set(moved, TURNS[0], &(w * g2));
        set(moved, TURNS[1], &(w * g + w1 * g2));
        set(moved, TURNS[2], &(w + w1 * (2.0 * g) + w2 * g2));
        for i in 0..6 {
            rows[i][j] = reach[i];
        }
        for k in 0..STATE {
            moved_rows[k][j] = moved[k];
        }
    }
    let mut on_outer = carried(fours, outer, arm);
    if let Some(cross) = cross {
        add_undamped(fours, &mut on_outer, &cross.outer_inner, cross.alpha_1_s);
    }
    let mut by_carrier = [[0.0; N]; STATE];
    for k in 0..STATE {
        by_carrier[k] = reached(fours, &rows, &on_outer[k]);
    }
    for (j, column) in columns.iter().enumerate().take(N) {
        for i in 0..3 {
            by_carrier[TURNS[0] + i][j] += column.turned[i];
        }
    }
    let mut wrench = [[0.0; N]; 6];
    add_rows(fours, &mut wrench, outer, &moved_rows);
    let mut block = *own;
    if let Some(Carried { wrench: wrenches, by_middle, block: own }) = from_sibling {
        let by_inner = carried(fours, by_middle, arm);
        for k in 0..STATE {
            fours.add(&mut by_carrier[k], 1.0, &by_inner[k]);
        }
        for i in 0..6 {
            fours.add(&mut wrench[i], 1.0, &wrenches[i]);
        }
        for j in 0..N {
            fours.add(&mut block[j], 1.0, &own[j]);
            for k in 0..STATE {
                fours.add(&mut block[j], factor.moved[j][k], &by_middle[k]);
            }
        }
    }
    for j in 0..N {
        for i in 0..6 {
            fours.add(&mut block[j], wrench[i][j], &rows[i]);
        }
    }
    // the wrench passed to the carrier
    let force = [wrench[0], wrench[1], wrench[2]];
    for (i, [j, k]) in [[1, 2], [2, 0], [0, 1]].into_iter().enumerate() {
        let moment = &mut wrench[3 + i];
        fours.add(moment, arm[0][j], &force[k]);
        fours.add(moment, -arm[0][k], &force[j]);
        fours.add(moment, g2 * link.force[k], &rows[j]);
        fours.add(moment, -g2 * link.force[j], &rows[k]);
    }
    if let Some(cross) = cross {
        let mut moved = [[0.0; N]; UNDAMPED];
        for k in 0..UNDAMPED {
            moved[k] = moved_rows[ACCELERATION + k];
            if k < 3 {
                fours.add(&mut moved[k], cross.alpha_1_s, &moved_rows[RATE + k]);
            }
        }
        add_rows(fours, &mut wrench, &cross.inner_outer, &moved);
    }
    let mut passed = [[0.0; 8]; N];
    for j in 0..N {
        for i in 0..6 {
            passed[j][PLACES[i]] = wrench[i][j];
            factor.passed[j][i] = wrench[i][j];
        }
    }
    factor.inverse = inverse(fours, block)?;
    if let Some(cross) = cross {
        cross.add_carried_on_inner(fours, on_inner, arm);
    }
    write_crossing(crossing, &arm[0]);
    for k in 0..STATE {
        factor.by_carrier[k] = combined(fours, &factor.inverse, &by_carrier[k]);
        let own = &mut on_inner[k];
        add_moved_in(fours, own, &on_outer[k], crossing);
        for j in 0..N {
            fours.add(own, -factor.by_carrier[k][j], &passed[j]);
        }
    }
    // the force turns with the arm
    let along = link.force.dot(&arm[0]);
    for k in 0..3 {
        let turn = &mut on_inner[TURNS[0] + k];
        turn[4 + k] -= along;
        for i in 0..3 {
            turn[4 + i] += arm[0][i] * link.force[k];
        }
    }
    Some(())
}

/// A matrix over the strains by columns.
#[inline(always)]
pub(super) fn columns_of(matrix: &StrainMatrix) -> [[f64; STRAINS]; STRAINS] {
    matrix.data.0
}
