//! Ratio of shear to bending deflection of a cantilever.

use crate::body_file::BodyFile;
use crate::document::Document;
use crate::station_table::StationTable;

/// Deflection by shear over that by bending above which there is a warning.
const MAXIMUM_SHEAR: f64 = 0.01;

/// Returns whether a body has no deflection by shear without `shear = false` in its keys: it may have been left out inadvertently.
pub(super) fn is_unstated(name: &str, body: &BodyFile, document: &Document) -> bool {
    !body.shear && document.find(&["body", name, "shear"]).is_none()
}

/// Reason and advice of the warning about bodies of one section without deflection by shear, from each one's share of the deflection by
/// bending; `None` if all shares are small.
pub(super) fn neglected_shear(bodies: &[(&str, f64)]) -> Option<(String, String)> {
    let deflected: Vec<&(&str, f64)> = bodies.iter().filter(|(_, share)| *share > MAXIMUM_SHEAR).collect();
    let percent = 100.0 * deflected.iter().map(|(_, share)| *share).fold(0.0, f64::max);
    let reason = match deflected.as_slice() {
        [] => return None,
        [(name, _)] => {
            format!(
                "shear deflection is neglected, although it is {percent:.1} % of the bending deflection of body {name} under a force at its tip"
            )
        }
        [first @ .., (last, _)] => {
            let first: Vec<&str> = first.iter().map(|(name, _)| *name).collect();
            format!(
                "shear deflection is neglected, although it is up to {percent:.1} % of the bending deflection of bodies {} and {last} under a force \
                 at the tip",
                first.join(", ")
            )
        }
    };
    let advice = "the computed frequencies are too high, most of all for higher modes; shear = true on the body includes shear, \
                  shear = false neglects it without this warning";
    Some((reason, advice.to_owned()))
}

/// Ratio of shear to bending deflection of a body of this length that is clamped, with a force at its tip along `y` and along `z` of its
/// sections: `∫ ds/GA` divided by `∫ s²/EI ds` with `s` from the tip, which is `3 EI/(GA L²)` for a uniform section. Bodies without shear
/// neglect this deflection, which the condensed stiffness does not contain. `None` for a table without shear stiffness.
pub(super) fn shear_shares(table: &StationTable, length_m: f64) -> Option<[f64; 2]> {
    let shear_n = [table.column("shear_stiffness_y_N")?, table.column("shear_stiffness_z_N")?];
    let bending_n_m2 = [table.column("edge_stiffness_N_m2")?, table.column("flap_stiffness_N_m2")?];
    let from_tip = |index: usize| match table.column("eta") {
        Some(shares) => Some((1.0 - shares.get(index)?) * length_m),
        None => Some(length_m - table.column("s_m")?.get(index)?),
    };
    let station =
        |index: usize| Some((from_tip(index)?, [0, 1].map(|axis| (shear_n[axis][index], bending_n_m2[axis][index]))));
    let stations = (0..shear_n[0].len()).map(station).collect::<Option<Vec<_>>>()?;
    Some(shear_over_bending(&stations))
}

/// Ratio of shear to bending deflection of a cantilever under a force along `y` and along `z` at its tip. Stations: distance from the tip
/// in m, and for each direction the shear stiffness in N and the bending stiffness in N·m².
pub(super) fn shear_over_bending(stations: &[(f64, [(f64, f64); 2])]) -> [f64; 2] {
    [0, 1].map(|axis| {
        let mut sums = [0.0; 2];
        for pair in stations.windows(2) {
            // integrals of 1 and s² between two stations, of which each station's flexibility takes half
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
