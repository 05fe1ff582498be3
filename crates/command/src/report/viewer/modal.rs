//! Modes in the format of the page: states as the frames of a run, and complex motions of its sections, single precision in base64.

use crate::report::shapes::{DrawnMode, DrawnState, LARGEST_SHARE, Shapes, size_m};
use crate::report::signals::Signals;
use foldwing_engine::math::strain::STRAINS;
use foldwing_recording::packed::{MAXIMUM_NUMBERS, PackedRun, encoded, in_script};
use foldwing_recording::recording::Scene;
use serde_json::{Value, json};

/// Numbers of the motion of a section: displacement, rotation and strain measures, real and imaginary.
const PER_SECTION: usize = 2 * (6 + STRAINS);

/// Modes as text.
#[derive(Debug, Clone, PartialEq)]
pub struct PackedModes {
    /// The states, as a run.
    pub states: PackedRun,
    /// JSON, safe inside its element of a page.
    pub description: String,
    /// Little-endian single-precision numbers, base64.
    pub numbers: String,
}

impl PackedModes {
    /// Packs modes; states in the middle are left out at equal intervals, and samples of a revolution, if the page would exceed its bound.
    /// States with a text are kept.
    pub fn new(shapes: &Shapes) -> Self {
        let kept = kept(shapes);
        let mut numbers: Vec<f32> = Vec::new();
        let mut frames = Vec::new();
        let mut states = Vec::new();
        for (state, stride) in &kept {
            let first = frames.len();
            frames.extend(state.frames.iter().step_by(*stride).cloned());
            let modes: Vec<Value> = state
                .modes
                .iter()
                .map(|mode| mode.as_ref().map_or(Value::Null, |mode| packed(mode, *stride, &mut numbers)))
                .collect();
            states.push(json!({
                "value": state.value, "words": state.words, "frame": first,
                "frames": frames.len() - first - usize::from(state.period_s.is_some()),
                "period": state.period_s, "modes": modes,
            }));
        }
        let size = shapes.states.first().and_then(|state| state.frames.first());
        let description = json!({
            "title": shapes.title, "quantity": shapes.quantity, "share": LARGEST_SHARE,
            "size": size.map_or(0.0, |frame| size_m(&shapes.scene, frame)),
            "states": states, "found": shapes.states.len(),
        });
        // a mode drawn at an arbitrary amplitude has no loads
        for frame in &mut frames {
            (frame.loads, frame.edge_forces_n) = (Vec::new(), Vec::new());
        }
        let load_places = vec![Vec::new(); shapes.scene.bodies.len()];
        let scene = Scene { load_places, ..shapes.scene.clone() };
        let states = PackedRun::of_states(&scene, &frames, &Signals::new([], 0));
        Self { states, description: in_script(&description), numbers: encoded(&numbers) }
    }
}

/// A mode as JSON; adds its motion to the numbers.
fn packed(mode: &DrawnMode, stride: usize, numbers: &mut Vec<f32>) -> Value {
    let begin = numbers.len();
    for change in mode.changes.iter().step_by(stride).flatten().flatten().flatten() {
        let parts = [&change.displacement_m, &change.rotation_rad].into_iter().flat_map(|vector| vector.iter());
        numbers.extend(parts.chain(change.measures.iter()).map(|number| *number as f32));
    }
    let pair = |value: &nalgebra::Complex<f64>| json!([value.re, value.im]);
    json!({
        "number": mode.number, "eigenvalue": pair(&mode.eigenvalue_1_s), "exponent": pair(&mode.exponent_1_s),
        "grows": mode.grows, "words": mode.words, "begin": begin,
        "largest": mode.largest_m, "turn": mode.largest_rad,
    })
}

/// States that fit a page, with the stride of their samples.
fn kept(shapes: &Shapes) -> Vec<(&DrawnState, usize)> {
    let sections: usize = shapes.scene.bodies.iter().map(|body| body.places_m.len()).sum();
    // a frame has fewer numbers of a section than the motion of one mode
    let size = |state: &DrawnState, stride: usize| {
        let modes = state.modes.iter().flatten().count();
        state.frames.len().div_ceil(stride) * sections * PER_SECTION * (modes + 1)
    };
    if let [only] = shapes.states.as_slice() {
        let frames = only.frames.len() - usize::from(only.period_s.is_some());
        let fits = |stride: &usize| frames.is_multiple_of(*stride) && size(only, *stride) <= MAXIMUM_NUMBERS;
        return vec![(only, (1..=frames).find(fits).unwrap_or(frames.max(1)))];
    }
    let plain = shapes.states.iter().filter(|state| state.words.is_empty()).count();
    let whole: usize = shapes.states.iter().map(|state| size(state, 1)).sum();
    let most = (plain * MAXIMUM_NUMBERS / whole.max(1)).clamp(2, plain.max(2));
    // `most` of the `plain` ones, with both ends
    let step = |i: usize| if plain <= most { i } else { i * (most - 1) / (plain - 1) };
    let mut i = 0;
    let keeps = |state: &&DrawnState| {
        if !state.words.is_empty() {
            return true;
        }
        i += 1;
        i == 1 || step(i - 1) != step(i - 2)
    };
    shapes.states.iter().filter(keeps).map(|state| (state, 1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::sample_tests::{recorded, shipped};
    use crate::report::shapes::state_of;
    use foldwing_engine::plant::Plant;
    use std::sync::Arc;

    /// Many states are thinned to the bound of a page: both ends and those with a text are kept, in their order. Samples of a revolution
    /// are thinned at equal intervals that divide it.
    #[test]
    fn many_states_are_thinned() {
        let mut plant = Plant::new(Arc::new(shipped("folding_wing")));
        plant.initialize(0.0).unwrap();
        let scene = recorded(shipped("folding_wing"), 1).scene;
        let frame = state_of(&scene, &plant);
        let coordinates = vec![nalgebra::Complex::new(1.0, 0.0); plant.freedoms().len()];
        let changes = crate::report::shapes::changes_of(&scene, &plant, &coordinates);
        let mode = |samples: usize| DrawnMode {
            number: 1,
            eigenvalue_1_s: nalgebra::Complex::new(0.0, 1.0),
            exponent_1_s: nalgebra::Complex::new(0.0, 1.0),
            grows: false,
            words: String::new(),
            changes: vec![changes.clone(); samples],
            largest_m: 1.0,
            largest_rad: 0.0,
        };
        let state = |value: f64, words: &str| DrawnState {
            value,
            words: words.to_owned(),
            frames: vec![frame.clone()],
            period_s: None,
            modes: vec![Some(mode(1)); 6],
        };
        let count = 400;
        let mut states: Vec<DrawnState> = (0..count).map(|i| state(f64::from(i), "")).collect();
        states.insert(200, state(199.5, "flutter of mode 1"));
        let mut shapes = Shapes { scene, title: String::new(), quantity: Some(["wind speed", "m/s"]), states };
        let values: Vec<f64> = kept(&shapes).iter().map(|(state, _)| state.value).collect();
        assert!(values.len() < 300 && values.len() > 50, "{}", values.len());
        assert_eq!((values[0], values[values.len() - 1]), (0.0, f64::from(count - 1)));
        assert!(values.contains(&199.5) && values.windows(2).all(|pair| pair[0] < pair[1]), "{values:?}");
        let packed = PackedModes::new(&shapes);
        // four bytes in base64, with the states
        assert!(
            (packed.numbers.len() + packed.states.numbers.len()) * 3 / 16 <= MAXIMUM_NUMBERS + MAXIMUM_NUMBERS / 50
        );
        shapes.states.truncate(3);
        assert_eq!(kept(&shapes).len(), 3);
        let turn = DrawnState {
            frames: vec![frame.clone(); 145],
            period_s: Some(1.0),
            modes: vec![Some(mode(144)); 60],
            ..state(0.0, "")
        };
        shapes.states = vec![turn];
        let [(_, stride)] = kept(&shapes)[..] else { panic!() };
        assert!(stride > 1 && 144 % stride == 0, "{stride}");
    }
}
