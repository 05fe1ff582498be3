//! Functions along a body: twist, curvatures, tapers, sections between two ends; their meaning and errors.

use crate::model_file::{message, message_of, with};
use foldwing::config;
use foldwing::machine::Machine;

/// The small model with further keys in `[body.inner]`.
fn inner(keys: &str) -> String {
    with("length_m = 0.15", &format!("length_m = 0.15\n{keys}"))
}

fn accepted(text: &str) -> Machine {
    config::parse(text, "wing.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Numbers, polynomials and tables give the specified values.
#[test]
fn natural_strain_along_a_body() {
    let machine = accepted(&inner(
        "twist_1_m = 0.3\ncurvature_y_1_m = { polynomial = [0.1, -2.0, 4] }\n\
         curvature_z_1_m = { table = [[0.05, 1.0], [0.1, 2]] }",
    ));
    let strain = |s: f64| <[f64; 4]>::from(machine.bodies[0].natural_strain.at(s));
    assert_eq!(strain(0.0), [0.0, 0.3, 0.1, 1.0]);
    let found = strain(0.075);
    let expected = [0.0, 0.3, 0.1 - 2.0 * 0.075 + 4.0 * 0.075 * 0.075, 1.5];
    assert!(found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-15), "{found:?}");
    assert_eq!(strain(0.15)[3], 2.0);
}

/// A number is the factor at the tip; the section follows the scaled outline.
#[test]
fn tapers() {
    let text = inner("width_taper = 0.5\nheight_taper = { table = [[0, 1], [0.15, 0.6]] }");
    let section = accepted(&text.replacen("z_m = 0.001\n", "", 1)).bodies[0].section.at(0.15);
    let close = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-14, "{found} {expected}");
    close(section.half_width_m, 0.0125);
    close(section.half_height_m, 0.0006);
    close(section.mass_kg_m, 1425.0 * 0.025 * 0.0012);
    close(section.stiffness[(2, 2)], 2.83e9 * 0.025 * 0.0012f64.powi(3) / 12.0);
}

/// `outer_section`: properties are linear between two sections of any shape; a gauge needs both outlines.
#[test]
fn sections_between_two_ends() {
    let text =
        inner("outer_section = \"spar\"").replacen("[gauge.root]\nbody = \"inner\"", "[gauge.root]\nbody = \"x\"", 1);
    let text = text.replacen("[gauge.root]\nbody = \"x\"\nposition_m = 0.02\nz_m = 0.001\n", "", 1);
    let law = &accepted(&text).bodies[0].section;
    let (a, b) = (law.at(0.0), law.at(0.15));
    assert!((law.at(0.05).mass_kg_m - (2.0 * a.mass_kg_m + b.mass_kg_m) / 3.0).abs() < 1e-15);
    assert_eq!(b.stiffness[(1, 2)], 0.5);
    assert_eq!(
        message_of(&inner("outer_section = \"spar\"")),
        "wing.toml:45: key 'gauge.root.body': \"inner\" is not allowed; allowed: a body whose section has half_width_m \
         and half_height_m"
    );
}

/// A gauge at 45° on the upper face reads half the shear strain due to torsion, `−h k₁ / 2` on a thin plate.
#[test]
fn gauge_directions() {
    let machine = accepted(&with("z_m = 0.001", "z_m = 0.001\ndirection = [1, 1, 0]"));
    let row = machine.gauges[0].row(&machine.bodies[0].section).unwrap();
    assert!((row[1] + 0.001).abs() < 1e-5 * 0.001, "{row}");
    assert!((row[0] - 0.5 * (1.0 - 0.3)).abs() < 1e-12, "{row}");
}

#[test]
fn functions_that_are_none() {
    assert_eq!(
        message_of(&inner("twist_1_m = \"much\"")),
        "wing.toml:17: key 'body.inner.twist_1_m': \"much\" is not allowed; allowed: a finite curvature in 1/m, \
         { polynomial = [c0, c1, …] } or { table = [[s, value], …] }"
    );
    assert_eq!(
        message_of(&inner("twist_1_m = [1, 2]")),
        "wing.toml:17: key 'body.inner.twist_1_m': [1, 2] is not allowed; allowed: a finite curvature in 1/m, \
         { polynomial = [c0, c1, …] } or { table = [[s, value], …] }"
    );
    assert_eq!(
        message_of(&inner("twist_1_m = inf")),
        "wing.toml:17: key 'body.inner.twist_1_m': inf is not allowed; allowed: a finite curvature in 1/m, \
         { polynomial = [c0, c1, …] } or { table = [[s, value], …] }"
    );
    assert_eq!(
        message_of(&inner("twist_1_m = { spline = [1] }")),
        "wing.toml:17: key 'body.inner.twist_1_m.spline' is unknown; allowed keys: polynomial, table"
    );
    assert_eq!(
        message_of(&inner("twist_1_m = {}")),
        "wing.toml:17: key 'body.inner.twist_1_m': an empty table is not allowed; allowed: a table with the key \
         polynomial or the key table"
    );
    assert_eq!(
        message_of(&inner("twist_1_m = { polynomial = [1], table = [[0, 1], [0.1, 2]] }")),
        "wing.toml:17: key 'body.inner.twist_1_m.table': [[0, 1], [0.1, 2]] is not allowed; allowed: either \
         polynomial or table, not both"
    );
    assert_eq!(
        message_of(&inner("twist_1_m = { polynomial = [] }")),
        "wing.toml:17: key 'body.inner.twist_1_m.polynomial': [] is not allowed; allowed: an array of 1 to 100 finite \
         numbers"
    );
    assert_eq!(
        message_of(&inner("twist_1_m = { polynomial = [1, nan] }")),
        "wing.toml:17: key 'body.inner.twist_1_m.polynomial': [1, nan] is not allowed; allowed: an array of 1 to 100 \
         finite numbers"
    );
}

#[test]
fn tables_that_do_not_fit_the_body() {
    assert_eq!(
        message_of(&inner("twist_1_m = { table = [[0, 1]] }")),
        "wing.toml:17: key 'body.inner.twist_1_m.table': [[0, 1]] is not allowed; allowed: at least 2 rows [s in m, \
         value] of finite numbers"
    );
    assert_eq!(
        message_of(&inner("twist_1_m = { table = [[0, 1], [0.1]] }")),
        "wing.toml:17: key 'body.inner.twist_1_m.table': [[0, 1], [0.1]] is not allowed; allowed: at least 2 rows \
         [s in m, value] of finite numbers"
    );
    for rows in ["[[0.1, 1], [0, 2]]", "[[0, 1], [0, 2]]", "[[0, 1], [0.2, 2]]", "[[-0.1, 1], [0.1, 2]]"] {
        assert_eq!(
            message_of(&inner(&format!("twist_1_m = {{ table = {rows} }}"))),
            format!(
                "wing.toml:17: key 'body.inner.twist_1_m.table': {rows} is not allowed; allowed: rows [s, value] with \
                 s ascending from 0 to at most 0.15 m, the body's length"
            )
        );
    }
}

/// Half a revolution per element is the limit, wherever along the body it is reached.
#[test]
fn curvatures_that_an_element_cannot_hold() {
    assert_eq!(
        message_of(&inner("curvature_y_1_m = { polynomial = [0, 300] }")),
        "wing.toml:17: key 'body.inner.curvature_y_1_m': a curvature of 45.0000 1/m at 0.15 m is not allowed; allowed: \
         curvatures of a magnitude < 41.8879 1/m, which is half a revolution per element"
    );
    assert_eq!(
        message_of(&inner("curvature_y_1_m = -42")),
        "wing.toml:17: key 'body.inner.curvature_y_1_m': -42 is not allowed; allowed: curvatures of a magnitude < \
         41.8879 1/m, which is half a revolution per element"
    );
    assert_eq!(
        message_of(&inner("natural_curvature_1_m = [0, 0, 1]\ntwist_1_m = 1")),
        "wing.toml:18: key 'body.inner.twist_1_m': 1 is not allowed; allowed: either natural_curvature_1_m or \
         twist_1_m, curvature_y_1_m and curvature_z_1_m, not both"
    );
}

#[test]
fn tapers_that_leave_no_section() {
    assert_eq!(
        message_of(&inner("width_taper = 0")),
        "wing.toml:17: key 'body.inner.width_taper': 0 is not allowed; allowed: a finite factor > 0"
    );
    assert_eq!(
        message_of(&inner("height_taper = { polynomial = [1, -10] }")),
        "wing.toml:17: key 'body.inner.height_taper': a factor that falls to -0.5 on the body is not allowed; \
         allowed: a factor > 0 all along the body"
    );
    // the gauge of the body would be outside its section, whose height is not checked further
    assert_eq!(
        message_of(&inner("height_taper = { table = [[0, 0.5], [0.15, -0.5]] }")),
        "wing.toml:17: key 'body.inner.height_taper': a factor that falls to -0.5 on the body is not allowed; \
         allowed: a factor > 0 all along the body"
    );
    assert_eq!(
        message_of(&inner("height_taper = { table = [[0, 1], [0.15, 1e-200]] }")),
        "wing.toml:17: key 'body.inner.height_taper': a section of such dimensions is not allowed; allowed: factors \
         that leave mass, inertia and stiffness positive, finite numbers in SI"
    );
    assert_eq!(
        message_of(&inner("outer_section = \"plate\"\nheight_taper = 0.5")),
        "wing.toml:18: key 'body.inner.height_taper': 0.5 is not allowed; allowed: either outer_section or width_taper \
         and height_taper, not both"
    );
    assert_eq!(
        message_of(&inner("outer_section = \"plat\"")),
        "wing.toml:17: key 'body.inner.outer_section': \"plat\" is not allowed; allowed: a section: \"plate\" or \
         \"spar\" (did you mean \"plate\"?)"
    );
    assert_eq!(
        message("length_m = 0.1\n", "length_m = 0.1\nwidth_taper = 0.5\n"),
        "wing.toml:22: key 'body.outer.width_taper': 0.5 is not allowed; allowed: a body whose section is a rectangle \
         or an ellipse; other sections vary by outer_section"
    );
}

#[test]
fn gauges_off_the_tapered_section_or_without_direction() {
    assert_eq!(
        message_of(&inner("height_taper = 0.5").replacen("position_m = 0.02", "position_m = 0.15", 1)),
        "wing.toml:47: key 'gauge.root.z_m': 0.001 is not allowed; allowed: a point on the section: |y| <= 0.025 m, \
         |z| <= 0.0005 m"
    );
    assert_eq!(
        message("z_m = 0.001", "z_m = 0.001\ndirection = [0, 0, 0]"),
        "wing.toml:47: key 'gauge.root.direction': [0, 0, 0] is not allowed; allowed: an array of 3 finite numbers, \
         not all 0"
    );
    let unknown = with("poisson_ratio = 0.3", "torsional_rigidity_N_m2 = 0.1");
    assert_eq!(
        message_of(&unknown.replacen("z_m = 0.001", "z_m = 0.001\ndirection = [0, 1, 0]", 1)),
        "wing.toml:47: key 'gauge.root.direction': [0, 1, 0] is not allowed; allowed: the axis, [1, 0, 0], on a \
         section that is not a rectangle or an ellipse with shear_modulus_Pa or poisson_ratio"
    );
}
