//! A body that slides along a beam and rotates on a ball joint.

use crate::plant::machines::*;
use crate::plant::sliding::{crane, crane_with};
use foldwing::machine::Joint;
use foldwing::machine::builder::JointBuilder;

/// SJ-14. A body on a ball joint on a massless carriage slides and rotates freely: in a plane as on a hinge; out of the plane, where the
/// beam bends sideways and twists, the energy account closes across element boundaries.
#[test]
fn sj14_a_ball_on_a_carriage() {
    let at = |joint: JointBuilder| joint.start_position_m(0.35);
    let mut hinged = start(crane(at));
    let mut balled = start(crane_with(Joint::ball("pin"), [4.0, 0.0, -9.0], at));
    let mut apart_m = 0.0f64;
    for step in 1..=36 {
        let end_s = 0.01 * f64::from(step);
        coast(&mut hinged, end_s);
        coast(&mut balled, end_s);
        apart_m = apart_m.max((hinged.outputs().joints()[0].angle_rad - balled.outputs().joints()[0].angle_rad).abs());
        for (one, other) in hinged.outputs().tips().iter().zip(balled.outputs().tips()) {
            apart_m = apart_m.max((one.position_m - other.position_m).norm());
        }
    }
    let (moved_m, events) = (balled.outputs().joints()[0].angle_rad - 0.35, balled.statistics().events);
    println!("SJ-14 ball and hinge apart by {apart_m:.1e} m after {moved_m:.3} m, {events} events");
    // the tolerance is 1e-8
    assert!(apart_m < 1e-6 && moved_m > 0.15 && events >= 1, "{apart_m:e} m");
    let mut aside = start(crane_with(Joint::ball("pin"), [4.0, 5.0, -7.5], at));
    let before_j = balance_j(aside.outputs());
    coast(&mut aside, 0.36);
    let (drift_j, side_m) = (balance_j(aside.outputs()) - before_j, aside.outputs().tips()[0].position_m.y);
    println!("SJ-14 aside by {side_m:.3} m: drift {drift_j:.1e} J of {:.2} J", aside.outputs().energy().kinetic);
    assert!(side_m > 0.05 && aside.statistics().events >= 1 && drift_j.abs() < 5e-6, "{drift_j:e} J");
}
