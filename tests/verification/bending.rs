//! V-20 to V-26: large static deflections against closed forms, elliptic integrals and an independent rod solver.

use crate::reference::{case, numbers};
use crate::rod::Rod;
use crate::static_newton::{Loading, assert_order, cantilever, equilibrium, plain_section};
use foldwing::beam::element::ElementKind::{self, Constant, Linear};
use foldwing::beam::section::{Material, Section};
use foldwing::load::{LoadFrame, Wrench};
use foldwing::multibody::{Model, Workspace};
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};
use std::f64::consts::PI;

/// Axial stiffness that makes the elastica of the reference inextensible to 1e-9 of its length.
const INEXTENSIBLE_N: f64 = 1e10;

fn tip_force(force: Vector3<f64>) -> Vec<Wrench> {
    vec![Wrench { force_n: force, moment_n_m: Vector3::zeros() }]
}

/// Tip position in m and rotation of a body under station loads.
fn tip(
    body: foldwing::multibody::model::BodyDescription,
    loads: Vec<Wrench>,
    steps: usize,
) -> (Vector3<f64>, Matrix3<f64>) {
    let model = Model::new(&[body]);
    let mut work = Workspace::new(&model);
    let start = model.natural_coordinates();
    equilibrium(&model, &mut work, &start, &Loading::stations(loads), steps);
    let node = &work.nodes[model.nodes.len() - 1];
    (node.position, node.rotation)
}

/// V-20. A pure end moment `2π EI/L` rolls the beam into a full circle (Euler, exact): the state has constant strain, so the tolerance is
/// round-off for every mesh, for a dead or follower moment, either element, about `y` and `z`.
#[test]
fn v20_end_moment_rolls_a_full_circle() {
    const LENGTH_M: f64 = 2.5;
    for (kind, meshes) in [(Constant, [1, 2, 7, 16]), (Linear, [1, 2, 3, 8])] {
        for elements in meshes {
            for (axis, ei) in [(Vector3::y(), 1.5), (Vector3::z(), 4.0)] {
                for frame in [LoadFrame::Root, LoadFrame::Section] {
                    let section = plain_section([1e4, 2.0, 1.5, 4.0]);
                    let body = cantilever(LENGTH_M, section, kind, elements, frame);
                    let moment_n_m = axis * (2.0 * PI * ei / LENGTH_M);
                    let (position, rotation) = tip(body, vec![Wrench { force_n: Vector3::zeros(), moment_n_m }], 4);
                    let gap_m = position.norm();
                    let turn_rad = (rotation - Matrix3::identity()).norm();
                    assert!(
                        gap_m < 1e-12 * LENGTH_M,
                        "{kind:?} {elements}, {frame:?}: tip misses root by {gap_m:.1e} m"
                    );
                    assert!(turn_rad < 1e-11, "{kind:?} {elements}, {frame:?}: tip turned by {turn_rad:.1e} rad");
                }
            }
        }
    }
}

/// Errors of deflection and shortening, divided by L, of the elastica under one load, for each mesh.
fn elastica(kind: ElementKind, meshes: &[usize], frame: LoadFrame, load: f64, expected: [f64; 2]) -> Vec<f64> {
    let solve = |&elements: &usize| {
        let section = plain_section([INEXTENSIBLE_N, 1.0, 1.0, 1.0]);
        let body = cantilever(1.0, section, kind, elements, frame);
        let (position, _) = tip(body, tip_force(Vector3::z() * load), 10);
        (position.z - expected[0]).abs().max((1.0 - position.x - expected[1]).abs())
    };
    meshes.iter().map(solve).collect()
}

/// V-21. Elastica, dead transverse tip force `PL²/EI` of 1 to 10 (elliptic integrals, 1e-9): 16 constant elements are within 1e-3 L and
/// converge with order 2 (piecewise constant curvature), 8 pairs are within 5e-6 L and converge with order 4.
#[test]
fn v21_elastica_dead() {
    for row in case("static.elastica_dead")["expected"]["rows"].as_array().expect("rows") {
        let row = numbers(row);
        let expected = [row[1], row[2]];
        let constant = elastica(Constant, &[8, 16, 32], LoadFrame::Root, row[0], expected);
        assert_order(&format!("V-21 constant, load {}", row[0]), &constant, 1.9, 2.1);
        assert!(constant[1] < 1e-3, "load {}: 16 constant elements off by {:.2e} L", row[0], constant[1]);
        let pairs = elastica(Linear, &[4, 8, 16], LoadFrame::Root, row[0], expected);
        assert_order(&format!("V-21 pairs, load {}", row[0]), &pairs[..], 3.5, 4.5);
        assert!(pairs[1] < 5e-6, "load {}: 8 pairs off by {:.2e} L", row[0], pairs[1]);
    }
}

/// V-22. The elastica with a follower force (shooting, 1e-7): 16 constant elements are within 3e-3 L, order 2; pairs have order 4 down to
/// the accuracy of the reference, hence meshes of 2, 4 and 8 at the largest load.
#[test]
fn v22_elastica_follower() {
    for row in case("static.elastica_follower")["expected"]["rows"].as_array().expect("rows") {
        let row = numbers(row);
        let rod = Rod {
            length_m: 1.0,
            stiffness: Matrix4::from_diagonal(&Vector4::new(INEXTENSIBLE_N, 1.0, 1.0, 1.0)),
            natural_strain: Vector4::zeros(),
            tip: [Vector3::z() * row[0], Vector3::zeros()],
            spread: |_| [Vector3::zeros(); 2],
        };
        let (_, position, _) = rod.solve(1);
        let exact = [position.z, 1.0 - position.x];
        let gap = (exact[0] - row[2]).abs().max((exact[1] - row[1]).abs());
        assert!(gap < 1e-6, "load {}: rod solver and reference table differ by {gap:.1e} L", row[0]);

        let constant = elastica(Constant, &[8, 16, 32], LoadFrame::Section, row[0], exact);
        assert_order(&format!("V-22 constant, load {}", row[0]), &constant, 1.9, 2.1);
        assert!(constant[1] < 3e-3, "load {}: 16 constant elements off by {:.2e} L", row[0], constant[1]);
        let pairs = elastica(Linear, &[4, 8, 16], LoadFrame::Section, row[0], exact);
        assert_order(&format!("V-22 pairs, load {}", row[0]), &pairs, 3.5, 4.5);
        assert!(pairs[1] < 1e-4, "load {}: 8 pairs off by {:.2e} L", row[0], pairs[1]);
    }
}

/// V-23. The 45° bend of Bathe and Bolourchi under 600 lb with Saint-Venant's `GJ = 0.140577 G a⁴` (shooting, 1e-5 in): natural curvature
/// `1/R` about `z`. Pairs: order 4, and 3e-6 L with 16; constant elements: order 2.
#[test]
fn v23_bend_of_45_degrees() {
    const RADIUS_IN: f64 = 100.0;
    let expected = &case("static.bathe45")["expected"]["cases"]["Kirchhoff_extensible_GJ=G*0.140577"]["600"];
    let expected = Vector3::from_row_slice(&numbers(expected));
    let length_in = RADIUS_IN * PI / 4.0;
    let error = |kind, elements| {
        let material = Material { youngs_modulus_pa: 1e7, shear_modulus_pa: 5e6, density_kg_m3: 1.0 };
        let section = Section::rectangle(1.0, 1.0, &material, None);
        let mut body = cantilever(length_in, section, kind, elements, LoadFrame::Root);
        body.natural_strain = [0.0, 0.0, 0.0, 1.0 / RADIUS_IN].into();
        (tip(body, tip_force(Vector3::z() * 600.0), 8).0 - expected).norm() / length_in
    };
    let constant: Vec<f64> = [4, 8, 16].iter().map(|&n| error(Constant, n)).collect();
    assert_order("V-23 constant", &constant, 1.9, 2.15);
    let pairs: Vec<f64> = [2, 4, 8].iter().map(|&n| error(Linear, n)).collect();
    assert_order("V-23 pairs", &pairs, 3.8, 4.6);
    assert!(pairs[2] < 3e-5, "8 pairs: tip off by {:.1e} L", pairs[2]);
    let fine = error(Linear, 16);
    assert!(fine < 3e-6, "16 pairs: tip off by {fine:.1e} L");
}

/// Abscissae of the two Gauss points of `[0, 1]`.
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

fn spread(s: f64) -> [Vector3<f64>; 2] {
    [Vector3::new(0.3, 0.8 - 0.5 * s, 2.5 + 1.5 * s * s), Vector3::new(0.7 * s, -0.2, 0.1)]
}

/// Tip position and rotation errors of a pretwisted, curved, coupled rod under follower loads.
fn coupled_rod(kind: ElementKind, elements: usize, distributed: bool) -> [f64; 2] {
    let mut stiffness = Matrix4::from_diagonal(&Vector4::new(40.0, 1.2, 1.0, 2.5));
    for (i, j, value) in [(1, 2, 0.25), (1, 3, -0.2), (0, 2, 0.8), (2, 3, 0.15)] {
        stiffness[(i, j)] = value;
        stiffness[(j, i)] = value;
    }
    let mut rod = Rod {
        length_m: 1.0,
        stiffness,
        natural_strain: Vector4::new(0.0, 0.8, -0.5, 0.6),
        tip: [Vector3::new(0.5, -0.7, 1.6), Vector3::new(0.4, 0.3, -0.5)],
        spread: |_| [Vector3::zeros(); 2],
    };
    let section = Section { stiffness, ..plain_section([1.0; 4]) };
    let mut body = cantilever(1.0, section, kind, elements, LoadFrame::Section);
    body.natural_strain = rod.natural_strain.into();
    let mut loads = vec![Wrench { force_n: rod.tip[0], moment_n_m: rod.tip[1] }];
    if distributed {
        rod.spread = spread;
        rod.tip = [Vector3::zeros(); 2];
        body.stations_m.clear();
        loads.clear();
        let h = 1.0 / elements as f64;
        for i in 0..elements {
            for point in GAUSS {
                let s = h * (i as f64 + point);
                body.stations_m.push(s);
                let [force, moment] = spread(s);
                loads.push(Wrench { force_n: force * (0.5 * h), moment_n_m: moment * (0.5 * h) });
            }
        }
    }
    let (_, exact_position, exact_rotation) = rod.solve(1);
    let (position, rotation) = tip(body, loads, 6);
    // chordal distance of the two rotations: no loss of digits at small angles
    [(position - exact_position).norm(), (rotation - exact_rotation).norm() / 2.0f64.sqrt()]
}

/// V-24. Pretwisted, naturally curved rod with full coupling under a follower force and moment at the tip, against the independent rod
/// solver: position and rotation converge with order 4 for pairs and with order 2 for constant elements.
#[test]
fn v24_coupled_curved_rod() {
    for (kind, meshes, least, most, finest) in
        [(Constant, [8, 16, 32], 1.9, 2.1, 2e-3), (Linear, [4, 8, 16], 3.7, 4.4, 5e-6)]
    {
        let errors = meshes.map(|elements| coupled_rod(kind, elements, false));
        assert_order(&format!("V-24 {kind:?} position"), &errors.map(|e| e[0]), least, most);
        assert_order(&format!("V-24 {kind:?} rotation"), &errors.map(|e| e[1]), least, most);
        assert!(errors[2][0] < finest, "{kind:?}: tip off by {:.1e} L", errors[2][0]);
    }
}

/// V-25. The rod of V-24 under distributed follower forces and moments that vary along its length, lumped at two Gauss stations per
/// element: pairs keep order 4 (station rule, eq. K10), constant elements have order 2.
#[test]
fn v25_distributed_follower_loads() {
    for (kind, meshes, least, most, finest) in
        [(Constant, [8, 16, 32], 1.9, 2.1, 2e-3), (Linear, [4, 8, 16], 3.6, 4.5, 5e-6)]
    {
        let errors = meshes.map(|elements| coupled_rod(kind, elements, true));
        assert_order(&format!("V-25 {kind:?} position"), &errors.map(|e| e[0]), least, most);
        assert_order(&format!("V-25 {kind:?} rotation"), &errors.map(|e| e[1]), least, most);
        assert!(errors[2][0] < finest, "{kind:?}: tip off by {:.1e} L", errors[2][0]);
    }
}

/// V-26. \[M\] set 1, a 90 m beam of 8 m × 2 m under a flapwise dead tip force, extensible and shear-free (shooting, 1e-8): at 10 and 50 MN
/// tip deflection and shortening of 12 pairs are within 1e-7 L, order 4.
#[test]
fn v26_extensible_cantilever_of_seed_001() {
    const LENGTH_M: f64 = 90.0;
    let reference = case("static.seed001_set1");
    for row in reference["expected"].as_array().expect("rows") {
        let value = |key: &str| row[key].as_f64().expect("a number");
        let errors = [3, 6, 12].map(|pairs| {
            let material = Material { youngs_modulus_pa: 70e9, shear_modulus_pa: 28e9, density_kg_m3: 1.0 };
            let section = Section::rectangle(8.0, 2.0, &material, None);
            let body = cantilever(LENGTH_M, section, Linear, pairs, LoadFrame::Root);
            let (position, _) = tip(body, tip_force(Vector3::z() * (1e3 * value("F_kN"))), 4);
            let gaps_m = [position.z - value("kirch_ext_w"), position.x - LENGTH_M - value("kirch_ext_u")];
            gaps_m[0].abs().max(gaps_m[1].abs()) / LENGTH_M
        });
        assert_order(&format!("V-26 {} kN", row["F_kN"]), &errors, 3.5, 4.5);
        assert!(errors[2] < 1e-7, "{} kN: 12 pairs off by {:.1e} L", row["F_kN"], errors[2]);
    }
}
