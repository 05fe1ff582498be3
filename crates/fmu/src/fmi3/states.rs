//! Exported functions that save and restore states.

use super::types::{fmi3Byte, fmi3FMUState, fmi3Instance};
use crate::saved::saved_states;
use foldwing_fmi::fmi3::Call;

saved_states! {
    fmi3Instance, fmi3FMUState, fmi3Byte, "FMUState";
    fmi3GetFMUState Call::GetFmuState;
    fmi3SetFMUState Call::SetFmuState;
    fmi3FreeFMUState Call::FreeFmuState;
    fmi3SerializedFMUStateSize Call::SerializedFmuStateSize;
    fmi3SerializeFMUState Call::SerializeFmuState;
    fmi3DeserializeFMUState Call::DeserializeFmuState;
}
