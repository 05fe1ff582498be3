//! The list of faults, `tests/mutants/faults.toml`, against the sources: `make mutants` introduces them and runs the tests that must detect
//! them.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// One entry of the list.
struct Fault {
    number: i64,
    file: String,
    old: String,
    new: String,
    equation: String,
    /// Exactly one of `finder`, `reason` and `pending`, with its text.
    outcome: (&'static str, String),
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn faults() -> Vec<Fault> {
    let list: toml::Table = read("tests/mutants/faults.toml").parse().expect("a TOML file");
    let of = |entry: &toml::Value| {
        let number = entry["number"].as_integer().expect("a number");
        let text = |key: &str| {
            entry
                .get(key)
                .and_then(toml::Value::as_str)
                .unwrap_or_else(|| panic!("fault {number} has no text {key}"))
                .to_owned()
        };
        assert!(text("what").len() > 20, "fault {number} does not say what goes wrong");
        let outcome: Vec<_> = ["finder", "reason", "pending"]
            .into_iter()
            .filter_map(|key| Some((key, entry.get(key)?.as_str()?.to_owned())).filter(|(_, text)| !text.is_empty()))
            .collect();
        assert_eq!(
            outcome.len(),
            1,
            "fault {number} has either a finder or a reason why it survives: `tools/mutants.py --find {number}` looks for a finder"
        );
        let outcome = outcome[0].clone();
        let [file, old, new, equation] = ["file", "old", "new", "equation"].map(text);
        Fault { number, file, old, new, equation, outcome }
    };
    list["fault"].as_array().expect("entries [[fault]]").iter().map(of).collect()
}

#[test]
fn every_edit_matches_the_sources_exactly_once() {
    let mut numbers = BTreeSet::new();
    let mut places: BTreeMap<String, Vec<(usize, usize, i64)>> = BTreeMap::new();
    for Fault { number, file, old, new, .. } in faults() {
        assert!(numbers.insert(number), "two faults have the number {number}");
        assert!(new.contains(&format!("fault({number})")), "fault {number}: `new` has no switch `fault({number})`");
        let text = read(&file);
        let found: Vec<usize> = text.match_indices(&old).map(|(at, _)| at).collect();
        assert_eq!(
            found.len(),
            1,
            "fault {number}: `old` is to be exactly once in {file}; carry the fault over to the new text"
        );
        places.entry(file).or_default().push((found[0], found[0] + old.len(), number));
    }
    for (file, mut edits) in places {
        edits.sort_unstable();
        for pair in edits.windows(2) {
            assert!(pair[0].1 <= pair[1].0, "faults {} and {} edit the same text of {file}", pair[0].2, pair[1].2);
        }
    }
}

/// Letters of the chapters of NOTATION that contain equations.
const CHAPTERS: &str = "KJSRDLGMACUQTWB";

/// Folders of the sources, and the minimum number of faults for each: one per about 400 lines of computation.
const FOLDERS: &[(&str, usize)] = &[
    ("crates/engine/src/aero", 40),
    ("crates/engine/src/beam", 10),
    ("crates/engine/src/force", 10),
    ("crates/engine/src/multibody", 20),
    ("crates/engine/src/run", 5),
    ("crates/engine/src/solve", 20),
    ("crates/engine/src/study", 10),
    ("crates/engine/src/system", 15),
    ("crates/file/src", 10),
    ("crates/fmi/src", 8),
    ("crates/study/src", 5),
    ("crates/command/src", 5),
];

#[test]
fn faults_are_spread_over_equations_and_sources() {
    let list = faults();
    assert!(list.len() >= 150, "{} faults", list.len());
    let notation = read("docs/NOTATION.md");
    for Fault { number, equation, .. } in list.iter().filter(|fault| !fault.equation.is_empty()) {
        assert!(notation.contains(&format!("**({equation})**")), "fault {number}: NOTATION has no equation {equation}");
    }
    for chapter in CHAPTERS.chars() {
        assert!(list.iter().any(|fault| fault.equation.starts_with(chapter)), "no fault in an equation ({chapter}…)");
    }
    for (folder, least) in FOLDERS {
        let count = list.iter().filter(|fault| fault.file.starts_with(&format!("{folder}/"))).count();
        assert!(count >= *least, "{count} faults in {folder}, which needs {least}");
    }
}

#[test]
fn every_finder_is_a_test() {
    for Fault { number, outcome: (kind, finder), .. } in faults() {
        if kind != "finder" {
            continue;
        }
        let (program, test) =
            finder.split_once(' ').unwrap_or_else(|| panic!("fault {number}: a finder is a program and a test"));
        let folder = match program.strip_prefix("foldwing_") {
            Some(package) => format!("crates/{package}/src"),
            None => format!("tests/{program}"),
        };
        let modules: Vec<&str> = test.split("::").collect();
        let name = modules[modules.len() - 1];
        let mut files = Vec::new();
        let folder = root().join(&folder);
        walk(&folder, &mut files);
        // a module's file is named in the path of its tests
        let is_of_module = |file: &PathBuf| {
            let within = file.strip_prefix(&folder).expect("below the folder").with_extension("");
            within.iter().filter_map(|part| part.to_str()).all(|part| {
                modules.contains(&part) || ["mod", "main", "lib"].contains(&part) || part.ends_with("tests")
            })
        };
        let is_there = files.iter().any(|file| is_of_module(file) && read(file).contains(&format!("fn {name}(")));
        let folder = folder.display();
        assert!(
            is_there,
            "fault {number}: {folder} has no test {name}; `tools/mutants.py --find {number}` looks for another finder"
        );
    }
}

fn walk(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            walk(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}
