//! Calls of every function of FMI 2.0 on an instance, with arguments that are valid wherever the call is legal.

use crate::fmu::Fmu;
use foldwing_fmu::derivatives::*;
use foldwing_fmu::exchange::*;
use foldwing_fmu::functions::*;
use foldwing_fmu::states::*;
use foldwing_fmu::status::*;
use foldwing_fmu::types::*;
use std::ptr;

/// Communication step in s.
pub const STEP_S: f64 = 1e-3;

/// Arguments of the calls in addition to the instance.
pub struct Arguments<'a> {
    /// A saved state.
    pub state: fmi2FMUstate,
    /// Its bytes.
    pub bytes: &'a [u8],
    /// Current time in s.
    pub time_s: f64,
    /// Continuous states; empty for an instance without Model Exchange.
    pub states: &'a [f64],
    /// Number of event indicators.
    pub indicators: usize,
}

/// A cleared event-info structure.
pub fn no_info() -> fmi2EventInfo {
    fmi2EventInfo {
        newDiscreteStatesNeeded: -1,
        terminateSimulation: -1,
        nominalsOfContinuousStatesChanged: -1,
        valuesOfContinuousStatesChanged: -1,
        nextEventTimeDefined: -1,
        nextEventTime: f64::NAN,
    }
}

/// Calls a function.
pub fn call(fmu: &Fmu, name: &str, arguments: &Arguments) -> fmi2Status {
    let &Arguments { mut state, bytes, time_s, states: given, indicators } = arguments;
    let c = fmu.component;
    let reference = |name: &str| fmu.reference(name);
    let (mut real, mut integer, mut size) = (0.0, 0, 0_usize);
    let (null, mut status, mut text) = (ptr::null::<u32>(), 0, ptr::null());
    let (mut states, mut indicators) = (given.to_vec(), vec![0.0; indicators]);
    let (nx, ni) = (states.len(), indicators.len());
    unsafe {
        match name {
            "fmi2SetDebugLogging" => fmi2SetDebugLogging(c, fmi2False, 1, &c"logEvents".as_ptr()),
            "fmi2SetupExperiment" => fmi2SetupExperiment(c, fmi2True, 1e-5, 0.0, fmi2True, 1.0),
            "fmi2EnterInitializationMode" => fmi2EnterInitializationMode(c),
            "fmi2ExitInitializationMode" => fmi2ExitInitializationMode(c),
            "fmi2Terminate" => fmi2Terminate(c),
            "fmi2Reset" => fmi2Reset(c),
            "fmi2GetReal" => fmi2GetReal(c, &reference("tip.acceleration.z"), 1, &mut real),
            "fmi2GetInteger" => fmi2GetInteger(c, &reference("fold.latch_count"), 1, &mut integer),
            "fmi2GetBoolean" => fmi2GetBoolean(c, &reference("fold.latched"), 1, &mut integer),
            "fmi2GetString" => fmi2GetString(c, null, 0, ptr::null_mut()),
            "fmi2SetReal" => fmi2SetReal(c, &reference("fold.external_torque"), 1, &0.01),
            "fmi2SetInteger" => fmi2SetInteger(c, null, 0, ptr::null()),
            // the importer cannot set switches while it integrates
            "fmi2SetBoolean" if nx == 0 => fmi2SetBoolean(c, &reference("fold.latch_enable"), 1, &fmi2False),
            "fmi2SetBoolean" => fmi2SetBoolean(c, null, 0, ptr::null()),
            "fmi2SetString" => fmi2SetString(c, null, 0, ptr::null()),
            "fmi2GetFMUstate" => fmi2GetFMUstate(c, &mut state),
            "fmi2SetFMUstate" => fmi2SetFMUstate(c, state),
            "fmi2FreeFMUstate" => fmi2FreeFMUstate(c, &mut fmu.save()),
            "fmi2SerializedFMUstateSize" => fmi2SerializedFMUstateSize(c, state, &mut size),
            "fmi2SerializeFMUstate" => {
                let mut room = vec![0_i8; bytes.len()];
                fmi2SerializeFMUstate(c, state, room.as_mut_ptr().cast(), room.len())
            }
            "fmi2DeSerializeFMUstate" => {
                fmi2DeSerializeFMUstate(c, bytes.as_ptr().cast(), bytes.len(), &mut ptr::null_mut())
            }
            "fmi2GetDirectionalDerivative" => {
                let (unknown, known) = (reference("tip.acceleration.z"), reference("fold.external_torque"));
                fmi2GetDirectionalDerivative(c, &unknown, 1, &known, 1, &1.0, &mut real)
            }
            "fmi2SetRealInputDerivatives" => {
                fmi2SetRealInputDerivatives(c, &reference("fold.external_torque"), 1, &1, &0.1)
            }
            "fmi2GetRealOutputDerivatives" => {
                fmi2GetRealOutputDerivatives(c, &reference("fold.angle"), 1, &1, &mut real)
            }
            "fmi2DoStep" => fmi2DoStep(c, time_s, STEP_S, fmi2True),
            "fmi2CancelStep" => fmi2CancelStep(c),
            "fmi2GetStatus" => fmi2GetStatus(c, fmi2DoStepStatus, &mut status),
            "fmi2GetRealStatus" => fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &mut real),
            "fmi2GetIntegerStatus" => fmi2GetIntegerStatus(c, fmi2DoStepStatus, &mut integer),
            "fmi2GetBooleanStatus" => fmi2GetBooleanStatus(c, fmi2Terminated, &mut integer),
            "fmi2GetStringStatus" => fmi2GetStringStatus(c, fmi2PendingStatus, &mut text),
            "fmi2EnterEventMode" => fmi2EnterEventMode(c),
            "fmi2NewDiscreteStates" => fmi2NewDiscreteStates(c, &mut no_info()),
            "fmi2EnterContinuousTimeMode" => fmi2EnterContinuousTimeMode(c),
            "fmi2CompletedIntegratorStep" => fmi2CompletedIntegratorStep(c, fmi2True, &mut integer, &mut 0),
            "fmi2SetTime" => fmi2SetTime(c, time_s),
            "fmi2SetContinuousStates" => fmi2SetContinuousStates(c, given.as_ptr(), nx),
            "fmi2GetDerivatives" => fmi2GetDerivatives(c, states.as_mut_ptr(), nx),
            "fmi2GetEventIndicators" => fmi2GetEventIndicators(c, indicators.as_mut_ptr(), ni),
            "fmi2GetContinuousStates" => fmi2GetContinuousStates(c, states.as_mut_ptr(), nx),
            "fmi2GetNominalsOfContinuousStates" => fmi2GetNominalsOfContinuousStates(c, states.as_mut_ptr(), nx),
            other => panic!("no call for {other}"),
        }
    }
}
