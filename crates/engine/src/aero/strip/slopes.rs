//! Derivatives of an aerodynamic step of the strips with respect to the motion of their sections at its end and to their state before it,
//! NOTATION eq. (X12).

use crate::aero::AirLoads;
use crate::aero::flap::HingeMoment;
use crate::aero::flow::Flow;
use crate::aero::pieces::{PieceList, Pieces};
use crate::aero::strip::{Inflow, StripHistory, StripState, Strips};
use crate::load::{SectionMotion, Wrench};
use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, Vector3};
use std::ops::Range;

/// Number of entries of a section's motion: position, rotation, velocity, angular velocity; root frame.
pub const MOTION: usize = 12;
/// Number of entries of a strip's state that later loads depend on.
pub const STATE: usize = 19;
/// Number of entries of a lag: the motion's lag comes first, followed by the relative speed; the gusts' lag is last.
const LAG: usize = 6;
/// Position of the components of the normal in the state.
const NORMAL: Range<usize> = LAG + 3..LAG + 6;
/// Number of load entries of a section: circulatory and impulsive.
pub const LOADS: usize = 12;
/// Number of columns of the derivatives of a strip: motions of its inner and outer section, its state before the step.
pub const COLUMNS: usize = 2 * MOTION + STATE;
/// Number of rows: loads on its inner and outer section, root frame, and its state after the step.
pub const ROWS: usize = 2 * LOADS + STATE;

/// Jacobian of a step of one strip.
pub type StripStep = SMatrix<f64, ROWS, COLUMNS>;

/// Difference step relative to chord or span, a radian, and the relative speed; with sixth order, truncation and round-off are 1e-13.
pub(super) const STEP: f64 = 3e-3;
/// Weights of sixth-order central differences, to be divided by 60 steps.
pub(super) const SIXTH_ORDER: [f64; 3] = [45.0, -9.0, 1.0];
/// Weights for functions of second degree, for which they are exact, also divided by 60 steps.
const EXACT: [f64; 1] = [30.0];

/// A strip without relative flow: its lift follows the direction of any small velocity and has no derivative there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoFlow {
    /// Index of the surface.
    pub surface: usize,
}

impl StripHistory {
    /// State entries that later loads depend on.
    pub fn numbers(&mut self) -> [&mut f64; STATE] {
        let [a, b, c, d, e] = &mut self.motion.followers_m_s;
        let [x, y, z] = &mut self.up.data.0[0];
        let speeds = [&mut self.speed_m_s, &mut self.middle_m_s, &mut self.difference_m_s];
        let [speed, middle, difference] = speeds;
        let [f, g, h, i, j] = &mut self.gust.followers_m_s;
        let (motion, gust) = (&mut self.motion.downwash_m_s, &mut self.gust.downwash_m_s);
        let rate = &mut self.flap_rate_rad_s;
        [motion, a, b, c, d, e, speed, middle, difference, x, y, z, rate, gust, f, g, h, i, j]
    }
}

impl Strips {
    /// Surface of a strip.
    pub fn surface_of(&self, strip: usize) -> usize {
        self.strips[strip].surface
    }

    /// Sections of each strip, inner one first.
    pub fn strip_sections(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        self.strips.iter().map(|strip| strip.sections)
    }

    /// Linearises the gusts at the position of a strip.
    pub(super) fn gust_slope(&self, index: usize, motions: &[SectionMotion], flow: &Flow) -> GustSlope {
        let strip = &self.strips[index];
        let own = (strip, &self.profiles[strip.surface], self.controls.on(index));
        let mut gust = GustSlope::default();
        Inflow::with_gusts(own, motions, flow, |at_m| {
            let slopes = flow.gusts.iter().filter_map(|gust| gust.slope_1_s(flow.time_s, at_m));
            let velocity_m_s = flow.gust_m_s(at_m);
            gust = GustSlope { place_m: *at_m, velocity_m_s, slope_1_s: slopes.sum() };
            velocity_m_s
        });
        gust
    }

    /// Derivatives of the step with respect to `motions` and state, strip by strip, on the pieces on which its functions lie; without a lifting
    /// line, so that strips are independent.
    ///
    /// # Errors
    /// If a strip has no relative flow.
    pub fn step_slopes(
        &self,
        from: &StripState,
        motions: &[SectionMotion],
        flow: &Flow,
        step_s: f64,
        pieces: &[PieceList],
    ) -> Result<Vec<StripStep>, NoFlow> {
        let mut trial = Trial {
            strips: self,
            pieces,
            flow,
            step_s,
            motions: motions.to_vec(),
            loads: AirLoads::still(motions.len()),
            hinges: from.hinges.clone(),
            gust: GustSlope::default(),
        };
        (0..self.strips.len()).map(|index| trial.slopes(index, &from.strips[index])).collect()
    }
}

/// Evaluates a step with perturbed motions and states.
struct Trial<'a> {
    strips: &'a Strips,
    pieces: &'a [PieceList],
    flow: &'a Flow<'a>,
    step_s: f64,
    motions: Vec<SectionMotion>,
    loads: AirLoads,
    hinges: Vec<HingeMoment>,
    gust: GustSlope,
}

/// Gusts at a strip, linearised about its position: the second derivative of their shape may jump.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct GustSlope {
    /// Position in m, root frame.
    place_m: Vector3<f64>,
    /// Velocity there in m/s.
    velocity_m_s: Vector3<f64>,
    /// Its gradient in 1/s.
    slope_1_s: Matrix3<f64>,
}

impl GustSlope {
    /// Velocity at a position in m/s.
    pub fn at_m_s(&self, place_m: &Vector3<f64>) -> Vector3<f64> {
        self.velocity_m_s + self.slope_1_s * (place_m - self.place_m)
    }
}

/// Whether an entry of a strip's state is a component of its normal.
pub(super) fn normal_in_state(entry: usize) -> bool {
    NORMAL.contains(&entry)
}

impl Trial<'_> {
    /// Inflow with the gusts linearised about the position.
    fn inflow(&self, index: usize) -> Inflow {
        let strip = &self.strips.strips[index];
        let own = (strip, &self.strips.profiles[strip.surface], self.strips.controls.on(index));
        Inflow::with_gusts(own, &self.motions, self.flow, |at_m| self.gust.at_m_s(at_m))
    }

    /// Jacobian of one strip.
    fn slopes(&mut self, index: usize, before: &StripHistory) -> Result<StripStep, NoFlow> {
        self.gust = self.strips.gust_slope(index, &self.motions, self.flow);
        let (strip, now) = (&self.strips.strips[index], self.inflow(index));
        let speed_m_s = now.speed_m_s.hypot(now.difference_m_s);
        if speed_m_s <= 0.0 {
            return Err(NoFlow { surface: strip.surface });
        }
        let length_m = now.cut.chord_m.min(now.cut.span_m);
        let has_polar = self.strips.profiles[strip.surface].polar.is_some();
        let mut slopes = StripStep::zeros();
        for end in 0..2 {
            let section = strip.sections[end];
            let usual = self.motions[section];
            for entry in 0..MOTION {
                let step = STEP * [length_m, 1.0, speed_m_s, speed_m_s / length_m][entry / 3];
                let column = differences((step, &SIXTH_ORDER), |change| {
                    self.motions[section] = moved(&usual, entry, change);
                    self.rows(index, before)
                });
                self.motions[section] = usual;
                slopes.set_column(end * MOTION + entry, &column);
            }
        }
        // without gusts their lag states are zero
        let entries = if self.flow.gusts.is_empty() { STATE - LAG } else { STATE };
        for entry in 0..entries {
            let step = STEP * if NORMAL.contains(&entry) { 1.0 } else { speed_m_s };
            // without a polar loads are quadratic in the downwash of the lag states and linear in the rates of change
            let weights: &[f64] = if entry == LAG || has_polar { &SIXTH_ORDER } else { &EXACT };
            let column = differences((step, weights), |change| {
                let mut changed = *before;
                *changed.numbers()[entry] += change;
                self.rows(index, &changed)
            });
            slopes.set_column(2 * MOTION + entry, &column);
        }
        Ok(slopes)
    }

    /// Returns the loads on both sections and the state after the step.
    fn rows(&mut self, index: usize, before: &StripHistory) -> SVector<f64, ROWS> {
        let now = self.inflow(index);
        let sections = self.strips.strips[index].sections;
        for section in sections {
            (self.loads.circulatory[section], self.loads.impulsive[section]) = Default::default();
        }
        let step = (self.flow, self.step_s);
        let pieces = &mut Pieces::keep(&self.pieces[index]);
        let mut after = self.strips.advance((index, &now), before, step, &mut self.hinges, &mut self.loads, pieces);
        let mut rows = SVector::<f64, ROWS>::zeros();
        for (end, section) in sections.into_iter().enumerate() {
            let parts = [&self.loads.circulatory[section], &self.loads.impulsive[section]];
            for (part, Wrench { force_n, moment_n_m }) in parts.into_iter().enumerate() {
                rows.fixed_rows_mut::<3>(end * LOADS + 6 * part).copy_from(force_n);
                rows.fixed_rows_mut::<3>(end * LOADS + 6 * part + 3).copy_from(moment_n_m);
            }
        }
        for (row, number) in rows.iter_mut().skip(2 * LOADS).zip(after.numbers()) {
            *row = *number;
        }
        rows
    }
}

/// A motion with one entry changed.
pub(in crate::aero) fn moved(motion: &SectionMotion, entry: usize, change: f64) -> SectionMotion {
    let mut vector = Vector3::zeros();
    vector[entry % 3] = change;
    let mut motion = *motion;
    match entry / 3 {
        0 => motion.position_m += vector,
        1 => motion.rotation = Rotation3::new(vector).into_inner() * motion.rotation,
        2 => motion.velocity_m_s += vector,
        _ => motion.spin_rad_s += vector,
    }
    motion
}

/// Central differences with a given step and weights.
fn differences((step, weights): (f64, &[f64]), mut rows: impl FnMut(f64) -> SVector<f64, ROWS>) -> SVector<f64, ROWS> {
    let mut sum = SVector::zeros();
    for (steps, weight) in (1..).map(f64::from).zip(weights) {
        sum += (rows(steps * step) - rows(-steps * step)) * (weight / (60.0 * step));
    }
    sum
}
