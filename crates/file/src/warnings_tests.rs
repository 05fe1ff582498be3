//! Warnings about properties lost from the files of a model.

use super::*;
use crate::station_file::read_sections;

/// BeamDyn file of a blade with uniform sections: shear stiffnesses in N, axial stiffness in N, then bending stiffnesses about `x` and
/// `y` and torsional stiffness.
fn blade([shear_x, shear_y, axial, about_x, about_y, twist]: [f64; 6]) -> String {
    let diagonal = |values: [f64; 6]| {
        let row = |i: usize| {
            (0..6).map(|j| if i == j { format!(" {}", values[i]) } else { " 0".to_owned() }).collect::<String>()
        };
        (0..6).map(|i| row(i) + "\n").collect::<String>()
    };
    let station = |share: f64| {
        let stiffness = diagonal([shear_x, shear_y, axial, about_x, about_y, twist]);
        format!("{share}\n{stiffness}\n{}\n", diagonal([0.08538, 0.08538, 0.08538, 0.010336, 0.0040972, 0.0144332]))
    };
    format!(
        "------- BEAMDYN V1.00.* INDIVIDUAL BLADE INPUT FILE --------\nbox\n2 station_total\n0 damp_type\n\
         ------ DAMPING COEFFICIENT\nmu1 mu2\n0 0 0 0 0 0\n---- DISTRIBUTED PROPERTIES-----\n{}{}",
        station(0.0),
        station(1.0)
    )
}

/// The composite box beam of the tests of GXBeam and BeamDyn, of length 10, without its couplings: 3 EI/(GA L²) is 4.8 % and 4.6 %, and
/// the warning states the larger value. For twenty times the length it is 0.01 %, without a warning; nor is there one for a file that is
/// not a BeamDyn blade.
#[test]
fn sections_that_lose_shear_are_named() {
    let folder = std::env::temp_dir().join(format!("foldwing-warnings-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let text = blade([38_780.0, 88_560.0, 1_368_170.0, 141_470.0, 59_120.0, 16_960.0]);
    std::fs::write(folder.join("box.dat"), &text).expect("a file");
    let [across_y, across_z] = shear_shares(&read_sections(&text).expect("a blade"), 10.0).expect("with shear");
    let closed = |bending: f64, shear: f64| 3.0 * bending / (shear * 100.0);
    assert!((across_y / closed(141_470.0, 88_560.0) - 1.0).abs() < 1e-12, "{across_y}");
    assert!((across_z / closed(59_120.0, 38_780.0) - 1.0).abs() < 1e-12, "{across_z}");
    let model = |length_m: f64, file: &str| {
        format!(
            "name = \"Box\"\n[section.box]\nshape = \"table\"\nfile = \"{file}\"\n\
             [body.beam]\nlength_m = {length_m:?}\nsection = \"box\"\nelements = 4\n\
             [joint.mount]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"beam\"\n"
        )
    };
    let found = warnings_of_files(&model(10.0, "box.dat"), &folder);
    let longer = warnings_of_files(&model(200.0, "box.dat"), &folder);
    let none = warnings_of_files(&model(10.0, "none.dat"), &folder);
    std::fs::remove_dir_all(&folder).expect("gone");
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((found[0].key.as_str(), found[0].line), ("section.box.file", 4));
    assert!(found[0].reason.contains("4.8 %") && found[0].reason.contains("body beam"), "{found:?}");
    assert_eq!((longer, none), (Vec::new(), Vec::new()));
}

/// The warning for a wind speed in km/h proposes the same speed in m/s, and for a gravity in g or mm/s² the value in m/s².
#[test]
fn warnings_convert_units_correctly() {
    for (km_h, m_s) in [(540.0, "150"), (720.0, "200")] {
        let text = format!(
            "name = \"Fast\"\n[section.plate]\nshape = \"rectangle\"\nwidth_m = 0.1\nheight_m = 0.01\ndensity_kg_m3 = 1000.0\n\
             youngs_modulus_Pa = 1e9\npoisson_ratio = 0.3\n[body.wing]\nlength_m = 1.0\nsection = \"plate\"\nelements = 2\n\
             [joint.mount]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"wing\"\n\
             [aerodynamics]\nmodel = \"strip\"\nwind_m_s = [{km_h:?}, 0, 0]\n[surface.wing]\nbody = \"wing\"\n\
             chord_m = 0.1\nelastic_axis_fraction = 0.5\nstrips = 2\n"
        );
        let found = warnings(&text);
        let wind: Vec<_> = found.iter().filter(|warning| warning.key == "aerodynamics.wind_m_s").collect();
        assert_eq!(wind.len(), 1, "{found:?}");
        let told = format!("{wind:?}");
        assert!(told.contains(&format!("at {km_h} m/s")) && told.contains(&format!("that is {m_s} m/s\"")), "{told}");
    }
}

/// All lengths in millimetres keep their ratios: a body or a section that is larger than any wing has a warning.
#[test]
fn lengths_in_millimetres_have_a_warning_about_their_size() {
    let model = |length_m: f64, width_m: f64, height_m: f64| {
        format!(
            "name = \"Long\"\n[section.plate]\nshape = \"rectangle\"\nwidth_m = {width_m:?}\nheight_m = {height_m:?}\n\
             density_kg_m3 = 1000.0\nyoungs_modulus_Pa = 1e9\npoisson_ratio = 0.3\n[body.wing]\nlength_m = {length_m:?}\n\
             section = \"plate\"\nelements = 2\n[joint.mount]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"wing\"\n"
        )
    };
    let keys = |text: &str| warnings(text).into_iter().map(|warning| (warning.key, warning.advice)).collect::<Vec<_>>();
    let found = keys(&model(800.0, 25.0, 2.0));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].0 == "body.wing.length_m" && found[0].1.starts_with("millimetres? write 0.8,"), "{found:?}");
    let found = keys(&model(200.0, 40.0, 2.0));
    assert_eq!(found, [("section.plate.width_m".to_owned(), "millimetres? write 0.04".to_owned())]);
    assert_eq!(keys(&model(107.0, 5.0, 1.0)), [], "a blade of today");
}

/// A body as long as five times its thickness is flagged for its neglected shear unless the key `shear` is given; one that is thicker than long
/// is no beam at all.
#[test]
fn bodies_that_state_their_shear_have_no_warning_about_it() {
    let model = |length_m: f64, stated: &str| {
        format!(
            "name = \"Thick\"\n[section.plate]\nshape = \"rectangle\"\nwidth_m = 0.1\nheight_m = 0.1\n\
             density_kg_m3 = 1000.0\nyoungs_modulus_Pa = 1e9\npoisson_ratio = 0.3\n[body.wing]\nlength_m = {length_m:?}\n\
             section = \"plate\"\nelements = 2\n{stated}[joint.mount]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"wing\"\n"
        )
    };
    let found = warnings(&model(0.5, ""));
    assert!(
        found.len() == 1 && found[0].advice.contains("shear = true") && found[0].advice.contains("shear = false"),
        "{found:?}"
    );
    for stated in ["shear = true\n", "shear = false\n"] {
        assert_eq!(warnings(&model(0.5, stated)), [], "{stated}");
        let found = warnings(&model(0.09, stated));
        assert!(found.len() == 1 && found[0].reason.contains("no beam"), "{found:?}");
    }
}
