//! Rigid loops that restrain nothing.

use foldwing::config;
use foldwing::plant::{Gradient, Holding, Parameter, Plant, PlantError, RunResult};
use std::sync::Arc;

fn plant(text: &str) -> Plant {
    Plant::new(Arc::new(config::parse(text, "pendulum.toml").unwrap_or_else(|error| panic!("{error}"))))
}

/// A pendulum of two rigid bars; `of_loop` closes a loop between the bars.
fn pendulum(of_loop: &str) -> Plant {
    let mut plant = plant(&pendulum_text(of_loop));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    plant
}

fn pendulum_text(of_loop: &str) -> String {
    format!(
        r#"
name = "Pendulum"
gravity_m_s2 = [0.3, 0.2, -9.8]

[rigid_body.upper]
mass_kg = 1.3
centre_of_mass_m = [0.31, 0.02, -0.01]
inertia_kg_m2 = [0.01, 0.02, 0.03, 0.0, 0.0, 0.0]

[rigid_body.lower]
mass_kg = 0.7
centre_of_mass_m = [0.17, 0.0, 0.03]
inertia_kg_m2 = [0.004, 0.01, 0.012, 0.0, 0.0, 0.0]

[joint.first]
type = "revolute"
parent = "root"
child = "upper"
axis = [0.3, 1.0, 0.2]
motor.stiffness_N_m_rad = 20.0

[joint.second]
type = "revolute"
parent = "upper"
child = "lower"
parent_offset_m = [0.7, 0.1, 0.0]
axis = [0.0, 0.6, 0.8]
motor.stiffness_N_m_rad = 5.0
{of_loop}
[solver]
tolerance = 1e-9

[simulation]
stop_time_s = 1.0
step_s = 1e-2
"#
    )
}

/// Both points on the axis of the second hinge, 0.25 m beside it.
const ON_AXIS: &str =
    "\n[loop.idle]\nbodies = [\"upper\", \"lower\"]\noffsets_m = [[0.7, 0.25, 0.2], [0.0, 0.15, 0.2]]\nrigid = true\n";

/// LP-40. A loop between two points of the axis of a hinge restrains nothing, and all of its rows are redundant: their matrix is round-off.
/// It carries no force and does not change the motion.
#[test]
fn lp40_a_loop_without_a_freedom_carries_nothing() {
    let (mut with, mut without) = (pendulum(ON_AXIS), pendulum(""));
    let (mut apart, mut force_n, mut gap_m) = (0.0f64, 0.0f64, 0.0f64);
    for step in 1..=100 {
        let time_s = 1e-2 * f64::from(step);
        for plant in [&mut with, &mut without] {
            plant.step(time_s).unwrap_or_else(|error| panic!("{error}"));
        }
        for (a, b) in with.outputs().joints().iter().zip(without.outputs().joints()) {
            apart = apart.max((a.angle_rad - b.angle_rad).abs()).max((a.rate_rad_s - b.rate_rad_s).abs());
        }
        let idle = with.outputs().loops()[0];
        (force_n, gap_m) = (force_n.max(idle.force_n.norm()), gap_m.max(idle.gap_m.norm()));
    }
    println!("LP-40 apart {apart:.1e}, force {force_n:.1e} N, gap {gap_m:.1e} m");
    // the steps are those of the same error to the tolerance
    assert!(apart < 1e-7 && force_n < 1e-12 && gap_m < 1e-14, "{apart:.1e} {force_n:.1e} N {gap_m:.1e} m");
}

/// LP-39. A loop that restrains nothing changes no gradient: angles and rates by a stiffness and a centre of mass, forward and adjoint, with
/// and without it, to the tolerance of Newton's iteration and of steps that are not the same.
#[test]
fn lp39_a_loop_without_a_freedom_changes_no_gradient() {
    let gradients = |of_loop: &str| {
        let text = pendulum_text(of_loop).replace("tolerance = 1e-9", "tolerance = 1e-11");
        let mut own = plant(&text);
        own.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let mut tape = own.run_on_tape(&[0.5]).unwrap_or_else(|error| panic!("{error}"));
        own.request(&mut tape, 0.3).unwrap_or_else(|error| panic!("{error}"));
        let parameters = [("20.0", 20.0), ("0.31", 0.31)].map(|(digits, value)| {
            let beside = |value: f64| Ok::<_, String>(plant(&text.replacen(digits, &format!("{value:.15}"), 1)));
            Parameter::new(digits, value, 1e-3 * value, beside).unwrap_or_else(|error| panic!("{error}"))
        });
        let angles = own.outputs().layout().joints.range();
        let results: Vec<RunResult> = (0..2)
            .flat_map(|time| angles.clone().take(2).map(move |index| RunResult::Output { index, time }))
            .collect();
        let mut gradient = Gradient::new(&mut own, &tape, parameters.into()).unwrap_or_else(|error| panic!("{error}"));
        let forward = gradient.forward(&results).unwrap_or_else(|error| panic!("{error}"));
        let adjoint = results.iter().map(|result| gradient.adjoint(*result));
        let adjoint: Vec<Vec<f64>> = adjoint.collect::<Result<_, _>>().unwrap_or_else(|error| panic!("{error}"));
        [forward, adjoint].map(|rows| rows.concat())
    };
    let ([with, adjoint], [without, _]) = (gradients(ON_AXIS), gradients(""));
    let largest = without.iter().fold(0.0f64, |most, slope| most.max(slope.abs()));
    let apart = |a: &[f64]| a.iter().zip(&without).fold(0.0f64, |most, (a, b)| most.max((a - b).abs())) / largest;
    println!("LP-39 with and without the loop {:.1e}, adjoint {:.1e}", apart(&with), apart(&adjoint));
    assert!(largest > 1e-3 && apart(&with) < 1e-8 && apart(&adjoint) < 1e-8, "{with:?} {adjoint:?} {without:?}");
}

/// A beam with a hinge in its middle, and a bar from its root to its outer part, closed by a rigid loop.
fn braced_beam(of_loop: &str) -> String {
    format!(
        r#"
name = "Braced"
gravity_m_s2 = [0.0, 0.4, -9.8]

[section.rod]
shape = "ellipse"
width_m = 0.01
height_m = 0.01
youngs_modulus_Pa = 2e11
poisson_ratio = 0.3
density_kg_m3 = 7800.0

[body.inner]
section = "rod"
length_m = 0.5
elements = 2

[body.outer]
section = "rod"
length_m = 0.5
elements = 2
shear = true

[rigid_body.brace]
mass_kg = 0.3
centre_of_mass_m = [0.3, 0.0, 0.0]
inertia_kg_m2 = [1e-3, 2e-3, 2e-3, 0.0, 0.0, 0.0]

[joint.clamp]
type = "clamped"
parent = "root"
child = "inner"

[joint.knee]
type = "revolute"
parent = "inner"
child = "outer"
axis = [0.0, 1.0, 0.0]

[joint.foot]
type = "ball"
parent = "root"
child = "brace"
root_position_m = [0.0, 0.0, -0.3]

[loop.brace]
bodies = ["brace", "outer"]
offsets_m = [[1.0, 0.0, 0.3], [0.0, 0.0, 0.0]]
rigid = true
{of_loop}
[solver]
tolerance = 1e-8

[simulation]
stop_time_s = 1.0
step_s = 1e-2
"#
    )
}

/// Two points of the axis of the knee.
const ON_KNEE: &str = "\n[loop.idle]\nbodies = [\"inner\", \"outer\"]\npositions_m = [0.5, 0.0]\noffsets_m = [[0.0, 0.1, 0.0], [0.0, 0.1, 0.0]]\nrigid = true\n";

/// LP-41. Static equilibria with an idle loop are those without it, and the loop carries nothing: alone between rigid bars, with and without
/// gravity, and beside a rigid loop that carries a beam. 1e-9 rad and of the weight: the correction after which the search ends is squared.
#[test]
fn lp41_an_idle_loop_does_not_change_an_equilibrium() {
    let weightless = |text: String| text.replace("[0.3, 0.2, -9.8]", "[0.0, 0.0, 0.0]");
    for (with, without) in [
        (pendulum_text(ON_AXIS), pendulum_text("")),
        (weightless(pendulum_text(ON_AXIS)), weightless(pendulum_text(""))),
        (braced_beam(ON_KNEE), braced_beam("")),
    ] {
        let [with, without] = [with, without].map(|text| {
            let mut plant = plant(&text);
            plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
            plant
        });
        let (mut apart, mut moved) = (0.0f64, 0.0f64);
        for (a, b) in with.outputs().tips().iter().zip(without.outputs().tips()) {
            apart = apart.max((a.position_m - b.position_m).norm());
            moved = moved.max(b.position_m.norm());
        }
        let carried = with.outputs().loops().len() - 1;
        let idle = with.outputs().loops()[carried];
        for (a, b) in with.outputs().loops()[..carried].iter().zip(without.outputs().loops()) {
            apart = apart.max((a.force_n - b.force_n).norm());
        }
        println!(
            "LP-41 apart {apart:.1e} of {moved:.1} m, force {:.1e} N, gap {:.1e} m",
            idle.force_n.norm(),
            idle.gap_m.norm()
        );
        assert!(apart < 1e-9 && idle.force_n.norm() < 1e-9 && idle.gap_m.norm() < 1e-12, "{apart:.1e} {idle:?}");
    }
}

/// LP-42. A hinge that nothing holds, with an idle loop on its axis: the refusal names the hinge and the remedy, as without the loop.
#[test]
fn lp42_an_idle_loop_holds_no_hinge() {
    for of_loop in ["", ON_AXIS] {
        let text = pendulum_text(of_loop)
            .replace("[0.3, 0.2, -9.8]", "[0.0, 0.0, 0.0]")
            .replace("motor.stiffness_N_m_rad = 5.0", "");
        let mut plant = plant(&text);
        let error = plant.study().equilibrium(0.0, Holding::AsReleased).expect_err("nothing holds the hinge");
        let PlantError::Equilibrium { cause, .. } = &error else { panic!("{error}") };
        assert!(cause.contains("no stiffness resists a motion of joint \"second\": add a spring"), "{cause}");
    }
}
