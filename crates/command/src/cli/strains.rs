//! Maximum longitudinal strain of every section over a run, as CSV.

use foldwing_engine::plant::{Plant, SectionStrain};
use std::io::{self, Write};

/// Largest `|E₁₁|` of each section so far, and the time of its occurrence.
#[derive(Default)]
pub struct StrainPeaks {
    rows: Vec<(SectionStrain, f64)>,
}

impl StrainPeaks {
    /// Names of the columns.
    pub const COLUMNS: [&str; 6] = ["body", "position_m", "largest_axial_strain", "time_s", "y_m", "z_m"];

    /// Updates the maxima with the plant's current strains.
    pub fn include(&mut self, plant: &Plant) {
        let time_s = plant.time_s();
        let strains = plant.section_strains();
        if self.rows.is_empty() {
            self.rows = strains.into_iter().map(|strain| (strain, time_s)).collect();
            return;
        }
        for (row, strain) in self.rows.iter_mut().zip(strains) {
            if strain.largest.abs() > row.0.largest.abs() {
                *row = (strain, time_s);
            }
        }
    }

    /// Writes one line per section.
    pub fn write(&self, plant: &Plant, mut sink: impl Write) -> io::Result<()> {
        writeln!(sink, "{}", Self::COLUMNS.join(","))?;
        for (strain, time_s) in &self.rows {
            let body = &plant.machine().bodies[strain.body].name;
            let ([y, z], position, largest) = (strain.point_m, strain.position_m, strain.largest);
            writeln!(sink, "{body},{position},{largest:e},{time_s},{y},{z}")?;
        }
        sink.flush()
    }
}
