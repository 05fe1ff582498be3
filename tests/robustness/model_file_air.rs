//! Aerodynamics: errors with their whole messages, and the meaning of an accepted file.

use crate::model_file::{MODEL, message_of};
use foldwing::aero::continuous_turbulence::{Component, ContinuousTurbulence, Spectrum};
use foldwing::aero::flow::GustShape;
use foldwing::config;
use foldwing::machine::{AirOptions, Coupling, Machine, WakeModel};
use nalgebra::Vector3;

const AIR: &str = "[aerodynamics]\nmodel = \"uvlm\"\nwind_m_s = [0, -10, 0]\n";
const SURFACE: &str = "[surface.in]\nbody = \"inner\"\nstrips = 4\n";

fn message(lines: &str) -> String {
    message_of(&format!("{MODEL}{lines}"))
}

fn machine(lines: &str) -> Machine {
    config::parse(&format!("{MODEL}{lines}"), "wing.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// By default the chord is the section's width about its axis, and the wind travels one panel per step; free edges are inset by a quarter
/// of a panel, among them the inner body's outer edge, because no surface continues there.
#[test]
fn defaults_of_air() {
    let air = machine(&format!("{AIR}{SURFACE}")).air.expect("air");
    assert_eq!((air.density_kg_m3, air.established), (1.225, true));
    approx::assert_relative_eq!(air.step_s, 0.05 / 4.0 / 10.0, max_relative = 1e-12);
    assert!(matches!(air.coupling, Coupling::Iterated { .. }));
    let AirOptions::Lattice(lattice) = &air.parts[0].options else { panic!("a lattice") };
    assert_eq!((lattice.wake, lattice.wake_rows, lattice.threads), (WakeModel::Prescribed, 100, 1));
    approx::assert_relative_eq!(lattice.core_radius_m, 1e-2 * 0.05 / 4.0, max_relative = 1e-12);
    let surface = &air.surfaces[0];
    approx::assert_relative_eq!(surface.chords[0].leading_m, Vector3::new(0.0, 0.025, 0.0), epsilon = 1e-15);
    approx::assert_relative_eq!(surface.chords[0].trailing_m, Vector3::new(0.0, -0.025, 0.0), epsilon = 1e-15);
    let width = 0.15 / 4.5;
    approx::assert_relative_eq!(surface.positions_m[0], 0.25 * width, max_relative = 1e-12);
    approx::assert_relative_eq!(surface.positions_m[4], 4.25 * width, max_relative = 1e-12);
}

/// In the default step the fastest point of the trailing edge travels one panel relative to the air at the start, whatever moves: wind,
/// flight, a rotating joint. Without motion there is no default.
#[test]
fn default_step_follows_what_moves() {
    let step_s = |joint: &str, wind: &str| {
        let flying = MODEL.replacen("type = \"clamped\"\nparent = \"root\"", &format!("{joint}\nparent = \"root\""), 1);
        let air = AIR.replace("[0, -10, 0]", wind);
        config::parse(&format!("{flying}{air}{SURFACE}"), "wing.toml").map(|machine| machine.air.expect("air").step_s)
    };
    let flies = |y_m_s: i32| format!("type = \"free\"\nstart_velocity_m_s = [0, {y_m_s}, 0]");
    let panel_m = 0.05 / 4.0;
    for (y_m_s, wind, relative_m_s) in [(0, "[0, -10, 0]", 10.0), (40, "[0, 0, 0]", 40.0), (40, "[0, -10, 0]", 50.0)] {
        let step_s = step_s(&flies(y_m_s), wind).expect("a default");
        approx::assert_relative_eq!(step_s, panel_m / relative_m_s, max_relative = 1e-12);
    }
    // about the root at 300 deg/s: the outer end of the surface, 4.25 of 4.5 panels out, 0.025 m behind the axis
    let turns = "type = \"revolute\"\naxis = [0, 0, 1]\nstart_rate_deg_s = 300";
    let reach_m = (0.15 * 4.25 / 4.5_f64).hypot(0.025);
    let expected_s = panel_m / (reach_m * 300f64.to_radians());
    approx::assert_relative_eq!(step_s(turns, "[0, 0, 0]").expect("a default"), expected_s, max_relative = 1e-9);
    assert!(step_s(&flies(-10), "[0, -10, 0]").is_err());
}

/// With a mirror plane at the root and a surface on the next body there are no insets; the strip model has none.
#[test]
fn edges_that_are_not_free() {
    let both = format!("{SURFACE}[surface.out]\nbody = \"outer\"\nstrips = 2\nchord_m = 0.05\n");
    let air = machine(&format!("{AIR}mirror_normal = [2, 0, 0]\n{both}")).air.expect("air");
    assert_eq!((air.surfaces[0].positions_m[0], air.surfaces[0].positions_m[4]), (0.0, 0.15));
    assert_eq!(air.surfaces[1].positions_m[0], 0.0);
    assert!(air.surfaces[1].positions_m[2] < 0.1);
    let strips = machine(&format!("{}{SURFACE}", AIR.replace("uvlm", "strip"))).air.expect("air");
    assert_eq!(strips.surfaces[0].positions_m, [0.0, 0.0375, 0.075, 0.11249999999999999, 0.15]);
}

/// Incidence raises the leading edge towards `+z`, on whichever side it lies.
#[test]
fn incidence_and_leading_edge() {
    for (side, sign) in [("+y", 1.0), ("-y", -1.0)] {
        let more =
            format!("elastic_axis_fraction = 0.25\nchord_m = 0.2\nincidence_deg = 30\nleading_edge = \"{side}\"\n");
        let air = machine(&format!("{AIR}{SURFACE}{more}")).air.expect("air");
        let expected = Vector3::new(0.0, sign * 0.05 * 30_f64.to_radians().cos(), 0.025);
        approx::assert_relative_eq!(air.surfaces[0].chords[1].leading_m, expected, epsilon = 1e-15);
    }
}

#[test]
fn gusts() {
    let gust = "[gust.up]\nshape = \"one_minus_cosine\"\nvelocity_m_s = [0, 0, 2]\nlength_m = 0.5\nstart_s = 0.1\n";
    let air = machine(&format!("{AIR}{SURFACE}{gust}")).air.expect("air");
    assert_eq!(air.gusts[0].shape, GustShape::OneMinusCosine { length_m: 0.5 });
    assert_eq!((air.gusts[0].direction, air.gusts[0].speed_m_s), (-Vector3::y(), 10.0));
    assert_eq!(
        message(&format!("{AIR}{SURFACE}{}", gust.replace("length_m = 0.5\n", ""))),
        "wing.toml:62: key 'gust.up.length_m' is missing; allowed: a finite length > 0 m"
    );
    assert_eq!(
        message(&format!("{AIR}{SURFACE}{}", gust.replace("one_minus_cosine", "sharp_edge"))),
        "wing.toml:65: key 'gust.up.length_m': 0.5 is not allowed; allowed: no length_m with shape = \"sharp_edge\""
    );
    assert_eq!(
        message(&format!("{}{SURFACE}{gust}", AIR.replace("[0, -10, 0]", "[0, 0, 0]\nstep_s = 1e-3"))),
        "wing.toml:63: key 'gust.up.direction' is missing; allowed: an array of 3 finite numbers, not all 0; its default \
         is the direction of wind_m_s"
    );
}

/// Turbulence along and normal to the flight path, its defaults, a table; keys of other shapes and oblique turbulence are rejected.
#[test]
fn gusts_of_turbulence_and_by_a_table() {
    let gust = "[gust.rough]\nshape = \"von_karman\"\nvelocity_m_s = [0, 0, 2]\nscale_m = 0.5\nseed = 7\n";
    let shape = |text: &str| machine(&format!("{AIR}{SURFACE}{text}")).air.expect("air").gusts[0].shape.clone();
    let series = |spectrum, component, seed| {
        let asked =
            ContinuousTurbulence { spectrum, component, scale_m: 0.5, seed, length_m: None, resolution_m: None };
        GustShape::Turbulence(asked.series().expect("a series"))
    };
    assert_eq!(shape(gust), series(Spectrum::VonKarman, Component::Transverse, 7));
    let along = gust.replace("[0, 0, 2]", "[0, 2, 0]").replace("seed = 7\n", "").replace("von_karman", "dryden");
    assert_eq!(shape(&along), series(Spectrum::Dryden, Component::Longitudinal, 0));
    let GustShape::Turbulence(coarse) = shape(&format!("{gust}length_m = 10\nresolution_m = 0.1\n")) else {
        panic!("turbulence")
    };
    assert_eq!((coarse.values.len(), coarse.spacing_m), (128, 10.0 / 128.0));
    let table = "[gust.rough]\nshape = \"table\"\nvelocity_m_s = [0, 0, 2]\ntable = [[0, 0], [0.5, 1], [1, 0]]\n";
    assert_eq!(shape(table), GustShape::Table([[0.0, 0.0], [0.5, 1.0], [1.0, 0.0]].into()));
    for (text, expected) in [
        (
            gust.replace("[0, 0, 2]", "[0, 1, 2]"),
            "wing.toml:64: key 'gust.rough.velocity_m_s': [0, 1, 2] is not allowed; allowed: a velocity parallel or \
             perpendicular to the direction of travel, because the spectra along and across it differ; write one gust \
             for each component, with separate seeds",
        ),
        (
            gust.replace("scale_m = 0.5\n", ""),
            "wing.toml:62: key 'gust.rough.scale_m' is missing; allowed: a finite length > 0 m",
        ),
        (
            format!("{gust}resolution_m = 1e-6\n"),
            "wing.toml:67: key 'gust.rough.resolution_m': 1e-6 is not allowed; allowed: a length > 0 m that is at \
             least length_m / 1048576",
        ),
        (
            gust.replace("von_karman", "sharp_edge"),
            "wing.toml:65: key 'gust.rough.scale_m': 0.5 is not allowed; allowed: this key is only for turbulence \
             (shape = \"dryden\" or \"von_karman\")",
        ),
        (
            table.replace("\"table\"", "\"sharp_edge\""),
            "wing.toml:65: key 'gust.rough.table': [[0, 0], [0.5, 1], [1, 0]] is not allowed; allowed: this key only \
             with shape = \"table\"",
        ),
        (
            format!("{table}length_m = 1\n"),
            "wing.toml:66: key 'gust.rough.length_m': 1 is not allowed; allowed: no length_m with shape = \"table\": \
             the distances are in the rows",
        ),
        (
            table.replace("table = [[0, 0], [0.5, 1], [1, 0]]\n", ""),
            "wing.toml:62: key 'gust.rough.table' is missing; allowed: rows [distance behind the gust front in m, \
             fraction of velocity_m_s]",
        ),
        (
            table.replace("[0.5, 1]", "[1.5, 1]"),
            "wing.toml:65: key 'gust.rough.table': [[0, 0], [1.5, 1], [1, 0]] is not allowed; allowed: 1 to 100000 \
             rows [distance in m, fraction] of finite numbers with ascending distances",
        ),
    ] {
        assert_eq!(message(&format!("{AIR}{SURFACE}{text}")), expected);
    }
}

/// Invalid densities, winds, panels and steps.
#[test]
fn numbers_of_air() {
    let air = |from: &str, to: &str| message(&format!("{AIR}{SURFACE}").replace(from, to));
    assert_eq!(
        air("model = \"uvlm\"\n", "model = \"uvlm\"\ndensity_kg_m3 = -1.2\n"),
        "wing.toml:58: key 'aerodynamics.density_kg_m3': -1.2 is not allowed; allowed: a finite density > 0 kg/m³"
    );
    assert_eq!(
        air("-10", "nan"),
        "wing.toml:58: key 'aerodynamics.wind_m_s': [0, nan, 0] is not allowed; allowed: an array of 3 finite \
         velocities in m/s"
    );
    assert_eq!(
        air("strips = 4", "strips = 0"),
        "wing.toml:61: key 'surface.in.strips': 0 is not allowed; allowed: a whole number from 1 to 1000"
    );
    assert_eq!(
        air("strips = 4", "strips = 4\nchord_m = 0"),
        "wing.toml:62: key 'surface.in.chord_m': 0 is not allowed; allowed: a finite length > 0 m"
    );
    assert_eq!(
        air("strips = 4", "strips = 4\nchord_m = { table = [[0, 0.1], [0.15, 0]] }"),
        "wing.toml:62: key 'surface.in.chord_m': a chord that falls to 0 m on the body is not allowed; allowed: a \
         chord > 0 m all along the body"
    );
    assert_eq!(
        air("wind_m_s = [0, -10, 0]\n", ""),
        "wing.toml:56: key 'aerodynamics.step_s' is missing; allowed: a finite time > 0 s: it has no default if the \
         wing does not move relative to the air at the start"
    );
    assert_eq!(
        air("model = \"uvlm\"\n", "model = \"uvlm\"\nmirror_normal = [0, 0, 0]\n"),
        "wing.toml:58: key 'aerodynamics.mirror_normal': [0, 0, 0] is not allowed; allowed: an array of 3 finite \
         numbers, not all 0"
    );
    assert_eq!(
        message(&format!("{AIR}{SURFACE}polar = [[10, 1, 0, 0], [0, 0, 0, 0]]\n").replace("\"uvlm\"", "\"strip\"")),
        "wing.toml:62: key 'surface.in.polar': [[10, 1, 0, 0], [0, 0, 0, 0]] is not allowed; allowed: rows [angle of \
         attack in deg, lift, drag, moment coefficient] with angles ascending from -180 to 180"
    );
}

/// Surfaces on no body, twice on one, none at all, and without aerodynamics.
#[test]
fn places_of_surfaces() {
    assert_eq!(
        message(&format!("{AIR}{}", SURFACE.replace("inner", "iner"))),
        "wing.toml:60: key 'surface.in.body': \"iner\" is not allowed; allowed: a body: \"inner\" or \"outer\" (did \
         you mean \"inner\"?)"
    );
    assert_eq!(
        message(&format!("{AIR}{SURFACE}{}", SURFACE.replace("surface.in", "surface.again"))),
        "wing.toml:63: key 'surface.again.body': \"inner\" is not allowed; allowed: a body without a surface; this one \
         already has \"in\""
    );
    assert_eq!(
        message(AIR),
        "wing.toml:57: key 'aerodynamics.model': aerodynamics without a surface is not allowed; allowed: at least one table \
         [surface.<name>]"
    );
    assert_eq!(
        message(SURFACE),
        "wing.toml:56: key 'surface.in': a table without [aerodynamics] is not allowed; allowed: a model file with [aerodynamics]"
    );
    // with the model `none` surfaces may remain in the file: loads come from outside
    assert!(machine(&format!("{}{SURFACE}", AIR.replace("uvlm", "none"))).air.is_none());
}

/// A polar in a lattice needs suction, and must not be combined with a speed of sound.
#[test]
fn profiles_that_a_lattice_cannot_take() {
    let air = |keys: &str, profile: &str| {
        message(&format!("[aerodynamics]\nmodel = \"uvlm\"\nwind_m_s = [0, -10, 0]\n{keys}\n{SURFACE}{profile}\n"))
    };
    let polar = "polar = [[-10, -1, 0, 0], [10, 1, 0, 0]]";
    for keys in ["", "leading_edge_suction = false"] {
        let said = air(keys, polar);
        assert!(said.contains("surface.in.polar") && said.contains("leading_edge_suction = true"), "{said}");
    }
    let said = air("leading_edge_suction = true\nspeed_of_sound_m_s = 340", polar);
    assert!(said.contains("surface.in.polar") && said.contains("Mach"), "{said}");
    for profile in
        ["drag_coefficient = 0.01", "zero_lift_angle_deg = -2", "lift_slope_1_rad = { table = [[0, 6], [0.1, 5]] }"]
    {
        let said = air("speed_of_sound_m_s = 340", profile);
        assert!(said.contains("surface.in") && said.contains("only a thin plate"), "{said}");
    }
}

/// A key that the aerodynamic model does not use is rejected: a mirror plane with strips used to be ignored silently. Strips and lattice
/// use those of a profile. Without aerodynamics all may remain in the file.
#[test]
fn keys_that_the_model_of_the_air_does_not_read() {
    let lattice = ["free_wake = true", "wake_rows = 30", "threads = 2"];
    let strips = ["quasi_steady = true", "apparent_mass = false", "indicial = \"fine\"", "tip_loss = \"lifting_line\""];
    let profile =
        ["lift_slope_1_rad = 6", "zero_lift_angle_deg = -2", "moment_coefficient = 0", "drag_coefficient = 0.01"];
    let profile = profile.into_iter().chain(["polar = [[0, 0, 0, 0], [10, 1, 0, 0]]"]);
    let air = |model: &str, key: &str| {
        format!("[aerodynamics]\nmodel = \"{model}\"\nwind_m_s = [0, -10, 0]\n{key}\n{SURFACE}")
    };
    let surface = |model: &str, key: &str| air(model, "") + key + "\n";
    let cases = lattice
        .map(|key| (air("strip", key), "uvlm", air("uvlm", key), air("none", key)))
        .into_iter()
        .chain(strips.map(|key| (air("uvlm", key), "strip", air("strip", key), air("none", key))))
        .chain(
            ["chord_panels = 6"].map(|key| (surface("strip", key), "uvlm", surface("uvlm", key), surface("none", key))),
        );
    for key in profile {
        let suction = "leading_edge_suction = true\n";
        machine(&surface("uvlm", key).replace("wind_m_s", &format!("{suction}wind_m_s")));
        machine(&surface("strip", key));
        assert!(machine(&surface("none", key)).air.is_none());
    }
    for (refused, model, accepted, without) in cases {
        let said = message(&refused);
        let allowed = format!("allowed: this key only with model = {model:?}");
        assert!(said.ends_with(&allowed) && said.lines().count() == 1, "{said}");
        machine(&accepted);
        assert!(machine(&without).air.is_none());
    }
    for (key, value) in [("mirror_normal", "[1, 0, 0]"), ("core_radius_m", "1e-4")] {
        let text = format!("{key} = {value}");
        assert_eq!(
            message(&air("strip", &text)),
            format!(
                "wing.toml:59: key 'aerodynamics.{key}': {value} is not allowed; allowed: this key only with \
                 model = \"uvlm\", or with tip_loss = \"lifting_line\""
            )
        );
        machine(&air("uvlm", &text));
        machine(&air("strip", &format!("{text}\ntip_loss = \"lifting_line\"")));
        assert!(machine(&air("none", &text)).air.is_none());
    }
    assert_eq!(
        message(&air("uvlm", "coupling = \"staggered\"\ncoupling_iterations = 9")),
        "wing.toml:60: key 'aerodynamics.coupling_iterations': 9 is not allowed; allowed: this key only with coupling = \"iterated\""
    );
    for key in ["coupling_tolerance = 1e-5", "coupling_iterations = 9"] {
        let said = message(&air("uvlm", &format!("coupling = \"staggered\"\n{key}")));
        assert!(said.ends_with("allowed: this key only with coupling = \"iterated\""), "{said}");
        machine(&air("uvlm", key));
    }
}

/// A lifting line needs lift that is linear in the downwash, and is used only if requested.
#[test]
fn tip_loss_of_strips() {
    let air = |key: &str, surface: &str| {
        format!("[aerodynamics]\nmodel = \"strip\"\nwind_m_s = [0, -10, 0]\n{key}\n{SURFACE}{surface}\n")
    };
    let strips = |text: &str| match machine(text).air.expect("air").parts[0].options.clone() {
        AirOptions::Strips(strips) => strips,
        AirOptions::Lattice(_) | AirOptions::Rotor(_) | AirOptions::SlenderBody(_) => panic!("no strips"),
    };
    assert_eq!(strips(&air("", "")).tip_loss, None);
    assert_eq!(strips(&air("tip_loss = \"none\"", "")).tip_loss, None);
    let line = strips(&air("tip_loss = \"lifting_line\"\nmirror_normal = [2, 0, 0]", "")).tip_loss.expect("a line");
    assert_eq!(line.mirror_normal, Some(nalgebra::Vector3::x()));
    let said = message(&air("tip_loss = \"lifting_line\"", "polar = [[-10, -1, 0, 0], [10, 1, 0, 0]]"));
    assert!(said.contains("polar") && said.contains("this key only without tip_loss"), "{said}");
    let said = message(&air("tip_loss = \"prandtl\"", ""));
    assert!(said.contains("'aerodynamics.tip_loss'") && said.contains("lifting_line"), "{said}");
}

/// Lift slope and position of the axis along the body; strips use the slope at their middle.
#[test]
fn slope_and_axis_along_the_body() {
    let air =
        |surface: &str| format!("[aerodynamics]\nmodel = \"strip\"\nwind_m_s = [0, -10, 0]\n{SURFACE}{surface}\n");
    let surface = |text: &str| machine(&air(text)).air.expect("air").surfaces.remove(0);
    let plain = surface("lift_slope_1_rad = 5");
    assert_eq!((plain.profile.lift_slope_1_rad, plain.profile.lift_slopes_1_rad.len()), (5.0, 0));
    let (rows, length_m) = (plain.positions_m.clone(), plain.positions_m[plain.positions_m.len() - 1]);
    let sloping = surface(&format!("lift_slope_1_rad = {{ table = [[0.0, 6.0], [{length_m}, 2.0]] }}"));
    let slopes = &sloping.profile.lift_slopes_1_rad;
    assert_eq!(slopes.len(), rows.len() - 1);
    for (slope, edges) in slopes.iter().zip(rows.windows(2)) {
        approx::assert_relative_eq!(*slope, 6.0 - 4.0 * 0.5 * (edges[0] + edges[1]) / length_m, max_relative = 1e-12);
    }
    let leaning = surface(&format!("elastic_axis_fraction = {{ table = [[0.0, 0.25], [{length_m}, 0.5]] }}"));
    let fractions = leaning.chords.iter().map(|chord| chord.leading_m.y / chord.length_m());
    for (fraction, s) in fractions.zip(&rows) {
        approx::assert_relative_eq!(fraction, 0.25 + 0.25 * s / length_m, max_relative = 1e-12);
    }
    let below = message(&air("lift_slope_1_rad = { polynomial = [1.0, -100.0] }"));
    assert!(below.contains("lift_slope_1_rad") && below.contains("a slope >= 0 all along the body"), "{below}");
    let far = message(&air("elastic_axis_fraction = { polynomial = [0.5, 100.0] }"));
    assert!(far.contains("elastic_axis_fraction") && far.contains("from -10 to 10 all along the body"), "{far}");
    let both = message(&air("elastic_axis_fraction = { polynomial = [0.5], table = [[0, 1], [0.1, 1]] }"));
    assert!(both.contains("either polynomial or table, not both"), "{both}");
    assert!(message(&air("lift_slope_1_rad = -1")).contains("lift_slope_1_rad"));
}
