//! The paper's equations in dense form, \[O\] (1)–(12): `e` of all nodes from `q` by matrix exponentials,
//! `B = ∂e/∂q` and `Ḃq̇` by exact Taylor arithmetic, `M` assembled from ANCF elements integrated here.
//!
//! Independent of the formulas of the recursions: it uses the tree, lengths and coordinates of [`Model`], and takes sections and masses
//! from the case's description.

use crate::taylor::{Scalar, Taylor, exponential};
use crate::trees::Case;
use foldwing::beam::element::ElementKind;
use foldwing::load::{LoadFrame, RootMotion, Wrench};
use foldwing::multibody::dynamics::Damping;
use foldwing::multibody::factor::{FreedomTangent, Weights};
use foldwing::multibody::joint::JointKind;
use foldwing::multibody::model::{Base, Model};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix4, SMatrix, Vector3};

/// `(r, r_x, r_y, r_z)` as rows.
type Rows = Taylor<4, 3>;

/// Dense form of one case.
pub struct Oracle<'a> {
    model: &'a Model,
    /// Reduced mass matrix of all nodes for each beam.
    beams: Vec<DMatrix<f64>>,
    /// Mass matrix with all beams and the attached masses.
    mass: DMatrix<f64>,
    /// Stiffness matrix of each body.
    stiffness: Vec<DMatrix<f64>>,
}

/// Residual with the sum of its terms' magnitudes, and the reaction at the root.
pub struct Residual {
    /// Residual per coordinate.
    pub value: DVector<f64>,
    /// Sum of magnitudes per coordinate.
    pub magnitude: DVector<f64>,
    /// Root force in N.
    pub root_force: Vector3<f64>,
    /// Root moment about the origin in N·m.
    pub root_moment: Vector3<f64>,
    /// Sum of magnitudes of the terms of force and of moment.
    pub root_magnitude: [f64; 2],
}

impl<'a> Oracle<'a> {
    /// Assembles mass and stiffness.
    pub fn new(case: &'a Case) -> Self {
        let model = &case.model;
        let (rows, n) = (rows(model), model.coordinates);
        // rows of the nodal vectors of the next element with shear
        let mut next = 4 * model.nodes.len();
        let (mut beams, mut stiffness) = (Vec::new(), Vec::new());
        for (body, description) in model.bodies.iter().zip(&case.descriptions) {
            let mut beam = DMatrix::zeros(rows, rows);
            let mut k = DMatrix::zeros(n, n);
            let section = &description.section.at(0.0);
            for i in 0..body.elements {
                let element = &model.elements[body.first_element + i];
                let block = element_mass(element.length_m, section);
                let mut at = 4 * (body.first_node + i);
                if body.sheared {
                    (at, next) = (next, next + 8);
                }
                let mut view = beam.view_mut((at, at), (8, 8));
                view += block;
                let c = element.coordinate;
                let count = element.range().len();
                let own = match section.shear {
                    Some(whole) => DMatrix::from_fn(count, count, |i, j| whole[(i, j)]),
                    None => DMatrix::from_fn(count, count, |i, j| section.stiffness[(i, j)]),
                };
                match description.kind {
                    ElementKind::Constant => {
                        let mut view = k.view_mut((c, c), (count, count));
                        view += own * element.length_m;
                    }
                    ElementKind::Linear if i % 2 == 0 => {
                        let pair_m = element.length_m + model.elements[body.first_element + i + 1].length_m;
                        for a in 0..2 {
                            for b in 0..2 {
                                let mut view = k.view_mut((c + count * a, c + count * b), (count, count));
                                view += &own * (pair_m * pair_weight(a, b));
                            }
                        }
                    }
                    ElementKind::Linear => {}
                }
            }
            beams.push(beam);
            stiffness.push(k);
        }
        let mut mass: DMatrix<f64> = beams.iter().sum();
        for (body, position_m, cloud) in &case.clouds {
            let at = 4 * node_at(model, *body, *position_m);
            for (mass_kg, place) in cloud {
                let lever = nalgebra::Vector4::new(1.0, place.x, place.y, place.z);
                let mut view = mass.view_mut((at, at), (4, 4));
                view += lever * lever.transpose() * *mass_kg;
            }
        }
        Self { model, beams, mass, stiffness }
    }

    /// Nodal vectors of all nodes relative to the root frame, for coordinates that depend on `t`.
    fn nodes(&self, q: &dyn Fn(usize) -> Scalar) -> Vec<Rows> {
        let mut nodes: Vec<Rows> = Vec::new();
        for body in &self.model.bodies {
            let parent = match body.base {
                Base::Node(node) => nodes[node],
                Base::Axis(_) => panic!("no sliding joints"),
                Base::Root(position) => {
                    let mut rows = SMatrix::<f64, 4, 3>::zeros();
                    rows.set_row(0, &position.transpose());
                    rows.fixed_view_mut::<3, 3>(1, 0).copy_from(&Matrix3::identity());
                    Taylor::constant(rows)
                }
            };
            // eq. (8): C(η), here 4×4 on the four vectors
            let mut turn = Taylor::constant(Matrix3::identity());
            // position of the body in its parent's frame: the offset, and the displacement of a prismatic joint
            let mut arm = [body.offset_m, Vector3::zeros(), Vector3::zeros()];
            match body.joint.kind {
                JointKind::Revolute { axis } => {
                    turn = exponential(Taylor::constant(Matrix3::zeros()).plus(q(body.joint.coordinate), skew(&axis)));
                }
                JointKind::Prismatic { axis } => {
                    arm.iter_mut().zip(q(body.joint.coordinate)).for_each(|(arm, way)| *arm += axis * way);
                }
                _ => {}
            }
            let turn = (turn * Taylor::constant(body.mount)).transpose();
            let embed = |block: &Matrix3<f64>, arm: &Vector3<f64>, one: f64| {
                let mut c = Matrix4::zeros();
                c[(0, 0)] = one;
                c.fixed_view_mut::<1, 3>(0, 1).copy_from(&arm.transpose());
                c.fixed_view_mut::<3, 3>(1, 1).copy_from(block);
                c
            };
            let joint = Taylor {
                value: embed(&turn.value, &arm[0], 1.0),
                first: embed(&turn.first, &arm[1], 0.0),
                second: embed(&turn.second, &arm[2], 0.0),
            };
            nodes.push(joint * parent);
            for element in &self.model.elements[body.first_element..body.first_element + body.elements] {
                let strain = strains(q, element.range());
                let inner = nodes[nodes.len() - 1];
                nodes.push(step(element.length_m, strain) * inner);
            }
        }
        // an element with shear has separate nodal vectors: the tangent of its axis at both ends is `R (e_x + ε)`
        for body in self.model.bodies.iter().filter(|body| body.sheared) {
            for i in 0..body.elements {
                let strain = strains(q, self.model.elements[body.first_element + i].range());
                for end in 0..2 {
                    nodes.push(sloped(strain) * nodes[body.first_node + i + end]);
                }
            }
        }
        nodes
    }

    /// Nodal vectors of a station: on constant elements by a part of the element, in a pair by two links of half the distance with mixed
    /// strains (the pair rule on `[0, s]`).
    fn station(&self, index: usize, nodes: &[Rows], q: &dyn Fn(usize) -> Scalar) -> Rows {
        let station = &self.model.stations[index];
        let body = &self.model.bodies[station.body];
        let element = &self.model.elements[station.element];
        let inner = nodes[body.first_node + station.element - body.first_element];
        let own = strains(q, element.range());
        if body.kind == ElementKind::Constant {
            return step(station.offset_m, own) * inner;
        }
        // ε(s) = (A+B)/2 + 3/(2ℓ)(B−A)(s − ℓ/2); the rule on [0, s] needs its mean and slope there
        let end = element.range().end;
        let other = strains(q, end..end + element.range().len());
        let pair_m = 2.0 * element.length_m;
        let s = station.offset_m;
        let part = |sign: f64| -> [Scalar; 6] {
            std::array::from_fn(|i| {
                std::array::from_fn(|d| {
                    let slope = 1.5 / pair_m * (other[i][d] - own[i][d]);
                    let mean = 0.5 * (own[i][d] + other[i][d]) + slope * (0.5 * s - 0.5 * pair_m);
                    // halves of the piece [0, s]: mean ∓ s/3 slope
                    mean + sign * s / 3.0 * slope
                })
            })
        };
        step(0.5 * s, part(1.0)) * (step(0.5 * s, part(-1.0)) * inner)
    }

    /// `B` by components: `e[4·node + k][component] = …`, each (4N × n).
    pub fn transformation(&self, q: &[f64]) -> [DMatrix<f64>; 3] {
        let n = self.model.coordinates;
        let mut b = [0, 1, 2].map(|_| DMatrix::zeros(rows(self.model), n));
        for j in 0..n {
            let along = |i: usize| [q[i], if i == j { 1.0 } else { 0.0 }, 0.0];
            for (node, rows) in self.nodes(&along).iter().enumerate() {
                for (c, b) in b.iter_mut().enumerate() {
                    b.view_mut((4 * node, j), (4, 1)).copy_from(&rows.first.column(c));
                }
            }
        }
        b
    }

    /// `M` for the generalised coordinates, `BᵀMB`.
    pub fn mass_matrix(&self, q: &[f64]) -> DMatrix<f64> {
        let b = self.transformation(q);
        b.iter().map(|b| b.transpose() * &self.mass * b).sum()
    }

    /// `a BᵀMB + b (Σ α BᵀM_beam B + β K) + c K` with hinge terms on the diagonal.
    pub fn matrix(&self, q: &[f64], w: Weights, damping: &[Damping], hinges: &[FreedomTangent]) -> DMatrix<f64> {
        let b = self.transformation(q);
        let mut mass = &self.mass * w.mass;
        let mut k = DMatrix::zeros(self.model.coordinates, self.model.coordinates);
        for (i, damping) in damping.iter().enumerate() {
            mass += &self.beams[i] * (w.damping * damping.mass_1_s);
            k += &self.stiffness[i] * (w.stiffness + w.damping * damping.stiffness_s);
        }
        for (body, tangent) in self.model.bodies.iter().zip(hinges) {
            if body.joint.kind.freedoms() == 1 {
                let c = body.joint.coordinate;
                k[(c, c)] += w.stiffness * tangent.stiffness + w.damping * tangent.damping;
            }
        }
        b.iter().map(|b| b.transpose() * &mass * b).sum::<DMatrix<f64>>() + k
    }

    /// Eq. (9): `BᵀM(ë − G) + α BᵀM_beam ė + K(q − q₀ + β q̇) − BᵀF`, the root moving in an inertial frame that
    /// coincides with the root frame at this instant.
    pub fn residual(
        &self,
        (q, v, a): (&[f64], &[f64], &[f64]),
        root: &RootMotion,
        damping: &[Damping],
        loads: &[Wrench],
    ) -> Residual {
        let n = self.model.coordinates;
        let along = |i: usize| [q[i], v[i], a[i]];
        let relative = self.nodes(&along);
        // p(t) = ½ a t², R(t) = exp[Ωt + ½Ω̇t²]×
        let (spin, spin_rate) = (root.angular_velocity_rad_s, root.angular_acceleration_rad_s2);
        let turn = exponential(Taylor { value: Matrix3::zeros(), first: skew(&spin), second: skew(&spin_rate) });
        let mut shift = Taylor::<4, 3>::constant(SMatrix::zeros());
        shift.second.set_row(0, &(root.acceleration_m_s2 - root.gravity_m_s2).transpose());
        let rows = rows(self.model);
        let (mut e, mut rate, mut push) = (DMatrix::zeros(rows, 3), DMatrix::zeros(rows, 3), DMatrix::zeros(rows, 3));
        let mut push_size = DMatrix::zeros(rows, 3);
        for (node, relative) in relative.iter().enumerate() {
            let inertial = *relative * turn.transpose() + shift;
            e.view_mut((4 * node, 0), (4, 3)).copy_from(&relative.value);
            rate.view_mut((4 * node, 0), (4, 3)).copy_from(&relative.first);
            push.view_mut((4 * node, 0), (4, 3)).copy_from(&inertial.second);
            push_size.view_mut((4 * node, 0), (4, 3)).copy_from(&inertial.second.abs());
        }
        let b = self.transformation(q);
        // magnitudes: strain accelerations and the remaining acceleration terms separately
        let pull = DVector::from_column_slice(a).abs();
        for (c, b) in b.iter().enumerate() {
            let mut column = push_size.column_mut(c);
            column += b.abs() * &pull;
        }
        let mut force = &self.mass * &push;
        let mut force_size = self.mass.abs() * &push_size;
        for (beam, damping) in self.beams.iter().zip(damping) {
            force += beam * &rate * damping.mass_1_s;
            force_size += beam.abs() * rate.abs() * damping.mass_1_s;
        }
        let (mut value, mut magnitude) = (DVector::zeros(n), DVector::zeros(n));
        for (c, b) in b.iter().enumerate() {
            value += b.transpose() * force.column(c);
            magnitude += b.abs().transpose() * force_size.column(c);
        }
        for (i, (body, damping)) in self.model.bodies.iter().zip(damping).enumerate() {
            let mut excess = DVector::zeros(n);
            let elements = body.first_element..body.first_element + body.elements;
            for element in &self.model.elements[elements] {
                for k in element.range() {
                    let natural_strain = element.natural_strain_of(k - element.coordinate);
                    excess[k] = q[k] - natural_strain + damping.stiffness_s * v[k];
                }
            }
            value += &self.stiffness[i] * &excess;
            magnitude += self.stiffness[i].abs() * excess.abs();
        }
        let vector = |m: &DMatrix<f64>, row: usize| Vector3::new(m[(row, 0)], m[(row, 1)], m[(row, 2)]);
        let (mut root_force, mut root_moment, mut root_magnitude) = (Vector3::zeros(), Vector3::zeros(), [0.0; 2]);
        for row in 0..rows {
            let (f, size) = (vector(&force, row), vector(&force_size, row));
            if row % 4 == 0 {
                root_force += f;
                root_magnitude[0] += size.norm();
            }
            root_moment += vector(&e, row).cross(&f);
            root_magnitude[1] += vector(&e, row).norm() * size.norm();
        }
        for (index, load) in loads.iter().enumerate() {
            let pose = self.station(index, &relative, &along).value;
            let axes = pose.fixed_view::<3, 3>(1, 0).transpose();
            let (force, moment) = match self.model.stations[index].frame {
                LoadFrame::Root => (load.force_n, load.moment_n_m),
                LoadFrame::Section => (axes * load.force_n, axes * load.moment_n_m),
            };
            root_force -= force;
            root_moment -= moment + pose.row(0).transpose().cross(&force);
            root_magnitude[0] += force.norm();
            root_magnitude[1] += moment.norm() + pose.row(0).norm() * force.norm();
            for j in 0..n {
                let unit = |i: usize| [q[i], if i == j { 1.0 } else { 0.0 }, 0.0];
                let (shift, turn) = virtual_motion(&self.station(index, &self.nodes(&unit), &unit));
                value[j] -= force.dot(&shift) + moment.dot(&turn);
                magnitude[j] += force.norm() * shift.norm() + moment.norm() * turn.norm();
            }
        }
        Residual { value, magnitude, root_force, root_moment, root_magnitude }
    }

    /// Kinetic energy relative to the root frame, `½ ėᵀMė` in J.
    pub fn kinetic_energy_j(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut rate = DMatrix::zeros(rows(self.model), 3);
        for (node, rows) in self.nodes(&|i| [q[i], v[i], 0.0]).iter().enumerate() {
            rate.view_mut((4 * node, 0), (4, 3)).copy_from(&rows.first);
        }
        0.5 * (rate.transpose() * &self.mass * &rate).trace()
    }
}

/// Number of rows of all nodal vectors: those of the nodes, then those of both ends of each element with shear.
fn rows(model: &Model) -> usize {
    4 * (model.nodes.len()
        + 2 * model.bodies.iter().filter(|body| body.sheared).map(|body| body.elements).sum::<usize>())
}

/// From the vectors of a node to those of an end of an element: `d = (1 + εx) r_x + γy r_y + γz r_z` for `r_x`.
fn sloped(strain: [Scalar; 6]) -> Taylor<4, 4> {
    let entry = |column: usize| {
        let mut entry = Matrix4::zeros();
        entry[(1, column)] = 1.0;
        entry
    };
    Taylor::constant(Matrix4::identity()).plus(strain[0], entry(1)).plus(strain[4], entry(2)).plus(strain[5], entry(3))
}

/// Displacement and rotation of a frame per unit of `t`: `δφ = ½ Σ r_k × δr_k`.
fn virtual_motion(rows: &Rows) -> (Vector3<f64>, Vector3<f64>) {
    let vector = |m: &SMatrix<f64, 4, 3>, k: usize| m.row(k).transpose();
    let turn = (1..4).map(|k| vector(&rows.value, k).cross(&vector(&rows.first, k))).sum::<Vector3<f64>>() * 0.5;
    (vector(&rows.first, 0), turn)
}

/// The strains `(εx, κx, κy, κz, γy, γz)` at some coordinates; shears that an element lacks are zero.
fn strains(q: &dyn Fn(usize) -> Scalar, range: std::ops::Range<usize>) -> [Scalar; 6] {
    std::array::from_fn(|i| if i < range.len() { q(range.start + i) } else { [0.0; 3] })
}

/// Eq. (7): `exp(κ Δs)`, κ of eq. (6) over the four vectors, with the shears in its first row.
fn step(length_m: f64, strain: [Scalar; 6]) -> Taylor<4, 4> {
    let entry = |list: &[(usize, usize, f64)]| {
        let mut kappa = Matrix4::zeros();
        for &(row, column, value) in list {
            kappa[(row, column)] = value * length_m;
        }
        kappa
    };
    exponential(
        Taylor::constant(entry(&[(0, 1, 1.0)]))
            .plus(strain[0], entry(&[(0, 1, 1.0)]))
            .plus(strain[1], entry(&[(2, 3, 1.0), (3, 2, -1.0)]))
            .plus(strain[2], entry(&[(1, 3, -1.0), (3, 1, 1.0)]))
            .plus(strain[3], entry(&[(1, 2, 1.0), (2, 1, -1.0)]))
            .plus(strain[4], entry(&[(0, 2, 1.0)]))
            .plus(strain[5], entry(&[(0, 3, 1.0)])),
    )
}

fn skew(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// Node of a body at an arc length that is a mesh boundary.
fn node_at(model: &Model, body: usize, position_m: f64) -> usize {
    let body = &model.bodies[body];
    let elements = &model.elements[body.first_element..body.first_element + body.elements];
    let boundary = elements.iter().position(|element| (element.start_m - position_m).abs() < 1e-9);
    body.first_node + boundary.unwrap_or(body.elements)
}

/// `∫₀¹ p q dξ` of two polynomials given by their coefficients.
fn integral(p: &[f64], q: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (i, p) in p.iter().enumerate() {
        for (j, q) in q.iter().enumerate() {
            sum += p * q / (i + j + 1) as f64;
        }
    }
    sum
}

/// `∫ N_a N_b dσ` of the pair's shape functions `½ ∓ (3/2)(σ − ½)`.
fn pair_weight(a: usize, b: usize) -> f64 {
    let shape = [[1.25, -1.5], [-0.25, 1.5]];
    integral(&shape[a], &shape[b])
}

/// Reduced 8×8 mass of the fully parameterised ANCF element: `r = s(ξ)·(r, r_x) + y (lin. r_y) + z (lin. r_z)`.
pub fn element_mass(length_m: f64, section: &foldwing::beam::section::Section) -> SMatrix<f64, 8, 8> {
    let l = length_m;
    let none = [0.0; 4];
    let (up, down) = ([0.0, 1.0, 0.0, 0.0], [1.0, -1.0, 0.0, 0.0]);
    let axis = [
        [1.0, 0.0, -3.0, 2.0],
        [0.0, l, -2.0 * l, l],
        none,
        none,
        [0.0, 0.0, 3.0, -2.0],
        [0.0, 0.0, -l, l],
        none,
        none,
    ];
    let chord = [none, none, down, none, none, none, up, none];
    let thick = [none, none, none, down, none, none, none, up];
    let [y, z] = section.first_moment_kg;
    let [yy, yz, zz] = section.second_moment_kg_m;
    let moments = [[section.mass_kg_m, y, z], [y, yy, yz], [z, yz, zz]];
    let families = [axis, chord, thick];
    SMatrix::from_fn(|i, j| {
        let mut sum = 0.0;
        for (f, first) in families.iter().enumerate() {
            for (s, second) in families.iter().enumerate() {
                sum += moments[f][s] * integral(&first[i], &second[j]);
            }
        }
        sum * l
    })
}
