//! Derivatives of an aerodynamic step of a rotor with respect to the motion of its sections at the end and to its state before it,
//! NOTATION eq. (X37).
//!
//! A section depends on its own motion and state, on the hub, on the axis of its blade at the root, and on a few numbers of the disc: mean
//! wind, radius and mean induction. With those as variables of their own, every section has one small matrix, and a product costs O(n).

use crate::aero::AirLoads;
use crate::aero::flow::Flow;
use crate::aero::pieces::Pieces;
use crate::aero::rotor::bem::{Past, Rotor, RotorState, SectionMemory};
use crate::aero::rotor::disc::Cut;
use crate::aero::rotor::dynamic_inflow::{InflowState, lags_on_s, time_constant_on_s};
use crate::aero::rotor::dynamic_stall::{StallInflow, StallState};
use crate::aero::rotor::loads::RotorLoads;
use crate::aero::rotor::output_slopes::{DiscChange, OUTPUTS, OutputSlopes};
use crate::aero::rotor::pieces::RotorPieces;
use crate::aero::rotor::spread::{SPREAD, Share};
use crate::aero::strip::slopes::{MOTION, moved};
use crate::load::SectionMotion;
use crate::math::corners::slope_off_corners;
use nalgebra::{SMatrix, SVector, Vector3};

/// Number of entries of a section's state that later loads depend on.
pub const STATE: usize = 15;
/// Entries of the load of a section: force and moment, root frame.
const LOADS: usize = 6;

/// First columns of the variables of a section: its state behind its motion, the motion of the hub, the axis at the root of its blade, the
/// mean wind relative to the sections, the radius of the rotor, and the mean inductions in the first pass, in the second, and behind it.
const OWN_STATE: usize = MOTION;
const HUB: usize = OWN_STATE + STATE;
const ROOT: usize = HUB + MOTION;
const WIND: usize = ROOT + 3;
const RADIUS: usize = WIND + 3;
const INDUCTION: usize = RADIUS + 1;
const COLUMNS: usize = INDUCTION + 3;

/// First rows of the numbers of a section: the entries that its load depends on ([`SPREAD`]), the velocity of the air relative to it, its
/// distance from the shaft, its parts in the mean induction in each pass, its state after the step.
const AIR: usize = SPREAD;
const RADIAL: usize = AIR + 3;
const LOST: usize = RADIAL + 1;
const AFTER: usize = LOST + 4;
const ROWS: usize = AFTER + STATE;

/// Jacobian of a section.
type Section = SMatrix<f64, ROWS, COLUMNS>;

/// First difference step relative to the chord or the radius, a radian, the relative speed, a time constant. Larger ones pass the curvature of
/// sections at small flow angles, shorter ones add round-off: a third of it exceeds 1e-9 in GR-87.
const STEP: f64 = 1e-4;
/// Smallest speed in m/s that scales the steps.
const LEAST_SPEED_M_S: f64 = 1e-3;

impl SectionMemory {
    /// State entries that later loads depend on.
    pub fn numbers(&mut self) -> [&mut f64; STATE] {
        let Self { inflow, stall } = self;
        let InflowState { balanced_m_s: [a, b], middle_m_s: [c, d], acting_m_s: [e, f], lags_s: [g, h] } = inflow;
        let StallState { wake_rad: [i, j], lagged_lift, attached, met } = stall;
        let StallInflow { speed_m_s, attack_rad, pitch_rate_rad_s, chord_m: _ } = met;
        [a, b, c, d, e, f, g, h, i, j, lagged_lift, attached, speed_m_s, attack_rad, pitch_rate_rad_s]
    }
}

impl RotorState {
    /// State entries that later loads and outputs depend on: those of the sections, then loads and coefficients in their order, the mean
    /// induction last.
    pub fn numbers(&mut self) -> impl Iterator<Item = &mut f64> {
        let Self { sections, loads } = self;
        let loads: &mut [f64] = bytemuck::cast_slice_mut(std::slice::from_mut(loads));
        sections.iter_mut().flat_map(SectionMemory::numbers).chain(loads)
    }
}

/// Wind along the shaft, as a share of the speed of the tips, below which a skewed wake has no derivatives.
const NO_WIND: f64 = 1e-6;

/// Reason why a step of a rotor has no derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoRotorSlopes {
    /// A section is exactly at a row of its polar, at which both sides have other slopes.
    Kink {
        /// Index of its blade.
        blade: usize,
    },
    /// A section is exactly at a point of the grid of the wind, at which both sides have other slopes.
    Node {
        /// Index of its blade.
        blade: usize,
    },
    /// The momentum balance of a section ends beside its state.
    End {
        /// Index of its blade.
        blade: usize,
    },
    /// Any small wind across the shaft would skew the wake.
    NoWind,
}

/// Derivatives of a step of a rotor.
pub struct RotorStep {
    sections: Vec<Section>,
    shares: Vec<Share>,
    /// Per section: that at the root of its blade.
    roots: Vec<usize>,
    /// Per blade: axis at its root, its outermost section.
    axes: Vec<Vector3<f64>>,
    blades: Vec<usize>,
    outermost: Vec<usize>,
    passes: usize,
    /// Per pass: derivatives of the mean induction with respect to the sums over the sections.
    means: [[f64; 2]; 2],
    outputs: OutputSlopes,
}

/// Variables of a section.
#[derive(Clone, Copy)]
struct Variables {
    own: SectionMotion,
    state: SectionMemory,
    hub: SectionMotion,
    root: Vector3<f64>,
    wind_m_s: Vector3<f64>,
    radius_m: f64,
    inductions: [f64; 3],
}

impl Variables {
    /// Changes one of them.
    fn change(&mut self, column: usize, by: f64) {
        match column {
            ..OWN_STATE => self.own = moved(&self.own, column, by),
            OWN_STATE..HUB => *self.state.numbers()[column - OWN_STATE] += by,
            HUB..ROOT => self.hub = moved(&self.hub, column - HUB, by),
            ROOT..WIND => self.root[column - ROOT] += by,
            WIND..RADIUS => self.wind_m_s[column - WIND] += by,
            RADIUS => self.radius_m += by,
            _ => self.inductions[column - INDUCTION] += by,
        }
    }
}

impl Rotor {
    /// Derivatives of the step from `from` to `motions`, on the pieces on which its functions lie.
    ///
    /// # Errors
    /// If the step has no derivatives.
    pub fn step_slopes(
        &mut self,
        from: &RotorState,
        motions: &[SectionMotion],
        flow: &Flow,
        step_s: f64,
        pieces: &RotorPieces,
    ) -> Result<RotorStep, NoRotorSlopes> {
        let (mut to, mut loads) = (self.blank_state(), AirLoads::still(motions.len()));
        self.solve(from, motions, flow, step_s, &mut to, &mut loads);
        let shares = self.spread_slopes();
        let hub = motions[self.sections.len()];
        let count = self.sections.len() as f64;
        let normal = hub.rotation * self.options.shaft_axis;
        let met = motions.iter().enumerate().take(self.sections.len());
        let met = met.map(|(index, own)| self.cut(index, own, (&hub, &normal), flow, &mut Pieces::Free).1);
        let wind_m_s = met.sum::<Vector3<f64>>() / count;
        let radius_m = self.rotor_radius_m();
        if let Some(section) = pieces.kinked() {
            return Err(NoRotorSlopes::Kink { blade: self.blade_of(section) });
        }
        if let Some(section) = pieces.at_node() {
            return Err(NoRotorSlopes::Node { blade: self.blade_of(section) });
        }
        let tip_m_s = (to.loads.speed_rad_s * radius_m).abs();
        if self.options.features.skewed_wake && wind_m_s.dot(&normal).abs() <= NO_WIND * tip_m_s {
            return Err(NoRotorSlopes::NoWind);
        }
        let disc = self.disc((&hub, &normal), (&wind_m_s, radius_m), flow, &mut Pieces::keep(&pieces.disc));
        let outputs = OutputSlopes::of((&disc, &wind_m_s), (motions, &loads.circulatory), flow, self.like);
        let distance_m = |section: &usize| self.cuts[*section].radial_m.norm();
        let last_of = |range: &std::ops::Range<usize>| {
            range.clone().max_by(|a, b| distance_m(a).total_cmp(&distance_m(b))).unwrap_or(range.start)
        };
        let outermost: Vec<usize> = self.blades.iter().map(last_of).collect();
        let cuts = self.cuts.clone();
        let blades: Vec<usize> =
            self.blades.iter().enumerate().flat_map(|(blade, range)| range.clone().map(move |_| blade)).collect();
        let starts: Vec<usize> = self.blades.iter().map(|range| range.start).collect();
        let roots: Vec<usize> = blades.iter().map(|blade| starts[*blade]).collect();
        let axes: Vec<Vector3<f64>> =
            starts.iter().map(|root| motions[*root].rotation.column(0).into_owned()).collect();
        let passes = pieces.sections.len();
        let first = from.loads.induction;
        let mut trial = Trial { rotor: self, pieces, from: from.clone(), flow, step_s };
        let mut inductions = [first; 3];
        let mut means = [[0.0; 2]; 2];
        let variables = |index: usize, inductions: [f64; 3]| Variables {
            own: motions[index],
            state: from.sections[index],
            hub,
            root: axes[blades[index]],
            wind_m_s,
            radius_m,
            inductions,
        };
        for slot in 2 - passes..2 {
            let mut sums = [0.0; 2];
            for index in 0..cuts.len() {
                let rows = trial.rows(index, &variables(index, inductions));
                (0..2).for_each(|sum| sums[sum] += rows[LOST + 2 * slot + sum]);
            }
            // as in the step: without wind there is no mean
            if to.loads.induction != 0.0 && sums[1] != 0.0 {
                means[slot] = [1.0 / sums[1], -sums[0] / (sums[1] * sums[1])];
                inductions[slot + 1] = sums[0] / sums[1];
            }
        }
        let sections: Vec<Section> =
            (0..cuts.len()).map(|index| trial.slopes(index, &variables(index, inductions), &cuts[index])).collect();
        let ends = |section: &Section| section.iter().any(|slope| !slope.is_finite());
        if let Some(section) = sections.iter().position(ends) {
            return Err(NoRotorSlopes::End { blade: blades[section] });
        }
        Ok(RotorStep { sections, shares, roots, axes, blades, outermost, passes, means, outputs })
    }
}

/// Evaluates sections one by one, on the pieces of a step.
struct Trial<'a> {
    rotor: &'a mut Rotor,
    pieces: &'a RotorPieces,
    from: RotorState,
    flow: &'a Flow<'a>,
    step_s: f64,
}

impl Trial<'_> {
    /// Jacobian of a section, by differences of sixth order with steps in which its functions are smooth: at small angles of the flow they have
    /// a sharp curvature, and heavily loaded annuli end.
    fn slopes(&mut self, index: usize, now: &Variables, cut: &Cut) -> Section {
        let chord_m = self.rotor.chord_m(index);
        let speed_m_s = cut.relative_m_s.norm().max(LEAST_SPEED_M_S);
        let of_motion = [chord_m, 1.0, speed_m_s, speed_m_s / chord_m];
        let [one_lag, two_lags, stalls] = self.rotor.moved(&self.rotor.sections[index]);
        let mut state = now.state;
        let mut slopes = Section::zeros();
        let present = self.rows(index, now);
        let kinds: [usize; ROWS] = std::array::from_fn(|row| row);
        for column in 0..COLUMNS {
            let size = match column {
                ..OWN_STATE => of_motion[column / 3],
                OWN_STATE..HUB => {
                    let entry = column - OWN_STATE;
                    let (value, of_stall) = (*state.numbers()[entry], if stalls { 1.0 } else { 0.0 });
                    match entry {
                        0..6 if one_lag || two_lags => speed_m_s,
                        6..8 if two_lags => value,
                        0..8 => 0.0,
                        11 => value * of_stall,
                        12 => speed_m_s * of_stall,
                        14 => speed_m_s / chord_m * of_stall,
                        _ => of_stall,
                    }
                }
                HUB..ROOT => of_motion[(column - HUB) / 3],
                ROOT..WIND => 1.0,
                WIND..RADIUS => now.wind_m_s.norm().max(LEAST_SPEED_M_S),
                RADIUS => now.radius_m,
                _ => 1.0,
            };
            let step = STEP * size;
            if step == 0.0 {
                continue;
            }
            let slope = slope_off_corners(step, &kinds, present.as_slice(), |shift, side| {
                let mut beside = *now;
                beside.change(column, shift);
                side.copy_from_slice(self.rows(index, &beside).as_slice());
            });
            slopes.column_mut(column).copy_from_slice(&slope);
        }
        slopes
    }

    /// Numbers of a section.
    fn rows(&mut self, index: usize, at: &Variables) -> SVector<f64, ROWS> {
        let Self { rotor, pieces, from, flow, step_s } = self;
        let normal = at.hub.rotation * rotor.options.shaft_axis;
        let wind = &mut Pieces::keep(&pieces.winds[index]);
        let (cut, air_m_s) = rotor.cut(index, &at.own, (&at.hub, &normal), flow, wind);
        let mut of_disc = Pieces::keep(&pieces.disc);
        let disc = rotor.disc((&at.hub, &normal), (&at.wind_m_s, at.radius_m), flow, &mut of_disc);
        let mut rows = SVector::<f64, ROWS>::zeros();
        from.sections[index] = at.state;
        let passes = pieces.sections.len();
        let mut after = SectionMemory::default();
        let lag_s = |induction: f64, pass: usize| {
            let mut pieces = Pieces::keep(&pieces.wakes[pass]);
            time_constant_on_s(disc.radius_m, induction, disc.loads.wind_m_s, &mut pieces)
        };
        rotor.cuts[index] = cut;
        if let Some([ahead, root_normal]) = Rotor::directions(&disc, &at.root) {
            let past = Past::Known { from, step_s: *step_s };
            for pass in 0..passes {
                let slot = pass + 2 - passes;
                rotor.cuts[index] = cut;
                let first_s = lag_s(at.inductions[slot], pass);
                let mut own = Pieces::keep(&pieces.sections[pass][index]);
                let directions = [&ahead, &root_normal];
                let met = rotor.section(index, &at.own, &disc, directions, flow, &past, first_s, &mut after, &mut own);
                if let Some(met) = met {
                    let weight = rotor.weight(index);
                    (0..2).for_each(|sum| rows[LOST + 2 * slot + sum] = weight * met[sum]);
                }
            }
        }
        if rotor.options.features.dynamic_inflow {
            let span = cut.radial_m.norm() / disc.radius_m;
            let mut end = Pieces::keep(&pieces.ends[index]);
            after.inflow.lags_s = lags_on_s(lag_s(at.inductions[2], passes), span, &mut end);
        }
        let Cut { line_n_m, moment_n, arm_m, from_apex_m, .. } = rotor.cuts[index];
        for (part, vector) in [line_n_m, moment_n, arm_m, from_apex_m, air_m_s].iter().enumerate() {
            rows.fixed_rows_mut::<3>(3 * part).copy_from(vector);
        }
        rows[RADIAL] = cut.radial_m.norm();
        for (row, number) in rows.iter_mut().skip(AFTER).zip(after.numbers()) {
            *row = *number;
        }
        rows
    }
}

impl RotorStep {
    /// Number of entries of the state.
    pub fn state_entries(&self) -> usize {
        self.place_of_loads() + size_of::<RotorLoads>() / size_of::<f64>()
    }

    /// Place of the loads and coefficients in the state.
    pub fn place_of_loads(&self) -> usize {
        STATE * self.sections.len()
    }

    /// Place of the mean induction in the state.
    fn place_of_induction(&self) -> usize {
        self.place_of_loads() + OUTPUTS
    }

    /// Adds to the numbers of the sections changes by variables of the disc, from the first of their columns on.
    fn add<const N: usize>(&self, first: usize, along: &SVector<f64, N>, rows: &mut [SVector<f64, ROWS>]) {
        for (section, rows) in self.sections.iter().zip(rows) {
            *rows += section.fixed_columns::<N>(first) * along;
        }
    }

    /// Multipliers of variables of the disc.
    fn on<const N: usize>(&self, first: usize, on: &[SVector<f64, ROWS>]) -> SVector<f64, N> {
        self.sections.iter().zip(on).map(|(section, on)| section.fixed_columns::<N>(first).tr_mul(on)).sum()
    }

    /// Variation of the mean induction of a pass.
    fn mean(&self, slot: usize, rows: &[SVector<f64, ROWS>]) -> f64 {
        let [lost, met] = self.means[slot];
        rows.iter().map(|rows| lost * rows[LOST + 2 * slot] + met * rows[LOST + 2 * slot + 1]).sum()
    }

    /// Adds the multiplier of the mean induction of a pass to those of the sections.
    fn add_on_mean(&self, slot: usize, on_mean: f64, on: &mut [SVector<f64, ROWS>]) {
        for on in on {
            (0..2).for_each(|sum| on[LOST + 2 * slot + sum] += self.means[slot][sum] * on_mean);
        }
    }

    /// Variations of the state after the step, loads and coefficients included, and of the loads, six per section, the hub last, root frame,
    /// due to variations of the state before it and of the motions at its end: [`MOTION`] entries each, the hub last.
    pub fn forward(&self, state: &[f64], motions: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let count = self.sections.len();
        let motion = |section: usize| &motions[MOTION * section..MOTION * (section + 1)];
        let mut rows: Vec<SVector<f64, ROWS>> = Vec::with_capacity(count);
        for (index, section) in self.sections.iter().enumerate() {
            let mut along = SVector::<f64, COLUMNS>::zeros();
            let values = along.as_mut_slice();
            values[..OWN_STATE].copy_from_slice(motion(index));
            values[OWN_STATE..HUB].copy_from_slice(&state[STATE * index..STATE * (index + 1)]);
            values[HUB..ROOT].copy_from_slice(motion(count));
            let turn = Vector3::from_column_slice(&motion(self.roots[index])[3..6]);
            values[ROOT..WIND].copy_from_slice(turn.cross(&self.axes[self.blades[index]]).as_slice());
            rows.push(section * along);
        }
        let mut disc = SVector::<f64, 4>::zeros();
        let wind: Vector3<f64> = rows.iter().map(|rows| rows.fixed_rows::<3>(AIR).into_owned()).sum();
        disc.fixed_rows_mut::<3>(0).copy_from(&(wind / count as f64));
        disc[3] = self.outermost.iter().map(|outer| rows[*outer][RADIAL]).sum::<f64>() / self.outermost.len() as f64;
        self.add(WIND, &disc, &mut rows);
        let mut induction = state[self.place_of_induction()];
        for slot in 2 - self.passes..2 {
            self.add(INDUCTION + slot, &SVector::<f64, 1>::new(induction), &mut rows);
            induction = self.mean(slot, &rows);
        }
        self.add(INDUCTION + 2, &SVector::<f64, 1>::new(induction), &mut rows);
        let mut after: Vec<f64> = rows.iter().flat_map(|rows| rows.as_slice()[AFTER..].iter().copied()).collect();
        let mut loads = vec![0.0; LOADS * (count + 1)];
        for Share { sections, slopes } in &self.shares {
            let load =
                sections.iter().zip(slopes).map(|(section, slopes)| slopes * rows[*section].fixed_rows::<SPREAD>(0));
            let load: SVector<f64, LOADS> = load.sum();
            loads[LOADS * sections[0]..].iter_mut().zip(&load).for_each(|(sum, entry)| *sum += entry);
        }
        let place_m = |section: usize| Vector3::from_column_slice(&motion(section)[..3]);
        let [hub_m, hub_turn, _, hub_spin_rad_s] =
            [0, 3, 6, 9].map(|first| Vector3::from_column_slice(&motion(count)[first..first + 3]));
        let wind_m_s = disc.fixed_rows::<3>(0).into_owned();
        let change = DiscChange { hub_m, hub_turn, hub_spin_rad_s, wind_m_s, radius_m: disc[3] };
        after.extend(&self.outputs.forward(&loads, (0..count).map(place_m), &change));
        after.push(induction);
        (after, loads)
    }

    /// The transpose of [`Self::forward`]: multipliers of state and motions from those of the state after the step and of the loads.
    pub fn reverse(&self, after: &[f64], loads: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let count = self.sections.len();
        let mut loads = loads.to_vec();
        let of_outputs = self.place_of_loads()..self.place_of_induction();
        let (places, of_disc) = self.outputs.reverse(&after[of_outputs], &mut loads);
        let mut on = vec![SVector::<f64, ROWS>::zeros(); count];
        for (on, after) in on.iter_mut().zip(after.chunks_exact(STATE)) {
            on.as_mut_slice()[AFTER..].copy_from_slice(after);
        }
        for Share { sections, slopes } in &self.shares {
            let load = SVector::<f64, LOADS>::from_column_slice(&loads[LOADS * sections[0]..LOADS * (sections[0] + 1)]);
            for (section, slopes) in sections.iter().zip(slopes) {
                let mut entries = on[*section].fixed_rows_mut::<SPREAD>(0);
                entries += slopes.tr_mul(&load);
            }
        }
        let mut on_induction = after[self.place_of_induction()] + self.on::<1>(INDUCTION + 2, &on)[0];
        for slot in (2 - self.passes..2).rev() {
            self.add_on_mean(slot, on_induction, &mut on);
            on_induction = self.on::<1>(INDUCTION + slot, &on)[0];
        }
        let mut on_disc = self.on::<4>(WIND, &on);
        on_disc += of_disc.wind_m_s.push(of_disc.radius_m);
        for on in &mut on {
            let mut air = on.fixed_rows_mut::<3>(AIR);
            air += on_disc.fixed_rows::<3>(0) / count as f64;
        }
        for outer in &self.outermost {
            on[*outer][RADIAL] += on_disc[3] / self.outermost.len() as f64;
        }
        let mut state = vec![0.0; self.state_entries()];
        state[self.place_of_induction()] = on_induction;
        let mut motions = vec![0.0; MOTION * (count + 1)];
        for (index, (section, on)) in self.sections.iter().zip(&on).enumerate() {
            let back = section.tr_mul(on);
            let mut add = |section: usize, first: usize, values: &[f64]| {
                motions[MOTION * section + first..].iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            };
            let values = back.as_slice();
            add(index, 0, &values[..OWN_STATE]);
            add(count, 0, &values[HUB..ROOT]);
            let on_root = Vector3::from_column_slice(&values[ROOT..WIND]);
            add(self.roots[index], 3, self.axes[self.blades[index]].cross(&on_root).as_slice());
            add(index, 0, places[index].as_slice());
            state[STATE * index..STATE * (index + 1)].copy_from_slice(&values[OWN_STATE..HUB]);
        }
        let DiscChange { hub_m, hub_turn, hub_spin_rad_s, .. } = of_disc;
        for (first, vector) in [(0, hub_m), (3, hub_turn), (9, hub_spin_rad_s)] {
            motions[MOTION * count + first..].iter_mut().zip(&vector).for_each(|(sum, value)| *sum += value);
        }
        (state, motions)
    }
}

#[cfg(test)]
#[path = "slopes_tests.rs"]
mod tests;
