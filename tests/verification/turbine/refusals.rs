//! Errors of modal bodies and copies, with location, value and remedy.

use crate::turbine::machine::{TEXT, WIND_TEXT, hinge_mut, windy, with_polars};
use foldwing::config;
use foldwing::plant::Plant;
use std::sync::Arc;

/// Error message for the example with one change.
fn refusal(from: &str, to: &str) -> String {
    refusal_of(TEXT, from, to)
}

/// Error message for a text with one change.
fn refusal_of(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "the example has {from:?}");
    match config::parse(&text.replacen(from, to, 1), "turbine.toml") {
        Ok(_) => panic!("{to:?} was accepted"),
        Err(refused) => refused.to_string(),
    }
}

/// WT-07. Each message names the key and the allowed values.
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
            "allow_nonphysical_inertia = true\n\n# The shaft",
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
        ("nodes = 17 ", "nodes = 0 ", &["modal_body.blade.nodes", "1 to 1000"]),
    ] {
        let told = refusal(from, to);
        for word in words {
            assert!(told.contains(word), "{to:?}: {word:?} is missing in\n{told}");
        }
    }
    // an error common to all copies is reported once
    let told = refusal("edge_damping_ratios = [0.00477465]", "edge_damping_ratios = [-0.1]");
    assert_eq!(told.matches("edge_damping_ratios").count(), 1, "{told}");
    let gauge = format!("{TEXT}\n[gauge.root]\nbody = \"blade\"\nposition_m = 1.0\n");
    let told = config::parse(&gauge, "turbine.toml").expect_err("a gauge on a modal body").to_string();
    assert!(told.contains("has no strains of sections"), "{told}");
    assert_eq!(told.matches("gauge.root").count(), 1, "{told}");
}

/// WT-24. Every invalid value of a generator, with its key and the allowed values.
#[test]
fn wt24_bad_generators_are_named() {
    let text = with_polars(WIND_TEXT);
    let table = "table_rpm_N_m = [[1150.878, 33876.63], [1173.7, 43093.55]]";
    let rows = "1 to 1000 rows [speed in rpm, torque in N·m]";
    let many =
        format!("table_rpm_N_m = [{}]", (0..1001).map(|row| format!("[{row}, 1]")).collect::<Vec<_>>().join(", "));
    let key = "joint.shaft.generator.table_rpm_N_m";
    for (from, to, words) in [
        (table, "table_rpm_N_m = [[1173.7, 43093.55], [1150.878, 33876.63]]", &[key, "ascending speeds"][..]),
        (table, "table_rpm_N_m = [[1150, 33876.63], [1150, 43093.55]]", &[key, "ascending speeds"]),
        (table, "table_rpm_N_m = []", &[key, rows]),
        (table, "table_rpm_N_m = [[1150.878, 33876.63, 1.0]]", &[key, rows]),
        (table, "table_rpm_N_m = [[1150.878, nan]]", &[key, rows]),
        (table, "table_rpm_N_m = [[inf, 33876.63]]", &[key, rows]),
        (table, "table_rpm_N_m = [[1, 1e300], [2, 1e305]]", &[key, rows]),
        (table, &many, &[key, rows]),
        (table, "", &[key, "missing", rows]),
        (
            "quadratic_gain_N_m_rpm2 = 0.0255764",
            "quadratic_gain_N_m_rpm2 = -1.0",
            &["generator.quadratic_gain_N_m_rpm2", ">= 0"],
        ),
        (
            "quadratic_gain_N_m_rpm2 = 0.0255764",
            "quadratic_gain_N_m_rpm2 = inf",
            &["generator.quadratic_gain_N_m_rpm2", "finite"],
        ),
        (
            "above_table = \"constant_torque\"",
            "above_table = \"speed\"",
            &["generator.above_table", "\"constant_torque\" or \"constant_power\""],
        ),
        ("efficiency = 0.944", "efficiency = 1.2", &["generator.efficiency", "from 0 to 1"]),
        ("efficiency = 0.944", "efficiency = -0.1", &["generator.efficiency", "from 0 to 1"]),
        ("efficiency = 0.944", "efficiency = nan", &["generator.efficiency", "from 0 to 1"]),
        ("efficiency = 0.944", "on = \"yes\"", &["generator.on", "true or false"]),
        ("efficiency = 0.944", "eficiency = 0.9", &["generator.eficiency", "efficiency"]),
        ("gear_ratio = 97.0", "", &["joint.shaft.motor.gear_ratio", "missing", "1.0 without a gearbox"]),
        ("gear_ratio = 97.0", "gear_ratio = 0.0", &["joint.shaft.motor.gear_ratio", "1e-6 to 1e6"]),
        ("gear_ratio = 97.0", "gear_ratio = nan", &["joint.shaft.motor.gear_ratio"]),
        ("start_rate_deg_s = 72.6", "motion = \"locked\"", &["joint.shaft.generator", "motion = \"free\""]),
        (
            "[joint.base]\ntype = \"clamped\"",
            "[joint.base]\ntype = \"clamped\"\ngenerator = { table_rpm_N_m = [[1, 2]] }",
            &["joint.base.generator", "revolute"],
        ),
    ] {
        let told = refusal_of(&text, from, to);
        for word in words {
            assert!(told.contains(word), "{to:.60}: {word:?} is missing in\n{told:.900}");
        }
        // each error is reported once, at a key of the file
        assert_eq!(
            told.matches("is not allowed").count()
                + told.matches("is missing").count()
                + told.matches("is unknown").count(),
            1,
            "{told:.900}"
        );
        assert!(!told.contains("generator.rows") && !told.contains("generator.gear_ratio"), "{told:.900}");
    }
    // constant power starting at an invalid speed
    let to = "table_rpm_N_m = [[-20.0, 5.0], [-10.0, 3.0]]";
    let told =
        refusal_of(&text.replace("above_table = \"constant_torque\"", "above_table = \"constant_power\""), table, to);
    assert!(told.contains(key) && told.contains("a last row at a speed > 0"), "{told:.900}");
}

/// WT-25. A rotor with incomplete blades: copies without an aerodynamic surface are named.
#[test]
fn wt25_blades_without_air_are_named() {
    let text = with_polars(WIND_TEXT);
    let told = refusal_of(&text, "[surface.blade]\nbody = \"blade\" ", "[surface.blade]\nbody = \"blade1\" ");
    for word in ["surface", "blade2, a blade like blade1, without a surface", "body = \"blade\" denotes all copies"] {
        assert!(told.contains(word), "{word:?} is missing in\n{told:.900}");
    }
    // rotors with one or two blades are valid
    for count in ["count = 1 ", "count = 2 ", "count = 5 "] {
        windy(&WIND_TEXT.replacen("count = 3 ", count, 1));
    }
}

/// WT-26. Polars with gaps, and truncated wind files: unreadable ones are errors, implausible ones are warnings.
#[test]
fn wt26_holes_in_polars_and_winds_are_named() {
    let sound = with_polars(WIND_TEXT);
    assert_eq!(
        config::warnings(&sound).iter().map(|warning| warning.key.clone()).collect::<Vec<_>>(),
        Vec::<String>::new()
    );
    let polar = "[polar.cylinder1]\nfile = \"polars/cylinder1.csv\"";
    let with = |rows: &str| with_polars(&WIND_TEXT.replacen(polar, &format!("[polar.cylinder1]\nrows = {rows}"), 1));
    for (rows, words) in [
        (
            "[[-180, 0, 0.5, 0], [0, nan, 0.5, 0], [180, 0, 0.5, 0]]",
            &["polar.cylinder1.rows", "[angle of attack in deg"][..],
        ),
        (
            "[[-180, 0, 0.5, 0], [10, 0, 0.5, 0], [5, 0, 0.5, 0], [180, 0, 0.5, 0]]",
            &["polar.cylinder1.rows", "ascending"],
        ),
        ("[[-20, 0, 0.5, 0], [20, 0, 0.5, 0]]", &["polar.cylinder1.rows", "from -20", "aspect_ratio"]),
        ("[]", &["polar.cylinder1.rows", "at least 1 row"]),
    ] {
        let told = config::parse(&with(rows), "turbine.toml").expect_err("a polar that is none").to_string();
        for word in words {
            assert!(told.contains(word), "{rows}: {word:?} is missing in\n{told:.600}");
        }
    }
    // rows missing in a polar that is not constant
    let text = with("[[-180, 0, 0.5, 0], [-20, -0.9, 0.3, 0], [20, 0.9, 0.3, 0], [180, 0, 0.5, 0]]");
    let warnings = config::warnings(&text);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(
        warnings[0].key.starts_with("polar.cylinder1") && warnings[0].reason == "no row between -180 and -20 deg",
        "{warnings:?}"
    );
    // a constant polar needs no rows in between
    assert_eq!(config::warnings(&with("[[-180, 0, 0.5, 0], [180, 0, 0.5, 0]]")), Vec::new());

    let wind = "[wind]\nreference_height_m = 90.0\nreference_length_m = 126.0\ntable = ROWS\n\n[surface.blade]";
    let blown = |rows: &str| sound.replacen("[surface.blade]", &wind.replace("ROWS", rows), 1);
    let told = config::parse(&blown("[[0, 8, 0, 0, 0, 0.2, 0, 0], [10, 9, 0, 0, 0, 0.2, 0]]"), "turbine.toml");
    assert!(told.expect_err("a row cut short").to_string().contains("wind.table"));
    let warnings = config::warnings(&blown("[[0, 8, 0, 0, 0, 0.2, 0, 0], [10, 9, 0, 0, 0, 0.2, 0, 0]]"));
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].reason == "the wind ends at 10 s, the run at 60 s", "{warnings:?}");
}

/// WT-27. A pitch beyond the polar's range still gives loads: angles of attack are periodic. Pitched by a full revolution, and by 200 and
/// -160 deg, the aerodynamic loads are equal to round-off.
#[test]
fn wt27_pitch_goes_round() {
    let thrust_n = |pitch_deg: f64| {
        let mut machine = windy(WIND_TEXT);
        for blade in 1..=3 {
            let pitch = hinge_mut(&mut machine, &format!("pitch{blade}"));
            (pitch.start_angle_rad, pitch.motor.command_rad) = (pitch_deg.to_radians(), pitch_deg.to_radians());
        }
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).expect("a start");
        plant.step(0.1).expect("a tenth of a second");
        plant.outputs().rotor()[0].thrust_n
    };
    for (one, other) in [(0.0, 360.0), (200.0, -160.0), (-90.0, 270.0)] {
        let pair = [thrust_n(one), thrust_n(other)];
        assert!(pair[0].is_finite() && (pair[0] / pair[1] - 1.0).abs() < 1e-9, "{one} and {other} deg: {pair:?}");
    }
}
