//! Profiles in the lattice: camber, lift slope and polars by a velocity through the panels of each strip; profile drag and moment: eqs.
//! (U27) to (U29).
//!
//! Without this the lattice is a thin plate. Any other profile has the circulation given by its coefficients at the effective angle: the
//! angle at which a thin plate would have the circulation of the strip, which includes the induced velocities of wake, other strips and
//! other surfaces. The velocities of all strips are coupled through the lattice and are computed by Newton's method.
//!
//! Beyond stall, where the lift falls with the angle, mutually inducing neighbouring strips may have several circulations, and Newton's
//! method does not converge. A steady flow is then found by relaxation from attached flow, or from the flow before a small change of the
//! motion. In a step all strips follow their polars with a lag, eq. (U32), as long as one of them is beyond stall or differs from its
//! polar.

use crate::aero::AirLoads;
use crate::aero::biot_savart::{LANES, blocks};
use crate::aero::flow::Flow;
use crate::aero::lattice::VortexLattice;
use crate::aero::lattice_state::LatticeState;
use crate::aero::linear_system::LinearSystem;
use crate::aero::near_sheets::NoCirculation;
use crate::aero::polar::PolarRow;
use crate::aero::strip::section::{Cut, Strip};
use crate::aero::surface::{Profile, Surface};
use crate::load::SectionMotion;
use pulp::Arch;
use std::f64::consts::{PI, TAU};

/// Convergence threshold of the strips' velocities, relative to the flow speed: round-off of the lattice's circulation.
const ROUND_OFF: f64 = 1e-12;
/// Maximum number of solutions of the lattice for one set of velocities. The factors are nearly exact, so that each solution reduces the
/// error to a twentieth or less.
const MAXIMUM_SOLUTIONS: usize = 40;
/// Maximum number of Newton iterations between two solutions: with polars, one for each linear segment that the strips cross.
const MAXIMUM_ITERATIONS: usize = 100;
/// Maximum number of halvings of a Newton step before a relaxed fixed-point step is taken instead.
const MAXIMUM_HALVINGS: usize = 12;
/// Relaxation factor of the fixed-point step; below 1 because of the mutual induction of the strips.
const RELAXATION_FACTOR: f64 = 0.3;

/// Maximum number of relaxation steps to a steady flow beyond stall: planar wings with 12 to 40 strips need up to 600 for 1e-13.
const MAXIMUM_RELAXATIONS: usize = 3000;
/// Residual, relative to the flow speed, at which relaxation ends and Newton's method takes over.
const RELAXED: f64 = 1e-9;
/// Time constant of the boundary-layer lag in semi-chords travelled, as for the dynamic stall of rotors, eq. (U32).
const STALL_LAG: f64 = 3.0;
/// Residual, relative to the flow speed, below which the lag ends if no strip is beyond stall: a hundredth of the lift coefficient.
const CAUGHT_UP: f64 = 2e-3;

/// Method to find a steady flow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Search {
    /// Newton's method from the current velocities.
    Newton,
    /// Relaxation to the neighbourhood of the solution, then Newton's method.
    Relaxation,
}

/// Strips whose profile is not a thin plate, with their scratch.
#[derive(Debug, Clone)]
pub(super) struct LatticeProfiles {
    strips: Vec<ProfileStrip>,
    met: Vec<Met>,
    profiles: Vec<Profile>,
    /// Circulation in m of strip `i` for a unit velocity through strip `j`, at `[j · strips + i]`, for the factors in use.
    pub gains_m: Vec<f64>,
    /// Whether the gains belong to the factors in use.
    pub has_gains: bool,
    newton: LinearSystem,
    /// For all strips in m/s: velocity at the last solution, thin-plate velocity there, trial velocity, velocity at the start of the
    /// current Newton step, that step, and residual.
    solved_m_s: Vec<f64>,
    thin_m_s: Vec<f64>,
    trial_m_s: Vec<f64>,
    base_m_s: Vec<f64>,
    step_m_s: Vec<f64>,
    residual_m_s: Vec<f64>,
    column: Vec<f64>,
    /// Velocities of all strips at the start of the time step in m/s, or the initial ones of a steady flow.
    begin_m_s: Vec<f64>,
    /// Length of the time step in s; `None` for steady flows.
    pub step_s: Option<f64>,
}

/// A strip and its position in the lattice.
#[derive(Debug, Clone)]
struct ProfileStrip {
    strip: Strip,
    /// Panels in the equations: the foremost, their number along the chord, and their stride.
    first_panel: usize,
    rows: usize,
    stride: usize,
    /// Index of its first ring.
    first_ring: usize,
}

/// Inflow of a strip at the current instant.
#[derive(Debug, Clone, Copy)]
struct Met {
    cut: Cut,
    /// Velocity of the air from leading to trailing edge in the strip's cut, without induced velocities, in m/s.
    along_m_s: f64,
}

impl ProfileStrip {
    fn panels(&self) -> impl Iterator<Item = usize> + use<> {
        (self.first_panel..).step_by(self.stride).take(self.rows)
    }

    fn rear_panel(&self) -> usize {
        self.first_panel + (self.rows - 1) * self.stride
    }

    /// Whether the lift of the polar at this thin-plate angle is lower than at a smaller one.
    fn is_beyond_stall(&self, profiles: &[Profile], met: &Met, thin_m_s: f64) -> bool {
        let polar = profiles[self.strip.surface].polar.as_ref();
        polar.is_some_and(|polar| polar.is_beyond_stall(thin_m_s.atan2(met.along_m_s)))
    }

    /// Velocity in m/s through a thin plate that has the circulation of this profile, and its derivative with respect to `thin_m_s`: eq.
    /// (U28).
    fn wanted(&self, profile: &Profile, along_m_s: f64, thin_m_s: f64) -> (f64, f64) {
        match &profile.polar {
            None => {
                let (sine, cosine) = profile.zero_lift_angle_rad.sin_cos();
                let slope = self.strip.lift_slope_1_rad / TAU;
                (slope * (thin_m_s * cosine - along_m_s * sine), slope * cosine)
            }
            Some(polar) => {
                let speed_m_s = along_m_s.hypot(thin_m_s);
                if speed_m_s == 0.0 {
                    return (0.0, 1.0);
                }
                let (row, slope) = polar.at_with_lift_slope(thin_m_s.atan2(along_m_s));
                let rate = (row.lift * thin_m_s + slope * along_m_s) / speed_m_s;
                (row.lift * speed_m_s / TAU, rate / TAU)
            }
        }
    }
}

impl LatticeProfiles {
    /// Collects the strips whose profile is not a thin plate, for a lattice with these first panels and first rings of the surfaces.
    pub fn new(surfaces: &[Surface], first: impl Iterator<Item = [usize; 2]>) -> Self {
        let mut strips = Vec::new();
        for (index, (surface, [first_panel, first_ring])) in surfaces.iter().zip(first).enumerate() {
            if surface.profile.is_thin() {
                continue;
            }
            let own = surface.strips();
            strips.extend((0..own).map(|strip| ProfileStrip {
                strip: Strip {
                    sections: [surface.sections.start + strip, surface.sections.start + strip + 1],
                    chords: [surface.chords[strip], surface.chords[strip + 1]],
                    surface: index,
                    lift_slope_1_rad: surface.profile.lift_slope_of_strip_1_rad(strip),
                    speed_of_sound_m_s: f64::INFINITY,
                },
                first_panel: first_panel + strip,
                rows: surface.chord_panels,
                stride: own,
                first_ring: first_ring + strip,
            }));
        }
        let (count, panels) = (strips.len(), surfaces.iter().map(Surface::panels).sum());
        let zero = vec![0.0; count];
        Self {
            met: Vec::with_capacity(count),
            profiles: surfaces.iter().map(|surface| surface.profile.clone()).collect(),
            gains_m: vec![0.0; count * count],
            has_gains: false,
            newton: LinearSystem::new(count, blocks(count) * LANES),
            solved_m_s: zero.clone(),
            thin_m_s: zero.clone(),
            trial_m_s: zero.clone(),
            base_m_s: zero.clone(),
            step_m_s: zero.clone(),
            begin_m_s: zero.clone(),
            step_s: None,
            residual_m_s: zero,
            column: vec![0.0; if count > 0 { panels } else { 0 }],
            strips,
        }
    }

    /// Number of strips with a velocity through their panels.
    pub fn count(&self) -> usize {
        self.strips.len()
    }

    /// Computes the circulation of each strip for a unit velocity through another one, with the factors of a lattice.
    fn find_gains(&mut self, arch: Arch, system: &LinearSystem) {
        let Self { strips, gains_m, column, .. } = self;
        for (strip, gains_m) in strips.iter().zip(gains_m.chunks_exact_mut(strips.len())) {
            column.fill(0.0);
            strip.panels().for_each(|panel| column[panel] = 1.0);
            system.solve(arch, column);
            gains_m.iter_mut().zip(strips.iter()).for_each(|(gain_m, strip)| *gain_m = column[strip.rear_panel()]);
        }
        self.has_gains = true;
    }

    /// Downwash in m/s of the thin plate equivalent to strip `i` at the trial velocities, by the gains.
    fn thin_m_s(&self, i: usize) -> f64 {
        let count = self.count();
        let changes = self.trial_m_s.iter().zip(&self.solved_m_s).map(|(trial, solved)| trial - solved);
        let circulation_m2_s: f64 = changes.enumerate().map(|(j, change)| self.gains_m[j * count + i] * change).sum();
        let own_m_s = self.trial_m_s[i] - self.solved_m_s[i];
        self.thin_m_s[i] + circulation_m2_s / (PI * self.met[i].cut.chord_m) - own_m_s
    }

    /// Residuals at the trial velocities, and their sum of squares in m²/s².
    fn find_residuals(&mut self) -> f64 {
        let mut sum = 0.0;
        for i in 0..self.count() {
            let thin_m_s = self.thin_m_s(i);
            let strip = &self.strips[i];
            let wanted_m_s = strip.wanted(&self.profiles[strip.strip.surface], self.met[i].along_m_s, thin_m_s).0;
            self.residual_m_s[i] = wanted_m_s - thin_m_s - self.trial_m_s[i];
            sum += self.residual_m_s[i].powi(2);
        }
        sum
    }

    /// Whether any strip is beyond stall in the last solution.
    pub fn is_beyond_stall(&self) -> bool {
        let strips = self.strips.iter().zip(self.met.iter().zip(&self.thin_m_s));
        strips.into_iter().any(|(strip, (met, thin_m_s))| strip.is_beyond_stall(&self.profiles, met, *thin_m_s))
    }

    /// Sets the trial velocities to the start of the Newton step plus a fraction of the step.
    fn go(&mut self, share: f64) {
        let ends = self.base_m_s.iter().zip(&self.step_m_s).map(|(base, step)| base + share * step);
        self.trial_m_s.iter_mut().zip(ends).for_each(|(trial, end)| *trial = end);
    }

    /// Iterates from the trial velocities to those for which all profiles have their circulation according to the gains.
    fn iterate(&mut self, allowed_m_s: f64) {
        let count = self.count();
        let mut before = self.find_residuals();
        for _ in 0..MAXIMUM_ITERATIONS {
            if self.residual_m_s.iter().all(|residual| residual.abs() <= allowed_m_s) {
                return;
            }
            self.newton.cleared();
            for i in 0..count {
                let strip = &self.strips[i];
                let profile = &self.profiles[strip.strip.surface];
                let slope = strip.wanted(profile, self.met[i].along_m_s, self.thin_m_s(i)).1;
                for j in 0..count {
                    let own = if i == j { 1.0 } else { 0.0 };
                    let thin = self.gains_m[j * count + i] / (PI * self.met[i].cut.chord_m) - own;
                    self.newton.add(i, j, own - (slope - 1.0) * thin);
                }
            }
            let arch = Arch::new();
            self.step_m_s.copy_from_slice(&self.residual_m_s);
            let solvable = self.newton.factorize(arch).is_ok();
            if solvable {
                self.newton.solve(arch, &mut self.step_m_s);
            }
            self.base_m_s.copy_from_slice(&self.trial_m_s);
            let mut share = 1.0;
            let shorter = solvable
                && (0..MAXIMUM_HALVINGS).any(|_| {
                    self.go(share);
                    share *= 0.5;
                    self.find_residuals() < before
                });
            if !shorter {
                self.go(0.0);
                self.find_residuals();
                let pairs = self.trial_m_s.iter_mut().zip(&self.residual_m_s);
                pairs.for_each(|(trial, residual)| *trial += RELAXATION_FACTOR * residual);
                self.find_residuals();
            }
            before = self.residual_m_s.iter().map(|residual| residual * residual).sum();
        }
    }

    /// Relaxed fixed-point iteration from the trial velocities; returns whether it converges.
    fn relax(&mut self, allowed_m_s: f64) -> bool {
        for _ in 0..MAXIMUM_RELAXATIONS {
            self.find_residuals();
            if self.residual_m_s.iter().all(|residual| residual.abs() <= allowed_m_s) {
                return true;
            }
            let pairs = self.trial_m_s.iter_mut().zip(&self.residual_m_s);
            pairs.for_each(|(trial, residual)| *trial += RELAXATION_FACTOR * residual);
        }
        false
    }
}

impl VortexLattice {
    /// Computes the circulation for which every strip has the lift of its profile, eqs. (U27) and (U28). `right` holds the velocity of the
    /// air through the panels.
    pub(super) fn circulate_profiles(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        state: &mut LatticeState,
    ) -> Result<(), NoCirculation> {
        let Self { profiles, bound, .. } = self;
        let LatticeProfiles { strips, met, .. } = profiles;
        met.clear();
        met.extend(strips.iter().map(|strip| {
            let cut = strip.strip.cut(motions, flow);
            let rings = (strip.first_ring..).step_by(bound[strip.strip.surface].ring_stride).take(strip.rows);
            // without vortices: the bound part of the wake depends on the step, and in steady flow the whole wake is bound
            let undisturbed_m_s = |ring: usize| flow.velocity_m_s(&state.collocation_m[ring]) - state.surface_m_s[ring];
            let along_m_s = rings.map(|ring| undisturbed_m_s(ring).dot(&cut.aft)).sum::<f64>() / strip.rows as f64;
            Met { cut, along_m_s }
        }));
        let mut through_m_s = std::mem::take(&mut state.profile_m_s);
        let outcome = self.find_profiles(state, &mut through_m_s);
        state.profile_m_s = through_m_s;
        outcome
    }

    fn find_profiles(&mut self, state: &mut LatticeState, through_m_s: &mut [f64]) -> Result<(), NoCirculation> {
        self.profiles.solved_m_s.fill(0.0);
        self.profiles.begin_m_s.copy_from_slice(through_m_s);
        let step_s = self.profiles.step_s;
        if !(state.lags && step_s.is_some()) {
            match self.settle_profiles(state, through_m_s, Search::Newton) {
                Err(NoCirculation::Profile(_)) => {}
                // without the lag, a step that follows the falling lift immediately departs from every steady flow
                Ok(()) if step_s.is_some() && self.profiles.is_beyond_stall() => {}
                outcome => return outcome,
            }
        }
        match step_s {
            None => {
                through_m_s.copy_from_slice(&self.profiles.begin_m_s);
                match self.settle_profiles(state, through_m_s, Search::Relaxation) {
                    // no solution near the initial velocities: start from attached flow
                    Err(NoCirculation::Profile(_))
                        if self.profiles.begin_m_s.iter().any(|begin_m_s| *begin_m_s != 0.0) =>
                    {
                        through_m_s.fill(0.0);
                        self.settle_profiles(state, through_m_s, Search::Relaxation)
                    }
                    outcome => outcome,
                }
            }
            Some(step_s) => {
                through_m_s.copy_from_slice(&self.profiles.begin_m_s);
                state.lags = self.lag_profiles(state, through_m_s, step_s)?;
                Ok(())
            }
        }
    }

    /// Solves the lattice with these velocities through its strips.
    fn solve_through(&mut self, state: &LatticeState, through_m_s: &[f64]) -> Result<(), NoCirculation> {
        for (at, strip) in self.profiles.strips.iter().enumerate() {
            let change_m_s = through_m_s[at] - self.profiles.solved_m_s[at];
            strip.panels().for_each(|panel| self.right[panel] += change_m_s);
        }
        self.profiles.solved_m_s.copy_from_slice(through_m_s);
        self.solve_right(state)
    }

    /// Solves the lattice and computes the residuals of these velocities; returns the largest speed of a strip in m/s.
    fn look_through(&mut self, state: &LatticeState, through_m_s: &[f64]) -> Result<f64, NoCirculation> {
        self.solve_through(state, through_m_s)?;
        let profiles = &mut self.profiles;
        let mut speed_m_s = 0.0_f64;
        for (at, strip) in profiles.strips.iter().enumerate() {
            let met = &profiles.met[at];
            let thin_m_s = self.solution[strip.rear_panel()] / (PI * met.cut.chord_m) - through_m_s[at];
            profiles.thin_m_s[at] = thin_m_s;
            speed_m_s = speed_m_s.max(met.along_m_s.hypot(thin_m_s));
        }
        profiles.trial_m_s.copy_from_slice(through_m_s);
        profiles.find_residuals();
        // NaN must not pass for the smallest residual
        match profiles.residual_m_s.iter().position(|residual| !residual.is_finite()) {
            Some(at) => Err(NoCirculation::Profile(profiles.strips[at].strip.surface)),
            None => Ok(speed_m_s),
        }
    }

    /// Advances the strips' velocities to the end of a step with a lag towards those of the profiles, eq. (U32); returns whether they still
    /// differ.
    fn lag_profiles(
        &mut self,
        state: &LatticeState,
        through_m_s: &mut [f64],
        step_s: f64,
    ) -> Result<bool, NoCirculation> {
        self.look_through(state, through_m_s)?;
        let profiles = &self.profiles;
        let mut lags = false;
        for (at, through_m_s) in through_m_s.iter_mut().enumerate() {
            let met = &profiles.met[at];
            let speed_m_s = met.along_m_s.hypot(profiles.thin_m_s[at]);
            let semi_chords = 2.0 * speed_m_s * step_s / met.cut.chord_m;
            lags |= profiles.residual_m_s[at].abs() > CAUGHT_UP * speed_m_s;
            *through_m_s -= (-semi_chords / STALL_LAG).exp_m1() * profiles.residual_m_s[at];
        }
        lags |= profiles.is_beyond_stall();
        self.solve_through(state, through_m_s)?;
        Ok(lags)
    }

    fn settle_profiles(
        &mut self,
        state: &LatticeState,
        through_m_s: &mut [f64],
        search: Search,
    ) -> Result<(), NoCirculation> {
        let mut worst = 0;
        for _ in 0..MAXIMUM_SOLUTIONS {
            let speed_m_s = self.look_through(state, through_m_s)?;
            let profiles = &mut self.profiles;
            let residuals = profiles.residual_m_s.iter().map(|residual| residual.abs()).enumerate();
            let (at, largest_m_s) =
                residuals.fold((0, 0.0), |largest, next| if next.1 > largest.1 { next } else { largest });
            if largest_m_s <= ROUND_OFF * speed_m_s {
                return Ok(());
            }
            worst = profiles.strips[at].strip.surface;
            if !profiles.has_gains {
                profiles.find_gains(self.arch, &self.system);
            }
            match search {
                Search::Newton => profiles.iterate(0.1 * ROUND_OFF * speed_m_s),
                // close to the solution Newton's method converges, although it does not find the solution on its own
                Search::Relaxation if profiles.relax(RELAXED * speed_m_s) => {
                    profiles.iterate(0.1 * ROUND_OFF * speed_m_s);
                }
                Search::Relaxation => break,
            }
            through_m_s.copy_from_slice(&profiles.trial_m_s);
        }
        Err(NoCirculation::Profile(worst))
    }

    /// Surfaces with strips beyond stall in the last solution of the lattice.
    pub fn surfaces_beyond_stall<'a>(&'a self, state: &'a LatticeState) -> impl Iterator<Item = usize> + 'a {
        let LatticeProfiles { strips, met, profiles, .. } = &self.profiles;
        let strips = strips.iter().zip(met).zip(&state.profile_m_s);
        let beyond = strips.filter(|((strip, met), through_m_s)| {
            let surface = strip.strip.surface;
            let rear = strip.first_ring + (strip.rows - 1) * self.bound[surface].ring_stride;
            let thin_m_s = state.circulation_m2_s[rear] / (PI * met.cut.chord_m) - *through_m_s;
            strip.is_beyond_stall(profiles, met, thin_m_s)
        });
        beyond.map(|((strip, _), _)| strip.strip.surface)
    }

    /// Computes drag and moment of the profiles, eq. (U29). The lift is that of the lattice.
    pub(super) fn profile_loads(&self, density_kg_m3: f64, state: &LatticeState, loads: &mut AirLoads) {
        let LatticeProfiles { strips, met, profiles, .. } = &self.profiles;
        for ((strip, met), through_m_s) in strips.iter().zip(met).zip(&state.profile_m_s) {
            let profile = &profiles[strip.strip.surface];
            let Met { cut, along_m_s } = met;
            let rear = strip.first_ring + (strip.rows - 1) * self.bound[strip.strip.surface].ring_stride;
            let thin_m_s = state.circulation_m2_s[rear] / (PI * cut.chord_m) - through_m_s;
            let PolarRow { drag, moment, .. } = match &profile.polar {
                Some(polar) => polar.at(thin_m_s.atan2(*along_m_s)),
                None => PolarRow {
                    angle_rad: 0.0,
                    lift: 0.0,
                    drag: profile.drag_coefficient,
                    moment: profile.moment_coefficient,
                },
            };
            let speed_m_s = along_m_s.hypot(thin_m_s);
            let pressure_n_m = 0.5 * density_kg_m3 * speed_m_s * cut.chord_m * cut.span_m;
            let force_n = (cut.aft * *along_m_s + cut.up * thin_m_s) * (pressure_n_m * drag);
            strip.strip.add_force(&mut loads.circulatory, cut, 0.25, &force_n);
            let moment_n_m = pressure_n_m * speed_m_s * cut.chord_m * moment;
            strip.strip.add_moment(&mut loads.circulatory, cut, moment_n_m);
        }
    }
}
