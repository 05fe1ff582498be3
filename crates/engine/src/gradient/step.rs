//! The linear equations of a step, eqs. (X6) and (X7).

use crate::gradient::tape::{Ending, Step};
use crate::gradient::{Entry, Gradient, GradientError, add};
use crate::multibody::kinematics::Motion;
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;

/// Remainder, as a share of the solution, at which a linear system is solved.
pub(super) const SOLVED: f64 = 3e-13;
/// Steps and weights over the step of differences by time, exact to the second degree: never before the present, which may be the first
/// instant of the inputs' stretch.
pub(super) const ONWARD: [(f64, f64); 3] = [(0.0, -1.5), (1.0, 2.0), (2.0, -0.5)];
/// Step of these differences as a share of the step of the run.
const TIME_STEP: f64 = 0.5;
/// Least step of these differences in s: steps that end at a crossing right behind a row may be as short as round-off.
const LEAST_TIME_STEP_S: f64 = 1e-6;

/// Step of differences by time in s in a step of given length.
pub(super) fn time_step_s(length_s: f64) -> f64 {
    (TIME_STEP * length_s).max(LEAST_TIME_STEP_S)
}

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

    pub fn add(&mut self, factor: f64, other: &Self) {
        add(&mut self.q, factor, &other.q);
        add(&mut self.v, factor, &other.v);
        add(&mut self.a, factor, &other.a);
    }
}

impl Gradient<'_> {
    /// Motion and wrenches of the nodes at a point.
    pub(super) fn place(&mut self, at: &Point) {
        self.system.equations.residual(at.time_s, &at.q, &at.v, &at.a, &mut self.scratch);
    }

    /// Linearises the equations at a point.
    pub(super) fn linearize(&mut self, at: &Point) {
        self.place(at);
        self.system.equations.linearize(&mut self.derivative, at);
        if let Some(sections) = &mut self.sections {
            sections.place(&self.system.equations, &at.q);
        }
        self.directions.restart();
    }

    /// Factors for `M + gC + g²K` at a linearised point. They serve the other stages of its step too: corrections run until they are round-off.
    pub(super) fn factorize(&mut self, at: &Point, gain: f64) -> Result<(), GradientError> {
        let equations = &mut self.system.equations;
        self.directions.restart_with_factors();
        let not_solved = GradientError::NotSolved { time_s: at.time_s, left: f64::INFINITY };
        equations.factorize(1.0, gain, gain * gain).map_err(|_| not_solved)
    }

    /// Solves `K δq + C δv + M δa + forcing = 0` for `δa` with `δv = δv* + g δa`, `δq = δq* + g δv`, at the linearised point. `variation`
    /// holds `δq*`, `δv*` and a first guess of `δa` at the start, the solution at the end.
    pub(super) fn solve(
        &mut self,
        at: &Point,
        gain: f64,
        forcing: Option<&[f64]>,
        variation: &mut Variation,
    ) -> Result<(), GradientError> {
        let Self { system, derivative, directions, .. } = self;
        let equations = &mut system.equations;
        let n = variation.q.len();
        let Variation { q, v, a } = variation;
        equations.clear_resting(v);
        equations.clear_resting(a);
        let others = directions.size(v).max(directions.size(q));
        let mut along_v: Vec<f64> = (0..n).map(|i| v[i] + gain * a[i]).collect();
        let mut along_q: Vec<f64> = (0..n).map(|i| q[i] + gain * along_v[i]).collect();
        let mut left = vec![0.0; n];
        equations.residual_along(derivative, Motion { q: &along_q, v: &along_v, a }, &mut left);
        if let Some(forcing) = forcing {
            add(&mut left, 1.0, forcing);
        }
        left.iter_mut().for_each(|left| *left = -*left);
        equations.clear_held(&mut left);
        equations.solve(&mut left);
        let solution = directions.solve(left, a, others, |direction, image| {
            for i in 0..n {
                along_v[i] = gain * direction[i];
                along_q[i] = gain * along_v[i];
            }
            equations.residual_along(derivative, Motion { q: &along_q, v: &along_v, a: direction }, image);
            equations.clear_held(image);
            equations.solve(image);
        });
        let solution = solution.map_err(|left| GradientError::NotSolved { time_s: at.time_s, left })?;
        a.copy_from_slice(solution);
        add(v, gain, a);
        add(q, gain, v);
        Ok(())
    }

    /// Solves `(M + gC + g²K)ᵀ w = right` at the linearised point; returns `w`, `Kᵀw` and `Cᵀw`.
    pub(super) fn solve_transposed(
        &mut self,
        at: &Point,
        gain: f64,
        right: &[f64],
    ) -> Result<[Vec<f64>; 3], GradientError> {
        let Self { system, derivative, directions, .. } = self;
        let equations = &mut system.equations;
        let n = right.len();
        let mut left = right.to_vec();
        equations.clear_held(&mut left);
        equations.solve_transposed(derivative, &mut left);
        let [mut by_q, mut by_v, mut by_a] = [0, 1, 2].map(|_| vec![0.0; n]);
        let solution = directions.solve(left, &vec![0.0; n], 0.0, |direction, image| {
            equations.residual_transposed(derivative, direction, [&mut by_q, &mut by_v, &mut by_a]);
            for i in 0..n {
                image[i] = by_a[i] + gain * (by_v[i] + gain * by_q[i]);
            }
            equations.clear_held(image);
            equations.solve_transposed(derivative, image);
        });
        let solution = solution.map_err(|left| GradientError::NotSolved { time_s: at.time_s, left })?;
        let w = solution.to_vec();
        equations.residual_transposed(derivative, &w, [&mut by_q, &mut by_v, &mut by_a]);
        Ok([w, by_q, by_v])
    }

    /// Adopts the states of the joints in a step.
    pub(super) fn adopt(&mut self, step: &Step) {
        let inputs = &self.tape.inputs;
        self.piece = step.piece;
        super::parameter::adopt(self.system, step, inputs, None);
        self.neighbours.iter_mut().for_each(|neighbours| neighbours.adopt(step, inputs));
    }

    /// Whether inputs move in time in the present step.
    pub(super) fn inputs_move(&self) -> bool {
        self.system.equations.course.moves
    }

    /// Slope of the residual by time at a point, by inputs that move in time; `None` if none does. The point has to be prepared afterwards.
    pub(super) fn time_slope(&mut self, at: &Point, length_s: f64) -> Option<Vec<f64>> {
        if !self.inputs_move() {
            return None;
        }
        let equations = &mut self.system.equations;
        let step_s = time_step_s(length_s);
        let mut slope = vec![0.0; at.q.len()];
        let mut residual = slope.clone();
        for (steps, weight) in ONWARD {
            equations.residual(at.time_s + steps * step_s, &at.q, &at.v, &at.a, &mut residual);
            add(&mut slope, weight / step_s, &residual);
        }
        Some(slope)
    }

    /// Slopes of the residual with respect to the numbers of all perturbed models at a point.
    pub(super) fn residual_slopes(&mut self, at: &Point) -> Vec<Vec<f64>> {
        let n = self.system.coordinates();
        let each = self.neighbours.iter_mut().map(|neighbours| {
            let mut slope = vec![0.0; n];
            neighbours.residual_slope(&self.system.equations, at, &mut slope);
            slope
        });
        each.collect()
    }

    /// Slopes of the residual at a linearised point in all directions by `causes`, with the shifts of the point's time; `by_time` is the
    /// slope with respect to time.
    pub(super) fn forcings(
        &mut self,
        at: &Point,
        shifts_s: &[f64],
        by_time: Option<&[f64]>,
        causes: Causes,
    ) -> Vec<Vec<f64>> {
        let mut forcings = vec![vec![0.0; at.q.len()]; shifts_s.len()];
        if causes.parameters {
            let slopes = self.residual_slopes(at);
            for ((forcing, Entry { beside, .. }), share) in
                forcings.iter_mut().zip(&self.entries).zip(self.shares(at.time_s))
            {
                add(forcing, share, &slopes[*beside]);
            }
        }
        if let Some(by_time) = by_time {
            forcings.iter_mut().zip(shifts_s).for_each(|(forcing, shift_s)| add(forcing, *shift_s, by_time));
        }
        if let Some(sections) = &mut self.sections {
            for (forcing, loads) in forcings.iter_mut().zip(causes.loads) {
                sections.add_rows(&self.system.equations, &at.q, loads, forcing);
            }
        }
        forcings
    }

    /// Variations of the step's end along the parameters, from those of its start and of its time, and, unless its length is fixed, along
    /// its length (last), eqs. (X6), (X7) and (X11). Without variations: along its length alone.
    pub(super) fn through(
        &mut self,
        step: &Step,
        starts: &[Variation],
        shifts_s: &[f64],
        causes: Causes,
    ) -> Result<Vec<Variation>, GradientError> {
        let taken = self.stages_through(step, starts, shifts_s, causes)?;
        let mut ends: Vec<Variation> = taken.into_iter().filter_map(|mut stages| stages.pop()).collect();
        let projection = self.projection(step);
        ends.iter_mut().for_each(|end| projection.apply(end));
        Ok(ends)
    }

    /// The same at all stages, from the start to the end, which is not yet projected onto constraints.
    pub(super) fn stages_through(
        &mut self,
        step: &Step,
        starts: &[Variation],
        shifts_s: &[f64],
        causes: Causes,
    ) -> Result<Vec<Vec<Variation>>, GradientError> {
        let (h, n) = (step.length_s(), self.system.coordinates());
        let gain = h * self.tableau.gamma;
        let mut taken: Vec<Vec<Variation>> = starts.iter().map(|start| vec![start.clone()]).collect();
        if step.ending != Ending::Chosen {
            taken.push(vec![Variation::zeros(n)]);
        }
        let points: Vec<&Point> = std::iter::once(&step.start).chain(step.solved()).collect();
        for stage in 1..self.tableau.stages() {
            let (at, row) = (points[stage], self.tableau.rows[stage - 1]);
            let laws = self.laws(at.time_s, step.middle_s());
            let shares = self.shares(at.time_s);
            let by_time = self.time_slope(at, h);
            self.linearize(at);
            if stage == 1 || self.directions.are_old() {
                self.factorize(at, gain)?;
            }
            let forcings = match starts.is_empty() {
                true => Vec::new(),
                false => self.forcings(at, shifts_s, by_time.as_deref(), causes),
            };
            // of the share of the step at which the stage is
            let share = (at.time_s - step.start.time_s) / h;
            let of_length_only = by_time.map(|by_time| by_time.iter().map(|slope| share * slope).collect::<Vec<f64>>());
            for (direction, before) in taken.iter_mut().enumerate() {
                let mut variation = Variation { a: vec![0.0; n], ..before[0].clone() };
                for (earlier, weight) in self.tableau.predictor(stage) {
                    add(&mut variation.a, weight, &before[earlier].a);
                }
                for (weight, stage) in row.iter().zip(&*before) {
                    add(&mut variation.q, h * weight, &stage.v);
                    add(&mut variation.v, h * weight, &stage.a);
                }
                let of_length = direction == starts.len();
                if of_length {
                    for (weight, point) in row.iter().chain([&self.tableau.gamma]).zip(&points) {
                        add(&mut variation.q, *weight, &point.v);
                        add(&mut variation.v, *weight, &point.a);
                    }
                }
                for law in &laws {
                    match of_length {
                        true => law.set(None, share, gain, &mut variation),
                        false => {
                            let number = self.number_of(direction, &shares, causes);
                            law.set(number, shifts_s[direction], gain, &mut variation);
                        }
                    }
                }
                let forcing = if of_length { of_length_only.as_ref() } else { forcings.get(direction) };
                self.solve(at, gain, forcing.map(Vec::as_slice), &mut variation)?;
                before.push(variation);
            }
        }
        Ok(taken)
    }
}
