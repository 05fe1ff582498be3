//! Beams with modal damping ratios: closed forms of decays, factors of the Newton matrix, energy balances and gauges.

use crate::plant::machines::*;
use foldwing::beam::section::{Material, Section, Solid};
use foldwing::load::LoadFrame;
use foldwing::load::RootMotion;
use foldwing::machine::builder::BodyBuilder;
use foldwing::machine::*;
use foldwing::multibody::Workspace;
use foldwing::multibody::closure::{ClosureDescription, Penalty};
use foldwing::multibody::dynamics::{Damping, Environment, residual};
use foldwing::multibody::factor::{FreedomTangent, Weights, factorize, solve};
use foldwing::multibody::joint::JointKind;
use foldwing::multibody::kinematics::Motion;
use foldwing::multibody::model::{Attachment, BodyDescription, Model};
use foldwing::plant::{Holding, Plant};
use nalgebra::Vector3;
use std::sync::Arc;

const MATERIAL: Material = Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.2e9, density_kg_m3: 1400.0 };
const LENGTH_M: f64 = 0.8;

fn plate() -> Solid {
    Solid::rectangle(0.03, 0.004, MATERIAL)
}

fn alone(beam: BodyBuilder) -> Machine {
    let tip = AttachedMass::point("tip", LENGTH_M, 0.02);
    let built = Machine::builder("damped")
        .body(beam, clamped())
        .mass("beam", AttachedMass { offset_m: Vector3::new(0.0, 0.01, 0.02), ..tip })
        .solver(solver(Method::Esdirk4, 1e-10))
        .stop_time_s(1.0)
        .step_s(1e-3)
        .build();
    built.unwrap_or_else(|refused| panic!("{refused}"))
}

/// LP-10. In the linear model of a clamped beam, modes have exactly the damping ratios of the list; those with a ratio of 0 and those
/// beyond the list are undamped. All have their undamped natural frequencies: straight, with shear, curved and twisted, with constant
/// elements, and with an eccentric mass. Tolerance 1e-9, round-off of the eigenvalues.
#[test]
fn lp10_modes_have_the_given_ratios() {
    let ratios = [0.01, 0.3, 0.0, 0.02, 1e-4];
    let beams: [(&str, BodyBuilder); 4] = [
        ("straight", Body::beam("beam", LENGTH_M, plate()).elements(4)),
        ("shear", Body::beam("beam", LENGTH_M, plate().with_shear()).elements(4)),
        ("bent", Body::beam("beam", LENGTH_M, plate()).elements(3).natural_curvature_1_m([0.8, -0.5, 1.2])),
        ("constant", Body::beam("beam", LENGTH_M, plate()).element(ElementKind::Constant).elements(6)),
    ];
    for (name, beam) in beams {
        let modes = |beam: BodyBuilder| {
            let mut plant = Plant::new(Arc::new(alone(beam)));
            plant.study().equilibrium(0.0, Holding::AsReleased).expect("an equilibrium");
            plant.study().modes(8).expect("has modes")
        };
        let (free, damped) = (modes(beam.clone()), modes(beam.modal_damping_ratios(ratios)));
        for (i, (mode, undamped)) in damped.iter().zip(&free).enumerate() {
            let expected = ratios.get(i).copied().unwrap_or(0.0);
            let miss = (mode.damping_ratio - expected).abs();
            let drift = (mode.frequency_hz / undamped.frequency_hz - 1.0).abs();
            println!("LP-10 {name} {:.2} Hz: ratio off by {miss:.1e}, frequency {drift:.1e}", mode.frequency_hz);
            assert!(miss < 1e-9 && drift < 1e-9, "{name}, mode {i}: {} for {expected}", mode.damping_ratio);
        }
    }
}

/// LP-11. A cantilever released from a small tip load: the deflection of its end is the sum of the decaying bending modes,
/// `4F/(mLω²)·e^(−ζωt)(cos ω_d t + ζω/ω_d sin ω_d t)`, each with its own ratio, over five periods of the first mode. Tolerance 1e-4 of the
/// deflection, to which the modes beyond the twelfth contribute 2.4e-5 in total.
#[test]
fn lp11_decay_of_a_released_cantilever() {
    let ratios = [0.03, 0.05, 0.02, 0.04, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05];
    let section = plate().section();
    // soft in flap alone, so that flap modes are the lowest
    let (line_kg_m, flap_n_m2) = (section.mass_kg_m, section.stiffness[(2, 2)]);
    let mut betas = vec![1.875_104_069, 4.694_091_133, 7.854_757_438, 10.995_540_735, 14.137_168_391];
    betas.extend((6..=12).map(|mode| (f64::from(mode) - 0.5) * std::f64::consts::PI));
    let omega = |beta: f64| (beta / LENGTH_M).powi(2) * (flap_n_m2 / line_kg_m).sqrt();
    let mut stiff = section.clone();
    for strain in [1, 3] {
        stiff.stiffness[(strain, strain)] *= 1e4;
    }
    stiff.second_moment_kg_m = section.second_moment_kg_m.map(|moment| 0.05 * moment);
    let built = Machine::builder("released")
        .body(
            Body::beam("beam", LENGTH_M, stiff)
                .elements(12)
                .load_station_positions_m([LENGTH_M])
                .modal_damping_ratios(ratios),
            clamped(),
        )
        .solver(Solver { fixed_step_s: Some(2e-4), ..solver(Method::Esdirk4, 1e-12) })
        .start(StartState::Equilibrium)
        .stop_time_s(1.0)
        .step_s(1e-3)
        .build();
    let mut plant = Plant::new(Arc::new(built.unwrap_or_else(|refused| panic!("{refused}"))));
    let load_n = 1e-5;
    plant.inputs_mut().stations_mut()[0].force_n.z = load_n;
    plant.initialize(0.0).expect("a start");
    let static_m = load_n * LENGTH_M.powi(3) / (3.0 * flap_n_m2);
    assert!((plant.outputs().tips()[0].position_m.z / static_m - 1.0).abs() < 1e-6);
    plant.inputs_mut().stations_mut()[0].force_n.z = 0.0;
    let period_s = std::f64::consts::TAU / omega(betas[0]);
    let mut worst = 0.0f64;
    for step in 1..=100 {
        let t = 5.0 * period_s * f64::from(step) / 100.0;
        plant.step(t).expect("a step");
        let mode = |(i, beta): (usize, &f64)| {
            let (w, ratio) = (omega(*beta), ratios.get(i).copied().unwrap_or(0.0));
            let ring = w * (1.0 - ratio * ratio).sqrt();
            let share = (ring * t).cos() + ratio * w / ring * (ring * t).sin();
            4.0 * load_n / (line_kg_m * LENGTH_M * w * w) * (-ratio * w * t).exp() * share
        };
        let expected_m: f64 = betas.iter().enumerate().map(mode).sum();
        worst = worst.max((plant.outputs().tips()[0].position_m.z - expected_m).abs() / static_m);
    }
    println!("LP-11 decay: {worst:.1e} of the deflection");
    assert!(worst < 1e-4, "{worst:.1e}");
}

/// LP-12. The factors contain the damping of modes and of loops together: their solution inverts the derivative of the residual with
/// respect to rates and accelerations, for two bodies of either element type and one with shear, with a loop between them and one on the
/// root. Tolerance 1e-8: the elastic forces of the strained bodies, a million times those of the damping, cancel in the derivative except
/// for their round-off.
#[test]
fn lp12_factors_contain_the_damping_of_modes() {
    let describe = |index: usize, solid: Solid, kind: ElementKind| BodyDescription {
        length_m: 0.5,
        section: solid.into(),
        kind,
        elements: 2,
        natural_strain: [0.0, 0.3, -0.2, 0.5].into(),
        parent: match index {
            0 => Attachment::Root(Vector3::zeros()),
            _ => Attachment::Body { index: index - 1, position_m: 0.4 },
        },
        offset_m: Vector3::zeros(),
        mount: nalgebra::Rotation3::new(Vector3::new(0.2, 0.7, -0.3) * index as f64).into_inner(),
        joint: JointKind::Revolute { axis: Vector3::y() },
        masses: Vec::new(),
        stations_m: Vec::new(),
        load_frame: LoadFrame::Root,
    };
    let bodies = [
        describe(0, plate(), ElementKind::Linear),
        describe(1, plate().with_shear(), ElementKind::Linear),
        describe(2, plate(), ElementKind::Constant),
    ];
    let penalty = Penalty { inertia_kg: 0.2, damping_n_s_m: 3.0, stiffness_n_m: 100.0 };
    let offsets_m = [Vector3::new(0.1, 0.0, 0.2), Vector3::new(-0.1, 0.3, 0.0)];
    let loops = [[Some((0, 0.5)), Some((2, 0.5))], [Some((1, 0.5)), None]];
    let loops = loops.map(|places| ClosureDescription { places, offsets_m, rigid: false, penalty });
    let mut model = Model::with_constraints(&bodies, &loops, &[]);
    for body in 0..3 {
        model.damp_modes(body, &[0.1, 0.4, 0.2]);
    }
    let n = model.coordinates;
    let mut work = Workspace::new(&model);
    let roll = |seed: usize| (0..n).map(|i| (1.7 + i as f64 * 2.3 + seed as f64).sin()).collect::<Vec<f64>>();
    let (q, x) = (roll(1).iter().map(|q| 0.3 * q).collect::<Vec<f64>>(), roll(2));
    let damping = vec![Damping { mass_1_s: 0.4, stiffness_s: 1e-3, strain_inertia_s2: 0.0 }; 3];
    let zero = vec![0.0; n];
    let mut at = |v: &[f64], a: &[f64]| {
        let environment = Environment { root: &RootMotion::default(), damping: &damping, stations: &[] };
        let mut value = zero.clone();
        residual(&model, &mut work, Motion { q: &q, v, a }, environment, &mut value);
        value
    };
    let opposite: Vec<f64> = x.iter().map(|x| -x).collect();
    let (still, pushed) = (at(&zero, &zero), at(&zero, &x));
    let (forth, back) = (at(&x, &zero), at(&opposite, &zero));
    let weights = Weights { mass: 1.0, damping: 0.02, stiffness: 0.0 };
    let mut right: Vec<f64> =
        (0..n).map(|i| pushed[i] - still[i] + weights.damping * 0.5 * (forth[i] - back[i])).collect();
    at(&zero, &zero);
    let tangents = vec![FreedomTangent { free: true, ..FreedomTangent::HELD }; 3];
    factorize(&model, &mut work, weights, &damping, &tangents).expect("a positive matrix");
    solve(&model, &mut work, &mut right);
    let size = x.iter().fold(0.0f64, |size, x| size.max(x.abs()));
    let miss = right.iter().zip(&x).map(|(own, x)| (own - x).abs()).fold(0.0, f64::max) / size;
    println!("LP-12: {miss:.1e}");
    assert!(miss < 1e-8, "{miss:.1e}");
}

/// LP-13. Energy in large motions of a folding wing whose beams have modal damping: the balance closes to the tolerance of the steps, and
/// the damping dissipates. In free flight the momentum is conserved, because the damping is internal to the body.
#[test]
fn lp13_energy_and_momentum_with_damped_modes() {
    let half =
        |name: &str| Body::beam(name, 0.3, plate()).elements(2).load_stations(0).modal_damping_ratios([0.1, 0.2, 0.1]);
    let built = Machine::builder("flying")
        .body(half("inner"), Joint::free("flight").start_angular_velocity_rad_s([0.5, 2.0, 0.2]))
        .body(
            half("outer"),
            Joint::revolute("fold", [0.0, 1.0, 0.1])
                .on("inner")
                .motor(Motor { stiffness_n_m_rad: 0.5, ..Motor::default() })
                .start_angle_rad(1.0),
        )
        .gauge(Gauge::on("root", "outer", 0.1))
        .solver(solver(Method::Esdirk4, 1e-9))
        .stop_time_s(1.0)
        .step_s(1e-3)
        .build();
    let mut plant = start(built.unwrap_or_else(|refused| panic!("{refused}")));
    let begin_j = balance_j(plant.outputs());
    let centre = |plant: &Plant| {
        let tips = plant.outputs().tips();
        tips.iter().map(|tip| tip.velocity_m_s).sum::<Vector3<f64>>()
    };
    assert!(centre(&plant).norm() > 0.0);
    let mut drift_j = 0.0f64;
    for step in 1..=200 {
        plant.step(2e-3 * f64::from(step)).expect("a step");
        drift_j = drift_j.max((balance_j(plant.outputs()) - begin_j).abs());
        // no external force
        assert!(plant.outputs().root().force_n.norm() < 1e-9);
    }
    let lost_j = plant.outputs().energy().dissipated;
    println!("LP-13 drift {drift_j:.1e} J, dissipated {lost_j:.2e} J of {begin_j:.2e} J");
    assert!(lost_j > 1e-4 && drift_j < 1e-5 * lost_j, "drift {drift_j:.1e} J, dissipated {lost_j:.1e} J");
}

/// LP-14. Strains recovered from the wrench at the ends of elements exclude the damping stress: a beam with damping ratios near 1, compared
/// with a mesh of constant elements, which interpolates strains. Tolerance 0.1 of the largest strain, for waves of the modes without
/// ratios, which differ by 0.03 between these meshes without damping as well; if the damping stress were included, the strain at the end
/// would differ by 1.4.
#[test]
fn lp14_gauges_with_damped_modes() {
    let strains = |kind: ElementKind, elements: usize| {
        let built = Machine::builder("decays")
            .body(
                Body::beam("beam", LENGTH_M, plate())
                    .element(kind)
                    .elements(elements)
                    .load_station_positions_m([LENGTH_M])
                    .modal_damping_ratios([0.8; 12]),
                clamped(),
            )
            .gauge(Gauge::on("end", "beam", 0.0).z_m(0.002))
            .gauge(Gauge::on("middle", "beam", 0.4).z_m(0.002))
            .solver(solver(Method::Esdirk4, 1e-8))
            .start(StartState::Equilibrium)
            .stop_time_s(1.0)
            .step_s(1e-3)
            .build();
        let mut plant = Plant::new(Arc::new(built.unwrap_or_else(|refused| panic!("{refused}"))));
        plant.inputs_mut().stations_mut()[0].force_n.z = 0.05;
        plant.initialize(0.0).expect("a start");
        plant.inputs_mut().stations_mut()[0].force_n.z = 0.0;
        (1..=40)
            .map(|step| {
                plant.step(5e-3 * f64::from(step)).expect("a step");
                [0, 1].map(|gauge| plant.outputs().gauges()[gauge])
            })
            .collect::<Vec<[f64; 2]>>()
    };
    let (pairs, fine) = (strains(ElementKind::Linear, 8), strains(ElementKind::Constant, 80));
    for gauge in 0..2 {
        let size = fine.iter().map(|strain| strain[gauge].abs()).fold(0.0, f64::max);
        let miss = pairs.iter().zip(&fine).map(|(a, b)| (a[gauge] - b[gauge]).abs()).fold(0.0, f64::max) / size;
        println!("LP-14 gauge {gauge}: {miss:.1e} of {size:.1e}");
        assert!(miss < 0.1, "gauge {gauge}: {miss:.1e}");
    }
}

/// LP-15. Modes with equal frequencies have no defined order: different ratios for them are rejected with an error that names the modes;
/// equal ratios damp both modes of a round bar.
#[test]
fn lp15_modes_of_one_frequency() {
    let bar = |ratios: &[f64]| {
        let round = Section::ellipse(0.01, 0.01, &MATERIAL, None);
        Machine::builder("round")
            .body(Body::beam("beam", LENGTH_M, round).elements(3).modal_damping_ratios(ratios), clamped())
            .stop_time_s(1.0)
            .step_s(1e-3)
            .build()
    };
    for ratios in [&[0.1][..], &[0.1, 0.2], &[0.1, 0.1, 0.3]] {
        let refused = bar(ratios).expect_err("no order").to_string();
        let says = "body \"beam\", modal_damping_ratios";
        assert!(refused.contains(says) && refused.contains("equal ratios for modes"), "{refused}");
    }
    let mut plant = start(bar(&[0.1, 0.1]).unwrap_or_else(|refused| panic!("{refused}")));
    let modes = plant.study().modes(3).expect("has modes");
    assert!((modes[0].damping_ratio - 0.1).abs() < 1e-9 && (modes[1].damping_ratio - 0.1).abs() < 1e-9);
    assert!(modes[2].damping_ratio.abs() < 1e-9, "{}", modes[2].damping_ratio);
}
