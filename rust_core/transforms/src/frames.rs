//! The frames of a tree by name, and a bound on their number.
//!
//! Names are interned: a lookup hashes its two names once and then follows indices. As in tf2, a name is kept for ever.
//! A publisher that makes up names, such as one per detection, would fill memory and slow down everything that goes
//! over all frames, so the tree refuses names above [`MOST_FRAMES`]: none of those that it has may be replaced by one.

use std::collections::HashMap;

use crate::history::History;
use crate::sample::FrameId;

/// Largest number of frames of a tree.
pub const MOST_FRAMES: usize = 5000;

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

    /// `true` if there is room for this number of new names.
    pub(crate) fn has_room_for(&self, count: usize) -> bool {
        self.entries.len() + count <= MOST_FRAMES
    }

    /// Removes all samples of moving frames, for a jump in time.
    pub(crate) fn clear_moving(&mut self) {
        self.entries.iter_mut().filter_map(|entry| entry.history.as_mut()).for_each(History::clear);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{InsertError, InsertProblem, Inserted, RawTransform, Time, TransformTree};

    fn insert(tree: &mut TransformTree, parent: &str, child: &str, secs: f64) -> Result<Inserted, InsertError> {
        let (translation, rotation_xyzw) = ([1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]);
        let transform = RawTransform { parent, child, stamp: Time::from_secs_f64(secs), translation, rotation_xyzw };
        tree.insert(&transform, false, "/detector")
    }

    #[test]
    fn names_above_the_limit_are_refused_and_the_robot_goes_on() {
        let mut tree = TransformTree::new();
        insert(&mut tree, "map", "base", 1.0).unwrap();
        let made_up = |number: usize| format!("box_{number}");
        let refused = |error: InsertError| assert!(matches!(error.problem, InsertProblem::TooManyFrames), "{error}");
        for number in 0..MOST_FRAMES - 3 {
            insert(&mut tree, "base", &made_up(number), 1.0).unwrap();
        }
        // A parent and a child, where there is room for one.
        refused(insert(&mut tree, "arm", "hand", 1.0).unwrap_err());
        assert!(!tree.frame_exists("arm") && !tree.frame_exists("hand"));
        insert(&mut tree, "base", "last", 1.0).unwrap();
        for number in MOST_FRAMES..3 * MOST_FRAMES {
            refused(insert(&mut tree, "base", &made_up(number), 2.0).unwrap_err());
        }
        refused(insert(&mut tree, "new parent", "base", 2.0).unwrap_err());
        assert_eq!(tree.frames().count(), MOST_FRAMES);
        let text = insert(&mut tree, "base", "one more", 2.0).unwrap_err().to_string();
        for part in ["/detector", "[one more]", "5000"] {
            assert!(text.contains(part), "{text}");
        }
        // Those that are known move on.
        for frame in ["base", "last"] {
            insert(&mut tree, "map", frame, 2.0).unwrap();
            assert!(tree.lookup("map", frame, Time::from_secs_f64(2.0)).is_ok());
        }
    }
}
