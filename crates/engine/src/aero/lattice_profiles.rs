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

use crate::aero::biot_savart::{LANES, blocks};
use crate::aero::linear_system::LinearSystem;
use crate::aero::strip::section::{Cut, Strip};
use crate::aero::surface::{Profile, Surface};
use pulp::Arch;
use std::f64::consts::{PI, TAU};

/// Maximum number of Newton iterations between two solutions: with polars, one for each linear segment that the strips cross.
const MAXIMUM_ITERATIONS: usize = 100;
/// Maximum number of halvings of a Newton step before a relaxed fixed-point step is taken instead.
const MAXIMUM_HALVINGS: usize = 12;
/// Relaxation factor of the fixed-point step; below 1 because of the mutual induction of the strips.
const RELAXATION_FACTOR: f64 = 0.3;

/// Maximum number of relaxation steps to a steady flow beyond stall: planar wings with 12 to 40 strips need up to 600 for 1e-13.
const MAXIMUM_RELAXATIONS: usize = 3000;
/// Strips whose profile is not a thin plate, with their scratch.
#[derive(Debug, Clone)]
pub(super) struct LatticeProfiles {
    pub strips: Vec<ProfileStrip>,
    pub met: Vec<Met>,
    pub profiles: Vec<Profile>,
    /// Circulation in m of strip `i` for a unit velocity through strip `j`, at `[j · strips + i]`, for the factors in use.
    pub gains_m: Vec<f64>,
    /// Whether the gains belong to the factors in use.
    pub has_gains: bool,
    pub newton: LinearSystem,
    /// For all strips in m/s: velocity at the last solution, thin-plate velocity there, trial velocity, velocity at the start of the
    /// current Newton step, that step, and residual.
    pub solved_m_s: Vec<f64>,
    pub thin_m_s: Vec<f64>,
    pub trial_m_s: Vec<f64>,
    pub base_m_s: Vec<f64>,
    pub step_m_s: Vec<f64>,
    pub residual_m_s: Vec<f64>,
    pub column: Vec<f64>,
    /// Velocities of all strips at the start of the time step in m/s, or the initial ones of a steady flow.
    pub begin_m_s: Vec<f64>,
    /// Length of the time step in s; `None` for steady flows.
    pub step_s: Option<f64>,
}

/// A strip and its position in the lattice.
#[derive(Debug, Clone)]
pub(super) struct ProfileStrip {
    pub strip: Strip,
    /// Panels in the equations: the foremost, their number along the chord, and their stride.
    pub first_panel: usize,
    pub rows: usize,
    pub stride: usize,
    /// Index of its first ring.
    pub first_ring: usize,
}

/// Inflow of a strip at the current instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Met {
    pub cut: Cut,
    /// Velocity of the air from leading to trailing edge in the strip's cut, without induced velocities, in m/s.
    pub along_m_s: f64,
}

impl ProfileStrip {
    pub fn panels(&self) -> impl Iterator<Item = usize> + use<> {
        (self.first_panel..).step_by(self.stride).take(self.rows)
    }

    pub fn rear_panel(&self) -> usize {
        self.first_panel + (self.rows - 1) * self.stride
    }

    /// Whether the lift of the polar at this thin-plate angle is lower than at a smaller one.
    pub fn is_beyond_stall(&self, profiles: &[Profile], met: &Met, thin_m_s: f64) -> bool {
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
    pub fn find_gains(&mut self, arch: Arch, system: &LinearSystem) {
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
    pub fn find_residuals(&mut self) -> f64 {
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
    pub fn iterate(&mut self, allowed_m_s: f64) {
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
    pub fn relax(&mut self, allowed_m_s: f64) -> bool {
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
