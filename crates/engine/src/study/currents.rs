//! Currents of DC motors in linear models: first-order states, NOTATION eq. (A14).

use crate::multibody::circuit::Circuit;
use crate::signal::DcMotorInputs;
use crate::solve::lagged::Lagged;
use crate::study::Study;
use crate::study::state_space::InputSlope;
use crate::system::{Outputs, System};
use nalgebra::{DMatrix, DVector};

impl System {
    /// Currents as states of linear models, after the aerodynamic lag states: name, unit, value.
    pub fn current_states(&self) -> Vec<(String, &'static str, f64)> {
        let values = self.equations.model.circuits.iter().map(|circuit| self.state.now.v[circuit.coordinate]);
        self.exchange_currents().into_iter().zip(values).map(|(name, value)| (name, "A", value)).collect()
    }
}

impl Study<'_> {
    /// Equations with the currents appended to their lag states. A current has no influence on held joints, and their rates none on it.
    pub(super) fn with_currents(&self, system: Lagged) -> Lagged {
        let circuits = &self.system.equations.model.circuits;
        if circuits.is_empty() {
            return system;
        }
        let freedoms = self.system.freedoms();
        let (n, lags, count) = (freedoms.len(), system.lag.nrows(), circuits.len());
        let mut force = system.force.resize_horizontally(lags + count, 0.0);
        let mut rate = system.rate.resize_vertically(lags + count, 0.0);
        let mut lag = system.lag.resize(lags + count, lags + count, 0.0);
        let position = system.position.resize(lags + count, n, 0.0);
        for (place, circuit) in (lags..).zip(circuits) {
            lag[(place, place)] = -circuit.resistance_ohm / circuit.inductance_h;
            if let Some(joint) = freedoms.iter().position(|freedom| freedom.index == circuit.joint) {
                force[(joint, place)] = -circuit.constant_n_m_a;
                rate[(place, joint)] = -circuit.constant_n_m_a / circuit.inductance_h;
            }
        }
        Lagged { second: system.second, force, position, rate, lag }
    }

    /// Changes a current at the current state by an amount in A.
    pub(super) fn add_to_current(&mut self, current: usize, amount_a: f64) {
        if let Some(circuit) = self.system.equations.model.circuits.get(current) {
            self.system.state.now.v[circuit.coordinate] += amount_a;
        }
    }

    /// Derivatives of `count` outputs with respect to the currents, with the accelerations constant: exact, because outputs are of second
    /// degree in the currents.
    pub(super) fn outputs_of_currents(
        &mut self,
        count: usize,
        read: &dyn Fn(&Outputs) -> DVector<f64>,
    ) -> DMatrix<f64> {
        let circuits = self.system.equations.model.circuits.len();
        let mut slopes = DMatrix::zeros(count, circuits);
        for current in 0..circuits {
            let [above, below] = [1.0, -1.0].map(|amount_a| {
                self.add_to_current(current, amount_a);
                let beside = read(&self.outputs_beside(None));
                self.add_to_current(current, -amount_a);
                beside
            });
            slopes.set_column(current, &((above - below) * 0.5));
        }
        slopes
    }

    /// Derivatives of the rates of the currents with respect to an input: only voltages act on them.
    pub(super) fn currents_of_input(&self, input: &InputSlope) -> DVector<f64> {
        let mut ends = [self.system.inputs().clone(), self.system.inputs().clone()];
        (input.add)(&mut ends[0], input.step);
        (input.add)(&mut ends[1], -input.step);
        let circuits =
            self.system.equations.model.circuits.iter().zip(ends[0].dc_motors().iter().zip(ends[1].dc_motors()));
        let slope = |(circuit, (above, below)): (&Circuit, (&DcMotorInputs, &DcMotorInputs))| {
            (above.voltage_v - below.voltage_v) * 0.5 / (input.step * circuit.inductance_h)
        };
        DVector::from_iterator(self.system.equations.model.circuits.len(), circuits.map(slope))
    }
}
