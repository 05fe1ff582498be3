//! Impulses that stop joints, those of rigid latches and locks: the rates jump at one configuration, eqs. (X17), (X18) and (X21).

use crate::gradient::impulse::{Impulses, Jump};
use crate::gradient::sums::Sums;
use crate::gradient::variation::{Causes, Front, Variation};
use crate::gradient::{Gradient, GradientError, add, dot};
use crate::multibody::kinematics::Motion;
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use crate::system::brake::JUMP_1_S;

/// Maximum number of corrections by the momenta that are left: masses of loops, a million times those of the machine, multiply round-off of a
/// solution. They end where they no longer become smaller.
const REFINEMENTS: usize = 20;

/// Whether a correction is smaller than the one before it, whose size is `before`, and not zero.
fn is_smaller(correction: &[f64], before: &mut f64) -> bool {
    let size = correction.iter().fold(0.0f64, |size, entry| size.max(entry.abs()));
    let is = size < *before && size > 0.0;
    *before = size;
    is
}

impl Gradient<'_> {
    /// The jump of the rates at the start of a step, whose states of the joints are adopted; `None` if no joint is stopped there.
    pub(super) fn jump(&mut self, index: usize) -> Result<Option<Jump>, GradientError> {
        let step = &self.steps[index];
        let before = index.checked_sub(1).map(|before| &self.steps[before]).or(self.step_before);
        let Some(before) = before else { return Ok(None) };
        let joints = self.system.equations.forces.joints();
        let stops = joints.iter().zip(&before.joints).filter(|(joint, memory)| joint.held && !joint.is_held_in(memory));
        let stopped: Vec<usize> = stops.map(|(joint, _)| joint.coordinate).collect();
        if stopped.is_empty() {
            return Ok(None);
        }
        let mut still = before.end.clone();
        still.v.fill(0.0);
        still.a.fill(0.0);
        let mut at = still.clone();
        add(&mut at.a, JUMP_1_S, &step.start.v);
        add(&mut at.a, -JUMP_1_S, &before.end.v);
        for joint in joints.iter().filter(|joint| joint.held && !stopped.contains(&joint.coordinate)) {
            at.a[joint.coordinate] = 0.0;
        }
        let mut jump = Jump { at, still, stopped };
        self.find_multipliers(&mut jump)?;
        Ok(Some(jump))
    }

    /// Impulses of the constraints in a jump, which the run does not keep, as multipliers of its accelerations.
    fn find_multipliers(&mut self, jump: &mut Jump) -> Result<(), GradientError> {
        let tree = self.system.equations.model.tree_coordinates();
        if tree == self.system.coordinates() {
            return Ok(());
        }
        self.system.join_loops();
        let found = self.add_multipliers(jump, tree);
        self.system.part_loops();
        found
    }

    fn add_multipliers(&mut self, jump: &mut Jump, tree: usize) -> Result<(), GradientError> {
        jump.at.a[tree..].fill(0.0);
        self.place(&jump.still);
        let still = self.scratch.clone();
        let mut size = f64::INFINITY;
        for correction in 0..REFINEMENTS {
            self.place(&jump.at);
            if correction == 0 {
                self.factorize(&jump.at, 0.0)?;
            }
            let mut left: Vec<f64> = self.scratch.iter().zip(&still).map(|(at, still)| at - still).collect();
            let equations = &mut self.system.equations;
            equations.clear_held(&mut left);
            equations.solve(&mut left);
            if !is_smaller(&left[tree..], &mut size) {
                break;
            }
            add(&mut jump.at.a[tree..], -1.0, &left[tree..]);
        }
        Ok(())
    }

    /// Variations behind a jump from those before it, and those of its impulses.
    pub(super) fn jump_forward(
        &mut self,
        jump: &Jump,
        front: &mut Front,
        causes: Causes,
    ) -> Result<Impulses, GradientError> {
        let slopes = if causes.parameters { self.momentum_slopes(jump) } else { Vec::new() };
        self.system.join_loops();
        let outcome = self.jumped(jump, front, (&slopes, causes));
        self.system.part_loops();
        outcome
    }

    fn jumped(
        &mut self,
        jump: &Jump,
        front: &mut Front,
        (slopes, causes): (&[Vec<f64>], Causes),
    ) -> Result<Impulses, GradientError> {
        let mut impulses = Impulses { stopped: jump.stopped.clone(), variations: Vec::new() };
        let shares = self.shares(jump.at.time_s);
        let n = self.system.coordinates();
        let zeros = vec![0.0; n];
        let along = |own: &mut Self, q: &[f64], a: &[f64]| {
            let mut rows = vec![0.0; n];
            own.system.equations.rows_along(&mut own.derivative, Motion { q, v: &zeros, a }, &mut rows);
            rows
        };
        self.linearize(&jump.still);
        let without: Vec<Vec<f64>> =
            front.variations.iter().map(|variation| along(self, &variation.q, &zeros)).collect();
        self.linearize(&jump.at);
        self.factorize(&jump.at, 0.0)?;
        for (direction, (variation, without)) in front.variations.iter_mut().zip(&without).enumerate() {
            let slope = self.number_of(direction, &shares, causes);
            // momenta along the variation and a change of the jump; masses of loops act on the sum of both alone
            let left = |own: &mut Self, change: &[f64]| {
                let a: Vec<f64> = change.iter().map(|change| JUMP_1_S * change).collect();
                let mut left = along(own, &variation.q, &a);
                add(&mut left, -1.0, without);
                left.iter_mut().for_each(|left| *left /= -JUMP_1_S);
                if let Some((beside, share)) = slope {
                    add(&mut left, -share, &slopes[beside]);
                }
                left
            };
            let mut change = zeros.clone();
            for c in &jump.stopped {
                change[*c] = -variation.v[*c];
            }
            let first = left(self, &change);
            self.solve_masses(&jump.at, first, &variation.v, &mut change)?;
            let mut size = f64::INFINITY;
            for _ in 0..REFINEMENTS {
                let mut left = left(self, &change);
                self.system.equations.clear_held(&mut left);
                self.system.equations.solve(&mut left);
                if !is_smaller(&left, &mut size) {
                    break;
                }
                add(&mut change, 1.0, &left);
            }
            let rows = left(self, &change);
            impulses.variations.push(jump.stopped.iter().map(|c| -rows[*c]).collect());
            let tree = self.system.equations.model.tree_coordinates();
            add(&mut variation.v[..tree], 1.0, &change[..tree]);
        }
        Ok(impulses)
    }

    /// Adds the solution of `M x = left` for the free coordinates at the linearised point to `change`; `size` has the size of other terms.
    fn solve_masses(
        &mut self,
        at: &Point,
        mut left: Vec<f64>,
        size: &[f64],
        change: &mut [f64],
    ) -> Result<(), GradientError> {
        let Self { system, derivative, directions, .. } = self;
        let equations = &mut system.equations;
        let zeros = vec![0.0; left.len()];
        equations.clear_held(&mut left);
        equations.solve(&mut left);
        let [others] = directions.sizes([size]);
        let solution = directions.solve(left, &zeros, others, |direction, image| {
            equations.residual_along(derivative, Motion { q: &zeros, v: &zeros, a: direction }, image);
            equations.solve(image);
        });
        add(change, 1.0, solution.map_err(|left| GradientError::NotSolved { time_s: at.time_s, left })?);
        Ok(())
    }

    /// Multipliers before a jump from those behind it; `impulse`: the coordinate of the joint whose impulse is the result.
    pub(super) fn jump_back(
        &mut self,
        jump: &Jump,
        on: &mut Variation,
        impulse: Option<usize>,
        sums: &mut Sums,
    ) -> Result<(), GradientError> {
        self.system.join_loops();
        let outcome = self.jumped_back(jump, on, impulse);
        self.system.part_loops();
        let w = outcome?;
        if let Some(gradient) = &mut sums.gradient {
            let slopes = self.momentum_slopes(jump);
            let by_neighbours: Vec<f64> = slopes.iter().map(|slope| dot(slope, &w)).collect();
            add(gradient, -1.0, &self.by_parameters(jump.at.time_s, &by_neighbours));
        }
        Ok(())
    }

    fn jumped_back(
        &mut self,
        jump: &Jump,
        on: &mut Variation,
        impulse: Option<usize>,
    ) -> Result<Vec<f64>, GradientError> {
        let zeros = vec![0.0; on.v.len()];
        let [mut by_q, mut by_v, mut by_a] = [zeros.clone(), zeros.clone(), zeros];
        self.linearize(&jump.at);
        self.factorize(&jump.at, 0.0)?;
        let mut right = on.v.clone();
        let mut of_impulse = vec![0.0; right.len()];
        if let Some(c) = impulse {
            of_impulse[c] = -1.0;
            let equations = &self.system.equations;
            equations.residual_transposed(&mut self.derivative, &of_impulse, [&mut by_q, &mut by_v, &mut by_a]);
            add(&mut right, -1.0, &by_a);
        }
        let [mut w, _, _] = self.solve_transposed(&jump.at, 0.0, &right)?;
        add(&mut w, 1.0, &of_impulse);
        // the sum of the products, not the product with the sum, whose round-off masses of loops multiply
        let mut correction = w.clone();
        let [mut sum_q, mut sum_a] = [0, 1].map(|_| vec![0.0; on.v.len()]);
        let mut size = f64::INFINITY;
        for _ in 0..REFINEMENTS {
            let equations = &mut self.system.equations;
            equations.residual_transposed(&mut self.derivative, &correction, [&mut by_q, &mut by_v, &mut by_a]);
            add(&mut sum_q, 1.0, &by_q);
            add(&mut sum_a, 1.0, &by_a);
            correction = on.v.iter().zip(&sum_a).map(|(own, found)| own - found).collect();
            equations.clear_held(&mut correction);
            equations.solve_transposed(&self.derivative, &mut correction);
            if !is_smaller(&correction, &mut size) {
                break;
            }
            add(&mut w, 1.0, &correction);
        }
        add(&mut on.q, -1.0 / JUMP_1_S, &sum_q);
        self.linearize(&jump.still);
        let equations = &self.system.equations;
        equations.residual_transposed(&mut self.derivative, &w, [&mut by_q, &mut by_v, &mut by_a]);
        add(&mut on.q, 1.0 / JUMP_1_S, &by_q);
        for c in &jump.stopped {
            on.v[*c] = sum_a[*c];
        }
        Ok(w)
    }

    /// Slopes of `M Δv`, with the rows of the joints that are stopped, with respect to the numbers of all perturbed models.
    fn momentum_slopes(&mut self, jump: &Jump) -> Vec<Vec<f64>> {
        let n = self.system.coordinates();
        let each = self.neighbours.iter_mut().map(|neighbours| {
            let mut slope = vec![0.0; n];
            neighbours.momentum_slope(jump, &mut slope);
            slope
        });
        each.collect()
    }
}
