//! The linear model between chosen inputs and outputs, NOTATION eq. (L12).

use crate::signal::Inputs;
use crate::solve::linearize::{OutputSlopes, StateSpace, state_space};
use crate::study::Study;
use crate::study::linear::Argument;
use crate::system::Outputs;
use crate::system::PlantError;
use nalgebra::{DMatrix, DVector};

/// A real input as the linearisation needs it.
pub struct InputSlope<'a> {
    /// Adds an amount to the input.
    pub add: &'a dyn Fn(&mut Inputs, f64),
    /// Step of the central difference. Forces are quadratic in the root's rates and linear in all other inputs, so any
    /// step serves that does not cross a torque limit.
    pub step: f64,
}

impl Study<'_> {
    /// `A`, `B`, `C`, `D` about the present state with the present inputs, over [`crate::system::System::freedoms`] and their rates.
    ///
    /// `A` and `B` are exact, but for the stiffness about a moving state ([`Study::second_order`]); `C` and `D` come from
    /// differences of the instantaneous outputs ([`Study::output_slope`]). Events and saturation stay as they are.
    pub fn state_space(
        &mut self,
        inputs: &[InputSlope],
        read: &dyn Fn(&Outputs) -> DVector<f64>,
    ) -> Result<StateSpace, PlantError> {
        let system = self.second_order()?;
        let freedoms = self.system.freedoms();
        let mut slopes = [Argument::Position, Argument::Rate, Argument::Acceleration].map(|argument| {
            let columns: Vec<DVector<f64>> =
                freedoms.iter().map(|freedom| self.output_slope(argument, freedom, read)).collect();
            columns_of(&columns, 0)
        });
        let count = read(&self.outputs_beside(None)).len();
        let (mut forces, mut by_input) = (Vec::new(), Vec::new());
        for input in inputs {
            let kept = self.system.inputs().clone();
            let mut ends = [1.0, -1.0].map(|sign| {
                (input.add)(self.system.inputs_mut(), sign * input.step);
                let end = (self.residual_of_inputs(), read(&self.outputs_beside(None)));
                self.system.inputs_mut().clone_from(&kept);
                end
            });
            let scale = 0.5 / input.step;
            let [(force_above, output_above), (force_below, output_below)] = &mut ends;
            forces.push((&*force_above - &*force_below) * scale);
            by_input.push((&*output_above - &*output_below) * scale);
        }
        let [position, rate, acceleration] = slopes.each_mut().map(std::mem::take);
        let slopes = OutputSlopes { position, rate, acceleration, input: columns_of(&by_input, count) };
        state_space(&system, &columns_of(&forces, freedoms.len()), &slopes).ok_or_else(|| PlantError::Linearization {
            time_s: self.system.time_s(),
            cause: "the mass matrix is not positive definite".into(),
        })
    }
}

/// A matrix of columns, with `rows` rows if there is none.
fn columns_of(columns: &[DVector<f64>], rows: usize) -> DMatrix<f64> {
    if columns.is_empty() { DMatrix::zeros(rows, 0) } else { DMatrix::from_columns(columns) }
}
