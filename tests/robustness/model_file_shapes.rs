//! Sections by shape and materials: the whole message of every error.

use crate::model_file::{MODEL, message_of};

/// The section that the cases replace.
const PLATE: &str = "shape = \"rectangle\"\nwidth_m = 0.05\nheight_m = 0.002\ndensity_kg_m3 = 1425.0\nyoungs_modulus_Pa = 2.83e9\n\
                     poisson_ratio = 0.3";

/// The small model with another section of its inner body.
fn with_section(section: &str) -> String {
    assert!(MODEL.contains(PLATE));
    MODEL.replacen(PLATE, section, 1).replacen("z_m = 0.001\n", "", 1)
}

/// Dimensions, materials, outlines, spars and plies that give no valid section.
#[test]
fn sections_by_shape() {
    for (section, due) in [
        (
            "shape = \"tube\"\ndiameter_m = 0.025\nwall_m = 0.0125\nmaterial = \"PLA\"",
            "wing.toml:6: key 'section.plate.wall_m': 0.0125 is not allowed; allowed: a wall > 0 m and < 0.0125 m, half of diameter_m; a solid rod has shape = \"ellipse\"",
        ),
        (
            "shape = \"tube\"\ndiameter_m = 0.025\nwall_m = -0.001\nmaterial = \"PLA\"",
            "wing.toml:6: key 'section.plate.wall_m': -0.001 is not allowed; allowed: a finite length > 0 m",
        ),
        (
            "shape = \"tube\"\ndiameter_m = 0.025\nwall_m = { polynomial = [0.002, -0.02] }\nmaterial = \"PLA\"",
            "wing.toml:6: key 'section.plate.wall_m': -0.001 at s = 0.15 m of body \"inner\" is not allowed; allowed: a finite length > 0 m",
        ),
        (
            "shape = \"tube\"\ndiameter_m = 0.025\nwall_m = 0.0015\nmaterial = \"aluminium 7075\"",
            "wing.toml:7: key 'section.plate.material': \"aluminium 7075\" is not allowed; allowed: a material: a table [material.<name>] or a name of the library in docs/guide/sections.md (did you mean \"aluminium 7075-T6\"?)",
        ),
        (
            "shape = \"tube\"\ndiameter_m = 0.025\nwall_m = 0.0015\nmaterial = \"unobtainium\"",
            "wing.toml:7: key 'section.plate.material': \"unobtainium\" is not allowed; allowed: a material: a table [material.<name>] or one of \"aluminium 2024-T3\", \"aluminium 6061-T6\", \"aluminium 7075-T6\", \"steel 4130\", \"steel S355\", \"steel 304\", \"titanium Ti-6Al-4V\", \"magnesium AZ31B\", \"CFRP AS4/3501-6\", \"CFRP AS4/3501-6 quasi-isotropic\", \"GFRP E-glass/epoxy\", \"GFRP E-glass/epoxy quasi-isotropic\", \"aramid 49/epoxy\", \"balsa\", \"Sitka spruce\", \"PLA\", \"polyamide 12\", \"polycarbonate\", \"Rohacell 51 IG\"",
        ),
        (
            "shape = \"tub\"\ndiameter_m = 0.025\nwall_m = 0.0015\nmaterial = \"PLA\"",
            "wing.toml:4: key 'section.plate.shape': \"tub\" is not allowed; allowed: \"rectangle\" or \"ellipse\" or \"tube\" or \"box\" or \"I\" or \"C\" or \"angle\" or \"profile\" or \"laminate\" or \"explicit\" or \"table\" (did you mean \"tube\"?)",
        ),
        (
            "shape = \"tube\"\ndiameter_m = 0.025\nwall_m = 0.0015\nmaterial = \"PLA\"\nwidth_m = 0.02",
            "wing.toml:8: key 'section.plate.width_m' is unknown; allowed keys: shape, diameter_m, wall_m, material",
        ),
        (
            "shape = \"tube\"\ndiameter_m = 0.025\nwall_m = 0.0015\nyoungs_modulus_Pa = 3e9",
            "wing.toml:3: key 'section.plate.material' is missing; allowed: a text in quotes\nwing.toml:7: key 'section.plate.youngs_modulus_Pa' is unknown; it belongs to [material.<name>] or [section.<name>] with shape = \"rectangle\" or [section.<name>] with shape = \"ellipse\"; allowed keys: shape, diameter_m, wall_m, material",
        ),
        (
            "shape = \"box\"\nwidth_m = 0.03\nheight_m = 0.02\nwall_m = 0.01\nmaterial = \"PLA\"",
            "wing.toml:7: key 'section.plate.wall_m': 0.01 is not allowed; allowed: a wall > 0 m and < 0.01 m, half of height_m; a solid one has shape = \"rectangle\"",
        ),
        (
            "shape = \"box\"\nwidth_m = 0.03\nheight_m = 0.02\nwall_m = 0.001\nmaterial = \"PLA\"\nweb_wall_m = 0.02",
            "wing.toml:9: key 'section.plate.web_wall_m': 0.02 is not allowed; allowed: a wall > 0 m and < 0.015 m, half of width_m; a solid one has shape = \"rectangle\"",
        ),
        (
            "shape = \"box\"\nwidth_m = 0.03\nheight_m = 0.05\nwall_m = 0.016\nmaterial = \"PLA\"",
            "wing.toml:7: key 'section.plate.wall_m': 0.016 is not allowed; allowed: a wall > 0 m and < 0.015 m, half of width_m; a solid one has shape = \"rectangle\"",
        ),
        (
            "shape = \"profile\"\nchord_m = 0.1\naerofoil = \"e387\"\nskin_wall_m = 0.0004\nmaterial = \"PLA\"",
            "wing.toml:6: key 'section.plate.aerofoil': \"e387\" is not allowed; allowed: a four-digit NACA aerofoil \
             such as \"naca2412\"; give the points of any other aerofoil as outline",
        ),
        (
            "shape = \"profile\"\nchord_m = 0.1\naerofoil = \"naca2412\"\nskin_wall_m = 0.02\nmaterial = \"PLA\"",
            "wing.toml:7: key 'section.plate.skin_wall_m': 0.02 is not allowed; allowed: a skin < 0.003199 m, the \
             largest that fits into this outline at chord_m = 0.1; a solid section has shape = \"explicit\"",
        ),
        (
            "shape = \"profile\"\nchord_m = 0.1\nskin_wall_m = 0.0004\nmaterial = \"PLA\"",
            "wing.toml:3: key 'section.plate.aerofoil' is missing; allowed: a four-digit NACA aerofoil such as \
             \"naca2412\", or outline instead",
        ),
        (
            "shape = \"profile\"\nchord_m = 0.1\naerofoil = \"naca2412\"\nskin_wall_m = 0.0004\nmaterial = \"PLA\"\noutline = [[1, 0], [0.5, 0.1], [0, 0], [0.5, -0.1], [1, 0]]",
            "wing.toml:9: key 'section.plate.outline': [[1, 0], [0.5, 0.1], [0, 0], [0.5, -0.1], [1, 0]] is not allowed; allowed: either aerofoil or outline, not both",
        ),
        (
            "shape = \"profile\"\nchord_m = 0.1\noutline = [[1, 0.1], [0.5, 0.1], [0, 0], [0.5, -0.1], [1, 0]]\nskin_wall_m = 0.0004\nmaterial = \"PLA\"",
            "wing.toml:6: key 'section.plate.outline': an outline that is not closed: its ends are 0.1 of the chord apart is not allowed; allowed: first and last point at the trailing edge, at most 0.05 of the chord apart",
        ),
        (
            "shape = \"profile\"\nchord_m = 0.1\noutline = [[1, 0], [0.5, 0.1], [0.5, -0.1], [0, 0], [1, 0]]\nskin_wall_m = 0.0004\nmaterial = \"PLA\"",
            "wing.toml:6: key 'section.plate.outline': an outline that crosses itself or has no area is not allowed; allowed: points [x, z] in order from the trailing edge over one side to the leading edge and back along the other",
        ),
        (
            "shape = \"profile\"\nchord_m = 0.1\naerofoil = \"naca2412\"\nskin_wall_m = 0.0004\nmaterial = \"PLA\"\n[section.plate.spar.rear]\nposition = 0.99\nwall_m = 0.001",
            "wing.toml:10: key 'section.plate.spar.rear.position': 0.99 is not allowed; allowed: a fraction of the \
             chord between 0.004012 and 0.986, so that the spar lies inside the skin",
        ),
        (
            "shape = \"profile\"\nchord_m = 0.1\naerofoil = \"naca2412\"\nskin_wall_m = 0.0004\nmaterial = \"PLA\"\n[section.plate.spar.a]\nposition = 0.3\nwall_m = 0.001\n[section.plate.spar.b]\nposition = 0.3\nwall_m = 0.001\nmaterial = \"Balsa\"",
            "wing.toml:15: key 'section.plate.spar.b.material': \"Balsa\" is not allowed; allowed: a material: a table [material.<name>] or a name of the library in docs/guide/sections.md (did you mean \"balsa\"?)",
        ),
        (
            "shape = \"profile\"\nchord_m = 0.1\naerofoil = \"naca2412\"\nskin_wall_m = 0.0004\nmaterial = \"PLA\"\n[section.plate.spar.a]\nposition = 0.3\nwall_m = 0.001\n[section.plate.spar.b]\nposition = 0.3\nwall_m = 0.001",
            "wing.toml:13: key 'section.plate.spar.b.position': 0.3 is not allowed; allowed: a position that no other \
             spar occupies",
        ),
        (
            "shape = \"laminate\"\nwidth_m = 0.03\nlayup_deg = [0, 45]\nply_thickness_m = 0.2e-3\nmaterial = \"CFRP AS4/3501-6\"",
            "wing.toml:6: key 'section.plate.layup_deg': an unbalanced laminate, which shears in its plane when it is \
             stretched is not allowed; allowed: for each ply at an angle a ply of the same material and thickness at \
             the opposite angle, because coupling with in-plane shear is not modelled",
        ),
        (
            "shape = \"laminate\"\nwidth_m = 0.03\nlayup_deg = [45, -45]\nply_thickness_m = 0.2e-3\nmaterial = \"CFRP AS4/3501-6\"",
            "wing.toml:6: key 'section.plate.layup_deg': a laminate whose bending or twist is coupled with shear in \
             its plane is not allowed; allowed: plies at angles other than 0 and 90 deg symmetric about the mid-plane \
             (symmetric = true), because coupling with in-plane shear is not modelled",
        ),
        (
            "shape = \"laminate\"\nwidth_m = 0.03\nlayup_deg = [0, 45]\nply_thickness_m = 0.2e-3\nmaterial = \"CFRP AS4/3501-6\"\nply_thicknesses_m = [1e-3, 1e-3]",
            "wing.toml:9: key 'section.plate.ply_thicknesses_m': [1e-3, 1e-3] is not allowed; allowed: either ply_thickness_m or ply_thicknesses_m, not both",
        ),
        (
            "shape = \"laminate\"\nwidth_m = 0.03\nlayup_deg = [0, 45]\nply_thicknesses_m = [1e-3]\nmaterial = \"CFRP AS4/3501-6\"",
            "wing.toml:7: key 'section.plate.ply_thicknesses_m': an array of 1 is not allowed; allowed: an array of 2, one for each ply in layup_deg",
        ),
        (
            "shape = \"laminate\"\nwidth_m = 0.03\nlayup_deg = [0, 45]\nply_thicknesses_m = [1e-3, -1e-3]\nmaterial = \"CFRP AS4/3501-6\"",
            "wing.toml:7: key 'section.plate.ply_thicknesses_m': -0.001 is not allowed; allowed: finite lengths > 0 m",
        ),
        (
            "shape = \"laminate\"\nwidth_m = 0.03\nlayup_deg = [0, 45]\nmaterial = \"CFRP AS4/3501-6\"",
            "wing.toml:3: key 'section.plate.ply_thickness_m' is missing; allowed: a finite length > 0 m, or ply_thicknesses_m instead",
        ),
        (
            "shape = \"laminate\"\nwidth_m = 0.03\nlayup_deg = [0, 45]\nply_thickness_m = 0.2e-3\nply_materials = [\"PLA\"]",
            "wing.toml:8: key 'section.plate.ply_materials': an array of 1 is not allowed; allowed: an array of 2, one for each ply in layup_deg",
        ),
        (
            "shape = \"laminate\"\nwidth_m = 0.03\nlayup_deg = [0, 45]\nply_thickness_m = 0.2e-3\nmaterial = \"CFRP AS4/3501-6\"\nply_materials = [\"PLA\", \"PLA\"]",
            "wing.toml:9: key 'section.plate.ply_materials': [\"PLA\", \"PLA\"] is not allowed; allowed: either material or ply_materials, not both",
        ),
        (
            "shape = \"laminate\"\nwidth_m = 0.03\nlayup_deg = [0, 45]\nply_thickness_m = 0.2e-3",
            "wing.toml:3: key 'section.plate.material' is missing; allowed: a material, or ply_materials instead",
        ),
        (
            "shape = \"rectangle\"\nwidth_m = 0.05\nheight_m = 0.002\nmaterial = \"PLA\"\ndensity_kg_m3 = 1000.0",
            "wing.toml:8: key 'section.plate.density_kg_m3': 1000.0 is not allowed; allowed: either material or density and moduli, not both",
        ),
        (
            "shape = \"rectangle\"\nwidth_m = 0.05\nheight_m = 0.002\npoisson_ratio = 0.3",
            "wing.toml:3: key 'section.plate.density_kg_m3' is missing; allowed: a finite density > 0 kg/m³, or material = \"…\" instead\nwing.toml:3: key 'section.plate.youngs_modulus_Pa' is missing; allowed: a finite modulus > 0 Pa, or material = \"…\" instead",
        ),
        (
            "shape = \"rectangle\"\nwidth_m = 0.05\nheight_m = 0.002\nmaterial = \"PLA\"\n[material.own]\nyoungs_modulus_Pa = 1e9\ndensity_kg_m3 = 1000",
            "wing.toml:8: key 'material.own.shear_modulus_Pa' is missing; allowed: a finite modulus > 0 Pa, or poisson_ratio",
        ),
        (
            "shape = \"rectangle\"\nwidth_m = 0.05\nheight_m = 0.002\nmaterial = \"PLA\"\n[material.own]\nyoungs_modulus_Pa = 1e9\ndensity_kg_m3 = 1000\npoisson_ratio = 0.3\nshear_modulus_Pa = 1e9",
            "wing.toml:11: key 'material.own.poisson_ratio': 0.3 is not allowed; allowed: either shear_modulus_Pa or \
             poisson_ratio; both only with transverse_youngs_modulus_Pa",
        ),
        (
            "shape = \"rectangle\"\nwidth_m = 0.05\nheight_m = 0.002\nmaterial = \"PLA\"\n[material.own]\nyoungs_modulus_Pa = 1e9\ndensity_kg_m3 = 1000\npoisson_ratio = 0.3\ntransverse_youngs_modulus_Pa = 1e8",
            "wing.toml:8: key 'material.own.shear_modulus_Pa' is missing; allowed: the shear modulus of a \
             unidirectional material in planes that contain the fibres (G12)",
        ),
        (
            "shape = \"rectangle\"\nwidth_m = 0.05\nheight_m = 0.002\nmaterial = \"PLA\"\n[material.own]\nyoungs_modulus_Pa = 1e9\ndensity_kg_m3 = 1000\nshear_modulus_Pa = 1e9\ntransverse_youngs_modulus_Pa = 1e8",
            "wing.toml:8: key 'material.own.poisson_ratio' is missing; allowed: the major Poisson's ratio of a \
             unidirectional material (nu12)",
        ),
        (
            "shape = \"rectangle\"\nwidth_m = 0.05\nheight_m = 0.002\nmaterial = \"PLA\"\n[material.own]\nyoungs_modulus_Pa = 1e9\ndensity_kg_m3 = 1000\nshear_modulus_Pa = 1e9\npoisson_ratio = 0.5\ntransverse_youngs_modulus_Pa = 1e10",
            "wing.toml:12: key 'material.own.poisson_ratio': 0.5 with transverse_youngs_modulus_Pa = 1e10 is not \
             allowed; allowed: a major Poisson's ratio whose square is less than youngs_modulus_Pa divided by \
             transverse_youngs_modulus_Pa",
        ),
        (
            "shape = \"rectangle\"\nwidth_m = 0.05\nheight_m = 0.002\nmaterial = \"PLA\"\n[material.own]\nyoungs_modulus_Pa = 1e9\ndensity_kg_m3 = 1000\nshear_modulus_Pa = 1e9\ntransverse_shear_modulus_Pa = 1e8",
            "wing.toml:12: key 'material.own.transverse_shear_modulus_Pa': 1e8 is not allowed; allowed: this key only with transverse_youngs_modulus_Pa",
        ),
    ] {
        assert_eq!(message_of(&with_section(section)), due, "{section}");
    }
}

/// Two ways to vary a section given by its shape along a body.
#[test]
fn sections_by_shape_along_a_body() {
    for (section, keys, due) in [
        (
            "shape = \"tube\"\ndiameter_m = 0.025\nwall_m = 0.0015\nmaterial = \"PLA\"",
            "length_m = 0.15\nwidth_taper = 0.5",
            "wing.toml:15: key 'body.inner.width_taper': 0.5 is not allowed; allowed: a body whose section is a rectangle or an ellipse; the dimensions of other shapes vary by { table = [[s, value], …] } in the section",
        ),
        (
            "shape = \"tube\"\ndiameter_m = { polynomial = [0.025, 0.01] }\nwall_m = 0.0015\nmaterial = \"PLA\"",
            "length_m = 0.15\nouter_section = \"plate\"",
            "wing.toml:16: key 'body.inner.section': section \"plate\", whose dimensions vary along the body is not \
             allowed; allowed: sections of constant dimensions, if the body has an outer_section",
        ),
    ] {
        let text = with_section(section).replacen("length_m = 0.15", keys, 1);
        assert_eq!(message_of(&text), due, "{section} with {keys}");
    }
}
