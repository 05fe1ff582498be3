//! The linear model between chosen inputs and outputs, NOTATION eqs. (L12) and (L23).

use crate::signal::{FlapInputs, Inputs};
use crate::solve::linearize::{Accelerations, LaggedInputs, OutputSlopes, StateSpace, lagged_state_space};
use crate::study::Study;
use crate::study::aeroelastic::Aeroelastic;
use crate::study::differences::{Bare, pick};
use crate::study::linear::Argument;
use crate::system::Outputs;
use crate::system::PlantError;
use crate::system::freedoms::Freedom;
use nalgebra::{DMatrix, DVector, Vector3};

/// A real input to be linearised.
pub struct InputSlope<'a> {
    /// Adds an amount to the input.
    pub add: &'a dyn Fn(&mut Inputs, f64),
    /// Step of the central difference. Forces are quadratic in the root's rates and, when linearised, linear in all other inputs, so any
    /// step is exact.
    pub step: f64,
    /// Uniform gust velocity in m/s, root frame, added per unit of the input: gusts are not inputs of the model, so `add` then has no
    /// effect. Strips respond to it with Küssner's lag, rotors and slender bodies at once.
    pub gust_m_s: Vector3<f64>,
}

/// Change of the aerodynamic variables per unit of an input, in the order of `AirSlopes::air`.
pub(super) fn air_of(input: &InputSlope, inputs: &Inputs) -> Vec<f64> {
    let mut ends = [inputs.clone(), inputs.clone()];
    (input.add)(&mut ends[0], input.step);
    (input.add)(&mut ends[1], -input.step);
    let scale = 0.5 / input.step;
    let wind = (ends[0].wind_m_s() - ends[1].wind_m_s()) * scale;
    let spin = (ends[0].root().angular_velocity_rad_s - ends[1].root().angular_velocity_rad_s) * scale;
    let flaps = |read: fn(&FlapInputs) -> f64| {
        let ends = ends[0].flaps().iter().zip(ends[1].flaps());
        ends.map(|(above, below)| (read(above) - read(below)) * scale).collect::<Vec<_>>()
    };
    let (angles, rates) = (flaps(|flap| flap.command_rad), flaps(|flap| flap.command_rate_rad_s));
    [wind.as_slice(), spin.as_slice(), &rates, input.gust_m_s.as_slice(), &angles].concat()
}

impl Study<'_> {
    /// `A`, `B`, `C`, `D` about the current state with the current inputs, over [`crate::system::System::freedoms`] and
    /// their rates, and over the lag states of all aerodynamic models.
    ///
    /// `A` and `B` are exact, except for the stiffness about a moving state ([`Study::second_order`]) and for the aerodynamic response,
    /// which is computed by differences accurate to about 1e-9. `C` and `D` are differences of the instantaneous outputs
    /// ([`Study::output_slope`]). All four use the same tangents of the joint forces, on one side of a kink (`Study::on_tangents`);
    /// discrete states are constant. The loads of lattices are constant. Outputs of accelerations and forces do not include the effect of
    /// the rate of the wind through the apparent mass.
    pub fn state_space(
        &mut self,
        inputs: &[InputSlope],
        read: &dyn Fn(&Outputs) -> DVector<f64>,
    ) -> Result<StateSpace, PlantError> {
        self.on_tangents(|study| study.state_space_on_tangents(inputs, read))
    }

    fn state_space_on_tangents(
        &mut self,
        inputs: &[InputSlope],
        read: &dyn Fn(&Outputs) -> DVector<f64>,
    ) -> Result<StateSpace, PlantError> {
        let gusts = inputs.iter().any(|input| input.gust_m_s != Vector3::zeros());
        let (system, air) = self.lagged(gusts)?;
        let freedoms = self.system.freedoms();
        let count = read(&self.outputs_beside(None)).len();
        let mut slopes = [Argument::Position, Argument::Rate].map(|argument| {
            let columns: Vec<DVector<f64>> =
                freedoms.iter().map(|freedom| self.output_slope(argument, freedom, read)).collect();
            columns_of(&columns, count)
        });
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
        let mut by_lag = DMatrix::zeros(count, system.lag.nrows());
        let (mut force, mut by_input) = (columns_of(&forces, freedoms.len()), columns_of(&by_input, count));
        let mut impulse = DMatrix::zeros(freedoms.len(), inputs.len());
        let mut follow = DMatrix::zeros(system.lag.nrows(), inputs.len());
        let currents = self.system.equations.model.circuits.len();
        let of_air = system.lag.nrows() - currents;
        for (column, input) in inputs.iter().enumerate() {
            follow.view_mut((of_air, column), (currents, 1)).copy_from(&self.currents_of_input(input));
        }
        let shown = self.outputs_of_currents(count, read);
        by_lag.columns_mut(of_air, currents).copy_from(&shown);
        if let Some(Aeroelastic { slopes: answers, air_force, air_rate_force, .. }) = &air {
            let kept = self.system.inputs().clone();
            let shares: Vec<DVector<f64>> = inputs.iter().map(|input| DVector::from(air_of(input, &kept))).collect();
            if !shares.is_empty() {
                let share = DMatrix::from_columns(&shares);
                force += air_force * &share;
                impulse += air_rate_force * share.rows(0, air_rate_force.ncols());
                let rows = answers.load_rows;
                let mut lags = follow.rows_mut(0, of_air);
                lags += answers.air.rows(rows, answers.lags.len()) * &share;
                by_input += self.outputs_of_air(&(&answers.air * &share), count, read);
            }
            for (slopes, answers) in slopes.iter_mut().zip(&answers.motion) {
                *slopes += self.outputs_of_air(answers, count, read);
            }
            let mut lags = by_lag.columns_mut(0, of_air);
            lags += self.outputs_of_air(&answers.lag, count, read);
        }
        let [position, rate] = slopes.each_mut().map(std::mem::take);
        let slopes = OutputSlopes { position, rate, input: by_input };
        let directions: Vec<DVector<f64>> =
            freedoms.iter().map(|freedom| DVector::from(self.direction(freedom))).collect();
        let mut along_tree = AlongTree {
            bare: Bare::without_stiffness(self.system),
            directions: columns_of(&directions, self.system.coordinates()),
            freedoms,
            apparent: air.map(|air| {
                let [.., by_acceleration] = air.slopes.motion;
                (air.mass, by_acceleration)
            }),
            count,
            read,
            study: self,
        };
        let inputs = LaggedInputs { force, impulse, follow };
        lagged_state_space(&system, &inputs, &slopes, &by_lag, &mut along_tree).ok_or_else(|| {
            PlantError::Linearization {
                time_s: self.system.time_s(),
                cause: "the mass matrix is not positive definite".into(),
            }
        })
    }

    /// Changes of the outputs due to the aerodynamic response, column by column: they are linear in loads and circulations.
    pub(super) fn outputs_of_air(
        &mut self,
        answers: &DMatrix<f64>,
        count: usize,
        read: &dyn Fn(&Outputs) -> DVector<f64>,
    ) -> DMatrix<f64> {
        let mut slopes = DMatrix::zeros(count, answers.ncols());
        for (column, answer) in answers.column_iter().enumerate() {
            let size = answer.amax();
            if size == 0.0 {
                continue;
            }
            let scale = self.system.air_scale_n().max(1.0) / size;
            let [above, below] = [scale, -scale].map(|amount| {
                let kept = self.system.add_to_air(answer.as_slice(), amount);
                let beside = read(&self.outputs_beside(None));
                self.system.take_air_back(kept);
                beside
            });
            slopes.set_column(column, &((above - below) * (0.5 / scale)));
        }
        self.outputs_beside(None);
        slopes
    }
}

/// Accelerations of the model by sweeps along the tree.
struct AlongTree<'s, 'a, 'r> {
    study: &'s mut Study<'a>,
    bare: Bare,
    /// Derivatives of the coordinates' accelerations with respect to those of the degrees of freedom.
    directions: DMatrix<f64>,
    freedoms: Vec<Freedom>,
    /// Apparent mass, and the aerodynamic response to accelerations.
    apparent: Option<(DMatrix<f64>, DMatrix<f64>)>,
    count: usize,
    read: &'r dyn Fn(&Outputs) -> DVector<f64>,
}

impl Accelerations for AlongTree<'_, '_, '_> {
    fn inertia(&mut self, accelerations: &DMatrix<f64>) -> DMatrix<f64> {
        let mut forces = DMatrix::zeros(accelerations.nrows(), accelerations.ncols());
        let q = &self.study.system.state.now.q;
        for (mut force, column) in forces.column_iter_mut().zip(accelerations.column_iter()) {
            let along = &self.directions * column;
            force.copy_from(&pick(&self.bare.of_accelerations(q, along.as_slice()), &self.freedoms));
        }
        if let Some((mass, _)) = &self.apparent {
            forces += mass * accelerations;
        }
        forces
    }

    fn shown(&mut self, accelerations: &DMatrix<f64>) -> DMatrix<f64> {
        let mut shown = DMatrix::zeros(self.count, accelerations.ncols());
        let present = self.study.system.state.now.a.iter().fold(1.0f64, |size, a| size.max(a.abs()));
        for (mut shown, column) in shown.column_iter_mut().zip(accelerations.column_iter()) {
            let along = &self.directions * column;
            let size = along.amax();
            if size > 0.0 {
                // outputs are linear in this step: at least as large as the current value, so that the change is not lost in round-off
                let scale = (present / size).max(1.0);
                let mut at = |sign: f64| {
                    let shift: Vec<f64> = along.iter().map(|a| sign * scale * a).collect();
                    (self.read)(&self.study.outputs_pulled(&shift))
                };
                shown.copy_from(&((at(1.0) - at(-1.0)) * (0.5 / scale)));
            }
        }
        if let Some((_, answers)) = &self.apparent {
            shown += self.study.outputs_of_air(&(answers * accelerations), self.count, self.read);
        }
        shown
    }
}

/// A matrix of columns, with `rows` rows even if there are no columns.
pub(super) fn columns_of(columns: &[DVector<f64>], rows: usize) -> DMatrix<f64> {
    if columns.is_empty() { DMatrix::zeros(rows, 0) } else { DMatrix::from_columns(columns) }
}
