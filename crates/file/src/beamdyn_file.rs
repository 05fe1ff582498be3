//! BeamDyn's files: the sections of a blade as 6×6 matrices, and its axis as key points.
//!
//! BeamDyn's axes are `x` downwind, `y` towards the trailing edge, `z` along the blade; here `x` runs along the blade, `y` towards the
//! leading edge, `z` downwind: `(x, y, z) = (z, −y, x)` in BeamDyn's axes. BeamDyn's twist is negative about its `z`.

use crate::section_files::{Lines, Station, Stiffness};
use crate::station_table::{StationFault, StationTable, fault};
use foldwing_engine::math::quadrature::gauss_pieces;
use foldwing_engine::math::spline::CubicSpline;

/// Returns whether a text is a BeamDyn file, judged by its first line. Lines that start with `#` are comments of a CSV file.
pub(super) fn is_beamdyn(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.next().is_some_and(|line| line.to_ascii_uppercase().contains("BEAMDYN"))
}

/// Reads the sections of a blade from BeamDyn's blade file.
///
/// # Errors
/// A truncated file, invalid numbers, or stations that do not ascend from 0 to 1.
pub(super) fn stations(text: &str) -> Result<Vec<Station>, StationFault> {
    let (mut lines, count) = to_stations(text)?;
    let mut stations: Vec<Station> = Vec::with_capacity(count);
    for station in 1..=count {
        let (line, [share]) = lines.numbers(&format!("station {station} of {count}"))?;
        if let Some(last) = stations.last().and_then(|last| last.share).filter(|last| *last >= share) {
            return Err(fault(
                line,
                format!("station {station} at {share} after {last}; stations must ascend from 0 to 1"),
            ));
        }
        let (line, stiffness) = lines.matrix::<6>(&format!("the stiffness of station {station}"))?;
        let (inertia_line, inertia) = lines.matrix::<6>(&format!("the inertia of station {station}"))?;
        let stiffness = Stiffness::Whole(stiffness);
        stations.push(Station { share: Some(share), lines: [line, inertia_line], stiffness, inertia });
    }
    Ok(stations)
}

/// Lines of a blade file from its first station on, and the number of stations.
fn to_stations(text: &str) -> Result<(Lines<'_>, usize), StationFault> {
    let mut lines = Lines::of(text);
    let (_, count) = lines.labelled("station_total")?;
    loop {
        let (_, line) = lines.next("its distributed properties")?;
        if line.to_ascii_uppercase().contains("DISTRIBUTED PROPERTIES") {
            return Ok((lines, count));
        }
    }
}

/// Reads the axis of a blade from BeamDyn's primary file, as columns of `[body.<name>.axis]`: arc lengths of the key points along natural
/// cubic splines parametrised by the chords between them, and the points with their twist.
///
/// # Errors
/// A truncated file, values that are not numbers, several members, coincident points, or a first point that is not the origin.
pub(super) fn read_key_points(text: &str) -> Result<StationTable, StationFault> {
    let mut lines = Lines::of(text);
    let (line, members) = lines.labelled("member_total")?;
    if members != 1 {
        return Err(fault(line, format!("member_total is {members}; blades of one member are read")));
    }
    let (line, count) = lines.labelled("kp_total")?;
    if count < 2 {
        return Err(fault(line, format!("kp_total is {count}; at least 2 key points are needed")));
    }
    loop {
        let (_, line) = lines.next("its key points")?;
        if line.contains("initial_twist") {
            break;
        }
    }
    lines.next("its key points")?; // line of units
    let mut points: [Vec<f64>; 4] = [const { Vec::new() }; 4];
    let mut chord_m: Vec<f64> = Vec::with_capacity(count);
    for index in 0..count {
        let (line, values) = lines.numbers::<4>(&format!("key point {} of {count}", index + 1))?;
        let step_m = match index.checked_sub(1) {
            Some(last) => (0..3).map(|axis| values[axis] - points[axis][last]).map(|d| d * d).sum::<f64>().sqrt(),
            None if values[..3] != [0.0; 3] => {
                return Err(fault(line, "the first key point is not the origin, where the blade begins"));
            }
            None => 0.0,
        };
        if index > 0 && step_m == 0.0 {
            return Err(fault(line, format!("key points {index} and {} coincide", index + 1)));
        }
        chord_m.push(chord_m.last().copied().unwrap_or_default() + step_m);
        points.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
    }
    let [x, y, z, twist] = points;
    let splines = [&x, &y, &z].map(|values| CubicSpline::new(&chord_m, values));
    let mut s_m = vec![0.0];
    for pair in chord_m.windows(2) {
        let speed = |at: f64| splines.iter().map(|spline| spline.slopes(at)[0].powi(2)).sum::<f64>().sqrt();
        let arc_m: f64 = gauss_pieces(pair[0], pair[1], &[]).iter().map(|(at, weight)| speed(*at) * weight).sum();
        s_m.push(s_m[s_m.len() - 1] + arc_m);
    }
    let straight = |values: &[f64]| values.iter().all(|value| *value == 0.0);
    if straight(&x) && straight(&y) {
        s_m = z; // exact for a straight axis, without the error of the integral
    }
    let negative = |values: &[f64]| values.iter().map(|value| 0.0 - value).collect::<Vec<f64>>();
    let names = ["s_m", "y_m", "z_m", "twist_deg"].map(str::to_owned).to_vec();
    Ok(StationTable { names, columns: vec![s_m, negative(&y), x, negative(&twist)] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::station_file::read_sections as read_blade;
    use nalgebra::Matrix6;

    const STATIONS: usize = 3;

    /// Lines of a blade with uniform sections, and the indices of the lines with numbers: for each station its position, six rows of
    /// stiffness and six of inertia, with an empty line after each matrix as in the format.
    fn blade() -> (Vec<String>, Vec<usize>) {
        let front = "BEAMDYN blade\nabout it\n 3 station_total\n 1 damp_type\n\n---- DISTRIBUTED PROPERTIES ----";
        let mut lines: Vec<String> = front.lines().map(str::to_owned).collect();
        let mut numbers = Vec::new();
        let rows = |matrix: Matrix6<f64>| {
            matrix.row_iter().map(|row| format!("{:?}", row.iter().collect::<Vec<_>>())).collect::<Vec<_>>()
        };
        let stiffness = Matrix6::from_diagonal(&[2e8, 3e8, 3e9, 4e9, 5e9, 1e9].into());
        let inertia = Matrix6::from_diagonal(&[100.0, 100.0, 100.0, 30.0, 20.0, 50.0].into());
        for station in 0..STATIONS {
            let own = [vec![(station as f64 / 2.0).to_string()], rows(stiffness), rows(inertia)];
            for (part, own) in own.into_iter().enumerate() {
                for row in own {
                    numbers.push(lines.len());
                    lines.push(row.replace(['[', ']', ','], " "));
                }
                if part > 0 {
                    lines.push(String::new());
                }
            }
        }
        (lines, numbers)
    }

    fn spoiled(lines: &[String], at: usize, spoil: impl FnOnce(&mut Vec<String>)) -> String {
        let mut lines = lines.to_vec();
        let mut words: Vec<String> = lines[at].split_whitespace().map(str::to_owned).collect();
        spoil(&mut words);
        lines[at] = words.join(" ");
        lines.join("\n")
    }

    /// A word that is not a number, or a missing number, is reported at its line with the matrix and station, wherever it is.
    #[test]
    fn every_number_is_reported_at_its_line() {
        let (lines, numbers) = blade();
        assert!(read_blade(&lines.join("\n")).is_ok());
        for (count, &at) in numbers.iter().enumerate() {
            let (station, row) = (count / 13 + 1, count % 13);
            let due = match row {
                0 => format!("station {station} of {STATIONS}"),
                1..=6 => format!("the stiffness of station {station}"),
                _ => format!("the inertia of station {station}"),
            };
            for column in 0..if row == 0 { 1 } else { 6 } {
                let wrong = |text: &str, reason: String| {
                    let expected = Err(fault(at + 1, reason));
                    assert_eq!(read_blade(text), expected);
                };
                let text = spoiled(&lines, at, |words| words[column] = "1e9999".to_owned());
                wrong(&text, format!("\"1e9999\" in {due}; a finite number is needed"));
                if row > 0 {
                    let text = spoiled(&lines, at, |words| words.truncate(column));
                    let expected = match column {
                        // an empty line counts as a gap: the next line is read in its place, so that the last line is missing
                        0 => continue,
                        _ => format!("{column} numbers where {due} has 6"),
                    };
                    wrong(&text, expected);
                }
            }
        }
    }

    /// A matrix that is not symmetric, or is impossible for a section, is reported at its first line, with the row and column of the entry,
    /// for every entry.
    #[test]
    fn every_matrix_is_reported_where_it_begins() {
        let (lines, numbers) = blade();
        for station in 0..STATIONS {
            for (first, what) in [(1, "the stiffness"), (7, "the inertia")] {
                let begin = 13 * station + first;
                for (row, column) in (0..6).flat_map(|row| (0..6).map(move |column| (row, column))) {
                    if row != column {
                        let text = spoiled(&lines, numbers[begin + row], |words| words[column] = "1e7".to_owned());
                        let refused = read_blade(&text).expect_err("not symmetric");
                        let (lower, upper) = (row.max(column) + 1, row.min(column) + 1);
                        assert_eq!(refused.line, numbers[begin] + 1, "{refused}");
                        assert!(refused.reason.starts_with(&format!("{what} is not symmetric")), "{refused}");
                        assert!(refused.reason.contains(&format!("in row {lower}, column {upper}")), "{refused}");
                    }
                }
                // an inertia of five times the largest entry is impossible for a thin slice; for the stiffness, a negative entry is used
                for row in 0..6 {
                    let bad = if first == 1 { "-1" } else { "500" };
                    let text = spoiled(&lines, numbers[begin + row], |words| words[row] = bad.to_owned());
                    match (read_blade(&text), first, row) {
                        (Err(refused), ..) => assert_eq!(refused.line, numbers[begin] + 1, "{refused}"),
                        // the other four stiffness entries are part of the condensed section stiffness, which the model file checks;
                        // moments of inertia are arbitrary as long as the polar one is their sum
                        (Ok(_), 1, 2..) => {}
                        (Ok(table), ..) => panic!("{what}, row {row}: {table:?}"),
                    }
                }
            }
        }
    }

    /// Positions that do not ascend are reported at their line, those of key points too.
    #[test]
    fn places_are_reported_at_their_line() {
        let (lines, numbers) = blade();
        for station in 1..STATIONS {
            let at = numbers[13 * station];
            let text = spoiled(&lines, at, |words| words[0] = "-1".to_owned());
            let refused = read_blade(&text).expect_err("descending");
            assert!(
                refused.line == at + 1 && refused.reason.starts_with(&format!("station {}", station + 1)),
                "{refused}"
            );
        }
        let front = "BEAMDYN\n 1 member_total\n 4 kp_total\n kp_xr kp_yr kp_zr initial_twist\n (m) (m) (m) (deg)";
        let points = ["0 0 0 0", "0 0 1 0", "0 0 2 0", "0 0 3 0"].map(str::to_owned);
        let lines: Vec<String> = front.lines().map(str::to_owned).chain(points).collect();
        assert!(read_key_points(&lines.join("\n")).is_ok());
        for (point, column) in (0..4).flat_map(|point| (0..4).map(move |column| (point, column))) {
            let at = 5 + point;
            for (word, reason) in
                [(Some("x"), "\"x\" in key point"), (None, &*format!("{column} numbers where key point"))]
            {
                if word.is_none() && column == 0 {
                    continue; // an empty line counts as a gap
                }
                let text = spoiled(&lines, at, |words| match word {
                    Some(word) => words[column] = word.to_owned(),
                    None => words.truncate(column),
                });
                let refused = read_key_points(&text).expect_err("no number");
                let due = format!("{reason} {} of 4", point + 1);
                assert!(refused.line == at + 1 && refused.reason.starts_with(&due), "{refused}");
            }
            if point > 0 && column == 2 {
                let text = spoiled(&lines, at, |words| words[column] = (point - 1).to_string());
                let refused = read_key_points(&text).expect_err("coincide");
                let due = format!("key points {point} and {} coincide", point + 1);
                assert!(refused.line == at + 1 && refused.reason == due, "{refused}");
            }
        }
    }
}
