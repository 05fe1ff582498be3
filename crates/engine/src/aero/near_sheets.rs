//! Near-field interpolation: points close to another sheet use the velocity that it induces above its control points.
//!
//! The lattice concentrates the vorticity of a panel in lines. At a point closer to another sheet than the spacing of its lines, the
//! induced velocity is that of discrete lines instead of a continuous sheet: the error is `e^(−2πh/d)` at the height `h` above lines with
//! the spacing `d`, times a factor that vanishes above the control points, where the sum over the lines equals the sheet's velocity at any
//! height. The velocity is therefore evaluated above the control points and interpolated along the sheet to the point, eq. (U11).

use crate::aero::biot_savart::{Arm, Block, Filaments, Kernel, LANES, Sheet};
use crate::aero::lattice_state::LatticeState;
use crate::aero::linear_system::SingularLattice;
use nalgebra::Vector3;

/// Heights relative to the panel size: up to the first, velocities are interpolated from above the control points; from the second, they
/// are evaluated directly; between them both are blended. At 0.8 panels the error of the lines is below 1 %.
const NEAR_PANELS: [f64; 2] = [0.4, 0.8];
/// Cosines of 30° and 15°, angles between two sheets that bound the blend: interpolation assumes points at equal heights above the sheet,
/// which does not hold for sheets that cross at a larger angle.
const PARALLEL: [f64; 2] = [0.866_025_403_784_438_6, 0.965_925_826_289_068_3];
/// Fraction of a panel within which a point outside an edge of the sheet is treated as above it.
const EDGE_PANELS: f64 = 0.25;
/// Largest gap height relative to the panel size for which a pair of sheets counts as closed, see [`ClosedSheets`].
pub const CLOSED_PANELS: f64 = 0.07;
/// Height relative to the panel size: a sheet with points higher than this on both sides of another one passes through it. It exceeds the
/// effect of bending on points next to a common hinge and is far below the resolution of a lattice.
pub(super) const CROSSED_PANELS: f64 = 0.02;
/// Number of control points in each direction used by the interpolation.
const ORDER: usize = 4;
/// Number of blocks for the interpolation points.
const BLOCKS: usize = ORDER * ORDER / LANES;
/// Interpolation weight below which a point is omitted: far below every tolerance.
const NOTHING: f64 = 1e-13;

/// Two sheets whose distance is everywhere smaller than the lattice can resolve.
///
/// The flow in the gap determines the difference of the two circulations by a term proportional to the gap height, whereas the errors of
/// the lattice do not decrease with it. If even the widest gap between the sheets is below [`CLOSED_PANELS`], the error of the moment about
/// the hinge exceeds a tenth of lift times lever arm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosedSheets {
    /// Indices of the surfaces.
    pub surfaces: [usize; 2],
    /// Largest height of the gap in m.
    pub gap_m: f64,
    /// Largest height of the gap relative to the size of the panels there.
    pub gap_panels: f64,
}

/// Two sheets, one of which passes through the other, so that air would flow through them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossedSheets {
    /// Indices of the surfaces.
    pub surfaces: [usize; 2],
    /// Largest distances of points of the first sheet from the second, on its two sides, in m: the smaller of the two.
    pub depth_m: f64,
}

/// A strip at Mach 1 or beyond.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sonic {
    /// Index of the surface.
    pub surface: usize,
    /// Index of its strip, counted from the inner end.
    pub strip: usize,
    /// Mach number.
    pub mach: f64,
}

/// Reason why the lattice has no solution.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoCirculation {
    /// The linear equations of the lattice are singular.
    #[error(transparent)]
    Singular(#[from] SingularLattice),
    /// Two sheets are closer to each other than the lattice can resolve.
    #[error("{0:?}")]
    Closed(ClosedSheets),
    /// Two joined sheets overlap at their joint: their edges are further apart than the lattice can merge.
    #[error("{0:?}")]
    Overlapping(CrossedSheets),
    /// A strip reaches Mach 1, where the Prandtl-Glauert rule ends.
    #[error("Mach {:.3} at a surface", .0.mach)]
    Sonic(Sonic),
    /// A part of the surface with this index is below the ground.
    #[error("a part of a surface is below the ground")]
    BelowGround(usize),
    /// No circulation satisfies the profile lift of all strips; index of the surface with the largest error.
    #[error("no circulation satisfies the profiles of all strips")]
    Profile(usize),
}

impl NoCirculation {
    /// The same reason with other indices of the surfaces.
    pub fn with_surfaces(self, index: impl Fn(usize) -> usize) -> Self {
        match self {
            Self::Singular(_) => self,
            Self::Closed(closed) => Self::Closed(ClosedSheets { surfaces: closed.surfaces.map(index), ..closed }),
            Self::Overlapping(crossed) => {
                Self::Overlapping(CrossedSheets { surfaces: crossed.surfaces.map(index), ..crossed })
            }
            Self::Sonic(sonic) => Self::Sonic(Sonic { surface: index(sonic.surface), ..sonic }),
            Self::BelowGround(surface) => Self::BelowGround(index(surface)),
            Self::Profile(surface) => Self::Profile(index(surface)),
        }
    }
}

/// A point that is close to another sheet, whose velocity is interpolated from above its control points.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Facing {
    /// Index of the point in the list of points.
    pub point: usize,
    /// Index of the other sheet.
    pub sheet: usize,
    /// Weight of the interpolated velocity; the direct one has the rest.
    pub share: f64,
    /// Weight for the wake of that sheet, which starts aft of most of its points.
    pub wake_share: f64,
    point_m: Vector3<f64>,
    used: usize,
    places: [Block; BLOCKS],
    weights: [[f64; LANES]; BLOCKS],
}

/// A point to be tested for sheets close to it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Looking {
    /// Index of the point in the list of points.
    pub point: usize,
    /// Position, root frame, m.
    pub point_m: Vector3<f64>,
    /// Unit normal of the sheet that the point belongs to.
    pub normal: Vector3<f64>,
}

/// Position of a point above another sheet.
struct Above {
    /// Position in units of panels: row from the foremost quarter chord, column from the inner section; control points are at `i + ½`.
    place: [f64; 2],
    height_m: Vector3<f64>,
    /// Unit normal of the sheet there.
    normal: Vector3<f64>,
    panel_m: f64,
    /// Chord of the panel in m.
    chord_m: f64,
    /// Degree, from 0 to 1, to which the point is above the sheet and its sheet parallel to it.
    share: f64,
}

/// Smooth ramp from 0 to 1 between two positions, with zero slope at both.
pub(super) fn ramp(from: f64, to: f64, x: f64) -> f64 {
    let part = ((x - from) / (to - from)).clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}

/// Weight of interpolation as a function of the distance in panels: 1 where sheets are too close to resolve.
fn nearness(panels: f64) -> f64 {
    1.0 - ramp(NEAR_PANELS[0], NEAR_PANELS[1], panels)
}

/// First control point and weights of the interpolation at a position among `count` control points at `i + ½`. Beyond the first and the
/// last one their values are used, because velocities at the edges of a sheet are not polynomials.
fn interpolation(place: f64, count: usize) -> (usize, usize, [f64; ORDER]) {
    let used = count.min(ORDER);
    let x = (place - 0.5).clamp(0.0, (count - 1) as f64);
    let first = (x.floor() - (used as f64 / 2.0 - 1.0).floor()).clamp(0.0, (count - used) as f64);
    let mut weights = [0.0; ORDER];
    for (k, weight) in weights.iter_mut().enumerate().take(used) {
        let node = |k: usize| first + k as f64;
        *weight = (0..used).filter(|m| *m != k).map(|m| (x - node(m)) / (node(k) - node(m))).product();
    }
    (first as usize, used, weights)
}

/// Corner and chord of a panel at a column of a sheet, root frame, m.
fn column(sheet: &Sheet, state: &LatticeState, row: usize, column: usize) -> [Vector3<f64>; 2] {
    let corner = |row| state.corner_m[sheet.node(row, column)];
    let chord_m = (corner(sheet.rows) - corner(0)) / (sheet.rows as f64 - 0.25);
    [corner(row), chord_m]
}

/// Finds a point's position above a sheet by the foot of its perpendicular on the panel with the nearest control point.
fn above(sheet: &Sheet, state: &LatticeState, looking: &Looking) -> Option<Above> {
    let controls_m = &state.collocation_m[sheet.first_ring..][..sheet.rows * sheet.strips];
    let mut nearest = 0;
    let mut least_m2 = f64::INFINITY;
    for (ring, control_m) in controls_m.iter().enumerate() {
        let distance_m2 = (control_m - looking.point_m).norm_squared();
        if distance_m2 < least_m2 {
            (nearest, least_m2) = (ring, distance_m2);
        }
    }
    let [row, strip] = [nearest / sheet.strips, nearest % sheet.strips];
    let [inner_m, inner_chord_m] = column(sheet, state, row, strip);
    let [outer_m, outer_chord_m] = column(sheet, state, row, strip + 1);
    let (mut across, mut along) = (0.5, 0.5);
    let mut height_m = Vector3::zeros();
    let (mut across_m, mut along_m) = (Vector3::zeros(), Vector3::zeros());
    // Newton's method for the foot of the perpendicular on a bilinear patch; flat panels need one step
    for _ in 0..4 {
        across_m = outer_m - inner_m + (outer_chord_m - inner_chord_m) * along;
        along_m = inner_chord_m + (outer_chord_m - inner_chord_m) * across;
        let base_m = inner_m + (outer_m - inner_m) * across + along_m * along;
        height_m = looking.point_m - base_m;
        let (a, b, c) = (across_m.norm_squared(), across_m.dot(&along_m), along_m.norm_squared());
        let (u, v) = (across_m.dot(&height_m), along_m.dot(&height_m));
        let determinant = a * c - b * b;
        if determinant <= 0.0 {
            return None;
        }
        across += (c * u - b * v) / determinant;
        along += (a * v - b * u) / determinant;
    }
    let normal = across_m.cross(&along_m).normalize();
    let place = [row as f64 + along, strip as f64 + across];
    let side = |x: f64| ramp(-EDGE_PANELS, EDGE_PANELS, x);
    // the sheet extends from a quarter panel in front of the foremost corners to a quarter panel in front of the last ones
    let on_sheet = side(place[0] + 0.25)
        * side(sheet.rows as f64 - 0.25 - place[0])
        * side(place[1])
        * side(sheet.strips as f64 - place[1]);
    Some(Above {
        place,
        height_m,
        normal,
        panel_m: across_m.norm().max(along_m.norm()),
        chord_m: along_m.norm(),
        share: on_sheet * ramp(PARALLEL[0], PARALLEL[1], normal.dot(&looking.normal).abs()),
    })
}

/// Gap between a sheet and the points of another one: smallest and largest heights of the points above it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Gap {
    /// Smallest and largest height relative to the panel size; infinite and 0 if no point is above the sheet.
    pub panels: [f64; 2],
    /// Largest height in m.
    pub widest_m: f64,
    /// Largest heights on the two sides of the sheet, opposite to its normal and along it, relative to the panel size; 0 without a point on
    /// that side.
    pub sides_panels: [f64; 2],
    /// Largest heights on the two sides in m.
    pub sides_m: [f64; 2],
}

impl Gap {
    /// The gap when no point is above the sheet.
    pub const NONE: Self =
        Self { panels: [f64::INFINITY, 0.0], widest_m: 0.0, sides_panels: [0.0; 2], sides_m: [0.0; 2] };

    fn include(&mut self, above: &Above) {
        let height_m = above.height_m.norm();
        let panels = height_m / above.panel_m;
        self.panels[0] = self.panels[0].min(panels);
        if panels > self.panels[1] {
            (self.panels[1], self.widest_m) = (panels, height_m);
        }
        let side = usize::from(above.height_m.dot(&above.normal) > 0.0);
        self.sides_panels[side] = self.sides_panels[side].max(panels);
        self.sides_m[side] = self.sides_m[side].max(height_m);
    }

    /// Whether there are points on both sides of the sheet, see [`CrossedSheets`].
    pub fn is_crossed(&self) -> bool {
        self.sides_panels.iter().all(|panels| *panels > CROSSED_PANELS)
    }

    /// Whether the gap is too narrow for the lattice, see [`ClosedSheets`].
    pub fn is_closed(&self) -> bool {
        self.panels[0] < f64::INFINITY && self.panels[1] < CLOSED_PANELS
    }
}

impl Facing {
    /// Returns the interpolation points above the control points of a sheet for a point that is close to it. Every point above the sheet,
    /// close or not, is recorded in `gap`.
    pub fn look(
        (index, sheet): (usize, &Sheet),
        state: &LatticeState,
        looking: &Looking,
        gap: &mut Gap,
    ) -> Option<Self> {
        let above = above(sheet, state, looking)?;
        if above.share >= 1.0 {
            gap.include(&above);
        }
        let height = above.height_m.norm() / above.panel_m;
        let share = above.share * nearness(height);
        if share <= 0.0 {
            return None;
        }
        let mut facing =
            Self { point: looking.point, sheet: index, share, point_m: looking.point_m, ..Self::default() };
        let behind = (sheet.rows as f64 - above.place[0]).max(0.0) * above.chord_m / above.panel_m;
        facing.wake_share = share * nearness(behind);
        let (first_row, rows, along) = interpolation(above.place[0], sheet.rows);
        let (first_strip, strips, across) = interpolation(above.place[1], sheet.strips);
        let mut used = 0;
        for (row, along) in along.iter().enumerate().take(rows) {
            for (strip, across) in across.iter().enumerate().take(strips) {
                let weight = along * across;
                if weight.abs() < NOTHING {
                    continue;
                }
                let control_m = state.collocation_m[sheet.ring(first_row + row, first_strip + strip)];
                facing.places[used / LANES].set(used % LANES, &(control_m + above.height_m));
                facing.weights[used / LANES][used % LANES] = weight;
                used += 1;
            }
        }
        facing.used = used.div_ceil(LANES);
        // unused lanes have zero weight and are placed at the point itself, where the field is regular
        for spare in used..facing.used * LANES {
            facing.places[spare / LANES].set(spare % LANES, &(looking.point_m + above.height_m));
        }
        Some(facing)
    }

    /// Correction to the velocity that the other sheet induces at the point, in m/s: `Σ w u(places) − u(point)`.
    pub fn correction_m_s(
        &self,
        kernel: &Kernel,
        sheet: &Sheet,
        nodes_m: &[Vector3<f64>],
        filaments: &Filaments,
        arms: &mut [Arm],
    ) -> Vector3<f64> {
        let mut direct = (Block::default(), Block::default());
        (0..LANES).for_each(|lane| direct.0.set(lane, &self.point_m));
        kernel.induce(&[*sheet], nodes_m, filaments, &direct.0, arms, &mut direct.1);
        let mut sum = -direct.1.get(0);
        for (places, weights) in self.places.iter().zip(&self.weights).take(self.used) {
            let mut velocities = Block::default();
            kernel.induce(&[*sheet], nodes_m, filaments, places, arms, &mut velocities);
            for (lane, weight) in weights.iter().enumerate() {
                sum += velocities.get(lane) * *weight;
            }
        }
        sum
    }

    /// The same point, with direct evaluation of the velocity.
    pub fn direct(&self) -> Self {
        let mut direct = Self { used: 1, ..*self };
        (0..LANES).for_each(|lane| direct.places[0].set(lane, &self.point_m));
        direct.weights[0] = std::array::from_fn(|lane| if lane == 0 { 1.0 } else { 0.0 });
        direct
    }

    /// Adds up the interpolated normal velocities at the point due to unit rings of a sheet, into `sums` by `column`; `scratch` has
    /// [`LANES`] entries for each of them.
    #[expect(clippy::too_many_arguments, reason = "a kernel: every argument is one plain operand of its loops")]
    pub fn influence(
        &self,
        kernel: &Kernel,
        sheet: &Sheet,
        nodes_m: &[Vector3<f64>],
        normal: &Vector3<f64>,
        arms: &mut [Arm],
        scratch: &mut [f64],
        sums: &mut [f64],
        first_column: impl Fn(usize) -> usize + Copy,
    ) {
        let mut normals = Block::default();
        (0..LANES).for_each(|lane| normals.set(lane, normal));
        for (places, weights) in self.places.iter().zip(&self.weights).take(self.used) {
            let scratch = &mut scratch[..LANES * sums.len()];
            scratch.fill(0.0);
            kernel.influence(sheet, nodes_m, places, &normals, arms, scratch, (LANES, 0), first_column);
            for (sum, entries) in sums.iter_mut().zip(scratch.chunks_exact(LANES)) {
                *sum += entries.iter().zip(weights).map(|(entry, weight)| entry * weight).sum::<f64>();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aero::AirLoads;
    use crate::aero::lattice::{LatticeOptions, VortexLattice};
    use crate::aero::surface::{ChordLine, Profile, Surface};
    use crate::aero::test_lattices::{flow, options, section};
    use crate::load::SectionMotion;

    /// A flat sheet of 12 m by 12 m with given numbers of strips and of rows per metre; its vorticity is 1 m/s everywhere.
    fn sheet(strips: usize, rows_1_m: usize) -> (VortexLattice, LatticeState) {
        let rows = 12 * rows_1_m;
        // each line represents the vorticity of half a row in front of and behind it: all sheets start 0.25 m in front of the origin
        let leading_m = Vector3::y() * (0.25 - 0.25 / rows_1_m as f64);
        let chord = ChordLine { leading_m, trailing_m: leading_m - Vector3::y() * 12.0 };
        let sections = strips + 1;
        let surface = Surface {
            sections: 0..sections,
            chords: vec![chord; sections],
            chord_panels: rows,
            profile: Profile::THIN,
        };
        let options = LatticeOptions { wake_rows: 2, core_radius_m: 1e-6, ..options() };
        let mut lattice = VortexLattice::new(vec![surface], options);
        let motions: Vec<SectionMotion> =
            (0..sections).map(|column| section(Vector3::x() * (12.0 * column as f64 / strips as f64), 0.0)).collect();
        let flow = flow(-Vector3::y());
        let (mut state, mut loads) = (lattice.blank_state(), AirLoads::still(sections));
        lattice.start(&motions, &flow, None, &mut state, &mut loads).unwrap();
        let bound = lattice.bound[0];
        for (row, strip) in (0..=rows).flat_map(|row| (0..strips).map(move |strip| (row, strip))) {
            state.circulation_m2_s[bound.ring(row, strip)] = (row.min(rows - 1) + 1) as f64 / rows_1_m as f64;
        }
        lattice.bound_filaments.gather(&lattice.inducing[0], &state.circulation_m2_s);
        (lattice, state)
    }

    /// Velocity that the sheet induces at a point along its normal, evaluated directly.
    fn direct_m_s((lattice, state): &mut (VortexLattice, LatticeState), point_m: &Vector3<f64>) -> f64 {
        let (mut points, mut velocities) = (Block::default(), Block::default());
        (0..LANES).for_each(|lane| points.set(lane, point_m));
        let (kernel, filaments) = (lattice.kernel, &lattice.bound_filaments);
        kernel.induce(&lattice.inducing, &state.corner_m, filaments, &points, &mut lattice.arms[0], &mut velocities);
        velocities.get(0).z
    }

    /// The velocity that a sheet induces at a point above it is that of a continuous sheet, not of its lines, at every height and at every
    /// position over a panel: it agrees with lines sixteen times denser. The error of the lines themselves is at least `e^(−2πh/d)` of the
    /// vorticity; with increasing height the velocity of the lines is blended in.
    #[test]
    fn points_above_a_sheet_see_no_lines() {
        let (mut coarse, mut fine) = (sheet(12, 1), sheet(1, 16));
        let (mut worst_m_s, mut worst_directly_m_s) = (0.0_f64, 0.0_f64);
        for height in 2..=20 {
            let height_m = 0.05 * f64::from(height);
            for place in 0..8 {
                let point_m = Vector3::new(6.3, -6.0 - 0.125 * f64::from(place), height_m);
                let expected_m_s = direct_m_s(&mut fine, &point_m);
                let directly_m_s = direct_m_s(&mut coarse, &point_m);
                let (lattice, state) = &mut coarse;
                let looking = Looking { point: 0, point_m, normal: Vector3::z() };
                let facing = Facing::look((0, &lattice.bound[0]), state, &looking, &mut { Gap::NONE });
                let (kernel, filaments) = (lattice.kernel, &lattice.bound_filaments);
                let seen_m_s = facing.map_or(directly_m_s, |facing| {
                    let sheet = &lattice.inducing[0];
                    let more_m_s =
                        facing.correction_m_s(&kernel, sheet, &state.corner_m, filaments, &mut lattice.arms[0]);
                    directly_m_s + facing.share * more_m_s.z
                });
                worst_m_s = worst_m_s.max((seen_m_s - expected_m_s).abs());
                worst_directly_m_s = worst_directly_m_s.max((directly_m_s - expected_m_s).abs());
            }
        }
        assert!(worst_directly_m_s > 0.5, "lines are to be seen directly: {worst_directly_m_s}");
        // (1 − share) e^(−2πh/d) is at most 0.012, at 0.62 panels; interpolation between control points adds 0.014, as at lower heights
        assert!(worst_m_s < 0.025, "off by {worst_m_s:.4}");
    }
}
