//! Studies of a model: analyses that need several of its states, such as the speed at which it flutters or the trim of an aircraft.
//!
//! Each study is a function of a model or a [`Plant`](foldwing_engine::plant::Plant) with start values, and of options whose names
//! carry units. Its result consists of numbers and its error of fields; the command and the Python package turn them into text. Results
//! that implement `serde::Serialize` give the JSON that the command prints.
//!
//! Studies that may take long have a second function `…_watched`, with a [`Watch`](watch::Watch) that shows their progress and can stop
//! them.
//!
//! Nothing here reads a file or prints, and no text contains options of the command. Names of inputs, parameters and outputs are those of
//! [`Interface`](foldwing_fmi::interface::Interface); `docs/NOTATION.md` numbers the equations that the code cites.

#![forbid(unsafe_code)]

pub mod names;

pub mod watch;

pub mod branches;

pub mod values;

pub mod warnings;

pub mod flutter;

pub mod trim;

pub mod operating_points;

pub mod campbell;

pub mod periodic;

pub mod latency;

pub mod sensitivity;

pub mod fit;
