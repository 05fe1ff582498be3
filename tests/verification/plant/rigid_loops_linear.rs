//! Linear models, modes, and equilibria in air of machines with rigid loops: against closed forms, differences of the machine, and the limit of
//! penalties.

use crate::linear_rows::compare::{Rows, linear_rows_agree_at};
use crate::plant::loops::START_RAD;
use crate::plant::machines::*;
use crate::plant::rigid_loops::{crank_energy, rigid_bars};
use crate::plant::sliding::slender;
use foldwing::beam::profile::Profile as Along;
use foldwing::machine::builder::AirBuilder;
use foldwing::machine::*;
use foldwing::plant::{Holding, Plant};
use nalgebra::{Complex, Rotation3, Vector3};
use std::sync::Arc;

/// A machine at its equilibrium.
fn resting(machine: Machine) -> Plant {
    let mut plant = Plant::new(Arc::new(machine));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    plant
}

fn eigenvalues_1_s(plant: &mut Plant, count: usize) -> Vec<Complex<f64>> {
    let modes = plant.study().modes(count).unwrap_or_else(|error| panic!("{error}"));
    modes.into_iter().map(|mode| mode.eigenvalue_1_s).collect()
}

/// Largest difference of eigenvalues, relative to their size.
fn apart(one: &[Complex<f64>], other: &[Complex<f64>]) -> f64 {
    assert_eq!(one.len(), other.len());
    one.iter().zip(other).map(|(a, b)| (a - b).norm() / b.norm()).fold(0.0, f64::max)
}

/// Spring on the crank of the four-bar linkage, N·m/rad.
const SPRING: f64 = 60.0;

/// The four-bar linkage of rigid bars with a spring on its crank that is unloaded at the start angle.
fn sprung_bars(turn: Rotation3<f64>) -> Machine {
    let mut machine = rigid_bars(JointMotion::Free, solver(Method::Esdirk4, 1e-8), turn);
    hinge_of(&mut machine, 0).spring =
        Some(Spring { stiffness_n_m_rad: SPRING, damping_n_m_s_rad: 0.0, rest_angle_rad: -START_RAD });
    machine
}

/// LP-43. The four-bar linkage of rigid bars with a sprung crank: its one mode about the equilibrium has the frequency
/// `√((k + V'')/I)` of its equation in the crank angle alone, in any plane.
#[test]
fn lp43_mode_of_a_four_bar_linkage() {
    let h = 2e-3;
    let slope = |angle: f64| {
        let at = |k: f64| crank_energy(angle + k * h)[1];
        (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h)
    };
    let bend = |angle: f64| {
        (8.0 * (slope(angle + h) - slope(angle - h)) - (slope(angle + 2.0 * h) - slope(angle - 2.0 * h))) / (12.0 * h)
    };
    let mut angle = START_RAD;
    for _ in 0..30 {
        angle -= (SPRING * (angle - START_RAD) + slope(angle)) / (SPRING + bend(angle));
    }
    let due_1_s = ((SPRING + bend(angle)) / crank_energy(angle)[0]).sqrt();
    for turn in [Rotation3::identity(), Rotation3::from_scaled_axis(Vector3::new(0.5, 1.3, -0.4))] {
        let mut plant = resting(sprung_bars(turn));
        let at_rad = -plant.outputs().joints()[0].angle_rad;
        let modes = eigenvalues_1_s(&mut plant, 5);
        let names: Vec<String> = plant.freedoms().into_iter().map(|freedom| freedom.name).collect();
        println!("LP-43 crank {:.1e} rad, {:.6} for {due_1_s:.6} 1/s, {names:?}", at_rad - angle, modes[0].norm());
        assert!((at_rad - angle).abs() < 1e-9 && (angle - START_RAD).abs() > 0.05 && modes.len() == 1);
        assert!((modes[0].im.abs() / due_1_s - 1.0).abs() < 1e-8 && modes[0].re.abs() < 1e-6, "{modes:?}");
        assert_eq!(names, ["mount.angle"], "the crank is independent");
    }
}

/// Distance from the hinge to the head of the strut along the wing, and of its foot below the hinge, m.
const HEAD_M: f64 = 0.8;
const FOOT_M: f64 = 0.5;

/// A wing on a hinge that a strut from the root braces, beside a second, redundant loop; air, and a penalty in place of rigid loops.
fn braced(air: Option<&AirBuilder>, penalty_n_m: Option<f64>) -> Machine {
    let mut section = slender(5e5, 60.0, 1e-3);
    section.mass_kg_m = 0.8;
    let wing = body("wing", 1.6, &section, ElementKind::Linear, 4).stiffness_damping_s(2e-3);
    // the strut descends from the wing to the foot
    let length_m = HEAD_M.hypot(FOOT_M);
    let strut = body("strut", length_m, &slender(2e5, 30.0, 1e-4), ElementKind::Linear, 1).stiffness_damping_s(2e-3);
    let angle_rad = std::f64::consts::PI - FOOT_M.atan2(HEAD_M);
    let head = Joint::revolute("head", [0.0, 1.0, 0.0]).on_at("wing", HEAD_M).start_angle_rad(angle_rad);
    let foot = |name: &str, y_m: f64| {
        let places = [[0.0, y_m, 0.0], [0.0, y_m, -FOOT_M]];
        match penalty_n_m {
            None => Closure::rigid(name, ["strut", "root"]).offsets_m(places),
            Some(stiffness) => Closure::between(name, ["strut", "root"], stiffness).offsets_m(places),
        }
    };
    let mut machine = Machine::builder("braced")
        .gravity_m_s2([0.0, 0.0, -9.81])
        .body(wing, Joint::revolute("root_hinge", [0.0, 1.0, 0.0]))
        .body(strut, head)
        .closure(foot("front", 0.02))
        .closure(foot("back", -0.02))
        .solver(solver(Method::Esdirk4, 1e-8))
        .step_s(0.01);
    if let Some(air) = air {
        machine = machine
            .air(air.clone().wind_m_s([0.5, -14.0, 0.8]))
            .surface(LiftingSurface::on("wing", 4).chord_m(Along::constant(0.25)).chord_panels(2));
    }
    machine.build().unwrap_or_else(|refused| panic!("{refused}"))
}

fn strips() -> AirBuilder {
    Air::strips()
        .density_kg_m3(1.2)
        .step_s(0.01)
        .coupling(Coupling::Iterated { tolerance: 1e-10, most_iterations: 100 })
}

fn lattice() -> AirBuilder {
    Air::lattice()
        .density_kg_m3(1.2)
        .step_s(0.01)
        .wake_rows(20)
        .coupling(Coupling::Iterated { tolerance: 1e-10, most_iterations: 100 })
}

/// LP-44. Every row of linear models about equilibria, with the forces of the loops among the outputs: sprung linkage of rigid bars, elastic
/// linkage whose pin is two loops with redundant rows, strut-braced wing without and with the air of strips.
#[test]
fn lp44_rows_of_linear_models() {
    let cases = [
        ("bars", sprung_bars(Rotation3::identity())),
        ("bars in another plane", sprung_bars(Rotation3::from_scaled_axis(Vector3::new(0.5, 1.3, -0.4)))),
        ("braced wing", braced(None, None)),
        ("braced wing in strips", braced(Some(&strips().apparent_mass(false)), None)),
    ];
    for (what, machine) in cases {
        let mut plant = resting(machine);
        match linear_rows_agree_at(&mut plant) {
            Rows::Agree(off) => println!("LP-44 {what}: off by {off:.1e} of a row's scale"),
            Rows::Miss(why) | Rows::Refused(why) => panic!("{what}: {why}"),
        }
    }
}

/// LP-45. Modes of a strut-braced wing with rigid loops are the limit of those with penalties: the difference falls with the stiffness, and the
/// extrapolation agrees; without air and in strips, and the discrete-time modes of a lattice.
#[test]
fn lp45_modes_are_the_limit_of_penalties() {
    let (by_strips, by_lattice) = (strips(), lattice());
    for (air, what) in [(None, "no air"), (Some(&by_strips), "strips"), (Some(&by_lattice), "lattice")] {
        let modes = |penalty: Option<f64>| {
            let mut plant = resting(braced(air, penalty));
            match what {
                "lattice" => {
                    let (modes, _) = plant.study().lattice_modes_and_rest(4).unwrap_or_else(|error| panic!("{error}"));
                    modes.into_iter().map(|mode| mode.eigenvalue_1_s).collect()
                }
                _ => eigenvalues_1_s(&mut plant, 5),
            }
        };
        let mut plant = resting(braced(air, None));
        for mode in plant.study().bare_modes(4).unwrap_or_else(|error| panic!("{error}")) {
            // between both loops the end of the strut does not move, in the mode and in its sections
            let change: Vec<f64> = mode.coordinates.iter().map(|x| x.re).collect();
            let sections = plant.section_changes(&change, &[vec![1.6], vec![HEAD_M.hypot(FOOT_M)]]);
            let [tip, foot] = [0, 1].map(|body| sections[body][0].displacement_m.norm());
            let node = mode.real[1].last().expect("a node").displacement_m.norm();
            assert!(foot < 1e-12 && node < 1e-12 && tip > 1e-3, "{foot:e} {node:e} {tip:e}");
        }
        let rigid = modes(None);
        // stiffer penalties leave the eigenvalues of strips without digits
        let (penalties, limit) = if air.is_none() { ([1e8, 1e9], 1e-7) } else { ([1e7, 1e8], 5e-6) };
        let [soft, stiff] = penalties.map(|stiffness| modes(Some(stiffness)));
        let extrapolated: Vec<Complex<f64>> = stiff.iter().zip(&soft).map(|(b, a)| (b * 10.0 - a) / 9.0).collect();
        let off = [&soft, &stiff, &extrapolated].map(|other| apart(other, &rigid));
        println!("LP-45 {what}: {rigid:.3?}; apart {off:?}");
        assert!(off[1] < 0.12 * off[0] && off[2] < limit, "{what}: {off:?}");
    }
}

/// LP-46. The equilibrium of a strut-braced wing in the wind with rigid loops, by strips and by a lattice: no gap, the limit of penalties, judged
/// stable, and the machine stays there for 0.3 s; a start in equilibrium does too.
#[test]
fn lp46_equilibrium_in_air() {
    for (air, what) in [(strips(), "strips"), (lattice(), "lattice")] {
        let mut plant = resting(braced(Some(&air), None));
        let rest = plant.outputs().clone();
        let stability = plant.study().stability().unwrap_or_else(|error| panic!("{what}: {error}"));
        assert!(stability.not_judged.is_none() && stability.is_stable(), "{what}: {stability:?}");
        let gap_m = rest.loops().iter().map(|own| own.gap_m.norm()).fold(0.0, f64::max);
        let tip_m = rest.tips()[0].position_m;
        let off = [1e8, 1e9]
            .map(|penalty| (resting(braced(Some(&air), Some(penalty))).outputs().tips()[0].position_m - tip_m).norm());
        coast(&mut plant, 0.3);
        let moved_m = (plant.outputs().tips()[0].position_m - tip_m).norm();
        let force_n = (plant.outputs().loops()[0].force_n - rest.loops()[0].force_n).norm();
        println!(
            "LP-46 {what}: tip {:.4} m, gap {gap_m:.1e} m, penalties {off:?} m, moved {moved_m:.1e} m, force {force_n:.1e} N",
            tip_m.z
        );
        assert!(gap_m < 1e-12 && (8.0..12.0).contains(&(off[0] / off[1])), "{what}: {off:?}");
        assert!(moved_m < 1e-8 && force_n < 1e-4 && rest.air_total().force_n.norm() > 5.0, "{what}: {moved_m:e} m");
        let mut machine = braced(Some(&air), None);
        machine.experiment.start = StartState::Equilibrium;
        let begins = start(machine);
        let off_m = (begins.outputs().tips()[0].position_m - tip_m).norm();
        assert!(off_m < 5e-3, "joints are held at their start angles: {off_m:e} m");
    }
}

/// LP-47. Linear models of moving states are refused.
#[test]
fn lp47_refusals() {
    let mut plant = start(sprung_bars(Rotation3::identity()));
    let text = plant.study().modes(1).expect_err("it falls").to_string();
    assert!(text.contains("rigid loops are linearised at rest only"), "{text}");
}

/// LP-48. Equilibria up to near divergence, found by the alternating solution; beyond it there is an error, with a penalty of 1e8 N/m the one with
/// the speed at which the path from still air ends, which is not followed if a rigid loop couples free hinges.
#[test]
fn lp48_equilibria_up_to_divergence() {
    let at = |speed_m_s: f64, penalty: Option<f64>| {
        let mut machine = braced(Some(&strips()), penalty);
        machine.air.as_mut().expect("air").wind_m_s = Vector3::new(0.0, -speed_m_s, 0.3);
        let mut plant = Plant::new(Arc::new(machine));
        let rest = plant.study().equilibrium(0.0, Holding::AsReleased).map(|_| plant.outputs().clone());
        rest.map_err(|error| error.to_string())
    };
    for speed_m_s in [20.0, 28.0, 31.0, 32.5] {
        let [rigid, soft] = [None, Some(1e8)].map(|penalty| at(speed_m_s, penalty));
        let (Ok(rigid), Ok(soft)) = (rigid.clone(), soft.clone()) else {
            panic!("{speed_m_s} m/s: {rigid:?} {soft:?}")
        };
        let off_m = (rigid.tips()[0].position_m - soft.tips()[0].position_m).norm();
        let [force, other] = [&rigid, &soft].map(|outputs| outputs.loops()[0].force_n + outputs.loops()[1].force_n);
        println!(
            "LP-48 {speed_m_s} m/s: tip {:.4} m, off {off_m:.1e} m, force {:.1e}",
            rigid.tips()[0].position_m.z,
            (force - other).norm() / other.norm()
        );
        assert!(off_m < 2e-2 * rigid.tips()[0].position_m.z.abs() && (force - other).norm() < 1e-2 * other.norm());
    }
    for (penalty, cause) in
        [(None, "above the divergence speed"), (Some(1e8), "the equilibrium path from still air ends at")]
    {
        let error = at(40.0, penalty).expect_err("beyond divergence");
        println!("LP-48 {error}");
        assert!(error.contains(cause), "{error}");
    }
}
