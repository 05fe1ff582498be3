//! Unsteady vortex lattice: geometry, boundary condition, circulation.
//!
//! Rings start at the quarter chord of a panel and end at the quarter chord of the next one; collocation points are at three quarters of
//! the panels. Normals and vector areas are those of the bilinear patches between quarter chords: the collocation point is the centre of
//! its patch, where the diagonals give the exact normal, also with bending and twist; section normals would have to be averaged. The last
//! rings end at the trailing edge; from there a row of rings with the same circulation extends along the path of the air to the position of
//! the youngest vorticity ([`rear_corner_m`]).
//!
//! Each surface has its own rings. If two surfaces share an edge (a hinge), the segments on it coincide, and cancel to the extent that
//! their circulations agree.

use crate::aero::biot_savart::{Arm, Block, Filaments, Kernel, LANES, Sheet, blocks};
use crate::aero::flow::Flow;
use crate::aero::hinged_panels::LatticeFlaps;
use crate::aero::images::{Plane, Stretch};
use crate::aero::lattice_profiles::LatticeProfiles;
use crate::aero::lattice_state::{LatticeState, SheetKind};
use crate::aero::linear_system::LinearSystem;
use crate::aero::near_sheets::{CrossedSheets, Facing, Gap};
use crate::aero::panel_forces::PanelForces;
use crate::aero::rear::rear_corner_m;
use crate::aero::surface::{JoinedEdges, Surface};
use crate::load::SectionMotion;
use nalgebra::Vector3;
use pulp::Arch;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Convection of the wake.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WakeModel {
    /// The wake moves with the undisturbed air, without gusts.
    Prescribed,
    /// The wake moves with the air and the velocities induced by all vortices.
    Free,
}

/// Method of computing forces from the circulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadRule {
    /// Pressure on the panels: no force along them, hence no leading-edge suction.
    Bernoulli,
    /// Kutta-Joukowski force on every bound segment, with leading-edge suction and induced drag.
    KuttaJoukowski,
}

/// Period of the updates of far rows of a free wake: each row is summed once in this number of steps and moves with that velocity in
/// between, so that all steps have the same amount of work. The error is of first order in the step, like that of the wake's path itself.
pub(super) const FAR_PERIOD: usize = 4;

/// Options of the lattice.
#[derive(Debug, Clone, PartialEq)]
pub struct LatticeOptions {
    /// Convection of the wake.
    pub wake: WakeModel,
    /// Number of wake rows, in addition to that of an established flow; older rows are merged into the last one.
    pub wake_rows: usize,
    /// Radius `δ` of the vortex core in m, positive, for both bound and wake vorticity.
    pub core_radius_m: f64,
    /// Method of computing forces from the circulation.
    pub load_rule: LoadRule,
    /// Unit normal of a mirror plane through the origin of the root frame.
    pub mirror_normal: Option<Vector3<f64>>,
    /// Ground plane, normal to the mirror plane, eq. (U23).
    pub ground: Option<Plane>,
    /// Speed of sound in m/s, for the Prandtl-Glauert rule, eq. (U22); incompressible without it.
    pub speed_of_sound_m_s: Option<f64>,
    /// Number of threads for induced velocities; the results are bit-identical for any number.
    pub threads: usize,
}

/// When the influence matrix is factorised in the solutions of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Factors {
    /// Factorise in the next solution: its result must not depend on earlier steps.
    Due,
    /// Do not factorise: the factors of the first motion are close enough.
    Kept,
    /// Factorise in each solution: the motions of this step are too far apart.
    OfEach,
}

/// Lattice over all surfaces of a wing, with its scratch. All history is in [`LatticeState`].
#[derive(Debug, Clone)]
pub struct VortexLattice {
    pub(super) surfaces: Vec<Surface>,
    pub(super) options: LatticeOptions,
    pub(super) kernel: Kernel,
    pub(super) arch: Arch,
    pool: Option<Arc<rayon::ThreadPool>>,
    /// Edges at which surfaces are joined.
    pub(super) joined: Vec<JoinedEdges>,
    /// Joined surfaces of which one passes through the other at their edges, as placed last.
    pub(super) crossed_edges: Option<CrossedSheets>,
    /// Points near another sheet, whose velocity is interpolated from above its control points.
    pub(super) facings: Vec<Facing>,
    /// Gaps between the sheets, for the points of the first above the second: `[index · surfaces + other]`.
    pub(super) gaps: Vec<Gap>,
    pub(super) facing_entries: Vec<f64>,
    pub(super) facing_sums: Vec<f64>,
    /// Bound sheets, one per surface: the rings of the panels, up to the trailing edge.
    pub(super) bound: Vec<Sheet>,
    /// Inducing sheets: the bound ones and the rings between trailing edge and wake, which have the circulation of the rings before them.
    pub(super) inducing: Vec<Sheet>,
    /// Wake sheets, one per surface.
    pub(super) wake: Vec<Sheet>,
    /// The rows of the wake sheets that currently induce.
    pub(super) wake_part: Vec<Sheet>,
    /// Index of the first bound ring of each surface in the equations.
    pub(super) first_panel: Vec<usize>,
    /// Numbers of nodes and of strips in a row of the wake.
    pub(super) wake_columns: usize,
    pub(super) wake_strips: usize,
    pub(super) bound_filaments: Filaments,
    pub(super) wake_filaments: Filaments,
    pub(super) corner_velocity_m_s: Vec<Vector3<f64>>,
    /// Velocity of the air relative to the surface at the collocation points in m/s.
    pub(super) relative_m_s: Vec<Vector3<f64>>,
    pub(super) points: Vec<Block>,
    pub(super) velocities: Vec<Block>,
    pub(super) normals: Vec<Block>,
    pub(super) panel_forces: PanelForces,
    pub(super) arms: Vec<Vec<Arm>>,
    pub(super) system: LinearSystem,
    /// Corners for which the matrix in `system` was built, if it exists.
    pub(super) matrix_corner_m: Vec<Vector3<f64>>,
    pub(super) built: bool,
    /// Corners for which the factors were computed, if they exist: the factors of the first motion of a step serve the others.
    pub(super) factored_corner_m: Vec<Vector3<f64>>,
    pub(super) flaps: LatticeFlaps,
    pub(super) profiles: LatticeProfiles,
    /// Angles of the control surfaces for which the matrix and the factors were computed.
    pub(super) matrix_angle_rad: Vec<f64>,
    pub(super) factored_angle_rad: Vec<f64>,
    /// Stretching for which the matrix and the factors were computed.
    pub(super) matrix_stretch: Option<Stretch>,
    pub(super) factored_stretch: Option<Stretch>,
    pub(super) factored: bool,
    pub(super) factors: Factors,
    /// Velocity in m/s at the nodes of a free wake in the current step.
    pub(super) free_m_s: Vec<Vector3<f64>>,
    /// Number of steps between two evaluations of the velocity of a far row of a free wake.
    pub(super) far_period: usize,
    pub(super) right: Vec<f64>,
    pub(super) solution: Vec<f64>,
}

impl VortexLattice {
    /// Creates a lattice with a strip between each pair of consecutive sections of a surface.
    pub fn new(surfaces: Vec<Surface>, options: LatticeOptions) -> Self {
        let (mut bound, mut wake, mut first_panel) = (Vec::new(), Vec::new(), Vec::new());
        let (mut corners, mut rings, mut panels, mut columns, mut strips) = (0, 0, 0, 0, 0);
        let all_strips: usize = surfaces.iter().map(Surface::strips).sum();
        let all_columns = all_strips + surfaces.len();
        for surface in &surfaces {
            let own = surface.strips();
            bound.push(Sheet {
                rows: surface.chord_panels,
                strips: own,
                first_node: corners,
                node_stride: own + 1,
                first_ring: rings,
                ring_stride: own,
                joined_rear: false,
            });
            wake.push(Sheet {
                rows: 0,
                strips: own,
                first_node: columns,
                node_stride: all_columns,
                first_ring: strips,
                ring_stride: all_strips,
                joined_rear: false,
            });
            first_panel.push(panels);
            // one row behind the trailing edge, and a spare one for the segments at its end
            corners += (surface.chord_panels + 2) * (own + 1);
            rings += (surface.chord_panels + 2) * own;
            panels += surface.panels();
            columns += own + 1;
            strips += own;
        }
        let suction = options.load_rule == LoadRule::KuttaJoukowski;
        // one row more than the wake keeps, for that of an established flow
        let wake_nodes = (options.wake_rows + 2) * columns;
        let widest = surfaces.iter().map(Surface::strips).max().unwrap_or(0) + 1;
        let threads = options.threads.max(1);
        let most_points = wake_nodes.max(rings + corners).max(panels);
        let pool = (threads > 1).then(|| rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok()).flatten();
        let segments = surfaces.iter().map(|surface| 2 * surface.panels() + surface.chord_panels).sum::<usize>();
        let others = surfaces.len().saturating_sub(1);
        let largest = surfaces.iter().map(Surface::panels).max().unwrap_or(0);
        let firsts = first_panel.iter().zip(&bound).map(|(panel, sheet): (_, &Sheet)| [*panel, sheet.first_ring]);
        let profiles = LatticeProfiles::new(&surfaces, firsts);
        Self {
            facings: Vec::with_capacity(others * if suction { segments } else { panels }),
            joined: Vec::new(),
            crossed_edges: None,
            gaps: vec![Gap::NONE; surfaces.len() * surfaces.len()],
            facing_entries: vec![0.0; LANES * largest],
            facing_sums: vec![0.0; largest],
            kernel: Kernel {
                core_squared_m2: options.core_radius_m * options.core_radius_m,
                mirror_normal: options.mirror_normal.map(|normal| normal.normalize()),
                ground: options.ground,
                stretch: None,
            },
            arch: Arch::new(),
            arms: vec![vec![Arm::default(); 2 * widest]; if pool.is_some() { threads } else { 1 }],
            pool: pool.map(Arc::new),
            bound_filaments: Filaments::new(rings, corners),
            wake_filaments: Filaments::new((options.wake_rows + 2) * strips, wake_nodes),
            corner_velocity_m_s: vec![Vector3::zeros(); corners],
            relative_m_s: vec![Vector3::zeros(); rings],
            points: vec![Block::default(); blocks(most_points)],
            velocities: vec![Block::default(); blocks(most_points)],
            normals: vec![Block::default(); blocks(panels)],
            panel_forces: PanelForces::new(panels, rings),
            system: LinearSystem::new(panels, blocks(panels) * LANES),
            matrix_corner_m: vec![Vector3::zeros(); corners],
            built: false,
            factored_corner_m: vec![Vector3::zeros(); corners],
            flaps: LatticeFlaps::default(),
            profiles,
            matrix_angle_rad: Vec::new(),
            factored_angle_rad: Vec::new(),
            matrix_stretch: None,
            factored_stretch: None,
            factored: false,
            factors: Factors::Due,
            free_m_s: vec![Vector3::zeros(); if options.wake == WakeModel::Free { wake_nodes } else { 0 }],
            far_period: FAR_PERIOD,
            right: vec![0.0; panels],
            solution: vec![0.0; panels],
            wake_columns: columns,
            wake_strips: strips,
            surfaces,
            options,
            inducing: bound.iter().map(|sheet| sheet.with_rear_row()).collect(),
            bound,
            wake_part: wake.clone(),
            wake,
            first_panel,
        }
    }

    /// Surfaces of the lattice.
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// Returns a state without circulation and wake.
    pub fn blank_state(&self) -> LatticeState {
        LatticeState {
            circulation_m2_s: vec![0.0; self.relative_m_s.len()],
            area_m2: vec![Vector3::zeros(); self.relative_m_s.len()],
            collocation_m: vec![Vector3::zeros(); self.relative_m_s.len()],
            surface_m_s: vec![Vector3::zeros(); self.relative_m_s.len()],
            far_wake_m_s: vec![Vector3::zeros(); self.relative_m_s.len()],
            corner_m: vec![Vector3::zeros(); self.corner_velocity_m_s.len()],
            wake_node_m: vec![Vector3::zeros(); (self.options.wake_rows + 2) * self.wake_columns],
            induced_m_s: vec![Vector3::zeros(); self.free_nodes()],
            unshed_steps: 0,
            wake_circulation_m2_s: vec![0.0; (self.options.wake_rows + 1) * self.wake_strips],
            wake_rows: 0,
            established: false,
            turning: false,
            edge_m: vec![Vector3::zeros(); self.wake_columns],
            edge_m_s: vec![Vector3::zeros(); self.wake_columns],
            left_m: vec![Vector3::zeros(); self.wake_columns],
            sheds: true,
            hinges: self.no_hinge_moments(),
            profile_m_s: vec![0.0; self.profiles.count()],
            lags: false,
            relative_m_s: Vector3::zeros(),
        }
    }

    /// Circulation at the trailing edge of a strip in m²/s, which is the circulation of the whole strip.
    pub fn strip_circulation(&self, state: &LatticeState, surface: usize, strip: usize) -> f64 {
        let sheet = &self.bound[surface];
        state.circulation_m2_s[sheet.ring(sheet.rows - 1, strip)]
    }

    /// Corner of a bound ring, root frame, m: row from the leading edge, column from the inner section. The last row but one is the
    /// trailing edge, the last row the start of the wake.
    pub fn corner_m(&self, state: &LatticeState, surface: usize, row: usize, column: usize) -> Vector3<f64> {
        state.corner_m[self.bound[surface].node(row, column)]
    }

    /// Node of the wake, root frame, m: row from the trailing edge, up to `state.wake_rows` inclusive.
    pub fn wake_node_m(&self, state: &LatticeState, surface: usize, row: usize, column: usize) -> Vector3<f64> {
        state.wake_node_m[self.wake[surface].node(row, column)]
    }

    /// Circulation of a wake ring in m²/s.
    pub fn wake_circulation_m2_s(&self, state: &LatticeState, surface: usize, row: usize, strip: usize) -> f64 {
        state.wake_circulation_m2_s[self.wake[surface].ring(row, strip)]
    }

    /// Normal force in N of a panel of a surface at the end of the step to `state`, positive along chord times span: steady part and rate of
    /// the impulse, without the corrections of profiles. `None` if the last solved step is another.
    pub fn panel_force_n(&self, state: &LatticeState, surface: usize, row: usize, strip: usize) -> Option<f64> {
        let panel = self.first_panel[surface] + row * self.bound[surface].strips + strip;
        self.panel_forces.belong_to(&state.circulation_m2_s).then(|| self.panel_forces.normal_n(panel))
    }

    /// Unit normal of a panel, numbered as in the equations.
    pub(super) fn panel_normal(&self, panel: usize) -> Vector3<f64> {
        self.normals[panel / LANES].get(panel % LANES)
    }

    /// Chordwise position of a row of corners as a fraction of the chord, eq. (U3): row `chord_panels` is the trailing edge.
    pub(super) fn chord_fraction(chord_panels: usize, row: usize) -> f64 {
        if row < chord_panels { (row as f64 + 0.25) / chord_panels as f64 } else { 1.0 }
    }

    /// Computes corners with their velocities, vector areas, collocation points and normals, and the first row of the wake.
    pub(super) fn place(&mut self, motions: &[SectionMotion], step: Option<(&Flow, f64)>, state: &mut LatticeState) {
        let mut panel = 0;
        for ((surface, sheet), wake) in self.surfaces.iter().zip(&self.bound).zip(&self.wake) {
            let section = |column: usize| (&motions[surface.sections.start + column], &surface.chords[column]);
            for column in 0..=sheet.strips {
                let (motion, chord) = section(column);
                let edge_m = motion.point_m(&chord.trailing_m);
                let edge_m_s = motion.point_velocity_m_s(&chord.trailing_m);
                for row in 0..=sheet.rows {
                    let (node, point_m) = (sheet.node(row, column), chord.at(Self::chord_fraction(sheet.rows, row)));
                    state.corner_m[node] = motion.point_m(&point_m);
                    self.corner_velocity_m_s[node] = motion.point_velocity_m_s(&point_m);
                }
                let moves = step.filter(|_| state.wake_rows > 0);
                let rear_m = moves.map_or(Vector3::zeros(), |(flow, step_s)| {
                    // gusts convect only a free wake, eq. (U5)
                    let air_m_s = match self.options.wake {
                        WakeModel::Prescribed => flow.convection_m_s(&edge_m),
                        WakeModel::Free => flow.velocity_m_s(&edge_m),
                    };
                    let panel_m = motion.rotation * (chord.trailing_m - chord.leading_m) / sheet.rows as f64;
                    rear_corner_m(&(step_s * (air_m_s - edge_m_s)), &panel_m)
                });
                let node = sheet.node(sheet.rows + 1, column);
                state.corner_m[node] = edge_m + rear_m;
                self.corner_velocity_m_s[node] = edge_m_s;
                state.wake_node_m[wake.node(0, column)] = state.corner_m[node];
                (state.edge_m[wake.node(0, column)], state.edge_m_s[wake.node(0, column)]) = (edge_m, edge_m_s);
            }
            for row in 0..sheet.rows {
                let front = Self::chord_fraction(sheet.rows, row);
                let middle = front + 0.5 / sheet.rows as f64;
                let back = front + 1.0 / sheet.rows as f64;
                for strip in 0..sheet.strips {
                    let ((inner, inner_chord), (outer, outer_chord)) = (section(strip), section(strip + 1));
                    let (inner_m, outer_m) = (inner_chord.at(middle), outer_chord.at(middle));
                    let inner_diagonal_m = outer.point_m(&outer_chord.at(back)) - inner.point_m(&inner_chord.at(front));
                    let outer_diagonal_m = inner.point_m(&inner_chord.at(back)) - outer.point_m(&outer_chord.at(front));
                    let area_m2 = 0.5 * inner_diagonal_m.cross(&outer_diagonal_m);
                    let ring = sheet.ring(row, strip);
                    state.area_m2[ring] = area_m2;
                    state.surface_m_s[ring] =
                        0.5 * (inner.point_velocity_m_s(&inner_m) + outer.point_velocity_m_s(&outer_m));
                    state.collocation_m[ring] = 0.5 * (inner.point_m(&inner_m) + outer.point_m(&outer_m));
                    let (block, lane) = (panel / LANES, panel % LANES);
                    self.points[block].set(lane, &state.collocation_m[ring]);
                    self.normals[block].set(lane, &area_m2.normalize());
                    panel += 1;
                }
            }
        }
        self.merge_edges(motions, state);
    }

    /// Computes the velocity of the air relative to the panels at their collocation points, with the wake and without bound vortices.
    ///
    /// [`convect`](Self::convect) has already summed the rows beyond [`NEAR_ROWS`](crate::aero::wake::NEAR_ROWS).
    pub(super) fn relative_velocity(&mut self, flow: &Flow, state: &LatticeState, near: Range<usize>) {
        let panels = self.right.len();
        self.gather_wake(state, near);
        self.velocities[..blocks(panels)].fill(Block::default());
        self.induce(panels, &state.wake_node_m, SheetKind::Wake);
        self.see_velocity(&state.wake_node_m, SheetKind::Wake);
        let mut panel = 0;
        for sheet in &self.bound {
            for row in 0..sheet.rows {
                for strip in 0..sheet.strips {
                    let (block, lane) = (panel / LANES, panel % LANES);
                    let air_m_s = flow.velocity_m_s(&self.points[block].get(lane)) + self.velocities[block].get(lane);
                    let ring = sheet.ring(row, strip);
                    self.relative_m_s[ring] = air_m_s + state.far_wake_m_s[ring] - state.surface_m_s[ring];
                    panel += 1;
                }
            }
        }
    }

    /// Computes the net circulations of the segments in some rows of the wake, which are the inducing rows from now on.
    pub(super) fn gather_wake(&mut self, state: &LatticeState, rows: Range<usize>) {
        for (whole, part) in self.wake.iter().zip(&mut self.wake_part) {
            *part = Sheet {
                rows: rows.len(),
                first_node: whole.node(rows.start, 0),
                first_ring: whole.ring(rows.start, 0),
                ..*whole
            };
            self.wake_filaments.gather(part, &state.wake_circulation_m2_s);
        }
    }

    /// Adds to `velocities` the velocity induced by bound or wake vortices with these nodes at the first `count` of `points`.
    pub(super) fn induce(&mut self, count: usize, nodes_m: &[Vector3<f64>], kind: SheetKind) {
        let (sheets, filaments) = match kind {
            SheetKind::Bound => (&self.inducing, &self.bound_filaments),
            SheetKind::Wake if self.wake_part.iter().all(|sheet| sheet.rows == 0) => return,
            SheetKind::Wake => (&self.wake_part, &self.wake_filaments),
        };
        let (kernel, used) = (&self.kernel, blocks(count));
        let (points, velocities) = (&self.points[..used], &mut self.velocities[..used]);
        let run = |points: &[Block], velocities: &mut [Block], arms: &mut [Arm]| {
            for (points_m, velocity_m_s) in points.iter().zip(velocities.iter_mut()) {
                kernel.induce(sheets, nodes_m, filaments, points_m, arms, velocity_m_s);
            }
        };
        match &self.pool {
            Some(pool) if used > 1 => {
                let share = used.div_ceil(self.arms.len());
                let parts = points.par_chunks(share).zip(velocities.par_chunks_mut(share)).zip(&mut self.arms);
                pool.install(|| parts.for_each(|((points, velocities), arms)| run(points, velocities, arms)));
            }
            _ => run(points, velocities, &mut self.arms[0]),
        }
    }
}
