//! Wind fields written by another program.

use super::{number, reference, table};
use foldwing::aero::rotor::turbulence_box::TurbulenceBox;
use foldwing::config::{BladedSettings, read_bladed, read_turbsim};

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/tests/reference/turbine/wind/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// Largest difference from the input of pyTurbSim, component by component, in m/s. Its `.bts` writer overflows at the largest value of a
/// component (65536 levels for 65535 numbers): this one value is excluded.
fn difference_m_s(grid: &TurbulenceBox) -> [f64; 3] {
    let rows = table(&reference("wind/pyturbsim.csv"));
    assert_eq!(rows.len(), grid.velocity_m_s.len());
    std::array::from_fn(|axis| {
        let column = ["u_m_s", "v_m_s", "w_m_s"][axis];
        let largest = rows.iter().map(|row| number(row, column)).fold(f64::NEG_INFINITY, f64::max);
        let others = rows.iter().filter(|row| number(row, column) < largest);
        others.fold(0.0f64, |worst, row| {
            let index = |name| number(row, name) as usize;
            let place = (index("plane") * grid.upward + index("row")) * grid.across + index("point");
            worst.max((f64::from(grid.velocity_m_s[place][axis]) - number(row, column)).abs())
        })
    })
}

/// RT-04: the files of pyTurbSim's two writers for one field. Tolerances: one level of their 16-bit numbers, which they truncate instead of
/// rounding.
#[test]
fn fields_of_another_program_are_read() {
    let turbsim = read_turbsim(&bytes("pyturbsim.bts")).unwrap();
    let sizes = (turbsim.across, turbsim.upward, turbsim.planes, turbsim.periodic);
    assert_eq!(sizes, (3, 4, 16, false));
    let [across_m, upward_m, plane_interval_s] = [turbsim.across_m, turbsim.upward_m, turbsim.plane_interval_s];
    assert_eq!(
        [across_m, upward_m, plane_interval_s, turbsim.bottom_m, turbsim.carried_m_s],
        [5.0, 6.0, 0.25, 80.0, 11.0]
    );
    let error = difference_m_s(&turbsim);
    assert!(error.iter().all(|error| *error < 2e-4), "{error:?}"); // a range of 9 m/s in 65536 levels: 1.4e-4

    let settings = BladedSettings { middle_height_m: 89.0, from_port: true };
    let bladed = read_bladed(&bytes("pyturbsim.wnd"), settings).unwrap();
    assert_eq!((bladed.across, bladed.upward, bladed.planes, bladed.bottom_m), (3, 4, 16, 80.0));
    approx::assert_relative_eq!(bladed.plane_interval_s, 0.25, max_relative = 1e-6);
    let error = difference_m_s(&bladed);
    assert!(error.iter().all(|error| *error < 3e-3), "{error:?}"); // a thousandth of a standard deviation of up to 2 m/s

    let wrong = read_bladed(&bytes("pyturbsim.wnd"), BladedSettings { from_port: false, ..settings }).unwrap();
    assert!(difference_m_s(&wrong)[0] > 1.0, "points across run the other way");
}

/// Truncation of either file at any point is reported as such before any of its data are used.
#[test]
fn fields_cut_short_are_refused() {
    let settings = BladedSettings { middle_height_m: 89.0, from_port: true };
    let (turbsim, bladed) = (bytes("pyturbsim.bts"), bytes("pyturbsim.wnd"));
    for length in (0..turbsim.len()).step_by(7) {
        let fault = read_turbsim(&turbsim[..length]).unwrap_err().to_string();
        assert!(fault.starts_with("truncated"), "{length}: {fault}");
    }
    for length in (0..bladed.len()).step_by(7) {
        let fault = read_bladed(&bladed[..length], settings).unwrap_err().to_string();
        assert!(fault.starts_with("truncated"), "{length}: {fault}");
    }
    let fault = read_bladed(&turbsim, settings).unwrap_err().to_string();
    assert!(fault.starts_with("identifier is 7; -99"), "{fault}");
    let fault = read_turbsim(&bladed).unwrap_err().to_string();
    assert!(fault.starts_with("identifier is -99; 7 or 8"), "{fault}");
}
