//! Tips with a mass below their added mass, and the schemes that couple them; hinges with only aerodynamic stiffness.

use crate::coupling::wings::{folding_wing, start};
use foldwing::config;
use foldwing::plant::{Holding, Plant, PlantError, Search};
use std::fmt::Write;
use std::sync::Arc;

/// The "baseline" wing of Bristol (F. Healy, PhD thesis, 2023, chapter 3): half span 1 m, chord 0.12 m, a free tip flared by 15 degrees
/// with a structural mass of 0.0096 kg/m and an added mass of 0.0139 kg/m. Negligible damping.
fn baseline_wing(air: &str) -> String {
    let mut text = "name = \"Baseline\"\ngravity_m_s2 = [0.0, 0.0, 0.0]\n".to_owned();
    for (section, mass_kg_m, moments) in
        [("spar", 0.96, "[7.2e-5, 0.0, 1.28e-6]"), ("tip", 0.0096, "[1e-9, 0.0, 1e-9]")]
    {
        write!(
            text,
            "[section.{section}]\nshape = \"explicit\"\naxial_stiffness_N = 2.316e7\ntorsional_rigidity_N_m2 = 48.731\n\
             flap_stiffness_N_m2 = 34.431\nedge_stiffness_N_m2 = 1962.8\nmass_kg_m = {mass_kg_m}\n\
             second_moments_kg_m = {moments}\n"
        )
        .expect("a String takes all");
    }
    for (body, section, length_m, elements, strips) in
        [("inner", "spar", 0.805895, 5, 14), ("tip", "tip", 0.194105, 1, 5)]
    {
        write!(
            text,
            "[body.{body}]\nlength_m = {length_m}\nsection = \"{section}\"\nelements = {elements}\n\
             stiffness_damping_s = 1e-6\n\
             [surface.{body}]\nbody = \"{body}\"\nchord_m = 0.12\nelastic_axis_fraction = 0.25\nstrips = {strips}\n"
        )
        .expect("a String takes all");
    }
    for (i, (body, position_m, mass_kg, offset_m, inertia)) in [
        ("inner", 0.07, 0.075, -0.021, [73e-6, 82e-6, 151e-6]),
        ("inner", 0.21, 0.075, -0.021, [73e-6, 82e-6, 151e-6]),
        ("inner", 0.35, 0.075, -0.021, [73e-6, 82e-6, 151e-6]),
        ("inner", 0.49, 0.075, -0.021, [73e-6, 82e-6, 151e-6]),
        ("inner", 0.63, 0.075, -0.021, [73e-6, 82e-6, 151e-6]),
        ("inner", 0.767, 0.056, -0.017, [32e-6, 26e-6, 56e-6]),
        ("tip", 0.081105, 0.167, -0.022, [122e-6, 942e-6, 1057e-6]),
    ]
    .into_iter()
    .enumerate()
    {
        let [x, y, z] = inertia;
        write!(
            text,
            "[mass.point{i}]\nbody = \"{body}\"\nposition_m = {position_m}\nmass_kg = {mass_kg}\n\
             offset_m = [0.0, {offset_m}, 0.0]\ninertia_kg_m2 = [{x:?}, {y:?}, {z:?}, 0.0, 0.0, 0.0]\n"
        )
        .expect("a String takes all");
    }
    text + &format!(
        "[joint.mount]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"inner\"\n\
         [joint.fold]\ntype = \"revolute\"\nparent = \"inner\"\nchild = \"tip\"\n\
         axis = [0.25881904510252074, 0.9659258262890683, 0.0]\nstart_angle_deg = -2.0\n[joint.fold.motor]\n\
         [aerodynamics]\ndensity_kg_m3 = 1.225\nwind_m_s = [0.0, -20.0, 0.0]\n{air}\n\
         [simulation]\nstop_time_s = 2.0\nstep_s = 5e-3\nstart = \"equilibrium\"\n"
    )
}

fn plant(text: &str) -> Plant {
    Plant::new(Arc::new(config::parse(text, "wing.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))))
}

/// Angle of the first fold in degrees at the end of a run in communication steps.
fn angle_deg(plant: &mut Plant, end_s: f64, step_s: f64) -> Result<f64, PlantError> {
    plant.initialize(0.0)?;
    for i in 1..=(end_s / step_s).round() as u32 {
        plant.step(f64::from(i) * step_s)?;
    }
    Ok(plant.outputs().joints()[0].angle_rad.to_degrees())
}

/// A tip lighter than its added mass: the coupling iteration converges in every step, whatever the step. The trial integrations must
/// depend smoothly on the loads: the residual of Newton's iteration, and steps halved in one trial only, once changed the loads by up to
/// 3e-3 from one trial to the next.
#[test]
fn q40_light_tips_agree_with_their_air() {
    for (air, end_s) in [
        ("model = \"strip\"", 1.0),
        ("model = \"strip\"\nstep_s = 3e-3", 0.3),
        ("model = \"strip\"\nstep_s = 7e-4", 0.1),
        // the residual of Newton's iteration matters relative to the square of the step: 1e-8 of the span would be 5e-3 of the loads
        ("model = \"strip\"\nstep_s = 1e-4", 0.02),
    ] {
        let mut wing = plant(&baseline_wing(air));
        let angle = angle_deg(&mut wing, end_s, 5e-3).unwrap_or_else(|error| panic!("{air}: {error}"));
        let statistics = wing.statistics();
        println!("Q-40 {air:?}: {angle:.4} deg at {end_s} s, {statistics:?}");
        assert!(angle.abs() < 10.0, "{angle}");
    }
}

/// A diverging staggered coupling stops with an error before the tip spins: for the shipped flared tip one correction per step is
/// unstable.
#[test]
fn q41_a_staggered_coupling_that_diverges_stops_by_name() {
    let text = include_str!("../../../examples/models/flared_wing_tip.toml");
    let mut light = plant(&text.replace("model = \"strip\"", "model = \"strip\"\ncoupling = \"staggered\""));
    let error = angle_deg(&mut light, 1.0, 5e-3).expect_err("the scheme diverges").to_string();
    println!("Q-41 {error}");
    assert!(
        error.contains("coupling = \"staggered\" diverges") && error.contains("write coupling = \"iterated\""),
        "{error}"
    );
    let turned = light.outputs().joints()[0].angle_rad.to_degrees();
    assert!(turned.abs() < 10.0, "{turned} deg");
}

/// With fixed steps the latch time does not depend on the communication steps: structural steps divide the aerodynamic step, in trial
/// integrations and in the final one.
#[test]
fn q42_fixed_steps_in_air_do_not_depend_on_the_caller() {
    let air = "model = \"strip\"\ndensity_kg_m3 = 1.2\nwind_m_s = [0.0, -10.0, 0.0]\nstep_s = 1.25e-3";
    let times: Vec<f64> = [5e-4, 3e-4, 2e-3, 9e-3]
        .into_iter()
        .map(|step_s| {
            let mut machine = folding_wing(air, 4, 1);
            machine.solver.fixed_step_s = Some(1e-3);
            let mut wing = start(machine);
            let mut i = 0.0;
            while wing.outputs().latches()[0].time_s < 0.0 && wing.time_s() < 0.3 {
                i += 1.0;
                wing.step(i * step_s).unwrap_or_else(|error| panic!("{error}"));
            }
            wing.outputs().latches()[0].time_s
        })
        .collect();
    println!("Q-42 latch at {times:?} s");
    assert!(times[0] > 0.1 && times.iter().all(|time| (time - times[0]).abs() < 1e-12), "{times:?}");
}

/// The shipped flared tip without its gust, its hinge damped so that it settles within a second or two.
fn flared_tip() -> String {
    let text = include_str!("../../../examples/models/flared_wing_tip.toml");
    let (before, rest) = text.split_once("[gust.bump]").expect("a gust");
    let (_, after) = rest.split_once("[gauge.root]").expect("a gauge");
    format!("{before}[gauge.root]{after}").replace("damping_N_m_s_rad = 0.02", "damping_N_m_s_rad = 0.3")
}

/// A hinge with only an aerodynamic restoring moment has the same equilibrium in `static` as at the end of a damped run, from other
/// start angles too; two such hinges; and a hinge without a restoring moment is an error.
#[test]
fn q43_hinges_that_only_the_air_restores_come_to_rest() {
    let mut run = plant(&flared_tip());
    let end = angle_deg(&mut run, 3.0, 0.1).unwrap_or_else(|error| panic!("{error}"));
    for start_deg in [-6.5, 0.0, 20.0, -30.0] {
        let mut wing =
            plant(&flared_tip().replace("start_angle_deg = -6.5", &format!("start_angle_deg = {start_deg:?}")));
        wing.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("from {start_deg}: {error}"));
        let rest = wing.outputs().joints()[0].angle_rad.to_degrees();
        println!("Q-43 from {start_deg}: at rest {rest:.4} deg, run {end:.4} deg");
        assert!((rest - end).abs() < 0.02, "{rest} {end}");
    }
}

/// With the exact static tangent of structure and strips, Newton's iteration for a hinge with only aerodynamic stiffness converges
/// quadratically: each correction is at most a tenth of the square of the previous one. With a difference over 1e-3 rad as tangent it would
/// converge linearly at the end.
#[test]
fn q78_a_free_hinge_comes_to_rest_in_second_order() {
    let text = flared_tip().replace("start_angle_deg = -6.5", "start_angle_deg = 4.0");
    let rest = plant(&text).study().rest(0.0, Holding::AsReleased, Search::default());
    let corrections_rad = rest.unwrap_or_else(|error| panic!("{error}")).corrections_rad;
    println!("Q-78 {corrections_rad:?}");
    assert!(corrections_rad.len() >= 3 && corrections_rad[0] > 0.1, "{corrections_rad:?}");
    // the loads in equilibrium converge to 1e-9, which leaves about 1e-9 rad
    assert!(corrections_rad.windows(2).all(|pair| pair[1] < 0.1 * pair[0] * pair[0] + 2e-9), "{corrections_rad:?}");
}

/// Corrections of Newton's iteration for the free hinges of a model.
fn corrections_rad(text: &str) -> Vec<f64> {
    let rest = plant(text).study().rest(0.0, Holding::AsReleased, Search::default());
    rest.unwrap_or_else(|error| panic!("{error}")).corrections_rad
}

/// Two hinges in a row, whose stiffness matrix is far from symmetric, converge quadratically with strips; so do one and two hinges in
/// a lattice, whose stiffnesses are central differences, accurate to 1e-6: each correction is at most a fraction of the square of the
/// previous one, apart from that error. Convergence used to be linear for two hinges when only symmetric stiffness was accepted for an
/// equilibrium, and in lattices with one-sided differences: each correction was 2e-4 or more of the previous one.
#[test]
fn q79_hinges_in_a_row_and_in_lattices_come_to_rest_in_second_order() {
    let lattice = |text: String| text.replace("model = \"strip\"", "model = \"uvlm\"\nwake_rows = 20");
    let near = |text: String| text.replace("start_angle_deg = -6.5", "start_angle_deg = -3.0");
    for (name, text, linear) in [
        ("two in strips", near(two_hinges()), 0.0),
        ("one in a lattice", lattice(near(flared_tip())), 1e-5),
        ("two in a lattice", lattice(near(two_hinges())), 1e-5),
    ] {
        let corrections_rad = corrections_rad(&text);
        println!("Q-79 {name}: {corrections_rad:?}");
        assert!(corrections_rad.len() >= 3, "{name}: {corrections_rad:?}");
        // the loads in equilibrium converge to 1e-9, which leaves about 1e-9 rad
        let allowed = |before: f64| 2.0 * before * before + linear * before + 5e-9;
        let steps = corrections_rad.windows(2).filter(|pair| pair[0] < 0.1);
        assert!(
            steps.clone().count() >= 1 && steps.clone().all(|pair| pair[1] < allowed(pair[0])),
            "{corrections_rad:?}"
        );
    }
}

/// The flared tip with an additional fold in the middle of the wing.
fn two_hinges() -> String {
    let text = flared_tip();
    let (joints, rest) = text.split_once("[aerodynamics]").expect("air");
    let joints = joints.replace("length_m = 0.4", "length_m = 0.2");
    let outer = "[body.end]\nlength_m = 0.2\nsection = \"spar\"\nelements = 2\nstiffness_damping_s = 2e-3\n\
                 [joint.last]\ntype = \"revolute\"\nparent = \"tip\"\nchild = \"end\"\n\
                 axis = [0.3420201433256687, 0.9396926207859084, 0.0]\n[joint.last.motor]\ndamping_N_m_s_rad = 0.3\n\
                 [surface.end]\nbody = \"end\"\nchord_m = 0.25\nelastic_axis_fraction = 0.3\nincidence_deg = 3.0\nstrips = 3\n";
    format!("{joints}{outer}[aerodynamics]{rest}").replace("strips = 6", "strips = 3")
}

/// Q-43, two free hinges in a row: the wing also folds in its middle.
#[test]
fn q43_two_hinges_that_only_the_air_restores() {
    let text = two_hinges();
    let mut run = plant(&text);
    angle_deg(&mut run, 6.0, 0.1).unwrap_or_else(|error| panic!("{error}"));
    let mut wing = plant(&text);
    wing.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    for (rest, end) in wing.outputs().joints().iter().zip(run.outputs().joints()) {
        let [rest, end] = [rest, end].map(|joint| joint.angle_rad.to_degrees());
        println!("Q-43 two hinges: at rest {rest:.4} deg, run {end:.4} deg");
        assert!((rest - end).abs() < 0.1, "{rest} {end}");
    }
}

/// Q-43, a hinge along the wind with a constant moment of its weight: there is no restoring moment, as the message states.
#[test]
fn q43_a_hinge_that_nothing_restores_is_told() {
    let text =
        flared_tip().replace("wind_m_s = [0.0, -20.0, 0.0]", "wind_m_s = [0.0, 0.0, 0.0]").replace("-9.81]", "0.0]");
    let error = plant(&text).study().equilibrium(0.0, Holding::AsReleased).expect_err("no place of rest").to_string();
    println!("Q-43 {error}");
    assert!(error.contains("fold") && error.contains("spring"), "{error}");
}
