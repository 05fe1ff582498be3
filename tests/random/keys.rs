//! Keys and words of the file format, from its schema, and those used in a model file.

use serde_json::Value;
use std::collections::BTreeSet;

/// Keys of the schema as paths, with `*` for a name, and words of the format as `path = "word"`; for a model file only those that it uses.
pub fn said(schema: &Value, file: Option<&Value>) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    walk(schema, schema, file, "", &mut found);
    // the tables of both degrees of freedom of a cylindrical joint are those of other joints, each with the keys of its own kind of motion
    let common = |key: String| match key.split('.').collect::<Vec<_>>()[..] {
        ["joint", "*", "rotation" | "translation", _, ..] if key.matches('.').count() > 3 => {
            key.replacen(".rotation", "", 1).replacen(".translation", "", 1)
        }
        _ => key,
    };
    found.into_iter().map(common).collect()
}

fn walk(schema: &Value, node: &Value, file: Option<&Value>, path: &str, found: &mut BTreeSet<String>) {
    if let Some(reference) = node["$ref"].as_str() {
        let target = schema.pointer(reference.trim_start_matches('#')).expect("a definition");
        walk(schema, target, file, path, found);
    }
    for choice in ["anyOf", "oneOf", "allOf"] {
        for branch in node[choice].as_array().into_iter().flatten() {
            walk(schema, branch, file, path, found);
        }
    }
    let words = node["enum"].as_array().into_iter().flatten().chain(node.get("const"));
    for word in words.filter(|word| word.is_string() && file.is_none_or(|file| file == *word)) {
        found.insert(format!("{path} = {word}"));
    }
    let inside = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    for (key, child) in node["properties"].as_object().into_iter().flatten() {
        let value = file.and_then(|file| file.get(key));
        if file.is_none() || value.is_some() {
            found.insert(inside(key));
            walk(schema, child, value, &inside(key), found);
        }
    }
    if node["additionalProperties"].is_object() {
        match file {
            None => walk(schema, &node["additionalProperties"], None, &inside("*"), found),
            Some(file) => {
                for value in file.as_object().into_iter().flatten().map(|(_, value)| value) {
                    walk(schema, &node["additionalProperties"], Some(value), &inside("*"), found);
                }
            }
        }
    }
}
