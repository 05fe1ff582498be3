//! Step-size control.

/// Largest factor by which the step may grow.
pub const MAX_GROWTH: f64 = 3.0;
/// Smallest factor by which a rejected step is cut.
const MIN_SHRINK: f64 = 0.2;
/// Fraction of the tolerance that a new step aims at.
const SAFETY: f64 = 0.9;

/// Factor from one step to the next, from its error divided by the tolerance, for an estimate proportional to `step^order`; NOTATION eq.
/// (T7).
pub fn factor(error_over_tolerance: f64, order: u32) -> f64 {
    let ideal = SAFETY * error_over_tolerance.max(1e-10).powf(-1.0 / f64::from(order));
    ideal.clamp(MIN_SHRINK, MAX_GROWTH)
}

/// Step after a jump of the accelerations: the displacement `½ a h²` due to the jump equals the tolerance.
pub fn after_jump(jump_norm_1_s2: f64, tolerance: f64) -> f64 {
    if jump_norm_1_s2 > 0.0 { (2.0 * tolerance / jump_norm_1_s2).sqrt() } else { f64::INFINITY }
}
