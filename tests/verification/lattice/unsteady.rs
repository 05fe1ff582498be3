use crate::wing::*;
use nalgebra::Vector3;

#[test]
fn smoke2() {
    // long wing, two-dimensional
    for (nc, f) in [(8, 1.0), (8, 0.25), (16, 0.5)] {
        let mut o = options();
        o.wake_rows = 2000;
        let aspect = 1e4;
        let places = inset(aspect, 5);
        let mut wing = Wing::new(&places, |_| 1.0, nc, o).with_incidence(0.01);
        wing.start(false);
        let dt = f / nc as f64 / SPEED_M_S;
        let mut t = 0.0;
        let mut out = vec![];
        for _ in 0..(5.0 / f * nc as f64) as usize {
            wing.step(dt);
            t += dt;
            let g = wing.lattice.strip_circulation(&wing.from, 0, 2);
            let s = 2.0 * SPEED_M_S * t;
            out.push((
                s,
                (wing.loads.circulatory[2].force_n.z + wing.loads.impulsive[2].force_n.z)
                    / (places[2] - places[1])
                    / pressure_pa()
                    / 0.01
                    / std::f64::consts::TAU,
                g,
            ));
        }
        for q in [0.5, 1.0, 2.0, 6.0] {
            let o = out.iter().find(|o| o.0 >= q - 1e-9).unwrap();
            println!("{nc} {f} {:?}  jones {}", o, 1.0 - 0.165 * (-0.0455 * o.0).exp() - 0.335 * (-0.3 * o.0).exp());
        }
    }
    // added mass
    for nc in [4, 8] {
        let places = inset(1e4, 5);
        let mut wing = Wing::new(&places, |_| 1.0, nc, options());
        wing.wind_m_s = Vector3::zeros();
        wing.start(false);
        for m in &mut wing.motions {
            m.velocity_m_s = Vector3::z() * 0.1;
        }
        wing.step(0.01);
        let f: f64 = wing.loads.impulsive[2].force_n.z;
        println!("{nc} {:?}", f / (places[2] - places[1]) / 10.0 / DENSITY_KG_M3 / std::f64::consts::PI * 4.0);
    }
}
