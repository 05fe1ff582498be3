//! Loads of the lattice on the sections.
//!
//! Every force acts at a point of the lattice that is fixed to a section, or at the mean of two such points: the power of the loads on the
//! sections equals the power on the lattice to round-off.

use crate::aero::biot_savart::{Block, LANES, Sheet, blocks};
use crate::aero::flow::{AirPath, Flow};
use crate::aero::lattice::{LoadRule, VortexLattice};
use crate::aero::lattice_state::{LatticeState, SheetKind};
use crate::aero::panel_forces::PanelForces;
use crate::aero::{AirLoads, split_between};
use crate::load::SectionMotion;
use nalgebra::Vector3;

/// Length on the body, in panel chords, of the rings and patches of a row, which start at quarter chords: those of the last row end at the
/// trailing edge.
fn part_on_body(rows: usize, row: usize) -> f64 {
    if row + 1 == rows { 0.75 } else { 1.0 }
}

/// Computes the circulatory loads from circulation and velocities at the end of the step, by Bernoulli's equation, eq. (U6), or the
/// Kutta-Joukowski theorem, eq. (U7).
pub(super) fn circulatory(
    lattice: &mut VortexLattice,
    motions: &[SectionMotion],
    flow: &Flow,
    state: &mut LatticeState,
    loads: &mut AirLoads,
) {
    match lattice.options.load_rule {
        LoadRule::Bernoulli => panel_velocity(lattice, state),
        LoadRule::KuttaJoukowski => segment_velocity(lattice, flow, state),
    }
    sum(lattice, motions, flow.density_kg_m3, state, loads);
    lattice.panel_forces.settle(&state.circulation_m2_s);
}

/// Sums the circulatory loads from the circulations and velocities stored in the lattice.
pub(super) fn sum(
    lattice: &mut VortexLattice,
    motions: &[SectionMotion],
    density: f64,
    state: &mut LatticeState,
    loads: &mut AirLoads,
) {
    let mut panel = 0;
    let mut segment = 0;
    let flaps = &lattice.flaps;
    let mut hinges = std::mem::take(&mut state.hinges);
    let mut panel_forces = std::mem::take(&mut lattice.panel_forces);
    panel_forces.clear();
    for (at, (surface, sheet)) in lattice.surfaces.iter().zip(&lattice.bound).enumerate() {
        let first = surface.sections.start;
        let point_m = |column: usize, place_m: &Vector3<f64>| motions[first + column].point_m(place_m);
        let corner = |row, column| state.corner_m[sheet.node(row, column)];
        for row in 0..sheet.rows {
            let front = VortexLattice::chord_fraction(sheet.rows, row);
            let part = part_on_body(sheet.rows, row);
            let middle = front + 0.5 * part / sheet.rows as f64;
            for strip in 0..sheet.strips {
                let spanwise_m = corner(row, strip + 1) - corner(row, strip);
                let lead = lattice.bound_filaments.spanwise[sheet.ring(row, strip)] * spanwise_m;
                let lead_points = [&surface.chords[strip].at(front), &surface.chords[strip + 1].at(front)];
                let sections = [first + strip, first + strip + 1];
                let flap = flaps.of_panel(panel);
                let lead_m = 0.5 * (point_m(strip, lead_points[0]) + point_m(strip + 1, lead_points[1]));
                let project = |velocity: Vector3<f64>, vortex: &Vector3<f64>, normal: Option<Vector3<f64>>| {
                    let force_n = density * velocity.cross(vortex);
                    normal.map_or(force_n, |normal| normal * normal.dot(&force_n))
                };
                match lattice.options.load_rule {
                    LoadRule::Bernoulli => {
                        let ring = sheet.ring(row, strip);
                        let normal = Some(lattice.normals[panel / LANES].get(panel % LANES));
                        let bound_m_s = lattice.velocities[panel / LANES].get(panel % LANES);
                        let velocity = lattice.relative_m_s[ring] + bound_m_s;
                        let force_n = project(velocity, &lead, normal);
                        split_between(&mut loads.circulatory, motions, sections, lead_points, &force_n);
                        panel_forces.add(panel, -lattice.panel_normal(panel).dot(&force_n));
                        if let Some(flap) = flap {
                            hinges[flap].circulatory_n_m += flaps.moment_n_m(at, strip, &lead_m, &force_n);
                        }
                        for column in [strip, strip + 1] {
                            let tip = column == 0 || column == sheet.strips;
                            let share = if tip { 1.0 } else { 0.5 };
                            let chordwise_m = corner(row + 1, column) - corner(row, column);
                            let vortex =
                                share * lattice.bound_filaments.chordwise[sheet.node(row, column)] * chordwise_m;
                            let force_n = project(velocity, &vortex, normal);
                            panel_forces.add(panel, -lattice.panel_normal(panel).dot(&force_n));
                            let motion = &motions[first + column];
                            let arm_m = motion.rotation * surface.chords[column].at(middle);
                            loads.circulatory[first + column].add_force_at(&arm_m, &force_n);
                            if let Some(flap) = flap {
                                let place_m = motion.position_m + arm_m;
                                hinges[flap].circulatory_n_m += flaps.moment_n_m(at, strip, &place_m, &force_n);
                            }
                        }
                    }
                    LoadRule::KuttaJoukowski => {
                        let velocity = lattice.velocities[segment / LANES].get(segment % LANES);
                        let force_n = project(velocity, &lead, None);
                        split_between(&mut loads.circulatory, motions, sections, lead_points, &force_n);
                        panel_forces.add(panel, -lattice.panel_normal(panel).dot(&force_n));
                        if let Some(flap) = flap {
                            hinges[flap].circulatory_n_m += flaps.moment_n_m(at, strip, &lead_m, &force_n);
                        }
                        segment += 1;
                    }
                }
                panel += 1;
            }
            if lattice.options.load_rule == LoadRule::KuttaJoukowski {
                for column in 0..=sheet.strips {
                    let velocity = lattice.velocities[segment / LANES].get(segment % LANES);
                    let chordwise_m = corner(row + 1, column) - corner(row, column);
                    let circulation = lattice.bound_filaments.chordwise[sheet.node(row, column)];
                    let vortex = circulation * chordwise_m;
                    let arm_m = motions[first + column].rotation * surface.chords[column].at(middle);
                    let force_n = density * velocity.cross(&vortex);
                    loads.circulatory[first + column].add_force_at(&arm_m, &force_n);
                    // one half to each of the adjacent strips
                    for strip in [column.wrapping_sub(1), column] {
                        let beside = if column == 0 || column == sheet.strips { 1.0 } else { 0.5 };
                        if strip < sheet.strips {
                            let of = lattice.first_panel[at] + row * sheet.strips + strip;
                            panel_forces.add(of, -beside * lattice.panel_normal(of).dot(&force_n));
                        }
                        if let Some(flap) = flaps.of_strip(at, row, strip, sheet.rows) {
                            let place_m = motions[first + column].position_m + arm_m;
                            let own_n_m = flaps.moment_n_m(at, strip, &place_m, &force_n);
                            hinges[flap].circulatory_n_m += beside * own_n_m;
                        }
                    }
                    segment += 1;
                }
            }
        }
    }
    state.hinges = hinges;
    lattice.panel_forces = panel_forces;
    if lattice.options.load_rule == LoadRule::KuttaJoukowski {
        lattice.join_loads(motions, density, state, loads);
    }
    lattice.profile_loads(density, state, loads);
}

/// Computes the impulsive loads: rate of the bound rings' impulse over the step at constant vector areas, eq. (U8). The areas at its start
/// are fixed in the air, which turns relative to a rotating root frame.
pub(super) fn impulsive(
    lattice: &VortexLattice,
    motions: &[SectionMotion],
    flow: &Flow,
    step_s: f64,
    (from, to): (&LatticeState, &mut LatticeState),
    loads: &mut AirLoads,
    mut panel_forces: Option<&mut PanelForces>,
) {
    let path = AirPath::new(flow, step_s);
    for (at, (surface, sheet)) in lattice.surfaces.iter().zip(&lattice.bound).enumerate() {
        for row in 0..sheet.rows {
            let part = part_on_body(sheet.rows, row);
            let middle = VortexLattice::chord_fraction(sheet.rows, row) + 0.5 * part / sheet.rows as f64;
            for strip in 0..sheet.strips {
                let ring = sheet.ring(row, strip);
                let area_m2 = 0.5 * part * (path.turned(&from.area_m2[ring]) + to.area_m2[ring]);
                let rate_m2_s2 = (to.circulation_m2_s[ring] - from.circulation_m2_s[ring]) / step_s;
                let first = surface.sections.start + strip;
                let points = [&surface.chords[strip].at(middle), &surface.chords[strip + 1].at(middle)];
                let force_n = -flow.density_kg_m3 * rate_m2_s2 * area_m2;
                split_between(&mut loads.impulsive, motions, [first, first + 1], points, &force_n);
                let panel = lattice.first_panel[at] + row * sheet.strips + strip;
                if let Some(panel_forces) = &mut panel_forces {
                    panel_forces.add(panel, -lattice.panel_normal(panel).dot(&force_n));
                }
                if let Some(flap) = lattice.flaps.of_panel(panel) {
                    let point_m = 0.5 * (motions[first].point_m(points[0]) + motions[first + 1].point_m(points[1]));
                    to.hinges[flap].impulsive_n_m += lattice.flaps.moment_n_m(at, strip, &point_m, &force_n);
                }
            }
        }
    }
}

/// Computes the velocity induced by the bound vortices at the collocation points, which must still be in `points`: on a bent or folded wing
/// it has a component along the panels.
fn panel_velocity(lattice: &mut VortexLattice, state: &LatticeState) {
    let panels: usize = lattice.bound.iter().map(|sheet| sheet.rows * sheet.strips).sum();
    lattice.velocities[..blocks(panels)].fill(Block::default());
    lattice.induce(panels, &state.corner_m, SheetKind::Bound);
    lattice.see_velocity(&state.corner_m, SheetKind::Bound);
}

/// Computes the velocity of the air relative to the surface, including all induced velocities, at the midpoints of all bound segments: row
/// by row the leading segments of the rings, then the chordwise ones.
fn segment_velocity(lattice: &mut VortexLattice, flow: &Flow, state: &LatticeState) {
    let mut count = 0;
    for at in 0..lattice.bound.len() {
        let sheet = lattice.bound[at];
        for_each_segment(&sheet, |from, to| {
            let middle_m = 0.5 * (state.corner_m[from] + state.corner_m[to]);
            lattice.points[count / LANES].set(count % LANES, &middle_m);
            count += 1;
        });
    }
    lattice.velocities[..blocks(count)].fill(Block::default());
    lattice.look_from_segments(state);
    lattice.induce(count, &state.corner_m, SheetKind::Bound);
    lattice.see_velocity(&state.corner_m, SheetKind::Bound);
    lattice.gather_wake(state, 0..state.wake_rows);
    lattice.induce(count, &state.wake_node_m, SheetKind::Wake);
    lattice.see_velocity(&state.wake_node_m, SheetKind::Wake);
    count = 0;
    for at in 0..lattice.bound.len() {
        let sheet = lattice.bound[at];
        for_each_segment(&sheet, |from, to| {
            let (block, lane) = (count / LANES, count % LANES);
            let surface_m_s = 0.5 * (lattice.corner_velocity_m_s[from] + lattice.corner_velocity_m_s[to]);
            let air_m_s = flow.velocity_m_s(&lattice.points[block].get(lane)) + lattice.velocities[block].get(lane);
            lattice.velocities[block].set(lane, &(air_m_s - surface_m_s));
            count += 1;
        });
    }
}

/// Visits the nodes of every segment that carries a force, in the order in which the loads are summed.
fn for_each_segment(sheet: &Sheet, mut visit: impl FnMut(usize, usize)) {
    for row in 0..sheet.rows {
        (0..sheet.strips).for_each(|strip| visit(sheet.node(row, strip), sheet.node(row, strip + 1)));
        (0..=sheet.strips).for_each(|column| visit(sheet.node(row, column), sheet.node(row + 1, column)));
    }
}
