//! Closed loops of the file to [`Closure`]: where they hold, and whether they are closed at the start.

use crate::config::file::{LoopFile, ModelFile};
use crate::config::schema::shortest;
use crate::config::tree::{ROOT, Tree};
use crate::config::validate::Checker;
use crate::machine::pose::{along, first_frames};
use crate::machine::{Closure, Machine};

/// Largest gap at the start over the length of the longer body: angles rounded to 0.01 degrees leave 2e-4. A wider gap
/// is a mistake in the model and would snap shut with a penalty's full force.
const START_GAP: f64 = 1e-3;

/// All closed loops; `None` if one cannot be placed.
pub(super) fn build(file: &ModelFile, tree: Option<&Tree>, checker: &mut Checker) -> Option<Vec<Closure>> {
    let closures: Vec<Option<Closure>> =
        file.closures.iter().map(|(name, closure)| place(name, closure, file, tree, checker)).collect();
    closures.into_iter().collect()
}

fn place(
    name: &str,
    closure: &LoopFile,
    file: &ModelFile,
    tree: Option<&Tree>,
    checker: &mut Checker,
) -> Option<Closure> {
    let path = ["loop", name, "bodies"];
    for body in &closure.bodies {
        if body == ROOT {
            let allowed = "two bodies: the root takes part by joints only. Hold one of the bodies by a joint with \
                           parent = \"root\" and close the loop between two bodies";
            checker.refuse(&path, allowed);
            return None;
        }
        if !file.body.contains_key(body) {
            checker.unknown_name(&path, body, "names of bodies", file.body.keys().map(String::as_str));
            return None;
        }
    }
    let mut places = [(0, 0.0); 2];
    for (side, place) in places.iter_mut().enumerate() {
        let (index, _, body) = file.body.get_full(&closure.bodies[side])?;
        let position_m = closure.positions_m.map_or(body.length_m, |positions_m| positions_m[side]);
        if position_m > body.length_m {
            let length = shortest(body.length_m);
            let allowed = format!("lengths up to those of the bodies; {:?} is {length} m long", closure.bodies[side]);
            checker.refuse(&["loop", name, "positions_m"], allowed);
            return None;
        }
        *place = (index, position_m);
    }
    if places[0] == places[1] {
        let key = if closure.positions_m.is_some() { "positions_m" } else { "bodies" };
        checker.refuse(&["loop", name, key], "two different sections: one is joined to itself");
        return None;
    }
    let tree = tree?;
    Some(Closure {
        name: name.to_owned(),
        places: places.map(|(index, position_m)| (tree.rank[index], position_m)),
        offsets_m: closure.offsets_m.map(Into::into),
        inertia_kg: closure.inertia_kg,
        damping_n_s_m: closure.damping_n_s_m,
        stiffness_n_m: closure.stiffness_n_m,
    })
}

/// Refuses loops that are open in the unstrained machine at its start angles.
pub(super) fn check_gaps(machine: &Machine, checker: &mut Checker) {
    let firsts = first_frames(&machine.bodies, |joint| joint.start_angle_rad);
    for closure in &machine.closures {
        let points = [0, 1].map(|side| {
            let (body, position_m) = closure.places[side];
            let frame = along(&machine.bodies[body], &firsts[body], position_m);
            frame.position_m + frame.attitude * closure.offsets_m[side]
        });
        let gap = points[1] - points[0];
        let length_m = closure.places.map(|(body, _)| machine.bodies[body].length_m).into_iter().fold(0.0, f64::max);
        let limit_m = START_GAP * length_m;
        // what is not a number is no closed loop either
        if gap.norm() > limit_m || gap.norm().is_nan() {
            checker.refuse_as(
                &["loop", &closure.name],
                format!(
                    "a gap of {:.6} m, from one point to the other [{:.6}, {:.6}, {:.6}],",
                    gap.norm(),
                    gap.x,
                    gap.y,
                    gap.z
                ),
                format!(
                    "points that coincide in the unstrained machine at its start angles to {} m, {START_GAP} of the \
                     longer body",
                    shortest(limit_m)
                ),
            );
        }
    }
}
