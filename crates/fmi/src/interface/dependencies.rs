//! Which row depends on which, at a communication point and in Initialization Mode.
//!
//! At a communication point the state is frozen: strains, angles, their rates, the stoppers and the latches.
//! What follows from the state alone (positions, velocities, angles, stored energy of the wing) depends on no
//! input; accelerations and the forces recovered from them depend on everything that pushes within the branch.
//! At the start the strains are the natural ones and at rest, so the state follows from start angles, start
//! rates and the inputs that decide about stoppers and latches; the springs of universal and ball joints are slack.
//! Where the experiment starts from equilibrium the state depends on all that acts on the machine.

use crate::interface::air::{blows, blows_initially};
use crate::interface::binding::{
    Binding, BodyParameter, EnergyOutput, Input, JointInput, JointOutput, JointParameter, Output, Parameter,
    PointOutput, SpatialParameter,
};
use crate::interface::hinge_dependencies::{
    commands_joint, latch_pulls, latches, motor_pulls_initially, spring_pulls_initially, spring_stores_initially,
    start_rate, starts, starts_closed, turns_joint,
};
use crate::interface::point_dependencies::point_initially;
use crate::interface::topology::{Topology, Turning};
use crate::interface::{Dependencies, DependencyKind, MOST_LISTED, Stage};
use foldwing_engine::machine::{Machine, StartState};

/// The dependencies of every row of a machine's table; `bindings` are those of all rows.
pub(super) fn find(machine: &Machine, bindings: &[Binding]) -> Vec<Dependencies> {
    let topology = Topology::new(machine);
    let knowns: Vec<(u32, Binding)> =
        (0..).zip(bindings.iter().copied()).filter(|(_, known)| !known.is_computed()).collect();
    let of = |output: Output| {
        let initial = |known: Binding| match settles(&topology, output) {
            true => DependencyKind::Dependent,
            false => initial_kind(output, known),
        };
        let running = knowns
            .iter()
            .filter(|(_, known)| depends(&topology, output, *known))
            .map(|(reference, _)| (*reference, DependencyKind::Dependent));
        let initial = knowns
            .iter()
            .filter(|(_, known)| depends_initially(&topology, output, *known))
            .map(|&(reference, known)| (reference, initial(known)));
        // one more than allowed tells that there are more
        let (running, initial): (Vec<_>, Vec<_>) =
            (running.take(MOST_LISTED + 1).collect(), initial.take(MOST_LISTED + 1).collect());
        if running.len().max(initial.len()) > MOST_LISTED {
            return Dependencies { on_all: true, ..Dependencies::default() };
        }
        Dependencies { running, initial, on_all: false }
    };
    let row = |binding: &Binding| match *binding {
        Binding::Output(output) => of(output),
        _ => Dependencies::default(),
    };
    bindings.iter().map(row).collect()
}

/// Pairs of outputs and knowns of which one depends on the other: at a communication point, or in initialisation.
pub(super) struct Dependence<'a> {
    topology: Topology<'a>,
    stage: Stage,
}

impl<'a> Dependence<'a> {
    /// Of a machine.
    pub fn new(machine: &'a Machine, stage: Stage) -> Self {
        Self { topology: Topology::new(machine), stage }
    }

    /// Whether the output depends on the known.
    pub fn holds(&self, output: Output, known: Binding) -> bool {
        match self.stage {
            Stage::Starting => depends_initially(&self.topology, output, known),
            Stage::Running => depends(&self.topology, output, known),
        }
    }
}

/// Of the initial dependences only the angle's on its own start value has a constant factor.
fn initial_kind(output: Output, known: Binding) -> DependencyKind {
    match (output, known) {
        (Output::Joint(_, JointOutput::Angle), Binding::Parameter(_)) => DependencyKind::Constant,
        _ => DependencyKind::Dependent,
    }
}

/// Whether the initial value is that of an equilibrium, on which all that loads or holds the machine acts. Stoppers hold
/// the angles of joints that are not latched, and the start rates are the model's.
fn settles(topology: &Topology, output: Output) -> bool {
    let starts_at_rest = topology.machine.experiment.start == StartState::Equilibrium;
    starts_at_rest
        && match output {
            Output::Joint(joint, JointOutput::Angle) => {
                topology.has_elastic_latch(joint) && starts_closed(topology, joint)
            }
            Output::Joint(_, field) => matches!(
                field,
                JointOutput::TorqueApplied
                    | JointOutput::MotorTorque
                    | JointOutput::SpringTorque
                    | JointOutput::HoldingTorque
                    | JointOutput::LatchTorque
                    | JointOutput::LatchReaction
            ),
            _ => true,
        }
}

/// Dependence at a communication point, state frozen.
fn depends(topology: &Topology, output: Output, known: Binding) -> bool {
    use EnergyOutput as E;
    match output {
        Output::Joint(joint, JointOutput::Angle | JointOutput::Rate) => {
            known == Binding::Time && topology.is_prescribed(joint)
        }
        Output::Joint(joint, JointOutput::TorqueApplied) => commands_joint(joint, known) || turns_joint(joint, known),
        Output::Joint(joint, JointOutput::MotorTorque) => commands_joint(joint, known),
        Output::Joint(joint, JointOutput::ExternalTorque) => turns_joint(joint, known),
        Output::Joint(
            _,
            JointOutput::SpringTorque
            | JointOutput::LatchTorque
            | JointOutput::Latched
            | JointOutput::LatchTime
            | JointOutput::LatchCount
            | JointOutput::LatchImpulse,
        ) => false,
        // Attitude and angular velocity are relative to the parent.
        Output::Spatial(_, _) => false,
        // A ball joint passes on the moment of its spring and damper only.
        Output::JointMoment(body, _) if topology.is_ball(body) => known == Binding::Time && moved(topology, body),
        // Without inertia a penalty force follows from the state alone.
        Output::LoopForce(closure, _) if topology.machine.closures[closure].inertia_kg == 0.0 => {
            known == Binding::Time && stretched(topology, closure)
        }
        Output::LoopGap(closure, _) => known == Binding::Time && stretched(topology, closure),
        // where something holds the joint; zero otherwise
        Output::Joint(_, JointOutput::HoldingTorque | JointOutput::LatchReaction)
        | Output::Gauge(_)
        | Output::SectionForce(_, _)
        | Output::SectionMoment(_, _)
        | Output::LoopForce(_, _)
        | Output::RootForce(_)
        | Output::RootMoment(_)
        | Output::JointForce(_, _)
        | Output::JointMoment(_, _)
        | Output::Tip(_, PointOutput::Acceleration(_) | PointOutput::AngularAcceleration(_))
        | Output::Station(_, PointOutput::Acceleration(_) | PointOutput::AngularAcceleration(_)) => {
            pushes(topology, reach(topology, output), known) || blows(topology, known)
        }
        Output::AirForce(_)
        | Output::AirMoment(_)
        | Output::AirStationForce(_, _)
        | Output::AirStationMoment(_, _)
        | Output::AirCirculation(_) => blows(topology, known),
        Output::Tip(_, _) | Output::Station(_, _) => {
            known == Binding::Time && body(topology, output).is_some_and(|body| moved(topology, body))
        }
        Output::Energy(E::Kinetic) => known == Binding::Time && any_moved(topology),
        Output::Energy(E::Elastic) => {
            known == Binding::Time && (0..topology.machine.closures.len()).any(|closure| stretched(topology, closure))
        }
        Output::Energy(E::Dissipated) => false,
        // A jump of an input moves a potential at once; the jump is booked as its work.
        Output::Energy(E::Work) => weighs(known) || commands(known),
        Output::Energy(E::Gravity) => weighs(known) || (known == Binding::Time && any_moved(topology)),
        Output::Energy(E::Drive) => commands(known),
        Output::Energy(E::Total) => {
            let parts = [E::Kinetic, E::Elastic, E::Gravity, E::Drive];
            parts.into_iter().any(|part| depends(topology, Output::Energy(part), known))
        }
    }
}

/// Dependence of the initial value.
fn depends_initially(topology: &Topology, output: Output, known: Binding) -> bool {
    use EnergyOutput as E;
    if settles(topology, output) {
        return match known {
            Binding::Time => any_moved(topology),
            Binding::Input(_) => true,
            Binding::Parameter(Parameter::Joint(_, JointParameter::RateLimit) | Parameter::Solver(_)) => false,
            Binding::Parameter(_) => true,
            Binding::Output(_) | Binding::Local(_) | Binding::Duration(_) => false,
        };
    }
    match output {
        Output::Joint(joint, JointOutput::Angle) => starts(topology, joint, known),
        Output::Joint(joint, JointOutput::Rate) => start_rate(topology, joint, known),
        Output::Joint(joint, JointOutput::TorqueApplied) => {
            motor_pulls_initially(topology, joint, known)
                || spring_pulls_initially(topology, joint, known)
                || turns_joint(joint, known)
        }
        Output::Joint(joint, JointOutput::MotorTorque) => motor_pulls_initially(topology, joint, known),
        Output::Joint(joint, JointOutput::SpringTorque) => spring_pulls_initially(topology, joint, known),
        Output::Joint(joint, JointOutput::ExternalTorque) => turns_joint(joint, known),
        Output::Joint(joint, JointOutput::LatchTorque) => latch_pulls(topology, joint, known),
        Output::Joint(joint, JointOutput::Latched) => latches(topology, joint, known),
        // A latch that is closed at the start has not closed: the first closing is the first event.
        Output::Joint(_, JointOutput::LatchTime | JointOutput::LatchCount | JointOutput::LatchImpulse) => false,
        Output::Gauge(gauge) => {
            let body = topology.machine.gauges[gauge].body;
            accelerates_initially(topology, reach(topology, output), known)
                || blows_initially(topology, known)
                || known == Binding::Parameter(Parameter::Body(body, BodyParameter::StiffnessFactor))
        }
        Output::Spatial(_, _) => false,
        Output::LoopGap(closure, _) => topology
            .joined(closure)
            .into_iter()
            .any(|body| topology.folds(body).any(|joint| starts(topology, joint, known))),
        Output::LoopForce(closure, _) => loop_pulls_initially(topology, closure, known),
        Output::JointMoment(body, _) if topology.is_ball(body) => damps_initially(topology, body, known),
        Output::Joint(_, JointOutput::HoldingTorque | JointOutput::LatchReaction)
        | Output::SectionForce(_, _)
        | Output::SectionMoment(_, _)
        | Output::RootForce(_)
        | Output::RootMoment(_)
        | Output::JointForce(_, _)
        | Output::JointMoment(_, _) => {
            accelerates_initially(topology, reach(topology, output), known) || blows_initially(topology, known)
        }
        Output::AirForce(_)
        | Output::AirMoment(_)
        | Output::AirStationForce(_, _)
        | Output::AirStationMoment(_, _)
        | Output::AirCirculation(_) => blows_initially(topology, known),
        Output::Tip(_, field) | Output::Station(_, field) => body(topology, output).is_some_and(|body| match field {
            PointOutput::Acceleration(_) | PointOutput::AngularAcceleration(_) => {
                accelerates_initially(topology, reach(topology, output), known) || blows_initially(topology, known)
            }
            _ => point_initially(topology, body, field, known),
        }),
        Output::Energy(E::Kinetic) => moves_initially(topology, known),
        Output::Energy(E::Elastic) => {
            (0..topology.revolutes.len()).any(|joint| {
                topology.is_free(joint)
                    && (latch_pulls(topology, joint, known) || spring_stores_initially(topology, joint, known))
            }) || (0..topology.machine.closures.len())
                .any(|closure| topology.opens(closure).any(|joint| starts(topology, joint, known)))
        }
        Output::Energy(E::Gravity) => {
            weighs(known)
                || is_mass_factor(known)
                || (0..topology.revolutes.len()).any(|joint| starts(topology, joint, known))
        }
        Output::Energy(E::Drive) => match known {
            Binding::Input(Input::Joint(_, JointInput::Command)) => true,
            Binding::Parameter(Parameter::Joint(joint, field)) => {
                topology.is_free(joint)
                    && matches!(
                        field,
                        JointParameter::StartAngle
                            | JointParameter::Stiffness
                            | JointParameter::ConstantTorque
                            | JointParameter::TorqueLimit
                    )
            }
            _ => false,
        },
        Output::Energy(E::Work | E::Dissipated) => false,
        Output::Energy(E::Total) => [E::Kinetic, E::Elastic, E::Gravity, E::Drive]
            .into_iter()
            .any(|part| depends_initially(topology, Output::Energy(part), known)),
    }
}

/// Body that an output's point or joint belongs to.
fn body(topology: &Topology, output: Output) -> Option<usize> {
    match output {
        Output::Gauge(gauge) => Some(topology.machine.gauges[gauge].body),
        Output::SectionForce(place, _) | Output::SectionMoment(place, _) => {
            Some(topology.machine.section_loads[place].body)
        }
        Output::Tip(tip, _) => Some(topology.tips[tip]),
        Output::Station(station, _) => Some(topology.stations[station].0),
        Output::Joint(joint, JointOutput::HoldingTorque | JointOutput::LatchReaction) => {
            Some(topology.revolutes[joint])
        }
        Output::JointForce(body, _) | Output::JointMoment(body, _) => Some(body),
        Output::LoopGap(closure, _) | Output::LoopForce(closure, _) => Some(topology.joined(closure)[0]),
        _ => None,
    }
}

/// Bodies whose accelerations an output feels.
#[derive(Debug, Clone, Copy)]
enum Reach {
    /// All branches that the root holds.
    Root,
    /// The branches that closed loops with inertia join, by their group: groups meet only at the root, whose motion is
    /// given, and in springs and dampers, whose forces follow from the state.
    Group(usize),
    /// Inertial motion of a group that floats.
    Flight(usize),
}

impl Reach {
    fn holds(self, topology: &Topology, body: usize) -> bool {
        match self {
            Self::Root => !topology.floats(body),
            Self::Group(first) | Self::Flight(first) => topology.group[body] == first,
        }
    }

    /// Closed loops that end on a body within reach.
    fn loops(self, topology: &Topology) -> impl Iterator<Item = usize> {
        let ends = move |&closure: &usize| topology.joined(closure).into_iter().any(|body| self.holds(topology, body));
        (0..topology.machine.closures.len()).filter(ends)
    }

    /// Whether gravity or the root's motion acts. What floats has its own inertial motion, of which gravity is part;
    /// all of it falls alike, so that forces inside feel neither gravity nor accelerations of the root frame.
    fn feels(self, topology: &Topology, input: Input) -> bool {
        match self {
            Self::Root => (0..topology.machine.bodies.len()).any(|body| self.holds(topology, body)),
            Self::Group(first) => !topology.floats(first) || matches!(input, Input::RootAngularVelocity(_)),
            Self::Flight(_) => matches!(input, Input::Gravity(_) | Input::RootAngularVelocity(_)),
        }
    }
}

fn reach(topology: &Topology, output: Output) -> Reach {
    match (output, body(topology, output)) {
        (
            Output::Tip(_, PointOutput::Acceleration(_)) | Output::Station(_, PointOutput::Acceleration(_)),
            Some(body),
        ) if topology.floats(body) => Reach::Flight(topology.group[body]),
        (_, body) => body.map_or(Reach::Root, |body| Reach::Group(topology.group[body])),
    }
}

/// A prescribed joint between the root and either side of a closed loop makes its gap a function of time.
fn stretched(topology: &Topology, closure: usize) -> bool {
    topology.joined(closure).into_iter().any(|body| moved(topology, body))
}

/// Initial force of a closed loop: of its gap, of the gap's rate where it has a damper or inertia, of everything that
/// accelerates where it has inertia.
fn loop_pulls_initially(topology: &Topology, closure: usize, known: Binding) -> bool {
    if topology.machine.closures[closure].inertia_kg > 0.0 {
        return accelerates_initially(topology, reach(topology, Output::LoopForce(closure, 0)), known);
    }
    loop_stretches_initially(topology, closure, known)
}

/// Initial force of a closed loop's spring and damper.
fn loop_stretches_initially(topology: &Topology, closure: usize, known: Binding) -> bool {
    let damped = topology.machine.closures[closure].damping_n_s_m > 0.0;
    topology.joined(closure).into_iter().any(|body| {
        topology
            .folds(body)
            .any(|joint| starts(topology, joint, known) || (damped && start_rate(topology, joint, known)))
    })
}

/// Whether what a start angle or rate changes may change the rate of a loop's gap, whose inertia has kinetic energy.
fn loop_moves_initially(topology: &Topology, closure: usize, known: Binding) -> bool {
    topology.machine.closures[closure].inertia_kg > 0.0
        && topology.joined(closure).into_iter().filter(|&body| moves_at_start(topology, body)).any(|body| {
            topology.folds(body).any(|joint| starts(topology, joint, known) || start_rate(topology, joint, known))
        })
}

/// A prescribed joint between the root and a body makes its position a function of time.
fn moved(topology: &Topology, body: usize) -> bool {
    topology.folds(body).any(|joint| topology.is_prescribed(joint))
}

fn any_moved(topology: &Topology) -> bool {
    (0..topology.revolutes.len()).any(|joint| topology.is_prescribed(joint))
}

/// Gravity and the root's linear acceleration.
fn weighs(known: Binding) -> bool {
    matches!(known, Binding::Input(Input::Gravity(_) | Input::RootAcceleration(_)))
}

fn commands(known: Binding) -> bool {
    matches!(known, Binding::Input(Input::Joint(_, JointInput::Command)))
}

fn is_mass_factor(known: Binding) -> bool {
    matches!(known, Binding::Parameter(Parameter::Body(_, BodyParameter::MassFactor)))
}

/// Everything that changes accelerations within reach at once.
fn pushes(topology: &Topology, reach: Reach, known: Binding) -> bool {
    match known {
        Binding::Time => {
            (0..topology.machine.bodies.len()).any(|body| reach.holds(topology, body) && moved(topology, body))
                || reach.loops(topology).any(|closure| stretched(topology, closure))
        }
        Binding::Input(input) => match input {
            Input::Joint(joint, JointInput::Command | JointInput::Torque) => {
                reach.holds(topology, topology.revolutes[joint])
            }
            Input::Joint(_, JointInput::Release | JointInput::LatchEnable) => false,
            Input::StationForce(station, _) | Input::StationMoment(station, _) => {
                reach.holds(topology, topology.stations[station].0)
            }
            Input::Gravity(_)
            | Input::RootAcceleration(_)
            | Input::RootAngularVelocity(_)
            | Input::RootAngularAcceleration(_) => reach.feels(topology, input),
            // The air's loads at a communication point are known already; wind acts on those to come.
            Input::Wind(_) => false,
        },
        Binding::Parameter(_) | Binding::Output(_) | Binding::Local(_) | Binding::Duration(_) => false,
    }
}

/// Initial accelerations within reach: what pushes, start angles and rates, joint parameters, inertia; strains are
/// natural and at rest, so neither stiffness nor its damping acts yet.
fn accelerates_initially(topology: &Topology, reach: Reach, known: Binding) -> bool {
    let joint_in = |joint: usize| reach.holds(topology, topology.revolutes[joint]);
    if reach.loops(topology).any(|closure| loop_stretches_initially(topology, closure, known)) {
        return true;
    }
    match known {
        Binding::Input(Input::Joint(joint, JointInput::Release)) => joint_in(joint),
        Binding::Input(Input::Joint(joint, JointInput::LatchEnable)) => {
            joint_in(joint) && starts_closed(topology, joint)
        }
        Binding::Parameter(Parameter::Joint(joint, field)) => {
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
        Binding::Parameter(Parameter::Spatial(joint, field)) => {
            reach.holds(topology, topology.spatials[joint])
                && match field {
                    SpatialParameter::Damping => topology.spins_at_start(joint),
                    SpatialParameter::Stiffness => false,
                }
        }
        Binding::Parameter(Parameter::Body(body, field)) => {
            reach.holds(topology, body)
                && match field {
                    BodyParameter::MassFactor => true,
                    BodyParameter::MassDamping => moves_on_carrier(topology, body),
                    BodyParameter::StiffnessFactor | BodyParameter::StiffnessDamping => false,
                }
        }
        _ => pushes(topology, reach, known),
    }
}

/// Initial moment of a ball joint: of its damper alone, in the root frame.
fn damps_initially(topology: &Topology, body: usize, known: Binding) -> bool {
    let own = topology.spatials.iter().position(|&other| other == body);
    own.is_some_and(|joint| {
        topology.spins_at_start(joint)
            && (known == Binding::Parameter(Parameter::Spatial(joint, SpatialParameter::Damping))
                || topology.folds(body).any(|inner| starts(topology, inner, known)))
    })
}

/// Whether a body moves at the start.
fn moves_at_start(topology: &Topology, body: usize) -> bool {
    topology.drifts(body) || topology.path[body].iter().any(|&joint| topology.starts_turning(joint))
}

/// Whether a body moves at the start relative to what carries it: the root, or the first body behind a free joint.
fn moves_on_carrier(topology: &Topology, body: usize) -> bool {
    let own = usize::from(topology.flies(body));
    topology.path[body].iter().skip(own).any(|&joint| topology.starts_turning(joint))
}

/// Initial kinetic energy: only bodies that move at the start have it.
fn moves_initially(topology: &Topology, known: Binding) -> bool {
    if let Binding::Parameter(Parameter::Body(body, BodyParameter::MassFactor)) = known {
        return moves_at_start(topology, body);
    }
    if (0..topology.machine.closures.len()).any(|closure| loop_moves_initially(topology, closure, known)) {
        return true;
    }
    let turns = |joints: &[Turning]| joints.iter().any(|&joint| topology.starts_turning(joint));
    topology.path.iter().enumerate().any(|(body, path)| {
        path.iter().enumerate().any(|(i, &joint)| {
            let Turning::Revolute(joint) = joint else { return false };
            // The angle of the first joint that turns moves the wing as a whole, which changes the energy only of
            // one that also drifts.
            let matters = turns(&path[..i]) || (topology.drifts(body) && turns(&path[i..]));
            start_rate(topology, joint, known) || (starts(topology, joint, known) && matters)
        })
    })
}
