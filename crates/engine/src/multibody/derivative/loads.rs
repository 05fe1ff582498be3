//! Loads at stations, in jets, eq. (X3): dead loads in the root frame and follower loads in the section's.

use crate::load::{LoadFrame, Wrench};
use crate::math::jet::{Dual, Jet, Vector, Virtual, plus, three, turned_constant};
use crate::math::jet_link::pose;
use crate::math::strain::STRAINS;
use crate::multibody::Model;
use crate::multibody::derivative::{Forces, Place, pass_link};
use crate::multibody::station::{first_coordinate, inner_node, sibling, steps};
use nalgebra::Vector3;

/// A ring in which a wrench has forces on a place.
pub(super) trait Carries: Jet {
    /// Forces on a place of a wrench in its frame, as the residual counts them: negative.
    fn carried(place: &Place<Self>, load: &Wrench, frame: LoadFrame) -> Forces<Self>;
}

impl Carries for Virtual {
    /// Variation of `−(F·p' + M·φ')`, `φ' = ½ Σ r_k × r_k'`: a force that turns with the section pushes its rotation too; the moment that
    /// does not turn with it, by `M × φ'`.
    fn carried(place: &Place<Self>, load: &Wrench, frame: LoadFrame) -> Forces<Self> {
        let kind = |vector: &Vector<Self>, kind: usize| Vector3::from(vector.map(|jet| jet.0[kind]));
        let (force, moment, by_turn);
        match frame {
            LoadFrame::Root => {
                (force, moment) = (load.force_n, load.moment_n_m);
                let turn =
                    place.axes.iter().fold(Vector3::zeros(), |sum, axis| sum + kind(axis, 0).cross(&kind(axis, 3)));
                by_turn = (turn * 0.5).cross(&moment);
            }
            LoadFrame::Section => {
                let value = |vector: &Vector3<f64>| kind(&turned_constant(&place.axes, vector), 0);
                (force, moment) = (value(&load.force_n), value(&load.moment_n_m));
                by_turn = force.cross(&kind(&place.position, 3));
            }
        }
        Forces {
            force: three(|i| Virtual([0.0, 0.0, 0.0, -force[i]])),
            moment: three(|i| Virtual([-by_turn[i], 0.0, 0.0, -moment[i]])),
        }
    }
}

impl Carries for Dual {
    fn carried(place: &Place<Self>, load: &Wrench, frame: LoadFrame) -> Forces<Self> {
        let of = |vector: &Vector3<f64>| -> Vector<Self> {
            let vector = -vector;
            match frame {
                LoadFrame::Root => three(|i| Dual::constant(vector[i])),
                LoadFrame::Section => turned_constant(&place.axes, &vector),
            }
        };
        Forces { force: of(&load.force_n), moment: of(&load.moment_n_m) }
    }
}

/// Adds the loads of all stations to the forces of their inner nodes and to the rows of their elements.
pub(super) fn apply<J: Carries>(
    model: &Model,
    loads: &[Wrench],
    places: &[Place<J>],
    coordinate: &impl Fn(usize) -> J,
    forces: &mut [Forces<J>],
    rows: &mut [J],
) {
    for (station, load) in model.stations.iter().zip(loads).filter(|(_, load)| !load.is_zero()) {
        let (node, first) = (inner_node(model, station), first_coordinate(model, station));
        let (steps, count) = steps(model, station);
        let mut path = [places[node]; 3];
        let mixed = |step: usize| -> [J; STRAINS] {
            let [own, other] = steps[step].weights;
            std::array::from_fn(|i| {
                let mut strain = coordinate(first + i).times(own);
                if other != 0.0 {
                    strain = strain + coordinate(sibling(first) + i).times(other);
                }
                strain
            })
        };
        for step in 0..count {
            path[step + 1] = path[step].linked(&pose(steps[step].length_m, &mixed(step)));
        }
        let mut on = J::carried(&path[count], load, station.frame);
        for step in (0..count).rev() {
            let mut inner = Forces::ZERO;
            let pushed = pass_link(steps[step].length_m, &mixed(step), &path[step], &on, &mut inner);
            let [own, other] = steps[step].weights;
            for (i, pushed) in pushed.into_iter().enumerate() {
                rows[first + i] = rows[first + i] + pushed.times(own);
                if other != 0.0 {
                    rows[sibling(first) + i] = rows[sibling(first) + i] + pushed.times(other);
                }
            }
            on = inner;
        }
        forces[node].force = plus(forces[node].force, on.force);
        forces[node].moment = plus(forces[node].moment, on.moment);
    }
}
