//! Figures of curves as SVG, PNG and PDF, from the same description: `plotters` draws the chart and writes the SVG; `tiny-skia` draws
//! the pixels (`pixels`), and `pdf-writer` writes the page (`page`).
//!
//! All three use integer coordinates in tenths of a user unit, because the coordinates of `plotters` are integers.

mod canvas;
mod ends;
mod heat;
mod page;
mod pixels;
mod thin;

use canvas::Backend;
use ends::spread;
pub use heat::Heat;
use pixels::Pixels;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::{
    Cartesian2d, ChartBuilder, ChartContext, Circle, Color, DashedLineSeries, DrawingArea, DrawingAreaErrorKind,
    DrawingBackend, FontStyle, IntoDrawingArea, IntoFont, LineSeries, PathElement, RGBColor, SVGBackend, ShapeStyle,
    TextStyle, WHITE,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;
use thin::thinned;
pub(super) use {canvas::outline, pixels::signed};

/// Integer coordinates per user unit.
const UNIT: u32 = 10;
/// Width and height of a figure in user units (pixels at scale 1).
pub const SIZE: [u32; 2] = [960, 600];
/// Width of the legend on the right, in user units.
const LEGEND: u32 = 190;
/// Space for labels on the left and below, in user units.
const LABELS: [u32; 2] = [78, 56];
/// Margin in user units.
const BORDER: u32 = 14;
/// Height of the title line in user units.
const TITLE: u32 = 40;
/// Line height of the name at the end of a curve, in user units.
const NAME_LINE: u32 = 17;
/// Width of a character in the label of a mark, in tenths of a user unit.
const MARK_LETTER: u32 = 72;
/// Maximum length of a name; longer names are shortened in the middle.
const LONGEST_NAME: usize = 24;

/// Font of labels; browsers without it use the most similar one.
const FONT: &str = "DejaVu Sans, Verdana, sans-serif";
/// The font file for pixels and pages: a subset (Latin, Greek, symbols) of DejaVu Sans 2.37 made by `pyftsubset --no-hinting
/// --layout-features=kern`; its licence is in the same folder.
pub(super) const FONT_FILE: &[u8] = include_bytes!("DejaVuSans.ttf");

/// Colours distinguishable by people with colour blindness (Okabe and Ito).
pub const PALETTE: [[u8; 3]; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233], [60, 60, 60]];

/// Comment that identifies an SVG of this program.
const DRAWN_BY: &str = "<!-- drawn by foldwing -->\n";

const INK: RGBColor = RGBColor(27, 39, 51);
const GRID: RGBColor = RGBColor(222, 227, 232);
const FAINT: RGBColor = RGBColor(110, 122, 134);

/// Style of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Look {
    /// Solid line; a dot if there is only one point.
    Line,
    /// Dashed line, used after all colours.
    Dashed,
    /// Dot at every point: measured data.
    Dots,
}

/// A curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Name, shown at the end of the curve or in the legend; empty for none.
    pub name: String,
    /// Red, green and blue components.
    pub colour: [u8; 3],
    /// Style.
    pub look: Look,
    /// Points `[x, y]`; points that are not finite are omitted, and the line continues without a gap.
    pub points: Vec<[f64; 2]>,
}

impl Curve {
    /// Creates the n-th curve of a figure, with a distinct colour and style.
    pub fn nth(n: usize, name: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        let look = if (n / PALETTE.len()) % 2 == 1 { Look::Dashed } else { Look::Line };
        Self { name: name.into(), colour: PALETTE[n % PALETTE.len()], look, points }
    }
}

/// Chart of curves with common axes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Figure {
    /// Heading.
    pub title: String,
    /// Quantity and unit of the horizontal axis.
    pub x_label: String,
    /// Quantity and unit of the vertical axis.
    pub y_label: String,
    /// Curves; the last is drawn on top.
    pub curves: Vec<Curve>,
    /// Times marked by a vertical line with a label above the chart.
    pub marks: Vec<(f64, String)>,
    /// Whether both axes have equal scales; names are then in a legend, otherwise at the ends of the curves.
    pub equal: bool,
    /// Cells instead of curves and axes, if given.
    pub heat: Option<Heat>,
}

/// Size and resolution of the files of a figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sheet {
    /// Width and height in user units of 1/96 inch.
    pub size: [u32; 2],
    /// Pixels per user unit in a PNG.
    pub scale: f32,
}

impl Default for Sheet {
    fn default() -> Self {
        Self { size: SIZE, scale: 2.0 }
    }
}

/// Error of a figure that cannot be drawn.
#[derive(Debug, thiserror::Error)]
#[error("figure `{title}`: {cause}")]
pub struct FigureError {
    title: String,
    cause: String,
}

impl Figure {
    /// Returns the figure as an SVG document.
    ///
    /// # Errors
    /// `plotters` cannot draw it.
    pub fn svg(&self, sheet: Sheet) -> Result<String, FigureError> {
        let size = sheet.size.map(|length| length * UNIT);
        let mut text = String::new();
        self.draw(sheet, &SVGBackend::with_string(&mut text, (size[0], size[1])).into_drawing_area())?;
        let [large, small] = [size, sheet.size].map(|[width, height]| format!("width=\"{width}\" height=\"{height}\""));
        // text must be on the same line as its element, otherwise viewers show the indentation
        let text = text.replacen(&large, &format!("{small} role=\"img\""), 1).replace(">\n</text>", "></text>");
        Ok(text.replacen('>', &format!(">\n{DRAWN_BY}"), 1))
    }

    /// Returns the figure as a PNG file.
    ///
    /// # Errors
    /// `plotters` cannot draw it.
    pub fn png(&self, sheet: Sheet) -> Result<Vec<u8>, FigureError> {
        let mut pixels = Pixels::new(sheet.size, UNIT, sheet.scale);
        self.draw(sheet, &Backend::new(&mut pixels, FONT_FILE).into_drawing_area())?;
        Ok(pixels.png())
    }

    fn draw<B: DrawingBackend>(&self, sheet: Sheet, area: &DrawingArea<B, Shift>) -> Result<(), FigureError> {
        // `plotters` measures text with the registered font
        let _ = plotters::style::register_font(FONT, FontStyle::Normal, FONT_FILE);
        self.chart(sheet.size, area)
            .map_err(|error| FigureError { title: self.title.clone(), cause: error.to_string() })
    }

    fn chart<B: DrawingBackend>(&self, size: [u32; 2], area: &DrawingArea<B, Shift>) -> Drawn<B> {
        area.fill(&WHITE)?;
        let title = style(17, &INK, HPos::Left, VPos::Center);
        area.draw_text(&self.title, &title, at(LABELS[0] + BORDER, BORDER + 10))?;
        if let Some(heat) = &self.heat {
            heat.cells(size, area)?;
            return area.present();
        }
        let (plot, legend) = area.split_horizontally((size[0] - LEGEND) * UNIT);
        let [x, y] = self.ranges(size);
        let mut chart = ChartBuilder::on(&plot)
            .margin(BORDER * UNIT)
            .margin_top((BORDER + TITLE) * UNIT)
            .x_label_area_size(LABELS[1] * UNIT)
            .y_label_area_size(LABELS[0] * UNIT)
            .build_cartesian_2d(x.clone(), y.clone())?;
        let turned = style(14, &INK, HPos::Center, VPos::Center);
        chart
            .configure_mesh()
            .max_light_lines(0)
            .bold_line_style(line(GRID, 1.0))
            .axis_style(line(FAINT, 1.0))
            .set_all_tick_mark_size(5 * UNIT)
            .x_labels(8)
            .y_labels(8)
            .label_style(style(13, &INK, HPos::Center, VPos::Center))
            .axis_desc_style(turned)
            .x_label_formatter(&|value| tidy(*value, &x))
            .y_label_formatter(&|value| tidy(*value, &y))
            .x_desc(self.x_label.as_str())
            .y_desc(self.y_label.as_str())
            .draw()?;
        self.draw_marks(size, area, &mut chart, &y)?;
        for curve in &self.curves {
            draw_curve(&mut chart, curve, &x)?;
        }
        if self.equal {
            self.draw_legend(size, &legend)?;
        } else {
            self.draw_names(size, area, &chart)?;
        }
        area.present()
    }

    /// Draws dashed lines at the marks, with labels above the chart that do not overlap; labels without space are omitted.
    fn draw_marks<B: DrawingBackend>(
        &self,
        size: [u32; 2],
        area: &DrawingArea<B, Shift>,
        chart: &mut Chart<'_, B>,
        y: &Range<f64>,
    ) -> Drawn<B> {
        let mut labels = Vec::new();
        for (x, label) in &self.marks {
            let ends = [(*x, y.start), (*x, y.end)];
            chart.draw_series(DashedLineSeries::new(ends, 6 * UNIT, 4 * UNIT, line(FAINT, 1.2)))?;
            let (pixel, _) = chart.backend_coord(&ends[1]);
            labels.push((f64::from(pixel), pixel, label));
        }
        let longest = labels.iter().map(|(_, _, label)| label.chars().count()).max().unwrap_or_default();
        let wide = f64::from(MARK_LETTER) * longest as f64;
        let range = [f64::from(BORDER * UNIT), f64::from((size[0] - BORDER) * UNIT)];
        labels.truncate(((range[1] - range[0]) / wide.max(1.0)) as usize);
        spread(&mut labels, wide, [range[0] + 0.5 * wide, range[1] - 0.5 * wide]);
        for (place, _, label) in labels {
            let label_style = style(12, &FAINT, HPos::Center, VPos::Center);
            area.draw_text(label, &label_style, (place as i32, at(0, BORDER + TITLE - 8).1))?;
        }
        Ok(())
    }

    /// Draws the name of every curve at its end, in its colour, without overlap.
    fn draw_names<B: DrawingBackend>(
        &self,
        size: [u32; 2],
        area: &DrawingArea<B, Shift>,
        chart: &Chart<'_, B>,
    ) -> Drawn<B> {
        let last = |curve: &&Curve| curve.points.iter().rfind(|point| point.iter().all(|c| c.is_finite())).copied();
        let named = self.curves.iter().filter(|curve| !curve.name.is_empty());
        let mut ends: Vec<(f64, i32, &Curve)> = named
            .filter_map(|curve| {
                let [x, y] = last(&curve)?;
                let (_, pixel) = chart.backend_coord(&(x, y));
                Some((f64::from(pixel), pixel, curve))
            })
            .collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (top, bottom) = (f64::from((BORDER + TITLE) * UNIT), f64::from((size[1] - BORDER) * UNIT));
        let apart = f64::from(NAME_LINE * UNIT).min((bottom - top) / ends.len().max(1) as f64);
        spread(&mut ends, apart, [top, bottom]);
        let left = (size[0] - LEGEND - BORDER) * UNIT;
        for (y, end, curve) in &ends {
            let (from, to) = ((left + 3 * UNIT) as i32, (left + 15 * UNIT) as i32);
            area.draw(&PathElement::new(vec![(from, *end), (to, *y as i32)], line(colour(curve), 0.9)))?;
            let ink = colour(curve);
            let text = style(13, &INK, HPos::Left, VPos::Center).color(&ink);
            area.draw_text(&short(&curve.name), &text, (to + (4 * UNIT) as i32, *y as i32))?;
        }
        Ok(())
    }

    fn draw_legend<B: DrawingBackend>(&self, size: [u32; 2], area: &DrawingArea<B, Shift>) -> Drawn<B> {
        let named = self.curves.iter().filter(|curve| !curve.name.is_empty());
        for (row, curve) in named.enumerate() {
            let y = BORDER + TITLE + 12 + 22 * row as u32;
            if y + 22 > size[1] {
                break; // a figure with so many curves needs no complete legend
            }
            let stroke = line(colour(curve), 2.2);
            match curve.look {
                _ if curve.points.len() == 1 => area.draw(&Circle::new(at(14, y), 4 * UNIT, colour(curve).filled()))?,
                Look::Dots => area.draw(&Circle::new(at(14, y), 3 * UNIT, colour(curve).filled()))?,
                Look::Dashed => {
                    area.draw(&PathElement::new(vec![at(2, y), at(11, y)], stroke))?;
                    area.draw(&PathElement::new(vec![at(17, y), at(26, y)], stroke))?;
                }
                Look::Line => area.draw(&PathElement::new(vec![at(2, y), at(26, y)], stroke))?,
            }
            let text = style(13, &INK, HPos::Left, VPos::Center);
            area.draw_text(&short(&curve.name), &text, at(34, y))?;
        }
        Ok(())
    }

    /// Ranges of the axes: they include all points with a margin, are never empty, and have equal scales if requested.
    fn ranges(&self, size: [u32; 2]) -> [Range<f64>; 2] {
        let points =
            self.curves.iter().flat_map(|curve| &curve.points).filter(|point| point.iter().all(|c| c.is_finite()));
        let mut least = [f64::INFINITY; 2];
        let mut most = [f64::NEG_INFINITY; 2];
        for point in points {
            for axis in 0..2 {
                least[axis] = least[axis].min(point[axis]);
                most[axis] = most[axis].max(point[axis]);
            }
        }
        let room = [if self.equal { 0.06 } else { 0.0 }, 0.06];
        let mut spans = [0, 1].map(|axis| {
            if least[axis] > most[axis] {
                return [0.5, 1.0];
            }
            let middle = 0.5 * (least[axis] + most[axis]);
            let half = 0.5 * (most[axis] - least[axis]);
            // a constant curve is drawn without its round-off
            let floor = (1e-9 * middle.abs()).max(1e-12);
            let half = if half > floor { half * (1.0 + room[axis]) } else { (0.1 * middle.abs()).max(1e-3) };
            [middle, half]
        });
        if self.equal {
            let sides = [
                f64::from(size[0] - LEGEND - LABELS[0] - 2 * BORDER),
                f64::from(size[1] - LABELS[1] - TITLE - 2 * BORDER),
            ];
            let scale = (spans[0][1] / sides[0]).max(spans[1][1] / sides[1]);
            spans = [0, 1].map(|axis| [spans[axis][0], scale * sides[axis]]);
        }
        spans.map(|[middle, half]| middle - half..middle + half)
    }
}

type Drawn<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;
type Chart<'a, B> = ChartContext<'a, B, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

fn draw_curve<B: DrawingBackend>(chart: &mut Chart<'_, B>, curve: &Curve, x: &Range<f64>) -> Drawn<B> {
    let stroke = line(colour(curve), 1.8);
    let points: Vec<(f64, f64)> = thinned(&curve.points, x).into_iter().map(|[x, y]| (x, y)).collect();
    if let [point] = points[..] {
        chart.draw_series([Circle::new(point, 4 * UNIT, colour(curve).filled())])?;
    } else if curve.look == Look::Dots {
        chart
            .draw_series(points.into_iter().map(|point| Circle::new(point, (5 * UNIT) / 2, colour(curve).filled())))?;
    } else if curve.look == Look::Dashed {
        chart.draw_series(DashedLineSeries::new(points, 7 * UNIT, 4 * UNIT, stroke))?;
    } else {
        chart.draw_series(LineSeries::new(points, stroke))?;
    }
    Ok(())
}

fn at(x: u32, y: u32) -> (i32, i32) {
    ((x * UNIT) as i32, (y * UNIT) as i32)
}

fn colour(curve: &Curve) -> RGBColor {
    let [red, green, blue] = curve.colour;
    RGBColor(red, green, blue)
}

/// Line style with a width in user units.
fn line(colour: RGBColor, width: f64) -> ShapeStyle {
    colour.stroke_width((width * f64::from(UNIT)).round() as u32)
}

/// Text style with a font size in user units.
fn style(size: u32, colour: &'static RGBColor, across: HPos, along: VPos) -> TextStyle<'static> {
    // the size in `plotters` is the line height, which is 1.24 times the font size
    let height = 1.24 * f64::from(size * UNIT);
    TextStyle::from((FONT, height).into_font()).color(colour).pos(Pos::new(across, along))
}

/// Formats the label of an axis with as many digits as its range needs, and a typographic minus sign.
fn tidy(value: f64, range: &Range<f64>) -> String {
    let span = range.end - range.start;
    if value.abs() < 1e-9 * span {
        return "0".to_owned();
    }
    let digits = (2.0 - span.log10()).ceil().clamp(0.0, 12.0) as usize;
    let trimmed = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    let text = if value.abs() >= 1e6 {
        let digits = (2.0 + (value.abs() / span).log10().ceil()).clamp(0.0, 12.0) as usize;
        let text = format!("{value:.digits$e}");
        text.split_once('e').map_or_else(|| text.clone(), |(number, power)| format!("{}e{power}", trimmed(number)))
    } else {
        trimmed(&format!("{value:.digits$}"))
    };
    text.replace('-', "−")
}

/// Shortens a name to the width of the legend.
fn short(name: &str) -> String {
    shortened(name, LONGEST_NAME)
}

/// Shortens a name to a number of characters by omitting its middle.
fn shortened(name: &str, most: usize) -> String {
    let letters: Vec<char> = name.chars().collect();
    if letters.len() <= most {
        return name.to_owned();
    }
    let half = most / 2;
    letters[..half].iter().chain(&['…']).chain(&letters[letters.len() - half..]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(points: Vec<[f64; 2]>) -> Figure {
        Figure { title: "a < b".to_owned(), curves: vec![Curve::nth(0, "wing & tip", points)], ..Figure::default() }
    }

    /// Texts of the model are escaped, sizes are in user units, and equal figures give equal bytes.
    #[test]
    fn svg_and_png_are_made_of_the_same_figure() {
        let figure = figure(vec![[0.0, 1.0], [1.0, 2.0], [2.0, 1.5]]);
        let svg = figure.svg(Sheet::default()).unwrap();
        assert!(svg.starts_with("<svg width=\"960\" height=\"600\" role=\"img\" viewBox=\"0 0 9600 6000\""), "{svg}");
        assert!(svg.contains("a &lt; b") && svg.contains("wing &amp; tip"));
        assert_eq!(svg, figure.svg(Sheet::default()).unwrap());
        let png = figure.png(Sheet::default()).unwrap();
        let picture = tiny_skia::Pixmap::decode_png(&png).unwrap();
        assert_eq!([picture.width(), picture.height()], SIZE.map(|length| 2 * length));
        assert_eq!(png, figure.png(Sheet::default()).unwrap());
        let small = figure.png(Sheet { size: [480, 300], scale: 1.0 }).unwrap();
        let picture = tiny_skia::Pixmap::decode_png(&small).unwrap();
        assert_eq!([picture.width(), picture.height()], [480, 300]);
    }

    /// Figures without points, with one point, with a constant and with values that are not finite are drawn without an error.
    #[test]
    fn odd_curves_are_drawn() {
        let cases = [
            vec![],
            vec![[1.0, 1.0]],
            vec![[0.0, 5.0], [1.0, 5.0]],
            vec![[0.0, 0.0], [1.0, 1e-300]],
            vec![[0.0, f64::NAN], [1.0, 2.0], [2.0, f64::INFINITY], [3.0, 4.0]],
            vec![[0.0, -1e300], [1.0, 1e300]],
        ];
        for points in cases {
            for equal in [false, true] {
                let figure = Figure { equal, ..figure(points.clone()) };
                let (svg, png) = (figure.svg(Sheet::default()).unwrap(), figure.png(Sheet::default()).unwrap());
                assert!(svg.ends_with("</svg>\n") && !png.is_empty(), "{points:?}");
            }
        }
    }

    /// With equal scales, a unit has the same length along both axes.
    #[test]
    fn equal_scales_are_equal() {
        let [x, y] = Figure { equal: true, ..figure(vec![[0.0, 0.0], [1.0, 0.01]]) }.ranges(SIZE);
        let sides =
            [SIZE[0] - LEGEND - LABELS[0] - 2 * BORDER, SIZE[1] - LABELS[1] - TITLE - 2 * BORDER].map(f64::from);
        let scales = [(x.end - x.start) / sides[0], (y.end - y.start) / sides[1]];
        assert!((scales[0] / scales[1] - 1.0).abs() < 1e-12, "{scales:?}");
    }

    #[test]
    fn labels_have_the_digits_they_need() {
        let cases = [
            (0.1, 0.4, "0.1"),
            (-2.5, 10.0, "−2.5"),
            (1e-20, 1.0, "0"),
            (0.00125, 0.004, "0.00125"),
            (300.0, 400.0, "300"),
            (5.000000000000001e29, 1e30, "5e29"),
            (-1_234_567.0, 1e3, "−1.234567e6"),
        ];
        for (value, span, text) in cases {
            assert_eq!(tidy(value, &(0.0..span)), text);
        }
        assert_eq!(short("station.outer[4].position.x"), "station.oute…].position.x");
        assert_eq!(short("fold.angle"), "fold.angle");
    }
}
