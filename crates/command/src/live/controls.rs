//! Sliders and switches of the page: every input, and every parameter that may change during a run.

use foldwing_engine::machine::UNLIMITED;
use foldwing_engine::plant::Plant;
use foldwing_fmi::interface::{Causality, Interface, UNITS, Value, Variability, Variable};
use serde::Serialize;

/// Gravitational acceleration for the typical size of forces, in m/s².
const GRAVITY_M_S2: f64 = 9.81;

/// Input or tunable parameter as shown on the page.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Control {
    /// Name of the variable.
    pub name: String,
    /// Causality: `input` or `parameter`.
    pub role: &'static str,
    /// Type of control: `real`, `integer` or `switch`.
    pub kind: &'static str,
    /// Unit in which the value is shown; empty for switches and dimensionless numbers.
    pub unit: &'static str,
    /// Ratio of shown value to variable value.
    pub factor: f64,
    /// Range of the slider, in the shown unit. The number field next to it accepts every allowed value.
    pub slider: [f64; 2],
    /// Smallest and largest allowed values, in the shown unit; `None` without a limit.
    pub allowed: [Option<f64>; 2],
    /// Description in one sentence.
    pub description: String,
    /// Value reference.
    #[serde(skip)]
    pub reference: u32,
}

/// All controls of a plant in the order of its variables, inputs before parameters.
pub fn controls(interface: &Interface, plant: &Plant) -> Vec<Control> {
    let scales = Scales::of(plant);
    let rows = interface.variables().iter();
    rows.filter_map(|row| control(row, interface, plant, &scales)).collect()
}

fn control(row: &Variable, interface: &Interface, plant: &Plant, scales: &Scales) -> Option<Control> {
    let role = match (row.causality, row.variability) {
        (Causality::Input, _) => "input",
        (Causality::Parameter, Variability::Tunable) => "parameter",
        (Causality::Parameter | Causality::Output | Causality::Local | Causality::Independent, _) => return None,
    };
    let value = interface.get(plant, plant.outputs(), row.value_reference)?;
    let unit = row.unit();
    let (unit, factor) = match UNITS.iter().find(|known| known.name == unit).and_then(|known| known.display) {
        Some((name, factor)) => (name, factor),
        None => (if unit == "1" { "" } else { unit }, 1.0),
    };
    let (least, most) = row.range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let bound = |value: f64| (value.abs() < UNLIMITED).then_some(value * factor);
    let allowed = [bound(least), bound(most)];
    let (kind, slider) = match value {
        Value::Boolean(_) => ("switch", [0.0, 1.0]),
        Value::Integer(value) => ("integer", ends(f64::from(value), 10.0, allowed)),
        Value::Real(value) => ("real", ends(value * factor, scales.of_unit(row.unit()) * factor, allowed)),
    };
    let (name, description) = (row.name.clone(), row.description.clone());
    Some(Control { name, role, kind, unit, factor, slider, allowed, description, reference: row.value_reference })
}

/// Range of a slider: up to twice the current value, or for a value of zero a typical size for its unit, within the allowed
/// range.
fn ends(value: f64, scale: f64, [least, most]: [Option<f64>; 2]) -> [f64; 2] {
    // a value that means "unlimited" does not give a size
    let size = if value == 0.0 || value.abs() >= UNLIMITED { scale } else { 2.0 * value.abs() };
    let narrow = |bound: Option<f64>| bound.filter(|bound| bound.abs() <= 20.0 * size);
    let low = narrow(least).unwrap_or(if least.is_some_and(|least| least >= 0.0) { 0.0 } else { -size });
    let high = narrow(most).unwrap_or(if most.is_some_and(|most| most <= 0.0) { 0.0 } else { size });
    [low, high]
}

/// Typical magnitudes of the quantities of a model.
struct Scales {
    weight_n: f64,
    length_m: f64,
}

impl Scales {
    fn of(plant: &Plant) -> Self {
        let length_m = plant.machine().bodies.iter().map(|body| body.length_m).sum::<f64>();
        Self { weight_n: rounded(GRAVITY_M_S2 * plant.mass_kg()), length_m }
    }

    /// Typical size of a quantity with this unit.
    fn of_unit(&self, unit: &str) -> f64 {
        match unit {
            "N" => self.weight_n,
            "N.m" => rounded(self.weight_n * self.length_m.max(1e-3)),
            "rad" | "rad/s" => std::f64::consts::PI,
            "rad/s2" => 10.0 * std::f64::consts::PI,
            "m/s2" => 2.0 * GRAVITY_M_S2,
            "m/s" => 20.0,
            "m" => rounded(self.length_m),
            "s" => 0.1,
            _ => 1.0,
        }
    }
}

/// Rounds up to 1, 2 or 5 times a power of ten.
fn rounded(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 1.0;
    }
    let power = 10_f64.powf(value.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|step| step * power).into_iter().find(|round| *round >= value * 0.999).unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::live::tests::started;

    /// Every input and tunable parameter, and nothing else, has a control; angles are in degrees; slider ranges include the
    /// current values.
    #[test]
    fn every_input_and_tunable_parameter_has_a_control() {
        for model in ["folding_wing", "folding_wing_in_tunnel", "flying_wing"] {
            let (interface, plant) = started(model);
            let found = controls(&interface, &plant);
            let settable = interface.variables().iter().filter(|row| match row.causality {
                Causality::Input => true,
                Causality::Parameter => row.variability == Variability::Tunable,
                Causality::Output | Causality::Local | Causality::Independent => false,
            });
            assert_eq!(
                found.iter().map(|one| &one.name).collect::<Vec<_>>(),
                settable.map(|row| &row.name).collect::<Vec<_>>()
            );
            for one in &found {
                let [low, high] = one.slider;
                assert!(low < high && low.is_finite() && high.is_finite(), "{}: {low} to {high}", one.name);
                assert!(one.allowed[0].is_none_or(|least| least <= low), "{}", one.name);
                assert!(one.allowed[1].is_none_or(|most| most >= high), "{}", one.name);
                let value = crate::report::number(&interface.get(&plant, plant.outputs(), one.reference).unwrap());
                let shown = one.factor * value;
                assert!(shown.abs() >= UNLIMITED || (low..=high).contains(&shown), "{}: {shown}", one.name);
            }
            let command = found.iter().find(|one| one.name == "fold.angle_command");
            assert!(command.is_none_or(|one| one.unit == "deg" && one.slider == [-180.0, 180.0]));
        }
    }

    /// Sliders of forces extend to the weight, 0.62 N rounded up.
    #[test]
    fn forces_are_as_large_as_the_weight() {
        let (interface, plant) = started("folding_wing");
        let found = controls(&interface, &plant);
        let force = found.iter().find(|one| one.name == "load.outer[4].force.z").unwrap();
        assert_eq!((force.kind, force.unit, force.slider, force.allowed), ("real", "N", [-1.0, 1.0], [None, None]));
        let release = found.iter().find(|one| one.name == "fold.release").unwrap();
        assert_eq!((release.kind, release.role), ("switch", "input"));
        assert_eq!([0.3, 1.0, 1.2, 6.0e6].map(rounded), [0.5, 1.0, 2.0, 1e7]);
    }
}
