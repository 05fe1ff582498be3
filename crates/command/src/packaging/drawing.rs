//! Drawing of an undeformed wing: deployed, at its start angles, and at positions between them. The same list of shapes is drawn as SVG
//! on the page and as pixels in `model.png`.

use crate::packaging::palette::{self, Role, ink};
use foldwing_engine::machine::Machine;
use foldwing_engine::machine::pose::{self, Frame};
use foldwing_engine::machine::{Body, LiftingSurface, OneFreedom, Parent, Travel};
use nalgebra::Vector3;
use quick_xml::escape::escape;
use std::fmt::Write;

/// Width of the drawing in user units (pixels at scale 1).
const WIDTH: f64 = 880.0;
/// Maximum height in user units.
const MAXIMUM_HEIGHT: f64 = 580.0;
/// Margin in user units.
const MARGIN: f64 = 24.0;
/// Length of the axes of the root frame in user units.
const AXIS: f64 = 60.0;
/// Number of intervals along a body, sufficient to draw an initially curved body smoothly.
const POINTS: usize = 24;

/// Roles explained in the legend, if they are drawn.
pub const KEYS: [(Role, &str); 7] = [
    (Role::Joint, "joint"),
    (Role::Hinge, "fold axis"),
    (Role::Loop, "closed loop"),
    (Role::Station, "load station"),
    (Role::Mass, "mass"),
    (Role::Gauge, "strain gauge"),
    (Role::Surface, "lifting surface"),
];

/// Point of the drawing in user units, rightwards and downwards, rounded to a tenth: the same for SVG and icon.
pub type Point = [f64; 2];

/// Shape of the drawing; later shapes cover earlier ones.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// Closed outline.
    Outline(Role, Vec<Point>),
    /// Open line.
    Line(Role, Vec<Point>),
    /// Dot with a title shown on hovering; its radius is determined by the role.
    Dot(Role, Point, String),
}

/// Shapes within `0 ≤ x ≤ size[0]`, `0 ≤ y ≤ size[1]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawing {
    /// Width and height in user units.
    pub size: [f64; 2],
    /// Shapes from the back to the front.
    pub shapes: Vec<Shape>,
}

impl Drawing {
    /// Returns whether a shape of a role is drawn.
    pub fn shows(&self, role: Role) -> bool {
        self.shapes.iter().any(|shape| match shape {
            Shape::Outline(found, _) | Shape::Line(found, _) | Shape::Dot(found, ..) => *found == role,
        })
    }
}

/// Frames along every body at equal arc lengths, `POINTS + 1` each, with initial strains only.
///
/// Fold angles and positions of prismatic joints are at the fraction `fraction` of the path from deployed (the latch position, or 0
/// without a latch) to the start; universal, ball and free joints are at their start attitude.
pub fn undeformed(machine: &Machine, fraction: f64) -> Vec<Vec<Frame>> {
    let stand = |joint: &OneFreedom| {
        let deployed = joint.latch.as_ref().map_or(0.0, |latch| latch.angle_rad);
        deployed + fraction * (joint.start_angle_rad - deployed)
    };
    let firsts = pose::first_frames(&machine.bodies, stand);
    machine
        .bodies
        .iter()
        .zip(firsts)
        .map(|(body, first)| {
            (0..=POINTS).map(|i| pose::along(body, &first, body.length_m * i as f64 / POINTS as f64)).collect()
        })
        .collect()
}

/// Axonometric view from the front, left and above: `x` to the right, `z` up, `y` away from the viewer.
fn project(point: &Vector3<f64>) -> Point {
    const AZIMUTH: f64 = 0.5;
    const ELEVATION: f64 = 0.42;
    let (sin_a, cos_a) = AZIMUTH.sin_cos();
    let (sin_e, cos_e) = ELEVATION.sin_cos();
    let right = cos_a * point.x - sin_a * point.y;
    let depth = sin_a * point.x + cos_a * point.y;
    [right, -(cos_e * point.z + sin_e * depth)]
}

/// Contour of a body: outline of a beam; for a rigid body, lines from its frame to its child bodies.
pub(super) fn contour(machine: &Machine, index: usize, wing: &[Vec<Frame>]) -> Vec<Vector3<f64>> {
    let (body, own) = (&machine.bodies[index], &wing[index]);
    if !body.is_rigid() {
        return outline(body, own);
    }
    let carried = machine
        .bodies
        .iter()
        .zip(wing)
        .filter(|(child, _)| matches!(child.joint.parent, Parent::Body { index: parent, .. } if parent == index));
    let mut points = vec![own[0].position_m];
    points.extend(carried.flat_map(|(_, frames)| [frames[0].position_m, own[0].position_m]));
    points
}

/// Closed outline formed by both edges of a body.
pub(super) fn outline(body: &Body, frames: &[Frame]) -> Vec<Vector3<f64>> {
    let place = |i: usize| body.length_m * i as f64 / (frames.len() - 1) as f64;
    let half: Vec<f64> = (0..frames.len()).map(|i| body.section.at(place(i)).half_width_m).collect();
    let edge =
        |side: f64| frames.iter().zip(&half).map(move |(f, half)| f.position_m + f.attitude.column(1) * (side * half));
    edge(1.0).chain(edge(-1.0).rev()).collect()
}

/// Draws the wing. Loops are closed only at the start angles, so a model with loops is drawn only there.
pub fn drawing(machine: &Machine) -> Drawing {
    let looped = !machine.closures.is_empty();
    let deployed = undeformed(machine, if looped { 1.0 } else { 0.0 });
    let folds = !looped && machine.bodies.iter().any(|body| body.joint.kind.one_freedom().is_some());
    let mut wings: Vec<(Role, Vec<Vec<Frame>>)> = Vec::new();
    if folds {
        wings.extend([0.25, 0.5, 0.75].map(|fraction| (Role::Ghost, undeformed(machine, fraction))));
        wings.push((Role::Start, undeformed(machine, 1.0)));
    }
    let (places, hinges) = (places(machine, &deployed), hinges(machine, &deployed));
    wings.push((Role::Deployed, deployed));

    let mut outlines: Vec<(Role, Vec<Vector3<f64>>)> = wings
        .iter()
        .flat_map(|(role, wing)| (0..machine.bodies.len()).map(|index| (*role, contour(machine, index, wing))))
        .collect();
    // shapes drawn behind the deployed wing
    let behind = outlines.len() - machine.bodies.len();
    outlines.splice(behind..behind, planforms(machine, &wings[wings.len() - 1].1));
    // the first body is attached to the root
    let root_m = wings[wings.len() - 1].1[0][0].position_m;
    let points: Vec<Point> = outlines.iter().flat_map(|(_, points)| points).map(project).collect();
    let canvas = Canvas::around(&points, project(&root_m));

    let mut shapes: Vec<Shape> = outlines
        .iter()
        .map(|(role, points)| Shape::Outline(*role, points.iter().map(|point| canvas.place(project(point))).collect()))
        .collect();
    let hinge = |ends: [Vector3<f64>; 2]| ends.map(|end| canvas.place(project(&end))).to_vec();
    shapes.extend(hinges.into_iter().map(|ends| Shape::Line(Role::Hinge, hinge(ends))));
    shapes.extend(places.into_iter().map(|(role, at, title)| Shape::Dot(role, canvas.place(project(&at)), title)));
    shapes.extend(canvas.axes());
    Drawing { size: canvas.size, shapes }
}

/// Edges of the lifting surfaces, leading edge first.
pub(super) fn planforms(machine: &Machine, wing: &[Vec<Frame>]) -> Vec<(Role, Vec<Vector3<f64>>)> {
    let surfaces = machine.air.iter().flat_map(|air| &air.surfaces);
    let planform = |surface: &LiftingSurface| {
        let edge = |fraction: f64| -> Vec<Vector3<f64>> {
            let frame = |position_m| pose::along(&machine.bodies[surface.body], &wing[surface.body][0], position_m);
            let places = surface.positions_m.iter().zip(&surface.chords);
            places
                .map(|(position_m, chord)| {
                    let frame = frame(*position_m);
                    frame.position_m + frame.attitude * chord.at(fraction)
                })
                .collect()
        };
        (Role::Surface, edge(0.0).into_iter().chain(edge(1.0).into_iter().rev()).collect())
    };
    surfaces.map(planform).collect()
}

/// Half the length of the fold axis drawn on a rigid body, which has no section, in m.
const RIGID_HALF_WIDTH_M: f64 = 0.02;

/// Legend for the lines through the joints: axes of revolute joints, prismatic joints, or both.
pub(super) fn axes(machine: &Machine) -> &'static str {
    let has =
        |wanted| machine.bodies.iter().any(|body| body.joint.kind.one_freedom().is_some_and(|own| own.0 == wanted));
    match (has(Travel::Rotation), has(Travel::Translation)) {
        (_, false) => "fold axis",
        (false, true) => "sliding axis",
        (true, true) => "fold or sliding axis",
    }
}

/// Fold and sliding axes, drawn as lines slightly longer than the section width of the joint's body.
pub(super) fn hinges(machine: &Machine, wing: &[Vec<Frame>]) -> Vec<[Vector3<f64>; 2]> {
    let line = |(body, frames): (&Body, &Vec<Frame>)| {
        let (_, joint) = body.joint.kind.one_freedom()?;
        // the axis is invariant under the joint's motion, so it follows from the first frame of the body
        let axis = frames[0].attitude * body.joint.mount.transpose() * joint.axis;
        let half_m = match body.is_rigid() {
            true => RIGID_HALF_WIDTH_M,
            false => body.section.at(0.0).half_width_m.max(0.02 * body.length_m),
        };
        let reach = axis * (1.3 * half_m);
        Some([frames[0].position_m - reach, frames[0].position_m + reach])
    };
    machine.bodies.iter().zip(wing).filter_map(line).collect()
}

/// Stations, masses, gauges and joints on the deployed wing, each with its title.
pub(super) fn places(machine: &Machine, wing: &[Vec<Frame>]) -> Vec<(Role, Vector3<f64>, String)> {
    let mut places = Vec::new();
    for (body, frames) in machine.bodies.iter().zip(wing) {
        let at = |position_m: f64| pose::along(body, &frames[0], position_m).position_m;
        for (i, position_m) in body.station_positions_m.iter().enumerate() {
            places.push((Role::Station, at(*position_m), format!("station {}[{}]", body.name, i + 1)));
        }
        for mass in &body.masses {
            places.push((Role::Mass, at(mass.position_m), format!("mass {}", mass.name)));
        }
        places.push((Role::Joint, frames[0].position_m, format!("joint {}", body.joint.name)));
    }
    for closure in &machine.closures {
        for (end, offset_m) in closure.ends.into_iter().zip(&closure.offsets_m) {
            let at = end.on_body().map_or(*offset_m, |(body, position_m)| {
                let frame = pose::along(&machine.bodies[body], &wing[body][0], position_m);
                frame.position_m + frame.attitude * offset_m
            });
            places.push((Role::Loop, at, format!("loop {}", closure.name)));
        }
    }
    for gauge in &machine.gauges {
        let frame = pose::along(&machine.bodies[gauge.body], &wing[gauge.body][0], gauge.position_m);
        places.push((Role::Gauge, frame.position_m, format!("gauge {}", gauge.name)));
    }
    places
}

/// Transformation from the projection plane in m to the drawing.
struct Canvas {
    /// Position of the projection's origin in user units.
    origin: Point,
    /// User units per metre.
    scale: f64,
    /// Origin of the drawn axes in m, in the projection plane.
    root: Point,
    size: [f64; 2],
}

impl Canvas {
    /// Fits the points to the page, leaving space for the axes at `root`.
    fn around(points: &[Point], root: Point) -> Self {
        let span = |points: &[Point]| -> [[f64; 2]; 2] {
            [0, 1].map(|axis| {
                points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], point| {
                    [least.min(point[axis]), most.max(point[axis])]
                })
            })
        };
        let [[left, right], [top, bottom]] = span(points);
        let border = 2.0 * MARGIN;
        let fit = |room: f64, length: f64| (room - border) / length.max(f64::MIN_POSITIVE);
        // a model of zero size is drawn at the scale of one metre
        let scale = match right - left > 0.0 || bottom - top > 0.0 {
            true => fit(WIDTH, right - left).min(fit(MAXIMUM_HEIGHT, bottom - top)),
            false => WIDTH - border,
        };
        let mut canvas = Self { origin: [0.0; 2], scale, root, size: [0.0; 2] };
        let drawn: Vec<Point> = points
            .iter()
            .map(|point| canvas.place(*point))
            .chain(canvas.axes().iter().flat_map(|shape| match shape {
                Shape::Outline(_, points) | Shape::Line(_, points) => points.clone(),
                Shape::Dot(_, point, _) => vec![*point],
            }))
            .collect();
        let [[left, right], [top, bottom]] = span(&drawn);
        // a narrow wing is centred on the page
        canvas.size = [(right - left + border).max(WIDTH), bottom - top + border].map(f64::ceil);
        canvas.origin = [0.5 * (canvas.size[0] - left - right), MARGIN - top];
        canvas
    }

    fn place(&self, point: Point) -> Point {
        [0, 1].map(|axis| round(self.origin[axis] + self.scale * point[axis]))
    }

    /// Axes of the root frame with their labels.
    fn axes(&self) -> Vec<Shape> {
        let mut shapes = Vec::new();
        let letters: [&[&[Point]]; 3] = [
            &[&[[0.0, 0.0], [6.0, 8.0]], &[[6.0, 0.0], [0.0, 8.0]]],
            &[&[[0.0, 0.0], [3.2, 5.0]], &[[6.0, 0.0], [1.4, 10.0]]],
            &[&[[0.0, 0.0], [6.0, 0.0], [0.0, 8.0], [6.0, 8.0]]],
        ];
        for (axis, strokes) in [Vector3::x(), Vector3::y(), Vector3::z()].iter().zip(letters) {
            let direction = project(axis);
            let [from, end, letter] =
                [0.0, AXIS, AXIS + 12.0].map(|length| [0, 1].map(|i| self.root_place(i) + length * direction[i]));
            shapes.push(Shape::Line(Role::Axis, vec![from.map(round), end.map(round)]));
            for stroke in strokes {
                let point = |p: &Point| [letter[0] - 3.0 + p[0], letter[1] - 4.0 + p[1]].map(round);
                shapes.push(Shape::Line(Role::Axis, stroke.iter().map(point).collect()));
            }
        }
        shapes
    }

    fn root_place(&self, axis: usize) -> f64 {
        self.origin[axis] + self.scale * self.root[axis]
    }
}

/// Rounds to a tenth of a user unit: too small to be visible, but much larger than differences between platforms.
fn round(value: f64) -> f64 {
    (10.0 * value).round() / 10.0
}

/// Returns the drawing as a stand-alone SVG file: white background, fixed colours, and a legend below.
pub fn file(machine: &Machine) -> String {
    const ROW: f64 = 26.0;
    let drawing = drawing(machine);
    let [width, height] = drawing.size;
    let keys: Vec<(Role, &str)> = KEYS.into_iter().filter(|(role, _)| drawing.shows(*role)).collect();
    let mut legend = String::new();
    for (i, (role, name)) in keys.iter().enumerate() {
        let (x, y) = (MARGIN + (i % 5) as f64 * 0.2 * (width - 2.0 * MARGIN), height + ROW * ((i / 5) as f64 + 0.3));
        let class = ink(*role).class;
        let _ = match (ink(*role).radius > 0.0, ink(*role).light.fill.is_some()) {
            (true, _) => write!(legend, "<circle class=\"{class}\" cx=\"{:.1}\" cy=\"{y:.1}\" r=\"5\"/>", x + 8.0),
            (_, true) => write!(legend, "<path class=\"{class}\" d=\"M{x:.1} {:.1}h16v8h-16Z\"/>", y - 4.0),
            _ => write!(legend, "<path class=\"{class}\" d=\"M{x:.1} {y:.1}h16\"/>"),
        };
        let _ = writeln!(legend, "<text x=\"{:.1}\" y=\"{:.1}\">{name}</text>", x + 24.0, y + 5.0);
    }
    let rows = keys.len().div_ceil(5) as f64;
    let total = height + ROW * rows;
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" \
         height=\"{total}\" viewBox=\"0 0 {width} {total}\">\n<!-- drawn by foldwing -->\n<title>{}</title>\n<style>\n{}\
         text{{font:14px sans-serif;fill:#1b2733}}\n</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
         {}{legend}</svg>\n",
        escape(&machine.name),
        palette::print_style(),
        body(&drawing),
    )
}

/// Returns the drawing as a self-contained `<svg>` element with the style classes of the palette.
pub fn svg(drawing: &Drawing) -> String {
    let [width, height] = drawing.size;
    format!(
        "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"The undeformed wing and its axes\">\n{}</svg>\n",
        body(drawing)
    )
}

/// Returns the shapes as SVG elements.
fn body(drawing: &Drawing) -> String {
    let mut svg = String::new();
    let path = |points: &[Point], end: &str| -> String {
        let points: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
        format!("M{}{end}", points.join("L"))
    };
    for shape in &drawing.shapes {
        let _ = match shape {
            Shape::Outline(role, points) => {
                writeln!(svg, "<path class=\"{}\" d=\"{}\"/>", ink(*role).class, path(points, "Z"))
            }
            Shape::Line(role, points) => {
                writeln!(svg, "<path class=\"{}\" d=\"{}\"/>", ink(*role).class, path(points, ""))
            }
            Shape::Dot(role, [x, y], title) => {
                let ink = ink(*role);
                writeln!(
                    svg,
                    "<circle class=\"{}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{}\"><title>{title}</title></circle>",
                    ink.class, ink.radius
                )
            }
        };
    }
    svg
}

#[cfg(test)]
#[path = "drawing_tests.rs"]
pub(crate) mod tests;
