//! Messages to the importer: categories, filter, text.

use crate::instance::error::CallError;
use crate::instance::status::Status;

/// Callback for messages to the importer: status, category, text.
pub type Sink = Box<dyn Fn(Status, LogCategory, &str)>;

/// Log categories of the model description: name and description.
pub const LOG_CATEGORIES: &[(&str, &str)] = &[
    ("logAll", "all messages"),
    ("logEvents", "releases, latch closings and openings"),
    ("logStatusWarning", "warnings"),
    ("logStatusDiscard", "rejected values; always logged"),
    ("logStatusError", "rejected and failed calls; always logged"),
    ("logStatusFatal", "internal errors; always logged"),
];

/// Category of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogCategory {
    /// Events of the simulation.
    Events,
    /// Warnings.
    Warning,
    /// Rejected values.
    Discard,
    /// Illegal and failed calls.
    Error,
    /// Internal errors.
    Fatal,
}

impl LogCategory {
    /// Name in [`LOG_CATEGORIES`].
    pub const fn name(self) -> &'static str {
        match self {
            Self::Events => "logEvents",
            Self::Warning => "logStatusWarning",
            Self::Discard => "logStatusDiscard",
            Self::Error => "logStatusError",
            Self::Fatal => "logStatusFatal",
        }
    }
}

/// Log of one instance. Errors are always passed to the importer; events and warnings if their category is on.
pub struct Log {
    sink: Option<Sink>,
    events: bool,
    warnings: bool,
}

impl Log {
    /// Log with callback `sink`, if there is one; `logging_on` switches every category on.
    pub fn new(sink: Option<Sink>, logging_on: bool) -> Self {
        Self { sink, events: logging_on, warnings: logging_on }
    }

    /// Sets the categories; an empty list means all of them. Unknown names are an error and nothing changes.
    pub fn set_categories<'a>(
        &mut self,
        logging_on: bool,
        categories: impl Iterator<Item = &'a str> + Clone,
    ) -> Result<(), CallError> {
        for name in categories.clone() {
            if !LOG_CATEGORIES.iter().any(|(known, _)| *known == name) {
                let known: Vec<_> = LOG_CATEGORIES.iter().map(|(known, _)| *known).collect();
                return Err(CallError::LogCategory { name: name.to_owned(), known: known.join(", ") });
            }
        }
        let concerns = |category: LogCategory| {
            let mut categories = categories.clone().peekable();
            categories.peek().is_none() || categories.any(|name| name == "logAll" || name == category.name())
        };
        // With a list, only the categories in it change.
        if concerns(LogCategory::Events) {
            self.events = logging_on;
        }
        if concerns(LogCategory::Warning) {
            self.warnings = logging_on;
        }
        Ok(())
    }

    /// Returns whether messages of a category are passed on; to be called before a text is built.
    pub fn wants(&self, category: LogCategory) -> bool {
        self.sink.is_some()
            && match category {
                LogCategory::Events => self.events,
                LogCategory::Warning => self.warnings,
                LogCategory::Discard | LogCategory::Error | LogCategory::Fatal => true,
            }
    }

    /// Passes a message to the importer if its category is on.
    pub fn write(&self, status: Status, category: LogCategory, text: &str) {
        if let (true, Some(sink)) = (self.wants(category), &self.sink) {
            sink(status, category, text);
        }
    }

    /// Passes the error of a call to the importer.
    pub fn refuse(&self, status: Status, text: &str) {
        let category = match status {
            Status::Ok | Status::Warning => LogCategory::Warning,
            Status::Discard => LogCategory::Discard,
            Status::Error => LogCategory::Error,
            Status::Fatal => LogCategory::Fatal,
        };
        self.write(status, category, text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;
    use std::rc::Rc;

    fn recording(logging_on: bool) -> (Log, Rc<RefCell<Vec<String>>>) {
        let messages = Rc::new(RefCell::new(Vec::new()));
        let sink = Rc::clone(&messages);
        let log = Log::new(
            Some(Box::new(move |_, category, text| sink.borrow_mut().push(format!("{}: {text}", category.name())))),
            logging_on,
        );
        (log, messages)
    }

    #[test]
    fn refusals_are_always_logged_and_events_on_request() {
        let (mut log, messages) = recording(false);
        log.write(Status::Ok, LogCategory::Events, "latched");
        log.refuse(Status::Error, "no");
        assert_eq!(*messages.borrow(), ["logStatusError: no"]);

        log.set_categories(true, ["logEvents"].into_iter()).expect("known category");
        log.write(Status::Ok, LogCategory::Events, "latched");
        log.write(Status::Warning, LogCategory::Warning, "hm");
        assert_eq!(*messages.borrow(), ["logStatusError: no", "logEvents: latched"]);

        log.set_categories(false, std::iter::empty()).expect("no category means all");
        assert!(!log.wants(LogCategory::Events));
    }

    #[test]
    fn unknown_category_is_refused_by_name_and_changes_nothing() {
        let (mut log, _) = recording(false);
        let error = log.set_categories(true, ["logEvents", "logNonsense"].into_iter()).expect_err("unknown");
        let text = error.to_string();
        assert!(text.contains("\"logNonsense\"") && text.contains("logStatusError"), "{text}");
        assert!(!log.wants(LogCategory::Events));
    }
}
