//! The NREL 5 MW turbine, mainly without aerodynamics: modal bodies, drive train and yaw, against OpenFAST and against Kane's equations in
//! dense form. Case numbers WT-xx.

mod beside;
mod bodies;
mod kane;
pub mod machine;
mod modes;
mod operating;
mod operation;
mod periodic;
mod recursions;
mod reduced;
mod refusals;
mod resonance;
mod strain;
mod swing;
mod vacuum;
mod whirl;
mod wind;
mod wind_files;
