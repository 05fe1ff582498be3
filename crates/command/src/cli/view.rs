//! `foldwing view`: animation of a run in the browser.

use crate::cli::grid::GridArguments;
use crate::cli::outlets::{Force, Mark};
use crate::cli::{Failure, print, simulate, tell};
use clap::builder::NonEmptyStringValueParser;
use serde_json::json;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::VIEW)]
pub struct Arguments {
    /// Model file, which is simulated first; or a page of `simulate --view`
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Page to write for a model [default: the model's name with .html, in this folder]
    #[arg(short, long, value_name = "OUT.html")]
    output: Option<PathBuf>,
    /// Inputs over time, as in `simulate`
    #[arg(long, value_name = "IN.csv")]
    inputs: Option<PathBuf>,
    /// Start value of an input or parameter; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    #[command(flatten)]
    grid: GridArguments,
    /// Data to overlay, as in `simulate`; may be repeated
    #[arg(long = "compare", value_name = "FILE")]
    beside: Vec<PathBuf>,
    /// Write the page without opening it
    #[arg(long)]
    no_open: bool,
    #[command(flatten)]
    force: Force,
    /// Print the summary as JSON for programs, as `simulate` does; for an existing page only its name
    #[arg(long)]
    json: bool,
    /// Print no summary
    #[arg(short, long)]
    quiet: bool,
}

/// Simulates a model and opens its page in the browser; an existing page is opened directly.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let run = &arguments.run;
    let extension = run.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let page = match extension.as_str() {
        "html" | "htm" => {
            if !run.is_file() {
                return Err(Failure::Files(format!("{}: cannot be read: there is no such file", run.display())));
            }
            if !Mark::PAGE.is_on(run) {
                return Err(Failure::Refused(format!(
                    "{}: is not a page of foldwing; `foldwing simulate MODEL --view {0}` makes one",
                    run.display()
                )));
            }
            if arguments.json {
                print(&format!("{:#}", json!({ "page": run.display().to_string() })))?;
            }
            run.clone()
        }
        "csv" => {
            let shown = run.display();
            return Err(Failure::Usage(format!(
                "{shown}: a table has no geometry to animate; name the model, and the table with --compare {shown}"
            )));
        }
        _ => {
            let named = arguments.output.clone();
            let page = named.unwrap_or_else(|| match run.file_name().filter(|_| run != Path::new("-")) {
                Some(name) => Path::new(name).with_extension("html"),
                None => PathBuf::from("run.html"),
            });
            simulate::run(&simulate::Arguments::for_page(
                run.clone(),
                page.clone(),
                arguments.inputs.clone(),
                arguments.settings.clone(),
                arguments.grid.clone(),
                arguments.beside.clone(),
                (arguments.force.clone(), arguments.quiet, arguments.json),
            ))?;
            page
        }
    };
    if !arguments.no_open
        && page != Path::new("-")
        && let Err(error) = open::that_detached(&page)
    {
        tell::note(&format!("no browser could be started ({error}); open {} in one", page.display()));
    }
    Ok(())
}
