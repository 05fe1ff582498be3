//! Packages an FMU of a model file with a changed section, from Rust.
//!
//! `cargo build --release && cargo run --release --example package -- examples/models/folding_wing.toml target/release/libfoldwing_fmu.so Thin.fmu`

use foldwing::packaging::{self, Extras, Library};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [model, library, fmu] = arguments.as_slice() else { return Err("usage: package MODEL LIBRARY FMU".into()) };
    let text = std::fs::read_to_string(model)?.replace("height_m = 0.002", "height_m = 0.001");
    std::fs::write(fmu, package(&text, Path::new(library))?)?;
    println!("packaged {fmu}");
    Ok(())
}

/// Returns the bytes of the FMU of a model, for the platform of the library.
pub fn package(text: &str, library: &Path) -> Result<Vec<u8>, Box<dyn Error>> {
    let machine = foldwing::config::parse(text, "model.toml")?;
    let extras = Extras { reference: None, linear: None, ..Extras::default() };
    Ok(packaging::package(&machine, text, &extras, &Library::read(library, None)?)?)
}
