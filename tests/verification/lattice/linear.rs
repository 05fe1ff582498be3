//! U-54 to U-56: the linear lattice of a long rigid wing against Wagner, Theodorsen and Küssner.

use crate::lattice::wing::{DENSITY_KG_M3, SPEED_M_S, Wing, inset, options, pressure_pa};
use crate::strips::theory::{Aerofoil, kuessner, theodorsen, wagner};
use crate::whole::is_whole;
use foldwing::aero::flow::Flow;
use foldwing::aero::lattice::LatticeOptions;
use foldwing::aero::lattice_linear::{LatticeSlopes, NoLinearLattice, SECTION_PARTS};
use nalgebra::{Complex, DMatrix, DVector, Vector3};
use std::f64::consts::TAU;

/// Aspect ratio of the wing, its strips, and the section in the middle that carries the load of one strip width: as in [`super::unsteady`].
const PLANE: f64 = 1e4;
const PLANE_STRIPS: usize = 5;
const MIDDLE: usize = 2;
/// Rows of a section's force along `z` and moment about `x` among its loads.
const LIFT: usize = 6 * MIDDLE + 2;
const MOMENT: usize = 6 * MIDDLE + 3;

/// The linear lattice of the plane wing, and the width of a strip in m.
struct Plane {
    slopes: LatticeSlopes,
    width_m: f64,
    step_s: f64,
}

fn flow() -> Flow<'static> {
    Flow {
        time_s: 0.0,
        density_kg_m3: DENSITY_KG_M3,
        wind_m_s: Vector3::y() * -SPEED_M_S,
        spin_rad_s: Vector3::zeros(),
        gusts: &[],
    }
}

impl Plane {
    fn new(chord_panels: usize, wake_rows: usize, step_s: f64) -> Self {
        let places_m = inset(PLANE, PLANE_STRIPS);
        let mut wing = Wing::new(&places_m, |_| 1.0, chord_panels, LatticeOptions { wake_rows, ..options() });
        let slopes = wing.lattice.linear(&wing.motions, &flow(), step_s, true, &wing.from).expect("a linear lattice");
        Self { slopes, width_m: places_m[1] - places_m[0], step_s }
    }

    /// Lift divided by its steady plane value for an upwash of a hundredth of the wind; circulatory loads at the ends of steps; the
    /// impulsive part is a mean over a step, and is averaged with that of the next step to give the value at its end.
    fn history(&self, steps: usize, given: impl Fn(usize) -> DVector<f64>) -> Vec<f64> {
        let slopes = &self.slopes;
        let strips = slopes.trailing.len();
        let scale_n = pressure_pa() * self.width_m * TAU / SPEED_M_S;
        let mut wake = DVector::zeros(slopes.wake.ncols());
        let mut before: Option<DVector<f64>> = None;
        let mut parts = Vec::new();
        for step in 0..=steps {
            if let Some(before) = &before {
                let moved = wake.rows(0, wake.len() - strips).into_owned();
                wake.rows_mut(strips, moved.len()).copy_from(&moved);
                slopes.trailing.iter().enumerate().for_each(|(strip, panel)| wake[strip] = before[*panel]);
            }
            let answer = given(step) + &slopes.wake * &wake;
            let circulation = answer.rows(0, slopes.panels).into_owned();
            if let Some(before) = &before {
                let rate = (&circulation - before) / self.step_s;
                parts.push([answer[slopes.panels + LIFT] / scale_n, (slopes.impulse.row(LIFT) * rate)[0] / scale_n]);
            }
            before = Some(circulation);
        }
        parts.windows(2).map(|pair| pair[0][0] + 0.5 * (pair[0][1] + pair[1][1])).collect()
    }

    /// Lift and moment per span of the middle strip in harmonic motion of all sections, for the amplitudes of heave (m, down) and pitch
    /// (rad, nose-up) about the quarter chord.
    fn harmonic(&self, k: f64, heave_m: f64, pitch_rad: f64) -> [Complex<f64>; 2] {
        let slopes = &self.slopes;
        let omega = Complex::new(0.0, k * SPEED_M_S / 0.5);
        let z = (omega * self.step_s).exp();
        let mut motion = DVector::from_element(slopes.section.ncols(), Complex::new(0.0, 0.0));
        for section in 0..slopes.sections {
            let first = SECTION_PARTS * section;
            motion[first + 2] = Complex::from(-heave_m);
            motion[first + 3] = Complex::from(pitch_rad);
            motion[first + 8] = -omega * heave_m;
            motion[first + 9] = omega * pitch_rad;
        }
        let given = slopes.section.map(Complex::from) * motion;
        let strips = slopes.trailing.len();
        let mut wake = DMatrix::from_element(slopes.rows(), strips, Complex::new(0.0, 0.0));
        for row in 0..slopes.wake_rows {
            let delay = z.powi(-(row as i32) - 1);
            wake += slopes.wake.columns(row * strips, strips).map(|entry| delay * entry);
        }
        let one = DMatrix::<Complex<f64>>::identity(strips, strips);
        let shed = (one - wake.select_rows(&slopes.trailing)).lu().solve(&given.select_rows(&slopes.trailing));
        let answer = given + wake * shed.expect("regular");
        // the impulsive loads belong to the middle of the step
        let rate = (z - 1.0) / self.step_s / (omega * (0.5 * self.step_s)).exp();
        [LIFT, MOMENT].map(|row| {
            let impulse: Complex<f64> =
                (0..slopes.panels).map(|panel| answer[panel] * slopes.impulse[(row, panel)] * rate).sum();
            (answer[slopes.panels + row] + impulse) / self.width_m
        })
    }
}

/// U-54. A step of the upwash, as in a sudden start, against Wagner from half a chord to 5 chords of travel: first order in panels; the
/// limits are those of U-10.
#[test]
fn u54_linear_lattice_follows_wagner() {
    for way_panels in [1.0, 0.25] {
        let errors = [4, 8, 16].map(|panels| {
            let step_s = way_panels / panels as f64 / SPEED_M_S;
            let steps = (5.0 / (SPEED_M_S * step_s)).ceil() as usize + 1;
            let plane = Plane::new(panels, steps + 2, step_s);
            let upwash: DVector<f64> = plane.slopes.air.column(2).into_owned();
            let lift = plane.history(steps, |_| upwash.clone());
            let off = lift.iter().enumerate().map(|(i, lift)| (2.0 * SPEED_M_S * step_s * (i + 1) as f64, lift));
            let off = off.filter(|(s, _)| *s >= 1.0).map(|(s, lift)| (lift - wagner(s)).abs());
            off.fold(0.0, f64::max)
        });
        println!("U-54 way {way_panels} panels: {errors:.4?} with 4, 8, 16 panels");
        assert!(errors[0] > 1.4 * errors[1] && errors[1] > 1.4 * errors[2], "no convergence: {errors:?}");
        assert!(errors[2] < 0.02, "{errors:?}");
    }
}

/// U-55. Harmonic heave and pitch against Theodorsen, without simulation in time: complex error of the lift relative to the theoretical
/// lift, and of the moment relative to lift times semi-chord; as functions of the number of panels, with a wake of 40 chords, and of the
/// wake length. Limits of U-12.
#[test]
fn u55_linear_lattice_follows_theodorsen() {
    let aerofoil = Aerofoil { density_kg_m3: DENSITY_KG_M3, speed_m_s: SPEED_M_S, semi_chord_m: 0.5, axis: -0.5 };
    let error = |plane: &Plane, k: f64, heave_m: f64, pitch_rad: f64| {
        let theory = aerofoil.response(theodorsen(k), k, heave_m.into(), pitch_rad.into());
        let [lift, moment] = plane.harmonic(k, heave_m, pitch_rad);
        let size = theory.lift_n_m().norm();
        [(lift - theory.lift_n_m()).norm() / size, (moment - theory.moment_n()).norm() / (0.5 * size)]
    };
    let plane = |panels: usize, chords: usize| Plane::new(panels, 2 * panels * chords, 0.5 / panels as f64 / SPEED_M_S);
    let panels: &[usize] = if is_whole() { &[4, 8, 16] } else { &[4, 8] };
    let planes: Vec<Plane> = panels.iter().map(|panels| plane(*panels, 40)).collect();
    for (name, heave_m, pitch_rad) in [("heave", 1.0, 0.0), ("pitch", 0.0, 1.0)] {
        for k in [1.0, 0.5, 0.2] {
            let errors: Vec<[f64; 2]> = planes.iter().map(|plane| error(plane, k, heave_m, pitch_rad)).collect();
            println!("U-55 {name} k {k}, {panels:?} panels: lift and moment {errors:.4?}");
            assert!(errors[0][0] > 1.4 * errors[1][0] && errors[0][1] > 1.4 * errors[1][1], "{name} {k}: {errors:?}");
            assert!(errors[1][0] < 0.03 && errors[1][1] < 0.06, "{name} {k}: {errors:?}");
        }
    }
    let errors = [2, 5, 10, 20, 40].map(|chords| error(&plane(4, chords), 0.2, 1.0, 0.0)[0]);
    println!("U-55 heave k 0.2, 4 panels, wake of 2, 5, 10, 20, 40 chords: lift {errors:.4?}");
    assert!(errors[4] < errors[0], "{errors:?}");
}

/// U-56. A sharp-edged gust carried by the wind, against Küssner: as an input sampled per step, the gust rises over the distance travelled
/// in one step. The middle of this rise counts as the edge.
#[test]
fn u56_linear_lattice_follows_kuessner() {
    let errors = [4, 8, 16].map(|panels| {
        let step_s = 0.5 / panels as f64 / SPEED_M_S;
        let steps = (5.0 / (SPEED_M_S * step_s)).ceil() as usize + 1;
        let plane = Plane::new(panels, steps + 2, step_s);
        let places = plane.slopes.gust_places();
        let lift = plane.history(steps, |step| {
            let entered = (0..places.min(step)).map(|place| plane.slopes.gust.column(3 * place + 2).into_owned());
            entered.fold(DVector::zeros(plane.slopes.rows()), |sum, column| sum + column)
        });
        // the middle of the rise reaches the foremost line half a step after the start, and the leading edge a quarter of a panel before
        let behind = |i: usize| 2.0 * (SPEED_M_S * step_s * (i as f64 + 0.5) + 0.25 / panels as f64);
        [0.0, 3.0].map(|from| {
            let off = lift.iter().enumerate().filter(|(i, _)| behind(*i) >= from);
            off.map(|(i, lift)| (lift - kuessner(behind(i))).abs()).fold(0.0, f64::max)
        })
    });
    println!("U-56 4, 8, 16 panels, from the edge on and from 3 semi-chords on: {errors:.4?}");
    // limits of U-11
    for (part, limit) in [(0, 0.05), (1, 0.02)] {
        assert!(errors[0][part] > errors[1][part] && errors[1][part] > errors[2][part], "{errors:?}");
        assert!(errors[2][part] < limit, "{errors:?}");
    }
}

/// A lattice without a steady straight wake is rejected: free wake, rotating root, wind that does not carry the wake away.
#[test]
fn flows_without_straight_wake_are_refused() {
    use foldwing::aero::lattice::WakeModel;
    let places_m = inset(4.0, 4);
    let linear = |change: &dyn Fn(&mut LatticeOptions), flow: &Flow, step_s: f64| {
        let mut own = LatticeOptions { wake_rows: 8, ..options() };
        change(&mut own);
        let mut wing = Wing::new(&places_m, |_| 1.0, 2, own);
        wing.lattice.linear(&wing.motions, flow, step_s, false, &wing.from).map(|slopes| slopes.wake_rows)
    };
    let still = Flow { wind_m_s: Vector3::zeros(), ..flow() };
    let turning = Flow { spin_rad_s: Vector3::z(), ..flow() };
    assert_eq!(linear(&|_| {}, &flow(), 0.05), Ok(8));
    assert_eq!(linear(&|own| own.wake = WakeModel::Free, &flow(), 0.05), Err(NoLinearLattice::FreeWake));
    assert_eq!(linear(&|own| own.wake_rows = 0, &flow(), 0.05), Err(NoLinearLattice::NoWake));
    assert_eq!(linear(&|_| {}, &turning, 0.05), Err(NoLinearLattice::Turning(1.0)));
    assert!(matches!(linear(&|_| {}, &still, 0.05), Err(NoLinearLattice::Slow { .. })));
    assert!(matches!(linear(&|_| {}, &flow(), 1e-3), Err(NoLinearLattice::Slow { .. })));
}
