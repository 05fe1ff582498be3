//! Sizes of the parts of a figure: wide ones have the names of curves at their ends, narrow ones are for a journal column, with
//! 8-point text and the names in rows above the chart.

use super::{BORDER, Curve, Figure, LONGEST_NAME, TITLE};

/// Narrower figures are laid out for a column: in user units, of which an inch has 96.
pub(super) const COLUMN: u32 = 480;
/// Most rows of names in a column.
const MOST_ROWS: u32 = 4;
/// Height of a row of names, in user units.
pub(super) const ROW: u32 = 15;
/// Length of the stroke before a name in a row, in user units.
pub(super) const STROKE: u32 = 16;
/// Room after a name in a row, in user units.
const APART: u32 = 10;
/// Distance of titles and names from the left in columns, in user units.
const LEFT: u32 = 14;
/// Mean width of a letter of 11 units, in tenths of a user unit.
const LETTER: u32 = 68;

/// Sizes in user units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    /// Room for names at the right.
    pub names: u32,
    /// Room for labels at the left and below.
    pub labels: [u32; 2],
    /// Margin, and margin to the right of the chart, which contains half of the last number of the axis.
    pub border: u32,
    pub right: u32,
    /// Distance of the title from the left.
    pub left: u32,
    /// Height of the title's line, in wide figures with the line of the marks.
    pub title: u32,
    /// Rows of names above the chart.
    pub rows: u32,
    /// Height of the line of the marks' labels below the names.
    pub marks: u32,
    /// Sizes of the letters of title, axes, numbers and names, marks.
    pub heading: u32,
    pub axis: u32,
    pub text: u32,
    pub small: u32,
    /// Width of a letter of a mark's label, in tenths of a user unit.
    pub letter: u32,
    /// Length of the ticks.
    pub tick: u32,
    /// Largest numbers of labels on the axes.
    pub ticks: [usize; 2],
}

/// Sizes of wide figures.
pub(super) const WIDE: Layout = Layout {
    names: 190,
    labels: [78, 56],
    border: BORDER,
    right: BORDER,
    left: 92,
    title: TITLE,
    rows: 0,
    marks: 0,
    heading: 17,
    axis: 14,
    text: 13,
    small: 12,
    letter: 72,
    tick: 5,
    ticks: [8, 8],
};

impl Layout {
    /// Sizes for a figure of a size.
    pub fn of(size: [u32; 2], figure: &Figure) -> Self {
        if size[0] >= COLUMN && figure.panels.is_empty() {
            return WIDE;
        }
        let rows = rows(figure, size).map(|([_, row], _)| row + 1).max().unwrap_or(0).min(MOST_ROWS);
        let marks = if figure.marks.is_empty() { 0 } else { 13 };
        // letters of 11 units have 8.25 points
        let letters = 11;
        Self {
            names: 0,
            labels: [54, 36],
            border: 8,
            right: 16,
            left: LEFT,
            title: if size[0] < COLUMN { 18 } else { 28 },
            rows,
            marks,
            heading: if size[0] < COLUMN { letters } else { 15 },
            axis: letters,
            text: letters,
            small: letters,
            letter: LETTER,
            tick: 3,
            ticks: [6, 5],
        }
    }

    /// Height from the border to the chart.
    pub fn top(&self) -> u32 {
        self.title + self.rows * ROW + self.marks
    }
}

/// Positions of the names in rows: distance from the left in user units and row.
pub(super) fn rows(figure: &Figure, size: [u32; 2]) -> impl Iterator<Item = ([u32; 2], &Curve)> {
    let (left, right) = (LEFT, size[0].saturating_sub(8));
    let named = figure.curves.iter().filter(|curve| !curve.name.is_empty());
    named.scan([left, 0], move |[x, row], curve| {
        let letters = curve.name.chars().count().min(LONGEST_NAME) as u32;
        let wide = STROKE + 4 + letters * LETTER / 10;
        if *x + wide > right && *x > left {
            (*x, *row) = (left, *row + 1);
        }
        let place = [*x, *row];
        *x += wide + APART;
        Some((place, curve))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(names: &[&str]) -> Figure {
        let curves = names.iter().enumerate().map(|(n, name)| Curve::nth(n, *name, vec![[0.0, 0.0], [1.0, 1.0]]));
        Figure { curves: curves.collect(), ..Figure::default() }
    }

    /// In a column of 85 mm the text has 8 points or more; the rows of names do not overlap and stay within the column.
    #[test]
    fn columns_are_legible() {
        let column = [(85.0 / 25.4 * 96.0) as u32, 220];
        let figure = named(&["mode 1", "mode 2", "a name of many letters that is shortened", "mode 3", "x"]);
        let layout = Layout::of(column, &figure);
        for letters in [layout.heading, layout.axis, layout.text, layout.small] {
            assert!(f64::from(letters) * 0.75 >= 8.0, "{letters} units");
        }
        let places: Vec<_> = rows(&figure, column).map(|(place, _)| place).collect();
        assert_eq!(layout.rows, places[4][1] + 1);
        for (before, after) in places.iter().zip(&places[1..]) {
            assert!(after[1] > before[1] || after[0] > before[0] + STROKE, "{places:?}");
            assert!(after[0] < column[0]);
        }
        assert_eq!(Layout::of([960, 600], &figure), WIDE);
    }
}
