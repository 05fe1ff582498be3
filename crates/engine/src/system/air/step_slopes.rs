//! An aerodynamic step of strips or of a rotor as a map, and its derivatives, NOTATION eqs. (X12) and (X37): from the aerodynamic memory at
//! the start and the poses of the sections at the end to the memory at the end and the effective loads in the step, eq. (Q1).
//!
//! A memory is a flat vector. Of strips: a sample of each section (position, rotation, filtered and mean velocities of eq. (Q4)), the lag
//! states of each strip, and the circulatory load of each section in its frame. Of a rotor, which uses velocities at the instant: the
//! states of its sections, their mean induction, and the loads.

use crate::aero::flow::{Gust, GustShape};
use crate::aero::rotor::slopes::{NoRotorSlopes, RotorStep};
use crate::aero::strip::slopes::{LOADS, MOTION, ROWS, STATE, StripStep};
use crate::aero::{AirModel, AirOptions, AirState};
use crate::load::Wrench;
use crate::machine::Coupling;
use crate::math::so3::{hat, rotation_vector};
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use crate::system::air::start::{flow, refusal};
use crate::system::air::pieces::{self, AirPieces};
use crate::system::air::{AirCoupling, AirHistory, ENTRIES, Sample, VELOCITY_WEIGHTS, gaps};
use crate::system::{PlantError, System};
use nalgebra::{Matrix3, SVector, Vector3};

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

/// Derivatives of an aerodynamic step.
pub(crate) struct AirStepSlopes {
    step_s: f64,
    /// Per section: derivatives of the mean angular velocity with respect to its rotations at both ends of the step.
    turns: Vec<[Matrix3<f64>; 2]>,
    /// Per section, at the end: attitude, circulatory and impulsive load in the root frame.
    ends: Vec<(Matrix3<f64>, [Wrench; 2])>,
    model: ModelSlopes,
    /// Pieces on which the functions of the model lie.
    pieces: Option<AirPieces>,
}

/// Derivatives of the aerodynamic model in a step.
enum ModelSlopes {
    /// Per strip: its sections and its derivatives.
    Strips(Vec<([usize; 2], StripStep)>),
    /// Of a rotor.
    Rotor(Box<RotorStep>),
}

impl AirStepSlopes {
    /// Number of entries of a memory.
    pub fn memory_entries(&self) -> usize {
        self.first_load() + ENTRIES * self.ends.len()
    }

    fn first_load(&self) -> usize {
        match &self.model {
            ModelSlopes::Strips(strips) => SAMPLE * self.ends.len() + STATE * strips.len(),
            ModelSlopes::Rotor(rotor) => rotor.state_entries(),
        }
    }

    /// Number of entries of the pose of a section: displacement and rotation; for rotors, which use them, also velocity and angular velocity.
    fn pose_entries(&self) -> usize {
        match &self.model {
            ModelSlopes::Strips(_) => ENTRIES,
            ModelSlopes::Rotor(_) => MOTION,
        }
    }

    /// Pieces on which the functions of the model lie.
    pub fn pieces(&self) -> Option<&AirPieces> {
        self.pieces.as_ref()
    }

    /// Variation of the memory at the end, followed by that of the effective loads, due to variations of the memory at the start and of the
    /// poses at the end (displacement and rotation of each section, for rotors also their velocities; root frame).
    pub fn forward(&self, memory: &[f64], poses: &[f64]) -> Vec<f64> {
        let sections = self.ends.len();
        let first_load = self.first_load();
        let mut out = vec![0.0; self.memory_entries() + ENTRIES * sections];
        let mut forces = vec![[0.0; LOADS]; sections];
        match &self.model {
            ModelSlopes::Strips(strips) => self.strips_forward(strips, [memory, poses], &mut out, &mut forces),
            ModelSlopes::Rotor(rotor) => {
                let (after, loads) = rotor.forward(&memory[..first_load], poses);
                out[..first_load].copy_from_slice(&after);
                for (own, loads) in forces.iter_mut().zip(loads.chunks_exact(ENTRIES)) {
                    own[..ENTRIES].copy_from_slice(loads);
                }
            }
        }
        for (section, ((rotation, loads), changes)) in self.ends.iter().zip(&forces).enumerate() {
            let [_, turn] = thirds(&poses[self.pose_entries() * section..]);
            let [circulatory, impulsive] = [0, 1].map(|part| {
                let [force, moment] = thirds(&changes[ENTRIES * part..]);
                let load = &loads[part];
                let local = |change: Vector3<f64>, load: &Vector3<f64>| rotation.tr_mul(&(change - turn.cross(load)));
                [local(force, &load.force_n), local(moment, &load.moment_n_m)]
            });
            let before: [Vector3<f64>; 2] = thirds(&memory[first_load + ENTRIES * section..]);
            write(&mut out[first_load + ENTRIES * section..], &circulatory);
            let acting = [0, 1].map(|i| (before[i] + circulatory[i]) * 0.5 + impulsive[i]);
            write(&mut out[first_load + ENTRIES * (sections + section)..], &acting);
        }
        out
    }

    /// Part of the strips in [`Self::forward`].
    fn strips_forward(
        &self,
        strips: &[([usize; 2], StripStep)],
        [memory, poses]: [&[f64]; 2],
        out: &mut [f64],
        forces: &mut [[f64; LOADS]],
    ) {
        let [own, earlier, last] = VELOCITY_WEIGHTS;
        for (section, turns) in self.turns.iter().enumerate() {
            let [r0, f0, w0, o0, mw0, mo0] = thirds(&memory[SAMPLE * section..]);
            let [r1, f1] = thirds(&poses[ENTRIES * section..]);
            let mw1 = (r1 - r0) / self.step_s;
            let mo1 = turns[1] * f1 - turns[0] * f0;
            let w1 = mw1 * own + mw0 * earlier + w0 * last;
            let o1 = mo1 * own + mo0 * earlier + o0 * last;
            write(&mut out[SAMPLE * section..], &[r1, f1, w1, o1, mw1, mo1]);
        }
        let states = SAMPLE * self.ends.len();
        for (strip, (ends, slopes)) in strips.iter().enumerate() {
            let own = states + STATE * strip;
            let mut along = SVector::<f64, { 2 * MOTION + STATE }>::zeros();
            for (end, section) in ends.iter().enumerate() {
                let motion = &out[SAMPLE * section..SAMPLE * section + MOTION];
                along.as_mut_slice()[MOTION * end..MOTION * (end + 1)].copy_from_slice(motion);
            }
            along.as_mut_slice()[2 * MOTION..].copy_from_slice(&memory[own..own + STATE]);
            let rows = slopes * along;
            for (end, section) in ends.iter().enumerate() {
                let own = &rows.as_slice()[LOADS * end..LOADS * (end + 1)];
                forces[*section].iter_mut().zip(own).for_each(|(sum, row)| *sum += row);
            }
            out[own..own + STATE].copy_from_slice(&rows.as_slice()[2 * LOADS..]);
        }
    }

    /// The transpose of [`Self::forward`]: multipliers of the memory at the start and of the poses, from those of the memory at the end and
    /// of the loads.
    pub fn reverse(&self, on: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let sections = self.ends.len();
        let first_load = self.first_load();
        let mut memory = vec![0.0; self.memory_entries()];
        let mut forces = vec![[0.0; LOADS]; sections];
        // on the rotations of the sections, which turn the loads
        let mut turned = Vec::with_capacity(sections);
        for (section, (rotation, loads)) in self.ends.iter().enumerate() {
            let acting: [Vector3<f64>; 2] = thirds(&on[first_load + ENTRIES * (sections + section)..]);
            let after: [Vector3<f64>; 2] = thirds(&on[first_load + ENTRIES * section..]);
            let half = acting.map(|acting| acting * 0.5);
            write(&mut memory[first_load + ENTRIES * section..], &half);
            let mut turn = Vector3::zeros();
            for (part, on) in [[after[0] + half[0], after[1] + half[1]], acting].into_iter().enumerate() {
                let [force, moment] = on.map(|on| rotation * on);
                write(&mut forces[section][ENTRIES * part..], &[force, moment]);
                turn -= loads[part].force_n.cross(&force) + loads[part].moment_n_m.cross(&moment);
            }
            turned.push(turn);
        }
        let poses = match &self.model {
            ModelSlopes::Strips(strips) => self.strips_reverse(strips, on, (&forces, &turned), &mut memory),
            ModelSlopes::Rotor(rotor) => {
                let loads: Vec<f64> = forces.iter().flat_map(|own| own[..ENTRIES].iter().copied()).collect();
                let (state, mut motions) = rotor.reverse(&on[..first_load], &loads);
                memory[..first_load].copy_from_slice(&state);
                for (motion, turn) in motions.chunks_exact_mut(MOTION).zip(&turned) {
                    motion[3..ENTRIES].iter_mut().zip(turn).for_each(|(sum, turn)| *sum += turn);
                }
                motions
            }
        };
        (memory, poses)
    }

    /// Part of the strips in [`Self::reverse`]: multipliers of the poses.
    fn strips_reverse(
        &self,
        strips: &[([usize; 2], StripStep)],
        on: &[f64],
        (forces, turned): (&[[f64; LOADS]], &[Vector3<f64>]),
        memory: &mut [f64],
    ) -> Vec<f64> {
        let [own, earlier, last] = VELOCITY_WEIGHTS;
        let mut poses = vec![0.0; ENTRIES * self.ends.len()];
        let mut motions: Vec<[Vector3<f64>; 4]> = Vec::with_capacity(self.ends.len());
        for (section, turned) in turned.iter().enumerate() {
            let [r, f, w, o] = thirds(&on[SAMPLE * section..]);
            motions.push([r, f + turned, w, o]);
        }
        let states = SAMPLE * self.ends.len();
        for (strip, (ends, slopes)) in strips.iter().enumerate() {
            let own = states + STATE * strip;
            let mut rows = SVector::<f64, ROWS>::zeros();
            for (end, section) in ends.iter().enumerate() {
                rows.as_mut_slice()[LOADS * end..LOADS * (end + 1)].copy_from_slice(&forces[*section]);
            }
            rows.as_mut_slice()[2 * LOADS..].copy_from_slice(&on[own..own + STATE]);
            let along = slopes.tr_mul(&rows);
            for (end, section) in ends.iter().enumerate() {
                let parts: [Vector3<f64>; 4] = thirds(&along.as_slice()[MOTION * end..]);
                motions[*section].iter_mut().zip(parts).for_each(|(sum, part)| *sum += part);
            }
            memory[own..own + STATE].copy_from_slice(&along.as_slice()[2 * MOTION..]);
        }
        for (section, (turns, [r1, f1, w1, o1])) in self.turns.iter().zip(motions).enumerate() {
            let [_, _, _, _, mw1, mo1] = thirds(&on[SAMPLE * section..]);
            let (mw1, mo1) = (mw1 + w1 * own, mo1 + o1 * own);
            let by_displacement = mw1 / self.step_s;
            write(&mut poses[ENTRIES * section..], &[r1 + by_displacement, f1 + turns[1].tr_mul(&mo1)]);
            let before = [-by_displacement, -turns[0].tr_mul(&mo1), w1 * last, o1 * last, w1 * earlier, o1 * earlier];
            write(&mut memory[SAMPLE * section..], &before);
        }
        poses
    }
}

impl System {
    /// First aerodynamic feature whose steps have no derivatives, and its name; smooth strips have them, and rotors in smooth wind.
    pub(crate) fn air_without_slopes(&self) -> Option<(&'static str, &str)> {
        let air = self.machine.air.as_ref()?;
        let strips = match air.only() {
            Some(AirOptions::Strips(strips)) => Some(strips),
            Some(AirOptions::Rotor(rotor)) => {
                let features = &rotor.features;
                if features.tower.is_some() {
                    return Some(("rotors whose tower disturbs the wind", "tower"));
                }
                None
            }
            Some(AirOptions::Lattice(_)) => return Some(("the vortex lattice", "aerodynamics")),
            Some(AirOptions::SlenderBody(_)) => return Some(("slender-body aerodynamics", "aerodynamics")),
            None => return Some(("several aerodynamic models", "aerodynamics")),
        };
        if strips.is_some_and(|strips| strips.tip_loss.is_some()) {
            return Some(("the lifting line of strips", "aerodynamics.tip_loss"));
        }
        if air.coupling == Coupling::Staggered {
            return Some(("the staggered coupling of aerodynamics and structure", "aerodynamics.coupling"));
        }
        let smooth = |gust: &&Gust| matches!(gust.shape, GustShape::OneMinusCosine { .. });
        if let Some(gust) = air.gusts.iter().find(|gust| !smooth(gust)) {
            return Some(("gusts with jumps or kinks, all but one_minus_cosine", &gust.name));
        }
        None
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
        let begins = before.begin.iter().zip(air.model.instants());
        let samples = air.motions.iter_mut().zip(begins).map(|(motion, (begin, &instant))| {
            let end = if instant { Sample::steady(motion) } else { begin.next(motion, step_s, &before.gain) };
            *motion = end.motion;
            end
        });
        Ok(samples.collect())
    }

    /// Derivatives of an aerodynamic step from `before` to the motion `at` its end.
    pub(crate) fn air_step_slopes(&mut self, before: &AirHistory, at: &Point) -> Result<AirStepSlopes, NoSlopes> {
        let samples = self.meet_end_of_air_step(before, at).map_err(NoSlopes::Step)?;
        let Self { air, state, .. } = self;
        let no_air = || NoSlopes::Step(refusal(at.time_s, "neither strips nor a rotor"));
        let Some(air) = air else { return Err(no_air()) };
        let AirCoupling { model, settings, motions, loads, .. } = &mut **air;
        let flow = flow(settings, state, before.loads.end_s);
        let step_s = settings.step_s;
        let mut after = before.after.clone();
        if let Some(model) = model.only_mut() {
            pieces::record(model);
        }
        let solved = model.solve(&before.before, motions, &flow, step_s, &mut after, loads);
        let met = model.only_mut().and_then(pieces::recorded);
        solved.map_err(|error| NoSlopes::Step(gaps::failure(&self.machine, settings, before.loads.end_s, error)))?;
        let model = match (model.only_mut(), before.before.only(), &met) {
            (Some(AirModel::Strips(strips)), Some(AirState::Strips(from)), Some(AirPieces::Strips(met))) => {
                if let Some(strip) = met.iter().position(|list| list.at_kink) {
                    return Err(NoSlopes::Kink(settings.surfaces[strips.surface_of(strip)].body));
                }
                let slopes = strips.step_slopes(from, motions, &flow, step_s, met);
                let slopes = slopes.map_err(|still| NoSlopes::Still(settings.surfaces[still.surface].body))?;
                ModelSlopes::Strips(strips.strip_sections().zip(slopes).collect())
            }
            (Some(AirModel::Rotor(rotor)), Some(AirState::Rotor(from)), Some(AirPieces::Rotor(met))) => {
                let slopes = rotor.step_slopes(from, motions, &flow, step_s, met).map_err(|refused| match refused {
                    NoRotorSlopes::Kink { blade } => NoSlopes::Kink(settings.surfaces[blade].body),
                    NoRotorSlopes::Node { blade } => NoSlopes::Node(settings.surfaces[blade].body),
                    NoRotorSlopes::End { blade } => NoSlopes::End(settings.surfaces[blade].body),
                    NoRotorSlopes::NoWind => NoSlopes::NoWind,
                })?;
                ModelSlopes::Rotor(Box::new(slopes))
            }
            (
                Some(AirModel::Lattice(_) | AirModel::Strips(_) | AirModel::Rotor(_) | AirModel::SlenderBody(_)) | None,
                _,
                _,
            ) => return Err(no_air()),
        };
        let turns = samples.iter().zip(&before.begin).map(|(end, begin)| {
            let left =
                inverse_left_tangent(&rotation_vector(&(end.motion.rotation * begin.motion.rotation.transpose())));
            // apart from its sign, the derivative with respect to the rotation at the start is that of the opposite rotation vector
            [left.transpose() / step_s, left / step_s]
        });
        let ends = motions.iter().zip(loads.circulatory.iter().zip(&loads.impulsive));
        Ok(AirStepSlopes {
            step_s,
            turns: turns.collect(),
            ends: ends.map(|(motion, (a, b))| (motion.rotation, [*a, *b])).collect(),
            model,
            pieces: met,
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
        let mut values = memory(&after, reference);
        let mut acting = after.loads.to.clone();
        after.loads.write(&mut acting);
        values.extend(entries(&acting));
        Ok(values)
    }

    /// Aerodynamic memory at the current time; rotations relative to `reference`. Empty without aerodynamics.
    pub(crate) fn air_memory(&self, reference: &[Matrix3<f64>]) -> Vec<f64> {
        self.state.air.as_ref().map_or_else(Vec::new, |history| memory(history, reference))
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

/// Memory at the end of a step, as a flat vector.
fn memory(history: &AirHistory, reference: &[Matrix3<f64>]) -> Vec<f64> {
    let mut values = Vec::new();
    if let Some(AirState::Rotor(state)) = history.after.only() {
        values.extend(state.clone().numbers().map(|number| *number));
        values.extend(entries(&history.loads.to));
        return values;
    }
    for (Sample { motion, mean_m_s, mean_rad_s }, reference) in history.end.iter().zip(reference) {
        values.extend(&motion.position_m);
        values.extend(&rotation_vector(&(motion.rotation * reference.transpose())));
        for vector in [&motion.velocity_m_s, &motion.spin_rad_s, mean_m_s, mean_rad_s] {
            values.extend(vector);
        }
    }
    if let Some(AirState::Strips(state)) = history.after.only() {
        values.extend(state.strips.iter().flat_map(|strip| strip.clone().numbers().map(|number| *number)));
    }
    values.extend(entries(&history.loads.to));
    values
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
