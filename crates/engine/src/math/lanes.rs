//! Numbers of several links that are computed together, their vectors, and the coefficients of the exponential.

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
    pub(super) fn all(value: f64) -> Self {
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

/// Zero for all links.
pub(super) const ZERO: Lanes = Lanes([0.0; LANES]);

/// Three components.
pub(crate) type Three = [Lanes; 3];

/// Scalar product `a·b` for each link.
#[inline(always)]
pub(crate) fn dot([a0, a1, a2]: Three, [b0, b1, b2]: Three) -> Lanes {
    a0 * b0 + a1 * b1 + a2 * b2
}

#[inline(always)]
pub(crate) fn cross([a0, a1, a2]: Three, [b0, b1, b2]: Three) -> Three {
    [a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0]
}

/// `b`, `c` and their first two derivatives with respect to `x = θ²`; and `1 − x c`.
pub(super) struct Coefficients {
    pub sinc: Lanes,
    pub b: Lanes,
    pub b1: Lanes,
    pub b2: Lanes,
    pub c: Lanes,
    pub c1: Lanes,
    pub c2: Lanes,
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
    pub(super) fn at(x: Lanes) -> Self {
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
