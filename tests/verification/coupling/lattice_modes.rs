//! the modes listed for a lattice, against all eigenvalues of the complete discrete-time model.

use crate::trees::Random;
use crate::whole::is_whole;
use foldwing::config;
use foldwing::plant::{Holding, Plant, SampledSpace};
use foldwing::solve::eigen::{Eigen, eigen};
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::PI;
use std::fmt::Write;
use std::sync::Arc;

/// Random value between two bounds, uniform on a logarithmic scale.
fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    (low.ln() + (high / low).ln() * 0.5 * (1.0 + random.symmetric())).exp()
}

/// A small machine with a vortex lattice: one or two bodies, swept or unswept, clamped at a wall or on a roll hinge, with a tip on a hinge
/// that may be free, with or without lift.
fn machine(seed: u64) -> String {
    let mut random = Random::new(seed);
    let coin = |random: &mut Random| random.symmetric() > 0.0;
    let (tip, rolls, lifts) = (coin(&mut random), coin(&mut random), coin(&mut random));
    let mut of = |low: f64, high: f64| between(&mut random, low, high);
    let speed_m_s = of(4.0, 60.0);
    let (chord_m, panels) = (of(0.08, 0.3), if of(1.0, 2.0) > 1.4 { 2 } else { 1 });
    let step_s = chord_m / panels as f64 / speed_m_s;
    let (flap, torsion, mass) = (of(0.3, 30.0), of(0.1, 10.0), of(0.1, 1.0));
    let (behind_m, inertia) = (of(0.02, 0.3) * chord_m - 0.1 * chord_m, mass * (0.3 * chord_m).powi(2));
    let sweep_deg = 60.0 * (of(0.5, 2.0).log2());
    let mut text = format!(
        "name = \"Small\"\ngravity_m_s2 = [0.0, 0.0, {:?}]\n[section.spar]\nshape = \"explicit\"\ntorsional_rigidity_N_m2 = {torsion:?}\n\
         flap_stiffness_N_m2 = {flap:?}\nedge_stiffness_N_m2 = {:?}\naxial_stiffness_N = 1e6\nmass_kg_m = {mass:?}\n\
         centre_of_mass_m = [{:?}, 0.0]\nsecond_moments_kg_m = [{inertia:?}, 0.0, 0.0]\n",
        if lifts && !rolls { -9.81 } else { 0.0 },
        30.0 * flap,
        -behind_m
    );
    let rolling = format!(
        "type = \"revolute\"\naxis = [0.0, 1.0, 0.0]\n[joint.wall.motor]\nstiffness_N_m_rad = {:?}\ndamping_N_m_s_rad = {:?}",
        of(0.01, 3.0),
        of(1e-4, 1e-1)
    );
    let turned = format!("mount_rotation_deg = [0.0, 0.0, {:?}]\n", if rolls { 0.0 } else { sweep_deg * 0.4 });
    let wall = if rolls {
        format!("parent = \"root\"\nchild = \"wing\"\n{turned}{rolling}")
    } else {
        format!("type = \"clamped\"\nparent = \"root\"\nchild = \"wing\"\n{turned}")
    };
    let _ = write!(
        text,
        "[body.wing]\nlength_m = {:?}\nsection = \"spar\"\nelements = 2\n[joint.wall]\n{wall}\n\
         [aerodynamics]\nmodel = \"uvlm\"\ndensity_kg_m3 = {:?}\nwind_m_s = [0.0, {:?}, 0.0]\nstep_s = {step_s:?}\nwake_rows = {}\n\
         leading_edge_suction = {}\n[surface.wing]\nbody = \"wing\"\nchord_m = {chord_m:?}\nelastic_axis_fraction = {:?}\nincidence_deg = {:?}\n\
         strips = 3\nchord_panels = {panels}\n",
        of(0.3, 1.5),
        of(0.3, 1.5),
        -speed_m_s,
        of(4.0, 13.0) as usize,
        lifts,
        of(0.25, 0.6),
        if lifts { 0.5 } else { 0.0 },
    );
    if tip {
        let swings = of(0.5, 2.0) > 1.0;
        let spring = if swings {
            String::new()
        } else {
            format!(
                "[joint.fold.motor]\nstiffness_N_m_rad = {:?}\ndamping_N_m_s_rad = {:?}\n",
                of(0.01, 10.0),
                of(1e-4, 1e-2)
            )
        };
        let _ = write!(
            text,
            "[body.tip]\nlength_m = {:?}\nsection = \"spar\"\nelements = 1\n[joint.fold]\ntype = \"revolute\"\nparent = \"wing\"\nchild = \"tip\"\n\
             axis = [{:?}, -1.0, 0.0]\n{spring}[surface.tip]\nbody = \"tip\"\nchord_m = {chord_m:?}\nelastic_axis_fraction = 0.4\nincidence_deg = {:?}\n\
             strips = 2\nchord_panels = {panels}\n",
            of(0.1, 0.4),
            of(0.05, 0.6) - 0.05,
            if lifts { 0.5 } else { 0.0 },
        );
    }
    text
}

/// Participation of a group of states in an eigenvalue: the sum of products of left and right eigenvector entries over the sum of all.
fn share(right: &DVector<Complex<f64>>, left: &DVector<Complex<f64>>, counts: &dyn Fn(usize) -> bool) -> f64 {
    let product = |i: usize| left[i] * right[i];
    let all: Complex<f64> = (0..right.len()).map(product).sum();
    let some: Complex<f64> = (0..right.len()).filter(|i| counts(*i)).map(product).sum();
    (some / all).norm()
}

fn vector(all: &Eigen, i: usize, scale: impl Fn(usize) -> f64) -> DVector<Complex<f64>> {
    let pair = all.values[i].im > 0.0;
    DVector::from_fn(all.vectors.nrows(), |row, _| {
        Complex::new(all.vectors[(row, i)], if pair { all.vectors[(row, i + 1)] } else { 0.0 }) * scale(row)
    })
}

/// A mode of the complete model.
#[derive(Debug)]
struct Oracle {
    eigenvalue_1_s: Complex<f64>,
    /// Participation of the circulations and of the nodes of the wake.
    wake: f64,
    /// Relative mismatch between rates and eigenvalue: near 1 for motions so fast that their samples alias to a slower one.
    hidden: f64,
}

/// The matrix balanced by powers of 2, so that rows and columns have about equal norms, and the scale of each unknown (Parlett and Reinsch
/// 1969).
fn balanced_rows(matrix: &DMatrix<f64>) -> (DMatrix<f64>, DVector<f64>) {
    let n = matrix.nrows();
    let (mut scaled, mut scale) = (matrix.clone(), DVector::from_element(n, 1.0));
    for _ in 0..30 {
        for i in 0..n {
            let own = scaled[(i, i)].abs();
            let (column, row) = (scaled.column(i).lp_norm(1) - own, scaled.row(i).lp_norm(1) - own);
            let factor = match (column > 0.0, row > 0.0) {
                (true, true) => (row / column).sqrt(),
                (true, false) => 1.0 / column,
                (false, true) => row,
                (false, false) => 1.0,
            };
            let factor = factor.log2().round().exp2();
            scale[i] *= factor;
            scaled.column_mut(i).scale_mut(factor);
            scaled.row_mut(i).unscale_mut(factor);
        }
    }
    (scaled, scale)
}

/// All modes of the complete model, of each complex pair the one with positive imaginary part, by Hessenberg form and QR.
fn all_motions(space: &SampledSpace, mass: &DMatrix<f64>) -> Vec<Oracle> {
    let (matrix, scale) = balanced_rows(&space.matrices.a);
    let (right, left) = (eigen(&matrix).expect("eigenvalues"), eigen(&matrix.transpose()).expect("eigenvalues"));
    let n = space.freedoms;
    let is_wake = |i: usize| space.states[i].0.contains(".circulation") || space.states[i].0.contains("].position.");
    let slow = (0..right.values.len()).filter(|&i| right.values[i].im >= 0.0 && right.values[i].norm() > 0.05);
    let of = |i: usize| {
        let z = right.values[i];
        let own = (0..left.values.len()).filter(|&j| left.values[j].im >= 0.0);
        let own = own.min_by(|&a, &b| (left.values[a] - z).norm().total_cmp(&(left.values[b] - z).norm()));
        let (x, y) = (vector(&right, i, |_| 1.0), vector(&left, own.expect("some"), |_| 1.0));
        let eigenvalue_1_s = z.ln() / space.step_s;
        let (place, rate) = (|k: usize| x[k] * scale[k], |k: usize| x[n + k] * scale[n + k]);
        let energy = |of: &dyn Fn(usize) -> Complex<f64>| -> f64 {
            let product = |i: usize, j: usize| (of(i).conj() * of(j)).re * mass[(i, j)];
            (0..n).map(|i| (0..n).map(|j| product(i, j)).sum::<f64>()).sum()
        };
        let hidden = energy(&|k| rate(k) - place(k) * eigenvalue_1_s) / energy(&rate);
        Oracle { eigenvalue_1_s, wake: share(&x, &y, &is_wake), hidden }
    };
    slow.map(of).collect()
}

/// The modes listed at the current state, after checking that they are eigenvalues of the complete model and that no slower mode of the
/// machine is missing.
fn listed_beside_the_whole(plant: &mut Plant, asked: usize, what: &str) -> Vec<Complex<f64>> {
    let (modes, _) = plant.study().lattice_modes_and_rest(asked).unwrap_or_else(|error| panic!("{what}: {error}"));
    let listed: Vec<Complex<f64>> = modes.iter().map(|mode| mode.eigenvalue_1_s).collect();
    let space = plant.study().lattice_space(&[], &|_| DVector::zeros(0)).unwrap_or_else(|error| panic!("{error}"));
    let second = plant.study().second_order().unwrap_or_else(|error| panic!("{error}"));
    let mut all = all_motions(&space, &second.mass);
    all.sort_by(|a, b| a.eigenvalue_1_s.norm().total_cmp(&b.eigenvalue_1_s.norm()));
    println!("{} states, listed {listed:.4?}", space.states.len());
    // an eigenvalue per step is accurate to round-off times its condition number
    let close = |a: Complex<f64>, b: Complex<f64>| (a - b).norm() < 1e-6 * b.norm() + 1e-9 / space.step_s;
    for value in listed.iter().filter(|value| value.norm() > 0.0) {
        let nearest = all.iter().map(|own| (own.eigenvalue_1_s - value).norm()).fold(f64::INFINITY, f64::min);
        let is_one = all.iter().any(|own| close(own.eigenvalue_1_s, *value));
        assert!(is_one, "{value} is none, nearest {nearest:e}\n{what}");
    }
    let last_1_s = if listed.len() < asked { 0.95 * PI / space.step_s } else { listed[asked - 1].norm() };
    for own in all.iter().filter(|own| own.eigenvalue_1_s.norm() < last_1_s * (1.0 - 1e-6)) {
        // far from the bound of one half, because the participation here also includes the memory of the impulse rate; motions without
        // resistance are listed as zeros, and such a double eigenvalue is accurate to the square root of its round-off
        let is_free = own.eigenvalue_1_s.norm() < 1e-9f64.sqrt() / space.step_s;
        let is_motion = own.wake < 0.25 && own.hidden < 0.25 && !is_free;
        let is_listed = listed.iter().any(|value| close(own.eigenvalue_1_s, *value));
        assert!(!is_motion || is_listed, "{own:?} is missing in {listed:?}\n{what}");
    }
    assert!(listed.is_sorted_by(|a, b| a.norm() <= b.norm() * (1.0 + 1e-9)), "{listed:?}\n{what}");
    listed
}

/// Every listed mode is an eigenvalue of the complete model, and none of the machine's slower modes is missing, for random small
/// machines, including free hinges, rolling wings, divergence and flutter. If fewer modes than requested are listed, there are no more.
#[test]
#[ignore = "long; `make long` runs it"]
fn q76_listed_modes_are_the_slowest_of_the_whole_model() {
    const ASKED: usize = 6;
    let (mut decaying, mut growing, mut few) = (0, 0, 0);
    for seed in 0..if is_whole() { 60 } else { 16 } {
        let text = machine(seed);
        let parsed = config::parse(&text, "small.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
        let mut plant = Plant::new(Arc::new(parsed));
        if let Err(error) = plant.study().equilibrium(0.0, Holding::AsReleased) {
            // beyond divergence a lifting wing has no equilibrium nearby
            println!("{seed}: {error}");
            continue;
        }
        let listed = listed_beside_the_whole(&mut plant, ASKED, &format!("{seed}:\n{text}"));
        decaying += listed.iter().filter(|value| value.im == 0.0 && value.re < 0.0).count();
        growing += listed.iter().filter(|value| value.re > 0.0).count();
        few += usize::from(listed.len() < ASKED);
    }
    println!("{decaying} decay, {growing} grow; {few} machines have fewer");
    assert!(decaying > 3 && growing > 0 && few > 0, "{decaying} decay, {growing} grow; {few} have fewer");
}

/// As Q-76 for the wing in the tunnel with fewer panels: many elements, whose fast motions alias to slower ones over the whole
/// sampled range, and a wake whose last row amplifies a decaying motion by a factor of up to 1e20. A search in circles about 0 listed only
/// four of the ten slowest modes.
#[test]
fn q87_a_wing_of_many_elements_lists_all_its_modes() {
    let text = include_str!("../../../examples/models/folding_wing_in_tunnel.toml");
    let coarse =
        [("strips = 10", "strips = 3"), ("chord_panels = 4", "chord_panels = 2"), ("wake_rows = 30", "wake_rows = 16")];
    let text = coarse.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    });
    let mut plant = Plant::new(Arc::new(config::parse(&text, "tunnel.toml").unwrap_or_else(|error| panic!("{error}"))));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    let listed = listed_beside_the_whole(&mut plant, 10, "tunnel");
    assert_eq!(listed.len(), 10);
}

/// A plate swept forward by 25° that diverges, or a plate held by a weak spring and a damper about the wind direction; both in a lattice
/// with steps in which the wind travels one panel.
fn plate(rolls: bool, speed_m_s: f64) -> Plant {
    let step_s = 0.1 / speed_m_s;
    let wall = match rolls {
        true => {
            "type = \"revolute\"\naxis = [0.0, 1.0, 0.0]\nstart_rate_deg_s = 1.0\n[joint.wall.motor]\nstiffness_N_m_rad = 0.4\ndamping_N_m_s_rad = 0.05"
        }
        false => "type = \"clamped\"\nmount_rotation_deg = [0.0, 0.0, 25.0]",
    };
    let wall = wall.replacen('\n', "\nparent = \"root\"\nchild = \"wing\"\n", 1);
    let text = format!(
        "name = \"Plate\"\n[section.spar]\nshape = \"rectangle\"\nwidth_m = 0.2\nheight_m = 0.002\ndensity_kg_m3 = 1600.0\nyoungs_modulus_Pa = 60e9\n\
         poisson_ratio = 0.3\n[body.wing]\nlength_m = 0.8\nsection = \"spar\"\nelements = 2\n[joint.wall]\n{wall}\n\
         [aerodynamics]\nmodel = \"uvlm\"\nwind_m_s = [0.0, {:?}, 0.0]\nstep_s = {step_s:?}\nwake_rows = 30\ncoupling_tolerance = 1e-9\n\
         [surface.wing]\nbody = \"wing\"\nchord_m = 0.2\nelastic_axis_fraction = 0.5\nstrips = 4\nchord_panels = 2\n\
         [solver]\ntolerance = 1e-9\nmax_step_s = {step_s:?}\n",
        -speed_m_s
    );
    Plant::new(Arc::new(config::parse(&text, "plate.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))))
}

/// Real modes, and the sign of the determinant of the static stiffness.
fn at_rest(plant: &mut Plant) -> (Vec<f64>, Option<bool>) {
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    let (modes, sign) = plant.study().lattice_modes_and_rest(8).unwrap_or_else(|error| panic!("{error}"));
    let real = modes.iter().map(|mode| mode.eigenvalue_1_s).filter(|value| value.im == 0.0);
    (real.map(|value| value.re).collect(), sign)
}

/// A forward-swept plate diverges where the determinant of its static stiffness vanishes: there a real mode passes through zero.
#[test]
fn q77_a_forward_swept_plate_diverges_where_its_stiffness_vanishes() {
    let (mut low_m_s, mut high_m_s) = (5.0, 60.0);
    while high_m_s - low_m_s > 1e-7 * low_m_s {
        let middle_m_s = 0.5 * (low_m_s + high_m_s);
        let (_, sign) = at_rest(&mut plate(false, middle_m_s));
        if sign == Some(true) { low_m_s = middle_m_s } else { high_m_s = middle_m_s }
    }
    let slowest = |speed_m_s: f64| {
        let (real, _) = at_rest(&mut plate(false, speed_m_s));
        real.into_iter().min_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or_else(|| panic!("none at {speed_m_s} m/s"))
    };
    let [below, above] = [0.9999, 1.0001].map(|factor| slowest(factor * low_m_s));
    assert!(below < 0.0 && above > 0.0, "{below} {above}");
    // linear between the two: over 0.2 % of the speed the curvature shifts the zero by 5e-6, over 0.02 % by a hundredth of that
    let zero_m_s = low_m_s * (0.9999 + 0.0002 * below / (below - above));
    println!("divergence at {low_m_s} m/s, real modes {below} and {above} 1/s beside, zero at {zero_m_s} m/s");
    assert!((zero_m_s / low_m_s - 1.0).abs() < 1e-6, "{zero_m_s} {low_m_s}");
    // this is the only unstable mode there
    assert_eq!(at_rest(&mut plate(false, 1.001 * low_m_s)).0.iter().filter(|value| **value > 0.0).count(), 1);
}

/// In a simulation the slowest mode remains: after a start with a rate, the wing returns in its slowest, non-oscillating mode; beyond
/// divergence it departs in the growing, non-oscillating mode.
#[test]
fn q77_what_only_decays_or_grows_does_so_in_time() {
    for (rolls, speed_m_s, from_s, to_s) in [(true, 12.0, 2.0, 4.0), (false, 31.0, 0.6, 0.9)] {
        let mut plant = plate(rolls, speed_m_s);
        let (real, _) = at_rest(&mut plant);
        let expected = match rolls {
            true => real.iter().copied().max_by(f64::total_cmp),
            false => real.iter().copied().find(|value| *value > 0.0),
        };
        let expected = expected.unwrap_or_else(|| panic!("no real mode: {real:?}"));
        let mut plant = plate(rolls, speed_m_s);
        if !rolls {
            // a disturbance small enough that the motion stays linear
            plant.inputs_mut().root_mut().gravity_m_s2.z = -1e-9;
        }
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let mut rate = |time_s: f64| {
            let step_s = 0.01;
            let mut height = [0.0; 2];
            for (i, height) in height.iter_mut().enumerate() {
                plant.step(time_s + i as f64 * step_s).unwrap_or_else(|error| panic!("{error}"));
                *height = plant.outputs().tips()[0].position_m.z;
            }
            height[1] - height[0]
        };
        let (begin, end) = (rate(from_s), rate(to_s));
        let marched = (end / begin).ln() / (to_s - from_s);
        println!("real modes {real:?}; in time {marched:.6} 1/s");
        assert!((marched / expected - 1.0).abs() < 1e-3, "{rolls}: {marched} {expected}");
    }
}
