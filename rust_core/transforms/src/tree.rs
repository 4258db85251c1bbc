//! The buffer of all frames, their names and histories. tf2 calls it `BufferCore`.
//!
//! Frame names are interned, so that a lookup hashes its two names once and then walks from frame to
//! parent by index. A name is known from the first stored transform that mentions it, as child or as parent,
//! and is kept, also through [`TransformTree::clear`], unless there are very many (see the module `crowd`). Lookups are
//! in the module `lookup`.

use std::collections::HashMap;
use std::time::Duration;

use crate::crowd::Crowd;
use crate::history::{Admission, History, Sample};
use crate::transform::strip_slash;
use crate::{InsertError, RawTransform, StampedTransform, Time};

/// How long tf2 remembers moving frames by default.
pub const DEFAULT_CACHE_LENGTH: Duration = Duration::from_secs(10);

/// A frame's place among the tree's frames.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) struct FrameId(pub(crate) u32);

#[derive(Clone, Debug)]
pub(crate) struct Frame {
    name: String,
    /// `None` until a transform places the frame in a parent: roots have none.
    pub(crate) history: Option<History>,
}

/// What an accepted transform changed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Inserted {
    /// The tree knows something that it did not know before.
    Stored,
    /// Nothing: the frame was placed exactly there already, at that stamp or for good. Nodes that publish in a loop do
    /// this all the time.
    Repeated,
}

/// The frame tree over time.
///
/// ```
/// use rcs_transforms::{LookupError, RawTransform, Time, TransformTree};
///
/// let mut tree = TransformTree::new();
/// let mount = RawTransform {
///     parent: "base_link",
///     child: "camera",
///     stamp: Time::ZERO,
///     translation: [0.1, 0.0, 0.5],
///     rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
/// };
/// tree.insert(&mount, true, "/robot_state_publisher")?;
/// let base_from_camera = tree.lookup("base_link", "camera", Time::ZERO)?;
/// assert_eq!(base_from_camera.translation.z, 0.5);
/// assert!(matches!(tree.lookup("map", "camera", Time::ZERO), Err(LookupError::Lookup { .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct TransformTree {
    cache_length: Duration,
    pub(crate) frames: Vec<Frame>,
    pub(crate) ids: HashMap<String, FrameId>,
    pub(crate) generation: u64,
    pub(crate) crowd: Crowd,
}

impl Default for TransformTree {
    fn default() -> Self {
        Self::new()
    }
}

impl TransformTree {
    /// An empty tree that remembers [`DEFAULT_CACHE_LENGTH`] of each moving frame.
    pub fn new() -> Self {
        Self::with_cache_length(DEFAULT_CACHE_LENGTH)
    }

    /// An empty tree that remembers `cache_length` of each moving frame, back from the frame's newest sample.
    pub fn with_cache_length(cache_length: Duration) -> Self {
        let (frames, ids, crowd) = (Vec::new(), HashMap::new(), Crowd::default());
        TransformTree { cache_length, frames, ids, generation: 0, crowd }
    }

    /// How long moving frames are remembered.
    pub fn cache_length(&self) -> Duration {
        self.cache_length
    }

    /// Adds what `authority` (a node's name) published, on `/tf_static` if `is_static`.
    ///
    /// Whether a frame is static is decided by the first transform published for it, for good, as in tf2: a
    /// later one from the other topic is a sample like any other, or replaces the static one.
    ///
    /// # Errors
    ///
    /// [`InsertError`] for what tf2 refuses; the tree's transforms are then as before.
    pub fn insert(
        &mut self,
        transform: &RawTransform<'_>,
        is_static: bool,
        authority: &str,
    ) -> Result<Inserted, InsertError> {
        let parent_from_child = transform.check(authority)?;
        let (parent, child) = (strip_slash(transform.parent), strip_slash(transform.child));
        let named = || (authority.to_owned(), parent.to_owned(), child.to_owned());
        let child_id = self.id(child);
        let known = child_id.and_then(|child_id| self.history(child_id));
        match known.map_or(Admission::New, |history| history.admits(transform.stamp, self.cache_length)) {
            Admission::New => {}
            Admission::Known(known) => {
                if known.parent_from_child == parent_from_child && self.name(known.parent) == parent {
                    return Ok(Inserted::Repeated);
                }
                let (authority, parent, child) = named();
                return Err(InsertError::RepeatedData { authority, parent, child, stamp: transform.stamp });
            }
            Admission::TooOld { latest } => {
                let (authority, parent, child) = named();
                return Err(InsertError::OldData { authority, parent, child, stamp: transform.stamp, latest });
            }
        }
        // Names are kept of what is stored, and of nothing else.
        let child_id = child_id.unwrap_or_else(|| self.intern(child));
        let sample = Sample { stamp: transform.stamp, parent: self.intern(parent), parent_from_child };
        let is_new = match self.frames.get_mut(child_id.0 as usize) {
            Some(Frame { history: Some(history), .. }) => history.insert(sample, self.cache_length),
            Some(frame) => {
                frame.history = Some(History::new(sample, is_static));
                true
            }
            None => false,
        };
        if !is_new {
            return Ok(Inserted::Repeated);
        }
        self.generation += 1;
        self.limit_frames(transform.stamp);
        Ok(Inserted::Stored)
    }

    /// Forgets all samples of moving frames. Static frames and all names stay known, as in tf2: static
    /// transforms are published once and would never come back after a jump in time.
    pub fn clear(&mut self) {
        for frame in &mut self.frames {
            if let Some(history) = &mut frame.history {
                history.clear();
            }
        }
        self.generation += 1;
        self.reset_crowd();
    }

    /// A number that grows whenever what the tree knows has changed, so that callers know when a lookup
    /// that failed is worth trying again. Repeated transforms do not count.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// All frames that were ever mentioned and not forgotten, in the order of their first mention.
    pub fn frames(&self) -> impl Iterator<Item = &str> {
        self.frames.iter().map(|frame| frame.name.as_str())
    }

    /// Whether `frame` was ever mentioned, as child or as parent.
    pub fn frame_exists(&self, frame: &str) -> bool {
        self.id(strip_slash(frame)).is_some()
    }

    /// The parent of `frame` at `time` (at zero: in its newest sample). `None` for roots, for unknown
    /// frames and for times that the frame's history does not cover.
    pub fn parent_of(&self, frame: &str, time: Time) -> Option<&str> {
        let (parent, _) = self.history(self.id(strip_slash(frame))?)?.at(time)?;
        Some(self.name(parent))
    }

    /// The newest sample of `frame`, with its parent; its stamp is zero where the frame is static, and so valid at all
    /// times. `None` for roots, for unknown frames and for moving frames without samples.
    pub fn latest(&self, frame: &str) -> Option<StampedTransform> {
        let id = self.id(strip_slash(frame))?;
        let newest = self.history(id)?.newest()?;
        Some(StampedTransform {
            parent: self.name(newest.parent).to_owned(),
            child: self.name(id).to_owned(),
            stamp: newest.stamp,
            parent_from_child: newest.parent_from_child,
        })
    }

    /// The stamp of the newest sample of `frame`, as [`Self::latest`] has it.
    pub fn newest_stamp_of(&self, frame: &str) -> Option<Time> {
        Some(self.history(self.id(strip_slash(frame))?)?.newest()?.stamp)
    }

    fn intern(&mut self, name: &str) -> FrameId {
        if let Some(id) = self.id(name) {
            return id;
        }
        // Four thousand million names do not fit into memory.
        let id = FrameId(self.frames.len() as u32);
        self.frames.push(Frame { name: name.to_owned(), history: None });
        self.ids.insert(name.to_owned(), id);
        id
    }

    /// The frame of that name, which is given without a leading slash.
    pub(crate) fn id(&self, name: &str) -> Option<FrameId> {
        self.ids.get(name).copied()
    }

    pub(crate) fn name(&self, id: FrameId) -> &str {
        self.frames.get(id.0 as usize).map_or("", |frame| &frame.name)
    }

    pub(crate) fn history(&self, id: FrameId) -> Option<&History> {
        self.frames.get(id.0 as usize)?.history.as_ref()
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
        assert_eq!(tree.latest("base").map(|sample| sample.stamp), Some(Time::from_secs_nanos(5, 0)));
        assert!(tree.latest("map").is_none());
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
    fn the_newest_sample_comes_with_its_parent() {
        let mut tree = TransformTree::new();
        tree.insert(&raw("map", "odom", 5, 1.0), false, "/a").unwrap();
        tree.insert(&raw("odom", "laser", 5, 2.0), true, "/a").unwrap();
        let odom = tree.latest("/odom").unwrap();
        assert_eq!((odom.parent.as_str(), odom.child.as_str()), ("map", "odom"));
        assert_eq!(odom.stamp, Time::from_secs_nanos(5, 0));
        assert_eq!(tree.latest("laser").unwrap().stamp, Time::ZERO);
        assert_eq!(tree.latest("map"), None);
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
