//! Output of BECAS: stiffness and mass matrices about the reference point of the section.

use super::matrices::{Station, Stiffness};
use super::text::Lines;
use crate::station_table::StationFault;

/// Title of the stiffness matrix.
pub(super) const STIFFNESS: &str = "Stiffness matrix w.r.t. to the cross section reference point";
const MASS: &str = "Mass matrix w.r.t. to the cross section reference point";

/// Reads the section.
pub(super) fn station(text: &str) -> Result<Station, StationFault> {
    let (line, stiffness) = Lines::after(text, STIFFNESS)?.matrix::<6>("the stiffness")?;
    let (inertia_line, inertia) = Lines::after(text, MASS)?.matrix::<6>("the mass matrix")?;
    Ok(Station { share: None, lines: [line, inertia_line], stiffness: Stiffness::Whole(stiffness), inertia })
}
