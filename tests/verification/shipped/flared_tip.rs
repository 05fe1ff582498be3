//! F-220 to F-222: `flared_wing_tip.toml`, a folding tip for gust load alleviation.

use super::{machine, run, start};
use nalgebra::{Rotation3, Unit, Vector3};
use std::f64::consts::PI;

const MODEL: &str = include_str!("../../../examples/models/flared_wing_tip.toml");
const AXIS: &str = "axis = [0.3420201433256687, 0.9396926207859084, 0.0]";
const START: &str = "start_angle_deg = -6.5";
/// Fold angle of the floating tip in equilibrium, rad.
const FLOATING_RAD: f64 = -6.5 * PI / 180.0;

/// Histories of the model's experiment with texts replaced: fold angle in rad (positive down), and moment about `−y` at the root in N·m,
/// positive for lift.
fn histories(changes: &[(&str, &str)]) -> (Vec<f64>, Vec<f64>) {
    let (mut angles_rad, mut moments_n_m) = (Vec::new(), Vec::new());
    run(machine(MODEL, changes), |plant| {
        angles_rad.push(plant.outputs().joints()[0].angle_rad);
        moments_n_m.push(-plant.outputs().root().moment_n_m.y);
    });
    (angles_rad, moments_n_m)
}

fn most(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

/// F-220. The tip stays at its equilibrium until the gust arrives; in the gust it folds up by more than 5 degrees, and the root bending
/// moment is lower than with the hinge locked at the equilibrium angle or straight, both in its peak and in its rise above the value before
/// the gust. The required margins are half of the observed ones.
#[test]
fn f220_the_flared_tip_relieves_the_root() {
    let (angles_rad, free) = histories(&[]);
    let before = 120; // steps of 2.5 ms up to the gust
    let drift_rad = angles_rad[..before].iter().map(|angle| (angle - FLOATING_RAD).abs()).fold(0.0, f64::max);
    assert!(drift_rad.to_degrees() < 0.15, "the tip does not float: {} deg", drift_rad.to_degrees());
    let up_deg = (FLOATING_RAD - least(&angles_rad)).to_degrees();
    let locked_at = |start: &str| histories(&[(START, &format!("{start}\nmotion = \"locked\""))]).1;
    let (floating, straight) = (locked_at(START), locked_at("start_angle_deg = 0.0"));
    let [(peak, rise), (floating_peak, floating_rise), (straight_peak, straight_rise)] =
        [&free, &floating, &straight].map(|moments| (most(moments), most(moments) - moments[before - 2]));
    println!(
        "F-220 drift {:.3} deg, folds up by {up_deg:.1} deg; peak (rise) of the root moment {peak:.2} ({rise:.2}) N.m free, \
         {floating_peak:.2} ({floating_rise:.2}) locked where it floats, {straight_peak:.2} ({straight_rise:.2}) locked straight",
        drift_rad.to_degrees()
    );
    assert!(up_deg > 5.0, "{up_deg} deg");
    assert!(
        peak < 0.85 * straight_peak && rise < 0.93 * straight_rise,
        "{peak} {straight_peak}, {rise} {straight_rise}"
    );
    assert!(
        peak < 0.953 * floating_peak && rise < 0.93 * floating_rise,
        "{peak} {floating_peak}, {rise} {floating_rise}"
    );
}

/// F-221. Sign and magnitude of the flare's effect on the local incidence, against geometry: the tip locked at angles from −40 to 40
/// degrees about axes flared by −30 to 30 degrees, without initial incidence, with quasi-steady strips and the undeformed wing at the
/// start. Chord and normal of the tip are rotated by Rodrigues' formula; with `V` and `W` the wind along them, the normal force is `½ρ c a₀
/// V W` per span (thin plate), to round-off. Folded up, a tip whose hinge axis points outboard at its front loses `sin Λ` of incidence per
/// radian.
#[test]
fn f221_flare_turns_the_nose_as_geometry_says() {
    const SPEED_M_S: f64 = 20.0;
    const HALF_DENSITY_CHORD_SPAN: f64 = 0.5 * 1.225 * 0.25 * 0.4;
    let wind = Vector3::new(0.0, -SPEED_M_S, 0.0);
    for flare_deg in [-30.0_f64, -10.0, 0.0, 20.0, 30.0] {
        let (sin, cos) = flare_deg.to_radians().sin_cos();
        let axis = Vector3::new(sin, cos, 0.0);
        for angle_deg in [-40.0_f64, -15.0, -0.5, 10.0, 40.0] {
            let tip_only = MODEL.split("[surface.inner]").next().unwrap().to_owned()
                + "[surface.tip]"
                + MODEL.split("[surface.tip]").nth(1).unwrap();
            let held = format!("start_angle_deg = {angle_deg}\nmotion = \"locked\"");
            let changes = [
                (AXIS, &*format!("axis = [{sin}, {cos}, 0.0]")),
                (START, &held),
                ("incidence_deg = 3.0", "incidence_deg = 0.0"),
                ("model = \"strip\"", "model = \"strip\"\nquasi_steady = true\napparent_mass = false"),
                ("start = \"equilibrium\"", ""),
            ];
            let plant = start(machine(&tip_only, &changes));
            let force_n = plant.outputs().air_total().force_n;
            let turn = Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle_deg.to_radians());
            let (aft, up) = (turn * -Vector3::y(), turn * Vector3::z());
            let expected_n = HALF_DENSITY_CHORD_SPAN * 2.0 * PI * wind.dot(&aft) * wind.dot(&up);
            let off = (force_n.dot(&up) - expected_n).abs();
            assert!(
                off < 1e-9,
                "flare {flare_deg} deg, angle {angle_deg} deg: {force_n} N, {expected_n} N along the normal"
            );

            let incidence = wind.dot(&up).atan2(wind.dot(&aft));
            assert_eq!(
                force_n.dot(&up) < -1e-9,
                angle_deg * sin < -1e-12,
                "up with a front end outboard, and nothing else, unloads"
            );
            if angle_deg == -0.5 {
                let slope = incidence / angle_deg.to_radians();
                assert!((slope - sin).abs() < 1e-4, "{slope} rad of incidence per rad, geometry says {sin}");
            }
        }
    }
}

/// F-222. Effect of the flare: without it, or with the opposite flare, there is no restoring moment and the tip folds up beyond 45 degrees
/// within the same second; with it, never beyond 25.
#[test]
fn f222_without_flare_the_tip_folds_away() {
    let highest_deg = |axis: &str| -least(&histories(&[(AXIS, axis)]).0).to_degrees();
    let [flared, plain, reversed] =
        [AXIS, "axis = [0.0, 1.0, 0.0]", "axis = [-0.3420201433256687, 0.9396926207859084, 0.0]"].map(highest_deg);
    println!("F-222 highest fold {flared:.1} deg flared, {plain:.1} deg without, {reversed:.1} deg the other way");
    assert!(flared < 25.0 && plain > 45.0 && reversed > 45.0, "{flared} {plain} {reversed}");
}
