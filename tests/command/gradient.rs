//! `foldwing gradient`: the table, names of results and numbers, and errors.

use crate::command_line::{foldwing, succeeds};

const WING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/folding_wing.toml");
const TUNNEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/folding_wing_in_tunnel.toml");
const GOLAND: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models/goland_wing.toml");

fn json(arguments: &[&str]) -> serde_json::Value {
    let mut all = vec!["gradient", WING, "--json"];
    all.extend(arguments);
    serde_json::from_str(&succeeds(&foldwing(&all))).unwrap()
}

/// The derivative of the latch time with respect to the motor's stiffness equals that of an independent prototype, −2.6455669 s/(N·m/rad),
/// within the effect of different steps at the tolerance of 1e-4. The table has a line per number, with the change per one per cent.
#[test]
fn the_latch_time_has_the_slope_of_the_prototype() {
    let text = succeeds(&foldwing(&["gradient", WING, "--of", "fold.latch_time", "--by", "fold.motor_stiffness"]));
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].starts_with("FoldingWing: derivatives of the run from 0 to 0.4 s, "), "{text}");
    assert!(lines[1].starts_with("fold.latch_time = 0.12217") && lines[1].contains(" s at 0.12217"), "{text}");
    let row: Vec<&str> = lines[3].split_whitespace().collect();
    assert_eq!(row[..3], ["fold.motor_stiffness", "0.026", "N.m/rad"], "{text}");
    let [slope, per_cent]: [f64; 2] = [row[3].parse().unwrap(), row[4].parse().unwrap()];
    assert!((slope + 2.6455669).abs() < 1e-4 * 2.6455669, "{text}");
    assert!((per_cent - 0.01 * 0.026 * slope).abs() < 1e-5 * per_cent.abs(), "{text}");
}

/// The strain of largest magnitude is negative: 5.3e-3 in compression at 0.1926 s, after latching. Its derivative, the only result of the
/// three available there, is that of the output at this instant.
#[test]
fn the_peak_strain_has_a_slope() {
    let by = ["--by", "file:section.plate.youngs_modulus_Pa"];
    let found = json(&[&["--of", "peak(gauge.root.strain),min(gauge.root.strain)"][..], &by].concat());
    let [peak, least] = [0, 1].map(|row| found["of"][row].clone());
    let value = peak["value"].as_f64().unwrap();
    assert!((value + 5.304e-3).abs() < 2e-6, "{found}");
    for key in ["value", "time_s"] {
        let [peak, least] = [&peak, &least].map(|own| own[key].as_f64().unwrap());
        assert!((peak - least).abs() < 1e-6 * least.abs(), "{found}");
    }
    let at = format!("gauge.root.strain@{}", peak["time_s"].as_f64().unwrap());
    let there = json(&[&["--of", &at][..], &by].concat());
    let [slope, known] = [&peak, &there["of"][0]].map(|own| own["derivatives"][0].as_f64().unwrap());
    assert!((slope - known).abs() < 1e-9 * known.abs() && slope > 0.0, "{slope} and {known}");
}

/// For planar bending, the stiffness varies with the cube of a rectangle's height and the mass linearly: `h ∂/∂h = 3 E ∂/∂E + ρ ∂/∂ρ` for
/// the tip, apart from the effect of axial stiffness and rotary inertia of the sections, (h/ℓ)² = 2e-4.
#[test]
fn numbers_of_a_section_have_the_slopes_of_its_stiffness() {
    let keys = ["height_m", "youngs_modulus_Pa", "density_kg_m3"].map(|key| format!("file:section.plate.{key}"));
    let found = json(&["--of", "tip.position.z@0.08,fold.latch_time", "--by", &keys.join(",")]);
    for row in 0..2 {
        let [height, modulus, density] = [0, 1, 2].map(|column| {
            found["by"][column]["value"].as_f64().unwrap() * found["of"][row]["derivatives"][column].as_f64().unwrap()
        });
        let sum = 3.0 * modulus + density;
        assert!((height - sum).abs() < 2e-3 * (3.0 * modulus.abs() + density.abs()), "{found}: {height} and {sum}");
    }
}

/// The derivative of the latch time with respect to a length, whose effect on the motion is not polynomial, against runs with other lengths
/// at a tight tolerance: 1e-4 is more than the error of the latch times divided by the differences. The strains are damped: without
/// damping, fast axial vibrations cause fluctuations of the latch time, 5e-4 of the derivative for a change of 0.1 %.
#[test]
fn the_slope_by_a_length_is_that_of_runs_with_other_lengths() {
    let model = std::fs::read_to_string(WING)
        .unwrap()
        .replace("mass_damping_1_s", "stiffness_damping_s = 1e-4\nmass_damping_1_s");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wing.toml");
    let run = |length: &str| -> (f64, f64) {
        let (inner, outer) = model.split_once("[body.outer]").unwrap();
        assert!(outer.contains("length_m = 0.15"));
        let changed =
            format!("{inner}[body.outer]{}", outer.replacen("length_m = 0.15", &format!("length_m = {length}"), 1));
        std::fs::write(&path, changed).unwrap();
        let arguments =
            ["gradient", path.to_str().unwrap(), "--of", "fold.latch_time", "--by", "file:body.outer.length_m"];
        let output =
            foldwing(&[&arguments[..], &["--set", "solver.tolerance=1e-7", "--stop", "0.13", "--json"]].concat());
        let found: serde_json::Value = serde_json::from_str(&succeeds(&output)).unwrap();
        (found["of"][0]["value"].as_f64().unwrap(), found["of"][0]["derivatives"][0].as_f64().unwrap())
    };
    let ((before, _), (_, slope), (behind, _)) = (run("0.14985"), run("0.15"), run("0.15015"));
    let known = (behind - before) / 3e-4;
    assert!((slope - known).abs() < 1e-4 * known.abs(), "{slope} and {known}");
}

/// Vectors, patterns, lists and entries of arrays represent their parts; a damping of zero has a one-sided derivative; numbers whose steps
/// would leave their range on both sides are rejected.
#[test]
fn results_and_numbers_are_named_like_variables_and_keys() {
    let found = json(&[
        "--of",
        "tip.position@0.05,max(fold.angular_velocity)",
        "--by",
        "load.outer[4].force.*,file:gravity_m_s2.0",
        "--stop",
        "0.06",
    ]);
    let names = |part: &str| -> Vec<String> {
        found[part].as_array().unwrap().iter().map(|own| own["name"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(
        names("of"),
        ["tip.position.x@0.05", "tip.position.y@0.05", "tip.position.z@0.05", "max(fold.angular_velocity)"]
    );
    assert_eq!(names("by")[..3], ["x", "y", "z"].map(|axis| format!("load.outer[4].force.{axis}")));
    assert_eq!((&names("by")[3][..], found["by"][3]["value"].as_f64()), ("file:gravity_m_s2.0", Some(-9.8)));
    assert_eq!(found["mode"], "forward");
    // the wing moves in the x–z plane: the load along y, and its position, have no effect
    let slope = |row: usize, column: usize| found["of"][row]["derivatives"][column].as_f64().unwrap();
    assert!(slope(0, 1).abs() < 1e-12 && slope(2, 0).abs() > 1e-3 && slope(0, 2).abs() > 1e-3);
    let found =
        json(&["--of", "fold.angle", "--by", "fold.motor_damping", "--set", "fold.motor_damping=0", "--stop", "0.05"]);
    assert!(found["of"][0]["derivatives"][0].as_f64().unwrap() > 0.0, "damping holds the wing back: {found}");
    // what trigonometric functions leave of a zero is no size of a step
    let [of_zero, of_tiny] = ["0", "1e-15"].map(|value| {
        let set = format!("fold.external_torque={value}");
        let found = json(&["--of", "fold.angle", "--by", "fold.external_torque", "--set", &set, "--stop", "0.05"]);
        found["of"][0]["derivatives"][0].as_f64().unwrap()
    });
    assert!((of_tiny / of_zero - 1.0).abs() < 1e-6, "{of_tiny} and {of_zero}");
}

/// Every error gives the option, the name and the cause.
#[test]
fn what_has_no_gradient_is_refused_by_name() {
    let cases: [(&[&str], &str, i32); 17] = [
        (&["--of", "fold.angel", "--by", "fold.motor_damping"], "--of fold.angel: no real output is named", 2),
        (&["--of", "fold.latched", "--by", "fold.motor_damping"], "--of fold.latched", 2),
        (
            &["--of", "fold.angle@0.5", "--by", "fold.motor_damping"],
            "the time 0.5 s is not within the run, 0 to 0.4 s",
            2,
        ),
        (
            &["--of", "mean(energy.work)", "--by", "fold.motor_damping"],
            "gradients do not cover means of energy accounts; choose their values at times, or use finite differences",
            3,
        ),
        (&["--of", "fold.angle", "--by", "fold.release"], "--by fold.release", 2),
        (
            &["--of", "fold.angle", "--by", "fold.motor_damping,fold.motor_damping"],
            "fold.motor_damping: is named twice",
            2,
        ),
        (&["--of", "fold.angle", "--by", "file:body.inner.elements"], "a whole number", 2),
        (&["--of", "fold.angle", "--by", "file:body.inner"], "is a table; name one of its keys", 2),
        (&["--of", "fold.angle", "--by", "file:body.inner.colour"], "has no key `colour` there", 2),
        (&["--of", "fold.angle", "--by", "file:gravity_m_s2"], "is an array; name one of its 3 entries", 2),
        (&["--of", "fold.angle", "--by", "file:name"], "--by file:name: is not a number", 2),
        (&["--of", "fold.angle", "--by", "solver.tolerance"], "is a setting of the integrator", 2),
        (&["--of", "fold.angle", "--by", "file:simulation.stop_time_s"], "is a setting of the run", 2),
        (&["--of", "fold.angle", "--by", "file:aerodynamics.coupling_tolerance"], "is a setting of the coupling", 2),
        (
            &["--of", "fold.angle", "--by", "fold.motor_damping", "--stop", "0"],
            "--stop 0: must be after the start time",
            2,
        ),
        (
            &["--of", "fold.latch_time", "--by", "fold.motor_damping", "--stop", "0.1"],
            "closing of the latch of joint fold",
            3,
        ),
        (
            &["--of", "max(fold.angular_velocity)", "--by", "fold.motor_damping", "--set", "fold.motor_damping=-1"],
            "--set",
            2,
        ),
    ];
    for (arguments, words, code) in cases {
        let mut all = vec!["gradient", WING];
        all.extend(arguments);
        let output = foldwing(&all);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
        assert!(message.contains(words), "{arguments:?}: {message}");
    }
    let output = foldwing(&["gradient", TUNNEL, "--of", "tip.position.z", "--by", "aero.density"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("gradients do not cover the vortex lattice (aerodynamics)"), "{message}");
}

/// Derivatives of the tip height of a wing in a gust with respect to the air density, an input and a key, against runs with 5 % more and
/// less: 1e-2 allows for nonlinearity and for loads that agree to 1e-4.
#[test]
fn a_wing_in_air_has_gradients() {
    let run = |more: &[&str]| -> serde_json::Value {
        let by = "aero.density,file:aerodynamics.density_kg_m3";
        let arguments = ["gradient", GOLAND, "--of", "tip.position.z@0.1", "--by", by, "--stop", "0.1", "--json"];
        serde_json::from_str(&succeeds(&foldwing(&[&arguments[..], more].concat()))).unwrap()
    };
    let value = |density: &str| run(&["--set", density])["of"][0]["value"].as_f64().unwrap();
    let known = (value("aero.density=1.28625") - value("aero.density=1.16375")) / 0.1225;
    let found = run(&[]);
    for number in 0..2 {
        let slope = found["of"][0]["derivatives"][number].as_f64().unwrap();
        assert!(known != 0.0 && (slope - known).abs() < 1e-2 * known.abs(), "{slope} and {known}");
    }
}

/// GR-109. The shipped turbines with modal bodies in wind, those with a generator at 10 rpm, below its table: forward and adjoint agree, and both
/// with differences over 5 mm/s of wind, in which hardly a section passes a row of its polar. The runs choose their steps: 1.2e-4 found.
#[test]
fn the_shipped_turbines_have_gradients() {
    let folder = tempfile::tempdir().unwrap();
    let turbines = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/turbine");
    for model in ["nrel_5mw_reduced", "nrel_5mw_wind", "nrel_5mw_strain"] {
        let text = std::fs::read_to_string(format!("{turbines}/{model}.toml")).unwrap();
        let slow = text.replace("start_rate_deg_s = 72.6", "start_rate_deg_s = 60.0");
        assert_eq!(text == slow, model == "nrel_5mw_reduced");
        let path = folder.path().join(format!("{model}.toml"));
        std::fs::write(&path, slow.replace("file = \"", &format!("file = \"{turbines}/"))).unwrap();
        let run = |more: &[&str]| -> serde_json::Value {
            let (of, by) = (
                "energy.kinetic@0.5,energy.elastic@0.5",
                "wind.velocity.x,file:modal_body.tower.flap_damping_ratios.0",
            );
            let arguments = ["gradient", path.to_str().unwrap(), "--of", of, "--by", by, "--stop", "0.5", "--json"];
            serde_json::from_str(&succeeds(&foldwing(&[&arguments[..], more].concat()))).unwrap()
        };
        let [forward, adjoint] = ["forward", "adjoint"].map(|mode| run(&["--mode", mode]));
        let wind_m_s = forward["by"][0]["value"].as_f64().unwrap();
        let [above, below] = [5e-3, -5e-3]
            .map(|shift| run(&["--mode", "forward", "--set", &format!("wind.velocity.x={}", wind_m_s + shift)]));
        for row in 0..2 {
            let slope =
                |found: &serde_json::Value, column: usize| found["of"][row]["derivatives"][column].as_f64().unwrap();
            for column in 0..2 {
                let [one, other] = [&forward, &adjoint].map(|found| slope(found, column));
                assert!(one != 0.0 && (one - other).abs() < 1e-8 * one.abs(), "{model}: {one} and {other}");
            }
            let [above, below] = [&above, &below].map(|found| found["of"][row]["value"].as_f64().unwrap());
            let (own, known) = (slope(&forward, 0), (above - below) / 1e-2);
            println!("GR-109 {model} {row}: {own:e} and {known:e}");
            assert!((own - known).abs() < 5e-4 * known.abs(), "{model}: {own:e} and {known:e}");
        }
    }
}

/// A sweep can also vary entries of arrays of the model file.
#[test]
fn a_sweep_varies_an_entry_of_an_array() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.csv");
    let sweep = |key: &str| {
        let out = out.to_str().unwrap();
        foldwing(&["sweep", WING, "--vary", key, "--stop", "0.01", "--variables", "root.force.x", "-o", out])
    };
    succeeds(&sweep("file:gravity_m_s2.0=-9.8,0"));
    let table = std::fs::read_to_string(&out).unwrap();
    assert_eq!(table.lines().count(), 3, "{table}");
    let refused = sweep("file:gravity_m_s2.3=1");
    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(message.contains("3 is not an index of the array, which has 3 entries; indices start at 0"), "{message}");
}

/// Inputs over time: the value in each row is a number, as are both values of a jump. The sum of the derivatives with respect to all rows
/// is that with respect to the input, if it is constant; values after the latch has closed have no effect on its time.
#[test]
fn values_of_inputs_over_time_are_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("push.csv");
    let table = table.to_str().unwrap();
    std::fs::write(table, "time,fold.external_torque,fold.release\n0,0.01,1\n0.05,0.01,1\n0.05,0.01,1\n0.1,0.01,1\n0.2,0.01,1\n0.3,0.01,1\n")
        .unwrap();
    let of = ["--of", "fold.latch_time"];
    let rows = json(&[&of[..], &["--by", "fold.external_torque@*", "--inputs", table]].concat());
    let names: Vec<&str> = rows["by"].as_array().unwrap().iter().map(|by| by["name"].as_str().unwrap()).collect();
    let times = ["0.0", "0.05-", "0.05+", "0.1", "0.2", "0.3"];
    assert_eq!(names, times.map(|time| format!("fold.external_torque@{time}")));
    let slopes: Vec<f64> =
        rows["of"][0]["derivatives"].as_array().unwrap().iter().map(|slope| slope.as_f64().unwrap()).collect();
    let whole = json(&[&of[..], &["--by", "fold.external_torque", "--set", "fold.external_torque=0.01"]].concat());
    let whole = whole["of"][0]["derivatives"][0].as_f64().unwrap();
    // the steps end at the rows and differ at the tolerance of 1e-4
    assert!((slopes.iter().sum::<f64>() - whole).abs() < 1e-3 * whole.abs(), "{slopes:?} and {whole}");
    assert_eq!(slopes[5], 0.0, "after the latch");
    let one = json(&[&of[..], &["--by", "fold.external_torque@0.05+", "--inputs", table]].concat());
    let one = one["of"][0]["derivatives"][0].as_f64().unwrap();
    assert!((one - slopes[2]).abs() < 1e-8 * one.abs(), "{one} and {}", slopes[2]);

    let refused = |by: &str, cause: &str| {
        let output = foldwing(&["gradient", WING, "--of", "fold.latch_time", "--by", by, "--inputs", table]);
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && text.contains(cause), "{by}: {text}");
    };
    refused("fold.external_torque@0.05", "two rows are at 0.05 s, a jump; 0.05- is the value before it");
    refused("fold.external_torque@0.07", "no row is at 0.07 s; the nearest is at 0.05 s");
    refused("fold.external_torque@0.1+", "one row is at 0.1 s; leave out the sign");
    refused("fold.external_torque@0.1,fold.external_torque@*", "is named twice");
    refused("fold.external_torque", "varies over time");
    refused("fold.release@0.1", "is not a real number");
    refused("load.outer[4].force.z@0.1", "is not among the inputs over time, fold.external_torque");
}

/// GR-31. The figure has a cell for each number and result: the change in % for 1 % of the number, from the printed derivatives; a file of
/// of other origin is not overwritten, which is an error before the run.
#[test]
fn the_figure_has_relative_slopes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().to_str().unwrap();
    let of = "fold.latch_time,max(gauge.root.strain),tip.position.y";
    let words = ["--of", of, "--by", "fold.motor_stiffness,fold.external_torque", "--plot", path];
    let found = json(&words);
    let slope = found["of"][0]["derivatives"][0].as_f64().unwrap() * 0.026 / found["of"][0]["value"].as_f64().unwrap();
    let svg = std::fs::read_to_string(folder.path().join("gradient.svg")).unwrap();
    assert!(svg.contains(&format!("{slope:.2}").replace('-', "−")), "{slope}: {svg}");
    // a number or a result of zero has no relative derivative: the torque's three cells and the tip's other one
    assert_eq!(svg.matches("\n–\n").count() + svg.matches(">–<").count(), 4, "{svg}");
    assert!(folder.path().join("gradient.png").exists());
    std::fs::write(folder.path().join("gradient.svg"), "mine").unwrap();
    let refused = foldwing(&[&["gradient", WING][..], &words].concat());
    assert_eq!(refused.status.code(), Some(4));
    assert_eq!(std::fs::read_to_string(folder.path().join("gradient.svg")).unwrap(), "mine");
}

/// GR-44: a mass on a spring, on a support that moves by a polynomial or a table. The derivative of its relative displacement with respect
/// to the quadratic coefficient is `−2 (1 − cos ωt)/ω²`; a shift has no effect: the derivative with respect to the constant coefficient and
/// the sum of those with respect to all rows of the table are zero. The time of a row cannot be a parameter, which is an error.
#[test]
fn coefficients_and_rows_of_a_prescribed_motion_are_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let model = |name: &str, motion: &str| {
        let body = |name: &str| {
            format!("[rigid_body.{name}]\nmass_kg = 0.8\ninertia_kg_m2 = [0.01, 0.01, 0.01, 0.0, 0.0, 0.0]\n")
        };
        let joint = |name: &str, parent: &str, child: &str| {
            format!(
                "[joint.{name}]\ntype = \"prismatic\"\nparent = \"{parent}\"\nchild = \"{child}\"\naxis = [0.0, 0.0, 1.0]\n"
            )
        };
        let text = format!(
            "name = \"Shaker\"\ngravity_m_s2 = [0.0, 0.0, 0.0]\n{}{}{}motion = \"prescribed\"\n{motion}\n{}[joint.slide.spring]\n\
             stiffness_N_m = 30.0\n[solver]\ntolerance = 1e-10\n",
            body("support"),
            body("mass"),
            joint("track", "root", "support"),
            joint("slide", "support", "mass"),
        );
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let slopes = |model: &str, by: &str| -> Vec<f64> {
        let words = ["gradient", model, "--of", "slide.position@0.2", "--by", by, "--stop", "0.3", "--json"];
        let found: serde_json::Value = serde_json::from_str(&succeeds(&foldwing(&words))).unwrap();
        found["of"][0]["derivatives"].as_array().unwrap().iter().map(|slope| slope.as_f64().unwrap()).collect()
    };
    let polynomial = model("polynomial.toml", "polynomial_m = [0.1, 0.2, 1.5, -0.7]");
    let found = slopes(&polynomial, "file:joint.track.polynomial_m.0,file:joint.track.polynomial_m.2");
    let omega = (30.0f64 / 0.8).sqrt();
    let due = -2.0 * (1.0 - (0.2 * omega).cos()) / (omega * omega);
    assert!(found[0].abs() < 1e-9 && (found[1] - due).abs() < 1e-7 * due.abs(), "{found:?} and {due}");
    let table = model("table.toml", "table_s_m = [[0.0, 0.1], [0.11, 0.2], [0.3, 0.15]]");
    let rows: Vec<String> = (0..3).map(|row| format!("file:joint.track.table_s_m.{row}.1")).collect();
    let found = slopes(&table, &rows.join(","));
    let largest = found.iter().fold(0.0f64, |most, slope| most.max(slope.abs()));
    assert!(largest > 0.1 && found.iter().sum::<f64>().abs() < 1e-8 * largest, "{found:?}");
    let words = ["gradient", &table, "--of", "slide.position@0.2", "--by", "file:joint.track.table_s_m.1.0"];
    let output = foldwing(&words);
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && text.contains("changes the times of a prescribed motion"), "{text}");
}
