//! A backend of `plotters` that draws smooth lines and outlines of glyphs on a `tiny-skia` pixmap.

use ab_glyph::{Font, FontRef, OutlineCurve, Point};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontTransform,
};
use std::convert::Infallible;
use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, Transform};

/// Height of small letters of the font, in em.
const X_HEIGHT: f32 = 0.547;

/// Bytes of a PNG file before its second chunk: signature and header.
const PNG_HEADER: usize = 8 + 25;
/// Text chunk with the name of the program.
const SIGNATURE: &[u8] = b"tEXtSoftware\0foldwing";

/// A PNG file with [`SIGNATURE`] behind its header.
fn signed(mut png: Vec<u8>) -> Vec<u8> {
    let mut chunk = (SIGNATURE.len() as u32 - 4).to_be_bytes().to_vec(); // without the four letters of the kind
    chunk.extend(SIGNATURE);
    chunk.extend(crc32fast::hash(SIGNATURE).to_be_bytes());
    png.splice(PNG_HEADER..PNG_HEADER, chunk);
    png
}

/// A picture in the making.
pub struct Pixels {
    map: Pixmap,
    size: [u32; 2],
    place: Transform,
    font: FontRef<'static>,
}

impl Pixels {
    /// A white picture of a size in user units, which `plotters` sees in `unit` parts each, of `scale` pixels per user unit,
    /// with its font.
    pub fn new(size: [u32; 2], unit: u32, scale: f32, font: &'static [u8]) -> Self {
        let [width, height] = size.map(|length| ((length as f32 * scale).round() as u32).max(1));
        let mut map = Pixmap::new(width, height).expect("the size is not zero");
        map.fill(Color::WHITE);
        Self {
            map,
            size: size.map(|length| length * unit),
            place: Transform::from_scale(scale / unit as f32, scale / unit as f32),
            font: FontRef::try_from_slice(font).expect("the font beside this file is valid"),
        }
    }

    /// What `plotters` draws on.
    pub fn backend(&mut self) -> Backend<'_> {
        Backend { pixels: self }
    }

    /// The picture as a PNG file that says by whom it was drawn.
    pub fn png(&self) -> Vec<u8> {
        signed(self.map.encode_png().expect("writing to memory does not fail"))
    }

    fn fill(&mut self, path: Option<Path>, colour: BackendColor, place: Transform) {
        // a path of no extent leaves no mark
        if let Some(path) = path {
            self.map.fill_path(&path, &paint(colour), FillRule::Winding, place, None);
        }
    }

    fn stroke<S: BackendStyle>(&mut self, path: Option<Path>, style: &S) {
        let stroke = Stroke {
            width: style.stroke_width() as f32,
            line_join: LineJoin::Round,
            line_cap: LineCap::Butt,
            ..Stroke::default()
        };
        if let Some(path) = path {
            self.map.stroke_path(&path, &paint(style.color()), &stroke, self.place, None);
        }
    }

    /// Outlines of a line of text in em, from the left end of its base line, upward; and its width.
    fn outline(&self, text: &str) -> (Option<Path>, f32) {
        let em = 1.0 / self.font.units_per_em().unwrap_or(1.0);
        let mut path = PathBuilder::new();
        let (mut along, mut before) = (0.0, None);
        for glyph in text.chars().map(|letter| self.font.glyph_id(letter)) {
            along += before.map_or(0.0, |before| self.font.kern_unscaled(before, glyph));
            let curves = self.font.outline(glyph).map_or_else(Vec::new, |outline| outline.curves);
            let point = |p: Point| (em * (along + p.x), em * p.y);
            append(&mut path, &curves, point);
            along += self.font.h_advance_unscaled(glyph);
            before = Some(glyph);
        }
        (path.finish(), em * along)
    }
}

/// Appends the curves of a glyph; a contour begins where a curve does not go on from the one before.
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

/// What `plotters` draws on.
pub struct Backend<'a> {
    pixels: &'a mut Pixels,
}

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

impl DrawingBackend for Backend<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.pixels.size.into()
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Drawn {
        let path = Rect::from_xywh(x as f32, y as f32, 1.0, 1.0).map(PathBuilder::from_rect);
        self.pixels.fill(path, colour, self.pixels.place);
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
        self.pixels.stroke(polyline(path, false), style);
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(&mut self, (x, y): BackendCoord, radius: u32, style: &S, fill: bool) -> Drawn {
        let path = PathBuilder::from_circle(x as f32, y as f32, radius as f32);
        if fill {
            self.pixels.fill(path, style.color(), self.pixels.place)
        } else {
            self.pixels.stroke(path, style)
        }
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(&mut self, corners: I, style: &S) -> Drawn {
        self.pixels.fill(polyline(corners, true), style.color(), self.pixels.place);
        Ok(())
    }

    /// As the SVG places it: the anchor lies on the base line moved by a part of the size.
    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, (x, y): BackendCoord) -> Drawn {
        let size = style.size() as f32 / 1.24;
        let (path, width) = self.pixels.outline(text);
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
        let place = self.pixels.place.pre_translate(x as f32, y as f32).pre_concat(Transform::from_rotate(turn));
        let place = place.pre_scale(size, size).pre_translate(left, down).pre_scale(1.0, -1.0);
        self.pixels.fill(path, style.color(), place);
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

fn paint(BackendColor { alpha, rgb: (red, green, blue) }: BackendColor) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, (255.0 * alpha).round() as u8);
    paint.anti_alias = true;
    paint
}
