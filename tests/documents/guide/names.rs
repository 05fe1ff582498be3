//! What the pages quote exists: variables, keys of the model file, sections that links lead to.

use crate::guide::command_lines::pages;
use crate::guide::variables::{everything, in_real_time, named, pattern, rotor, sliding, with_rigid_latch};
use foldwing::config;
use foldwing::instance::Version;
use foldwing::interface::Interface;
use foldwing::packaging::Kinds;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Code in sentences and tables of a page, and texts in quotes with a dot inside in its scripts.
fn spans(text: &str) -> Vec<String> {
    let prose: String = text.split("```").step_by(2).collect();
    let code =
        text.split("```").skip(1).step_by(2).filter(|block| block.starts_with("python") || block.starts_with("matlab"));
    let texts = code.flat_map(|block| block.split(['"', '\'']).skip(1).step_by(2)).filter(|text| text.contains('.'));
    prose.split('`').skip(1).step_by(2).chain(texts).map(|span| span.replace('\n', " ")).collect()
}

/// Names and values of the model file's schema.
fn words_of_the_schema() -> BTreeSet<String> {
    fn collect(value: &serde_json::Value, found: &mut BTreeSet<String>) {
        match value {
            serde_json::Value::Object(map) => {
                found.extend(
                    map.get("properties")
                        .and_then(|keys| keys.as_object())
                        .into_iter()
                        .flatten()
                        .map(|(key, _)| key.clone()),
                );
                map.values().for_each(|value| collect(value, found));
            }
            serde_json::Value::Array(items) => items.iter().for_each(|item| collect(item, found)),
            serde_json::Value::String(word) => drop(found.insert(word.clone())),
            _ => {}
        }
    }
    let mut found = BTreeSet::new();
    collect(&serde_json::from_str(&config::schema()).unwrap(), &mut found);
    found
}

/// Names of variables: patterns, and those of the shipped wing with and without air.
fn variables() -> BTreeSet<String> {
    let tables = [everything(), in_real_time(), with_rigid_latch(), sliding(false), sliding(true), rotor()];
    let mut names: BTreeSet<String> =
        tables.iter().flat_map(Interface::variables).map(|row| pattern(&row.name).0).collect();
    for model in [
        "models/folding_wing.toml",
        "models/folding_wing_in_tunnel.toml",
        "models/four_bar.toml",
        "failures/latch_does_not_catch.toml",
    ] {
        let path = crate::guide::in_package("examples").join(model);
        let (machine, _) = config::read(path).unwrap_or_else(|error| panic!("{error}"));
        let kinds = Kinds { version: Version::Fmi3, co_simulation: true, model_exchange: machine.air.is_none() };
        names.extend(kinds.interface(&machine).arrays().iter().map(|array| array.name.clone()));
        for row in Interface::new(&machine).variables() {
            names.insert(row.name.clone());
            names.insert(named(&machine, &row.name).replace("tip_<body>", "tip"));
        }
    }
    // a group stands for all that begin so: `root.acceleration`, `load.`
    let groups: Vec<String> =
        names.iter().flat_map(|name| name.match_indices('.').map(|(at, _)| name[..at].to_owned())).collect();
    names.extend(groups);
    names
}

/// Words in code that look like a name of ours and are someone else's.
const FOREIGN: &[&str] = &[
    "attitude.roll",
    "attitude.pitch",
    "attitude.yaw",
    "turn.rate",
    "fmudialog.createBusType",
    "m.A",
    "m.B",
    "m.C",
    "m.D",
    "m.u0",
    "m.y0",
    "<joint>.first_latch_time",
    "gauge.<name>.strain.peak",
    "set_param",
    "set_input_derivatives",
    "start_values",
    "oms_ma",
    "oms_mav",
    "oms_mav2",
    // fields of what `--timing`, `--lattice`, `--vtk` and `sweep` write
    "processor_s",
    "time_s",
    "without_air",
    "growing_1_s",
    "error_bound",
    "reduction.accuracy",
    "up_to_Hz",
    "largest_at_deg",
    // inputs and states of linear models in air
    "gust.x",
    "gust.y",
    "gust.z",
    "wing.strip[1].gust_lag[1]",
    "state.wing.strip[3].lag[1]",
    "<body>.station[i]",
    "gust_lag",
    // states of reduced linear models
    "balanced_1",
    "modal_1",
    "trial_iterations",
    "iteration_us",
    "axial_strain",
    "displacement_m",
    "velocity_m_s",
    "circulation_m2_s",
    "end_time",
    // what `modes --over` calls a rotor's speed, and a joint of the turbine
    "rotor_speed_rpm",
    "drive_train",
    "fold_angles",
    "fold_torques",
    "root_moment",
    "air_force",
    "slide_forces",
    "tip_path",
    "outputs_1",
    "energy.total − energy.work + energy.dissipated",
];

/// Whether a word looks like a variable, a key or a path of keys: small letters with a dot or an underscore inside.
fn looks_like_a_name(word: &str) -> bool {
    let plain = word.chars().all(|c| c.is_ascii_alphanumeric() || "._<>[]{},".contains(c));
    let inside = word.trim_end_matches('.').contains(['.', '_']);
    let file = word.rsplit_once('.').is_some_and(|(_, extension)| {
        [
            "toml", "csv", "py", "fmu", "xml", "json", "mat", "npz", "md", "rs", "so", "dll", "html", "txt", "opt",
            "png", "pvd", "vtu", "exp", "ipynb", "ssp", "sweep",
        ]
        .contains(&extension)
    });
    plain && inside && !file && word.starts_with(|c: char| c.is_ascii_lowercase() || c == '<')
}

/// What may be quoted.
struct Names {
    variables: BTreeSet<String>,
    /// Keys and words of the model file.
    keys: BTreeSet<String>,
}

impl Names {
    fn new() -> Self {
        Self { variables: variables(), keys: words_of_the_schema() }
    }

    fn knows(&self, word: &str) -> bool {
        let name = word.trim_end_matches('.');
        let tables = ["inner", "outer", "fold", "front"];
        let in_file = |part: &str| self.keys.contains(part) || part.starts_with('<') || tables.contains(&part);
        let last_part = || self.variables.iter().any(|variable| variable.rsplit('.').next() == Some(word));
        self.variables.contains(name)
            || self.keys.contains(name)
            || (name.contains('.') && name.split('.').all(in_file))
            || last_part()
    }
}

/// F-249. Variables, keys and values of the model file in the guide, on the front page and in its scripts exist.
#[test]
fn f249_names_that_the_guide_quotes_exist() {
    let names = Names::new();
    let (mut unknown, mut count) = (Vec::new(), 0);
    for page in pages() {
        let path = page.to_string_lossy().replace('\\', "/");
        let ours = ["docs/guide/", "README.md", "COMMAND_LINE.md"].iter().any(|part| path.contains(part));
        if !ours || path.ends_with("commands.md") {
            continue;
        }
        for span in spans(&fs::read_to_string(&page).unwrap()) {
            let span = span.split(" = ").next().unwrap();
            if FOREIGN.contains(&span) || !looks_like_a_name(span) {
                continue;
            }
            count += 1;
            if !names.knows(span) {
                unknown.push(format!("{path}: {span}"));
            }
        }
    }
    assert!(unknown.is_empty(), "no such variable or key:\n{}", unknown.join("\n"));
    assert!(count > 120, "{count} names were found");
}

/// The check sees what it should refuse.
#[test]
fn a_wrong_name_is_seen() {
    let names = Names::new();
    for wrong in
        ["fold.angel", "body.inner.lenght_m", "tip.position.q", "latch_tim", "solver.speed", "gauge.root.stress"]
    {
        assert!(looks_like_a_name(wrong) && !names.knows(wrong), "{wrong}");
    }
    for right in ["fold.angle", "body.inner.length_m", "tip.position.", "latch_time", "solver.method", "load.<body>[i]"]
    {
        assert!(names.knows(right), "{right}");
    }
}

/// F-255. Links within the documents lead to pages, and to sections that these have.
#[test]
fn f255_links_lead_to_sections() {
    let mut count = 0;
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        for link in
            text.split("](").skip(1).filter_map(|rest| rest.split(')').next()).filter(|link| !link.contains("://"))
        {
            let (path, section) = link.split_once('#').unwrap_or((link, ""));
            let target = if path.is_empty() { page.clone() } else { page.parent().unwrap().join(path) };
            assert!(target.exists(), "{}: {link} does not exist", page.display());
            if !section.is_empty() {
                count += 1;
                assert!(sections(&target).contains(section), "{}: no section {link}", page.display());
            }
        }
    }
    assert!(count > 20, "{count} links to sections");
}

/// Names of a page's sections, as links say them.
fn sections(page: &Path) -> BTreeSet<String> {
    let text = fs::read_to_string(page).unwrap();
    let titles = text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    let slug = |title: &str| -> String {
        let kept = title.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.collect::<String>().to_lowercase().replace(' ', "-")
    };
    titles.map(slug).collect()
}

/// F-256. Figures of the front page's table of speeds are those of `docs/BENCHMARKS.md`, and what is missed there is missed here.
#[test]
fn f256_speeds_of_the_front_page_are_those_of_the_benchmarks() {
    let read = |path: &str| fs::read_to_string(crate::guide::in_package(path)).unwrap();
    let (front, benchmarks) = (read("README.md"), read("docs/BENCHMARKS.md"));
    let section = front.split("## How fast it is").nth(1).and_then(|rest| rest.split("\n## ").next()).unwrap();
    let rows: Vec<Vec<&str>> = section
        .lines()
        .filter(|line| line.starts_with("| ") && !line.starts_with("| what"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    assert!(rows.len() >= 8, "{} rows", rows.len());
    let verdicts: Vec<&str> = benchmarks.lines().filter(|line| line.matches('|').count() == 6).collect();
    for row in &rows {
        let [what, _, measured, verdict] = row[..] else { panic!("four columns: {row:?}") };
        for figure in measured.split([',', ';']).map(str::trim) {
            let found = verdicts.iter().find(|line| line.split('|').nth(3).is_some_and(|cell| cell.contains(figure)));
            let line =
                found.unwrap_or_else(|| panic!("{what}: {figure} is not a measured figure of docs/BENCHMARKS.md"));
            let missed = line.contains("**no**");
            assert_eq!(verdict.contains("**missed**"), missed || verdict.contains("; met"), "{what}: {line}");
        }
    }
}
