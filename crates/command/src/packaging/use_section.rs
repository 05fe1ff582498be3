//! Sections of the FMU's page other than the model: its use, its accuracy, further contents of the archive, licences.

use crate::packaging::extras::Extras;
use crate::packaging::html::{number, table};
use crate::packaging::{Kinds, linear_model, reference};
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{FastestMotion, Plant};
use foldwing_fmi::instance::Version;
use foldwing_fmi::interface::{Causality, Value, Variable};
use quick_xml::escape::escape;
use std::fmt::Write;
use std::sync::Arc;

/// The accuracy table of `README.md`.
const ACCURACY: &str = include_str!("../../shipped/accuracy.md");

/// Writes how to use the FMU, with variable names of this model.
pub(super) fn drive(html: &mut String, machine: &Machine, variables: &[Variable], kinds: Kinds) {
    let experiment = &machine.experiment;
    let names: Vec<String> =
        reference::recorded(variables).iter().take(3).map(|row| format!("\"{}\"", escape(&row.name))).collect();
    let _ = write!(
        html,
        "<h2 id=\"use\">How to use it</h2>\n\
         <p>Any importer of FMI {} {kinds} takes this FMU: Simulink's FMU Import block, Dymola, OpenModelica, FMPy \
         and others. In Python, with FMPy:</p>\n\
         <pre><code>from fmpy import simulate_fmu\n\n\
         result = simulate_fmu(\"{}.fmu\", stop_time={}, output_interval={},\n{}                      output=[{}])\n\
         print(result.dtype.names, result[-1])</code></pre>\n<ul>\n",
        kinds.standard(),
        escape(&machine.name),
        number(experiment.stop_time_s),
        number(experiment.step_s),
        start_values(variables),
        names.join(", ")
    );
    let released = variables.iter().find(|row| {
        row.causality == Causality::Input && row.name.ends_with(".release") && row.value == Value::Boolean(true)
    });
    if let Some(row) = released {
        let _ = writeln!(
            html,
            "<li>With the default start values the joint is released at once; <code>{}</code> = false holds it.</li>",
            escape(&row.name)
        );
    }
    let _ = write!(
        html,
        "<li>{} Outputs belong to the end of the last step.</li>\n\
         <li>States can be saved and restored, also as bytes; two instances share nothing.</li>\n\
         <li>Undamped vibrations that the tolerance does not resolve appear in forces, reactions and accelerations first: these then change \
         with <code>solver.tolerance</code> or the tolerance of the experiment much more than angles, positions and strains. Stiffness \
         damping (<code>stiffness_damping_s</code>) damps the vibrations.</li>\n\
         <li>A value outside its range is discarded with a message; a failed step leaves the FMU at the last good \
         time.</li>\n</ul>\n",
        match kinds.version {
            Version::Fmi2 =>
                "Inputs are held during a communication step, or run linearly if the importer sets their derivatives.",
            Version::Fmi3 => "Inputs are held during a communication step. Arrays are set and read whole, row by row.",
        }
    );
    if kinds.model_exchange {
        integrate(html, machine);
    }
}

/// Writes data for the integrator of an importer: the fastest motion at the start, and the explicit steps that it allows.
fn integrate(html: &mut String, machine: &Machine) {
    let mut plant = Plant::new(Arc::new(machine.clone()));
    let started = plant.initialize(machine.experiment.start_time_s).is_ok();
    if !started || plant.system_mut().begin_exchange().is_err() {
        return;
    }
    let Ok(fastest) = plant.system_mut().fastest_motion() else { return };
    if fastest.magnitude_rad_s > 0.0 {
        html.push_str(
            "<p><strong>Model Exchange.</strong> Integrate with an implicit method, such as CVode's. The fastest motion at the start ",
        );
        html.push_str(&explicit_steps(fastest));
    }
}

/// Sentence on the fastest motion and the steps of explicit methods, to the end of the paragraph.
fn explicit_steps(FastestMotion { magnitude_rad_s, damping_rate_1_s }: FastestMotion) -> String {
    let euler_s = 2.0 * damping_rate_1_s / (magnitude_rad_s * magnitude_rad_s);
    let ratio = damping_rate_1_s / magnitude_rad_s;
    let limit = if ratio < HARDLY { UNDAMPED } else { DAMPED };
    let classical_s = limit / magnitude_rad_s;
    let classical = format!("the classical Runge–Kutta method of order 4 needs steps of {classical_s:.1e} s or less");
    if ratio < HARDLY {
        format!(
            "has about {magnitude_rad_s:.1e} rad/s, hardly damped: {classical} ({limit}/ω), and forward Euler far shorter ones \
             (2ζ/ω).</p>\n"
        )
    } else if ratio < ALMOST_ALL {
        format!(
            "has about {magnitude_rad_s:.1e} rad/s and a damping rate of {damping_rate_1_s:.1e} 1/s: {classical} ({limit}/ω), \
             and forward Euler {euler_s:.1e} s or less, by motions with less damping perhaps far less.</p>\n"
        )
    } else {
        format!(
            "decays at about {magnitude_rad_s:.1e} 1/s without oscillation: {classical} ({limit}/λ), and forward Euler \
             {euler_s:.1e} s or less, by motions with less damping perhaps far less.</p>\n"
        )
    }
}

/// Product of step and angular frequency up to which the classical fourth-order Runge–Kutta method is stable without
/// damping, 2√2.
const UNDAMPED: f64 = 2.8;
/// The same with any damping: the least is 2.62, at damping ratios near 0.57.
const DAMPED: f64 = 2.6;
/// Damping ratio below which the estimate of the damping of the fastest motion has no digits.
const HARDLY: f64 = 0.01;
/// Share of the magnitude above which a damping rate is that of a motion without oscillation, within the accuracy of both.
const ALMOST_ALL: f64 = 0.9;

/// Line of start values in the example: the first Boolean input, or the first parameter.
fn start_values(variables: &[Variable]) -> String {
    let switch = |row: &&Variable| row.causality == Causality::Input && matches!(row.value, Value::Boolean(_));
    let parameter = |row: &&Variable| row.causality == Causality::Parameter;
    let Some(row) = variables.iter().find(switch).or(variables.iter().find(parameter)) else { return String::new() };
    let value = match row.value {
        Value::Real(value) => format!("{value:?}"),
        Value::Integer(value) => value.to_string(),
        Value::Boolean(true) => "True".to_owned(),
        Value::Boolean(false) => "False".to_owned(),
    };
    format!("                      start_values={{\"{}\": {value}}},\n", escape(&row.name))
}

/// Writes the measured accuracy of the engine, as in the project's `README.md`.
pub(super) fn validation(html: &mut String) {
    html.push_str(
        "<h2 id=\"validation\">Validation</h2>\n<p>The engine behind this FMU is compared with closed forms, with \
         independent programs and with the published deployment experiment. Measured with the models that Foldwing \
         ships; <code>docs/VALIDATION.md</code> of the project has each case with its source, tolerance and \
         command.</p>\n",
    );
    let mut rows = accuracy();
    let head = rows.remove(0);
    table(html, &head.iter().map(String::as_str).collect::<Vec<_>>(), rows.into_iter());
    html.push_str(
        "<p>The formulation is that of K. Otsuka et al.: strain-based geometrically nonlinear beams with joint \
         parameters.</p>\n",
    );
}

/// Cells of the table with code spans as HTML; the header is the first row.
fn accuracy() -> Vec<Vec<String>> {
    let cell = |text: &str| -> String {
        let spans = escape(text.trim()).into_owned();
        spans
            .split('`')
            .enumerate()
            .map(|(i, part)| if i % 2 == 1 { format!("<code>{part}</code>") } else { part.to_owned() })
            .collect()
    };
    ACCURACY
        .lines()
        .filter(|line| line.starts_with('|') && !line.starts_with("|-"))
        .map(|line| line.trim_matches('|').split('|').map(cell).collect())
        .collect()
}

/// Writes the list of other contents of the archive, and of the licences.
pub(super) fn archive(html: &mut String, extras: &Extras) {
    html.push_str(
        "<h2 id=\"archive\">In the archive</h2>\n<ul>\n\
         <li><a href=\"../resources/model.toml\"><code>resources/model.toml</code></a>: the model file; change it and \
         package again with <code>foldwing package</code>, no compiler is needed.</li>\n",
    );
    if extras.reference.is_some() {
        let folder = reference::FOLDER;
        let _ = writeln!(
            html,
            "<li><a href=\"../{folder}/experiments.exp\"><code>{folder}</code></a>: reference results of two experiments, \
             for a first check in your importer; <a href=\"fmi-ls-ref.txt\">what to expect</a>.</li>"
        );
    }
    if let Some(model) = &extras.linear {
        let folder = linear_model::FOLDER;
        let _ = writeln!(
            html,
            "<li><a href=\"../{folder}/README.txt\"><code>{folder}</code></a>: the linear model {} with {} states, {} \
             inputs and {} outputs, for MATLAB, Simulink, Python and Julia.</li>",
            escape(model.point.to_string().as_str()),
            model.states.len(),
            model.inputs.len(),
            model.outputs.len()
        );
    }
    html.push_str(
        "</ul>\n<h2 id=\"licence\">Licence</h2>\n<p>MIT or Apache-2.0, at your choice: \
         <a href=\"licenses/license.txt\">licenses/license.txt</a>, with the <a href=\"licenses/THIRD_PARTY.txt\">notices of \
         what is linked in</a>. The model file and its results belong to their author.</p>\n",
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Complex;
    use std::fs;
    use std::path::Path;

    /// The words follow the damping ratio, and the steps are the limits of stability: `|1 + h λ| = 1` for forward Euler.
    #[test]
    fn explicit_steps_are_the_limits_of_stability() {
        let words = |ratio: f64| {
            let damping_rate_1_s = 1e5 * ratio;
            explicit_steps(FastestMotion { magnitude_rad_s: 1e5, damping_rate_1_s })
        };
        let [none, some, all] = [0.005, 0.25, 1.0].map(words);
        assert!(none.contains("1.0e5 rad/s, hardly damped") && !none.contains("1/s:"), "{none}");
        assert!(some.contains("a damping rate of 2.5e4 1/s") && some.contains("forward Euler 5.0e-6 s"), "{some}");
        assert!(all.contains("decays at about 1.0e5 1/s") && all.contains("forward Euler 2.0e-5 s"), "{all}");
        for (text, limit) in [(&none, "2.8e-5"), (&some, "2.6e-5"), (&all, "2.6e-5")] {
            assert!(text.contains(&format!("steps of {limit} s or less")) && text.ends_with("</p>\n"), "{text}");
        }
        // stability function of the method in the left half-plane: |1 + z + z²/2 + z³/6 + z⁴/24| ≤ 1
        for degrees in 90..=180 {
            let angle = f64::from(degrees).to_radians();
            let z = Complex::from_polar(if degrees == 90 { UNDAMPED } else { DAMPED }, angle);
            let factor = (z / 24.0 + 1.0 / 6.0) * z * z * z + z * z / 2.0 + z + 1.0;
            assert!(factor.norm() <= 1.0, "{degrees}: {factor}");
        }
        // Euler's step of the damped oscillator: λ = −ζ ω + i ω √(1 − ζ²)
        let (step_s, ratio) = (5e-6, 0.25_f64);
        let (real, imaginary) = (1.0 - step_s * 1e5 * ratio, step_s * 1e5 * (1.0 - ratio * ratio).sqrt());
        assert!((real.hypot(imaginary) - 1.0).abs() < 1e-12);
    }

    /// The numbers on the page are identical to those of `docs/VALIDATION.md`, and their test cases are in the list of
    /// cases.
    #[test]
    fn accuracy_is_stated_in_one_place() {
        let read = |path: &str| {
            fs::read_to_string(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join(path)).unwrap()
        };
        let front = read("docs/VALIDATION.md");
        let chapters =
            fs::read_dir(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("docs/validation")).unwrap();
        let cases: String = chapters.map(|chapter| fs::read_to_string(chapter.unwrap().path()).unwrap()).collect();
        assert!(front.contains(ACCURACY.trim_end()), "the table of docs/VALIDATION.md is not docs/tables/accuracy.md");
        let rows = accuracy();
        assert_eq!(rows[0], ["what", "reference", "ours", "case"]);
        for row in &rows[1..] {
            assert_eq!(row.len(), 4, "{row:?}");
            let case = &row[3];
            assert!(case.contains("<code>") || cases.contains(case), "{case} is not in docs/validation");
        }
        assert!(rows.len() > 8, "{} rows", rows.len());
        let mut html = String::new();
        validation(&mut html);
        assert!(html.contains("<td>elastica under a dead tip force <code>10 EI/L²</code>, 8 pairs</td>"), "{html}");
    }
}
