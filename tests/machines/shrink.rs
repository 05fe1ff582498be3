//! The smallest machine that still fails.

use crate::machines::model::Model;

/// Takes away tables with all that hangs on them, keys and actions, one by one, while `fails` holds: what is left fails and
/// fails no more without any one of its parts.
pub fn shrink(model: &Model, mut fails: impl FnMut(&Model) -> bool) -> Model {
    let mut least = model.clone();
    loop {
        let before = least.clone();
        for index in (1..least.tables.len()).rev() {
            // one that is taken away takes others with it
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
                less.tables[table].keys.remove(key);
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
