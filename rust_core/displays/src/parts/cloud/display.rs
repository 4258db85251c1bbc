//! A display of clouds, whatever messages they come from.

use std::sync::Arc;

use rcs_messages::{AnyMessage, TypedMessage};
use rcs_rviz_config::CloudSettings;
use rcs_scene::{DisplayId, Drawable};
use rcs_transforms::Time;

use super::clouds::{Clouds, PlacedCloud};
use super::points::NonFinite;
use crate::framework::display::{Display, TopicRequest};
use crate::framework::waiting_messages::WaitingMessages;
use crate::framework::world::stamp;
use crate::{Level, StatusText, Statuses, World};

/// Conversion of a type of message to clouds.
pub(crate) trait CloudSource {
    type Message: TypedMessage;

    /// Treatment of points without a finite position.
    const NON_FINITE: NonFinite;

    /// Time until which its frame must be known, from its stamp on.
    fn end(message: &Self::Message) -> Time {
        message.header().map_or(Time::ZERO, stamp)
    }

    /// Sets or clears the statuses of a message when it arrives.
    fn announce(_message: &Self::Message, _statuses: &mut Statuses) {}

    /// Converts and places a message.
    fn place(message: &Arc<Self::Message>, world: &World<'_>) -> Result<PlacedCloud, StatusText>;
}

pub(crate) struct CloudDisplay<S: CloudSource> {
    topic: Option<TopicRequest>,
    incoming: WaitingMessages<S::Message>,
    clouds: Clouds,
    statuses: Statuses,
}

impl<S: CloudSource> CloudDisplay<S> {
    pub(crate) fn new(display: DisplayId, settings: CloudSettings) -> Self {
        Self {
            topic: TopicRequest::new(&settings.topic, S::Message::KIND, settings.queue_size),
            incoming: WaitingMessages::new(settings.queue_size),
            clouds: Clouds::new(display, settings, S::NON_FINITE),
            statuses: Statuses::default(),
        }
    }
}

impl<S: CloudSource> Display for CloudDisplay<S> {
    fn topics(&self) -> Vec<TopicRequest> {
        self.topic.iter().cloned().collect()
    }

    fn take(&mut self, message: &AnyMessage, _world: &World<'_>) {
        let Some(message) = S::Message::from_any(message) else { return };
        if let Some(header) = message.header() {
            S::announce(message, &mut self.statuses);
            self.incoming.push_until(header, S::end(message), message.clone(), &mut self.statuses);
        }
    }

    fn is_waiting(&self, stamp: Time) -> bool {
        self.incoming.is_waiting(stamp)
    }

    fn is_replaced_by_newest(&self) -> bool {
        self.clouds.keeps_one()
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        self.clouds.packs_points = world.packs_points;
        let mut ready = self.incoming.take_ready(world, &mut self.statuses);
        let keeps_one = self.clouds.keeps_one();
        if keeps_one {
            // Only the newest valid one would be visible.
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
