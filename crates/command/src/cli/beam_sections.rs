//! Sections of the beams in the summary of a model.

use crate::cli::assessment::short;
use foldwing_file::shapes::SectionProperties;
use foldwing_file::{BodySections, SectionAt};
use std::fmt::Write;

/// Maximum number of sections of a body in the text; the JSON lists all.
const MAXIMUM_ROWS: usize = 5;

/// Title of the table.
const TITLE: &str = "sections: EA, GA in N; GJ, EI in N.m2; mass in kg/m; tension centre, shear centre, centre of mass (y, z) in mm from the beam axis";

/// Returns the table of sections; empty without beams.
pub(super) fn text(bodies: &[BodySections]) -> String {
    let mut rows = vec![
        ["", "at m", "EA", "GA_y", "GA_z", "GJ", "EI_y", "EI_z", "mass", "tension", "shear", "mass centre"]
            .map(str::to_owned),
    ];
    let mut omitted = String::new();
    for body in bodies {
        let count = body.sections.len();
        let shown = |index: &usize| count <= MAXIMUM_ROWS || *index < MAXIMUM_ROWS - 1 || *index == count - 1;
        rows.extend((0..count).filter(shown).map(|index| row(&body.body, &body.sections[index])));
        if count > MAXIMUM_ROWS {
            let _ = writeln!(omitted, "  {}: {} more sections in --json", body.body, count - MAXIMUM_ROWS);
        }
    }
    if rows.len() == 1 {
        return String::new();
    }
    let widths: Vec<usize> =
        (0..rows[0].len()).map(|column| rows.iter().map(|row| row[column].len()).max().unwrap_or(0)).collect();
    let mut text = format!("\n{TITLE}\n");
    for row in rows {
        let cells: Vec<String> = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        let _ = writeln!(text, "  {}", cells.join("  ").trim_end());
    }
    text + &omitted
}

fn row(body: &str, at: &SectionAt) -> [String; 12] {
    let SectionProperties { tension_centre_m, shear_centre_m, centre_of_mass_m, .. } = at.properties;
    let own = &at.properties;
    let number = |value: f64| -> String {
        let rounded = short(value);
        if rounded != 0.0 && !(1e-3..1e6).contains(&rounded.abs()) {
            format!("{rounded:e}")
        } else {
            rounded.to_string()
        }
    };
    let centre = |[y, z]: [f64; 2]| format!("({}, {})", number(1e3 * y), number(1e3 * z));
    let shear = |axis: usize| own.shear_stiffnesses_n.map_or_else(|| "-".to_owned(), |pair| number(pair[axis]));
    [
        body.to_owned(),
        number(at.s_m),
        number(own.axial_stiffness_n),
        shear(0),
        shear(1),
        number(own.torsional_rigidity_n_m2),
        number(own.flap_stiffness_n_m2),
        number(own.edge_stiffness_n_m2),
        number(own.mass_kg_m),
        centre(tension_centre_m),
        shear_centre_m.map_or_else(|| "-".to_owned(), centre),
        centre(centre_of_mass_m),
    ]
}
