//! Reduction of curves with many points to the number that a figure can show.

use super::SIZE;
use std::ops::Range;

/// Finite points of a curve. If `x` ascends and there are many points, only the first, minimum, maximum and last one in every column of a
/// pixel's width are kept, which looks the same.
pub(super) fn thinned(points: &[[f64; 2]], x: &Range<f64>) -> Vec<[f64; 2]> {
    let finite: Vec<[f64; 2]> = points.iter().filter(|point| point.iter().all(|c| c.is_finite())).copied().collect();
    let columns = 2 * SIZE[0] as usize;
    if finite.len() <= 4 * columns || !finite.is_sorted_by(|a, b| a[0] <= b[0]) {
        return finite;
    }
    let column = |point: &[f64; 2]| ((point[0] - x.start) / (x.end - x.start) * columns as f64) as usize;
    let mut thin = Vec::with_capacity(4 * columns);
    for group in finite.chunk_by(|a, b| column(a) == column(b)) {
        let height = |i: &usize, j: &usize| group[*i][1].total_cmp(&group[*j][1]);
        let (least, most) = ((0..group.len()).min_by(height), (0..group.len()).max_by(height));
        let mut kept: Vec<usize> = [Some(0), least, most, Some(group.len() - 1)].into_iter().flatten().collect();
        kept.sort_unstable();
        kept.dedup();
        thin.extend(kept.into_iter().map(|i| group[i]));
    }
    thin
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thinning preserves the peaks exactly.
    #[test]
    fn thinned_curves_keep_their_peaks() {
        let mut points: Vec<[f64; 2]> = (0..100_000).map(|i| [f64::from(i), (0.01 * f64::from(i)).sin()]).collect();
        points[31_415][1] = 7.0;
        points[92_653][1] = -5.0;
        let thin = thinned(&points, &(0.0..100_000.0));
        assert!(thin.len() <= 8 * SIZE[0] as usize + 8, "{} points", thin.len());
        for i in [0, 31_415, 92_653, 99_999] {
            assert!(thin.contains(&points[i]), "point {i}");
        }
        assert!(thin.is_sorted_by(|a, b| a[0] < b[0]));
    }
}
