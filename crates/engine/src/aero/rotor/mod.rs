//! Rotor aerodynamics: blade-element momentum theory, with models of the wake, the wind and the tower.
//!
//! At a node where Prandtl's loss is complete, exactly at the tip or at the hub, the annulus has no solution.
//! [`EndRule::ZeroLoad`](induction::EndRule), the default, sets the load of such a node to zero, as at the end of a lifting line;
//! [`EndRule::Stopped`](induction::EndRule) is AeroDyn's method, for comparison.

pub mod bem;
mod continuous;
mod disc;
pub mod dynamic_inflow;
pub mod dynamic_stall;
pub mod induction;
pub mod inflow_lag;
pub mod lag;
pub mod loads;
mod meeting;
pub mod options;
mod output_slopes;
pub mod pieces;
pub mod skew;
pub mod slopes;
mod spread;
pub mod states;
pub mod steady;
mod switch;
pub mod tower;
pub mod turbulence;
pub mod turbulence_box;
pub mod viterna;
pub mod wind;
