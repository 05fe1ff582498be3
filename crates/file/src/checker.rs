//! Collection of errors of the third pass, at the lines of their keys.

use crate::document::{Document, key_text};
use crate::error::{Fault, Problem};
use crate::freedoms::is_common;
use crate::meant::did_you_mean;
use foldwing_engine::machine::units::quoted;
use std::collections::BTreeMap;
use toml::de::DeValue;

/// Collects errors with the positions of their keys.
pub(super) struct Checker<'d, 'a> {
    document: &'d Document<'a>,
    problems: Vec<Problem>,
    /// Paths of the machine whose values were replaced after an error; further errors there are consequences of it.
    stand_ins: Vec<Vec<String>>,
    /// Names of copies, of parts that are defined once in the file and copied in the machine, with the names of their originals; of the degrees
    /// of freedom of joints with their tables, as in `strut.rotation`.
    copies: &'d BTreeMap<String, String>,
}

impl<'d, 'a> Checker<'d, 'a> {
    /// Creates a checker without errors.
    pub fn new(document: &'d Document<'a>, copies: &'d BTreeMap<String, String>) -> Self {
        Self { document, problems: Vec::new(), stand_ins: Vec::new(), copies }
    }
}

impl Checker<'_, '_> {
    /// Reports an invalid or missing value at `path`.
    pub fn refuse(&mut self, path: &[&str], allowed: impl Into<String>) {
        self.push(self.document.refusal(&self.stated(path), allowed.into()));
    }

    /// Path in the file for a path that may belong to a copy, or to a degree of freedom of a joint.
    fn stated<'p>(&'p self, path: &[&'p str]) -> Vec<&'p str> {
        let mut path = path.to_vec();
        let Some(original) = path.get(1).and_then(|name| self.copies.get(*name)) else { return path };
        let table = path.get(2).is_some_and(|key| !is_common(key));
        let parts = original.split('.').take(if table { 2 } else { 1 });
        path.splice(1..2, parts);
        path
    }

    /// Adds a problem; an error that all copies have is reported once.
    fn push(&mut self, problem: Problem) {
        if self.copies.is_empty() || !self.problems.contains(&problem) {
            self.problems.push(problem);
        }
    }

    /// Reports the invalid state described by `value`, at `path`.
    pub fn refuse_as(&mut self, path: &[&str], value: impl Into<String>, allowed: impl Into<String>) {
        let fault = Fault::NotAllowed { value: value.into(), allowed: allowed.into() };
        let path = &self.stated(path);
        let span = self
            .document
            .find(path)
            .map_or_else(|| self.document.span_of(path), |entry| self.document.value_span(entry.offset, entry.value));
        let problem = Problem { line: self.document.line_of(path), span, key: key_text(path), fault };
        self.push(problem);
    }

    /// Returns whether the file states the key.
    pub fn states(&self, path: &[&str]) -> bool {
        self.document.find(&self.stated(path)).is_some()
    }

    /// Reports an unknown name; `known` are the allowed names.
    pub fn unknown_name<'k>(&mut self, path: &[&str], name: &str, what: &str, known: impl Iterator<Item = &'k str>) {
        let known: Vec<&str> = known.collect();
        let hint = did_you_mean(name, known.iter().copied());
        self.refuse(path, format!("{what}: {}{hint}", quoted(&known)));
    }

    /// Suppresses errors at and below this path of the machine.
    pub fn stands_in(&mut self, place: &[&str]) {
        self.stand_ins.push(place.iter().map(|part| (*part).to_owned()).collect());
    }

    /// Returns whether a place of the machine is at or below a path at which errors are suppressed.
    pub fn has_stand_in(&self, place: &[String]) -> bool {
        self.stand_ins.iter().any(|path| place.starts_with(path))
    }

    /// Allowed values if the file gives a function along a body as a single number.
    pub fn plain_number(&self, path: &[&str]) -> Option<&'static str> {
        let entry = self.document.find(&self.stated(path))?;
        let number = matches!(entry.value.get_ref(), DeValue::Integer(_) | DeValue::Float(_));
        match path.last() {
            Some(&("width_taper" | "height_taper")) if number => Some("a finite factor > 0"),
            Some(&"chord_m") if number => Some("a finite length > 0 m"),
            _ => None,
        }
    }

    /// All reported errors, in the order of their reports.
    pub fn into_problems(self) -> Vec<Problem> {
        self.problems
    }
}
