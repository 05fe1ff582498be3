//! Text of the rows of CSV files.

use foldwing_engine::plant::Plant;
use foldwing_fmi::interface::{Interface, Value};

/// Length in bytes of the widest cell, `-2.2250738585072014e-308`.
const CELL_BYTES: usize = 24;

/// Value as a CSV cell: reals with the shortest text from which the same bits are read back, Booleans as 0 and 1.
pub fn cell(value: &Value) -> String {
    let mut text = [0; CELL_BYTES];
    let end = write_cell(value, &mut text);
    String::from_utf8_lossy(&text[..end]).into_owned()
}

/// Writes a value to the beginning of `text` in the format of [`cell`] and returns its length. The buffer needs [`CELL_BYTES`] bytes.
fn write_cell(value: &Value, text: &mut [u8]) -> usize {
    let mut put = |written: &str| {
        text[..written.len()].copy_from_slice(written.as_bytes());
        written.len()
    };
    match value {
        // 44 % of the cells of the shipped wing, which is planar; faster than the general case
        Value::Real(value) if value.to_bits() == 0 => put("0.0"),
        // exponents instead of many zeros, as in 1e-9 and 1e30
        Value::Real(value) => put(zmij::Buffer::new().format(*value)),
        Value::Integer(value) => put(&value.to_string()),
        Value::Boolean(value) => put(if *value { "1" } else { "0" }),
    }
}

/// Text of one row, with space for the widest cells, since a growing text would check its capacity at each cell.
#[derive(Debug)]
pub struct CsvRow {
    text: Vec<u8>,
    end: usize,
}

impl CsvRow {
    /// A row with space for `cells` cells, the time included.
    pub fn new(cells: usize) -> Self {
        Self { text: vec![0; cells * (CELL_BYTES + 1)], end: 0 }
    }

    /// Replaces the row by one with only the time in s.
    pub fn start(&mut self, time_s: f64) {
        self.end = write_cell(&Value::Real(time_s), &mut self.text);
    }

    /// Appends a cell. Panics beyond the cells of the row.
    pub fn push(&mut self, value: &Value) {
        self.text[self.end] = b',';
        self.end += 1;
        self.end += write_cell(value, &mut self.text[self.end..]);
    }

    /// Appends the variables with these value references; panics if `interface` has no such variable. The plant must have computed its
    /// outputs.
    pub fn push_variables(&mut self, interface: &Interface, plant: &Plant, value_references: &[u32]) {
        let outputs = plant.outputs();
        for &reference in value_references {
            self.push(&interface.get(plant, outputs, reference).expect("a reference of the interface"));
        }
    }

    /// The row with the end of its line.
    pub fn line(&mut self) -> &[u8] {
        self.text[self.end] = b'\n';
        &self.text[..=self.end]
    }
}
