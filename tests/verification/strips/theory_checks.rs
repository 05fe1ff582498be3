//! The references of these tests, checked against published values and against each other.

use crate::reference::{case, numbers};
use crate::strips::theory::{kuessner, sears, theodorsen, wagner};
use serde_json::Value;

/// Rows of a table of the case by their argument.
fn table(name: &str) -> Vec<(f64, Value)> {
    let rows = case("aero.unsteady_2d")["expected"][name].clone();
    let rows = rows.as_object().expect("a table").clone();
    rows.into_iter().map(|(key, value)| (key.parse().expect("a number"), value)).collect()
}

/// W-01. Theodorsen's function against an independent evaluation with Bessel functions.
#[test]
fn w01_theodorsen_function() {
    for (k, value) in table("theodorsen") {
        let expected = numbers(&value);
        let ours = theodorsen(k);
        let off = (ours.re - expected[0]).hypot(ours.im - expected[1]);
        println!("C({k}) = {ours:.9}, off by {off:.1e}");
        assert!(off < 1e-10, "k = {k}: {ours} against {expected:?}"); // the accuracy of the table
    }
    // Theodorsen and Garrick's printed table: F and −G to four digits
    for (k, f, g) in [(0.1, 0.8319, 0.1723), (0.3, 0.6650, 0.1793), (0.5, 0.5979, 0.1507), (1.0, 0.5394, 0.1003)] {
        let ours = theodorsen(k);
        assert!((ours.re - f).abs() < 5.1e-5 && (ours.im + g).abs() < 5.1e-5, "k = {k}: {ours}");
    }
    // no jump where the series ends
    let step = theodorsen(2.0 + 1e-9) - theodorsen(2.0 - 1e-9);
    assert!(step.norm() < 1e-9, "{step}");
}

/// W-02. Wagner's function: tabulated values, and its limits for small and large arguments.
#[test]
fn w02_wagner_function() {
    for (s, value) in table("wagner") {
        let expected = value.as_f64().expect("a number");
        println!("wagner({s}) = {:.7}, table {expected}", wagner(s));
        assert!((wagner(s) - expected).abs() < 1e-5, "s = {s}: {} against {expected}", wagner(s)); // the accuracy of the table
    }
    assert!((wagner(0.0) - 0.5).abs() < 1e-9, "{}", wagner(0.0));
    assert!((wagner(1e4) - 1.0).abs() < 2e-4, "{}", wagner(1e4)); // 1 − 1/s
}

/// W-03. Küssner's function: tabulated values (accurate to 2e-3), its start `√(2s)/π`, and Sears' function as its spectrum.
#[test]
fn w03_kuessner_function() {
    for (s, value) in table("kussner") {
        let expected = value.as_f64().expect("a number");
        println!("kuessner({s}) = {:.7}, table {expected}", kuessner(s));
        assert!((kuessner(s) - expected).abs() < 2e-3, "s = {s}: {} against {expected}", kuessner(s));
    }
    let s: f64 = 1e-6;
    assert!((kuessner(s) / ((2.0 * s).sqrt() / std::f64::consts::PI) - 1.0).abs() < 1e-3, "{}", kuessner(s));
    // a long gust is quasi-steady, the effect of a short one vanishes: |S| → 1/√(2πk)
    assert!((sears(1e-6).re - 1.0).abs() < 1e-4);
    let k = 50.0;
    let ratio = sears(k).norm() * (2.0 * std::f64::consts::PI * k).sqrt();
    assert!((ratio - 1.0).abs() < 1e-2, "{ratio}");
}
