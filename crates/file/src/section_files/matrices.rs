//! 6×6 matrices of a section in the axes and units of a program, converted to the columns of `[section.<name>.along]`.

use crate::station_table::{StationFault, StationTable, fault};
use foldwing_engine::math::strain::{EDGE, FLAP, STRAINS, STRETCH, StrainMatrix, TWIST};
use nalgebra::{Matrix2, Matrix6, SMatrix};
use schemars::JsonSchema;
use serde::Deserialize;

/// Asymmetry that is attributed to rounding, relative to the geometric mean of the diagonal entries.
const ROUNDING: f64 = 1e-6;

/// Number of shear strains of a 6×6 stiffness, which are eliminated by its condensation.
const SHEARS: usize = 2;

/// Axes of a program: for `x` along the beam, `y` chordwise towards the leading edge and `z` through the thickness, the index of the
/// program's axis and its sign. All are proper rotations, so that forces, moments, strains and curvatures transform alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axes([(usize, f64); 3]);

/// VABS: `x1` along the beam.
pub(super) const X_ALONG: Axes = Axes([(0, 1.0), (1, 1.0), (2, 1.0)]);
/// BECAS and ANBA4: `z` along the beam, `x` chordwise towards the leading edge.
pub(super) const Z_ALONG: Axes = Axes([(2, 1.0), (0, 1.0), (1, 1.0)]);
/// BeamDyn and windIO: `z` along the blade, `y` towards the trailing edge.
pub(super) const BLADE: Axes = Axes([(2, 1.0), (1, -1.0), (0, 1.0)]);

impl Axes {
    /// Index and sign of the program's component that corresponds to a component `(force; moment)` in our axes.
    fn component(&self, here: usize) -> (usize, f64) {
        let (axis, sign) = self.0[here % 3];
        (3 * (here / 3) + axis, sign)
    }

    /// Transforms a matrix of `(force; moment)` to our axes.
    fn turned(&self, theirs: &Matrix6<f64>) -> Matrix6<f64> {
        Matrix6::from_fn(|row, column| {
            let ((row, one), (column, other)) = (self.component(row), self.component(column));
            0.0 + one * other * theirs[(row, column)]
        })
    }

    /// Transforms a matrix in our axes to those of the program.
    pub(super) fn back(&self, here: &Matrix6<f64>) -> Matrix6<f64> {
        let mut theirs = Matrix6::zeros();
        for (row, column) in (0..6).flat_map(|row| (0..6).map(move |column| (row, column))) {
            let ((their_row, one), (their_column, other)) = (self.component(row), self.component(column));
            theirs[(their_row, their_column)] = one * other * here[(row, column)];
        }
        theirs
    }
}

/// Units of the numbers of a file of 6×6 matrices.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize, JsonSchema)]
pub enum FileUnits {
    /// Metre, newton, kilogram.
    #[default]
    #[serde(rename = "m_N_kg")]
    MNKg,
    /// Millimetre, newton, tonne.
    #[serde(rename = "mm_N_t")]
    MmNT,
    /// Inch, pound-force, pound-force times second squared per inch.
    #[serde(rename = "inch_lbf")]
    InchLbf,
}

impl FileUnits {
    /// Units of length in m and of force in N. The unit of mass is force times s² divided by length.
    fn length_and_force(self) -> (f64, f64) {
        match self {
            Self::MNKg => (1.0, 1.0),
            Self::MmNT => (1e-3, 1.0),
            Self::InchLbf => (0.0254, 4.448_221_615_260_5),
        }
    }

    /// Converts to SI a matrix of `(force; moment)` whose upper left block has units of `factor`.
    fn in_si(self, matrix: &Matrix6<f64>, factor: f64) -> Matrix6<f64> {
        let (length_m, _) = self.length_and_force();
        let arm = |index: usize| if index < 3 { 1.0 } else { length_m };
        Matrix6::from_fn(|row, column| matrix[(row, column)] * (factor * arm(row) * arm(column)))
    }
}

/// Stiffness as written by a program, which maps `(strain; curvature)` to `(force; moment)` in its axes.
pub(crate) enum Stiffness {
    /// With shear stiffness.
    Whole(Matrix6<f64>),
    /// Without shear stiffness: the rows and columns of both shear strains are zero.
    Classical(Matrix6<f64>),
}

/// Section in a file.
pub(crate) struct Station {
    /// Position as a fraction of the length; `None` in files of a single section.
    pub share: Option<f64>,
    /// Line numbers of the stiffness and of the inertia.
    pub lines: [usize; 2],
    /// Stiffness.
    pub stiffness: Stiffness,
    /// Inertia per length, which maps `(acceleration; angular acceleration)` to `(force; moment)`.
    pub inertia: Matrix6<f64>,
}

/// Columns after the position; those of shear are last.
const COLUMNS: [&str; 27] = [
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
/// Number of columns of a section without shear stiffness.
const CLASSICAL: usize = 16;

/// Position and columns of a station; the columns of shear are `None` without shear stiffness.
pub(super) type Row = (f64, ([f64; CLASSICAL], Option<[f64; COLUMNS.len() - CLASSICAL]>));

/// Table of the columns, preceded by the position. Columns of shear are included if all sections have them.
pub(super) fn table(place: &str, rows: &[Row]) -> StationTable {
    let sheared = rows.iter().all(|(_, (_, shears))| shears.is_some());
    let count = if sheared { COLUMNS.len() } else { CLASSICAL };
    let names: Vec<String> =
        std::iter::once(place).chain(COLUMNS[..count].iter().copied()).map(str::to_owned).collect();
    let mut columns: Vec<Vec<f64>> = vec![Vec::with_capacity(rows.len()); names.len()];
    for (place, (classical, shears)) in rows {
        let shears = shears.iter().flatten().filter(|_| sheared);
        let values = std::iter::once(place).chain(classical).chain(shears);
        columns.iter_mut().zip(values).for_each(|(column, value)| column.push(*value));
    }
    StationTable { names, columns }
}

/// Indices in a `(force; moment)` matrix of the strains of an element without shear.
pub(super) const KEPT: [usize; STRAINS] = {
    let mut kept = [0; STRAINS];
    (kept[STRETCH], kept[TWIST], kept[FLAP], kept[EDGE]) = (0, 3, 4, 5);
    kept
};
/// Indices of the shear strains, `z` first: the order of BeamDyn, with which results agree to the last digit.
const SHEARED_FIRST: [usize; SHEARS] = [2, 1];

/// Condenses a 6×6 stiffness in our axes to `(εx, κx, κy, κz)` with zero shear forces, NOTATION eq. (S9); `None` if its shear stiffness
/// is not positive definite.
fn condensed(whole: &Matrix6<f64>) -> Option<StrainMatrix> {
    let shear = Matrix2::from_fn(|row, column| whole[(SHEARED_FIRST[row], SHEARED_FIRST[column])]);
    let mixed = SMatrix::<f64, SHEARS, STRAINS>::from_fn(|row, column| whole[(SHEARED_FIRST[row], KEPT[column])]);
    let inverse = shear.cholesky()?.inverse();
    Some(kept(whole) - mixed.transpose() * inverse * mixed)
}

/// Extracts the rows and columns of `(εx, κx, κy, κz)`.
fn kept(whole: &Matrix6<f64>) -> StrainMatrix {
    StrainMatrix::from_fn(|row, column| whole[(KEPT[row], KEPT[column])])
}

/// Condenses a 6×6 stiffness of `(γx, γy, εz, κx, κy, κz)` in BeamDyn's axes to `(εx, κx, κy, κz)`: the shear strains are those with zero
/// shear forces, NOTATION eq. (S9). `None` if the shear stiffness is not positive definite.
pub fn condensed_stiffness(full: &Matrix6<f64>) -> Option<StrainMatrix> {
    condensed(&BLADE.turned(full))
}

pub(super) fn row(axes: &Axes, station: &Station, units: FileUnits) -> Result<Row, StationFault> {
    let (length_m, force_n) = units.length_and_force();
    let [line, inertia_line] = station.lines;
    let (whole, sheared) = match &station.stiffness {
        Stiffness::Whole(matrix) => (matrix, true),
        Stiffness::Classical(matrix) => (matrix, false),
    };
    symmetric(line, "the stiffness", whole)?;
    let whole = axes.turned(&units.in_si(whole, force_n));
    let bending = if sheared { condensed(&whole) } else { Some(kept(&whole)) };
    let bending = bending.ok_or_else(|| fault(line, "the stiffness of shear is not positive definite"))?;
    symmetric(inertia_line, "the inertia", &station.inertia)?;
    // unit of mass per length: force times s² divided by length²
    let inertia = units.in_si(&station.inertia, force_n / (length_m * length_m));
    let [mass, y, z, yy, yz, zz] = lamina(inertia_line, axes, &inertia)?;
    let k = |row: usize, column: usize| 0.0 + bending[(row, column)];
    let classical = [
        k(0, 0),
        k(1, 1),
        k(2, 2),
        k(3, 3),
        k(0, 1),
        k(0, 2),
        k(0, 3),
        k(1, 2),
        k(1, 3),
        k(2, 3),
        mass,
        y,
        z,
        yy,
        yz,
        zz,
    ];
    let c = |row: usize, column: usize| whole[(row, column)];
    let shears = [c(1, 1), c(2, 2), c(1, 2), c(1, 0), c(1, 3), c(1, 4), c(1, 5), c(2, 0), c(2, 3), c(2, 4), c(2, 5)];
    Ok((station.share.unwrap_or_default(), (classical, sheared.then_some(shears))))
}

/// Checks that a matrix is symmetric.
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

/// Inertia matrix of a thin slice in our axes, from mass, centre and moments about the axis `[m, y, z, yy, yz, zz]`.
pub(super) fn slice_inertia([mass, y, z, yy, yz, zz]: [f64; 6]) -> Matrix6<f64> {
    let mut inertia = Matrix6::zeros();
    for (row, column, value) in [
        (0, 0, mass),
        (1, 1, mass),
        (2, 2, mass),
        (0, 4, mass * z),
        (0, 5, -mass * y),
        (1, 3, -mass * z),
        (2, 3, mass * y),
        (3, 3, yy + zz),
        (4, 4, zz),
        (4, 5, -yz),
        (5, 5, yy),
    ] {
        inertia[(row, column)] = value;
        inertia[(column, row)] = value;
    }
    inertia
}

/// Mass per length, centre and central moments `[m, y, z, yy, yz, zz]` in our axes, from a 6×6 inertia in SI and in the axes of a
/// program, which must be that of a thin slice.
fn lamina(line: usize, axes: &Axes, theirs: &Matrix6<f64>) -> Result<[f64; 6], StationFault> {
    let inertia = axes.turned(theirs);
    let mass = inertia[(0, 0)];
    let refuse =
        |reason: String| Err(fault(line, format!("the matrix is not the inertia matrix of a section: {reason}")));
    if mass <= 0.0 {
        return refuse(format!("a mass of {mass}; it must be > 0"));
    }
    let (y, z) = (inertia[(2, 3)] / mass, -inertia[(1, 3)] / mass);
    let moments = [inertia[(5, 5)], -inertia[(4, 5)], inertia[(4, 4)]];
    let expected = axes.back(&slice_inertia([mass, y, z, moments[0], moments[1], moments[2]]));
    let along = axes.component(3).0;
    for (row, column) in (0..6).flat_map(|row| (0..=row).map(move |column| (row, column))) {
        let (found, due) = (theirs[(row, column)], expected[(row, column)]);
        let scale = (theirs[(row, row)] * theirs[(column, column)]).abs().sqrt();
        // the polar moment is often rounded separately
        let allowed = if (row, column) == (along, along) { 1e-2 } else { 1e-3 };
        if (found - due).abs() > allowed * scale {
            return refuse(format!("{found} in row {}, column {}, where a thin slice has {due}", row + 1, column + 1));
        }
    }
    Ok([mass, y + 0.0, z + 0.0, moments[0] - mass * y * y, moments[1] - mass * y * z, moments[2] - mass * z * z])
}
