//! Steady wings: lift slope, span loading, induced drag.

use crate::wing::{Wing, options, pressure_pa};
use nalgebra::Vector3;

#[test]
fn smoke() {
    for (nc, half) in [(4, 16), (8, 32), (12, 48)] {
        for aspect in [2.0, 6.0, 20.0] {
            let n = 2 * half;
            let places: Vec<f64> = (0..=n).map(|i| aspect * (i as f64 / n as f64 - 0.5)).collect();
            let a = 1f64.to_radians();
            let mut wing = Wing::new(&places, |_| 1.0, nc, options()).with_incidence(a);
            wing.start(true);
            let f = wing.circulatory_n();
            println!("{nc} {aspect} {:.6} {:?}", f.z / (pressure_pa() * aspect) / a, f);
            let _ = Vector3::<f64>::x();
        }
    }
}
