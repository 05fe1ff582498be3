//! Multipliers of a result, from the end of a run back to its start, eqs. (X10) and (X11).

use crate::gradient::account::EventSide;
use crate::gradient::integrand::Mean;
use crate::gradient::mean::Seeds;
use crate::gradient::outputs::{Part, Seed};
use crate::gradient::parameter::Neighbours;
use crate::gradient::rotor::MemoryShares;
use crate::gradient::sums::{OnEnd, Sums};
use crate::gradient::tape::{Ending, Step};
use crate::gradient::variation::{Causes, Variation, product};
use crate::gradient::{Gradient, GradientError, RunResult, add, dot};
use crate::solve::point::Point;
use std::ops::Range;

impl Gradient<'_> {
    /// Derivatives of a result with respect to all parameters.
    pub fn adjoint(&mut self, result: RunResult) -> Result<Vec<f64>, GradientError> {
        let seed = self.seed(result)?;
        let Seed { step: last, part, state, by_shift, by_loads, by_parameters } = seed;
        let mean = Mean::of(result, self.tape, self.system);
        let mut sums = Sums { gradient: Some(by_parameters), loads: Vec::new(), mean };
        let tape = self.tape;
        let spans = tape.spans();
        let holds = spans.partition_point(|span| span.end <= last);
        let (mut multipliers, mut memory) = ((state, by_shift), Vec::new());
        for (index, span) in spans.iter().enumerate().take(holds + 1).rev() {
            sums.loads = vec![0.0; self.load_entries()];
            let mut within = None;
            if index == holds {
                add(&mut sums.loads, 1.0, &by_loads);
                multipliers = self.back_from((span.start..last + 1, part), multipliers, &mut sums)?;
                within = Some(multipliers.0.clone());
            }
            let Some(air) = self.air_step(index, span)? else {
                if within.is_none() {
                    multipliers = self.back_march(span.clone(), multipliers, &mut sums)?;
                }
                continue;
            };
            let motion = match within {
                Some(_) => Variation::zeros(self.system.coordinates()),
                None => multipliers.0,
            };
            let shares = self.memory_shares(&result, (span, &air));
            memory.resize(air.memory_entries(), 0.0);
            if let Some(MemoryShares { place, shares: [_, after] }) = shares {
                memory[place] += after;
            }
            // within it the mean has been passed
            let mean = sums.mean.take_if(|_| within.is_some());
            let mut before = self.air_back((span, &air), OnEnd { motion, memory }, &mut sums)?;
            if let Some(MemoryShares { place, shares: [at_start, _] }) = shares {
                before.memory[place] += at_start;
            }
            if let Some(within) = within {
                before.motion.add(1.0, &within);
                sums.mean = mean;
            }
            // the start of an aerodynamic step is a given time
            (multipliers, memory) = ((before.motion, 0.0), before.memory);
        }
        let mut gradient = sums.gradient.unwrap_or_default();
        let start_s = tape.steps.first().map_or(0.0, |step| step.start.time_s);
        let motion = &multipliers.0;
        let of_start = |beside: &Neighbours| {
            dot(&motion.q, &beside.start[0]) + dot(&motion.v, &beside.start[1]) + dot(&memory, &beside.start_memory)
        };
        let by_neighbours: Vec<f64> = self.neighbours.iter().map(of_start).collect();
        add(&mut gradient, 1.0, &self.by_parameters(start_s, &by_neighbours));
        Ok(gradient)
    }

    /// Multipliers of the start of some steps, and of its time, from those behind a part of the last one.
    fn back_from(
        &mut self,
        (steps, part): (Range<usize>, Part),
        mut multipliers: (Variation, f64),
        sums: &mut Sums,
    ) -> Result<(Variation, f64), GradientError> {
        let (marched, last) = (self.steps, steps.end - 1);
        for index in steps.rev() {
            let step = &marched[index];
            self.adopt(step);
            let over = match part {
                Part::Start | Part::Jump(_) if index == last => None,
                Part::Branch(branch) if index == last => Some(branch),
                Part::Start | Part::Jump(_) | Part::Branch(_) | Part::Whole => Some(step),
            };
            if let Some(over) = over {
                multipliers = self.back_over(over, multipliers.0, multipliers.1, sums)?;
            }
            let before = index.checked_sub(1).filter(|_| step.renewed);
            let account = sums.mean.and_then(|mean| mean.account()).zip(before);
            let mut loses = false;
            if let Some((account, _)) = account {
                loses = self.check_jump(index)?;
                let (on, shift) = &mut multipliers;
                let side = EventSide { step, at: &step.start, sign: 1.0, loses };
                self.add_energy_seed(side, account, (on, shift), sums.gradient.as_mut());
            }
            if step.renewed {
                self.adopt(step);
                let (on, shift) = &mut multipliers;
                let laws = self.laws(step.start.time_s, step.start.time_s);
                let by_time = self.time_slope(&step.start, step.length_s());
                self.linearize(&step.start);
                self.factorize(&step.start, 0.0)?;
                let [w, by_q, by_v] = self.solve_transposed(&step.start, 0.0, &on.a)?;
                add(&mut on.q, -1.0, &by_q);
                add(&mut on.v, -1.0, &by_v);
                if !laws.is_empty() {
                    add(&mut on.a, -1.0, &self.momentum(&w));
                    let at = (&laws[..], step.start.time_s);
                    *shift += self.through_laws(at, [&on.q, &on.v, &on.a], sums.gradient.as_mut());
                    laws.iter().for_each(|law| on.q[law.coordinate] = 0.0);
                }
                on.a.fill(0.0);
                self.system.equations.clear_held(&mut on.v);
                *shift -= by_time.map_or(0.0, |by_time| dot(&by_time, &w));
                self.subtract_forcings(&step.start, &w, sums);
                if let Some(jump) = self.jump(index)? {
                    let impulse = match part {
                        Part::Jump(coordinate) if index == last => Some(coordinate),
                        Part::Jump(_) | Part::Start | Part::Branch(_) | Part::Whole => None,
                    };
                    self.jump_back(&jump, &mut multipliers.0, impulse, sums)?;
                }
            }
            if let Some((account, before)) = account {
                let earlier = &marched[before];
                let (on, shift) = &mut multipliers;
                let side = EventSide { step: earlier, at: &earlier.end, sign: -1.0, loses };
                self.add_energy_seed(side, account, (on, shift), sums.gradient.as_mut());
                // the air of the step comes next
                self.adopt(step);
            }
        }
        Ok(multipliers)
    }

    /// Multipliers of the start of some whole steps, and of its time, from those of their end.
    pub(super) fn back_march(
        &mut self,
        steps: Range<usize>,
        multipliers: (Variation, f64),
        sums: &mut Sums,
    ) -> Result<(Variation, f64), GradientError> {
        self.back_from((steps, Part::Whole), multipliers, sums)
    }

    /// Multipliers of a step's start, and of its time, from those of its end.
    fn back_over(
        &mut self,
        step: &Step,
        mut multipliers: Variation,
        mut shift: f64,
        sums: &mut Sums,
    ) -> Result<(Variation, f64), GradientError> {
        self.projection(step).pull(&mut multipliers, sums.gradient.as_mut());
        let seeds = self.mean_seeds(step, sums);
        let mut along_length = 0.0;
        let mut column = Variation::zeros(0);
        if step.ending != Ending::Chosen {
            let mut columns = self.stages_through(step, &[], &[], Causes::NONE)?.pop().unwrap_or_default();
            along_length = seeds.along(&columns);
            column = columns.pop().unwrap_or(column);
            along_length += product(&multipliers, &column);
        }
        match step.ending {
            Ending::Chosen => {}
            Ending::Given | Ending::Timed => {
                if let Some(gradient) = &mut sums.gradient {
                    add(gradient, along_length + shift, &self.end_slopes(step)?);
                }
                shift = -along_length;
            }
            Ending::Crossing(indicator) => {
                let z = self.crossing_slopes(step, indicator);
                let c = z.coordinate;
                let along = z.by_angle * column.q[c] + z.by_rate * column.v[c];
                let share = (along_length + shift) / along;
                multipliers.q[c] -= share * z.by_angle;
                multipliers.v[c] -= share * z.by_rate;
                if let Some(gradient) = &mut sums.gradient {
                    add(gradient, -share, &z.by_parameters);
                }
            }
        }
        shift += seeds.by_shift();
        self.back_through(step, multipliers, shift, (seeds, sums))
    }

    /// Multipliers of a step's start and time from those of its end, for a fixed length.
    fn back_through(
        &mut self,
        step: &Step,
        end: Variation,
        mut shift: f64,
        (seeds, sums): (Seeds, &mut Sums),
    ) -> Result<(Variation, f64), GradientError> {
        let (h, n, stages) = (step.length_s(), self.system.coordinates(), self.tableau.stages());
        let gain = h * self.tableau.gamma;
        let points: Vec<&Point> = std::iter::once(&step.start).chain(step.solved()).collect();
        let mut on = vec![Variation::zeros(n); stages];
        on[stages - 1] = end;
        seeds.add_to(&mut on);
        for stage in (1..stages).rev() {
            let at = points[stage];
            let laws = self.laws(at.time_s, step.middle_s());
            let by_time = self.time_slope(at, h);
            self.linearize(at);
            self.factorize_stage(at, gain, stage == stages - 1)?;
            let Variation { q: b_q, v: b_v, a: b_a } = on[stage].clone();
            let right: Vec<f64> = (0..n).map(|i| b_a[i] + gain * (b_v[i] + gain * b_q[i])).collect();
            let [w, by_q, by_v] = self.solve_transposed(at, gain, &right)?;
            let mut e_q: Vec<f64> = (0..n).map(|i| b_q[i] - by_q[i]).collect();
            let mut e_v: Vec<f64> = (0..n).map(|i| b_v[i] + gain * (b_q[i] - by_q[i]) - by_v[i]).collect();
            self.system.equations.clear_held(&mut e_v);
            if !laws.is_empty() {
                let by_a = self.momentum(&w);
                let [on_v, on_a] = [(&b_v, &by_v), (&b_a, &by_a)]
                    .map(|(on, by)| on.iter().zip(by).map(|(on, by)| on - by).collect::<Vec<f64>>());
                shift += self.through_laws((&laws, at.time_s), [&e_q, &on_v, &on_a], sums.gradient.as_mut());
                laws.iter().for_each(|law| e_q[law.coordinate] = 0.0);
            }
            shift -= by_time.map_or(0.0, |by_time| dot(&by_time, &w));
            self.subtract_forcings(at, &w, sums);
            for (weight, earlier) in self.tableau.rows[stage - 1].iter().zip(&mut on) {
                add(&mut earlier.v, h * weight, &e_q);
                add(&mut earlier.a, h * weight, &e_v);
            }
            add(&mut on[0].q, 1.0, &e_q);
            add(&mut on[0].v, 1.0, &e_v);
        }
        Ok((on.swap_remove(0), shift))
    }

    /// `Mᵀw` at the linearised point.
    fn momentum(&mut self, w: &[f64]) -> Vec<f64> {
        let [mut by_q, mut by_v, mut by_a] = [0, 1, 2].map(|_| vec![0.0; w.len()]);
        self.system.equations.residual_transposed(&mut self.derivative, w, [&mut by_q, &mut by_v, &mut by_a]);
        by_a
    }

    fn subtract_forcings(&mut self, at: &Point, w: &[f64], sums: &mut Sums) {
        if let Some(sections) = &mut self.sections {
            sections.add_on_loads(&self.system.equations, &at.q, w, &mut sums.loads);
        }
        if let Some(gradient) = &mut sums.gradient {
            self.find_residual_slopes(at);
            let slopes = self.neighbours.iter().map(Neighbours::slope_of_residual);
            let by_neighbours: Vec<f64> = slopes.map(|slope| dot(slope, w)).collect();
            add(gradient, -1.0, &self.by_parameters(at.time_s, &by_neighbours));
        }
    }
}
