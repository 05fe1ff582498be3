//! Effects on the rotor as a whole: motion of its hub, and the tower.

use super::*;
use crate::aero::polar::{Polar, PolarRow};
use crate::aero::rotor::tower::{Potential, Shadow, Tower};
use crate::aero::surface::Profile;
use nalgebra::Rotation3;

const POSITIONS_M: [f64; 3] = [0.0, 4.0, 9.0];

/// Two flat-plate blades of 9 m without drag on a hub with a radius of 1 m.
fn rotor(features: RotorFeatures) -> Rotor {
    let row = |i: i32| {
        let angle_rad = PI * f64::from(i) / 36.0;
        PolarRow { angle_rad, lift: PI * (2.0 * angle_rad).sin(), drag: 0.0, moment: 0.0 }
    };
    let chord = ChordLine { leading_m: Vector3::y() * 0.2, trailing_m: Vector3::y() * -0.6 };
    let surface = |sections: std::ops::Range<usize>| Surface {
        sections,
        chords: vec![chord; 3],
        chord_panels: 1,
        profile: Profile::THIN,
    };
    let options = RotorOptions {
        hub_body: 0,
        shaft_axis: Vector3::x(),
        polars: vec![Polar { rows: (-36..=36).map(row).collect() }],
        sections: vec![vec![0; 3]; 2],
        positions_m: vec![POSITIONS_M.to_vec(); 2],
        lengths_m: vec![9.0; 2],
        sections_turn: vec![true; 2],
        features,
    };
    Rotor::new(&[surface(0..3), surface(3..6)], &options)
}

/// Sections of the two blades, then the hub, rotating at 2 rad/s about `x` and translating along it; the first blade points down.
fn motions(forward_m_s: f64) -> Vec<SectionMotion> {
    let spin_rad_s = Vector3::x() * 2.0;
    let section = |blade: usize, position_m: f64| {
        let sign = if blade == 0 { -1.0 } else { 1.0 };
        // directions along the blade and of its motion; the chord is inclined slightly into the wind
        let (along, ahead) = (Vector3::z() * sign, Vector3::y() * -sign);
        let pitched = (ahead - Vector3::x() * 0.1).normalize();
        let rotation = nalgebra::Matrix3::from_columns(&[along, pitched, along.cross(&pitched)]);
        let place_m = along * (1.0 + position_m);
        let velocity_m_s = spin_rad_s.cross(&place_m) + Vector3::x() * forward_m_s;
        SectionMotion { rotation, position_m: place_m, velocity_m_s, spin_rad_s }
    };
    let hub = SectionMotion {
        rotation: Rotation3::identity().into_inner(),
        position_m: Vector3::zeros(),
        velocity_m_s: Vector3::x() * forward_m_s,
        spin_rad_s,
    };
    let places = (0..2).flat_map(|blade| POSITIONS_M.map(|position_m| (blade, position_m)));
    places.map(|(blade, position_m)| section(blade, position_m)).chain([hub]).collect()
}

fn flow(wind_m_s: f64) -> Flow<'static> {
    let wind_m_s = Vector3::x() * wind_m_s;
    Flow { time_s: 0.0, density_kg_m3: 1.2, wind_m_s, spin_rad_s: Vector3::zeros(), gusts: &[] }
}

/// A rotor that moves against the wind at 3 m/s is equivalent to a fixed one in a wind higher by 3 m/s, for momentum theory with and
/// without a lag: equal loads and induced velocities, to round-off, at the start and after steps.
#[test]
fn a_rotor_that_moves_against_the_wind_stands_in_more_of_it() {
    for inflow_lag_s in [None, Some(0.8)] {
        let features = RotorFeatures { losses: [false; 2], inflow_lag_s, ..RotorFeatures::of(1.0) };
        let run = |wind_m_s: f64, forward_m_s: f64| {
            let (mut rotor, motions, flow) = (rotor(features.clone()), motions(forward_m_s), flow(wind_m_s));
            let (mut state, mut next) = (rotor.blank_state(), rotor.blank_state());
            let mut loads = AirLoads::still(motions.len());
            rotor.start(&motions, &flow, false, &mut state, &mut loads);
            for _ in 0..5 {
                rotor.solve(&state, &motions, &flow, 0.1, &mut next, &mut loads);
                state.copy_from(&next);
            }
            let induced_m_s: Vec<f64> = state.sections.iter().map(|memory| memory.inflow.acting_m_s[0]).collect();
            (state.loads.thrust_n, induced_m_s)
        };
        let (stands, moves) = (run(10.0, 0.0), run(7.0, -3.0));
        assert!(stands.0 > 100.0 && stands.1[1] > 0.1, "{stands:?}");
        assert!((moves.0 / stands.0 - 1.0).abs() < 1e-9, "{inflow_lag_s:?}: {moves:?} {stands:?}");
        for (a, b) in moves.1.iter().zip(&stands.1) {
            assert!((a - b).abs() < 1e-9, "{inflow_lag_s:?}: {moves:?} {stands:?}");
        }
    }
}

/// The mean wind of the rotor, which defines coefficients and time constants of the wake, excludes the tower: the flow around a tower one
/// radius behind a blade reduces the velocity at the sections of this blade, but not the mean wind.
#[test]
fn the_mean_wind_of_the_rotor_knows_no_tower() {
    let tower = Tower {
        base_m: Vector3::new(3.0, 0.0, -20.0),
        up: Vector3::z(),
        rows: vec![[0.0, 3.0, 0.5], [19.0, 3.0, 0.5]],
        potential: Potential::Cylinder,
        shadow: Shadow::None,
    };
    let found = [None, Some(tower)].map(|tower| {
        let features = RotorFeatures { dynamic_inflow: true, tower, ..RotorFeatures::of(1.0) };
        let (mut rotor, motions, flow) = (rotor(features), motions(0.0), flow(8.0));
        let (mut state, mut loads) = (rotor.blank_state(), AirLoads::still(motions.len()));
        rotor.start(&motions, &flow, true, &mut state, &mut loads);
        state.loads
    });
    let [alone, before_tower] = found;
    assert!(before_tower.thrust_n < 0.99 * alone.thrust_n, "{before_tower:?} {alone:?}");
    assert!((alone.wind_m_s - 8.0).abs() < 1e-12, "{alone:?}");
    assert_eq!(before_tower.wind_m_s, alone.wind_m_s);
    assert_eq!(before_tower.tip_speed_ratio, alone.tip_speed_ratio);
}
