//! Forces of inertia, gravity, mass-proportional damping and loops on the nodes, in jets, eqs. (X3) and (X5).
//!
//! All of them are bilinear: a mass block times the nodal vectors' `L(e) = ë + α ė + 2 Ω × ė + (Ω̇× + Ω×Ω×) e − g`.

use crate::load::RootMotion;
use crate::math::jet::{Dual, Jet, Varied, Vector, Virtual, moment, plus, three};
use crate::math::so3::hat;
use crate::multibody::closure::Penalty;
use crate::multibody::derivative::{Forces, Place};
use crate::multibody::dynamics::{Environment, multiply, multiply_transposed};
use crate::multibody::model::Model;
use nalgebra::{Matrix3, Matrix4, Vector3};

/// The root's motion as the nodal vectors need it.
pub(super) struct Field {
    gravity: Vector3<f64>,
    /// `2 [Ω]×`.
    coriolis: Matrix3<f64>,
    /// `[Ω̇]× + [Ω]×²`.
    frame: Matrix3<f64>,
}

impl Field {
    fn of(root: &RootMotion) -> Self {
        let turn = hat(&root.angular_velocity_rad_s);
        Self {
            gravity: root.apparent_gravity_m_s2(),
            coriolis: turn * 2.0,
            frame: hat(&root.angular_acceleration_rad_s2) + turn * turn,
        }
    }

    /// `L(e)` less gravity.
    fn load(&self, [e, e1, e2]: [Vector3<f64>; 3], alpha: f64) -> Vector3<f64> {
        e2 + e1 * alpha + self.coriolis * e1 + self.frame * e
    }
}

/// Two linear forms of the four nodal vectors that the mass multiplies.
type Pair = [[Vector3<f64>; 4]; 2];

/// A ring in which inertia has forces.
pub(super) trait Loaded: Jet {
    /// Forces on its nodes.
    type On: Jet;

    /// The two forms of a nodal vector that the mass multiplies; `origin`: gravity acts on it.
    fn forms(vector: &Vector<Self>, field: &Field, alpha: f64, origin: bool) -> [Vector3<f64>; 2];

    /// Forces on a nodal vector from the masses' products with both forms.
    fn on(products: [Vector3<f64>; 2], field: &Field, alpha: f64) -> Vector<Self::On>;

    /// Force of a loop's penalty on its gap, eq. (C2).
    fn penalty(gap: &Vector<Self>, penalty: &Penalty) -> Vector<Self::On>;

    /// A vector as the forces' ring multiplies it.
    fn arm(vector: &Vector<Self>) -> Vector<Self::On>;

    /// Writes the forces on all nodes.
    fn load(model: &Model, environment: &Environment, places: &[Place<Self>], forces: &mut [Forces<Self::On>]) {
        let field = Field::of(environment.root);
        forces.fill(Forces::ZERO);
        for (body, damping) in model.bodies.iter().zip(environment.damping) {
            let alpha = damping.mass_1_s;
            let forms = |node: usize, alpha: f64| -> Pair {
                let place = &places[node];
                let of = |k: usize| match k {
                    0 => Self::forms(&place.position, &field, alpha, true),
                    _ => Self::forms(&place.axes[k - 1], &field, alpha, false),
                };
                let all = [of(0), of(1), of(2), of(3)];
                [all.map(|forms| forms[0]), all.map(|forms| forms[1])]
            };
            let mut add = |node: usize, products: Pair, alpha: f64| {
                let [load, other] = products;
                for (k, products) in load.into_iter().zip(other).enumerate() {
                    let on = Self::on([products.0, products.1], &field, alpha);
                    match k.checked_sub(1) {
                        None => forces[node].force = plus(forces[node].force, on),
                        Some(axis) => {
                            let moment = moment(&Self::arm(&places[node].axes[axis]), &on);
                            forces[node].moment = plus(forces[node].moment, moment);
                        }
                    }
                }
            };
            let both = |mass: &Matrix4<f64>, pair: &Pair| [multiply(mass, &pair[0]), multiply(mass, &pair[1])];
            let mut inner = forms(body.first_node, alpha);
            for i in 0..=body.elements {
                let node = body.first_node + i;
                let mass = &model.nodes[node];
                add(node, both(&mass.beam, &inner), alpha);
                if let Some(attached) = &mass.attached {
                    let alpha = if body.damps_attached { alpha } else { 0.0 };
                    add(node, both(attached, &forms(node, alpha)), alpha);
                }
                if i < body.elements {
                    let cross = &model.elements[body.first_element + i].cross_mass;
                    let outer = forms(node + 1, alpha);
                    let back = [multiply_transposed(cross, &outer[0]), multiply_transposed(cross, &outer[1])];
                    add(node, back, alpha);
                    add(node + 1, both(cross, &inner), alpha);
                    inner = outer;
                }
            }
        }
        for closure in &model.closures {
            let arms = [0, 1].map(|side| places[closure.nodes[side]].arm(&closure.offsets_m[side]));
            let gap = three(|i| {
                let end = |side: usize| places[closure.nodes[side]].position[i] + arms[side][i];
                end(1) - end(0)
            });
            let force = Self::penalty(&gap, &closure.penalty);
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                let force = force.map(|force| force.times(sign));
                forces[closure.nodes[side]].add_at(&Self::arm(&arms[side]), &force);
            }
        }
    }
}

/// One coefficient of a vector of jets.
fn entry<const N: usize>(vector: [[f64; N]; 3], kind: usize) -> Vector3<f64> {
    Vector3::new(vector[0][kind], vector[1][kind], vector[2][kind])
}

impl Loaded for Virtual {
    type On = Virtual;

    fn forms(vector: &Vector<Self>, field: &Field, alpha: f64, origin: bool) -> [Vector3<f64>; 2] {
        let of = |kind: usize| entry(vector.map(|jet| jet.0), kind);
        let load = field.load([of(0), of(1), of(2)], alpha);
        [if origin { load - field.gravity } else { load }, of(3)]
    }

    fn on([load, y]: [Vector3<f64>; 2], field: &Field, alpha: f64) -> Vector<Self> {
        let (by_value, by_rate) = (field.frame.tr_mul(&y), y * alpha + field.coriolis.tr_mul(&y));
        three(|i| Virtual([by_value[i], by_rate[i], y[i], load[i]]))
    }

    fn penalty(gap: &Vector<Self>, penalty: &Penalty) -> Vector<Self> {
        let Penalty { inertia_kg: m, damping_n_s_m: c, stiffness_n_m: k } = *penalty;
        gap.map(|Virtual([g, g1, g2, gs])| Virtual([k * gs, c * gs, m * gs, m * g2 + c * g1 + k * g]))
    }

    fn arm(vector: &Vector<Self>) -> Vector<Self> {
        *vector
    }
}

impl Loaded for Varied {
    type On = Dual;

    fn forms(vector: &Vector<Self>, field: &Field, alpha: f64, origin: bool) -> [Vector3<f64>; 2] {
        let of = |kind: usize| entry(vector.map(|jet| jet.0), kind);
        let load = field.load([of(0), of(1), of(2)], alpha);
        [if origin { load - field.gravity } else { load }, field.load([of(3), of(4), of(5)], alpha)]
    }

    fn on([load, change]: [Vector3<f64>; 2], _: &Field, _: f64) -> Vector<Dual> {
        three(|i| Dual([load[i], change[i]]))
    }

    fn penalty(gap: &Vector<Self>, penalty: &Penalty) -> Vector<Dual> {
        let Penalty { inertia_kg: m, damping_n_s_m: c, stiffness_n_m: k } = *penalty;
        gap.map(|Varied([g, g1, g2, d, d1, d2])| Dual([m * g2 + c * g1 + k * g, m * d2 + c * d1 + k * d]))
    }

    fn arm(vector: &Vector<Self>) -> Vector<Dual> {
        vector.map(|jet| Dual([jet.0[0], jet.0[3]]))
    }
}
