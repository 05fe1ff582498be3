//! Progress record of a sweep, in a file that remains after the process ends: `OUT.csv.sweep` next to `OUT.csv`.
//!
//! The first line identifies the sweep, as JSON; each further line is a row of results after its checksum, appended when a variant is
//! finished. If a killed process or a power failure leaves an incomplete line, it is removed with all lines after it, and those
//! variants run again.

use crate::cli::Failure;
use serde_json::Value;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// First word of the first line, with the version of the format.
const FORMAT: &str = "foldwing-sweep-1 ";
/// Interval at which rows are flushed to disk: a killed process loses no rows, a power failure at most those of this interval.
const SYNC_EVERY: Duration = Duration::from_secs(1);

/// The record; the file is locked against other processes while it is open.
pub(super) struct Journal {
    path: PathBuf,
    file: File,
    /// Checksum of the first line, with which the checksums of the rows are seeded.
    seed: u32,
    done: Vec<bool>,
    synced: Instant,
}

impl Journal {
    /// Opens the record next to `out` and reads its rows; creates it if it is missing.
    ///
    /// # Errors
    /// The record belongs to another sweep or is in use, or `out` exists without a record.
    pub fn open(out: &Path, identity: &Value, variants: usize) -> Result<Self, Failure> {
        let mut name = out.file_name().unwrap_or_default().to_owned();
        name.push(".sweep");
        let path = out.with_file_name(name);
        if out.exists() && !path.exists() {
            return Err(Failure::Usage(format!(
                "--output {}: exists without the record {} of a sweep; it is not overwritten: remove it or name another file",
                out.display(),
                path.display()
            )));
        }
        let failed = |error: io::Error| Failure::writing(&path.display().to_string(), &error);
        let options = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
        let mut file = options.map_err(failed)?;
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(Failure::Files(format!("{}: another process is running this sweep", path.display())));
        }
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(failed)?;
        let header = format!("{FORMAT}{identity}\n");
        let seed = crc32fast::hash(header.as_bytes());
        let mut journal = Self { path: path.clone(), file, seed, done: vec![false; variants], synced: Instant::now() };
        let kept = match bytes.iter().position(|byte| *byte == b'\n') {
            Some(end) => {
                journal.check_header(&bytes[..=end], &header, identity, out)?;
                let rows = rows(&bytes[end + 1..], seed);
                let length: usize = rows.iter().map(|row| row.length).sum();
                for row in rows {
                    if let Some(done) = journal.done.get_mut(row.index) {
                        *done = true;
                    }
                }
                end + 1 + length
            }
            None if header.as_bytes().starts_with(&bytes) => 0, // the process was killed while it wrote the first line
            None => return Err(no_record(&journal.path)),
        };
        journal.file.set_len(kept as u64).map_err(failed)?;
        journal.file.seek(SeekFrom::End(0)).map_err(failed)?;
        if kept == 0 {
            journal.file.write_all(header.as_bytes()).and_then(|()| journal.file.sync_data()).map_err(failed)?;
        }
        Ok(journal)
    }

    /// Returns an error that lists the differences if the record belongs to another sweep.
    fn check_header(&self, found: &[u8], header: &str, identity: &Value, out: &Path) -> Result<(), Failure> {
        if found == header.as_bytes() {
            return Ok(());
        }
        let other = found.strip_prefix(FORMAT.as_bytes()).and_then(|json| serde_json::from_slice::<Value>(json).ok());
        let place = self.path.display();
        let Some(other) = other else {
            return Err(no_record(&self.path));
        };
        let names = identity.as_object().into_iter().flatten();
        let changed: Vec<&str> = names
            .filter(|(name, value)| other.get(name.as_str()) != Some(value))
            .map(|(name, _)| name.as_str())
            .collect();
        Err(Failure::Usage(format!(
            "{place}: belongs to another sweep, which differs in: {}; to start again, remove it and {}, or name another --output",
            changed.join("; "),
            out.display()
        )))
    }

    /// Number of variants that have a row.
    pub fn done(&self) -> usize {
        self.done.iter().filter(|done| **done).count()
    }

    /// Variants without a row.
    pub fn missing(&self) -> Vec<usize> {
        (0..self.done.len()).filter(|&index| !self.done[index]).collect()
    }

    /// Appends the row of a variant.
    pub fn append(&mut self, index: usize, cells: &[String]) -> Result<(), Failure> {
        let failed = |error: io::Error| Failure::writing(&self.path.display().to_string(), &error);
        let row = csv_line(std::iter::once(index.to_string().as_str()).chain(cells.iter().map(String::as_str)));
        let mut line = format!("{:08x} ", checksum(self.seed, &row)).into_bytes();
        line.extend(row);
        self.file.write_all(&line).map_err(failed)?;
        self.done[index] = true;
        if self.synced.elapsed() > SYNC_EVERY {
            self.file.sync_data().map_err(failed)?;
            self.synced = Instant::now();
        }
        Ok(())
    }

    /// Results: header and rows in the order of the variants, and the number of failed variants.
    pub fn results(&mut self, columns: &[String]) -> Result<(Vec<u8>, usize), Failure> {
        let failed = |error: io::Error| Failure::Files(format!("{}: cannot be read: {error}", self.path.display()));
        self.file.sync_data().map_err(failed)?;
        self.file.seek(SeekFrom::Start(0)).map_err(failed)?;
        let mut bytes = Vec::new();
        self.file.read_to_end(&mut bytes).map_err(failed)?;
        let start = bytes.iter().position(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        let mut rows = rows(&bytes[start..], self.seed);
        rows.sort_by_key(|row| row.index);
        rows.dedup_by_key(|row| row.index);
        if rows.len() != self.done.len() {
            let (found, all) = (rows.len(), self.done.len());
            return Err(Failure::Files(format!(
                "{}: {found} of {all} rows can be read: another program has changed the file; the same command \
                 computes the missing rows",
                self.path.display()
            )));
        }
        let status = columns.iter().position(|column| column == "status").unwrap_or_default();
        let mut results = csv_line(columns.iter().map(String::as_str));
        let mut failures = 0;
        for row in &rows {
            results.extend(row.text);
            let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(row.text);
            let record = reader.records().next().and_then(Result::ok).unwrap_or_default();
            failures += usize::from(record.get(status) == Some("failed"));
        }
        Ok((results, failures))
    }
}

/// Error for a file that is not a progress record.
fn no_record(path: &Path) -> Failure {
    Failure::Usage(format!("{}: is not a record of a sweep; remove it or name another --output", path.display()))
}

/// Row in the file.
struct Row<'a> {
    index: usize,
    /// Row of the results, with its line feed.
    text: &'a [u8],
    /// Length in bytes in the file, with checksum and line feed.
    length: usize,
}

/// Complete rows from the beginning of the file up to the first damaged one.
fn rows(bytes: &[u8], seed: u32) -> Vec<Row<'_>> {
    bytes.split_inclusive(|byte| *byte == b'\n').map_while(|line| row(line, seed)).collect()
}

fn row(line: &[u8], seed: u32) -> Option<Row<'_>> {
    let (sum, text) = line.split_at_checked(9)?;
    let sum = u32::from_str_radix(std::str::from_utf8(sum).ok()?.strip_suffix(' ')?, 16).ok()?;
    let number = text.split(|byte| *byte == b',').next()?;
    let index = std::str::from_utf8(number).ok()?.parse().ok()?;
    (text.ends_with(b"\n") && checksum(seed, text) == sum).then_some(Row { index, text, length: line.len() })
}

/// Checksum of a row of the sweep whose first line has the checksum `seed`.
fn checksum(seed: u32, row: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new_with_initial(seed);
    hasher.update(row);
    hasher.finalize()
}

/// Joins cells to a line of CSV.
fn csv_line<'a>(cells: impl Iterator<Item = &'a str>) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(cells).expect("writing to memory does not fail");
    writer.into_inner().expect("writing to memory does not fail")
}
