//! Repeats one part of the work on a hinged beam of 32 pairs, for `tools/shear_cost.py`, which counts the instructions of a call.
//!
//! `shear_cost BEAM WORK CALLS`: `plain`, `sheared` or `coupled`; `residual`, `factorisation` or `solution`. `coupled` has shear and a full
//! stiffness matrix. Prints a sum of the results.

use foldwing_engine::beam::element::ElementKind;
use foldwing_engine::beam::section::{Material, Section, Solid};
use foldwing_engine::load::{LoadFrame, RootMotion};
use foldwing_engine::math::strain::SHEARED;
use foldwing_engine::multibody::dynamics::{Damping, Environment, residual};
use foldwing_engine::multibody::factor::{FreedomTangent, Weights, factorize, solve};
use foldwing_engine::multibody::joint::JointKind;
use foldwing_engine::multibody::kinematics::Motion;
use foldwing_engine::multibody::model::{Attachment, BodyDescription};
use foldwing_engine::multibody::{Model, Workspace};
use nalgebra::{Matrix3, Vector3};

/// Pairs of each of the two bodies.
const PAIRS: usize = 16;

fn section(beam: &str) -> Option<Section> {
    let material = Material { youngs_modulus_pa: 2.83e9, shear_modulus_pa: 1.0e9, density_kg_m3: 1425.0 };
    let solid = Solid::rectangle(0.05, 0.02, material);
    match beam {
        "plain" => Some(solid.section()),
        "sheared" => Some(solid.with_shear().section()),
        "coupled" => {
            let mut section = solid.with_shear().section();
            if let Some(shear) = &mut section.shear {
                let own = *shear;
                for i in 0..SHEARED {
                    for j in 0..i {
                        let coupling = 0.1 * (own[(i, i)] * own[(j, j)]).sqrt();
                        (shear[(i, j)], shear[(j, i)]) = (coupling, coupling);
                    }
                }
            }
            Some(section)
        }
        _ => None,
    }
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let asked = match &words[..] {
        [beam, work, calls] => section(beam).zip(calls.parse::<usize>().ok()).map(|asked| (asked, work.as_str())),
        _ => None,
    };
    let Some(((section, calls), part)) = asked else {
        eprintln!("shear_cost plain|sheared|coupled residual|factorisation|solution CALLS");
        std::process::exit(2);
    };
    let body = |parent, joint| BodyDescription {
        length_m: 0.15,
        section: section.clone().into(),
        kind: ElementKind::Linear,
        elements: PAIRS,
        natural_strain: [0.0; 4].into(),
        offset_m: Vector3::zeros(),
        parent,
        mount: Matrix3::identity(),
        joint,
        masses: Vec::new(),
        stations_m: Vec::new(),
        load_frame: LoadFrame::Root,
    };
    let model = Model::new(&[
        body(Attachment::Root(Vector3::zeros()), JointKind::Clamped),
        body(Attachment::Body { index: 0, position_m: 0.15 }, JointKind::Revolute { axis: Vector3::y() }),
    ]);
    let wave = |scale: f64| -> Vec<f64> { (0..model.coordinates).map(|i| scale * (1.7 * i as f64).sin()).collect() };
    let (q, v, a) = (wave(0.05), wave(3.0), wave(100.0));
    let damping = [Damping { mass_1_s: 2.5, stiffness_s: 1e-4, strain_inertia_s2: 0.0 }; 2];
    let tangents = [FreedomTangent { free: true, stiffness: 0.026, damping: 8e-4 }; 2];
    let mut work = Workspace::new(&model);
    let mut out = vec![0.0; model.coordinates];
    let (mut sum, mut bad) = (0.0, false);
    // every part once, so that each has its input
    let repeated = |name: &str| if part == name { calls } else { 1 };
    for _ in 0..repeated("residual") {
        let environment = Environment { root: &RootMotion::default(), damping: &damping, stations: &[] };
        residual(&model, &mut work, Motion { q: &q, v: &v, a: &a }, environment, &mut out);
        sum += out.iter().sum::<f64>();
    }
    for _ in 0..repeated("factorisation") {
        let weights = Weights { mass: 1.0, damping: 1e-4, stiffness: 1e-8 };
        bad |= factorize(&model, &mut work, weights, &damping, &tangents).is_err();
    }
    for _ in 0..repeated("solution") {
        out.fill(1.0);
        sum += solve(&model, &mut work, &mut out);
    }
    println!("{sum:e}{}", if bad { ", no factors" } else { "" });
    for value in &out {
        println!("{value:e}");
    }
}
