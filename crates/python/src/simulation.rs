//! Simulation of a model: step by step, or at once over given times.

use crate::input_table::InputTable;
use crate::model::{Model, Shared};
use crate::progress::Progress;
use crate::refusal;
use crate::variables::{of_kind, row};
use foldwing_command::report::recording::FRAMES;
use foldwing_command::report::signals::Signals;
use foldwing_command::report::viewer::{PackedRun, page};
use foldwing_command::report::{Recording, number};
use foldwing_engine::plant::{OutputSet, Plant, PlantError, Snapshot};
use foldwing_fmi::interface::{Causality, Stage, Value, guid};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::collections::HashMap;
use std::sync::Arc;

/// Step-by-step simulation. Variables are read and set by their FMU names; the name of a vector selects all its components.
#[pyclass(module = "foldwing._native", subclass)]
pub struct Simulation {
    shared: Arc<Shared>,
    plant: Plant,
    started: bool,
    /// First value reference and number of components of vectors; created at the first use of a vector.
    vectors: Option<HashMap<String, (u32, usize)>>,
}

/// Result of a run: values of shape (variables, points), number of points, exception or `None`, page or `None`.
type Outcome<'py> = (Bound<'py, PyArray2<f64>>, usize, Option<PyErr>, Option<String>);

#[pymethods]
impl Simulation {
    /// Create a simulation without starting it.
    #[new]
    fn new(model: &Model, settings: Vec<(String, Bound<'_, PyAny>)>) -> PyResult<Self> {
        let plant = model.plant(&settings)?;
        Ok(Self { shared: Arc::clone(&model.shared), plant, started: false, vectors: None })
    }

    /// Compute the initial state at `time_s`.
    fn start(&mut self, py: Python<'_>, time_s: f64) -> PyResult<()> {
        self.plant.watch(OutputSet::NONE);
        let plant = &mut self.plant;
        py.detach(|| plant.initialize(time_s)).map_err(|error| refusal::simulation(&error))?;
        self.started = true;
        Ok(())
    }

    /// Compute the static equilibrium at `time_s` and keep it as the state.
    fn settle(&mut self, py: Python<'_>, time_s: f64) -> PyResult<()> {
        let plant = &mut self.plant;
        py.detach(|| plant.study().equilibrium(time_s, foldwing_engine::plant::Holding::AsReleased))
            .map_err(|error| refusal::statics(&error))?;
        self.started = true;
        Ok(())
    }

    /// Current time in s.
    #[getter]
    fn time(&self) -> f64 {
        self.plant.time_s()
    }

    /// Advance by `step` s with the current inputs.
    fn step(&mut self, py: Python<'_>, step: f64) -> PyResult<()> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(refusal::usage(format!("step {step}: must be a positive, finite number of seconds")));
        }
        self.march(py, self.plant.time_s() + step)
    }

    /// Advance to `time` s with the current inputs.
    fn step_to(&mut self, py: Python<'_>, time: f64) -> PyResult<()> {
        let now_s = self.plant.time_s();
        if !(time > now_s && time.is_finite()) {
            return Err(refusal::usage(format!(
                "step_to {time}: must be a finite time after the present one, {now_s} s"
            )));
        }
        self.march(py, time)
    }

    fn __getitem__<'py>(&mut self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        if let Some(row) = self.shared.interface.find(name) {
            let reference = row.value_reference;
            return match self.read(reference) {
                Some(Value::Real(value)) => value.into_bound_py_any(py),
                Some(Value::Integer(value)) => value.into_bound_py_any(py),
                Some(Value::Boolean(value)) => value.into_bound_py_any(py),
                None => Err(refusal::usage(format!("{name}: has no value"))),
            };
        }
        let Some((first, count)) = self.vector(name) else {
            return Err(row(&self.shared.interface, name, "variable").err().unwrap_or_else(|| refusal::usage(name)));
        };
        let values: Vec<f64> = (first..).take(count).filter_map(|row| self.read(row)).map(|v| number(&v)).collect();
        Ok(PyArray1::from_vec(py, values).into_any())
    }

    fn __setitem__(&mut self, name: &str, value: &Bound<'_, PyAny>) -> PyResult<()> {
        let stage = if self.started { Stage::Running } else { Stage::Starting };
        let shared = Arc::clone(&self.shared);
        if shared.interface.find(name).is_none()
            && let Some((first, count)) = self.vector(name)
        {
            let values: Vec<f64> = value
                .extract()
                .map_err(|_| refusal::usage(format!("{name}: has {count} components; give a sequence of numbers")))?;
            if values.len() != count {
                return Err(refusal::usage(format!("{name}: {} values for {count} components", values.len())));
            }
            let references: Vec<u32> = (first..).take(count).collect();
            return shared
                .interface
                .set_all(&mut self.plant, references.as_slice(), &values, stage)
                .map_err(|error| refusal::access(&error));
        }
        let row = row(&shared.interface, name, "input or parameter")?;
        let set = match of_kind(row, value)? {
            Value::Real(value) => {
                shared.interface.set_all(&mut self.plant, [row.value_reference].as_slice(), &[value], stage)
            }
            Value::Integer(value) => {
                shared.interface.set_all(&mut self.plant, [row.value_reference].as_slice(), &[value], stage)
            }
            Value::Boolean(value) => {
                shared.interface.set_all(&mut self.plant, [row.value_reference].as_slice(), &[value], stage)
            }
        };
        set.map_err(|error| refusal::access(&error))
    }

    /// Values of variables by value reference, shape (references,); Booleans as 0 and 1.
    fn values<'py>(
        &mut self,
        py: Python<'py>,
        references: PyReadonlyArray1<'_, u32>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let references = references.as_array();
        let mut values = Vec::with_capacity(references.len());
        for &reference in references {
            let value = self.read(reference);
            values.push(value.map(|value| number(&value)).ok_or_else(|| refusal::usage("no such variable"))?);
        }
        Ok(PyArray1::from_vec(py, values))
    }

    /// Save the complete state of the simulation.
    fn save(&self) -> State {
        State { shared: Arc::clone(&self.shared), snapshot: self.plant.snapshot() }
    }

    /// Restore a saved state, bit for bit.
    fn restore(&mut self, state: &State) -> PyResult<()> {
        if state.shared.text != self.shared.text {
            let (own, other) = (&self.shared.machine.name, &state.shared.machine.name);
            return Err(refusal::usage(format!("the state belongs to the model {other}, not to {own} as it is here")));
        }
        self.plant.restore(&state.snapshot).map_err(|error| refusal::usage(error.to_string()))?;
        self.started = true;
        Ok(())
    }

    /// Solver statistics since the start: steps, rejections, iterations and others.
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let counts = self.plant.statistics();
        let fields = PyDict::new(py);
        for (name, count) in [
            ("steps", counts.steps),
            ("rejections", counts.rejections),
            ("failures", counts.failures),
            ("iterations", counts.iterations),
            ("factorizations", counts.factorizations),
            ("events", counts.events),
        ] {
            fields.set_item(name, count)?;
        }
        Ok(fields)
    }

    /// Run from the first to the last of `times_s`. Returns values at the times, shape (variables, points), the number of
    /// points reached, the exception that ended the run early, and with `view` an animated page.
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        times_s: PyReadonlyArray1<'_, f64>,
        references: Vec<u32>,
        inputs: Option<&InputTable>,
        view: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Outcome<'py>> {
        let times_s = times_s.as_array().to_vec();
        let mut run = Run::new(self, &times_s, &references, view);
        let mut progress = Progress::new(progress);
        let ended = py.detach(|| run.through(inputs, &mut progress)).err();
        let Run { values, reached, film, .. } = run;
        let page = film.map(|film| film.page());
        self.started = true;
        let array = PyArray1::from_vec(py, values).reshape([references.len() + 1, times_s.len()])?;
        Ok((array, reached, ended, page))
    }
}

impl Simulation {
    fn march(&mut self, py: Python<'_>, end_s: f64) -> PyResult<()> {
        if !self.started {
            return Err(refusal::usage("the simulation has not started; call start()"));
        }
        let plant = &mut self.plant;
        py.detach(|| plant.step(end_s)).map_err(|error| refusal::simulation(&error))
    }

    fn read(&mut self, reference: u32) -> Option<Value> {
        if self.started {
            self.plant.provide(self.shared.interface.needs([reference].as_slice()));
        }
        self.shared.interface.get(&self.plant, self.plant.outputs(), reference)
    }

    fn vector(&mut self, name: &str) -> Option<(u32, usize)> {
        let vectors = self.vectors.get_or_insert_with(|| {
            let signals = self.shared.interface.signals().iter();
            signals
                .map(|signal| (signal.name.clone(), (signal.first_reference, signal.shape.components().len())))
                .filter(|(_, (_, count))| *count > 1)
                .collect()
        });
        vectors.get(name).copied()
    }

    /// Plant and table, for linear models.
    pub fn parts(&mut self) -> (&mut Plant, Arc<Shared>) {
        (&mut self.plant, Arc::clone(&self.shared))
    }
}

/// A run over given times.
struct Run<'a> {
    simulation: &'a mut Simulation,
    times_s: &'a [f64],
    references: &'a [u32],
    /// Row by row: time, then the variables.
    values: Vec<f64>,
    reached: usize,
    film: Option<Film>,
}

impl<'a> Run<'a> {
    fn new(simulation: &'a mut Simulation, times_s: &'a [f64], references: &'a [u32], view: bool) -> Self {
        let wanted = simulation.shared.interface.needs(references) | OutputSet::JOINTS;
        simulation.plant.watch(if view { OutputSet::ALL } else { wanted });
        let values = vec![0.0; (references.len() + 1) * times_s.len()];
        let film = view.then(|| Film::new(simulation, times_s.len() as u64 - 1));
        Self { simulation, times_s, references, values, reached: 0, film }
    }

    fn through(&mut self, inputs: Option<&InputTable>, progress: &mut Progress) -> PyResult<()> {
        self.feed(inputs, self.times_s[0])?;
        let failed = |error: PlantError| refusal::simulation(&error);
        self.simulation.plant.initialize(self.times_s[0]).map_err(failed)?;
        self.record(self.times_s[0]);
        for pair in self.times_s.windows(2) {
            self.feed(inputs, pair[0])?;
            if let Err(error) = self.simulation.plant.step(pair[1]) {
                let now_s = self.simulation.plant.time_s();
                if now_s > pair[0] {
                    self.record(now_s); // the last successful time
                }
                return Err(failed(error));
            }
            self.record(pair[1]);
            progress.at(self.reached as f64 / self.times_s.len() as f64)?;
        }
        Ok(())
    }

    fn feed(&mut self, inputs: Option<&InputTable>, time_s: f64) -> PyResult<()> {
        let Some(inputs) = inputs else { return Ok(()) };
        let interface = &self.simulation.shared.interface;
        for (row, value) in inputs.table.at(time_s) {
            interface
                .set(&mut self.simulation.plant, interface.variables()[row].value_reference, value)
                .map_err(|error| refusal::usage(format!("input at {time_s} s: {error}")))?;
        }
        Ok(())
    }

    fn record(&mut self, time_s: f64) {
        let Self { simulation, times_s, references, values, reached, film } = self;
        let Simulation { plant, shared, .. } = &**simulation;
        values[*reached] = time_s;
        for (row, &reference) in references.iter().enumerate() {
            let value = shared.interface.get(plant, plant.outputs(), reference);
            values[(row + 1) * times_s.len() + *reached] = value.map_or(f64::NAN, |value| number(&value));
        }
        if let Some(film) = film {
            film.include(plant, shared);
        }
        *reached += 1;
    }
}

/// Data for the page with the animation.
struct Film {
    name: String,
    recording: Recording,
    signals: Signals,
    rows: Vec<u32>,
}

impl Film {
    fn new(simulation: &Simulation, steps: u64) -> Self {
        let outputs = || {
            let rows = simulation.shared.interface.variables().iter();
            rows.filter(|row| row.causality == Causality::Output)
        };
        let columns = outputs().map(|row| (row.name.clone(), row.unit().to_owned()));
        Self {
            name: simulation.shared.machine.name.clone(),
            recording: Recording::new(&simulation.plant, steps, FRAMES),
            signals: Signals::new(columns, steps),
            rows: outputs().map(|row| row.value_reference).collect(),
        }
    }

    fn include(&mut self, plant: &Plant, shared: &Shared) {
        self.recording.include(plant);
        let value = |&row: &u32| shared.interface.get(plant, plant.outputs(), row).map_or(0.0, |value| number(&value));
        self.signals.include(plant.time_s(), self.rows.iter().map(value));
    }

    fn page(&self) -> String {
        page(&self.name, &PackedRun::new(&self.recording, &self.signals, 1), &[])
    }
}

/// Saved simulation state. Opaque; can be pickled.
#[pyclass(frozen, module = "foldwing._native")]
pub struct State {
    shared: Arc<Shared>,
    snapshot: Snapshot,
}

#[pymethods]
impl State {
    /// Restores a state from the bytes of `to_bytes`, for a model.
    #[staticmethod]
    fn from_bytes(model: &Model, bytes: &[u8]) -> PyResult<Self> {
        let damaged = |cause: String| refusal::usage(format!("the saved state is damaged: {cause}"));
        let (owner, snapshot): (String, Snapshot) =
            postcard::from_bytes(bytes).map_err(|error| damaged(error.to_string()))?;
        let own = guid(&model.shared.text, model.shared.interface.variables());
        if owner != own {
            return Err(refusal::usage(format!("the saved state belongs to the model {owner}, not to {own}")));
        }
        Ok(Self { shared: Arc::clone(&model.shared), snapshot })
    }

    /// Serialize to bytes for `from_bytes`, in any process with the same version and model.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let owner = guid(&self.shared.text, self.shared.interface.variables());
        let bytes = postcard::to_stdvec(&(owner, &self.snapshot)).map_err(|error| refusal::usage(error.to_string()))?;
        Ok(PyBytes::new(py, &bytes))
    }
}
