//! The model with a vortex lattice as a linear system in discrete time, NOTATION eqs. (L27) to (L29), with the aerodynamic step as the
//! sampling time, coupled as in a simulation by (Q1), (Q2) and (Q4).

use crate::solve::held::{HeldStructure, held_structure};
use crate::solve::linearize::{SecondOrder, StateSpace};
use crate::study::Study;
use crate::study::linear::Argument;
use crate::study::state_space::{InputSlope, air_of, columns_of};
use crate::system::air::slopes::SECTION_VARIABLES;
use crate::system::air::{LatticeSlopes, SECTION_PARTS, VELOCITY_WEIGHTS};
use crate::system::freedoms::Freedom;
use crate::system::{Outputs, PlantError};
use nalgebra::{DMatrix, DVector, Vector3};
use std::ops::Range;

/// Number of entries of a wrench.
const ENTRIES: usize = 6;
/// Maximum number of states: five dense matrices of this size take 2.6 GB.
const MAXIMUM_STATES: usize = 8_000;
/// Number of dense matrices of that size in memory: the rows under construction, `A`, its copies for names and files, and the one for the
/// eigenvalues.
const MATRICES: f64 = 5.0;

/// A linear model in discrete time, `x⁺ = A x + B u`, `y = C x + D u`.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledSpace {
    /// Matrices `A`, `B`, `C` and `D`.
    pub matrices: StateSpace,
    /// Step in s.
    pub step_s: f64,
    /// Names and units of the states.
    pub states: Vec<(String, &'static str)>,
    /// Number of degrees of freedom; the states start with the coordinates and their rates.
    pub freedoms: usize,
}

/// Index ranges of the kinds of states.
struct Layout {
    position: Range<usize>,
    rate: Range<usize>,
    mean: Range<usize>,
    seen: Range<usize>,
    bound: Range<usize>,
    /// Circulatory loads and hinge moments at the end of the last step.
    load: Range<usize>,
    /// Loads and hinge moments of the last step.
    acting: Range<usize>,
    wake: Range<usize>,
    /// Displacements of the last corners, and of the wake nodes after them.
    edge: Range<usize>,
    node: Range<usize>,
    gust: Range<usize>,
    count: usize,
}

impl Layout {
    fn new(freedoms: usize, slopes: &LatticeSlopes) -> Self {
        let loads = ENTRIES * slopes.sections + slopes.flaps;
        let mut count = 0;
        let mut next = |size: usize| {
            count += size;
            count - size..count
        };
        let (position, rate, mean, seen) = (next(freedoms), next(freedoms), next(freedoms), next(freedoms));
        let (bound, load, acting) = (next(slopes.panels), next(loads), next(loads));
        let edges = if slopes.node.ncols() > 0 { 3 * slopes.edges } else { 0 };
        let (wake, edge, node) = (next(slopes.wake.ncols()), next(edges), next(slopes.node.ncols()));
        let gust = next(slopes.gust.ncols());
        Self { position, rate, mean, seen, bound, load, acting, wake, edge, node, gust, count }
    }
}

impl Study<'_> {
    /// Linear model of the machine with its lattice about the current state, which must be an equilibrium, in aerodynamic steps.
    ///
    /// Inputs are constant over a step, as in a simulation; wind and control surfaces act at its end. A gust input is the velocity, at the
    /// end of the step and at the foremost point of the lattice, of a gust that travels with the wind. Outputs are values at the end of a
    /// step, under the loads of that step.
    ///
    /// # Errors
    /// For machines without a lattice, moving states, unsteady flows, and too many states for the memory.
    pub fn lattice_space(
        &mut self,
        inputs: &[InputSlope],
        read: &dyn Fn(&Outputs) -> DVector<f64>,
    ) -> Result<SampledSpace, PlantError> {
        self.on_tangents(|study| study.lattice_space_on_tangents(inputs, read))
    }

    fn lattice_space_on_tangents(
        &mut self,
        inputs: &[InputSlope],
        read: &dyn Fn(&Outputs) -> DVector<f64>,
    ) -> Result<SampledSpace, PlantError> {
        let gusts = inputs.iter().any(|input| input.gust_m_s != Vector3::zeros());
        // before anything of that size is computed; wake nodes and gusts can add further states
        let at_least = self.system.freedoms().len() * 4 + self.system.lattice_circulations();
        if at_least > MAXIMUM_STATES {
            return Err(self.too_many_states(at_least));
        }
        let lattice = self.sampled_lattice(gusts)?;
        let (slopes, freedoms) = (&lattice.slopes, self.system.freedoms());
        let kept = self.system.inputs().clone();
        let count = read(&self.outputs_beside(None)).len();
        let (mut forces, mut direct, mut air) = (Vec::new(), Vec::new(), Vec::new());
        for input in inputs {
            let mut ends = [1.0, -1.0].map(|sign| {
                (input.add)(self.system.inputs_mut(), sign * input.step);
                let end = (self.residual_of_inputs(), read(&self.outputs_beside(None)));
                self.system.inputs_mut().clone_from(&kept);
                end
            });
            let scale = 0.5 / input.step;
            let [above, below] = &mut ends;
            forces.push((&above.0 - &below.0) * scale);
            direct.push((&above.1 - &below.1) * scale);
            air.push(DVector::from(air_of(input, &kept)));
        }
        let layout = Layout::new(freedoms.len(), slopes);
        if layout.count > MAXIMUM_STATES {
            return Err(self.too_many_states(layout.count));
        }
        let coupled = Coupled {
            layout: &layout,
            lattice: &lattice,
            input_force: columns_of(&forces, freedoms.len()),
            air: columns_of(&air, 9 + 2 * slopes.flaps),
        };
        let (a, b) = coupled.step().ok_or_else(|| self.no_masses())?;
        let direct = columns_of(&direct, count);
        let (c, d) = self.sampled_outputs(&coupled, &freedoms, direct, read);
        let matrices = StateSpace { a, b, c, d };
        let states = self.sampled_names(&layout, &freedoms, slopes);
        Ok(SampledSpace { matrices, step_s: lattice.step_s, states, freedoms: freedoms.len() })
    }

    fn too_many_states(&self, count: usize) -> PlantError {
        let cause = format!(
            "the discrete-time model would have at least {count} states and dense matrices of {:.1} GB; at most \
             {MAXIMUM_STATES} states are allowed: use fewer wake_rows, strips or chord_panels",
            MATRICES * (count as f64).powi(2) * 8e-9
        );
        PlantError::Linearization { time_s: self.system.state.now.time_s, cause }
    }

    fn no_masses(&self) -> PlantError {
        let cause = "the mass matrix is not positive definite".into();
        PlantError::Linearization { time_s: self.system.state.now.time_s, cause }
    }

    /// Structure and lattice about the current equilibrium.
    pub(super) fn sampled_lattice(&mut self, gusts: bool) -> Result<SampledLattice, PlantError> {
        let time_s = self.system.state.now.time_s;
        let refused = |cause: &str| PlantError::Linearization { time_s, cause: cause.into() };
        let Some(step_s) = self.system.air_step_s().filter(|_| self.system.has_linear_lattice()) else {
            return Err(refused("only a vortex lattice (aerodynamics.model = \"uvlm\") has a discrete-time model"));
        };
        self.system.refuse_dc_motor("linear model in discrete time")?;
        if !self.system.stands_still() {
            return Err(refused("a lattice can be linearised only about a state of rest; use the equilibrium"));
        }
        let second = self.second_order()?;
        let freedoms = self.system.freedoms();
        let sections = self.sections_at(&self.system.state.now.q.clone(), None, None);
        let motions: Vec<_> = sections.into_iter().map(|(motion, _)| motion).collect();
        let Some(slopes) = self.system.lattice_slopes(&motions, gusts)? else {
            return Err(refused("the model has no lattice"));
        };
        let [by_place, by_velocity] = self.answers_of_motion(&freedoms, &slopes);
        let units = DMatrix::identity(ENTRIES * slopes.sections, ENTRIES * slopes.sections);
        let force = self.residual_of_loads(&units, &freedoms);
        let held = held_structure(&second, step_s).ok_or_else(|| self.no_masses())?;
        Ok(SampledLattice { slopes, second, held, step_s, by_place, by_velocity, force })
    }

    /// Response of the lattice to the coordinates, and to their averaged rates in the aerodynamic model.
    fn answers_of_motion(&mut self, freedoms: &[Freedom], slopes: &LatticeSlopes) -> [DMatrix<f64>; 2] {
        let [by_place, by_rate, _] = self.section_slopes(freedoms);
        [(0, by_place), (6, by_rate)].map(|(first, by)| {
            let mut sum = DMatrix::zeros(slopes.rows(), freedoms.len());
            for section in 0..slopes.sections {
                let answers = slopes.section.columns(SECTION_PARTS * section + first, 6);
                sum += answers * by.rows(SECTION_VARIABLES * section + first, 6);
            }
            sum
        })
    }

    /// Matrices `C` and `D`, eq. (L29).
    fn sampled_outputs(
        &mut self,
        coupled: &Coupled,
        freedoms: &[Freedom],
        direct: DMatrix<f64>,
        read: &dyn Fn(&Outputs) -> DVector<f64>,
    ) -> (DMatrix<f64>, DMatrix<f64>) {
        let Coupled { layout, lattice: SampledLattice { slopes, second, force, .. }, input_force, .. } = coupled;
        let count = direct.nrows();
        let [position, rate, acceleration] =
            [Argument::Position, Argument::Rate, Argument::Acceleration].map(|argument| {
                let columns: Vec<_> =
                    freedoms.iter().map(|freedom| self.output_slope(argument, freedom, read)).collect();
                columns_of(&columns, count)
            });
        let loads = ENTRIES * slopes.sections;
        // responses that the outputs depend on: loads, circulations of strips, hinge moments
        let strips = slopes.trailing.len();
        let answers = DMatrix::identity(loads + strips + slopes.flaps, loads + strips + slopes.flaps);
        let of_air = self.outputs_of_air(&answers, count, read);
        let mut c = DMatrix::zeros(count, layout.count);
        let Some(inverse) = second.mass.clone().cholesky() else { return (c, direct) };
        let by_force = -&acceleration * inverse.inverse();
        c.columns_mut(layout.position.start, freedoms.len()).copy_from(&(position + &by_force * &second.stiffness));
        c.columns_mut(layout.rate.start, freedoms.len()).copy_from(&(rate + &by_force * &second.damping));
        let mut acting = c.columns_mut(layout.acting.start, layout.acting.len());
        acting.columns_mut(0, loads).copy_from(&(of_air.columns(0, loads) + &by_force * force));
        acting.columns_mut(loads, slopes.flaps).copy_from(&of_air.columns(loads + strips, slopes.flaps));
        for (strip, panel) in slopes.trailing.iter().enumerate() {
            c.set_column(layout.bound.start + panel, &of_air.column(loads + strip));
        }
        let d = direct + by_force * input_force;
        (c, d)
    }

    /// Names and units of the states.
    fn sampled_names(
        &self,
        layout: &Layout,
        freedoms: &[Freedom],
        slopes: &LatticeSlopes,
    ) -> Vec<(String, &'static str)> {
        let mut names = Vec::with_capacity(layout.count);
        names.extend(freedoms.iter().map(|freedom| (freedom.name.clone(), freedom.unit)));
        for kind in ["der", "mean_rate", "seen_rate"] {
            names.extend(freedoms.iter().map(|freedom| (format!("{kind}({})", freedom.name), freedom.rate_unit)));
        }
        let [panels, strips] = self.system.lattice_names();
        names.extend(panels.into_iter().map(|panel| (format!("{panel}.circulation"), "m2/s")));
        let flaps = self.system.machine.air.iter().flat_map(|air| &air.flaps);
        let hinges: Vec<&String> = flaps.map(|flap| &flap.name).collect();
        for kind in ["circulatory", "acting"] {
            for section in self.system.section_names() {
                for (part, unit) in [("force", "N"), ("moment", "N.m")] {
                    let of = |axis| (format!("{section}.{kind}_{part}.{axis}"), unit);
                    names.extend(["x", "y", "z"].map(of));
                }
            }
            names.extend(hinges.iter().map(|flap| (format!("{flap}.{kind}_hinge_moment"), "N.m")));
        }
        for row in 1..=slopes.wake_rows {
            names.extend(strips.iter().map(|strip| (format!("{strip}.wake[{row}].circulation"), "m2/s")));
        }
        for row in 0..if layout.node.is_empty() { 0 } else { slopes.node_rows() + 1 } {
            for node in self.system.section_names() {
                names.extend(["x", "y", "z"].map(|axis| (format!("{node}.wake[{row}].position.{axis}"), "m")));
            }
        }
        for place in 1..=slopes.gust_places() {
            names.extend(["x", "y", "z"].map(|axis| (format!("gust.{axis}[{place}]"), "m/s")));
        }
        names
    }
}

/// Structure and lattice about an equilibrium.
pub(super) struct SampledLattice {
    pub slopes: LatticeSlopes,
    /// The structure under constant loads.
    pub second: SecondOrder,
    /// Response of the structure over a step.
    pub held: HeldStructure,
    pub step_s: f64,
    /// Response of the lattice to the coordinates.
    pub by_place: DMatrix<f64>,
    /// Response to the averaged rates of the aerodynamic model.
    pub by_velocity: DMatrix<f64>,
    /// Derivative of the residual with respect to the loads of the sections.
    pub force: DMatrix<f64>,
}

/// Structure and lattice coupled within a step, with inputs.
struct Coupled<'a> {
    layout: &'a Layout,
    lattice: &'a SampledLattice,
    /// Derivative of the residual with respect to the inputs.
    input_force: DMatrix<f64>,
    /// Aerodynamic variables that the inputs change: wind, angular velocity, rates of the control surfaces, gust, angles of the control
    /// surfaces.
    air: DMatrix<f64>,
}

impl Coupled<'_> {
    /// `A` and `B`; `None` if the mass matrix is singular.
    fn step(&self) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let Self { layout, lattice, .. } = self;
        let SampledLattice { slopes, step_s, second, held, by_place, by_velocity, force } = lattice;
        let (n, states, inputs) = (second.mass.nrows(), layout.count, self.air.ncols());
        let (panels, loads) = (slopes.panels, ENTRIES * slopes.sections);
        let rest = loads + slopes.flaps;
        let wide = states + inputs;
        let strips = slopes.trailing.len();
        // every quantity is a linear function of the states and inputs at the start of the step, with `wide` columns
        let mut wake = DMatrix::zeros(slopes.wake.ncols(), wide);
        for (strip, panel) in slopes.trailing.iter().enumerate() {
            wake[(strip, layout.bound.start + panel)] = 1.0;
        }
        for ring in strips..wake.nrows() {
            wake[(ring, layout.wake.start + ring - strips)] = 1.0;
        }
        let mut gust = DMatrix::zeros(slopes.gust.ncols(), wide);
        for row in 0..gust.nrows() {
            match row.checked_sub(3) {
                Some(before) => gust[(row, layout.gust.start + before)] = 1.0,
                None => {
                    let at_front = self.air.row(6 + slopes.flaps + row);
                    gust.view_mut((row, states), (1, inputs)).copy_from(&at_front);
                }
            }
        }
        // nodes of the wake move with the wind, eq. (U25)
        let edges = layout.edge.len();
        let mut node = DMatrix::zeros(slopes.node.ncols(), wide);
        (0..node.nrows()).for_each(|row| node[(row, layout.edge.start + row)] = 1.0);
        let carried = &slopes.carried * self.air.rows(0, slopes.carried.ncols());
        node.columns_mut(states, inputs).copy_from(&carried);
        // the response without the motion of this step, eq. (U24)
        let [own, earlier, last] = VELOCITY_WEIGHTS;
        let mut answer = DMatrix::zeros(slopes.rows(), wide);
        answer.columns_mut(layout.position.start, n).copy_from(&(by_velocity * (-own / step_s)));
        answer.columns_mut(layout.mean.start, n).copy_from(&(by_velocity * earlier));
        answer.columns_mut(layout.seen.start, n).copy_from(&(by_velocity * last));
        // the wake shifts states to states: no multiplication by zeros
        answer
            .columns_mut(layout.wake.start, wake.nrows() - strips)
            .copy_from(&slopes.wake.columns(strips, wake.nrows() - strips));
        for (strip, panel) in slopes.trailing.iter().enumerate() {
            let mut column = answer.column_mut(layout.bound.start + panel);
            column += slopes.wake.column(strip);
        }
        if edges > 0 {
            // the nodes lie behind the edges: the states of this step's nodes are those of the previous row
            answer.columns_mut(layout.edge.start, node.nrows()).copy_from(&slopes.node);
            let carried = &slopes.node * node.columns(states, inputs);
            let mut at_inputs = answer.columns_mut(states, inputs);
            at_inputs += carried;
        }
        if gust.nrows() > 0 {
            answer += &slopes.gust * &gust;
        }
        let mut by_input = slopes.air.columns(0, 6 + slopes.flaps) * self.air.rows(0, 6 + slopes.flaps);
        by_input += slopes.air.columns(6 + slopes.flaps, slopes.flaps) * self.air.rows(9 + slopes.flaps, slopes.flaps);
        let mut at_inputs = answer.columns_mut(states, inputs);
        at_inputs += by_input;
        // loads of the step from a response at its end, eq. (Q1): half of the circulatory loads, and the rate of the impulse; hinge moments
        // count fully
        let rate = &slopes.impulse / *step_s;
        let mut taken = DMatrix::zeros(rest, slopes.rows());
        taken.columns_mut(0, panels).copy_from(&rate);
        for row in 0..rest {
            taken[(row, panels + row)] = if row < loads { 0.5 } else { 1.0 };
        }
        let mut before = DMatrix::zeros(rest, wide);
        before.columns_mut(layout.bound.start, panels).copy_from(&-&rate);
        (0..loads).for_each(|row| before[(row, layout.load.start + row)] = 0.5);
        // the structure under these loads, eq. (L28)
        let moved = by_place + by_velocity * (own / step_s);
        let mut acting = &before + &taken * &answer;
        let mut pushed = force * acting.rows(0, loads);
        let mut at_inputs = pushed.columns_mut(states, inputs);
        at_inputs += &self.input_force;
        let mut free = DMatrix::zeros(2 * n, wide);
        free.columns_mut(layout.position.start, 2 * n).copy_from(&held.free);
        free -= &held.by_force * pushed;
        let back = &held.by_force * (force * (taken.rows(0, loads) * &moved));
        let implicit = DMatrix::identity(n, n) + back.rows(0, n);
        let position = implicit.lu().solve(&free.rows(0, n).into_owned())?;
        let velocity = free.rows(n, n) - back.rows(n, n) * &position;
        answer += &moved * &position;
        acting += &taken * (&moved * &position);
        let mut mean = &position / *step_s;
        (0..n).for_each(|i| mean[(i, layout.position.start + i)] -= 1.0 / step_s);
        let mut seen = &mean * own;
        for i in 0..n {
            seen[(i, layout.mean.start + i)] += earlier;
            seen[(i, layout.seen.start + i)] += last;
        }
        let mut all = DMatrix::zeros(states, wide);
        let mut put =
            |place: &Range<usize>, rows: &DMatrix<f64>| all.rows_mut(place.start, place.len()).copy_from(rows);
        put(&layout.position, &position);
        put(&layout.rate, &velocity);
        put(&layout.mean, &mean);
        put(&layout.seen, &seen);
        put(&layout.bound, &answer.rows(0, panels).into_owned());
        put(&layout.load, &answer.rows(panels, rest).into_owned());
        put(&layout.acting, &acting);
        put(&layout.wake, &wake);
        put(&layout.edge, &answer.rows(slopes.edge_row(), edges).into_owned());
        put(&layout.node, &node);
        put(&layout.gust, &gust);
        Some((all.columns(0, states).into_owned(), all.columns(states, inputs).into_owned()))
    }
}

#[cfg(test)]
mod tests;
