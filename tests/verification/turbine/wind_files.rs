//! Wind of a model file from other files: tables over time, TurbSim's full fields.

use crate::turbine::machine::{WIND_TEXT, with_polars};
use foldwing::aero::rotor::turbulence::Turbulence;
use foldwing::aero::rotor::wind::Source;
use foldwing::config;
use foldwing::machine::{AirOptions, Machine};
use std::path::Path;

/// The example with other lines of `[wind]` that refer to files in a folder.
fn read(wind: &str, folder: &Path) -> Result<(Machine, String), String> {
    let text = format!("{}\n[wind]\nreference_height_m = 90.0\n{wind}\n", with_polars(WIND_TEXT));
    let text = config::with_files(text, folder, "turbine.toml").map_err(|refused| refused.to_string())?;
    let machine = config::parse(&text, "turbine.toml").map_err(|refused| refused.to_string())?;
    Ok((machine, text))
}

fn source(machine: &Machine) -> Source {
    let AirOptions::Rotor(options) = &machine.air.as_ref().expect("air").parts[0].options else { panic!("a rotor") };
    options.features.field.clone().expect("a field").source
}

/// WT-39. A table and a full field from files are included in the text, byte by byte, so that an FMU has them; a field truncated at any
/// byte, a table with a bad line and a missing file are errors with key and file.
#[test]
fn wt39_wind_from_files() {
    let folder = std::env::temp_dir().join(format!("foldwing_wind_{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let turbulence = Turbulence {
        seed: 7,
        mean_m_s: 11.4,
        power_exponent: 0.2,
        standard_deviation_m_s: 1.5,
        reference_height_m: 90.0,
        points: [4, 5],
        spacing_m: [40.0, 35.0],
        planes: 16,
        plane_interval_s: 0.5,
    };
    let bytes = config::write_turbsim(&turbulence.generate().expect("turbulence"), 90.0);
    std::fs::write(folder.join("wind.bts"), &bytes).expect("a file");
    std::fs::write(folder.join("hub.wnd"), "! time speed\n0 8 0 0 0 0.2 0 0\n10 12 5 0.1 0 0.2 0 1\n").expect("a file");

    let (machine, text) = read("field_file = \"wind.bts\"", &folder).unwrap_or_else(|refused| panic!("{refused}"));
    let Source::Box(found) = source(&machine) else { panic!("a box") };
    assert_eq!(*found, config::read_turbsim(&bytes).expect("a field"));
    assert!(!text.contains("wind.bts") && text.contains("field = \""), "the text has the bytes");
    // a text with included files needs no folder
    assert_eq!(config::parse(&text, "turbine.toml").expect("a machine"), machine);

    let table = "table = [[0, 8, 0, 0, 0, 0.2, 0, 0], [10, 12, 5, 0.1, 0, 0.2, 0, 1]]";
    let [by_file, inline] = ["table_file = \"hub.wnd\"", table].map(|line| {
        let (machine, _) =
            read(&format!("reference_length_m = 126.0\n{line}"), &folder).unwrap_or_else(|refused| panic!("{refused}"));
        source(&machine)
    });
    assert_eq!(by_file, inline);

    for length in (0..bytes.len()).step_by(97).chain([bytes.len() - 1]) {
        std::fs::write(folder.join("short.bts"), &bytes[..length]).expect("a file");
        let told = read("field_file = \"short.bts\"", &folder).expect_err("a field cut short");
        for word in ["wind.field_file", "short.bts", "truncated"] {
            assert!(told.contains(word), "{length}: {told}");
        }
    }
    std::fs::write(folder.join("bad.wnd"), "0 8 0 0 0 0.2 0 0\n10 12 5\n").expect("a file");
    for (line, words) in [
        ("reference_length_m = 126.0\ntable_file = \"bad.wnd\"", ["wind.table_file", "bad.wnd", "line 2: 3 columns"]),
        ("field_file = \"none.bts\"", ["wind.field_file", "none.bts", "a readable wind field of TurbSim or Bladed"]),
        ("field_file = \"hub.wnd\"", ["wind.field_file", "hub.wnd", "identifier"]),
        ("field = \"AAAA\"", ["wind.field", "identifier is 0", "a complete file of TurbSim"]),
        (
            "field_from = \"port\"\nfield_file = \"wind.bts\"",
            ["wind.field_from", "a field of TurbSim contains this value", ""],
        ),
        ("field_centre_height_m = 80.0", ["wind.field_centre_height_m", "a wind field of Bladed", ""]),
        ("field = \"A*AA\"", ["wind.field", "base64", "field_file"]),
        ("shear_exponent = 0.2\nfield_file = \"wind.bts\"", ["wind.field", "one of shear_exponent", "turbulence"]),
        ("field = \"AAAA\"\nfield_file = \"wind.bts\"", ["field", "", ""]),
        ("table_file = \"hub.wnd\"", ["wind.reference_length_m", "table", ""]),
    ] {
        let told = read(line, &folder).expect_err(line);
        for word in words {
            assert!(told.contains(word), "{line}: {word:?} is missing in\n{told:.600}");
        }
    }
    // a text alone does not determine the folder of its files
    let text = format!("{}\n[wind]\nreference_height_m = 90.0\nfield_file = \"wind.bts\"\n", with_polars(WIND_TEXT));
    let told = config::parse(&text, "turbine.toml").expect_err("a text alone").to_string();
    assert!(told.contains("a model given as text must have field"), "{told}");
    std::fs::remove_dir_all(folder).expect("a folder");
}

/// WT-66. A Bladed field as written by pyTurbSim: values by height and side are those read in Rust, `field_from` rotates it, its bytes are
/// included in the text; its summary must be consistent; every truncation is rejected with key and file.
#[test]
fn wt66_fields_of_bladed() {
    let folder = std::env::temp_dir().join(format!("foldwing_bladed_{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let bytes = include_bytes!("../../reference/turbine/wind/pyturbsim.wnd");
    std::fs::write(folder.join("wind.wnd"), bytes).expect("a file");
    let expected = |middle_height_m, from_port| {
        config::read_bladed(bytes, config::BladedSettings { middle_height_m, from_port }).expect("a field")
    };
    for (line, field) in [
        ("field_file = \"wind.wnd\"", expected(90.0, true)),
        ("field_centre_height_m = 89.0\nfield_file = \"wind.wnd\"", expected(89.0, true)),
        ("field_from = \"starboard\"\nfield_file = \"wind.wnd\"", expected(90.0, false)),
    ] {
        let (machine, text) = read(line, &folder).unwrap_or_else(|refused| panic!("{refused}"));
        let Source::Box(found) = source(&machine) else { panic!("a box") };
        assert_eq!(*found, field, "{line}");
        assert_eq!(config::parse(&text, "turbine.toml").expect("a machine"), machine, "the text has the bytes");
    }
    for length in (0..bytes.len()).step_by(53).chain([bytes.len() - 1]) {
        std::fs::write(folder.join("short.wnd"), &bytes[..length]).expect("a file");
        let told = read("field_file = \"short.wnd\"", &folder).expect_err("a field cut short");
        for word in ["wind.field_file", "short.wnd", "truncated"] {
            assert!(told.contains(word), "{length}: {told}");
        }
    }
    let mut model_7 = bytes.to_vec();
    model_7[2] = 7;
    std::fs::write(folder.join("kaimal.wnd"), model_7).expect("a file");
    let told = read("field_file = \"kaimal.wnd\"", &folder).expect_err("another model");
    assert!(told.contains("kaimal.wnd") && told.contains("model of turbulence is 7"), "{told}");

    let with_summary = |text: &str, line: &str| {
        std::fs::write(folder.join("wind.sum"), text).expect("a file");
        read(&format!("{line}field_file = \"wind.wnd\""), &folder).map(|_| ())
    };
    let summary = " T Clockwise rotation when looking downwind?\n 89.0 Hub height [m]\n";
    let told = with_summary(summary, "").expect_err("another height");
    assert!(told.contains("89 m by its .sum file") && told.contains("field_centre_height_m = 89.0"), "{told}");
    with_summary(summary, "field_centre_height_m = 89.0\n").expect("what the summary says");
    let told =
        with_summary(summary, "field_centre_height_m = 89.0\nfield_from = \"starboard\"\n").expect_err("another side");
    assert!(told.contains("state field_from = \"port\""), "{told}");
    let told = with_summary("? CLOCKWISE\n", "").expect_err("a summary that cannot be read");
    assert!(told.contains("wind.sum: line 1"), "{told}");
    std::fs::remove_dir_all(folder).expect("a folder");
}
