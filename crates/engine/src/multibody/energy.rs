//! Energies and powers of the tree, from the motion of the last sweep in the workspace.

use crate::load::RootMotion;
use crate::math::so3::hat;
use crate::math::strain::{SHEARED, STRAINS, Strain};
use crate::multibody::dynamics::Damping;
use crate::multibody::joint::JointWork;
use crate::multibody::model::{Base, Body, Element, Model, Strained};
use crate::multibody::nodal::multiply;
use crate::multibody::node::Node;
use crate::multibody::slope;
use crate::multibody::workspace::Workspace;
use nalgebra::{Matrix4, Vector3};

/// Dissipation of the mass-proportional damping, `α ėᵀM̂ė` of each beam with `ė` relative to the carrier of the tree, eq. (D15), in W; one
/// number per beam.
pub fn mass_damping_power(model: &Model, work: &Workspace, damping: &[Damping], mut per_body: impl FnMut(f64)) {
    let plain = |body: &Body| body.carrier.is_none() && !body.damps_attached;
    if model.bodies.iter().any(plain) {
        kinetic(model, work, |body, beam| {
            if plain(&model.bodies[body]) {
                per_body(2.0 * damping[body].mass_1_s * beam);
            }
        });
    }
    let rest = model.bodies.iter().zip(damping).filter(|(body, damping)| !plain(body) && damping.mass_1_s != 0.0);
    for (body, damping) in rest {
        let carrier = body.carrier.map(|node| &work.nodes[node]);
        let relative = |i: usize| {
            let node = &work.nodes[body.first_node + i];
            let [_, x, y, z] = nodal_vectors(node);
            let (velocity, spin) = carrier.map_or((node.velocity, node.spin), |carrier| node.relative_to(carrier));
            [velocity, spin.cross(&x), spin.cross(&y), spin.cross(&z)]
        };
        let mut form = 0.0;
        for i in 0..=body.elements {
            let here = relative(i);
            form += quadratic(&model.nodes[body.first_node + i].damped(body), &here, &here);
            if i < body.elements && !body.sheared {
                form += 2.0 * quadratic(&model.elements[body.first_element + i].cross_mass, &relative(i + 1), &here);
            }
        }
        for ends in slope::ends(model, work, body) {
            let rates = ends.field(|slope, node| slope.relative_velocities(node, carrier));
            form += ends.form(&rates, &rates);
        }
        per_body(damping.mass_1_s * form);
    }
}

/// Kinetic energy relative to the root frame, J: the total, and that of each body's beam through `per_body`.
pub fn kinetic(model: &Model, work: &Workspace, mut per_body: impl FnMut(usize, f64)) -> f64 {
    let mut total = 0.0;
    for (index, body) in model.bodies.iter().enumerate() {
        let form = if body.slim_mass { slim_form } else { quadratic };
        let mut beam = 0.0;
        let mut attached = 0.0;
        let mut rates = nodal_velocities(&work.nodes[body.first_node]);
        for i in 0..=body.elements {
            let mass = &model.nodes[body.first_node + i];
            beam += 0.5 * form(&mass.beam, &rates, &rates);
            if let Some(mass) = &mass.attached {
                attached += 0.5 * quadratic(mass, &rates, &rates);
            }
            if i < body.elements {
                let outer = nodal_velocities(&work.nodes[body.first_node + i + 1]);
                let cross = &model.elements[body.first_element + i].cross_mass;
                beam += if body.sheared { 0.0 } else { form(cross, &outer, &rates) };
                rates = outer;
            }
        }
        for ends in slope::ends(model, work, body) {
            let rates = ends.field(|slope, node| slope.velocities(node));
            beam += 0.5 * ends.form(&rates, &rates);
        }
        if let (Some(modal), Some(scratch)) = (&body.modal, &work.modal[index]) {
            let masses = modal.masses(scratch, &work.nodes[body.first_node]);
            beam += masses.map(|(mass_kg, _, velocity)| 0.5 * mass_kg * velocity.norm_squared()).sum::<f64>();
            if let Some(mass) = &model.nodes[body.last_node()].attached {
                let rates = nodal_velocities(&work.nodes[body.last_node()]);
                attached += 0.5 * quadratic(mass, &rates, &rates);
            }
        }
        per_body(index, beam);
        total += beam + attached;
    }
    total
}

/// Kinetic energy in J of the inertias that rotate with the joint angles only, eq. (D16).
pub fn kinetic_of_drives(model: &Model, work: &Workspace, v: &[f64]) -> f64 {
    let driven = model.bodies.iter().zip(&work.joints).filter(|(body, _)| body.joint.drive_inertia != 0.0);
    let rotors: f64 =
        driven.map(|(body, scratch)| 0.5 * body.joint.drive_inertia * rotor_rate(body, scratch, work, v).powi(2)).sum();
    rotors + model.circuits.iter().map(|circuit| circuit.energy_j(v)).sum::<f64>()
}

/// Rate of a motor's rotor divided by its gear ratio, in rad/s, or in m/s for a prismatic joint, eq. (D17).
fn rotor_rate(body: &Body, scratch: &JointWork, work: &Workspace, v: &[f64]) -> f64 {
    let own = v[body.joint.coordinate];
    match (body.joint.drive_carried, scratch.one_freedom(), body.base) {
        (carried, Some(one), Base::Node(node)) if carried != 0.0 => {
            own + carried * one.axis.dot(&work.nodes[node].spin)
        }
        _ => own,
    }
}

/// Power in W of the inertia forces of a rotating root frame on the rotors of motors, like [`frame_power`].
pub fn frame_power_of_drives(model: &Model, work: &Workspace, root: &RootMotion, v: &[f64]) -> f64 {
    let mut power = 0.0;
    for (body, scratch) in model.bodies.iter().zip(&work.joints).filter(|(body, _)| body.joint.drive_carried != 0.0) {
        let Some(one) = scratch.one_freedom() else { continue };
        let spin = match body.base {
            // a sliding joint has no rotor
            Base::Root(_) | Base::Axis(_) => Vector3::zeros(),
            Base::Node(node) => work.nodes[node].spin,
        };
        let added = root.inertial_angular_acceleration_rad_s2(&spin, &Vector3::zeros());
        let coupling = body.joint.drive_inertia * body.joint.drive_carried;
        power -= coupling * rotor_rate(body, scratch, work, v) * one.axis.dot(&added);
    }
    power
}

/// Strain energy of the beams and modal bodies in J, including the coupling within pairs.
pub fn elastic(model: &Model, q: &[f64]) -> f64 {
    strain_form(model, |body, elements| match body.sheared {
        false => excess_form::<STRAINS>(elements, q),
        true => excess_form::<SHEARED>(elements, q),
    })
    .into_iter()
    .sum::<f64>()
        * 0.5
        + model.bodies.iter().filter_map(|body| body.modal.as_ref()).map(|modal| modal.elastic_j(q)).sum::<f64>()
}

/// Power in W dissipated by the damping of modal bodies and by that of modes of beams.
pub fn modal_damping_power(model: &Model, v: &[f64]) -> f64 {
    let bodies: f64 = model.bodies.iter().filter_map(|body| body.modal.as_ref()).map(|modal| modal.damping_w(v)).sum();
    model.damped_modes.iter().fold(bodies, |sum, mode| sum + mode.power_w(v))
}

/// Power `Σ β_body q̇ᵀ K q̇` dissipated by the stiffness-proportional damping, in W.
pub fn stiffness_damping_power(model: &Model, v: &[f64], damping: &[Damping]) -> f64 {
    strain_form(model, |body, elements| match body.sheared {
        false => rate_form::<STRAINS>(body, elements, v),
        true => rate_form::<SHEARED>(body, elements, v),
    })
    .into_iter()
    .zip(damping)
    .map(|(form, damping)| form * damping.stiffness_s)
    .sum()
}

/// Quadratic form `xᵀ K x` per body.
fn strain_form<'a>(
    model: &'a Model,
    form: impl Fn(&Body, &[Element]) -> f64 + 'a,
) -> impl IntoIterator<Item = f64> + 'a {
    model
        .bodies
        .iter()
        .map(move |body| form(body, &model.elements[body.first_element..body.first_element + body.elements]))
}

/// The form for the strains minus the natural strains.
fn excess_form<const N: usize>(elements: &[Element], q: &[f64]) -> f64
where
    Element: Strained<N>,
{
    form_of::<N>(elements, |element| {
        let (strain, natural_strain): ([f64; N], _) = (element.strains(q), element.elastic().natural_strain);
        Strain::from_fn(|i, _| strain[i] - natural_strain[i])
    })
}

/// The form for the strain rates, with the damping factors.
fn rate_form<const N: usize>(body: &Body, elements: &[Element], v: &[f64]) -> f64
where
    Element: Strained<N>,
{
    form_of::<N>(elements, |element| {
        let rates = Strain::from(element.strains(v));
        body.damping_roots.map_or(rates, |roots| roots.fixed_rows::<N>(0).component_mul(&rates))
    })
}

fn form_of<const N: usize>(elements: &[Element], vector: impl Fn(&Element) -> Strain<N>) -> f64
where
    Element: Strained<N>,
{
    let mut form = 0.0;
    for (i, element) in elements.iter().enumerate() {
        let (x, elastic) = (vector(element), element.elastic());
        form += x.dot(&(elastic.stiffness * x));
        if i % 2 == 1 {
            form += 2.0 * x.dot(&(elastic.coupling * vector(&elements[i - 1])));
        }
    }
    form
}

/// First moment of mass of the whole tree about the root's origin, `∫ r dm` in kg·m.
pub fn first_moment_kg_m(model: &Model, work: &Workspace) -> Vector3<f64> {
    let mut sum = sum_of_mass_rows(model, |node| nodal_vectors(&work.nodes[node]));
    for ends in model.bodies.iter().flat_map(|body| slope::ends(model, work, body)) {
        let [inner, outer] = ends.forces(&ends.field(|slope, node| slope.vectors(node)));
        sum += inner[0] + outer[0];
    }
    for (body, scratch) in model.bodies.iter().zip(&work.modal) {
        if let (Some(modal), Some(scratch)) = (&body.modal, scratch) {
            for (mass_kg, position, _) in modal.masses(scratch, &work.nodes[body.first_node]) {
                sum += position * mass_kg;
            }
        }
    }
    sum
}

/// Mass of the whole tree in kg.
pub fn mass_kg(model: &Model) -> f64 {
    let modal = model.bodies.iter().filter_map(|body| body.modal.as_ref());
    let modal = modal.flat_map(|modal| &modal.element.masses).map(|point| point.mass_kg).sum::<f64>();
    let unit = [Vector3::x(), Vector3::zeros(), Vector3::zeros(), Vector3::zeros()];
    let sheared = model.elements.iter().filter(|element| element.inner_mass.is_some());
    let sheared = sheared.map(|element| slope::forces::<false>(element, &[unit; 2]));
    let sheared = sheared.map(|[inner, outer]| inner[0].x + outer[0].x).sum::<f64>();
    sum_of_mass_rows(model, |_| unit).x + modal + sheared
}

/// `Σ uᵀ M̂ e` of all elements except those with shear, with `u` that selects positions: the shape functions of the positions add up to
/// one.
fn sum_of_mass_rows(model: &Model, vectors: impl Fn(usize) -> [Vector3<f64>; 4]) -> Vector3<f64> {
    let row = |mass: &Matrix4<f64>, e: &[Vector3<f64>; 4]| multiply(mass, e)[0];
    let mut sum = Vector3::zeros();
    for body in &model.bodies {
        for i in 0..=body.elements {
            let n = body.first_node + i;
            let e = vectors(n);
            sum += row(&model.nodes[n].beam, &e);
            if let Some(attached) = &model.nodes[n].attached {
                sum += row(attached, &e);
            }
            if i < body.elements && !body.sheared {
                let cross = &model.elements[body.first_element + i].cross_mass;
                sum += row(cross, &e) + row(&cross.transpose(), &vectors(n + 1));
            }
        }
        if let (Some(_), Some(attached)) = (&body.modal, &model.nodes[body.last_node()].attached) {
            sum += row(attached, &vectors(body.last_node()));
        }
    }
    sum
}

/// Power in W of the inertia forces due to a rotating root frame: centrifugal and Euler terms (the Coriolis term does no work).
pub fn frame_power(model: &Model, work: &Workspace, root: &RootMotion) -> f64 {
    let turn = hat(&root.angular_velocity_rad_s);
    let frame = hat(&root.angular_acceleration_rad_s2) + turn * turn;
    let turned = |node: usize| nodal_vectors(&work.nodes[node]).map(|vector| frame * vector);
    let mut power = 0.0;
    for (body, scratch) in model.bodies.iter().zip(&work.modal) {
        if let (Some(modal), Some(scratch)) = (&body.modal, scratch) {
            let masses = modal.masses(scratch, &work.nodes[body.first_node]);
            power -= masses.map(|(mass_kg, r, v)| mass_kg * v.dot(&(frame * r))).sum::<f64>();
            if let Some(attached) = &model.nodes[body.last_node()].attached {
                power -=
                    quadratic(attached, &nodal_velocities(&work.nodes[body.last_node()]), &turned(body.last_node()));
            }
        }
        for i in 0..=body.elements {
            let n = body.first_node + i;
            let rates = nodal_velocities(&work.nodes[n]);
            let here = turned(n);
            power -= quadratic(&model.nodes[n].beam, &rates, &here);
            if let Some(attached) = &model.nodes[n].attached {
                power -= quadratic(attached, &rates, &here);
            }
            if i < body.elements && !body.sheared {
                let cross = &model.elements[body.first_element + i].cross_mass;
                let outer = nodal_velocities(&work.nodes[n + 1]);
                power -= quadratic(cross, &outer, &here) + quadratic(cross, &turned(n + 1), &rates);
            }
        }
        for ends in slope::ends(model, work, body) {
            let rates = ends.field(|slope, node| slope.velocities(node));
            let turned = ends.field(|slope, node| slope.vectors(node).map(|vector| frame * vector));
            power -= ends.form(&rates, &turned);
        }
    }
    power
}

/// `(r, r_x, r_y, r_z)` of a node.
fn nodal_vectors(node: &Node) -> [Vector3<f64>; 4] {
    let column = |k: usize| node.rotation.fixed_view::<3, 1>(0, k).into_owned();
    [node.position, column(0), column(1), column(2)]
}

/// Rates of the nodal vectors relative to the root frame.
fn nodal_velocities(node: &Node) -> [Vector3<f64>; 4] {
    let [_, x, y, z] = nodal_vectors(node);
    [node.velocity, node.spin.cross(&x), node.spin.cross(&y), node.spin.cross(&z)]
}

/// Bilinear form `Σ m[i,j] a_i · b_j`.
fn quadratic(mass: &Matrix4<f64>, a: &[Vector3<f64>; 4], b: &[Vector3<f64>; 4]) -> f64 {
    multiply(mass, b).iter().zip(a).map(|(mb, a)| a.dot(mb)).sum()
}

/// [`quadratic`], reduced for blocks that couple only `r` and `r_x`.
fn slim_form(mass: &Matrix4<f64>, a: &[Vector3<f64>; 4], b: &[Vector3<f64>; 4]) -> f64 {
    a[0].dot(&(b[0] * mass[(0, 0)] + b[1] * mass[(0, 1)]))
        + a[1].dot(&(b[0] * mass[(1, 0)] + b[1] * mass[(1, 1)]))
        + a[2].dot(&b[2]) * mass[(2, 2)]
        + a[3].dot(&b[3]) * mass[(3, 3)]
}
