//! Saved FMU states: a registry with checked handles, and a serialised form with model and version.

use crate::instance::phase::{InterfaceKind, Phase};
use crate::instance::status::Status;
use foldwing_engine::plant::Snapshot;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::hash::{BuildHasher, Hasher, RandomState};

/// First bytes of a serialised state.
const MAGIC: [u8; 8] = *b"FOLDWING";
/// Version of the serialised form: to be increased with every change of [`SavedState`] or its contents.
const VERSION: u16 = 10;
/// Length of a GUID with its braces.
const GUID_LENGTH: usize = 38;
/// Magic, version, GUID, length of the payload, CRC-32 of all but the checksum itself.
pub(super) const HEADER_LENGTH: usize = 8 + 2 + GUID_LENGTH + 8 + 4;

/// Error of a saved state.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum StateError {
    /// A handle of another instance, or one that was freed.
    #[error("the FMU state was freed or belongs to another instance; set one that this instance has saved")]
    UnknownHandle,
    /// The bytes are not a serialised state.
    #[error("the serialised FMU state was not written by this program: it does not begin with FOLDWING")]
    NotAState,
    /// The bytes were written by another version.
    #[error(
        "the serialised FMU state has version {found}; this library reads version {VERSION}: serialise it again with this one"
    )]
    Version {
        /// Version in the bytes.
        found: u16,
    },
    /// State of another model.
    #[error("the serialised FMU state belongs to the model {found}, not to {expected}; set one of this model")]
    OtherModel {
        /// GUID in the bytes.
        found: String,
        /// GUID of this instance.
        expected: String,
    },
    /// State of an instance of the other interface type.
    #[error(
        "the FMU state was saved by an instance for {found} and does not fit one for {expected}; set a state of \
             the same interface type"
    )]
    OtherKind {
        /// Interface type of the instance that saved it.
        found: InterfaceKind,
        /// Interface type of this instance.
        expected: InterfaceKind,
    },
    /// Wrong length.
    #[error(
        "the serialised FMU state is damaged: {found} bytes instead of {}{expected}; pass all the bytes that were written when it was serialised",
        if *in_header { "more than " } else { "" }
    )]
    Length {
        /// Given number of bytes.
        found: usize,
        /// Expected number of bytes.
        expected: u64,
        /// Whether they end in the header, so that only its length is known.
        in_header: bool,
    },
    /// Wrong checksum.
    #[error(
        "the serialised FMU state is damaged: its checksum does not match; pass the bytes as they were written when it was serialised"
    )]
    Checksum,
    /// Invalid content.
    #[error("the serialised FMU state is damaged: {0}")]
    Content(String),
    /// The buffer of the importer is too small.
    #[error(
        "the buffer for the serialised FMU state has {given} bytes; {needed} are needed, as returned by the function \
         for the serialised size"
    )]
    Buffer {
        /// Size of the buffer.
        given: usize,
        /// Size of the state.
        needed: usize,
    },
}

/// Times and tolerance of the experiment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Experiment {
    /// Start time in s.
    pub start_s: f64,
    /// Stop time in s, if there is one.
    pub stop_s: Option<f64>,
}

/// Complete state for a rollback.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedState {
    /// Interface type of the instance.
    pub kind: InterfaceKind,
    /// Phase of the life cycle.
    pub phase: Phase,
    /// Times of the experiment.
    pub experiment: Experiment,
    /// The initial values must be evaluated again.
    pub stale: bool,
    /// Whether the last step succeeded.
    pub step_failed: bool,
    /// State of the model.
    pub plant: Snapshot,
}

impl SavedState {
    /// Status of the last step.
    pub fn step_status(step_failed: bool) -> Status {
        if step_failed { Status::Error } else { Status::Ok }
    }

    /// Serialises the state; the bytes can be restored in any process by the same library and model.
    pub fn to_bytes(&self, guid: &str) -> Result<Vec<u8>, StateError> {
        let payload = postcard::to_stdvec(self).map_err(|error| StateError::Content(error.to_string()))?;
        let mut bytes = Vec::with_capacity(HEADER_LENGTH + payload.len());
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(guid.as_bytes());
        bytes.extend((payload.len() as u64).to_le_bytes());
        let checksum = checksum(&bytes, &payload);
        bytes.extend(checksum.to_le_bytes());
        bytes.extend(payload);
        Ok(bytes)
    }

    /// Restores a state from bytes; fails unless they are complete, undamaged and of this model.
    pub fn from_bytes(bytes: &[u8], guid: &str) -> Result<Self, StateError> {
        let cut = StateError::Length { found: bytes.len(), expected: HEADER_LENGTH as u64, in_header: true };
        let (magic, rest) = bytes.split_first_chunk::<8>().ok_or(cut.clone())?;
        if *magic != MAGIC {
            return Err(StateError::NotAState);
        }
        let (version, rest) = rest.split_first_chunk::<2>().ok_or(cut.clone())?;
        let version = u16::from_le_bytes(*version);
        if version != VERSION {
            return Err(StateError::Version { found: version });
        }
        let (found, rest) = rest.split_first_chunk::<GUID_LENGTH>().ok_or(cut.clone())?;
        if found != guid.as_bytes() {
            let found = String::from_utf8_lossy(found).into_owned();
            return Err(StateError::OtherModel { found, expected: guid.to_owned() });
        }
        let (length, rest) = rest.split_first_chunk::<8>().ok_or(cut.clone())?;
        let (sum, payload) = rest.split_first_chunk::<4>().ok_or(cut)?;
        let length = u64::from_le_bytes(*length);
        if payload.len() as u64 != length {
            let expected = length.saturating_add(HEADER_LENGTH as u64);
            return Err(StateError::Length { found: bytes.len(), expected, in_header: false });
        }
        if checksum(&bytes[..HEADER_LENGTH - 4], payload) != u32::from_le_bytes(*sum) {
            return Err(StateError::Checksum);
        }
        match postcard::take_from_bytes(payload) {
            Ok((state, [])) => Ok(state),
            Ok((_, rest)) => Err(StateError::Content(format!("{} bytes too many", rest.len()))),
            Err(error) => Err(StateError::Content(error.to_string())),
        }
    }
}

/// CRC-32 over the header before the checksum, and the payload.
pub(super) fn checksum(header: &[u8], payload: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(header);
    hasher.update(payload);
    hasher.finalize()
}

/// Saved states of one instance.
///
/// A handle is a number that no other instance uses and that is never reused, so a freed or foreign one is recognised without access to
/// memory.
pub struct Registry {
    states: BTreeMap<usize, SavedState>,
    next: usize,
}

impl Registry {
    /// Empty registry whose handles start at a random number, so that those of different instances differ.
    pub fn new() -> Self {
        // Only the lower half of the number fits into a pointer on 32-bit systems.
        #[expect(clippy::cast_possible_truncation, reason = "any bits will do")]
        let next = RandomState::new().build_hasher().finish() as usize;
        Self { states: BTreeMap::new(), next }
    }

    /// Stores a state under a new handle, never zero.
    pub fn insert(&mut self, state: SavedState) -> usize {
        loop {
            self.next = self.next.wrapping_add(1);
            if self.next != 0 && !self.states.contains_key(&self.next) {
                self.states.insert(self.next, state);
                return self.next;
            }
        }
    }

    /// Overwrites the state of a handle.
    pub fn replace(&mut self, handle: usize, state: SavedState) -> Result<(), StateError> {
        *self.states.get_mut(&handle).ok_or(StateError::UnknownHandle)? = state;
        Ok(())
    }

    /// Returns the state of a handle.
    pub fn get(&self, handle: usize) -> Result<&SavedState, StateError> {
        self.states.get(&handle).ok_or(StateError::UnknownHandle)
    }

    /// Removes the state of a handle.
    pub fn remove(&mut self, handle: usize) -> Result<(), StateError> {
        self.states.remove(&handle).map(|_| ()).ok_or(StateError::UnknownHandle)
    }
}
