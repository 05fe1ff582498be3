//! Control surfaces in the lattice: against an independent lattice, thin-aerofoil theory, and other cases of the lattice itself.

use crate::lattice::wing::{DENSITY_KG_M3, SPEED_M_S, Wing, options};
use foldwing::aero::flap::{Deflection, Flap};
use foldwing::aero::lattice::LoadRule;
use nalgebra::Vector3;
use serde_json::Value;

/// Spanwise positions of sections for consecutive parts `[end, count]`, tips inset by a quarter of a strip.
fn places(parts: &[(f64, usize)]) -> Vec<f64> {
    let (mut places, mut begin) = (Vec::new(), 0.0);
    for (index, &(end, count)) in parts.iter().enumerate() {
        let last = index + 1 == parts.len();
        let inset = [if index == 0 { 0.25 } else { 0.0 }, if last { 0.25 } else { 0.0 }];
        let width = (end - begin) / (count as f64 + inset[0] + inset[1]);
        places.extend((0..count + usize::from(last)).map(|i| begin + (inset[0] + i as f64) * width));
        begin = end;
    }
    places
}

fn flap(strips: std::ops::Range<usize>, hinge_fraction: f64) -> Flap {
    Flap {
        name: "flap".into(),
        surface: 0,
        strips,
        hinge_fraction,
        lower_rad: -1.0,
        upper_rad: 1.0,
        command_rad: 0.0,
        downward: 1.0,
    }
}

/// Lift, rolling moment about the middle and hinge moment per angle, divided by density and the square of the speed.
fn steady(wing: &mut Wing, span_m: f64, angle_rad: f64) -> [f64; 3] {
    wing.lattice.deflect(&[Deflection { angle_rad, rate_rad_s: 0.0 }]);
    wing.start(true);
    let scale = 1.0 / (DENSITY_KG_M3 * SPEED_M_S * SPEED_M_S * angle_rad);
    let lift_n = wing.circulatory_n().z;
    let sections = wing.loads.circulatory.iter().zip(&wing.motions);
    let roll_n_m: f64 = sections
        .map(|(load, motion)| {
            let moment_n_m = load.moment_n_m - (Vector3::x() * (0.5 * span_m) - motion.position_m).cross(&load.force_n);
            -moment_n_m.y
        })
        .sum();
    [lift_n, roll_n_m, wing.from.hinges[0].circulatory_n_m].map(|value| value * scale)
}

/// U-42. Lift, rolling moment and hinge moment of control surfaces over the whole span and of an outer aileron on a tapered wing compared
/// with a lattice of horseshoes in numpy: `tests/reference/flaps/vortex_lattice.py`. Both load formulas (pressure and suction); the
/// tolerance is 0.1 %.
#[test]
fn u42_flaps_agree_with_an_independent_lattice() {
    let reference: Value =
        serde_json::from_str(include_str!("../../reference/flaps/vortex_lattice.json")).expect("JSON");
    for case in reference["cases"].as_array().expect("cases") {
        for load_rule in [LoadRule::Bernoulli, LoadRule::KuttaJoukowski] {
            let panels = case["chord_panels"].as_u64().expect("a count") as usize;
            let (mut wing, span_m) = wing_of(case, load_rule, panels);
            for row in case["results"].as_array().expect("results") {
                let angle_deg = row["angle_deg"].as_f64().expect("an angle");
                let found = steady(&mut wing, span_m, angle_deg.to_radians());
                let expected = ["lift", "roll", "hinge_moment"].map(|key| row[key].as_f64().expect("a number"));
                let off: Vec<f64> =
                    (0..3).map(|i| (found[i] - expected[i]).abs() / expected[0].abs().max(expected[i].abs())).collect();
                let relative = (found[2] / expected[2] - 1.0).abs();
                println!(
                    "U-42 {} {load_rule:?} {angle_deg} deg, {} turned: {found:.6?} off {off:.6?}, hinge {relative:.1e}",
                    case["name"], row["turned"]
                );
                // small angles: no terms neglected. At 10° either both rotate only the normals, or the reference also rotates its vortices:
                // then the difference is the term neglected by U20
                if angle_deg < 1.0 {
                    assert!(off.iter().all(|off| *off < 1e-3) && relative < 1e-3, "{found:?} against {expected:?}");
                }
            }
        }
    }
}

/// U-46. With 20 panels along the chord, lift, rolling moment and hinge moment equal the limit, for ever more panels, of plain lattices of
/// the other program, whose panels in front of the hinge do not rotate: these converge to it with first order, this one with second.
#[test]
fn u46_flaps_reach_the_limit_of_plain_lattices() {
    let reference: Value =
        serde_json::from_str(include_str!("../../reference/flaps/vortex_lattice.json")).expect("JSON");
    for case in reference["cases"].as_array().expect("cases") {
        let limit = ["lift", "roll", "hinge_moment"].map(|key| case["limit"][key].as_f64().expect("a number"));
        let found = [20, 40].map(|chord_panels| {
            let (mut wing, span_m) = wing_of(case, LoadRule::Bernoulli, chord_panels);
            steady(&mut wing, span_m, 1e-4)
        });
        let off = |i: usize, at: usize| (found[at][i] / limit[i] - 1.0).abs();
        let off = [0, 1].map(|at| [off(0, at), off(2, at)]);
        println!("U-46 {}: {found:.6?}, limit {limit:.6?}, off {off:.5?}", case["name"]);
        assert!(off[0][0] < 2e-3 && off[0][1] < 1e-2, "{off:?}");
        assert!(off[1][0] < off[0][0] && off[1][1] < 0.6 * off[0][1], "{off:?}");
    }
}

/// A wing of the reference with its flap.
fn wing_of(case: &Value, load_rule: LoadRule, chord_panels: usize) -> (Wing, f64) {
    let number = |key: &str| case[key].as_f64().expect("a number");
    let parts: Vec<(f64, usize)> = case["parts"]
        .as_array()
        .expect("parts")
        .iter()
        .map(|part| (part[0].as_f64().expect("an end"), part[1].as_u64().expect("a count") as usize))
        .collect();
    let places_m = places(&parts);
    let range = [0, 1].map(|end| case["flap_m"][end].as_f64().expect("an end"));
    let held = |edges: &[f64]| (range[0]..range[1]).contains(&(0.5 * (edges[0] + edges[1])));
    let first = places_m.windows(2).position(held).expect("a strip");
    let count = places_m.windows(2).filter(|edges| held(edges)).count();
    let (span_m, root_m, tip_m) = (number("span_m"), number("root_chord_m"), number("tip_chord_m"));
    let mut options = options();
    (options.load_rule, options.core_radius_m) = (load_rule, 1e-7);
    let mut wing = Wing::new(&places_m, |x: f64| root_m + (tip_m - root_m) * x / span_m, chord_panels, options);
    wing.lattice.add_flaps(&[flap(first..first + count, number("hinge_fraction"))]);
    (wing.from, wing.to) = (wing.lattice.blank_state(), wing.lattice.blank_state());
    (wing, span_m)
}

/// U-43. The middle strips of a long wing approach thin-aerofoil theory as the number of chordwise panels increases: lift within 1 % from
/// four panels on, with second order; the hinge moment of a quarter-chord flap within 1 % with 32 and 1.6 % with four.
#[test]
fn u43_flaps_converge_to_thin_aerofoil_theory() {
    let hinge: f64 = 0.75;
    let (c, theta) = (2.0 * hinge - 1.0, (2.0 * hinge - 1.0).acos());
    let sine = theta.sin();
    // Theodorsen's T12, T10, T5, T4 (NACA Report 496): steady hinge moment −(T12 T10 + T5 − T4 T10)/π divided by ρV²b²
    let (t12, t10) = (sine * (2.0 + c) - theta * (2.0 * c + 1.0), sine + theta);
    let (t5, t4) = (-sine * sine - theta * theta + 2.0 * c * sine * theta, -theta + c * sine);
    let expected = [t10, -(t12 * t10 + t5 - t4 * t10) / (4.0 * std::f64::consts::PI)];
    let found = [4, 8, 16, 32].map(|panels| {
        let places_m = [-2e4, -1e4, -0.5, 0.5, 1e4, 2e4];
        let mut wing = Wing::new(&places_m, |_| 1.0, panels, options());
        wing.lattice.add_flaps(&[flap(0..5, hinge)]);
        (wing.from, wing.to) = (wing.lattice.blank_state(), wing.lattice.blank_state());
        let angle_rad = 1e-3;
        wing.lattice.deflect(&[Deflection { angle_rad, rate_rad_s: 0.0 }]);
        wing.start(true);
        let scale = DENSITY_KG_M3 * SPEED_M_S.powi(2) * angle_rad;
        let circulation = wing.lattice.strip_circulation(&wing.from, 0, 2);
        let all_m = 4e4;
        [circulation * SPEED_M_S * DENSITY_KG_M3 / scale, wing.from.hinges[0].circulatory_n_m / (scale * all_m)]
    });
    println!("U-43: {found:?} against {expected:?}");
    let off = |i: usize, at: usize| (found[at][i] / expected[i] - 1.0).abs();
    assert!((0..4).all(|at| off(0, at) < 0.01), "{found:?} against {expected:?}");
    assert!(off(0, 3) < 0.4 * off(0, 2), "second order: {found:?}");
    assert!(off(1, 0) < 0.02 && off(1, 3) < 0.01, "{found:?} against {expected:?}");
}

/// U-72. Hinge moment of flaps of half and a quarter of the chord in plane flow, for increasing numbers of panels: from eight panels on it
/// converges to thin-aerofoil theory with first order or higher, because the pressure is singular at the hinge as at the leading edge; the
/// vortex core, a thousandth of the narrowest panel, has no effect.
#[test]
fn u72_hinge_moments_converge_over_panels() {
    for hinge in [0.5_f64, 0.75] {
        let (c, theta) = (2.0 * hinge - 1.0, (2.0 * hinge - 1.0).acos());
        let sine = theta.sin();
        // NACA Report 496, as in U-43
        let (t12, t10) = (sine * (2.0 + c) - theta * (2.0 * c + 1.0), sine + theta);
        let (t5, t4) = (-sine * sine - theta * theta + 2.0 * c * sine * theta, -theta + c * sine);
        let expected = -(t12 * t10 + t5 - t4 * t10) / (4.0 * std::f64::consts::PI);
        let off = [4, 8, 16, 32, 64].map(|panels| {
            let mut options = options();
            options.core_radius_m = 1e-5;
            let mut wing = Wing::new(&[-2e4, -1e4, -0.5, 0.5, 1e4, 2e4], |_| 1.0, panels, options);
            wing.lattice.add_flaps(&[flap(0..5, hinge)]);
            (wing.from, wing.to) = (wing.lattice.blank_state(), wing.lattice.blank_state());
            let angle_rad = 1e-3;
            wing.lattice.deflect(&[Deflection { angle_rad, rate_rad_s: 0.0 }]);
            wing.start(true);
            let scale = DENSITY_KG_M3 * SPEED_M_S.powi(2) * angle_rad * 4e4;
            (wing.from.hinges[0].circulatory_n_m / scale / expected - 1.0).abs()
        });
        let orders: Vec<f64> = off.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
        println!("U-72 hinge at {hinge}: off {off:.5?}, orders {orders:.2?}");
        // the first doubling is not yet in the asymptotic range: one panel on the quarter-chord flap does not resolve the pressure
        assert!(orders[1..].iter().all(|order| *order > 0.7), "{hinge}: {off:?}, orders {orders:?}");
        assert!(off[0] < 0.03 && off[4] < 0.003, "{hinge}: {off:?}");
    }
}

/// U-44. A flap that rotates about its hinge at a constant rate from angle 0: the normal velocity at its panels is that of a plate whose
/// rear part moves. A flap of the whole chord, hinged at the leading edge, is the wing itself in pitch; the hinge is on the first line
/// between panels, in a lattice so fine that the part in front of it is a two-hundredth of the chord.
#[test]
fn u44_a_flap_of_all_panels_is_the_wing_in_pitch() {
    let panels = 40;
    let places_m = crate::lattice::wing::inset(6.0, 6);
    let rate_rad_s = 0.3;
    let hinge = 1.0 / panels as f64;
    let circulation = |by_flap: bool| {
        let mut wing = Wing::new(&places_m, |_| 1.0, panels, options());
        wing.lattice.add_flaps(&[flap(0..6, hinge)]);
        (wing.from, wing.to) = (wing.lattice.blank_state(), wing.lattice.blank_state());
        if by_flap {
            wing.lattice.deflect(&[Deflection { angle_rad: 0.0, rate_rad_s }]);
        } else {
            // about the hinge, which is ahead of the sections on the quarter chord
            for motion in &mut wing.motions {
                motion.spin_rad_s = Vector3::x() * rate_rad_s;
                motion.velocity_m_s = Vector3::z() * (rate_rad_s * -(0.25 - hinge));
            }
        }
        wing.start(false);
        let edge = wing.lattice.strip_circulation(&wing.from, 0, 3);
        let at_hinge = wing.from.hinges[0].circulatory_n_m;
        [edge, at_hinge]
    };
    let (flapped, pitched) = (circulation(true), circulation(false));
    println!("U-44: {flapped:?} against {pitched:?}");
    for (flapped, pitched) in flapped.into_iter().zip(pitched) {
        // the panel in front of the hinge is fixed in one case and rotates in the other, with a width of a fortieth of the chord
        approx::assert_relative_eq!(flapped, pitched, max_relative = 0.01);
    }
}

/// U-45. Steps with a moving flap neither allocate nor depend on earlier solutions: the same state and angle give bit-identical results,
/// and flaps at zero give those of a wing without flaps.
#[test]
fn u45_flaps_are_arguments_of_a_step() {
    let places_m = places(&[(1.0, 3), (2.0, 3)]);
    let new = |flaps: &[Flap]| {
        let mut wing = Wing::new(&places_m, |_| 0.5, 4, options()).with_incidence(0.05);
        wing.lattice.add_flaps(flaps);
        (wing.from, wing.to) = (wing.lattice.blank_state(), wing.lattice.blank_state());
        wing.start(true);
        wing
    };
    let (mut plain, mut still) = (new(&[]), new(&[flap(3..6, 0.75)]));
    for _ in 0..3 {
        plain.step(0.01);
        still.step(0.01);
    }
    assert_eq!(plain.from.circulation_m2_s, still.from.circulation_m2_s);
    assert_eq!(plain.loads, still.loads);
    let kept = still.from.clone();
    let go = |wing: &mut Wing, angle_rad: f64| {
        wing.from.copy_from(&kept);
        wing.lattice.deflect(&[Deflection { angle_rad, rate_rad_s: 1.0 }]);
        wing.step(0.01);
        (wing.from.clone(), wing.loads.clone())
    };
    let first = go(&mut still, 0.2);
    let before = crate::counting_allocator::allocations();
    still.lattice.deflect(&[Deflection { angle_rad: -0.1, rate_rad_s: 0.0 }]);
    still.step(0.01);
    assert_eq!(crate::counting_allocator::allocations(), before, "a step allocates");
    let again = go(&mut still, 0.2);
    assert_eq!(first, again);
}

/// U-75. Hinge moments of a flap over the span, over one end and in the middle of a wing in a sideslip of 30°, where chordwise vortex lines
/// carry forces: equal by both load formulas, up to terms of second order in the incidence.
#[test]
fn u75_hinge_moments_in_sideslip_are_the_same_by_both_rules() {
    let hinge_n_m = |strips: std::ops::Range<usize>, load_rule: LoadRule, incidence_rad: f64| {
        let options = foldwing::aero::lattice::LatticeOptions { load_rule, ..options() };
        let mut wing = Wing::new(&crate::lattice::wing::inset(3.0, 12), |x| 1.0 - 0.1 * x, 4, options);
        wing.lattice.add_flaps(&[flap(strips, 0.5)]);
        (wing.from, wing.to) = (wing.lattice.blank_state(), wing.lattice.blank_state());
        let (sine, cosine) = 30f64.to_radians().sin_cos();
        wing.wind_m_s = Vector3::new(sine, -cosine * incidence_rad.cos(), cosine * incidence_rad.sin()) * SPEED_M_S;
        wing.start(true);
        wing.from.hinges[0].circulatory_n_m
    };
    for strips in [0..12, 0..4, 4..9] {
        let off = [2e-3, 1e-3].map(|incidence_rad| {
            let [pressure, segments] = [LoadRule::Bernoulli, LoadRule::KuttaJoukowski]
                .map(|rule| hinge_n_m(strips.clone(), rule, incidence_rad));
            (segments / pressure - 1.0).abs()
        });
        println!("U-75 flap {strips:?}: off {off:?}");
        // the difference is found to be quadratic: the velocities that the vortices induce along a flat wing have opposite signs on its two
        // sides
        assert!(off[0] < 1e-5 && off[1] < 0.3 * off[0], "{strips:?}: {off:?}");
    }
}
