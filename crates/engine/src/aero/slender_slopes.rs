//! Derivatives of an aerodynamic step of a slender body with respect to the motion of its sections at the end and to its state before it,
//! NOTATION eq. (X12).
//!
//! The motion of a section changes loads and momenta of itself and of its neighbours, and the load by the rate of its own momentum.

use crate::aero::AirLoads;
use crate::aero::flow::Flow;
use crate::aero::slender::{DragPoint, SlenderBody, SlenderBodyState};
use crate::aero::strip::slopes::{LOADS, MOTION, moved};
use crate::load::{SectionMotion, Wrench};
use crate::math::corners::slope_off_corners;
use nalgebra::{SMatrix, SVector, Vector3};

/// Number of entries of a section's state: its momentum.
pub const STATE: usize = 3;
/// Entries of a load.
const LOAD: usize = 6;
/// Rows of a section by its own motion or that of a neighbour: circulatory load and momentum.
const ROWS: usize = LOAD + STATE;
/// The same of a section and its neighbours, the inner one first.
const ALL: usize = 3 * ROWS;
/// Columns of the load by the rate of momentum: motion, momentum before and after the step.
const COLUMNS: usize = MOTION + 2 * STATE;

/// First difference step relative to the length of a part, a radian, and the relative speed.
const STEP: f64 = 1e-3;

/// Derivatives of a section.
struct Section {
    /// Loads and momenta of the inner neighbour, itself and the outer neighbour by its motion.
    around: SMatrix<f64, ALL, MOTION>,
    /// Its load by the rate of its momentum.
    impulse: SMatrix<f64, LOAD, COLUMNS>,
}

/// Derivatives of a step of a slender body.
pub struct SlenderStep(Vec<Section>);

impl SlenderBodyState {
    /// State entries that later loads depend on.
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        self.momenta_m4_s.iter().flat_map(|momentum| momentum.iter().copied())
    }
}

impl SlenderBody {
    /// Derivatives of the step from `from` to `motions`. The drag is replaced by its tangent, whose second derivative jumps in flow along the
    /// axis.
    pub fn step_slopes(
        &self,
        from: &SlenderBodyState,
        motions: &[SectionMotion],
        flow: &Flow,
        step_s: f64,
    ) -> SlenderStep {
        let mut trial = Trial {
            body: self,
            flow,
            step_s,
            about: self.drag_points_in(motions, flow),
            motions: motions.to_vec(),
            state: self.blank_state(),
            loads: AirLoads::still(motions.len()),
        };
        self.add_flow_loads(motions, flow, &[], &mut trial.state, &mut trial.loads);
        let after = trial.state.momenta_m4_s.clone();
        let momenta = from.momenta_m4_s.iter().zip(&after).enumerate();
        SlenderStep(momenta.map(|(section, momenta)| trial.section(section, momenta)).collect())
    }
}

/// Evaluates parts of the body with perturbed motions.
struct Trial<'a> {
    body: &'a SlenderBody,
    flow: &'a Flow<'a>,
    step_s: f64,
    about: Vec<[DragPoint; 2]>,
    motions: Vec<SectionMotion>,
    state: SlenderBodyState,
    loads: AirLoads,
}

impl Trial<'_> {
    fn section(&mut self, section: usize, momenta: (&Vector3<f64>, &Vector3<f64>)) -> Section {
        let mut around = SMatrix::<f64, ALL, MOTION>::zeros();
        let mut impulse = SMatrix::<f64, LOAD, COLUMNS>::zeros();
        let (usual, body) = (self.motions[section], self.body);
        let arm_m = body.arm_m(section, &self.motions);
        let air_m_s = self.flow.velocity_m_s(&(usual.position_m + arm_m));
        let speed_m_s = (air_m_s - usual.velocity_m_s - usual.spin_rad_s.cross(&arm_m)).norm();
        let beside = section.saturating_sub(1)..(section + 1).min(body.lengths_m.len());
        let part_m = body.lengths_m[beside].iter().copied().fold(f64::INFINITY, f64::min);
        let reach_m = arm_m.norm().max(part_m);
        let kinds: [usize; ALL] = std::array::from_fn(|row| (row % ROWS) / 3);
        let (present, load) = (self.around(section), self.impulse(section, momenta));
        for entry in 0..MOTION {
            let step = STEP * [part_m, part_m / reach_m, speed_m_s, speed_m_s / reach_m][entry / 3];
            // without relative flow, loads are of second degree in the velocities
            if step == 0.0 {
                continue;
            }
            let slope = slope_off_corners(step, &kinds, present.as_slice(), |shift, side| {
                self.motions[section] = moved(&usual, entry, shift);
                side.copy_from_slice(self.around(section).as_slice());
            });
            around.column_mut(entry).copy_from_slice(&slope);
            let slope = slope_off_corners(step, &kinds[..LOAD], load.as_slice(), |shift, side| {
                self.motions[section] = moved(&usual, entry, shift);
                side.copy_from_slice(self.impulse(section, momenta).as_slice());
            });
            impulse.column_mut(entry).copy_from_slice(&slope);
            self.motions[section] = usual;
        }
        // linear in the momenta
        for entry in 0..STATE {
            let (unit, none) = (Vector3::ith(entry, 1.0), Vector3::zeros());
            for (part, momenta) in [(&unit, &none), (&none, &unit)].into_iter().enumerate() {
                impulse.set_column(MOTION + STATE * part + entry, &self.impulse(section, momenta));
            }
        }
        Section { around, impulse }
    }

    /// Loads and momenta of a section and its neighbours by the parts at the section.
    fn around(&mut self, section: usize) -> SVector<f64, ALL> {
        let Self { body, flow, about, motions, state, loads, .. } = self;
        let all = motions.len();
        let near = section.saturating_sub(1)..(section + 2).min(all);
        for near in near.clone() {
            loads.circulatory[near] = Wrench::default();
            state.momenta_m4_s[near] = Vector3::zeros();
        }
        for inner in section.saturating_sub(1)..(section + 1).min(all - 1) {
            body.add_frustum(inner, motions, flow, about.get(inner), state, loads);
        }
        for end in body.ends().into_iter().filter(|(at, ..)| *at == section) {
            body.add_end(end, motions, flow, loads);
        }
        let mut rows = SVector::<f64, ALL>::zeros();
        for near in near {
            let first = ROWS * (near + 1 - section);
            let Wrench { force_n, moment_n_m } = &loads.circulatory[near];
            for (part, vector) in [force_n, moment_n_m, &state.momenta_m4_s[near]].into_iter().enumerate() {
                rows.fixed_rows_mut::<3>(first + 3 * part).copy_from(vector);
            }
        }
        rows
    }

    /// Load of a section by the rate of its momentum.
    fn impulse(&self, section: usize, momenta: (&Vector3<f64>, &Vector3<f64>)) -> SVector<f64, LOAD> {
        let mut load = Wrench::default();
        if self.body.options.apparent_mass && self.step_s > 0.0 {
            self.body.add_impulse(section, momenta, &self.motions, (self.flow, self.step_s), &mut load);
        }
        let mut rows = SVector::<f64, LOAD>::zeros();
        rows.fixed_rows_mut::<3>(0).copy_from(&load.force_n);
        rows.fixed_rows_mut::<3>(3).copy_from(&load.moment_n_m);
        rows
    }
}

impl SlenderStep {
    /// Variations of the state after the step and of the loads, circulatory and impulsive, root frame, due to variations of the state before
    /// it and of the motions at its end: [`MOTION`] entries each.
    pub fn forward(&self, state: &[f64], motions: &[f64]) -> (Vec<f64>, Vec<[f64; LOADS]>) {
        let count = self.0.len();
        let mut after = vec![0.0; STATE * count];
        let mut loads = vec![[0.0; LOADS]; count];
        let motion = |section: usize| SVector::<f64, MOTION>::from_column_slice(&motions[MOTION * section..][..MOTION]);
        for (section, own) in self.0.iter().enumerate() {
            let rows = own.around * motion(section);
            for near in section.saturating_sub(1)..(section + 2).min(count) {
                let rows = &rows.as_slice()[ROWS * (near + 1 - section)..][..ROWS];
                add(&mut loads[near][..LOAD], &rows[..LOAD]);
                add(&mut after[STATE * near..], &rows[LOAD..]);
            }
        }
        for (section, own) in self.0.iter().enumerate() {
            let mut along = SVector::<f64, COLUMNS>::zeros();
            let values = along.as_mut_slice();
            values[..MOTION].copy_from_slice(motion(section).as_slice());
            values[MOTION..MOTION + STATE].copy_from_slice(&state[STATE * section..][..STATE]);
            values[MOTION + STATE..].copy_from_slice(&after[STATE * section..][..STATE]);
            add(&mut loads[section][LOAD..], (own.impulse * along).as_slice());
        }
        (after, loads)
    }

    /// The transpose of [`Self::forward`]: multipliers of state and motions from those of the state after the step and of the loads.
    pub fn reverse(&self, after: &[f64], loads: &[[f64; LOADS]]) -> (Vec<f64>, Vec<f64>) {
        let count = self.0.len();
        let (mut state, mut motions) = (vec![0.0; STATE * count], vec![0.0; MOTION * count]);
        let mut after = after.to_vec();
        for (section, own) in self.0.iter().enumerate() {
            let back = own.impulse.tr_mul(&SVector::<f64, LOAD>::from_column_slice(&loads[section][LOAD..]));
            let values = back.as_slice();
            add(&mut motions[MOTION * section..], &values[..MOTION]);
            add(&mut state[STATE * section..], &values[MOTION..MOTION + STATE]);
            add(&mut after[STATE * section..], &values[MOTION + STATE..]);
        }
        for (section, own) in self.0.iter().enumerate() {
            let mut on = SVector::<f64, ALL>::zeros();
            for near in section.saturating_sub(1)..(section + 2).min(count) {
                let rows = &mut on.as_mut_slice()[ROWS * (near + 1 - section)..][..ROWS];
                rows[..LOAD].copy_from_slice(&loads[near][..LOAD]);
                rows[LOAD..].copy_from_slice(&after[STATE * near..][..STATE]);
            }
            add(&mut motions[MOTION * section..], own.around.tr_mul(&on).as_slice());
        }
        (state, motions)
    }
}

fn add(sum: &mut [f64], values: &[f64]) {
    sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
}
