//! Control surfaces on strips against thin-aerofoil theory: steady by Glauert's series, harmonic by the pressures of the plate; neither
//! uses Theodorsen's constants.

use crate::strips::plate::{Motion, Plate};
use crate::strips::theory::theodorsen;
use foldwing::aero::AirLoads;
use foldwing::aero::flap::{Deflection, Flap};
use foldwing::aero::strip::indicial::{Fit, Indicial};
use foldwing::aero::strip::{StripOptions, Strips};
use foldwing::aero::surface::{ChordLine, Surface};
use foldwing::load::SectionMotion;
use nalgebra::{Complex, Vector3};
use std::f64::consts::PI;

/// Span of the plate, as in [`Plate`], m.
const SPAN_M: f64 = 3.0;

fn flap(hinge_fraction: f64) -> Flap {
    Flap {
        name: "flap".into(),
        surface: 0,
        strips: 0..1,
        hinge_fraction,
        lower_rad: -1.0,
        upper_rad: 1.0,
        command_rad: 0.0,
        downward: 1.0,
    }
}

/// Lift, nose-up moment about half chord, and hinge moment, all per span; thrust.
#[derive(Debug, Clone, Copy, Default)]
struct Found {
    lift_n_m: f64,
    moment_n: f64,
    hinge_n: f64,
    thrust_n_m: f64,
}

/// Steady loads of a plate at an incidence with its flap at an angle.
fn steady(plate: &Plate, hinge: f64, incidence_rad: f64, angle_rad: f64) -> Found {
    let mut strips = Strips::new(vec![plate.surface()], plate.options);
    strips.add_flaps(&[flap(hinge)]);
    strips.deflect(&[Deflection { angle_rad, rate_rad_s: 0.0 }]);
    let mut state = strips.blank_state();
    let mut loads = AirLoads::still(2);
    let sections = Plate::sections(Motion { pitch_rad: incidence_rad, ..Motion::default() });
    strips.start(&sections, &plate.flow(0.0, &[]), true, &mut state, &mut loads);
    let [now, _] = Plate::per_span(&loads);
    Found {
        lift_n_m: now.lift_n_m,
        moment_n: now.moment_n,
        hinge_n: state.hinges[0].circulatory_n_m / SPAN_M,
        thrust_n_m: now.thrust_n_m,
    }
}

/// Derivatives of `c_l`, `c_m` about the quarter chord and `c_h` (relative to the square of the whole chord) with respect to the angle of a
/// flap, by summing Glauert's series (The Elements of Aerofoil and Airscrew Theory, 1926, chapter VII).
fn glauert(hinge: f64) -> [f64; 3] {
    let at = (1.0 - 2.0 * hinge).acos();
    let a0 = (PI - at) / PI;
    let a = |n: f64| 2.0 * (n * at).sin() / (n * PI);
    let lift = 2.0 * PI * a0 + PI * a(1.0);
    let moment = 0.25 * PI * (a(2.0) - a(1.0));
    // c_h = −∫ Δc_p (x − x_h) dx with Δc_p = 4 (A_0 cot θ/2 + Σ A_n sin nθ), x = (1 − cos θ)/2, by Simpson's rule
    let over = |f: &dyn Fn(f64) -> f64| {
        let cells = 4000;
        let width = (PI - at) / f64::from(cells);
        let value = |i: i32| f(at + f64::from(i) * 0.5 * width);
        (0..cells).map(|i| width / 6.0 * (value(2 * i) + 4.0 * value(2 * i + 1) + value(2 * i + 2))).sum::<f64>()
    };
    let arm = |angle: f64| 0.25 * angle.sin() * (at.cos() - angle.cos());
    let first = over(&|angle| a0 * 0.25 * (1.0 + angle.cos()) * (at.cos() - angle.cos()));
    // the terms fall with the third power of their number: those omitted contribute 1e-7
    let rest: f64 = (1..400).map(|n| a(f64::from(n)) * over(&|angle| (f64::from(n) * angle).sin() * arm(angle))).sum();
    [lift, moment, -4.0 * (first + rest)]
}

/// W-41. Steady lift, moment and hinge moment at small angles; the requirement is 1 %, the observed difference is the nonlinearity of the
/// sine.
#[test]
fn w41_steady_flaps_follow_thin_aerofoil_theory() {
    let plate = Plate::default();
    let pressure_pa = 0.5 * plate.density_kg_m3 * plate.speed_m_s.powi(2);
    let chord_m = 2.0 * plate.semi_chord_m;
    for hinge in [0.02, 0.25, 0.5, 0.7, 0.8, 0.95] {
        let angle_rad = 1e-4;
        let found = steady(&plate, hinge, 0.0, angle_rad);
        let lift = found.lift_n_m / (pressure_pa * chord_m * angle_rad);
        // about the quarter chord, half a semi-chord in front of half chord
        let moment =
            (found.moment_n - found.lift_n_m * 0.5 * plate.semi_chord_m) / (pressure_pa * chord_m.powi(2) * angle_rad);
        let hinge_moment = found.hinge_n / (pressure_pa * chord_m.powi(2) * angle_rad);
        let expected = glauert(hinge);
        println!("W-41 hinge {hinge}: {:?} against {expected:?}", [lift, moment, hinge_moment]);
        for (found, expected) in [lift, moment, hinge_moment].into_iter().zip(expected) {
            // the series, truncated after 400 terms, has an error of 1e-6
            assert!((found - expected).abs() < 2e-6, "{hinge}: {found} against {expected}");
        }
    }
}

/// W-42. In steady plane flow a plate with a flap has no drag (d'Alembert): leading-edge suction balances the backward component of the
/// flap's force. The remainder is of third order: it falls with the cube of the angles.
#[test]
fn w42_steady_flaps_have_no_drag() {
    for (incidence, angle) in [(0.0, 0.1), (0.05, 0.1), (0.05, -0.08)] {
        let drag = |scale: f64| {
            let found = steady(&Plate::default(), 0.7, incidence * scale, angle * scale);
            found.thrust_n_m / found.lift_n_m.abs().max(1e-9)
        };
        let (one, half) = (drag(1.0), drag(0.5));
        // lift is of first order, so this ratio is of second order
        assert!(one.abs() < 3e-3 && half.abs() < 0.3 * one.abs() + 1e-9, "{incidence} {angle}: {one} {half}");
    }
}

/// Oscillating part: the flap relative to the plate, or the whole plate in pitch about its axis with the flap fixed to it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Moving {
    Flap,
    Plate,
}

/// Harmonic loads of a plate with a flap, from its pressures: potential without circulation by its Fourier series, circulation from the
/// Kutta condition with Theodorsen's function. Lift, nose-up moment about half chord, and hinge moment, per unit angle.
fn pressures(plate: &Plate, moving: Moving, hinge: f64, k: f64, answer: Complex<f64>) -> [Complex<f64>; 3] {
    let (b, v, rho) = (plate.semi_chord_m, plate.speed_m_s, plate.density_kg_m3);
    let (c, i) = (2.0 * hinge - 1.0, Complex::i());
    let rate = i * k * v / b;
    let end = c.acos();
    let simpson = |to: f64, f: &dyn Fn(f64) -> Complex<f64>| {
        let cells = 800;
        let width = to / f64::from(cells);
        let sum: Complex<f64> = (0..cells)
            .map(|cell| {
                let at = f64::from(cell) * width;
                f(at) + f(at + 0.5 * width) * 4.0 + f(at + width)
            })
            .sum();
        sum * (width / 6.0)
    };
    // upward normal velocity on the moving part at x = cos φ per unit angle, about c or the axis a: v + b (x − a) α̇. w sin φ = Σ S_m sin
    // mφ, potential on the plate b Σ S_m/m sin mφ; the ends of the flap are ends of the integral
    let terms = 200;
    let (about, moved) = match moving {
        Moving::Flap => (c, end),
        Moving::Plate => (plate.axis, PI),
    };
    let inside = |phi: f64| Complex::from(v) + rate * b * (phi.cos() - about);
    let strengths: Vec<Complex<f64>> = (1..=terms)
        .map(|m| simpson(moved, &|phi| inside(phi) * phi.sin() * (f64::from(m) * phi).sin()) * (2.0 / PI))
        .collect();
    let potential = |phi: f64| -> Complex<f64> {
        strengths.iter().enumerate().map(|(m, s)| s * (((m + 1) as f64 * phi).sin() * b / (m + 1) as f64)).sum()
    };
    // integrals of the potential: over the whole plate in closed form from its first two terms, over the flap by quadrature
    let whole = strengths[0] * (b * 0.5 * PI);
    let arm = strengths[1] * (0.5 * b * 0.25 * PI);
    let over_flap = |f: &dyn Fn(f64) -> f64| -> Complex<f64> {
        let cells = 400;
        let width = end / f64::from(cells);
        (0..cells)
            .map(|cell| {
                let phi = (f64::from(cell) + 0.5) * width;
                potential(phi) * (f(phi.cos()) * phi.sin() * width)
            })
            .sum()
    };
    let kutta = simpson(moved, &|phi| inside(phi) * (1.0 + phi.cos())) / PI;
    // Δp = 2ρ (φ̇ + V/b ∂φ/∂x) + 2ρVQ (C (1 − x) + x)/√(1 − x²), lift ∫ b dx, moment −∫ x b² dx, hinge −∫ (x − c) b² dx
    let lift = 2.0 * rho * b * rate * whole + 2.0 * rho * v * b * kutta * answer * PI;
    let moment = -2.0 * rho * b * b * rate * arm + 2.0 * rho * v * b * whole
        - 2.0 * rho * v * b * b * kutta * (-answer * (0.5 * PI) + 0.5 * PI);
    let sine = end.sin();
    let front = sine - 0.5 * end - 0.5 * sine * c - c * (end - sine); // ∫ (x − c)(1 − x)/√(1 − x²)
    let back = 0.5 * (end + c * sine) - c * sine; // ∫ (x − c) x/√(1 − x²)
    let hinge_moment = -2.0 * rho * b * b * rate * over_flap(&|x| x - c) + 2.0 * rho * v * b * over_flap(&|_| 1.0)
        - 2.0 * rho * v * b * b * kutta * (answer * front + back);
    [lift, moment, hinge_moment]
}

/// Complex amplitudes of the strips' response to a flap or a plate that oscillates by a small angle, per unit angle. The moment is about
/// the axis.
fn harmonic(plate: &Plate, moving: Moving, hinge: f64, k: f64) -> [Complex<f64>; 3] {
    const ANGLE_RAD: f64 = 1e-5;
    const PARTS: usize = 400;
    let mut strips = Strips::new(vec![plate.surface()], plate.options);
    strips.add_flaps(&[flap(hinge)]);
    let (mut from, mut to) = (strips.blank_state(), strips.blank_state());
    let mut loads = AirLoads::still(2);
    let omega = k / plate.semi_chord_s();
    let step_s = 2.0 * PI / omega / PARTS as f64;
    let at = |time_s: f64| {
        let (angle_rad, rate_rad_s) = (ANGLE_RAD * (omega * time_s).sin(), ANGLE_RAD * omega * (omega * time_s).cos());
        match moving {
            Moving::Flap => (Deflection { angle_rad, rate_rad_s }, Plate::sections(Motion::default())),
            Moving::Plate => {
                let pitch = Motion { pitch_rad: angle_rad, pitch_rad_s: rate_rad_s, ..Motion::default() };
                (Deflection::default(), Plate::sections(pitch))
            }
        }
    };
    let (deflection, sections) = at(0.0);
    strips.deflect(&[deflection]);
    strips.start(&sections, &plate.flow(0.0, &[]), false, &mut from, &mut loads);
    // the slowest relevant lag has decayed to 1e-5
    let periods = (450.0 / (2.0 * PI / k)).ceil() as usize + 2;
    let mut sums = [Complex::from(0.0); 3];
    for step in 1..=periods * PARTS {
        let time_s = step as f64 * step_s;
        let (deflection, sections) = at(time_s);
        strips.deflect(&[deflection]);
        strips.solve(&from, &sections, &plate.flow(time_s, &[]), step_s, &mut to, &mut loads);
        from.copy_from(&to);
        if step > (periods - 1) * PARTS {
            let [circulatory, impulsive] = Plate::per_span(&loads);
            let hinge = to.hinges[0];
            // impulsive loads are means over the step: they belong to its middle
            let parts = [
                (time_s, [circulatory.lift_n_m, circulatory.moment_n, hinge.circulatory_n_m / SPAN_M]),
                (time_s - 0.5 * step_s, [impulsive.lift_n_m, impulsive.moment_n, hinge.impulsive_n_m / SPAN_M]),
            ];
            for (at_s, values) in parts {
                // relative to sin ωt: the amplitude A of A e^(iωt), whose real part is along the sine
                let turn = Complex::new((omega * at_s).sin(), (omega * at_s).cos()) * (2.0 / PARTS as f64 / ANGLE_RAD);
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += turn * value;
                }
            }
        }
    }
    sums
}

/// `1 − Σ a ik/(ik + b)`: the fit's replacement of Theodorsen's function.
fn fitted(fit: &Indicial, k: f64) -> Complex<f64> {
    let ik = Complex::new(0.0, k);
    let missing: Complex<f64> =
        fit.weights.iter().zip(fit.rates).take(fit.terms).map(|(a, b)| ik * *a / (ik + Complex::from(b))).sum();
    Complex::from(1.0) - missing
}

/// W-43. An oscillating flap: lift, moment and hinge moment in amplitude and phase. With the fit in place of `C(k)` the difference is the
/// second-order error of the step (400 steps per period); with Theodorsen's function it is the error of the fit, 0.06 % for the fine one.
#[test]
fn w43_oscillating_flaps_follow_theodorsen() {
    for (hinge, k) in [(0.5, 0.3), (0.75, 0.1), (0.75, 1.0), (0.9, 0.5)] {
        for fit in [Fit::Jones, Fit::Fine] {
            let plate = Plate { options: StripOptions { fit, ..StripOptions::default() }, ..Plate::default() };
            let found = harmonic(&plate, Moving::Flap, hinge, k);
            let own = pressures(&plate, Moving::Flap, hinge, k, fitted(fit.wagner(), k));
            let exact = pressures(&plate, Moving::Flap, hinge, k, theodorsen(k));
            let off = |other: &[Complex<f64>; 3]| -> Vec<f64> {
                found.iter().zip(other).map(|(found, other)| (found - other).norm() / other.norm()).collect()
            };
            println!(
                "W-43 hinge {hinge}, k {k}, {fit:?}: off the fit {:.6?}, off Theodorsen {:.6?}",
                off(&own),
                off(&exact)
            );
            assert!(off(&own).iter().all(|off| *off < 3e-4), "{found:?} against {own:?}");
            if fit == Fit::Fine {
                assert!(off(&exact).iter().all(|off| *off < 2e-3), "{found:?} against {exact:?}");
            }
        }
    }
}

/// W-51. The hinge moment of a flap on a plate that pitches about half chord and about other axes, in amplitude and phase, with the fit in
/// place of `C(k)`: the difference is the second-order error of the step (400 steps per period). The lift is compared too.
#[test]
fn w51_hinge_moment_of_a_pitching_plate() {
    for (hinge, k, axis) in [(0.5, 0.3, 0.0), (0.75, 0.1, -0.4), (0.75, 1.0, 0.3), (0.9, 2.0, 0.0)] {
        let options = StripOptions { fit: Fit::Fine, ..StripOptions::default() };
        let plate = Plate { options, axis, ..Plate::default() };
        let found = harmonic(&plate, Moving::Plate, hinge, k);
        let own = pressures(&plate, Moving::Plate, hinge, k, fitted(Fit::Fine.wagner(), k));
        let off = [0, 2].map(|at| (found[at] - own[at]).norm() / own[at].norm());
        println!("W-51 hinge {hinge}, k {k}, axis {axis}: lift and hinge moment off {off:.6?}");
        assert!(off.iter().all(|off| *off < 3e-4), "{found:?} against {own:?}");
    }
}

/// W-44. In a flow from behind the flap is at the front: the plate rotated by 180° together with its flap is equivalent to a plate with its
/// hinge at the same distance from the other edge, at an incidence equal to the flap angle minus that of the rest. All loads by
/// thin-aerofoil theory.
#[test]
fn w44_flaps_in_reversed_flow_are_noses() {
    let (hinge, angle_rad) = (0.7, 1e-4);
    let forward = Plate::default();
    let backward = Plate { speed_m_s: -forward.speed_m_s, ..Plate::default() };
    let found = steady(&backward, hinge, 0.0, angle_rad);
    // relative to its leading edge, the front part 1 − hinge is inclined to the wind by the angle: the plate at that incidence with its
    // rear part deflected back
    let whole = steady(&forward, 0.5, angle_rad, 0.0);
    let rear = steady(&forward, 1.0 - hinge, 0.0, angle_rad);
    let lift_n_m = -(whole.lift_n_m - rear.lift_n_m);
    let scale = whole.lift_n_m;
    assert!((found.lift_n_m - lift_n_m).abs() < 1e-6 * scale, "{found:?} against {lift_n_m}");
}

/// W-45. With a hinge line not parallel to the quarter-chord line, hinge moment times angle is the aerodynamic work: both the hinge moment
/// and the angle are those of the section times the cosine of the angle between the lines.
#[test]
fn w45_tapered_flaps_take_the_cosine_of_their_hinge() {
    let chord = |leading: f64, trailing: f64| ChordLine {
        leading_m: Vector3::y() * leading,
        trailing_m: Vector3::y() * trailing,
    };
    let (hinge, slope) = (0.75, 0.4);
    // straight quarter-chord line at y = 0, chords 2 and 2 − 2·slope·…: the hinge line is at y = −0.5 c
    let (inner, outer) = (2.0, 2.0 - 2.0 * slope);
    let surface = Surface {
        sections: 0..2,
        chords: vec![chord(0.25 * inner, -0.75 * inner), chord(0.25 * outer, -0.75 * outer)],
        chord_panels: 1,
        profile: foldwing::aero::surface::Profile::THIN,
    };
    let mut strips = Strips::new(vec![surface], StripOptions::default());
    strips.add_flaps(&[flap(hinge)]);
    let angle_rad = 1e-4;
    strips.deflect(&[Deflection { angle_rad, rate_rad_s: 0.0 }]);
    let mut state = strips.blank_state();
    let mut loads = AirLoads::still(2);
    let sections = [0.0, 1.0].map(|x| SectionMotion {
        rotation: nalgebra::Matrix3::identity(),
        position_m: Vector3::x() * x,
        velocity_m_s: Vector3::zeros(),
        spin_rad_s: Vector3::zeros(),
    });
    let plate = Plate::default();
    strips.start(&sections, &plate.flow(0.0, &[]), true, &mut state, &mut loads);
    let cosine = 1.0 / (1.0 + (0.5 * (inner - outer)).powi(2)).sqrt();
    let mean_m = 0.5 * (inner + outer);
    let pressure_pa = 0.5 * plate.density_kg_m3 * plate.speed_m_s.powi(2);
    let [lift, _, hinge_moment] = glauert(hinge);
    let lift_n: f64 = loads.circulatory.iter().map(|load| load.force_n.z).sum();
    approx::assert_relative_eq!(lift_n, pressure_pa * mean_m * lift * cosine * angle_rad, max_relative = 1e-5);
    let expected_n_m = pressure_pa * mean_m.powi(2) * hinge_moment * cosine.powi(2) * angle_rad;
    // error of the series, 1e-6 for a coefficient of 0.06
    approx::assert_relative_eq!(state.hinges[0].circulatory_n_m, expected_n_m, max_relative = 5e-5);
}

/// W-46. Prandtl–Glauert correction: lift, moment and hinge moment of a plate with a flap divided by `√(1 − M²)`; Mach 1 is an error.
/// Leading-edge suction still balances the backward force of the flap: no drag either.
#[test]
fn w46_compressible_strips_follow_prandtl_and_glauert() {
    let plain = Plate::default();
    let still = steady(&plain, 0.75, 0.02, 0.01);
    for mach in [0.2, 0.5, 0.8] {
        let speed_of_sound_m_s = Some(plain.speed_m_s / mach);
        let options = StripOptions { speed_of_sound_m_s, ..StripOptions::default() };
        let found = steady(&Plate { options, ..plain.clone() }, 0.75, 0.02, 0.01);
        let beta = (1.0_f64 - mach * mach).sqrt();
        for (found, still) in [
            (found.lift_n_m, still.lift_n_m),
            (found.moment_n, still.moment_n),
            (found.hinge_n, still.hinge_n),
            (found.thrust_n_m, still.thrust_n_m),
        ] {
            approx::assert_relative_eq!(found * beta, still, max_relative = 1e-12);
        }
    }
    for (share, fine) in [(0.999, true), (1.0, false), (50.0, false)] {
        let options = StripOptions { speed_of_sound_m_s: Some(plain.speed_m_s / share), ..StripOptions::default() };
        let mut air =
            foldwing::aero::AirModel::new(vec![plain.surface()], &foldwing::aero::AirOptions::Strips(options));
        let (mut state, mut loads) = (air.blank_state(), AirLoads::still(2));
        let started = air.start(
            &Plate::sections(Motion::default()),
            &plain.flow(0.0, &[]),
            Some(foldwing::aero::established::Established::straight(0.01)),
            &mut state,
            &mut loads,
        );
        assert_eq!(started.is_ok(), fine, "{share}: {started:?}");
    }
}
