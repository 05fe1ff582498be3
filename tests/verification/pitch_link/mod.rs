//! The blade whose pitch link opens: the paper's matrix, its equations in momenta, flutter roots and the motion after the failure with
//! given aerodynamics, against an independent solution.
//!
//! Cases are numbered PL-xx.

mod air;
mod design;
mod edges;
mod failing;
mod growth;
mod in_wind;
mod momenta;
mod rotor_5mw;

use foldwing::config;
use foldwing::machine::{JointKind, Machine, OneFreedom};
use nalgebra::{Matrix3, Vector3};
use std::path::Path;

/// Second moments of a blade's lamina about the quarter chord at the hub, kg·m², and the inertias that rotate with shaft and pitch.
#[derive(Clone, Copy)]
struct Lamina {
    /// `∫ y² dm`.
    ix: f64,
    /// `∫ x² dm`.
    iy: f64,
    /// `−∫ x y dm`.
    cxy: f64,
    rotor: f64,
    pitch: f64,
}

/// The shipped blade with gears of an inertia in kg·m² that remain in the pitch circuit.
fn blade(pitch_kg_m2: f64) -> Machine {
    let mut machine = shipped("pitch_link");
    joint_of(&mut machine, "pitch").motor.inertia_kg_m2 = pitch_kg_m2;
    machine
}

/// A model of `examples/failures`.
fn shipped(name: &str) -> Machine {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("examples/failures/{name}.toml"));
    let text = std::fs::read_to_string(path).expect("a shipped model");
    config::parse(&text, name).unwrap_or_else(|error| panic!("{error}"))
}

fn joint_of<'m>(machine: &'m mut Machine, name: &str) -> &'m mut OneFreedom {
    let body = machine.bodies.iter_mut().find(|body| body.joint.name == name).expect("a joint of that name");
    match &mut body.joint.kind {
        JointKind::Revolute(own) => own,
        other => panic!("{other:?}"),
    }
}

/// The lamina by the same rule as the reference: 2000 midpoints.
fn lamina(pitch_kg_m2: f64) -> Lamina {
    let count = 2000;
    let step_m = air::RADIUS_M / f64::from(count);
    let mut own = Lamina { ix: 0.0, iy: 0.0, cxy: 0.0, rotor: 1e5, pitch: pitch_kg_m2 };
    for i in 0..count {
        let y = (f64::from(i) + 0.5) * step_m;
        let share = y / air::RADIUS_M;
        let (mass_kg, chord_m) = ((300.0 - 220.0 * share) * step_m, air::chord_m(share));
        own.ix += mass_kg * y * y;
        own.iy += mass_kg * (0.12f64.powi(2) + 0.22f64.powi(2)) * chord_m * chord_m;
        own.cxy -= mass_kg * 0.12 * chord_m * y;
    }
    own
}

impl Lamina {
    /// The paper's mass matrix for azimuth, flap and pitch.
    fn matrix(&self, q: &Vector3<f64>) -> Matrix3<f64> {
        let Self { ix, iy, cxy, .. } = *self;
        let ((sb, cb), (st, ct)) = (q[1].sin_cos(), q[2].sin_cos());
        let pp = ix * cb * cb + iy * (sb * sb + cb * cb * ct * ct) - 2.0 * cxy * sb * cb * st + self.rotor;
        let (pb, pt) = (iy * cb * st * ct + cxy * sb * ct, iy * sb - cxy * cb * st);
        Matrix3::new(pp, pb, pt, pb, ix + iy * st * st, cxy * ct, pt, cxy * ct, iy + self.pitch)
    }

    /// Kinetic energy in J.
    fn kinetic_j(&self, q: &Vector3<f64>, rates: &Vector3<f64>) -> f64 {
        0.5 * rates.dot(&(self.matrix(q) * rates))
    }

    /// `∂T/∂q` at given rates, in closed form.
    fn slope(&self, q: &Vector3<f64>, rates: &Vector3<f64>) -> Vector3<f64> {
        let Self { ix, iy, cxy, .. } = *self;
        let ((sb, cb), (st, ct)) = (q[1].sin_cos(), q[2].sin_cos());
        let [p, b, t] = [rates[0], rates[1], rates[2]];
        let (w1, w2, w3) = (b * ct - p * cb * st, p * sb + t, b * st + p * cb * ct);
        let (f1, f2, f3) = (ix * w1 + cxy * w2, iy * w2 + cxy * w1, (ix + iy) * w3);
        Vector3::new(0.0, f1 * p * sb * st + f2 * p * cb - f3 * p * sb * ct, f3 * w1 - f1 * w3)
    }

    /// `∂T/∂q` by central differences, as in the paper.
    fn slope_by_differences(&self, q: &Vector3<f64>, rates: &Vector3<f64>) -> Vector3<f64> {
        let step = 1e-5;
        Vector3::from_fn(|i, _| {
            let mut ends = [*q; 2];
            ends[0][i] += step;
            ends[1][i] -= step;
            (self.kinetic_j(&ends[0], rates) - self.kinetic_j(&ends[1], rates)) / (2.0 * step)
        })
    }
}
