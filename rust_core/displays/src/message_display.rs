//! Displays that make something of each message where its frame was at its stamp.
//!
//! Reproduces what `rviz::MessageFilterDisplay` does for the small displays: a message waits for its frame, is checked,
//! and is drawn at the place that its frame had at its stamp, wherever the frame goes afterwards. A message with a number
//! that is NaN or infinite becomes an error, and what was shown before it stays.

use std::sync::Arc;

use nalgebra::Isometry3;
use rcs_messages::std_msgs::Header;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_scene::Drawable;

use crate::display::{Display, TopicRequest};
use crate::placed::Incoming;
use crate::{Level, Statuses, World};

/// A message has a number that is NaN or infinite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("Message contained invalid floating point values (nans or infs)")]
pub(crate) struct InvalidFloats;

/// What a display makes of its messages.
pub(crate) trait MessageVisual: Send {
    /// What it listens to.
    type Message: Send + Sync;

    /// The same, by name.
    const KIND: MessageKind;

    /// The message, if it is one of this type.
    fn message(any: &AnyMessage) -> Option<&Arc<Self::Message>>;

    /// The message's header.
    fn header(message: &Self::Message) -> &Header;

    /// Shows a message whose frame stood there in the fixed frame at its stamp. Returns whether its drawables changed.
    ///
    /// # Errors
    /// [`InvalidFloats`]; then everything is as it was.
    fn show(&mut self, message: &Self::Message, fixed_from_frame: &Isometry3<f64>) -> Result<bool, InvalidFloats>;

    /// What it shows.
    fn drawables(&self) -> &[Drawable];

    /// Shows nothing any more.
    fn clear(&mut self);
}

/// A display of a [`MessageVisual`].
pub(crate) struct MessageDisplay<V: MessageVisual> {
    visual: V,
    topics: Vec<TopicRequest>,
    incoming: Incoming<V::Message>,
    statuses: Statuses,
}

impl<V: MessageVisual> MessageDisplay<V> {
    /// A display that listens to a topic (none when it is empty); at most `queue_size` messages wait for their frames, 0
    /// sets no limit.
    pub(crate) fn new(topic: &str, queue_size: u32, visual: V) -> Self {
        Self {
            visual,
            topics: TopicRequest::new(topic, V::KIND, queue_size).into_iter().collect(),
            incoming: Incoming::new(queue_size),
            statuses: Statuses::default(),
        }
    }

    /// What it draws with.
    #[cfg(test)]
    pub(crate) fn into_visual(self) -> V {
        self.visual
    }
}

impl<V: MessageVisual> Display for MessageDisplay<V> {
    fn topics(&self) -> Vec<TopicRequest> {
        self.topics.clone()
    }

    fn take(&mut self, message: &AnyMessage, _world: &World<'_>) {
        if let Some(message) = V::message(message) {
            self.incoming.push(V::header(message), message.clone(), &mut self.statuses);
        }
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        let mut changed = false;
        // The last message decides: each one that is good takes the complaint about those before it away.
        let mut last = Ok(());
        for message in self.incoming.take_ready(world, &mut self.statuses) {
            let Ok(fixed_from_frame) = world.fixed_from_header(V::header(&message)) else { continue };
            let shown = self.visual.show(&message, &fixed_from_frame);
            changed |= shown == Ok(true);
            last = shown.map(|_| ());
        }
        if let Err(error) = last {
            self.statuses.set(Level::Error, "Topic", error.to_string());
        }
        changed
    }

    fn drawables(&self) -> &[Drawable] {
        self.visual.drawables()
    }

    fn reset(&mut self) {
        self.incoming.clear();
        self.visual.clear();
        self.statuses.clear();
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}
