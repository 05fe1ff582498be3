//! Blade-element momentum theory for a rotor whose blades are surfaces of moving bodies.
//!
//! The sections of all blades come first, blade by blade, followed by one section of the hub, whose point is the rotor's apex. Each annulus
//! is normal to its blade as bent out of the plane of rotation, without twist, pitch and in-plane bending, as in AeroDyn. By default the
//! loads are linear between the sections.

use crate::aero::AirLoads;
use crate::aero::flow::Flow;
use crate::aero::pieces::{Holding, PieceList, Pieces};
use crate::aero::rotor::disc::{Cut, Disc, NO_CUT, downwind};
use crate::aero::rotor::dynamic_inflow::{InflowState, lags_on_s, time_constant_on_s};
use crate::aero::rotor::dynamic_stall::{SplitPolar, StallInflow, StallState};
use crate::aero::rotor::induction::{Annulus, Approach, EndRule, aerodyn_balance, aerodyn_limited, balance_on};
use crate::aero::rotor::inflow_lag::{Lagging, Meeting};
use crate::aero::rotor::loads::RotorLoads;
pub use crate::aero::rotor::options::{PitchRate, RotorFeatures, RotorOptions, Spread};
use crate::aero::rotor::pieces::RotorPieces;
use crate::aero::rotor::states::RotorLag;
pub use crate::aero::rotor::states::{RotorState, SectionMemory};
use crate::aero::surface::{ChordLine, Surface};
use crate::load::SectionMotion;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Constant data of a section.
pub(super) struct Section {
    chord: ChordLine,
    chord_m: f64,
    pub(super) polar: usize,
    /// Radius of the straight blade in m.
    radius_m: f64,
    /// Exponents of Prandtl's tip and hub loss of the straight blade: `B (R − r)/(2 r)` and `B (r − r_h)/(2 r_h)`.
    pub(super) exponents: [f64; 2],
}

/// Rotor of moving blades by blade-element momentum theory.
pub struct Rotor {
    pub(super) options: RotorOptions,
    pub(super) blades: Vec<std::ops::Range<usize>>,
    /// Number of blades of the rotor divided by the number in the model.
    pub(super) like: f64,
    pub(super) sections: Vec<Section>,
    pub(super) splits: Vec<Option<SplitPolar>>,
    pub(super) cuts: Vec<Cut>,
    /// Last momentum balances of the annuli, kept because the passes of a step and neighbouring motions repeat most of them.
    pub(super) balances: Vec<Option<(Annulus, Approach, [f64; 2])>>,
    /// Fraction of the induction in the last evaluation, eq. (B7).
    pub(super) share: f64,
    /// Section whose momentum balance jumps between neighbouring instants.
    pub(super) jump: Option<usize>,
    /// Lag states at an instant with their sections.
    pub(super) lags: Vec<(usize, RotorLag)>,
    /// State and loads of the last response at an instant.
    pub(super) instant: (RotorState, AirLoads),
    /// Use of the pieces of its functions in evaluations.
    pub holding: Holding<RotorPieces>,
}

impl Rotor {
    /// Creates a rotor from these surfaces, one per blade.
    pub fn new(surfaces: &[Surface], options: &RotorOptions) -> Self {
        let blades = options.features.blades.unwrap_or(surfaces.len()) as f64;
        let half = 0.5 * blades;
        let mut sections = Vec::new();
        for (blade, surface) in surfaces.iter().enumerate() {
            let positions_m = &options.positions_m[blade];
            let hub_m = options.features.hub_radius_m;
            let tip_m = hub_m + positions_m[positions_m.len() - 1];
            for (section, chord) in surface.chords.iter().enumerate() {
                let radius_m = hub_m + positions_m[section];
                let [tip, hub] = options.features.losses;
                sections.push(Section {
                    chord: *chord,
                    chord_m: chord.length_m(),
                    polar: options.sections[blade][section],
                    radius_m,
                    exponents: [
                        if tip { half * (tip_m - radius_m) / radius_m } else { f64::INFINITY },
                        if hub && hub_m > 0.0 { half * (radius_m - hub_m) / hub_m } else { f64::INFINITY },
                    ],
                });
            }
        }
        let splits = options.polars.iter().map(|polar| SplitPolar::new(polar.clone()));
        let mut rotor = Self {
            blades: surfaces.iter().map(|surface| surface.sections.clone()).collect(),
            like: blades / surfaces.len().max(1) as f64,
            cuts: vec![NO_CUT; sections.len()],
            balances: vec![None; sections.len()],
            share: 0.0,
            jump: None,
            lags: Vec::new(),
            instant: Default::default(),
            holding: Holding::Free,
            splits: splits.map(|split| split.filter(|_| options.features.dynamic_stall)).collect(),
            sections,
            options: options.clone(),
        };
        rotor.lags = rotor.list_lags();
        // the section of the hub follows those of the blades
        rotor.instant = (rotor.blank_state(), AirLoads::still(rotor.sections.len() + 1));
        rotor
    }

    /// Index of a blade whose axis points along the shaft and has no direction in the disc; such a blade carries no load.
    pub fn blade_along_shaft(&self, motions: &[SectionMotion]) -> Option<usize> {
        let normal = motions[self.sections.len()].rotation * self.options.shaft_axis;
        self.blades.iter().position(|range| {
            let along = motions[range.start].rotation.column(0).into_owned();
            (along - normal * along.dot(&normal)).norm() < 1e-6
        })
    }

    /// Index of the blade of a section.
    pub fn blade_of(&self, section: usize) -> usize {
        self.blades.iter().position(|range| range.contains(&section)).unwrap_or_default()
    }

    /// Quarter-chord point of a section in the section's frame, in m.
    pub(super) fn quarter_m(&self, section: usize) -> Vector3<f64> {
        self.sections[section].chord.at(0.25)
    }

    /// Chord of a section in m.
    pub(super) fn chord_m(&self, section: usize) -> f64 {
        self.sections[section].chord_m
    }

    /// Computes the initial state and its loads; with `steady_initial_flow` the wake is fully developed.
    pub fn start(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        established: bool,
        state: &mut RotorState,
        loads: &mut AirLoads,
    ) {
        self.look(motions, flow, if established { Past::Settled } else { Past::Still }, state, loads);
    }

    /// Computes state and loads after a step of `step_s` from `from`, for the motions and the flow at its end.
    pub fn solve(
        &mut self,
        from: &RotorState,
        motions: &[SectionMotion],
        flow: &Flow,
        step_s: f64,
        to: &mut RotorState,
        loads: &mut AirLoads,
    ) {
        self.look(motions, flow, Past::Known { from, step_s }, to, loads);
    }

    pub(super) fn look(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        past: Past,
        state: &mut RotorState,
        loads: &mut AirLoads,
    ) {
        loads.clear();
        let mut holding = std::mem::take(&mut self.holding);
        let mut disc = self.meet(motions, flow, &mut holding);
        self.share = disc.share;
        let RotorFeatures { dynamic_inflow, aerodyn_compatible, .. } = self.options.features;
        let mut induction = match past {
            Past::Known { from, .. } => from.loads.induction,
            Past::Settled | Past::Still | Past::Given => 0.0,
        };
        // the first pass uses the induction at the start of the step, the second the resulting one at its end
        let passes = if dynamic_inflow && !aerodyn_compatible && matches!(past, Past::Known { .. }) { 2 } else { 1 };
        if let Holding::Record(pieces) = &mut holding {
            let sections = vec![PieceList::default(); self.sections.len()];
            (pieces.wakes, pieces.ends) = (vec![PieceList::default(); passes + 1], sections.clone());
            pieces.sections = vec![sections; passes];
        }
        for pass in 0..passes {
            let wake = &mut holding.pieces(|pieces| &mut pieces.wakes[pass]);
            let first_s = time_constant_on_s(disc.radius_m, induction, disc.loads.wind_m_s, wake);
            induction = self.load_sections(motions, flow, &disc, &past, first_s, state, (&mut holding, pass));
        }
        if dynamic_inflow {
            let wake = &mut holding.pieces(|pieces| &mut pieces.wakes[passes]);
            let first_s = time_constant_on_s(disc.radius_m, induction, disc.loads.wind_m_s, wake);
            for (index, (cut, memory)) in self.cuts.iter().zip(&mut state.sections).enumerate() {
                let end = &mut holding.pieces(|pieces| &mut pieces.ends[index]);
                memory.inflow.lags_s = lags_on_s(first_s, cut.radial_m.norm() / disc.radius_m, end);
            }
        }
        self.holding = holding;
        disc.loads.induction = induction;
        self.spread(loads, &mut disc);
        let RotorLoads { thrust_n, power_w, wind_m_s, .. } = disc.loads;
        let pressure_n = 0.5 * flow.density_kg_m3 * PI * disc.radius_m.powi(2) * wind_m_s.powi(2);
        if disc.has_wind && pressure_n > 0.0 {
            disc.loads.thrust_coefficient = thrust_n / pressure_n;
            disc.loads.power_coefficient = power_w / (pressure_n * wind_m_s.abs());
        }
        state.loads = disc.loads;
    }

    /// Computes the line loads of all sections, into the scratch, and their current states; returns the mean axial induced velocity divided
    /// by the mean wind, 0 without wind. `first_s` is the time constant of the wake at the end of a step.
    #[allow(clippy::too_many_arguments)] // one call, split off for its length
    fn load_sections(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        disc: &Disc,
        past: &Past,
        first_s: f64,
        state: &mut RotorState,
        (holding, pass): (&mut Holding<RotorPieces>, usize),
    ) -> f64 {
        let (mut lost_m_s, mut met_m_s) = (0.0, 0.0);
        for blade in 0..self.blades.len() {
            let range = self.blades[blade].clone();
            let root = motions[range.start].rotation.column(0).into_owned();
            let Some([ahead, root_normal]) = Self::directions(disc, &root) else { continue };
            for index in range {
                let memory = &mut state.sections[index];
                let pieces = &mut holding.pieces(|pieces| &mut pieces.sections[pass][index]);
                let directions = [&ahead, &root_normal];
                let met = self.section(index, &motions[index], disc, directions, flow, past, first_s, memory, pieces);
                if let Some(met) = met {
                    let weight = self.weight(index);
                    lost_m_s += weight * met[0];
                    met_m_s += weight * met[1];
                }
            }
        }
        if disc.has_wind && met_m_s != 0.0 { lost_m_s / met_m_s } else { 0.0 }
    }

    /// Weight of a section in the mean induction: its distance from the shaft, 1 for compatibility with AeroDyn.
    pub(super) fn weight(&self, index: usize) -> f64 {
        if self.options.features.aerodyn_compatible { 1.0 } else { self.cuts[index].radial_m.norm() }
    }

    /// Adds the line load and moment of one section to the scratch; returns its axial induced velocity and its wind in m/s if the momentum
    /// balance has a solution. With `aerodyn_compatible` both are divided by that wind, because AeroDyn averages induction factors.
    #[allow(clippy::too_many_arguments)] // one call, split off for its length
    pub(super) fn section(
        &mut self,
        index: usize,
        motion: &SectionMotion,
        disc: &Disc,
        [ahead, root_normal]: [&Vector3<f64>; 2],
        flow: &Flow,
        past: &Past,
        first_s: f64,
        memory: &mut SectionMemory,
        pieces: &mut Pieces,
    ) -> Option<[f64; 2]> {
        let section = &self.sections[index];
        let cut = &mut self.cuts[index];
        let axis = motion.rotation.column(0).into_owned();
        let tangent = (axis - ahead * axis.dot(ahead)).try_normalize(1e-9)?;
        let normal = downwind(tangent.cross(ahead), &disc.normal);
        let radius_m = cut.radial_m.norm();
        let annulus = Annulus {
            solidity: 0.5 * self.like * self.blades.len() as f64 * section.chord_m / (PI * radius_m.max(1e-9)),
            tip_exponent: section.exponents[0],
            hub_exponent: section.exponents[1],
        };
        let chord = motion.rotation * (section.chord.leading_m - section.chord.trailing_m);
        let chord_angle_rad = if self.options.features.aerodyn_compatible {
            // measured from the direction of the chord on the cone of the undeflected blade, about the axis of the section
            let level = (root_normal.cross(&axis) * disc.turn).try_normalize(1e-9)?;
            (-chord.dot(&(axis.cross(&level) * disc.turn))).atan2(chord.dot(&level))
        } else {
            (-chord.dot(&normal)).atan2(chord.dot(ahead))
        };
        let approach = Approach {
            axial_m_s: cut.relative_m_s.dot(&normal),
            tangential_m_s: -cut.relative_m_s.dot(ahead),
            chord_angle_rad,
        };
        let polar = &self.options.polars[section.polar];
        let pitching = ahead.cross(&normal);
        let meeting = Meeting {
            approach,
            polar,
            chord_m: section.chord_m,
            pitch_rate_rad_s: match self.options.features.pitch_rate {
                PitchRate::None => 0.0,
                PitchRate::Hub => (motion.spin_rad_s - disc.hub_rad_s).dot(&pitching),
                PitchRate::Air => (motion.spin_rad_s + flow.spin_rad_s).dot(&pitching),
            },
        };
        let lag_s = self.options.features.inflow_lag_s;
        let (induced_m_s, meeting) = match (lag_s, annulus.is_end(), self.options.features.end_loads) {
            (Some(time_s), ..) => {
                let lean = normal.dot(&disc.normal);
                let share_1_m = self.like * self.blades.len() as f64 / (PI * section.radius_m);
                let lagging = Lagging { meeting, wind_m_s: cut.wind_m_s, lean, share_1_m, time_s };
                memory.inflow = match past {
                    Past::Known { from, step_s } => lagging.after(&from.sections[index].inflow, *step_s, pieces),
                    Past::Still => lagging.still(pieces),
                    Past::Settled => lagging.settled(pieces),
                    Past::Given => lagging.given(memory.inflow.acting_m_s[0]),
                };
                ([lean * memory.inflow.acting_m_s[0], 0.0], lagging.meeting)
            }
            (None, true, EndRule::ZeroLoad) => return None,
            (None, true, EndRule::Stopped) => ([disc.share * approach.axial_m_s, 0.0], meeting),
            (None, false, _) => {
                let is_free = matches!(pieces, Pieces::Free);
                let mut solve = || {
                    let free = match self.options.features.aerodyn_compatible {
                        true => aerodyn_balance(&annulus, polar, &approach, pieces),
                        false => balance_on(&annulus, polar, &approach, pieces),
                    };
                    [free.axial_loss_m_s, free.swirl_m_s]
                };
                let balanced_m_s = match self.balances[index] {
                    Some((known, at, found)) if is_free && known == annulus && at == approach => found,
                    _ => solve(),
                };
                if is_free {
                    self.balances[index] = Some((annulus, approach, balanced_m_s));
                }
                memory.inflow = match past {
                    Past::Known { from, step_s } if self.options.features.dynamic_inflow => {
                        let to_s = lags_on_s(first_s, radius_m / disc.radius_m, pieces);
                        let from = &from.sections[index].inflow;
                        // AeroDyn uses the time constants at the end of the step, except for the induction at its start
                        let lags_s = match self.options.features.aerodyn_compatible {
                            true => to_s,
                            false => std::array::from_fn(|lag| 0.5 * (from.lags_s[lag] + to_s[lag])),
                        };
                        from.after(balanced_m_s, *step_s, lags_s)
                    }
                    Past::Still if self.options.features.dynamic_inflow => {
                        InflowState { balanced_m_s, ..InflowState::default() }
                    }
                    Past::Given if self.options.features.dynamic_inflow => memory.inflow.balanced(balanced_m_s),
                    Past::Settled | Past::Still | Past::Known { .. } | Past::Given => {
                        InflowState::established(balanced_m_s)
                    }
                };
                let [axial_m_s, swirl_m_s] = match self.options.features.aerodyn_compatible {
                    true => aerodyn_limited(memory.inflow.acting_m_s, &approach, pieces),
                    false => memory.inflow.acting_m_s,
                };
                let factor = match &disc.skew {
                    Some(skew) => skew.factor(&(cut.radial_m / disc.radius_m), axial_m_s, pieces),
                    None => 1.0,
                };
                ([axial_m_s * factor, swirl_m_s].map(|velocity_m_s| disc.share * velocity_m_s), meeting)
            }
        };
        let mut state = meeting.state(induced_m_s, pieces);
        if let Some(split) = &self.splits[section.polar] {
            let met = StallInflow {
                speed_m_s: state.speed_m_s,
                attack_rad: state.attack_rad,
                pitch_rate_rad_s: (motion.spin_rad_s + flow.spin_rad_s - disc.shaft_spin_rad_s).dot(&pitching),
                chord_m: section.chord_m,
            };
            memory.stall = match past {
                Past::Known { from, step_s } => {
                    // the chord is that of this machine, also for the state of a neighbouring one
                    let mut before = from.sections[index].stall;
                    before.met.chord_m = section.chord_m;
                    before.after_on(met, *step_s, split, pieces)
                }
                Past::Given => StallState { met, ..memory.stall },
                Past::Settled | Past::Still => StallState::steady_on(met, split, pieces),
            };
            let dynamic = memory.stall.coefficients_on(split, pieces);
            (state.row.lift, state.row.drag, state.row.moment) = (dynamic.lift, dynamic.drag, dynamic.moment);
        }
        let [along, drive] = state.force_m3_s2(section.chord_m);
        cut.line_n_m = (normal * along + ahead * drive) * flow.density_kg_m3;
        let moment = 0.5 * flow.density_kg_m3 * (section.chord_m * state.speed_m_s).powi(2) * state.row.moment;
        cut.moment_n = pitching * moment;
        let lost_m_s = match (lag_s.is_none(), annulus.is_end(), self.options.features.aerodyn_compatible) {
            (true, true, true) => approach.axial_m_s,
            (true, true, false) => return None,
            (true, false, true) => memory.inflow.balanced_m_s[0],
            _ => memory.inflow.acting_m_s[0],
        };
        match self.options.features.aerodyn_compatible {
            true => Some([lost_m_s / approach.axial_m_s, 1.0]).filter(|[a, _]| a.is_finite()),
            false => Some([lost_m_s, approach.axial_m_s]),
        }
    }
}

/// History of the flow before the instant of evaluation.
pub(super) enum Past<'a> {
    /// Flow and wake are fully developed.
    Settled,
    /// The flow starts now: with dynamic inflow the wake has no induced velocity yet.
    Still,
    /// The state at the end of the previous step.
    Known { from: &'a RotorState, step_s: f64 },
    /// The lag states of the sections at this instant, eq. (B27), are those of the state; its other entries have no meaning.
    Given,
}

#[cfg(test)]
#[path = "bem_tests.rs"]
mod tests;
