//! H-01 to H-04: large deflections against shooting on the rod's equations (1e-9 of the length).

use crate::reference::numbers;
use crate::shear::{beams, matrix};
use crate::statics::machines::{assert_order, at_rest};
use nalgebra::Vector3;
use serde_json::Value;

/// A clamped beam under a dead force at its tip.
fn cantilever(case: &Value, pairs: usize) -> String {
    let length_m = case["length_m"].as_f64().expect("a length");
    format!(
        "name = 'C'\n[section.s]\nshape = 'explicit'\nstiffness_with_shear_SI = {}\nmass_kg_m = 1.0\n\
         second_moments_kg_m = [0.1, 0.0, 0.1]\n\
         [body.beam]\nlength_m = {length_m:?}\nsection = 's'\nshear = true\nelements = {pairs}\n\
         natural_curvature_1_m = {:?}\nload_station_positions_m = [{length_m:?}]\n\
         [joint.mount]\ntype = 'clamped'\nparent = 'root'\nchild = 'beam'\n\
         [load.tip]\nbody = 'beam'\nstation = 1\nforce_N = {:?}\n",
        matrix(&case["stiffness"]),
        numbers(&case["natural_curvature_1_m"]),
        numbers(&case["tip_force_n"]),
    )
}

/// Distance of the tip from that of the file, over the length.
fn tip_error(text: &str, case: &Value) -> f64 {
    let (plant, _) = at_rest(text);
    let tip = plant.shape()[0].last().expect("a tip").position_m;
    let known = Vector3::from_vec(numbers(&case["tip_m"]));
    (tip - known).norm() / case["length_m"].as_f64().expect("a length")
}

/// H-01. Eight rods with shear, straight, curved and twisted, with couplings: eight pairs within 3e-5 of the length, fourth order.
#[test]
fn h01_tips_under_a_dead_force() {
    let beams = beams();
    for (name, case) in beams["statics"].as_object().expect("cases") {
        let errors = [4, 8, 16].map(|pairs| tip_error(&cantilever(case, pairs), case));
        assert_order(&format!("H-01 {name}"), &errors, 3.85, 4.2);
        assert!(errors[1] < 3e-5, "{name}: {:.2e} of the length", errors[1]);
    }
}

/// H-02. Without shear the tip of the composite box is where that of its condensed stiffness is: the section's own matrix without
/// `shear = true`, NOTATION eq. (S9). Tolerance: six digits of the known tip.
#[test]
fn h02_condensed_without_shear() {
    let beams = beams();
    let case = &beams["statics"]["composite_box_tip_force"];
    let text = cantilever(case, 16).replace("shear = true\n", "");
    let (plant, _) = at_rest(&text);
    let tip = plant.shape()[0].last().expect("a tip").position_m;
    assert!((tip - Vector3::new(9.914105, -0.062333, 1.193078)).norm() < 2e-6, "{tip}");
}

/// H-03. No locking: the error of two and of four pairs under a moderate force hardly depends on the slenderness.
#[test]
fn h03_no_locking() {
    let beams = beams();
    let errors = [3.0, 10.0, 100.0, 1000.0].map(|slenderness: f64| {
        let (young, shear) = (1.0e6, 1.0e6 / 2.6);
        let height: f64 = 1.0 / slenderness;
        let (area, second) = (height * height, height.powi(4) / 12.0);
        let shear_n = 5.0 / 6.0 * shear * area;
        let diagonal = [young * area, shear_n, shear_n, shear * 2.0 * second, young * second, young * second];
        let rows: Vec<Vec<f64>> =
            (0..6).map(|i| (0..6).map(|j| if i == j { diagonal[i] } else { 0.0 }).collect()).collect();
        let mut case = beams["statics"]["geradin_cardona"].clone();
        case["length_m"] = 1.0.into();
        case["stiffness"] = rows.into();
        case["tip_force_n"] = vec![0.0, 0.0, 1.5 * young * second].into();
        let tip = |pairs| at_rest(&cantilever(&case, pairs)).0.shape()[0].last().expect("a tip").position_m;
        let exact = tip(32);
        [2, 4].map(|pairs| (tip(pairs) - exact).norm())
    });
    println!("H-03 {errors:?}");
    for (row, known) in
        errors.iter().zip([[6.835e-5, 4.009e-6], [6.513e-5, 3.823e-6], [6.493e-5, 3.813e-6], [6.493e-5, 3.813e-6]])
    {
        for (error, known) in row.iter().zip(known) {
            // three digits of the known errors; the reference here is the mesh of 32 pairs, itself at 1e-9
            assert!((error / known - 1.0).abs() < 3e-3, "{error:.3e} instead of {known:.3e}");
        }
    }
}

/// H-04. The limit of a stiff section in shear is the beam without shear: 1e-6 of the length at a shear stiffness of 1e6 times that of the
/// case. Shear of a tip force displaces it by `F L/GA`, 3e-8 here.
#[test]
fn h04_limit_without_shear() {
    let beams = beams();
    let mut case = beams["statics"]["geradin_cardona"].clone();
    for shear in [1, 2] {
        case["stiffness"][shear][shear] = 3.231e14.into();
    }
    let stiff = cantilever(&case, 8);
    let tip = |text: &str| at_rest(text).0.shape()[0].last().expect("a tip").position_m;
    let gap = (tip(&stiff) - tip(&stiff.replace("shear = true\n", ""))).norm() / 5.0;
    assert!(gap < 1e-6, "{gap:.1e} of the length");
}
