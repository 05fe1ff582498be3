//! The page of a live simulation: the page of a run that starts with one frame, and the frames that follow.

use super::{element, elements, filled};
use crate::report::recording::{Frame, Scene};
use crate::report::signals::Signals;
use foldwing_recording::packed::{PackedRun, fixed_part, in_script, wake_part};
use serde_json::Value;

/// Beginning of the element with the description of a live simulation.
const LIVE_BEGINS: &str = "<script type=\"application/json\" class=\"live\">";

/// The page as HTML: the model in its first frame, the signals that can be plotted (name, unit), and the additional data for `live.js`.
pub fn page_of_live(scene: &Scene, first: &Frame, signals: &[(String, String)], live: &Value) -> String {
    let none = Signals::new(signals.iter().cloned(), 1);
    let run = PackedRun::of_states(scene, std::slice::from_ref(first), &none);
    filled(&scene.name, elements(&run) + &element(LIVE_BEGINS, &in_script(live)), &[])
}

/// The numbers of a frame as in the page of a run, and the rows of the wake of every surface.
pub fn numbers_of_frame(scene: &Scene, frame: &Frame) -> (Vec<usize>, Vec<f32>) {
    let rows = frame.lattice.iter().map(|surface| surface.wake_circulation_m2_s.len()).collect();
    let mut numbers = fixed_part(frame, &scene.travels);
    numbers.extend(frame.lattice.iter().flat_map(wake_part));
    (rows, numbers)
}
