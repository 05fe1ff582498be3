//! Exported functions that save and restore states.

use super::saved::saved_states;
use super::types::{fmi2Byte, fmi2Component, fmi2FMUstate};
use foldwing_fmi::fmi2::Call;

saved_states! {
    fmi2Component, fmi2FMUstate, fmi2Byte, "FMUstate";
    fmi2GetFMUstate Call::GetFmuState;
    fmi2SetFMUstate Call::SetFmuState;
    fmi2FreeFMUstate Call::FreeFmuState;
    fmi2SerializedFMUstateSize Call::SerializedFmuStateSize;
    fmi2SerializeFMUstate Call::SerializeFmuState;
    fmi2DeSerializeFMUstate Call::DeSerializeFmuState;
}
