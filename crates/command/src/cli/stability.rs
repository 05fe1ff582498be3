//! Stability of an equilibrium, and the load path to it, as text and JSON.

use foldwing_engine::plant::{Coarseness, Departure, Growth, Plant, Rest, Stability};
use serde_json::{Value, json};
use std::fmt::Write;

/// Describes the stability, the growing motions of an unstable equilibrium, and the reason why the search departed from the
/// load path.
pub fn text(plant: &Plant, stability: &Stability, departure: Option<Departure>) -> String {
    let mut text = match departure {
        Some(Departure::Unstable(count)) => format!(
            "The equilibrium on the load path is unstable in {}: this is a stable one, found by descent from it \
             (--branch path prints the unstable one).\n",
            directions(count)
        ),
        Some(Departure::PathEnds(factor)) => format!(
            "The load path ends at {factor:.4} of the load: under the full load the model snaps through to this \
             equilibrium (--path arc-length follows a path through limit points).\n"
        ),
        Some(Departure::PathInAirEnds(factor)) => format!(
            "The equilibrium path from still air ends at {factor:.4} of the dynamic pressure: this equilibrium is not \
             connected to the path, and the model may not reach it.\n"
        ),
        None => String::new(),
    };
    if let Some(cause) = &stability.not_judged {
        let _ = writeln!(text, "stability: not determined: {cause}");
        return text;
    }
    let basis = match (stability.neutral, stability.potential) {
        _ if stability.in_lattice => " (with the vortex lattice: from the slowest modes in discrete time)",
        (true, _) => " (with neutral motions: from the lowest eigenvalues)",
        (false, false) => " (non-conservative loads: from the lowest eigenvalues)",
        (false, true) => "",
    };
    if stability.is_stable() {
        let _ = writeln!(text, "stability: stable{basis}");
        return text;
    }
    let _ = writeln!(text, "stability: UNSTABLE in {}{basis}", directions(stability.unstable_directions()));
    for growth in &stability.growing {
        let _ = writeln!(text, "  {}", growth_in_words(plant, growth));
    }
    if stability.growing.is_empty() {
        text.push_str("  no slow mode grows: stabilised by gyroscopic forces only, which damping would overcome\n");
    }
    text
}

fn directions(count: usize) -> String {
    format!("{count} direction{}", if count == 1 { "" } else { "s" })
}

fn growth_in_words(plant: &Plant, growth: &Growth) -> String {
    let (lambda, d) = (growth.eigenvalue_1_s, growth.direction);
    let swing = if lambda.im.abs() > 1e-9 * lambda.norm() {
        format!(", oscillating at {:.4} Hz", lambda.im / std::f64::consts::TAU)
    } else {
        String::new()
    };
    let name = &plant.machine().bodies[growth.body].name;
    format!(
        "grows with {:.4} 1/s{swing}: most at {:.4} m of {name}, along ({:.2}, {:.2}, {:.2})",
        lambda.re, growth.place_m, d.x, d.y, d.z
    )
}

/// Stability as JSON, with the contents of [`text`].
pub fn as_json(plant: &Plant, stability: &Stability, departure: Option<Departure>) -> Value {
    let growing: Vec<Value> = stability
        .growing
        .iter()
        .map(|growth| {
            json!({
                "eigenvalue_1_s": [growth.eigenvalue_1_s.re, growth.eigenvalue_1_s.im],
                "body": plant.machine().bodies[growth.body].name,
                "place_m": growth.place_m,
                "direction": growth.direction.as_slice(),
            })
        })
        .collect();
    json!({
        "stable": stability.not_judged.is_none().then(|| stability.is_stable()),
        "not_judged": stability.not_judged,
        "unstable_directions": stability.not_judged.is_none().then(|| stability.unstable_directions()),
        "negative_pivots": if stability.in_lattice || stability.not_judged.is_some() { Value::Null } else { stability.negative_directions.into() },
        "loads_have_potential": stability.potential,
        "neutral": stability.neutral,
        "with_air_of_lattice": stability.in_lattice,
        "growing": growing,
        "left_path": match departure {
            None => Value::Null,
            Some(Departure::Unstable(count)) => json!({ "unstable_directions": count }),
            Some(Departure::PathEnds(factor)) => json!({ "load_factor": factor }),
            Some(Departure::PathInAirEnds(factor)) => json!({ "dynamic_pressure_factor": factor }),
        },
    })
}

/// Hint if the mesh is too coarse for the deformed shape; `None` otherwise.
pub fn coarse_hint(plant: &Plant, coarseness: &Coarseness) -> Option<String> {
    coarseness.is_coarse().then(|| {
        format!(
            "hint: the mesh is coarse: {} bends by {:.2} rad more from one element to the next at {:.4} m; compare with \
             twice the elements",
            plant.machine().bodies[coarseness.body].name,
            coarseness.turn_rad,
            coarseness.place_m
        )
    })
}

/// Load factor, unstable directions and positions of the free ends at the points of the path.
pub fn path_text(plant: &mut Plant, rest: &Rest) -> String {
    if rest.path.is_empty() {
        return String::new();
    }
    let names: Vec<String> = tip_names(plant);
    let mut text = format!("\nPath of equilibria\n{:>12} {:>8}", "load factor", "unstable");
    for name in &names {
        let _ = write!(text, "  {:>35}", format!("tip of {name}: x y z m"));
    }
    text.push('\n');
    for point in &rest.path {
        let _ = write!(text, "{:12.6} {:8}", point.factor, point.negative_directions);
        for tip in plant.study().tips_at(point) {
            let _ = write!(text, "  {:11.6} {:11.6} {:11.6}", tip.x, tip.y, tip.z);
        }
        text.push('\n');
    }
    text
}

/// Load path as JSON, with the contents of [`path_text`].
pub fn path_json(plant: &mut Plant, rest: &Rest) -> Vec<Value> {
    let names = tip_names(plant);
    let mut list = Vec::new();
    for point in &rest.path {
        let tips: Vec<Value> = names
            .iter()
            .zip(plant.study().tips_at(point))
            .map(|(name, tip)| json!({ "body": name, "position_m": tip.as_slice() }))
            .collect();
        list.push(json!({
            "load_factor": point.factor,
            "unstable_directions": point.negative_directions,
            "tips": tips,
        }));
    }
    list
}

fn tip_names(plant: &Plant) -> Vec<String> {
    plant.tip_bodies().iter().map(|&body| plant.machine().bodies[body].name.clone()).collect()
}
