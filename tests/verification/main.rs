//! Verification against theory: a dense oracle, identities, statics, frequencies. Case numbers V-xx.

mod oracle;
mod recursion;
mod taylor;
mod trees;
