//! Variable-length coding of transform coefficients (ITU-T H.264, clause 9.2), with the tables of that clause.

use super::bits::Bits;

/// Code lengths of `coeff_token`, indexed by `4 · count + trailing ones`, for few to many coefficients in the neighbouring
/// blocks (table 9-5).
#[rustfmt::skip]
const TOKEN_LENGTHS: [[u8; 68]; 3] = [
    [
        1, 0, 0, 0, 6, 2, 0, 0, 8, 6, 3, 0, 9, 8, 7, 5, 10, 9, 8, 6, 11, 10, 9, 7, 13, 11, 10, 8, 13, 13, 11, 9, 13, 13, 13, 10,
        14, 14, 13, 11, 14, 14, 14, 13, 15, 15, 14, 14, 15, 15, 15, 14, 16, 15, 15, 15, 16, 16, 16, 15, 16, 16, 16, 16, 16, 16, 16, 16,
    ],
    [
        2, 0, 0, 0, 6, 2, 0, 0, 6, 5, 3, 0, 7, 6, 6, 4, 8, 6, 6, 4, 8, 7, 7, 5, 9, 8, 8, 6, 11, 9, 9, 6, 11, 11, 11, 7,
        12, 11, 11, 9, 12, 12, 12, 11, 12, 12, 12, 11, 13, 13, 13, 12, 13, 13, 13, 13, 13, 14, 13, 13, 14, 14, 14, 13, 14, 14, 14, 14,
    ],
    [
        4, 0, 0, 0, 6, 4, 0, 0, 6, 5, 4, 0, 6, 5, 5, 4, 7, 5, 5, 4, 7, 5, 5, 4, 7, 6, 6, 4, 7, 6, 6, 4, 8, 7, 7, 5,
        8, 8, 7, 6, 9, 8, 8, 7, 9, 9, 8, 8, 9, 9, 9, 8, 10, 9, 9, 9, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10,
    ],
];
/// Bits of these codes.
#[rustfmt::skip]
const TOKENS: [[u8; 68]; 3] = [
    [
        1, 0, 0, 0, 5, 1, 0, 0, 7, 4, 1, 0, 7, 6, 5, 3, 7, 6, 5, 3, 7, 6, 5, 4, 15, 6, 5, 4, 11, 14, 5, 4, 8, 10, 13, 4,
        15, 14, 9, 4, 11, 10, 13, 12, 15, 14, 9, 12, 11, 10, 13, 8, 15, 1, 9, 12, 11, 14, 13, 8, 7, 10, 9, 12, 4, 6, 5, 8,
    ],
    [
        3, 0, 0, 0, 11, 2, 0, 0, 7, 7, 3, 0, 7, 10, 9, 5, 7, 6, 5, 4, 4, 6, 5, 6, 7, 6, 5, 8, 15, 6, 5, 4, 11, 14, 13, 4,
        15, 10, 9, 4, 11, 14, 13, 12, 8, 10, 9, 8, 15, 14, 13, 12, 11, 10, 9, 12, 7, 11, 6, 8, 9, 8, 10, 1, 7, 6, 5, 4,
    ],
    [
        15, 0, 0, 0, 15, 14, 0, 0, 11, 15, 13, 0, 8, 12, 14, 12, 15, 10, 11, 11, 11, 8, 9, 10, 9, 14, 13, 9, 8, 10, 9, 8, 15, 14, 13, 13,
        11, 14, 10, 12, 15, 10, 13, 12, 11, 14, 9, 12, 8, 10, 13, 8, 13, 7, 9, 12, 9, 12, 11, 10, 5, 8, 7, 6, 1, 4, 3, 2,
    ],
];
/// Code lengths of `coeff_token` for the DC coefficients of chroma, and their bits.
const CHROMA_TOKEN_LENGTHS: [u8; 20] = [2, 0, 0, 0, 6, 1, 0, 0, 6, 6, 3, 0, 6, 7, 7, 6, 6, 8, 8, 7];
const CHROMA_TOKENS: [u8; 20] = [1, 0, 0, 0, 7, 1, 0, 0, 4, 6, 1, 0, 3, 3, 2, 5, 2, 3, 2, 0];

/// Code lengths of `total_zeros`, indexed by count − 1 and number of zeros (tables 9-7 and 9-8).
#[rustfmt::skip]
const ZEROS_LENGTHS: [&[u8]; 15] = [
    &[1, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8, 8, 9, 9, 9], &[3, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 6, 6, 6, 6],
    &[4, 3, 3, 3, 4, 4, 3, 3, 4, 5, 5, 6, 5, 6], &[5, 3, 4, 4, 3, 3, 3, 4, 3, 4, 5, 5, 5], &[4, 4, 4, 3, 3, 3, 3, 3, 4, 5, 4, 5],
    &[6, 5, 3, 3, 3, 3, 3, 3, 4, 3, 6], &[6, 5, 3, 3, 3, 2, 3, 4, 3, 6], &[6, 4, 5, 3, 2, 2, 3, 3, 6], &[6, 6, 4, 2, 2, 3, 2, 5],
    &[5, 5, 3, 2, 2, 2, 4], &[4, 4, 3, 3, 1, 3], &[4, 4, 2, 1, 3], &[3, 3, 1, 2], &[2, 2, 1], &[1, 1],
];
/// Bits of these codes.
#[rustfmt::skip]
const ZEROS: [&[u8]; 15] = [
    &[1, 3, 2, 3, 2, 3, 2, 3, 2, 3, 2, 3, 2, 3, 2, 1], &[7, 6, 5, 4, 3, 5, 4, 3, 2, 3, 2, 3, 2, 1, 0],
    &[5, 7, 6, 5, 4, 3, 4, 3, 2, 3, 2, 1, 1, 0], &[3, 7, 5, 4, 6, 5, 4, 3, 3, 2, 2, 1, 0], &[5, 4, 3, 7, 6, 5, 4, 3, 2, 1, 1, 0],
    &[1, 1, 7, 6, 5, 4, 3, 2, 1, 1, 0], &[1, 1, 5, 4, 3, 3, 2, 1, 1, 0], &[1, 1, 1, 3, 3, 2, 2, 1, 0], &[1, 0, 1, 3, 2, 1, 1, 1],
    &[1, 0, 1, 3, 2, 1, 1], &[0, 1, 1, 2, 1, 3], &[0, 1, 1, 1, 1], &[0, 1, 1, 1], &[0, 1, 1], &[0, 1],
];
/// Code lengths of `total_zeros` for the DC coefficients of chroma (table 9-9), and their bits.
const CHROMA_ZEROS_LENGTHS: [&[u8]; 3] = [&[1, 2, 3, 3], &[1, 2, 2], &[1, 1]];
const CHROMA_ZEROS: [&[u8]; 3] = [&[1, 1, 1, 0], &[1, 1, 0], &[1, 0]];

/// Code lengths of `run_before`, indexed by remaining zeros − 1, at most 6, and run (table 9-10).
#[rustfmt::skip]
const RUN_LENGTHS: [&[u8]; 7] = [
    &[1, 1], &[1, 2, 2], &[2, 2, 2, 2], &[2, 2, 2, 3, 3], &[2, 2, 3, 3, 3, 3], &[2, 3, 3, 3, 3, 3, 3],
    &[3, 3, 3, 3, 3, 3, 3, 4, 5, 6, 7, 8, 9, 10, 11],
];
/// Bits of these codes.
#[rustfmt::skip]
const RUNS: [&[u8]; 7] = [
    &[1, 0], &[1, 1, 0], &[3, 2, 1, 0], &[3, 2, 1, 1, 0], &[3, 2, 3, 2, 1, 0], &[3, 0, 1, 3, 2, 5, 4],
    &[7, 6, 5, 4, 3, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1],
];

/// Selects the table of `coeff_token` for a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Neighbours {
    /// Mean number of coefficients in the blocks on the left and above.
    Count(u32),
    /// DC coefficients of chroma.
    Chroma,
}

/// Appends coefficients in scan order and returns the number of non-zero ones.
pub(super) fn write(bits: &mut Bits, coefficients: &[i32], neighbours: Neighbours) -> u8 {
    let last = coefficients.iter().rposition(|level| *level != 0);
    let used = last.map_or(&[][..], |last| &coefficients[..=last]);
    // from the highest frequency to the lowest, each with the number of zeros before it
    let mut levels: Vec<(i32, usize)> = Vec::with_capacity(16);
    let mut zeros = 0;
    for level in used {
        if *level == 0 {
            zeros += 1;
        } else {
            levels.push((*level, zeros));
            zeros = 0;
        }
    }
    levels.reverse();
    let count = levels.len();
    let ones = levels.iter().take(3).take_while(|(level, _)| level.abs() == 1).count();
    let token = 4 * count + ones;
    match neighbours {
        Neighbours::Chroma => bits.put(CHROMA_TOKENS[token].into(), CHROMA_TOKEN_LENGTHS[token].into()),
        Neighbours::Count(around) if around >= 8 => {
            let code = if count == 0 { 3 } else { 4 * (count as u32 - 1) + ones as u32 };
            bits.put(code, 6);
        }
        Neighbours::Count(around) => {
            let table = usize::from(around >= 2) + usize::from(around >= 4);
            bits.put(TOKENS[table][token].into(), TOKEN_LENGTHS[table][token].into());
        }
    }
    if count == 0 {
        return 0;
    }
    levels[..ones].iter().for_each(|(level, _)| bits.put((*level < 0).into(), 1));
    write_levels(bits, &levels[ones..], count, ones);
    let mut left: usize = levels.iter().map(|(_, zeros)| zeros).sum();
    if count < coefficients.len() {
        let (codes, lengths) = match neighbours {
            Neighbours::Chroma => (CHROMA_ZEROS[count - 1], CHROMA_ZEROS_LENGTHS[count - 1]),
            Neighbours::Count(_) => (ZEROS[count - 1], ZEROS_LENGTHS[count - 1]),
        };
        bits.put(codes[left].into(), lengths[left].into());
    }
    for (_, run) in &levels[..count - 1] {
        if left == 0 {
            break;
        }
        let table = left.min(7) - 1;
        bits.put(RUNS[table][*run].into(), RUN_LENGTHS[table][*run].into());
        left -= run;
    }
    count as u8
}

/// Appends the levels that are not trailing ones.
fn write_levels(bits: &mut Bits, levels: &[(i32, usize)], count: usize, ones: usize) {
    let mut suffix = u32::from(count > 10 && ones < 3);
    for (i, (level, _)) in levels.iter().enumerate() {
        let mut code = if *level > 0 { 2 * level - 2 } else { -2 * level - 1 }.unsigned_abs();
        if i == 0 && ones < 3 {
            code -= 2;
        }
        let (prefix, rest, length) = match (suffix, code) {
            (0, 0..14) => (code, 0, 0),
            (0, 14..30) => (14, code - 14, 4),
            (0, _) => (15, code - 30, 12),
            _ if code < 15 << suffix => (code >> suffix, code & ((1 << suffix) - 1), suffix),
            _ => (15, code - (15 << suffix), 12),
        };
        bits.put(1, prefix + 1);
        bits.put(rest, length);
        suffix = suffix.max(1);
        if level.unsigned_abs() > 3 << (suffix - 1) && suffix < 6 {
            suffix += 1;
        }
    }
}
