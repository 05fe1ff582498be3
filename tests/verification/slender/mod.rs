//! Slender bodies: SB-01 and following, eqs. (W17) to (W20).

mod linear;
pub(crate) mod machines;
mod motion;
mod steady;

use foldwing::aero::AirLoads;
use foldwing::aero::flow::{Flow, Gust};
use foldwing::aero::slender::{SlenderBody, SlenderBodyOptions, SlenderBodyState};
use foldwing::load::SectionMotion;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

pub(crate) const DENSITY_KG_M3: f64 = 1.2;

/// A body on sections of its own, without drag.
pub(crate) fn body(rows: &[[f64; 2]], rigid: bool) -> SlenderBodyOptions {
    SlenderBodyOptions {
        body: 0,
        rigid,
        positions_m: rows.iter().map(|row| row[0]).collect(),
        radii_m: rows.iter().map(|row| row[1]).collect(),
        apparent_mass: true,
        cross_flow_drag_coefficient: 0.0,
        axial_drag_coefficient: 0.0,
    }
}

/// A pointed body with an uneven shape.
pub(crate) const POINTED: [[f64; 2]; 5] = [[-1.0, 0.0], [-0.4, 0.2], [0.3, 0.25], [0.8, 0.1], [1.6, 0.0]];

/// Integral of the cross-section times a power of the position up to 3, by Gauss' rule of three points on each interval, which is exact:
/// independent of the shape functions of the program.
pub(crate) fn moment(rows: &[[f64; 2]], power: i32) -> f64 {
    let of_pair = |pair: &[[f64; 2]]| {
        let [[from_m, inner_m], [to_m, outer_m]] = [pair[0], pair[1]];
        let at = |share: f64| {
            let s = from_m + (to_m - from_m) * share;
            PI * (inner_m + (outer_m - inner_m) * share).powi(2) * s.powi(power)
        };
        let off = 0.5 * 0.6_f64.sqrt();
        (to_m - from_m) * (5.0 * at(0.5 - off) + 8.0 * at(0.5) + 5.0 * at(0.5 + off)) / 18.0
    };
    rows.windows(2).map(of_pair).sum()
}

/// Motions of the sections of a body that is rigid, with its origin at the root's, attitude, velocity and angular velocity.
pub(crate) fn motions(
    options: &SlenderBodyOptions,
    attitude: Matrix3<f64>,
    velocity_m_s: Vector3<f64>,
    spin_rad_s: Vector3<f64>,
) -> Vec<SectionMotion> {
    let section = |s: &f64| {
        let position_m = if options.rigid { Vector3::zeros() } else { attitude * Vector3::x() * *s };
        SectionMotion {
            rotation: attitude,
            position_m,
            velocity_m_s: velocity_m_s + spin_rad_s.cross(&position_m),
            spin_rad_s,
        }
    };
    options.positions_m.iter().map(section).collect()
}

pub(crate) fn flow(wind_m_s: Vector3<f64>, gusts: &[Gust]) -> Flow<'_> {
    Flow { time_s: 0.0, density_kg_m3: DENSITY_KG_M3, wind_m_s, spin_rad_s: Vector3::zeros(), gusts }
}

/// Force and moment about the root's origin: of the flow, and of the apparent mass.
pub(crate) fn totals(motions: &[SectionMotion], loads: &AirLoads) -> [[Vector3<f64>; 2]; 2] {
    [&loads.circulatory, &loads.impulsive].map(|loads| {
        let mut sum = [Vector3::zeros(); 2];
        for (motion, load) in motions.iter().zip(loads) {
            sum[0] += load.force_n;
            sum[1] += load.moment_n_m + motion.position_m.cross(&load.force_n);
        }
        sum
    })
}

/// Force and moment about the origin at rest in a steady flow.
pub(crate) fn at_rest(options: &SlenderBodyOptions, attitude: Matrix3<f64>, flow: &Flow) -> [Vector3<f64>; 2] {
    let model = SlenderBody::new(options);
    let motions = motions(options, attitude, Vector3::zeros(), Vector3::zeros());
    let (mut state, mut loads) = (model.blank_state(), AirLoads::still(motions.len()));
    model.start(&motions, flow, &mut state, &mut loads);
    totals(&motions, &loads)[0]
}

/// State and loads at the end of a step between two motions.
pub(crate) fn step(
    options: &SlenderBodyOptions,
    [before, after]: [&[SectionMotion]; 2],
    [flow_before, flow_after]: [&Flow; 2],
    step_s: f64,
) -> [[Vector3<f64>; 2]; 2] {
    let model = SlenderBody::new(options);
    let (mut from, mut to): (SlenderBodyState, _) = (model.blank_state(), model.blank_state());
    let mut loads = AirLoads::still(before.len());
    model.start(before, flow_before, &mut from, &mut loads);
    model.solve(&from, after, flow_after, step_s, &mut to, &mut loads);
    totals(after, &loads)
}
