//! Static equilibrium of the model under its loads.

use crate::force::set::Forces;
use crate::load::{RootMotion, Wrench};
use crate::multibody::Model;
use crate::multibody::norm::kinematic_norm;
use crate::multibody::tangent::{JointTangent, SingularTangent, Surroundings, Tangent};
use crate::solve::arc_length::{self, PathPoint};
use crate::solve::equilibrium::{self, Cause, Effort, NoEquilibrium, Settings, StaticEquations};
use crate::solve::settle;
use crate::solve::{EquationsOfMotion, Singular};
use crate::study::Study;
use crate::study::differences::DenseTangent;
use crate::study::stability::{SYMMETRIC, Stability};
use crate::system::PlantError;
use crate::system::equations::Equations;
use nalgebra::Matrix3;

/// Maximum number of searches for equilibrium if contacts open and close alternately.
const MAXIMUM_SEARCHES: usize = 100;
/// Gap of a closed loop at equilibrium, relative to the model's length, above which the loop counts as torn.
const TORN: f64 = 0.01;
/// Distance in rad, or displacement divided by the model's length, from an unstable equilibrium at which the search for a stable one near
/// it starts: within it the linear part of the torque is destabilising.
const BESIDE_RAD: f64 = 0.05;

/// Constraint of the joints in the search for equilibrium.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holding {
    /// According to their release inputs: a released joint moves until its motor and latch balance the loads. If its enabled latch is in
    /// between, it closes.
    AsReleased,
    /// Locks hold all joints at their initial angles, except those with a closed latch.
    Stopped,
}

/// Method to apply the loads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LoadPath {
    /// The whole load in one step, or in several steps if that fails, eq. (L9).
    #[default]
    Load,
    /// Along the path of equilibria, through its limit points, eq. (L17).
    ArcLength,
}

/// Choice of the equilibrium if the one on the path is unstable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Branch {
    /// The equilibrium on the path.
    #[default]
    Path,
    /// A stable equilibrium downhill from it, eq. (L15), assessed with the aerodynamics.
    Stable,
}

/// Settings of the search for equilibrium.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Search {
    /// Method to apply the loads.
    pub path: LoadPath,
    /// Whether an unstable equilibrium is accepted, or a stable one sought.
    pub branch: Branch,
}

/// Reason why the result is not on the path of equilibria.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Departure {
    /// The equilibrium under the whole load is unstable, with this number of unstable directions.
    Unstable(usize),
    /// The path ends, or turns back, at this load factor.
    PathEnds(f64),
    /// The path from still air ends at this fraction of the dynamic pressure, eq. (Q12).
    PathInAirEnds(f64),
}

/// An equilibrium, and how it was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Rest {
    /// Numbers of load steps and iterations.
    pub effort: Effort,
    /// Reason why the search left the path.
    pub departure: Option<Departure>,
    /// Points of the path by arc length; empty for other load paths.
    pub path: Vec<PathPoint>,
    /// Stability of the equilibrium, if the search has assessed it: with [`Branch::Stable`].
    pub stability: Option<Stability>,
    /// Largest correction in rad in each iteration of the hinges with only aerodynamic stiffness; empty without such hinges.
    pub corrections_rad: Vec<f64>,
}

/// The current search and its intermediate results.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Quest {
    search: Search,
    pub(super) departure: Option<Departure>,
    path: Vec<PathPoint>,
    pub(super) corrections_rad: Vec<f64>,
}

/// Loads and joint states of the requested case, which the search scales.
struct Target {
    root: RootMotion,
    stations: Vec<Wrench>,
    air: Vec<Wrench>,
    forces: Forces,
    start: Vec<f64>,
}

impl Target {
    /// Target given by the current equations, from the coordinates `start`.
    fn of(equations: &Equations, start: &[f64]) -> Self {
        Self {
            root: equations.root,
            stations: equations.stations[..equations.load_stations].to_vec(),
            air: equations.air.as_ref().map_or(Vec::new(), |air| air.to.clone()),
            forces: equations.forces.clone(),
            start: start.to_vec(),
        }
    }
}

/// The static equations of motion, eq. (L1), with loads that can be scaled, eq. (L8).
struct AtRest<'a> {
    equations: &'a mut Equations,
    tangent: Tangent,
    /// The tangent of a machine with sliding joints in place of `tangent`.
    dense: Option<DenseTangent>,
    target: Target,
    time_s: f64,
    /// Rates: zero, except the currents.
    still: Vec<f64>,
    /// Accelerations: zero, with the multipliers of rigid loops, which the unknowns have at their coordinates.
    multipliers: Vec<f64>,
    /// Weight of each coordinate in the arc length of a path.
    weights: Vec<f64>,
}

impl<'a> AtRest<'a> {
    fn new(equations: &'a mut Equations, dense: Option<DenseTangent>, time_s: f64, start: &[f64]) -> Self {
        let target = Target::of(equations, start);
        let weights = path_weights(&equations.model);
        Self {
            tangent: Tangent::new(&equations.model),
            dense,
            still: vec![0.0; start.len()],
            multipliers: vec![0.0; start.len()],
            target,
            time_s,
            equations,
            weights,
        }
    }

    /// Continues from the result of the search on the path to a stable state, if `q` is not stable and there is one.
    fn stabilise(
        &mut self,
        q: &mut [f64],
        found: Result<Effort, NoEquilibrium>,
    ) -> (Result<Effort, NoEquilibrium>, Option<Departure>) {
        let settings = Settings::default();
        let kept = q.to_vec();
        let (mut effort, departure) = match &found {
            Ok(effort) => match self.unstable_directions(q) {
                0 => return (found, None),
                directions => (*effort, Departure::Unstable(directions)),
            },
            Err(error) => (Effort::default(), Departure::PathEnds(error.reached)),
        };
        self.load(1.0);
        let left = match departure {
            Departure::Unstable(_) => settle::leave(self, q),
            Departure::PathEnds(_) | Departure::PathInAirEnds(_) => Ok(()),
        };
        match left.and_then(|()| settle::descend(self, q, settings, &mut effort)) {
            Ok(()) => (Ok(effort), Some(departure)),
            Err(_) => {
                q.copy_from_slice(&kept);
                self.residual(q, &mut vec![0.0; kept.len()]);
                (found, None)
            }
        }
    }

    /// Number of unstable directions of the equilibrium `q`; zero for loads without a potential, for which the pivots are inconclusive.
    fn unstable_directions(&mut self, q: &[f64]) -> usize {
        let directions = self.factorize(q, 0.0).unwrap_or(0);
        let asymmetry = match &self.dense {
            Some(dense) => dense.asymmetry(),
            None => self.tangent.asymmetry(&self.equations.model),
        };
        if directions > 0 && asymmetry < SYMMETRIC { directions } else { 0 }
    }
}

/// Weights of the coordinates in the arc length of a path: `∫κ² ds` times the length of the model, strains multiplied by the element's
/// fraction of that length, angles in rad, displacements divided by the length.
fn path_weights(model: &Model) -> Vec<f64> {
    let length_m = model.reference_length_m;
    let mut weights = vec![1.0; model.coordinates];
    weights[model.tree_coordinates() - model.circuits.len()..].fill(0.0);
    for body in &model.bodies {
        let first = body.joint.coordinate;
        weights[first..first + body.joint.kind.translations()].fill(length_m.powi(-2));
        if let Some(modal) = &body.modal {
            weights[modal.range()].fill(length_m.powi(-2));
        }
    }
    for element in &model.elements {
        weights[element.range()].fill(element.length_m / length_m);
        weights[element.curvatures()].fill(element.length_m * length_m);
    }
    weights
}

impl StaticEquations for AtRest<'_> {
    fn coordinates(&self) -> usize {
        self.still.len()
    }

    fn load(&mut self, factor: f64) {
        let Target { root, stations, air, forces, start } = &self.target;
        self.equations.root = RootMotion {
            gravity_m_s2: root.gravity_m_s2 * factor,
            acceleration_m_s2: root.acceleration_m_s2 * factor,
            angular_velocity_rad_s: root.angular_velocity_rad_s * factor.max(0.0).sqrt(),
            angular_acceleration_rad_s2: root.angular_acceleration_rad_s2 * factor,
        };
        for (scaled, load) in self.equations.stations.iter_mut().zip(stations) {
            *scaled = Wrench { force_n: load.force_n * factor, moment_n_m: load.moment_n_m * factor };
        }
        if let Some(loads) = &mut self.equations.air {
            loads.scale(air, factor);
        }
        for (joint, whole) in self.equations.forces.joints_mut().iter_mut().zip(forces.joints()) {
            joint.scale(whole, start[joint.coordinate], factor, self.time_s);
        }
    }

    fn residual(&mut self, q: &[f64], residual: &mut [f64]) {
        let tree = self.equations.model.tree_coordinates();
        self.multipliers[tree..].copy_from_slice(&q[tree..]);
        self.equations.seat_at(q);
        self.equations.stand(&mut self.still);
        self.equations.residual(self.time_s, q, &self.still, &self.multipliers, residual);
        let Equations { model, work, .. } = &*self.equations;
        // the currents are those at rest
        model.circuits.iter().for_each(|circuit| residual[circuit.coordinate] = 0.0);
        for (index, closure) in model.rigid_loops.iter().enumerate() {
            residual[model.multipliers(index)].copy_from_slice(closure.gap(work).position_m.as_slice());
        }
    }

    fn factorize(&mut self, q: &[f64], shift_1_s2: f64) -> Result<usize, Singular> {
        if let Some(dense) = &mut self.dense {
            return dense.factorize(self.equations, q, shift_1_s2);
        }
        self.equations.linearize_shifted(&mut self.tangent, q, shift_1_s2);
        let singular = |singular: SingularTangent| Singular { coordinate: singular.coordinate };
        self.tangent.factorize(&self.equations.model).map_err(singular)?;
        Ok(self.tangent.negative_directions())
    }

    fn solve(&mut self, x: &mut [f64]) {
        match &self.dense {
            Some(dense) => dense.solve(x),
            None => self.tangent.solve(&self.equations.model, x),
        }
        Tangent::to_coordinates(&self.equations.model, &self.equations.work, x);
    }

    fn norm(&mut self, change: &[f64]) -> f64 {
        kinematic_norm(&self.equations.model, &mut self.equations.work, change)
    }

    fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        self.weights.iter().zip(a.iter().zip(b)).map(|(weight, (a, b))| weight * a * b).sum()
    }

    fn project(&mut self, q: &mut [f64]) {
        let mut rates = vec![0.0; q.len()];
        let mut second = rates.clone();
        EquationsOfMotion::project(self.equations, q, &mut rates, &mut second);
    }
}

impl Equations {
    /// Computes the exact static tangent about `q`, the configuration of the last residual.
    pub(crate) fn linearize_at_rest(&self, tangent: &mut Tangent, q: &[f64]) {
        self.linearize_shifted(tangent, q, 0.0);
    }

    /// Computes the static tangent with a multiple of the mass added, eq. (L15).
    fn linearize_shifted(&self, tangent: &mut Tangent, q: &[f64], shift_1_s2: f64) {
        let joints = self.joint_tangents();
        let stations: &[Wrench] = if self.loaded { &self.stations } else { &[] };
        let surroundings = Surroundings { root: &self.root, stations, joints: &joints };
        tangent.linearize_shifted(&self.model, &self.work, q, surroundings, shift_1_s2);
    }

    /// Springs of the joints at the last residual, per body.
    pub(crate) fn joint_tangents(&self) -> Vec<JointTangent> {
        let mut joints = vec![JointTangent::HELD; self.model.bodies.len()];
        for joint in self.forces.joints().iter().filter(|joint| !joint.held) {
            joints[joint.body] = JointTangent::one_freedom(self.tangents[joint.body].stiffness);
        }
        for joint in self.forces.spatial() {
            let spring = joint.attitude().map_or_else(Matrix3::zeros, |spring| spring.stiffness(&self.work));
            joints[joint.body] = JointTangent { free: true, stiffness: spring };
        }
        for joint in self.spatial.iter().filter(|joint| joint.held) {
            joints[joint.body] = JointTangent::HELD;
        }
        joints
    }
}

impl Study<'_> {
    /// Initialises at `time_s` and finds the static equilibrium under the current inputs: gravity, root motion, station loads, motors and
    /// latches. Afterwards, rates and accelerations are zero, and the outputs are those of the equilibrium.
    ///
    /// Starts from the unstrained model at its initial angles; prescribed joints keep their angle at `time_s`. A rotating root loads the
    /// wing by centrifugal and Euler forces.
    ///
    /// The equilibrium is the one at the end of the load path, stable or not: see [`Study::stability`].
    pub fn equilibrium(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        self.rest(time_s, holding, Search::default()).map(|rest| rest.effort)
    }

    /// Finds an equilibrium like [`Study::equilibrium`], with a choice of the path and of the treatment of an unstable state.
    pub fn rest(&mut self, time_s: f64, holding: Holding, search: Search) -> Result<Rest, PlantError> {
        self.quest = Quest { search, ..Quest::default() };
        let effort = self.come_to_rest(time_s, holding);
        let Quest { mut departure, path, corrections_rad, .. } = std::mem::take(&mut self.quest);
        let mut effort = effort?;
        self.refuse_unbalanced_flight(time_s)?;
        let mut stability = None;
        if search.branch == Branch::Stable {
            let mut judged = self.stability()?;
            let directions = judged.static_directions();
            if directions > 0 && self.system.flying_joints().is_empty() {
                (effort, judged) = self.leave_in_air(time_s, holding, judged)?;
                departure = departure.or(Some(Departure::Unstable(directions)));
            }
            stability = Some(judged);
        }
        Ok(Rest { effort, departure, path, stability, corrections_rad })
    }

    /// Continues from the current equilibrium, which is statically unstable, to a stable one downhill: hinges with only aerodynamic
    /// stiffness leave their angle to either side in steps proportional to the torques, eq. (Q6).
    ///
    /// # Errors
    /// If no stable equilibrium is found on either side.
    fn leave_in_air(
        &mut self,
        time_s: f64,
        holding: Holding,
        found: Stability,
    ) -> Result<(Effort, Stability), PlantError> {
        let angles: Vec<f64> = self
            .system
            .equations
            .forces
            .joints()
            .iter()
            .map(|joint| self.system.state.now.q[joint.coordinate])
            .collect();
        let hinges =
            if self.system.air.is_some() && holding == Holding::AsReleased { self.free_hinges() } else { Vec::new() };
        for side in [0.0, -BESIDE_RAD, BESIDE_RAD] {
            if hinges.is_empty() {
                break;
            }
            self.start_at_rest(time_s);
            if side != 0.0 {
                for &hinge in &hinges {
                    let coordinate = self.system.equations.forces.joints()[hinge].coordinate;
                    self.system.state.now.q[coordinate] = angles[hinge] + side * self.scale(hinge);
                }
            }
            let Ok(effort) = self.coast(time_s, &hinges) else { continue };
            self.conclude_rest(time_s)?;
            let judged = self.stability()?;
            if judged.not_judged.is_none() && judged.static_directions() == 0 {
                return Ok((effort, judged));
            }
        }
        let cause = format!(
            "the equilibrium on the load path is unstable{}, and no stable equilibrium was found near it; accept it \
             with the branch \"path\", or use other start angles",
            found.growing.first().map_or(String::new(), |growth| {
                let name = &self.system.machine.bodies[growth.body].name;
                format!(" (body {name:?} leaves it with {:.4} 1/s)", growth.eigenvalue_1_s.re)
            })
        );
        Err(PlantError::Equilibrium { time_s, reached: 1.0, tried: 1.0, cause, diverges_m_s: None })
    }

    pub(super) fn come_to_rest(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        self.system.refuse_sliding("static equilibrium")?;
        self.system.refuse_no_slip("static equilibrium")?;
        self.start_at_rest(time_s);
        let effort = self.settle_in_air(time_s, holding)?;
        self.conclude_rest(time_s)?;
        Ok(effort)
    }

    /// Starts without initial rates: the aerodynamic loads are static ones from the first search on.
    fn start_at_rest(&mut self, time_s: f64) {
        self.system.start(time_s);
        self.system.equations.stand(&mut self.system.state.now.v);
    }

    fn conclude_rest(&mut self, time_s: f64) -> Result<(), PlantError> {
        self.system.equations.stand(&mut self.system.state.now.v);
        self.system.state.now.a.fill(0.0);
        // the multipliers are stored with the coordinates in the search, but with the accelerations in a motion
        let tree = self.system.equations.model.tree_coordinates();
        let now = &mut self.system.state.now;
        now.a[tree..].copy_from_slice(&now.q[tree..]);
        now.q[tree..].fill(0.0);
        self.system.conclude_start(time_s)?;
        // the remaining accelerations are round-off multiplied by the stiffness
        self.stand_still();
        Ok(())
    }

    /// Initialises at `time_s` without loads, gravity and root motion, which are set to zero, with zero rates at the initial angles: the
    /// state for modes of the bare structure.
    pub fn undeformed(&mut self, time_s: f64) -> Result<(), PlantError> {
        *self.system.state.inputs.root_mut() = RootMotion::default();
        self.system.state.inputs.stations_mut().fill(Wrench::default());
        self.system.state.inputs.wind_m_s_mut().fill(0.0);
        self.start_at_rest(time_s);
        self.system.conclude_start(time_s)?;
        self.stand_still();
        Ok(())
    }

    /// Sets the accelerations to zero and updates the outputs.
    fn stand_still(&mut self) {
        let tree = self.system.equations.model.tree_coordinates();
        for point in [&mut self.system.state.now, &mut self.system.state.start, &mut self.system.state.ahead] {
            point.a[..tree].fill(0.0);
            point.auxiliary[..tree].fill(0.0);
        }
        self.system.evaluate();
    }

    /// Replaces the initial coordinates by those of the equilibrium.
    ///
    /// A joint whose equilibrium would be at the angle of its enabled latch or beyond cannot reach it: the latch closes, and the search is
    /// repeated with the closed latch. A rigid latch then holds the joint at the edge of its capture range. If no equilibrium is found,
    /// released joints move to the latch or end stop towards which all loads together push them.
    pub(crate) fn settle_at_rest(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        let mut start = self.system.state.now.q.clone();
        for _ in 0..MAXIMUM_SEARCHES {
            self.system.state.now.q.copy_from_slice(&start);
            let effort = match self.search(time_s, holding) {
                Ok(effort) => effort,
                Err(_) if self.stop_pushed_joints(&mut start, time_s, holding) => {
                    self.system.configure();
                    continue;
                }
                Err(error) => return Err(error),
            };
            let mut caught = false;
            for (joint, memory) in self.system.equations.forces.joints().iter().zip(&mut self.system.state.joints) {
                let c = joint.coordinate;
                caught |= joint.stops_at_rest(&mut start[c], self.system.state.now.q[c], memory);
            }
            if !caught {
                return Ok(effort);
            }
            self.system.configure();
        }
        let cause = format!(
            "latches or end stops still change their state after {MAXIMUM_SEARCHES} searches for the \
                             equilibrium"
        );
        Err(PlantError::Equilibrium { time_s, reached: 1.0, tried: 1.0, cause, diverges_m_s: None })
    }

    /// Finds the equilibrium on the path from the initial coordinates, with the latches in their current state.
    fn search(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        let now = &mut self.system.state.now;
        let equations = &mut self.system.equations;
        equations.branch_s = time_s;
        equations.prescribe(time_s, &mut now.q, &mut now.v, &mut now.a);
        if holding == Holding::Stopped {
            for joint in equations.forces.joints_mut().iter_mut().filter(|joint| !joint.is_latched()) {
                joint.held = true;
            }
        }
        // free bodies are held: their balance is found by trimming, eq. (Q8)
        for joint in &mut equations.spatial {
            joint.held = joint.flies;
        }
        let dense = self.dense_tangent();
        let (now, equations) = (&mut self.system.state.now, &mut self.system.equations);
        let mut at_rest = AtRest::new(equations, dense, time_s, &now.q);
        let quest = &mut self.quest;
        let settings = Settings::default();
        quest.path.clear();
        let mut found = match quest.search.path {
            LoadPath::Load => equilibrium::find(&mut at_rest, &mut now.q, settings),
            LoadPath::ArcLength => arc_length::trace(&mut at_rest, &mut now.q, settings).map(|(effort, path)| {
                quest.path = path;
                effort
            }),
        };
        if quest.search.branch != Branch::Path {
            (found, quest.departure) = at_rest.stabilise(&mut now.q, found);
        }
        if found.is_err() {
            // the last attempt had a part of the loads
            at_rest.load(1.0);
        }
        let Target { forces, .. } = at_rest.target;
        self.system.equations.forces = forces;
        for joint in &mut self.system.equations.spatial {
            joint.held = false;
        }
        self.system.configure();
        let effort = found.map_err(|error| self.no_equilibrium(time_s, &error))?;
        self.check_loops(time_s)?;
        Ok(effort)
    }

    /// The dense tangent of a machine with sliding joints.
    pub(super) fn dense_tangent(&self) -> Option<DenseTangent> {
        self.system.machine.sliding_joint()?;
        Some(DenseTangent::new(&self.system.equations, self.system.freedoms()))
    }

    /// Returns an error for an equilibrium supported only by stretched penalty springs of closed loops; the search finds such a state for a
    /// linkage that can move freely.
    fn check_loops(&self, time_s: f64) -> Result<(), PlantError> {
        let limit_m = TORN * self.system.equations.model.reference_length_m;
        let described = self.system.machine.closures.iter().filter(|closure| !closure.rigid);
        for (closure, described) in self.system.equations.model.closures.iter().zip(described) {
            let gap_m = closure.gap(&self.system.equations.work).position_m.norm();
            if gap_m > limit_m {
                let cause = format!(
                    "loop {:?} is open by {gap_m:.3e} m; lock or restrain the linkage (release = false, a spring, a \
                     latch) or increase the loop's stiffness",
                    described.name
                );
                return Err(PlantError::Equilibrium { time_s, reached: 0.0, tried: 1.0, cause, diverges_m_s: None });
            }
        }
        Ok(())
    }

    fn no_equilibrium(&self, time_s: f64, error: &NoEquilibrium) -> PlantError {
        let cause = match error.cause {
            Cause::Singular(coordinate) => {
                format!("no stiffness resists a motion of {}", self.coordinate_name(coordinate))
            }
            other @ (Cause::NotConverged { .. }
            | Cause::NotFinite(_)
            | Cause::NoStableState(_)
            | Cause::PathTooLong(_)) => other.to_string(),
        };
        PlantError::Equilibrium { time_s, reached: error.reached, tried: error.tried, cause, diverges_m_s: None }
    }

    /// Name of the joint or body of a coordinate.
    fn coordinate_name(&self, coordinate: usize) -> String {
        let bodies = &self.system.equations.model.bodies;
        for (body, described) in bodies.iter().zip(&self.system.machine.bodies) {
            if body.joint.range().contains(&coordinate) {
                let remedy = match body.joint.kind.freedoms() {
                    1 => "add a spring, close its latch, or lock it (release = false)",
                    6 => {
                        "its body is held by loops only, which leave a motion free; add a spring to a joint of the \
                         loops, or lock one (release = false)"
                    }
                    _ => "add a spring",
                };
                return format!("joint {:?}: {remedy}", described.joint.name);
            }
            if let Some(modal) = body.modal.as_ref().filter(|modal| modal.range().contains(&coordinate)) {
                return format!("body {:?} in mode {}", described.name, coordinate - modal.coordinate + 1);
            }
            let elements =
                &self.system.equations.model.elements[body.first_element..body.first_element + body.elements];
            if let Some(i) = elements.iter().position(|element| element.range().contains(&coordinate)) {
                return format!("body {:?} in element {}", described.name, i + 1);
            }
        }
        format!("coordinate {coordinate}")
    }
}
