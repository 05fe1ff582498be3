//! The command `foldwing` as run from a shell.

mod command_line;
mod day_to_day;
mod files;
mod film;
mod fit;
mod gradient;
mod mistakes;
mod rotors;
mod slips;
mod starter;
mod sweep;
mod verdicts;
mod warnings;
#[path = "../verification/whole.rs"]
mod whole;

/// The shared library that Cargo built next to this test.
fn library() -> std::path::PathBuf {
    let name = format!("{}foldwing_fmu{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    std::env::current_exe().unwrap().with_file_name(name)
}
