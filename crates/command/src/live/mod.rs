//! A simulation in real time that a page of the browser shows and touches: the machine by the wall clock, a server for one computer.
//!
//! [`Session`] has the plant, its clock, a bounded history and the spring that pulls; it knows no network. [`Server`] has the network, and
//! no physics: it hands [`Order`]s of the pages to the session and its pictures to the pages. Rules: `docs/decisions/0063-live-view.md`.

mod clients;
mod controls;
mod history;
mod http;
mod order;
mod pace;
mod pull;
mod server;
#[cfg(test)]
mod server_tests;
mod session;
#[cfg(test)]
mod session_tests;
#[cfg(test)]
mod tests;

pub use controls::{Control, controls};
pub use order::{Order, SPEEDS};
pub use server::{Ended, Server};
pub use session::{Session, Summary};
