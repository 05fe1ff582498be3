//! Linear models as a MAT-file, level 5, uncompressed, for MATLAB, Octave, Julia and SciPy.
//!
//! Format: The MathWorks, "MAT-File Format", chapter "Level 5 MAT-files". Written without a crate, which would store the time of day in the
//! header; here equal models give equal bytes.

use crate::report::linear::{growing, point_texts};
use crate::report::number;
use foldwing_fmi::interface::{LinearModel, LinearSignal, OperatingPoint};
use nalgebra::DMatrix;
use std::io::{self, Write};

/// Data types of elements.
const INT8: u32 = 1;
const UINT16: u32 = 4;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const DOUBLE: u32 = 9;
const MATRIX: u32 = 14;

/// Array classes.
const CELL_CLASS: u32 = 1;
const CHAR_CLASS: u32 = 4;
const DOUBLE_CLASS: u32 = 6;

/// Writes a linear model for `load`: `A`, `B`, `C`, `D`, the columns `x0`, `u0`, `y0`, the scalar `time_s`, in discrete time the step
/// `step_s`, the other data of the operating point as in [`crate::report::write_npz`], the scalar `without_air` (1 or 0), and the names and
/// units `state_names`, `state_units`, … as cell columns, as required by `ss`.
pub fn write_mat<W: Write>(model: &LinearModel, mut target: W) -> io::Result<()> {
    let mut header = format!("{:<124}", "MATLAB 5.0 MAT-file, a linear model written by foldwing").into_bytes();
    header.extend([0x00, 0x01, b'I', b'M']); // version, and byte order mark
    target.write_all(&header)?;
    let matrices = &model.matrices;
    for (name, matrix) in [("A", &matrices.a), ("B", &matrices.b), ("C", &matrices.c), ("D", &matrices.d)] {
        target.write_all(&numbers(name, matrix))?;
    }
    write_point(&model.point, &mut target)?;
    if let Some(step_s) = model.step_s {
        target.write_all(&numbers("step_s", &DMatrix::from_element(1, 1, step_s)))?;
    }
    target.write_all(&numbers("without_air", &DMatrix::from_element(1, 1, f64::from(u8::from(model.without_air)))))?;
    for (what, short, signals) in
        [("state", "x0", &model.states), ("input", "u0", &model.inputs), ("output", "y0", &model.outputs)]
    {
        let values = DMatrix::from_iterator(signals.len(), 1, signals.iter().map(|signal| signal.value));
        target.write_all(&numbers(short, &values))?;
        let column = |text: fn(&LinearSignal) -> &str| signals.iter().map(text).collect::<Vec<_>>();
        target.write_all(&cells(&format!("{what}_names"), &column(|signal| &signal.name)))?;
        target.write_all(&cells(&format!("{what}_units"), &column(|signal| &signal.unit)))?;
    }
    Ok(())
}

/// Writes the operating point: `time_s`, `equilibrium`, joints and acting inputs, as columns.
fn write_point<W: Write>(point: &OperatingPoint, target: &mut W) -> io::Result<()> {
    target.write_all(&numbers("time_s", &DMatrix::from_element(1, 1, point.time_s)))?;
    let equilibrium = f64::from(u8::from(point.equilibrium));
    target.write_all(&numbers("equilibrium", &DMatrix::from_element(1, 1, equilibrium)))?;
    let growing = growing(point);
    let rows = growing.iter().flatten().copied();
    target.write_all(&numbers("growing_1_s", &DMatrix::from_row_iterator(growing.len(), 2, rows)))?;
    let angles = point.joints.iter().map(|joint| joint.angle_rad);
    target.write_all(&numbers("joint_angles_rad", &DMatrix::from_iterator(point.joints.len(), 1, angles)))?;
    let values = point.acting.iter().map(|acting| number(&acting.value));
    target.write_all(&numbers("acting_values", &DMatrix::from_iterator(point.acting.len(), 1, values)))?;
    for (name, list) in point_texts(point) {
        target.write_all(&cells(name, &list))?;
    }
    Ok(())
}

/// Data element: tag, data, and zeros up to a multiple of eight bytes.
fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = kind.to_le_bytes().to_vec();
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

/// Array of a class: flags, dimensions, name, content.
fn array(class: u32, size: [usize; 2], name: &str, content: &[u8]) -> Vec<u8> {
    let flags: Vec<u8> = [class, 0].iter().flat_map(|word| word.to_le_bytes()).collect();
    let size: Vec<u8> = size.iter().flat_map(|length| (*length as i32).to_le_bytes()).collect();
    let parts = [element(UINT32, &flags), element(INT32, &size), element(INT8, name.as_bytes()), content.to_vec()];
    element(MATRIX, &parts.concat())
}

/// Matrix, stored column by column.
fn numbers(name: &str, matrix: &DMatrix<f64>) -> Vec<u8> {
    let data: Vec<u8> = matrix.iter().flat_map(|value| value.to_le_bytes()).collect();
    array(DOUBLE_CLASS, [matrix.nrows(), matrix.ncols()], name, &element(DOUBLE, &data))
}

/// Column of cells with one text each.
fn cells(name: &str, texts: &[&str]) -> Vec<u8> {
    let content: Vec<u8> = texts
        .iter()
        .flat_map(|text| {
            let letters: Vec<u16> = text.encode_utf16().collect();
            let data: Vec<u8> = letters.iter().flat_map(|letter| letter.to_le_bytes()).collect();
            array(CHAR_CLASS, [usize::from(!letters.is_empty()), letters.len()], "", &element(UINT16, &data))
        })
        .collect();
    array(CELL_CLASS, [texts.len(), 1], name, &content)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An array has the layout of the format, byte by byte, for a 1×2 matrix; `tests/fmi` reads complete files with SciPy.
    #[test]
    fn arrays_have_the_layout_of_the_format() {
        let bytes = numbers("D", &DMatrix::from_row_slice(1, 2, &[1.0, -2.0]));
        let words: Vec<u32> = bytes[..48].chunks(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect();
        // 72 = 16 (flags) + 16 (dimensions) + 16 (name) + 8 (tag) + two numbers
        assert_eq!(words, [14, 72, 6, 8, 6, 0, 5, 8, 1, 2, 1, 1]);
        assert_eq!(bytes[48..56], *b"D\0\0\0\0\0\0\0");
        assert_eq!(bytes[56..64], [[9, 0, 0, 0], [16, 0, 0, 0]].concat());
        assert_eq!(bytes[64..], [1.0f64.to_le_bytes(), (-2.0f64).to_le_bytes()].concat());
    }
}
