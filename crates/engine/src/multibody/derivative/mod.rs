//! Exact derivatives of the residual of the tree in O(n): along a direction, and transposed, NOTATION eqs. (X1)–(X5).
//!
//! [`Derivative::prepare`] linearises the recursion at the point of the last residual: each coordinate has a column, the motion of the
//! outer end of its link or joint, with two time derivatives; each node has the forces and rates that vary with its own rotation. Products
//! are then one outward and one inward sweep of small constant matrices, [`Derivative::forward`], or the same sweeps transposed,
//! [`Derivative::reverse`].

mod carried;
mod chain;
mod constraint;
mod coupling;
mod elastic;
mod elimination;
mod exact;
mod gains;
mod inertia;
mod lanes;
mod link;
mod loads;
mod loop_force;
mod modal;
mod rotor;
mod shear;
mod solution;
mod spatial;
mod spot;

pub use elastic::elastic_products;
pub use exact::Sweep;
pub use lanes::Lanes;
use lanes::{Linear, Product};
pub(crate) use spatial::{to_freedoms, to_multipliers, to_turning};

use crate::math::strain::{SHEARED, STRAINS, Strain, strains_at};
use crate::math::wide::{Fours, WithFours, with_fours};
use crate::multibody::dynamics::{Damping, Environment};
use crate::multibody::joint::JointKind;
use crate::multibody::kinematics::Motion;
use crate::multibody::model::{Base, Body, Model};
use crate::multibody::no_slip::ROWS;
use crate::multibody::workspace::Workspace;
use chain::{Column, Shift, fixed};
use constraint::ConstraintBlock;
use exact::Exact;
use inertia::Inertia;
use link::Link;
use loads::LoadedSection;
use loop_force::LoopForce;
use modal::ModalBlock;
use nalgebra::{Matrix3, Vector3};
use rotor::Rotor;
use shear::ShearedElement;
use spatial::SpatialBlock;
use spot::Spot;

/// The linearised recursion at a point.
#[derive(Debug, Clone)]
pub struct Derivative {
    /// Link or joint of each node.
    links: Vec<Link>,
    spots: Vec<Spot>,
    /// Column of each coordinate.
    columns: Vec<Column>,
    /// Mass-proportional damping per body in 1/s.
    alphas: Vec<f64>,
    inertia: Inertia,
    loads: Vec<LoadedSection>,
    loops: Vec<LoopForce>,
    constraints: Vec<ConstraintBlock>,
    rotors: Vec<Rotor>,
    exact: Exact,
    /// Elements with shear.
    sheared: Vec<ShearedElement>,
    modal: Vec<ModalBlock>,
    /// Universal, ball and free joints.
    spatial: Vec<SpatialBlock>,
    /// Per node: the one among them whose body starts there, counted from 1; 0 for none.
    spatial_at: Vec<usize>,
    /// Whether the model has only parts that [`Self::factorize`] and [`Self::forward_lanes`] cover.
    is_plain: bool,
    // workspace for the products, per node
    shifts: Vec<Shift>,
    wrenches: Vec<[Vector3<f64>; 2]>,
    single: Lanes<1>,
}

impl Derivative {
    /// Workspace for a model.
    pub fn new(model: &Model) -> Self {
        let nodes = model.nodes.len();
        let mut links = Vec::with_capacity(nodes);
        for (index, body) in model.bodies.iter().enumerate() {
            links.push(Link::of_joint(body));
            for i in 0..body.elements {
                let element = body.first_element + i;
                links.push(Link {
                    carrier: Some(body.first_node + i),
                    first: model.elements[element].coordinate,
                    count: if body.sheared { SHEARED } else { STRAINS },
                    element: Some(element),
                    ..Link::of_joint(body)
                });
            }
            if let Some(modal) = &body.modal {
                links.push(Link {
                    carrier: Some(body.first_node),
                    first: modal.coordinate,
                    count: modal.element.modes,
                    modal: Some(index),
                    ..Link::NONE
                });
            }
        }
        let spatial: Vec<SpatialBlock> =
            model.bodies.iter().enumerate().filter_map(|(index, body)| SpatialBlock::of_body(index, body)).collect();
        let mut spatial_at = vec![0; nodes];
        spatial.iter().enumerate().for_each(|(place, block)| spatial_at[block.node] = place + 1);
        Self {
            links,
            sheared: ShearedElement::of_model(model),
            modal: ModalBlock::of_model(model),
            spatial,
            spatial_at,
            spots: vec![Spot::ZERO; nodes],
            columns: vec![Column::ZERO; model.coordinates],
            alphas: vec![0.0; model.bodies.len()],
            inertia: Inertia::new(model),
            loads: Vec::with_capacity(model.stations.len()),
            loops: vec![LoopForce::ZERO; model.closures.len()],
            constraints: ConstraintBlock::of_model(model),
            rotors: Rotor::of_model(model),
            exact: Exact::new(model),
            shifts: vec![Shift::ZERO; nodes],
            wrenches: vec![[Vector3::zeros(); 2]; nodes],
            is_plain: exact::covers(model),
            single: Lanes::new(model),
        }
    }

    /// Linearises the recursion at the point of the last [`residual`](crate::multibody::dynamics::residual), whose motions and wrenches are
    /// in `work`; allocates nothing. Sliding joints are not supported.
    pub fn prepare(&mut self, model: &Model, work: &Workspace, motion: Motion, environment: &Environment) {
        with_fours(Preparation { derivative: self, model, work, motion, environment });
        self.spatial.iter_mut().for_each(|block| block.prepare(work, motion));
        self.sheared.iter_mut().for_each(|element| element.prepare(model, work, motion, &self.spots));
        self.modal.iter_mut().for_each(|body| body.prepare(model, &work.nodes, motion, environment.root));
        self.loads.clear();
        for (station, load) in model.stations.iter().zip(environment.stations).filter(|(_, load)| !load.is_zero()) {
            self.loads.push(LoadedSection::new(model, &work.nodes, motion.q, station, load));
        }
        for (own, closure) in self.loops.iter_mut().zip(&model.closures) {
            *own = LoopForce::new(closure, work);
        }
        for (index, own) in self.constraints.iter_mut().enumerate() {
            own.prepare(model.constraint(index), motion, work);
        }
        self.rotors.iter_mut().for_each(|rotor| rotor.prepare(work, motion, environment.root));
    }

    /// Adds torques on the degrees of freedom of a body's universal or ball joint: their slopes by its rotation and its angular velocity, in
    /// the parent's frame.
    pub(crate) fn add_torques(&mut self, body: usize, by_turn: &Matrix3<f64>, by_spin: &Matrix3<f64>) {
        let own = self.spatial.iter_mut().filter(|block| block.body == body);
        own.for_each(|block| block.add_torques(by_turn, by_spin));
    }

    /// Converts multipliers of the parameters of universal, ball and free joints to right sides of the rows, `Dᵀ` of eq. (X26), in place.
    pub(crate) fn to_rows(&self, on: &mut [f64]) {
        self.spatial.iter().for_each(|block| block.apply(&block.maps[0], true, on));
    }

    /// Converts a solution, changes of the parameters, to changes of the degrees of freedom and constraints, `D⁻¹` of eq. (X26), in place.
    pub(crate) fn to_freedoms(&self, change: &mut [f64]) {
        self.spatial.iter().for_each(|block| block.apply(&block.maps[1], false, change));
    }

    /// Column of a joint with one degree of freedom.
    fn joint_column(&self, work: &Workspace, index: usize, body: &Body) -> Option<Column> {
        let axis = work.joints[index].one_freedom()?.axis;
        let fixed = match body.base {
            Base::Root(_) => [axis, Vector3::zeros(), Vector3::zeros()],
            Base::Node(node) => fixed(&work.nodes[node], &self.spots[node].second, axis),
            Base::Axis(_) => unreachable!("no derivatives with sliding joints"),
        };
        match body.joint.kind {
            JointKind::Revolute { .. } => Some(Column { angular: fixed, ..Column::ZERO }),
            JointKind::Prismatic { .. } => Some(Column { linear: fixed, ..Column::ZERO }),
            JointKind::Clamped
            | JointKind::Sliding
            | JointKind::Universal { .. }
            | JointKind::Ball
            | JointKind::Free => None,
        }
    }

    /// Arm, columns and forces of the link to a node.
    #[inline(always)]
    fn prepare_link<V: Fours>(&mut self, fours: V, model: &Model, work: &Workspace, motion: Motion, n: usize) {
        let (link, node) = (&mut self.links[n], &work.nodes[n]);
        link.force = node.force;
        if let Some(carrier) = link.carrier {
            let inner = &work.nodes[carrier];
            link.arm = [
                node.position - inner.position,
                node.velocity - inner.velocity,
                node.acceleration - inner.acceleration,
            ];
            if let Some(index) = link.element.filter(|index| model.elements[*index].sheared.is_some()) {
                let element = &model.elements[index];
                let own = shear::columns(element, motion, inner, &self.spots[carrier].second);
                self.columns[element.range()].copy_from_slice(&own);
            } else if let Some(index) = link.element {
                let element = &model.elements[index];
                let own = link::columns(fours, element, motion, &self.spots[carrier]);
                self.columns[element.range()].copy_from_slice(&own);
                let local = |vector: &Vector3<f64>| inner.rotation.tr_mul(vector);
                link.slopes = link::slopes(element, motion.q, &local(&node.force), &local(&node.moment));
            } else if let Some(modal) = link.modal.and_then(|body| model.bodies[body].modal.as_deref()) {
                let own = modal::columns(modal, motion, inner, &self.spots[carrier].second);
                self.columns[modal.range()].iter_mut().zip(own).for_each(|(column, own)| *column = own);
            }
        }
        for column in &mut self.columns[link.first..link.first + link.count] {
            column.set_turned(&node.force, &node.moment);
        }
    }

    /// Adds the projection of wrenches on the nodes on the rows, eq. (D9). The wrenches on outboard parts are added to those on their carriers.
    pub(crate) fn project(&self, wrenches: &mut [[Vector3<f64>; 2]], rows: &mut [f64]) {
        for (n, link) in self.links.iter().enumerate().rev() {
            let [force, moment] = wrenches[n];
            for (row, column) in rows[link.range()].iter_mut().zip(&self.columns[link.range()]) {
                *row += column.project(&force, &moment);
            }
            if self.spatial_at[n] > 0 {
                self.spatial[self.spatial_at[n] - 1].project(&wrenches[n], rows);
            }
            if let Some(carrier) = link.carrier {
                wrenches[carrier][0] += force;
                wrenches[carrier][1] += moment + link.arm[0].cross(&force);
            }
        }
    }

    /// Adds `K δq + C δv + M δa` of tree, loads and loops to `sum`, eq. (X3), without the elastic and damping forces of the strains and the
    /// forces of joints.
    pub fn forward(&mut self, model: &Model, along: Motion, sum: &mut [f64]) {
        let Self { links, spots, columns, shifts, wrenches, spatial, spatial_at, sheared, modal, .. } = self;
        for (n, link) in links.iter().enumerate() {
            let mut shift = link.carrier.map_or(Shift::ZERO, |carrier| shifts[carrier].carried(&link.arm));
            for i in link.range() {
                columns[i].add(&mut shift, [along.q[i], along.v[i], along.a[i]]);
            }
            if spatial_at[n] > 0 {
                spatial[spatial_at[n] - 1].move_node(along, &mut shift);
            }
            shifts[n] = shift;
        }
        self.inertia.forward(model, (spots, &self.alphas), shifts, wrenches);
        for element in sheared.iter() {
            element.forward(model, (spots, &self.alphas, self.inertia.field()), along, shifts, wrenches, sum);
        }
        for body in modal.iter() {
            body.forward((spots, &self.alphas, self.inertia.field()), along, shifts, wrenches, sum);
        }
        for load in &self.loads {
            let node = load.node();
            load.forward(&shifts[node], along.q, &mut wrenches[node], sum);
        }
        for own in &self.loops {
            own.forward(shifts, wrenches);
        }
        for own in &self.constraints {
            own.forward(shifts, along, wrenches, sum);
        }
        for rotor in &self.rotors {
            rotor.forward(shifts, along, wrenches, sum);
        }
        for (n, link) in links.iter().enumerate().rev() {
            let [force, moment] = wrenches[n];
            let turn = link.carrier.map_or(Vector3::zeros(), |carrier| shifts[carrier].angular[0]);
            for i in link.range() {
                sum[i] += columns[i].project(&force, &moment) + columns[i].turned.dot(&turn);
            }
            if spatial_at[n] > 0 {
                spatial[spatial_at[n] - 1].add_rows(&wrenches[n], &turn, along, sum);
            }
            if link.element.is_some() {
                let own = link.slopes * Strain::from(strains_at(along.q, link.first));
                sum[link.range()].iter_mut().zip(&own).for_each(|(sum, own)| *sum += own);
            }
            if let Some(carrier) = link.carrier {
                let moved = shifts[n].linear[0] - shifts[carrier].linear[0];
                wrenches[carrier][0] += force;
                wrenches[carrier][1] += moment + link.arm[0].cross(&force) + moved.cross(&link.force);
            }
        }
    }

    /// Adds the transposed products `Kᵀw`, `Cᵀw` and `Mᵀw` of the parts covered by [`Self::forward`] to `sums`, eq. (X4).
    pub fn reverse(&mut self, model: &Model, w: &[f64], sums: [&mut [f64]; 3]) {
        let [by_q, by_v, by_a] = sums;
        let Self { links, spots, columns, shifts, wrenches, spatial, spatial_at, sheared, modal, .. } = self;
        shifts.fill(Shift::ZERO);
        // multipliers of the wrenches: virtual motion of the nodes
        for (n, link) in links.iter().enumerate() {
            let [mut moved, mut turn] = [Vector3::zeros(); 2];
            let mut by_turn = Vector3::zeros();
            for i in link.range() {
                moved += columns[i].linear[0] * w[i];
                turn += columns[i].angular[0] * w[i];
                by_turn += columns[i].turned * w[i];
            }
            if spatial_at[n] > 0 {
                let block = &spatial[spatial_at[n] - 1];
                let [own_move, own_turn, own_by_turn] = block.pull_rows(w, [&mut *by_q, &mut *by_v, &mut *by_a]);
                moved += own_move;
                turn += own_turn;
                by_turn += own_by_turn;
            }
            if let Some(carrier) = link.carrier {
                let [inner_move, inner_turn] = wrenches[carrier];
                moved += inner_move + inner_turn.cross(&link.arm[0]);
                turn += inner_turn;
                let by_move = link.force.cross(&inner_turn);
                shifts[carrier].angular[0] += by_turn;
                shifts[carrier].linear[0] -= by_move;
                shifts[n].linear[0] += by_move;
            }
            if link.element.is_some() {
                let own = link.slopes.tr_mul(&Strain::from(strains_at(w, link.first)));
                by_q[link.range()].iter_mut().zip(&own).for_each(|(sum, own)| *sum += own);
            }
            wrenches[n] = [moved, turn];
        }
        self.inertia.reverse(model, (spots, &self.alphas), wrenches, shifts);
        for element in sheared.iter() {
            let at = (&spots[..], &self.alphas[..], self.inertia.field());
            element.reverse(model, at, (wrenches, w), shifts, [&mut *by_q, &mut *by_v, &mut *by_a]);
        }
        for body in modal.iter() {
            let at = (&spots[..], &self.alphas[..], self.inertia.field());
            body.reverse(at, (wrenches, w), shifts, [&mut *by_q, &mut *by_v, &mut *by_a]);
        }
        for load in &self.loads {
            let node = load.node();
            load.reverse(&wrenches[node], w, &mut shifts[node], by_q);
        }
        for own in &self.loops {
            own.reverse(wrenches, shifts);
        }
        for own in &self.constraints {
            own.reverse(wrenches, w, shifts, by_a);
        }
        for rotor in &self.rotors {
            rotor.reverse(wrenches, w, shifts, by_a);
        }
        self.pull_shifts([by_q, by_v, by_a]);
    }

    /// Slopes of a row of the gap of a constraint, of its rate (`order` 1) or its acceleration (2), with respect to the motion.
    pub(crate) fn gap_slopes(&mut self, (constraint, order, row): (usize, usize, usize), mut slopes: [&mut [f64]; 3]) {
        slopes.iter_mut().for_each(|slopes| slopes.fill(0.0));
        self.shifts.fill(Shift::ZERO);
        self.constraints[constraint].add_row(ROWS * order + row, 1.0, &mut self.shifts);
        self.pull_shifts(slopes);
    }

    /// Adds the multipliers of the coordinates, their rates and their accelerations from those of the motion of the nodes.
    fn pull_shifts(&mut self, [by_q, by_v, by_a]: [&mut [f64]; 3]) {
        let Self { links, columns, shifts, spatial, spatial_at, .. } = self;
        for (n, link) in links.iter().enumerate().rev() {
            let on = shifts[n];
            for i in link.range() {
                let [x, x1, x2] = columns[i].pulled(&on);
                by_q[i] += x;
                by_v[i] += x1;
                by_a[i] += x2;
            }
            if spatial_at[n] > 0 {
                spatial[spatial_at[n] - 1].pull(&on, [&mut *by_q, &mut *by_v, &mut *by_a]);
            }
            if let Some(carrier) = link.carrier {
                shifts[carrier].add_carried(&on, &link.arm);
            }
        }
    }
}

/// The arguments of [`Derivative::prepare`].
struct Preparation<'a> {
    derivative: &'a mut Derivative,
    model: &'a Model,
    work: &'a Workspace,
    motion: Motion<'a>,
    environment: &'a Environment<'a>,
}

impl WithFours for Preparation<'_> {
    type Output = ();

    /// Nodes, links and joints with one degree of freedom.
    #[inline(always)]
    fn run<V: Fours>(self, fours: V) {
        let Self { derivative, model, work, motion, environment } = self;
        for (alpha, damping) in derivative.alphas.iter_mut().zip(environment.damping) {
            *alpha = damping.mass_1_s;
        }
        for (body, alpha) in model.bodies.iter().zip(&derivative.alphas) {
            for n in body.first_node..=body.last_node() {
                derivative.spots[n] = Spot::of(&work.nodes[n], *alpha);
            }
        }
        derivative.inertia.prepare(model, &work.nodes, environment, &mut derivative.spots);
        for (index, body) in model.bodies.iter().enumerate() {
            if let Some(column) = derivative.joint_column(work, index, body) {
                derivative.columns[body.joint.coordinate] = column;
            }
            for n in body.first_node..=body.last_node() {
                derivative.prepare_link(fours, model, work, motion, n);
            }
        }
    }
}

/// Linear systems with `M + g C + g² K` of the tree, eqs. (X30)–(X33).
impl Derivative {
    /// Whether [`Self::factorize`] covers a model: not with closed loops, skates, wheels, joints with several degrees of freedom, sliding
    /// joints, modal bodies, damping of modes, circuits, rotors that turn with their carrier and shear.
    pub fn has_factors(model: &Model) -> bool {
        exact::covers(model)
    }

    /// Factorises `M + g C + g² K` at the linearised point. `joint` gives for each body the coefficient of its joint's own acceleration
    /// (inertia, `g` times damping, `g²` times stiffness), `None` while the joint is held. Allocates nothing.
    ///
    /// `None` if a pivot is not positive.
    pub fn factorize(
        &mut self,
        model: &Model,
        gain_s: f64,
        damping: &[Damping],
        joint: impl Fn(usize) -> Option<f64>,
    ) -> Option<()> {
        let Self { links, spots, columns, alphas, exact, .. } = self;
        exact.factorize(Linear { links, spots, columns, alphas }, model, gain_s, damping, joint)
    }

    /// Solves `(M + g C + g² K) x = right` by the last factors: `x` holds the right-hand side and then the solution. Held joints do not
    /// move. Allocates nothing.
    pub fn solve(&mut self, model: &Model, x: &mut [f64]) {
        self.exact.solve(&self.links, model, x);
    }

    /// The same for `L` right-hand sides.
    pub fn solve_lanes<const L: usize>(&self, model: &Model, sweep: &mut Sweep<L>, x: &mut [[f64; L]]) {
        self.exact.solve_lanes(&self.links, model, sweep, x);
    }

    /// Solves the transposed equations by the same factors.
    pub fn solve_transposed(&mut self, model: &Model, x: &mut [f64]) {
        self.exact.solve_transposed(&self.links, model, x);
    }

    /// Whether [`Self::forward_lanes`] covers the linearised point: not with a root that rotates, loads at stations and closed loops,
    /// skates and wheels.
    pub fn has_lanes(&self) -> bool {
        self.loads.is_empty() && self.loops.is_empty() && self.constraints.is_empty() && !self.inertia.rotates()
    }

    /// [`Self::forward_lanes`] along one direction; `false`, without a result, for machines and points that are not covered.
    pub(crate) fn forward_plain(&mut self, mesh: (&Model, &[Damping]), along: Motion, sum: &mut [f64]) -> bool {
        let covers = self.is_plain && self.has_lanes();
        if covers {
            let Self { links, spots, columns, alphas, single, .. } = self;
            let along = [along.q, along.v, along.a].map(|rows| rows.as_chunks::<1>().0);
            let linear = Linear { links, spots, columns, alphas };
            with_fours(Product { linear, mesh, work: single, along, sum: sum.as_chunks_mut::<1>().0 });
        }
        covers
    }

    /// `K δq + C δv + M δa` of the tree with the elastic and damping forces of the strains, without those of joints, along `L` directions,
    /// into `sum`.
    pub fn forward_lanes<const L: usize>(
        &self,
        mesh: (&Model, &[Damping]),
        work: &mut Lanes<L>,
        along: [&[[f64; L]]; 3],
        sum: &mut [[f64; L]],
    ) {
        let Self { links, spots, columns, alphas, .. } = self;
        with_fours(Product { linear: Linear { links, spots, columns, alphas }, mesh, work, along, sum });
    }
}

#[cfg(test)]
mod random_case;
#[cfg(test)]
mod tests;
