//! Problems in a `.rviz` file, with their lines.

use std::fmt;

use crate::one_line::one_line;
use crate::plugin_displays::needs;

/// A problem in the file: text that does not do what its author may expect.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// Line in the file, from 1.
    pub line: usize,
    /// Names of sections and displays, then the key, as in `Displays / cloud / Style`.
    pub path: String,
    /// `true` if no image changes by it, as in a disabled display.
    pub is_note: bool,
    /// The problem.
    pub kind: FindingKind,
}

/// The kinds of [`Finding`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FindingKind {
    /// A key that rviz 1.14 does not read at this place. It has no effect.
    UnknownKey,
    /// A key that older versions of rviz wrote, and that 1.14 ignores.
    OldKey {
        /// The keys that replace it.
        now: &'static str,
    },
    /// The links of a robot in another Link Tree Style than the one that rviz reads.
    UnreadTree {
        /// The settings of the tree that differ from the defaults and have no effect, a phrase each.
        changed: Vec<String>,
    },
    /// Synchronization that the Time panel asks for.
    TimeSync {
        /// The mode's name in rviz's window.
        mode: &'static str,
        /// The display whose messages set the time; empty for none.
        source: String,
    },
    /// An unknown view class, or a display without a class. Its keys are not read.
    UnknownClass {
        /// The class as the file names it; empty when there is none.
        class: String,
    },
    /// A display of a class that is not rviz's own. It is not drawn, and of its keys only topics are read.
    PluginDisplay {
        /// The class as the file names it.
        class: String,
        /// The topics that it names.
        topics: Vec<String>,
    },
    /// A name below a camera's Visibility that no display has at this place. It has no effect.
    UnknownDisplay {
        /// The names that displays have at this place.
        present: Vec<String>,
    },
    /// An invalid value.
    InvalidValue {
        /// The value in the file.
        value: String,
        /// The value that is used instead, as rviz would.
        used: String,
    },
}

impl fmt::Display for Finding {
    /// One line, whatever the file holds: control characters are escaped and long values cut.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let note = if self.is_note { "note: " } else { "" };
        write!(f, "line {}: {note}{}: ", self.line, one_line(&self.path))?;
        match &self.kind {
            FindingKind::UnknownKey => write!(f, "unknown key"),
            FindingKind::OldKey { now } => {
                write!(f, "key of an older rviz, which rviz ignores since 1.12; it reads {now}")
            }
            FindingKind::UnreadTree { changed } => write!(
                f,
                "rviz does not read this tree of links back, so these settings have no effect: {}; save the config with the \
                 Link Tree Style \"Links in Alphabetic Order\"",
                one_line(&changed.join(", "))
            ),
            FindingKind::TimeSync { mode, source } => {
                let source = if source.is_empty() { String::new() } else { format!(" to {}", one_line(source)) };
                write!(
                    f,
                    "synchronization \"{mode}\"{source} is not followed: what follows frames is shown at their latest \
                     transforms, as with SyncMode 0"
                )
            }
            FindingKind::UnknownClass { class } if class.is_empty() => write!(f, "no class named"),
            FindingKind::UnknownClass { class } => write!(f, "unknown class {}", one_line(class)),
            FindingKind::PluginDisplay { class, topics } => {
                write!(f, "unknown class {}, which {}", one_line(class), needs(class, topics))
            }
            FindingKind::UnknownDisplay { present } if present.is_empty() => write!(f, "no display is in this place"),
            FindingKind::UnknownDisplay { present } => {
                write!(f, "no display has this name; there are: {}", one_line(&present.join(", ")))
            }
            FindingKind::InvalidValue { value, used } => {
                write!(f, "invalid value \"{}\", using {}", one_line(value), one_line(used))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_one_line_whatever_the_file_holds() {
        let finding = Finding {
            line: 7,
            path: "Displays / a\nb / Style".to_owned(),
            is_note: false,
            kind: FindingKind::InvalidValue { value: "x\r\n".repeat(500), used: "Points".to_owned() },
        };
        let text = finding.to_string();
        assert_eq!(text.lines().count(), 1);
        assert!(text.starts_with("line 7: Displays / a\\nb / Style: invalid value \"x\\r\\n"));
        assert!(text.ends_with("…\", using Points"));
    }
}
