//! Figures of curves, as SVG, PNG and PDF, from one description: `plotters` draws the chart and its SVG; the pixels are drawn by
//! `tiny-skia` (`pixels`), the page by `pdf-writer` (`page`).
//!
//! All use tenths of a user unit as integers, because the coordinates of `plotters` are integers.

mod canvas;
mod ends;
mod heat;
mod layout;
mod names;
mod page;
mod pixels;
mod thin;

use canvas::Backend;
pub use heat::Heat;
use layout::Layout;
use pixels::Pixels;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::{
    Cartesian2d, ChartBuilder, ChartContext, Circle, Color, DashedLineSeries, DrawingArea, DrawingAreaErrorKind,
    DrawingBackend, FontStyle, IntoDrawingArea, IntoFont, LineSeries, RGBColor, SVGBackend, ShapeStyle, TextStyle,
    WHITE,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;
use thin::thinned;
pub(super) use {canvas::outline, pixels::signed};

/// Integer coordinates per user unit.
const UNIT: u32 = 10;
/// Width and height of a figure in user units (pixels at scale 1).
pub const SIZE: [u32; 2] = [960, 600];
/// Free border in user units.
const BORDER: u32 = 14;
/// Height of the title's line in user units.
const TITLE: u32 = 40;
/// Longer names are shortened in their middle.
const LONGEST_NAME: usize = 24;

/// Font of labels; browsers without it use the most similar one.
const FONT: &str = "DejaVu Sans, Verdana, sans-serif";
/// The same font for the pixels: a subset (Latin, Greek, signs) of DejaVu Sans 2.37 by `pyftsubset --no-hinting --layout-features=kern`;
/// its licence is in the same folder.
pub(super) const FONT_FILE: &[u8] = include_bytes!("DejaVuSans.ttf");

/// Colours that are distinct for people with colour blindness (Okabe and Ito).
pub const PALETTE: [[u8; 3]; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 158, 115], [204, 121, 167], [230, 159, 0], [86, 180, 233], [60, 60, 60]];

/// Comment by which an SVG of this program is recognised.
const DRAWN_BY: &str = "<!-- drawn by foldwing -->\n";

const INK: RGBColor = RGBColor(27, 39, 51);
const GRID: RGBColor = RGBColor(222, 227, 232);
const FAINT: RGBColor = RGBColor(110, 122, 134);

/// Style of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Look {
    /// A line; a dot if it has one point.
    Line,
    /// Dashed, after all colours are used.
    Dashed,
    /// A dot at every point: measured data.
    Dots,
}

/// A curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Name at its end or in the legend; empty for none.
    pub name: String,
    /// Red, green, blue.
    pub colour: [u8; 3],
    /// Style.
    pub look: Look,
    /// Points `[x, y]`; those that are not finite are omitted without a gap.
    pub points: Vec<[f64; 2]>,
}

impl Curve {
    /// The n-th curve of a figure, with its own colour and style.
    pub fn nth(n: usize, name: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        let look = if (n / PALETTE.len()) % 2 == 1 { Look::Dashed } else { Look::Line };
        Self { name: name.into(), colour: PALETTE[n % PALETTE.len()], look, points }
    }
}

/// A chart of curves over one pair of axes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Figure {
    /// Heading.
    pub title: String,
    /// Quantity and unit of the horizontal axis.
    pub x_label: String,
    /// Quantity and unit of the vertical axis.
    pub y_label: String,
    /// Curves, the last on top.
    pub curves: Vec<Curve>,
    /// Times marked by a vertical line with a label above the chart.
    pub marks: Vec<(f64, String)>,
    /// Equal scales on both axes; names are then in a legend, otherwise at the ends of the curves.
    pub equal: bool,
    /// Cells instead of curves and axes.
    pub heat: Option<Heat>,
    /// Other figures on one sheet instead of a chart, row by row, and the number of columns.
    pub panels: Vec<Figure>,
    /// Number of columns of `panels`; 0 for one.
    pub columns: u32,
    /// Fixed width and height of the sheet in user units, which override the requested size.
    pub own_size: Option<[u32; 2]>,
}

/// Size and resolution of the files of a figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sheet {
    /// Width and height in user units, of which an inch has 96.
    pub size: [u32; 2],
    /// Pixels per user unit of a PNG.
    pub scale: f32,
}

impl Default for Sheet {
    fn default() -> Self {
        Self { size: SIZE, scale: 2.0 }
    }
}

/// A figure that cannot be drawn.
#[derive(Debug, thiserror::Error)]
#[error("figure `{title}`: {cause}")]
pub struct FigureError {
    title: String,
    cause: String,
}

impl Figure {
    /// The figure as an SVG document.
    ///
    /// # Errors
    /// `plotters` cannot draw it.
    pub fn svg(&self, sheet: Sheet) -> Result<String, FigureError> {
        let sheet = self.sheet(sheet);
        let size = sheet.size.map(|length| length * UNIT);
        let mut text = String::new();
        self.draw(sheet, &SVGBackend::with_string(&mut text, (size[0], size[1])).into_drawing_area())?;
        let [large, small] = [size, sheet.size].map(|[width, height]| format!("width=\"{width}\" height=\"{height}\""));
        // text must be on one line with its element, otherwise viewers show its indentation
        let text = text.replacen(&large, &format!("{small} role=\"img\""), 1).replace(">\n</text>", "></text>");
        Ok(text.replacen('>', &format!(">\n{DRAWN_BY}"), 1))
    }

    /// The figure as a PNG file.
    ///
    /// # Errors
    /// `plotters` cannot draw it.
    pub fn png(&self, sheet: Sheet) -> Result<Vec<u8>, FigureError> {
        let sheet = self.sheet(sheet);
        let mut pixels = Pixels::new(sheet.size, UNIT, sheet.scale);
        self.draw(sheet, &Backend::new(&mut pixels, FONT_FILE).into_drawing_area())?;
        Ok(pixels.png())
    }

    /// Sheet of this figure for a requested sheet: panels one below the other are two thirds as high as a single figure, and as high in a
    /// column layout.
    fn sheet(&self, asked: Sheet) -> Sheet {
        let rows = (self.panels.len() as u32).div_ceil(self.columns.max(1)).max(1);
        let [width, height] = asked.size;
        let stacked = [width, if rows > 1 && width >= layout::COLUMN { height * 2 * rows / 3 } else { height * rows }];
        Sheet { size: self.own_size.unwrap_or(stacked), ..asked }
    }

    fn draw<B: DrawingBackend>(&self, sheet: Sheet, area: &DrawingArea<B, Shift>) -> Result<(), FigureError> {
        // `plotters` measures text with a registered font
        let _ = plotters::style::register_font(FONT, FontStyle::Normal, FONT_FILE);
        area.fill(&WHITE)
            .and_then(|()| self.chart(sheet.size, area))
            .and_then(|()| area.present())
            .map_err(|error| FigureError { title: self.title.clone(), cause: error.to_string() })
    }

    fn chart<B: DrawingBackend>(&self, size: [u32; 2], area: &DrawingArea<B, Shift>) -> Drawn<B> {
        let layout = Layout::of(size, self);
        let title = style(layout.heading, &INK, HPos::Left, VPos::Center);
        area.draw_text(&self.title, &title, at(layout.left, layout.border + layout.title / 4))?;
        if !self.panels.is_empty() {
            for (i, (corner, part)) in self.places(size, &layout).take(self.panels.len()).enumerate() {
                let [from, sides] = [corner, part].map(|[x, y]| at(x, y));
                let part_area = area.clone().shrink(from, (sides.0 as u32, sides.1 as u32));
                self.panel(i, part[0] < layout::COLUMN).chart(part, &part_area)?;
            }
            return Ok(());
        }
        if let Some(heat) = &self.heat {
            return heat.cells(size, area);
        }
        let (plot, legend) = area.split_horizontally((size[0] - layout.names) * UNIT);
        let [x, y] = self.ranges(size);
        let mut chart = ChartBuilder::on(&plot)
            .margin(layout.border * UNIT)
            .margin_top((layout.border + layout.top()) * UNIT)
            .margin_right(layout.right * UNIT)
            .x_label_area_size(layout.labels[1] * UNIT)
            .y_label_area_size(layout.labels[0] * UNIT)
            .build_cartesian_2d(x.clone(), y.clone())?;
        let turned = style(layout.axis, &INK, HPos::Center, VPos::Center);
        chart
            .configure_mesh()
            .max_light_lines(0)
            .bold_line_style(line(GRID, 1.0))
            .axis_style(line(FAINT, 1.0))
            .set_all_tick_mark_size(layout.tick * UNIT)
            .x_labels(layout.ticks[0])
            .y_labels(layout.ticks[1])
            .label_style(style(layout.text, &INK, HPos::Center, VPos::Center))
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
        if layout.names == 0 {
            self.draw_rows(&layout, size, area)
        } else if self.equal {
            self.draw_legend(size, &legend)
        } else {
            self.draw_names(size, area, &chart)
        }
    }

    /// A panel; in a column, one below another with the same names has none.
    fn panel(&self, index: usize, narrow: bool) -> Figure {
        let mut panel = self.panels[index].clone();
        let names = |figure: &Figure| figure.curves.iter().map(|curve| curve.name.clone()).collect::<Vec<_>>();
        if narrow && self.columns == 1 && index > 0 && names(&panel) == names(&self.panels[0]) {
            panel.curves.iter_mut().for_each(|curve| curve.name.clear());
        }
        panel
    }

    /// Corners and sizes of the panels below the title, in user units.
    fn places(&self, size: [u32; 2], layout: &Layout) -> impl Iterator<Item = ([u32; 2], [u32; 2])> {
        let columns = self.columns.max(1);
        let rows = (self.panels.len() as u32).div_ceil(columns).max(1);
        let head = if self.title.is_empty() { 0 } else { layout.border + layout.title / 2 };
        let part = [size[0] / columns, (size[1] - head) / rows];
        (0..).map(move |i| ([i % columns * part[0], head + i / columns * part[1]], part))
    }

    /// Ranges of the axes: all points with a margin, never empty, with equal scales if requested.
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
            // a constant curve is drawn as such, without its round-off
            let floor = (1e-9 * middle.abs()).max(1e-12);
            let half = if half > floor { half * (1.0 + room[axis]) } else { (0.1 * middle.abs()).max(1e-3) };
            [middle, half]
        });
        if self.equal {
            let layout = Layout::of(size, self);
            let sides = [
                f64::from(size[0] - layout.names - layout.labels[0] - layout.border - layout.right),
                f64::from(size[1] - layout.labels[1] - layout.top() - 2 * layout.border),
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

/// Text style with a size in user units.
fn style(size: u32, colour: &'static RGBColor, across: HPos, along: VPos) -> TextStyle<'static> {
    // the size in `plotters` is the height of a line, which is 1.24 times the font size
    let height = 1.24 * f64::from(size * UNIT);
    TextStyle::from((FONT, height).into_font()).color(colour).pos(Pos::new(across, along))
}

/// Label of an axis: as many digits as its range needs, with a true minus sign.
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

/// Shortens a name to fit the legend.
fn short(name: &str) -> String {
    shortened(name, LONGEST_NAME)
}

/// Shortens a name to a number of letters, in its middle.
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

    /// Texts of the model are escaped, the size is in user units, and equal figures have equal bytes.
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

    /// With equal scales a unit has the same length in both directions.
    #[test]
    fn equal_scales_are_equal() {
        let [x, y] = Figure { equal: true, ..figure(vec![[0.0, 0.0], [1.0, 0.01]]) }.ranges(SIZE);
        let Layout { names, labels, border, title, .. } = layout::WIDE;
        let sides = [SIZE[0] - names - labels[0] - 2 * border, SIZE[1] - labels[1] - title - 2 * border].map(f64::from);
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
