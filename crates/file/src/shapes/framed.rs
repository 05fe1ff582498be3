//! Boxes, I-beams, channels and angles of one material: area and bending from rectangles, torsion and shear from walls.

use super::materials::Material;
use super::properties::{Moments, Raw};
use super::walls::Walls;
use std::f64::consts::PI;

/// Rectangle given by smallest and largest `y` and smallest and largest `z` in m.
type Rectangle = [[f64; 2]; 2];

/// Properties from rectangles that do not overlap, walls along their centre lines, and the torsion constant in m⁴; for open sections
/// including warping.
fn raw(rectangles: &[Rectangle], walls: &Walls, torsion_m4: f64, open: bool, material: &Material) -> Option<Raw> {
    let moments = |weight: f64| {
        let mut moments = Moments::default();
        for [[left, right], [low, high]] in rectangles {
            let (middle, half) =
                ([0.5 * (left + right), 0.5 * (low + high)], [0.5 * (right - left), 0.5 * (high - low)]);
            moments.add_rectangle(weight, middle, half, [1.0, 0.0]);
        }
        moments
    };
    let flows = walls.flows()?;
    let reach = |axis: usize| {
        let ends = || rectangles.iter().map(|rectangle| rectangle[axis]);
        [
            ends().map(|end| end[0]).fold(f64::INFINITY, f64::min),
            ends().map(|end| end[1]).fold(f64::NEG_INFINITY, f64::max),
        ]
    };
    Some(Raw {
        stiffness: moments(material.youngs_modulus_pa),
        mass: moments(material.density_kg_m3),
        torsional_rigidity_n_m2: material.shear_modulus_pa * torsion_m4,
        shear_stiffnesses_n: flows.shear_stiffnesses_n,
        shear_centre_m: flows.shear_centre_m,
        warping_stiffness_n_m4: if open { flows.warping_stiffness_n_m4 } else { 0.0 },
        reach_m: [reach(0), reach(1)],
    })
}

/// Outer dimensions and wall thicknesses in m: `wall_m` for walls along `y`, `web_m` for walls along `z`.
#[derive(Debug, Clone, Copy)]
pub(in crate::shapes) struct Frame {
    /// Full width along `y`.
    pub width_m: f64,
    /// Full height along `z`.
    pub height_m: f64,
    /// Thickness of the walls along `y`.
    pub wall_m: f64,
    /// Thickness of the walls along `z`.
    pub web_m: f64,
}

/// Rectangular box with sharp corners; torsion from walls and corners, NOTATION eq. (S19).
pub(in crate::shapes) fn hollow_box(frame: Frame, material: &Material) -> Option<Raw> {
    let Frame { width_m: b, height_m: h, wall_m: t, web_m: w } = frame;
    let (y, z) = (0.5 * b, 0.5 * h);
    let rectangles =
        [[[-y, y], [z - t, z]], [[-y, y], [-z, t - z]], [[-y, w - y], [t - z, z - t]], [[y - w, y], [t - z, z - t]]];
    let (ym, zm) = (y - 0.5 * w, z - 0.5 * t);
    let mut walls = Walls::default();
    let corners = [[ym, zm], [-ym, zm], [-ym, -zm], [ym, -zm]].map(|corner| walls.node(corner));
    for (side, thickness) in [t, w, t, w].into_iter().enumerate() {
        walls.wall(corners[side], corners[(side + 1) % 4], thickness, material);
    }
    let (inner_b, inner_h) = (b - 2.0 * w, h - 2.0 * t);
    // ∫h dA and ∮∂h/∂n of the harmonic function h that is 0 at the outer and 1 at the inner boundary
    let level = inner_b * inner_h + inner_b * t + inner_h * w + 4.0 * corner_level_m2(t, w);
    let flux = 2.0 * inner_b / t + 2.0 * inner_h / w + 4.0 * corner_flux(t, w);
    let open = 2.0 * (inner_b * t.powi(3) + inner_h * w.powi(3)) / 3.0 + 4.0 * corner_torsion_m4(t, w);
    raw(&rectangles, &walls, 4.0 * level * level / flux + open, false, material)
}

/// I-beam with equal flanges; torsion includes the contributions of the junctions, NOTATION eq. (S19).
pub(in crate::shapes) fn i_beam(frame: Frame, material: &Material) -> Option<Raw> {
    let Frame { width_m: b, height_m: h, wall_m: t, web_m: w } = frame;
    let (y, z, half) = (0.5 * b, 0.5 * h, 0.5 * w);
    let rectangles = [[[-y, y], [z - t, z]], [[-y, y], [-z, t - z]], [[-half, half], [t - z, z - t]]];
    let zm = z - 0.5 * t;
    let mut walls = Walls::default();
    let nodes = [[-y, zm], [0.0, zm], [y, zm], [-y, -zm], [0.0, -zm], [y, -zm]].map(|node| walls.node(node));
    for (from, to, thickness) in [(0, 1, t), (1, 2, t), (3, 4, t), (4, 5, t), (1, 4, w)] {
        walls.wall(nodes[from], nodes[to], thickness, material);
    }
    let torsion = 2.0 * b * t.powi(3) / 3.0 + (h - 2.0 * t) * w.powi(3) / 3.0 + 2.0 * junction_torsion_m4(t, w)
        - 4.0 * END * t.powi(4);
    raw(&rectangles, &walls, torsion, true, material)
}

/// Channel, open towards `+y`; torsion includes the contributions of the corners, NOTATION eq. (S19).
pub(in crate::shapes) fn channel(frame: Frame, material: &Material) -> Option<Raw> {
    let Frame { width_m: b, height_m: h, wall_m: t, web_m: w } = frame;
    let z = 0.5 * h;
    let rectangles = [[[0.0, b], [z - t, z]], [[0.0, b], [-z, t - z]], [[0.0, w], [t - z, z - t]]];
    let (ym, zm) = (0.5 * w, z - 0.5 * t);
    let mut walls = Walls::default();
    let nodes = [[b, zm], [ym, zm], [ym, -zm], [b, -zm]].map(|node| walls.node(node));
    for (from, thickness) in [(0, t), (1, w), (2, t)] {
        walls.wall(nodes[from], nodes[from + 1], thickness, material);
    }
    let torsion = 2.0 * (b - w) * t.powi(3) / 3.0 + (h - 2.0 * t) * w.powi(3) / 3.0 + 2.0 * corner_torsion_m4(t, w)
        - 2.0 * END * t.powi(4);
    raw(&rectangles, &walls, torsion, true, material)
}

/// Angle with its heel at the smallest `y` and `z`, and legs of equal thickness along `+y` and `+z`; NOTATION eq. (S19).
pub(in crate::shapes) fn angle(width_m: f64, height_m: f64, wall_m: f64, material: &Material) -> Option<Raw> {
    let (b, h, t) = (width_m, height_m, wall_m);
    let rectangles = [[[0.0, b], [0.0, t]], [[0.0, t], [t, h]]];
    let mut walls = Walls::default();
    let nodes = [[b, 0.5 * t], [0.5 * t, 0.5 * t], [0.5 * t, h]].map(|node| walls.node(node));
    walls.wall(nodes[0], nodes[1], t, material);
    walls.wall(nodes[1], nodes[2], t, material);
    let torsion = (b + h - 2.0 * t) * t.powi(3) / 3.0 + corner_torsion_m4(t, t) - 2.0 * END * t.powi(4);
    raw(&rectangles, &walls, torsion, true, material)
}

/// Reduction of the torsion constant at a free end of a wall, divided by the fourth power of its thickness, from a long rectangle,
/// NOTATION eq. (S2).
const END: f64 = 0.105;

/// Cubic interpolation of values at 1/4, 1/2, 3/4 and 1, given by the first value and the forward differences.
fn cubic(ratio: f64, [value, first, second, third]: [f64; 4]) -> f64 {
    let u = 4.0 * ratio - 1.0;
    value + u * (first + 0.5 * (u - 1.0) * (second + (u - 2.0) / 3.0 * third))
}

/// Ratio of the smaller to the larger thickness, and the larger thickness in m.
fn ratio(wall_m: f64, web_m: f64) -> (f64, f64) {
    (wall_m.min(web_m) / wall_m.max(web_m), wall_m.max(web_m))
}

/// Torsion constant in m⁴ of a sharp corner, in addition to that of the walls up to its inner edge; from Poisson's equation in an
/// infinite corner, `tests/reference/sections/corners.py`.
fn corner_torsion_m4(wall_m: f64, web_m: f64) -> f64 {
    let (ratio, thick_m) = ratio(wall_m, web_m);
    thick_m.powi(4) * cubic(ratio, [-0.018_907, 0.104_301, 0.034_908, 0.007_569])
}

/// `∫h dA` in m² of a sharp corner, in addition to that of the walls up to its inner edge, from the same script.
fn corner_level_m2(wall_m: f64, web_m: f64) -> f64 {
    let (ratio, thick_m) = ratio(wall_m, web_m);
    thick_m.powi(2) * cubic(ratio, [-0.033_765, 0.076_154, -0.017_321, 0.002_105])
}

/// `∫∂h/∂n` of a sharp corner, in addition to that of the walls up to its inner edge (Cockcroft, J. IEE 66 (1928) 385); 0.559 for equal
/// walls.
fn corner_flux(wall_m: f64, web_m: f64) -> f64 {
    let (a, b) = (wall_m, web_m);
    2.0 / PI * (((a * a + b * b) / (4.0 * a * b)).ln() + a / b * (b / a).atan() + b / a * (a / b).atan())
}

/// Torsion constant in m⁴ of the junction of a flange and a web, in addition to those of the complete flange and of the web up to it,
/// from the same script.
fn junction_torsion_m4(flange_m: f64, web_m: f64) -> f64 {
    let ratio = web_m / flange_m;
    let u = 2.0 * ratio - 2.0;
    let factor = if ratio < 1.0 { 0.2926 * ratio.powf(2.26) } else { 0.2926 + u * (0.3902 + 0.004_35 * (u - 1.0)) };
    flange_m.powi(4) * factor
}
