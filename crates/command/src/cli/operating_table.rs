//! Tables of operating points: text, CSV and JSON.

use crate::cli::operating_points::Table;
use serde_json::{Value, json};
use std::fmt::Write;

/// Default outputs in the text, by the ends of their names, with factor and unit.
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

/// One operating point.
pub(super) struct Row {
    /// Wind in m/s.
    pub wind_m_s: f64,
    /// Rotor speed in rpm.
    pub speed_rpm: f64,
    /// Pitch in degrees; NaN if no joint pitches the blades.
    pub pitch_deg: f64,
    /// The state is periodic; otherwise it is steady in the rotating frame.
    pub is_periodic: bool,
    /// Whether the target is met; `None` without a target.
    pub held: Option<bool>,
    /// Mean and peak-to-peak value of each output.
    pub values: Vec<[f64; 2]>,
    /// Cause of a missing state.
    pub cause: Option<String>,
}

impl Row {
    fn state(&self) -> &'static str {
        match (&self.cause, self.is_periodic) {
            (Some(_), _) => "none",
            (None, true) => "periodic",
            (None, false) => "steady",
        }
    }

    fn held(&self) -> &'static str {
        match self.held {
            None => "",
            Some(true) => "held",
            Some(false) => "below",
        }
    }

    /// Cells of the CSV.
    pub fn cells(&self) -> Vec<String> {
        let number = |value: f64| if value.is_nan() { String::new() } else { format!("{value:?}") };
        let own = [number(self.wind_m_s), number(self.speed_rpm), number(self.pitch_deg)];
        let words = [self.state().to_owned(), self.held().to_owned(), self.cause.clone().unwrap_or_default()];
        let values = self.values.iter().flatten().map(|value| number(*value));
        own.into_iter().chain(words).chain(values).collect()
    }
}

/// Names of the columns of the CSV.
pub(super) fn header(outputs: &[(String, &'static str)]) -> Vec<String> {
    let own = ["wind_m_s", "rotor_speed_rpm", "pitch_deg", "state", "hold", "message"].map(str::to_owned);
    let values = outputs.iter().flat_map(|(name, _)| [format!("{name}.mean"), format!("{name}.peak_to_peak")]);
    own.into_iter().chain(values).collect()
}

/// Columns of the text: index of the output, factor, and heading.
pub(super) fn shown(table: &Table, named: bool) -> Vec<(usize, f64, String)> {
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

/// The table as text: means, and peak-to-peak values after a bar if the state is periodic.
pub(super) fn rows_text(table: &Table, columns: &[(usize, f64, String)]) -> String {
    let periodic = table.rows.iter().any(|row| row.is_periodic);
    let found = table.rows.iter().any(|row| row.held.is_some());
    let width = |heading: &str| heading.chars().count().max(11) + 2;
    let mut text =
        format!("{}: operating points, {}\n", table.name, if periodic { "means | peak to peak" } else { "steady" });
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
    for row in &table.rows {
        let _ = write!(text, "{:9.4}{:11.5}{:11.5}  {:8}", row.wind_m_s, row.speed_rpm, row.pitch_deg, row.state());
        if found {
            let _ = write!(text, " {:5}", row.held());
        }
        for part in 0..if periodic { 2 } else { 1 } {
            if part == 1 {
                text.push_str(" |");
            }
            for (place, factor, heading) in columns {
                let width = width(heading);
                let _ = match row.values.get(*place) {
                    Some(pair) => write!(text, "{:>width$}", digits(pair[part] * factor)),
                    None => write!(text, "{:>width$}", "-"),
                };
            }
        }
        text.push('\n');
    }
    text
}

/// Six digits, without an exponent if there is room.
fn digits(value: f64) -> String {
    let size = value.abs();
    match size {
        0.0 => "0".to_owned(),
        _ if !(1e-3..1e7).contains(&size) => format!("{value:.4e}"),
        _ => format!("{value:.*}", (5 - size.log10().floor() as i32).clamp(0, 6) as usize),
    }
}

/// The table as JSON.
pub(super) fn as_json(table: &Table) -> Value {
    let row = |row: &Row| {
        let column = |part: usize| -> Vec<f64> { row.values.iter().map(|pair| pair[part]).collect() };
        json!({
            "wind_m_s": row.wind_m_s,
            "rotor_speed_rpm": row.speed_rpm,
            "pitch_deg": row.pitch_deg,
            "state": row.state(),
            "hold": row.held.map(|held| if held { "held" } else { "below" }),
            "message": row.cause,
            "mean": column(0),
            "peak_to_peak": column(1),
        })
    };
    json!({
        "name": table.name,
        "outputs": table.outputs.iter().map(|(name, unit)| json!({ "name": name, "unit": unit })).collect::<Vec<_>>(),
        "points": table.rows.iter().map(row).collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packaging::drawing::tests::two_body_machine;
    use foldwing_fmi::interface::{Causality, Interface};

    /// Points in every kind of state, with all outputs of a machine.
    fn table() -> Table {
        let interface = Interface::new(&two_body_machine());
        let rows = interface.variables().iter().filter(|row| row.causality == Causality::Output);
        let outputs: Vec<_> = rows.map(|row| (row.name.clone(), row.unit())).collect();
        let row = |point: usize, is_periodic: bool, held: Option<bool>, cause: Option<&str>| Row {
            wind_m_s: point as f64,
            speed_rpm: 10.0 + point as f64,
            pitch_deg: if point == 0 { f64::NAN } else { -1.5 * point as f64 },
            is_periodic,
            held,
            values: match cause {
                Some(_) => Vec::new(),
                None => (0..outputs.len()).map(|i| [(100 * point + i) as f64, 0.5 + i as f64]).collect(),
            },
            cause: cause.map(str::to_owned),
        };
        let rows = vec![
            row(0, false, None, None),
            row(1, true, Some(true), None),
            row(2, true, Some(false), None),
            row(3, false, None, Some("no state")),
        ];
        Table { name: "Wing".to_owned(), blade: None, outputs, rows }
    }

    /// JSON has every output with its own name and unit, and every point with the numbers, state and message of the CSV.
    #[test]
    fn json_has_the_units_and_numbers_of_the_table() {
        let table = table();
        let json = as_json(&table);
        let listed: Vec<_> = json["outputs"].as_array().unwrap().iter().collect();
        assert!(listed.len() > 10 && listed.len() == table.outputs.len());
        for ((name, unit), listed) in table.outputs.iter().zip(listed) {
            assert_eq!(*listed, json!({ "name": name, "unit": unit }));
        }
        let states = ["steady", "periodic", "periodic", "none"];
        let holds = ["", "held", "below", ""];
        let header = header(&table.outputs);
        for (i, (row, point)) in table.rows.iter().zip(json["points"].as_array().unwrap()).enumerate() {
            let cells = row.cells();
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

    /// Named columns have headings with name and unit, if there is one; the numbers of the text are those of the table.
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
        for (row, line) in table.rows.iter().zip(lines) {
            let (means, peaks) = line.split_once('|').expect("a bar");
            let words = means.split_whitespace().rev().take(columns.len()).collect::<Vec<_>>();
            for (part, words) in [words.into_iter().rev().collect(), peaks.split_whitespace().collect::<Vec<_>>()]
                .into_iter()
                .enumerate()
            {
                assert_eq!(words.len(), columns.len());
                for (i, word) in words.into_iter().enumerate() {
                    match row.values.get(i) {
                        Some(pair) => assert_eq!(word.parse::<f64>(), Ok(pair[part])),
                        None => assert_eq!(word, "-"),
                    }
                }
            }
        }
    }

    /// Columns in other units: the factor is the ratio of the unit in the heading to the output's own.
    #[test]
    fn headings_of_people_have_the_factor_of_their_unit() {
        for (end, factor, heading) in SHOWN {
            let kilo = heading.rsplit(' ').next().is_some_and(|unit| unit.starts_with('k'));
            assert_eq!(factor, if kilo { 1e-3 } else { 1.0 }, "{end} as {heading}");
        }
    }
}
