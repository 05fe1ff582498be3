//! W-10 to W-18: the strip in unsteady plane flow.

use crate::strips::plate::{Loads, Motion, Plate};
use crate::strips::theory::{Aerofoil, kuessner, theodorsen, wagner};
use foldwing::aero::continuous_turbulence::{Component, ContinuousTurbulence, Spectrum};
use foldwing::aero::flow::{Gust, GustShape};
use foldwing::aero::polar::{Polar, PolarRow};
use foldwing::aero::strip::StripOptions;
use foldwing::aero::strip::indicial::Indicial;
use foldwing::aero::surface::Profile;
use nalgebra::{Complex, Vector3};
use std::f64::consts::{PI, TAU};

/// Amplitude in rad and in semi-chords: small enough that its square is negligible.
const SMALL: f64 = 1e-6;

/// Transform of the exponential fit to Wagner's function, which replaces Theodorsen's function in the strips.
pub fn fitted_theodorsen(k: f64) -> Complex<f64> {
    let p = Complex::new(0.0, k);
    let Indicial { weights, rates, .. } = Indicial::WAGNER;
    weights.iter().zip(rates).fold(Complex::new(1.0, 0.0), |c, (weight, rate)| c - p * *weight / (p + rate))
}

/// First harmonic over the last of `periods` periods; the sample times are shifted back by `lag` steps.
fn harmonic(history: &[Loads], steps: usize, lag: f64, value: impl Fn(&Loads) -> f64) -> Complex<f64> {
    let first = history.len() - steps;
    let sum: Complex<f64> = (first..history.len())
        .map(|i| Complex::from_polar(2.0 / steps as f64, -TAU * (i as f64 - lag) / steps as f64) * value(&history[i]))
        .sum();
    sum
}

/// Lift and moment of a harmonic motion, as complex amplitudes, after the initial transient.
fn measured(plate: &Plate, k: f64, heave: bool, steps: usize) -> [Complex<f64>; 2] {
    let omega_rad_s = k / plate.semi_chord_s();
    let amplitude = if heave { SMALL * plate.semi_chord_m } else { SMALL };
    let motion = |time_s: f64| {
        let (sine, cosine) = (omega_rad_s * time_s).sin_cos();
        let (value, rate) = (amplitude * cosine, -amplitude * omega_rad_s * sine);
        match heave {
            true => Motion { heave_m: value, heave_m_s: rate, ..Default::default() },
            false => Motion { pitch_rad: value, pitch_rad_s: rate, ..Default::default() },
        }
    };
    // the slow lag needs 700 semi-chords for its initial transient to decay to 1e-14
    let periods = (700.0 * k / TAU).ceil() as usize + 1;
    let history = plate.march(motion, &[], true, TAU / omega_rad_s / steps as f64, periods * steps);
    let (circulatory, impulsive): (Vec<Loads>, Vec<Loads>) = history.iter().map(|[c, i]| (*c, *i)).unzip();
    let whole = |value: fn(&Loads) -> f64| {
        // impulsive loads are means over a step: they belong to its middle
        harmonic(&circulatory, steps, 0.0, value) + harmonic(&impulsive, steps, 0.5, value)
    };
    [whole(|loads| loads.lift_n_m), whole(|loads| loads.moment_n)]
}

/// Theory with Theodorsen's function replaced by `lag`.
fn expected(plate: &Plate, k: f64, heave: bool, lag: Complex<f64>) -> [Complex<f64>; 2] {
    let aerofoil = Aerofoil {
        density_kg_m3: plate.density_kg_m3,
        speed_m_s: plate.speed_m_s,
        semi_chord_m: plate.semi_chord_m,
        axis: plate.axis,
    };
    let (zero, one) = (Complex::new(0.0, 0.0), Complex::new(SMALL, 0.0));
    let (heave_m, pitch_rad) = if heave { (one * plate.semi_chord_m, zero) } else { (zero, one) };
    let response = aerofoil.response(lag, k, heave_m, pitch_rad);
    [response.lift_n_m(), response.moment_n()]
}

/// W-10. Sudden start: the lift grows as given by the fit, exactly for any step; the fit is within 0.0097 of Wagner's function.
#[test]
fn w10_sudden_start_follows_wagner() {
    let plate = Plate::default();
    let incidence = Motion { pitch_rad: SMALL, ..Default::default() };
    let full_n_m = TAU * plate.density_kg_m3 * plate.speed_m_s.powi(2) * plate.semi_chord_m * SMALL;
    let mut worst: f64 = 0.0;
    for per_semi_chord in [2.0, 10.0] {
        let steps = (60.0 * per_semi_chord) as usize;
        let history = plate.march(|_| incidence, &[], false, plate.semi_chord_s() / per_semi_chord, steps);
        for (i, [circulatory, impulsive]) in history.iter().enumerate() {
            let s = i as f64 / per_semi_chord;
            let ours = circulatory.lift_n_m / full_n_m;
            assert!((ours - Indicial::WAGNER.at(s)).abs() < 1e-10, "s = {s}: {ours}"); // squares of the incidence
            assert!(impulsive.lift_n_m.abs() < 1e-12 * full_n_m);
            if i % per_semi_chord as usize == 0 {
                worst = worst.max((ours - wagner(s)).abs());
            }
        }
    }
    println!("W-10 largest distance from Wagner's function: {worst:.4}");
    assert!(worst < 0.0097, "{worst}"); // the error of the fit as documented
}

/// W-11. Heave and pitch about four axes, `k` from 0.05 to 1: lift and moment against Theodorsen.
///
/// Against theory with the transform of the fit, the difference is only the error of the step (200 per period, second order: (2π/200)²/12 =
/// 8e-5 of the largest part). Against Theodorsen's function it includes the error of the fit.
#[test]
fn w11_harmonic_motion_follows_theodorsen() {
    for axis in [-0.5, -0.3, 0.0, 0.4] {
        let plate = Plate { axis, ..Default::default() };
        for heave in [true, false] {
            let name = if heave { "heave" } else { "pitch" };
            let mut most = [0.0_f64; 4];
            for k in [0.05, 0.1, 0.2, 0.3, 0.5, 0.8, 1.0] {
                let ours = measured(&plate, k, heave, 200);
                let fitted = expected(&plate, k, heave, fitted_theodorsen(k));
                let exact = expected(&plate, k, heave, theodorsen(k));
                // moments about an axis near the centre of pressure vanish: scale them by lift times semi-chord
                let scales = [exact[0].norm(), exact[1].norm().max(exact[0].norm() * plate.semi_chord_m * 0.5)];
                for i in 0..2 {
                    let off = (ours[i] - fitted[i]).norm() / scales[i];
                    assert!(off < 2e-4, "{name} about {axis}, k = {k}, part {i}: {off:.1e}");
                }
                let lift = ours[0] / exact[0];
                most[0] = most[0].max((lift.norm() - 1.0).abs());
                most[1] = most[1].max(lift.arg().abs().to_degrees());
                most[2] = most[2].max((ours[1] - exact[1]).norm() / scales[1]);
                let moment = ours[1] / exact[1];
                most[3] = most[3].max(if exact[1].norm() < scales[1] { 0.0 } else { moment.arg().abs().to_degrees() });
                if axis == -0.3 {
                    println!(
                        "W-11 {name} k = {k}: lift {:+.2} %, {:+.2}°; moment {:+.2} %, {:+.2}°",
                        100.0 * (lift.norm() - 1.0),
                        lift.arg().to_degrees(),
                        100.0 * (moment.norm() - 1.0),
                        moment.arg().to_degrees()
                    );
                }
            }
            println!(
                "W-11 {name} about {axis:+.1}: lift within {:.2} % and {:.2}°, moment within {:.2} % and {:.2}°",
                100.0 * most[0],
                most[1],
                100.0 * most[2],
                most[3]
            );
            // the fit's transform is off by at most 0.0142 at these k, where |C| > 0.54: 2.7 % at worst, and less with apparent mass in
            // addition
            assert!(most[0] < 0.027 && most[2] < 0.027, "{name} about {axis}: {most:?}");
            assert!(most[1] < 1.6, "{name} about {axis}: {most:?}");
        }
    }
}

/// W-12. The error falls with the square of the step.
#[test]
fn w12_second_order_in_the_step() {
    let plate = Plate { axis: -0.3, ..Default::default() };
    for heave in [true, false] {
        let exact = expected(&plate, 0.4, heave, fitted_theodorsen(0.4));
        let error = |steps: usize| {
            let ours = measured(&plate, 0.4, heave, steps);
            [0, 1].map(|i| (ours[i] - exact[i]).norm() / exact[i].norm())
        };
        let (coarse, fine) = (error(25), error(50));
        for i in 0..2 {
            let order = (coarse[i] / fine[i]).log2();
            println!("W-12 heave {heave}, part {i}: {:.1e}, {:.1e}, order {order:.2}", coarse[i], fine[i]);
            assert!((order - 2.0).abs() < 0.1, "{order}");
        }
    }
}

/// W-13. Sharp-edged gust, stationary in the air: Küssner's function; a 1 − cosine gust: Duhamel's integral with it.
#[test]
fn w13_gust_follows_kuessner() {
    let plate = Plate::default();
    let leading_m = plate.semi_chord_m;
    let gust = |shape| Gust {
        name: "gust".into(),
        shape,
        velocity_m_s: Vector3::z() * SMALL * plate.speed_m_s,
        direction: -Vector3::y(),
        speed_m_s: plate.speed_m_s,
        origin_m: Vector3::y() * leading_m,
        start_s: 0.0,
    };
    let full_n_m = TAU * plate.density_kg_m3 * plate.speed_m_s.powi(2) * plate.semi_chord_m * SMALL;
    let lifts = |shape, per_semi_chord: f64, semi_chords: f64| -> Vec<f64> {
        let steps = (semi_chords * per_semi_chord) as usize;
        let history =
            plate.march(|_| Motion::default(), &[gust(shape)], true, plate.semi_chord_s() / per_semi_chord, steps);
        history
            .iter()
            .map(|[circulatory, impulsive]| {
                assert_eq!(impulsive.lift_n_m, 0.0);
                assert!(
                    (circulatory.moment_n - 0.5 * plate.semi_chord_m * circulatory.lift_n_m).abs() < 1e-12 * full_n_m
                );
                circulatory.lift_n_m / full_n_m
            })
            .collect()
    };

    let sharp = lifts(GustShape::SharpEdge, 100.0, 40.0);
    let (mut late, mut early): (f64, f64) = (0.0, 0.0);
    for (i, ours) in sharp.iter().enumerate().skip(1).step_by(5) {
        let s = i as f64 / 100.0;
        // the edge is reached within the first step: half a step times the steepest growth, 0.61 per semi-chord
        assert!((ours - Indicial::KUESSNER.at(s)).abs() < 0.0032, "s = {s}: {ours}");
        let off = (ours - kuessner(s)).abs();
        if s < 1.0 { early = early.max(off) } else { late = late.max(off) }
    }
    println!("W-13 largest distance from Küssner's function: {early:.4} in the first semi-chord, {late:.4} after it");

    // a length of 20 semi-chords, relevant for the lift
    let length_m = 20.0 * plate.semi_chord_m;
    let shape = GustShape::OneMinusCosine { length_m };
    let slope = |x: f64| if x < 20.0 { PI / 20.0 * (TAU * x / 20.0).sin() } else { 0.0 };
    let duhamel = |s: f64, cells: i32, indicial: &dyn Fn(f64) -> f64| {
        let width = s / f64::from(cells);
        (0..cells).map(|i| (f64::from(i) + 0.5) * width).map(|x| slope(x) * indicial(s - x) * width).sum::<f64>()
    };
    let smooth = |per_semi_chord: f64| lifts(shape.clone(), per_semi_chord, 40.0);
    let (coarse, fine) = (smooth(2.0), smooth(4.0));
    let (mut errors, mut worst, mut peak) = ([0.0_f64; 2], 0.0_f64, 0.0_f64);
    for s in [4.0, 8.0, 11.0, 14.0, 17.0, 30.0] {
        let fitted = duhamel(s, 20_000, &|x| Indicial::KUESSNER.at(x));
        errors[0] = errors[0].max((coarse[(2.0 * s) as usize] - fitted).abs());
        errors[1] = errors[1].max((fine[(4.0 * s) as usize] - fitted).abs());
        let exact = duhamel(s, 300, &kuessner);
        worst = worst.max((fine[(4.0 * s) as usize] - exact).abs());
        peak = peak.max(exact);
    }
    let order = (errors[0] / errors[1]).log2();
    println!("W-13 1 − cosine gust: order {order:.2}; {:.2} % of the peak from Küssner", 100.0 * worst / peak);
    assert!((order - 2.0).abs() < 0.2, "{order}, {errors:?}");
    // the documented errors of the fit: its jump at the start, and its error after a semi-chord
    assert!(early < 0.08 && late < 0.0125, "{early}, {late}");
    assert!(worst < 0.0125, "{worst} of {peak}"); // the total variation of the gust is 1 up and 1 down: errors do not accumulate
}

/// W-18. Periodic turbulence: every harmonic of the lift is that of the gust times the transform of the fit to Küssner's function, after
/// the initial transient has decayed. 1e-3 of a harmonic at `k` up to 0.25 and four steps per semi-chord: the discretisation error, of
/// second order.
#[test]
fn w18_lift_in_turbulence_has_the_transform_of_kuessner() {
    let plate = Plate::default();
    let scale_m = 2.0 * plate.semi_chord_m;
    let turbulence = |spectrum| {
        let (component, seed) = (Component::Transverse, 11);
        let asked = ContinuousTurbulence { spectrum, component, scale_m, seed, length_m: None, resolution_m: None };
        asked.series().expect("a series")
    };
    let full_n_m = TAU * plate.density_kg_m3 * plate.speed_m_s.powi(2) * plate.semi_chord_m * SMALL;
    for (spectrum, per_semi_chord) in [(Spectrum::Dryden, 4), (Spectrum::VonKarman, 4)] {
        let series = turbulence(spectrum);
        let gust = Gust {
            name: "gust".into(),
            shape: GustShape::Turbulence(series.clone()),
            velocity_m_s: Vector3::z() * SMALL * plate.speed_m_s,
            direction: -Vector3::y(),
            speed_m_s: plate.speed_m_s,
            origin_m: Vector3::y() * plate.semi_chord_m,
            start_s: 0.0,
        };
        let period = 512 * per_semi_chord;
        let step_s = plate.semi_chord_s() / per_semi_chord as f64;
        let history = plate.march(|_| Motion::default(), &[gust], true, step_s, 4 * period);
        let lift = |i: usize| history[3 * period + i][0].lift_n_m / full_n_m;
        let wind = |i: usize| series.at(i as f64 * plate.semi_chord_m / per_semi_chord as f64);
        let harmonic = |m: usize, value: &dyn Fn(usize) -> f64| -> Complex<f64> {
            (0..period).map(|i| Complex::from_polar(value(i), -TAU * (m * i % period) as f64 / period as f64)).sum()
        };
        let mut worst = 0.0_f64;
        for m in [1, 2, 3, 5, 8, 13, 20] {
            let p = Complex::new(0.0, TAU * m as f64 / 512.0);
            let Indicial { weights, rates, .. } = Indicial::KUESSNER;
            let transform = weights
                .iter()
                .zip(rates)
                .fold(Complex::new(1.0, 0.0), |sum, (weight, rate)| sum - p * *weight / (p + rate));
            let ratio = harmonic(m, &lift) / harmonic(m, &wind);
            worst = worst.max((ratio / transform - 1.0).norm());
        }
        println!("W-18 {spectrum:?}: harmonics of the lift off by {worst:.1e}");
        assert!(worst < 1e-3, "{spectrum:?}: {worst:.1e}");
    }
}

/// W-14. Without lag: theory with `C = 1`. With lag the difference from this falls with the frequency.
#[test]
fn w14_quasi_steady_limit() {
    let one = Complex::new(1.0, 0.0);
    let plain = StripOptions { unsteady: false, ..Default::default() };
    for heave in [true, false] {
        let plate = Plate { axis: -0.3, options: plain, ..Default::default() };
        let (ours, exact) = (measured(&plate, 0.3, heave, 200), expected(&plate, 0.3, heave, one));
        for i in 0..2 {
            let off = (ours[i] - exact[i]).norm() / exact[i].norm();
            assert!(off < 2e-4, "part {i}: {off:.1e}"); // error of the step, see W-11
        }
        let unsteady = Plate { axis: -0.3, ..Default::default() };
        let gap = |k: f64| (measured(&unsteady, k, heave, 100)[0] / measured(&plate, k, heave, 100)[0] - 1.0).norm();
        let (slow, slower) = (gap(0.01), gap(0.001));
        println!("W-14 lag against none: {slow:.4} at k = 0.01, {slower:.5} at k = 0.001");
        // with two exponentials 1 − C becomes linear for small k: Σ a/b = 4.7 per unit of k
        assert!(slow < 0.048 && slower < 0.0048 && slower > 0.004, "{slow}, {slower}");
    }
}

/// W-15. Mean thrust of a flapping plate due to leading-edge suction: Garrick (NACA Report 567, 1936), with the fit's transform instead of
/// Theodorsen's function.
#[test]
fn w15_thrust_of_flapping_follows_garrick() {
    let k = 0.5;
    let plate = Plate { axis: -0.5, ..Default::default() };
    let (b, v, rho) = (plate.semi_chord_m, plate.speed_m_s, plate.density_kg_m3);
    let omega_rad_s = k * v / b;
    // heave leads pitch by a quarter period
    let (heave_m, pitch_rad) = (1e-3 * b, 0.4e-3);
    let motion = |time_s: f64| {
        let (sine, cosine) = (omega_rad_s * time_s).sin_cos();
        Motion {
            heave_m: heave_m * cosine,
            heave_m_s: -heave_m * omega_rad_s * sine,
            pitch_rad: pitch_rad * sine,
            pitch_rad_s: pitch_rad * omega_rad_s * cosine,
        }
    };
    let steps = 400;
    let history = plate.march(motion, &[], true, TAU / omega_rad_s / steps as f64, 60 * steps);
    let last = &history[history.len() - steps..];
    // the impulsive force rotates with the plate between two instants: use its mean with the tilt of the mean normal
    let thrust_n_m = last.iter().map(|[c, i]| c.thrust_n_m + i.thrust_n_m).sum::<f64>() / steps as f64;

    let amplitudes = (Complex::new(heave_m, 0.0), Complex::new(0.0, -pitch_rad));
    let lag = fitted_theodorsen(k);
    let turning = Complex::new(0.0, omega_rad_s) * amplitudes.1;
    let downwash = Complex::new(0.0, omega_rad_s) * amplitudes.0 + amplitudes.1 * v + turning * b;
    let edge = downwash * lag - turning * (0.5 * b);
    let aerofoil = Aerofoil { density_kg_m3: rho, speed_m_s: v, semi_chord_m: b, axis: -0.5 };
    let lift_n_m = aerofoil.response(lag, k, amplitudes.0, amplitudes.1).lift_n_m();
    let garrick_n_m = PI * rho * b * edge.norm_sqr() - 0.5 * (lift_n_m * amplitudes.1.conj()).re;
    let off = thrust_n_m / garrick_n_m - 1.0;
    println!("W-15 mean thrust {thrust_n_m:.4e} N/m, Garrick {garrick_n_m:.4e} N/m: {off:+.1e}");
    assert!(off.abs() < 1e-3, "{off}"); // second order in the step and in the amplitudes
}

/// W-16. A polar equal to the plate's lift line gives the plate's lift, with lag.
#[test]
fn w16_polar_of_a_plate_is_the_plate() {
    let row = |angle_rad: f64| PolarRow { angle_rad, lift: TAU * angle_rad, drag: 0.0, moment: 0.0 };
    let polar = Some(Polar { rows: vec![row(-0.1), row(0.1)] });
    let table = Plate { profile: Profile { polar, ..Profile::THIN }, ..Default::default() };
    for heave in [true, false] {
        let (plate, table) = (measured(&Plate::default(), 0.3, heave, 100), measured(&table, 0.3, heave, 100));
        for i in 0..2 {
            let off = (plate[i] - table[i]).norm() / plate[i].norm();
            assert!(off < 1e-9, "part {i}: {off:.1e}"); // squares of the motion
        }
    }
}

/// W-17. Plate that starts in still air: only the apparent mass `π ρ b²` and the apparent inertia `π ρ b⁴/8` act.
#[test]
fn w17_apparent_mass_in_still_air() {
    let plate = Plate { speed_m_s: 0.0, ..Default::default() };
    let (b, rho) = (plate.semi_chord_m, plate.density_kg_m3);
    let (acceleration, step_s) = (7.0, 0.01);
    let starting = |time_s: f64| Motion {
        heave_m: 0.5 * acceleration * time_s.powi(2),
        heave_m_s: acceleration * time_s,
        ..Default::default()
    };
    for [circulatory, impulsive] in &plate.march(starting, &[], false, step_s, 10)[1..] {
        assert!((impulsive.lift_n_m / (PI * rho * b * b * acceleration) - 1.0).abs() < 1e-12, "{impulsive:?}");
        assert!(circulatory.lift_n_m.abs() + circulatory.thrust_n_m.abs() + impulsive.moment_n.abs() < 1e-12);
    }
    let turning = |time_s: f64| Motion {
        pitch_rad: 0.5 * acceleration * time_s.powi(2),
        pitch_rad_s: acceleration * time_s,
        ..Default::default()
    };
    for [circulatory, impulsive] in &plate.march(turning, &[], false, step_s, 10)[1..] {
        assert!(
            (impulsive.moment_n / (-PI * rho * b.powi(4) / 8.0 * acceleration) - 1.0).abs() < 1e-12,
            "{impulsive:?}"
        );
        assert!(circulatory.lift_n_m.abs() + circulatory.moment_n.abs() + impulsive.lift_n_m.abs() < 1e-12);
    }
}
