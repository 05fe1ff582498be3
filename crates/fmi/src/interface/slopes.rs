//! Derivatives of rows for the integrator of an importer (Model Exchange): of derivatives of states and outputs, with respect to states,
//! inputs, tunable parameters and time.

use crate::interface::access::{Kind, Stage};
use crate::interface::table::Place;
use crate::interface::{AccessError, DerivativeError, Interface, Value, Variability};
use foldwing_engine::machine::Air;
use foldwing_engine::math::corners::{STEPS, slope_off_corners};
use foldwing_engine::plant::{OutputSet, Plant, PlantError};

/// Step of the differences, relative to the nominal magnitude of the known that changes most. The truncation error is its fourth power
/// times the fifth derivative divided by 30, 1e-13 for angles; round-off of the values is 1e-13.
const STEP: f64 = 1e-3;
/// Fourth-order central difference: steps and weights; the sum is divided by 12 steps.
const FOURTH_ORDER: [(f64, f64); 4] = [(1.0, 8.0), (-1.0, -8.0), (2.0, -1.0), (-2.0, 1.0)];
/// Factor by which a step is shortened if an event indicator changes sign within it: a motor reaches its limit there, and its torque has a
/// kink.
const SHORTER: f64 = 1.0 / 64.0;
/// Number of shorter steps tried; the last one is used in any case.
const SHORTER_STEPS: usize = 2;
/// Nominal magnitude of time in s, which scales its step.
const NOMINAL_TIME_S: f64 = 1e-2;
/// Nominal magnitude of inputs, and of parameters that are 0, in their units, which scales their step: values are at most quadratic in most
/// of them, so that a large step adds no truncation error.
const NOMINAL_INPUT: f64 = 10.0;

/// Least nominal magnitude of a parameter that is not 0: the step relative to a smaller one would be lost in round-off.
const SMALL_PARAMETER: f64 = 1e-3;

/// Rate of a coordinate over its magnitude in 1/s, for the step.
const RATE_1_S: f64 = 10.0;

/// Discontinuity between the points of a difference.
enum Between {
    Nothing,
    /// An event indicator changes its sign.
    Limit,
    /// The momentum balance of an annulus of a rotor jumps, so that there is no derivative.
    Jump(usize),
}

/// Discontinuities between the points at which it looks.
struct Passed {
    first: Option<[Vec<bool>; 2]>,
    between: Between,
}

impl Default for Passed {
    fn default() -> Self {
        Self { first: None, between: Between::Nothing }
    }
}

impl Passed {
    /// Compares signs of indicators and the flows through annuli with those at the first point.
    fn look(&mut self, plant: &Plant) {
        let indicators = plant.exchange_indicators().iter().map(|indicator| *indicator > 0.0).collect();
        let here = [indicators, plant.exchange_flows()];
        let first = self.first.get_or_insert_with(|| here.clone());
        let jump = first[1].iter().zip(&here[1]).position(|(one, other)| one != other);
        let is_same = *first == here;
        self.between = match (&self.between, jump) {
            (Between::Jump(annulus), _) => Between::Jump(*annulus),
            (Between::Nothing | Between::Limit, Some(annulus)) => Between::Jump(annulus),
            (Between::Nothing, None) if is_same => Between::Nothing,
            (Between::Nothing | Between::Limit, None) => Between::Limit,
        };
    }
}

/// A known with its current value and its seed.
struct Seeded {
    row: usize,
    value: f64,
    seed: f64,
    /// Typical magnitude.
    nominal: f64,
}

impl Interface {
    /// `Σ ∂unknown/∂known · seed` per unknown, NOTATION eq. (L14), at the states, inputs and parameters set by an importer: along the
    /// seeds by central differences of fourth order, accurate to about 1e-11 of the terms of the unknown, at the cost of four evaluations; with
    /// polars by those of sixth order that avoid their kinks, at the cost of seven, and of six for each shorter step. Discrete states are constant, and a motor at its limit stays there. The loads of strips are part of the equations and included.
    ///
    /// The slices of knowns and of unknowns are equally long; nothing is written unless all can be computed. The caller restores the plant,
    /// on which the changed inputs have acted.
    pub fn exchange_directional_derivative(
        &self,
        plant: &mut Plant,
        (unknowns, values): (&[u32], &mut [f64]),
        (knowns, seeds): (&[u32], &[f64]),
    ) -> Result<(), DerivativeError> {
        let of = self.exchange_unknowns(unknowns)?;
        let mut along = Vec::new();
        for (&known, &seed) in knowns.iter().zip(seeds) {
            let by = self.exchange_known(plant, known)?;
            self.finite_seed(known, seed)?;
            // a known may be given several times
            match along.iter_mut().find(|other: &&mut Seeded| other.row == by.row) {
                Some(other) => other.seed += seed,
                None => along.push(Seeded { seed, ..by }),
            }
        }
        along.retain(|known| known.seed != 0.0);
        values.copy_from_slice(&self.slope(plant, &of, &along)?);
        Ok(())
    }

    /// `Σ seed · ∂unknown/∂known` per known: the transpose of [`Interface::exchange_directional_derivative`], with the same knowns, unknowns
    /// and errors, at this cost for each known.
    pub fn exchange_adjoint_derivative(
        &self,
        plant: &mut Plant,
        (unknowns, seeds): (&[u32], &[f64]),
        (knowns, values): (&[u32], &mut [f64]),
    ) -> Result<(), DerivativeError> {
        let of = self.exchange_unknowns(unknowns)?;
        unknowns.iter().zip(seeds).try_for_each(|(&unknown, &seed)| self.finite_seed(unknown, seed))?;
        let mut sums = vec![0.0; knowns.len()];
        for (sum, &known) in sums.iter_mut().zip(knowns) {
            let column = self.slope(plant, &of, &[self.exchange_known(plant, known)?])?;
            *sum = column.iter().zip(seeds).map(|(entry, seed)| entry * seed).sum();
        }
        values.copy_from_slice(&sums);
        Ok(())
    }

    /// Directional derivative of unknowns along the seeds of knowns.
    fn slope(&self, plant: &mut Plant, unknowns: &[usize], along: &[Seeded]) -> Result<Vec<f64>, PlantError> {
        let size = along.iter().fold(0.0, |size: f64, known| size.max(known.seed.abs() / known.nominal));
        if size == 0.0 {
            return Ok(vec![0.0; unknowns.len()]);
        }
        let mut step = STEP / size;
        let differences = match plant.machine().air.as_ref().is_some_and(Air::has_polars) {
            true => Self::differences_off_corners,
            false => Self::differences,
        };
        let mut found = differences(self, plant, unknowns, along, step);
        for _ in 0..SHORTER_STEPS {
            match found {
                Ok((_, Between::Limit | Between::Jump(_))) => {
                    step *= SHORTER;
                    found = differences(self, plant, unknowns, along, step);
                }
                Ok((_, Between::Nothing)) | Err(_) => break,
            }
        }
        self.shift(plant, along, 0.0);
        match found? {
            (_, Between::Jump(annulus)) => Err(plant.no_exchange_slope(annulus)),
            (slope, Between::Nothing | Between::Limit) => Ok(slope),
        }
    }

    /// Directional differences with a given step, and the discontinuity between the points of evaluation.
    fn differences(
        &self,
        plant: &mut Plant,
        unknowns: &[usize],
        along: &[Seeded],
        step: f64,
    ) -> Result<(Vec<f64>, Between), PlantError> {
        let mut slope = vec![0.0; unknowns.len()];
        let mut values = slope.clone();
        let mut passed = Passed::default();
        for (steps, weight) in FOURTH_ORDER {
            self.displaced(plant, (unknowns, &mut values), along, steps * step)?;
            passed.look(plant);
            slope.iter_mut().zip(&values).for_each(|(sum, value)| *sum += weight * value / (12.0 * step));
        }
        Ok((slope, passed.between))
    }

    /// The same off the kinks of polars: differences of sixth order, with shorter steps where they pass one. Discontinuities count between the
    /// points of the first steps.
    fn differences_off_corners(
        &self,
        plant: &mut Plant,
        unknowns: &[usize],
        along: &[Seeded],
        step: f64,
    ) -> Result<(Vec<f64>, Between), PlantError> {
        let units: Vec<&str> = unknowns.iter().map(|&row| self.variables()[row].unit()).collect();
        let kind = |unit: &&str| units.iter().position(|other| other == unit).unwrap_or_default();
        let kinds: Vec<usize> = units.iter().map(kind).collect();
        let mut present = vec![0.0; unknowns.len()];
        self.displaced(plant, (unknowns, &mut present), along, 0.0)?;
        let (mut passed, mut points, mut failed) = (Passed::default(), 0, None);
        let slope = slope_off_corners(step, &kinds, &present, |shift, side| {
            if let Err(error) = self.displaced(plant, (unknowns, side), along, shift) {
                failed = Some(error);
                return;
            }
            if points < 2 * STEPS.len() {
                passed.look(plant);
            }
            points += 1;
        });
        match failed {
            Some(error) => Err(error),
            None => Ok((slope, passed.between)),
        }
    }

    /// Unknowns with the knowns displaced along their seeds.
    fn displaced(
        &self,
        plant: &mut Plant,
        (unknowns, values): (&[usize], &mut [f64]),
        along: &[Seeded],
        amount: f64,
    ) -> Result<(), PlantError> {
        self.shift(plant, along, amount);
        plant.system_mut().update_exchange()?;
        plant.provide(unknowns.iter().fold(OutputSet::NONE, |needs, &row| needs | self.slots[row].needs));
        for (value, &row) in values.iter_mut().zip(unknowns) {
            *value = match self.slots[row].read(plant, plant.outputs()) {
                Value::Real(value) => value,
                Value::Integer(_) | Value::Boolean(_) => 0.0,
            };
        }
        Ok(())
    }

    /// Sets the knowns to their current values plus `amount` times their seeds.
    fn shift(&self, plant: &mut Plant, along: &[Seeded], amount: f64) {
        for known in along {
            let value = known.value + amount * known.seed;
            match self.slots[known.row].place {
                Place::Time => plant.system_mut().set_exchange_time(value),
                Place::Input(_)
                | Place::Parameter(_)
                | Place::Output(_)
                | Place::Local(_)
                | Place::Duration(_)
                | Place::State(_)
                | Place::Derivative(_)
                | Place::Indicator(_) => {
                    self.slots[known.row].write(plant, Value::Real(value), Stage::Exchanging);
                }
            }
        }
        plant.system_mut().exchange_inputs_set();
    }

    /// Rows of unknowns: derivatives of states and Real outputs.
    fn exchange_unknowns(&self, unknowns: &[u32]) -> Result<Vec<usize>, AccessError> {
        self.check_kind(unknowns, Kind::Real)?;
        let of = |&unknown: &u32| match self.slots[unknown as usize].place {
            Place::Output(_) | Place::Derivative(_) => Ok(unknown as usize),
            Place::Time
            | Place::Input(_)
            | Place::Parameter(_)
            | Place::Local(_)
            | Place::Duration(_)
            | Place::State(_)
            | Place::Indicator(_) => {
                Err(AccessError::NotAnExchangeUnknown { name: self.variables()[unknown as usize].name.clone() })
            }
        };
        unknowns.iter().map(of).collect()
    }

    /// A known with a seed of 1.
    fn exchange_known(&self, plant: &Plant, known: u32) -> Result<Seeded, AccessError> {
        self.check_kind(&[known], Kind::Real)?;
        let row = &self.variables()[known as usize];
        let slot = &self.slots[known as usize];
        let refused = || Err(AccessError::NotAnExchangeKnown { name: row.name.clone() });
        let value = match slot.place {
            Place::Time => plant.exchange_time_s(),
            Place::Parameter(_) if row.variability != Variability::Tunable => return refused(),
            Place::Input(_) | Place::Parameter(_) | Place::State(_) => match slot.read(plant, plant.outputs()) {
                Value::Real(value) => value,
                Value::Integer(_) | Value::Boolean(_) => return refused(),
            },
            Place::Output(_) | Place::Local(_) | Place::Duration(_) | Place::Derivative(_) | Place::Indicator(_) => {
                return refused();
            }
        };
        let nominal = match slot.place {
            // the nominal magnitudes of rates are those of short waves: too long a step for aerodynamic loads, which are not quadratic
            Place::State(state) if (self.coordinates.len()..2 * self.coordinates.len()).contains(&state) => {
                RATE_1_S * self.nominals[state - self.coordinates.len()]
            }
            Place::Time => NOMINAL_TIME_S,
            Place::Input(_) => NOMINAL_INPUT,
            Place::Parameter(_) if value != 0.0 => value.abs().max(SMALL_PARAMETER),
            Place::Parameter(_) => NOMINAL_INPUT,
            Place::State(_)
            | Place::Output(_)
            | Place::Local(_)
            | Place::Duration(_)
            | Place::Derivative(_)
            | Place::Indicator(_) => row.nominal.unwrap_or(1.0),
        };
        Ok(Seeded { row: known as usize, value, seed: 1.0, nominal })
    }
}
