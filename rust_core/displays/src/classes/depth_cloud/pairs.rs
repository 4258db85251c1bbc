//! Pairs of depth and colour images of nearly equal stamps.
//!
//! rviz pairs them with the approximate time policy of ROS's `message_filters`, so this makes the same pairs for two
//! topics (see THIRD_PARTY.md). Each topic is a queue in the order of arrival, which is taken for that of the stamps. A
//! search moves a cursor through each queue: the cursor with the earlier stamp advances, and the two images under the
//! cursors are compared with the best pair so far. Images are used once, and pairs do not cross.
//!
//! ```text
//!   depth   1.00   1.10   1.20            the first two images make the pair 1.00 | 1.11;
//!                   ▲                     that of 1.10 | 1.11 is closer and takes its place,
//!   color   1.11                          and what lies before it is dropped
//!           ▲
//! ```
//!
//! The later image of the first pair of a search is its pivot: a pair without it belongs to the next search. So the
//! search ends when the pivot would be passed, or when a pair that ends later would have to begin after the pivot to be
//! better. Where one queue has run out, rviz relies on the images of a topic being half a second apart, so that most
//! pairs are known at once instead of one image later.

use std::collections::VecDeque;
use std::sync::Arc;

use rcs_messages::Image;

/// A pair must begin later by this much more than it ends later, to be better than an older one.
const AGE_PENALTY: f64 = 0.1;

/// The time between two images of a topic that the search relies on, in seconds.
const MIN_INTERVAL_SECS: f64 = 0.5;

pub(super) const DEPTH: usize = 0;

pub(super) const COLOR: usize = 1;

type Stamped = (f64, Arc<Image>);

#[derive(Debug)]
pub(super) struct Pairs {
    queue_size: usize,
    queues: [Queue; 2],
    best: Option<Best>,
}

#[derive(Debug, Default)]
struct Queue {
    /// While there is a best pair, its image is the first.
    images: VecDeque<Stamped>,
    /// Index of the image that is compared next; past the end where it has not come yet.
    cursor: usize,
    /// The queue was full: an image was dropped that may have been the better partner of the other topic's next one.
    has_dropped: bool,
}

#[derive(Clone, Copy, Debug)]
struct Best {
    start_secs: f64,
    end_secs: f64,
    pivot: usize,
    pivot_secs: f64,
}

impl Queue {
    fn stamp_secs(&self, index: usize) -> Option<f64> {
        self.images.get(index).map(|(secs, _)| *secs)
    }

    /// Stamp of an image, or the earliest possible one if it has not come yet.
    fn earliest_secs(&self, index: usize, best: &Best) -> f64 {
        let before = index.checked_sub(1).and_then(|before| self.stamp_secs(before));
        self.stamp_secs(index).unwrap_or_else(|| {
            before.map_or(best.pivot_secs, |before| (before + MIN_INTERVAL_SECS).max(best.pivot_secs))
        })
    }

    fn drop_passed(&mut self) {
        self.images.drain(..self.cursor);
        self.cursor = 0;
    }
}

impl Best {
    /// `true` if a pair that begins and ends at these times is better than this one.
    fn is_worse_than(&self, start_secs: f64, end_secs: f64) -> bool {
        start_secs - self.start_secs > self.cost(end_secs)
    }

    /// `true` if a pair that ends then or later would have to begin after the pivot to be better.
    fn is_final_at(&self, end_secs: f64) -> bool {
        self.pivot_secs - self.start_secs <= self.cost(end_secs)
    }

    /// Delay after this pair at which one that ends at `end_secs` must begin.
    fn cost(&self, end_secs: f64) -> f64 {
        (end_secs - self.end_secs) * (1.0 + AGE_PENALTY)
    }
}

/// The topics of the earlier and of the later of two times; of equal ones colour is the later.
fn in_order(times: [f64; 2]) -> (usize, usize) {
    if times[DEPTH] <= times[COLOR] {
        (DEPTH, COLOR)
    } else {
        (COLOR, DEPTH)
    }
}

impl Pairs {
    /// At most `queue_size` images of each topic wait.
    pub(super) fn new(queue_size: u32) -> Self {
        Self { queue_size: (queue_size as usize).max(1), queues: Default::default(), best: None }
    }

    /// Takes an image of [`DEPTH`] or [`COLOR`]; pairs that are complete with it are added to `out`, depth first.
    pub(super) fn add(&mut self, topic: usize, stamp_secs: f64, image: Arc<Image>, out: &mut Vec<[Arc<Image>; 2]>) {
        let Some(queue) = self.queues.get_mut(topic) else { return };
        queue.images.push_back((stamp_secs, image));
        if queue.cursor + 1 == queue.images.len() {
            self.search(out);
        }
        self.limit(topic, out);
    }

    /// Drops the oldest image of a queue that is too long; if a search was under way, it starts again without that
    /// image.
    fn limit(&mut self, topic: usize, out: &mut Vec<[Arc<Image>; 2]>) {
        if self.queues[topic].images.len() <= self.queue_size {
            return;
        }
        self.queues[topic].images.pop_front();
        self.queues[topic].has_dropped = true;
        self.queues.iter_mut().for_each(|queue| queue.cursor = 0);
        if self.best.take().is_some() {
            self.search(out);
        }
    }

    pub(super) fn images(&self) -> impl Iterator<Item = &Arc<Image>> {
        self.queues.iter().flat_map(|queue| &queue.images).map(|(_, image)| image)
    }

    pub(super) fn clear(&mut self) {
        (self.queues, self.best) = (Default::default(), None);
    }

    /// The stamps of the images under the cursors; `None` while one has not come.
    fn stamps_secs(&self) -> Option<[f64; 2]> {
        let [depth, color] = &self.queues;
        Some([depth.stamp_secs(depth.cursor)?, color.stamp_secs(color.cursor)?])
    }

    /// Compares images until one is missing, and outputs the pairs that are final.
    fn search(&mut self, out: &mut Vec<[Arc<Image>; 2]>) {
        while let Some(times) = self.stamps_secs() {
            let (start, end) = in_order(times);
            let (start_secs, end_secs) = (times[start], times[end]);
            self.queues[start].has_dropped = false;
            if self.best.is_none() && self.queues[end].has_dropped {
                // What was dropped may have been the partner of this one.
                self.queues[start].images.pop_front();
                continue;
            }
            let best = match self.best {
                Some(best) if !best.is_worse_than(start_secs, end_secs) => best,
                before => {
                    self.queues.iter_mut().for_each(Queue::drop_passed);
                    let (pivot, pivot_secs) = before.map_or((end, end_secs), |best| (best.pivot, best.pivot_secs));
                    Best { start_secs, end_secs, pivot, pivot_secs }
                }
            };
            self.best = Some(best);
            self.queues[start].cursor += 1;
            if start == best.pivot || best.is_final_at(end_secs) || self.is_final_already(&best) {
                self.output(out);
            }
        }
    }

    /// Where one queue has run out: `true` if the best pair stays so, whatever comes on that topic.
    fn is_final_already(&self, best: &Best) -> bool {
        if self.stamps_secs().is_some() {
            return false;
        }
        let mut cursors = [self.queues[DEPTH].cursor, self.queues[COLOR].cursor];
        loop {
            let times = [DEPTH, COLOR].map(|topic| self.queues[topic].earliest_secs(cursors[topic], best));
            let (start, end) = in_order(times);
            if best.is_final_at(times[end]) {
                return true;
            }
            let has_come = cursors[start] < self.queues[start].images.len();
            if !has_come || best.is_worse_than(times[start], times[end]) {
                return false;
            }
            cursors[start] += 1;
        }
    }

    fn output(&mut self, out: &mut Vec<[Arc<Image>; 2]>) {
        self.best = None;
        self.queues.iter_mut().for_each(|queue| queue.cursor = 0);
        let [depth, color] = &mut self.queues;
        if let (Some((_, depth)), Some((_, color))) = (depth.images.pop_front(), color.images.pop_front()) {
            out.push([depth, color]);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Adds images by topic and stamp; gives the pairs by their stamps, with the position of the one that completed it.
    fn pairs(queue_size: u32, images: &[(usize, f64)]) -> Vec<(usize, f64, f64)> {
        let mut pairs = Pairs::new(queue_size);
        let mut all = Vec::new();
        for (i, (topic, secs)) in images.iter().enumerate() {
            let mut image = Image::default();
            image.step = (secs * 1000.0).round() as u32;
            let mut out = Vec::new();
            pairs.add(*topic, *secs, Arc::new(image), &mut out);
            all.extend(out.iter().map(|[d, c]| (i, f64::from(d.step) / 1000.0, f64::from(c.step) / 1000.0)));
        }
        all
    }

    #[test]
    fn images_of_one_stamp_are_a_pair_at_once() {
        let images = [(COLOR, 1.0), (DEPTH, 1.0), (DEPTH, 2.0), (COLOR, 2.0), (COLOR, 2.0), (DEPTH, 2.0)];
        assert_eq!(pairs(5, &images), [(1, 1.0, 1.0), (3, 2.0, 2.0), (5, 2.0, 2.0)]);
    }

    #[test]
    fn images_of_nearly_one_stamp_are_a_pair() {
        let images = [(DEPTH, 1.0), (COLOR, 1.004), (DEPTH, 1.033), (COLOR, 1.037), (COLOR, 1.07), (DEPTH, 1.066)];
        assert_eq!(pairs(5, &images), [(1, 1.0, 1.004), (3, 1.033, 1.037), (5, 1.066, 1.07)]);
    }

    #[test]
    fn the_nearest_image_is_the_partner_and_the_others_stay_alone() {
        // Depth images at 10 Hz wait for the first colour image, which belongs to the second of them.
        let images = [(DEPTH, 1.0), (DEPTH, 1.1), (DEPTH, 1.2), (COLOR, 1.11)];
        assert_eq!(pairs(5, &images), [(3, 1.1, 1.11)]);
    }

    #[test]
    fn the_oldest_image_of_a_full_queue_is_dropped() {
        let images: Vec<_> = (0..9).map(|i| (DEPTH, f64::from(i))).chain([(COLOR, 1.2), (COLOR, 8.1)]).collect();
        assert_eq!(pairs(2, &images), [(10, 8.0, 8.1)], "that at 1 s is gone, and with it what could be near it");
    }

    proptest! {
        #[test]
        fn each_image_is_used_once_and_pairs_do_not_cross(
            queue_size in 1..8_u32,
            // Milliseconds since the topic's previous image; none for images of equal stamps.
            steps in prop::collection::vec((0..2_usize, prop_oneof![0..5_u32, 0..100_u32, 0..2000_u32]), 0..60),
        ) {
            let mut stamps_ms = [0; 2];
            let images: Vec<(usize, f64)> = steps
                .into_iter()
                .map(|(topic, step_ms)| {
                    stamps_ms[topic] += step_ms;
                    (topic, f64::from(stamps_ms[topic]) / 1000.0)
                })
                .collect();
            let pairs = pairs(queue_size, &images);
            prop_assert!(pairs.windows(2).all(|two| two[0].1 <= two[1].1 && two[0].2 <= two[1].2), "{pairs:?}");
            for (topic, name) in [(DEPTH, "depth"), (COLOR, "color")] {
                let of_pair = |pair: &(usize, f64, f64)| if topic == DEPTH { pair.1 } else { pair.2 };
                for pair in &pairs {
                    let stamp = of_pair(pair);
                    let uses = pairs.iter().filter(|other| of_pair(other) == stamp).count();
                    let sent = images.iter().filter(|image| **image == (topic, stamp)).count();
                    prop_assert!(uses <= sent, "the {name} image of {stamp} is used {uses} times: {pairs:?}");
                }
            }
        }
    }
}
