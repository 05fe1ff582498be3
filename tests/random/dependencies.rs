//! Declared dependencies of Model Exchange FMUs of random machines. ME-21.

use crate::machine;
use crate::machines::{Model, View};
use foldwing::instance::{Instance, Manner, Request, Setup, Version};
use foldwing::interface::{Causality, Interface, Kind, guid};
use foldwing::packaging::Kinds;
use foldwing::plant::{OutputSet, Plant};
use std::sync::Arc;

/// Distance of the states from the start over their nominal values.
const AWAY: f64 = 1e-3;
/// Bound for entries that are not declared, over the largest entry of their column and the value over the nominal magnitude: 1.5e-9 of round-off
/// of sums of large numbers were found in 187 machines, and none above the bound in 200.
const ROUND_OFF: f64 = 1e-8;

/// Result for one machine.
pub enum Outcome {
    Holds,
    /// The machine has no Model Exchange, or does not start; the reason without names and numbers.
    Without(String),
    Broken(String),
}

/// An instance for Model Exchange in Continuous-Time Mode off its start, with its table, or the reason why there is none.
fn moving(text: &str) -> Result<(Instance, Interface), String> {
    let parsed = Arc::new(foldwing::config::parse(text, "model.toml").map_err(|_| "model file refused".to_owned())?);
    let kinds = Kinds { co_simulation: false, model_exchange: true, ..Kinds::default() };
    kinds.check(&parsed).map_err(|error| error.to_string())?;
    let mut plant = Plant::new(Arc::clone(&parsed));
    plant.watch(OutputSet::NONE);
    plant.system_mut().keep_exchange_accounts(false);
    let table = Interface::with_states(&parsed, &plant);
    let token = guid(text, table.variables());
    let request = Request {
        version: Version::Fmi2,
        name: Some("random"),
        fmu_type: 0,
        guid: Some(&token),
        resource_location: None,
        manner: Manner::default(),
    };
    let mut instance =
        Instance::of_text(&request, text, "model.toml").map_err(|error| format!("no instance: {error}"))?;
    instance
        .setup_experiment(Setup { tolerance: None, start_s: parsed.experiment.start_time_s, stop_s: None })
        .expect("times of the model");
    instance.enter_initialization();
    instance.exit_initialization().map_err(|_| "does not start".to_owned())?;
    instance.new_discrete_states().map_err(|_| "no events at the start".to_owned())?;
    instance.enter_continuous_time();
    let n = instance.state_count();
    let (mut states, mut nominals) = (vec![0.0; n], vec![0.0; n]);
    instance.continuous_states(&mut states).expect("as many as states");
    instance.nominals(&mut nominals).expect("as many as states");
    for (k, (state, nominal)) in states.iter_mut().zip(&nominals).enumerate() {
        // rates of stretch have the nominal magnitude of short waves, far from those of these motions
        *state += AWAY * nominal.min(10.0) * (1.0 + 2.0 * k as f64).sin();
    }
    instance.set_continuous_states(&states).expect("finite");
    Ok((instance, table))
}

/// ME-21. Whatever a derivative of a state or a Real output depends on according to the directional derivatives is declared.
pub fn declared(model: &Model) -> Outcome {
    let text = model.text(&View::plain());
    let (mut instance, table) = match moving(&text) {
        Ok(found) => found,
        Err(reason) => return Outcome::Without(reason),
    };
    let parsed = machine(model, &View::plain()).expect("an instance has it");
    let declared = table.dependencies(&parsed);
    let rows = table.variables();
    let real = rows.iter().filter(|row| row.value.kind() == Kind::Real);
    let (mut unknowns, mut knowns) = (Vec::new(), Vec::new());
    for row in real {
        if row.derivative_of.is_some() || row.causality == Causality::Output {
            unknowns.push(row.value_reference);
        }
        if row.nominal.is_some() || row.causality == Causality::Input {
            knowns.push(row.value_reference);
        }
    }
    let mut values = vec![0.0; unknowns.len()];
    if let Err(error) = instance.get(&unknowns[..], &mut values) {
        return Outcome::Without(format!("no values off the start: {error}"));
    }
    let mut column = vec![0.0; unknowns.len()];
    for &known in &knowns {
        if let Err(error) = instance.directional_derivative((&unknowns, &mut column), (&[known], &[1.0])) {
            return Outcome::Without(format!("no derivatives off the start: {error}"));
        }
        let largest = column.iter().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
        let nominal = rows[known as usize].nominal.unwrap_or(10.0);
        for ((&unknown, &entry), value) in unknowns.iter().zip(&column).zip(&values) {
            let list = &declared[unknown as usize];
            let bound = ROUND_OFF * (largest + value.abs() / (AWAY * nominal));
            if entry.abs() > bound && !list.on_all && !list.running.iter().any(|(row, _)| *row == known) {
                let name = |row: u32| &rows[row as usize].name;
                return Outcome::Broken(format!(
                    "d {} / d {} = {entry:e} is not declared (bound {bound:e})",
                    name(unknown),
                    name(known)
                ));
            }
        }
    }
    Outcome::Holds
}
