//! Topics of a bag, and which messages they hold.

use std::fmt;
use std::sync::Arc;

use rcs_messages::MessageKind;

/// A topic of a bag, of one publisher.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connection {
    /// The topic's whole name.
    pub topic: Arc<str>,
    /// `package/Name`.
    pub ros_type: Arc<str>,
    /// The checksum of the type's definition, in hexadecimal; empty when it was not recorded (`*`, say).
    pub md5sum: String,
    /// Name of the publishing node; empty when it was not recorded.
    pub publisher: Arc<str>,
    /// Whether the publisher latched its messages.
    pub latching: bool,
}

impl Connection {
    /// Whether its messages are of a type: by the checksum, as ROS compares types when nodes connect; by the name where
    /// the bag has no checksum.
    pub fn holds(&self, kind: MessageKind) -> bool {
        if self.md5sum.is_empty() {
            kind.ros_type() == &*self.ros_type
        } else {
            kind.md5sum() == self.md5sum
        }
    }

    /// The type that a message of it is decoded as, unless it is one that nothing here reads.
    pub fn kind(&self) -> Option<MessageKind> {
        let of_name = MessageKind::from_ros_type(&self.ros_type).filter(|kind| self.holds(*kind));
        of_name.or_else(|| MessageKind::ALL.iter().copied().find(|kind| self.holds(*kind)))
    }

    /// Formats its type, for a message about a type that it does not hold.
    pub fn held(&self) -> Held<'_> {
        Held(self)
    }
}

/// Prints the type of a connection; with its checksum if the type of that name has another one here.
#[derive(Clone, Copy, Debug)]
pub struct Held<'a>(&'a Connection);

impl fmt::Display for Held<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(Connection { ros_type, md5sum, .. }) = self;
        match MessageKind::from_ros_type(ros_type).map(MessageKind::md5sum) {
            Some(known) if !md5sum.is_empty() && known != *md5sum => {
                write!(f, "another version of {ros_type} (md5sum {md5sum}, here {known})")
            }
            _ => f.write_str(ros_type),
        }
    }
}

/// The md5sum if it is one, else nothing: recorders of topics of any type write `*`.
pub(crate) fn md5sum(text: &[u8]) -> String {
    let is_md5sum = text.len() == 32 && text.iter().all(u8::is_ascii_hexdigit);
    if is_md5sum {
        String::from_utf8_lossy(text).to_ascii_lowercase()
    } else {
        String::new()
    }
}

/// A topic's whole name in a bag, without remapping: names without a slash are below the root.
///
/// ```
/// assert_eq!([rcs_bag::full_name("tf"), rcs_bag::full_name("/tf")], ["/tf", "/tf"]);
/// ```
pub fn full_name(topic: &str) -> String {
    format!("/{}", topic.trim_start_matches('/'))
}
