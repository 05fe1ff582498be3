//! Many variants of a model on all cores.

use crate::input_table::InputTable;
use crate::model::Model;
use crate::progress::Progress;
use crate::refusal;
use foldwing_command::cli::{SweepPlan, SweepRun};
use pyo3::prelude::*;
use std::num::NonZero;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

/// Names of the columns, and a row of texts for each variant.
type Table = (Vec<String>, Vec<Vec<String>>);

/// Runs all variants; `threads` 0 means one per processor.
#[pyfunction]
#[pyo3(signature = (model, keys, rows, *, times, inputs, outputs, settings, threads, progress))]
#[allow(clippy::too_many_arguments, reason = "named in Python")]
pub fn sweep(
    py: Python<'_>,
    model: &Model,
    keys: Vec<String>,
    rows: Vec<Vec<String>>,
    times: (Option<f64>, Option<f64>, Option<f64>),
    inputs: Option<&InputTable>,
    outputs: Vec<String>,
    settings: Vec<String>,
    threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<Table> {
    let shared = &model.shared;
    let run = SweepRun {
        times_s: [times.0, times.1, times.2],
        inputs: inputs.map(|inputs| inputs.table.clone()),
        outputs,
        settings,
    };
    let of = (Arc::clone(&shared.machine), Arc::clone(&shared.interface));
    let mut progress = Progress::new(progress);
    py.detach(|| {
        let plan = SweepPlan::new((&shared.file, &shared.text), of, keys, rows, run)
            .map_err(|failure| refusal::command(&failure))?;
        let rows = march(&plan, threads, &mut progress)?;
        Ok((plan.columns().to_vec(), rows))
    })
}

/// Rows in the order of the variants. Each free thread runs the next variant; Ctrl-C ends the sweep after the variants in progress.
fn march(plan: &SweepPlan, threads: usize, progress: &mut Progress) -> PyResult<Vec<Vec<String>>> {
    let processors = thread::available_parallelism().map_or(1, NonZero::get);
    let threads = if threads == 0 { processors } else { threads }.min(plan.count());
    let (next, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
    let mut rows = vec![Vec::new(); plan.count()];
    thread::scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        for _ in 0..threads {
            let (sender, next, stopped) = (sender.clone(), &next, &stopped);
            scope.spawn(move || {
                while !stopped.load(Ordering::Relaxed) {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= plan.count() || sender.send((index, plan.run(index))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let mut done = 0;
        loop {
            match receiver.recv_timeout(Duration::from_millis(100)) {
                Ok((index, row)) => {
                    rows[index] = row;
                    done += 1;
                }
                Err(mpsc::RecvTimeoutError::Timeout) => {}
                Err(mpsc::RecvTimeoutError::Disconnected) => return progress.tell(1.0),
            }
            if let Err(error) = progress.at(done as f64 / plan.count() as f64) {
                stopped.store(true, Ordering::Relaxed);
                return Err(error);
            }
        }
    })?;
    Ok(rows)
}
