//! Thin-walled profile: the skin of an aerofoil with spars between its upper and lower side.

use super::materials::Material;
use super::properties::Raw;
use super::walls::Walls;

/// Number of points on each side of a NACA four-digit aerofoil.
const POINTS_PER_SIDE: usize = 60;
/// Maximum distance between the ends of an outline as a fraction of the chord; the resulting blunt trailing edge is closed by a wall.
pub(in crate::shapes) const LARGEST_GAP: f64 = 0.05;

/// Spar: a wall through the profile along `z`.
#[derive(Debug, Clone)]
pub(in crate::shapes) struct Spar {
    /// Name, for messages.
    pub name: String,
    /// Distance from the leading edge as a fraction of the chord.
    pub position: f64,
    /// Thickness in m.
    pub wall_m: f64,
    /// Material.
    pub material: Material,
}

/// Reason why a profile is not valid.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::shapes) enum Misfit {
    /// The ends of the outline are separated by this fraction of the chord.
    Open(f64),
    /// The outline crosses itself or has no area.
    Tangled,
    /// A skin thicker than this thickness in m overlaps itself at a bend of the outline.
    ThickSkin(f64),
    /// The spar with this index is not within the hollow, which extends between these fractions of the chord.
    Outside(usize, [f64; 2]),
    /// Two spars are at the same position; index of one of them.
    Coincident(usize),
}

/// Outline of a NACA four-digit aerofoil with a sharp trailing edge, as fractions of the chord `[x, z]`: from the trailing edge along the
/// upper side to the leading edge and back along the lower side. `None` for other names.
pub(crate) fn naca(name: &str) -> Option<Vec<[f64; 2]>> {
    let digits = name.to_ascii_lowercase().replace(['-', ' ', '_'], "");
    let digits = digits.strip_prefix("naca")?;
    if digits.len() != 4 || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let digit = |at: usize| f64::from(digits.as_bytes()[at] - b'0');
    let (camber, peak) = (0.01 * digit(0), 0.1 * digit(1));
    let thickness = 0.1 * digit(2) + 0.01 * digit(3);
    if thickness == 0.0 || (camber > 0.0) != (peak > 0.0) {
        return None;
    }
    let side = |sign: f64| {
        (0..=POINTS_PER_SIDE).map(move |i| {
            let x = 0.5 * (1.0 - (std::f64::consts::PI * i as f64 / POINTS_PER_SIDE as f64).cos());
            let half =
                5.0 * thickness * (0.2969 * x.sqrt() + x * (-0.1260 + x * (-0.3516 + x * (0.2843 - 0.1036 * x))));
            let (line, slope) = if camber == 0.0 {
                (0.0, 0.0)
            } else if x < peak {
                (camber / (peak * peak) * x * (2.0 * peak - x), 2.0 * camber / (peak * peak) * (peak - x))
            } else {
                let aft = camber / ((1.0 - peak) * (1.0 - peak));
                (aft * (1.0 - 2.0 * peak + x * (2.0 * peak - x)), 2.0 * aft * (peak - x))
            };
            let angle = slope.atan();
            [x - sign * half * angle.sin(), line + sign * half * angle.cos()]
        })
    };
    let mut points: Vec<[f64; 2]> = side(1.0).collect();
    points.reverse();
    points.extend(side(-1.0).skip(1));
    Some(points)
}

/// Profile with a chord in m and an outline given as fractions of the chord `[x, z]`, which is the outer surface. The leading edge is
/// towards `+y` if `side` is 1, towards `−y` if −1. The origin of the returned positions is the leading edge, `x = 0`.
pub(in crate::shapes) fn profile(
    outline: &[[f64; 2]],
    chord_m: f64,
    skin_m: f64,
    skin: &Material,
    spars: &[Spar],
    side: f64,
) -> Result<Raw, Misfit> {
    let mut surface: Vec<[f64; 2]> = outline.iter().map(|[x, z]| [x * chord_m, z * chord_m]).collect();
    surface.dedup();
    let area: f64 = edges(&surface, true).map(|([x0, z0], [x1, z1])| 0.5 * (x0 * z1 - x1 * z0)).sum();
    if area < 0.0 {
        surface.reverse();
    }
    if surface.len() < 4 || area.abs() < 1e-6 * chord_m * chord_m || crosses_itself(&surface) {
        return Err(Misfit::Tangled);
    }
    let gap = distance(surface[0], surface[surface.len() - 1]) / chord_m;
    if gap > LARGEST_GAP {
        return Err(Misfit::Open(gap));
    }
    let middle = closed_middle(&surface, 0.5 * skin_m)
        .ok_or_else(|| Misfit::ThickSkin(2.0 * largest_inset(&surface, 0.5 * skin_m)))?;
    let mut walls = Walls::default();
    let mut nodes: Vec<usize> = middle.iter().map(|point| walls.node(*point)).collect();
    // spars connect both sides of the skin at new nodes of the ring
    let reach = |points: &[[f64; 2]]| {
        let ends = points.iter().map(|point| point[0]);
        [ends.clone().fold(f64::INFINITY, f64::min), ends.fold(f64::NEG_INFINITY, f64::max)]
    };
    let [nose, tail] = reach(&middle);
    let mut webs = Vec::new();
    for (index, spar) in spars.iter().enumerate() {
        let at = spar.position * chord_m;
        if at - 0.5 * spar.wall_m <= nose + 0.5 * skin_m || at + 0.5 * spar.wall_m >= tail {
            return Err(Misfit::Outside(index, [(nose + 0.5 * skin_m) / chord_m, tail / chord_m]));
        }
        if spars[..index].iter().any(|other| (other.position * chord_m - at).abs() < 0.5 * (other.wall_m + spar.wall_m))
        {
            return Err(Misfit::Coincident(index));
        }
        let feet = [split(&mut walls, &mut nodes, at, true), split(&mut walls, &mut nodes, at, false)];
        let [Some(upper), Some(lower)] = feet else {
            return Err(Misfit::Outside(index, [nose / chord_m, tail / chord_m]));
        };
        webs.push((lower, upper, spar));
    }
    for (at, node) in nodes.iter().enumerate() {
        walls.wall(*node, nodes[(at + 1) % nodes.len()], skin_m, skin);
    }
    for (lower, upper, spar) in webs {
        walls.wall(lower, upper, spar.wall_m, &spar.material);
        let height = distance(walls.nodes_m[lower], walls.nodes_m[upper]);
        if let Some(web) = walls.walls.last_mut() {
            web.trim_m = (0.5 * skin_m).min(0.45 * height);
        }
    }
    walls.nodes_m.iter_mut().for_each(|node| node[0] *= -side);
    let flows = walls.flows().ok_or(Misfit::Tangled)?;
    let [first, last] = reach(&surface);
    let heights = surface.iter().map(|point| point[1]);
    let (low, high) = (heights.clone().fold(f64::INFINITY, f64::min), heights.fold(f64::NEG_INFINITY, f64::max));
    let ends = [-side * first, -side * last];
    Ok(Raw {
        stiffness: walls.moments(|material| material.youngs_modulus_pa),
        mass: walls.moments(|material| material.density_kg_m3),
        torsional_rigidity_n_m2: flows.cells_n_m2 + flows.open_n_m2,
        shear_stiffnesses_n: flows.shear_stiffnesses_n,
        shear_centre_m: flows.shear_centre_m,
        warping_stiffness_n_m4: 0.0,
        reach_m: [[ends[0].min(ends[1]), ends[0].max(ends[1])], [low, high]],
    })
}

/// Pairs of consecutive points; for a closed line also the last and the first.
fn edges(points: &[[f64; 2]], closed: bool) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
    let count = if closed { points.len() } else { points.len() - 1 };
    (0..count).map(|i| (points[i], points[(i + 1) % points.len()]))
}

fn distance(from: [f64; 2], to: [f64; 2]) -> f64 {
    (to[0] - from[0]).hypot(to[1] - from[1])
}

/// Intersection of two segments, as fractions of each.
fn crossing((a, b): ([f64; 2], [f64; 2]), (c, d): ([f64; 2], [f64; 2])) -> Option<[f64; 2]> {
    let (r, s, w) = ([b[0] - a[0], b[1] - a[1]], [d[0] - c[0], d[1] - c[1]], [c[0] - a[0], c[1] - a[1]]);
    let cross = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
    let area = cross(r, s);
    let places = [cross(w, s) / area, cross(w, r) / area];
    places.iter().all(|place| (0.0..=1.0).contains(place)).then_some(places)
}

/// Returns whether edges that are not adjacent intersect.
fn crosses_itself(points: &[[f64; 2]]) -> bool {
    let lines: Vec<_> = edges(points, false).collect();
    let last = lines.len() - 1;
    let far = |i: usize, j: usize| j > i + 1 && !(i == 0 && j == last);
    (0..lines.len()).any(|i| (i..lines.len()).any(|j| far(i, j) && crossing(lines[i], lines[j]).is_some()))
}

/// Closed line inside an outline at the distance `inset_m`; near the trailing edge, where the lines of the two sides meet, it ends at their
/// intersection. `None` if the distance is too large for a bend of the outline.
fn closed_middle(surface: &[[f64; 2]], inset_m: f64) -> Option<Vec<[f64; 2]>> {
    let directions: Vec<[f64; 2]> = edges(surface, false)
        .map(|(a, b)| {
            let length = distance(a, b);
            [(b[0] - a[0]) / length, (b[1] - a[1]) / length]
        })
        .collect();
    let last = surface.len() - 1;
    let inset: Vec<[f64; 2]> = (0..=last)
        .map(|i| {
            let (before, after) = (directions[i.max(1) - 1], directions[i.min(last - 1)]);
            let cosine = before[0] * after[0] + before[1] * after[1];
            // intersection of the lines at this distance from both edges
            let scale = inset_m / (1.0 + cosine).max(0.1);
            [surface[i][0] - scale * (before[1] + after[1]), surface[i][1] + scale * (before[0] + after[0])]
        })
        .collect();
    let lines: Vec<_> = edges(&inset, false).collect();
    let meeting = (0..lines.len() / 2)
        .find_map(|i| (lines.len() / 2..lines.len()).rev().find_map(|j| Some((i, j, crossing(lines[i], lines[j])?))));
    let middle = match meeting {
        Some((i, j, [place, _])) => {
            let (a, b) = lines[i];
            let mut middle = vec![[a[0] + place * (b[0] - a[0]), a[1] + place * (b[1] - a[1])]];
            middle.extend(&inset[i + 1..=j]);
            middle
        }
        None => inset.clone(),
    };
    // find edges whose length the inset reduces to zero
    let folded = (0..last).find(|i| {
        let (a, b) = lines[*i];
        let kept = meeting.is_none_or(|(first, end, _)| *i > first && *i < end);
        kept && (b[0] - a[0]) * directions[*i][0] + (b[1] - a[1]) * directions[*i][1] <= 0.0
    });
    (folded.is_none() && middle.len() >= 4 && !crosses_itself(&middle)).then_some(middle)
}

/// Half of the largest thickness that an outline permits, below a thickness that it does not permit; found by bisection.
fn largest_inset(surface: &[[f64; 2]], inset_m: f64) -> f64 {
    let (mut low, mut high) = (0.0, inset_m);
    for _ in 0..20 {
        let half = 0.5 * (low + high);
        if closed_middle(surface, half).is_some() {
            low = half;
        } else {
            high = half;
        }
    }
    low
}

/// Inserts a node into the upper or lower side of the ring at `x`, and returns its index.
fn split(walls: &mut Walls, ring: &mut Vec<usize>, at_m: f64, upper: bool) -> Option<usize> {
    let mut best: Option<(usize, f64)> = None;
    for i in 0..ring.len() {
        let (a, b) = (walls.nodes_m[ring[i]], walls.nodes_m[ring[(i + 1) % ring.len()]]);
        if (a[0] - at_m) * (b[0] - at_m) > 0.0 || a[0] == b[0] {
            continue;
        }
        let height = a[1] + (b[1] - a[1]) * (at_m - a[0]) / (b[0] - a[0]);
        if best.is_none_or(|(_, other)| if upper { height > other } else { height < other }) {
            best = Some((i, height));
        }
    }
    let (i, height) = best?;
    for end in [i, (i + 1) % ring.len()] {
        if distance(walls.nodes_m[ring[end]], [at_m, height]) < 1e-9 * at_m.abs() {
            return Some(ring[end]);
        }
    }
    let node = walls.node([at_m, height]);
    ring.insert(i + 1, node);
    Some(node)
}
