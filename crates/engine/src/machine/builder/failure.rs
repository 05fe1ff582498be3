//! Failures in code: equivalent of a table `[failure.<name>]` of the model file.

use crate::machine::failure::{Bound, BoundSide, Effect, Failure, FrictionBrake, Quantity};
use crate::machine::fault::Checker;
use crate::machine::{Body, Closure};

/// Part on which the failure acts, by name.
#[derive(Debug, Clone, PartialEq)]
enum Target {
    /// A joint.
    Joint(String),
    /// A closed loop.
    Loop(String),
    /// A beam.
    Body(String),
}

/// A failure under construction, see [`Failure::motor_loss`] and the other constructors. Its input is always a trigger.
#[derive(Debug, Clone, PartialEq)]
pub struct FailureBuilder {
    pub(super) name: String,
    target: Target,
    /// Effect with a placeholder for the index, which is not known yet.
    effect: Effect,
    at_time_s: Option<f64>,
    after: Option<String>,
    when: Option<(String, Quantity, BoundSide, f64)>,
    delay_s: f64,
}

/// Placeholder for an index that is looked up by name later.
const UNKNOWN: usize = usize::MAX;

impl Failure {
    fn of(name: impl Into<String>, target: Target, effect: Effect) -> FailureBuilder {
        FailureBuilder { name: name.into(), target, effect, at_time_s: None, after: None, when: None, delay_s: 0.0 }
    }

    fn of_joint(name: impl Into<String>, joint: impl Into<String>, effect: Effect) -> FailureBuilder {
        Self::of(name, Target::Joint(joint.into()), effect)
    }

    /// The motor of a joint loses its torque.
    pub fn motor_loss(name: impl Into<String>, joint: impl Into<String>) -> FailureBuilder {
        Self::of_joint(name, joint, Effect::MotorLoss { body: UNKNOWN })
    }

    /// A joint is held at its position.
    pub fn motor_jam(name: impl Into<String>, joint: impl Into<String>) -> FailureBuilder {
        Self::of_joint(name, joint, Effect::MotorJam { body: UNKNOWN })
    }

    /// The neutral angle of a motor moves to `to_rad` at `rate_rad_s`, in rad and rad/s, or m and m/s, independent of its command.
    pub fn motor_runaway(
        name: impl Into<String>,
        joint: impl Into<String>,
        to_rad: f64,
        rate_rad_s: f64,
    ) -> FailureBuilder {
        Self::of_joint(name, joint, Effect::MotorRunaway { body: UNKNOWN, to_rad, rate_rad_s })
    }

    /// The latch of a joint opens and does not close again.
    pub fn latch_break(name: impl Into<String>, joint: impl Into<String>) -> FailureBuilder {
        Self::of_joint(name, joint, Effect::LatchBreak { body: UNKNOWN })
    }

    /// The open latch of a joint does not close.
    pub fn latch_no_capture(name: impl Into<String>, joint: impl Into<String>) -> FailureBuilder {
        Self::of_joint(name, joint, Effect::LatchNoCapture { body: UNKNOWN })
    }

    /// The lock of a joint opens, because the link that held it fails.
    pub fn lock_release(name: impl Into<String>, joint: impl Into<String>) -> FailureBuilder {
        Self::of_joint(name, joint, Effect::LockRelease { body: UNKNOWN })
    }

    /// Spring and damper of a joint are reduced to the fraction `remaining`; 0 for a broken spring.
    pub fn spring_break(name: impl Into<String>, joint: impl Into<String>, remaining: f64) -> FailureBuilder {
        Self::of_joint(name, joint, Effect::SpringBreak { body: UNKNOWN, remaining })
    }

    /// The penalty of a closed loop is reduced to the fraction `remaining`; 0 for an open loop.
    pub fn loop_break(name: impl Into<String>, closure: impl Into<String>, remaining: f64) -> FailureBuilder {
        Self::of(name, Target::Loop(closure.into()), Effect::LoopBreak { closure: UNKNOWN, remaining })
    }

    /// All stiffness of a beam is reduced to the fraction `remaining`.
    pub fn stiffness_loss(name: impl Into<String>, body: impl Into<String>, remaining: f64) -> FailureBuilder {
        Self::of(name, Target::Body(body.into()), Effect::StiffnessLoss { body: UNKNOWN, remaining })
    }

    /// A brake is applied to a joint.
    pub fn brake_applied(name: impl Into<String>, joint: impl Into<String>, brake: FrictionBrake) -> FailureBuilder {
        Self::of_joint(name, joint, Effect::BrakeApplied { body: UNKNOWN, brake })
    }
}

impl FailureBuilder {
    /// Triggered at a time in s.
    pub fn at_time_s(self, time_s: f64) -> Self {
        Self { at_time_s: Some(time_s), ..self }
    }

    /// Triggered by another failure.
    pub fn after(self, failure: impl Into<String>) -> Self {
        Self { after: Some(failure.into()), ..self }
    }

    /// Triggered when the angle or rate of a joint passes a value in rad or rad/s, m or m/s.
    pub fn when(self, joint: impl Into<String>, quantity: Quantity, side: BoundSide, value: f64) -> Self {
        Self { when: Some((joint.into(), quantity, side, value)), ..self }
    }

    /// Delay after the trigger in s. Default 0.
    pub fn delay_s(self, delay_s: f64) -> Self {
        Self { delay_s, ..self }
    }

    /// Builds the failure of a machine; `None` for an unknown name, which is an error.
    pub(super) fn build(
        &self,
        bodies: &[Body],
        closures: &[Closure],
        failures: &[FailureBuilder],
        checker: &mut Checker,
    ) -> Option<Failure> {
        let mut find = |key: &[&str], name: &str, what: &str, known: Vec<&str>| {
            let found = known.iter().position(|known| *known == name);
            if found.is_none() {
                let place: Vec<&str> = ["failure", self.name.as_str()].into_iter().chain(key.iter().copied()).collect();
                checker.unknown_name(&place, name, what, known);
            }
            found
        };
        let joints = || bodies.iter().map(|body| body.joint.name.as_str()).collect();
        let target = match &self.target {
            Target::Joint(name) => find(&["joint"], name, "a joint", joints()),
            Target::Loop(name) => {
                find(&["loop"], name, "a loop", closures.iter().map(|closure| closure.name.as_str()).collect())
            }
            Target::Body(name) => {
                find(&["body"], name, "a body", bodies.iter().map(|body| body.name.as_str()).collect())
            }
        };
        let others = || failures.iter().map(|failure| failure.name.as_str()).collect();
        let after = self.after.as_ref().map(|name| find(&["after"], name, "a failure", others()));
        let when = self.when.as_ref().map(|(joint, quantity, side, value)| {
            let body = find(&["when", "joint"], joint, "a joint", joints())?;
            Some(Bound { body, quantity: *quantity, value: *value, side: *side })
        });
        if after == Some(None) || when == Some(None) {
            return None;
        }
        Some(Failure {
            name: self.name.clone(),
            effect: self.effect.at(target?),
            at_time_s: self.at_time_s,
            after: after.flatten(),
            when: when.flatten(),
            delay_s: self.delay_s,
        })
    }
}

impl Effect {
    /// The effect with a known index.
    fn at(self, place: usize) -> Self {
        match self {
            Self::MotorLoss { .. } => Self::MotorLoss { body: place },
            Self::MotorJam { .. } => Self::MotorJam { body: place },
            Self::MotorRunaway { to_rad, rate_rad_s, .. } => Self::MotorRunaway { body: place, to_rad, rate_rad_s },
            Self::LatchBreak { .. } => Self::LatchBreak { body: place },
            Self::LatchNoCapture { .. } => Self::LatchNoCapture { body: place },
            Self::LockRelease { .. } => Self::LockRelease { body: place },
            Self::SpringBreak { remaining, .. } => Self::SpringBreak { body: place, remaining },
            Self::LoopBreak { remaining, .. } => Self::LoopBreak { closure: place, remaining },
            Self::StiffnessLoss { remaining, .. } => Self::StiffnessLoss { body: place, remaining },
            Self::BrakeApplied { brake, .. } => Self::BrakeApplied { body: place, brake },
        }
    }
}
