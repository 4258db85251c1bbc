//! The frames of a tree by name, and a bound on their number.
//!
//! Names are interned: a lookup hashes its two names once and then follows indices. tf2 keeps every name for ever; a
//! publisher that makes up names, such as one per detection, would fill memory and slow down everything that goes over
//! all frames. So above [`FRAMES_ALWAYS_KEPT`] frames the later ones that were silent for [`SILENCE`] are forgotten,
//! and above [`MOST_FRAMES`] those that were silent for longest, static ones last. The first [`FRAMES_ALWAYS_KEPT`]
//! frames stay, and so does every frame between one that stays and its root, unless that would be too many.

use std::collections::HashMap;
use std::time::Duration;

use crate::history::History;
use crate::sample::FrameId;
use crate::Time;

/// Frames of a tree that are never forgotten: the first ones.
pub const FRAMES_ALWAYS_KEPT: usize = 1000;
/// Largest number of frames of a tree.
pub const MOST_FRAMES: usize = 5000;
/// Age behind the newest transform of all at which a frame may be forgotten.
const SILENCE: Duration = Duration::from_secs(60);
/// Frames left after the number was exceeded; forgetting one at a time would be slow.
const LEFT: usize = MOST_FRAMES / 2;
/// Period, in stamps, of the search for silent frames.
const PERIOD: Duration = Duration::from_secs(10);

#[derive(Clone, Debug)]
struct FrameEntry {
    name: String,
    /// `None` for roots, which no transform places in a parent.
    history: Option<History>,
}

/// Frames with their histories, in the order of their first mention.
#[derive(Clone, Debug, Default)]
pub(crate) struct Frames {
    entries: Vec<FrameEntry>,
    ids: HashMap<String, FrameId>,
    /// Newest stamp of all transforms.
    newest: Time,
    /// Value of `newest` at the last search for silent frames.
    searched_at: Time,
    /// Frames forgotten so far.
    pub(crate) forgotten: u64,
}

impl Frames {
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|entry| entry.name.as_str())
    }

    /// The frame of a name without leading slash.
    pub(crate) fn id(&self, name: &str) -> Option<FrameId> {
        self.ids.get(name).copied()
    }

    pub(crate) fn name(&self, id: FrameId) -> &str {
        self.entries.get(id.0 as usize).map_or("", |entry| &entry.name)
    }

    pub(crate) fn history(&self, id: FrameId) -> Option<&History> {
        self.entries.get(id.0 as usize)?.history.as_ref()
    }

    pub(crate) fn history_mut(&mut self, id: FrameId) -> Option<&mut Option<History>> {
        self.entries.get_mut(id.0 as usize).map(|entry| &mut entry.history)
    }

    pub(crate) fn intern(&mut self, name: &str) -> FrameId {
        if let Some(id) = self.id(name) {
            return id;
        }
        // Four thousand million names do not fit into memory.
        let id = FrameId(self.entries.len() as u32);
        self.entries.push(FrameEntry { name: name.to_owned(), history: None });
        self.ids.insert(name.to_owned(), id);
        id
    }

    /// Removes all samples of moving frames, for a jump in time.
    pub(crate) fn clear_moving(&mut self) {
        self.entries.iter_mut().filter_map(|entry| entry.history.as_mut()).for_each(History::clear);
        (self.newest, self.searched_at) = (Time::ZERO, Time::ZERO);
    }

    /// Forgets frames if there are too many. `stamp` is of the transform that was inserted.
    pub(crate) fn limit(&mut self, stamp: Time) {
        self.newest = self.newest.max(stamp);
        if self.entries.len() <= FRAMES_ALWAYS_KEPT {
            return;
        }
        let (newest, searched_at) = (self.newest, self.searched_at);
        if self.entries.len() > MOST_FRAMES {
            self.forget_most_silent();
        } else if newest >= searched_at.saturating_add(PERIOD) || newest < searched_at {
            self.searched_at = newest;
            let is_silent = |stamp: Time| stamp.saturating_add(SILENCE) < newest;
            let silent = self.later_frames().filter(|(_, is_static, stamp)| !is_static && is_silent(*stamp));
            let silent: Vec<FrameId> = silent.map(|(id, ..)| id).collect();
            if !silent.is_empty() {
                let stays = self.with_parents(self.all_but(&silent));
                self.retain(stays);
            }
        }
    }

    /// The frames after the first [`FRAMES_ALWAYS_KEPT`]: whether they are static, and their newest stamp.
    fn later_frames(&self) -> impl Iterator<Item = (FrameId, bool, Time)> + '_ {
        self.entries.iter().enumerate().skip(FRAMES_ALWAYS_KEPT).map(|(index, entry)| {
            let is_static = matches!(entry.history, Some(History::Static(_)));
            let newest = entry.history.as_ref().and_then(History::newest);
            (FrameId(index as u32), is_static, newest.map_or(Time::ZERO, |newest| newest.stamp))
        })
    }

    /// Forgets later frames until [`LEFT`] are left, or those above them where most of them are needed.
    fn forget_most_silent(&mut self) {
        let mut later: Vec<_> = self.later_frames().collect();
        // Of equally silent ones the older.
        later.sort_by_key(|(id, is_static, stamp)| (*is_static, *stamp, id.0));
        let count = self.entries.len().saturating_sub(LEFT).min(later.len());
        let obsolete: Vec<FrameId> = later.iter().take(count).map(|(id, ..)| *id).collect();
        let alone = self.all_but(&obsolete);
        let with_parents = self.with_parents(alone.clone());
        let is_enough = with_parents.iter().filter(|stays| **stays).count() <= MOST_FRAMES * 3 / 4;
        self.retain(if is_enough { with_parents } else { alone });
    }

    /// For each frame whether it is none of these.
    fn all_but(&self, obsolete: &[FrameId]) -> Vec<bool> {
        let mut stays = vec![true; self.entries.len()];
        for id in obsolete {
            if let Some(stays) = stays.get_mut(id.0 as usize) {
                *stays = false;
            }
        }
        stays
    }

    /// Adds the frames between those that stay and their roots.
    fn with_parents(&self, mut stays: Vec<bool>) -> Vec<bool> {
        let mut next: Vec<usize> = (0..stays.len()).filter(|index| stays.get(*index) == Some(&true)).collect();
        while let Some(index) = next.pop() {
            let history = self.entries.get(index).and_then(|entry| entry.history.as_ref());
            for parent in history.into_iter().flat_map(History::parents) {
                let parent = parent.0 as usize;
                if let Some(stays) = stays.get_mut(parent).filter(|stays| !**stays) {
                    *stays = true;
                    next.push(parent);
                }
            }
        }
        stays
    }

    /// Forgets all other frames, and the transforms that lead to them.
    fn retain(&mut self, stays: Vec<bool>) {
        let before = self.entries.len();
        let mut new_ids: HashMap<FrameId, FrameId> = HashMap::new();
        for (index, stays) in stays.iter().enumerate() {
            if *stays {
                new_ids.insert(FrameId(index as u32), FrameId(new_ids.len() as u32));
            }
        }
        let mut stays = stays.into_iter();
        self.entries.retain(|_| stays.next() == Some(true));
        for entry in &mut self.entries {
            let history = entry.history.take();
            entry.history = history.and_then(|history| history.with_parents(|parent| new_ids.get(&parent).copied()));
        }
        self.ids.retain(|_, id| new_ids.get(id).map(|new| *id = *new).is_some());
        self.ids.shrink_to_fit();
        self.entries.shrink_to_fit();
        self.forgotten += (before - self.entries.len()) as u64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{RawTransform, TransformTree};

    fn insert(tree: &mut TransformTree, parent: &str, child: &str, secs: f64, is_static: bool) {
        let (translation, rotation_xyzw) = ([1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]);
        let transform = RawTransform { parent, child, stamp: Time::from_secs_f64(secs), translation, rotation_xyzw };
        tree.insert(&transform, is_static, "/a").unwrap();
    }

    /// `true` if a frame is placed, up to the common root.
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
