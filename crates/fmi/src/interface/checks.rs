//! Checks of a row before it is read or written.

use crate::interface::access::{AccessError, Kind, Settable, Slot, Stage};
use crate::interface::{Causality, Interface, Value};

impl Interface {
    /// Returns the slot of a row if it can be set to `value` now.
    #[inline]
    pub(super) fn check(&self, reference: u32, value: Value, stage: Stage) -> Result<&Slot, AccessError> {
        let slot = self.typed(reference, value.kind())?;
        let now = match slot.settable {
            Settable::Always => true,
            Settable::Starting => stage == Stage::Starting,
            Settable::Guess => matches!(stage, Stage::Starting | Stage::Exchanging),
            Settable::Never => false,
        };
        // NaN and infinity fail both comparisons: unlimited rows span the finite numbers.
        let fits = match value {
            Value::Real(value) => slot.min <= value && value <= slot.max,
            Value::Integer(_) | Value::Boolean(_) => true,
        };
        if now && fits { Ok(slot) } else { Err(self.refusal(reference, value, slot)) }
    }

    /// Checks a value for a row of the same array as `head`, which has been checked: only values and ranges can differ.
    #[inline]
    pub(super) fn check_beside(&self, head: &Slot, reference: u32, value: Value) -> Result<(), AccessError> {
        match value {
            Value::Real(number) if !(head.min <= number && number <= head.max) => {
                Err(self.refusal(reference, value, head))
            }
            Value::Real(_) | Value::Integer(_) | Value::Boolean(_) => Ok(()),
        }
    }

    /// Checks that all rows have the requested type.
    #[inline]
    pub fn check_kind(&self, references: &[u32], kind: Kind) -> Result<(), AccessError> {
        references.iter().try_for_each(|&reference| self.typed(reference, kind).map(|_| ()))
    }

    #[inline]
    fn typed(&self, reference: u32, requested: Kind) -> Result<&Slot, AccessError> {
        match self.slots.get(reference as usize) {
            Some(slot) if slot.kind == requested => Ok(slot),
            Some(slot) => Err(AccessError::WrongType {
                name: self.variables[reference as usize].name.clone(),
                value_reference: reference,
                actual: slot.kind.name(),
                requested: requested.name(),
            }),
            None => Err(AccessError::UnknownReference {
                value_reference: reference,
                last: self.variables.last().map_or(0, |row| row.value_reference),
            }),
        }
    }

    /// Returns the reason why `value` cannot be set.
    #[cold]
    fn refusal(&self, reference: u32, value: Value, slot: &Slot) -> AccessError {
        let row = &self.variables[reference as usize];
        let name = row.name.clone();
        match (slot.settable, value) {
            (Settable::Never, _) => AccessError::NotSettable {
                name,
                causality: match row.causality {
                    Causality::Independent => "the independent variable",
                    Causality::Local => "a local variable",
                    Causality::Input | Causality::Output | Causality::Parameter => "an output",
                },
            },
            (_, Value::Real(value)) if !value.is_finite() => AccessError::NotFinite { name, value },
            (_, Value::Real(value)) if !(slot.min <= value && value <= slot.max) => {
                AccessError::OutOfRange { name, value, min: slot.min, max: slot.max, unit: row.unit() }
            }
            (Settable::Guess, _) => AccessError::State { name },
            (Settable::Starting | Settable::Always, _) => AccessError::Fixed { name },
        }
    }
}
