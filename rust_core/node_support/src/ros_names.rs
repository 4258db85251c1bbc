//! Topics, services and parameters of a program, as its reference page lists them.

/// How a program uses a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Usage {
    /// Publishes a topic.
    Publishes,
    /// Subscribes to a topic.
    Subscribes,
    /// Provides a service.
    Serves,
    /// Offers settings by dynamic_reconfigure.
    Configures,
    /// Reads a parameter.
    Reads,
}

impl Usage {
    /// The word in the reference.
    pub fn word(self) -> &'static str {
        match self {
            Self::Publishes => "publishes",
            Self::Subscribes => "subscribes",
            Self::Serves => "service",
            Self::Configures => "settings",
            Self::Reads => "reads",
        }
    }
}

/// A topic, service or parameter of a program.
#[derive(Clone, Copy, Debug)]
pub struct RosName {
    /// How the program uses it.
    pub usage: Usage,
    /// The name by default. Words in capitals stand for others, and several names are separated by a comma.
    pub name: &'static str,
    /// Type of the message, service or parameter.
    pub kind: &'static str,
    /// Contents, and the condition under which the name is used.
    pub note: &'static str,
}

/// A published topic.
pub const fn publishes(name: &'static str, kind: &'static str, note: &'static str) -> RosName {
    RosName { usage: Usage::Publishes, name, kind, note }
}

/// A topic that is subscribed to.
pub const fn subscribes(name: &'static str, kind: &'static str, note: &'static str) -> RosName {
    RosName { usage: Usage::Subscribes, name, kind, note }
}

/// A provided service.
pub const fn serves(name: &'static str, kind: &'static str, note: &'static str) -> RosName {
    RosName { usage: Usage::Serves, name, kind, note }
}

/// Settings that dynamic_reconfigure changes.
pub const fn configures(name: &'static str, note: &'static str) -> RosName {
    RosName { usage: Usage::Configures, name, kind: "dynamic_reconfigure", note }
}

/// A parameter that is read.
pub const fn reads(name: &'static str, kind: &'static str, note: &'static str) -> RosName {
    RosName { usage: Usage::Reads, name, kind, note }
}
