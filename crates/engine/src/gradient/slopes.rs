//! Slopes of the residual of the whole machine, and the parts that have none.

use crate::force::joint::JointForces;
use crate::gradient::GradientError;
use crate::load::Wrench;
use crate::multibody::Workspace;
use crate::multibody::derivative::{Derivative, Lanes, elastic_products};
use crate::multibody::dynamics::Environment;
use crate::multibody::kinematics::Motion;
use crate::multibody::model::Body;
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use crate::system::System;
use crate::system::equations::Equations;
use nalgebra::Vector3;

/// Largest jump of the torque of a generator at the first row of its table, relative to this torque, that is round-off.
const GENERATOR_JUMP: f64 = 1e-6;

/// Loads that act.
fn stations(equations: &Equations) -> &[Wrench] {
    if equations.loaded { &equations.stations } else { &[] }
}

impl Equations {
    /// Motion and wrenches of the nodes and the slopes of the forces on joints at a point, as a residual leaves them, without the torques that
    /// hold joints. `scratch` has the size of a residual.
    pub(super) fn place(&mut self, at: &Point, scratch: &mut [f64]) {
        self.wrenches(at.time_s, Motion { q: &at.q, v: &at.v, a: &at.a }, scratch);
        self.forces.apply(at.time_s, [&at.q, &at.v], &self.work, scratch, &mut self.tangents);
    }

    /// Linearises the residual at the point of the last one, or of the last [`Self::place`].
    pub(super) fn linearize(&self, derivative: &mut Derivative, at: &Point) {
        let environment = Environment { root: &self.root, damping: &self.damping, stations: stations(self) };
        derivative.prepare(&self.model, &self.work, Motion { q: &at.q, v: &at.v, a: &at.a }, &environment);
        for joint in self.forces.spatial() {
            if let Some([by_turn, by_spin]) = joint.attitude().and_then(|spring| spring.slopes(&self.work, &at.v)) {
                derivative.add_torques(joint.body, &by_turn, &by_spin);
            }
        }
    }

    /// Size of a direction of the coordinates in differences: the kinematic norm, but not below the largest change of a rotation's parameter,
    /// which may hardly turn anything.
    pub(super) fn size_of(&mut self, direction: &[f64]) -> f64 {
        let size = self.norm(direction);
        let joints = self.model.bodies.iter().map(|body| &body.joint).filter(|joint| joint.kind.is_redundant());
        let parameters = joints.flat_map(|joint| &direction[joint.range()][joint.kind.translations()..]);
        let size = parameters.fold(size, |size, entry| size.max(entry.abs()));
        let multipliers = &direction[self.model.tree_coordinates()..];
        if multipliers.is_empty() {
            return size;
        }
        // a force on the machine's mass
        let mass_kg = crate::multibody::energy::mass_kg(&self.model);
        multipliers.iter().fold(size, |size, entry| size.max(entry.abs() / mass_kg))
    }

    /// Solution of the transposed equations by the factors, which are symmetric in the degrees of freedom but for circuits: `D⁻¹ N⁻¹ Dᵀ` of eq. (X26).
    pub(super) fn solve_transposed(&mut self, derivative: &Derivative, x: &mut [f64]) {
        derivative.to_rows(x);
        self.transpose_circuits();
        self.solve(x);
        self.transpose_circuits();
        derivative.to_freedoms(x);
    }

    /// Replaces each circuit by its transpose, and a transpose by the circuit.
    fn transpose_circuits(&mut self) {
        self.model.circuits.iter_mut().for_each(|circuit| *circuit = circuit.transposed());
    }

    /// Factors of `M + g C + g² K` at the linearised point, with all terms of the tree; `None` if a pivot is not positive.
    pub(super) fn factorize_exact(&self, derivative: &mut Derivative, gain_s: f64) -> Option<()> {
        let joint = |body: usize| {
            let tangent = self.tangents[body];
            let inertia = self.model.bodies[body].joint.drive_inertia;
            tangent.free.then_some(inertia + gain_s * (tangent.damping + gain_s * tangent.stiffness))
        };
        derivative.factorize(&self.model, gain_s, &self.damping, joint)
    }

    /// `K δq + C δv + M δa` at the linearised point, eq. (X3); rows of held joints are zero.
    pub(super) fn residual_along(&self, derivative: &mut Derivative, along: Motion, out: &mut [f64]) {
        self.rows_along(derivative, along, out);
        self.clear_held(out);
    }

    /// The same with the rows of held joints, which are the torques that hold them.
    pub(super) fn rows_along(&self, derivative: &mut Derivative, along: Motion, out: &mut [f64]) {
        out.fill(0.0);
        if !derivative.forward_plain((&self.model, &self.damping), along, out) {
            derivative.forward(&self.model, along, out);
            elastic_products::<false>(&self.model, &self.damping, along.q, along.v, |row, force, viscous| {
                out[row] += force + viscous
            });
        }
        self.model.damped_modes.iter().for_each(|mode| mode.add_forces(along.v, out));
        self.model.circuits.iter().for_each(|circuit| circuit.add_along(along.v, along.a, out));
        for joint in self.forces.joints() {
            let (c, tangent) = (joint.coordinate, self.tangents[joint.body]);
            let inertia = self.model.bodies[joint.body].joint.drive_inertia;
            out[c] += tangent.stiffness * along.q[c] + tangent.damping * along.v[c] + inertia * along.a[c];
        }
    }

    /// Several products of [`Self::residual_along`] side by side; only if [`Derivative::has_lanes`].
    pub(super) fn residual_along_lanes<const L: usize>(
        &self,
        derivative: &Derivative,
        lanes: &mut Lanes<L>,
        [q, v, a]: [&[[f64; L]]; 3],
        out: &mut [[f64; L]],
    ) {
        derivative.forward_lanes((&self.model, &self.damping), lanes, [q, v, a], out);
        for joint in self.forces.joints() {
            let (c, tangent) = (joint.coordinate, self.tangents[joint.body]);
            let inertia = self.model.bodies[joint.body].joint.drive_inertia;
            for lane in 0..L {
                out[c][lane] += tangent.stiffness * q[c][lane] + tangent.damping * v[c][lane] + inertia * a[c][lane];
            }
        }
        self.held().for_each(|held| out[held] = [0.0; L]);
    }

    /// `Kᵀw`, `Cᵀw` and `Mᵀw` there, eq. (X4); `w` is zero at held joints.
    pub(super) fn residual_transposed(&self, derivative: &mut Derivative, w: &[f64], out: [&mut [f64]; 3]) {
        let [by_q, by_v, by_a] = out;
        [&mut *by_q, &mut *by_v, &mut *by_a].into_iter().for_each(|out| out.fill(0.0));
        derivative.reverse(&self.model, w, [by_q, by_v, by_a]);
        elastic_products::<true>(&self.model, &self.damping, w, w, |row, force, viscous| {
            by_q[row] += force;
            by_v[row] += viscous;
        });
        self.model.damped_modes.iter().for_each(|mode| mode.add_forces(w, by_v));
        self.model.circuits.iter().for_each(|circuit| circuit.add_transposed(w, by_v, by_a));
        for joint in self.forces.joints() {
            let (c, tangent) = (joint.coordinate, self.tangents[joint.body]);
            by_q[c] += tangent.stiffness * w[c];
            by_v[c] += tangent.damping * w[c];
            by_a[c] += self.model.bodies[joint.body].joint.drive_inertia * w[c];
        }
    }

    /// Adds a multiple of the forces on the joints alone, as the residual counts them, at a point whose motions and wrenches are in `work`.
    /// `scratch` has the size of a residual.
    pub(super) fn add_joint_residual(
        &mut self,
        (at, work): (&Point, &Workspace),
        factor: f64,
        scratch: &mut [f64],
        sum: &mut [f64],
    ) {
        self.bring_loads_to(at.time_s);
        self.forces.rows().for_each(|row| scratch[row] = 0.0);
        self.forces.apply(at.time_s, [&at.q, &at.v], work, scratch, &mut self.tangents);
        self.forces.rows().for_each(|row| sum[row] += factor * scratch[row]);
    }

    /// Whether another machine has the same loads.
    pub(super) fn loads_are_those_of(&self, other: &Self) -> bool {
        self.root == other.root
            && self.loaded == other.loaded
            && self.stations[..self.load_stations] == other.stations[..other.load_stations]
    }

    /// Adds a multiple of loads, six entries per section in its frame, to those of the air.
    pub(super) fn add_air_loads(&mut self, loads: &[f64], factor: f64) {
        let Some(air) = &mut self.air else { return };
        for (load, entries) in air.impulsive.iter_mut().zip(loads.chunks_exact(6)) {
            load.force_n += Vector3::from_column_slice(&entries[..3]) * factor;
            load.moment_n_m += Vector3::from_column_slice(&entries[3..]) * factor;
        }
    }

    /// Held joints take no part: sets their entries to zero.
    pub(super) fn clear_held(&self, values: &mut [f64]) {
        for held in self.held() {
            values[held] = 0.0;
        }
    }

    /// The entries of joints that rest do not vary: sets them to zero.
    pub(super) fn clear_resting(&self, values: &mut [f64]) {
        for resting in self.resting() {
            values[resting] = 0.0;
        }
    }

    /// Coordinates of the joints that are held at rest, by a lock or a rigid latch, not by a prescribed motion.
    pub(super) fn resting(&self) -> impl Iterator<Item = usize> {
        let resting = self.forces.joints().iter().filter(|joint| joint.held && joint.law().is_none());
        resting.map(|joint| joint.coordinate)
    }

    /// Coordinates of the joints that are held.
    pub(super) fn held(&self) -> impl Iterator<Item = usize> {
        self.forces.joints().iter().filter(|joint| joint.held).map(|joint| joint.coordinate)
    }
}

impl System {
    /// Returns an error for machines with parts whose derivatives are not known, by their names.
    pub(crate) fn refuse_gradient(&self) -> Result<(), GradientError> {
        let refuse = |part, place: &str| Err(GradientError::NotCovered { part, place: place.into() });
        let other = |part, remedy: &str| Err(GradientError::OtherChoice { part, remedy: remedy.into() });
        let machine = &*self.machine;
        if let Some((part, place)) = self.air_without_slopes() {
            return refuse(part, place);
        }
        if let Some(failure) = machine.failures.iter().find(|failure| failure.lasts_after_a_bound(&machine.failures)) {
            return refuse(
                "failures with a delay, a ramp or a runaway after a bound of a joint's motion",
                &failure.name,
            );
        }
        if machine.solver.most_iterations.is_some() {
            return refuse("real-time mode, whose stages may end without convergence", "solver.mode");
        }
        if let Some(joint) = machine.sliding_joint() {
            return refuse("sliding joints", joint);
        }
        let turns_otherwise =
            |body: &Body| body.modal.as_ref().is_some_and(|modal| modal.element.has_rates_of_angles());
        if let Some(body) = self.equations.model.bodies.iter().position(turns_otherwise) {
            return refuse(
                "modal bodies whose angular velocity is the rate of small angles",
                &machine.bodies[body].name,
            );
        }
        if let Some((part, body)) = self.shear_without_slopes() {
            return refuse(part, &machine.bodies[body].name);
        }
        if !self.state.rates.is_still() || !self.state.applied_rates.is_still() || self.equations.course.moves {
            return refuse("inputs that vary in time", "inputs");
        }
        if !self.state.initialized || self.inputs_changed() {
            return other("inputs or parameters that changed after the initialisation", "initialise the model again");
        }
        if self.state.statistics.steps != 0 {
            return other("runs that continue an earlier run", "initialise the model first");
        }
        Ok(())
    }

    /// Returns an error for a generator whose torque jumps between some points, by the name of its joint. Torques of neighbouring machines may
    /// jump by their change.
    pub(crate) fn refuse_jumps<'p>(
        &self,
        points: impl Iterator<Item = &'p Point> + Clone,
    ) -> Result<(), GradientError> {
        let jumps = |joint: &&JointForces| {
            let Some(law) = joint.generator().map(|own| &own.law) else { return false };
            let (Some(first), true) = (law.rows.first(), law.relative_jump() > GENERATOR_JUMP) else { return false };
            let is_below = |at: &Point| law.gear_ratio * at.v[joint.coordinate] < first[0];
            let mut sides = points.clone().map(is_below);
            let side = sides.next();
            sides.any(|other| Some(other) != side)
        };
        match self.equations.forces.joints().iter().find(jumps) {
            Some(joint) => Err(GradientError::NotCovered {
                part: "runs in which a generator passes the first row of its table, where its torque jumps",
                place: self.machine.bodies[joint.body].joint.name.clone(),
            }),
            None => Ok(()),
        }
    }

    /// A body with shear in a machine with a part that is then not covered, with the name of the part.
    fn shear_without_slopes(&self) -> Option<(&'static str, usize)> {
        let model = &self.equations.model;
        let damping = self.equations.damping.iter();
        let carried = model
            .bodies
            .iter()
            .zip(damping)
            .position(|(body, damping)| body.sheared && body.carrier.is_some() && damping.mass_1_s != 0.0);
        carried.map(|body| ("mass-proportional damping of bodies with shear on free joints", body))
    }
}
