//! Solid symbols: tubes and cones, spheres, rings.

use super::colours::Rgb;
use super::drawing::{Face, Vertex};
use crate::report::film::run::Vector;
use std::f64::consts::{PI, TAU};

/// Two unit vectors normal to a unit vector and to each other.
fn across(axis: &Vector) -> [Vector; 2] {
    let other = if axis.x.abs() < 0.6 { Vector::x() } else { Vector::y() };
    let first = axis.cross(&other).normalize();
    [first, axis.cross(&first)]
}

/// Adds the faces between neighbouring points of a grid of `rows` by `columns`, which is closed in the direction of the
/// columns.
fn net(into: &mut Vec<Face>, points: &[Vertex], rows: usize, columns: usize) {
    for row in 1..rows {
        for column in 0..columns {
            let next = (column + 1) % columns;
            let [a, b] = [column, next].map(|column| points[(row - 1) * columns + column]);
            let [d, c] = [column, next].map(|column| points[row * columns + column]);
            into.push(Face { corners: [a, b, c], sheet: false });
            into.push(Face { corners: [a, c, d], sheet: false });
        }
    }
}

/// Adds a tube with closed ends; a cone if the second radius is zero.
pub(super) fn tube(into: &mut Vec<Face>, ends: [Vector; 2], radii: [f64; 2], sides: usize, rgb: Rgb) {
    let Some(axis) = (ends[1] - ends[0]).try_normalize(0.0) else { return };
    let [u, v] = across(&axis);
    let direction = |side: usize| {
        let (sine, cosine) = (TAU * side as f64 / sides as f64).sin_cos();
        cosine * u + sine * v
    };
    let slope = (radii[0] - radii[1]) / (ends[1] - ends[0]).norm();
    let point = |end: usize, side: usize| {
        let radial = direction(side);
        Vertex { at: ends[end] + radii[end] * radial, normal: (radial + slope * axis).normalize(), rgb }
    };
    let points: Vec<Vertex> = [0, 1].into_iter().flat_map(|end| (0..sides).map(move |side| point(end, side))).collect();
    net(into, &points, 2, sides);
    for (end, sign) in [(0, -1.0), (1, 1.0)] {
        let cap = |side: usize| Vertex { normal: sign * axis, ..point(end, side) };
        let middle = Vertex { at: ends[end], normal: sign * axis, rgb };
        for side in 0..sides {
            into.push(Face { corners: [middle, cap(side), cap((side + 1) % sides)], sheet: false });
        }
    }
}

/// Adds a sphere.
pub(super) fn sphere(into: &mut Vec<Face>, at: Vector, radius: f64, rgb: Rgb) {
    let (rows, columns) = (13, 20);
    let point = |row: usize, column: usize| {
        let (ring, height) = (PI * row as f64 / (rows - 1) as f64).sin_cos();
        let (sine, cosine) = (TAU * column as f64 / columns as f64).sin_cos();
        let normal = Vector::new(ring * cosine, ring * sine, height);
        Vertex { at: at + radius * normal, normal, rgb }
    };
    let points: Vec<Vertex> = (0..rows).flat_map(|row| (0..columns).map(move |column| point(row, column))).collect();
    net(into, &points, rows, columns);
}

/// Adds a ring around an axis; the radii are those of its centre line and of its cross section.
pub(super) fn torus(into: &mut Vec<Face>, at: Vector, axis: Vector, radii: [f64; 2], rgb: Rgb) {
    let (rows, columns) = (25, 10);
    let [u, v] = across(&axis);
    let point = |row: usize, column: usize| {
        let (sine, cosine) = (TAU * row as f64 / (rows - 1) as f64).sin_cos();
        let outward = cosine * u + sine * v;
        let (up, out) = (TAU * column as f64 / columns as f64).sin_cos();
        let normal = out * outward + up * axis;
        Vertex { at: at + radii[0] * outward + radii[1] * normal, normal, rgb }
    };
    let points: Vec<Vertex> = (0..rows).flat_map(|row| (0..columns).map(move |column| point(row, column))).collect();
    net(into, &points, rows, columns);
}
