//! The page of a live simulation: the page of a run that starts with one frame, and the frames that follow.

use super::{Companion, element, elements, filled};
use crate::report::recording::{Frame, Scene};
use crate::report::signals::Signals;
use foldwing_recording::packed::{PackedRun, fixed_part, in_script, wake_part};
use serde_json::Value;

/// Beginning of the element with the description of a live simulation.
const LIVE_BEGINS: &str = "<script type=\"application/json\" class=\"live\">";

/// Machine of the page of a live simulation.
pub struct LiveMachine<'a> {
    /// Name in the legend.
    pub label: String,
    /// Scene.
    pub scene: &'a Scene,
    /// First frame.
    pub first: Frame,
    /// Outputs that can be plotted, with their units.
    pub signals: Vec<(String, String)>,
}

/// The page as HTML: the machines in their first frames, the first of which has the fields, and the additional data for `live.js`.
pub fn page_of_live(machines: &[LiveMachine], live: &Value) -> String {
    let packed = |one: &LiveMachine| {
        let none = Signals::new(one.signals.iter().cloned(), 1);
        PackedRun::of_states(one.scene, std::slice::from_ref(&one.first), &none)
    };
    let companion = |one: &LiveMachine| Companion::Run { label: one.label.clone(), run: packed(one) };
    let companions: Vec<_> = machines.iter().skip(1).map(companion).collect();
    let first = machines.first().map(|one| elements(&packed(one))).unwrap_or_default();
    let names: Vec<_> = machines.iter().map(|one| one.label.as_str()).collect();
    filled(&names.join(", "), first + &element(LIVE_BEGINS, &in_script(live)), &companions)
}

/// The numbers of a frame as in the page of a run, and the rows of the wake of every surface.
pub fn numbers_of_frame(scene: &Scene, frame: &Frame) -> (Vec<usize>, Vec<f32>) {
    let rows = frame.lattice.iter().map(|surface| surface.wake_circulation_m2_s.len()).collect();
    let mut numbers = fixed_part(frame, &scene.travels);
    numbers.extend(frame.lattice.iter().flat_map(wake_part));
    (rows, numbers)
}
