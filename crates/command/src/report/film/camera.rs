//! Cameras: position of the eye, and projection of points of the model to the image. The z axis of the root frame
//! points up.

use crate::report::film::run::{Run, State, Vector};
use std::f64::consts::{FRAC_PI_2, PI};

/// Extent of the framed points, as fractions of half the width and half the height of the image.
const FILLED: [f64; 2] = [0.86, 0.8];
/// Number of states sampled to frame a motion.
const SAMPLED: usize = 61;

/// Tangent of half the angle of view along the shorter side of the image.
fn half_view() -> f64 {
    (15.0 * PI / 180.0).tan()
}

/// Viewing direction of a video, as on the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum View {
    /// Isometric.
    Iso,
    /// View along y: x to the right, z up.
    Front,
    /// View against x: y to the right, z up.
    Side,
    /// View from above: x to the right, y up.
    Top,
}

impl View {
    /// Azimuth of the eye, measured from x towards y, and its elevation, in rad.
    fn angles_rad(self) -> [f64; 2] {
        match self {
            Self::Iso => [-1.05, 0.42],
            Self::Front => [-FRAC_PI_2, 0.0],
            Self::Side => [0.0, 0.0],
            Self::Top => [-FRAC_PI_2, FRAC_PI_2],
        }
    }
}

/// Camera directed at a target.
#[derive(Debug, Clone, Copy)]
pub(super) struct Camera {
    target: Vector,
    /// Distance of the eye from the target in m.
    pub distance_m: f64,
    right: Vector,
    up: Vector,
    /// Unit vector from the target to the eye.
    pub outward: Vector,
    /// Width and height of the image in pixels.
    size: [f64; 2],
}

/// Projected point: pixels from the upper left corner, and the inverse of its distance from the plane of the eye in 1/m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seen {
    pub x: f64,
    pub y: f64,
    pub near: f64,
}

impl Camera {
    /// Creates a camera at the smallest distance at which the points are in the frame, in the direction `view`.
    fn framing(points: &[Vector], view: View, size: [u32; 2]) -> Self {
        let [azimuth, elevation] = view.angles_rad();
        let ((sa, ca), (se, ce)) = (azimuth.sin_cos(), elevation.sin_cos());
        let (outward, right) = (Vector::new(ca * ce, sa * ce, se), Vector::new(-sa, ca, 0.0));
        let up = outward.cross(&right);
        let size = size.map(f64::from);
        let axes = [right, up, outward];
        let seen: Vec<[f64; 3]> = points.iter().map(|point| axes.map(|axis| point.dot(&axis))).collect();
        let ends = [0, 1, 2].map(|i| {
            let along = seen.iter().map(|point| point[i]);
            [along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max)]
        });
        let middle = ends.map(|[low, high]| 0.5 * (low + high));
        let span = ends.map(|[low, high]| high - low).iter().map(|length| length * length).sum::<f64>().sqrt();
        let shorter = size[0].min(size[1]);
        let half = [0, 1].map(|i| half_view() * size[i] / shorter * FILLED[i]);
        let fits = |point: &[f64; 3]| {
            let off = |i: usize| (point[i] - middle[i]).abs() / half[i];
            off(0).max(off(1)) + point[2] - middle[2]
        };
        let distance_m = seen.iter().map(fits).fold((0.02 * span).max(1e-6), f64::max);
        let target = right * middle[0] + up * middle[1] + outward * middle[2];
        Self { target, distance_m, right, up, outward, size }
    }

    /// Position of the eye.
    pub fn eye(&self) -> Vector {
        self.target + self.distance_m * self.outward
    }

    /// Distance of a point from the plane of the eye in m, positive in front of it.
    pub fn depth_m(&self, point: &Vector) -> f64 {
        self.distance_m - (point - self.target).dot(&self.outward)
    }

    /// Smallest distance that is drawn, in m.
    pub fn nearest_m(&self) -> f64 {
        1e-3 * self.distance_m
    }

    /// Projects a point in front of the eye to the image.
    pub fn seen(&self, point: &Vector) -> Seen {
        let (off, near) = (point - self.target, 1.0 / self.depth_m(point));
        let scale = self.size[0].min(self.size[1]) / (2.0 * half_view()) * near;
        Seen {
            x: 0.5 * self.size[0] + scale * off.dot(&self.right),
            y: 0.5 * self.size[1] - scale * off.dot(&self.up),
            near,
        }
    }
}

/// Motion of the camera of a video.
#[derive(Debug)]
pub(super) struct Motion {
    at_start: Camera,
    /// Mean position of the model at the start, if the target moves with the model.
    start: Option<Vector>,
}

impl Motion {
    /// Creates a camera for the states of a run: fixed, with the whole motion in the frame, or moving with the model.
    pub fn new<'r>(
        run: &'r Run,
        (view, follows): (View, bool),
        size: [u32; 2],
        states: impl Iterator<Item = State<'r>>,
    ) -> Self {
        let start = follows.then(|| run.at_frame(0).middle());
        let moved = |state: State<'r>| {
            let shift = start.map_or_else(Vector::zeros, |start| start - state.middle());
            state.points().into_iter().map(move |point| point + shift)
        };
        let points: Vec<Vector> = states.flat_map(moved).filter(|point| point.iter().all(|c| c.is_finite())).collect();
        Self { at_start: Camera::framing(&points, view, size), start }
    }

    /// Number of states sampled to frame a motion.
    pub const STATES: usize = SAMPLED;

    /// Returns the camera for a state.
    pub fn at(&self, state: &State<'_>) -> Camera {
        let shift = self.start.map_or_else(Vector::zeros, |start| state.middle() - start);
        Camera { target: self.at_start.target + shift, ..self.at_start }
    }
}
