//! `model.png`: the drawing as pixels, used as icon of the FMU.

use crate::packaging::drawing::{Drawing, Point, Shape, drawing};
use crate::packaging::palette::{Colour, Ink, PAPER, ink};
use foldwing_engine::machine::Machine;
use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, StrokeDash, Transform};

/// Width and height in pixels.
pub const SIZE: [u32; 2] = [800, 600];

/// Factor for the width of lines and dots, because importers show the icon at a fraction of its size.
const BOLD: f64 = 1.6;

/// Returns the icon as a PNG file with white background. Equal models give equal bytes.
pub fn png(machine: &Machine) -> Vec<u8> {
    let drawing = drawing(machine);
    let mut pixels = Pixmap::new(SIZE[0], SIZE[1]).expect("the size is not zero");
    let [red, green, blue] = PAPER[0];
    pixels.fill(Color::from_rgba8(red, green, blue, 255));
    let place = placement(&drawing);
    for shape in &drawing.shapes {
        paint(&mut pixels, shape, place);
    }
    pixels.encode_png().expect("writing to memory does not fail")
}

/// Transformation that centres the drawing, as large as possible.
fn placement(drawing: &Drawing) -> Transform {
    let [width, height] = drawing.size;
    let size = SIZE.map(f64::from);
    let scale = (size[0] / width).min(size[1] / height);
    let shift = [0.5 * (size[0] - scale * width), 0.5 * (size[1] - scale * height)].map(|value| value as f32);
    Transform::from_row(scale as f32, 0.0, 0.0, scale as f32, shift[0], shift[1])
}

fn paint(pixels: &mut Pixmap, shape: &Shape, place: Transform) {
    let (role, path) = match shape {
        Shape::Outline(role, points) => (role, line(points, true)),
        Shape::Line(role, points) => (role, line(points, false)),
        Shape::Dot(role, [x, y], _) => {
            (role, PathBuilder::from_circle(*x as f32, *y as f32, (BOLD * ink(*role).radius) as f32))
        }
    };
    // a path of zero size draws nothing, as on the page
    let Some(path) = path else { return };
    let Ink { light, opacity, width, dash, .. } = ink(*role);
    if let Some(colour) = light.fill {
        pixels.fill_path(&path, &colour_of(colour, *opacity), FillRule::Winding, place, None);
    }
    if let Some(colour) = light.line {
        let stroke = Stroke {
            width: (BOLD * width) as f32,
            line_cap: LineCap::Butt,
            line_join: LineJoin::Round,
            dash: dash.and_then(|lengths| StrokeDash::new(lengths.map(|length| (BOLD * length) as f32).into(), 0.0)),
            ..Stroke::default()
        };
        pixels.stroke_path(&path, &colour_of(colour, 1.0), &stroke, place, None);
    }
}

fn line(points: &[Point], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (i, [x, y]) in points.iter().map(|point| point.map(|value| value as f32)).enumerate() {
        if i == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
    }
    if closed {
        path.close();
    }
    path.finish()
}

fn colour_of([red, green, blue]: Colour, opacity: f64) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, (255.0 * opacity).round() as u8);
    paint.anti_alias = true;
    paint
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packaging::drawing::tests::two_body_machine;
    use crate::packaging::palette::Role;

    /// The decoded icon has its nominal size and the colours of wing, joints and start angles at their positions on the page; drawing it
    /// twice gives the same bytes.
    #[test]
    fn icon_shows_what_the_page_shows() {
        let machine = two_body_machine();
        let file = png(&machine);
        assert_eq!(file, png(&machine));
        assert!(file.len() < 60_000, "{} bytes", file.len());
        let image = Pixmap::decode_png(&file).unwrap();
        assert_eq!([image.width(), image.height()], SIZE);

        let drawing = drawing(&machine);
        let place = placement(&drawing);
        let pixel = |[x, y]: Point| {
            let at = |value: f64, shift: f32| (value * f64::from(place.sx) + f64::from(shift)) as u32;
            let found = image.pixel(at(x, place.tx), at(y, place.ty)).unwrap();
            [found.red(), found.green(), found.blue()]
        };
        let joints: Vec<_> =
            drawing.shapes.iter().filter(|shape| matches!(shape, Shape::Dot(Role::Joint, ..))).collect();
        assert_eq!(joints.len(), 2);
        for shape in joints {
            let Shape::Dot(_, at, title) = shape else { unreachable!("filtered above") };
            // nothing covers the last joint; the first one is covered by the axes at their origin
            if title.ends_with("fold") {
                assert_eq!(pixel(*at), ink(Role::Joint).light.fill.unwrap(), "{title}");
            }
        }
        assert_eq!(pixel([1.0, 1.0]), PAPER[0], "the border is free");
    }
}
