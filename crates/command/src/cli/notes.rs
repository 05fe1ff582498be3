//! Notes on a valid model.

use foldwing_engine::machine::{
    Air, AirOptions, DEFAULT_CAPTURE_RAD, JointMotion, Latch, LatchKind, Machine, Motion, OneFreedom, Travel,
};

/// Ratio of the rate in the last interval to the fastest one, above which the table was not meant to slow down.
const GOES_ON: f64 = 0.5;

/// Notes on a model that runs until `stop_s`, one sentence each.
pub fn notes(machine: &Machine, stop_s: f64) -> Vec<String> {
    let mut notes = Vec::new();
    for body in &machine.bodies {
        let Some((travel, revolute)) = body.joint.kind.one_freedom() else { continue };
        let name = &body.joint.name;
        if let JointMotion::Prescribed(Motion::Table(points)) = &revolute.motion {
            notes.extend(braking(name, travel, points, stop_s));
        }
        let Some(latch) = &revolute.latch else { continue };
        let rigid = latch.kind == LatchKind::Rigid;
        if starts_closed(revolute, latch) {
            let holds =
                if rigid { " and holds its angle: statics, modes and linear models treat it as constant" } else { "" };
            notes.push(format!("joint {name}: the latch is closed at the start{}", travel.words(holds)));
        }
        if latch.capture_rad > DEFAULT_CAPTURE_RAD {
            let window = (travel.shown(latch.capture_rad) * 1e9).round() / 1e9;
            let (key, unit) = (travel.words("capture_deg"), travel.shown_unit());
            let coordinate = travel.coordinate();
            notes.push(if rigid {
                format!(
                    "joint {name}: with {key} = {window} the enabled rigid latch closes {window} {unit} before its \
                     {coordinate} and holds the joint there; omit the key to close at the {coordinate} itself"
                )
            } else {
                format!("joint {name}: with {key} = {window} the enabled latch closes {window} {unit} before its {coordinate}, \
                 and the wing then swings about that {coordinate}; version 0.1.0 used the capture range only when the \
                 latch was enabled; \
                 omit the key to close at the {coordinate} itself"
                )
            });
        }
    }
    notes.extend(machine.air.as_ref().and_then(apart));
    notes
}

/// Note on several aerodynamic models: none reaches the surfaces of another; and on slender bodies.
fn apart(air: &Air) -> Option<String> {
    let names: Vec<&str> = air.parts.iter().map(|part| part.name.as_str()).collect();
    let slender = air.slender_bodies().next().is_some();
    if names.len() < 2 {
        return slender.then(|| format!("aerodynamics {}: {}", names.join(", "), refused(air)));
    }
    let wing = air.parts.iter().any(|part| matches!(part.options, AirOptions::Strips(_)));
    let effects = [
        (air.rotors().next().is_some() && wing, "the slipstream of a rotor does not reach the wing"),
        (air.rotors().next().is_some() && !wing, "the wake of a rotor does not reach the others"),
        (
            slender && wing,
            "wing and slender body do not act on each other: no carry-over of lift, no upwash, no downwash of the wing",
        ),
    ];
    let effects: Vec<&str> = effects.into_iter().filter_map(|(applies, effect)| applies.then_some(effect)).collect();
    let effects = if effects.is_empty() { String::new() } else { format!("{}; ", effects.join("; ")) };
    let names = names.join(", ");
    Some(format!("aerodynamics {names}: each model is in the undisturbed wind; {effects}{}", refused(air)))
}

/// End of the note: analyses that several models and slender bodies do not permit.
fn refused(air: &Air) -> &'static str {
    match air.rotors().next() {
        Some(_) => "flutter speeds, periodic motions, gradients and Model Exchange are refused",
        None => "periodic motions and gradients are refused",
    }
}

/// Note on a table of times in s and angles in rad (or positions in m) that is a spin sampled up to the end of the run: its motion stops
/// there although its rows do not slow down.
fn braking(name: &str, travel: Travel, points: &[(f64, f64)], stop_s: f64) -> Option<String> {
    let rate = |pair: &[(f64, f64)]| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0);
    let last = points.windows(2).last()?;
    let ends_with_run = last[0].0 < stop_s && stop_s <= last[1].0 * (1.0 + 1e-9);
    let fastest = points.windows(2).map(|pair| rate(pair).abs()).fold(0.0, f64::max);
    if !ends_with_run || rate(last).abs() <= GOES_ON * fastest {
        return None;
    }
    let (shown, unit) = (travel.shown(rate(last)), travel.shown_unit());
    Some(format!(
        "joint {name}: in its last interval, from {} s to {} s, the table brakes from about {} {unit}/s to rest; write \
         table_ends = \"extrapolate\" to keep the rate, or add a row with the same {} if the joint should stop",
        last[0].0,
        last[1].0,
        rounded(shown),
        travel.coordinate()
    ))
}

/// Rounds a number to four digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().expect("a number")
}

/// Returns whether a latch is closed at the start, by its setting or because it closes there.
fn starts_closed(revolute: &OneFreedom, latch: &Latch) -> bool {
    let caught = (revolute.start_angle_rad - latch.angle_rad).abs() <= latch.capture_rad;
    latch.enable && (latch.initially_closed || caught)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// There is a note on a sampled spin that ends with the run. There is none on a fold whose rows slow down, nor on a spin that ends
    /// earlier or later, has a repeated last row, or is extrapolated.
    #[test]
    fn a_table_that_brakes_at_the_end_of_the_run_is_told() {
        let said = |table: &str, stop_s: f64| {
            let text = format!(
                "name = \"Spin\"\n[section.rod]\nshape = \"rectangle\"\nwidth_m = 0.01\nheight_m = 0.01\ndensity_kg_m3 = 1e3\n\
                 youngs_modulus_Pa = 1e9\npoisson_ratio = 0.3\n[body.rod]\nlength_m = 1.0\nsection = \"rod\"\nelements = 1\n[joint.spin]\n\
                 type = \"revolute\"\nparent = \"root\"\nchild = \"rod\"\naxis = [0, 0, 1]\nmotion = \"prescribed\"\n{table}\n\
                 [simulation]\nstop_time_s = {stop_s:?}\nstep_s = 0.1\n"
            );
            let machine = foldwing_file::parse(&text, "spin.toml").unwrap_or_else(|error| panic!("{error}"));
            notes(&machine, machine.experiment.stop_time_s)
        };
        let spin = "table_s_deg = [[0, 0], [0.5, 150], [0.9, 300], [1, 330]]";
        assert_eq!(
            said(spin, 1.0),
            ["joint spin: in its last interval, from 0.9 s to 1 s, the table brakes from about 300 deg/s to rest; \
                 write table_ends = \"extrapolate\" to keep the rate, or add a row with the same angle if the joint should stop"]
        );
        assert_eq!(said(spin, 0.95).len(), 1, "inside the last interval");
        for (table, stop_s) in [
            (spin.to_owned(), 0.9),
            (spin.to_owned(), 2.0),
            (format!("{spin}\ntable_ends = \"extrapolate\""), 1.0),
            (spin.replace("[1, 330]", "[1, 330], [1.1, 330]"), 1.1),
            ("table_s_deg = [[0, 0], [0.5, 45], [0.8, 60], [1, 63]]".to_owned(), 1.0),
            ("polynomial_deg = [0, 300]".to_owned(), 1.0),
        ] {
            assert_eq!(said(&table, stop_s), [""; 0], "{table} to {stop_s} s");
        }
    }

    /// The capture range of a latch and its key have the unit of the joint, for rigid and elastic latches.
    #[test]
    fn the_window_of_a_latch_has_the_unit_of_its_joint() {
        for (kind, key, unit, coordinate) in
            [("revolute", "capture_deg", "deg", "angle"), ("prismatic", "capture_m", "m", "position")]
        {
            for latch in ["rigid", "elastic"] {
                let stiffness = match (latch, kind) {
                    ("rigid", _) => "",
                    (_, "revolute") => "stiffness_N_m_rad = 100.0\n",
                    _ => "stiffness_N_m = 100.0\n",
                };
                let text = format!(
                    "name = \"Latched\"\n[rigid_body.part]\nmass_kg = 1.0\ninertia_kg_m2 = [1, 1, 1, 0, 0, 0]\n[joint.hold]\n\
                     type = \"{kind}\"\nparent = \"root\"\nchild = \"part\"\naxis = [0, 0, 1]\nstart_{coordinate}_{unit} = 2.0\n\
                     [joint.hold.latch]\nkind = \"{latch}\"\n{coordinate}_{unit} = 0.0\n{key} = 0.5\n{stiffness}"
                );
                let machine = foldwing_file::parse(&text, "latched.toml").unwrap_or_else(|error| panic!("{error}"));
                let notes = notes(&machine, 1.0);
                let due = format!("joint hold: with {key} = 0.5 the enabled ");
                assert!(notes.len() == 1 && notes[0].starts_with(&due), "{notes:?}");
                assert!(notes[0].contains(&format!("latch closes 0.5 {unit} before its {coordinate}")), "{notes:?}");
            }
        }
    }
}
