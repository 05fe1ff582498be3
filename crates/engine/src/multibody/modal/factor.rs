//! A modal body in the articulated-body recursion: its coordinates are eliminated with one Cholesky factor, NOTATION
//! eqs. (M10) and (M11).

use super::{Modal, ModalWork};
use crate::beam::modal::MAXIMUM_MODES;
use crate::math::so3::hat;
use crate::multibody::elimination::{BadPivot, Weights};
use crate::multibody::node::{ArticulatedInertia, Node, Pair};
use nalgebra::{Matrix3, Vector3};

/// Factor of one elimination.
#[derive(Debug, Clone)]
pub(crate) struct ModalFactor {
    /// Lower Cholesky factor, with inverted diagonal.
    cholesky: [[f64; MAXIMUM_MODES]; MAXIMUM_MODES],
    /// Coupling of the coordinates to the first node, velocity rows.
    velocity: [Vector3<f64>; MAXIMUM_MODES],
    /// Coupling of the coordinates to the first node, spin rows.
    spin: [Vector3<f64>; MAXIMUM_MODES],
    /// Right-hand side of the last inward sweep.
    right: [f64; MAXIMUM_MODES],
}

impl ModalFactor {
    pub(crate) const ZERO: Self = Self {
        cholesky: [[0.0; MAXIMUM_MODES]; MAXIMUM_MODES],
        velocity: [Vector3::new(0.0, 0.0, 0.0); MAXIMUM_MODES],
        spin: [Vector3::new(0.0, 0.0, 0.0); MAXIMUM_MODES],
        right: [0.0; MAXIMUM_MODES],
    };

    fn solve(&self, modes: usize, x: &mut [f64; MAXIMUM_MODES]) {
        let l = &self.cholesky;
        for i in 0..modes {
            for k in 0..i {
                x[i] -= l[i][k] * x[k];
            }
            x[i] *= l[i][i];
        }
        for i in (0..modes).rev() {
            for k in i + 1..modes {
                x[i] -= l[k][i] * x[k];
            }
            x[i] *= l[i][i];
        }
    }
}

impl Modal {
    /// Eliminates the coordinates from the inertia `p` of the outer end and the mass in between; returns the inertia at the first node, eq.
    /// (M10). Only the symmetric part of the damping is used.
    pub(crate) fn eliminate(
        &self,
        work: &mut ModalWork,
        inner: &Node,
        p: &ArticulatedInertia,
        weights: Weights,
    ) -> Result<ArticulatedInertia, BadPivot> {
        let (element, modes) = (&self.element, self.element.modes);
        let axes = &inner.rotation;
        let mut x = [[0.0; MAXIMUM_MODES]; MAXIMUM_MODES];
        let mut uv = [Vector3::zeros(); MAXIMUM_MODES];
        let mut uw = [Vector3::zeros(); MAXIMUM_MODES];
        // the mass between the ends, in the frame of the inner end
        let (mut mass, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for point in &element.masses {
            let shapes = &point.shapes;
            let shortened = shapes.shortened(&work.q[..modes]);
            let place = shapes.position_m(&work.q[..modes], &shortened);
            let own = point.mass_kg * weights.mass;
            mass += own;
            first += place * own;
            second += place * place.transpose() * own;
            let partial: [Vector3<f64>; MAXIMUM_MODES] =
                std::array::from_fn(|i| if i < modes { shapes.velocity(i, &shortened) } else { Vector3::zeros() });
            for i in 0..modes {
                let weighted = partial[i] * own;
                uv[i] += weighted;
                uw[i] += place.cross(&weighted);
                for j in 0..=i {
                    x[i][j] += weighted.dot(&partial[j]);
                }
            }
        }
        let d = &work.arm;
        let vwt = p.vw.transpose();
        for i in 0..modes {
            let (jv, jw) = (&work.velocity[i], &work.spin[i]);
            let tv = p.vv * jv + p.vw * jw;
            let tw = vwt * jv + p.ww * jw;
            uv[i] = axes * uv[i] + tv;
            uw[i] = axes * uw[i] + tw + d.cross(&tv);
            for (j, entry) in x[i].iter_mut().enumerate().take(i + 1) {
                *entry += tv.dot(&work.velocity[j]) + tw.dot(&work.spin[j]);
                *entry += weights.stiffness * element.stiffness[(i, j)]
                    + 0.5 * weights.damping * (element.damping[(i, j)] + element.damping[(j, i)]);
            }
        }
        factorize(&mut x, modes).ok_or(BadPivot { coordinate: self.coordinate })?;

        let first = axes * first;
        let second = axes * second * axes.transpose();
        let (dh, sh) = (hat(d), hat(&first));
        let shift = p.vw - p.vv * dh;
        let mut vv = p.vv + Matrix3::from_diagonal_element(mass);
        let mut vw = shift - sh;
        let mut ww = p.ww - vwt * dh + dh * shift + Matrix3::from_diagonal_element(second.trace()) - second;
        let (mut zv, mut zw) = (uv, uw);
        for j in 0..modes {
            for k in 0..j {
                let l = x[j][k];
                zv[j] -= zv[k] * l;
                zw[j] -= zw[k] * l;
            }
            zv[j] *= x[j][j];
            zw[j] *= x[j][j];
            vv -= zv[j] * zv[j].transpose();
            vw -= zv[j] * zw[j].transpose();
            ww -= zw[j] * zw[j].transpose();
        }
        work.factor.cholesky = x;
        (work.factor.velocity, work.factor.spin) = (uv, uw);
        Ok(ArticulatedInertia { vv, vw, ww })
    }

    /// Inward half of the solution: from the right-hand side `p` at the outer end to that at the first node, without the contribution of
    /// the first node itself.
    pub(crate) fn reduce(&self, work: &mut ModalWork, x: &[f64], p: &Pair) -> Pair {
        let modes = self.element.modes;
        let mut right = [0.0; MAXIMUM_MODES];
        right[..modes].copy_from_slice(&x[self.range()]);
        self.pull(work, p, &mut right);
        work.factor.right = right;
        let mut y = right;
        work.factor.solve(modes, &mut y);
        let mut linear = p.linear;
        let mut angular = p.angular + work.arm.cross(&p.linear);
        for (j, value) in y.iter().enumerate().take(modes) {
            linear -= work.factor.velocity[j] * *value;
            angular -= work.factor.spin[j] * *value;
        }
        Pair { linear, angular }
    }

    fn pull(&self, work: &ModalWork, p: &Pair, out: &mut [f64; MAXIMUM_MODES]) {
        for (i, out) in out.iter_mut().enumerate().take(self.element.modes) {
            *out += work.velocity[i].dot(&p.linear) + work.spin[i].dot(&p.angular);
        }
    }

    /// Outward half: writes the coordinates to `x`; returns the twist of the outer end, from the twist `moved` of the first node.
    pub(crate) fn expand(&self, work: &ModalWork, x: &mut [f64], moved: &Pair) -> Pair {
        let modes = self.element.modes;
        let mut y = work.factor.right;
        for (j, value) in y.iter_mut().enumerate().take(modes) {
            *value -= work.factor.velocity[j].dot(&moved.linear) + work.factor.spin[j].dot(&moved.angular);
        }
        work.factor.solve(modes, &mut y);
        x[self.range()].copy_from_slice(&y[..modes]);
        self.displaced(work, moved, x)
    }
}

/// Cholesky factor in place, with inverted diagonal; `None` at a pivot that is not positive or not finite.
fn factorize(x: &mut [[f64; MAXIMUM_MODES]; MAXIMUM_MODES], modes: usize) -> Option<()> {
    for j in 0..modes {
        let pivot = x[j][j] - (0..j).map(|k| x[j][k] * x[j][k]).sum::<f64>();
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        let inverse = 1.0 / pivot.sqrt();
        x[j][j] = inverse;
        for i in j + 1..modes {
            let entry = x[i][j] - (0..j).map(|k| x[i][k] * x[j][k]).sum::<f64>();
            x[i][j] = entry * inverse;
        }
    }
    Some(())
}
