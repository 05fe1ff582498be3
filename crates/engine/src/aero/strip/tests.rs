use super::flap::{FlapInflow, Hinge};
use super::*;
use crate::aero::polar::{Polar, PolarRow};
use crate::aero::strip::continuous::Variable;
use crate::aero::strip::instant::Instant;
use crate::aero::surface::ChordLine;
use nalgebra::Rotation3;
use std::f64::consts::PI;

/// Two strips with sweep, taper and twist on three sections that translate and rotate.
fn wing(profile: Profile) -> Vec<Surface> {
    let chord = |leading: f64, trailing: f64, z: f64| ChordLine {
        leading_m: Vector3::new(0.0, leading, z),
        trailing_m: Vector3::new(0.05, trailing, -z),
    };
    let chords = vec![chord(0.1, -0.3, 0.01), chord(0.05, -0.3, 0.0), chord(0.0, -0.25, -0.01)];
    vec![Surface { sections: 0..3, chords, chord_panels: 1, profile }]
}

fn motions() -> Vec<SectionMotion> {
    (0..3)
        .map(|i| {
            let x = f64::from(i);
            SectionMotion {
                rotation: Rotation3::from_scaled_axis(Vector3::new(0.1 + 0.05 * x, -0.2, 0.03 * x)).into_inner(),
                position_m: Vector3::new(0.4 * x, 0.05 * x, 0.1 * x * x),
                velocity_m_s: Vector3::new(0.3, -0.5 + x, 1.0 - 0.7 * x),
                spin_rad_s: Vector3::new(2.0 - x, 0.5, -0.4 * x),
            }
        })
        .collect()
}

fn flow<'a>() -> Flow<'a> {
    Flow {
        time_s: 0.0,
        density_kg_m3: 1.2,
        wind_m_s: Vector3::new(1.0, -12.0, 1.5),
        spin_rad_s: Vector3::new(0.1, 0.2, -0.3),
        gusts: &[],
    }
}

fn cambered() -> Profile {
    Profile { zero_lift_angle_rad: -0.04, moment_coefficient: -0.05, drag_coefficient: 0.02, ..Profile::THIN }
}

/// State and loads after one step of sections that start from rest.
fn step(profile: Profile, options: StripOptions) -> (StripState, AirLoads) {
    let mut strips = Strips::new(wing(profile), options);
    let (mut from, mut to) = (strips.blank_state(), strips.blank_state());
    let mut loads = AirLoads::still(3);
    let at_rest: Vec<_> = motions()
        .into_iter()
        .map(|motion| SectionMotion { velocity_m_s: Vector3::zeros(), spin_rad_s: Vector3::zeros(), ..motion })
        .collect();
    strips.start(&at_rest, &flow(), false, &mut from, &mut loads);
    strips.convect(&from, &flow(), 0.01, &mut to);
    strips.solve(&from, &motions(), &flow(), 0.01, &mut to, &mut loads);
    (to, loads)
}

/// A rectangular strip of unit chord and span whose leading edge points to +y; lift is +z.
fn plate(profile: Profile, options: StripOptions) -> Strips {
    let chord = ChordLine { leading_m: Vector3::y() * 0.5, trailing_m: -Vector3::y() * 0.5 };
    Strips::new(vec![Surface { sections: 0..2, chords: vec![chord; 2], chord_panels: 1, profile }], options)
}

/// Sections of that plate without velocity, pitched nose-up by an angle.
fn pitched(angle_rad: f64) -> Vec<SectionMotion> {
    (0..2)
        .map(|i| SectionMotion {
            rotation: Rotation3::from_axis_angle(&Vector3::x_axis(), angle_rad).into_inner(),
            position_m: Vector3::x() * f64::from(i),
            velocity_m_s: Vector3::zeros(),
            spin_rad_s: Vector3::zeros(),
        })
        .collect()
}

/// Steady force, and moment about the middle of the plate, in a wind of 10 m/s along −y with a density of 2 kg/m³.
fn steady(profile: Profile, leading_edge_suction: bool, angle_rad: f64) -> (Vector3<f64>, f64) {
    let mut strips = plate(profile, StripOptions { leading_edge_suction, ..Default::default() });
    let (mut state, mut loads) = (strips.blank_state(), AirLoads::still(2));
    let wind_m_s = -10.0 * Vector3::y();
    let flow = Flow { wind_m_s, density_kg_m3: 2.0, spin_rad_s: Vector3::zeros(), ..flow() };
    strips.start(&pitched(angle_rad), &flow, true, &mut state, &mut loads);
    let [a, b] = [loads.circulatory[0], loads.circulatory[1]];
    (a.force_n + b.force_n, (a.moment_n_m + b.moment_n_m).x)
}

#[test]
fn steady_plate_has_its_slope_at_the_quarter_chord() {
    let (force_n, moment_n_m) = steady(Profile::THIN, true, 1e-4);
    approx::assert_relative_eq!(force_n.z, 100.0 * 2.0 * PI * 1e-4, max_relative = 1e-7);
    approx::assert_relative_eq!(moment_n_m, 0.25 * force_n.z, max_relative = 1e-7);
}

/// Leading-edge suction rotates the force from the normal of the chord to that of the wind, to the third power of the angle.
#[test]
fn suction_takes_the_drag_away() {
    let angle_rad: f64 = 0.1;
    let (with_n, _) = steady(Profile::THIN, true, angle_rad);
    let (without_n, _) = steady(Profile::THIN, false, angle_rad);
    approx::assert_relative_eq!(-without_n.y / without_n.z, angle_rad.tan(), max_relative = 1e-12);
    assert!((with_n.y / with_n.z).abs() < angle_rad.powi(3), "{with_n}");
}

#[test]
fn zero_lift_angle_moment_and_drag_of_the_profile() {
    let (force_n, moment_n_m) = steady(cambered(), true, -0.04);
    approx::assert_relative_eq!(force_n.z, 0.0, epsilon = 1e-12);
    approx::assert_relative_eq!(-force_n.y, 100.0 * 0.02, max_relative = 1e-12);
    let drag_moment_n_m = 0.25 * (-0.04_f64).sin() * 100.0 * 0.02; // at the quarter chord
    approx::assert_relative_eq!(moment_n_m, -0.05 * 100.0 + drag_moment_n_m, max_relative = 1e-12);
}

#[test]
fn polar_replaces_slope_moment_and_drag() {
    let row = |angle_rad: f64, lift| PolarRow { angle_rad, lift, drag: 0.3, moment: -0.1 };
    let polar = Some(Polar { rows: vec![row(-PI, 0.0), row(0.0, 0.2), row(0.2, 1.0), row(PI, 0.0)] });
    let (force_n, moment_n_m) = steady(Profile { polar, zero_lift_angle_rad: -0.05, ..Profile::THIN }, true, 0.1);
    approx::assert_relative_eq!(force_n.z, 100.0 * 0.6, max_relative = 1e-12);
    approx::assert_relative_eq!(force_n.y, -100.0 * 0.3, max_relative = 1e-12);
    let arm_m = 0.25 * (0.1_f64.cos() * force_n.z - 0.1_f64.sin() * force_n.y);
    approx::assert_relative_eq!(moment_n_m, arm_m - 0.1 * 100.0, max_relative = 1e-12);
}

/// The power of the wrenches equals that of the forces at the points of the strip where they act, for any force and any motion.
#[test]
fn wrenches_do_the_work_of_the_strips_points() {
    let strips = Strips::new(wing(cambered()), StripOptions::default());
    let still = Flow { wind_m_s: Vector3::zeros(), spin_rad_s: Vector3::zeros(), ..flow() };
    let force_n = Vector3::new(3.0, -2.0, 5.0);
    for strip in &strips.strips {
        // in still air a point's velocity is minus the velocity of the air relative to the point
        let cut = strip.cut(&motions(), &still);
        let power_w = |wrenches: &[crate::load::Wrench]| -> f64 {
            let each = wrenches.iter().zip(motions());
            each.map(|(w, m)| w.force_n.dot(&m.velocity_m_s) + w.moment_n_m.dot(&m.spin_rad_s)).sum()
        };
        for fraction in [0.0, 0.3, 1.0] {
            let mut loads = AirLoads::still(3).circulatory;
            strip.add_force(&mut loads, &cut, fraction, &force_n);
            approx::assert_relative_eq!(power_w(&loads), -force_n.dot(&cut.air_m_s(fraction)), max_relative = 1e-13);
        }
        let mut loads = AirLoads::still(3).circulatory;
        strip.add_moment(&mut loads, &cut, 7.0);
        let pitching_rad_s = (cut.trailing_air_m_s - cut.leading_air_m_s).dot(&cut.up) / cut.chord_m;
        approx::assert_relative_eq!(power_w(&loads), 7.0 * pitching_rad_s, max_relative = 1e-13);
    }
}

#[test]
fn solving_again_gives_the_same_bits() {
    let mut strips = Strips::new(wing(cambered()), StripOptions::default());
    let (from, loads) = step(cambered(), StripOptions::default());
    let (mut once, mut again) = (strips.blank_state(), strips.blank_state());
    let (mut loads_once, mut loads_again) = (loads.clone(), loads);
    strips.solve(&from, &motions(), &flow(), 0.02, &mut once, &mut loads_once);
    let elsewhere: Vec<_> = motions().into_iter().rev().collect();
    strips.solve(&from, &elsewhere, &flow(), 0.03, &mut again, &mut loads_again);
    strips.solve(&from, &motions(), &flow(), 0.02, &mut again, &mut loads_again);
    assert_eq!(once, again);
    assert_eq!(loads_once, loads_again);
}

/// Angular acceleration of the root frame is equivalent to the acceleration of all sections: `α × r` at each point, and the angular
/// acceleration `α`. In uniform flow the loads agree, both those of the apparent mass and those without lag. Everything is linear, so that
/// the tolerance is round-off.
#[test]
fn a_rate_of_the_root_s_spin_is_an_acceleration_of_all_sections() {
    let mut strips = Strips::new(wing(cambered()), StripOptions { apparent_mass: true, ..Default::default() });
    let places_m: Vec<Vector3<f64>> = motions().iter().map(|motion| motion.position_m).collect();
    let at = Instant {
        motions: motions().into(),
        accelerations: vec![[Vector3::zeros(); 2]; 3].into(),
        flow: flow(),
        gust_m_s: Vector3::zeros(),
        lags: vec![0.0; strips.lag_count(false)].into(),
        flaps: Vec::new().into(),
        flap_rad_s2: Vec::new().into(),
    };
    for (axis, spin_rate) in [Vector3::x(), Vector3::y(), Vector3::z()].into_iter().enumerate() {
        let found = strips.slope(&at, false, Variable::AirRate(3 + axis));
        let mut expected = vec![0.0; found.len()];
        for (section, place_m) in places_m.iter().enumerate() {
            let acceleration = spin_rate.cross(place_m);
            for (component, share) in acceleration.iter().chain(&spin_rate).enumerate() {
                let slope = strips.slope(&at, false, Variable::Motion { section, component: 12 + component });
                expected.iter_mut().zip(slope).for_each(|(sum, slope)| *sum += share * slope);
            }
        }
        let scale = expected.iter().fold(0.0f64, |scale, entry| scale.max(entry.abs()));
        assert!(scale > 1e-3, "axis {axis}: nothing answers");
        for (row, (a, b)) in found.iter().zip(&expected).enumerate() {
            assert!((a - b).abs() < 1e-12 * scale, "axis {axis}, row {row}: {a} {b}");
        }
    }
}

/// Eqs. (U16) and (U18): circulation and leading-edge singularity of a plate whose control surface is deflected and moves, by quadrature of
/// the normal velocity over `x = cos t`: the quasi-steady circulation is that of the mean over `1 + x`, the singularity at the leading edge
/// with this circulation is that of the mean. Thin-aerofoil theory.
#[test]
fn circulation_and_singularity_of_a_moving_control_surface() {
    let (chord_m, along_m_s, angle_rad, rate_rad_s) = (0.6, 12.0, 0.07, 1.9);
    for fraction in [0.05, 0.3, 0.5, 0.75, 0.9] {
        let hinge = Hinge::at(fraction);
        let flap = FlapInflow { hinge, flap: 0, angle_rad, rate_rad_s, share: 1.0, downwash_m_s: 0.0 };
        let normal_m_s = |x: f64| along_m_s * angle_rad + (x - hinge.c) * 0.5 * chord_m * rate_rad_s;
        // Simpson's rule over the control surface, x = cos t from the hinge to the trailing edge at t = 0
        let (count, end) = (200, hinge.c.acos());
        let mean = |weight: fn(f64) -> f64| {
            let width = end / f64::from(count);
            let value = |t: f64| weight(t.cos()) * normal_m_s(t.cos());
            let panel = |i: i32| {
                let t = f64::from(i) * width;
                (value(t) + 4.0 * value(t + 0.5 * width) + value(t + width)) * width / 6.0
            };
            (0..count).map(panel).sum::<f64>() / PI
        };
        let (from_kutta_m_s, singularity_m_s, reversed_m_s) = (mean(|x| 1.0 + x), mean(|_| 1.0), mean(|x| 1.0 - x));
        // fourth order in 1/200 of the interval
        let near = |value: f64, wanted: f64| assert!((value - wanted).abs() < 1e-9 * along_m_s, "{value} {wanted}");
        near(flap.circulating_m_s(chord_m, along_m_s, 1.0), from_kutta_m_s);
        near(flap.circulating_m_s(chord_m, along_m_s, -1.0), reversed_m_s);
        near(from_kutta_m_s - flap.edge_m_s(chord_m, along_m_s), singularity_m_s);
    }
}

/// (X37). Derivatives of a step lie on the interval of the polar in which each strip is, although their differences pass its rows: they are those
/// of a polar that continues the line of this interval.
#[test]
fn derivatives_stay_on_the_interval_of_the_polar() {
    let row = |angle_rad: f64| PolarRow {
        angle_rad,
        lift: 1.1 * (2.0 * angle_rad).sin() + 0.2 * (40.0 * angle_rad).sin(),
        drag: 0.01 + angle_rad.sin().powi(2),
        moment: -0.05 * angle_rad.cos(),
    };
    let kinked = Polar { rows: (-180..=180).map(|angle_deg| row(f64::from(angle_deg).to_radians())).collect() };
    let slopes = |polar: Polar| {
        let mut strips = Strips::new(wing(Profile { polar: Some(polar), ..cambered() }), StripOptions::default());
        let (mut from, mut to) = (strips.blank_state(), strips.blank_state());
        let mut loads = AirLoads::still(3);
        strips.start(&motions(), &flow(), true, &mut from, &mut loads);
        strips.holding = Holding::Record(strips.no_pieces());
        strips.solve(&from, &motions(), &flow(), 0.01, &mut to, &mut loads);
        let pieces = strips.holding.recorded().expect("recorded");
        let slopes = strips.step_slopes(&from, &motions(), &flow(), 0.01, &pieces).expect("a flow");
        (slopes, pieces)
    };
    let (found, pieces) = slopes(kinked.clone());
    for (strip, (found, list)) in found.iter().zip(&pieces).enumerate() {
        let end = |angle_rad| kinked.in_interval(list.choices[0], angle_rad);
        let (known, _) = slopes(Polar { rows: vec![end(-PI), end(PI)] });
        let apart = (found - known[strip]).amax() / known[strip].amax();
        println!("strip {strip}: {apart:.1e}");
        // round-off of the differences
        assert!(apart < 1e-9, "strip {strip}: {apart:.1e}");
    }
}
