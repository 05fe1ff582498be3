//! The functions of the WebAssembly module. The page writes the text of a model into memory that the module allocates, and reads answers
//! from memory at an address that the module returns; nothing else passes between them, and the module imports nothing.
//!
//! The module handles one text at a time: a page has one module per worker.

#![allow(unsafe_code)] // the attribute that keeps a name in the module; there is no unsafe block

use crate::session::{Session, State};
use foldwing_recording::packed::Packing;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Data from the page and for the page.
struct Desk {
    text: Vec<u8>,
    session: Option<Session>,
    answer: String,
    numbers: Vec<f32>,
}

static DESK: Mutex<Desk> =
    Mutex::new(Desk { text: Vec::new(), session: None, answer: String::new(), numbers: Vec::new() });

fn desk() -> MutexGuard<'static, Desk> {
    DESK.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Allocates memory for a text of `bytes` bytes of UTF-8, and returns its address.
#[unsafe(no_mangle)]
pub extern "C" fn foldwing_text(bytes: usize) -> *mut u8 {
    let mut desk = desk();
    desk.text = vec![0; bytes];
    desk.text.as_mut_ptr()
}

/// Reads the text and starts its run, which is recorded in at most `frames` frames after the first. Returns 0, or 1 if the text is
/// rejected; the answer is then JSON with the reasons. Any previous run ends.
#[unsafe(no_mangle)]
pub extern "C" fn foldwing_begin(frames: u32) -> u32 {
    let mut desk = desk();
    desk.session = None;
    desk.numbers = Vec::new();
    let text = String::from_utf8_lossy(&desk.text).into_owned();
    match Session::begin(&text, frames.into()) {
        Ok(session) => {
            desk.session = Some(session);
            0
        }
        Err(refusal) => {
            desk.answer = refusal.json().to_string();
            1
        }
    }
}

/// Takes at most `steps` communication steps. Returns 0 if more steps remain, 1 at the stop time, 2 if a step failed or there is no run.
#[unsafe(no_mangle)]
pub extern "C" fn foldwing_advance(steps: u32) -> u32 {
    let mut desk = desk();
    match desk.session.as_mut().map_or(State::Failed, |session| session.advance(steps)) {
        State::Running => 0,
        State::Finished => 1,
        State::Failed => 2,
    }
}

/// Sets the answer to the summary of the run, as JSON.
#[unsafe(no_mangle)]
pub extern "C" fn foldwing_summary() {
    let mut desk = desk();
    desk.answer = desk.session.as_ref().map_or_else(String::new, |session| session.summary().to_string());
}

/// Sets the answer to the description of the run so far for the viewer page, as JSON, and provides its numbers.
#[unsafe(no_mangle)]
pub extern "C" fn foldwing_pack() {
    let mut desk = desk();
    let none = || Packing { description: String::new(), numbers: Vec::new() };
    let packing = desk.session.as_ref().map_or_else(none, Session::packing);
    (desk.answer, desk.numbers) = (packing.description, packing.numbers);
}

/// Address of the answer, which is UTF-8.
#[unsafe(no_mangle)]
pub extern "C" fn foldwing_answer() -> *const u8 {
    desk().answer.as_ptr()
}

/// Length of the answer in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn foldwing_answer_bytes() -> usize {
    desk().answer.len()
}

/// Address of the numbers, in single precision.
#[unsafe(no_mangle)]
pub extern "C" fn foldwing_numbers() -> *const f32 {
    desk().numbers.as_ptr()
}

/// Count of the numbers.
#[unsafe(no_mangle)]
pub extern "C" fn foldwing_numbers_count() -> usize {
    desk().numbers.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(text: &str) {
        foldwing_text(text.len());
        desk().text.copy_from_slice(text.as_bytes());
    }

    fn answer() -> serde_json::Value {
        let (bytes, place) = (foldwing_answer_bytes(), foldwing_answer());
        let desk = desk();
        assert_eq!((bytes, place), (desk.answer.len(), desk.answer.as_ptr()));
        serde_json::from_str(&desk.answer).unwrap()
    }

    /// The calls in the order of a page: a model, a text that is rejected, another model.
    #[test]
    fn a_page_is_served() {
        assert_eq!(foldwing_advance(1), 2, "nothing runs yet");
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/models/folding_wing.toml");
        let wing = std::fs::read_to_string(path).unwrap();
        write(&wing);
        assert_eq!((foldwing_begin(600), foldwing_advance(10)), (0, 0));
        foldwing_summary();
        let share = answer()["share"].as_f64().unwrap();
        assert_eq!((share, answer()["latches"][0]["time_s"].clone()), (10.0 / 800.0, serde_json::Value::Null));
        foldwing_pack();
        assert_eq!(answer()["points"], 11);
        let (count, place) = (foldwing_numbers_count(), foldwing_numbers());
        assert!(count > 11 && place == desk().numbers.as_ptr());
        assert_eq!(foldwing_advance(u32::MAX), 1);
        write("nonsense");
        assert_eq!(foldwing_begin(600), 1);
        assert_eq!(answer()["marks"][0]["line"], 1);
        assert_eq!(foldwing_advance(1), 2, "the run before has ended");
        write(&wing);
        assert_eq!((foldwing_begin(600), foldwing_advance(1000)), (0, 1));
        foldwing_summary();
        assert!(answer()["latches"][0]["time_s"].as_f64().unwrap() > 0.1);
    }
}
