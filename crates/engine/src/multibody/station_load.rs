//! Loads at stations inside elements, several stations at a time: their forces on strains and inner nodes.
//!
//! Equivalent to successive calls of [`station::apply`](crate::multibody::station::apply), but in the frames of the links, NOTATION eqs.
//! (K3), (K4), (K10): these are independent of the pose of the node, so that several stations can be computed at once.

use crate::load::{LoadFrame, Wrench};
use crate::math::local_link::{LANES, Lanes, LocalLinks, Strains, Three, cross, poses, turned, turned_back, vector};
use crate::math::strain::{SHEARED, STRAINS};
use crate::multibody::modal::Modal;
use crate::multibody::model::{Model, Station};
use crate::multibody::motion::Motion;
use crate::multibody::node::Pair;
use crate::multibody::station::{self, Step, apply, first_coordinate, inner_node, mix, node_under, sibling, steps};
use crate::multibody::workspace::Workspace;
use nalgebra::Vector3;
use std::array::from_fn;

/// Subtracts the loads of all stations from the residual, on the strains of their elements and on the wrenches of nodes. Allocates nothing.
pub(crate) fn apply_all(model: &Model, work: &mut Workspace, q: &[f64], loads: &[Wrench], residual: &mut [f64]) {
    for_each(model, loads, |visited| match visited {
        Visited::One(station, load) => apply(model, work, q, station, load, residual),
        Visited::Along(modal, stations, loads) => {
            let node = &mut work.nodes[inner_node(model, &stations[0])];
            modal.gather(node, &q[modal.range()], stations, loads).subtract(modal, node, residual);
        }
        Visited::Some(stations) => match sheared(model, stations) {
            false => Passed::<STRAINS>::new(model, work, q, stations)
                .into_iter()
                .for_each(|passed| passed.subtract(work, residual)),
            true => Passed::<SHEARED>::new(model, work, q, stations)
                .into_iter()
                .for_each(|passed| passed.subtract(work, residual)),
        },
    });
}

/// Power of the loads of all stations in W, by the same map; `work` must hold the whole motion.
pub(crate) fn power_w(model: &Model, work: &Workspace, motion: Motion, loads: &[Wrench]) -> f64 {
    let mut power_w = 0.0;
    for_each(model, loads, |visited| match visited {
        Visited::One(station, load) => {
            let point = station::motion(model, work, motion, station);
            power_w += station::power_w(&point, load, station.frame);
        }
        Visited::Along(modal, stations, loads) => {
            let node = &work.nodes[inner_node(model, &stations[0])];
            let gathered = modal.gather(node, &motion.q[modal.range()], stations, loads);
            power_w += gathered.power_w(node, &motion.v[modal.range()]);
        }
        Visited::Some(stations) => {
            power_w += match sheared(model, stations) {
                false => Passed::<STRAINS>::new(model, work, motion.q, stations)
                    .map_or(0.0, |passed| passed.power_w(work, motion.v)),
                true => Passed::<SHEARED>::new(model, work, motion.q, stations)
                    .map_or(0.0, |passed| passed.power_w(work, motion.v)),
            };
        }
    });
    power_w
}

/// One station on a node, at least one station of a modal body, or several inside elements.
enum Visited<'a, 'b> {
    One(&'a Station, &'a Wrench),
    Along(&'a Modal, &'a [Station], &'a [Wrench]),
    Some(&'b Waiting<'a>),
}

/// Visits all stations that carry a load.
#[inline]
fn for_each<'a>(model: &'a Model, loads: &'a [Wrench], mut visit: impl FnMut(Visited<'a, '_>)) {
    let mut waiting: Waiting = [None; LANES];
    let mut count = 0;
    let mut rest = (&model.stations[..loads.len().min(model.stations.len())], loads);
    while let ([station, stations @ ..], [load, loads @ ..]) = rest {
        if let Some(modal) = &model.bodies[station.body].modal {
            let count = rest.0.iter().take_while(|other| other.body == station.body).count();
            let (along, loads_along) = (&rest.0[..count], &rest.1[..count]);
            visit(Visited::Along(modal, along, loads_along));
            let at_ends =
                along.iter().zip(loads_along).filter(|(station, load)| !load.is_zero() && !modal.is_between(station));
            at_ends.for_each(|(station, load)| visit(Visited::One(station, load)));
            rest = (&rest.0[count..], &rest.1[count..]);
            continue;
        }
        rest = (stations, loads);
        if load.is_zero() {
            continue;
        }
        if node_under(model, station).is_some() {
            visit(Visited::One(station, load));
            continue;
        }
        let differs = |first: &Station| {
            first.frame != station.frame || model.bodies[first.body].sheared != model.bodies[station.body].sheared
        };
        if count == LANES || waiting[0].is_some_and(|(first, _)| differs(first)) {
            visit(Visited::Some(&waiting));
            (waiting, count) = ([None; LANES], 0);
        }
        waiting[count] = Some((station, load));
        count += 1;
    }
    visit(Visited::Some(&waiting));
}

/// Whether collected stations are in elements with shear.
#[inline]
fn sheared(model: &Model, stations: &Waiting) -> bool {
    stations[0].is_some_and(|(first, _)| model.bodies[first.body].sheared)
}

/// Forces on the strains of one link of each station's path, with the weights of the strains of the element and of the other half.
type Exerted<const N: usize> = [([f64; 2], [f64; N]); LANES];

/// One link of each of several stations, at the same position in the list of links between the station and the root.
struct LinkBatch<const N: usize> {
    length_m: Lanes,
    weights: [[f64; 2]; LANES],
    links: LocalLinks,
}

impl<const N: usize> LinkBatch<N> {
    #[inline(always)]
    fn new(q: &[f64], first: &[usize; LANES], steps: [Step; LANES]) -> Self {
        let weights = steps.map(|step| step.weights);
        let each: [[f64; N]; LANES] = from_fn(|lane| mix(q, first[lane], weights[lane]));
        let length_m = Lanes(steps.map(|step| step.length_m));
        let strains: Strains<N> = Strains(from_fn(|strain| Lanes(from_fn(|lane| each[lane][strain]))));
        Self { length_m, weights, links: poses(length_m, &strains) }
    }

    /// Forces on the strains due to a load at the outer ends, in the inner frames.
    #[inline(always)]
    fn project(&self, force_n: &Three, moment_n_m: &Three) -> Exerted<N> {
        let projected: [Lanes; N] = self.links.project(self.length_m, force_n, moment_n_m);
        from_fn(|lane| (self.weights[lane], projected.map(|lanes| lanes.0[lane])))
    }

    /// Moments about the inner ends due to loads at the outer ends.
    #[inline(always)]
    fn moment_inside(&self, force_n: &Three, moment_n_m: &Three) -> Three {
        let arm = cross(self.links.arm_m, *force_n);
        from_fn(|i| moment_n_m[i] + arm[i])
    }
}

/// Stations inside elements, with loads in the same frame, collected for a common computation.
type Waiting<'a> = [Option<(&'a Station, &'a Wrench)>; LANES];

/// Forces due to the loads of several stations: on the strains, starting with the first coordinate of their elements, and on the inner
/// nodes, in the root frame.
struct Passed<const N: usize> {
    count: usize,
    first: [usize; LANES],
    strains: [Option<Exerted<N>>; 2],
    node: [usize; LANES],
    wrenches: [Pair; LANES],
}

impl<const N: usize> Passed<N> {
    #[inline]
    fn new(model: &Model, work: &Workspace, q: &[f64], stations: &Waiting) -> Option<Self> {
        let count = stations.iter().flatten().count();
        let (last, last_load) = stations[..count].last().copied().flatten()?;
        let each: [(&Station, &Wrench); LANES] = from_fn(|lane| stations[lane].unwrap_or((last, last_load)));
        let first: [usize; LANES] = from_fn(|lane| first_coordinate(model, each[lane].0));
        let node: [usize; LANES] = from_fn(|lane| inner_node(model, each[lane].0));
        let paths: [([Step; 2], usize); LANES] = from_fn(|lane| steps(model, each[lane].0));
        let inner = LinkBatch::<N>::new(q, &first, paths.map(|(steps, _)| steps[0]));
        // if only one of the stations has a second link, those of the others have zero length
        let pairs = paths.iter().any(|(_, links)| *links == 2);
        let outer = pairs.then(|| LinkBatch::<N>::new(q, &first, paths.map(|(steps, _)| steps[1])));

        // at the outer ends, in the frames of the stations or in those of the inner nodes
        let in_section = last.frame == LoadFrame::Section;
        let at_station = |part: fn(&Wrench) -> &Vector3<f64>| -> Three {
            let each: [Vector3<f64>; LANES] = from_fn(|lane| match in_section {
                true => *part(each[lane].1),
                false => work.nodes[node[lane]].rotation.tr_mul(part(each[lane].1)),
            });
            from_fn(|axis| Lanes(from_fn(|lane| each[lane][axis])))
        };
        let (mut force_n, mut moment_n_m) = (at_station(|load| &load.force_n), at_station(|load| &load.moment_n_m));
        // now in the inner frames of the last links
        for vector in [&mut force_n, &mut moment_n_m] {
            *vector = match (in_section, &outer) {
                (true, Some(outer)) => turned(&outer.links.rotation, vector),
                (true, None) => turned(&inner.links.rotation, vector),
                (false, Some(_)) => turned_back(&inner.links.rotation, vector),
                (false, None) => *vector,
            };
        }
        let by_outer = outer.map(|outer| {
            let exerted = outer.project(&force_n, &moment_n_m);
            moment_n_m = outer.moment_inside(&force_n, &moment_n_m);
            for vector in [&mut force_n, &mut moment_n_m] {
                *vector = turned(&inner.links.rotation, vector);
            }
            exerted
        });
        let by_inner = inner.project(&force_n, &moment_n_m);
        moment_n_m = inner.moment_inside(&force_n, &moment_n_m);
        let wrenches = from_fn(|lane| {
            let rotation = &work.nodes[node[lane]].rotation;
            Pair { linear: rotation * vector(&force_n, lane), angular: rotation * vector(&moment_n_m, lane) }
        });
        Some(Self { count, first, strains: [by_outer, Some(by_inner)], node, wrenches })
    }

    /// Subtracts the loads from the residual.
    #[inline]
    fn subtract(&self, work: &mut Workspace, residual: &mut [f64]) {
        for exerted in self.strains.iter().flatten() {
            for (first, ([own, other], forces)) in self.first.iter().zip(exerted).take(self.count) {
                for (i, force) in forces.iter().enumerate() {
                    residual[first + i] -= own * force;
                    if *other != 0.0 {
                        residual[sibling::<N>(*first) + i] -= other * force;
                    }
                }
            }
        }
        for (node, wrench) in self.node.iter().zip(&self.wrenches).take(self.count) {
            work.nodes[*node].force -= wrench.linear;
            work.nodes[*node].moment -= wrench.angular;
        }
    }

    /// Power of the loads in W.
    #[inline]
    fn power_w(&self, work: &Workspace, v: &[f64]) -> f64 {
        let mut power_w = 0.0;
        for exerted in self.strains.iter().flatten() {
            for (first, (weights, forces)) in self.first.iter().zip(exerted).take(self.count) {
                let rates: [f64; N] = mix(v, *first, *weights);
                power_w += rates.iter().zip(forces).map(|(rate, force)| rate * force).sum::<f64>();
            }
        }
        for (node, wrench) in self.node.iter().zip(&self.wrenches).take(self.count) {
            let node = &work.nodes[*node];
            power_w += wrench.linear.dot(&node.velocity) + wrench.angular.dot(&node.spin);
        }
        power_w
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::element::ElementKind;
    use crate::beam::section::{Material, Solid};
    use crate::multibody::joint::JointKind;
    use crate::multibody::kinematics::sweep_motion;
    use crate::multibody::model::{Attachment, BodyDescription};

    /// Loads computed together equal those computed one by one, and their power equals that computed with the stations' velocities: a body
    /// of constant elements and one of pairs attached to it, an odd number of stations on nodes and between them, in either frame.
    /// Tolerance: round-off of about a hundred operations on numbers up to 10.
    #[test]
    fn loads_side_by_side_are_those_one_by_one() {
        for frame in [LoadFrame::Root, LoadFrame::Section] {
            let body = |kind, parent| BodyDescription {
                length_m: 0.8,
                section: Solid::rectangle(0.05, 0.01, Material::isotropic(1e8, 0.3, 1000.0)).section().into(),
                kind,
                elements: 4,
                natural_strain: [0.0; STRAINS].into(),
                parent,
                offset_m: Vector3::zeros(),
                mount: nalgebra::Matrix3::identity(),
                joint: JointKind::Clamped,
                masses: Vec::new(),
                stations_m: vec![0.0, 0.05, 0.33, 0.4, 0.47, 0.71, 0.8],
                load_frame: frame,
            };
            let model = Model::new(&[
                body(ElementKind::Constant, Attachment::Root(Vector3::zeros())),
                body(ElementKind::Linear, Attachment::Body { index: 0, position_m: 0.8 }),
            ]);
            let mut generator = fastrand::Rng::with_seed(5);
            let mut random = |size: f64| size * (2.0 * generator.f64() - 1.0);
            let n = model.coordinates;
            let [q, v, a]: [Vec<f64>; 3] = [2.0, 3.0, 5.0].map(|size| (0..n).map(|_| random(size)).collect());
            let motion = Motion { q: &q, v: &v, a: &a };
            let mut vector = || Vector3::new(random(1.0), random(1.0), random(1.0));
            let loads: Vec<Wrench> =
                model.stations.iter().map(|_| Wrench { force_n: vector(), moment_n_m: vector() }).collect();
            let mut together = Workspace::new(&model);
            sweep_motion(&model, &mut together, motion);
            let mut single = together.clone();
            let (mut found, mut known) = (vec![0.0; n], vec![0.0; n]);
            apply_all(&model, &mut together, &q, &loads, &mut found);
            for (place, load) in model.stations.iter().zip(&loads) {
                apply(&model, &mut single, &q, place, load, &mut known);
            }
            for (found, known) in found.iter().zip(&known) {
                assert!((found - known).abs() < 1e-13, "{frame:?}: {found} instead of {known}");
            }
            for (found, known) in together.nodes.iter().zip(&single.nodes) {
                assert!((found.force - known.force).norm() < 1e-13, "{frame:?}");
                assert!((found.moment - known.moment).norm() < 1e-13, "{frame:?}");
            }
            let known: f64 = model.stations.iter().zip(&loads).fold(0.0, |sum, (place, load)| {
                sum + station::power_w(&station::motion(&model, &single, motion, place), load, frame)
            });
            let found = power_w(&model, &single, motion, &loads);
            assert!(known.abs() > 1.0 && (found / known - 1.0).abs() < 1e-13, "{frame:?}: {found} instead of {known}");
        }
    }
}
