//! Sections of the FMU's page other than the model: its use, its accuracy, further contents of the archive, licences.

use crate::packaging::extras::Extras;
use crate::packaging::html::{number, table};
use crate::packaging::{Kinds, MODEL_IDENTIFIER, linear_model, reference};
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::Plant;
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
         <li>States can be saved and restored, also as bytes; two instances of <code>{MODEL_IDENTIFIER}</code> share \
         nothing.</li>\n\
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

/// Writes data for the integrator of an importer: the highest frequency at the start, and the explicit step that it allows.
fn integrate(html: &mut String, machine: &Machine) {
    let mut plant = Plant::new(Arc::new(machine.clone()));
    let started = plant.initialize(machine.experiment.start_time_s).is_ok();
    if !started || plant.system_mut().begin_exchange().is_err() {
        return;
    }
    let Ok(fastest_rad_s) = plant.system_mut().fastest_rad_s() else { return };
    if fastest_rad_s > 0.0 {
        let _ = writeln!(
            html,
            "<p><strong>Model Exchange.</strong> Integrate with an implicit method, such as CVode's. The fastest motion at the start has \
             about {fastest_rad_s:.1e} rad/s, hardly damped: the classical Runge–Kutta method of order 4 needs steps of {:.1e} s or less \
             ({RUNGE_KUTTA}/ω), and forward Euler far shorter ones (2ζ/ω).</p>",
            RUNGE_KUTTA / fastest_rad_s
        );
    }
}

/// Product of step and angular frequency up to which the classical fourth-order Runge–Kutta method is stable without
/// damping, 2√2.
const RUNGE_KUTTA: f64 = 2.8;

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
    use std::fs;
    use std::path::Path;

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
