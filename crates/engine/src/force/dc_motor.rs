//! Electrical DC motor: a torque proportional to its armature current, which is a state, NOTATION eqs. (A12)–(A14).

use crate::force::Here;
use crate::multibody::circuit::Circuit;
use crate::solve::Powers;

/// An electrical DC motor on the degree of freedom of a joint.
///
/// Names are those of a revolute joint; for a prismatic joint read N for N·m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DcMotor {
    /// Resistance of the armature in Ω, positive.
    pub resistance_ohm: f64,
    /// Inductance of the armature in H, positive.
    pub inductance_h: f64,
    /// Torque per current on the motor's shaft in N·m/A, equal to the voltage per speed in V·s/rad; positive.
    pub torque_constant_n_m_a: f64,
    /// Ratio of the shaft speed to the joint rate, negative for opposite directions.
    pub gear_ratio: f64,
    /// Start value of the voltage input in V.
    pub voltage_v: f64,
    /// Armature current at the start in A; not used by a start in equilibrium.
    pub start_current_a: f64,
}

/// The armature of a motor under its voltage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Armature {
    /// Its circuit.
    pub circuit: Circuit,
    /// Voltage in V.
    pub voltage_v: f64,
}

impl Armature {
    /// Adds the electrical power as work of the input, and the heat of the resistance, eq. (A13).
    pub fn add_powers(&self, here: &Here, powers: &mut Powers) {
        let current_a = here.v[self.circuit.coordinate];
        powers.work += self.voltage_v * current_a;
        powers.dissipated += self.circuit.resistance_ohm * current_a * current_a;
    }

    /// Current at rest in A.
    pub fn rest_current_a(&self) -> f64 {
        self.voltage_v / self.circuit.resistance_ohm
    }
}
