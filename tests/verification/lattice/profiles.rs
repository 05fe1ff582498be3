//! Profiles in the lattice: camber, lift slope, drag, moment, and polars with stall.

use crate::counting_allocator::allocations;
use crate::lattice::wing::{SPEED_M_S, Wing, inset, options, pressure_pa};
use foldwing::aero::lattice::{LatticeOptions, LoadRule};
use foldwing::aero::near_sheets::NoCirculation;
use foldwing::aero::polar::{Polar, PolarRow};
use foldwing::aero::surface::Profile;
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};

fn suction() -> LatticeOptions {
    LatticeOptions { load_rule: LoadRule::KuttaJoukowski, ..options() }
}

/// A cambered profile that stalls gently at 12°, tabulated every degree.
fn stalling() -> Polar {
    let row = |degrees: i32| {
        let angle_rad = f64::from(degrees).to_radians();
        let attached = 5.7 * (angle_rad + 0.05);
        let lift =
            if attached.abs() < 1.1 { attached } else { attached.signum() * (1.1 + 0.15 * (attached.abs() - 1.1)) };
        PolarRow { angle_rad, lift, drag: 0.01 + 0.4 * angle_rad.powi(2), moment: -0.06 - 0.03 * angle_rad }
    };
    Polar { rows: (-40..=40).map(row).collect() }
}

fn of_polar(polar: Polar) -> Profile {
    Profile { polar: Some(polar), ..Profile::THIN }
}

/// Coefficients of lift, drag and moment about the quarter chord of a wing of chord 1 m at an angle of attack.
fn coefficients(profile: Profile, places_m: &[f64], chord_panels: usize, angle_rad: f64) -> [f64; 3] {
    let mut wing = Wing::with_profile(profile, places_m, |_| 1.0, chord_panels, suction()).with_incidence(angle_rad);
    wing.start(true);
    let area_pa = pressure_pa() * (places_m[places_m.len() - 1] - places_m[0]);
    let force_n = wing.circulatory_n();
    let along = wing.wind_m_s / SPEED_M_S;
    let across = Vector3::x().cross(&along);
    let moment_n_m: f64 = wing.loads.circulatory.iter().map(|load| load.moment_n_m.x).sum();
    [-force_n.dot(&across), force_n.dot(&along), moment_n_m].map(|value| value / area_pa)
}

/// U-57. A wing of aspect ratio 20 000 has the coefficients of its polar at every angle, before and beyond stall, and those of a profile
/// with lift slope, camber, drag and moment. The effect of the finite span is of the order of 2 divided by the aspect ratio, 1e-4; the
/// remaining difference is due to the linear interpolation of the polar, up to 2.4e-4.
#[test]
fn u57_an_endless_wing_has_its_polar() {
    let places_m = inset(2e4, 8);
    for degrees in [-25.0, -8.0, 0.0, 3.3, 9.0, 12.5, 20.0, 35.0_f64] {
        let angle_rad = degrees.to_radians();
        let polar = stalling();
        let row = polar.at(angle_rad);
        let straight = Profile {
            lift_slope_1_rad: 5.5,
            zero_lift_angle_rad: -0.07,
            moment_coefficient: -0.08,
            drag_coefficient: 0.02,
            ..Profile::THIN
        };
        let lift = 5.5 * (angle_rad + 0.07).sin();
        for (profile, expected) in
            [(of_polar(polar), [row.lift, row.drag, row.moment]), (straight, [lift, 0.02, -0.08])]
        {
            for chord_panels in [1, 4] {
                let found = coefficients(profile.clone(), &places_m, chord_panels, angle_rad);
                let off: Vec<f64> = found.iter().zip(expected).map(|(found, expected)| found - expected).collect();
                println!("U-57 {degrees} deg, {chord_panels} panels: {found:.5?}, off {off:?}");
                assert!(off.iter().all(|off| off.abs() < 5e-4), "{degrees} deg: {found:?} for {expected:?}");
            }
        }
    }
}

/// Wind at an angle of attack.
fn wind_at(angle_rad: f64) -> Vector3<f64> {
    Vector3::new(0.0, -angle_rad.cos(), angle_rad.sin()) * SPEED_M_S
}

/// Normal velocity at three quarters of the chord in the middle of the strips of a straight wing of chord 1 m, per unit circulation of each
/// strip: horseshoes with legs along the chord to the trailing edge and along the wind from there on.
fn horseshoes(places_m: &[f64], wind_m_s: Vector3<f64>) -> Vec<Vec<f64>> {
    let far_m = |point_m: &Vector3<f64>| point_m + wind_m_s * 1e6;
    let segment = |at: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>| {
        let (r, s) = (at - from, at - to);
        let size = r.norm() * s.norm();
        r.cross(&s) * ((r.norm() + s.norm()) / (size * (size + r.dot(&s)) * 2.0 * TAU))
    };
    let horseshoe = |at: &Vector3<f64>, ends: &[f64]| {
        let [inner, outer] = [ends[0], ends[1]].map(|x| [Vector3::new(x, 0.0, 0.0), Vector3::new(x, -0.75, 0.0)]);
        segment(at, &far_m(&inner[1]), &inner[1])
            + segment(at, &inner[1], &inner[0])
            + segment(at, &inner[0], &outer[0])
            + segment(at, &outer[0], &outer[1])
            + segment(at, &outer[1], &far_m(&outer[1]))
    };
    let points = places_m.windows(2).map(|ends| Vector3::new(0.5 * (ends[0] + ends[1]), -0.5, 0.0));
    points.map(|at| places_m.windows(2).map(|ends| horseshoe(&at, ends).z).collect()).collect()
}

/// Circulations in m²/s that a polar gives for strips at their effective incidence, which excludes their own plane vortices (Weissinger).
fn of_what_they_meet(
    polar: &Polar,
    wind_m_s: Vector3<f64>,
    influence: &[Vec<f64>],
    circulation_m2_s: &[f64],
) -> Vec<f64> {
    let strips = influence.iter().zip(circulation_m2_s);
    let wanted = strips.map(|(row, own)| {
        let induced_m_s: f64 = row.iter().zip(circulation_m2_s).map(|(entry, other)| entry * other).sum();
        let through_m_s = wind_m_s.z + induced_m_s + own / PI;
        let lift = polar.at(through_m_s.atan2(-wind_m_s.y)).lift;
        0.5 * through_m_s.hypot(wind_m_s.y) * lift
    });
    wanted.collect()
}

/// Circulations in m²/s of a lifting line with a polar for a straight wing of chord 1 m, by under-relaxed iteration.
fn lifting_line(polar: &Polar, places_m: &[f64], angle_rad: f64) -> Vec<f64> {
    let wind_m_s = wind_at(angle_rad);
    let influence = horseshoes(places_m, wind_m_s);
    let mut circulation = vec![0.0; influence.len()];
    for _ in 0..4000 {
        let wanted = of_what_they_meet(polar, wind_m_s, &influence, &circulation);
        circulation.iter_mut().zip(&wanted).for_each(|(now, wanted)| *now += 0.1 * (wanted - *now));
    }
    circulation
}

/// U-58. Wings of aspect ratios 4 and 16 with one panel along the chord against an independent lifting line with the same polar, attached,
/// at the onset of stall and beyond: every strip agrees to 1e-6, the effect of the vortex core and the length of the straight wake. With
/// four and eight panels along the chord the lift differs from one panel's by less than 2 %, the lifting-surface effect, and from each
/// other by less than 0.5 %.
#[test]
fn u58_polar_against_a_lifting_line() {
    let polar = stalling();
    for (span_m, degrees) in [4.0, 16.0].into_iter().flat_map(|span| [4.0, 10.0, 14.0, 20.0].map(|at| (span, at))) {
        let angle_rad: f64 = f64::to_radians(degrees);
        let places_m = inset(span_m, 24);
        let expected = lifting_line(&polar, &places_m, angle_rad);
        let mut wing = Wing::with_profile(of_polar(polar.clone()), &places_m, |_| 1.0, 1, suction());
        wing = wing.with_incidence(angle_rad);
        wing.start(true);
        let largest = expected.iter().fold(0.0_f64, |most, value| most.max(*value));
        let strips = expected.iter().enumerate();
        let offs = strips.map(|(strip, value)| (wing.lattice.strip_circulation(&wing.from, 0, strip) - value).abs());
        let off = offs.fold(0.0, f64::max) / largest;
        let lifts =
            [1, 4, 8].map(|chord_panels| coefficients(of_polar(polar.clone()), &places_m, chord_panels, angle_rad)[0]);
        println!("U-58 {degrees} deg, aspect ratio {span_m}: off {off:.1e}, lift with 1, 4, 8 panels {lifts:.5?}");
        assert!(off < 1e-6, "{span_m} {degrees}: {off:e}");
        assert!((lifts[0] / lifts[1] - 1.0).abs() < 0.02 && (lifts[1] / lifts[2] - 1.0).abs() < 5e-3, "{lifts:?}");
    }
}

/// U-59. Identities: a polar equal to the lift line of the plate changes nothing beyond the interpolation error between its rows, 1e-5;
/// profile drag alone changes no circulation; a wing with its zero-lift line rotated by 3° has the lift of a plate rotated by 3°, apart
/// from the effect of the different position of its vortices.
#[test]
fn u59_profiles_that_are_plates() {
    let places_m = inset(6.0, 12);
    let found = |profile: Profile, degrees: f64| coefficients(profile, &places_m, 4, degrees.to_radians());
    let row = |i: i32| {
        let angle_rad = 0.005 * f64::from(i);
        PolarRow { angle_rad, lift: TAU * angle_rad.sin(), drag: 0.0, moment: 0.0 }
    };
    let plate = found(Profile::THIN, 5.0);
    let own = found(of_polar(Polar { rows: (-100..=100).map(row).collect() }), 5.0);
    let dragging = found(Profile { drag_coefficient: 0.02, ..Profile::THIN }, 5.0);
    let (turned, cambered) =
        (found(Profile::THIN, 3.0), found(Profile { zero_lift_angle_rad: -3f64.to_radians(), ..Profile::THIN }, 0.0));
    println!("U-59 plate {plate:?}, polar {own:?}, with drag {dragging:?}, turned {turned:?}, cambered {cambered:?}");
    assert!(plate.iter().zip(&own).all(|(plate, own)| (plate - own).abs() < 1e-5));
    // drag acts along the local flow deflected by the lattice, a small angle from the wind
    let induced_rad = 2.0 * plate[0] / (PI * 6.0);
    assert!((dragging[1] - plate[1] - 0.02).abs() < 1e-4 && (dragging[0] - plate[0]).abs() < 0.02 * induced_rad);
    assert!((cambered[0] / turned[0] - 1.0).abs() < 5e-3);
}

/// U-60. Wings that enter and leave stall, with taper and a fold: every step finds its circulation, allocates nothing, and repeated from a
/// saved state gives bit-identical results.
#[test]
fn u60_steps_through_stall_repeat_and_do_not_allocate() {
    let places_m = inset(8.0, 12);
    let new = || {
        let chord_m = |x: f64| 1.0 - 0.06 * x.abs();
        let options = LatticeOptions { wake_rows: 12, ..suction() };
        let mut wing = Wing::with_profile(of_polar(stalling()), &places_m, chord_m, 3, options);
        for motion in &mut wing.motions[8..] {
            motion.position_m.z = 0.8 * (motion.position_m.x - places_m[8]);
        }
        wing.start(true);
        wing
    };
    let go = |wing: &mut Wing, steps: std::ops::Range<i32>| -> Vec<f64> {
        steps
            .map(|step| {
                let pitch_rad = 0.4 * (0.3 * f64::from(step)).sin();
                wing.wind_m_s = Vector3::new(0.0, -pitch_rad.cos(), pitch_rad.sin()) * SPEED_M_S;
                let before = allocations();
                wing.step(0.02);
                assert_eq!(allocations(), before, "step {step}");
                wing.circulatory_n().z
            })
            .collect()
    };
    let mut wing = new();
    go(&mut wing, 0..10);
    let (kept, time_s) = (wing.from.clone(), wing.time_s);
    let first = go(&mut wing, 10..40);
    wing.from.copy_from(&kept);
    wing.time_s = time_s;
    assert_eq!(first, go(&mut wing, 10..40));
    let mut other = new();
    other.from.copy_from(&kept);
    other.time_s = time_s;
    assert_eq!(first, go(&mut other, 10..40));
    let largest = first.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
    println!("U-60 largest lift {:.3} of the pressure and area", largest / (pressure_pa() * 6.6));
    // a plate would have 1.9 at 0.4 rad
    assert!((0.9..1.3).contains(&(largest / (pressure_pa() * 6.6))));
}

/// U-61. Polars whose lift drops by up to four fifths within two degrees: neighbouring strips can be on either side of the drop, and the
/// equations can have many solutions. At every angle of a sweep the lattice finds a solution whose strips have the lift of the polar at
/// their angle (so that the lift of the wing lies between the extremes of the polar), or reports an error that names the cause.
#[test]
fn u61_sharp_stall_is_solved_or_refused() {
    let places_m = inset(8.0, 24);
    let (mut solved, mut refused) = (0, 0);
    for drop in [0.2, 0.5, 0.8] {
        let row = |degrees: i32| {
            let lift = 0.1 * f64::from(degrees.clamp(-12, 12)) * if degrees.abs() >= 14 { 1.0 - drop } else { 1.0 };
            PolarRow { angle_rad: f64::from(degrees).to_radians(), lift, drag: 0.01, moment: 0.0 }
        };
        let polar = Polar { rows: (-60..=60).step_by(2).map(row).collect() };
        let mut wing = Wing::with_profile(of_polar(polar), &places_m, |_| 1.0, 2, suction());
        for degrees in 0..=40 {
            let angle_rad = 0.5 * f64::from(degrees).to_radians();
            wing.wind_m_s = Vector3::new(0.0, -angle_rad.cos(), angle_rad.sin()) * SPEED_M_S;
            match wing.try_start(true) {
                Ok(()) => {
                    solved += 1;
                    let largest = (0..24)
                        .map(|strip| wing.lattice.strip_circulation(&wing.from, 0, strip) * 2.0 / SPEED_M_S)
                        .fold(0.0, f64::max);
                    assert!(largest < 1.2 * 1.05, "{drop} {degrees}: {largest}");
                }
                Err(error) => {
                    refused += 1;
                    assert_eq!(error, NoCirculation::Profile(0));
                }
            }
        }
        println!("U-61 drop {drop}: {solved} solved, {refused} refused so far");
    }
    // nine were rejected before relaxation, decisions 0044 and 0051
    assert!(solved == 123 && refused == 0, "{solved} {refused}");
}

/// A polar whose lift drops by a third within three degrees, like that of a thin profile at a low Reynolds number.
fn breaking_down() -> Polar {
    let row =
        |degrees: f64, lift: f64, drag: f64| PolarRow { angle_rad: degrees.to_radians(), lift, drag, moment: 0.0 };
    let rows = [(0.0, 0.0, 0.01), (11.0, 1.05, 0.03), (14.0, 0.7, 0.15), (25.0, 0.75, 0.4), (90.0, 0.0, 1.2)];
    let up = rows.iter().map(|(at, lift, drag)| row(*at, *lift, *drag));
    let down = rows.iter().skip(1).rev().map(|(at, lift, drag)| row(-at, -lift, *drag));
    Polar { rows: down.chain(up).collect() }
}

/// U-76. A wing whose polar has an abrupt stall, with one panel along the chord, at 8 to 30°: the steady flow is found at all angles, and
/// every strip has the lift of its polar at the effective incidence computed from an independent row of horseshoes (1e-6 as in U-58). A run
/// from rest continues past stall, with a lag at some of the angles; in attached flow there is no lag.
#[test]
fn u76_polars_that_break_down() {
    let polar = breaking_down();
    let mut lagged = 0;
    for degrees in [8.0, 12.0, 14.0, 16.0, 20.0, 30.0] {
        let angle_rad = f64::to_radians(degrees);
        let (places_m, wind_m_s) = (inset(8.0, 20), wind_at(angle_rad));
        let influence = horseshoes(&places_m, wind_m_s);
        let make = || {
            let wing = Wing::with_profile(of_polar(polar.clone()), &places_m, |_| 1.0, 1, suction());
            wing.with_incidence(angle_rad)
        };
        let off = |wing: &Wing| {
            let found: Vec<f64> = (0..20).map(|strip| wing.lattice.strip_circulation(&wing.from, 0, strip)).collect();
            let wanted = of_what_they_meet(&polar, wind_m_s, &influence, &found);
            found.iter().zip(&wanted).map(|(found, wanted)| (found - wanted).abs()).fold(0.0, f64::max) / SPEED_M_S
        };
        let mut steady = make();
        steady.start(true);
        let mut run = make();
        run.start(false);
        let mut lags = false;
        for _ in 0..100 {
            run.step(0.25 / SPEED_M_S);
            lags |= run.from.lags;
        }
        lagged += usize::from(lags);
        println!("U-76 {degrees} deg: steady off {:.1e}, run off {:.1e}, lag {lags}", off(&steady), off(&run));
        assert!(off(&steady) < 1e-6, "{degrees} deg");
        assert!(!lags || degrees > 11.0, "{degrees} deg: the attached wing lags");
    }
    assert!(lagged > 0, "no case beyond what Newton's iteration finds");
}

/// Largest difference between the circulations of a run and those that a polar gives with the velocities induced by independent horseshoes,
/// divided by the wind speed.
fn off_polar(wing: &Wing, polar: &Polar, influence: &[Vec<f64>]) -> f64 {
    let strips = 0..influence.len();
    let found: Vec<f64> = strips.map(|strip| wing.lattice.strip_circulation(&wing.from, 0, strip)).collect();
    let wanted = of_what_they_meet(polar, wing.wind_m_s, influence, &found);
    found.iter().zip(&wanted).map(|(found, wanted)| (found - wanted).abs()).fold(0.0, f64::max) / SPEED_M_S
}

/// U-77. A run ends in the steady flow with the polar, whatever its step: a wing of aspect ratio 8 with an abruptly stalling polar, started
/// from rest at pitches from -20 to 20 degrees, after 60 chords in steps of one chord and of half a chord. The remaining effect of the
/// starting vortex, which at 60 chords induces (4/60)^2/2 of the downwash, is 2e-4 for circulations up to 0.55 times wind and chord; a
/// thousandth of the lift is 4e-4 of them. The end used to be 3e-3 to 2e-2 off: the chordwise speed included the velocity induced by the
/// part of the wake that the step did not count as bound, and without a lag, strips on the falling part of the polar do not settle.
#[test]
fn u77_a_run_ends_on_the_polar() {
    let polar = breaking_down();
    let places_m = inset(8.0, 16);
    for degrees in [-20.0, -14.0, -12.0, 6.0, 12.0, 14.0, 16.0, 20.0] {
        let angle_rad = f64::to_radians(degrees);
        let influence = horseshoes(&places_m, wind_at(angle_rad));
        for chords in [1.0, 0.5] {
            let wing = Wing::with_profile(of_polar(polar.clone()), &places_m, |_| 1.0, 1, suction());
            let mut wing = wing.with_incidence(angle_rad);
            wing.start(false);
            (0..(60.0 / chords) as usize).for_each(|_| wing.step(chords / SPEED_M_S));
            let off = off_polar(&wing, &polar, &influence);
            let lift: f64 = (0..16).map(|strip| wing.lattice.strip_circulation(&wing.from, 0, strip)).sum();
            println!(
                "U-77 {degrees} deg, steps of {chords}: off {off:.1e}, mean {:.5}, lag {}",
                lift / 160.0,
                wing.from.lags
            );
            assert!(off < 4e-4, "{degrees} deg, steps of {chords}: {off:e}");
            // stalled strips keep their lag, attached strips never have one
            assert_eq!(wing.from.lags, wing.lattice.surfaces_beyond_stall(&wing.from).count() > 0, "{degrees} deg");
        }
    }
}

/// U-78. In the limit of high aspect ratio the lift is that of a polar with abrupt stall at every pitch of a sweep from -20 to 20 degrees:
/// the effect of the span is of the order of 2 divided by the aspect ratio, 1e-4 at 20 000. The steady flow continued from that of the
/// previous degree is the same: strips as wide as these have a unique circulation. Strips as narrow as a chord do not: there each strip has
/// the lift of its polar in upward and downward sweeps.
#[test]
fn u78_pitch_sweeps_with_a_polar_that_breaks_down() {
    let polar = breaking_down();
    let wide_m = inset(2e4, 8);
    let mut wing = Wing::with_profile(of_polar(polar.clone()), &wide_m, |_| 1.0, 1, suction());
    wing.start(true);
    for degrees in (-20..=20).step_by(2).map(f64::from) {
        let angle_rad = f64::to_radians(degrees);
        let cold = coefficients(of_polar(polar.clone()), &wide_m, 1, angle_rad)[0];
        wing.wind_m_s = wind_at(angle_rad);
        wing.go_on().unwrap_or_else(|error| panic!("{degrees} deg: {error:?}"));
        let warm = -wing.circulatory_n().dot(&Vector3::x().cross(&(wing.wind_m_s / SPEED_M_S)))
            / (pressure_pa() * (wide_m[8] - wide_m[0]));
        let expected = polar.at(angle_rad).lift;
        assert!(
            (cold - expected).abs() < 5e-4 && (warm - expected).abs() < 5e-4,
            "{degrees} deg: {cold} {warm} {expected}"
        );
    }
    let places_m = inset(8.0, 20);
    let mut narrow = Wing::with_profile(of_polar(polar.clone()), &places_m, |_| 1.0, 1, suction());
    narrow.start(true);
    let mut several = 0.0_f64;
    let mut up = Vec::new();
    for degrees in (-20..=20).chain((-20..20).rev()).map(f64::from) {
        narrow.wind_m_s = wind_at(degrees.to_radians());
        narrow.go_on().unwrap_or_else(|error| panic!("{degrees} deg: {error:?}"));
        let off = off_polar(&narrow, &polar, &horseshoes(&places_m, narrow.wind_m_s));
        assert!(off < 1e-6, "{degrees} deg: {off:e}");
        let lift: f64 = (0..20).map(|strip| narrow.lattice.strip_circulation(&narrow.from, 0, strip)).sum();
        match up.iter().find(|(at, _)| *at == degrees) {
            Some((_, before)) => several = several.max(f64::abs(lift - before) / 200.0),
            None => up.push((degrees, lift)),
        }
    }
    println!("U-78 lift on the way down less that on the way up, the largest: {several:.3}");
    assert!(several > 1e-3, "a polar that breaks down has several circulations: {several:e}");
}
