//! Keys renamed since version 0.1.0: a file with an old key is invalid, and the message states its line and the new name.

/// Tables with renamed keys, the old names and the new ones. The table is the first part of the key's path; `*` matches
/// any.
const KEYS: &[(&str, &str, &str)] = &[
    ("*", "young_Pa", "youngs_modulus_Pa"),
    ("*", "shear_Pa", "shear_modulus_Pa"),
    ("section", "lag_stiffness_N_m2", "edge_stiffness_N_m2"),
    ("section", "coupling_axial_lag_N_m", "coupling_axial_edge_N_m"),
    ("section", "coupling_twist_lag_N_m2", "coupling_twist_edge_N_m2"),
    ("section", "coupling_flap_lag_N_m2", "coupling_flap_edge_N_m2"),
    ("section", "share", "eta"),
    ("body", "share", "eta"),
    ("body", "strain_damping_shares", "stiffness_damping_factors"),
    ("rigid_body", "moments_as_given", "allow_nonphysical_inertia"),
    ("modal_body", "cells", "nodes"),
    ("joint", "drive", "motor"),
    ("joint", "stops", "end_stops"),
    ("joint", "square_gain_N_m_rpm2", "quadratic_gain_N_m_rpm2"),
    ("joint", "beyond", "above_table"),
    ("failure", "remaining", "remaining_fraction"),
    ("aerodynamics", "established", "steady_initial_flow"),
    ("aerodynamics", "turns", "rotation_direction"),
    ("aerodynamics", "end_rule", "end_loads"),
    ("aerodynamics", "spread", "load_interpolation"),
    ("aerodynamics", "as_aerodyn", "aerodyn_compatible"),
    ("surface", "axis_fraction", "elastic_axis_fraction"),
    ("wind", "field_middle_height_m", "field_centre_height_m"),
    ("wind", "deviation_m_s", "standard_deviation_m_s"),
    ("wind", "plane_s", "plane_interval_s"),
    ("tower", "foot_m", "base_m"),
    ("", "section_load", "internal_load"),
    ("", "flap", "control_surface"),
    ("", "experiment", "simulation"),
];

/// Renamed values, listed with the present names of their keys.
const VALUES: &[(&str, &str, &str)] = &[
    ("kind", "drive_dies", "motor_loss"),
    ("kind", "drive_jams", "motor_jam"),
    ("kind", "drive_runs_away", "motor_runaway"),
    ("kind", "latch_breaks", "latch_break"),
    ("kind", "latch_does_not_catch", "latch_no_capture"),
    ("kind", "stopper_opens", "lock_release"),
    ("kind", "spring_breaks", "spring_break"),
    ("kind", "loop_opens", "loop_break"),
    ("kind", "body_weakens", "stiffness_loss"),
    ("kind", "brake_comes_on", "brake_applied"),
    ("table_ends", "onward", "extrapolate"),
    ("end_loads", "zero_load", "zero"),
    ("end_loads", "stopped", "full_induction"),
    ("load_interpolation", "cells", "piecewise_constant"),
    ("above_table", "torque", "constant_torque"),
    ("above_table", "power", "constant_power"),
];

/// Present name of a key of version 0.1.0. `path` leads to the key and includes it.
pub(super) fn key(path: &[String]) -> Option<&'static str> {
    let (name, tables) = path.split_last()?;
    let top = tables.first().map_or("", String::as_str);
    let holds = |table: &str| table == top || table == "*" && !top.is_empty();
    KEYS.iter().find(|(table, old, _)| old == name && holds(table)).map(|(_, _, new)| *new)
}

/// Present name of a value of version 0.1.0, under the present name of its key.
pub(super) fn value(key: &str, text: &str) -> Option<&'static str> {
    VALUES.iter().find(|(under, old, _)| *under == key && *old == text).map(|(_, _, new)| *new)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::{Node, options, properties};
    use std::collections::BTreeSet;

    /// All keys and enumerated values of the schema.
    fn words() -> (BTreeSet<String>, BTreeSet<String>) {
        let (mut keys, mut values) = (BTreeSet::new(), BTreeSet::new());
        let mut add = |schema: Node| {
            for (key, property) in properties(schema) {
                keys.insert(key.to_owned());
                values.extend(options(property.resolve()).unwrap_or_default().iter().map(|word| (*word).to_owned()));
            }
        };
        add(Node::root());
        let definitions = Node::root().child("$defs");
        for (name, _) in definitions.entries() {
            let definition = definitions.child(name);
            add(definition);
            definition.children("oneOf").into_iter().flatten().for_each(&mut add);
        }
        (keys, values)
    }

    #[test]
    fn new_names_are_in_the_schema_and_old_ones_are_not_where_they_were() {
        let (keys, values) = words();
        for (_, old, new) in KEYS {
            assert!(keys.contains(*new), "{new}");
            assert_ne!(old, new);
        }
        for (key, old, new) in VALUES {
            assert!(keys.contains(*key) && values.contains(*new), "{key} = {new}");
            assert!(!values.contains(*old) || ["torque", "power"].contains(old), "{old}");
        }
    }
}
