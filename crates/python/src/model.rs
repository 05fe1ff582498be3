//! A model, its variables, and analyses without a simulation.

use crate::input_table::InputTable;
use crate::progress::Progress;
use crate::variables::{described, of_kind, row};
use crate::{object, refusal};
use foldwing_command::cli::{self, ModesOf, Packaging, SweepPlan, SweepRun};
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{Branch, Plant};
use foldwing_fmi::interface::{self, Interface, Variable};
use foldwing_study::campbell;
use foldwing_study::flutter;
use foldwing_study::operating_points::{self, Search, Target, Unknown};
use foldwing_study::periodic;
use foldwing_study::sensitivity;
use foldwing_study::trim;
use foldwing_study::values::Setting;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Values of a list; `None` selects those of the model.
type Values = Option<Vec<f64>>;

/// A machine with the text of its model file and its variable table.
pub struct Shared {
    /// Name of the file, for messages.
    pub file: String,
    /// Text of the model file.
    pub text: String,
    /// The model.
    pub machine: Arc<Machine>,
    /// Its variables.
    pub interface: Arc<Interface>,
}

/// A periodic motion with its outputs over the revolution.
#[derive(Serialize)]
struct WithValues<'a> {
    #[serde(flatten)]
    found: &'a periodic::Periodic,
    turn_deg: Vec<f64>,
    values: Vec<&'a Vec<f64>>,
}

/// Handle of a model.
#[pyclass(frozen, module = "foldwing._native")]
pub struct Model {
    pub shared: Arc<Shared>,
}

#[pymethods]
impl Model {
    /// Reads the text of a model file; `file` is the name in messages.
    #[new]
    fn new(py: Python<'_>, text: String, file: String) -> PyResult<Self> {
        let machine = py.detach(|| foldwing_file::parse(&text, &file)).map_err(|error| refusal::model(&error))?;
        let interface = Arc::new(Interface::new(&machine));
        Ok(Self { shared: Arc::new(Shared { file, text, machine: Arc::new(machine), interface }) })
    }

    /// Returns the model file for a JSON object with the same keys.
    #[staticmethod]
    fn text_of_json(json: &str) -> PyResult<String> {
        foldwing_file::text_of_json(json).map_err(|error| refusal::usage(format!("from_dict: {error}")))
    }

    /// Returns the text of the model file at `file`, including data from files in its folder.
    #[staticmethod]
    fn text_with_files(py: Python<'_>, text: String, file: String) -> PyResult<String> {
        let folder = Path::new(&file).parent().unwrap_or(Path::new(""));
        py.detach(|| foldwing_file::with_files(text, folder, &file)).map_err(|error| refusal::model(&error))
    }

    #[getter]
    fn name(&self) -> &str {
        &self.shared.machine.name
    }

    #[getter]
    fn description(&self) -> &str {
        &self.shared.machine.description
    }

    #[getter]
    fn text(&self) -> &str {
        &self.shared.text
    }

    /// Start, stop and step of `[simulation]` in s.
    #[getter]
    fn experiment(&self) -> (f64, f64, f64) {
        let experiment = &self.shared.machine.experiment;
        (experiment.start_time_s, experiment.stop_time_s, experiment.step_s)
    }

    /// Rows of the table: name, causality, variability, type, unit, start, minimum, maximum, description.
    fn variables<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.shared.interface.variables().iter().map(|row| described(py, row)).collect()
    }

    /// Vectors and quaternions: name, value reference of the first component, number of components.
    fn vectors(&self) -> Vec<(String, u32, usize)> {
        let signals = self.shared.interface.signals().iter();
        let count = |signal: &interface::Signal| signal.shape.components().len();
        signals
            .filter(|signal| count(signal) > 1)
            .map(|signal| (signal.name.clone(), signal.first_reference, count(signal)))
            .collect()
    }

    /// Value reference of a name; an unknown name is an error with the closest one.
    fn find(&self, name: &str) -> PyResult<u32> {
        self.row(name, "variable").map(|row| row.value_reference)
    }

    /// Output of `foldwing check`.
    fn check(&self, py: Python<'_>, variables: bool) -> String {
        py.detach(|| cli::summary(&self.shared.machine, &self.shared.text, variables))
    }

    /// Output of `foldwing check --json`.
    fn check_json(&self, py: Python<'_>) -> String {
        py.detach(|| cli::summary_json(&self.shared.machine, &self.shared.text))
    }

    /// Sections of the beams, as in the output of `foldwing check --json`.
    fn sections(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        object::of(py, &py.detach(|| foldwing_file::section_properties(&self.shared.text)))
    }

    /// Output of `foldwing static --json`.
    fn rest(
        &self,
        py: Python<'_>,
        settings: Vec<(String, Bound<'_, PyAny>)>,
        arc_length: bool,
        branch: &str,
    ) -> PyResult<Py<PyAny>> {
        let branch = if branch == "path" { Branch::Path } else { Branch::Stable };
        let mut plant = self.plant(&settings)?;
        let time_s = self.shared.machine.experiment.start_time_s;
        let rest = py.detach(|| cli::rest(&mut plant, time_s, arc_length, branch));
        object::of(py, &rest.map_err(|error| refusal::statics(&error))?)
    }

    /// Output of `foldwing modes --json`.
    fn modes(
        &self,
        py: Python<'_>,
        settings: Vec<(String, Bound<'_, PyAny>)>,
        undeformed: bool,
        count: usize,
        lattice: bool,
    ) -> PyResult<Py<PyAny>> {
        let mut plant = self.plant(&settings)?;
        let time_s = self.shared.machine.experiment.start_time_s;
        let modes = py.detach(|| cli::modes(&mut plant, time_s, state_of(undeformed, lattice), count));
        object::of(py, &modes.map_err(|error| refusal::statics(&error))?)
    }

    /// Page of `foldwing modes --view`.
    fn modes_page(
        &self,
        py: Python<'_>,
        settings: Vec<(String, Bound<'_, PyAny>)>,
        undeformed: bool,
        count: usize,
        lattice: bool,
    ) -> PyResult<String> {
        let mut plant = self.plant(&settings)?;
        let time_s = self.shared.machine.experiment.start_time_s;
        py.detach(|| cli::modes_page(&mut plant, time_s, state_of(undeformed, lattice), count))
            .map_err(|failure| refusal::command(&failure))
    }

    /// An entry of `results` in the output of `foldwing flutter --json`.
    fn flutter(
        &self,
        py: Python<'_>,
        settings: Vec<(String, Bound<'_, PyAny>)>,
        wind_m_s: PyReadonlyArray1<'_, f64>,
        count: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        let plant = self.plant(&settings)?;
        let options = flutter::Options { wind_m_s: wind_m_s.as_array().to_vec(), count };
        let (mut progress, mut raised) = (Progress::new(progress), None);
        let found = py.detach(|| flutter::sweep_watched(plant, &options, &mut progress.watch(&mut raised)));
        object::of(py, &found.map_err(|error| raised.unwrap_or_else(|| refusal::flutter(&error)))?)
    }

    /// Page of `foldwing flutter --view`.
    fn flutter_page(
        &self,
        py: Python<'_>,
        settings: Vec<(String, Bound<'_, PyAny>)>,
        wind_m_s: PyReadonlyArray1<'_, f64>,
        count: usize,
    ) -> PyResult<String> {
        let plants = [self.plant(&settings)?, self.plant(&settings)?];
        let options = flutter::Options { wind_m_s: wind_m_s.as_array().to_vec(), count };
        py.detach(|| cli::flutter_page(plants, &options)).map_err(|failure| refusal::command(&failure))
    }

    /// The result of [`Self::flutter`] for each row of start values, parameters and keys of the model file.
    fn flutter_over(
        &self,
        py: Python<'_>,
        keys: Vec<String>,
        rows: Vec<Vec<String>>,
        wind_m_s: PyReadonlyArray1<'_, f64>,
        count: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Vec<Py<PyAny>>> {
        let shared = &self.shared;
        let of = (Arc::clone(&shared.machine), Arc::clone(&shared.interface));
        let options = flutter::Options { wind_m_s: wind_m_s.as_array().to_vec(), count };
        let plan = SweepPlan::new((&shared.file, &shared.text), of, keys, rows, SweepRun::default())
            .map_err(|failure| refusal::command(&failure))?;
        let mut list = Vec::new();
        let mut shown = Progress::new(progress);
        for index in 0..plan.count() {
            let plant = plan.plant(index).map_err(|failure| refusal::command(&failure))?;
            // Ctrl-C also ends a row
            let (mut unseen, mut raised) = (Progress::new(None), None);
            let found = py.detach(|| flutter::sweep_watched(plant, &options, &mut unseen.watch(&mut raised)));
            list.push(object::of(py, &found.map_err(|error| raised.unwrap_or_else(|| refusal::flutter(&error)))?)?);
            shown.tell((index + 1) as f64 / plan.count() as f64)?;
        }
        Ok(list)
    }

    /// Output of `foldwing modes --vary rotor_speed_rpm=… --json`.
    #[allow(clippy::too_many_arguments, reason = "named in Python")]
    fn campbell(
        &self,
        py: Python<'_>,
        speed_rpm: Vec<f64>,
        shaft: Option<String>,
        undeformed: bool,
        count: usize,
        settings: Vec<(String, Bound<'_, PyAny>)>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        let options = campbell::Options { speed_rpm, shaft, undeformed, count, settings: self.settings(&settings)? };
        let machine = Arc::clone(&self.shared.machine);
        let (mut progress, mut raised) = (Progress::new(progress), None);
        let found = py.detach(|| cli::campbell(machine, &options, &mut progress.watch(&mut raised)));
        object::of(py, &found.map_err(|error| raised.unwrap_or_else(|| refusal::campbell(&error)))?)
    }

    /// Output of `foldwing trim --json`; `turns` are values of the attitude in rad and of the turn in rad/s.
    fn trim(
        &self,
        py: Python<'_>,
        settings: Vec<(String, Bound<'_, PyAny>)>,
        solve_for: Vec<String>,
        targets: Vec<(String, f64)>,
        turns: Vec<(String, f64)>,
    ) -> PyResult<Py<PyAny>> {
        let plant = self.plant(&settings)?;
        let targets = targets.into_iter().map(|(output, value)| trim::Target { output, value }).collect();
        let turns = turns.iter().filter_map(|(name, value)| Some((trim::Turn::named(name)?, *value))).collect();
        let options = trim::Options { solve_for, targets, turns };
        let (mut progress, mut raised) = (Progress::new(None), None);
        let found = py.detach(|| trim::solve_watched(plant, &options, &mut progress.watch(&mut raised)));
        object::of(py, &found.map_err(|error| raised.unwrap_or_else(|| refusal::trim(&error)))?)
    }

    /// Output of `foldwing periodic --json`, with the outputs over the revolution; `counts` are steps, harmonics, modes and perturbations.
    #[allow(clippy::too_many_arguments, reason = "named in Python")]
    fn periodic(
        &self,
        py: Python<'_>,
        speed_rpm: Option<f64>,
        shaft: Option<String>,
        settings: Vec<(String, Bound<'_, PyAny>)>,
        outputs: Vec<String>,
        counts: (usize, usize, usize, usize),
        tolerance: f64,
    ) -> PyResult<Py<PyAny>> {
        let options = self.periodic_options(speed_rpm, shaft, &settings, outputs, counts, tolerance)?;
        let (mut progress, mut raised) = (Progress::new(None), None);
        let find = || periodic::find_watched(&self.shared.machine, &options, &mut progress.watch(&mut raised));
        let found = py.detach(find);
        let found = found.map_err(|error| raised.unwrap_or_else(|| refusal::periodic(&error)))?;
        let (turn_deg, values) = (found.turn_deg(), found.outputs.iter().map(|series| &series.values).collect());
        object::of(py, &WithValues { found: &found, turn_deg, values })
    }

    /// Page of `foldwing periodic --view`.
    #[allow(clippy::too_many_arguments, reason = "named in Python")]
    fn periodic_page(
        &self,
        py: Python<'_>,
        speed_rpm: Option<f64>,
        shaft: Option<String>,
        settings: Vec<(String, Bound<'_, PyAny>)>,
        counts: (usize, usize, usize, usize),
        tolerance: f64,
    ) -> PyResult<String> {
        let options = self.periodic_options(speed_rpm, shaft, &settings, Vec::new(), counts, tolerance)?;
        py.detach(|| cli::periodic_page(&self.shared.machine, &options)).map_err(|failure| refusal::command(&failure))
    }

    /// Output of `foldwing operating-points --json`; `lists` are wind in m/s, speed in rpm and pitch in degrees, `joints` the shaft and the
    /// pitch joints.
    #[allow(clippy::too_many_arguments, reason = "named in Python")]
    fn operating_points(
        &self,
        py: Python<'_>,
        lists: (Vec<f64>, Values, Values),
        tip_speed_ratio: Option<f64>,
        paired: bool,
        solve_for: Option<(String, f64, f64)>,
        target: Option<(String, f64)>,
        joints: (Option<String>, Option<Vec<String>>),
        settings: Vec<(String, Bound<'_, PyAny>)>,
        outputs: Vec<String>,
        steps: usize,
        tolerance: f64,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Py<PyAny>> {
        let (wind_m_s, speed_rpm, pitch_deg) = lists;
        let (shaft, pitch_joints) = joints;
        let search = solve_for.zip(target).map(|((unknown, from, to), (output, value))| Search {
            unknown: match unknown.as_str() {
                "pitch_deg" => Unknown::PitchDeg { from, to },
                _ => Unknown::SpeedRpm { from, to },
            },
            target: Target { output, value },
        });
        let options = operating_points::Options {
            wind_m_s,
            speed_rpm,
            tip_speed_ratio,
            pitch_deg,
            paired,
            search,
            shaft,
            pitch_joints,
            settings: self.settings(&settings)?,
            outputs,
            steps,
            tolerance,
        };
        let machine = Arc::clone(&self.shared.machine);
        let (mut progress, mut raised) = (Progress::new(progress), None);
        let tabulate = || operating_points::tabulate_watched(machine, &options, &mut progress.watch(&mut raised));
        let table = py.detach(tabulate);
        object::of(py, &table.map_err(|error| raised.unwrap_or_else(|| refusal::operating_points(&error)))?)
    }

    /// Output of `foldwing gradient --json`; `settings` are `NAME=VALUE`.
    #[allow(clippy::too_many_arguments, reason = "as many as in Python")]
    fn gradient(
        &self,
        py: Python<'_>,
        of: Vec<String>,
        by: Vec<String>,
        stop_s: Option<f64>,
        settings: Vec<String>,
        mode: &str,
        inputs: Option<&InputTable>,
    ) -> PyResult<Py<PyAny>> {
        let mode = match mode {
            "forward" => sensitivity::Mode::Forward,
            "adjoint" => sensitivity::Mode::Adjoint,
            _ => sensitivity::Mode::Auto,
        };
        let options = sensitivity::Options { of, stop_s, mode, ..Default::default() };
        let Shared { file, text, machine, interface } = &*self.shared;
        let model = (file.as_str(), text.as_str());
        let options = (inputs.map(|inputs| &inputs.table), options);
        let found = py.detach(|| cli::gradients(model, (Arc::clone(machine), interface), &settings, &by, options));
        object::of(py, &found.map_err(|failure| refusal::command(&failure))?)
    }

    /// Text of the model file with other values of keys, each value as TOML text.
    fn text_with_values(&self, values: Vec<(String, String)>) -> PyResult<String> {
        cli::text_with_values(&self.shared.text, &values).map_err(|failure| refusal::command(&failure))
    }

    /// Writes an FMU, and a system of it if `ssp` is given; `kinds` are the version of FMI, co-simulation, Model Exchange, scalars instead of arrays,
    /// energy accounts, and Real outputs only.
    #[pyo3(signature = (output, *, ssp, model, libraries, linear, kinds, without_reference, force))]
    #[allow(clippy::too_many_arguments, reason = "named in Python")]
    fn package(
        &self,
        py: Python<'_>,
        output: PathBuf,
        ssp: Option<PathBuf>,
        model: Option<PathBuf>,
        libraries: Vec<PathBuf>,
        linear: Option<String>,
        kinds: (u8, bool, bool, [bool; 3]),
        without_reference: bool,
        force: bool,
    ) -> PyResult<()> {
        let (fmi, co_simulation, model_exchange, variables) = kinds;
        let kinds = cli::kinds(fmi, [co_simulation, model_exchange], variables);
        let packaging = Packaging { output, ssp, model, libraries, linear, kinds, without_reference, force };
        py.detach(|| cli::package(&self.shared.machine, &self.shared.text, &packaging))
            .map_err(|failure| refusal::command(&failure))
    }

    /// Communication points in s as an array of shape (points,).
    fn points<'py>(
        &self,
        py: Python<'py>,
        start_s: Option<f64>,
        stop_s: Option<f64>,
        step_s: Option<f64>,
    ) -> PyResult<Bound<'py, numpy::PyArray1<f64>>> {
        let points = cli::points(&self.shared.machine, start_s, stop_s, step_s);
        Ok(numpy::PyArray1::from_vec(py, points.map_err(|failure| refusal::command(&failure))?))
    }
}

impl Model {
    /// Returns a plant with start values set, not yet initialised.
    pub fn plant(&self, settings: &[(String, Bound<'_, PyAny>)]) -> PyResult<Plant> {
        let mut plant = Plant::new(Arc::clone(&self.shared.machine));
        for (name, value) in settings {
            let row = self.row(name, "input or parameter")?;
            let value = of_kind(row, value)?;
            self.shared
                .interface
                .set(&mut plant, row.value_reference, value)
                .map_err(|error| refusal::access(&error))?;
        }
        Ok(plant)
    }

    /// Converts start values to the types of their variables.
    fn settings(&self, settings: &[(String, Bound<'_, PyAny>)]) -> PyResult<Vec<Setting>> {
        let typed = |(name, value): &(String, Bound<'_, PyAny>)| {
            let value = of_kind(self.row(name, "input or parameter")?, value)?;
            Ok(Setting { name: name.clone(), value })
        };
        settings.iter().map(typed).collect()
    }

    /// Options of the search for a periodic motion; `counts` are steps, harmonics, modes and perturbations.
    fn periodic_options(
        &self,
        speed_rpm: Option<f64>,
        shaft: Option<String>,
        settings: &[(String, Bound<'_, PyAny>)],
        outputs: Vec<String>,
        (steps, harmonics, count, perturbations): (usize, usize, usize, usize),
        tolerance: f64,
    ) -> PyResult<periodic::Options> {
        let settings = self.settings(settings)?;
        Ok(periodic::Options { speed_rpm, shaft, settings, steps, tolerance, outputs, harmonics, count, perturbations })
    }

    /// Returns the row of a name; `what` describes it in messages.
    pub fn row(&self, name: &str, what: &'static str) -> PyResult<&Variable> {
        row(&self.shared.interface, name, what)
    }
}

/// State about which modes are computed, and the motion-dependent loads that they include.
fn state_of(undeformed: bool, lattice: bool) -> ModesOf {
    match (undeformed, lattice) {
        (true, _) => ModesOf::Undeformed,
        (false, true) => ModesOf::RestInLattice,
        (false, false) => ModesOf::Rest,
    }
}
