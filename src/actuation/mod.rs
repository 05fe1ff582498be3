//! actuation
