//! Figures as PDF: a canvas that writes paths with `pdf-writer`, including text, so that no viewer needs the font.

use crate::report::figure::canvas::{Backend, Canvas};
use crate::report::figure::{FONT_FILE, Figure, FigureError, Sheet, UNIT};
use pdf_writer::types::LineJoinStyle;
use pdf_writer::{Content, Finish, Pdf, Rect, Ref, TextStr};
use plotters::prelude::IntoDrawingArea;
use plotters_backend::BackendColor;
use tiny_skia::{Path, PathSegment, Point, Transform};

/// PDF points per user unit of 1/96 inch.
const POINTS: f32 = 72.0 / 96.0;

impl Figure {
    /// Returns the figure as a PDF file with one page.
    ///
    /// # Errors
    /// `plotters` cannot draw it.
    pub fn pdf(&self, sheet: Sheet) -> Result<Vec<u8>, FigureError> {
        let sheet = self.sheet(sheet);
        let mut page = Page::new(sheet.size);
        self.draw(sheet, &Backend::new(&mut page, FONT_FILE).into_drawing_area())?;
        Ok(page.pdf(&self.title))
    }
}

/// A page under construction.
struct Page {
    content: Content,
    size: [u32; 2],
    place: Transform,
}

impl Page {
    /// Creates a page with a size in user units.
    fn new(size: [u32; 2]) -> Self {
        let scale = POINTS / UNIT as f32;
        let mut content = Content::new();
        content.set_line_join(LineJoinStyle::RoundJoin);
        // y is upwards on a PDF page
        let place = Transform::from_row(scale, 0.0, 0.0, -scale, 0.0, POINTS * size[1] as f32);
        Self { content, size: size.map(|length| length * UNIT), place }
    }

    /// Returns the file; its first object names the producer.
    fn pdf(self, title: &str) -> Vec<u8> {
        let [information, catalog, pages, page, content] = [1, 2, 3, 4, 5].map(Ref::new);
        let mut pdf = Pdf::new();
        pdf.document_info(information).producer(TextStr("foldwing")).title(TextStr(title));
        pdf.catalog(catalog).pages(pages);
        pdf.pages(pages).kids([page]).count(1);
        let [width, height] = self.size.map(|length| POINTS * (length / UNIT) as f32);
        let mut sheet = pdf.page(page);
        sheet.parent(pages).media_box(Rect::new(0.0, 0.0, width, height)).contents(content);
        sheet.resources();
        sheet.finish();
        pdf.stream(content, &self.content.finish());
        pdf.finish()
    }

    /// Writes the segments of a path to the page.
    fn path(&mut self, path: &Path, place: Transform) {
        let at = |point: Point| {
            let mut points = [point];
            place.map_points(&mut points);
            points[0]
        };
        let mut last = Point::zero();
        for segment in path.segments() {
            match segment {
                PathSegment::MoveTo(to) => {
                    last = at(to);
                    self.content.move_to(last.x, last.y);
                }
                PathSegment::LineTo(to) => {
                    last = at(to);
                    self.content.line_to(last.x, last.y);
                }
                PathSegment::QuadTo(control, to) => {
                    let (control, to) = (at(control), at(to));
                    // the same parabola as a cubic curve with two control points
                    let towards = |end: f32, control: f32| end + (control - end) * 2.0 / 3.0;
                    let [first, second] =
                        [last, to].map(|end| Point::from_xy(towards(end.x, control.x), towards(end.y, control.y)));
                    self.content.cubic_to(first.x, first.y, second.x, second.y, to.x, to.y);
                    last = to;
                }
                PathSegment::CubicTo(first, second, to) => {
                    let (first, second) = (at(first), at(second));
                    last = at(to);
                    self.content.cubic_to(first.x, first.y, second.x, second.y, last.x, last.y);
                }
                PathSegment::Close => {
                    self.content.close_path();
                }
            }
        }
    }
}

impl Canvas for Page {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn place(&self) -> Transform {
        self.place
    }

    fn fill(&mut self, path: &Path, colour: BackendColor, place: Transform) {
        let [red, green, blue] = on_white(colour);
        self.content.set_fill_rgb(red, green, blue);
        self.path(path, place);
        self.content.fill_nonzero();
    }

    fn stroke(&mut self, path: &Path, colour: BackendColor, width: f32) {
        let [red, green, blue] = on_white(colour);
        self.content.set_stroke_rgb(red, green, blue).set_line_width(width * POINTS / UNIT as f32);
        self.path(path, self.place);
        self.content.stroke();
    }
}

/// Colour that results from a transparent colour on white, with components from 0 to 1.
fn on_white(BackendColor { alpha, rgb: (red, green, blue) }: BackendColor) -> [f32; 3] {
    [red, green, blue].map(|part| (alpha * f64::from(part) / 255.0 + 1.0 - alpha) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::figure::Curve;

    /// A page has the sheet's size in points and the producer by which it is recognised; equal figures give equal bytes; a title with any
    /// characters is preserved; the vertices of the curve are at the positions of the SVG, with y upwards.
    #[test]
    fn a_page_has_the_figure() {
        let points = vec![[0.0, 1.0], [1.0, 2.0], [2.0, 1.5]];
        let figure =
            Figure { title: "κ (1/m)".to_owned(), curves: vec![Curve::nth(0, "wing", points)], ..Figure::default() };
        let sheet = Sheet { size: [800, 400], scale: 1.0 };
        let pdf = figure.pdf(sheet).unwrap();
        assert_eq!(pdf, figure.pdf(sheet).unwrap());
        let text = String::from_utf8_lossy(&pdf);
        assert!(text.starts_with("%PDF-1.") && text.trim_end().ends_with("%%EOF"));
        assert!(
            text[..1000].contains("/Producer (foldwing)") && text.contains("/MediaBox [0 0 600 300]"),
            "{}",
            &text[..1000]
        );
        let svg = figure.svg(sheet).unwrap();
        let line = svg.split("<polyline").find(|part| part.contains("#0072B2")).expect("the curve is drawn");
        let corners = line.split("points=\"").nth(1).unwrap().split('"').next().unwrap();
        let first: Vec<f32> =
            corners.split_whitespace().next().unwrap().split(',').map(|x| x.parse().unwrap()).collect();
        let (x, y) = (first[0] * 0.075, 300.0 - first[1] * 0.075);
        let near = |line: &str| {
            let numbers: Vec<f32> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
            line.ends_with(" m") && numbers.len() == 2 && (numbers[0] - x).abs() < 0.01 && (numbers[1] - y).abs() < 0.01
        };
        assert!(text.lines().any(near), "no path begins at {x}, {y}");
    }
}
