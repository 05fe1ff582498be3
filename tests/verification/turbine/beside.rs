//! Motions about periodic steady states: multipliers with aerodynamics compared with simulations; modes that do not exist, are not found or
//! cannot be tracked.

use crate::turbine::machine::hinge_mut;
use crate::turbine::resonance::Resonance;
use crate::turbine::swing::Swing;
use foldwing::config;
use foldwing::machine::Machine;
use foldwing::plant::{Floquet, PeriodicMotion, Plant, Turn};
use nalgebra::{Complex, Matrix2, Vector2};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Multipliers of the slowest decaying pair, from the distances of a motion from the periodic one at the ends of revolutions, once all
/// other modes have decayed: `y(n+2) = (μ₁ + μ₂) y(n+1) − μ₁μ₂ y(n)` for all signals, by least squares with rows of equal size.
pub fn slowest_pair(distances: &[Vec<f64>]) -> Complex<f64> {
    let (mut normal, mut right) = (Matrix2::<f64>::zeros(), Vector2::<f64>::zeros());
    for three in distances.windows(3) {
        let size: f64 = three[0].iter().map(|x| x * x).sum();
        for ((first, second), third) in three[0].iter().zip(&three[1]).zip(&three[2]) {
            let row = Vector2::new(*second, -*first);
            normal += row * row.transpose() / size;
            right += row * (*third / size);
        }
    }
    let found = normal.lu().solve(&right).expect("two signals");
    let root = Complex::new(0.25 * found[0] * found[0] - found[1], 0.0).sqrt();
    root + 0.5 * found[0]
}

/// A periodic motion and its modes.
struct Found {
    motion: PeriodicMotion,
    floquet: Floquet,
}

fn find(machine: &Machine, speed_rad_s: f64, steps: usize, directions: usize) -> Found {
    let (machine, turn) = Turn::of(machine, Some("shaft"), Some(speed_rad_s), steps).expect("a turn");
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).expect("a start");
    let motion = plant.periodic(&turn, 1e-9).expect("a motion");
    let floquet = plant.floquet(&turn, &motion, directions).expect("modes");
    Found { motion, floquet }
}

/// A stiff blade of 2 m on a flap hinge, half a metre from a horizontal shaft, at 60 rpm; `air` are lines of `[aerodynamics]`; `None` for
/// no aerodynamics.
fn flapping(mass_kg: f64, youngs_modulus_pa: f64, gravity_m_s2: f64, air: Option<&str>) -> Machine {
    let density_kg_m3 = mass_kg / 0.2;
    let mut text = format!(
        "name = \"flapping\"\ngravity_m_s2 = [0, 0, {:?}]\n[rigid_body.hub]\nmass_kg = 50.0\ninertia_kg_m2 = [1, 1, 1, 0, 0, 0]\n\
         [joint.shaft]\ntype = \"revolute\"\nparent = \"root\"\nchild = \"hub\"\naxis = [1, 0, 0]\n\
         [section.s]\nshape = \"rectangle\"\nwidth_m = 1.0\nheight_m = 0.1\ndensity_kg_m3 = {density_kg_m3:?}\nyoungs_modulus_Pa = {youngs_modulus_pa:?}\n\
         poisson_ratio = 0.3\n[body.b]\nlength_m = 2.0\nsection = \"s\"\nelements = 1\n\
         [joint.flap]\ntype = \"revolute\"\nparent = \"hub\"\nchild = \"b\"\nparent_offset_m = [0, 0, 0.5]\n\
         mount_rotation_deg = [127.27922061357854, 0, 127.27922061357854]\naxis = [0, 1, 0]\nmotor = {{ stiffness_N_m_rad = 2000.0 }}\n",
        -gravity_m_s2
    );
    if let Some(lines) = air {
        text += "[aerodynamics]\nmodel = \"strip\"\ndensity_kg_m3 = 1.225\nwind_m_s = [0, 0, 0]\nstep_s = 0.006944444444444444\n";
        text += lines;
        text += "\n[surface.b]\nbody = \"b\"\nchord_m = 1.0\nelastic_axis_fraction = 0.25\nstrips = 4\n";
    }
    text += "[simulation]\nstop_time_s = 1.0\nstep_s = 0.01\n";
    config::parse(&text, "flapping.toml").unwrap_or_else(|refused| panic!("{refused}"))
}

/// WT-70. Floquet modes with strip theory: a blade flapping under gravity, with apparent mass, with Wagner's lag states, with both and a
/// lifting line. The slowest decaying pair compared with simulations with the same steps, one of them started 1e-4 rad from the other; the
/// remainder of other modes in their difference, (0.7/0.9)^24 of some per cent, and the nonlinearity at 1e-4 rad are below 1e-5.
#[test]
#[ignore = "long; `make long` runs it"]
fn wt70_modes_in_strips() {
    let cases = [
        ("quasi-steady", 60.0, "quasi_steady = true\napparent_mass = false", 3..9),
        ("apparent mass", 60.0, "quasi_steady = true", 3..9),
        ("lags", 400.0, "apparent_mass = false", 24..36),
        ("both, tip loss", 400.0, "tip_loss = \"lifting_line\"", 24..36),
    ];
    for (what, mass_kg, lines, turns) in cases {
        let machine = flapping(mass_kg, 60e9, 9.81, Some(lines));
        let Found { motion, floquet } = find(&machine, TAU, 144, 30);
        let (ready, turn) = Turn::of(&machine, Some("shaft"), Some(TAU), 144).expect("a turn");
        let mut marched = [0.0, 1e-4].map(|beside_rad| {
            let mut machine = ready.clone();
            hinge_mut(&mut machine, "flap").start_angle_rad += beside_rad;
            let mut plant = Plant::new(Arc::new(machine));
            plant.initialize(0.0).expect("a start");
            plant
        });
        let mut distances = Vec::new();
        for n in 1..turns.end {
            let [(q, v), (beside_q, beside_v)] = marched.each_mut().map(|plant| {
                plant.step(turn.period_s() * n as f64).expect("a turn");
                plant.free_state()
            });
            if n >= turns.start {
                distances.push(vec![beside_q[0] - q[0], (beside_v[0] - v[0]) / TAU]);
            }
        }
        let expected = slowest_pair(&distances);
        let slowest = floquet.modes.iter().find(|mode| mode.multiplier.im != 0.0).expect("a pair").multiplier;
        let off = (slowest - expected).norm().min((slowest.conj() - expected).norm());
        println!("WT-70 {what}: {} states, {slowest:.7}, march {expected:.7}, off by {off:.1e}", motion.states);
        assert!(off < 1e-5, "{what}: {slowest} {expected}");
        assert!(floquet.modes.iter().all(|mode| mode.multiplier.norm() < 1.0), "{what}: everything decays");
    }
}

/// WT-71. A machine without free coordinates: every motion over a revolution is periodic, and there are no modes; also with aerodynamics.
#[test]
fn wt71_nothing_is_free() {
    let rotor = Resonance::of(2);
    let mut rigid = rotor.machine();
    for name in ["rail", "seat", "lag0", "lag1"] {
        let body = rigid.bodies.iter_mut().find(|body| body.joint.name == name).expect("a joint");
        body.joint.kind = foldwing::machine::JointKind::Clamped;
    }
    let Found { motion, floquet } = find(&rigid, 10.0, 144, 10);
    assert_eq!((motion.states, motion.distance), (0, 0.0));
    assert!(floquet.modes.is_empty() && floquet.unfound == 0);
}

/// WT-72. An undamped blade, softer than steel, of steel, and 20 and 300 times as stiff as steel, at 60 rpm: all multipliers have magnitude
/// 1, nothing grows, and modes not resolved by the steps are counted, not listed: those listed with 288 steps are also found with 2880,
/// with errors of 4e-6 for 24 steps per period and 1e-5 for the products.
#[test]
fn wt72_modes_that_steps_follow() {
    for youngs_modulus_pa in [6e10, 2.1e11, 4e12, 6e13] {
        let machine = flapping(100.0, youngs_modulus_pa, 9.81, None);
        let [coarse, fine] = [288, 2880].map(|steps| find(&machine, TAU, steps, 40).floquet);
        for (steps, floquet) in [(288, &coarse), (2880, &fine)] {
            let sizes: Vec<f64> = floquet.modes.iter().map(|mode| mode.multiplier.norm() - 1.0).collect();
            let list: Vec<f64> = floquet.modes.iter().map(|mode| mode.frequency_hz).collect();
            let errors: Vec<f64> = floquet.modes.iter().map(|mode| mode.error).collect();
            println!(
                "WT-72 {youngs_modulus_pa:.1e} Pa, {steps} steps: {list:.4?} Hz, |μ| − 1 {sizes:?}, errors {errors:?}, coarse {}, unfound {}",
                floquet.coarse, floquet.unfound
            );
            assert!(floquet.modes.iter().all(|mode| !mode.is_growing()), "{youngs_modulus_pa:e} {steps}: {sizes:?}");
            assert!(!floquet.modes.is_empty() && sizes.iter().all(|size| size.abs() < 1e-4), "{sizes:?}");
        }
        // at 288 steps, modes of the stiffer blades decay completely within one revolution
        assert!(coarse.coarse > 0 || youngs_modulus_pa > 1e11);
        for mode in &coarse.modes {
            let off = |other: &f64| (other / mode.frequency_hz - 1.0).abs();
            let near = fine.modes.iter().map(|mode| mode.frequency_hz).min_by(|a, b| off(a).total_cmp(&off(b)));
            assert!(off(&near.expect("a mode")) < 1.4e-5, "{} Hz", mode.frequency_hz);
        }
    }
}

/// WT-73. Ground resonance with too few directions: the growing mode is not found, and this is reported.
#[test]
fn wt73_modes_that_directions_do_not_find() {
    let machine = Resonance::of(3).machine();
    for directions in [1, 4, 8, 10] {
        let Floquet { modes, unfound, largest_unfound, .. } = find(&machine, 21.0, 720, directions).floquet;
        println!(
            "WT-73 {directions} directions: {} modes, {unfound} not found, up to {largest_unfound:.3}",
            modes.len()
        );
        let grows = modes.iter().any(|mode| mode.is_growing());
        match directions {
            10 => assert!(grows && unfound == 0, "all are found"),
            _ => assert!(grows || unfound > 0, "{directions}: something grows that nothing is said of"),
        }
    }
}

/// WT-74. A rigid body clamped to the hub at an angle is not a blade: the listed modes and the averaged model do not change beyond the
/// error of the products. Unequal blades have no transformation to the fixed frame, and the cause is reported.
#[test]
fn wt74_a_spinner_is_no_blade() {
    let rotor = Resonance::of(3);
    let spinner = "[rigid_body.spinner]\nmass_kg = 1e-9\ninertia_kg_m2 = [1e-9, 1e-9, 1e-9, 0, 0, 0]\n[joint.spinner]\ntype = \"clamped\"\n\
                   parent = \"hub\"\nchild = \"spinner\"\nmount_rotation_deg = [20, 30, 0]\n[simulation]";
    let with = config::parse(&rotor.text().replace("[simulation]", spinner), "spinner.toml").expect("a machine");
    let [plain, with] = [&rotor.machine(), &with].map(|machine| find(machine, 15.0, 720, 10).floquet);
    assert!(plain.unseen.is_none() && with.unseen.is_none() && with.averaged.is_some(), "{:?}", with.unseen);
    for (mode, other) in plain.modes.iter().zip(&with.modes) {
        assert!((mode.exponent_1_s - other.exponent_1_s).norm() < 1e-3, "{mode:?} {other:?}");
    }
    let uneven = rotor.text().replacen("mount_rotation_deg = [120.0", "mount_rotation_deg = [110.0", 1);
    let uneven = config::parse(&uneven, "uneven.toml").expect("a machine");
    let told = find(&uneven, 15.0, 720, 4).floquet.unseen.expect("a cause");
    assert!(told.contains("evenly spaced"), "{told}");
}

/// WT-75. A blade without restraint about its hinge on the shaft's axis: both its multipliers are 1 to the square root of the products'
/// error; it is neutral, without damping, and nothing grows. The averaged model of two blades on an anisotropic support, whose stiffness
/// varies by a third, is only compared with modes within that distance.
#[test]
fn wt75_neutral_modes_and_averages_nearby() {
    let free = Swing {
        mass_kg: 50.0,
        inertia_kg_m2: 550.0,
        arm_m: 3.0,
        hinge_m: 0.0,
        spring_n_m_rad: 0.0,
        damping_n_m_s_rad: 0.0,
        gravity_m_s2: 0.0,
        speed_rad_s: 2.0,
    };
    let floquet = find(&free.machine(), free.speed_rad_s, 720, 2).floquet;
    assert!(!floquet.modes.is_empty(), "{floquet:?}");
    for mode in &floquet.modes {
        assert!(mode.is_neutral() && mode.damping_ratio == 0.0 && !mode.is_growing(), "{mode:?}");
    }
    let rotor = Resonance { support_n_m: [2e5, 3e5], ..Resonance::of(2) };
    let floquet = find(&rotor.machine(), 18.0, 720, 8).floquet;
    let spread = floquet.averaged.as_ref().expect("an average").spread;
    let mut without = 0;
    for mode in &floquet.modes {
        match mode.averaged_1_s {
            Some(value) => assert!((value - mode.exponent_1_s).norm() <= spread.max(1e-3) * value.norm(), "{mode:?}"),
            None => without += 1,
        }
    }
    println!(
        "WT-75: {without} of {} modes have no average nearby, stiffness changes by {spread:.2}",
        floquet.modes.len()
    );
}
