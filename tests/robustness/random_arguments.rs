//! Arguments for random calls: mostly valid, often invalid, never undefined behaviour of the caller.

use fastrand::Rng;
use foldwing::interface::{Causality, Interface, Kind, Value, Variability, Variable};

/// Extreme numbers.
const SENSELESS: [f64; 14] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    -0.0,
    0.0,
    -1.0,
    1e30,
    -1e200,
    1e100,
    1e18,
];

/// One of a list.
pub fn pick<T: Copy>(rng: &mut Rng, list: &[T]) -> T {
    list[rng.usize(..list.len())]
}

/// A Real for a row: near its start value, or invalid.
pub fn real(rng: &mut Rng, row: Option<&Variable>) -> f64 {
    let start = match row.map(|row| row.value) {
        Some(Value::Real(start)) => start,
        _ => 0.0,
    };
    // accuracy and steps determine the cost: only reasonable values keep a call short, all others must be rejected
    let costs = row.is_some_and(|row| row.name.starts_with("solver."));
    match rng.u8(..10) {
        0 => pick(rng, if costs { &SENSELESS[..3] } else { &SENSELESS }),
        1..=3 => start,
        4..=6 if start != 0.0 => start * (0.5 + rng.f64()),
        _ if costs => start,
        _ => 0.1 * (rng.f64() - 0.5),
    }
}

/// A communication step in s, valid or invalid.
pub fn step_s(rng: &mut Rng) -> f64 {
    match rng.u8(..12) {
        0 => pick(rng, &SENSELESS),
        1 => 1e-12,
        2 => 0.02,
        _ => 1e-3 * rng.f64(),
    }
}

/// Value references: few of them, mostly of one kind, with repetitions, other kinds and unknown ones.
pub fn references(rng: &mut Rng, table: &Interface, fitting: impl Fn(&Variable) -> bool) -> Vec<u32> {
    let rows = table.variables();
    let fitting: Vec<u32> = rows.iter().filter(|row| fitting(row)).map(|row| row.value_reference).collect();
    let mut references: Vec<u32> = (0..rng.usize(..7))
        .map(|_| match rng.u8(..40) {
            0 => rng.u32(..),
            1 => pick(rng, &[rows.len() as u32, u32::MAX, u32::MAX - 1, 1 << 31]),
            2 => rng.u32(..rows.len() as u32),
            _ if fitting.is_empty() => rng.u32(..rows.len() as u32),
            _ => pick(rng, &fitting),
        })
        .collect();
    if let (Some(&first), true) = (references.first(), rng.u8(..8) == 0) {
        references.resize(references.len() + rng.usize(..40), first);
    }
    references
}

/// Returns whether the importer sets a row.
pub fn is_settable(row: &Variable) -> bool {
    matches!(row.causality, Causality::Input | Causality::Parameter)
}

/// Result of setting a value according to the standard and the documentation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    Taken,
    /// `fmi2Discard`.
    BadValue,
    /// `fmi2Error`.
    BadCall,
}

/// Result of a batch: determined by the first rejected value.
pub fn batch(verdicts: impl IntoIterator<Item = Verdict>) -> Verdict {
    verdicts.into_iter().find(|verdict| *verdict != Verdict::Taken).unwrap_or(Verdict::Taken)
}

/// Expected result of reading a row as `kind`.
pub fn reading(table: &Interface, reference: u32, kind: Kind) -> Verdict {
    match table.variables().get(reference as usize) {
        Some(row) if row.value.kind() == kind => Verdict::Taken,
        _ => Verdict::BadCall,
    }
}

/// Expected result of setting a row; `started` after the initialisation, `exchanging` while an importer integrates.
pub fn setting(table: &Interface, reference: u32, value: Value, started: bool, exchanging: bool) -> Verdict {
    let Some(row) = table.variables().get(reference as usize) else { return Verdict::BadCall };
    // start values of continuous states are guesses: accepted before the start, and not used
    let guess = table.is_state(reference) && (!started || exchanging);
    if row.value.kind() != value.kind() || !(is_settable(row) || guess) {
        return Verdict::BadCall;
    }
    if let Value::Real(value) = value {
        let (min, max) = row.range.unwrap_or((f64::MIN, f64::MAX));
        if !value.is_finite() || value < min || value > max {
            return Verdict::BadValue;
        }
    }
    let fixed = row.causality == Causality::Parameter && row.variability == Variability::Fixed;
    if fixed && started { Verdict::BadCall } else { Verdict::Taken }
}

/// Expected result of setting the time derivative of an input.
pub fn setting_rate(table: &Interface, reference: u32, order: i32, value: f64) -> Verdict {
    match table.variables().get(reference as usize) {
        Some(row) if row.causality == Causality::Input && row.value.kind() == Kind::Real && order == 1 => {
            if value.is_finite() { Verdict::Taken } else { Verdict::BadValue }
        }
        _ => Verdict::BadCall,
    }
}

/// Expected result of reading the time derivative of an output.
pub fn reading_rate(table: &Interface, reference: u32, order: i32) -> Verdict {
    match table.variables().get(reference as usize) {
        Some(row) if row.causality == Causality::Output && row.value.kind() == Kind::Real && order >= 1 => {
            Verdict::Taken
        }
        _ => Verdict::BadCall,
    }
}

/// Corrupts the bytes of a state; returns `true` if the checksum is corrected, so that only the content is wrong.
pub fn damage(rng: &mut Rng, bytes: &mut Vec<u8>) -> bool {
    /// Bytes before the checksum, and including it.
    const HEADER: (usize, usize) = (56, 60);
    match rng.u8(..6) {
        0 => bytes.truncate(rng.usize(..bytes.len())),
        1 => bytes.extend((0..rng.usize(1..9)).map(|_| 0)),
        2 => {
            let at = rng.usize(..bytes.len());
            bytes[at] ^= 1 << rng.u8(..8);
        }
        _ => {
            for _ in 0..rng.usize(1..5) {
                let at = rng.usize(HEADER.1..bytes.len());
                if let (true, Some(place)) = (rng.bool(), bytes.get_mut(at..at + 8)) {
                    place.copy_from_slice(&pick(rng, &SENSELESS).to_le_bytes());
                } else {
                    bytes[at] = rng.u8(..);
                }
            }
            let mut sum = crc32fast::Hasher::new();
            sum.update(&bytes[..HEADER.0]);
            sum.update(&bytes[HEADER.1..]);
            bytes[HEADER.0..HEADER.1].copy_from_slice(&sum.finalize().to_le_bytes());
            return true;
        }
    }
    false
}
