//! Two bodies with a hinge, folded until their panels nearly touch.

use crate::wing::{DENSITY_KG_M3, SPEED_M_S, options};
use foldwing::aero::AirLoads;
use foldwing::aero::flow::Flow;
use foldwing::aero::lattice::{LatticeOptions, VortexLattice};
use foldwing::aero::surface::{ChordLine, Profile, Surface};
use foldwing::load::SectionMotion;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Circulations at the trailing edge in m²/s, inner strips then outer ones, and the lift in N, of two bodies of 3 m with
/// chord 1 m at an angle of attack of 0.1 rad, the outer one folded.
fn folded(angle_rad: f64, strips: usize, chord_panels: usize, core_radius_m: f64, split: bool) -> (Vec<f64>, f64) {
    let chord = ChordLine { leading_m: Vector3::y() * 0.25, trailing_m: Vector3::y() * -0.75 };
    // the outer tip is inset by a quarter panel
    let panel_m = 3.0 / strips as f64;
    let outer_panel_m = 3.0 / (strips as f64 + 0.25);
    let fold = Rotation3::from_axis_angle(&Vector3::y_axis(), angle_rad).into_inner();
    let still = |rotation: Matrix3<f64>, position_m| SectionMotion {
        rotation,
        position_m,
        velocity_m_s: Vector3::zeros(),
        spin_rad_s: Vector3::zeros(),
    };
    let inner = (0..=strips).map(|i| still(Matrix3::identity(), Vector3::x() * (panel_m * i as f64)));
    let outer =
        (0..=strips).map(|i| still(fold, Vector3::x() * 3.0 + fold * Vector3::x() * (outer_panel_m * i as f64)));
    let surface = |sections: std::ops::Range<usize>| Surface {
        chords: vec![chord; sections.len()],
        sections,
        chord_panels,
        profile: Profile::THIN,
    };
    let (motions, surfaces): (Vec<_>, _) = if split {
        (inner.chain(outer).collect(), vec![surface(0..strips + 1), surface(strips + 1..2 * strips + 2)])
    } else {
        (inner.chain(outer.skip(1)).collect(), vec![surface(0..2 * strips + 1)])
    };
    let options = LatticeOptions { core_radius_m, mirror_normal: Some(Vector3::x()), ..options() };
    let mut lattice = VortexLattice::new(surfaces, options);
    let (mut state, mut loads) = (lattice.blank_state(), AirLoads::still(motions.len()));
    let flow = Flow {
        time_s: 0.0,
        density_kg_m3: DENSITY_KG_M3,
        wind_m_s: Vector3::new(0.0, -0.1f64.cos(), 0.1f64.sin()) * SPEED_M_S,
        spin_rad_s: Vector3::zeros(),
        gusts: &[],
    };
    lattice.start(&motions, &flow, true, &mut state, &mut loads).expect("regular");
    let circulation = |strip: usize| match split {
        true => lattice.strip_circulation(&state, strip / strips, strip % strips),
        false => lattice.strip_circulation(&state, 0, strip),
    };
    let lift_n: f64 = loads.circulatory.iter().map(|load| load.force_n.z).sum();
    ((0..2 * strips).map(circulation).collect(), lift_n)
}

/// U-30. Two bodies that share an edge are one wing: their rings' segments on the edge cancel. The loads of the
/// chordwise segments there differ by the two sides' velocities, nothing else.
#[test]
fn u30_a_hinge_does_not_disturb() {
    let (one, one_n) = folded(0.3, 8, 4, 1e-3, false);
    let (two, two_n) = folded(0.3, 8, 4, 1e-3, true);
    let error = one.iter().zip(&two).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("U-30 circulation {error:.1e} m2/s, lift {one_n:.4} and {two_n:.4} N");
    assert!(error < 1e-10, "{error:e}");
    assert!((one_n / two_n - 1.0).abs() < 0.01, "{one_n} {two_n}");
}

/// U-31. Folded by 170° the tips' panels are a sixth of their span apart: circulation and lift stay finite, do not
/// depend on a small core, and converge with the panels.
#[test]
fn u31_folded_by_170_degrees() {
    let angle_rad = 170f64.to_radians();
    let lifts_n = [6, 12, 24].map(|strips| {
        let (circulation, lift_n) = folded(angle_rad, strips, 4, 1e-3, true);
        let largest = circulation.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        println!("U-31 {strips} strips: lift {lift_n:.4} N, circulation up to {largest:.4} m2/s");
        // plane flow without the other body would have πcVα
        assert!(largest < std::f64::consts::PI * SPEED_M_S * 0.1, "{largest}");
        lift_n
    });
    let (coarse, fine) = ((lifts_n[1] - lifts_n[0]).abs(), (lifts_n[2] - lifts_n[1]).abs());
    assert!(fine < 0.7 * coarse && fine < 0.03 * lifts_n[2].abs(), "no convergence: {lifts_n:?}");
    let (_, other_n) = folded(angle_rad, 12, 4, 1e-4, true);
    println!("U-31 core of a tenth: {:+.1e}", other_n / lifts_n[1] - 1.0);
    assert!((other_n / lifts_n[1] - 1.0).abs() < 1e-3, "{other_n} against {}", lifts_n[1]);
}
