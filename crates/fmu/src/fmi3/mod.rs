//! The exported functions of FMI 3.0, behind the same gate.

pub mod clocks;
pub mod derivatives;
pub mod exchange;
pub mod functions;
#[cfg(feature = "import")]
pub mod official;
pub mod states;
pub mod steps;
pub mod types;
pub mod values;

use crate::{c_text, status_code};
use foldwing_fmi::instance::Sink;
use types::{fmi3Boolean, fmi3Float64, fmi3InstanceEnvironment, fmi3LogMessageCallback};

/// The importer's function that hears of times within steps.
#[derive(Clone, Copy)]
pub(crate) struct Asked {
    pub update: unsafe extern "C" fn(
        fmi3InstanceEnvironment,
        fmi3Float64,
        fmi3Boolean,
        fmi3Boolean,
        fmi3Boolean,
        fmi3Boolean,
        *mut fmi3Boolean,
        *mut fmi3Float64,
    ),
    pub environment: fmi3InstanceEnvironment,
}

impl Asked {
    /// Tells the importer that an internal step has ended at `now_s`. Returns until when the communication step to `end_s` goes
    /// on: to its end, unless the importer wants otherwise and may.
    fn until(self, now_s: f64, end_s: f64, may_return: bool) -> f64 {
        let (mut returns, mut at_s) = (false, now_s);
        // SAFETY: the importer's function, with results that outlive the call.
        unsafe {
            (self.update)(self.environment, now_s, false, true, true, may_return, &mut returns, &mut at_s);
        }
        if returns && may_return { if at_s.is_nan() { now_s } else { at_s.clamp(now_s, end_s) } } else { end_s }
    }
}

/// The importer's log function as a [`Sink`]; none if there is no function.
///
/// # Safety
/// `log_message` stays callable as long as the sink lives.
unsafe fn sink(log_message: fmi3LogMessageCallback, environment: fmi3InstanceEnvironment) -> Option<Sink> {
    let log_message = log_message?;
    Some(Box::new(move |status, category, text| {
        let (category, message) = (c_text(category.name()), c_text(text));
        // SAFETY: the importer's function, with zero-terminated texts that outlive the call.
        unsafe { log_message(environment, status_code(status), category.as_ptr(), message.as_ptr()) }
    }))
}
