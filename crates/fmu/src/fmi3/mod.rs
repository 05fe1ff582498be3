//! Exported functions of FMI 3.0, behind the same gate as those of FMI 2.0.

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

/// The importer's callback for intermediate updates within steps.
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
    /// Notifies the importer of the end of an internal step at `now_s`. Returns the time until which the communication step to `end_s`
    /// continues: its end, unless the importer requests an earlier return and this is allowed.
    fn until(self, now_s: f64, end_s: f64, may_return: bool) -> f64 {
        let (mut returns, mut at_s) = (false, now_s);
        // SAFETY: the importer's function, with results that outlive the call.
        unsafe {
            (self.update)(self.environment, now_s, false, true, true, may_return, &mut returns, &mut at_s);
        }
        if returns && may_return { if at_s.is_nan() { now_s } else { at_s.clamp(now_s, end_s) } } else { end_s }
    }
}

/// The importer's log function as a [`Sink`]; `None` if there is no function.
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
