//! Perturbed machines, and the parts of the residual in which they differ from the one that ran: its slopes need no more than these.

use crate::gradient::inputs::Offset;
use crate::gradient::replay::Replay;
use crate::gradient::tape::Tape;
use crate::machine::Effect;
use crate::multibody::Model;
use crate::multibody::block_slopes::{BlockSlopes, DampingSlope};
use crate::run::Plant;
use crate::system::equations::Equations;

/// A perturbed plant.
pub(super) struct Perturbed {
    /// Its weight in a slope.
    pub weight: f64,
    pub plant: Plant,
    /// Its change of the inputs over time.
    pub offset: Option<Offset>,
    /// Its slews and failures in the steps of the tape; `None` until it is initialised.
    pub replay: Option<Replay>,
}

impl Perturbed {
    pub fn new(weight: f64, plant: Plant, offset: Option<Offset>) -> Self {
        Self { weight, plant, offset, replay: None }
    }
}

/// Kind of the difference between the residuals of the machines.
pub(super) enum Difference {
    /// Only in joint forces: motion and nodal wrenches are those of the unperturbed model.
    Joints,
    /// In blocks of the mesh or in the damping of bodies as well.
    Mesh(Box<MeshSlopes>),
    /// In anything, such as lengths.
    Any,
}

/// Slopes of the parts of a residual that are linear in blocks of the mesh and in the damping.
pub(super) struct MeshSlopes {
    /// `None` if the blocks are those of the unperturbed model.
    pub blocks: Option<BlockSlopes>,
    /// `None` if the damping is.
    pub damping: Option<DampingSlope>,
}

impl Difference {
    pub fn of(plants: &mut [Perturbed], own: &Equations, tape: &Tape) -> Self {
        let same_loads = plants.iter_mut().all(|Perturbed { plant, offset, .. }| {
            let system = plant.system_mut();
            let of_joint = |index: usize| system.state.inputs.layout().joints.range().contains(&index);
            let column = offset.map(|offset| tape.inputs.columns()[offset.column].index);
            own.loads_are_those_of(&system.equations) && column.is_none_or(of_joint)
        });
        // failures change these blocks during the run
        let weakens = |effect: &Effect| matches!(effect, Effect::StiffnessLoss { .. } | Effect::LoopBreak { .. });
        let weakened = plants.iter_mut().any(|Perturbed { plant, .. }| {
            plant.system_mut().machine.failures.iter().any(|failure| weakens(&failure.effect))
        });
        // voltages are not forces on joints, the damping of modes is not linear in the blocks, and shapes and constraints are not among them
        let is_constrained = own.model.constraints() > 0;
        let has_others = !own.model.circuits.is_empty()
            || !own.model.damped_modes.is_empty()
            || own.model.bodies.iter().any(|body| body.modal.is_some());
        if !same_loads || weakened || has_others {
            return Self::Any;
        }
        let others = plants.iter_mut().map(|perturbed| (perturbed.weight, &perturbed.plant.system_mut().equations));
        let others: Vec<(f64, &Equations)> = others.collect();
        let damping = others.iter().map(|(weight, other)| (*weight, other.damping.as_slice()));
        let damping = DampingSlope::new(&own.model, &own.damping, damping);
        let models: Vec<(f64, &Model)> = others.iter().map(|(weight, other)| (*weight, &other.model)).collect();
        let is_same = models.iter().all(|(_, model)| **model == own.model);
        if is_same && damping.is_none() {
            return Self::Joints;
        }
        let blocks = if is_same { None } else { BlockSlopes::new(&own.model, models.into_iter()) };
        if is_constrained || !is_same && blocks.is_none() {
            return Self::Any;
        }
        Self::Mesh(Box::new(MeshSlopes { blocks, damping }))
    }
}

/// Whether the forces on joints may differ between models. Equal models have no slope, as the weights of a difference quotient cancel; rows of
/// the inputs over time differ only later.
pub(super) fn forces_differ(plants: &mut [Perturbed]) -> bool {
    let Some((first, others)) = plants.split_first_mut() else { return false };
    let own = first.plant.system_mut();
    first.offset.is_some()
        || !own.machine.failures.is_empty()
        || others.iter_mut().any(|other| {
            let other = other.plant.system_mut();
            other.state.inputs != own.state.inputs || !own.equations.forces.are_those_of(&other.equations.forces)
        })
}
