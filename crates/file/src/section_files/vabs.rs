//! Output of VABS, `.K`: mass matrix, classical stiffness and, from a Timoshenko analysis, 6×6 stiffness, about the origin of its
//! mesh.

use super::matrices::{KEPT, Station, Stiffness};
use super::text::Lines;
use crate::station_table::StationFault;
use foldwing_engine::math::strain::STRAINS;
use nalgebra::Matrix6;

/// Title of the mass matrix.
pub(super) const MASS: &str = "The 6X6 Mass Matrix";
const TIMOSHENKO: &str = "Timoshenko Stiffness Matrix";
const CLASSICAL: &str = "Classical Stiffness Matrix";

/// Reads the section.
pub(super) fn station(text: &str) -> Result<Station, StationFault> {
    let (inertia_line, inertia) = Lines::after(text, MASS)?.matrix::<6>("the mass matrix")?;
    let (line, stiffness) = match Lines::after(text, TIMOSHENKO) {
        Ok(mut lines) => {
            let (line, matrix) = lines.matrix::<6>("the Timoshenko stiffness")?;
            (line, Stiffness::Whole(matrix))
        }
        Err(_) => {
            let mut lines = Lines::after(text, CLASSICAL)?;
            let (line, matrix) = lines.matrix::<STRAINS>("the classical stiffness")?;
            let mut whole = Matrix6::zeros();
            for (row, column) in (0..STRAINS).flat_map(|row| (0..STRAINS).map(move |column| (row, column))) {
                whole[(KEPT[row], KEPT[column])] = matrix[(row, column)];
            }
            (line, Stiffness::Classical(whole))
        }
    };
    Ok(Station { share: None, lines: [line, inertia_line], stiffness, inertia })
}
