//! Momentum balances of annuli, their losses and limits.

use super::*;

/// A thin section: lift 2π sin α, and the drag of a flat plate.
fn plate(drag: f64) -> Polar {
    let rows = (-180..=180).map(|degree| {
        let angle_rad = f64::from(degree).to_radians();
        let lift = std::f64::consts::TAU * angle_rad.sin() * angle_rad.cos();
        PolarRow { angle_rad, lift, drag: drag + 1.5 * angle_rad.sin().powi(2), moment: 0.0 }
    });
    Polar { rows: rows.collect() }
}

fn annulus() -> Annulus {
    Annulus::new(3, 2.0, 30.0, 1.5, 63.0)
}

/// Thrust and torque of the element minus the momentum rates of its annulus, formulated with velocities.
fn imbalance(annulus: &Annulus, polar: &Polar, approach: &Approach, state: &Annular) -> [f64; 2] {
    let axial = approach.axial_m_s - state.axial_loss_m_s;
    let tangential = approach.tangential_m_s + state.swirl_m_s;
    let section = SectionState::of(axial, tangential, approach.chord_angle_rad, polar);
    let [normal, drive] = section.force_m3_s2(1.0);
    let loss = annulus.loss(section.flow_angle_rad.sin());
    // σ cn W²/2 = 2 F |u| u_i and σ ct W²/2 = 2 F |u| v_i
    let flux = 2.0 * loss * axial.abs();
    [annulus.solidity * normal - flux * state.axial_loss_m_s, annulus.solidity * drive - flux * state.swirl_m_s]
}

#[test]
fn momentum_balances_in_every_quadrant() {
    let (annulus, polar) = (annulus(), plate(0.01));
    let mut met = [0; 2];
    for (axial_m_s, tangential_m_s) in
        [(8.0, 40.0), (-8.0, 40.0), (8.0, -40.0), (-8.0, -40.0), (30.0, 3.0), (0.0, 40.0), (12.0, 0.0), (0.5, 60.0)]
    {
        for degree in -180..180 {
            let chord_angle_rad = f64::from(degree).to_radians();
            let approach = Approach { axial_m_s, tangential_m_s, chord_angle_rad };
            let state = balance(&annulus, &polar, &approach);
            let a = state.axial_loss_m_s / axial_m_s;
            met[usize::from(state.balanced)] += 1;
            let scale = axial_m_s.hypot(tangential_m_s).powi(2);
            let heavy = a > 0.4 && a < 1.0; // heavily loaded: Buhl's relation, checked below
            if state.balanced && !heavy {
                let [axial, swirl] = imbalance(&annulus, &polar, &approach, &state);
                assert!(
                    axial.abs() < 1e-9 * scale && swirl.abs() < 1e-9 * scale,
                    "{approach:?} {state:?} {axial} {swirl}"
                );
            }
        }
    }
    assert!(met[0] * 50 < met[1], "balanced in {met:?}");
}

/// Buhl's relation between thrust and induction, eq. (18) of the paper, for any loss.
#[test]
fn heavy_loading_follows_buhl_and_joins_momentum_theory() {
    for loss in [1.0, 0.7, 0.3, 0.05] {
        let mut last = 1.0 + 2.0 / 3.0;
        for step in 0..2000 {
            let k = 2.0 / 3.0 * (1.0 + 1e-9 + 0.01 * f64::from(step));
            let slowing = windmill(k, loss, k > HEAVY);
            let a = 1.0 - 1.0 / slowing;
            let thrust = 8.0 / 9.0 + (4.0 * loss - 40.0 / 9.0) * a + (50.0 / 9.0 - 4.0 * loss) * a * a;
            approx::assert_relative_eq!(4.0 * loss * k * (1.0 - a).powi(2), thrust, max_relative = 1e-9);
            assert!(slowing >= last - 1e-9 && slowing - last < 0.1, "{loss} {k}: {last} {slowing}");
            last = slowing;
        }
    }
}

#[test]
fn nothing_moves_nothing_acts() {
    let still = Approach { axial_m_s: 0.0, tangential_m_s: 0.0, chord_angle_rad: 0.3 };
    assert_eq!(balance(&annulus(), &plate(0.01), &still), Annular::FREE);
    assert_eq!(SectionState::of(0.0, 0.0, 0.3, &plate(0.01)).force_m3_s2(2.0), [0.0, 0.0]);
}

/// Eq. (B23): axial induction factors from −1 to 1.5 and tangential ones from −1 to 1, for inflow from either side.
#[test]
fn aerodyn_limits_its_induction() {
    for axial_m_s in [10.0, -10.0] {
        for tangential_m_s in [50.0, -50.0] {
            let limited = |axial: f64, tangential: f64| {
                let approach = Approach { axial_m_s, tangential_m_s, chord_angle_rad: 0.0 };
                let [loss_m_s, swirl_m_s] =
                    aerodyn_limited([axial * axial_m_s, tangential * tangential_m_s], &approach, &mut Pieces::Free);
                [loss_m_s / axial_m_s, swirl_m_s / tangential_m_s]
            };
            assert_eq!(limited(3.0, 3.0), [1.5, 1.0]);
            assert_eq!(limited(-3.0, -3.0), [-1.0, -1.0]);
            assert_eq!(limited(0.5, -0.5), [0.5, -0.5]);
        }
    }
}

/// Inflow from behind on a symmetric section at the opposite angle gives the mirror image.
#[test]
fn mirrored_inflow_has_mirrored_induction() {
    let (annulus, polar) = (annulus(), plate(0.01));
    let to = |axial_m_s, tangential_m_s, chord_angle_rad| {
        let approach = Approach { axial_m_s, tangential_m_s, chord_angle_rad };
        let state = balance(&annulus, &polar, &approach);
        [state.axial_loss_m_s, state.swirl_m_s]
    };
    let [u, v] = to(8.0, 50.0, 0.05);
    assert!(u > 1.0 && v > 0.05, "{u} {v}");
    let [back_u, back_v] = to(-8.0, 50.0, -0.05);
    approx::assert_relative_eq!(back_u, -u, max_relative = 1e-10);
    approx::assert_relative_eq!(back_v, v, max_relative = 1e-10);
    let [rear_u, rear_v] = to(8.0, -50.0, PI - 0.05);
    approx::assert_relative_eq!(rear_u, u, max_relative = 1e-10);
    approx::assert_relative_eq!(rear_v, -v, max_relative = 1e-10);
}

/// A rotor that turns in still air has the induced velocity of a hovering propeller, `W² σ cn = 4 F u²`.
#[test]
fn still_air_is_hover() {
    let (annulus, polar) = (annulus(), plate(0.01));
    for chord_angle_rad in [0.1, -0.1] {
        let hover = Approach { axial_m_s: 0.0, tangential_m_s: 50.0, chord_angle_rad };
        let state = balance(&annulus, &polar, &hover);
        assert!(state.balanced && state.axial_loss_m_s.abs() > 2.0);
        // the section pitched up accelerates the air opposite to its thrust
        assert_eq!(state.axial_loss_m_s > 0.0, chord_angle_rad < 0.0);
        for nearby_m_s in [1e-9, -1e-9] {
            let near = balance(&annulus, &polar, &Approach { axial_m_s: nearby_m_s, ..hover });
            approx::assert_relative_eq!(near.axial_loss_m_s, state.axial_loss_m_s, max_relative = 1e-6);
        }
    }
}

#[test]
fn loss_is_prandtls_and_complete_at_the_ends() {
    let annulus = annulus();
    let sine = 0.1f64;
    let direct = |exponent: f64| (2.0 / PI) * (-exponent / sine).exp().acos();
    let expected = direct(1.5 * 33.0 / 30.0) * direct(1.5 * 28.5 / 1.5);
    approx::assert_relative_eq!(annulus.loss(sine), expected, max_relative = 1e-12);
    for radius_m in [1.5, 63.0] {
        let end = Annulus::new(3, 2.0, radius_m, 1.5, 63.0);
        assert!(end.is_end() && end.loss(sine) == 0.0);
        let approach = Approach { axial_m_s: 8.0, tangential_m_s: 50.0, chord_angle_rad: 0.0 };
        assert_eq!(balance(&end, &plate(0.0), &approach), Annular::FREE);
    }
}
