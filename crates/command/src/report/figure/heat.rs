//! Table of cells coloured by their values, which shows the sensitivity of each result to each quantity.

use super::{BORDER, Drawn, FAINT, GRID, INK, TITLE, UNIT, at, line, shortened, style};
use plotters::coord::Shift;
use plotters::prelude::{Color, DrawingArea, DrawingBackend, RGBColor, Rectangle};
use plotters::style::text_anchor::{HPos, VPos};

/// Width of a character of a label, in user units.
const LETTER: u32 = 7;
/// Width of the colour scale with its labels, in user units.
const SCALE: u32 = 96;
/// Height of the labels above the cells, in user units.
const HEAD: u32 = 26;
/// Maximum height of a row, in user units.
const TALLEST: u32 = 96;
/// Minimum height of a row whose cells show numbers, in user units.
const READABLE: u32 = 14;
/// Colours of the smallest value, zero and the largest value, distinguishable by people with colour blindness.
const ENDS: [[u8; 3]; 3] = [[0, 114, 178], [255, 255, 255], [213, 94, 0]];

/// A table of numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Heat {
    /// Names of the rows, shown on the left.
    pub rows: Vec<String>,
    /// Names of the columns, shown at the top.
    pub columns: Vec<String>,
    /// Values, row by row; cells with values that are not finite are not coloured.
    pub values: Vec<Vec<f64>>,
    /// Quantity and unit of the values, shown above the colour scale.
    pub unit: String,
}

impl Heat {
    /// Largest magnitude of the values; 1 if there are none.
    pub(super) fn largest(&self) -> f64 {
        let sizes = self.values.iter().flatten().filter(|value| value.is_finite()).map(|value| value.abs());
        let largest = sizes.fold(0.0, f64::max);
        if largest > 0.0 { largest } else { 1.0 }
    }

    /// Draws names, cells and the colour scale below the title.
    pub(super) fn cells<B: DrawingBackend>(&self, size: [u32; 2], area: &DrawingArea<B, Shift>) -> Drawn<B> {
        let longest = self.rows.iter().map(|name| name.chars().count() as u32).max().unwrap_or(0);
        let left = BORDER + (LETTER * longest + 16).min(size[0] * 2 / 5);
        let top = BORDER + TITLE + HEAD;
        let (wide, tall) = (size[0] - left - SCALE - 2 * BORDER, size[1] - top - BORDER);
        let (rows, columns) = (self.rows.len().max(1) as u32, self.columns.len().max(1) as u32);
        // in tenths of a user unit, so that many cells have equal widths
        let (width, height) = (wide * UNIT / columns, (tall * UNIT / rows).min(TALLEST * UNIT));
        let corner =
            |row: u32, column: u32| ((left * UNIT + column * width) as i32, (top * UNIT + row * height) as i32);
        let largest = self.largest();
        for (column, name) in (0..columns).zip(&self.columns) {
            let (x, y) = corner(0, column);
            let label = shortened(name, (width / (LETTER * UNIT)).max(3) as usize);
            let place = (x + width as i32 / 2, y - (HEAD * UNIT / 2) as i32);
            area.draw_text(&label, &style(12, &INK, HPos::Center, VPos::Center), place)?;
        }
        for ((row, name), values) in (0..rows).zip(&self.rows).zip(&self.values) {
            let (x, y) = corner(row, 0);
            let middle = y + height as i32 / 2;
            let label = shortened(name, ((left - BORDER - 10) / LETTER) as usize);
            area.draw_text(&label, &style(12, &INK, HPos::Right, VPos::Center), (x - (8 * UNIT) as i32, middle))?;
            for (column, value) in (0..columns).zip(values) {
                let (from, to) = (corner(row, column), corner(row + 1, column + 1));
                let (fill, ink) = colours(value / largest);
                area.draw(&Rectangle::new([from, to], fill.filled()))?;
                area.draw(&Rectangle::new([from, to], line(GRID, 1.0)))?;
                if height >= READABLE * UNIT && width >= 40 * UNIT {
                    let text = style(12, ink, HPos::Center, VPos::Center);
                    area.draw_text(&number(*value), &text, (from.0 + width as i32 / 2, middle))?;
                }
            }
        }
        self.scale(largest, [size[0] - BORDER - SCALE + 16, top, (rows * height / UNIT).max(120).min(tall)], area)
    }

    /// Draws the colour scale at a position, with a given height.
    fn scale<B: DrawingBackend>(&self, largest: f64, [x, y, tall]: [u32; 3], area: &DrawingArea<B, Shift>) -> Drawn<B> {
        let bands = 64;
        let level = |band: u32| ((y * UNIT) + tall * UNIT * band / bands) as i32;
        for band in 0..bands {
            let share = 1.0 - 2.0 * (f64::from(band) + 0.5) / f64::from(bands);
            // each band extends to the end of the scale, so that there are no gaps between bands
            let ends = [(at(x, 0).0, level(band)), (at(x + 14, 0).0, level(bands))];
            area.draw(&Rectangle::new(ends, colours(share).0.filled()))?;
        }
        area.draw(&Rectangle::new([at(x, y), at(x + 14, y + tall)], line(FAINT, 1.0)))?;
        for (share, value) in [(0, largest), (bands / 2, 0.0), (bands, -largest)] {
            let place = (at(x + 20, 0).0, level(share));
            area.draw_text(&number(value), &style(12, &INK, HPos::Left, VPos::Center), place)?;
        }
        area.draw_text(&self.unit, &style(12, &FAINT, HPos::Right, VPos::Center), at(x + SCALE - 16, y - HEAD - 8))
    }
}

/// Colours of a cell and of its number, for a value from -1 to 1. The square root of the magnitude makes small values visible next to large
/// ones.
fn colours(share: f64) -> (RGBColor, &'static RGBColor) {
    if !share.is_finite() {
        return (GRID, &FAINT);
    }
    let size = share.abs().min(1.0).sqrt();
    let end = if share < 0.0 { ENDS[0] } else { ENDS[2] };
    let mix = |i: usize| (f64::from(ENDS[1][i]) * (1.0 - size) + f64::from(end[i]) * size).round() as u8;
    (RGBColor(mix(0), mix(1), mix(2)), if size > 0.75 { &plotters::prelude::WHITE } else { &INK })
}

/// Formats two digits; a dash if the value is not finite.
fn number(value: f64) -> String {
    let text = match value.abs() {
        _ if !value.is_finite() => return "–".to_owned(),
        0.0 => "0".to_owned(),
        1e-3..1e4 => {
            let digits = (1 - value.abs().log10().floor() as i32).max(0) as usize;
            format!("{value:.digits$}")
        }
        _ => format!("{value:.1e}"),
    };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::figure::{Figure, Sheet};

    fn heat(rows: usize, columns: usize) -> Heat {
        let value = |i: usize, j: usize| if i == j { f64::NAN } else { (i as f64 - j as f64) * 0.1 };
        Heat {
            rows: (0..rows).map(|i| format!("file:section.plate.number_{i}<")).collect(),
            columns: (0..columns).map(|j| format!("result_{j}")).collect(),
            values: (0..rows).map(|i| (0..columns).map(|j| value(i, j)).collect()).collect(),
            unit: "% per %".to_owned(),
        }
    }

    /// Tables of any size are drawn, and names are escaped. The value of largest magnitude has the colour at the end of the scale, and one
    /// that is not finite has none.
    #[test]
    fn tables_of_any_size_are_drawn() {
        for (rows, columns) in [(0, 0), (1, 1), (4, 3), (2, 30), (200, 2)] {
            let figure = Figure { title: "a".to_owned(), heat: Some(heat(rows, columns)), ..Figure::default() };
            for size in [[480, 240], [960, 600]] {
                let sheet = Sheet { size, scale: 1.0 };
                let (svg, png) = (figure.svg(sheet).unwrap(), figure.png(sheet).unwrap());
                assert!(svg.ends_with("</svg>\n") && !png.is_empty() && !figure.pdf(sheet).unwrap().is_empty());
                assert!(rows == 0 || svg.contains("&lt;"), "{rows} {columns}");
            }
        }
        let svg = Figure { heat: Some(heat(4, 3)), ..Figure::default() }.svg(Sheet::default()).unwrap();
        assert!(svg.contains("0.30") && svg.contains("−0.20") && svg.contains("#D55E00") && svg.contains("–"), "{svg}");
        assert_eq!(heat(4, 3).largest(), 0.30000000000000004);
        assert_eq!(heat(1, 1).largest(), 1.0);
    }

    /// Colours of values with equal magnitude and opposite sign are equally far from white; zero is white.
    #[test]
    fn colours_have_the_sign_and_the_size() {
        assert_eq!(colours(0.0).0, RGBColor(255, 255, 255));
        assert_eq!((colours(1.0).0, colours(-1.0).0), (RGBColor(213, 94, 0), RGBColor(0, 114, 178)));
        assert_eq!((colours(f64::NAN).0, colours(7.0).0), (GRID, RGBColor(213, 94, 0)));
        assert_eq!(colours(0.25).0, RGBColor(234, 175, 128));
        for (value, text) in [(0.0123, "0.012"), (-0.5, "−0.50"), (12.3, "12"), (1234.0, "1234"), (2e5, "2.0e5")] {
            assert_eq!(number(value), text);
        }
    }
}
