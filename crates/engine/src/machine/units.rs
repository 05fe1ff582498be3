//! Units indicated by the ending of a name, and numbers in words.

/// Unit and quantity of the keys with a common ending.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unit {
    /// Ending of the key, e.g. `_N_m_rad`.
    pub suffix: &'static str,
    /// Unit symbol, e.g. `N·m/rad`.
    pub symbol: &'static str,
    /// Quantity in the singular, e.g. `stiffness`.
    pub quantity: &'static str,
}

const fn unit(suffix: &'static str, symbol: &'static str, quantity: &'static str) -> Unit {
    Unit { suffix, symbol, quantity }
}

/// All endings, longer ones before those that they contain. `mass_kg_m` is a mass per length, any other `_kg_m` a moment; `stiffness_N_m`
/// is a stiffness, any other `_N_m` a torque.
const UNITS: &[Unit] = &[
    unit("_N_m_s_rad", "N·m·s/rad", "damping"),
    unit("_N_m_rad", "N·m/rad", "stiffness"),
    unit("_N_m2", "N·m²", "stiffness"),
    unit("_N_s_m", "N·s/m", "damping"),
    unit("stiffness_N_m", "N/m", "stiffness"),
    unit("_N_m_A", "N·m/A", "torque constant"),
    unit("_N_A", "N/A", "force constant"),
    unit("resistance_ohm", "Ω", "resistance"),
    unit("inductance_H", "H", "inductance"),
    unit("voltage_V", "V", "voltage"),
    unit("current_A", "A", "current"),
    unit("_N_m", "N·m", "torque"),
    unit("_kg_m3", "kg/m³", "density"),
    unit("_kg_m2", "kg·m²", "inertia"),
    unit("mass_kg_m", "kg/m", "mass per length"),
    unit("_kg_m", "kg·m", "second moment"),
    unit("_kg", "kg", "mass"),
    unit("_Pa", "Pa", "modulus"),
    unit("_m_s2", "m/s²", "acceleration"),
    unit("_m_s", "m/s", "velocity"),
    unit("_rad_s", "rad/s", "rate"),
    unit("_deg_s", "deg/s", "rate"),
    unit("_s_deg", "s, deg", "pair"),
    unit("table_s_m", "s, m", "pair"),
    unit("_1_rad", "1/rad", "slope"),
    unit("_rad", "rad", "angle"),
    unit("_deg", "deg", "angle"),
    unit("_1_m", "1/m", "curvature"),
    unit("_1_s", "1/s", "damping"),
    unit("_SI", "SI", "number"),
    unit("force_N", "N", "force"),
    unit("force_limit_N", "N", "force"),
    unit("_N", "N", "stiffness"),
    unit("_s", "s", "time"),
    unit("_m", "m", "length"),
];

/// Unit of a key of the model file or of a field of the machine; `None` if its ending contains no unit.
pub fn unit_of(key: &str) -> Option<Unit> {
    let ends = |unit: &&Unit| {
        let begin = key.len().checked_sub(unit.suffix.len());
        begin.and_then(|begin| key.get(begin..)).is_some_and(|ending| ending.eq_ignore_ascii_case(unit.suffix))
    };
    let unit = UNITS.iter().find(ends).copied()?;
    // Off-diagonal stiffnesses in N·m are not torques.
    Some(if key.starts_with("coupling_") { Unit { quantity: "stiffness", ..unit } } else { unit })
}

/// Description of a finite number, with a range that starts with a space or is empty, e.g. `a finite length > 0 m`; of several numbers with
/// `plural`.
pub fn finite(key: &str, range: &str, plural: &str) -> String {
    let article = if plural.is_empty() { "a " } else { "" };
    let (quantity, unit) = unit_of(key).map_or(("number", ""), |unit| (unit.quantity, unit.symbol));
    let unit = match (unit, range.is_empty()) {
        ("", _) => String::new(),
        (unit, true) => format!(" in {unit}"),
        (unit, false) if unit.starts_with(char::is_numeric) => format!(" ({unit})"),
        (unit, false) => format!(" {unit}"),
    };
    let quantity = match quantity.strip_suffix('y') {
        Some(stem) if !plural.is_empty() => format!("{stem}ie"),
        _ => quantity.to_owned(),
    };
    format!("{article}finite {quantity}{plural}{range}{unit}")
}

/// Quoted alternatives, for example `"a" or "b"`.
pub fn quoted(options: &[&str]) -> String {
    options.iter().map(|option| format!("{option:?}")).collect::<Vec<_>>().join(" or ")
}

/// A number as text in its shortest form.
pub fn shortest(value: f64) -> String {
    let size = value.abs();
    if value != 0.0 && !(1e-3..1e6).contains(&size) { format!("{value:e}") } else { format!("{value}") }
}

/// The known key that `key` denotes without a unit or with a different one, e.g. `length` or `length_mm` for `length_m`.
pub fn same_quantity<'a>(key: &str, known: impl IntoIterator<Item = &'a str>) -> Option<(&'a str, Unit)> {
    known
        .into_iter()
        .filter_map(|known| unit_of(known).map(|unit| (known, unit)))
        .filter(|(known, unit)| {
            let ending = unit.suffix.trim_start_matches(|c: char| c != '_').len();
            let stem = &known[..known.len() - ending];
            key.strip_prefix(stem).is_some_and(|rest| rest.is_empty() || (rest.starts_with('_') && is_unit_like(rest)))
        })
        .max_by_key(|(known, _)| known.len())
}

/// Whether every part after an underscore is short enough to be a unit, as in `_mm` or `_kN_m`.
fn is_unit_like(ending: &str) -> bool {
    ending.split('_').skip(1).all(|part| !part.is_empty() && part.len() <= 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn longer_endings_win() {
        assert_eq!(unit_of("stiffness_N_m_rad").unwrap().symbol, "N·m/rad");
        assert_eq!(unit_of("stiffness_N_m").unwrap().symbol, "N/m");
        assert_eq!(unit_of("moment_N_m").unwrap().symbol, "N·m");
        assert_eq!(unit_of("mass_kg_m").unwrap().symbol, "kg/m");
        assert_eq!(unit_of("second_moments_kg_m").unwrap().symbol, "kg·m");
        assert_eq!(unit_of("mass_damping_1_s").unwrap().symbol, "1/s");
        assert_eq!(unit_of("elements"), None);
        assert_eq!(unit_of("coupling_iterations"), None);
        for key in ["coupling_axial_twist_N_m", "coupling_axial_flap_N_m", "coupling_flap_edge_N_m2"] {
            assert_eq!(unit_of(key).unwrap().quantity, "stiffness", "{key}");
        }
    }

    #[test]
    fn a_key_without_its_unit_or_with_another_is_recognised() {
        let known = ["length_m", "mass_kg_m", "axial_stiffness_N", "start_rate_deg_s"];
        for (written, meant) in [
            ("length", "length_m"),
            ("length_mm", "length_m"),
            ("mass", "mass_kg_m"),
            ("start_rate", "start_rate_deg_s"),
            ("start_rate_rad_s", "start_rate_deg_s"),
        ] {
            assert_eq!(same_quantity(written, known).map(|(key, _)| key), Some(meant));
        }
        assert_eq!(same_quantity("length_of_something", known), None);
    }
}
