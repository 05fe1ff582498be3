//! The immutable tree: mesh, masses, stiffness, joints and the positions of their coordinates in `q`.
//!
//! Coordinates follow \[O\] (10)–(12): body by body, first the joint parameter (if the joint is revolute), then the strains element by
//! element ([`Element::range`]); a linear element is two halves with separate strains.

use crate::beam::element::{ElementKind, ElementMass};
use crate::beam::law::{NaturalStrain, SectionLaw};
use crate::beam::modal::ModalElement;
use crate::load::LoadFrame;
use crate::math::strain::{SHEARED, Strain, StrainMatrix};
use crate::multibody::carriage::Slide;
use crate::multibody::circuit::Circuit;
use crate::multibody::damped_mode::DampedMode;
pub use crate::multibody::element::{Elastic, Element, Strained};
use crate::multibody::joint::{Joint, JointKind};
use crate::multibody::loops::{Closure, ClosureDescription};
use crate::multibody::modal::Modal;
use crate::multibody::runner::{NoSlip, NoSlipDescription, ROWS};
use nalgebra::{Matrix3, Matrix4, Vector3};

/// Description of a body for meshing.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyDescription {
    /// Arc length in m.
    pub length_m: f64,
    /// Cross-section along the body.
    pub section: SectionLaw,
    /// Kind of element.
    pub kind: ElementKind,
    /// Number of elements; increased if masses or children require mesh boundaries. Zero for a rigid body: one node at position 0 that
    /// carries its masses.
    pub elements: usize,
    /// Natural strains `(εx, κx, κy, κz)` along the body.
    pub natural_strain: NaturalStrain,
    /// Attachment of the inner end.
    pub parent: Attachment,
    /// Offset of the inner end from the position on the parent, frame of the parent's section there, m; zero on the root.
    pub offset_m: Vector3<f64>,
    /// Parent ← body at angle zero, or at the start for joints without an angle.
    pub mount: Matrix3<f64>,
    /// Type of the joint.
    pub joint: JointKind,
    /// Rigid masses: distance from the inner end in m, and reduced mass matrix ([`crate::beam::element::rigid_body_mass`]).
    pub masses: Vec<(f64, Matrix4<f64>)>,
    /// Load stations: distance from the inner end in m.
    pub stations_m: Vec<f64>,
    /// Frame of the station loads.
    pub load_frame: LoadFrame,
}

/// Attachment of a body's inner end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Attachment {
    /// The root frame, at a position in m.
    Root(Vector3<f64>),
    /// A section of an earlier body, at a distance from its inner end in m.
    Body {
        /// Index of that body.
        index: usize,
        /// Distance from its inner end in m.
        position_m: f64,
    },
    /// The axis of an earlier body, at the arc length of a sliding joint.
    Axis {
        /// Index of that body.
        index: usize,
    },
}

/// Attachment of a body in the tree of nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Base {
    /// Root frame, position in m.
    Root(Vector3<f64>),
    /// Node of an earlier body.
    Node(usize),
    /// Carriage of a sliding joint, by its index in [`Model::slides`].
    Axis(usize),
}

/// One body: a joint, then a chain of elements.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Attachment of its inner end.
    pub base: Base,
    /// Attitude of the body, parent ← body, at angle zero.
    pub mount: Matrix3<f64>,
    /// Offset of its first node from its carrier node, in that node's frame, m; zero on the root.
    pub offset_m: Vector3<f64>,
    /// Joint at its inner end.
    pub joint: Joint,
    /// Index of its first node; node `first_node + i` is the inner end of element `first_element + i`.
    pub first_node: usize,
    /// Index of its first (half-)element.
    pub first_element: usize,
    /// Number of (half-)elements; zero for a rigid or modal body.
    pub elements: usize,
    /// The shapes of a modal body, between its first node and the one at its outer end.
    pub modal: Option<Box<Modal>>,
    /// Kind of element.
    pub kind: ElementKind,
    /// Whether its elements have six strains.
    pub sheared: bool,
    /// Natural strains along it.
    pub natural_strain: NaturalStrain,
    /// Mass blocks of its elements couple `r` and `r_x` only ([`couples_axis_only`]).
    pub slim_mass: bool,
    /// First node of the body on a `free` joint that carries this body, which may be itself; `None` for bodies carried by the root.
    pub carrier: Option<usize>,
    /// Whether the mass-proportional damping also acts on its attached masses.
    pub damps_attached: bool,
    /// Whether a body slides along its axis.
    pub ridden: bool,
    /// Square roots of the factors of stiffness-proportional damping per strain; `None` if all are 1.
    pub damping_roots: Option<Strain<SHEARED>>,
}

/// Whether a mass block couples only the nodal vectors `r` and `r_x` with each other: sections whose centre of mass is on the axis, in
/// principal axes.
pub fn couples_axis_only(mass: &Matrix4<f64>) -> bool {
    let slim = |i: usize, j: usize| i == j || i < 2 && j < 2;
    (0..4).all(|i| (0..4).all(|j| slim(i, j) || mass[(i, j)] == 0.0))
}

impl Body {
    /// Weights of a stiffness block with the factors `elastic` of the stiffness and `viscous` of its damping, NOTATION eq. (D8):
    /// `elastic + viscous s_i s_j`, entry by entry.
    #[inline]
    pub fn damped_weights<const N: usize>(&self, elastic: f64, viscous: f64) -> StrainMatrix<N> {
        match &self.damping_roots {
            None => StrainMatrix::from_element(elastic + viscous),
            Some(roots) => StrainMatrix::from_fn(|i, j| elastic + viscous * (roots[i] * roots[j])),
        }
    }

    /// Node at the outer end.
    pub fn last_node(&self) -> usize {
        self.first_node + self.elements + usize::from(self.modal.is_some())
    }

    /// Nodes that are frames of the beam: all except the middle nodes of pairs.
    pub fn frames(&self) -> impl Iterator<Item = usize> + use<> {
        let stride = if self.kind == ElementKind::Linear { 2 } else { 1 };
        (self.first_node..=self.last_node()).step_by(stride)
    }
}

/// Lumped mass of elements and attachments at a node.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeMass {
    /// Beam inertia: outer block of the element before, inner block of the element after; zero with shear, where these blocks remain with
    /// the elements.
    pub beam: Matrix4<f64>,
    /// Attached rigid masses: damped if [`Body::damps_attached`].
    pub attached: Option<Matrix4<f64>>,
}

impl NodeMass {
    /// Mass on which the mass-proportional damping of its body acts.
    pub fn damped(&self, body: &Body) -> Matrix4<f64> {
        match &self.attached {
            Some(attached) if body.damps_attached => self.beam + attached,
            _ => self.beam,
        }
    }
}

/// A load station.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Index of the body.
    pub body: usize,
    /// Element, or inner half of the pair, that contains it; for a rigid body, the index at which its elements would start.
    pub element: usize,
    /// Arc length from the inner end of that element or pair in m.
    pub offset_m: f64,
    /// Frame of its load.
    pub frame: LoadFrame,
}

/// The tree. Bodies are stored after their parents; nodes and elements are ordered outward within each body.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// Bodies.
    pub bodies: Vec<Body>,
    /// Elements.
    pub elements: Vec<Element>,
    /// Node masses.
    pub nodes: Vec<NodeMass>,
    /// Stations: body by body, then those added later.
    pub stations: Vec<Station>,
    /// Closed loops with a penalty.
    pub closures: Vec<Closure>,
    /// Rigid loops, without a penalty: their multipliers are the last coordinates, three for each, NOTATION eq. (C5).
    pub rigid_loops: Vec<Closure>,
    /// Skates and wheels: their multipliers follow those of the rigid loops, three for each, NOTATION eq. (L47).
    pub no_slips: Vec<NoSlip>,
    /// Modes of beams damped by their ratios.
    pub damped_modes: Vec<DampedMode>,
    /// Sliding joints.
    pub slides: Vec<Slide>,
    /// Armature circuits of motors; their charges are the last coordinates of the tree.
    pub circuits: Vec<Circuit>,
    /// Number of coordinates.
    pub coordinates: usize,
    /// Whether at least one body has elements with six strains.
    pub sheared: bool,
    /// Longest path from the root to a free end in m; scales displacements in the kinematic norm.
    pub reference_length_m: f64,
}

impl Model {
    /// Meshes the bodies. Bodies must be sorted parent before child; positions must be on their bodies.
    pub fn new(descriptions: &[BodyDescription]) -> Self {
        Self::with_constraints(descriptions, &[], &[])
    }

    /// Meshes the bodies of a machine with closed loops, skates and wheels, whose positions become mesh boundaries.
    pub fn with_constraints(
        descriptions: &[BodyDescription],
        closures: &[ClosureDescription],
        no_slips: &[NoSlipDescription],
    ) -> Self {
        let mut model = Self {
            bodies: Vec::new(),
            elements: Vec::new(),
            nodes: Vec::new(),
            stations: Vec::new(),
            closures: Vec::new(),
            rigid_loops: Vec::new(),
            no_slips: Vec::new(),
            damped_modes: Vec::new(),
            slides: Vec::new(),
            circuits: Vec::new(),
            coordinates: 0,
            sheared: false,
            reference_length_m: 0.0,
        };
        let mut path_m: Vec<f64> = Vec::new();
        for (index, description) in descriptions.iter().enumerate() {
            let (base, inner_path_m) = match description.parent {
                Attachment::Root(position) => (Base::Root(position), position.norm()),
                Attachment::Body { index: parent, position_m } => (
                    Base::Node(model.node_at(parent, position_m)),
                    path_m[parent] - descriptions[parent].length_m - reach_m(&descriptions[parent])
                        + position_m
                        + description.offset_m.norm(),
                ),
                Attachment::Axis { index: beam } => {
                    model.bodies[beam].ridden = true;
                    model.slides.push(Slide { beam, rider: index });
                    (Base::Axis(model.slides.len() - 1), path_m[beam] + description.offset_m.norm())
                }
            };
            path_m.push(inner_path_m + description.length_m + reach_m(description));
            let children = descriptions.iter().filter_map(|child| match child.parent {
                Attachment::Body { index: parent, position_m } if parent == index => Some(position_m),
                Attachment::Root(_) | Attachment::Body { .. } | Attachment::Axis { .. } => None,
            });
            let looped = closures.iter().flat_map(|closure| closure.places).flatten();
            let looped = looped.chain(no_slips.iter().map(|no_slip| no_slip.place));
            let looped = looped.filter_map(|(body, position_m)| (body == index).then_some(position_m));
            model.add_body(description, base, children.chain(looped).collect());
        }
        for closure in closures {
            let built = Closure {
                nodes: closure.places.map(|place| place.map(|(body, position_m)| model.node_at(body, position_m))),
                offsets_m: closure.offsets_m,
                penalty: closure.penalty,
            };
            if closure.rigid { model.rigid_loops.push(built) } else { model.closures.push(built) }
        }
        for described in no_slips {
            let node = model.node_at(described.place.0, described.place.1);
            model.no_slips.push(NoSlip { node, described: *described });
        }
        model.coordinates += ROWS * (model.rigid_loops.len() + no_slips.len());
        model.reference_length_m = path_m.iter().copied().fold(0.0, f64::max);
        if model.reference_length_m == 0.0 {
            model.reference_length_m = 1.0; // the machine has no extent
        }
        model
    }

    fn add_body(&mut self, description: &BodyDescription, base: Base, children_m: Vec<f64>) {
        let coordinate = self.coordinates;
        let joint = Joint {
            kind: description.joint.mounted(&description.mount),
            coordinate,
            drive_inertia: 0.0,
            drive_carried: 0.0,
        };
        self.coordinates += joint.kind.coordinates();
        let body_index = self.bodies.len();
        let mut body = Body {
            base,
            mount: description.mount,
            offset_m: description.offset_m,
            joint,
            first_node: self.nodes.len(),
            first_element: self.elements.len(),
            elements: 0,
            modal: None,
            kind: description.kind,
            sheared: description.elements > 0 && description.section.shears(),
            natural_strain: description.natural_strain.clone(),
            slim_mass: true,
            carrier: self.carrier_of(description),
            damps_attached: false,
            ridden: false,
            damping_roots: None,
        };
        if let Some(law) = description.section.modal() {
            let modal = Modal { element: ModalElement::new(law), coordinate: self.coordinates };
            self.coordinates += modal.element.modes;
            body.modal = Some(Box::new(modal));
            body.kind = ElementKind::Constant;
        }
        let section = match description.section.is_uniform() {
            true => SectionLaw::Uniform(description.section.at(0.0)),
            false => description.section.clone(),
        };

        self.sheared |= body.sheared;
        let boundaries = mesh_boundaries(description, children_m);
        let empty = NodeMass { beam: Matrix4::zeros(), attached: None };
        self.nodes.push(empty.clone());
        for pair in boundaries.windows(2) {
            let (start_m, length_m) = (pair[0], pair[1] - pair[0]);
            let law = (description.kind, (start_m, length_m), &section, &description.natural_strain);
            let parts: Vec<(Elastic, Option<Box<Elastic<SHEARED>>>)> = match body.sheared {
                false => Elastic::parts(law.0, law.1, law.2, law.3).into_iter().map(|own| (own, None)).collect(),
                true => Elastic::parts(law.0, law.1, law.2, law.3)
                    .into_iter()
                    .map(|own| (Elastic::none(), Some(Box::new(own))))
                    .collect(),
            };
            let piece_m = length_m / parts.len() as f64;
            for (piece, (elastic, sheared)) in parts.into_iter().enumerate() {
                let inner_m = start_m + piece as f64 * piece_m;
                let kinks: Vec<f64> = section.kinks_m().iter().map(|kink| (kink - inner_m) / piece_m).collect();
                let mass = ElementMass::with_kinks(piece_m, |xi| section.at(inner_m + xi * piece_m), &kinks);
                body.slim_mass &= [&mass.inner, &mass.outer, &mass.cross].into_iter().all(couples_axis_only);
                let element = Element {
                    length_m: piece_m,
                    start_m: inner_m,
                    coordinate: self.coordinates,
                    elastic,
                    sheared,
                    cross_mass: mass.cross,
                    outer_mass: mass.outer,
                    inner_mass: body.sheared.then(|| Box::new(mass.inner)),
                };
                self.coordinates = element.range().end;
                self.elements.push(element);
                body.elements += 1;
                if body.sheared {
                    self.nodes.push(empty.clone());
                    continue;
                }
                let inner = self.nodes.len() - 1;
                self.nodes[inner].beam += mass.inner;
                self.nodes.push(NodeMass { beam: mass.outer, attached: None });
            }
        }
        if body.modal.is_some() {
            self.nodes.push(empty);
        }
        self.bodies.push(body);

        for (position_m, mass) in &description.masses {
            let node = self.node_at(body_index, *position_m);
            let attached = &mut self.nodes[node].attached;
            *attached = Some(attached.unwrap_or_else(Matrix4::zeros) + mass);
        }
        self.add_stations(body_index, &description.stations_m, description.load_frame);
    }

    /// Node whose rigid-body motion is the reference of a new body's mass-proportional damping: its first node if it is on a free joint,
    /// otherwise its parent's carrier.
    fn carrier_of(&self, description: &BodyDescription) -> Option<usize> {
        match (description.joint, description.parent) {
            (joint, _) if joint.floats() => Some(self.nodes.len()),
            (_, Attachment::Body { index, .. } | Attachment::Axis { index }) => self.bodies[index].carrier,
            (_, Attachment::Root(_)) => None,
        }
    }

    /// Appends stations to the existing ones.
    pub fn add_stations(&mut self, body: usize, positions_m: &[f64], frame: LoadFrame) {
        for &position_m in positions_m {
            let (element, offset_m) = self.locate(body, position_m);
            if let Some(modal) = &mut self.bodies[body].modal {
                modal.element.keep(offset_m);
            }
            self.stations.push(Station { body, element, offset_m, frame });
        }
    }

    /// Node nearest to a position on a body; at mesh boundaries exactly the node there.
    pub fn node_at(&self, body: usize, position_m: f64) -> usize {
        let body = &self.bodies[body];
        if let Some(modal) = &body.modal {
            return if position_m < 0.5 * modal.element.length_m { body.first_node } else { body.last_node() };
        }
        let elements = &self.elements[body.first_element..body.first_element + body.elements];
        // a pair's middle node is not a frame of the beam: skip it
        let stride = if body.kind == ElementKind::Linear { 2 } else { 1 };
        let ends = (0..=body.elements).step_by(stride);
        let place = |i: usize| elements.get(i).map_or_else(|| end_of(elements), |element| element.start_m);
        let nearest = ends.min_by(|&i, &j| (place(i) - position_m).abs().total_cmp(&(place(j) - position_m).abs()));
        body.first_node + nearest.unwrap_or(0)
    }

    /// Element (or inner half of the pair) that contains a position, and the arc length from its inner end in m.
    ///
    /// A position on a mesh boundary is assigned to the element outboard of it; a position within 1e-9 of an element's end is moved to that
    /// end.
    pub fn locate(&self, body: usize, position_m: f64) -> (usize, f64) {
        let body_index = body;
        let body = &self.bodies[body];
        if let Some(modal) = &body.modal {
            let length_m = modal.element.length_m;
            let snapped = [0.0, length_m].into_iter().find(|end| (position_m - end).abs() <= 1e-9 * length_m);
            return (body.first_element, snapped.unwrap_or(position_m));
        }
        if body.elements == 0 {
            return (body.first_element, 0.0);
        }
        let stride = if body.kind == ElementKind::Linear { 2 } else { 1 };
        let mut element = body.first_element;
        for candidate in (body.first_element..body.first_element + body.elements).step_by(stride) {
            if self.elements[candidate].start_m <= position_m * (1.0 + 1e-12) {
                element = candidate;
            }
        }
        let offset_m = position_m - self.elements[element].start_m;
        let (length_m, _) = self.span(element, body_index);
        let near = 1e-9 * length_m;
        let snapped = [0.0, length_m].into_iter().find(|end| (offset_m - end).abs() <= near);
        (element, snapped.unwrap_or(offset_m))
    }

    /// Length in m of the element, or pair, that starts with `element`, and the number of its parts.
    pub fn span(&self, element: usize, body: usize) -> (f64, usize) {
        if let Some(modal) = &self.bodies[body].modal {
            return (modal.element.length_m, 1);
        }
        match self.bodies[body].kind {
            ElementKind::Constant => (self.elements[element].length_m, 1),
            ElementKind::Linear => (self.elements[element].length_m + self.elements[element + 1].length_m, 2),
        }
    }
}

/// Extent of a rigid body beyond its node: the radius of gyration of its masses about the node, in m. Zero for beams.
fn reach_m(description: &BodyDescription) -> f64 {
    let sum: Matrix4<f64> = description.masses.iter().map(|(_, mass)| mass).sum();
    if description.elements > 0 || sum[(0, 0)] == 0.0 {
        return 0.0;
    }
    ((sum[(1, 1)] + sum[(2, 2)] + sum[(3, 3)]) / sum[(0, 0)]).sqrt()
}

fn end_of(elements: &[Element]) -> f64 {
    elements.last().map_or(0.0, |element| element.start_m + element.length_m)
}

/// Mesh boundaries from 0 to the body's length: one at every mass and child, the others evenly spaced between these.
fn mesh_boundaries(description: &BodyDescription, children_m: Vec<f64>) -> Vec<f64> {
    if description.elements == 0 || description.section.modal().is_some() {
        return vec![0.0]; // a rigid body has only its node, a modal body one more at its end
    }
    let length_m = description.length_m;
    let near = 1e-9 * length_m;
    let mut stops: Vec<f64> = children_m.into_iter().chain(description.masses.iter().map(|mass| mass.0)).collect();
    stops.retain(|&stop| stop > near && stop < length_m - near);
    stops.extend([0.0, length_m]);
    stops.sort_by(f64::total_cmp);
    stops.dedup_by(|b, a| *b - *a <= near);

    let mut boundaries = vec![0.0];
    for segment in stops.windows(2) {
        let share = (description.elements as f64 * (segment[1] - segment[0]) / length_m).round();
        let count = (share as usize).max(1);
        boundaries.extend((1..=count).map(|i| segment[0] + (segment[1] - segment[0]) * (i as f64 / count as f64)));
    }
    boundaries
}
