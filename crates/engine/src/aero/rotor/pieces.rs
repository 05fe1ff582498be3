//! Smooth pieces of the functions of a rotor, NOTATION eq. (X37).

use crate::aero::pieces::PieceList;

/// Pieces of an evaluation of a rotor.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RotorPieces {
    /// Of the wind at the sections.
    pub winds: Vec<PieceList>,
    /// Of the disc.
    pub disc: PieceList,
    /// Of the wake's time constant: in each pass over the sections, and behind the last.
    pub wakes: Vec<PieceList>,
    /// Of the sections, pass by pass.
    pub sections: Vec<Vec<PieceList>>,
    /// Of the time constants of the sections at the end of a step.
    pub ends: Vec<PieceList>,
}

impl RotorPieces {
    /// Numbers of all pieces, for comparison.
    pub fn choices(&self) -> impl Iterator<Item = usize> {
        let lists = self.winds.iter().chain([&self.disc]).chain(&self.wakes).chain(self.sections.iter().flatten());
        lists.chain(&self.ends).flat_map(|list| list.choices.iter().copied())
    }

    /// The first section that is exactly at a point of the grid of the wind.
    pub fn at_node(&self) -> Option<usize> {
        self.winds.iter().position(|list| list.at_node)
    }

    /// The first section that is exactly at a row of its polar.
    pub fn kinked(&self) -> Option<usize> {
        self.sections.iter().find_map(|pass| pass.iter().position(|list| list.at_kink))
    }
}
