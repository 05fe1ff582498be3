//! Exported functions that get and set values.

use super::types::{
    fmi3Binary, fmi3Boolean, fmi3Clock, fmi3Float32, fmi3Float64, fmi3Instance, fmi3Int8, fmi3Int16, fmi3Int32,
    fmi3Int64, fmi3Status, fmi3String, fmi3UInt8, fmi3UInt16, fmi3UInt32, fmi3UInt64, fmi3ValueReference,
};
use crate::{enter, slice, slice_mut};
use foldwing_fmi::fmi3::Call;
use foldwing_fmi::interface::{Kind, Scalar, Value, Whole};

/// A Boolean from C: any byte but 0 is true.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(transparent)]
struct Flag(u8);

impl Scalar for Flag {
    const KIND: Kind = Kind::Boolean;

    fn into_value(self) -> Value {
        Value::Boolean(self.0 != 0)
    }

    fn from_value(value: Value) -> Option<Self> {
        bool::from_value(value).map(|value| Self(u8::from(value)))
    }
}

/// Getter and setter of a type with variables; `$seen` is the corresponding Rust type.
macro_rules! values {
    ($($get:ident $get_call:ident $set:ident $set_call:ident $type:ty as $seen:ty;)*) => { $(
        /// Reads variables of the type in its name, arrays row by row.
        ///
        /// # Safety
        /// `instance` is null or came from an instantiation and has not been freed; the arrays hold as many entries as given by the counts
        /// after them.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(
            instance: fmi3Instance,
            references: *const fmi3ValueReference,
            n_references: usize,
            values: *mut $type,
            n_values: usize,
        ) -> fmi3Status {
            // SAFETY: forwarded from the caller.
            unsafe {
                enter(instance, Call::$get_call, |instance| {
                    let references = Whole(slice(references, n_references, "valueReferences")?);
                    instance.get(references, slice_mut(values.cast::<$seen>(), n_values, "values")?)
                })
            }
        }

        /// Sets inputs and parameters of the type in its name, arrays row by row: all of them or, on an error, none.
        ///
        /// # Safety
        /// `instance` is null or came from an instantiation and has not been freed; the arrays hold as many entries as given by the counts
        /// after them.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(
            instance: fmi3Instance,
            references: *const fmi3ValueReference,
            n_references: usize,
            values: *const $type,
            n_values: usize,
        ) -> fmi3Status {
            // SAFETY: forwarded from the caller.
            unsafe {
                enter(instance, Call::$set_call, |instance| {
                    let references = Whole(slice(references, n_references, "valueReferences")?);
                    instance.set(references, slice(values.cast::<$seen>(), n_values, "values")?)
                })
            }
        }
    )* };
}

values! {
    fmi3GetFloat64 GetFloat64 fmi3SetFloat64 SetFloat64 fmi3Float64 as f64;
    fmi3GetInt32 GetInt32 fmi3SetInt32 SetInt32 fmi3Int32 as i32;
    fmi3GetBoolean GetBoolean fmi3SetBoolean SetBoolean fmi3Boolean as Flag;
}

/// Getter or setter of a type without variables.
macro_rules! no_values {
    ($($function:ident $call:ident $of:literal ($($argument:ident: $type:ty),*);)*) => { $(
        /// Fails unless there are no value references: no variable has the type in the name.
        ///
        /// # Safety
        /// `instance` is null or came from an instantiation and has not been freed; `references` holds `n_references` entries.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $function(
            instance: fmi3Instance,
            references: *const fmi3ValueReference,
            n_references: usize,
            $($argument: $type),*
        ) -> fmi3Status {
            // SAFETY: forwarded from the caller.
            unsafe {
                enter(instance, Call::$call, |instance| {
                    instance.none_of_type(slice(references, n_references, "valueReferences")?, $of)
                })
            }
        }
    )* };
}

no_values! {
    fmi3GetFloat32 GetFloat32 "Float32" (_values: *mut fmi3Float32, _n_values: usize);
    fmi3GetInt8 GetInt8 "Int8" (_values: *mut fmi3Int8, _n_values: usize);
    fmi3GetUInt8 GetUInt8 "UInt8" (_values: *mut fmi3UInt8, _n_values: usize);
    fmi3GetInt16 GetInt16 "Int16" (_values: *mut fmi3Int16, _n_values: usize);
    fmi3GetUInt16 GetUInt16 "UInt16" (_values: *mut fmi3UInt16, _n_values: usize);
    fmi3GetUInt32 GetUInt32 "UInt32" (_values: *mut fmi3UInt32, _n_values: usize);
    fmi3GetInt64 GetInt64 "Int64" (_values: *mut fmi3Int64, _n_values: usize);
    fmi3GetUInt64 GetUInt64 "UInt64" (_values: *mut fmi3UInt64, _n_values: usize);
    fmi3GetString GetString "String" (_values: *mut fmi3String, _n_values: usize);
    fmi3GetBinary GetBinary "Binary" (_sizes: *mut usize, _values: *mut fmi3Binary, _n_values: usize);
    fmi3GetClock GetClock "Clock" (_values: *mut fmi3Clock);
    fmi3SetFloat32 SetFloat32 "Float32" (_values: *const fmi3Float32, _n_values: usize);
    fmi3SetInt8 SetInt8 "Int8" (_values: *const fmi3Int8, _n_values: usize);
    fmi3SetUInt8 SetUInt8 "UInt8" (_values: *const fmi3UInt8, _n_values: usize);
    fmi3SetInt16 SetInt16 "Int16" (_values: *const fmi3Int16, _n_values: usize);
    fmi3SetUInt16 SetUInt16 "UInt16" (_values: *const fmi3UInt16, _n_values: usize);
    fmi3SetUInt32 SetUInt32 "UInt32" (_values: *const fmi3UInt32, _n_values: usize);
    fmi3SetInt64 SetInt64 "Int64" (_values: *const fmi3Int64, _n_values: usize);
    fmi3SetUInt64 SetUInt64 "UInt64" (_values: *const fmi3UInt64, _n_values: usize);
    fmi3SetString SetString "String" (_values: *const fmi3String, _n_values: usize);
    fmi3SetBinary SetBinary "Binary" (_sizes: *const usize, _values: *const fmi3Binary, _n_values: usize);
    fmi3SetClock SetClock "Clock" (_values: *const fmi3Clock);
}
