//! The command `foldwing` as a shell runs it.

mod command_line;
mod day_to_day;
mod doubts;
mod files;
mod film;
mod gradient;
mod mistakes;
mod rotors;
mod slips;
mod starter;
mod sweep;
mod verdicts;
#[path = "../verification/whole.rs"]
mod whole;
