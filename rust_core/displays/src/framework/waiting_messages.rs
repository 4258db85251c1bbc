//! Messages that wait until their frame is known, with rviz's statuses for that.

use std::sync::Arc;

use rcs_messages::std_msgs::Header;
use rcs_transforms::{Time, WaitingQueue};

use crate::framework::display::bounded;
use crate::framework::frame;
use crate::framework::world::stamp;
use crate::{Level, Statuses, World};

/// Queue of one topic's messages that cannot be placed yet.
#[derive(Debug)]
pub(crate) struct WaitingMessages<M> {
    queue: WaitingQueue<Arc<M>>,
    received: u64,
    /// Number of drops that the statuses report.
    reported_drops: u64,
}

impl<M> WaitingMessages<M> {
    pub(crate) fn new(queue_size: u32) -> Self {
        Self { queue: WaitingQueue::new(bounded(queue_size)), received: 0, reported_drops: 0 }
    }

    pub(crate) fn push(&mut self, header: &Header, message: Arc<M>, statuses: &mut Statuses) {
        self.push_until(header, stamp(header), message, statuses);
    }

    /// Adds a message whose frame must be known both at its stamp and at `end`.
    pub(crate) fn push_until(&mut self, header: &Header, end: Time, message: Arc<M>, statuses: &mut Statuses) {
        self.received += 1;
        statuses.set(Level::Ok, Statuses::TOPIC, format!("{} messages received", self.received));
        self.queue.push_until(&header.frame_id, stamp(header), end, message);
    }

    pub(crate) fn take_ready(&mut self, world: &World<'_>, statuses: &mut Statuses) -> Vec<Arc<M>> {
        if self.queue.is_empty() && self.queue.dropped().total() == self.reported_drops {
            return Vec::new();
        }
        let ready = self.queue.take_ready(world.transforms, world.fixed_frame);
        self.report_drops(world, statuses);
        if !ready.is_empty() {
            statuses.set(Level::Ok, Statuses::TRANSFORM, "Transform OK");
        } else if let Some(reason) = self.queue.waiting_reason(world.transforms, world.fixed_frame) {
            // The error of a drop stays until a message can be placed.
            if statuses.get(Statuses::TRANSFORM).is_none_or(|status| status.level < Level::Error) {
                statuses.set(Level::Warn, Statuses::TRANSFORM, frame::problem(&reason, world.fixed_frame));
            }
        }
        ready
    }

    pub(crate) fn is_waiting(&self, stamp: Time) -> bool {
        self.queue.stamps().any(|waiting| waiting == stamp)
    }

    /// Sets the statuses of dropped messages.
    fn report_drops(&mut self, world: &World<'_>, statuses: &mut Statuses) {
        let counts = self.queue.dropped();
        if counts.total() == self.reported_drops {
            return;
        }
        self.reported_drops = counts.total();
        if let Some(dropped) = self.queue.last_dropped() {
            statuses.set(Level::Error, Statuses::TRANSFORM, frame::drop_reason(dropped, world.fixed_frame));
        }
        let by_reason =
            [(counts.queue_full, "queue full"), (counts.too_old, "too old"), (counts.empty_frame, "no frame")];
        let by_reason = by_reason.iter().filter(|(count, _)| *count > 0);
        let by_reason: Vec<String> = by_reason.map(|(count, reason)| format!("{count} {reason}")).collect();
        let text = format!("{} messages dropped: {}", counts.total(), by_reason.join(", "));
        statuses.set(Level::Ok, "Dropped", text);
    }

    pub(crate) fn clear(&mut self) {
        self.queue.clear();
        self.received = 0;
    }
}

#[cfg(test)]
mod tests {
    use rcs_resources::{MeshStore, PackageIndex};
    use rcs_transforms::{RawTransform, TransformTree};

    use super::*;

    fn place(tree: &mut TransformTree, secs: u32) {
        let (translation, rotation_xyzw) = ([0.0; 3], [0.0, 0.0, 0.0, 1.0]);
        let stamp = Time::from_secs_nanos(secs, 0);
        let transform = RawTransform { parent: "map", child: "arm", stamp, translation, rotation_xyzw };
        tree.insert(&transform, false, "/a").unwrap();
    }

    fn header(secs: u32, frame: &str) -> Header {
        let stamp = rcs_messages::Time { sec: secs, nsec: 0 };
        Header { seq: 0, stamp, frame_id: frame.to_owned() }
    }

    #[test]
    fn a_drop_is_an_error_until_a_message_can_be_placed_and_its_count_stays() {
        let mut tree = TransformTree::new();
        let meshes = MeshStore::new(PackageIndex::new([]));
        let (mut incoming, mut statuses) = (WaitingMessages::new(1), Statuses::default());
        let update = |incoming: &mut WaitingMessages<()>, tree: &TransformTree, statuses: &mut Statuses| {
            let world = World::new(tree, "map", Time::ZERO, &meshes);
            let ready = incoming.take_ready(&world, statuses).len();
            let status = statuses.get(Statuses::TRANSFORM).unwrap();
            (ready, status.level, status.text.clone())
        };
        place(&mut tree, 1000);
        incoming.push(&header(1001, "arm"), Arc::new(()), &mut statuses);
        let (ready, level, text) = update(&mut incoming, &tree, &mut statuses);
        assert_eq!((ready, level), (0, Level::Warn), "{text}");
        assert!(text.starts_with("For frame [arm]: No transform to fixed frame [map].  TF error: ["), "{text}");
        incoming.push(&header(0, ""), Arc::new(()), &mut statuses);
        for _ in 0..2 {
            let dropped = (0, Level::Error, "For frame []: Frame [] does not exist".to_owned());
            assert_eq!(update(&mut incoming, &tree, &mut statuses), dropped);
        }
        place(&mut tree, 1001);
        for _ in 0..2 {
            let (_, level, text) = update(&mut incoming, &tree, &mut statuses);
            assert_eq!((level, text.as_str()), (Level::Ok, "Transform OK"));
        }
        assert_eq!(statuses.get("Dropped").unwrap().text, "1 messages dropped: 1 no frame");

        place(&mut tree, 9000);
        incoming.push(&header(7, "arm"), Arc::new(()), &mut statuses);
        let (_, level, text) = update(&mut incoming, &tree, &mut statuses);
        let old = "Message removed because it is too old (frame=[arm], stamp=[7.000000000])";
        assert_eq!((level, text.as_str()), (Level::Error, old));
        assert_eq!(statuses.get("Dropped").unwrap().text, "2 messages dropped: 1 too old, 1 no frame");
    }

    #[test]
    fn so_many_messages_wait_as_the_config_says_and_a_large_number_without_a_limit_there() {
        for (queue_size, most) in [(2, 2), (0, 1000)] {
            let (mut incoming, mut statuses) = (WaitingMessages::new(queue_size), Statuses::default());
            let received = Arc::new(());
            for secs in 1..=1500 {
                incoming.push(&header(secs, "arm"), Arc::clone(&received), &mut statuses);
            }
            assert_eq!(Arc::strong_count(&received) - 1, most, "Queue Size {queue_size}");
            assert!(incoming.is_waiting(stamp(&header(1500, "arm"))), "the newest are kept");
        }
    }
}
