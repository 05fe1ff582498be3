//! A blade that oscillates under gravity: its machine, harmonic balance, Hill's equation.

use foldwing::config;
use foldwing::machine::Machine;
use nalgebra::{Complex, DMatrix, DVector, Matrix2};
use std::f64::consts::{PI, TAU};

/// A blade on a hinge at a distance from a horizontal shaft, under gravity.
#[derive(Clone, Copy)]
pub struct Swing {
    pub mass_kg: f64,
    pub inertia_kg_m2: f64,
    pub arm_m: f64,
    pub hinge_m: f64,
    pub spring_n_m_rad: f64,
    pub damping_n_m_s_rad: f64,
    pub gravity_m_s2: f64,
    pub speed_rad_s: f64,
}

impl Swing {
    /// Its machine.
    pub fn machine(&self) -> Machine {
        let own = self.inertia_kg_m2 - self.mass_kg * self.arm_m * self.arm_m;
        let text = format!(
            "name = \"swing\"\ngravity_m_s2 = [0, 0, {:?}]\n[rigid_body.hub]\nmass_kg = 100.0\ninertia_kg_m2 = [20.0, 20.0, 20.0, 0, 0, 0]\n\
             [joint.shaft]\ntype = \"revolute\"\nparent = \"root\"\nchild = \"hub\"\naxis = [1, 0, 0]\n\
             [rigid_body.blade]\nmass_kg = {:?}\ncentre_of_mass_m = [0, {:?}, 0]\ninertia_kg_m2 = [{own:?}, {own:?}, {own:?}, 0, 0, 0]\n\
             [joint.lag]\ntype = \"revolute\"\nparent = \"hub\"\nchild = \"blade\"\naxis = [1, 0, 0]\nparent_offset_m = [0, {:?}, 0]\n\
             spring = {{ stiffness_N_m_rad = {:?}, damping_N_m_s_rad = {:?} }}\n[simulation]\nstop_time_s = 1.0\nstep_s = 0.01\n",
            -self.gravity_m_s2, self.mass_kg, self.arm_m, self.hinge_m, self.spring_n_m_rad, self.damping_n_m_s_rad
        );
        config::parse(&text, "swing.toml").unwrap_or_else(|refused| panic!("{refused}"))
    }

    /// `I ζ̈ + d ζ̇ + k ζ + m e c Ω² sin ζ + m g c cos(ψ + ζ) = 0`: its static part divided by `I`, and the derivative of this with respect
    /// to `ζ`.
    pub fn left(&self, azimuth_rad: f64, lag_rad: f64) -> [f64; 2] {
        let (s, w) = (self.mass_kg * self.arm_m, self.speed_rad_s);
        let centrifugal = s * self.hinge_m * w * w;
        let weight = s * self.gravity_m_s2;
        [
            self.spring_n_m_rad * lag_rad + centrifugal * lag_rad.sin() + weight * (azimuth_rad + lag_rad).cos(),
            self.spring_n_m_rad + centrifugal * lag_rad.cos() - weight * (azimuth_rad + lag_rad).sin(),
        ]
        .map(|x| x / self.inertia_kg_m2)
    }

    /// Harmonic balance at `n` points of the revolution: the values there, by Newton's method with the Fourier differentiation matrix.
    pub fn balanced(&self, n: usize) -> DVector<f64> {
        let w = self.speed_rad_s;
        // derivative of the trigonometric interpolation at an even number of points
        let first = DMatrix::from_fn(n, n, |i, j| {
            if i == j {
                0.0
            } else {
                0.5 * if (i + j).is_multiple_of(2) { 1.0 } else { -1.0 } / (PI * (i as f64 - j as f64) / n as f64).tan()
            }
        });
        let second = DMatrix::from_fn(n, n, |i, j| {
            if i == j {
                return -((n * n) as f64) / 12.0 - 1.0 / 6.0;
            }
            let sine = (PI * (i as f64 - j as f64) / n as f64).sin();
            -0.5 * if (i + j).is_multiple_of(2) { 1.0 } else { -1.0 } / (sine * sine)
        });
        let linear = second * (w * w) + first * (w * self.damping_n_m_s_rad / self.inertia_kg_m2);
        let mut lag = DVector::zeros(n);
        for _ in 0..60 {
            let parts: Vec<[f64; 2]> = (0..n).map(|k| self.left(TAU * k as f64 / n as f64, lag[k])).collect();
            let left = &linear * &lag + DVector::from_fn(n, |k, _| parts[k][0]);
            let slope = &linear + DMatrix::from_diagonal(&DVector::from_fn(n, |k, _| parts[k][1]));
            lag -= slope.lu().solve(&left).expect("a slope");
        }
        lag
    }

    /// Multipliers of Hill's equation about a motion given by its values, by 40 000 steps of Runge–Kutta.
    pub fn multipliers(&self, lag: &DVector<f64>) -> [Complex<f64>; 2] {
        let n = lag.len();
        let steps = 40_000;
        let h = TAU / self.speed_rad_s / steps as f64;
        let parts: Vec<[f64; 2]> = (0..n / 2)
            .map(|m| {
                let sum = |f: fn(f64) -> f64| (0..n).map(|k| lag[k] * f(TAU * (m * k) as f64 / n as f64)).sum::<f64>();
                let scale = if m == 0 { 1.0 } else { 2.0 } / n as f64;
                [scale * sum(f64::cos), scale * sum(f64::sin)]
            })
            .collect();
        let slope = |t: f64| {
            let psi = self.speed_rad_s * t;
            let at =
                |(m, part): (usize, &[f64; 2])| part[0] * (m as f64 * psi).cos() + part[1] * (m as f64 * psi).sin();
            self.left(psi, parts.iter().enumerate().map(at).sum())[1]
        };
        let damping = self.damping_n_m_s_rad / self.inertia_kg_m2;
        let of = |t: f64| Matrix2::new(0.0, 1.0, -slope(t), -damping);
        let mut turn = Matrix2::<f64>::identity();
        for k in 0..steps {
            let t = h * f64::from(k);
            let (a, b, c) = (of(t), of(t + 0.5 * h), of(t + h));
            let k1 = a * turn;
            let k2 = b * (turn + k1 * (0.5 * h));
            let k3 = b * (turn + k2 * (0.5 * h));
            let k4 = c * (turn + k3 * h);
            turn += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0);
        }
        let found = turn.complex_eigenvalues();
        [found[0], found[1]]
    }
}
