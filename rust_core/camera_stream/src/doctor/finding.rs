//! Results of the doctor's checks, as data: a page for the operator shows the same.

use std::fmt;
use std::io::Write;

use anyhow::{Error, Result};

use crate::check::live::is_closed_pipe;

/// Outcome of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mark {
    /// As it should be.
    Good,
    /// Wrong.
    Bad,
    /// Not known, often because an earlier check failed.
    Unknown,
}

/// Result of one check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Finding {
    pub(crate) mark: Mark,
    /// Name of the check, with the topic or display that it is about.
    pub(crate) name: String,
    /// Text of the finding.
    pub(crate) text: String,
    /// What to do about it; empty where nothing is to be done, or where the text says so.
    pub(crate) advice: String,
}

impl Finding {
    /// A finding that needs no action.
    pub(crate) fn good(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self { mark: Mark::Good, name: name.into(), text: text.into(), advice: String::new() }
    }

    /// A fault, and what to do about it.
    pub(crate) fn bad(name: impl Into<String>, text: impl Into<String>, advice: impl Into<String>) -> Self {
        Self { mark: Mark::Bad, name: name.into(), text: text.into(), advice: advice.into() }
    }

    /// A check that could not be made, and what would make it possible.
    pub(crate) fn unknown(name: impl Into<String>, text: impl Into<String>, advice: impl Into<String>) -> Self {
        Self { mark: Mark::Unknown, name: name.into(), text: text.into(), advice: advice.into() }
    }
}

/// Prints each finding when it is made.
pub(crate) struct Report<'o> {
    pub(crate) out: &'o mut dyn Write,
    pub(crate) is_coloured: bool,
    pub(crate) findings: Vec<Finding>,
    /// Why nothing is printed any more.
    pub(crate) error: Option<Error>,
}

impl Report<'_> {
    /// Prints findings.
    pub(crate) fn add(&mut self, findings: impl IntoIterator<Item = Finding>) {
        for finding in findings {
            let line = finding.to_string();
            self.print(finding.mark, &line);
            self.findings.push(finding);
        }
    }

    /// Prints what to do first. Returns `true` if something is wrong.
    ///
    /// # Errors
    /// The output could not be written.
    pub(crate) fn end(mut self) -> Result<bool> {
        let first = self.findings.iter().find(|finding| finding.mark == Mark::Bad);
        let line = first.map(|first| format!("fix first: {}", first.to_string().trim_start_matches("✗ ")));
        if let Some(line) = &line {
            self.print(Mark::Bad, line);
        }
        match self.error {
            // A closed pipe, as of `head`, is no error.
            Some(error) if !is_closed_pipe(&error) => Err(error),
            _ => Ok(line.is_some()),
        }
    }

    /// Prints a line, its first word in the colour of a mark.
    fn print(&mut self, mark: Mark, line: &str) {
        let color = match mark {
            Mark::Good => "32",
            Mark::Bad => "31",
            Mark::Unknown => "33",
        };
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        let printed = match self.is_coloured {
            true => writeln!(self.out, "\x1b[{color}m{word}\x1b[0m {rest}"),
            false => writeln!(self.out, "{line}"),
        };
        if let (Err(error), None) = (printed.and_then(|()| self.out.flush()), &self.error) {
            self.error = Some(error.into());
        }
    }
}

impl fmt::Display for Mark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Good => "✓",
            Self::Bad => "✗",
            Self::Unknown => "?",
        })
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = format!("{} {}: {}", self.mark, self.name, self.text.trim_end_matches('.'));
        let line = if self.advice.is_empty() { line } else { format!("{line}; {}", self.advice) };
        // A row is a line, whatever a node's texts hold.
        f.write_str(&line.replace(|c: char| c.is_control(), " "))
    }
}

/// Seconds for a sentence: `2 s`, `0.25 s`.
pub(crate) fn secs(secs: f64) -> String {
    let digits = if secs.abs() < 1.0 { 2 } else { 1 };
    let text = format!("{secs:.digits$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    format!("{} s", if text == "-0" { "0" } else { text })
}

/// The name of a check of one of several things: that of the only one is short.
pub(crate) fn check_name(check: &str, name: &str, count: usize) -> String {
    if count > 1 {
        format!("{check} {name}")
    } else {
        check.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finding_is_a_line_with_its_mark_and_what_to_do() {
        assert_eq!(Finding::good("master", "http://x:1/").to_string(), "✓ master: http://x:1/");
        assert_eq!(Finding::bad("image", "none\nat all", "start it").to_string(), "✗ image: none at all; start it");
        assert_eq!(Finding::unknown("exposure", "no driver", "").to_string(), "? exposure: no driver");
    }

    #[test]
    fn findings_are_printed_when_they_are_made_and_the_first_fault_again_at_the_end() {
        let printed = |is_coloured: bool, findings: &[Finding]| {
            let mut out = Vec::new();
            let mut report = Report { out: &mut out, is_coloured, findings: Vec::new(), error: None };
            report.add(findings.iter().cloned());
            let is_faulty = report.end().unwrap();
            (is_faulty, String::from_utf8(out).unwrap())
        };
        let good = Finding::good("master", "there");
        let bad = |name: &str| Finding::bad(name, "gone", "start it");
        assert_eq!(printed(false, std::slice::from_ref(&good)), (false, "✓ master: there\n".to_owned()));
        let (is_faulty, text) = printed(false, &[good.clone(), bad("image"), bad("window")]);
        let expected =
            "✓ master: there\n✗ image: gone; start it\n✗ window: gone; start it\nfix first: image: gone; start it\n";
        assert!(is_faulty);
        assert_eq!(text, expected);
        assert_eq!(printed(true, &[good]).1, "\u{1b}[32m✓\u{1b}[0m master: there\n");
    }

    #[test]
    fn seconds_have_the_digits_that_matter() {
        assert_eq!(
            [2.0, 0.25, 0.1, 1.96, 0.0, -0.001, 12.34].map(secs),
            ["2 s", "0.25 s", "0.1 s", "2 s", "0 s", "0 s", "12.3 s"]
        );
    }
}
