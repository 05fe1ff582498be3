//! Interactive simulation in real time on a page in the browser.
//!
//! [`Session`] contains the machines, their clock, a bounded history and the springs; it is independent of the network. [`Server`] passes
//! [`Order`]s of the pages to the session, and frames of the session to the pages. Rules: `docs/decisions/0063-live-view.md`.

mod clients;
mod controls;
mod history;
mod http;
mod order;
mod pace;
mod pull;
mod running;
mod server;
#[cfg(test)]
mod server_tests;
mod session;
#[cfg(test)]
mod session_tests;
mod summary;
#[cfg(test)]
mod tests;

pub use controls::{Control, controls};
pub use order::{Order, SPEEDS};
pub use server::{Ended, Server};
pub use session::{MOST_MACHINES, Session};
pub use summary::Summary;
