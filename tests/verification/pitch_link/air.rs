//! The declared aerodynamics of the reference: ten strips, quasi-steady polars beyond stall, momentum theory in annuli with a lag.

use nalgebra::{SVector, Vector3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_8, PI};

pub const RADIUS_M: f64 = 22.5;
pub const STRIPS: usize = 10;
const ROOT_M: f64 = 2.25;
const BLADES: f64 = 2.0;
const DENSITY_KG_M3: f64 = 1.225;
const WIND_M_S: f64 = 13.0;
const LAG_S: f64 = 0.8;
const LIFT_SLOPE: f64 = 6.0;
const ZERO_LIFT_DEG: f64 = -4.0;
const DRAG: f64 = 0.008;
const MOMENT: f64 = -0.05;
const STALLS_DEG: [(f64, f64); 2] = [(1.0, 12.0), (-1.0, -10.0)];
const ASPECT_RATIO: f64 = 15.0;

/// Velocities induced in the annuli, m/s.
pub type Induced = SVector<f64, STRIPS>;

pub fn chord_m(share: f64) -> f64 {
    1.8 - 0.9 * share
}

/// Lift, drag and moment coefficients at an angle of attack: linear, beyond stall by Viterna and Corrigan.
pub fn polar(angle_rad: f64) -> [f64; 3] {
    let alpha = (angle_rad + PI).rem_euclid(2.0 * PI) - PI;
    let linear = |alpha: f64| LIFT_SLOPE * (alpha - ZERO_LIFT_DEG.to_radians());
    let (mut lift, mut drag) = (linear(alpha), DRAG + 0.01 * linear(alpha).powi(2));
    let mut moment = MOMENT;
    let most = 1.11 + 0.018 * ASPECT_RATIO;
    for (sign, stall_deg) in STALLS_DEG {
        let stall = stall_deg.to_radians();
        let (lift_s, a) = (linear(stall), stall.abs());
        let drag_s = DRAG + 0.01 * lift_s * lift_s;
        if sign * alpha <= a {
            continue;
        }
        let (sin, cos) = a.sin_cos();
        let a2 = (sign * lift_s - most * sin * cos) * sin / (cos * cos);
        let b2 = (drag_s - most * sin * sin) / cos;
        let x = alpha.abs().min(FRAC_PI_2);
        lift = sign * (0.5 * most * (2.0 * x).sin() + a2 * x.cos().powi(2) / x.sin());
        drag = most * x.sin().powi(2) + b2 * x.cos();
        let normal = lift * alpha.cos() + drag * alpha.sin();
        // the centre of pressure moves to mid-chord over ten degrees
        let gone = ((x - a) / 10f64.to_radians()).min(1.0);
        moment = MOMENT * (1.0 - gone) - 0.25 * gone * normal;
    }
    [lift, drag, moment]
}

/// Moments about shaft, flap hinge and pitch axis of one blade in N·m, and the rates of the induced velocities in m/s².
pub fn loads(q: &Vector3<f64>, rates: &Vector3<f64>, induced: &Induced) -> (Vector3<f64>, Induced) {
    let (psi_rate, flap, flap_rate, pitch, pitch_rate) = (rates[0], q[1], rates[1], q[2], rates[2]);
    let width_m = (RADIUS_M - ROOT_M) / STRIPS as f64;
    let (mut moments, mut slopes) = (Vector3::zeros(), Induced::zeros());
    let mut pitching = 0.0;
    for i in 0..STRIPS {
        let r = ROOT_M + (i as f64 + 0.5) * width_m;
        let share = r / RADIUS_M;
        let (chord, twist) = (chord_m(share), (10.0 - 10.0 * share).to_radians());
        let along = r * flap.cos() * psi_rate;
        let across = (WIND_M_S - induced[i]) * flap.cos() - r * flap_rate;
        let speed = along.hypot(across);
        let inflow = across.atan2(along);
        let turning = pitch_rate * chord / speed.max(1.0);
        let [lift, drag, moment] = polar(pitch - twist + inflow + 0.5 * turning);
        let moment = moment - FRAC_PI_8 * turning;
        let scale = 0.5 * DENSITY_KG_M3 * speed * speed * chord * width_m;
        let thrust = scale * (lift * inflow.cos() + drag * inflow.sin());
        let drag = scale * (drag * inflow.cos() - lift * inflow.sin());
        pitching += scale * chord * moment;
        moments[0] -= drag * r * flap.cos();
        moments[1] += thrust * r;
        let loading = BLADES * thrust / width_m * flap.cos() / (PI * DENSITY_KG_M3 * r * WIND_M_S * WIND_M_S);
        let factor =
            if loading < 0.96 { 0.5 * (1.0 - (1.0 - loading.max(-1.5)).sqrt()) } else { 0.4 + (loading - 0.96) / 2.0 };
        slopes[i] = (factor * WIND_M_S - induced[i]) / LAG_S;
    }
    moments[2] = pitching;
    moments[0] += flap.sin() * pitching;
    (moments, slopes)
}

/// Flap angle and induced velocities of the blade in steady rotation with its pitch held at −2° and its shaft at 4 rad/s.
pub fn trim(lamina: &super::Lamina, stiffness_n_m_rad: f64) -> (Vector3<f64>, Vector3<f64>, Induced) {
    let (mut q, rates) = (Vector3::new(0.0, 0.0, (-2f64).to_radians()), Vector3::new(4.0, 0.0, 0.0));
    let mut induced = Induced::zeros();
    for _ in 0..4000 {
        let (moments, slopes) = loads(&q, &rates, &induced);
        induced += 0.05 * LAG_S * slopes;
        let off = moments[1] - stiffness_n_m_rad * q[1] + lamina.slope(&q, &rates)[1];
        q[1] += 0.1 * off / (stiffness_n_m_rad + lamina.ix * 16.0);
    }
    (q, rates, induced)
}
