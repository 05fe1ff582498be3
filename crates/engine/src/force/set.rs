//! All forces on the joints of a model.

use crate::force::dc_motor::Armature;
use crate::force::joint::JointForces;
use crate::force::memory::JointMemory;
use crate::force::{Place, Stored};
use crate::multibody::Workspace;
use crate::multibody::factor::FreedomTangent;
use crate::solve::Powers;
use crate::solve::continuation::Taken;
use crate::solve::point::Point;

/// Number of points within a step at which it is searched for a crossing that returns.
const CROSSING_SAMPLES: u32 = 8;

/// Forces joint by joint: first of the joints with one degree of freedom, then of those with several.
#[derive(Debug, Clone)]
pub struct Forces {
    list: Vec<JointForces>,
    with_one_freedom: usize,
}

/// An indicator of the forces on a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Indicator {
    /// Index of the joint among those with one degree of freedom.
    pub joint: usize,
    /// Number of the indicator within the joint.
    pub number: usize,
}

impl Forces {
    /// Collects the forces on joints with one degree of freedom and on those with several.
    pub fn new(one_freedom: Vec<JointForces>, several: Vec<JointForces>) -> Self {
        let with_one_freedom = one_freedom.len();
        let list = one_freedom.into_iter().chain(several).collect();
        Self { list, with_one_freedom }
    }

    /// Forces on joints with one degree of freedom, in the order of the bodies.
    pub fn joints(&self) -> &[JointForces] {
        &self.list[..self.with_one_freedom]
    }

    /// Forces on joints with one degree of freedom, mutable.
    pub fn joints_mut(&mut self) -> &mut [JointForces] {
        &mut self.list[..self.with_one_freedom]
    }

    /// Forces on joints with several degrees of freedom, in the order of the bodies.
    pub fn spatial(&self) -> &[JointForces] {
        &self.list[self.with_one_freedom..]
    }

    /// Forces on joints with several degrees of freedom, mutable.
    pub fn spatial_mut(&mut self) -> &mut [JointForces] {
        &mut self.list[self.with_one_freedom..]
    }

    /// Armatures of the DC motors, in the order of their joints.
    pub fn armatures(&self) -> impl Iterator<Item = &Armature> {
        self.joints().iter().filter_map(JointForces::armature)
    }

    /// Armatures of the DC motors, mutable.
    pub fn armatures_mut(&mut self) -> impl Iterator<Item = &mut Armature> {
        self.joints_mut().iter_mut().filter_map(|joint| joint.motor_mut()?.armature.as_mut())
    }

    /// Whether another machine has equal forces on all joints, in equal states.
    pub fn are_those_of(&self, other: &Self) -> bool {
        self.list.len() == other.list.len()
            && self.list.iter().zip(&other.list).all(|(own, other)| own.has_forces_of(other))
    }

    /// Rows of the joints in a residual.
    pub fn rows(&self) -> impl Iterator<Item = usize> {
        self.list.iter().flat_map(JointForces::rows)
    }

    /// Overwrites rates and accelerations of the joints that are held, and also the coordinates of prescribed ones.
    pub fn prescribe(&self, [time_s, branch_s]: [f64; 2], q: &mut [f64], v: &mut [f64], a: &mut [f64]) {
        for joint in self.list.iter().filter(|joint| joint.held) {
            let c = joint.coordinate;
            [q[c], v[c], a[c]] = joint.law().map_or([q[c], 0.0, 0.0], |law| law.at_on(time_s, branch_s));
        }
    }

    /// Subtracts all forces from a residual, and returns their tangents by body.
    pub fn apply(
        &mut self,
        time_s: f64,
        [q, v]: [&[f64]; 2],
        work: &Workspace,
        residual: &mut [f64],
        tangents: &mut [FreedomTangent],
    ) {
        for joint in &mut self.list {
            tangents[joint.body] = joint.apply(time_s, q, v, work, residual);
        }
    }

    /// Adds work and dissipation of all forces, NOTATION eq. (A5).
    pub fn add_powers(&self, times_s: [f64; 2], [q, v]: [&[f64]; 2], work: &Workspace, powers: &mut Powers) {
        self.list.iter().for_each(|joint| joint.add_powers(times_s, q, v, work, powers));
    }

    /// Adds the energy stored in all forces.
    pub fn add_stored(&self, time_s: f64, q: &[f64], work: &Workspace, sum: &mut Stored) {
        for joint in &self.list {
            let stored = joint.stored(time_s, q, work);
            sum.drive += stored.drive;
            sum.elastic += stored.elastic;
        }
    }

    /// Next kink after `time_s` whose time is known in advance, in s: end of a slew, knot of a prescribed motion.
    pub fn next_kink_s(&self, time_s: f64) -> f64 {
        self.list.iter().map(|joint| joint.next_kink_s(time_s)).fold(f64::INFINITY, f64::min)
    }

    /// Whether such a kink, where prescribed rates or accelerations may jump, is exactly at `time_s`.
    pub fn kink_at(&self, time_s: f64) -> bool {
        self.list.iter().any(|joint| joint.kink_at(time_s))
    }

    /// Whether a knot of a prescribed motion is exactly at `time_s`.
    pub fn knot_at(&self, time_s: f64) -> bool {
        self.joints().iter().filter_map(JointForces::law).any(|law| law.has_knot_at(time_s))
    }

    /// Selects the pieces of all forces with kinks for a state, eq. (T12), or changes only the first; returns whether any piece has
    /// changed.
    pub fn move_pieces(&mut self, time_s: f64, q: &[f64], v: &[f64], only_first: bool) -> bool {
        let mut moved = false;
        for joint in &mut self.list {
            moved |= joint.move_pieces(time_s, q, v);
            if moved && only_first {
                break;
            }
        }
        moved
    }

    /// Deselects the pieces of forces with kinks, which then follow from the state again.
    pub fn drop_pieces(&mut self) {
        self.list.iter_mut().for_each(JointForces::drop_pieces);
    }

    /// Keeps the smooth pieces on which all forces lie at a state, as [`JointForces::hold`], until [`Forces::let_go`], eq. (X34).
    pub fn hold(&mut self, times_s: [f64; 2], q: &[f64], v: &[f64]) {
        self.joints_mut().iter_mut().for_each(|joint| joint.hold(times_s, q, v));
    }

    /// Keeps the pieces of another machine.
    pub fn hold_as(&mut self, other: &Self) {
        self.joints_mut().iter_mut().zip(other.joints()).for_each(|(joint, other)| joint.hold_as(other));
    }

    /// Ends [`Forces::hold`].
    pub fn let_go(&mut self) {
        self.joints_mut().iter_mut().for_each(JointForces::let_go);
    }

    /// Whether a force changes with time itself at a time, apart from inputs and prescribed motions.
    pub fn move_at(&self, time_s: f64) -> bool {
        self.joints().iter().any(|joint| joint.moves_at(time_s))
    }

    /// Replaces all nonlinear forces by their tangents at a state, until [`Forces::drop_tangents`]: linear in the motion of their joints.
    pub fn linearize(&mut self, time_s: f64, q: &[f64], v: &[f64]) {
        self.joints_mut().iter_mut().for_each(|joint| joint.linearize(time_s, q, v));
    }

    /// Restores the nonlinear forces.
    pub fn drop_tangents(&mut self) {
        self.joints_mut().iter_mut().for_each(JointForces::drop_tangents);
    }

    /// All indicators.
    pub fn indicators(&self) -> impl Iterator<Item = Indicator> {
        let of_joint = |(joint, forces): (usize, &JointForces)| {
            (0..forces.indicators()).map(move |number| Indicator { joint, number })
        };
        self.joints().iter().enumerate().flat_map(of_joint)
    }

    /// Whether a motion that starts at `start` may cross an indicator.
    pub fn is_armed(&self, indicator: Indicator, start: &Point, memories: &[JointMemory]) -> bool {
        let joint = &self.list[indicator.joint];
        joint.is_armed(indicator.number, &joint.moving(start), &memories[indicator.joint])
    }

    /// Signed distance of an indicator in rad at a point reached by a motion from `start`, and the rate at which it decreases there in
    /// rad/s.
    pub fn distance(&self, indicator: Indicator, start: &Point, at: &Point, memories: &[JointMemory]) -> (f64, f64) {
        let joint = &self.list[indicator.joint];
        let (moving, start_rad) = (joint.moving(at), start.q[joint.coordinate]);
        let memory = &memories[indicator.joint];
        (
            joint.distance_rad(indicator.number, start_rad, &moving, memory),
            joint.closing_rad_s(indicator.number, &moving, memory),
        )
    }

    /// Whether a crossing must be located on its far side.
    pub fn lands_beyond(&self, indicator: Indicator) -> bool {
        self.list[indicator.joint].lands_beyond(indicator.number)
    }

    /// First armed indicator that falls through zero within a step, and an estimate of the fraction of the step at which it does.
    pub fn first_crossing(&self, taken: &Taken, memories: &[JointMemory]) -> Option<(Indicator, f64)> {
        let mut first: Option<(Indicator, f64)> = None;
        for indicator in self.indicators() {
            if !self.is_armed(indicator, taken.start, memories) {
                continue;
            }
            let joint = &self.list[indicator.joint];
            let start_rad = taken.start.q[joint.coordinate];
            let distance = |fraction: f64| {
                let place = Within { taken, fraction, coordinate: joint.coordinate };
                joint.distance_rad(indicator.number, start_rad, &place, &memories[indicator.joint])
            };
            let sample = |k: u32| f64::from(k) / f64::from(CROSSING_SAMPLES);
            let Some(k) = (1..=CROSSING_SAMPLES).find(|&k| distance(sample(k)) <= 0.0) else { continue };
            let (mut low, mut high) = (sample(k - 1), sample(k));
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                if distance(middle) > 0.0 { low = middle } else { high = middle }
            }
            if first.is_none_or(|(_, earliest)| high < earliest) {
                first = Some((indicator, high));
            }
        }
        first
    }
}

/// A point within a step.
struct Within<'a> {
    taken: &'a Taken<'a>,
    fraction: f64,
    coordinate: usize,
}

impl Place for Within<'_> {
    fn angle_rad(&self) -> f64 {
        self.taken.coordinate(self.fraction, self.coordinate)
    }

    fn rate_rad_s(&self) -> f64 {
        self.taken.rate(self.fraction, self.coordinate)
    }
}
