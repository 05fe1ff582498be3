//! Linearisation of the lattice about a steady flow: derivatives of its response with respect to motion, air, control surfaces and wake,
//! eqs. (U24) to (U26).
//!
//! After Maraniello and Palacios, State-space realizations and internal balancing in potential-flow aerodynamics with arbitrary kinematics,
//! AIAA Journal 57 (2019). The wake is straight and has its full length; its last row extends far behind the wing. The circulations of the
//! wake are states, and so are the displacements of its nodes if it has circulation in the steady flow. The circulations of the wing follow
//! from the motion at the end of a step by (U4) and are eliminated.

use crate::aero::flap::{Deflection, HingeMoment};
use crate::aero::flow::{Flow, Gust, GustShape};
use crate::aero::lattice::{Factors, VortexLattice, WakeModel};
use crate::aero::lattice_state::LatticeState;
use crate::aero::near_sheets::NoCirculation;
use crate::aero::rear::SHED_PANELS;
use crate::aero::wake::SHED_ROUND_OFF;
use crate::aero::{AirLoads, lattice_loads};
use crate::load::{SectionMotion, Wrench};
use nalgebra::{DMatrix, Matrix3, Rotation3, Vector3};

/// Number of variables of a section's motion: position in m, rotation vector in rad, velocity in m/s, angular velocity in rad/s, three
/// each.
pub const SECTION_PARTS: usize = 12;
/// Number of entries of a wrench.
const ENTRIES: usize = 6;
/// Fourth-order central differences: weights of the steps ±1 and ±2, to be divided by 12 steps.
pub(super) const WEIGHTS: [f64; 2] = [8.0, -1.0];
/// Difference step, relative to the panel chord, to the rotation in rad that moves the end of the longest chord by a panel chord, and to
/// the wind speed. The response is smooth on the scale of a panel: truncation error and round-off are both about 1e-11.
pub(super) const STEP: f64 = 1e-3;
/// Number of rows of nodes behind the trailing edge with independent displacements; the rows behind them move with the last of these.
pub(super) const MOVING_ROWS: usize = 64;
/// Circulation of the wake, relative to wind speed times panel chord, below which displacements of its nodes have no effect.
pub(super) const NO_CIRCULATION: f64 = 1e-12;
/// Speed due to the rotation of the root frame, relative to the wind speed, below which the flow is treated as steady.
const STEADY_SHARE: f64 = 1e-12;

/// Reason why a lattice cannot be linearised.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoLinearLattice {
    /// The steady flow has no solution.
    #[error("{0}")]
    Flow(NoCirculation),
    /// The wake is free, so that induced velocities move it.
    #[error("a free wake has no steady shape; write free_wake = false")]
    FreeWake,
    /// There is no wake.
    #[error("wake_rows = 0 leaves no wake to linearise; set wake_rows to 1 or more")]
    NoWake,
    /// The root frame rotates.
    #[error("the root rotates at {0} rad/s, so the wake is not straight; set the root's angular velocity to 0")]
    Turning(f64),
    /// Strips are beyond stall.
    #[error(
        "strips are beyond stall, where the lift follows the polar with a lag that the linear model does not include; \
         reduce the incidence, or simulate"
    )]
    Stalled,
    /// The wind does not carry the wake away fast enough.
    #[error(
        "the wind travels {panels:.4} panel chords in an aerodynamic step; each row of the wake needs at least \
         {SHED_PANELS}; increase \
         step_s or the wind"
    )]
    Slow {
        /// Displacement of the wind in a step divided by the chord of the shortest panel.
        panels: f64,
    },
}

impl From<NoCirculation> for NoLinearLattice {
    fn from(error: NoCirculation) -> Self {
        Self::Flow(error)
    }
}

/// Derivatives of the response of a lattice at the end of a step. Rows of a response: circulations of the panels in m²/s, in the order of
/// the equations; circulatory loads of the sections in their frames, force in N and moment in N·m; circulatory hinge moments of the control
/// surfaces in N·m; positions in m of the last corners, where the wake starts, root frame.
#[derive(Debug, Clone, PartialEq)]
pub struct LatticeSlopes {
    /// Number of panels of all surfaces.
    pub panels: usize,
    /// Number of sections.
    pub sections: usize,
    /// Number of control surfaces.
    pub flaps: usize,
    /// Indices of the panels at the trailing edge, strip by strip.
    pub trailing: Vec<usize>,
    /// Number of rows of the wake, with one ring per strip.
    pub wake_rows: usize,
    /// Number of last corners, one per column of nodes of the wake.
    pub edges: usize,
    /// Derivatives with respect to [`SECTION_PARTS`] variables of each section.
    pub section: DMatrix<f64>,
    /// Derivatives with respect to the wind velocity and the angular velocity of the root frame (three columns each), and to the rates and
    /// the angles of the control surfaces, for a fixed wake.
    pub air: DMatrix<f64>,
    /// Derivatives with respect to gusts that travel with the wind: velocity components at the points that the wind reaches 0, 1, 2… steps
    /// after the foremost point of the lattice, linear in between; three columns for each point.
    pub gust: DMatrix<f64>,
    /// Derivatives with respect to the circulations of the wake, row by row from the trailing edge.
    pub wake: DMatrix<f64>,
    /// Derivatives with respect to displacements of the wake nodes in m, row by row behind the last corners, three for each node; rows
    /// further behind move with the last. No columns if the wake has no circulation.
    pub node: DMatrix<f64>,
    /// Displacements of these nodes in m over a step due to the wind velocity and the angular velocity of the root frame (three columns
    /// each), eq. (U25).
    pub carried: DMatrix<f64>,
    /// Loads and hinge moments, as means over a step, due to the rates of the panels' circulations in m²/s²: eq. (U8).
    pub impulse: DMatrix<f64>,
}

impl LatticeSlopes {
    /// Number of rows of a response.
    pub fn rows(&self) -> usize {
        self.edge_row() + 3 * self.edges
    }

    /// Index of the first row of a response that is a position.
    pub fn edge_row(&self) -> usize {
        self.panels + ENTRIES * self.sections + self.flaps
    }

    /// Number of rows of nodes whose displacements are states.
    pub fn node_rows(&self) -> usize {
        self.node.ncols() / (3 * self.edges).max(1)
    }

    /// Number of points at which travelling gusts are given.
    pub fn gust_places(&self) -> usize {
        self.gust.ncols() / 3
    }
}

/// State about which the variables are perturbed one by one.
pub(super) struct About<'a> {
    pub state: LatticeState,
    pub motions: Vec<SectionMotion>,
    deflections: Vec<Deflection>,
    pub flow: Flow<'a>,
    step_s: f64,
}

impl VortexLattice {
    /// Computes the derivatives about the steady flow past fixed sections, for steps of `step_s`; `gusts` includes those with respect to
    /// travelling gusts. If there are several circulations beyond stall, eq. (U32), the one nearest to `from` is used.
    ///
    /// # Errors
    /// [`NoLinearLattice`] gives the reason.
    pub fn linear(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        step_s: f64,
        gusts: bool,
        from: &LatticeState,
    ) -> Result<LatticeSlopes, NoLinearLattice> {
        let mut about = self.about_steady(motions, flow, step_s, from)?;
        let panel_m = self.shed_way_m() / SHED_PANELS;
        let chord_m = self.surfaces.iter().flat_map(|surface| &surface.chords).map(|chord| chord.length_m());
        let longest_m = chord_m.fold(0.0, f64::max);
        let speed_m_s = flow.wind_m_s.norm();
        let mut columns = Vec::new();
        for (section, kept) in motions.iter().copied().enumerate() {
            for part in 0..SECTION_PARTS {
                let axis = Vector3::ith(part % 3, 1.0);
                let step = STEP * [panel_m, panel_m / longest_m, speed_m_s, speed_m_s / longest_m][part / 3];
                columns.extend(self.difference(&mut about, step, &mut |about, amount| {
                    let motion = &mut about.motions[section];
                    *motion = kept;
                    match part / 3 {
                        0 => motion.position_m += amount * axis,
                        1 => motion.rotation = Rotation3::new(amount * axis).into_inner() * kept.rotation,
                        2 => motion.velocity_m_s += amount * axis,
                        _ => motion.spin_rad_s += amount * axis,
                    }
                })?);
            }
        }
        let rows = columns.len() / (SECTION_PARTS * motions.len()).max(1);
        let section = DMatrix::from_vec(rows, SECTION_PARTS * motions.len(), std::mem::take(&mut columns));
        let wind_m_s = flow.wind_m_s;
        for part in 0..3 {
            columns.extend(self.difference(&mut about, STEP * speed_m_s, &mut |about, amount| {
                about.flow.wind_m_s = wind_m_s + amount * Vector3::ith(part, 1.0);
            })?);
        }
        let spin_rad_s = flow.spin_rad_s;
        for part in 0..3 {
            columns.extend(self.difference(&mut about, STEP * speed_m_s / longest_m, &mut |about, amount| {
                about.flow.spin_rad_s = spin_rad_s + amount * Vector3::ith(part, 1.0);
            })?);
        }
        let flaps = about.deflections.clone();
        for (flap, kept) in flaps.iter().enumerate() {
            columns.extend(self.difference(&mut about, STEP * speed_m_s / longest_m, &mut |about, amount| {
                about.deflections[flap].rate_rad_s = kept.rate_rad_s + amount;
            })?);
        }
        for (flap, kept) in flaps.iter().enumerate() {
            columns.extend(self.difference(&mut about, STEP, &mut |about, amount| {
                about.deflections[flap].angle_rad = kept.angle_rad + amount;
            })?);
        }
        let air = DMatrix::from_vec(rows, 6 + 2 * flaps.len(), columns);
        let gust = if gusts { self.gust_slopes(&about, rows)? } else { DMatrix::zeros(rows, 0) };
        let mut seen = self.look_at_steady(&mut about, rows)?;
        let wake = self.wake_slopes(&mut about, &mut seen, rows)?;
        let node = self.node_slopes(&mut about, &mut seen, rows)?;
        let carried = self.carried(&about, node.ncols());
        let trailing = self.bound.iter().zip(&self.first_panel).flat_map(|(sheet, first)| {
            let last = first + (sheet.rows - 1) * sheet.strips;
            last..last + sheet.strips
        });
        let trailing = trailing.collect();
        // the factors belong to the last perturbed motion
        (self.factored, self.built, self.factors) = (false, false, Factors::Due);
        Ok(LatticeSlopes {
            panels: self.right.len(),
            sections: motions.len(),
            flaps: flaps.len(),
            trailing,
            wake_rows: about.state.wake_rows,
            edges: self.wake_columns,
            section,
            air,
            gust,
            wake,
            node,
            carried,
            impulse: self.impulse_slopes(&about),
        })
    }

    /// Computes the steady flow, ready for perturbations.
    pub(super) fn about_steady<'a>(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow<'a>,
        step_s: f64,
        from: &LatticeState,
    ) -> Result<About<'a>, NoLinearLattice> {
        let mut state = self.blank_state();
        state.profile_m_s.copy_from_slice(&from.profile_m_s);
        self.steady(motions, flow, step_s, &mut state)?;
        self.factors = Factors::OfEach;
        let deflections = self.flaps.deflections().to_vec();
        Ok(About { state, motions: motions.to_vec(), deflections, flow: *flow, step_s })
    }

    /// Computes the steady flow with the full wake: rows of the length that the wind travels in a step, and a very long last row.
    fn steady(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        step_s: f64,
        state: &mut LatticeState,
    ) -> Result<(), NoLinearLattice> {
        if self.options.wake == WakeModel::Free {
            return Err(NoLinearLattice::FreeWake);
        }
        if self.options.wake_rows == 0 {
            return Err(NoLinearLattice::NoWake);
        }
        let spin_rad_s = flow.spin_rad_s.norm();
        let largest_m = motions.iter().map(|motion| motion.position_m.norm()).fold(0.0, f64::max);
        if spin_rad_s * largest_m > STEADY_SHARE * flow.wind_m_s.norm() {
            return Err(NoLinearLattice::Turning(spin_rad_s));
        }
        let panels = flow.wind_m_s.norm() * step_s * SHED_PANELS / self.shed_way_m();
        if panels < SHED_PANELS * (1.0 - SHED_ROUND_OFF) {
            return Err(NoLinearLattice::Slow { panels });
        }
        state.relative_m_s = crate::aero::lattice_far::mean_relative_m_s(motions, flow);
        self.compress(motions, flow, state)?;
        // the last corners are those for a step
        state.wake_rows = 1;
        self.place(motions, Some((flow, step_s)), state);
        self.turn_flaps(motions, state);
        self.above_ground(state)?;
        self.look_from_panels(state);
        self.lay_straight_wake(flow, state);
        self.factors = Factors::Due;
        self.influence(state, true)?;
        self.relative_velocity(flow, state, 0..0);
        self.circulate(motions, flow, state)?;
        if self.profiles.is_beyond_stall() {
            return Err(NoLinearLattice::Stalled);
        }
        (self.factored, self.built) = (false, false);
        let (rows, columns) = (self.options.wake_rows, self.wake_columns);
        let displacement_m = flow.wind_m_s * step_s;
        state.wake_node_m.copy_within(columns..2 * columns, rows * columns);
        for row in 1..rows {
            for column in 0..columns {
                state.wake_node_m[row * columns + column] = state.wake_node_m[column] + displacement_m * row as f64;
            }
        }
        (state.wake_rows, state.established) = (rows, false);
        (0..rows).for_each(|row| self.shed_into(row, state));
        Ok(())
    }

    /// Appends the response of the lattice to `rows`.
    pub(super) fn answer(&mut self, about: &mut About, rows: &mut Vec<f64>) -> Result<(), NoCirculation> {
        let About { state, motions, deflections, flow, step_s } = about;
        self.deflect(deflections);
        state.relative_m_s = crate::aero::lattice_far::mean_relative_m_s(motions, flow);
        self.compress(motions, flow, state)?;
        self.place(motions, Some((flow, *step_s)), state);
        self.turn_flaps(motions, state);
        self.above_ground(state)?;
        self.look_from_panels(state);
        self.influence(state, false)?;
        self.relative_velocity(flow, state, 0..state.wake_rows);
        self.circulate(motions, flow, state)?;
        let mut loads = AirLoads::still(motions.len());
        state.hinges.fill(HingeMoment::default());
        lattice_loads::circulatory(self, motions, flow, state, &mut loads);
        rows.extend_from_slice(&self.solution);
        in_sections(motions, &loads.circulatory, rows);
        rows.extend(state.hinges.iter().map(|hinge| hinge.circulatory_n_m));
        rows.extend(state.wake_node_m[..self.wake_columns].iter().flat_map(|node| [node.x, node.y, node.z]));
        Ok(())
    }

    /// Fourth-order difference of the response; `change` sets a variable to its value plus a perturbation.
    fn difference(
        &mut self,
        about: &mut About,
        step: f64,
        change: &mut dyn FnMut(&mut About, f64),
    ) -> Result<Vec<f64>, NoCirculation> {
        let mut slope: Vec<f64> = Vec::new();
        let mut rows = Vec::new();
        for (i, weight) in (1..).zip(WEIGHTS) {
            for sign in [1.0, -1.0] {
                rows.clear();
                change(about, sign * f64::from(i) * step);
                self.answer(about, &mut rows)?;
                slope.resize(rows.len(), 0.0);
                slope.iter_mut().zip(&rows).for_each(|(slope, row)| *slope += sign * weight * row / (12.0 * step));
            }
        }
        change(about, 0.0);
        Ok(slope)
    }

    /// Computes the derivatives with respect to gusts that travel with the wind, eq. (U26).
    fn gust_slopes(&mut self, about: &About, rows: usize) -> Result<DMatrix<f64>, NoCirculation> {
        let flow = about.flow;
        let speed_m_s = flow.wind_m_s.norm();
        let (direction, displacement_m) = (flow.wind_m_s / speed_m_s, speed_m_s * about.step_s);
        let corners_m = &about.state.corner_m;
        let along_m = |point_m: &Vector3<f64>| direction.dot(point_m);
        let foremost_m = corners_m.iter().map(along_m).fold(f64::INFINITY, f64::min);
        let hindmost_m = corners_m.iter().map(along_m).fold(f64::NEG_INFINITY, f64::max);
        let places = ((hindmost_m - foremost_m) / displacement_m * (1.0 - 1e-12)).ceil() as usize + 1;
        let mut columns = Vec::new();
        for place in 0..places {
            for part in 0..3 {
                // at the current instant the front has passed the foremost point by `place + 1` steps
                let shape = [[0.0, 0.0], [displacement_m, 1.0], [2.0 * displacement_m, 0.0]];
                let gust = |velocity_m_s: f64| Gust {
                    name: String::new(),
                    shape: GustShape::Table(shape.into()),
                    velocity_m_s: Vector3::ith(part, velocity_m_s),
                    direction,
                    speed_m_s,
                    origin_m: direction * (foremost_m + (place as f64 + 1.0) * displacement_m),
                    start_s: flow.time_s,
                };
                let ends = [1.0, -1.0].map(|sign| {
                    let mut gusts = flow.gusts.to_vec();
                    gusts.push(gust(sign * STEP * speed_m_s));
                    let mut beside = About {
                        state: about.state.clone(),
                        motions: about.motions.clone(),
                        deflections: about.deflections.clone(),
                        flow: Flow { gusts: &gusts, ..flow },
                        step_s: about.step_s,
                    };
                    let mut answer = Vec::new();
                    self.answer(&mut beside, &mut answer).map(|()| answer)
                });
                let [above, below] = ends;
                let pairs = above?.into_iter().zip(below?);
                columns.extend(pairs.map(|(above, below)| (above - below) / (2.0 * STEP * speed_m_s)));
            }
        }
        Ok(DMatrix::from_vec(rows, 3 * places, columns))
    }

    /// Convection of wake nodes with the air, in the root frame: the first `count` nodes behind the last corners.
    fn carried(&self, about: &About, count: usize) -> DMatrix<f64> {
        let step_s = about.step_s;
        let nodes_m = about.state.wake_node_m[self.wake_columns..].iter().take(count / 3);
        let mut carried = DMatrix::zeros(count, 6);
        for (node, node_m) in nodes_m.enumerate() {
            // midway along its path to its position in the steady wake
            let middle_m = node_m - about.flow.wind_m_s * (0.5 * step_s);
            carried.fixed_view_mut::<3, 3>(3 * node, 0).copy_from(&(Matrix3::identity() * step_s));
            carried.fixed_view_mut::<3, 3>(3 * node, 3).copy_from(&(middle_m.cross_matrix() * step_s));
        }
        carried
    }

    /// Computes the loads due to unit rates of the panels' circulations.
    fn impulse_slopes(&self, about: &About) -> DMatrix<f64> {
        let panels = self.right.len();
        let mut columns = Vec::new();
        let mut from = about.state.clone();
        from.circulation_m2_s.fill(0.0);
        let mut to = from.clone();
        let mut loads = AirLoads::still(about.motions.len());
        for (sheet, first) in self.bound.iter().zip(&self.first_panel) {
            for panel in 0..sheet.rows * sheet.strips {
                debug_assert!(first + panel < panels);
                let ring = sheet.first_ring + panel;
                to.circulation_m2_s[ring] = 1.0;
                to.hinges.fill(HingeMoment::default());
                loads.clear();
                lattice_loads::impulsive(self, &about.motions, &about.flow, 1.0, (&from, &mut to), &mut loads, None);
                to.circulation_m2_s[ring] = 0.0;
                in_sections(&about.motions, &loads.impulsive, &mut columns);
                columns.extend(to.hinges.iter().map(|hinge| hinge.impulsive_n_m));
            }
        }
        DMatrix::from_vec(ENTRIES * about.motions.len() + about.deflections.len(), panels, columns)
    }

    /// Number of strips.
    pub(crate) fn strip_count(&self) -> usize {
        self.bound.iter().map(|sheet| sheet.strips).sum()
    }

    /// Adds `amount` times `by_strip_m2_s` (in m²/s, strip by strip) to the circulations of a state's strips.
    pub(crate) fn add_strip_circulations(&self, state: &mut LatticeState, by_strip_m2_s: &[f64], amount: f64) {
        let mut strip = 0;
        for sheet in &self.bound {
            for own in 0..sheet.strips {
                for row in [sheet.rows - 1, sheet.rows] {
                    state.circulation_m2_s[sheet.ring(row, own)] += by_strip_m2_s[strip] * amount;
                }
                strip += 1;
            }
        }
    }
}

/// Appends the loads, expressed in the frames of their sections.
pub(super) fn in_sections(motions: &[SectionMotion], loads: &[Wrench], rows: &mut Vec<f64>) {
    for (motion, load) in motions.iter().zip(loads) {
        let turned = motion.rotation.transpose();
        rows.extend_from_slice((turned * load.force_n).as_slice());
        rows.extend_from_slice((turned * load.moment_n_m).as_slice());
    }
}
