//! What a user should know of a model although it is valid.

use foldwing_engine::machine::Machine;
use foldwing_engine::machine::{DEFAULT_CAPTURE_RAD, Latch, LatchKind, OneFreedom};

/// Notes on a model, a sentence each.
pub fn notes(machine: &Machine) -> Vec<String> {
    let mut notes = Vec::new();
    for body in &machine.bodies {
        let Some((travel, revolute)) = body.joint.kind.one_freedom() else { continue };
        let Some(latch) = &revolute.latch else { continue };
        let name = &body.joint.name;
        let rigid = latch.kind == LatchKind::Rigid;
        if starts_closed(revolute, latch) {
            let holds = if rigid {
                " and holds its angle: statics, modes and linear models take it for a constant"
            } else {
                ""
            };
            notes.push(format!("joint {name}: the latch is closed at the start{}", travel.words(holds)));
        }
        if latch.capture_rad > DEFAULT_CAPTURE_RAD {
            let window = (travel.shown(latch.capture_rad) * 1e9).round() / 1e9;
            let (key, unit) = (travel.words("capture_deg"), travel.shown_unit());
            let coordinate = travel.coordinate();
            notes.push(if rigid {
                format!(
                    "joint {name}: with {key} = {window} the enabled rigid latch closes {window} {unit} before its \
                     {coordinate} and holds the joint there; leave the key out to close at the {coordinate} itself"
                )
            } else {
                format!("joint {name}: with {key} = {window} the enabled latch closes {window} {unit} before its {coordinate}, \
                 and the wing then swings about that {coordinate}; version 0.1.0 used the window only when the latch was enabled; \
                 leave the key out to close at the {coordinate} itself"
                )
            });
        }
    }
    notes
}

/// Whether a latch is closed at the start: told so, or caught there.
fn starts_closed(revolute: &OneFreedom, latch: &Latch) -> bool {
    let caught = (revolute.start_angle_rad - latch.angle_rad).abs() <= latch.capture_rad;
    latch.enable && (latch.initially_closed || caught)
}
