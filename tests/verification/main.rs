//! Verification against theory and independent solutions: the engine by itself, statics, the machine in time, air, and the
//! methods of the papers. Case numbers V-xx; the other folders name theirs.

mod agreement;
mod bending;
mod blades;
mod breaking;
mod capabilities;
mod carried;
mod closed_forms;
mod conventional;
mod counting_allocator;
mod coupling;
mod flight;
mod gauges;
mod lattice;
mod linear_rows;
mod modes;
mod oracle;
mod pitch_link;
mod plant;
mod properties;
mod recursion;
mod reference;
mod rod;
mod rotor;
mod shear;
mod shipped;
mod static_newton;
mod statics;
mod strips;
mod taylor;
mod trees;
mod turbine;
mod whole;
