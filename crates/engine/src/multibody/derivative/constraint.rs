//! Variations of the forces and gaps of constraints: rigid loops, skates and wheels, NOTATION eqs. (C5), (L47) and (X42).

use crate::math::jet::{Partial, Vector};
use crate::math::so3::hat;
use crate::multibody::closure::Closure;
use crate::multibody::constraint::Constraint;
use crate::multibody::derivative::chain::{Shift, Timed, fixed, second};
use crate::multibody::kinematics::Motion;
use crate::multibody::model::Model;
use crate::multibody::no_slip::{NoSlip, NodeMotion, ROWS};
use crate::multibody::node::Node;
use crate::multibody::workspace::Workspace;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Entries of a [`Shift`]: variations of a node's position and attitude with two time derivatives each.
const ENTRIES: usize = 18;
/// Rows of the gap, its rate and its acceleration.
const GAP_ROWS: usize = 3 * ROWS;
/// Place of the rotation in the entries of a shift.
const TURN: usize = 9;

/// Rows of the gap, its rate and its acceleration by the entries of a shift.
type GapSlopes = SMatrix<f64, GAP_ROWS, ENTRIES>;

/// A constraint at the point of linearisation.
#[derive(Debug, Clone)]
pub(super) struct ConstraintBlock {
    /// Index of its first multiplier among the coordinates.
    first: usize,
    ends: [Option<End>; 2],
}

/// A node on which a constraint acts.
#[derive(Debug, Clone, Copy)]
struct End {
    node: usize,
    gap: GapSlopes,
    /// Force and moment on the node by its rotation, for constant multipliers.
    by_turn: [Matrix3<f64>; 2],
    /// Force and moment on the node per multiplier, in columns.
    per_multiplier: [Matrix3<f64>; 2],
}

/// Entries of a shift in one vector.
fn entries(shift: &Shift) -> SVector<f64, ENTRIES> {
    let parts = shift.linear.iter().chain(&shift.angular);
    SVector::from_iterator(parts.flat_map(|part| part.iter().copied()))
}

/// Shift of which one entry is 1.
fn unit(entry: usize) -> Shift {
    let mut shift = Shift::ZERO;
    let part = if entry < TURN { &mut shift.linear } else { &mut shift.angular };
    part[(entry % TURN) / 3][entry % 3] = 1.0;
    shift
}

/// `e × vector` of the three unit vectors `e`, in columns.
fn turned_by_units(vector: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::from_columns(&[0, 1, 2].map(|axis| Vector3::ith(axis, 1.0).cross(vector)))
}

impl End {
    /// The end of a loop on a node; `sign`: of its point in the gap.
    fn of_loop(
        closure: &Closure,
        (side, sign): (usize, f64),
        multipliers: &Vector3<f64>,
        work: &Workspace,
    ) -> Option<Self> {
        let number = closure.nodes[side]?;
        let node: &Node = &work.nodes[number];
        let arm: Timed = fixed(node, &second(node), node.rotation * closure.offsets_m[side]);
        let mut gap = GapSlopes::zeros();
        for entry in 0..ENTRIES {
            let moved = unit(entry).carried(&arm).linear;
            for (row, moved) in moved.iter().flat_map(|order| order.iter()).enumerate() {
                gap[(row, entry)] = sign * moved;
            }
        }
        let force = multipliers * sign;
        let moment_by_turn = -hat(&force) * turned_by_units(&arm[0]);
        Some(Self {
            node: number,
            gap,
            by_turn: [Matrix3::zeros(), moment_by_turn],
            per_multiplier: [Matrix3::identity() * sign, hat(&arm[0]) * sign],
        })
    }

    /// The node of a skate or a wheel.
    fn of_no_slip(no_slip: &NoSlip, multipliers: &Vector3<f64>, work: &Workspace) -> Self {
        let motion = NodeMotion::varied(&work.nodes[no_slip.node]);
        let mut gap = GapSlopes::zeros();
        let rows = no_slip.rows(&motion);
        for (row, jet) in rows.iter().flatten().enumerate() {
            for (entry, by) in jet.by.iter().enumerate() {
                gap[(row, entry)] = *by;
            }
        }
        let (mut by_turn, mut per_multiplier) = ([Matrix3::zeros(); 2], [Matrix3::zeros(); 2]);
        for (row, wrench) in no_slip.wrenches(&motion).iter().enumerate() {
            for (part, vector) in wrench.iter().enumerate() {
                let vector: &Vector<Partial<ENTRIES>> = vector;
                for (axis, jet) in vector.iter().enumerate() {
                    per_multiplier[part][(axis, row)] = jet.value;
                    for turn in 0..3 {
                        by_turn[part][(axis, turn)] += multipliers[row] * jet.by[TURN + turn];
                    }
                }
            }
        }
        Self { node: no_slip.node, gap, by_turn, per_multiplier }
    }
}

impl ConstraintBlock {
    /// The constraints of a model.
    pub fn of_model(model: &Model) -> Vec<Self> {
        let block = |index: usize| Self { first: model.multipliers(index).start, ends: [None; 2] };
        (0..model.constraints()).map(block).collect()
    }

    /// Linearises a constraint at the motions in `work`, for the multipliers among the accelerations.
    pub fn prepare(&mut self, constraint: Constraint, motion: Motion, work: &Workspace) {
        let multipliers = Vector3::from_column_slice(&motion.a[self.first..self.first + ROWS]);
        self.ends = match constraint {
            Constraint::Loop(closure) => {
                [(0, -1.0), (1, 1.0)].map(|side| End::of_loop(closure, side, &multipliers, work))
            }
            Constraint::NoSlip(no_slip) => [Some(End::of_no_slip(no_slip, &multipliers, work)), None],
        };
    }

    fn gap(&self, shifts: &[Shift]) -> SVector<f64, GAP_ROWS> {
        self.ends.iter().flatten().map(|end| end.gap * entries(&shifts[end.node])).sum()
    }

    /// Adds the variations of the wrenches on the nodes, and those of the second rates of the gap to the rows of the multipliers.
    pub fn forward(&self, shifts: &[Shift], along: Motion, wrenches: &mut [[Vector3<f64>; 2]], sum: &mut [f64]) {
        let change = Vector3::from_column_slice(&along.a[self.first..self.first + ROWS]);
        for end in self.ends.iter().flatten() {
            let turn = &shifts[end.node].angular[0];
            for (part, wrench) in wrenches[end.node].iter_mut().enumerate() {
                *wrench += end.by_turn[part] * turn + end.per_multiplier[part] * change;
            }
        }
        let gap = self.gap(shifts);
        for row in 0..ROWS {
            sum[self.first + row] += gap[2 * ROWS + row];
        }
    }

    /// The transpose of [`Self::forward`]; `on` are the multipliers of the wrenches, `w` those of the rows.
    pub fn reverse(&self, on: &[[Vector3<f64>; 2]], w: &[f64], sums: &mut [Shift], by_a: &mut [f64]) {
        for end in self.ends.iter().flatten() {
            for (part, on) in on[end.node].iter().enumerate() {
                sums[end.node].angular[0] += end.by_turn[part].tr_mul(on);
                let by_multipliers = end.per_multiplier[part].tr_mul(on);
                by_a[self.first..].iter_mut().zip(&by_multipliers).for_each(|(sum, by)| *sum += by);
            }
        }
        for row in 0..ROWS {
            self.add_row(2 * ROWS + row, w[self.first + row], sums);
        }
    }

    /// Adds the multipliers of the shifts for a multiplier of a row of the gap, its rate or its acceleration.
    pub fn add_row(&self, row: usize, weight: f64, sums: &mut [Shift]) {
        if weight == 0.0 {
            return;
        }
        for end in self.ends.iter().flatten() {
            let Shift { linear, angular } = &mut sums[end.node];
            for (part, sum) in linear.iter_mut().chain(angular).enumerate() {
                *sum += end.gap.fixed_view::<1, 3>(row, 3 * part).transpose() * weight;
            }
        }
    }
}

impl NodeMotion<Partial<ENTRIES>> {
    /// A node with its variations by the entries of a shift.
    fn varied(node: &Node) -> Self {
        let jets = |value: &Vector3<f64>, orders: &[(usize, Matrix3<f64>)]| -> Vector<Partial<ENTRIES>> {
            std::array::from_fn(|axis| {
                let mut by = [0.0; ENTRIES];
                for (first, columns) in orders {
                    (0..3).for_each(|entry| by[first + entry] = columns[(axis, entry)]);
                }
                Partial { value: value[axis], by }
            })
        };
        let unit = Matrix3::identity();
        let (spin, spin_rate) = (turned_by_units(&node.spin), turned_by_units(&node.spin_rate));
        Self {
            position: jets(&node.position, &[(0, unit)]),
            velocity: jets(&node.velocity, &[(3, unit)]),
            acceleration: jets(&node.acceleration, &[(6, unit)]),
            // of vectors fixed to the node: δω = δθ̇ + δθ × ω
            spin: jets(&node.spin, &[(TURN, spin), (TURN + 3, unit)]),
            spin_rate: jets(&node.spin_rate, &[(TURN, spin_rate), (TURN + 3, spin), (TURN + 6, unit)]),
            axes: [0, 1, 2].map(|axis| {
                let own = node.rotation.column(axis).into_owned();
                jets(&own, &[(TURN, turned_by_units(&own))])
            }),
        }
    }
}
