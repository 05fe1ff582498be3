//! Derivatives of an aerodynamic step of strips with a lifting line, which couples all of them, NOTATION eqs. (W11) and (X12).

use crate::aero::AirLoads;
use crate::aero::flow::Flow;
use crate::aero::strip::slopes::{GustSlope, LOADS, MOTION, NoFlow, SIXTH_ORDER, STATE, STEP, moved, normal_in_state};
use crate::aero::strip::{Inflow, StripState, Strips};
use crate::load::{SectionMotion, Wrench};
use nalgebra::{DMatrix, DVector};

/// Derivatives of a step. Rows: loads on each section, root frame, then the states of the strips; columns: motions of the sections, then the
/// states of the strips before the step.
pub struct LineStep(DMatrix<f64>);

impl LineStep {
    /// Variations of the state at the end and of the loads, as `ModelSlopes::forward`.
    pub fn forward(&self, state: &[f64], motions: &[f64]) -> (Vec<f64>, Vec<[f64; LOADS]>) {
        let along = DVector::from_iterator(self.0.ncols(), motions.iter().chain(state).copied());
        let rows = &self.0 * along;
        let (loads, after) = rows.as_slice().split_at(self.0.nrows() - state.len());
        (after.to_vec(), loads.as_chunks().0.to_vec())
    }

    /// The transpose of [`Self::forward`].
    pub fn reverse(&self, state: &[f64], loads: &[[f64; LOADS]]) -> (Vec<f64>, Vec<f64>) {
        let on = DVector::from_iterator(self.0.nrows(), loads.iter().flatten().chain(state).copied());
        let along = self.0.tr_mul(&on);
        let (motions, before) = along.as_slice().split_at(MOTION * loads.len());
        (before.to_vec(), motions.to_vec())
    }
}

impl Strips {
    /// Whether a lifting line couples the strips.
    pub fn has_line(&self) -> bool {
        self.line.is_some()
    }

    /// Derivatives of the step with respect to `motions` and state: differences of sixth order of whole steps.
    ///
    /// # Errors
    /// If a strip has no relative flow.
    pub fn line_step_slopes(
        &self,
        from: &StripState,
        motions: &[SectionMotion],
        flow: &Flow,
        step_s: f64,
    ) -> Result<LineStep, NoFlow> {
        let mut model = self.clone();
        let gusts = (0..self.strips.len()).map(|strip| self.gust_slope(strip, motions, flow)).collect();
        model.meet(motions, flow);
        let sizes = model.sizes()?;
        let usual = model.inflows.clone();
        let loads = AirLoads::still(motions.len());
        let mut trial = Trial { model, gusts, flow, step_s, after: from.clone(), loads };
        let rows = LOADS * motions.len() + STATE * self.strips.len();
        let mut slopes = DMatrix::zeros(rows, MOTION * motions.len() + STATE * self.strips.len());
        let mut column = 0;
        let mut moving = motions.to_vec();
        for (section, usual) in motions.iter().enumerate() {
            let near = self.strips.iter().zip(&sizes).filter(|(strip, _)| strip.sections.contains(&section));
            let (length_m, speed_m_s) = near.fold((f64::INFINITY, 0.0_f64), |(length_m, speed_m_s), (_, own)| {
                (length_m.min(own.0), speed_m_s.max(own.1))
            });
            for entry in 0..MOTION {
                let step = STEP * [length_m, 1.0, speed_m_s, speed_m_s / length_m][entry / 3];
                slopes.set_column(
                    column,
                    &differences(rows, step, |change| {
                        moving[section] = moved(usual, entry, change);
                        trial.meet(&moving);
                        trial.rows(from)
                    }),
                );
                column += 1;
            }
            moving[section] = *usual;
        }
        trial.meet(motions);
        let mut changed = from.clone();
        for (strip, (_, speed_m_s)) in sizes.iter().enumerate() {
            for entry in 0..STATE {
                let step = STEP * if normal_in_state(entry) { 1.0 } else { *speed_m_s };
                slopes.set_column(
                    column,
                    &differences(rows, step, |change| {
                        trial.model.inflows.clone_from(&usual);
                        *changed.strips[strip].numbers()[entry] += change;
                        let rows = trial.rows(&changed);
                        changed.strips[strip] = from.strips[strip];
                        rows
                    }),
                );
                column += 1;
            }
        }
        Ok(LineStep(slopes))
    }

    /// Length and relative speed of each strip, as scales of differences.
    fn sizes(&self) -> Result<Vec<(f64, f64)>, NoFlow> {
        let size = |(index, now): (usize, &Inflow)| {
            let speed_m_s = now.speed_m_s.hypot(now.difference_m_s);
            let surface = self.strips[index].surface;
            if speed_m_s > 0.0 { Ok((now.cut.chord_m.min(now.cut.span_m), speed_m_s)) } else { Err(NoFlow { surface }) }
        };
        self.inflows.iter().enumerate().map(size).collect()
    }
}

/// Evaluates steps with perturbed motions and states.
struct Trial<'a> {
    model: Strips,
    gusts: Vec<GustSlope>,
    flow: &'a Flow<'a>,
    step_s: f64,
    after: StripState,
    loads: AirLoads,
}

impl Trial<'_> {
    /// Evaluates the inflow and the mutual influence of the strips.
    fn meet(&mut self, motions: &[SectionMotion]) {
        let gusts = &self.gusts;
        self.model.meet_with(motions, self.flow, |strip, place_m| gusts[strip].at_m_s(place_m));
    }

    /// Returns the loads on all sections and the states after the step, for the inflow of the last [`Self::meet`], which is used up.
    fn rows(&mut self, from: &StripState) -> DVector<f64> {
        let Self { model, flow, step_s, after, loads, .. } = self;
        model.solve_met(from, flow, *step_s, after, loads);
        let sections = loads.circulatory.iter().zip(&loads.impulsive).flat_map(|(one, other)| [one, other]);
        let loads = sections.flat_map(|Wrench { force_n, moment_n_m }| force_n.iter().chain(moment_n_m).copied());
        let states = after.strips.iter_mut().flat_map(|strip| strip.numbers().map(|number| *number));
        let rows: Vec<f64> = loads.chain(states).collect();
        DVector::from_vec(rows)
    }
}

/// Central differences of sixth order.
fn differences(count: usize, step: f64, mut rows: impl FnMut(f64) -> DVector<f64>) -> DVector<f64> {
    let mut sum = DVector::zeros(count);
    for (steps, weight) in (1..).map(f64::from).zip(SIXTH_ORDER) {
        sum += (rows(steps * step) - rows(-steps * step)) * (weight / (60.0 * step));
    }
    sum
}
