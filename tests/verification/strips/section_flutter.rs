//! W-33: the strips coupled to the smallest structure, a section on two springs.

use crate::strips::plate::{Motion, Plate};
use crate::strips::theory::Aerofoil;
use crate::strips::unsteady::fitted_theodorsen;
use foldwing::aero::AirLoads;
use foldwing::aero::strip::Strips;
use nalgebra::{Complex, Matrix2, Vector2};

/// Section per metre of span on an axis at the quarter chord; its mass equals its apparent mass, a case in which a coupling without
/// iteration fails.
struct Section {
    plate: Plate,
    mass: Matrix2<f64>,
    stiffness: Matrix2<f64>,
}

impl Section {
    fn new(speed_m_s: f64) -> Self {
        let plate = Plate { semi_chord_m: 1.0, axis: -0.5, speed_m_s, density_kg_m3: 1.2, ..Default::default() };
        let apparent_kg_m = std::f64::consts::PI * plate.density_kg_m3;
        let (mass_kg_m, arm_m, radius_m) = (apparent_kg_m, 0.5, 0.8_f64);
        let (heave_rad_s, pitch_rad_s) = (10.0_f64, 14.0_f64);
        Self {
            plate,
            mass: Matrix2::new(1.0, arm_m, arm_m, radius_m.powi(2)) * mass_kg_m,
            stiffness: Matrix2::from_diagonal(&Vector2::new(heave_rad_s.powi(2), (radius_m * pitch_rad_s).powi(2)))
                * mass_kg_m,
        }
    }

    /// Determinant of the section at a real frequency with the fit's transform in place of Theodorsen's function.
    fn determinant(&self, omega_rad_s: f64) -> Complex<f64> {
        let Plate { semi_chord_m, axis, speed_m_s, density_kg_m3, .. } = self.plate;
        let aerofoil = Aerofoil { density_kg_m3, speed_m_s, semi_chord_m, axis };
        let k = omega_rad_s * semi_chord_m / speed_m_s;
        let (zero, one) = (Complex::new(0.0, 0.0), Complex::new(1.0, 0.0));
        let heaving = aerofoil.response(fitted_theodorsen(k), k, one, zero);
        let pitching = aerofoil.response(fitted_theodorsen(k), k, zero, one);
        let own = self.stiffness - self.mass * omega_rad_s.powi(2);
        // heave is positive down, lift up
        (heaving.lift_n_m() + own[(0, 0)]) * (-pitching.moment_n() + own[(1, 1)])
            - (pitching.lift_n_m() + own[(0, 1)]) * (-heaving.moment_n() + own[(1, 0)])
    }

    /// Free motion after a disturbance, by the trapezoidal rule with the aerodynamics iterated in every step; heave after each step.
    fn march(&self, step_s: f64, steps: usize) -> Vec<f64> {
        let mut strips = Strips::new(vec![self.plate.surface()], self.plate.options);
        let (mut from, mut to) = (strips.blank_state(), strips.blank_state());
        let mut loads = AirLoads::still(2);
        let (mut q, mut v) = (Vector2::new(0.0, 0.0), Vector2::new(1e-4, 0.0));
        let motion = |q: &Vector2<f64>, v: &Vector2<f64>| {
            Plate::sections(Motion { heave_m: q.x, heave_m_s: v.x, pitch_rad: q.y, pitch_rad_s: v.y })
        };
        strips.start(&motion(&q, &v), &self.plate.flow(0.0, &[]), false, &mut from, &mut loads);
        let [circulatory, _] = Plate::per_span(&loads);
        let mut last = Vector2::new(-circulatory.lift_n_m, circulatory.moment_n);
        let added = Matrix2::identity() * (std::f64::consts::PI * self.plate.density_kg_m3);
        let mut heave_m = Vec::new();
        for step in 1..=steps {
            strips.convect(&from, &self.plate.flow(0.0, &[]), step_s, &mut to);
            let mut end = v;
            let mut iterations = 0;
            loop {
                let place = q + (v + end) * (0.5 * step_s);
                strips.solve(&from, &motion(&place, &end), &self.plate.flow(0.0, &[]), step_s, &mut to, &mut loads);
                let [circulatory, impulsive] = Plate::per_span(&loads);
                let now = Vector2::new(-circulatory.lift_n_m, circulatory.moment_n);
                // circulatory loads belong to the ends of the step, impulsive ones are means over it
                let mean = 0.5 * (last + now) + Vector2::new(-impulsive.lift_n_m, impulsive.moment_n);
                let residual = self.mass * (end - v) / step_s + self.stiffness * (q + place) * 0.5 - mean;
                // Newton-like: the apparent mass on the left-hand side makes the iteration contract
                let change = -((self.mass + added) / step_s).try_inverse().expect("regular") * residual;
                end += change;
                iterations += 1;
                if change.norm() < 1e-13 * end.norm() {
                    (q, v, last) = (place, end, now);
                    break;
                }
                assert!(iterations < 100, "step {step}: {change}");
            }
            from.copy_from(&to);
            heave_m.push(q.x);
        }
        heave_m
    }
}

/// W-33. Flutter of a section as heavy as its apparent mass: speed and frequency from a simulation against the frequency domain.
///
/// The strips, iterated with the section in each step, add neither damping nor energy: 0.5 % below the flutter speed of the equations the
/// motion decays, 0.5 % above it grows, with the predicted frequency, whose discretisation error is (ωh)²/12 = 2e-4.
#[test]
fn w33_flutter_of_a_light_section() {
    // both parts of the determinant vanish: Newton's method for speed and frequency
    let value = |at: &Vector2<f64>| {
        let f = Section::new(at.x).determinant(at.y);
        Vector2::new(f.re, f.im)
    };
    let mut at = Vector2::new(GUESS[0], GUESS[1]);
    for _ in 0..50 {
        let slope = |shift: Vector2<f64>| (value(&(at + shift)) - value(&(at - shift))) / 2e-6;
        let jacobian = Matrix2::from_columns(&[slope(Vector2::x() * 1e-6), slope(Vector2::y() * 1e-6)]);
        at -= jacobian.try_inverse().expect("regular") * value(&at);
    }
    println!("W-33 flutter at {:.4} m/s and {:.4} rad/s", at.x, at.y);
    assert!(value(&at).norm() < 1e-6 * Section::new(at.x).stiffness.norm().powi(2), "{at}");

    let step_s = 0.05 / at.y;
    let steps = (60.0 * std::f64::consts::TAU / 0.05) as usize;
    let growth = |speed_m_s: f64| {
        let heave_m = Section::new(speed_m_s).march(step_s, steps);
        let size = |range: std::ops::Range<usize>| heave_m[range].iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        // times of the zeros, by interpolation: the frequency in the second half
        let zeros: Vec<f64> = (steps / 2..steps)
            .filter(|&i| heave_m[i - 1] < 0.0 && heave_m[i] >= 0.0)
            .map(|i| i as f64 - heave_m[i] / (heave_m[i] - heave_m[i - 1]))
            .collect();
        let period = (zeros[zeros.len() - 1] - zeros[0]) / (zeros.len() - 1) as f64;
        let factor = size(steps * 3 / 4..steps) / size(steps / 2..steps * 3 / 4);
        (factor, std::f64::consts::TAU / (period * step_s))
    };
    let (below, above) = (growth(at.x * 0.995), growth(at.x * 1.005));
    println!(
        "W-33 growth in fifteen periods {:.4} and {:.4}, {:.4} and {:.4} rad/s",
        below.0, above.0, below.1, above.1
    );
    assert!(below.0 < 1.0 && above.0 > 1.0, "{below:?} {above:?}");
    assert!((0.5 * (below.1 + above.1) / at.y - 1.0).abs() < 2e-3, "{below:?} {above:?}");
}

/// Initial guess near the flutter point for Newton's iteration.
const GUESS: [f64; 2] = [24.5, 15.4];
