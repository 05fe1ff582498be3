//! Line numbers of records in CSV files. The position of a record in the crate `csv` precedes any empty lines, comments and the second
//! half of a line ending before the record.

use std::io::{self, Read};

/// Bytes of a CSV file.
pub struct Lines {
    bytes: Vec<u8>,
}

impl Lines {
    /// Reads a file to its end.
    ///
    /// # Errors
    /// Read errors of the source.
    pub fn of(mut source: impl Read) -> io::Result<Self> {
        let mut bytes = Vec::new();
        source.read_to_end(&mut bytes)?;
        Ok(Self { bytes })
    }

    /// Returns a reader of the records after a header; lines that start with `#` are comments.
    pub fn reader(&self) -> csv::Reader<&[u8]> {
        csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(&self.bytes)
    }

    /// Line number, starting at 1, of the record at a position; 0 without a position.
    pub fn number(&self, position: Option<&csv::Position>) -> u64 {
        let Some(mut start) = position.and_then(|position| usize::try_from(position.byte()).ok()) else { return 0 };
        while let Some(line) =
            self.bytes.get(start..).and_then(|rest| rest.split_inclusive(|byte| *byte == b'\n').next())
        {
            if !(line.starts_with(b"#") || matches!(line, b"\n" | b"\r\n")) {
                break;
            }
            start += line.len();
        }
        1 + self.bytes.iter().take(start).filter(|byte| **byte == b'\n').count() as u64
    }

    /// Error of the reader, preceded by its line and without terms of the crate.
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "a foreign enum that may grow: its own words serve for the rest"
    )]
    pub fn describe(&self, error: &csv::Error) -> String {
        let line = self.number(error.position());
        match error.kind() {
            csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                format!("line {line}: {len} columns where the header has {expected_len}")
            }
            csv::ErrorKind::Utf8 { err, .. } => format!("line {line}: not UTF-8 text: {err}"),
            _ => error.to_string(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every record has its line number, also after other lines, with either line ending, with or without one at the end of the file,
    /// and if it has the wrong length.
    #[test]
    fn records_have_the_lines_of_the_file() {
        let lines = ["# a run", "", "time,x", "0,1", "# a comment", "", "# another", "1,2", "2,3", "", "3,4"];
        for (ending, last) in [("\n", ""), ("\n", "\n"), ("\r\n", ""), ("\r\n", "\r\n"), ("\r\n", "\r\n\r\n")] {
            let source = |lines: &[&str]| Lines::of((lines.join(ending) + last).as_bytes()).expect("bytes");
            let read = source(&lines);
            let numbers: Vec<u64> =
                read.reader().records().map(|record| read.number(record.expect("a row").position())).collect();
            assert_eq!(numbers, [4, 8, 9, 11], "{ending:?}");
            for at in [3, 7, 8, 10] {
                let mut lines = lines;
                lines[at] = "7";
                let read = source(&lines);
                let error = read.reader().records().find_map(Result::err).expect("too short");
                assert_eq!(read.describe(&error), format!("line {}: 1 columns where the header has 2", at + 1));
            }
        }
    }
}
