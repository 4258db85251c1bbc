//! Topics of a bag and their types.

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
    /// `true` if its messages are of a type: by the checksum, as between nodes, or by the name if the bag has none.
    pub fn holds(&self, kind: MessageKind) -> bool {
        if self.md5sum.is_empty() {
            kind.ros_type() == &*self.ros_type
        } else {
            kind.md5sum() == self.md5sum
        }
    }

    /// The type its messages are decoded as; `None` for one that is not supported.
    pub fn kind(&self) -> Option<MessageKind> {
        let of_name = MessageKind::from_ros_type(&self.ros_type).filter(|kind| self.holds(*kind));
        of_name.or_else(|| MessageKind::ALL.iter().copied().find(|kind| self.holds(*kind)))
    }

    /// Its type, with the checksum if it is another version of a known type.
    pub fn held(&self) -> String {
        let Self { ros_type, md5sum, .. } = self;
        match MessageKind::from_ros_type(ros_type).map(MessageKind::md5sum) {
            Some(known) if !md5sum.is_empty() && known != *md5sum => {
                format!("another version of {ros_type} (md5sum {md5sum}, here {known})")
            }
            _ => ros_type.to_string(),
        }
    }
}

/// The md5sum, or nothing for other texts: recorders of topics of any type write `*`.
pub(crate) fn md5sum(text: &[u8]) -> String {
    let is_md5sum = text.len() == 32 && text.iter().all(u8::is_ascii_hexdigit);
    if is_md5sum {
        String::from_utf8_lossy(text).to_ascii_lowercase()
    } else {
        String::new()
    }
}
