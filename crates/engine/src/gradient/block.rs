//! Linear systems with several right sides whose matrix is only known by its products, near the identity: minimal residuals over all
//! directions of all right sides so far (block GCR).

use crate::gradient::{add, dot};

/// Remainder, as a share of the right side, at which a system is solved.
const SOLVED: f64 = 1e-13;
/// Maximum number of rounds, each of a direction per right side that is not yet solved.
const MAX_ROUNDS: usize = 40;
/// Share of an image that is left beside those of the other directions, below which it is one of them.
const SAME: f64 = 1e-9;
/// Remainder that is accepted where no direction is left: round-off of the images.
const ROUND_OFF: f64 = 1e-11;

/// Solves `A x = right` for each of `rights`; `image` gives `A` times each of some directions.
///
/// # Errors
/// That of `image`; the remaining share, if it does not fall.
pub(super) fn solve<E: From<Remains>>(
    mut left: Vec<Vec<f64>>,
    mut image: impl FnMut(&[Vec<f64>]) -> Result<Vec<Vec<f64>>, E>,
) -> Result<Vec<Vec<f64>>, E> {
    let wholes: Vec<f64> = left.iter().map(|right| size(right)).collect();
    let mut solutions: Vec<Vec<f64>> = left.iter().map(|right| vec![0.0; right.len()]).collect();
    let mut rows: Vec<[Vec<f64>; 2]> = Vec::new();
    for _ in 0..MAX_ROUNDS {
        let unsolved = left.iter().zip(&wholes).filter(|(left, whole)| size(left) > SOLVED * *whole);
        let directions: Vec<Vec<f64>> = unsolved.map(|(left, _)| scaled(left)).collect();
        if directions.is_empty() {
            return Ok(solutions);
        }
        let images = image(&directions)?;
        let known = rows.len();
        for (mut direction, mut image) in directions.into_iter().zip(images) {
            let whole = dot(&image, &image).sqrt();
            // twice: the first removal leaves round-off of the image
            for _ in 0..2 {
                for [other, image_of] in &rows {
                    let share = dot(&image, image_of);
                    add(&mut direction, -share, other);
                    add(&mut image, -share, image_of);
                }
            }
            let rest = dot(&image, &image).sqrt();
            if rest <= SAME * whole || !rest.is_finite() {
                continue;
            }
            [&mut direction, &mut image].into_iter().flatten().for_each(|entry| *entry /= rest);
            for (left, solution) in left.iter_mut().zip(&mut solutions) {
                let share = dot(left, &image);
                add(solution, share, &direction);
                add(left, -share, &image);
            }
            rows.push([direction, image]);
        }
        if rows.len() == known {
            break;
        }
    }
    let share = left.iter().zip(&wholes).fold(0.0f64, |most, (left, whole)| most.max(size(left) / whole));
    if share <= ROUND_OFF { Ok(solutions) } else { Err(Remains(share).into()) }
}

/// The share of a right side that is left.
pub(super) struct Remains(pub f64);

fn size(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |size, value| size.max(value.abs()))
}

fn scaled(values: &[f64]) -> Vec<f64> {
    let size = size(values);
    values.iter().map(|value| value / size).collect()
}
