//! Number of unknowns per joint, compared with the conventional formulation: Otsuka et al., Table 2 and eq. (13).

use foldwing_engine::machine::JointKind;
use serde::Serialize;

/// Coordinates of a node in the conventional formulation: position and three vectors of its frame.
const NODE: usize = 12;

/// Variables and multipliers of one joint in both formulations.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct JointSize {
    /// Joint variables `N_J` of this formulation.
    variables: usize,
    /// Lagrange multipliers `N_L` of this formulation.
    multipliers: usize,
    /// Variables of the node outboard of the joint in the conventional formulation.
    conventional_variables: usize,
    /// Multipliers of the conventional formulation: constraints of the joint and of the rigid section.
    conventional_multipliers: usize,
    /// Reduction rate of the unknowns, eq. (13).
    reduction_rate: f64,
    /// Whether the paper's table has this type of joint; the numbers of the other types are counted in the same manner.
    in_table_2: bool,
}

impl JointSize {
    /// Heading and explanation of the table.
    pub const TITLE: &str = "\njoint variables and multipliers, ours against the conventional 12 per node (Otsuka et \
                             al., Table 2)\n";

    /// Computes the sizes of a joint from the numbers of unknowns in the engine.
    pub fn new(kind: &JointKind, variables: usize, multipliers: usize) -> Self {
        // both formulations have the same degrees of freedom
        let conventional_multipliers = NODE - (variables - multipliers);
        let (ours, conventional) = (variables + multipliers, NODE + conventional_multipliers);
        // revolute, universal and ball joints
        let in_table_2 = kind.holds_place() && !kind.is_clamped();
        Self {
            variables,
            multipliers,
            conventional_variables: NODE,
            conventional_multipliers,
            reduction_rate: (conventional - ours) as f64 / conventional as f64,
            in_table_2,
        }
    }

    /// Returns one line of the table. For the revolute joint, the paper prints 33 as the sum of 12 and 11, hence its 97
    /// %.
    pub fn text(&self, name: &str, kind: &str) -> String {
        let Self { variables, multipliers, conventional_variables, conventional_multipliers, .. } = self;
        let source = match (self.in_table_2, kind.starts_with("revolute")) {
            (false, _) => " (not in the table: counted in the same way)",
            (true, true) => " (the table prints 33 for 12 + 11, and so 97 %)",
            (true, false) => "",
        };
        format!(
            "  {name}: {kind}, {variables} + {multipliers} against {conventional_variables} + \
             {conventional_multipliers}, {:.0} % less{source}\n",
            100.0 * self.reduction_rate
        )
    }
}
