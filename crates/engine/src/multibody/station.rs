//! Stations: points inside elements with loads and motion outputs.
//!
//! Inside a pair the pose at `σ = s/ℓ` is that of two constant-strain links of length `s/2` with mixed strains `αA + (1−α)B` and
//! `βA + (1−β)B`, `α = 5/4 − σ/4`, `β = 5/4 − 5σ/4`, NOTATION eq. (K10): fourth order. Loads are projected on the coordinates by the same
//! map as the station's velocity, so their power is conserved.

use crate::beam::element::ElementKind;
use crate::load::{LoadFrame, SectionMotion, Wrench};
use crate::math::se3::{Link, LinkGeometry, LinkRates};
use crate::math::strain::{SHEARED, STRAINS, strains_at};
use crate::multibody::model::{Model, Station};
use crate::multibody::motion::Motion;
use crate::multibody::workspace::Workspace;
use nalgebra::{Matrix3, Vector3};
use std::slice::from_ref;

/// One link of the path from the element's inner node to the station: its strain is `own · (strain of this element) + sibling · (strain of
/// the other half)`.
#[derive(Clone, Copy)]
pub(crate) struct Step {
    /// Length in m.
    pub length_m: f64,
    /// Weights of the strains of the element and of the other half.
    pub weights: [f64; 2],
}

/// Arm and outer frame of a link.
pub(crate) struct Reached {
    pub arm_m: Vector3<f64>,
    pub rotation: Matrix3<f64>,
}

impl Step {
    /// The link on an inner frame, for an element with `N` strains whose first coordinate is `first`.
    pub fn link<const N: usize>(&self, inner: &Matrix3<f64>, q: &[f64], first: usize) -> Link<N> {
        LinkGeometry::new(inner, self.length_m, &mix(q, first, self.weights)).1
    }

    /// Pose and rates at the end of the link.
    #[inline]
    fn moved<const N: usize>(&self, inner: &Matrix3<f64>, motion: Motion, first: usize) -> (Reached, LinkRates) {
        let (geometry, link) = LinkGeometry::new::<N>(inner, self.length_m, &mix(motion.q, first, self.weights));
        let rates = geometry.rates::<N>(inner, &mix(motion.v, first, self.weights));
        (Reached { arm_m: link.arm_m, rotation: link.rotation }, rates)
    }

    /// Pose, rates, and the same linear map applied to the second time derivatives, since velocities are linear in the rates.
    #[inline]
    fn accelerated<const N: usize>(
        &self,
        inner: &Matrix3<f64>,
        motion: Motion,
        first: usize,
    ) -> (Reached, LinkRates, LinkRates) {
        let (geometry, link) = LinkGeometry::new::<N>(inner, self.length_m, &mix(motion.q, first, self.weights));
        let [rates, second] =
            [motion.v, motion.a].map(|rates| geometry.rates::<N>(inner, &mix(rates, first, self.weights)));
        (Reached { arm_m: link.arm_m, rotation: link.rotation }, rates, second)
    }
}

/// The links that lead to a station, and their number.
pub(crate) fn steps(model: &Model, station: &Station) -> ([Step; 2], usize) {
    let none = Step { length_m: 0.0, weights: [1.0, 0.0] };
    if model.bodies[station.body].elements == 0 {
        return ([none, none], 0);
    }
    let element = &model.elements[station.element];
    match model.bodies[station.body].kind {
        ElementKind::Constant => ([Step { length_m: station.offset_m, weights: [1.0, 0.0] }, none], 1),
        ElementKind::Linear => {
            let sigma = station.offset_m / (2.0 * element.length_m);
            let (alpha, beta) = (1.25 - 0.25 * sigma, 1.25 - 1.25 * sigma);
            let length_m = 0.5 * station.offset_m;
            ([Step { length_m, weights: [alpha, 1.0 - alpha] }, Step { length_m, weights: [beta, 1.0 - beta] }], 2)
        }
    }
}

/// First strain of the element, or inner half of the pair, that contains a station; unused on a rigid body, which has no links.
pub(crate) fn first_coordinate(model: &Model, station: &Station) -> usize {
    model.elements.get(station.element).map_or(0, |element| element.coordinate)
}

/// First strain of the outer half of a pair, from that of the inner half; halves with `N` strains.
#[inline(always)]
pub(crate) fn sibling<const N: usize>(first: usize) -> usize {
    first + N
}

/// Mixed strains (or rates) of one link; `coordinates` hold those of the inner half, then those of the outer half.
pub(crate) fn mix<const N: usize>(coordinates: &[f64], first: usize, weights: [f64; 2]) -> [f64; N] {
    let own: [f64; N] = strains_at(coordinates, first);
    if weights[1] == 0.0 {
        return own.map(|strain| strain * weights[0]);
    }
    let other: [f64; N] = strains_at(coordinates, sibling::<N>(first));
    std::array::from_fn(|i| weights[0] * own[i] + weights[1] * other[i])
}

/// Pose, velocity and angular velocity of a station; in `work` the poses of the nodes must be current, and for rates the whole motion.
pub fn motion(model: &Model, work: &Workspace, motion: Motion, station: &Station) -> SectionMotion {
    let first = first_coordinate(model, station);
    let node = &work.nodes[inner_node(model, station)];
    if let Some(modal) = &model.bodies[station.body].modal {
        return modal.motion_at(node, motion, station.offset_m);
    }
    let mut point = SectionMotion {
        rotation: node.rotation,
        position_m: node.position,
        velocity_m_s: node.velocity,
        spin_rad_s: node.spin,
    };
    let (steps, count) = steps(model, station);
    for step in &steps[..count] {
        let (link, rates) = match model.bodies[station.body].sheared {
            false => step.moved::<STRAINS>(&point.rotation, motion, first),
            true => step.moved::<SHEARED>(&point.rotation, motion, first),
        };
        point.velocity_m_s += point.spin_rad_s.cross(&link.arm_m) + rates.velocity;
        point.spin_rad_s += rates.spin;
        point.position_m += link.arm_m;
        point.rotation = link.rotation;
    }
    point
}

/// Motion of a section, with accelerations relative to the root frame, resolved in the root frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accelerated {
    /// Pose, velocity and angular velocity.
    pub motion: SectionMotion,
    /// Acceleration in m/s².
    pub acceleration_m_s2: Vector3<f64>,
    /// Angular acceleration in rad/s².
    pub spin_rate_rad_s2: Vector3<f64>,
}

/// Motion of a station with its accelerations, NOTATION eqs. (K5), (K9), (K10); `work` must hold the whole motion.
pub fn accelerated(model: &Model, work: &Workspace, motion: Motion, station: &Station) -> Accelerated {
    let first = first_coordinate(model, station);
    let node = &work.nodes[inner_node(model, station)];
    if let Some(modal) = &model.bodies[station.body].modal {
        return modal.accelerated_at(node, motion, station.offset_m);
    }
    let point = SectionMotion {
        rotation: node.rotation,
        position_m: node.position,
        velocity_m_s: node.velocity,
        spin_rad_s: node.spin,
    };
    let start = Accelerated { motion: point, acceleration_m_s2: node.acceleration, spin_rate_rad_s2: node.spin_rate };
    let (steps, count) = steps(model, station);
    // a single branch for all links: one branch per link would copy each result
    match model.bodies[station.body].sheared {
        false => along::<STRAINS>(&steps[..count], motion, first, start),
        true => along::<SHEARED>(&steps[..count], motion, first, start),
    }
}

/// Motion at the end of links, from that at their start.
#[inline]
fn along<const N: usize>(steps: &[Step], motion: Motion, first: usize, start: Accelerated) -> Accelerated {
    let Accelerated { motion: mut point, mut acceleration_m_s2, mut spin_rate_rad_s2 } = start;
    for step in steps {
        let (link, rates, second) = step.accelerated::<N>(&point.rotation, motion, first);
        let swing = point.spin_rad_s.cross(&link.arm_m);
        acceleration_m_s2 += spin_rate_rad_s2.cross(&link.arm_m)
            + point.spin_rad_s.cross(&(swing + rates.velocity * 2.0))
            + second.velocity
            + rates.velocity_bias;
        spin_rate_rad_s2 += point.spin_rad_s.cross(&rates.spin) + second.spin + rates.spin_bias;
        point.velocity_m_s += swing + rates.velocity;
        point.spin_rad_s += rates.spin;
        point.position_m += link.arm_m;
        point.rotation = link.rotation;
    }
    Accelerated { motion: point, acceleration_m_s2, spin_rate_rad_s2 }
}

/// Attitude of a station, root ← section; poses of the nodes must be current in `work`.
pub fn rotation(model: &Model, work: &Workspace, q: &[f64], station: &Station) -> Matrix3<f64> {
    let node = &work.nodes[inner_node(model, station)];
    if let Some(modal) = &model.bodies[station.body].modal {
        let mut own = None;
        return modal.place(node, &q[modal.range()], modal.element.shapes(station.offset_m, &mut own)).rotation(node);
    }
    let first = first_coordinate(model, station);
    let mut rotation = node.rotation;
    let (steps, count) = steps(model, station);
    for step in &steps[..count] {
        rotation = match model.bodies[station.body].sheared {
            false => step.link::<STRAINS>(&rotation, q, first).rotation,
            true => step.link::<SHEARED>(&rotation, q, first).rotation,
        };
    }
    rotation
}

/// Subtracts a station's load from the residual, on the strains of its element and on the wrench of its inner node.
pub(crate) fn apply(
    model: &Model,
    work: &mut Workspace,
    q: &[f64],
    station: &Station,
    load: &Wrench,
    residual: &mut [f64],
) {
    let node = inner_node(model, station);
    if let Some(node) = node_under(model, station) {
        let rotation = &work.nodes[node].rotation;
        let (force, moment) = match station.frame {
            LoadFrame::Root => (load.force_n, load.moment_n_m),
            LoadFrame::Section => (rotation * load.force_n, rotation * load.moment_n_m),
        };
        work.nodes[node].add_fixed(&-force, &-moment);
        return;
    }
    if let Some(modal) = &model.bodies[station.body].modal {
        let node = &mut work.nodes[node];
        let gathered = modal.gather(node, &q[modal.range()], from_ref(station), from_ref(load));
        gathered.subtract(modal, node, residual);
        return;
    }
    match model.bodies[station.body].sheared {
        false => apply_inside::<STRAINS>(model, work, q, station, load, residual),
        true => apply_inside::<SHEARED>(model, work, q, station, load, residual),
    }
}

/// [`apply`] inside an element with `N` strains, or on a rigid body.
fn apply_inside<const N: usize>(
    model: &Model,
    work: &mut Workspace,
    q: &[f64],
    station: &Station,
    load: &Wrench,
    residual: &mut [f64],
) {
    let first = first_coordinate(model, station);
    let node = inner_node(model, station);
    let (steps, count) = steps(model, station);
    let mut rotation = work.nodes[node].rotation;
    let mut links = [Link::<N>::ZERO; 2];
    for (step, link) in steps[..count].iter().zip(&mut links) {
        *link = step.link(&rotation, q, first);
        rotation = link.rotation;
    }
    let (force, mut moment) = match station.frame {
        LoadFrame::Root => (load.force_n, load.moment_n_m),
        LoadFrame::Section => (rotation * load.force_n, rotation * load.moment_n_m),
    };
    for (step, link) in steps[..count].iter().zip(&links).rev() {
        for (i, projected) in link.project(&force, &moment).iter().enumerate() {
            residual[first + i] -= step.weights[0] * projected;
            if step.weights[1] != 0.0 {
                residual[sibling::<N>(first) + i] -= step.weights[1] * projected;
            }
        }
        moment += link.arm_m.cross(&force);
    }
    work.nodes[node].force -= force;
    work.nodes[node].moment -= moment;
}

/// Node at a station at the end of an element or pair: the load is then applied to that node, and the strain on either side of it is
/// recovered with and without the load.
pub(crate) fn node_under(model: &Model, station: &Station) -> Option<usize> {
    let inner = inner_node(model, station);
    if station.offset_m == 0.0 {
        return Some(inner);
    }
    let (length_m, pieces) = model.span(station.element, station.body);
    (station.offset_m == length_m).then_some(inner + pieces)
}

/// Inner node of the element or pair that contains a station.
pub(crate) fn inner_node(model: &Model, station: &Station) -> usize {
    let body = &model.bodies[station.body];
    body.first_node + station.element - body.first_element
}

/// Power of a station's load in W.
pub fn power_w(point: &SectionMotion, load: &Wrench, frame: LoadFrame) -> f64 {
    let (force, moment) = match frame {
        LoadFrame::Root => (load.force_n, load.moment_n_m),
        LoadFrame::Section => (point.rotation * load.force_n, point.rotation * load.moment_n_m),
    };
    force.dot(&point.velocity_m_s) + moment.dot(&point.spin_rad_s)
}
