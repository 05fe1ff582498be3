//! Slender bodies at rest in a flow: SB-01 to SB-04.

use crate::slender::{DENSITY_KG_M3, POINTED, at_rest, body, flow, moment};
use foldwing::aero::flow::{Gust, GustShape};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::f64::consts::PI;

const SPEED_M_S: f64 = 30.0;

/// A spheroid of half-length `a` and radius `b` in m, by rows at the angles of a circle.
fn spheroid(a: f64, b: f64, parts: usize) -> Vec<[f64; 2]> {
    let at = |k: usize| {
        let angle = PI * k as f64 / parts as f64;
        [-a * angle.cos(), if k == 0 || k == parts { 0.0 } else { b * angle.sin() }]
    };
    (0..=parts).map(at).collect()
}

/// SB-01. Munk's moment: a closed body in a steady flow has no force, and the moment `ρ V U² sin α cos α` that turns it across the flow,
/// from the front and from behind, in every plane through its axis, on a rigid body and on sections of its own.
#[test]
fn sb01_closed_body_has_munks_moment() {
    let volume_m3 = moment(&POINTED, 0);
    let pressure_n_m2 = DENSITY_KG_M3 * SPEED_M_S.powi(2);
    let mut largest = 0.0_f64;
    for rigid in [true, false] {
        let options = body(&POINTED, rigid);
        approx::assert_relative_eq!(options.volume_m3(), volume_m3, max_relative = 1e-10);
        for (angle_deg, plane_deg) in
            [(5.0, 0.0), (30.0, 70.0), (-20.0, 200.0), (90.0, 0.0), (160.0, 30.0), (180.0, 0.0)]
        {
            let (angle, plane) = (f64::to_radians(angle_deg), f64::to_radians(plane_deg));
            let across = Vector3::new(0.0, plane.sin(), plane.cos());
            let wind_m_s = (Vector3::x() * angle.cos() + across * angle.sin()) * SPEED_M_S;
            // in any attitude of body and wind together
            let attitude = Rotation3::new(Vector3::new(0.4, -1.1, 0.7)).into_inner();
            let [force_n, moment_n_m] = at_rest(&options, attitude, &flow(attitude * wind_m_s, &[]));
            // turns x, from the first to the last section, towards -across: across the flow
            let munk_n_m = across.cross(&Vector3::x()) * (pressure_n_m2 * volume_m3 * angle.sin() * angle.cos());
            let error = (attitude.transpose() * moment_n_m - munk_n_m).norm() / (pressure_n_m2 * volume_m3);
            largest = largest.max(error).max(force_n.norm() / (pressure_n_m2 * 0.2));
        }
    }
    // spheroids: the volume of inscribed frustums converges to theirs
    let [coarse, fine] = [20, 40].map(|parts| {
        let options = body(&spheroid(3.0, 0.3, parts), true);
        let wind_m_s = Vector3::new(10f64.to_radians().cos(), 0.0, 10f64.to_radians().sin()) * SPEED_M_S;
        let [_, moment_n_m] = at_rest(&options, Matrix3::identity(), &flow(wind_m_s, &[]));
        let exact_n_m =
            pressure_n_m2 * 4.0 / 3.0 * PI * 3.0 * 0.09 * 10f64.to_radians().sin() * 10f64.to_radians().cos();
        (moment_n_m.y / exact_n_m - 1.0).abs()
    });
    println!("SB-01: {largest:.1e}; spheroid of 20 and 40 parts {coarse:.1e} {fine:.1e}");
    assert!(largest < 1e-10, "{largest:e}");
    assert!(fine < 4e-3 && (3.5..4.5).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
}

/// SB-02. A body with an open base: the lift `ρ U² A sin α cos α` of its base, the drag `L tan(α/2)`, the force midway between the normals
/// of axis and flow, and the moment about the nose. With the base towards the flow it has Munk's couple alone.
#[test]
fn sb02_open_base_has_the_lift_of_its_area() {
    let rows = [[0.0, 0.0], [0.5, 0.15], [1.5, 0.2], [2.0, 0.12]];
    let (volume_m3, base_m2, length_m) = (moment(&rows, 0), PI * 0.12_f64.powi(2), 2.0);
    let pressure_n_m2 = DENSITY_KG_M3 * SPEED_M_S.powi(2);
    for rigid in [true, false] {
        let options = body(&rows, rigid);
        for angle in [1e-3_f64, 0.1, 0.4, -0.8] {
            let (sine, cosine) = angle.sin_cos();
            let wind_m_s = Vector3::new(cosine, 0.0, sine) * SPEED_M_S;
            let [force_n, moment_n_m] = at_rest(&options, Matrix3::identity(), &flow(wind_m_s, &[]));
            let lift_n = force_n.dot(&Vector3::new(-sine, 0.0, cosine));
            let drag_n = force_n.dot(&Vector3::new(cosine, 0.0, sine));
            let expected_n = pressure_n_m2 * base_m2 * sine * cosine;
            approx::assert_relative_eq!(lift_n, expected_n, max_relative = 1e-10);
            approx::assert_relative_eq!(drag_n, expected_n * (0.5 * angle).tan(), max_relative = 1e-10);
            // about the nose: the rate of the momentum that leaves, less Munk's couple
            let due_n_m = pressure_n_m2 * sine * cosine * (volume_m3 - base_m2 * length_m);
            approx::assert_relative_eq!(moment_n_m.y, due_n_m, max_relative = 1e-10);
            let behind = flow(-wind_m_s, &[]);
            let [force_n, moment_n_m] = at_rest(&options, Matrix3::identity(), &behind);
            assert!(force_n.norm() < 1e-10 * pressure_n_m2 * base_m2, "{force_n:?}");
            approx::assert_relative_eq!(moment_n_m.y, pressure_n_m2 * sine * cosine * volume_m3, max_relative = 1e-9);
        }
    }
}

fn gust(shape: GustShape, start_s: f64) -> Gust {
    Gust {
        name: "gust".into(),
        shape,
        velocity_m_s: Vector3::new(0.0, 0.6, 1.0),
        direction: Vector3::x(),
        speed_m_s: SPEED_M_S,
        origin_m: Vector3::new(-1.0, 0.0, 0.0),
        start_s,
    }
}

/// SB-03. A gust whose front has passed is a wind; while the front of a sharp-edged gust passes the section at `s`, the force across a closed
/// body is `ρ U w A(s)`, the rate of the momentum of the gust in front of it; behind the body it has no effect, also for an open base.
#[test]
fn sb03_gusts_pass_along_the_body() {
    let wind_m_s = Vector3::new(SPEED_M_S, 0.0, 1.5);
    let velocity_m_s = gust(GustShape::SharpEdge, 0.0).velocity_m_s;
    let fine: Vec<[f64; 2]> = POINTED
        .windows(2)
        .flat_map(|pair| {
            (0..200).map(move |k| {
                let share = f64::from(k) / 200.0;
                [pair[0][0] + (pair[1][0] - pair[0][0]) * share, pair[0][1] + (pair[1][1] - pair[0][1]) * share]
            })
        })
        .chain([[1.6, 0.0]])
        .collect();
    let open = &fine[..700];
    for rows in [&fine[..], open] {
        let options = body(rows, true);
        let passed = [gust(GustShape::SharpEdge, -1.0)];
        let [force_n, moment_n_m] = at_rest(&options, Matrix3::identity(), &flow(wind_m_s, &passed));
        let [wind_n, wind_n_m] = at_rest(&options, Matrix3::identity(), &flow(wind_m_s + velocity_m_s, &[]));
        let size_n = DENSITY_KG_M3 * SPEED_M_S.powi(2);
        println!("SB-03: {:.1e} {:.1e}", (force_n - wind_n).norm() / size_n, (moment_n_m - wind_n_m).norm() / size_n);
        assert!((force_n - wind_n).norm() < 1e-12 * size_n && (moment_n_m - wind_n_m).norm() < 1e-12 * size_n);
    }
    let options = body(&fine, true);
    let calm = flow(wind_m_s, &[]);
    let [calm_n, _] = at_rest(&options, Matrix3::identity(), &calm);
    for section in [1, 150, 420, 700, 799] {
        // the front is just behind the section
        let front_m = fine[section][0] + 1e-6;
        let gusts = [gust(GustShape::SharpEdge, -(front_m + 1.0) / SPEED_M_S)];
        let [force_n, _] = at_rest(&options, Matrix3::identity(), &flow(wind_m_s, &gusts));
        let area_m2 = PI * fine[section][1].powi(2);
        let due_n = velocity_m_s * (DENSITY_KG_M3 * SPEED_M_S * area_m2);
        // the gust acts up to half a part behind the section
        let slack_n = DENSITY_KG_M3 * SPEED_M_S * velocity_m_s.norm() * PI * 2.0 * 0.25 * 0.0017;
        assert!((force_n - calm_n - due_n).norm() < slack_n, "{section}: {:?} for {due_n:?}", force_n - calm_n);
    }
}

/// SB-04. Drag: a cylinder across the flow, and a body along the flow, by their coefficients; the cross-flow principle: in oblique flow the
/// drag across the axis depends on the velocity across it alone.
#[test]
fn sb04_drag_across_and_along() {
    let mut options = body(&[[0.0, 0.1], [2.0, 0.1]], true);
    options.cross_flow_drag_coefficient = 1.2;
    options.axial_drag_coefficient = 0.3;
    let of = |wind_m_s: Vector3<f64>| at_rest(&options, Matrix3::identity(), &flow(wind_m_s, &[]));
    let [across_n, across_n_m] = of(Vector3::z() * SPEED_M_S);
    let due_n = 0.5 * DENSITY_KG_M3 * SPEED_M_S.powi(2) * 1.2 * 0.2 * 2.0;
    approx::assert_relative_eq!(across_n, Vector3::z() * due_n, max_relative = 1e-12);
    approx::assert_relative_eq!(across_n_m, Vector3::y() * -due_n, max_relative = 1e-12);
    for sign in [1.0, -1.0] {
        let [along_n, _] = of(Vector3::x() * SPEED_M_S * sign);
        let due_n = sign * 0.5 * DENSITY_KG_M3 * SPEED_M_S.powi(2) * 0.3 * PI * 0.01;
        approx::assert_relative_eq!(along_n, Vector3::x() * due_n, max_relative = 1e-12);
    }
    let potential = body(&[[0.0, 0.1], [2.0, 0.1]], true);
    let wind_m_s = Vector3::new(20.0, 3.0, 4.0);
    let [with_n, _] = of(wind_m_s);
    let [without_n, _] = at_rest(&potential, Matrix3::identity(), &flow(wind_m_s, &[]));
    let due_n = Vector3::new(0.0, 3.0, 4.0) * (0.5 * DENSITY_KG_M3 * 5.0 * 1.2 * 0.4)
        + Vector3::x() * (0.5 * DENSITY_KG_M3 * 400.0 * 0.3 * PI * 0.01);
    approx::assert_relative_eq!(with_n - without_n, due_n, max_relative = 1e-12);
    // a gust along and across is part of the velocities
    let gusts = [gust(GustShape::SharpEdge, -1.0)];
    let [gusty_n, _] = at_rest(&options, Matrix3::identity(), &flow(wind_m_s, &gusts));
    let [windy_n, _] = of(wind_m_s + gusts[0].velocity_m_s);
    approx::assert_relative_eq!(gusty_n, windy_n, max_relative = 1e-12);
}
