//! stability with a vortex lattice, compared with its modes: with the loads held constant there is neither flutter nor divergence.

use crate::coupling::goland::Goland;
use foldwing::interface::Interface;
use foldwing::plant::{Branch, Holding, Plant, Search};
use nalgebra::Complex;
use std::sync::Arc;

/// The lattice with a free wake.
const FREE: &str = "model = \"uvlm\"\nmirror_normal = [1.0, 0.0, 0.0]\nfree_wake = true";

/// The unswept wing in equilibrium, with its elastic axis at a fraction of the chord.
fn at_rest(speed_m_s: f64, elastic_axis_fraction: f64) -> Plant {
    let case = Goland { gust_m_s: 0.0, elastic_axis_fraction, pairs: 3, ..Goland::lattice(4, 6) };
    let mut plant = Plant::new(Arc::new(case.machine(speed_m_s, |structure| structure)));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    plant
}

/// Growing modes, by the stability analysis of the state and by its linear model.
fn growing(plant: &mut Plant) -> Vec<Complex<f64>> {
    let stability = plant.study().stability().unwrap_or_else(|error| panic!("{error}"));
    let list: Vec<_> = stability.growing.iter().map(|growth| growth.eigenvalue_1_s).collect();
    assert!(stability.in_lattice && stability.not_judged.is_none(), "{stability:?}");
    assert_eq!(stability.is_stable(), list.is_empty());
    let interface = Interface::new(plant.machine());
    let model = interface.linearize_lattice(plant, &[], &[], &[]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(model.point.growing_1_s.expect("judged"), list);
    list
}

/// Below the flutter speed no mode grows. Above it one pair grows, at the growth rate of the mode found from the structure, while the
/// structure under constant loads is stable throughout.
#[test]
fn flutter_is_an_instability_of_the_lattice_not_of_held_loads() {
    assert_eq!(growing(&mut at_rest(100.0, 0.33)), []);
    let mut plant = at_rest(220.0, 0.33);
    let found = growing(&mut plant);
    assert!(found.len() == 1 && found[0].im > 40.0 && found[0].re > 1.0, "{found:?}");
    // no stable branch exists next to a flutter instability: the state is the only equilibrium, and is reported as unstable
    let search = Search { branch: Branch::Stable, ..Search::default() };
    let rest = plant.study().rest(0.0, Holding::AsReleased, search).unwrap_or_else(|error| panic!("{error}"));
    assert!(rest.departure.is_none() && rest.stability.is_some_and(|judged| !judged.is_stable()));
}

/// The static analysis with a free wake reports no stability, and gives the reason: with constant loads it would miss flutter.
#[test]
fn a_free_wake_is_not_judged() {
    let case = Goland { gust_m_s: 0.0, elastic_axis_fraction: 0.33, pairs: 2, air: FREE, ..Goland::lattice(2, 3) };
    let mut plant = Plant::new(Arc::new(case.machine(220.0, |structure| structure)));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    let judged = plant.study().stability().unwrap_or_else(|error| panic!("{error}"));
    assert!(!judged.is_stable() && judged.unstable_directions() == 0, "{judged:?}");
    assert!(judged.not_judged.is_some_and(|cause| cause.contains("a free wake has no steady shape")));
}

/// With an elastic axis far behind the centre of pressure the wing diverges: growth without oscillation.
#[test]
fn divergence_is_an_instability_without_oscillation() {
    let mut plant = at_rest(350.0, 0.5);
    let found = growing(&mut plant);
    let (_, sign) = plant.study().lattice_modes_and_rest(2).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(sign, Some(false), "the static stiffness with the air is negative");
    assert_eq!(found.iter().filter(|value| value.im == 0.0).count(), 1, "{found:?}");
    let search = Search { branch: Branch::Stable, ..Search::default() };
    let refused = plant.study().rest(0.0, Holding::AsReleased, search).expect_err("no stable equilibrium").to_string();
    assert!(refused.contains("is unstable") && refused.contains("no stable equilibrium was found"), "{refused}");
}
