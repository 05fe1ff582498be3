//! Loads at stations inside elements, some stations side by side: what they exert on strains and inner nodes.
//!
//! As [`station::apply`](crate::multibody::station::apply) would one after the other, but in the frames of the links, NOTATION eqs. (K3), (K4), (K10): there
//! nothing depends on the pose of the node, so that several stations can be worked out at once.

use crate::load::{LoadFrame, Wrench};
use crate::math::local_link::{LANES, Lanes, LocalLinks, Strains, Three, cross, poses, turned, turned_back, vector};
use crate::multibody::model::{Model, Station};
use crate::multibody::station::{Step, apply, first_coordinate, inner_node, mix, node_under, steps};
use crate::multibody::workspace::Workspace;
use nalgebra::Vector3;
use std::array::from_fn;

/// Subtracts the loads of all stations from the residual: on the strains of their elements, and on the wrenches of nodes.
/// Allocates nothing.
pub(crate) fn apply_all(model: &Model, work: &mut Workspace, q: &[f64], loads: &[Wrench], residual: &mut [f64]) {
    let mut waiting: [Option<(&Station, &Wrench)>; LANES] = [None; LANES];
    let mut count = 0;
    for (station, load) in model.stations.iter().zip(loads).filter(|(_, load)| !load.is_zero()) {
        if model.bodies[station.body].modal.is_some() || node_under(model, station).is_some() {
            apply(model, work, q, station, load, residual);
            continue;
        }
        if waiting[0].is_some_and(|(first, _)| first.frame != station.frame) {
            apply_some(model, work, q, &waiting, residual);
            (waiting, count) = ([None; LANES], 0);
        }
        waiting[count] = Some((station, load));
        count += 1;
        if count == LANES {
            apply_some(model, work, q, &waiting, residual);
            (waiting, count) = ([None; LANES], 0);
        }
    }
    apply_some(model, work, q, &waiting, residual);
}

/// The links of some stations at the same place on their ways.
struct Way {
    length_m: Lanes,
    weights: [[f64; 2]; LANES],
    links: LocalLinks,
}

impl Way {
    #[inline(always)]
    fn new(q: &[f64], first: &[usize; LANES], steps: [Step; LANES]) -> Self {
        let weights = steps.map(|step| step.weights);
        let each: [[f64; 4]; LANES] = from_fn(|lane| mix(q, first[lane], weights[lane]));
        let length_m = Lanes(steps.map(|step| step.length_m));
        let strains = Strains(from_fn(|strain| Lanes(from_fn(|lane| each[lane][strain]))));
        Self { length_m, weights, links: poses(length_m, &strains) }
    }

    /// Takes a load at the outer ends, in the inner frames, away from the residual of the strains.
    #[inline(always)]
    fn project(&self, first: &[usize], force_n: &Three, moment_n_m: &Three, residual: &mut [f64]) {
        let projected = self.links.project(self.length_m, force_n, moment_n_m);
        for (lane, first) in first.iter().enumerate() {
            let [own, other] = self.weights[lane];
            for (i, projected) in projected.iter().enumerate() {
                residual[first + i] -= own * projected.0[lane];
                if other != 0.0 {
                    residual[first + 4 + i] -= other * projected.0[lane];
                }
            }
        }
    }

    /// Moments about the inner ends of loads at the outer ones.
    #[inline(always)]
    fn moment_inside(&self, force_n: &Three, moment_n_m: &Three) -> Three {
        let arm = cross(self.links.arm_m, *force_n);
        from_fn(|i| moment_n_m[i] + arm[i])
    }
}

/// The same for some stations inside elements, whose loads have the same frame.
#[inline]
fn apply_some(
    model: &Model,
    work: &mut Workspace,
    q: &[f64],
    stations: &[Option<(&Station, &Wrench)>; LANES],
    residual: &mut [f64],
) {
    let count = stations.iter().flatten().count();
    let Some((last, last_load)) = stations[..count].last().copied().flatten() else { return };
    let each: [(&Station, &Wrench); LANES] = from_fn(|lane| stations[lane].unwrap_or((last, last_load)));
    let first: [usize; LANES] = from_fn(|lane| first_coordinate(model, each[lane].0));
    let node: [usize; LANES] = from_fn(|lane| inner_node(model, each[lane].0));
    let ways: [([Step; 2], usize); LANES] = from_fn(|lane| steps(model, each[lane].0));
    let inner = Way::new(q, &first, ways.map(|(steps, _)| steps[0]));
    let outer = ways.iter().any(|(_, links)| *links == 2).then(|| Way::new(q, &first, ways.map(|(steps, _)| steps[1])));

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
    if let Some(outer) = &outer {
        outer.project(&first[..count], &force_n, &moment_n_m, residual);
        moment_n_m = outer.moment_inside(&force_n, &moment_n_m);
        for vector in [&mut force_n, &mut moment_n_m] {
            *vector = turned(&inner.links.rotation, vector);
        }
    }
    inner.project(&first[..count], &force_n, &moment_n_m, residual);
    moment_n_m = inner.moment_inside(&force_n, &moment_n_m);
    for (lane, node) in node[..count].iter().enumerate() {
        let node = &mut work.nodes[*node];
        node.force -= node.rotation * vector(&force_n, lane);
        node.moment -= node.rotation * vector(&moment_n_m, lane);
    }
}
