//! Text in images: outlines of the font of the figures, filled with anti-aliased edges.

use super::colours::Rgb;
use super::raster::Raster;
use crate::report::figure::{FONT_FILE, outline};
use ab_glyph::FontRef;
use tiny_skia::{FillRule, Mask, Transform};

/// The font.
pub(super) struct Letters {
    font: FontRef<'static>,
}

/// Part of a text that is placed at its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    /// Left end of the baseline.
    Left,
    /// Middle of the baseline.
    Middle,
    /// Right end of the baseline.
    Right,
    /// Middle of the letters.
    Centre,
}

/// Ratio of the height of lower-case letters to the font size.
const X_HEIGHT: f64 = 0.547;

impl Letters {
    /// Loads the font of the figures.
    pub fn new() -> Self {
        Self { font: FontRef::try_from_slice(FONT_FILE).expect("the font of the figures is valid") }
    }

    /// Draws a text of a size at a position in pixels; `near` is its inverse distance from the eye.
    pub fn draw(
        &self,
        text: &str,
        [x, y]: [f64; 2],
        (size, anchor): (f64, Anchor),
        (near, rgb): (f64, Rgb),
        raster: &mut Raster,
    ) {
        let (path, width) = outline(&self.font, text);
        let Some(path) = path else { return };
        let width = f64::from(width) * size;
        let (left, base) = match anchor {
            Anchor::Left => (x, y),
            Anchor::Middle => (x - 0.5 * width, y),
            Anchor::Right => (x - width, y),
            Anchor::Centre => (x - 0.5 * width, y + 0.5 * X_HEIGHT * size),
        };
        if !(left.abs() < 1e5 && base.abs() < 1e5) {
            return;
        }
        let (column, row) = ((left - 1.0).floor(), (base - 1.1 * size).floor());
        let (wide, high) = ((width + 0.2 * size).ceil() as u32 + 3, (1.5 * size).ceil() as u32 + 3);
        let Some(mut mask) = Mask::new(wide, high) else { return };
        let place = Transform::from_translate((left - column) as f32, (base - row) as f32);
        mask.fill_path(&path, FillRule::Winding, true, place.pre_scale(size as f32, -size as f32));
        for (i, coverage) in mask.data().iter().enumerate().filter(|(_, coverage)| **coverage > 0) {
            let (right, down) = (i as i64 % i64::from(wide), i as i64 / i64::from(wide));
            let at = [column as i64 + right, row as i64 + down];
            raster.dot(at, near, rgb, f32::from(*coverage) / 255.0);
        }
    }
}
