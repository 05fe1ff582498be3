//! Variables of FMI 3.0: rows of the table under one name, in row-major order.

use crate::interface::access::Kind;
use crate::interface::{AccessError, Dependencies, DependencyKind, Interface, MAXIMUM_LISTED, Shape, Signal, Variable};
use sha2::{Digest, Sha256};
use std::collections::HashMap;

/// Variable of FMI 3.0. Its rows have the same type, causality, variability, unit and range.
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// Name, such as `load.wing.force`.
    pub name: String,
    /// One sentence.
    pub description: String,
    /// Lengths; empty for a scalar.
    pub dimensions: Vec<usize>,
    /// Its rows in the table, the last dimension fastest.
    pub rows: Vec<u32>,
}

/// All variables of a table for FMI 3.0: the position of a variable is its value reference.
pub(super) struct Arrays {
    arrays: Vec<Array>,
    /// Per row, its array.
    of_row: Vec<u32>,
}

impl Arrays {
    /// Combines the signals of each array at the position of the first one.
    pub fn new(signals: &[Signal]) -> Self {
        let mut arrays: Vec<Array> = Vec::new();
        let mut counts: Vec<usize> = Vec::new();
        let mut known: HashMap<&str, usize> = HashMap::new();
        for signal in signals {
            let components = u32::try_from(signal.shape.components().len()).unwrap_or(u32::MAX);
            let rows = signal.first_reference..signal.first_reference + components;
            let name = signal.array.as_ref().map(|array| array.name.as_str());
            match name.and_then(|name| known.get(name)) {
                Some(&at) => {
                    arrays[at].rows.extend(rows);
                    counts[at] += 1;
                }
                None => {
                    if let Some(name) = name {
                        known.insert(name, arrays.len());
                    }
                    let (name, meaning) = match &signal.array {
                        Some(array) => (&array.name, &array.meaning),
                        None => (&signal.name, &signal.meaning),
                    };
                    let mut dimensions = Vec::new();
                    if signal.array.is_some() {
                        dimensions.push(0);
                    }
                    if signal.shape != Shape::Scalar {
                        dimensions.push(signal.shape.components().len());
                    }
                    let description = meaning.replace("{}", &signal.shape.components().join(" "));
                    arrays.push(Array { name: name.clone(), description, dimensions, rows: rows.collect() });
                    counts.push(1);
                }
            }
        }
        let mut of_row = vec![0; arrays.iter().map(|array| array.rows.len()).sum()];
        for (number, (array, count)) in (0..).zip(arrays.iter_mut().zip(counts)) {
            // the length is the first dimension, and only arrays of signals have it
            if let Some(length) = array.dimensions.first_mut().filter(|length| **length == 0) {
                *length = count;
            }
            array.rows.iter().for_each(|&row| of_row[row as usize] = number);
        }
        Self { arrays, of_row }
    }
}

impl Arrays {
    /// Makes every row a scalar variable.
    pub fn scalars(rows: &[Variable]) -> Self {
        let of = |row: &Variable| Array {
            name: row.name.clone(),
            description: row.description.clone(),
            dimensions: Vec::new(),
            rows: vec![row.value_reference],
        };
        Self { arrays: rows.iter().map(of).collect(), of_row: rows.iter().map(|row| row.value_reference).collect() }
    }
}

/// Rows selected by a call, in the order of its values.
pub trait Selection: Copy {
    /// The rows of a block have the same properties, so that checking the first one is enough.
    const ALIKE: bool;

    /// The rows, in blocks. [`Selection::check`] has verified that every block exists.
    fn blocks<'a>(self, interface: &'a Interface) -> impl Iterator<Item = &'a [u32]> + Clone
    where
        Self: 'a;

    /// Fails for rows that do not exist or have another type, and if the number of values differs from `count`.
    fn check(self, interface: &Interface, kind: Kind, count: usize) -> Result<(), AccessError>;

    /// Rows that represent the selection in checks.
    fn heads<'a>(self, interface: &'a Interface) -> impl Iterator<Item = u32>
    where
        Self: 'a,
    {
        let take = if Self::ALIKE { 1 } else { usize::MAX };
        self.blocks(interface).flat_map(move |block| block.iter().take(take).copied())
    }
}

/// Rows selected by their value references of FMI 2.0. There are as many values as rows.
impl Selection for &[u32] {
    const ALIKE: bool = false;

    fn blocks<'a>(self, _: &'a Interface) -> impl Iterator<Item = &'a [u32]> + Clone
    where
        Self: 'a,
    {
        std::iter::once(self)
    }

    #[inline]
    fn check(self, interface: &Interface, kind: Kind, _: usize) -> Result<(), AccessError> {
        interface.check_kind(self, kind)
    }
}

/// Arrays selected by their value references of FMI 3.0.
#[derive(Debug, Clone, Copy)]
pub struct Whole<'a>(pub &'a [u32]);

impl Selection for Whole<'_> {
    const ALIKE: bool = true;

    fn blocks<'a>(self, interface: &'a Interface) -> impl Iterator<Item = &'a [u32]> + Clone
    where
        Self: 'a,
    {
        self.0.iter().map(|&reference| interface.array_rows(reference))
    }

    #[inline]
    fn check(self, interface: &Interface, kind: Kind, count: usize) -> Result<(), AccessError> {
        let mut own = 0;
        for &reference in self.0 {
            interface.check_array_type(reference, kind.name_of_fmi3())?;
            own += interface.array_rows(reference).len();
        }
        if own == count { Ok(()) } else { Err(AccessError::Count { given: count, variables: self.0.len(), own }) }
    }
}

impl Interface {
    /// The variables of FMI 3.0; a variable's position is its value reference.
    pub fn arrays(&self) -> &[Array] {
        &self.arrays.arrays
    }

    /// Row that represents an array: its rows differ in name, description and start value only.
    pub fn head(&self, array: &Array) -> &Variable {
        &self.variables[array.rows[0] as usize]
    }

    /// Value reference in FMI 3.0 of the array that contains a row.
    pub fn array_of(&self, row: u32) -> u32 {
        self.arrays.of_row[row as usize]
    }

    /// Rows of an array; none if it does not exist.
    #[inline]
    fn array_rows(&self, reference: u32) -> &[u32] {
        self.arrays.arrays.get(reference as usize).map_or(&[], |array| &array.rows)
    }

    /// Fails for arrays that do not exist or have another type than `requested`, a name of FMI 3.0.
    pub fn check_array_type(&self, reference: u32, requested: &'static str) -> Result<(), AccessError> {
        let Some(array) = self.arrays.arrays.get(reference as usize) else {
            let last = u32::try_from(self.arrays.arrays.len()).unwrap_or(u32::MAX).saturating_sub(1);
            return Err(AccessError::UnknownReference { value_reference: reference, last });
        };
        let actual = self.slots[array.rows[0] as usize].kind.name_of_fmi3();
        if actual == requested {
            return Ok(());
        }
        Err(AccessError::WrongType { name: array.name.clone(), value_reference: reference, actual, requested })
    }

    /// Dependencies of each array, combined from those of its rows in [`Interface::dependencies`]; references are those of FMI 3.0.
    pub fn array_dependencies(&self, of_rows: &[Dependencies]) -> Vec<Dependencies> {
        let joined = |lists: &mut dyn Iterator<Item = &[(u32, DependencyKind)]>| {
            let mut found: Vec<(u32, DependencyKind)> = Vec::new();
            let mut places: HashMap<u32, usize> = HashMap::new();
            for &(row, kind) in lists.flatten() {
                let array = self.array_of(row);
                let place = *places.entry(array).or_insert_with(|| {
                    found.push((array, kind));
                    found.len() - 1
                });
                if found[place].1 != kind {
                    found[place].1 = DependencyKind::Dependent;
                }
            }
            // some elements of one array may not depend on every element of the other
            found.iter_mut().filter(|(_, kind)| *kind == DependencyKind::Constant).for_each(|(array, kind)| {
                if self.arrays.arrays[*array as usize].rows.len() > 1 {
                    *kind = DependencyKind::Dependent;
                }
            });
            found.sort_by_key(|(array, _)| *array);
            found
        };
        let of = |array: &Array| {
            let rows = || array.rows.iter().map(|&row| &of_rows[row as usize]);
            if rows().any(|row| row.on_all) {
                return Dependencies { on_all: true, ..Dependencies::default() };
            }
            let running = joined(&mut rows().map(|row| row.running.as_slice()));
            let initial = joined(&mut rows().map(|row| row.initial.as_slice()));
            let on_all = running.len().max(initial.len()) > MAXIMUM_LISTED;
            if on_all {
                Dependencies { on_all, ..Dependencies::default() }
            } else {
                Dependencies { running, initial, on_all }
            }
        };
        self.arrays.arrays.iter().map(of).collect()
    }

    /// Instantiation token of FMI 3.0: a hash of the model file and of the arrays, in the form of [`crate::interface::guid`]. It differs
    /// from the GUID of the same table in FMI 2.0.
    pub fn instantiation_token(&self, model_text: &str) -> String {
        let mut hash = Sha256::new();
        hash.update(crate::interface::guid(model_text, &self.variables).as_bytes());
        for array in &self.arrays.arrays {
            hash.update(format!("\0{} {:?} {:?}", array.name, array.dimensions, array.rows).as_bytes());
        }
        crate::interface::guid::form(&hash.finalize())
    }
}
