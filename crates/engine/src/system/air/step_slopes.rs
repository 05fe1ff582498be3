//! An aerodynamic step as a map, and its derivatives, NOTATION eqs. (X12) and (X37): from the aerodynamic memory at the start and the poses of
//! the sections at the end to the memory at the end and the effective loads in the step, eq. (Q1).
//!
//! A memory is a flat vector: a sample of each section whose model uses mean velocities (position, rotation, filtered and mean velocities of
//! eq. (Q4)); the states of the models (lags of strips; states of the sections of rotors and their mean induction; momenta of slender
//! bodies); and the circulatory load of each section in its frame. With the staggered coupling, eq. (X39), it ends with the circulatory
//! load at the start of the step and the impulsive load, from which the prediction of the next step follows, in the same frame.

use crate::aero::flow::{Gust, GustShape};
use crate::aero::strip::slopes::{LOADS, MOTION};
use crate::aero::{AirOptions, AirPart, AirState};
use crate::load::Wrench;
use crate::machine::Coupling;
use crate::math::so3::{hat, rotation_vector};
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use crate::system::air::model_slopes::{ModelSlopes, NoModelSlopes};
use crate::system::air::pieces::AirPieces;
use crate::system::air::start::{flow, refusal};
use crate::system::air::{AirCoupling, AirHistory, ENTRIES, Sample, StepLoads, VELOCITY_WEIGHTS, gaps};
use crate::system::{PlantError, System};
use nalgebra::{Matrix3, Vector3};

/// Number of entries of a section's sample.
const SAMPLE: usize = 18;

/// Reason why a step has no derivatives.
pub(crate) enum NoSlopes {
    /// A strip of this body has no relative flow velocity.
    Still(usize),
    /// A section of this body is exactly at a row of its polar.
    Kink(usize),
    /// A section of this body is exactly at a point of the grid of the wind.
    Node(usize),
    /// The momentum balance of a section of this body ends beside its state.
    End(usize),
    /// Any small wind across the shaft would skew the wake of the rotor.
    NoWind,
    /// The step itself has no solution.
    Step(PlantError),
}

/// Loads under which the trial march of the staggered coupling takes place, eq. (X39).
#[derive(Clone, Copy)]
enum Prediction {
    /// Those at the start of the run.
    Kept,
    /// Continued from the last step.
    Continued,
}

/// Derivatives of an aerodynamic step.
pub(crate) struct AirStepSlopes {
    step_s: f64,
    /// With the staggered coupling: the rule of its trial march.
    prediction: Option<Prediction>,
    /// Per section: derivatives of the mean angular velocity with respect to its rotations at both ends of the step; `None` for sections
    /// whose model uses velocities at the instant.
    turns: Vec<Option<[Matrix3<f64>; 2]>>,
    /// Per section, at the end: attitude, circulatory and impulsive load in the root frame.
    ends: Vec<(Matrix3<f64>, [Wrench; 2])>,
    /// Per model: its sections, first entry and number of entries of its state in a memory, and its derivatives.
    models: Vec<(Vec<usize>, [usize; 2], ModelSlopes)>,
    /// Place of the first load in a memory.
    first_load: usize,
    /// Number of entries of the pose of a section: displacement and rotation; if a model uses them, also velocity and angular velocity.
    pose_entries: usize,
    /// Pieces on which the functions of the models lie.
    pieces: AirPieces,
}

impl AirStepSlopes {
    /// Number of entries of a memory.
    pub fn memory_entries(&self) -> usize {
        let loads = if self.prediction.is_some() { 3 } else { 1 };
        self.first_load + loads * ENTRIES * self.ends.len()
    }

    /// Places of the circulatory load of a section in a memory, of that at the start of the step, and of its impulsive load.
    fn load_places(&self, section: usize) -> [usize; 3] {
        [0, 1, 2].map(|part| self.first_load + ENTRIES * (part * self.ends.len() + section))
    }

    /// Variation of the loads in the trial march of the staggered coupling due to one of the memory at its start.
    pub fn predict(&self, memory: &[f64]) -> Vec<f64> {
        let of = |section: usize| {
            let [last, earlier, impulsive] = self.load_places(section);
            let [by_last, by_earlier] = self.prediction_weights();
            (0..ENTRIES)
                .map(move |i| by_last * memory[last + i] + by_earlier * memory[earlier + i] + memory[impulsive + i])
        };
        (0..self.ends.len()).flat_map(of).collect()
    }

    /// The transpose of [`Self::predict`]: adds the multipliers of the memory.
    pub fn predict_back(&self, loads: &[f64], memory: &mut [f64]) {
        let [by_last, by_earlier] = self.prediction_weights();
        for (section, on) in loads.chunks_exact(ENTRIES).enumerate() {
            for (place, weight) in self.load_places(section).into_iter().zip([by_last, by_earlier, 1.0]) {
                memory[place..place + ENTRIES].iter_mut().zip(on).for_each(|(sum, on)| *sum += weight * on);
            }
        }
    }

    /// Shares of the circulatory loads at the start of the step and of the step before in the loads of the trial march: the mean of the load
    /// and of its continuation.
    fn prediction_weights(&self) -> [f64; 2] {
        match self.prediction {
            None => [0.0; 2],
            Some(Prediction::Kept) => [1.0, 0.0],
            Some(Prediction::Continued) => [1.5, -0.5],
        }
    }

    /// Places of the loads and coefficients of the rotors in a memory.
    pub fn places_of_rotors(&self) -> impl Iterator<Item = usize> {
        self.models.iter().filter_map(|(_, [first, _], slopes)| match slopes {
            ModelSlopes::Rotor(rotor) => Some(first + rotor.place_of_loads()),
            ModelSlopes::Strips(_) | ModelSlopes::Line(_) | ModelSlopes::SlenderBody(_) => None,
        })
    }

    /// Share of the step that has passed at a time before its end.
    pub fn share_at(&self, before_end_s: f64) -> f64 {
        1.0 - before_end_s / self.step_s
    }

    /// Pieces on which the functions of the models lie.
    pub fn pieces(&self) -> &AirPieces {
        &self.pieces
    }

    /// Sections with samples, and the places of these in a memory.
    fn samples(&self) -> impl Iterator<Item = (usize, usize, &[Matrix3<f64>; 2])> {
        let turns = self.turns.iter().enumerate();
        let with = turns.filter_map(|(section, turns)| Some((section, turns.as_ref()?)));
        with.enumerate().map(|(place, (section, turns))| (section, SAMPLE * place, turns))
    }

    /// Variation of the memory at the end, followed by that of the effective loads, due to variations of the memory at the start and of the
    /// poses at the end: displacement and rotation of each section, if a model uses them also velocities; root frame.
    pub fn forward(&self, memory: &[f64], poses: &[f64]) -> Vec<f64> {
        let sections = self.ends.len();
        let mut out = vec![0.0; self.memory_entries() + ENTRIES * sections];
        let mut motions = vec![0.0; MOTION * sections];
        for (motion, pose) in motions.chunks_exact_mut(MOTION).zip(poses.chunks_exact(self.pose_entries)) {
            motion[..self.pose_entries].copy_from_slice(pose);
        }
        let [own, earlier, last] = VELOCITY_WEIGHTS;
        for (section, place, turns) in self.samples() {
            let [r0, f0, w0, o0, mw0, mo0] = thirds(&memory[place..]);
            let [r1, f1] = thirds(&motions[MOTION * section..]);
            let mw1 = (r1 - r0) / self.step_s;
            let mo1 = turns[1] * f1 - turns[0] * f0;
            let w1 = mw1 * own + mw0 * earlier + w0 * last;
            let o1 = mo1 * own + mo0 * earlier + o0 * last;
            write(&mut out[place..], &[r1, f1, w1, o1, mw1, mo1]);
            write(&mut motions[MOTION * section..], &[r1, f1, w1, o1]);
        }
        let mut forces = vec![[0.0; LOADS]; sections];
        for (own, [first, count], slopes) in &self.models {
            let gathered: Vec<f64> =
                own.iter().flat_map(|section| &motions[MOTION * section..MOTION * (section + 1)]).copied().collect();
            let (after, loads) = slopes.forward(&memory[*first..first + count], &gathered);
            out[*first..first + count].copy_from_slice(&after);
            own.iter().zip(loads).for_each(|(section, load)| forces[*section] = load);
        }
        for (section, ((rotation, loads), changes)) in self.ends.iter().zip(&forces).enumerate() {
            let [_, turn] = thirds(&poses[self.pose_entries * section..]);
            let [circulatory, impulsive] = [0, 1].map(|part| {
                let [force, moment] = thirds(&changes[ENTRIES * part..]);
                let load = &loads[part];
                let local = |change: Vector3<f64>, load: &Vector3<f64>| rotation.tr_mul(&(change - turn.cross(load)));
                [local(force, &load.force_n), local(moment, &load.moment_n_m)]
            });
            let [last, earlier, of_impulse] = self.load_places(section);
            let before: [Vector3<f64>; 2] = thirds(&memory[last..]);
            write(&mut out[last..], &circulatory);
            if self.prediction.is_some() {
                write(&mut out[earlier..], &before);
                write(&mut out[of_impulse..], &impulsive);
            }
            let acting = [0, 1].map(|i| (before[i] + circulatory[i]) * 0.5 + impulsive[i]);
            write(&mut out[self.memory_entries() + ENTRIES * section..], &acting);
        }
        out
    }

    /// The transpose of [`Self::forward`]: multipliers of the memory at the start and of the poses, from those of the memory at the end and
    /// of the loads.
    pub fn reverse(&self, on: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let sections = self.ends.len();
        let mut memory = vec![0.0; self.memory_entries()];
        let mut forces = vec![[0.0; LOADS]; sections];
        let mut motions = vec![0.0; MOTION * sections];
        for (section, (rotation, loads)) in self.ends.iter().enumerate() {
            let [last, earlier, of_impulse] = self.load_places(section);
            let acting: [Vector3<f64>; 2] = thirds(&on[self.memory_entries() + ENTRIES * section..]);
            let after: [Vector3<f64>; 2] = thirds(&on[last..]);
            let half = acting.map(|acting| acting * 0.5);
            let (mut before, mut impulsive) = (half, acting);
            if self.prediction.is_some() {
                let [kept, own]: [[Vector3<f64>; 2]; 2] = [earlier, of_impulse].map(|place| thirds(&on[place..]));
                before = [0, 1].map(|i| half[i] + kept[i]);
                impulsive = [0, 1].map(|i| acting[i] + own[i]);
            }
            write(&mut memory[last..], &before);
            // the loads turn with their section
            let mut turn = Vector3::zeros();
            for (part, on) in [[after[0] + half[0], after[1] + half[1]], impulsive].into_iter().enumerate() {
                let [force, moment] = on.map(|on| rotation * on);
                write(&mut forces[section][ENTRIES * part..], &[force, moment]);
                turn -= loads[part].force_n.cross(&force) + loads[part].moment_n_m.cross(&moment);
            }
            write(&mut motions[MOTION * section + 3..], &[turn]);
        }
        for (own, [first, count], slopes) in &self.models {
            let gathered: Vec<[f64; LOADS]> = own.iter().map(|section| forces[*section]).collect();
            let (state, back) = slopes.reverse(&on[*first..first + count], &gathered);
            memory[*first..first + count].copy_from_slice(&state);
            for (section, back) in own.iter().zip(back.chunks_exact(MOTION)) {
                motions[MOTION * section..].iter_mut().zip(back).for_each(|(sum, back)| *sum += back);
            }
        }
        let [own, earlier, last] = VELOCITY_WEIGHTS;
        for (section, place, turns) in self.samples() {
            let [r, f, w, o, mw, mo] = thirds(&on[place..]);
            let [r1, f1, w1, o1]: [Vector3<f64>; 4] = thirds(&motions[MOTION * section..]);
            let (r1, f1, w1, o1) = (r + r1, f + f1, w + w1, o + o1);
            let (mw1, mo1) = (mw + w1 * own, mo + o1 * own);
            let by_displacement = mw1 / self.step_s;
            let pose = [r1 + by_displacement, f1 + turns[1].tr_mul(&mo1), Vector3::zeros(), Vector3::zeros()];
            write(&mut motions[MOTION * section..], &pose);
            let before = [-by_displacement, -turns[0].tr_mul(&mo1), w1 * last, o1 * last, w1 * earlier, o1 * earlier];
            write(&mut memory[place..], &before);
        }
        let poses = motions.chunks_exact(MOTION).flat_map(|motion| &motion[..self.pose_entries]).copied().collect();
        (memory, poses)
    }
}

impl System {
    /// First aerodynamic feature whose steps have no derivatives, and its name; strips, rotors without a tower and slender bodies have them.
    pub(crate) fn air_without_slopes(&self) -> Option<(&'static str, &str)> {
        let air = self.machine.air.as_ref()?;
        let of_part = |part: &AirPart| match &part.options {
            AirOptions::Rotor(rotor) => {
                rotor.features.tower.is_some().then_some(("rotors whose tower disturbs the wind", "tower"))
            }
            AirOptions::Lattice(_) => Some(("the vortex lattice", "aerodynamics")),
            AirOptions::Strips(_) | AirOptions::SlenderBody(_) => None,
        };
        if let Some(found) = air.parts.iter().find_map(of_part) {
            return Some(found);
        }
        let smooth = |gust: &&Gust| matches!(gust.shape, GustShape::OneMinusCosine { .. });
        let gust = air.gusts.iter().find(|gust| !smooth(gust))?;
        Some(("gusts with jumps or kinks, all but one_minus_cosine", &gust.name))
    }

    /// Whether the loads of the air depend on velocities at the instant.
    pub(crate) fn air_uses_rates(&self) -> bool {
        self.air.as_ref().is_some_and(|air| air.model.instants().contains(&true))
    }

    /// Sets the motions of the sections at the end of an aerodynamic step from `before`, by eq. (Q4), or at the instant; returns their samples.
    pub(super) fn meet_end_of_air_step(&mut self, before: &AirHistory, at: &Point) -> Result<Vec<Sample>, PlantError> {
        let Self { equations, scratch, air, state, .. } = self;
        equations.residual(at.time_s, &at.q, &at.v, &at.a, &mut scratch[0]);
        let Some(air) = air else { return Ok(Vec::new()) };
        air.observe(equations, at);
        air.deflect(state, before.loads.end_s)?;
        let step_s = air.settings.step_s;
        let StepLoads { begin_s, end_s, .. } = before.loads;
        let gain = before.gain.after(end_s - begin_s, state.applied_rates.wind_m_s());
        let begins = before.begin.iter().zip(air.model.instants());
        let samples = air.motions.iter_mut().zip(begins).map(|(motion, (begin, &instant))| {
            let end = if instant { Sample::steady(motion) } else { begin.next(motion, step_s, &gain) };
            *motion = end.motion;
            end
        });
        Ok(samples.collect())
    }

    /// Derivatives of an aerodynamic step from `before` to the motion `at` its end.
    pub(crate) fn air_step_slopes(&mut self, before: &AirHistory, at: &Point) -> Result<AirStepSlopes, NoSlopes> {
        let samples = self.meet_end_of_air_step(before, at).map_err(NoSlopes::Step)?;
        let with_rates = self.air_uses_rates();
        let Self { air, state, machine, .. } = self;
        let no_air = || NoSlopes::Step(refusal(at.time_s, "a model without derivatives"));
        let Some(air) = air else { return Err(no_air()) };
        let AirCoupling { model, settings, motions, loads, .. } = &mut **air;
        let flow = flow(settings, state, before.loads.end_s);
        let step_s = settings.step_s;
        let mut after = before.after.clone();
        AirPieces::record(model);
        let solved = model.solve(&before.before, motions, &flow, step_s, &mut after, loads);
        let pieces = AirPieces::recorded(model);
        solved.map_err(|error| NoSlopes::Step(gaps::failure(machine, settings, before.loads.end_s, error)))?;
        let turns: Vec<_> = samples
            .iter()
            .zip(&before.begin)
            .zip(model.instants())
            .map(|((end, begin), &instant)| {
                let turn = rotation_vector(&(end.motion.rotation * begin.motion.rotation.transpose()));
                let left = inverse_left_tangent(&turn);
                // apart from its sign, the derivative with respect to the rotation at the start is that of the opposite rotation vector
                (!instant).then_some([left.transpose() / step_s, left / step_s])
            })
            .collect();
        let mut place = SAMPLE * turns.iter().flatten().count();
        let mut models = Vec::new();
        for ((own, from), held) in model.each_mut().zip(&before.before.0).zip(&pieces.0) {
            let (model, sections, motions, surfaces) = own;
            let slopes = ModelSlopes::of((model, held), from, motions, (&flow, step_s)).map_err(|refused| {
                let body = |surface: usize| settings.surfaces[surfaces[surface]].body;
                match refused {
                    NoModelSlopes::Still(surface) => NoSlopes::Still(body(surface)),
                    NoModelSlopes::Kink(surface) => NoSlopes::Kink(body(surface)),
                    NoModelSlopes::Node(surface) => NoSlopes::Node(body(surface)),
                    NoModelSlopes::End(surface) => NoSlopes::End(body(surface)),
                    NoModelSlopes::NoWind => NoSlopes::NoWind,
                    NoModelSlopes::Model => no_air(),
                }
            })?;
            let count = numbers(from).len();
            models.push((sections.to_vec(), [place, count], slopes));
            place += count;
        }
        let ends = motions.iter().zip(loads.circulatory.iter().zip(&loads.impulsive));
        let is_first = before.steps <= 1;
        let rule = if is_first { Prediction::Kept } else { Prediction::Continued };
        let prediction = (settings.coupling == Coupling::Staggered).then_some(rule);
        Ok(AirStepSlopes {
            step_s,
            prediction,
            turns,
            ends: ends.map(|(motion, (a, b))| (motion.rotation, [*a, *b])).collect(),
            models,
            first_load: place,
            pose_entries: if with_rates { MOTION } else { ENTRIES },
            pieces,
        })
    }

    /// Aerodynamic state after an aerodynamic step from `before` to the motion `at` its end; its loads are the effective loads in the step.
    /// `None` without aerodynamics.
    pub(crate) fn air_step_after(&mut self, before: &AirHistory, at: &Point) -> Result<Option<AirHistory>, PlantError> {
        let samples = self.meet_end_of_air_step(before, at)?;
        let Self { air: Some(air), state, machine, .. } = self else { return Ok(None) };
        let AirCoupling { model, settings, motions, loads, .. } = &mut **air;
        let flow = flow(settings, state, before.loads.end_s);
        let mut after = before.clone();
        model
            .solve(&before.before, motions, &flow, settings.step_s, &mut after.after, loads)
            .map_err(|error| gaps::failure(machine, settings, before.loads.end_s, error))?;
        after.end.copy_from_slice(&samples);
        let parts = [(&mut after.loads.to, &loads.circulatory), (&mut after.loads.impulsive, &loads.impulsive)];
        for (own, found) in parts {
            for ((own, load), motion) in own.iter_mut().zip(found).zip(&*motions) {
                own.force_n = motion.rotation.tr_mul(&load.force_n);
                own.moment_n_m = motion.rotation.tr_mul(&load.moment_n_m);
            }
        }
        Ok(Some(after))
    }

    /// Aerodynamic memory after an aerodynamic step, followed by the effective loads; rotations relative to `reference`.
    pub(crate) fn air_step_values(
        &mut self,
        before: &AirHistory,
        at: &Point,
        reference: &[Matrix3<f64>],
    ) -> Result<Vec<f64>, PlantError> {
        let Some(after) = self.air_step_after(before, at)? else { return Ok(Vec::new()) };
        let mut values = self.memory(&after, reference);
        let mut acting = after.loads.to.clone();
        after.loads.write(&mut acting);
        values.extend(entries(&acting));
        Ok(values)
    }

    /// Aerodynamic memory at the current time; rotations relative to `reference`. Empty without aerodynamics.
    pub(crate) fn air_memory(&self, reference: &[Matrix3<f64>]) -> Vec<f64> {
        self.state.air.as_ref().map_or_else(Vec::new, |history| self.memory(history, reference))
    }

    /// Memory at the end of a step, as a flat vector: samples of the sections whose models use mean velocities, states of the models, loads.
    fn memory(&self, history: &AirHistory, reference: &[Matrix3<f64>]) -> Vec<f64> {
        let Some(air) = &self.air else { return Vec::new() };
        let mut values = Vec::new();
        let ends = history.end.iter().zip(reference).zip(air.model.instants());
        for ((Sample { motion, mean_m_s, mean_rad_s }, reference), _) in ends.filter(|(_, instant)| !**instant) {
            values.extend(&motion.position_m);
            values.extend(&rotation_vector(&(motion.rotation * reference.transpose())));
            for vector in [&motion.velocity_m_s, &motion.spin_rad_s, mean_m_s, mean_rad_s] {
                values.extend(vector);
            }
        }
        values.extend(history.after.0.iter().flat_map(numbers));
        values.extend(entries(&history.loads.to));
        if air.settings.coupling == Coupling::Staggered {
            values.extend(entries(&history.loads.from).chain(entries(&history.loads.impulsive)));
        }
        values
    }

    /// Attitudes of the sections at a point.
    pub(crate) fn section_attitudes(&mut self, at: &Point) -> Vec<Matrix3<f64>> {
        let Self { equations, scratch, air, .. } = self;
        equations.residual(at.time_s, &at.q, &at.v, &at.a, &mut scratch[0]);
        let Some(air) = air else { return Vec::new() };
        air.observe(equations, at);
        air.motions.iter().map(|motion| motion.rotation).collect()
    }
}

/// Numbers of a state on which later loads depend.
fn numbers(state: &AirState) -> Vec<f64> {
    match state {
        AirState::Strips(state) => {
            state.strips.iter().flat_map(|strip| strip.clone().numbers().map(|number| *number)).collect()
        }
        AirState::Rotor(state) => state.clone().numbers().map(|number| *number).collect(),
        AirState::SlenderBody(state) => state.numbers().collect(),
        // lattices have no derivatives
        AirState::Lattice(_) => Vec::new(),
    }
}

/// Entries of the loads in flat order.
fn entries(loads: &[Wrench]) -> impl Iterator<Item = f64> {
    loads.iter().flat_map(|load| load.force_n.iter().chain(&load.moment_n_m).copied())
}

/// `N` consecutive vectors from the start of a slice.
fn thirds<const N: usize>(values: &[f64]) -> [Vector3<f64>; N] {
    std::array::from_fn(|i| Vector3::from_column_slice(&values[3 * i..3 * i + 3]))
}

fn write(values: &mut [f64], vectors: &[Vector3<f64>]) {
    for (place, vector) in values.chunks_exact_mut(3).zip(vectors) {
        place.copy_from_slice(vector.as_slice());
    }
}

/// Derivative of a rotation vector with respect to a rotation applied on its left: `I − Θ̂/2 + (1/θ² − (1 + cos θ)/(2θ sin θ)) Θ̂²`.
fn inverse_left_tangent(turn: &Vector3<f64>) -> Matrix3<f64> {
    let (angle, hat) = (turn.norm(), hat(turn));
    // series below the limit: the next term is less than 1e-16
    let share = if angle < 1e-2 {
        let square = angle * angle;
        1.0 / 12.0 + square * (1.0 / 720.0 + square / 30_240.0)
    } else {
        1.0 / (angle * angle) - (1.0 + angle.cos()) / (2.0 * angle * angle.sin())
    };
    Matrix3::identity() - hat * 0.5 + hat * hat * share
}
