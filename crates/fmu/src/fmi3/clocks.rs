//! Exported functions of features that this FMU does not have: clocks, structural parameters, dependencies of single elements. The life
//! cycle rejects each call before its body runs.

use super::types::{
    fmi3DependencyKind, fmi3Float64, fmi3Instance, fmi3IntervalQualifier, fmi3Status, fmi3UInt64, fmi3ValueReference,
};
use crate::enter;
use foldwing_fmi::fmi3::Call;

macro_rules! refused {
    ($($function:ident $call:ident ($($argument:ident: $type:ty),*);)*) => { $(
        /// Always an error: the FMU does not have this feature.
        ///
        /// # Safety
        /// `instance` is null or came from an instantiation and has not been freed.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $function(instance: fmi3Instance, $($argument: $type),*) -> fmi3Status {
            // SAFETY: forwarded from the caller.
            unsafe { enter(instance, Call::$call, |_| Ok(())) }
        }
    )* };
}

refused! {
    fmi3GetNumberOfVariableDependencies GetNumberOfVariableDependencies (_reference: fmi3ValueReference, _n: *mut usize);
    fmi3GetVariableDependencies GetVariableDependencies (
        _dependent: fmi3ValueReference,
        _elements_of_dependent: *mut usize,
        _independents: *mut fmi3ValueReference,
        _elements_of_independents: *mut usize,
        _kinds: *mut fmi3DependencyKind,
        _n: usize
    );
    fmi3EnterConfigurationMode EnterConfigurationMode ();
    fmi3ExitConfigurationMode ExitConfigurationMode ();
    fmi3GetIntervalDecimal GetIntervalDecimal (
        _references: *const fmi3ValueReference,
        _n: usize,
        _intervals: *mut fmi3Float64,
        _qualifiers: *mut fmi3IntervalQualifier
    );
    fmi3GetIntervalFraction GetIntervalFraction (
        _references: *const fmi3ValueReference,
        _n: usize,
        _counters: *mut fmi3UInt64,
        _resolutions: *mut fmi3UInt64,
        _qualifiers: *mut fmi3IntervalQualifier
    );
    fmi3GetShiftDecimal GetShiftDecimal (_references: *const fmi3ValueReference, _n: usize, _shifts: *mut fmi3Float64);
    fmi3GetShiftFraction GetShiftFraction (
        _references: *const fmi3ValueReference,
        _n: usize,
        _counters: *mut fmi3UInt64,
        _resolutions: *mut fmi3UInt64
    );
    fmi3SetIntervalDecimal SetIntervalDecimal (
        _references: *const fmi3ValueReference,
        _n: usize,
        _intervals: *const fmi3Float64
    );
    fmi3SetIntervalFraction SetIntervalFraction (
        _references: *const fmi3ValueReference,
        _n: usize,
        _counters: *const fmi3UInt64,
        _resolutions: *const fmi3UInt64
    );
    fmi3SetShiftDecimal SetShiftDecimal (_references: *const fmi3ValueReference, _n: usize, _shifts: *const fmi3Float64);
    fmi3SetShiftFraction SetShiftFraction (
        _references: *const fmi3ValueReference,
        _n: usize,
        _counters: *const fmi3UInt64,
        _resolutions: *const fmi3UInt64
    );
    fmi3EvaluateDiscreteStates EvaluateDiscreteStates ();
    fmi3ActivateModelPartition ActivateModelPartition (_clock: fmi3ValueReference, _time: fmi3Float64);
}
