//! An image as triangles, lines and labels in space with lighting, and its rendering by the rasteriser.

use super::camera::{Camera, Seen};
use super::colours::Rgb;
use super::raster::{Corner, Ink, Raster};
use crate::report::film::run::Vector;

/// Direction from the ground to the sun.
const SUN: [f64; 3] = [0.5, -0.9, 2.2];
/// Intensity of the sun and of the sky, and the fraction of sky light that comes from below, as on the page.
const SUNLIGHT: f64 = 1.5;
const SKYLIGHT: f64 = 1.75;
const FROM_BELOW: f64 = 0.75;
/// Opacity of the shadow on the ground.
const SHADOW: f32 = 0.22;

/// Vertex of a face: position, surface normal, colour.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vertex {
    pub at: Vector,
    pub normal: Vector,
    pub rgb: Rgb,
}

/// Lit face: the normals of closed surfaces point outwards, sheets have two sides.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face {
    pub corners: [Vertex; 3],
    pub sheet: bool,
}

/// Line with a width in units of the page, which are scaled to the image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub ends: [Vector; 2],
    pub rgb: Rgb,
    pub opacity: f32,
    pub width: f64,
}

/// Text that is centred at a position.
#[derive(Debug, Clone)]
pub(super) struct Label {
    pub at: Vector,
    pub text: String,
    pub height: f32,
    pub rgb: Rgb,
    /// Whether it is drawn on top of faces in front of it.
    pub on_top: bool,
}

/// All contents of an image.
#[derive(Debug, Default)]
pub(super) struct Drawing {
    /// Faces that cast shadows.
    pub faces: Vec<Face>,
    /// Faces that do not.
    pub arrows: Vec<Face>,
    /// Distance in m towards the eye by which lines on faces are moved, so that they are visible.
    pub lifted_m: f64,
    pub lines: Vec<Line>,
    /// Lines on the ground.
    pub grid: Vec<Line>,
    /// Panels of the wake: corners in order around each, and colour.
    pub wake: Vec<([Vector; 4], Rgb)>,
    /// Opacity of the wake.
    pub wake_opacity: f32,
    /// Height of the ground in m; `None` if there is no ground.
    pub floor_m: Option<f64>,
    pub labels: Vec<Label>,
}

impl Drawing {
    /// Adds a flat face with four corners given in order around it.
    pub fn sheet(&mut self, corners: [Vector; 4], rgb: Rgb) {
        let normal = (corners[2] - corners[0]).cross(&(corners[3] - corners[1]));
        let normal = normal.try_normalize(0.0).unwrap_or_else(Vector::z);
        let vertices = corners.map(|at| Vertex { at, normal, rgb });
        for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
            self.faces.push(Face { corners: [vertices[a], vertices[b], vertices[c]], sheet: true });
        }
    }

    /// Draws all contents; `unit` is the number of pixels per unit of width.
    pub fn draw(&self, camera: &Camera, unit: f64, raster: &mut Raster) {
        let sun = Vector::from(SUN).normalize();
        for line in &self.grid {
            draw_line(line, camera, (0.0, unit), raster);
        }
        for Face { corners, sheet } in self.faces.iter().chain(&self.arrows) {
            let lit = corners.map(|vertex| (vertex.at, lit(&vertex, *sheet, camera, &sun)));
            draw_face(&lit, camera, Ink::Solid, raster);
        }
        if let Some(floor_m) = self.floor_m {
            let fallen = |at: Vector| at - sun * ((at.z - floor_m) / sun.z);
            for Face { corners, .. } in &self.faces {
                let dark = corners.map(|vertex| (fallen(vertex.at), [0.0; 3]));
                draw_face(&dark, camera, Ink::Shadow(SHADOW), raster);
            }
        }
        for line in &self.lines {
            draw_line(line, camera, (self.lifted_m, unit), raster);
        }
        for (corners, rgb) in &self.wake {
            for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                let face = [a, b, c].map(|corner| (corners[corner], *rgb));
                draw_face(&face, camera, Ink::Glass(self.wake_opacity), raster);
            }
        }
    }
}

/// Colour of a vertex with lighting.
fn lit(vertex: &Vertex, sheet: bool, camera: &Camera, sun: &Vector) -> Rgb {
    let away = (camera.eye() - vertex.at).dot(&vertex.normal) < 0.0;
    let normal = if sheet && away { -vertex.normal } else { vertex.normal };
    let above = 0.5 + 0.5 * normal.z;
    let light = SUNLIGHT * normal.dot(sun).max(0.0) + SKYLIGHT * (FROM_BELOW + (1.0 - FROM_BELOW) * above);
    let light = (light / std::f64::consts::PI) as f32;
    vertex.rgb.map(|part| (part * light).clamp(0.0, 1.0))
}

fn corner(seen: Seen, rgb: Rgb) -> Corner {
    Corner { x: seen.x, y: seen.y, near: seen.near, rgb }
}

/// Draws the part of a face that is in front of the eye.
fn draw_face(corners: &[(Vector, Rgb); 3], camera: &Camera, ink: Ink, raster: &mut Raster) {
    let nearest_m = camera.nearest_m();
    let depths = corners.map(|(at, _)| camera.depth_m(&at));
    if depths.iter().all(|depth_m| *depth_m >= nearest_m) {
        return raster.triangle(corners.map(|(at, rgb)| corner(camera.seen(&at), rgb)), ink);
    }
    let mut kept = Vec::with_capacity(4);
    for (i, next) in [(0, 1), (1, 2), (2, 0)] {
        let (from, to) = (depths[i], depths[next]);
        if from >= nearest_m {
            kept.push(corners[i]);
        }
        if (from >= nearest_m) != (to >= nearest_m) {
            let share = (nearest_m - from) / (to - from);
            let ((a, a_rgb), (b, b_rgb)) = (corners[i], corners[next]);
            let rgb = std::array::from_fn(|c| a_rgb[c] + share as f32 * (b_rgb[c] - a_rgb[c]));
            kept.push((a + share * (b - a), rgb));
        }
    }
    let kept: Vec<Corner> = kept.into_iter().map(|(at, rgb)| corner(camera.seen(&at), rgb)).collect();
    for i in 1..kept.len().saturating_sub(1) {
        raster.triangle([kept[0], kept[i], kept[i + 1]], ink);
    }
}

/// Draws the part of a line that is in front of the eye.
fn draw_line(line: &Line, camera: &Camera, (lifted_m, unit): (f64, f64), raster: &mut Raster) {
    let [a, b] = line.ends;
    let (from, to) = (camera.depth_m(&a), camera.depth_m(&b));
    let nearest_m = camera.nearest_m() + lifted_m;
    if (from < nearest_m && to < nearest_m) || !from.is_finite() || !to.is_finite() {
        return;
    }
    let cut = |share: f64| a + share * (b - a);
    let at_nearest = || (nearest_m - from) / (to - from);
    let [a, b] = match (from < nearest_m, to < nearest_m) {
        (false, false) => [a, b],
        (true, _) => [cut(at_nearest()), b],
        (false, true) => [a, cut(at_nearest())],
    };
    let ends = [a, b].map(|at| {
        let seen = camera.seen(&at);
        Corner { near: 1.0 / (1.0 / seen.near - lifted_m), ..corner(seen, line.rgb) }
    });
    let ink = if line.opacity < 1.0 { Ink::Glass(line.opacity) } else { Ink::Solid };
    raster.line(ends, line.width * unit, ink);
}
