//! Classical theory of the thin aerofoil in unsteady incompressible flow, computed from its closed forms: Theodorsen, NACA Report 496
//! (1935); Wagner and Küssner by the inversion of their Laplace transforms along the branch cut, after von Kármán and Sears, Journal of the
//! Aeronautical Sciences 5 (1938). No exponential fits. Shares no code with the code under test.
//!
//! `k = ωb/V` is the reduced frequency, `s = Vt/b` the distance travelled in semi-chords, `b` the semi-chord.

use nalgebra::Complex;
use std::f64::consts::{FRAC_1_SQRT_2, PI};

const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;

/// Up to here the power series are used: negligible cancellation, and twenty terms are more than enough.
const SERIES_LIMIT: f64 = 2.0;

/// Theodorsen's function `C(k) = K₁(ik)/(K₀(ik) + K₁(ik))`.
pub fn theodorsen(k: f64) -> Complex<f64> {
    let (k0, k1) = macdonald(Complex::new(0.0, k));
    k1 / (k0 + k1)
}

/// Sears' function `1/(ik (K₀(ik) + K₁(ik)))`: lift in a sinusoidal gust relative to the quasi-steady one, gust phase at half chord.
pub fn sears(k: f64) -> Complex<f64> {
    let z = Complex::new(0.0, k);
    let (k0, k1) = macdonald(z);
    // the exponential that `macdonald` leaves out
    z.exp() / (z * (k0 + k1))
}

/// Wagner's function: circulatory lift after a sudden change of incidence, relative to its final value, `1 − ∫ e^(−xs)/(x² D) dx`, `D = (K₀
/// − K₁)² + π²(I₀ + I₁)²`, integrated over positive `x`.
pub fn wagner(s: f64) -> f64 {
    1.0 - over_positive(s + 2.0, |x| {
        let (k0, k1, i_sum) = real_bessel(x);
        // both are scaled: D = e^(2x) (…)
        let d = ((k0 - k1) * (-2.0 * x).exp()).powi(2) + (PI * i_sum).powi(2);
        (-x * s - 2.0 * x).exp() / (x * x * d)
    })
}

/// Küssner's function: lift after the leading edge entered a sharp-edged gust that is stationary in the air, relative to its final value,
/// `1 − ∫ e^(−x(s−1)) (I₀ + I₁)/(x² D) dx`. Grows as `√(2s)/π` at first.
pub fn kuessner(s: f64) -> f64 {
    if s <= 0.0 {
        return 0.0;
    }
    1.0 - over_positive(s, |x| {
        let (k0, k1, i_sum) = real_bessel(x);
        let d = ((k0 - k1) * (-2.0 * x).exp()).powi(2) + (PI * i_sum).powi(2);
        (-x * s).exp() * i_sum / (x * x * d)
    })
}

/// Lift (up) and moment (nose-up) per span of a thin aerofoil in small harmonic motion `e^(iωt)`.
#[derive(Debug, Clone, Copy)]
pub struct Response {
    /// Circulatory lift, N/m.
    pub circulatory_lift_n_m: Complex<f64>,
    /// Lift due to apparent mass, N/m.
    pub impulsive_lift_n_m: Complex<f64>,
    /// Moment about the axis due to circulation and flow curvature, N.
    pub circulatory_moment_n: Complex<f64>,
    /// Moment about the axis due to apparent mass, N.
    pub impulsive_moment_n: Complex<f64>,
}

impl Response {
    /// Total lift in N/m.
    pub fn lift_n_m(&self) -> Complex<f64> {
        self.circulatory_lift_n_m + self.impulsive_lift_n_m
    }

    /// Total moment in N.
    pub fn moment_n(&self) -> Complex<f64> {
        self.circulatory_moment_n + self.impulsive_moment_n
    }
}

/// Aerofoil and flow.
#[derive(Debug, Clone, Copy)]
pub struct Aerofoil {
    /// Density in kg/m³.
    pub density_kg_m3: f64,
    /// Speed in m/s.
    pub speed_m_s: f64,
    /// Semi-chord in m.
    pub semi_chord_m: f64,
    /// Axis of pitch in semi-chords behind half chord (Theodorsen's `a`).
    pub axis: f64,
}

impl Aerofoil {
    /// Response to the amplitudes of heave of the axis (downward positive, m) and pitch (nose-up, rad): Theodorsen's (XVIII) and (XX) with
    /// the lift positive upward. `lag` is Theodorsen's [function](theodorsen) or its replacement; 1 gives quasi-steady theory.
    pub fn response(&self, lag: Complex<f64>, k: f64, heave_m: Complex<f64>, pitch_rad: Complex<f64>) -> Response {
        let Self { density_kg_m3: rho, speed_m_s: v, semi_chord_m: b, axis: a } = *self;
        let rate = Complex::new(0.0, k * v / b);
        let (sinking, turning) = (rate * heave_m, rate * pitch_rad);
        let downwash = sinking + pitch_rad * v + turning * (b * (0.5 - a));
        let effective = downwash * lag;
        Response {
            circulatory_lift_n_m: effective * (2.0 * PI * rho * v * b),
            impulsive_lift_n_m: (rate * sinking + turning * v - rate * turning * (b * a)) * (PI * rho * b * b),
            // π ρ b² V b (½ − a) α̇ of (XX) is a couple −π ρ b³ V α̇/2 and the apparent lift π ρ b² V α̇ at half chord
            circulatory_moment_n: effective * (2.0 * PI * rho * v * b * b * (a + 0.5))
                - turning * (0.5 * PI * rho * v * b.powi(3)),
            impulsive_moment_n: (rate * sinking * a + turning * (v * a) - rate * turning * (b * (0.125 + a * a)))
                * (PI * rho * b.powi(3)),
        }
    }
}

/// Macdonald's functions times `e^z`: `(e^z K₀(z), e^z K₁(z))` for `|arg z| ≤ π/2`.
pub fn macdonald(z: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    if z.norm() <= SERIES_LIMIT {
        let (i0, i1) = series_i(z);
        let quarter = z * z * 0.25;
        let logarithm = (z * 0.5).ln();
        let (mut k0, mut k1) = (-(logarithm + EULER_GAMMA) * i0, z.inv() + logarithm * i1);
        let (mut term0, mut term1, mut harmonic) = (Complex::new(1.0, 0.0), z * 0.25, 0.0);
        for n in 0..24 {
            let next = f64::from(n + 1);
            k0 += term0 * harmonic;
            // ψ(n+1) + ψ(n+2)
            k1 -= term1 * (2.0 * (harmonic - EULER_GAMMA) + 1.0 / next);
            harmonic += 1.0 / next;
            term0 *= quarter / (next * next);
            term1 *= quarter / (next * (next + 1.0));
        }
        return (k0 * z.exp(), k1 * z.exp());
    }
    // K_n e^z = √(π/2z)/Γ(n+½) ∫ e^(−u) u^(n−½) (1 + u/2z)^(n−½) du with u = y²: trapezoidal rule on an analytic even
    // function, whose nearest singularity is y² = −2z, at least 1.4 away from the real axis
    let step = 0.2;
    let (mut zeroth, mut first) = (Complex::new(0.5, 0.0), Complex::new(0.0, 0.0));
    for n in 1..35 {
        let u = (step * f64::from(n)).powi(2);
        let root = (Complex::new(1.0, 0.0) + z.inv() * (0.5 * u)).sqrt();
        zeroth += root.inv() * (-u).exp();
        first += root * ((-u).exp() * u);
    }
    let factor = z.sqrt().inv() * (2.0 * step * FRAC_1_SQRT_2);
    (zeroth * factor, first * factor * 2.0)
}

/// `(I₀(z), I₁(z))` by power series.
fn series_i(z: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
    let quarter = z * z * 0.25;
    let (mut i0, mut i1) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
    let (mut term0, mut term1) = (Complex::new(1.0, 0.0), z * 0.5);
    for n in 0..24 {
        i0 += term0;
        i1 += term1;
        let next = f64::from(n + 1);
        term0 *= quarter / (next * next);
        term1 *= quarter / (next * (next + 1.0));
    }
    (i0, i1)
}

/// `(e^x K₀, e^x K₁, e^(−x)(I₀ + I₁))` for positive `x`.
fn real_bessel(x: f64) -> (f64, f64, f64) {
    let (k0, k1) = macdonald(Complex::new(x, 0.0));
    let i_sum = if x <= SERIES_LIMIT {
        let (i0, i1) = series_i(Complex::new(x, 0.0));
        (i0 + i1).re * (-x).exp()
    } else {
        // from the Wronskian I₀K₁ + I₁K₀ = 1/x and the ratio I₁/I₀ by its continued fraction, which converges within about √x terms; where
        // these become too many, the leading terms of the ratio's expansion are exact
        let mut ratio = 1.0 - 0.5 / x;
        let terms = if x < 1e6 { 30 + (6.0 * x.sqrt()) as i32 } else { 0 };
        for n in (1..terms).rev() {
            ratio = 1.0 / (2.0 * f64::from(n) / x + ratio);
        }
        (1.0 + ratio) / (x * (k1.re + ratio * k0.re))
    };
    (k0.re, k1.re, i_sum)
}

/// Integral over positive `x` of a function that decays like `exp(−decay x)`: trapezoidal rule in `ln x`, which converges exponentially.
fn over_positive(decay: f64, integrand: impl Fn(f64) -> f64) -> f64 {
    let step = 0.05;
    let points = (-750..).map(|n| (step * f64::from(n)).exp()).take_while(|x| decay * x < 40.0);
    points.map(|x| integrand(x) * x).sum::<f64>() * step
}
