//! BeamDyn's files: sections of a blade by 6×6 matrices, its axis by key points.
//!
//! BeamDyn's axes are `x` downwind, `y` towards the trailing edge, `z` along the blade; here `x` runs along the blade, `y` towards
//! the leading edge, `z` downwind: `(x, y, z) = (z, −y, x)` of BeamDyn's. BeamDyn's twist turns against its `z`.

use crate::station_file::{StationFault, StationTable, fault};
use crate::stations::MAXIMUM_STATIONS;
use foldwing_engine::math::quadrature::gauss_pieces;
use foldwing_engine::math::spline::CubicSpline;
use foldwing_engine::math::strain::{STRAINS, StrainMatrix};
use nalgebra::{Matrix2, Matrix6, SMatrix};

/// Asymmetry and stray entries that are treated as rounding, relative to the geometric mean of the diagonal.
const ROUNDING: f64 = 1e-6;

/// Whether a text is a file of BeamDyn, by its first line. Lines that start with `#` are comments of a CSV file.
pub(super) fn is_beamdyn(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.next().is_some_and(|line| line.to_ascii_uppercase().contains("BEAMDYN"))
}

/// Shear strains of a 6×6 stiffness: those that its condensation removes.
const SHEARS: usize = 2;

/// Stiffness of `(εx, κx, κy, κz)` from a 6×6 one of `(γx, γy, εz, κx, κy, κz)` in BeamDyn's axes without shear forces: the shear
/// strains are those of zero shear forces, NOTATION eq. (S9). `None` if the stiffness of shear is not positive definite.
pub fn condensed_stiffness(full: &Matrix6<f64>) -> Option<StrainMatrix> {
    let shear: Matrix2<f64> = full.fixed_view::<SHEARS, SHEARS>(0, 0).into_owned();
    let mixed: SMatrix<f64, SHEARS, STRAINS> = full.fixed_view::<SHEARS, STRAINS>(0, SHEARS).into_owned();
    let inverse = shear.cholesky()?.inverse();
    let kept = full.fixed_view::<STRAINS, STRAINS>(SHEARS, SHEARS) - mixed.transpose() * inverse * mixed;
    // (εz, κx, κy, κz) of BeamDyn to (εx, κx, κy, κz)
    let turn =
        StrainMatrix::<STRAINS>::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0);
    Some(turn * kept * turn.transpose())
}

/// Lines of a file, read from the front.
struct Lines<'t> {
    lines: std::iter::Enumerate<std::str::Lines<'t>>,
    last: usize,
}

impl<'t> Lines<'t> {
    fn of(text: &'t str) -> Self {
        Self { lines: text.lines().enumerate(), last: text.lines().count() }
    }

    /// The next line that is not empty.
    fn next(&mut self, due: &str) -> Result<(usize, &'t str), StationFault> {
        let next = self.lines.find(|(_, line)| !line.trim().is_empty());
        let (index, line) =
            next.ok_or_else(|| fault(self.last + 1, format!("cut short: the file ends before {due}")))?;
        Ok((index + 1, line))
    }

    /// The value before a label.
    fn labelled(&mut self, label: &str) -> Result<(usize, usize), StationFault> {
        loop {
            let (line, text) = self.next(label)?;
            let mut words = text.split_whitespace();
            let (value, name) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
            if name.eq_ignore_ascii_case(label) {
                let count: Option<usize> = value.parse().ok();
                let count = count.filter(|count| (1..=MAXIMUM_STATIONS).contains(count));
                let reason = format!("{label} is {value:?}; a whole number from 1 to {MAXIMUM_STATIONS} is needed");
                return count.map(|count| (line, count)).ok_or_else(|| fault(line, reason));
            }
        }
    }

    /// So many numbers at the front of the next line.
    fn numbers<const N: usize>(&mut self, due: &str) -> Result<(usize, [f64; N]), StationFault> {
        let (line, text) = self.next(due)?;
        let mut words = text.split_whitespace();
        let mut values = [0.0; N];
        for (place, value) in values.iter_mut().enumerate() {
            let word = words.next().ok_or_else(|| fault(line, format!("{place} numbers where {due} has {N}")))?;
            *value = number(line, due, word)?;
        }
        Ok((line, values))
    }

    fn matrix(&mut self, due: &str) -> Result<(usize, Matrix6<f64>), StationFault> {
        let (mut matrix, mut first) = (Matrix6::zeros(), 0);
        for row in 0..6 {
            let (line, values) = self.numbers::<6>(due)?;
            matrix.set_row(row, &values.into());
            first = if row == 0 { line } else { first };
        }
        Ok((first, matrix))
    }
}

fn number(line: usize, due: &str, word: &str) -> Result<f64, StationFault> {
    let value: Option<f64> = word.replace(['d', 'D'], "e").parse().ok();
    let finite = value.filter(|value| value.is_finite());
    finite.ok_or_else(|| fault(line, format!("{word:?} in {due}; a finite number is needed")))
}

/// Sections of a blade from BeamDyn's file of one, as columns of `[section.<name>.along]`.
///
/// # Errors
/// A truncated file, invalid numbers, stations that do not ascend from 0 to 1, matrices that are not symmetric, or not those of a section.
pub(super) fn read_blade(text: &str) -> Result<StationTable, StationFault> {
    let (mut lines, count) = to_stations(text)?;
    let names = [
        "eta",
        "axial_stiffness_N",
        "torsional_rigidity_N_m2",
        "flap_stiffness_N_m2",
        "edge_stiffness_N_m2",
        "coupling_axial_twist_N_m",
        "coupling_axial_flap_N_m",
        "coupling_axial_edge_N_m",
        "coupling_twist_flap_N_m2",
        "coupling_twist_edge_N_m2",
        "coupling_flap_edge_N_m2",
        "mass_kg_m",
        "centre_of_mass_y_m",
        "centre_of_mass_z_m",
        "second_moment_yy_kg_m",
        "second_moment_yz_kg_m",
        "second_moment_zz_kg_m",
        "shear_stiffness_y_N",
        "shear_stiffness_z_N",
        "coupling_shear_y_shear_z_N",
        "coupling_shear_y_axial_N",
        "coupling_shear_y_twist_N_m",
        "coupling_shear_y_flap_N_m",
        "coupling_shear_y_edge_N_m",
        "coupling_shear_z_axial_N",
        "coupling_shear_z_twist_N_m",
        "coupling_shear_z_flap_N_m",
        "coupling_shear_z_edge_N_m",
    ];
    let mut columns: Vec<Vec<f64>> = vec![Vec::with_capacity(count); names.len()];
    for station in 1..=count {
        let (line, [share]) = lines.numbers(&format!("station {station} of {count}"))?;
        if let Some(last) = columns[0].last().filter(|last| **last >= share) {
            return Err(fault(
                line,
                format!("station {station} at {share} after {last}; stations must ascend from 0 to 1"),
            ));
        }
        let (line, stiffness) = lines.matrix(&format!("the stiffness of station {station}"))?;
        symmetric(line, "the stiffness", &stiffness)?;
        let condensed = condensed_stiffness(&stiffness).ok_or_else(|| {
            fault(line, format!("station {station}: the stiffness of shear is not positive definite"))
        })?;
        let (line, inertia) = lines.matrix(&format!("the inertia of station {station}"))?;
        symmetric(line, "the inertia", &inertia)?;
        let [mass, y, z, yy, yz, zz] = lamina(line, &inertia)?;
        let k = |row, column| condensed[(row, column)];
        let couplings = [k(0, 1), k(0, 2), k(0, 3), k(1, 2), k(1, 3), k(2, 3)];
        let values = [share, k(0, 0), k(1, 1), k(2, 2), k(3, 3)].into_iter().chain(couplings);
        let values = values.chain([mass, y, z, yy, yz, zz]).chain(shears(&stiffness));
        columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
    }
    Ok(StationTable { names: names.map(str::to_owned).to_vec(), columns })
}

/// Stiffness of the shears and their couplings, in the axes and the order of the columns: `y` here is BeamDyn's `−y`, `z` its `x`.
fn shears(full: &Matrix6<f64>) -> [f64; 11] {
    // (εz, κz, −κy, κx) of BeamDyn are (εx, κx, κy, κz)
    let others = [(2, 1.0), (5, 1.0), (4, -1.0), (3, 1.0)];
    let [y, z] =
        [(1, -1.0), (0, 1.0)].map(|(row, sign)| others.map(|(column, turn)| sign * turn * full[(row, column)]));
    let own = [full[(1, 1)], full[(0, 0)], -full[(0, 1)]];
    let mut columns = [0.0; 11];
    columns.iter_mut().zip(own.into_iter().chain(y).chain(z)).for_each(|(column, value)| *column = 0.0 + value);
    columns
}

/// Lines of a blade's file from its first station on, and the number of stations.
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

/// Deflection by shear over that by bending of a blade of this length, clamped and with a force at its tip, across `y` and `z` of a
/// section: `∫ ds/GA` over `∫ s²/EI ds` with `s` from the tip, which is `3 EI/(GA L²)` for a constant section. The beams of this program
/// have no shear, and the condensed stiffness does not contain the neglected part.
///
/// # Errors
/// As [`read_blade`], for the values read here.
pub(super) fn shear_shares(text: &str, length_m: f64) -> Result<[f64; 2], StationFault> {
    let (mut lines, count) = to_stations(text)?;
    let mut stations = Vec::with_capacity(count);
    for station in 1..=count {
        let due = format!("station {station} of {count}");
        let (_, [share]) = lines.numbers(&due)?;
        let (line, full) = lines.matrix(&due)?;
        let bending = condensed_stiffness(&full).ok_or_else(|| {
            fault(line, format!("station {station}: the stiffness of shear is not positive definite"))
        })?;
        lines.matrix(&due)?;
        // BeamDyn's x is z here, its y is -y here
        let shear_n = [full[(1, 1)], full[(0, 0)]];
        stations.push(((1.0 - share) * length_m, [0, 1].map(|axis| (shear_n[axis], bending[(3 - axis, 3 - axis)]))));
    }
    Ok(shear_over_bending(&stations))
}

/// Deflection by shear over that by bending of a cantilever under a force along `y` and `z` at its tip. Stations: distance from the tip in m,
/// and for either direction the shear stiffness in N and the bending stiffness in N·m².
pub(super) fn shear_over_bending(stations: &[(f64, [(f64, f64); 2])]) -> [f64; 2] {
    [0, 1].map(|axis| {
        let mut sums = [0.0; 2];
        for pair in stations.windows(2) {
            // ∫ s² ds between two stations, half of it with the flexibility of each
            let half = [0.5 * (pair[0].0 - pair[1].0), (pair[0].0.powi(3) - pair[1].0.powi(3)) / 6.0];
            for (_, sections) in pair {
                let (shear_n, bending_n_m2): (f64, f64) = sections[axis];
                sums[0] += half[0] / shear_n;
                sums[1] += half[1] / bending_n_m2;
            }
        }
        sums[0] / sums[1]
    })
}

/// Returns an error for a matrix that is not symmetric.
fn symmetric(line: usize, what: &str, matrix: &Matrix6<f64>) -> Result<(), StationFault> {
    for (row, column) in (0..6).flat_map(|row| (0..row).map(move |column| (row, column))) {
        let (lower, upper) = (matrix[(row, column)], matrix[(column, row)]);
        let scale = (matrix[(row, row)] * matrix[(column, column)]).abs().sqrt();
        if (lower - upper).abs() > ROUNDING * scale {
            let place = format!("{lower} in row {}, column {} and {upper} in its mirror image", row + 1, column + 1);
            return Err(fault(line, format!("{what} is not symmetric: {place}")));
        }
    }
    Ok(())
}

/// Mass per length, centre and central moments `[m, y, z, yy, yz, zz]` in the axes used here of a 6×6 inertia, which must be that
/// of a thin slice.
fn lamina(line: usize, inertia: &Matrix6<f64>) -> Result<[f64; 6], StationFault> {
    let mass = inertia[(0, 0)];
    let refuse = |reason: String| Err(fault(line, format!("the inertia is not that of a section: {reason}")));
    if mass <= 0.0 {
        return refuse(format!("a mass of {mass}; it must be > 0"));
    }
    let (x_cm, y_cm) = (inertia[(1, 5)] / mass, -inertia[(0, 5)] / mass);
    let mut expected = Matrix6::zeros();
    for (row, column, value) in [
        (0, 0, mass),
        (1, 1, mass),
        (2, 2, mass),
        (0, 5, -mass * y_cm),
        (1, 5, mass * x_cm),
        (2, 3, mass * y_cm),
        (2, 4, -mass * x_cm),
        (3, 3, inertia[(3, 3)]),
        (3, 4, inertia[(3, 4)]),
        (4, 4, inertia[(4, 4)]),
        (5, 5, inertia[(3, 3)] + inertia[(4, 4)]),
    ] {
        expected[(row, column)] = value;
        expected[(column, row)] = value;
    }
    for (row, column) in (0..6).flat_map(|row| (0..=row).map(move |column| (row, column))) {
        let (found, due) = (inertia[(row, column)], expected[(row, column)]);
        let scale = (inertia[(row, row)] * inertia[(column, column)]).abs().sqrt();
        // polar moments are often rounded by themselves
        let allowed = if (row, column) == (5, 5) { 1e-2 } else { 1e-3 };
        if (found - due).abs() > allowed * scale {
            return refuse(format!("{found} in row {}, column {}, where a thin slice has {due}", row + 1, column + 1));
        }
    }
    let (y, z) = (-y_cm, x_cm);
    let central = [inertia[(3, 3)] - mass * y * y, inertia[(3, 4)] - mass * y * z, inertia[(4, 4)] - mass * z * z];
    Ok([mass, y, z, central[0], central[1], central[2]])
}

/// Axis of a blade from BeamDyn's primary file, as columns of `[body.<name>.axis]`: arc lengths of the key points along natural
/// cubic splines over the chords between them, and the points with their twist.
///
/// # Errors
/// A file cut short, values that are no numbers, several members, points that coincide, a first point that is not the origin.
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
    lines.next("its key points")?; // units
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
        s_m = z; // to the last digit
    }
    let negative = |values: &[f64]| values.iter().map(|value| 0.0 - value).collect::<Vec<f64>>();
    let names = ["s_m", "y_m", "z_m", "twist_deg"].map(str::to_owned).to_vec();
    Ok(StationTable { names, columns: vec![s_m, negative(&y), x, negative(&twist)] })
}

#[cfg(test)]
mod tests {
    use super::*;

    const STATIONS: usize = 3;

    /// Lines of a blade of uniform sections, and the indices of the lines of numbers: of each station its place, then six rows of
    /// stiffness and six of inertia, a gap after each as the format has it.
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

    /// A word that is no number, and a number that is missing, are reported at their own line with the matrix and station, whichever
    /// line and column it is.
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
                        // an empty line is a gap: the next is read for it, and it is the last that is missing
                        0 => continue,
                        _ => format!("{column} numbers where {due} has 6"),
                    };
                    wrong(&text, expected);
                }
            }
        }
    }

    /// A matrix that is not symmetric, or not that of a section, is reported at its first line, with the row and column of the entry, for
    /// every entry.
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
                // five times the largest entry: impossible for a thin slice; a negative one for the shear stiffness
                for row in 0..6 {
                    let bad = if first == 1 { "-1" } else { "500" };
                    let text = spoiled(&lines, numbers[begin + row], |words| words[row] = bad.to_owned());
                    match (read_blade(&text), first, row) {
                        (Err(refused), ..) => assert_eq!(refused.line, numbers[begin] + 1, "{refused}"),
                        // the four of the condensed stiffness are those of the section, which the model file checks; moments of inertia are
                        // arbitrary as long as the polar one is their sum
                        (Ok(_), 1, 2..) => {}
                        (Ok(table), ..) => panic!("{what}, row {row}: {table:?}"),
                    }
                }
            }
        }
    }

    /// Places that do not ascend are reported at their line, key points at theirs.
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
                    continue; // an empty line is a gap
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
