//! Aerofoils around lifting surfaces, and nacelle and hub of a turbine, as the page shows them by default.

use super::colours::{self, Rgb};
use super::drawing::{Drawing, Face, Line, Vertex};
use super::outlines::Aerofoil;
use crate::report::film::run::{Run, State, Vector};

/// Opacity of the lattice lines.
const LATTICE: f32 = 0.55;

/// Slope at the leading edge relative to that of the first interval: the normal there points forward.
const NOSE: f64 = 6.0;

/// Point of an aerofoil with its outward normal.
type Point = (Vector, Vector);

/// Returns whether aerofoils are drawn: not where they would hide a spar whose outline the model gives.
pub(super) fn has_aerofoils(run: &Run) -> bool {
    run.about.aerofoils.iter().any(Option::is_some) && !run.about.aerofoils.iter().flatten().any(|one| one.hides_spar)
}

/// Returns whether the aerofoil of a surface surrounds all of a body.
pub(super) fn is_enclosed(run: &Run, body: usize) -> bool {
    let Some(length_m) = run.about.bodies[body].places.last() else { return false };
    let surfaces = run.about.surfaces.iter().zip(&run.about.aerofoils);
    has_aerofoils(run)
        && surfaces.filter(|(surface, aerofoil)| surface.body == body && aerofoil.is_some()).any(|(surface, _)| {
            surface.places.first().is_some_and(|first_m| *first_m < 0.02 * length_m)
                && surface.places.last().is_some_and(|last_m| *last_m > 0.98 * length_m)
        })
}

/// Draws the aerofoil of a surface with one colour per strip, and its lattice on both sides.
pub(super) fn draw_aerofoil(
    run: &Run,
    index: usize,
    aerofoil: &Aerofoil,
    rgb: &dyn Fn(usize) -> Rgb,
    state: &State<'_>,
    into: &mut Drawing,
) {
    let surface = &run.about.surfaces[index];
    let edges: Vec<[Vec<Point>; 2]> =
        (0..surface.columns).map(|column| edge(surface.columns, index, column, aerofoil, state)).collect();
    let strips = surface.columns - 1;
    let vertex = |(at, normal): Point, strip: usize| Vertex { at, normal, rgb: rgb(strip) };
    for (strip, pair) in edges.windows(2).enumerate() {
        for (before, after) in pair[0].iter().zip(&pair[1]) {
            for (inner, outer) in before.windows(2).zip(after.windows(2)) {
                let [a, b, c, d] = [inner[0], outer[0], outer[1], inner[1]].map(|point| vertex(point, strip));
                into.faces.push(Face { corners: [a, b, c], sheet: false });
                into.faces.push(Face { corners: [a, c, d], sheet: false });
            }
        }
    }
    for (column, strip) in [(0, 0), (strips, strips - 1)] {
        let [upper, lower] = &edges[column];
        for (above, below) in upper.windows(2).zip(lower.windows(2)) {
            into.sheet([above[0].0, above[1].0, below[1].0, below[0].0], rgb(strip));
        }
    }
    let panels = surface.panels.max(1) as f64;
    let on_panel = |x: f64| (x * panels - (x * panels).round()).abs() < 1e-4;
    let mut line = |ends: [Vector; 2]| {
        into.lines.push(Line { ends, rgb: colours::EDGE, opacity: LATTICE, width: 1.0 });
    };
    for (column, edge) in edges.iter().enumerate() {
        for (side, points) in edge.iter().enumerate() {
            points.windows(2).for_each(|pair| line([pair[0].0, pair[1].0]));
            if column > 0 {
                let stations = aerofoil.stations.iter().zip(points).zip(&edges[column - 1][side]);
                for ((_, outer), inner) in stations.filter(|((x, _), _)| on_panel(**x)) {
                    line([inner.0, outer.0]);
                }
            }
        }
    }
}

/// Points with outward normals at an edge of the strips: upper and lower side.
fn edge(columns: usize, surface: usize, column: usize, aerofoil: &Aerofoil, state: &State<'_>) -> [Vec<Point>; 2] {
    let corner = |column: usize, edge: usize| state.corner(surface, column, edge);
    let (before, after) = (column.saturating_sub(1), (column + 1).min(columns - 1));
    let chord = corner(column, 1) - corner(column, 0);
    let span = corner(after, 0) - corner(before, 0) + corner(after, 1) - corner(before, 1);
    let across = chord.cross(&span).try_normalize(0.0).unwrap_or_else(Vector::z);
    let along = chord.try_normalize(0.0).unwrap_or_else(Vector::x);
    [(&aerofoil.upper, 1.0), (&aerofoil.lower, -1.0)].map(|(side, out)| {
        let heights = &side[column];
        let slope = |k: usize| {
            let (i, j) = (k.saturating_sub(1), (k + 1).min(heights.len() - 1));
            let steeper = if k == 0 { NOSE } else { 1.0 };
            steeper * (heights[j] - heights[i]) / (aerofoil.stations[j] - aerofoil.stations[i])
        };
        let point = |(k, x): (usize, &f64)| {
            let at = corner(column, 0) + *x * chord + heights[k] * chord.norm() * across;
            (at, out * (across - slope(k) * along).normalize())
        };
        aerofoil.stations.iter().enumerate().map(point).collect()
    })
}

/// Draws nacelle and hub.
pub(super) fn draw_solids(run: &Run, state: &State<'_>, into: &mut Drawing) {
    for solid in &run.about.solids {
        let section = state.section(solid.body, 0);
        let place = |[x, y, z]: [f64; 3]| section.at + x * section.x() + y * section.y + z * section.z;
        let rings: Vec<Vec<Vector>> =
            solid.rings.iter().map(|ring| ring.iter().copied().map(place).collect()).collect();
        let middles: Vec<Vector> = rings.iter().map(|ring| ring.iter().sum::<Vector>() / ring.len() as f64).collect();
        let middle = 0.5 * (middles[0] + middles[middles.len() - 1]);
        let mut face = |corners: [Vector; 3], normals: Option<[Vector; 3]>| {
            let flat = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
            let flat = flat.try_normalize(0.0).unwrap_or_else(Vector::z);
            let flat = if flat.dot(&(corners[0] - middle)) < 0.0 { -flat } else { flat };
            let normals = normals.unwrap_or([flat; 3]);
            let vertex = |k: usize| Vertex { at: corners[k], normal: normals[k], rgb: colours::BODY };
            into.faces.push(Face { corners: [vertex(0), vertex(1), vertex(2)], sheet: false });
        };
        let around = rings[0].len();
        let outward = |ring: usize, k: usize| {
            let way = rings[ring][k] - middles[ring.saturating_sub(1)];
            way.try_normalize(0.0).unwrap_or_else(Vector::z)
        };
        for i in 1..rings.len() {
            for k in 0..around {
                let next = (k + 1) % around;
                let quad = [(i - 1, k), (i - 1, next), (i, next), (i, k)];
                for three in [[0, 1, 2], [0, 2, 3]] {
                    let corners = three.map(|corner| rings[quad[corner].0][quad[corner].1]);
                    let normals = solid.round.then(|| three.map(|corner| outward(quad[corner].0, quad[corner].1)));
                    face(corners, normals);
                }
            }
        }
        for ring in [&rings[0], &rings[rings.len() - 1]] {
            for k in 1..around - 1 {
                face([ring[0], ring[k], ring[k + 1]], None);
            }
        }
    }
}
