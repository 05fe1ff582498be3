//! Chosen variables over time, written row by row as CSV.

use crate::report::{cell, write_cell};
use foldwing_fmi::interface::Value;
use std::io::{self, Write};

/// Writes a header of variable names, then one row per time.
pub struct Recorder<W: Write> {
    writer: csv::Writer<W>,
    /// Text of one cell, kept for its memory.
    text: String,
}

impl<W: Write> Recorder<W> {
    /// Writes the header: `time` and the names of the variables, in their order.
    pub fn new<'a>(target: W, names: impl IntoIterator<Item = &'a str>) -> io::Result<Self> {
        Self::start(csv::Writer::from_writer(target), names)
    }

    /// The same with names in quotes, as the rules of the FMI Cross-Check ask.
    pub fn quoted<'a>(target: W, names: impl IntoIterator<Item = &'a str>) -> io::Result<Self> {
        Self::start(csv::WriterBuilder::new().quote_style(csv::QuoteStyle::NonNumeric).from_writer(target), names)
    }

    fn start<'a>(mut writer: csv::Writer<W>, names: impl IntoIterator<Item = &'a str>) -> io::Result<Self> {
        writer.write_record(std::iter::once("time").chain(names))?;
        Ok(Self { writer, text: String::new() })
    }

    /// Writes one row.
    pub fn record(&mut self, time_s: f64, values: impl IntoIterator<Item = Value>) -> io::Result<()> {
        for value in std::iter::once(Value::Real(time_s)).chain(values) {
            self.text.clear();
            write_cell(&value, &mut self.text);
            self.writer.write_field(&self.text)?;
        }
        Ok(self.writer.write_record(None::<&[u8]>)?)
    }

    /// Writes one row of texts.
    pub fn record_cells(&mut self, time_s: f64, cells: impl IntoIterator<Item = String>) -> io::Result<()> {
        Ok(self.writer.write_record(std::iter::once(cell(&Value::Real(time_s))).chain(cells))?)
    }

    /// Flushes, and hands the target back.
    pub fn finish(self) -> io::Result<W> {
        self.writer.into_inner().map_err(|error| error.into_error())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers read back to the same bits, Booleans are 0 and 1.
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
    }
}
