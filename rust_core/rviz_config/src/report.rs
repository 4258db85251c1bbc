//! Findings and properties that are collected while a file is read.
//!
//! A [`Report::recording`] notes each property that is read, with its default: a class's reader, run over a section
//! without keys, lists the class's properties.

use std::cell::{Cell, RefCell};

use crate::finding::{Finding, FindingKind};

/// A property that a display class reads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Property {
    /// The keys that lead to it in the display's section, as in `Line Style / Line Width`. Where the keys are names of
    /// joints, links and the like, [`ENTRY`] stands for any of them.
    pub key: String,
    /// The text with which a file would set it to its default; empty where no text would.
    pub default: String,
}

/// Stands for any name in the key of a [`Property`].
pub const ENTRY: &str = "(name)";

/// Findings while a file is read, in the order of reading, and the properties that are read where they are recorded.
#[derive(Debug, Default)]
pub(crate) struct Report {
    findings: RefCell<Vec<Finding>>,
    /// `true` while findings are notes: about settings that change no image.
    notes_only: Cell<bool>,
    /// `None` unless the properties that are read are recorded.
    properties: Option<RefCell<Vec<Property>>>,
}

impl Report {
    /// A report that records which properties are read.
    pub(crate) fn recording() -> Self {
        Self { properties: Some(RefCell::default()), ..Self::default() }
    }

    /// The properties that were read, in the order of reading.
    pub(crate) fn into_properties(self) -> Vec<Property> {
        self.properties.map(RefCell::into_inner).unwrap_or_default()
    }

    pub(crate) fn add(&self, line: usize, path: &str, kind: FindingKind) {
        let is_note = self.notes_only.get();
        self.findings.borrow_mut().push(Finding { line, path: path.to_owned(), is_note, kind });
    }

    /// Reports a note: a finding that changes no image.
    pub(crate) fn add_note(&self, line: usize, path: &str, kind: FindingKind) {
        self.with_notes(true, || self.add(line, path, kind));
    }

    /// Calls `read`; its findings are notes if `is_note`, or inside of another call with `is_note`.
    pub(crate) fn with_notes<T>(&self, is_note: bool, read: impl FnOnce() -> T) -> T {
        let outer = self.notes_only.replace(is_note || self.notes_only.get());
        let result = read();
        self.notes_only.set(outer);
        result
    }

    /// Reports an invalid value and the value used instead.
    pub(crate) fn add_invalid(&self, line: usize, path: &str, value: &str, used: &str) {
        let kind = FindingKind::InvalidValue { value: value.to_owned(), used: used.to_owned() };
        self.add(line, path, kind);
    }

    /// `true` where properties are recorded.
    pub(crate) fn is_recording(&self) -> bool {
        self.properties.is_some()
    }

    /// Records a property with its default, where properties are recorded.
    pub(crate) fn record(&self, key: impl FnOnce() -> String, default: impl FnOnce() -> String) {
        if let Some(properties) = &self.properties {
            properties.borrow_mut().push(Property { key: key(), default: default() });
        }
    }

    /// All findings in the order of their lines.
    pub(crate) fn into_findings(self) -> Vec<Finding> {
        let mut findings = self.findings.into_inner();
        findings.sort_by_key(|finding| finding.line);
        findings
    }
}
