//! Variations of a point of a run, and the quantities that cause them.

use crate::gradient::{add, dot};

/// Quantities that vary besides the start of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Causes<'c> {
    /// The parameters, each in a direction of its own.
    pub parameters: bool,
    /// Loads of the air in each direction; empty if they do not vary.
    pub loads: &'c [Vec<f64>],
}

impl Causes<'_> {
    /// Nothing else.
    pub const NONE: Self = Self { parameters: false, loads: &[] };
    /// The parameters.
    pub const PARAMETERS: Self = Self { parameters: true, loads: &[] };
}

/// A variation of a point.
#[derive(Debug, Clone)]
pub(super) struct Variation {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
}

impl Variation {
    pub fn zeros(coordinates: usize) -> Self {
        let zeros = vec![0.0; coordinates];
        Self { q: zeros.clone(), v: zeros.clone(), a: zeros }
    }

    /// Its coordinates, rates or accelerations.
    pub fn part_mut(&mut self, order: usize) -> &mut [f64] {
        match order {
            0 => &mut self.q,
            1 => &mut self.v,
            _ => &mut self.a,
        }
    }

    pub fn add(&mut self, factor: f64, other: &Self) {
        add(&mut self.q, factor, &other.q);
        add(&mut self.v, factor, &other.v);
        add(&mut self.a, factor, &other.a);
    }
}

/// Scalar product of a variation and multipliers.
pub(super) fn product(a: &Variation, b: &Variation) -> f64 {
    dot(&a.q, &b.q) + dot(&a.v, &b.v) + dot(&a.a, &b.a)
}

/// Variations of a point of the run in several directions, and of its time.
#[derive(Debug, Clone)]
pub(super) struct Front {
    pub variations: Vec<Variation>,
    pub shifts_s: Vec<f64>,
}
