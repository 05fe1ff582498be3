//! Model files of the cases.

use foldwing::config;
use foldwing::machine::Machine;
use foldwing::plant::{Holding, Plant, StaticEffort};
use std::sync::Arc;

/// A machine of a model text.
pub fn machine(text: &str) -> Machine {
    config::parse(text, "case.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// A plant of a model text.
pub fn plant(text: &str) -> Plant {
    Plant::new(Arc::new(machine(text)))
}

/// A plant of a model text in equilibrium under its loads.
pub fn at_rest(text: &str) -> (Plant, StaticEffort) {
    let mut plant = plant(text);
    let effort = plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    (plant, effort)
}

/// A cantilever along `x` with one load station at its tip.
pub struct Cantilever {
    /// Length in m.
    pub length_m: f64,
    /// `EA` (N), `GJ`, `EI_y`, `EI_z` (N·m²).
    pub stiffness: [f64; 4],
    /// Mass per length in kg/m and second moments about `y` and `z` (kg·m); one of them must not vanish.
    pub inertia: [f64; 3],
    /// `"constant"` or `"linear"`.
    pub element: &'static str,
    /// Number of elements.
    pub elements: usize,
    /// `"root"` or `"section"`.
    pub load_frame: &'static str,
    /// Force and moment at the tip, N and N·m.
    pub tip: [[f64; 3]; 2],
    /// Natural curvature in 1/m.
    pub natural_curvature: [f64; 3],
    /// Gravity in m/s².
    pub gravity: [f64; 3],
    /// Lines added to the body.
    pub body: &'static str,
    /// Joint lines; clamped if empty.
    pub joint: &'static str,
}

impl Default for Cantilever {
    fn default() -> Self {
        Self {
            length_m: 1.0,
            stiffness: [1e9, 1.0, 1.0, 1.0],
            inertia: [1.0, 0.0, 1e-8],
            element: "linear",
            elements: 8,
            load_frame: "root",
            tip: [[0.0; 3]; 2],
            natural_curvature: [0.0; 3],
            gravity: [0.0; 3],
            body: "",
            joint: "",
        }
    }
}

impl Cantilever {
    /// The model file.
    pub fn text(&self) -> String {
        let [ea, gj, ei_y, ei_z] = self.stiffness;
        let [mass, about_y, about_z] = self.inertia;
        format!(
            "name = 'C'\ngravity_m_s2 = {:?}\n\
             [section.s]\nshape = 'explicit'\naxial_stiffness_N = {ea:?}\ntorsional_rigidity_N_m2 = {gj:?}\n\
             flap_stiffness_N_m2 = {ei_y:?}\nedge_stiffness_N_m2 = {ei_z:?}\nmass_kg_m = {mass:?}\n\
             second_moments_kg_m = [{about_z:?}, 0.0, {about_y:?}]\n\
             [body.beam]\nlength_m = {:?}\nsection = 's'\nelement = '{}'\nelements = {}\n\
             natural_curvature_1_m = {:?}\nload_frame = '{}'\nload_station_positions_m = [{:?}]\n{}\n\
             [joint.mount]\nparent = 'root'\nchild = 'beam'\n{}\n\
             [load.tip]\nbody = 'beam'\nstation = 1\nforce_N = {:?}\nmoment_N_m = {:?}\n",
            self.gravity,
            self.length_m,
            self.element,
            self.elements,
            self.natural_curvature,
            self.load_frame,
            self.length_m,
            self.body,
            if self.joint.is_empty() { "type = 'clamped'" } else { self.joint },
            self.tip[0],
            self.tip[1],
        )
    }
}

/// Asserts that the order between the last two of the errors on meshes refined by a factor of 2 is at least `least` and less than `most`.
#[track_caller]
pub fn assert_order(what: &str, errors: &[f64], least: f64, most: f64) {
    let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    let list: Vec<String> = errors.iter().map(|error| format!("{error:.2e}")).collect();
    println!("{what}: errors {list:?}, orders {orders:.2?}");
    let last = orders[orders.len() - 1];
    assert!((least..=most).contains(&last), "{what}: order {last:.2} outside {least}..{most}, errors {list:?}");
}
