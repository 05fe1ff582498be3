//! The strut-braced folding wing of `examples/braced`.

use foldwing::config;
use foldwing::plant::Plant;
use nalgebra::Vector3;
use std::sync::Arc;

const MODEL: &str = include_str!("../../../examples/braced/braced_wing.toml");
/// Distances along the wing from the hinge to the strut and to the tip, and height of the hinge above the foot, m.
const STRUT_M: f64 = 1.0;
const SPAN_M: f64 = 1.6;
const HEIGHT_M: f64 = 0.6;

fn balance_j(plant: &Plant) -> f64 {
    let energy = plant.outputs().energy();
    energy.total - energy.work + energy.dissipated
}

/// LP-20. The wing rises, the knee latches within its range, and the braced wing settles: the horizontal force of the strut on the root
/// balances the moments of the weights about the hinge, the root carries the whole weight, and the gaps of the loops are their forces
/// divided by the stiffness. The energy balance closes through the impulse of the latch.
#[test]
fn lp20_braced_wing_deploys_and_is_held_by_its_strut() {
    let machine = config::parse(MODEL, "braced_wing.toml").unwrap_or_else(|error| panic!("{error}"));
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).expect("a start");
    let begin_j = balance_j(&plant);
    let (mut drift_j, mut gap_m, mut pull_n) = (0.0f64, 0.0f64, 0.0f64);
    for step in 1..=1600 {
        plant.step(5e-3 * f64::from(step)).unwrap_or_else(|error| panic!("{error}"));
        drift_j = drift_j.max((balance_j(&plant) - begin_j).abs());
        for closure in plant.outputs().loops() {
            gap_m = gap_m.max(closure.gap_m.norm());
            pull_n = pull_n.max(closure.force_n.norm());
        }
    }
    let outputs = plant.outputs();
    let knee = outputs.joints()[2];
    let latch = outputs.latches()[2];
    println!(
        "LP-20 latch at {:.4} s, {:.4} deg; gap {gap_m:.1e} m, force {pull_n:.1} N, drift {drift_j:.1e} J; hinge {:.4} deg",
        latch.time_s,
        knee.angle_rad.to_degrees(),
        outputs.joints()[0].angle_rad.to_degrees()
    );
    assert!(latch.closed.is_on() && knee.angle_rad.to_degrees().abs() < 1.0 + 1e-6);
    let tip = outputs.tips()[0];
    assert!(tip.position_m.x > 0.99 * SPAN_M, "{:?} m", tip.position_m);
    // force of the foot on the strut: along the strut, except for the weight of the links, half of which acts at either end
    let foot: Vector3<f64> = outputs.loops().iter().map(|closure| closure.force_n).sum();
    let mass = |body: usize| {
        let body = &plant.machine().bodies[body];
        body.section.mass_kg(body.length_m)
    };
    let (wing_n, link_n) = (9.81 * mass(0), 9.81 * mass(1));
    let length_m = (STRUT_M * STRUT_M + HEIGHT_M * HEIGHT_M).sqrt();
    // about the hinge: weight of the wing at half the span, of the strut at half its horizontal extent, and the force of the foot
    let moment_n_m = wing_n * 0.5 * SPAN_M + 2.0 * link_n * 0.5 * STRUT_M;
    // the foot is vertically below the hinge
    let across_n = moment_n_m / HEIGHT_M;
    let miss = (foot.x / across_n - 1.0).abs();
    println!("LP-20 foot {foot:?} N, across {across_n:.2} N, off by {miss:.1e}; strut {length_m:.3} m");
    // the angle of the knee, up to 1 degree, and the bending of the wing change the lever arms by 1e-3 or less
    assert!(miss < 5e-3, "{} N for {across_n} N", foot.x);
    let weight_n = 9.81 * plant.mass_kg();
    assert!(
        (outputs.root().force_n + Vector3::z() * weight_n).norm() < 1e-3 * weight_n,
        "{:?}",
        outputs.root().force_n
    );
    assert!(drift_j < 1e-3 * begin_j.abs().max(30.0), "drift {drift_j:.1e} J");
    assert!(gap_m < 1.5 * pull_n / 5e6 + 1e-6, "gap {gap_m:.1e} m at {pull_n:.1} N");
}
