//! Derivatives of an aerodynamic step of one model: from the motions of its sections at the end and its state at the start to its state at
//! the end and the loads on its sections, NOTATION eqs. (X12) and (X37).

use crate::aero::flow::Flow;
use crate::aero::rotor::slopes::{NoRotorSlopes, RotorStep};
use crate::aero::slender_slopes::SlenderStep;
use crate::aero::strip::LineStep;
use crate::aero::strip::slopes::{LOADS, MOTION, NoFlow, ROWS, STATE, StripStep};
use crate::aero::{AirModel, AirState};
use crate::load::SectionMotion;
use crate::system::air::pieces::ModelPieces;
use nalgebra::SVector;

/// Reason why the step of a model has no derivatives, with the index of one of its surfaces.
pub(super) enum NoModelSlopes {
    /// A strip has no relative flow velocity.
    Still(usize),
    /// A section is exactly at a row of its polar.
    Kink(usize),
    /// A section is exactly at a point of the grid of the wind.
    Node(usize),
    /// The momentum balance of a section ends beside its state.
    End(usize),
    /// Any small wind across the shaft would skew the wake of the rotor.
    NoWind,
    /// The model has none.
    Model,
}

/// Derivatives of a model in a step.
pub(super) enum ModelSlopes {
    /// Per strip: its sections and its derivatives.
    Strips(Vec<([usize; 2], StripStep)>),
    /// Of strips with a lifting line.
    Line(LineStep),
    /// Of a rotor.
    Rotor(Box<RotorStep>),
    /// Of a slender body.
    SlenderBody(SlenderStep),
}

impl ModelSlopes {
    /// Derivatives of the step from `from` to `motions`, on known pieces.
    pub fn of(
        (model, pieces): (&mut AirModel, &ModelPieces),
        from: &AirState,
        motions: &[SectionMotion],
        (flow, step_s): (&Flow, f64),
    ) -> Result<Self, NoModelSlopes> {
        match (model, from, pieces) {
            (AirModel::Strips(strips), AirState::Strips(from), ModelPieces::Strips(pieces)) => {
                let still = |still: NoFlow| NoModelSlopes::Still(still.surface);
                if strips.has_line() {
                    // a lifting line has no polars
                    return Ok(Self::Line(strips.line_step_slopes(from, motions, flow, step_s).map_err(still)?));
                }
                if let Some(strip) = pieces.iter().position(|list| list.at_kink) {
                    return Err(NoModelSlopes::Kink(strips.surface_of(strip)));
                }
                let slopes = strips.step_slopes(from, motions, flow, step_s, pieces).map_err(still)?;
                Ok(Self::Strips(strips.strip_sections().zip(slopes).collect()))
            }
            (AirModel::Rotor(rotor), AirState::Rotor(from), ModelPieces::Rotor(pieces)) => {
                let slopes = rotor.step_slopes(from, motions, flow, step_s, pieces);
                let slopes = slopes.map_err(|refused| match refused {
                    NoRotorSlopes::Kink { blade } => NoModelSlopes::Kink(blade),
                    NoRotorSlopes::Node { blade } => NoModelSlopes::Node(blade),
                    NoRotorSlopes::End { blade } => NoModelSlopes::End(blade),
                    NoRotorSlopes::NoWind => NoModelSlopes::NoWind,
                })?;
                Ok(Self::Rotor(Box::new(slopes)))
            }
            (AirModel::SlenderBody(body), AirState::SlenderBody(from), ModelPieces::None) => {
                Ok(Self::SlenderBody(body.step_slopes(from, motions, flow, step_s)))
            }
            (AirModel::Lattice(_) | AirModel::Strips(_) | AirModel::Rotor(_) | AirModel::SlenderBody(_), _, _) => {
                Err(NoModelSlopes::Model)
            }
        }
    }

    /// Variations of the state at the end and of the loads, circulatory and impulsive, on each section, root frame, due to variations of the
    /// state at the start and of the motions at the end, [`MOTION`] entries each.
    pub fn forward(&self, state: &[f64], motions: &[f64]) -> (Vec<f64>, Vec<[f64; LOADS]>) {
        match self {
            Self::Strips(strips) => strips_forward(strips, state, motions),
            Self::Line(line) => line.forward(state, motions),
            Self::Rotor(rotor) => {
                let (after, loads) = rotor.forward(state, motions);
                let wide = |own: &[f64]| std::array::from_fn(|entry| own.get(entry).copied().unwrap_or(0.0));
                (after, loads.chunks_exact(LOADS / 2).map(wide).collect())
            }
            Self::SlenderBody(body) => body.forward(state, motions),
        }
    }

    /// The transpose of [`Self::forward`]: multipliers of state and motions from those of the state at the end and of the loads.
    pub fn reverse(&self, state: &[f64], loads: &[[f64; LOADS]]) -> (Vec<f64>, Vec<f64>) {
        match self {
            Self::Strips(strips) => strips_reverse(strips, state, loads),
            Self::Line(line) => line.reverse(state, loads),
            Self::Rotor(rotor) => {
                let loads: Vec<f64> = loads.iter().flat_map(|own| own[..LOADS / 2].iter().copied()).collect();
                rotor.reverse(state, &loads)
            }
            Self::SlenderBody(body) => body.reverse(state, loads),
        }
    }
}

fn strips_forward(strips: &[([usize; 2], StripStep)], state: &[f64], motions: &[f64]) -> (Vec<f64>, Vec<[f64; LOADS]>) {
    let mut after = vec![0.0; STATE * strips.len()];
    let mut loads = vec![[0.0; LOADS]; motions.len() / MOTION];
    for (strip, (ends, slopes)) in strips.iter().enumerate() {
        let own = STATE * strip..STATE * (strip + 1);
        let mut along = SVector::<f64, { 2 * MOTION + STATE }>::zeros();
        for (end, section) in ends.iter().enumerate() {
            let motion = &motions[MOTION * section..MOTION * (section + 1)];
            along.as_mut_slice()[MOTION * end..MOTION * (end + 1)].copy_from_slice(motion);
        }
        along.as_mut_slice()[2 * MOTION..].copy_from_slice(&state[own.clone()]);
        let rows = slopes * along;
        for (end, section) in ends.iter().enumerate() {
            let rows = &rows.as_slice()[LOADS * end..LOADS * (end + 1)];
            loads[*section].iter_mut().zip(rows).for_each(|(sum, row)| *sum += row);
        }
        after[own].copy_from_slice(&rows.as_slice()[2 * LOADS..]);
    }
    (after, loads)
}

fn strips_reverse(strips: &[([usize; 2], StripStep)], state: &[f64], loads: &[[f64; LOADS]]) -> (Vec<f64>, Vec<f64>) {
    let mut before = vec![0.0; STATE * strips.len()];
    let mut motions = vec![0.0; MOTION * loads.len()];
    for (strip, (ends, slopes)) in strips.iter().enumerate() {
        let own = STATE * strip..STATE * (strip + 1);
        let mut rows = SVector::<f64, ROWS>::zeros();
        for (end, section) in ends.iter().enumerate() {
            rows.as_mut_slice()[LOADS * end..LOADS * (end + 1)].copy_from_slice(&loads[*section]);
        }
        rows.as_mut_slice()[2 * LOADS..].copy_from_slice(&state[own.clone()]);
        let along = slopes.tr_mul(&rows);
        for (end, section) in ends.iter().enumerate() {
            let back = &along.as_slice()[MOTION * end..MOTION * (end + 1)];
            motions[MOTION * section..].iter_mut().zip(back).for_each(|(sum, back)| *sum += back);
        }
        before[own].copy_from_slice(&along.as_slice()[2 * MOTION..]);
    }
    (before, motions)
}
