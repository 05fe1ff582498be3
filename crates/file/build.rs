//! Converts the stored schema to a constant, so that no model file needs a parser of JSON.

use serde_json::Value;
use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};

const SCHEMA: &str = "shipped/foldwing.schema.json";

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed={SCHEMA}");
    println!("cargo:rerun-if-changed=build.rs");
    let schema: Value = serde_json::from_str(&fs::read_to_string(SCHEMA)?)
        .map_err(|error| format!("{SCHEMA}: {error}; take either side of a conflict and `make bless`"))?;
    let mut code = String::new();
    write(&schema, &mut code)?;
    fs::write(Path::new(&env::var("OUT_DIR")?).join("schema_tree.rs"), code)?;
    Ok(())
}

/// Writes a value as an expression of the type `Json`.
fn write(value: &Value, code: &mut String) -> Result<(), Box<dyn Error>> {
    match value {
        Value::Null => code.push_str("Json::Null"),
        Value::Bool(flag) => write!(code, "Json::Flag({flag})")?,
        Value::Number(number) => write!(code, "Json::Number({:?})", number.as_f64().ok_or("a number beyond f64")?)?,
        Value::String(text) => write!(code, "Json::Text({text:?})")?,
        Value::Array(items) => {
            code.push_str("Json::List(&[");
            for item in items {
                write(item, code)?;
                code.push(',');
            }
            code.push_str("])");
        }
        Value::Object(entries) => {
            code.push_str("Json::Table(&[");
            for (key, value) in entries {
                write!(code, "({key:?},")?;
                write(value, code)?;
                code.push_str("),");
            }
            code.push_str("])");
        }
    }
    Ok(())
}
