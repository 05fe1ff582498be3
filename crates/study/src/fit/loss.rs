//! Loss functions, which weight large residuals.

use nalgebra::{DMatrix, DVector};

/// Loss of a residual `r`, as a function of `z = r²`; the search minimises half of their sum, eq. (X14). Robust losses deviate
/// from least squares for residuals above one standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Loss {
    /// `z`.
    #[default]
    Linear,
    /// `2 (√(1 + z) − 1)`.
    SoftL1,
    /// `z` up to 1, beyond `2 √z − 1`.
    Huber,
    /// `ln(1 + z)`.
    Cauchy,
    /// `atan z`.
    Arctan,
}

/// Smallest dimensionless curvature of a loss, for residuals at which a robust loss is concave.
const CURVATURE: f64 = f64::EPSILON;

impl Loss {
    /// All losses and their names.
    pub const ALL: [(Self, &'static str); 5] = [
        (Self::Linear, "linear"),
        (Self::SoftL1, "soft_l1"),
        (Self::Huber, "huber"),
        (Self::Cauchy, "cauchy"),
        (Self::Arctan, "arctan"),
    ];

    /// The loss with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, own)| *own == name).map(|(loss, _)| *loss)
    }

    /// Value, and first and second derivative with respect to `z`.
    pub(super) fn at(self, z: f64) -> [f64; 3] {
        let t = 1.0 + z;
        match self {
            Self::Linear => [z, 1.0, 0.0],
            Self::SoftL1 => [2.0 * (t.sqrt() - 1.0), t.powf(-0.5), -0.5 * t.powf(-1.5)],
            Self::Huber if z <= 1.0 => [z, 1.0, 0.0],
            Self::Huber => [2.0 * z.sqrt() - 1.0, z.powf(-0.5), -0.5 * z.powf(-1.5)],
            Self::Cauchy => [z.ln_1p(), 1.0 / t, -1.0 / (t * t)],
            Self::Arctan => [z.atan(), 1.0 / (1.0 + z * z), -2.0 * z / (1.0 + z * z).powi(2)],
        }
    }

    /// Half of the sum of the losses.
    pub(super) fn cost(self, residuals: &DVector<f64>) -> f64 {
        0.5 * residuals.iter().map(|r| self.at(r * r)[0]).sum::<f64>()
    }

    /// Residuals and Jacobian of the linear problem with the same gradient and Gauss–Newton curvature as the losses, eq.
    /// (X14).
    pub(super) fn weighted(
        self,
        mut residuals: DVector<f64>,
        mut jacobian: DMatrix<f64>,
    ) -> (DVector<f64>, DMatrix<f64>) {
        for (row, r) in residuals.iter_mut().enumerate() {
            let [_, slope, bend] = self.at(*r * *r);
            let curvature = (slope + 2.0 * bend * *r * *r).max(CURVATURE).sqrt();
            *r *= slope / curvature;
            jacobian.row_mut(row).scale_mut(curvature);
        }
        (residuals, jacobian)
    }
}
