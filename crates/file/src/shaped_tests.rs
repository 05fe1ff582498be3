//! Model files with sections by shape: their machines, errors and warnings.

use crate::shapes::{MATERIALS, NamedMaterial};
use crate::{parse, section_properties, warnings};
use foldwing_engine::math::strain::{FLAP, STRETCH, TWIST};

/// Model file of a beam 1 m long with a section.
fn beam(section: &str) -> String {
    format!(
        "name = \"Beam\"\n[material.foil]\nyoungs_modulus_Pa = 70e9\npoisson_ratio = 0.3\ndensity_kg_m3 = 2700\n[section.spar]\n{section}\n\
         [body.beam]\nlength_m = 1.0\nsection = \"spar\"\nelements = 4\n[joint.mount]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"beam\"\n"
    )
}

const TUBE: &str = "shape = \"tube\"\ndiameter_m = 0.025\nwall_m = 0.0015\nmaterial = \"foil\"";

/// The tube of a sketched wing has the EA, GJ, EI and mass computed by hand, the same with a library material, and the known shear
/// stiffness.
#[test]
fn a_tube_has_the_properties_of_its_ring() {
    let machine = parse(&beam(TUBE), "beam.toml").unwrap_or_else(|error| panic!("{error}"));
    let section = machine.bodies[0].section.at(0.3);
    let (outer, inner): (f64, f64) = (0.0125, 0.011);
    let area = std::f64::consts::PI * (outer * outer - inner * inner);
    let second = 0.25 * std::f64::consts::PI * (outer.powi(4) - inner.powi(4));
    let near = |own: f64, due: f64| assert!((own / due - 1.0).abs() < 1e-12, "{own} for {due}");
    near(section.stiffness[(STRETCH, STRETCH)], 70e9 * area);
    near(section.stiffness[(FLAP, FLAP)], 70e9 * second);
    near(section.stiffness[(TWIST, TWIST)], 70e9 / 2.6 * 2.0 * second);
    near(section.mass_kg_m, 2700.0 * area);
    near(section.second_moment_kg_m[0], 2700.0 * second);
    assert_eq!((section.half_width_m, section.half_height_m), (outer, outer));
    let listed = section_properties(&beam(TUBE));
    assert_eq!((listed.len(), listed[0].body.as_str(), listed[0].sections.len()), (1, "beam", 1));
    let shear = listed[0].sections[0].properties.shear_stiffnesses_n.expect("known");
    // ratio of shear area to area of a thin ring: 0.5 + 0.7 (thickness / radius)²
    assert!((shear[0] / (70e9 / 2.6 * area) - 0.5).abs() < 0.01 && shear[0] == shear[1], "{shear:?}");
}

/// For a tube that tapers to half its diameter, the section properties at each position are those computed from the local dimensions, to
/// 1e-4, and the mass is the integral of the mass per length.
#[test]
fn dimensions_vary_along_the_body() {
    let tapered = TUBE.replace("0.025", "{ table = [[0, 0.04], [0.5, 0.04], [1, 0.02]] }");
    let machine = parse(&beam(&tapered), "beam.toml").unwrap_or_else(|error| panic!("{error}"));
    let law = &machine.bodies[0].section;
    for i in 0..=100 {
        let s_m = 0.01 * f64::from(i);
        let diameter_m = if s_m < 0.5 { 0.04 } else { 0.06 - 0.04 * s_m };
        let due = parse(&beam(&TUBE.replace("0.025", &format!("{diameter_m:?}"))), "beam.toml").expect("a beam");
        let (own, due) = (law.at(s_m), due.bodies[0].section.at(0.0));
        for strain in [STRETCH, TWIST, FLAP] {
            let error = own.stiffness[(strain, strain)] / due.stiffness[(strain, strain)] - 1.0;
            assert!(error.abs() < 1.5e-4, "{error:e} in {strain} at {s_m} m");
        }
        assert!((own.mass_kg_m / due.mass_kg_m - 1.0).abs() < 1.5e-4);
    }
    let mass_kg = 2700.0 * std::f64::consts::PI * 0.0015 * (0.5 * 0.0385 + 0.5 * (0.03 - 0.0015));
    assert!((law.mass_kg(1.0) / mass_kg - 1.0).abs() < 1e-9);
    let places: Vec<f64> = section_properties(&beam(&tapered))[0].sections.iter().map(|section| section.s_m).collect();
    assert_eq!(places, [0.0, 0.5, 1.0]);
    let shorter = beam(&tapered).replace("length_m = 1.0", "length_m = 0.7");
    assert!((parse(&shorter, "beam.toml").expect("a beam").bodies[0].section.mass_kg(0.7) / mass_kg) < 0.8);
}

/// Every shape gives a model with a positive definite section, and solid sections accept materials by name.
#[test]
fn all_shapes_make_models() {
    for section in [
        "shape = \"rectangle\"\nwidth_m = 0.03\nheight_m = 0.003\nmaterial = \"steel S355\"",
        "shape = \"ellipse\"\nwidth_m = 0.03\nheight_m = 0.003\nmaterial = \"foil\"",
        "shape = \"box\"\nwidth_m = 0.03\nheight_m = 0.02\nwall_m = 0.001\nmaterial = \"PLA\"",
        "shape = \"I\"\nwidth_m = 0.03\nheight_m = 0.04\nwall_m = 0.001\nweb_wall_m = 0.002\nmaterial = \"foil\"",
        "shape = \"C\"\nwidth_m = 0.03\nheight_m = 0.04\nwall_m = 0.001\nopen_side = \"-y\"\nmaterial = \"foil\"",
        "shape = \"angle\"\nwidth_m = 0.03\nheight_m = 0.04\nwall_m = 0.001\nmaterial = \"foil\"",
        "shape = \"profile\"\nchord_m = 0.1\naerofoil = \"naca2412\"\nskin_wall_m = 0.0004\nmaterial = \"GFRP E-glass/epoxy quasi-isotropic\"\n\
         [section.spar.spar.main]\nposition = 0.3\nwall_m = 0.001\nmaterial = \"balsa\"",
        "shape = \"profile\"\nchord_m = 0.1\noutline = [[1, 0], [0.5, 0.05], [0, 0], [0.5, -0.05], [1, 0]]\nskin_wall_m = 0.0004\n\
         material = \"foil\"",
        "shape = \"laminate\"\nwidth_m = 0.03\nlayup_deg = [45, -45]\nsymmetric = true\nply_thickness_m = 0.2e-3\nmaterial = \"CFRP AS4/3501-6\"",
        "shape = \"laminate\"\nwidth_m = 0.03\nlayup_deg = [0, 0, 0]\nply_thicknesses_m = [0.2e-3, 2e-3, 0.2e-3]\n\
         ply_materials = [\"foil\", \"Rohacell 51 IG\", \"foil\"]",
    ] {
        let text = beam(section);
        let machine = parse(&text, "beam.toml").unwrap_or_else(|error| panic!("{error}"));
        assert!(machine.bodies[0].section.at(0.0).stiffness.cholesky().is_some(), "{section}");
        let listed = section_properties(&text);
        assert!(listed[0].sections[0].properties.shear_stiffnesses_n.is_some_and(|shear| shear[0] > 0.0), "{section}");
    }
    let named = "shape = \"rectangle\"\nwidth_m = 0.03\nheight_m = 0.003\nmaterial = \"foil\"";
    let stated = "shape = \"rectangle\"\nwidth_m = 0.03\nheight_m = 0.003\nyoungs_modulus_Pa = 70e9\npoisson_ratio = 0.3\ndensity_kg_m3 = 2700";
    let sections =
        [named, stated].map(|section| parse(&beam(section), "beam.toml").expect("a beam").bodies[0].section.clone());
    assert_eq!(sections[0], sections[1]);
}

/// Errors for impossible sections state location, value, allowed values and remedy.
#[test]
fn impossible_sections_are_refused() {
    let profile =
        "shape = \"profile\"\nchord_m = 0.1\naerofoil = \"naca2412\"\nskin_wall_m = 0.0004\nmaterial = \"foil\"";
    let plate =
        "shape = \"laminate\"\nwidth_m = 0.03\nlayup_deg = [0, 45]\nply_thickness_m = 0.2e-3\nmaterial = \"foil\"";
    let frame = "shape = \"box\"\nwidth_m = 0.03\nheight_m = 0.02\nwall_m = 0.001\nmaterial = \"foil\"";
    for (section, due) in [
        (
            TUBE.replace("0.0015", "0.0125"),
            &["spar.wall_m", "0.0125", "< 0.0125 m, half of diameter_m", "\"ellipse\""][..],
        ),
        (TUBE.replace("0.0015", "0.0"), &["spar.wall_m", "0.0", "a finite length > 0 m"]),
        (
            TUBE.replace("0.0015", "{ polynomial = [0.002, -0.003] }"),
            &["spar.wall_m", "-0.001 at s = 1 m of body \"beam\"", "> 0 m"],
        ),
        (
            TUBE.replace("foil", "aluminium 7075"),
            &["spar.material", "did you mean \"aluminium 7075-T6\"?", "[material.<name>]"],
        ),
        (TUBE.replace("foil", "foli"), &["did you mean \"foil\"?"]),
        (TUBE.replace("wall_m", "wall_mm"), &["wall_m"]),
        (TUBE.replace("tube", "tub"), &["did you mean \"tube\"?"]),
        (frame.replace("0.001", "0.01"), &["spar.wall_m", "< 0.01 m, half of height_m", "\"rectangle\""]),
        (format!("{frame}\nweb_wall_m = 0.02"), &["spar.web_wall_m", "0.02", "< 0.015 m, half of width_m"]),
        (profile.replace("naca2412", "e387"), &["spar.aerofoil", "four-digit NACA aerofoil", "outline"]),
        (profile.replace("0.0004", "0.02"), &["spar.skin_wall_m", "0.02", "a skin < "]),
        (
            profile.replace("aerofoil = \"naca2412\"", "outline = [[1, 0.1], [0.5, 0.1], [0, 0], [0.5, -0.1], [1, 0]]"),
            &["spar.outline", "not closed: its ends are 0.1 of the chord apart", "at most 0.05"],
        ),
        (
            format!("{profile}\n[section.spar.spar.rear]\nposition = 0.99\nwall_m = 0.001"),
            &["spar.rear.position", "0.99", "so that the spar lies inside the skin"],
        ),
        (plate.to_owned(), &["spar.layup_deg", "foil"][..1]),
        (
            plate.replace("\"foil\"", "\"CFRP AS4/3501-6\""),
            &["spar.layup_deg", "unbalanced laminate", "opposite angle"],
        ),
        (
            plate.replace("\"foil\"", "\"CFRP AS4/3501-6\"").replace("[0, 45]", "[45, -45]"),
            &["spar.layup_deg", "coupled with shear in its plane", "symmetric = true"],
        ),
        (format!("{plate}\nply_thicknesses_m = [1e-3]"), &["ply_thicknesses_m", "not both"]),
        (plate.replace("ply_thickness_m = 0.2e-3", "ply_thicknesses_m = [1e-3]"), &["an array of 1", "an array of 2"]),
        (
            "shape = \"rectangle\"\nwidth_m = 0.03\nheight_m = 0.003\nmaterial = \"foil\"\ndensity_kg_m3 = 2700"
                .to_owned(),
            &["spar.density_kg_m3", "either material or density and moduli"],
        ),
        (
            "shape = \"rectangle\"\nwidth_m = 0.03\nheight_m = 0.003\npoisson_ratio = 0.3\nyoungs_modulus_Pa = 1e9"
                .to_owned(),
            &["spar.density_kg_m3", "material = \"…\" instead"],
        ),
    ] {
        let isotropic = section == plate;
        match parse(&beam(&section), "beam.toml") {
            // plies of one isotropic material have no couplings
            Ok(_) => assert!(isotropic, "{section}"),
            Err(error) => {
                let text = error.to_string();
                assert!(!isotropic && due.iter().all(|part| text.contains(part)), "{section}\n{text}");
            }
        }
    }
    let fibres = beam(TUBE).replace("poisson_ratio = 0.3", "poisson_ratio = 0.3\ntransverse_youngs_modulus_Pa = 5e9");
    let text = parse(&fibres, "beam.toml").expect_err("no shear modulus").to_string();
    assert!(text.contains("material.foil.shear_modulus_Pa") && text.contains("unidirectional"), "{text}");
    let tapered = beam(TUBE).replace("elements = 4", "elements = 4\nwidth_taper = 0.5");
    let text = parse(&tapered, "beam.toml").expect_err("a taper").to_string();
    assert!(text.contains("{ table = [[s, value], …] } in the section"), "{text}");
}

/// There are warnings for shear deflection, restrained warping and an elastic axis away from the shear centre, but not for a slender tube.
#[test]
fn shapes_beyond_the_beams_have_a_warning() {
    assert_eq!(warnings(&beam(TUBE)), []);
    let short = beam(TUBE).replace("length_m = 1.0", "length_m = 0.2");
    let found = warnings(&short);
    assert!(found.len() == 1 && found[0].key == "section.spar", "{found:?}");
    // 3 EI/(GA L²)
    let properties = &section_properties(&short)[0].sections[0].properties;
    let share = 3.0 * properties.flap_stiffness_n_m2 / (properties.shear_stiffnesses_n.expect("known")[1] * 0.04);
    assert!(
        share > 0.01 && found[0].reason.contains(&format!("{:.1} % of the bending deflection", 100.0 * share)),
        "{found:?}"
    );
    let shear = |stated: &str| short.replace("length_m = 0.2", &format!("length_m = 0.2\n{stated}"));
    for stated in ["shear = true", "shear = false"] {
        assert_eq!(warnings(&shear(stated)), [], "{stated}");
    }
    let channel = beam("shape = \"C\"\nwidth_m = 0.03\nheight_m = 0.04\nwall_m = 0.001\nmaterial = \"foil\"");
    let found = warnings(&channel);
    assert!(found.len() == 1 && found[0].reason.contains("an open section"), "{found:?}");
    let profile =
        beam("shape = \"profile\"\nchord_m = 0.1\naerofoil = \"naca0012\"\nskin_wall_m = 0.0004\nmaterial = \"foil\"")
            .replace("length_m = 1.0", "length_m = 3.0");
    let axis = |fraction: f64| {
        format!(
            "{profile}[aerodynamics]\nmodel = \"strip\"\nwind_m_s = [0, -10, 0]\n[surface.wing]\nbody = \"beam\"\nchord_m = 0.1\n\
             elastic_axis_fraction = {fraction}\nstrips = 4\n"
        )
    };
    let found = warnings(&axis(0.5));
    let wing: Vec<_> = found.iter().filter(|warning| warning.key == "surface.wing.elastic_axis_fraction").collect();
    assert_eq!(wing.len(), 1, "{found:?}");
    let proposed: f64 = wing[0].advice.rsplit(' ').next().and_then(|number| number.parse().ok()).expect("a number");
    assert!((0.2..0.4).contains(&proposed), "{proposed}");
    assert!(
        warnings(&axis(proposed)).iter().all(|warning| !warning.key.starts_with("surface")),
        "the value proposed has no warning"
    );
    let soft = beam(TUBE).replace("70e9", "70.0").replace("2700", "2.7");
    let keys: Vec<String> = warnings(&soft).into_iter().map(|warning| warning.key).collect();
    assert!(
        keys.contains(&"material.foil.youngs_modulus_Pa".to_owned())
            && keys.contains(&"material.foil.density_kg_m3".to_owned())
    );
}

/// The material library in the guide is that of the program, and the guide's models and excerpts of models are valid.
#[test]
fn the_guide_is_true() {
    let guide =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/guide/sections.md")).expect("a page");
    for NamedMaterial { name, material, source } in MATERIALS {
        let digits = |value: f64| -> String { format!("{value:.3e}").parse::<f64>().expect("a number").to_string() };
        let across = material.across.map_or("–".to_owned(), |across| {
            let (along, shear) = (digits(1e-9 * across.youngs_modulus_pa), digits(1e-9 * across.shear_modulus_pa));
            format!("{along}, {}, {shear}", across.poisson_ratio)
        });
        let (young, shear) = (digits(1e-9 * material.youngs_modulus_pa), digits(1e-9 * material.shear_modulus_pa));
        let row = format!("| `{name}` | {young} | {shear} | {} | {across} | {source} |", material.density_kg_m3);
        assert!(guide.contains(&row), "{row}");
    }
    let blocks: Vec<&str> = guide.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    assert_eq!(blocks.len(), 5);
    let mut sections = 0;
    for block in blocks {
        let text = if block.starts_with("name") {
            block.to_owned()
        } else {
            let section = block.split("[section.").nth(1).and_then(|rest| rest.split(']').next());
            let spar = if section.is_none() {
                format!("[section.spar]\n{}\n", TUBE.replace("foil", "my_own"))
            } else {
                String::new()
            };
            format!(
                "name = \"Part\"\n{block}{spar}[body.beam]\nlength_m = 2.0\nsection = {:?}\nelements = 4\n\
                 [joint.mount]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"beam\"\n",
                section.unwrap_or("spar")
            )
        };
        let machine = parse(&text, "guide.toml").unwrap_or_else(|error| panic!("{error}"));
        let listed = section_properties(&text);
        assert_eq!(listed.len(), machine.bodies.len());
        sections += listed.len();
    }
    assert_eq!(sections, 5);
}
