//! Inputs within a communication step: constant, or `u + u̇ (t − t_c)`, NOTATION eq. (A4).

use crate::load::{RootMotion, Wrench};
use crate::signal::Inputs;
use crate::system::state::State;
use nalgebra::Vector3;

impl RootMotion {
    /// Advances all quantities linearly by `elapsed_s` times their rates.
    fn run_on(&mut self, rates: &Self, elapsed_s: f64) {
        self.gravity_m_s2 += rates.gravity_m_s2 * elapsed_s;
        self.acceleration_m_s2 += rates.acceleration_m_s2 * elapsed_s;
        self.angular_velocity_rad_s += rates.angular_velocity_rad_s * elapsed_s;
        self.angular_acceleration_rad_s2 += rates.angular_acceleration_rad_s2 * elapsed_s;
    }
}

impl State {
    /// Wind at a time of the current communication step in m/s.
    pub fn wind_at_m_s(&self, time_s: f64) -> Vector3<f64> {
        self.applied_inputs.wind_m_s() + self.applied_rates.wind_m_s() * (time_s - self.applied_from_s)
    }

    /// Angular velocity of the root frame at a time of the current communication step in rad/s.
    pub fn spin_at_rad_s(&self, time_s: f64) -> Vector3<f64> {
        self.applied_inputs.root().angular_velocity_rad_s
            + self.applied_rates.root().angular_velocity_rad_s * (time_s - self.applied_from_s)
    }

    /// Ends a communication step: the rates apply to one step only, and the inputs keep their values at its end.
    pub fn arrive(&mut self) {
        self.rates.clear();
        if !self.applied_rates.is_still() {
            self.inputs.clone_from(&self.applied_inputs);
            self.inputs.run_on(&self.applied_rates, self.now.time_s - self.applied_from_s);
        }
    }
}

/// Inputs of the current communication step as functions of time, for the equations.
#[derive(Debug, Clone)]
pub(crate) struct Course {
    /// Whether some rate is nonzero.
    pub moves: bool,
    /// Time of `base` in s.
    pub from_s: f64,
    /// Inputs at `from_s`.
    pub base: Inputs,
    /// Their rates per second.
    pub rates: Inputs,
}

impl Course {
    /// Inputs that are held constant.
    pub fn held(inputs: &Inputs) -> Self {
        Self { moves: false, from_s: 0.0, base: inputs.clone(), rates: inputs.no_rates() }
    }

    /// Copies the inputs and rates of a state's current step. Allocates nothing.
    pub fn follow(&mut self, state: &State) {
        self.from_s = state.applied_from_s;
        self.base.clone_from(&state.applied_inputs);
        self.rates.clone_from(&state.applied_rates);
        self.moves = !self.rates.is_still();
    }

    /// Motion of the root at a time.
    pub fn root(&self, time_s: f64) -> RootMotion {
        let mut root = *self.base.root();
        root.run_on(self.rates.root(), time_s - self.from_s);
        root
    }

    /// Loads of the stations at a time.
    pub fn write_stations(&self, time_s: f64, loads: &mut [Wrench]) {
        let elapsed_s = time_s - self.from_s;
        for ((load, base), rate) in loads.iter_mut().zip(self.base.stations()).zip(self.rates.stations()) {
            load.force_n = base.force_n + rate.force_n * elapsed_s;
            load.moment_n_m = base.moment_n_m + rate.moment_n_m * elapsed_s;
        }
    }

    /// Voltage of a DC motor at a time in V.
    pub fn voltage_v(&self, dc_motor: usize, time_s: f64) -> f64 {
        let (base, rate) = (&self.base.dc_motors()[dc_motor], &self.rates.dc_motors()[dc_motor]);
        base.voltage_v + rate.voltage_v * (time_s - self.from_s)
    }

    /// External torque of a revolute joint at a time in N·m.
    pub fn torque_n_m(&self, joint: usize, time_s: f64) -> f64 {
        self.base.joints()[joint].torque_n_m + self.rates.joints()[joint].torque_n_m * (time_s - self.from_s)
    }
}
