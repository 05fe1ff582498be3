//! Forces of a modal body: elastic forces and those of the mass between its ends, and its energies.

use super::{Modal, ModalWork, inside, square};
use crate::beam::modal_mass::{MassForces, MassMotion};
use crate::load::RootMotion;
use crate::multibody::motion::Motion;
use crate::multibody::node::Node;
use nalgebra::{Matrix3, Vector3};

/// A mass between the ends and its motion, frame of the inner end.
struct Moving {
    mass_kg: f64,
    /// Position relative to the first node in m.
    place: Vector3<f64>,
    /// Velocity relative to that frame in m/s.
    rate: Vector3<f64>,
}

impl Modal {
    /// Writes the elastic and damping forces of the shapes, eqs. (M5) and (M6), without adding to previous values of these entries.
    pub(crate) fn own_forces(&self, motion: Motion, residual: &mut [f64]) {
        let (range, element) = (self.range(), &self.element);
        let (q, v) = (&motion.q[range.clone()], &motion.v[range.clone()]);
        for (i, out) in residual[range].iter_mut().enumerate() {
            *out = (0..q.len()).map(|j| element.stiffness[(i, j)] * q[j] + element.damping[(i, j)] * v[j]).sum();
        }
    }

    /// Adds the inertia forces minus the weight of the mass between the ends, eq. (M9), on the first node and with `PROJECT` on the
    /// coordinates. The first node holds the rates of its nodal vectors.
    pub(crate) fn inertia_forces<const PROJECT: bool>(
        &self,
        work: &ModalWork,
        node: &mut Node,
        root: &RootMotion,
        residual: &mut [f64],
    ) {
        let axes = &node.rotation;
        let origin = inside(axes, &node.load_rate[0]);
        let [x, y, z] = [1, 2, 3].map(|k| inside(axes, &node.load_rate[k]));
        let spread = Matrix3::from_columns(&[x, y, z]);
        // factor 2 of the Coriolis acceleration
        let spin = inside(axes, &(node.spin + root.angular_velocity_rad_s)) * 2.0;
        let own_residual = &mut residual[self.range()];
        if let Some(moments) = &self.element.moments {
            let [q, v, a] = [&work.q, &work.v, &work.a].map(|all| std::array::from_fn(|i| all[i]));
            let motion = MassMotion { q: &q, v: &v, a: &a, origin, spread, twice_spin: spin };
            let MassForces { force, moment, on_coordinates } = moments.forces(&motion);
            if PROJECT {
                own_residual.iter_mut().zip(&on_coordinates).for_each(|(out, force)| *out += force);
            }
            node.force += axes * force;
            node.moment += axes * moment;
            return;
        }
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        let modes = self.element.modes;
        let (q, v, a) = (&work.q[..modes], &work.v[..modes], &work.a[..modes]);
        for point in &self.element.masses {
            let shapes = &point.shapes;
            let (shortened, drawn) = (shapes.shortened(q), shapes.shortened(v));
            let place = shapes.position_m(q, &shortened);
            let rate = shapes.moved(v, &shortened);
            let second = Vector3::new(-square(&drawn, v), 0.0, 0.0) + shapes.moved(a, &shortened);
            let own = (origin + spread * place + spin.cross(&rate) + second) * point.mass_kg;
            force += own;
            moment += place.cross(&own);
            if PROJECT {
                for (i, out) in own_residual.iter_mut().enumerate() {
                    *out += shapes.velocity(i, &shortened).dot(&own);
                }
            }
        }
        node.force += axes * force;
        node.moment += axes * moment;
    }

    fn moving(&self, work: &ModalWork) -> impl Iterator<Item = Moving> {
        let modes = self.element.modes;
        self.element.masses.iter().map(move |point| {
            let shortened = point.shapes.shortened(&work.q[..modes]);
            let rate = (0..modes).map(|i| point.shapes.velocity(i, &shortened) * work.v[i]).sum();
            Moving { mass_kg: point.mass_kg, place: point.shapes.position_m(&work.q[..modes], &shortened), rate }
        })
    }

    /// Masses between the ends, each with position (m) and velocity (m/s) relative to the root frame, after a sweep.
    pub(crate) fn masses(
        &self,
        work: &ModalWork,
        node: &Node,
    ) -> impl Iterator<Item = (f64, Vector3<f64>, Vector3<f64>)> {
        self.moving(work).map(move |moving| {
            let arm = node.rotation * moving.place;
            let velocity = node.velocity + node.spin.cross(&arm) + node.rotation * moving.rate;
            (moving.mass_kg, node.position + arm, velocity)
        })
    }

    /// Elastic energy `½ qᵀK q` in J.
    pub(crate) fn elastic_j(&self, q: &[f64]) -> f64 {
        let q = &q[self.range()];
        let row = |i: usize| (0..q.len()).map(|j| self.element.stiffness[(i, j)] * q[j]).sum::<f64>();
        0.5 * (0..q.len()).map(|i| q[i] * row(i)).sum::<f64>()
    }

    /// `vᵀC v` in W: the power dissipated by the damping.
    pub(crate) fn damping_w(&self, v: &[f64]) -> f64 {
        let v = &v[self.range()];
        let row = |i: usize| (0..v.len()).map(|j| self.element.damping[(i, j)] * v[j]).sum::<f64>();
        (0..v.len()).map(|i| v[i] * row(i)).sum()
    }
}
