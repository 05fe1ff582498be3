//! Writes the page of the documentation in which models run: `live_site OUTPUT`, which `make live-site` calls.
//!
//! OUTPUT gets `index.html`, which is the viewer page with an editor, and `models.js` with the schema of the model
//! file and the texts of the gallery, other files embedded.
//! The engine itself, `engine.js`, is written by `tools/live_site.py`.

use foldwing_command::report::viewer::page_of_runs;
use serde_json::{Value, json};
use std::error::Error;
use std::path::Path;

const CODEMIRROR: &str = include_str!("../page/vendor/codemirror.js");
const STYLES: &str = include_str!("../page/editor.css");
const WORKER: &str = include_str!("../page/worker.js");
const COMPLETION: &str = include_str!("../page/completion.js");
const SCHEMA: &str = include_str!("../../../examples/models/foldwing.schema.json");
const EDITOR: &str = include_str!("../page/editor.js");
const GALLERY: &str = include_str!("../page/gallery.json");

fn main() -> Result<(), Box<dyn Error>> {
    let output = std::env::args().nth(1).ok_or("live_site OUTPUT")?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let gallery: Vec<Value> = serde_json::from_str(GALLERY)?;
    let models = gallery.iter().map(|row| model(&root, row)).collect::<Result<Vec<_>, _>>()?;
    std::fs::create_dir_all(&output)?;
    let write = |name: &str, text: String| std::fs::write(Path::new(&output).join(name), text);
    let schema: Value = serde_json::from_str(SCHEMA)?;
    write("models.js", format!("const MODELS = {};\nconst SCHEMA = {};\n", script(&json!(models)), script(&schema)))?;
    let scripts = format!("const WORKER = {};\n{COMPLETION}{EDITOR}", script(&json!(WORKER)));
    write(
        "index.html",
        page_of_runs("Models that run", STYLES, CODEMIRROR, &scripts, "<script src=\"models.js\"></script>\n"),
    )?;
    Ok(())
}

/// Name and text of a row of the gallery.
fn model(root: &Path, row: &Value) -> Result<Value, Box<dyn Error>> {
    let (name, file) = row["name"].as_str().zip(row["model"].as_str()).ok_or("a row has `name` and `model`")?;
    let (_, text) = foldwing_file::read(root.join(file))?;
    Ok(json!({ "name": name, "text": text }))
}

/// JSON within a script element of a page that has no placeholder left.
fn script(value: &Value) -> String {
    value.to_string().replace('<', "\\u003c").replace("{{", "{\\u007b")
}
