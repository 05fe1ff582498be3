//! The tree of beams and joints, and the recursions over it: kinematics, residual, solve. All O(n).

pub(crate) mod block_slopes;
mod carried;
mod cholesky;
pub mod closure;
mod damped_mode;
pub mod derivative;
pub mod dynamics;
mod elastic;
pub mod element;
pub(crate) mod elimination;
pub mod energy;
pub mod factor;
pub mod gauge;
pub mod internal_load;
pub mod joint;
pub mod kinematics;
pub mod modal;
pub mod mode_damping;
pub mod model;
pub(crate) mod motion;
pub(crate) mod node;
pub mod norm;
pub(crate) mod rigid_loop;
pub mod slide;
pub(crate) mod slope;
pub mod station;
pub(crate) mod station_load;
pub mod tangent;
pub mod workspace;

pub use model::Model;
pub use workspace::Workspace;
