//! Selected variables over time, written row by row as CSV.

use crate::report::cell;
use foldwing_engine::plant::Plant;
use foldwing_fmi::interface::{Interface, Value};
use foldwing_recording::CsvRow;
use std::io::{self, BufWriter, Write};

/// Writes a header of variable names, then one row per time.
pub struct Recorder<W: Write> {
    target: BufWriter<W>,
    row: CsvRow,
}

impl<W: Write> Recorder<W> {
    /// Writes the header: `time` and the names of the variables, in order.
    pub fn new<'a>(target: W, names: impl IntoIterator<Item = &'a str>) -> io::Result<Self> {
        Self::start(target, csv::QuoteStyle::Necessary, names)
    }

    /// Like [`Recorder::new`], with names in quotes, as required by the FMI Cross-Check.
    pub fn quoted<'a>(target: W, names: impl IntoIterator<Item = &'a str>) -> io::Result<Self> {
        Self::start(target, csv::QuoteStyle::NonNumeric, names)
    }

    fn start<'a>(target: W, quotes: csv::QuoteStyle, names: impl IntoIterator<Item = &'a str>) -> io::Result<Self> {
        let mut target = BufWriter::new(target);
        let mut header = csv::WriterBuilder::new().quote_style(quotes).from_writer(&mut target);
        let mut cells = 0;
        header.write_record(std::iter::once("time").chain(names).inspect(|_| cells += 1))?;
        header.flush()?;
        drop(header);
        Ok(Self { target, row: CsvRow::new(cells) })
    }

    /// Writes one row, with a value for each name of the header. Numbers need no quotes: a writer that checks for them took longer than
    /// the run.
    pub fn record(&mut self, time_s: f64, values: impl IntoIterator<Item = Value>) -> io::Result<()> {
        self.row.start(time_s);
        for value in values {
            self.row.push(&value);
        }
        self.target.write_all(self.row.line())
    }

    /// Writes one row with the values of variables of a plant, by their value references: those of the header.
    pub fn record_variables(
        &mut self,
        time_s: f64,
        interface: &Interface,
        plant: &Plant,
        value_references: &[u32],
    ) -> io::Result<()> {
        self.row.start(time_s);
        self.row.push_variables(interface, plant, value_references);
        self.target.write_all(self.row.line())
    }

    /// Writes one row of texts.
    pub fn record_cells(&mut self, time_s: f64, cells: impl IntoIterator<Item = String>) -> io::Result<()> {
        let mut row = csv::Writer::from_writer(&mut self.target);
        row.write_record(std::iter::once(cell(&Value::Real(time_s))).chain(cells))?;
        row.flush()
    }

    /// Flushes, and returns the target.
    pub fn finish(self) -> io::Result<W> {
        self.target.into_inner().map_err(io::IntoInnerError::into_error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same bits are read back from numbers; Booleans are 0 and 1.
    #[test]
    fn rows_read_back_to_the_same_bits() {
        let mut recorder = Recorder::new(Vec::new(), ["a", "b", "c"]).unwrap();
        let value = 0.1 + 0.2;
        recorder.record(1e-3, [Value::Real(value), Value::Boolean(true), Value::Integer(-1)]).unwrap();
        let text = String::from_utf8(recorder.finish().unwrap()).unwrap();
        assert_eq!(text.lines().next(), Some("time,a,b,c"));
        let cells: Vec<_> = text.lines().nth(1).unwrap().split(',').collect();
        assert_eq!(cells[1].parse::<f64>().unwrap().to_bits(), value.to_bits());
        assert_eq!(&cells[2..], ["1", "-1"]);
        let extremes = [5e-324, -1.7e308, 1e-5, 12345.678e-9, 1e16, 1.5e17, 123_456_789.0, 0.0, f64::INFINITY];
        let mut recorder = Recorder::new(Vec::new(), vec!["x"; extremes.len()]).unwrap();
        recorder.record(-0.0, extremes.map(Value::Real)).unwrap();
        recorder.record_cells(0.0, ["a,b", "plain"].map(str::to_owned)).unwrap();
        let text = String::from_utf8(recorder.finish().unwrap()).unwrap();
        let rows: Vec<&str> = text.lines().collect();
        let read: Vec<u64> = rows[1].split(',').map(|cell| cell.parse::<f64>().unwrap().to_bits()).collect();
        assert_eq!(read[0], (-0.0f64).to_bits());
        assert_eq!(read[1..], extremes.map(f64::to_bits));
        assert_eq!(rows[1].split(',').map(str::len).max(), Some("-1.7e308".len().max("0.000012345678".len())));
        assert_eq!(rows[2], "0.0,\"a,b\",plain");
    }
}
