//! Functions along a body, given as a number, a polynomial or a table.

use crate::checker::Checker;
use foldwing_engine::beam::profile::Profile;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Function of the distance `s` from a body's inner end.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum FunctionFile {
    /// A number.
    Number(f64),
    /// A polynomial or a table.
    Curve(CurveFile),
}

/// Polynomial or table over the distance `s` from a body's inner end: one of the two.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CurveFile {
    /// Coefficients of 1, s, s², … with s in m.
    #[schemars(length(min = 1, max = 100))]
    pub polynomial: Option<Vec<f64>>,
    /// Rows `[s, value]`, s in m ascending; linear between rows, constant outside.
    #[schemars(length(min = 2), extend("x-allowed" = "at least 2 rows [s in m, value] of finite numbers"))]
    pub table: Option<Vec<[f64; 2]>>,
}

/// Builds the function; having both polynomial and table, or neither, is an error.
pub(super) fn along_body(path: &[&str], function: &FunctionFile, checker: &mut Checker) -> Option<Profile> {
    match function {
        FunctionFile::Number(value) => Some(Profile::constant(*value)),
        FunctionFile::Curve(CurveFile { polynomial: Some(coefficients), table: None }) => {
            Some(Profile::Polynomial(coefficients.clone()))
        }
        FunctionFile::Curve(CurveFile { polynomial: None, table: Some(rows) }) => Some(Profile::Table(rows.clone())),
        FunctionFile::Curve(CurveFile { polynomial: Some(_), table: Some(_) }) => {
            checker.refuse(&[path, &["table"]].concat(), "either polynomial or table, not both");
            None
        }
        FunctionFile::Curve(CurveFile { polynomial: None, table: None }) => {
            checker.refuse(path, "a table with the key polynomial or the key table");
            None
        }
    }
}
