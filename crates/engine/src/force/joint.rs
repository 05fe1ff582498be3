//! Forces on one joint, and their sum.

use crate::force::attitude::AttitudeSpring;
use crate::force::borders::Borders;
use crate::force::dc_motor::Armature;
use crate::force::drive::DriveTorque;
use crate::force::external::External;
use crate::force::friction::SlippingBrake;
use crate::force::generator::{Generator, GeneratorState};
use crate::force::latch::{CatchingLatch, Latch};
use crate::force::memory::{JointMemory, Told};
use crate::force::motor::Motor;
use crate::force::prescribed::Law;
use crate::force::spring::Spring;
use crate::force::{Force, Here, Moving, Outcome, Place, Push, Stored};
use crate::load::Wrench;
use crate::multibody::factor::FreedomTangent;
use crate::multibody::joint::{Joint, JointKind};
use crate::multibody::kinematics::Motion;
use crate::multibody::{Model, Workspace};
use crate::solve::Powers;
use crate::solve::point::Point;
use nalgebra::Vector3;
use std::ops::Range;

/// Forces on the degrees of freedom of a joint.
#[derive(Debug, Clone)]
pub struct JointForces {
    /// Body that the joint connects to its parent.
    pub body: usize,
    /// Index of the joint angle in `q`, or of the first of the joint's parameters.
    pub coordinate: usize,
    /// Number of degrees of freedom.
    freedoms: usize,
    /// Whether some force holds the joint: its angle then does not follow from torques.
    pub held: bool,
    /// Whether motor, spring and damper act: for joints that are neither locked nor prescribed.
    pub driven: bool,
    /// Constraint torque that holds the joint, from the last residual, in N·m; 0 for a free joint.
    pub holding_n_m: f64,
    /// Forces in the order in which they are added.
    forces: Vec<Force>,
}

impl JointForces {
    /// Creates the forces on a joint; a joint with one degree of freedom is held until [`JointForces::recall`].
    pub fn new(body: usize, joint: &Joint, forces: Vec<Force>) -> Self {
        Self {
            body,
            coordinate: joint.coordinate,
            freedoms: joint.kind.freedoms(),
            held: !joint.kind.is_redundant(),
            driven: forces.iter().any(|force| matches!(force, Force::Motor(_))),
            holding_n_m: 0.0,
            forces,
        }
    }

    /// Restores the state of the forces from the memory, including whether the joint is held.
    pub fn recall(&mut self, memory: &JointMemory) {
        self.held = self.is_held_in(memory);
        self.forces.iter_mut().for_each(|force| force.recall(memory));
    }

    /// Whether some force holds the joint, according to its memory.
    pub fn is_held_in(&self, memory: &JointMemory) -> bool {
        self.forces.iter().any(|force| force.holds(memory))
    }

    fn here<'a>(&self, time_s: f64, branch_s: f64, q: &[f64], v: &'a [f64], work: &'a Workspace) -> Here<'a> {
        let c = self.coordinate;
        Here { time_s, branch_s, angle_rad: q[c], rate_rad_s: v[c], v, work }
    }

    /// Subtracts the forces, and the constraint torque of a held joint, from the residual rows of the joint; adds their tangent.
    pub fn apply(
        &mut self,
        time_s: f64,
        q: &[f64],
        v: &[f64],
        work: &Workspace,
        residual: &mut [f64],
    ) -> FreedomTangent {
        let rows = &mut residual[self.rows()];
        let here = self.here(time_s, time_s, q, v, work);
        let tangent = FreedomTangent { free: !self.held, stiffness: 0.0, damping: 0.0 };
        let mut push = Push { torque_n_m: 0.0, tangent, rows };
        self.forces.iter().for_each(|force| force.push(&here, &mut push));
        if self.freedoms == 1 {
            let left_n_m = push.rows[0] - push.torque_n_m;
            (push.rows[0], self.holding_n_m) = if self.held { (0.0, left_n_m) } else { (left_n_m, 0.0) };
        }
        push.tangent
    }

    /// Whether another joint has equal forces, in equal states.
    pub fn has_forces_of(&self, other: &Self) -> bool {
        self.forces == other.forces
    }

    /// Rows of the joint's degrees of freedom in a residual.
    pub fn rows(&self) -> Range<usize> {
        self.coordinate..self.coordinate + self.freedoms
    }

    /// Sum of all torques on the outer body about `+θ` in N·m, NOTATION eqs. (A1) and (A3).
    fn torque_n_m(&self, time_s: f64, motion: Motion, work: &Workspace) -> f64 {
        let mut push = Push { torque_n_m: 0.0, tangent: FreedomTangent::HELD, rows: &mut [] };
        let here = self.here(time_s, time_s, motion.q, motion.v, work);
        self.forces.iter().for_each(|force| force.push(&here, &mut push));
        push.torque_n_m
    }

    /// Adds work and dissipation of the joint's forces, NOTATION eq. (A5).
    pub fn add_powers(
        &self,
        [time_s, branch_s]: [f64; 2],
        q: &[f64],
        v: &[f64],
        work: &Workspace,
        powers: &mut Powers,
    ) {
        let here = self.here(time_s, branch_s, q, v, work);
        let mut own = Powers::default();
        self.forces.iter().for_each(|force| force.add_powers(&here, self.holding_n_m, &mut own));
        powers.work += own.work;
        powers.dissipated += own.dissipated;
    }

    /// Power of the work per rate of the motor's command, which it follows at once, in N·m.
    pub fn work_per_command_rate_n_m(
        &self,
        [time_s, branch_s]: [f64; 2],
        [q, v]: [&[f64]; 2],
        work: &Workspace,
    ) -> f64 {
        let here = self.here(time_s, branch_s, q, v, work);
        self.motor().map_or(0.0, |motor| motor.work_per_slew_rate_n_m(&here))
    }

    /// Energy stored in the joint's forces.
    pub fn stored(&self, time_s: f64, q: &[f64], work: &Workspace) -> Stored {
        let c = self.coordinate;
        let here = Here { time_s, branch_s: time_s, angle_rad: q[c], rate_rad_s: 0.0, v: &[], work };
        let mut stored = Stored::default();
        self.forces.iter().for_each(|force| force.add_stored(&here, &mut stored));
        stored
    }

    /// Next kink after `time_s` whose time is known in advance, in s.
    pub fn next_kink_s(&self, time_s: f64) -> f64 {
        self.forces.iter().map(|force| force.next_kink_s(time_s)).fold(f64::INFINITY, f64::min)
    }

    /// Whether such a kink is exactly at `time_s`.
    pub fn kink_at(&self, time_s: f64) -> bool {
        self.forces.iter().any(|force| force.kink_at(time_s))
    }

    /// Selects the pieces of forces with kinks for a state, eq. (T12); returns whether any piece has changed.
    pub fn move_pieces(&mut self, time_s: f64, q: &[f64], v: &[f64]) -> bool {
        if self.held {
            return false;
        }
        let (angle_rad, rate_rad_s) = (q[self.coordinate], v[self.coordinate]);
        let mut moved = false;
        for force in &mut self.forces {
            moved |= force.move_piece(time_s, angle_rad, rate_rad_s);
        }
        moved
    }

    /// Deselects the pieces of forces with kinks, which then follow from the state again.
    pub fn drop_pieces(&mut self) {
        self.forces.iter_mut().for_each(Force::drop_piece);
    }

    /// Keeps the smooth pieces on which the forces lie at a state, as [`Force::hold`], until [`JointForces::let_go`].
    pub fn hold(&mut self, times_s: [f64; 2], q: &[f64], v: &[f64]) {
        let (angle_rad, rate_rad_s) = (q[self.coordinate], v[self.coordinate]);
        self.forces.iter_mut().for_each(|force| force.hold(times_s, angle_rad, rate_rad_s));
    }

    /// Keeps the pieces of the same joint of another machine.
    pub fn hold_as(&mut self, other: &Self) {
        self.forces.iter_mut().zip(&other.forces).for_each(|(force, other)| force.hold_as(other));
    }

    /// Ends [`JointForces::hold`].
    pub fn let_go(&mut self) {
        self.forces.iter_mut().for_each(Force::let_go);
    }

    /// Whether a force changes with time itself at a time, apart from inputs and prescribed motions.
    pub fn moves_at(&self, time_s: f64) -> bool {
        self.forces.iter().any(|force| force.moves_at(time_s))
    }

    /// Kink in which a force of a joint that is not held lies at a state to round-off, in words.
    pub fn kink(&self, at: &Point) -> Option<&'static str> {
        let Moving { angle_rad, rate_rad_s, .. } = self.moving(at);
        self.forces.iter().filter(|_| !self.held).find_map(|force| force.kink(at.time_s, angle_rad, rate_rad_s))
    }

    /// Replaces the joint's nonlinear forces by their tangents at a state.
    pub fn linearize(&mut self, time_s: f64, q: &[f64], v: &[f64]) {
        let (angle_rad, rate_rad_s) = (q[self.coordinate], v[self.coordinate]);
        self.forces.iter_mut().for_each(|force| force.linearize(time_s, angle_rad, rate_rad_s));
    }

    /// Restores the nonlinear forces.
    pub fn drop_tangents(&mut self) {
        self.forces.iter_mut().for_each(Force::drop_tangent);
    }

    /// Motion of a joint with one degree of freedom at a point.
    pub fn moving(&self, at: &Point) -> Moving {
        let c = self.coordinate;
        Moving { angle_rad: at.q[c], rate_rad_s: at.v[c], acceleration_rad_s2: at.a[c] }
    }

    /// Number of indicators of the joint's forces.
    pub fn indicators(&self) -> usize {
        self.forces.iter().map(Force::indicators).sum()
    }

    /// Forces with the numbers of their indicators in the joint.
    fn numbered(&self) -> impl Iterator<Item = (&Force, Range<usize>)> {
        self.forces.iter().scan(0, |first, force| {
            let numbers = *first..*first + force.indicators();
            *first = numbers.end;
            Some((force, numbers))
        })
    }

    /// Force that an indicator belongs to, and the indicator's number within that force.
    fn indicating(&self, indicator: usize) -> Option<(&Force, usize)> {
        self.numbered()
            .find(|(_, numbers)| numbers.contains(&indicator))
            .map(|(force, at)| (force, indicator - at.start))
    }

    /// Whether a motion from this start may cross an indicator.
    pub fn is_armed(&self, indicator: usize, start: &Moving, memory: &JointMemory) -> bool {
        let sees = |force: &Force| !self.held || matches!(force, Force::Borders(_));
        self.indicating(indicator).is_some_and(|(force, i)| sees(force) && force.is_armed(i, start, memory))
    }

    /// Signed distance of an indicator in rad for a motion from `start_rad`: an event occurs when it falls through zero.
    pub fn distance_rad(&self, indicator: usize, start_rad: f64, place: &impl Place, memory: &JointMemory) -> f64 {
        self.indicating(indicator).map_or(f64::INFINITY, |(force, i)| force.distance_rad(i, start_rad, place, memory))
    }

    /// Rate at which an indicator decreases, in rad/s; never negative.
    pub fn closing_rad_s(&self, indicator: usize, at: &Moving, memory: &JointMemory) -> f64 {
        self.indicating(indicator).map_or(0.0, |(force, i)| force.closing_rad_s(i, at, memory))
    }

    /// Whether a crossing must be located on its far side.
    pub fn lands_beyond(&self, indicator: usize) -> bool {
        self.indicating(indicator).is_some_and(|(force, _)| force.lands_beyond())
    }

    /// Initialises the memory for the start of a run.
    pub fn begin(&self, start: &Point, memory: &mut JointMemory) {
        self.forces.iter().for_each(|force| force.begin(&self.moving(start), memory));
    }

    /// Marks the indicators that were already crossed at the start of a step.
    pub fn mark_overdue(&self, at: &Point, memory: &mut JointMemory) {
        for (force, numbers) in self.numbered() {
            // the stop itself may have passed a bound, and a prescribed motion passes borders
            let sees = !self.held || matches!(force, Force::Watch(_) | Force::Borders(_));
            for number in numbers.clone().filter(|_| sees) {
                if force.is_overdue(number - numbers.start, &self.moving(at), memory) {
                    memory.crossed |= 1 << number;
                }
            }
        }
    }

    /// Performs the transitions of the indicators that the step has crossed.
    pub fn make_transitions(&self, at: &Point, memory: &mut JointMemory) -> Outcome {
        let crossed = std::mem::take(&mut memory.crossed);
        let mut sum = Outcome::default();
        for (force, numbers) in self.numbered() {
            for number in numbers.clone().filter(|number| crossed & (1 << number) != 0) {
                sum.add(force.transition(number - numbers.start, at.time_s, &self.moving(at), memory));
            }
        }
        sum
    }

    /// Applies changed inputs, including crossings at the current instant.
    pub fn take_inputs(&self, told: &Told, now: &Point, memory: &mut JointMemory) -> Outcome {
        let crossed = std::mem::take(&mut memory.crossed);
        let mut sum = Outcome::default();
        for (force, numbers) in self.numbered() {
            let own = (crossed >> numbers.start) & ((1 << numbers.len()) - 1);
            sum.add(force.take_inputs(told, &self.moving(now), own, memory));
        }
        sum
    }

    /// Whether the bound of a failure has been passed.
    pub fn has_tripped(&self, failure: usize, memory: &JointMemory) -> bool {
        let trips = |force: &Force| matches!(force, Force::Watch(watch) if watch.failure == failure && watch.has_tripped(memory));
        self.forces.iter().any(trips)
    }

    /// Brakes applied by failures.
    pub fn slipping_brakes(&self) -> impl Iterator<Item = &SlippingBrake> {
        self.forces.iter().filter_map(|force| if let Force::Slipping(brake) = force { Some(brake) } else { None })
    }

    /// Brakes applied by failures, mutable.
    pub fn slipping_brakes_mut(&mut self) -> impl Iterator<Item = &mut SlippingBrake> {
        self.forces.iter_mut().filter_map(|force| if let Force::Slipping(brake) = force { Some(brake) } else { None })
    }

    /// Whether some force stores the impulse that stops the joint.
    pub fn keeps_impulses(&self) -> bool {
        self.forces.iter().any(Force::keeps_impulses)
    }

    /// Storage of the impulse that stops the joint at `time_s`, if one of its forces exerts it.
    pub fn impulse_n_m_s<'a>(&self, time_s: f64, memory: &'a mut JointMemory) -> Option<&'a mut f64> {
        let giver = self.forces.iter().find(|force| force.impulse_n_m_s(time_s, memory).is_some())?;
        giver.impulse_n_m_s(time_s, memory)
    }

    /// Whether some force acts differently than assumed on a joint that moves from rest at `from_rad` to rest at `to_rad`. Stops at the
    /// first such force, because its change affects the following ones.
    pub fn stops_at_rest(&self, from_rad: &mut f64, to_rad: f64, memory: &mut JointMemory) -> bool {
        self.forces.iter().any(|force| force.stops_at_rest(from_rad, to_rad, memory))
    }

    /// Coordinate of the first latch or end stop that a joint reaches from `from_rad` in a direction, 1 or -1.
    pub fn ahead_rad(&self, from_rad: f64, direction: f64, memory: &JointMemory) -> Option<f64> {
        let ends = self.forces.iter().filter_map(|force| force.ahead_rad(from_rad, direction, memory));
        ends.min_by(|one, other| (one * direction).total_cmp(&(other * direction)))
    }

    /// Scales the forces to a fraction `factor` of those of `whole`, eq. (L8).
    pub fn scale(&mut self, whole: &Self, start_rad: f64, factor: f64, time_s: f64) {
        let pairs = self.forces.iter_mut().zip(&whole.forces);
        pairs.for_each(|(force, whole)| force.scale(whole, start_rad, factor, time_s));
    }

    /// Completes the joint's wrench on its body, root frame, along its degree of freedom: for a free joint the joint torques or forces
    /// minus the inertia torque of its motor, independent of the last residual. The wrench of a held joint is unchanged.
    pub fn complete_reaction(&self, model: &Model, work: &Workspace, motion: Motion, time_s: f64, on: &mut Wrench) {
        if self.held || model.bodies[self.body].joint.kind == JointKind::Sliding {
            return;
        }
        let (c, joint) = (self.coordinate, &model.bodies[self.body].joint);
        let twists = joint.freedom_twists(&work.joints[self.body]);
        let axis = |row: usize| -> Vector3<f64> { twists.fixed_view::<3, 1>(row, 0).into_owned() };
        // unit axes of a prismatic and of a revolute joint; the other one is zero
        let (slide, hinge) = (axis(0), axis(3));
        let carried = joint.drive_carried * work.joints[self.body].one_freedom().map_or(0.0, |one| one.carrier_rate);
        let along = self.torque_n_m(time_s, motion, work) - joint.drive_inertia * (motion.a[c] + carried);
        on.force_n += slide * (along * slide.norm_squared() - slide.dot(&on.force_n));
        on.moment_n_m += hinge * (along * hinge.norm_squared() - hinge.dot(&on.moment_n_m));
    }
}

/// Access to individual forces, for their parameters and outputs.
impl JointForces {
    fn find<T>(&self, view: impl Fn(&Force) -> Option<&T>) -> Option<&T> {
        self.forces.iter().find_map(view)
    }

    fn find_mut<T>(&mut self, view: impl Fn(&mut Force) -> Option<&mut T>) -> Option<&mut T> {
        self.forces.iter_mut().find_map(view)
    }

    /// Motor, if any.
    pub fn motor(&self) -> Option<&Motor> {
        self.find(|force| if let Force::Motor(motor) = force { Some(motor) } else { None })
    }

    /// Motor, mutable.
    pub fn motor_mut(&mut self) -> Option<&mut Motor> {
        self.find_mut(|force| if let Force::Motor(motor) = force { Some(motor) } else { None })
    }

    /// Borders of the elements along which a sliding joint moves.
    pub fn borders(&self) -> Option<&Borders> {
        self.find(|force| if let Force::Borders(borders) = force { Some(borders) } else { None })
    }

    /// Spring and damper of a joint with one degree of freedom.
    pub fn spring(&self) -> Option<&Spring> {
        self.find(|force| if let Force::Spring(spring) = force { Some(spring) } else { None })
    }

    /// Spring and damper, mutable.
    pub fn spring_mut(&mut self) -> Option<&mut Spring> {
        self.find_mut(|force| if let Force::Spring(spring) = force { Some(spring) } else { None })
    }

    /// External torque, mutable.
    pub fn external_mut(&mut self) -> Option<&mut External> {
        self.find_mut(|force| if let Force::External(external) = force { Some(external) } else { None })
    }

    /// Generator, if any.
    pub fn generator(&self) -> Option<&Generator> {
        self.find(|force| if let Force::Generator(generator) = force { Some(generator) } else { None })
    }

    /// Generator, mutable.
    pub fn generator_mut(&mut self) -> Option<&mut Generator> {
        self.find_mut(|force| if let Force::Generator(generator) = force { Some(generator) } else { None })
    }

    /// Torque and power of the generator at a joint rate.
    pub fn generated(&self, rate_rad_s: f64) -> Option<GeneratorState> {
        self.generator().map(|generator| generator.at(rate_rad_s))
    }

    /// Latch, if any.
    pub fn latch(&self) -> Option<&CatchingLatch> {
        self.find(|force| if let Force::Latch(latch) = force { Some(latch) } else { None })
    }

    /// Parameters of the latch, mutable.
    pub fn latch_mut(&mut self) -> Option<&mut Latch> {
        self.find_mut(|force| if let Force::Latch(latch) = force { Some(&mut latch.latch) } else { None })
    }

    /// Prescribed motion, if any.
    pub fn law(&self) -> Option<&Law> {
        self.find(|force| if let Force::Prescribed(law) = force { Some(law) } else { None })
    }

    /// Spring and damper of a universal or ball joint.
    pub fn attitude(&self) -> Option<&AttitudeSpring> {
        self.find(|force| if let Force::Attitude(spring) = force { Some(spring) } else { None })
    }

    /// Spring and damper of a universal or ball joint, mutable.
    pub fn attitude_mut(&mut self) -> Option<&mut AttitudeSpring> {
        self.find_mut(|force| if let Force::Attitude(spring) = force { Some(spring) } else { None })
    }

    /// Torque of the motor at a state; zero without one.
    pub fn motor_torque(&self, time_s: f64, angle_rad: f64, rate_rad_s: f64) -> DriveTorque {
        self.motor().map_or(DriveTorque::default(), |motor| motor.torque(time_s, angle_rad, rate_rad_s))
    }

    /// Armature of the joint's DC motor, if any.
    pub fn armature(&self) -> Option<&Armature> {
        self.motor()?.armature.as_ref()
    }

    /// Torque of the joint's DC motor in N·m at the rates of all coordinates, or its derivative in time at their accelerations.
    pub fn armature_torque_n_m(&self, rates: &[f64]) -> f64 {
        self.armature().map_or(0.0, |armature| armature.circuit.torque_n_m(rates))
    }

    /// Torque of the joint's spring and damper at a state in N·m.
    pub fn spring_torque_n_m(&self, angle_rad: f64, rate_rad_s: f64) -> f64 {
        self.spring().map_or(0.0, |spring| spring.torque_n_m(angle_rad, rate_rad_s))
    }

    /// External torque in N·m; zero for joints without one.
    pub fn external_torque_n_m(&self) -> f64 {
        self.find(|force| if let Force::External(external) = force { Some(external) } else { None })
            .map_or(0.0, |external| external.torque_n_m)
    }

    /// Torque of the closed elastic latch in N·m.
    pub fn latch_torque_n_m(&self, angle_rad: f64) -> f64 {
        self.latch().filter(|latch| latch.closed).map_or(0.0, |latch| latch.latch.torque_n_m(angle_rad))
    }

    /// Whether the joint has a rigid latch.
    pub fn has_rigid_latch(&self) -> bool {
        self.latch().is_some_and(|latch| latch.latch.is_rigid())
    }

    /// Whether the joint's latch is closed.
    pub fn is_latched(&self) -> bool {
        self.latch().is_some_and(|latch| latch.closed)
    }
}
