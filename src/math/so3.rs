//! Rotations: cross-product matrices, rotation about an axis, quaternions with continuous sign.

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// Cross-product matrix: `hat(a) b = a × b`, NOTATION eq. (K1).
#[inline]
pub fn hat(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// Rotation by `angle_rad` about the unit vector `axis`, right hand positive, NOTATION eq. (K6).
#[inline]
pub fn rotation_about(axis: &Vector3<f64>, angle_rad: f64) -> Matrix3<f64> {
    let (sine, cosine) = angle_rad.sin_cos();
    Matrix3::identity() * cosine + hat(axis) * sine + axis * axis.transpose() * (1.0 - cosine)
}

/// Quaternion of a rotation matrix, of the two signs the one nearer to `previous`.
pub fn quaternion_near(rotation: &Matrix3<f64>, previous: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let quaternion = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    if quaternion.coords.dot(&previous.coords) < 0.0 {
        UnitQuaternion::new_unchecked(Quaternion::from(-quaternion.coords))
    } else {
        quaternion
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    /// Design section 1: positive θ about `r_y` turns `r_x` towards `−r_z`.
    #[test]
    fn positive_fold_turns_x_towards_minus_z() {
        let turned = rotation_about(&Vector3::y(), FRAC_PI_2) * Vector3::x();
        assert!((turned + Vector3::z()).norm() < 1e-15);
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
