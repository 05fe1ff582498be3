//! Rows of the continuous states and their time derivatives, for Model Exchange.

use crate::interface::table::{Place, Table, Text};
use foldwing_engine::plant::{CoordinateName, CoordinateQuantity, Plant};

/// Declared types of a coordinate and of its first and second time derivatives.
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
/// Declared types of a lag state and of its rate, and its typical magnitude, by its unit: velocities, angles of attack, and lift
/// coefficients and degrees of attachment.
fn types_of_lag(unit: &str) -> ([&'static str; 2], f64) {
    match unit {
        "m/s" => (["Velocity", "Acceleration"], 1.0),
        "rad" => (["Angle", "AngularVelocity"], 0.1),
        _ => (["Ratio", "RatioRate"], 1.0),
    }
}

/// Typical magnitude of a current in A.
const NOMINAL_CURRENT_A: f64 = 1.0;

/// Adds the rows: all states, then the derivatives in the same order. Returns the bodies of the coordinates, whose rates follow them.
pub(super) fn add(table: &mut Table, plant: &Plant) -> Vec<usize> {
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
    for CoordinateName { name, quantity, nominal, .. } in &coordinates {
        let [own, rate, _] = types(*quantity);
        add(table, format!("state.{name}"), [own, rate], nominal[0], name);
    }
    for CoordinateName { name, quantity, nominal, .. } in &coordinates {
        let [_, own, rate] = types(*quantity);
        add(table, format!("state_rate.{name}"), [own, rate], nominal[1], &format!("rate of {name}"));
    }
    for (name, unit) in plant.exchange_lags().into_iter().zip(plant.exchange_lag_units()) {
        let meaning = format!("aerodynamic lag state {name}");
        let (declared, nominal) = types_of_lag(unit);
        add(table, format!("state.{name}"), declared, nominal, &meaning);
    }
    for name in plant.exchange_currents() {
        let meaning = format!("armature current {name}");
        add(table, format!("state.{name}"), ["Current", "CurrentSlope"], NOMINAL_CURRENT_A, &meaning);
    }
    for (name, meaning) in ACCOUNTS.into_iter().filter(|_| plant.keeps_exchange_accounts()) {
        add(table, format!("state.energy.{name}"), ["Energy", "Power"], NOMINAL_ENERGY_J, meaning);
    }
    for (state, (name, declared)) in rates.into_iter().enumerate() {
        let text = Text::new(format!("der({name})"), format!("time derivative of {name}"));
        table.state(Place::Derivative(state), declared, None, reference(state), text);
    }
    coordinates.iter().map(|coordinate| coordinate.body).collect()
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
