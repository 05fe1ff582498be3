//! The methods that Otsuka et al. compare joint parameters with, small and dense: rotation angles, penalty joint,
//! index-1 DAE, planar finite segments; and joint parameters themselves in the dense form of eq. (9).
//!
//! This module contains no product code and uses it only for comparison: kinematics, inertia and solution are written a second time, for
//! clarity rather than speed. Results are in `docs/validation/conventional.md`; `make validate` also runs the long studies.

mod angles;
mod assembly;
mod constraint;
mod derivatives;
mod double_pendulum;
mod link;
mod pendulum;
mod planar;
mod product;
mod reference;
mod sample;
mod segments;
mod table_2;
mod two_body;
