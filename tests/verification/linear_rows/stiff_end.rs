//! Outputs that depend on accelerations, of which the largest have almost no effect on them.

use super::Rows;
use super::compare::linear_rows_agree_at;
use foldwing::config;
use foldwing::plant::{Holding, Plant};
use std::sync::Arc;

/// A beam with a mass 5 mm before its end: its last element has accelerations of 3e12 1/m·s² per unit of curvature.
const BEAM: &str = r#"
name = "StiffEnd"
gravity_m_s2 = [-8.6, -8.1, -6.9]

[section.s]
shape = "explicit"
axial_stiffness_N = 8.3e5
torsional_rigidity_N_m2 = 1.34
flap_stiffness_N_m2 = 1.34
edge_stiffness_N_m2 = 266.0
mass_kg_m = 0.24
second_moments_kg_m = [7.7e-5, 0.0, 3.9e-7]
half_width_m = 0.031
half_height_m = 0.0022

[body.b]
length_m = 0.25
section = "s"
elements = 2

[joint.mount]
type = "clamped"
parent = "root"
child = "b"

[mass.m]
body = "b"
position_m = 0.245
mass_kg = 0.069
"#;

/// LR-12. Derivatives of the root reactions of a beam with respect to the strains of its very stiff end: the derivatives with respect to
/// accelerations used to be differences over accelerations of at most 1 in their units, so that changes of 1e-12 N were lost in the
/// round-off of the reaction.
#[test]
fn lr12_reactions_of_a_stiff_end_keep_their_digits() {
    let machine = config::parse(BEAM, "stiff_end.toml").unwrap_or_else(|error| panic!("{error}"));
    let mut plant = Plant::new(Arc::new(machine));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    match linear_rows_agree_at(&mut plant) {
        Rows::Agree(off) => {
            println!("LR-12: off by at most {off:.1e} of a row's scale");
            // a hundred times the round-off of reactions, relative to their largest terms
            assert!(off < 1e-8, "{off:.1e}");
        }
        Rows::Miss(why) | Rows::Refused(why) => panic!("{why}"),
    }
}
