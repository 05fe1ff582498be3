//! Colours of a video: those of the page's light theme and of its colour scales.

/// Colour with red, green and blue components from 0 to 1.
pub(super) type Rgb = [f32; 3];

const fn hex(colour: u32) -> Rgb {
    [(colour >> 16 & 255) as f32 / 255.0, (colour >> 8 & 255) as f32 / 255.0, (colour & 255) as f32 / 255.0]
}

pub(super) const BACKGROUND: Rgb = hex(0xffffff);
pub(super) const TEXT: Rgb = hex(0x1b2733);
pub(super) const FAINT: Rgb = hex(0x5d6b79);
pub(super) const GRID: Rgb = hex(0xd3dbe3);
pub(super) const EDGE: Rgb = hex(0x33424f);
pub(super) const SURFACE: Rgb = hex(0xb9d3cd);
pub(super) const BODY: Rgb = hex(0xb7c2cc);
pub(super) const ACCENT: Rgb = hex(0x0b62a4);
pub(super) const JOINT: Rgb = hex(0x5b6773);
pub(super) const LATCH_CLOSED: Rgb = hex(0x2e9e5b);
pub(super) const LATCH_OPEN: Rgb = hex(0x8b98a5);
pub(super) const MASS: Rgb = hex(0x9a7b4f);
pub(super) const GRAVITY: Rgb = hex(0x2fae62);
pub(super) const WIND: Rgb = hex(0x19a3e6);
/// Colours of the axes x, y and z of the root frame.
pub(super) const AXES: [Rgb; 3] = [[0.84, 0.24, 0.18], [0.16, 0.6, 0.24], [0.16, 0.4, 0.85]];

/// Colour scale given at five equidistant values.
pub(super) type Scale = [[u8; 3]; 5];

/// Colour scale of strain: negative blue, positive red.
pub(super) const STRAIN: Scale = [[5, 48, 97], [67, 147, 195], [240, 240, 240], [244, 135, 75], [127, 30, 8]];
/// Colour scale of circulation: negative violet, positive orange.
pub(super) const CIRCULATION: Scale =
    [[94, 60, 153], [178, 171, 210], [236, 236, 240], [253, 190, 110], [222, 104, 20]];

/// Colour at the relative position `share`, from 0 to 1, on a scale.
pub(super) fn tint(scale: &Scale, share: f64) -> Rgb {
    let along = if share.is_finite() { 4.0 * share.clamp(0.0, 1.0) } else { 2.0 };
    let before = (along.floor() as usize).min(3);
    let rest = (along - before as f64) as f32;
    std::array::from_fn(|i| {
        let [a, b] = [before, before + 1].map(|at| f32::from(scale[at][i]));
        (a + rest * (b - a)) / 255.0
    })
}

/// Relative position of a value on a scale from `-most` to `most`.
pub(super) fn share(value: f64, most: f64) -> f64 {
    0.5 + 0.5 * value / most
}
