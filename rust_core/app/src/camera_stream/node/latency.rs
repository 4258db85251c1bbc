//! How long the data take into a camera's pictures, and how old they are there.
//!
//! ```text
//!   received ──► decoded ──► drawn ──► published
//! ```
//!
//! Only new pictures are measured, and one message speaks for each of them. Of every display that shows another message
//! than in the picture before it is the newest one; older ones that it replaced are nobody's delay. Where several
//! displays are new in one picture, it is the message that was received first: a slow display is not hidden by a fast
//! one. A picture that is new only because frames moved counts from the last transforms. One without either, such as
//! the first for a subscriber or one in which something faded, is not measured.

use std::time::Instant;

use rcs_displays::ShownMessage;
use rcs_scene::{DisplayId, DisplayMask};
use rcs_transforms::Time;

use crate::camera_stream::recent::Recent;
use crate::camera_stream::report::{age_ms, figure};

/// How many pictures the figures are of.
const PICTURES: usize = 100;

/// Something received that is to be seen in the next picture.
#[derive(Clone, Copy, Debug)]
struct News {
    received: Instant,
    /// When the scene had it.
    decoded: Instant,
}

/// The figures of a camera's last new pictures.
#[derive(Debug, Default)]
pub(super) struct Latency {
    /// What the displays show since the last picture, one for each display, with its stamp.
    news: Vec<(DisplayId, News, Time)>,
    /// The last transforms since the last picture.
    moved: Option<News>,
    figures: Figures,
}

/// In milliseconds.
#[derive(Debug)]
struct Figures {
    received_to_decoded_ms: Recent<PICTURES>,
    decoded_to_drawn_ms: Recent<PICTURES>,
    drawn_to_published_ms: Recent<PICTURES>,
    received_to_published_ms: Recent<PICTURES>,
    age_ms: Recent<PICTURES>,
}

impl Default for Figures {
    fn default() -> Self {
        let none = Recent::new;
        Self {
            received_to_decoded_ms: none(),
            decoded_to_drawn_ms: none(),
            drawn_to_published_ms: none(),
            received_to_published_ms: none(),
            age_ms: none(),
        }
    }
}

/// What an update of the scene brought.
#[derive(Clone, Copy, Debug)]
pub(super) struct Update<'a> {
    /// The displays that show another message.
    pub(super) shown: &'a [(DisplayId, ShownMessage)],
    /// When the last transforms were received, if some were.
    pub(super) moved: Option<Instant>,
    /// When the scene was up to date.
    pub(super) decoded: Instant,
}

impl Latency {
    /// Takes note of what the next picture will show.
    pub(super) fn follow(&mut self, update: &Update<'_>, visible: &DisplayMask) {
        let Update { shown, moved, decoded } = *update;
        for (display, message) in shown.iter().filter(|(display, _)| visible.shows(*display)) {
            let Some(received) = message.received else { continue };
            let new = (*display, News { received, decoded }, message.stamp);
            match self.news.iter_mut().find(|(known, ..)| known == display) {
                Some(known) => *known = new,
                None => self.news.push(new),
            }
        }
        self.moved = moved.map(|received| News { received, decoded }).or(self.moved);
    }

    /// Forgets what was to be seen: there is no picture for it.
    pub(super) fn forget(&mut self) {
        self.news.clear();
        self.moved = None;
    }

    /// Takes the figures of a new picture. `stamp` is the picture's own, the ROS time of publishing.
    pub(super) fn measure(&mut self, drawn: Instant, published: Instant, stamp: Time) {
        let first = self.news.iter().map(|(_, news, _)| *news).min_by_key(|news| news.received).or(self.moved);
        let oldest = self.news.iter().filter_map(|(.., data)| age_ms(*data, stamp)).max_by(f64::total_cmp);
        self.forget();
        let Some(News { received, decoded }) = first else { return };
        let ms = |from: Instant, to: Instant| to.saturating_duration_since(from).as_secs_f64() * 1e3;
        let figures = &mut self.figures;
        figures.received_to_decoded_ms.push(ms(received, decoded));
        figures.decoded_to_drawn_ms.push(ms(decoded, drawn));
        figures.drawn_to_published_ms.push(ms(drawn, published));
        figures.received_to_published_ms.push(ms(received, published));
        if let Some(age_ms) = oldest {
            figures.age_ms.push(age_ms);
        }
    }

    /// The figures by their names.
    pub(super) fn values(&self) -> [(&'static str, String); 6] {
        let figures = &self.figures;
        let told = |recent: &Recent<PICTURES>| figure(recent.typical());
        [
            ("frames measured", figures.received_to_published_ms.len().to_string()),
            ("received to decoded ms (median / p95)", told(&figures.received_to_decoded_ms)),
            ("decoded to drawn ms (median / p95)", told(&figures.decoded_to_drawn_ms)),
            ("drawn to published ms (median / p95)", told(&figures.drawn_to_published_ms)),
            ("received to published ms (median / p95)", told(&figures.received_to_published_ms)),
            ("age of the data shown ms (median / p95)", told(&figures.age_ms)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

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
            self.latency.follow(&Update { shown: &shown, moved: None, decoded }, &visible);
        }

        fn turn(&mut self, received: u64, decoded: u64) {
            let (moved, decoded) = (Some(self.at(received)), self.at(decoded));
            self.latency.follow(&Update { shown: &[], moved, decoded }, &DisplayMask::all());
        }

        /// A picture, published when it is 100 s.
        fn publish(&mut self, drawn: u64, published: u64) {
            let (drawn, published) = (self.at(drawn), self.at(published));
            self.latency.measure(drawn, published, Time::from_secs_nanos(100, 0));
        }

        fn told(&self) -> [String; 6] {
            self.latency.values().map(|(_, value)| value)
        }
    }

    #[test]
    fn each_stage_is_told_and_together_they_are_the_whole() {
        let mut bench = Bench::new();
        assert_eq!(bench.told(), ["0", "-", "-", "-", "-", "-"]);
        bench.show(1, 0, 3, 98);
        bench.publish(13, 14);
        let stages = ["3.00 / 3.00", "10.00 / 10.00", "1.00 / 1.00", "14.00 / 14.00"];
        assert_eq!(bench.told()[1..5], stages);
        assert_eq!((&*bench.told()[0], &*bench.told()[5]), ("1", "2000.00 / 2000.00"));
    }

    #[test]
    fn of_a_display_the_newest_message_counts_and_of_displays_the_slowest() {
        let mut bench = Bench::new();
        bench.show(1, 0, 1, 10);
        bench.show(1, 20, 21, 99);
        bench.publish(22, 23);
        assert_eq!((&*bench.told()[4], &*bench.told()[5]), ("3.00 / 3.00", "1000.00 / 1000.00"));
        bench.show(1, 130, 131, 99);
        bench.show(2, 100, 131, 90);
        bench.publish(132, 133);
        assert_eq!((&*bench.told()[4], &*bench.told()[5]), ("3.00 / 33.00", "1000.00 / 10000.00"));
    }

    #[test]
    fn pictures_without_news_and_hidden_displays_are_not_measured() {
        let mut bench = Bench::new();
        bench.publish(1, 2);
        bench.show(9, 0, 1, 10);
        bench.publish(3, 4);
        bench.show(1, 0, 1, 10);
        bench.latency.forget();
        bench.publish(5, 6);
        assert_eq!(bench.told()[0], "0");
    }

    #[test]
    fn moved_frames_count_where_no_display_has_news_and_have_no_age() {
        let mut bench = Bench::new();
        bench.turn(0, 1);
        bench.turn(10, 11);
        bench.publish(15, 16);
        assert_eq!(bench.told()[4..], ["6.00 / 6.00", "-"]);
        bench.turn(90, 91);
        bench.show(1, 80, 91, 0);
        bench.publish(92, 93);
        assert_eq!(bench.told()[4..], ["6.00 / 13.00", "-"], "data without a stamp has no age");
        bench.publish(94, 95);
        assert_eq!(bench.told()[0], "2", "each is counted once");
    }
}
