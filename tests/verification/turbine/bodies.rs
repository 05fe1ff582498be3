//! Masses and moments of the modal bodies.

use crate::turbine::machine::*;
use foldwing::plant::Plant;
use std::sync::Arc;

/// WT-01. Masses, moments of the blade about its root and the rotor's inertia about its shaft, by the mid-point sums of
/// ElastoDyn: the reference has nine digits, the tables here a mass factor already multiplied out and rounded to 1e-6 kg/m.
#[test]
fn wt01_masses_are_those_of_elastodyn() {
    let machine = turbine();
    let law_of = |name: &str| law(machine.bodies.iter().find(|body| body.name == name).expect("a body")).clone();
    let element = foldwing::beam::modal::ModalElement::new(&law_of("blade1"));
    let moment =
        |power: i32| element.masses.iter().map(|point| point.mass_kg * point.shapes.place_m.powi(power)).sum::<f64>();
    let cone = 2.5f64.to_radians().cos();
    let about_shaft: f64 =
        element.masses.iter().map(|point| point.mass_kg * ((point.shapes.place_m + 1.5) * cone).powi(2)).sum();
    for (what, found, expected) in [
        ("mass of a blade", moment(0), 17536.614),
        ("first moment", moment(1), 362132.65),
        ("second moment", moment(2), 11752352.3),
        ("inertia of the rotor", 3.0 * about_shaft + 115926.0, 38677040.6),
        ("mass of the tower", law_of("tower").mass_in_all_kg(), 347460.23),
    ] {
        println!("WT-01 {what}: {found:.8e} ({:.1e})", found / expected - 1.0);
        assert!((found / expected - 1.0).abs() < 1e-6, "{what}: {found} for {expected}");
    }
    let parts = 3.0 * 17536.614 + 347460.23 + 240000.0 + 56780.0;
    let plant = Plant::new(Arc::new(machine));
    assert!((plant.mass_kg() / parts - 1.0).abs() < 1e-6, "{} kg in all", plant.mass_kg());
}
