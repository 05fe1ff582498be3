//! Spanwise flow: forces on the trailing legs of the lifting line, eq. (W16), and twisted strips, eq. (W4), compared with the lattice with
//! one panel along the chord and with a pitching plate.

use super::tip_loss::{LINE, Line, arch, flow, wind, worst};
use crate::lattice::wing::{SPEED_M_S, Wing, inset, options};
use foldwing::aero::AirLoads;
use foldwing::aero::flow::{Flow, Gust, GustShape};
use foldwing::aero::strip::StripOptions;
use foldwing::aero::strip::lifting_line::LiftingLineOptions;
use foldwing::aero::surface::{Edge, Profile};
use foldwing::load::SectionMotion;
use nalgebra::{Rotation3, Vector3};

/// A wind with an incidence and a sideslip angle.
fn aside(incidence_rad: f64, sideslip_rad: f64) -> Vector3<f64> {
    Rotation3::from_axis_angle(&Vector3::z_axis(), sideslip_rad) * wind(incidence_rad)
}

/// Force in N and moment about the middle of the wing in N.m.
fn wrench(loads: &AirLoads, motions: &[SectionMotion]) -> (Vector3<f64>, Vector3<f64>) {
    let both = loads.circulatory.iter().zip(motions);
    let moments = both.map(|(load, motion)| load.moment_n_m + motion.position_m.cross(&load.force_n));
    (loads.circulatory.iter().map(|load| load.force_n).sum(), moments.sum())
}

/// Lifting line and lattice in the same wind, both without leading-edge suction.
fn pair(places_m: &[f64], wind_m_s: Vector3<f64>, shape: impl Fn(&mut [SectionMotion])) -> (Line, Wing) {
    let strips = StripOptions { tip_loss: Some(LINE), leading_edge_suction: false, ..Default::default() };
    let mut line = Line::new(places_m, |_| 1.0, Profile::THIN, strips);
    let mut lattice = Wing::new(places_m, |_| 1.0, 1, options());
    lattice.wind_m_s = wind_m_s;
    shape(&mut line.motions);
    shape(&mut lattice.motions);
    line.start(wind_m_s, true);
    lattice.start(true);
    (line, lattice)
}

/// W-47. A wing in sideslip has a rolling moment: the spanwise flow causes forces on the chordwise legs. Lift and rolling moment are those
/// of the lattice with one panel; the velocities induced along the panels, which only the lattice includes, are of second order in the
/// incidence. The forces on the legs act at 7/12 of the chord, as on a lattice with many panels, not at 5/8 as with one panel.
#[test]
fn w47_sideslip_rolls_the_line_as_it_rolls_the_lattice() {
    let places_m = inset(6.0, 24);
    let mut errors = Vec::new();
    for incidence_rad in [4e-3, 2e-3] {
        let (line, lattice) = pair(&places_m, aside(incidence_rad, 0.3), |_| {});
        let ((ours_n, ours_n_m), (theirs_n, theirs_n_m)) =
            (wrench(&line.loads, &line.motions), wrench(&lattice.loads, &lattice.motions));
        let arm_m = theirs_n_m.y / theirs_n.z;
        println!(
            "W-47 {incidence_rad} rad: lift {:.2e} off, rolls on an arm of {arm_m:.4} m, {:.2e} off",
            ours_n.z / theirs_n.z - 1.0,
            ours_n_m.y / theirs_n_m.y - 1.0
        );
        assert!(arm_m.abs() > 0.05, "the wind from the side moves the lift");
        errors.push([ours_n.z / theirs_n.z - 1.0, ours_n_m.y / theirs_n_m.y - 1.0].map(f64::abs));
    }
    // different wake lengths cause a difference of 1e-6, as in W-34
    assert!(errors.iter().flatten().all(|error| *error < 1e-5), "{errors:?}");
    assert!((3.5..4.5).contains(&(errors[0][0] / errors[1][0])), "second order: {errors:?}");
}

/// W-48. Twist, bend and sideslip together: circulations of the lattice with one panel, up to terms of second order in the angles (normals
/// of warped panels) or fourth (W-34): halving the angles reduces the difference to a quarter or less.
#[test]
fn w48_twisted_wings_in_sideslip_are_those_of_the_lattice() {
    let places_m = inset(6.0, 48);
    let difference = |bend_rad: f64, twist_rad: f64, incidence_rad: f64| {
        let (line, lattice) = pair(&places_m, aside(incidence_rad, 0.3), |motions| {
            let twists = motions.iter().map(|motion| twist_rad * motion.position_m.x / 6.0).collect::<Vec<f64>>();
            if bend_rad > 0.0 {
                arch(motions, bend_rad);
            }
            for (motion, twist_rad) in motions.iter_mut().zip(twists) {
                motion.rotation *= Rotation3::from_axis_angle(&Vector3::x_axis(), twist_rad).into_inner();
            }
        });
        let theirs: Vec<f64> =
            (0..48).map(|strip| lattice.lattice.strip_circulation(&lattice.from, 0, strip)).collect();
        worst(&line.circulations(), &theirs)
    };
    for (bend_rad, twist_rad, incidence_rad) in [(0.0, 0.2, 0.0), (0.3, 0.1, 0.0), (0.6, 0.1, 0.05)] {
        let [whole, half] =
            [1.0, 0.5].map(|share| difference(share * bend_rad, share * twist_rad, share * incidence_rad));
        println!(
            "W-48 bend {bend_rad}, twist {twist_rad}, incidence {incidence_rad} rad: {whole:.1e}, half: {half:.1e}"
        );
        // half the twist at the end, and the contribution of the bend in sideslip
        let angle_rad = bend_rad * 0.3_f64.sin() + 0.5 * twist_rad + incidence_rad;
        assert!(whole < 0.05 * angle_rad * angle_rad && half < 0.3 * whole + 2e-6, "{whole}, {half}");
    }
}

/// W-49. A twisted plate in spanwise flow is equivalent to a pitching plate: in a frame that moves with the flow, a section has the pitch rate `u_s dθ/ds`. Lift
/// and moment agree to second order in the twist.
#[test]
fn w49_twist_in_air_along_the_span_is_a_rate_of_pitch() {
    let (along_m_s, twist_rad_m) = (4.0, 1e-3);
    let places_m = [-0.5, 0.5];
    let options = StripOptions { apparent_mass: false, ..Default::default() };
    let mut twisted = Line::new(&places_m, |_| 1.0, Profile::THIN, options);
    for motion in &mut twisted.motions {
        motion.rotation =
            Rotation3::from_axis_angle(&Vector3::x_axis(), twist_rad_m * motion.position_m.x).into_inner();
    }
    twisted.start(Vector3::new(along_m_s, -SPEED_M_S, 0.0), true);
    let mut pitching = Line::new(&places_m, |_| 1.0, Profile::THIN, options);
    for motion in &mut pitching.motions {
        motion.spin_rad_s = Vector3::x() * (along_m_s * twist_rad_m);
    }
    pitching.start(Vector3::new(0.0, -SPEED_M_S, 0.0), true);
    let ((ours_n, ours_n_m), (theirs_n, theirs_n_m)) =
        (wrench(&twisted.loads, &twisted.motions), wrench(&pitching.loads, &pitching.motions));
    println!("W-49 lift {} of {} N, moment {} of {} N.m", ours_n.z, theirs_n.z, ours_n_m.x, theirs_n_m.x);
    assert!(theirs_n.z > 1e-2 && (ours_n.z / theirs_n.z - 1.0).abs() < 1e-5, "{ours_n} against {theirs_n}");
    assert!((ours_n_m.x / theirs_n_m.x - 1.0).abs() < 1e-5, "{ours_n_m} against {theirs_n_m}");
}

/// W-50. A leg in a mirror plane carries no force: half a wing with suction has half of the forces of the whole wing, also along the span.
#[test]
fn w50_legs_at_a_mirror_cancel() {
    let whole_places_m = inset(8.0, 16);
    let mut whole =
        Line::new(&whole_places_m, |_| 1.0, Profile::THIN, StripOptions { tip_loss: Some(LINE), ..Default::default() });
    whole.start(wind(0.1), true);
    let outer = &whole.loads.circulatory[9..];
    let mirror = LiftingLineOptions { mirror_normal: Some(Vector3::x()), ..LINE };
    let options = StripOptions { tip_loss: Some(mirror), ..Default::default() };
    let mut half = Line::new(&whole_places_m[8..], |_| 1.0, Profile::THIN, options);
    half.strips.join_image(Edge { surface: 0, outer: false });
    half.start(wind(0.1), true);
    // the section at the mirror plane has the loads of one side only
    for (ours, theirs) in half.loads.circulatory[1..].iter().zip(outer) {
        assert!((ours.force_n - theirs.force_n).norm() < 1e-5 * whole.force_n().norm(), "{ours:?} against {theirs:?}");
    }
    let (root, twice) = (half.loads.circulatory[0].force_n, whole.loads.circulatory[8].force_n);
    assert!(root.x.abs() < 1e-9 && (2.0 * root - twice).norm() < 1e-5 * whole.force_n().norm(), "{root} of {twice}");
}

/// W-52. Pitching moment of the legs of a tapered wing in sideslip, due to the wind or to a spanwise gust: the force on every leg by the
/// Kutta–Joukowski theorem from the circulations found, at 7/12 of the chord, the mean position at which the circulation of a flat plate is
/// shed into the legs (the loading `√((1 − x)/x)` has its first two moments at 1/4 and 1/8). The lift of the strips acts on the straight
/// quarter-chord line along `x`, behind it by a distance that grows with the square of the incidence, eq. (W7).
#[test]
fn w52_legs_of_a_tapered_wing_act_at_seven_twelfths() {
    let chord_m = |x: f64| 1.0 - 0.1 * x;
    let places_m = inset(6.0, 24);
    let across_m_s = 3.0;
    let gust = Gust {
        name: "across".into(),
        shape: GustShape::SharpEdge,
        velocity_m_s: Vector3::x() * across_m_s,
        direction: -Vector3::y(),
        speed_m_s: SPEED_M_S,
        origin_m: Vector3::y() * 100.0,
        start_s: -100.0,
    };
    for (from_gust, suction) in [(false, false), (true, false), (false, true), (true, true)] {
        let options = StripOptions { tip_loss: Some(LINE), leading_edge_suction: suction, ..Default::default() };
        let mut line = Line::new(&places_m, chord_m, Profile::THIN, options);
        let along_m_s = wind(2e-3);
        let wind_m_s = if from_gust { along_m_s } else { along_m_s + Vector3::x() * across_m_s };
        let gusts = if from_gust { std::slice::from_ref(&gust) } else { &[] };
        line.start_in(&Flow { gusts, ..flow(wind_m_s) }, true);
        let (_, found_n_m) = wrench(&line.loads, &line.motions);
        let air_m_s = along_m_s + Vector3::x() * across_m_s;
        let circulations = line.circulations();
        let mut expected_n_m = Vector3::zeros();
        for (column, x) in places_m.iter().enumerate() {
            let inner = if column > 0 { circulations[column - 1] } else { 0.0 };
            let outer = circulations.get(column).copied().unwrap_or(0.0);
            let leg_m = Vector3::y() * (-0.75 * chord_m(*x));
            let force_n = 1.2 * (inner - outer) * air_m_s.cross(&leg_m);
            // without suction only the part normal to the plate
            let force_n = if suction { force_n } else { Vector3::z() * force_n.z };
            expected_n_m += Vector3::new(*x, -(7.0 / 12.0 - 0.25) * chord_m(*x), 0.0).cross(&force_n);
        }
        println!("W-52 gust {from_gust}, suction {suction}: {found_n_m:?}, legs {expected_n_m:?}");
        // the square of the incidence shifts the lift by 1e-6 semi-chords, times lift divided by the legs' force: 3e-5
        assert!(expected_n_m.x.abs() > 1e-3, "the legs pitch a tapered wing: {expected_n_m}");
        assert!((found_n_m.x / expected_n_m.x - 1.0).abs() < 1e-4, "{found_n_m} against {expected_n_m}");
    }
}
