//! Positions of the curve names, placed at the ends of the curves without overlap.

/// Moves ascending positions apart and into a range, each by as little as its neighbours allow.
pub(super) fn spread<T>(ends: &mut [(f64, i32, T)], apart: f64, [top, bottom]: [f64; 2]) {
    let count = ends.len();
    for _ in 0..100 {
        for i in 1..count {
            let lack = apart - (ends[i].0 - ends[i - 1].0);
            if lack > 0.0 {
                ends[i - 1].0 -= 0.5 * lack;
                ends[i].0 += 0.5 * lack;
            }
        }
    }
    // positions outside the range are moved into it, and push their neighbours
    let mut least = top;
    for (i, end) in ends.iter_mut().enumerate() {
        end.0 = end.0.max(least).min(bottom - apart * (count - 1 - i) as f64);
        least = end.0 + apart;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names at coinciding curve ends are separated, in order, and within the picture.
    #[test]
    fn names_at_the_ends_stand_apart() {
        for places in [vec![5.0, 5.0, 5.0], vec![0.0, 1.0, 99.0, 100.0], vec![98.0, 99.0, 100.0, 100.0], vec![50.0]] {
            let mut ends: Vec<(f64, i32, ())> = places.iter().map(|place| (*place, 0, ())).collect();
            spread(&mut ends, 10.0, [0.0, 100.0]);
            let found: Vec<f64> = ends.iter().map(|end| end.0).collect();
            assert!(found.windows(2).all(|pair| pair[1] - pair[0] > 10.0 - 1e-6), "{places:?}: {found:?}");
            assert!(found.iter().all(|place| (-1e-9..=100.0 + 1e-9).contains(place)), "{places:?}: {found:?}");
        }
    }
}
