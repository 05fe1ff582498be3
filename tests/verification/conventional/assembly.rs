//! Beams and joints as one dense system: kinematics `e(q)`, `B`, `Ḃq̇`, and eq. (9) as a matrix with multipliers.

use crate::conventional::constraint::{Constraint, End, Spring};
use crate::conventional::link::{self, Jet, Joint, Node};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix4, SMatrix, Vector3};

/// A uniform beam and the joint at its inner end.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Body to whose outer end the joint is attached; none for the root frame's origin.
    pub parent: Option<usize>,
    /// Joint.
    pub joint: Joint,
    /// Rotation from body to parent frame at zero joint rotation.
    pub mount: Matrix3<f64>,
    /// Length in m.
    pub length_m: f64,
    /// Number of elements.
    pub elements: usize,
    /// Mass per length in kg/m.
    pub mass_kg_m: f64,
    /// `∫ρy² dA` and `∫ρz² dA` in kg·m.
    pub second_moment_kg_m: [f64; 2],
    /// `EA` in N; `GJ`, `EI_y`, `EI_z` in N·m².
    pub stiffness: [f64; 4],
}

/// Motion of a node: `h`, its derivatives with respect to the active coordinates, `ḣ`, and `ḧ` at `q̈ = 0`.
#[derive(Debug, Clone)]
pub struct NodeMotion {
    /// Nodal vectors.
    pub h: Node,
    /// Columns of `B`; fewer than the body's active coordinates, because coordinates of outer elements do not move the node.
    pub columns: Vec<Node>,
    /// `ḣ`.
    pub rate: Node,
    /// `Ḃq̇`.
    pub bias: Node,
}

impl NodeMotion {
    fn ground() -> Self {
        let mut h = Node::zeros();
        h.fixed_view_mut::<3, 3>(1, 0).copy_from(&Matrix3::identity());
        Self { h, columns: Vec::new(), rate: Node::zeros(), bias: Node::zeros() }
    }

    /// The next node outward.
    fn next(&self, jet: &Jet) -> Self {
        let mut columns: Vec<Node> = self.columns.iter().map(|column| jet.value.apply(column)).collect();
        columns.extend(jet.partial.iter().map(|partial| partial.apply(&self.h)));
        Self {
            h: jet.value.apply(&self.h),
            columns,
            rate: jet.rate.apply(&self.h) + jet.value.apply(&self.rate),
            bias: jet.bias.apply(&self.h) + jet.rate.apply(&self.rate) * 2.0 + jet.value.apply(&self.bias),
        }
    }

    /// `ḧ` for given accelerations of the active coordinates.
    pub fn acceleration(&self, active: &[usize], a: &DVector<f64>) -> Node {
        active.iter().zip(&self.columns).fold(self.bias, |sum, (&j, column)| sum + column * a[j])
    }
}

/// Motion of a body.
#[derive(Debug, Clone)]
pub struct BodyMotion {
    /// Coordinates that move the body, in the order of the nodes' columns.
    pub active: Vec<usize>,
    /// Nodes from the inner end outward.
    pub nodes: Vec<NodeMotion>,
}

/// Eq. (9): `mass q̈ + jacobianᵀ λ = force`, `jacobian q̈ = gamma`.
#[derive(Debug, Clone)]
pub struct Equations {
    /// `BᵀMB`.
    pub mass: DMatrix<f64>,
    /// `BᵀF − BᵀMḂq̇ − K(q − q₀)` and springs.
    pub force: DVector<f64>,
    /// `Ψ_q`.
    pub jacobian: DMatrix<f64>,
    /// Right-hand side of the constraints at the level of accelerations.
    pub gamma: DVector<f64>,
}

/// Energies in J.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energies {
    /// `½ ėᵀMė`.
    pub kinetic: f64,
    /// Strain energy and springs.
    pub elastic: f64,
    /// Potential of gravity, zero at the root frame's origin.
    pub gravity: f64,
}

impl Energies {
    /// Sum.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic + self.gravity
    }
}

/// The whole system.
#[derive(Debug, Clone)]
pub struct Assembly {
    /// Bodies, parents first.
    pub bodies: Vec<Body>,
    /// Constraints: those of the joint variables first, then the given ones.
    pub constraints: Vec<Constraint>,
    /// Fictitious springs.
    pub springs: Vec<Spring>,
    /// Gravity in m/s².
    pub gravity_m_s2: Vector3<f64>,
    /// First coordinate of each body; the number of coordinates last.
    pub first: Vec<usize>,
}

impl Assembly {
    /// Assigns the coordinates (eqs. 10–12) and adds the constraints between the joints' variables.
    pub fn new(bodies: Vec<Body>, given: Vec<Constraint>, springs: Vec<Spring>, gravity_m_s2: Vector3<f64>) -> Self {
        let mut first = vec![0];
        let mut constraints = Vec::new();
        for (index, body) in bodies.iter().enumerate() {
            let start = first[index];
            match body.joint {
                Joint::Ball | Joint::BallInRoot => constraints.push(Constraint::EulerParameters(start)),
                Joint::Free => constraints.push(Constraint::EulerParameters(start + 3)),
                Joint::Universal => constraints.push(Constraint::DirectionCosines(start)),
                Joint::Nodal => {
                    let node = End { body: index, node: 0 };
                    for k in 1..4 {
                        for l in k..4 {
                            let value = f64::from(u8::from(k == l));
                            constraints.push(Constraint::Product { a: (node, k), b: (node, l), value });
                        }
                    }
                }
                _ => {}
            }
            first.push(start + body.joint.variables() + 4 * body.elements);
        }
        constraints.extend(given);
        Self { bodies, constraints, springs, gravity_m_s2, first }
    }

    /// Number of coordinates.
    pub fn coordinates(&self) -> usize {
        self.first[self.bodies.len()]
    }

    /// Number of multipliers.
    pub fn multipliers(&self) -> usize {
        self.constraints.iter().map(Constraint::rows).sum()
    }

    /// First strain of an element.
    pub fn strain(&self, body: usize, element: usize) -> usize {
        self.first[body] + self.bodies[body].joint.variables() + 4 * element
    }

    /// Nodes of all bodies at `(q, q̇)`.
    pub fn motion(&self, q: &DVector<f64>, v: &DVector<f64>) -> Vec<BodyMotion> {
        let mut motions: Vec<BodyMotion> = Vec::new();
        for (index, body) in self.bodies.iter().enumerate() {
            let (mut active, inner) = match body.parent {
                Some(parent) => (motions[parent].active.clone(), motions[parent].nodes.last().expect("nodes").clone()),
                None => (Vec::new(), NodeMotion::ground()),
            };
            active.extend(self.first[index]..self.first[index + 1]);
            let (q, v) = (q.as_slice(), v.as_slice());
            let start = self.first[index]..self.first[index] + body.joint.variables();
            let jet = link::joint(&body.joint, &body.mount, &q[start.clone()], &v[start]);
            let mut nodes = vec![inner.next(&jet)];
            for element in 0..body.elements {
                let range = self.strain(index, element)..self.strain(index, element) + 4;
                let length_m = body.length_m / body.elements as f64;
                nodes.push(nodes[element].next(&link::element(length_m, &q[range.clone()], &v[range])));
            }
            motions.push(BodyMotion { active, nodes });
        }
        motions
    }

    /// Eq. (9) at a state, with the motion of the bodies there.
    pub fn equations(&self, q: &DVector<f64>, v: &DVector<f64>) -> (Equations, Vec<BodyMotion>) {
        let motion = self.motion(q, v);
        let n = self.coordinates();
        let (mut mass, mut force) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for (index, (body, moving)) in self.bodies.iter().zip(&motion).enumerate() {
            let m = element_mass(body);
            let fall = self.falling();
            for element in 0..body.elements {
                let (a, b) = (&moving.nodes[element], &moving.nodes[element + 1]);
                let columns = |j: usize| (a.columns.get(j).copied().unwrap_or_else(Node::zeros), b.columns[j]);
                let (fa, fb) = m.apply(&(fall - a.bias), &(fall - b.bias));
                for j in 0..b.columns.len() {
                    let (ca, cb) = columns(j);
                    let (pa, pb) = m.apply(&ca, &cb);
                    let row = moving.active[j];
                    force[row] += ca.dot(&fa) + cb.dot(&fb);
                    for k in 0..=j {
                        let (ca, cb) = columns(k);
                        mass[(row, moving.active[k])] += ca.dot(&pa) + cb.dot(&pb);
                    }
                }
                let strain = self.strain(index, element);
                for (k, stiffness) in body.stiffness.iter().enumerate() {
                    force[strain + k] -= stiffness * body.length_m / body.elements as f64 * q[strain + k];
                }
            }
        }
        mass.fill_upper_triangle_with_lower_triangle();
        for spring in &self.springs {
            spring.add_force(&motion, q, &mut force);
        }
        let (mut jacobian, mut gamma) = (DMatrix::zeros(self.multipliers(), n), DVector::zeros(self.multipliers()));
        let mut row = 0;
        for constraint in &self.constraints {
            constraint.linearise(&motion, q, v, &mut jacobian, &mut gamma, row);
            row += constraint.rows();
        }
        (Equations { mass, force, jacobian, gamma }, motion)
    }

    /// Accelerations and multipliers by the augmented formulation, solved densely. NaN where the matrix is singular.
    pub fn accelerations(&self, q: &DVector<f64>, v: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
        let (Equations { mass, force, jacobian, gamma }, _) = self.equations(q, v);
        let (n, m) = (mass.nrows(), jacobian.nrows());
        let mut matrix = DMatrix::zeros(n + m, n + m);
        matrix.view_mut((0, 0), (n, n)).copy_from(&mass);
        matrix.view_mut((n, 0), (m, n)).copy_from(&jacobian);
        matrix.view_mut((0, n), (n, m)).copy_from(&jacobian.transpose());
        let mut x = DVector::zeros(n + m);
        x.rows_mut(0, n).copy_from(&force);
        x.rows_mut(n, m).copy_from(&gamma);
        if !matrix.lu().solve_mut(&mut x) {
            x.fill(f64::NAN);
        }
        (x.rows(0, n).into_owned(), x.rows(n, m).into_owned())
    }

    /// Energies at a state.
    pub fn energies(&self, q: &DVector<f64>, v: &DVector<f64>) -> Energies {
        let motion = self.motion(q, v);
        let mut energies = Energies::default();
        for (index, (body, moving)) in self.bodies.iter().zip(&motion).enumerate() {
            let m = element_mass(body);
            let fall = self.falling();
            for element in 0..body.elements {
                let (a, b) = (&moving.nodes[element], &moving.nodes[element + 1]);
                let (pa, pb) = m.apply(&a.rate, &b.rate);
                energies.kinetic += 0.5 * (a.rate.dot(&pa) + b.rate.dot(&pb));
                let (wa, wb) = m.apply(&fall, &fall);
                energies.gravity -= a.h.dot(&wa) + b.h.dot(&wb);
                let strain = self.strain(index, element);
                for (k, stiffness) in body.stiffness.iter().enumerate() {
                    energies.elastic += 0.5 * stiffness * body.length_m / body.elements as f64 * q[strain + k].powi(2);
                }
            }
        }
        energies.elastic += self.springs.iter().map(|spring| spring.energy(&motion, q)).sum::<f64>();
        energies
    }

    /// Force in N and moment in N·m about the inner end that the joint transmits to a body and all bodies attached to it: inertia minus
    /// gravity, summed inward over the nodes.
    pub fn reaction(&self, body: usize, q: &DVector<f64>, v: &DVector<f64>) -> [Vector3<f64>; 2] {
        let (acceleration, _) = self.accelerations(q, v);
        let motion = self.motion(q, v);
        let hinge = row(&motion[body].nodes[0].h, 0);
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        let outer = (0..self.bodies.len()).filter(|&i| i == body || self.bodies[i].parent == Some(body));
        for (beam, moving) in outer.map(|i| (&self.bodies[i], &motion[i])) {
            let m = element_mass(beam);
            for element in 0..beam.elements {
                let ends = [&moving.nodes[element], &moving.nodes[element + 1]];
                let [a, b] = ends.map(|node| node.acceleration(&moving.active, &acceleration) - self.falling());
                let (fa, fb) = m.apply(&a, &b);
                for (node, f) in ends.into_iter().zip([fa, fb]) {
                    force += row(&f, 0);
                    moment += (row(&node.h, 0) - hinge).cross(&row(&f, 0));
                    moment += (1..4).map(|k| row(&node.h, k).cross(&row(&f, k))).sum::<Vector3<f64>>();
                }
            }
        }
        [force, moment]
    }

    /// Uniform acceleration of gravity as nodal vectors.
    fn falling(&self) -> Node {
        let mut node = Node::zeros();
        node.set_row(0, &self.gravity_m_s2.transpose());
        node
    }

    /// Residuals of all constraints.
    pub fn residual(&self, q: &DVector<f64>, v: &DVector<f64>) -> DVector<f64> {
        let motion = self.motion(q, v);
        let values = self.constraints.iter().flat_map(|constraint| constraint.value(&motion, q));
        DVector::from_iterator(self.multipliers(), values)
    }

    /// Projects joint variables and their rates onto the constraints of these variables.
    pub fn project(&self, q: &mut DVector<f64>, v: &mut DVector<f64>) {
        self.constraints.iter().for_each(|constraint| constraint.project(q, v));
    }
}

/// Row of a node as a vector.
pub fn row(node: &Node, k: usize) -> Vector3<f64> {
    node.row(k).transpose()
}

/// Reduced element mass matrix in closed form, blocks of 4×4.
struct ElementMass {
    aa: Matrix4<f64>,
    ab: Matrix4<f64>,
    bb: Matrix4<f64>,
}

impl ElementMass {
    fn apply(&self, a: &Node, b: &Node) -> (Node, Node) {
        (self.aa * a + self.ab * b, self.ab.transpose() * a + self.bb * b)
    }
}

/// Cubic Hermite functions for `r` and `r_x` (the textbook matrix of the bending beam), linear ones for `r_y` and `r_z`.
fn element_mass(body: &Body) -> ElementMass {
    let l = body.length_m / body.elements as f64;
    let m = body.mass_kg_m * l / 420.0;
    let mut full = SMatrix::<f64, 8, 8>::zeros();
    let axis = [0, 1, 4, 5];
    let bending = [
        [156.0, 22.0 * l, 54.0, -13.0 * l],
        [22.0 * l, 4.0 * l * l, 13.0 * l, -3.0 * l * l],
        [54.0, 13.0 * l, 156.0, -22.0 * l],
        [-13.0 * l, -3.0 * l * l, -22.0 * l, 4.0 * l * l],
    ];
    for i in 0..4 {
        for j in 0..4 {
            full[(axis[i], axis[j])] = m * bending[i][j];
        }
    }
    for (k, second) in [2, 3].into_iter().zip(body.second_moment_kg_m) {
        full[(k, k)] = second * l / 3.0;
        full[(k + 4, k + 4)] = second * l / 3.0;
        full[(k, k + 4)] = second * l / 6.0;
        full[(k + 4, k)] = second * l / 6.0;
    }
    let block = |i, j| full.fixed_view::<4, 4>(i, j).into_owned();
    ElementMass { aa: block(0, 0), ab: block(0, 4), bb: block(4, 4) }
}
