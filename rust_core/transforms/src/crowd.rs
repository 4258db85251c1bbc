//! A bound on the number of frames.
//!
//! tf2 keeps every name for ever. A publisher that makes up names, such as one that counts them up with each detection,
//! would fill memory and slow down everybody who goes over all frames. So a tree with more than [`FRAMES_ALWAYS_KEPT`] frames
//! forgets those of the later ones that were silent for [`SILENCE`], and one with [`MOST_FRAMES`] those that were
//! silent for longest, static ones last. The first [`FRAMES_ALWAYS_KEPT`] frames that were mentioned are kept, and so is every
//! frame on the way from one that stays to its root, unless that would be too many.

use std::collections::HashMap;
use std::time::Duration;

use crate::history::History;
use crate::tree::{FrameId, TransformTree};
use crate::Time;

/// A tree of no more frames forgets none.
pub const FRAMES_ALWAYS_KEPT: usize = 1000;
/// A tree has no more frames.
pub const MOST_FRAMES: usize = 5000;
/// Frames of a crowded tree whose newest transform is that much older than the newest of all are forgotten.
const SILENCE: Duration = Duration::from_secs(60);
/// After forgetting, so many are left of the most: it is not worth the while for a single frame.
const LEFT: usize = MOST_FRAMES / 2;
/// How often, in stamps, a crowded tree looks for silent frames.
const PERIOD: Duration = Duration::from_secs(10);

/// What a tree remembers about its crowd.
#[derive(Clone, Debug, Default)]
pub(crate) struct Crowd {
    /// The newest stamp of all transforms.
    newest: Time,
    /// The newest stamp when silent frames were last looked for.
    checked_at: Time,
    /// How many frames were forgotten.
    forgotten: u64,
}

impl TransformTree {
    /// How many frames were forgotten so far, because there were too many.
    pub fn forgotten_frames(&self) -> u64 {
        self.crowd.forgotten
    }

    /// Forgets frames if there are too many. `stamp` is that of the transform that was inserted.
    pub(crate) fn limit_frames(&mut self, stamp: Time) {
        self.crowd.newest = self.crowd.newest.max(stamp);
        if self.frames.len() <= FRAMES_ALWAYS_KEPT {
            return;
        }
        let (newest, checked_at) = (self.crowd.newest, self.crowd.checked_at);
        if self.frames.len() > MOST_FRAMES {
            self.forget_all_but(LEFT);
        } else if newest >= checked_at.saturating_add(PERIOD) || newest < checked_at {
            self.crowd.checked_at = newest;
            let is_silent = |stamp: Time| stamp.saturating_add(SILENCE) < newest;
            let silent = self.later_frames().filter(|(_, is_static, stamp)| !is_static && is_silent(*stamp));
            let silent: Vec<FrameId> = silent.map(|(id, _, _)| id).collect();
            self.forget(&silent);
        }
    }

    /// Time jumped back: the newest stamps are no measure any more.
    pub(crate) fn reset_crowd(&mut self) {
        (self.crowd.newest, self.crowd.checked_at) = (Time::ZERO, Time::ZERO);
    }

    /// The frames after the first [`FRAMES_ALWAYS_KEPT`]: whether they are static, and their newest stamp.
    fn later_frames(&self) -> impl Iterator<Item = (FrameId, bool, Time)> + '_ {
        self.frames.iter().enumerate().skip(FRAMES_ALWAYS_KEPT).map(|(index, frame)| {
            let is_static = matches!(frame.history, Some(History::Static(_)));
            let newest = frame.history.as_ref().and_then(History::newest);
            (FrameId(index as u32), is_static, newest.map_or(Time::ZERO, |newest| newest.stamp))
        })
    }

    /// Forgets later frames until so many are left, if that many are not on the way from another to its root.
    fn forget_all_but(&mut self, left: usize) {
        let mut later: Vec<_> = self.later_frames().collect();
        // Of equally silent ones the older.
        later.sort_by_key(|(id, is_static, stamp)| (*is_static, *stamp, id.0));
        let count = self.frames.len().saturating_sub(left).min(later.len());
        let obsolete: Vec<FrameId> = later.iter().take(count).map(|(id, _, _)| *id).collect();
        let mut stays = self.all_but(&obsolete);
        let without_parents = stays.clone();
        self.keep_parents(&mut stays);
        let is_enough = stays.iter().filter(|stays| **stays).count() <= MOST_FRAMES * 3 / 4;
        self.keep(if is_enough { stays } else { without_parents });
    }

    /// Forgets frames, except those on the way from one that stays to its root.
    fn forget(&mut self, obsolete: &[FrameId]) {
        if !obsolete.is_empty() {
            let mut stays = self.all_but(obsolete);
            self.keep_parents(&mut stays);
            self.keep(stays);
        }
    }

    /// For each frame whether it is none of these.
    fn all_but(&self, obsolete: &[FrameId]) -> Vec<bool> {
        let mut stays = vec![true; self.frames.len()];
        for id in obsolete {
            if let Some(stays) = stays.get_mut(id.0 as usize) {
                *stays = false;
            }
        }
        stays
    }

    /// Adds the frames on the way from those that stay to their roots.
    fn keep_parents(&self, stays: &mut [bool]) {
        let mut next: Vec<usize> = (0..stays.len()).filter(|index| stays.get(*index) == Some(&true)).collect();
        while let Some(index) = next.pop() {
            let history = self.frames.get(index).and_then(|frame| frame.history.as_ref());
            for parent in history.into_iter().flat_map(History::parents) {
                let parent = parent.0 as usize;
                if let Some(stays) = stays.get_mut(parent).filter(|stays| !**stays) {
                    *stays = true;
                    next.push(parent);
                }
            }
        }
    }

    /// Forgets all other frames, and the transforms that lead to them.
    fn keep(&mut self, stays: Vec<bool>) {
        let before = self.frames.len();
        let mut new_ids: HashMap<FrameId, FrameId> = HashMap::new();
        for (index, stays) in stays.iter().enumerate() {
            if *stays {
                new_ids.insert(FrameId(index as u32), FrameId(new_ids.len() as u32));
            }
        }
        let mut stays = stays.into_iter();
        self.frames.retain(|_| stays.next() == Some(true));
        for frame in &mut self.frames {
            let history = frame.history.take();
            frame.history = history.and_then(|history| history.with_parents(|parent| new_ids.get(&parent).copied()));
        }
        self.ids.retain(|_, id| new_ids.get(id).map(|new| *id = *new).is_some());
        self.ids.shrink_to_fit();
        self.frames.shrink_to_fit();
        self.crowd.forgotten += (before - self.frames.len()) as u64;
        self.generation += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RawTransform;

    fn insert(tree: &mut TransformTree, parent: &str, child: &str, secs: f64, is_static: bool) {
        let (translation, rotation_xyzw) = ([1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]);
        let transform = RawTransform { parent, child, stamp: Time::from_secs_f64(secs), translation, rotation_xyzw };
        tree.insert(&transform, is_static, "/a").unwrap();
    }

    /// Whether a frame is placed, up to the root that all have in common.
    fn is_placed(tree: &TransformTree, frame: &str) -> bool {
        let up = |frame: &&str| tree.parent_of(frame, Time::ZERO);
        std::iter::successors(Some(frame), up).last() == Some("map")
    }

    #[test]
    fn made_up_names_are_bounded_and_the_robot_stays() {
        let mut tree = TransformTree::new();
        insert(&mut tree, "map", "base", 100.0, false);
        insert(&mut tree, "base", "laser", 0.0, true);
        for number in 0..50_000 {
            let secs = 100.0 + f64::from(number) / 2000.0;
            insert(&mut tree, "base", &format!("box_{number}"), secs, false);
            if number % 100 == 0 {
                insert(&mut tree, "map", "base", secs, false);
            }
            assert!(tree.frames().count() <= MOST_FRAMES);
        }
        assert!(is_placed(&tree, "laser") && is_placed(&tree, "box_49999"));
        assert!(!tree.frame_exists("box_20000"));
        assert!(tree.forgotten_frames() > 40_000);
    }

    #[test]
    fn once_they_fall_silent_only_the_first_are_left() {
        let mut tree = TransformTree::new();
        insert(&mut tree, "map", "base", 100.0, false);
        for number in 0..4000 {
            insert(&mut tree, "base", &format!("box_{number}"), 100.0, false);
        }
        insert(&mut tree, "box_3999", "hand", 100.0, true);
        insert(&mut tree, "map", "base", 150.0, false);
        assert_eq!(tree.frames().count(), 4003);
        insert(&mut tree, "map", "base", 170.0, false);
        // The first thousand, what is static, and its parent.
        assert_eq!(tree.frames().count(), FRAMES_ALWAYS_KEPT + 2);
        assert!(is_placed(&tree, "box_10") && is_placed(&tree, "hand"));
        assert_eq!(tree.forgotten_frames(), 3001);
        insert(&mut tree, "base", "box_3000", 171.0, false);
        assert!(is_placed(&tree, "box_3000"), "it may come back");
    }

    #[test]
    fn static_names_are_bounded_too() {
        let mut tree = TransformTree::new();
        for number in 0..20_000 {
            insert(&mut tree, "map", &format!("tag_{number}"), 0.0, true);
            assert!(tree.frames().count() <= MOST_FRAMES);
        }
        assert!(is_placed(&tree, "tag_0") && is_placed(&tree, "tag_19999"));
    }

    #[test]
    fn a_chain_is_kept_whole_unless_it_alone_is_too_long() {
        let mut tree = TransformTree::new();
        insert(&mut tree, "map", "link_0", 1.0, false);
        let mut extend = |from: u32, to: u32| {
            for number in from..to {
                let names = [number, number + 1].map(|number| format!("link_{number}"));
                insert(&mut tree, &names[0], &names[1], f64::from(number + 2), false);
                assert!(tree.frames().count() <= MOST_FRAMES);
            }
            (is_placed(&tree, &format!("link_{to}")), is_placed(&tree, "link_900"))
        };
        assert_eq!(extend(0, 3000), (true, true));
        assert_eq!(extend(3000, 20_000), (false, true));
    }
}
