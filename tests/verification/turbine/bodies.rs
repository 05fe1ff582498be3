//! Masses and mass moments of the modal bodies.

use crate::turbine::machine::*;
use foldwing::plant::Plant;
use std::sync::Arc;

/// WT-01. Masses, moments of the blade about its root and the rotor's inertia about its shaft, by the mid-point sums of ElastoDyn: the
/// reference has nine digits; in the tables here the mass factor is already multiplied in and rounded to 1e-6 kg/m.
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

/// WT-83. Copies of a hinged body by `count`: position and axis of the joint are rotated with the copy about the parent's `x`, not about
/// the axis of the joint; against hand calculation.
#[test]
fn wt83_copies_of_a_hinged_body() {
    let text = "name = \"Hinged\"\n[section.bar]\nshape = \"rectangle\"\nwidth_m = 0.1\nheight_m = 0.1\nyoungs_modulus_Pa = 1e9\nshear_modulus_Pa = 4e8\n\
        density_kg_m3 = 1000.0\n[rigid_body.hub]\nmass_kg = 10.0\ninertia_kg_m2 = [1, 1, 1, 0, 0, 0]\n\
        [joint.shaft]\ntype = \"revolute\"\nparent = \"root\"\nchild = \"hub\"\naxis = [1, 0, 0]\n\
        [body.blade]\ncount = 3\nlength_m = 2.0\nelements = 1\nsection = \"bar\"\n\
        [joint.flap]\ntype = \"revolute\"\nparent = \"hub\"\nchild = \"blade\"\naxis = [0.6, 0.8, 0.0]\nparent_offset_m = [0.1, 0.2, 1.5]\n";
    let machine = foldwing::config::parse(text, "hinged.toml").unwrap_or_else(|refused| panic!("{refused}"));
    for k in 0..3 {
        let joint = &machine.bodies.iter().find(|body| body.name == format!("blade{}", k + 1)).expect("a copy").joint;
        let (sine, cosine) = (std::f64::consts::TAU * f64::from(k) / 3.0).sin_cos();
        let offset_m = joint.offset_m;
        let expected = nalgebra::Vector3::new(0.1, 0.2 * cosine - 1.5 * sine, 0.2 * sine + 1.5 * cosine);
        assert!((offset_m - expected).norm() < 1e-14, "{k}: {offset_m} {expected}");
        let foldwing::machine::JointKind::Revolute(hinge) = &joint.kind else { panic!("a hinge") };
        let axis = nalgebra::Vector3::new(0.6, 0.8 * cosine, 0.8 * sine);
        assert!((hinge.axis - axis).norm() < 1e-14, "{k}: {} {axis}", hinge.axis);
    }
}
