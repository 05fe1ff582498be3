//! The rules of `docs/ARCHITECTURE.md`, executable: allowed imports, the location of `unsafe`, restrictions of the physics modules, and
//! existence of the files and names in the documents.
//!
//! A failure names the file and the rule. Changing a table here is a design decision: change the same row in `docs/ARCHITECTURE.md` and
//! give the reason in the commit.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Module → modules that it may name, of the same crate and of others, in the order of `docs/ARCHITECTURE.md`. Rows name only earlier rows,
/// so there are no cycles.
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("math", &[]),
    ("load", &[]),
    ("solve", &[]),
    ("aero", &["math", "load"]),
    ("beam", &["math"]),
    ("multibody", &["math", "load", "beam"]),
    ("force", &["math", "load", "solve", "multibody"]),
    ("machine", &["math", "load", "aero", "beam", "multibody", "force"]),
    ("signal", &["load", "machine"]),
    ("system", &["math", "load", "solve", "aero", "beam", "multibody", "force", "machine", "signal"]),
    ("study", &["math", "load", "solve", "multibody", "force", "machine", "signal", "system"]),
    ("run", &["solve", "aero", "force", "machine", "signal", "system", "study"]),
    (
        "gradient",
        &["math", "load", "solve", "aero", "beam", "multibody", "force", "machine", "signal", "system", "run"],
    ),
    ("plant", &["signal", "system", "study", "run", "gradient"]),
    ("config", &["math", "load", "aero", "beam", "machine"]),
    ("interface", &["math", "load", "machine", "plant"]),
    ("instance", &["machine", "plant", "config", "interface"]),
    ("fmi2", &["instance"]),
    ("fmi3", &["instance"]),
    ("fmu", &["interface", "instance", "fmi2", "fmi3"]),
    ("names", &["interface"]),
    ("watch", &[]),
    ("branches", &[]),
    ("values", &["machine", "plant", "interface", "names"]),
    ("warnings", &["machine", "plant"]),
    ("flutter", &["machine", "plant", "watch", "branches", "warnings"]),
    ("trim", &["machine", "plant", "interface", "names", "watch", "values", "warnings"]),
    ("operating_points", &["machine", "plant", "interface", "names", "watch", "values"]),
    ("campbell", &["machine", "plant", "interface", "watch", "branches", "values"]),
    ("periodic", &["machine", "plant", "interface", "names", "watch", "values"]),
    ("latency", &["plant"]),
    ("sensitivity", &["machine", "plant", "interface", "names"]),
    ("fit", &[]),
    ("recording", &["math", "load", "beam", "machine", "plant", "interface"]),
    ("web", &["plant", "config", "interface", "recording"]),
    ("report", &["math", "beam", "machine", "plant", "interface", "names", "recording"]),
    ("packaging", &["math", "load", "beam", "machine", "plant", "interface", "instance", "fmi2", "fmi3", "report"]),
    ("live", &["load", "machine", "plant", "interface", "names", "report"]),
    (
        "cli",
        &[
            "machine",
            "plant",
            "config",
            "interface",
            "instance",
            "names",
            "watch",
            "branches",
            "values",
            "warnings",
            "flutter",
            "trim",
            "operating_points",
            "campbell",
            "periodic",
            "latency",
            "sensitivity",
            "fit",
            "recording",
            "report",
            "packaging",
            "live",
        ],
    ),
    ("import", &["interface", "report", "cli"]),
    (
        "python",
        &[
            "machine",
            "plant",
            "config",
            "interface",
            "names",
            "watch",
            "values",
            "flutter",
            "trim",
            "operating_points",
            "campbell",
            "periodic",
            "sensitivity",
            "fit",
            "report",
            "cli",
        ],
    ),
];

/// Folders below `crates` whose crate is a single module, and the name of this module in the table.
const CRATES_OF_ONE_MODULE: &[(&str, &str)] = &[
    ("file", "config"),
    ("fmu", "fmu"),
    ("import", "import"),
    ("python", "python"),
    ("recording", "recording"),
    ("web", "web"),
];

/// Modules that the unit tests of every module may also name: they read the shipped models, build machines and run them.
const OPEN_TO_UNIT_TESTS: &[&str] = &["config", "machine", "run"];

/// Submodules that the unit tests of a module also name: parts of the machines that they build.
const PARTS_IN_UNIT_TESTS: &[(&str, &[&str])] = &[("run", &["beam"]), ("study", &["aero", "beam"])];

/// Texts that start the unit tests at the end of a file.
const INLINE_TESTS: &[&str] = &["#[cfg(test)]\nmod tests {", "#[cfg(test)]\npub(super) mod tests {"];

/// Modules that compute: no files, no output, no clock, no environment, no threads, no random order.
const PHYSICS: &[&str] = &[
    "math",
    "load",
    "solve",
    "aero",
    "beam",
    "multibody",
    "force",
    "machine",
    "signal",
    "system",
    "study",
    "run",
    "gradient",
    "plant",
];

/// Patterns that are not allowed in them.
const NOT_IN_PHYSICS: &[&str] = &[
    "std::fs",
    "std::io",
    "std::net",
    "std::env",
    "std::time",
    "std::thread",
    "std::process",
    "println!",
    "eprintln!",
    "print!",
    "dbg!",
    "thread_local!",
    "static mut",
    "HashMap",
    "HashSet",
    "Mutex",
    "OnceLock",
    "LazyLock",
    "Atomic",
];

/// The only place for `unsafe`.
const UNSAFE_FOLDER: &str = "crates/fmu/src/";

/// The attribute that keeps the name of a function in a library, and the only other file that may contain it; it has no unsafe block.
const NAMED: (&str, &str) = ("crates/web/src/exports.rs", "#[unsafe(no_mangle)]");

/// Maximum number of lines of a source file.
const MAXIMUM_LINES: usize = 500;

/// Files that may be longer, each with its reason.
const LONGER: &[(&str, &str)] = &[
    (
        "crates/engine/src/solve/reduction.rs",
        "balanced and modal truncation from one modal form, with the Gramians of a band",
    ),
    ("crates/engine/src/study/statics.rs", "the search for an equilibrium from its start to the stable branch"),
];

/// Top-level folders: text in a document that begins with one of them is a path.
const TOP: &[&str] =
    &[".ci", "benches", "crates", "docs", "examples", "modelDescription", "python", "src", "studies", "tests", "tools"];

#[test]
fn imports_point_one_way() {
    let mut used: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for source in sources() {
        let text = &source.whole;
        if source.path == "src/lib.rs" {
            continue; // it re-exports the modules of the other crates, all at once
        }
        // importing several modules at once would hide them from the search below; a crate of one module has none to hide
        let of_one = CRATES_OF_ONE_MODULE.iter().any(|(_, module)| *module == source.module);
        let forbidden =
            ["foldwing::{", "foldwing_engine::{", "foldwing_fmi::{", "foldwing_study::{", "super::super", "crate::{"];
        for forbidden in &forbidden[..forbidden.len() - usize::from(of_one)] {
            assert!(
                !text.contains(forbidden),
                "{}: write one `crate::module::…` instead of `{forbidden}`",
                source.path
            );
        }
        for (module, _) in MAY_IMPORT {
            assert!(!text.contains(&format!("super::{module}::")), "{}: write `crate::{module}`", source.path);
        }
        if source.module == "lib" {
            // it declares modules without naming paths; its documentation shows how they are used
            let named = ["crate::", "super::"].into_iter().flat_map(|prefix| words_after(&source.code, prefix));
            assert_eq!(named.collect::<Vec<_>>(), [""; 0], "{} only declares modules", source.path);
            continue;
        }
        let (product, tests) = text.split_at(source.tests_at);
        let names = |text| source.names(text).into_iter();
        let parts =
            PARTS_IN_UNIT_TESTS.iter().find(|(module, _)| *module == source.module).map_or(&[][..], |row| row.1);
        let open = |name: &str| OPEN_TO_UNIT_TESTS.contains(&name) || parts.contains(&name);
        let names = names(product).chain(names(tests).filter(|name| !open(name)));
        used.entry(source.module.clone()).or_default().extend(names.filter(|name| *name != source.module));
    }
    assert_eq!(used.remove("main"), Some(owned(&["import", "run"])), "src/main.rs only starts the command");

    let allowed: BTreeMap<String, BTreeSet<String>> =
        MAY_IMPORT.iter().map(|(module, imports)| ((*module).to_owned(), owned(imports))).collect();
    for (module, imports) in &used {
        let row = allowed.get(module).unwrap_or_else(|| panic!("{module} has no row in MAY_IMPORT"));
        let beyond: Vec<_> = imports.difference(row).collect();
        assert!(beyond.is_empty(), "{module} names {beyond:?}; see MAY_IMPORT");
        let unused: Vec<_> = row.difference(imports).collect();
        assert!(unused.is_empty(), "{module} no longer names {unused:?}: take them out of MAY_IMPORT");
    }
    assert_eq!(used.keys().collect::<Vec<_>>(), allowed.keys().collect::<Vec<_>>(), "rows and modules");
}

/// Without this check the table could contain a cycle.
#[test]
fn every_row_names_earlier_rows_only() {
    for (i, (module, imports)) in MAY_IMPORT.iter().enumerate() {
        let earlier: Vec<&str> = MAY_IMPORT[..i].iter().map(|row| row.0).collect();
        let places: Vec<_> = imports.iter().map(|import| earlier.iter().position(|name| name == import)).collect();
        assert!(places.iter().all(Option::is_some), "{module} names a row at or below its own");
        assert!(places.is_sorted(), "{module}: imports stand in the order of the rows");
    }
}

/// The table in the document is the table that is enforced, row by row and in the same order.
#[test]
fn architecture_page_shows_the_same_table() {
    let page = read("docs/ARCHITECTURE.md");
    let rows: Vec<(String, Vec<String>)> = page
        .lines()
        .skip_while(|line| !line.starts_with("| module |"))
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(|line| {
            let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
            assert_eq!(cells.len(), 3, "module, what it does, what it may name: {line}");
            assert!(cells[1].len() > 20, "no description: {line}");
            let names = |cell| -> Vec<String> {
                code_spans(cell).into_iter().map(|name| name.trim_end_matches('/').to_owned()).collect()
            };
            (names(cells[0]).concat(), names(cells[2]))
        })
        .collect();
    let expected: Vec<(String, Vec<String>)> = MAY_IMPORT
        .iter()
        .map(|(module, imports)| ((*module).to_owned(), imports.iter().map(|name| (*name).to_owned()).collect()))
        .collect();
    assert_eq!(rows, expected, "docs/ARCHITECTURE.md (left) and MAY_IMPORT (right)");
}

#[test]
fn unsafe_code_stands_behind_the_gate_only() {
    for source in sources().into_iter().filter(|source| !source.path.starts_with(UNSAFE_FOLDER)) {
        let code = if source.path == NAMED.0 { source.code.replace(NAMED.1, "") } else { source.code };
        assert!(!has_word(&code, "unsafe"), "{}: `unsafe` belongs into {UNSAFE_FOLDER}", source.path);
    }
}

#[test]
fn physics_does_no_input_output_and_knows_no_fmi() {
    for source in sources() {
        let physics = PHYSICS.contains(&source.module.as_str());
        // files of tests print their figures
        for forbidden in NOT_IN_PHYSICS.iter().filter(|_| physics && source.tests_at > 0) {
            assert!(!source.code.contains(forbidden), "{}: `{forbidden}` in a module that computes", source.path);
        }
        let below_interface = physics || source.module == "config";
        assert!(!below_interface || !source.code.contains("fmi"), "{}: FMI begins at `interface`", source.path);
    }
}

#[test]
fn cited_equations_exist() {
    let known = equations();
    assert!(known.len() > 30, "docs/NOTATION.md numbers its equations as **(K1)**");
    let mut citations = 0;
    for source in sources() {
        for number in cited(&source.whole) {
            assert!(known.contains(&number), "{}: eq. ({number}) is not in docs/NOTATION.md", source.path);
            citations += 1;
        }
    }
    assert!(citations > 30, "only {citations} citations found: has their form changed?");
}

/// Letters of chapters and of papers: each letter used is in the legend of `docs/NOTATION.md`.
#[test]
fn letters_stand_in_the_legend() {
    let page = read("docs/NOTATION.md");
    let (legend, _) = page.split_once("\n## ").expect("the legend stands before the first chapter");
    for number in equations() {
        assert!(legend.contains(&format!("**{}** |", &number[..1])), "({number}): no chapter in the legend");
    }
    let mut citations = 0;
    for source in sources() {
        for (at, _) in source.whole.match_indices("\\[") {
            let letter = &source.whole[at + 2..].chars().next().expect("a letter behind the bracket");
            let paper = format!("**[{letter}]**");
            assert!(legend.contains(&paper), "{}: the paper [{letter}] is not in the legend", source.path);
            citations += 1;
        }
    }
    assert!(citations > 10, "only {citations} citations of papers found: has their form changed?");
}

/// An equation that is not cited in the code is either not implemented or cannot be found from the page.
#[test]
fn numbered_equations_are_cited() {
    let cited: BTreeSet<String> = sources().iter().flat_map(|source| cited(&source.whole)).collect();
    let missing: Vec<_> = equations().into_iter().filter(|number| !cited.contains(number)).collect();
    assert!(missing.is_empty(), "no source line cites {missing:?}");
}

#[test]
fn files_stay_short_and_have_names_that_say_something() {
    for source in sources() {
        let lines = source.whole.lines().count();
        let reason = LONGER.iter().find(|(path, _)| *path == source.path);
        assert!(
            lines <= MAXIMUM_LINES || reason.is_some(),
            "{}: {lines} lines; split it or give a reason",
            source.path
        );
        assert!(lines > MAXIMUM_LINES || reason.is_none(), "{}: short enough now, take it out of LONGER", source.path);
        for word in ["util", "helper", "manager", "misc", "common"] {
            assert!(!source.path.contains(word), "{}: `{word}` says nothing about what is inside", source.path);
        }
    }
}

#[test]
fn paths_in_documents_exist() {
    for document in documents() {
        let text = read(&document);
        let folder = root().join(&document).parent().expect("a document has a folder").to_owned();
        for span in code_spans(&text) {
            let path = span.split([' ', ':']).next().unwrap_or_default();
            let looks_like_a_path = TOP.iter().any(|top| path.starts_with(&format!("{top}/")))
                || (!path.contains(['/', '*', '<']) && path.ends_with(".md"));
            let exists = root().join(path).exists() || folder.join(path).exists();
            assert!(!looks_like_a_path || exists, "{document}: `{path}` does not exist");
        }
        for link in text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next()) {
            let local = !link.is_empty() && !link.contains("://");
            assert!(!local || folder.join(link).exists(), "{document}: the link to {link} is broken");
        }
    }
}

/// Decision records are numbered without gaps, have a common form, and are in the index in order.
#[test]
fn decision_records_have_one_form() {
    let folder = root().join("docs/decisions");
    let mut names: Vec<String> = fs::read_dir(&folder)
        .expect("readable")
        .map(|entry| entry.expect("readable").file_name().to_string_lossy().into_owned())
        .filter(|name| name != "README.md")
        .collect();
    names.sort();
    let index = read("docs/decisions/README.md");
    let listed: Vec<&str> = index.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    assert_eq!(listed, names, "docs/decisions/README.md (left) and the folder (right)");
    for (i, name) in names.iter().enumerate() {
        let text = read(&format!("docs/decisions/{name}"));
        let number = format!("{:04}", i + 1);
        assert!(name.starts_with(&number) && text.starts_with(&format!("# {number}: ")), "{name}: number {number}");
        let status = text.lines().nth(2).unwrap_or_default();
        let date = status.split([' ', '.', ';']).find(|word| word.len() == 10 && word.starts_with("20"));
        assert!(status.starts_with("Accepted, ") && date.is_some(), "{name}: `Accepted, YYYY-MM-DD.`, not {status:?}");
        let sections: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("## ")).collect();
        assert_eq!(sections, ["Context", "Decision", "Considered", "Consequences"], "{name}");
    }
}

/// The version to cite is the newest release with a date in the changelog.
#[test]
fn citation_names_the_newest_release() {
    let (changelog, citation) = (read("CHANGELOG.md"), read("CITATION.cff"));
    let release = changelog.lines().find_map(|line| line.strip_prefix("## ")?.strip_suffix(')')?.split_once(" ("));
    let (version, date) = release.expect("CHANGELOG.md dates its releases: `## 0.1.0 (2026-11-21)`");
    let value = |key: &str| citation.lines().find_map(|line| line.strip_prefix(key)).map(str::trim);
    assert_eq!((value("version:"), value("date-released:")), (Some(version), Some(date)), "CITATION.cff");
}

/// `make X` in a code block names a target; `foldwing X` a command.
#[test]
fn commands_in_documents_exist() {
    let makefile = read("Makefile");
    let targets: BTreeSet<&str> =
        makefile.lines().filter_map(|line| line.split_once(':')).map(|(target, _)| target).collect();
    let command_line = read("crates/command/src/cli/mod.rs");
    for document in documents() {
        let text = read(&document);
        let lines = code_blocks(&text, "sh").into_iter().flat_map(str::lines);
        for command in lines.chain(code_spans(&text)) {
            let words: Vec<&str> = command.split(['#', '|']).next().unwrap_or_default().split_whitespace().collect();
            let Some(name) = words.first().and_then(|path| path.rsplit('/').next()) else { continue };
            let argument = words.iter().skip(1).find(|word| !word.starts_with('-') && !word.contains('='));
            let Some(argument) = argument else { continue };
            if name == "make" {
                assert!(targets.contains(argument), "{document}: the Makefile has no target {argument}: {command}");
            }
            if name == "foldwing" && argument.chars().all(char::is_lowercase) {
                let variant = format!("    {}{}", argument[..1].to_uppercase(), &argument[1..]);
                assert!(command_line.contains(&variant), "{document}: no command {argument}: {command}");
            }
        }
    }
}

/// The model in the guide is one that the reader takes; the Python of the first scripts is in files that the tests run.
#[test]
fn examples_in_the_guide_work() {
    let guide = read("docs/guide/README.md");
    let models = code_blocks(&guide, "toml");
    assert!(!models.is_empty(), "docs/guide/README.md shows a model file");
    for model in models {
        foldwing::config::parse(model, "docs/guide/README.md").unwrap_or_else(|error| panic!("{error}"));
    }
    let text = read("docs/guide/first_scripts.md");
    let scripts = ["python", "fmpy"].map(|name| read(&format!("examples/{name}_ten_lines.py")));
    let scripts = scripts.each_ref().map(String::as_str);
    assert_eq!(code_blocks(&text, "python"), scripts, "docs/guide/first_scripts.md repeats examples/*_ten_lines.py");
}

/// The checks above ignore comments and strings; this test ensures that they still find something.
#[test]
fn comments_and_strings_are_told_from_code() {
    let text = "let a = 'x'; // unsafe\n/* unsafe /* nested */ unsafe */ let b: &'a str = \"un\\\"safe\";\nlet c = r#\"unsafe\"#;";
    let code = code_of(text);
    assert!(!code.contains("safe") && !code.contains("nested"), "{code}");
    assert!(code.contains("let b: &'a str = ") && code.contains("let c = "), "{code}");
    assert!(has_word("unsafe { x }", "unsafe") && !has_word("deny(unsafe_code)", "unsafe"));
    let citations = "/// see eqs. (D4)–(D6),\n    /// (D8) and NOTATION eq.\n/// (K10); not f(A1), not eq. (15)";
    assert_eq!(cited(citations), ["K10", "D4", "D5", "D6", "D8"]);
}

/// A source file.
struct Source {
    /// Path from the root, with `/`.
    path: String,
    /// Module of its crate: first folder below `src`, or the file's name; crates of a single module are that module.
    module: String,
    /// The unchanged text.
    whole: String,
    /// Position of the unit tests in the text.
    tests_at: usize,
    /// Text without comments and the contents of strings.
    code: String,
}

impl Source {
    /// Modules named in a part of this file, of the same crate and of others.
    fn names(&self, text: &str) -> Vec<String> {
        let mut names = Vec::new();
        for package in ["foldwing_engine::", "foldwing_fmi::", "foldwing_study::", "foldwing_command::", "foldwing::"] {
            names.extend(words_after(text, package));
        }
        if !CRATES_OF_ONE_MODULE.iter().any(|(_, module)| *module == self.module) {
            names.extend(words_after(text, "crate::"));
        }
        for (folder, module) in CRATES_OF_ONE_MODULE {
            let crate_name = format!("foldwing_{folder}");
            let named = text.contains(&format!("{crate_name}::")) || text.contains(&format!("use {crate_name} "));
            names.extend(named.then(|| (*module).to_owned()));
        }
        names
    }
}

fn sources() -> Vec<Source> {
    let mut paths = Vec::new();
    walk(&root().join("src"), "rs", &mut paths);
    for package in fs::read_dir(root().join("crates")).expect("readable") {
        walk(&package.expect("readable").path().join("src"), "rs", &mut paths);
    }
    paths.sort();
    let of = |path: PathBuf| {
        let inside = path.strip_prefix(root()).expect("inside the repository");
        let parts: Vec<String> = inside.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        let whole = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let path = parts.join("/");
        let all_tests = path.ends_with("tests.rs") || path.contains("/tests/");
        let tests_at = if all_tests { 0 } else { first_of(&whole, INLINE_TESTS) };
        let of_one = CRATES_OF_ONE_MODULE.iter().find(|(folder, _)| parts[1] == *folder).map(|(_, module)| *module);
        let below_src = parts.iter().position(|part| part == "src").expect("sources stand below src") + 1;
        let module = of_one.unwrap_or(parts[below_src].trim_end_matches(".rs")).to_owned();
        Source { path, tests_at, module, code: code_of(&whole), whole }
    };
    let sources: Vec<Source> = paths.into_iter().map(of).collect();
    assert!(sources.len() > 50, "only {} files found", sources.len());
    sources
}

/// Documents whose paths, links and commands are checked: pages at the top, of `studies/`, and all of `docs/`.
fn documents() -> Vec<String> {
    let mut paths = Vec::new();
    walk(&root().join("docs"), "md", &mut paths);
    walk(&root().join("studies"), "md", &mut paths);
    let top = fs::read_dir(root()).expect("readable").map(|entry| entry.expect("readable").path());
    paths.extend(top.filter(|path| path.extension().is_some_and(|extension| extension == "md")));
    paths.sort();
    assert!(paths.len() > 30, "only {} documents found", paths.len());
    let inside = |path: PathBuf| path.strip_prefix(root()).expect("inside").to_string_lossy().replace('\\', "/");
    paths.into_iter().map(inside).collect()
}

/// Position of the first of `marks`, or the end of the text.
fn first_of(text: &str, marks: &[&str]) -> usize {
    marks.iter().filter_map(|mark| text.find(mark)).min().unwrap_or(text.len())
}

fn walk(folder: &Path, extension: &str, paths: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            walk(&path, extension, paths);
        } else if path.extension().is_some_and(|found| found == extension) {
            paths.push(path);
        }
    }
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

fn owned(names: &[&str]) -> BTreeSet<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

fn is_word(character: char) -> bool {
    character.is_alphanumeric() || character == '_'
}

/// Words that follow each occurrence of `prefix` where it begins a path.
fn words_after(text: &str, prefix: &str) -> Vec<String> {
    text.match_indices(prefix)
        .filter(|(at, _)| !text[..*at].ends_with(|before: char| is_word(before) || before == ':'))
        .map(|(at, _)| text[at + prefix.len()..].chars().take_while(|&c| is_word(c)).collect())
        .collect()
}

fn has_word(text: &str, word: &str) -> bool {
    text.match_indices(word)
        .any(|(at, _)| !text[..at].ends_with(is_word) && !text[at + word.len()..].starts_with(is_word))
}

/// Rust text without comments and without the contents of quotes.
fn code_of(text: &str) -> String {
    let mut code = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let skip = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            block_comment(rest)
        } else if rest.starts_with("r\"")
            || rest.starts_with("r#") && rest.trim_start_matches(['r', '#']).starts_with('"')
        {
            let hashes = rest[1..].chars().take_while(|&c| c == '#').count();
            let end = format!("\"{}", "#".repeat(hashes));
            2 + hashes + rest[2 + hashes..].find(&end).map_or(0, |at| at + end.len())
        } else if first == '"' {
            quoted(rest, '"')
        } else if first == '\'' && (rest[1..].starts_with('\\') || rest[1..].chars().nth(1) == Some('\'')) {
            quoted(rest, '\'') // a character; otherwise a lifetime
        } else {
            code.push(first);
            first.len_utf8()
        };
        rest = &rest[skip..];
    }
    code
}

/// Length of a block comment, which may contain others.
fn block_comment(text: &str) -> usize {
    let mut depth = 0;
    let mut at = 0;
    loop {
        match &text[at..] {
            "" => return at,
            rest if rest.starts_with("/*") => (depth, at) = (depth + 1, at + 2),
            rest if rest.starts_with("*/") => (depth, at) = (depth - 1, at + 2),
            rest => at += rest.chars().next().map_or(0, char::len_utf8),
        }
        if depth == 0 {
            return at;
        }
    }
}

/// Length of a quoted text with both quotes.
fn quoted(text: &str, quote: char) -> usize {
    let mut escaped = true; // the opening quote does not close the text
    for (at, character) in text.char_indices() {
        if character == quote && !escaped {
            return at + 1;
        }
        escaped = at > 0 && character == '\\' && !escaped;
    }
    text.len()
}

/// Numbers of `docs/NOTATION.md`.
fn equations() -> BTreeSet<String> {
    let page = read("docs/NOTATION.md");
    let numbers: Vec<String> = page
        .lines()
        .filter_map(|line| line.strip_prefix("**(")?.split_once(")**"))
        .map(|(number, _)| number.to_owned())
        .collect();
    let set: BTreeSet<String> = numbers.iter().cloned().collect();
    assert_eq!(set.len(), numbers.len(), "docs/NOTATION.md uses a number twice");
    set
}

/// Equation numbers in `eq. (D5)`, `eqs. (K2)–(K5)`, `eqs. (D4), (D6) and (T1)`; ranges are filled in.
fn cited(text: &str) -> Vec<String> {
    let words: Vec<&str> = text.split_whitespace().filter(|word| !["//", "///", "//!"].contains(word)).collect();
    let text = words.join(" ");
    let mut numbers = Vec::new();
    for (at, mark) in text.match_indices("eq. (").chain(text.match_indices("eqs. (")) {
        let mut rest = &text[at + mark.len() - 1..];
        let mut range_from: Option<u32> = None;
        while let Some((number, after)) = rest.strip_prefix('(').and_then(|inside| inside.split_once(')')) {
            let chapter = number.chars().next().filter(char::is_ascii_uppercase);
            let (Some(chapter), Ok(last)) = (chapter, number.get(1..).unwrap_or_default().parse()) else { break };
            let first = range_from.map_or(last, |first: u32| first + 1);
            numbers.extend((first..=last).map(|n| format!("{chapter}{n}")));
            let joint = ["–", ", ", " and "].into_iter().find(|joint| after.starts_with(&format!("{joint}(")));
            let Some(joint) = joint else { break };
            range_from = (joint == "–").then_some(last);
            rest = &after[joint.len()..];
        }
    }
    numbers
}

/// Texts between single backticks outside of code blocks.
fn code_spans(text: &str) -> Vec<&str> {
    let outside = text.split("```").step_by(2);
    outside.flat_map(|part| part.split('`').skip(1).step_by(2)).collect()
}

/// Code blocks of a language.
fn code_blocks<'a>(text: &'a str, language: &str) -> Vec<&'a str> {
    let blocks = text.split("```").skip(1).step_by(2);
    blocks.filter_map(|block| block.strip_prefix(language)?.strip_prefix('\n')).collect()
}
