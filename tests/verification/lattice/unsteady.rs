//! Unsteady flow: the plane limit against Wagner, Theodorsen, Küssner; apparent mass; the wake.

use crate::lattice::wing::{DENSITY_KG_M3, SPEED_M_S, Wing, inset, options, pressure_pa};
use crate::strips::theory::{Aerofoil, kuessner, theodorsen, wagner};
use crate::whole::is_whole;
use foldwing::aero::flow::{Gust, GustShape};
use foldwing::aero::lattice::{LatticeOptions, WakeModel};
use foldwing::load::SectionMotion;
use nalgebra::{Complex, Rotation3, Vector3};
use std::f64::consts::{PI, TAU};

/// Aspect ratio of the wings that represent plane flow. Their middle is 5000 chords from the tips.
const PLANE: f64 = 1e4;
/// Strips of such a wing; the third section lies in the middle region and carries the load of one strip width.
const PLANE_STRIPS: usize = 5;
const MIDDLE: usize = 2;

fn plane_wing(chord_panels: usize, wake_rows: usize) -> (Wing, f64) {
    let places_m = inset(PLANE, PLANE_STRIPS);
    let width_m = places_m[1] - places_m[0];
    (Wing::new(&places_m, |_| 1.0, chord_panels, LatticeOptions { wake_rows, ..options() }), width_m)
}

/// Lift divided by its steady plane value after a sudden start or the entry into a gust, at the ends of steps; the impulsive part is a mean
/// over a step, and is averaged with that of the next step to give the value at its end.
fn history(chord_panels: usize, way_panels: f64, semi_chords: f64, gust: Option<Gust>) -> Vec<(f64, f64)> {
    const ANGLE_RAD: f64 = 0.01;
    let step_s = way_panels / chord_panels as f64 / SPEED_M_S;
    let steps = (0.5 * semi_chords / (SPEED_M_S * step_s)).ceil() as usize + 1;
    let (mut wing, width_m) = plane_wing(chord_panels, steps);
    match gust {
        Some(gust) => wing.gusts = vec![gust],
        None => wing = wing.with_incidence(ANGLE_RAD),
    }
    wing.start(false);
    let scale_n = pressure_pa() * width_m * TAU * ANGLE_RAD;
    let mut parts = Vec::new();
    for _ in 0..steps {
        wing.step(step_s);
        let (circulatory, impulsive) = (&wing.loads.circulatory[MIDDLE], &wing.loads.impulsive[MIDDLE]);
        parts.push((2.0 * SPEED_M_S * wing.time_s, circulatory.force_n.z / scale_n, impulsive.force_n.z / scale_n));
    }
    parts.windows(2).map(|pair| (pair[0].0, pair[0].1 + 0.5 * (pair[0].2 + pair[1].2))).collect()
}

/// Largest difference from a function between two positions.
fn worst(history: &[(f64, f64)], from: f64, theory: impl Fn(f64) -> f64) -> f64 {
    history.iter().filter(|(s, _)| *s >= from).map(|(s, lift)| (lift - theory(*s)).abs()).fold(0.0, f64::max)
}

/// U-10. Sudden start against Wagner from half a chord to 5 chords of travel: first order in panels, at every ratio of step to panel. The
/// limit is that of a first-order method with 16 panels: half a panel of travel changes the lift by 0.01.
#[test]
fn u10_sudden_start_follows_wagner() {
    for way_panels in [1.0, 0.25] {
        let errors = [4, 8, 16].map(|panels| worst(&history(panels, way_panels, 10.0, None), 1.0, wagner));
        println!("U-10 way {way_panels} panels: {errors:.4?}");
        assert!(errors[0] > 1.4 * errors[1] && errors[1] > 1.4 * errors[2], "no convergence: {errors:?}");
        assert!(errors[2] < 0.02, "{errors:?}");
    }
}

/// U-11. Sharp-edged gust, stationary in the air, against Küssner. While it passes the chord, the lift grows with the square root of the
/// distance and the gust reaches one panel after the other: the error varies with the square root of the panel size; after it has passed
/// the trailing edge the error falls faster.
#[test]
fn u11_sharp_gust_follows_kuessner() {
    let gust = Gust {
        name: "edge".into(),
        shape: GustShape::SharpEdge,
        velocity_m_s: Vector3::z() * 0.01 * SPEED_M_S,
        direction: -Vector3::y(),
        speed_m_s: SPEED_M_S,
        origin_m: Vector3::y() * 0.25,
        start_s: 0.0,
    };
    let histories = [4, 8, 16].map(|panels| history(panels, 0.5, 10.0, Some(gust.clone())));
    for (from, limit) in [(0.0, 0.05), (3.0, 0.02)] {
        let errors = histories.each_ref().map(|history| worst(history, from, kuessner));
        println!("U-11 from {from} semi-chords on: {errors:.4?}");
        assert!(errors[0] > 1.4 * errors[1] && errors[1] > 1.4 * errors[2], "no convergence: {errors:?}");
        assert!(errors[2] < limit, "{errors:?}");
    }
}

/// Amplitudes of lift and moment (nose-up, quarter chord) per span in harmonic heave (m, down) or pitch (rad, nose-up).
fn harmonic(k: f64, heave_m: f64, pitch_rad: f64, chord_panels: usize, way_panels: f64) -> [Complex<f64>; 2] {
    let omega = k * SPEED_M_S / 0.5;
    let step_s = way_panels / chord_panels as f64 / SPEED_M_S;
    let period = (TAU / omega / step_s).ceil() as usize;
    // a whole number of steps per period, so that the Fourier sums are exact
    let step_s = TAU / omega / period as f64;
    let periods = if k < 0.1 { 2 } else { 4 };
    let (mut wing, width_m) = plane_wing(chord_panels, periods * period);
    let pose = |motions: &mut [SectionMotion], time_s: f64| {
        let (sine, cosine) = (omega * time_s).sin_cos();
        for motion in motions {
            motion.position_m.z = -heave_m * sine;
            motion.velocity_m_s.z = -heave_m * omega * cosine;
            motion.rotation = Rotation3::from_axis_angle(&Vector3::x_axis(), pitch_rad * sine).into_inner();
            motion.spin_rad_s = Vector3::x() * (pitch_rad * omega * cosine);
        }
    };
    pose(&mut wing.motions, 0.0);
    wing.start(false);
    let mut sums = [Complex::new(0.0, 0.0); 2];
    for step in 1..=periods * period {
        let time_s = step as f64 * step_s;
        pose(&mut wing.motions, time_s);
        wing.step(step_s);
        if step > (periods - 1) * period {
            // `sin ωt` is the real part of `−i e^(iωt)`; the impulsive loads belong to the middle of the step
            let weight =
                |time_s: f64| Complex::from_polar(2.0 / period as f64, -omega * time_s) * Complex::i() / width_m;
            let (now, middle) = (weight(time_s), weight(time_s - 0.5 * step_s));
            let (circulatory, impulsive) = (&wing.loads.circulatory[MIDDLE], &wing.loads.impulsive[MIDDLE]);
            sums[0] += now * circulatory.force_n.z + middle * impulsive.force_n.z;
            sums[1] += now * circulatory.moment_n_m.x + middle * impulsive.moment_n_m.x;
        }
    }
    sums
}

/// U-12. Harmonic heave and pitch against Theodorsen: amplitude and phase of the lift, and the complex error of the moment about the
/// quarter chord relative to the theoretical lift times the semi-chord. Steps of half a panel; the errors fall with the number of panels;
/// at `k = 1` a period has 50 steps with 8 panels. Short studies: `k` of 0.5 and 1.
#[test]
fn u12_harmonic_motion_follows_theodorsen() {
    let aerofoil = Aerofoil { density_kg_m3: DENSITY_KG_M3, speed_m_s: SPEED_M_S, semi_chord_m: 0.5, axis: -0.5 };
    for (name, heave_m, pitch_rad) in [("heave", 0.01, 0.0), ("pitch", 0.0, 0.01)] {
        // the wake of slow motions takes long to settle
        for k in [1.0, 0.5, 0.2, 0.05].into_iter().take(if is_whole() { 4 } else { 2 }) {
            let (heave, pitch) = (Complex::new(heave_m, 0.0), Complex::new(pitch_rad, 0.0));
            let theory = aerofoil.response(theodorsen(k), k, heave, pitch);
            let way_panels = if k < 0.1 { 1.0 } else { 0.5 };
            let errors = [4, 8].map(|panels| {
                let [lift, moment] = harmonic(k, heave_m, pitch_rad, panels, way_panels);
                let ratio = lift / theory.lift_n_m();
                let moment = (moment - theory.moment_n()).norm() / (0.5 * theory.lift_n_m().norm());
                println!(
                    "U-12 {name} k {k} {panels} panels: amplitude {:+.4}, phase {:+.2} deg, moment {moment:.4}",
                    ratio.norm() - 1.0,
                    ratio.arg().to_degrees()
                );
                [(ratio - 1.0).norm(), moment]
            });
            assert!(errors[0][0] > 1.4 * errors[1][0], "{name} {k}: the lift does not converge: {errors:?}");
            assert!(errors[1][0] < 0.03, "{name} {k}: lift {errors:?}");
            // first order in panels, from an error of 0.07 with four panels at the highest frequencies
            assert!(errors[0][1] > 1.4 * errors[1][1], "{name} {k}: the moment does not converge: {errors:?}");
            assert!(errors[1][1] < 0.06, "{name} {k}: moment {errors:?}");
        }
    }
}

/// Apparent mass in kg of a rectangular plate of chord 1 m, from a start in still air.
fn apparent_mass_kg(places_m: &[f64], chord_panels: usize, section: Option<usize>) -> f64 {
    let mut wing = Wing::new(places_m, |_| 1.0, chord_panels, options());
    wing.wind_m_s = Vector3::zeros();
    wing.start(false);
    wing.motions.iter_mut().for_each(|motion| motion.velocity_m_s = Vector3::z());
    wing.step(1.0);
    let force_n = |load: &foldwing::load::Wrench| -load.force_n.z;
    section.map_or_else(|| wing.loads.impulsive.iter().map(force_n).sum(), |at| force_n(&wing.loads.impulsive[at]))
}

/// U-13. A plate in plane flow has the apparent mass `πρb²` with any number of panels: with the last vortex on the edge the sums are exact.
/// The tolerance allows for the finite span, and for segments 2000 chords long, which lose six digits.
#[test]
fn u13_apparent_mass_in_plane_flow() {
    let places_m = inset(PLANE, PLANE_STRIPS);
    for panels in [1, 4, 10] {
        let ratio = apparent_mass_kg(&places_m, panels, Some(MIDDLE))
            / ((places_m[1] - places_m[0]) * PI * DENSITY_KG_M3 * 0.25);
        println!("U-13 {panels} panels: {ratio:.7}");
        assert!((ratio - 1.0).abs() < 1e-5, "{panels} panels: {ratio}");
    }
}

/// U-14. Rectangular plates broadside: coefficients of `π/4 ρ a² b` from DNV-RP-H103 (2011), table A-2, given to three digits.
#[test]
fn u14_apparent_mass_of_rectangles() {
    for (ratio, expected) in [(2.0, 0.757), (4.0, 0.872), (10.0, 0.947)] {
        let values = [8, 16].map(|panels| {
            let mass_kg = apparent_mass_kg(&inset(ratio, 2 * panels), panels, None);
            mass_kg / (PI / 4.0 * DENSITY_KG_M3 * ratio)
        });
        println!("U-14 ratio {ratio}: {values:.4?} for {expected}");
        assert!((values[1] / expected - 1.0).abs() < 0.01, "{ratio}: {values:?}");
    }
}

/// Lift in N of a wing of aspect ratio 6 after a sudden start, after 4 chords and at the end.
fn started(angle_rad: f64, wake: WakeModel, wake_rows: usize, steps: usize) -> f64 {
    let rule = LatticeOptions { wake, wake_rows, ..options() };
    let mut wing = Wing::new(&inset(6.0, 12), |_| 1.0, 4, rule).with_incidence(angle_rad);
    wing.start(false);
    (0..steps).for_each(|_| wing.step(0.25 / SPEED_M_S));
    wing.circulatory_n().z + wing.impulsive_n().z
}

/// U-15. The effect of a free wake on lift divided by angle is of second order in the angle: it vanishes for small loads.
#[test]
fn u15_free_wake_tends_to_the_prescribed_one() {
    let change = |angle_rad| {
        let [prescribed_n, free_n] =
            [WakeModel::Prescribed, WakeModel::Free].map(|wake| started(angle_rad, wake, 40, 40));
        (free_n / prescribed_n - 1.0).abs()
    };
    let changes = [change(0.01), change(0.02), change(0.1)];
    println!("U-15 {changes:?}");
    assert!(changes[0] < 1e-4 && changes[2] < 0.01, "{changes:?}");
    assert!((3.0..5.0).contains(&(changes[1] / changes[0])), "not the second power: {changes:?}");
}

/// Lift in N during the last of three periods of heave with `k = 0.2`, for a wing of aspect ratio 6 with a wake of a number of chords.
fn heaving(wake_chords: usize) -> Vec<f64> {
    const PERIOD: usize = 64;
    let rule = LatticeOptions { wake_rows: 4 * wake_chords, ..options() };
    let mut wing = Wing::new(&inset(6.0, 12), |_| 1.0, 4, rule);
    wing.start(false);
    let step_s = TAU / (0.2 * SPEED_M_S / 0.5) / PERIOD as f64;
    let lift_n = |step: usize| {
        let (sine, cosine) = (TAU * step as f64 / PERIOD as f64).sin_cos();
        for motion in &mut wing.motions {
            (motion.position_m.z, motion.velocity_m_s.z) = (0.1 * sine, 0.4 * cosine);
        }
        wing.step(step_s);
        wing.circulatory_n().z + wing.impulsive_n().z
    };
    (1..=3 * PERIOD).map(lift_n).skip(2 * PERIOD).collect()
}

/// U-16. Error of a short wake, whose last ring represents all older rows: largest difference in the lift of a heaving wing relative to its
/// amplitude, with 1, 2, 5, 10 and 20 chords of wake against all 47, and of the steady lift after a sudden start.
#[test]
fn u16_short_wake() {
    let all_n = heaving(50);
    let amplitude_n = all_n.iter().fold(0.0, |most: f64, lift| most.max(lift.abs()));
    let errors = [1, 2, 5, 10, 20].map(|chords| {
        let kept_n = heaving(chords);
        kept_n.iter().zip(&all_n).map(|(kept, all)| (kept - all).abs()).fold(0.0, f64::max) / amplitude_n
    });
    println!("U-16 heaving, 1, 2, 5, 10, 20 chords kept: {errors:.5?}");
    assert!(errors[0] > errors[2] && errors[2] > errors[4], "{errors:?}");
    assert!(errors[3] < 0.01 && errors[4] < 3e-3, "{errors:?}");
    let [short_n, long_n] = [2, 60].map(|chords| started(0.02, WakeModel::Prescribed, 4 * chords, 240));
    println!("U-16 steady: {:.1e}", short_n / long_n - 1.0);
    assert!((short_n / long_n - 1.0).abs() < 1e-4, "{short_n} {long_n}");
}
