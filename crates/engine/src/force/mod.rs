//! Forces on the degrees of freedom of joints: motors, springs, latches, locks, prescribed motions, NOTATION eqs. (A1)–(A14). A force may
//! have indicators whose crossing is an event, transitions that dissipate energy, and kinks at known times.
//!
//! A force consists of one file and its arms in [`Force`]. The time integration does not depend on the types: it evaluates signed
//! distances, locates the first fall through zero, and calls the transition of that force. Names are those of a revolute joint; for a
//! prismatic one read m for rad and N for N·m.

pub mod attitude;
pub mod borders;
pub mod brake;
mod contract;
pub mod dc_motor;
pub mod drive;
pub mod end_stops;
pub mod external;
pub mod friction;
pub mod generator;
pub mod joint;
pub mod latch;
pub mod memory;
pub mod motor;
pub mod prescribed;
pub mod set;
pub mod spring;
pub mod watch;

use crate::solve::Powers;
use attitude::AttitudeSpring;
use borders::Borders;
use brake::Brake;
use end_stops::TwoSidedStops;
use external::External;
use friction::SlippingBrake;
use generator::Generator;
use latch::CatchingLatch;
use memory::{JointMemory, Told};
use motor::Motor;
use prescribed::Law;
use spring::Spring;
use watch::Watch;

pub use contract::{Here, Moving, Outcome, Place, Push, Stored};

/// Distance of a force from a kink, as a share of the torque or speed of the kink, that is round-off.
const AT_KINK: f64 = 1e-11;

/// Matches forces by type, without their contents; without a list it matches all of them. Types without an effect are listed explicitly, so
/// that a new type does not compile until every function handles it.
macro_rules! each {
    () => {
        each!(
            Motor
                | Spring
                | External
                | Generator
                | Latch
                | EndStops
                | Brake
                | Prescribed
                | Lock
                | Attitude
                | Slipping
                | Watch
                | Borders
        )
    };
    ($($kind:ident)|+) => { $(Self::$kind { .. })|+ };
}

mod at_rest;

/// A force on the degrees of freedom of one joint, by type.
#[derive(Debug, Clone, PartialEq)]
pub enum Force {
    /// Motor with torque limit and slew, eqs. (A1), (A2).
    Motor(Motor),
    /// Spring and damper of a joint with one degree of freedom, eq. (A1).
    Spring(Spring),
    /// External torque, an input.
    External(External),
    /// Generator whose torque is a function of the speed, eq. (A11).
    Generator(Generator),
    /// Latch, eqs. (A3), (A7).
    Latch(CatchingLatch),
    /// End stops at both ends of the joint's travel, eq. (A8).
    EndStops(TwoSidedStops),
    /// Lock that holds the joint until it is released, eq. (A6).
    Brake(Brake),
    /// Prescribed angle as a function of time.
    Prescribed(Law),
    /// Permanent lock at the start angle.
    Lock,
    /// Spring and damper of a universal or ball joint.
    Attitude(AttitudeSpring),
    /// Brake applied by a failure, eq. (A9).
    Slipping(SlippingBrake),
    /// Monitor of the motion for a failure.
    Watch(Watch),
    /// Borders of the elements along which a sliding joint moves.
    Borders(Borders),
}

impl Force {
    /// Adds torque and tangent, on the pieces selected by [`Force::move_piece`].
    pub fn push(&self, here: &Here, sum: &mut Push) {
        match self {
            Self::Motor(motor) => motor.push(here, sum),
            Self::Spring(spring) => spring.push(here, sum),
            Self::External(external) => sum.torque_n_m += external.torque_n_m,
            Self::Generator(generator) => generator.push(here, sum),
            Self::Latch(latch) => latch.push(here, sum),
            Self::EndStops(stops) => stops.push(here, sum),
            Self::Attitude(spring) => spring.push(here, sum),
            Self::Slipping(brake) => brake.push(here, sum),
            Self::Brake(_) | Self::Prescribed(_) | Self::Lock | Self::Watch(_) | Self::Borders(_) => {}
        }
    }

    /// Adds the power of inputs and of dissipation, NOTATION eq. (A5). `holding_n_m` is the constraint torque that holds the joint.
    pub fn add_powers(&self, here: &Here, holding_n_m: f64, powers: &mut Powers) {
        match self {
            Self::Motor(motor) => motor.add_powers(here, powers),
            Self::Spring(spring) => powers.dissipated += spring.dissipation_w(here.rate_rad_s),
            Self::External(external) => powers.work += external.torque_n_m * here.rate_rad_s,
            Self::Generator(generator) => generator.add_powers(here, powers),
            Self::Prescribed(_) | Self::Lock => powers.work += holding_n_m * here.rate_rad_s,
            Self::Attitude(spring) => powers.dissipated += spring.dissipation_w(here.work, here.v),
            Self::EndStops(stops) => stops.add_powers(here, powers),
            Self::Slipping(brake) => brake.add_powers(here, powers),
            Self::Latch(_) | Self::Brake(_) | Self::Watch(_) | Self::Borders(_) => {}
        }
    }

    /// Adds the energy stored in the force.
    pub fn add_stored(&self, here: &Here, stored: &mut Stored) {
        match self {
            Self::Motor(motor) => stored.drive += motor.potential_j(here),
            Self::Spring(spring) => stored.elastic += spring.energy_j(here.angle_rad),
            Self::Latch(latch) => stored.elastic += latch.stored_j(here.angle_rad),
            Self::EndStops(stops) => stored.elastic += stops.stored_j(here.angle_rad),
            Self::Attitude(spring) => stored.drive += spring.potential_j(here.work),
            Self::External(_)
            | Self::Generator(_)
            | Self::Brake(_)
            | Self::Prescribed(_)
            | Self::Lock
            | Self::Slipping(_)
            | Self::Watch(_)
            | Self::Borders(_) => {}
        }
    }

    /// Whether the force holds the joint, according to the memory.
    pub fn holds(&self, memory: &JointMemory) -> bool {
        match self {
            Self::Brake(brake) => brake.holds(memory),
            Self::Latch(latch) => latch.holds(memory),
            Self::Prescribed(_) | Self::Lock => true,
            each!(Motor | Spring | External | Generator | EndStops | Attitude | Slipping | Watch | Borders) => false,
        }
    }

    /// Restores the state of the force from the memory.
    pub fn recall(&mut self, memory: &JointMemory) {
        match self {
            Self::Motor(motor) => motor.recall(memory),
            Self::Latch(latch) => latch.closed = memory.latch.closed,
            Self::EndStops(stops) => stops.contact = memory.contact,
            each!(
                Spring | External | Generator | Brake | Prescribed | Lock | Attitude | Slipping | Watch | Borders
            ) => {}
        }
    }

    /// Applies changed inputs. `crossed` has one bit for each of the force's indicators that the current step crosses at its end.
    pub fn take_inputs(&self, told: &Told, now: &Moving, crossed: u32, memory: &mut JointMemory) -> Outcome {
        match self {
            Self::Motor(_) => Motor::take_inputs(told, memory),
            Self::Latch(latch) => latch.take_inputs(told, now, crossed != 0, memory),
            Self::EndStops(stops) => stops.take_inputs(told, now, crossed, memory),
            Self::Brake(brake) => brake.take_inputs(told, memory),
            Self::Borders(borders) => borders.take_inputs(told, crossed, memory),
            Self::Watch(watch) if told.at_end && crossed != 0 => watch.transition(memory),
            each!(Spring | External | Generator | Prescribed | Lock | Attitude | Slipping | Watch) => {
                Outcome::default()
            }
        }
    }

    /// Next kink after `time_s` whose time is known in advance, in s.
    pub fn next_kink_s(&self, time_s: f64) -> f64 {
        match self {
            Self::Motor(motor) => motor.next_kink_s(time_s),
            Self::Prescribed(law) => law.next_knot_s(time_s),
            Self::Slipping(brake) => brake.next_kink_s(time_s),
            each!(Spring | External | Generator | Latch | EndStops | Brake | Lock | Attitude | Watch | Borders) => {
                f64::INFINITY
            }
        }
    }

    /// Whether such a kink, where the force may jump, is exactly at `time_s`.
    pub fn kink_at(&self, time_s: f64) -> bool {
        match self {
            Self::Motor(motor) => motor.kink_at(time_s),
            Self::Prescribed(law) => law.has_knot_at(time_s),
            each!(
                Spring | External | Generator | Latch | EndStops | Brake | Lock | Attitude | Slipping | Watch | Borders
            ) => false,
        }
    }

    /// Selects the piece of a force with kinks for a state, eq. (T12); returns whether the piece has changed.
    pub fn move_piece(&mut self, time_s: f64, angle_rad: f64, rate_rad_s: f64) -> bool {
        match self {
            Self::Motor(motor) => motor.move_piece(time_s, angle_rad, rate_rad_s),
            each!(
                Spring
                    | External
                    | Generator
                    | Latch
                    | EndStops
                    | Brake
                    | Prescribed
                    | Lock
                    | Attitude
                    | Slipping
                    | Watch
                    | Borders
            ) => false,
        }
    }

    /// Deselects the piece of a force with kinks, which then follows from the state again.
    pub fn drop_piece(&mut self) {
        if let Self::Motor(motor) = self {
            motor.piece = None;
        }
    }

    /// Keeps the smooth piece on which the force lies at a state, for derivatives with respect to parameters and time, until
    /// [`Force::let_go`], eq. (X34). `times_s`: time of the state, and a time on the same branch of laws in time.
    pub fn hold(&mut self, times_s: [f64; 2], angle_rad: f64, rate_rad_s: f64) {
        match self {
            Self::Motor(motor) => motor.hold(times_s, angle_rad, rate_rad_s),
            Self::Generator(generator) => generator.hold(rate_rad_s),
            Self::Slipping(brake) => brake.hold(times_s[1]),
            // smooth in angle, rate and parameters for the current contact, latch state and attitude
            each!(Spring | External | Latch | EndStops | Brake | Prescribed | Lock | Attitude | Watch | Borders) => {}
        }
    }

    /// Keeps the same piece as the same force of another machine.
    pub fn hold_as(&mut self, other: &Self) {
        match self {
            Self::Motor(motor) => {
                if let Self::Motor(other) = other {
                    motor.held = other.held;
                }
            }
            Self::Generator(generator) => {
                if let Self::Generator(other) = other {
                    generator.held = other.held;
                }
            }
            Self::Slipping(brake) => {
                if let Self::Slipping(other) = other {
                    brake.held = other.held;
                }
            }
            each!(Spring | External | Latch | EndStops | Brake | Prescribed | Lock | Attitude | Watch | Borders) => {}
        }
    }

    /// Ends [`Force::hold`].
    pub fn let_go(&mut self) {
        match self {
            Self::Motor(motor) => motor.held = None,
            Self::Generator(generator) => generator.held = None,
            Self::Slipping(brake) => brake.held = None,
            each!(Spring | External | Latch | EndStops | Brake | Prescribed | Lock | Attitude | Watch | Borders) => {}
        }
    }

    /// Whether the force changes with time itself at a time, apart from inputs and prescribed motions.
    pub fn moves_at(&self, time_s: f64) -> bool {
        match self {
            Self::Motor(motor) => motor.slews_at(time_s),
            Self::Slipping(brake) => brake.grows_at(time_s),
            each!(
                Spring
                    | External
                    | Generator
                    | Latch
                    | EndStops
                    | Brake
                    | Prescribed
                    | Lock
                    | Attitude
                    | Watch
                    | Borders
            ) => false,
        }
    }

    /// Kink in which the force lies at a state to round-off, in words: derivatives to its two sides differ.
    pub fn kink(&self, time_s: f64, angle_rad: f64, rate_rad_s: f64) -> Option<&'static str> {
        match self {
            Self::Motor(motor) => motor
                .is_at_limit(time_s, angle_rad, rate_rad_s, AT_KINK)
                .then_some("the torque of its motor is exactly at the torque limit"),
            Self::Generator(generator) => generator
                .is_at_row(rate_rad_s, AT_KINK)
                .then_some("the speed of its generator is exactly that of a row of the table"),
            each!(
                Spring
                    | External
                    | Latch
                    | EndStops
                    | Brake
                    | Prescribed
                    | Lock
                    | Attitude
                    | Slipping
                    | Watch
                    | Borders
            ) => None,
        }
    }

    /// Replaces a force that is nonlinear in the motion of its joint by its tangent at a state, until [`Force::drop_tangent`].
    pub fn linearize(&mut self, time_s: f64, angle_rad: f64, rate_rad_s: f64) {
        match self {
            Self::Motor(motor) => motor.linearize(time_s, angle_rad, rate_rad_s),
            Self::Generator(generator) => generator.linearize(rate_rad_s),
            Self::Slipping(brake) => brake.linearize(rate_rad_s),
            // linear in angle and rate for the current contact, latch state and attitude
            each!(Spring | External | Latch | EndStops | Brake | Prescribed | Lock | Attitude | Watch | Borders) => {}
        }
    }

    /// Restores the nonlinear force.
    pub fn drop_tangent(&mut self) {
        match self {
            Self::Motor(motor) => motor.tangent = None,
            Self::Generator(generator) => generator.about_rad_s = None,
            Self::Slipping(brake) => brake.about_rad_s = None,
            each!(Spring | External | Latch | EndStops | Brake | Prescribed | Lock | Attitude | Watch | Borders) => {}
        }
    }

    /// Number of the force's indicators: signed distances in rad whose fall through zero is an event.
    pub fn indicators(&self) -> usize {
        match self {
            Self::Latch(_) | Self::Watch(_) => 1,
            Self::EndStops(_) | Self::Borders(_) => 2,
            each!(Motor | Spring | External | Generator | Brake | Prescribed | Lock | Attitude | Slipping) => 0,
        }
    }

    /// Whether a motion from `start` may cross an indicator, according to the memory.
    pub fn is_armed(&self, indicator: usize, start: &Moving, memory: &JointMemory) -> bool {
        match (self, indicator) {
            (Self::Latch(latch), 0) => latch.is_armed(start, memory),
            (Self::EndStops(stops), 0 | 1) => stops.distance_rad(indicator, start, memory) > 0.0,
            (Self::Watch(watch), 0) => watch.is_armed(start, memory),
            (Self::Borders(borders), 0 | 1) => borders.distance_m(indicator, start, memory) > 0.0,
            (each!(), _) => false,
        }
    }

    /// Signed distance of an indicator for a motion from `start_rad`, in rad.
    pub fn distance_rad(&self, indicator: usize, start_rad: f64, place: &impl Place, memory: &JointMemory) -> f64 {
        match (self, indicator) {
            (Self::Latch(latch), 0) => latch.latch.gap_rad(start_rad, place.angle_rad()),
            (Self::EndStops(stops), 0 | 1) => stops.distance_rad(indicator, place, memory),
            (Self::Watch(watch), 0) => watch.distance_rad(place),
            (Self::Borders(borders), 0 | 1) => borders.distance_m(indicator, place, memory),
            (each!(), _) => f64::INFINITY,
        }
    }

    /// Rate at which an indicator decreases, in rad/s; never negative.
    pub fn closing_rad_s(&self, indicator: usize, at: &Moving, memory: &JointMemory) -> f64 {
        match (self, indicator) {
            (Self::Latch(_), 0) | (Self::Borders(_), 0 | 1) => at.rate_rad_s.abs(),
            (Self::EndStops(stops), 0 | 1) => stops.closing_rad_s(indicator, at, memory),
            (Self::Watch(watch), 0) => watch.closing_rad_s(at),
            (each!(), _) => 0.0,
        }
    }

    /// Whether a crossing must be located on its far side.
    pub fn lands_beyond(&self) -> bool {
        match self {
            Self::Latch(latch) => latch.latch.is_rigid(),
            Self::EndStops(_) | Self::Watch(_) | Self::Borders(_) => true,
            each!(Motor | Spring | External | Generator | Brake | Prescribed | Lock | Attitude | Slipping) => false,
        }
    }

    /// Whether an indicator was already crossed at the start of a step, according to the memory: the transition is due immediately.
    pub fn is_overdue(&self, indicator: usize, at: &Moving, memory: &JointMemory) -> bool {
        match self {
            Self::EndStops(stops) => stops.is_overdue(indicator, at, memory),
            Self::Watch(watch) => watch.is_overdue(at, memory),
            Self::Borders(borders) => borders.is_overdue(indicator, at, memory),
            each!(Motor | Spring | External | Generator | Latch | Brake | Prescribed | Lock | Attitude | Slipping) => {
                false
            }
        }
    }

    /// Initialises the memory for the start of a run.
    pub fn begin(&self, start: &Moving, memory: &mut JointMemory) {
        match self {
            Self::EndStops(stops) => stops.begin(start, memory),
            Self::Watch(watch) => watch.begin(start, memory),
            Self::Borders(borders) => borders.begin(start, memory),
            each!(Motor | Spring | External | Generator | Latch | Brake | Prescribed | Lock | Attitude | Slipping) => {}
        }
    }

    /// Performs the transition of an indicator.
    pub fn transition(&self, indicator: usize, time_s: f64, at: &Moving, memory: &mut JointMemory) -> Outcome {
        match (self, indicator) {
            (Self::Latch(_), 0) => CatchingLatch::transition(time_s, memory),
            (Self::EndStops(stops), 0 | 1) => stops.transition(indicator, at, memory),
            (Self::Watch(watch), 0) => watch.transition(memory),
            (Self::Borders(borders), 0 | 1) => borders.transition(indicator, memory),
            (each!(), _) => Outcome::default(),
        }
    }

    /// Whether the force stores the impulse with which it stops the joint.
    pub fn keeps_impulses(&self) -> bool {
        matches!(self, Self::Latch(latch) if latch.latch.is_rigid())
    }

    /// Storage of the impulse that stops the joint at `time_s`, if the force exerts it.
    pub fn impulse_n_m_s<'a>(&self, time_s: f64, memory: &'a mut JointMemory) -> Option<&'a mut f64> {
        match self {
            Self::Latch(latch) => latch.impulse_n_m_s(time_s, memory),
            each!(
                Motor
                    | Spring
                    | External
                    | Generator
                    | EndStops
                    | Brake
                    | Prescribed
                    | Lock
                    | Attitude
                    | Slipping
                    | Watch
                    | Borders
            ) => None,
        }
    }
}
