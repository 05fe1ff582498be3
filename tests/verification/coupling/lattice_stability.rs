//! stability with the air of a lattice, against its modes: loads that are held see neither flutter nor divergence.

use crate::coupling::goland::Goland;
use foldwing::interface::Interface;
use foldwing::plant::{Holding, Plant};
use nalgebra::Complex;
use std::sync::Arc;

/// The wing at rest, unswept with its elastic axis at a share of the chord.
fn at_rest(speed_m_s: f64, axis_fraction: f64) -> Plant {
    let case = Goland { gust_m_s: 0.0, axis_fraction, pairs: 3, ..Goland::lattice(4, 6) };
    let mut plant = Plant::new(Arc::new(case.machine(speed_m_s, |structure| structure)));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    plant
}

/// What grows, by the stability of the state and by its linear model.
fn growing(plant: &mut Plant) -> Vec<Complex<f64>> {
    let stability = plant.study().lattice_stability().unwrap_or_else(|error| panic!("{error}")).expect("few states");
    let list: Vec<_> = stability.growing.iter().map(|growth| growth.eigenvalue_1_s).collect();
    assert_eq!(stability.is_stable(), list.is_empty());
    let interface = Interface::new(plant.machine());
    let model = interface.linearize_lattice(plant, &[], &[], &[]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(model.point.growing_1_s.as_deref(), Some(list.as_slice()));
    list
}

/// Below flutter nothing grows. Above it one pair does, at the growth of the mode that is found from the structure, and the
/// structure under held loads is stable all the while.
#[test]
fn flutter_is_an_instability_of_the_lattice_not_of_held_loads() {
    assert_eq!(growing(&mut at_rest(100.0, 0.33)), []);
    let mut plant = at_rest(220.0, 0.33);
    let found = growing(&mut plant);
    let (modes, _) = plant.study().lattice_modes_and_rest(4).unwrap_or_else(|error| panic!("{error}"));
    let expected: Vec<_> = modes.iter().filter(|mode| mode.grows()).map(|mode| mode.eigenvalue_1_s).collect();
    assert!(found.len() == 1 && expected.len() == 1, "{found:?} {expected:?}");
    println!("{found:?}, followed {expected:?}");
    // both solve one eigenvalue problem to 1e-9 of distances in the plane, one of 8000 steps in a second
    assert!((found[0] - expected[0]).norm() < 1e-5 * expected[0].norm(), "{found:?} {expected:?}");
    assert!(found[0].im > 40.0 && found[0].re > 1.0, "{found:?}");
    assert!(plant.study().stability().unwrap_or_else(|error| panic!("{error}")).is_stable());
}

/// Far behind the centre of pressure the axis lets the wing diverge: growth without oscillation.
#[test]
fn divergence_is_an_instability_without_oscillation() {
    let mut plant = at_rest(350.0, 0.5);
    let found = growing(&mut plant);
    let (_, sign) = plant.study().lattice_modes_and_rest(2).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(sign, Some(false), "the static stiffness with the air is negative");
    assert_eq!(found.iter().filter(|value| value.im == 0.0).count(), 1, "{found:?}");
}
