//! scratch
use crate::pendulum::*;
#[test]
fn measure() {
    for between in Between::ALL {
        let t = std::time::Instant::now();
        let (s, q) = joint_parameters(between, 2);
        let d = run(&s, &q, 0.3, 500, true);
        let t1 = t.elapsed().as_secs_f64();
        let (s2, q2) = index_1_dae(between, 2);
        let c = run(&s2, &q2, 0.3, 500, false);
        println!("{between:?} d {t1:.2} s, dae {:.2} s", t.elapsed().as_secs_f64() - t1);
        for (d, c) in d.iter().zip(&c) {
            println!("{:.2} tip {:.8?} diff {:.1e} strain {:.2e} {:.1e} E {:.1e} {:.1e} T {:.1} gap {:.1e} {:.1e} card {:.1e} {:.1e} hinge {:.1e} {:.1e} own {:.1e} {:.1e}", d.time_s, d.points_m[1].as_slice(),
              (d.points_m[1]-c.points_m[1]).norm(), d.root_strain[3], d.root_strain[3]-c.root_strain[3], d.total_j(), c.total_j(), d.energy_j[0], d.gap_m, c.gap_m, d.cardan, c.cardan, d.hinge, c.hinge, d.own, c.own);
        }
    }
}
