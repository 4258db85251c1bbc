//! A display of clouds, whatever messages they come from.

use std::sync::Arc;

use rcs_messages::std_msgs::Header;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_rviz_config::CloudSettings;
use rcs_scene::{DisplayId, Drawable};
use rcs_transforms::Time;

use super::{Clouds, Nowhere, PlacedCloud};
use crate::framework::display::{Display, TopicRequest};
use crate::framework::placed::Incoming;
use crate::framework::world::stamp;
use crate::{Level, Statuses, World};

/// A type of message that becomes clouds.
pub(crate) trait CloudSource {
    /// The messages.
    type Message: Send + Sync;

    /// Their type.
    const KIND: MessageKind;

    /// What becomes of points without a finite position.
    const NOWHERE: Nowhere;

    /// The message, if it is of this type.
    fn message(any: &AnyMessage) -> Option<&Arc<Self::Message>>;

    /// Its header.
    fn header(message: &Self::Message) -> &Header;

    /// The time until which its frame must be known, from its stamp on.
    fn end(message: &Self::Message) -> Time {
        stamp(Self::header(message))
    }

    /// The cloud that it is.
    ///
    /// # Errors
    /// The text of a status, where it is none.
    fn place(message: &Arc<Self::Message>, world: &World<'_>) -> Result<PlacedCloud, String>;
}

/// A display of clouds.
pub(crate) struct CloudDisplay<S: CloudSource> {
    topic: Option<TopicRequest>,
    incoming: Incoming<S::Message>,
    clouds: Clouds,
    statuses: Statuses,
}

impl<S: CloudSource> CloudDisplay<S> {
    pub(crate) fn new(display: DisplayId, settings: CloudSettings) -> Self {
        Self {
            topic: TopicRequest::new(&settings.topic, S::KIND, settings.queue_size),
            incoming: Incoming::new(settings.queue_size),
            clouds: Clouds::new(display, settings, S::NOWHERE),
            statuses: Statuses::default(),
        }
    }
}

impl<S: CloudSource> Display for CloudDisplay<S> {
    fn topics(&self) -> Vec<TopicRequest> {
        self.topic.iter().cloned().collect()
    }

    fn take(&mut self, message: &AnyMessage, _world: &World<'_>) {
        if let Some(message) = S::message(message) {
            self.incoming.push_until(S::header(message), S::end(message), message.clone(), &mut self.statuses);
        }
    }

    fn is_waiting(&self, stamp: Time) -> bool {
        self.incoming.is_waiting(stamp)
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        let mut ready = self.incoming.take_ready(world, &mut self.statuses);
        let keeps_one = self.clouds.keeps_one();
        if keeps_one {
            // Only the newest that can be shown would be seen.
            ready.reverse();
        }
        let mut new = Vec::new();
        for message in ready {
            match S::place(&message, world) {
                Ok(placed) => new.extend(self.clouds.decode(placed, &mut self.statuses)),
                Err(problem) => self.statuses.set(Level::Error, "Message", problem),
            }
            if keeps_one && !new.is_empty() {
                break;
            }
        }
        self.clouds.update(new, world.now)
    }

    fn drawables(&self) -> &[Drawable] {
        self.clouds.drawables()
    }

    fn next_change(&self) -> Option<Time> {
        self.clouds.next_change()
    }

    fn reset(&mut self) {
        self.incoming.clear();
        self.clouds.clear();
        self.statuses.clear();
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}
