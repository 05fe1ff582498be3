//! The constant-strain link in jets: pose, and the effect of its strains on its outer end, NOTATION eqs. (K2)–(K4).

use crate::math::jet::{Jet, Vector, cross, three};
use crate::math::se3::Coefficients;
use crate::math::strain::{STRAINS, STRETCH, TWIST};

/// Pose of a link's outer end in its inner frame.
#[derive(Debug, Clone, Copy)]
pub struct JetPose<J> {
    /// Inner to outer end in m.
    pub arm_m: Vector<J>,
    /// Columns of the rotation, inner ← outer.
    pub rotation: [Vector<J>; 3],
}

/// The effect of the strains on it: columns of its Jacobian per length.
#[derive(Debug, Clone, Copy)]
pub struct JetSlopes<J> {
    /// Columns `V`: turn of the outer end per curvature and length.
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

/// Pose and slopes of the same.
#[inline]
pub fn pose_and_slopes<J: Jet>(length_m: f64, strain: &[J; STRAINS]) -> (JetPose<J>, JetSlopes<J>) {
    let (shared, [b_slope, c_slope]) = Shared::new(length_m, strain);
    let Shared { turn, stretched_m, b, c, .. } = shared;
    let axis = unit::<J>(0);
    let once = shared.once(0);
    let twice = shared.twice(0);
    let slope_m = three(|j| {
        let double = turn[j].times(2.0);
        let (by_b, by_c) = (double * b_slope, double * c_slope);
        let swing = cross(unit::<J>(j), axis);
        three(|i| {
            let mut second = axis[i] * double.times(-1.0);
            if i == j {
                second = second + turn[0];
            }
            if j == 0 {
                second = second + turn[i];
            }
            stretched_m * (by_b * once[i] + b * swing[i] + by_c * twice[i] + c * second)
        })
    });
    let tangent = three(|j| shared.tangent(j));
    (JetPose { arm_m: shared.arm_m(), rotation: shared.rotation() }, JetSlopes { tangent, slope_m })
}

/// Common terms.
struct Shared<J> {
    /// `Θ = ℓ κ`.
    turn: Vector<J>,
    /// `x = Θ·Θ`.
    square: J,
    /// `a = ℓ (1 + εx)`.
    stretched_m: J,
    b: J,
    c: J,
}

impl<J: Jet> Shared<J> {
    /// Terms, and the derivatives of `b` and `c` in `x`.
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

    /// `Θ × e_j`.
    #[inline(always)]
    fn once(&self, j: usize) -> Vector<J> {
        let mut once = [J::ZERO; 3];
        let (next, last) = ((j + 1) % 3, (j + 2) % 3);
        once[next] = self.turn[last];
        once[last] = self.turn[next].times(-1.0);
        once
    }

    /// `Θ × (Θ × e_j) = Θ Θ_j − x e_j`.
    #[inline(always)]
    fn twice(&self, j: usize) -> Vector<J> {
        let mut twice: Vector<J> = three(|i| self.turn[i] * self.turn[j]);
        twice[j] = twice[j] - self.square;
        twice
    }

    /// `e_j + p Θ×e_j + s Θ×(Θ×e_j)`.
    #[inline(always)]
    fn column(&self, j: usize, p: J, s: J) -> Vector<J> {
        let (once, twice, unit) = (self.once(j), self.twice(j), unit::<J>(j));
        three(|i| unit[i] + p * once[i] + s * twice[i])
    }

    #[inline(always)]
    fn tangent(&self, j: usize) -> Vector<J> {
        self.column(j, self.b, self.c)
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
