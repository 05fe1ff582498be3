//! Frequencies and damping against OpenFAST's linearisation.

use crate::turbine::machine::*;
use foldwing::machine::JointMotion;
use foldwing::plant::{Holding, Plant};
use std::sync::Arc;

/// WT-02. Three modes of one blade at 0 to 18 rpm. The reference has six digits, 2e-6 of the lowest frequency; damping ratios have four,
/// 1e-4 of the lowest, and depend on the same integrals.
#[test]
fn wt02_a_blade_stiffens_as_it_turns() {
    let (_, rows) = table(include_str!("../../reference/turbine/openfast_fan_plot.csv"));
    let mut worst = [0.0f64; 2];
    for row in rows {
        let mut plant = spinning(blade_alone(), row[0]);
        let modes = plant.study().modes(3).expect("modes");
        for (k, mode) in modes.iter().enumerate() {
            worst[0] = worst[0].max((mode.frequency_hz / row[1 + k] - 1.0).abs());
            worst[1] = worst[1].max((mode.damping_ratio / row[4 + k] - 1.0).abs());
        }
    }
    println!("WT-02: frequencies {:.1e}, damping ratios {:.1e}", worst[0], worst[1]);
    assert!(worst[0] < 2e-5, "frequencies off by {:.1e}", worst[0]);
    assert!(worst[1] < 1e-3, "damping ratios off by {:.1e}", worst[1]);
}

/// WT-03. The fifteen modes of the machine at rest under gravity, generator locked, blade 1 up.
#[test]
fn wt03_modes_at_standstill() {
    let mut machine = turbine();
    hinge_mut(&mut machine, "shaft").motion = JointMotion::Locked;
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).expect("a start");
    plant.study().equilibrium(0.0, Holding::AsReleased).expect("an equilibrium");
    let modes = plant.study().modes(15).expect("modes");
    let (_, rows) = table(include_str!("../../reference/turbine/openfast_standstill_modes.csv"));
    assert_eq!((modes.len(), rows.len()), (15, 15));
    let mut worst = [0.0f64; 2];
    for (mode, row) in modes.iter().zip(rows) {
        println!(
            "{:9.6} Hz ({:9.6}), damping ratio {:.6} ({:.6})",
            mode.frequency_hz, row[1], mode.damping_ratio, row[3]
        );
        worst[0] = worst[0].max((mode.frequency_hz / row[1] - 1.0).abs());
        worst[1] = worst[1].max((mode.damping_ratio / row[3] - 1.0).abs());
    }
    println!("WT-03: frequencies {:.1e}, damping ratios {:.1e}", worst[0], worst[1]);
    assert!(worst[0] < 1e-4, "frequencies off by {:.1e}", worst[0]);
    assert!(worst[1] < 1e-2, "damping ratios off by {:.1e}", worst[1]);
}
