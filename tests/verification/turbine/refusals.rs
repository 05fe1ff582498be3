//! What is refused about modal bodies and copies, with place, value and cure.

use crate::turbine::machine::TEXT;
use foldwing::config;

/// The example with one change, refused.
fn refusal(from: &str, to: &str) -> String {
    assert!(TEXT.contains(from), "the example has {from:?}");
    match config::parse(&TEXT.replacen(from, to, 1), "turbine.toml") {
        Ok(_) => panic!("{to:?} was accepted"),
        Err(refused) => refused.to_string(),
    }
}

/// WT-07. Each with the key, and what is allowed instead.
#[test]
fn wt07_refusals_name_place_and_cure() {
    for (from, to, words) in [
        ("[0.7004, 2.1963", "[0.9004, 2.1963", &["modal_body.tower.flap_shapes", "add up to 1"][..]),
        (
            "flap_damping_ratios = [0.01, 0.01]",
            "flap_damping_ratios = [0.01]",
            &["an array of 2 numbers, one per shape"],
        ),
        ("    0.0, 0.1, 0.2,", "    0.0, 0.2, 0.1,", &["modal_body.tower.stations", "ascend from 0 to 1"]),
        ("    5590.87, 5232.43,", "    5590.87,", &["modal_body.tower.mass_kg_m", "an array of 11 numbers"]),
        (
            "    5590.87, 5232.43,",
            "    5590.87, -5232.43,",
            &["modal_body.tower.mass_kg_m", "values > 0 all along the body"],
        ),
        (
            "moments_as_given = true\n\n# The shaft",
            "\n# The shaft",
            &["rigid_body.nacelle.inertia_kg_m2", "none larger than the sum"],
        ),
        ("count = 3 ", "count = 0 ", &["modal_body.blade.count", "1 to 12"]),
        (
            "[joint.yaw]",
            "[joint.pitch2]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"tower\"\n\n[joint.yaw]",
            &["joint.pitch2", "one of the copies of \"pitch\""],
        ),
        (
            "parent = \"tower\"\n",
            "parent = \"tower\"\nparent_position_m = 40.0\n",
            &["joint.yaw.parent_position_m", "carries others at its ends only"],
        ),
        ("cells = 17 ", "cells = 0 ", &["modal_body.blade.cells", "1 to 1000"]),
    ] {
        let told = refusal(from, to);
        for word in words {
            assert!(told.contains(word), "{to:?}: {word:?} is missing in\n{told}");
        }
    }
    // what is wrong with every copy is told once
    let told = refusal("edge_damping_ratios = [0.00477465]", "edge_damping_ratios = [-0.1]");
    assert_eq!(told.matches("edge_damping_ratios").count(), 1, "{told}");
    let gauge = format!("{TEXT}\n[gauge.root]\nbody = \"blade\"\nposition_m = 1.0\n");
    let told = config::parse(&gauge, "turbine.toml").expect_err("a gauge on a modal body").to_string();
    assert!(told.contains("has no strains of sections"), "{told}");
    assert_eq!(told.matches("gauge.root").count(), 1, "{told}");
}
