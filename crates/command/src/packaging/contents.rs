//! All contents of the archive except the libraries.

pub use crate::packaging::extras::Extras;
use crate::packaging::{documentation, icon, licenses, linear_model, terminals};
use foldwing_engine::machine::Machine;
use foldwing_fmi::instance::{MODEL_FILE, Version};
use std::collections::BTreeMap;

/// All files by their paths in the archive, except the libraries.
///
/// `model_text` is the file from which `machine` was read.
pub fn contents(machine: &Machine, model_text: &str, extras: &Extras) -> BTreeMap<String, Vec<u8>> {
    let interface = extras.kinds.interface(machine);
    let mut files = BTreeMap::from([
        (
            "documentation/index.html".to_owned(),
            documentation::page(machine, &extras.kinds.variables(&interface), extras).into_bytes(),
        ),
        (
            "modelDescription.xml".to_owned(),
            extras.kinds.model_description(machine, &interface, model_text).into_bytes(),
        ),
        (format!("resources/{MODEL_FILE}"), model_text.into()),
    ]);
    match extras.kinds.version {
        Version::Fmi2 => files.extend([("model.png".to_owned(), icon::png(machine))]),
        Version::Fmi3 => {
            let folder = terminals::FOLDER;
            files.extend([
                (format!("{folder}/icon.png"), icon::png(machine)),
                (format!("{folder}/terminalsAndIcons.xml"), terminals::document(machine, &interface).into_bytes()),
            ]);
        }
    }
    files.extend(licenses::FILES.map(|(name, text)| (format!("{}/{name}", licenses::FOLDER), text.into())));
    if let Some(reference) = &extras.reference {
        files.extend(reference.files(machine).into_iter().map(|(path, text)| (path, text.into_bytes())));
    }
    if let Some(model) = &extras.linear {
        files.extend(linear_model::files(model));
    }
    files
}
