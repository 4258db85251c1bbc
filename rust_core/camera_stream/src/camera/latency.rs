//! The latency from a message to a camera's image, step by step, and the age of the data shown.
//!
//! ```text
//!   received ──► decoded ──► drawn ──► published
//! ```
//!
//! Only new images are measured, each by one message. Of every display that shows another message than before, the
//! newest one counts; the older ones that it replaced delayed nothing. Where several displays changed in one image, the
//! message that was received first counts, so that a slow display is not hidden by a fast one. An image that is new
//! only because frames moved counts from the last transforms. One without either, such as the first for a subscriber,
//! is not measured.

use std::time::{Duration, Instant};

use rcs_camera::{figure, RollingWindow, StepTimes, IMAGES};
use rcs_displays::ShownMessage;
use rcs_scene::{DisplayId, DisplayMask};
use rcs_transforms::Time;

use crate::scene::status_tree::age_ms;

/// Arrival of a message or of transforms, and the time at which they were part of the scene.
#[derive(Clone, Copy, Debug)]
struct MessageTimes {
    received: Instant,
    decoded: Instant,
}

/// The figures of a camera's last new images.
#[derive(Debug, Default)]
pub(crate) struct Latency {
    /// The messages that are new since the last image, one for each display, with their stamps.
    messages: Vec<(DisplayId, MessageTimes, Time)>,
    /// The last transforms since the last image.
    transforms: Option<MessageTimes>,
    /// From received to decoded, to drawn, to published.
    steps: StepTimes<3>,
    age_ms: RollingWindow<IMAGES>,
    /// From looking up frames to publishing, of predicted images; milliseconds of ROS time.
    lookup_to_publish_ms: RollingWindow<IMAGES>,
}

/// The news of an update of the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Update<'a> {
    /// The displays that show another message.
    pub(crate) messages: &'a [(DisplayId, ShownMessage)],
    /// Arrival of the last transforms, if there are new ones.
    pub(crate) transforms_received: Option<Instant>,
    /// The time at which the scene was up to date.
    pub(crate) decoded: Instant,
}

impl Latency {
    /// Records the time from looking up frames to publishing the image.
    pub(crate) fn record_lookup_to_publish(&mut self, took: Duration) {
        self.lookup_to_publish_ms.push(took.as_secs_f64() * 1e3);
    }

    /// The median of what [`record_lookup_to_publish`](Self::record_lookup_to_publish) recorded.
    pub(crate) fn lookup_to_publish(&self) -> Option<Duration> {
        self.lookup_to_publish_ms.percentiles().map(|took| Duration::from_secs_f64(took.median / 1e3))
    }

    /// Records the news that the next image will show.
    pub(crate) fn record_update(&mut self, update: &Update<'_>, visible: &DisplayMask) {
        let Update { messages, transforms_received, decoded } = *update;
        for (display, message) in messages.iter().filter(|(display, _)| visible.shows(*display)) {
            let Some(received) = message.received else { continue };
            let new = (*display, MessageTimes { received, decoded }, message.stamp);
            match self.messages.iter_mut().find(|(known, ..)| known == display) {
                Some(known) => *known = new,
                None => self.messages.push(new),
            }
        }
        let transforms = transforms_received.map(|received| MessageTimes { received, decoded });
        self.transforms = transforms.or(self.transforms);
    }

    /// Forgets the news: there is no next image.
    pub(crate) fn forget(&mut self) {
        self.messages.clear();
        self.transforms = None;
    }

    /// Adds the figures of a new image. `stamp` is the image's own, the ROS time of publishing.
    pub(crate) fn measure(&mut self, drawn: Instant, published: Instant, stamp: Time) {
        let arrivals = self.messages.iter().map(|(_, arrival, _)| *arrival);
        let first = arrivals.min_by_key(|arrival| arrival.received).or(self.transforms);
        let oldest = self.messages.iter().filter_map(|(.., data)| age_ms(*data, stamp)).max_by(f64::total_cmp);
        self.forget();
        let Some(MessageTimes { received, decoded }) = first else { return };
        let steps = [(received, decoded), (decoded, drawn), (drawn, published)];
        let time = |(from, to): (Instant, Instant)| to.saturating_duration_since(from);
        self.steps.push(steps.map(time), time((received, published)));
        if let Some(age_ms) = oldest {
            self.age_ms.push(age_ms);
        }
    }

    /// Medians in milliseconds: from received to published, and the age of the data shown.
    pub(crate) fn medians_ms(&self) -> [Option<f64>; 2] {
        [self.steps.whole_ms(), &self.age_ms].map(|window| window.percentiles().map(|ms| ms.median))
    }

    /// The figures with their names.
    pub(crate) fn values(&self) -> [(&'static str, String); 6] {
        let text = |window: &RollingWindow<IMAGES>| figure(window.percentiles());
        let [to_decoded, to_drawn, to_published] = self.steps.steps_ms();
        [
            ("frames measured", self.steps.images().to_string()),
            ("received to decoded ms (median / p95)", text(to_decoded)),
            ("decoded to drawn ms (median / p95)", text(to_drawn)),
            ("drawn to published ms (median / p95)", text(to_published)),
            ("received to published ms (median / p95)", text(self.steps.whole_ms())),
            ("age of the data shown ms (median / p95)", text(&self.age_ms)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments in milliseconds after a start.
    struct Bench {
        start: Instant,
        latency: Latency,
    }

    impl Bench {
        fn new() -> Self {
            Self { start: Instant::now(), latency: Latency::default() }
        }

        fn at(&self, millis: u64) -> Instant {
            self.start + Duration::from_millis(millis)
        }

        /// A display shows a message that was received and decoded then.
        fn show(&mut self, display: DisplayId, received: u64, decoded: u64, stamp_secs: u32) {
            let (received, decoded) = (Some(self.at(received)), self.at(decoded));
            let shown = [(display, ShownMessage { stamp: Time::from_secs_nanos(stamp_secs, 0), received })];
            let mut visible = DisplayMask::all();
            visible.set(9, false);
            self.latency.record_update(&Update { messages: &shown, transforms_received: None, decoded }, &visible);
        }

        fn move_frames(&mut self, received: u64, decoded: u64) {
            let (transforms_received, decoded) = (Some(self.at(received)), self.at(decoded));
            self.latency.record_update(&Update { messages: &[], transforms_received, decoded }, &DisplayMask::all());
        }

        /// An image, published at 100 s.
        fn publish(&mut self, drawn: u64, published: u64) {
            let (drawn, published) = (self.at(drawn), self.at(published));
            self.latency.measure(drawn, published, Time::from_secs_nanos(100, 0));
        }

        fn values(&self) -> [String; 6] {
            self.latency.values().map(|(_, value)| value)
        }
    }

    #[test]
    fn the_steps_add_up_to_the_whole() {
        let mut bench = Bench::new();
        assert_eq!(bench.values(), ["0", "-", "-", "-", "-", "-"]);
        bench.show(1, 0, 3, 98);
        bench.publish(13, 14);
        let steps = ["3.00 / 3.00", "10.00 / 10.00", "1.00 / 1.00", "14.00 / 14.00"];
        assert_eq!(bench.values()[1..5], steps);
        assert_eq!((&*bench.values()[0], &*bench.values()[5]), ("1", "2000.00 / 2000.00"));
    }

    #[test]
    fn the_newest_message_of_the_slowest_display_counts() {
        let mut bench = Bench::new();
        bench.show(1, 0, 1, 10);
        bench.show(1, 20, 21, 99);
        bench.publish(22, 23);
        assert_eq!((&*bench.values()[4], &*bench.values()[5]), ("3.00 / 3.00", "1000.00 / 1000.00"));
        bench.show(1, 130, 131, 99);
        bench.show(2, 100, 131, 90);
        bench.publish(132, 133);
        assert_eq!((&*bench.values()[4], &*bench.values()[5]), ("3.00 / 33.00", "1000.00 / 10000.00"));
    }

    #[test]
    fn images_without_new_messages_and_hidden_displays_are_not_measured() {
        let mut bench = Bench::new();
        bench.publish(1, 2);
        bench.show(9, 0, 1, 10);
        bench.publish(3, 4);
        bench.show(1, 0, 1, 10);
        bench.latency.forget();
        bench.publish(5, 6);
        assert_eq!(bench.values()[0], "0");
    }

    #[test]
    fn moved_frames_count_where_no_display_has_a_new_message_and_have_no_age() {
        let mut bench = Bench::new();
        bench.move_frames(0, 1);
        bench.move_frames(10, 11);
        bench.publish(15, 16);
        assert_eq!(bench.values()[4..], ["6.00 / 6.00", "-"]);
        bench.move_frames(90, 91);
        bench.show(1, 80, 91, 0);
        bench.publish(92, 93);
        assert_eq!(bench.values()[4..], ["6.00 / 13.00", "-"], "data without a stamp has no age");
        bench.publish(94, 95);
        assert_eq!(bench.values()[0], "2", "each is counted once");
    }
}
