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

/// Pose of a link of `length_m` with strains `(εx, κx, κy, κz)`, and with shear `(γy, γz)`.
#[inline]
pub fn pose<const N: usize, J: Jet>(length_m: f64, strain: &[J; N]) -> JetPose<J> {
    let (shared, _) = Shared::new(length_m, &std::array::from_fn(|i| strain[i]));
    let mut arm_m = shared.arm_m();
    if N == SHEARED {
        for (axis, shear) in [(1, strain[SHEAR_Y]), (2, strain[SHEAR_Z])] {
            let (across_m, direction) = (shear.times(length_m), shared.tangent(axis));
            arm_m = plus(arm_m, direction.map(|entry| entry * across_m));
        }
    }
    JetPose { arm_m, rotation: shared.rotation() }
}

/// Columns of the link's Jacobian per length. Products that several entries have in common are formed once.
#[inline(always)]
pub fn slopes<J: Jet>(length_m: f64, strain: &[J; STRAINS]) -> JetSlopes<J> {
    let (Shared { turn, square, stretched_m, b, c }, [b_slope, c_slope]) = Shared::new(length_m, strain);
    // V = I + b [Θ]× + c (Θ Θᵀ − x I)
    let (b_turn, c_turn) = (three(|i| b * turn[i]), three(|i| c * turn[i]));
    let [xy, yz, zx] = [c_turn[0] * turn[1], c_turn[1] * turn[2], c_turn[2] * turn[0]];
    let diagonal = J::constant(1.0) - c * square;
    let along = three(|i| diagonal + c_turn[i] * turn[i]);
    let tangent = [
        [along[0], xy + b_turn[2], zx - b_turn[1]],
        [xy - b_turn[2], along[1], yz + b_turn[0]],
        [zx + b_turn[1], yz - b_turn[0], along[2]],
    ];
    // derivatives of b and c: those of b Θ × e_x + c Θ × (Θ × e_x) in the direction of x, times a
    let once = [b_slope * turn[2], b_slope * turn[1]];
    let twice = [turn[0] * turn[0] - square, turn[1] * turn[0], turn[2] * turn[0]].map(|twice| c_slope * twice);
    let spread = [twice[0], twice[1] + once[0], twice[2] - once[1]].map(|entry| stretched_m * entry);
    let mut slope_m = three(|j| {
        let double = turn[j].times(2.0);
        three(|i| double * spread[i])
    });
    // derivatives of Θ × e_x and Θ × (Θ × e_x); that of Θ Θ_x − x e_x by Θ_x is (0, Θ_y, Θ_z)
    let (a_b, [a_x, a_y, a_z]) = (stretched_m * b, c_turn.map(|turn| stretched_m * turn));
    let [by_x, by_y, by_z] = &mut slope_m;
    by_x[1] = by_x[1] + a_y;
    by_x[2] = by_x[2] + a_z;
    by_y[0] = by_y[0] - a_y.times(2.0);
    by_y[1] = by_y[1] + a_x;
    by_y[2] = by_y[2] - a_b;
    by_z[0] = by_z[0] - a_z.times(2.0);
    by_z[1] = by_z[1] + a_b;
    by_z[2] = by_z[2] + a_x;
    JetSlopes { tangent, slope_m }
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
        let (k, [b3, c3]) = Coefficients::with_third(square.value());
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
