//! Unknowns and targets of a trim, found by name.

use crate::trim::attitude::Turn;
use crate::trim::error::{TargetError, TrimError, UnknownError};
use crate::values::no_row;
use foldwing_fmi::interface::{Causality, Interface, Value, Variable};

/// An unknown of the trim.
pub enum Unknown<'a> {
    /// The common value of inputs or parameters, which is that of the first one; each has its sign.
    Value { name: String, rows: Vec<(f64, &'a Variable)> },
    /// Attitude angle or turn rate.
    Turn(Turn),
}

impl<'a> Unknown<'a> {
    /// Returns the unknown of this name: a real input or parameter, several with a common value, or an attitude angle or turn rate.
    pub fn of(name: &str, interface: &'a Interface) -> Result<Self, TrimError> {
        if let Some(turn) = Turn::named(name) {
            return Ok(Self::Turn(turn));
        }
        let refused = |error: UnknownError| TrimError::SolveFor { unknown: name.to_owned(), error };
        let signed = |part: &str| {
            let (sign, part) = part.strip_prefix('-').map_or((1.0, part), |part| (-1.0, part));
            let row = interface.find(part).ok_or_else(|| no_row(part, "input or parameter", interface))?;
            let changes = matches!(row.causality, Causality::Input | Causality::Parameter);
            if changes && matches!(row.value, Value::Real(_)) {
                return Ok((sign, row));
            }
            Err(refused(UnknownError::NotSettable))
        };
        let rows = name.split(',').map(|part| signed(part.trim())).collect::<Result<Vec<_>, _>>()?;
        if rows.iter().any(|(_, row)| row.unit() != rows[0].1.unit()) {
            return Err(refused(UnknownError::MixedUnits));
        }
        Ok(Self::Value { name: name.to_owned(), rows })
    }

    /// Its name, as it was given.
    pub fn name(&self) -> &str {
        match self {
            Self::Value { name, .. } => name,
            Self::Turn(turn) => turn.name(),
        }
    }

    /// Its unit.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Value { rows, .. } => rows[0].1.unit(),
            Self::Turn(turn) => turn.unit(),
        }
    }
}

/// Output with its target value.
pub struct Balance<'a> {
    /// The output.
    pub row: &'a Variable,
    /// Its target in SI units.
    pub target: f64,
}

impl<'a> Balance<'a> {
    /// A real output with a finite target.
    pub fn of(output: &str, target: f64, interface: &'a Interface) -> Result<Self, TrimError> {
        let refused = |error: TargetError| TrimError::Target { output: output.to_owned(), value: target, error };
        let row = interface.find(output).ok_or_else(|| no_row(output, "output", interface))?;
        if row.causality != Causality::Output || !matches!(row.value, Value::Real(_)) {
            return Err(refused(TargetError::NotAnOutput));
        }
        if !target.is_finite() {
            return Err(refused(TargetError::NotFinite));
        }
        Ok(Self { row, target })
    }
}

/// Checks that unknowns and targets are named once: a second one would have no effect, or contradict the first.
pub fn refuse_repeated(unknowns: &[Unknown], balances: &[Balance]) -> Result<(), TrimError> {
    let twice = |name: &str| TrimError::SolveFor { unknown: name.to_owned(), error: UnknownError::Repeated };
    let (mut rows, mut turns) = (Vec::new(), Vec::new());
    for unknown in unknowns {
        match unknown {
            Unknown::Value { rows: own, .. } => {
                for (_, row) in own {
                    if rows.contains(&row.value_reference) {
                        return Err(twice(&row.name));
                    }
                    rows.push(row.value_reference);
                }
            }
            Unknown::Turn(turn) => {
                if turns.contains(turn) {
                    return Err(twice(turn.name()));
                }
                turns.push(*turn);
            }
        }
    }
    let mut outputs = Vec::new();
    for Balance { row, target } in balances {
        if outputs.contains(&row.value_reference) {
            let error = TargetError::Repeated;
            return Err(TrimError::Target { output: row.name.clone(), value: *target, error });
        }
        outputs.push(row.value_reference);
    }
    Ok(())
}
