//! The lifting line through the strips, eqs. (W10) to (W12): against the lattice with one panel along the chord, elliptic and infinite
//! wings; mirrors, frames, reversed flow.

use crate::lattice::wing::{SPEED_M_S, Wing, inset, options, pressure_pa};
use foldwing::aero::AirLoads;
use foldwing::aero::flow::Flow;
use foldwing::aero::strip::lifting_line::LiftingLineOptions;
use foldwing::aero::strip::{StripOptions, StripState, Strips};
use foldwing::aero::surface::{ChordLine, Profile, Surface};
use foldwing::load::SectionMotion;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::PI;

pub const LINE: LiftingLineOptions = LiftingLineOptions { core_radius_m: 1e-4, mirror_normal: None };

fn strip_options() -> StripOptions {
    StripOptions { tip_loss: Some(LINE), ..Default::default() }
}

/// A wing of strips with the sections of a lattice wing, its quarter chord on the axis.
pub struct Line {
    pub strips: Strips,
    state: StripState,
    after: StripState,
    pub loads: AirLoads,
    pub motions: Vec<SectionMotion>,
    count: usize,
}

impl Line {
    pub fn new(places_m: &[f64], chord_m: impl Fn(f64) -> f64, profile: Profile, options: StripOptions) -> Self {
        let chords = places_m.iter().map(|x| ChordLine {
            leading_m: Vector3::y() * (0.25 * chord_m(*x)),
            trailing_m: Vector3::y() * (-0.75 * chord_m(*x)),
        });
        let surface = Surface { sections: 0..places_m.len(), chords: chords.collect(), chord_panels: 1, profile };
        let strips = Strips::new(vec![surface], options);
        let wing = Wing::new(places_m, &chord_m, 1, self::options());
        Self {
            state: strips.blank_state(),
            after: strips.blank_state(),
            loads: AirLoads::still(places_m.len()),
            motions: wing.motions.clone(),
            count: places_m.len() - 1,
            strips,
        }
    }

    pub fn start(&mut self, wind_m_s: Vector3<f64>, established: bool) {
        self.start_in(&flow(wind_m_s), established);
    }

    pub fn start_in(&mut self, flow: &Flow, established: bool) {
        self.strips.start(&self.motions, flow, established, &mut self.state, &mut self.loads);
    }

    fn step(&mut self, wind_m_s: Vector3<f64>, step_s: f64) {
        let flow = flow(wind_m_s);
        self.strips.convect(&self.state, &flow, step_s, &mut self.after);
        self.strips.solve(&self.state, &self.motions, &flow, step_s, &mut self.after, &mut self.loads);
        std::mem::swap(&mut self.state, &mut self.after);
    }

    pub fn circulations(&self) -> Vec<f64> {
        (0..self.count).map(|strip| self.strips.strip_circulation_m2_s(&self.state, 0, strip)).collect()
    }

    pub fn force_n(&self) -> Vector3<f64> {
        self.loads.circulatory.iter().map(|load| load.force_n).sum()
    }
}

pub fn flow<'a>(wind_m_s: Vector3<f64>) -> Flow<'a> {
    Flow { time_s: 0.0, density_kg_m3: 1.2, wind_m_s, spin_rad_s: Vector3::zeros(), gusts: &[] }
}

pub fn wind(angle_rad: f64) -> Vector3<f64> {
    Rotation3::from_axis_angle(&Vector3::x_axis(), -angle_rad) * (Vector3::y() * -SPEED_M_S)
}

pub fn worst(ours: &[f64], theirs: &[f64]) -> f64 {
    let size = theirs.iter().map(|value| value.abs()).fold(0.0, f64::max);
    ours.iter().zip(theirs).map(|(a, b)| (a - b).abs() / size).fold(0.0, f64::max)
}

/// Bends a straight wing into an arch of a total angle about the chord.
pub fn arch(motions: &mut [SectionMotion], total_rad: f64) {
    let (first, last) = (motions[0].position_m.x, motions[motions.len() - 1].position_m.x);
    for motion in motions {
        let angle_rad = total_rad * (motion.position_m.x - first) / (last - first);
        let radius_m = (last - first) / total_rad;
        motion.position_m = Vector3::new(first + radius_m * angle_rad.sin(), 0.0, radius_m * (1.0 - angle_rad.cos()));
        motion.rotation = Rotation3::from_axis_angle(&Vector3::y_axis(), -angle_rad).into_inner();
    }
}

/// W-34. In steady flow the lifting line equals the lattice with one panel along the chord, strip by strip: on flat wings and on one bent
/// up by 70 degrees. Different wake lengths cause a difference of 1e-6. The suction of the plate of eq. (W7) falls with the cosine of the
/// incidence, so its circulation is less than that of the lattice by a quarter of the fourth power: 3e-5 at 0.1 rad.
#[test]
fn w34_steady_line_is_the_lattice_of_one_panel() {
    for (span_m, strips, bend_rad, angle_rad) in [(4.0, 8, 0.0, 1e-3), (12.0, 24, 0.0, 0.1), (12.0, 24, 1.2, 0.1)] {
        let places_m = inset(span_m, strips);
        let mut lattice = Wing::new(&places_m, |_| 1.0, 1, options()).with_incidence(angle_rad);
        let mut line = Line::new(&places_m, |_| 1.0, Profile::THIN, strip_options());
        if bend_rad > 0.0 {
            arch(&mut lattice.motions, bend_rad);
            arch(&mut line.motions, bend_rad);
        }
        lattice.start(true);
        line.start(wind(angle_rad), true);
        let theirs: Vec<f64> =
            (0..strips).map(|strip| lattice.lattice.strip_circulation(&lattice.from, 0, strip)).collect();
        let error = worst(&line.circulations(), &theirs);
        println!("W-34 span {span_m} m, bend {bend_rad} rad, {angle_rad} rad: worst strip {error:.1e}");
        assert!(error < 2e-6 + 0.3 * angle_rad.powi(4), "{:?} against {theirs:?}", line.circulations());
    }
}

/// W-35. Elliptic wings: the lift slope against Van Dyke's third-order lifting line, `2π/(1 + 2/A + 16/(πA)² (ln πA − 9/8))` (Archiwum
/// Mechaniki Stosowanej 16, 1964), whose next term is of order `1/A³`; the loading tends to the ellipse. The induced drag follows from the
/// downwash at three quarters of the chord, which is larger than at the bound vortex: it is too large, by an amount that falls slowly with
/// A.
#[test]
fn w35_elliptic_wing() {
    let (angle_rad, strips) = (1e-2, 160);
    let mut errors = Vec::new();
    for aspect in [10.0, 20.0, 40.0] {
        let root_m = 1.0;
        let span_m = aspect * PI / 4.0 * root_m;
        let chord_m = |x: f64| root_m * (1.0 - (2.0 * x / span_m).powi(2)).max(0.0).sqrt();
        let places_m = inset(span_m, strips);
        let mut line = Line::new(&places_m, chord_m, Profile::THIN, strip_options());
        line.start(wind(angle_rad), true);
        let along = wind(angle_rad).normalize();
        let force_n = line.force_n();
        let area_m2 = PI / 4.0 * span_m * root_m;
        let lift = force_n.dot(&along.cross(&Vector3::x())) / (pressure_pa() * area_m2);
        let drag = force_n.dot(&along) / (pressure_pa() * area_m2);
        let third = 16.0 / (PI * aspect).powi(2) * ((PI * aspect).ln() - 9.0 / 8.0);
        let slope = lift / angle_rad / (2.0 * PI / (1.0 + 2.0 / aspect + third)) - 1.0;
        let efficiency = lift * lift / (PI * aspect * drag) - 1.0;
        let loading: Vec<f64> = (0..strips)
            .map(|strip| 0.5 * (places_m[strip] + places_m[strip + 1]))
            .zip(line.circulations())
            .filter(|(x, _)| x.abs() < 0.45 * span_m)
            .map(|(x, circulation)| circulation / chord_m(x))
            .collect();
        let mean = loading.iter().sum::<f64>() / loading.len() as f64;
        let uneven = loading.iter().map(|value| (value / mean - 1.0).abs()).fold(0.0, f64::max);
        println!("W-35 A = {aspect}: slope {slope:+.4}, drag {efficiency:+.4}, loading off the ellipse {uneven:.4}");
        assert!(uneven < 0.5 / aspect, "A = {aspect}: loading {uneven}");
        errors.push([slope, efficiency]);
    }
    for ([slope, efficiency], [slopes, drags]) in errors.iter().zip([[0.009, 0.2], [0.003, 0.135], [0.0015, 0.085]]) {
        assert!(slope.abs() < slopes && *efficiency < 0.0 && *efficiency > -drags, "{errors:?}");
    }
}

/// W-36. Doubling the number of strips reduces the error to a quarter, for a rectangular wing of aspect ratio 12.8.
#[test]
fn w36_converges_with_the_strips() {
    let lift = |strips: usize| {
        let mut line = Line::new(&inset(12.8, strips), |_| 1.0, Profile::THIN, strip_options());
        line.start(wind(1e-2), true);
        line.force_n().z
    };
    let values = [12, 24, 48, 96].map(lift);
    let changes: Vec<f64> = values.windows(2).map(|pair| ((pair[1] - pair[0]) / pair[1]).abs()).collect();
    println!("W-36 changes of the lift from 12 to 24, 48, 96 strips: {changes:.5?}");
    assert!(changes[0] < 6e-3 && changes[1] < 0.3 * changes[0] && changes[2] < 0.3 * changes[1], "{changes:?}");
}

/// W-37. An infinite wing has no induced loss: in the middle of a wing of aspect ratio 20000 the strip has the lift of strip theory, apart
/// from 2/A, the loss of an elliptic wing of that aspect ratio. A wing of zero lift slope has no lift.
#[test]
fn w37_endless_wing_and_wing_without_lift() {
    let places_m = inset(20_000.0, 41);
    let middle = |options| {
        let mut line = Line::new(&places_m, |_| 1.0, Profile::THIN, options);
        line.start(wind(1e-2), true);
        line.circulations()[20]
    };
    let (with, without) = (middle(strip_options()), middle(StripOptions::default()));
    assert!((with / without - 1.0).abs() < 1e-4, "{with} against {without}");
    let mut flat =
        Line::new(&inset(6.0, 8), |_| 1.0, Profile { lift_slope_1_rad: 0.0, ..Profile::THIN }, strip_options());
    flat.start(wind(1e-2), true);
    assert!(flat.circulations().iter().all(|circulation| *circulation == 0.0));
}

/// W-38. Half a wing at a mirror plane equals half of the whole wing; the wing is symmetric; a flying wing equals the wing in the wind;
/// wind from the trailing edge gives the circulation of the wing rotated by 180°.
#[test]
fn w38_mirror_symmetry_frames_and_reversed_flow() {
    let chord_m = |x: f64| 1.0 - 0.08 * x.abs();
    let whole_places_m = inset(8.0, 16);
    let mut whole = Line::new(&whole_places_m, chord_m, Profile::THIN, strip_options());
    whole.start(wind(0.1), true);
    let circulations = whole.circulations();
    let turned: Vec<f64> = circulations.iter().rev().copied().collect();
    assert!(worst(&circulations, &turned) < 1e-12, "{circulations:?}");

    let half_places_m: Vec<f64> = whole_places_m[8..].to_vec();
    let mirror = LiftingLineOptions { mirror_normal: Some(Vector3::x()), ..LINE };
    let options = StripOptions { tip_loss: Some(mirror), ..Default::default() };
    let mut half = Line::new(&half_places_m, chord_m, Profile::THIN, options);
    half.start(wind(0.1), true);
    // legs 200 diameters long, of the half and of the whole wing: 1e-6
    assert!(worst(&half.circulations(), &circulations[8..]) < 5e-6, "{:?}", half.circulations());

    let mut flying = Line::new(&whole_places_m, chord_m, Profile::THIN, strip_options());
    flying.motions.iter_mut().for_each(|motion| motion.velocity_m_s = -wind(0.1));
    flying.start(Vector3::zeros(), true);
    assert!(worst(&flying.circulations(), &circulations) < 1e-12, "{:?}", flying.circulations());

    let mut behind = Line::new(&whole_places_m, chord_m, Profile::THIN, strip_options());
    let back = Rotation3::from_axis_angle(&Vector3::x_axis(), 0.1) * (Vector3::y() * SPEED_M_S);
    behind.start(back, true);
    // the axis of the planform is at a quarter of the chord in one case and at three quarters in the other: effect of taper
    let error = worst(&behind.circulations(), &circulations);
    assert!(error < 0.03, "{error}: {:?} against {circulations:?}", behind.circulations());

    // without taper, in sideslip: rotated by 180° in its plane, the wing has the same forces on each section; those on the chordwise legs
    // cancel over the whole wing
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), PI);
    let sideways = wind(0.1) + Vector3::x() * (0.3 * SPEED_M_S);
    let [forwards_n, backwards_n] = [sideways, turn * sideways].map(|wind_m_s| {
        let mut line = Line::new(&whole_places_m, |_| 1.0, Profile::THIN, strip_options());
        line.start(wind_m_s, true);
        line.loads.circulatory.iter().map(|load| load.force_n).collect::<Vec<_>>()
    });
    let pairs = forwards_n.iter().zip(backwards_n.iter().rev());
    let error = pairs.map(|(one, other)| (turn * one - other).norm()).fold(0.0, f64::max) / forwards_n[8].norm();
    // the legs make the loads of both halves unequal
    let skew = (forwards_n[4].z / forwards_n[12].z - 1.0).abs();
    println!("W-38 in sideslip, rotated: {error:.1e}, halves differ by {skew:.3}");
    assert!(error < 1e-12 && skew > 0.01, "{error}, {skew}");
}

/// W-39. After a sudden start the lift grows to that of the steady flow, from about half of the lift of strip theory, which is more than
/// half of its final value (the trailing vortices are still short). For a heaving wing the error falls with the square of the step.
#[test]
fn w39_growth_and_order_in_time() {
    let places_m = inset(6.0, 12);
    let mut sudden = Line::new(&places_m, |_| 1.0, Profile::THIN, strip_options());
    let mut established = Line::new(&places_m, |_| 1.0, Profile::THIN, strip_options());
    established.start(wind(1e-2), true);
    let end_n = established.force_n().z;
    sudden.start(wind(1e-2), false);
    let first = sudden.force_n().z / end_n;
    for _ in 0..8000 {
        sudden.step(wind(1e-2), 0.025);
    }
    let last = sudden.force_n().z / end_n;
    println!("W-39 aspect ratio 6: starts at {first:.3} of its end (Jones: 0.64), ends at {last:.6}");
    assert!((0.6..0.72).contains(&first) && (last - 1.0).abs() < 1e-4, "{first}, {last}");

    let heave = |steps: usize| {
        let mut line = Line::new(&places_m, |_| 1.0, Profile::THIN, strip_options());
        let rest: Vec<SectionMotion> = line.motions.clone();
        let set = |line: &mut Line, time_s: f64| {
            for (motion, rest) in line.motions.iter_mut().zip(&rest) {
                let (angle_rad, rate_rad_s) = (0.3 * (8.0 * time_s).sin(), 2.4 * (8.0 * time_s).cos());
                let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), angle_rad).into_inner();
                motion.position_m = turn * rest.position_m;
                motion.rotation = turn;
                motion.spin_rad_s = Vector3::y() * rate_rad_s;
                motion.velocity_m_s = motion.spin_rad_s.cross(&motion.position_m);
            }
        };
        set(&mut line, 0.0);
        line.start(wind(0.05), true);
        for step in 1..=steps {
            set(&mut line, 0.4 * step as f64 / steps as f64);
            line.step(wind(0.05), 0.4 / steps as f64);
        }
        line.circulations()
    };
    let [coarse, middle, fine] = [40, 80, 160].map(heave);
    let (first, second) = (worst(&coarse, &middle), worst(&middle, &fine));
    println!("W-39 flapping: changes {first:.1e}, {second:.1e}");
    assert!((3.0..5.5).contains(&(first / second)), "{first} {second}");
}

/// W-40. Steps allocate no memory.
#[test]
fn w40_steps_do_not_allocate() {
    let mut line = Line::new(&inset(6.0, 12), |_| 1.0, Profile::THIN, strip_options());
    let before = crate::counting_allocator::allocations();
    line.start(wind(0.1), false);
    for _ in 0..5 {
        line.step(wind(0.1), 0.01);
    }
    assert_eq!(crate::counting_allocator::allocations(), before);
}
