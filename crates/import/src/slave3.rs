//! Instance of a foreign FMU of FMI 3.0, from set-up to termination, without Event Mode and early return.

use crate::description::{Datum, NativeType, Variable};
use crate::error::{CallError, Fault};
use crate::step::Step;
use fmi::fmi3::instance::InstanceCS;
use fmi::fmi3::{CoSimulation, Common, Fmi3Error, Fmi3Res, GetSet};
use foldwing_fmi::interface::Value;
use std::collections::HashMap;
use std::ffi::CString;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// An instance. It is terminated and freed when dropped, if its last status allows this.
pub struct Slave3 {
    /// `None` only while the instance is dropped.
    instance: Option<InstanceCS>,
    /// Tolerance, start and stop time in s.
    experiment: (Option<f64>, f64, f64),
    /// Values set last for the elements of each array, by value reference, because an array can only be set as a whole.
    held: HashMap<u32, Vec<Datum>>,
    stepping: bool,
    failed: Option<Fault>,
    warnings: u64,
}

impl fmt::Debug for Slave3 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Slave3").field("warnings", &self.warnings).finish_non_exhaustive()
    }
}

/// Arrays of one type, concatenated.
#[derive(Debug)]
struct List<T> {
    references: Vec<u32>,
    values: Vec<T>,
}

impl<T> Default for List<T> {
    fn default() -> Self {
        Self { references: Vec::new(), values: Vec::new() }
    }
}

impl<T: Default + Clone> List<T> {
    /// Appends an array; returns the index of its first element.
    fn push(&mut self, reference: u32, length: usize) -> usize {
        let begin = self.values.len();
        self.references.push(reference);
        self.values.resize(begin + length, T::default());
        begin
    }
}

/// Converts an integer to a smaller type; values out of range have already been rejected by the parser.
macro_rules! narrowed {
    ($value:expr, $type:ty) => {
        $value.clamp(i128::from(<$type>::MIN), i128::from(<$type>::MAX)) as $type
    };
}

macro_rules! natives {
    ($($variant:ident $field:ident $type:ty, $get:ident $get_name:literal, $set:ident $set_name:literal,
        $out:expr, $in:expr;)*) => {
        /// Variables that are read together, and their last values.
        #[derive(Debug, Default)]
        pub struct Readout3 {
            /// Type and index among the values of that type, in the order of the variables.
            places: Vec<(NativeType, usize)>,
            strings: List<CString>,
            $($field: List<$type>,)*
        }

        impl Readout3 {
            /// Creates the readout of variables, in the given order.
            pub fn new<'a>(variables: impl IntoIterator<Item = &'a Variable>) -> Self {
                let mut readout = Self::default();
                let mut begins: HashMap<u32, usize> = HashMap::new();
                for variable in variables {
                    let Some(element) = variable.element else { continue };
                    let (reference, length) = (variable.value_reference, element.length);
                    let begin = *begins.entry(reference).or_insert_with(|| match element.native {
                        $(NativeType::$variant => readout.$field.push(reference, length),)*
                        NativeType::String => readout.strings.push(reference, length),
                        NativeType::Binary | NativeType::Clock => 0,
                    });
                    readout.places.push((element.native, begin + element.place));
                }
                readout
            }

            /// Last values, in the order of the variables.
            pub fn values(&self) -> impl Iterator<Item = Datum> + '_ {
                self.places.iter().map(|&(native, at)| match native {
                    $(NativeType::$variant => $out(self.$field.values[at]),)*
                    NativeType::String => Datum::Text(self.strings.values[at].to_string_lossy().into_owned()),
                    NativeType::Binary | NativeType::Clock => Datum::Text(String::new()),
                })
            }
        }

        impl Slave3 {
            /// Reads variables.
            ///
            /// # Errors
            /// The status of the FMU.
            pub fn read(&mut self, readout: &mut Readout3) -> Result<(), CallError> {
                $(if !readout.$field.references.is_empty() {
                    let List { references, values } = &mut readout.$field;
                    self.call(|| $get_name.to_owned(), |instance| instance.$get(references, values))?;
                })*
                let List { references, values } = &mut readout.strings;
                if !references.is_empty() {
                    let get = |instance: &mut InstanceCS| instance.get_string(references, values).map(|()| Fmi3Res::OK);
                    self.call(|| "fmi3GetString".to_owned(), get)?;
                }
                Ok(())
            }

            /// Sets a whole variable.
            fn send(&mut self, variable: &Variable, native: NativeType, values: &[Datum]) -> Result<(), CallError> {
                let reference = [variable.value_reference];
                let shown = || {
                    let shown: Vec<String> = values.iter().map(ToString::to_string).collect();
                    format!("{} to {}", variable.array_name(), shown.join(" "))
                };
                match native {
                    $(NativeType::$variant => {
                        let values: Vec<$type> = values.iter().map(|value| $in(value)).collect();
                        let set = |instance: &mut InstanceCS| instance.$set(&reference, &values);
                        self.call(|| format!("{} of {}", $set_name, shown()), set)
                    })*
                    NativeType::String => {
                        let text = |value: &Datum| CString::new(value.to_string().replace('\0', " ")).unwrap_or_default();
                        let texts: Vec<CString> = values.iter().map(text).collect();
                        let set = |instance: &mut InstanceCS| instance.set_string(&reference, &texts).map(|()| Fmi3Res::OK);
                        self.call(|| format!("fmi3SetString of {}", shown()), set)
                    }
                    // no value can be given for these types
                    NativeType::Binary | NativeType::Clock => Ok(()),
                }
            }
        }

        /// Sets a value and reads it again; `None` for types that are not numbers.
        #[cfg(test)]
        fn set_and_read(native: NativeType, value: &Datum) -> Option<Datum> {
            match native {
                $(NativeType::$variant => {
                    let value: $type = $in(value);
                    Some($out(value))
                })*
                NativeType::String | NativeType::Binary | NativeType::Clock => None,
            }
        }
    };
}

natives! {
    Float32 float32 f32, get_float32 "fmi3GetFloat32", set_float32 "fmi3SetFloat32",
        |value| Datum::Number(Value::Real(f64::from(value))), |value: &Datum| value.real() as f32;
    Float64 float64 f64, get_float64 "fmi3GetFloat64", set_float64 "fmi3SetFloat64",
        |value| Datum::Number(Value::Real(value)), Datum::real;
    Int8 int8 i8, get_int8 "fmi3GetInt8", set_int8 "fmi3SetInt8",
        |value| Datum::whole(i128::from(value)), |value: &Datum| narrowed!(value.integer(), i8);
    UInt8 uint8 u8, get_uint8 "fmi3GetUInt8", set_uint8 "fmi3SetUInt8",
        |value| Datum::whole(i128::from(value)), |value: &Datum| narrowed!(value.integer(), u8);
    Int16 int16 i16, get_int16 "fmi3GetInt16", set_int16 "fmi3SetInt16",
        |value| Datum::whole(i128::from(value)), |value: &Datum| narrowed!(value.integer(), i16);
    UInt16 uint16 u16, get_uint16 "fmi3GetUInt16", set_uint16 "fmi3SetUInt16",
        |value| Datum::whole(i128::from(value)), |value: &Datum| narrowed!(value.integer(), u16);
    Int32 int32 i32, get_int32 "fmi3GetInt32", set_int32 "fmi3SetInt32",
        |value| Datum::whole(i128::from(value)), |value: &Datum| narrowed!(value.integer(), i32);
    UInt32 uint32 u32, get_uint32 "fmi3GetUInt32", set_uint32 "fmi3SetUInt32",
        |value| Datum::whole(i128::from(value)), |value: &Datum| narrowed!(value.integer(), u32);
    Int64 int64 i64, get_int64 "fmi3GetInt64", set_int64 "fmi3SetInt64",
        |value| Datum::whole(i128::from(value)), |value: &Datum| narrowed!(value.integer(), i64);
    UInt64 uint64 u64, get_uint64 "fmi3GetUInt64", set_uint64 "fmi3SetUInt64",
        |value| Datum::whole(i128::from(value)), |value: &Datum| narrowed!(value.integer(), u64);
    Boolean boolean bool, get_boolean "fmi3GetBoolean", set_boolean "fmi3SetBoolean",
        |value| Datum::Number(Value::Boolean(value)), |value: &Datum| *value == Datum::Number(Value::Boolean(true));
}

impl Slave3 {
    /// Creates the wrapper of an instance; `variables` are those of its description.
    pub(super) fn new(instance: InstanceCS, variables: &[Variable]) -> Self {
        let mut held: HashMap<u32, Vec<Datum>> = HashMap::new();
        for variable in variables.iter().filter(|variable| variable.settable) {
            let Some(element) = variable.element.filter(|element| element.length > 1) else { continue };
            // aliases have the same value reference
            let whole = held.entry(variable.value_reference).or_insert_with(|| vec![Datum::whole(0); element.length]);
            if let Some(place) = whole.get_mut(element.place) {
                *place = variable.start_value();
            }
        }
        let experiment = (None, 0.0, 0.0);
        Self { instance: Some(instance), experiment, held, stepping: false, failed: None, warnings: 0 }
    }

    /// Number of calls with `fmi3Warning` so far.
    pub fn warnings(&self) -> u64 {
        self.warnings
    }

    /// Stores the times in s and, if given, the tolerance; [`Slave3::enter_initialization`] passes them to the FMU.
    pub fn set_up(&mut self, tolerance: Option<f64>, start_s: f64, stop_s: f64) {
        self.experiment = (tolerance, start_s, stop_s);
    }

    /// Enters Initialization Mode.
    ///
    /// # Errors
    /// The status of the FMU.
    pub fn enter_initialization(&mut self) -> Result<(), CallError> {
        let (tolerance, start_s, stop_s) = self.experiment;
        let enter =
            |instance: &mut InstanceCS| Common::enter_initialization_mode(instance, tolerance, start_s, Some(stop_s));
        self.call(|| "fmi3EnterInitializationMode".to_owned(), enter)
    }

    /// Leaves Initialization Mode; steps may follow.
    ///
    /// # Errors
    /// The status of the FMU.
    pub fn exit_initialization(&mut self) -> Result<(), CallError> {
        self.call(|| "fmi3ExitInitializationMode".to_owned(), Common::exit_initialization_mode)?;
        self.stepping = true;
        Ok(())
    }

    /// Sets variables, each array once.
    ///
    /// # Errors
    /// The status of the FMU, with the name of the variable and its values.
    pub fn set<'a>(&mut self, values: impl IntoIterator<Item = (&'a Variable, Datum)>) -> Result<(), CallError> {
        let mut touched: Vec<&Variable> = Vec::new();
        for (variable, value) in values {
            let Some(element) = variable.element else { continue };
            match self.held.get_mut(&variable.value_reference).and_then(|held| held.get_mut(element.place)) {
                Some(place) => {
                    *place = value;
                    if touched.iter().all(|other| other.value_reference != variable.value_reference) {
                        touched.push(variable);
                    }
                }
                None => self.send(variable, element.native, &[value])?,
            }
        }
        for variable in touched {
            let values = self.held.get(&variable.value_reference).cloned().unwrap_or_default();
            if let Some(element) = variable.element {
                self.send(variable, element.native, &values)?;
            }
        }
        Ok(())
    }

    /// Performs a step from a communication point.
    ///
    /// # Errors
    /// The status of the FMU, or an early return without permission.
    pub fn step(&mut self, time_s: f64, step_s: f64) -> Result<Step, CallError> {
        let (mut event, mut end, mut early, mut last_s) = (false, false, false, time_s + step_s);
        let step = |instance: &mut InstanceCS| {
            instance.do_step(time_s, step_s, true, &mut event, &mut end, &mut early, &mut last_s)
        };
        self.call(|| format!("fmi3DoStep from {time_s} s"), step)?;
        if end {
            return Ok(Step::Ended(last_s));
        }
        if early && last_s < time_s + step_s {
            let call = format!(
                "fmi3DoStep from {time_s} s: it ended early, at {last_s} s, although early return was not allowed"
            );
            return Err(CallError { call, fault: Fault::Early });
        }
        Ok(Step::Done)
    }

    /// The only function that converts a status of the FMU to a `Result`. A status after which no call is allowed is stored.
    fn call(
        &mut self,
        name: impl FnOnce() -> String,
        body: impl FnOnce(&mut InstanceCS) -> Result<Fmi3Res, Fmi3Error>,
    ) -> Result<(), CallError> {
        let instance = self.instance.as_mut().expect("taken by drop only");
        // the crate panics on a status that the standard does not define
        let fault = match catch_unwind(AssertUnwindSafe(|| body(instance))) {
            Ok(Ok(Fmi3Res::OK)) => return Ok(()),
            Ok(Ok(Fmi3Res::Warning)) => {
                self.warnings += 1;
                return Ok(());
            }
            Ok(Err(Fmi3Error::Discard)) => Fault::Discard,
            Ok(Err(Fmi3Error::Error)) => Fault::Error,
            Ok(Err(Fmi3Error::Fatal)) => Fault::Fatal,
            Err(_) => Fault::Other,
        };
        if fault != Fault::Discard {
            self.failed = Some(fault);
        }
        Err(CallError { call: name(), fault })
    }
}

impl Drop for Slave3 {
    fn drop(&mut self) {
        let Some(mut instance) = self.instance.take() else { return };
        match self.failed {
            None if self.stepping => {
                // the status no longer has any effect
                let _ = catch_unwind(AssertUnwindSafe(|| instance.terminate()));
            }
            None | Some(Fault::Discard | Fault::Error | Fault::Early) => {}
            // after fmi3Fatal not even fmi3FreeInstance may be called
            Some(Fault::Fatal | Fault::Other) => std::mem::forget(instance),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integers of every type are set and read unchanged at and next to the limits of their range, and saturate beyond; the limits are
    /// also the range of the variables.
    #[test]
    fn whole_numbers_have_the_range_of_their_type() {
        for (native, bits, signed) in [
            (NativeType::Int8, 8, true),
            (NativeType::UInt8, 8, false),
            (NativeType::Int16, 16, true),
            (NativeType::UInt16, 16, false),
            (NativeType::Int32, 32, true),
            (NativeType::UInt32, 32, false),
            (NativeType::Int64, 64, true),
            (NativeType::UInt64, 64, false),
        ] {
            let values = 1_i128 << bits;
            let least = if signed { -values / 2 } else { 0 };
            let most = least + values - 1;
            let passed = |value: i128| set_and_read(native, &Datum::whole(value)).expect("a number");
            for value in [least, least + 1, least / 2, 0, 1, most / 2, most / 2 + 1, most - 1, most] {
                assert_eq!(passed(value), Datum::whole(value), "{native:?}");
            }
            for (value, end) in [(least - 1, least), (2 * least - 2, least), (most + 1, most), (2 * most + 2, most)] {
                assert_eq!(passed(value), Datum::whole(end), "{native:?}: {value}");
            }
            // the 64-bit limits are not representable as reals: the nearest reals are used
            assert_eq!(native.bounds(), (Some(least as f64), Some(most as f64)), "{native:?}");
        }
    }

    /// Reals and Booleans are set and read unchanged; single-precision values are rounded.
    #[test]
    fn reals_and_booleans_are_set_as_they_are() {
        for value in [0.0, -1.5, 0.1, f64::MAX, f64::MIN_POSITIVE] {
            let real = |value: f64| Datum::Number(Value::Real(value));
            assert_eq!(set_and_read(NativeType::Float64, &real(value)), Some(real(value)));
            assert_eq!(set_and_read(NativeType::Float32, &real(value)), Some(real(f64::from(value as f32))));
        }
        for value in [false, true] {
            let boolean = Datum::Number(Value::Boolean(value));
            assert_eq!(set_and_read(NativeType::Boolean, &boolean), Some(boolean));
        }
    }
}
