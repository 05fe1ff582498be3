//! `foldwing examples`: lists the examples embedded in the command, and copies them.

use crate::cli::outlets::{Force, Mark, Outlets, Place, Quiet};
use crate::cli::shipped::Example;
use crate::cli::{Failure, print};
use foldwing_study::names::NameError;
use serde_json::json;
use std::borrow::Cow;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use wildmatch::WildMatch;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::EXAMPLES)]
pub struct Arguments {
    /// Examples: names, patterns (`turbine/*`) or folders [default: all]
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// Copy the examples and the files that they need into this folder; identical files are not rewritten
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    output: Option<PathBuf>,
    /// Print JSON for programs
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    force: Force,
    #[command(flatten)]
    quiet: Quiet,
}

/// Lists the examples, or copies them.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let chosen = chosen(&arguments.names)?;
    let Some(folder) = &arguments.output else {
        return print(&if arguments.json { as_json(&chosen) } else { list(&chosen) });
    };
    let mut files: Vec<Example> = Vec::new();
    for example in chosen.iter().flat_map(|example| std::iter::once(*example).chain(example.needed())) {
        if !files.contains(&example) {
            files.push(example);
        }
    }
    let mut outlets = Outlets::new(arguments.force.force, []);
    // determine all output paths before writing the first file: an error leaves no files behind
    let mut places: Vec<(Place, Cow<str>)> = Vec::new();
    let mut equal = 0;
    for example in &files {
        let (path, text) = (folder.join(example.name), example.text());
        if holds(&path, &text) {
            equal += 1;
            continue;
        }
        places.push((outlets.place(&path, Mark::Never)?, text));
    }
    for (place, text) in places {
        place.fill(text.as_bytes())?;
    }
    if arguments.json {
        let value = json!({ "files": outlets.files(), "left_as_they_are": equal });
        return arguments.quiet.print(&format!("{value:#}"), &outlets);
    }
    if !arguments.quiet.quiet {
        outlets.report();
        if equal > 0 {
            arguments.quiet.note(&format!("{equal} of the files are in {} already", folder.display()));
        }
    }
    Ok(())
}

/// Returns the examples with the given names; without names, those that can be used on their own.
fn chosen(names: &[String]) -> Result<Vec<Example>, Failure> {
    if names.is_empty() {
        return Ok(Example::all().filter(Example::is_listed).collect());
    }
    let mut list: Vec<Example> = Vec::new();
    for name in names {
        let plain = name.trim_start_matches("./").trim_start_matches("examples/").trim_end_matches('/');
        let (pattern, below) = (WildMatch::new(plain), format!("{plain}/"));
        let file = |example: &Example| example.name.rsplit('/').next() == Some(plain);
        let found: Vec<Example> = Example::all()
            .filter(|example| pattern.matches(example.name) || example.name.starts_with(&below) || file(example))
            .collect();
        if found.is_empty() {
            // file names are accepted as well as paths
            let known =
                Example::all().flat_map(|example| [Some(example.name), example.name.rsplit('/').next()]).flatten();
            let NameError::Unknown { nearest, .. } = NameError::unknown(plain, "example", known) else { continue };
            let hint =
                nearest.map_or("`foldwing examples` lists them".to_owned(), |name| format!("did you mean `{name}`?"));
            return Err(Failure::Usage(format!("no example is named `{name}`; {hint}")));
        }
        list.extend(found.into_iter().filter(|example| !list.contains(example)).collect::<Vec<_>>());
    }
    Ok(list)
}

fn list(examples: &[Example]) -> String {
    let width = examples.iter().map(|example| example.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    for example in examples {
        let _ = writeln!(text, "{}", format!("{:width$}  {}", example.name, example.summary()).trim_end());
    }
    text + "\nfoldwing examples -o DIR copies all, foldwing examples NAME -o DIR one with the files that it needs"
}

fn as_json(examples: &[Example]) -> String {
    let entry = |example: &Example| {
        let needs: Vec<&str> = example.needed().iter().map(|other| other.name).collect();
        json!({ "name": example.name, "summary": example.summary(), "needs": needs })
    };
    format!("{:#}", json!(examples.iter().map(entry).collect::<Vec<_>>()))
}

/// Returns whether the file has exactly this text.
pub(super) fn holds(path: &Path, text: &str) -> bool {
    std::fs::read(path).is_ok_and(|found| found == text.as_bytes())
}
