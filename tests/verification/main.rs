//! Verification against theory: a dense oracle, identities, statics, frequencies. Case numbers V-xx.

mod bending;
mod carried;
mod gauges;
mod modes;
mod oracle;
mod properties;
mod recursion;
mod reference;
mod rod;
mod statics;
mod taylor;
mod trees;
