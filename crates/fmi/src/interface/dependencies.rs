//! Dependencies between rows, at a communication point and in Initialization Mode.
//!
//! Each output's row declares its causes ([`Cause`]); this module lists the inputs and parameters of each cause. At a communication point
//! the state is held constant: strains, angles, their rates, locks and latches. Results of the state alone (positions, velocities, angles,
//! stored energy of the wing) depend on no input; accelerations and the forces recovered from them depend on all loads within the branch.
//! At the start the strains and their rates are zero, so the state follows from start angles, start rates and the inputs of locks and
//! latches; the springs of universal and ball joints are slack. If the simulation starts from equilibrium, the state depends on everything
//! that acts on the model.

use crate::interface::air::{blows, blows_initially};
use crate::interface::cause::{Cause, Depends, Reach};
use crate::interface::hinge_dependencies::{
    commands_joint, latch_pulls, latches, motor_pulls_initially, motor_stores, spring_pulls_initially,
    spring_stores_initially, start_rate, starts, starts_closed, turns_joint,
};
use crate::interface::known::{BodyParameter, Input, JointInput, JointParameter, Known, Parameter, SpatialParameter};
use crate::interface::point_dependencies::{spins_initially, turned_initially, velocity_initially};
use crate::interface::topology::{Topology, Turning};
use crate::interface::{Dependencies, DependencyKind, MAXIMUM_LISTED, Stage};
use foldwing_engine::machine::{Machine, StartState};

/// Dependencies of outputs on knowns: pairs of a row and its declaration.
pub(super) fn find<'a>(
    machine: &Machine,
    knowns: &[(u32, Known)],
    rows: impl Iterator<Item = Option<&'a Depends>>,
) -> Vec<Dependencies> {
    let topology = Topology::new(machine);
    let of = |depends: &Depends| {
        let initial = |known: Known| match (settles(machine, depends), known) {
            (false, Known::Parameter(_)) => depends.factor,
            (_, Known::Time | Known::Input(_) | Known::Parameter(_)) => DependencyKind::Dependent,
        };
        let running = knowns
            .iter()
            .filter(|(_, known)| depends_on(&topology, depends, *known))
            .map(|(reference, _)| (*reference, DependencyKind::Dependent));
        let initial = knowns
            .iter()
            .filter(|(_, known)| depends_initially_on(&topology, depends, *known))
            .map(|&(reference, known)| (reference, initial(known)));
        // one row above the limit shows that the list is too long
        let (running, initial): (Vec<_>, Vec<_>) =
            (running.take(MAXIMUM_LISTED + 1).collect(), initial.take(MAXIMUM_LISTED + 1).collect());
        if running.len().max(initial.len()) > MAXIMUM_LISTED {
            return Dependencies { on_all: true, ..Dependencies::default() };
        }
        Dependencies { running, initial, on_all: false }
    };
    rows.map(|depends| depends.map(of).unwrap_or_default()).collect()
}

/// Dependence of outputs on knowns: at a communication point, or in initialisation.
pub(super) struct Dependence<'a> {
    topology: Topology<'a>,
    stage: Stage,
}

impl<'a> Dependence<'a> {
    /// Dependence for a model at a stage.
    pub fn new(machine: &'a Machine, stage: Stage) -> Self {
        Self { topology: Topology::new(machine), stage }
    }

    /// Returns whether the output depends on the known.
    pub fn holds(&self, depends: &Depends, known: Known) -> bool {
        match self.stage {
            Stage::Starting => depends_initially_on(&self.topology, depends, known),
            Stage::Running | Stage::Exchanging => depends_on(&self.topology, depends, known),
        }
    }
}

/// Returns whether the initial value is that of an equilibrium, which depends on everything that loads or holds the machine. Locks hold the
/// angles of joints that are not latched, and the start rates are the model's.
fn settles(machine: &Machine, depends: &Depends) -> bool {
    machine.experiment.start == StartState::Equilibrium && depends.settles
}

/// Dependence at a communication point, with the state held constant.
fn depends_on(topology: &Topology, depends: &Depends, known: Known) -> bool {
    depends.running.iter().any(|&cause| is_cause(topology, cause, known))
}

/// Dependence of the initial value.
fn depends_initially_on(topology: &Topology, depends: &Depends, known: Known) -> bool {
    // the start rates are projected onto the constraints of skates and wheels, which couples all of them
    let projected = depends.settles && !topology.machine.no_slips.is_empty();
    if projected || settles(topology.machine, depends) {
        return match known {
            Known::Time => any_moved(topology),
            Known::Parameter(Parameter::Joint(_, JointParameter::RateLimit) | Parameter::Solver) => false,
            Known::Input(_) | Known::Parameter(_) => true,
        };
    }
    if let Known::Input(Input::Failure(_)) = known {
        // at the start a failure changes locks, motors and supports
        return !depends.initial.is_empty();
    }
    depends.initial.iter().any(|&cause| is_cause(topology, cause, known))
}

/// Returns whether a known belongs to a cause.
fn is_cause(topology: &Topology, cause: Cause, known: Known) -> bool {
    match cause {
        Cause::Command(joint) => commands_joint(joint, known),
        Cause::AnyCommand => matches!(known, Known::Input(Input::Joint(_, JointInput::Command))),
        Cause::Torque(joint) => turns_joint(joint, known),
        Cause::Generator(joint) => known == Known::Input(Input::Joint(joint, JointInput::GeneratorOn)),
        Cause::Voltage(joint) => known == Known::Input(Input::Joint(joint, JointInput::Voltage)),
        Cause::Weight => matches!(known, Known::Input(Input::Gravity | Input::RootAcceleration)),
        Cause::Prescribed(joint) => known == Known::Time && topology.is_prescribed(joint),
        Cause::Travel(body) => known == Known::Time && moved(topology, body),
        Cause::AnyTravel => known == Known::Time && any_moved(topology),
        Cause::LoopTravel(closure) => known == Known::Time && stretched(topology, closure),
        Cause::Push(reach) => pushes(topology, reach, known),
        Cause::Air => blows(topology, known),
        Cause::AirStart => blows_initially(topology, known),
        Cause::Start(joint) => starts(topology, joint, known),
        Cause::StartRate(joint) => start_rate(topology, joint, known),
        Cause::MotorStart(joint) => motor_pulls_initially(topology, joint, known),
        Cause::SpringStart(joint) => spring_pulls_initially(topology, joint, known),
        Cause::SpringStore(joint) => spring_stores_initially(topology, joint, known),
        Cause::LatchPull(joint) => latch_pulls(topology, joint, known),
        Cause::LatchStart(joint) => latches(topology, joint, known),
        Cause::Accelerate(reach) => accelerates_initially(topology, reach, known),
        Cause::Stiffness(body) => known == Known::Parameter(Parameter::Body(body, BodyParameter::StiffnessFactor)),
        Cause::AnyMassFactor => matches!(known, Known::Parameter(Parameter::Body(_, BodyParameter::MassFactor))),
        Cause::Folds(body) => topology.folds(body).any(|joint| starts(topology, joint, known)),
        Cause::LoopPull(closure) => loop_pulls_initially(topology, closure, known),
        Cause::BallStart(body) => damps_initially(topology, body, known),
        Cause::VelocityStart(body) => velocity_initially(topology, body, known),
        Cause::AngularVelocityStart(body) => spins_initially(topology, body, known),
        Cause::AttitudeStart(body) => turned_initially(topology, body, known),
        Cause::KineticStart => moves_initially(topology, known),
        Cause::DriveStart => motor_stores(topology, known),
        Cause::Flap(flap) => known == Known::Input(Input::Flap(flap)),
        Cause::FlapRate(flap) => known == Known::Input(Input::FlapRate(flap)),
        Cause::AnyFailure => matches!(known, Known::Input(Input::Failure(_))),
    }
}

impl Reach {
    fn holds(self, topology: &Topology, body: usize) -> bool {
        match self {
            Self::Root => !topology.floats(body),
            Self::Group(first) | Self::Flight(first) => topology.group[body] == first,
        }
    }

    /// Closed loops that end on a body within reach, or on the root.
    fn loops(self, topology: &Topology) -> impl Iterator<Item = usize> {
        let ends = move |&closure: &usize| {
            topology.joined(closure).any(|body| self.holds(topology, body))
                || (matches!(self, Self::Root) && topology.ends_on_root(closure))
        };
        (0..topology.machine.closures.len()).filter(ends)
    }

    /// Returns whether gravity or the root's motion acts. A floating group has its own inertial motion, which includes gravity; the whole
    /// group falls with the same acceleration, so that its internal forces depend neither on gravity nor on accelerations of the root
    /// frame.
    fn feels(self, topology: &Topology, input: Input) -> bool {
        match self {
            Self::Root => (0..topology.machine.bodies.len()).any(|body| self.holds(topology, body)),
            Self::Group(first) => !topology.floats(first) || matches!(input, Input::RootAngularVelocity),
            Self::Flight(_) => matches!(input, Input::Gravity | Input::RootAngularVelocity),
        }
    }
}

/// Bodies whose accelerations act on the force of a closed loop with inertia.
pub(super) fn loop_reach(topology: &Topology, closure: usize) -> Reach {
    let mut groups = topology.joined(closure).map(|body| topology.group[body]);
    Reach::Group(groups.next().expect("a loop has a point on a body"))
}

/// Returns whether a prescribed joint between the root and either side of a closed loop makes its gap a function of time.
fn stretched(topology: &Topology, closure: usize) -> bool {
    topology.joined(closure).any(|body| moved(topology, body))
}

/// Initial force of a closed loop: depends on its gap, on the rate of the gap with a damper or inertia, and on all accelerations with
/// inertia.
fn loop_pulls_initially(topology: &Topology, closure: usize, known: Known) -> bool {
    if topology.machine.closures[closure].resists_acceleration() {
        return accelerates_initially(topology, loop_reach(topology, closure), known);
    }
    loop_stretches_initially(topology, closure, known)
}

/// Initial force of a closed loop's spring and damper.
fn loop_stretches_initially(topology: &Topology, closure: usize, known: Known) -> bool {
    let damped = topology.machine.closures[closure].damping_n_s_m > 0.0;
    topology.joined(closure).any(|body| {
        topology
            .folds(body)
            .any(|joint| starts(topology, joint, known) || (damped && start_rate(topology, joint, known)))
    })
}

/// Returns whether a change of a start angle or rate may change the rate of a loop's gap, whose inertia has kinetic energy. The angle of the
/// first rotating joint turns the gap of a loop on the root as a whole, which changes the rate of its length only if the body also translates.
fn loop_moves_initially(topology: &Topology, closure: usize, known: Known) -> bool {
    let on_root = topology.ends_on_root(closure);
    let turns = |joints: &[Turning]| joints.iter().any(|&joint| topology.starts_turning(joint));
    topology.machine.closures[closure].resists_acceleration()
        && topology.joined(closure).filter(|&body| moves_at_start(topology, body)).any(|body| {
            let path = &topology.path[body];
            path.iter().enumerate().any(|(i, &joint)| {
                let Turning::Revolute(joint) = joint else { return false };
                let matters = !on_root || turns(&path[..i]) || topology.drifts(body);
                start_rate(topology, joint, known) || (starts(topology, joint, known) && matters)
            })
        })
}

/// Returns whether a prescribed joint between the root and a body makes its position a function of time.
fn moved(topology: &Topology, body: usize) -> bool {
    topology.folds(body).any(|joint| topology.is_prescribed(joint))
}

fn any_moved(topology: &Topology) -> bool {
    (0..topology.revolutes.len()).any(|joint| topology.is_prescribed(joint))
}

/// Everything that changes accelerations within reach instantaneously.
fn pushes(topology: &Topology, reach: Reach, known: Known) -> bool {
    match known {
        Known::Time => {
            (0..topology.machine.bodies.len()).any(|body| reach.holds(topology, body) && moved(topology, body))
                || reach.loops(topology).any(|closure| stretched(topology, closure))
        }
        Known::Input(input) => match input {
            Input::Joint(joint, JointInput::Command | JointInput::Torque | JointInput::GeneratorOn) => {
                reach.holds(topology, topology.revolutes[joint])
            }
            // a voltage acts on the rate of the current, which is a state
            Input::Joint(_, JointInput::Release | JointInput::LatchEnable | JointInput::Voltage) => false,
            Input::Load(station) => reach.holds(topology, topology.stations[station].0),
            Input::Gravity | Input::RootAcceleration | Input::RootAngularVelocity | Input::RootAngularAcceleration => {
                reach.feels(topology, input)
            }
            // The aerodynamic loads at a communication point are given; wind acts on those of later steps.
            Input::Wind | Input::Flap(_) | Input::FlapRate(_) => false,
            // failures act through events, which change the state
            Input::Failure(_) => false,
        },
        Known::Parameter(_) => false,
    }
}

/// Initial accelerations within reach: loads, start angles and rates, joint parameters, inertia; strains and their rates are zero, so
/// neither stiffness nor damping acts yet.
fn accelerates_initially(topology: &Topology, reach: Reach, known: Known) -> bool {
    let joint_in = |joint: usize| reach.holds(topology, topology.revolutes[joint]);
    if reach.loops(topology).any(|closure| loop_stretches_initially(topology, closure, known)) {
        return true;
    }
    match known {
        Known::Input(Input::Joint(joint, JointInput::Release)) => joint_in(joint),
        Known::Input(Input::Joint(joint, JointInput::LatchEnable)) => joint_in(joint) && starts_closed(topology, joint),
        Known::Parameter(Parameter::Joint(joint, field)) => {
            joint_in(joint)
                && match field {
                    JointParameter::StartAngle
                    | JointParameter::Stiffness
                    | JointParameter::ConstantTorque
                    | JointParameter::TorqueLimit
                    | JointParameter::SpringStiffness
                    | JointParameter::RestAngle => true,
                    JointParameter::Damping | JointParameter::SpringDamping => topology.turns_at_start(joint),
                    JointParameter::LatchStiffness => starts_closed(topology, joint),
                    JointParameter::RateLimit => false,
                }
        }
        Known::Parameter(Parameter::Spatial(joint, field)) => {
            reach.holds(topology, topology.spatials[joint])
                && match field {
                    SpatialParameter::Damping => topology.spins_at_start(joint),
                    SpatialParameter::Stiffness => false,
                }
        }
        Known::Parameter(Parameter::Body(body, field)) => {
            reach.holds(topology, body)
                && match field {
                    BodyParameter::MassFactor => true,
                    BodyParameter::MassDamping => moves_on_carrier(topology, body),
                    BodyParameter::StiffnessFactor | BodyParameter::StiffnessDamping => false,
                }
        }
        Known::Time | Known::Input(_) | Known::Parameter(_) => pushes(topology, reach, known),
    }
}

/// Initial moment of a ball joint, in the root frame: only its damper acts.
fn damps_initially(topology: &Topology, body: usize, known: Known) -> bool {
    let own = topology.spatials.iter().position(|&other| other == body);
    own.is_some_and(|joint| {
        topology.spins_at_start(joint)
            && (known == Known::Parameter(Parameter::Spatial(joint, SpatialParameter::Damping))
                || topology.folds(body).any(|inner| starts(topology, inner, known)))
    })
}

/// Returns whether a body moves at the start.
fn moves_at_start(topology: &Topology, body: usize) -> bool {
    topology.drifts(body) || topology.path[body].iter().any(|&joint| topology.starts_turning(joint))
}

/// Returns whether a body moves at the start relative to its carrier: the root, or the first body outboard of a free joint.
fn moves_on_carrier(topology: &Topology, body: usize) -> bool {
    let own = usize::from(topology.flies(body));
    topology.path[body].iter().skip(own).any(|&joint| topology.starts_turning(joint))
}

/// Initial kinetic energy: non-zero only for bodies that move at the start.
fn moves_initially(topology: &Topology, known: Known) -> bool {
    if let Known::Parameter(Parameter::Body(body, BodyParameter::MassFactor)) = known {
        return moves_at_start(topology, body);
    }
    if (0..topology.machine.closures.len()).any(|closure| loop_moves_initially(topology, closure, known)) {
        return true;
    }
    let turns = |joints: &[Turning]| joints.iter().any(|&joint| topology.starts_turning(joint));
    topology.path.iter().enumerate().any(|(body, path)| {
        path.iter().enumerate().any(|(i, &joint)| {
            let Turning::Revolute(joint) = joint else { return false };
            // The angle of the first rotating joint moves the wing as a whole, which changes the energy only if the wing also translates.
            let matters = turns(&path[..i]) || (topology.drifts(body) && turns(&path[i..]));
            start_rate(topology, joint, known) || (starts(topology, joint, known) && matters)
        })
    })
}
