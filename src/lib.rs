//! Foldwing: simulation of flexible folding wings, and their export as FMUs.
//!
//! A short model file becomes an FMU (FMI 2.0 or 3.0, co-simulation and Model Exchange) of a geometrically nonlinear, strain-based
//! beam multibody wing with fold joints, motors and latches. `docs/ARCHITECTURE.md` maps the modules,
//! `docs/NOTATION.md` numbers the equations that the code cites.
//!
//! A machine can also be built in code: a [`machine::Machine`] by its [builder](machine::Machine::builder), whose errors give
//! location, value and remedy. A [`plant::Plant`] runs it.
//!
//! ```
//! use foldwing::beam::section::{Material, Solid};
//! use foldwing::machine::{Body, Joint, Latch, Machine, Motor};
//! use foldwing::plant::Plant;
//!
//! let plate = Solid::rectangle(0.05, 0.002, Material::isotropic(2.83e9, 0.3, 1425.0));
//! let half = |name| Body::beam(name, 0.15, plate).elements(2).mass_damping_1_s(2.5);
//! let motor = Motor { stiffness_n_m_rad: 0.026, constant_torque_n_m: 0.043, ..Motor::default() };
//! let fold = Joint::revolute("fold", [0.0, 1.0, 0.0]).on("inner").start_angle_rad(2.97);
//! let wing = Machine::builder("FoldingWing")
//!     .gravity_m_s2([-9.8, 0.0, 0.0])
//!     .body(half("inner"), Joint::clamped("mount"))
//!     .body(half("outer"), fold.motor(motor).latch(Latch::with_ratio(1e4)))
//!     .build()?;
//! let mut plant = Plant::new(std::sync::Arc::new(wing));
//! plant.initialize(0.0)?;
//! plant.step(0.2)?;
//! assert!(plant.outputs().latches()[0].closed.is_on());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Studies use several states of a machine: flutter and divergence versus wind speed, trim, operating points, Campbell diagrams and
//! periodic motions of rotors. They are in [`study`], with units in the names of options, numerical results, and errors with fields.
//!
//! ```
//! use foldwing::plant::Plant;
//! use foldwing::study::flutter;
//! use foldwing::study::trim::{self, Target};
//!
//! let text = std::fs::read_to_string("examples/models/goland_wing.toml")?;
//! let wing = std::sync::Arc::new(foldwing::config::parse(&text, "goland_wing.toml")?);
//! let options = flutter::Options { wind_m_s: vec![130.0, 140.0], count: 2 };
//! let found = flutter::sweep(Plant::new(wing.clone()), &options)?;
//! let speed_m_s = found.flutter().next().map(|crossing| crossing.at);
//! assert!((speed_m_s.unwrap() - 137.41).abs() < 0.01);
//!
//! // the gravitational acceleration at which the root carries 10 N
//! let options = trim::Options {
//!     solve_for: vec!["gravity.z".to_owned()],
//!     targets: vec![Target { output: "root.force.z".to_owned(), value: 10.0 }],
//!     ..trim::Options::default()
//! };
//! let trim = trim::solve(Plant::new(wing), &options)?;
//! assert!((trim.balanced[0].value - 10.0).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub use foldwing_engine::{aero, beam, force, load, machine, math, multibody, plant, signal, solve};
pub use foldwing_file as config;

#[cfg(feature = "command")]
pub use foldwing_command::{packaging, report};
#[cfg(feature = "study")]
pub use foldwing_fmi::{fmi2, fmi3, instance, interface};
#[cfg(feature = "import")]
pub use foldwing_import as import;
#[cfg(feature = "study")]
pub use foldwing_study as study;
