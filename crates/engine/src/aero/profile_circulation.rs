//! Circulation of a lattice with profiles: the velocities through its strips by Newton's method, by relaxation beyond stall, or with a lag
//! in a step, eqs. (U28) and (U32); loads of the profiles, eq. (U29).

use crate::aero::AirLoads;
use crate::aero::flow::Flow;
use crate::aero::lattice::VortexLattice;
use crate::aero::lattice_profiles::{LatticeProfiles, Met};
use crate::aero::lattice_state::LatticeState;
use crate::aero::near_sheets::NoCirculation;
use crate::aero::polar::PolarRow;
use crate::load::SectionMotion;
use std::f64::consts::PI;

/// Convergence threshold of the strips' velocities, relative to the flow speed: round-off of the lattice's circulation.
const ROUND_OFF: f64 = 1e-12;
/// Maximum number of solutions of the lattice for one set of velocities. The factors are nearly exact, so that each solution reduces the
/// error to a twentieth or less.
const MAXIMUM_SOLUTIONS: usize = 40;
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
