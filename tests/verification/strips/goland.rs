//! W-30 to W-32: flutter of Goland's wing as a continuous wing, without modes, elements or time steps.
//!
//! At a real frequency `ω` and a speed `V` the amplitudes of heave `h` (down, of the elastic axis) and twist `α` satisfy linear equations
//! along the span with constant coefficients, `EI h'''' = ω²(m h + S α) − L(h, α)`, `−GJ α'' = ω²(I α + S h) + M(h, α)`, `L` and `M`
//! Theodorsen's lift and nose-up moment. For a clamped root and a free tip, a 3×3 determinant of the transfer matrix over the span must
//! vanish; its real and imaginary parts determine flutter speed and frequency. This shares no code with the product and is the reference
//! for its flutter in simulations.

use crate::strips::theory::{Aerofoil, theodorsen};
use crate::strips::unsteady::fitted_theodorsen;
use nalgebra::{Complex, Matrix3, Matrix6};
use serde_json::Value;

/// The reference file with the wing's data and the published results.
pub fn reference() -> Value {
    serde_json::from_str(include_str!("../../reference/goland.json")).expect("valid JSON")
}

/// A number in an object of the file.
fn number(object: &Value, key: &str) -> f64 {
    object[key].as_f64().unwrap_or_else(|| panic!("no number {key}"))
}

/// The wing, with the aerodynamic lag as a function of the reduced frequency in place of Theodorsen's function.
struct Wing {
    data: Value,
    density_kg_m3: f64,
    lag: fn(f64) -> Complex<f64>,
}

impl Wing {
    fn new(density_kg_m3: f64, lag: fn(f64) -> Complex<f64>) -> Self {
        Self { data: reference()["wing"].clone(), density_kg_m3, lag }
    }

    /// The wing with the data of a source, where they differ from the usual ones in the fourth digit.
    fn of(source: &Value) -> Self {
        let usual = Self::new(number(source, "density_kg_m3"), theodorsen);
        if source["wing"].is_object() { Self { data: source["wing"].clone(), ..usual } } else { usual }
    }

    fn get(&self, key: &str) -> f64 {
        number(&self.data, key)
    }

    /// Determinant of the boundary conditions at the tip, scaled to order one.
    fn determinant(&self, speed_m_s: f64, frequency_rad_s: f64) -> Complex<f64> {
        let (span_m, chord_m, mass_kg_m) = (self.get("span_m"), self.get("chord_m"), self.get("mass_kg_m"));
        let axis = self.get("elastic_axis_of_chord");
        let imbalance_kg = mass_kg_m * self.get("static_moment_arm_m");
        let inertia_kg_m = self.get("inertia_about_elastic_axis_kg_m");
        let (bending, torsion) = (self.get("flap_stiffness_N_m2"), self.get("torsional_stiffness_N_m2"));

        let aerofoil = Aerofoil {
            density_kg_m3: self.density_kg_m3,
            speed_m_s,
            semi_chord_m: 0.5 * chord_m,
            axis: 2.0 * axis - 1.0,
        };
        let k = frequency_rad_s * aerofoil.semi_chord_m / speed_m_s;
        let (zero, one) = (Complex::new(0.0, 0.0), Complex::new(1.0, 0.0));
        let heaving = aerofoil.response((self.lag)(k), k, one, zero);
        let pitching = aerofoil.response((self.lag)(k), k, zero, one);

        // unknowns (h, h', h'', h''', α, α'), derivatives with respect to the fraction of the span so that entries are of similar size
        let square = frequency_rad_s.powi(2);
        let flap = span_m.powi(4) / bending;
        let twist = -span_m.powi(2) / torsion;
        let mut along = Matrix6::<Complex<f64>>::zeros();
        for row in [0, 1, 2, 4] {
            along[(row, row + 1)] = one;
        }
        along[(3, 0)] = (one * square * mass_kg_m - heaving.lift_n_m()) * flap;
        along[(3, 4)] = (one * square * imbalance_kg - pitching.lift_n_m()) * flap;
        along[(5, 0)] = (one * square * imbalance_kg + heaving.moment_n()) * twist;
        along[(5, 4)] = (one * square * inertia_kg_m + pitching.moment_n()) * twist;
        let transfer = exponential(&along);
        // free at the root: h'', h''', α'; zero at the tip: the same three
        let (rows, columns) = ([2, 3, 5], [2, 3, 5]);
        let tip = Matrix3::from_fn(|i, j| transfer[(rows[i], columns[j])]);
        tip.determinant()
    }

    /// Flutter speed in m/s and frequency in rad/s by Newton's iteration from a guess.
    fn flutter(&self, guess: [f64; 2]) -> [f64; 2] {
        let mut at = guess;
        for _ in 0..40 {
            let f = self.determinant(at[0], at[1]);
            let step = 1e-6;
            let by_speed =
                (self.determinant(at[0] + step, at[1]) - self.determinant(at[0] - step, at[1])) / (2.0 * step);
            let by_rate =
                (self.determinant(at[0], at[1] + step) - self.determinant(at[0], at[1] - step)) / (2.0 * step);
            let determinant = by_speed.re * by_rate.im - by_rate.re * by_speed.im;
            let change = [
                (f.re * by_rate.im - by_rate.re * f.im) / determinant,
                (by_speed.re * f.im - f.re * by_speed.im) / determinant,
            ];
            at = [at[0] - change[0], at[1] - change[1]];
            if change[0].abs() + change[1].abs() < 1e-9 {
                return at;
            }
        }
        panic!("no convergence from {guess:?}: at {at:?}");
    }
}

/// Matrix exponential by scaling and squaring of its power series.
fn exponential(matrix: &Matrix6<Complex<f64>>) -> Matrix6<Complex<f64>> {
    let halvings = (matrix.norm().log2().ceil() as i32 + 2).max(0);
    let small = matrix * Complex::new(0.5_f64.powi(halvings), 0.0);
    let (mut sum, mut term) = (Matrix6::identity(), Matrix6::identity());
    for n in 1..20 {
        term = term * small / Complex::new(f64::from(n), 0.0);
        sum += term;
    }
    (0..halvings).fold(sum, |power, _| power * power)
}

/// W-30. Check of the solution itself: natural frequencies of the wing in a vacuum with the mass on the elastic axis, against the closed
/// form.
#[test]
fn w30_transfer_matrix_has_the_closed_form_frequencies() {
    let mut wing = Wing::new(0.0, theodorsen);
    wing.data["static_moment_arm_m"] = 0.0.into();
    let span_m = wing.get("span_m");
    let bend =
        |root: f64| root.powi(2) * (wing.get("flap_stiffness_N_m2") / wing.get("mass_kg_m")).sqrt() / span_m.powi(2);
    let turn = |n: f64| {
        let rigidity = wing.get("torsional_stiffness_N_m2") / wing.get("inertia_about_elastic_axis_kg_m");
        (n - 0.5) * std::f64::consts::PI / span_m * rigidity.sqrt()
    };
    for expected_rad_s in [bend(1.875_104_068_711_961), turn(1.0), turn(2.0), bend(4.694_091_132_974_175)] {
        let below = wing.determinant(1.0, expected_rad_s * (1.0 - 1e-9)).re;
        let above = wing.determinant(1.0, expected_rad_s * (1.0 + 1e-9)).re;
        assert!(below * above < 0.0, "no sign change at {expected_rad_s} rad/s: {below:e}, {above:e}");
    }
}

/// W-31. Flutter with Theodorsen's theory against an independent exact solution, with its data to all digits, and against the values quoted
/// in the literature, whose frequency is 1 % above the one for the quoted data.
#[test]
fn w31_flutter_with_theodorsen() {
    let published = reference()["strip_theory"].clone();
    for (row, tolerance) in [(0, [0.003, 0.011]), (1, [1e-9, 1e-9])] {
        let [speed_m_s, frequency_rad_s] = Wing::of(&published[row]).flutter([137.0, 70.0]);
        let of = |key| number(&published[row], key);
        let off = [speed_m_s / of("flutter_speed_m_s") - 1.0, frequency_rad_s / of("flutter_frequency_rad_s") - 1.0];
        println!("W-31 {speed_m_s:.6} m/s, {frequency_rad_s:.6} rad/s; source {row}: {:+.1e}, {:+.1e}", off[0], off[1]);
        assert!(off[0].abs() < tolerance[0] && off[1].abs() < tolerance[1], "{off:?}");
    }
}

/// W-32. Effect of the product's aerodynamics on the flutter speed: its two-term fit to Wagner's function, and no lag.
#[test]
fn w32_flutter_with_the_fit_and_without_lag() {
    let exact = Wing::new(1.225, theodorsen).flutter([137.0, 70.0]);
    let fitted = Wing::new(1.225, fitted_theodorsen).flutter(exact);
    let plain = Wing::new(1.225, |_| Complex::new(1.0, 0.0)).flutter(exact);
    let thin = Wing::new(1.02, theodorsen).flutter(exact);
    let published = reference()["strip_theory"][2].clone();
    println!("W-32 fit {fitted:.4?}, no lag {plain:.4?}, Theodorsen at 1.02 kg/m3 {thin:.4?} (m/s, rad/s)");
    // the fit's transform is off by at most 1.5 % of C near k = 0.47
    assert!((fitted[0] / exact[0] - 1.0).abs() < 0.015 && (fitted[1] / exact[1] - 1.0).abs() < 0.015, "{fitted:?}");
    // an independent model with the same aerodynamics and two modes of each kind
    assert!((fitted[0] / number(&published, "flutter_speed_m_s") - 1.0).abs() < 1e-3, "{fitted:?}");
    assert!((fitted[1] / number(&published, "flutter_frequency_rad_s") - 1.0).abs() < 1e-3, "{fitted:?}");
    assert!(plain[0] < exact[0], "lag lowers the lift: without it flutter comes earlier");
    assert!(thin[0] > exact[0], "thinner air, later flutter");
}
