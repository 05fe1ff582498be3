//! Reads `tests/reference/cases.json`.

use serde_json::Value;

/// One case of the file by its name.
pub fn case(name: &str) -> Value {
    let text = include_str!("../reference/cases.json");
    let cases: Value = serde_json::from_str(text).expect("valid JSON");
    let list = cases.as_array().expect("a list of cases");
    list.iter().find(|case| case["name"] == name).unwrap_or_else(|| panic!("no case {name}")).clone()
}

/// A list of numbers.
pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}
