//! The linear equations of a step, eqs. (X6) and (X7).

use crate::gradient::factors::{Factors, LANES, Side};
use crate::gradient::tape::{Ending, Step};
use crate::gradient::variation::{Causes, Variation};
use crate::gradient::{Entry, Gradient, GradientError, add, add_all};
use crate::multibody::kinematics::Motion;
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;

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

impl Gradient<'_> {
    /// Motion and wrenches of the nodes at a point.
    pub(super) fn place(&mut self, at: &Point) {
        self.system.equations.residual(at.time_s, &at.q, &at.v, &at.a, &mut self.scratch);
    }

    /// Linearises the equations at a point.
    pub(super) fn linearize(&mut self, at: &Point) {
        self.system.equations.place(at, &mut self.scratch);
        self.system.equations.linearize(&mut self.derivative, at);
        if let Some(sections) = &mut self.sections {
            sections.place(&self.system.equations, &at.q);
        }
        self.directions.restart();
    }

    /// Factors for `M + gC + g²K` at a linearised point. They serve the other stages of its step too: corrections run until they are round-off.
    pub(super) fn factorize(&mut self, at: &Point, gain: f64) -> Result<(), GradientError> {
        let equations = &mut self.system.equations;
        self.factors = Factors::Symmetric;
        self.directions.restart_with_factors();
        let not_solved = GradientError::NotSolved { time_s: at.time_s, left: f64::INFINITY };
        equations.factorize(1.0, gain, gain * gain).map_err(|_| not_solved)
    }

    /// The same for a stage of a step, `first` of those that are treated: with all terms of the tree where the model allows, else with those
    /// of Newton's method, which serve the other stages as long as they pay.
    pub(super) fn factorize_stage(&mut self, at: &Point, gain: f64, first: bool) -> Result<(), GradientError> {
        let Self { system, derivative, directions, has_exact, .. } = self;
        let equations = &system.equations;
        if *has_exact && equations.factorize_exact(derivative, gain).is_some() {
            self.factors = Factors::Exact;
            directions.restart_with_factors_of_stage(first);
            return Ok(());
        }
        if first || self.factors == Factors::Exact || directions.are_old() {
            self.factorize(at, gain)?;
        }
        Ok(())
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
        let Self { system, derivative, factors, .. } = self;
        let equations = &mut system.equations;
        let n = variation.q.len();
        let Variation { q, v, a } = variation;
        equations.clear_resting(v);
        equations.clear_resting(a);
        let along_v: Vec<f64> = (0..n).map(|i| v[i] + gain * a[i]).collect();
        let along_q: Vec<f64> = (0..n).map(|i| q[i] + gain * along_v[i]).collect();
        let mut left = vec![0.0; n];
        equations.residual_along(derivative, Motion { q: &along_q, v: &along_v, a }, &mut left);
        if let Some(forcing) = forcing {
            add(&mut left, 1.0, forcing);
        }
        left.iter_mut().for_each(|left| *left = -*left);
        equations.clear_held(&mut left);
        factors.solve(equations, derivative, &mut left);
        self.correct(at, gain, left, variation)
    }

    /// Adds the rest of the solution to a first guess, whose correction by the factors is `left`.
    fn correct(
        &mut self,
        at: &Point,
        gain: f64,
        left: Vec<f64>,
        variation: &mut Variation,
    ) -> Result<(), GradientError> {
        let Self { system, derivative, directions, factors, .. } = self;
        let equations = &mut system.equations;
        let Variation { q, v, a } = variation;
        let [of_v, of_q] = directions.sizes([v, q]);
        let others = of_v.max(of_q);
        let [mut along_q, mut along_v] = [const { Vec::new() }; 2];
        let solution = directions.solve(left, a, others, |direction, image| {
            along_v.clear();
            along_v.extend(direction.iter().map(|change| gain * change));
            along_q.clear();
            along_q.extend(along_v.iter().map(|change| gain * change));
            equations.residual_along(derivative, Motion { q: &along_q, v: &along_v, a: direction }, image);
            equations.clear_held(image);
            factors.solve(equations, derivative, image);
        });
        let solution = solution.map_err(|left| GradientError::NotSolved { time_s: at.time_s, left })?;
        a.copy_from_slice(solution);
        add(v, gain, a);
        add(q, gain, v);
        Ok(())
    }

    /// [`Self::solve`] for several variations, side by side where factors and point allow it.
    fn solve_all(
        &mut self,
        at: &Point,
        gain: f64,
        forcings: &[Option<&[f64]>],
        variations: &mut [Variation],
    ) -> Result<(), GradientError> {
        let side_by_side = self.factors == Factors::Exact && self.derivative.has_lanes();
        for (variations, forcings) in variations.chunks_mut(LANES).zip(forcings.chunks(LANES)) {
            if !side_by_side || variations.len() == 1 {
                for (variation, forcing) in variations.iter_mut().zip(forcings) {
                    self.solve(at, gain, *forcing, variation)?;
                }
                continue;
            }
            self.solve_lanes(gain, forcings, variations);
            for (lane, variation) in variations.iter_mut().enumerate() {
                let left = self.lanes.left.iter().map(|row| row[lane]).collect();
                self.correct(at, gain, left, variation)?;
            }
        }
        Ok(())
    }

    /// Corrections of up to [`LANES`] first guesses.
    fn solve_lanes(&mut self, gain: f64, forcings: &[Option<&[f64]>], variations: &mut [Variation]) {
        let Self { system, derivative, lanes, .. } = self;
        let Side { along: [along_q, along_v, along_a], left, product, sweep } = lanes;
        let equations = &system.equations;
        for rows in [&mut *along_q, along_v, along_a, left] {
            rows.fill([0.0; LANES]);
        }
        for (lane, variation) in variations.iter_mut().enumerate() {
            equations.clear_resting(&mut variation.v);
            equations.clear_resting(&mut variation.a);
            let rows = along_q.iter_mut().zip(&mut *along_v).zip(&mut *along_a);
            let changes = variation.q.iter().zip(&variation.v).zip(&variation.a);
            for (((along_q, along_v), along_a), ((q, v), a)) in rows.zip(changes) {
                let rate = v + gain * a;
                (along_a[lane], along_v[lane], along_q[lane]) = (*a, rate, q + gain * rate);
            }
        }
        equations.residual_along_lanes(derivative, product, [&*along_q, &*along_v, &*along_a], left);
        for (lane, forcing) in forcings.iter().enumerate() {
            let Some(forcing) = forcing else { continue };
            left.iter_mut().zip(*forcing).for_each(|(left, forcing)| left[lane] += forcing);
        }
        left.iter_mut().flatten().for_each(|left| *left = -*left);
        equations.held().for_each(|held| left[held] = [0.0; LANES]);
        derivative.solve_lanes(&equations.model, sweep, left);
    }

    /// Solves `(M + gC + g²K)ᵀ w = right` at the linearised point; returns `w`, `Kᵀw` and `Cᵀw`.
    pub(super) fn solve_transposed(
        &mut self,
        at: &Point,
        gain: f64,
        right: &[f64],
    ) -> Result<[Vec<f64>; 3], GradientError> {
        let Self { system, derivative, directions, factors, .. } = self;
        let equations = &mut system.equations;
        let n = right.len();
        let mut left = right.to_vec();
        equations.clear_held(&mut left);
        factors.solve_transposed(equations, derivative, &mut left);
        let [mut by_q, mut by_v, mut by_a] = [0, 1, 2].map(|_| vec![0.0; n]);
        let solution = directions.solve(left, &vec![0.0; n], 0.0, |direction, image| {
            equations.residual_transposed(derivative, direction, [&mut by_q, &mut by_v, &mut by_a]);
            for i in 0..n {
                image[i] = by_a[i] + gain * (by_v[i] + gain * by_q[i]);
            }
            equations.clear_held(image);
            factors.solve_transposed(equations, derivative, image);
        });
        let solution = solution.map_err(|left| GradientError::NotSolved { time_s: at.time_s, left })?;
        let w = solution.to_vec();
        equations.residual_transposed(derivative, &w, [&mut by_q, &mut by_v, &mut by_a]);
        Ok([w, by_q, by_v])
    }

    /// Adopts the states of the joints in a step.
    pub(super) fn adopt(&mut self, step: &Step) {
        let inputs = &self.tape.inputs;
        (self.piece, self.middle_s) = (step.piece, step.middle_s());
        super::parameter::adopt(self.system, step, inputs);
        self.neighbours.iter_mut().for_each(|neighbours| neighbours.adopt(step, inputs));
    }

    /// Whether inputs or forces change with time itself in the present step.
    pub(super) fn inputs_move(&self) -> bool {
        let equations = &self.system.equations;
        equations.course.moves || equations.forces.move_at(self.middle_s)
    }

    /// Keeps the smooth pieces of all forces at a point of the present step, in the perturbed machines too, eq. (X34), until [`Self::let_go`].
    pub(super) fn hold(&mut self, at: &Point) {
        let Self { system, neighbours, middle_s, .. } = self;
        let forces = &mut system.equations.forces;
        forces.hold([at.time_s, *middle_s], &at.q, &at.v);
        neighbours.iter_mut().for_each(|beside| beside.hold_as(forces));
    }

    /// Ends [`Self::hold`]; the perturbed machines are held again before their next use.
    pub(super) fn let_go(&mut self) {
        self.system.equations.forces.let_go();
    }

    /// Slope of the residual by time at a point, by inputs that move in time; `None` if none does. The point has to be prepared afterwards.
    pub(super) fn time_slope(&mut self, at: &Point, length_s: f64) -> Option<Vec<f64>> {
        if !self.inputs_move() {
            return None;
        }
        self.hold(at);
        let equations = &mut self.system.equations;
        let step_s = time_step_s(length_s);
        let mut slope = vec![0.0; at.q.len()];
        let mut residual = slope.clone();
        for (steps, weight) in ONWARD {
            equations.residual(at.time_s + steps * step_s, &at.q, &at.v, &at.a, &mut residual);
            add(&mut slope, weight / step_s, &residual);
        }
        self.let_go();
        Some(slope)
    }

    /// Computes the slopes of the residual with respect to the numbers of all perturbed models at a point.
    pub(super) fn find_residual_slopes(&mut self, at: &Point) {
        self.hold(at);
        let Self { system, neighbours, derivative, .. } = self;
        let own = (&system.equations, &*derivative);
        neighbours.iter_mut().for_each(|neighbours| neighbours.find_residual_slope(own, at));
        self.let_go();
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
            self.find_residual_slopes(at);
            for ((forcing, Entry { beside, .. }), share) in
                forcings.iter_mut().zip(&self.entries).zip(self.shares(at.time_s))
            {
                add(forcing, share, self.neighbours[*beside].slope_of_residual());
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
        for (direction, end) in ends.iter_mut().enumerate() {
            projection.apply(end, (causes.parameters && direction < starts.len()).then_some(direction));
        }
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
            let predictor = self.tableau.predictor(stage);
            let laws = self.laws(at.time_s, step.middle_s());
            let shares = self.shares(at.time_s);
            let by_time = self.time_slope(at, h);
            self.linearize(at);
            self.factorize_stage(at, gain, stage == 1)?;
            let forcings = match starts.is_empty() {
                true => Vec::new(),
                false => self.forcings(at, shifts_s, by_time.as_deref(), causes),
            };
            // of the share of the step at which the stage is
            let share = (at.time_s - step.start.time_s) / h;
            let of_length_only = by_time.map(|by_time| by_time.iter().map(|slope| share * slope).collect::<Vec<f64>>());
            let (mut own, mut variations) = (Vec::with_capacity(taken.len()), Vec::with_capacity(taken.len()));
            for (direction, before) in taken.iter().enumerate() {
                let Variation { q, v, .. } = &before[0];
                let mut variation = Variation { q: q.clone(), v: v.clone(), a: vec![0.0; n] };
                add_all(&mut variation.a, predictor.iter().map(|&(earlier, weight)| (weight, &before[earlier].a[..])));
                let earlier = || row.iter().zip(before).map(|(weight, stage)| (h * weight, stage));
                add_all(&mut variation.q, earlier().map(|(weight, stage)| (weight, &stage.v[..])));
                add_all(&mut variation.v, earlier().map(|(weight, stage)| (weight, &stage.a[..])));
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
                own.push(forcing.map(Vec::as_slice));
                variations.push(variation);
            }
            self.solve_all(at, gain, &own, &mut variations)?;
            taken.iter_mut().zip(variations).for_each(|(before, variation)| before.push(variation));
        }
        Ok(taken)
    }
}
