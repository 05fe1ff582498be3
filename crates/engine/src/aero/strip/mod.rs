//! Strip theory: every strip is treated as a section of an infinite wing.
//!
//! A strip is cut normal to its quarter-chord line; the velocity along that line has no effect. The loads follow thin-aerofoil theory at
//! any angle of attack, quasi-steady or with the lag of Wagner and Küssner, for a plate along the zero-lift line or with a polar. Without a
//! polar there is no stall. A lifting line through all strips may add the effects of finite span.

mod compressible;
pub mod continuous;
pub mod flap;
pub mod indicial;
mod inflow;
pub mod instant;
pub mod lifting_line;
mod line_slopes;
pub mod section;
pub mod slopes;
mod step;
#[cfg(test)]
mod tests;

use crate::aero::AirLoads;
use crate::aero::flap::HingeMoment;
use crate::aero::flow::Flow;
use crate::aero::pieces::{Holding, PieceList, Pieces};
use crate::aero::surface::{Edge, Profile, Surface};
use crate::load::{SectionMotion, Wrench};
use flap::Controls;
use indicial::{Fit, Lag};
use inflow::Inflow;
use lifting_line::{LiftingLine, LiftingLineOptions, LineEnd, StripEdges, StripEquation};
pub use line_slopes::LineStep;
use nalgebra::Vector3;
use section::Strip;
use serde::{Deserialize, Serialize};

/// Options of strip theory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StripOptions {
    /// Lag of the lift behind the downwash (Wagner, Küssner); without it the lift is quasi-steady.
    pub unsteady: bool,
    /// Whether the loads include the apparent mass of the air.
    pub apparent_mass: bool,
    /// Fit of the indicial functions.
    pub fit: Fit,
    /// Leading-edge suction, which rotates the force of a plate from the normal of the chord to the normal of the relative velocity; polars
    /// include it.
    pub leading_edge_suction: bool,
    /// Loss of lift towards the wing tips and induced drag, by a lifting line; without it every strip is part of an infinite wing. Not with
    /// polars.
    pub tip_loss: Option<LiftingLineOptions>,
    /// Speed of sound in m/s, for the Prandtl-Glauert rule, eq. (U22); incompressible without it. Not with polars.
    pub speed_of_sound_m_s: Option<f64>,
}

impl Default for StripOptions {
    fn default() -> Self {
        Self {
            unsteady: true,
            apparent_mass: true,
            fit: Fit::Jones,
            leading_edge_suction: true,
            tip_loss: None,
            speed_of_sound_m_s: None,
        }
    }
}

impl StripOptions {
    /// Effective downwash for the lift, including the lag of motion and gusts, eq. (W6).
    fn effective_m_s(&self, motion: &Lag, gust: &Lag) -> f64 {
        if self.unsteady {
            self.fit.wagner().effective_m_s(motion.downwash_m_s, motion)
                + self.fit.kuessner().effective_m_s(gust.downwash_m_s, gust)
        } else {
            motion.downwash_m_s + gust.downwash_m_s
        }
    }

    /// Lag states of motion and gusts one step after `before`, eq. (W6); the distance in semi-chords follows from the mean of the speeds at
    /// both ends.
    fn lags(&self, before: &StripHistory, now: &Inflow, gust_m_s: f64, step_s: f64) -> (Lag, Lag) {
        let distance = (before.speed_m_s + now.speed_m_s) * step_s / now.cut.chord_m;
        let motion = before.motion.advanced(self.fit.wagner(), distance, now.downwash_m_s);
        (motion, before.gust.advanced(self.fit.kuessner(), distance, gust_m_s))
    }
}

/// State of one strip at the last aerodynamic step.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct StripHistory {
    /// Lag of the downwash of motion and wind.
    pub motion: Lag,
    /// Lag of the downwash of gusts and of the lifting line.
    pub gust: Lag,
    /// Relative speed in m/s.
    pub speed_m_s: f64,
    /// Upward velocity of the air, without gusts, at half chord, in m/s.
    pub middle_m_s: f64,
    /// Upward velocity at the trailing edge minus that at the leading edge in m/s.
    pub difference_m_s: f64,
    /// Unit normal.
    pub up: Vector3<f64>,
    /// Circulation in m²/s equivalent to the lift.
    pub circulation_m2_s: f64,
    /// Deflection rate of the strip's control surface in its cut in rad/s; 0 without one.
    pub flap_rate_rad_s: f64,
}

/// State of all strips and control surfaces on which later loads depend.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct StripState {
    /// One entry per strip, surface by surface, inner strip first.
    pub strips: Vec<StripHistory>,
    /// Hinge moments, one entry per control surface.
    pub hinges: Vec<HingeMoment>,
}

impl StripState {
    /// Copies another state of the same model without allocation.
    pub fn copy_from(&mut self, other: &Self) {
        self.strips.copy_from_slice(&other.strips);
        self.hinges.copy_from_slice(&other.hinges);
    }

    /// Whether another state has the same sizes.
    pub fn fits(&self, other: &Self) -> bool {
        self.strips.len() == other.strips.len() && self.hinges.len() == other.hinges.len()
    }
}

/// Strips of all surfaces, with their options and scratch.
#[derive(Debug, Clone, PartialEq)]
pub struct Strips {
    pub(super) options: StripOptions,
    strips: Vec<Strip>,
    profiles: Vec<Profile>,
    /// Index of the first strip of each surface.
    first: Vec<usize>,
    line: Option<LiftingLine>,
    controls: Controls,
    /// Scratch: inflow of the strips.
    inflows: Vec<Inflow>,
    /// Scratch: loads of the sections.
    section_loads: Vec<Wrench>,
    /// Pieces of the functions of the strips: recorded, kept or free.
    pub holding: Holding<Vec<PieceList>>,
}

impl Strips {
    /// Creates one strip between each pair of consecutive sections of each surface.
    pub fn new(surfaces: Vec<Surface>, options: StripOptions) -> Self {
        let mut model = Self {
            options,
            strips: Vec::new(),
            profiles: Vec::new(),
            first: Vec::new(),
            line: None,
            controls: Controls::default(),
            inflows: Vec::new(),
            section_loads: Vec::new(),
            holding: Holding::Free,
        };
        for (index, surface) in surfaces.into_iter().enumerate() {
            model.first.push(model.strips.len());
            for strip in 0..surface.strips() {
                let inner = surface.sections.start + strip;
                let chords = [surface.chords[strip], surface.chords[strip + 1]];
                let lift_slope_1_rad = surface.profile.lift_slope_of_strip_1_rad(strip);
                let speed_of_sound_m_s = options.speed_of_sound_m_s.unwrap_or(f64::INFINITY);
                let sections = [inner, inner + 1];
                model.strips.push(Strip { sections, chords, surface: index, lift_slope_1_rad, speed_of_sound_m_s });
            }
            model.profiles.push(surface.profile);
        }
        model.line = options.tip_loss.map(|line| LiftingLine::new(model.strips.len(), &line));
        model.inflows.reserve_exact(model.strips.len());
        model
    }

    /// Joins two surface edges where their bodies are connected: the lifting line has no gap there.
    pub fn join(&mut self, edges: [Edge; 2]) {
        let ends = edges.map(|edge| self.line_end(edge));
        self.line.iter_mut().for_each(|line| line.join(ends));
    }

    /// Joins an edge that lies at the mirror plane with its image.
    pub fn join_image(&mut self, edge: Edge) {
        let end = self.line_end(edge);
        self.line.iter_mut().for_each(|line| line.join_image(end));
    }

    fn line_end(&self, edge: Edge) -> LineEnd {
        let (first, surface) = (self.first[edge.surface], edge.surface);
        let next = self.first.get(surface + 1).copied().unwrap_or(self.strips.len());
        let strip = if edge.outer { next - 1 } else { first };
        LineEnd { surface, strips: next - first, strip, end: usize::from(edge.outer) }
    }

    /// Empty lists of pieces, one per strip.
    pub fn no_pieces(&self) -> Vec<PieceList> {
        vec![PieceList::default(); self.strips.len()]
    }

    /// Returns an empty state, to be filled by [`Strips::start`].
    pub fn blank_state(&self) -> StripState {
        StripState {
            strips: vec![StripHistory::default(); self.strips.len()],
            hinges: vec![HingeMoment::default(); self.controls.flaps.len()],
        }
    }

    /// Sets the initial state and the circulatory loads; impulsive loads are zero.
    ///
    /// With `steady_initial_flow` the current flow has always existed. Otherwise all downwash starts now, initially with half of the lift
    /// due to motion and wind and none due to gusts.
    pub fn start(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        established: bool,
        state: &mut StripState,
        loads: &mut AirLoads,
    ) {
        loads.clear();
        let lag = if established { Lag::established } else { Lag::sudden };
        self.meet(motions, flow);
        let options = self.options;
        self.add_induced(|_, now, gust_m_s| options.effective_m_s(&lag(now.downwash_m_s), &lag(gust_m_s)));
        state.hinges.fill(HingeMoment::default());
        let mut holding = std::mem::take(&mut self.holding);
        for (index, history) in state.strips.iter_mut().enumerate() {
            let now = &self.inflows[index];
            let pieces = &mut holding.pieces(|strips| &mut strips[index]);
            *history = now.history(lag(now.downwash_m_s), lag(now.gust_downwash_m_s));
            self.add_circulatory((index, now), flow, history, &mut state.hinges, loads, pieces);
        }
        self.holding = holding;
    }

    /// Prepares the state at the end of a step: a copy, because strips have no wake.
    pub fn convect(&mut self, from: &StripState, _flow: &Flow, _step_s: f64, to: &mut StripState) {
        to.copy_from(from);
    }

    /// Computes state and loads after a step of `step_s` from `from`, for the motions and the flow at its end.
    ///
    /// The result depends only on the arguments, so that a coupling iteration may call this again with other motions. Second order in the
    /// step for motions and gusts that are smooth over it.
    pub fn solve(
        &mut self,
        from: &StripState,
        motions: &[SectionMotion],
        flow: &Flow,
        step_s: f64,
        to: &mut StripState,
        loads: &mut AirLoads,
    ) {
        self.meet(motions, flow);
        self.solve_met(from, flow, step_s, to, loads);
    }

    /// [`Self::solve`] for the inflow of the last [`Self::meet_with`], to which the velocities induced by the lifting line are added.
    fn solve_met(&mut self, from: &StripState, flow: &Flow, step_s: f64, to: &mut StripState, loads: &mut AirLoads) {
        loads.clear();
        let options = self.options;
        self.add_induced(|strip, now, gust_m_s| {
            let (motion, gust) = options.lags(&from.strips[strip], now, gust_m_s, step_s);
            options.effective_m_s(&motion, &gust)
        });
        to.hinges.fill(HingeMoment::default());
        let mut holding = std::mem::take(&mut self.holding);
        for (index, (before, after)) in from.strips.iter().zip(&mut to.strips).enumerate() {
            let pieces = &mut holding.pieces(|strips| &mut strips[index]);
            *after = self.advance((index, &self.inflows[index]), before, (flow, step_s), &mut to.hinges, loads, pieces);
        }
        self.holding = holding;
    }

    /// Evaluates the inflow of all strips, and the lifting line through them if there is one.
    fn meet(&mut self, motions: &[SectionMotion], flow: &Flow) {
        self.meet_with(motions, flow, |_, place_m| flow.gust_m_s(place_m));
    }

    /// The same with the gust velocity that `gust_m_s` gives for a strip and a position.
    fn meet_with(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        gust_m_s: impl Fn(usize, &Vector3<f64>) -> Vector3<f64>,
    ) {
        let Self { strips, profiles, inflows, line, controls, .. } = self;
        inflows.clear();
        let meet = |(index, strip): (usize, &Strip)| {
            let own = (strip, &profiles[strip.surface], controls.on(index));
            Inflow::with_gusts(own, motions, flow, |place_m| gust_m_s(index, place_m))
        };
        inflows.extend(strips.iter().enumerate().map(meet));
        if let Some(line) = line {
            let edges = strips.iter().zip(inflows).map(|(strip, now)| StripEdges::of(strip, motions, flow, now.bias));
            line.look(strips, edges, |strip| profiles[strip.surface].zero_lift_angle_rad.sin_cos());
        }
    }

    /// Adds the velocity induced by the lifting line to the gusts at the strips, eq. (W11). `effective_m_s` returns the effective downwash
    /// of a strip as a function of its gust downwash, in which it is linear.
    fn add_induced(&mut self, effective_m_s: impl Fn(usize, &Inflow, f64) -> f64) {
        let Self { line: Some(line), strips, inflows, .. } = self else { return };
        for (at, (equation, now)) in line.equations.iter_mut().zip(inflows.iter()).enumerate() {
            let plain_m_s = effective_m_s(at, now, now.gust_downwash_m_s);
            *equation = StripEquation {
                slope_m: 0.5 * now.cut.chord_m * strips[at].lift_slope_1_rad * now.compression,
                effective_m_s: plain_m_s,
                gain: effective_m_s(at, now, now.gust_downwash_m_s + 1.0) - plain_m_s,
            };
        }
        line.induce();
        for (now, induced_m_s) in inflows.iter_mut().zip(&line.induced_m_s) {
            now.gust_downwash_m_s += induced_m_s;
        }
    }

    /// Circulation in m²/s of a strip of a surface, counted from its inner end.
    pub fn strip_circulation_m2_s(&self, state: &StripState, surface: usize, strip: usize) -> f64 {
        state.strips[self.first[surface] + strip].circulation_m2_s
    }

    /// Adds the loads of circulation, flow curvature, profile drag and profile moment.
    fn add_circulatory(
        &self,
        (index, now): (usize, &Inflow),
        flow: &Flow,
        history: &mut StripHistory,
        hinges: &mut [HingeMoment],
        loads: &mut AirLoads,
        pieces: &mut Pieces,
    ) {
        let strip = &self.strips[index];
        let profile = &self.profiles[strip.surface];
        let effective_m_s = self.options.effective_m_s(&history.motion, &history.gust);
        let suction = self.options.leading_edge_suction;
        let section = now.section_loads(strip, profile, suction, effective_m_s, flow.density_kg_m3, pieces);
        let span_m = now.cut.span_m;
        history.circulation_m2_s = section.circulation_m2_s;
        strip.add_force(&mut loads.circulatory, &now.cut, section.fraction, &(section.force_n_m * span_m));
        strip.add_moment(&mut loads.circulatory, &now.cut, section.moment_n * span_m);
        self.add_legs(index, section.circulation_m2_s, flow.density_kg_m3, &mut loads.circulatory);
        if let Some(flap) = &now.flap {
            let plate = profile.polar.is_none();
            let loads = &mut loads.circulatory;
            hinges[flap.flap].circulatory_n_m +=
                now.add_flap(strip, section.circulation_m2_s, flow.density_kg_m3, plate, loads);
        }
    }

    /// Adds the forces on the chordwise legs of the lifting line at a strip, eq. (W16); without suction only their component normal to the
    /// zero-lift line.
    fn add_legs(&self, index: usize, circulation_m2_s: f64, density_kg_m3: f64, loads: &mut [Wrench]) {
        let Some(line) = &self.line else { return };
        let (strip, now) = (&self.strips[index], &self.inflows[index]);
        let (forces_n, fraction) = line.leg_forces_n(index, circulation_m2_s, &now.gust_m_s, density_kg_m3);
        for (end, force_n) in forces_n.into_iter().enumerate() {
            let force_n = if self.options.leading_edge_suction { force_n } else { now.up * now.up.dot(&force_n) };
            let [leading_m, trailing_m] = now.cut.arms_m[end];
            loads[strip.sections[end]].add_force_at(&(leading_m + (trailing_m - leading_m) * fraction), &force_n);
        }
    }
}
