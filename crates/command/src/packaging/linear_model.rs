//! The linear model inside the archive, for tools that cannot linearise a co-simulation FMU.

use crate::report::{linear_json, write_mat};
use foldwing_fmi::interface::LinearModel;
use std::collections::BTreeMap;

/// Folder inside the archive: a name in reverse domain notation, as FMI requires below `extra`.
pub const FOLDER: &str = "extra/org.foldwing.linear";

const README: &str = include_str!("linear_model.txt");

/// Files of the linear model by their paths in the archive.
pub fn files(model: &LinearModel) -> BTreeMap<String, Vec<u8>> {
    let mut mat = Vec::new();
    write_mat(model, &mut mat).expect("writing to memory does not fail");
    BTreeMap::from([
        (format!("{FOLDER}/linear.json"), format!("{:#}\n", linear_json(model)).into_bytes()),
        (format!("{FOLDER}/linear.mat"), mat),
        (format!("{FOLDER}/README.txt"), README.as_bytes().to_vec()),
    ])
}
