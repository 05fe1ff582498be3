//! Statics, modes and linearisation against theory and independent solutions. Case numbers S-xx.

mod tangent;
