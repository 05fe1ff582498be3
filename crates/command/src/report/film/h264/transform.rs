//! Transforms and quantisers of 4 × 4 blocks (ITU-T H.264, clause 8.5); blocks are stored row by row.

/// Zigzag order of the coefficients of a block in the stream.
pub(super) const SCAN: [usize; 16] = [0, 1, 4, 8, 5, 2, 3, 6, 9, 12, 13, 10, 7, 11, 14, 15];

/// A block of differences or coefficients.
pub(super) type Block = [i32; 16];

/// Quantiser parameter of luma and chroma: below 30, where both are equal.
pub(super) const QP: i32 = 22;

/// Quantiser factors by `QP mod 6`: positions with both frequencies even, both odd, others.
const FORWARD: [[i32; 3]; 6] = [
    [13107, 5243, 8066],
    [11916, 4660, 7490],
    [10082, 4194, 6554],
    [9362, 3647, 5825],
    [8192, 3355, 5243],
    [7282, 2893, 4559],
];
/// Factors of the inverse quantiser.
const BACKWARD: [[i32; 3]; 6] = [[10, 16, 13], [11, 18, 14], [13, 20, 16], [14, 23, 18], [16, 25, 20], [18, 29, 23]];

const fn kind(i: usize) -> usize {
    match (i / 4 % 2, i % 2) {
        (0, 0) => 0,
        (1, 1) => 1,
        _ => 2,
    }
}

const SHIFT: i32 = 15 + QP / 6;

/// Quantised level: the magnitude divided by the step, rounded up where its fractional part is at least `1 − 1/share`.
fn level(value: i32, factor: i32, (shift, share): (i32, i32)) -> i32 {
    let size = (i64::from(value.abs()) * i64::from(factor) + (1_i64 << shift) / i64::from(share)) >> shift;
    (size as i32) * value.signum()
}

/// The forward transform.
pub(super) fn forward(block: &Block) -> Block {
    let once = |a: [i32; 4]| {
        let (s0, s1, d0, d1) = (a[0] + a[3], a[1] + a[2], a[0] - a[3], a[1] - a[2]);
        [s0 + s1, 2 * d0 + d1, s0 - s1, d0 - 2 * d1]
    };
    both(block, once)
}

/// The inverse transform, rounded.
pub(super) fn inverse(block: &Block) -> Block {
    let once = |a: [i32; 4]| {
        let (e, f) = (a[0] + a[2], a[0] - a[2]);
        let (g, h) = ((a[1] >> 1) - a[3], a[1] + (a[3] >> 1));
        [e + h, f + g, f - g, e - h]
    };
    both(block, once).map(|value| (value + 32) >> 6)
}

/// The Hadamard transform of the DC coefficients.
pub(super) fn hadamard(block: &Block) -> Block {
    let once = |a: [i32; 4]| {
        let (s0, s1, d0, d1) = (a[0] + a[1], a[2] + a[3], a[0] - a[1], a[2] - a[3]);
        [s0 + s1, s0 - s1, d0 - d1, d0 + d1]
    };
    both(block, once)
}

/// Applies a transform to the rows, then to the columns.
fn both(block: &Block, once: impl Fn([i32; 4]) -> [i32; 4]) -> Block {
    let mut half = [0; 16];
    for row in 0..4 {
        let found = once(std::array::from_fn(|i| block[4 * row + i]));
        half[4 * row..4 * row + 4].copy_from_slice(&found);
    }
    let mut whole = [0; 16];
    for column in 0..4 {
        let found = once(std::array::from_fn(|i| half[4 * i + column]));
        (0..4).for_each(|i| whole[4 * i + column] = found[i]);
    }
    whole
}

/// Quantises a transformed block; `share` is 3 for intra prediction, 6 for inter prediction.
pub(super) fn quantised(block: &Block, share: i32) -> Block {
    std::array::from_fn(|i| level(block[i], FORWARD[(QP % 6) as usize][kind(i)], (SHIFT, share)))
}

/// Coefficients reconstructed from levels.
pub(super) fn restored(levels: &Block) -> Block {
    std::array::from_fn(|i| (levels[i] * BACKWARD[(QP % 6) as usize][kind(i)]) << (QP / 6))
}

/// Quantises a transformed DC coefficient.
pub(super) fn constant_level(value: i32, share: i32) -> i32 {
    level(value, FORWARD[(QP % 6) as usize][0], (SHIFT + 1, share))
}

/// DC coefficient of a luma block, reconstructed from the inverse transform of the levels.
pub(super) fn constant_of_luma(value: i32) -> i32 {
    let scale = 16 * BACKWARD[(QP % 6) as usize][0];
    (value * scale + (1 << (5 - QP / 6))) >> (6 - QP / 6)
}

/// DC coefficient of a chroma block, reconstructed from the inverse transform of the levels.
pub(super) fn constant_of_chroma(value: i32) -> i32 {
    ((value * 16 * BACKWARD[(QP % 6) as usize][0]) << (QP / 6)) >> 5
}
