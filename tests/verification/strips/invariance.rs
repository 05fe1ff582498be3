//! W-20 to W-28: invariances of any aerodynamic model on any wing, and attitudes beyond the linear range.

use crate::strips::plate::{Motion, Plate};
use foldwing::aero::AirLoads;
use foldwing::aero::flow::{Flow, Gust, GustShape};
use foldwing::aero::strip::{StripOptions, StripState, Strips};
use foldwing::aero::surface::{ChordLine, Profile, Surface};
use foldwing::load::{SectionMotion, Wrench};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Sections of the wing.
const SECTIONS: usize = 5;
/// Number of steps in the comparisons: enough for a history of lag states and impulse.
const STEPS: usize = 6;
const STEP_S: f64 = 0.01;

/// Differences between two runs that must agree.
#[derive(Clone)]
struct Setting {
    /// Rotation of everything: wind, gust, motion.
    turn: Matrix3<f64>,
    /// Velocity added to wing and air, m/s.
    drift_m_s: Vector3<f64>,
    density_kg_m3: f64,
    /// Factor on all velocities (and on the number of steps per second, so that the paths are unchanged).
    speed: f64,
    /// Angular velocity of the frame in which the same motion is described, rad/s.
    frame_rad_s: Vector3<f64>,
    /// Leading and trailing edge exchanged.
    reversed: bool,
    profile: Profile,
    options: StripOptions,
}

impl Default for Setting {
    fn default() -> Self {
        Self {
            turn: Matrix3::identity(),
            drift_m_s: Vector3::zeros(),
            density_kg_m3: 1.2,
            speed: 1.0,
            frame_rad_s: Vector3::zeros(),
            reversed: false,
            profile: Profile {
                zero_lift_angle_rad: -0.05,
                moment_coefficient: -0.04,
                drag_coefficient: 0.03,
                ..Profile::THIN
            },
            options: StripOptions::default(),
        }
    }
}

/// A swept, tapered wing; the zero-lift line of its profile is not on the chord.
fn wing(setting: &Setting) -> Surface {
    let chords = (0..SECTIONS)
        .map(|i| {
            let x = i as f64 / (SECTIONS - 1) as f64;
            let (leading_m, trailing_m) =
                (Vector3::new(0.02, 0.2 - 0.15 * x, 0.01), Vector3::new(-0.01, -0.4 + 0.1 * x, -0.01));
            match setting.reversed {
                true => ChordLine { leading_m: trailing_m, trailing_m: leading_m },
                false => ChordLine { leading_m, trailing_m },
            }
        })
        .collect();
    Surface { sections: 0..SECTIONS, chords, chord_panels: 1, profile: setting.profile.clone() }
}

/// Positions, attitudes and velocities in the inertial frame: a wing that bends, twists and flaps by large angles.
fn inertial(setting: &Setting, time_s: f64) -> Vec<SectionMotion> {
    let t = time_s * setting.speed;
    (0..SECTIONS)
        .map(|i| {
            let x = 0.5 * i as f64;
            let amplitude = Vector3::new(0.3, -0.2 * x, 0.1 * x);
            let (angle, rate) = (1.0 + (9.0 * t).sin(), 9.0 * (9.0 * t).cos());
            // rotation about a fixed axis: the rate of the rotation vector is the angular velocity
            let turning = Rotation3::from_scaled_axis(amplitude * angle).into_inner();
            let position_m = Vector3::new(x, 0.1 * x * (5.0 * t).sin(), 0.2 * x * x * (7.0 * t).sin());
            let velocity_m_s = Vector3::new(0.0, 0.5 * x * (5.0 * t).cos(), 1.4 * x * x * (7.0 * t).cos());
            SectionMotion {
                rotation: setting.turn * turning,
                position_m: setting.turn * (position_m + setting.drift_m_s * time_s),
                velocity_m_s: setting.turn * (velocity_m_s * setting.speed + setting.drift_m_s),
                spin_rad_s: setting.turn * (amplitude * rate * setting.speed),
            }
        })
        .collect()
}

/// Loads of each step, transformed back into the frame of the default setting.
fn loads(setting: &Setting) -> (Vec<AirLoads>, StripState) {
    let mut strips = Strips::new(vec![wing(setting)], setting.options);
    let (mut from, mut to) = (strips.blank_state(), strips.blank_state());
    let mut loads = AirLoads::still(SECTIONS);
    let wind_m_s = Vector3::new(1.0, -8.0, 1.2) * setting.speed;
    let gust_speed_m_s = 8.0 * setting.speed;
    let mut history = Vec::new();
    for step in 0..=STEPS {
        let time_s = step as f64 * STEP_S / setting.speed;
        // the frame rotates by R(t): a point fixed in space rotates backward in it
        let back = setting.turn * Rotation3::from_scaled_axis(-setting.frame_rad_s * time_s).into_inner();
        let spin_rad_s = setting.turn * setting.frame_rad_s;
        let direction = back * -Vector3::y();
        let gusts = [Gust {
            name: "gust".into(),
            shape: GustShape::OneMinusCosine { length_m: 1.0 },
            velocity_m_s: back * Vector3::new(0.2, 0.3, 1.5) * setting.speed,
            direction,
            speed_m_s: gust_speed_m_s + setting.drift_m_s.dot(&-Vector3::y()),
            origin_m: back * Vector3::y() * 0.3,
            start_s: 0.0,
        }];
        let flow = Flow {
            time_s,
            density_kg_m3: setting.density_kg_m3,
            wind_m_s: back * (wind_m_s + setting.drift_m_s),
            spin_rad_s,
            gusts: &gusts,
        };
        let motions: Vec<SectionMotion> = inertial(setting, time_s)
            .into_iter()
            .map(|motion| {
                let bring = back * setting.turn.transpose();
                let position_m = bring * motion.position_m;
                SectionMotion {
                    rotation: bring * motion.rotation,
                    position_m,
                    velocity_m_s: bring * motion.velocity_m_s - spin_rad_s.cross(&position_m),
                    spin_rad_s: bring * motion.spin_rad_s - spin_rad_s,
                }
            })
            .collect();
        if step == 0 {
            strips.start(&motions, &flow, false, &mut from, &mut loads);
        } else {
            strips.convect(&from, &flow, STEP_S / setting.speed, &mut to);
            strips.solve(&from, &motions, &flow, STEP_S / setting.speed, &mut to, &mut loads);
            from.copy_from(&to);
        }
        let forward = back.transpose();
        let turned = |wrenches: &[Wrench]| -> Vec<Wrench> {
            let turn = |w: &Wrench| Wrench { force_n: forward * w.force_n, moment_n_m: forward * w.moment_n_m };
            wrenches.iter().map(turn).collect()
        };
        history.push(AirLoads { circulatory: turned(&loads.circulatory), impulsive: turned(&loads.impulsive) });
    }
    (history, from)
}

/// Largest difference between two histories of loads, relative to the largest force; the second one is divided by `factor`.
fn difference(a: &[AirLoads], b: &[AirLoads], factor: f64, impulsive: bool) -> f64 {
    let pick = |loads: &AirLoads| if impulsive { loads.impulsive.clone() } else { loads.circulatory.clone() };
    let (mut most, mut size): (f64, f64) = (0.0, 0.0);
    for (a, b) in a.iter().flat_map(pick).zip(b.iter().flat_map(pick)) {
        most = most.max((a.force_n - b.force_n / factor).norm()).max((a.moment_n_m - b.moment_n_m / factor).norm());
        size = size.max(a.force_n.norm());
    }
    assert!(size > 0.1, "no load to compare: {size}");
    most / size
}

/// W-20. A rotation of everything rotates the loads; a common drift of wing and air does not change them; loads are proportional to density
/// and, for the same path, to the square of the speed. Tolerance: round-off of some hundred operations.
#[test]
fn w20_rotation_drift_density_and_speed() {
    let (reference, _) = loads(&Setting::default());
    let turn = Rotation3::from_scaled_axis(Vector3::new(0.7, -1.9, 0.4)).into_inner();
    let cases = [
        ("turned", Setting { turn, ..Default::default() }, 1.0),
        ("drifting", Setting { drift_m_s: Vector3::new(3.0, 20.0, -7.0), ..Default::default() }, 1.0),
        ("denser", Setting { density_kg_m3: 3.6, ..Default::default() }, 3.0),
        ("faster", Setting { speed: 5.0, ..Default::default() }, 25.0),
    ];
    for (name, setting, factor) in cases {
        let (changed, _) = loads(&setting);
        for impulsive in [false, true] {
            let off = difference(&reference, &changed, factor, impulsive);
            println!("W-20 {name}, impulsive {impulsive}: {off:.1e}");
            assert!(off < 1e-11, "{name}, impulsive {impulsive}: {off:.1e}");
        }
    }
}

/// W-21. The same motion in a rotating frame: circulatory loads to round-off; the impulsive ones act along the mean normal, which in such a
/// frame is rotated by the rotation of half a step.
#[test]
fn w21_turning_frame() {
    let (reference, state) = loads(&Setting::default());
    let frame_rad_s = Vector3::new(0.5, -0.8, 1.1);
    let (seen, seen_state) = loads(&Setting { frame_rad_s, ..Default::default() });
    let off = difference(&reference, &seen, 1.0, false);
    println!("W-21 turning frame: {off:.1e}");
    assert!(off < 1e-11, "{off:.1e}");
    assert!(difference(&reference, &seen, 1.0, true) < frame_rad_s.norm() * STEP_S);
    for (a, b) in state.strips.iter().zip(&seen_state.strips) {
        assert!((a.circulation_m2_s - b.circulation_m2_s).abs() < 1e-11 * a.circulation_m2_s.abs());
    }
}

/// W-22. The edges of a thin plate are interchangeable: exchanged leading and trailing edges, at any attitude, give the same loads.
#[test]
fn w22_reversed_flow() {
    let thin = Setting { profile: Profile::THIN, ..Default::default() };
    let (reference, _) = loads(&thin);
    // the span of the reversed wing is divided normal to the three-quarter line of the other: compare without sweep
    let (swept, _) = loads(&Setting { reversed: true, ..thin });
    assert!(difference(&reference, &swept, 1.0, false) < 0.1);
    let plate = Plate { profile: Profile::THIN, ..Default::default() };
    let moving = |time_s: f64| Motion {
        heave_m: 0.5 * (3.0 * time_s).sin(),
        heave_m_s: 1.5 * (3.0 * time_s).cos(),
        pitch_rad: 0.5 + 2.0 * time_s,
        pitch_rad_s: 2.0,
    };
    let reversed = |time_s: f64| Motion { pitch_rad: moving(time_s).pitch_rad + PI, ..moving(time_s) };
    let (forward, backward) =
        (plate.march(moving, &[], false, 0.01, 300), plate.march(reversed, &[], false, 0.01, 300));
    let size_n_m = forward.iter().map(|[c, _]| c.lift_n_m.abs()).fold(0.0, f64::max);
    for ([a, b], [c, d]) in forward.iter().zip(&backward) {
        // a pitch rotation by π exchanges the edges and leaves the nose-up direction unchanged
        for (x, y) in [(a, c), (b, d)] {
            assert!((x.lift_n_m - y.lift_n_m).abs() < 1e-11 * size_n_m, "{x:?} {y:?}");
            assert!((x.thrust_n_m - y.thrust_n_m).abs() < 1e-11 * size_n_m, "{x:?} {y:?}");
            assert!((x.moment_n - y.moment_n).abs() < 1e-11 * size_n_m, "{x:?} {y:?}");
        }
    }
}

/// W-23. All angles of attack: the plate's lift coefficient `2π sin α cos α (|cos α| + sin² α)` (without suction `2π sin α cos α |cos α|`)
/// is within ±1.25 π and has the sign of `sin α cos α`; at 90° there is only drag, no force normal to the wind; and there is no kink
/// anywhere.
#[test]
fn w23_plate_at_any_angle() {
    let profile = Profile { drag_coefficient: 0.1, ..Profile::THIN };
    for leading_edge_suction in [true, false] {
        let options = StripOptions { leading_edge_suction, ..Default::default() };
        let plate = Plate { profile: profile.clone(), options, ..Default::default() };
        let size_n_m = plate.density_kg_m3 * plate.speed_m_s.powi(2) * plate.semi_chord_m;
        let at = |pitch_rad: f64| plate.march(|_| Motion { pitch_rad, ..Default::default() }, &[], true, 0.1, 0)[0][0];
        let (mut last, mut most) = (at(-PI), 0.0_f64);
        for degree in -179..=180 {
            let alpha_rad = f64::from(degree).to_radians();
            let loads = at(alpha_rad);
            let lift = loads.lift_n_m / size_n_m;
            most = most.max(lift.abs());
            let sign = (2.0 * alpha_rad).sin();
            assert!(lift * sign > 0.0 || sign.abs() < 1e-9, "{degree}°: {lift}");
            // 2π per rad is 0.11 per degree; sin α cos α (|cos α| + sin² α) is at most 1.3 times as steep as sin α
            assert!((loads.lift_n_m - last.lift_n_m).abs() < 0.143 * size_n_m, "{degree}°");
            assert!(loads.thrust_n_m < -0.099 * size_n_m, "{degree}°: {loads:?}"); // never less drag than that of the profile
            last = loads;
        }
        println!("W-23 suction {leading_edge_suction}: largest lift coefficient {most:.3}");
        assert!(most < 1.25 * PI, "{most}");
        let across = at(FRAC_PI_2);
        assert!(across.lift_n_m.abs() < 1e-12 * size_n_m && across.moment_n.abs() < 1e-12 * size_n_m, "{across:?}");
        assert!((across.thrust_n_m + 0.1 * size_n_m).abs() < 1e-12 * size_n_m, "{across:?}");
    }
}

/// W-24. Infinite swept wing: the lift of the straight one times the cosine of the sweep, per area and streamwise angle. Dihedral rotates
/// the force.
#[test]
fn w24_sweep_and_dihedral() {
    let (chord_m, sweep_rad, dihedral_rad) = (0.8, 0.6_f64, 0.3_f64);
    let angle_rad = 1e-6;
    let force_n = |sweep_rad: f64, dihedral_rad: f64| {
        let chord = ChordLine { leading_m: Vector3::y() * 0.25 * chord_m, trailing_m: -Vector3::y() * 0.75 * chord_m };
        let surface = Surface { sections: 0..2, chords: vec![chord; 2], chord_panels: 1, profile: Profile::THIN };
        let mut strips = Strips::new(vec![surface], StripOptions::default());
        let tip_m = Vector3::new(1.0, -sweep_rad.tan(), dihedral_rad.tan());
        let motions = [Vector3::zeros(), tip_m].map(|position_m| SectionMotion {
            rotation: Matrix3::identity(),
            position_m,
            velocity_m_s: Vector3::zeros(),
            spin_rad_s: Vector3::zeros(),
        });
        let wind_m_s = Vector3::new(0.0, -10.0, 10.0 * angle_rad);
        let flow = Flow { time_s: 0.0, density_kg_m3: 1.0, wind_m_s, spin_rad_s: Vector3::zeros(), gusts: &[] };
        let (mut state, mut loads) = (strips.blank_state(), AirLoads::still(2));
        strips.start(&motions, &flow, true, &mut state, &mut loads);
        loads.circulatory.iter().map(|wrench| wrench.force_n).sum::<Vector3<f64>>()
    };
    let straight_n = force_n(0.0, 0.0);
    assert!((straight_n.z / (2.0 * PI * 50.0 * chord_m * angle_rad) - 1.0).abs() < 1e-6);
    // equal area, since the span normal to the flow is 1 m in both cases
    assert!((force_n(sweep_rad, 0.0).z / straight_n.z / sweep_rad.cos() - 1.0).abs() < 1e-6);
    // the wing is longer by 1/cos and its normal velocity smaller by cos: its normal force is the same, tilted
    let tilted_n = force_n(0.0, dihedral_rad);
    assert!((tilted_n.z / straight_n.z / dihedral_rad.cos() - 1.0).abs() < 1e-6, "{tilted_n}");
    assert!((tilted_n.x / tilted_n.z + dihedral_rad.tan()).abs() < 1e-6, "{tilted_n}");
}

/// W-25. Work of the impulsive loads on a heaving and pitching plate in still air = loss of kinetic energy of the air, step by step to
/// round-off: this ensures stability for light wings.
#[test]
fn w25_apparent_mass_stores_energy() {
    let plate = Plate { speed_m_s: 0.0, ..Default::default() };
    let (b, rho, step_s) = (plate.semi_chord_m, plate.density_kg_m3, 0.01);
    let sinking_m_s = |time_s: f64| (20.0 * time_s).sin() + 0.3;
    let history =
        plate.march(|time_s| Motion { heave_m_s: sinking_m_s(time_s), ..Default::default() }, &[], false, step_s, 100);
    let energy_j_m = |time_s: f64| 0.5 * PI * rho * b * b * sinking_m_s(time_s).powi(2);
    for (step, [_, impulsive]) in history.iter().enumerate().skip(1) {
        let (before_s, now_s) = ((step - 1) as f64 * step_s, step as f64 * step_s);
        // the mean force over the step times the displacement of a plate with uniform acceleration
        let work_j_m = -impulsive.lift_n_m * 0.5 * (sinking_m_s(before_s) + sinking_m_s(now_s)) * step_s;
        let gain_j_m = energy_j_m(now_s) - energy_j_m(before_s);
        assert!((work_j_m + gain_j_m).abs() < 1e-13, "step {step}: {work_j_m} J/m, {gain_j_m} J/m");
    }
}

/// W-26. Refining the strips of a twisted, tapered wing changes the total with the square of their width.
#[test]
fn w26_second_order_in_the_strips() {
    let total = |strips: usize| {
        let place = |i: usize| i as f64 / strips as f64;
        let chords = (0..=strips)
            .map(|i| {
                let half_m = 0.5 * (1.0 - 0.5 * place(i).powi(2));
                ChordLine { leading_m: Vector3::y() * half_m, trailing_m: -Vector3::y() * half_m }
            })
            .collect();
        let motions: Vec<_> = (0..=strips)
            .map(|i| SectionMotion {
                rotation: Rotation3::from_axis_angle(&Vector3::x_axis(), 0.2 * place(i).powi(3)).into_inner(),
                position_m: Vector3::new(3.0 * place(i), 0.0, 0.5 * place(i).powi(2)),
                velocity_m_s: Vector3::zeros(),
                spin_rad_s: Vector3::zeros(),
            })
            .collect();
        let surface = Surface { sections: 0..strips + 1, chords, chord_panels: 1, profile: Profile::THIN };
        let mut model = Strips::new(vec![surface], StripOptions::default());
        let wind_m_s = Vector3::new(0.0, -10.0, 0.3);
        let flow = Flow { time_s: 0.0, density_kg_m3: 1.0, wind_m_s, spin_rad_s: Vector3::zeros(), gusts: &[] };
        let (mut state, mut loads) = (model.blank_state(), AirLoads::still(strips + 1));
        model.start(&motions, &flow, true, &mut state, &mut loads);
        let moment = |(w, m): (&Wrench, &SectionMotion)| w.moment_n_m + m.position_m.cross(&w.force_n);
        let root_n_m: Vector3<f64> = loads.circulatory.iter().zip(&motions).map(moment).sum();
        root_n_m
    };
    let [coarse, middle, fine] = [8, 16, 32].map(total);
    let order = ((coarse - middle).norm() / (middle - fine).norm()).log2();
    println!("W-26 order in the strips: {order:.2}");
    assert!((order - 2.0).abs() < 0.1, "{order}");
}
