//! The engine in a web page: its input is the text of a model, its output the run in the format of the viewer page, or errors with line,
//! column and remedy.
//!
//! `make live-site` compiles it for `wasm32-unknown-unknown`; the module imports nothing. On other targets it is the same code, for tests.

mod exports;
mod marks;
mod session;

pub use marks::{Mark, Severity, marks, warnings};
pub use session::{Refusal, Session, State};
