//! `docs/MODEL_FILE.md`: the reference of all keys, written from the schema.

use crate::json::Json;
use crate::schema::{Node, allowed, is_required, properties, shortest, tagged, tree};
use foldwing_engine::machine::validate::joint::RESERVED;
use std::fmt::Write;

const HEAD: &str = "\
# The model file

This page is generated from the schema that checks the file (`foldwing schema` prints it for editors); a test
keeps it current. Keys end in their unit. Angles are in degrees if the key ends in `_deg`; everything else is SI. An
unknown key, a missing one or a value outside its range is refused with file, line, key, value and what is allowed.
`examples/models/` has complete files; `foldwing new mywing.toml` writes one to start from, with every key explained.

- Vectors are resolved in the root frame unless their key says otherwise. A body's section frame has `x` along the
  axis, `y` chordwise, `z` through the thickness; without rotations it equals the root frame.
- Strains are ordered `(εx, κx, κy, κz)`: stretch, twist, curvature about `y` (flap), curvature about `z` (lag).
- Names are identifiers: letters, digits and `_`, no digit first. Joint names are groups of the FMU's variables and
  must not be one of RESERVED.
  A body must not be called `root`.
- A function along a body is a number, `{ polynomial = [c0, c1, …] }` in powers of the distance `s` from the body's
  inner end in m, or `{ table = [[s, value], …] }` with ascending `s`: linear between the rows, constant
  outside them. A number is a constant, except in `width_taper` and `height_taper`.
- Every body has exactly one joint with it as `child`. Bodies may branch: several may be attached to the root or to one body.
- A machine with closed loops is cut into such a tree; a table `[loop.<name>]` closes each loop again. A loop that is open
  by more than 0.001 of the longer body's length, in the unstrained machine at its start angles, is refused.
- Numbers are finite and at most 1e30 in magnitude.
";

/// Ends the page's introduction; the diff is what a test applies.
const START: &str = concat!(
    "\
## From the starter to a wing of three bodies

`foldwing new mywing.toml` writes a wing with two bodies; these nine lines add a third, with a second fold that starts
folded to the other side and latches on its own. Then run `foldwing package mywing.toml -o mywing.fmu`.

```diff
",
    include_str!("../../../examples/starter_three_bodies.diff"),
    "\
```

## Completion in an editor

Editors that know Taplo (Even Better TOML in Visual Studio Code, Zed, Helix and others) complete keys, show their meaning and
mark mistakes as you type, with the JSON schema named in the first line of the file:

```toml
#:schema ./foldwing.schema.json
```

The path is relative to the model file. `foldwing new` writes the schema next to the model (`--no-schema`: neither file nor
line); `foldwing schema > foldwing.schema.json` writes it for a model of your own, and again after an update. The models in
`examples/models/` have theirs in that folder. Foldwing itself ignores the line.

## The models in `examples/models/`

| file | what it shows |
|---|---|
| `folding_wing.toml` | the folding wing of the deployment experiment: spring, damper, motor, latch; without air |
| `folding_wing_constant.toml`, `folding_wing_as_printed.toml` | the same with 15 constant elements per body; with the printed spring |
| `folding_wing_in_tunnel.toml` | the same in a wind tunnel: vortex lattice, mirror plane |
| `three_bodies.toml` | two folds to opposite sides, which latch at different times |
| `roll_fold.toml` | a rolled-up wing whose two folds open one after the other: [picture](pictures/roll_fold.png) |
| `flared_wing_tip.toml` | a tip that folds freely about a flared axis and relieves a gust: [picture](pictures/flared_wing_tip.png) |
| `slender_wing.toml` | a curved, tapered wing of high aspect ratio, bent up by a third of its span, in a gust: [picture](pictures/slender_wing.png) |
| `goland_wing.toml` | Goland's wing just below its flutter speed: strips, an explicit section, a gust |
| `branched.toml` | two winglets on one wing, bend–twist coupling, a driven and a prescribed fold |
| `curved_blade.toml` | a blade curved, twisted and tapered without loads |
| `double_pendulum.toml` | ball and revolute joints |
| `four_bar.toml` | a closed loop: a linkage with a motor |
| `flying_wing.toml` | a free body: no root |
"
);

/// The reference of all keys as Markdown, the text of `docs/MODEL_FILE.md`.
pub fn reference() -> String {
    let mut page = HEAD.replace("RESERVED", &format!("`{}`", RESERVED.join("`, `")));
    page += &format!("\n{START}");
    let tree = tree();
    let top = Node::root(&tree);
    table(&mut page, "Top level", top);
    for (key, property) in properties(top) {
        let items = property.child("additionalProperties");
        if items.is_table() {
            group(&mut page, &format!("[{key}.<name>]"), items.resolve());
        } else if property.resolve()["type"] == "object" {
            group(&mut page, &format!("[{key}]"), property.resolve());
        }
    }
    page
}

/// A table of the file with its variants and the tables inside it.
fn group(page: &mut String, title: &str, schema: Node) {
    match tagged(schema) {
        Some((tag, variants)) => {
            for (name, variant) in variants {
                table(page, &format!("{title} with {tag} = {name:?}"), variant);
                inner_tables(page, title, variant);
            }
        }
        None => table(page, title, schema),
    }
    inner_tables(page, title, schema);
}

fn inner_tables(page: &mut String, title: &str, schema: Node) {
    for (key, property) in properties(schema) {
        let inner = property.resolve();
        if inner["type"] == "object" {
            group(page, &format!("{}.{key}]", title.trim_end_matches(']')), inner);
        }
    }
}

fn table(page: &mut String, title: &str, schema: Node) {
    let description = schema["description"].as_str().unwrap_or_default();
    let mut rows = String::new();
    for (key, property) in properties(schema) {
        let words = allowed_words(key, property);
        let default = default_words(&schema, key, &property);
        let meaning = property["description"]
            .as_str()
            .or(property.resolve()["description"].as_str())
            .unwrap_or_default()
            .to_owned();
        rows += &format!("| `{key}` | {} | {default} | {} |\n", cell(&words), cell(&meaning));
    }
    let head = "| key | allowed | default | meaning |\n|---|---|---|---|\n";
    // Writing to a String cannot fail.
    let _ = write!(page, "\n## {}\n\n{description}\n\n{head}{rows}", title.replace('[', "`[").replace(']', "]`"));
}

fn allowed_words(key: &str, property: Node) -> String {
    match property["const"].as_str() {
        Some(constant) => format!("{constant:?}"),
        None if property["additionalProperties"].is_table() => format!("tables `[{key}.<name>]`"),
        None => allowed(key, property),
    }
}

fn default_words(schema: &Json, key: &str, property: &Json) -> String {
    match &property["default"] {
        _ if is_required(schema, key) => "required".to_owned(),
        Json::Table(_) | Json::Null => "–".to_owned(),
        Json::Number(number) => format!("`{}`", shortest(*number)),
        Json::List(items) => {
            let items: Vec<String> = items.iter().filter_map(Json::as_f64).map(shortest).collect();
            format!("`[{}]`", items.join(", "))
        }
        Json::Text(text) => format!("`{text:?}`"),
        Json::Flag(flag) => format!("`{flag}`"),
    }
}

/// Text that stands in a Markdown table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}
