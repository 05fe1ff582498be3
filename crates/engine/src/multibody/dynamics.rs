//! Residual of the equations of motion, \[O\] (9), by recursion: `BᵀM(ë − g) + K(q − q₀) + damping − loads`.
//!
//! Everything is expressed in the nodal vectors `(r, r_x, r_y, r_z)`: their mass is constant, so no velocity term appears except `ω × (ω ×
//! r_k)`, NOTATION eqs. (D4)–(D7).

use crate::load::{RootMotion, Wrench};
use crate::math::so3::hat;
use crate::math::strain::{SHEARED, STRAINS};
use crate::multibody::constraint;
pub use crate::multibody::elastic::Damping;
use crate::multibody::elastic::elastic_forces;
use crate::multibody::kinematics::{Motion, sweep_motion};
use crate::multibody::model::{Base, Body, Model};
use crate::multibody::nodal::{multiply, multiply_transposed, product, transposed_product, wrench_of};
use crate::multibody::rigid_loop;
use crate::multibody::slope;
use crate::multibody::station_load;
use crate::multibody::workspace::{Node, Pair, Workspace};
use nalgebra::{Matrix3, Vector3};

/// External actions on the tree.
#[derive(Debug, Clone, Copy)]
pub struct Environment<'a> {
    /// Gravity and motion of the root.
    pub root: &'a RootMotion,
    /// Damping per body.
    pub damping: &'a [Damping],
    /// Wrench per station, in the station's frame; empty without loads.
    pub stations: &'a [Wrench],
}

/// Computes the residual in generalised coordinates: the additional loads that would be needed to make the motion possible.
///
/// `residual` has [`Model::coordinates`] entries: N·m at joints (without motor torques, which the caller subtracts), N·m and N·m² at
/// strains. Stores poses, accelerations and accumulated wrenches in `work`. Allocates nothing.
pub fn residual(model: &Model, work: &mut Workspace, motion: Motion, environment: Environment, residual: &mut [f64]) {
    sweep_motion(model, work, motion);
    residual_of_swept(model, work, motion, environment, residual);
}

/// [`residual`] for a motion whose outward sweep is in `work`.
pub(crate) fn residual_of_swept(
    model: &Model,
    work: &mut Workspace,
    motion: Motion,
    environment: Environment,
    residual: &mut [f64],
) {
    elastic_forces(model, work, motion, environment.damping, residual);
    sweep_forces::<true>(model, work, motion, environment, residual);
}

/// Computes only the contents of `work` as after [`residual`], bit-identical; `scratch` has the size of a residual.
pub fn wrenches(model: &Model, work: &mut Workspace, motion: Motion, environment: Environment, scratch: &mut [f64]) {
    sweep_motion(model, work, motion);
    sweep_forces::<false>(model, work, motion, environment, scratch);
}

/// Adds the projection of loads at the stations on the coordinates, with the negative sign of [`residual`]. `work` must hold the poses; its
/// wrenches are overwritten.
pub fn project_loads(model: &Model, work: &mut Workspace, q: &[f64], loads: &[Wrench], residual: &mut [f64]) {
    for node in &mut work.nodes {
        (node.force, node.moment, node.fixed) = (Vector3::zeros(), Vector3::zeros(), Pair::ZERO);
    }
    station_load::apply_all(model, work, q, loads, residual);
    sweep_inward::<true>(model, work, residual);
}

/// Wrenches of all nodes and, with `PROJECT`, their projections on the coordinates, added to `residual`.
pub(super) fn sweep_forces<const PROJECT: bool>(
    model: &Model,
    work: &mut Workspace,
    motion: Motion,
    environment: Environment,
    residual: &mut [f64],
) {
    load_rates(model, work, environment);
    for (index, body) in model.bodies.iter().enumerate() {
        if let (Some(modal), Some(scratch)) = (&body.modal, &work.modal[index]) {
            modal.inertia_forces::<PROJECT>(scratch, &mut work.nodes[body.first_node], environment.root, residual);
            continue;
        }
        match (body.sheared, body.slim_mass) {
            (false, true) => inertia_forces::<true>(model, body, work),
            (false, false) => inertia_forces::<false>(model, body, work),
            (true, true) => slope::inertia_forces::<true, PROJECT>(model, body, work, residual),
            (true, false) => slope::inertia_forces::<false, PROJECT>(model, body, work, residual),
        }
    }
    if !environment.stations.is_empty() {
        station_load::apply_all(model, work, motion.q, environment.stations, residual);
    }
    react_on_carriers(model, work, environment.damping);
    let rotors_on_root = react_of_rotors::<PROJECT>(model, work, motion, environment.root, residual);
    let loops_on_root = constraint::apply_all(model, work, motion.a);
    sweep_inward::<PROJECT>(model, work, residual);
    if PROJECT {
        rigid_loop::violations(model, work, residual);
    }
    if let Some(wrench) = loops_on_root {
        work.root_force += wrench.linear;
        work.root_moment += wrench.angular;
    }
    if let Some(moment) = rotors_on_root {
        work.root_moment += moment;
    }
}

/// Adds the momenta in the directions of the coordinates of a field of velocities to `momenta`. `work` holds the poses, and the velocities
/// as accelerations of nodes at rest; its wrenches are overwritten. `motion` has zero rates and accelerations.
pub(crate) fn momenta(model: &Model, work: &mut Workspace, motion: Motion, damping: &[Damping], momenta: &mut [f64]) {
    let root = &RootMotion { gravity_m_s2: Vector3::zeros(), ..RootMotion::default() };
    sweep_forces::<true>(model, work, motion, Environment { root, damping, stations: &[] }, momenta);
}

/// Computes the rates of the nodal vectors that are multiplied by the mass, and the wrenches of attached masses, eq. (D5).
fn load_rates(model: &Model, work: &mut Workspace, environment: Environment) {
    let root = environment.root;
    let field = root.apparent_gravity_m_s2();
    let rotates = root.rotates();
    let turn = hat(&root.angular_velocity_rad_s);
    let frame = hat(&root.angular_acceleration_rad_s2) + turn * turn;
    for (body, damping) in model.bodies.iter().zip(environment.damping) {
        let range = body.first_node..=body.last_node();
        let alpha = damping.mass_1_s;
        let carrier = body.carrier.filter(|_| alpha != 0.0).map(|node| work.nodes[node]);
        for (node, mass) in work.nodes[range.clone()].iter_mut().zip(&model.nodes[range]) {
            let mut origin = node.acceleration - field;
            let mut spread = turning(&node.spin_rate, &node.spin);
            if rotates {
                origin += turn * node.velocity * 2.0 + frame * node.position;
                spread += turn * hat(&node.spin) * 2.0 + frame;
            }
            node.force = Vector3::zeros();
            node.moment = Vector3::zeros();
            node.fixed = Pair::ZERO;
            let (velocity, spin) = match &carrier {
                None => (node.velocity, node.spin),
                Some(carrier) => node.relative_to(carrier),
            };
            let damped = spread + hat(&(spin * alpha));
            node.load_rate = nodal_rates(origin + velocity * alpha, &damped, &node.rotation);
            if let Some(attached) = &mass.attached {
                let rates = match body.damps_attached {
                    true => node.load_rate,
                    false => nodal_rates(origin, &spread, &node.rotation),
                };
                let (force, moment) = wrench_of(&node.rotation, &multiply(attached, &rates));
                node.add_fixed(&force, &moment);
            }
        }
        if body.sheared {
            slope::load_rates(body, work, root, alpha);
        }
    }
}

/// Subtracts the resultant of the mass-proportional damping from the wrench on a carrier: the damping acts between the tree and its
/// carrier, eq. (D15).
fn react_on_carriers(model: &Model, work: &mut Workspace, damping: &[Damping]) {
    for (body, damping) in model.bodies.iter().zip(damping).filter(|(_, damping)| damping.mass_1_s != 0.0) {
        let Some(carrier) = body.carrier else { continue };
        let (force, moment) = damping_resultant(model, body, work, carrier);
        work.nodes[carrier].add_fixed(&(force * -damping.mass_1_s), &(moment * -damping.mass_1_s));
    }
}

/// Adds the effect of the carrier's rotation on the rotors of geared motors, and their reaction on it, eq. (D17). Returns the moment on the
/// root, if there is one.
fn react_of_rotors<const PROJECT: bool>(
    model: &Model,
    work: &mut Workspace,
    motion: Motion,
    root: &RootMotion,
    residual: &mut [f64],
) -> Option<Vector3<f64>> {
    let mut on_root = None;
    for (body, scratch) in model.bodies.iter().zip(&mut work.joints) {
        let joint = &body.joint;
        if joint.drive_carried == 0.0 {
            continue;
        }
        let Some(one) = scratch.one_freedom_mut() else { continue };
        let (spin, spin_rate) = match body.base {
            // a sliding joint has no rotor
            Base::Root(_) | Base::Axis(_) => (Vector3::zeros(), Vector3::zeros()),
            Base::Node(node) => (work.nodes[node].spin, work.nodes[node].spin_rate),
        };
        one.carrier_rate = one.axis.dot(&root.inertial_angular_acceleration_rad_s2(&spin, &spin_rate));
        let coupling = joint.drive_inertia * joint.drive_carried;
        if PROJECT {
            residual[joint.coordinate] += coupling * one.carrier_rate;
        }
        let moment = one.axis * (coupling * (motion.a[joint.coordinate] + joint.drive_carried * one.carrier_rate));
        match body.base {
            Base::Root(_) => on_root = Some(on_root.unwrap_or_else(Vector3::zeros) + moment),
            Base::Node(node) => work.nodes[node].add_fixed(&Vector3::zeros(), &moment),
            Base::Axis(_) => {}
        }
    }
    on_root
}

/// `Σ f` and `Σ e × f` about the carrier of `f = M̂ ė`, with `ė` relative to the carrier's rigid-body motion, for one body's beam.
fn damping_resultant(model: &Model, body: &Body, work: &Workspace, carrier: usize) -> (Vector3<f64>, Vector3<f64>) {
    let carrier = &work.nodes[carrier];
    let (mut force, mut moment) = slope::damping_resultant(model, body, work, carrier);
    let rates = |node: &Node| {
        let (velocity, spin) = node.relative_to(carrier);
        nodal_rates(velocity, &hat(&spin), &node.rotation)
    };
    let mut add = |node: &Node, forces: &[Vector3<f64>; 4]| {
        let (own_force, own_moment) = wrench_of(&node.rotation, forces);
        force += own_force;
        moment += own_moment + (node.position - carrier.position).cross(&own_force);
    };
    for i in 0..=body.elements {
        let node = &work.nodes[body.first_node + i];
        let here = rates(node);
        add(node, &multiply(&model.nodes[body.first_node + i].damped(body), &here));
        if i < body.elements && !body.sheared {
            let (outer, cross) =
                (&work.nodes[body.first_node + i + 1], &model.elements[body.first_element + i].cross_mass);
            add(node, &multiply_transposed(cross, &rates(outer)));
            add(outer, &multiply(cross, &here));
        }
    }
    (force, moment)
}

/// Adds the inertia forces of the beams: from the lumped mass of each node and the adjacent elements, eqs. (D5) and (D7).
fn inertia_forces<const SLIM: bool>(model: &Model, body: &Body, work: &mut Workspace) {
    let nodes = &mut work.nodes[body.first_node..=body.last_node()];
    for i in 0..nodes.len() {
        let forces = beam_force::<SLIM>(model, body, i, |i| &nodes[i].load_rate);
        let (force, moment) = wrench_of(&nodes[i].rotation, &forces);
        nodes[i].force += force;
        nodes[i].moment += moment;
    }
}

/// Forces on the nodal vectors of node `i` of a body, with the given `load_rate` of its nodes, eq. (D5).
#[inline(always)]
pub(crate) fn beam_force<'a, const SLIM: bool>(
    model: &Model,
    body: &Body,
    i: usize,
    load_rate: impl Fn(usize) -> &'a [Vector3<f64>; 4],
) -> [Vector3<f64>; 4] {
    let elements = &model.elements[body.first_element..body.first_element + body.elements];
    let mut forces = product::<SLIM>(&model.nodes[body.first_node + i].beam, load_rate(i));
    if i > 0 {
        let from_inner = product::<SLIM>(&elements[i - 1].cross_mass, load_rate(i - 1));
        forces.iter_mut().zip(&from_inner).for_each(|(sum, force)| *sum += force);
    }
    if let Some(element) = elements.get(i) {
        let from_outer = transposed_product::<SLIM>(&element.cross_mass, load_rate(i + 1));
        forces.iter_mut().zip(&from_outer).for_each(|(sum, force)| *sum += force);
    }
    forces
}

/// `[α]× + [ω]×²`: maps a vector fixed to the node to its acceleration.
#[inline]
fn turning(spin_rate: &Vector3<f64>, spin: &Vector3<f64>) -> Matrix3<f64> {
    let square = spin.norm_squared();
    hat(spin_rate) + spin * spin.transpose() - Matrix3::from_diagonal_element(square)
}

/// Rates of the four nodal vectors from that of the origin and the matrix that is applied to the gradients.
#[inline]
fn nodal_rates(origin: Vector3<f64>, turn: &Matrix3<f64>, rotation: &Matrix3<f64>) -> [Vector3<f64>; 4] {
    let gradients = turn * rotation;
    [
        origin,
        gradients.fixed_view::<3, 1>(0, 0).into_owned(),
        gradients.fixed_view::<3, 1>(0, 1).into_owned(),
        gradients.fixed_view::<3, 1>(0, 2).into_owned(),
    ]
}

/// Projects the node wrenches on the coordinates, from the tips to the root, eq. (D9).
fn sweep_inward<const PROJECT: bool>(model: &Model, work: &mut Workspace, residual: &mut [f64]) {
    work.root_force = Vector3::zeros();
    work.root_moment = Vector3::zeros();
    for (index, body) in model.bodies.iter().enumerate().rev() {
        let outer = &work.nodes[body.last_node()];
        let (mut force, mut moment) = (outer.force, outer.moment);
        if let (Some(modal), Some(scratch)) = (&body.modal, &work.modal[index]) {
            if PROJECT {
                modal.project(scratch, &Pair { linear: force, angular: moment }, residual);
            }
            moment += scratch.arm.cross(&force);
            let inner = &mut work.nodes[body.first_node];
            inner.moment += moment;
            inner.force += force;
            (force, moment) = (inner.force, inner.moment);
        }
        (force, moment) = match body.sheared {
            false => sweep_body::<PROJECT, STRAINS>(model, body, work, (force, moment), residual),
            true => sweep_body::<PROJECT, SHEARED>(model, body, work, (force, moment), residual),
        };
        let joint = &work.joints[index];
        body.joint.project(joint, &Pair { linear: force, angular: moment }, residual);
        if !body.joint.kind.transmits() {
            // free body: at the solution this wrench is zero
            continue;
        }
        joint.pass_on(&force, &mut moment);
        match body.base {
            Base::Root(_) => {
                work.root_force += force;
                work.root_moment += moment + work.nodes[body.first_node].position.cross(&force);
            }
            Base::Node(node) => work.nodes[node].add_fixed(&force, &moment),
            Base::Axis(slide) => {
                let wrench = Pair { linear: force, angular: moment };
                let (slide, own) = (&model.slides[slide], &mut work.slides[slide]);
                own.pass_on::<PROJECT>(model, slide, &wrench, &mut work.nodes, residual);
            }
        }
    }
}

/// Sweeps the elements of one body: from the wrench at its last node to that at its first node.
#[inline(always)]
fn sweep_body<const PROJECT: bool, const N: usize>(
    model: &Model,
    body: &Body,
    work: &mut Workspace,
    (mut force, mut moment): (Vector3<f64>, Vector3<f64>),
    residual: &mut [f64],
) -> (Vector3<f64>, Vector3<f64>) {
    for i in (0..body.elements).rev() {
        let jacobian = work.jacobian(body.first_element + i);
        let arm = work.arms[body.first_element + i];
        let inner = &mut work.nodes[body.first_node + i];
        if PROJECT {
            let element = &model.elements[body.first_element + i];
            let (local_force, local_moment) = (inner.rotation.tr_mul(&force), inner.rotation.tr_mul(&moment));
            let res = &mut residual[element.range_of::<N>()];
            let projected: [f64; N] = jacobian.project(element.length_m, &local_force, &local_moment);
            res.iter_mut().zip(&projected).for_each(|(sum, term)| *sum += term);
        }
        moment += arm.cross(&force);
        inner.moment += moment;
        inner.force += force;
        (force, moment) = (inner.force, inner.moment);
    }
    (force, moment)
}
