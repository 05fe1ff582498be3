//! SH-20: large motion with shear against a geometrically exact program.

use crate::statics::machines::plant;

/// A thick pendulum, hinged at its inner end and released horizontally.
fn pendulum(pairs: usize) -> String {
    let (height, young, ratio, density): (f64, f64, f64, f64) = (0.1, 2e6, 0.3, 1000.0);
    let (area, second) = (height * height, height.powi(4) / 12.0);
    let shear_n = 5.0 / 6.0 * young / (2.0 * (1.0 + ratio)) * area;
    format!(
        "name = 'P'\ngravity_m_s2 = [0.0, 0.0, -9.81]\n\
         [section.s]\nshape = 'explicit'\naxial_stiffness_N = {:?}\ntorsional_rigidity_N_m2 = {:?}\n\
         flap_stiffness_N_m2 = {:?}\nedge_stiffness_N_m2 = {:?}\nshear_stiffness_N = [{shear_n:?}, {shear_n:?}]\n\
         mass_kg_m = {:?}\nsecond_moments_kg_m = [{:?}, 0.0, {:?}]\n\
         [body.beam]\nlength_m = 1.0\nsection = 's'\nshear = true\nelements = {pairs}\n\
         [joint.hinge]\ntype = 'revolute'\naxis = [0.0, 1.0, 0.0]\nparent = 'root'\nchild = 'beam'\n",
        young * area,
        young * 2.0 * second,
        young * second,
        young * second,
        density * area,
        density * second,
        density * second,
    )
}

/// Largest distance of the tip from the reference over 1 s, and the largest error of the energy balance relative to the largest kinetic
/// energy.
fn deviation(text: &str) -> (f64, f64) {
    let rows = include_str!("../../reference/shear/thick_pendulum_exudyn.csv").lines().skip(1);
    let rows: Vec<[f64; 3]> = rows
        .map(|row| {
            let mut numbers = row.split(',').map(|word| word.parse().expect("a number"));
            std::array::from_fn(|_| numbers.next().expect("three numbers"))
        })
        .collect();
    let mut plant = plant(text);
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    let (mut worst, mut unbalanced, mut kinetic, mut start) = (0.0f64, 0.0f64, 0.0f64, None);
    for pair in rows.windows(2) {
        plant.step(pair[1][0]).unwrap_or_else(|error| panic!("{error}"));
        let tip = plant.shape()[0].last().expect("a tip").position_m;
        worst = worst.max((tip.x - pair[1][1]).hypot(tip.z - pair[1][2]));
        let energies = plant.outputs().energy();
        let account = energies.total - energies.work + energies.dissipated;
        unbalanced = unbalanced.max((account - *start.get_or_insert(account)).abs());
        kinetic = kinetic.max(energies.kinetic);
    }
    (worst, unbalanced / kinetic)
}

/// SH-20. Four pairs follow 64 geometrically exact elements within 1 mm over 1 s (the error of the reference is 0.1 mm); without shear the
/// tip is 5 mm off. The energy balance closes to 1e-6 of the largest kinetic energy.
#[test]
fn sh20_thick_pendulum() {
    let text = pendulum(4);
    let (worst_m, unbalanced) = deviation(&text);
    let (without_m, _) = deviation(&text.replace("shear = true\n", ""));
    println!("SH-20 {worst_m:.2e} m, without shear {without_m:.2e} m, energy {unbalanced:.1e}");
    assert!(worst_m < 1e-3, "{worst_m:.2e} m");
    assert!((4e-3..7e-3).contains(&without_m), "{without_m:.2e} m");
    assert!(unbalanced < 1e-6, "{unbalanced:.1e}");
}
