//! Rows of the continuous states and their time derivatives, for Model Exchange.

use crate::interface::table::{Place, Table, Text};
use crate::interface::{Dependencies, DependencyKind, Interface, MAXIMUM_LISTED, Variability};
use foldwing_engine::plant::{CoordinateName, CoordinateQuantity, Plant};

/// Declared types of a coordinate, of its rate and of the rate's rate.
fn types(quantity: CoordinateQuantity) -> [&'static str; 3] {
    match quantity {
        CoordinateQuantity::Angle => ["Angle", "AngularVelocity", "AngularAcceleration"],
        CoordinateQuantity::Position => ["Position", "Velocity", "Acceleration"],
        CoordinateQuantity::Parameter => ["Ratio", "RatioRate", "RatioAcceleration"],
        CoordinateQuantity::Strain => ["Strain", "StrainRate", "StrainAcceleration"],
        CoordinateQuantity::Curvature => ["Curvature", "CurvatureRate", "CurvatureAcceleration"],
    }
}

/// Energy accounts that are states, with their meaning and nominal value, J.
const ACCOUNTS: [(&str, &str); 2] = [("work", "work done by the inputs"), ("dissipated", "dissipated energy")];
const NOMINAL_ENERGY_J: f64 = 1.0;
/// Typical magnitude of a lag state in m/s.
const NOMINAL_LAG_M_S: f64 = 1.0;

/// Adds the rows: all states, then the derivatives in the same order. Returns the number of coordinates, whose rates follow them.
pub(super) fn add(table: &mut Table, plant: &Plant) -> usize {
    let coordinates = plant.exchange_coordinates();
    let first = table.variables.len();
    let reference = |state: usize| u32::try_from(first + state).ok();
    let mut rates = Vec::new();
    let mut add = |table: &mut Table, name: String, declared: [&'static str; 2], nominal: f64, meaning: &str| {
        let state = rates.len();
        let text = Text::new(name.clone(), format!("continuous state: {meaning}"));
        table.state(Place::State(state), declared[0], Some(nominal), None, text);
        rates.push((name, declared[1]));
    };
    for CoordinateName { name, quantity, nominal } in &coordinates {
        let [own, rate, _] = types(*quantity);
        add(table, format!("state.{name}"), [own, rate], nominal[0], name);
    }
    for CoordinateName { name, quantity, nominal } in &coordinates {
        let [_, own, rate] = types(*quantity);
        add(table, format!("state_rate.{name}"), [own, rate], nominal[1], &format!("rate of {name}"));
    }
    for name in plant.exchange_lags() {
        let meaning = format!("aerodynamic lag state {name}");
        add(table, format!("state.{name}"), ["Velocity", "Acceleration"], NOMINAL_LAG_M_S, &meaning);
    }
    for (name, meaning) in ACCOUNTS {
        add(table, format!("state.energy.{name}"), ["Energy", "Power"], NOMINAL_ENERGY_J, meaning);
    }
    for (state, (name, declared)) in rates.into_iter().enumerate() {
        let text = Text::new(format!("der({name})"), format!("time derivative of {name}"));
        table.state(Place::Derivative(state), declared, None, reference(state), text);
    }
    coordinates.len()
}

/// Adds the row of the event indicators, which FMI 3.0 requires as a variable: an array.
pub(super) fn add_indicators(table: &mut Table, plant: &Plant) {
    for indicator in 0..plant.exchange_indicator_count() {
        let number = indicator + 1;
        let text = Text::new(format!("event_indicator[{number}]"), format!("event indicator {number}"))
            .in_array("event_indicator", "event indicators: an event occurs at a zero crossing from above");
        table.state(Place::Indicator(indicator), "Ratio", None, None, text);
    }
}

impl Interface {
    /// Returns whether the table has continuous states.
    pub fn has_states(&self) -> bool {
        !self.nominals.is_empty()
    }

    /// Typical magnitudes of the continuous states, in their units.
    pub fn nominals(&self) -> &[f64] {
        &self.nominals
    }

    /// Name of a continuous state.
    pub fn state_name(&self, state: usize) -> &str {
        let of = |place: Place| place == Place::State(state);
        self.bounds.iter().position(|bound| of(bound.place)).map_or("", |row| &self.variables[row].name)
    }

    /// Returns whether a row can be set at events only, not during the integration.
    pub fn is_set_at_events(&self, reference: u32) -> bool {
        self.slots.get(reference as usize).is_some_and(|slot| slot.is_set_at_events())
    }

    /// Returns whether a row is a continuous state.
    pub fn is_state(&self, reference: u32) -> bool {
        self.bounds.get(reference as usize).is_some_and(|bound| matches!(bound.place, Place::State(_)))
    }

    /// Adds dependencies of continuous outputs and derivatives on the states. The rate of a coordinate that is not a redundant parameter is
    /// the state of that name; everything else is assumed to depend on all states.
    pub(super) fn add_states_to(&self, found: &mut [Dependencies]) {
        if !self.has_states() {
            return;
        }
        let states: Vec<u32> =
            self.variables.iter().filter(|row| row.nominal.is_some()).map(|row| row.value_reference).collect();
        let coordinates = self.coordinates;
        for ((found, row), bound) in found.iter_mut().zip(&self.variables).zip(&self.bounds) {
            match bound.place {
                Place::Output(_) if row.variability == Variability::Continuous && !found.on_all => {
                    found.running.extend(states.iter().map(|&state| (state, DependencyKind::Dependent)));
                    if found.running.len() > MAXIMUM_LISTED {
                        *found = Dependencies { on_all: true, ..Dependencies::default() };
                    }
                }
                Place::Derivative(state) if state < coordinates && row.declared_type != Some("RatioRate") => {
                    found.running = vec![(states[coordinates + state], DependencyKind::Constant)];
                }
                Place::Derivative(_) => found.on_all = true,
                Place::Time
                | Place::Input(_)
                | Place::Parameter(_)
                | Place::Output(_)
                | Place::Local(_)
                | Place::Duration(_)
                | Place::State(_)
                | Place::Indicator(_) => {}
            }
        }
    }
}
