//! A mode of a body whose damping is given by its ratio, NOTATION eq. (D31).

use crate::multibody::element::Element;

/// A damped mode of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct DampedMode {
    /// Index of the body.
    pub body: usize,
    /// Index of the body's first strain in `q`.
    pub first: usize,
    /// Momenta `Mφ` of the mode, `φᵀMφ = 1`, per strain of the body.
    pub momenta: Vec<f64>,
    /// `2ζω` in 1/s.
    pub rate_1_s: f64,
}

impl DampedMode {
    /// Rate of the mode's coordinate at rates `v` of all coordinates.
    pub fn rate(&self, v: &[f64]) -> f64 {
        self.momenta.iter().zip(&v[self.first..]).map(|(momentum, v)| momentum * v).sum()
    }

    /// Adds the damping forces at rates `v`, eq. (D31).
    pub(crate) fn add_forces(&self, v: &[f64], residual: &mut [f64]) {
        let force = self.rate_1_s * self.rate(v);
        self.momenta.iter().zip(&mut residual[self.first..]).for_each(|(momentum, sum)| *sum += momentum * force);
    }

    /// Dissipated power in W.
    pub fn power_w(&self, v: &[f64]) -> f64 {
        self.rate_1_s * self.rate(v).powi(2)
    }

    /// Damping forces on the strains of an element at rates `v`.
    pub(crate) fn forces_on<const N: usize>(&self, element: &Element, v: &[f64]) -> [f64; N] {
        let force = self.rate_1_s * self.rate(v);
        std::array::from_fn(|i| self.momenta[element.coordinate - self.first + i] * force)
    }
}
