//! Equilibrium of the machine at rest: what the loads do without time.

use crate::actuation::latch::Latch;
use crate::load::{RootMotion, Wrench};
use crate::multibody::norm::kinematic_norm;
use crate::multibody::tangent::{JointTangent, Surroundings, Tangent};
use crate::plant::Plant;
use crate::plant::equations::{Equations, JointEquations};
use crate::plant::face::PlantError;
use crate::solve::equilibrium::{self, Cause, Effort, NoEquilibrium, Settings, StaticEquations};
use crate::solve::{EquationsOfMotion, Singular};

/// Gap of a closed loop at rest over the machine's length beyond which it is no loop any more.
const TORN: f64 = 0.01;

/// What holds the fold joints while the machine settles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holding {
    /// Their release inputs: a released joint turns until its drive and latch balance the loads. If its enabled latch lies
    /// on the way, it closes.
    AsReleased,
    /// Stoppers hold all joints at their start angles, but those whose latch is closed.
    Stopped,
}

/// Loads and joints of the case asked for; the search scales them.
struct Target {
    root: RootMotion,
    stations: Vec<Wrench>,
    air: Vec<Wrench>,
    joints: Vec<JointTarget>,
}

/// One revolute joint of the case asked for.
struct JointTarget {
    start_rad: f64,
    neutral_rad: f64,
    constant_n_m: f64,
    external_n_m: f64,
    latch: Option<Latch>,
}

impl Target {
    /// The case that the equations stand for, from the coordinates `start`.
    fn of(equations: &Equations, time_s: f64, start: &[f64]) -> Self {
        let joint = |joint: &JointEquations| JointTarget {
            start_rad: start[joint.coordinate],
            neutral_rad: joint.slew.at(time_s).0,
            constant_n_m: joint.drive.constant_torque_n_m,
            external_n_m: joint.external_n_m,
            latch: joint.latch,
        };
        Self {
            root: equations.root,
            stations: equations.stations[..equations.load_stations].to_vec(),
            air: equations.air.as_ref().map_or(Vec::new(), |air| air.to.clone()),
            joints: equations.joints.iter().map(joint).collect(),
        }
    }
}

/// The equations of motion at rest, eq. (L1), with loads that can be scaled, eq. (L8).
struct AtRest<'a> {
    equations: &'a mut Equations,
    tangent: Tangent,
    target: Target,
    time_s: f64,
    zero: Vec<f64>,
}

impl StaticEquations for AtRest<'_> {
    fn coordinates(&self) -> usize {
        self.zero.len()
    }

    fn load(&mut self, factor: f64) {
        let Target { root, stations, air, joints } = &self.target;
        self.equations.root = RootMotion {
            gravity_m_s2: root.gravity_m_s2 * factor,
            acceleration_m_s2: root.acceleration_m_s2 * factor,
            angular_velocity_rad_s: root.angular_velocity_rad_s * factor.sqrt(),
            angular_acceleration_rad_s2: root.angular_acceleration_rad_s2 * factor,
        };
        for (scaled, load) in self.equations.stations.iter_mut().zip(stations) {
            *scaled = Wrench { force_n: load.force_n * factor, moment_n_m: load.moment_n_m * factor };
        }
        if let Some(loads) = &mut self.equations.air {
            loads.scale(air, factor);
        }
        for (joint, target) in self.equations.joints.iter_mut().zip(joints) {
            let between = |end: f64| target.start_rad + factor * (end - target.start_rad);
            joint.slew.from_rad = between(target.neutral_rad);
            joint.slew.target_rad = joint.slew.from_rad;
            joint.drive.constant_torque_n_m = factor * target.constant_n_m;
            joint.external_n_m = factor * target.external_n_m;
            if let (Some(latch), Some(target)) = (&mut joint.latch, &target.latch) {
                latch.angle_rad = between(target.angle_rad);
            }
        }
    }

    fn residual(&mut self, q: &[f64], residual: &mut [f64]) {
        self.equations.residual(self.time_s, q, &self.zero, &self.zero, residual);
    }

    fn factorize(&mut self, q: &[f64]) -> Result<(), Singular> {
        self.equations.linearize_at_rest(&mut self.tangent, q);
        self.tangent.factorize(&self.equations.model).map_err(|singular| Singular { coordinate: singular.coordinate })
    }

    fn solve(&mut self, x: &mut [f64]) {
        self.tangent.solve(&self.equations.model, x);
        Tangent::to_coordinates(&self.equations.model, &self.equations.work, x);
    }

    fn norm(&mut self, change: &[f64]) -> f64 {
        kinematic_norm(&self.equations.model, &mut self.equations.work, change)
    }

    fn project(&mut self, q: &mut [f64]) {
        let mut rates = vec![0.0; q.len()];
        let mut second = rates.clone();
        EquationsOfMotion::project(self.equations, q, &mut rates, &mut second);
    }
}

impl Equations {
    /// Exact tangent at rest about `q`, the configuration of the last residual.
    pub(super) fn linearize_at_rest(&self, tangent: &mut Tangent, q: &[f64]) {
        let joints = self.joint_tangents();
        let stations: &[Wrench] = if self.loaded { &self.stations } else { &[] };
        let surroundings = Surroundings { root: &self.root, stations, joints: &joints };
        tangent.linearize(&self.model, &self.work, q, surroundings);
    }

    /// Springs of the joints at the last residual, per body.
    pub(super) fn joint_tangents(&self) -> Vec<JointTangent> {
        let mut joints = vec![JointTangent::HELD; self.model.bodies.len()];
        for joint in self.joints.iter().filter(|joint| !joint.held) {
            joints[joint.body] = JointTangent::hinge(self.tangents[joint.body].stiffness_n_m_rad);
        }
        for joint in &self.spatial {
            joints[joint.body] = JointTangent { free: true, stiffness_n_m_rad: joint.stiffness(&self.work) };
        }
        joints
    }
}

impl Plant {
    /// Initialises at `time_s` and brings the machine to rest under the present inputs: gravity, root motion, station
    /// loads, drives and latches. Rates and accelerations are zero afterwards, and the outputs belong to the
    /// equilibrium.
    ///
    /// Starts from the unstrained machine at its start angles; prescribed joints keep their angle of `time_s`. A root
    /// that turns loads the wing by its centrifugal and Euler forces.
    pub fn equilibrium(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        self.start(time_s);
        let effort = self.settle_in_air(time_s, holding)?;
        self.state.now.v.fill(0.0);
        self.state.now.a.fill(0.0);
        self.conclude_start(time_s)?;
        // what is left of the accelerations is round-off times stiffness
        self.stand_still();
        Ok(effort)
    }

    /// Initialises at `time_s` without loads, gravity and root motion, which are set to zero, and stands still at the
    /// start angles: the state about which the modes of the bare structure are meant.
    pub fn undeformed(&mut self, time_s: f64) -> Result<(), PlantError> {
        self.state.inputs.root = RootMotion::default();
        self.state.inputs.stations.fill(Wrench::default());
        self.state.inputs.wind_m_s.fill(0.0);
        self.start(time_s);
        self.state.now.v.fill(0.0);
        self.conclude_start(time_s)?;
        self.stand_still();
        Ok(())
    }

    /// Takes away the accelerations, with the outputs.
    fn stand_still(&mut self) {
        for point in [&mut self.state.now, &mut self.state.start, &mut self.state.ahead] {
            point.a.fill(0.0);
            point.auxiliary.fill(0.0);
        }
        self.evaluate();
    }

    /// Replaces the start coordinates by those of the equilibrium.
    ///
    /// A joint that would come to rest beyond the angle of its enabled latch cannot get there: the latch closes, and
    /// the search begins anew with it.
    pub(super) fn settle_at_rest(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        let start = self.state.now.q.clone();
        loop {
            self.state.now.q.copy_from_slice(&start);
            let effort = self.search(time_s, holding)?;
            let mut caught = false;
            for (joint, state) in self.equations.joints.iter().zip(&mut self.state.joints) {
                let passes = |angle_rad: f64| joint.latch.as_ref().is_some_and(|latch| latch.gap_rad(angle_rad) < 0.0);
                let (before, after) = (start[joint.coordinate], self.state.now.q[joint.coordinate]);
                if state.latch.enabled && !state.latch.closed && passes(after) && !passes(before) {
                    state.latch.closed = true;
                    caught = true;
                }
            }
            if !caught {
                return Ok(effort);
            }
            self.configure();
        }
    }

    /// The equilibrium on the path from the start coordinates, with the latches as they are.
    fn search(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        let now = &mut self.state.now;
        let equations = &mut self.equations;
        equations.branch_s = time_s;
        equations.prescribe(time_s, &mut now.q, &mut now.v, &mut now.a);
        if holding == Holding::Stopped {
            for joint in equations.joints.iter_mut().filter(|joint| !joint.latched) {
                joint.held = true;
            }
        }
        let target = Target::of(equations, time_s, &now.q);
        let mut at_rest =
            AtRest { tangent: Tangent::new(&equations.model), zero: vec![0.0; now.q.len()], target, time_s, equations };
        let found = equilibrium::find(&mut at_rest, &mut now.q, Settings::default());
        let latches: Vec<Option<Latch>> = at_rest.target.joints.iter().map(|joint| joint.latch).collect();
        for (joint, latch) in self.equations.joints.iter_mut().zip(latches) {
            joint.latch = latch;
        }
        self.configure();
        let effort = found.map_err(|error| self.no_equilibrium(time_s, &error))?;
        self.check_loops(time_s)?;
        Ok(effort)
    }

    /// Refuses a state of rest that only the stretched penalties of closed loops hold, as the search finds it for a
    /// linkage that nothing keeps from turning.
    fn check_loops(&self, time_s: f64) -> Result<(), PlantError> {
        let limit_m = TORN * self.equations.model.reference_length_m;
        for (closure, described) in self.equations.model.closures.iter().zip(&self.machine.closures) {
            let gap_m = closure.gap(&self.equations.work).position_m.norm();
            if gap_m > limit_m {
                let cause = format!(
                    "loop {:?} is torn open by {gap_m:.3e} m; hold the linkage (release = false, a spring, a latch) or \
                     give the loop more stiffness",
                    described.name
                );
                return Err(PlantError::Equilibrium { time_s, reached: 0.0, tried: 1.0, cause });
            }
        }
        Ok(())
    }

    fn no_equilibrium(&self, time_s: f64, error: &NoEquilibrium) -> PlantError {
        let cause = match error.cause {
            Cause::Singular(coordinate) => format!("nothing resists a motion of {}", self.coordinate_name(coordinate)),
            other => other.to_string(),
        };
        PlantError::Equilibrium { time_s, reached: error.reached, tried: error.tried, cause }
    }

    /// Joint or body that a coordinate belongs to, in words.
    fn coordinate_name(&self, coordinate: usize) -> String {
        let bodies = &self.equations.model.bodies;
        for (body, described) in bodies.iter().zip(&self.machine.bodies) {
            let joint = body
                .hinge
                .map(|hinge| hinge.coordinate..hinge.coordinate + 1)
                .or_else(|| body.parameters.map(|joint| joint.coordinate..joint.coordinate + joint.kind.parameters()));
            if joint.is_some_and(|range| range.contains(&coordinate)) {
                let remedy = if body.hinge.is_some() {
                    "give it a spring, close its latch, or hold it (release = false)"
                } else if body.parameters.is_some_and(|joint| joint.kind.freedoms() == 6) {
                    "a free body has no place of rest"
                } else {
                    "give it a spring"
                };
                return format!("joint {:?}: {remedy}", described.joint.name);
            }
            let elements = &self.equations.model.elements[body.first_element..body.first_element + body.elements];
            if let Some(i) =
                elements.iter().position(|element| (element.coordinate..element.coordinate + 4).contains(&coordinate))
            {
                return format!("body {:?} in element {}", described.name, i + 1);
            }
        }
        format!("coordinate {coordinate}")
    }
}
