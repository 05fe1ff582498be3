//! B-01 to B-09: elements whose section and natural strain vary along them.

use crate::blade::{description, errors, reference, solve};
use crate::statics::{assert_order, order};
use foldwing::beam::element::ElementKind::{Constant, Linear};
use foldwing::beam::law::{NaturalStrain, SectionLaw};
use foldwing::beam::profile::Profile;
use foldwing::beam::section::Section;
use foldwing::multibody::model::BodyDescription;
use nalgebra::{Matrix4, Vector3};

const LENGTH_M: f64 = 1.2;

/// Section with every coupling, by its stiffness.
fn coupled(stiffness: Matrix4<f64>) -> Section {
    Section {
        stiffness,
        mass_kg_m: 1.0,
        first_moment_kg: [0.0; 2],
        second_moment_kg_m: [1e-3, 0.0, 1e-3],
        half_width_m: 0.1,
        half_height_m: 0.05,
    }
}

#[rustfmt::skip]
fn inner_stiffness() -> Matrix4<f64> {
    Matrix4::new(
        90.0, 2.0, -1.5, 3.0,
        2.0, 1.6, 0.4, -0.2,
        -1.5, 0.4, 1.3, 0.3,
        3.0, -0.2, 0.3, 2.8,
    )
}

#[rustfmt::skip]
fn outer_stiffness() -> Matrix4<f64> {
    Matrix4::new(
        40.0, -1.0, 0.5, 1.0,
        -1.0, 0.7, -0.1, 0.1,
        0.5, -0.1, 0.5, 0.05,
        1.0, 0.1, 0.05, 0.9,
    )
}

const TWIST: [f64; 4] = [0.7, -1.1, 0.9, 0.8];
const CURVATURE_Y: [f64; 3] = [-0.4, 0.9, -1.2];
const CURVATURE_Z: [f64; 3] = [0.5, -0.6, 1.1];

/// Stiffness falls linearly to less than half with all couplings, twist and curvatures are polynomials.
fn blade() -> BodyDescription {
    let section = SectionLaw::Between {
        inner: coupled(inner_stiffness()),
        outer: coupled(outer_stiffness()),
        length_m: LENGTH_M,
    };
    let natural = NaturalStrain([
        Profile::constant(0.0),
        Profile::Polynomial(TWIST.to_vec()),
        Profile::Polynomial(CURVATURE_Y.to_vec()),
        Profile::Polynomial(CURVATURE_Z.to_vec()),
    ]);
    description(LENGTH_M, section, natural)
}

fn stiffness(s: f64) -> Matrix4<f64> {
    inner_stiffness() + (outer_stiffness() - inner_stiffness()) * (s / LENGTH_M)
}

fn curvature(s: f64) -> [f64; 3] {
    let power = |c: &[f64]| c.iter().enumerate().map(|(i, c)| c * s.powi(i as i32)).sum();
    [power(&TWIST), power(&CURVATURE_Y), power(&CURVATURE_Z)]
}

/// B-01. Section and natural curvature vary: pairs converge with order 4 in tip, rotation, root moment and, at pair
/// boundaries, in the recovered strain; constant elements with order 2. All couplings, strains of order one.
#[test]
fn b01_order_of_convergence() {
    let force = Vector3::new(0.4, -0.5, 0.9);
    let exact = reference(LENGTH_M, &stiffness, &curvature, &force, 4);
    for (kind, meshes, least, most) in [(Linear, [4, 8, 16], 3.7, 4.4), (Constant, [16, 32, 64], 1.8, 2.2)] {
        let found = meshes.map(|n| errors(LENGTH_M, &solve(&blade(), (kind, n), &force, 4), &exact));
        for (i, what) in ["tip", "rotation", "root moment", "strain"].iter().enumerate() {
            assert_order(&format!("B-01 {kind:?} {what}"), &found.map(|errors| errors[i]), least, most);
        }
    }
}

/// B-02. Without loads the blade takes its natural shape: order 4 for pairs, 2 for constant elements, and no strain.
#[test]
fn b02_natural_shape() {
    let exact = reference(LENGTH_M, &stiffness, &curvature, &Vector3::zeros(), 4);
    for (kind, meshes, least, most) in [(Linear, [4, 8, 16], 3.7, 4.4), (Constant, [16, 32, 64], 1.8, 2.2)] {
        let found = meshes.map(|n| solve(&blade(), (kind, n), &Vector3::zeros(), 4));
        let at = |i: usize| found.each_ref().map(|solution| errors(LENGTH_M, solution, &exact)[i]);
        assert_order(&format!("B-02 {kind:?} tip"), &at(0), least, most);
        assert_order(&format!("B-02 {kind:?} rotation"), &at(1), least, most);
        let strain = found[0].measures.iter().map(|measures| measures.amax()).fold(0.0, f64::max);
        assert!(strain < 1e-12, "{kind:?}: strain {strain:.1e} without loads");
    }
    let _ = order;
}
