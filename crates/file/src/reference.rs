//! `docs/MODEL_FILE.md`: the reference of all keys, generated from the schema.

use crate::json::Json;
use crate::schema::{Node, allowed, is_required, properties, shortest, tagged};
use foldwing_engine::machine::validate::joint::RESERVED;
use foldwing_engine::math::strain::{NAMES, STRAINS};
use std::fmt::Write;

const HEAD: &str = "\
# The model file

This page is generated from the JSON schema that validates model files (`foldwing schema` prints it for editors); a test
keeps it current. Keys end in their unit. Angles are in degrees if the key ends in `_deg`; all other units are SI. Unknown
keys, missing keys and values outside their range are errors, reported with file, line, key, value and allowed values.
`examples/models/` contains complete files; `foldwing new mywing.toml` writes a template with every key explained.

- Vectors are resolved in the root frame unless the description of the key specifies another. A body's section frame has
  `x` along the axis, `y` chordwise, `z` through the thickness; without rotations it equals the root frame.
- Strains are ordered `(SYMBOLS)`: MEANINGS.
- Names are identifiers: letters, digits and `_`, not starting with a digit. Joint names prefix FMU variables and must
  not be one of RESERVED.
  A body must not be called `root`.
- A function along a body is a number, `{ polynomial = [c0, c1, …] }` in powers of the distance `s` from the body's
  inner end in m, or `{ table = [[s, value], …] }` with ascending `s`: linear between the rows, constant
  outside. A number is a constant, except in `width_taper` and `height_taper`.
- A section has a shape with dimensions and a material, or its stiffness and inertia are given. [Sections by shape](guide/sections.md) has
  the formulas, their limits and the library of materials.
- Every body is the `child` of exactly one joint. Topology is a tree: several bodies may be attached to the root or to one body.
- A model with closed kinematic loops is cut into such a tree, and a table `[loop.<name>]` closes each loop. An initial gap of
  more than 0.001 of the longer body's length, in the unstrained model at its start angles, is an error.
- Numbers are finite and at most 1e30 in magnitude.
";

/// End of the introduction of the page; a test applies the diff in it.
const START: &str = concat!(
    "\
## From the starter to a wing of three bodies

`foldwing new mywing.toml` writes a wing with two bodies; these nine lines add a third body with a second fold joint that
starts folded to the opposite side and has its own latch. Then run `foldwing package mywing.toml -o mywing.fmu`.

```diff
",
    include_str!("../shipped/starter_three_bodies.diff"),
    "\
```

## Completion in an editor

Editors with Taplo (Even Better TOML in Visual Studio Code, Zed, Helix and others) complete keys, show their descriptions and
highlight errors, using the JSON schema referenced in the first line of the file:

```toml
#:schema ./foldwing.schema.json
```

The path is relative to the model file. `foldwing new` writes the schema next to the model (`--no-schema`: neither file nor
line); `foldwing schema > foldwing.schema.json` writes it for existing models, and updates it for a new version. For the models
in `examples/models/` it is in that folder. Foldwing itself ignores the line.

## The models in `examples/models/`

| file | content |
|---|---|
| `folding_wing.toml` | the folding wing of the deployment experiment: spring, damper, motor, latch; without aerodynamics |
| `folding_wing_constant.toml`, `folding_wing_as_printed.toml` | the same with 15 constant-strain elements per body; with the spring stiffness as printed in the paper |
| `folding_wing_in_tunnel.toml` | the same in a wind tunnel: vortex lattice, mirror plane |
| `three_bodies.toml` | two fold joints to opposite sides that latch at different times |
| `roll_fold.toml` | a rolled-up wing with two fold joints that open in sequence: [picture](pictures/roll_fold.png) |
| `flared_wing_tip.toml` | a free folding wing tip with a flared hinge, for gust load alleviation: [picture](pictures/flared_wing_tip.png) |
| `slender_wing.toml` | a curved, tapered wing of high aspect ratio in a gust, with a deflection of a third of the span: [picture](pictures/slender_wing.png) |
| `goland_wing.toml` | Goland wing just below its flutter speed: strip theory, explicit section, gust |
| `branched.toml` | two winglets on one wing, bend–twist coupling, one fold joint with a motor, one prescribed |
| `curved_blade.toml` | a blade with natural curvature, twist and taper |
| `double_pendulum.toml` | ball and revolute joints |
| `four_bar.toml` | a closed kinematic loop: a four-bar linkage with a motor |
| `flying_wing.toml` | a free-flying body (free joint) |
"
);

/// Returns the reference of all keys as Markdown, the text of `docs/MODEL_FILE.md`.
pub fn reference() -> String {
    let names: [_; STRAINS] = std::array::from_fn(|strain| NAMES[strain]);
    let [symbols, meanings] = [names.map(|strain| strain.symbol), names.map(|strain| strain.meaning)];
    let mut page = HEAD
        .replace("RESERVED", &format!("`{}`", RESERVED.join("`, `")))
        .replace("SYMBOLS", &symbols.join(", "))
        .replace("MEANINGS", &meanings.join(", "));
    page += &format!("\n{START}");
    let top = Node::root();
    let mut seen = Vec::new();
    table(&mut page, "Top level", top);
    for (key, property) in properties(top) {
        let items = property.child("additionalProperties");
        if items.is_table() {
            group((&mut page, &mut seen), &format!("[{key}.<name>]"), items.resolve());
        } else if property.resolve()["type"] == "object" {
            let table = property.resolve();
            group((&mut page, &mut seen), &format!("[{key}]"), table);
            let named = table.child("additionalProperties");
            if named.is_table() {
                group((&mut page, &mut seen), &format!("[{key}.<name>]"), named.resolve());
            }
        }
    }
    page
}

/// The page, and the definitions of inner tables that it has.
type Page<'p> = (&'p mut String, &'p mut Vec<&'static str>);

/// Writes a table of the model file with its variants and the tables inside it.
fn group((page, seen): Page, title: &str, schema: Node) {
    match tagged(schema) {
        Some((tag, variants)) => {
            for (name, variant) in variants {
                table(page, &format!("{title} with {tag} = {name:?}"), variant);
                inner_tables((page, seen), title, variant);
            }
        }
        None => table(page, title, schema),
    }
    inner_tables((page, seen), title, schema);
}

fn inner_tables((page, seen): Page, title: &str, schema: Node) {
    for (key, property) in properties(schema) {
        let inner = property.resolve();
        let items = inner.child("additionalProperties");
        if items.is_table() {
            group((page, seen), &format!("{}.{key}.<name>]", title.trim_end_matches(']')), items.resolve());
        } else if inner["type"] == "object" {
            // a definition that several tables have is written once
            if property.reference().is_some_and(|name| seen.contains(&name)) {
                continue;
            }
            seen.extend(property.reference());
            group((page, seen), &format!("{}.{key}]", title.trim_end_matches(']')), inner);
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
    // writing to a String cannot fail
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

/// Escapes a text for a cell of a Markdown table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}
