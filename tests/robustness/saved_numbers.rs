//! Saved states with numbers that are not finite, wherever they stand: coordinates, inputs, latches, the air with its wake and lags.

use foldwing::plant::{Plant, PlantError, Snapshot};
use std::sync::Arc;

/// Machines with strips, with a lattice and its wake, with a rotor in wind, and with a latch and stops without air.
const MODELS: [&str; 5] = [
    "models/goland_wing.toml",
    "models/folding_wing_in_tunnel.toml",
    "turbine/nrel_5mw_wind.toml",
    "failures/latch_no_capture.toml",
    "models/three_bodies.toml",
];
/// Places in each state that are tried.
const TRIED: usize = 150;

fn started(model: &str) -> Plant {
    let file = format!("{}/examples/{model}", env!("CARGO_MANIFEST_DIR"));
    let (machine, _) = foldwing::config::read(file).expect("a model that is shipped");
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).expect("starts");
    plant.step(2e-3).expect("steps");
    plant
}

/// A state as it prints itself, without the stages within a step: a step without length has none, and what stands there means nothing.
fn printed(state: &Snapshot) -> String {
    let text = format!("{state:?}");
    let (head, rest) = text.split_once("stages: [").expect("stages");
    let (_, tail) = rest.split_once(", now: Point").expect("the present");
    format!("{head}{tail}")
}

/// Bytes of a state in which eight from `offset` on are those of `number`, read as a state again where they are one.
fn with_number(bytes: &[u8], offset: usize, number: f64) -> Option<Snapshot> {
    let mut changed = bytes.to_vec();
    changed[offset..offset + 8].copy_from_slice(&number.to_le_bytes());
    postcard::from_bytes(&changed).ok()
}

/// A state that holds NaN or an infinity is refused when it is set, with the place, and the machine goes on as if it had not been
/// tried. What a state holds is read from its own printed form, not by what refuses it.
#[test]
fn numbers_that_are_not_finite_are_refused_at_once() {
    for model in MODELS {
        let mut plant = started(model);
        let sound = plant.snapshot();
        plant.restore(&sound).unwrap_or_else(|error| panic!("{model}: {error}"));
        let bytes = postcard::to_stdvec(&sound).expect("bytes");
        let infinities = printed(&sound).matches("inf").count();
        let mut refused = 0;
        for k in 0..TRIED {
            let offset = k * (bytes.len() - 8) / TRIED;
            for number in [f64::NAN, f64::NEG_INFINITY] {
                let Some(changed) = with_number(&bytes, offset, number) else { continue };
                let shown = printed(&changed);
                if !shown.contains("NaN") && shown.matches("inf").count() == infinities {
                    continue; // it has become part of a whole number
                }
                match plant.restore(&changed) {
                    // bytes of a length make a state of other sizes, which is refused before its numbers are looked at
                    Err(PlantError::Snapshot(cause)) if cause.contains("differ") => {}
                    Err(PlantError::Snapshot(cause)) => {
                        assert!(cause.contains("cannot occur in a run"), "{model}, byte {offset}: {cause}");
                        refused += 1;
                    }
                    other => {
                        let at = shown.find("NaN").or_else(|| shown.find("inf")).unwrap_or(0);
                        panic!(
                            "{model}, byte {offset}, {number}: {other:?} of …{}…",
                            &shown[at.saturating_sub(300)..at + 3]
                        )
                    }
                }
            }
        }
        assert!(refused >= TRIED / 10, "{model}: {refused} states with such numbers among {TRIED}");
        assert!(plant.snapshot() == sound, "{model}: a refused state has changed the machine");
        plant.step(4e-3).unwrap_or_else(|error| panic!("{model}: {error}"));
    }
}
