//! Inputs, parameters and outputs as flat vectors of numbers, with typed views of them.
//!
//! All inputs, all parameters and all outputs are one `Vec<f64>` each: sums, comparisons, saving and differentiation are loops over
//! numbers. A [`Segment`] locates values of one type and gives access to them as a slice of that type without a copy. Names, units,
//! descriptions and dependencies are defined in the table of the module that exposes the values.

mod inputs;
mod parameters;

pub use inputs::{DcMotorInputs, FlapInputs, InputLayout, Inputs, JointInputs};
pub use parameters::{
    BodyParameters, FACTOR_RANGE, JointParameters, ParameterLayout, Parameters, SolverParameters, SpatialParameters,
};

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};
use std::marker::PhantomData;

/// Location of consecutive values of type `T` in a flat vector.
///
/// `T` consists of `f64` fields only, in the order of their declaration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Segment<T> {
    start: usize,
    count: usize,
    #[serde(skip)]
    of: PhantomData<fn() -> T>,
}

impl<T: Pod> Segment<T> {
    /// Number of `f64` entries in one value.
    const WIDTH: usize = size_of::<T>() / size_of::<f64>();

    /// Creates a segment of `count` values that starts at `end`, and advances `end` past it.
    pub fn append(end: &mut usize, count: usize) -> Self {
        let start = *end;
        *end += count * Self::WIDTH;
        Self { start, count, of: PhantomData }
    }

    /// Number of values.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Index range of the values in the vector.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.start..self.start + self.count * Self::WIDTH
    }

    /// The values as a slice.
    #[inline]
    pub fn view<'a>(&self, vector: &'a [f64]) -> &'a [T] {
        bytemuck::cast_slice(&vector[self.range()])
    }

    /// The values as a mutable slice.
    #[inline]
    pub fn view_mut<'a>(&self, vector: &'a mut [f64]) -> &'a mut [T] {
        bytemuck::cast_slice_mut(&mut vector[self.range()])
    }

    /// Index in the vector of the number at `offset_bytes` (see [`std::mem::offset_of!`]) in value `index`.
    ///
    /// # Panics
    /// If `index` is out of range.
    pub fn place(&self, index: usize, offset_bytes: usize) -> usize {
        assert!(index < self.count, "value {index} of {}", self.count);
        self.start + index * Self::WIDTH + offset_bytes / size_of::<f64>()
    }
}

/// Shared and mutable views of the segments of a vector: first segments with many values, then, after `;`, those with one.
macro_rules! views {
    (
        ($visibility:vis)
        $($(#[$doc:meta])* $name:ident, $name_mut:ident: [$type:ty];)* ;
        $($(#[$one_doc:meta])* $one:ident, $one_mut:ident: $one_type:ty;)*
    ) => {
        $(
            $(#[$doc])*
            #[inline]
            pub fn $name(&self) -> &[$type] {
                self.layout.$name.view(&self.values)
            }

            #[doc = concat!("[`Self::", stringify!($name), "`], to be changed.")]
            #[inline]
            $visibility fn $name_mut(&mut self) -> &mut [$type] {
                self.layout.$name.view_mut(&mut self.values)
            }
        )*
        $(
            $(#[$one_doc])*
            #[inline]
            pub fn $one(&self) -> &$one_type {
                &self.layout.$one.view(&self.values)[0]
            }

            #[doc = concat!("[`Self::", stringify!($one), "`], to be changed.")]
            #[inline]
            $visibility fn $one_mut(&mut self) -> &mut $one_type {
                &mut self.layout.$one.view_mut(&mut self.values)[0]
            }
        )*
    };
}
pub(crate) use views;

/// A switch stored as a number: 1 or 0.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable, Serialize, Deserialize)]
#[repr(transparent)]
pub struct Switch(f64);

impl Switch {
    /// Switched on.
    pub const ON: Self = Self(1.0);
    /// Switched off.
    pub const OFF: Self = Self(0.0);

    /// Whether the number is 1 or 0.
    pub(crate) fn is_valid(self) -> bool {
        self == Self::ON || self == Self::OFF
    }

    /// Whether the switch is on.
    #[inline]
    pub fn is_on(self) -> bool {
        self.0 != 0.0
    }
}

impl From<bool> for Switch {
    fn from(on: bool) -> Self {
        if on { Self::ON } else { Self::OFF }
    }
}

/// An integer stored as a floating-point number.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(transparent)]
pub struct Count(f64);

impl Count {
    /// Zero.
    pub const NONE: Self = Self(0.0);

    /// The integer.
    pub fn get(self) -> i32 {
        self.0 as i32
    }
}

impl From<i32> for Count {
    fn from(count: i32) -> Self {
        Self(f64::from(count))
    }
}

/// Whether all numbers are finite.
pub(crate) fn are_finite(values: &[f64]) -> bool {
    values.iter().all(|value| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::Wrench;
    use std::mem::offset_of;

    #[test]
    fn segments_follow_each_other_and_read_what_was_written() {
        let mut end = 0;
        let first: Segment<Wrench> = Segment::append(&mut end, 2);
        let second: Segment<Switch> = Segment::append(&mut end, 3);
        assert_eq!(end, 2 * 6 + 3);
        let mut vector: Vec<f64> = (0..end).map(|i| i as f64).collect();
        assert_eq!(first.view(&vector)[1].moment_n_m.as_slice(), [9.0, 10.0, 11.0]);
        assert_eq!(first.place(1, offset_of!(Wrench, moment_n_m)), 9);
        second.view_mut(&mut vector)[2] = true.into();
        assert_eq!((vector[14], second.place(2, 0)), (1.0, 14));
        assert_eq!([0, -3, i32::MAX].map(|count| Count::from(count).get()), [0, -3, i32::MAX]);
    }

    #[test]
    #[should_panic(expected = "value 2 of 2")]
    fn a_place_beyond_a_segment_is_refused() {
        let segment: Segment<f64> = Segment::append(&mut 5, 2);
        segment.place(2, 0);
    }
}
