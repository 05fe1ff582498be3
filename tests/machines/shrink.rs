//! The smallest machine that still fails.

use crate::machines::Frame;
use crate::machines::model::{Model, Value};
use nalgebra::Vector3;

/// Removes tables with everything that refers to them, keys and actions, one by one, while `fails` holds: the remaining model fails, but no
/// longer fails if any further part is removed.
pub fn shrink(model: &Model, mut fails: impl FnMut(&Model) -> bool) -> Model {
    let mut least = model.clone();
    loop {
        let before = least.clone();
        for index in (1..least.tables.len()).rev() {
            // removing one table also removes others
            if index < least.tables.len() {
                let less = least.without(index);
                if fails(&less) {
                    least = less;
                }
            }
        }
        for index in (0..least.actions.len()).rev() {
            let mut less = least.clone();
            less.actions.remove(index);
            if fails(&less) {
                least = less;
            }
        }
        for table in 0..least.tables.len() {
            for key in (0..least.tables[table].keys.len()).rev() {
                let mut less = least.clone();
                match &mut less.tables[table].keys[key].1 {
                    // a view rotates the machine by this key
                    Value::TurnDeg(turn, Frame::Root) => *turn = Vector3::zeros(),
                    _ => drop(less.tables[table].keys.remove(key)),
                }
                if fails(&less) {
                    least = less;
                }
            }
        }
        if least == before {
            return least;
        }
    }
}
