//! Model descriptions of the shipped models, byte for byte: every change of the FMU's interface must be deliberate.
//!
//! After a deliberate change, `make bless` rewrites them; the diff then shows the changes for importers.

use foldwing::interface::{Interface, guid};
use foldwing::packaging::{Kinds, model_description};
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Set by `make bless`.
const BLESS: &str = "FOLDWING_BLESS";

fn in_package(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// File names without extension of the files in a folder that have the extension.
fn stems(folder: &Path, extension: &str) -> BTreeSet<OsString> {
    let files =
        std::fs::read_dir(folder).expect("the folder is part of the repository").map(|file| file.unwrap().path());
    files
        .filter(|file| file.extension().is_some_and(|found| found == extension))
        .map(|f| f.file_stem().unwrap().into())
        .collect()
}

/// Every shipped model has a committed description, equal to the generated one, and there are no others.
#[test]
fn committed_descriptions_are_what_is_generated() {
    let models = in_package("examples/models");
    let committed = in_package("modelDescription");
    let bless = std::env::var_os(BLESS).is_some();
    for stem in stems(&models, "toml") {
        // The GUID is a hash of the text; line feeds keep it the same on every platform.
        let text = std::fs::read_to_string(models.join(&stem).with_extension("toml")).unwrap();
        let machine = foldwing::config::parse(&text, &stem.to_string_lossy()).unwrap_or_else(|error| panic!("{error}"));
        let interface = Interface::new(&machine);
        let variables = interface.variables();
        let (dependencies, guid) = (interface.dependencies(&machine), guid(&text, variables));
        let generated = model_description(&machine, variables, &dependencies, &guid, Kinds::default());
        let file = committed.join(&stem).with_extension("xml");
        if bless {
            std::fs::write(&file, &generated).unwrap();
        }
        let expected = std::fs::read_to_string(&file)
            .unwrap_or_else(|error| panic!("{}: {error}; `make bless` writes it", file.display()));
        if let Some((line, (old, new))) = (1..).zip(expected.lines().zip(generated.lines())).find(|(_, (a, b))| a != b)
        {
            panic!(
                "{}:{line}: committed\n{old}\ngenerated\n{new}\n`make bless` after a deliberate change",
                file.display()
            );
        }
        assert_eq!(expected, generated, "{}: `make bless` after a deliberate change", file.display());
    }
    assert_eq!(stems(&committed, "xml"), stems(&models, "toml"), "descriptions and models do not pair up");
}
