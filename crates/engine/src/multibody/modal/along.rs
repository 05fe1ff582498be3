//! Loads along a modal body, for all its stations at once and in the frame of its inner end, NOTATION eqs. (M2)–(M4) and (M8).

use super::Modal;
use crate::beam::modal::{FEW_MODES, MAXIMUM_MODES};
use crate::load::{LoadFrame, Wrench};
use crate::multibody::model::Station;
use crate::multibody::node::Node;
use nalgebra::Vector3;

/// Generalised forces of loads along a body, frame of its inner end.
pub(crate) struct Gathered {
    /// Generalised forces on the coordinates in N.
    on_coordinates: [f64; MAXIMUM_MODES],
    /// Force on the first node in N.
    force: Vector3<f64>,
    /// Moment about the first node in N·m.
    moment: Vector3<f64>,
}

impl Modal {
    /// Whether a station is between the ends: loads at the ends act on nodes.
    pub(crate) fn is_between(&self, station: &Station) -> bool {
        station.offset_m != 0.0 && station.offset_m != self.element.length_m
    }

    /// Sums the loads of stations between the ends; `q` are the coordinates of the body.
    pub(crate) fn gather(&self, node: &Node, q: &[f64], stations: &[Station], loads: &[Wrench]) -> Gathered {
        if self.element.modes <= FEW_MODES {
            self.gathered::<FEW_MODES>(node, q, stations, loads)
        } else {
            self.gathered::<MAXIMUM_MODES>(node, q, stations, loads)
        }
    }

    /// [`Self::gather`] with at most `N` shapes.
    fn gathered<const N: usize>(&self, node: &Node, own_q: &[f64], stations: &[Station], loads: &[Wrench]) -> Gathered {
        let mut q = [0.0; N];
        q[..own_q.len()].copy_from_slice(own_q);
        let mut on_coordinates = [0.0; MAXIMUM_MODES];
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        let (mut own, mut next) = (None, 0);
        for (station, load) in stations.iter().zip(loads) {
            if load.is_zero() || !self.is_between(station) {
                continue;
            }
            let shapes = self.element.shapes_from(station.offset_m, &mut next, &mut own);
            let shortened = shapes.shortened(&q);
            let place = shapes.position_m(&q, &shortened);
            let turn = self.element.turn(shapes.angles_rad(&q));
            let (push, twist) = match station.frame {
                LoadFrame::Root => (node.rotation.tr_mul(&load.force_n), node.rotation.tr_mul(&load.moment_n_m)),
                LoadFrame::Section => {
                    let rotation = turn.rotation();
                    (rotation * load.force_n, rotation * load.moment_n_m)
                }
            };
            let on_angles = turn.moments(&twist);
            for (i, sum) in on_coordinates[..N].iter_mut().enumerate() {
                *sum += shapes.velocity(i, &shortened).dot(&push) + shapes.angles_1_m(i).dot(&on_angles);
            }
            force += push;
            moment += twist + place.cross(&push);
        }
        Gathered { on_coordinates, force, moment }
    }
}

impl Gathered {
    /// Subtracts the loads from the residual and from the wrench on the first node.
    pub(crate) fn subtract(&self, modal: &Modal, node: &mut Node, residual: &mut [f64]) {
        for (out, force) in residual[modal.range()].iter_mut().zip(&self.on_coordinates) {
            *out -= force;
        }
        node.force -= node.rotation * self.force;
        node.moment -= node.rotation * self.moment;
    }

    /// Power of the loads in W, by the same map; `v` are the rates of the body's coordinates.
    pub(crate) fn power_w(&self, node: &Node, v: &[f64]) -> f64 {
        let own: f64 = v.iter().zip(&self.on_coordinates).map(|(rate, force)| rate * force).sum();
        own + (node.rotation * self.force).dot(&node.velocity) + (node.rotation * self.moment).dot(&node.spin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::element::ElementKind;
    use crate::beam::law::SectionLaw;
    use crate::beam::modal::{ModalLaw, Shape};
    use crate::beam::profile::Profile;
    use crate::math::strain::STRAINS;
    use crate::multibody::joint::JointKind;
    use crate::multibody::kinematics::sweep_motion;
    use crate::multibody::model::{Attachment, BodyDescription, Model};
    use crate::multibody::motion::Motion;
    use crate::multibody::workspace::Workspace;
    use crate::multibody::{station, station_load};

    /// A body on a hinge with three shapes, or five, for which the sums have another length; stations between its ends and at them, not in
    /// order.
    fn model(flap: usize, frame: LoadFrame) -> Model {
        let shape =
            |coefficients: &[f64]| Shape { coefficients: coefficients.to_vec(), damping_ratio: 0.0, start_m: 0.0 };
        let flaps = [[1.0, 0.0], [-0.6, 1.6], [0.3, 0.7], [2.0, -1.0]];
        let law = ModalLaw {
            length_m: 3.0,
            cells: 7,
            mass_kg_m: Profile::Polynomial(vec![2.0]),
            flap_stiffness_n_m2: Profile::Polynomial(vec![1e3]),
            edge_stiffness_n_m2: Profile::Polynomial(vec![3e3]),
            twist_rad: Some(Profile::Polynomial(vec![0.4])),
            flap: flaps[..flap].iter().map(|coefficients| shape(coefficients)).collect(),
            edge: vec![shape(&[0.8, 0.2])],
            axial_shortening: true,
            section_rotation: true,
            rates_of_angles: false,
            mass_factor: 1.0,
            stiffness_factor: 1.0,
        };
        Model::new(&[BodyDescription {
            length_m: 3.0,
            section: SectionLaw::Modal(Box::new(law)),
            kind: ElementKind::Constant,
            elements: 1,
            natural_strain: [0.0; STRAINS].into(),
            parent: Attachment::Root(Vector3::zeros()),
            offset_m: Vector3::zeros(),
            mount: nalgebra::Matrix3::identity(),
            joint: JointKind::Revolute { axis: *Vector3::y_axis() },
            masses: Vec::new(),
            stations_m: vec![2.5, 0.0, 0.4, 1.1, 3.0, 1.7],
            load_frame: frame,
        }])
    }

    /// The power of loads along a body equals that computed with the velocities of their stations, for the rate of each coordinate alone
    /// and for all together. Tolerance: round-off of about a hundred operations on numbers up to 10.
    #[test]
    fn loads_along_a_body_work_as_their_stations_move() {
        for (flap, frame) in
            [(2, LoadFrame::Root), (2, LoadFrame::Section), (4, LoadFrame::Root), (4, LoadFrame::Section)]
        {
            let model = model(flap, frame);
            let n = model.coordinates;
            let mut generator = fastrand::Rng::with_seed(7);
            let mut random = |size: f64| size * (2.0 * generator.f64() - 1.0);
            let [q, v]: [Vec<f64>; 2] = [0.5, 3.0].map(|size| (0..n).map(|_| random(size)).collect());
            let mut vector = || Vector3::new(random(1.0), random(1.0), random(1.0));
            let loads: Vec<Wrench> =
                model.stations.iter().map(|_| Wrench { force_n: vector(), moment_n_m: vector() }).collect();
            let powers = |v: &[f64]| {
                let (mut work, a) = (Workspace::new(&model), vec![0.0; n]);
                let motion = Motion { q: &q, v, a: &a };
                sweep_motion(&model, &mut work, motion);
                let by_stations: f64 = model.stations.iter().zip(&loads).fold(0.0, |sum, (place, load)| {
                    sum + station::power_w(&station::motion(&model, &work, motion, place), load, frame)
                });
                (by_stations, station_load::power_w(&model, &work, motion, &loads), work)
            };
            let (known, found, mut work) = powers(&v);
            assert!(known.abs() > 1.0 && (found - known).abs() < 1e-12, "{frame:?}: {found} W instead of {known}");
            let mut residual = vec![0.0; n];
            work.nodes.iter_mut().for_each(|node| (node.force, node.moment) = Default::default());
            station_load::apply_all(&model, &mut work, &q, &loads, &mut residual);
            let modal = model.bodies[0].modal.as_ref().expect("shapes");
            for i in modal.range() {
                let mut unit = vec![0.0; n];
                unit[i] = 1.0;
                let (known, _, moved) = powers(&unit);
                // loads at the outer end are already applied to its node
                let end = model.bodies[0].last_node();
                let at_end = work.nodes[end].force.dot(&moved.nodes[end].velocity)
                    + work.nodes[end].moment.dot(&moved.nodes[end].spin);
                let found = -residual[i] - at_end;
                assert!((found - known).abs() < 1e-12, "{frame:?}, coordinate {i}: {found} N instead of {known}");
            }
        }
    }
}
