//! Names quoted in the pages exist: variables, keys of the model file, sections that are linked.

use crate::guide::command_lines::pages;
use crate::guide::variables::{everything, in_real_time, named, pattern, rotor, sliding, with_rigid_latch};
use foldwing::config;
use foldwing::instance::Version;
use foldwing::interface::Interface;
use foldwing::packaging::Kinds;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Code in sentences and tables of a page, and quoted texts with a dot inside in its scripts.
fn spans(text: &str) -> Vec<String> {
    let prose: String = text.split("```").step_by(2).collect();
    let code =
        text.split("```").skip(1).step_by(2).filter(|block| block.starts_with("python") || block.starts_with("matlab"));
    let texts = code.flat_map(|block| block.split(['"', '\'']).skip(1).step_by(2)).filter(|text| text.contains('.'));
    prose.split('`').skip(1).step_by(2).chain(texts).map(|span| span.replace('\n', " ")).collect()
}

/// Names and values in the schema of the model file.
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

/// Names of variables: patterns, and those of the shipped wing with and without aerodynamics.
fn variables() -> BTreeSet<String> {
    let tables = [everything(), in_real_time(), with_rigid_latch(), sliding(false), sliding(true), rotor()];
    let mut names: BTreeSet<String> =
        tables.iter().flat_map(Interface::variables).map(|row| pattern(&row.name).0).collect();
    for model in [
        "models/folding_wing.toml",
        "models/folding_wing_in_tunnel.toml",
        "models/four_bar.toml",
        "failures/latch_no_capture.toml",
        "tutorial/sketch.toml",
    ] {
        let path = crate::guide::in_package("examples").join(model);
        let (machine, _) = config::read(path).unwrap_or_else(|error| panic!("{error}"));
        let kinds = Kinds {
            version: Version::Fmi3,
            co_simulation: true,
            model_exchange: machine.air.is_none(),
            ..Kinds::default()
        };
        names.extend(kinds.interface(&machine).arrays().iter().map(|array| array.name.clone()));
        for row in Interface::new(&machine).variables() {
            names.insert(row.name.clone());
            names.insert(named(&machine, &row.name).replace("tip.<body>", "tip"));
        }
    }
    // a group represents all names that begin with it: `root.acceleration`, `load.`
    let groups: Vec<String> =
        names.iter().flat_map(|name| name.match_indices('.').map(|(at, _)| name[..at].to_owned())).collect();
    names.extend(groups);
    names
}

/// Words in code that look like names of variables or keys but belong to other software.
const FOREIGN: &[&str] = &[
    // CasADi
    "adj2_xf",
    "adj_xf",
    "dae.create",
    "dae.set",
    "quad_err_con",
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
    "<joint>.latch_impulse",
    "fold.latch_impulse",
    "gauge.<name>.strain.peak",
    "set_param",
    "set_input_derivatives",
    "start_values",
    "oms_ma",
    "oms_mav",
    "oms_mav2",
    // fields of the output of `fit`, `--profile`, `--lattice`, `--vtk` and `sweep`
    "degrees_of_freedom",
    "standard_error",
    "times_s",
    "processor_s",
    "time_s",
    "without_air",
    "growing_1_s",
    "error_bound",
    "reduction.accuracy",
    "max_frequency_Hz",
    "largest_at_deg",
    // inputs and states of linear models with aerodynamics
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
    "latch_time_s",
    // functions of Python
    "jax_function",
    "torch_function",
    "jax.jit",
    "jax.vmap",
    // the delay of a paced step in Python
    "sim.late_s",
    // the rotor speed in `modes --vary`, and a joint of the turbine
    "rotor_speed_rpm",
    "drive_train",
    "fold_angles",
    "fold_torques",
    "root_moment",
    "air_force",
    // functions of examples/controlled_wing_ssp.py
    "for_fmpy",
    "start_values",
    "slide_forces",
    "tip_path",
    "outputs_1",
    "energy.total − energy.work + energy.dissipated",
];

/// Returns whether a word looks like a variable, a key or a path of keys: lower-case letters with a dot or an underscore inside.
fn looks_like_a_name(word: &str) -> bool {
    let plain = word.chars().all(|c| c.is_ascii_alphanumeric() || "._<>[]{},".contains(c));
    let inside = word.trim_end_matches('.').contains(['.', '_']);
    let file = word.rsplit_once('.').is_some_and(|(_, extension)| {
        [
            "toml", "csv", "py", "fmu", "xml", "json", "mat", "npz", "md", "rs", "so", "dll", "html", "mp4", "gif",
            "txt", "opt", "png", "pvd", "vtu", "exp", "ipynb", "ssp", "sweep",
        ]
        .contains(&extension)
    });
    plain && inside && !file && word.starts_with(|c: char| c.is_ascii_lowercase() || c == '<')
}

/// Names that may be quoted.
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
        if !ours || path.ends_with("commands.md") || path.ends_with("upgrade.md") {
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

/// The check detects invalid names.
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

/// All pages of the repository: those at its root and in the folders that contain pages.
fn all_pages() -> Vec<PathBuf> {
    fn below(folder: &Path, deep: bool, found: &mut Vec<PathBuf>) {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() && deep {
                below(&path, true, found);
            } else if path.extension().is_some_and(|extension| extension == "md") {
                found.push(path);
            }
        }
    }
    let mut found = Vec::new();
    below(&crate::guide::in_package(""), false, &mut found);
    for folder in ["docs", "examples", "studies", "tests"] {
        below(&crate::guide::in_package(folder), true, &mut found);
    }
    found
}

/// Lines of a page outside its code blocks.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut code = false;
    text.lines().filter(move |line| {
        let fence = line.trim_start().starts_with("```");
        code ^= fence;
        !code && !fence
    })
}

/// Links in a page's text to other pages and to sections: their number, the number of those to sections, and errors.
fn links(page: &Path, text: &str) -> (usize, usize, Vec<String>) {
    let (mut count, mut to_sections, mut wrong) = (0, 0, Vec::new());
    let text = prose(text).collect::<Vec<_>>().join("\n");
    for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()).filter(|link| !link.contains("://"))
    {
        count += 1;
        let (path, section) = link.split_once('#').unwrap_or((link, ""));
        let target = if path.is_empty() { page.to_owned() } else { page.parent().unwrap().join(path) };
        if !target.exists() {
            wrong.push(format!("{}: {link} does not exist", page.display()));
        } else if !section.is_empty() {
            to_sections += 1;
            if !sections(&fs::read_to_string(&target).unwrap()).contains(section) {
                wrong.push(format!("{}: no section {link}", page.display()));
            }
        }
    }
    (count, to_sections, wrong)
}

/// F-255. Links in the documents, including decisions and the texts next to examples and tests, lead to existing files and sections. A
/// lower bound on the number of links, half of that at the time of writing, ensures that the pages are found.
#[test]
fn f255_links_lead_to_sections() {
    let (mut count, mut to_sections, mut wrong) = (0, 0, Vec::new());
    let pages = all_pages();
    for page in &pages {
        let (all, sections, bad) = links(page, &fs::read_to_string(page).unwrap());
        count += all;
        to_sections += sections;
        wrong.extend(bad);
    }
    println!("F-255: {} pages, {count} links, {to_sections} to sections", pages.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(pages.len() > 100 && count > 200 && to_sections > 30, "{} pages, {count}, {to_sections}", pages.len());
}

/// F-255 detects invalid links: to a missing page or section, to a comment in a code block, to a second section with a name that occurs
/// only once.
#[test]
fn a_link_that_leads_nowhere_is_seen() {
    let page = crate::guide::in_package("docs/guide/made_up.md");
    let text = "[a](../NOTATION.md#kinematics) [b](../NOTATION.md#kinematic) [c](../NOTATIONS.md)\n```sh\n# run it\n[d](nowhere.md)\n```\n\
                [e](../NOTATION.md#kinematics-1) [f](https://example.org/nowhere.md)\n";
    let (count, to_sections, wrong) = links(&page, text);
    assert_eq!((count, to_sections, wrong.len()), (4, 3, 3), "{wrong:?}");
    let own = sections("# One\n```sh\n# run it\n```\n## Two, three\n## One\n");
    assert_eq!(own.iter().map(String::as_str).collect::<Vec<_>>(), ["one", "one-1", "two-three"]);
}

/// Names of a page's sections as used in links: repeated names are numbered.
fn sections(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for title in prose(text).filter(|line| line.starts_with('#')) {
        let title = title.trim_start_matches('#').trim();
        let kept: String = title.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect();
        let slug = kept.to_lowercase().replace(' ', "-");
        let free = (1..).map(|n| format!("{slug}-{n}")).find(|name| !found.contains(name));
        let name = if found.contains(&slug) { free.expect("some number is free") } else { slug };
        found.insert(name);
    }
    found
}

/// F-256. Values in the table of speeds of docs/VALIDATION.md are those of `docs/BENCHMARKS.md`, and targets missed there are marked as
/// missed here.
#[test]
fn f256_speeds_of_the_validation_page_are_those_of_the_benchmarks() {
    let read = |path: &str| fs::read_to_string(crate::guide::in_package(path)).unwrap();
    let (front, benchmarks) = (read("docs/VALIDATION.md"), read("docs/BENCHMARKS.md"));
    let section = front.split("## Speed").nth(1).and_then(|rest| rest.split("\n## ").next()).unwrap();
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
