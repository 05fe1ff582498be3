//! Saved states with non-finite numbers at any position: coordinates, inputs, latches, aerodynamics with wake and lag states.

use foldwing::plant::{Plant, PlantError, Snapshot};
use std::sync::Arc;

/// Machines with strips, with a lattice and its wake, with a rotor in wind, and with a latch and end stops without aerodynamics.
const MODELS: [&str; 5] = [
    "models/goland_wing.toml",
    "models/folding_wing_in_tunnel.toml",
    "turbine/nrel_5mw_wind.toml",
    "failures/latch_no_capture.toml",
    "models/three_bodies.toml",
];
/// Number of positions in each state that are tested.
const TRIED: usize = 150;

fn started(model: &str) -> Plant {
    let file = format!("{}/examples/{model}", env!("CARGO_MANIFEST_DIR"));
    let (machine, _) = foldwing::config::read(file).expect("a model that is shipped");
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(0.0).expect("starts");
    plant.step(2e-3).expect("steps");
    plant
}

/// The debug output of a state without the stages within a step: at the end of a step there are none, and their stored values have no
/// meaning.
fn printed(state: &Snapshot) -> String {
    let text = format!("{state:?}");
    let (head, rest) = text.split_once("stages: [").expect("stages");
    let (_, tail) = rest.split_once(", now: Point").expect("the present");
    format!("{head}{tail}")
}

/// Bytes of a state with the eight bytes at `offset` replaced by `number`, read as a state again if valid.
fn with_number(bytes: &[u8], offset: usize, number: f64) -> Option<Snapshot> {
    let mut changed = bytes.to_vec();
    changed[offset..offset + 8].copy_from_slice(&number.to_le_bytes());
    postcard::from_bytes(&changed).ok()
}

/// A state that holds NaN or an infinity is rejected when it is set, with the location, and the machine continues as if it had not been
/// set. The test detects such numbers in the debug output, independently of the code that rejects them.
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
                    continue; // the bytes belong to an integer
                }
                match plant.restore(&changed) {
                    // a modified length gives a state of other sizes, which is rejected before its numbers are checked
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
