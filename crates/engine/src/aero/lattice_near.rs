//! Near-field correction, eq. (U11): for a point close to a sheet, the velocity of its lines is replaced by that of a continuous sheet.

use crate::aero::biot_savart::{LANES, Sheet};
use crate::aero::lattice::VortexLattice;
use crate::aero::lattice_state::{LatticeState, SheetKind};
use crate::aero::near_sheets::{ClosedSheets, CrossedSheets, Facing, Gap, Looking};
use crate::load::SectionMotion;
use nalgebra::Vector3;

/// Bounding box of a sheet, enlarged on all sides by the size of its largest panel.
struct Surroundings {
    low_m: Vector3<f64>,
    high_m: Vector3<f64>,
}

impl Surroundings {
    fn of(sheet: &Sheet, state: &LatticeState) -> Self {
        let corner = |row, column| state.corner_m[sheet.node(row, column)];
        let (mut low_m, mut high_m) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        let mut panel_m = 0.0_f64;
        for column in 0..=sheet.strips {
            for row in [0, sheet.rows] {
                low_m = low_m.inf(&corner(row, column));
                high_m = high_m.sup(&corner(row, column));
            }
            let chord_m = (corner(sheet.rows, column) - corner(0, column)).norm() / (sheet.rows as f64 - 0.25);
            panel_m = panel_m.max(chord_m);
            if column > 0 {
                panel_m = panel_m.max((corner(0, column) - corner(0, column - 1)).norm());
            }
        }
        let margin_m = Vector3::repeat(panel_m);
        Self { low_m: low_m - margin_m, high_m: high_m + margin_m }
    }

    fn contain(&self, point_m: &Vector3<f64>) -> bool {
        (0..3).all(|axis| self.low_m[axis] <= point_m[axis] && point_m[axis] <= self.high_m[axis])
    }
}

impl VortexLattice {
    /// Places the lattice for sections without velocity and measures the gaps, which [`gap`](Self::gap) then returns.
    pub fn measure_gaps(&mut self, motions: &[SectionMotion], state: &mut LatticeState) {
        self.place(motions, None, state);
        self.look_from_panels(state);
    }

    /// Finds the sheets close to each collocation point and measures the gaps.
    pub(super) fn look_from_panels(&mut self, state: &LatticeState) {
        self.facings.clear();
        self.gaps.fill(Gap::NONE);
        for other in 0..self.bound.len() {
            let near = Surroundings::of(&self.bound[other], state);
            let mut point = 0;
            for own in 0..self.bound.len() {
                let sheet = self.bound[own];
                for ring in sheet.first_ring..sheet.ring(sheet.rows, 0) {
                    let point_m = state.collocation_m[ring];
                    if own != other && near.contain(&point_m) {
                        let looking = Looking { point, point_m, normal: state.area_m2[ring].normalize() };
                        self.look([own, other], state, &looking);
                    }
                    point += 1;
                }
            }
        }
    }

    /// Finds the sheets close to the midpoint of each segment that carries a force, in the order of `points`.
    pub(super) fn look_from_segments(&mut self, state: &LatticeState) {
        self.facings.clear();
        for other in 0..self.bound.len() {
            let near = Surroundings::of(&self.bound[other], state);
            let mut point = 0;
            for own in 0..self.bound.len() {
                let sheet = self.bound[own];
                for row in 0..sheet.rows {
                    let corner = |row, column| state.corner_m[sheet.node(row, column)];
                    for at in 0..2 * sheet.strips + 1 {
                        // spanwise segments first, then chordwise ones
                        let (column, to) = match at.checked_sub(sheet.strips) {
                            None => (at, [row, at + 1]),
                            Some(column) => (column, [row + 1, column]),
                        };
                        let point_m = 0.5 * (corner(row, column) + corner(to[0], to[1]));
                        let joined = at >= sheet.strips && self.is_joined(own, column, other);
                        if own != other && !joined && near.contain(&point_m) {
                            let ring = sheet.ring(row, column.min(sheet.strips - 1));
                            let looking = Looking { point, point_m, normal: state.area_m2[ring].normalize() };
                            self.look([own, other], state, &looking);
                        }
                        point += 1;
                    }
                }
            }
        }
    }

    /// Tests one point of a sheet for its distance to another sheet.
    fn look(&mut self, [own, other]: [usize; 2], state: &LatticeState, looking: &Looking) {
        let sheet = &self.bound[other];
        let gap = &mut self.gaps[own * self.bound.len() + other];
        self.facings.extend(Facing::look((other, sheet), state, looking, gap));
    }

    /// Gap between the points of one sheet and another sheet, as of the last start or solution.
    pub fn gap(&self, own: usize, other: usize) -> Gap {
        self.gaps[own * self.bound.len() + other]
    }

    /// First pair of closed sheets, if any.
    pub(super) fn closed_sheets(&self) -> Option<ClosedSheets> {
        let count = self.bound.len();
        let closed = self.gaps.iter().enumerate().find(|(_, gap)| gap.is_closed());
        closed.map(|(at, gap)| ClosedSheets {
            surfaces: [at / count, at % count],
            gap_m: gap.widest_m,
            gap_panels: gap.panels[1],
        })
    }

    /// First pair of sheets of which one passes through the other, as of the last start or solution.
    pub fn crossed_sheets(&self) -> Option<CrossedSheets> {
        let count = self.bound.len();
        let crossed = self.gaps.iter().enumerate().find(|(_, gap)| gap.is_crossed());
        crossed.map(|(at, gap)| CrossedSheets {
            surfaces: [at / count, at % count],
            depth_m: gap.sides_m[0].min(gap.sides_m[1]),
        })
    }

    /// Writes the near-field correction of the influence of bound vortices at the collocation points to the matrix, which must be zero. The
    /// rings of an established wake are merged with the last ones of the sheets and added later by direct evaluation, so that only their
    /// correction is added here.
    pub(super) fn see_influence(&mut self, state: &LatticeState, established: bool) {
        let (kernel, system) = (&self.kernel, &mut self.system);
        let (facings, entries, sums) = (&self.facings, &mut self.facing_entries, &mut self.facing_sums);
        let (bound, wakes, firsts, normals) = (&self.bound, &self.wake, &self.first_panel, &self.normals);
        let inducing = &self.inducing;
        let arms = &mut self.arms[0];
        for facing in facings {
            let (sheet, wake, first) = (&bound[facing.sheet], &wakes[facing.sheet], firsts[facing.sheet]);
            let sums = &mut sums[..sheet.rows * sheet.strips];
            let normal = normals[facing.point / LANES].get(facing.point % LANES);
            let of = |row: usize| row.min(sheet.rows - 1) * sheet.strips;
            sums.fill(0.0);
            facing.influence(kernel, &inducing[facing.sheet], &state.corner_m, &normal, arms, entries, sums, of);
            for (ring, sum) in sums.iter().enumerate() {
                let direct = system.get(facing.point, first + ring);
                system.add(facing.point, first + ring, facing.share * (sum - direct));
            }
            if established && facing.wake_share > 0.0 {
                let of = |_: usize| of(sheet.rows - 1);
                sums.fill(0.0);
                facing.influence(kernel, wake, &state.wake_node_m, &normal, arms, entries, sums, of);
                sums.iter_mut().for_each(|sum| *sum = -*sum);
                facing.direct().influence(kernel, wake, &state.wake_node_m, &normal, arms, entries, sums, of);
                for (ring, sum) in sums.iter().enumerate() {
                    system.add(facing.point, first + ring, -facing.wake_share * sum);
                }
            }
        }
    }

    /// Adds the near-field correction of bound or wake vortices to `velocities`.
    pub(super) fn see_velocity(&mut self, nodes_m: &[Vector3<f64>], kind: SheetKind) {
        let (sheets, filaments) = match kind {
            SheetKind::Bound => (&self.inducing, &self.bound_filaments),
            SheetKind::Wake if self.wake_part.iter().all(|sheet| sheet.rows == 0) => return,
            SheetKind::Wake => (&self.wake_part, &self.wake_filaments),
        };
        let (kernel, facings, velocities) = (&self.kernel, &self.facings, &mut self.velocities);
        let arms = &mut self.arms[0];
        for facing in facings {
            let sheet = &sheets[facing.sheet];
            let share = if kind == SheetKind::Wake { facing.wake_share } else { facing.share };
            if share <= 0.0 {
                continue;
            }
            let more_m_s = share * facing.correction_m_s(kernel, sheet, nodes_m, filaments, arms);
            let (block, lane) = (facing.point / LANES, facing.point % LANES);
            let sum_m_s = velocities[block].get(lane) + more_m_s;
            velocities[block].set(lane, &sum_m_s);
        }
    }
}
