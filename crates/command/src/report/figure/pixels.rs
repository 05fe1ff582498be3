//! Figures as pixels: a canvas that draws on a `tiny-skia` pixmap.

use crate::report::figure::canvas::Canvas;
use plotters_backend::BackendColor;
use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, Path, Pixmap, Stroke, Transform};

/// Bytes of a PNG file before its second chunk: signature and header.
const PNG_HEADER: usize = 8 + 25;
/// Text chunk that names the program.
const SIGNATURE: &[u8] = b"tEXtSoftware\0foldwing";

/// Inserts [`SIGNATURE`] after the header of a PNG file.
pub(in crate::report) fn signed(mut png: Vec<u8>) -> Vec<u8> {
    let mut chunk = (SIGNATURE.len() as u32 - 4).to_be_bytes().to_vec(); // without the four letters of the chunk type
    chunk.extend(SIGNATURE);
    chunk.extend(crc32fast::hash(SIGNATURE).to_be_bytes());
    png.splice(PNG_HEADER..PNG_HEADER, chunk);
    png
}

/// A picture under construction.
pub struct Pixels {
    map: Pixmap,
    size: [u32; 2],
    place: Transform,
}

impl Pixels {
    /// Creates a white picture with a size in user units, each divided into `unit` coordinates of `plotters`, with `scale` pixels per
    /// user unit.
    pub fn new(size: [u32; 2], unit: u32, scale: f32) -> Self {
        let [width, height] = size.map(|length| ((length as f32 * scale).round() as u32).max(1));
        let mut map = Pixmap::new(width, height).expect("the size is not zero");
        map.fill(Color::WHITE);
        Self {
            map,
            size: size.map(|length| length * unit),
            place: Transform::from_scale(scale / unit as f32, scale / unit as f32),
        }
    }

    /// Returns the picture as a PNG file that names the program.
    pub fn png(&self) -> Vec<u8> {
        signed(self.map.encode_png().expect("writing to memory does not fail"))
    }
}

impl Canvas for Pixels {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn place(&self) -> Transform {
        self.place
    }

    fn fill(&mut self, path: &Path, colour: BackendColor, place: Transform) {
        self.map.fill_path(path, &paint(colour), FillRule::Winding, place, None);
    }

    fn stroke(&mut self, path: &Path, colour: BackendColor, width: f32) {
        let stroke = Stroke { width, line_join: LineJoin::Round, line_cap: LineCap::Butt, ..Stroke::default() };
        self.map.stroke_path(path, &paint(colour), &stroke, self.place, None);
    }
}

fn paint(BackendColor { alpha, rgb: (red, green, blue) }: BackendColor) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, (255.0 * alpha).round() as u8);
    paint.anti_alias = true;
    paint
}
