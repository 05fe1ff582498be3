//! Modal bodies at the point of linearisation: columns of their shapes, and the forces of the mass between the ends, NOTATION eq. (X40).

use crate::beam::modal::MAXIMUM_MODES;
use crate::load::RootMotion;
use crate::multibody::derivative::chain::{Column, Shift};
use crate::multibody::derivative::link::turned;
use crate::multibody::derivative::spot::{Field, Four, NONE, Spot};
use crate::multibody::kinematics::Motion;
use crate::multibody::modal::Modal;
use crate::multibody::model::{Body, Model};
use crate::multibody::workspace::Node;
use nalgebra::{Matrix3, Vector3};

/// Places of the causes by which the forces of the mass vary, in the frame of the inner end: rates of the origin and of the three axes,
/// twice the angular velocity, coordinates, rates and accelerations.
const SPIN: usize = 12;
const COORDINATES: usize = 15;
const RATES: usize = COORDINATES + MAXIMUM_MODES;
const ACCELERATIONS: usize = RATES + MAXIMUM_MODES;
const CAUSES: usize = ACCELERATIONS + MAXIMUM_MODES;
/// Places of force, moment and forces on the coordinates.
const MOMENT: usize = 3;
const ROWS: usize = 6;
const EFFECTS: usize = ROWS + MAXIMUM_MODES;

/// A modal body at the point of linearisation.
#[derive(Debug, Clone)]
pub(super) struct ModalBlock {
    body: usize,
    /// Node at its inner end; the next one is at the outer end.
    node: usize,
    /// Index of its first coordinate, and their number.
    first: usize,
    modes: usize,
    /// Attitude of the inner end.
    axes: Matrix3<f64>,
    /// Rates of its nodal vectors.
    loads: Four,
    /// Angular velocity of the root frame in rad/s.
    root_rad_s: Vector3<f64>,
    /// Force and moment of the mass between the ends on the inner end, root frame.
    wrench: [Vector3<f64>; 2],
    /// Slopes of the forces of the mass, by effects and causes.
    slopes: [[f64; CAUSES]; EFFECTS],
    /// Derivatives of the forces on the coordinates (rows) by the coordinates, for a constant wrench at the outer end.
    by_coordinates: [[f64; MAXIMUM_MODES]; MAXIMUM_MODES],
}

/// Columns of a modal body, resolved on its inner node.
pub(super) fn columns<'m>(
    modal: &'m Modal,
    motion: Motion<'m>,
    inner: &'m Node,
    second: &'m Matrix3<f64>,
) -> impl Iterator<Item = Column> + 'm {
    let tip = &modal.element.tip;
    let [q, v, a] = [motion.q, motion.v, motion.a].map(|all| &all[modal.range()]);
    let [shortened, drawn, drawn_more] = [q, v, a].map(|x| tip.shortened(x));
    let turn = modal.element.turn(tip.angles_rad(q));
    let (rates, accelerations) = (tip.angles_rad(v), tip.angles_rad(a));
    (0..modal.element.modes).map(move |i| {
        let along = |value: f64| Vector3::new(-value, 0.0, 0.0);
        let linear = [tip.velocity(i, &shortened), along(drawn[i]), along(drawn_more[i])];
        let angular = turn.spin_with_rates(&tip.angles_1_m(i), &rates, &accelerations);
        Column { linear: turned(inner, second, linear), angular: turned(inner, second, angular), ..Column::ZERO }
    })
}

impl ModalBlock {
    /// The modal bodies of a model.
    pub fn of_model(model: &Model) -> Vec<Self> {
        let of = |(index, body): (usize, &Body)| {
            let modal = body.modal.as_deref()?;
            Some(Self {
                body: index,
                node: body.first_node,
                first: modal.coordinate,
                modes: modal.element.modes,
                axes: Matrix3::identity(),
                loads: NONE,
                root_rad_s: Vector3::zeros(),
                wrench: [Vector3::zeros(); 2],
                slopes: [[0.0; CAUSES]; EFFECTS],
                by_coordinates: [[0.0; MAXIMUM_MODES]; MAXIMUM_MODES],
            })
        };
        model.bodies.iter().enumerate().filter_map(of).collect()
    }

    /// Linearises the body at the motions and wrenches of the last residual.
    pub fn prepare(&mut self, model: &Model, nodes: &[Node], motion: Motion, root: &RootMotion) {
        let Some(modal) = model.bodies[self.body].modal.as_deref() else { return };
        let (inner, outer) = (&nodes[self.node], &nodes[self.node + 1]);
        (self.axes, self.loads, self.root_rad_s) = (inner.rotation, inner.load_rate, root.angular_velocity_rad_s);
        self.prepare_masses(modal, inner, motion);
        let element = &modal.element;
        let [force, moment] = [&outer.force, &outer.moment].map(|vector| inner.rotation.tr_mul(vector));
        let turn = element.turn(element.tip.angles_rad(&motion.q[modal.range()]));
        for i in 0..self.modes {
            for j in 0..self.modes {
                self.by_coordinates[i][j] = element.tip.force_slope((i, j), &turn, (&force, &moment));
            }
        }
    }

    /// Slopes of `f = Σ m (origin + spread p + 2ω × ṗ + p̈)`, of `Σ p × f` and of the projections of `f` on the shapes.
    fn prepare_masses(&mut self, modal: &Modal, inner: &Node, motion: Motion) {
        let [origin, x, y, z] = inner.load_rate.map(|rate| inner.rotation.tr_mul(&rate));
        let spread = Matrix3::from_columns(&[x, y, z]);
        let spin = inner.rotation.tr_mul(&(inner.spin + self.root_rad_s)) * 2.0;
        let [q, v, a] = [motion.q, motion.v, motion.a].map(|all| &all[modal.range()]);
        let (mut sum_force, mut sum_moment) = (Vector3::zeros(), Vector3::zeros());
        self.slopes = [[0.0; CAUSES]; EFFECTS];
        for point in &modal.element.masses {
            let shapes = &point.shapes;
            let [shortened, drawn, drawn_more] = [q, v, a].map(|x| shapes.shortened(x));
            let place = shapes.position_m(q, &shortened);
            let rate = shapes.moved(v, &shortened);
            let along = |value: f64| Vector3::new(-value, 0.0, 0.0);
            let twice: f64 = drawn.iter().zip(v).map(|(drawn, v)| drawn * v).sum();
            let second = along(twice) + shapes.moved(a, &shortened);
            let force = (origin + spread * place + spin.cross(&rate) + second) * point.mass_kg;
            sum_force += force;
            sum_moment += place.cross(&force);
            let partial: [Vector3<f64>; MAXIMUM_MODES] = std::array::from_fn(|i| match i < self.modes {
                true => shapes.velocity(i, &shortened),
                false => Vector3::zeros(),
            });
            // a change of the force by one of its causes
            let mut add = |cause: usize, change: Vector3<f64>| {
                let change = change * point.mass_kg;
                let moment = place.cross(&change);
                for k in 0..3 {
                    self.slopes[k][cause] += change[k];
                    self.slopes[MOMENT + k][cause] += moment[k];
                }
                for (row, partial) in self.slopes[ROWS..ROWS + self.modes].iter_mut().zip(&partial) {
                    row[cause] += partial.dot(&change);
                }
            };
            for k in 0..3 {
                let mut unit = Vector3::zeros();
                unit[k] = 1.0;
                add(k, unit);
                for axis in 0..3 {
                    add(3 + 3 * axis + k, unit * place[axis]);
                }
                add(SPIN + k, unit.cross(&rate));
            }
            for j in 0..self.modes {
                let by_q = spread * partial[j] + spin.cross(&along(drawn[j])) + along(drawn_more[j]);
                add(COORDINATES + j, by_q);
                add(RATES + j, spin.cross(&partial[j]) + along(2.0 * drawn[j]));
                add(ACCELERATIONS + j, partial[j]);
            }
            // the place and the shapes vary with the coordinates too
            for (j, own) in partial[..self.modes].iter().enumerate() {
                let moment = own.cross(&force);
                for k in 0..3 {
                    self.slopes[MOMENT + k][COORDINATES + j] += moment[k];
                }
                for i in 0..self.modes {
                    self.slopes[ROWS + i][COORDINATES + j] -= shapes.shortening_1_m[i][j] * force.x;
                }
            }
        }
        self.wrench = [inner.rotation * sum_force, inner.rotation * sum_moment];
    }

    /// Adds the variations of the wrench on the inner end and of the forces on the coordinates.
    pub fn forward(
        &self,
        (spots, alphas, field): (&[Spot], &[f64], &Field),
        along: Motion,
        shifts: &[Shift],
        wrenches: &mut [[Vector3<f64>; 2]],
        sum: &mut [f64],
    ) {
        let shift = &shifts[self.node];
        let loads = spots[self.node].loads(shift, field, alphas[self.body]);
        let [turn, turn1, _] = &shift.angular;
        let mut causes = [0.0; CAUSES];
        for ((load, own), part) in loads.iter().zip(&self.loads).zip(causes.chunks_exact_mut(3)) {
            part.copy_from_slice(self.axes.tr_mul(&(load - turn.cross(own))).as_slice());
        }
        // the angular velocity varies by `φ̇ + φ × ω`
        let spin = self.axes.tr_mul(&(turn1 - turn.cross(&self.root_rad_s))) * 2.0;
        causes[SPIN..COORDINATES].copy_from_slice(spin.as_slice());
        let range = self.first..self.first + self.modes;
        for (place, change) in [(COORDINATES, along.q), (RATES, along.v), (ACCELERATIONS, along.a)] {
            causes[place..place + self.modes].copy_from_slice(&change[range.clone()]);
        }
        let effect =
            |row: usize| -> f64 { self.slopes[row].iter().zip(&causes).map(|(slope, cause)| slope * cause).sum() };
        let [force, moment] = [0, MOMENT].map(|row| self.axes * Vector3::from_fn(|k, _| effect(row + k)));
        let [own_force, own_moment] = &self.wrench;
        wrenches[self.node][0] += turn.cross(own_force) + force;
        wrenches[self.node][1] += turn.cross(own_moment) + moment;
        for (i, sum) in sum[range.clone()].iter_mut().enumerate() {
            let bent: f64 =
                self.by_coordinates[i].iter().zip(&along.q[range.clone()]).map(|(slope, q)| slope * q).sum();
            *sum += effect(ROWS + i) + bent;
        }
    }

    /// The transpose of [`Self::forward`]: `on` are the multipliers of the wrenches, `w` those of the rows.
    pub fn reverse(
        &self,
        (spots, alphas, field): (&[Spot], &[f64], &Field),
        (on, w): (&[[Vector3<f64>; 2]], &[f64]),
        sums: &mut [Shift],
        [by_q, by_v, by_a]: [&mut [f64]; 3],
    ) {
        let range = self.first..self.first + self.modes;
        let ([on_force, on_moment], w) = (&on[self.node], &w[range.clone()]);
        let mut effects = [0.0; EFFECTS];
        effects[..MOMENT].copy_from_slice(self.axes.tr_mul(on_force).as_slice());
        effects[MOMENT..ROWS].copy_from_slice(self.axes.tr_mul(on_moment).as_slice());
        effects[ROWS..ROWS + self.modes].copy_from_slice(w);
        let mut causes = [0.0; CAUSES];
        for (row, effect) in self.slopes.iter().zip(&effects) {
            causes.iter_mut().zip(row).for_each(|(cause, slope)| *cause += slope * effect);
        }
        let vector = |place: usize| self.axes * Vector3::from_column_slice(&causes[place..place + 3]);
        let mut on_turn = self.wrench[0].cross(on_force) + self.wrench[1].cross(on_moment);
        let on_loads: Four = std::array::from_fn(|k| vector(3 * k));
        for (own, on) in self.loads.iter().zip(&on_loads) {
            on_turn -= own.cross(on);
        }
        let on_spin = vector(SPIN) * 2.0;
        on_turn -= self.root_rad_s.cross(&on_spin);
        let sum = &mut sums[self.node];
        sum.angular[0] += on_turn;
        sum.angular[1] += on_spin;
        spots[self.node].add_loads(&on_loads, field, alphas[self.body], sum);
        for (place, sum) in [(COORDINATES, &mut *by_q), (RATES, by_v), (ACCELERATIONS, by_a)] {
            sum[range.clone()].iter_mut().zip(&causes[place..]).for_each(|(sum, cause)| *sum += cause);
        }
        for (row, w) in self.by_coordinates.iter().zip(w) {
            by_q[range.clone()].iter_mut().zip(row).for_each(|(sum, slope)| *sum += slope * w);
        }
    }
}
