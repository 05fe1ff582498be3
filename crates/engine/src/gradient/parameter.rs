//! Parameters of a run: any number of a machine, by perturbed models, eq. (X9).

use crate::force::drive::Pieces;
use crate::force::joint::JointForces;
use crate::force::memory::JointMemory;
use crate::force::set::Forces;
use crate::gradient::GradientError;
use crate::gradient::difference::{Difference, MeshSlopes, Perturbed, forces_differ};
use crate::gradient::impulse::Jump;
use crate::gradient::inputs::{InputRows, Offset};
use crate::gradient::replay::Replay;
use crate::gradient::tape::{Step, Tape};
use crate::machine::StartState;
use crate::multibody::derivative::Derivative;
use crate::multibody::joint::JointKind;
use crate::multibody::kinematics::Motion;
use crate::multibody::model::Body;
use crate::run::Plant;
use crate::signal::JointInputs;
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use crate::system::System;
use crate::system::air::AirHistory;
use crate::system::air::pieces::AirPieces;
use crate::system::equations::Equations;
use crate::system::failure_memory::FailureMemory;
use nalgebra::Matrix3;
use std::mem::offset_of;
use std::sync::Arc;

/// Steps and weights over the step of central differences of fourth order.
const CENTRAL: [(f64, f64); 4] = [(-2.0, 1.0 / 12.0), (-1.0, -8.0 / 12.0), (1.0, 8.0 / 12.0), (2.0, -1.0 / 12.0)];
/// The same to one side, for a parameter at the end of its range.
const ONE_SIDED: [(f64, f64); 5] = [(0.0, -25.0 / 12.0), (1.0, 4.0), (2.0, -3.0), (3.0, 4.0 / 3.0), (4.0, -1.0 / 4.0)];

/// A number of a machine, a start value of one of its inputs and parameters, or values of an input over time.
///
/// Residual, start state and outputs are differenced along the tape, not the run: at a step of a thousandth of the number, or of its usual
/// size, fourth-order differences of these smooth functions have 1e-12 of truncation and of round-off.
pub struct Parameter {
    name: String,
    /// Perturbed plants, with their weights in a slope.
    perturbed: Vec<Perturbed>,
    /// The rows of the input over time whose values are differentiated by, each a parameter of its own; `None` for a single number.
    rows: Option<Vec<usize>>,
}

impl Parameter {
    /// A parameter from a function that gives the plant, not initialised, for a value of it. `step`: positive, in the unit of the value.
    /// `name`: for messages.
    ///
    /// Differences are central, or one-sided where the function returns errors for values on one side, such as a damping below zero.
    ///
    /// # Errors
    /// That of the function, if values on both sides are errors.
    pub fn new<E>(
        name: impl Into<String>,
        value: f64,
        step: f64,
        plant: impl Fn(f64) -> Result<Plant, E>,
    ) -> Result<Self, E> {
        let perturbed = |rule: &[(f64, f64)], step: f64| {
            rule.iter()
                .map(|(steps, weight)| Ok(Perturbed::new(weight / step, plant(value + steps * step)?, None)))
                .collect::<Result<_, E>>()
        };
        let perturbed = perturbed(&CENTRAL, step).or_else(|refused| {
            perturbed(&ONE_SIDED, step).or_else(|_| perturbed(&ONE_SIDED, -step)).map_err(|_| refused)
        })?;
        Ok(Self { name: name.into(), perturbed, rows: None })
    }

    /// Values of an input over time in some of its rows, each a parameter: `column` is its place in [`InputRows::columns`]. `step`: positive,
    /// in the unit of the input, of the differences of residuals with all rows of the column changed; a row has its share of them.
    /// `plant` gives the present plant, not initialised.
    ///
    /// # Errors
    /// That of the function.
    pub fn of_rows<E>(
        name: impl Into<String>,
        (column, rows): (usize, Vec<usize>),
        step: f64,
        plant: impl Fn() -> Result<Plant, E>,
    ) -> Result<Self, E> {
        let perturbed = |&(steps, weight): &(f64, f64)| {
            let offset = Some(Offset { column, row: None, by: steps * step });
            Ok(Perturbed::new(weight / step, plant()?, offset))
        };
        let perturbed = CENTRAL.iter().map(perturbed).collect::<Result<_, E>>()?;
        Ok(Self { name: name.into(), perturbed, rows: Some(rows) })
    }

    /// The parameter, or one for each of its rows, where a row has no fixed share in an effect: a motor with a rate limit remembers earlier
    /// rows of its command, and the air follows the rate of the wind, eq. (Q4).
    pub(super) fn apart(self, own: &System, tape: &Tape) -> Vec<Self> {
        let layout = own.state.inputs.layout();
        let slewed = |index: usize| {
            let command = |joint: usize| layout.joints.place(joint, offset_of!(JointInputs, command_rad)) == index;
            // at a runaway a motor without a rate limit gets one
            let slews = |(joint, memory): (usize, &JointMemory)| command(joint) && !memory.slew.follows_at_once();
            tape.steps.iter().any(|step| step.joints.iter().enumerate().any(slews))
        };
        let is_wind = |index: usize| own.state.air.is_some() && layout.wind_m_s.range().contains(&index);
        let column = self.perturbed.first().and_then(|perturbed| tape.inputs.columns().get(perturbed.offset?.column));
        let has_no_share = column.is_some_and(|column| slewed(column.index) || is_wind(column.index));
        let (Some(rows), true) = (&self.rows, has_no_share) else { return vec![self] };
        let of_row = |row: &usize| {
            let perturbed = |from: &Perturbed| {
                let system = &from.plant.system;
                let mut plant = Plant::new(Arc::clone(&system.machine));
                plant.inputs_mut().clone_from(&system.state.inputs);
                plant.parameters_mut().clone_from(&system.state.parameters);
                let offset = from.offset.map(|offset| Offset { row: Some(*row), ..offset });
                Perturbed::new(from.weight, plant, offset)
            };
            Self { name: self.name.clone(), perturbed: self.perturbed.iter().map(perturbed).collect(), rows: None }
        };
        rows.iter().map(of_row).collect()
    }

    /// Number of perturbed models: 4 for central differences, 5 for one-sided ones.
    pub fn machines(&self) -> usize {
        self.perturbed.len()
    }
}

/// The perturbed models, at work.
pub(super) struct Neighbours {
    plants: Vec<Perturbed>,
    /// The rows of the input over time, or `None` for a single number.
    pub rows: Option<Vec<usize>>,
    /// Slopes of the start's coordinates and rates.
    pub start: [Vec<f64>; 2],
    /// Slopes of the start's memory of the air.
    pub start_memory: Vec<f64>,
    difference: Difference,
    /// Whether forces on joints may differ.
    forces: bool,
    scratch: Vec<f64>,
    slope: Vec<f64>,
    /// Address of the step in whose state the machines are.
    adopted: usize,
}

/// Value of `adopted` after other uses of the machines.
const NOT_ADOPTED: usize = 0;

/// The unperturbed machine, and the pieces of the functions of its rotor at the start of the run.
type Own<'a> = (&'a System, &'a AirPieces);

impl Neighbours {
    pub fn new(parameter: Parameter, (own, begun): Own, tape: &Tape) -> Result<Self, GradientError> {
        let time_s = tape.steps.first().map_or(0.0, |step| step.start.time_s);
        let Parameter { name, perturbed: mut plants, rows } = parameter;
        let refuse = |what| GradientError::Structure { parameter: name.clone(), what };
        let coordinates = own.coordinates();
        let mut start = [vec![0.0; coordinates], vec![0.0; coordinates]];
        let mut start_memory = Vec::new();
        for Perturbed { weight, plant, offset, replay } in &mut plants {
            let rows = rows.iter().flatten();
            if offset.as_ref().is_some_and(|own| !tape.inputs.has(own.column, rows.chain(&own.row))) {
                let cause = format!("parameter {name} has no such real input over time, or no such row");
                return Err(GradientError::Inputs { cause });
            }
            tape.inputs.set_with(plant, time_s, *offset);
            let rests = own.machine.experiment.start == StartState::Equilibrium;
            plant.system_mut().hold_air((!rests).then_some(begun));
            plant.initialize(time_s)?;
            let system = plant.system_mut();
            system.hold_air(None);
            if rests && !system.starts_on(begun) {
                return Err(refuse("the interval of a polar or the cell of the turbulence in which a section starts"));
            }
            if system.coordinates() != coordinates || system.outputs.values().len() != own.outputs.values().len() {
                return Err(refuse("the number of coordinates or outputs"));
            }
            system.refuse_gradient()?;
            if !system.equations.model.bodies.iter().zip(&own.equations.model.bodies).all(same_axes) {
                return Err(refuse("the angle between the axes of a universal joint"));
            }
            let knots = |system: &System| -> Vec<Option<Vec<f64>>> {
                system.equations.forces.joints().iter().map(|joint| Some(joint.law()?.knots_s().collect())).collect()
            };
            if knots(system) != knots(own) {
                return Err(refuse("the times of a prescribed motion"));
            }
            if let Some(first) = tape.steps.first() {
                let held = system.state.joints.iter().zip(&first.joints);
                if held.clone().count() != first.joints.len()
                    || held.clone().any(|(a, b)| {
                        (a.released, a.latch.closed, a.latch.enabled, a.contact)
                            != (b.released, b.latch.closed, b.latch.enabled, b.contact)
                    })
                {
                    return Err(refuse("the state of a joint at the start (lock, latch or stop)"));
                }
                let failed = |memory: &FailureMemory| (memory.brought_s.is_some(), memory.has_failed());
                if !system.state.failures.iter().map(failed).eq(first.failures.iter().map(failed)) {
                    return Err(refuse("a failure at the start"));
                }
                if rests && pieces(system, &system.state.start) != pieces(own, &first.start) {
                    return Err(refuse("whether a motor is at its torque limit at the start"));
                }
            }
            if law_rows(system).ne(law_rows(own)) {
                return Err(refuse("the number of rows of a generator's table"));
            }
            *replay = Some(Replay::of(system, &own.machine, tape, *offset).map_err(refuse)?);
            if let Some(air) = tape.steps.first().and_then(|step| step.air.as_deref()) {
                if !system.state.air.as_ref().is_some_and(|own| air.fits(own)) {
                    return Err(refuse("the number of aerodynamic sections"));
                }
                if own.air_step_s() != system.air_step_s() {
                    return Err(refuse("the aerodynamic step"));
                }
                let reference: Vec<_> = air.begin.iter().map(|begin| begin.motion.rotation).collect();
                let memory = system.air_memory(&reference);
                start_memory.resize(memory.len(), 0.0);
                super::add(&mut start_memory, *weight, &memory);
            }
            let (mut q, mut v) = (system.state.now.q.clone(), system.state.now.v.clone());
            if let Some(first) = tape.steps.first() {
                align_quaternions(system, &first.start.q, [&mut q, &mut v]);
            }
            super::add(&mut start[0], *weight, &q);
            super::add(&mut start[1], *weight, &v);
        }
        let difference = Difference::of(&mut plants, &own.equations, tape);
        let forces = forces_differ(&mut plants);
        let [scratch, slope] = [(); 2].map(|()| vec![0.0; coordinates]);
        Ok(Self { plants, rows, start, start_memory, difference, forces, scratch, slope, adopted: NOT_ADOPTED })
    }

    /// Place of the input over time whose rows are differentiated by, among its columns; `None` for a single number.
    pub fn column(&self) -> Option<usize> {
        self.plants.first().and_then(|perturbed| perturbed.offset).map(|offset| offset.column)
    }

    /// Adopts the states of the joints in a step.
    pub fn adopt(&mut self, step: &Step, inputs: &InputRows) {
        let address = std::ptr::from_ref(step).addr();
        if std::mem::replace(&mut self.adopted, address) == address {
            return;
        }
        for Perturbed { plant, offset, replay, .. } in &mut self.plants {
            let system = plant.system_mut();
            take(system, step, inputs, *offset);
            if let Some(replay) = replay {
                replay.impose(step, &mut system.state);
            }
            system.configure();
        }
    }

    /// Keeps the smooth pieces of the forces of another machine, eq. (X34).
    pub fn hold_as(&mut self, own: &Forces) {
        self.adopted = NOT_ADOPTED;
        self.plants.iter_mut().for_each(|perturbed| perturbed.plant.system_mut().equations.forces.hold_as(own));
    }

    /// The slope of the residual at the point of the last [`Self::find_residual_slope`].
    pub fn slope_of_residual(&self) -> &[f64] {
        &self.slope
    }

    /// Computes the slope of the residual at a point, at which that of `own` is linearised.
    pub fn find_residual_slope(&mut self, (own, derivative): (&Equations, &Derivative), at: &Point) {
        self.adopted = NOT_ADOPTED;
        let Self { plants, difference, scratch, slope, .. } = self;
        slope.fill(0.0);
        if let Difference::Mesh(mesh) = difference {
            let MeshSlopes { blocks, damping } = &mut **mesh;
            let motion = Motion { q: &at.q, v: &at.v, a: &at.a };
            if let Some(blocks) = blocks {
                blocks.residual((&own.work, derivative), (&own.root, &own.damping), motion, slope);
            }
            if let Some(damping) = damping {
                damping.add_residual((&own.model, &own.work, derivative), &own.root, motion, slope);
            }
            own.clear_held(slope);
        }
        for Perturbed { weight, plant, .. } in plants {
            let equations = &mut plant.system_mut().equations;
            match difference {
                Difference::Joints | Difference::Mesh(_) => {
                    if self.forces {
                        equations.add_joint_residual((at, &own.work), *weight, scratch, slope);
                    }
                }
                Difference::Any => {
                    equations.residual(at.time_s, &at.q, &at.v, &at.a, scratch);
                    super::add(slope, *weight, scratch);
                }
            }
        }
    }

    /// Adds the slope of the momenta of a jump of the rates to `slope`.
    pub fn momentum_slope(&mut self, jump: &Jump, slope: &mut [f64]) {
        self.adopted = NOT_ADOPTED;
        match self.difference {
            // the masses are those of the unperturbed model
            Difference::Joints => return,
            Difference::Mesh(_) | Difference::Any => {}
        }
        for Perturbed { weight, plant, .. } in &mut self.plants {
            jump.momentum(plant.system_mut(), &mut self.scratch, *weight, slope);
        }
    }

    /// Slopes of an aerodynamic step from `before` to the motion `at` its end: of the memory of the air there and of the loads that act.
    pub fn air_slopes(
        &mut self,
        (before, pieces): (&AirHistory, &AirPieces),
        at: &Point,
        reference: &[Matrix3<f64>],
    ) -> Result<Vec<f64>, GradientError> {
        let mut slopes = Vec::new();
        self.adopted = NOT_ADOPTED;
        for Perturbed { weight, plant, .. } in &mut self.plants {
            let system = plant.system_mut();
            system.hold_air(Some(pieces));
            let values = system.air_step_values(before, at, reference)?;
            system.hold_air(None);
            slopes.resize(values.len(), 0.0);
            super::add(&mut slopes, *weight, &values);
        }
        Ok(slopes)
    }

    /// Slope of a number that each machine gives.
    pub fn slope(&mut self, mut of: impl FnMut(&mut System) -> f64) -> f64 {
        self.adopted = NOT_ADOPTED;
        self.plants.iter_mut().map(|perturbed| perturbed.weight * of(perturbed.plant.system_mut())).sum()
    }

    /// Adds the slopes of numbers that each machine gives to `sum`.
    pub fn add_slopes(&mut self, sum: &mut [f64], mut of: impl FnMut(&mut System, &mut [f64])) {
        self.adopted = NOT_ADOPTED;
        let mut each = vec![0.0; sum.len()];
        for Perturbed { weight, plant, .. } in &mut self.plants {
            of(plant.system_mut(), &mut each);
            super::add(sum, *weight, &each);
        }
    }
}

/// Change of the axes of a universal joint in the frames of its bodies, and of the cosine between them, that is round-off.
const SAME_AXES: f64 = 1e-12;

/// Whether universal joints of two machines have the same constraints.
fn same_axes((one, other): (&Body, &Body)) -> bool {
    let axes = |body: &Body| match body.joint.kind {
        JointKind::Universal { parent_axis, body_axis, cosine } => Some((parent_axis, body_axis, cosine)),
        JointKind::Clamped
        | JointKind::Revolute { .. }
        | JointKind::Prismatic { .. }
        | JointKind::Sliding
        | JointKind::Ball
        | JointKind::Free => None,
    };
    match (axes(one), axes(other)) {
        (Some((p, b, c)), Some((p1, b1, c1))) => {
            (p - p1).amax() < SAME_AXES && (b - b1).amax() < SAME_AXES && (c - c1).abs() < SAME_AXES
        }
        (one, other) => one.is_none() && other.is_none(),
    }
}

/// Gives the Euler parameters of joints the signs of those in `reference`: both signs are the same attitude.
fn align_quaternions(system: &System, reference: &[f64], [q, v]: [&mut [f64]; 2]) {
    for joint in
        system.equations.model.bodies.iter().map(|body| &body.joint).filter(|joint| joint.kind.constraints() == 1)
    {
        let range = joint.coordinate + joint.kind.translations()..joint.range().end;
        if super::dot(&q[range.clone()], &reference[range.clone()]) < 0.0 {
            q[range.clone()].iter_mut().chain(&mut v[range]).for_each(|entry| *entry = -*entry);
        }
    }
}

/// Pieces of the torques of motors at rest at the start of a run.
fn pieces(system: &System, start: &Point) -> Vec<Option<Pieces>> {
    let of_joint = |joint: &JointForces| {
        let (angle_rad, motor) = (start.q[joint.coordinate], joint.motor()?);
        Some(motor.drive.pieces(angle_rad, 0.0, motor.neutral(start.time_s).0))
    };
    system.equations.forces.joints().iter().map(of_joint).collect()
}

/// Numbers of rows of the generators' tables.
fn law_rows(system: &System) -> impl Iterator<Item = usize> {
    system.equations.forces.joints().iter().filter_map(|joint| Some(joint.generator()?.law.rows.len()))
}

/// Puts the system of a tape into the state of a step: joints, failures, inputs and the signs of quaternions.
pub(super) fn adopt(system: &mut System, step: &Step, inputs: &InputRows) {
    take(system, step, inputs, None);
    system.configure();
}

/// Takes over joints, failures, inputs and the signs of quaternions of a step.
fn take(system: &mut System, step: &Step, inputs: &InputRows, offset: Option<Offset>) {
    system.state.joints.clone_from(&step.joints);
    system.state.failures.clone_from(&step.failures);
    let [joints, tips, stations] = &step.attitudes;
    system.state.spatial_rotations.clone_from(joints);
    system.state.tip_rotations.clone_from(tips);
    system.state.station_rotations.clone_from(stations);
    if let (Some(own), Some(taped)) = (&mut system.state.air, &step.air) {
        own.copy_from(taped);
    }
    if !inputs.columns().is_empty() {
        inputs.write_present(step.piece, offset, &mut system.state);
    }
}
