//! Messages of FMUs. The crate `fmi` formats them in C and passes them to the logger of the crate `log`.

use log::{Level, Log, Metadata, Record};

/// Severity of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// Information: status `fmi2OK`.
    Note,
    /// Status `fmi2Warning`.
    Warning,
    /// Status `fmi2Discard`.
    Discard,
    /// Status `fmi2Error` or `fmi2Fatal`.
    Error,
}

/// A message of an FMU, with its arguments inserted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// Name of the instance; `None` in FMI 3.0.
    pub instance: Option<String>,
    /// Severity, from the status.
    pub severity: Severity,
    /// Text without trailing line feeds.
    pub text: String,
}

/// Passes every message of every FMU to a function; returns `false` if another logger is already installed.
pub fn listen(to: impl Fn(&Message) + Send + Sync + 'static) -> bool {
    log::set_boxed_logger(Box::new(Listener(to))).is_ok()
}

struct Listener<F>(F);

impl<F: Fn(&Message) + Send + Sync> Log for Listener<F> {
    fn enabled(&self, _: &Metadata) -> bool {
        true
    }

    fn log(&self, record: &Record) {
        let severity = match record.level() {
            Level::Error => Severity::Error,
            Level::Warn => Severity::Warning,
            Level::Info => Severity::Note,
            Level::Debug | Level::Trace => Severity::Discard,
        };
        let text = record.args().to_string().trim_end().to_owned();
        // in FMI 2.0 the crate passes the name of the instance, in FMI 3.0 the category instead
        let instance = (record.module_path() != Some("fmu")).then(|| record.target().to_owned());
        (self.0)(&Message { instance, severity, text });
    }

    fn flush(&self) {}
}
