//! Growth and decay about a periodic motion: leading multipliers of a turn, NOTATION eqs. (L34) to (L36).

use crate::run::Plant;
use crate::run::periodic::shooting::{PeriodicMotion, Shooting};
use crate::run::periodic::turn::{SAMPLES, Turn};
use crate::solve::floquet::{Harmonic, resolve, separate};
use crate::solve::krylov::{RitzPair, leading};
use crate::study::{AveragedModes, GroundView, Rotor};
use crate::system::{ModeShape, PlantError, WhirlShare};
use nalgebra::{Complex, DVector};
use std::f64::consts::TAU;

/// Central difference by which a product is found, in the measure of the states.
const STEP: f64 = 1e-4;
/// Error of a multiplier over its magnitude beyond which it is left out.
const ERROR: f64 = 1e-4;
/// Multiplier that nothing is left of within a turn: round-off and differences are larger.
const GONE: f64 = 1e-5;
/// Distance of multipliers over their magnitude up to which their motions may be any mixture: ten times what differences leave of it.
const SAME: f64 = 1e-6;
/// Samples of the turn that the averaged model is made of.
const AVERAGED: usize = 24;

/// A motion about a periodic one, eq. (L35).
#[derive(Debug, Clone, PartialEq)]
pub struct FloquetMode {
    /// What a turn multiplies it by; of a complex pair one.
    pub multiplier: Complex<f64>,
    /// Exponent `λ` in 1/s, with the frequency that the largest part of the motion shows to the ground.
    pub exponent_1_s: Complex<f64>,
    /// `|λ|/2π` in Hz.
    pub frequency_hz: f64,
    /// `−Re λ/|λ|`.
    pub damping_ratio: f64,
    /// Frequencies that it shows, largest share first.
    pub harmonics: Vec<Harmonic>,
    /// Whether the second of these has more than half the share of the first.
    pub ambiguous: bool,
    /// What moves, largest share first.
    pub parts: Vec<WhirlShare>,
    /// Error of the multiplier over its magnitude, as Arnoldi's iteration estimates it.
    pub error: f64,
    /// Nearest eigenvalue of the averaged model in 1/s, where there is one.
    pub averaged_1_s: Option<Complex<f64>>,
}

/// What happens beside a periodic motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Floquet {
    /// Modes, slowest decay first.
    pub modes: Vec<FloquetMode>,
    /// Modes of the averaged model, of machines without air whose rotor has equal blades.
    pub averaged: Option<AveragedModes>,
    /// States of the motion.
    pub states: usize,
    /// Turns marched.
    pub turns: usize,
}

impl ModeShape {
    /// A mode beside a periodic motion: its exponent and what moves; a shape it has none, as it changes over the turn.
    pub fn of_floquet(mode: FloquetMode) -> Self {
        Self {
            frequency_hz: mode.frequency_hz,
            damping_ratio: mode.damping_ratio,
            eigenvalue_1_s: mode.exponent_1_s,
            shares: [0.0; 5],
            real: Vec::new(),
            imaginary: Vec::new(),
            length_m: 1.0,
            whirl: mode.parts,
            flight: None,
        }
    }
}

impl Plant {
    /// A periodic motion of the machine that [`Turn::of`] has made ready, NOTATION eqs. (L32) and (L33): the state of an initialised plant
    /// is where the search begins. The plant is then at the begin of the turn.
    ///
    /// `accuracy` bounds the distance between begin and end of the turn: rotation in rad or displacement over the machine's length,
    /// rates over the speed of the shaft.
    ///
    /// # Errors
    /// [`PlantError::Periodic`] where no motion is found, or a joint meets latch or stops within the turn; those of [`Plant::step`].
    pub fn periodic(&mut self, turn: &Turn, accuracy: f64) -> Result<PeriodicMotion, PlantError> {
        Shooting::new(self, *turn).close(accuracy)
    }

    /// Marches the turn of a periodic motion; `seen` gets the number of the sample, from 0 to [`SAMPLES`], which is the end of the
    /// turn, and the plant there.
    ///
    /// # Errors
    /// Those of [`Plant::restore`], [`Plant::step`] and `seen`.
    pub fn trace(
        &mut self,
        turn: &Turn,
        motion: &PeriodicMotion,
        seen: &mut dyn FnMut(usize, &mut Plant) -> Result<(), PlantError>,
    ) -> Result<(), PlantError> {
        self.restore(&motion.start)?;
        let mut shooting = Shooting::new(self, *turn);
        let states = shooting.at_begin();
        shooting.march(&states, seen).map(|_| ())
    }

    /// Modes about a periodic motion from at most `products` directions, each of which costs two turns. Modes that a turn leaves nothing of
    /// and those that the directions do not show to four digits are left out. Without a rotor of equal blades
    /// ([`crate::study::Study::rotor`]) motions are those of the machine's own coordinates, and there is no averaged model.
    ///
    /// # Errors
    /// As [`Plant::trace`].
    pub fn floquet(&mut self, turn: &Turn, motion: &PeriodicMotion, products: usize) -> Result<Floquet, PlantError> {
        self.restore(&motion.start)?;
        let speed_rad_s = turn.speed_rad_s;
        let rotor = self.rotor_of(turn);
        let mut view = self.study().ground_view(turn.shaft, rotor.as_ref(), speed_rad_s)?;
        let averaged = match (&rotor, &self.system.machine.air) {
            (Some(_), None) => self.average(turn, motion, &mut view)?,
            _ => None,
        };
        self.restore(&motion.start)?;
        let mut shooting = Shooting::new(self, *turn);
        let (states, free) = (shooting.at_begin(), shooting.free.clone());
        let n = shooting.states();
        let mut beside: Vec<Vec<DVector<f64>>> = Vec::new();
        let mut product = |_: usize, direction: &DVector<f64>| -> Result<DVector<f64>, PlantError> {
            let mut paths: [Vec<DVector<f64>>; 2] = [Vec::new(), Vec::new()];
            let mut ends = Vec::new();
            for (path, sign) in paths.iter_mut().zip([1.0, -1.0]) {
                let mut seen = |sample: usize, plant: &mut Plant| {
                    if sample < SAMPLES {
                        path.push(DVector::from_iterator(
                            free.len(),
                            free.iter().map(|&c| plant.system.state.now.q[c]),
                        ));
                    }
                    Ok(())
                };
                ends.push(shooting.march(&(&states + direction * (sign * STEP)), &mut seen)?);
            }
            let difference = |above: &DVector<f64>, below: &DVector<f64>| (above - below) / (2.0 * STEP);
            beside.push(paths[0].iter().zip(&paths[1]).map(|(above, below)| difference(above, below)).collect());
            Ok(difference(&ends[0], &ends[1]))
        };
        let pairs = leading(n, products, &mut product)?;
        let turns = shooting.turns;
        let weights = view.weights();
        let motion_of = |pair: &RitzPair| -> Vec<DVector<Complex<f64>>> {
            let seen = |sample: usize| -> DVector<Complex<f64>> {
                let mut sum = DVector::zeros(free.len());
                for (amount, path) in pair.amounts.iter().zip(&beside) {
                    sum += path[sample].map(|x| amount * x);
                }
                view.components(&sum, speed_rad_s.signum() * TAU * sample as f64 / SAMPLES as f64)
            };
            (0..SAMPLES).map(seen).collect()
        };
        let mut list: Vec<(RitzPair, Vec<DVector<Complex<f64>>>)> = Vec::new();
        let mut pairs: Vec<RitzPair> =
            pairs.into_iter().filter(|pair| pair.error <= ERROR && pair.value.norm() > GONE).collect();
        while !pairs.is_empty() {
            let first = pairs[0].value;
            let (same, others): (Vec<RitzPair>, Vec<RitzPair>) =
                pairs.into_iter().partition(|pair| (pair.value - first).norm() <= SAME * first.norm());
            pairs = others;
            let motions: Vec<_> = same.iter().map(motion_of).collect();
            if same.len() == 1 {
                list.extend(same.into_iter().zip(motions));
                continue;
            }
            for (pair, amounts) in same.iter().zip(separate(first, turn.period_s(), &motions, &weights)) {
                let mut sum = vec![DVector::zeros(weights.len()); SAMPLES];
                for (motion, amount) in motions.iter().zip(&amounts) {
                    sum.iter_mut().zip(motion).for_each(|(sum, seen)| sum.axpy(*amount, seen, Complex::new(1.0, 0.0)));
                }
                list.push((pair.clone(), sum));
            }
        }
        let mut modes = Vec::new();
        for (pair, seen) in list {
            let read = resolve(pair.value, turn.period_s(), &seen, &weights);
            let exponent_1_s = read.exponent_1_s;
            let size = exponent_1_s.norm();
            let near = |value: &&Complex<f64>| (**value - exponent_1_s).norm();
            let nearest = averaged.as_ref().and_then(|averaged| {
                averaged.eigenvalues_1_s.iter().min_by(|a, b| near(a).total_cmp(&near(b))).copied()
            });
            modes.push(FloquetMode {
                multiplier: pair.value,
                exponent_1_s,
                frequency_hz: size / TAU,
                damping_ratio: if size == 0.0 { 0.0 } else { -exponent_1_s.re / size },
                ambiguous: read.is_ambiguous(),
                parts: self.study().moving_parts(&view, &read.shape),
                harmonics: read.harmonics,
                error: pair.error,
                averaged_1_s: nearest,
            });
        }
        self.restore(&motion.start)?;
        Ok(Floquet { modes, averaged, states: n, turns })
    }

    /// The rotor on the shaft, if its blades are equal.
    fn rotor_of(&mut self, turn: &Turn) -> Option<Rotor> {
        let machine = self.system.machine.clone();
        let shaft = &machine.bodies[turn.shaft].joint.name;
        self.study().rotor(machine.experiment.start_time_s, Some(shaft)).ok()
    }

    /// Modes of the equations averaged over the turn, eq. (L36).
    fn average(
        &mut self,
        turn: &Turn,
        motion: &PeriodicMotion,
        view: &mut GroundView,
    ) -> Result<Option<AveragedModes>, PlantError> {
        let speed_rad_s = turn.speed_rad_s;
        let mut seen = |sample: usize, plant: &mut Plant| {
            if sample == SAMPLES || !sample.is_multiple_of(SAMPLES / AVERAGED) {
                return Ok(());
            }
            plant.study().see(view, speed_rad_s.signum() * TAU * sample as f64 / SAMPLES as f64)
        };
        self.trace(turn, motion, &mut seen)?;
        Ok(view.averaged())
    }
}
