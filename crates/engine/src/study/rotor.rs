//! Identification of the rotor of a model: a shaft, a hub and equal blades with even spacing around the shaft.

use crate::machine::{JointKind, Machine, OneFreedom, Parent};
use crate::study::Study;
use crate::system::PlantError;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Angle in rad by which the azimuth of a blade may deviate.
const PLACE_RAD: f64 = 1e-6;

/// A rotor of equal blades.
#[derive(Debug, Clone, PartialEq)]
pub struct Rotor {
    /// Body attached by the joint that is the shaft.
    pub(crate) shaft: usize,
    /// Bodies of every blade, inner ones first; each blade leads the previous one in azimuth.
    pub(crate) blades: Vec<Vec<usize>>,
}

impl Rotor {
    /// Number of blades.
    pub fn blades(&self) -> usize {
        self.blades.len()
    }

    /// Bodies of every blade, inner ones first.
    pub fn bodies(&self) -> &[Vec<usize>] {
        &self.blades
    }
}

/// Children of a body.
fn children(machine: &Machine, of: usize) -> Vec<usize> {
    let carried =
        |body: &usize| matches!(machine.bodies[*body].joint.parent, Parent::Body { index, .. } if index == of);
    (0..machine.bodies.len()).filter(carried).collect()
}

/// A body and all bodies attached to it, directly or indirectly, inner ones first.
fn tree(machine: &Machine, of: usize) -> Vec<usize> {
    let mut list = vec![of];
    let mut next = 0;
    while next < list.len() {
        list.extend(children(machine, list[next]));
        next += 1;
    }
    list
}

/// Bodies attached to a body, except those that are part of it: rigid ones clamped to it without children, such as a spinner. If all are
/// such bodies, they may be the blades.
fn carried(machine: &Machine, of: usize) -> Vec<usize> {
    let all = children(machine, of);
    let moves = |body: &usize| {
        tree(machine, *body).into_iter().any(|body| {
            let body = &machine.bodies[body];
            !body.is_rigid() || !matches!(body.joint.kind, JointKind::Clamped)
        })
    };
    let moving: Vec<usize> = all.iter().copied().filter(moves).collect();
    if moving.is_empty() { all } else { moving }
}

/// The first body outward from a shaft that has several bodies attached: the hub.
fn hub(machine: &Machine, shaft: usize) -> Option<usize> {
    let mut body = shaft;
    loop {
        match carried(machine, body)[..] {
            [] => return None,
            [only] => body = only,
            _ => return Some(body),
        }
    }
}

/// Whether a joint can rotate without limit: it is a shaft if it carries a hub.
fn turns(joint: &JointKind) -> bool {
    let free = |joint: &OneFreedom| {
        joint.spring.is_none()
            && joint.motor.stiffness_n_m_rad == 0.0
            && joint.end_stops.is_none()
            && joint.latch.is_none()
    };
    matches!(joint, JointKind::Revolute(joint) if free(joint))
}

/// The body attached by the shaft: by the named joint, or by the only possible one.
pub(crate) fn shaft_of(machine: &Machine, named: Option<&str>) -> Result<usize, String> {
    if let Some(name) = named {
        let body = machine.bodies.iter().position(|body| body.joint.name == name);
        let body = body.ok_or_else(|| format!("shaft {name}: the model has no joint of this name"))?;
        return match machine.bodies[body].joint.kind {
            JointKind::Revolute(_) => Ok(body),
            JointKind::Clamped | JointKind::Prismatic(_) | JointKind::Sliding(_) | JointKind::Spatial(_) => {
                Err(format!("shaft {name}: the joint is not revolute; a shaft must be revolute"))
            }
        };
    }
    let may_be = |body: &usize| turns(&machine.bodies[*body].joint.kind) && hub(machine, *body).is_some();
    let list: Vec<usize> = (0..machine.bodies.len()).filter(may_be).collect();
    match list[..] {
        [only] => Ok(only),
        [] => Err("the model has no rotor: no revolute joint without spring, motor stiffness, end stops and latch carries a body with \
                   several others on it; name the joint of the shaft"
            .to_owned()),
        _ => {
            let names: Vec<&str> = list.iter().map(|body| machine.bodies[*body].joint.name.as_str()).collect();
            Err(format!("each of the joints {} may be the shaft; name one of them", names.join(", ")))
        }
    }
}

impl Study<'_> {
    /// Identifies the rotor of the model from its initial angles; state, loads and wind are unchanged. `shaft` names its joint; by
    /// default it is the only joint that rotates without limit and carries a hub, a body with several others attached.
    ///
    /// # Errors
    /// If there is no rotor, or if its blades are not copies of one blade rotated by equal angles around the shaft.
    pub fn rotor(&mut self, time_s: f64, shaft: Option<&str>) -> Result<Rotor, PlantError> {
        self.system.refuse_constraints("rotor analysis")?;
        self.system.refuse_dc_motor("rotor analysis")?;
        let kept = self.system.state.clone();
        let found = self.undeformed(time_s).map(|()| self.find_rotor(shaft));
        self.system.put_back(kept);
        found?.map_err(|cause| PlantError::Linearization { time_s, cause })
    }

    fn find_rotor(&self, shaft: Option<&str>) -> Result<Rotor, String> {
        let machine = &self.system.machine;
        let shaft = shaft_of(machine, shaft)?;
        let joint = &machine.bodies[shaft].joint;
        let hub = hub(machine, shaft).ok_or_else(|| {
            format!(
                "the joint {} carries no hub, a body with two or more blades on it; name another joint as the shaft",
                joint.name
            )
        })?;
        let JointKind::Revolute(hinge) = &joint.kind else {
            return Err(format!("the joint {} is not revolute", joint.name));
        };
        let sections = self.system.shape();
        let attitude = |body: usize| -> Matrix3<f64> { sections[body][0].rotation };
        let axis: Vector3<f64> = attitude(shaft) * joint.mount.transpose() * hinge.axis;
        let across = axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize();
        let roots = carried(machine, hub);
        let mut placed = Vec::new();
        for &root in &roots {
            let turn = attitude(root) * attitude(roots[0]).transpose();
            let turned = turn * across;
            let angle_rad = axis.dot(&across.cross(&turned)).atan2(across.dot(&turned));
            let (first, own) = (&machine.bodies[roots[0]].name, &machine.bodies[root].name);
            if (turn * axis - axis).norm() > PLACE_RAD {
                return Err(format!(
                    "{own} on {} is not a copy of {first} rotated about the joint {}: the hub must carry only equal \
                     blades, at equal start angles",
                    machine.bodies[hub].name, joint.name
                ));
            }
            placed.push((angle_rad.rem_euclid(TAU), tree(machine, root)));
        }
        // an angle less than a whole revolution by round-off counts as zero
        placed
            .iter_mut()
            .filter(|(angle_rad, _)| TAU - *angle_rad < PLACE_RAD)
            .for_each(|(angle_rad, _)| *angle_rad = 0.0);
        placed.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (k, (angle_rad, bodies)) in placed.iter().enumerate() {
            let wanted_rad = TAU * k as f64 / placed.len() as f64;
            if (angle_rad - wanted_rad).abs() > PLACE_RAD {
                return Err(format!(
                    "{} is {:.4} deg ahead of {}: {} blades must be evenly spaced, by {:.4} deg; is one missing?",
                    machine.bodies[bodies[0]].name,
                    angle_rad.to_degrees(),
                    machine.bodies[placed[0].1[0]].name,
                    placed.len(),
                    360.0 / placed.len() as f64
                ));
            }
        }
        Ok(Rotor { shaft, blades: placed.into_iter().map(|(_, bodies)| bodies).collect() })
    }
}
