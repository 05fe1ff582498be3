//! The model in an image: bodies, lifting surfaces, wake, joints, gauges, masses, paths and arrows, as the page shows them by
//! default.

use super::colours::{self, Rgb, share, tint};
use super::drawing::{Drawing, Face, Line, Vertex};
use super::{skin, solids};
use crate::report::film::run::{Body, Extents, Hinge, Run, Section, State, Vector};

/// Opacities of the lattice lines and of the wake.
const LATTICE: f32 = 0.55;
const WAKE: f32 = 0.62;
/// Maximum number of segments of a path.
const PATH: usize = 400;
/// Magnitude up to which strains are round-off and are not coloured.
const NO_STRAIN: f64 = 1e-7;

/// Limits of the colour scales over the run, and reference sizes of symbols.
#[derive(Debug)]
pub(super) struct Measures {
    /// Size of the model at the start in m.
    pub width_m: f64,
    /// Largest magnitude of the longitudinal strain.
    pub strain: f64,
    /// Largest magnitude of circulation in m²/s; 0 without a lattice.
    pub circulation_m2_s: f64,
    /// Largest magnitude of gravity in m/s² and of the wind in m/s.
    gravity_m_s2: f64,
    wind_m_s: f64,
    /// Positions of the outer ends of the bodies in every frame.
    paths: Vec<Vec<Vector>>,
}

impl Measures {
    /// Measures of a run.
    pub fn of(run: &Run) -> Self {
        let width_m = Extents::of(run.at_frame(0).points().into_iter()).size();
        let (mut strain, mut circulation, mut gravity, mut wind) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
        let mut paths = vec![Vec::new(); run.about.bodies.len()];
        for frame in 0..run.count() {
            let state = run.at_frame(frame);
            for (b, body) in run.about.bodies.iter().enumerate() {
                for (i, rim) in body.rims.iter().enumerate() {
                    let section = state.section(b, i);
                    strain = rim.iter().fold(strain, |most, point| most.max(section.strain(*point).abs()));
                }
                paths[b].push(state.section(b, body.rims.len() - 1).at);
            }
            strain = (0..run.about.gauges.len()).fold(strain, |most, gauge| most.max(state.strain(gauge).abs()));
            circulation = (0..run.about.strips).fold(circulation, |most, i| most.max(state.circulation(i).abs()));
            for wake in state.wakes() {
                let rings = (0..wake.rows).flat_map(|row| (0..wake.columns.saturating_sub(1)).map(move |c| (row, c)));
                circulation = rings.fold(circulation, |most, (row, c)| most.max(wake.circulation(row, c).abs()));
            }
            gravity = gravity.max(state.gravity_m_s2().norm());
            wind = (0..run.about.winds).fold(wind, |most, body| most.max(state.wind_m_s(body).norm()));
        }
        Self {
            width_m,
            strain: strain.max(NO_STRAIN),
            circulation_m2_s: circulation,
            gravity_m_s2: gravity,
            wind_m_s: wind,
            paths,
        }
    }

    /// Returns whether there are strains to colour.
    pub fn has_strain(&self, run: &Run) -> bool {
        self.strain > NO_STRAIN
            && run.about.bodies.iter().enumerate().any(|(b, body)| !body.rigid && !skin::is_enclosed(run, b))
    }

    fn circulation_range(&self) -> f64 {
        if self.circulation_m2_s > 0.0 { self.circulation_m2_s } else { 1.0 }
    }
}

/// Draws the model in a state.
pub(super) fn draw(run: &Run, measures: &Measures, state: &State<'_>, into: &mut Drawing) {
    for (b, body) in run.about.bodies.iter().enumerate() {
        if !body.rigid && !skin::is_enclosed(run, b) {
            draw_body(body, b, measures, state, into);
        }
    }
    draw_surfaces(run, measures, state, into);
    skin::draw_solids(run, state, into);
    draw_wake(measures, state, into);
    for hinge in &run.about.hinges {
        draw_hinge(run, hinge, measures.width_m, state, into);
    }
    for gauge in 0..run.about.gauges.len() {
        let rgb = tint(&colours::STRAIN, share(state.strain(gauge), measures.strain));
        solids::sphere(&mut into.faces, state.gauge(gauge), 0.008 * measures.width_m, rgb);
    }
    draw_links(run, measures, state, into);
    draw_paths(measures, state, into);
    draw_arrows(run, measures, state, into);
}

/// Points around a section with their outward normals: corners of a rectangle appear twice, an ellipse is smooth.
fn ring(rim: &[[f64; 2]]) -> Vec<([f64; 2], [f64; 2])> {
    let unit = |[y, z]: [f64; 2]| {
        let length = y.hypot(z);
        if length > 0.0 { [y / length, z / length] } else { [0.0, 0.0] }
    };
    if rim.len() == 4 {
        let side = |j: usize| {
            let (p, q) = (rim[j], rim[(j + 1) % 4]);
            let normal = unit([q[1] - p[1], p[0] - q[0]]);
            [(p, normal), (q, normal)]
        };
        return (0..4).flat_map(side).collect();
    }
    let half: [f64; 2] = std::array::from_fn(|i| rim.iter().map(|point| point[i].abs()).fold(0.0, f64::max));
    let around = |j: u32| {
        let (sine, cosine) = (f64::from(j) * std::f64::consts::PI / 12.0).sin_cos();
        ([half[0] * cosine, half[1] * sine], unit([cosine * half[1], sine * half[0]]))
    };
    (0..24).map(around).collect()
}

/// Draws a closed surface around the sections, coloured by the strain.
fn draw_body(body: &Body, index: usize, measures: &Measures, state: &State<'_>, into: &mut Drawing) {
    let sections: Vec<Section> = (0..body.rims.len()).map(|i| state.section(index, i)).collect();
    let vertex = |section: &Section, point: [f64; 2], normal: Vector| {
        let rgb = if measures.strain > NO_STRAIN {
            tint(&colours::STRAIN, share(section.strain(point), measures.strain))
        } else {
            colours::BODY
        };
        Vertex { at: section.point(point), normal, rgb }
    };
    let rings: Vec<Vec<Vertex>> = sections
        .iter()
        .zip(&body.rims)
        .map(|(section, rim)| {
            let outward = |[y, z]: [f64; 2]| y * section.y + z * section.z;
            ring(rim).into_iter().map(|(point, normal)| vertex(section, point, outward(normal))).collect()
        })
        .collect();
    let step = if body.rims[0].len() == 4 { 2 } else { 1 };
    for pair in rings.windows(2) {
        let around = pair[0].len();
        for j in (0..around).step_by(step) {
            let k = (j + 1) % around;
            let [a, b, c, d] = [pair[0][j], pair[0][k], pair[1][k], pair[1][j]];
            into.faces.push(Face { corners: [a, b, c], sheet: false });
            into.faces.push(Face { corners: [a, c, d], sheet: false });
        }
    }
    let last = sections.len() - 1;
    for (i, sign) in [(0, -1.0), (last, 1.0)] {
        let normal = sign * sections[i].x();
        let cap: Vec<Vertex> = rings[i].iter().map(|vertex| Vertex { normal, ..*vertex }).collect();
        for pair in cap[1..].windows(2) {
            into.faces.push(Face { corners: [cap[0], pair[0], pair[1]], sheet: false });
        }
    }
}

fn draw_surfaces(run: &Run, measures: &Measures, state: &State<'_>, into: &mut Drawing) {
    let mut strip = 0;
    for (s, surface) in run.about.surfaces.iter().enumerate() {
        let circulation = |strip: usize| {
            if run.about.strips > 0 {
                tint(&colours::CIRCULATION, share(state.circulation(strip), measures.circulation_range()))
            } else {
                colours::SURFACE
            }
        };
        if let Some(aerofoil) = run.about.aerofoils[s].as_ref().filter(|_| skin::has_aerofoils(run)) {
            skin::draw_aerofoil(run, s, aerofoil, &|own| circulation(strip + own), state, into);
            strip += surface.columns - 1;
            continue;
        }
        let corner = |column: usize, edge: usize| state.corner(s, column, edge);
        let along = |column: usize, share: f64| {
            let (leading, trailing) = (corner(column, 0), corner(column, 1));
            leading + share * (trailing - leading)
        };
        let mut line = |ends: [Vector; 2]| {
            into.lines.push(Line { ends, rgb: colours::EDGE, opacity: LATTICE, width: 1.0 });
        };
        let panels = surface.panels.max(1);
        for column in 0..surface.columns {
            line([corner(column, 0), corner(column, 1)]);
            if column > 0 {
                for k in 0..=panels {
                    let share = k as f64 / panels as f64;
                    line([along(column - 1, share), along(column, share)]);
                }
            }
        }
        for column in 1..surface.columns {
            let rgb = circulation(strip);
            strip += 1;
            into.sheet([corner(column - 1, 0), corner(column, 0), corner(column, 1), corner(column - 1, 1)], rgb);
        }
    }
}

fn draw_wake(measures: &Measures, state: &State<'_>, into: &mut Drawing) {
    into.wake_opacity = WAKE;
    for wake in state.wakes() {
        for row in 0..wake.rows {
            for column in 1..wake.columns {
                let of = wake.circulation(row, column - 1);
                let rgb = tint(&colours::CIRCULATION, share(of, measures.circulation_range()));
                let corners = [(row, column - 1), (row, column), (row + 1, column), (row + 1, column - 1)];
                into.wake.push((corners.map(|(row, column)| wake.node(row, column)), rgb));
            }
        }
    }
}

/// Half length and radius of the symbol at the inner end of a body, derived from its section within limits of visibility.
fn mark_size(run: &Run, body: usize, width_m: f64) -> [f64; 2] {
    let rim = &run.about.bodies[body].rims[0];
    let [wide, high] = [0, 1].map(|i| rim.iter().map(|point| point[i].abs()).fold(0.0, f64::max));
    [(1.25 * wide).clamp(0.012 * width_m, 0.05 * width_m), (1.5 * high).clamp(0.005 * width_m, 0.014 * width_m)]
}

fn draw_hinge(run: &Run, hinge: &Hinge, width_m: f64, state: &State<'_>, into: &mut Drawing) {
    let [half, radius] = mark_size(run, hinge.body, width_m);
    let at = state.section(hinge.body, 0).at;
    let axis = state.axis(hinge).filter(|_| hinge.freedom.is_some());
    let Some(axis) = axis else {
        return solids::sphere(&mut into.faces, at, 1.6 * radius, colours::JOINT);
    };
    let (sides, radius_m) = if hinge.kind == "prismatic" { (4, 1.4 * radius) } else { (20, radius) };
    solids::tube(&mut into.faces, [at - half * axis, at + half * axis], [radius_m; 2], sides, colours::JOINT);
    if hinge.latch {
        let closed = hinge.freedom.is_some_and(|freedom| state.latched(freedom));
        let rgb = if closed { colours::LATCH_CLOSED } else { colours::LATCH_OPEN };
        for place in [-0.55, 0.55] {
            solids::torus(&mut into.faces, at + place * half * axis, axis, [1.35 * radius, 0.5 * radius], rgb);
        }
    }
}

/// Draws masses, and lines from the axes to parts with an offset.
fn draw_links(run: &Run, measures: &Measures, state: &State<'_>, into: &mut Drawing) {
    let mut links = Vec::new();
    for mass in &run.about.masses {
        let ends = state.mass(mass);
        // as a steel ball, within limits of visibility
        let ball_m = (mass.kg / (7800.0 * 4.19)).cbrt();
        let radius = ball_m.min(0.03 * measures.width_m).max(0.006 * measures.width_m);
        solids::sphere(&mut into.faces, ends[1], radius, colours::MASS);
        links.push(ends);
    }
    for (b, _) in run.about.bodies.iter().enumerate().filter(|(_, body)| body.rigid) {
        let hub = state.section(b, 0).at;
        let gauges = run.about.gauges.iter().enumerate().filter(|(_, gauge)| gauge.body == b);
        links.extend(gauges.map(|(i, _)| [hub, state.gauge(i)]));
        let surfaces = run.about.surfaces.iter().enumerate().filter(|(_, surface)| surface.body == b);
        links.extend(surfaces.map(|(i, _)| [hub, 0.5 * (state.corner(i, 0, 0) + state.corner(i, 0, 1))]));
    }
    let line = |ends| Line { ends, rgb: colours::EDGE, opacity: 1.0, width: 1.0 };
    into.lines.extend(links.into_iter().map(line));
}

/// Draws dashed paths of the outer ends up to the current time.
fn draw_paths(measures: &Measures, state: &State<'_>, into: &mut Drawing) {
    let (dash, gap) = (0.012 * measures.width_m, 0.009 * measures.width_m);
    let until = state.frame();
    let stride = until.div_ceil(PATH).max(1);
    for (body, path) in measures.paths.iter().enumerate() {
        let now = state.body_end(body);
        let mut points: Vec<Vector> = path[..=until].iter().step_by(stride).copied().collect();
        points.push(now);
        let mut gone = 0.0;
        for pair in points.windows(2) {
            let segment = pair[1] - pair[0];
            let length = segment.norm();
            if !(length > 0.0 && length < 1e3 * measures.width_m) {
                continue;
            }
            let mut from = 0.0;
            while from < length {
                let place: f64 = (gone + from) % (dash + gap);
                let to =
                    (from + if place < dash { dash - place } else { dash + gap - place }).max(from + 1e-9 * length);
                if place < dash {
                    let ends = [from, to.min(length)].map(|at| pair[0] + segment * (at / length));
                    into.lines.push(Line { ends, rgb: colours::ACCENT, opacity: 0.8, width: 1.0 });
                }
                from = to;
            }
            gone += length;
        }
    }
}

/// Draws arrows of gravity at the middle of the model and of the wind at the middle of every body; the longest is a fifth of the
/// model's size.
fn draw_arrows(run: &Run, measures: &Measures, state: &State<'_>, into: &mut Drawing) {
    let width_m = measures.width_m;
    let mut arrow = |at: Vector, value: Vector, most: f64, upstream: bool, rgb: Rgb| {
        let (size, Some(direction)) = (value.norm(), value.try_normalize(0.0)) else { return };
        if !(most > 1e-9 && size > 1e-6 * most) {
            return;
        }
        let length = 0.2 * width_m * size / most;
        let begin = if upstream { at - (length + 0.04 * width_m) * direction } else { at };
        let head = (0.05 * width_m).min(0.6 * length);
        let (radius, neck, tip) = (0.0035 * width_m, begin + (length - head) * direction, begin + length * direction);
        solids::tube(&mut into.arrows, [begin, neck], [radius; 2], 10, rgb);
        solids::tube(&mut into.arrows, [neck, tip], [3.2 * radius, 0.0], 14, rgb);
    };
    let count = run.about.bodies.len();
    let middle = (0..count).map(|body| state.middle_section(body).at).sum::<Vector>() / count as f64;
    arrow(middle, state.gravity_m_s2(), measures.gravity_m_s2, false, colours::GRAVITY);
    for body in 0..run.about.winds {
        let at = state.middle_section(body).at;
        arrow(at, state.wind_m_s(body), measures.wind_m_s, true, colours::WIND);
    }
}
