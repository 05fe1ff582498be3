//! Reference for statics under loads that follow the sections: with everything resolved in the section frame the balance is an
//! initial-value problem from the free end inwards, which needs no shooting.
//!
//! `n' = −κ×n − f`, `m' = −κ×m − (1+εx) e_x×n − c`, `(εx, κ) = ε₀ + K_s⁻¹ (n_x, m)`; shear-free, like the model.

use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// A rod and its follower loads.
pub struct Rod {
    /// Length in m.
    pub length_m: f64,
    /// Section stiffness.
    pub stiffness: Matrix4<f64>,
    /// Natural strain.
    pub natural_strain: Vector4<f64>,
    /// Force and moment at the free end, section frame, N and N·m.
    pub tip: [Vector3<f64>; 2],
    /// Force and moment per length as a function of arc length in m, section frame, N/m and N.
    pub spread: fn(f64) -> [Vector3<f64>; 2],
}

/// One section of the solution.
#[derive(Clone, Copy)]
pub struct Section {
    /// Strain `(εx, κ)`.
    pub strain: Vector4<f64>,
}

#[derive(Clone, Copy)]
struct Slice {
    force: Vector3<f64>,
    moment: Vector3<f64>,
    position: Vector3<f64>,
    rotation: Matrix3<f64>,
}

impl Rod {
    fn strain(&self, slice: &Slice) -> Vector4<f64> {
        let resultant = Vector4::new(slice.force.x, slice.moment.x, slice.moment.y, slice.moment.z);
        self.natural_strain + self.stiffness.lu().solve(&resultant).expect("regular stiffness")
    }

    fn slope(&self, s: f64, slice: &Slice) -> Slice {
        let strain = self.strain(slice);
        let kappa = Vector3::new(strain[1], strain[2], strain[3]);
        let along = Vector3::x() * (1.0 + strain[0]);
        let [force, moment] = (self.spread)(s);
        Slice {
            force: -kappa.cross(&slice.force) - force,
            moment: -kappa.cross(&slice.moment) - along.cross(&slice.force) - moment,
            position: slice.rotation * along,
            rotation: slice.rotation * kappa.cross_matrix(),
        }
    }

    /// Sections at the `count + 1` arc lengths `i L / count`, and the pose of the tip in the root section's frame: Runge–Kutta 4, 4000
    /// steps (error 1e-12 of the length).
    pub fn solve(&self, count: usize) -> (Vec<Section>, Vector3<f64>, Matrix3<f64>) {
        let sub = 4000 / count;
        let h = -self.length_m / (count * sub) as f64;
        let plus = |a: &Slice, b: &Slice, h: f64| Slice {
            force: a.force + b.force * h,
            moment: a.moment + b.moment * h,
            position: a.position + b.position * h,
            rotation: a.rotation + b.rotation * h,
        };
        let mut slice = Slice {
            force: self.tip[0],
            moment: self.tip[1],
            position: Vector3::zeros(),
            rotation: Matrix3::identity(),
        };
        let section = |slice: &Slice| Section { strain: self.strain(slice) };
        let mut sections = vec![section(&slice)];
        for i in 0..count * sub {
            let s = self.length_m + h * i as f64;
            let k1 = self.slope(s, &slice);
            let k2 = self.slope(s + 0.5 * h, &plus(&slice, &k1, 0.5 * h));
            let k3 = self.slope(s + 0.5 * h, &plus(&slice, &k2, 0.5 * h));
            let k4 = self.slope(s + h, &plus(&slice, &k3, h));
            for (k, weight) in [(k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)] {
                slice = plus(&slice, &k, h * weight / 6.0);
            }
            if (i + 1) % sub == 0 {
                sections.push(section(&slice));
            }
        }
        sections.reverse();
        let back = slice.rotation.transpose();
        (sections, -(back * slice.position), back)
    }
}
