//! Linear models as files: JSON, and NumPy's `.npz`.

use crate::report::number;
use foldwing_fmi::interface::{self, Acting, JointPoint, LinearModel, LinearSignal, OperatingPoint};
use nalgebra::DMatrix;
use serde_json::{Value, json};
use std::io::{self, Seek, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Linear model as JSON: `time_s`, `without_air` (aerodynamic loads are held constant), `state` (whether it is an equilibrium, joints,
/// acting inputs, `growing_1_s`), `states`, `inputs`, `outputs` (name, unit, value at the operating point) and the matrices `A`, `B`, `C`,
/// `D` row by row. A reduced model has `reduction` (`method`, `states_before`, `error_bound`; for a frequency band `up_to_Hz`,
/// `error_in_band`; for all frequencies, except in discrete time, `accuracy`: `measured_to_Hz`, the `error` up to this frequency relative
/// to the largest gain, with a row for each output, its `largest_error` with its frequency `at_Hz`, and `dropped_modes`). A discrete-time
/// model has its step, `step_s`.
pub fn linear_json(model: &LinearModel) -> Value {
    let signals = |list: &[LinearSignal]| -> Vec<Value> {
        let entry = |signal: &LinearSignal| json!({ "name": signal.name, "unit": signal.unit, "value": signal.value });
        list.iter().map(entry).collect()
    };
    let rows = |matrix: &DMatrix<f64>| -> Vec<Vec<f64>> {
        matrix.row_iter().map(|row| row.iter().copied().collect()).collect()
    };
    let matrices = &model.matrices;
    let mut value = json!({
        "written_by": "foldwing linearize",
        "time_s": model.point.time_s,
        "without_air": model.without_air,
        "state": state(&model.point),
        "states": signals(&model.states),
        "inputs": signals(&model.inputs),
        "outputs": signals(&model.outputs),
        "A": rows(&matrices.a),
        "B": rows(&matrices.b),
        "C": rows(&matrices.c),
        "D": rows(&matrices.d),
    });
    if let Some(step_s) = model.step_s {
        value["step_s"] = json!(step_s);
    }
    if let Some(reduction) = &model.reduction {
        value["reduction"] = json!({
            "method": reduction.method(),
            "states_before": reduction.whole,
            "error_bound": reduction.error_bound,
        });
        if let Some(up_to_hz) = reduction.up_to_hz {
            value["reduction"]["up_to_Hz"] = json!(up_to_hz);
        }
        if let Some(accuracy) = &reduction.accuracy {
            if reduction.up_to_hz.is_some() {
                value["reduction"]["error_in_band"] = json!(accuracy.worst().0);
            }
            let dropped = accuracy.dropped.iter().map(|mode| {
                let [re, im] = [mode.eigenvalue_1_s.re, mode.eigenvalue_1_s.im];
                json!({ "eigenvalue_1_s": [re, im], "share": mode.share })
            });
            value["reduction"]["accuracy"] = json!({
                "measured_to_Hz": accuracy.up_to_hz,
                "largest_error": accuracy.worst().0,
                "at_Hz": accuracy.worst_hz,
                "error": rows(&accuracy.error),
                "dropped_modes": dropped.collect::<Vec<_>>(),
            });
        }
    }
    value
}

/// Operating point as JSON.
fn state(point: &OperatingPoint) -> Value {
    let joint = |joint: &JointPoint| {
        let coordinate = joint.travel.words("angle_rad");
        json!({ "name": joint.name, coordinate: joint.angle_rad, "motion": joint.motion, "latch": joint.latch })
    };
    let acting = |acting: &Acting| {
        let value = match acting.value {
            interface::Value::Boolean(value) => json!(value),
            ref value @ (interface::Value::Real(_) | interface::Value::Integer(_)) => json!(number(value)),
        };
        json!({ "name": acting.name, "unit": acting.unit, "value": value })
    };
    let growing: Option<Vec<[f64; 2]>> =
        point.growing_1_s.as_ref().map(|list| list.iter().map(|lambda| [lambda.re, lambda.im]).collect());
    json!({
        "equilibrium": point.equilibrium,
        "growing_1_s": growing,
        "joints": point.joints.iter().map(joint).collect::<Vec<_>>(),
        "acting": point.acting.iter().map(acting).collect::<Vec<_>>(),
    })
}

/// Writes a linear model for `numpy.load`: `A`, `B`, `C`, `D`, `x0`, `u0`, `y0`, `time_s`, in discrete time `step_s`, `without_air` (1 or
/// 0), and the names and units `state_names`, `state_units`, … as text arrays; for the operating point `equilibrium` (0 or 1),
/// `joint_names`, `joint_angles_rad` (in m for prismatic joints), `joint_motions`, `joint_latches`, `acting_names`, `acting_values`,
/// `acting_units`, and `growing_1_s`, with a row of real and imaginary part for each unstable eigenvalue (NaN if not computed). Equal
/// models give equal bytes.
pub fn write_npz<W: Write + Seek>(model: &LinearModel, target: W) -> io::Result<()> {
    let mut archive = ZipWriter::new(target);
    let mut member = |name: &str, bytes: Vec<u8>| -> io::Result<()> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(DateTime::default());
        archive.start_file(format!("{name}.npy"), options)?;
        archive.write_all(&bytes)
    };
    let matrices = &model.matrices;
    for (name, matrix) in [("A", &matrices.a), ("B", &matrices.b), ("C", &matrices.c), ("D", &matrices.d)] {
        let values: Vec<f64> = matrix.row_iter().flat_map(|row| row.iter().copied().collect::<Vec<_>>()).collect();
        member(name, numbers(&values, &format!("({}, {})", matrix.nrows(), matrix.ncols())))?;
    }
    for (what, signals) in [("state", &model.states), ("input", &model.inputs), ("output", &model.outputs)] {
        let short = match what {
            "state" => "x0",
            "input" => "u0",
            _ => "y0",
        };
        let values: Vec<f64> = signals.iter().map(|signal| signal.value).collect();
        member(short, numbers(&values, &format!("({},)", values.len())))?;
        member(&format!("{what}_names"), texts(signals.iter().map(|signal| signal.name.as_str())))?;
        member(&format!("{what}_units"), texts(signals.iter().map(|signal| signal.unit.as_str())))?;
    }
    let point = &model.point;
    member("time_s", numbers(&[point.time_s], "()"))?;
    if let Some(step_s) = model.step_s {
        member("step_s", numbers(&[step_s], "()"))?;
    }
    if let Some(reduction) = &model.reduction {
        member("error_bound", numbers(&[reduction.error_bound.unwrap_or(f64::NAN)], "()"))?;
    }
    member("without_air", numbers(&[f64::from(u8::from(model.without_air))], "()"))?;
    member("equilibrium", numbers(&[f64::from(u8::from(point.equilibrium))], "()"))?;
    let growing = growing(point);
    let values: Vec<f64> = growing.iter().flatten().copied().collect();
    member("growing_1_s", numbers(&values, &format!("({}, 2)", growing.len())))?;
    let angles: Vec<f64> = point.joints.iter().map(|joint| joint.angle_rad).collect();
    member("joint_angles_rad", numbers(&angles, &format!("({},)", angles.len())))?;
    let values: Vec<f64> = point.acting.iter().map(|acting| number(&acting.value)).collect();
    member("acting_values", numbers(&values, &format!("({},)", values.len())))?;
    for (name, list) in point_texts(point) {
        member(name, texts(list.into_iter()))?;
    }
    archive.finish()?;
    Ok(())
}

/// Real and imaginary parts of the unstable eigenvalues in 1/s; a row of NaN if not computed.
pub(super) fn growing(point: &OperatingPoint) -> Vec<[f64; 2]> {
    match &point.growing_1_s {
        Some(list) => list.iter().map(|lambda| [lambda.re, lambda.im]).collect(),
        None => vec![[f64::NAN; 2]],
    }
}

/// Texts of an operating point in array files, with the names of their arrays.
pub(super) fn point_texts(point: &OperatingPoint) -> [(&'static str, Vec<&str>); 5] {
    let joints = |text: fn(&JointPoint) -> &str| point.joints.iter().map(text).collect();
    let acting = |text: fn(&Acting) -> &str| point.acting.iter().map(text).collect();
    [
        ("joint_names", joints(|joint| &joint.name)),
        ("joint_motions", joints(|joint| joint.motion)),
        ("joint_latches", joints(|joint| joint.latch)),
        ("acting_names", acting(|acting| &acting.name)),
        ("acting_units", acting(|acting| &acting.unit)),
    ]
}

/// File in the `.npy` format, version 1.0: magic string, header padded to 64 bytes, data.
fn npy(kind: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    while (header.len() + 11) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut file = b"\x93NUMPY\x01\x00".to_vec();
    file.extend((header.len() as u16).to_le_bytes());
    file.extend(header.as_bytes());
    file.extend(data);
    file
}

fn numbers(values: &[f64], shape: &str) -> Vec<u8> {
    let data: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    npy("<f8", shape, &data)
}

/// Texts with four bytes per character, padded to the length of the longest.
fn texts<'a>(values: impl Iterator<Item = &'a str>) -> Vec<u8> {
    let values: Vec<Vec<char>> = values.map(|value| value.chars().collect()).collect();
    let width = values.iter().map(Vec::len).max().unwrap_or(0).max(1);
    let mut data = Vec::new();
    for value in &values {
        for i in 0..width {
            data.extend(value.get(i).map_or(0, |&letter| letter as u32).to_le_bytes());
        }
    }
    npy(&format!("<U{width}"), &format!("({},)", values.len()), &data)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The file has the magic string, length and padding of the format: the data start at a multiple of 64 bytes.
    #[test]
    fn arrays_have_the_header_of_the_format() {
        let file = numbers(&[1.0, -2.0], "(2,)");
        assert_eq!(&file[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([file[8], file[9]]));
        assert_eq!(((10 + length) % 64, file[9 + length]), (0, b'\n'));
        assert_eq!(file[10 + length..], [1.0f64.to_le_bytes(), (-2.0f64).to_le_bytes()].concat());
        let file = texts(["ab", "c"].into_iter());
        assert_eq!(file[file.len() - 16..], [97, 0, 0, 0, 98, 0, 0, 0, 99, 0, 0, 0, 0, 0, 0, 0]);
    }
}
