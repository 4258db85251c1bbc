//! Displays that draw each message where its frame was at its stamp.
//!
//! Reproduces `rviz::MessageFilterDisplay` for the small displays: a message waits for its frame, is checked, and is
//! drawn at the place of its frame at its stamp. A message with NaN or infinity is an error, and the drawables stay.

use nalgebra::Isometry3;
use rcs_messages::{AnyMessage, TypedMessage};
use rcs_scene::Drawable;
use rcs_transforms::Time;

use crate::framework::display::{Display, TopicRequest};
use crate::framework::waiting_messages::WaitingMessages;
use crate::parts::history::MessageHistory;
use crate::{Level, Statuses, World};

/// A message has a number that is NaN or infinite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("Message contained invalid floating point values (nans or infs)")]
pub(crate) struct InvalidFloats;

/// Drawables of a message; `None` leaves what is shown.
pub(crate) type DrawResult = Result<Option<Vec<Drawable>>, InvalidFloats>;

/// Drawing of a type of message.
pub(crate) trait MessageVisual: Send {
    type Message: TypedMessage;

    /// Name of the status of an invalid message.
    const STATUS: &'static str = Statuses::TOPIC;

    /// Draws a message whose frame had this pose in the fixed frame at its stamp.
    ///
    /// # Errors
    /// [`InvalidFloats`]; then everything is as it was.
    fn draw(&mut self, message: &Self::Message, fixed_from_frame: &Isometry3<f64>) -> DrawResult;

    /// Drawables in the place of an invalid message's, where it replaces `next_to_go`; `None` leaves what is shown.
    fn instead(&self, _next_to_go: &[Drawable]) -> Option<Vec<Drawable>> {
        None
    }

    /// Fault of a message that is drawn nevertheless.
    fn fault(&self, _message: &Self::Message) -> Option<String> {
        None
    }

    fn reset(&mut self) {}
}

pub(crate) struct MessageDisplay<V: MessageVisual> {
    visual: V,
    topics: Vec<TopicRequest>,
    incoming: WaitingMessages<V::Message>,
    history: MessageHistory,
    statuses: Statuses,
}

impl<V: MessageVisual> MessageDisplay<V> {
    /// A display that subscribes to a topic (none when it is empty) and shows the last `history_length` messages, all
    /// of them for `None`. At most `queue_size` messages wait for their frames, 0 sets no limit.
    pub(crate) fn new(topic: &str, queue_size: u32, history_length: Option<u32>, visual: V) -> Self {
        Self {
            visual,
            topics: TopicRequest::new(topic, V::Message::KIND, queue_size).into_iter().collect(),
            incoming: WaitingMessages::new(queue_size),
            history: MessageHistory::new(history_length),
            statuses: Statuses::default(),
        }
    }

    /// Shows a message. Returns whether the drawables changed.
    pub(crate) fn show(
        &mut self,
        message: &V::Message,
        fixed_from_frame: &Isometry3<f64>,
    ) -> Result<bool, InvalidFloats> {
        let drawables = self.visual.draw(message, fixed_from_frame)?;
        let changed = drawables.is_some();
        drawables.into_iter().for_each(|drawables| self.history.push(drawables));
        Ok(changed)
    }
}

impl<V: MessageVisual> Display for MessageDisplay<V> {
    fn topics(&self) -> Vec<TopicRequest> {
        self.topics.clone()
    }

    fn take(&mut self, message: &AnyMessage, _world: &World<'_>) {
        let Some(message) = V::Message::from_any(message) else { return };
        if let Some(header) = message.header() {
            self.incoming.push(header, message.clone(), &mut self.statuses);
        }
    }

    fn is_waiting(&self, stamp: Time) -> bool {
        self.incoming.is_waiting(stamp)
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        let mut changed = false;
        // The last message decides: a good one clears the error of those before it.
        let mut last = None;
        for message in self.incoming.take_ready(world, &mut self.statuses) {
            let fixed_from_frame = message.header().and_then(|header| world.fixed_from_header(header).ok());
            let Some(fixed_from_frame) = fixed_from_frame else { continue };
            last = Some(match self.show(&message, &fixed_from_frame) {
                Ok(is_shown) => {
                    changed |= is_shown;
                    self.visual.fault(&message)
                }
                Err(error) => {
                    let instead = self.visual.instead(self.history.next_to_go());
                    changed |= instead.is_some();
                    instead.into_iter().for_each(|drawables| self.history.push(drawables));
                    Some(error.to_string())
                }
            });
        }
        match last {
            Some(Some(error)) => self.statuses.set(Level::Error, V::STATUS, error),
            // The count of messages has taken the place of an error of the topic.
            Some(None) if V::STATUS != Statuses::TOPIC => self.statuses.remove(V::STATUS),
            _ => {}
        }
        changed
    }

    fn drawables(&self) -> &[Drawable] {
        self.history.drawables()
    }

    fn reset(&mut self) {
        self.incoming.clear();
        self.visual.reset();
        self.history.clear();
        self.statuses.clear();
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::classes::pose::{self, PoseVisual};
    use crate::framework::test_world::TestWorld;
    use crate::parts::gathering::singly;
    use rcs_messages::geometry_msgs::PoseStamped;
    use rcs_rviz_config::{PoseSettings, PoseShape, PoseSymbolSettings};

    /// A Pose display of axes with the world around it. The frame `map` is fixed.
    struct Bench {
        display: MessageDisplay<PoseVisual>,
        world: TestWorld,
    }

    impl Bench {
        fn new() -> Self {
            let symbol = PoseSymbolSettings { shape: PoseShape::Axes, ..PoseSymbolSettings::default() };
            let settings = PoseSettings { topic: "/p".to_owned(), symbol, ..PoseSettings::default() };
            let world = TestWorld::at(Time::from_secs_nanos(10, 0));
            Self { display: pose::create(0, &settings), world }
        }

        /// Sends a pose at x in the frame `robot`, without an update.
        fn send(&mut self, secs: u32, x: f64) {
            let mut pose = PoseStamped::default();
            pose.header.frame_id = "robot".to_owned();
            pose.header.stamp.sec = secs;
            pose.pose.position.x = x;
            self.display.take(&AnyMessage::PoseStamped(Arc::new(pose)), &self.world.get());
        }

        fn update(&mut self) -> bool {
            self.display.update(&self.world.get())
        }

        fn place_robot(&mut self, secs: u32, x: f64) {
            self.world.place("robot", Time::from_secs_nanos(secs, 0), [x, 0.0, 0.0]);
        }

        /// Place of the y axis' foot along x.
        fn x(&self) -> Option<f64> {
            singly(self.display.drawables()).get(1).map(|axis| axis.sort_point.x)
        }

        fn topic_status(&self) -> Option<(Level, &str)> {
            let status = self.display.statuses().iter().find(|(name, _)| *name == Statuses::TOPIC)?.1;
            Some((status.level, status.text.as_str()))
        }
    }

    #[test]
    fn a_message_waits_for_its_frame_and_stays_where_that_was_at_its_stamp() {
        let mut bench = Bench::new();
        bench.send(2, 0.5);
        assert!(!bench.update());
        bench.place_robot(1, 10.0);
        assert!(!bench.update() && bench.x().is_none());
        bench.place_robot(3, 20.0);
        assert!(bench.update());
        assert_eq!(bench.x(), Some(15.5));
        bench.place_robot(4, 90.0);
        assert!(!bench.update());
        assert_eq!(bench.x(), Some(15.5));
    }

    #[test]
    fn a_bad_message_is_an_error_until_the_next_good_one_and_what_was_shown_stays() {
        let mut bench = Bench::new();
        bench.place_robot(1, 0.0);
        bench.send(1, 4.0);
        assert!(bench.update());
        bench.send(1, f64::NAN);
        assert!(!bench.update());
        assert_eq!(bench.x(), Some(4.0));
        let text = "Message contained invalid floating point values (nans or infs)";
        assert_eq!(bench.topic_status(), Some((Level::Error, text)));
        bench.send(1, f64::INFINITY);
        bench.send(1, 5.0);
        assert!(bench.update());
        assert_eq!(bench.x(), Some(5.0));
        assert_eq!(bench.topic_status(), Some((Level::Ok, "4 messages received")));
    }

    #[test]
    fn a_reset_display_shows_nothing_and_counts_from_zero() {
        let mut bench = Bench::new();
        bench.place_robot(1, 0.0);
        bench.send(1, 4.0);
        bench.update();
        bench.display.reset();
        assert_eq!((bench.x(), bench.topic_status()), (None, None));
        bench.send(1, 6.0);
        assert!(bench.update());
        assert_eq!((bench.x(), bench.topic_status()), (Some(6.0), Some((Level::Ok, "1 messages received"))));
    }
}
