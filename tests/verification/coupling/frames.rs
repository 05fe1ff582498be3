//! Equal flows give equal results in every frame: flying wings, moving roots, wind.

use crate::coupling::edges::{LATTICE, folded_at_incidence};
use crate::coupling::wings::{march, start};
use crate::trees::Random;
use foldwing::config;
use foldwing::plant::{Plant, Statistics, SurfaceLattice};
use nalgebra::Vector3;

/// A stiff wing at 5 degrees of incidence, so heavy that aerodynamic loads do not move it.
fn heavy_wing(joint: &str, gravity_m_s2: [f64; 3], wind_m_s: [f64; 3], air: &str) -> Plant {
    let panels = if air.contains("strip") { "" } else { "chord_panels = 3\n" };
    let text = format!(
        "name = \"Wing\"\ngravity_m_s2 = {gravity_m_s2:?}\n\
         [section.plate]\nshape = \"explicit\"\naxial_stiffness_N = 1e9\ntorsional_rigidity_N_m2 = 1e6\n\
         flap_stiffness_N_m2 = 1e6\nedge_stiffness_N_m2 = 1e6\nmass_kg_m = 1e12\n\
         second_moments_kg_m = [1e10, 0.0, 1e10]\nhalf_width_m = 0.1\nhalf_height_m = 0.01\n\
         [body.wing]\nlength_m = 1.2\nsection = \"plate\"\nelements = 1\n\
         [joint.mount]\nparent = \"root\"\nchild = \"wing\"\n{joint}\n\
         [aerodynamics]\nwind_m_s = {wind_m_s:?}\nstep_s = 5e-3\n{air}\n\
         [surface.wing]\nbody = \"wing\"\nchord_m = 0.2\nelastic_axis_fraction = 0.25\nincidence_deg = 5.0\nstrips = 6\n\
         {panels}"
    );
    start(config::parse(&text, "wing.toml").unwrap_or_else(|error| panic!("{error}")))
}

fn flying(velocity_m_s: [f64; 3], gravity_m_s2: [f64; 3], wind_m_s: [f64; 3], air: &str) -> Plant {
    let joint = format!("type = \"free\"\nstart_velocity_m_s = {velocity_m_s:?}");
    heavy_wing(&joint, gravity_m_s2, wind_m_s, air)
}

fn models() -> impl Iterator<Item = String> {
    let airs = [
        "model = \"strip\"",
        "model = \"uvlm\"\nwake_rows = 12",
        "model = \"uvlm\"\nwake_rows = 12\nleading_edge_suction = true\nfree_wake = true",
    ];
    airs.into_iter()
        .flat_map(|air| [true, false].map(|established| format!("{air}\nsteady_initial_flow = {established}")))
}

/// Aerodynamic forces in N at the start and every 10 ms; `change` is called before each step.
fn forces_n(mut plant: Plant, mut change: impl FnMut(&mut Plant)) -> Vec<Vector3<f64>> {
    let mut forces = vec![plant.outputs().air_total().force_n];
    for step in 1..=15 {
        change(&mut plant);
        plant.step(0.01 * f64::from(step)).unwrap_or_else(|error| panic!("{error}"));
        forces.push(plant.outputs().air_total().force_n);
    }
    forces
}

fn difference(one: &[Vector3<f64>], two: &[Vector3<f64>]) -> f64 {
    let largest_n = one.iter().map(|force| force.norm()).fold(0.0, f64::max);
    one.iter().zip(two).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max) / largest_n
}

/// Fixed in the wind, flying through still air, and both together: the same flow and lift from the start on. Version 0.1.0 shed no
/// wake in still air and placed the wake of the start along the wind: 77 % off.
#[test]
fn q50_wind_and_flight_are_one_flow() {
    for air in models() {
        let fixed = forces_n(heavy_wing("type = \"clamped\"", [0.0; 3], [0.0, -10.0, 0.0], &air), |_| ());
        for [velocity_m_s, wind_m_s] in
            [[[0.0, 10.0, 0.0], [0.0; 3]], [[0.0, 5.0, 0.0], [0.0, -5.0, 0.0]], [[0.3, 10.1, -3.0], [0.3, 0.1, -3.0]]]
        {
            let off = difference(&fixed, &forces_n(flying(velocity_m_s, [0.0; 3], wind_m_s, &air), |_| ()));
            assert!(off < 1e-10, "{air}, flies at {velocity_m_s:?}: {off:e}");
        }
    }
}

/// A wing in free fall through still air, and one on a root with the same acceleration in wind that accelerates at the same rate:
/// velocities are averaged relative to that wind, eq. (Q4).
#[test]
fn q51_a_root_that_accelerates_is_a_wing_that_does() {
    let (gravity_m_s2, rate_m_s2) = ([0.0, 8.0, -3.0], Vector3::new(0.0, -8.0, 3.0));
    // no far wake: its direction follows from the velocity at the start of a step, an error of 2e-5 of the load in an accelerated frame
    for air in models().map(|air| air.replace("wake_rows = 12", "wake_rows = 6")) {
        let falls = forces_n(flying([0.0, 10.0, 0.0], gravity_m_s2, [0.0; 3], &air), |_| ());
        let root = heavy_wing("type = \"clamped\"", gravity_m_s2, [0.0, -10.0, 0.0], &air);
        let carried = forces_n(root, |plant| {
            plant.inputs_mut().root_mut().acceleration_m_s2 = -rate_m_s2;
            *plant.input_rates_mut().wind_m_s_mut() = rate_m_s2;
        });
        let off = difference(&falls, &carried);
        assert!(off < 1e-10, "{air}: {off:e}");
    }
}

/// The shipped folding wing with a lattice, its root clamped or on a carrier so heavy that it flies straight on.
fn unfolding(speed_m_s: Option<f64>, wind_m_s: f64, air: &str) -> Plant {
    let mut text = include_str!("../../../examples/models/folding_wing.toml").replace("-9.8", "0.0");
    for line in text.clone().lines().filter(|line| line.starts_with("mass_damping_1_s")) {
        text = text.replace(line, "mass_damping_1_s = 0.0");
    }
    if let Some(speed_m_s) = speed_m_s {
        let free = format!("type = \"free\"\nstart_velocity_m_s = [0.0, {:?}, 0.0]\nparent = \"root\"", -speed_m_s);
        text = text.replacen("type = \"clamped\"\nparent = \"root\"", &free, 1);
        text += "[mass.carrier]\nbody = \"inner\"\nposition_m = 0.0\nmass_kg = 1e12\n\
                 inertia_kg_m2 = [1e12, 1e12, 1e12, 0.0, 0.0, 0.0]\n";
        assert!(text.contains("type = \"free\""));
    }
    text +=
        &format!("[aerodynamics]\nmodel = \"uvlm\"\nwind_m_s = [0.0, {:?}, 0.0]\nstep_s = 1.25e-3\n{air}\n", -wind_m_s);
    for body in ["inner", "outer"] {
        text += &format!("[surface.{body}]\nbody = \"{body}\"\nstrips = 5\nchord_panels = 2\n");
    }
    start(config::parse(&text, "wing.toml").unwrap_or_else(|error| panic!("{error}")))
}

fn angle_deg(plant: Plant, end_s: f64) -> f64 {
    march(plant, end_s, 1).outputs().joints()[0].angle_rad.to_degrees()
}

/// A wing that unfolds in still air, in frames of roots that move with the air. Before, it latched at 0.10269 s with a fixed root and
/// at 0.10507 s in every other frame.
#[test]
fn q52_unfolding_in_air_at_rest_does_not_depend_on_the_frame() {
    for air in ["steady_initial_flow = true", "steady_initial_flow = false"] {
        let rest_deg = angle_deg(unfolding(None, 0.0, air), 0.06);
        for speed_m_s in [1.0, 20.0] {
            let moving_deg = angle_deg(unfolding(Some(speed_m_s), speed_m_s, air), 0.06);
            println!("Q-52 {rest_deg} deg at rest, {:e} at {speed_m_s} m/s", moving_deg - rest_deg);
            // the joint of the carrier is integrated too: Newton's iteration leaves a relative error of 1e-8
            assert!((moving_deg - rest_deg).abs() < 1e-7 * rest_deg, "{moving_deg} {rest_deg}");
        }
    }
}

/// As Q-52 with a free wake, folded sheets included, until shortly before the latch closes. With vortex cores narrower than the
/// spacing of the wake's lines, round-off grows: the latch closed at 0.1047, 0.1063 and 0.1035 s with a fifth of that spacing, and with the
/// core of the panels a run failed. Now only round-off remains; the required agreement is 1e-4.
#[test]
fn q81_a_free_wake_does_not_depend_on_the_frame() {
    let air = "free_wake = true";
    let rest_deg = angle_deg(unfolding(None, 0.0, air), 0.1);
    for speed_m_s in [1.0, 20.0] {
        let moving_deg = angle_deg(unfolding(Some(speed_m_s), speed_m_s, air), 0.1);
        println!("Q-81 {rest_deg} deg at rest, {:e} at {speed_m_s} m/s", moving_deg - rest_deg);
        assert!((moving_deg - rest_deg).abs() < 1e-4 * rest_deg.abs(), "{moving_deg} {rest_deg}");
    }
}

fn between(random: &mut Random, from: f64, to: f64) -> f64 {
    from + (to - from) * 0.5 * (1.0 + random.symmetric())
}

/// A wing of two to four bodies on locked, flared hinges at random angles, in a wind that may also come from the side.
fn held(random: &mut Random, free_wake: bool) -> Plant {
    let mut text = "name = \"Held\"\ngravity_m_s2 = [0.0, 0.0, 0.0]\n".to_owned();
    let (bodies, chord_m) = (2 + (between(random, 0.0, 3.0) as usize).min(2), between(random, 0.1, 0.25));
    for body in 0..bodies {
        let width_m = chord_m * between(random, 0.7, 1.0);
        let (length_m, flare_rad) = (between(random, 0.15, 0.5), between(random, -0.4, 0.4));
        text += &format!(
            "[section.s{body}]\nshape = \"rectangle\"\nwidth_m = {width_m:?}\nheight_m = {:?}\ndensity_kg_m3 = 600.0\n\
             youngs_modulus_Pa = 2e11\nshear_modulus_Pa = 8e10\n\
             [body.b{body}]\nlength_m = {length_m:?}\nsection = \"s{body}\"\nelements = 2\n\
             [joint.j{body}]\nchild = \"b{body}\"\n",
            0.05 * width_m
        );
        text += &match body {
            0 => "type = \"clamped\"\nparent = \"root\"\n".to_owned(),
            _ => format!(
                "type = \"revolute\"\nparent = \"b{}\"\naxis = [{:?}, {:?}, 0.0]\nmotion = \"locked\"\nstart_angle_deg = {:?}\n",
                body - 1,
                flare_rad.sin(),
                flare_rad.cos(),
                between(random, -100.0, 100.0)
            ),
        };
        text += &format!(
            "[surface.b{body}]\nbody = \"b{body}\"\nstrips = {}\nchord_panels = 4\nincidence_deg = {:?}\n",
            4 + 2 * (between(random, 0.0, 3.0) as usize).min(2),
            between(random, -4.0, 6.0)
        );
    }
    let (side_rad, speed_m_s) = (between(random, -0.26, 0.26), between(random, 8.0, 25.0));
    text += &format!(
        "[aerodynamics]\nmodel = \"uvlm\"\nwind_m_s = [{:?}, {:?}, 0.0]\nfree_wake = {free_wake}\nwake_rows = 40\n",
        speed_m_s * side_rad.sin(),
        -speed_m_s * side_rad.cos()
    );
    start(config::parse(&text, "held.toml").unwrap_or_else(|error| panic!("{error}")))
}

/// Random wings on locked hinges: a free wake with the default core changes the forces by a few per cent of the largest. With cores
/// of a hundredth of a panel, the wake became irregular where sheets overlap: the forces changed by up to 21 times, and runs failed.
#[test]
fn q82_free_wakes_of_held_wings_stay_near_prescribed_ones() {
    let forces_n = |seed: u64, free_wake: bool| -> Vec<Vector3<f64>> {
        let mut plant = held(&mut Random::new(seed), free_wake);
        let step = |step: i32| {
            plant.step(2e-3 * f64::from(step)).unwrap_or_else(|error| panic!("{seed}: {error}"));
            plant.outputs().air_total().force_n
        };
        (1..=25).map(step).collect()
    };
    for seed in 1..=10 {
        let off = difference(&forces_n(seed, false), &forces_n(seed, true));
        println!("Q-82 {seed}: {off:.1e}");
        // roll-up behind folded wings: twice the largest value of twelve such wings
        assert!(off < 0.04, "{seed}: {off}");
    }
}

/// A free wake differs from a prescribed one by its roll-up, which falls with the circulation: the relative difference of the forces is
/// of second order in the incidence on a plane wing, where it does not depend on its sign, and of first order on a folded one.
#[test]
fn q95_free_wakes_tend_to_prescribed_ones_with_the_circulation() {
    let forces_n = |fold_deg: f64, incidence_deg: f64, free_wake: bool| -> Vec<Vector3<f64>> {
        let air = format!("{LATTICE}\nwake_rows = 40\nstep_s = 5e-3\nfree_wake = {free_wake}");
        let wing = folded_at_incidence(|_, _| format!("{incidence_deg:?}"), fold_deg, 8, &air);
        let mut plant = wing.unwrap_or_else(|error| panic!("{error}"));
        let step = |step: i32| {
            plant.step(0.01 * f64::from(step)).unwrap_or_else(|error| panic!("{error}"));
            plant.outputs().air_total().force_n
        };
        (1..=20).map(step).collect()
    };
    for (fold_deg, order) in [(0.0, 2.0), (60.0, 1.0)] {
        let off = [1.0, 2.0, 4.0].map(|incidence_deg| {
            difference(&forces_n(fold_deg, incidence_deg, false), &forces_n(fold_deg, incidence_deg, true))
        });
        let orders = [0, 1].map(|at| (off[at + 1] / off[at]).log2());
        println!("Q-95 {fold_deg} deg: {off:?}, orders {orders:?}");
        assert!(orders.iter().all(|found| (found - order).abs() < 0.4), "{fold_deg}: {orders:?}");
        assert!(off[2] < 1e-3, "{fold_deg}: {off:?}");
    }
}

/// Still air is the limit of slow wind, whether the flow at the start is steady or impulsive.
#[test]
fn q53_slow_wind_leads_to_air_at_rest() {
    let rest_deg = angle_deg(unfolding(None, 0.0, ""), 0.06);
    for established in [true, false] {
        let air = format!("steady_initial_flow = {established}");
        let off_deg = [1e-3, 1e-2].map(|wind| angle_deg(unfolding(None, wind, &air), 0.06) - rest_deg);
        println!("Q-53 {rest_deg} deg at rest, off by {off_deg:?}");
        // after a steady-flow start the wake has a ring at the edge from the first step on, which moves the youngest vortex, eq. (U9),
        // whatever the wind: 0.039 deg, 3e-5 s of the motion; a wind of 0.01 m/s adds 0.009 deg (2026-11-24, since that vortex moves across
        // the chord with the air; before, at most 0.006)
        let own_deg = [0.045, 0.055];
        assert!(off_deg.iter().zip(own_deg).all(|(off, own)| off.abs() < own), "{off_deg:?} of {rest_deg}");
    }
}

/// Distance from the trailing edge to the row shed at the start, and the corresponding time in s.
fn first_row_m(plant: &Plant, start: &[SurfaceLattice]) -> (f64, Vector3<f64>) {
    let (time_s, now) = plant.lattice().expect("a lattice");
    let last = now[0].wake_node_m.last().expect("a row");
    (time_s, last[3] - start[0].wake_node_m[0][3])
}

/// The wake travels with the wind, whatever happens inside aerodynamic steps: jumps and ramps of the wind there, with communication
/// steps of 1.3 ms and aerodynamic steps of 5 ms.
#[test]
fn q54_wake_goes_with_a_wind_that_jumps_inside_a_step() {
    let air = "model = \"uvlm\"\nwake_rows = 50\nsteady_initial_flow = false";
    let mut plant = heavy_wing("type = \"clamped\"", [0.0; 3], [0.0, -10.0, 0.0], air);
    let (_, start) = plant.lattice().expect("a lattice");
    let (mut wind_m_s, mut way_m) = (Vector3::new(0.0, -10.0, 0.0), Vector3::zeros());
    for step in 1..=20_u32 {
        let rate_m_s2 = if step % 5 == 1 { Vector3::new(0.0, -900.0, 200.0) } else { Vector3::zeros() };
        if [3, 6, 14].contains(&step) {
            wind_m_s += Vector3::new(0.5, -3.0, 0.7);
        }
        *plant.inputs_mut().wind_m_s_mut() = wind_m_s;
        *plant.input_rates_mut().wind_m_s_mut() = rate_m_s2;
        plant.step(1.3e-3 * f64::from(step)).unwrap_or_else(|error| panic!("{error}"));
        way_m += wind_m_s * 1.3e-3 + rate_m_s2 * (0.5 * 1.3e-3 * 1.3e-3);
        wind_m_s += rate_m_s2 * 1.3e-3;
        let (time_s, row_m) = first_row_m(&plant, &start);
        // the lattice is at the end of the aerodynamic step, up to which the current wind is extrapolated
        let expected_m = way_m + wind_m_s * (time_s - plant.time_s());
        let runs = rate_m_s2 != Vector3::zeros();
        assert!(runs || (row_m - expected_m).norm() < 1e-12, "step {step}: {row_m} {expected_m}");
    }
}

/// Rows longer than two panels are counted, whatever the cause of the motion, and the warning gives a step that avoids them.
#[test]
fn q55_rows_that_are_too_long_are_told() {
    let air = "model = \"uvlm\"\nwake_rows = 12";
    // a third of 0.2 m in 5 ms is 13.3 m/s
    for (speed_m_s, panels) in [(10.0, 0.75), (40.0, 3.0)] {
        let plant = march(flying([0.0, speed_m_s, 0.0], [0.0; 3], [0.0; 3], air), 0.02, 1);
        let statistics = plant.statistics();
        approx::assert_relative_eq!(statistics.longest_row_panels, panels, max_relative = 1e-9);
        let advice = statistics.advice_on_rows(5e-3);
        assert_eq!(advice.is_some(), panels > 2.0);
        assert!(advice.is_none_or(|advice| advice.contains("up to 3.0 panel chords") && advice.contains("3.3e-3 s")));
    }
}

/// The warning gives enough digits to distinguish the bound from a length that only just exceeds it, and its proposed step stays
/// within the bound.
#[test]
fn q55_advice_on_rows_is_told_to_the_digit_that_matters() {
    for (panels, told) in
        [(2.0031, "up to 2.003 panel chords"), (2.01, "up to 2.01 panel chords"), (2.16, "up to 2.2 panel chords")]
    {
        let statistics = Statistics { longest_row_panels: panels, ..Statistics::default() };
        let advice = statistics.advice_on_rows(1.27e-3).expect("rows are too long");
        assert!(advice.contains(told), "{panels}: {advice}");
        let named_s: f64 =
            advice.split("at most ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap().parse().unwrap();
        assert!(named_s * panels <= 2.0 * 1.27e-3 && named_s > 0.9 * 1.27e-3 * 2.0 / panels, "{panels}: {advice}");
    }
}
