//! Drawing of an undeformed wing as SVG: deployed, at its start angles, and half-way frames between them.

use crate::config::Machine;
use crate::config::machine::{Body, JointKind, Revolute};
use crate::config::pose::{self, Frame};
use nalgebra::Vector3;
use std::fmt::Write;

/// Width of the drawing in user units (pixels at scale 1).
const WIDTH: f64 = 880.0;
/// Free border in user units.
const MARGIN: f64 = 40.0;
/// Points along a body: enough for a smooth curve of an initially curved one.
const POINTS: usize = 24;

/// Frames along every body at equal arc lengths, `POINTS + 1` each, natural strains only.
///
/// Fold angles lie at `fraction` of the way from deployed (latch angle, else 0) to the start angle; universal, ball and
/// free joints stand in their start attitude, which is their mount.
pub fn undeformed(machine: &Machine, fraction: f64) -> Vec<Vec<Frame>> {
    let angle_rad = |joint: &Revolute| {
        let deployed = joint.latch.as_ref().map_or(0.0, |latch| latch.angle_rad);
        deployed + fraction * (joint.start_angle_rad - deployed)
    };
    let firsts = pose::first_frames(machine, angle_rad);
    machine
        .bodies
        .iter()
        .zip(firsts)
        .map(|(body, first)| {
            (0..=POINTS).map(|i| pose::along(body, &first, body.length_m * i as f64 / POINTS as f64)).collect()
        })
        .collect()
}

/// Axonometric view from the front, the left and above: `x` runs to the right, `z` up, `y` into the depth.
fn project(point: &Vector3<f64>) -> [f64; 2] {
    const AZIMUTH: f64 = 0.5;
    const ELEVATION: f64 = 0.42;
    let (sin_a, cos_a) = AZIMUTH.sin_cos();
    let (sin_e, cos_e) = ELEVATION.sin_cos();
    let right = cos_a * point.x - sin_a * point.y;
    let depth = sin_a * point.x + cos_a * point.y;
    [right, -(cos_e * point.z + sin_e * depth)]
}

/// Both edges of a body as one closed outline.
fn outline(body: &Body, frames: &[Frame]) -> Vec<Vector3<f64>> {
    let place = |i: usize| body.length_m * i as f64 / (frames.len() - 1) as f64;
    let half: Vec<f64> = (0..frames.len()).map(|i| body.section.at(place(i)).half_width_m).collect();
    let edge =
        |side: f64| frames.iter().zip(&half).map(move |(f, half)| f.position_m + f.attitude.column(1) * (side * half));
    edge(1.0).chain(edge(-1.0).rev()).collect()
}

/// The wing as a self-contained `<svg>` element. Closed loops close at the start angles only, so nothing else is drawn of
/// a machine that has them.
pub fn svg(machine: &Machine) -> String {
    let looped = !machine.closures.is_empty();
    let deployed = undeformed(machine, if looped { 1.0 } else { 0.0 });
    let folds = !looped && machine.bodies.iter().any(|body| matches!(body.joint.kind, JointKind::Revolute(_)));
    let ghosts: Vec<_> = if folds { [0.25, 0.5, 0.75].map(|f| undeformed(machine, f)).into() } else { vec![] };
    let start = folds.then(|| undeformed(machine, 1.0));

    let everything = std::iter::once(&deployed).chain(&ghosts).chain(&start);
    let points: Vec<[f64; 2]> = everything
        .flat_map(|wing| machine.bodies.iter().zip(wing))
        .flat_map(|(body, frames)| outline(body, frames))
        .map(|point| project(&point))
        .collect();
    let canvas = Canvas::around(&points);

    let mut svg = String::new();
    let height = canvas.height;
    let _ = writeln!(svg, "<svg viewBox=\"0 0 {WIDTH} {height:.0}\" role=\"img\" aria-label=\"The undeformed wing\">");
    let shapes = ghosts.iter().map(|wing| ("ghost", wing)).chain(start.iter().map(|wing| ("start", wing)));
    for (class, wing) in shapes.chain([("deployed", &deployed)]) {
        for (body, frames) in machine.bodies.iter().zip(wing) {
            let _ = writeln!(svg, "<path class=\"{class}\" d=\"{}\"/>", canvas.closed(&outline(body, frames)));
        }
    }
    mark(&mut svg, &canvas, machine, &deployed);
    canvas.axes(&mut svg, &deployed[0][0].position_m); // the first body hangs on the root
    svg.push_str("</svg>\n");
    svg
}

/// Stations, masses, gauges and joints on the deployed wing, each with a title that viewers show on hovering.
fn mark(svg: &mut String, canvas: &Canvas, machine: &Machine, wing: &[Vec<Frame>]) {
    let mut dot = |class: &str, radius: f64, frame: &Frame, title: &str| {
        let [x, y] = canvas.place(&frame.position_m);
        let _ = writeln!(
            svg,
            "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\"><title>{title}</title></circle>"
        );
    };
    for (body, frames) in machine.bodies.iter().zip(wing) {
        for (i, position) in body.station_positions_m.iter().enumerate() {
            dot(
                "station",
                3.0,
                &pose::along(body, &frames[0], *position),
                &format!("station {}[{}]", body.name, i + 1),
            );
        }
        for mass in &body.masses {
            dot("mass", 6.0, &pose::along(body, &frames[0], mass.position_m), &format!("mass {}", mass.name));
        }
        dot("joint", 4.5, &frames[0], &format!("joint {}", body.joint.name));
    }
    for closure in &machine.closures {
        for (side, (body, position_m)) in closure.places.into_iter().enumerate() {
            let frame = pose::along(&machine.bodies[body], &wing[body][0], position_m);
            let position_m = frame.position_m + frame.attitude * closure.offsets_m[side];
            dot("loop", 4.0, &Frame { position_m, ..frame }, &format!("loop {}", closure.name));
        }
    }
    for gauge in &machine.gauges {
        let frame = pose::along(&machine.bodies[gauge.body], &wing[gauge.body][0], gauge.position_m);
        dot("gauge", 3.5, &frame, &format!("gauge {}", gauge.name));
    }
}

/// From metres in the projection plane to the drawing.
struct Canvas {
    origin: [f64; 2],
    scale: f64,
    height: f64,
}

impl Canvas {
    fn around(points: &[[f64; 2]]) -> Self {
        let bound = |axis: usize, pick: fn(f64, f64) -> f64, start: f64| {
            points.iter().map(|point| point[axis]).fold(start, pick)
        };
        let [left, right] = [bound(0, f64::min, f64::INFINITY), bound(0, f64::max, f64::NEG_INFINITY)];
        let [top, bottom] = [bound(1, f64::min, f64::INFINITY), bound(1, f64::max, f64::NEG_INFINITY)];
        let scale = (WIDTH - 2.0 * MARGIN) / (right - left).max(0.6 * (bottom - top)).max(f64::MIN_POSITIVE);
        let height = (bottom - top) * scale + 2.0 * MARGIN;
        Self { origin: [MARGIN - left * scale, MARGIN - top * scale], scale, height }
    }

    fn place(&self, point: &Vector3<f64>) -> [f64; 2] {
        let [x, y] = project(point);
        [self.origin[0] + self.scale * x, self.origin[1] + self.scale * y]
    }

    fn closed(&self, points: &[Vector3<f64>]) -> String {
        let mut path = String::new();
        for (i, point) in points.iter().enumerate() {
            let [x, y] = self.place(point);
            let _ = write!(path, "{}{x:.1} {y:.1} ", if i == 0 { "M" } else { "L" });
        }
        path + "Z"
    }

    /// Directions of the root frame `G`, drawn at a point of the wing, 60 user units long.
    fn axes(&self, svg: &mut String, at: &Vector3<f64>) {
        let [x0, y0] = self.place(at);
        for (axis, name) in [(Vector3::x(), "x"), (Vector3::y(), "y"), (Vector3::z(), "z")] {
            let [x, y] = self.place(&(at + axis * (60.0 / self.scale)));
            let _ = writeln!(
                svg,
                "<path class=\"axis\" d=\"M{x0:.1} {y0:.1} L{x:.1} {y:.1}\"/>\
                 <text x=\"{x:.1}\" y=\"{y:.1}\" dx=\"4\" dy=\"4\">{name}</text>"
            );
        }
    }
}

#[cfg(test)]
#[path = "drawing_tests.rs"]
pub(crate) mod tests;
