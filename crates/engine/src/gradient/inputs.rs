//! Inputs over time along a run on a tape, eq. (X11).

use crate::gradient::GradientError;
use crate::run::Plant;
use crate::signal::Inputs;
use crate::system::state::State;

/// One input over time.
#[derive(Debug, Clone, PartialEq)]
pub struct InputColumn {
    /// Its place in [`Inputs::values`].
    pub index: usize,
    /// A switch, which holds from row to row; other inputs are interpolated linearly.
    pub held: bool,
    /// A value for each row, in SI units.
    pub values: Vec<f64>,
}

/// Rows of input values at ascending times. Before the first row and after the last one inputs are constant. Two rows at one time are a
/// jump: the interpolation before it ends at the first, the second is valid from there on.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct InputRows {
    times_s: Vec<f64>,
    columns: Vec<InputColumn>,
}

/// A stretch between two rows, in which all inputs are linear in time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Piece {
    /// Its start in s; it may lie within the stretch.
    pub from_s: f64,
    /// The rows at its ends; the same one where inputs are constant.
    rows: [usize; 2],
}

/// A change of one column in all rows, or in one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Offset {
    pub column: usize,
    /// The row; `None` for all.
    pub row: Option<usize>,
    /// In the unit of the input.
    pub by: f64,
}

impl InputRows {
    /// Rows of values.
    ///
    /// # Errors
    /// [`GradientError::Inputs`] for times or values that are not finite, times that descend or occur three times, no row, and columns
    /// whose length is not the number of rows.
    pub fn new(times_s: Vec<f64>, columns: Vec<InputColumn>) -> Result<Self, GradientError> {
        let refuse = |cause: String| Err(GradientError::Inputs { cause });
        if times_s.is_empty() {
            return refuse("they have no rows; at least one is needed".into());
        }
        if let Some(time_s) = times_s.iter().find(|time_s| !time_s.is_finite()) {
            return refuse(format!("the time {time_s} s is not finite"));
        }
        if let Some(pair) = times_s.windows(2).find(|pair| pair[1] < pair[0]) {
            return refuse(format!("the times must ascend; {} s is followed by {} s", pair[0], pair[1]));
        }
        if let Some(three) = times_s.windows(3).find(|three| three[0] == three[2]) {
            return refuse(format!("three rows are at {} s; a jump has two", three[0]));
        }
        for InputColumn { index, values, .. } in &columns {
            if values.len() != times_s.len() || values.iter().any(|value| !value.is_finite()) {
                return refuse(format!("input {index} needs a finite value for each of the {} rows", times_s.len()));
            }
        }
        Ok(Self { times_s, columns })
    }

    /// Times of the rows in s.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// The inputs.
    pub fn columns(&self) -> &[InputColumn] {
        &self.columns
    }

    /// Whether a column is that of a real input, and has these rows.
    pub(crate) fn has<'a>(&self, column: usize, mut rows: impl Iterator<Item = &'a usize>) -> bool {
        self.columns.get(column).is_some_and(|column| !column.held && rows.all(|row| *row < self.times_s.len()))
    }

    /// Whether a row with values of real inputs is at a time.
    pub(crate) fn varies_at(&self, time_s: f64) -> bool {
        self.times_s.contains(&time_s) && self.columns.iter().any(|column| !column.held)
    }

    /// Times in s at which inputs jump: of two rows each, and of rows at which a switch changes.
    pub fn jumps_s(&self) -> impl Iterator<Item = f64> + '_ {
        let switched = |row: usize| self.columns.iter().any(|own| own.held && own.values[row] != own.values[row - 1]);
        let jumps = move |row: &usize| self.times_s[*row] == self.times_s[row - 1] || switched(*row);
        (1..self.times_s.len()).filter(jumps).map(|row| self.times_s[row])
    }

    /// Sets the inputs of a plant to their values at a time, before it is initialised there.
    ///
    /// # Panics
    /// If a column has an index that the plant's inputs do not have.
    pub fn set(&self, plant: &mut Plant, time_s: f64) {
        self.set_with(plant, time_s, None);
    }

    /// The same with a change of one column.
    pub(crate) fn set_with(&self, plant: &mut Plant, time_s: f64, offset: Option<Offset>) {
        let piece = self.piece_at(time_s);
        let values = plant.system_mut().inputs_mut().values_mut();
        for (index, value, _) in self.values(piece, offset) {
            values[index] = value;
        }
    }

    /// The stretch that starts at a time, or holds it.
    pub(crate) fn piece_at(&self, time_s: f64) -> Piece {
        let next = self.times_s.partition_point(|row_s| *row_s <= time_s);
        let last = self.times_s.len().saturating_sub(1);
        Piece { from_s: time_s, rows: [next.saturating_sub(1), next.min(last)] }
    }

    /// The time of the row after a stretch in s; infinite behind the last row.
    pub(crate) fn end_s(&self, piece: Piece) -> f64 {
        let next = self.times_s.partition_point(|row_s| *row_s <= piece.from_s);
        self.times_s.get(next).copied().unwrap_or(f64::INFINITY)
    }

    /// Share of a row in the inputs at a time of a stretch.
    pub(crate) fn weight(&self, row: usize, piece: Piece, time_s: f64) -> f64 {
        let [left, right] = piece.rows;
        let share = self.share(piece, time_s);
        let at = |own: usize, share: f64| if own == row { share } else { 0.0 };
        at(left, 1.0 - share) + at(right, share)
    }

    /// Rate of this share in 1/s.
    pub(crate) fn weight_rate_1_s(&self, row: usize, piece: Piece) -> f64 {
        let [left, right] = piece.rows;
        if left == right {
            return 0.0;
        }
        let rate_1_s = 1.0 / (self.times_s[right] - self.times_s[left]);
        let at = |own: usize, rate_1_s: f64| if own == row { rate_1_s } else { 0.0 };
        at(right, rate_1_s) - at(left, rate_1_s)
    }

    /// Place between the rows of a stretch, 0 to 1.
    fn share(&self, piece: Piece, time_s: f64) -> f64 {
        let [left, right] = piece.rows;
        if left == right {
            return 0.0;
        }
        let (from_s, to_s) = (self.times_s[left], self.times_s[right]);
        (time_s - from_s) / (to_s - from_s)
    }

    /// Place in [`Inputs::values`], value at the start of a stretch and rate per s of each input.
    fn values(&self, piece: Piece, offset: Option<Offset>) -> impl Iterator<Item = (usize, f64, f64)> + '_ {
        let [left, right] = piece.rows;
        let share = self.share(piece, piece.from_s);
        self.columns.iter().enumerate().map(move |(place, column)| {
            let by = |row: usize| match offset {
                Some(offset) if offset.column == place && offset.row.is_none_or(|own| own == row) => offset.by,
                Some(_) | None => 0.0,
            };
            let from = column.values[left];
            if left == right || column.held {
                return (column.index, from + by(left), 0.0);
            }
            let change = column.values[right] - from + (by(right) - by(left));
            let rate_1_s = change / (self.times_s[right] - self.times_s[left]);
            (column.index, from + share * change + by(left), rate_1_s)
        })
    }

    /// Writes the inputs of a stretch, as those that the coming step shall have, with their rates.
    pub(crate) fn write_next(&self, piece: Piece, state: &mut State) {
        let State { inputs, rates, .. } = state;
        self.write(piece, None, inputs, rates);
    }

    /// Writes the inputs of a stretch as those of the present step.
    pub(crate) fn write_present(&self, piece: Piece, offset: Option<Offset>, state: &mut State) {
        let State { applied_inputs, applied_rates, applied_from_s, .. } = state;
        self.write(piece, offset, applied_inputs, applied_rates);
        *applied_from_s = piece.from_s;
    }

    fn write(&self, piece: Piece, offset: Option<Offset>, inputs: &mut Inputs, rates: &mut Inputs) {
        for (index, value, rate_1_s) in self.values(piece, offset) {
            inputs.values_mut()[index] = value;
            rates.values_mut()[index] = rate_1_s;
        }
    }
}
