//! Internal loads: force and moment of the part outboard of a section on the part inboard of it.
//!
//! They follow from the balance of the outboard part: inertia, loads at stations, attached masses, children. At a node this is the wrench
//! of the recursion. Inside an element the mass between the section and the element's outer node moves according to the element's shape
//! functions, so that the values at both ends of the element are exact, NOTATION eqs. (G5), (G6).

use crate::beam::element::{ElementMass, shape_at};
use crate::beam::law::SectionLaw;
use crate::load::{LoadFrame, Wrench};
use crate::multibody::gauge::{Side, section_wrench};
use crate::multibody::model::{Model, Station};
use crate::multibody::motion::Motion;
use crate::multibody::nodal::{multiply, multiply_transposed, wrench_of};
use crate::multibody::node::Node;
use crate::multibody::slide;
use crate::multibody::station;
use crate::multibody::workspace::Workspace;
use nalgebra::{Matrix3, Vector3};

/// A section of a beam for internal loads.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionPlace {
    /// Position of the section.
    station: Station,
    /// Side of the section for masses and loads attached there.
    side: Side,
    /// Part between the section and the next node outboard; `None` for a section at a node.
    cut: Option<Cut>,
    /// Stations of the model inside the same element or pair whose loads act outboard.
    loaded: Vec<usize>,
}

/// An element cut at a section.
#[derive(Debug, Clone, PartialEq)]
struct Cut {
    /// Inner node of the element, or of the half of a pair.
    inner_node: usize,
    /// Length in m.
    length_m: f64,
    /// Position in the element, 0 to 1.
    xi: f64,
    /// Mass of the part outboard of the cut, in terms of the nodal vectors at the cut and at the outer node.
    mass: ElementMass,
}

impl SectionPlace {
    /// The section of a body with elements at `position_m` from its inner end; `law` is the section law of the body in the model. Stations
    /// that are added to the model later are not taken into account.
    pub fn new(model: &Model, law: &SectionLaw, body: usize, position_m: f64, side: Side) -> Self {
        let (element, offset_m) = model.locate(body, position_m);
        let station = Station { body, element, offset_m, frame: LoadFrame::Root };
        if station::node_under(model, &station).is_some() {
            return Self { station, side, cut: None, loaded: Vec::new() };
        }
        let outboard = |other: &Station| {
            other.body == body
                && other.element == element
                && station::node_under(model, other).is_none()
                && match side {
                    Side::Inboard => other.offset_m >= offset_m,
                    Side::Outboard => other.offset_m > offset_m,
                }
        };
        let loaded = (0..model.stations.len()).filter(|&i| outboard(&model.stations[i])).collect();
        let first_m = model.elements[element].length_m;
        let piece = usize::from(model.span(element, body).1 == 2 && offset_m >= first_m);
        let half = &model.elements[element + piece];
        let xi = (offset_m - piece as f64 * first_m) / half.length_m;
        let (start_m, rest_m) = (half.start_m + xi * half.length_m, (1.0 - xi) * half.length_m);
        let kinks: Vec<f64> = law.kinks_m().iter().map(|kink| (kink - start_m) / rest_m).collect();
        let mass = ElementMass::with_kinks(rest_m, |x| law.at(start_m + x * rest_m), &kinks);
        let inner_node = model.bodies[body].first_node + element + piece - model.bodies[body].first_element;
        Self { station, side, cut: Some(Cut { inner_node, length_m: half.length_m, xi, mass }), loaded }
    }

    /// Force and moment at the section in its frame, on the part inboard, N and N·m. `work` must hold the wrenches of `motion`; `loads` are
    /// those of the model's stations, empty without loads. Allocates nothing.
    pub fn load(&self, model: &Model, work: &Workspace, motion: Motion, loads: &[Wrench]) -> Wrench {
        let body = self.station.body;
        let Some(cut) = &self.cut else {
            let node = station::node_under(model, &self.station).unwrap_or(model.bodies[body].first_node);
            let (force, moment) = section_wrench(model, work, body, node, self.side);
            let axes = work.nodes[node].rotation.transpose();
            return Wrench { force_n: -(axes * force), moment_n_m: -(axes * moment) };
        };
        let section = station::motion(model, work, motion, &self.station);
        let (mut force, mut moment) = cut.wrench(model, work, body, &section.position_m);
        for &i in self.loaded.iter().filter(|&&i| i < loads.len() && !loads[i].is_zero()) {
            let place = &model.stations[i];
            let point = station::motion(model, work, motion, place);
            let (own_force, own_moment) = match place.frame {
                LoadFrame::Root => (loads[i].force_n, loads[i].moment_n_m),
                LoadFrame::Section => (point.rotation * loads[i].force_n, point.rotation * loads[i].moment_n_m),
            };
            force -= own_force;
            moment -= own_moment + (point.position_m - section.position_m).cross(&own_force);
        }
        if model.bodies[body].ridden {
            let from = (self.station.element, self.station.offset_m);
            let riders = slide::outboard_wrench(model, work, motion.q, from, &section.position_m);
            force += riders.linear;
            moment += riders.angular;
        }
        let axes = section.rotation.transpose();
        Wrench { force_n: -(axes * force), moment_n_m: -(axes * moment) }
    }
}

impl Cut {
    /// Inertia forces minus loads on nodes of the part outboard of the section, about a point, root frame.
    fn wrench(
        &self,
        model: &Model,
        work: &Workspace,
        body: usize,
        about_m: &Vector3<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let nodes = [&work.nodes[self.inner_node], &work.nodes[self.inner_node + 1]];
        let outer = nodes[1];
        let pose = |node: &Node| -> [Vector3<f64>; 4] {
            let axis = |k: usize| node.rotation.column(k).into_owned();
            [node.position, axis(0), axis(1), axis(2)]
        };
        let (vectors, load_rates, axes) = match model.bodies[body].sheared {
            false => (nodes.map(pose), nodes.map(|node| node.load_rate), outer.rotation),
            true => {
                let body = &model.bodies[body];
                let slopes = &work.slopes[body.first_element + self.inner_node - body.first_node];
                let ends = [0, 1];
                (
                    ends.map(|end| slopes[end].vectors(nodes[end])),
                    ends.map(|end| slopes[end].load_rates(nodes[end])),
                    slopes[1].axes(outer),
                )
            }
        };
        let here = shape_at(self.length_m, self.xi, &vectors[0], &vectors[1]);
        let rates = shape_at(self.length_m, self.xi, &load_rates[0], &load_rates[1]);
        let sum =
            |a: [Vector3<f64>; 4], b: [Vector3<f64>; 4]| -> [Vector3<f64>; 4] { std::array::from_fn(|k| a[k] + b[k]) };
        let at_place = sum(multiply(&self.mass.inner, &rates), multiply_transposed(&self.mass.cross, &load_rates[1]));
        let at_outer = sum(multiply(&self.mass.outer, &load_rates[1]), multiply(&self.mass.cross, &rates));
        let (own_force, own_moment) = wrench_of(&Matrix3::from_columns(&[here[1], here[2], here[3]]), &at_place);
        let (rest_force, rest_moment) = wrench_of(&axes, &at_outer);
        let (force, moment) = section_wrench(model, work, body, self.inner_node + 1, Side::Inboard);
        let (force, moment) = (force + rest_force, moment + rest_moment);
        (
            force + own_force,
            moment + (outer.position - about_m).cross(&force) + own_moment + (here[0] - about_m).cross(&own_force),
        )
    }
}
