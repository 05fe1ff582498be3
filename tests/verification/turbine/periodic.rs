//! Periodic motions with the period of one revolution: against harmonic balance, Hill's equation, Coleman's closed form and simulations
//! whose transients have decayed.

use crate::turbine::beside::slowest_pair;
use crate::turbine::machine::*;
use crate::turbine::resonance::Resonance;
use crate::turbine::swing::Swing;
use crate::whole::is_whole;
use foldwing::machine::{JointMotion, Machine, Motion};
use foldwing::plant::{Floquet, FloquetMode, PeriodicMotion, Plant, SAMPLES, Turn};
use nalgebra::{Complex, DMatrix, Vector2};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// A plant at the start of a periodic revolution, with its modes if directions are given.
struct Found {
    plant: Plant,
    turn: Turn,
    motion: PeriodicMotion,
    floquet: Option<Floquet>,
}

fn find(
    machine: &Machine,
    shaft: Option<&str>,
    speed_rad_s: f64,
    steps: usize,
    directions: usize,
) -> Result<Found, String> {
    let (machine, turn) = Turn::of(machine, shaft, Some(speed_rad_s), steps)?;
    let told = |error: foldwing::plant::PlantError| error.to_string();
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).map_err(told)?;
    let motion = plant.periodic(&turn, 1e-9).map_err(told)?;
    let floquet = match directions {
        0 => None,
        _ => Some(plant.floquet(&turn, &motion, directions).map_err(told)?),
    };
    Ok(Found { plant, turn, motion, floquet })
}

/// A coordinate at the samples of the revolution.
fn over_the_turn(found: &mut Found, name: &str) -> Vec<f64> {
    let place = place(&found.plant, name);
    let mut list = Vec::new();
    let mut seen = |_: usize, plant: &mut Plant| {
        list.push(plant.free_state().0[place]);
        Ok(())
    };
    found.plant.trace(&found.turn, &found.motion, &mut seen).expect("a turn");
    list
}

/// A damped hinge that oscillates with an amplitude of 0.3 rad.
const SWING: Swing = Swing {
    mass_kg: 50.0,
    inertia_kg_m2: 550.0,
    arm_m: 3.0,
    hinge_m: 0.3,
    spring_n_m_rad: 6000.0,
    damping_n_m_s_rad: 60.0,
    gravity_m_s2: 9.81,
    speed_rad_s: 1.2,
};

/// The same hinge, barely damped, with a speed of twice the frequency of the blade: gravity excites it parametrically, and the motion is
/// unstable.
const DRIVEN: Swing = Swing { speed_rad_s: 8.05, damping_n_m_s_rad: 10.0, ..SWING };

/// WT-40. One blade on a lag hinge under gravity: harmonic balance with 48 points (their highest harmonics are below 1e-13) for the motion,
/// Hill's equation about it for the multipliers. Fixed steps of fourth order: 1440 per revolution have an error of 1e-8, and multipliers by
/// differences one of 1e-7; 1e-6 is allowed for exponents.
#[test]
fn wt40_a_blade_that_swings() {
    for (what, swing, unstable) in [("damped", SWING, false), ("driven", DRIVEN, true)] {
        let reference = swing.balanced(48);
        let mut found = find(&swing.machine(), Some("shaft"), swing.speed_rad_s, 1440, 2).expect("a motion");
        let lag = over_the_turn(&mut found, "lag.angle");
        let amplitude = reference.amax();
        let miss = (0..48).map(|k| (lag[3 * k] - reference[k]).abs()).fold(0.0, f64::max);
        let floquet = found.floquet.as_ref().expect("modes");
        let period_s = TAU / swing.speed_rad_s;
        let mut worst = 0.0f64;
        let multipliers = swing.multipliers(&reference);
        for mode in &floquet.modes {
            let exponent = |value: &Complex<f64>| value.ln() / period_s;
            let near = |value: &&Complex<f64>| {
                let own = exponent(&mode.multiplier);
                (exponent(value) - own).norm().min((exponent(value).conj() - own).norm())
            };
            let nearest = multipliers.iter().min_by(|a, b| near(a).total_cmp(&near(b))).expect("a multiplier");
            worst = worst.max(near(&nearest) / swing.speed_rad_s);
        }
        let largest = floquet.modes[0].multiplier;
        println!(
            "WT-40 {what}: amplitude {amplitude:.3} rad, off by {miss:.1e} rad; multipliers {largest:.6} {multipliers:?}, exponents off by \
             {worst:.1e} of the speed; {} Newton steps, {} turns",
            found.motion.newton_steps, found.motion.turns
        );
        assert!(miss < 1e-7 && worst < 1e-6, "{what}: {miss:.1e} rad, {worst:.1e}");
        assert_eq!(largest.norm() > 1.0, unstable, "{what}");
        assert_eq!(floquet.modes.len(), if unstable { 2 } else { 1 }, "{:?}", floquet.modes);
        if unstable {
            assert!(largest.re < -1.0 && largest.im == 0.0, "half the speed: {largest}");
            assert!((floquet.modes[0].exponent_1_s.im / swing.speed_rad_s - 0.5).abs() < 1e-9);
            // a simulation departs from the unstable motion found by shooting: from a distance of 1e-5 rad the distance grows by the
            // multiplier in each revolution, up to the remainder of the other direction, (0.87/1.13)^40, and the nonlinearity at 1e-3 rad
            let leaves = leaving(&mut found, 40);
            println!("WT-40 {what}: leaves by {leaves:.4} per turn");
            assert!((leaves / largest.re.abs() - 1.0).abs() < 1e-2, "{leaves}");
        }
    }
}

/// Growth per revolution of the distance of a simulation, started 1e-5 rad from a motion, over its last revolutions.
fn leaving(found: &mut Found, turns: usize) -> f64 {
    let period_s = found.turn.period_s();
    found.plant.restore(&found.motion.start).expect("the begin");
    let begin = found.plant.free_state();
    let mut distances = Vec::new();
    let mut machine = found.plant.machine().clone();
    let hinge = hinge_mut(&mut machine, "lag");
    hinge.start_angle_rad = begin.0[0] + 1e-5;
    hinge.start_rate_rad_s = begin.1[0];
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).expect("a start");
    for turn in 1..=turns {
        plant.step(period_s * turn as f64).expect("a turn");
        let now = plant.free_state();
        distances.push(Vector2::new(now.0[0] - begin.0[0], (now.1[0] - begin.1[0]) / found.turn.speed_rad_s).norm());
    }
    distances[turns - 1] / distances[turns - 2]
}

/// Multipliers of one revolution, by Runge–Kutta, of the linear equations of [`Resonance`] with any number of blades: support along y and
/// z, then lag angles.
fn resonance_multipliers(rotor: &Resonance, speed_rad_s: f64) -> Vec<Complex<f64>> {
    let (n, w) = (2 + rotor.blades, speed_rad_s);
    let s = rotor.mass_kg * rotor.arm_m;
    let whole = rotor.support_kg + rotor.blades as f64 * rotor.mass_kg;
    let stiff = rotor.spring_n_m_rad + s * rotor.hinge_m * w * w;
    let of = |t: f64| -> DMatrix<f64> {
        let mut mass = DMatrix::zeros(n, n);
        let mut damping = DMatrix::zeros(n, n);
        let mut stiffness = DMatrix::zeros(n, n);
        for axis in 0..2 {
            mass[(axis, axis)] = whole;
            stiffness[(axis, axis)] = rotor.support_n_m[axis];
        }
        for k in 0..rotor.blades {
            let (sine, cosine) = (w * t + TAU * k as f64 / rotor.blades as f64).sin_cos();
            let (along, across) = ([cosine, sine], [-sine, cosine]);
            mass[(2 + k, 2 + k)] = rotor.inertia_kg_m2;
            stiffness[(2 + k, 2 + k)] = stiff;
            for axis in 0..2 {
                mass[(axis, 2 + k)] += s * across[axis];
                mass[(2 + k, axis)] += s * across[axis];
                damping[(axis, 2 + k)] -= 2.0 * s * w * along[axis];
                stiffness[(axis, 2 + k)] -= s * w * w * across[axis];
            }
        }
        let lu = mass.lu();
        let (c, k) = (lu.solve(&damping).expect("a mass"), lu.solve(&stiffness).expect("a mass"));
        DMatrix::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
            (true, true) => 0.0,
            (true, false) => f64::from(u8::from(i + n == j)),
            (false, true) => -k[(i - n, j)],
            (false, false) => -c[(i - n, j - n)],
        })
    };
    let steps = 4000;
    let h = TAU / w.abs() / f64::from(steps);
    let mut turn = DMatrix::<f64>::identity(2 * n, 2 * n);
    for k in 0..steps {
        let t = h * f64::from(k);
        let (a, b, c) = (of(t), of(t + 0.5 * h), of(t + h));
        let k1 = a * &turn;
        let k2 = &b * (&turn + &k1 * (0.5 * h));
        let k3 = &b * (&turn + &k2 * (0.5 * h));
        let k4 = c * (&turn + &k3 * h);
        turn += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
    }
    turn.complex_eigenvalues().iter().copied().collect()
}

/// Largest distance of found multipliers from the nearest of a list, relative to their magnitude.
fn multipliers_off(floquet: &Floquet, expected: &[Complex<f64>]) -> f64 {
    let off = |value: Complex<f64>| {
        let near = |other: &Complex<f64>| (other - value).norm().min((other.conj() - value).norm());
        expected.iter().map(near).fold(f64::INFINITY, f64::min) / value.norm()
    };
    floquet.modes.iter().map(|mode| off(mode.multiplier)).fold(0.0, f64::max)
}

/// WT-41. Ground resonance. Three blades on an isotropic support: exponents and frequencies are Coleman's, and those of the averaged model;
/// the growing one is found. Two blades on an anisotropic support: the multipliers are those of the linear equations derived by hand; the
/// averaged model does not show the growth. Eigenvalues of the undamped rotor come in close pairs: an error `e` of products by differences,
/// 1e-8, can move them by the square root of `e`, depending on their distance; 1e-5 is allowed.
#[test]
fn wt41_floquet_where_coleman_holds_and_where_not() {
    let rotor = Resonance::of(3);
    for speed_rad_s in [15.0, 21.0, -15.0] {
        let found = find(&rotor.machine(), None, speed_rad_s, 720, 10).expect("a motion");
        let floquet = found.floquet.expect("modes");
        let off = multipliers_off(&floquet, &resonance_multipliers(&rotor, speed_rad_s));
        let mut worst = [0.0f64; 2];
        for root in rotor.closed_form(speed_rad_s) {
            let value = Complex::new(0.0, 1.0) * root;
            let expected = if value.im < 0.0 { value.conj() } else { value };
            let near = |other: Complex<f64>| (other - expected).norm() / expected.norm();
            worst[0] =
                worst[0].max(floquet.modes.iter().map(|mode| near(mode.exponent_1_s)).fold(f64::INFINITY, f64::min));
            let averaged = &floquet.averaged.as_ref().expect("an average").eigenvalues_1_s;
            worst[1] = worst[1].max(averaged.iter().map(|value| near(*value)).fold(f64::INFINITY, f64::min));
        }
        println!(
            "WT-41 three blades at {speed_rad_s} rad/s: multipliers {off:.1e}, exponents {:.1e}, averaged {:.1e}",
            worst[0], worst[1]
        );
        assert!(off < 1e-5 && worst[0] < 1e-5 && worst[1] < 1e-8, "{speed_rad_s} rad/s: {off:.1e} {worst:?}");
        assert!(floquet.averaged.expect("an average").spread < 1e-8);
        if speed_rad_s == 21.0 {
            assert!(floquet.modes[0].multiplier.norm() > 1.1, "ground resonance");
        }
    }
    let rotor = Resonance { support_n_m: [2e5, 3e5], ..Resonance::of(2) };
    let mut missed = 0.0f64;
    for speed_rad_s in [10.0, 18.0, 30.0] {
        let found = find(&rotor.machine(), None, speed_rad_s, 720, 8).expect("a motion");
        let floquet = found.floquet.expect("modes");
        let expected = resonance_multipliers(&rotor, speed_rad_s);
        let off = multipliers_off(&floquet, &expected);
        let averaged = floquet.averaged.as_ref().expect("an average");
        let period_s = TAU / speed_rad_s;
        let growth = |list: &mut dyn Iterator<Item = f64>| list.fold(f64::MIN, f64::max);
        let grows = [
            growth(&mut floquet.modes.iter().map(|mode| mode.exponent_1_s.re)),
            growth(&mut averaged.eigenvalues_1_s.iter().map(|value| value.re)),
            growth(&mut expected.iter().map(|value| value.norm().ln() / period_s)),
        ];
        println!(
            "WT-41 two blades at {speed_rad_s} rad/s: multipliers {off:.1e}; growth {:.5} (averaged {:.5}, reference {:.5}) 1/s; stiffness \
             changes by {:.2}",
            grows[0], grows[1], grows[2], averaged.spread
        );
        assert!(off < 1e-5, "{speed_rad_s} rad/s: {off:.1e}");
        assert!(averaged.spread > 1e-2);
        missed = missed.max((grows[0] - grows[1]).abs());
    }
    assert!(missed > 0.1, "averaging loses growth: {missed}");
}

/// The example with more damping, so that the transient decays in a simulation of three minutes: with the nacelle only a third of the
/// tower's damping remains.
fn damped() -> Machine {
    let mut machine = turbine();
    for (name, ratio) in [("tower", 0.2), ("blade1", 0.05), ("blade2", 0.05), ("blade3", 0.05)] {
        let law = law_mut(&mut machine, name);
        law.flap.iter_mut().chain(&mut law.edge).for_each(|shape| shape.damping_ratio = ratio);
    }
    machine
}

const SPEED_RAD_S: f64 = 12.1 * PI / 30.0;

/// WT-42. The 5 MW turbine without aerodynamics, with tilt and gravity, shaft at 12.1 rpm. The state at the start of a revolution compared
/// with a simulation with variable steps at a tolerance of 1e-9 whose transient has decayed: 1e-8 for coordinates is the accumulated error
/// of the simulation; errors of rates of modes at ten times the rotor speed are ten times as large.
#[test]
fn wt42_the_turbine_under_gravity() {
    let machine = damped();
    let mut found = find(&machine, None, SPEED_RAD_S, 720, 0).expect("a motion");
    println!(
        "WT-42: {} states, {:.1e} after {} Newton steps, {} turns",
        found.motion.states, found.motion.distance, found.motion.newton_steps, found.motion.turns
    );
    found.plant.restore(&found.motion.start).expect("the begin");
    let (q, v) = found.plant.free_state();
    let mut marched = found.plant.machine().clone();
    marched.solver.fixed_step_s = None;
    marched.solver.tolerance = 1e-9;
    let mut plant = Plant::new(Arc::new(marched));
    plant.initialize(0.0).expect("a start");
    let turns = 36;
    plant.step(found.turn.period_s() * f64::from(turns)).expect("a march");
    let (marched_q, marched_v) = plant.free_state();
    let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let largest = q.iter().fold(0.0f64, |largest, x| largest.max(x.abs()));
    let (off_q, off_v) = (off(&q, &marched_q), off(&v, &marched_v) / SPEED_RAD_S);
    println!("WT-42: off the march by {off_q:.1e}, rates {off_v:.1e}, of {largest:.3} m");
    assert!(off_q < 1e-8 && off_v < 1e-7, "{off_q:.1e} {off_v:.1e}");
    // gravity excites the edgewise motion of a blade once per revolution; there is no other excitation
    let once = |found: &mut Found| {
        let edge = over_the_turn(found, "blade1.mode[3]");
        let wave = (0..SAMPLES)
            .map(|k| edge[k] * (Complex::new(0.0, -TAU * k as f64 / SAMPLES as f64)).exp())
            .sum::<Complex<f64>>();
        2.0 * wave.norm() / SAMPLES as f64
    };
    let mut still = damped();
    still.gravity_m_s2 *= 0.0;
    let with = once(&mut found);
    let without = once(&mut find(&still, None, SPEED_RAD_S, 720, 0).expect("a motion"));
    println!("WT-42: edge once per turn {with:.4} m, without gravity {without:.1e} m");
    assert!(without < 1e-8 && with > 0.1, "{with} {without}");
}

/// WT-43. The example with gravity: fifteen modes about its periodic motion, named in the fixed frame. Without gravity they are those of
/// the averaged model, which is then exact, to the error of the steps: fourth order, 2e-6 for the yaw mode at 6 Hz with 29 steps per
/// period. Short studies: without gravity.
#[test]
#[ignore = "long; `make long` runs it"]
fn wt43_modes_of_the_turbine() {
    let mut still = turbine();
    still.gravity_m_s2 *= 0.0;
    let machines = [("without gravity", still), ("with gravity", turbine())];
    for (what, machine) in machines.into_iter().take(if is_whole() { 2 } else { 1 }) {
        let found = find(&machine, None, SPEED_RAD_S, 864, 30).expect("a motion");
        let floquet = found.floquet.expect("modes");
        let mut worst = 0.0f64;
        for mode in &floquet.modes {
            let averaged = mode.averaged_1_s.expect("an average");
            let off = (averaged - mode.exponent_1_s).norm() / averaged.norm();
            worst = worst.max(off);
            println!(
                "WT-43 {what}: {:9.6} Hz {:8.6} averaged {:9.6} Hz {:8.6} {:.3} {}{}",
                mode.frequency_hz,
                mode.damping_ratio,
                averaged.norm() / TAU,
                -averaged.re / averaged.norm(),
                mode.harmonics[0].share,
                mode.parts[0],
                if mode.ambiguous { " ambiguous" } else { "" }
            );
        }
        println!("WT-43 {what}: {} modes, off the averaged by {worst:.1e}", floquet.modes.len());
        assert_eq!((floquet.modes.len(), floquet.coarse, floquet.unfound), (15, 0, 0), "{what}");
        assert!(floquet.unseen.is_none(), "{what}");
        // averaging changes modes only in second order
        let spread = floquet.averaged.as_ref().expect("an average").spread;
        println!("WT-43 {what}: stiffness changes by {spread:.1e}");
        assert!(worst < spread.max(1e-5), "{what}: {worst:.1e} {spread:.1e}");
        if what == "without gravity" {
            assert!(worst < 1e-5, "{worst:.1e}");
            let off = |mode: &FloquetMode| {
                let averaged = mode.averaged_1_s.expect("an average");
                (averaged - mode.exponent_1_s).norm() / averaged.norm()
            };
            // compare only modes that 432 steps per revolution resolve; above 1440 steps the error of the finite-difference products of the
            // monodromy matrix, about 1e-7, dominates
            let coarse = find(&machine, None, SPEED_RAD_S, 432, 30).expect("a motion").floquet.expect("modes").modes;
            let highest_hz = coarse.iter().map(|mode| mode.frequency_hz).fold(0.0, f64::max);
            assert!(coarse.len() < 15 && highest_hz < 432.0 / 24.0 * SPEED_RAD_S / TAU * 1.05, "{highest_hz} Hz");
            let error = |modes: &[FloquetMode]| {
                modes.iter().filter(|mode| mode.frequency_hz < 1.01 * highest_hz).map(off).fold(0.0, f64::max)
            };
            let ratio = error(&coarse) / error(&floquet.modes);
            println!("WT-43: half the step divides the error by {ratio:.1}");
            assert!((12.0..20.0).contains(&ratio), "order {}", ratio.log2());
        }
    }
}

/// Asserts that a machine has no periodic motion, with an error that contains the words.
fn refused(machine: &Machine, shaft: Option<&str>, speed_rad_s: f64, words: &[&str]) {
    let told = match find(machine, shaft, speed_rad_s, 144, 0) {
        Err(told) => told,
        Ok(found) => panic!("found {:?}", found.motion.distance),
    };
    for word in words {
        assert!(told.contains(word), "{word:?} is missing in {told}");
    }
}

/// WT-44. Machines without a periodic motion are rejected with the cause.
#[test]
fn wt44_refusals() {
    let swing = SWING.machine();
    for speed_rad_s in [0.0, f64::NAN, f64::INFINITY, 1e-320] {
        refused(&swing, Some("shaft"), speed_rad_s, &["speed", "static equilibrium"]);
    }
    refused(&swing, None, 1.0, &["no rotor", "name the joint of the shaft"]);
    refused(&swing, Some("shafts"), 1.0, &["shaft shafts", "no joint"]);
    assert!(Turn::of(&swing, Some("shaft"), None, 144).unwrap_err().contains("give its speed"));
    assert!(Turn::of(&swing, Some("shaft"), Some(1.0), 0).unwrap_err().contains("0 steps"));
    // a second joint with a prescribed motion
    let mut moved = swing.clone();
    hinge_mut(&mut moved, "lag").motion = JointMotion::Prescribed(Motion::Polynomial(vec![0.0, 1.0]));
    refused(&moved, Some("shaft"), 1.0, &["joint lag", "prescribed motion"]);
    // so slow that a revolution takes two years: the hinge is in equilibrium at every azimuth
    let slow = Swing { speed_rad_s: 1e-7, ..SWING };
    let mut found = find(&swing, Some("shaft"), slow.speed_rad_s, 144, 0).expect("a motion");
    let lag = over_the_turn(&mut found, "lag.angle");
    let left = lag.iter().enumerate().map(|(k, lag)| slow.left(TAU * k as f64 / SAMPLES as f64, *lag)[0].abs());
    let left = left.fold(0.0, f64::max);
    println!("WT-44: at rest at every azimuth to {left:.1e} rad/s²");
    assert!(left < 1e-7, "{left:.1e}");
    // a hinge without spring whose weight makes it rotate over: relative to the hub it rotates without end
    let loose = Swing { spring_n_m_rad: 0.0, damping_n_m_s_rad: 0.0, ..SWING };
    let told = find(&loose.machine(), Some("shaft"), 0.05, 144, 0).err().expect("no motion");
    assert!(
        told.contains("no periodic revolution of the shaft was found") || told.contains("no convergence"),
        "{told}"
    );
    // end stops within the range of the motion
    let mut stopped = swing.clone();
    hinge_mut(&mut stopped, "lag").end_stops = Some(foldwing::machine::EndStops {
        lower_rad: None,
        upper_rad: Some(0.1),
        stiffness_n_m_rad: 1e5,
        damping_n_m_s_rad: 1e3,
    });
    refused(&stopped, Some("shaft"), SWING.speed_rad_s, &["joint lag", "stops"]);
    // at a thousand times the speed the hinge is stiffened by centrifugal forces, and does not move
    let mut fast = find(&swing, Some("shaft"), 1000.0 * SWING.speed_rad_s, 720, 0).expect("a motion");
    let lag = over_the_turn(&mut fast, "lag.angle");
    assert!(lag.iter().all(|lag| lag.abs() < 1e-4), "{lag:?}");
    // reverse rotation
    let back = find(&swing, Some("shaft"), -SWING.speed_rad_s, 720, 2).expect("a motion");
    assert!(back.floquet.expect("modes").modes[0].multiplier.norm() < 1.0);
}

/// WT-45. In wind: the example at 8 m/s with shear, tilt and gravity, shaft speed prescribed at 9.16 rpm. The state is compared with a
/// simulation of the same machine, whose transient decays as the slowest Floquet mode: 1e-3 of this.
#[test]
#[ignore = "long; `make long` runs it"]
fn wt45_the_turbine_in_wind() {
    let machine = windy(WIND_TEXT);
    let speed_rad_s = 9.16 * PI / 30.0;
    let (ready, turn) = Turn::of(&machine, None, Some(speed_rad_s), 288).expect("a turn");
    let mut plant = Plant::new(Arc::new(ready));
    plant.inputs_mut().wind_m_s_mut().x = 8.0;
    plant.initialize(0.0).expect("a start");
    let clock = std::time::Instant::now();
    let motion = plant.periodic(&turn, 1e-7).expect("a motion");
    println!(
        "WT-45: {} states, {:.1e} after {} Newton steps and {} revolutions, {:.1} s",
        motion.states,
        motion.distance,
        motion.newton_steps,
        motion.turns,
        clock.elapsed().as_secs_f64()
    );
    let (q, _) = plant.free_state();
    let mut marched = Plant::new(Arc::new(plant.machine().clone()));
    marched.inputs_mut().wind_m_s_mut().x = 8.0;
    marched.initialize(0.0).expect("a start");
    let far = |plant: &Plant| -> Vec<f64> { plant.free_state().0.iter().zip(&q).map(|(now, q)| now - q).collect() };
    let begun = far(&marched).iter().map(|x| x.abs()).fold(0.0, f64::max);
    let turns = if is_whole() { 120 } else { 30 };
    let mut distances = Vec::new();
    for n in 1..=turns {
        marched.step(turn.period_s() * f64::from(n)).expect("a march");
        if (22..=30).contains(&n) {
            distances.push(far(&marched));
        }
    }
    let (marched_q, _) = marched.free_state();
    let off = q.iter().zip(&marched_q).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("WT-45: off the march of {turns} turns by {off:.1e} m or rad");
    // the simulation approaches as its slowest mode, the tower's side-to-side mode, decays, relative to the initial distance
    let floquet = plant.floquet(&turn, &motion, 36).expect("modes");
    assert_eq!(motion.states, floquet.states);
    assert_eq!(motion.states, 2 * q.len(), "no feature in use lags");
    assert!(floquet.modes.iter().all(|mode| !mode.is_neutral() && mode.multiplier.norm() < 0.95), "{floquet:?}");
    let slowest = floquet.modes[0].multiplier;
    let allowed = begun * slowest.norm().powi(turns) + 1e-5;
    println!("WT-45: begins {begun:.2} off, allowed {allowed:.1e}");
    assert!(off < allowed, "{off:.1e} {allowed:.1e}");
    // after 22 revolutions other modes are (0.54/0.92)^22 = 1e-5 of it; its magnitude is 1e-2 m, compared with 1e-6 m of the closed
    // revolution
    let expected = slowest_pair(&distances);
    let miss = (slowest - expected).norm().min((slowest.conj() - expected).norm());
    println!("WT-45: slowest mode {slowest:.6}, the march's {expected:.6}, off by {miss:.1e}");
    assert!(miss < 1e-3, "{slowest} {expected}");
}
