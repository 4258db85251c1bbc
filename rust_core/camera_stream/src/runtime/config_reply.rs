//! The answer for who asked for a config.

use rcs_ros::{Reply, TriggerReply};

/// Answers who asked for a config.
pub(super) enum ConfigReply {
    /// A caller of `reload_config`.
    Reload(TriggerReply),
    /// A caller of `load_config`, whose answer has no text.
    Load(Reply<bool>),
}

impl ConfigReply {
    pub(super) fn send(self, success: bool, message: impl Into<String>) {
        match self {
            Self::Reload(reply) => reply.send(success, message),
            Self::Load(reply) => {
                if success {
                    log::info!("the config changed: {}", message.into());
                } else {
                    log::error!("{}", message.into());
                }
                reply.answer(success);
            }
        }
    }
}
