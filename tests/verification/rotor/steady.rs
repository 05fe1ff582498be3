//! Steady blade-element momentum theory against OpenFAST and CCBlade.

use super::{nrel_5mw, number, reference, table};
use foldwing::aero::rotor::induction::EndRule;

/// RT-01: power, thrust and induction at OpenFAST's operating points with a stiff rotor, with AeroDyn's formula for the end losses.
///
/// Tolerances are those of the reference: its solver ends at a residual of 5e-10 in the flow angle, and outputs have 8 digits.
#[test]
fn stiff_rotor_is_openfasts_with_its_end_rule() {
    let rotor = nrel_5mw(EndRule::Stopped);
    let rows = table(&reference("openfast_aeromap_stiff.csv"));
    assert_eq!(rows.len(), 14);
    let (mut coefficients, mut induction) = (0.0f64, 0.0f64);
    for row in &rows {
        let wind_m_s = number(row, "WindSpeed_m_per_s");
        let speed_rad_s = number(row, "RotorSpeed_RPM") * std::f64::consts::PI / 30.0;
        let loads = rotor.at(wind_m_s, speed_rad_s, number(row, "Pitch_deg").to_radians());
        let power = loads.power_coefficient / number(row, "RtFldCp_nd") - 1.0;
        let thrust = loads.thrust_coefficient / number(row, "RtFldCt_nd") - 1.0;
        coefficients = coefficients.max(power.abs()).max(thrust.abs());
        for (node, name) in [(2, "B1N1"), (8, "B1N2"), (14, "B1N3")] {
            let error = loads.nodes[node].axial_induction - number(row, &format!("{name}AxInd_nd"));
            induction = induction.max(error.abs());
            let error = loads.nodes[node].tangential_induction - number(row, &format!("{name}TnInd_nd"));
            induction = induction.max(error.abs());
        }
        println!("{wind_m_s} m/s: Cp {power:+.2e}, Ct {thrust:+.2e}, a {induction:.2e} so far");
    }
    assert!(coefficients < 1e-5 && induction < 2e-6, "{coefficients:e} {induction:e}");
}
