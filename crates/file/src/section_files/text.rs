//! Reading of numbers and matrices from lines of text.

use crate::station_table::{StationFault, fault};
use crate::stations::MAXIMUM_STATIONS;
use nalgebra::SMatrix;

/// Lines of a file, read in order.
pub(crate) struct Lines<'t> {
    lines: std::iter::Enumerate<std::str::Lines<'t>>,
    last: usize,
}

impl<'t> Lines<'t> {
    pub fn of(text: &'t str) -> Self {
        Self { lines: text.lines().enumerate(), last: text.lines().count() }
    }

    /// Returns the next line that is not empty.
    pub fn next(&mut self, due: &str) -> Result<(usize, &'t str), StationFault> {
        let next = self.lines.find(|(_, line)| !line.trim().is_empty());
        let (index, line) =
            next.ok_or_else(|| fault(self.last + 1, format!("truncated: the file ends before {due}")))?;
        Ok((index + 1, line))
    }

    /// Returns the lines after the first line that starts with a title, ignoring case.
    pub fn after(text: &'t str, title: &str) -> Result<Self, StationFault> {
        let mut lines = Self::of(text);
        loop {
            let (_, line) = lines.next(&format!("{title:?}"))?;
            if line.trim_start().get(..title.len()).is_some_and(|front| front.eq_ignore_ascii_case(title)) {
                return Ok(lines);
            }
        }
    }

    /// Returns the value that precedes a label.
    pub fn labelled(&mut self, label: &str) -> Result<(usize, usize), StationFault> {
        loop {
            let (line, text) = self.next(label)?;
            let mut words = text.split_whitespace();
            let (value, name) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
            if name.eq_ignore_ascii_case(label) {
                let count: Option<usize> = value.parse().ok();
                let count = count.filter(|count| (1..=MAXIMUM_STATIONS).contains(count));
                let reason = format!("{label} is {value:?}; a whole number from 1 to {MAXIMUM_STATIONS} is needed");
                return count.map(|count| (line, count)).ok_or_else(|| fault(line, reason));
            }
        }
    }

    /// Returns the first `N` numbers of the next line.
    pub fn numbers<const N: usize>(&mut self, due: &str) -> Result<(usize, [f64; N]), StationFault> {
        let (line, text) = self.next(due)?;
        numbers(line, text, due).map(|values| (line, values))
    }

    /// Returns a matrix of `N` rows, and the line number of its first row. Lines of `=` before it are skipped.
    pub fn matrix<const N: usize>(&mut self, due: &str) -> Result<(usize, SMatrix<f64, N, N>), StationFault> {
        let (mut line, mut text) = self.next(due)?;
        while text.trim().bytes().all(|byte| byte == b'=') || text.trim_end().ends_with('=') {
            (line, text) = self.next(due)?;
        }
        let first = line;
        let mut matrix = SMatrix::<f64, N, N>::zeros();
        for row in 0..N {
            if row > 0 {
                (line, text) = self.next(due)?;
            }
            let values = numbers::<N>(line, text, due)?;
            (0..N).for_each(|column| matrix[(row, column)] = values[column]);
        }
        Ok((first, matrix))
    }
}

fn numbers<const N: usize>(line: usize, text: &str, due: &str) -> Result<[f64; N], StationFault> {
    let mut words = text.split_whitespace();
    let mut values = [0.0; N];
    for (place, value) in values.iter_mut().enumerate() {
        let word = words.next().ok_or_else(|| fault(line, format!("{place} numbers where {due} has {N}")))?;
        *value = number(line, due, word)?;
    }
    Ok(values)
}

/// Parses a finite number; Fortran's `d` is accepted as exponent.
pub(crate) fn number(line: usize, due: &str, word: &str) -> Result<f64, StationFault> {
    let value: Option<f64> = word.replace(['d', 'D'], "e").parse().ok();
    let finite = value.filter(|value| value.is_finite());
    finite.ok_or_else(|| fault(line, format!("{word:?} in {due}; a finite number is needed")))
}
