//! The JSON schema of the model file, derived from the serde structs, and its use by the checks.

use crate::file::ModelFile;
use crate::json::Json;
use foldwing_engine::machine::UNLIMITED;
use foldwing_engine::machine::units::finite;
pub(super) use foldwing_engine::machine::units::{quoted, shortest};
use foldwing_engine::machine::validate::IDENTIFIER_ALLOWED;
use serde_json::{Map, Value, json};
use std::ops::Deref;

/// Pattern for the names of sections, bodies, joints, masses and gauges.
pub(super) const IDENTIFIER: &str = "^[A-Za-z_][A-Za-z0-9_]*$";

/// Description of a function along a body, appended to that of a number.
const FUNCTION_ALLOWED: &str = "{ polynomial = [c0, c1, …] } or { table = [[s, value], …] }";

/// Maximum number of tables named in a message.
const MAXIMUM_HOMES: usize = 4;

/// Returns the JSON schema (draft 2020-12) of the model file, pretty-printed, for editors that complete TOML.
pub fn schema() -> String {
    let mut text = format!("{:#}", derived());
    text.push('\n');
    text
}

/// Result of [`schema`] as a constant: nothing is parsed for a model file, and nothing remains when the library is unloaded.
#[expect(clippy::approx_constant, reason = "a default of the schema is 2π")]
pub(super) static TREE: Json = include!(concat!(env!("OUT_DIR"), "/schema_tree.rs"));

/// Derives the schema from the structs.
fn derived() -> Value {
    let mut tree = schemars::schema_for!(ModelFile).to_value();
    tidy(&mut tree);
    tree
}

/// Node of the schema.
#[derive(Clone, Copy)]
pub(super) struct Node(&'static Json);

impl Node {
    /// Root of the schema.
    pub fn root() -> Self {
        Self(&TREE)
    }

    /// Node of a key; null if there is none.
    pub fn child(self, key: &str) -> Self {
        Self(&self.0[key])
    }

    /// Nodes of an array under a key.
    pub fn children(self, key: &str) -> Option<impl Iterator<Item = Self> + use<>> {
        Some(self.0[key].as_list()?.iter().map(Self))
    }

    /// Definition to which the node refers, if it does.
    pub fn reference(self) -> Option<&'static str> {
        self.0["$ref"].as_str()
    }

    /// Follows a `$ref` into `$defs`.
    pub fn resolve(self) -> Self {
        let target = self.0["$ref"].as_str().and_then(|path| path.strip_prefix("#/$defs/"));
        target.map_or(self, |name| Self(&TREE["$defs"][name]))
    }
}

impl Deref for Node {
    type Target = Json;

    fn deref(&self) -> &Json {
        self.0
    }
}

/// Adapts the derived schema to TOML: no `null`, table names are identifiers, descriptions have one line.
fn tidy(node: &mut Value) {
    match node {
        Value::Array(items) => items.iter_mut().for_each(tidy),
        Value::Object(map) => {
            map.values_mut().for_each(tidy);
            tidy_object(map);
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

fn tidy_object(map: &mut Map<String, Value>) {
    if let Some(types) = map.get_mut("type").filter(|types| types.is_array()) {
        let kept: Vec<Value> = types.as_array().into_iter().flatten().filter(|t| **t != "null").cloned().collect();
        *types = kept.into_iter().next().unwrap_or_default();
    }
    if let Some(Value::Array(options)) = map.get("anyOf") {
        let kept: Vec<Value> = options.iter().filter(|option| option["type"] != "null").cloned().collect();
        if let [Value::Object(only)] = kept.as_slice() {
            map.remove("anyOf");
            only.iter().for_each(|(key, value)| {
                map.insert(key.clone(), value.clone());
            });
        }
    }
    // Rust's number types are not formats of JSON schema.
    if map.get("format").is_some_and(|format| format == "double" || format == "uint") {
        map.remove("format");
    }
    if map.get("default").is_some_and(Value::is_null) {
        map.remove("default");
    }
    if let Some(Value::Object(default)) = map.get_mut("default") {
        default.retain(|_, value| !value.is_null());
    }
    if map.get("additionalProperties").is_some_and(Value::is_object) {
        map.insert("propertyNames".to_owned(), json!({ "pattern": IDENTIFIER }));
    }
    if let Some(Value::String(description)) = map.get_mut("description") {
        *description = description.split_whitespace().collect::<Vec<_>>().join(" ");
    }
}

/// Keys of a table's schema, with their nodes.
pub(super) fn properties(schema: Node) -> impl Iterator<Item = (&'static str, Node)> {
    schema["properties"].entries().iter().map(|(key, value)| (*key, Node(value)))
}

/// Returns whether a table must contain the key.
pub(super) fn is_required(schema: &Json, key: &str) -> bool {
    schema["required"].as_list().into_iter().flatten().any(|name| *name == key)
}

/// Key that distinguishes the variants of a table, such as `shape` of a section, with their schemas.
pub(super) fn tagged(schema: Node) -> Option<(&'static str, Vec<(&'static str, Node)>)> {
    let variants: Vec<Node> = schema.children("oneOf")?.collect();
    let tag = properties(*variants.first()?).find(|(_, value)| value.get("const").is_some())?.0;
    let named =
        variants.iter().map(|variant| variant.0["properties"][tag]["const"].as_str().map(|name| (name, *variant)));
    Some((tag, named.collect::<Option<_>>()?))
}

/// Allowed texts of a key, if they are listed.
pub(super) fn options(schema: Node) -> Option<Vec<&'static str>> {
    if let Some(list) = schema.0["enum"].as_list() {
        return list.iter().map(Json::as_str).collect();
    }
    schema.children("oneOf")?.map(|option| option.0["const"].as_str()).collect()
}

/// Allowed values of a key as text, with quantity, range and unit, such as `a finite length > 0 m`.
pub(super) fn allowed(key: &str, schema: Node) -> String {
    if let Some(text) = schema["x-allowed"].as_str() {
        return text.to_owned();
    }
    let schema = schema.resolve();
    if let Some(options) = options(schema) {
        return quoted(&options);
    }
    if let Some((_, variants)) = tagged(schema) {
        return quoted(&variants.iter().map(|(name, _)| *name).collect::<Vec<_>>());
    }
    if schema["anyOf"].is_list() {
        return format!("{}, {FUNCTION_ALLOWED}", number(key, &schema, ""));
    }
    match schema["type"].as_str() {
        Some("number") => number(key, &schema, ""),
        Some("integer") => format!("a whole number{}", range(&schema)),
        Some("boolean") => "true or false".to_owned(),
        Some("array") => array(key, &schema),
        Some("object") => "a table".to_owned(),
        _ if schema["pattern"] == IDENTIFIER => IDENTIFIER_ALLOWED.to_owned(),
        _ => "a text in quotes".to_owned(),
    }
}

fn number(key: &str, schema: &Json, plural: &str) -> String {
    finite(key, &range(schema), plural)
}

fn array(key: &str, schema: &Json) -> String {
    let items = number(key, &schema["items"], "s");
    match (schema["minItems"].as_count(), schema["maxItems"].as_count()) {
        (Some(least), Some(most)) if least == most => format!("an array of {least} {items}"),
        (None | Some(0), Some(most)) => format!("an array of at most {most} {items}"),
        (Some(least), Some(most)) => format!("an array of {least} to {most} {items}"),
        (Some(least), None) => format!("an array of at least {least} {items}"),
        (None, None) => format!("an array of {items}"),
    }
}

/// Range of a number as text, preceded by a space; empty if there is none.
fn range(schema: &Json) -> String {
    let bound = |keyword: &str| schema[keyword].as_f64().map(shortest);
    if let (Some(least), Some(most)) = (bound("minimum"), bound("maximum")) {
        return format!(" from {least} to {most}");
    }
    let bounds = [("exclusiveMinimum", ">"), ("minimum", ">="), ("exclusiveMaximum", "<"), ("maximum", "<=")];
    let words: Vec<String> =
        bounds.iter().filter_map(|(keyword, sign)| bound(keyword).map(|value| format!("{sign} {value}"))).collect();
    if words.is_empty() { String::new() } else { format!(" {}", words.join(" and ")) }
}

/// Returns whether `value` is finite, not larger than [`UNLIMITED`], and within the range of the schema.
pub(super) fn in_range(value: f64, schema: &Json) -> bool {
    let bound = |keyword: &str, otherwise: f64| schema[keyword].as_f64().unwrap_or(otherwise);
    value.abs() <= UNLIMITED
        && value >= bound("minimum", f64::NEG_INFINITY)
        && value > bound("exclusiveMinimum", f64::NEG_INFINITY)
        && value <= bound("maximum", f64::INFINITY)
        && value < bound("exclusiveMaximum", f64::INFINITY)
}

/// Tables that have a key, in the notation of the file, such as `[joint.<name>.motor]`; empty if there are none or many.
pub(super) fn homes(key: &str) -> Vec<String> {
    let top = Node::root();
    let mut found: Vec<String> = Vec::new();
    let mut seen: Vec<usize> = Vec::new();
    let mut look = |title: String, schema: Node| {
        // a definition that several tables have is named once, and a table in one that has the key is not named
        let inner = found.iter().any(|home| title.starts_with(&format!("{}.", home.trim_end_matches(']'))));
        let definition = std::ptr::from_ref(schema.0).addr();
        let again = seen.contains(&definition);
        seen.push(definition);
        if !inner && !again && properties(schema).any(|(known, _)| known == key) {
            found.push(title);
        }
    };
    look("the top of the file, before the first table".to_owned(), top);
    for (name, property) in properties(top) {
        match property.child("additionalProperties").resolve() {
            inner if inner.is_table() => visit(&format!("[{name}.<name>]"), inner, &mut look),
            _ => {
                let table = property.resolve();
                visit(&format!("[{name}]"), table, &mut look);
                let named = table.child("additionalProperties").resolve();
                if named.is_table() {
                    visit(&format!("[{name}.<name>]"), named, &mut look);
                }
            }
        }
    }
    if found.len() > MAXIMUM_HOMES { Vec::new() } else { found }
}

/// Calls `look` for a table, its variants and the tables inside it.
fn visit(title: &str, schema: Node, look: &mut impl FnMut(String, Node)) {
    match tagged(schema) {
        Some((tag, variants)) => {
            variants.into_iter().for_each(|(name, variant)| look(format!("{title} with {tag} = {name:?}"), variant));
        }
        None => look(title.to_owned(), schema),
    }
    for (key, property) in properties(schema).filter(|(_, property)| property.resolve()["type"] == "object") {
        visit(&format!("{}.{key}]", title.trim_end_matches(']')), property.resolve(), look);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The stored schema is identical to that of the structs, also in its order; `make bless` writes it. The constant is the stored one.
    #[test]
    fn the_written_schema_is_current() {
        let derived = derived();
        let written: Value = serde_json::from_str(include_str!("../shipped/foldwing.schema.json")).expect("JSON");
        assert_eq!(written.to_string(), derived.to_string(), "`make bless`");
        assert!(same(&TREE, &derived));
    }

    /// Whether a constant tree has the entries of a value, in the same order.
    fn same(tree: &Json, value: &Value) -> bool {
        match (tree, value) {
            (Json::Null, Value::Null) => true,
            (Json::Flag(flag), Value::Bool(own)) => flag == own,
            (Json::Number(number), Value::Number(own)) => own.as_f64() == Some(*number),
            (Json::Text(text), Value::String(own)) => text == own,
            (Json::List(items), Value::Array(own)) => {
                items.len() == own.len() && items.iter().zip(own).all(|(item, own)| same(item, own))
            }
            (Json::Table(entries), Value::Object(own)) => {
                let pairs = entries.iter().zip(own);
                entries.len() == own.len()
                    && pairs.into_iter().all(|(entry, own)| entry.0 == own.0 && same(&entry.1, own.1))
            }
            _ => false,
        }
    }

    #[test]
    fn keys_have_homes() {
        assert_eq!(homes("capture_deg"), ["[joint.<name>.latch]"]);
        assert_eq!(homes("latch"), ["[joint.<name>]"]);
        assert_eq!(homes("gravity_m_s2"), ["the top of the file, before the first table"]);
        assert_eq!(homes("mass_kg_m"), ["[section.<name>] with shape = \"explicit\"", "[modal_body.<name>]"]);
        assert!(homes("body").is_empty(), "gauges, masses, loads, surfaces and the top have it");
    }
}
