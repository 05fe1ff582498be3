//! Stability of a periodic motion: leading multipliers over a revolution, NOTATION eqs. (L34) to (L36).

use crate::run::Plant;
use crate::run::periodic::shooting::{PeriodicMotion, Shooting};
use crate::run::periodic::turn::{SAMPLES, Turn};
use crate::solve::floquet::{Harmonic, principal_1_s, resolve, separate};
use crate::solve::krylov::{RitzPair, leading};
use crate::study::{AveragedModes, GroundView, Rotor};
use crate::system::{ENERGY_SHARES, ModeShape, PlantError, WhirlShare};
use nalgebra::{Complex, DVector};
use std::f64::consts::TAU;

/// Step of the central difference for a product, in scaled states.
const STEP: f64 = 1e-4;
/// Nonlinearity of the revolution over a difference step, relative to the product, above which the step is shortened; the factor of
/// shortening and its maximum number.
const CURVED: f64 = 1e-4;
const SHORTER: f64 = 0.1;
const SHORTENINGS: usize = 2;
/// Length of a product for a direction of unit length, below which the product is round-off.
const SMALL: f64 = 1e-2;
/// Steps per period below which a mode is not resolved: with this number the fourth-order error of its frequency is 4e-6.
const STEPS_IN_A_PERIOD: f64 = 24.0;
/// Magnitude of `ln μ` below which a mode has neither stiffness nor damping: two multipliers of 1 are perturbed by the square root of the
/// error of products, 1e-8.
const NEUTRAL: f64 = 1e-4;
/// Relative distance of an averaged mode due to errors of steps and products if the average is exact.
const SAME: f64 = 1e-3;
/// Relative error of a multiplier above which it is omitted.
const ERROR: f64 = 1e-4;
/// Number of estimated errors by which a multiplier must exceed 1 to count as growing.
const ERRORS: f64 = 10.0;
/// Multiplier below which a mode has decayed within a revolution: round-off and difference errors are larger.
const GONE: f64 = 1e-5;
/// Relative distance of multipliers up to which their modes may be arbitrarily mixed: ten times the difference error.
const ALIKE: f64 = 1e-6;
/// Number of samples of the revolution in the averaged model.
const AVERAGED: usize = 24;

/// A Floquet mode of a periodic motion, eq. (L35).
#[derive(Debug, Clone, PartialEq)]
pub struct FloquetMode {
    /// Factor by which the mode changes over one revolution; one of a complex pair.
    pub multiplier: Complex<f64>,
    /// Exponent `λ` in 1/s, with the frequency in the fixed frame of the harmonic with the largest participation.
    pub exponent_1_s: Complex<f64>,
    /// Frequency `|λ|/2π` in Hz.
    pub frequency_hz: f64,
    /// Damping ratio `−Re λ/|λ|`; 0 for a degree of freedom without stiffness and damping ([`FloquetMode::is_neutral`]).
    pub damping_ratio: f64,
    /// Frequencies in its response, largest participation first.
    pub harmonics: Vec<Harmonic>,
    /// Whether the participation of the second harmonic is more than half that of the first.
    pub ambiguous: bool,
    /// Moving parts, largest participation first.
    pub parts: Vec<WhirlShare>,
    /// Relative error of the multiplier, estimated from Arnoldi's iteration and from the nonlinearity of the revolution over the difference
    /// steps.
    pub error: f64,
    /// Principal exponent in 1/s: `ln μ` divided by the period, with an imaginary part of at most half the shaft speed.
    pub principal_1_s: Complex<f64>,
    /// Periodic part of the motion at the [`SAMPLES`] of the revolution: changes of the degrees of freedom
    /// ([`System::freedoms`](crate::system::System::freedoms)), `u(t) = p(t) exp(λ t)` with the principal exponent.
    pub motion: Vec<DVector<Complex<f64>>>,
    /// Nearest eigenvalue of the averaged model in 1/s, if its distance is at most the variation due to the stiffness over the revolution.
    pub averaged_1_s: Option<Complex<f64>>,
}

impl FloquetMode {
    /// Whether it is a degree of freedom without stiffness and damping: its multiplier is 1 within the error of the products.
    pub fn is_neutral(&self) -> bool {
        self.multiplier.ln().norm() < NEUTRAL && self.harmonics.first().is_none_or(|harmonic| harmonic.number == 0)
    }

    /// Whether it grows by more than its error and by more than the error of the multipliers of rigid-body modes, which are 1.
    pub fn is_growing(&self) -> bool {
        self.multiplier.norm() > 1.0 + NEUTRAL.max(ERRORS * self.error)
    }
}

/// Floquet modes about a periodic motion; empty without degrees of freedom.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Floquet {
    /// Modes, slowest decay first.
    pub modes: Vec<FloquetMode>,
    /// Number of modes omitted because steps or samples of the revolution do not resolve them.
    pub coarse: usize,
    /// Number of modes omitted because the directions do not resolve them to four digits.
    pub unfound: usize,
    /// Largest magnitude of the multipliers of those modes.
    pub largest_unfound: f64,
    /// Reason why frequencies refer to the coordinates of the model instead of the fixed frame; `None` for frequencies in the fixed
    /// frame.
    pub unseen: Option<String>,
    /// Modes of the averaged model, for machines without aerodynamics whose rotor has equal blades.
    pub averaged: Option<AveragedModes>,
    /// Number of states of the motion.
    pub states: usize,
    /// Number of revolutions marched.
    pub turns: usize,
}

impl ModeShape {
    /// A mode about a periodic motion: its exponent and moving parts; it has no shape, because the shape varies over the revolution.
    pub fn of_floquet(mode: FloquetMode) -> Self {
        Self {
            frequency_hz: mode.frequency_hz,
            damping_ratio: mode.damping_ratio,
            eigenvalue_1_s: mode.exponent_1_s,
            shares: [0.0; ENERGY_SHARES],
            real: Vec::new(),
            imaginary: Vec::new(),
            coordinates: Vec::new(),
            length_m: 1.0,
            whirl: mode.parts,
            flight: None,
        }
    }
}

impl Plant {
    /// Finds a periodic motion of the model prepared by [`Turn::of`], NOTATION eqs. (L32) and (L33). The search starts from the state of
    /// an initialised plant. The plant is then at the start of the revolution.
    ///
    /// `accuracy` bounds the difference between start and end of the revolution: rotation in rad or displacement divided by the model's
    /// length, rates also divided by the shaft speed.
    ///
    /// # Errors
    /// [`PlantError::Periodic`] if no motion is found, or a joint reaches a latch or end stop within the revolution;
    /// [`PlantError::RigidLoop`]; errors of [`Plant::step`].
    pub fn periodic(&mut self, turn: &Turn, accuracy: f64) -> Result<PeriodicMotion, PlantError> {
        self.system.refuse_constraints("periodic motion")?;
        self.system.refuse_dc_motor("periodic motion")?;
        Shooting::new(self, *turn).close(accuracy)
    }

    /// Marches the revolution of a periodic motion; `seen` is called with the plant and the number of the sample, from 0 to [`SAMPLES`],
    /// the end of the revolution.
    ///
    /// # Errors
    /// Errors of [`Plant::restore`], [`Plant::step`] and `seen`.
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

    /// Modes about a periodic motion from at most `products` directions, each of which costs two revolutions. Modes that decay within a
    /// revolution are omitted; modes that steps and samples do not resolve, and modes that the directions do not resolve to four digits,
    /// are omitted and counted. Without a rotor of equal blades ([`crate::study::Study::rotor`]) the modes refer to the coordinates of the
    /// machine, and there is no averaged model.
    ///
    /// # Errors
    /// As for [`Plant::trace`].
    pub fn floquet(&mut self, turn: &Turn, motion: &PeriodicMotion, products: usize) -> Result<Floquet, PlantError> {
        self.restore(&motion.start)?;
        let speed_rad_s = turn.speed_rad_s;
        if self.system.freedoms().is_empty() {
            return Ok(Floquet::default());
        }
        let rotor = self.rotor_of(turn);
        let unseen = rotor.as_ref().err().map(ToString::to_string);
        let rotor = rotor.ok();
        let mut view = self.study().ground_view(turn.shaft, rotor.as_ref(), speed_rad_s)?;
        let averaged = match (&rotor, &self.system.machine.air) {
            (Some(_), None) => self.average(turn, motion, &mut view)?,
            _ => None,
        };
        self.restore(&motion.start)?;
        let own = self.study().second_order()?;
        let masses = own.mass.diagonal();
        let alone_rad_s =
            masses.zip_map(&own.stiffness.diagonal(), |mass, stiffness| (stiffness.max(0.0) / mass).sqrt());
        let mut beside = Beside::new(self, *turn, alone_rad_s.as_slice())?;
        let states = beside.begin.len();
        let pairs = leading(states, products, |_, direction| beside.product(direction))?;
        let Beside { paths, spoiled, shooting: Shooting { turns, .. }, .. } = beside;
        let weights = view.weights();
        let error = |pair: &RitzPair| pair.error.max(spoiled / pair.value.norm());
        let (unfound, found): (Vec<&RitzPair>, Vec<&RitzPair>) =
            pairs.iter().filter(|pair| pair.value.norm() > GONE).partition(|pair| error(pair) > ERROR);
        let highest_rad_s = speed_rad_s.abs() * (0.5 * SAMPLES as f64 - 1.0).min(turn.steps as f64 / STEPS_IN_A_PERIOD);
        let mut followed: Vec<(&RitzPair, Seen)> = Vec::new();
        for &pair in &found {
            let (mut seen, mut square): (Seen, [f64; 2]) = (Vec::new(), [0.0; 2]);
            for sample in 0..SAMPLES {
                let mut sum: [DVector<Complex<f64>>; 2] = [0, 1].map(|_| DVector::zeros(masses.len()));
                for (amount, path) in pair.amounts.iter().zip(&paths) {
                    sum.iter_mut().zip(&path[sample]).for_each(|(sum, x)| *sum += x.map(|x| amount * x));
                }
                for (square, sum) in square.iter_mut().zip(&sum) {
                    *square += sum.iter().zip(masses.iter()).map(|(x, mass)| mass * x.norm_sqr()).sum::<f64>();
                }
                seen.push(view.components(&sum[0], speed_rad_s.signum() * TAU * sample as f64 / SAMPLES as f64));
            }
            // frequency from the rates, without the samples
            if square[1] <= square[0] * highest_rad_s.powi(2) {
                followed.push((pair, seen));
            }
        }
        let coarse = found.len() - followed.len();
        let mut modes = Vec::new();
        for (pair, seen) in unmixed(followed, turn.period_s(), &weights) {
            let read = resolve(pair.value, turn.period_s(), &seen, &weights);
            let exponent_1_s = read.exponent_1_s;
            let size = exponent_1_s.norm();
            let near = |value: &&Complex<f64>| (**value - exponent_1_s).norm();
            let nearest = averaged.as_ref().and_then(|averaged| {
                let list = averaged.eigenvalues_1_s.iter();
                let nearest = list.min_by(|a, b| near(a).total_cmp(&near(b)))?;
                (near(&nearest) <= averaged.spread.max(SAME) * nearest.norm()).then_some(*nearest)
            });
            let principal = principal_1_s(pair.value, turn.period_s());
            let still = |(sample, seen): (usize, &DVector<Complex<f64>>)| {
                let part = sample as f64 / SAMPLES as f64;
                view.coordinates(seen, speed_rad_s.signum() * TAU * part)
                    * (-principal * (turn.period_s() * part)).exp()
            };
            let mut mode = FloquetMode {
                principal_1_s: principal,
                motion: seen.iter().enumerate().map(still).collect(),
                multiplier: pair.value,
                exponent_1_s,
                frequency_hz: size / TAU,
                damping_ratio: -exponent_1_s.re / size,
                ambiguous: read.is_ambiguous(),
                parts: self.study().moving_parts(&view, &read.shape),
                harmonics: read.harmonics,
                error: error(pair),
                averaged_1_s: nearest,
            };
            if mode.is_neutral() {
                mode.damping_ratio = 0.0;
            }
            modes.push(mode);
        }
        self.restore(&motion.start)?;
        let largest_unfound = unfound.iter().map(|pair| pair.value.norm()).fold(0.0, f64::max);
        Ok(Floquet { modes, coarse, unfound: unfound.len(), largest_unfound, unseen, averaged, states, turns })
    }

    /// The rotor on the shaft, if its blades are equal.
    fn rotor_of(&mut self, turn: &Turn) -> Result<Rotor, PlantError> {
        let machine = self.system.machine.clone();
        let shaft = &machine.bodies[turn.shaft].joint.name;
        self.study().rotor(machine.experiment.start_time_s, Some(shaft))
    }

    /// Modes of the equations averaged over the revolution, eq. (L36).
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

/// Samples of a motion in the fixed frame.
type Seen = Vec<DVector<Complex<f64>>>;

/// Separates modes with equal multipliers, which may be arbitrarily mixed, by their harmonics, eq. (L35).
fn unmixed<'p>(
    mut motions: Vec<(&'p RitzPair, Seen)>,
    period_s: f64,
    weights: &DVector<f64>,
) -> Vec<(&'p RitzPair, Seen)> {
    let mut list = Vec::with_capacity(motions.len());
    while let Some((first, _)) = motions.first() {
        let value = first.value;
        let (same, others): (Vec<_>, Vec<_>) =
            motions.into_iter().partition(|(pair, _)| (pair.value - value).norm() <= ALIKE * value.norm());
        motions = others;
        if same.len() == 1 {
            list.extend(same);
            continue;
        }
        let (pairs, seen): (Vec<&RitzPair>, Vec<Seen>) = same.into_iter().unzip();
        for (pair, amounts) in pairs.into_iter().zip(separate(value, period_s, &seen, weights)) {
            let mut sum = vec![DVector::zeros(weights.len()); SAMPLES];
            for (motion, amount) in seen.iter().zip(&amounts) {
                sum.iter_mut().zip(motion).for_each(|(sum, seen)| sum.axpy(*amount, seen, Complex::new(1.0, 0.0)));
            }
            list.push((pair, sum));
        }
    }
    list
}

/// Coordinates and rates at each sample of a revolution.
type Path = Vec<[DVector<f64>; 2]>;

/// Revolutions near a periodic motion.
struct Beside<'p> {
    shooting: Shooting<'p>,
    /// States at the start and at the end of the revolution.
    begin: DVector<f64>,
    end: DVector<f64>,
    /// Motions that start in the directions.
    paths: Vec<Path>,
    step: f64,
    /// Error of the products due to the nonlinearity of the revolution.
    spoiled: f64,
}

impl<'p> Beside<'p> {
    fn new(plant: &'p mut Plant, turn: Turn, alone_rad_s: &[f64]) -> Result<Self, PlantError> {
        let mut shooting = Shooting::new(plant, turn);
        shooting.stiffen(alone_rad_s);
        let begin = shooting.at_begin();
        let end = shooting.march(&begin, &mut |_, _| Ok(()))?;
        Ok(Self { shooting, begin, end, paths: Vec::new(), step: STEP, spoiled: 0.0 })
    }

    /// Product of the monodromy matrix with a direction of unit length, by a central difference with a sufficiently short step.
    fn product(&mut self, direction: &DVector<f64>) -> Result<DVector<f64>, PlantError> {
        for shortening in 0.. {
            let [above, below] = [self.step, -self.step].map(|step| self.march(&(direction * step)));
            let ((above, above_path), (below, below_path)) = (above?, below?);
            let width = 2.0 * self.step;
            let product = (&above - &below) / width;
            let curved = (above + below - &self.end * 2.0).norm() / width;
            let size = product.norm().max(SMALL);
            if curved > CURVED * size && shortening < SHORTENINGS {
                self.step *= SHORTER;
                continue;
            }
            // the error of a one-sided difference is of first order, that of a central difference of second order
            self.spoiled = self.spoiled.max(curved * curved / size);
            let difference = |(above, below): (&[DVector<f64>; 2], &[DVector<f64>; 2])| {
                [0, 1].map(|rate| (&above[rate] - &below[rate]) / width)
            };
            self.paths.push(above_path.iter().zip(&below_path).map(difference).collect());
            return Ok(product);
        }
        unreachable!("the last shortening returns")
    }

    /// Marches a revolution near the periodic one, and returns its end and motion.
    fn march(&mut self, change: &DVector<f64>) -> Result<(DVector<f64>, Path), PlantError> {
        let free = self.shooting.free.clone();
        let mut path: Path = Vec::with_capacity(SAMPLES);
        let mut seen = |sample: usize, plant: &mut Plant| {
            if sample < SAMPLES {
                let now = &plant.system.state.now;
                path.push(
                    [&now.q, &now.v].map(|list| DVector::from_iterator(free.len(), free.iter().map(|&c| list[c]))),
                );
            }
            Ok(())
        };
        let end = self.shooting.march(&(&self.begin + change), &mut seen)?;
        Ok((end, path))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{Body, Joint, Machine, Spring};
    use nalgebra::Matrix3;
    use std::sync::Arc;

    const SPEED_RAD_S: f64 = 2.0;

    /// A hub that rotates about `z`, and blades of 1 kg·m² on hinges at the shaft: axis, stiffness, damping, neutral angle.
    fn modes_of(blades: &[([f64; 3], [f64; 3])], steps: usize) -> Floquet {
        let hub = Body::rigid("hub").inertia(1.0, [0.0; 3], Matrix3::identity());
        let mut builder = Machine::builder("Rotor").body(hub, Joint::revolute("shaft", [0.0, 0.0, 1.0]));
        for (number, (axis, [stiffness_n_m_rad, damping_n_m_s_rad, rest_angle_rad])) in blades.iter().enumerate() {
            let spring = Spring {
                stiffness_n_m_rad: *stiffness_n_m_rad,
                damping_n_m_s_rad: *damping_n_m_s_rad,
                rest_angle_rad: *rest_angle_rad,
            };
            let inertia_kg_m2 = Matrix3::from_diagonal(&[0.2, 1.0, 1.0].into());
            builder = builder.body(
                Body::rigid(format!("blade{number}")).inertia(1.0, [0.0; 3], inertia_kg_m2),
                Joint::revolute(format!("hinge{number}"), *axis)
                    .on("hub")
                    .spring(spring)
                    .start_angle_rad(*rest_angle_rad),
            );
        }
        let machine = builder.build().unwrap_or_else(|refused| panic!("{refused}"));
        let (machine, turn) =
            Turn::of(&machine, Some("shaft"), Some(SPEED_RAD_S), steps).unwrap_or_else(|refused| panic!("{refused}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let motion = plant.periodic(&turn, 1e-9).unwrap_or_else(|error| panic!("{error}"));
        plant.floquet(&turn, &motion, 8).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Two blades with lead-lag springs, at 2.3 and 9.3 times the rotor speed: 144 steps per revolution resolve the first mode, as 24 steps
    /// per period are available up to 6 times the speed. The other mode is counted and omitted.
    #[test]
    fn motions_that_steps_do_not_follow_are_counted_only() {
        let lag = |ratio: f64| ([0.0, 0.0, 1.0], [(ratio * SPEED_RAD_S).powi(2), 0.02, 0.0]);
        let Floquet { modes, coarse, unfound, .. } = modes_of(&[lag(2.3), lag(9.3)], SAMPLES);
        assert_eq!((modes.len(), coarse, unfound), (1, 1, 0), "{modes:?}");
        // 63 steps per period: a fourth-order error of 1e-7
        assert!((modes[0].frequency_hz * TAU / (2.3 * SPEED_RAD_S) - 1.0).abs() < 1e-6, "{:?}", modes[0]);
    }

    /// MS-08. The motion of a mode over the revolution is in the coordinates of the model: a lead-lag blade has its own exponent relative to
    /// the hub at any speed of the shaft, so that its periodic part times the principal exponential is a single exponential function.
    #[test]
    fn motions_are_those_of_the_own_coordinates() {
        let (ratio, damping_n_m_s_rad) = (2.3, 0.02);
        let Floquet { modes, .. } =
            modes_of(&[([0.0, 0.0, 1.0], [(ratio * SPEED_RAD_S).powi(2), damping_n_m_s_rad, 0.0])], 4 * SAMPLES);
        let mode = &modes[0];
        let decay = 0.5 * damping_n_m_s_rad;
        let own = Complex::new(-decay, ((ratio * SPEED_RAD_S).powi(2) - decay * decay).sqrt());
        let period_s = TAU / SPEED_RAD_S;
        assert_eq!((mode.motion.len(), mode.motion[0].len()), (SAMPLES, 1));
        for (sample, motion) in mode.motion.iter().enumerate() {
            let time_s = period_s * sample as f64 / SAMPLES as f64;
            let found = motion[0] * (mode.principal_1_s * time_s).exp() / mode.motion[0][0];
            // either one of a complex pair may have been found
            let off = [own, own.conj()].map(|exponent| (found - (exponent * time_s).exp()).norm());
            assert!(off[0].min(off[1]) < 1e-5, "sample {sample}: {found} {off:?}");
        }
    }

    /// A damped blade that flaps about a coned equilibrium: centrifugal moments are proportional to `sin 2β`, so that the revolution is
    /// nonlinear over the difference steps of its products. With all directions Arnoldi's iteration has no error; the error of the products
    /// has the same size for all multipliers, so that the relative errors are inversely proportional to the multipliers. The lead-lag
    /// motion of a blade hinged on the shaft is linear, and has only round-off.
    #[test]
    fn curved_turns_spoil_small_multipliers_most() {
        let flaps = ([0.0, 1.0, 0.0], [2.5, 4.8, 0.6]);
        let lags = ([0.0, 0.0, 1.0], [5.2, 4.8, 0.6]);
        let spoiled = |blade: ([f64; 3], [f64; 3])| {
            let Floquet { modes, unfound, .. } = modes_of(&[blade], 4 * SAMPLES);
            assert_eq!((modes.len(), unfound), (2, 0), "{modes:?}");
            let sizes = [0, 1].map(|i| modes[i].multiplier.norm());
            assert!(sizes[1] < 0.1 * sizes[0], "{sizes:?}");
            [0, 1].map(|i| modes[i].error * sizes[i])
        };
        let [slow, fast] = spoiled(flaps);
        assert!(slow > 1e-13 && (fast / slow - 1.0).abs() < 1e-6, "{slow:e} {fast:e}");
        let straight = spoiled(lags);
        assert!(straight.iter().all(|spoiled| *spoiled < 0.1 * slow), "{straight:?} {slow:e}");
    }
}
