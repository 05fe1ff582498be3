//! A folding wing without a model file: built in code, unfolded, and analysed as a linear system.
//!
//! `cargo run --release --example wing`

use foldwing::beam::section::{Material, Solid};
use foldwing::interface::{Interface, Variable};
use foldwing::machine::{Body, Joint, Latch, Machine, Motor};
use foldwing::plant::Plant;
use std::error::Error;
use std::sync::Arc;

fn main() -> Result<(), Box<dyn Error>> {
    let latch_time_s = unfold(wing(0.15)?)?;
    println!("latched at {latch_time_s:.4} s");
    for (frequency_hz, damping_ratio) in latched_modes(wing(0.15)?)? {
        println!("mode at {frequency_hz:7.2} Hz, damping ratio {damping_ratio:.3}");
    }
    Ok(())
}

/// Two plates of the given length in m, joined by a motor with a latch, folded by 170°.
pub fn wing(length_m: f64) -> Result<Arc<Machine>, Box<dyn Error>> {
    let plate = Solid::rectangle(0.05, 0.002, Material::isotropic(2.83e9, 0.3, 1425.0));
    let half = |name| Body::beam(name, length_m, plate).elements(2).mass_damping_1_s(2.5);
    let motor = Motor { stiffness_n_m_rad: 0.026, constant_torque_n_m: 0.043, ..Motor::default() };
    let fold = Joint::revolute("fold", [0.0, 1.0, 0.0]).on("inner").start_angle_rad(170f64.to_radians());
    let machine = Machine::builder("Wing")
        .gravity_m_s2([-9.8, 0.0, 0.0])
        .body(half("inner"), Joint::clamped("mount"))
        .body(half("outer"), fold.motor(motor).latch(Latch::with_ratio(1e4)))
        .build()?;
    Ok(Arc::new(machine))
}

/// Time in s at which the latch of the only joint closes.
pub fn unfold(machine: Arc<Machine>) -> Result<f64, Box<dyn Error>> {
    let mut plant = Plant::new(machine);
    plant.initialize(0.0)?;
    for millisecond in 1..=400 {
        plant.step(f64::from(millisecond) * 1e-3)?;
        if plant.outputs().latches()[0].closed.is_on() {
            return Ok(plant.outputs().latches()[0].time_s);
        }
    }
    Err("the latch did not close within 0.4 s".into())
}

/// Natural frequency in Hz and damping ratio of the four slowest oscillations of the deployed wing about its static
/// equilibrium.
pub fn latched_modes(machine: Arc<Machine>) -> Result<Vec<(f64, f64)>, Box<dyn Error>> {
    let table = Interface::new(&machine);
    let mut plant = Plant::new(machine);
    plant.initialize(0.0)?;
    plant.step(20.0)?;
    let inputs: Vec<&Variable> = table.real_inputs().filter(|input| input.name == "fold.external_torque").collect();
    let outputs: Vec<&Variable> = table.real_outputs().filter(|output| output.name == "fold.angle").collect();
    let model = table.linearize(&mut plant, &inputs, &outputs)?;
    let mut modes: Vec<(f64, f64)> = model
        .matrices
        .a
        .complex_eigenvalues()
        .iter()
        .filter(|eigenvalue| eigenvalue.im > 0.0)
        .map(|eigenvalue| (eigenvalue.norm() / std::f64::consts::TAU, -eigenvalue.re / eigenvalue.norm()))
        .collect();
    modes.sort_by(|one, other| one.0.total_cmp(&other.0));
    modes.truncate(4);
    Ok(modes)
}
