//! Steady wings: lift slope, tips, elliptic wing, both load formulas.

use crate::lattice::wing::{SPEED_M_S, Wing, inset, options, pressure_pa};
use crate::reference::{case, numbers};
use foldwing::aero::lattice::{LatticeOptions, LoadRule};
use nalgebra::Vector3;
use std::f64::consts::PI;

fn uniform(span_m: f64, strips: usize) -> Vec<f64> {
    (0..=strips).map(|i| span_m * (i as f64 / strips as f64 - 0.5)).collect()
}

/// Lift slope of a rectangular wing of chord 1 m at 1°.
fn slope(places_m: &[f64], aspect: f64, chord_panels: usize) -> f64 {
    let angle_rad = 1f64.to_radians();
    let mut wing = Wing::new(places_m, |_| 1.0, chord_panels, options()).with_incidence(angle_rad);
    wing.start(true);
    wing.circulatory_n().z / (pressure_pa() * aspect * angle_rad)
}

/// U-01. Lift slope of rectangular wings against an independent lattice on the same panels, which has a stated accuracy of 1e-3.
#[test]
fn u01_lift_slope_of_rectangular_wings() {
    let expected = &case("aero.rect_wing_CLalpha")["expected"];
    for aspect in [2, 6, 20] {
        let levels = numbers(&expected[aspect.to_string()]["levels"]);
        for (level, (chord_panels, half_span)) in [(4, 16), (8, 32)].into_iter().enumerate() {
            let ours = slope(&uniform(f64::from(aspect), 2 * half_span), f64::from(aspect), chord_panels);
            let error = ours / levels[level] - 1.0;
            println!("U-01 aspect ratio {aspect}, {chord_panels} x {half_span}: {ours:.5} ({error:+.1e})");
            assert!(error.abs() < 1e-3, "aspect ratio {aspect}: {ours} for {}", levels[level]);
        }
    }
}

/// U-02. A lattice that extends to the tip converges only with first order in the span; with the tips inset by a quarter of a panel the
/// error is ten times smaller. Both converge to the same wing.
#[test]
fn u02_inset_tips_converge_faster() {
    let strips = [12, 24, 48];
    let to_the_tip = strips.map(|n| slope(&uniform(6.0, n), 6.0, 4));
    let inset = strips.map(|n| slope(&inset(6.0, n), 6.0, 4));
    // extrapolation with the observed order
    let (first, second) = (to_the_tip[1] - to_the_tip[0], to_the_tip[2] - to_the_tip[1]);
    let limit = to_the_tip[2] - second * second / (second - first);
    println!("U-02 to the tip {to_the_tip:.5?}, inset {inset:.5?}, limit {limit:.5}");
    let order = (first / second).log2();
    assert!((0.8..1.3).contains(&order), "order to the tip {order}");
    for level in 0..2 {
        let (whole, quarter) = ((to_the_tip[level] - limit).abs(), (inset[level] - limit).abs());
        assert!(quarter < 0.2 * whole, "{} strips: {quarter} against {whole}", strips[level]);
    }
}

/// U-03. Elliptic planform of aspect ratio 10, straight quarter-chord line: the induced drag of Kutta–Joukowski is `CL²/(πAR)` (Prandtl).
/// The piecewise linear planform and the curved edges of a lifting surface cause a difference of about 1 %, which falls with the number of
/// strips.
#[test]
fn u03_elliptic_wing() {
    let (span_m, root_m) = (10.0, 4.0 / PI);
    let angle_rad = 3f64.to_radians();
    let chord_m = |x: f64| root_m * (1.0 - (2.0 * x / span_m).powi(2)).max(0.0).sqrt();
    let mut errors = Vec::new();
    for strips in [20, 40] {
        let rule = LatticeOptions { load_rule: LoadRule::KuttaJoukowski, ..options() };
        let places_m = inset(span_m, strips);
        let mut wing = Wing::new(&places_m, chord_m, 4, rule).with_incidence(angle_rad);
        wing.start(true);
        let force_n = wing.circulatory_n();
        let along = wing.wind_m_s.normalize();
        let (drag_n, lift_n) = (force_n.dot(&along), force_n.dot(&along.cross(&Vector3::x())));
        let area_m2 = PI / 4.0 * span_m * root_m;
        let (lift, drag) = (lift_n / (pressure_pa() * area_m2), drag_n / (pressure_pa() * area_m2));
        let efficiency = lift * lift / (PI * (span_m * span_m / area_m2) * drag);
        let circulation = |strip: usize| wing.lattice.strip_circulation(&wing.from, 0, strip);
        // shape of the loading: circulation divided by the elliptic chord, relative to its mean over the inner 80 %
        let inner: Vec<f64> = (0..strips)
            .filter(|s| (0.5 * (places_m[*s] + places_m[s + 1])).abs() < 0.4 * span_m)
            .map(|s| circulation(s) / chord_m(0.5 * (places_m[s] + places_m[s + 1])))
            .collect();
        let mean = inner.iter().sum::<f64>() / inner.len() as f64;
        let uneven = inner.iter().map(|value| (value / mean - 1.0).abs()).fold(0.0, f64::max);
        println!(
            "U-03 {strips} strips: CL {lift:.5} CD {drag:.6} efficiency {efficiency:.4} loading uneven {uneven:.4}"
        );
        errors.push((efficiency - 1.0).abs());
        assert!(uneven < 0.03, "loading off the ellipse by {uneven}");
    }
    assert!(errors[1] < 0.02, "induced drag off by {}", errors[1]);
}

/// U-04. Both load formulas give the same normal force; the suction rotates the resultant to nearly normal to the flow.
#[test]
fn u04_both_rules_agree_on_the_normal_force() {
    let force_n = |load_rule| {
        let angle_rad = 4f64.to_radians();
        let rule = LatticeOptions { load_rule, ..options() };
        let mut wing = Wing::new(&inset(6.0, 16), |_| 1.0, 6, rule).with_incidence(angle_rad);
        wing.start(true);
        (wing.circulatory_n(), wing.wind_m_s.normalize())
    };
    let (pressure_n, _) = force_n(LoadRule::Bernoulli);
    let (segments_n, along) = force_n(LoadRule::KuttaJoukowski);
    println!("U-04 normal force {:.5} and {:.5} N; drag {:.5} N", pressure_n.z, segments_n.z, segments_n.dot(&along));
    assert!((segments_n.z / pressure_n.z - 1.0).abs() < 2e-3, "{pressure_n} against {segments_n}");
    assert!(pressure_n.y.abs() < 1e-12, "pressure along the plate: {pressure_n}");
    let resultant_n = pressure_n.z * 4f64.to_radians().sin();
    assert!(segments_n.dot(&along) < 0.5 * resultant_n, "no suction: {segments_n}");
}

/// Force in N and moment in N·m about the origin of all sections.
fn wrench(wing: &Wing) -> [f64; 6] {
    let loads = wing.loads.circulatory.iter().zip(&wing.motions);
    let moment_n_m: Vector3<f64> =
        loads.map(|(load, motion)| load.moment_n_m + motion.position_m.cross(&load.force_n)).sum();
    let force_n = wing.circulatory_n();
    [force_n.x, force_n.y, force_n.z, moment_n_m.x, moment_n_m.y, moment_n_m.z]
}

/// U-73. Steady loads in sideslip, by both load formulas, for steps from a quarter of a panel to two panels, at the start and after some
/// steps, against an independent lattice of horseshoes on the same mesh: `tests/reference/sideslip/vortex_lattice.py`. The step may change
/// the loads by at most 1e-3; the wake, which ends 200 diameters behind while the horseshoes extend to infinity, and the core of 1e-4 m
/// cause a difference of 2e-5.
#[test]
fn u73_steady_loads_in_sideslip_do_not_depend_on_the_step() {
    let reference: serde_json::Value =
        serde_json::from_str(include_str!("../../reference/sideslip/vortex_lattice.json")).expect("JSON");
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let (span_m, chord_m) = (number(&reference["span_m"]), number(&reference["chord_m"]));
    for case in reference["cases"].as_array().expect("cases") {
        let angle = |name: &str| number(&case[name]).to_radians();
        let count = |name: &str| case[name].as_u64().expect("a count") as usize;
        let (sine, cosine) = angle("sideslip_deg").sin_cos();
        let (up, along) = angle("incidence_deg").sin_cos();
        for (rule, name) in [(LoadRule::Bernoulli, "pressure"), (LoadRule::KuttaJoukowski, "segments")] {
            let expected = numbers(&case[name]).into_iter().map(|entry| 2.0 * pressure_pa() * entry);
            let expected: Vec<f64> = expected.collect();
            let scales = [expected[2].abs(), chord_m * expected[2].abs()];
            for panels in [2.0, 1.0, 0.5, 0.25] {
                let rules = LatticeOptions { load_rule: rule, wake_rows: 12, ..options() };
                let places_m = inset(span_m, count("strips"));
                let mut wing = Wing::new(&places_m, |_| chord_m, count("chord_panels"), rules);
                wing.wind_m_s = Vector3::new(sine, -cosine * along, cosine * up) * SPEED_M_S;
                let step_s = panels * wing.panel_step_s();
                wing.start_for_steps(step_s);
                let mut found = vec![wrench(&wing)];
                (0..4).for_each(|_| wing.step(step_s));
                found.push(wrench(&wing));
                let off = |loads: &[f64; 6]| {
                    let each = loads.iter().zip(&expected).enumerate();
                    each.map(|(i, (ours, theirs))| (ours - theirs).abs() / scales[i / 3]).fold(0.0, f64::max)
                };
                let errors = [off(&found[0]), off(&found[1])];
                println!(
                    "U-73 {name}, {panels} panels: roll {:.6}, off {:.1e} {:.1e}",
                    found[0][4], errors[0], errors[1]
                );
                assert!(errors.iter().all(|error| *error < 3e-5), "{name}: {found:?} for {expected:?}");
            }
        }
    }
}
