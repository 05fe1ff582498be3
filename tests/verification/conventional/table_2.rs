//! C-03: Table 2 of the paper, computed from the models.

use crate::conventional::constraint::Constraint;
use crate::conventional::pendulum::{Between, index_1_dae, joint_parameters};

/// One joint of Table 2.
pub struct Row {
    /// Joint.
    pub between: Between,
    /// Variables and multipliers of the conventional DAE.
    pub conventional: [usize; 2],
    /// Variables and multipliers of joint parameters.
    pub joint_parameters: [usize; 2],
    /// Reduction of eq. (13) in per cent.
    pub reduction: usize,
}

/// Table 2. The paper prints a sum of 33 and a reduction of 97 % for the revolute joint; 12 + 11 = 23, and eq. (13) then gives 96 % (95.7
/// %), the value used here.
pub const TABLE_2: [Row; 3] = [
    Row { between: Between::Revolute, conventional: [12, 11], joint_parameters: [1, 0], reduction: 96 },
    Row { between: Between::Universal, conventional: [12, 10], joint_parameters: [9, 7], reduction: 27 },
    Row { between: Between::Ball, conventional: [12, 9], joint_parameters: [4, 1], reduction: 76 },
];

/// C-03. Both dense models have the variables and multipliers of Table 2, and their numbers of remaining degrees of freedom agree.
#[test]
fn c03_variables_and_multipliers_are_those_of_table_2() {
    for row in TABLE_2 {
        let (ours, _) = joint_parameters(row.between, 2);
        let (dae, _) = index_1_dae(row.between, 2);
        let variables = |system: &crate::conventional::assembly::Assembly| system.bodies[1].joint.variables();
        // body A is attached by a ball joint, which in the DAE has 6 rigid-node and 3 position constraints
        let dae_multipliers = dae.multipliers() - 9;
        let own: usize = ours.constraints.iter().map(Constraint::rows).sum::<usize>() - 1;
        let name = row.between.name();
        assert_eq!([variables(&dae), dae_multipliers], row.conventional, "{name}: conventional");
        assert_eq!([variables(&ours), own], row.joint_parameters, "{name}: joint parameters");
        let sums = [row.conventional, row.joint_parameters].map(|[n, l]| (n + l) as f64);
        assert_eq!((100.0 * (1.0 - sums[1] / sums[0])).round() as usize, row.reduction, "{name}: eq. (13)");
        let freedoms = [row.conventional, row.joint_parameters].map(|[n, l]| n - l);
        assert_eq!(freedoms[0], freedoms[1], "{name}: degrees of freedom");
    }
}
