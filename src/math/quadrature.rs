//! Gauss–Legendre quadrature on the unit interval.

/// Four-point rule on `[0, 1]`: `(abscissa, weight)`, exact for polynomials of degree 7.
pub const GAUSS_4: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_9, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_points_integrate_degree_seven() {
        for degree in 0..=7 {
            let sum: f64 = GAUSS_4.iter().map(|(x, w)| w * x.powi(degree)).sum();
            assert!((sum - 1.0 / f64::from(degree + 1)).abs() < 1e-15, "degree {degree}: {sum}");
        }
    }
}
