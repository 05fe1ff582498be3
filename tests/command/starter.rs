//! `foldwing new` and the drawings of `foldwing check`, as on a terminal.

use std::path::Path;
use std::process::{Command, Output};

fn foldwing(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_foldwing")).current_dir(folder).args(arguments).output().expect("the command runs")
}

#[track_caller]
fn succeeds(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Exit code and message of an error.
fn refusal(output: &Output) -> (Option<i32>, String) {
    (output.status.code(), String::from_utf8_lossy(&output.stderr).trim_end().to_owned())
}

/// Latch time in s in the CSV of a default run.
fn latch_time_s(folder: &Path, model: &str) -> f64 {
    let csv = succeeds(&foldwing(folder, &["simulate", model, "-q", "--csv", "-", "--variables", "fold.latch_time"]));
    csv.lines().last().unwrap().split(',').nth(1).unwrap().parse().unwrap()
}

/// The starter is a valid model named after its file, unfolds and latches; the commands in it run as printed.
#[test]
fn the_starter_runs_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let told = succeeds(&foldwing(folder.path(), &["new", "my-wing.toml"]));
    assert!(told.starts_with("wrote my-wing.toml and foldwing.schema.json; next commands:\n"), "{told}");
    let text = std::fs::read_to_string(folder.path().join("my-wing.toml")).unwrap();
    assert!(text.starts_with("#:schema ./foldwing.schema.json\n") && text.contains("\nname = \"my_wing\""), "{text}");
    let schema = std::fs::read_to_string(folder.path().join("foldwing.schema.json")).unwrap();
    assert_eq!(schema, foldwing::config::schema());

    let commands: Vec<&str> = told.lines().filter_map(|line| line.trim().strip_prefix("foldwing ")).collect();
    assert_eq!(commands.len(), 4, "{told}");
    for command in commands.iter().filter(|command| !command.starts_with("package")) {
        // words end where the explanation begins, after two spaces
        let words: Vec<&str> = command.split("  ").next().unwrap().split(' ').collect();
        succeeds(&foldwing(folder.path(), &words));
        assert!(text.contains(&format!("#   foldwing {}", words.join(" "))), "{command}");
    }
    assert!(folder.path().join("wing.html").is_file() && folder.path().join("wing.csv").is_file());
    let latch_s = latch_time_s(folder.path(), "my-wing.toml");
    assert!(latch_s > 0.1 && latch_s < 0.5, "latch at {latch_s} s");
}

/// With the lines for the aerodynamics enabled, as described in the starter, the wing unfolds in wind: later.
#[test]
fn the_starter_unfolds_in_air() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(&foldwing(folder.path(), &["new", "wing.toml", "--no-schema"]));
    let path = folder.path().join("wing.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(!text.contains("#:schema") && !folder.path().join("foldwing.schema.json").exists());
    let still_s = latch_time_s(folder.path(), "wing.toml");
    let code = |line: &str| {
        let rest = line.strip_prefix('#').filter(|rest| rest.starts_with(|c: char| c == '[' || c.is_ascii_lowercase()));
        rest.unwrap_or(line).to_owned() + "\n"
    };
    let windy: String = text.lines().map(code).collect();
    assert_eq!(windy.matches("\n[surface.").count(), 2);
    std::fs::write(&path, windy).unwrap();
    assert!(succeeds(&foldwing(folder.path(), &["check", "wing.toml"])).contains("unsteady strips"));
    let windy_s = latch_time_s(folder.path(), "wing.toml");
    assert!(windy_s > 1.1 * still_s, "latch at {windy_s} s in air, at {still_s} s without");
}

/// File names that look like the text they replace, or that cannot be written unchanged in a comment.
#[test]
fn the_starter_takes_any_name() {
    for (file, name) in [
        ("MODEL_2.toml", "MODEL_2"),
        ("MyWing-2.toml", "MyWing_2"),
        ("my wing.toml", "my_wing"),
        ("3.toml", "wing_3"),
        #[cfg(unix)]
        ("a\nb = 1.toml", "a_b___1"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        succeeds(&foldwing(folder.path(), &["new", file]));
        let (machine, text) =
            foldwing::config::read(folder.path().join(file)).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(machine.name, name);
        let shown = file.replace('\n', "?");
        assert_eq!(text.matches(&shown).count(), 4, "{file}: once per command\n{text}");
    }
}

/// Nothing is overwritten without `--force`; a file that cannot be written leaves no other files.
#[test]
fn the_starter_overwrites_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let new = |arguments: &[&str]| foldwing(folder.path(), &[&["new"], arguments].concat());
    let path = folder.path().join("wing.toml");
    std::fs::write(&path, "mine").unwrap();
    let exists = "error: wing.toml: exists already; --force overwrites it";
    assert_eq!(refusal(&new(&["wing.toml", "--no-schema"])), (Some(4), exists.to_owned()));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    assert_eq!(refusal(&new(&["wing.toml"])), (Some(4), exists.to_owned()));
    assert!(!folder.path().join("foldwing.schema.json").exists(), "a refusal leaves no schema behind");
    succeeds(&new(&["wing.toml", "--force"]));
    assert_ne!(std::fs::read_to_string(&path).unwrap(), "mine");
    // the same schema serves the next model
    succeeds(&new(&["second.toml"]));

    let schema = folder.path().join("foldwing.schema.json");
    std::fs::write(&schema, "{}").unwrap();
    let exists = "error: foldwing.schema.json: exists and is not recognised as the schema of foldwing; --force overwrites it, \
         --no-schema leaves it as it is";
    assert_eq!(refusal(&new(&["third.toml"])), (Some(4), exists.to_owned()));
    assert!(!folder.path().join("third.toml").exists());
    assert_eq!(std::fs::read_to_string(&schema).unwrap(), "{}");

    let (code, said) = refusal(&new(&["wing"]));
    assert_eq!(
        (code, said.lines().next()),
        (Some(2), Some("error: wing: the name of a model file must end in .toml; write wing.toml"))
    );
    assert_eq!(refusal(&new(&["wing.toml/wing.toml"])).0, Some(4));
}

/// Every shipped model is drawn within 80 columns of ASCII, with a symbol for each kind of joint it has; as SVG with the names of its
/// joints.
#[test]
fn every_model_is_drawn() {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(&models).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let model = path.to_str().unwrap();
        let text = succeeds(&foldwing(folder.path(), &["check", model, "--draw", "wing.svg"]));
        let drawing = text.split_once("  from above").unwrap_or_else(|| panic!("{model}: no drawing")).1;
        assert!(drawing.is_ascii() && drawing.lines().all(|line| line.len() <= 80), "{model}\n{drawing}");
        assert!(drawing.contains("from the side") && drawing.contains("one column is"), "{model}\n{drawing}");
        let machine = foldwing::config::read(&path).unwrap().0;
        let svg = std::fs::read_to_string(folder.path().join("wing.svg")).unwrap();
        assert!(!svg.contains("var(") && !svg.contains("NaN") && svg.trim_end().ends_with("</svg>"), "{model}");
        for body in &machine.bodies {
            assert!(svg.contains(&format!("<title>joint {}</title>", body.joint.name)), "{model}");
        }
        let json = succeeds(&foldwing(folder.path(), &["check", model, "--json"]));
        assert!(serde_json::from_str::<serde_json::Value>(&json).is_ok(), "{model}: JSON without a drawing");
    }
    let bad =
        ["check", models.join("folding_wing.toml").to_str().unwrap(), "--draw", "wing.svg/wing.svg"].map(str::to_owned);
    let refused = refusal(&foldwing(folder.path(), &bad.each_ref().map(String::as_str)));
    assert_eq!(refused.0, Some(4), "{}", refused.1);
}
