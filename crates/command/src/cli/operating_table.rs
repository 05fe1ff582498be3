//! Tables of operating points: text, CSV and JSON.

use foldwing_study::operating_points::{OperatingPoints, Point, PointError, Statistics};
use serde_json::{Value, json};
use std::fmt::Write;

/// Default outputs in the text, by the ends of their names, with conversion factor and unit.
const SHOWN: [(&str, f64, &str); 9] = [
    ("rotor.tip_speed_ratio", 1.0, "tip speed ratio"),
    ("rotor.power", 1e-3, "power kW"),
    ("rotor.torque", 1e-3, "torque kN.m"),
    ("rotor.thrust", 1e-3, "thrust kN"),
    ("rotor.power_coefficient", 1.0, "Cp"),
    ("rotor.thrust_coefficient", 1.0, "Ct"),
    (".deflection.z", 1.0, "tip z m"),
    (".deflection.y", 1.0, "tip y m"),
    (".root_moment.y", 1e-3, "root y kN.m"),
];

/// Cells of a row of the CSV; `words` converts an error to text.
pub(super) fn cells(point: &Point, words: &dyn Fn(&PointError) -> String) -> Vec<String> {
    let number = |value: f64| if value.is_nan() { String::new() } else { format!("{value:?}") };
    let own = [number(point.wind_m_s), number(point.speed_rpm), number(point.pitch_deg)];
    let message = point.state.as_ref().err().map(words).unwrap_or_default();
    let texts = [point.state_name().to_owned(), point.hold_name().unwrap_or_default().to_owned(), message];
    let values = point.outputs().iter().flat_map(|output| [number(output.mean), number(output.peak_to_peak)]);
    own.into_iter().chain(texts).chain(values).collect()
}

/// Names of the CSV columns.
pub(super) fn header(outputs: &[(String, &'static str)]) -> Vec<String> {
    let own = ["wind_m_s", "rotor_speed_rpm", "pitch_deg", "state", "hold", "message"].map(str::to_owned);
    let values = outputs.iter().flat_map(|(name, _)| [format!("{name}.mean"), format!("{name}.peak_to_peak")]);
    own.into_iter().chain(values).collect()
}

/// Columns of the text: index of the output, conversion factor, and heading.
pub(super) fn shown(table: &OperatingPoints, named: bool) -> Vec<(usize, f64, String)> {
    let outputs = table.outputs.iter().enumerate();
    if named {
        let label =
            |name: &str, unit: &str| if ["", "1"].contains(&unit) { name.to_owned() } else { format!("{name} {unit}") };
        return outputs.map(|(i, (name, unit))| (i, 1.0, label(name, unit))).collect();
    }
    let of = |(end, factor, heading): &(&str, f64, &str)| {
        let own = |name: &str| match end.strip_prefix('.') {
            Some(end) => table.blade.as_ref().is_some_and(|blade| *name == format!("body.{blade}.{end}")),
            None => name == *end,
        };
        let place = table.outputs.iter().position(|(name, _)| own(name))?;
        Some((place, *factor, (*heading).to_owned()))
    };
    SHOWN.iter().filter_map(of).collect()
}

/// Table as text: mean values, followed by a bar and peak-to-peak values if the state is periodic.
pub(super) fn rows_text(table: &OperatingPoints, columns: &[(usize, f64, String)]) -> String {
    let states = || table.points.iter().filter_map(|point| point.state.as_ref().ok());
    let periodic = states().any(|state| state.is_periodic);
    let found = states().any(|state| state.held.is_some());
    let width = |heading: &str| heading.chars().count().max(11) + 2;
    let mut text =
        format!("{}: operating points, {}\n", table.machine, if periodic { "means | peak to peak" } else { "steady" });
    let _ = write!(text, "{:>9}{:>11}{:>11}  {:8}", "wind m/s", "speed rpm", "pitch deg", "state");
    if found {
        let _ = write!(text, " {:5}", "hold");
    }
    let headings = |text: &mut String| {
        columns.iter().for_each(|(_, _, heading)| {
            let _ = write!(text, "{heading:>width$}", width = width(heading));
        })
    };
    headings(&mut text);
    if periodic {
        text.push_str(" |");
        headings(&mut text);
    }
    text.push('\n');
    for point in &table.points {
        let Point { wind_m_s, speed_rpm, pitch_deg, .. } = point;
        let _ = write!(text, "{wind_m_s:9.4}{speed_rpm:11.5}{pitch_deg:11.5}  {:8}", point.state_name());
        if found {
            let _ = write!(text, " {:5}", point.hold_name().unwrap_or_default());
        }
        for part in 0..if periodic { 2 } else { 1 } {
            if part == 1 {
                text.push_str(" |");
            }
            for (place, factor, heading) in columns {
                let width = width(heading);
                let _ = match point.outputs().get(*place) {
                    Some(Statistics { mean, peak_to_peak }) => {
                        write!(text, "{:>width$}", digits([mean, peak_to_peak][part] * factor))
                    }
                    None => write!(text, "{:>width$}", "-"),
                };
            }
        }
        text.push('\n');
    }
    text
}

/// Formats six digits, without an exponent if there is room.
fn digits(value: f64) -> String {
    let size = value.abs();
    match size {
        0.0 => "0".to_owned(),
        _ if !(1e-3..1e7).contains(&size) => format!("{value:.4e}"),
        _ => format!("{value:.*}", (5 - size.log10().floor() as i32).clamp(0, 6) as usize),
    }
}

/// Table as JSON; `words` converts an error to text.
pub(super) fn as_json(table: &OperatingPoints, words: &dyn Fn(&PointError) -> String) -> Value {
    let mut value = json!(table);
    for (i, point) in table.points.iter().enumerate() {
        if let Err(error) = &point.state {
            value["points"][i]["message"] = words(error).into();
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packaging::drawing::tests::two_body_machine;
    use foldwing_fmi::interface::{Causality, Interface};
    use foldwing_study::operating_points::State;

    /// Table with points of every kind (steady, periodic, without a state), with all outputs of a model.
    fn table() -> OperatingPoints {
        let interface = Interface::new(&two_body_machine());
        let rows = interface.variables().iter().filter(|row| row.causality == Causality::Output);
        let outputs: Vec<_> = rows.map(|row| (row.name.clone(), row.unit())).collect();
        let statistics =
            |point: usize, i: usize| Statistics { mean: (100 * point + i) as f64, peak_to_peak: 0.5 + i as f64 };
        let state = |point: usize, is_periodic: bool, held: Option<bool>| State {
            is_periodic,
            held,
            outputs: (0..outputs.len()).map(|i| statistics(point, i)).collect(),
        };
        let states = [
            Ok(state(0, false, None)),
            Ok(state(1, true, Some(true))),
            Ok(state(2, true, Some(false))),
            Err(PointError::NoTurn { cause: "still".to_owned() }),
        ];
        let point = |(i, state): (usize, Result<State, PointError>)| Point {
            wind_m_s: i as f64,
            speed_rpm: 10.0 + i as f64,
            pitch_deg: if i == 0 { f64::NAN } else { -1.5 * i as f64 },
            state,
        };
        let points = states.into_iter().enumerate().map(point).collect();
        OperatingPoints { machine: "Wing".to_owned(), blade: None, outputs, points }
    }

    fn words(error: &PointError) -> String {
        format!("{error}!")
    }

    /// The JSON has every output with its name and unit, and every point with the numbers, state and message of the CSV.
    #[test]
    fn json_has_the_units_and_numbers_of_the_table() {
        let table = table();
        let json = as_json(&table, &words);
        let listed: Vec<_> = json["outputs"].as_array().unwrap().iter().collect();
        assert!(listed.len() > 10 && listed.len() == table.outputs.len());
        for ((name, unit), listed) in table.outputs.iter().zip(listed) {
            assert_eq!(*listed, json!({ "name": name, "unit": unit }));
        }
        let states = ["steady", "periodic", "periodic", "none"];
        let holds = ["", "held", "below", ""];
        let header = header(&table.outputs);
        for (i, (row, point)) in table.points.iter().zip(json["points"].as_array().unwrap()).enumerate() {
            let cells = cells(row, &words);
            let text = |key: &str| match &point[key] {
                Value::Null => String::new(),
                Value::String(text) => text.clone(),
                other @ (Value::Bool(_) | Value::Number(_) | Value::Array(_) | Value::Object(_)) => {
                    format!("{:?}", other.as_f64().unwrap())
                }
            };
            for (key, cell) in header.iter().zip(&cells).take(6) {
                assert_eq!(text(key), *cell, "{key} of point {i}");
            }
            assert_eq!([&cells[3], &cells[4]], [states[i], holds[i]]);
            let column = |key: &str| point[key].as_array().unwrap().clone();
            let pairs = column("mean").into_iter().zip(column("peak_to_peak")).flat_map(|(mean, peaks)| [mean, peaks]);
            let pairs: Vec<String> = pairs.map(|value| format!("{:?}", value.as_f64().unwrap())).collect();
            assert_eq!(pairs, cells[6..]);
        }
    }

    /// Columns selected by name have headings with the name and any unit; the numbers in the text are those of the
    /// table.
    #[test]
    fn text_has_the_units_and_numbers_of_the_table() {
        let table = table();
        let columns = shown(&table, true);
        for ((place, factor, heading), (i, (name, unit))) in columns.iter().zip(table.outputs.iter().enumerate()) {
            let due = if ["", "1"].contains(unit) { name.clone() } else { format!("{name} {unit}") };
            assert_eq!((*place, *factor, heading), (i, 1.0, &due));
        }
        let text = rows_text(&table, &columns);
        let mut lines = text.lines().skip(1);
        let heading = lines.next().unwrap();
        for (_, _, own) in &columns {
            assert_eq!(heading.matches(own.as_str()).count() % 2, 0, "{own}: once for means and once for peaks");
        }
        for (row, line) in table.points.iter().zip(lines) {
            let (means, peaks) = line.split_once('|').expect("a bar");
            let words = means.split_whitespace().rev().take(columns.len()).collect::<Vec<_>>();
            for (part, words) in [words.into_iter().rev().collect(), peaks.split_whitespace().collect::<Vec<_>>()]
                .into_iter()
                .enumerate()
            {
                assert_eq!(words.len(), columns.len());
                for (i, word) in words.into_iter().enumerate() {
                    match row.outputs().get(i) {
                        Some(output) => assert_eq!(word.parse::<f64>(), Ok([output.mean, output.peak_to_peak][part])),
                        None => assert_eq!(word, "-"),
                    }
                }
            }
        }
    }

    /// For columns shown in another unit, the factor is the ratio of the unit in the heading to the output's unit.
    #[test]
    fn headings_of_people_have_the_factor_of_their_unit() {
        for (end, factor, heading) in SHOWN {
            let kilo = heading.rsplit(' ').next().is_some_and(|unit| unit.starts_with('k'));
            assert_eq!(factor, if kilo { 1e-3 } else { 1.0 }, "{end} as {heading}");
        }
    }
}
