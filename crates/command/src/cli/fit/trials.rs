//! Runs of a model with other values of some of its parameters.

use crate::cli::fit::data::Data;
use crate::cli::gradient::Variants;
use crate::cli::sweep::{changed_text, file_path};
use crate::cli::{Failure, shown};
use crate::report::InputTable;
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::InputRows;
use foldwing_file as config;
use foldwing_fmi::interface::Interface;
use foldwing_study::fit::Problem;
use foldwing_study::sensitivity::{Gradients, Mode, Options};
use nalgebra::{DMatrix, DVector};
use std::path::Path;
use std::sync::Arc;

/// Model with the parameters to identify and the measurements.
pub struct Trials<'a> {
    file: String,
    text: &'a str,
    machine: Arc<Machine>,
    interface: &'a Interface,
    settings: &'a [String],
    table: Option<&'a InputTable>,
    options: Options,
    data: &'a Data,
    /// Names, values in the model and units of the parameters.
    pub numbers: Vec<(String, f64, &'static str)>,
    /// Units of the measurements.
    pub units: Vec<&'static str>,
    /// Name of the model.
    pub name: String,
    started: bool,
}

impl<'a> Trials<'a> {
    /// Looks up the parameters to identify.
    pub fn new(
        (path, text): (&Path, &'a str),
        (machine, interface): (Machine, &'a Interface),
        (settings, table, inputs): (&'a [String], Option<&'a InputTable>, InputRows),
        data: &'a Data,
        by: &[&str],
    ) -> Result<Self, Failure> {
        if let Some(row) = by.iter().find(|name| name.contains('@') && file_path(name).is_none()) {
            return Err(Failure::Usage(format!(
                "--by {row}: only Model.fit of the Python package can identify values of an input over time; name a \
                 number that is constant"
            )));
        }
        let options = Options { of: data.of.clone(), stop_s: data.stop_s, mode: Mode::Auto, inputs };
        let mut trials = Self {
            file: shown(path),
            text,
            name: machine.name.clone(),
            machine: Arc::new(machine),
            interface,
            settings,
            table,
            options,
            data,
            numbers: vec![],
            units: vec![],
            started: false,
        };
        let by: Vec<String> = by.iter().map(|name| (*name).to_owned()).collect();
        let found = trials.gradients(&DVector::zeros(0), &by)?;
        trials.units = found.of.iter().map(|row| row.unit).collect();
        trials.numbers = found.by.into_iter().map(|number| (number.name, number.value, number.unit)).collect();
        Ok(trials)
    }

    /// Parameter values in the model.
    pub fn own(&self) -> DVector<f64> {
        DVector::from_iterator(self.numbers.len(), self.numbers.iter().map(|(_, value, _)| *value))
    }

    /// Smallest and largest values of the variables.
    pub fn allowed(&self) -> Vec<[f64; 2]> {
        let range = |name: &str| self.interface.find(name).and_then(|row| row.range);
        let range = |name: &str| range(name).unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        self.numbers.iter().map(|(name, ..)| range(name)).map(|(low, high)| [low, high]).collect()
    }

    /// Index of the parameter that is named in an option.
    pub fn place(&self, option: &str, name: &str) -> Result<usize, Failure> {
        self.numbers.iter().position(|(own, ..)| own == name).ok_or_else(|| {
            let known: Vec<&str> = self.numbers.iter().map(|(own, ..)| own.as_str()).collect();
            Failure::Usage(format!("{option} {name}: is not one of the numbers of --by: {}", known.join(", ")))
        })
    }

    /// Text of the model file with the values of the identified file keys.
    pub fn text_at(&self, x: &DVector<f64>) -> Result<String, Failure> {
        let values: Vec<(Vec<&str>, String)> = self
            .numbers
            .iter()
            .zip(x.iter())
            .filter_map(|((name, ..), value)| Some((file_path(name)?, format!("{value:?}"))))
            .collect();
        let changes: Vec<(Vec<&str>, &str)> =
            values.iter().map(|(path, value)| (path.clone(), value.as_str())).collect();
        if changes.is_empty() { Ok(self.text.to_owned()) } else { changed_text(self.text, "--by", &changes) }
    }

    /// Values of inputs and parameters, `NAME=VALUE`.
    pub fn settings_at(&self, x: &DVector<f64>) -> Vec<String> {
        let own = self.numbers.iter().zip(x.iter()).filter(|((name, ..), _)| file_path(name).is_none());
        own.map(|((name, ..), value)| format!("{name}={value:?}")).collect()
    }

    /// Results at parameter values, without derivatives.
    pub fn results(&self, x: &DVector<f64>) -> Result<Vec<f64>, Failure> {
        Ok(self.gradients(x, &[])?.of.iter().map(|row| row.value).collect())
    }

    fn gradients(&self, x: &DVector<f64>, by: &[String]) -> Result<Gradients, Failure> {
        let text = self.text_at(x)?;
        let machine = match text == self.text {
            true => Arc::clone(&self.machine),
            false => Arc::new(
                config::parse(&text, &self.file).map_err(|error| Failure::Model { text: text.clone(), error })?,
            ),
        };
        let interface = Interface::new(&machine);
        let settings: Vec<String> = self.settings.iter().cloned().chain(self.settings_at(x)).collect();
        let model = Variants {
            file: &self.file,
            text: &text,
            machine,
            interface: &interface,
            settings: &settings,
            table: self.table,
        };
        let found = model.gradients(by, &self.options).map_err(|failure| match failure {
            // errors name `--of`, where the options of this command are columns and --value
            Failure::Usage(text) => match text.strip_prefix("--of ") {
                Some(rest) => Failure::Usage(format!("measurement {rest}")),
                None => Failure::Usage(text),
            },
            other @ (Failure::Refused(_)
            | Failure::Model { .. }
            | Failure::Simulation(_)
            | Failure::Statics(_)
            | Failure::Files(_)
            | Failure::Differ(..)
            | Failure::Closed) => other,
        })?;
        if found.of.len() != self.data.of.len() {
            return Err(Failure::Usage(
                "--value: a name selects several results; give each result by its own name".to_owned(),
            ));
        }
        Ok(found)
    }
}

impl Problem for Trials<'_> {
    type Error = Failure;

    fn residuals(&mut self, x: &DVector<f64>) -> Result<Option<DVector<f64>>, Failure> {
        let first = !std::mem::replace(&mut self.started, true);
        match self.results(x) {
            Ok(found) => {
                Ok(Some(DVector::from_fn(found.len(), |i, _| (found[i] - self.data.values[i]) / self.data.scales[i])))
            }
            // values that the model rejects, or a run without the results: the trial step is too long
            Err(
                Failure::Refused(_)
                | Failure::Model { .. }
                | Failure::Usage(_)
                | Failure::Simulation(_)
                | Failure::Statics(_),
            ) if !first => Ok(None),
            Err(failure) => Err(failure),
        }
    }

    fn jacobian(&mut self, x: &DVector<f64>) -> Result<DMatrix<f64>, Failure> {
        let by: Vec<String> = self.numbers.iter().map(|(name, ..)| name.clone()).collect();
        let found = self.gradients(x, &by)?;
        Ok(DMatrix::from_fn(found.of.len(), by.len(), |i, j| found.of[i].derivatives[j] / self.data.scales[i]))
    }
}
