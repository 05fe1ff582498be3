//! Gauss–Legendre quadrature on the unit interval.

/// Four-point rule on `[0, 1]`: `(abscissa, weight)`, exact for polynomials of degree 7.
pub const GAUSS_4: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_9, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Nodes and weights of [`GAUSS_4`] on every smooth piece of `[from, to]`, which `breaks` divide, in any order; breaks outside are ignored.
/// The weights add up to `to − from`.
pub fn gauss_pieces(from: f64, to: f64, breaks: &[f64]) -> Vec<(f64, f64)> {
    let near = 1e-12 * (to - from).abs();
    let mut cuts: Vec<f64> = breaks.iter().copied().filter(|&cut| cut > from + near && cut < to - near).collect();
    cuts.extend([from, to]);
    cuts.sort_by(f64::total_cmp);
    let pieces = cuts.windows(2).map(|piece| (piece[0], piece[1] - piece[0]));
    pieces.flat_map(|(start, width)| GAUSS_4.map(|(x, weight)| (start + x * width, weight * width))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A kink at a break causes no error.
    #[test]
    fn pieces_integrate_a_kink_exactly() {
        let sum: f64 = gauss_pieces(-1.0, 2.0, &[0.5, 7.0, -1.0]).iter().map(|(x, w)| w * (x - 0.5).abs()).sum();
        assert!((sum - 2.25).abs() < 1e-15, "{sum}");
    }

    #[test]
    fn four_points_integrate_degree_seven() {
        for degree in 0..=7 {
            let sum: f64 = GAUSS_4.iter().map(|(x, w)| w * x.powi(degree)).sum();
            assert!((sum - 1.0 / f64::from(degree + 1)).abs() < 1e-15, "degree {degree}: {sum}");
        }
    }
}
