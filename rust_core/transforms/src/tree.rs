//! The buffer of all frames, their names and histories. tf2 calls it `BufferCore`.
//!
//! A name is known from the first stored transform that mentions it, as child or as parent, and is kept, also through
//! [`TransformTree::clear`]; above [`MOST_FRAMES`](crate::MOST_FRAMES) new ones are refused. Lookups are in the module
//! `lookup`.

use std::time::Duration;

use crate::frames::Frames;
use crate::history::{Admission, History};
use crate::sample::PoseSample;
use crate::transform::{strip_slash, InsertProblem};
use crate::{InsertError, RawTransform, Time};

/// tf2's default cache length of moving frames.
const DEFAULT_CACHE_LENGTH: Duration = Duration::from_secs(10);

/// Effect of an accepted transform.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Inserted {
    /// The tree knows something that it did not know before.
    Stored,
    /// Nothing: the frame was there already, at that stamp or for good. Nodes that publish in a loop do this all the
    /// time.
    Repeated,
}

/// The frame tree over time.
#[derive(Clone, Debug)]
pub struct TransformTree {
    cache_length: Duration,
    pub(crate) frames: Frames,
    generation: u64,
}

impl Default for TransformTree {
    fn default() -> Self {
        Self::new()
    }
}

impl TransformTree {
    /// An empty tree that remembers ten seconds of each moving frame, as tf2 does.
    pub fn new() -> Self {
        Self::with_cache_length(DEFAULT_CACHE_LENGTH)
    }

    /// An empty tree that remembers `cache_length` of each moving frame, back from the frame's newest sample.
    pub fn with_cache_length(cache_length: Duration) -> Self {
        TransformTree { cache_length, frames: Frames::default(), generation: 0 }
    }

    /// How long moving frames are remembered.
    pub(crate) fn cache_length(&self) -> Duration {
        self.cache_length
    }

    /// Adds a transform that `authority` (a node's name) published, on `/tf_static` if `is_static`.
    ///
    /// The first transform of a frame decides for good whether it is static, as in tf2: a later one from the other
    /// topic is a sample like any other, or replaces the static one.
    ///
    /// # Errors
    ///
    /// [`InsertError`] for transforms that tf2 refuses, and for names above [`MOST_FRAMES`](crate::MOST_FRAMES); the
    /// tree is unchanged then.
    pub fn insert(
        &mut self,
        transform: &RawTransform<'_>,
        is_static: bool,
        authority: &str,
    ) -> Result<Inserted, InsertError> {
        let refused = |problem| transform.refused(authority, problem);
        let parent_from_child = transform.check().map_err(refused)?;
        let (parent, child) = (strip_slash(transform.parent), strip_slash(transform.child));
        let stamp = transform.stamp;
        let child_id = self.frames.id(child);
        let known = child_id.and_then(|child_id| self.frames.history(child_id));
        match known.map_or(Admission::New, |history| history.admits(stamp, self.cache_length)) {
            Admission::New => {}
            Admission::Known(known)
                if known.parent_from_child == parent_from_child && self.frames.name(known.parent) == parent =>
            {
                return Ok(Inserted::Repeated);
            }
            Admission::Known(_) => return Err(refused(InsertProblem::Repeated { stamp })),
            Admission::TooOld { latest } => return Err(refused(InsertProblem::TooOld { stamp, latest })),
        }
        // Only names of stored transforms are kept.
        let parent_id = self.frames.id(parent);
        if !self.frames.has_room_for([child_id, parent_id].iter().filter(|id| id.is_none()).count()) {
            return Err(refused(InsertProblem::TooManyFrames));
        }
        let child_id = child_id.unwrap_or_else(|| self.frames.intern(child));
        let parent = parent_id.unwrap_or_else(|| self.frames.intern(parent));
        let sample = PoseSample { stamp, parent, parent_from_child };
        let is_new = match self.frames.history_mut(child_id) {
            Some(Some(history)) => history.insert(sample, self.cache_length),
            Some(empty) => {
                *empty = Some(History::new(sample, is_static));
                true
            }
            None => false,
        };
        if !is_new {
            return Ok(Inserted::Repeated);
        }
        self.generation += 1;
        Ok(Inserted::Stored)
    }

    /// Forgets all samples of moving frames. Static frames and all names stay known, as in tf2: static transforms are
    /// published once and would never come back after a jump in time.
    pub fn clear(&mut self) {
        self.frames.clear_moving();
        self.generation += 1;
    }

    /// Number that grows with every change of the tree, so that callers know when to repeat a failed lookup. Repeated
    /// transforms do not count.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// All frames that were ever mentioned, in the order of their first mention.
    pub fn frames(&self) -> impl Iterator<Item = &str> {
        self.frames.names()
    }

    /// `true` if `frame` was ever mentioned, as child or as parent.
    pub fn frame_exists(&self, frame: &str) -> bool {
        self.frames.id(strip_slash(frame)).is_some()
    }

    /// Parent of `frame` at `time` (at zero: in its newest sample). `None` for roots, for unknown frames and for times
    /// outside the frame's history.
    pub fn parent_of(&self, frame: &str, time: Time) -> Option<&str> {
        let (parent, _) = self.frames.history(self.frames.id(strip_slash(frame))?)?.at(time)?;
        Some(self.frames.name(parent))
    }

    /// Stamp of the newest sample of `frame`; zero where the frame is static. `None` for roots, for unknown frames and
    /// for moving frames without samples.
    pub fn newest_stamp_of(&self, frame: &str) -> Option<Time> {
        Some(self.frames.history(self.frames.id(strip_slash(frame))?)?.newest()?.stamp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raw<'a>(parent: &'a str, child: &'a str, secs: u32, x: f64) -> RawTransform<'a> {
        RawTransform {
            parent,
            child,
            stamp: Time::from_secs_nanos(secs, 0),
            translation: [x, 0.0, 0.0],
            rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
        }
    }

    fn x_of(tree: &TransformTree, target: &str, source: &str, secs: u32) -> Option<f64> {
        let found = tree.lookup(target, source, Time::from_secs_nanos(secs, 0));
        Some(found.ok()?.translation.x)
    }

    #[test]
    fn frames_are_known_by_their_first_mention_with_or_without_a_slash() {
        let mut tree = TransformTree::new();
        tree.insert(&raw("/map", "odom", 5, 1.0), false, "/a").unwrap();
        tree.insert(&raw("odom", "/base", 5, 1.0), false, "/a").unwrap();
        assert_eq!(tree.frames().collect::<Vec<_>>(), ["odom", "map", "base"]);
        assert!(tree.frame_exists("map") && tree.frame_exists("/map"));
        assert!(!tree.frame_exists("") && !tree.frame_exists("//map"));
        assert_eq!(tree.parent_of("/odom", Time::ZERO), Some("map"));
        assert_eq!(tree.parent_of("odom", Time::from_secs_nanos(6, 0)), None);
        assert_eq!(tree.parent_of("map", Time::ZERO), None);
        assert_eq!(tree.newest_stamp_of("/base"), Some(Time::from_secs_nanos(5, 0)));
        assert_eq!(tree.newest_stamp_of("map"), None);
        tree.insert(&raw("odom", "laser", 5, 2.0), true, "/a").unwrap();
        assert_eq!(tree.newest_stamp_of("laser"), Some(Time::ZERO));
    }

    #[test]
    fn the_generation_grows_with_what_is_new_and_with_nothing_else() {
        let mut tree = TransformTree::new();
        let mut last = tree.generation();
        let mut grew = |tree: &TransformTree| {
            let grew = tree.generation() > last;
            last = tree.generation();
            grew
        };
        let moving = raw("map", "odom", 50, 1.0);
        assert_eq!(tree.insert(&moving, false, "/a"), Ok(Inserted::Stored));
        assert!(grew(&tree));
        assert_eq!(tree.insert(&moving, false, "/a"), Ok(Inserted::Repeated));
        assert!(!grew(&tree));
        let fixed = raw("odom", "laser", 50, 1.0);
        assert_eq!(tree.insert(&fixed, true, "/a"), Ok(Inserted::Stored));
        assert!(grew(&tree));
        assert_eq!(tree.insert(&fixed, true, "/a"), Ok(Inserted::Repeated));
        assert!(tree.insert(&raw("map", "odom", 39, 1.0), false, "/a").is_err());
        assert!(!grew(&tree));
        tree.clear();
        assert!(grew(&tree));
    }

    #[test]
    fn data_older_than_the_cache_is_refused_and_the_error_names_all() {
        let mut tree = TransformTree::with_cache_length(Duration::from_secs(2));
        tree.insert(&raw("map", "odom", 50, 1.0), false, "/a").unwrap();
        assert!(tree.insert(&raw("map", "odom", 48, 1.0), false, "/a").is_ok());
        let error = tree.insert(&raw("map", "odom", 47, 1.0), false, "/slam").unwrap_err();
        let text = error.to_string();
        for part in ["/slam", "[map]", "[odom]", "47.000000000", "50.000000000"] {
            assert!(text.contains(part), "{text}");
        }
    }

    #[test]
    fn clearing_forgets_moving_frames_and_keeps_static_ones_and_names() {
        let mut tree = TransformTree::new();
        tree.insert(&raw("map", "odom", 50, 1.0), false, "/a").unwrap();
        tree.insert(&raw("odom", "laser", 50, 2.0), true, "/a").unwrap();
        tree.clear();
        assert_eq!(x_of(&tree, "map", "odom", 0), None);
        assert_eq!(x_of(&tree, "odom", "laser", 3), Some(2.0));
        assert!(tree.frame_exists("map"));
        // Time may now run from the start again.
        tree.insert(&raw("map", "odom", 1, 5.0), false, "/a").unwrap();
        assert_eq!(x_of(&tree, "map", "laser", 1), Some(7.0));
    }

    #[test]
    fn the_first_transform_decides_whether_a_frame_is_static() {
        let mut tree = TransformTree::new();
        tree.insert(&raw("map", "post", 5, 1.0), true, "/a").unwrap();
        tree.insert(&raw("map", "post", 6, 2.0), false, "/a").unwrap();
        assert_eq!(x_of(&tree, "map", "post", 100), Some(2.0));
        tree.insert(&raw("map", "cart", 5, 1.0), false, "/a").unwrap();
        tree.insert(&raw("map", "cart", 6, 3.0), true, "/a").unwrap();
        assert_eq!(x_of(&tree, "map", "cart", 0), Some(3.0));
        assert_eq!(x_of(&tree, "map", "cart", 100), None);
    }

    #[test]
    fn a_refused_or_ignored_transform_leaves_no_frame_behind() {
        let mut tree = TransformTree::new();
        assert!(tree.insert(&raw("map", "odom", 5, f64::NAN), false, "/a").is_err());
        assert_eq!(tree.frames().count(), 0);
        assert_eq!(tree.generation(), 0);
        tree.insert(&raw("map", "odom", 50, 1.0), false, "/a").unwrap();
        assert!(tree.insert(&raw("old_parent", "odom", 5, 1.0), false, "/a").is_err());
        assert!(tree.insert(&raw("other_parent", "odom", 50, 1.0), false, "/a").is_err());
        assert_eq!(tree.frames().collect::<Vec<_>>(), ["odom", "map"]);
    }

    #[test]
    fn another_place_at_a_known_stamp_is_refused_and_the_error_names_all() {
        let mut tree = TransformTree::new();
        for secs in [50, 51, 52] {
            tree.insert(&raw("map", "odom", secs, f64::from(secs)), false, "/a").unwrap();
        }
        for secs in [52, 50, 51] {
            let again = raw("map", "odom", secs, f64::from(secs));
            assert_eq!(tree.insert(&again, false, "/b"), Ok(Inserted::Repeated), "{secs}");
            let other = RawTransform { translation: [9.0, 0.0, 0.0], ..again };
            let text = tree.insert(&other, false, "/b").unwrap_err().to_string();
            for part in ["/b", "[map]", "[odom]", &format!("{secs}.000000000"), "TF_REPEATED_DATA"] {
                assert!(text.contains(part), "{text}");
            }
            assert_eq!(x_of(&tree, "map", "odom", secs), Some(f64::from(secs)));
        }
        tree.insert(&raw("map", "post", 50, 1.0), true, "/a").unwrap();
        assert_eq!(tree.insert(&raw("map", "post", 50, 2.0), true, "/a"), Ok(Inserted::Stored), "static: the newest");
    }
}
