//! Which colour image belongs to which depth image: the approximate time policy of ROS's `message_filters`.
//!
//! Of the images that have come, in the order of their stamps on each topic, that pair is found whose stamps are nearest
//! to each other, in such a way that each image is used once and pairs do not cross. A pair is handed out as soon as no
//! image that may still come could make a better one; rviz promises that images of a topic are half a second apart,
//! which makes it hand out most pairs at once. The pair around the image that was latest when the search began (the
//! pivot) is searched for; age counts against later candidates a little.

use std::collections::VecDeque;
use std::sync::Arc;

use rcs_messages::Image;

/// How much worse a later candidate counts than an earlier one.
const AGE_PENALTY: f64 = 0.1;

/// The least time between two images of a topic that the search relies on, in seconds.
const LEAST_INTERVAL_SECS: f64 = 0.5;

/// The index of depth images.
pub(super) const DEPTH: usize = 0;

/// The index of colour images.
pub(super) const COLOR: usize = 1;

/// An image with its stamp in seconds.
type Stamped = (f64, Arc<Image>);

/// The images that have no partner yet.
#[derive(Debug)]
pub(super) struct Pairs {
    queue_size: usize,
    topics: [Topic; 2],
    candidate: Option<Candidate>,
}

#[derive(Debug, Default)]
struct Topic {
    /// Not looked at yet; the first is looked at.
    waiting: VecDeque<Stamped>,
    /// Looked at since the candidate was found, which is the first of them (or of those waiting).
    past: VecDeque<Stamped>,
    /// An image was dropped that could have been a better partner.
    has_dropped: bool,
}

/// The best pair so far.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    start_secs: f64,
    end_secs: f64,
    pivot: usize,
    pivot_secs: f64,
}

impl Topic {
    fn look_away(&mut self) {
        self.past.extend(self.waiting.pop_front());
    }

    fn look_back(&mut self, count: usize) {
        for _ in 0..count {
            if let Some(image) = self.past.pop_back() {
                self.waiting.push_front(image);
            }
        }
    }
}

/// Which of two times is the later one and which the earlier one; of equal ones the second is later.
fn later_and_earlier(times: [f64; 2]) -> (usize, usize) {
    if times[1] >= times[0] {
        (1, 0)
    } else {
        (0, 1)
    }
}

impl Pairs {
    /// At most `queue_size` images of each topic wait.
    pub(super) fn new(queue_size: u32) -> Self {
        Self { queue_size: (queue_size as usize).max(1), topics: Default::default(), candidate: None }
    }

    /// Takes an image of [`DEPTH`] or [`COLOR`]; pairs that are complete with it are added to `out`, depth first.
    pub(super) fn add(&mut self, topic: usize, stamp_secs: f64, image: Arc<Image>, out: &mut Vec<[Arc<Image>; 2]>) {
        let Some(of_topic) = self.topics.get_mut(topic) else { return };
        of_topic.waiting.push_back((stamp_secs, image));
        if of_topic.waiting.len() == 1 {
            self.search(out);
        }
        let Some(of_topic) = self.topics.get(topic) else { return };
        if of_topic.waiting.len() + of_topic.past.len() > self.queue_size {
            self.look_back_to_all();
            if let Some(of_topic) = self.topics.get_mut(topic) {
                of_topic.waiting.pop_front();
                of_topic.has_dropped = true;
            }
            if self.candidate.take().is_some() {
                self.search(out);
            }
        }
    }

    /// The images that have no partner yet.
    pub(super) fn images(&self) -> impl Iterator<Item = &Arc<Image>> {
        self.topics.iter().flat_map(|topic| topic.past.iter().chain(&topic.waiting)).map(|(_, image)| image)
    }

    /// Forgets all images.
    pub(super) fn clear(&mut self) {
        (self.topics, self.candidate) = (Default::default(), None);
    }

    fn look_back_to_all(&mut self) {
        for topic in &mut self.topics {
            topic.look_back(topic.past.len());
        }
    }

    /// The stamps of the images that are looked at; `None` while one is missing.
    fn fronts(&self) -> Option<[f64; 2]> {
        let [depth, color] = &self.topics;
        Some([depth.waiting.front()?.0, color.waiting.front()?.0])
    }

    fn search(&mut self, out: &mut Vec<[Arc<Image>; 2]>) {
        while let Some(times) = self.fronts() {
            let (end, start) = later_and_earlier(times);
            let (end_secs, start_secs) = (times[end], times[start]);
            self.topics[start].has_dropped = false;
            let new = match self.candidate {
                None if self.topics[end].has_dropped => {
                    self.topics[start].waiting.pop_front();
                    continue;
                }
                None => Some(Candidate { start_secs, end_secs, pivot: end, pivot_secs: end_secs }),
                Some(best) => {
                    is_better(&best, start_secs, end_secs).then_some(Candidate { start_secs, end_secs, ..best })
                }
            };
            if new.is_some() {
                self.topics.iter_mut().for_each(|topic| topic.past.clear());
                self.candidate = new;
            }
            let Some(best) = self.candidate else { break };
            self.topics[start].look_away();
            if start == best.pivot || cannot_be_beaten(&best, end_secs) || self.nothing_better_can_come(&best) {
                self.hand_out(out);
            }
        }
    }

    /// Whether the best pair stays so, whatever comes on the topic that nothing waits of.
    fn nothing_better_can_come(&mut self, best: &Candidate) -> bool {
        let mut looked_away = [0; 2];
        let is_best = loop {
            if self.fronts().is_some() && looked_away == [0; 2] {
                break false;
            }
            let earliest = |topic: &Topic| match (topic.waiting.front(), topic.past.back()) {
                (Some((secs, _)), _) => *secs,
                (None, Some((secs, _))) => (secs + LEAST_INTERVAL_SECS).max(best.pivot_secs),
                (None, None) => best.pivot_secs,
            };
            let times = [earliest(&self.topics[DEPTH]), earliest(&self.topics[COLOR])];
            let (end, start) = later_and_earlier(times);
            if cannot_be_beaten(best, times[end]) {
                break true;
            }
            if is_better(best, times[start], times[end]) || self.topics[start].waiting.is_empty() {
                break false;
            }
            self.topics[start].look_away();
            looked_away[start] += 1;
        };
        for (topic, count) in self.topics.iter_mut().zip(looked_away) {
            topic.look_back(count);
        }
        is_best
    }

    fn hand_out(&mut self, out: &mut Vec<[Arc<Image>; 2]>) {
        self.candidate = None;
        self.look_back_to_all();
        let [depth, color] = &mut self.topics;
        if let (Some((_, depth)), Some((_, color))) = (depth.waiting.pop_front(), color.waiting.pop_front()) {
            out.push([depth, color]);
        }
    }
}

/// Whether a pair between two times is better than the best so far.
fn is_better(best: &Candidate, start_secs: f64, end_secs: f64) -> bool {
    (end_secs - best.end_secs) * (1.0 + AGE_PENALTY) < start_secs - best.start_secs
}

/// Whether no pair that ends at a time or later is better, because it would have to begin after the pivot.
fn cannot_be_beaten(best: &Candidate, end_secs: f64) -> bool {
    (end_secs - best.end_secs) * (1.0 + AGE_PENALTY) >= best.pivot_secs - best.start_secs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds images by topic and stamp; gives the pairs by their stamps, with the position of the one that completed it.
    fn pairs(queue_size: u32, images: &[(usize, f64)]) -> Vec<(usize, f64, f64)> {
        let mut pairs = Pairs::new(queue_size);
        let mut all = Vec::new();
        for (i, (topic, secs)) in images.iter().enumerate() {
            let mut image = Image::default();
            image.step = (secs * 1000.0) as u32;
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
    fn the_oldest_gives_way_where_too_many_wait() {
        let images: Vec<_> = (0..9).map(|i| (DEPTH, f64::from(i))).chain([(COLOR, 1.2), (COLOR, 8.1)]).collect();
        assert_eq!(pairs(2, &images), [(10, 8.0, 8.1)], "that at 1 s is gone, and with it what could be near it");
    }
}
