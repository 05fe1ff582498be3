//! Rotations: cross-product matrices, rotation about an axis, quaternions with continuous sign.

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// Cosine of the angle below which a rotation vector is computed from the quaternion: near 180° the skew part of the matrix loses digits, 1
/// of 16 here.
const NEARLY_HALF_A_TURN: f64 = -0.99;

/// Cross-product matrix: `hat(a) b = a × b`, NOTATION eq. (K1).
#[inline]
pub fn hat(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// Rotation by `angle_rad` about the unit vector `axis`, right-hand positive, NOTATION eq. (K6).
#[inline]
pub fn rotation_about(axis: &Vector3<f64>, angle_rad: f64) -> Matrix3<f64> {
    let (sine, cosine) = angle_rad.sin_cos();
    Matrix3::identity() * cosine + hat(axis) * sine + axis * axis.transpose() * (1.0 - cosine)
}

/// Quaternion of a rotation matrix, with the sign closer to `previous`.
pub fn quaternion_near(rotation: &Matrix3<f64>, previous: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let quaternion = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    if quaternion.coords.dot(&previous.coords) < 0.0 {
        UnitQuaternion::new_unchecked(Quaternion::from(-quaternion.coords))
    } else {
        quaternion
    }
}

/// Rotation vector in rad, of length up to π, accurate to round-off also for small rotations; for 180° either of the two. Valid also if
/// round-off makes the trace exceed 3, for which the arc cosine in nalgebra is undefined.
pub fn rotation_vector(rotation: &Matrix3<f64>) -> Vector3<f64> {
    let skew = Vector3::new(
        rotation[(2, 1)] - rotation[(1, 2)],
        rotation[(0, 2)] - rotation[(2, 0)],
        rotation[(1, 0)] - rotation[(0, 1)],
    ) * 0.5;
    let (sine, cosine) = (skew.norm(), 0.5 * (rotation.trace() - 1.0));
    if cosine < NEARLY_HALF_A_TURN {
        // the skew part is too small to determine the axis
        return UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation)).scaled_axis();
    }
    if sine > 0.0 { skew * (sine.atan2(cosine) / sine) } else { skew }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    /// Design section 1: positive θ about `r_y` rotates `r_x` towards `−r_z`.
    #[test]
    fn positive_fold_turns_x_towards_minus_z() {
        let turned = rotation_about(&Vector3::y(), FRAC_PI_2) * Vector3::x();
        assert!((turned + Vector3::z()).norm() < 1e-15);
    }

    /// Angles so small that their cosine is 1 in double precision, up to angles near 180°.
    #[test]
    fn rotation_vector_is_accurate_for_small_and_large_turns() {
        let axis = Vector3::new(0.6, -0.48, 0.64);
        for angle in [0.0, 1e-12, 1e-8, 1e-3, 1.0, 2.6, 2.7, 3.0, PI - 1e-7] {
            let found = rotation_vector(&rotation_about(&axis, angle));
            // entries of the matrix have a round-off relative to 1; near 180° the sine loses a digit
            assert!((found - axis * angle).norm() < 1e-15_f64.max(4e-15 * angle), "{angle}: {found}");
        }
    }

    /// Exactly 180° about any axis, and a matrix whose trace slightly exceeds 3, as for a product of rotations.
    #[test]
    fn rotation_vector_of_half_a_turn_and_of_round_off() {
        for axis in
            [Vector3::x(), Vector3::y(), Vector3::z(), Vector3::new(0.6, -0.48, 0.64), Vector3::new(0.0, 0.6, -0.8)]
        {
            let half = rotation_vector(&(axis * axis.transpose() * 2.0 - Matrix3::identity()));
            assert!((half.norm() - PI).abs() < 1e-14 && half.cross(&axis).norm() < 1e-14, "{axis}: {half}");
        }
        let above = Matrix3::identity() * (1.0 + f64::EPSILON) + hat(&Vector3::new(1e-12, 0.0, 0.0));
        assert!((rotation_vector(&above) - Vector3::new(1e-12, 0.0, 0.0)).norm() < 1e-20);
    }

    #[test]
    fn quaternion_keeps_its_sign_through_a_full_turn() {
        let mut quaternion = UnitQuaternion::identity();
        for step in 0..=100 {
            let angle = 2.0 * PI * f64::from(step) / 100.0;
            let next = quaternion_near(&rotation_about(&Vector3::y(), angle), &quaternion);
            assert!(next.coords.dot(&quaternion.coords) > 0.99, "sign flips at {angle} rad");
            quaternion = next;
        }
        assert!((quaternion.w + 1.0).abs() < 1e-12, "a full turn ends at −1");
    }
}
