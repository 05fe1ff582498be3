//! The constant-strain link in jets: pose, and the effect of its strains on its outer end, NOTATION eqs. (K2)–(K4).

use crate::math::jet::{Jet, Vector, cross, plus, three};
use crate::math::se3::Coefficients;
use crate::math::strain::{SHEAR_Y, SHEAR_Z, SHEARED, STRAINS, STRETCH, TWIST};

/// Pose of a link's outer end in its inner frame.
#[derive(Debug, Clone, Copy)]
pub struct JetPose<J> {
    /// Vector from the inner to the outer end in m.
    pub arm_m: Vector<J>,
    /// Columns of the rotation matrix, inner ← outer.
    pub rotation: [Vector<J>; 3],
}

/// Effect of the strains on the pose: columns of the Jacobian per length.
#[derive(Debug, Clone, Copy)]
pub struct JetSlopes<J> {
    /// Columns of `V`: rotation of the outer end per curvature and length.
    pub tangent: [Vector<J>; 3],
    /// Columns `a ∂u/∂Θ` in m: displacement of the outer end per curvature and length.
    pub slope_m: [Vector<J>; 3],
}

/// A unit vector of constants.
#[inline(always)]
fn unit<J: Jet>(axis: usize) -> Vector<J> {
    three(|i| J::constant(if i == axis { 1.0 } else { 0.0 }))
}

/// Pose of a link of `length_m` with strains `(εx, κx, κy, κz)`.
#[inline]
pub fn pose<J: Jet>(length_m: f64, strain: &[J; STRAINS]) -> JetPose<J> {
    let (shared, _) = Shared::new(length_m, strain);
    JetPose { arm_m: shared.arm_m(), rotation: shared.rotation() }
}

/// Columns of the link's Jacobian per length.
#[inline]
pub fn slopes<J: Jet>(length_m: f64, strain: &[J; STRAINS]) -> JetSlopes<J> {
    let (shared, slopes) = Shared::new(length_m, strain);
    JetSlopes {
        tangent: [shared.tangent(0), shared.tangent(1), shared.tangent(2)],
        slope_m: [shared.slope_m(0, &slopes), shared.slope_m(1, &slopes), shared.slope_m(2, &slopes)],
    }
}

/// Columns of the Jacobian per length of a link with shear, of `(εx, κx, κy, κz, γy, γz)`, NOTATION eq. (K11): those of the linear strains are
/// the columns of `V`.
#[inline]
pub fn sheared_slopes<J: Jet>(length_m: f64, strain: &[J; SHEARED]) -> JetSlopes<J> {
    let plain: [J; STRAINS] = std::array::from_fn(|i| strain[i]);
    let (shared, [b_slope, c_slope]) = Shared::new(length_m, &plain);
    let across: Vector<J> = [shared.stretched_m, strain[SHEAR_Y].times(length_m), strain[SHEAR_Z].times(length_m)];
    let turn = shared.turn;
    let once = cross(turn, across);
    let twice = cross(turn, once);
    let slope_m = three(|j| {
        let unit = unit::<J>(j);
        let double = turn[j].times(2.0);
        let (by_b, by_c) = (double * b_slope, double * c_slope);
        let by_once = cross(unit, across);
        let by_twice = plus(cross(unit, once), cross(turn, by_once));
        three(|i| by_b * once[i] + by_c * twice[i] + shared.b * by_once[i] + shared.c * by_twice[i])
    });
    JetSlopes { tangent: [shared.tangent(0), shared.tangent(1), shared.tangent(2)], slope_m }
}

/// Terms shared by pose and Jacobian.
struct Shared<J> {
    /// Rotation vector `Θ = ℓ κ`.
    turn: Vector<J>,
    /// Squared angle `x = Θ·Θ`.
    square: J,
    /// Stretched length `a = ℓ (1 + εx)`.
    stretched_m: J,
    b: J,
    c: J,
}

impl<J: Jet> Shared<J> {
    /// Computes the terms, and the derivatives of `b` and `c` with respect to `x`.
    #[inline(always)]
    fn new(length_m: f64, strain: &[J; STRAINS]) -> (Self, [J; 2]) {
        let turn: Vector<J> = three(|i| strain[TWIST + i].times(length_m));
        let square = turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2];
        let k = Coefficients::at(square.value());
        let [b3, c3] = k.third(square.value());
        let shared = Self {
            turn,
            square,
            stretched_m: J::constant(length_m) + strain[STRETCH].times(length_m),
            b: square.composed([k.b, k.b1, k.b2]),
            c: square.composed([k.c, k.c1, k.c2]),
        };
        (shared, [square.composed([k.b1, k.b2, b3]), square.composed([k.c1, k.c2, c3])])
    }

    /// Cross product `Θ × e_j`.
    #[inline(always)]
    fn once(&self, j: usize) -> Vector<J> {
        let mut once = [J::ZERO; 3];
        let (next, last) = ((j + 1) % 3, (j + 2) % 3);
        once[next] = self.turn[last];
        once[last] = self.turn[next].times(-1.0);
        once
    }

    /// Double cross product `Θ × (Θ × e_j) = Θ Θ_j − x e_j`.
    #[inline(always)]
    fn twice(&self, j: usize) -> Vector<J> {
        let mut twice: Vector<J> = three(|i| self.turn[i] * self.turn[j]);
        twice[j] = twice[j] - self.square;
        twice
    }

    /// Vector `e_j + p Θ×e_j + s Θ×(Θ×e_j)`.
    #[inline(always)]
    fn column(&self, j: usize, p: J, s: J) -> Vector<J> {
        let (once, twice, unit) = (self.once(j), self.twice(j), unit::<J>(j));
        three(|i| unit[i] + p * once[i] + s * twice[i])
    }

    #[inline(always)]
    fn tangent(&self, j: usize) -> Vector<J> {
        self.column(j, self.b, self.c)
    }

    /// `a ∂u/∂Θ_j`, eq. (K4): first the terms with the derivatives of `b` and `c`, then the derivatives of `Θ × e_x` and `Θ × (Θ × e_x)`.
    #[inline(always)]
    fn slope_m(&self, j: usize, [b_slope, c_slope]: &[J; 2]) -> Vector<J> {
        let turn = &self.turn;
        let double = turn[j].times(2.0);
        let (by_b, by_c) = (double * *b_slope, double * *c_slope);
        // Θ × e_x = (0, Θ_z, −Θ_y)
        let mut entries = self.twice(0).map(|twice| by_c * twice);
        entries[1] = entries[1] + by_b * turn[2];
        entries[2] = entries[2] - by_b * turn[1];
        match j {
            0 => {
                // e_x × e_x vanishes; the derivative of Θ Θ_x − x e_x is (Θ_x − 2 Θ_x + Θ_x, Θ_y, Θ_z) for j = x
                entries[1] = entries[1] + self.c * turn[1];
                entries[2] = entries[2] + self.c * turn[2];
            }
            1 => {
                entries[2] = entries[2] - self.b;
                entries[0] = entries[0] - self.c * double;
                entries[1] = entries[1] + self.c * turn[0];
            }
            _ => {
                entries[1] = entries[1] + self.b;
                entries[0] = entries[0] - self.c * double;
                entries[2] = entries[2] + self.c * turn[0];
            }
        }
        entries.map(|entry| self.stretched_m * entry)
    }

    #[inline(always)]
    fn rotation(&self) -> [Vector<J>; 3] {
        let sinc = J::constant(1.0) - self.square * self.c;
        three(|j| self.column(j, sinc, self.b))
    }

    #[inline(always)]
    fn arm_m(&self) -> Vector<J> {
        self.tangent(0).map(|direction| self.stretched_m * direction)
    }
}
