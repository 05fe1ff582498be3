//! Blades on lag hinges at a hub on springs.

use foldwing::config;
use foldwing::machine::Machine;
use nalgebra::{Complex, DMatrix};
use std::f64::consts::TAU;
use std::fmt::Write;

/// A hub on springs in the two directions normal to its shaft, with `blades` rigid blades on lag hinges: the machine of Coleman and
/// Feingold's ground resonance.
pub struct Resonance {
    pub blades: usize,
    /// Blade: mass, inertia about its hinge, distance of its centre of mass from the hinge and of the hinge from the shaft, hinge spring.
    pub mass_kg: f64,
    pub inertia_kg_m2: f64,
    pub arm_m: f64,
    pub hinge_m: f64,
    pub spring_n_m_rad: f64,
    /// Support: mass including the hub, stiffness along y and z.
    pub support_kg: f64,
    pub support_n_m: [f64; 2],
}

impl Resonance {
    /// The rotor with a number of blades.
    pub fn of(blades: usize) -> Self {
        Self {
            blades,
            mass_kg: 50.0,
            inertia_kg_m2: 550.0,
            arm_m: 3.0,
            hinge_m: 0.3,
            spring_n_m_rad: 2000.0,
            support_kg: 600.0,
            support_n_m: [2e5, 2e5],
        }
    }

    /// Its model file.
    pub fn text(&self) -> String {
        let [along_y, along_z] = self.support_n_m;
        let mut text = format!(
            "name = \"resonance\"\ngravity_m_s2 = [0, 0, 0]\n[rigid_body.rail]\n\
             [joint.rail]\ntype = \"prismatic\"\nparent = \"root\"\nchild = \"rail\"\naxis = [0, 1, 0]\nspring = {{ stiffness_N_m = {along_y:?} }}\n\
             [rigid_body.seat]\nmass_kg = {:?}\ninertia_kg_m2 = [10.0, 10.0, 10.0, 0, 0, 0]\n\
             [joint.seat]\ntype = \"prismatic\"\nparent = \"rail\"\nchild = \"seat\"\naxis = [0, 0, 1]\nspring = {{ stiffness_N_m = {along_z:?} }}\n\
             [rigid_body.hub]\nmass_kg = 100.0\ninertia_kg_m2 = [20.0, 20.0, 20.0, 0, 0, 0]\n\
             [joint.shaft]\ntype = \"revolute\"\nparent = \"seat\"\nchild = \"hub\"\naxis = [1, 0, 0]\n",
            self.support_kg - 100.0
        );
        let own = self.inertia_kg_m2 - self.mass_kg * self.arm_m * self.arm_m;
        for k in 0..self.blades {
            let angle = TAU * k as f64 / self.blades as f64;
            let (sine, cosine) = angle.sin_cos();
            write!(
                text,
                "[rigid_body.blade{k}]\nmass_kg = {:?}\ncentre_of_mass_m = [0, {:?}, 0]\ninertia_kg_m2 = [{own:?}, {own:?}, {own:?}, 0, 0, 0]\n\
                 [joint.lag{k}]\ntype = \"revolute\"\nparent = \"hub\"\nchild = \"blade{k}\"\naxis = [1, 0, 0]\n\
                 mount_rotation_deg = [{:?}, 0, 0]\nparent_offset_m = [0, {:?}, {:?}]\nspring = {{ stiffness_N_m_rad = {:?} }}\n",
                self.mass_kg,
                self.arm_m,
                360.0 * k as f64 / self.blades as f64,
                self.hinge_m * cosine,
                self.hinge_m * sine,
                self.spring_n_m_rad
            )
            .expect("text");
        }
        text + "[simulation]\nstop_time_s = 1.0\nstep_s = 0.01\n"
    }

    /// Its machine.
    pub fn machine(&self) -> Machine {
        config::parse(&self.text(), "resonance.toml").unwrap_or_else(|refused| panic!("{refused}"))
    }

    /// Roots `ω` of `(κ − I(ω − Ω)²)(K − Mω²) − B/2 S²ω⁴ = 0`, `κ = k + S e Ω²`: motions `e^{iωt}` of hub and blades as complex numbers in
    /// the rotor plane; negative roots are backward whirl.
    pub fn closed_form(&self, speed_rad_s: f64) -> Vec<Complex<f64>> {
        let (i, s, w) = (self.inertia_kg_m2, self.mass_kg * self.arm_m, speed_rad_s);
        let mass = self.support_kg + self.blades as f64 * self.mass_kg;
        let (stiffness, hinge) = (self.support_n_m[0], self.spring_n_m_rad + s * self.hinge_m * w * w);
        let blade = [hinge - i * w * w, 2.0 * i * w, -i];
        let c = [
            blade[0] * stiffness,
            blade[1] * stiffness,
            blade[2] * stiffness - blade[0] * mass,
            -blade[1] * mass,
            -blade[2] * mass - 0.5 * self.blades as f64 * s * s,
        ];
        let companion = DMatrix::from_fn(4, 4, |row, column| match (row, column) {
            (row, 3) => -c[row] / c[4],
            (row, column) if row == column + 1 => 1.0,
            _ => 0.0,
        });
        companion.complex_eigenvalues().iter().copied().collect()
    }
}
