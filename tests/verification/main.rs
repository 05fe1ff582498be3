//! Verification against theory and independent solutions: the engine itself, statics, machines in time, aerodynamics, and the methods of
//! the papers. Cases are numbered V-xx; the other folders state their own numbering.

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
mod share;
mod shear;
mod shipped;
mod slender;
mod static_newton;
mod statics;
mod strips;
mod taylor;
mod trees;
mod turbine;
mod whole;
