//! A folding joint, and the comparison of gradients of machines that fold.

use super::*;
use crate::machine::builder::JointBuilder;

/// A revolute joint with a latch that closes within the run.
pub fn fold(numbers: Numbers, on: &str) -> JointBuilder {
    let drive = Motor {
        stiffness_n_m_rad: 0.1 * numbers.stiffness,
        damping_n_m_s_rad: 0.1 * numbers.damping,
        constant_torque_n_m: -0.1 * numbers.torque,
        inertia_kg_m2: 1e-4,
        ..Motor::default()
    };
    // a fifth: the differences of runs over a shift of the latch have the truncation of stiff motions
    let latch = Latch::with_stiffness_n_m_rad(numbers.latch_stiffness).angle_rad(0.7 + 0.2 * numbers.latch_angle);
    Joint::revolute("fold", [1.0, 0.1, 0.0])
        .on(on)
        .offset_m([0.01, 0.0, 0.005])
        .motor(drive)
        .start_angle_rad(numbers.start_angle)
        .start_rate_rad_s(10.0 * numbers.start_rate)
        .latch(latch.capture_rad(0.01))
}

/// A hinge with a spring.
pub fn flap() -> JointBuilder {
    Joint::revolute("flap", [0.0, 1.0, 0.0]).spring(Spring { stiffness_n_m_rad: 40.0, ..Spring::default() })
}

/// Spring and damper of a joint with several freedoms.
pub fn hold(numbers: Numbers) -> Motor {
    let (stiffness_n_m_rad, damping_n_m_s_rad) = (2.0 * numbers.stiffness, numbers.damping);
    Motor { stiffness_n_m_rad, damping_n_m_s_rad, ..Motor::default() }
}

/// The numbers without some of them.
pub fn without(names: &[&str]) -> Vec<Place> {
    PLACES.into_iter().filter(|place| !names.contains(&place.0)).collect()
}

/// Forward and adjoint mode agree within `same`, and both with differences of runs; prints the figures of the validation.
pub fn agree(compared: &Compared, same: f64, words: &str) {
    let Compared { forward_and_adjoint, differences, .. } = compared;
    println!("{words}: forward and adjoint {forward_and_adjoint:.1e}, differences {differences:.1e}");
    assert!(*forward_and_adjoint < same, "{words}: {forward_and_adjoint:.1e}");
    assert!(*differences < 1e-6, "{words}: {differences:.1e}");
}
