//! Validates and runs an FMU with the crate fmi-rs, and writes its scalar outputs over time.
//!
//! `second_importer FMU cs|me STOP_S INTERVAL_S STEP_S CSV`: FMI 2.0 or 3.0, depending on the archive; `STEP_S` is the step of
//! the integrator in Model Exchange. Findings of the validation are printed one per line; the exit code is then 1.

mod runge_kutta;

use fmi_rs::model_description::{FMIMajorVersion, peek_fmi_major_version};
use fmi_rs::{model_description, sim, zip};
use runge_kutta::RungeKuttaFactory;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

/// Arguments of the command line.
struct Run {
    archive: PathBuf,
    exchange: bool,
    stop_s: f64,
    interval_s: f64,
    step_s: f64,
    table: PathBuf,
}

impl Run {
    fn read() -> Option<Self> {
        let words: Vec<String> = std::env::args().skip(1).collect();
        let [archive, kind, stop_s, interval_s, step_s, table] = words.as_slice() else { return None };
        let exchange = match kind.as_str() {
            "cs" => false,
            "me" => true,
            _ => return None,
        };
        let [stop_s, interval_s, step_s] = [stop_s, interval_s, step_s].map(|word| word.parse::<f64>().ok());
        let (archive, table) = (archive.into(), table.into());
        let run = Self { archive, exchange, stop_s: stop_s?, interval_s: interval_s?, step_s: step_s?, table };
        [run.stop_s, run.interval_s, run.step_s].iter().all(|time_s| *time_s > 0.0).then_some(run)
    }

    /// Returns the findings of the validation; runs the FMU if there are none.
    fn check(&self) -> Result<Vec<String>, Box<dyn Error>> {
        let folder = tempfile::tempdir()?;
        zip::extract_zip_archive(&self.archive, folder.path())?;
        let description = folder.path().join("modelDescription.xml");
        match peek_fmi_major_version(&description)? {
            FMIMajorVersion::V2 => self.check_2(folder.path(), &description),
            FMIMajorVersion::V3 => self.check_3(folder.path(), &description),
        }
    }

    fn check_2(&self, folder: &Path, description: &Path) -> Result<Vec<String>, Box<dyn Error>> {
        use model_description::fmi2::{Causality, ModelDescription};
        use sim::fmi2::{SimulationSettings, Trajectories, cs, csv, me, recorder::Recorder};
        let description = Arc::new(ModelDescription::from_path(description)?);
        let findings = description.validate();
        if !findings.is_empty() {
            return Ok(findings.into_iter().map(|finding| finding.message).collect());
        }
        let outputs = description.modelVariables.iter().enumerate();
        let outputs = outputs.filter(|(_, variable)| variable.causality == Causality::Output).map(|(index, _)| index);
        let recorder = Arc::new(Recorder::new(Trajectories::new(Arc::clone(&description), outputs.collect())));
        let settings = SimulationSettings {
            unzipdir: folder.to_owned(),
            model_description: Arc::clone(&description),
            start_time: 0.0,
            stop_time: self.stop_s,
            logging_on: true,
            set_stop_time: true,
            output_interval: self.interval_s,
            log_time_scale: false,
            tolerance: 1e-12,
            set_tolerance: false,
            start_values: vec![],
            log_fmi_calls: false,
            input_file: None,
            early_return_allowed: false,
            event_mode_used: false,
            log_file: None,
            initial_fmu_state_file: None,
            final_fmu_state_file: None,
        };
        if self.exchange {
            me::simulate(&settings, &RungeKuttaFactory { step_s: self.step_s }, None, Arc::clone(&recorder))?;
        } else {
            cs::simulate(&settings, None, Arc::clone(&recorder))?;
        }
        csv::write_csv(&recorder.trajectories.borrow(), &self.table)?;
        Ok(vec![])
    }

    fn check_3(&self, folder: &Path, description: &Path) -> Result<Vec<String>, Box<dyn Error>> {
        use fmi_rs::fmi3::LibraryKind;
        use model_description::fmi3::{Causality, ModelDescription};
        use sim::fmi3::{SimulationSettings, Trajectories, cs, csv, me, recorder::Recorder};
        let description = Arc::new(ModelDescription::from_path(description)?);
        let findings = description.validate();
        if !findings.is_empty() {
            return Ok(findings.into_iter().map(|finding| finding.message).collect());
        }
        let outputs = description.modelVariables.iter().enumerate();
        let outputs = outputs.filter(|(_, variable)| variable.causality == Causality::Output).map(|(index, _)| index);
        let recorder = Arc::new(Recorder::new(Trajectories::new(Arc::clone(&description), outputs.collect())));
        let settings = SimulationSettings {
            unzipdir: folder.to_owned(),
            model_description: Arc::clone(&description),
            library_kind: LibraryKind::Native,
            enable_dae: false,
            start_time: 0.0,
            stop_time: self.stop_s,
            visible: false,
            logging_on: true,
            set_stop_time: true,
            output_interval: self.interval_s,
            log_time_scale: false,
            tolerance: 1e-12,
            set_tolerance: false,
            start_values: vec![],
            log_fmi_calls: false,
            intermediate_update: false,
            input_file: None,
            early_return_allowed: !self.exchange,
            event_mode_used: !self.exchange,
            log_file: None,
            initial_fmu_state_file: None,
            final_fmu_state_file: None,
        };
        if self.exchange {
            me::simulate(&settings, &RungeKuttaFactory { step_s: self.step_s }, None, Arc::clone(&recorder))?;
        } else {
            cs::simulate(&settings, None, Arc::clone(&recorder))?;
        }
        csv::write_csv(&recorder.trajectories.borrow(), &self.table)?;
        Ok(vec![])
    }
}

fn main() -> ExitCode {
    let Some(run) = Run::read() else {
        eprintln!("second_importer FMU cs|me STOP_S INTERVAL_S STEP_S CSV");
        return ExitCode::from(2);
    };
    match run.check() {
        Ok(findings) if findings.is_empty() => ExitCode::SUCCESS,
        Ok(findings) => {
            findings.iter().for_each(|finding| println!("{finding}"));
            ExitCode::from(1)
        }
        Err(error) => {
            eprintln!("{}: {error}", run.archive.display());
            ExitCode::from(1)
        }
    }
}
