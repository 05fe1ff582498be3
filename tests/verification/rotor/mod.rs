//! Aerodynamics of rotors: RT-01 and following. Reference numbers: `tests/reference/turbine`.

mod exchange;
mod hover;
mod linear;
mod order;
pub mod several;
mod several_linear;
mod steady;
mod turning;
mod unsteady;
mod wind;

use foldwing::aero::polar::Polar;
use foldwing::aero::rotor::induction::EndRule;
use foldwing::aero::rotor::steady::{BladeNode, SteadyRotor};
use std::collections::BTreeMap;

/// Text of a file of `tests/reference/turbine`.
pub(crate) fn reference(name: &str) -> String {
    let path = format!("{}/tests/reference/turbine/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Rows of a CSV text by column; comments begin with `#`.
pub(crate) fn table(text: &str) -> Vec<BTreeMap<String, String>> {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let row =
        |line: &str| names.iter().map(|name| (*name).to_owned()).zip(line.split(',').map(str::to_owned)).collect();
    lines.map(row).collect()
}

pub(crate) fn number(row: &BTreeMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: {}", row[column]))
}

/// A section's polar, read by the product.
pub(crate) fn polar(section: &str) -> Polar {
    foldwing::config::read_polars(&reference(&format!("polars/{section}.csv"))).unwrap().remove(0).polar
}

/// The NREL 5 MW rotor without cone.
pub(crate) fn nrel_5mw(end_loads: EndRule) -> SteadyRotor {
    let rows = table(&reference("nrel5mw_blade.csv"));
    let mut sections: Vec<String> = Vec::new();
    let nodes = rows
        .iter()
        .map(|row| {
            let polar = sections.iter().position(|name| *name == row["section"]).unwrap_or_else(|| {
                sections.push(row["section"].clone());
                sections.len() - 1
            });
            BladeNode {
                radius_m: 1.5 + number(row, "span_m"),
                chord_m: number(row, "chord_m"),
                twist_rad: number(row, "twist_deg").to_radians(),
                polar,
            }
        })
        .collect();
    SteadyRotor {
        blades: 3,
        hub_radius_m: 1.5,
        tip_radius_m: 62.9999,
        density_kg_m3: 1.225,
        nodes,
        polars: sections.iter().map(|section| polar(section)).collect(),
        end_loads,
    }
}
