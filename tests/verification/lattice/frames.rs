//! Rotating roots against rotating wings, and edges that move at different speeds.

use crate::lattice::wing::{DENSITY_KG_M3, inset, options};
use foldwing::aero::established::Established;
use foldwing::aero::flow::Flow;
use foldwing::aero::lattice::{LatticeOptions, LoadRule};
use foldwing::aero::lattice_state::LatticeState;
use foldwing::aero::strip::StripOptions;
use foldwing::aero::surface::{ChordLine, Profile, Surface};
use foldwing::aero::{AirLoads, AirModel, AirOptions, AirState};
use foldwing::load::SectionMotion;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// A wing of 3 m that rotates about an axis through the origin, at some incidence and distance from it.
fn turning(
    options: &AirOptions,
    spin_rad_s: Vector3<f64>,
    established: bool,
    root_turns: bool,
) -> (Vec<AirLoads>, AirState) {
    let places_m: Vec<f64> = inset(3.0, 6).into_iter().map(|x| x + 1.6).collect();
    let forward = Vector3::new(0.0, 0.1_f64.cos(), 0.1_f64.sin());
    let chord = ChordLine { leading_m: forward * 0.25, trailing_m: forward * -0.75 };
    let surface = Surface {
        sections: 0..places_m.len(),
        chords: vec![chord; places_m.len()],
        chord_panels: 3,
        profile: Profile::THIN,
    };
    let mut model = AirModel::new(vec![surface], options);
    let (mut from, mut to, mut loads) = (model.blank_state(), model.blank_state(), AirLoads::still(places_m.len()));
    let (step_s, mut all) = (0.02, Vec::new());
    for step in 0..7 {
        let time_s = f64::from(step) * step_s;
        let turn = if root_turns { Matrix3::identity() } else { Rotation3::new(spin_rad_s * time_s).into_inner() };
        let spin = if root_turns { Vector3::zeros() } else { spin_rad_s };
        let section = |x: &f64| {
            let position_m = turn * Vector3::new(*x, 0.3, 0.0);
            SectionMotion { rotation: turn, position_m, velocity_m_s: spin.cross(&position_m), spin_rad_s: spin }
        };
        let motions: Vec<SectionMotion> = places_m.iter().map(section).collect();
        let flow = Flow {
            time_s,
            density_kg_m3: DENSITY_KG_M3,
            wind_m_s: Vector3::zeros(),
            spin_rad_s: if root_turns { spin_rad_s } else { Vector3::zeros() },
            gusts: &[],
        };
        if step == 0 {
            model
                .start(&motions, &flow, established.then_some(Established::straight(step_s)), &mut from, &mut loads)
                .expect("regular");
        } else {
            model.convect(&from, &flow, step_s, &mut to);
            model.solve(&from, &motions, &flow, step_s, &mut to, &mut loads).expect("regular");
            std::mem::swap(&mut from, &mut to);
        }
        let mut own = loads.clone();
        for load in own.circulatory.iter_mut().chain(&mut own.impulsive) {
            (load.force_n, load.moment_n_m) = (turn.transpose() * load.force_n, turn.transpose() * load.moment_n_m);
        }
        all.push(own);
    }
    (all, from)
}

/// U-40. A fixed wing on a root that rotates through the air, and a rotating wing on a fixed root: the same loads on the sections, in their
/// frames, to round-off, and the same wake. The wake used to be rotated with the wrong sign, unnoticed.
#[test]
fn u40_a_root_that_turns_is_a_wing_that_turns() {
    let spin_rad_s = Vector3::new(0.4, -0.3, 4.0);
    let lattice = AirOptions::Lattice(LatticeOptions { wake_rows: 8, ..options() });
    let by_segments = LatticeOptions { load_rule: LoadRule::KuttaJoukowski, wake_rows: 8, ..options() };
    let joukowski = AirOptions::Lattice(by_segments);
    for (options, established) in [
        (lattice.clone(), true),
        (lattice, false),
        (joukowski, true),
        (AirOptions::Strips(StripOptions::default()), false),
    ] {
        let (root, _) = turning(&options, spin_rad_s, established, true);
        let (wing, _) = turning(&options, spin_rad_s, established, false);
        let largest_n = root[6].circulatory.iter().map(|load| load.force_n.norm()).fold(0.0, f64::max);
        for (step, (one, two)) in root.iter().zip(&wing).enumerate() {
            let both = one.circulatory.iter().chain(&one.impulsive).zip(two.circulatory.iter().chain(&two.impulsive));
            let off = both.map(|(one, two)| (one.force_n - two.force_n).norm()).fold(0.0, f64::max) / largest_n;
            // close to the line of a segment only eight digits are left, as in U-20
            assert!(off < 1e-8, "{options:?}, established {established}, step {step}: {off:e}");
        }
    }
}

/// U-41. Edges that move at different speeds: the wake of a wing that rotates about its inner end is a fan whose rows widen with the
/// distance from the axis, from the start on; at the axis their length is zero and they induce nothing.
#[test]
fn u41_wake_of_edges_at_different_speeds_is_a_fan() {
    let lattice = AirOptions::Lattice(LatticeOptions { wake_rows: 8, ..options() });
    let (_, state) = turning(&lattice, Vector3::z() * 4.0, false, false);
    let AirState::Lattice(state) = state else { panic!("a lattice") };
    assert_eq!(state.wake_rows, 6);
    for (column, edge_m) in state.edge_m.iter().enumerate() {
        // shed nodes lie on a circle about the axis just behind the edge, one step apart
        let row_m = |row: usize| state.wake_node_m[row * state.edge_m.len() + column];
        let radius_m = row_m(1).xy().norm();
        assert!((row_m(2).xy().norm() - radius_m).abs() < 1e-12 && (edge_m.xy().norm() - radius_m).abs() < 0.4);
        let expected_m = 2.0 * radius_m * (0.5_f64 * 4.0 * 0.02).sin();
        let found_m = (row_m(2) - row_m(1)).norm();
        assert!((found_m - expected_m).abs() < 1e-12, "{found_m}, expected {expected_m}, at {radius_m} m");
    }
}

/// U-66. The wake of a steady turn is that of a wing turning from the start on: after 200 steps through 1.5 rad its circulations are those
/// of the steady flow, except for the effects of the starting vortex and of the far end; with a straight wake the outer and the inner half
/// would differ. The steady flow itself does not change.
#[test]
fn u66_the_wake_of_a_steady_turn_is_what_a_turning_wing_leaves() {
    let (spin_rad_s, step_s) = (Vector3::new(0.0, 0.02, 0.3), 0.025);
    let flow = Flow {
        time_s: 0.0,
        density_kg_m3: DENSITY_KG_M3,
        wind_m_s: Vector3::new(0.0, -0.1f64.cos(), 0.1f64.sin()) * 10.0,
        spin_rad_s,
        gusts: &[],
    };
    let places_m = inset(6.0, 8);
    let march = |established: Option<Established>, steps: usize| {
        let chord = ChordLine { leading_m: Vector3::y() * 0.25, trailing_m: Vector3::y() * -0.75 };
        let surface = Surface {
            sections: 0..places_m.len(),
            chords: vec![chord; places_m.len()],
            chord_panels: 4,
            profile: Profile::THIN,
        };
        let options = AirOptions::Lattice(LatticeOptions { wake_rows: 220, ..options() });
        let mut model = AirModel::new(vec![surface], &options);
        let still = |x: &f64| SectionMotion {
            rotation: Matrix3::identity(),
            position_m: Vector3::x() * *x,
            velocity_m_s: Vector3::zeros(),
            spin_rad_s: Vector3::zeros(),
        };
        let motions: Vec<SectionMotion> = places_m.iter().map(still).collect();
        let (mut from, mut to, mut loads) = (model.blank_state(), model.blank_state(), AirLoads::still(places_m.len()));
        model.start(&motions, &flow, established, &mut from, &mut loads).expect("regular");
        for _ in 0..steps {
            model.convect(&from, &flow, step_s, &mut to);
            model.solve(&from, &motions, &flow, step_s, &mut to, &mut loads).expect("regular");
            std::mem::swap(&mut from, &mut to);
        }
        let AirState::Lattice(state) = from else { panic!("a lattice") };
        state
    };
    let off = |one: &LatticeState, two: &LatticeState| {
        let largest = one.circulation_m2_s.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let pairs = one.circulation_m2_s.iter().zip(&two.circulation_m2_s);
        pairs.map(|(one, two)| (one - two).abs()).fold(0.0, f64::max) / largest
    };
    let turning = Some(Established { step_s, turning: true });
    let (begin, left) = (march(turning, 0), march(None, 200));
    let straight = march(Some(Established::straight(step_s)), 0);
    let (curved_off, straight_off) = (off(&begin, &left), off(&straight, &left));
    let steady = off(&begin, &march(turning, 30));
    println!("U-66 off by {curved_off:.1e}, with a straight wake {straight_off:.1e}; after 30 steps {steady:.1e}");
    // the starting vortex is 50 m behind a span of 6 m: 6²/(2π 50²) of the wing's own induced velocity
    assert!(curved_off < 2e-3 && straight_off > 4.0 * curved_off, "{curved_off:e} {straight_off:e}");
    assert!(steady < 1e-12, "{steady:e}");
    assert_eq!(begin.wake_rows, 208 + 1, "a quarter turn");
}
