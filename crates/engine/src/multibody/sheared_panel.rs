//! Panel in which the six strains of an element with shear are eliminated, NOTATION eq. (D23).
//!
//! The matrix of the strains `X`, its coupling `Uᵀ` with the inner node and, for the outer half of a pair, its coupling with the strains of the
//! inner half stand below each other in six columns. The Cholesky factor `L` of `X` is applied to the rows below at the same time: they become
//! `Z = U L⁻ᵀ` and `Yᵀ = D_BAᵀ L⁻ᵀ`. All updates are products of these, without a further solution: `−Z Zᵀ` of the inner node, `−Z Y` and
//! `−Yᵀ Y` of the inner half.

use crate::math::strain::SHEARED;

/// One number for each strain, or the three components of velocity and spin, or of force and moment.
pub(super) type Six = [f64; SHEARED];

/// Column of one strain.
#[derive(Debug, Clone, Copy)]
pub(super) struct Column {
    /// Rows of the strains, from the diagonal on: `X`, then `L` with inverted diagonal.
    pub own: Six,
    /// Rows of the inner node's twist: `Uᵀ`, then `Z`.
    pub twist: Six,
    /// Rows of the strains of a pair's inner half: the coupling `D_BA`, then `Yᵀ`; zero for other elements.
    pub sibling: Six,
}

impl Column {
    pub(super) const ZERO: Self = Self { own: [0.0; SHEARED], twist: [0.0; SHEARED], sibling: [0.0; SHEARED] };
}

/// Rows of the inner half in a panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sibling {
    /// None: an inner half, or an element without halves.
    None,
    /// A diagonal coupling: `Y` is a lower triangular matrix.
    Diagonal,
    /// Any coupling.
    Full,
}

/// Strains of an element, eliminated, eq. (D23).
#[derive(Debug, Clone, Copy)]
pub(crate) struct ShearedFactor {
    pub(super) columns: [Column; SHEARED],
    /// Right-hand side in a solution, `L⁻¹ g`.
    pub(super) right_hand: Six,
}

impl ShearedFactor {
    pub(super) const ZERO: Self = Self { columns: [Column::ZERO; SHEARED], right_hand: [0.0; SHEARED] };
}

const NONE: u8 = 0;
const DIAGONAL: u8 = 1;
const FULL: u8 = 2;

/// Last row of the inner half that differs from zero in column `j`, plus one.
#[inline(always)]
const fn rows<const SIBLING: u8>(j: usize) -> usize {
    match SIBLING {
        NONE => 0,
        DIAGONAL => j + 1,
        _ => SHEARED,
    }
}

#[inline(always)]
fn subtract<const C: usize, const J: usize, const SIBLING: u8>(column: &mut Column, done: &Column) {
    let factor = done.own[C];
    for r in C..SHEARED {
        column.own[r] -= factor * done.own[r];
    }
    for r in 0..SHEARED {
        column.twist[r] -= factor * done.twist[r];
    }
    for r in 0..rows::<SIBLING>(J) {
        column.sibling[r] -= factor * done.sibling[r];
    }
}

#[inline(always)]
fn scale<const C: usize, const SIBLING: u8>(column: &mut Column) -> bool {
    let pivot = column.own[C];
    let inverse = 1.0 / pivot.sqrt();
    column.own[C] = inverse;
    for r in C + 1..SHEARED {
        column.own[r] *= inverse;
    }
    for r in 0..SHEARED {
        column.twist[r] *= inverse;
    }
    for r in 0..rows::<SIBLING>(C) {
        column.sibling[r] *= inverse;
    }
    pivot > 0.0 && pivot.is_finite()
}

/// Reduces the columns in their order, each by those before it; written out, so that the lengths of all loops are constants.
fn reduce<const SIBLING: u8>(panel: &mut [Column; SHEARED]) -> bool {
    macro_rules! reduced {
        ($($c:literal: [$($j:literal)*])*) => {
            $({
                let mut column = panel[$c];
                $(subtract::<$c, $j, SIBLING>(&mut column, &panel[$j]);)*
                if !scale::<$c, SIBLING>(&mut column) {
                    return false;
                }
                panel[$c] = column;
            })*
        };
    }
    reduced!(0: [] 1: [0] 2: [0 1] 3: [0 1 2] 4: [0 1 2 3] 5: [0 1 2 3 4]);
    true
}

/// `sum − factor · rows` for the whole pairs of rows from row `FIRST` on.
#[inline(always)]
fn minus<const FIRST: usize>(mut sum: Six, rows: &Six, factor: f64) -> Six {
    for r in FIRST / 2 * 2..SHEARED {
        sum[r] -= factor * rows[r];
    }
    sum
}

/// A sum of [`minus`] over the listed columns: their rows `rows`, with the row `c` of `by` as factors; written out, so that sums stay in
/// registers.
macro_rules! some {
    (minus<$first:literal>($columns:expr, $start:expr, $rows:ident, $by:ident, $c:literal), $($j:literal)*) => {{
        let mut sum = $start;
        $(sum = minus::<$first>(sum, &$columns[$j].$rows, $columns[$j].$by[$c]);)*
        sum
    }};
}

/// [`some`] over all columns.
macro_rules! every {
    ($($of:tt)*) => { some!($($of)*, 0 1 2 3 4 5) };
}

impl ShearedFactor {
    /// Eliminates the strains; false at a pivot that is not positive or not finite.
    #[inline(always)]
    pub(super) fn reduce(&mut self, sibling: Sibling) -> bool {
        match sibling {
            Sibling::None => reduce::<NONE>(&mut self.columns),
            Sibling::Diagonal => reduce::<DIAGONAL>(&mut self.columns),
            Sibling::Full => reduce::<FULL>(&mut self.columns),
        }
    }

    /// Forward substitution `L⁻¹ g`.
    #[inline(always)]
    pub(super) fn forward(&self, mut g: Six) -> Six {
        for j in 0..SHEARED {
            let own = &self.columns[j].own;
            g[j] *= own[j];
            for r in j + 1..SHEARED {
                g[r] -= own[r] * g[j];
            }
        }
        g
    }

    /// Back substitution `L⁻ᵀ y`.
    #[inline(always)]
    pub(super) fn back(&self, mut y: Six) -> Six {
        for j in (0..SHEARED).rev() {
            let own = &self.columns[j].own;
            for r in j + 1..SHEARED {
                y[j] -= own[r] * y[r];
            }
            y[j] *= own[j];
        }
        y
    }

    /// Sum of the rows of the inner node, weighted: `Z y`.
    #[inline(always)]
    pub(super) fn on_twist(&self, y: &Six) -> Six {
        self.sum(y, |column| &column.twist)
    }

    /// Sum of the rows of the inner half, weighted: `Yᵀ y`.
    #[inline(always)]
    pub(super) fn on_sibling(&self, y: &Six) -> Six {
        self.sum(y, |column| &column.sibling)
    }

    #[inline(always)]
    fn sum(&self, y: &Six, of: impl Fn(&Column) -> &Six) -> Six {
        let mut sum = [0.0; SHEARED];
        for (column, y) in self.columns.iter().zip(y) {
            let rows = of(column);
            for r in 0..SHEARED {
                sum[r] += rows[r] * y;
            }
        }
        sum
    }

    /// Subtracts the symmetric product `Z Zᵀ` from the lower triangle of a matrix by columns.
    pub(super) fn subtract_twist_square(&self, lower: &mut [Six; SHEARED]) {
        macro_rules! columns {
            ($($c:literal)*) => {
                $(lower[$c] = every!(minus<$c>(&self.columns, lower[$c], twist, twist, $c));)*
            };
        }
        columns!(0 1 2 3 4 5);
    }

    /// Contributions of an eliminated outer half to the inner one, eq. (D14): the coupling `G = −Z Y` of the middle node with the strains, by
    /// columns, and the lower triangle of `ΔD = −Yᵀ Y`, by columns. `TRIANGULAR`: `Y` is a lower triangular matrix.
    pub(super) fn leave<const TRIANGULAR: bool>(&self, twist: &mut [Six; SHEARED], block: &mut [Six; SHEARED]) {
        let zero = [0.0; SHEARED];
        macro_rules! columns {
            ($($c:literal: [$($j:literal)*])*) => {
                $(
                    (twist[$c], block[$c]) = match TRIANGULAR {
                        true => (
                            some!(minus<0>(&self.columns, zero, twist, sibling, $c), $($j)*),
                            some!(minus<$c>(&self.columns, zero, sibling, sibling, $c), $($j)*),
                        ),
                        false => (
                            every!(minus<0>(&self.columns, zero, twist, sibling, $c)),
                            every!(minus<$c>(&self.columns, zero, sibling, sibling, $c)),
                        ),
                    };
                )*
            };
        }
        columns!(0: [0 1 2 3 4 5] 1: [1 2 3 4 5] 2: [2 3 4 5] 3: [3 4 5] 4: [4 5] 5: [5]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::SMatrix;

    type Matrix = SMatrix<f64, SHEARED, SHEARED>;

    /// A matrix without structure.
    fn any(seed: f64) -> Matrix {
        Matrix::from_fn(|i, j| (1.0 + seed * (3.1 * i as f64 + 1.7 * j as f64 + 0.4 * (i * j) as f64)).sin())
    }

    fn panel(x: &Matrix, u: &Matrix, coupling: &Matrix) -> ShearedFactor {
        let mut factor = ShearedFactor::ZERO;
        for (j, column) in factor.columns.iter_mut().enumerate() {
            for i in 0..SHEARED {
                column.own[i] = x[(i, j)];
                column.twist[i] = u[(i, j)];
                column.sibling[i] = coupling[(j, i)];
            }
        }
        factor
    }

    /// The products of the panel, eq. (D23), are the Schur complements by a dense inverse, for full and for diagonal couplings; 1e-13: round-off of
    /// matrices of condition 30.
    #[test]
    fn products_are_schur_complements() {
        let x = any(1.0) * any(1.0).transpose() + Matrix::identity() * 0.5;
        let u = any(2.0);
        let inverse = x.try_inverse().unwrap();
        let diagonal = Matrix::from_diagonal(&any(3.0).column(0).into_owned());
        for (kind, coupling) in [(Sibling::Full, any(4.0)), (Sibling::Diagonal, diagonal)] {
            let mut factor = panel(&x, &u, &coupling);
            assert!(factor.reduce(kind));
            let mut of_twist = [[0.0; SHEARED]; SHEARED];
            factor.subtract_twist_square(&mut of_twist);
            let (mut twist, mut block) = (of_twist, of_twist);
            match kind {
                Sibling::Diagonal => factor.leave::<true>(&mut twist, &mut block),
                Sibling::None | Sibling::Full => factor.leave::<false>(&mut twist, &mut block),
            }
            let rows = coupling.transpose();
            for (found, first, second, lower) in
                [(&of_twist, u, u, true), (&twist, u, rows, false), (&block, rows, rows, true)]
            {
                let known = -(first * inverse * second.transpose());
                for j in 0..SHEARED {
                    for i in if lower { j } else { 0 }..SHEARED {
                        assert!((found[j][i] - known[(i, j)]).abs() < 1e-13, "{kind:?}: {i} {j}");
                    }
                }
            }
            let g: Six = [0.3, -1.0, 0.7, 2.0, -0.2, 1.1];
            let y = factor.forward(g);
            let solved = inverse * nalgebra::SVector::from(g);
            let back = factor.back(y);
            assert!((0..SHEARED).all(|i| (back[i] - solved[i]).abs() < 1e-13), "{kind:?}");
            let (twist, half) = (factor.on_twist(&y), factor.on_sibling(&y));
            let known = [u * solved, coupling.transpose() * solved];
            assert!((0..SHEARED).all(|i| (twist[i] - known[0][i]).abs() < 1e-13), "{kind:?}");
            assert!((0..SHEARED).all(|i| (half[i] - known[1][i]).abs() < 1e-13), "{kind:?}");
        }
    }

    /// A matrix that is not positive has no factor, for each of the pivots; nor has one with NaN.
    #[test]
    fn bad_pivots_are_reported() {
        for bad in 0..SHEARED {
            for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
                let mut x = Matrix::identity();
                x[(bad, bad)] = value;
                let mut factor = panel(&x, &any(2.0), &any(4.0));
                assert!(!factor.reduce(Sibling::Full), "{bad} {value}");
            }
        }
    }
}
