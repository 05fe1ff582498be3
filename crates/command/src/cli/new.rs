//! `foldwing new`: writes a model file to start from.

use crate::cli::examples::holds;
use crate::cli::outlets::{Mark, Outlets, Quiet};
use crate::cli::shipped::Example;
use crate::cli::{Failure, print};
use foldwing_file as config;
use serde_json::json;
use std::path::{Path, PathBuf};

/// The starter model file, which is itself valid. [`NAME`] and [`FILE`] are placeholders for the names of the model and of its
/// file.
const STARTER: &str = include_str!("starter.toml");

/// Name of the schema file next to the model, as in the first line of [`STARTER`].
const SCHEMA: &str = "foldwing.schema.json";

/// Beginning of the line of [`STARTER`] with the model's name.
const NAME: &str = "name = \"MyWing\"";

/// Placeholder for the file's name in [`STARTER`].
const FILE: &str = "MODEL";

/// Start of the file.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Template {
    /// Two bodies that unfold and latch, every key explained
    Wing,
    /// Free aircraft with folding wing tips, elevator, rudder and ailerons
    Aircraft,
    /// Wind turbine: the NREL 5 MW reference turbine, with its polars
    Turbine,
    /// Folding wing that unfolds in a wind tunnel, with a vortex lattice
    Tunnel,
    /// Half wing with a folding tip that carries an aileron
    Aileron,
}

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::NEW)]
pub struct Arguments {
    /// Model file to write; the model gets the name of the file
    model: PathBuf,
    /// Model to start from
    #[arg(short, long, value_enum, default_value = "wing")]
    template: Template,
    /// Overwrite existing files
    #[arg(long)]
    force: bool,
    /// Do not write the schema, which lets editors complete and check the file
    #[arg(long)]
    no_schema: bool,
    #[command(flatten)]
    quiet: Quiet,
    /// Print the name of the model and the paths of the written files as JSON, for programs
    #[arg(long)]
    json: bool,
}

/// Model file below `examples/` from which a template is made, and the commands to run next with their effects; `MODEL` is the
/// placeholder of the file.
type Source = (&'static str, &'static [(&'static str, &'static str)]);

impl Template {
    /// Source of the template; `None` for the wing, whose text is [`STARTER`].
    fn source(self) -> Option<Source> {
        match self {
            Self::Wing => None,
            Self::Aircraft => Some((
                "flight/folding_aircraft.toml",
                &[
                    ("check MODEL", "a check and a summary, with a drawing"),
                    (
                        "trim MODEL --solve-for attitude.pitch --solve-for 'load.fuselage[1].force.x' \
                         --solve-for aero.control_surface.elevator_left.angle_command,aero.control_surface.elevator_right.angle_command",
                        "straight and level flight: pitch, thrust, elevator",
                    ),
                    ("simulate MODEL --view flight.html", "the flight; a page for the browser plays the motion"),
                ],
            )),
            Self::Turbine => Some((
                "turbine/nrel_5mw_wind.toml",
                &[
                    ("check MODEL", "a check and a summary, with a drawing"),
                    (
                        "simulate MODEL --stop 20 --view turbine.html",
                        "20 s in wind; a page for the browser plays the motion",
                    ),
                    (
                        "operating-points MODEL --wind-m-s 6,8,10 --tip-speed-ratio 7.55 --speed-rpm 12.1",
                        "power, thrust and loads versus wind speed",
                    ),
                ],
            )),
            Self::Tunnel => Some((
                "models/folding_wing_in_tunnel.toml",
                &[
                    ("check MODEL", "a check and a summary, with a drawing"),
                    (
                        "simulate MODEL --view tunnel.html",
                        "unfold it in the wind; a page for the browser plays the motion",
                    ),
                    ("package MODEL -o tunnel.fmu", "the FMU for your simulation tool"),
                ],
            )),
            Self::Aileron => Some((
                "aileron/folding_aileron.toml",
                &[
                    ("check MODEL", "a check and a summary, with a drawing"),
                    ("simulate MODEL --view aileron.html", "the motion; a page for the browser plays it"),
                    ("flutter MODEL --wind-m-s 10:40:7", "modes versus wind speed"),
                ],
            )),
        }
    }
}

/// Writes the template and, next to it, the files that it needs and the schema named in its first line.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let path = &arguments.model;
    let shown = path.display();
    let stem = path.file_stem().filter(|_| !path.to_string_lossy().ends_with(['/', '\\']));
    let Some(name) = stem.map(|stem| identifier(&stem.to_string_lossy())) else {
        return Err(Failure::Usage(format!("{shown}: is not a file name; allowed: a path such as wings/mywing.toml")));
    };
    if path.extension().is_none_or(|extension| extension != "toml") {
        return Err(Failure::Usage(format!(
            "{shown}: the name of a model file must end in .toml; write {}",
            path.with_extension("toml").display()
        )));
    }
    let mut outlets = Outlets::new(arguments.force, []);
    let model = outlets.place(path, Mark::Never)?;
    let own_name = path.file_name().map(Path::new).unwrap_or(path);
    let (mut text, commands, parts) = match arguments.template.source() {
        None => (
            STARTER.replace(FILE, &quoted(own_name)).replacen(NAME, &named(&name), 1),
            starter_commands(path),
            Vec::new(),
        ),
        Some((source, next)) => {
            let Some(example) = Example::named(source) else {
                return Err(Failure::Files(format!("{source}: is not among the examples of this build")));
            };
            (template(&example, next, own_name, &name), commands(next, path), parts(&example))
        }
    };
    let schema = path.with_file_name(SCHEMA);
    if arguments.no_schema {
        text = text.split_once("\n\n").map_or(text.clone(), |(_, rest)| rest.to_owned());
    }
    let mut files = Vec::new();
    for (part, text) in parts {
        let beside = path.with_file_name("").join(part);
        if !holds(&beside, &text) {
            files.push((outlets.place(&beside, Mark::Never)?, text));
        }
    }
    // write the schema first: if it fails, no model file is left behind
    if !arguments.no_schema && !holds(&schema, &config::schema()) {
        let place = outlets.place(&schema, Mark::SCHEMA).map_err(|failure| {
            if let Failure::Files(message) = failure {
                Failure::Files(format!("{message}, --no-schema leaves it as it is"))
            } else {
                failure
            }
        })?;
        place.fill(config::schema().as_bytes())?;
    }
    files.into_iter().try_for_each(|(place, text)| place.fill(text.as_bytes()))?;
    model.fill(text.as_bytes())?;
    if arguments.json {
        return print(&format!("{:#}", json!({ "name": name, "model": shown.to_string(), "files": outlets.files() })));
    }
    if arguments.quiet.quiet {
        return Ok(());
    }
    // then write the model, and the other files
    let mut written = outlets.files();
    written.rotate_right(1);
    let written = match &written[..] {
        [model, rest @ ..] if rest.len() > 2 => format!("{model} and {} files next to it", rest.len()),
        list => list.join(" and "),
    };
    print(&format!("wrote {written}; next commands:\n{commands}"))
}

/// Text of a template: an example with the commands to run next in its header, for a file named `file` and a model named `name`.
fn template(example: &Example, next: &[(&str, &str)], file: &Path, name: &str) -> String {
    let text = example.text();
    let own = example.name.rsplit('/').next().unwrap_or(example.name);
    let body = text.split_once('\n').map_or("", |(_schema, body)| body).trim_start_matches('\n');
    let body: String = body
        .lines()
        .map(|line| if line.starts_with("name = \"") { named(name) } else { line.replace(own, &quoted(file)) } + "\n")
        .collect();
    let head: String = next
        .iter()
        .map(|(command, what)| format!("#   foldwing {}\n#       {what}\n", command.replace(FILE, &quoted(file))))
        .collect();
    format!(
        "#:schema ./{SCHEMA}\n\n# Made from the example {}. It is valid as it is. Next commands, in this folder:\n#\n{head}#\n{body}",
        example.name
    )
}

/// Files that an example needs in addition to the schema, with paths relative to the folder of the model.
fn parts(example: &Example) -> Vec<(String, String)> {
    let folder = example.name.rsplit_once('/').map_or("", |(folder, _)| folder);
    let below = |part: &Example| {
        part.name.strip_prefix(folder)?.strip_prefix('/').map(|name| (name.to_owned(), part.text().into_owned()))
    };
    example.needed().iter().filter(|part| !part.name.ends_with(SCHEMA)).filter_map(below).collect()
}

/// Line of a model file with the name of the model.
fn named(name: &str) -> String {
    format!("name = \"{name}\"")
}

/// Commands in the header of the starter, for a model at a path.
fn starter_commands(path: &Path) -> String {
    let lines = STARTER.lines().filter_map(|line| line.strip_prefix("#   foldwing "));
    lines.map(|line| format!("  foldwing {}\n", line.replace(FILE, &quoted(path)))).collect()
}

/// Commands of a template, for a model at a path.
fn commands(next: &[(&str, &str)], path: &Path) -> String {
    next.iter().map(|(command, _)| format!("  foldwing {}\n", command.replace(FILE, &quoted(path)))).collect()
}

/// Formats a path as a shell argument: quoted if it has spaces, always on one line.
fn quoted(path: &Path) -> String {
    let text: String = path.display().to_string().chars().map(|c| if c.is_control() { '?' } else { c }).collect();
    if text.contains(' ') { format!("\"{text}\"") } else { text }
}

/// Model name made from the file name: letters, digits and `_` are kept, other characters become `_`, and the first is never a
/// digit.
fn identifier(stem: &str) -> String {
    let name: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if name.starts_with(|first: char| first.is_ascii_digit()) { format!("wing_{name}") } else { name }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_become_identifiers() {
        for (stem, name) in [("mywing", "mywing"), ("my wing-2", "my_wing_2"), ("2wings", "wing_2wings"), ("é", "_")] {
            assert_eq!(identifier(stem), name);
        }
    }

    /// Each placeholder occurs where it is expected and nowhere else.
    #[test]
    fn the_starter_has_its_placeholders() {
        assert_eq!(STARTER.matches(&format!("\n{NAME}")).count(), 1);
        assert_eq!(STARTER.matches(FILE).count(), STARTER.matches("foldwing ").count());
        assert!(STARTER.starts_with(&format!("#:schema ./{SCHEMA}\n\n")));
    }

    /// Every key of the starter is explained: by a comment on its line, or by a line above that starts with its name.
    #[test]
    fn every_key_of_the_starter_is_explained() {
        let lines: Vec<&str> = STARTER.lines().collect();
        for (number, line) in lines.iter().enumerate() {
            let code = line.strip_prefix('#').filter(|rest| rest.starts_with(|c: char| c.is_ascii_lowercase()));
            let Some((key, value)) = code.unwrap_or(line).split_once(" = ") else { continue };
            if line.starts_with("# ") || !key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
                continue;
            }
            let inside =
                value.split(['{', ',', '}']).filter_map(|part| part.split_once(" = ")).map(|(key, _)| key.trim());
            let keys: Vec<&str> = if value.starts_with('{') { inside.collect() } else { vec![key] };
            for key in keys {
                let above = lines[..number].iter().any(|line| {
                    let words = line.trim_start_matches('#').trim_start();
                    line.starts_with('#') && words.starts_with(&format!("{key}  "))
                        || line.contains(&format!("{key} = ")) && line.contains("  # ")
                });
                assert!(line.contains("  # ") || above, "line {}: {key} is not explained", number + 1);
            }
        }
    }
}
