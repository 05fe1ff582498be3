//! Stability of equilibria, the search for a stable one, and paths through limit points, against closed forms.

use crate::statics::machines::*;
use foldwing::plant::{Branch, Departure, Holding, LoadPath, Plant, Rest, Search};
use std::f64::consts::PI;

fn rest(text: &str, path: LoadPath, branch: Branch) -> (Plant, Rest) {
    let mut plant = plant(text);
    let search = Search { path, branch };
    let rest = plant.study().rest(0.0, Holding::AsReleased, search).unwrap_or_else(|error| panic!("{error}"));
    (plant, rest)
}

/// Number of negative eigenvalues of the dense stiffness for the free coordinates.
fn dense_count(plant: &mut Plant) -> usize {
    let stiffness = plant.study().second_order().expect("linear").stiffness;
    let symmetric = (&stiffness + stiffness.transpose()) * 0.5;
    symmetric.symmetric_eigenvalues().iter().filter(|value| **value < 0.0).count()
}

/// A stiff rod of 0.3 m and 0.3 kg on a free hinge at the origin, under gravity along −z.
fn rod(start_deg: f64) -> String {
    format!(
        "name = \"R\"\ngravity_m_s2 = [0.0, 0.0, -9.81]\n[section.s]\nshape = \"explicit\"\naxial_stiffness_N = 1e6\ntorsional_rigidity_N_m2 = 1e4\n\
         flap_stiffness_N_m2 = 1e4\nedge_stiffness_N_m2 = 1e4\nmass_kg_m = 1.0\n\
         second_moments_kg_m = [1e-9, 0.0, 0.0]\n[body.rod]\nlength_m = 0.3\nsection = \"s\"\n\
         elements = 2\n[joint.h]\ntype = \"revolute\"\nparent = \"root\"\nchild = \"rod\"\naxis = [0.0, 1.0, 0.0]\n\
         start_angle_deg = {start_deg}\n[simulation]\nstop_time_s = 1.0\nstep_s = 1e-3\n"
    )
}

/// S-47. A rod on a free hinge hangs down, wherever it starts: the stable equilibrium is found, and the one on the load path, if upright,
/// is reported as unstable with the rate `√(3g/2L)` of a falling rod (1e-6: its rotary inertia). (From the horizontal and from above, the
/// upright equilibrium used to be returned without a warning.)
#[test]
fn s47_a_rod_on_a_free_hinge_hangs() {
    for start_deg in [0.0, -10.0, -30.0, -45.0, -80.0, 1.0, 90.0, 135.0] {
        let (mut plant, found) = rest(&rod(start_deg), LoadPath::Load, Branch::Stable);
        let tip = plant.outputs().tips()[0].position_m;
        assert!((tip.z + 0.3).abs() < 1e-4 && tip.x.abs() < 1e-6, "from {start_deg}° the tip rests at {tip:?}");
        assert!(plant.study().stability().expect("linear").is_stable());
        let (mut plant, kept) = rest(&rod(start_deg), LoadPath::Load, Branch::Path);
        assert_eq!(kept.departure, None);
        let stability = plant.study().stability().expect("linear");
        if plant.outputs().tips()[0].position_m.z > 0.0 {
            assert_eq!(found.departure, Some(Departure::Unstable(1)), "from {start_deg}°");
            assert_eq!(stability.unstable_directions(), 1);
            let (rate, right) = (stability.growing[0].eigenvalue_1_s.re, (1.5 * 9.81f64 / 0.3).sqrt());
            assert!((rate / right - 1.0).abs() < 1e-4, "falls with {rate} 1/s, right {right} 1/s");
            assert!(stability.growing[0].direction.x.abs() > 0.99);
        } else {
            assert!(stability.is_stable() && found.departure.is_none());
        }
    }
}

/// A column along x, `L = 1`, `EI_y = 1`, stiff in all other deformations, under a compression of `times_euler` times Euler's load, and a
/// side force.
fn column(times_euler: f64) -> String {
    let force_n = times_euler * PI * PI / 4.0;
    Cantilever {
        stiffness: [1e9, 1e4, 1.0, 1e4],
        elements: 8,
        tip: [[-force_n, 0.0, 1e-6], [0.0; 3]],
        ..Cantilever::default()
    }
    .text()
}

/// `K(sin(α/2))`, by the arithmetic–geometric mean.
fn elliptic(alpha: f64) -> f64 {
    let (mut a, mut b) = (1.0, (0.5 * alpha).cos());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    0.5 * PI / a
}

/// S-48. A straight column is unstable in `n` directions between the `n`th and the next Euler load (1, 9, 25 times the first), equal to the
/// number of negative eigenvalues of the dense matrix; the descent of the potential leads to the elastica `K(sin(α/2)) = π/2 √(P/P_E)`. (At
/// four times Euler's load it used to be reported as an equilibrium without its instability.)
#[test]
fn s48_a_column_beyond_eulers_load() {
    for (times, count) in [(0.98, 0), (1.02, 1), (4.0, 1), (8.9, 1), (9.1, 2), (24.0, 2), (26.0, 3)] {
        let (mut plant, _) = rest(&column(times), LoadPath::Load, Branch::Path);
        assert!(plant.outputs().tips()[0].position_m.z.abs() < 1e-3, "straight at {times} Euler loads");
        let stability = plant.study().stability().expect("linear");
        assert!(stability.potential, "dead forces have a potential");
        assert_eq!((stability.negative_directions, dense_count(&mut plant)), (count, count), "{times} Euler loads");
        assert_eq!(stability.growing.len(), count, "as many modes grow");
    }
    let (mut low, mut high) = (0.0, PI);
    for _ in 0..60 {
        let middle: f64 = 0.5 * (low + high);
        if elliptic(middle) < PI { low = middle } else { high = middle }
    }
    let (mut plant, found) = rest(&column(4.0), LoadPath::Load, Branch::Stable);
    assert_eq!(found.departure, Some(Departure::Unstable(1)));
    assert!(plant.study().stability().expect("linear").is_stable());
    let turn = plant.shape()[0].last().expect("a tip").rotation_vector_rad().norm();
    assert!((turn - low).abs() < 1e-3, "the tip turns by {turn} rad, the elastica by {low} rad");
    assert!(plant.outputs().tips()[0].position_m.z > 0.0, "to the side of the force");
}

/// Two hinged bars that meet at an apex at `angle` above the line between their feet, 0.5 m each, loaded there by `force_n`.
fn truss(angle: f64, force_n: f64) -> String {
    let (span_m, degrees) = (2.0 * 0.5 * angle.cos(), angle.to_degrees());
    let bar = |name: &str| {
        format!(
            "[body.{name}]\nlength_m = 0.5\nsection = \"s\"\nelements = 1\nload_station_positions_m = [0.5]\n\
             [joint.{name}]\ntype = \"revolute\"\nparent = \"root\"\nchild = \"{name}\"\naxis = [0.0, 1.0, 0.0]\n"
        )
    };
    format!(
        "name = \"T\"\n[section.s]\nshape = \"explicit\"\naxial_stiffness_N = 1e4\ntorsional_rigidity_N_m2 = 1e4\n\
         flap_stiffness_N_m2 = 1e4\nedge_stiffness_N_m2 = 1e4\nmass_kg_m = 1.0\n\
         second_moments_kg_m = [1e-9, 0.0, 0.0]\n{}start_angle_deg = {}\n{}root_position_m = [{span_m}, 0.0, 0.0]\n\
         start_angle_deg = {}\n[loop.apex]\nbodies = [\"left\", \"right\"]\nstiffness_N_m = 1e11\n[load.p]\n\
         body = \"left\"\nstation = 1\nforce_N = [0.0, 0.0, {}]\n[simulation]\nstop_time_s = 1.0\nstep_s = 1e-3\n",
        bar("left"),
        -degrees,
        bar("right"),
        180.0 + degrees,
        -force_n
    )
}

/// S-49. Snap-through of von Mises' truss by arc length: every point of the path satisfies `P = 2 EA (1 − l/l₀) z/l`, is unstable exactly
/// where the load decreases with the displacement, and the path ends at the full load on the far side.
#[test]
fn s49_snap_through_by_arc_length() {
    let (angle, stiffness_n) = (0.1f64, 1e4);
    let half_m = 0.5 * angle.cos();
    let load_n = |z: f64| -2.0 * stiffness_n * (1.0 - z.hypot(half_m) / 0.5) * z / z.hypot(half_m);
    let limit_n = (0..10_000).map(|i| -load_n(0.05 * f64::from(i) / 1e4)).fold(0.0, f64::max);
    let force_n = 1.5 * limit_n;
    let (mut plant, found) = rest(&truss(angle, force_n), LoadPath::ArcLength, Branch::Path);
    let mut largest_n = 0.0f64;
    for point in &found.path {
        let z = plant.study().tips_at(point)[0].z;
        let (here_n, right_n) = (point.factor * force_n, -load_n(z));
        assert!((here_n - right_n).abs() < 1e-5 * limit_n, "z = {z} m: {here_n} N, right {right_n} N");
        let slope = load_n(z + 1e-6) - load_n(z - 1e-6);
        if slope.abs() > 1e-3 * limit_n * 2e-6 / 0.05 {
            assert_eq!(point.negative_directions, usize::from(slope < 0.0), "z = {z} m at {here_n} N");
        }
        if z > 0.0 {
            largest_n = largest_n.max(here_n);
        }
    }
    assert!((largest_n / limit_n - 1.0).abs() < 2e-3, "limit load {largest_n} N, right {limit_n} N");
    assert_eq!(found.path.last().expect("points").factor, 1.0);
    let z = plant.outputs().tips()[0].position_m.z;
    assert!(z < -0.04, "ends at z = {z} m");
    let (snapped, _) = rest(&truss(angle, force_n), LoadPath::Load, Branch::Stable);
    let other = snapped.outputs().tips()[0].position_m.z;
    assert!((other - z).abs() < 1e-7, "the load at once leads to {other} m, the path to {z} m");
}

/// S-50. A follower force has no potential, and its column has no negative pivot: it flutters from `P L²/EI = 20.05` on (Beck), as the
/// modes show.
#[test]
fn s50_becks_column_flutters() {
    for (load, stable) in [(19.5, true), (20.6, false)] {
        let text = Cantilever {
            stiffness: [1e9, 1e5, 1.0, 1e4],
            elements: 8,
            load_frame: "section",
            tip: [[-load, 0.0, 0.0], [0.0; 3]],
            ..Cantilever::default()
        }
        .text();
        let (mut plant, found) = rest(&text, LoadPath::Load, Branch::Stable);
        let stability = plant.study().stability().expect("linear");
        assert!(!stability.potential && found.departure.is_none());
        assert_eq!(stability.is_stable(), stable, "P = {load}: {stability:?}");
        assert!(stability.growing.iter().all(|growth| growth.eigenvalue_1_s.im > 1.0), "it oscillates");
    }
}

/// S-51. An elastica whose boundary layer is far shorter than an element is reported as coarse; the same bend at a load resolved by the
/// mesh is not, nor is a full circle of four elements, which is exact.
#[test]
fn s51_a_coarse_mesh_is_told() {
    let bent = |tip: [[f64; 3]; 2], elements| {
        let text = Cantilever { tip, elements, stiffness: [1e9, 1.0, 1.0, 1e4], ..Cantilever::default() }.text();
        rest(&text, LoadPath::Load, Branch::Path).0.study().coarseness()
    };
    let steep = bent([[0.0, 0.0, 1e5], [0.0; 3]], 16);
    assert!(steep.is_coarse(), "{steep:?}");
    assert!(!bent([[0.0, 0.0, 10.0], [0.0; 3]], 16).is_coarse());
    assert!(!bent([[0.0; 3], [0.0, -2.0 * PI, 0.0]], 4).is_coarse());
}
