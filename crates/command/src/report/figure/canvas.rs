//! Backend of `plotters` that converts all elements, including text, to smooth paths on a canvas of pixels or of a PDF
//! page.

use ab_glyph::{Font, FontRef, OutlineCurve, Point};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontTransform,
};
use std::convert::Infallible;
use tiny_skia::{Path, PathBuilder, Rect, Transform};

/// Height of lower-case letters of the font, in em.
const X_HEIGHT: f32 = 0.547;

/// Target of paths.
pub trait Canvas {
    /// Width and height in the units of `plotters`.
    fn size(&self) -> [u32; 2];

    /// Transformation from the units of `plotters` to those of the canvas.
    fn place(&self) -> Transform;

    /// Fills a path after transformation to the canvas by `place`.
    fn fill(&mut self, path: &Path, colour: BackendColor, place: Transform);

    /// Draws a path in the units of `plotters`, with round joins.
    fn stroke(&mut self, path: &Path, colour: BackendColor, width: f32);
}

/// Outlines of a line of text in em, from the left end of its baseline, with y upwards; and its width.
pub(in crate::report) fn outline(font: &FontRef<'_>, text: &str) -> (Option<Path>, f32) {
    let em = 1.0 / font.units_per_em().unwrap_or(1.0);
    let mut path = PathBuilder::new();
    let (mut along, mut before) = (0.0, None);
    for glyph in text.chars().map(|letter| font.glyph_id(letter)) {
        along += before.map_or(0.0, |before| font.kern_unscaled(before, glyph));
        let curves = font.outline(glyph).map_or_else(Vec::new, |outline| outline.curves);
        let point = |p: Point| (em * (along + p.x), em * p.y);
        append(&mut path, &curves, point);
        along += font.h_advance_unscaled(glyph);
        before = Some(glyph);
    }
    (path.finish(), em * along)
}

/// Appends the curves of a glyph; a new contour starts at a curve that does not continue the previous one.
fn append(path: &mut PathBuilder, curves: &[OutlineCurve], place: impl Fn(Point) -> (f32, f32)) {
    let mut pen: Option<Point> = None;
    for curve in curves {
        let (OutlineCurve::Line(from, to) | OutlineCurve::Quad(from, _, to) | OutlineCurve::Cubic(from, _, _, to)) =
            curve;
        if pen != Some(*from) {
            let (x, y) = place(*from);
            path.move_to(x, y);
        }
        let (x, y) = place(*to);
        match curve {
            OutlineCurve::Line(..) => path.line_to(x, y),
            OutlineCurve::Quad(_, control, _) => {
                let (cx, cy) = place(*control);
                path.quad_to(cx, cy, x, y);
            }
            OutlineCurve::Cubic(_, first, second, _) => {
                let ((ax, ay), (bx, by)) = (place(*first), place(*second));
                path.cubic_to(ax, ay, bx, by, x, y);
            }
        }
        pen = Some(*to);
    }
}

/// Backend of `plotters` that draws everything as paths.
pub struct Backend<'a, C> {
    canvas: &'a mut C,
    font: FontRef<'static>,
}

impl<'a, C: Canvas> Backend<'a, C> {
    /// Creates a backend on a canvas, with the font of its text.
    pub fn new(canvas: &'a mut C, font: &'static [u8]) -> Self {
        Self { canvas, font: FontRef::try_from_slice(font).expect("the font beside this file is valid") }
    }

    fn fill(&mut self, path: Option<Path>, colour: BackendColor, within: Transform) {
        // a path of zero size draws nothing
        if let Some(path) = path {
            self.canvas.fill(&path, colour, self.canvas.place().pre_concat(within));
        }
    }

    fn stroke<S: BackendStyle>(&mut self, path: Option<Path>, style: &S) {
        if let Some(path) = path {
            self.canvas.stroke(&path, style.color(), style.stroke_width() as f32);
        }
    }
}

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

impl<C: Canvas> DrawingBackend for Backend<'_, C> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.canvas.size().into()
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Drawn {
        let path = Rect::from_xywh(x as f32, y as f32, 1.0, 1.0).map(PathBuilder::from_rect);
        self.fill(path, colour, Transform::identity());
        Ok(())
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Drawn {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S, fill: bool) -> Drawn {
        let corners = [from, (to.0, from.1), to, (from.0, to.1)];
        if fill { self.fill_polygon(corners, style) } else { self.draw_path(corners.into_iter().chain([from]), style) }
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, path: I, style: &S) -> Drawn {
        self.stroke(polyline(path, false), style);
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(&mut self, (x, y): BackendCoord, radius: u32, style: &S, fill: bool) -> Drawn {
        let path = PathBuilder::from_circle(x as f32, y as f32, radius as f32);
        if fill {
            self.fill(path, style.color(), Transform::identity())
        } else {
            self.stroke(path, style)
        }
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, corners: I, style: &S) -> Drawn {
        self.fill(polyline(corners, true), style.color(), Transform::identity());
        Ok(())
    }

    /// Draws text at the position that the SVG uses: the anchor is on the baseline, shifted by a fraction of the font
    /// size.
    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, (x, y): BackendCoord) -> Drawn {
        let size = style.size() as f32 / 1.24;
        let (path, width) = outline(&self.font, text);
        let left = match style.anchor().h_pos {
            HPos::Left => 0.0,
            HPos::Center => -0.5 * width,
            HPos::Right => -width,
        };
        let down = match style.anchor().v_pos {
            VPos::Top => 0.76,
            VPos::Center => 0.5 * X_HEIGHT,
            VPos::Bottom => -0.5 * X_HEIGHT,
        };
        let turn = match style.transform() {
            FontTransform::None => 0.0,
            FontTransform::Rotate90 => 90.0,
            FontTransform::Rotate180 => 180.0,
            FontTransform::Rotate270 => 270.0,
        };
        let place = Transform::from_translate(x as f32, y as f32).pre_concat(Transform::from_rotate(turn));
        let place = place.pre_scale(size, size).pre_translate(left, down).pre_scale(1.0, -1.0);
        self.fill(path, style.color(), place);
        Ok(())
    }
}

fn polyline(points: impl IntoIterator<Item = BackendCoord>, closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (x, y) in points {
        if path.is_empty() { path.move_to(x as f32, y as f32) } else { path.line_to(x as f32, y as f32) }
    }
    if closed {
        path.close();
    }
    path.finish()
}

#[cfg(test)]
#[path = "canvas_tests.rs"]
mod tests;
